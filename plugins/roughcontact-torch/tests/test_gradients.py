"""The wrapper for torch's reverse mode in docs/use/gradients.md."""

import re
from pathlib import Path

import numpy as np
import roughcontact as rc

PAGE = Path(__file__).parents[3] / "docs" / "use" / "gradients.md"


def test_the_wrapper_hands_on_the_gradient():
    (script,) = re.findall(r"```python torch\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    names = {}
    exec(script, names)
    heights = names["heights"]
    surface = rc.HeightMap(heights.detach().numpy(), size=names["SIZE"], periodic=True)
    solution = rc.ContactProblem(rc.Body(surface, names["STEEL"]), boundary="periodic").solve(pressure=200e6)
    gradient = solution.gradient(lambda pressure: 4 * pressure**3)
    assert np.allclose(heights.grad.numpy(), gradient, rtol=1e-9, atol=1e-9 * np.abs(gradient).max())
