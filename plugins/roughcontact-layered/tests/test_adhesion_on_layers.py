"""Adhesion on layers: the law meets the modulus of the layer, not that of the half-space below."""

import numpy as np
import pytest
import roughcontact as rc

from roughcontact_layered import Layer, LayeredKernel

GLASS = rc.Elastic(70e9, 0.3)
GEL = rc.Elastic(1e7, 0.49)
WORK = 0.05
RADIUS = 1e-6
TIP = rc.ParaboloidSurface(RADIUS, (7e-9, 11e-9))


def press(law, material, shape=(48, 48), **parts):
    return rc.ContactProblem(rc.Body(TIP, material), grid=rc.Grid(shape, 2.4e-6), adhesion=law, **parts)


@pytest.mark.parametrize("law", [rc.ShortRange(WORK), rc.Exponential(WORK, 60e-9)])
@pytest.mark.parametrize("shape", [(48, 48), (48, 36)])
def test_a_thick_soft_layer_on_glass_is_a_soft_half_space(law, shape):
    layer = LayeredKernel(layers=[Layer(1e7, 0.49, 50e-6)], substrate=GLASS)
    on_glass = press(law, GLASS, shape, kernel=layer)
    alone = press(law, GEL, shape)
    found = on_glass.pull_off()
    expected = alone.pull_off()
    assert found.value == pytest.approx(expected.value, rel=0.01)
    assert found.uncertainty == pytest.approx(expected.uncertainty, rel=0.2)
    plans = [on_glass.plan, alone.plan]
    cells = [plan.interaction.cohesive_cells(plan.grid.spacing, plan.surface_modulus) for plan in plans]
    assert cells[0] == pytest.approx(cells[1], rel=0.02)
    areas = [problem.solve(force=0.0).area() for problem in (on_glass, alone)]
    assert areas[0].uncertainty == pytest.approx(areas[1].uncertainty, rel=0.05)


def test_a_stiff_film_is_not_refused_for_its_soft_body():
    film = LayeredKernel(layers=[Layer(1e9, 0.3, 5e-6)], substrate=GEL)
    law = rc.Exponential(WORK, 10e-9)
    assert press(law, GEL, kernel=film).plan.surface_modulus == pytest.approx(1e9 / 0.91, rel=0.02)
    with pytest.raises(rc.InputError, match="A path cannot be followed"):
        press(law, GEL).cycle(approach=np.array([-1e-8, 0.0]))
    assert press(law, GEL, kernel=film).require_cycle(approach=[-1e-8, 0.0])
