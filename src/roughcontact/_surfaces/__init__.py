"""Surfaces: heights over a grid, positive outward, towards the other body."""

from roughcontact._surfaces.analytic import FlatSurface, ParaboloidSurface, SphereSurface, WavySurface
from roughcontact._surfaces.base import Surface, SurfaceSum, surfaces
from roughcontact._surfaces.heightmap import HeightMap, Separated
from roughcontact._surfaces.matching import MatchedPair, PlacedMap, match
from roughcontact._surfaces.selfaffine import SelfAffineSurface

__all__ = [
    "FlatSurface",
    "HeightMap",
    "MatchedPair",
    "ParaboloidSurface",
    "PlacedMap",
    "SelfAffineSurface",
    "Separated",
    "SphereSurface",
    "Surface",
    "SurfaceSum",
    "WavySurface",
    "match",
    "surfaces",
]
