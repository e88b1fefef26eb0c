"""The scene with which the page opens, so that there is an answer before anything is chosen."""

from __future__ import annotations

# A ball on a plane, both of bearing steel, at 0.8 GPa: Hertz's contact radius is 55 um, a quarter of the side.
FIRST: dict[str, str] = {
    "surface": "sphere",
    "radius": "5",
    "radius_unit": "mm",
    "side": "220",
    "side_unit": "um",
    "cells": "256",
    "boundary": "free",
    "counterbody": "deformable",
    "hardness": "7",
    "counterbody_hardness": "7",
    "load": "force",
    "loads": "5",
    "load_unit": "N",
}
