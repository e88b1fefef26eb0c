"""The multiplication of the waves of several fields by a matrix: displacements, or stresses, by tractions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray, Waves
from roughcontact._base.checks import choice
from roughcontact._base.units import outlined
from roughcontact._parts.kernels import odd_axes
from roughcontact._solve.convolvers.transforms import (
    list_all_waves,
    multiply_columns,
    transform_columns,
    transform_columns_back,
    transform_rows,
    transform_rows_back,
)

# Maximum waves of a field that are multiplied as a whole: calls cost more there than passes over memory.
_MAX_WHOLE_WAVES = 2**15


@attrs.frozen(eq=False)
class WaveMatrix:
    """The multiplication of each wave of several fields by a matrix, on a periodic grid that may be padded.

    A traction, or a displacement, is named by a letter, and a stress by two. The matrix is real if the fields named by
    an even number of letters x and y are counted times i, and such products over i.

    Attributes
    ----------
    symbols
        The factor of each component, as in `SupportsShear`, or ``"zz"``, or of a stress by a load, such as ``"xzx"``,
        for half of the waves in x and in y, shape (mx // 2 + 1, my // 2 + 1). Of a component that is odd in one axis
        it is the imaginary part. A component that is missing is zero.
    padded
        Cells (mx, my) of the periodic grid.
    """

    symbols: Mapping[str, RealArray] = attrs.field(repr=outlined)
    padded: tuple[int, int]

    @cached_property
    def _symbols_float32(self) -> dict[str, RealArray]:
        return {name: symbol.astype(np.float32, copy=False) for name, symbol in self.symbols.items()}

    @cached_property
    def _factors(self) -> dict[tuple[Sequence[str], Sequence[str], bool], RealArray]:
        """The factors found so far of all waves of small grids."""
        return {}

    def apply(self, fields: RealArray, of: Sequence[str] = "xy", to: Sequence[str] = "xy") -> RealArray:
        """Return the products, shape (len(to), nx, ny), in the precision of the fields, shape (len(of), nx, ny).

        The letters of fields and products name the components.
        """
        count, nx, ny = fields.shape
        mx, my = self.padded
        if mx * my <= _MAX_WHOLE_WAVES:
            return self._apply_as_whole(fields, of, to)

        def multiply(columns: Waves, block: slice) -> Waves:
            turn(columns, of)
            return self.multiply(columns, block, of, to)

        waves = transform_rows(fields.reshape(count * nx, ny), my).reshape(count, nx, -1)
        out = waves if len(of) == len(to) else np.empty((len(to), *waves.shape[1:]), dtype=waves.dtype)
        multiply_columns(waves, mx, multiply, out)
        return transform_rows_back(out.reshape(len(to) * nx, -1), my, ny).reshape(len(to), nx, ny)

    def _apply_as_whole(self, fields: RealArray, of: Sequence[str], to: Sequence[str]) -> RealArray:
        """Return the products of the fields of a small grid, by few calls."""
        count, nx, ny = fields.shape
        mx, my = self.padded
        rows = transform_rows(fields.reshape(count * nx, ny), my).reshape(count, nx, -1)
        waves = transform_columns(rows, mx)
        turn(waves, of)
        key = of, to, waves.dtype == np.complex64
        if key not in self._factors:
            self._factors[key] = self._list_factors(*key)
        factors = self._factors[key]
        products: Waves = factors[:, 0] * waves[0]
        for column, wave in zip(factors.swapaxes(0, 1)[1:], waves[1:], strict=True):
            products += column * wave
        turn(products, to)
        back = transform_columns_back(products)[:, :nx]
        return transform_rows_back(back.reshape(len(to) * nx, -1), my, ny).reshape(len(to), nx, ny)

    def _list_factors(self, of: Sequence[str], to: Sequence[str], single: bool) -> RealArray:
        """Return the real matrix of each wave, shape (len(to), len(of), mx, my // 2 + 1)."""
        symbols = self._symbols_float32 if single else self.symbols
        shape = (self.padded[0], self.padded[1] // 2 + 1)
        factors = np.zeros((len(to), len(of), *shape), dtype=np.float32 if single else np.float64)
        for row, letters in zip(factors, to, strict=True):
            for factor, other in zip(row, of, strict=True):
                name, sign = _find_real_component(letters, other)
                if name in symbols:
                    factor[...] = sign * list_all_waves(symbols[name], shape[0], odd_axes(name)[0])
        return factors

    def multiply(self, turned: Waves, block: slice, of: Sequence[str], to: Sequence[str]) -> Waves:
        """Return the products of some columns of waves after `turn`, shape (len(to), mx, n)."""
        symbols = self._symbols_float32 if turned.dtype == np.complex64 else self.symbols
        products = np.empty((len(to), *turned.shape[1:]), dtype=turned.dtype)
        for product, letters in zip(products, to, strict=True):
            terms = []
            for waves, other in zip(turned, of, strict=True):
                name, sign = _find_real_component(letters, other)
                if name in symbols:
                    terms.append((waves, symbols[name][:, block], sign, odd_axes(name)[0]))
            _add_terms(product, terms)
        turn(products, to)
        return products


def turn(waves: Waves, names: Sequence[str]) -> None:
    """Multiply the waves of fields by i, in place, where they are named by an even number of letters x and y."""
    for one, name in zip(waves, names, strict=True):
        if _is_turned(name):
            one *= 1j


def _is_turned(name: str) -> bool:
    return (len(name) - name.count("z")) % 2 == 0


def find_component(to: str, of: str) -> tuple[str, int]:
    """Return the component that a kernel knows and the sign with which it gives a stress or a displacement by a load.

    `InputError` if the letter of a load or of a displacement is not x, y or z.
    """
    if len(to) == 2:
        return to + of, 1
    for letter in (to, of):
        choice(letter, "The letter of a traction or displacement", ("x", "y", "z"))
    if of == "z" and to != "z":
        return of + to, -1
    return ("xy" if to + of == "yx" else to + of), 1


def _find_real_component(to: str, of: str) -> tuple[str, int]:
    """Return component and sign of the real matrix; where load and product are turned, i times i is -1."""
    name, sign = find_component(to, of)
    return name, -sign if _is_turned(to) and _is_turned(of) else sign


def _add_terms(product: Waves, terms: list[tuple[Waves, RealArray, int, bool]]) -> None:
    """Set the product to the sum of waves times symbols, each with its sign, and whether it is odd in x.

    The symbols have half of the waves in x.
    """
    if not terms:
        product[...] = 0.0
        return
    half = terms[0][1].shape[0]
    for is_mirrored, part in enumerate((slice(half), slice(half, None))):
        target = product[part]
        for place, (waves, symbol, sign, is_odd) in enumerate(terms):
            factor = symbol[product.shape[0] - half : 0 : -1] if is_mirrored else symbol
            is_added = (sign > 0) != (is_mirrored and is_odd)
            if place == 0:
                np.multiply(waves[part], factor if is_added else -factor, out=target)
            elif is_added:
                target += waves[part] * factor
            else:
                target -= waves[part] * factor
