"""
The law of a joint
==================

Thermal conductance of a rough steel joint over the pressure, for a program of finite elements.
"""

import numpy as np

import roughcontact as rc

steel = rc.Elastic(young=210e9, poisson=0.3)
surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=6e-6, longest=200e-6, rolloff=25e-6, seed=2)
problem = rc.ContactProblem(
    rc.Body(surface, steel), rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((128, 128), 200e-6), boundary="periodic"
)
law = rc.interface_law(problem, np.geomspace(20e6, 400e6, 6), [rc.responses.create("conductance", 45.0)])
print(law)

# %%
# ``law.to_abaqus``, ``to_calculix`` and ``to_moose`` write it.
law.plot("conductance")
