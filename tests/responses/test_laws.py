"""Laws of an interface: columns, fits, tables, and the files of other programs, read back as their manuals say."""

from __future__ import annotations

import csv
import math
import re

import attrs
import numpy as np
import pytest

import roughcontact as rc
from scenes import make_problem

STEEL = rc.Elastic(200e9, 0.3)
GRID = rc.Grid((64, 48), (64e-6, 48e-6))
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=32e-6, seed=1)
PRESSURES = np.geomspace(20e6, 2e9, 11)


@attrs.frozen
class Spring(rc.Response):
    """A response in proportion to the load, of a unit that is over nominal area or not."""

    unit: str = "N/m"
    factor: float = 1e7
    warning: str = ""

    def respond(self, solution):
        warnings = (self.warning,) if self.warning and solution.mean_pressure > 1e9 else ()
        return rc.Estimate(self.factor * solution.force, 0.01 * self.factor * solution.force, self.unit, warnings)


@attrs.frozen
class Parts(rc.Response):
    def respond(self, solution):
        return attrs.make_class("Found", ["value", "uncertainty", "patches"])(solution.force, 0.0, [1.0])


@attrs.frozen
class Words(rc.Response):
    def respond(self, solution):
        return "stiff"


def problem(surface=ROUGH, material=STEEL, boundary="periodic", **options):
    return make_problem(surface, material, grid=GRID, boundary=boundary, threads=1, **options)


@pytest.fixture(scope="module")
def law():
    responses = {"stiffness": Spring(), "conductance": Spring("W/K", 2.0, "A warning.")}
    return rc.interface_law(problem(), PRESSURES[::-1], responses)


