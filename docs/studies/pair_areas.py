"""The paper's ball on a ring, for its unpublished maps a synthetic pair: the areas of docs/trust/paper.md.

python docs/studies/pair_areas.py

Needs plugins/roughcontact-paper. Three minutes, and two more for running in, unless `roughcontact paper --pairs --full`
was run in the same folder before; that command also makes the figures.
"""

from __future__ import annotations

from pathlib import Path

from doc_tables import DocTable, pick, write_tables

from roughcontact_paper import published
from roughcontact_paper.pair_tables import FORCES, STATES, PairCase, fit_counts, solve_pair
from roughcontact_paper.synthetic_pair import new_pair, run_in_pair

RESULTS = Path("paper-results")


def make_row(cases: list[PairCase]) -> list[str]:
    last, extrapolated = cases[-1], fit_counts(cases).value
    true = 1e12 * last.area.value
    printed = published.PAIR_AREA.get((last.state, last.force))
    return [
        f"{last.state.split()[0]}, {last.force:g} N",
        "-" if printed is None else f"{printed[0]:.0f}, {printed[1]:.0f}",
        *(f"{1e12 * last.counted:.0f}", f"{100 * (1e12 * last.counted / true - 1):+.1f} %"),
        *(f"{extrapolated:.0f}", f"{100 * (extrapolated / true - 1):+.1f} %"),
        *(f"{true:.0f} ± {1e12 * last.area.uncertainty:.0f}", f"{1e12 * last.saturated.value:.0f}"),
    ]


def make_rows(grids: tuple[int, ...] = published.GRIDS) -> list[list[str]]:
    heading = ["pair", "printed: counted, eq. 28", "counted", "error", "eq. 28", "error", "sub-grid", "saturated"]
    before = new_pair(grids[-1])
    RESULTS.mkdir(exist_ok=True)
    pairs = dict(zip(STATES, (before, run_in_pair(before, RESULTS / f"run-in-{grids[-1]}.npz")), strict=True))
    return [
        heading,
        *(
            make_row([solve_pair(state, pairs[state], force, cells) for cells in grids])
            for state in STATES
            for force in FORCES
        ),
    ]


# The columns of the page.
SHOWN = ("pair", "printed: counted, eq. 28", "counted", "error", "sub-grid", "saturated")
LINES = ("before, 2.5 N", "before, 10 N", "after, 2.5 N", "after, 10 N")
TABLES = {"pair-areas": DocTable(make_rows, seconds=300, shown=pick(SHOWN, LINES))}

if __name__ == "__main__":
    write_tables(TABLES)
