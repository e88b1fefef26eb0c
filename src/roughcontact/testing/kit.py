"""The claims by kind, and the report on one part."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from types import MappingProxyType

from roughcontact import registry
from roughcontact.areas import AreaEstimator
from roughcontact.checks import choice
from roughcontact.convolvers import Convolver
from roughcontact.errors import InputError
from roughcontact.files import SurfaceReader
from roughcontact.flattening import PermanentSet
from roughcontact.kernels import InfluenceKernel
from roughcontact.materials import Material
from roughcontact.solvers import Solver
from roughcontact.surfaces import Surface
from roughcontact.testing import areas, convolvers, kernels, materials, readers, sets, solvers, surfaces
from roughcontact.testing.claim import Claim, Report

KINDS: Mapping[str, registry.Registry] = MappingProxyType(
    {
        "kernel": registry.kernels,
        "convolver": registry.convolvers,
        "solver": registry.solvers,
        "area": registry.areas,
        "set": registry.sets,
        "material": registry.materials,
        "surface": registry.surfaces,
        "reader": registry.readers,
    }
)
_BASES: Mapping[str, type] = {
    "kernel": InfluenceKernel,
    "convolver": Convolver,
    "solver": Solver,
    "area": AreaEstimator,
    "set": PermanentSet,
    "material": Material,
    "surface": Surface,
    "reader": SurfaceReader,
}
_CLAIMS: Mapping[str, tuple[Claim, ...]] = {
    room.CLAIMS[0].kind: room.CLAIMS
    for room in (kernels, convolvers, solvers, areas, sets, materials, surfaces, readers)
}


def claims(kind: str) -> tuple[Claim, ...]:
    """Return what every part of a kind must do, to be tried one by one.

    Parameters
    ----------
    kind
        One of `KINDS`: ``"kernel"``, ``"convolver"``, ``"solver"``, ``"area"``, ``"set"``, ``"material"``,
        ``"surface"`` or ``"reader"``.

    Examples
    --------
    >>> import roughcontact as rc
    >>> import roughcontact.testing as kit
    >>> [str(claim) for claim in kit.claims("kernel")][5:8]
    ['even in x and y', 'each offset and wave alone', 'positive work']
    >>> kit.claims("kernel")[5].check(rc.Love())
    """
    return _CLAIMS[choice(kind, "The kind of part", tuple(KINDS))]


def check(part: object, kind: str | None = None) -> Report:
    """Return what was found of every claim about a part.

    Parameters
    ----------
    part
        An instance, not a class.
    kind
        What it is (see `claims`); found from its base class if left out.

    Raises
    ------
    InputError
        If it is of no known kind.
    """
    known = kind_of(part) if kind is None else kind
    name = textwrap.shorten(repr(part), 100, placeholder=" ...")
    return Report(name, known, tuple(claim.judge(part) for claim in claims(known)))


def kind_of(part: object) -> str:
    """Return the kind of a part, by its base class; see `claims`.

    Raises
    ------
    InputError
        If it has none of them.
    """
    for kind, base in _BASES.items():
        if isinstance(part, base):
            return kind
    bases = ", ".join(base.__name__ for base in _BASES.values())
    hint = "Pass an instance, not the class." if isinstance(part, type) else ""
    raise InputError.about("What is checked", part, f"an instance of one of {bases}", hint)
