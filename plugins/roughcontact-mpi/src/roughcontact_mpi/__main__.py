"""The command ``mpiexec -n 4 python -m roughcontact_mpi map.npy ...``."""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
from collections.abc import Sequence

import roughcontact as rc
from roughcontact.typing import quantity

from roughcontact_mpi.contact import solve
from roughcontact_mpi.files import read_heights
from roughcontact_mpi.processes import Processes, ending_all

_METRE, _PASCAL, _NEWTON, _NUMBER = (quantity(unit) for unit in ("m", "Pa", "N", ""))
_EPILOG = """
example:
  mpiexec -n 4 python -m roughcontact_mpi map.npy --size 1mm --pressure 10MPa --young 210GPa \\
      --boundary periodic -o out/

The folder gets pressure.npy, displacement.npy and gap.npy, in Pa and m, and numbers.json.
Defaults are in parentheses."""


def _unit(text: str) -> float:
    """Return the length that a height of one means: ``um`` alone is ``1um``."""
    return _METRE(f"1{text}" if text[:1].isalpha() else text)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m roughcontact_mpi",
        description="Solve one contact by several processes, each with a slab of the map.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("map", help="heights in a .npy file with two axes, along x and y")
    parser.add_argument(
        "--size", type=_METRE, nargs="+", required=True, metavar="L", help="both sides, or LX LY: 1mm 0.5mm"
    )
    parser.add_argument(
        "--unit", type=_unit, default="m", metavar="U", help="unit of the heights in the file, such as um (m)"
    )
    load = parser.add_mutually_exclusive_group(required=True)
    load.add_argument("--pressure", type=_PASCAL, metavar="P", help="nominal mean pressure, such as 100MPa")
    load.add_argument("--force", type=_NEWTON, metavar="F", help="normal force, such as 2.5N")
    load.add_argument("--approach", type=_METRE, metavar="D", help="approach since first contact, such as 50nm")
    body = parser.add_mutually_exclusive_group(required=True)
    body.add_argument("--young", type=_PASCAL, metavar="E", help="Young's modulus, such as 210GPa")
    body.add_argument("--material", metavar="NAME", help="a typical material, such as steel")
    parser.add_argument("--poisson", type=_NUMBER, metavar="NU", help="Poisson's ratio (0.3)")
    parser.add_argument("--hardness", type=_PASCAL, metavar="H", help="maximum contact pressure, such as 2GPa (none)")
    parser.add_argument("--boundary", choices=["free", "periodic"], default="free", help="(free)")
    parser.add_argument("--kernel", default="love", metavar="NAME", help="influence kernel (love)")
    parser.add_argument("--tolerance", type=_NUMBER, metavar="T", help="tolerance of the solver (1e-5)")
    parser.add_argument("--stiffness", action="store_true", help="also the normal stiffness, by one more solve")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="folder for the fields and numbers")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    return parser


def _material(options: argparse.Namespace) -> rc.Material | str:
    if options.material is not None:
        if options.poisson is not None or options.hardness is not None:
            raise rc.InputError("--poisson and --hardness belong to --young: a material has its own.")
        return str(options.material)
    poisson = 0.3 if options.poisson is None else options.poisson
    if options.hardness is None:
        return rc.Elastic(young=options.young, poisson=poisson)
    return rc.ElasticPerfectlyPlastic(young=options.young, poisson=poisson, hardness=options.hardness)


def _run(processes: Processes, options: argparse.Namespace) -> None:
    if len(options.size) > 2:
        raise rc.InputError.about("--size", options.size, "one length or two")
    material = _material(options)
    heights = read_heights(options.map, processes, unit=options.unit)
    solution = solve(
        heights,
        options.size if len(options.size) == 2 else options.size[0],
        material,
        pressure=options.pressure,
        force=options.force,
        approach=options.approach,
        boundary=options.boundary,
        kernel=options.kernel,
        tolerance=options.tolerance,
    )
    if options.stiffness:
        solution.stiffness()
    text = solution.describe()
    if options.output is not None:
        solution.save(options.output)
    if processes.rank == 0 and not options.quiet:
        print(text, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status 0, or 2 where there is no MPI."""
    try:
        processes = Processes()
    except rc.InputError as error:
        print(f"roughcontact_mpi: {error}", file=sys.stderr)
        return 2
    with contextlib.ExitStack() as stack:
        if processes.rank:
            # All read the same arguments; one tells what is wrong with them.
            silent = io.StringIO()
            stack.enter_context(contextlib.redirect_stderr(silent))
            stack.enter_context(contextlib.redirect_stdout(silent))
        options = _parser().parse_args(arguments)
    with ending_all(processes):
        _run(processes, options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
