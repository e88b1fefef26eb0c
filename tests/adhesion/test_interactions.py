from __future__ import annotations

import copy
import math
import pickle

import attrs
import numpy as np
import pytest
from scipy import integrate

import roughcontact as rc
from roughcontact.typing import BoundInteraction, quantity

WORK = 0.05
LAWS = [
    rc.Exponential(WORK, 2e-9),
    rc.Dugdale(WORK, 1e7),
    rc.Dugdale(WORK, 1e7, smoothing=1.0),
    rc.VanDerWaals(WORK, 5e-10),
]
GAPS = np.linspace(0.0, 2e-8, 4001)


class Linear(rc.Interaction):
    """A law of one's own: the tension falls in a straight line."""

    def __repr__(self):
        return f"{type(self).__name__}()"

    def tension(self, gap):
        return 5e6 * np.maximum(1.0 - gap / 2e-8, 0.0)

    def slope(self, gap):
        return np.where(gap < 2e-8, -2.5e14, 0.0)

    def energy(self, gap):
        return -0.05 * np.maximum(1.0 - gap / 2e-8, 0.0) ** 2


@pytest.mark.parametrize("law", [*LAWS, Linear()], ids=repr)
class TestEveryLaw:
    def test_the_tension_is_the_derivative_of_the_energy(self, law):
        step = 1e-13
        inner = GAPS[1:]
        found = (law.energy(inner + step) - law.energy(inner - step)) / (2.0 * step)
        np.testing.assert_allclose(found, law.tension(inner), atol=2e-4 * law.strength)

    def test_the_slope_is_the_derivative_of_the_tension(self, law):
        step = 1e-13
        inner = GAPS[1:-1]
        found = (law.tension(inner + step) - law.tension(inner - step)) / (2.0 * step)
        np.testing.assert_allclose(found, law.slope(inner), atol=2e-4 * law.steepest)

    def test_the_work_of_adhesion_is_the_integral_of_the_tension(self, law):
        reach = law.reach
        corners = np.geomspace(1e-3, 1.0, 13) * reach
        parts = zip(np.append(0.0, corners[:-1]), corners, strict=True)
        total = sum(integrate.quad(lambda gap: float(law.tension(np.asarray(gap))), *part)[0] for part in parts)
        assert total == pytest.approx(WORK, rel=2e-6)
        assert law.work == pytest.approx(WORK, rel=1e-14)
        assert np.all(np.abs(law.energy(np.array([1.0, 2.0]) * reach * (1.0 + 1e-9))) <= 1.001e-6 * WORK)

    def test_it_pulls_less_the_farther_apart(self, law):
        tension = law.tension(GAPS)
        assert law.strength == pytest.approx(tension[0], rel=1e-15)
        assert np.all(np.diff(tension) <= 0.0)
        assert np.all(tension >= 0.0)

    def test_steepest_bounds_the_slope(self, law):
        assert np.abs(law.slope(GAPS)).max() == pytest.approx(law.steepest, rel=1e-4)

    def test_single_precision_stays_and_nothing_is_changed(self, law):
        gap = GAPS[:-1].astype(np.float32)
        before = gap.copy()
        bound = BoundInteraction(law, 1e-9, 1e6)
        for function in (bound.tension, bound.slope, bound.energy):
            single = function((gap / np.float32(1e-9)).reshape(1, -1))
            assert single.dtype == np.float32
            assert single.shape == (1, gap.size)
            double = function(gap.astype(np.float64).reshape(1, -1) / 1e-9)
            np.testing.assert_allclose(single, double, atol=2e-6 * np.abs(double).max())
        np.testing.assert_array_equal(gap, before)

    def test_units_of_powers_of_two_change_no_bit(self, law):
        length, pressure = 2.0**-30, 2.0**22
        bound = BoundInteraction(law, length, pressure)
        np.testing.assert_array_equal(bound.tension(GAPS / length) * pressure, law.tension(GAPS))
        np.testing.assert_array_equal(bound.energy(GAPS / length) * (length * pressure), law.energy(GAPS))
        assert bound.steepest * (pressure / length) == law.steepest
        assert bound.reach * length == law.reach

    def test_a_stretched_law_has_the_same_work(self, law):
        bound = BoundInteraction(law, 1e-9, 1e6).stretched(4.0)
        assert float(bound.energy(np.zeros(()))) == pytest.approx(-WORK / 1e-3, rel=1e-12)
        assert bound.steepest == pytest.approx(law.steepest * 1e-15 / 16.0, rel=1e-12)
        assert bound.strength == pytest.approx(law.strength / 4e6, rel=1e-12)

    def test_it_survives_pickling(self, law):
        again = pickle.loads(pickle.dumps(law))
        np.testing.assert_array_equal(again.tension(GAPS), law.tension(GAPS))


