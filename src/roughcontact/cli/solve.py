"""``roughcontact solve``: height maps in, summary, fields and picture out."""

from __future__ import annotations

import argparse
from pathlib import Path

from roughcontact.body import RIGID_FLAT, Body
from roughcontact.cli.picture import draw_solution
from roughcontact.errors import InputError
from roughcontact.files import read_surface, write_solution
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import FlatSurface, HeightMap, Surface


def run(options: argparse.Namespace) -> None:
    """Read, solve, print the summary, write fields and picture."""
    body = Body(_surface(options.surface, options), _material(options.young, options.poisson, options.hardness))
    problem = ContactProblem(
        body, _counter(options), boundary=options.boundary, kernel=options.kernel, solver=options.solver
    )
    print(problem.explain())
    solution = problem.solve(pressure=options.pressure, force=options.force)
    print(f"\n{solution}")
    if options.area is not None:
        print(f"{'':17}{solution.area(options.area)}")
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    write_solution(folder / "solution.npz", solution)
    draw_solution(solution, folder / "solution.png")
    print(f"\nWritten to {folder}: solution.npz, solution.png")


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
        if options.counter_hardness is not None:
            raise InputError("A rigid body has no hardness: give --counter-young together with --counter-hardness.")
        return Body(surface, RIGID_FLAT.material)
    return Body(surface, _material(options.counter_young, options.counter_poisson, options.counter_hardness))


def _material(young: float, poisson: float, hardness: float | None) -> Material:
    if hardness is None:
        return Elastic(young, poisson)
    return ElasticPerfectlyPlastic(young, poisson, hardness)
