"""``roughcontact solve``: height maps in, summary, fields and picture out."""

from __future__ import annotations

import argparse
from pathlib import Path

from roughcontact.body import RIGID_FLAT, Body
from roughcontact.cli.picture import draw_solution
from roughcontact.cli.units import quantity
from roughcontact.errors import InputError
from roughcontact.files import read_surface, write_solution
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import FlatSurface, HeightMap, Surface


def add_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the command."""
    metre, pascal = quantity("m"), quantity("Pa")
    parser.add_argument("surface", help="height map of the body: npz, npy, txt, or an instrument's file")
    parser.add_argument("counter", nargs="?", help="height map of the other body; a flat if left out")
    load = parser.add_mutually_exclusive_group(required=True)
    load.add_argument("--pressure", type=pascal, metavar="P", help="nominal mean pressure, such as 100MPa")
    load.add_argument("--force", type=quantity("N"), metavar="F", help="normal force, such as 2.5N")
    parser.add_argument("--young", type=pascal, required=True, metavar="E", help="Young's modulus, such as 210GPa")
    parser.add_argument(
        "--poisson", type=quantity("dimensionless"), default=0.3, metavar="NU", help="Poisson's ratio (0.3)"
    )
    parser.add_argument("--hardness", type=pascal, metavar="H", help="pressure at which the body flows, such as 6GPa")
    parser.add_argument(
        "--counter-young",
        type=pascal,
        metavar="E",
        help="Young's modulus of the other body; rigid if left out",
    )
    parser.add_argument(
        "--counter-poisson",
        type=quantity("dimensionless"),
        default=0.3,
        metavar="NU",
        help="its Poisson's ratio (0.3)",
    )
    parser.add_argument("--counter-hardness", type=pascal, metavar="H", help="its hardness")
    parser.add_argument(
        "--size",
        type=metre,
        nargs="+",
        metavar="L",
        help="sides of the domain x [y], where the file does not tell",
    )
    parser.add_argument(
        "--missing",
        choices=("refuse", "fill"),
        default="refuse",
        help="what to do with missing points (refuse)",
    )
    parser.add_argument(
        "--detrend",
        type=int,
        metavar="DEGREE",
        help="take away the polynomial of this degree: 1 tilt, 2 curvature too",
    )
    parser.add_argument(
        "--resample", type=int, nargs=2, metavar=("NX", "NY"), help="bilinear resampling to this many cells"
    )
    parser.add_argument(
        "--boundary", choices=("free", "periodic", "wrapped"), default="free", help="beyond the border (free)"
    )
    parser.add_argument("--kernel", default="love", help="influence kernel (love)")
    parser.add_argument("--solver", default="auto", help="solver (auto)")
    parser.add_argument(
        "--area", default=None, metavar="ESTIMATOR", help="area estimator to report besides the default"
    )
    parser.add_argument(
        "-o",
        "--output",
        default="contact-results",
        metavar="FOLDER",
        help="where the results go (contact-results)",
    )


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
