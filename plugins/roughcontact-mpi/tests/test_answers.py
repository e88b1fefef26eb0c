"""Area, maximum pressure, patches and stiffness on slabs are those of one machine."""

import json
from pathlib import Path

import numpy as np
import pytest
import roughcontact as rc

import answer_cases
import mpi

pytestmark = pytest.mark.skipif(bool(mpi.missing()), reason=mpi.missing() or "MPI is there")

SCRIPT = Path(answer_cases.__file__)
CASES = [f"{name} {boundary}" for name in answer_cases.CONTACTS for boundary in answer_cases.BOUNDARIES]
# Two processes have all cases; more processes than processors wait for each other, so that three have some.
OF_COUNT = {
    count: [case for case in CASES if case.split()[0] in names] for count, names in answer_cases.OF_COUNT.items()
}
# The solve for the stiffness is one in float32.
TOLERANCES = {"stiffness": 1e-8}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder with the answers of one, two and three processes."""
    place = tmp_path_factory.mktemp("answers")
    for count in OF_COUNT:
        done = mpi.run(count, SCRIPT, place, timeout=600)
        assert done.returncode == 0, done.stderr
    return place


@pytest.mark.parametrize(("count", "case"), [(count, case) for count, cases in OF_COUNT.items() for case in cases])
def test_answers_are_those_of_the_gathered_solution(folder, case, count):
    found, expected = json.loads((folder / f"answers-{count}.json").read_text())[case]
    for name, numbers in expected.items():
        tolerance = TOLERANCES.get(name, 1e-9)
        for one, other in zip(found[name], numbers, strict=True):
            # An uncertainty far below rounding of the number is rounding itself.
            assert one == pytest.approx(other, rel=tolerance, abs=tolerance * np.abs(numbers[0]).max()), name


@pytest.mark.parametrize("case", [case for case in CASES if case in OF_COUNT[3] and case.split()[0] in ("odd", "hard")])
def test_the_gathered_solution_is_that_of_one_machine(folder, case):
    name, boundary = case.split()
    heights, size = answer_cases.make(name)
    body = rc.Body(rc.HeightMap(heights, size), answer_cases.material_of(name))
    problem = rc.ContactProblem(body, boundary=boundary)
    alone = problem.solve(**answer_cases.CONTACTS[name][3], tolerance=1e-10)
    for count in (2, 3):
        pressure = np.load(folder / f"{name}-{boundary}-{count}.npy")
        assert np.abs(pressure - alone.pressure).max() < 1e-8 * alone.pressure.max()
        found = json.loads((folder / f"answers-{count}.json").read_text())[case][0]
        area = alone.area(uncertainty="model")
        assert found["blend"][:2] == pytest.approx([area.value, area.uncertainty], rel=1e-6)
        assert found["peak-pressure"][0] == pytest.approx(alone.peak_pressure().value, rel=1e-7)
        assert found["stiffness"][0] == pytest.approx(alone.stiffness().value, rel=1e-7)


def test_contacts_cross_slabs_wrap_around_and_leave_slabs_empty(folder):
    """The cases hold what they are there for."""
    snake = np.load(folder / "snake-periodic-3.npy") > 0.0
    corner = np.load(folder / "corner-periodic-3.npy") > 0.0
    assert snake.any(axis=1).all()
    assert corner[0, 0]
    assert corner[-1, -1]
    assert not corner[40:88].any()
    assert np.load(folder / "odd-free-3.npy")[[0, -1]].any()
