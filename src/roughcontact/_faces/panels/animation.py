"""A path as one moving picture: the pressure of its states, one after the other."""

from __future__ import annotations

import io
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact._base.archive import replacing
from roughcontact._faces.panels.figures import add_title, draw_png, fill_alone, title_of_solution, wrap_title
from roughcontact._faces.panels.solution import draw_pressure
from roughcontact._faces.panels.theme import apply_theme, require_matplotlib
from roughcontact._solve.problem import Path as StatePath
from roughcontact.errors import InputError

ANIMATION = ".gif"
# Most colours of the format.
_COLORS = 256
# How long a state is shown, and the last one, ms.
_SHOWN = 600
_SHOWN_LAST = 2400


def write_animation(path: StatePath, file: Path, dark: bool = False) -> None:
    """Write a picture of each state into one file, completely or not at all; see `Path.animate`."""
    if file.suffix != ANIMATION:
        raise InputError.about("The animation", str(file), f"a file that ends in {ANIMATION}")
    require_matplotlib()
    # It comes with matplotlib.
    from PIL import Image

    drawn = [Image.open(io.BytesIO(one)).convert("RGB") for one in _draw_states(path, dark)]
    # The colour bar is on each: the colours of one serve all.
    colors = drawn[0].quantize(_COLORS)
    frames = [one.quantize(palette=colors, dither=Image.Dither.NONE) for one in drawn]
    shown = [*(len(frames) - 1) * [_SHOWN], _SHOWN_LAST]
    content = io.BytesIO()
    frames[0].save(content, format="gif", save_all=True, append_images=frames[1:], duration=shown, loop=0)
    with replacing(file) as unfinished:
        unfinished.write_bytes(content.getvalue())


def _draw_states(path: StatePath, dark: bool) -> list[bytes]:
    """Return a picture of each state, all of one size, whose colours mean the same pressures."""
    from roughcontact._faces.panels.figure_view import FigureView

    highest = max(float(state.contact_pressure.max()) for state in path)
    is_saturated = any(state.saturated.any() for state in path)
    _, names = path.label_states()
    figures = []
    titles = []
    with apply_theme(dark):
        for state, name in zip(path, names, strict=True):
            figure = FigureView()
            draw = partial(draw_pressure, state, highest=highest, names_saturated=is_saturated)
            fill_alone(figure, "solution", state, draw)
            figures.append(figure)
            titles.append(wrap_title(figure, f"{name[0].upper()}{name[1:]}\n{title_of_solution(state)}"))
        count = max(map(len, titles))
        return [
            _draw(figure, [*title, *(count - len(title)) * [""]]) for figure, title in zip(figures, titles, strict=True)
        ]


def _draw(figure: Any, title: list[str]) -> bytes:
    add_title(figure, title)
    return draw_png(figure)
