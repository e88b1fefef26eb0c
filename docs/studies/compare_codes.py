"""Our default solver beside tamaas, ContactMechanics, ASPHER and slippy on the same arrays, judged by one function.

Needs a separate environment with the other codes (none is a dependency of ours; tamaas is under the AGPL):

    python -m venv peers && peers/bin/pip install -e . ./plugins/roughcontact-numba tamaas ContactMechanics
    peers/bin/pip install aspher  # compiles; needs CMake and Eigen 3.4
    peers/bin/pip install --no-deps slippy && peers/bin/pip install numba matplotlib pyfftw sympy scikit-image tinydb
    peers/bin/python docs/studies/compare_codes.py

slippy 0.5.2 asks for a numpy before 1.21, but its solver runs with newer ones. What is not installed is omitted.
It writes the table of docs/trust/standing.md, ours by numpy alone. `--small` writes that of grids of 64 to 256 cells a
side, by numpy alone and compiled by the plug-in: all codes run by turns, and the medians count. `--only` and
`--largest` print a choice of the lines of the first table. `--friction` compares the first step of a path with
friction, of which ASPHER alone has histories (like materials).

Ours runs at its default tolerance. Each other code gets the loosest tolerance of a ladder, three to a factor of ten,
with which `measure_violation` finds it as good as ours, or 1e-6 of the rms height if ours is better. CPU time on one
thread, each case in a process of its own. Ours runs before and after each other code, and the median counts; the others
run once, because some take minutes.
"""

from __future__ import annotations

import os

if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", os.environ["OMP_NUM_THREADS"])

import argparse
import importlib.util
import json
import statistics
import subprocess
import sys
import time
import warnings
from collections.abc import Callable

import attrs
import numpy as np
from doc_tables import DocTable, format_rows, pick, write_tables

import roughcontact as rc

# Rms slope of the rough surfaces; complementarity over the rms height that is enough.
SLOPE = 0.1
REQUIRED = 1e-6
THREADS = int(os.environ.get("OMP_NUM_THREADS", "1"))
# Sides of small grids, and how often each code solves a contact on them.
SMALL, REPEATS = (64, 128, 256), 9


@attrs.frozen(eq=False)
class Case:
    """One contact in units of E* = 1 on cells of side one."""

    name: str
    heights: np.ndarray
    mean: float
    boundary: str = "periodic"
    hardness: float | None = None
    # Work and range of an exponential attraction; the mean gap is then given, and not the mean pressure.
    adhesion: tuple[float, float] | None = None
    # Whether codes that solve on one grid alone take minutes, and are not run.
    long: bool = False


def make_rough(cells: int, seed: int = 0) -> np.ndarray:
    """Return heights with Hurst 0.8, roll-off at an eighth of the side, shortest wave of eight cells, rms slope 0.1."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=float(cells), rolloff=cells / 8, seed=seed
    )
    return surface.heights(rc.Grid((cells, cells), float(cells)))


def make_cases(largest: int) -> list[Case]:
    """Return the contacts of the table, up to a number of cells along a side."""
    cases = [Case(f"x = 0.05, {n}", make_rough(n), 0.05 * SLOPE) for n in (512, 1024, 2048) if n <= largest]
    if largest >= 1024:
        cases += [Case(f"x = {x}, 1024", make_rough(1024), x * SLOPE, long=x < 1.5) for x in (0.2, 1.0, 1.5, 3.0)]
        cases += [make_wave(1024), make_ball(1024)]
    cases.append(Case("hardness 0.3 slope, x = 0.05, 512", make_rough(512), 0.05 * SLOPE, hardness=0.3 * SLOPE))
    cases.append(Case("mean pressure 0.9 H, 512", make_rough(512), 0.27 * SLOPE, hardness=0.3 * SLOPE))
    # An attraction of four cells of cohesive length, at the mean gap of a small load.
    cases += [make_adhesive(n) for n in (256, 512, 1024) if n <= largest]
    return cases


def make_small_cases() -> list[Case]:
    """Return the contacts of the table of small grids."""
    rough = [Case(f"x = {x}, {n}", make_rough(n), x * SLOPE) for x in (0.05, 1.0) for n in SMALL]
    return [*rough, *map(make_ball, SMALL), *map(make_wave, SMALL)]


def make_wave(cells: int) -> Case:
    """Return the paper's wave at 100 MPa."""
    wave = rc.WavySurface(0.5e-6 * cells / 250e-6, 12.5e-6 * cells / 250e-6)
    heights = wave.heights(rc.Grid((cells, cells), float(cells)))
    return Case(f"bi-sinusoid, {cells}", heights, 100e6 / 219.78e9)


