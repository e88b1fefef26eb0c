"""Contact of rough surfaces by the semi-analytical method.

Surfaces and materials in; contact pressure, gap, approach and real contact area out.
"""

import importlib
import inspect
import types

from roughcontact.errors import interrupt as _interrupt  # noqa: F401 - for an interrupt of what follows

# isort: split
from roughcontact import examples as examples
from roughcontact import faces as faces
from roughcontact import plotting as plotting
from roughcontact import responses as _responses
from roughcontact import results as results
from roughcontact import solving as solving
from roughcontact import typing as typing
from roughcontact._answers.areas import (
    AreaEstimator,
    Blend,
    CellCount,
    Hertz,
    LevelSet,
    LevelSetRichardson,
    Perimeter,
    areas,
)
from roughcontact._answers.laws import film_law, interface_law
from roughcontact._answers.refinement import beyond_resolution, extrapolate, on_grid
from roughcontact._base.machine.programs import show_versions
from roughcontact._base.registry import publish
from roughcontact._parts.files import SurfaceReader, read_profile, read_surface, readers
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.interactions import (
    Coulomb,
    Dugdale,
    Exponential,
    FrictionLaw,
    Interaction,
    LimitedCoulomb,
    ShortRange,
    VanDerWaals,
    frictions,
    interactions,
)
from roughcontact._parts.kernels import FourierHalfSpace, InfluenceKernel, Love, kernels
from roughcontact._parts.materials import Elastic, ElasticPerfectlyPlastic, Material, Rigid, Viscoelastic, materials
from roughcontact._parts.surfaces import (
    FlatSurface,
    HeightMap,
    NonGaussianSurface,
    ParaboloidSurface,
    PlacedMap,
    SelfAffineSurface,
    SphereSurface,
    Surface,
    WavySurface,
    match,
    surfaces,
)
from roughcontact._solve.convolvers import DCFFT, CircularFFT, Convolver, Direct, convolvers
from roughcontact._solve.problem import RIGID_FLAT, Body, ContactProblem, FrictionalPath, load
from roughcontact._solve.solution import (
    Archard,
    Area,
    ContactSolution,
    CoupledProcess,
    EnergyWear,
    Estimate,
    Flattening,
    FlatteningModel,
    Law,
    Overlap,
    Process,
    Relaxation,
    Response,
    SolutionWriter,
    Status,
    SteadySliding,
    UniformRise,
    flattening_models,
    laws,
    responses,
    writers,
)
from roughcontact._solve.solvers import (
    GapDescent,
    Majorise,
    PolonskyKeer,
    ProjectedConjugateGradient,
    Solver,
    SpectralGradient,
    solvers,
)
from roughcontact._work.processes import run_in
from roughcontact._work.reports import cite, error_vs_time, stability
from roughcontact._work.studies import Study
from roughcontact.errors import (
    ContactWarning,
    FileError,
    InputError,
    MissingPackage,
    NotConverged,
    OutOfMemory,
    RoughContactError,
    StudyStopped,
    UnexpectedError,
)
from roughcontact.errors.door import guarded
from roughcontact.plotting import Panel, panels

__version__ = "0.1.0"

_MODULES = (
    "errors", "examples", "extrapolation", "faces", "plotting", "reference", "results", "slabs",
    "solving", "testing", "typing",
)  # fmt: skip

__all__ = [
    "DCFFT",
    "RIGID_FLAT",
    "Archard",
    "Area",
    "AreaEstimator",
    "Blend",
    "Body",
    "Boundary",
    "CellCount",
    "CircularFFT",
    "ContactProblem",
    "ContactSolution",
    "ContactWarning",
    "Convolver",
    "Coulomb",
    "CoupledProcess",
    "Direct",
    "Dugdale",
    "Elastic",
    "ElasticPerfectlyPlastic",
    "EnergyWear",
    "Estimate",
    "Exponential",
    "FileError",
    "FlatSurface",
    "Flattening",
    "FlatteningModel",
    "FourierHalfSpace",
    "FrictionLaw",
    "FrictionalPath",
    "GapDescent",
    "Grid",
    "HeightMap",
    "Hertz",
    "InfluenceKernel",
    "InputError",
    "Interaction",
    "Law",
    "LevelSet",
    "LevelSetRichardson",
    "LimitedCoulomb",
    "Love",
    "Majorise",
    "Material",
    "MissingPackage",
    "NonGaussianSurface",
    "NotConverged",
    "OutOfMemory",
    "Overlap",
    "Panel",
    "ParaboloidSurface",
    "Perimeter",
    "PlacedMap",
    "PolonskyKeer",
    "Process",
    "ProjectedConjugateGradient",
    "Relaxation",
    "Response",
    "Rigid",
    "RoughContactError",
    "SelfAffineSurface",
    "ShortRange",
    "SolutionWriter",
    "Solver",
    "SpectralGradient",
    "SphereSurface",
    "Status",
    "SteadySliding",
    "Study",
    "StudyStopped",
    "Surface",
    "SurfaceReader",
    "UnexpectedError",
    "UniformRise",
    "VanDerWaals",
    "Viscoelastic",
    "WavySurface",
    "areas",
    "beyond_resolution",
    "cite",
    "convolvers",
    "error_vs_time",
    "extrapolate",
    "film_law",
    "flattening_models",
    "frictions",
    "interactions",
    "interface_law",
    "kernels",
    "laws",
    "load",
    "match",
    "materials",
    "on_grid",
    "panels",
    "read_profile",
    "read_surface",
    "readers",
    "responses",
    "run_in",
    "show_versions",
    "solvers",
    "stability",
    "surfaces",
    "writers",
]


# Classes that scripts seldom type: bases of plug-ins, parts that are chosen by their registered names, results, errors.
_SELDOM_TYPED = frozenset({
    "Area", "AreaEstimator", "Blend", "Boundary", "CellCount", "CircularFFT", "ContactWarning", "Convolver",
    "CoupledProcess", "DCFFT",
    "Direct", "Estimate", "FileError", "FlatteningModel", "FourierHalfSpace", "FrictionLaw", "FrictionalPath",
    "GapDescent", "Hertz",
    "InfluenceKernel", "InputError", "Interaction", "Majorise",
    "Law", "LevelSet", "LevelSetRichardson", "Love", "Material", "MissingPackage", "NotConverged", "OutOfMemory",
    "Overlap", "Panel", "Perimeter", "PolonskyKeer", "Process", "ProjectedConjugateGradient",
    "Response", "RoughContactError", "SolutionWriter", "Solver", "SpectralGradient", "Status", "StudyStopped",
    "Surface", "SurfaceReader", "UnexpectedError", "UniformRise",
})  # fmt: skip


def __getattr__(name: str) -> object:
    """Import a module at its first use: what plug-ins must do, and slabs of processes, are seldom asked."""
    if name in ("slabs", "testing"):
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return what scripts type, for the completion of names; all of `__all__` is there."""
    return [*(name for name in __all__ if name not in _SELDOM_TYPED), *_MODULES, "__version__"]


# The public functions are guarded where they are defined; a registry and RIGID_FLAT, by their classes.
for _public in (
    *(globals()[name] for name in __all__),
    *(getattr(module, name) for module in (faces, _responses, results, solving, typing) for name in module.__all__),
):
    if not inspect.isfunction(_public):
        guarded(_public if isinstance(_public, type) else type(_public))
for _name in __all__:
    if isinstance(globals()[_name], (type, types.FunctionType)):
        publish(globals()[_name], __name__)
del _name, _public, _responses
