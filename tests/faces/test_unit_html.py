"""Parts of a report: what to cite, numbers of a script, and texts that are escaped."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from roughcontact._faces.html.words import escape, typeset
from roughcontact._solve.problem import write_number

ROOT = Path(__file__).parents[2]


def test_numbers_are_exact_and_short():
    for value, text in ((200e9, "200e9"), (12.5e-6, "12.5e-6"), (5e-7, "500e-9"), (0.3, "0.3"), (-0.0, "-0.0")):
        assert write_number(value) == text
    rng = np.random.default_rng(1)
    for value in rng.standard_normal(300) * 10.0 ** rng.integers(-300, 300, 300):
        assert float(write_number(value)) == value
    assert eval(write_number(np.inf)) == np.inf


def test_units_are_raised_and_texts_escaped():
    assert typeset("(1.0 +- 0.1) % of nominal, 360 µm2 [a<b]") == "(1.0 ± 0.1) % of nominal, 360 µm² [a<b]"
    assert typeset("2 mm3/s, 5 W/(m2 K)") == "2 mm³/s, 5 W/(m² K)"
    assert escape("a\x00\x1b\ufffe\udc80<b\n") == "a????&lt;b\n"
