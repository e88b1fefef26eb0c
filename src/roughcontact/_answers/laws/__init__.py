"""Laws of an interface: properties of its contact over the load, in a form that other programs read."""

from roughcontact._answers.laws.law import InterfaceLaw, LawColumn, PowerFit
from roughcontact._answers.laws.run import MAX_LOAD_RATIO, interface_law

__all__ = ["MAX_LOAD_RATIO", "InterfaceLaw", "LawColumn", "PowerFit", "interface_law"]