def make_ball(cells: int) -> Case:
    """Return a sphere on a free boundary whose contact radius is 0.3 of half the side."""
    radius, a = 1e4 * cells / 1024, 0.15 * cells
    force = 4 * a**3 / (3 * radius)
    heights = rc.ParaboloidSurface(radius).heights(rc.Grid((cells, cells), float(cells)))
    return Case(f"Hertz, free, {cells}", heights, force / cells**2, "free")


def make_adhesive(cells: int) -> Case:
    """Return a rough contact with adhesion, waves of 16 cells to a quarter of the domain."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=SLOPE, shortest=16.0, longest=0.25 * cells, seed=1)
    heights = surface.heights(rc.Grid((cells, cells), float(cells)))
    work = 0.02 * SLOPE**2
    case = Case(f"adhesion, {cells}", heights, 0.0, adhesion=(work, (4.0 * work) ** 0.5))
    relaxed = make_problem(case).solve(pressure=0.05 * SLOPE)
    return attrs.evolve(case, mean=float(relaxed.gap.mean()))


def measure_violation(pressure: np.ndarray, case: Case) -> tuple[float, float]:
    """Return the violation of the contact conditions over the rms height, and the error of the load, by numpy's FFT."""
    n = case.heights.shape[0]
    if case.adhesion is not None:
        return measure_adhesive_violation(pressure, case)
    if case.boundary == "free":
        offsets = np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n)).astype(int)
        table = rc.Love().coefficients((n + 1, n + 1), (1.0, 1.0), 1.0)[np.ix_(offsets, offsets)]
        padded = np.fft.rfft2(pressure, s=(2 * n, 2 * n)) * np.fft.rfft2(table)
        gap = np.fft.irfft2(padded)[:n, :n] - case.heights
    else:
        q = 2 * np.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None, :])
        q[0, 0] = np.inf
        gap = np.fft.irfft2(np.fft.rfft2(pressure) * 2 / q, s=(n, n)) - case.heights
    saturated = pressure >= (1 - 1e-9) * (case.hardness or np.inf)
    free = (pressure > 0) & ~saturated
    gap -= np.average(gap[free], weights=pressure[free]) if free.any() else gap[saturated].max()
    wrong = np.where(saturated, np.maximum(gap, 0), np.abs(gap))
    opened = np.sum(pressure * wrong) / pressure.sum()
    overlap = max(0.0, -gap[~saturated].min(initial=np.inf))
    return float(max(opened, overlap) / case.heights.std()), float(abs(pressure.mean() / case.mean - 1))


def measure_adhesive_violation(pressure: np.ndarray, case: Case) -> tuple[float, float]:
    """Return the violation at the given mean gap over the rms height; no load is given that could be wrong."""
    assert case.adhesion is not None
    work, length = case.adhesion
    n = case.heights.shape[0]
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None, :])
    q[0, 0] = np.inf
    gap = np.fft.irfft2(np.fft.rfft2(pressure) * 2 / q, s=(n, n)) - case.heights
    gap += case.mean - gap.mean()
    contact = pressure + work / length * np.exp(-np.maximum(gap, 0.0) / length)
    opened = np.sum(np.maximum(contact, 0.0) * np.abs(gap)) / np.sum(np.maximum(contact, 0.0))
    # A pressure below the law belongs to a smaller gap.
    below = max(0.0, -contact.min()) * length**2 / work
    return float(max(opened, below, -gap.min()) / case.heights.std()), 0.0


def make_problem(case: Case, tolerance: float | None = None, convolver: str = "auto") -> rc.ContactProblem:
    material = rc.Elastic(1.0, 0.0)
    if case.hardness is not None:
        material = rc.ElasticPerfectlyPlastic(1.0, 0.0, case.hardness)
    size = float(case.heights.shape[0])
    return rc.ContactProblem(
        rc.Body(rc.HeightMap(case.heights, size=size, periodic=True), material),
        boundary=case.boundary,
        kernel="love" if case.boundary == "free" else "fourier",
        convolver=convolver,
        solver="auto" if tolerance is None else rc.ProjectedConjugateGradient(tolerance=tolerance),
        adhesion=None if case.adhesion is None else rc.Exponential(*case.adhesion),
        threads=THREADS,
    )


def name_numpys(case: Case) -> str:
    """Return the convolver that needs numpy and scipy alone."""
    return "dc-fft" if case.boundary == "free" else "circular-fft"


