"""Errors and uncertainties of an area estimator on classes of contacts: tuned, held-out and fresh ones.

    python benchmarks/area_classes.py [--classes wave-whole,ball-centred] [--split held-out] [--estimator blend]
        [--cache FOLDER] [--groups] [--worst 5] [--references]

Prints for each class the number of cases, rms error, 95th percentile and maximum, the fractions of errors within one
and two stated standard deviations, the medians of error and uncertainty and their ratio, the largest error over the
uncertainty, and the median uncertainty of the true values. Solutions are kept in the folder; the true values in
benchmarks/area_references.json, which `--references` computes where they are missing (20 minutes).
"""

from __future__ import annotations

import argparse
import json
import math
import os
import pickle
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from pathlib import Path

import contact_classes as contacts
import numpy as np
import rough_classes as rough
import unkind_classes as unkind
from contact_classes import Case

import roughcontact as rc

REFERENCES = Path(__file__).parent / "area_references.json"
# Constants were set on the first; the second was looked at meanwhile; the third was drawn when all were set.
SPLITS = ("tuned", "held-out", "fresh")
BANDS = ("light", "middle", "heavy")
CLASSES = {
    "wave-whole": contacts.wave_whole,
    "wave-random": contacts.wave_random,
    "wave-other": contacts.wave_other,
    "ball-centred": partial(contacts.ball, centred=True),
    "ball-random": partial(contacts.ball, centred=False),
    **{f"rough-{band}": partial(rough.rough, band=band) for band in BANDS},
    **{f"lay-{band}": partial(rough.lay, band=band, turned=False) for band in BANDS},
    **{f"lay-turned-{band}": partial(rough.lay, band=band, turned=True) for band in BANDS},
    "strips-axis": partial(contacts.strips, directions=((1, 0), (0, 1))),
    "strips-45": partial(contacts.strips, directions=((1, 1), (1, -1))),
    "strips-1:2": partial(contacts.strips, directions=((1, 2), (-2, 1))),
    "ellipse-centred": partial(contacts.ellipse, centred=True),
    "ellipse-random": partial(contacts.ellipse, centred=False),
    "capped-rough": rough.capped_rough,
    "capped-ball": rough.capped_ball,
    "capped-punch": rough.capped_punch,
    "run-in-half": partial(rough.run_in, fraction=0.5),
    "run-in-own": partial(rough.run_in, fraction=1.0),
    "cone": partial(contacts.cone, power=1.0),
    "cubic": partial(contacts.cone, power=3.0),
    "border": rough.border,
    "holes-kept": partial(rough.holes, filled=False),
    "holes-filled": partial(rough.holes, filled=True),
    "map-blurred": partial(rough.maps, kind="blurred", original=False),
    "map-upsampled": partial(rough.maps, kind="upsampled", original=False),
}
# Judged against the surface from which the map came, whose heights it has lost: not among "all".
LOST = {
    "lost-blurred": partial(rough.maps, kind="blurred", original=True),
    "lost-upsampled": partial(rough.maps, kind="upsampled", original=True),
}
# Long domains and cells, slender ellipses, tips, holes: closed forms, in two minutes; named "unkind" together.
UNKIND = unkind.CLASSES
Judged = tuple[rc.ContactSolution, float, float, Case]  # solution, true area and its standard deviation (m2), case


def list_cases(name: str, split: str) -> list[Case]:
    return list({**CLASSES, **LOST, **UNKIND}[name](split))


# --- true values ------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=1)
def known() -> dict[str, dict[str, list[float]]]:
    return json.loads(REFERENCES.read_text(encoding="utf-8")) if REFERENCES.exists() else {}


def reference_key(name: str, case: Case) -> str:
    kind = next((k for k in ("wave", "rough", "lay-turned", "lay", "lost") if name.startswith(k)), name)
    return f"{kind}: {case.key}"


