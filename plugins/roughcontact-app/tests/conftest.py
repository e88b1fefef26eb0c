from __future__ import annotations

import numpy as np
import pytest
import roughcontact as rc


@pytest.fixture(scope="session")
def exported_map(tmp_path_factory):
    """A map of 400 x 300 points, 2 % non-measured, and its files in µm: a row for each x, and one for each y."""
    grid = rc.Grid((400, 300), (200e-6, 150e-6))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=0.5e-6, shortest=6e-6, longest=60e-6, seed=3)
    micrometres = np.round(1e6 * surface.heights(grid), 4)
    lost = np.random.default_rng(5).random(grid.shape) < 0.02
    texts = np.where(lost, "", np.char.mod("%.4f", micrometres))
    folder = tmp_path_factory.mktemp("exported")
    for name, rows in (("x", texts), ("y", texts.T)):
        (folder / f"{name}.csv").write_text("".join(f"{';'.join(row)}\n" for row in rows), encoding="utf-8")
    heights = np.where(lost, 0.0, 1e-6 * micrometres)
    return rc.HeightMap(heights, grid.size, non_measured=lost), folder / "x.csv", folder / "y.csv"
