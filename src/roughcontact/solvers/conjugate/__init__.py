"""Projected, preconditioned, mixed-precision conjugate gradients: the default solver.

From the top: `solver` (the whole way), `cascade` (coarse to fine), `box` (only what can touch),
`refinement` (float64 proofs around the float32 descent), `descent` (one iteration), `control` (what
a given load or a given approach demands), `preconditioner` and `longwaves` (the inverse kernel on
the active cells).
"""

from roughcontact.solvers.conjugate.solver import ProjectedConjugateGradient

__all__ = ["ProjectedConjugateGradient"]
