"""A physics of one's own: what it adds to a state is printed, saved, drawn and judged like all else.

The physics is a lubricant of given pressure that fills the gap around the contact, and carries part of the load.
"""

import json

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._solve.solution import additions
from roughcontact.results import Condition
from roughcontact.typing import Addition
from unit_files import read_archive, write_archive

OIL = 2e6  # Pa


@additions.register("test-lubricant")
@attrs.frozen(eq=False)
class Lubricant(Addition):
    """A pressure in the gap, Pa, shape (nx, ny), and the load that it carries, N."""

    kind = "test-lubricant"

    pressure: np.ndarray
    load: float

    @property
    def conditions(self):
        return (Condition("lubricant", float(np.ptp(self.pressure[self.pressure > 0.0])) / OIL, "its unevenness"),)

    def list_rows(self, state):
        return {"lubricant": f"{self.load:.3g} N"}

    def list_numbers(self, state):
        return {"lubricant_load": (self.load, "N")}

    def list_columns(self, state):
        return {"lubricant_load": (self.load, "N")}

    def list_fields(self):
        return {"lubricant": (self.pressure, "pressure of the lubricant", "Pa")}


def fill(state):
    """Return a state with a lubricant in its gap."""
    pressure = np.where(state.contact, 0.0, OIL)
    return state._add(Lubricant(pressure, float(pressure.sum()) * state.grid.cell_area))


@pytest.fixture(scope="module")
def sweep():
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    found = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).sweep(force=[1.0, 2.0])
    return attrs.evolve(found, states=tuple(map(fill, found)))


def test_it_is_printed_and_judged(sweep):
    state = sweep[0]
    assert f"lubricant         {state.added[0].load:.3g} N" in str(state)
    assert state.certificate["lubricant"].residual == 0.0
    assert "lubricant 0.0e+00" in str(state.certificate)
    with pytest.raises(rc.InputError, match="There is no condition of this contact named 'cone'"):
        _ = state.certificate["cone"]


def test_answers_are_those_of_the_contact(sweep):
    dry = attrs.evolve(sweep[0], added=())
    assert sweep[0].area() == dry.area()
    assert sweep[0].stiffness() == dry.stiffness()


def test_it_is_a_column_of_the_table_and_a_number_of_the_data(sweep):
    loads = [state.added[0].load for state in sweep]
    assert sweep.table().columns["lubricant_load"] == loads
    assert sweep.table().units["lubricant_load"] == "N"
    found = json.loads(json.dumps(sweep[1].to_dict()))
    assert found["lubricant_load"] == {"value": loads[1], "unit": "N"}
    assert found["certificate"]["lubricant"] == 0.0


@pytest.mark.parametrize("ending", ["npz", "nc"])
def test_it_is_in_the_file(sweep, tmp_path, ending):
    sweep[0].save(tmp_path / f"state.{ending}")
    loaded = rc.load(tmp_path / f"state.{ending}")
    np.testing.assert_array_equal(loaded.added[0].pressure, sweep[0].added[0].pressure)
    assert loaded.added[0].load == sweep[0].added[0].load


def test_it_is_in_the_file_of_a_path(sweep, tmp_path):
    sweep.save(tmp_path / "sweep.npz")
    assert [one.added[0].load for one in rc.load(tmp_path / "sweep.npz")] == [one.added[0].load for one in sweep]


def test_a_file_builds_none_that_is_not_registered(sweep, tmp_path, monkeypatch):
    sweep[0].save(tmp_path / "state.npz")
    monkeypatch.setattr(Lubricant, "kind", "test-grease")
    sweep[0].save(tmp_path / "other.npz")
    with pytest.raises(rc.InputError, match="There is no addition to a state named 'test-grease'"):
        rc.load(tmp_path / "other.npz")


def test_its_field_is_in_datasets_and_in_image_data(sweep, tmp_path):
    found = sweep[0].to_xarray()["lubricant"]
    assert found.dims == ("x", "y")
    assert found.attrs == {"long_name": "pressure of the lubricant", "units": "Pa"}
    sweep[0].save(tmp_path / "state.vti")
    assert b'Name="lubricant"' in (tmp_path / "state.vti").read_bytes()


@pytest.mark.slow
def test_it_is_on_the_page(sweep):
    page = sweep[0].to_html()
    assert "<th>Lubricant" in page or "Lubricant</th>" in page
    assert "its unevenness" in page


@pytest.mark.parametrize("wrong", [None, "text", -1, [1, 2, 3]])
def test_wrong_numbers_of_a_path_get_a_sentence(tmp_path, wrong):
    """Notes beside the states, in a file that is whole otherwise."""
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    flat = rc.Body(rc.FlatSurface(), rc.Elastic(young=210e9, poisson=0.3))
    problem = rc.ContactProblem(ball, flat, grid=rc.Grid((16, 16), 100e-6))
    file = tmp_path / "path.npz"
    problem.path(force=1.0, tangential_force=[(0.1, 0.0)], friction=0.3).save(file)
    arrays, header = read_archive(file)
    for name in ("numbers", "increments", "reasons"):
        notes = {**header["notes"]["mapping"], name: wrong}
        write_archive(file, arrays, {**header, "notes": {"mapping": notes}})
        with pytest.raises(rc.InputError, match=r"The file path\.npz cannot be used"):
            rc.load(file, verify=False)
