"""Solutions whose fields are closed forms at the cell centres: what is asked of them has a closed form too."""

from __future__ import annotations

import math

import numpy as np

import roughcontact as rc
from roughcontact.results import Residuals

MODULUS = 2e9


def with_fields(grid, pressure, gap, *, initial_gap=None, approach=0.0, boundary="free", limit=math.inf, **options):
    """Return a solution with this pressure, Pa, and gap, m; the displacement is what the other fields leave."""
    pressure, gap = (np.broadcast_to(np.asarray(field, dtype=float), grid.shape).copy() for field in (pressure, gap))
    initial_gap = gap if initial_gap is None else np.broadcast_to(initial_gap, grid.shape).copy()
    plain = {
        "modulus": MODULUS,
        "status": rc.Status.CONVERGED,
        "iterations": 1,
        "convolutions": 1,
        "seconds": 0.0,
        "residuals": Residuals(0.0, 0.0, 0.0, 1.0),
        "errors": (),
    }
    return rc.ContactSolution(
        grid=grid,
        boundary=rc.Boundary(boundary),
        pressure_limit=limit,
        pressure=pressure,
        displacement=gap - initial_gap + approach,
        initial_gap=initial_gap,
        approach=approach,
        **plain | options,
    )


def distances(grid, centre, boundary="free"):
    """Return x and y from a centre, m, to the nearest image on a periodic boundary, shape (nx, ny) each."""
    x, y = np.broadcast_arrays(grid.x - centre[0], grid.y - centre[1])
    if boundary != "free":
        x, y = (step - side * np.round(step / side) for step, side in zip((x, y), grid.size, strict=True))
    return x, y


def ball(grid, contact_radius, radius, centre=(0.0, 0.0), boundary="free", **options):
    """Return Hertz's contact of a ball: Johnson, Contact Mechanics (1985), section 3.4 and 4.2."""
    r, a = np.hypot(*distances(grid, centre, boundary)), contact_radius
    inside = r < a
    pressure = 2.0 * MODULUS * a / (np.pi * radius) * np.sqrt(np.where(inside, 1.0 - (r / a) ** 2, 0.0))
    approach, beyond = a**2 / radius, np.maximum(r, a)
    displaced = ((2.0 * a**2 - beyond**2) * np.arcsin(a / beyond) + a * np.sqrt(beyond**2 - a**2)) / (np.pi * radius)
    gap = np.where(inside, 0.0, r**2 / (2.0 * radius) + displaced - approach)
    return with_fields(
        grid, pressure, gap, initial_gap=r**2 / (2.0 * radius), approach=approach, boundary=boundary, **options
    )


def edge(grid, depth, strength=1e8, **options):
    """Return a contact whose edge lies where the depth, m, vanishes, with the pressure strength * sqrt(depth) inside.

    The gap outside is that of the same stress intensity: Johnson, section 5.1.
    """
    inside, outside = np.maximum(depth, 0.0), np.maximum(-depth, 0.0)
    return with_fields(grid, strength * np.sqrt(inside), 4.0 * strength / (3.0 * MODULUS) * outside**1.5, **options)
