"""Measure contacts on slabs beside the solver of one process: `python measure.py` prints two tables.

Work is what each process computes outside of calls of MPI, in which it spins while it waits; the largest of all counts.
Memory is the peak of numpy's arrays in a solve, over the float64 arrays of the slab, without the heights.
"""

import json
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_mpi import Processes, SlabArray, ending_all, read_heights, solve

SIDES = (256, 1024, 4096)
# Of a side from here on one contact is measured.
LARGE = 4096
COUNTS = (1, 2, 4)
CONTACTS = {
    "periodic, light": {"load": {"pressure": 5e6}, "boundary": "periodic"},
    "periodic, half": {"load": {"pressure": 3e7}, "boundary": "periodic"},
    "periodic, nearly full": {"load": {"pressure": 1e8}, "boundary": "periodic"},
    "periodic, hardness": {"load": {"pressure": 1e7}, "boundary": "periodic", "hardness": 3e7},
    "free, light": {"load": {"pressure": 5e6}, "boundary": "free"},
    "free-periodic, light": {"load": {"pressure": 5e6}, "boundary": "free-periodic"},
    "periodic-free, light": {"load": {"pressure": 5e6}, "boundary": "periodic-free"},
}
REPEATS = 3
# The answers that are measured, from a solution that has none yet, on grids of a side from here on.
ANSWERS = {"area": lambda solution: solution.area(), "stiffness": lambda solution: solution.stiffness()}
ANSWERED = 1024


class Timed:
    """A communicator that adds up the processor time of its calls."""

    def __init__(self, communicator):
        self.communicator = communicator
        self.seconds = 0.0

    def __getattr__(self, name):
        call = getattr(self.communicator, name)

        def timed(*arguments, **options):
            started = time.thread_time()
            found = call(*arguments, **options)
            self.seconds += time.thread_time() - started
            return found

        return timed


def contacts_of(side):
    """Return the contacts that are measured on a grid."""
    return list(CONTACTS.items())[: 1 if side >= LARGE else None]


def material_of(contact):
    """Return the material of a contact."""
    hardness = contact.get("hardness")
    return rc.Elastic(1e9, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1e9, 0.0, hardness)


def traced(run):
    """Return the peak of numpy's arrays in a run, bytes."""
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def measure_slabs(path):
    """Solve the contacts of a map as one of several processes; the first prints the numbers."""
    processes = Processes()
    with ending_all(processes):
        heights = read_heights(path, processes)
        rows = {}
        for name, contact in contacts_of(heights.shape[0]):

            def run(of=heights, contact=contact):
                return solve(of, 1e-3, material_of(contact), **contact["load"], boundary=contact["boundary"])

            seconds = []
            for _ in range(REPEATS):
                timed = Timed(processes.communicator)
                own = Processes(timed)
                slab = SlabArray.field(heights.part, own, heights.shape[0])
                started = time.thread_time()
                solution = run(slab)
                seconds.append(time.thread_time() - started - timed.seconds)
            counts = {"reductions": own.reductions, "sent": own.sent}
            peak = traced(run) / max(8 * heights.part.size, 1)
            work = float(processes.collect(min(seconds)).max())
            memory = float(processes.collect(peak).max())
            row = {"iterations": solution.iterations, "convolutions": solution.convolutions}
            row["counted_area"] = solution.area("cell-count").value
            answers = {}
            if heights.shape[0] >= ANSWERED:
                answers = {answer: measure_answer(solution, answer, timed, own) for answer in ANSWERS}
            rows[name] = row | counts | {"work": work, "memory": memory, "answers": answers}
        if processes.rank == 0:
            print(json.dumps(rows))


def measure_answer(solution, answer, timed, own):
    """Return the work of an answer on slabs, s, the number of reductions, and the bytes that a process sends."""
    seconds = []
    for _ in range(REPEATS):
        fresh = attrs.evolve(solution)
        own.sent = own.reductions = 0
        timed.seconds = 0.0
        started = time.thread_time()
        ANSWERS[answer](fresh)
        seconds.append(time.thread_time() - started - timed.seconds)
    return float(own.collect(min(seconds)).max()), own.reductions - 1, own.sent


def measure_alone(path):
    """Solve the contacts of a map in this process, and yield the numbers of each."""
    heights = np.load(path)
    for name, contact in contacts_of(heights.shape[0]):
        surface = rc.HeightMap(heights, 1e-3, periodic=contact["boundary"] == "periodic")
        body = rc.Body(surface, material_of(contact))
        seconds = []
        for _ in range(REPEATS):
            problem = rc.ContactProblem(body, boundary=contact["boundary"], threads=1)
            started = time.thread_time()
            solution = problem.solve(**contact["load"])
            seconds.append(time.thread_time() - started)
        problem = rc.ContactProblem(body, boundary=contact["boundary"], threads=1)
        peak = traced(lambda problem=problem, contact=contact: problem.solve(**contact["load"])) / (8 * heights.size)
        area = solution.area("cell-count").value
        answers = {}
        for answer, ask in ANSWERS.items() if heights.shape[0] >= ANSWERED else ():
            took = []
            for _ in range(REPEATS):
                fresh = attrs.evolve(solution)
                started = time.thread_time()
                ask(fresh)
                took.append(time.thread_time() - started)
            answers[answer] = min(took)
        yield name, solution.iterations, solution.convolutions, area, min(seconds), peak, answers


def main():
    """Print both tables."""
    answered = []
    print("| contact | cells a side | processes | iterations | products | area, counted | reductions | sent, MiB "
          "| work, s | over one process | memory, arrays |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for side in SIDES:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "map.npy"
            shortest = 8e-3 / side
            rough = rc.SelfAffineSurface(
                hurst=0.8, rms_slope=0.1, shortest=shortest, longest=1e-3, rolloff=1.25e-4, seed=1
            )
            np.save(path, rough.heights(rc.Grid((side, side), 1e-3)))
            slabs = {}
            for count in COUNTS:
                command = ["mpiexec", "-n", str(count), sys.executable, __file__, str(path)]
                slabs[count] = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
            for name, iterations, products, area, seconds, memory, answers in measure_alone(path):
                head = f"| {name} | {side} |"
                done = f"{iterations} | {products} | {area * 1e6:.8f}"
                print(f"{head} serial | {done} | | | {seconds:.2f} | 1 | {memory:.1f} |")
                for count in COUNTS:
                    row = slabs[count][name]
                    work = row["work"]
                    done = f"{row['iterations']} | {row['convolutions']} | {row['counted_area'] * 1e6:.8f}"
                    sent = f"{row['reductions']} | {row['sent'] / 2**20:.1f}"
                    cost = f"{work:.2f} | {work / seconds:.2f} | {row['memory']:.1f}"
                    print(f"{head} {count} | {done} | {sent} | {cost} |", flush=True)
                for answer, alone in answers.items():
                    answered.append(f"| {answer} | {name} | {side} | serial | | | {alone:.2f} | 1 |")
                    for count in COUNTS:
                        work, reductions, sent = slabs[count][name]["answers"][answer]
                        cost = f"{reductions} | {sent / 2**20:.1f} | {work:.2f} | {work / alone:.2f}"
                        answered.append(f"| {answer} | {name} | {side} | {count} | {cost} |")
    print("\n| answer | contact | cells a side | processes | reductions | sent, MiB | work, s | over one process |")
    print("|---|---|---|---|---|---|---|---|")
    print("\n".join(answered))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure_slabs(sys.argv[1])
    else:
        main()
