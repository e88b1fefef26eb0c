"""How solutions, problems and maps print: in full, in one line, and in a notebook."""

from __future__ import annotations

import re
import sys
from functools import partial

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.typing import si
from scenes import make_problem

STEEL = rc.Elastic(young=200e9, poisson=0.3)
ROUGH = rc.SelfAffineSurface(hurst=0.7, rms_slope=0.1, shortest=8e-6, longest=64e-6, seed=2)
GRID = rc.Grid((32, 32), 64e-6)
PREFIXES = {"p": 1e-12, "n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0}


rough_problem = partial(make_problem, ROUGH, material=STEEL, grid=GRID)


class TestPrint:
    def test_the_answer_comes_first_and_the_work_last(self):
        labels = [
            line[:18].strip() for line in str(rough_problem(boundary="periodic").solve(pressure=1e8)).splitlines()
        ]
        shown = [label for label in labels if label and label not in ("warning", "Persson")]
        answer = ["contact area", "force", "mean pressure", "maximum pressure", "approach"]
        assert shown == [*answer, "other places", "status", "modulus E*", "residuals", "work"]

    @pytest.mark.parametrize(
        ("material", "force", "said"),
        [
            (rc.Elastic(210e9, 0.3), 20.0, True),
            (rc.Elastic(210e9, 0.3), 0.01, False),
            (rc.ElasticPerfectlyPlastic(210e9, 0.3, 7e9), 20.0, False),
            (rc.Elastic(3e9, 0.4), 1.0, False),
        ],
        ids=["steel at 30 GPa", "steel at 2 GPa", "with a hardness", "a polymer"],
    )
    @pytest.mark.usefixtures("no_pictures")
    def test_a_pressure_that_no_metal_bears_is_remarked(self, material, force, said):
        ball = rc.Body(rc.SphereSurface(1e-4), material)
        solution = rc.ContactProblem(ball, grid=rc.Grid((48, 40), (1e-4, 9e-5))).solve(force=force)
        remark = "more than metals bear: unless it is meant, give a hardness"
        lines = str(solution).splitlines()
        assert (" " * 18 + remark in lines) == said
        assert (remark in solution.to_html()) == said
        if said:
            assert lines[lines.index(" " * 18 + remark) - 1].startswith("maximum pressure")

    def test_what_did_not_converge_says_so_first(self):
        problem = rough_problem(solver=rc.ProjectedConjugateGradient(tolerance=1e-8, max_iterations=1))
        solution = problem.solve(pressure=1e8, throw=False)
        assert str(solution).startswith("status            not converged: ")
        assert repr(solution) == "<ContactSolution 32 x 32, free: not converged, 100 MPa>"

    def test_what_is_not_finite_is_printed(self):
        solution = rough_problem(material=rc.ElasticPerfectlyPlastic(200e9, 0.3, 2e9)).solve(pressure=1e8)
        broken = attrs.evolve(solution, pressure=np.nan * solution.pressure, status=rc.Status.NOT_FINITE)
        assert "contact area      not determined" in str(broken)
        assert repr(broken).startswith("<ContactSolution 32 x 32, free: not converged, nan")

    def test_it_has_80_columns_whatever_is_wrong(self):
        steep = rc.HeightMap(30.0 * ROUGH.heights(GRID), size=64e-6)
        material = rc.ElasticPerfectlyPlastic(200e9, 0.3, 2e9)
        solution = rc.ContactProblem(rc.Body(steep, material)).solve(pressure=1e8, area_within=1e-5, throw=False)
        text = str(solution)
        assert max(map(len, text.splitlines())) <= 80
        words = " ".join(text.split())
        for warning in (*solution.warnings, *solution.area().warnings, *solution.saturated_area().warnings):
            assert " ".join(warning.split()) in words
        assert solution.warnings
        for label in ("saturated", "warning", "accuracy", "grids solved", "tolerance"):
            assert re.search(rf"^{label} ", text, re.MULTILINE)

    def test_the_area_is_that_of_the_estimator(self):
        solution = rough_problem(boundary="periodic").solve(pressure=1e8)
        area = solution.area()
        first = str(solution).splitlines()[0]
        value, std, size = re.fullmatch(
            r"contact area      \(([\d.]+) \+- ([\d.]+)\) % of nominal, ([\d.]+) µm2 \[blend\]", first
        ).groups()
        assert float(value) == pytest.approx(100.0 * area.fraction, abs=0.06 * float(std))
        assert float(std) == pytest.approx(100.0 * area.uncertainty / GRID.area, rel=0.06)
        assert float(size) * 1e-12 == pytest.approx(area.value, rel=1e-3)


class TestShort:
    def test_a_solution_is_one_line_with_its_answer(self):
        text = repr(rough_problem(boundary="periodic").solve(pressure=1e8))
        assert re.fullmatch(
            r"<ContactSolution 32 x 32, periodic: converged, 100 MPa, contact area \([\d.]+ \+- [\d.]+\) %>", text
        )

    def test_maps_and_problems_hide_their_arrays(self):
        mask = np.zeros(GRID.shape, dtype=bool)
        mask[0, :3] = True
        height_map = rc.HeightMap(ROUGH.heights(GRID), 64e-6, periodic=True, non_measured=mask)
        assert repr(height_map) == "<HeightMap 32 x 32 cells on 64 µm x 64 µm, periodic, 3 points non-measured>"
        problem = rc.ContactProblem(rc.Body(height_map, STEEL), boundary="periodic")
        assert repr(problem) == "<ContactProblem 32 x 32 cells on 64 µm x 64 µm, periodic: HeightMap on FlatSurface>"
        assert len(repr(problem.body)) < 200

    def test_the_plan_shows_as_it_prints(self):
        problem = rough_problem()
        text = problem.explain()
        assert isinstance(text, str)
        assert repr(text) == str(text) == str(problem.plan) == repr(problem.plan)
        assert "\n" in repr(text)

    def test_a_notebook_shows_a_table_and_one_picture(self):
        html5lib = pytest.importorskip("html5lib")
        solution = rough_problem(material=rc.ElasticPerfectlyPlastic(200e9, 0.3, 2e9)).solve(pressure=1e8)
        tree = html5lib.HTMLParser(strict=True, namespaceHTMLElements=False).parseFragment(solution._repr_html_())
        heads = [one.text for one in tree.iter("th")]
        assert heads[0] == "contact area"
        assert "status" in heads
        assert len(list(tree.iter("img"))) == 1

    def test_a_notebook_shows_no_picture_of_a_large_solution_or_without_matplotlib(self, monkeypatch):
        solution = rough_problem().solve(pressure=1e8)
        monkeypatch.setattr("roughcontact._faces.html.notebook._MAX_PICTURE_CELLS", 100)
        assert "<img" not in solution._repr_html_()
        monkeypatch.undo()
        monkeypatch.setitem(sys.modules, "matplotlib", None)
        assert "<img" not in solution._repr_html_()

    @pytest.mark.parametrize(("value", "text"), [(0.027085, "0.02709"), (1234.5, "1234"), (0.0, "0"), (1e-9, "1e-09")])
    def test_a_number_without_a_unit_has_no_prefix(self, value, text):
        """A strain of 0.027 is not one of 27 m."""
        assert si(value, "") == text


class TestUnits:
    @given(st.floats(1e-22, 9e3), st.sampled_from([2, 3]))
    def test_areas_and_volumes_have_a_prefix_raised_to_their_power(self, value, order):
        number, unit = si(value, f"m{order}", 4).split()
        prefix = unit.removesuffix(f"m{order}")
        assert float(number) * PREFIXES[prefix] ** order == pytest.approx(value, rel=6e-4)
        assert "e" not in number or value < 1e-20

    def test_texts(self):
        for value, unit, text in (
            (4.19e-10, "m2", "419 µm2"),
            (2.5e-9, "m2", "2500 µm2"),
            (1e-8, "m2", "0.01 mm2"),
            (-3e-17, "m2", "-30 nm2"),
            (0.0, "m2", "0 m2"),
            (2e-12, "m3/s", "0.002 mm3/s"),
            (3e4, "1/m2", "3e+04 1/m2"),
            (5e3, "W/(m2 K)", "5 kW/(m2 K)"),
            (2e4, "m2", "2e+04 m2"),
        ):
            assert si(value, unit) == text
