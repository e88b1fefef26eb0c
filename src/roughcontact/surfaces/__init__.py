"""Surfaces: heights over a grid, positive outward, towards the other body."""

from roughcontact.surfaces.base import Surface
from roughcontact.surfaces.flat import FlatSurface
from roughcontact.surfaces.heightmap import HeightMap, Separated
from roughcontact.surfaces.matching import MatchedPair, match
from roughcontact.surfaces.paraboloid import ParaboloidSurface
from roughcontact.surfaces.placed import PlacedMap
from roughcontact.surfaces.selfaffine import SelfAffineSurface
from roughcontact.surfaces.sphere import SphereSurface
from roughcontact.surfaces.sum import SurfaceSum
from roughcontact.surfaces.wavy import WavySurface

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
]
