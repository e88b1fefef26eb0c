"""When a measured property of a contact is good, admissible, or neither."""

from __future__ import annotations

import attrs


@attrs.frozen
class Rule:
    """When a measured value passes.

    Attributes
    ----------
    good, admissible
        Up to `good` it passes, up to `admissible` it needs attention; down to them where `good` is the larger one.
    reason
        Why these values.
    advice
        What to do about a value that does not pass.
    """

    good: float
    admissible: float
    reason: str
    advice: str


# Rules whose values cost no further solve and no convolution: beyond `admissible` the solution gets a warning.
PLAUSIBILITY_RULES = {
    "units": Rule(
        0,
        0,
        "quantities that no contact has: a modulus below 1 MPa without the Poisson's ratio of a gel, or above that of "
        "diamond; heights that exceed the domain, or an rms slope above 10; a domain of 1 m or more; cells or "
        "heights below an atom",
        "Numbers without a unit are in m and Pa (5um and 210GPa are read too): check them, and the unit of heights "
        "from a file.",
    ),
    "border jump": Rule(
        3,
        3,
        "rms step across the border over that between neighbours; waves of eight cells have one",
        "Beyond the border the domain repeats: subtract the tilt, use a surface that repeats, or a free boundary.",
    ),
    "edge contact": Rule(
        0,
        0.25,
        "fraction of the load on contacts that reach a free border: all of it for a ball that is cut; from a quarter "
        "on rough surfaces have their maximum pressure there (benchmarks/border_constants.py)",
        "Nothing lies beyond it, so that the pressure rises as under the edge of a punch: enlarge the domain, or make "
        "it periodic if the surface repeats; what is near the border must not be used.",
    ),
    "tilt": Rule(
        0.1,
        0.5,
        "fraction of the variance of the heights that is a plane, where a contact reaches a free border",
        "Subtract the plane (detrend).",
    ),
    "cells per contact": Rule(
        0.05,
        0.5,
        "fraction of the load on contacts of one cell, whose pressure is no more than their load over the cell's area",
        "The grid does not resolve their pressure: refine it; a measured map needs a finer pitch, or a filter.",
    ),
    "slope": Rule(
        0.2,
        0.5,
        "a half-space neglects the square of the slope: 4 % at 0.2, a quarter at 0.5",
        "A half-space is a model for small slopes: check that heights and sizes are in metres; filter noise.",
    ),
    "peak pressure": Rule(
        0.1,
        0.3,
        "strains are about a third of p / E* (Tabor); linear elasticity holds up to strains of a tenth",
        "Linear elasticity holds up to strains of about a tenth, p / E* of 0.3: give a hardness, or a lower load.",
    ),
    "approach": Rule(
        0.1,
        0.3,
        "as for the peak pressure: the mean strain of the domain is about approach over side",
        "Linear elasticity holds up to about a tenth: check modulus, load and size.",
    ),
    "theory": Rule(
        2,
        3,
        "standard deviations by which the ratio of Persson's area to the solved one is outside 0.65 to 0.9, where all "
        "isotropic Gaussian surfaces are between 1 and 40 % of contact (docs/studies/persson.py)",
        "On isotropic Gaussian roughness it is 0.65 to 0.9: the surface differs where it touches from elsewhere, as a "
        "worn or honed one does, or the grid does not resolve the contacts; compare a finer grid.",
    ),
}
