"""The paper on the grid dependence of the real contact area, recomputed.

Section 3.1, a wavy surface on a rigid flat: `wave`, `wave_tables`, `wave_figures`. Section 3.2, a ball on a
ring: `synthetic_pair`, `pair_tables`, `pair_figures`. The printed values are in `published`.
"""
