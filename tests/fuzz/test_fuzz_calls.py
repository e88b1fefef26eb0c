"""Calls of the public API with bad values: each ends in a finite answer or in one sentence.

The calls are made from the signatures of what is public: every argument that is needed gets a good value, one or two
get a bad one. Nothing else may come out: no other error, no warning, no value that is not finite, no endless call.
"""

from __future__ import annotations

import inspect
import io
import math
import random
import signal
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from decimal import Decimal
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
import pytest
from matplotlib import pyplot

import roughcontact as rc
from roughcontact import extrapolation, faces, reference, results, slabs, solving
from roughcontact import typing as types_of_rc

# Calls of the long run, and of one block of it.
CALLS, BLOCK = 5_000, 500
# Calls of the ordinary run.
FEW = 1_000
# Memory that the calls may take beyond what is held before, bytes; seconds after which a call counts as endless.
MEMORY, ENDLESS = 2**31, 60
# Characters of a sentence.
LONGEST = 600

HAS_TOPOGRAPHY = find_spec("SurfaceTopography") is not None
# Calls that need a package which is not installed: the seeds draw among all, so that each means the same everywhere.
ABSENT = set() if HAS_TOPOGRAPHY else {"HeightMap.from_topography"}
GRID = rc.Grid((8, 8), 1e-3)
WAVE = rc.WavySurface(1e-6, 1e-3)
STEEL = rc.Elastic(210e9, 0.3)
HARD = rc.ElasticPerfectlyPlastic(210e9, 0.3, 1e9)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3e-4, longest=1e-3)
LINES = 1e-8 * np.random.default_rng(0).standard_normal((5, 512)).cumsum(axis=1)
MAP = rc.HeightMap(ROUGH.heights(GRID), size=1e-3, periodic=True)
PROBLEM = rc.ContactProblem(rc.Body(ROUGH, STEEL), grid=GRID, boundary="periodic")
MAPPED = rc.ContactProblem(
    rc.Body(rc.HeightMap(ROUGH.heights(rc.Grid((32, 32), 1e-3)), 1e-3), STEEL), boundary="periodic"
)
LIMITED = rc.ContactProblem(rc.Body(ROUGH, HARD), grid=GRID)
SOLUTION = PROBLEM.solve(pressure=1e8)
SWEEP = LIMITED.sweep(pressure=[1e7, 2e7])
STUDY = rc.Study(problems=PROBLEM, pressure=[1e7])
TASK = types_of_rc.Task(initial_gap=MAP.heights(GRID) - MAP.heights(GRID).min(), mean_pressure=0.1)
PLAN = PROBLEM.plan
OUTCOME = types_of_rc.Outcome(
    pressure=TASK.initial_gap * 0.1, status=rc.Status.CONVERGED, iterations=1, convolutions=1, errors=()
)
LAW = rc.interface_law(PROBLEM, [1e7, 2e7], ["stiffness", rc.responses.create("conductance", 50.0)])
FILM = rc.film_law(PROBLEM, [1.0, 3.0], sampling=False)
BOUND = types_of_rc.BoundKernel(rc.Love())

# Methods that parts call on each other: any error of roughcontact will do, and what they return is not judged.
INNER = ("Love", "FourierHalfSpace", "DCFFT", "CircularFFT", "Direct", "project_to_load", "rescale_to_load")
INNER += ("nearest_pressure", "starting_pressure", "PolonskyKeer.solve", "ProjectedConjugateGradient.solve")
INNER += ("SpectralGradient.solve", "natural_residual", "make_task", "confirm")
INNER += ("find_patches", "solve_on_cells", "estimate_approach", "map_tiles", "require_memory")

