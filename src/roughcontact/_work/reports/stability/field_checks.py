"""Checks of the fields of a solution."""

from __future__ import annotations

import math

from roughcontact._answers.areas.curvature import curvature_resolution
from roughcontact._solve.solution import ContactSolution, Status, find_contact, find_scene
from roughcontact._work.reports.stability.check import Check, SolvedProblem, Verdict, assess, skip
from roughcontact._work.reports.stability.rules import RULES


def check_residuals(solved: SolvedProblem) -> list[Check]:
    """Return how the solve ended, the error of the load, and the residuals of the contact conditions."""
    solution = solved.solution
    residuals = solved.solution.residuals
    verdict = Verdict.PASS
    advice = ""
    if solution.status is not Status.CONVERGED:
        verdict = Verdict.ATTENTION if solution.status.success else Verdict.FAIL
        advice = RULES["convergence"].advice
    finding = f"{solution.status}; {solution.iterations} iterations, {solution.convolutions} convolutions"
    gap = "pressure-weighted mean gap in contact, over the scale of the residuals"
    overlap = "maximum overlap outside saturated cells, over the scale of the residuals"
    return [
        Check("convergence", verdict, residuals.error, finding, advice),
        _check_load(solved),
        assess("complementarity", residuals.complementarity, gap),
        assess("penetration", residuals.penetration, overlap),
    ]


def check_model(solved: SolvedProblem) -> list[Check]:
    """Return whether units, domain, grid and half-space suit the contact."""
    plan = solved.problem.plan
    solution = solved.solution
    findings = find_scene(solution.initial_gap, plan.grid, plan.boundary, plan.materials) + find_contact(solution)
    checks = [
        skip(finding.rule, finding.text)
        if math.isnan(finding.value)
        else assess(finding.rule, finding.value, finding.text)
        for finding in findings
    ]
    return [*checks, _check_resolution(solution)]


def check_area(solution: ContactSolution) -> list[Check]:
    """Return the relative uncertainty of the real contact area, and the number of its warnings."""
    name = "area: uncertainty"
    area = solution.area()
    warnings = assess("area: warnings", len(area.warnings), "; ".join(area.warnings) or "no warnings")
    if not area.value > 0.0:
        return [skip(name, "there is no contact"), warnings]
    finding = f"the area is {100 * area.fraction:.4g} % of nominal; standard deviation over area [{area.estimator}]"
    return [assess(name, area.uncertainty / area.value, finding), warnings]


def _check_load(solved: SolvedProblem) -> Check:
    name = "load balance"
    load = solved.load
    grid = solved.solution.grid
    if load.kind == "approach":
        return skip(name, "the approach is given, and the load follows from it")
    force = load.value if load.kind == "force" else load.value * grid.area
    carried = math.fsum(solved.solution.pressure.ravel()) * grid.cell_area
    return assess(name, abs(carried / force - 1.0), "relative error of the load, summed without rounding")


def _check_resolution(solution: ContactSolution) -> Check:
    name = "cells per wavelength"
    if not solution.contact.any():
        return skip(name, "there is no contact")
    squared = curvature_resolution(solution)
    cells = 2.0 * math.pi / math.sqrt(squared) if squared > 0.0 else math.inf
    return assess(name, cells, "wavelength that dominates the curvature in contact, in cells")
