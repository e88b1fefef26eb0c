"""Contacts and their answers on slabs, beside those of the gathered solution. Run by `mpiexec`, it writes a table."""

import json
import sys
from pathlib import Path

import numpy as np
import roughcontact as rc

from roughcontact_mpi import Processes, SlabArray, ending_all, solve

ESTIMATORS = ("blend", "level-set", "level-set-richardson", "hertz", "perimeter", "cell-count")
SIZE = 1e-4


def waves(shape, size, seed):
    """Return random waves, periodic, the shortest of which has a 24th of the shorter side."""
    sides = [np.fft.fftfreq(n, 1.0 / n) / length for n, length in zip(shape, size, strict=True)]
    q = min(size) * np.hypot(sides[0][:, np.newaxis], sides[1][: shape[1] // 2 + 1])
    height = np.where((q > 0.0) & (q <= 24.0), np.maximum(q, 4.0) ** -1.8, 0.0)
    phase = 2.0 * np.pi * np.random.default_rng(seed).random(q.shape)
    heights = np.fft.irfft2(height * np.exp(1j * phase), shape)
    return 1e-8 * heights / heights.std()


def ridges(shape, size, seed):
    """Return oblique waves of one direction."""
    x, y = (np.arange(n) / n for n in shape)
    phase = 2.0 * np.pi * (3.0 * x[:, np.newaxis] + 4.0 * y)
    return 1e-8 * (np.cos(phase) + 0.3 * np.cos(2.0 * phase + seed))


def strips(shape, size, seed):
    """Return waves along one axis."""
    x = np.arange(shape[seed]) / shape[seed]
    return np.ascontiguousarray(np.broadcast_to(1e-8 * np.cos(8.0 * np.pi * np.expand_dims(x, 1 - seed)), shape))


def punch(shape, size, seed):
    """Return a flat punch."""
    x, y = (np.arange(n) / n - 0.5 for n in shape)
    return np.where((np.abs(x[:, np.newaxis]) < 0.3) & (np.abs(y) < 0.2), 1e-8, 0.0)


def snake(shape, size, seed):
    """Return a plateau that winds through all slabs and around the border, with noise."""
    x, y = (np.arange(n) / n for n in shape)
    middle = 0.5 + 0.35 * np.sin(2.0 * np.pi * x[:, np.newaxis])
    return 1e-8 * (np.abs((y - middle + 0.5) % 1.0 - 0.5) < 0.1) + 0.1 * waves(shape, size, seed)


def corner(shape, size, seed):
    """Return a summit at the corner of a periodic domain."""
    x, y = ((np.arange(n) / n + 0.5) % 1.0 - 0.5 for n in shape)
    return -1e-7 * (x[:, np.newaxis] ** 2 + 2.0 * y**2)


def filled(shape, size, seed):
    """Return waves with points that were filled from their neighbours."""
    heights = waves(shape, size, seed)
    for i, j in np.random.default_rng(seed).integers(2, min(shape) - 2, (300, 2)):
        heights[i, j] = 0.25 * (heights[i - 1, j] + heights[i + 1, j] + heights[i, j - 1] + heights[i, j + 1])
    return heights


# Heights, shape, aspect of the domain, load, hardness: domains of 8 : 1, cells of 1 : 3, odd numbers of cells.
CONTACTS = {
    "rough": (waves, (144, 144), 1.0, {"pressure": 1e7}, None),
    "long": (waves, (256, 32), 8.0, {"pressure": 3e7}, None),
    "wide": (waves, (32, 256), 0.125, {"pressure": 3e7}, None),
    "odd": (waves, (75, 49), 1.5, {"pressure": 1e7}, None),
    "cells": (waves, (96, 96), 3.0, {"pressure": 1e7}, None),
    "heavy": (waves, (96, 96), 1.0, {"pressure": 6e7}, None),
    "hard": (waves, (96, 96), 1.0, {"pressure": 2e7}, 2e8),
    "light": (waves, (128, 96), 1.0, {"force": 1e-4}, None),
    "approach": (waves, (96, 80), 1.0, {"approach": 1e-8}, None),
    "low": (waves, (3, 40), 0.1, {"pressure": 1e7}, None),
    "ridges": (ridges, (120, 96), 1.0, {"pressure": 1e7}, None),
    "strips": (strips, (96, 64), 1.0, {"pressure": 1e7}, None),
    "punch": (punch, (96, 80), 1.0, {"pressure": 1e7}, None),
    "snake": (snake, (96, 96), 1.0, {"pressure": 5e6}, None),
    "corner": (corner, (128, 128), 1.0, {"force": 1e-3}, None),
    "filled": (filled, (96, 96), 1.0, {"pressure": 1e7}, None),
    "full": (waves, (48, 48), 1.0, {"pressure": 3e9}, None),
}
# The contacts that so many processes solve.
OF_COUNT = {
    1: ("rough", "filled"),
    2: tuple(CONTACTS),
    3: ("odd", "hard", "low", "ridges", "snake", "corner"),
}
BOUNDARIES = ("periodic", "free")
SEEDS = {name: int(name == "strips") or 3 + place for place, name in enumerate(CONTACTS)}


def make(name):
    """Return the heights of a contact, m, and its size, m."""
    shape_of, shape, aspect, _, _ = CONTACTS[name]
    size = (SIZE * aspect, SIZE)
    return shape_of(shape, size, SEEDS[name]), size


def material_of(name):
    """Return the material of a contact."""
    hardness = CONTACTS[name][4]
    return rc.Elastic(1e10, 0.3) if hardness is None else rc.ElasticPerfectlyPlastic(1e10, 0.3, hardness)


def list_numbers(solution):
    """Return the answers of a solution, on slabs or whole: value and uncertainty, and the numbers of the patches.

    All are judged by the model, as those on slabs are.
    """
    found = {}
    for name in ESTIMATORS:
        area = solution.area(name, uncertainty="model")
        found[name] = (area.value, area.uncertainty, area.perimeter)
    for name in ("peak-pressure", "stiffness"):
        estimate = solution.response(name, uncertainty="model")
        found[name] = (estimate.value, estimate.uncertainty)
    patches = solution.patches
    found["patches"] = (patches.cells.tolist(), patches.forces.tolist())
    found["areas of patches"] = solution.area(uncertainty="model").patches.tolist()
    return found


def main(folder):
    """Solve all contacts, and write the answers of the slabs, of the gathered solution, and its pressure."""
    processes = Processes()
    table = {}
    with ending_all(processes):
        for name in OF_COUNT[processes.count]:
            heights, size = make(name)
            own = processes.own_rows(heights.shape[0])
            for boundary in BOUNDARIES:
                slab = SlabArray.field(heights[own].copy(), processes, heights.shape[0])
                load = CONTACTS[name][3]
                solution = solve(slab, size, material_of(name), **load, boundary=boundary, tolerance=1e-10)
                found = list_numbers(solution)
                labels = solution.patches.labels.part
                whole = solution.gather()
                if processes.rank == 0:
                    table[f"{name} {boundary}"] = [found, list_numbers(whole)]
                    assert np.array_equal(labels, whole.patches.labels[own])
                    assert whole.status is solution.status
                    np.save(folder / f"{name}-{boundary}-{processes.count}.npy", whole.pressure)
                else:
                    assert whole is None
        if processes.rank == 0:
            (folder / f"answers-{processes.count}.json").write_text(json.dumps(table))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
