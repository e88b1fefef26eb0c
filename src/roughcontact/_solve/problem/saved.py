"""Files of solutions and of paths, whichever of them it is; the problem of a solution."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import Any

from roughcontact._base import checks
from roughcontact._base.archive import HEADER, read_some
from roughcontact._solve.problem.cycle import AdhesionCycle
from roughcontact._solve.problem.frictional_path import FrictionalPath
from roughcontact._solve.problem.load_path import LoadPath
from roughcontact._solve.problem.path import Path as StatePath
from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.problem.sweep import Sweep
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

_PATHS = (Sweep, AdhesionCycle, FrictionalPath, LoadPath)


@guarded
def load(path: str | os.PathLike[str], *, verify: bool = True) -> ContactSolution | StatePath:
    """Return what `save` wrote: a solution, a sweep, a cycle or a path with friction.

    Parameters
    ----------
    path
        The file, ``.npz`` or ``.nc``.
    verify
        Whether to build the problem and recompute the certificate; see `ContactSolution.load`.

    Raises
    ------
    InputError
        If there is no such file, it holds nothing of this kind, is damaged, or contradicts itself.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).solve(force=1.0)
    >>> with TemporaryDirectory() as folder:
    ...     solution.save(Path(folder) / "contact.npz")
    ...     print(f"{rc.load(Path(folder) / 'contact.npz').force:.1f} N")
    1.0 N
    """
    verify = checks.flag(verify, "verify=")
    file = checks.path(path, "The file")
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.")
    kind = find_saved_kind(file)
    if kind is None:
        raise InputError(f"{file.name} holds no solution and no path: rc.read_surface reads height maps.")
    found: ContactSolution | StatePath = kind.load(file, verify=verify)
    return found


def find_saved_kind(path: Path) -> Any:
    """Return the class whose `load` reads a file; None for files that may be height maps."""
    if path.suffix == ".nc":
        return ContactSolution
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    # Readers of height maps say what is wrong.
    except (OSError, zipfile.BadZipFile):
        return None
    if "displacement.npy" in names:
        return ContactSolution
    if f"{HEADER}.npy" not in names:
        return None
    # States with friction had no name of a field in files, before they were solutions.
    kinds: dict[str, Any] = {one.kind: one for one in _PATHS} | {"frictional solution": ContactSolution}
    return kinds.get(str(read_some(path)[1].get("kind")))


def problem_of(solution: ContactSolution) -> ContactProblem:
    """Return the problem of a solution, with its prepared convolution; the problem of a file is built anew.

    `InputError` if the solution has no origin, or needs a class that is not registered.
    """
    if solution.origin is None:
        raise InputError("The solution does not say which problem it solves, so that nothing can be computed with it.")
    problem = solution.origin.scene
    if not isinstance(problem, ContactProblem):
        raise InputError(f"What was solved must be a ContactProblem, but is {problem!r}.")
    return problem
