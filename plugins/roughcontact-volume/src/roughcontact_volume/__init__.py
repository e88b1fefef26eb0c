"""Plastic zones, residual stress and inclusions below the surfaces of rough contacts."""

from roughcontact_volume.operators import VolumeOperators

__all__ = ["VolumeOperators"]
