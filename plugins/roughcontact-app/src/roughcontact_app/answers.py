"""The answers of a run: numbers with uncertainty and unit for the page, and a table of them for a spreadsheet."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import attrs
from roughcontact import ContactSolution, Estimate, FrictionalPath
from roughcontact.errors import RoughContactError
from roughcontact.faces import (
    describe_other_places,
    exceeds_metals,
    gather_warnings,
    list_answer_warnings,
    list_quantities,
    name_load,
    tabulate_answers,
    write_column,
)
from roughcontact.results import AdhesionCycle, LoadPath, Sweep
from roughcontact.results import Path as StatePath
from roughcontact.typing import Table, si

from roughcontact_app.hertz import list_closed_form
from roughcontact_app.responses import finite
from roughcontact_app.words import end_sentence

# Columns of the table of a path that the answer of each state has.
_IN_ANSWERS = [
    *("increments", "mean_pressure", "force", "approach", "area", "area_uncertainty", "area_fraction"),
    *("peak_pressure", "peak_pressure_uncertainty"),
]
# Digits of a number in a table: more than any uncertainty leaves.
_DIGITS = 9


def describe_solutions(
    solutions: Sequence[ContactSolution], asked: Mapping[str, Sequence[Any]] = MappingProxyType({})
) -> list[dict[str, Any]]:
    """Return the answer at each load: how the solve ended, quantities by name in SI units, and all warnings.

    `asked` is what responses have answered, one for each solution, by their names.
    """
    found = [list_quantities(solution) for solution in solutions]
    certain = [solution.area().certain_fraction for solution in solutions]
    if any(fraction is not None for fraction in certain):
        for (quantities, _), fraction in zip(found, certain, strict=True):
            quantities["part of the contact that the tip touched"] = Estimate(
                math.nan if fraction is None else fraction, 0.0, ""
            )
    for name, column in tabulate_answers(asked).items():
        words = _in_words(name)
        for (quantities, _), one in zip(found, column, strict=True):
            # A name that a response shares with a quantity hides none.
            quantities[f"{words} (asked)" if words in quantities else words] = one
    for index, (_, warnings) in enumerate(found):
        warnings += list_answer_warnings({name: [column[index]] for name, column in asked.items()}, [solutions[index]])
    columns = {name: iter(write_column([quantities[name] for quantities, _ in found])) for name in found[0][0]}
    places = [describe_other_places(solution, found[index][0]) for index, solution in enumerate(solutions)]
    return [
        make_answer(
            name_load(solution),
            [describe_quantity(name, one, next(columns[name])) for name, one in quantities.items()],
            (*_warn_of_hardness(solution), *warnings),
            status=str(solution.status),
            certified=solution.status.success,
            seconds=solution.seconds,
            places=f"{place.replace('+-', '±')}." if place else "",
            closed_form=list_closed_form(solution),
        )
        for solution, (quantities, warnings), place in zip(solutions, found, places, strict=True)
    ]


def make_answer(
    load: str,
    quantities: Sequence[dict[str, Any]],
    warnings: Iterable[str],
    *,
    status: str,
    certified: bool,
    seconds: float = 0.0,
    **others: Any,
) -> dict[str, Any]:
    """Return an answer as the page takes it, plain data that JSON can hold.

    Parameters
    ----------
    load
        The load or the separation in words.
    quantities
        Its numbers, by `describe_quantity`.
    warnings
        Its warnings, which become sentences.
    status, certified, seconds
        How its solve ended, whether it is certified, and how long it took, s.
    others
        What only some answers have: ``places`` and ``note``, sentences, and ``closed_form``.
    """
    sentences = [end_sentence(text) for text in warnings]
    of_solve = {"status": status, "certified": certified, "seconds": seconds}
    return {"load": load, **of_solve, "quantities": list(quantities), "warnings": sentences, **others}


def describe_path(path: LoadPath, asked: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Return the answer of each state of a path on which the surfaces change, with what has passed and what is lost.

    `asked` is what responses have answered for each state, by their names.
    """
    rows = _describe_rows([path.table()])
    answers = describe_solutions(path.states, asked)
    # No closed form is of a state that others went before.
    return [
        {**answer, "load": f"state {number}", "quantities": [*row, *answer["quantities"]], "closed_form": {}}
        for number, (row, answer) in enumerate(zip(rows, answers, strict=True), start=1)
    ]


