"""``roughcontact solve``: height maps in, summary, fields and picture out."""

from __future__ import annotations

import argparse
from pathlib import Path

from roughcontact.body import RIGID_FLAT, Body
from roughcontact.cli.picture import draw_solution
from roughcontact.errors import InputError, NotConverged
from roughcontact.files import read_surface
from roughcontact.files.reading import read_raw
from roughcontact.grid import Grid
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact.problem import ContactProblem
from roughcontact.registry import areas
from roughcontact.solution import EstimatesArea
from roughcontact.surfaces import FlatSurface, HeightMap, SphereSurface, Surface, match
from roughcontact.surfaces.base import own_grid

_OF_COUNTER = ("match", "counter-size", "counter-unit", "counter-detrend")


def run(options: argparse.Namespace) -> None:
    """Read, solve, print the summary, write fields and picture."""
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    estimator = None if options.area is None else areas.resolve(options.area, EstimatesArea)
    problem = problem_of(options)
    print(problem.explain())
    solution = problem.solve(pressure=options.pressure, force=options.force, approach=options.approach, throw=False)
    print(f"\n{solution}")
    if estimator is not None:
        print(f"{'':17}{solution.area(estimator)}")
    solution.save(folder / "solution.npz")
    draw_solution(solution, folder / "solution.png")
    print(f"\nWritten to {folder}: solution.npz, solution.png")
    if not solution.status.success:
        raise NotConverged(f"The contact is {solution.status}; what was reached is in {folder}.", solution)


def problem_of(options: argparse.Namespace) -> ContactProblem:
    """Return the problem that the options describe."""
    surface, counter, grid = _surfaces(options)
    if options.ball is not None:
        surface, grid = surface + SphereSurface(options.ball), grid or own_grid(surface)
    return ContactProblem(
        Body(surface, _material(options.young, options.poisson, options.hardness)),
        Body(counter, _counter_material(options)),
        grid=grid,
        boundary=options.boundary,
        kernel=options.kernel,
        solver=options.solver,
    )


def _surfaces(options: argparse.Namespace) -> tuple[Surface, Surface, Grid | None]:
    """Return both surfaces and the grid, if they do not carry it."""
    form, size, unit = options.detrend, options.size, options.unit
    body = _read(options.surface, options, size, unit, form)
    if options.counter is None:
        _refuse_without_counter(options)
        return _scaled(body, options), FlatSurface(), None
    counter_form = form if options.counter_detrend is None else options.counter_detrend
    counter = _read(options.counter, options, *_told_of_counter(options), counter_form)
    if options.match is None:
        _refuse_without_match(options)
        return _scaled(body, options), _scaled(counter, options), None
    pair = match(
        body,
        counter,
        offset=options.offset or (0.0, 0.0),
        rotation=options.rotation or 0.0,
        mirrored=options.mirror,
        method=options.match,
        shape=options.resample,
        size=_sides(options.domain),
    )
    return pair.body, pair.counter, pair.grid


def _told_of_counter(options: argparse.Namespace) -> tuple[list[float] | None, float | None]:
    """Return size and unit of the second map: its own, or those of the first where its file does not tell."""
    size, unit = options.counter_size, options.counter_unit
    if size is None or unit is None:
        raw = read_raw(Path(options.counter))
        size = options.size if size is None and raw.size is None else size
        unit = options.unit if unit is None and not raw.metric else unit
    return size, unit


def _refuse_without_counter(options: argparse.Namespace) -> None:
    given = {f"--{name}": getattr(options, name.replace("-", "_")) for name in _OF_COUNTER}
    for name, value in given.items():
        if value is not None:
            raise InputError(f"{name} is for the second of two height maps: give its file too, or leave it out.")
    _refuse_without_match(options)


def _refuse_without_match(options: argparse.Namespace) -> None:
    given = {"--offset": options.offset, "--rotation": options.rotation, "--domain": options.domain}
    given["--mirror"] = options.mirror or None
    for name, value in given.items():
        if value is not None:
            raise InputError(f"{name} is for two maps that are interpolated: give both, and --match bilinear.")


def _read(
    path: str, options: argparse.Namespace, size: list[float] | None, unit: float | None, form: str | int | None
) -> HeightMap:
    surface = read_surface(path, size=_sides(size), unit=unit, missing=options.missing)
    # The trend goes first: its fit should see every measured point.
    return surface if form is None else surface.detrend(form)


def _scaled(surface: HeightMap, options: argparse.Namespace) -> HeightMap:
    return surface if options.resample is None else surface.resample(options.resample)


def _sides(lengths: list[float] | None) -> float | list[float] | None:
    if lengths is not None and len(lengths) > 2:
        raise InputError.about("The size of the domain", lengths, "one length or two, x and y")
    return lengths[0] if lengths and len(lengths) == 1 else lengths


def _counter_material(options: argparse.Namespace) -> Material:
    if options.counter_young is None:
        if options.counter_hardness is not None or options.counter_poisson is not None:
            raise InputError(
                "The other body is rigid: give --counter-young with --counter-poisson or --counter-hardness."
            )
        return RIGID_FLAT.material
    poisson = options.poisson if options.counter_poisson is None else options.counter_poisson
    return _material(options.counter_young, poisson, options.counter_hardness)


def _material(young: float, poisson: float, hardness: float | None) -> Material:
    if hardness is None:
        return Elastic(young, poisson)
    return ElasticPerfectlyPlastic(young, poisson, hardness)
