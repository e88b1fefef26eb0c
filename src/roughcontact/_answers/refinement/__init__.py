"""Ladders of ever finer grids, and waves beyond the resolution of maps."""

from roughcontact._answers.refinement.beyond import BeyondResolution, beyond_resolution
from roughcontact._answers.refinement.ladder import Ladder, extrapolate, on_grid, solve_ladder

__all__ = ["BeyondResolution", "Ladder", "beyond_resolution", "extrapolate", "on_grid", "solve_ladder"]
