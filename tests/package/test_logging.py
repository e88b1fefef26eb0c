"""What `logging.getLogger("roughcontact")` gets of a run."""

import logging

import numpy as np
import pytest

import roughcontact as rc


def press_ball(**solver):
    steel = rc.Elastic(young=210e9, poisson=0.3)
    ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    return rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((17, 51), (51e-6, 51e-6)), **solver)


@pytest.fixture
def lines(caplog):
    caplog.set_level(logging.INFO, logger="roughcontact")

    def read():
        found = [(one.levelname, one.getMessage()) for one in caplog.records if one.name == "roughcontact"]
        caplog.clear()
        return found

    return read


def test_a_solve_is_a_line(lines):
    solution = press_ball().solve(force=1.0)
    ((level, text),) = lines()
    assert level == "INFO"
    assert text.startswith(f"solved 17 x 51 cells on 51 µm x 51 µm, force 1 N: CONVERGED, {solution.iterations} iter")


def test_a_solve_that_ends_early_is_a_warning(lines):
    press_ball(solver=rc.ProjectedConjugateGradient(max_iterations=1)).solve(force=1.0, throw=False)
    ((level, text),) = lines()
    assert level == "WARNING"
    assert "MAXIMUM_ITERATIONS" in text


def test_increments_contacts_of_a_study_and_maps_are_lines(lines, tmp_path):
    press_ball().path(force=1.0, tangential_force=[(0.1, 0.0)], friction=0.3, substeps=2)
    assert sum(text.startswith("increment to force 1 N, (") for _, text in lines()) == 2
    rc.Study(problems={"ball": press_ball()}, force=[1.0, 1e9]).run(tmp_path / "study")
    found = [one for one in lines() if one[1].startswith("study: ball, seed None, force ")]
    assert [level for level, _ in found] == ["INFO", "INFO"]
    np.savez(tmp_path / "map.npz", heights=np.zeros((4, 8)), size=(4e-6, 8e-6))
    rc.read_surface(tmp_path / "map.npz")
    assert lines() == [("INFO", "read map.npz: 4 x 8 cells on 4 µm x 8 µm")]
