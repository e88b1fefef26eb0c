"""Finer grids: ladders of them, and refinement around the contacts."""

from roughcontact.refinement.finer import on_grid
from roughcontact.refinement.ladder import Ladder, extrapolate
from roughcontact.refinement.local import Refined, refine

__all__ = ["Ladder", "Refined", "extrapolate", "on_grid", "refine"]