class TestLaw:
    def test_columns_are_those_of_single_solves(self, law):
        assert (law.pressures == PRESSURES).all()
        for index in (0, 6, 10):
            solution = problem().solve(pressure=PRESSURES[index])
            area = solution.area()
            assert law["area"].values[index] == pytest.approx(area.fraction, rel=2e-4)
            assert law["mean_gap"].values[index] == pytest.approx(solution.response("mean-gap").value, rel=1e-3)
            assert law["area"].uncertainties[index] == pytest.approx(area.uncertainty / GRID.area, rel=0.05)
        # N/m and W/K over the nominal area.
        assert law["stiffness"].values == pytest.approx(1e7 * PRESSURES, rel=1e-9)
        assert law["conductance"].uncertainties == pytest.approx(0.02 * PRESSURES, rel=1e-9)
        assert [column.unit for column in law.columns.values()] == ["", "m", "Pa/m", "W/(m2 K)"]

    def test_warnings_name_their_loads(self, law):
        assert law.warnings == ("At 1.262 GPa and 2 GPa: conductance: A warning.",)
        assert "warning: At 1.262 GPa and 2 GPa" in str(law)

    def test_a_warning_with_other_numbers_is_one_sentence(self):
        class Doubtful(rc.Response):
            def respond(self, solution):
                text = f"{solution.mean_pressure / 1e6:.0f} MPa are many."
                return rc.Estimate(1.0, 0.1, "", (text,))

        found = rc.interface_law(problem(), [2e8, 3e8, 4e8], {"doubtful": Doubtful()}).warnings
        last = "At 200 MPa, 300 MPa and 400 MPa (here with the numbers at 400 MPa): doubtful: 400 MPa are many."
        assert found == (last,)

    def test_few_loads_get_a_warning(self):
        found = rc.interface_law(problem(), [2e8, 4e8], ())
        assert found.warnings == (
            "Neighbouring loads differ by up to 2 times. Programs that draw straight lines between them may be off by "
            "more than 1 %: take ratios of at most 1.6.",
        )

    def test_the_ratio_keeps_straight_lines_within_one_per_cent(self):
        for exponent in (1 / 3, 0.5, 0.8, 0.95):
            p = np.linspace(1.0, 1.6, 101)
            chord = 1.0 + (p - 1.0) * (1.6**exponent - 1.0) / 0.6
            assert np.abs(chord / p**exponent - 1.0).max() < 0.01

    def test_a_response_may_have_parts_and_other_units_stay(self):
        found = rc.interface_law(problem(), [1e8], {"heat": Parts(), "flow": Spring("m3/s")})
        assert found["heat"].values == pytest.approx([1e8 * GRID.area])
        assert found["heat"].unit == ""
        assert found["flow"].unit == "m3/s"
        assert found["flow"].values == pytest.approx([1e7 * 1e8 * GRID.area])

    def test_pressures_that_are_limited(self):
        hard = rc.ElasticPerfectlyPlastic(200e9, 0.3, 5e9)
        found = rc.interface_law(problem(material=hard), [1e8, 1.5e8], [Spring()])
        assert "pressure limit 5e+09 Pa" in found.description[1]
        assert list(found.columns) == ["area", "mean_gap", "Spring"]
        with pytest.raises(rc.InputError, match="more than the bodies can carry"):
            rc.interface_law(problem(material=hard), [1e8, 6e9], ())

    def test_units_change_nothing_but_the_unit(self):
        lengths = {"shortest": 8e-6 * 2.0**20, "longest": 32e-6 * 2.0**20}
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, seed=1, **lengths)
        grid = rc.Grid(GRID.shape, tuple(side * 2.0**20 for side in GRID.size))
        large = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary="periodic", threads=1)
        one, other = (rc.interface_law(each, [1e8, 1.5e8], [Spring()]) for each in (problem(), large))
        assert other["area"].values == pytest.approx(one["area"].values, rel=1e-6)
        assert other["mean_gap"].values == pytest.approx(one["mean_gap"].values * 2.0**20, rel=1e-6)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"problem": 5}, "a ContactProblem"),
            ({"problem": problem(boundary="free")}, "needs boundary='periodic'"),
            ({"problem": problem(boundary="wrapped")}, "needs boundary='periodic'"),
            ({"pressure": []}, "empty"),
            ({"pressure": [1e8, 1e8]}, "given twice"),
            ({"pressure": [1e8, -1.0]}, "above 0"),
            ({"pressure": 1e8}, "a list"),
            ({"responses": "stiffness"}, "a list of registered names"),
            ({"responses": 5}, "a list of registered names"),
            ({"responses": ["stiff"]}, "There is no response named 'stiff'"),
            ({"responses": [Spring(), Spring("S")]}, "name of a column"),
            ({"responses": {"area": Spring()}}, "name of a column"),
            ({"responses": [Words()]}, "not a number with an uncertainty"),
        ],
    )
    def test_bad_input_gets_a_sentence(self, change, words):
        with pytest.raises(rc.InputError, match=words):
            rc.interface_law(**({"problem": problem(), "pressure": [1e8], "responses": ()} | change))

    def test_a_column_that_is_not_there(self, law):
        with pytest.raises(rc.InputError, match="There is no column of the law named 'leakage'"):
            law.fit("leakage")


class TestOwnResponses:
    """The responses that ship, in a law."""

    def test_stiffness_is_the_slope_of_the_gap_and_conductance_in_proportion(self):
        pressures = np.geomspace(1e8, 4e8, 7)
        law = rc.interface_law(
            problem(),
            pressures,
            {"stiffness": "stiffness", "conductance": rc.responses.create("conductance", (50.0, 20.0))},
        )
        gap, stiffness = law["mean_gap"].values, law["stiffness"].values
        slope = -np.diff(pressures) / np.diff(gap)
        assert slope == pytest.approx(np.sqrt(stiffness[1:] * stiffness[:-1]), rel=0.08)
        modulus = problem().plan.modulus
        assert law["conductance"].values == pytest.approx(stiffness * 2 / (1 / 50 + 1 / 20) / modulus, rel=2e-3)
        assert law["conductance"].unit == "W/(m2 K)"
        assert (law["stiffness"].uncertainties > 0.0).all()

    def test_leakage_falls_with_the_load_and_is_that_of_the_domain(self):
        flow = rc.responses.create("leakage", viscosity=1e-3, pressure_drop=1e5)
        law = rc.interface_law(problem(), [1e8, 1.5e8], [flow])
        leakage = law["leakage"]
        assert leakage.unit == "m3/s"
        single = problem().solve(pressure=1e8).leakage(viscosity=1e-3, pressure_drop=1e5)
        assert leakage.values[0] == pytest.approx(single.value, rel=1e-3)
        assert leakage.values[1] < leakage.values[0]


