import contextlib
import html
import io
import re

import numpy as np
import pytest
import roughcontact as rc
from roughcontact._faces.html import report

from roughcontact_layered import Anisotropic, AnisotropicKernel, GradedKernel, Layer, LayeredKernel

STEEL = rc.Elastic(young=200e9, poisson=0.3)
SILICON = Anisotropic.cubic(165.7e9, 63.9e9, 79.6e9, normal=(1, 1, 0), x_axis=(0, 0, 1))


@pytest.mark.parametrize(
    ("kernel", "material", "other"),
    [
        (LayeredKernel(Layer(young=400e9, poisson=0.25, thickness=2e-6), substrate=STEEL), STEEL, "wavelength"),
        (GradedKernel(gradient=1e5, surface=STEEL), STEEL, "wavelength"),
        (AnisotropicKernel(SILICON), SILICON, "direction"),
    ],
    ids=lambda part: type(part).__name__,
)
def test_a_report_runs_the_contact_again_to_the_last_bit(monkeypatch, kernel, material, other):
    monkeypatch.setattr(report, "can_draw", lambda: False)
    body = rc.Body(rc.WavySurface(amplitude=0.1e-6, wavelength=12.5e-6), material)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 25e-6), boundary="periodic", kernel=kernel)
    solution = problem.solve(pressure=100e6)
    page = solution.to_html()
    script = html.unescape(re.search(r"<pre><code>(.*?)</code></pre>", page, re.S)[1])
    assert "import roughcontact_layered\n" in script
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(script, names)
    np.testing.assert_array_equal(names["solution"].pressure, solution.pressure)
    assert f"another for each {other}" in page
