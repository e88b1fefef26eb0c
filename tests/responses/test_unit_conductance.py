"""Conduction through films and saturated cells, beside the tangent of the contact."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from roughcontact._answers.linear.conductance import _Conduction
from roughcontact._answers.linear.tangent import Tangent
from test_conductance import ball


def test_saturated_cells_conduct():
    solution = ball(8, 0, hardness=0.004)
    assert solution.saturated.sum() > 0.2 * solution.contact.sum()
    ones = np.ones(solution.grid.shape)
    unloading = Tangent(solution, saturated=True).solve(ones).values.sum()
    found = solution.conductance(1.0)
    assert found.value == pytest.approx(unloading, rel=0.01)
    assert found.value > 1.03 * solution.stiffness().value
    # The contact of a plastic ball is round too.
    assert found.value == pytest.approx(2 * math.sqrt(solution.area().value / math.pi), rel=0.01)


class Films:
    """A half-space of modulus E0 with a film of so much resistance: a wave q drops 2 / (E q) for each flow."""

    def __init__(self, modulus, film):
        self.modulus, self.film = modulus, film

    def effective_modulus(self, wavenumber, compliance):
        assert compliance == 0.5 * 4.0
        return 1.0 / (1.0 / self.modulus + 0.5 * self.film * wavenumber)


@pytest.mark.parametrize("count", [3, 200])
def test_the_resistance_of_discs_on_films_is_between_its_limits(count):
    """Holm's 1 / 2 E a without a film; r / pi a^2 where the film is all; and above their sum never, nor below either.

    The flow through a disc at one potential with all resistance in the film is uniform; more discs than are computed
    are interpolated.
    """
    radii = np.geomspace(0.3, 5.0, count)

    def find(modulus, film):
        return _Conduction(4.0, 1.0, modulus, SimpleNamespace(kernel=Films(modulus, film))).find_constriction(radii)

    half_space = 1.0 / (2.0 * 0.5 * radii)
    np.testing.assert_allclose(find(0.5, 0.0), half_space, rtol=2e-3)
    np.testing.assert_allclose(_Conduction(4.0, 1.0, 0.5).find_constriction(radii), half_space)
    film = 1e4 / (np.pi * radii**2)
    np.testing.assert_allclose(find(1e3, 1e4), film, rtol=3e-3)
    mixed = find(0.5, 3.0)
    film = 3.0 / (np.pi * radii**2)
    assert (mixed >= half_space + film - 1e-9).all()
    # Uniform flow through both: 32 / 3 pi^2 of Holm's, less than 8.1 % more.
    assert (mixed <= 32.0 / (3.0 * np.pi**2) * half_space + film + 1e-9).all()