class TestFit:
    def test_a_power_law_is_found(self, law):
        found = law.fit("stiffness")
        assert found.exponent == pytest.approx(1.0, abs=1e-9)
        assert found.loads == 11
        assert found.pressures == (PRESSURES[0], PRESSURES[-1])
        assert found.factor == pytest.approx(1e7 * found.pivot, rel=1e-9)


class TestTables:
    def test_csv_has_all_digits(self, law, tmp_path):
        law.to_csv(tmp_path / "law.csv")
        with (tmp_path / "law.csv").open(newline="", encoding="utf-8") as file:
            heading, *rows = list(csv.reader(file))
        assert heading[:3] == ["pressure [Pa]", "area [1]", "area_uncertainty [1]"]
        assert heading[-1] == "conductance_uncertainty [W/(m2 K)]"
        assert (list(law.to_table().values()) == np.array(rows, dtype=float).T).all()

    def test_pandas(self, law):
        pytest.importorskip("pandas")
        frame = law.to_pandas()
        assert list(frame.columns[:4]) == ["pressure", "area", "area_uncertainty", "mean_gap"]
        assert (frame["stiffness"] == law["stiffness"].values).all()
        assert frame.attrs["units"]["stiffness"] == "Pa/m"

    def test_plot(self, law):
        pyplot = pytest.importorskip("matplotlib.pyplot")
        axes = law.plot()
        assert axes.get_ylabel() == "stiffness, Pa/m"
        same = law.plot("area", axes=axes)
        assert sum(law.plot(dark=True).get_facecolor()[:3]) < 1.0 < sum(axes.get_facecolor()[:3])
        assert same is axes
        assert len(axes.collections) == 2
        with pytest.raises(rc.InputError, match="The axes"):
            law.plot(axes=5)
        pyplot.close("all")


def read_keywords(path, longest, most):
    """Return keyword, parameters and data lines, as both programs define their input.

    A keyword line begins with one star, a comment with two; parameters and data are parted by commas, blanks and case
    do not count: Abaqus Analysis Guide, "Input syntax rules", of which a line has at most 256 characters
    (https://abaqus-docs.mit.edu/2017/English/SIMACAEMODRefMap/simamod-c-inputsyntax.htm); CalculiX User's Manual,
    "Golden rules" and "Input deck format".
    """
    blocks = []
    text = path.read_text(encoding="ascii")
    assert text.endswith("\n")
    for line in text.splitlines():
        assert len(line) <= longest
        assert line.strip(), "an empty line"
        if line.startswith("**"):
            continue
        fields = [field.strip() for field in line.split(",")]
        assert len(fields) <= most
        if line.startswith("*"):
            parameters = dict([*field.upper().split("="), ""][:2] for field in fields[1:])
            blocks.append((fields[0].upper(), parameters, []))
        else:
            blocks[-1][2].append(fields)
    return blocks