# A good value for each argument that has no default, by its name; the loads are given as pressures.
GOOD = {
    "amplitude": 1e-6, "approach": 1e-7, "area": "blend", "body": rc.Body(WAVE, STEEL),
    "boundary": rc.Boundary.PERIODIC,
    "cells": (4, 8, 16), "choice": "blend", "cls": rc.Blend, "compliance": 1e-9, "contact_fraction": 0.5,
    "convolution": PROBLEM.convolution, "convolutions": 3, "convolver": rc.CircularFFT(), "count": 1,
    "counterbody": rc.RIGID_FLAT, "displacement": SOLUTION.displacement, "estimator": "blend",
    "field": SOLUTION.pressure, "plan": PLAN, "outcome": OUTCOME, "unit": "Pa",
    "folder": "study", "force": 1.0, "fraction": 0.3, "grid": GRID, "hardness": 1e9, "heights": MAP.heights(GRID),
    "history": (0.1,), "hurst": 0.8, "increment": 1, "initial_gap": SOLUTION.initial_gap, "iterations": 3,
    "kernel": rc.Love(), "kind": "pressure", "levels": [0.0, 1e-7],
    "fractions": [0.5, 0.1], "uncertainties": [0.1, 0.1], "load": 0.1, "longest": 1e-3, "material": STEEL, "mean": 0.1,
    "model": rc.Overlap(), "modulus": 1e9, "name": "blend", "other": GRID, "p_max": 1e9, "parts": (), "path": "x.npz",
    "periodic": True,
    "poisson": 0.3, "pressure": 1e8, "pressure_limit": math.inf, "problem": PROBLEM,
    "problems": PROBLEM, "qx": np.ones((8, 1)), "qy": np.ones((1, 8)), "radii": (1e-3, 2e-3), "radius": 1e-2,
    "reader": "auto", "residuals": SOLUTION.residuals, "seconds": 0.1, "semi_axes": (1e-4, 1e-4), "shape": (8, 8),
    "shortest": 3e-4, "size": 1e-3, "solution": SOLUTION, "source": MAP, "spacing": (1e-4, 1e-4),
    "quantity": "peak-pressure",
    "status": rc.Status.CONVERGED, "surface": WAVE, "task": TASK, "tolerance": 1e-6, "values": SOLUTION.pressure,
    "wavelength": 1e-3, "wavenumber": 1e4, "yield_stress": 1e9, "conductivity": 50.0, "viscosity": 1e-3,
    "pressure_drop": 1e5, "of": "participation", "tangential_force": 1.0, "friction": 0.2, "response": "stress",
    "alpha": 0.3, "contact_radius": 1e-4, "half_width": 1e-4,
    "work": 0.05, "range": 2e-8, "strength": 1e6, "gap": np.full((8, 8), 1e-8),
    "interaction": rc.Exponential(0.05, 2e-8), "rms_slope": 0.1, "rms_curvature": 1e5,
    "coefficient": 0.2, "compliance_ratio": 1.2, "beta": 0.3, "friction_over_beta": 0.6,
    "component": "xy", "pair": types_of_rc.PairConstants(0.1, 0.4),
    "table": {"body": rc.Body(WAVE, STEEL), "grid": GRID},
    "moduli": (1e6, 1e6), "times": (0.1,), "time": 1.0, "frequency": 1.0, "storage": (1.0, 1.1), "loss": (0.1, 0.1),
    "speed": 1.0, "diffusivity": 1e-5,
    "tip_radius": 1e-4, "index": 0, "topography": MAP.to_topography() if HAS_TOPOGRAPHY else None, "young": 1e9,
}  # fmt: skip
# ... where the same name means something else.
GOOD_FOR = {
    "SphereSurface.plot": {"grid": GRID, "panel": "map"}, "ContactSolution.plot": {"panel": "patch-sizes"},
    "Estimate": {"value": 1.0, "uncertainty": 0.1, "unit": "m"}, "Estimate.__add__": {"other": 1.0},
    "cite": {"style": "bibtex"},
    "DCFFT.prepare": {"kernel": BOUND, "boundary": rc.Boundary.FREE},
    "CircularFFT.prepare": {"kernel": BOUND},
    "Direct.prepare": {"kernel": BOUND, "boundary": rc.Boundary.FREE},
    "DCFFT.require": {"boundary": rc.Boundary.FREE},
    "from_master_curve": {"frequency": (1.0, 10.0)},
    "map_tiles": {"work": len, "tiles": [[1.0], [2.0]]},
    "require_memory": {"needed": 1e3, "what": "It", "advice": "take fewer cells"},
    "ContactProblem": {"grid": GRID}, "read_surface": {"path": "map.npz"},
    "read_profile": {"path": "line.npy", "spacing": 1e-6}, "profile": {"lines": LINES, "spacing": 1e-6},
    "fit_surface": {"lines": LINES, "spacing": 1e-6, "shortest": 8e-6},
    "read_raw": {"file": "map.npz"},
    "run_in": {"problem": LIMITED, "pressure": 1e7}, "ContactSolution.load": {"path": "solution.npz"},
    "Sweep.load": {"path": "sweep.npz"}, "Sweep.animate": {"path": "x.gif"},
    "load": {"path": "solution.npz"},
    "Direct.require": {"boundary": rc.Boundary.FREE}, "limited.verify": {"solution": SWEEP.states[0]},
    "SelfAffineSurface": {"rms_slope": 0.1}, "NonGaussianSurface": {"rms_slope": 0.1},
    "HeightMap.filtered": {"shortest": 5e-4},
    "interface_law": {"pressure": [1e7, 2e7], "responses": ()}, "fit": {"name": "area"},
    "InterfaceLaw.__getitem__": {"name": "area"}, "FilmLaw.__getitem__": {"name": "area"},
    "film_law": {"separation": [1.0, 3.0]}, "plan_film": {"separation": [1.0, 3.0]},
    "space_separations": {"first": 0.5, "last": 4.0}, "FilmLaw.fit": {"model": "patir-cheng"},
    "FilmLaw.to_text": {"path": "p.txt", "column": "area"}, "to_moose": {"path": "m.csv"},
    "exponential": {"values": (1.0, 1.1, 1.12)}, "power_law": {"values": (1.0, 1.1, 1.12)},
    "richardson": {"values": (1.0, 1.1, 1.12)},
    "pair_constants": {"one": STEEL, "other": HARD}, "match": {"body": MAP, "counterbody": MAP},
    "beyond_resolution": {"problem": MAPPED, "cutoffs": (2.0,), "realizations": 2, "resolved": 8e-5},
    "kernels.create": {"name": "love"}, "kernels.__getitem__": {"name": "love"}, "kernels.resolve": {"choice": "love"},
    "kernels.name_of": {"cls": rc.Love},
    "ContactProblem.path": {"tangential_force": (0.01, 0.0), "pressure": 1e8, "friction": 0.2},
    "limited.path": {"tangential_force": (0.0, 0.0), "pressure": 1e4, "friction": 0.2},
    "limited.slide": {"pressure": 1e4, "friction": 0.3},
    "ContactProblem.slide": {"pressure": 1e8, "friction": 0.3},
    "ContactProblem.solve_for": {"response": rc.CellCount(), "value": "30%"},
    "limited.solve_for": {"response": rc.CellCount(), "value": "30%"},
    "Study": {"pressure": [1e7]}, "sweep": {"pressure": [1e7, 2e7]},
    "SurfaceSum.with_parts": {"parts": (WAVE, WAVE)},
    "effective_modulus": {"wavenumber": np.array([1e3, 1e4])},
    "directional_modulus": {"angle": np.array([0.0, 1.0])},
    "natural_residual": {"shear": np.zeros((2, 8)), "slip": np.zeros((2, 8)), "limit": np.ones(8), "own": 1.0},
    "nearest_pressure": {"values": TASK.initial_gap}, "make_task": {"load": types_of_rc.Load("pressure", 1e8)},
    "rescale_to_load": {"pressure": np.ones((8, 8))},
    "halve_shape": {"shape": (128, 45)}, "count_blocks": {"stiffness": np.arange(65.0), "count": 128, "mean": 1.0},
    "find_patches": {"contact": SOLUTION.contact, "pressure": SOLUTION.pressure},
    "solve_on_cells": {
        "operator": PROBLEM.convolution, "inverse": PROBLEM.convolution.inverse(np.float32), "unit": 1e-9,
        "cells": SOLUTION.contact, "right": np.ones(GRID.shape), "tolerance": 1e-2, "rigid": False,
    },
}  # fmt: skip
LOADED = ("solve", "require_load", "error_vs_time", "extrapolate", "run_in", "stability", "beyond_resolution")


