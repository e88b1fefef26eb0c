"""Plastic zones, residual stress and inclusions below the surfaces of rough contacts."""

from roughcontact_volume.between_mixtures import InclusionAnswers, find_inclusion_answers
from roughcontact_volume.flow import PlasticFlow
from roughcontact_volume.given_strains import StrainedRegion
from roughcontact_volume.hardening import (
    Hardening,
    LinearHardening,
    LudwikHardening,
    SwiftHardening,
    TabulatedHardening,
    VoceHardening,
)
from roughcontact_volume.inclusions import Inclusion, Inclusions
from roughcontact_volume.indentation import Indentation, find_indentation
from roughcontact_volume.layered_stress import LayeredStress
from roughcontact_volume.material_field import MaterialField, draw_moduli
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.own_yield import FindOwnYield
from roughcontact_volume.panels import PlasticZonePanel, ResidualStressPanel, TotalStressPanel
from roughcontact_volume.plastic import Plastic
from roughcontact_volume.plastic_zone import FindImprint, FindPlasticZone, Imprint, PlasticZone
from roughcontact_volume.residual_stress import ResidualStress
from roughcontact_volume.shakedown import Passes, judge_passes
from roughcontact_volume.shakedown_load import ShakedownLoad, find_shakedown_load
from roughcontact_volume.shapes import Cuboid, Ellipsoid, Shape, Sphere
from roughcontact_volume.stress_answers import FindResidualStress, FindTotalStress

__all__ = [
    "Cuboid",
    "Ellipsoid",
    "FindImprint",
    "FindOwnYield",
    "FindPlasticZone",
    "FindResidualStress",
    "FindTotalStress",
    "Hardening",
    "Imprint",
    "Inclusion",
    "InclusionAnswers",
    "Inclusions",
    "Indentation",
    "LayeredStress",
    "LinearHardening",
    "LudwikHardening",
    "MaterialField",
    "Passes",
    "Plastic",
    "PlasticFlow",
    "PlasticZone",
    "PlasticZonePanel",
    "ResidualStress",
    "ResidualStressPanel",
    "ShakedownLoad",
    "Shape",
    "Sphere",
    "StrainedRegion",
    "SwiftHardening",
    "TabulatedHardening",
    "TotalStressPanel",
    "VoceHardening",
    "VolumeOperators",
    "draw_moduli",
    "find_inclusion_answers",
    "find_indentation",
    "find_shakedown_load",
    "judge_passes",
]
