"""
A coated ball
=============

A layer of 8 µm on a steel ball, by the plug-in ``roughcontact-layered``: a stiff one takes more of the pressure.
"""

import matplotlib.pyplot as plt

import roughcontact as rc
from roughcontact_layered import Layer, LayeredKernel

steel = rc.Elastic(young=210e9, poisson=0.3)
grid = rc.Grid((128, 128), 80e-6)
ball = rc.Body(rc.ParaboloidSurface(radius=1e-3), steel)
with rc.plotting.style():
    figure, axes = plt.subplots(figsize=(5, 3.8), layout="constrained")
    for young, style in ((70e9, "--"), (210e9, "-"), (600e9, "-.")):
        kernel = LayeredKernel((Layer(young=young, poisson=0.3, thickness=8e-6),), substrate=steel)
        solution = rc.ContactProblem(ball, grid=grid, kernel=kernel).solve(force=2.0)
        axes.plot(1e6 * grid.x[:, 0], solution.pressure[:, 64] / 1e9, style, label=f"layer of {young / 1e9:g} GPa")
    axes.set(xlabel="x, µm", ylabel="pressure, GPa", ylim=(0, None))
    axes.legend(title="on steel, 210 GPa", loc="lower center")
