"""The smallest plug-in of each kind."""

from roughcontact_example.between import Between
from roughcontact_example.foam import Foam
from roughcontact_example.springback import Springback
from roughcontact_example.springs import Springs

__all__ = ["Between", "Foam", "Springback", "Springs"]
