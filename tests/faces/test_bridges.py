"""Results in pandas, xarray, VTK and SurfaceTopography, and what comes from there: the same numbers and places."""

from __future__ import annotations

import csv
import inspect
import re
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Elastic(210e9, 0.3)
GRID = rc.Grid((24, 16), (3e-4, 2e-4))
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=5e-5, longest=2e-4, seed=3)
PROBLEM = rc.ContactProblem(rc.Body(ROUGH, STEEL), grid=GRID)
LOADS = [0.5, 1.0, 2.0]
SWEEP = PROBLEM.sweep(force=LOADS)
SOLUTION = SWEEP.states[1]


def hide(monkeypatch, package):
    """Let a package not be installed."""
    monkeypatch.setitem(sys.modules, package, None)


def draw_3d(subject, **settings):
    """Return the view of a solution or surface, without a window."""
    pyvista = pytest.importorskip("pyvista")
    pyvista.OFF_SCREEN = True
    return subject.plot_3d(**settings)


class TestSweep:
    def test_it_is_a_sequence_of_its_solutions(self):
        assert len(SWEEP) == 3
        assert list(SWEEP) == list(SWEEP.states)
        assert SWEEP[1] is SOLUTION
        assert SWEEP[-1] is SWEEP.states[2]
        assert SWEEP[np.int64(0)] is SWEEP.states[0]
        assert SWEEP[1:].states == SWEEP.states[1:]
        assert [solution.force for solution in reversed(SWEEP)] == pytest.approx(LOADS[::-1])

    def test_secants_are_chords_between_neighbours_in_load(self):
        force, approach = SWEEP.force, SWEEP.approach
        expected = [(force[b] - force[a]) / (approach[b] - approach[a]) for a, b in ((0, 1), (0, 2), (1, 2))]
        np.testing.assert_allclose(SWEEP.secant_stiffness, expected)

    @pytest.mark.parametrize("order", [(2, 0, 1), (1, 1, 0, 2, 1)])
    def test_secants_do_not_depend_on_the_order_of_the_loads_or_their_number(self, order):
        sweep = PROBLEM.sweep(force=[LOADS[place] for place in order])
        np.testing.assert_allclose(sweep.secant_stiffness, SWEEP.secant_stiffness[list(order)], rtol=1e-3)
        sweep = PROBLEM.sweep(approach=[float(SWEEP.approach[place]) for place in order])
        np.testing.assert_allclose(sweep.secant_stiffness, SWEEP.secant_stiffness[list(order)], rtol=1e-3)

    @pytest.mark.parametrize("loads", [[1.0], [1.0, 1.0]])
    def test_one_load_has_no_secant(self, loads):
        sweep = PROBLEM.sweep(force=loads)
        assert np.isnan(sweep.secant_stiffness).all()
        assert str(sweep).splitlines()[-1].endswith(" -")
        assert "nan" not in str(sweep) + sweep._repr_html_()

    @pytest.mark.parametrize("index", [3, -4, True, 1.0, "area", None, slice(5, 9), slice("a", None)])
    def test_a_wrong_index_is_said(self, index):
        with pytest.raises(rc.InputError, match=r"The index of a sweep must be a (whole number from 0 to 2|slice of)"):
            SWEEP[index]

    def test_a_data_frame_has_a_row_for_each_load_and_knows_its_units(self):
        pandas = pytest.importorskip("pandas")
        frame = SWEEP.to_pandas()
        assert isinstance(frame, pandas.DataFrame)
        for name in ("force", "mean_pressure", "approach", "area", "area_uncertainty", "secant_stiffness"):
            np.testing.assert_array_equal(frame[name], getattr(SWEEP, name))
        assert frame.area_fraction[1] == SOLUTION.area().fraction
        assert frame.peak_pressure[1] == SOLUTION.peak_pressure().value
        assert set(frame.attrs["units"]) == set(frame.columns)
        assert frame.attrs["units"]["area"] == "m2"
        # It may be changed: nothing of the sweep is.
        frame.loc[0, "area"] = 0.0
        assert SWEEP.area[0] > 0.0

    def test_a_dataset_has_the_fields_at_their_places(self):
        pytest.importorskip("xarray")
        dataset = SWEEP.to_xarray()
        assert dict(dataset.sizes) == {"load": 3, "x": 24, "y": 16}
        np.testing.assert_array_equal(dataset["load"], LOADS)
        assert dataset["load"].units == "N"
        np.testing.assert_array_equal(dataset.pressure.sel(load=1.0), SOLUTION.pressure)
        np.testing.assert_array_equal(dataset.gap.isel(load=2), SWEEP[2].gap)
        np.testing.assert_array_equal(dataset.area, SWEEP.area)
        # The force is the integral of the pressure over x and y.
        force = dataset.pressure.integrate("x").integrate("y")
        np.testing.assert_allclose(force, dataset.force, rtol=0.2)
        peak = dataset.pressure.isel(load=1).argmax(("x", "y"))
        assert float(dataset.x[peak["x"]]) == GRID.x[np.unravel_index(SOLUTION.pressure.argmax(), GRID.shape)[0], 0]

    def test_a_csv_file_has_all_digits_and_the_units(self, tmp_path):
        SWEEP.to_csv(tmp_path / "sweep.csv")
        with (tmp_path / "sweep.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        assert [float(row["area [m2]"]) for row in rows] == SWEEP.area.tolist()
        assert [float(row["area_fraction [1]"]) for row in rows] == [one.area().fraction for one in SWEEP]

    def test_it_prints_in_80_columns_with_the_uncertainty(self):
        heavy = PROBLEM.sweep(pressure=[1.234567e9])
        for sweep in (SWEEP, heavy):
            assert max(map(len, str(sweep).splitlines())) <= 80
        assert "+-" in str(SWEEP)
        assert repr(SWEEP).startswith("<Sweep 3 loads, mean pressure 8.333 MPa to 33.33 MPa")
        assert "<Sweep 1 load," in repr(heavy)

    @pytest.mark.parametrize(("package", "method"), [("pandas", "to_pandas"), ("xarray", "to_xarray")])
    def test_an_absent_package_is_named_with_its_extra(self, monkeypatch, package, method):
        hide(monkeypatch, package)
        with pytest.raises(rc.MissingPackage, match=r"pip install 'roughcontact\[(table|store)\]'"):
            getattr(SWEEP, method)()


def read_vti(path):
    """Return origin, spacing and arrays of a file, read by its format alone: XML, then lengths and values."""
    content = path.read_bytes()
    head, _, rest = content.partition(b'<AppendedData encoding="raw">\n_')
    root = ElementTree.fromstring(head + b"</VTKFile>")
    image = root.find("ImageData")
    assert root.get("byte_order") == f"{sys.byteorder.capitalize()}Endian"
    arrays = {}
    for item in root.iter("DataArray"):
        offset = int(item.get("offset"))
        (length,) = struct.unpack_from("=Q", rest, offset)
        kind = {"Float64": np.float64, "UInt8": np.uint8}[item.get("type")]
        arrays[item.get("Name")] = np.frombuffer(rest[offset + 8 : offset + 8 + length], kind)
    numbers = {name: [float(one) for one in image.get(name).split()] for name in ("Origin", "Spacing", "WholeExtent")}
    return numbers, arrays


class TestVtk:
    def test_a_file_of_image_data_is_what_its_format_says(self, tmp_path):
        SOLUTION.save(tmp_path / "contact.vti")
        numbers, arrays = read_vti(tmp_path / "contact.vti")
        assert numbers["WholeExtent"] == [0, 24, 0, 16, 0, 0]
        # The centre of the domain is the origin, and x varies fastest.
        assert numbers["Origin"] == [-1.5e-4, -1e-4, 0.0]
        assert numbers["Spacing"][:2] == list(GRID.spacing)
        for name in ("pressure", "gap", "initial_gap", "displacement"):
            np.testing.assert_array_equal(arrays[name].reshape(16, 24).T, getattr(SOLUTION, name))
        np.testing.assert_array_equal(arrays["contact"].reshape(16, 24).T, SOLUTION.contact)
        np.testing.assert_array_equal(arrays["heights"].reshape(16, 24).T, ROUGH.heights(GRID))
        assert arrays["force"] == [SOLUTION.force]
        assert arrays["area_uncertainty"] == [SOLUTION.area().uncertainty]
        # Nothing says anything about a flat counterbody.
        assert "counterbody_heights" not in arrays

    def test_a_solution_without_its_problem_has_no_heights(self, tmp_path):
        attrs.evolve(SOLUTION, origin=None).save(tmp_path / "contact.vti")
        _, arrays = read_vti(tmp_path / "contact.vti")
        assert "heights" not in arrays
        assert arrays["pressure"].size == GRID.cells

    def test_non_measured_points_and_a_second_rough_body_are_in_it(self, tmp_path):
        heights = ROUGH.heights(GRID)
        mask = heights < np.quantile(heights, 0.1)
        body = rc.Body(rc.HeightMap(heights, GRID.size, non_measured=mask), STEEL)
        rc.ContactProblem(body, rc.Body(ROUGH, STEEL)).solve(force=1.0).save(tmp_path / "contact.vti")
        _, arrays = read_vti(tmp_path / "contact.vti")
        np.testing.assert_array_equal(arrays["non_measured"].reshape(16, 24).T, mask)
        np.testing.assert_array_equal(arrays["counterbody_heights"], arrays["heights"])

    def test_vtk_reads_what_pyvista_is_given(self, tmp_path):
        pyvista = pytest.importorskip("pyvista")
        SOLUTION.save(tmp_path / "contact.vti")
        read, given = pyvista.read(tmp_path / "contact.vti"), SOLUTION.to_pyvista()
        assert read.dimensions == given.dimensions == (25, 17, 1)
        assert set(read.cell_data) == set(given.cell_data)
        for name in given.cell_data:
            np.testing.assert_array_equal(read.cell_data[name], given.cell_data[name])
        for name in given.field_data:
            np.testing.assert_array_equal(read.field_data[name], given.field_data[name])
        x, y, _ = read.cell_centers().points[np.argmax(read.cell_data["pressure"])]
        where = np.unravel_index(SOLUTION.pressure.argmax(), GRID.shape)
        np.testing.assert_allclose([x, y], [GRID.x[where[0], 0], GRID.y[0, where[1]]], rtol=1e-6)

    def test_a_view_has_the_heights_and_pressures_of_the_solution(self):
        view = draw_3d(SOLUTION, exaggeration=50.0)
        (mesh,) = view.meshes
        heights = -SOLUTION.initial_gap
        # In longer sides of the domain, 50 times as high.
        raised = 50.0 * (heights - heights.mean()) / 3e-4
        np.testing.assert_allclose(mesh.points[:, 2].reshape(16, 24).T, raised, atol=1e-6)
        np.testing.assert_allclose(
            mesh.points[:, 0].reshape(16, 24).T * 3e-4, np.broadcast_to(GRID.x, GRID.shape), rtol=1e-5
        )
        drawn = mesh.point_data["pressure, GPa"].reshape(16, 24).T
        np.testing.assert_array_equal(np.isnan(drawn), ~SOLUTION.contact)
        np.testing.assert_allclose(drawn[SOLUTION.contact], 1e-9 * SOLUTION.pressure[SOLUTION.contact])

    def test_a_view_of_a_capped_contact_in_dark_shows_where_it_is_saturated(self):
        steel = rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness=6e9)
        solution = rc.ContactProblem(rc.Body(ROUGH, steel), grid=GRID).solve(force=5.0)
        assert solution.saturated.any()
        view = draw_3d(solution, dark=True)
        (mesh,) = view.meshes
        np.testing.assert_array_equal((mesh.point_data["pressure, GPa"] > 6.0).reshape(16, 24).T, solution.saturated)
        picture = view.screenshot(return_img=True)
        assert picture.shape == (900, 1200, 3)
        # Saturated cells and their colour bar are orange, (255, 140, 66), before the light falls on them.
        assert (np.ptp(picture.astype(int), axis=2) > 120).sum() > 1000

    @pytest.mark.parametrize("heights", [np.zeros((8, 6)), np.where(np.arange(48).reshape(8, 6) == 20, np.nan, 1e-7)])
    def test_flat_and_partly_measured_surfaces_have_a_view(self, heights):
        view = draw_3d(rc.HeightMap(np.nan_to_num(heights), (8e-6, 6e-6), non_measured=np.isnan(heights)))
        (mesh,) = view.meshes
        assert np.isnan(mesh.active_scalars).sum() == np.isnan(heights).sum()
        assert np.isfinite(mesh.points).all()

    @pytest.mark.parametrize("wrong", [{"exaggeration": 0.0}, {"exaggeration": "high"}, {"dark": "yes"}])
    def test_a_wrong_setting_of_a_view_is_said(self, wrong):
        pytest.importorskip("pyvista")
        with pytest.raises(rc.InputError, match=next(iter(wrong))):
            SOLUTION.plot_3d(**wrong)

    def test_without_pyvista_the_file_is_written_and_the_view_named(self, tmp_path, monkeypatch):
        hide(monkeypatch, "pyvista")
        SOLUTION.save(tmp_path / "contact.vti")
        with pytest.raises(rc.MissingPackage, match=r"roughcontact\[vtk\]"):
            SOLUTION.to_pyvista()
        with pytest.raises(rc.MissingPackage, match=r"roughcontact\[vtk\]"):
            SOLUTION.plot_3d()


