"""The values that the paper prints, and the converged ones. Loads in MPa, pressures in GPa, areas in % of nominal."""

from __future__ import annotations

from collections.abc import Mapping

# Nominal pressures, and cells along a side, of Tables 1 and 2.
LOADS = (50, 100, 200)
GRIDS = (64, 128, 256, 512, 1024, 2048)

# Table 1: maximum pressure by eq. 26, and by the semi-analytical method (SAM) on each grid.
ANALYTIC_P_MAX = {50: 10.52, 100: 13.26, 200: 16.71}
SAM_P_MAX: Mapping[int, tuple[float, ...]] = {
    50: (3.719, 5.637, 8.645, 11.42, 10.57, 10.54),
    100: (5.056, 7.888, 13.42, 13.81, 13.34, 13.25),
    200: (6.872, 11.74, 18.34, 17.04, 16.73, 16.67),
}
# ... and the errors of these against eq. 26, %, unsigned.
SAM_P_MAX_ERROR: Mapping[int, tuple[float, ...]] = {
    50: (64.7, 46.4, 17.9, 8.5, 0.5, 0.22),
    100: (61.8, 40.5, 1.3, 4.2, 0.6, 0.07),
    200: (58.9, 29.7, 9.8, 2.0, 0.2, 0.2),
}
# Table 2: real contact area by eq. 27, and by SAM on each grid.
ANALYTIC_AREA = {50: 0.713, 100: 1.131, 200: 1.796}
SAM_AREA: Mapping[int, tuple[float, ...]] = {
    50: (2.734, 1.733, 1.221, 0.868, 0.787, 0.750),
    100: (3.809, 2.441, 1.678, 1.326, 1.228, 1.184),
    200: (5.469, 3.222, 2.289, 2.055, 1.932, 1.875),
}
# ... and the errors of these against eq. 27, %.
SAM_AREA_ERROR: Mapping[int, tuple[float, ...]] = {
    50: (283.7, 143.2, 71.3, 21.8, 8.5, 5.3),
    100: (236.6, 115.8, 48.4, 17.2, 7.9, 4.6),
    200: (204.5, 79.4, 27.4, 14.5, 7.5, 4.4),
}
# Table 3: the area extrapolated by eq. 28, and its error against eq. 27, %.
EXTRAPOLATED_AREA = {50: 0.714, 100: 1.137, 200: 1.838}
EXTRAPOLATED_ERROR = {50: 0.14, 100: 0.45, 200: 2.33}
# Table 4: 52100 steel: elastic modulus, GPa; Poisson's ratio; hardness, GPa.
STEEL = {"elastic modulus, GPa": 210.0, "Poisson's ratio": 0.3, "hardness, GPa": 6.0}
# Table 5: area in um2, counted on 2048 x 2048 cells and extrapolated, by state and force, N.
PAIR_AREA: Mapping[tuple[str, float], tuple[float, float]] = {
    ("before running in", 2.5): (540.1, 509.9),
    ("before running in", 5.0): (1126.2, 1063.1),
    ("after running in", 2.5): (613.9, 538.3),
    ("after running in", 5.0): (1262.4, 1086.9),
    ("after running in", 10.0): (2597.1, 2149.2),
}
# Not in the paper: solves of one wave of the infinite surface on up to 4096 x 4096 cells, good to 0.02 %.
TRUE_AREA = {50: 0.71689, 100: 1.14192, 200: 1.82266}
TRUE_P_MAX = {50: 10.504, 100: 13.220, 200: 16.630}
