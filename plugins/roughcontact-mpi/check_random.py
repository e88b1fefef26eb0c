"""Solve 500 random contacts by two and three processes and by one: `python check_random.py` prints how far they differ.

A contact that one process refuses must be refused by all others, in the same words.
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import roughcontact as rc

TESTS = Path(__file__).with_name("tests")
sys.path.insert(0, str(TESTS))

import mpi  # noqa: E402 - it lies beside the tests
from alone import solve_alone  # noqa: E402
from random_problems import make_problem  # noqa: E402

PROBLEMS = 500
COUNTS = (2, 3)
TOLERANCE = 1e-10


def make_cases(folder):
    """Write the problems into a folder, and return them."""
    cases = {}
    for seed in range(PROBLEMS):
        heights, case = make_problem(seed)
        np.save(folder / f"{seed}.npy", heights)
        cases[str(seed)] = {"map": str(seed), "counts": list(COUNTS), "tolerance": TOLERANCE, **case}
    (folder / "cases.json").write_text(json.dumps(cases))
    return cases


def compare(folder, name, case, count):
    """Return what differs between several processes and one: the refusal, or pressure, cells and approach."""
    numbers = json.loads((folder / f"{name}-{count}.json").read_text())
    try:
        alone = solve_alone(case, np.load(folder / f"{case['map']}.npy"))
    except rc.RoughContactError as error:
        return "refused" if numbers.get("error") == str(error) else f"other words: {numbers} {error}"
    if "error" in numbers or numbers["status"] != alone.status.name:
        return f"other end: {numbers}"
    pressure = np.load(folder / f"{name}-{count}.npy")
    return {
        "pressure": float(np.abs(pressure - alone.contact_pressure).max() / alone.contact_pressure.max()),
        "cells": int(((pressure > 0.0) != alone.contact).sum()),
        "area": abs(numbers["counted_area"] / alone.area("cell-count").value - 1.0),
        "approach": abs(numbers["approach"] - alone.approach) / float(np.ptp(alone.initial_gap)),
        "iterations": abs(numbers["iterations"] - alone.iterations),
        "residual": max(numbers["residuals"].values()),
    }


def main():
    """Print the largest differences."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        cases = make_cases(folder)
        for count in COUNTS:
            done = mpi.run(count, TESTS / "solve_cases.py", folder, timeout=3600)
            if done.returncode:
                sys.exit(done.stderr)
            found = {name: compare(folder, name, case, count) for name, case in cases.items()}
            solved = {name: one for name, one in found.items() if isinstance(one, dict)}
            print(f"{count} processes: {len(solved)} solved, {list(found.values()).count('refused')} refused alike")
            for what in next(iter(solved.values())):
                name = max(solved, key=lambda name: solved[name][what])
                print(f"  largest {what}: {solved[name][what]:.2g} (problem {name})")
            for name, one in found.items():
                if isinstance(one, str) and one != "refused":
                    print(f"  problem {name}: {one}")


if __name__ == "__main__":
    main()
