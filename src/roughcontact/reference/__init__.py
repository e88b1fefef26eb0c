"""Closed forms and theories of contact mechanics to compare with; SI units, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""

from roughcontact.reference.adhesion import (
    DmtSphere,
    FullContactEnergies,
    JkrSphere,
    JohnsonWave,
    MaugisSphere,
    full_contact_energies,
    stickiness,
    tabor_parameter,
)
from roughcontact.reference.bearing import BearingCurve, bearing_area
from roughcontact.reference.closed_forms import FlatPunch, Hertz, WavyContact, Westergaard, hertz_elliptic, hertz_sphere
from roughcontact.reference.persson import PerssonContact, persson
from roughcontact.reference.roughness import Roughness, roughness

__all__ = [
    "BearingCurve",
    "DmtSphere",
    "FlatPunch",
    "FullContactEnergies",
    "Hertz",
    "JkrSphere",
    "JohnsonWave",
    "MaugisSphere",
    "PerssonContact",
    "Roughness",
    "WavyContact",
    "Westergaard",
    "bearing_area",
    "full_contact_energies",
    "hertz_elliptic",
    "hertz_sphere",
    "persson",
    "roughness",
    "stickiness",
    "tabor_parameter",
]
