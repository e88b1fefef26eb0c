"""One process in this one: what is refused, and the same solver by `rc.ContactProblem`."""

import numpy as np
import pytest
import roughcontact as rc

MPI = pytest.importorskip("mpi4py.MPI", reason="mpi4py finds no MPI: pip install mpich", exc_type=Exception)

from roughcontact_mpi import Processes, SlabArray, SlabFFT, make_heights, read_heights, solve, write_field  # noqa: E402

ALONE = Processes(MPI.COMM_SELF)
STEEL = rc.Elastic(1e9, 0.3)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=0.1, longest=1.0, lay=0.3, peklenik=2.0, seed=2)
VALUES = 0.01 * np.random.default_rng(1).normal(size=(40, 33))


def slab(values=VALUES):
    return SlabArray.field(values.copy(), ALONE, values.shape[0])


class StiffLayer(rc.InfluenceKernel):
    """A body whose shortest waves are much stiffer than a half-space."""

    def spectrum(self, qx, qy, spacing, compliance):
        q = np.hypot(qx, qy)
        return 2.0 * compliance / (q * (1.0 + (q * spacing[0]) ** 3))


def test_a_problem_takes_the_convolver_and_gets_whole_fields():
    surface = rc.HeightMap(VALUES, (1.0, 1.0), periodic=True)
    parts = {"boundary": "periodic", "solver": rc.ProjectedConjugateGradient(tolerance=1e-10)}
    expected, found = (
        rc.ContactProblem(rc.Body(surface, STEEL), **parts, **more).solve(pressure=1e7)
        for more in ({}, {"convolver": SlabFFT(ALONE)})
    )
    assert type(found.pressure) is np.ndarray
    assert np.abs(found.pressure - expected.pressure).max() < 1e-9 * expected.pressure.max()


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_the_text_and_the_numbers_are_those_of_a_solution(boundary):
    solution = solve(slab(), 1.0, rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e8), pressure=1e7, boundary=boundary)
    solution.stiffness()
    whole = solution.gather()
    assert type(solution) is type(whole) is rc.ContactSolution
    assert {"slabs", "stiffness", "force"} <= {line[:18].strip() for line in str(solution).splitlines()}
    assert solution.to_dict()["area"]["value"] == pytest.approx(whole.to_dict()["area"]["value"], rel=1e-9)
    assert repr(solution)[:32] == repr(whole)[:32]


def test_a_step_that_slabs_do_not_have_is_refused():
    with pytest.raises(rc.InputError, match="thin stiff layers"):
        solve(slab(), 1.0, STEEL, pressure=1e7, boundary="periodic", kernel=StiffLayer())
    with pytest.raises(rc.InputError, match=r"numpy\.sort"):
        np.sort(slab())
    with pytest.raises(rc.InputError, match="its part"):
        np.asarray(slab())
    with pytest.raises(rc.InputError, match="slabs"):
        slab() + VALUES


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({}, "exactly one"),
        ({"pressure": 1e7, "heights": VALUES}, "read_heights"),
        ({"pressure": 1e7, "force": 1.0}, "exactly one"),
        ({"pressure": -1.0}, "above 0"),
        ({"pressure": 1e7, "boundary": "wrapped"}, "wrapped"),
        ({"pressure": 1e7, "size": -1.0}, "above 0"),
        ({"pressure": 1e7, "heights": slab(np.ones((4, 4)))}, "all the same"),
        ({"pressure": 1e7, "material": rc.ElasticPerfectlyPlastic(1e9, 0.3, np.full((8, 8), 1e8))}, "one number"),
        ({"approach": 1.0, "boundary": "periodic"}, "full contact"),
        ({"pressure": 1e7, "heights": rc.SphereSurface(1.0), "size": rc.Grid((8, 8), 1.0)}, "SelfAffineSurface"),
        ({"pressure": 1e7, "heights": ROUGH, "size": 1.0}, "an rc.Grid"),
        ({"pressure": 1e7, "heights": ROUGH, "size": rc.Grid((8, 8), 1.0)}, "at least two cells"),
        ({"pressure": 1e7, "size": rc.Grid((8, 8), 1.0)}, "shape of the heights"),
    ],
)
def test_wrong_input_is_refused(arguments, sentence):
    given = {"heights": slab(), "size": 1.0, "material": STEEL, **arguments}
    with pytest.raises(rc.InputError, match=sentence):
        solve(**given)


