"""The types that a part of your own names: a material, kernel, convolver, solver, law, response, reader or command.

===========  ==========================================================================================================
for          names
===========  ==========================================================================================================
all parts    `Part`, the base of those without one of their own; numbers in SI units or texts with a unit, `Quantity`,
             `Length`, `Pressure`, `Force`; the load of a contact, `Load`
arrays       `Array` (float64), `RealArray` (float32 or float64), `IntArray`, `Mask` (bool), `Pair` (x, y)
kernels      `SupportsCoefficients`, `SupportsRows`, `SupportsSpectrum`, `SupportsShear`, `SupportsStress`,
             `SupportsConduction`, `SupportsTangential`; `HalfSpaceStress`, `STRESS_COMPONENTS`; `PairConstants`,
             `pair_constants`
convolvers   `BoundKernel`, `ConvolutionSetup`, `PreparedConvolution`, `InverseConvolution`, `ShearConvolution`,
             `StressConvolution`, `FieldPasses`, `LastStep`; the function `padded_shape`
solvers      `Task`, `Outcome`, `Step`, `Monitor`, `Violation`, `BoundInteraction`; `ShearSolver`, `ShearTask`,
             `ShearOutcome`, `natural_residual`
physics      `LoadIncrement`, what passes between two states; `Memory`, what a process remembers, and `Press`, the
             contacts of a coupled one; `Addition`, what one adds to a state
readers      `RawMap`; the function `read_raw`
commands     `Command`, `Table`; the functions `quantity`, `si`, `binary`, `replacing`
===========  ==========================================================================================================

What calls return is in `roughcontact.results`; what a solve in your own hands needs, in `roughcontact.solving`; what a
page shows, in `roughcontact.faces`.
"""

from roughcontact._base.archive import replacing
from roughcontact._base.arrays import Array, IntArray, Mask, Pair, RealArray
from roughcontact._base.checks import Part
from roughcontact._base.tables import Table
from roughcontact._base.units import Force, Length, Pressure, Quantity, binary, quantity, si
from roughcontact._faces.cli import Command
from roughcontact._parts.files import RawMap, read_raw
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._parts.kernels import (
    STRESS_COMPONENTS,
    BoundKernel,
    HalfSpaceStress,
    SupportsCoefficients,
    SupportsConduction,
    SupportsRows,
    SupportsShear,
    SupportsSpectrum,
    SupportsStress,
    SupportsTangential,
)
from roughcontact._parts.materials import PairConstants, pair_constants
from roughcontact._solve.convolvers import (
    ConvolutionSetup,
    FieldPasses,
    InverseConvolution,
    LastStep,
    PreparedConvolution,
    ShearConvolution,
    StressConvolution,
    padded_shape,
)
from roughcontact._solve.solution import Addition, LoadIncrement, Memory, Press, Violation
from roughcontact._solve.solvers import (
    Monitor,
    Outcome,
    ShearOutcome,
    ShearSolver,
    ShearTask,
    Step,
    Task,
    natural_residual,
)

__all__ = [
    "STRESS_COMPONENTS",
    "Addition",
    "Array",
    "BoundInteraction",
    "BoundKernel",
    "Command",
    "ConvolutionSetup",
    "FieldPasses",
    "Force",
    "HalfSpaceStress",
    "IntArray",
    "InverseConvolution",
    "LastStep",
    "Length",
    "Load",
    "LoadIncrement",
    "Mask",
    "Memory",
    "Monitor",
    "Outcome",
    "Pair",
    "PairConstants",
    "Part",
    "PreparedConvolution",
    "Press",
    "Pressure",
    "Quantity",
    "RawMap",
    "RealArray",
    "ShearConvolution",
    "ShearOutcome",
    "ShearSolver",
    "ShearTask",
    "Step",
    "StressConvolution",
    "SupportsCoefficients",
    "SupportsConduction",
    "SupportsRows",
    "SupportsShear",
    "SupportsSpectrum",
    "SupportsStress",
    "SupportsTangential",
    "Table",
    "Task",
    "Violation",
    "binary",
    "natural_residual",
    "padded_shape",
    "pair_constants",
    "quantity",
    "read_raw",
    "replacing",
    "si",
]