class Raising:
    """A value each of whose conversions fails."""

    def fail(self, *_):
        raise RuntimeError("this value fails")

    __float__ = __int__ = __index__ = __array__ = __iter__ = __len__ = __repr__ = __fspath__ = __eq__ = fail
    __hash__ = object.__hash__


class Text(str):
    __slots__ = ()


class ForeignQuantity:
    """What seems to have a unit, but converts to none."""

    def to(self, other):
        raise KeyError(other)

    to_base_units = to


class ForeignArray:
    """What seems to have named axes, but no numbers."""

    dims = ("x", "y")
    ndim = 2
    shape = (8, 8)
    coords: ClassVar = {}
    attrs: ClassVar = {"units": 3}
    name = data = None


class Failing(rc.Surface):
    def heights(self, grid):
        raise ZeroDivisionError("this surface fails")


class WrongKernel(rc.InfluenceKernel):
    def coefficients(self):
        return 1.0

    def spectrum(self, qx):
        return qx


class WrongEstimator(rc.AreaEstimator):
    def estimate(self):
        return 1.0


def closed_file():
    file = io.BytesIO(b"12")
    file.close()
    return file


def deep():
    value = []
    for _ in range(5_000):
        value = [value]
    return value


def itself():
    value = [1.0]
    value.append(value)
    return value