def test_closed_forms():
    assert rc.Exponential(0.05, 2e-9).tension(np.array([2e-9]))[0] == pytest.approx(0.05 / 2e-9 / math.e, rel=1e-14)
    assert rc.VanDerWaals(0.05, 1e-9).tension(np.array([1e-9]))[0] == pytest.approx(2 * 0.05 / 1e-9 / 8, rel=1e-14)
    # The Hamaker constant of two half-spaces, A = 12 pi w z^2: the tension far away is A / (6 pi g^3).
    hamaker = 12.0 * math.pi * 0.05 * 1e-18
    assert rc.VanDerWaals(0.05, 1e-9).tension(np.array([1e-4]))[0] == pytest.approx(
        hamaker / (6 * math.pi * 1e-12), rel=4e-5
    )
    dugdale = rc.Dugdale(0.05, 1e7, smoothing=0.2)
    np.testing.assert_allclose(dugdale.tension(np.array([0.0, 3.9e-9, 5e-9, 6.1e-9])), [1e7, 1e7, 5e6, 0.0], atol=1e-8)
    assert dugdale.steepest == pytest.approx(math.pi * 1e14 / (4 * 0.2 * 0.05), rel=1e-14)


class _Linear(rc.Interaction):
    """A law of one's own, whose tension falls linearly: with an array of strengths it varies from cell to cell."""

    def __init__(self, strength):
        self.largest = strength

    def tension(self, gap):
        return self.largest * np.maximum(1.0 - gap / 1e-8, 0.0)

    def slope(self, gap):
        return np.where(gap < 1e-8, -self.largest / 1e-8, 0.0)

    def energy(self, gap):
        return -0.5e-8 * self.largest * np.maximum(1.0 - gap / 1e-8, 0.0) ** 2


def test_work_and_strength_of_a_law_of_ones_own_are_numbers_or_arrays():
    assert type(_Linear(5e6).work) is float
    assert type(_Linear(5e6).strength) is float
    strengths = np.array([[1e6, 2e6, 4e6]])
    np.testing.assert_allclose(_Linear(strengths).work, 0.5e-8 * strengths, rtol=1e-15)
    np.testing.assert_array_equal(_Linear(strengths).strength, strengths)


@pytest.mark.parametrize("ask", ["resolve", "cohesive_cells"])
@pytest.mark.parametrize(
    ("spacing", "modulus", "what"),
    [((0.0, 0.0), 1e9, "The cell"), ((1e-8, np.nan), 1e9, "The cell"), ((1e-8, 3e-8), 0.0, "The contact modulus")],
)
def test_cells_and_moduli_that_no_grid_has(ask, spacing, modulus, what):
    law = rc.ShortRange(0.05) if ask == "resolve" else rc.Exponential(0.05, 1e-9)
    with pytest.raises(rc.InputError, match=what):
        getattr(law, ask)(spacing, modulus)


def test_a_short_range_has_no_units_without_a_grid():
    with pytest.raises(rc.InputError, match="depends on the grid"):
        rc.ShortRange(0.05).scaled(1e-9, 1e6)


