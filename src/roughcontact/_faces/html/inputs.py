"""What was solved, and with what, for a report."""

from __future__ import annotations

from roughcontact._base.archive import digest_of
from roughcontact._base.units import si
from roughcontact._faces.html.elements import escape, quantity
from roughcontact._faces.html.names import describe_material
from roughcontact._faces.html.rerun import describe_part, hash_pressure
from roughcontact._parts.load import Load
from roughcontact._parts.surfaces import Surface, find_maps
from roughcontact._solve.problem import ContactProblem, problem_of
from roughcontact._solve.solution import ContactSolution, describe_work, key_of_origin, versions
from roughcontact.errors import RoughContactError

_MEANINGS = {
    "complementarity": "mean of the gap where there is pressure, weighted by it",
    "penetration": "deepest overlap of the bodies outside the saturated cells",
    "load": "relative error of the load",
}


def find_problem(solution: ContactSolution) -> tuple[ContactProblem | None, str]:
    """Return the problem that a solution solves, or None and the reason in a sentence."""
    try:
        return problem_of(solution), ""
    except RoughContactError as error:
        return None, str(error)


def list_inputs(solution: ContactSolution, problem: ContactProblem | None) -> dict[str, str]:
    """Return what was solved, as HTML by name."""
    rows = {}
    if problem is not None:
        for name, body in (("Body", problem.body), ("Counterbody", problem.counterbody)):
            rows[name] = f"{_describe_surface(body.surface)}<br>{describe_material(body.material)}"
        rows["Method"] = _code(f"{problem.plan.kernel}, {problem.plan.convolver}, {problem.plan.solver}")
    cell = " x ".join(si(step, "m") for step in solution.grid.spacing)
    rows["Grid"] = escape(f"{solution.grid}, cells of {cell}, boundary {solution.boundary}")
    if solution.non_measured is not None:
        rows["Non-measured points"] = escape(int(solution.non_measured.sum()))
    if solution.origin is not None:
        rows["Load"] = ", ".join(escape(Load(kind, value)) for kind, value in solution.origin.load.items())
        rows["Key"] = f"{_code(key_of_origin(solution.origin) or 'none')} (of problem, load and versions)"
    rows["Pressure"] = f"SHA-256 of its bytes {_code(hash_pressure(solution))}"
    return rows


def list_certificate(solution: ContactSolution) -> dict[str, str]:
    """Return how the solve ended and its residuals with their meaning, as HTML by name."""
    residuals = solution.residuals
    scale = f", over {si(residuals.scale, 'm')}"
    rows = {"Status": escape(solution.status)}
    for name, meaning in _MEANINGS.items():
        value = getattr(residuals, name)
        rows[name.capitalize()] = f"{value:.1e}: {escape(meaning)}{'' if name == 'load' else escape(scale)}"
    rows["Modulus E*"] = escape(si(solution.modulus, "Pa", 6))
    if solution.moduli is not None:
        rows["Modulus E*"] += ", that of the materials: the kernel has another for each wavelength"
    rows["Work"] = describe_work(solution)
    if solution.accuracy is not None:
        rows["Accuracy"] = quantity(str(solution.accuracy).replace("\n", "; "))
    if solution.theory is not None:
        rows["Persson's theory"] = quantity(str(solution.theory))
    return rows


def list_versions(solution: ContactSolution) -> dict[str, str]:
    """Return the versions of the programs that made a solution, as HTML by name."""
    numbers = versions() if solution.origin is None else solution.origin.versions
    rows = {"Packages": escape(", ".join(f"{name} {number}" for name, number in numbers.items()))}
    programs = [] if solution.origin is None else solution.origin.programs
    return rows | ({"Plug-ins": escape(", ".join(programs))} if programs else {})


def _describe_surface(surface: Surface) -> str:
    """Return a surface, where its heights come from, and the digests of those that are not computed."""
    maps = find_maps(surface)
    text = _code(describe_part(surface))
    if surface.provenance and maps:
        text += f"<br>{escape('; '.join(surface.provenance))}"
    for one in maps:
        text += f"<br>digest of its {' x '.join(map(str, one.values.shape))} heights {_code(digest_of(one.values))}"
    return text


def _code(text: str) -> str:
    return f"<code>{escape(text)}</code>"
