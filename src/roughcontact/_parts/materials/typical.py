"""Typical materials by name: a first guess, not a certificate."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from roughcontact._parts.materials.base import Material, materials
from roughcontact._parts.materials.isotropic import Elastic, ElasticPerfectlyPlastic
from roughcontact.errors import InputError

# Young's modulus, Pa, Poisson's ratio, and Vickers hardness, Pa, as typical in textbooks, rounded. Polymers have no
# hardness here: they creep, and theirs depends on time.
TYPICAL: Mapping[str, Material] = MappingProxyType({
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
})  # fmt: skip


def resolve_material(choice: object) -> Material:
    """Return a material: an instance as it is, of a registered name a new one, of a typical one its values.

    Raises
    ------
    InputError
        If there is no material of that name, or it is not a material.
    """
    if isinstance(choice, str) and choice not in materials:
        if choice not in TYPICAL:
            raise InputError.unknown("material", choice, (*materials, *TYPICAL))
        return TYPICAL[choice]
    if isinstance(choice, (str, Material)):
        return materials.resolve(choice)
    raise InputError.about("The material of a body", choice, "a Material, or the name of one such as 'bearing steel'")
