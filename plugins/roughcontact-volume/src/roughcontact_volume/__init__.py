"""Plastic zones, residual stress and inclusions below the surfaces of rough contacts."""