def solve_ours(case: Case, tolerance: float | None = None, convolver: str = "auto") -> np.ndarray:
    problem = make_problem(case, tolerance, convolver)
    if case.adhesion is not None:
        return np.array(problem.solve(approach=float(problem.initial_gap.mean()) - case.mean).pressure)
    return np.array(problem.solve(pressure=case.mean).pressure)


def solve_tamaas(case: Case, tolerance: float) -> np.ndarray | None:
    if case.hardness is not None or case.long:
        return None
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    tm.initialize(THREADS)
    n = case.heights.shape[0]
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [float(n)] * 2, [n, n])
    model.E, model.nu = 1.0, 0.0
    if case.adhesion is not None:
        kind = tm.PolonskyKeerRey.gap
        solver = tm.PolonskyKeerRey(model, case.heights, tolerance, kind, kind)
        law = tm.ExponentialAdhesionFunctional(case.heights)
        law.parameters = dict(zip(("surface_energy", "rho"), case.adhesion, strict=True))
        solver.addFunctionalTerm(law)
        solver.max_iter = 10_000
        solver.solve(case.mean)
        return np.array(model.traction)
    solver = tm.PolonskyKeerRey(model, case.heights, tolerance)
    if case.boundary == "free":
        tm.ModelFactory.registerNonPeriodic(model, "dcfft")
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 10_000
    solver.solve(case.mean)
    return np.array(model.traction)


def solve_contact_mechanics(case: Case, tolerance: float) -> np.ndarray | None:
    # Without a hardness it took 1.6 to 4 times as long as tamaas on 1024 x 1024 cells: minutes a case.
    if case.adhesion is not None or (case.hardness is None and case.heights.shape[0] > 512):
        return None
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from ContactMechanics.Optimization import constrained_conjugate_gradients
    from SurfaceTopography import Topography

    n, size = case.heights.shape[0], float(case.heights.shape[0])
    space = FreeFFTElasticHalfSpace if case.boundary == "free" else PeriodicFFTElasticHalfSpace
    result = constrained_conjugate_gradients(
        space((n, n), 1.0, (size, size)),
        Topography(case.heights, (size, size)),
        hardness=case.hardness,
        external_force=case.mean * size**2,
        pentol=tolerance * case.heights.std(),
        maxiter=3000,
    )
    return np.abs(np.array(result.jac)[:n, :n]) if result.success else None


def solve_aspher(case: Case, tolerance: float) -> np.ndarray | None:
    if case.hardness is not None or case.adhesion is not None:
        return None
    from aspher import solve_nested

    n, free = case.heights.shape[0], case.boundary == "free"
    # On a free boundary float32 saves no time.
    result = solve_nested(
        grid_size=n,
        gap=np.ascontiguousarray(-case.heights),
        p_nominal=case.mean,
        domain_size=float(n),
        E_star=1.0,
        tol=tolerance,
        precision="" if free else "float_then_double",
        backend="fft" if free else "periodic",
    )
    return np.array(result.pressure).reshape(n, n)


def solve_slippy(case: Case, tolerance: float) -> np.ndarray | None:
    # The solver under its model classes, which takes a gap and a load, on either boundary.
    if case.hardness is not None or case.adhesion is not None or case.long:
        return None
    import slippy

    slippy.CUDA, slippy.CORES = False, THREADS
    from slippy import core
    from slippy.core import elastic_material

    n, free = case.heights.shape[0], case.boundary == "free"
    if free:
        response = elastic_material.elastic_influence_matrix_spatial("zz", (2 * n, 2 * n), (1.0, 1.0), 0.5, 0.0)
    else:
        qy, qx = elastic_material.get_angular_velocity((n, n), (1.0, 1.0))
        q = np.hypot(qx, qy)
        response = elastic_material.elastic_influence_matrix_frequency(qy, qx, q, q**2, "zz", 1.0, 0.0)
    convolve = core.plan_convolve(np.zeros((n, n)), response, None, circular=not free, fft_im=not free)
    gap = case.heights.max() - case.heights
    failed, pressure, _ = core.polonsky_and_keer(
        convolve, np.ones((n, n)), gap, case.mean * n**2, 1.0, tolerance, max_it=3000
    )
    return None if failed else np.array(pressure)


@attrs.frozen
class Peer:
    """Another code: its package, how it is run, and the loosest tolerance worth trying."""

    package: str
    solve: Callable[[Case, float], np.ndarray | None]
    loosest: float


