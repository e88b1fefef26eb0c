"""The constants of maximum pressure, perimeter, patches, approach and mean gap: meaning and unit.

Fitted to the tuned classes of `benchmarks/quantity_classes.py`, which judges them again on the classes held out. The
ratio is the resolution ratio of `curvature_resolution`; the bend of p^2 is -h^2 times its laplacian over p^2.
"""

# Relative excess of the square of the discrete maximum pressure over its bend and over the shift of the edge, 1/cells.
# Measured: 0.027 for Love's kernel, whose shift is 0.018, and none for "fourier".
PEAK_EXCESS = 1.5
# Largest bend in that product, no unit: beyond it a parabola through the cells has no meaning.
MAX_PEAK_BEND = 1.0
# Terms a, b, c, d of the relative standard deviation w (a + b w + c s + d w^3) of a quadratic through p^2 of the larger
# principal bend w and the third difference s, both over p^2, no unit.
PEAK_ERROR = (0.005, 0.009, 0.036, 0.006)
# Increase of b at blunt summits, and the negative sharpness from which all of it is added, no unit.
BLUNT_PEAK_ERROR = 0.05
BLUNT_SHARPNESS = 0.1
# Factor of a along straight strips, whose cells have the same error, no unit.
STRIP_PEAK_FACTOR = 3.0
# Relative error (1 sd) of the maximum pressure by straight edges between the cells, over the 3/4 power of the bend
# of p^2, which is 1.7 (h/a)^1.5. And the standard deviation by the residual, over E* times the gap left in contact over
# the side of a cell. Set on lines on stiff and soft coatings, of 4 to 400 cells.
STRAIGHT_PEAK_STD = 0.004
RESIDUAL_PEAK_STD = 0.08
# Smallest relative standard deviation where a neighbour is open: of compact patches; its increase on ridges (twice on
# rows of single cells); and its increase times the number of cells; no unit.
OPEN_NEIGHBOUR_ERROR = (0.1, 0.12, 4.0)
# Relative standard deviation for tips: the sharpness from which a part of it is added, the sharpness from which all of
# it is added, and its size times the fourth root of the number of cells; no unit. Set on r^1.5.
TIP_PEAK_ERROR = (0.3, 0.36, 0.45)
# The same for tips that only the gap shows: its size where they are as pointed (`fit_hyperboloid`) as the second
# number, and its slope beyond. Set on r^1.25, r^1.5 and r^1.75.
POINTED_PEAK_ERROR = (0.4, 0.4, 6.0)
# Number that is added to the ratio by which the sharpness is divided, so that rounding does not count.
MIN_RESOLUTION_RATIO = 0.01
# Relative standard deviation of a summit's maximum pressure: its smallest value, its ratio to that of the area, and its
# increase at a free border; no unit.
MIN_SUMMIT_ERROR = 2e-5
SUMMIT_ERROR_FACTOR = 0.9
BORDER_SUMMIT_ERROR = 4e-4
# Length lost along an edge of several summits, relative, times the resolution ratio to the power 3/2; half of it is
# uncertain.
LOST_LENGTH = 0.05
# Relative standard deviation of the length of smooth edges, and of edges of several summits times the ratio, no unit.
LENGTH_ERROR = 0.003
UNEVEN_LENGTH_ERROR = 0.025
# The same of edges of several summits, independent of the ratio, no unit.
LOBED_LENGTH_ERROR = 0.007
# Relative standard deviation of the length of narrow patches over the ratio: on ridges of one direction, and on
# isotropic surfaces, no unit. Set on rough contacts with a lay and without.
NARROW_LENGTH_ERROR = (0.3, 0.04)
# Width of patches, in cells of a disc, that halves it. Set on the same contacts.
NARROW_PATCH_WIDTH = 100.0
# Relative standard deviation of the length of an edge along the diagonals of the grid, no unit.
DIAGONAL_LENGTH_ERROR = 0.045
# Width of strips in contact or open between them that doubles it, cells. Set on oblique strips.
DIAGONAL_STRIP_WIDTH = 2.0
# Relative standard deviation of the length by the sides of cells, no unit.
COUNTED_LENGTH_ERROR = 0.1
# Spread of the curvature above which a patch may be part of another one, no unit.
UNEVEN_SPREAD = 0.3
# Number of patches, no unit: variance for each of fewer than nine cells; standard deviation for each of fewer than four
# cells and for each of all, times the resolution ratio.
MISSING_PATCH_TERMS = (0.15, 0.2, 0.1)
# The same: variance on ridges of one direction, whose contacts may be narrower than a cell; standard deviation for each
# contact at a summit between the cells. Relative standard deviation of the length of the edges of these contacts.
RIDGE_PATCH_VARIANCE = 0.5
HIDDEN_PATCH_STD = 0.2
HIDDEN_LENGTH_ERROR = 0.1
# Standard deviation of the number of patches for each of them on maps that are linear between points. Set on such maps.
LINEAR_PATCH_STD = 0.06
# Excess of the mean gap over h^2 times the mean curvature under the contact, over the shift of the edge, 1/cells.
GAP_EXCESS = 1.7
# Cells of a patch that has half of that excess.
HALF_EXCESS_CELLS = 10.0
# Standard deviation of the mean gap over h^2 times that curvature: common to all patches; of one patch; of one patch,
# times the root of its cells, where all are equal and where they differ; and over the ratio; no unit.
COMMON_GAP_STD = 0.002
PATCH_GAP_STD = 0.012
SMALL_PATCH_GAP_STD = (0.15, 0.1)
UNRESOLVED_GAP_STD = 0.008
# The same of one patch over the square of the fraction of the load on saturated cells and over the fourth root of its
# cells, as the error of an edge between whole cells grows, no unit.
SATURATED_GAP_STD = 0.08
# The same where the edge runs along whole rows of cells, which have the same error, and where it is straight in an
# oblique direction, no unit. Set on strips.
ALIGNED_GAP_STD = 0.07
OBLIQUE_GAP_STD = 0.02
# Resolution ratio from which the standard deviation of the mean gap grows with the root of the kurtosis of the second
# differences under the contact, and the largest factor. Set on pillars, mesas, dimples, craters and rounded flats.
MIN_CREASE_RATIO = 1.3
MAX_CREASE_FACTOR = 3.0
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
# standard deviation, no unit. Set on a wave and a rough surface at 35 to 97 % contact.
FADING_FACTOR = 2.2
MIN_FADING = 0.3
# Excess of the approach where the contact is cut, by a free border and by points that were not measured, over the sum
# of p^2 h^2 b / (E* F) over the sides of cells there, h across and b along them, and its standard deviation; no unit.
# Set on rough contacts: 0.09 to 0.34 at borders, 0.02 to 0.07 at single points, 0.03 to 0.14 at groups of them.
CUT_BORDER_EXCESS = (0.2, 0.07)
CUT_NON_MEASURED_EXCESS = (0.06, 0.03)
# Length of the edge that is not traced where it meets a border that cuts the contact, cells for each such place, and
# its standard deviation. Set on rough contacts.
UNTRACED_CUT_LENGTH = (0.9, 0.6)
# Power of the open part of the domain in the change of the mean gap by a cut, no unit.
CUT_GAP_EXPONENT = 1.5
# Relative standard deviation of the deficit of the mean over cell centres on a free domain. Set on balls.
MEAN_CORRECTION_ERROR = 0.1
# Standard deviation of the height of a summit over the difference of its heights by polynomials of sixth and eighth
# order, and relative standard deviation of the height of a tip, no unit.
RISE_ERROR = 1.5
TIP_RISE_ERROR = 0.03
# Deficit of the height of a tip between a cone and a paraboloid by polynomials, over how pointed it is: the fraction of
# the second differences that is added to the height, and the relative standard deviation of the deficit. Set on tips
# r^1.25 to r^1.75.
TIP_RISE_DEFICIT = (0.06, 0.4)
# Resolution ratios between which the summits between the cells are lost.
UNRESOLVED_RATIOS = (1.4, 2.0)
# Standard deviation of the height of the highest summit over h^2 times the curvature under the contact: where they are
# lost, at sharp rims as above, and over the root of the fraction of the load on filled cells, no unit.
HIDDEN_RISE_STD = (0.05, 0.014, 0.5)
# Length of a sharp edge over that through the middles of the sides of its cells, which eight directions make 5.5 % too
# long on average and none along the grid, and its relative standard deviation. Set on round, square and turned pillars,
# lands and dimples of 50 to 200 cells a side.
SHARP_LENGTH = 0.974
SHARP_LENGTH_ERROR = 0.03
# Growth of that with the logarithm of the ratio of the sides of a cell; set on the same with cells of 1:3 and 3:1.
SLENDER_LENGTH_ERROR = 1.7
# Standard deviation of the length over the difference from pi/4 of the sides of the cells, which is right for networks
# of ridges. Set on craters, ground and smooth surfaces.
COUNTED_DIFFERENCE = 0.5
