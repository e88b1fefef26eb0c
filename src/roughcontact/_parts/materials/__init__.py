"""Materials: what a body is made of, as far as normal contact depends on it."""

from roughcontact._parts.materials.base import Material, combined_pressure_limit, contact_modulus, materials
from roughcontact._parts.materials.isotropic import Elastic, ElasticPerfectlyPlastic, Rigid
from roughcontact._parts.materials.typical import TYPICAL, resolve_material

__all__ = [
    "TYPICAL",
    "Elastic",
    "ElasticPerfectlyPlastic",
    "Material",
    "Rigid",
    "combined_pressure_limit",
    "contact_modulus",
    "materials",
    "resolve_material",
]
