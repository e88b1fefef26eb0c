"""What is done to the heights of a map: filled, moved, cut, filtered, and freed of the tip that traced them."""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair
from roughcontact._base.checks import flag, number, pair
from roughcontact._base.units import Length, Quantity, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import stylus
from roughcontact._parts.surfaces.base import Surface
from roughcontact._parts.surfaces.filling import describe_filling, fill
from roughcontact._parts.surfaces.resampling import smooth
from roughcontact._parts.surfaces.robust_filter import smooth_robustly
from roughcontact.errors import InputError


class TreatedMap(Surface):
    """A height map as far as its treatments know it.

    Attributes
    ----------
    grid, size, periodic
        Its grid, sides, m, and whether it repeats beyond its border.
    non_measured, uncertain
        Masks of points that were not measured, and that the tip of a stylus has not surely touched; None without any.
    history
        Processing of the heights so far.
    """

    _heights: Array
    size: Pair
    periodic: bool
    non_measured: Mask | None
    uncertain: Mask | None
    history: tuple[str, ...]

    @property
    @abc.abstractmethod
    def grid(self) -> Grid:
        """The grid on which the map is given."""

    @abc.abstractmethod
    def _change(self, **changes: Any) -> Self:
        """Return the map with other arguments."""

    def fill(self) -> Self:
        """Return the map with its non-measured points taken as measured, at heights filled from their neighbours."""
        if self.non_measured is None:
            return self
        heights = fill(np.where(self.non_measured, np.nan, self._heights))
        history = (*self.history, describe_filling(self.non_measured))
        return self._change(heights=heights, non_measured=None, history=history)

    def mirrored(self) -> Self:
        """Return the map with x reversed: what faces a body whose map was measured from outside, too."""
        return self._rearrange(lambda values: values[::-1], "mirrored, x to -x")

    def mirror_borders(self) -> Self:
        """Return the map and its mirror images at two borders, four times as large: it repeats without a step.

        A map that repeats is returned as it is.
        """
        if self.periodic:
            return self

        def unfold(values: Any) -> Any:
            along_x = np.concatenate([values, values[::-1]], axis=0)
            return np.concatenate([along_x, along_x[:, ::-1]], axis=1)

        size = 2.0 * self.size[0], 2.0 * self.size[1]
        return self._rearrange(unfold, "mirrored at its borders", size, periodic=True)

    def transposed(self) -> Self:
        """Return the map with x and y exchanged."""
        return self._rearrange(np.transpose, "x and y exchanged", self.size[::-1])

    def _rearrange(
        self, move: Callable[[Any], Any], text: str, size: Pair | None = None, *, periodic: bool | None = None
    ) -> Self:
        return self._change(
            heights=move(self._heights),
            size=size or self.size,
            periodic=self.periodic if periodic is None else periodic,
            non_measured=None if self.non_measured is None else move(self.non_measured),
            uncertain=None if self.uncertain is None else move(self.uncertain),
            history=(*self.history, text),
        )

    def crop(self, size: float | Sequence[float], centre: Sequence[float] = (0.0, 0.0)) -> Self:
        """Return the part of the map in a rectangle, of whole cells; it does not repeat.

        Parameters
        ----------
        size
            Sides of the rectangle (x, y), m; one number for a square.
        centre
            Its centre (x, y), m, from the centre of the map.

        Raises
        ------
        InputError
            If the rectangle is not inside the map, or has no measured point.

        Examples
        --------
        >>> import numpy as np
        >>> import roughcontact as rc
        >>> print(rc.HeightMap(np.eye(64), 64e-6).crop(32e-6, centre=(8e-6, 0.0)).grid)
        32 x 32 cells on 32 µm x 32 µm
        """
        sides = pair(size, "The size of the part", "m", above=0.0)
        middle = pair(centre, "The centre of the part", "m")
        ranges = []
        for side, place, step, count in zip(sides, middle, self.grid.spacing, self._heights.shape, strict=True):
            cells = max(round(side / step), 1)
            first = round(place / step + 0.5 * (count - cells))
            if first < 0 or first + cells > count:
                part, whole, around = (
                    mark.join(si(length, "m") for length in lengths)
                    for mark, lengths in ((" x ", sides), (" x ", self.size), (", ", middle))
                )
                raise InputError(
                    f"A part of {part} around ({around}) is not inside the map, {whole} around its centre."
                )
            ranges.append(slice(first, first + cells))
        inside = tuple(ranges)
        nx, ny = self._heights[inside].shape
        dx, dy = self.grid.spacing
        indices = " x ".join(f"{one.start} to {one.stop - 1}" for one in ranges)
        text = f"cut to {nx} x {ny} of its cells, {indices}"
        return self._rearrange(lambda values: values[inside], text, (nx * dx, ny * dy), periodic=False)

    def filtered(self, shortest: Length | None = None, longest: Length | None = None, *, robust: bool = False) -> Self:
        """Return the map without its short waves, its long waves, or both, by Gaussian filters.

        A wave of the cut-off wavelength loses half of its amplitude (ISO 16610-61; robust filters, ISO 16610-71). At
        the border of a map that does not repeat, and at non-measured points, the weights of the measured points are
        raised to a sum of one. A map that was filtered is smooth on the scale of its cells, where a contact needs
        heights: state the cut-off with the area.

        Parameters
        ----------
        shortest
            Cut-off below which waves are removed (S filter), m, at least two cells.
        longest
            Cut-off above which waves are removed (L filter), m.
        robust
            Whether grooves and spikes must not move the mean surface, by local paraboloids with robust weights: as on a
            honed liner, whose plateaus the grooves would otherwise lift. Forms of second degree are removed with the
            long waves. Of the other filter it takes some 20 times the work.

        Raises
        ------
        InputError
            If neither is given, a cut-off is shorter than two cells, or the longest is below the shortest.

        Examples
        --------
        >>> import numpy as np
        >>> import roughcontact as rc
        >>> grid = rc.Grid((64, 64), 64e-6)
        >>> wave = rc.HeightMap(rc.WavySurface(1e-6, 16e-6).heights(grid), 64e-6, periodic=True)
        >>> print(f"{np.ptp(wave.filtered(16e-6).values) / np.ptp(wave.values):.3f}")
        0.500
        """
        if shortest is None and longest is None:
            raise InputError("Give the cut-off of the short waves, of the long ones (longest=), or both, m.")
        limits = [_check_cutoff(value, self.grid) for value in (shortest, longest)]
        low, high = limits
        if low is not None and high is not None and high <= low:
            raise InputError.about("The longest wavelength that stays", high, f"above the shortest ({low:g} m)")
        is_robust = flag(robust, "robust=")
        filter_map = smooth_robustly if is_robust else smooth
        kind = "robust " if is_robust else ""
        heights = self._heights
        texts = []
        for cutoff, word in ((low, "below"), (high, "above")):
            if cutoff is None:
                continue
            means = filter_map(heights, self.grid, cutoff, periodic=self.periodic, non_measured=self.non_measured)
            heights = means if word == "below" else heights - means
            texts.append(f"waves {word} {si(cutoff, 'm')} removed by a {kind}Gaussian filter")
        return self._change(heights=heights, history=(*self.history, *texts))

    def traced(self, tip_radius: Length) -> Self:
        r"""Return the map that a stylus with a ball at its end traces of this one: its dilation by the ball.

        .. math:: m(x) = \max_d \left( z(x + d) - R + \sqrt{R^2 - d^2} \right)

        Its summits are blunt and the area of a contact is too large: by a sixth where R is half of the inverse rms of
        z_xx + z_yy.

        Parameters
        ----------
        tip_radius
            Radius of the ball R, m.

        Raises
        ------
        InputError
            If the radius is not above zero, or the ball reaches over too many cells.

        Examples
        --------
        >>> import numpy as np
        >>> import roughcontact as rc
        >>> spike = np.zeros((33, 33))
        >>> spike[16, 16] = 1e-6
        >>> wide = rc.HeightMap(spike, 33e-6).traced("2um")
        >>> print(f"{1e6 * wide.values[17, 16]:.3f} µm")
        0.732 µm
        """
        radius = _check_radius(tip_radius)
        tip = stylus.make_tip(self._heights, self.grid, radius, periodic=self.periodic)
        found = stylus.trace(self._heights, tip, periodic=self.periodic, non_measured=self.non_measured)
        history = (*self.history, f"as a tip of radius {si(radius, 'm')} traces it")
        return self._change(heights=found, history=history)

    def restored(self, tip_radius: Length, *, noise: Length = 0.0) -> Self:
        r"""Return the surface below a map that a stylus has traced: the erosion of the map by the ball at its end.

        .. math:: r(x) = \min_d \left( m(x + d) + R - \sqrt{R^2 - d^2} \right)

        It is the highest surface of which the ball traces this map, nowhere below the true one but for noise. It is the
        true one where the ball touched it, as on most summits: `uncertain` marks the points that the ball has not
        surely touched, and `certain_fraction` states the others. The area of a contact on it states which fraction lies
        on certain points, is warned of below 0.9, and has its uncertainty widened, as have other answers: the mean gap
        and flows, which are too small, by the depth that the valleys may have. Restore a map before its form is
        subtracted or it is filtered for long waves, and state the radius of the tip as it is, worn: with one that is
        30 % off the area is up to 20 % off.

        Parameters
        ----------
        tip_radius
            Radius of the ball R, m.
        noise
            Standard deviation of the noise of the heights, m: points within three of it count as touched. The
            ball follows noise downwards: filter it first. From about 3 % of Sq on it is warned of.

        Raises
        ------
        InputError
            If the radius is not above zero, or the ball reaches over too many cells.

        References
        ----------
        Villarrubia, J. Res. Natl. Inst. Stand. Technol. 102 (1997) 425-454, https://doi.org/10.6028/jres.102.030

        Examples
        --------
        >>> import roughcontact as rc
        >>> grid = rc.Grid((64, 64), 64e-6)
        >>> wave = rc.HeightMap(rc.WavySurface(0.2e-6, 16e-6).heights(grid), 64e-6, periodic=True)
        >>> found = wave.traced("20um").restored("20um")
        >>> error = found.values - wave.values
        >>> print(f"{found.certain_fraction:.2f} certain, {1e9 * error.max():.0f} nm too high at most")
        0.68 certain, 10 nm too high at most
        """
        radius = _check_radius(tip_radius)
        noise_std = number(noise, "The noise of the heights", "m", at_least=0.0)
        grid = self.grid
        lost = self.non_measured
        tip = stylus.make_tip(self._heights, grid, radius, periodic=self.periodic)
        found = stylus.restore(self._heights, tip, periodic=self.periodic, non_measured=lost)
        again = stylus.trace(found, tip, periodic=self.periodic, non_measured=lost)
        certain = stylus.find_certain(self._heights, found, tip, noise_std, periodic=self.periodic, non_measured=lost)
        text = stylus.describe_restoring(radius, float(certain.mean()), self._heights, again)
        return self._change(heights=found, uncertain=~certain, history=(*self.history, text))

    @property
    def certain_fraction(self) -> float | None:
        """Fraction of the points that the tip of a stylus has surely touched; None if the map was not `restored`."""
        return None if self.uncertain is None else 1.0 - float(self.uncertain.mean())


def _check_radius(value: Quantity) -> float:
    return number(value, "The radius of the tip", "m", above=0.0)


def _check_cutoff(value: Quantity | None, grid: Grid) -> float | None:
    if value is None:
        return None
    cutoff = number(value, "The cut-off wavelength", "m", above=0.0)
    shortest = 2.0 * max(grid.resolved.spacing)
    if cutoff < shortest * (1.0 - 1e-9):
        raise InputError.about("The cut-off wavelength", cutoff, f"at least two cells, {shortest:g} m")
    return cutoff
