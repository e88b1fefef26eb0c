"""The linear problem beneath a contact with adhesion, by its own matrix."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.linear.tangent import AdhesiveTangent
from roughcontact._solve.problem import problem_of
from test_adhesion_linear import APPROACH, HARD, LAWS, NAMES, PRESSURE, SHAPES, SOFT, SQUARE, Scene, find_ends


class TestAnswer:
    """The linear answer itself."""

    @pytest.mark.parametrize("material", [SOFT, HARD], ids=["elastic", "hard"])
    @pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
    @pytest.mark.parametrize(("shape", "size"), SHAPES, ids=NAMES)
    def test_the_kernel_confirms_it(self, shape, size, boundary, material):
        # The solver divides by the spectrum of the kernel; this multiplies by it.
        solution = Scene(boundary, LAWS[0], material, shape, size).solve(**APPROACH)
        right = 1e-9 * np.random.default_rng(2).normal(size=shape)
        answer = AdhesiveTangent(solution).solve(right)
        problem = problem_of(solution)
        moved = solution.grid.spacing[0] / solution.modulus * problem.convolution.apply(answer.values)
        opened = ~solution.contact
        slope = problem.adhesion.slope(np.maximum(solution.gap, 0.0))
        scale = np.abs(answer.values).max()
        assert answer.error < 1e-10
        closed = solution.contact & ~solution.saturated
        np.testing.assert_allclose(moved[closed], right[closed], atol=1e-8 * np.abs(right).max())
        expected = -(slope * (moved - right))[opened]
        np.testing.assert_allclose(answer.values[opened], expected, atol=1e-8 * scale)
        assert not answer.values[solution.saturated].any()
        assert answer.product == pytest.approx(float(np.sum(right * answer.values)), rel=1e-9)

    @pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
    def test_reciprocity(self, boundary):
        tangent = AdhesiveTangent(Scene(boundary, LAWS[1], HARD).solve(**PRESSURE))
        one, other = np.random.default_rng(4).normal(size=(2, 24, 24))
        there = float(np.sum(tangent.solve(one).values * other))
        assert there == pytest.approx(float(np.sum(tangent.solve(other).values * one)), rel=1e-9)

    def test_the_error_of_the_product_is_a_square(self):
        tangent = AdhesiveTangent(Scene("free").solve(**APPROACH))
        ones = np.ones(SQUARE[0])
        exact = tangent.solve(ones).product
        for tolerance in (1e-1, 1e-2, 1e-3):
            found = tangent.solve(ones, tolerance)
            # A minimum of the energy, which an approximation exceeds.
            assert -1e-12 < found.product / exact - 1.0 < 2.0 * tolerance**2
            assert found.products < 30

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_the_margin_is_met_on_the_way(self, boundary):
        solution = Scene(boundary).solve(**APPROACH)
        margin = AdhesiveTangent(solution).solve(np.ones(SQUARE[0])).margin
        assert margin == pytest.approx(solution.stability().value, rel=0.15)


class TestStiffness:
    @pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_neighbouring_states(self, boundary, law):
        scene = Scene(boundary, law, shape=(48, 48))
        middle = scene.solve(**APPROACH)
        step, ends = find_ends(lambda step: scene.solve(0.0, middle.pressure, approach=3e-9 * (1 + step)), middle)
        difference = (ends[0].force - ends[1].force) / (6e-9 * step)
        # The cells in contact are fixed there; the stiffness corrects for the edge between them.
        fixed = AdhesiveTangent(middle).solve(np.ones(scene.shape)).values.sum() * middle.grid.cell_area
        assert fixed == pytest.approx(difference, rel=1e-6)
        found = middle.stiffness()
        assert abs(found.value - difference) < 2.0 * found.uncertainty
        assert set(middle.area().warnings) <= set(found.warnings)

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_without_work_it_is_that_without_adhesion(self, boundary):
        load = {"pressure": 2e7}
        plain = Scene(boundary, None).solve(**load)
        expected, slope = plain.stiffness(), plain.gradient("approach")
        differences = []
        for work in (1e-4, 1e-5):
            solution = Scene(boundary, rc.Exponential(work, 6e-9)).solve(**load)
            assert np.array_equal(solution.contact, plain.contact)
            tangent = AdhesiveTangent(solution).solve(np.ones(solution.grid.shape))
            fixed = float(tangent.values.sum()) * solution.grid.cell_area
            differences.append(fixed)
            assert solution.stiffness().value == pytest.approx(expected.value, rel=3.0 * work / 1e-3)
            error = np.abs(solution.gradient("approach") - slope).max() / np.abs(slope).max()
            assert error < 3.0 * work / 1e-3
        bare = plain.response("stiffness")
        assert bare.value == expected.value
        assert abs(differences[1] - differences[0]) < 0.01 * differences[0]
