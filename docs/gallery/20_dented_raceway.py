"""
A dented raceway
================

A hard particle is pressed into a raceway that flows below its surface, by the plug-in ``roughcontact-volume``, and
lifted: it leaves a dent and a residual stress. A ball that rolls over the dent presses hardest on its shoulders.
"""

import warnings

import matplotlib.pyplot as plt

import roughcontact as rc
from roughcontact_volume import FindResidualStress, Plastic, SwiftHardening

steel = Plastic("210GPa", 0.3, yield_stress="1.4GPa", hardening=SwiftHardening(strain=0.005, power=0.1))
grid = rc.Grid((45, 45), "108um")
particle = rc.Body(rc.ParaboloidSurface("200um"), rc.Elastic("300GPa", 0.25))
dented = rc.ContactProblem(particle, rc.Body(rc.FlatSurface(), steel), grid=grid).path(force=["3N", "0N"])
residual = dented[-1].response(FindResidualStress("50um"))
# The ball rolls over the shape alone, without the stress below it, of which a warning reminds.
with warnings.catch_warnings(action="ignore", category=rc.ContactWarning):
    raceway = dented.bodies[1].surface

elastic = rc.Elastic("210GPa", 0.3)
with rc.plotting.style():
    figure, (top, middle, bottom) = plt.subplots(3, sharex=True, figsize=(5, 7), layout="constrained")
    x = 1e6 * grid.x[:, 0]
    top.plot(x, 1e9 * raceway.heights(grid)[:, 22])
    top.set(ylabel="height of the raceway, nm")

    xx = residual.cut(y=0.0)[0] / 1e6
    colours = middle.pcolormesh(x, 1e6 * residual.depths, xx, cmap="RdBu_r", vmin=-abs(xx).max(), vmax=abs(xx).max())
    figure.colorbar(colours, ax=middle, label="residual stress along x, MPa")
    middle.set(ylabel="depth, µm", ylim=(50, 0))

    for place, style in ((-18e-6, ":"), (-9e-6, "--"), (0.0, "-")):
        ball = rc.Body(rc.ParaboloidSurface("1mm", center=(place, 0.0)), elastic)
        solution = rc.ContactProblem(ball, rc.Body(raceway, elastic), grid=grid).solve(force="3N")
        bottom.plot(x, solution.pressure[:, 22] / 1e9, style, label=f"{1e6 * place:g} µm")
    bottom.set(xlabel="x, µm", ylabel="pressure, GPa", ylim=(0, 4.2))
    bottom.legend(title="ball at", ncols=3, loc="upper center")
