"""The warnings of a contact, found from what a solution is."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from exact_contacts import MODULUS, with_fields
from roughcontact._solve.solution.plausibility import _MAX_METAL_PRESSURE, find_contact, find_scene
from roughcontact.faces import exceeds_metals


def judge(contact, rule):
    return next(one for one in find_contact(contact, (rc.Elastic(1e9, 0.3),)) if one.rule == rule)


OBLONG = rc.Grid((24, 18), (48.0, 18.0))


def flat(pressure, boundary="periodic", initial_gap=None, grid=OBLONG, **options):
    gap = np.where(np.asarray(pressure) > 0.0, 0.0, 1.0)
    return with_fields(grid, pressure, gap, initial_gap=initial_gap, boundary=boundary, **options)


class TestFindings:
    """The number behind each warning, of fields that are known."""

    def test_the_load_of_single_cells(self):
        pressure = np.zeros(OBLONG.shape)
        pressure[2, 2] = 3e6
        pressure[5:7, 5] = 1e6, 2e6
        pressure[9, 9] = 4e6
        found = judge(flat(pressure), "cells per contact")
        assert found.value == pytest.approx(0.7)
        assert found.text == "70 % of the load is on contacts of a single cell"
        assert found.warning
        pressure[9, 8] = 1e6
        assert judge(flat(pressure), "cells per contact").value == pytest.approx(3.0 / 11.0)
        assert not judge(flat(pressure), "cells per contact").warning
        light = judge(flat(np.where(pressure == 3e6, 1.0, 0.0)), "cells per contact")
        assert "(loads are in Pa and N, lengths in m" in light.text
        assert f"the mean pressure is {1e3 / 432:.4g} mPa" in light.text

    def test_the_slope_in_contact_alone(self):
        gap = 0.3 * OBLONG.x + 0.4 * OBLONG.y
        pressure = np.zeros(OBLONG.shape)
        pressure[3:6, 3:6] = 1e6
        wild = np.where(pressure > 0.0, gap, 1e3 + 50.0 * np.random.default_rng(0).random(OBLONG.shape))
        found = judge(flat(pressure, initial_gap=wild), "slope")
        assert found.value == pytest.approx(0.5)
        assert not found.warning
        assert judge(flat(pressure, initial_gap=1.02 * wild), "slope").warning
        along_y = np.zeros(OBLONG.shape)
        along_y[3, 3:6] = 1e6
        assert judge(flat(along_y, initial_gap=wild), "slope").value == pytest.approx(0.4)

    def test_maximum_pressure_and_approach_over_modulus_and_side(self):
        pressure = np.zeros(OBLONG.shape)
        pressure[3:6, 3:6] = 0.29 * MODULUS
        found = flat(pressure, approach=0.29 * 18.0)
        assert judge(found, "maximum pressure").value == pytest.approx(0.29)
        assert judge(found, "approach").value == pytest.approx(0.29)
        assert not judge(found, "maximum pressure").warning
        assert not judge(found, "approach").warning
        more = flat(pressure * 1.05, approach=0.305 * 18.0)
        assert judge(more, "maximum pressure").warning.startswith("The maximum pressure is 0.304 times")
        assert judge(more, "approach").warning
        line = rc.Grid((40, 1), (40.0, 1.0))
        assert judge(flat(np.ones((40, 1)), grid=line, approach=4.0), "approach").value == pytest.approx(0.1)

    @pytest.mark.parametrize(
        ("boundary", "expected"), [("free", 7 / 12), ("free-periodic", 4 / 12), ("periodic", None)]
    )
    def test_the_load_at_a_free_border(self, boundary, expected):
        pressure = np.zeros(OBLONG.shape)
        pressure[0:2, 3] = 2e6
        pressure[5, -1] = 3e6
        pressure[5, 5] = 5e6
        found = judge(flat(pressure, boundary), "edge contact")
        if expected is None:
            assert math.isnan(found.value)
            return
        assert found.value == pytest.approx(expected)
        assert f"{100 * expected:.3g} % of the load" in found.text
        assert found.warning
        small = rc.Grid((12, 3), (12.0, 3.0))
        assert math.isnan(judge(flat(pressure[:12, 2:5], "free", grid=small), "edge contact").value)

    def test_a_light_touch_at_the_border_is_none(self):
        pressure = np.full(OBLONG.shape, 1e6)
        pressure[[0, -1]] = pressure[:, [0, -1]] = 1.0
        assert judge(flat(pressure, "free"), "edge contact").value == 0.0

    def test_the_tilt_is_the_part_of_the_variance_that_is_a_plane(self):
        rng = np.random.default_rng(3)
        noise = rng.normal(size=OBLONG.shape)
        i, j = (index / n for index, n in zip(np.indices(OBLONG.shape), OBLONG.shape, strict=True))
        gap = 5.0 * i + 2.0 * j + noise + 10.0
        gap[7, 7] = 100.0
        pressure = np.zeros(OBLONG.shape)
        pressure[0, 2:5] = 1e6
        found = judge(flat(pressure, "free", initial_gap=gap), "tilt")
        inside = gap < 100.0
        basis = np.stack([np.ones(inside.sum()), i[inside], j[inside]], axis=1)
        fitted = basis @ np.linalg.lstsq(basis, gap[inside], rcond=None)[0]
        assert found.value == pytest.approx(fitted.var() / gap[inside].var(), rel=1e-9)
        assert f"a tilt of {np.ptp(fitted):.3g} m" in found.text
        pressure[5, 5] = 1e9
        assert math.isnan(judge(flat(pressure, "free", initial_gap=gap), "tilt").value)

    def test_moduli_and_lengths_that_no_contact_has(self):
        def list_units(*materials, gap=1e-6, size=1e-3):
            grid = rc.Grid((8, 8), size)
            heights = gap * (np.arange(64.0).reshape(8, 8) % 7) / 6.0
            return find_scene(heights, grid, rc.Boundary.FREE, materials)[0]

        assert list_units(rc.Elastic(210e9, 0.3)).value == 0
        for young, poisson, said in (
            (0.9e6, 0.3, True), (1.1e6, 0.3, False), (0.9e6, 0.5, False), (1.1e12, 0.2, False), (1.4e12, 0.2, True)
        ):  # fmt: skip
            assert (list_units(rc.Elastic(young, poisson)).value == 1) == said, young
        twice = list_units(rc.Elastic(1e3, 0.3), rc.Elastic(1e3, 0.3))
        assert twice.value == 1
        assert "foam or a gel" in twice.text
        assert "longer" not in list_units(gap=0.9e-3).text
        assert "heights differ by 1.167 mm" in list_units(gap=1.4e-3, size=1e-3).text
        assert "less than an atom" in list_units(gap=0.5e-10).text
        assert list_units(gap=5e-10).value == 0
        assert "the domain is 1 m long" in list_units(gap=1e-3, size=1.0).text
        assert list_units(gap=1e-3, size=0.99).value == 0
        assert "cells are 50 pm wide" in list_units(gap=3e-10, size=4e-10).text

    def test_metals_yield_above_a_part_of_their_modulus(self):
        pressure = np.zeros(OBLONG.shape)
        pressure[3, 3] = 1.0
        steel = rc.Elastic(210e9, 0.3)
        part = _MAX_METAL_PRESSURE * 210e9
        for factor, material, options, expected in (
            (1.01, steel, {}, True), (0.99, steel, {}, False), (1.01, steel, {"limit": 1e20}, False),
            (1e9, rc.Elastic(1e6, 0.5), {}, False)
        ):  # fmt: skip
            found = exceeds_metals(flat(factor * part * pressure, **options), (material, rc.Rigid()))
            assert found == expected

    def test_the_heights_jump_across_a_periodic_border(self):
        grid = rc.Grid((16, 20), (16.0, 20.0))
        wave = np.cos(2.0 * np.pi * 2.0 * grid.x / 16.0) + 0.0 * grid.y
        for boundary, tilt, axis in (("periodic", 0.0, 0), ("periodic", 1.0, 0), ("periodic", 1.0, 1)):
            gap = wave + tilt * (grid.x, grid.y)[axis]
            found = find_scene(gap - gap.min(), grid, rc.Boundary(boundary), ())[1]
            steps = np.sqrt(np.mean(np.diff(gap, axis=axis) ** 2))
            across = np.sqrt(np.mean((gap.take(0, axis) - gap.take(-1, axis)) ** 2))
            other = np.sqrt(np.mean((gap.take(0, 1 - axis) - gap.take(-1, 1 - axis)) ** 2))
            beside = np.sqrt(np.mean(np.diff(gap, axis=1 - axis) ** 2))
            expected = max(across / steps, other / beside if beside > 0.0 else 0.0)
            assert found.value == pytest.approx(expected)
            assert bool(found.warning) == (tilt > 0.0)
        half = find_scene(gap - gap.min(), grid, rc.Boundary("periodic-free"), ())[1]
        assert not half.warning
        assert math.isnan(find_scene(gap, grid, rc.Boundary.FREE, ())[1].value)
