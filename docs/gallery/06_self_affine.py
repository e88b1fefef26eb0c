"""
A synthetic surface
===================

A self-affine surface beside its spectrum, bearing curve and autocorrelation.
"""

import roughcontact as rc

surface = rc.SelfAffineSurface(hurst=0.8, rms_height=0.2e-6, shortest=2e-6, longest=100e-6, rolloff=20e-6, seed=1)
# sphinx_gallery_thumbnail_number = 2
surface.plot(rc.Grid((256, 256), 100e-6))

# %%
# With a lay: Peklenik's number is the ratio of the correlation lengths along and across it.
ground = rc.SelfAffineSurface(
    hurst=0.8, rms_height=0.2e-6, shortest=2e-6, longest=100e-6, rolloff=20e-6, peklenik=8, seed=1
)
ground.plot(rc.Grid((256, 256), 100e-6), "map")
