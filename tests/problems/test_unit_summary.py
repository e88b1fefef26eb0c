"""The texts of a solution: short ones, numbers with their spread."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._base.units import PlainText, with_spread
from roughcontact._solve.solution import summary
from test_summary import rough_problem


class TestShort:
    def test_a_large_solution_is_not_estimated_for_one_line(self, monkeypatch):
        solution = rough_problem().solve(pressure=1e8)
        monkeypatch.setattr(summary, "_MAX_REPR_CELLS", 100)
        monkeypatch.setattr(rc.ContactSolution, "area", lambda self: pytest.fail("the area was estimated"))
        assert repr(solution) == "<ContactSolution 32 x 32, free: converged, 100 MPa>"


class TestUnits:
    def test_a_spread_has_two_digits(self):
        assert with_spread(1.14188, 0.000193) == "(1.14188 +- 0.00019)"
        assert with_spread(11.69, 0.67) == "(11.69 +- 0.67)"
        assert with_spread(1234.5, 123.0) == "(1230 +- 120)"
        assert with_spread(100.0, 0.0) == "100"
        assert with_spread(1e-12, 2e-13) == "(1e-12 +- 2e-13)"
        assert with_spread(np.nan, 1.0) == "nan"

    def test_a_plain_text_shows_as_it_prints(self):
        assert repr(PlainText("a\nb")) == "a\nb"
        assert type(str(PlainText("a"))) is str
