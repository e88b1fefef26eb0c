"""The measured constants of areas and of the other numbers: meaning, unit, how each was measured, and by which script.

The ratio is the resolution ratio of `curvature_resolution`; the width of a patch is in cells of a disc as wide; the
bend of p^2 is -h^2 times its laplacian over p^2.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from roughcontact._base.arrays import Array, read_only


def _read_table(name: str) -> Array:
    """Return the columns of a table that a script has written beside this module."""
    return read_only(np.loadtxt(Path(__file__).with_name(name), delimiter=",", unpack=True))


# --- benchmarks/edge_constants.py: spheres against closed forms -------------------------------------------------------

# Area that polygons between the cells lack besides the area that their chords cut off, cells^2 for each piece less
# holes. Measured on 200 spheres of 3 to 25 cells radius, fitted together with the kernel's shift of the edge: 0.21 +-
# 0.07.
PIECE_AREA_DEFICIT = 0.16
# Standard deviation of the area of a patch, cells^2 per root of the number of cell sides along its edge: the
# discrete solution itself varies. Measured on the same spheres: rms 0.053 about the fit.
EDGE_AREA_STD = 0.05
# Standard deviation of the area where a free border cuts a contact, cells^2 for each contact cell on the border.
# Measured on 60 spheres against four times finer grids: rms 0.07; more, up to 0.9, where one to five cells are cut,
# and on rough contacts.
CUT_BORDER_STD = 0.15

# Standard deviation of the place of a straight edge along the grid, cells, over the width of the contact and of the gap
# beyond, in cells. Measured on cylinders of 6 to 30 cells half width, and on waves.
STRAIGHT_POSITION_STD = (0.1, 0.3)
# Places of such edges between the centres of the last cell in contact and the next, in cells: the true ones, and those
# of the traced polygons, shape (2, places). Measured on cylinders of 1600 cells half width, the same on waves; beyond
# the last the next cell is in contact.
STRAIGHT_EDGE_PLACES = _read_table("straight_edges.csv")

# --- benchmarks/limit_constants.py: spheres at a pressure limit ------------------------------------------------------

# Overloads, Hertz's maximum pressure over the pressure limit, and the contact area of a sphere at these over Hertz's
# area, no unit, shape (2, overloads); beyond, two thirds of the overload. Measured on spheres of 40 cells elastic
# radius: within 0.0015.
PLASTIC_GROWTH = _read_table("plastic_growth.csv")

# --- benchmarks/rough_constants.py: self-affine surfaces of 32 cells a shortest wave ----------------------------------

# Terms a, b, c of Hertz's relative standard deviation a v / (v + v0) + b v^2 + c v^4 where v is the spread of the
# curvature, no unit; v0 is EVEN_SPREAD.
# Measured on patches of at least 150 cells: rms 0.009, 0.015, 0.06, 0.16, 0.29 (in use: 0.016, 0.03, 0.06, 0.12, 0.32)
# at v of 0.15 to 0.3, to 0.4, to 0.6, to 0.8, to 1.2.
HERTZ_ERROR = (0.0003, 0.2, 0.1)
# Fraction of that standard deviation that is common to all patches, no unit.
# Measured: 0.53 at v below 0.3.
HERTZ_COMMON_FRACTION = 0.55

# --- benchmarks/area_classes.py: the tuned half of the classes of contacts --------------------------------------------

# Standard deviation of the area for each cell in contact at a free border before which the contact ends, cells. Set on
# balls that nearly touch the border.
UNCUT_BORDER_STD = 0.4
# Patches of width n have 1 + (this / n)^2 times the standard deviation EDGE_AREA_STD, cells. Set on rough contacts: the
# area inside the edge of patches of 1, 2, 4, 9, 18 cells errs by 0.48, 0.11, 0.06, 0.025, 0.017.
SMALL_PATCH_WIDTH = 2.0
# Relative standard deviation of the area of a patch of few cells, times the ratio over cells^(3/2). Set on rough
# contacts of two cells a shortest wave, by the parts of the fine contact in each: 0.15, 0.3, 0.37 for 1, 2 and 3 cells.
SMALL_PATCH_STD = 0.3
# Number of parts of an edge with the same error over the number of equal parts, both without the part itself. Set on
# waves of whole cells, whose errors follow no normal distribution, and on strips.
ALIKE_PARTS_FACTOR = 2.5
# Factor of that number on straight edges in an oblique direction, where errors cancel in each period. Set on strips.
OBLIQUE_PARTS_FACTOR = 0.5
# Standard deviation of traced areas that are weighted with Hertz's areas, over EDGE_AREA_STD, no unit. Set on rough
# contacts.
BLENDED_STD_FACTOR = 1.5
# Standard deviation of the excess of all edges together over that excess, times the root of the number of pieces with
# independent errors. Set on rough contacts, with a lay and without.
EXCESS_STD = 1.4
# Standard deviation of the position of the edge of a slender patch, cells, over (1 - width / cells)^6: on ridges of one
# direction, and on isotropic surfaces, where slender patches have merged. Set on rough contacts.
SLENDER_POSITION_STD = (0.036, 0.012)
# Rim ratio (`rim_ratio`) above which an edge has a sharp rim, the largest excess over it that counts, and the standard
# deviation of the position of such edges over this excess, cells. Set on flats that were run in.
RIM_POSITION_TERMS = (1.3, 1.5, 0.05)
# Excess of the area inside the edge, cells along it times the resolution ratio and its square.
# Measured patch by patch: 0.006, 0.016 and 0.05 cells with 8, 4 and 2 cells a shortest wave, with a lay and without.
EXCESS = (0.016, 0.004)
# Standard deviation of the position of an edge where half of the patch or more is saturated, cells.
# Set on rough contacts with a pressure limit; spheres at an overload of 1.7 to 2.2 measured 0.057.
SATURATED_POSITION_STD = 0.03
# Relative standard deviation of Hertz's area of a patch at its pressure limit. Set on spheres of 1 to 12 cells radius.
PLASTIC_ERROR = 0.0015
# Spread v0 up to which Hertz's error is in proportion to the spread, and its smallest value, no unit.
# Measured on balls and ellipses in domains of any shape, whose computed curvatures spread by 1e-7 to 1e-3: 0.16 v, and
# 0.6e-6 where v is less.
EVEN_SPREAD = 0.0014
MIN_HERTZ_ERROR = 1e-6
# Relative standard deviation of the area of a patch of n cells by its load, times n^(3/2), where the load does not
# follow from the approach. Measured on rough contacts: 0.24, 0.19, 0.25, 0.3 with 1, 2, 3 to 4, 5 to 8 cells.
LOAD_ERROR = 0.25
# Standard deviation of an area whose load was corrected, over the correction. Set on waves of 12.5 cells.
SHARED_LOAD_ERROR = 0.02
# Relative standard deviation of Hertz's area for heights that the grid hardly resolves, times the ratio to the fourth
# power, and the number of cells of a patch that halves it. Set on cones of one to four cells.
HERTZ_RESOLUTION_ERROR = (0.011, 10.0)
# Terms a, b of the relative standard deviation min(a s^4, b) of Hertz's area for a tip between the cell centres, where
# s is its sharpness (`find_sharpness`). Set on cones, whose areas err by up to 0.3 in patches of 1 to 6 cells.
TIP_ERROR = (25.0, 0.3)
# Excess of the counted area where the edge meets non-measured points that touch, cells for each such place, and its
# standard deviation, independent of each. Set on rough contacts with 2 to 10 % non-measured points: 0.31 for single
# ones, 0.46 for groups.
NON_MEASURED_EXCESS = 0.4
NON_MEASURED_PLACE_STD = 0.8
# Length of the edge that is not traced there, cells for each such place, and its standard deviation. Set on the same:
# 0.45 to 0.55 for single ones, 0.8 to 0.9 for groups.
NON_MEASURED_LENGTH = 0.65
NON_MEASURED_LENGTH_STD = 0.35

# --- benchmarks/layer_constants.py: spheres on layers, where E* depends on the wavelength ----------------------------

# Inverse wave number at which the edge meets E*, cells, and that at which a contact meets it, radii of the contact.
# Measured with 0.25, 0.5 and 1: rms error of the edge 0.025, 0.018, 0.057 cells; on layers of 1 and 3 cells, rms
# relative error of Hertz's area 0.18, 0.14, 0.34.
MODULUS_LENGTH = 0.5
# Standard deviation of the position of the edge, cells times the logarithm of the change of E* over two octaves.
# Measured on layers of 0.2 and 0.4 cells thickness: rms 0.093.
LAYERED_POSITION_STD = 0.1
# Relative standard deviation of Hertz's area, times the logarithm of the change of E* over two octaves. Measured: 0.31.
HERTZ_LAYERED_ERROR = 0.4

# --- benchmarks/image_constants.py: ellipses in domains that repeat, against four times finer grids -------------------

# Standard deviation of the curvature by another contact as a point load, over F / (pi E* r^3): times the sum of the
# squares of both major semi-axes over the square of the distance r, and its largest value. Set on 24 ellipses: over the
# smaller principal curvature, their areas err by 0.3 to 1.0 of the first, and by 0.05 to 0.11 of the second.
FAR_FIELD_ERROR = (0.7, 0.12)
# Relative standard deviation of Hertz's area in a wrapped domain, over the excess of the contact's length over half the
# side, relative to that half. Set on the same ellipses: 0.015 to 0.04.
WRAPPED_ERROR = 0.05
# Standard deviation of the curvature by a contact half of a wrapped domain away, over the jump of the slope divided by
# the length of the contact, where the jump passes through its centre. Set on two to five balls.
KINK_ERROR = 0.4

# --- benchmarks/quantity_classes.py: all other numbers on the tuned half of its classes, judged on the other half -----

# Relative excess of the square of the discrete maximum pressure over its bend and over the shift of the edge, 1/cells.
# Measured: 0.027 for Love's kernel, whose shift is 0.018, and none for "fourier".
PEAK_EXCESS = 1.5
# Largest bend in that product, no unit: beyond it a parabola through the cells has no meaning.
MAX_PEAK_BEND = 1.0
# Terms a, b, c of the relative standard deviation w (a + b s + c w^3) of a quadratic through p^2, of the larger
# principal bend w and the third difference s, both over p^2, no unit. Judged on 140 smooth contacts of 2.7 to 34 cells
# a wave: 99 % within two, u/e 3.
PEAK_ERROR = (0.005, 0.025, 0.006)
# Increase of the standard deviation by w at blunt summits, and the negative sharpness from which all of it is added, no
# unit. Set on tips r^3 and r^4.
BLUNT_PEAK_ERROR = 0.05
BLUNT_SHARPNESS = 0.1
# Factor of a along straight strips, whose cells have the same error, no unit.
STRIP_PEAK_FACTOR = 3.0
# Relative error (1 sd) of the maximum pressure by straight edges between the cells, over the 3/4 power of the bend
# of p^2, which is 1.7 (h/a)^1.5. And the standard deviation by the residual, over E* times the gap left in contact over
# the side of a cell. Set on lines on stiff and soft coatings, of 4 to 400 cells.
STRAIGHT_PEAK_STD = 0.004
RESIDUAL_PEAK_STD = 0.08
# Smallest relative standard deviation where a neighbour is open, in wide contacts times the square of the ratio up to
# one: of compact patches; its increase on ridges (twice on rows of single cells); and its increase times the number of
# cells; no unit.
OPEN_NEIGHBOUR_ERROR = (0.1, 0.12, 4.0)
# Relative standard deviation of the maximum pressure by the load on a long ridge: at least, and over the square of the
# ratio. Set on ridges of one to four cells: 0.001 to 0.06.
RIDGE_PEAK_ERROR = (0.02, 0.05)
# Relative standard deviation for tips: the sharpness from which a part of it is added, the sharpness from which all of
# it is added, and its size times the fourth root of the number of cells; no unit. Set on r^1.5.
TIP_PEAK_ERROR = (0.3, 0.36, 0.45)
# The same for tips that only the gap shows: its size where they are as pointed (`fit_hyperboloid`) as the second
# number, and its slope beyond. Set on r^1.25, r^1.5 and r^1.75.
POINTED_PEAK_ERROR = (0.4, 0.4, 6.0)
# Number that is added to the ratio by which the sharpness is divided, so that rounding does not count.
MIN_RESOLUTION_RATIO = 0.01
# Relative standard deviation of a summit's maximum pressure beside that of its area, and its increase at a free border;
# no unit.
MIN_SUMMIT_ERROR = 2e-5
BORDER_SUMMIT_ERROR = 4e-4
# Length lost along an edge of several summits, relative, times the resolution ratio to the power 3/2; half of it is
# uncertain.
LOST_LENGTH = 0.05
# Relative standard deviation of the length of smooth edges, and of edges of several summits times the ratio, no unit.
LENGTH_ERROR = 0.003
UNEVEN_LENGTH_ERROR = 0.025
# Relative length of narrow patches that is lost at their ends, on ridges of one direction along a diagonal of the
# grid, half of which is uncertain, no unit. Set on rough contacts with a lay.
LOST_END_LENGTH = 0.75
# Width of patches, in cells of a disc, that halves it, by its square. Set on the same contacts.
NARROW_PATCH_WIDTH = 4.0
# Relative standard deviation of the length of an edge along the diagonals of the grid, no unit.
DIAGONAL_LENGTH_ERROR = 0.045
# Relative standard deviation of the length by the sides of cells, no unit.
COUNTED_LENGTH_ERROR = 0.1
# Spread of the curvature above which a patch may be part of another one, no unit.
UNEVEN_SPREAD = 0.3
# Number of patches, no unit: variance for each of fewer than nine cells; standard deviation for each of fewer than four
# cells and for each of all, times the resolution ratio.
MISSING_PATCH_TERMS = (0.15, 0.2, 0.1)
# Standard deviation of the number of patches for each of them on maps that are linear between points. Set on such maps.
LINEAR_PATCH_STD = 0.06
# Excess of the mean gap over h^2 times the mean curvature under the contact, over the shift of the edge, 1/cells.
GAP_EXCESS = 1.7
# Cells of a patch that has half of that excess.
HALF_EXCESS_CELLS = 10.0
# Standard deviation of the mean gap over h^2 times that curvature: of one patch; of one patch, times the root of its
# cells; no unit.
PATCH_GAP_STD = 0.012
SMALL_PATCH_GAP_STD = 0.15
# The same of one patch over the square of the fraction of the load on saturated cells and over the fourth root of its
# cells, as the error of an edge between whole cells grows, no unit.
SATURATED_GAP_STD = 0.08
# The same where the edge runs along whole rows of cells, which have the same error, and where it is straight in an
# oblique direction, no unit. Set on strips.
ALIGNED_GAP_STD = 0.07
OBLIQUE_GAP_STD = 0.02
# Standard deviation of the approach over the mean height of creases above the cells, where the contact across them is
# narrow, and the largest second difference beside a crease over the sum of the two at it, no unit. Set on turned and
# shot-peened surfaces; smooth rough ones have no such creases.
CREASE_STD = 0.8
MAX_BEND_BESIDE = 0.2
# Standard deviation of the approach over the sum of p^2 h^2 b / (E* F) over the sides of cells at sharp edges, h across
# and b along them, no unit. Set on pillars and plateaus; an edge that is off by 0.22 h moves it by as much (exact).
SHARP_EDGE_STD = 0.35
# Rim ratios between which the rims of flats that were run in become sharp.
RIM_RATIOS = (1.5, 2.5)
# Excess of the mean gap over h^2 times the curvature at sharp rims, over the ratio and over the fourth root of the
# cells of a patch, and its standard deviation, no unit. Set on surfaces that were run in.
RIM_GAP_EXCESS = (-0.013, 0.014)
# The same for heights that are linear between points, and over the fraction of the load on filled cells (the standard
# deviation over the root of this fraction).
LINEAR_GAP_EXCESS = (-0.09, 0.015)
FILLED_GAP_EXCESS = (-1.5, 0.2)
# Ratio, up to one, of that excess near full contact to the open part of the domain, and the smallest such ratio for its
# standard deviation, no unit. Set on waves, strips and rough surfaces at 12 to 97 % contact: with 2.2 for 1.5 the mean
# gap of rough surfaces erred twice as much.
FADING_FACTOR = 1.5
MIN_FADING = 0.3
# Excess of the approach where the contact is cut, by a free border and by points that were not measured, over the sum
# of p^2 h^2 b / (E* F) over the sides of cells there, h across and b along them, and its standard deviation; no unit.
# Set on rough contacts: 0.09 to 0.34 at borders, 0.02 to 0.07 at single points, 0.03 to 0.14 at groups of them.
CUT_BORDER_EXCESS = (0.2, 0.07)
CUT_NON_MEASURED_EXCESS = (0.06, 0.03)
# Length of the edge that is not traced where it meets a border that cuts the contact, cells for each such place, and
# its standard deviation. Set on rough contacts.
UNTRACED_CUT_LENGTH = (0.9, 0.6)
# Relative standard deviation of the height of a tip, no unit.
TIP_RISE_ERROR = 0.03
# Relative standard deviation of the height of the top of creased summits, no unit. Set on shot-peened and turned
# surfaces.
CREASED_RISE_STD = 0.2
# Deficit of the height of a tip between a cone and a paraboloid by polynomials, over how pointed it is: the fraction of
# the second differences that is added to the height, set on tips r^1.25 to r^1.75, and the relative standard deviation
# of the deficit: bumps like a Gaussian may look pointed and have none.
TIP_RISE_DEFICIT = (0.06, 0.55)
# Resolution ratios between which the summits between the cells are lost.
UNRESOLVED_RATIOS = (1.4, 2.0)
# Standard deviation of the height of the highest summit over h^2 times the curvature under the contact: where they are
# lost, and over the root of the fraction of the load on filled cells, no unit; at sharp rims that of the mean gap.
HIDDEN_RISE_STD = (0.05, 0.5)
# Excess of the length of a sharp edge through the middles of the sides of its cells, half of the 5.5 % that it has on
# average in all directions and does not have along the grid, and its relative standard deviation. Set on round, square
# and turned pillars, lands and dimples of 20 to 200 cells a side. Both grow with the logarithm of the ratio of the
# sides of a cell, as the 5.5 % to 12 % at 1 : 3.
SHARP_LENGTH_EXCESS = 0.026
SHARP_LENGTH_ERROR = 0.045
# Standard deviation of the length over the difference from pi/4 of the sides of the cells, which is right for networks
# of ridges. Set on craters, ground and smooth surfaces.
COUNTED_DIFFERENCE = 0.5
