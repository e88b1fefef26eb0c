"""A process: what a contact changes of the surfaces, and the next one finds."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Oxidation(rc.Process):
    """An oxide that grows on steel where air comes to it, up to a thickness, and narrows the gap.

    Parameters
    ----------
    thickness
        Thickness of the oxide in the end, m.
    time
        Time in which its growth falls to 1/e, s.
    """

    thickness: float = attrs.field(metadata={"unit": "m"})
    time: float = attrs.field(metadata={"unit": "s"})

    rates = ("time",)
    remembered = {"oxide": ("thickness of the oxide", "m")}  # noqa: RUF012

    def change_gap(self, problem, increment, memory):
        """Return what the gap gains."""
        return -memory["oxide"]

    def remember(self, state, increment, memory):
        """Return the oxide after an increment of time, in which none grows where the surfaces touch."""
        grown = -np.expm1(-increment.time / self.time) * (self.thickness - memory["oxide"])
        return {"oxide": memory["oxide"] + np.where(state.contact, 0.0, grown)}

    def list_numbers(self, state, memory):
        """Return the volume of the oxide."""
        return {"oxide_volume": (float(memory["oxide"].sum()) * state.grid.cell_area, "m3")}
