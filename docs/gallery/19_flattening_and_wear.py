"""
Flattening and wear
===================

A ball of steel is pressed, unloaded and pressed again; then a pin wears on a flat: what the surfaces remember.
"""

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

sphere = rc.SphereSurface(radius=1e-3)
steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
pressed = rc.ContactProblem(rc.Body(sphere, steel), grid=rc.Grid((64, 64), 120e-6))
rising = np.linspace(0.5, 4.0, 8)
path = pressed.path(force=[*rising, *rising[-2::-1], 0.0, *rising[1::2]])

pin = rc.Body(sphere, rc.Elastic(young=210e9, poisson=0.3))
rubbed = rc.ContactProblem(pin, grid=rc.Grid((64, 64), 160e-6), laws=rc.Archard("1e-16m2/N"))
worn = rubbed.path(force=1.0, sliding=["0m", "0.5m", "2m", "8m"])
with rc.plotting.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
    path.plot(axes=left)
    for state, distance in zip(worn, worn.sliding, strict=True):
        right.plot(1e6 * state.grid.x[:, 0], state.pressure[:, 32] / 1e9, label=f"after {distance:.1f} m")
    right.set(xlabel="x, µm", ylabel="pressure on the pin, GPa")
    right.legend()
