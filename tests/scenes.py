"""Contacts and studies that several test modules share."""

from __future__ import annotations

import attrs
import pytest

import roughcontact as rc

STEEL = rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9)
GRID = rc.Grid((48, 48), 1e-4)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=8e-6, seed=5)


def make_problem(surface=ROUGH, material=STEEL, **parts):
    return rc.ContactProblem(rc.Body(surface, material), grid=GRID, **parts)


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
    }
    return rc.Study(**{**parts, **changes})


def without_seconds(records):
    return [attrs.evolve(record, seconds=0.0) for record in records]


def list_unfinished(folder):
    return sorted(path.name for path in folder.rglob("*.partial"))


def rather_slow(cases, ordinary):
    """Return the cases of a test; the ordinary run tries only some of them."""
    return [case if case in ordinary else pytest.param(case, marks=pytest.mark.slow) for case in cases]
