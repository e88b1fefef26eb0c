"""Likely mistakes in a contact, and limits of its model: rules, and the values that they judge."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import WarningText, si
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact._parts.surfaces import border_jump, rms_slope
from roughcontact._solve.solution.fields import ContactFields
from roughcontact._solve.solution.theory import compare_areas
from roughcontact.errors.door import guarded

# Young's modulus of the softest rubbers, Pa, minimum Poisson's ratio of softer solids that are gels and not foams, and
# Young's modulus of the softest gels and tissues, Pa (M. F. Ashby, Materials Selection in Mechanical Design).
_RUBBER_MODULUS = 1e6
_GEL_POISSON = 0.45
_GEL_MODULUS = 100.0
# Maximum Young's modulus of any material, Pa: diamond has 1.05 to 1.2e12.
_DIAMOND_MODULUS = 1.3e12
# Minimum Young's modulus of metals, Pa, above the polymers, and maximum pressure that they bear, over it: the hardest
# steels have a hardness of 0.04 of it.
_STIFF_MODULUS = 10e9
_MAX_METAL_PRESSURE = 0.05
# Diameter of an atom, and maximum side of a domain on which roughness is measured, m.
_ATOM_DIAMETER = 1e-10
_MAX_DOMAIN_SIDE = 1.0
# Minimum plausible mean pressure, over E*: 10 kPa on steel, 1 Pa on rubber of 10 MPa. A smaller load may be in another
# unit: 100 MPa given as 100, 4e-10 on steel, touches single cells on grids of up to 1024 x 1024 cells.
_MIN_PRESSURE_RATIO = 1e-7
# Mean pressure of cells at the border that are just touched, over the nominal one: the area of a ball that is cut by a
# border is 2 % too small there (benchmarks/border_constants.py).
_LIGHT_BORDER_PRESSURE = 0.25
# Maximum rms slope of a surface, 84 degrees; heights in mm, read as m, have some 10 to 1000.
_MAX_RMS_SLOPE = 10.0
# Parts of the length of a roller whose means are its profile.
_CROWN_PARTS = 16
# Step of the load from the last part to the first, over the mean load of a part, from which the ends are unlike; and
# load below which an end is one.
_MIN_LOAD_STEP = 0.5
# Bend and departure of a mean profile over the range of the heights below which they are rounding.
_EXACT_BEND = 1e-12
# Largest ratio to the variation inside that is said.
_LARGEST_CROWN = 100.0
# Minimum cells along an axis: of fewer all are near the border.
_MIN_CELLS = 16


@attrs.frozen
class Rule:
    """The admissible values of a measured quantity.

    Attributes
    ----------
    good, admissible
        Values up to `good` pass, values up to `admissible` need attention; down to them if `good` is the larger one.
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
    "crown": Rule(
        5,
        5,
        "bend of the mean profile across the periodic border over that inside, its fall there over its scatter, or its "
        "step there over those inside, where the other axis is free and the load at that border is not the mean: 5.5 "
        "to 7 of a crowned roller, more of one with ends, 3 of a wave; above 5 on 2 % of straight rough ones",
        "Beyond the border the domain repeats, so that the contact is one of a row, and its approach is counted from "
        "the side of the domain: for a single roller choose a free boundary, for a line without end a straight one.",
    ),
    "isotropy": Rule(
        0,
        0,
        "bodies whose modulus depends on the direction along the surface, under a kernel that takes the mean",
        "Contacts come out round where they are elliptic: choose the kernel of the anisotropic material.",
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
    "maximum pressure": Rule(
        0.1,
        0.3,
        "strains are about a third of p / E* (Tabor); linear elasticity holds up to strains of a tenth",
        "Linear elasticity holds up to strains of about a tenth, p / E* of 0.3: give a hardness, or a lower load.",
    ),
    "approach": Rule(
        0.1,
        0.3,
        "as for the maximum pressure: the mean strain of the domain is about approach over side",
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


@attrs.frozen
class Finding:
    """The measured value for one of `PLAUSIBILITY_RULES`.

    Attributes
    ----------
    rule
        Name of the rule.
    value
        The measured value; nan where the rule does not apply.
    text
        The value in words, or why the rule does not apply.
    """

    rule: str
    value: float
    text: str

    @property
    def warning(self) -> str:
        """The finding with advice; empty if the value is admissible."""
        rule = PLAUSIBILITY_RULES[self.rule]
        if not self.value > rule.admissible:
            return ""
        return WarningText(f"{self.text[0].upper()}{self.text[1:]}. {rule.advice}", self.rule, self.value)


def find_scene(initial_gap: Array, grid: Grid, boundary: Boundary, materials: Iterable[Material]) -> list[Finding]:
    """Return the findings before a solve: implausible units, and a jump across a periodic border."""
    implausible = [*_list_moduli(materials), *_list_lengths(initial_gap, grid)]
    units = "; ".join(implausible) or "moduli, heights and sizes are plausible"
    return [Finding("units", len(implausible), units), _find_jump(initial_gap, boundary)]


def find_contact(solution: ContactFields, materials: Iterable[Material]) -> list[Finding]:
    """Return the findings on half-space, domain and grid of a solved contact."""
    names = (
        "crown",
        "isotropy",
        "edge contact",
        "tilt",
        "cells per contact",
        "slope",
        "maximum pressure",
        "approach",
        "theory",
    )
    if not solution.contact.any():
        return [Finding(name, math.nan, "there is no contact") for name in names]
    peak = float(solution.pressure.max()) / solution.surface_modulus
    # A line has no side along the axis of its single cell.
    sides = zip(solution.grid.size, solution.grid.shape, strict=True)
    approach = solution.approach / min(side for side, count in sides if count > 1)
    edge = _find_edge_contact(solution)
    return [
        _find_crown(solution),
        _find_isotropy(solution, materials),
        edge,
        _find_tilt(solution, edge),
        _find_single_cells(solution),
        _find_slope(solution),
        Finding("maximum pressure", peak, f"the maximum pressure is {peak:.3g} times the contact modulus E*"),
        Finding("approach", approach, f"the approach is {approach:.3g} times the shorter side of the domain"),
        _find_departure(solution),
    ]


def list_warnings(solution: ContactFields, materials: Iterable[Material]) -> tuple[str, ...]:
    """Return the warnings of a solution, likely causes first; after a failed solve only those before a solve."""
    materials = tuple(materials)
    findings = find_scene(solution.initial_gap, solution.grid, solution.boundary, materials)
    explained: set[str] = set()
    if findings[0].warning:
        explained |= {"slope", "maximum pressure", "approach"}
    if solution.status.success:
        findings += find_contact(solution, materials)
        if any(finding.rule == "tilt" and finding.warning for finding in findings):
            explained.add("edge contact")
    return tuple(finding.warning for finding in findings if finding.rule not in explained and finding.warning)


@guarded
def exceeds_metals(solution: ContactFields, materials: Iterable[Material]) -> bool:
    """Return whether stiff bodies without a hardness carry more than metals do; this may be intended."""
    softest = min((one.young for one in materials if isinstance(one, Elastic)), default=0.0)
    return (
        not solution.capped
        and softest >= _STIFF_MODULUS
        and float(solution.pressure.max()) > _MAX_METAL_PRESSURE * softest
    )


def _find_isotropy(solution: ContactFields, materials: Iterable[Material]) -> Finding:
    names = [type(material).__name__ for material in materials if not material.is_isotropic]
    if not names or solution.directional_moduli is not None:
        return Finding("isotropy", 0, "materials and kernel agree on the directions")
    return Finding("isotropy", len(names), f"the material {' and '.join(names)} is anisotropic, but the kernel is not")


def _list_moduli(materials: Iterable[Material]) -> list[str]:
    texts = []
    for material in materials:
        if not isinstance(material, (Elastic, ElasticPerfectlyPlastic)):
            continue
        young = f"a Young's modulus of {si(material.young, 'Pa')}"
        if material.young < (_RUBBER_MODULUS if material.poisson < _GEL_POISSON else _GEL_MODULUS):
            texts.append(f"{young} is that of a foam or a gel")
        elif material.young > _DIAMOND_MODULUS:
            texts.append(f"{young} is more than that of diamond")
    return list(dict.fromkeys(texts))


def _list_lengths(initial_gap: Array, grid: Grid) -> list[str]:
    texts = []
    largest = float(initial_gap.max())
    side = max(grid.resolved.size)
    cell = min(grid.resolved.spacing)
    heights = float(initial_gap.max(where=_measured(initial_gap), initial=0.0))
    slope = rms_slope(np.minimum(initial_gap, heights), grid)
    if heights > side or slope > _MAX_RMS_SLOPE:
        texts.append(f"the heights differ by {si(heights, 'm')}, with an rms slope of {slope:.2g}")
    elif largest < _ATOM_DIAMETER:
        texts.append(f"the heights differ by {si(largest, 'm')}, less than an atom")
    if side >= _MAX_DOMAIN_SIDE:
        texts.append(f"the domain is {si(side, 'm')} long")
    elif cell < _ATOM_DIAMETER:
        texts.append(f"the cells are {si(cell, 'm')} wide, less than an atom")
    return texts


def _measured(initial_gap: Array) -> Mask:
    """Return the mask of the measured points: the others lie at the largest gap."""
    return np.asarray(initial_gap < initial_gap.max())


def _find_jump(initial_gap: Array, boundary: Boundary) -> Finding:
    name = "border jump"
    if boundary is Boundary.FREE:
        return Finding(name, math.nan, "the boundary is free: nothing lies beyond it")
    jump = max(border_jump(initial_gap, axis) for axis in (0, 1) if not boundary.free_axes[axis])
    return Finding(name, jump, f"the heights jump across the border by {jump:.3g} times the step between cells")


def _find_crown(solution: ContactFields) -> Finding:
    """Return how much a roller ends at the periodic border, if contacts end before it.

    It is the change of the slope across the border over the median of those inside, so that neither a jump nor steep
    ends count, or the fall of the open ends below the median over the median departure from it, as of ends that are
    flat. Where an end touches it is the step to the other one over the median of those inside, if their loads differ.
    """
    name = "crown"
    if not solution.boundary.mixed:
        return Finding(name, math.nan, "the boundary is the same along both axes")
    axis = 1 - solution.boundary.free_axis
    if solution.non_measured is not None or solution.grid.shape[axis] < _MIN_CELLS:
        return Finding(name, math.nan, f"not judged with non-measured points, or on fewer than {_MIN_CELLS} cells")
    means, loads = (
        _average_parts(field.mean(axis=1 - axis)) for field in (solution.initial_gap, solution.contact_pressure)
    )
    slopes = np.diff(means)
    departures = means - np.median(means)
    rounding = _EXACT_BEND * float(np.ptp(solution.initial_gap))
    touching = np.moveaxis(solution.contact, axis, 0)[[0, -1]].any(axis=1)
    ends = [0.0]
    unlike = _MIN_LOAD_STEP * float(loads.mean())
    if not touching.all() or float(np.min(loads[[0, -1]])) < unlike:
        bend = float(slopes[-1] - slopes[0])
        ends.append(bend / max(float(np.median(np.abs(slopes[2:] - slopes[:-2]))), rounding))
    if not touching.all():
        fall = float(np.min(departures[[0, -1]][~touching]))
        ends.append(fall / max(float(np.median(np.abs(departures))), rounding))
    if touching.any() and abs(loads[0] - loads[-1]) > unlike:
        step = abs(float(means[0] - means[-1]))
        ends.append(step / max(float(np.median(np.abs(slopes))), rounding))
    # Straight profiles do not vary inside.
    end = min(max(ends), _LARGEST_CROWN)
    return Finding(name, end, f"the roller ends at the periodic border, by {end:.3g} times what it varies inside")


def _average_parts(profile: Array) -> Array:
    """Return the means over parts of the length, so that roughness on it hardly counts."""
    ends = np.linspace(0.0, profile.size, _CROWN_PARTS + 1)
    sums = np.interp(ends, np.arange(profile.size + 1), np.concatenate(([0.0], np.cumsum(profile))))
    return np.asarray(np.diff(sums) / np.diff(ends))


def _find_edge_contact(solution: ContactFields) -> Finding:
    """Return the fraction of the load on patches at a free border."""
    name = "edge contact"
    patches = solution.patches
    if not solution.boundary.has_free_axis:
        return Finding(name, math.nan, f"the boundary is {solution.boundary}: the domain has no border")
    free = [axis for axis in (0, 1) if solution.boundary.free_axes[axis]]
    if min(solution.grid.shape[axis] for axis in free) < _MIN_CELLS:
        return Finding(
            name, math.nan, f"with fewer than {_MIN_CELLS} cells along an axis all cells are near the border"
        )
    labels, pressure = (
        np.concatenate([np.moveaxis(field, axis, 0)[[0, -1]].ravel() for axis in free])
        for field in (patches.labels, solution.pressure)
    )
    touching = np.unique(labels[labels > 0]) - 1
    fraction = float(patches.forces[touching].sum() / patches.forces.sum())
    if pressure.mean() < _LIGHT_BORDER_PRESSURE * solution.pressure.mean():
        fraction = 0.0
    return Finding(name, fraction, f"{_percent(fraction)} of the load is on contacts that reach the free border")


def _find_tilt(solution: ContactFields, edge: Finding) -> Finding:
    """Return the fraction of the variance of the heights that is a plane, if contacts at a free border matter."""
    name = "tilt"
    initial_gap = solution.initial_gap
    if not edge.value > PLAUSIBILITY_RULES["edge contact"].admissible:
        return Finding(name, math.nan, "the load is not at a free border")
    measured = np.nonzero(_measured(initial_gap))
    if len(measured[0]) < _MIN_CELLS:
        return Finding(name, math.nan, f"fewer than {_MIN_CELLS} points are above the lowest")
    values = initial_gap[measured]
    places = [(index - index.mean()) / n for index, n in zip(measured, initial_gap.shape, strict=True)]
    slopes = np.linalg.lstsq(np.stack(places, axis=1), values - values.mean(), rcond=None)[0]
    plane = slopes[0] * places[0] + slopes[1] * places[1]
    fraction = float(plane.var() / values.var()) if values.max() > values.min() else 0.0
    across = si(float(plane.max() - plane.min()), "m", 3)
    text = f"the load is at the border, and {_percent(fraction)} of the variance of the heights is a tilt of {across}"
    return Finding(name, fraction, text)


def _find_single_cells(solution: ContactFields) -> Finding:
    """Return the fraction of the load on single cells, with a hint if the load may be in another unit."""
    name = "cells per contact"
    forces = solution.patches.forces
    single = float(forces[solution.patches.cells == 1].sum() / forces.sum())
    ratio = solution.mean_pressure / solution.surface_modulus
    text = f"{_percent(single)} of the load is on contacts of a single cell"
    if ratio < _MIN_PRESSURE_RATIO and single > PLAUSIBILITY_RULES[name].admissible:
        light = f"the mean pressure is {si(solution.mean_pressure, 'Pa')}, {ratio:.2g} of E*"
        text = f"{light} (loads are in Pa and N, lengths in m: 100 MPa is 100e6, 1 mm is 1e-3), and {text}"
    return Finding(name, single, text)


def _find_slope(solution: ContactFields) -> Finding:
    """Return the rms slope of the initial gap between cells that are both in contact."""
    name = "slope"
    total = 0.0
    contact = solution.contact
    gap = solution.initial_gap
    for spacing, before, after in (
        (solution.grid.spacing[0], np.s_[:-1], np.s_[1:]),
        (solution.grid.spacing[1], np.s_[:, :-1], np.s_[:, 1:]),
    ):
        both = contact[before] & contact[after]
        steps = (gap[after][both] - gap[before][both]) / spacing
        total += float(np.mean(steps**2)) if steps.size else 0.0
    slope = math.sqrt(total)
    return Finding(name, slope, f"the rms slope of both surfaces together is {slope:.3g} in contact")


def _find_departure(solution: Any) -> Finding:
    """Return the distance of the area from the range of Persson's theory, in standard deviations."""
    name = "theory"
    theory = compare_areas(solution)
    if theory is None:
        return Finding(name, math.nan, "Persson's theory does not hold for this contact")
    text = f"the area of Persson's theory is {theory.ratio:.2f} of the solved one"
    return Finding(name, theory.departure, text)


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:.3g} %"