BLOCKS = re.findall(
    r"```py\n(.*?)```", (Path(__file__).parents[2] / "docs" / "use" / "results.md").read_text("utf-8"), re.S
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("block", "package", "file"), [*zip(BLOCKS, ["pyvista", "SurfaceTopography"], ["contact.png", ""], strict=True)]
)
def test_blocks_of_the_page_that_need_a_package_run(block, package, file, tmp_path):
    pytest.importorskip(package)
    done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert not file or (tmp_path / file).stat().st_size > 10_000


@attrs.frozen
class Topography:
    """What a map reads of a topography of SurfaceTopography."""

    values: np.ndarray
    unit: str | None = "m"
    dim: int = 2
    is_periodic: bool = False
    is_domain_decomposed: bool = False
    physical_sizes: tuple = (3e-4, 2e-4)

    def heights(self):
        return self.values

    def to_unit(self, unit):
        factor = {"m": 1.0, "µm": 1e-6}[self.unit] / {"m": 1.0}[unit]
        sizes = tuple(factor * side for side in self.physical_sizes)
        return attrs.evolve(self, values=self.values * factor, unit=unit, physical_sizes=sizes)


class TestUnits:
    """Quantities of pint, wherever a text with a unit may stand."""

    @pytest.fixture
    def pint(self):
        return pytest.importorskip("pint").UnitRegistry().Quantity

    def test_they_mean_what_texts_mean(self, pint):
        given = {"Pa": pint(210, "GPa"), "m": pint(5, "mm"), "J/m2": pint(50, "mJ/m**2"), "rad": pint(30, "deg")}
        assert rc.Elastic(given["Pa"], pint(30, "percent")).young == pytest.approx(210e9)
        assert rc.SphereSurface(given["m"]).radius == pytest.approx(5e-3)
        assert rc.ShortRange(work=given["J/m2"]).work == pytest.approx(0.05)
        rough = {"hurst": 0.8, "rms_slope": 0.1, "shortest": pint(5, "um"), "longest": "50um", "lay": given["rad"]}
        assert rc.SelfAffineSurface(**rough).lay == pytest.approx(np.pi / 6.0)
        for size in (pint([300, 200], "um"), (pint(0.3, "mm"), "0.2mm")):
            assert rc.Grid((24, 16), size).size == pytest.approx(GRID.size)
            found = rc.HeightMap(pint(1e6 * ROUGH.heights(GRID), "um"), size=size)
            np.testing.assert_allclose(found.values, ROUGH.heights(GRID))
        forces = [state.force for state in PROBLEM.sweep(force=pint([0.5, 1.0], "N"))]
        assert forces == pytest.approx([0.5, 1.0])
        assert SOLUTION.stress(depths=pint([1, 2], "um")).depths == pytest.approx([1e-6, 2e-6])
        flow = SOLUTION.leakage(viscosity=pint(1, "mPa*s"), pressure_drop=pint(1, "bar"))
        assert flow.value == SOLUTION.leakage(viscosity="1mPa.s", pressure_drop="1bar").value
        assert SOLUTION.conductance(conductivity=pint(45, "W/m/K")).value == SOLUTION.conductance(conductivity=45).value
        wanted = PROBLEM.solve_for(area=pint(0.002, "mm**2"))
        stiff = PROBLEM.solve_for(stiffness=pint(2, "MN/m"))
        assert stiff.wanted == pytest.approx(2e6)
        assert wanted.wanted == pytest.approx(0.002e-6)

    def test_of_another_dimension_they_are_refused(self, pint):
        for call in (rc.SphereSurface, lambda one: rc.Grid((8, 8), one), lambda one: rc.Elastic(one, 0.3)):
            with pytest.raises(rc.InputError, match="'3 newton' is not a quantity in units of"):
                call(pint(3, "N"))
        with pytest.raises(rc.InputError, match="not a plain number"):
            rc.Elastic(1e9, pint(3, "N"))

    def test_of_uncertainties(self):
        uncertainties = pytest.importorskip("uncertainties")
        found = SOLUTION.stiffness().to_ufloat() / SOLUTION.area().to_ufloat()
        assert isinstance(found, uncertainties.UFloat)
        assert found.nominal_value == pytest.approx(SOLUTION.stiffness().value / SOLUTION.area().value)


