"""The paper's Tables 1 and 2: all eighteen pressures and all eighteen areas."""

from __future__ import annotations

import numpy as np
import pytest

from roughcontact.paper import all_tables, printed, remarks, stand_in
from roughcontact.paper.scene import MATERIAL, problem, summit_positions

# Cells in contact as the printed percentages tell them; on the larger grids the print is too coarse.
CELLS = {
    50: (112, 284, 800, 2276),
    100: (156, 400, 1100, 3476),
    200: (224, 528, 1500, 5388),
}
GRIDS = [pytest.param(n, marks=pytest.mark.slow) if n == 2048 else n for n in printed.GRIDS]


@pytest.mark.parametrize("load", printed.LOADS)
@pytest.mark.parametrize("cells", GRIDS)
def test_table_1_maximum_pressure(cells, load, case_of):
    expected = printed.SAM_P_MAX[load][printed.GRIDS.index(cells)]
    assert case_of(cells, load).p_max == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("load", printed.LOADS)
@pytest.mark.parametrize("cells", GRIDS)
def test_table_2_real_contact_area(cells, load, case_of):
    """To one unit of the last printed digit: some are cut off, not rounded."""
    expected = printed.SAM_AREA[load][printed.GRIDS.index(cells)]
    assert abs(case_of(cells, load).area - expected) < 1.05e-3


@pytest.mark.parametrize("load", printed.LOADS)
@pytest.mark.parametrize("place", range(4))
def test_table_2_cells_in_contact(place, load, case_of):
    assert case_of(printed.GRIDS[place], load).contact_cells == CELLS[load][place]


def test_the_scene_is_the_papers():
    scene = problem(64)
    assert scene.plan.modulus == pytest.approx(219.78e9, rel=1e-5)
    assert 1 / MATERIAL.compliance == scene.plan.modulus
    heights = scene.body.surface.values
    np.testing.assert_allclose(heights, heights[::-1, ::-1], atol=1e-18)
    assert heights[0, 0] == pytest.approx(-1e-6)
    assert scene.plan.grid.spacing[0] == 250e-6 / 64


def test_the_summit_is_cut_out_where_it_is(case_of):
    case = case_of(512, 100)
    positions = summit_positions(case)
    i, j = np.nonzero(case.summit)
    assert np.abs(positions[i]).max() < 1.2e-6
    assert np.abs(np.hypot(positions[i], positions[j])).max() < 1.4e-6
    # Four hundred summits carry nearly the same contact.
    assert case.summit.sum() * 400 == pytest.approx(case.contact_cells, rel=0.2)


def test_tables_show_print_and_truth_beside_ours(case_of):
    cases = [case_of(cells, load) for load in printed.LOADS for cells in printed.GRIDS[:4]]
    pressure, area, extrapolated = all_tables(cases)
    assert len(pressure.rows) == len(area.rows) == 12
    assert len(extrapolated.rows) == 3
    for table in (pressure, area, extrapolated):
        assert all(len(row) == len(table.columns) for row in table.rows)
    assert area.rows[0][:4] == ("50", "64", "112", "2.734")
    assert any("not to be trusted" in note for note in extrapolated.notes)
    assert "0.807, 1.255, 1.982" in " ".join(remarks())


class TestStandIn:
    """The pair that stands in for the paper's unpublished maps."""

    def test_it_has_the_papers_steel_domain_and_ball(self):
        pair = stand_in.fresh(512)
        assert pair.plan.grid.size == (264.2e-6, 264.2e-6)
        assert pair.plan.limit == 6e9
        assert pair.plan.modulus == pytest.approx(210e9 / (2 * (1 - 0.3**2)))
        assert pair.body.surface.separate("sphere").radius == pytest.approx(5e-3, rel=0.02)

    def test_the_ring_has_its_lay_along_y(self):
        heights = stand_in.fresh(512).counter.surface.values
        across, along = (np.abs(np.diff(heights, axis=axis)).mean() for axis in (0, 1))
        assert across > 5 * along
        assert heights.std() == pytest.approx(0.2e-6, rel=1e-6)

    def test_coarse_maps_are_scaled_bilinearly(self):
        """Half as many cells: each the mean of two by two."""
        pair = stand_in.fresh(512)
        fine, coarse = pair.counter.surface.values, stand_in.scaled(pair, 256).counter.surface.values
        np.testing.assert_allclose(coarse, fine.reshape(256, 2, 256, 2).mean(axis=(1, 3)), atol=1e-20)

    @pytest.mark.slow
    def test_running_in_goes_on_where_it_stopped(self, tmp_path, monkeypatch):
        monkeypatch.setattr(stand_in, "PLACES", 2)
        pair, cycles = stand_in.fresh(512), []
        whole = stand_in.worn(pair, tmp_path / "whole.npz", cycles.append)

        class Stopped(Exception):
            pass

        def stop(result):
            cycles.append(result)
            if len(cycles) == count + 3:
                raise Stopped

        count = len(cycles)
        with pytest.raises(Stopped):
            stand_in.worn(pair, tmp_path / "maps.npz", stop)
        # The first round of two is kept, the third cycle is done again.
        rest = []
        again = stand_in.worn(pair, tmp_path / "maps.npz", rest.append)
        assert len(rest) == count - 2
        for one, other in ((whole.body, again.body), (whole.counter, again.counter)):
            np.testing.assert_array_equal(one.surface.values, other.surface.values)
        stand_in.worn(pair, tmp_path / "maps.npz", lambda _: pytest.fail("run in again"))

    @pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut short", b"\x93NUMPY"])
    def test_damaged_maps_are_made_again(self, tmp_path, monkeypatch, content):
        monkeypatch.setattr(stand_in, "PLACES", 1)
        monkeypatch.setattr(stand_in, "TOLERANCE", 1.0)
        (tmp_path / "maps.npz").write_bytes(content)
        cycles = []
        stand_in.worn(stand_in.fresh(512), tmp_path / "maps.npz", cycles.append)
        assert cycles
        # Another pair, or another way of running in, is not what the file holds.
        monkeypatch.setattr(stand_in, "RUN_IN_FORCE", 9.0)
        count = len(cycles)
        stand_in.worn(stand_in.fresh(512), tmp_path / "maps.npz", cycles.append)
        assert len(cycles) > count
