"""A process: what a contact changes of the surfaces, and the next one finds."""

import attrs

import roughcontact as rc


@attrs.frozen
class Wear(rc.Process):
    """Summits that are worn by the pressure: each load slides a distance over which it takes k p s of the heights.

    Parameters
    ----------
    coefficient
        Wear coefficient k of Archard's law over the hardness, volume per force and distance, m2/N.
    distance
        Sliding distance s at each load, m; long steps overshoot from 1.25 cells over k s E* on.
    """

    coefficient: float
    distance: float = attrs.field(metadata={"unit": "m"})

    remembered = {"height_loss": ("height lost by wear", "m")}  # noqa: RUF012

    def change_gap(self, problem, increment, memory):
        """Return the height lost so far: the gap is wider by it."""
        return memory["height_loss"]

    def remember(self, state, increment, memory):
        """Return the height lost after a load."""
        return {"height_loss": memory["height_loss"] + self.coefficient * self.distance * state.pressure}

    def list_numbers(self, state, memory):
        """Return the worn volume."""
        return {"worn_volume": (float(memory["height_loss"].sum()) * state.grid.cell_area, "m3")}
