"""The parts keep what the kit claims of any of their kind."""

from __future__ import annotations

import pytest
import roughcontact as rc
from roughcontact.testing import claims

from roughcontact_layered import (
    Anisotropic,
    AnisotropicKernel,
    GradedKernel,
    Layer,
    LayeredKernel,
    TransverselyIsotropic,
)

SILICON = Anisotropic.cubic(165.7e9, 63.9e9, 79.6e9, normal=(1, 1, 1), x_axis=(1, -1, 0))
FIBRES = TransverselyIsotropic(c11=300e9, c12=90e9, c13=60e9, c33=900e9, c44=80e9)
KERNELS = [
    LayeredKernel(layers=(Layer(young=420e9, poisson=0.25, thickness=2e-6),), substrate=rc.Elastic(210e9, 0.3)),
    LayeredKernel(Layer(210e9, 0.3, 2e-6, conductivity=2.0), substrate=rc.Elastic(210e9, 0.3)).conduction_kernel(45.0),
    LayeredKernel(layers=Layer(young=420e9, poisson=0.25, thickness=2e-6), substrate=rc.Rigid()),
    GradedKernel(gradient=2e5, surface=rc.Elastic(210e9, 0.3)),
    AnisotropicKernel(SILICON),
    AnisotropicKernel(Anisotropic(FIBRES.stiffness, normal=(1, 0, 0), x_axis=(0, 0, 1))),
]


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: type(kernel).__name__)
@pytest.mark.parametrize("claim", claims("kernel"), ids=str)
def test_kernels_conform(claim, kernel):
    claim.check(kernel)


@pytest.mark.parametrize("material", [SILICON, FIBRES], ids=lambda material: type(material).__name__)
@pytest.mark.parametrize("claim", claims("material"), ids=str)
def test_materials_conform(claim, material):
    claim.check(material)
