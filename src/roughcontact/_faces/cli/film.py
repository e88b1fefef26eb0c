"""``roughcontact film``: flow factors and asperity pressure of measured height maps over the separation."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path

import roughcontact as rc
from roughcontact._answers.laws import FilmLaw
from roughcontact._base import checks
from roughcontact._base.units import fit
from roughcontact._faces.cli import DOUBTFUL, Command
from roughcontact._faces.cli.answers import PICTURES, require_packages, require_place, write_csv
from roughcontact._faces.cli.options import add_interface, add_shape
from roughcontact._faces.cli.problem import problem_of
from roughcontact._faces.cli.progress import show_progress
from roughcontact._faces.panels.figures import save_figure

# Columns that a picture shows side by side, those of one quantity in the same axes, and the size of each, inches.
_DRAWN = {
    "pressure flow factors": ("phi_xx", "phi_yy"),
    "shear flow factors": ("phi_s_xx", "phi_s_yy"),
    "": ("asperity_pressure",),
}
_PANEL_SIZE = (4.4, 3.8)


class Film(Command):
    """Find flow factors, asperity pressure and contact area over the separation, for mixed lubrication and seals."""

    epilog = """
examples:
  roughcontact film map.npz --young 210GPa --separation 0.5..4 --csv
  roughcontact film map.npz --young 210GPa --separation 0.5..6 \\
      --mirror-borders -o film.csv --comsol film.txt --units mm
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_interface(parser, of_film=True)
        once = "do not find how much other places of the maps differ, from their quarters"
        parser.add_argument("--no-sampling", action="store_true", help=once)
        output = parser.add_argument_group("output")
        add_shape(output)
        output.add_argument("--comsol", metavar="FILE", help="all columns as an interpolation function of COMSOL")
        output.add_argument("--units", choices=("SI", "mm"), default="SI", help="units of that file (SI)")
        files = f"table or picture to write: {', '.join(_WRITERS)}; may be repeated"
        output.add_argument("-o", "--output", action="append", default=[], metavar="FILE", help=files)

    def run(self, options: argparse.Namespace) -> int:
        """Write the files and print the law; return 0, or 3 if it has warnings."""
        maps = [checks.path(name, "The map") for name in (options.surface, options.counterbody) if name is not None]
        writers = _plan_writers(options, maps)
        with show_progress("reading the maps", quiet=options.quiet):
            problem = problem_of(options)
        separations = [value for several in options.separation for value in several]
        with show_progress("solving", quiet=options.quiet):
            law = rc.film_law(problem, separations, sampling=not options.no_sampling)
        for write, path in writers:
            write(law, path)
        if options.json:
            print("\n".join(law.list_json()))
        elif options.csv:
            print(write_csv(law.table()))
        elif not options.quiet:
            print(fit(str(law)))
            if writers:
                print(fit(f"\nWritten: {', '.join(str(path) for _, path in writers)}"))
        return DOUBTFUL if law.warnings else 0


def _plan_writers(options: argparse.Namespace, maps: list[Path]) -> list[tuple[Callable[[FilmLaw, Path], None], Path]]:
    """Return what will be written, with its files; `InputError` before anything is solved."""
    planned: list[tuple[Callable[[FilmLaw, Path], None], Path]] = []
    for text in options.output:
        ending = Path(text).suffix
        if ending not in _WRITERS:
            raise rc.InputError.about("The output", text, f"a file that ends in {', '.join(_WRITERS)}")
        require_packages(ending)
        planned.append((_WRITERS[ending], checks.path(text, "The file")))
    if options.comsol is not None:
        planned.append((partial(FilmLaw.to_comsol, units=options.units), checks.path(options.comsol, "The file")))
    for _, path in planned:
        require_place(path, [path], maps)
    return planned


def _draw(law: FilmLaw, path: Path) -> None:
    """Draw flow factors and pressure side by side."""
    from matplotlib.figure import Figure

    drawn = {title: [name for name in names if name in law.columns] for title, names in _DRAWN.items()}
    drawn = {title: names for title, names in drawn.items() if names}
    width, height = _PANEL_SIZE
    figure = Figure(figsize=(width * len(drawn), height), layout="constrained")
    for (title, names), axes in zip(drawn.items(), figure.subplots(1, len(drawn), squeeze=False)[0], strict=True):
        for name in names:
            law.plot(name, axes)
        if title:
            axes.set_ylabel(title)
    save_figure(figure, path)


_WRITERS: dict[str, Callable[[FilmLaw, Path], None]] = {
    ".csv": FilmLaw.to_csv,
    ".html": FilmLaw.to_html,
    ".json": FilmLaw.to_json,
    **dict.fromkeys(sorted(PICTURES), _draw),
}
