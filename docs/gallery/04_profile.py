"""
A cut through both bodies
=========================

The deformed surfaces and the pressure along one line.
"""

import roughcontact as rc

surface = rc.SphereSurface(2e-3) + rc.SelfAffineSurface(
    hurst=0.8, rms_height=50e-9, shortest=4e-6, longest=50e-6, rolloff=25e-6, seed=2
)
ball = rc.Body(surface, rc.Elastic(young=210e9, poisson=0.3))
solution = rc.ContactProblem(ball, grid=rc.Grid((192, 192), 150e-6)).solve(force=2.0)
solution.plot("profile")
