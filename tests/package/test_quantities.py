"""One number and one unit: what the command line and study files take for a quantity, and what not."""

from __future__ import annotations

import argparse
import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import commands, main
from roughcontact.typing import quantity
from unit_files import read_study

GOOD = {
    "N": {
        "2.5N": 2.5,
        "2.5 N": 2.5,
        " 2.5 N ": 2.5,
        "2.5\u00a0N": 2.5,
        "+1N": 1.0,
        "-1N": -1.0,
        ".5N": 0.5,
        "5.N": 5.0,
        "1e-3 N": 1e-3,
        "1E3 N": 1e3,
        "1e+3N": 1e3,
        "5uN": 5e-6,
        "5 \u00b5N": 5e-6,
        "5 \u03bcN": 5e-6,
        "5 kN": 5e3,
        "1 kgf": 9.80665,
        "5 kg*m/s^2": 5.0,
    },
    "m": {"1.5mm": 1.5e-3, "250um": 250e-6, "2 \u00b5m": 2e-6, "2 \u03bcm": 2e-6, "1 \u00c5": 1e-10, "1in": 25.4e-3},
    "Pa": {
        "5 MPa": 5e6,
        "210GPa": 210e9,
        "5 N/mm^2": 5e6,
        "5 N/mm2": 5e6,
        "5 N/mm**2": 5e6,
        "5N/mm²": 5e6,
        "1 bar": 1e5,
    },
    "rad": {"180deg": math.pi, "180°": math.pi, "5 mrad": 5e-3},
    "W/(m K) or S/m": {
        "45": 45.0,
        "45 W/(m K)": 45.0,
        "45W/m/K": 45.0,
        "45 W m-1 K-1": 45.0,
        "45 W·m⁻¹·K⁻¹": 45.0,
        "45 W*m^-1*K^-1": 45.0,
        "0.45 W/(cm·K)": 45.0,
        "58 MS/m": 58e6,
    },
    "m2 K/W or Ohm m2": {"1e-6 m2 K/W": 1e-6, "2 (mm2 K)/W": 2e-6, "3e-12 Ω m²": 3e-12, "3 mOhm*mm2": 3e-9},
    "W/K or S": {"5mW/K": 5e-3, "5mS": 5e-3},
    "": {"0.3": 0.3, "3e-1": 0.3, "30%": 0.3, "30 %": 0.3, "-1": -1.0},
}
# A decimal comma, groups of digits, arithmetic, two quantities, no number, no unit, a wrong or unknown unit, what
# Python takes beside numbers, and numbers without end.
ALWAYS_BAD = (
    *("2,5N", "2,5 N", "2 500mN", "2'500mN", "2.500.000N", "9**9**9**9N", "2+3N", "2*3N", "5**2N", "1/2 N", "(5N)"),
    *("nanN", "nan", "inf N", "-infN", "1e999N", "1e400 N", "1e9999N", "1e308 GN", "0x10N", "1_000N", "5jN", "1e N"),
    *("\uff15N", "\u0665N", "\u22125N", "5N\0", "5N;1", "5 N*rad", "__import__('os')", "N" * 10**6, "9" * 10**6 + "N"),
    *("5N 3", "5N 3N", "5 N N", "3 5N", "N", "", " ", "lots", "5 MPa 3", "1,5mm", "1 5mm"),
)
BAD = {
    "N": (*ALWAYS_BAD, "5", "1e3", "5 Pa", "5 Nm", "5 q", "5 n", "5/N"),
    "m": ("1,5mm", "1.5 mm mm", "1 5mm", "1um2", "1 m2", "5 deg"),
    "Pa": ("5 MPa 3", "210", "5 mpa", "1 MPa^2", "5 kg", "1e5 degC"),
    "rad": ("30", "0.5", "30 %", "1,5rad"),
    # Millikelvins, one quantity for another, brackets that do not close, and those that divide twice.
    "W/(m K) or S/m": ("45 W/mK", "45 W/K", "45%", "45 Pa", "45 W/(m K", "45 W/((m K))", "45 W/(m/K)", "45,5", "(45)"),
    "": ("0,3", ",3", "0.3.1", "1/3", "30 deg", "0.3 m", "nan", "inf", "1e999", "0x1", "1_0"),
}


