"""Viscoelastic bodies below layers, in gradients and beside crystals: loads that act at once, and nothing else."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
import roughcontact as rc

from roughcontact_layered import Anisotropic, AnisotropicKernel, GradedKernel, Layer, LayeredKernel, PairKernel

RUBBER = rc.Viscoelastic([1e6, 9e6], [1e-3], 0.5)
AT_ONCE = rc.Elastic(10e6, 0.5)
COATING = Layer(40e6, 0.4, 50e-6)
CRYSTAL = Anisotropic.cubic(165.7e6, 63.9e6, 79.6e6, normal=(1, 1, 0), x_axis=(0, 0, 1))
# Cells of 1 : 3.
GRID = rc.Grid((24, 16), (1e-3, 2e-3))
HEIGHTS = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=0.5e-3, longest=2e-3, seed=3)
CASES = {
    "layer on rubber": (LayeredKernel(COATING, AT_ONCE), RUBBER, rc.Rigid()),
    "layers on both": (
        PairKernel(LayeredKernel(COATING, AT_ONCE), LayeredKernel(Layer(5e6, 0.3, 20e-6), AT_ONCE)),
        RUBBER,
        AT_ONCE,
    ),
    "rubber in a gradient": (GradedKernel(2e3, AT_ONCE), RUBBER, rc.Rigid()),
    "crystal on rubber": (AnisotropicKernel(CRYSTAL), RUBBER, CRYSTAL),
}


@pytest.mark.parametrize("case", CASES)
def test_a_load_acts_at_once_and_time_and_speed_get_a_sentence(case):
    kernel, flat, other = CASES[case]
    sides = rc.Body(rc.FlatSurface(), flat), rc.Body(HEIGHTS, other)
    problem = rc.ContactProblem(*sides, grid=GRID, boundary="periodic", kernel=kernel)
    state = problem.solve(pressure=3e4)
    elastic = attrs.evolve(problem, body=rc.Body(rc.FlatSurface(), AT_ONCE)).solve(pressure=3e4)
    np.testing.assert_allclose(state.pressure, elastic.pressure, atol=1e-9 * state.pressure.max())
    with pytest.raises(rc.InputError, match="one half-space each"):
        problem.path(pressure=3e4, time=[0.0, 1.0])
    with pytest.raises(rc.InputError, match="isotropic half-spaces"):
        problem.slide(pressure=3e4, speed=0.1)
