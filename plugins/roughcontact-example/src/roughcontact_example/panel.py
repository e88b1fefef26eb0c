"""A panel."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class PatchForces(rc.Panel):
    """The fraction of the force that the largest patches carry together."""

    def draw(self, subject, axes):
        """Draw a solution; the patches stand in the order of their forces."""
        forces = np.sort(subject.patches.forces)[::-1]
        if not forces.size:
            raise rc.InputError("No cell is in contact, so that no patch carries a force.")
        carried = 100.0 * np.cumsum(forces) / forces.sum()
        color = rc.plotting.theme_of(axes).lines[0]
        axes.step(np.arange(1, forces.size + 1), carried, where="post", marker="o", color=color)
        rc.plotting.scale_axes(axes, x="number of patches", y="force, %", logarithmic="x")