@pytest.mark.parametrize(("unit", "text", "value"), [(u, t, v) for u, row in GOOD.items() for t, v in row.items()])
def test_one_number_and_one_unit(unit, text, value):
    assert quantity(unit)(text) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("unit", BAD)
def test_anything_else_is_refused_and_shown(unit):
    for text in BAD[unit]:
        with pytest.raises(argparse.ArgumentTypeError, match=r"; write it like [0-9]") as caught:
            quantity(unit)(text)
        assert str(caught.value).startswith(repr(text[:80])), text[:80]
        assert len(str(caught.value)) < 250


def typed_options():
    """Return the converter of every option, of every command, that converts its text."""
    options = []
    for name in commands:
        parser = argparse.ArgumentParser()
        commands.create(name).declare(parser)
        # A form and the number of lost points may also be words, and shifts pairs; some options are words.
        words = "detrend", "no_data", "shift"
        typed = [one for one in parser._actions if one.type not in (None, str) and not one.dest.endswith(words)]
        options += [pytest.param(action.type, id=f"{name} {action.dest}") for action in typed]
    return options


@pytest.mark.parametrize("convert", typed_options())
def test_every_option_of_every_command_is_strict(convert):
    # Reading a million characters once for each unit will do.
    for text in (*(one for one in ALWAYS_BAD if len(one) < 100), *BAD[""][:3]):
        with pytest.raises(argparse.ArgumentTypeError, match="write it like"):
            convert(text)


def test_a_decimal_comma_solves_nothing(tmp_path, capsys):
    arguments = ["map.npz", "--young", "210GPa", "--force", "2,5N", "-o", str(tmp_path / "out")]
    with pytest.raises(SystemExit):
        main(["solve", *arguments])
    assert "--force: '2,5N' is not one number with a decimal point and one unit; write it like 2.5N" in (
        capsys.readouterr().err
    )
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("young", ["2,5e9", "210m", "9**9**9**9", "nan", "1e999", "1_0_"])
def test_fields_of_a_part_are_plain_numbers(young, capsys):
    assert main(["check", "elastic", "--with", f"young={young}", "poisson=0.3"]) == 2
    assert "Young's modulus must be a finite number, above 0 (Pa), but got" in capsys.readouterr().err


STUDY = """
[problems.a]
grid = {{ shape = [16, 16], size = {size} }}
boundary = "periodic"
body.surface = {{ type = "wavy", amplitude = 1e-7, wavelength = 1e-4 }}
body.material = {{ type = "elastic", young = {young}, poisson = {poisson} }}
[study]
{load}
"""
PLAIN = {"size": "1e-4", "young": "1e9", "poisson": "0.3", "load": "pressure = [1e6]"}


def study(tmp_path, **changes):
    (tmp_path / "study.toml").write_text(STUDY.format(**PLAIN | changes), encoding="utf-8")
    return read_study(tmp_path / "study.toml")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"size": '"1,5mm"'},
            "'1,5mm' is not one number .*; write it like 250um, or as a number in m @ problems.a.grid.size",
        ),
        ({"young": '"5 MPa 3"'}, "'5 MPa 3' is not one number .* @ problems.a.body.material.young"),
        ({"young": '"210"'}, "'210' has no unit .* @ problems.a.body.material.young"),
        ({"young": '"210 N"'}, "'210 N' is not a quantity in units of Pa; .* @ problems.a.body.material.young"),
        ({"young": "[2, 5]"}, "Young's modulus must be"),
        ({"young": "inf"}, "Young's modulus must be"),
        ({"young": "1e999"}, "Young's modulus must be"),
        ({"poisson": '"0,3"'}, "'0,3' is not one number .* @ problems.a.body.material.poisson"),
        ({"poisson": "nan"}, "Poisson's ratio must be"),
        ({"poisson": "0,3"}, "is not TOML"),
        ({"load": 'pressure = ["5 mN"]'}, "'5 mN' is not a quantity in units of Pa.* @ study.pressure"),
        ({"load": 'pressure = "5 MPa"'}, "must be a list"),
        ({"load": 'pressure = "5e6"'}, "pressure"),
        ({"load": 'force = "2,5N"'}, "force"),
    ],
)
def test_in_study_files_a_wrong_quantity_is_refused_with_its_place(tmp_path, changes, words):
    with pytest.raises(rc.InputError, match=words):
        study(tmp_path, **changes)


