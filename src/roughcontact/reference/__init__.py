"""Closed forms and theories of contact mechanics to compare with; SI units, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""

from roughcontact.reference.adhesion import DMT, JKR, JohnsonWave, MaugisDugdale
from roughcontact.reference.closed_forms import FlatPunch, Hertz, WavyContact, Westergaard, hertz_elliptic, hertz_sphere
from roughcontact.reference.friction import (
    CattaneoMindlin,
    SlidingWave,
    UnlikeCylinder,
    bonded_punch,
    frictional_punch,
)
from roughcontact.reference.profiles import ProfileFit, ProfileStatistics, fit_surface, profile
from roughcontact.reference.roughness import BearingCurve, Roughness, bearing_area, roughness
from roughcontact.reference.sliding import SlidingCylinder, SlidingSphere
from roughcontact.reference.texture import Texture, texture
from roughcontact.reference.theories import (
    FullContactEnergies,
    PastewkaRobbins,
    PerssonContact,
    full_contact_energies,
    persson,
)

__all__ = [
    "DMT",
    "JKR",
    "BearingCurve",
    "CattaneoMindlin",
    "FlatPunch",
    "FullContactEnergies",
    "Hertz",
    "JohnsonWave",
    "MaugisDugdale",
    "PastewkaRobbins",
    "PerssonContact",
    "ProfileFit",
    "ProfileStatistics",
    "Roughness",
    "SlidingCylinder",
    "SlidingSphere",
    "SlidingWave",
    "Texture",
    "UnlikeCylinder",
    "WavyContact",
    "Westergaard",
    "bearing_area",
    "bonded_punch",
    "fit_surface",
    "frictional_punch",
    "full_contact_energies",
    "hertz_elliptic",
    "hertz_sphere",
    "persson",
    "profile",
    "roughness",
    "texture",
]
