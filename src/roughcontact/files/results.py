"""Solutions as npz files."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np

from roughcontact.solution import ContactSolution


def write_solution(path: str | os.PathLike[str], solution: ContactSolution) -> None:
    """Write the fields and figures of a solution to an npz file, in SI units.

    The file appears whole or not at all.

    Parameters
    ----------
    path
        Where to; an existing file is replaced.
    solution
        What to write: the arrays pressure, gap, displacement and undeformed, shape (nx, ny), the
        size, and every figure of the summary under its own name.
    """
    target = Path(path)
    handle, name = tempfile.mkstemp(dir=target.parent, suffix=".partial")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(
                file,
                pressure=solution.pressure,
                gap=solution.gap,
                displacement=solution.displacement,
                undeformed=solution.undeformed,
                size=solution.grid.size,
                boundary=str(solution.boundary),
                modulus=solution.modulus,
                limit=solution.limit,
                force=solution.force,
                approach=solution.approach,
                area=solution.area().value,
                area_uncertainty=solution.area().uncertainty,
                status=solution.status.name,
                iterations=solution.iterations,
                convolutions=solution.convolutions,
                seconds=solution.seconds,
                complementarity=solution.residuals.complementarity,
                penetration=solution.residuals.penetration,
                load_error=solution.residuals.load,
            )
        Path(name).replace(target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
