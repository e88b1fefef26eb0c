"""Solves the cases of a folder on slabs; the first process writes their numbers. Run by `mpiexec`."""

import json
import sys
from pathlib import Path

import roughcontact as rc

from roughcontact_mpi import Processes, ending_all, read_heights, solve, write_field

folder = Path(sys.argv[1])
processes = Processes()
with ending_all(processes):
    for name, case in json.loads((folder / "cases.json").read_text()).items():
        if processes.count not in case["counts"]:
            continue
        material = rc.Elastic(1e9, 0.0)
        if case["hardness"] is not None:
            material = rc.ElasticPerfectlyPlastic(1e9, 0.0, case["hardness"])
        heights = read_heights(folder / f"{case['map']}.npy", processes)
        try:
            solution = solve(
                heights, case["size"], material, **case["load"], boundary=case["boundary"], tolerance=case["tolerance"]
            )
        except rc.InputError as error:
            # All refuse it.
            if processes.rank == 0:
                (folder / f"{name}-{processes.count}.json").write_text(json.dumps({"error": str(error)}))
            continue
        write_field(folder / f"{name}-{processes.count}.npy", solution.pressure)
        residuals = solution.residuals
        numbers = {
            "status": solution.status.name,
            "shape": solution.grid.shape,
            "iterations": solution.iterations,
            "convolutions": solution.convolutions,
            "approach": solution.approach,
            "force": solution.force,
            "area": solution.area().value,
            "counted_area": solution.area("cell-count").value,
            "patches": solution.patches.count,
            "residuals": {name: getattr(residuals, name) for name in ("complementarity", "penetration", "load")},
            "rows": processes.rows(heights.shape[0]),
        }
        if processes.rank == 0:
            (folder / f"{name}-{processes.count}.json").write_text(json.dumps(numbers))
