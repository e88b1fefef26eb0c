"""The measured constants of the area estimators: meaning, unit, how each was measured, and the script that repeats it.

The ratio is the resolution ratio of `curvature_resolution`; the width of a patch is in cells of a disc as wide.
"""

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

# Standard deviation of the place of a straight edge along the grid, cells: constant, and terms over the width of the
# contact and of the gap beyond, in cells. Measured on cylinders of 6 to 30 cells half width, and on waves.
STRAIGHT_POSITION_STD = (0.002, 0.1, 0.3)
# Places of such edges between the centres of the last cell in contact and the next, in cells: the first and the step of
# the true ones, and those of the traced polygons. Measured on cylinders of 1600 cells half width, the same on waves;
# beyond the last the next cell is in contact.
STRAIGHT_EDGE_START = -0.15
STRAIGHT_EDGE_STEP = 0.025
STRAIGHT_EDGE_PLACES = (
    0,
    0.0016,
    0.0038,
    0.0072,
    0.0117,
    0.0176,
    0.0248,
    0.0336,
    0.0439,
    0.0557,
    0.0691,
    0.0841,
    0.1005,
    0.1184,
    0.1376,
    0.1581,
    0.1797,
    0.2024,
    0.2261,
    0.2507,
    0.2762,
    0.3023,
    0.3292,
    0.3568,
    0.385,
    0.4139,
    0.4433,
    0.4735,
    0.5043,
    0.5359,
    0.5683,
    0.6017,
    0.6363,
    0.6722,
    0.71,
    0.7501,
    0.7935,
    0.8418,
    0.8995,
    0.9944,
    1,
)

# --- benchmarks/limit_constants.py: spheres at a pressure limit ------------------------------------------------------

# Overloads of the next table: Hertz's maximum pressure over the pressure limit, no unit.
OVERLOADS = (1.0, 1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 1.85, 2.0, 2.2, 2.6, 3.0)
# Contact area of a sphere at these overloads over Hertz's area, no unit; beyond, two thirds of the overload.
# Measured on spheres of 40 cells elastic radius: within 0.0015.
PLASTIC_GROWTH = (1.0, 1.0006, 1.003, 1.0143, 1.034, 1.0625, 1.098, 1.187, 1.267, 1.355, 1.4805, 1.737, 2.0)

# --- benchmarks/rough_constants.py: self-affine surfaces of 2 to 8 cells a shortest wave against 32 cells -------------

# Excess of the area inside the edge, cells along the edge times the resolution ratio.
# Measured on 4 surfaces at 3 loads: 0.030, scatter 0.009.
EXCESS = 0.03
# The same after extrapolation, cells along the edge times the square of the ratio. Measured: 0.011, scatter 0.005.
EXCESS_REFINED = 0.009
# Relative standard deviation of the area for summits between the grid points, for the fraction of the area in patches
# of fewer than four cells, times the square of the ratio. Measured at 2 cells a shortest wave: maximum 0.115.
UNSEEN_STD = 0.12
# Relative standard deviation of the area of a patch of few cells, times the ratio over cells^(3/2).
# Measured for 1, 2 and 3 cells, by the parts of the fine contact in each: median 0.15, 0.30, 0.37.
SMALL_PATCH_STD = 0.3
# Terms a, b, c of Hertz's relative standard deviation a v / (v + v0) + b v^2 + c v^4 where v is the spread of the
# curvature, no unit; v0 is EVEN_SPREAD.
# Measured on patches of at least 150 cells: rms 0.009, 0.015, 0.06, 0.16, 0.29 (in use: 0.016, 0.03, 0.06, 0.12, 0.32)
# at v of 0.15 to 0.3, to 0.4, to 0.6, to 0.8, to 1.2.
HERTZ_ERROR = (0.0003, 0.2, 0.1)
# Fraction of that standard deviation that is common to all patches, no unit.
# Measured: 0.23 at v below 0.3, before HERTZ_DEFICIT corrected most of the common error.
HERTZ_COMMON_FRACTION = 1.0 / 3.0

# --- benchmarks/area_classes.py: the tuned half of the classes of contacts --------------------------------------------