def read_abaqus(path):
    """Read the tables of a surface interaction of Abaqus.

    *GAP CONDUCTANCE: conductance, then the pressure with the parameter PRESSURE, without it the clearance; at least two
    lines (Keywords Guide 2017, simakey-r-gapconductance.htm). *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR:
    pressure, overclosure, at least two lines in ascending order of the overclosure (User Manual, vol. II, 18.47-4).
    """
    (head, parameters, data), *rest = read_keywords(path, 256, 16)
    assert (head, data) == ("*SURFACE INTERACTION", [])
    found = {"name": parameters["NAME"]}
    for keyword, parameters, data in rest:
        rows = np.array(data, dtype=float)
        assert len(rows) >= 2
        if keyword == "*SURFACE BEHAVIOR":
            assert parameters == {"PRESSURE-OVERCLOSURE": "TABULAR"}
            assert (np.diff(rows[:, 1]) > 0.0).all()
            found["closure"] = rows
        else:
            assert keyword in ("*GAP CONDUCTANCE", "*GAP ELECTRICAL CONDUCTANCE")
            assert parameters == {"PRESSURE": ""}, "of the clearance"
            assert (np.diff(rows[:, 1]) > 0.0).all()
            found[keyword] = rows
    return found


def read_calculix(path):
    """Read the tables of a surface interaction of CalculiX, with what ccx does to them.

    *SURFACE BEHAVIOR: pressure, overclosure, temperature; *GAP CONDUCTANCE: conductance, contact pressure, temperature,
    after the surface behavior and before any step; USER is its only parameter (User's Manual 2.17, node315.html; source
    gapconductances.f, surfacebehaviors.f: numbers of 20 characters, differences of overclosures below 1e-10 changed).
    """
    found, seen = {}, []
    for keyword, parameters, data in read_keywords(path, 132, 16):
        seen.append(keyword)
        assert keyword != "*STEP"
        assert all(len(field) <= 20 for row in data for field in row)
        rows = np.array(data, dtype=float)
        if keyword == "*SURFACE INTERACTION":
            found["name"] = parameters["NAME"]
        elif keyword == "*SURFACE BEHAVIOR":
            assert seen == ["*SURFACE INTERACTION", "*SURFACE BEHAVIOR"]
            assert parameters == {"PRESSURE-OVERCLOSURE": "TABULAR"}
            assert (np.diff(rows[:, 1]) > 1e-10).all(), "changed to 1e-10"
            found["closure"] = rows
        else:
            assert keyword == "*GAP CONDUCTANCE"
            assert "*SURFACE BEHAVIOR" in seen
            assert parameters == {}
            assert len(np.unique(rows[:, 2])) == 1
            found[keyword] = rows
    return found


def read_moose(path):
    """Return the value of a `PiecewiseLinear` function and the parameters of its contact, as MOOSE reads them.

    Blocks as in a HIT file; ``format`` of `PiecewiseLinear` is ``rows`` unless given, ``#`` begins a comment, more than
    two columns are an error, and beyond the ends the function is constant
    (https://mooseframework.inl.gov/source/functions/PiecewiseLinear.html; PiecewiseTabularBase.C). In a closed gap the
    conductance is gap_conductivity times the function over min_gap (GapConductance.C).
    """
    stack, blocks = [], {}
    for line in path.read_text(encoding="ascii").splitlines():
        text = line.partition("#")[0].strip()
        if text == "[]":
            stack.pop()
        elif text.startswith("["):
            stack.append(text.strip("[]"))
        elif text:
            name, value = (part.strip() for part in text.split("="))
            blocks.setdefault("/".join(stack), {})[name] = value
    assert stack == []
    (function,) = (block for name, block in blocks.items() if name.startswith("Functions/"))
    ((contact_name, contact),) = ((name, block) for name, block in blocks.items() if name.startswith("ThermalContact/"))
    assert function["type"] == "PiecewiseLinear"
    assert function.get("format", "rows") == "columns"
    lines = [
        line.partition("#")[0].strip() for line in (path.parent / function["data_file"]).read_text("ascii").splitlines()
    ]
    rows = np.array([line.split(",") for line in lines if line], dtype=float)
    assert rows.shape[1] == 2
    assert (np.diff(rows[:, 0]) > 0.0).all()
    assert contact["gap_conductivity_function"] == contact_name.split("/")[1]
    assert contact["emissivity_primary"] == contact["emissivity_secondary"] == "0"
    scale = float(contact["gap_conductivity"]) * float(function["scale_factor"]) / float(contact["min_gap"])
    return lambda pressure: scale * np.interp(pressure, rows[:, 0], rows[:, 1]), contact


