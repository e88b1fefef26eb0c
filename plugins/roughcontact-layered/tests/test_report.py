import contextlib
import html
import io
import re

import numpy as np
import roughcontact as rc
from roughcontact._faces.html import report

from roughcontact_layered import Layer, LayeredKernel


def test_a_report_runs_a_layered_contact_again_to_the_last_bit(monkeypatch):
    monkeypatch.setattr(report, "can_draw", lambda: False)
    steel = rc.Elastic(young=200e9, poisson=0.3)
    kernel = LayeredKernel(Layer(young=400e9, poisson=0.25, thickness=2e-6), substrate=steel)
    body = rc.Body(rc.WavySurface(amplitude=0.1e-6, wavelength=12.5e-6), steel)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 25e-6), boundary="periodic", kernel=kernel)
    solution = problem.solve(pressure=100e6)
    page = solution.to_html()
    script = html.unescape(re.search(r"<pre><code>(.*?)</code></pre>", page, re.S)[1])
    assert "import roughcontact_layered.kernel" in script
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(script, names)
    np.testing.assert_array_equal(names["solution"].pressure, solution.pressure)
    assert "another for each wavelength" in page
