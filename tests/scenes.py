"""Contacts and studies that several test modules share."""

from __future__ import annotations

import dataclasses
import itertools

import attrs
import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9)
GRID = rc.Grid((48, 48), 1e-4)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=8e-6, seed=5)


# A contact that is solved in milliseconds.
SMALL_GRID = rc.Grid((24, 24), 1e-4)
SMALL_ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=16e-6, seed=5)
ELASTIC = rc.Elastic(200e9, 0.3)
_SURFACE_FIELDS = {field.name for field in attrs.fields(rc.SelfAffineSurface)}


def make_problem(surface=ROUGH, material=STEEL, *, grid=GRID, **parts):
    """Return the contact of a surface with a rigid flat."""
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, **parts)


def small_problem(surface=SMALL_ROUGH, **parts):
    return make_problem(surface, ELASTIC, grid=SMALL_GRID, **parts)


def make_rough(cells, size, material=ELASTIC, *, boundary="periodic", **fields):
    """Return the contact of a self-affine surface, of a Hurst exponent of 0.8, with a rigid flat.

    `cells` and `size` are of the grid, one number or one for x and one for y; `fields` are those of the surface and the
    other parts of the problem.
    """
    grid = rc.Grid(np.broadcast_to(cells, 2), size)
    parts = {name: fields.pop(name) for name in fields.keys() - _SURFACE_FIELDS}
    return make_problem(
        rc.SelfAffineSurface(**{"hurst": 0.8} | fields), material, grid=grid, boundary=boundary, **parts
    )


def read_problem(name, boundary="periodic", **parts):
    """Return the contact of a steel body, whose surface is a file, with a rigid flat."""
    return make_problem(rc.read_surface(name), rc.Elastic(210e9, 0.3), grid=None, boundary=boundary, **parts)


def make_study(**changes):
    """Return a study of two problems, three loads and two seeds, unless other things are given."""
    parts = {
        "problems": {
            "periodic": make_problem(boundary="periodic"),
            "free": make_problem(rc.ParaboloidSurface(5e-3) + ROUGH),
        },
        "force": [0.1, 0.5, 1.0],
        "seeds": [0, 1],
        "areas": ["blend", "cell-count"],
        "fields": True,
    }
    return rc.Study(**{**parts, **changes})


def small_study(**changes):
    """Return a study of one small problem, two loads and three seeds, unless other things are given."""
    parts = {"problems": small_problem(), "force": [0.1, 0.3], "seeds": [0, 1, 2], "fields": True}
    return rc.Study(**{**parts, "areas": ["blend", "cell-count"], **changes})


def without_seconds(records):
    return [attrs.evolve(record, seconds=0.0) for record in records]


def list_unfinished(folder):
    return sorted(path.name for path in folder.rglob("*.partial"))


def rather_slow(cases, ordinary):
    """Return the cases of a test; the ordinary run tries only some of them."""
    return [case if case in ordinary else pytest.param(case, marks=pytest.mark.slow) for case in cases]


def each_once(axes):
    """Parametrise a test by all combinations, of which the ordinary run tries each value of each argument.

    `axes` holds the values of an argument by its name, or those of several arguments by their names in one text.
    """
    lists = [list(values) for values in axes.values()]
    longest = max(map(len, lists))
    ordinary = {tuple(k % len(values) for values in lists) for k in range(longest)}
    cases = []
    for places in itertools.product(*(range(len(values)) for values in lists)):
        chosen = [values[k] for values, k in zip(lists, places, strict=True)]
        groups = [one if " " in names else (one,) for names, one in zip(axes, chosen, strict=True)]
        marks = () if places in ordinary else pytest.mark.slow
        cases.append(pytest.param(*itertools.chain(*groups), marks=marks))
    return pytest.mark.parametrize(" ".join(axes).split(), cases)


@attrs.frozen
class Doubled(rc.Surface):
    inner: rc.Surface

    def heights(self, grid):
        return 2 * self.inner.heights(grid)


@dataclasses.dataclass(frozen=True)
class DoubledData(rc.Surface):
    inner: rc.Surface

    def heights(self, grid):
        return 2 * self.inner.heights(grid)


class DoubledPlain(rc.Surface):
    def __init__(self, inner):
        self.inner = inner

    def heights(self, grid):
        return 2 * self.inner.heights(grid)

    def with_parts(self, parts):
        return DoubledPlain(*parts)


WRAPPERS = [Doubled, DoubledData, DoubledPlain]


def act_as_on_large_grids(patch):
    """Have the default solver do on small grids, which are fast, what it does on large ones.

    It starts on coarser grids, descends on lists of cells, and near full contact seeks the openings.
    """
    method = "roughcontact._solve.solvers.conjugate.field_descent.FieldDescent.serves"
    patch.setattr(method, staticmethod(lambda *_: False))
    patch.setattr("roughcontact._solve.solvers.grids._MIN_HALVED_CELLS", 0)
