"""The report of a solution: one self-contained page."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Any, final

import attrs

from roughcontact._solution import SolutionWriter
from roughcontact.archive import replacing


@final
@attrs.frozen
class HtmlWriter(SolutionWriter):
    """A report in HTML that opens without a network."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Html."""
        return frozenset({".html"})

    def write(self, solution: Any, path: Path) -> None:
        """Write the page."""
        with replacing(path) as partial:
            partial.write_text(self.text(solution), encoding="utf-8")

    def text(self, solution: Any) -> str:
        """Return the page."""
        return f"<!doctype html><meta charset=utf-8><title>Contact</title><pre>{html.escape(str(solution))}</pre>\n"
