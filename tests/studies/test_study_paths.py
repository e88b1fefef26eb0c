"""Studies of paths with friction: files, records, continuation, shares, refusals."""

from __future__ import annotations

import contextlib
import csv
import shutil

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from unit_files import key_of, read_frictional_path, read_study, save_path

STUDY = """
[problems.long]
grid = {shape = [32, 12], size = [240e-6, 30e-6]}
body = {surface = {type = "sphere", radius = "1mm"}, material = {young = "210GPa", poisson = 0.3}}
counterbody = {surface = "flat", material = {young = "70GPa", poisson = 0.33}}
[problems.rough]
boundary = "periodic"
grid = {shape = [24, 24], size = 1e-4}
[problems.rough.body]
surface = {type = "self-affine", hurst = 0.8, rms_height = 1e-7, longest = 1e-4, shortest = 16e-6, seed = 5}
material = "bearing steel"
[problems.rough.counterbody]
surface = "flat"
material = "bearing steel"
[study]
force = ["0.2N", "0.4N"]
tangential_force = [["20mN", 0.0], ["-20mN", "5mN"]]
friction = {type = "limited-coulomb", coefficient = 0.3, strength = "2GPa"}
substeps = 2
fields = true
"""


SLIPPING = rc.responses.create("partial-slip", tangential_force=0.1, friction=0.3)


