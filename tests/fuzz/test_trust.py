"""The page of promises states the sizes of the random tests that hold them."""

from __future__ import annotations

from pathlib import Path

import pytest

from test_fuzz_calls import CALLS
from test_fuzz_commands import COMMANDS
from test_fuzz_files import FILES, MAPS
from test_fuzz_problems import PROBLEMS
from test_kills import KILLS

TEXT = (Path(__file__).parents[2] / "docs" / "trust" / "trust.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "figure",
    [
        f"{PROBLEMS:,} problems, 0 wrong",
        f"{CALLS:,} calls, {COMMANDS:,} command lines, 0 without",
        f"{FILES:,} files of solutions and studies and {MAPS:,} maps, 0 accepted",
        f"{sum(KILLS.values())} kills, 0 solutions lost",
    ],
)
def test_sizes_are_those_of_the_tests(figure):
    assert figure in TEXT
