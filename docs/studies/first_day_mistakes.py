"""The table of first-day mistakes in docs/use/limits.md: scenes, and what is said of each.

Run ``python docs/studies/first_day_mistakes.py`` to write the table; ``tests/pages/test_mistakes.py`` compares it.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
import tifffile

import roughcontact as rc
from roughcontact.__main__ import main as run_command
from roughcontact.errors import Sentence

PAGE = Path(__file__).parent.parent / "use" / "limits.md"
HEAD = "| the mistake | what is said |\n|---|---|\n"
GRID = rc.Grid(shape=(64, 64), size=(64e-6, 64e-6))
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=8e-6, longest=32e-6, seed=0)
STEEL = rc.Elastic(young=210e9, poisson=0.3)


@attrs.frozen
class Mistake:
    """A mistake, the scene in Python, the arguments of ``roughcontact solve``, and whether it is on the page.

    {} is the folder of the maps.
    """

    name: str
    solve: Callable[[Path], rc.ContactSolution]
    command: str = ""
    on_page: bool = True


def write_maps(folder: Path) -> None:
    """Write the height maps of the scenes into a folder."""
    heights = ROUGH.heights(GRID)
    x, y = np.meshgrid(*(np.arange(64) * 1e-6,) * 2, indexing="ij")
    np.savez(folder / "rough.npz", heights=heights, size=GRID.size)
    np.savez(folder / "tilted.npz", heights=heights + 0.1 * y, size=GRID.size)
    np.save(folder / "micrometres.npy", 1e6 * heights)
    np.save(folder / "oblong.npy", heights[:, :48])
    np.savetxt(folder / "points.txt", 1e6 * np.stack((x, y, heights), axis=-1).reshape(-1, 3))
    np.savetxt(folder / "decimal.csv", 1e6 * heights, delimiter=";", header="heights in um", comments="")
    text = (folder / "decimal.csv").read_text(encoding="utf-8")
    (folder / "decimal.csv").write_text(text.replace(".", ","), encoding="utf-8")
    (folder / "trailing.csv").write_text(
        "".join(",".join(f"{value:.7e}" for value in row) + ",\n" for row in heights), encoding="utf-8"
    )
    np.savetxt(folder / "whole.csv", 1e9 * (heights - heights.min())[:2].T, fmt="%.0f", delimiter=",")
    grey = np.round(255 * (heights - heights.min()) / np.ptp(heights)).astype(np.uint8)
    tifffile.imwrite(folder / "grey.tif", grey)
    noise = 1e-7 * np.random.default_rng(0).standard_normal(GRID.shape)
    np.savez(folder / "noise.npz", heights=noise, size=GRID.size)


def solve(surface: rc.Surface, material: rc.Material = STEEL, grid: rc.Grid | None = GRID, **options: object):
    """Return the solution on a rigid flat, converged or not; 10 MPa on a periodic boundary unless options differ."""
    load = {name: options.pop(name) for name in ("pressure", "force") if name in options} or {"pressure": 10e6}
    problem = rc.ContactProblem(rc.Body(surface, material), grid=grid, **{"boundary": "periodic", **options})
    return problem.solve(**load, throw=False)


def solve_map(
    file: str, size: float | None = None, unit: float | None = None, **options: object
) -> Callable[[Path], rc.ContactSolution]:
    """Return a function of the folder that solves one of its maps."""
    return lambda folder: solve(
        rc.read_surface(folder / file, size=size, unit=unit), grid=None, boundary="free", **options
    )


MISTAKES = [
    Mistake(
        "The map is tilted.",
        solve_map("tilted.npz"),
        "{}/tilted.npz --pressure 10MPa --young 210GPa",
    ),
    Mistake(
        "The map is tilted, and taken for periodic.",
        lambda folder: solve(rc.read_surface(folder / "tilted.npz"), grid=None),
        "{}/tilted.npz --boundary periodic --pressure 10MPa --young 210GPa",
    ),
    Mistake(
        "A text file lists points x y z in µm.",
        solve_map("points.txt"),
        "{}/points.txt --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "A CSV file in µm has a title, semicolons and decimal commas, and `unit=1e-6` is given.",
        solve_map("decimal.csv", 64e-6, unit=1e-6),
        "{}/decimal.csv --size 64um --unit 1um --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "Each row of a CSV file ends with a comma.",
        solve_map("trailing.csv", 64e-6),
        "{}/trailing.csv --size 64um --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "A comma may separate two numbers, or be decimal.",
        solve_map("whole.csv", 64e-6),
        "{}/whole.csv --size 64um --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "A TIFF file is read as it is.",
        solve_map("grey.tif"),
        "{}/grey.tif --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "A TIFF file is given a size, but no unit of height.",
        solve_map("grey.tif", 64e-6),
        "{}/grey.tif --size 64um --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "Heights are in µm, and `unit=1e-6` is forgotten.",
        solve_map("micrometres.npy", 64e-6),
        "{}/micrometres.npy --size 64um --pressure 10MPa --young 210GPa",
    ),
    Mistake(
        "One size is given for a map of 64 x 48 points.",
        solve_map("oblong.npy", 64e-6),
        "{}/oblong.npy --size 64um --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "`rc.Elastic(210, 0.3)`: GPa taken for Pa.",
        lambda _: solve(ROUGH, rc.Elastic(210, 0.3)),
        "{}/rough.npz --boundary periodic --pressure 10MPa --young 210Pa",
    ),
    Mistake(
        "`rc.Elastic(210e3, 0.3)`: MPa taken for Pa.",
        lambda _: solve(ROUGH, rc.Elastic(210e3, 0.3)),
        "{}/rough.npz --boundary periodic --pressure 10MPa --young 210kPa",
        on_page=False,
    ),
    Mistake(
        "All lengths are in µm.",
        lambda _: solve(rc.WavySurface(amplitude=0.5, wavelength=12.5), grid=rc.Grid((256, 256), 250), pressure=100e6),
        on_page=False,
    ),
    Mistake(
        "All lengths are in mm: a map of 1 mm, `size=1.0`.",
        lambda _: solve(rc.HeightMap(ROUGH.heights(GRID) / 64e-6, size=1.0, periodic=True), grid=None),
        on_page=False,
    ),
    Mistake(
        "`pressure=100`: MPa taken for Pa.",
        lambda _: solve(ROUGH, pressure=100),
        "{}/rough.npz --boundary periodic --pressure 100Pa --young 210GPa",
    ),
    Mistake(
        "The contact of a ball is cut by the border.",
        lambda _: solve(rc.SphereSurface(1e-3), boundary="free", force=17.4),
    ),
    Mistake(
        "The map is noise from point to point.",
        solve_map("noise.npz"),
        "{}/noise.npz --pressure 10MPa --young 210GPa",
        on_page=False,
    ),
    Mistake(
        "The grid is too coarse for the wave.",
        lambda _: solve(rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6), grid=rc.Grid((64, 64), 250e-6)),
        on_page=False,
    ),
    Mistake(
        "The material is elastic, and the pressure beyond its strength.",
        lambda _: solve(attrs.evolve(ROUGH, rms_slope=0.4), pressure=2e9),
    ),
    Mistake(
        "The surface is too steep for a half-space.",
        lambda _: solve(
            attrs.evolve(ROUGH, rms_slope=1.0), rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9), pressure=500e6
        ),
    ),
    Mistake(
        "The counterbody has no material.",
        lambda _: solve(ROUGH),
        "{}/rough.npz {}/rough.npz --boundary periodic --pressure 10MPa --young 210GPa",
    ),
]


def list_sentences(mistake: Mistake, folder: Path) -> tuple[str, ...]:
    """Return what is said of a scene: its refusal, its warnings, or the line that states the materials."""
    try:
        solution = mistake.solve(folder)
    except rc.InputError as refusal:
        return (Sentence(refusal.marked),)
    stated = next(line for line in str(solution).splitlines() if "modulus E*" in line)
    return solution.warnings or (" ".join(stated.split()),)


def run(mistake: Mistake, folder: Path) -> tuple[int, str]:
    """Return the exit status of the command, and what it prints, in one line."""
    printed = io.StringIO()
    arguments = mistake.command.format(*[folder] * mistake.command.count("{}")).split()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        status = run_command(["solve", *arguments])
    return status, " ".join(printed.getvalue().split())


def write_row(mistake: Mistake, sentences: tuple[str, ...]) -> str:
    """Return a row of the table, with the first of its warnings."""
    said = sentences[0].replace("|", "\\|")
    return f"| {mistake.name} | {said} |"


def make_table(folder: Path) -> str:
    """Return the table, from maps in a folder."""
    write_maps(folder)
    rows = [write_row(mistake, list_sentences(mistake, folder)) for mistake in MISTAKES if mistake.on_page]
    return HEAD + "\n".join(rows) + "\n"


def main() -> None:
    """Write the table into the page."""
    with tempfile.TemporaryDirectory() as folder:
        table = make_table(Path(folder))
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(HEAD)
    after = rest[rest.index("\n\n") + 1 :]
    PAGE.write_text(before + table + after, encoding="utf-8")


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    sys.exit(main())