def make_array(axes=("x", "y"), heights="um", places="mm", **stated):
    """Return the rough heights as an array of xarray, in these units."""
    xarray = pytest.importorskip("xarray")
    units = {} if places is None else {"units": places}
    along = {axis: (axis, 1e3 * getattr(GRID, axis).ravel(), units) for axis in "xy"}
    stated |= {} if heights is None else {"units": heights}
    return xarray.DataArray(1e6 * ROUGH.heights(GRID), dims=("x", "y"), coords=along, attrs=stated, name="z").transpose(
        *axes
    )


class TestArraysOfXarray:
    HEIGHTS = ROUGH.heights(GRID)

    @pytest.mark.parametrize("axes", ["xy", "yx"])
    def test_axes_sides_and_units_are_its_own(self, axes):
        array = make_array(axes)
        for same in (array, array.isel(y=slice(None, None, -1)), array.expand_dims("t")):
            found = rc.read_surface(same)
            assert found.grid.matches(GRID)
            np.testing.assert_allclose(found.values, self.HEIGHTS, rtol=1e-12)
            assert found.history[0].startswith("read from the array 'z': 24 x 16 cells")

    def test_gaps_are_non_measured_points(self):
        array = make_array().where(lambda heights: heights < heights.quantile(0.9))
        with pytest.raises(rc.InputError, match="array 'z' 39 of 384 points were not measured"):
            rc.read_surface(array)
        assert rc.read_surface(array, non_measured="keep").non_measured.sum() == 39

    def test_what_a_solution_gives_is_read_again(self):
        found = rc.read_surface(SOLUTION.to_xarray()["gap"])
        assert found.grid.matches(GRID)
        np.testing.assert_array_equal(found.values, SOLUTION.gap)

    def test_what_it_does_not_state_may_be_given(self):
        found = rc.read_surface(make_array(heights=None, places=None), unit="um", size=GRID.size)
        np.testing.assert_allclose(found.values, self.HEIGHTS, rtol=1e-12)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (lambda: make_array(heights=None), "heights in the array 'z' are numbers without a unit"),
            (lambda: make_array(heights="Pa"), "states values in 'Pa', which is not a known unit of length"),
            (lambda: make_array(places=None), "array 'z' does not state the size of its domain"),
            (lambda: make_array(places="s"), "apart in 's'"),
            (lambda: make_array().isel(x=[0, 1, 2, 5]), "its positions x are not regular"),
            (lambda: make_array().rename(x="a"), "its axes, 'a', 'y', must be two, named 'x' and 'y'"),
            (lambda: make_array().isel(x=0), "its axes, 'y', must be two"),
            (lambda: make_array(scale=2.0), "'scale = 2.0', which changes what its numbers mean"),
            (lambda: make_array(positive="down"), "'positive = down', which changes"),
            (lambda: make_array().to_dataset(), "it is a set of arrays: give one of them, such as 'z'"),
            (lambda: make_array() > 0, "it must hold real numbers"),
        ],
    )
    def test_what_it_does_not_say_is_refused(self, change, words):
        with pytest.raises(rc.InputError, match=words):
            rc.read_surface(change())

    def test_options_of_files_are_refused(self):
        for options in ({"reader": "npz"}, {"skip_rows": 2}, {"unit": "nm"}, {"size": 1e-3}):
            with pytest.raises(rc.InputError):
                rc.read_surface(make_array(), **options)

    def test_its_axes_are_never_taken_for_others(self):
        with pytest.raises(rc.InputError, match="an array with named axes: read_surface takes it"):
            rc.HeightMap(make_array("yx"), size=1e-3)


