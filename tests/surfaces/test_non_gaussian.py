"""Random surfaces of a given spectrum, skewness and kurtosis, or bearing curve."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from unit_files import read_study

WAVES = {"hurst": 0.8, "shortest": 4e-6, "longest": 32e-6}
GRID = rc.Grid((128, 128), 64e-6)


def find_moments(heights):
    rough = heights - heights.mean()
    return float(np.mean(rough**3)) / rough.std() ** 3, float(np.mean(rough**4)) / rough.std() ** 4


def power(heights):
    return np.abs(np.fft.fft2(heights)) ** 2


@pytest.mark.parametrize(("skewness", "kurtosis"), [(0, 3), (-1, 5), (-2, 9), (1, 5), (0, 2.6), (0, 7), (-0.5, 3)])
def test_moments_are_those_asked_for_and_the_spectrum_stays(skewness, kurtosis):
    surface = rc.NonGaussianSurface(rms_height=1e-6, skewness=skewness, kurtosis=kurtosis, seed=3, **WAVES)
    heights = surface.heights(GRID)
    assert find_moments(heights) == pytest.approx((skewness, kurtosis), abs=0.01)
    assert heights.std() == pytest.approx(1e-6, rel=1e-12)
    gaussian = rc.SelfAffineSurface(rms_height=1e-6, seed=3, **WAVES)
    np.testing.assert_allclose(power(heights), power(gaussian.heights(GRID)), rtol=0, atol=1e-12 * power(heights).max())


@pytest.mark.parametrize(("shape", "size"), [((256, 33), (256e-6, 32e-6)), ((90, 150), (90e-6, 90e-6))])
def test_it_is_the_same_surface_on_every_grid(shape, size):
    surface = rc.NonGaussianSurface(hurst=0.6, rms_slope=0.2, shortest=3e-6, longest=30e-6, skewness=-1.5, seed=1)
    coarse = surface.heights(rc.Grid(shape, size))
    finer = surface.heights(rc.Grid((3 * shape[0], 3 * shape[1]), size))
    np.testing.assert_allclose(finer[1::3, 1::3], coarse, rtol=0, atol=1e-12 * np.ptp(coarse))
    assert find_moments(finer) == pytest.approx((-1.5, 3.0 + 1.5**3), abs=0.012)
    assert surface.reseed(1) == rc.NonGaussianSurface(
        hurst=0.6, rms_slope=0.2, shortest=3e-6, longest=30e-6, skewness=-1.5, seed=2
    )


def test_a_lay_stays():
    surface = rc.NonGaussianSurface(rms_height=1e-6, skewness=-1, peklenik=3.0, lay=0.5, **WAVES)
    along_x, along_y = np.gradient(surface.heights(GRID), 0.5e-6)
    across = 0.5 * np.arctan2(2.0 * np.mean(along_x * along_y), np.mean(along_x**2 - along_y**2))
    assert (across + 0.5 * np.pi) % np.pi == pytest.approx(0.5, abs=0.15)


def test_heights_follow_a_bearing_curve():
    rng = np.random.default_rng(0)
    worn = np.minimum(rng.standard_normal((64, 64)), 0.5) * 2e-7
    curve = rc.reference.bearing_area(worn)
    surface = rc.NonGaussianSurface(bearing=(curve.levels, curve.fractions), **WAVES)
    heights = surface.heights(GRID)
    assert heights.std() == pytest.approx(worn.std(), rel=0.02)
    found = rc.reference.bearing_area(heights, curve.levels)
    assert np.abs(found.fractions - curve.fractions).max() < 0.2
    inner = (curve.fractions > 0.3) & (curve.fractions < 0.99)
    np.testing.assert_allclose(found.fractions[inner], curve.fractions[inner], atol=0.06)
    scaled = rc.NonGaussianSurface(bearing=(curve.levels[::-1], curve.fractions[::-1]), rms_height=1e-6, **WAVES)
    np.testing.assert_allclose(scaled.heights(GRID), heights * (1e-6 / heights.std()), rtol=0, atol=1e-12)


def test_worn_summits_carry_less_at_a_given_separation():
    steel = rc.Elastic(young=210e9, poisson=0.3)
    pressures = []
    for skewness in (0.0, -1.0, -2.0):
        surface = rc.NonGaussianSurface(rms_height=0.5e-6, skewness=skewness, seed=1, **WAVES)
        problem = rc.ContactProblem(rc.Body(surface, steel), grid=GRID, boundary="periodic")
        summit = surface.heights(GRID).max()
        pressures.append(problem.solve(approach=summit - 1.5 * 0.5e-6).mean_pressure)
    assert pressures[0] > 2.0 * pressures[1] > 8.0 * pressures[2] > 0.0


def test_from_the_command_line_a_study_and_a_file(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = "--hurst 0.8 --rms-height 100nm --shortest 4um --longest 32um --skewness -1 --kurtosis 5 --seed 2"
    assert (
        main(["surface", "non-gaussian", *options.split(), "--shape", "48", "48", "--size", "48um", "-o", "x.npz"]) == 0
    )
    assert "skewness, kurtosis      -1, 5" in capsys.readouterr().out
    (tmp_path / "study.toml").write_text(
        """[problems.one]