def quantities(problem: rc.ContactProblem, load: dict[str, float]) -> dict[str, float]:
    solution = problem.solve(**load)
    area, wide = solution.area(), solution.grid.area
    return {
        "area": area.value / wide,
        "uncertainty": area.uncertainty / wide,
        "p_max": float(solution.pressure.max()),
        "approach": solution.approach,
        "mean_gap": float(solution.gap.mean()),
        "open_gap": float(np.maximum(solution.gap, 0.0).mean()),
        "perimeter": area.perimeter / wide**0.5,
        "patches": solution.patches.count,
    }


def find_reference(case: Case) -> dict[str, list[float]]:
    """Return fractions and other numbers on the finest grid and on half as many cells, in pairs."""
    places = (case.fine, *case.others)
    fine = contacts.FINEST if case.others else contacts.FINE
    pair = [[quantities(make(cells), case.load) for make in places] for cells in (fine, fine // 2)]
    return {name: [float(f"{np.mean([each[name] for each in level]):.7g}") for level in pair] for name in pair[0][0]}


def find_references(names: Sequence[str]) -> None:
    """Compute the true values that are missing and write them to the file."""
    table = dict(known())
    for name in names:
        for split in SPLITS:
            for case in list_cases(name, split):
                key = reference_key(name, case)
                if case.true is None and key not in table:
                    table[key] = find_reference(case)
        rows = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in sorted(table.items())]
        REFERENCES.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")
        print(f"{name}: {len(table)} references", flush=True)
    known.cache_clear()


def true_area(name: str, case: Case, solution: rc.ContactSolution) -> tuple[float, float]:
    """Return the true area and its standard deviation, m2."""
    if case.true is not None:
        return case.true["area"], 0.0
    found = known()[reference_key(name, case)]
    wide = 25.0 if name == "capped-ball" else solution.grid.area
    # The error of the finest grid: about a third of what the last refinement has changed.
    fine, half = found["area"]
    return fine * wide, min(found["uncertainty"][0], abs(fine - half) / 3) * wide


# --- coarse solutions, kept in a folder -------------------------------------------------------------------------------


def load_solutions(file: Path) -> dict[str, rc.ContactSolution]:
    """Return the solutions in a file; none if there is no file, or if another version of the package has written it."""
    try:
        return pickle.loads(file.read_bytes())
    except (OSError, ImportError, rc.RoughContactError, AttributeError):
        return {}


def cases(name: str, split: str, folder: Path | None = None) -> Iterator[Judged]:
    """Yield solution, true area and its standard deviation, m2, and case for each contact of a class."""
    folder = Path(folder or os.environ.get("AREA_CLASSES_CACHE") or Path(tempfile.gettempdir()) / "area_classes")
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name.replace(':', '-')}-{split}.pickle"
    solved = load_solutions(file)
    wanted = list_cases(name, split)
    missing = [case for case in wanted if case.label not in solved]
    for case in missing:
        solved[case.label] = case.problem().solve(**case.load)
    if missing:
        file.write_bytes(pickle.dumps({case.label: solved[case.label] for case in wanted}))
    for case in wanted:
        solution = solved[case.label]
        yield solution, *true_area(name, case, solution), case


# --- judgement --------------------------------------------------------------------------------------------------------

DIGITS = 1e-6
HEADER = (
    f"{'':22}{'n':>4}{'rms %':>8}{'95 %':>8}{'max %':>8}{'bias %':>8}{'< 1 sd':>7}{'< 2 sd':>7}"
    f"{'|e| %':>8}{'sd %':>8}{'ratio':>6}{'max z':>7}{'true %':>8}"
)


def judge(judged: Sequence[tuple[float, float, float]]) -> dict[str, float]:
    """Return what relative errors, their stated and the true values' standard deviations amount to."""
    error, stated, true = np.array(judged).T
    # The true values have six digits.
    size, z = np.abs(error), np.abs(error) / np.maximum(stated, DIGITS)
    return {
        "n": len(error),
        "rms": float(np.sqrt(np.mean(error**2))),
        "95 %": float(np.quantile(size, 0.95)),
        "max": float(error[np.argmax(size)]),
        "bias": float(np.mean(error)),
        "within 1": float(np.mean(z <= 1.0)),
        "within 2": float(np.mean(z <= 2.0)),
        "median error": float(np.median(size)),
        "median uncertainty": float(np.median(stated)),
        "ratio": float(np.median(stated) / np.median(size)) if np.median(size) > DIGITS else math.nan,
        "max z": float(np.max(z)),
        "true": float(np.median(true)),
    }


