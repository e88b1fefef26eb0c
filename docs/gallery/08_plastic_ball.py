"""
A plastic ball
==============

An elastic, perfectly plastic ball: the pressure is cut at the hardness, and the contact grows.
"""

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

hardness = 6e9
grid = rc.Grid((160, 160), 300e-6)
materials = {
    "elastic": rc.Elastic(young=210e9, poisson=0.3),
    "hardness 6 GPa": rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=hardness),
}
with rc.plotting.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
    for (name, material), marker in zip(materials.items(), "os", strict=True):
        problem = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-3), material), grid=grid)
        sweep = problem.sweep(force=np.linspace(10, 200, 8))
        middle = sweep[-1].pressure[:, 80] / 1e9
        left.plot(1e6 * grid.x[:, 0], middle, label=name)
        right.plot(sweep.force, 1e12 * sweep.area, f"{marker}-", label=name)
    left.set(xlabel="x, µm", ylabel="pressure at 200 N, GPa", ylim=(0, None))
    right.set(xlabel="force, N", ylabel="contact area, µm²", xlim=(0, None), ylim=(0, None))
    left.legend(loc="lower center")
    right.legend()