PEERS = {
    "tamaas": Peer("tamaas", solve_tamaas, 5e-6),
    "ContactMechanics": Peer("ContactMechanics", solve_contact_mechanics, 1e-5),
    "ASPHER": Peer("aspher", solve_aspher, 1e-6),
    "slippy": Peer("slippy", solve_slippy, 1e-5),
}
COLUMNS = (
    *(f"{code}, s" for code in ("ours", *PEERS)),
    *(f"{code} / ours" for code in ("tamaas", "ASPHER")),
)
OURS = ("numpy", "compiled")
SMALL_COLUMNS = (
    *(f"ours, {code}, ms" for code in OURS),
    *(f"{code}, ms" for code in PEERS),
    *(f"ASPHER / {code}" for code in OURS),
)
# Factors between the tolerances of a ladder, and how many are tried.
STEPS, RUNGS = (1.0, 0.5, 0.2), 10
LOOSEST_GAP = 1e-3


@attrs.frozen
class Run:
    """CPU time of a solve, s, the violation of its pressure, the error of its load, and the tolerance."""

    cpu: float
    violation: float
    load: float
    tolerance: float | None = None


def measure_run(solve: Callable[[Case], np.ndarray | None], case: Case, tolerance: float | None = None) -> Run | None:
    """Return the time and the violation of a solve; None if it fails or does not exist for a case."""
    started = time.process_time()
    try:
        with warnings.catch_warnings(action="ignore"), np.errstate(all="ignore"):
            pressure = solve(case)
    except Exception as error:
        print(f"{case.name}, tolerance {tolerance}: {type(error).__name__}: {error}", file=sys.stderr)
        return None
    cpu = time.process_time() - started
    return None if pressure is None else Run(cpu, *measure_violation(pressure, case), tolerance)


