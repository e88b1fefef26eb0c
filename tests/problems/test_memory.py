"""Memory is asked for before it is taken, and no solve takes more than its plan says."""

from __future__ import annotations

import contextlib
import io
import json
import re
import subprocess
import sys
import tracemalloc
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.solving import available_memory, require_memory_of_solve
from roughcontact.typing import binary
from systems import linux
from unit_files import key_of

STEEL = rc.Elastic(1e9, 0.0)
WAVY = rc.WavySurface(1e-7, 1e-4)
SPHERE = rc.SphereSurface(1.0)
# The largest grid: an array of it takes 2 GiB.
LARGEST = 2**14
GRID = rc.Grid((LARGEST, LARGEST), 1e-2)


def write(root, **files):
    """Write files below a folder that stands for the root of the file system."""
    for name, text in files.items():
        path = root / name.replace("__", "/")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


MEMINFO = (
    "MemTotal: 9000 kB\nMemFree: 1 kB\nMemAvailable: 1000 kB\nSwapTotal: 0 kB\nSwapFree: 24 kB\nHugePages_Total: 0\n"
)


def limited(root, folder, name, used, limit, stat=""):
    group = root / "sys/fs/cgroup" / folder
    group.mkdir(parents=True, exist_ok=True)
    second = name == "memory.max"
    (group / name).write_text(f"{limit}\n")
    (group / ("memory.current" if second else "memory.usage_in_bytes")).write_text(f"{used}\n")
    (group / "memory.stat").write_text(stat)


def test_a_grid_may_have_more_cells_than_this_machine_can_take(leave_memory):
    """It is the fields that need memory, and of a grid on a cluster each process has a slab."""
    leave_memory(2**33)
    grid = rc.Grid((2**17, 2**17), 1e-2)
    assert grid.cells == 2**34
    assert grid.x.shape == (2**17, 1)
    with pytest.raises(
        rc.InputError, match=r"131072 x 131072 cells, boundary free, needs 1.4\d+ TiB of memory, but this"
    ):
        rc.ContactProblem(rc.Body(WAVY, STEEL), grid=grid)
    with pytest.raises(rc.InputError, match=r"A row of 1099511627776 cells needs 24 TiB of memory"):
        assert rc.Grid((2**40, 1), 1.0).x.size
    with pytest.raises(rc.InputError, match=r"of at most 2\^40 cells, of which a field takes 8 TiB"):
        rc.Grid((2**20, 2**20 + 1), 1.0)


def test_the_memory_of_the_machine(tmp_path):
    write(tmp_path, proc__meminfo=MEMINFO)
    assert available_memory(tmp_path) == 1024 * 1024


def test_the_limit_of_a_control_group_of_version_2_or_of_one_above_it(tmp_path):
    write(tmp_path, proc__meminfo=MEMINFO, proc__self__cgroup="0::/user.slice/job\n")
    limited(tmp_path, "user.slice/job", "memory.max", 500, "max")
    assert available_memory(tmp_path) == 1024 * 1024
    limited(
        tmp_path,
        "user.slice",
        "memory.max",
        60_000,
        100_000,
        "anon 1\ninactive_file 5000\nactive_file 300\nfile 5300\n",
    )
    assert available_memory(tmp_path) == 45_300
    limited(tmp_path, "user.slice/job", "memory.max", 900, 1000)
    assert available_memory(tmp_path) == 100
    limited(tmp_path, "user.slice/job", "memory.max", 1100, 1000)
    assert available_memory(tmp_path) == 0


def test_the_limit_of_a_container_that_sees_only_its_own_groups(tmp_path):
    write(
        tmp_path, proc__meminfo=MEMINFO, proc__self__cgroup="5:cpu,memory:/docker/4711\n1:name=systemd:/docker/4711\n"
    )
    limited(tmp_path, "memory", "memory.limit_in_bytes", 60_000, 100_000, "inactive_file 7\ntotal_inactive_file 1000\n")
    assert available_memory(tmp_path) == 41_000
    (tmp_path / "sys/fs/cgroup/memory/memory.stat").unlink()
    assert available_memory(tmp_path) == 40_000
    write(tmp_path, proc__self__cgroup="0::/../../elsewhere\n")
    assert available_memory(tmp_path) == 1024 * 1024


