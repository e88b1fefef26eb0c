"""
A study as a table
==================

Parameters of a function as axes: roll-off and pressure, three seeds of each, and pandas from there on.
"""

import tempfile

import matplotlib.pyplot as plt

import roughcontact as rc

steel = rc.Elastic(young=210e9, poisson=0.3)


def build(rolloff, seed):
    """Return a rough contact of 64 um a side."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_height=50e-9, shortest=4e-6, longest=64e-6, rolloff=rolloff, seed=seed
    )
    return rc.ContactProblem(rc.Body(surface, steel), grid=rc.Grid((128, 128), 64e-6), boundary="periodic")


with tempfile.TemporaryDirectory() as folder:  # "my-study", to keep it
    study = rc.Study(build, rolloff=[16e-6, 32e-6, 64e-6], seed=range(3), pressure=[50e6, 100e6, 200e6])
    table = study.run(folder).to_pandas()
print(table[["rolloff", "seed", "load", "area blend", "uncertainty blend"]].head())

# %%
# Means over the seeds, in per cent of the nominal area.
table["fraction"] = 100 * table["area blend"] / 64e-6**2
means = table.groupby(["rolloff", "load"])["fraction"].agg(["mean", "std"])
with rc.plotting.style():
    figure, axes = plt.subplots(figsize=(5, 3.8), layout="constrained")
    for (rolloff, rows), marker in zip(means.groupby("rolloff"), "os^", strict=True):
        load = rows.index.get_level_values("load") / 1e6
        axes.errorbar(load, rows["mean"], rows["std"], fmt=f"{marker}-", capsize=3, label=f"{1e6 * rolloff:.0f} µm")
    axes.set(xlabel="pressure, MPa", ylabel="contact area, % of nominal", xlim=(0, None), ylim=(0, None))
    axes.legend(title="roll-off; error bars: scatter of seeds")