def test_work_and_range_may_vary_from_cell_to_cell():
    work = np.array([[0.01, 0.02, 0.03]])
    for law in (rc.Exponential(work, 2e-9), rc.Dugdale(work, 1e7), rc.VanDerWaals(work, 1e-9), rc.ShortRange(work)):
        if isinstance(law, rc.ShortRange):
            law = law.resolve((1e-8, 1e-8), 1e9)
        np.testing.assert_allclose(law.work, work, rtol=1e-14)
        gap = np.full((1, 3), 3e-9)
        each = [float(_at(law, cell).tension(np.asarray(3e-9))) for cell in range(3)]
        np.testing.assert_allclose(law.tension(gap)[0], each, rtol=1e-14)
        bound = BoundInteraction(law, 1e-9, 1e6)
        part = bound.convert(lambda values: values[:, 1:])
        np.testing.assert_allclose(part.tension(gap[:, 1:] / 1e-9), bound.tension(gap / 1e-9)[:, 1:], rtol=1e-14)
        again = copy.deepcopy(law)
        assert not again.work.flags.writeable
    same = BoundInteraction(rc.Exponential(0.05, 2e-9))
    assert same.convert(lambda values: values[:, 1:]) is same


def _at(law, cell):
    fields = {field.alias: getattr(law, field.name) for field in attrs.fields(type(law))}
    return type(law)(**{name: value[0, cell] if np.ndim(value) else value for name, value in fields.items()})


def test_the_shortest_range_is_that_which_the_grid_resolves():
    law = rc.ShortRange("50mJ/m2").resolve((1e-8, 3e-8), 1e9)
    assert law.cohesive_cells((1e-8, 3e-8), 1e9) == pytest.approx(2.0, rel=1e-14)
    assert law.work == 0.05
    # Half of the cell: the range shrinks by the square root.
    finer = rc.ShortRange(0.05).resolve((5e-9, 1.5e-8), 1e9)
    assert finer.range == pytest.approx(law.range / math.sqrt(2.0), rel=1e-14)
    with pytest.raises(rc.InputError, match="depends on the grid"):
        rc.ShortRange(0.05).tension(np.zeros(3))
    fixed = rc.Exponential(0.05, 2e-9)
    assert fixed.resolve((1e-8, 1e-8), 1e9) is fixed


def test_texts_with_units():
    assert rc.Exponential("50mJ/m2", "2nm").range == 2e-9
    assert rc.Exponential("50 mN/m", "2nm").work == pytest.approx(0.05, rel=1e-15)
    assert rc.Dugdale("0.05 J/m^2", "10MPa").strength == 1e7
    assert quantity("J/m2")("50mJ/m2") == 0.05
    for wrong in ("50", "50mJ", "50Pa", "work"):
        with pytest.raises(rc.InputError, match="work of adhesion"):
            rc.Exponential(wrong, 2e-9)


@pytest.mark.parametrize(
    "value", [0.0, -1.0, math.nan, math.inf, True, None, [[0.1, -0.1]], np.zeros((2, 2)), np.ones(3)]
)
def test_wrong_values(value):
    with pytest.raises(rc.InputError, match="work of adhesion"):
        rc.Exponential(value, 1e-9)
    with pytest.raises(rc.InputError, match="range"):
        rc.VanDerWaals(0.05, value)
    with pytest.raises(rc.InputError, match="smoothing"):
        rc.Dugdale(0.05, 1e7, smoothing=value)


def test_a_registered_law_is_made_by_its_name():
    name = "law of a straight line"
    rc.interactions.register(name)(Linear)
    assert isinstance(rc.interactions.resolve(name), Linear)
    assert Linear().cohesive_cells((1e-8, 1e-8), 1e9) == pytest.approx(1e9 / 2.5e14 / 1e-8, rel=1e-3)


def test_a_law_of_a_wrong_shape_is_named():
    class Wrong(Linear):
        def tension(self, gap):
            return np.zeros(7)

    with pytest.raises(rc.InputError, match=r"Wrong.* shape \(7,\)"):
        BoundInteraction(Wrong(), 1e-9, 1e6).tension(np.zeros((2, 2)))