def match_run(peer: Peer, case: Case, required: float) -> Run | None:
    """Return the run with the loosest tolerance that meets the requirement, else the one nearest to it."""
    best = None
    for rung in range(RUNGS):
        # With adhesion the tolerance of tamaas is that of the gap.
        loosest = peer.loosest if case.adhesion is None else LOOSEST_GAP
        tolerance = loosest * STEPS[rung % len(STEPS)] * 10.0 ** -(rung // len(STEPS))
        found = measure_run(lambda case, tolerance=tolerance: peer.solve(case, tolerance), case, tolerance)
        if found is None:
            break
        best = found if best is None or found.violation < best.violation else best
        if found.violation <= required:
            break
    return best


def compare(case: Case) -> dict[str, Run]:
    """Return the runs of all codes in this process, at the accuracy of ours."""

    def solve(case: Case) -> np.ndarray:
        return solve_ours(case, convolver=name_numpys(case))

    solve(case)
    mine, runs = [measure_run(solve, case)], {}
    # Imports and compilation are not counted.
    small = attrs.evolve(case, name="warm-up", heights=make_rough(64))
    for name, peer in PEERS.items():
        if importlib.util.find_spec(peer.package) is None:
            continue
        measure_run(lambda case, peer=peer: peer.solve(case, peer.loosest), small)
        found = match_run(peer, case, max(REQUIRED, mine[0].violation))
        if found is not None:
            runs[name] = found
            mine.append(measure_run(solve, case))
    return {"ours": take_median(mine), **runs}


def compare_small(case: Case) -> dict[str, Run]:
    """Return the median runs of all codes, by turns in this process; ours by numpy and, with the plug-in, compiled."""
    names = [name for name in (name_numpys(case), "compiled") if name in rc.convolvers]
    solves = {
        code: (lambda case, name=name: solve_ours(case, convolver=name), None)
        for code, name in zip(OURS, names, strict=False)
    }
    for solve, _ in solves.values():
        measure_run(solve, case)
    required = max(REQUIRED, *(measure_run(solve, case).violation for solve, _ in solves.values()))
    for name, peer in PEERS.items():
        if importlib.util.find_spec(peer.package) is None:
            continue
        # Imports and compilation are not counted.
        measure_run(lambda case, peer=peer: peer.solve(case, peer.loosest), case)
        found = match_run(peer, case, required)
        if found is not None:
            solves[name] = (lambda case, peer=peer, t=found.tolerance: peer.solve(case, t), found.tolerance)
    runs: dict[str, list[Run]] = {code: [] for code in solves}
    for _ in range(REPEATS):
        for code, (solve, tolerance) in solves.items():
            runs[code].append(measure_run(solve, case, tolerance))
    return {code: take_median(several) for code, several in runs.items()}


def take_median(runs: list[Run]) -> Run:
    """Return the last of several runs with the median of their times."""
    return attrs.evolve(runs[-1], cpu=statistics.median(run.cpu for run in runs))


@attrs.frozen(eq=False)
class Push:
    """The first tangential force on a contact with friction: what it moves, the traction, and what it cost."""

    displacement: float
    shear: np.ndarray
    pressure: np.ndarray
    iterations: int
    cpu: float
    tolerance: float | None = None


FRICTION = 0.3
PUSHED = 0.5


def measure_slip(push: Push, influence: np.ndarray, own: float) -> float:
    """Return the natural residual of stick and slip over the largest limit, by numpy's FFT (nu = 0: axis by axis)."""
    n = push.pressure.shape[0]
    moved = [np.fft.irfft2(np.fft.rfft2(part, s=(2 * n, 2 * n)) * influence)[:n, :n] for part in push.shear]
    limit = FRICTION * push.pressure
    tried = push.shear + (np.array([push.displacement, 0.0])[:, None, None] - moved) / own
    return float(np.hypot(*(push.shear - project(tried, limit))).max() / limit.max())


def project(shear: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Return the nearest traction within the limit of each cell."""
    size = np.hypot(*shear)
    return shear * np.where(size > limit, limit / np.where(size > 0.0, size, 1.0), 1.0)


def push_ours(case: Case) -> Push:
    body = rc.Body(rc.HeightMap(case.heights, size=float(case.heights.shape[0])), rc.Elastic(2.0, 0.0))
    problem = rc.ContactProblem(
        body, rc.Body(rc.FlatSurface(), rc.Elastic(2.0, 0.0)), boundary="free", kernel="love", threads=1
    )
    force = case.mean * case.heights.size
    begin = time.process_time()
    path = problem.path(
        force=[force], tangential_force=[(PUSHED * FRICTION * force, 0.0)], friction=FRICTION, substeps=1
    )
    spent = time.process_time() - begin
    state = path[0]
    return Push(
        state.tangential_displacement[0],
        np.array(state.shear),
        np.array(state.pressure),
        state.sheared.iterations,
        spent,
    )


def push_aspher(case: Case, tolerance: float) -> Push:
    from aspher import CoulombFriction, FrictionSolver

    n = case.heights.shape[0]
    begin = time.process_time()
    solver = FrictionSolver(n, float(n), 1.0, 0.0, CoulombFriction(FRICTION))
    solver.set_gap(np.ascontiguousarray(case.heights.max() - case.heights))
    found = solver.step(
        p_bar=case.mean, q_bar=(PUSHED * FRICTION * case.mean, 0.0), tol_tangential=tolerance, tol_kkt=1.0
    )
    spent = time.process_time() - begin
    return Push(
        float(found.delta_t[0]),
        np.stack([np.reshape(part, (n, n)) for part in (found.qx, found.qy)]),
        np.reshape(solver.pressure, (n, n)),
        found.tangential_iters,
        spent,
        tolerance,
    )


def compare_friction(cells: int = 128) -> None:
    """Print the first step of a path with friction by ours and ASPHER, both judged on their own pressure."""
    case = Case(f"friction, {cells}", make_rough(cells), 0.05 * SLOPE, "free")
    offsets = np.minimum(np.arange(2 * cells), 2 * cells - np.arange(2 * cells)).astype(int)
    table = rc.Love().coefficients((cells + 1, cells + 1), (1.0, 1.0), 1.0)
    influence = np.fft.rfft2(table[np.ix_(offsets, offsets)])
    push_ours(case)
    mine = push_ours(case)
    required = measure_slip(mine, influence, table[0, 0])
    print("| code | iterations | CPU, s | residual of stick and slip | displacement | traction, of the largest |")
    print("|---|---|---|---|---|---|")
    print(f"| ours | {mine.iterations} | {mine.cpu:.2f} | {required:.0e} | {mine.displacement:.6g} | - |")
    if importlib.util.find_spec("aspher") is None:
        return
    for rung in range(RUNGS):
        other = push_aspher(case, 1e-4 * STEPS[rung % len(STEPS)] * 10.0 ** -(rung // len(STEPS)))
        residual = measure_slip(other, influence, table[0, 0])
        if residual <= required:
            break
    moved = other.displacement / mine.displacement - 1.0
    sheared = np.abs(other.shear - mine.shear).max() / np.abs(mine.shear).max()
    print(
        f"| ASPHER, tolerance {other.tolerance:.0e} | {other.iterations} | {other.cpu:.2f} | {residual:.0e} "
        f"| {other.displacement:.6g} ({moved:+.0e}) | {sheared:.0e} |"
    )


def compare_in_process(name: str, options: list[str]) -> dict[str, Run]:
    """Return the runs of one case in a process of its own."""
    command = [sys.executable, __file__, "--case", name, *options]
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    return {code: Run(**values) for code, values in json.loads(output.splitlines()[-1]).items()}


def make_rows(largest: int = 1024, only: str = "") -> list[list[str]]:
    """Return the table, CPU times on one thread."""
    rows = [["case", *COLUMNS]]
    for case in make_cases(largest):
        if only not in case.name:
            continue
        options = ["--largest", str(largest)]
        runs = compare_in_process(case.name, options)
        required = max(REQUIRED, runs["ours"].violation)
        times = [format_run(runs.get(code), required) for code in ("ours", *PEERS)]
        ratios = [format_ratio(runs.get(code), runs["ours"]) for code in ("tamaas", "ASPHER")]
        rows.append([name_case(case), *times, *ratios])
        print(" | ".join(rows[-1]), flush=True)
    return rows


def name_case(case: Case) -> str:
    """Return the name of a case with the cells along both sides."""
    name, cells = case.name.rsplit(", ", 1)
    return f"{name}, {cells} x {cells}"


def make_small_rows() -> list[list[str]]:
    """Return the table of small grids, each contact in a process of its own on one thread."""
    rows = [["case", *SMALL_COLUMNS]]
    for case in make_small_cases():
        runs = compare_in_process(case.name, ["--small"])
        required = max(REQUIRED, *(runs[code].violation for code in OURS if code in runs))
        entries = [format_run(runs.get(code), required, 1e3) for code in (*OURS, *PEERS)]
        ratios = [format_ratio(runs.get("ASPHER"), runs.get(code)) for code in OURS]
        rows.append([name_case(case), *entries, *ratios])
        print(" | ".join(rows[-1]), flush=True)
    return rows


def format_run(run: Run | None, required: float, unit: float = 1.0) -> str:
    """Return a CPU time, in units of a second over `unit`, and in brackets a violation above what is required."""
    if run is None:
        return "-"
    missed = "" if run.violation <= required else f" ({run.violation:.0e})"
    spent = unit * run.cpu
    return f"{spent:.0f}{missed}" if spent >= 100.0 else f"{spent:.3g}{missed}"


def format_ratio(other: Run | None, own: Run | None) -> str:
    if other is None or own is None:
        return "-"
    ratio = other.cpu / own.cpu
    return f"{ratio:.0f}" if ratio >= 100.0 else f"{ratio:.2g}"


SHOWN_SMALL = [column for column in ("case", *SMALL_COLUMNS) if column != "slippy, ms"]
LISTED = (
    *(f"x = {x}, 1024 x 1024" for x in (0.2, 1.0, 1.5)),
    *(f"{name}, {cells} x {cells}" for name in ("x = 0.05", "adhesion") for cells in (512, 1024)),
    *(f"{name}, 1024 x 1024" for name in ("bi-sinusoid", "Hertz, free")),
    "hardness 0.3 slope, x = 0.05, 512 x 512",
)
TABLES = {
    "other-codes": DocTable(make_rows, seconds=1500, timed=COLUMNS, shown=pick(["case", *COLUMNS], LISTED)),
    "small-codes": DocTable(make_small_rows, seconds=200, timed=SMALL_COLUMNS, shown=pick(SHOWN_SMALL)),
}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--largest", type=int, default=1024, help="print the lines up to these cells along a side (1024)"
    )
    parser.add_argument("--only", default="", help="print the lines of the cases whose name contains this")
    parser.add_argument("--friction", action="store_true", help="the first step of a path with friction instead")
    parser.add_argument("--small", action="store_true", help="the table of small grids instead, written to its page")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.friction:
        compare_friction()
    elif options.case is not None:
        cases = make_small_cases() if options.small else make_cases(options.largest)
        chosen = next(case for case in cases if case.name == options.case)
        found = compare_small(chosen) if options.small else compare(chosen)
        print(json.dumps({code: attrs.asdict(run) for code, run in found.items()}))
    elif options.only or options.largest != 1024:
        print(format_rows(make_rows(options.largest, options.only)))
    else:
        name = "small-codes" if options.small else "other-codes"
        write_tables({name: TABLES[name]})