def read_ansys(path):
    """Return pressures and conductances of the table that is given to real constant 14, by the rules of APDL."""
    tables = {}
    given = {}
    for line in path.read_text(encoding="ascii").splitlines():
        command = line.partition("!")[0].strip()
        assert len(command) <= 640
        assert "$" not in command
        if command.startswith("*DIM,"):
            _, name, kind, rows, columns, planes, variable = command.split(",")
            assert (kind, columns, planes, variable) == ("TABLE", "1", "1", "PRESSURE")
            assert name not in tables
            tables[name] = np.full((int(rows) + 1, 2), np.nan)
        elif command.startswith("RMODIF,"):
            _, constants, place, table = command.split(",")
            assert table[0] == table[-1] == "%"
            given[constants, place] = tables[table.strip("%")]
        elif command:
            name, row, column, value = re.fullmatch(r"(\w+)\((\d+),(\d)\)=(\S+)", command).groups()
            tables[name][int(row), int(column)] = float(value)
    ((place, table),) = given.items()
    assert place == ("cid", "14")
    # Index numbers stand in column zero, from row one on, in ascending order.
    assert (np.diff(table[1:, 0]) > 0.0).all()
    assert not np.isnan(table[1:]).any()
    return table[1:]


def read_comsol(path):
    """Return the rows of a table in the spreadsheet format: numbers between blanks, comments behind a percent sign."""
    lines = path.read_text(encoding="ascii").splitlines()
    rows = np.array([line.split() for line in lines if not line.startswith("%")], dtype=float)
    assert (np.diff(rows[:, 0]) > 0.0).all()
    return rows


UNITS = {"SI": (1.0, 1.0, 1.0), "mm": (1e3, 1e-6, 1e-3)}


