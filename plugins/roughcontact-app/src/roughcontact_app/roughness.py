"""The roughness of a map for the page, when it is asked for: numbers of ISO 25178-2, spectrum and bearing curve."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import attrs
from roughcontact import Grid, HeightMap
from roughcontact.errors import RoughContactError
from roughcontact.faces import write_column
from roughcontact.reference import texture

from roughcontact_app.outputs import draw
from roughcontact_app.scene import ShownSurface
from roughcontact_app.words import end_sentence, in_words_of_page

_PANELS = ("spectrum", "bearing-curve")


def describe_roughness(shown: ShownSurface, grid: Grid, folder: Path, dark: bool) -> dict[str, Any]:
    """Return the numbers and the pictures, in a folder, of a map as it was read or of a surface on a grid."""
    source = shown.source
    own = grid
    periodic = False
    basis = "measured on these cells"
    if isinstance(source, HeightMap):
        own = source.grid
        periodic = source.periodic
        basis = "measured on the map as it was read, less its form"
    rows: list[list[str]] = []
    notes = []
    pictures = []
    try:
        found = texture(source.heights(own), own, periodic=periodic)
        meanings = dict(line[:37].split(None, 1) for line in str(found).split("\n"))
        numbers = attrs.asdict(found, recurse=False)
        rows = [[name, meanings[name].strip(), write_column([one])[0]] for name, one in numbers.items()]
        notes = [f"{name}: {text}" for name, one in numbers.items() for text in one.warnings]
    except RoughContactError as error:
        notes.append(in_words_of_page(error))
    folder.mkdir(exist_ok=True)
    for panel in _PANELS:
        path = folder / f"{panel}.png"
        try:
            draw(partial(source.plot, own, panel, dark=dark), path)
            pictures.append({"panel": panel, "picture": path.name})
        except RoughContactError as error:
            notes.append(in_words_of_page(error))
    return {"rows": rows, "pictures": pictures, "notes": [end_sentence(text) for text in notes], "basis": basis}
