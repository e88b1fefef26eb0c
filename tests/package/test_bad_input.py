"""Every kind of bad input gets one sentence that says what, the value, what is allowed and what to do."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import extrapolation, reference
from scenes import make_problem

GRID = rc.Grid((8, 8), 1e-3)
STEEL = rc.Elastic(210e9, 0.3)
WAVE = rc.WavySurface(1e-6, 1e-3)
BODY = rc.Body(WAVE, STEEL)
NAN, INF = float("nan"), float("inf")
ROUGH = {"hurst": 0.8, "shortest": 1e-4, "longest": 1e-3}


problem = partial(make_problem, BODY.surface, BODY.material, grid=GRID)


def with_infinite():
    heights = np.zeros((4, 4))
    heights[1, 1] = np.inf
    return heights


class WrongShape(rc.Surface):
    def heights(self, grid):
        return np.zeros((2, 3))


class NotFinite(rc.Surface):
    def heights(self, grid):
        return np.full(grid.shape, NAN)


class Stretchy(rc.Material):
    compliance = -1.0
    pressure_limit = INF


class Wordy(rc.Material):
    compliance = 1e-9
    pressure_limit = "hard"


TABLE = {
    "grid of one cell": (lambda: rc.Grid((1, 1), 1.0), "at least two cells"),
    "grid of no cell": (lambda: rc.Grid((0, 4), 1.0), "at least 1"),
    "grid of half cells": (lambda: rc.Grid((4.5, 4), 1.0), "whole number"),
    "grid of one number": (lambda: rc.Grid(64, 1.0), "two whole numbers"),
    "grid without size": (lambda: rc.Grid((4, 4), 0.0), "above 0"),
    "grid of negative size": (lambda: rc.Grid((4, 4), (1.0, -1.0)), "above 0"),
    "grid of infinite size": (lambda: rc.Grid((4, 4), INF), "finite number"),
    "grid with a size in words": (lambda: rc.Grid((4, 4), "big"), "finite number"),
    "grid of three sides": (lambda: rc.Grid((4, 4), (1.0, 1.0, 1.0)), "one value or two"),
    "modulus zero": (lambda: rc.Elastic(0.0, 0.3), "Young's modulus"),
    "modulus negative": (lambda: rc.Elastic(-1e9, 0.3), "above 0"),
    "modulus in words": (lambda: rc.Elastic("steel", 0.3), "'steel'"),
    "modulus nan": (lambda: rc.Elastic(NAN, 0.3), "finite number"),
    "modulus array": (lambda: rc.Elastic(np.ones(3), 0.3), "finite number"),
    "modulus true": (lambda: rc.Elastic(True, 0.3), "finite number"),
    "modulus none": (lambda: rc.Elastic(None, 0.3), "finite number"),
    "Poisson's ratio of more than a half": (lambda: rc.Elastic(1e9, 0.51), "at most 0.5"),
    "Poisson's ratio of -1": (lambda: rc.Elastic(1e9, -1.0), "above -1"),
    "hardness zero": (lambda: rc.ElasticPerfectlyPlastic(1e9, 0.3, 0.0), "The hardness"),
    "hardness infinite": (lambda: rc.ElasticPerfectlyPlastic(1e9, 0.3, INF), "finite number"),
    "map with infinite points": (lambda: rc.HeightMap(with_infinite(), size=1.0), "1 of 16 points"),
    "map of missing points": (lambda: rc.HeightMap(np.full((4, 4), np.nan), size=1.0), "No point of the height map"),
    "map masked": (lambda: rc.HeightMap(np.ma.masked_all((4, 4)), size=1.0), "No point of the height map was measured"),
    "map empty": (lambda: rc.HeightMap(np.zeros((0, 4)), size=1.0), "at least two cells"),
    "map of one cell": (lambda: rc.HeightMap([[1.0]], size=1.0), "at least two cells"),
    "map of one dimension": (lambda: rc.HeightMap([1.0, 2.0], size=1.0), "two-dimensional"),
    "map of three dimensions": (lambda: rc.HeightMap(np.zeros((2, 2, 2)), size=1.0), "two-dimensional"),
    "map ragged": (lambda: rc.HeightMap([[1.0, 2.0], [3.0]], size=1.0), "rectangular"),
    "map of text": (lambda: rc.HeightMap([["a", "b"]], size=1.0), "real numbers"),
    "map of complex numbers": (lambda: rc.HeightMap(np.ones((2, 2)) * 1j, size=1.0), "real numbers"),
    "map without size": (lambda: rc.HeightMap(np.zeros((2, 2)), size=None), "finite number"),
    "map on another grid": (lambda: rc.HeightMap(np.eye(4), size=1.0).heights(GRID), "resample"),
    "resampling unknown": (lambda: rc.HeightMap(np.eye(4), size=1.0).resample((2, 2), "magic"), "'bilinear'"),
    "resampling to nothing": (lambda: rc.HeightMap(np.eye(4), size=1.0).resample((0, 2)), "at least 1"),
    "Fourier of a map that ends": (lambda: rc.HeightMap(np.eye(4), size=1.0).resample((8, 8), "fourier"), "periodic"),
    "means of broken blocks": (lambda: rc.HeightMap(np.eye(4), size=1.0).resample((3, 2), "mean"), "divide"),
    "trend of degree -1": (lambda: rc.HeightMap(np.eye(4), size=1.0).detrend(-1), "at least 0"),
    "trend of too high degree": (lambda: rc.HeightMap(np.eye(4), size=1.0).detrend(4), "more than 4 cells"),
    "wave of length zero": (lambda: rc.WavySurface(1e-6, 0.0), "The wavelength"),
    "wave of negative amplitude": (lambda: rc.WavySurface(-1e-6, 1e-3), "The amplitude"),
    "sphere of radius zero": (lambda: rc.SphereSurface(0.0), "The radius"),
    "sphere smaller than the domain": (lambda: rc.SphereSurface(1e-4).heights(GRID), "smaller domain"),
    "paraboloid of negative radius": (lambda: rc.ParaboloidSurface((1.0, -1.0)), "radius of curvature"),
    "roughness of no height": (lambda: rc.SelfAffineSurface(**ROUGH), "exactly one"),
    "roughness of two heights": (lambda: rc.SelfAffineSurface(**ROUGH, rms_height=1.0, rms_slope=1.0), "exactly one"),
    "roughness of Hurst 2": (lambda: rc.SelfAffineSurface(**{**ROUGH, "hurst": 2}, rms_slope=1.0), "Hurst"),
    "roll-off outside": (lambda: rc.SelfAffineSurface(**ROUGH, rms_slope=1.0, rolloff=1.0), "roll-off"),
    "roughness with a negative seed": (lambda: rc.SelfAffineSurface(**ROUGH, rms_slope=1.0, seed=-1), "The seed"),
    "roughness finer than the grid": (
        lambda: rc.SelfAffineSurface(**ROUGH, rms_slope=1.0).heights(rc.Grid((8, 8), 1e-3)),
        "at least two cells",
    ),
    "roughness longer than the domain": (
        lambda: rc.SelfAffineSurface(hurst=0.5, shortest=3.0, longest=4.0, rms_slope=1.0).heights(rc.Grid((8, 8), 1.0)),
        "enlarge it",
    ),
    "body without surface": (lambda: rc.Body(None, STEEL), "The surface of a body"),
    "body without material": (lambda: rc.Body(WAVE, 210e9), "The material of a body"),
    "surface in place of a body": (lambda: rc.ContactProblem(WAVE, grid=GRID), "Body(surface, material)"),
    "shape in place of a grid": (lambda: problem(grid=(8, 8)), "Grid(shape, size)"),
    "no grid": (lambda: problem(grid=None), "give grid="),
    "rigid against rigid": (
        lambda: rc.ContactProblem(rc.Body(WAVE, rc.Rigid()), rc.RIGID_FLAT, grid=GRID),
        "Both bodies are rigid",
    ),
    "flat against flat": (
        lambda: rc.ContactProblem(rc.Body(rc.FlatSurface(), STEEL), grid=GRID),
        "Both surfaces are flat",
    ),
    "equal heights everywhere": (
        lambda: rc.ContactProblem(rc.Body(rc.HeightMap(np.full((4, 4), 3.0), size=1.0), STEEL)),
        "Both surfaces are flat",
    ),
    "two maps on two grids": (
        lambda: rc.ContactProblem(
            rc.Body(rc.HeightMap(np.eye(4), size=1.0), STEEL), rc.Body(rc.HeightMap(np.eye(5), size=1.0), STEEL)
        ),
        "resample",
    ),
    "surface of the wrong shape": (lambda: rc.ContactProblem(rc.Body(WrongShape(), STEEL), grid=GRID), "(2, 3)"),
    "surface of nan": (lambda: rc.ContactProblem(rc.Body(NotFinite(), STEEL), grid=GRID), "not finite"),
    "negative compliance": (lambda: rc.ContactProblem(rc.Body(WAVE, Stretchy()), grid=GRID), "compliance"),
    "boundary unknown": (lambda: problem(boundary="open"), "one of 'free', 'periodic', 'wrapped'"),
    "kernel misspelt": (lambda: problem(kernel="lov"), "Did you mean 'love'?"),
    "convolver misspelt": (lambda: problem(convolver="dcfft"), "Did you mean 'dc-fft'?"),
    "solver misspelt": (lambda: problem(solver="polonski-keer"), "Did you mean 'polonsky-keer'?"),
    "kernel class for an instance": (lambda: problem(kernel=rc.Love), "Pass an instance"),
    "number for a solver": (lambda: problem(solver=3), "registered name"),
    "tolerance zero": (lambda: rc.PolonskyKeer(tolerance=0.0), "above 0"),
    "no iterations": (lambda: rc.SpectralGradient(max_iterations=0), "at least 1"),
    "no threads": (lambda: problem(threads=0), "'auto' or a whole number of at least 1"),
    "no memory": (lambda: problem(memory_limit=0), "at least 1 (bytes)"),
    "memory in words": (lambda: problem(memory_limit="much"), "a text such as '8 GiB'"),
    "no load": (lambda: problem().solve(), "none of them"),
    "two loads": (lambda: problem().solve(pressure=1e6, force=1.0), "pressure= and force="),
    "load zero": (lambda: problem().solve(pressure=0.0), "above 0"),
    "load negative": (lambda: problem().solve(force=-1.0), "above 0"),
    "load infinite": (lambda: problem().solve(pressure=INF), "finite number"),
    "load nan": (lambda: problem().solve(pressure=NAN), "finite number"),
    "load in words": (lambda: problem().solve(pressure="100 pounds"), "'100 pounds'"),
    "approach zero": (lambda: problem().solve(approach=0.0), "above 0"),
    "approach beyond full contact": (
        lambda: problem(boundary="periodic").solve(approach=3e-6),
        "below that of full contact",
    ),
    "approach for the paper's solver": (
        lambda: problem(solver="polonsky-keer").solve(approach=1e-6),
        "use solver='auto'",
    ),
    "hardness of another shape": (
        lambda: rc.ContactProblem(rc.Body(WAVE, rc.ElasticPerfectlyPlastic(1e9, 0.3, np.ones((2, 2)))), grid=GRID),
        "shape (2, 2)",
    ),
    "hardness with zeros": (lambda: rc.ElasticPerfectlyPlastic(1e9, 0.3, np.zeros((2, 2))), "above 0"),
    "more load than the hardness bears": (
        lambda: rc.ContactProblem(rc.Body(WAVE, rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e6)), grid=GRID).solve(
            pressure=2e6
        ),
        "at most 1 MPa, that is 1 N",
    ),
    "estimator misspelt": (lambda: problem().solve(pressure=1e6).area("cellcount"), "Did you mean 'cell-count'?"),
    "estimator of another kind": (lambda: problem().solve(pressure=1e6).area(3), "registered name"),
    "estimator class for an instance": (lambda: problem().solve(pressure=1e6).area(rc.CellCount), "Pass an instance"),
    "number registered": (lambda: rc.kernels.register("x")(5), "a class"),
    "limit in words": (lambda: rc.ContactProblem(rc.Body(WAVE, Wordy()), grid=GRID), "pressure limit"),
    "resampling to one number": (lambda: rc.HeightMap(np.eye(4), size=1.0).resample(5), "two whole numbers"),
    "wave of negative amplitude in a closed form": (lambda: reference.WavyContact(-1.0, 1.0, 1.0), "above 0"),
    "strip beyond full contact": (lambda: reference.Westergaard(1.0, 1.0, 1.0).half_width(9.0), "at most"),
    "order in words": (lambda: extrapolation.richardson([1, 2], [1.0, 2.0], order="two"), "'two'"),
    "modulus complex": (lambda: rc.Elastic(np.complex64(1 + 2j), 0.3), "finite number"),
    "file missing": (lambda: rc.read_surface("nowhere.npz"), "There is no file 'nowhere.npz'"),
    "folder for a file": (lambda: rc.read_surface("."), "it is a folder"),
    "non-measured points in other words": (
        lambda: rc.read_surface("nowhere.npz", non_measured="ignore"),
        "'refuse', 'fill'",
    ),
    "extrapolation from one grid": (lambda: extrapolation.exponential([64], [1.0]), "at least two"),
    "extrapolation of nan": (lambda: extrapolation.power_law([64, 128], [1.0, NAN]), "finite"),
    "extrapolation of text": (lambda: extrapolation.richardson(["a"], ["b"]), "lists of numbers"),
    "extrapolation of unequal lists": (lambda: extrapolation.exponential([64, 128], [1.0]), "equal length"),
    "Richardson on two grids": (lambda: extrapolation.richardson([64, 128], [2.0, 1.0]), "three grids"),
    "Hertz without force": (lambda: reference.hertz_sphere(0.0, 1.0, 1.0), "above 0"),
}


@pytest.mark.parametrize("case", TABLE)
def test_bad_input_gets_a_sentence(case):
    action, words = TABLE[case]
    with pytest.raises(rc.InputError) as caught:
        action()
    sentence = str(caught.value)
    assert words in sentence
    assert sentence.endswith((".", "?"))
    assert len(sentence) < 400


def test_input_errors_are_value_errors():
    assert issubclass(rc.InputError, ValueError)
    assert issubclass(rc.InputError, rc.RoughContactError)
    assert issubclass(rc.NotConverged, rc.RoughContactError)


@pytest.mark.parametrize(
    "start", [5, "x", [[1, 2]], [[1], [1, 2]], np.full((16, 16), np.nan), np.ones((16, 16)) * 1j, np.ones((4, 4))]
)
def test_a_start_that_is_no_pressure(start):
    problem = rc.ContactProblem(rc.Body(rc.WavySurface(1e-3, 8.0), rc.Elastic(1.0, 0.0)), grid=rc.Grid((16, 16), 16.0))
    with pytest.raises(rc.InputError, match="pressure to start from"):
        problem.solve(pressure=1e-4, start=start)


@pytest.mark.parametrize("loads", [5, [1.0, "x"], [1.0, None], [1.0, [2]], [1.0, float("inf")], []])
def test_loads_of_a_sweep_that_are_none(loads):
    problem = rc.ContactProblem(rc.Body(rc.WavySurface(1e-3, 8.0), rc.Elastic(1.0, 0.0)), grid=rc.Grid((16, 16), 16.0))
    with pytest.raises(rc.InputError, match="load"):
        problem.sweep(pressure=loads)