class TestTopography:
    HEIGHTS = ROUGH.heights(GRID)

    @pytest.mark.parametrize("periodic", [True, False])
    def test_a_map_comes_back_bit_for_bit(self, periodic):
        pytest.importorskip("SurfaceTopography")
        height_map = rc.HeightMap(self.HEIGHTS, GRID.size, periodic=periodic)
        topography = height_map.to_topography()
        assert (topography.unit, topography.is_periodic, topography.nb_grid_pts) == ("m", periodic, GRID.shape)
        again = rc.HeightMap.from_topography(topography)
        np.testing.assert_array_equal(again.values, self.HEIGHTS)
        assert (again.size, again.periodic) == (GRID.size, periodic)

    def test_non_measured_points_come_back(self):
        pytest.importorskip("SurfaceTopography")
        heights = self.HEIGHTS
        mask = heights > np.quantile(heights, 0.9)
        topography = rc.HeightMap(self.HEIGHTS, GRID.size, non_measured=mask).to_topography()
        assert topography.has_undefined_data
        again = rc.HeightMap.from_topography(topography, non_measured="keep")
        np.testing.assert_array_equal(again.non_measured, mask)
        np.testing.assert_array_equal(again.values[~mask], self.HEIGHTS[~mask])

    def test_units_are_converted(self):
        pytest.importorskip("SurfaceTopography")
        from SurfaceTopography import Topography as Real

        found = rc.HeightMap.from_topography(Real(self.HEIGHTS * 1e9, (3e5, 2e5), unit="nm"))
        np.testing.assert_allclose(found.values, self.HEIGHTS, rtol=1e-12)
        assert found.size == pytest.approx(GRID.size)

    def test_it_knows_where_it_comes_from_and_what_was_filled(self):
        values = np.ma.masked_array(self.HEIGHTS, np.zeros(GRID.shape, bool))
        values[3, 4] = np.ma.masked
        found = rc.HeightMap.from_topography(Topography(values), non_measured="fill")
        assert found.non_measured is None
        around = self.HEIGHTS[[2, 4, 3, 3], [4, 4, 3, 5]]
        assert found.values[3, 4] == pytest.approx(around.mean())
        assert found.history == (
            "from a topography of SurfaceTopography, 1 of 384 points non-measured and filled from their neighbours",
        )

    @pytest.mark.parametrize(
        ("topography", "words"),
        [
            (5, "must be a Topography"),
            (Topography(HEIGHTS, unit=None), "does not state its unit"),
            (Topography(HEIGHTS[0], dim=1), "a line profile"),
            (Topography(HEIGHTS, is_domain_decomposed=True), "several processes"),
            (Topography(np.where(HEIGHTS > 0.0, np.nan, HEIGHTS)), "non_measured='fill'"),
            (Topography(np.full((4, 4), np.nan)), "no valid point"),
        ],
    )
    def test_what_is_not_a_map_is_refused_in_words(self, topography, words):
        with pytest.raises(rc.InputError, match=words):
            rc.HeightMap.from_topography(topography)

    def test_an_absent_package_is_named(self, monkeypatch):
        hide(monkeypatch, "SurfaceTopography")
        with pytest.raises(rc.MissingPackage, match="pip install SurfaceTopography"):
            rc.HeightMap(self.HEIGHTS, GRID.size).to_topography()