def test_the_sentence_says_how_much_there_is_and_what_to_do(leave_memory):
    leave_memory(3 * 2**30)
    with pytest.raises(rc.InputError) as caught:
        rc.ContactProblem(rc.Body(WAVY, STEEL), grid=GRID)
    assert str(caught.value) == (
        "A solve on 16384 x 16384 cells, boundary free, needs 23 GiB of memory, but this process may take only 3 GiB "
        "more: choose at most 5888 x 5888 cells, or a periodic boundary, which needs less."
    )
    # Memory that was taken since the problem was made.
    problem = rc.ContactProblem(rc.Body(WAVY, STEEL), grid=rc.Grid((512, 512), 1e-2))
    leave_memory(2**23)
    with pytest.raises(rc.InputError, match=r"needs 23 MiB of memory, but this process may take only 8 MiB more"):
        problem.solve(pressure=1e5)


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_a_limit_names_the_largest_grid_that_fits(boundary):
    side, solve = 1e-2, {"boundary": boundary, "memory_limit": "3 GiB"}
    with pytest.raises(rc.InputError, match=r"needs .* GiB of memory, but memory_limit= allows only 3 GiB") as caught:
        contact(grid=rc.Grid((2**14, 2**13), (side, side / 2)), **solve)
    nx, ny = map(int, re.search(r"choose at most (\d+) x (\d+) cells", str(caught.value)).groups())
    assert (nx % 32, ny % 32) == (0, 0)
    require_memory_of_solve(rc.Grid((nx, ny), 1.0), rc.Boundary(boundary), 3 * 2**30)
    with pytest.raises(rc.InputError, match="choose at most"):
        require_memory_of_solve(rc.Grid((nx + 64, ny + 64), 1.0), rc.Boundary(boundary), 3 * 2**30)


def test_a_limit_replaces_what_the_machine_has(leave_memory):
    leave_memory(2**23)
    grid = rc.Grid((512, 512), 1e-2)
    assert contact(grid=grid, memory_limit="100 MiB").solve(pressure=1e5).status.success
    with pytest.raises(rc.InputError, match=r"allows only 1 MiB: choose at most 96 x 96 cells"):
        contact(grid=rc.Grid((128, 128), 1e-2), memory_limit="1 MiB")


def test_a_limit_holds_for_finer_grids():
    problem = contact(WAVY, grid=rc.Grid((64, 64), 1e-4), boundary="periodic", memory_limit="1 MiB")
    with pytest.raises(rc.InputError, match=r"allows only 1 MiB"):
        rc.extrapolate(problem, pressure=1e5, levels=3)
    words = r"It seems to need 256 x 256 cells, .*too little memory \(.*allows only 1 MiB\): allow a larger error\."
    with pytest.raises(rc.NotConverged, match=words):
        problem.solve(pressure=1e5, area_within=1e-6)


def test_explain_says_for_how_much_contact_the_memory_suffices(monkeypatch):
    problem = contact(grid=rc.Grid((256, 256), 1e-2), boundary="periodic", memory_limit="5 MiB")
    words = re.search(r"the 5 MiB there are suffice for up to (\d+) % of the cells in contact", problem.explain())
    fits = 0.01 * int(words[1])
    assert problem.plan.memory_at(fits) <= 5 * 2**20 < problem.plan.memory_at(fits + 0.01)
    assert "suffice" not in attrs.evolve(problem, memory_limit="1 GiB").explain()
    monkeypatch.setattr("roughcontact._solve.problem.plan.available_memory", lambda: 2**22)
    assert "the 4 MiB there are suffice for up to 0 %" in attrs.evolve(problem, memory_limit=None).explain()


def test_what_is_small_is_not_asked_for(leave_memory):
    leave_memory(0)
    assert rc.ContactProblem(rc.Body(WAVY, STEEL), grid=rc.Grid((64, 64), 1e-2)).solve(pressure=1e5).status.success


def test_numbers_of_bytes():
    words = [binary(size) for size in (0, 1023, 1024, 1.5 * 2**30, 2**50)]
    assert words == ["0 bytes", "1023 bytes", "1 KiB", "1.5 GiB", "1024 TiB"]


def read_status(name):
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(name))


def contact(surface=WAVY, **others):
    return rc.ContactProblem(rc.Body(surface, STEEL), **{"grid": GRID, **others})


