"""Typical materials by name: those of this package, and those that installed distributions add."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points

from roughcontact._base.registry import Registry
from roughcontact._parts.materials.isotropic import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact.errors import InputError, NoSuchField

_GROUP = "roughcontact.typical"
# What stands before the name of an attribute that would begin with a digit, such as that of 1006 steel.
_BEFORE_DIGIT = "grade_"
# Young's modulus, Pa, Poisson's ratio, and Vickers hardness, Pa, as typical in textbooks, rounded. Polymers have no
# hardness here: they creep, so that it depends on time.
_OWN: Mapping[str, Material] = {
    "bearing steel": ElasticPerfectlyPlastic(210e9, 0.3, 7e9),
    "structural steel": ElasticPerfectlyPlastic(210e9, 0.3, 1.5e9),
    "stainless steel": ElasticPerfectlyPlastic(195e9, 0.3, 1.8e9),
    "grey cast iron": ElasticPerfectlyPlastic(120e9, 0.26, 2e9),
    "aluminium alloy": ElasticPerfectlyPlastic(70e9, 0.33, 1.1e9),
    "copper": ElasticPerfectlyPlastic(120e9, 0.34, 0.8e9),
    "brass": ElasticPerfectlyPlastic(100e9, 0.35, 1.2e9),
    "titanium alloy": ElasticPerfectlyPlastic(114e9, 0.34, 3.4e9),
    "silicon nitride": ElasticPerfectlyPlastic(310e9, 0.27, 15e9),
    "alumina": ElasticPerfectlyPlastic(370e9, 0.22, 16e9),
    "glass": ElasticPerfectlyPlastic(70e9, 0.22, 5.5e9),
    "PTFE": Elastic(0.5e9, 0.46),
    "PEEK": Elastic(3.8e9, 0.4),
    "rubber": Elastic(4e6, 0.495),
}  # fmt: skip


class TypicalMaterials(Mapping[str, Material]):
    """Materials by name, own ones and those of the entry points ``roughcontact.typical``, which are loaded when asked.

    Parameters
    ----------
    own
        The materials of this package, whose names no other may take.
    """

    def __init__(self, own: Mapping[str, Material]) -> None:
        self._known = dict(own)

    def __iter__(self) -> Iterator[str]:
        return iter({**self._known, **self._added})

    def __len__(self) -> int:
        return len({**self._known, **self._added})

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (name in self._known or name in self._added)

    def __getitem__(self, name: str) -> Material:
        if name not in self._known:
            self._known[name] = _load(self._added[name])
        return self._known[name]

    @cached_property
    def _added(self) -> dict[str, dict[str, EntryPoint]]:
        """Entry points by name and by the place that they name: a distribution may be on the path twice."""
        found: dict[str, dict[str, EntryPoint]] = {}
        for entry in sorted(entry_points(group=_GROUP), key=lambda one: one.name):
            found.setdefault(entry.name, {})[entry.value] = entry
        return found


def _load(claims: Mapping[str, EntryPoint]) -> Material:
    entry = next(iter(claims.values()))
    what = f"The typical material {entry.name!r}"
    if len(claims) > 1:
        raise InputError(f"{what} is claimed by {' and '.join(claims)}: uninstall one of them.")
    try:
        found = entry.load()
    except Exception as error:
        raise InputError(
            f"{what} is installed as {entry.value}, but cannot be loaded: {type(error).__name__}: {error}"
        ) from error
    if not isinstance(found, Material):
        raise InputError.about(what, found, "a Material")
    return found


TYPICAL: Mapping[str, Material] = TypicalMaterials(_OWN)


class MaterialRegistry(Registry[Material]):
    """The classes of materials by name, and typical materials as attributes: ``rc.materials.bearing_steel``.

    The attribute of a typical material is its name with underscores; ``grade_`` stands before a digit. A word that
    several names have, such as ``steel``, is refused.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.materials.bearing_steel
    ElasticPerfectlyPlastic(young=210000000000.0, poisson=0.3, hardness=7000000000.0)
    >>> rc.materials.steel
    Traceback (most recent call last):
        ...
    roughcontact.errors.NoSuchField: There is no material named 'steel'. Did you mean 'bearing_steel', ...
    """

    def __getattr__(self, name: str) -> Material:
        if name.startswith("_"):
            raise AttributeError(name)
        known = self._list_typical()
        if name not in known:
            raise NoSuchField.unknown("material", name, known)
        return TYPICAL[known[name]]

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *self._list_typical()]

    def __repr__(self) -> str:
        return f"{super().__repr__()}\ntypical ones: {', '.join(self._list_typical())}"

    def _list_typical(self) -> dict[str, str]:
        """Return the names of the typical materials by those of their attributes."""
        found = {}
        for name in TYPICAL:
            attribute = re.sub(r"\W+", "_", name).strip("_")
            found[f"{_BEFORE_DIGIT}{attribute}" if attribute[:1].isdigit() else attribute] = name
        return found


materials = MaterialRegistry(Material, "material", "roughcontact.materials")


def resolve_material(choice: object) -> Material:
    """Return a material that is given as an instance, by a registered name, or by the name of a typical one.

    `InputError` if there is no material of that name, or the choice is something else.
    """
    if isinstance(choice, str) and choice not in materials:
        if choice not in TYPICAL:
            raise InputError.unknown("material", choice, (*materials, *TYPICAL))
        return TYPICAL[choice]
    if isinstance(choice, (str, Material)):
        return materials.resolve(choice)
    raise InputError.about("The material of a body", choice, "a Material, or the name of one such as 'bearing steel'")
