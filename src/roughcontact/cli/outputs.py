"""Files that a solve writes: each in the format that the ending of its name says."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import roughcontact as rc
from roughcontact import checks
from roughcontact.archive import replacing
from roughcontact.panel.theme import require_matplotlib
from roughcontact.units.text import fit

PICTURES = frozenset({".png", ".svg", ".pdf"})


def plan_outputs(given: Sequence[str], report: str | None, maps: Sequence[Path]) -> list[Path]:
    """Return the files to be written; a name without an ending is that of a folder, which is made.

    Raises
    ------
    InputError
        If a folder is missing, no writer knows an ending, or a height map would be overwritten.
    MissingPackage
        If a picture is asked for without matplotlib.
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
    files += [] if report is None else [checks.path(report, "The report")]
    for path in files:
        if not path.parent.is_dir():
            raise rc.InputError(f"There is no folder {str(path.parent)!r} to write {path.name!r} into.")
        if path.exists() and any(known.exists() and path.samefile(known) for known in maps):
            raise rc.InputError(f"The output {str(path)!r} is a height map that is read: give another name.")
        if path.suffix in PICTURES:
            require_matplotlib()
    return files


def plan_picture(text: str, others: Sequence[str] = ()) -> Path:
    """Return the file of a picture; `InputError` for another ending, of which `others` would be possible."""
    path = checks.path(text, "The output")
    if path.suffix not in PICTURES:
        raise rc.InputError.about("The output", text, f"a file that ends in {', '.join((*others, *sorted(PICTURES)))}")
    require_matplotlib()
    return path


def write_outputs(files: Sequence[Path], subject: Any, solutions: Sequence[rc.ContactSolution]) -> str:
    """Write a solution, or those of a sweep with their numbers, and a picture of the subject; say what was written."""
    written = []
    for path in files:
        if path.suffix in PICTURES:
            save_picture(subject.plot(), path)
            written.append(path)
            continue
        for number, solution in enumerate(solutions, 1):
            target = path if len(solutions) == 1 else path.with_stem(f"{path.stem}-{number}")
            solution.save(target)
            written.append(target)
    return fit(f"\nWritten: {', '.join(map(str, written))}") if written else ""


def save_picture(drawn: Any, path: Path) -> None:
    """Write the figure of some axes, or a figure, completely or not at all, and let pyplot forget it."""
    from matplotlib import pyplot

    content = io.BytesIO()
    drawn.figure.savefig(content, format=path.suffix.removeprefix("."))
    pyplot.close(drawn.figure)
    with replacing(path) as partial:
        partial.write_bytes(content.getvalue())