def results():
    """Return one of each kind of result."""
    report = rc.error_vs_time(PROBLEM, force=1.0, cells=(8, 12), repeats=1)
    yield from (SWEEP, SOLUTION, SOLUTION.patches, SOLUTION.stress(), SOLUTION.stiffness(), SOLUTION.area(), report)
    yield from (rc.stability(PROBLEM, force=1.0), SOLUTION.conductance(50.0), PROBLEM.convolution, PROBLEM._gap)
    yield SOLUTION.partial_slip(tangential_force=0.1, friction=0.3).loop()
    periodic = rc.ContactProblem(rc.Body(ROUGH, STEEL), grid=GRID, boundary="periodic")
    law = rc.interface_law(periodic, [1e7, 1.5e7])
    yield from (law, law["area"], rc.extrapolate(PROBLEM, force=1.0))
    yield from (rc.HeightMap(ROUGH.heights(GRID), GRID.size), rc.Study(problems=PROBLEM, force=[1.0]))
    hard = rc.ElasticPerfectlyPlastic(210e9, 0.3, 4e9)
    yield rc.run_in(attrs.evolve(PROBLEM, body=rc.Body(ROUGH, hard)), force=1.0, rounds=1)


def test_nothing_prints_a_wall_of_numbers_in_a_notebook():
    for result in results():
        text = repr(result)
        assert "array(" not in text, type(result).__name__
        assert len(text) < 1200, type(result).__name__


