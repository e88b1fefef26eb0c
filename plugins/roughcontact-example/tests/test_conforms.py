import numpy as np
import pytest
from matplotlib import pyplot

import roughcontact as rc
import roughcontact.testing as kit
import roughcontact_example as example
from roughcontact.__main__ import main

ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=20e-6, shortest=3e-6, seed=1)
PARTS = [
    example.Foam(young=70e9, strength=200e6, density=0.1),
    example.Capillary(surface_energy=0.072, kelvin_radius=1e-9, smoothing=3e-10),
    example.Junctions(coefficient=0.3, strength=200e6),
    example.Oxidation(thickness=20e-9, time=3600.0),
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


def test_friction_along_a_path_in_a_file_and_on_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    grid = rc.Grid((32, 32), 100e-6)
    np.savez("ball.npz", heights=rc.ParaboloidSurface(1e-3).heights(grid), size=grid.size)
    steel = ["--young", "210GPa", "--counterbody-young", "210GPa"]
    law = ["--friction", "junctions", "coefficient=0.4", "strength=100MPa"]
    solve = ["solve", "ball.npz", "--force", "1N", *steel]
    assert main([*solve, *law, "--tangential", "50mN", "-50mN", "-o", "path.npz"]) == 0
    assert "energy lost" in capsys.readouterr().out
    path = rc.FrictionalPath.load("path.npz")
    assert path[0].friction == example.Junctions(0.4, 100e6)
    assert all(state.status.success for state in path)
    assert (np.hypot(*path[1].shear) <= 100e6 * (1 + 1e-6)).all()
    assert main(["info", "path.npz"]) == 0
    assert main([*solve, "--kernel", "springs", "--friction", "0.3", "--tangential", "50mN"]) == 2
    assert "shear" in capsys.readouterr().err


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


STUDY = """
[problems.ball]
grid = {shape = [24, 17], size = [100e-6, 70e-6]}
laws = [{type = "oxidation", thickness = "20nm", time = "1h"}]
body = {surface = {type = "paraboloid", radius = "1mm"}, material = "bearing steel"}
[study]
force = ["1N", "2N"]
time = ["0s", "1h", "10h"]
"""


def test_a_process_of_ones_own_passes_every_door(tmp_path, capsys, monkeypatch):
    """A script, files, command line, page and study, by the class and a line of pyproject.toml alone."""
    monkeypatch.chdir(tmp_path)
    grid = rc.Grid((24, 17), (100e-6, 70e-6))
    np.savez("ball.npz", heights=rc.ParaboloidSurface(1e-3).heights(grid), size=grid.size)
    steel = rc.materials.create("elastic", young=210e9, poisson=0.3)
    law = example.Oxidation("20nm", "1h")
    times = ["0s", "1h", "10h"]
    path = rc.ContactProblem(rc.Body(rc.read_surface("ball.npz"), steel), laws=law).path(force=1.0, time=times)
    grown = path.table().columns["oxide_volume"]
    # Nothing grows where the surfaces touch; outside all of it in ten times its time.
    outside = (~path[-1].contact).sum() * grid.cell_area
    assert grown[0] == 0.0
    assert grown[2] == pytest.approx(20e-9 * outside, rel=1e-3)
    assert path[2].peak_pressure().value < path[0].peak_pressure().value
    path.save("by-hand.npz")
    assert rc.load("by-hand.npz")[2].approach == path[2].approach

    given = ["--force", "1N", "--young", "210GPa", "--law", "oxidation", "thickness=20nm", "time=1h", "--time", *times]
    assert main(["solve", "ball.npz", *given, "-o", "path.npz", "--report", "path.html"]) in (0, 3)
    printed = capsys.readouterr().out
    assert "oxide volume" in printed
    assert "oxide volume" in (tmp_path / "path.html").read_text(encoding="utf-8").lower()
    assert rc.load("path.npz").table().columns["oxide_volume"] == grown
    assert main(["info", "path.npz"]) in (0, 3)
    assert "Oxidation" in capsys.readouterr().out

    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    assert main(["run", "study.toml", "-o", "night"]) in (0, 3)
    table = (tmp_path / "night" / "records.csv").read_text(encoding="utf-8")
    assert "oxide_volume" in table.splitlines()[0]
    assert main(["run", "study.toml", "-o", "night"]) in (0, 3)
    assert "0 of them now" in " ".join(capsys.readouterr().out.split())