def closed_pool():
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    return pool


# Each bad value is made anew.
BAD = {
    name: (lambda value=value: value)
    for name, value in {
        "None": None, "true": True, "ellipsis": ..., "0": 0, "-1": -1, "2": 2, "0.0": 0.0, "-1.0": -1.0,
        "nan": math.nan,
        "inf": math.inf, "-inf": -math.inf, "1e308": 1e308, "-1e308": -1e308, "1e-320": 1e-320, "1e-200": 1e-200,
        "1e200": 1e200, "1e30": 1e30, "1e-30": 1e-30, "1j": 1j, "2**31": 2**31, "10**30": 10**30, "10**400": 10**400,
        "-10**400": -(10**400), "decimal nan": Decimal("NaN"), "signalling nan": Decimal("sNaN"),
        "decimal": Decimal("1e500"), "fraction": Fraction(1, 3), "numpy float32": np.float32(1e38),
        "numpy nan": np.float64("nan"), "numpy int8": np.int8(-1), "numpy bool": np.True_,
        "numpy time": np.datetime64("NaT", "s"), "numpy text": np.str_("5"), "bytes": b"5", "text of a number": "5",
        "text": "no such name", "empty": "", "nul": "a\0b", "surrogate": "\udcff", "long text": "x" * 5_000, "dot": ".",
        "own text": Text("5"), "masked": np.ma.masked, "array 0-d": np.array(1.0), "array 0-d nan": np.array(math.nan),
        "array 0-d text": np.array("5"), "array of one": np.array([1.0]), "array empty": np.zeros(0),
        "array empty 2-d": np.zeros((0, 8)), "array of masked": np.ma.masked_array(np.ones((8, 8)), np.eye(8)),
        "array of two masked": np.ma.masked_array([1.0, 2.0], [True, False]), "array of bool": np.ones((8, 8), bool),
        "array of two bool": np.array([True, False]), "array of text": np.full((8, 8), "5"),
        "array of bytes": np.full((8, 8), b"5"), "array of objects": np.full((8, 8), None),
        "array of complex": np.ones((8, 8), complex), "array of nan": np.full((8, 8), math.nan),
        "array of inf": np.full((8, 8), math.inf), "array of 1e308": np.eye(8) * 1e308,
        "array of 1e-320": np.eye(8) * 1e-320, "array of 1e200": np.eye(8) * 1e200, "array of zeros": np.zeros((8, 8)),
        "array of -1": -np.eye(8), "array of int": np.eye(8, dtype=int), "array 3-d": np.zeros((8, 8, 8)),
        "array of times": np.full((8, 8), np.datetime64("NaT", "s")), "array of records": np.zeros(8, "f8,i4"),
        "list empty": [], "list of text": ["5", "6"], "list of None": [None, None], "list of bool": [True, False],
        "list ragged": [[1.0], [1.0, 2.0]], "list of nan": [math.nan, 1.0], "list of -1": [-1, -1], "pair": (1.0, 2.0),
        "pair of int": (3, 5), "pair of huge": (10**30, 10**30), "pair of large": (2**20, 2**20),
        "pair of 1e308": (1e308, 1e308), "pair of 1e-320": (1e-320, 1e-320), "triple": (1.0, 2.0, 3.0),
        "list of names": ["love", "nope"], "file of a map": "map.npz",
        "file of a solution": "solution.npz", "empty dict": {}, "dict": {1: 2}, "dict of text": {"a": "b"},
        "set": {1.0, 2.0},
        "range": range(3), "object": object(), "class": rc.Love, "type": type, "module": math, "error": ValueError("x"),
        "function": len, "lambda": lambda: None, "lambda of one": lambda x: x, "slice": slice(None), "folder": ".",
        "path": Path("no/folder/x.npz"), "path with nul": Path("a\0b"), "path in a file": "/dev/null/x.npz",
        "grid": GRID, "grid large": rc.Grid((9, 8), 1e6), "surface": WAVE, "steel": STEEL, "rigid": rc.Rigid(),
        "problem": PROBLEM, "limited": LIMITED, "solution": SOLUTION, "free": rc.Boundary.FREE, "wrapped": "wrapped",
        "kernel": rc.FourierHalfSpace(), "paper solver": rc.PolonskyKeer(), "estimator": rc.Perimeter(), "map": MAP,
        "failing surface": Failing(), "failing body": rc.Body(Failing(), STEEL), "wrong kernel": WrongKernel(),
        "wrong estimator": WrongEstimator(), "hard": HARD,
        "quantity": ForeignQuantity(), "array with axes": ForeignArray(),
    }.items()
}  # fmt: skip
BAD |= {
    "raising": Raising, "generator": lambda: (x for x in "ab"), "numbers once": lambda: iter([1.0, 2.0]),
    "closed file": closed_file, "deep list": deep, "list of itself": itself, "closed pool": closed_pool,
    "bytearray": lambda: bytearray(b"5"),
}  # fmt: skip

