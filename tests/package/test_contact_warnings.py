"""Warnings of answers that a script gets by `warnings.warn`."""

import subprocess
import sys
import threading
import warnings

import pytest

import roughcontact as rc

# A ball that is cut by the border of its domain of 100 by 50 cells, 1 by 3 µm.
SCENE = """
import roughcontact as rc

ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
solution = rc.ContactProblem(ball, grid=rc.Grid((51, 17), (51e-6, 51e-6))).solve(force=9.0)
"""


def run_script(folder, lines):
    """Return what a script prints, and what it writes to standard error."""
    path = folder / "script.py"
    path.write_text(SCENE + lines, encoding="utf-8")
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, check=True, cwd=folder)
    return done.stdout, done.stderr


def make_cut_ball():
    names = {}
    exec(SCENE, names)
    return names["solution"]


def given_by(ask):
    """Return the sentences that a call gives."""
    with warnings.catch_warnings(record=True, action="always") as found:
        ask()
    assert all(one.category is rc.ContactWarning and one.filename == __file__ for one in found)
    return [str(one.message) for one in found]


def test_a_script_is_warned_once_at_its_own_line(tmp_path):
    printed, errors = run_script(tmp_path, "for _ in range(3):\n    area = solution.area().value\nprint(area)\n")
    assert float(printed) > 0.0
    assert errors.count("ContactWarning") == errors.count("script.py:7") == len(make_cut_ball().warnings)
    assert "area = solution.area()" in errors
    assert "reach the free border" in errors


def test_one_filter_is_silent(tmp_path):
    silent = "import warnings\nwarnings.filterwarnings('ignore', category=rc.ContactWarning)\n"
    assert run_script(tmp_path, silent + "solution.area(), solution.stiffness()\n")[1] == ""


def test_nothing_is_said_before_a_number_is_asked_for(tmp_path):
    assert run_script(tmp_path, "print(solution, solution.approach, solution.warnings)\n")[1] == ""


def test_a_solution_gives_its_warnings_with_the_first_answer_and_an_answer_its_own():
    solution = make_cut_ball()
    assert solution.warnings
    first = given_by(solution.stiffness)
    assert first == [*solution.warnings, *solution.stiffness().warnings]
    assert given_by(solution.stiffness) == list(solution.stiffness().warnings)
    assert given_by(solution.peak_pressure) == list(solution.peak_pressure().warnings)


def test_the_warnings_of_parts_of_a_plug_in_are_given():
    class Doubled(rc.Response):
        def respond(self, solution):
            return rc.Estimate(2.0 * solution.force, 0.1, "N", ("the number is only an example",))

    assert "the number is only an example" in given_by(lambda: make_cut_ball().response(Doubled()))


def test_a_state_with_friction_warns():
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    flat = rc.Body(rc.FlatSurface(), rc.Elastic(young=210e9, poisson=0.3))
    problem = rc.ContactProblem(ball, flat, grid=rc.Grid((17, 51), (51e-6, 51e-6)))
    state = problem.path(force=9.0, tangential_force=[(0.5, 0.0)], friction=0.3)[-1]
    assert state.warnings
    assert set(state.warnings) <= set(given_by(lambda: state.stick_area))


def test_an_error_can_be_made_of_a_warning():
    with warnings.catch_warnings(category=rc.ContactWarning, action="error"), pytest.raises(rc.ContactWarning):
        make_cut_ball().area()


@pytest.mark.slow
def test_the_command_line_says_warnings_once(tmp_path):
    heights = tmp_path / "ball.npz"
    make = ["surface", "sphere", "--radius", "1mm", "--shape", "51", "17", "--size", "51um", "-o", heights]
    for call in (make, ["solve", heights, "--force", "9N", "--young", "210GPa", "--stiffness"]):
        done = subprocess.run([sys.executable, "-m", "roughcontact", *call], capture_output=True, text=True)
        assert "ContactWarning" not in done.stderr
    assert done.stdout.count("reach the free border") == 1


def test_a_study_keeps_warnings_in_its_table(tmp_path):
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    problem = rc.ContactProblem(ball, grid=rc.Grid((51, 17), (51e-6, 51e-6)))
    study = rc.Study(problems={"ball": problem}, force=[9.0], responses=["stiffness"])
    threads = []

    class Threads:
        def submit(self, function, *arguments):
            from concurrent.futures import Future

            future = Future()
            threads.append(threading.Thread(target=lambda: future.set_result(function(*arguments))))
            threads[-1].start()
            return future

    with warnings.catch_warnings(record=True, action="always") as found:
        result = study.run(tmp_path, executor=Threads())
    assert not found
    assert result[0].warnings
