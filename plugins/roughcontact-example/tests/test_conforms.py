import pytest
from matplotlib import pyplot

import roughcontact as rc
import roughcontact.testing as kit
import roughcontact_example as example

ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=20e-6, shortest=3e-6, seed=1)
PARTS = [
    example.Foam(young=70e9, strength=200e6, density=0.1),
    example.Capillary(surface_energy=0.072, kelvin_radius=1e-9, smoothing=3e-10),
    example.Junctions(coefficient=0.3, strength=200e6),
    example.ProjectedGradient(),
    example.Springs(thickness=2e-6),
    example.SignalConvolver(),
    example.AcceleratedGradient(),
    example.Between(),
    example.Capacitance(),
    example.Springback(),
    example.Dimples(ROUGH),
    example.PatchForces(),
    example.Raw16(),
]
CLAIMS = [
    pytest.param(part, claim, id=f"{type(part).__name__}-{claim}")
    for part in PARTS
    for claim in kit.claims(kit.kind_of(part))
]


@pytest.mark.parametrize(("part", "claim"), CLAIMS)
def test_claim(part, claim):
    claim.check(part)


def test_panel():
    body, grid = rc.Body(ROUGH, rc.Elastic(70e9, 0.3)), rc.Grid((32, 32), 20e-6)
    problem = rc.ContactProblem(body, grid=grid, boundary="periodic")
    solution = problem.solve(pressure=50e6)
    axes = pyplot.figure().add_subplot()
    solution.plot("patch-forces", axes=axes)
    carried = axes.lines[0].get_ydata()
    assert carried.size == solution.patches.count
    assert carried[-1] == pytest.approx(100.0)
    pyplot.close("all")
