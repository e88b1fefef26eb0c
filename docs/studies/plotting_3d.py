"""The view in three dimensions of docs/use/plotting.md; needs the extra `vtk`.

python docs/studies/plotting_3d.py
"""

from __future__ import annotations

import pyvista
from plotting import FIGURES, STEEL, SURFACE

import roughcontact as rc

if __name__ == "__main__":
    pyvista.OFF_SCREEN = True
    problem = rc.ContactProblem(rc.Body(SURFACE, STEEL), grid=rc.Grid((512, 512), 100e-6), boundary="periodic")
    view = problem.solve(pressure=400e6).plot_3d()
    view.camera.zoom(1.25)
    view.screenshot(FIGURES / "plotting_3d.png", window_size=(1200, 720))