boundary = "periodic"
grid = {shape = [48, 48], size = "48um"}
[problems.one.body]
material = {young = 1e9, poisson = 0.3}
[problems.one.body.surface]
type = "non-gaussian"
hurst = 0.8
rms_height = "100nm"
shortest = "4um"
longest = "32um"
bearing = [[1, 0, -2], [0, 0.9, 1]]
[study]
pressure = [1e7]
"""
    )
    (problem,) = read_study(tmp_path / "study.toml").problems.values()
    assert problem.body.surface.bearing == ((1.0, 0.0, -2.0), (0.0, 0.9, 1.0))
    solution = problem.solve(pressure=1e7)
    solution.save(tmp_path / "solution.npz")
    assert rc.load(tmp_path / "solution.npz").origin.problem["body"].surface == problem.body.surface


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"skewness": -2, "kurtosis": 4}, "skewness of -2 and a kurtosis of 4: choose a larger kurtosis, such as 9"),
        ({"skewness": 9}, "choose a skewness nearer to 0"),
        ({"rms_slope": 0.1}, "exactly one of rms_height= and rms_slope="),
        ({"skewness": -1, "bearing": [[1, 0], [0, 1]]}, "skewness= and kurtosis=, or bearing="),
        ({"bearing": [[1, 0], [0.5, 0.2]]}, "fractions from 0 to 1 that grow as the level falls"),
        ({"bearing": [[1, 0, 0], [0, 1]]}, "3 levels, but 2 fractions"),
        ({"bearing": [[1, 1], [0, 1]]}, "more than one level"),
        ({"bearing": "x"}, "The bearing curve must be a pair of lists"),
        ({"kurtosis": 0.5}, "The kurtosis must be a finite number, above 1"),
        ({"rolloff": 1e-6}, "roll-off"),
    ],
)
def test_what_is_not_a_surface_is_refused(changes, sentence):
    with pytest.raises(rc.InputError, match=sentence):
        rc.NonGaussianSurface(**{"rms_height": 1e-6, **WAVES, **changes})


def test_what_few_waves_cannot_make_is_refused():
    surface = rc.NonGaussianSurface(hurst=0.8, rms_height=1e-6, shortest=16e-6, longest=32e-6, skewness=-3, kurtosis=20)
    with pytest.raises(rc.InputError, match="These waves make no surface with a skewness of -3"):
        surface.heights(GRID)
    with pytest.raises(rc.InputError, match="The shortest wavelength must be at least two cells"):
        surface.heights(rc.Grid((4, 4), 64e-6))