def print_row(title: str, found: dict[str, float]) -> None:
    per_cent = ("rms", "95 %", "max", "bias")
    print(
        f"{title:22}{found['n']:4d}" + "".join(f"{100 * found[key]:8.3f}" for key in per_cent)
        + f"{found['within 1']:7.2f}{found['within 2']:7.2f}"
        + f"{100 * found['median error']:8.3f}{100 * found['median uncertainty']:8.3f}"
        + f"{found['ratio']:6.1f}{found['max z']:7.1f}{100 * found['true']:8.3f}",
        flush=True,
    )  # fmt: skip


def print_rows(
    name: str, rows: Sequence[tuple[float, float, float, Case]], *, groups: bool = False, worst: int = 0
) -> dict[str, float]:
    """Print the row of a class, of its resolutions and its worst cases, and return the first."""
    found = judge([row[:3] for row in rows])
    print_row(name, found)
    if groups:
        for group in dict.fromkeys(row[3].group for row in rows):
            print_row(f"    {group}", judge([row[:3] for row in rows if row[3].group == group]))
    for error, stated, _, case in sorted(rows, key=lambda row: -abs(row[0]) / max(row[1], DIGITS))[:worst]:
        print(f"    {100 * error:+.3f} +- {100 * stated:.3f} %: {case.label}")
    return found


def estimate(
    name: str, split: str, estimator: str | rc.AreaEstimator, folder: Path | None = None
) -> list[tuple[float, float, float, Case]]:
    """Return relative error, stated relative uncertainty, that of the true value, and the case."""
    rows = []
    for solution, true, std, case in cases(name, split, folder):
        area = solution.area(estimator)
        rows.append((area.value / true - 1.0, area.uncertainty / true, std / true, case))
    return rows


def report(
    names: Sequence[str], split: str, estimator: str | rc.AreaEstimator, *, groups: bool = False, worst: int = 0,
    folder: Path | None = None,
) -> dict[str, dict[str, float]]:  # fmt: skip
    """Print the table and return its rows by class."""
    print(f"{split}, {estimator}\n{HEADER}")
    table = {}
    for name in names:
        rows = estimate(name, split, estimator, folder)
        table[name] = print_rows(name, rows, groups=groups, worst=worst)
    held = statistics.median(row["within 2"] for row in table.values())
    print(
        f"classes below 93 % within two: {[k for k, row in table.items() if row['within 2'] < 0.93]}, median {held:.2f}"
    )
    print(f"classes with a ratio above 2.5: {[k for k, row in table.items() if row['ratio'] > 2.5]}")
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    every = (*CLASSES, *LOST, *UNKIND)
    parser.add_argument("--classes", default="all", help=f"all, unkind, or names or beginnings of: {', '.join(every)}")
    parser.add_argument("--split", default="tuned", choices=SPLITS)
    parser.add_argument("--estimator", default="blend")
    parser.add_argument("--cache", type=Path, help="folder of the solutions (or the variable AREA_CLASSES_CACHE)")
    parser.add_argument("--groups", action="store_true", help="a row for each resolution, too")
    parser.add_argument(
        "--worst", type=int, default=0, help="print so many cases of the largest error over uncertainty"
    )
    parser.add_argument("--references", action="store_true", help="compute the true values that are missing")
    options = parser.parse_args(arguments)
    wanted = tuple(options.classes.split(","))
    groups = {"all": list(CLASSES), "unkind": list(UNKIND)}
    names = groups.get(options.classes) or [name for name in every if name.startswith(wanted)]
    if options.references:
        find_references(names)
        return
    report(names, options.split, options.estimator, groups=options.groups, worst=options.worst, folder=options.cache)


if __name__ == "__main__":
    main()
