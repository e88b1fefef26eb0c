"""
Fretting
========

A ground steel surface under a cycle of tangential force: the loop, and the energy lost at each place.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

ground = rc.SelfAffineSurface(
    hurst=0.8, rms_height=150e-9, shortest=8e-6, longest=64e-6, rolloff=32e-6, peklenik=5.0, lay=math.pi / 2, seed=3
)
steel = rc.Elastic(young=210e9, poisson=0.3)
flat = rc.Body(rc.FlatSurface(), steel)
problem = rc.ContactProblem(rc.Body(ground, steel), flat, grid=rc.Grid((96, 96), 96e-6), boundary="periodic")
force = 300e6 * problem.plan.grid.area
waves = 0.6 * 0.3 * force * np.sin(0.5 * np.pi * np.arange(1, 21) / 4)
path = problem.path(force=force, tangential_force=[(float(part), 0.0) for part in waves], friction=0.3)
with rc.plotting.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
    path.plot(axes=left)
    work = path.work[4:].sum(axis=0)
    lost, error = 1e9 * path.dissipated.value, 1e9 * path.dissipated.uncertainty
    image = right.imshow(np.where(work > 0.0, work, np.nan).T, origin="lower", extent=(0, 96, 0, 96), cmap="magma_r")
    right.set(
        xlabel="x, µm",
        ylabel="y, µm",
        title=f"lost along the path: {lost:.2f} ± {error:.2f} nJ",
    )
    figure.colorbar(image, ax=right, label="energy lost, J/m²")
