"""Laws of an interface: what its contact does, over the load, in a form that other programs read."""

from roughcontact.laws.fits import PowerFit
from roughcontact.laws.law import InterfaceLaw, LawColumn
from roughcontact.laws.run import interface_law

__all__ = ["InterfaceLaw", "LawColumn", "PowerFit", "interface_law"]
