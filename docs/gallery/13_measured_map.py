"""
A measured map and its form
===========================

The ground raceway of a ring as it was measured, its form, and what remains of it.
"""

import matplotlib.pyplot as plt

import roughcontact as rc

measured = rc.examples.ground_ring()  # or rc.read_surface("my.x3p")
parts = measured.separate(2)
with rc.plotting.style():
    figure, places = plt.subplots(1, 3, figsize=(9, 2.8), layout="constrained")
    for axes, (name, surface) in zip(
        places, {"as measured": measured, "form": parts.form, "roughness": parts.roughness}.items(), strict=True
    ):
        surface.plot(panel="map", axes=axes)
        axes.set_title(name)

# %%
# The roughness alone.
# sphinx_gallery_thumbnail_number = 2
parts.roughness.plot(panel="map")
