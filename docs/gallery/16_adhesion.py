"""
Adhesion: a ball sticks
=======================

A soft ball that attracts a flat: it snaps into contact, and a force is needed to separate it.
"""

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.reference import JKR

radius = 1e-6
work = 0.05
grid = rc.Grid((72, 72), 300e-9)
ball = rc.Body(rc.ParaboloidSurface(radius), rc.Elastic(young=750e6, poisson=0.5))
problem = rc.ContactProblem(ball, grid=grid, adhesion=rc.ShortRange(work))
cycle = problem.cycle(approach=np.linspace(-4e-9, 4e-9, 25))
zero = problem.solve(force=0.0)

theory = JKR(radius, problem.plan.modulus, work)
radii = np.linspace(0.1, 1.2, 100) * theory.radius_at_zero_load
with rc.plotting.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
    cycle.plot(axes=left)
    approach = np.array([theory.approach(a) for a in radii]) + problem.summit
    left.plot(1e9 * approach, [1e9 * theory.force(a) for a in radii], "k--", linewidth=1.0, label="JKR")
    left.legend()
    middle = zero.pressure[:, 36] / 1e6
    right.plot(1e9 * grid.x[:, 0], middle, label="pressure")
    right.plot(1e9 * grid.x[:, 0], -zero.tension[:, 36] / 1e6, "--", label="minus tension")
    right.set(xlabel="x, nm", ylabel="pressure without a load, MPa")
    right.legend()
