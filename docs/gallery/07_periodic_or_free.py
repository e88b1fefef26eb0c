"""
Periodic or free
================

The same waves as one period of an endless surface, and as a punch with edges.
"""

import matplotlib.pyplot as plt

import roughcontact as rc

wavy = rc.Body(rc.WavySurface(amplitude=0.5e-6, wavelength=25e-6), rc.Elastic(young=200e9, poisson=0.3))
grid = rc.Grid((200, 200), 100e-6)
with rc.plotting.style():
    figure, places = plt.subplots(1, 2, figsize=(7.5, 3.2), layout="constrained")
    for axes, boundary in zip(places, ("periodic", "free"), strict=True):
        solution = rc.ContactProblem(wavy, grid=grid, boundary=boundary).solve(pressure=500e6)
        solution.plot("pressure", axes=axes)
        axes.set_title(f"{boundary}: at most {solution.peak_pressure().value / 1e9:.1f} GPa")

# %%
# On the free boundary the outer waves have no neighbours beyond the border, and carry more.
