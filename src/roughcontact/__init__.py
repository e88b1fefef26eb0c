"""Contact of rough surfaces by the semi-analytical method.

Surfaces and materials in; contact pressure, gap, approach and real contact area out.
"""

from roughcontact.areas import AreaEstimator, Blend, CellCount, Hertz, LevelSet, LevelSetRichardson, Perimeter
from roughcontact.body import RIGID_FLAT, Body
from roughcontact.clusters import Clusters
from roughcontact.convolvers import DCFFT, CircularFFT, Convolver, Direct, PlannedConvolution
from roughcontact.errors import InputError, MissingPackage, NotConverged, RoughContactError, StudyStopped
from roughcontact.files import RawMap, SurfaceReader, read_surface
from roughcontact.flattening import Overlap, PermanentSet, UniformRise
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import FourierHalfSpace, InfluenceKernel, Love
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material, Rigid
from roughcontact.plan import Plan
from roughcontact.problem import ContactProblem
from roughcontact.refinement import Ladder, Refined, extrapolate, refine
from roughcontact.registry import areas, convolvers, kernels, materials, readers, sets, solvers, surfaces
from roughcontact.report import ErrorReport, ReportRow, Timing, Truth, error_vs_time
from roughcontact.running_in import Cycle, RunIn, run_in
from roughcontact.solution import Area, ContactSolution, Level, Origin, Residuals, Status
from roughcontact.solvers import Outcome, PolonskyKeer, ProjectedConjugateGradient, Solver, SpectralGradient, Step, Task
from roughcontact.stability import Check, Gallery, GalleryRow, StabilityReport, Verdict, stability, stability_gallery
from roughcontact.studies import Record, Study, StudyResult
from roughcontact.surfaces import (
    FlatSurface,
    HeightMap,
    MatchedPair,
    ParaboloidSurface,
    PlacedMap,
    SelfAffineSurface,
    Separated,
    SphereSurface,
    Surface,
    WavySurface,
    match,
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
    "Check",
    "CircularFFT",
    "Clusters",
    "ContactProblem",
    "ContactSolution",
    "Convolver",
    "Cycle",
    "Direct",
    "Elastic",
    "ElasticPerfectlyPlastic",
    "ErrorReport",
    "FlatSurface",
    "FourierHalfSpace",
    "Gallery",
    "GalleryRow",
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
    "MatchedPair",
    "Material",
    "MissingPackage",
    "NotConverged",
    "Origin",
    "Outcome",
    "Overlap",
    "ParaboloidSurface",
    "Perimeter",
    "PermanentSet",
    "PlacedMap",
    "Plan",
    "PlannedConvolution",
    "PolonskyKeer",
    "ProjectedConjugateGradient",
    "RawMap",
    "Record",
    "Refined",
    "ReportRow",
    "Residuals",
    "Rigid",
    "RoughContactError",
    "RunIn",
    "SelfAffineSurface",
    "Separated",
    "Solver",
    "SpectralGradient",
    "SphereSurface",
    "StabilityReport",
    "Status",
    "Step",
    "Study",
    "StudyResult",
    "StudyStopped",
    "Surface",
    "SurfaceReader",
    "Sweep",
    "Task",
    "Timing",
    "Truth",
    "UniformRise",
    "Verdict",
    "WavySurface",
    "areas",
    "convolvers",
    "error_vs_time",
    "extrapolate",
    "kernels",
    "match",
    "materials",
    "read_surface",
    "readers",
    "refine",
    "run_in",
    "sets",
    "solvers",
    "stability",
    "stability_gallery",
    "surfaces",
]