# Results, which users do not make; enumerations; what has no arguments.
SKIPPED = {"Area", "ContactSolution", "FrictionalPath", "Boundary", "Status", "reference.Hertz"}
# Results again; a figure for each call would be too many.
SKIPPED |= {
    "reference.PerssonContact",
    "reference.Roughness",
    "reference.ProfileFit",
    "reference.ProfileStatistics",
    "reference.Texture",
    "reference.FullContactEnergies",
    "InterfaceLaw.plot",
    "FilmLaw.plot",
}
SKIPPED |= {
    f"{name}.plot" for name in ("WavySurface", "SelfAffineSurface", "HeightMap", "SurfaceSum", "PlacedMap", "Sweep")
}
# Functions for commands and pages, which pass what they have made; one limits the memory of this process.
SKIPPED |= {"si", "binary", "write_column", "available_memory", "available_threads", "limit_address_space"}
SKIPPED |= {"require_memory_of_solve", "run_sweep", "name_load", "list_quantities", "gather_warnings", "exceeds_metals"}
SKIPPED |= {"describe_other_places", "explain_loads", "prepare_path", "summarize"}
SKIPPED |= {
    "describe_response",
    "find_parts",
    "build_layer",
    "build_part",
    "build_response",
    "ask_states",
    "tabulate_answers",
    "write_report",
}
SKIPPED |= {"list_answer_warnings"}
# Plug-ins call them with processes, plans and classes of their own.
SKIPPED |= {"solve_in_window", "make_solution", "require_certified", "gather_slabs"}
SKIPPED |= {"make_random_rows", "symbol_of_columns", "multiply_on_slabs", "stiffness_on_slabs", "long_waves_on_slabs"}
# Python's own, of each sequence.
SKIPPED |= {"Sweep.index", "Sweep.count", "Sweep.__contains__"}
# Rows and columns for which convolvers and processes ask.
SKIPPED |= {"SelfAffineSurface.half_spectrum", "Love.coefficients_from"}
# Views by pyvista, which takes 560 MB: tests/faces/test_bridges.py has them.
SKIPPED |= {f"{name}.plot_3d" for name in ("WavySurface", "SelfAffineSurface", "HeightMap", "SurfaceSum", "PlacedMap")}
SKIPPED |= {"SphereSurface.plot_3d", "ContactSolution.plot_3d"}
# It has no coefficients, which it says.
SKIPPED |= {"FourierHalfSpace.shear_coefficients"}
# For surfaces that attract each other: tests/adhesion/test_adhesion.py has them.
SKIPPED |= {"ContactProblem.cycle", "limited.cycle", "ContactProblem.require_cycle", "limited.require_cycle"}
SKIPPED |= {"ContactSolution.attractive_area", "AdhesionCycle"}
OBJECTS = {
    "Grid": GRID, "WavySurface": WAVE, "SelfAffineSurface": ROUGH, "HeightMap": MAP, "SurfaceSum": WAVE + WAVE,
    "Body": rc.Body(WAVE, STEEL), "ContactProblem": PROBLEM, "limited": LIMITED, "SolvePlan": PLAN, "Sweep": SWEEP,
    "ContactSolution": SOLUTION, "ContactPatches": SOLUTION.patches, "Study": STUDY, "areas": rc.areas,
    "Stress": SOLUTION.stress(),
    "kernels": rc.kernels, "Love": rc.Love(), "FourierHalfSpace": rc.FourierHalfSpace(), "DCFFT": rc.DCFFT(),
    "CircularFFT": rc.CircularFFT(), "Direct": rc.Direct(), "PolonskyKeer": rc.PolonskyKeer(),
    "ProjectedConjugateGradient": rc.ProjectedConjugateGradient(), "SpectralGradient": rc.SpectralGradient(),
    "Blend": rc.Blend(), "LevelSet": rc.LevelSet(), "Overlap": rc.Overlap(), "UniformRise": rc.UniformRise(),
    "PlacedMap": rc.PlacedMap(MAP), "Estimate": rc.Estimate(1.0, 0.1, "m"),
    "InterfaceLaw": LAW, "FilmLaw": FILM, "SphereSurface": rc.SphereSurface(1.0),
}  # fmt: skip


