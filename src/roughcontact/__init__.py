"""Contact of rough surfaces by the semi-analytical method.

Surfaces and materials in; contact pressure, gap, approach and real contact area out.
"""

from roughcontact.areas import AreaEstimator, Blend, CellCount, Hertz, LevelSet, LevelSetRichardson, Perimeter
from roughcontact.body import RIGID_FLAT, Body
from roughcontact.clusters import Clusters
from roughcontact.convolvers import DCFFT, CircularFFT, Convolver, Direct, PlannedConvolution
from roughcontact.errors import InputError, MissingPackage, NotConverged, RoughContactError
from roughcontact.files import RawMap, SurfaceReader, read_surface, write_solution
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import FourierHalfSpace, InfluenceKernel, Love
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material, Rigid
from roughcontact.plan import Plan
from roughcontact.problem import ContactProblem
from roughcontact.refinement import Ladder, Refined, extrapolate, refine
from roughcontact.registry import areas, convolvers, kernels, readers, solvers
from roughcontact.solution import Area, ContactSolution, Level, Residuals, Status
from roughcontact.solvers import Outcome, PolonskyKeer, ProjectedConjugateGradient, Solver, SpectralGradient, Step, Task
from roughcontact.surfaces import (
    FlatSurface,
    HeightMap,
    ParaboloidSurface,
    SelfAffineSurface,
    SphereSurface,
    Surface,
    WavySurface,
)
from roughcontact.sweep import Sweep

__version__ = "0.1.0"

__all__ = [
    "DCFFT",
    "RIGID_FLAT",
    "Area",
    "AreaEstimator",
    "Blend",
    "Body",
    "Boundary",
    "CellCount",
    "CircularFFT",
    "Clusters",
    "ContactProblem",
    "ContactSolution",
    "Convolver",
    "Direct",
    "Elastic",
    "ElasticPerfectlyPlastic",
    "FlatSurface",
    "FourierHalfSpace",
    "Grid",
    "HeightMap",
    "Hertz",
    "InfluenceKernel",
    "InputError",
    "Ladder",
    "Level",
    "LevelSet",
    "LevelSetRichardson",
    "Love",
    "Material",
    "MissingPackage",
    "NotConverged",
    "Outcome",
    "ParaboloidSurface",
    "Perimeter",
    "Plan",
    "PlannedConvolution",
    "PolonskyKeer",
    "ProjectedConjugateGradient",
    "RawMap",
    "Refined",
    "Residuals",
    "Rigid",
    "RoughContactError",
    "SelfAffineSurface",
    "Solver",
    "SpectralGradient",
    "SphereSurface",
    "Status",
    "Step",
    "Surface",
    "SurfaceReader",
    "Sweep",
    "Task",
    "WavySurface",
    "areas",
    "convolvers",
    "extrapolate",
    "kernels",
    "read_surface",
    "readers",
    "refine",
    "solvers",
    "write_solution",
]