def test_the_mpiexec_of_another_mpi_is_named(monkeypatch):
    monkeypatch.setenv("PMI_SIZE", "4")
    with pytest.raises(rc.InputError, match="mpiexec has started 4 processes"):
        Processes()


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (np.zeros((4, 4, 4)), "two axes"),
        (np.full((4, 4), "a"), "real numbers"),
        (np.array([[0.0, 1.0], [np.nan, 2.0]]), "not finite"),
    ],
)
def test_unfit_files_are_refused(values, sentence, tmp_path):
    np.save(tmp_path / "map.npy", values)
    with pytest.raises(rc.RoughContactError, match=sentence):
        read_heights(tmp_path / "map.npy", ALONE)
    (tmp_path / "text.npy").write_text("no array")
    with pytest.raises(rc.FileError, match=r"text\.npy cannot be read"):
        read_heights(tmp_path / "text.npy", ALONE)


def test_a_field_comes_back_from_its_file(tmp_path):
    write_field(tmp_path / "field.npy", slab())
    assert np.array_equal(np.load(tmp_path / "field.npy"), VALUES)
    found = read_heights(tmp_path / "field.npy", ALONE, unit=1e-6)
    assert np.array_equal(found.part, VALUES * 1e-6)
    assert [file.name for file in tmp_path.iterdir()] == ["field.npy"]


def test_random_heights_are_those_of_the_surface():
    grid = rc.Grid((40, 33), (2.0, 1.0))
    expected = ROUGH.heights(grid)
    found = make_heights(ROUGH, grid, ALONE)
    assert np.abs(found.part - expected).max() < 1e-14 * np.abs(expected).max()
    one, other = (
        solve(heights, grid, STEEL, pressure=1e7, boundary="periodic", tolerance=1e-10)
        for heights in (ROUGH, slab(expected))
    )
    assert np.abs(one.pressure.part - other.pressure.part).max() < 1e-8 * other.pressure.part.max()


def test_what_is_no_store_is_not_replaced(tmp_path):
    pytest.importorskip("zarr")
    solution = solve(slab(), 1.0, STEEL, pressure=1e7, boundary="periodic")
    (tmp_path / "data.zarr").mkdir()
    refused = {"data.zarr": "something else", "no/out.zarr": "no folder", "out.nc": "or that of a folder"}
    for name, sentence in refused.items():
        with pytest.raises(rc.InputError, match=sentence):
            solution.save(tmp_path / name)
    assert [file.name for file in tmp_path.iterdir()] == ["data.zarr"]


def test_the_area_does_not_depend_on_the_orientation():
    """Transposed heights have the transposed contact, for all estimators and both boundaries."""
    for boundary in ("periodic", "free"):
        one = solve(slab(), (1.0, 2.0), STEEL, pressure=3e7, boundary=boundary, tolerance=1e-9)
        other = solve(slab(VALUES.T), (2.0, 1.0), STEEL, pressure=3e7, boundary=boundary, tolerance=1e-9)
        for estimator in ("cell-count", "perimeter", "level-set", "hertz", "blend"):
            assert one.area(estimator).value == pytest.approx(other.area(estimator).value, rel=1e-6)
        assert one.area("perimeter").value < one.area("cell-count").value
    with pytest.raises(rc.InputError, match=r"asked of a contact on slabs must be one of blend, .* but got 'MeanGap'"):
        one.response("mean-gap")