def command(*arguments):
    """Run a command; an exit with a sentence becomes an error with it."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        status = main([str(argument) for argument in arguments])
    if status == 2 or "failed [1]" in said.getvalue():
        raise rc.InputError(said.getvalue())


STUDY = """
[problems.large]
{grid}
body.surface = {{ {surface} }}
body.material = {{ type = "elastic", young = 1e9, poisson = 0.3 }}
[study]
pressure = [1e5]
"""
OF_FILE = {"grid": "", "surface": f'type = "file", path = "map.npz", resample = [{LARGEST}, {LARGEST}]'}
OF_GRID = {
    "grid": f"grid = {{ shape = [{LARGEST}, {LARGEST}], size = 1e-2 }}",
    "surface": 'type = "wavy", amplitude = 1e-7, wavelength = 1e-4',
}


def large_cases(folder):
    """Return what asks for a grid of 2^28 cells, by name."""
    heights = rc.HeightMap(1e-7 * np.random.default_rng(0).random((64, 64)), 1e-2, periodic=True)
    np.savez(folder / "map.npz", heights=heights.values, size=1e-2)
    for name, parts in (("file", OF_FILE), ("grid", OF_GRID)):
        (folder / f"{name}.toml").write_text(STUDY.format(**parts), encoding="utf-8")
    small = contact(SPHERE, grid=rc.Grid((64, 64), 1e-2))
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, longest=1e-3, shortest=2e-2 / LARGEST)
    of_map = [folder / "map.npz", "--young", "1GPa", "--pressure", "1kPa", "-o", folder / "out"]
    many = (LARGEST, LARGEST)
    return {
        **{boundary: lambda boundary=boundary: contact(boundary=boundary) for boundary in rc.Boundary},
        "direct": lambda: contact(convolver="direct"),
        "fourier": lambda: contact(kernel="fourier", boundary="periodic"),
        "rough": lambda: contact(rough),
        "strip": lambda: contact(grid=rc.Grid((2, 2**27), 1e-2)),
        "matched": lambda: contact(rc.match(heights, heights, shape=many).body),
        **{f"heights {type(s).__name__}": lambda s=s: s.heights(GRID) for s in (rough, SPHERE)},
        **{f"resampled {how}": lambda how=how: heights.resample(many, how) for how in ("bilinear", "cubic", "fourier")},
        "extrapolate": lambda: rc.extrapolate(small, force=0.1, levels=9),
        "beyond_resolution": lambda: rc.beyond_resolution(contact(heights), force=0.1, cutoffs=[64 / LARGEST]),
        "on_grid": lambda: rc.on_grid(small, many),
        "report": lambda: rc.error_vs_time(small, force=0.1, cells=[LARGEST]),
        **{
            f"dry run of a {name}": lambda name=name: command("run", folder / f"{name}.toml", "--dry-run")
            for name in ("file", "grid")
        },
        "command solve": lambda: command("solve", *of_map, "--resample", LARGEST, LARGEST),
        "command report": lambda: command("report", *of_map, "--cells", LARGEST),
    }


def run_alone(code):
    """Run code in a process of its own, which imports what this one does."""
    whole = f"import sys; sys.path[:0] = {sys.path!r}; {code}"
    return subprocess.run([sys.executable, "-c", whole], capture_output=True, text=True)


def try_large_cases(folder):
    """Print the sentence of each case and how much the resident memory rose, in a process that may take 1 GiB more."""
    import resource

    cases = large_cases(folder)
    contact(SPHERE, grid=rc.Grid((64, 64), 1e-2)).solve(force=0.1).area()
    limit = read_status("VmSize") + 2**30
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    result = {}
    for name, case in cases.items():
        before = read_status("VmRSS")
        # This resets the peak.
        Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")
        try:
            said = f"not refused: {case()!r:.80}"
        except rc.RoughContactError as error:
            said = str(error)
        result[name] = said, read_status("VmHWM") - before
    print(json.dumps(result))


@pytest.mark.slow
@linux
def test_the_largest_grid_is_refused_before_anything_is_taken(tmp_path):
    code = f"import pathlib, test_memory; test_memory.try_large_cases(pathlib.Path({str(tmp_path)!r}))"
    done = run_alone(code)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout.splitlines()[-1])
    assert len(result) == 23
    for name, (said, risen) in result.items():
        # On the command line a line ends after 80 columns.
        said = " ".join(said.split())
        asked = "GiB of memory, but this process may take only" in said
        assert asked or "needs more memory than there is" in said, (name, said)
        # The command line imports the figures' package.
        assert risen < 2**20 * (100 if name.startswith("command") else 16), (name, risen)


@linux
def test_maps_of_files_are_compared_with_the_memory(tmp_path, leave_memory):
    np.save(tmp_path / "map.npy", np.zeros((1200, 1200)))
    np.savez(tmp_path / "map.npz", heights=np.zeros((1200, 1200)), size=1.0)
    row = b"0.000000000000000000e+00 " * 1200 + b"\n"
    (tmp_path / "map.txt").write_bytes(row * 1200)
    leave_memory(2**24)
    for name, needed in (("map.npy", 21.97), ("map.npz", 21.97), ("map.txt", 68.67)):
        with pytest.raises(rc.InputError, match=rf"{name} cannot be used: it needs {needed} MiB of memory, but"):
            rc.read_surface(tmp_path / name, size=1.0)


def test_a_text_map_takes_little_more_than_its_numbers(tmp_path):
    """Three arrays of them at most."""
    heights = np.random.default_rng(0).integers(100, 999, (700, 750))
    np.savetxt(tmp_path / "map.csv", heights, fmt="%d", delimiter=",")
    np.savetxt(tmp_path / "small.csv", heights[:9, :8], fmt="%d", delimiter=",")
    # The first reading loads what all use.
    for name in ("small.csv", "map.csv"):
        tracemalloc.start()
        values = rc.read_surface(tmp_path / name, size=(1e-3, 1e-3), unit=1e-9).values
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    np.testing.assert_array_equal(values, heights * 1e-9)
    assert peak < 3.2 * heights.nbytes


def test_a_small_file_does_not_expand_to_a_large_map(tmp_path):
    np.savez_compressed(tmp_path / "map.npz", heights=np.zeros((1500, 1500)), size=1.0)
    assert (tmp_path / "map.npz").stat().st_size < 100_000
    with pytest.raises(rc.InputError, match=r"write it again without compression \(numpy.savez\)"):
        rc.read_surface(tmp_path / "map.npz")


@pytest.mark.parametrize(
    ("surface", "arrays"),
    [
        (rc.FlatSurface(), 1),
        (rc.SphereSurface(1.0), 3),
        (rc.ParaboloidSurface(1.0), 1),
        (rc.WavySurface(1e-6, 1e-5), 1),
        (rc.FlatSurface() + rc.SphereSurface(1.0), 3),
    ],
)
def test_surfaces_ask_before_they_take_memory(leave_memory, surface, arrays):
    grid = rc.Grid((1600, 1500), 1e-4)
    tracemalloc.start()
    surface.heights(grid)
    taken = tracemalloc.get_traced_memory()[1] / (8 * grid.cells)
    tracemalloc.stop()
    # A sum holds its total as well.
    assert arrays <= taken < arrays + 1.1
    leave_memory(2**20)
    tracemalloc.start()
    with pytest.raises(rc.InputError, match=r"on 1600 x 1500 cells needs .* of memory, but .*: choose fewer cells"):
        surface.heights(grid)
    # A page that is only reserved counts here.
    assert tracemalloc.get_traced_memory()[1] < 1.1 * 8 * grid.cells
    tracemalloc.stop()


@linux
def test_a_process_may_be_held_to_the_memory_that_there_is(tmp_path):
    """A gigabyte beyond what it has, and the address space that is only reserved."""
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/meminfo").write_text("MemAvailable: 1048576 kB\n")
    code = """if True:
        import pathlib, shutil, sys
        import numpy as np
        from roughcontact._base.machine import limit_address_space
        root = pathlib.Path(sys.argv[1])
        shutil.copy("/proc/self/statm", root / "proc/self/statm")
        for available, largest in ((2**20, 2), (4 * 2**20, 5)):
            (root / "proc/meminfo").write_text(f"MemAvailable: {available} kB\\n")
            limit_address_space(root)
            np.empty(largest * 2**27)
            try:
                np.empty((largest + 2) * 2**27)
            except MemoryError:
                print("refused")
        """
    ran = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True)
    assert ran.stdout.split() == ["refused", "refused"], ran.stderr


def rough_problem(cells, **parts):
    side = 1e-4
    surface = rc.SelfAffineSurface(
        hurst=0.8,
        rms_slope=0.1,
        longest=side,
        rolloff=max(side / 8, 8 * side / cells),
        shortest=8 * side / cells,
        seed=3,
    )
    material = parts.pop("material", STEEL)
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((cells, cells), side), **parts)


def measure(cells, load, hardness=0.0, **parts):
    """Return the peak memory of a solve, and that of its plan, bytes."""
    material = rc.ElasticPerfectlyPlastic(1e9, 0.0, hardness) if hardness else STEEL
    problem = rough_problem(cells, material=material, **parts)
    tracemalloc.start()
    solution = problem.solve(pressure=load, throw=False)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak, problem.plan.memory_at(float((solution.contact & ~solution.saturated).mean()))


CASES = [
    ({"boundary": boundary, "solver": solver}, load, hardness)
    for boundary in ("free", "periodic", "wrapped")
    for solver in ("projected-cg", "polonsky-keer", "spectral-gradient")
    for load, hardness in ((5e5, 0.0), (5e6, 0.0), (5e7, 0.0), (5e6, 3e7))
    if not (hardness and solver == "polonsky-keer")
]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_no_solve_takes_more_than_its_plan_says(boundary):
    for cells in (32, 256):
        # Once for the imports.
        peak, stated = measure(cells, 5e6, boundary=boundary)
    assert peak < stated


@pytest.mark.parametrize(("load", "hardness"), [(2e7, 0.0), (3e7, 0.0), (1e8, 0.0), (3e7, 5e8)])
def test_more_contact_takes_hardly_more_than_light_contact(load, hardness):
    """Arrays of the grid: fields, spectra and vectors of all cells, each once."""
    for cells in (32, 256):
        peak, _ = measure(cells, load, hardness, boundary="periodic", threads=1)
    assert peak / (8 * 256**2) < (10.2 if hardness else 9.2)


@pytest.mark.slow
@pytest.mark.parametrize(("parts", "load", "hardness"), CASES)
def test_no_solve_takes_more_than_its_plan_says_with_any_part(parts, load, hardness):
    for cells in (32, 256):
        peak, stated = measure(cells, load, hardness, **parts)
    assert peak < stated


def attract(cells, boundary, **options):
    """Return a rough problem whose surfaces attract each other."""
    law = rc.Exponential(work=0.05, range=6e-9)
    return rough_problem(cells, boundary=boundary, adhesion=law, material=rc.Elastic(1e9, 0.3), **options)


@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
@pytest.mark.parametrize("solver", ["gap-descent", pytest.param("majorise", marks=pytest.mark.slow)])
def test_no_solve_with_adhesion_takes_more_than_its_plan_says(boundary, solver):
    for cells in (32, 192):
        problem = attract(cells, boundary, solver=solver)
        tracemalloc.start()
        solution = problem.solve(pressure=5e6, throw=False)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert solution.status.success
    assert peak < problem.plan.memory_at(0.1)


def test_adhesion_is_refused_before_it_takes_memory():
    assert rough_problem(512, boundary="periodic", memory_limit="30 MiB").plan.memory_at(0.0) < 30 * 2**20
    with pytest.raises(rc.InputError, match=r"A solve on 512 x 512 cells, .* needs 43 MiB .*choose at most 416 x 416"):
        attract(512, "periodic", memory_limit="30 MiB")


ANSWERS = {
    "area": rc.LevelSet(),
    "flags": "flags",
    "stiffness": "stiffness",
    "conductance": rc.responses.create("conductance", 50.0),
    "tangential-stiffness": "tangential-stiffness",
    "stress": "stress",
    "leakage": rc.responses.create("leakage", viscosity=1e-3, pressure_drop=1e5),
    "partial-slip": rc.responses.create("partial-slip", tangential_force=2e-4, friction=0.5),
    "gradient": rc.responses.create("gradient", "participation"),
    "first-yield": rc.responses.create("first-yield", 1e7),
    "flash-temperature": rc.responses.create("flash-temperature", 0.2, 9.0, conductivity=45.0, diffusivity=1e-5),
}


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("name", ANSWERS)
def test_no_answer_takes_more_than_it_states(name, boundary):
    response = rc.responses.resolve(ANSWERS[name]) if name != "area" else ANSWERS[name]
    for cells in (32, 256, 256):
        solution = rough_problem(cells, boundary=boundary, material=rc.Elastic(1e9, 0.3)).solve(pressure=5e5)
        tracemalloc.start()
        found = solution.response(response)
        if name == "stress":
            assert found.maximum.value > 0.0
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 8 * 256**2 * response.memory_arrays


def test_an_answer_that_does_not_fit_is_refused_and_named_beforehand():
    problem = rough_problem(256, boundary="periodic", material=rc.Elastic(1e9, 0.3), memory_limit="40 MiB")
    # Plug-ins may add answers between these.
    sizes = (
        "leakage 84 MiB (168 arrays)",
        "first-yield 27 MiB (54 arrays)",
        "tangential-stiffness 24.5 MiB (49 arrays)",
    )
    assert re.search(", (?:.*, )?".join(map(re.escape, sizes)), problem.explain())
    solution = problem.solve(pressure=5e6)
    assert solution.response("tangential-stiffness").value > 0.0
    words = r"GapFlow of a contact on 256 x 256 cells needs 84 MiB of memory, but memory_limit= allows only 40 MiB: ask"
    with pytest.raises(rc.InputError, match=words):
        solution.leakage(viscosity=1e-3, pressure_drop=1e5)


def push(cells, counterbody, boundary="periodic", **options):
    """Return a rough problem at light contact, and its load."""
    problem = rough_problem(cells, boundary=boundary, counterbody=rc.Body(rc.FlatSurface(), counterbody), **options)
    return problem, 1e-3 * problem.plan.modulus * problem.plan.grid.area


def test_friction_is_refused_before_it_takes_memory():
    problem, force = push(512, STEEL, memory_limit="40 MiB")
    assert problem.solve(force=force).status.success
    loads = {"force": force, "friction": 0.1}
    tracemalloc.start()
    calls = (lambda: problem.path(tangential_force=[(0.05 * force, 0.0)], **loads), lambda: problem.slide(**loads))
    for call in calls:
        with pytest.raises(rc.InputError) as caught:
            call()
        assert str(caught.value) == (
            "A contact with friction on 512 x 512 cells, boundary periodic, needs 64 MiB of memory, but memory_limit= "
            "allows only 40 MiB: choose at most 384 x 384 cells."
        )
    assert tracemalloc.get_traced_memory()[1] < 8 * problem.plan.grid.cells
    tracemalloc.stop()
    fits, force = push(384, STEEL, memory_limit="40 MiB")
    assert fits.slide(force=force, friction=0.1).status.success
    # A path keeps all its states.
    with pytest.raises(rc.InputError, match=r"A path of 41 states on 384 x 384 cells, .* allows only 40 MiB"):
        fits.path(force=force, tangential_force=[(0.05 * force * (-1) ** k, 0.0) for k in range(40)], friction=0.1)


def solve_in(boundary, fraction):
    """Print how a solve near full contact ends in a process that may take a fraction of what the plan says at most."""
    import resource

    rough_problem(64, boundary=boundary).solve(pressure=5e7)
    problem = rough_problem(1024, boundary=boundary)
    limit = read_status("VmSize") + int(fraction * problem.plan.memory)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    try:
        print(problem.solve(pressure=5e7).status)
    except rc.RoughContactError as error:
        print(error)


@linux
@pytest.mark.slow
@pytest.mark.parametrize(("boundary", "fraction", "said"), [
    ("free", 1.05, "converged"),
    ("free", 0.7, "this process may take only"),
    ("periodic", 1.05, "converged"),
    ("periodic", 0.8, "needs more memory than there is"),
    ("periodic", 0.7, "this process may take only"),
])  # fmt: skip
def test_a_solve_ends_well_in_the_memory_of_its_plan_and_with_a_sentence_in_less(boundary, fraction, said):
    done = run_alone(f"import test_memory; test_memory.solve_in({boundary!r}, {fraction})")
    assert done.returncode == 0, done.stderr
    assert said in done.stdout, done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "wrapped"])
def test_the_direct_sum_takes_no_more_than_the_plan_says(boundary):
    # The first solves load modules too.
    for cells in (32, 64, 64):
        peak, stated = measure(cells, 5e6, boundary=boundary, convolver="direct")
    assert peak < stated


def test_the_direct_sum_of_a_long_strip_is_made_in_parts(monkeypatch):
    strip = contact(SPHERE, grid=rc.Grid((3, 40), (3e-3, 4e-2)), convolver="direct")
    whole = strip.convolution.apply(strip.initial_gap)
    monkeypatch.setattr("roughcontact._solve.convolvers.direct._MAX_MATRIX_NUMBERS", 300)
    np.testing.assert_allclose(strip.convolution.apply(strip.initial_gap), whole, rtol=1e-13)


@linux
@pytest.mark.slow
def test_the_scale_of_small_grids_is_measured(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "studies"))
    import scale

    monkeypatch.setattr(scale, "TIMES", 1)
    heading, *lines = scale.make_rows((128,))
    assert [line[:2] for line in lines] == [["periodic", "128"], ["free", "128"]]
    for line in lines:
        entries = dict(zip(heading, line, strict=True))
        assert set(scale.TIMED) < set(entries)
        assert 10 < int(entries["products"]) < 100
        assert all(float(entries[name]) > 0.0 for name in scale.TIMED)
        stated = rough_problem(128, boundary=entries["boundary"]).plan.memory
        assert float(entries["peak memory, MiB"]) < 2 * stated / 2**20


class TestMappedFile:
    """Heights that are mapped from a file are not copied."""

    @staticmethod
    def save(folder, heights):
        np.save(folder / "map.npy", heights)
        return np.load(folder / "map.npy", mmap_mode="r")

    def test_takes_no_memory_until_it_is_resampled(self, tmp_path):
        heights = np.random.default_rng(0).standard_normal((1200, 1000))
        mapped = self.save(tmp_path, heights)
        rc.HeightMap(heights[:30, :30], 1.0).resample((3, 3), "mean")
        tracemalloc.start()
        coarse = rc.HeightMap(mapped, (1.2, 1.0)).resample((120, 100), "mean")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 0.1 * heights.nbytes
        copied = rc.HeightMap(heights, (1.2, 1.0)).resample((120, 100), "mean")
        np.testing.assert_array_equal(coarse.values, copied.values)

    def test_is_kept_by_maps_made_from_it(self, tmp_path):
        mapped = self.save(tmp_path, np.random.default_rng(0).standard_normal((40, 30)))
        surface = rc.HeightMap(mapped, (4.0, 3.0))
        assert np.shares_memory(attrs.evolve(surface, periodic=True).values, mapped)
        assert np.shares_memory(rc.HeightMap(mapped[:20], (2.0, 3.0)).values, mapped)
        assert not surface.values.flags.writeable

    def test_gives_the_same_contact(self, tmp_path):
        heights = 1e-7 * np.random.default_rng(0).standard_normal((40, 30))
        one, other = (
            contact(rc.HeightMap(values, (4e-5, 3e-5)), grid=None) for values in (heights, self.save(tmp_path, heights))
        )
        assert key_of(one.parts) == key_of(other.parts)
        np.testing.assert_array_equal(one.solve(force=1e-3).pressure, other.solve(force=1e-3).pressure)

    @pytest.mark.parametrize("mode", ["r+", "c"])
    def test_is_copied_if_it_may_be_written_to(self, tmp_path, mode):
        self.save(tmp_path, np.ones((4, 5)))
        mapped = np.load(tmp_path / "map.npy", mmap_mode=mode)
        view = mapped[:]
        view.flags.writeable = False
        for given in (mapped, view):
            surface = rc.HeightMap(given, (4.0, 5.0))
            mapped[0, 0] = 7.0
            assert surface.values[0, 0] == 1.0
            mapped[0, 0] = 1.0

    def test_is_copied_if_it_must_be_converted(self, tmp_path):
        for heights in (np.ones((4, 5), dtype=np.float32), np.asfortranarray(np.ones((4, 5)))):
            values = rc.HeightMap(self.save(tmp_path, heights), (4.0, 5.0)).values
            assert (values.dtype, values.flags.c_contiguous) == (np.float64, True)

    def test_that_is_not_finite_is_refused(self, tmp_path):
        heights = np.ones((4, 5))
        heights[2, 1], heights[3, 3] = np.nan, np.inf
        with pytest.raises(rc.InputError, match="2 of 20 points are NaN or infinite"):
            rc.HeightMap(self.save(tmp_path, heights), (4.0, 5.0))
