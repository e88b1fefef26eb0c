"""
A ball on fibres
================

A rigid ball on a composite of carbon fibres along x, by the plug-in ``roughcontact-layered``: the contact is shorter
along the fibres, where the body is stiffer. The dashed circle is that of a kernel with the mean modulus.
"""

import matplotlib.pyplot as plt

import roughcontact as rc
from roughcontact_layered import Anisotropic, AnisotropicKernel, TransverselyIsotropic

across_fibres = TransverselyIsotropic(c11=15e9, c12=7e9, c13=6e9, c33=235e9, c44=15e9)  # axis 3 along the fibres
fibres = Anisotropic(across_fibres.stiffness, normal=(1, 0, 0), x_axis=(0, 0, 1))
bodies = rc.Body(rc.ParaboloidSurface(radius=1e-3), rc.Rigid()), rc.Body(rc.FlatSurface(), fibres)
grid = rc.Grid((128, 128), 120e-6)
solution = rc.ContactProblem(*bodies, grid=grid, kernel=AnisotropicKernel(fibres)).solve(force=1.0)
mean = rc.ContactProblem(*bodies, grid=grid).solve(force=1.0)
print(solution.area())
with rc.plotting.style():
    figure, axes = plt.subplots(figsize=(5, 4), layout="constrained")
    for name, one, style in (("fibres along x", solution, "-"), ("mean modulus", mean, "--")):
        (line,) = rc.LevelSet().contours(one)
        axes.plot(*(1e6 * line.T), style, color="C0", label=name)
    axes.legend(loc="center")
    axes.set(xlabel="x, along the fibres, µm", ylabel="y, µm", aspect="equal")