def test_tables_show_in_a_notebook():
    shown = (rc.results.Sweep, rc.results.InterfaceLaw, rc.results.ErrorReport, rc.results.StabilityReport)
    tables = [result for result in results() if isinstance(result, shown)]
    assert len(tables) == len(shown)
    for table in tables:
        page = ElementTree.fromstring(f"<div>{table._repr_html_()}</div>")
        assert len(page.findall(".//tr")) > 1


def test_a_long_table_is_cut_in_the_middle_and_texts_are_escaped():
    from roughcontact.typing import Table

    table = Table({"load": [float(load) for load in range(100)], "text": ["<b>&"] * 100}, {"load": "N"})
    page = ElementTree.fromstring(table.to_html("a < b").replace("</div>", "</div>\n", 1).join(["<div>", "</div>"]))
    rows = [[cell.text or "" for cell in row] for row in page.iter("tr")]
    assert rows[0] == ["load", "text"]
    assert rows[1] == ["0 N", "<b>&"]
    assert rows[11] == ["... 80 more", ""]
    assert rows[-1] == ["99 N", "<b>&"]
    assert page.find("div").text == "a < b"


def test_the_list_of_names_is_what_scripts_type():
    """Bases of plug-ins, what is chosen by a registered name, results and errors are not in it, all else is."""
    listed, all_names = set(dir(rc)), set(rc.__all__)
    assert all_names - listed == rc._SELDOM_TYPED
    by_name = {
        registry[name]
        for registry in (rc.areas, rc.kernels, rc.convolvers, rc.solvers, rc.flattening_models)
        for name in registry
    }
    results_and_choices = {rc.Area, rc.Estimate, rc.Status, rc.Boundary, rc.results.KnownAnswer}
    results_and_choices |= {rc.FrictionalPath}
    for name in all_names - listed:
        cls = getattr(rc, name)
        assert inspect.isclass(cls)
        is_base = inspect.isabstract(cls) or cls is rc.InfluenceKernel
        assert is_base or issubclass(cls, Exception) or cls in by_name | results_and_choices, name
    for name in listed & all_names:
        cls = getattr(rc, name)
        if inspect.isclass(cls):
            assert not inspect.isabstract(cls)
            assert not issubclass(cls, Exception)
    assert {"Study", "ContactProblem", "read_surface", "areas", "examples"} <= listed
    assert len(listed) < 0.65 * len(all_names | listed)
