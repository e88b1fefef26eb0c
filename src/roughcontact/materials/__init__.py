"""Materials: what a body is made of, as far as normal contact can tell."""

from roughcontact.materials.base import Material, contact_modulus, pressure_limit
from roughcontact.materials.elastic import Elastic
from roughcontact.materials.plastic import ElasticPerfectlyPlastic
from roughcontact.materials.rigid import Rigid

__all__ = ["Elastic", "ElasticPerfectlyPlastic", "Material", "Rigid", "contact_modulus", "pressure_limit"]
