"""A solution as text."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import attrs

from roughcontact._materials import Material
from roughcontact._surfaces import HeightMap
from roughcontact.units import si

if TYPE_CHECKING:
    from roughcontact._solution.contact import ContactSolution

# Width of a printed warning, characters.
_WIDTH = 120


def summarize(solution: ContactSolution, maps: Sequence[HeightMap], materials: Mapping[str, Material]) -> str:
    """Return how the solve ended, the main numbers of the contact, and the warnings, line by line."""
    rigid = [name for name, material in materials.items() if material.compliance == 0.0]
    alone = f": the {rigid[0]} is rigid" if rigid else ""
    # The area below says the same warnings.
    peak = attrs.evolve(solution.peak_pressure(), warnings=())
    lines = [
        f"{solution.status}",
        f"  after {solution.iterations} iterations, {solution.convolutions} convolutions, {solution.seconds:.2g} s",
        f"  residuals      {solution.residuals}",
        f"  modulus E*     {si(solution.modulus, 'Pa', 6)}{alone}",
        f"  force          {si(solution.force, 'N', 6)}",
        f"  mean pressure  {si(solution.mean_pressure, 'Pa', 6)}",
        f"  max pressure   {peak}",
        f"  approach       {si(solution.approach, 'm', 6)}",
        f"  contact area   {solution.area()}",
    ]
    if maps:
        shortest = si(2.0 * max(max(one.grid.spacing) for one in maps), "m", 3)
        lines.append(f"                 of the map as interpolated: waves below {shortest} are not in it")
    if solution.capped:
        lines.append(f"  saturated      {solution.saturated_area()}")
    if solution.theory is not None:
        lines.append(f"  Persson        {solution.theory}")
    if solution.accuracy is not None:
        lines.append(f"  accuracy       {solution.accuracy}")
    for text in solution.warnings:
        lines.append(textwrap.fill(text, _WIDTH, initial_indent="  warning        ", subsequent_indent=17 * " "))
    return "\n".join(lines)
