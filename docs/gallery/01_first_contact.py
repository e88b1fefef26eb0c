"""
First contact
=============

A ball on a flat: the certified solution beside Hertz's closed form.
"""

import roughcontact as rc

grid = rc.Grid((128, 128), 100e-6)  # cells, side in m
ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
solution = rc.ContactProblem(ball, rc.RIGID_FLAT, grid=grid).solve(force=1.0)  # N
print(solution)

# %%
# Hertz's area differs from ours by less than the stated uncertainty.
hertz = rc.reference.hertz_sphere(force=1.0, radius=1e-3, modulus=solution.modulus)
area = solution.area()
print(f"ours {area.value:.5g} +- {area.uncertainty:.1g} m2, Hertz {hertz.area:.5g} m2")

# %%
# The pressure, with the edge of the contact between the cells.
solution.plot("pressure")
