"""The figures as the paper prints them, and the converged answers. Loads in MPa, pressures in GPa, areas in %."""

from __future__ import annotations

from collections.abc import Mapping

LOADS = (50, 100, 200)
GRIDS = (64, 128, 256, 512, 1024, 2048)

# Table 1.
ANALYTIC_P_MAX = {50: 10.52, 100: 13.26, 200: 16.71}
SAM_P_MAX: Mapping[int, tuple[float, ...]] = {
    50: (3.719, 5.637, 8.645, 11.42, 10.57, 10.54),
    100: (5.056, 7.888, 13.42, 13.81, 13.34, 13.25),
    200: (6.872, 11.74, 18.34, 17.04, 16.73, 16.67),
}
# Table 2.
ANALYTIC_AREA = {50: 0.713, 100: 1.131, 200: 1.796}
SAM_AREA: Mapping[int, tuple[float, ...]] = {
    50: (2.734, 1.733, 1.221, 0.868, 0.787, 0.750),
    100: (3.809, 2.441, 1.678, 1.326, 1.228, 1.184),
    200: (5.469, 3.222, 2.289, 2.055, 1.932, 1.875),
}
# Table 3.
EXTRAPOLATED_AREA = {50: 0.714, 100: 1.137, 200: 1.838}
# Not in the paper: solves of one wave of the infinite surface on up to 4096 x 4096 cells, good to 0.02 %.
TRUE_AREA = {50: 0.71689, 100: 1.14192, 200: 1.82266}
TRUE_P_MAX = {50: 10.504, 100: 13.220, 200: 16.630}
