"""Surfaces: heights over a grid, positive outward, towards the other body."""

from roughcontact._parts.surfaces.base import SampledSurface, Surface, SurfaceSum, surfaces
from roughcontact._parts.surfaces.continuation import Continuation, cells_for, find_maps
from roughcontact._parts.surfaces.facts import list_facts, write_facts
from roughcontact._parts.surfaces.filling import MAX_BANDWIDTH, TREATMENTS, complete, fill, solve_in_bands
from roughcontact._parts.surfaces.heightmap import HeightMap, Separated
from roughcontact._parts.surfaces.matching import MatchedPair, PlacedMap, match
from roughcontact._parts.surfaces.resampling import bilinear
from roughcontact._parts.surfaces.statistics import (
    HANN_DEPENDENCE,
    border_jump,
    mean_in_bands,
    polynomial,
    power_spectrum,
    repeats,
    rms_slope,
)
from roughcontact._parts.surfaces.synthetic import (
    FlatSurface,
    ParaboloidSurface,
    SelfAffineSurface,
    SphereSurface,
    WavySurface,
)
from roughcontact._parts.surfaces.topography import read_topography

__all__ = [
    "HANN_DEPENDENCE",
    "MAX_BANDWIDTH",
    "TREATMENTS",
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
    "polynomial",
    "power_spectrum",
    "read_topography",
    "repeats",
    "rms_slope",
    "solve_in_bands",
    "surfaces",
    "write_facts",
]
