"""
Leakage of a seal
=================

Water through the gap of a rough contact, and the throat that limits it.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=100e-6, rolloff=25e-6, seed=7)
body = rc.Body(surface, rc.Elastic(young=210e9, poisson=0.3))
problem = rc.ContactProblem(body, grid=rc.Grid((192, 192), 100e-6), boundary="periodic")
flow = problem.solve(pressure=2.5e9).leakage(axis=0, viscosity=1e-3, pressure_drop=1e5)
print(flow)

# %%
# The flow over the width, on a logarithmic scale; the contact is grey.
speed = np.hypot(*flow.flux)
shown = 1e12 * np.where(speed > 0, np.maximum(speed, 1e-4 * speed.max()), np.nan)
figure, axes = plt.subplots(figsize=(5, 4), layout="constrained")
axes.set_facecolor("0.75")
image = axes.imshow(shown.T, origin="lower", extent=(-50, 50, -50, 50), cmap="cividis", norm=LogNorm())
axes.plot(
    *(1e6 * one for one in flow.throat.place), "o", ms=14, mfc="none", mec="black", mew=2, label="critical throat"
)
axes.set(xlabel="x, µm", ylabel="y, µm")
axes.legend(loc="upper right")
figure.colorbar(image, ax=axes, label="flow over width, µm²/s")
