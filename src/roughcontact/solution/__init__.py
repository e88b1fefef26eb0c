"""What a solve returns."""

from roughcontact.solution.contact import ContactSolution
from roughcontact.solution.figures import DEFAULT_AREA, Area, EstimatesArea, Level, Residuals, Status
from roughcontact.solution.origin import Origin

__all__ = ["DEFAULT_AREA", "Area", "ContactSolution", "EstimatesArea", "Level", "Origin", "Residuals", "Status"]
