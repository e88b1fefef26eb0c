"""The command ``mpiexec -n 4 roughcontact slabs map.npy ...``."""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import Any

import roughcontact as rc
from roughcontact.faces import build_part
from roughcontact.typing import Command, quantity

_METRE, _PASCAL, _NEWTON, _NUMBER = (quantity(unit) for unit in ("m", "Pa", "N", ""))
# Where the mpiexec of MPICH and of Open MPI states the number of a process.
_RANKS = ("PMI_RANK", "OMPI_COMM_WORLD_RANK")


class Slabs(Command):
    """Solve one contact by the processes of mpiexec, each with a slab."""

    epilog = """
examples:
  mpiexec -n 4 roughcontact slabs map.npy --size 1mm --pressure 10MPa \\
      --young 210GPa --boundary periodic -o out.zarr
  mpiexec -n 4 roughcontact slabs --shape 8192 8192 --size 1mm \\
      --self-affine hurst=0.8 rms_slope=0.1 shortest=1um longest=1mm \\
      --pressure 10MPa --young 210GPa --boundary periodic -o out

A folder gets pressure.npy, displacement.npy, gap.npy, in Pa and m, and
numbers.json.
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Declare heights, load, bodies and output."""
        _leave_words_to_one(parser)
        _add_heights(parser)
        load = parser.add_mutually_exclusive_group(required=True)
        load.add_argument("--pressure", type=_PASCAL, metavar="P", help="nominal mean pressure, such as 100MPa")
        load.add_argument("--force", type=_NEWTON, metavar="F", help="normal force, such as 2.5N")
        load.add_argument("--approach", type=_METRE, metavar="D", help="approach since first contact, such as 50nm")
        body = parser.add_mutually_exclusive_group(required=True)
        body.add_argument("--young", type=_PASCAL, metavar="E", help="Young's modulus, such as 210GPa")
        body.add_argument("--material", metavar="NAME", help="a typical material, such as 'bearing steel'")
        parser.add_argument("--poisson", type=_NUMBER, metavar="NU", help="Poisson's ratio (0.3)")
        parser.add_argument("--hardness", type=_PASCAL, metavar="H", help="maximum contact pressure (none)")
        boundaries = [str(one) for one in rc.Boundary if one is not rc.Boundary.WRAPPED]
        words = f"what lies beyond the domain, {', '.join(boundaries)} (free)"
        parser.add_argument("--boundary", choices=boundaries, default="free", metavar="WORD", help=words)
        parser.add_argument("--kernel", default="love", metavar="NAME", help="influence kernel (love)")
        parser.add_argument("--tolerance", type=_NUMBER, metavar="T", help="tolerance of the solver (1e-5)")
        parser.add_argument("--stiffness", action="store_true", help="also the normal stiffness, by one more solve")
        parser.add_argument("-o", "--output", metavar="PLACE", help="a folder, or a zarr store, NAME.zarr")
        parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")

    def run(self, options: argparse.Namespace) -> int:
        """Solve as one of the processes; the first prints the numbers. Return 0."""
        from roughcontact_mpi.processes import Processes

        processes = Processes()
        with processes.ending_all():
            _run(processes, options)
        return 0


def _leave_words_to_one(parser: argparse.ArgumentParser) -> None:
    """Let one process alone print the help, or what is wrong with the arguments, which all read."""
    if any(int(os.environ.get(name, "0")) for name in _RANKS):
        silent: Any = parser
        silent.print_help = lambda *_: None
        silent.error = lambda _: sys.exit(2)


def _add_heights(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("map", nargs="?", help="heights in a .npy file with two axes, along x and y")
    parser.add_argument(
        "--self-affine",
        nargs="+",
        metavar="FIELD=VALUE",
        help="random heights instead, as of 'roughcontact surface self-affine', such as hurst=0.8",
    )
    parser.add_argument("--shape", type=_whole_number, nargs=2, metavar=("NX", "NY"), help="cells of random heights")
    parser.add_argument(
        "--size", type=_METRE, nargs="+", required=True, metavar="L", help="both sides, or LX LY: 1mm 0.5mm"
    )
    parser.add_argument("--unit", type=_unit, metavar="U", help="unit of the heights in the file, such as um (m)")


def _whole_number(text: str) -> int:
    """Return text such as ``256`` as an int."""
    if not re.fullmatch(r"[-+]?[0-9]{1,18}", text):
        raise argparse.ArgumentTypeError(f"{text[:80]!r} is not a whole number; write it like 256")
    return int(text)


def _unit(text: str) -> float:
    """Return the length that a height of one means: ``um`` alone is ``1um``."""
    return _METRE(f"1{text}" if text[:1].isalpha() else text)


def _heights(processes: Any, options: argparse.Namespace) -> Any:
    """Return the heights in slabs."""
    from roughcontact_mpi.contact import Contacts
    from roughcontact_mpi.files import read_heights

    size = _size(options)
    if (options.map is None) == (options.self_affine is None):
        raise rc.InputError("Give either the file of a map or --self-affine.")
    if options.self_affine is None:
        if options.shape is not None:
            raise rc.InputError("--shape is for --self-affine: a map has its cells.")
        return read_heights(options.map, processes, unit=1.0 if options.unit is None else options.unit)
    if options.shape is None or options.unit is not None:
        raise rc.InputError("--self-affine needs --shape, and has no --unit.")
    fields = dict(_field(text) for text in options.self_affine)
    surface = build_part(rc.surfaces, "self-affine", fields, "--self-affine")
    return Contacts.make_heights(surface, rc.Grid(options.shape, size), processes)


def _field(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise rc.InputError.about("A field of --self-affine", text, "FIELD=VALUE, such as hurst=0.8")
    return name, value


def _size(options: argparse.Namespace) -> Any:
    if len(options.size) > 2:
        raise rc.InputError.about("--size", options.size, "one length or two")
    return options.size if len(options.size) == 2 else options.size[0]


def _material(options: argparse.Namespace) -> rc.Material | str:
    if options.material is not None:
        if options.poisson is not None or options.hardness is not None:
            raise rc.InputError("--poisson and --hardness belong to --young: a material has its own.")
        return str(options.material)
    poisson = 0.3 if options.poisson is None else options.poisson
    if options.hardness is None:
        return rc.Elastic(young=options.young, poisson=poisson)
    return rc.ElasticPerfectlyPlastic(young=options.young, poisson=poisson, hardness=options.hardness)


def _run(processes: Any, options: argparse.Namespace) -> None:
    from roughcontact_mpi.contact import Contacts
    from roughcontact_mpi.files import require_place

    material = _material(options)
    if options.output is not None:
        require_place(Path(options.output))
    solution = Contacts.solve(
        _heights(processes, options),
        _size(options),
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
    text = str(solution)
    if options.output is not None:
        solution.save(options.output)
    if processes.rank == 0 and not options.quiet:
        print(text, flush=True)
