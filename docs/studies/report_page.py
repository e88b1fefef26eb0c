"""The picture of a report, docs/figures/report_page.png: the top of its page, by Debian's chromium.

python docs/studies/report_page.py
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

import roughcontact as rc

FIGURES = Path(__file__).parent.parent / "figures"
# Pixels of the window.
WIDTH, HEIGHT = 1000, 1330


def main(folder: Path = FIGURES) -> None:
    ring = rc.examples.ground_ring().detrend(2)
    solution = rc.ContactProblem(rc.Body(ring, rc.Elastic(210e9, 0.3))).solve(pressure=50e6)
    with tempfile.TemporaryDirectory() as place:
        page = Path(place) / "report.html"
        solution.to_html(page)
        options = [
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            f"--user-data-dir={place}/profile",
        ]
        picture = f"--screenshot={(folder / 'report_page.png').resolve()}"
        subprocess.run(["chromium", *options, f"--window-size={WIDTH},{HEIGHT}", picture, page.as_uri()], check=True)


if __name__ == "__main__":
    main()