@pytest.mark.parametrize("units", UNITS)
class TestFiles:
    def check_closure(self, law, rows, units):
        """The first row is at rest; from the second on the steps are those of the gap; the start is its tangent."""
        length, pressure, _ = UNITS[units]
        assert (rows[0, :2] == 0.0).all()
        assert rows[1:, 0] == pytest.approx(law.pressures * pressure, rel=1e-8)
        assert np.diff(rows[1:, 1]) == pytest.approx(-np.diff(law["mean_gap"].values) * length, rel=1e-6)
        slope = rows[1, 0] / rows[1, 1]
        assert slope == pytest.approx(law["stiffness"].values[0] * pressure / length, rel=1e-8)

    def check_conductance(self, law, rows, units):
        _, pressure, conductance = UNITS[units]
        assert (rows[0, :2] == 0.0).all()
        assert rows[1:, 0] == pytest.approx(law["conductance"].values * conductance, rel=1e-8)
        assert rows[1:, 1] == pytest.approx(law.pressures * pressure, rel=1e-8)

    def test_abaqus(self, law, tmp_path, units):
        law.to_abaqus(tmp_path / "rough.inp", name="Joint_1", units=units)
        found = read_abaqus(tmp_path / "rough.inp")
        assert found["name"] == "JOINT_1"
        self.check_closure(law, found["closure"], units)
        self.check_conductance(law, found["*GAP CONDUCTANCE"], units)

    def test_calculix(self, law, tmp_path, units):
        law.to_calculix(tmp_path / "rough.inp", units=units)
        found = read_calculix(tmp_path / "rough.inp")
        assert found["name"] == "ROUGH"
        self.check_closure(law, found["closure"], units)
        self.check_conductance(law, found["*GAP CONDUCTANCE"], units)

    def test_comsol(self, law, tmp_path, units):
        law.to_comsol(tmp_path / "h.txt", units=units)
        law.to_comsol(tmp_path / "p.txt", table="closure", units=units)
        found = read_comsol(tmp_path / "h.txt")
        self.check_conductance(law, found[:, ::-1], units)
        closure = read_comsol(tmp_path / "p.txt")
        self.check_closure(law, closure[:, ::-1], units)

    def test_ansys(self, law, tmp_path, units):
        law.to_ansys(tmp_path / "a.inp", name="JOINT_1", units=units)
        self.check_conductance(law, read_ansys(tmp_path / "a.inp")[:, ::-1], units)

    def test_moose(self, law, tmp_path, units):
        law.to_moose(tmp_path / "rough.csv", name="joint", min_gap=3e-6, units=units)
        function, contact = read_moose(tmp_path / "rough.i")
        length, pressure, conductance = UNITS[units]
        assert float(contact["min_gap"]) == pytest.approx(3e-6 * length)
        for index in (0, 5, 10):
            wanted = law["conductance"].values[index] * conductance
            assert function(law.pressures[index] * pressure) == pytest.approx(wanted, rel=1e-8)
        assert function(0.0) == 0.0
        assert function(1e30) == pytest.approx(law["conductance"].values[-1] * conductance, rel=1e-8)

    def test_comments_say_units_limits_and_uncertainties(self, law, tmp_path, units):
        for write, name in (
            (law.to_abaqus, "a.inp"),
            (law.to_calculix, "c.inp"),
            (law.to_ansys, "s.inp"),
            (law.to_moose, "m.csv"),
        ):
            write(tmp_path / name, units=units)
            comments = [line for line in (tmp_path / name).read_text("ascii").splitlines() if line[0] in "*#!"]
            text = " ".join(comments)
            unit = {"SI": "pressure in Pa, conductance in W/(m2 K)", "mm": "pressure in MPa, conductance in mW/(mm2 K)"}
            assert unit[units] in text
            assert "no pressure limit" in text
            assert "all pressures are nominal" in text
            assert "A warning." in text
            rows = [line.strip("*#! ").split(", ") for line in comments if re.match(r"(\*\*|#|!) [\d.]+e", line)]
            _, pressure, conductance = UNITS[units]
            last = [float(value) for value in rows[-1]]
            values = law["conductance"]
            assert last == pytest.approx(
                [2e9 * pressure, values.values[-1] * conductance, values.uncertainties[-1] * conductance], rel=1e-5
            )


def small_law(gap, conductance=(1e3, 2e3), unit="W/(m2 K)", **columns):
    from roughcontact.results import InterfaceLaw, LawColumn

    pressures = 1e6 * np.arange(1.0, len(gap) + 1.0)
    made = {"mean_gap": ("m", gap), "conductance": (unit, conductance), **columns}
    return InterfaceLaw(
        pressures, {k: LawColumn(k, u, np.array(v), np.zeros(len(gap))) for k, (u, v) in made.items()}, ("A law.",), ()
    )