def is_made(value):
    return inspect.isclass(value) and value.__module__.startswith("roughcontact") and not inspect.isabstract(value)


def collect():
    """Return the public calls by name."""
    calls = {}
    for module in (rc, reference, extrapolation, faces, slabs, solving, types_of_rc):
        for name in getattr(module, "__all__", vars(module)):
            value = getattr(module, name)
            if inspect.isfunction(value) and name[0] != "_" and value.__module__.startswith("roughcontact"):
                if module in (rc, faces, slabs, solving, types_of_rc) or value.__module__.startswith(module.__name__):
                    calls[name] = value
            elif module is reference and is_made(value) and value.__module__.startswith(module.__name__):
                calls[f"reference.{name}"] = value
            elif module is rc and is_made(value) and not issubclass(value, BaseException):
                calls[name] = value
    for name, thing in OBJECTS.items():
        for method, _ in inspect.getmembers(type(thing), callable):
            if method[0] != "_" or method in ("__add__", "__getitem__", "__contains__"):
                calls[f"{name}.{method}"] = getattr(thing, method)
    calls["ContactSolution.load"] = rc.ContactSolution.load
    return {name: call for name, call in calls.items() if name not in SKIPPED and parameters(call)}


def parameters(call):
    try:
        found = inspect.signature(call).parameters.values()
    except ValueError:
        return []
    return [one for one in found if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]


CALLABLE = collect()


def good_arguments(name):
    """Return good values of the arguments that a call needs, by their names."""
    short = name.rpartition(".")[2]
    special = GOOD_FOR.get(short, {}) | GOOD_FOR.get(name, {})
    known = parameters(CALLABLE[name])
    needed = [one.name for one in known if one.default is one.empty and one.name not in special]
    taken = {one.name for one in known}
    load = {"pressure": GOOD["pressure"]} if short in LOADED and "pressure" in taken else {}
    return {key: GOOD[key] for key in needed} | load | {key: value for key, value in special.items() if key in taken}


def make_call(seed):
    """Return the name of a call, its arguments, and the names of the bad ones."""
    rng = random.Random(seed)
    name = rng.choice(sorted(CALLABLE))
    known = [one.name for one in parameters(CALLABLE[name])]
    arguments, labels = good_arguments(name), {}
    for changed in rng.sample(known, min(len(known), rng.choice((1, 1, 1, 2)))):
        if changed in ("force", "approach") and "pressure" in arguments and "pressure" not in labels:
            del arguments["pressure"]
        labels[changed] = rng.choice(sorted(BAD))
        arguments[changed] = BAD[labels[changed]]()
    return name, arguments, labels


