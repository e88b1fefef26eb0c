"""The paper this project starts from, recomputed: section 3.1, the wavy surface on a rigid flat."""

from roughcontact.paper.scene import Case, run_case
from roughcontact.paper.tables import Table, all_tables, remarks

__all__ = ["Case", "Table", "all_tables", "remarks", "run_case"]
