"""
A solution at one sight
=======================

Heights, pressure with the edge of the contact, gap, and contact patches.
"""

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=2e-6, longest=50e-6, rolloff=25e-6, seed=4)
steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
problem = rc.ContactProblem(rc.Body(surface, steel), grid=rc.Grid((256, 256), 100e-6), boundary="periodic")
solution = problem.solve(pressure=200e6)


def draw(dark=False):
    """Draw a small figure, in which letters are large."""
    figure = solution.plot(dark=dark)
    figure.set_size_inches(5.8, 5.3)
    figure.suptitle(figure.get_suptitle().replace(" at ", "\nat "))


# sphinx_gallery_thumbnail_number = 1
draw()

# %%
# The same for a dark page.
draw(dark=True)
