"""Files that a solve writes: each in the format that the ending of its name says."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.units.text import fit
from roughcontact._faces.panels.figures import save_figure
from roughcontact._faces.panels.theme import require_matplotlib
from roughcontact._solve.solution import require_netcdf

PICTURES = frozenset({".png", ".svg", ".pdf"})


def plan_outputs(given: Sequence[str], report: str | None, maps: Sequence[Path], count: int = 1) -> list[Path]:
    """Return the files to be written; a name without an ending is that of a folder, which is made.

    `count` solutions get their numbers when they are written.

    Raises
    ------
    InputError
        If a folder is missing, no writer knows an ending, or a height map would be overwritten.
    MissingPackage
        If a picture, a report or netCDF is asked for without its packages.
    """
    known = {suffix for name in rc.writers for suffix in rc.writers.create(name).suffixes} | PICTURES
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
    if report is not None:
        files.append(checks.path(report, "The report"))
        if files[-1].suffix != ".html":
            raise rc.InputError.about("The report", report, "a file that ends in .html")
    for path in files:
        if not path.parent.is_dir():
            raise rc.InputError(f"There is no folder {str(path.parent)!r} to write {path.name!r} into.")
        for target in (path, *_numbered(path, count)):
            if target.exists() and any(one.exists() and target.samefile(one) for one in maps):
                raise rc.InputError(f"The output {str(target)!r} is a height map that is read: give another name.")
        # A report has figures.
        if path.suffix in {*PICTURES, ".html"}:
            require_matplotlib()
        elif path.suffix == ".nc":
            require_netcdf()
    return files


def plan_picture(text: str, others: Sequence[str] = ()) -> Path:
    """Return the file of a picture; `InputError` for another ending, of which `others` would be possible."""
    path = checks.path(text, "The output")
    if path.suffix not in PICTURES:
        raise rc.InputError.about("The output", text, f"a file that ends in {', '.join((*others, *sorted(PICTURES)))}")
    require_matplotlib()
    return path


def write_outputs(files: Sequence[Path], subject: Any, solutions: Sequence[rc.ContactSolution]) -> str:
    """Write a solution, or those of a sweep with their numbers, a picture and a report; say what was written."""
    written = []
    for path in files:
        if path.suffix in PICTURES or path.suffix == ".html":
            if path.suffix == ".html":
                subject.to_html(path)
            else:
                save_figure(subject.plot(), path)
            written.append(path)
            continue
        for target, solution in zip(_numbered(path, len(solutions)), solutions, strict=True):
            solution.save(target)
            written.append(target)
    return fit(f"\nWritten: {', '.join(map(str, written))}") if written else ""


def _numbered(path: Path, count: int) -> list[Path]:
    return [path] if count == 1 else [path.with_stem(f"{path.stem}-{number}") for number in range(1, count + 1)]
