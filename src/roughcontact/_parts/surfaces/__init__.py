"""Surfaces: heights over a grid, positive outward, towards the other body."""

from roughcontact._parts.surfaces.analytic import FlatSurface, ParaboloidSurface, SphereSurface, WavySurface
from roughcontact._parts.surfaces.base import Surface, SurfaceSum, surfaces
from roughcontact._parts.surfaces.continuation import Continuation, cells_for, find_maps
from roughcontact._parts.surfaces.filling import TREATMENTS, WIDEST, complete, fill, solve_in_bands
from roughcontact._parts.surfaces.heightmap import HeightMap, Separated
from roughcontact._parts.surfaces.matching import MatchedPair, PlacedMap, match
from roughcontact._parts.surfaces.resampling import bilinear
from roughcontact._parts.surfaces.sampled import SampledSurface
from roughcontact._parts.surfaces.selfaffine import SelfAffineSurface
from roughcontact._parts.surfaces.spectrum import mean_in_bands, power_spectrum
from roughcontact._parts.surfaces.statistics import border_jump, repeats, rms_slope
from roughcontact._parts.surfaces.summary import list_facts
from roughcontact._parts.surfaces.topography import read_topography

__all__ = [
    "TREATMENTS",
    "WIDEST",
    "Continuation",
    "FlatSurface",
    "HeightMap",
    "MatchedPair",
    "ParaboloidSurface",
    "PlacedMap",
    "SampledSurface",
    "SelfAffineSurface",
    "Separated",
    "SphereSurface",
    "Surface",
    "SurfaceSum",
    "WavySurface",
    "bilinear",
    "border_jump",
    "cells_for",
    "complete",
    "fill",
    "find_maps",
    "list_facts",
    "match",
    "mean_in_bands",
    "power_spectrum",
    "read_topography",
    "repeats",
    "rms_slope",
    "solve_in_bands",
    "surfaces",
]
