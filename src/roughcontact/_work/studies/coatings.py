"""Layers on bodies in tables, which are the kernel of a problem, and the material that a kernel shares with a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import attrs

from roughcontact._base.archive.plain import parts
from roughcontact._parts.kernels import InfluenceKernel, kernels
from roughcontact._parts.materials import TYPICAL, Elastic, ElasticPerfectlyPlastic, Material, Rigid
from roughcontact.errors import InputError, MissingPackage, argument

# Reads an entry of a table by its kind and its place; see `Form.read`.
Read: TypeAlias = Callable[[Any, Any, str], Any]

BODIES = ("body", "counterbody")
# The entry of a body, and the registered names of a layer, of the kernel of one body with layers, and of two.
LAYERS = "layers"
_LAYER = "layer"
LAYERED = "layered"
_TWO = "pair"


def find_layer_class() -> type[Any]:
    """Return the class of a layer; `MissingPackage` without the plug-in that has it."""
    if _LAYER not in parts:
        raise MissingPackage(
            "Layers on a body need the package roughcontact-layered: pip install roughcontact-layered, in a clone of "
            "the repository pip install ./plugins/roughcontact-layered."
        )
    return parts[_LAYER]


def read_layers(table: Mapping[str, Any], read: Read) -> Mapping[str, Any]:
    """Return the table of a problem in which the layers of its bodies are the kernel; itself without layers.

    A body of which the layers lie on a rigid base has the constants of the topmost layer. Typical values by name lack
    their hardness there: it is that of the body under the layers, which nothing touches.
    """
    sides = {name: table[name] for name in BODIES if isinstance(table.get(name), Mapping) and LAYERS in table[name]}
    if not sides:
        return table
    if table.get("kernel") not in (None, LAYERED, _TWO):
        raise InputError(
            f"The layers of a body are the kernel of the problem: omit {argument('kernel')}, or the layers."
        )
    layer = find_layer_class()
    bodies = {}
    coatings = {}
    for name, side in sides.items():
        given = [side[LAYERS]] if isinstance(side[LAYERS], (Mapping, layer)) else side[LAYERS]
        layers = read(tuple[layer, ...], given, f"{name}.{LAYERS}")  # type: ignore[valid-type]
        material = read(Material, side.get("material", "rigid"), f"{name}.material")
        if material is None or layers is None or None in layers:
            # What is wrong has been noted.
            return table
        if not layers:
            raise InputError.about(f"The layers of the {name}", given, "one layer or more, from the surface downwards")
        if side.get("material") in TYPICAL and isinstance(material, ElasticPerfectlyPlastic):
            material = _without_hardness(material)
        on_rigid = isinstance(material, Rigid)
        own = _without_hardness(layers[0]) if on_rigid else material
        bodies[name] = {**{key: one for key, one in side.items() if key != LAYERS}, "material": own}
        substrate = material if on_rigid else _without_hardness(material)
        coatings[name] = {"type": LAYERED, LAYERS: layers, "substrate": substrate, "carrier": name}
    kernel = {"type": _TWO, **coatings} if len(coatings) > 1 else next(iter(coatings.values()))
    return {**table, **bodies, "kernel": read(InfluenceKernel, kernel, "kernel")}


def _without_hardness(one: Any) -> Any:
    """Return the isotropic elastic body with the constants of a material or a layer; others as they are."""
    young, poisson = (getattr(one, name, None) for name in ("young", "poisson"))
    return one if young is None or poisson is None else Elastic(young, poisson)


def complete_kernel(kernel: Any, read: Read, table: Mapping[str, Any]) -> Any:
    """Return the table of a kernel, with the material of the body that is not rigid where a field lacks it.

    Such a field has ``material`` in its metadata; of two bodies that deform it is that of the body.
    """
    name = kernel.get("type") if isinstance(kernel, Mapping) else kernel
    cls: Any = kernels[name] if isinstance(name, str) and name in kernels else None
    if cls is None or not attrs.has(cls):
        return kernel
    given = dict(kernel) if isinstance(kernel, Mapping) else {"type": name}
    wanted = [field.name for field in attrs.fields(cls) if field.metadata.get("material")]
    for field in wanted:
        if field not in given:
            materials = [_material_of(table.get(body), read, body) for body in BODIES]
            given[field] = next((one for one in materials if one is not None and not isinstance(one, Rigid)), None)
    return given if wanted else kernel


def _material_of(body: Any, read: Read, name: str) -> Material | None:
    if isinstance(body, Mapping):
        found: Material | None = read(Material, body.get("material", "rigid"), f"{name}.material")
        return found
    return getattr(body, "material", None)
