"""The convolution of shear: displacements by tractions, and its approximate inverse."""

from __future__ import annotations

from collections.abc import Callable

import attrs

from roughcontact._base.arrays import Array, RealArray
from roughcontact._solve.convolvers.base import ConvolutionSetup, ShearConvolution
from roughcontact._solve.convolvers.matrix import WaveMatrix


@attrs.frozen(eq=False)
class SymbolShear(ShearConvolution):
    """Multiplication of waves by a matrix of symbols."""

    setup: ConvolutionSetup
    matrix: WaveMatrix

    @classmethod
    def of(
        cls, setup: ConvolutionSetup, find_symbol: Callable[[str], Array], normal: Array, padded: tuple[int, int]
    ) -> SymbolShear:
        """Return the convolution from a function that gives the symbol of a component, and the symbol of zz."""
        components = ["xx", "yy", "xy"]
        if setup.kernel.pair.beta != 0.0:
            components += ["zx", "zy"]
        symbols = {"zz": normal} | {component: find_symbol(component) for component in components}
        return cls(setup, WaveMatrix({name: symbol for name, symbol in symbols.items() if symbol.any()}, padded))

    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> RealArray:
        return self.matrix.apply(tractions, of, to)
