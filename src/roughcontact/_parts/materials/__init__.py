"""Materials: the interface, isotropic and viscoelastic ones, and typical ones by name."""

from roughcontact._parts.materials.isotropic import MAX_UNCOUPLED_BETA as MAX_UNCOUPLED_BETA
from roughcontact._parts.materials.isotropic import Elastic as Elastic
from roughcontact._parts.materials.isotropic import ElasticPerfectlyPlastic as ElasticPerfectlyPlastic
from roughcontact._parts.materials.isotropic import Material as Material
from roughcontact._parts.materials.isotropic import PairConstants as PairConstants
from roughcontact._parts.materials.isotropic import Rigid as Rigid
from roughcontact._parts.materials.isotropic import combined_pressure_limit as combined_pressure_limit
from roughcontact._parts.materials.isotropic import contact_modulus as contact_modulus
from roughcontact._parts.materials.isotropic import pair_constants as pair_constants
from roughcontact._parts.materials.typical import TYPICAL as TYPICAL
from roughcontact._parts.materials.typical import materials as materials
from roughcontact._parts.materials.typical import resolve_material as resolve_material
from roughcontact._parts.materials.viscoelastic import Viscoelastic as Viscoelastic
