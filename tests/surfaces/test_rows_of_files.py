"""Files with a row for each x, or for each y: the same map, read and solved by script, command line and study."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import savemat

import roughcontact as rc
from unit_files import read_study

SIZE = (200e-6, 150e-6)
READING = {"size": SIZE, "unit": 1e-6, "non_measured": "keep"}
OPTIONS = ("--size", "200um", "150um", "--unit", "um", "--non-measured", "keep")
STEEL = rc.Elastic(210e9, 0.3)


@pytest.fixture(scope="module")
def expected(exported_map):
    return rc.ContactProblem(rc.Body(exported_map[0], STEEL)).solve(pressure=2e8)


def test_both_are_read_as_the_map(exported_map):
    surface, by_x, by_y = exported_map
    for read in (rc.read_surface(by_x, **READING), rc.read_surface(by_y, rows="y", **READING)):
        assert read.grid == surface.grid
        np.testing.assert_array_equal(read.non_measured, surface.non_measured)
        measured = ~surface.non_measured
        np.testing.assert_allclose(read.values[measured], surface.values[measured], rtol=1e-12, atol=0.0)
    assert 0.025 < surface.non_measured.mean() < 0.035


@pytest.mark.slow
def test_a_script_solves_both(exported_map, expected):
    _, by_x, by_y = exported_map
    for path, rows in ((by_x, "auto"), (by_y, "y")):
        surface = rc.read_surface(path, rows=rows, **READING)
        solution = rc.ContactProblem(rc.Body(surface, STEEL)).solve(pressure=2e8)
        assert solution.area().value == pytest.approx(expected.area().value, rel=1e-9)
        assert not (solution.contact & surface.non_measured).any()


@pytest.mark.slow
def test_the_command_line_solves_both(exported_map, expected, run, tmp_path):
    _, by_x, by_y = exported_map
    for path, rows in ((by_x, ()), (by_y, ("--rows", "y"))):
        load = ("--young", "210GPa", "--pressure", "200MPa", "-o", tmp_path / path.stem)
        status, _, error = run("solve", path, *OPTIONS, *load, *rows)
        # Solved, perhaps with warnings.
        assert status in (0, 3), error
        found = rc.ContactSolution.load(tmp_path / path.stem / "solution.npz")
        assert found.area().value == pytest.approx(expected.area().value, rel=1e-9)


@pytest.mark.slow
def test_it_is_asked_where_only_rows_of_y_make_square_cells(exported_map, run):
    by_y = exported_map[2]
    with pytest.raises(
        rc.InputError, match=r"300 rows of 400 .* 666\.7 nm x 375 nm, .* 500 nm\. .* rows='y', or rows='x'"
    ):
        rc.read_surface(by_y, **READING)
    assert rc.read_surface(by_y, rows="x", **READING).grid.spacing == pytest.approx((2e-6 / 3.0, 3.75e-7))
    status, _, error = run("info", by_y, *OPTIONS)
    assert status == 2
    assert "--rows y, or --rows x." in " ".join(error.split())
    status, shown, _ = run("info", by_y, *OPTIONS, "--rows", "x")
    assert status == 0
    assert "300 x 400 cells" in shown


@pytest.mark.parametrize(
    ("shape", "size", "asked"),
    [
        ((12, 8), (8e-6, 12e-6), True),
        ((12, 8), (12e-6, 8e-6), False),
        # Neither way makes square cells.
        ((12, 8), (9e-6, 9e-6), False),
        ((9, 9), (9e-6, 3e-6), False),
        ((50, 51), (0.0255, 0.025), True),
        ((51, 50), (0.0255, 0.025), False),
    ],
)
@pytest.mark.parametrize("ending", ["csv", "npy", "mat"])
def test_only_a_turn_to_square_cells_is_asked_about(shape, size, asked, ending, tmp_path):
    heights, path = np.random.default_rng(1).normal(size=shape), tmp_path / f"map.{ending}"
    write = {"csv": np.savetxt, "npy": np.save, "mat": lambda file, array: savemat(file, {"heights": array})}[ending]
    write(path, heights)
    if asked:
        with pytest.raises(rc.InputError, match="Say which it is: rows='y', or rows='x'"):
            rc.read_surface(path, size=size)
    else:
        np.testing.assert_array_equal(rc.read_surface(path, size=size).values, heights)
    np.testing.assert_array_equal(rc.read_surface(path, size=size, rows="y").values, heights.T)
    np.testing.assert_array_equal(rc.read_surface(path, size=size, rows="x").values, heights)


def test_a_study_file_names_the_rows(exported_map, expected):
    by_y = exported_map[2]
    reading = f'path = "{by_y.name}", size = [2e-4, 1.5e-4], unit = "1um", non_measured = "keep", rows = "y"'
    text = f"""
    [problems.steel.body]
    surface = {{ type = "file", {reading} }}
    material = {{ type = "elastic", young = "210GPa", poisson = 0.3 }}
    [study]
    pressure = [2e8]
    """
    study = by_y.parent / "study.toml"
    study.write_text(text, encoding="utf-8")
    surface = read_study(study).problems["steel"].body.surface
    assert surface.grid == expected.grid
    np.testing.assert_array_equal(surface.non_measured, exported_map[0].non_measured)


def test_images_and_lists_state_their_axes(tmp_path):
    header = "# Width: 12 µm\n# Height: 8 µm\n# Value units: nm\n"
    image = np.random.default_rng(2).normal(size=(12, 8)).round(3)
    path = tmp_path / "image.txt"
    path.write_text(header + "\n".join(" ".join(map(str, row)) for row in image), encoding="utf-8")
    for rows in ("auto", "y"):
        np.testing.assert_allclose(rc.read_surface(path, rows=rows).values, 1e-9 * image[::-1].T, rtol=1e-12)
    with pytest.raises(rc.InputError, match="states that its rows are those of y: omit rows="):
        rc.read_surface(path, rows="x")
    x, y = np.meshgrid(np.arange(12.0), np.arange(8.0))
    points = tmp_path / "points.xyz"
    np.savetxt(points, np.stack((x, y, np.sin(x) + y**2), axis=-1).reshape(-1, 3))
    read = [rc.read_surface(points, size=(12e-6, 8e-6), rows=rows).values for rows in ("auto", "x", "y")]
    assert read[0].shape == (12, 8)
    np.testing.assert_array_equal(read[0], read[1])
    np.testing.assert_array_equal(read[0], read[2])


def test_other_words_are_refused(exported_map):
    with pytest.raises(rc.InputError, match="The axis of the rows in a file must be one of 'auto', 'x', 'y'"):
        rc.read_surface(exported_map[1], rows="z", **READING)