def is_finite(value):
    """Return whether a result holds no value that is not finite, where it must not."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, np.ndarray):
        return value.dtype.kind != "f" or bool(np.isfinite(value).all())
    if isinstance(value, rc.ContactSolution):
        fields = (value.pressure, value.gap, value.displacement, value.force, value.mean_pressure, value.approach)
        return not value.status.success or all(map(is_finite, fields))
    if isinstance(value, rc.Area):
        return all(map(math.isfinite, (value.value, value.fraction, value.uncertainty)))
    if isinstance(value, results.Sweep):
        return all(map(is_finite, value.states)) and is_finite(value.area)
    if isinstance(value, (rc.Grid, types_of_rc.Load, reference.Hertz, extrapolation.Extrapolation)):
        return all(map(is_finite, attrs.astuple(value, recurse=False)))
    return True


def use(value):
    """Use what a call has made as a user would, and return what must be finite."""
    yield value
    grid, surface, material, options = GRID, ROUGH, HARD, {}
    match value:
        case rc.Grid():
            yield from (value.area, value.cell_area, value.x, value.y, value.spacing)
            grid, surface = value, rc.ParaboloidSurface(1.0)
        case rc.Surface():
            surface, grid = value, value.own_grid or GRID
        case rc.Material():
            material = value
        case rc.InfluenceKernel():
            options["kernel"] = value
        case rc.Convolver():
            options["convolver"] = value
        case rc.Solver():
            options["solver"], material = value, STEEL
        case rc.AreaEstimator():
            yield SOLUTION.area(value)
            return
        case rc.Body():
            surface, material, grid = value.surface, value.material, value.own_grid or GRID
        case rc.ContactSolution() | results.Sweep() | results.SolvePlan():
            yield str(value)
            return
        case rc.Study():
            yield value.explain()
            return
        case rc.ContactProblem():
            yield value.explain()
            yield value.solve(pressure=1e-3 * value.plan.modulus, throw=False)
            return
        case _:
            if inspect.isgenerator(value):
                list(value)
            return
    if grid.cells > 10_000:
        return
    problem = rc.ContactProblem(rc.Body(surface, material), grid=grid, **options)
    solution = problem.solve(approach=0.1 * problem.plan.peak_to_valley, throw=False)
    yield solution
    yield str(solution)


@contextmanager
def bounded():
    """Make errors of warnings, and bound memory and time where the system lets them be."""
    with warnings.catch_warnings(), bounds() if sys.platform.startswith("linux") else nullcontext():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rc.ContactWarning)
        yield


@contextmanager
def bounds():
    import resource

    def stop(*_):
        raise KeyboardInterrupt("a call did not end")

    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(ENDLESS)
    resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def fault(name, arguments):
    """Return what is wrong with how a call ends; None if nothing is."""
    try:
        with bounded():
            if name.startswith(INNER) and ("." in name or name.islower()):
                warnings.simplefilter("ignore")
                CALLABLE[name](**arguments)
                return None
            for result in use(CALLABLE[name](**arguments)):
                if not is_finite(result):
                    return f"not finite: {result!r:.300}"
    except rc.RoughContactError as error:
        return None if name.startswith(INNER) else fault_of_sentence(error)
    except BaseException as error:
        # A callback's own error reaches the user as it is.
        if getattr(error, "of_callback", False):
            return None
        return f"{type(error).__name__}: {error!s:.300}"
    finally:
        if name.endswith(".plot"):
            pyplot.close("all")
    return None


def fault_of_sentence(error):
    text = str(error)
    if isinstance(error, rc.UnexpectedError) and not any(word in text for word in ("Failing.", "Wrong", "value fails")):
        return f"unforeseen: {text}"
    banned = ("object has no attribute", "array(", "not subscriptable", "broadcast", "object is not", "ufunc", "dtype(")
    found = [word for word in banned if word in text.replace("bytearray(", "")]
    if found or not text.endswith((".", "...")) or len(text) > LONGEST or "\n" in text:
        return f"no sentence: {text[:LONGEST]}"
    return None


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    prepare_files()


def prepare_files():
    np.savez("map.npz", heights=MAP.heights(GRID), size=(1e-3, 1e-3))
    np.save("line.npy", LINES[0])
    SOLUTION.save("solution.npz")
    SWEEP.save("sweep.npz")


def test_every_argument_has_a_good_value():
    for name, call in CALLABLE.items():
        arguments = good_arguments(name)
        inspect.signature(call).bind(**arguments)


@pytest.mark.usefixtures("no_pictures")
@pytest.mark.parametrize("name", sorted(CALLABLE.keys() - ABSENT))
def test_good_values_are_accepted(name, folder):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        CALLABLE[name](**good_arguments(name))


def check_calls(seeds):
    faults = []
    for seed in seeds:
        name, arguments, labels = make_call(seed)
        if name not in ABSENT and (found := fault(name, arguments)):
            faults.append(f"seed {seed}: {name} with {labels}: {found}")
    assert not faults, f"{len(faults)} faults\n" + "\n".join(faults)


def test_a_few_calls_end_in_an_answer_or_a_sentence(folder):
    check_calls(range(FEW))


# Calls that ended otherwise once: the name of the call, and its bad arguments.
FOUND = [
    ("SphereSurface", {"center": "1e200"}),
    ("ParaboloidSurface", {"center": "1e308"}),
    ("SurfaceSum.heights", {"grid": "dict"}),
    ("LevelSet.outline", {"solution": "map"}),
    ("Grid", {"size": "array 0-d text"}),
    ("Grid", {"size": "bytearray"}),
    ("Elastic", {"poisson": "masked"}),
    ("Elastic", {"young": "array 0-d text"}),
    ("ElasticPerfectlyPlastic", {"hardness": "array of bool"}),
    ("ElasticPerfectlyPlastic", {"hardness": "array of text"}),
    ("HeightMap", {"non_measured": "inf"}),
    ("HeightMap.shift_half_cell", {"grid": "array of 1e200"}),
    ("PlacedMap.with_parts", {"parts": "array 0-d text"}),
    ("SurfaceSum.with_parts", {"parts": "generator"}),
    ("ContactProblem.sweep", {"force": "bytes"}),
    ("ContactProblem.sweep", {"force": "closed file"}),
    ("ContactProblem.solve", {"on_step": "lambda"}),
    ("limited.solve", {"approach": "numpy float32"}),
    ("limited.verify", {"solution": "solution"}),
    ("PolonskyKeer", {"tolerance": "1e308"}),
    ("Study", {"pressure": "array 0-d"}),
    ("Study.run", {"executor": "2"}),
    ("Study.run", {"folder": "path with nul"}),
    ("Study.run", {"folder": "long text"}),
    ("error_vs_time", {"solvers": "array of text"}),
    ("ContactSolution.load", {"path": "array 0-d"}),
    ("ContactPatches.sum", {"field": "array empty"}),
    ("SolvePlan.memory_at", {"contact_fraction": "nan"}),
    ("kernels.__contains__", {"name": "array of bool"}),
    ("kernels.resolve", {"choice": "long text"}),
    ("kernels.__getitem__", {"name": "solution"}),
    ("hertz_elliptic", {"radii": "list empty"}),
    ("exponential", {"cells": "array of complex"}),
    ("power_law", {"cells": "map"}),
    ("richardson", {"order": "1e-30"}),
    ("richardson", {"order": "2**31"}),
    ("ContactSolution.partial_slip", {"tangential_force": "1e-30"}),
]


@pytest.mark.parametrize(("name", "labels"), FOUND)
def test_what_failed_once_ends_in_an_answer_or_a_sentence(name, labels, folder):
    arguments = good_arguments(name)
    for changed, label in labels.items():
        if changed in ("force", "approach"):
            arguments.pop("pressure", None)
        arguments[changed] = BAD[label]()
    assert fault(name, arguments) is None


# Values that were taken for others, and are none.
@pytest.mark.parametrize(
    ("name", "labels"),
    [
        ("Elastic", {"young": "array 0-d text"}),
        ("Elastic", {"young": "bytes"}),
        ("Elastic", {"young": "masked"}),
        ("ElasticPerfectlyPlastic", {"hardness": "array of bool"}),
        ("ElasticPerfectlyPlastic", {"hardness": "array of text"}),
        ("ElasticPerfectlyPlastic", {"hardness": "array of bytes"}),
        ("ContactProblem.sweep", {"force": "bytes"}),
        ("HeightMap", {"heights": "array of bool"}),
        ("PolonskyKeer", {"tolerance": "1e308"}),
        ("exponential", {"values": "list of text"}),
        ("Grid", {"size": "list of bool"}),
    ],
)
def test_what_is_no_number_is_not_taken_for_one(name, labels):
    arguments = {**good_arguments(name), **{key: BAD[label]() for key, label in labels.items()}}
    with pytest.raises(rc.InputError):
        CALLABLE[name](**{key: value for key, value in arguments.items() if key != "pressure"})


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, CALLS, BLOCK))
def test_calls_end_in_an_answer_or_a_sentence(start, folder):
    check_calls(range(start, start + BLOCK))
