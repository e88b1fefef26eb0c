"""Love's potential of a cell, and the axes of shear kernels."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

import roughcontact as rc
from extended_precision import love_by_mpmath
from roughcontact._parts.kernels import odd_axes
from roughcontact._parts.kernels.half_space import cell_potential
from roughcontact._solve.convolvers.base import periodic_shear_spectrum
from roughcontact.typing import BoundKernel
from test_shear_kernels import COMPONENTS, PAIR


def offsets(rng, count=60):
    """Offsets up to 16384 cells, evenly in their logarithm, with the axes and the corners."""
    some = rng.integers(0, 2 ** rng.integers(1, 15, count))
    return np.unique(np.concatenate([[0, 1, 2, 9, 10, 11, 110, 111, 16384], some]))


def equation_6(x, y, a, b):
    """The paper's eq. 6 without its factor, with the l of its second logarithm restored and nothing else changed."""
    with mp.workdps(60):
        x, y, a, b = (mp.mpf(float(value)) for value in (x, y, a, b))
        ln, sqrt = mp.log, mp.sqrt
        return (
            (x + a) * ln((y + b + sqrt((y + b) ** 2 + (x + a) ** 2)) / (y - b + sqrt((y - b) ** 2 + (x + a) ** 2)))
            + (y + b) * ln((x + a + sqrt((y + b) ** 2 + (x + a) ** 2)) / (x - a + sqrt((y + b) ** 2 + (x - a) ** 2)))
            + (x - a) * ln((y - b + sqrt((y - b) ** 2 + (x - a) ** 2)) / (y + b + sqrt((y + b) ** 2 + (x - a) ** 2)))
            + (y - b) * ln((x - a + sqrt((y - b) ** 2 + (x - a) ** 2)) / (x + a + sqrt((y - b) ** 2 + (x + a) ** 2)))
        )


@pytest.mark.parametrize("aspect", [1.0, 1.5, 8.0])
def test_equation_6_of_the_paper_is_loves_solution(aspect):
    i = j = np.array([0.0, 1.0, 2.0, 7.0, 40.0, 300.0, 4000.0])
    printed = np.array([[float(equation_6(aspect * m, n, aspect / 2, 0.5)) for n in j] for m in i])
    np.testing.assert_allclose(printed, cell_potential(i, j, aspect), rtol=3e-14)


LONG = [1e4, 1e5, 1e6, 1e8, 1e12]


@pytest.mark.parametrize("aspect", [*(1 / a for a in LONG), 1e-3, 0.03, 0.7, 1.0, 1.5, 8.0, 25.0, 1e2, 1e3, *LONG])
def test_love_agrees_with_mpmath_to_1e_14_out_to_16384_cells(aspect):
    rng = np.random.default_rng(3)
    i, j = offsets(rng), offsets(rng)
    if aspect >= 1:
        values = cell_potential(i.astype(float), j.astype(float), aspect)
    else:
        values = aspect * cell_potential(j.astype(float), i.astype(float), 1 / aspect).T
    some = zip(rng.integers(0, i.size, 150), rng.integers(0, j.size, 150), strict=True)
    axes = [(a, 0) for a in range(i.size)] + [(0, b) for b in range(j.size)]
    for a, b in (*some, *axes):
        exact = love_by_mpmath(int(i[a]), int(j[b]), aspect, 1)
        assert abs(values[a, b] / exact - 1) < 1e-14


@pytest.mark.parametrize("kernel", [rc.Love(), rc.FourierHalfSpace()])
def test_half_the_sampling_wave_number_moves_no_other_axis(kernel):
    bound = BoundKernel(kernel, pair=PAIR)
    for component in COMPONENTS:
        values = periodic_shear_spectrum(bound, component, (8, 6), (1.0, 1.4))
        odd_x, odd_y = odd_axes(component)
        assert values[-1].any() == (not odd_x)
        assert values[:, -1].any() == (not odd_y)
