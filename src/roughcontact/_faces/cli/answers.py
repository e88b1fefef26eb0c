"""The answers of a solve as text, JSON and CSV, and the files that a solve writes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.tables import Table
from roughcontact._base.units import fit, si, without_reasons
from roughcontact._faces.html.pages import require_jinja
from roughcontact._faces.panels.animation import ANIMATION
from roughcontact._faces.panels.figures import save_figure
from roughcontact._faces.panels.theme import require_matplotlib
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.problem import (
    RequiredLoad,
    Sweep,
    describe_estimate,
    describe_loads,
    describe_part,
    describe_problem,
    describe_solution,
    describe_value,
    find_versions,
    format_json,
)
from roughcontact._solve.solution import (
    gather_warnings,
    list_estimates,
    list_quantities,
    require_netcdf,
    versions,
)
from roughcontact._work.studies import (
    Answers,
    Study,
    add_answers,
    describe_answers_elsewhere,
    list_answer_warnings,
    name_of,
    tabulate_answers,
    write_report,
)

_NONE: Answers = MappingProxyType({})
# Width of the label of a line, as `print(solution)` has it.
_LABEL_WIDTH = 18
PICTURES = frozenset({".png", ".svg", ".pdf"})
# Endings of files that hold answers of responses too.
LATE = frozenset({".html", ".json"})


def to_json(
    solutions: Sequence[rc.ContactSolution],
    estimator: str | None = None,
    answers: Answers = _NONE,
    asked: Mapping[str, Any] = _NONE,
) -> str:
    """Return one JSON object: the description of the only solution, or a list of them under ``solutions``.

    `estimator` is the name of an area estimator whose area is given besides the default, `answers` what responses say,
    `asked` what was asked for, for the inputs.
    """
    described = [describe_solution(solution, estimator) for solution in solutions]
    for one in described:
        if one["inputs"] is not None:
            one["inputs"] |= asked
    if answers:
        for position, one in enumerate(described):
            one["responses"] = {name: describe_result(found[position]) for name, found in answers.items()}
    if len(described) == 1:
        return format_json({**described[0], "versions": find_versions(solutions[0])})
    return write_json({"solutions": described})


def write_json(content: dict[str, Any]) -> str:
    """Return data as one JSON object, with the versions of the packages; null for numbers that JSON does not have."""
    return format_json({**content, "versions": versions()})


def describe_rows(table: Table) -> list[dict[str, Any]]:
    """Return the rows of a table as data that JSON can hold."""
    columns = [[_plain(value) for value in column] for column in table.columns.values()]
    return [dict(zip(table.columns, row, strict=True)) for row in zip(*columns, strict=True)]


def _plain(value: Any) -> Any:
    if isinstance(value, rc.Estimate):
        return describe_estimate(value)
    return value.item() if hasattr(value, "item") else value


def to_csv(solutions: Sequence[rc.ContactSolution], estimator: str | None = None, answers: Answers = _NONE) -> str:
    """Return a header and a row for each load, in SI units: the columns of `Sweep.to_pandas`, and more."""
    table = Sweep(tuple(solutions)).table()
    columns: dict[str, Any] = {
        **table.columns,
        "saturated_area": [float(solution.saturated_area().value) for solution in solutions],
        "status": [solution.status.name for solution in solutions],
        "warnings": [" ".join(_warnings(solution)) for solution in solutions],
        "convolutions": [solution.convolutions for solution in solutions],
        "seconds": [solution.seconds for solution in solutions],
    }
    units = {**table.units, "saturated_area": "m2", "seconds": "s"}
    if estimator is not None:
        others = [solution.area(estimator) for solution in solutions]
        columns["other_area"] = [float(area.value) for area in others]
        columns["other_area_uncertainty"] = [float(area.uncertainty) for area in others]
        units |= {"other_area": "m2", "other_area_uncertainty": "m2"}
    return write_csv(Table({**columns, **tabulate_answers(answers)}, units))


def write_csv(table: Table) -> str:
    """Return a table as a header and rows, in SI units, with all digits."""
    text = io.StringIO()
    table.write(text)
    return text.getvalue().replace("\r\n", "\n").rstrip("\n")


def to_text(solutions: Sequence[rc.ContactSolution], estimator: str | None = None, answers: Answers = _NONE) -> str:
    """Return the answer for people, of at most 80 columns: of one load, or as a table over several."""
    lines = [str(solutions[0])]
    if len(solutions) > 1:
        warnings = gather_warnings([(si(solution.force, "N"), list_quantities(solution)[1]) for solution in solutions])
        lines = [str(Sweep(tuple(solutions))), "+-: one standard deviation"]
        lines += [f"warning  {text}" for text in warnings]
    if estimator is not None:
        lines += ["", *(f"Area: {solution.area(estimator)}" for solution in solutions)]
    if answers:
        lines += ["", *_write_answers(solutions, answers)]
    return fit("\n".join(lines))


def _write_answers(solutions: Sequence[rc.ContactSolution], answers: Answers) -> list[str]:
    """Return the lines of the answers of one solution; of several those of a table, and of what has no number."""
    if len(solutions) == 1:
        return write_answers_of_one(answers, solutions)
    forces = [rc.Estimate(solution.force, 0.0, "N") for solution in solutions]
    loads = [si(one.value, "N") for one in forces]
    lines = write_rows_of_answers(Table({"force": forces}), [f"at {load}" for load in loads], answers, {}, solutions)
    places = describe_answers_elsewhere(answers, loads)
    return lines + ([f"other places  {places}"] if places else [])


def write_answers_of_one(answers: Answers, solutions: Sequence[rc.ContactSolution]) -> list[str]:
    """Return the lines of the answers of one state, of warnings that its area does not have, and of other places."""
    lines = []
    for name, found in answers.items():
        lines += _label(name, without_reasons(str(found[0]), list_estimates(found[0]).values()))
    lines += [line for text in list_answer_warnings(answers, solutions) for line in _label("warning", text)]
    places = describe_answers_elsewhere(answers, [""])
    return lines + (_label("other places", places) if places else [])


def write_rows_of_answers(
    states: Table,
    names: Sequence[str],
    answers: Answers,
    reasons: Mapping[str, str] = MappingProxyType({}),
    solutions: Sequence[rc.ContactSolution] = (),
) -> list[str]:
    """Return the lines of a table of states, with answers, of what has no number, of warnings and missing answers.

    `names` says where each state is, such as ``"at 5 N"``, `reasons` why a response has no answer. What the solutions
    themselves are warned of is omitted.
    """
    lines = add_answers(states, answers).to_text().split("\n")
    for name, found in answers.items():
        for where, result in zip(names, found, strict=True):
            if result is not None and not list_estimates(result):
                lines += _label(name, f"{where}: {result}")
    lines += [f"warning  {text}" for text in list_answer_warnings(answers, solutions)]
    return [*lines, *(f"{name}: {text}" for name, text in reasons.items())]


def _label(name: str, text: str) -> list[str]:
    first, *others = text.split("\n")
    return [f"{name:{_LABEL_WIDTH - 1}} {first}", *(f"{'':{_LABEL_WIDTH}}{line}" for line in others)]


def describe_result(result: Any) -> dict[str, Any]:
    """Return what a response has returned as data that JSON can hold."""
    if isinstance(result, rc.Estimate):
        return describe_estimate(result)
    return {name: describe_estimate(one) for name, one in list_estimates(result).items()} or {"text": str(result)}


def is_doubtful(answers: Answers, solutions: Sequence[rc.ContactSolution] = (), estimator: str | None = None) -> bool:
    """Return whether what responses answered, or the area by a further estimator, is warned of.

    What the default area and the maximum pressure of the solutions are warned of does not count.
    """
    known = {text for solution in solutions for text in solution.area().warnings}
    others = [] if estimator is None else [text for one in solutions for text in one.area(estimator).warnings]
    return bool(list_answer_warnings(answers, solutions) or set(others) - known)


def _warnings(solution: rc.ContactSolution) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*solution.warnings, *solution.area().warnings)))


def plan_outputs(given: Sequence[str], report: str | None, maps: Sequence[Path], count: int = 1) -> list[Path]:
    """Return the files to be written; a name without an ending is the name of a folder, which is made.

    `count` solutions get their numbers when they are written.

    Raises
    ------
    InputError
        If a folder is missing, no writer knows an ending, or a height map would be overwritten.
    MissingPackage
        If a picture, a report or netCDF is asked for without its packages.
    """
    writers = [rc.writers.create(name) for name in rc.writers]
    known = {suffix for writer in writers if not writer.divided for suffix in writer.suffixes} | PICTURES
    files = []
    for text in given:
        path = checks.path(text, "The output")
        if path.is_dir() or not path.suffix or text.endswith("/"):
            path.mkdir(parents=True, exist_ok=True)
            files += [path / "solution.npz", path / "solution.png"]
        elif path.suffix in known:
            files.append(path)
        else:
            allowed = f"a folder, or a file that ends in {', '.join(sorted(known))}"
            raise rc.InputError.about("The output", text, allowed)
    for path in files:
        require_place(path, (path, *_numbered(path, count)), maps)
        require_packages(path.suffix)
    return files + plan_report(report, maps)


def plan_report(report: str | None, maps: Sequence[Path]) -> list[Path]:
    """Return the file of a report, if there is one; see `plan_outputs`."""
    if report is None:
        return []
    path = checks.path(report, "The report")
    if path.suffix != ".html":
        raise rc.InputError.about("The report", report, "a file that ends in .html")
    require_place(path, [path], maps)
    require_packages(path.suffix)
    return [path]


def require_packages(ending: str) -> None:
    """Raise `MissingPackage` without the packages that write a file of this ending."""
    # A report has figures.
    if ending in {*PICTURES, ".html"}:
        require_matplotlib()
    if ending == ".html":
        require_jinja()
    if ending == ".nc":
        require_netcdf()


def require_place(path: Path, targets: Sequence[Path], maps: Sequence[Path]) -> None:
    """Raise `InputError` if there is no folder for a file, or if one of its targets is a height map that is read."""
    if not path.parent.is_dir():
        raise rc.InputError(f"There is no folder {str(path.parent)!r} to write {path.name!r} into.")
    for target in targets:
        if target.exists() and any(one.exists() and target.samefile(one) for one in maps):
            raise rc.InputError(f"The output {str(target)!r} is a height map that is read: give another name.")


def plan_picture(text: str, others: Sequence[str] = ()) -> Path:
    """Return the file of a picture; `InputError`, which also names the endings `others`, for another ending."""
    path = checks.path(text, "The output")
    if path.suffix not in PICTURES:
        raise rc.InputError.about("The output", text, f"a file that ends in {', '.join((*others, *sorted(PICTURES)))}")
    require_matplotlib()
    return path


def plan_path_picture(text: str, others: Sequence[str] = ()) -> Path:
    """Return the file of a picture of a path, still or moving; see `plan_picture`."""
    path = checks.path(text, "The output")
    if path.suffix != ANIMATION:
        return plan_picture(text, (*others, ANIMATION))
    require_matplotlib()
    return path


def save_path_picture(path: StatePath, file: Path, dark: bool = False) -> None:
    """Write a picture of a path, still or moving as the ending says."""
    if file.suffix == ANIMATION:
        path.animate(file, dark=dark)
    else:
        save_figure(path.plot(dark=dark), file)


def write_late(
    files: Sequence[Path],
    solutions: Sequence[rc.ContactSolution],
    estimator: str | None,
    answers: Answers,
    asked: Mapping[str, Any],
) -> None:
    """Write the files that hold answers of responses too: reports, and what ``--json`` prints."""
    for path in files:
        if path.suffix == ".html":
            write_report(solutions, path, answers)
            continue
        with replacing(path) as partial:
            partial.write_text(f"{to_json(solutions, estimator, answers, asked)}\n", encoding="utf-8")


def write_outputs(files: Sequence[Path], subject: Any, solutions: Sequence[rc.ContactSolution]) -> list[Path]:
    """Return the files that were written: solutions (several with their numbers) and pictures."""
    written = []
    for path in files:
        if path.suffix in PICTURES:
            save_figure(subject.plot(), path)
            written.append(path)
            continue
        for target, solution in zip(_numbered(path, len(solutions)), solutions, strict=True):
            solution.save(target)
            written.append(target)
    return written


def name_written(files: Sequence[Path]) -> str:
    """Return a line that names the files that were written, below an empty one; empty without any."""
    return fit(f"\nWritten: {', '.join(map(str, files))}") if files else ""


def _numbered(path: Path, count: int) -> list[Path]:
    return [path] if count == 1 else [path.with_stem(f"{path.stem}-{number}") for number in range(1, count + 1)]


def describe_responses(asked: Mapping[str, rc.Response[Any]]) -> dict[str, Any]:
    """Return what is asked of a contact, with its fields, by name; empty if nothing is."""
    return {"responses": {name: describe_part(one) for name, one in asked.items()}} if asked else {}


def describe_wanted(answer: rc.Response[Any], required: RequiredLoad) -> dict[str, Any]:
    """Return the answer for which a load was asked, and what was wanted of it."""
    return {"solve_for": {"answer": describe_part(answer), **describe_value(required.wanted, required.answer.unit)}}


def describe_study(study: Study) -> dict[str, Any]:
    """Return the problems of a study by name, and what each is solved at and asked for."""
    return {
        "problems": {name: describe_problem(problem) for name, problem in study.problems.items()},
        "load": describe_loads(study.loads),
        "seeds": list(study.seeds),
        "areas": list(study.areas),
        **describe_responses({name_of(one): one for one in study.responses}),
        **study.loading.describe(),
    }
