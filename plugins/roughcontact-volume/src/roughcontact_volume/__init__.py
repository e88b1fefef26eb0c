"""Plastic zones, residual stress and inclusions below the surfaces of rough contacts."""

from roughcontact_volume.flow import PlasticFlow
from roughcontact_volume.hardening import (
    Hardening,
    LinearHardening,
    SwiftHardening,
    TabulatedHardening,
    VoceHardening,
)
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.plastic import Plastic

__all__ = [
    "Hardening",
    "LinearHardening",
    "Plastic",
    "PlasticFlow",
    "SwiftHardening",
    "TabulatedHardening",
    "VoceHardening",
    "VolumeOperators",
]
