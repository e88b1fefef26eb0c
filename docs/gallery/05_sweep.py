"""
A sweep of loads
================

Area, approach and stiffness over the load, with their uncertainties as bands.
"""

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2e-6, longest=32e-6, rolloff=16e-6, seed=4)
body = rc.Body(surface, rc.Elastic(young=210e9, poisson=0.3))
problem = rc.ContactProblem(body, grid=rc.Grid((96, 96), 64e-6), boundary="periodic")
sweep = problem.sweep(pressure=[50e6, 100e6, 200e6, 400e6, 800e6])
# sphinx_gallery_thumbnail_number = 2
sweep.plot()

# %%
# One of the panels.
sweep.plot("area-load")
