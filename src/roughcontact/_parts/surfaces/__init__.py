"""Surfaces: heights over a grid, positive outward, towards the other body."""

from roughcontact._parts.surfaces.analytic import FlatSurface, ParaboloidSurface, SphereSurface, WavySurface
from roughcontact._parts.surfaces.base import Surface, SurfaceSum, surfaces
from roughcontact._parts.surfaces.heightmap import HeightMap, Separated
from roughcontact._parts.surfaces.matching import MatchedPair, PlacedMap, match
from roughcontact._parts.surfaces.selfaffine import SelfAffineSurface

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
