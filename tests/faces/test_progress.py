"""Progress of long calls on standard error."""

import subprocess
import sys

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("tqdm")


def press_wave(**parts):
    body = rc.Body(rc.WavySurface(amplitude=1e-6, wavelength=50e-6), rc.Elastic(young=210e9, poisson=0.3))
    return rc.ContactProblem(body, grid=rc.Grid((48, 16), (100e-6, 100e-6)), boundary="periodic", **parts)


def press_ball():
    steel = rc.Elastic(young=210e9, poisson=0.3)
    ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    return rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((17, 51), (51e-6, 51e-6)))


def follow_cycle(**options):
    ball = rc.Body(rc.ParaboloidSurface(radius=1e-6), rc.Elastic(young=10e6, poisson=0.5))
    law = rc.Exponential(work="50mJ/m2", range="60nm")
    problem = rc.ContactProblem(ball, grid=rc.Grid((24, 24), 2e-6), adhesion=law)
    return problem.cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 3), **options)


CALLS = {
    "sweep": lambda folder, **options: press_wave().sweep(pressure=[1e7, 2e7, 3e7], **options),
    "cycle": lambda folder, **options: follow_cycle(**options),
    "path": lambda folder, **options: press_ball().path(
        force=1.0, tangential_force=[(0.1, 0.0), (0.1, 0.1)], friction=0.3, substeps=2, **options
    ),
    "law": lambda folder, **options: rc.interface_law(press_wave(), [1e7, 2e7], **options),
    "study": lambda folder, **options: rc.Study(problems={"wave": press_wave()}, pressure=[1e7]).run(folder, **options),
    "error report": lambda folder, **options: rc.error_vs_time(
        press_wave(), pressure=1e7, cells=[24], repeats=1, **options
    ),
    "stability": lambda folder, **options: rc.stability(press_wave(), pressure=1e7, **options),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_long_call_shows_how_far_it_is_if_it_is_asked_to(name, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    CALLS[name](tmp_path / "silent")
    assert capsys.readouterr().err == ""
    CALLS[name](tmp_path / "shown", progress=True)
    shown = capsys.readouterr().err
    assert f"00:00  {name.split()[-1]}" in shown
    # Nothing is left of it when the call ends.
    assert shown.split("\r")[-2].strip() == ""


@pytest.mark.parametrize("name", CALLS)
def test_progress_is_yes_or_no(name, tmp_path):
    with pytest.raises(rc.InputError, match="progress="):
        CALLS[name](tmp_path, progress="yes")


def test_callbacks_are_called_too(capsys):
    states = []
    follow_cycle(on_state=states.append, progress=True)
    assert len(states) == 5
    assert "cycle" in capsys.readouterr().err


def test_without_tqdm_it_is_asked_for(tmp_path):
    script = tmp_path / "script.py"
    lines = [
        "import sys",
        "sys.modules['tqdm'] = None",
        "import roughcontact as rc",
        "ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))",
        "rc.ContactProblem(ball, grid=rc.Grid((16, 16), 51e-6)).sweep(force=[1.0, 2.0], progress=True)",
    ]
    script.write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert "MissingPackage: Progress needs the package tqdm: pip install 'roughcontact[progress]'." in done.stderr
