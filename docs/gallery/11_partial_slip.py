"""
Partial slip
============

Where a rough contact slips under a tangential force, before it slides.
"""

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=4e-6, longest=64e-6, rolloff=32e-6, seed=5)
steel = rc.Elastic(young=210e9, poisson=0.3)
flat = rc.Body(rc.FlatSurface(), steel)
problem = rc.ContactProblem(rc.Body(surface, steel), flat, grid=rc.Grid((160, 160), 64e-6), boundary="periodic")
solution = problem.solve(pressure=1e9)
figure, places = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
for axes, part in zip(places, (0.5, 0.9), strict=True):
    slip = solution.partial_slip(tangential_force=part * 0.2 * solution.force, friction=0.2)
    ratio = np.full(solution.grid.shape, np.nan)
    ratio[solution.contact] = slip.traction[solution.contact] / (0.2 * solution.pressure[solution.contact])
    image = axes.imshow(ratio.T, origin="lower", extent=(-32, 32, -32, 32), cmap="cividis", vmin=0, vmax=1)
    axes.set(title=f"tangential force {part:g} µP", xlabel="x, µm", ylabel="y, µm")
figure.colorbar(image, ax=places, label="traction over µp: 1 where it slips")
