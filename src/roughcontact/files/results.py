"""Solutions as npz files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from roughcontact.errors import InputError
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

    Raises
    ------
    InputError
        If the folder does not exist.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"There is no folder {str(target.parent)!r} to write {target.name} into.")
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    area, saturated = solution.area(), solution.saturated_area()
    try:
        with partial.open("wb") as file:
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
                area=area.value,
                area_uncertainty=area.uncertainty,
                saturated_area=saturated.value,
                saturated_area_uncertainty=saturated.uncertainty,
                status=solution.status.name,
                iterations=solution.iterations,
                convolutions=solution.convolutions,
                seconds=solution.seconds,
                complementarity=solution.residuals.complementarity,
                penetration=solution.residuals.penetration,
                load_error=solution.residuals.load,
            )
        partial.replace(target)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