# Standard deviation of the position of all edges, cells. Set on rough contacts of 6 to 12 cells a shortest wave.
EDGE_POSITION_STD = 0.0011
# Its relative increase on ridges of one direction, and the power of the lay ratio in the number of pieces of the edges
# with independent errors. Set on rough contacts with a lay along the grid.
LAY_POSITION_FACTOR = 0.7
LAY_PIECES_EXPONENT = 1.5
# Standard deviation of the area for each cell in contact at a free border before which the contact ends, cells. Set on
# balls that nearly touch the border.
UNCUT_BORDER_STD = 0.4
# Standard deviation of the area for each point beside the edge whose height was filled in, cells. Set on rough contacts
# with 1 to 5 % filled points.
FILLED_POINT_STD = 0.4
# Patches of width n have 1 + (this / n)^2 times the standard deviation EDGE_AREA_STD, cells. Set on rough contacts: the
# area inside the edge of patches of 1, 2, 4, 9, 18 cells errs by 0.48, 0.11, 0.06, 0.025, 0.017.
SMALL_PATCH_WIDTH = 2.0
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
# Excess of the mean of the traced and the extrapolated area, cells along the edge times the ratio and its square.
# Measured patch by patch: 0.006, 0.016 and 0.05 cells with 8, 4 and 2 cells a shortest wave, with a lay and without.
EXCESS_HALF = (0.016, 0.004)
# Standard deviation of the position of an edge where half of the patch or more is saturated, cells.
# Set on rough contacts with a pressure limit; spheres at an overload of 1.7 to 2.2 measured 0.057.
SATURATED_POSITION_STD = 0.03
# Relative standard deviation of Hertz's area of a patch at its pressure limit: constant, and a part over its
# cells. Set on spheres of 1 to 12 cells radius.
PLASTIC_ERROR = (0.0015, 0.05)
# Spread v0 up to which Hertz's error is in proportion to the spread, and its smallest value, no unit.
# Measured on balls and ellipses in domains of any shape, whose computed curvatures spread by 1e-7 to 1e-3: 0.16 v, and
# 0.6e-6 where v is less.
EVEN_SPREAD = 0.0014
MIN_HERTZ_ERROR = 1e-6
# Deficit of the approach of the larger patches of a discrete solution, over their curvature times the area of a cell.
# Measured: 0.04 on spheres of 4 to 40 cells, 0.02 to 0.03 for the loads of the small patches of rough contacts.
APPROACH_DEFICIT = 0.026
# Standard deviation of that deficit, times the fraction of the load on patches whose load does not follow from the
# approach. Set on the small patches of rough contacts.
APPROACH_DEFICIT_STD = 0.04
# Relative standard deviation of the area of a patch of n cells by its load, times n^(3/2), where the load does not
# follow from the approach. Measured on rough contacts: 0.24, 0.19, 0.25, 0.3 with 1, 2, 3 to 4, 5 to 8 cells.
LOAD_ERROR = 0.25
# Standard deviation of an area whose load was corrected, over the correction. Set on waves of 12.5 cells.
SHARED_LOAD_ERROR = 0.02
# Relative standard deviation of Hertz's area for heights that the grid hardly resolves, times the ratio to the fourth
# power, and the number of cells of a patch that halves it. Set on cones of one to four cells.
HERTZ_RESOLUTION_ERROR = (0.011, 10.0)
# Terms a, b of the relative standard deviation min(a s^4, b) of Hertz's area for a tip between the cell centres, where
# s is its sharpness (`find_sharpness`), and the number of cells up to which a patch has it. Set on cones, whose areas
# err by up to 0.3 in patches of 1 to 6 cells.
TIP_ERROR = (25.0, 0.3)
MAX_TIP_CELLS = 6
# Excess of the counted area where the edge meets non-measured points that touch, cells for each such place, and its
# standard deviations: common to all places, and independent of each. Set on rough contacts with 2 to 10 % non-measured
# points: 0.31 for single ones, 0.46 for groups.
NON_MEASURED_EXCESS = 0.4
NON_MEASURED_STD = 0.1
NON_MEASURED_PLACE_STD = 0.8
# Length of the edge that is not traced there, cells for each such place, and its standard deviation. Set on the same:
# 0.45 to 0.55 for single ones, 0.8 to 0.9 for groups.
NON_MEASURED_LENGTH = 0.65
NON_MEASURED_LENGTH_STD = 0.35
# Relative standard deviation of the areas of contacts that have no cell. Set on rough contacts.
HIDDEN_AREA_ERROR = 0.2
# Terms a, b, c of the deficit of Hertz's area a v^4 / ((b + v^2) (1 + c v^2)), relative. Measured on rough contacts of
# 8 cells a shortest wave: 0.013, 0.02, 0.03, 0.04 at a spread v of 0.35, 0.45, 0.6, 0.85.
HERTZ_DEFICIT = (0.15, 0.02, 2.5)

# --- benchmarks/layer_constants.py: spheres on layers, where E* depends on the wavelength ----------------------------

# Inverse wave number at which the edge meets E*, cells.
# Measured: rms error of the edge 0.025, 0.018, 0.057 cells with 0.25, 0.5 and 1.
EDGE_LENGTH = 0.5
# Standard deviation of the position of the edge, cells times the logarithm of the change of E* over two octaves.
# Measured on layers of 0.2 and 0.4 cells thickness: rms 0.093.
LAYERED_POSITION_STD = 0.1
# Inverse wave number at which a contact meets E*, radii of the contact.
# Measured on layers of 1 and 3 cells: rms relative error of the area 0.18, 0.14, 0.34 with 0.25, 0.5 and 1.
HERTZ_LENGTH = 0.5
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
