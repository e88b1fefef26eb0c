"""``roughcontact solve``: height maps in, summary, fields and picture out."""

from __future__ import annotations

import argparse
from pathlib import Path

from roughcontact.body import RIGID_FLAT, Body
from roughcontact.cli.picture import draw_solution
from roughcontact.errors import InputError, NotConverged
from roughcontact.files import read_surface, write_solution
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact.problem import ContactProblem
from roughcontact.registry import areas
from roughcontact.solution import EstimatesArea
from roughcontact.surfaces import FlatSurface, HeightMap, Surface


def run(options: argparse.Namespace) -> None:
    """Read, solve, print the summary, write fields and picture."""
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    estimator = None if options.area is None else areas.resolve(options.area, EstimatesArea)
    body = Body(_surface(options.surface, options), _material(options.young, options.poisson, options.hardness))
    problem = ContactProblem(
        body, _counter(options), boundary=options.boundary, kernel=options.kernel, solver=options.solver
    )
    print(problem.explain())
    solution = problem.solve(pressure=options.pressure, force=options.force, approach=options.approach, throw=False)
    print(f"\n{solution}")
    if estimator is not None:
        print(f"{'':17}{solution.area(estimator)}")
    write_solution(folder / "solution.npz", solution)
    draw_solution(solution, folder / "solution.png")
    print(f"\nWritten to {folder}: solution.npz, solution.png")
    if not solution.status.success:
        raise NotConverged(f"The contact is {solution.status}; what was reached is in {folder}.", solution)


def _surface(path: str, options: argparse.Namespace) -> HeightMap:
    size = options.size
    if size is not None and len(size) > 2:
        raise InputError.about("The size of the domain", size, "one length or two, x and y")
    surface = read_surface(path, size=size[0] if size and len(size) == 1 else size, missing=options.missing)
    # The trend goes first: its fit should see every measured point.
    if options.detrend is not None:
        surface = surface.detrend(options.detrend)
    return surface if options.resample is None else surface.resample(options.resample)


def _counter(options: argparse.Namespace) -> Body:
    surface: Surface = FlatSurface() if options.counter is None else _surface(options.counter, options)
    if options.counter_young is None:
        if options.counter_hardness is not None or options.counter_poisson is not None:
            raise InputError(
                "The other body is rigid: give --counter-young with --counter-poisson or --counter-hardness."
            )
        return Body(surface, RIGID_FLAT.material)
    poisson = options.poisson if options.counter_poisson is None else options.counter_poisson
    return Body(surface, _material(options.counter_young, poisson, options.counter_hardness))


def _material(young: float, poisson: float, hardness: float | None) -> Material:
    if hardness is None:
        return Elastic(young, poisson)
    return ElasticPerfectlyPlastic(young, poisson, hardness)