class TestFilesOfOtherLaws:
    def test_steps_that_calculix_would_change_are_omitted(self, tmp_path):
        gap = 1e-6 - np.array([0.0, 1e-9, 1.05e-9, 2e-9])
        law = small_law(gap, (1e3, 2e3, 3e3, 4e3))
        law.to_calculix(tmp_path / "c.inp")
        found = read_calculix(tmp_path / "c.inp")["closure"]
        assert found[:, 0] == pytest.approx([0.0, 1e6, 2e6, 4e6])
        # In mm all rows remain.
        law.to_calculix(tmp_path / "c.inp", units="mm")
        assert len(read_calculix(tmp_path / "c.inp")["closure"]) == 5

    def test_without_a_stiffness_the_first_slope_goes_on(self, tmp_path):
        small_law([3e-6, 2e-6]).to_abaqus(tmp_path / "a.inp")
        assert read_abaqus(tmp_path / "a.inp")["closure"] == pytest.approx(
            np.array([[0.0, 0.0], [1e6, 1e-6], [2e6, 2e-6]])
        )

    def test_without_a_conductance_there_is_the_closure_alone(self, tmp_path):
        law = small_law([3e-6, 2e-6])
        for write, read in ((law.to_abaqus, read_abaqus), (law.to_calculix, read_calculix)):
            write(tmp_path / "a.inp", conductance=None)
            assert set(read(tmp_path / "a.inp")) == {"name", "closure"}

    def test_electrical_conductance(self, tmp_path):
        """Abaqus Keywords Guide 2017, *GAP ELECTRICAL CONDUCTANCE (simakey-r-gapelectricalconductance.htm)."""
        law = small_law([3e-6, 2e-6], (5.0, 9.0), "S/m2")
        law.to_abaqus(tmp_path / "a.inp")
        assert read_abaqus(tmp_path / "a.inp")["*GAP ELECTRICAL CONDUCTANCE"] == pytest.approx(
            np.array([[0.0, 0.0], [5.0, 1e6], [9.0, 2e6]])
        )
        small_law([3e-6, 2e-6], (5.0, 9.0)).to_abaqus(tmp_path / "e.inp", electrical=True, units="mm")
        rows = read_abaqus(tmp_path / "e.inp")["*GAP ELECTRICAL CONDUCTANCE"]
        assert rows[1:] == pytest.approx(np.array([[5e-6, 1.0], [9e-6, 2.0]]))
        for write, name in ((law.to_calculix, "c.inp"), (law.to_moose, "m.csv")):
            with pytest.raises(rc.InputError, match=r"W/\(m2 K\)"):
                write(tmp_path / name)

    @pytest.mark.parametrize(
        ("law", "options", "words"),
        [
            (small_law([2e-6, 3e-6]), {}, "does not fall from load to load"),
            (small_law([2e-6], (1.0,)), {}, "at least two loads"),
            (small_law([3e-6, 2e-6], (1e3, math.inf)), {}, "full contact"),
            (small_law([3e-6, 2e-6]), {"name": "1 joint"}, "a letter"),
            (small_law([3e-6, 2e-6]), {"units": "inch"}, "'SI', 'mm'"),
            (small_law([3e-6, 2e-6]), {"conductance": "mean_gap"}, "a conductance is in"),
        ],
    )
    def test_what_cannot_be_written_gets_a_sentence(self, law, options, words, tmp_path):
        with pytest.raises(rc.InputError, match=words):
            law.to_abaqus(tmp_path / "a.inp", **options)
        assert not list(tmp_path.iterdir())

    def test_ansys_needs_a_name_of_a_parameter_and_a_thermal_conductance(self, tmp_path):
        law = small_law([3e-6, 2e-6])
        for name in ("JOINT-1", "1", "_A", "A" * 33, "A B", "", 3):
            with pytest.raises(rc.InputError, match="The name of the table"):
                law.to_ansys(tmp_path / "a.inp", name=name)
        with pytest.raises(rc.InputError, match="no column of the law named 'heat'"):
            law.to_ansys(tmp_path / "a.inp", conductance="heat")
        with pytest.raises(rc.InputError, match="takes a thermal conductance, in"):
            law.to_ansys(tmp_path / "a.inp", conductance="mean_gap")
        assert not list(tmp_path.iterdir())

    def test_moose_needs_a_csv_and_a_gap(self, tmp_path):
        law = small_law([3e-6, 2e-6])
        with pytest.raises(rc.InputError, match=r"ends in \.csv"):
            law.to_moose(tmp_path / "m.txt")
        with pytest.raises(rc.InputError, match="smallest gap"):
            law.to_moose(tmp_path / "m.csv", min_gap=0.0)
        with pytest.raises(rc.InputError, match="no column of the law named 'heat'"):
            law.to_moose(tmp_path / "m.csv", conductance="heat")
