"""Cost of a solve on a core and on a node of a cluster, by a model of its memory traffic and its transforms.

    python docs/studies/cluster.py

Bytes of a product and of the passes of an iteration, and the rates of one core, are those of products and solves that
were measured on a periodic grid of 4096 x 4096 cells. The rates of a node are assumed, not measured. Beside the model
stand the wall times on one thread of docs/tables/scale.csv.
"""

from __future__ import annotations

import math

import attrs
import doc_tables
from doc_tables import DocTable, Rows

from roughcontact._base.units import binary

SIDES = (512, 1024, 4096, 8192, 16384)
# Products with the kernel and its inverse, passes over all fields (iterations, those of coarse grids included).
PRODUCTS = 28
PASSES = 12
# Bytes of memory traffic for each cell: of a product, of a pass; flop of a product for each cell and octave.
PRODUCT_BYTES = 56
PASS_BYTES = 220
FLOP = 10
# Bytes of memory for each cell at light contact: eight float64 arrays.
CELL_BYTES = 64


@attrs.frozen
class Machine:
    """Memory bandwidth, bytes/s, and speed of Fourier transforms, flop/s."""

    bandwidth: float
    speed: float

    def seconds(self, side: int) -> float:
        """Return the time of a solve on a periodic grid of side x side cells."""
        product = PRODUCT_BYTES / self.bandwidth + FLOP * math.log2(side) / self.speed
        return side**2 * (PRODUCTS * product + PASSES * PASS_BYTES / self.bandwidth)


CORE = Machine(bandwidth=12e9, speed=17e9)
# 64 cores.
NODE = Machine(bandwidth=200e9, speed=640e9)


def make_rows() -> Rows:
    heading, *lines = doc_tables.read("scale")
    cells, wall = heading.index("N"), heading.index("wall, s")
    measured = {line[cells]: line[wall] for line in lines if line[0] == "periodic"}
    rows = [["N", "memory", "core, measured, s", "core, model, s", "node, model, s", "solves of a node in an hour"]]
    for side in SIDES:
        seconds = NODE.seconds(side)
        figures = map(two_digits, (CORE.seconds(side), seconds, 3600 / seconds))
        rows.append([str(side), binary(CELL_BYTES * side**2), measured.get(str(side), ""), *figures])
    return rows


def two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):.6g}"


TABLES = {"cluster": DocTable(make_rows, seconds=0.1)}

if __name__ == "__main__":
    doc_tables.write_tables(TABLES)