@pytest.fixture
def study_file(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The study, and its results in a folder."""
    folder = tmp_path_factory.mktemp("paths")
    (folder / "study.toml").write_text(STUDY)
    study = read_study(folder / "study.toml")
    return study, study.run(folder / "all")


def numbers(record):
    area = record.areas["blend"]
    return (record.key, record.status, record.dissipated, record.stick_area, record.approach, *area, record.warnings)


@pytest.mark.slow
def test_the_records_are_those_of_paths_by_hand(finished):
    study, result = finished
    assert [(record.problem, record.load) for record in result] == [
        (name, load) for name in ("long", "rough") for load in (0.2, 0.4)
    ]
    law = rc.LimitedCoulomb(0.3, 2e9)
    loads = [(0.02, 0.0), (-0.02, 0.005)]
    for record in result:
        path = study.problems[record.problem].path(force=record.load, tangential_force=loads, friction=law, substeps=2)
        assert record.status == "CONVERGED"
        assert record.dissipated == path.dissipated.value > 0.0
        assert record.dissipated_uncertainty == path.dissipated.uncertainty
        assert record.stick_area == path.numbers[-1].stick_area.value
        assert record.areas["blend"][0] == path[-1].area().value
        assert set(path.warnings) <= set(record.warnings)
        saved = rc.FrictionalPath.load(result.folder / f"{record.key}.npz", verify=True)
        assert len(result.path(record)) == len(saved) == 2
        np.testing.assert_array_equal(saved[-1].shear, path[-1].shear)
        assert result.solution(record).force == path[-1].force


def test_the_time_of_a_record_is_that_of_all_its_states(finished):
    _, result = finished
    for record in result:
        path = result.path(record)
        assert record.seconds == pytest.approx(path.pressed.seconds + sum(state.seconds for state in path))
        assert path.pressed.seconds > 0.0


def test_answers_are_those_of_the_state_at_the_end_of_the_path(tmp_path):
    """The stress counts the traction, which raises it by two thirds here, also where records are read again."""
    steel = rc.Elastic(210e9, 0.3)
    grid = rc.Grid((39, 13), (300e-6, 300e-6))
    problem = rc.ContactProblem(rc.Body(rc.SphereSurface(0.01), steel), rc.Body(rc.FlatSurface(), steel), grid=grid)
    along = {"tangential_force": [(0.0, -2.8)], "friction": 0.6, "substeps": 1}
    state = problem.path(force=5.0, **along)[-1]
    study = rc.Study({"ball": problem}, force=[5.0], responses=["stress", "stiffness"], **along)
    found = study.run(tmp_path)[0].answers
    expected = state.stress().maximum
    assert found["stress"].numbers["von_mises"][:2] == (expected.value, expected.uncertainty)
    assert expected.value > 1.5 * problem.solve(force=5.0).stress().maximum.value
    assert found["stiffness"].numbers[""][0] == state.response("stiffness").value == state.stiffness().value
    (tmp_path / "records.json").unlink(missing_ok=True)
    assert study.run(tmp_path)[0].answers == found


@pytest.mark.parametrize("own", [{"friction": 0.3}, {"traction": np.zeros((2, 16, 48))}])
def test_a_state_has_its_own_traction(own):
    steel = rc.Elastic(210e9, 0.3)
    grid = rc.Grid((16, 48), (300e-6, 300e-6))
    problem = rc.ContactProblem(rc.Body(rc.SphereSurface(0.01), steel), rc.Body(rc.FlatSurface(), steel), grid=grid)
    state = problem.path(force=5.0, tangential_force=[(1.0, 0.0)], friction=0.6, substeps=1)[-1]
    with pytest.raises(rc.InputError, match=f"The state has its own traction: omit {next(iter(own))}="):
        state.response(rc.responses.create("stress", **own))


def test_it_goes_on_where_it_stopped(finished, tmp_path):
    study, result = finished
    assert result.computed == 4
    first = study.run(tmp_path / "again")
    assert study.run(tmp_path / "again").computed == 0
    (tmp_path / "again" / f"{first[1].key}.npz").unlink()
    damaged = tmp_path / "again" / f"{first[2].key}.npz"
    damaged.write_bytes(damaged.read_bytes()[:-2000])
    # A path of other loads in its place.
    (tmp_path / "again" / f"{first[3].key}.npz").write_bytes((tmp_path / "again" / f"{first[0].key}.npz").read_bytes())
    again = study.run(tmp_path / "again")
    assert again.computed == 3
    assert list(map(numbers, again)) == list(map(numbers, result))


@attrs.frozen
class Saturating(rc.FrictionLaw):
    """A friction law that nobody has registered."""

    strength: float

    def limit(self, pressure):
        return self.strength * np.tanh(0.3 * pressure / self.strength)


def like_pair(**changes):
    """A ball in a domain eight times as long as wide, with cells 1:3 and odd numbers of them."""
    steel = rc.Elastic(210e9, 0.3)
    bodies = rc.Body(rc.SphereSurface(1e-3), steel), rc.Body(rc.FlatSurface(), steel)
    problem = rc.ContactProblem(*bodies, grid=rc.Grid((25, 9), (240e-6, 30e-6)))
    along = {"tangential_force": [(0.02, 0.0), (-0.02, 0.003)], "friction": 0.3}
    return rc.Study(problem, **{"force": [0.1, 0.2], "fields": True, **along, **changes})


@contextlib.contextmanager
def forbidden(monkeypatch, *names):
    """No path is followed or verified, unless other methods are named."""
    with monkeypatch.context() as context:
        for cls, name in names or ((rc.ContactProblem, "path"), (rc.ContactProblem, "verify")):
            context.setattr(cls, name, lambda *_, **__: pytest.fail("computed again"))
        yield


@pytest.mark.slow
@pytest.mark.parametrize("changed", [{"friction": 0.6}, {"substeps": 3}])
def test_a_file_of_another_law_or_other_increments_is_followed_again(tmp_path, changed):
    """The loads are the same: only the key tells them apart."""
    first = like_pair().run(tmp_path)
    other = like_pair(**changed).run(tmp_path)
    for one, two in zip(first, other, strict=True):
        shutil.copy(tmp_path / f"{one.key}.npz", tmp_path / f"{two.key}.npz")
    with pytest.raises(rc.InputError, match="does not hold the path with the key"):
        other.path(other[0])
    again = like_pair(**changed).run(tmp_path)
    assert again.computed == 2
    assert list(map(numbers, again)) == list(map(numbers, other))


def test_a_displacement_is_not_a_force_of_the_same_number(tmp_path):
    small = [(1e-9, 0.0)]
    moved = like_pair(tangential_force=None, displacement=small).run(tmp_path)
    pushed = like_pair(tangential_force=small)
    (chain,) = pushed.chains()
    for key, record in zip(chain.solution_keys(), moved, strict=True):
        shutil.copy(tmp_path / f"{record.key}.npz", tmp_path / f"{key}.npz")
    result = pushed.run(tmp_path)
    assert result.computed == 2
    assert result.path(result[0])[0].tangential_force[0] == pytest.approx(1e-9)


def test_parts_that_nobody_registered_are_not_followed_again(tmp_path, monkeypatch):
    study = like_pair(friction=Saturating(2e8))
    first = study.run(tmp_path)
    assert not first.failed
    with forbidden(monkeypatch):
        again = study.run(tmp_path)
    assert again.computed == 0
    assert again.records == first.records
    with pytest.raises(rc.InputError, match="Saturating must be registered"):
        again.path(again[0])


def test_a_finished_study_takes_the_areas_from_its_list(tmp_path, monkeypatch):
    first = like_pair(areas=["blend", "cell-count"]).run(tmp_path)
    with forbidden(monkeypatch, (rc.ContactSolution, "peak_pressure"), (rc.ContactProblem, "path")):
        again = like_pair(areas=["blend", "cell-count"]).run(tmp_path)
    assert again.records == first.records
    assert again.computed == 0
    more = like_pair(areas=["perimeter"]).run(tmp_path)
    assert more.computed == 0
    assert all({"perimeter", "cell-count"} <= set(record.areas) for record in more)


def test_without_the_list_the_states_are_verified(tmp_path, monkeypatch):
    """A file with its seal whose last traction is not in equilibrium."""
    study = like_pair(force=[0.2])
    (record,) = study.run(tmp_path)
    file = tmp_path / f"{record.key}.npz"
    path = read_frictional_path(file, verify=False)
    end = attrs.evolve(path[-1], added=(attrs.evolve(path[-1].sheared, traction=0.9 * path[-1].shear),))
    save_path(file, attrs.evolve(path, states=(path[0], end)), record.key)
    for index in tmp_path.glob("study-*.json"):
        index.unlink()
    again = study.run(tmp_path)
    assert again.computed == 1
    assert list(map(numbers, again)) == [numbers(record)]


def test_a_study_is_as_doubtful_as_its_paths(tmp_path):
    """Loads that turn, in given increments, whose error is not known; one load along a line has none."""
    doubtful = like_pair(substeps=2, tangential_force=[(0.02, 0.0), (0.0, 0.02)]).run(tmp_path)
    sure = like_pair(tangential_force=[(0.02, 0.0)]).run(tmp_path)
    for result in (doubtful, sure):
        for record in result:
            path = result.path(record)
            assert record.doubtful == bool(path.warnings)
            assert record.seconds >= sum(state.seconds for state in path)
    assert all(record.doubtful for record in doubtful)


def test_shares_are_one_run(finished, tmp_path):
    study, result = finished
    parts = [study.run(tmp_path, share=(k, 2)) for k in (1, 2)]
    assert sum(part.computed for part in parts) == 4
    whole = study.run(tmp_path)
    assert whole.computed == 0
    assert list(map(numbers, whole)) == list(map(numbers, result))


def test_the_command_prints_and_writes_the_energy(study_file, capsys):
    assert main(["run", str(study_file), "--dry-run"]) == 0
    plan = " ".join(capsys.readouterr().out.split())
    assert "path tangential force (20 mN, 0 N), (-20 mN, 5 mN) under each normal load; LimitedCoulomb(" in plan
    assert "for the normal contacts alone" in plan
    assert "omitted friction" not in plan
    assert "coupling normal and tangential solves in turn" in plan
    assert main(["run", str(study_file)]) in (0, 3)
    out = capsys.readouterr().out
    assert "energy lost" in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 80
    rows = list(csv.DictReader((study_file.with_suffix("") / "records.csv").read_text().splitlines()))
    assert len(rows) == 4
    assert all(float(row["dissipated [J]"]) > 0.0 and float(row["stick_area [m2]"]) > 0.0 for row in rows)


@pytest.mark.slow
def test_a_load_that_slides_is_refused_in_its_record(finished, tmp_path):
    study, _ = finished
    problem = study.problems["long"]
    result = rc.Study(problem, force=[0.1, 1.0], tangential_force=[(0.1, 0.0)], friction=0.3).run(tmp_path)
    assert [record.status for record in result] == ["REFUSED", "CONVERGED"]
    assert "slide" in result[0].message
    with pytest.raises(rc.InputError, match="This record has no path"):
        result.path(result[0])
    frame = result.to_pandas()
    assert np.isnan(frame["dissipated"][0])
    assert frame["dissipated"][1] >= 0.0
    assert float(result.to_xarray()["stick_area"].isel(load=1).item()) == result[1].stick_area


def test_axes_of_a_function_have_paths(finished, tmp_path):
    def build(young):
        steel = rc.Elastic(young, 0.3)
        bodies = rc.Body(rc.SphereSurface(1e-3), steel), rc.Body(rc.FlatSurface(), steel)
        return rc.ContactProblem(*bodies, grid=rc.Grid((16, 16), 100e-6))

    result = rc.Study(build, young=[70e9, 210e9], force=[0.5], displacement=[(20e-9, 0.0)], friction=0.3).run(tmp_path)
    path = build(210e9).path(force=0.5, displacement=[(20e-9, 0.0)], friction=0.3)
    assert result[1].dissipated == path.dissipated.value


def test_studies_without_friction_keep_their_keys():
    body = rc.Body(rc.SphereSurface(1e-3), rc.Elastic(210e9, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((16, 16), 100e-6))
    plain = rc.Study(problem, force=[1.0])
    sheared = [
        rc.Study(problem, force=[1.0], tangential_force=[(0.1, y)], friction=mu, substeps=n)
        for y, mu, n in ((0.0, 0.3, "auto"), (0.05, 0.3, "auto"), (0.0, 0.4, "auto"), (0.0, 0.3, 2))
    ]
    assert plain.key == key_of([{"problem": problem.parts}, [{"force": 1.0}], ()])[:12]
    assert len({plain.key, *(study.key for study in sheared)}) == 5
    assert not {"dissipated", "stick_area"} & set(
        rc.results.Record(problem="a", seed=None, control="force", load=1.0, key="0" * 32, status="FAILED").row()
    )


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"friction": None}, "give friction=0.3, for example"),
        ({"tangential_force": None}, "Friction is for loads along the surface"),
        ({"displacement": [(1e-9, 0.0)]}, "Give tangential_force= or displacement="),
        ({"tangential_force": [1.0]}, "pairs (x, y) in N"),
        ({"responses": rc.responses.create("first-yield", 1e9)}, "'first-yield' is not for a contact with friction"),
        ({"responses": ["stress", SLIPPING]}, "'partial-slip' is not for a contact with fric"),
        ({"substeps": 0}, "substeps= must be a whole number of at least 1"),
        ({"friction": -0.3}, "The coefficient of friction"),
        ({"friction": "glue"}, "friction= must be a coefficient or a FrictionLaw"),
    ],
)
def test_what_does_not_fit_is_refused(finished, changed, words):
    study, _ = finished
    arguments = {"force": [1.0], "tangential_force": [(0.1, 0.0)], "friction": 0.3, **changed}
    with pytest.raises(rc.InputError) as caught:
        rc.Study(study.problems["long"], **arguments)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"limited-coulomb"', '"coulom"', "Did you mean 'coulomb'?"),
        ('"2GPa"', '"2N"', "is not a quantity in units of Pa"),
        ('[["20mN", 0.0], ["-20mN", "5mN"]]', '["20mN"]', "pairs (x, y) in N"),
        ('"20mN", 0.0', '"20m", 0.0', "is not a quantity in units of N"),
        ('boundary = "periodic"', 'boundary = "wrapped"', "A wrapped boundary has no response to shear"),
    ],
)
def test_what_is_wrong_in_a_file_is_a_sentence(study_file, capsys, old, new, words):
    study_file.write_text(STUDY.replace(old, new))
    assert main(["run", str(study_file), "--dry-run"]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert "@ study" in error


def test_a_number_in_a_file_is_a_coefficient(study_file):
    text = STUDY[: STUDY.index("friction =")] + "friction = 0.25\n"
    study_file.write_text(text)
    assert read_study(study_file).loading.friction.coefficient == 0.25
