"""Height maps that the package makes itself: small, and the same on every machine."""

from __future__ import annotations

from roughcontact._surfaces import HeightMap, SelfAffineSurface
from roughcontact.errors.door import guarded
from roughcontact.grid import Grid


@guarded
def ground_ring() -> HeightMap:
    """Return a map of a ground ring: rough, with a lay along y."""
    surface = SelfAffineSurface(hurst=0.8, rms_height=0.1e-6, shortest=4e-6, longest=256e-6, rolloff=64e-6, seed=1)
    grid = Grid((128, 128), 256e-6)
    return HeightMap(surface.heights(grid), size=grid.size)
