"""
Stress below a rough contact
============================

The von Mises stress in a plane through its maximum.
"""

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.06, shortest=8e-6, longest=60e-6, rolloff=30e-6, seed=7)
steel = rc.Elastic(young=210e9, poisson=0.3)
grid = rc.Grid((192, 192), 100e-6)
solution = rc.ContactProblem(rc.Body(surface, steel), grid=grid, boundary="periodic").solve(pressure=1.2e9)
stress = solution.stress(np.linspace(0.0, 12e-6, 61))
maximum = stress.maximum
print(maximum)

# %%
# Each contact has its maximum below the surface, at half the radius of the contact or so.
row = int(np.argmin(np.abs(grid.x[:, 0] - maximum.x)))
cut = stress.von_mises[:, row] / 1e9
figure, axes = plt.subplots(figsize=(6.5, 3), layout="constrained")
image = axes.pcolormesh(1e6 * grid.y[0], 1e6 * np.linspace(0, 12e-6, 61), cut, cmap="inferno", shading="gouraud")
axes.plot(1e6 * maximum.y, 1e6 * maximum.depth, "+", color="black", markersize=12)
axes.set(xlabel="y, µm", ylabel="depth, µm", ylim=(12, 0))
figure.colorbar(image, ax=axes, label="von Mises stress, GPa")
