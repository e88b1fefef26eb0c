"""
The area and its uncertainty
============================

One contact on ever finer grids: counted cells, and the default estimator with two standard deviations.
"""

import matplotlib.pyplot as plt

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2e-6, longest=32e-6, rolloff=16e-6, seed=4)
body = rc.Body(surface, rc.Elastic(young=210e9, poisson=0.3))
grids = (64, 80, 96, 128, 192, 256, 384)
counted, blend = [], []
for cells in grids:
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), 64e-6), boundary="periodic")
    solution = problem.solve(pressure=300e6)
    counted.append(solution.area("cell-count"))
    blend.append(solution.area())

# %%
# The counted area falls with every finer grid. The default, ``blend``, is right from two cells to the shortest wave
# on (64 cells a side), within what it states.
with rc.plotting.style():
    figure, axes = plt.subplots(figsize=(5, 3.5), layout="constrained")
    axes.plot(grids, [100 * area.fraction for area in counted], "s--", color="0.5", label="counted cells")
    values = [100 * area.fraction for area in blend]
    errors = [2 * area.uncertainty / area.value * value for area, value in zip(blend, values, strict=True)]
    axes.errorbar(grids, values, errors, fmt="o-", capsize=3, label="blend, two standard deviations")
    axes.set_xscale("log", base=2)
    axes.set_xticks(grids, [str(cells) for cells in grids])
    axes.set_xticks([], minor=True)
    axes.set(xlabel="cells along a side", ylabel="contact area, % of nominal", ylim=(0, 4))
    axes.legend()