def describe_sweep(sweep: Sweep, asked: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Return the answer at each load, a first loading, with the numbers of the laws that its materials bring.

    `asked` is what responses have answered, one for each solution, by their names.
    """
    answers = describe_solutions(sweep.states, asked)
    if not any(addition.kind == "laws" for addition in sweep.states[0].added):
        return answers
    rows = _describe_rows([LoadPath(states=(one,), increments=(1,)).table() for one in sweep.states])
    return [{**answer, "quantities": [*answer["quantities"], *row]} for row, answer in zip(rows, answers, strict=True)]


def _describe_rows(tables: Sequence[Table]) -> list[list[dict[str, Any]]]:
    """Return the numbers of the states in tables of the same columns, but for those that each answer has."""
    units = tables[0].units
    columns = {
        name.replace("_", " "): [_estimate(one, units.get(name, "")) for table in tables for one in table.columns[name]]
        for name in tables[0].columns
        if name not in _IN_ANSWERS
    }
    texts = {name: write_column(column) for name, column in columns.items()}
    count = sum(len(table.columns["force"]) for table in tables)
    return [
        [describe_quantity(name, column[number], texts[name][number]) for name, column in columns.items()]
        for number in range(count)
    ]


def _estimate(one: float | Estimate, unit: str) -> Estimate:
    return one if isinstance(one, Estimate) else Estimate(float(one), 0.0, unit)


def _in_words(column: str) -> str:
    """Return the name of a number of a response as words."""
    return re.sub("[-_]", " ", column).replace("von mises", "von Mises")


def tabulate_path(path: StatePath, asked: Mapping[str, Sequence[Any]]) -> Table:
    """Return the table of a path, with what responses have answered for its states."""
    table = path.table()
    return Table({**table.columns, **tabulate_answers(asked)}, table.units, table.left)


def find_pull_off(cycle: AdhesionCycle) -> Estimate:
    """Return the force of pull-off, whatever the steps of a cycle; if it cannot be followed, the lowest of its states.

    The states may be farther apart than the surfaces attract each other.
    """
    try:
        found: Estimate = cycle.loading[0].response("pull-off")
    except RoughContactError:
        return cycle.pull_off
    return found


def describe_cycle(cycle: AdhesionCycle, asked: Mapping[str, Sequence[Any]] = MappingProxyType({})) -> dict[str, Any]:
    """Return the answer of a cycle, in the form of the answer at a load.

    `asked` is what responses have answered for each of its states; shown is the answer at the last approach.
    """
    # Unloading starts where loading ends.
    states = (*cycle.loading, *cycle.unloading[1:])
    pull_off = find_pull_off(cycle)
    shared = dict.fromkeys((*pull_off.warnings, *cycle.pull_in.warnings))
    # Both branches have a state at each approach.
    others: dict[str, list[str]] = {}
    for state in states:
        known = others.setdefault(name_load(state), [])
        known += [text for text in state.warnings if text not in (*shared, *known)]
    found = {"pull-off": pull_off, "pull-in": cycle.pull_in, "energy lost": cycle.dissipated}
    for name, column in tabulate_answers(asked).items():
        if name == "pull-off":
            continue
        found[f"{_in_words(name)} at the last approach"] = column[len(cycle.loading) - 1]
    quantities = [describe_quantity(name, one, write_column([one])[0]) for name, one in found.items()]
    places = "; ".join(f"{si(first, 'm', 3)} to {si(last, 'm', 3)}" for first, last in cycle.jumps)
    count = Estimate(float(len(cycle.jumps)), 0.0, "")
    quantities.append(describe_quantity("jumps", count, f"{len(cycle.jumps)}{f': {places}' if places else ''}"))
    return make_answer("cycle", quantities, (*shared, *gather_warnings([*others.items()])), **_sum_up(states))


def describe_fretting(path: FrictionalPath, asked: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """Return the answer of a fretting cycle, in the form of the answer at a load: to a turn, back and there again.

    `asked` is what responses have answered for each state; shown is the answer of the last one.
    """
    along = [state.tangential_force[0] for state in path]
    back, there = path.numbers[along.index(min(along))], path.numbers[-1]
    parts = [one.dissipated for one in path.numbers[along.index(max(along[: along.index(min(along))])) + 1 :]]
    lost = Estimate(sum(part.value for part in parts), sum(part.uncertainty for part in parts), "J")
    # The increments shift both turning points alike, not independently.
    ends = there.displacement[0], back.displacement[0]
    moved = Estimate(ends[0].value - ends[1].value, sum(end.uncertainty for end in ends), "m")
    found = {
        "energy lost in a cycle": lost,
        "displacement from turn to turn": moved,
        "area that sticks at the first turn": back.stick_area,
        "area that sticks at the second turn": there.stick_area,
        "contact area": path[-1].area(),
        "approach": Estimate(path[-1].approach, 0.0, "m"),
    }
    for name, column in tabulate_answers(asked).items():
        found[f"{_in_words(name)} at the end"] = column[-1]
    hard = _warn_of_hardness(path[-1])
    said = list_answer_warnings({name: column[-1:] for name, column in asked.items()}, path[-1:])
    quantities = [
        describe_quantity(name, attrs.evolve(one, warnings=()), write_column([one])[0]) for name, one in found.items()
    ]
    return make_answer("fretting", quantities, (*hard, *path.warnings, *said), **_sum_up(path.states))


def _sum_up(states: Sequence[ContactSolution]) -> dict[str, Any]:
    """Return how the solves of a cycle ended, for its one answer."""
    return {
        "status": str(states[-1].status),
        "certified": all(state.status.success for state in states),
        "seconds": sum(state.seconds for state in states),
    }


def _warn_of_hardness(solution: ContactSolution) -> list[str]:
    """Return that stiff bodies without a hardness bear more than metals do; a script may mean to have no limit."""
    materials = () if solution.origin is None else solution.origin.materials.values()
    if not exceeds_metals(solution, materials):
        return []
    pressure = si(float(solution.pressure.max()), "Pa", 2)
    return [f"The maximum pressure, {pressure}, is more than metals bear: unless it is meant, give a hardness"]


def list_warnings(answers: list[dict[str, Any]]) -> list[str]:
    """Return the warnings of all answers, each once, with the loads that it concerns."""
    return gather_warnings([(answer["load"], answer["warnings"]) for answer in answers])


def make_table(answers: list[dict[str, Any]]) -> str:
    """Return the answers as CSV: a row for each load, a column for each quantity and for its uncertainty."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\r\n")
    names = list(dict.fromkeys((one["name"], one["unit"]) for answer in answers for one in answer["quantities"]))
    head = [f"{name}{', ' if unit else ''}{unit}" for name, unit in names]
    writer.writerow([text for title in head for text in (title, f"uncertainty of {title}")] + ["status", "warnings"])
    for answer in answers:
        known = {one["name"]: one for one in answer["quantities"]}
        cells = [known.get(name, {"value": "", "uncertainty": ""}) for name, _ in names]
        numbers = [_round(value) for cell in cells for value in (cell["value"], cell["uncertainty"])]
        writer.writerow([*numbers, answer["status"], " ".join(answer["warnings"])])
    return file.getvalue()


def _round(value: float | str | None) -> float | str:
    """Return a number without the digits that rounding errors have made, such as those of 4.999999999999999 N."""
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value or ""


def describe_quantity(name: str, one: Estimate, text: str) -> dict[str, Any]:
    """Return a number of an answer, plain data that JSON can hold; the text is its value as it is read."""
    numbers = {"value": finite(one.value), "uncertainty": finite(one.uncertainty)}
    return {"name": name, **numbers, "unit": one.unit, "text": text}