def test_the_study_file_itself_is_read(tmp_path):
    assert study(tmp_path).loads[0].value == 1e6


def test_in_study_files_quantities_may_have_units(tmp_path):
    """A text with a unit is the same number as one in SI units, to the last bit."""
    changes = {"size": '["100um", 1e-4]', "young": '"1GPa"', "poisson": '"30 %"', "load": 'pressure = ["1MPa", 2e6]'}
    given, plain = study(tmp_path, **changes), study(tmp_path, load="pressure = [1e6, 2e6]")
    assert given.key == plain.key
    assert study(tmp_path, load='force = ["300 mN"]').loads[0].value == 0.3


def test_the_size_and_unit_of_a_map_in_a_study_may_have_units(tmp_path):
    np.savetxt(tmp_path / "map.txt", np.eye(4))
    text = STUDY.format(**PLAIN)
    surface = 'body.surface = {{ type = "file", path = "map.txt", size = "{}", unit = "{}" }}'

    def write(size, unit):
        lines = [
            surface.format(size, unit) if "wavy" in line else "" if line.startswith("grid") else line
            for line in text.split("\n")
        ]
        (tmp_path / "maps.toml").write_text("\n".join(lines), encoding="utf-8")
        return read_study(tmp_path / "maps.toml").problems["a"].body.surface

    found = write("40um", "1 um")
    assert found.size == (40e-6, 40e-6)
    assert found.values.max() == 1e-6
    with pytest.raises(rc.InputError, match="The unit of a map: '1 Pa' is not a quantity in units of m"):
        write("40um", "1 Pa")


def test_a_share_has_two_digits_and_no_exponent():
    texts = [str(rc.Estimate(1.0, spread, "N")).split("+- ")[1] for spread in (0.0123, 0.994, 0.996, 12.3, np.inf)]
    assert texts == ["1.2 %", "99 %", "100 %", "1230 %", "inf %"]


SHARP_SHAPES = {
    "round": (lambda x, y: np.hypot(x - 2e-5, y + 1e-5) < 2e-4, 4e-4 * math.pi),
    "square": (lambda x, y: (abs(x + 3e-5) < 2e-4) & (abs(y) < 2e-4), 16e-4),
    "turned": (lambda x, y: abs(x + 0.6 * y) + abs(y - 0.6 * x) < 2e-4, 8e-4 * math.sqrt(2.0 / 1.36)),
    "hole": (lambda x, y: np.hypot(x, y - 4e-5) > 2.5e-4, 5e-4 * math.pi),
}


@pytest.mark.parametrize("shape", [(80, 80), (101, 63), (40, 120)])
@pytest.mark.parametrize("name", SHARP_SHAPES)
def test_the_edge_of_a_land_that_is_sharp_all_round_is_measured(name, shape):
    """Nothing of such an edge was traced: 184 nm +- 1 % for .94 mm."""
    inside, length = SHARP_SHAPES[name]
    x, y = (((np.arange(n) + 0.5) / n - 0.5) * 1e-3 for n in shape)
    heights = np.where(inside(x[:, np.newaxis], y), 2e-5, 0.0)
    body = rc.Body(rc.HeightMap(heights, (1e-3, 1e-3), periodic=True), rc.Elastic(210e9, 0.3))
    solution = rc.ContactProblem(body, boundary="periodic").solve(pressure=5e6)
    found = solution.response("perimeter", uncertainty="model")
    assert abs(found.value - length) < 2.0 * found.uncertainty < 0.4 * length


@pytest.mark.parametrize(("shape", "size"), [((96, 96), (1e-3, 1e-3)), ((120, 41), (1e-3, 1e-3))])
def test_the_mean_gap_below_a_margin_without_points_is_not_that_of_a_plane(shape, size):
    grid = rc.Grid(shape, size)
    heights = -(grid.x**2 + grid.y**2) / 1e-2
    margin = np.hypot(grid.x, grid.y) > 3.5e-4
    steel = rc.Elastic(210e9, 0.3)
    whole, cut = (
        rc.ContactProblem(rc.Body(rc.HeightMap(heights, size, non_measured=lost), steel)).solve(force=5.0)
        for lost in (None, margin)
    )
    exact = whole.response("mean-gap").value
    found = cut.response("mean-gap")
    assert found.value == pytest.approx(exact, rel=0.1)
    assert abs(found.value - exact) < 2.0 * found.uncertainty
    assert found.warnings


