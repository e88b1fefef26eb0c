"""What is said of a contact does not depend on how it lies on the grid, nor on the units of its lengths and moduli.

The same contact is transposed, mirrored, or made a thousand times larger: every area, every estimate and every number
that a figure draws follows. Domains are oblong, cells are not square, numbers of cells are odd.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from matplotlib.collections import LineCollection

import roughcontact as rc
from roughcontact.plotting import SampledSurface, make_figure
from strategies import STRICT, seeds

AREAS = sorted(rc.areas)
QUANTITIES = ("approach", "mean-gap", "patches", "peak-pressure", "perimeter")
# Panels whose curves are named after the axes have the names exchanged by a transposition.
EXCHANGED = {"along x": "along y", "along y": "along x"}
THOUSAND = 1000.0
# Profiles across a contact alone are flat to this, in the unit that is drawn.
FLAT = 1e-6


@attrs.frozen(eq=False)
class Scene:
    """Heights, shape (nx, ny), m, on a domain of `size`, m, and what they are pressed with."""

    heights: np.ndarray
    size: tuple[float, float]
    boundary: str
    young: float
    hardness: float | None
    pressure: float
    non_measured: np.ndarray | None = None

    def solve(self) -> rc.ContactSolution:
        material = rc.Elastic(self.young, 0.3)
        if self.hardness is not None:
            material = rc.ElasticPerfectlyPlastic(self.young, 0.3, self.hardness)
        surface = rc.HeightMap(self.heights.copy(), size=self.size, periodic=True, non_measured=self.non_measured)
        problem = rc.ContactProblem(rc.Body(surface, material), boundary=self.boundary, solver=STRICT)
        return problem.solve(pressure=self.pressure)

    def sample(self) -> SampledSurface:
        heights = self.heights if self.non_measured is None else np.where(self.non_measured, np.nan, self.heights)
        return SampledSurface(heights.copy(), rc.Grid(heights.shape, self.size), self.boundary == "periodic")


@attrs.frozen
class Move:
    """How a contact is laid on the grid anew: what happens to heights, to fields, to sides and to numbers."""

    name: str
    turn: Callable[[np.ndarray], np.ndarray] = np.asarray
    exchanges_axes: bool = False
    lengths: float = 1.0
    moduli: float = 1.0

    def apply(self, scene: Scene) -> Scene:
        lx, ly = (self.lengths * side for side in scene.size)
        return attrs.evolve(
            scene,
            heights=self.lengths * np.ascontiguousarray(self.turn(scene.heights)),
            size=(ly, lx) if self.exchanges_axes else (lx, ly),
            young=self.moduli * scene.young,
            hardness=None if scene.hardness is None else self.moduli * scene.hardness,
            pressure=self.moduli * scene.pressure,
            non_measured=None if scene.non_measured is None else np.ascontiguousarray(self.turn(scene.non_measured)),
        )

    def scale_of(self, unit: str) -> float:
        powers = {"m": 1, "m2": 2, "": 0, "Pa": 0}
        return self.lengths ** powers[unit] * (self.moduli if unit == "Pa" else 1.0)


TRANSPOSED = Move("transposed", np.transpose, exchanges_axes=True)
MIRRORED_X = Move("mirrored along x", lambda field: field[::-1])
MIRRORED_Y = Move("mirrored along y", lambda field: field[:, ::-1])
LARGER = Move("a thousand times larger", lengths=THOUSAND)
STIFFER = Move("a thousand times stiffer", moduli=THOUSAND)
MOVES = (TRANSPOSED, MIRRORED_X, MIRRORED_Y, LARGER, STIFFER)
CLASSES = {name: rc.panels[name] for name in rc.panels}


def smooth_noise(shape, seed, shortest):
    """Return periodic heights, of unit standard deviation, without waves shorter than so many cells."""
    nx, ny = shape
    spectrum = np.fft.fft2(np.random.default_rng(seed).standard_normal(shape))
    wave = np.hypot(np.fft.fftfreq(nx)[:, np.newaxis], np.fft.fftfreq(ny))
    spectrum[(wave > 1.0 / shortest) | (wave == 0.0)] = 0.0
    heights = np.fft.ifft2(spectrum / np.maximum(wave, 1.0 / max(shape)) ** 1.8).real
    return heights / heights.std()


@st.composite
def scenes(draw):
    """A rough contact, elastic or plastic, or a ball anywhere, on an oblong domain with cells of unequal sides."""
    shape = draw(st.sampled_from([(45, 23), (24, 48), (31, 37), (64, 16), (17, 60), (40, 40)]))
    dx, dy = draw(st.sampled_from([(1e-6, 1e-6), (1e-6, 3e-6), (2e-6, 1e-6)]))
    boundary = draw(st.sampled_from(["free", "periodic"]))
    size = (shape[0] * dx, shape[1] * dy)
    young = 100e9
    if draw(st.booleans()):
        heights = 0.02 * min(dx, dy) * smooth_noise(shape, draw(seeds), draw(st.sampled_from([4.0, 6.0])))
        pressure = draw(st.sampled_from([0.05, 0.3, 1.0])) * 0.02 * young
    else:
        x, y = ((np.arange(n) + 0.5) * side / n for n, side in zip(shape, size, strict=True))
        place = [draw(st.floats(0.2, 0.8)) * side for side in size]
        heights = -((x[:, np.newaxis] - place[0]) ** 2 + (y - place[1]) ** 2) / (400.0 * min(size))
        pressure = 1e-5 * young
    hardness = draw(st.sampled_from([None, None, 0.02 * young]))
    if hardness is not None:
        pressure = min(pressure, 0.3 * hardness)
    holes = None
    if draw(st.booleans()):
        holes = np.random.default_rng(draw(seeds)).random(shape) < 0.03
        holes &= heights < heights.max()
    return Scene(heights, size, boundary, young, hardness, pressure, holes)


def read_answers(solution):
    answers = {f"area {name}": solution.area(name) for name in AREAS}
    answers |= {f"estimate {name}": solution.response(name) for name in QUANTITIES}
    if solution.saturated.any():
        answers["saturated area"] = solution.saturated_area()
    return answers


@pytest.mark.slow
@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(scene=scenes(), move=st.sampled_from(MOVES))
def test_every_area_and_estimate_follows_the_contact(scene, move):
    expected, found = read_answers(scene.solve()), read_answers(move.apply(scene).solve())
    assert expected.keys() == found.keys()
    for name, one in expected.items():
        other = found[name]
        unit = "m2" if isinstance(one, rc.Area) else one.unit
        scale = move.scale_of(unit)
        context = (name, move.name)
        assert other.value == pytest.approx(scale * one.value, rel=1e-4, abs=0.02 * scale * one.uncertainty), context
        assert other.uncertainty == pytest.approx(scale * one.uncertainty, rel=0.05, abs=1e-6 * scale * one.value), (
            context
        )
        assert len(other.warnings) == len(one.warnings), context
        if isinstance(one, rc.Area) and one.perimeter is not None:
            assert other.perimeter == pytest.approx(move.lengths * one.perimeter, rel=1e-3, nan_ok=True), context


def read_numbers(axes, exchanged=False, lengths=1.0):
    """Return every number that a panel draws, by what it belongs to."""
    numbers = {}
    # Spectral densities have no prefix.
    units = np.array([1.0, lengths**4 if axes.get_ylabel().endswith(", m⁴") else 1.0])
    for index, image in enumerate(axes.images):
        shown = np.ma.filled(np.ma.asarray(image.get_array(), dtype=float), np.nan)
        if shown.ndim == 2:
            numbers[f"image {index}"] = shown.T if exchanged else shown
    for index, line in enumerate(axes.lines):
        label = line.get_label()
        label = EXCHANGED.get(label, label) if exchanged else label
        # A label that states a length has its unit.
        label = label if label.isalpha() or label in EXCHANGED else f"line {index}"
        if len(line.get_xdata()):
            numbers[label] = np.asarray(line.get_xydata(), dtype=float) / units
    for collection in axes.collections:
        if isinstance(collection, LineCollection):
            # A closed line may begin anywhere; its last point is its first.
            points = np.concatenate([*(line[:-1] for line in collection.get_segments()), np.empty((0, 2))])
            numbers["edges"] = np.sort(np.hypot(*points.T))
    numbers["bars"] = np.array([bar.get_bbox().bounds for bar in axes.patches if hasattr(bar, "get_height")])
    return numbers


def turn_images(numbers, move):
    """Return the numbers of the contact as it lies, with images as they must be after the move."""
    if move.exchanges_axes:
        return numbers
    return {name: move.turn(values.T).T if name.startswith("image") else values for name, values in numbers.items()}


def compare_figures(kind, one, other, panel, moved_panel, move):
    expected = turn_images(read_numbers(make_figure(kind, one, panel).axes[0]), move)
    found = read_numbers(make_figure(kind, other, moved_panel).axes[0], move.exchanges_axes, move.lengths)
    assert expected.keys() == found.keys(), panel
    flat = FLAT if type(rc.panels.resolve(panel)) is rc.panels["profile"] else 0.0
    for name, values in expected.items():
        assert found[name].shape == values.shape, (panel, name)
        across = tuple(range(values.ndim)) if name.startswith("image") else 0
        size = np.nanmax(np.abs(values), axis=across, initial=0.0)
        differences = np.abs(found[name] - values) > 2e-3 * np.abs(values) + 1e-4 * size + flat
        assert not differences.any(), (panel, name, found[name][differences], values[differences])
        assert np.array_equal(np.isnan(found[name]), np.isnan(values)), (panel, name)
    return sum(values.size for values in found.values())


FIGURE_SCENES = {
    "rough": Scene(2e-8 * smooth_noise((45, 23), 3, 5.0), (45e-6, 69e-6), "periodic", 100e9, None, 3e8),
    "rough free": Scene(2e-8 * smooth_noise((24, 51), 4, 5.0), (48e-6, 51e-6), "free", 100e9, None, 1e8),
    "plastic": Scene(2e-8 * smooth_noise((32, 45), 5, 5.0), (32e-6, 45e-6), "periodic", 100e9, 2e9, 3e8),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURE_SCENES)
@pytest.mark.parametrize("move", [TRANSPOSED, LARGER], ids=lambda move: move.name)
def test_every_figure_of_a_solution_follows_the_contact(name, move):
    scene = FIGURE_SCENES[name]
    one, other = scene.solve(), move.apply(scene).solve()
    for panel in (name for name, cls in CLASSES.items() if cls.subject == "solution" and cls.fits(one)):
        drawn, moved = panel, panel
        if panel == "profile" and move.exchanges_axes:
            drawn, moved = rc.panels.create(panel, axis=0), rc.panels.create(panel, axis=1)
        assert compare_figures("solution", one, other, drawn, moved, move) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURE_SCENES)
@pytest.mark.parametrize("move", [TRANSPOSED, MIRRORED_X, LARGER], ids=lambda move: move.name)
def test_every_figure_of_a_surface_follows_it(name, move):
    scene = FIGURE_SCENES[name]
    for panel in (panel for panel in rc.panels if rc.panels[panel].subject == "surface"):
        assert compare_figures("surface", scene.sample(), move.apply(scene).sample(), panel, panel, move) >= 40


@pytest.mark.slow
@pytest.mark.parametrize("move", [TRANSPOSED, MIRRORED_Y, LARGER, STIFFER], ids=lambda move: move.name)
def test_every_figure_of_a_sweep_follows_the_contact(move):
    def sweep(scene):
        surface = rc.HeightMap(scene.heights.copy(), size=scene.size, periodic=True)
        problem = rc.ContactProblem(
            rc.Body(surface, rc.Elastic(scene.young, 0.3)), boundary=scene.boundary, solver=STRICT
        )
        return problem.sweep(pressure=[0.5 * scene.pressure, scene.pressure])

    scene = FIGURE_SCENES["rough"]
    for panel in (panel for panel in rc.panels if rc.panels[panel].subject == "sweep"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert compare_figures("sweep", sweep(scene), sweep(move.apply(scene)), panel, panel, move) >= 4