@pytest.mark.parametrize(("place", "boundary"), [(1.2, "free"), (1.45, "free"), (1.2, ("free", "periodic"))])
@pytest.mark.parametrize("turned", [False, True])
def test_the_mean_gap_over_a_summit_beside_a_free_border_is_uncertain(place, boundary, turned):
    """Its curvature was taken from cells further inside, where it has the other sign: an uncertainty of zero."""
    found = []
    for fold in (1, 4):
        x, y = ((np.arange(n * fold) + 0.5) / fold for n in (26, 21))
        heights = np.exp(-((x[::-1, np.newaxis] - place) ** 2 + (y - 10.3) ** 2) / 5.0)
        surface = rc.HeightMap(heights.T if turned else heights, (63.0, 26.0) if turned else (26.0, 63.0))
        kinds = boundary[::-1] if turned and isinstance(boundary, tuple) else boundary
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary=kinds)
        found.append(problem.solve(pressure=2e-4).response("mean-gap"))
    assert abs(found[0].value - found[1].value) < 2.0 * found[0].uncertainty < 0.3 * found[1].value


UNITS = {"mm": ("m", 1e-3), "GPa": ("Pa", 1e9), "mJ/m2": ("J/m**2", 1e-3), "1": ("dimensionless", 1.0)}


class Measured:
    """A number with a unit of its own, as packages for units have it."""

    def __init__(self, magnitude, unit):
        self.magnitude = magnitude
        self.unit = unit

    def to_base_units(self):
        return self.to(UNITS[self.unit][0])

    def to(self, other):
        base, factor = UNITS[self.unit]
        if other != base:
            raise ArithmeticError(f"{self.unit} is no {other}")
        return Measured(self.magnitude * factor, other)

    def __repr__(self):
        return f"{self.magnitude} {self.unit}"


class TestOtherPackages:
    """What acts as a quantity of pint is read where a text with a unit is; tests/faces/test_bridges.py has pint's."""

    def test_it_is_read_in_the_unit_of_the_field(self):
        assert rc.Elastic(Measured(210, "GPa"), Measured(0.3, "1")) == rc.Elastic(210e9, 0.3)
        assert rc.Grid((8, 4), [Measured(1, "mm"), "0.5mm"]).size == (1e-3, 5e-4)
        assert rc.Grid((8, 4), Measured(np.array([1.0, 0.5]), "mm")).size == (1e-3, 5e-4)
        assert rc.Exponential(work=Measured(50, "mJ/m2"), range="2nm").work == 0.05
        heights = np.random.default_rng(0).random((8, 8))
        found = rc.HeightMap(Measured(heights, "mm"), size=Measured(1, "mm"))
        np.testing.assert_array_equal(found.values, 1e-3 * heights)

    @pytest.mark.parametrize(
        "call",
        [
            lambda: rc.Elastic(Measured(1, "mm"), 0.3),
            lambda: rc.Elastic(1e9, Measured(1, "mm")),
            lambda: rc.Grid((8, 8), Measured(1, "GPa")),
            lambda: rc.Grid((8, 8), ["1mm", Measured(1, "GPa")]),
            lambda: rc.SphereSurface(Measured(1, "GPa")),
            lambda: rc.SphereSurface(Measured(None, "mm")),
            lambda: rc.Exponential(work=Measured(1, "mm"), range=1e-9),
            lambda: rc.HeightMap(Measured(np.ones((8, 8)), "GPa"), size=1e-3),
            lambda: rc.reference.texture(Measured(np.ones((8, 8)), "GPa"), rc.Grid((8, 8), 1e-3)),
        ],
    )
    def test_of_another_dimension_it_is_refused(self, call):
        with pytest.raises(rc.InputError, match=r"is not a (quantity in units of|plain number)"):
            call()
