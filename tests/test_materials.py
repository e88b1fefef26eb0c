from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given

import roughcontact as rc
from roughcontact._parts.materials import combined_pressure_limit, contact_modulus
from roughcontact.typing import TYPICAL
from strategies import moduli
from unit_files import read_study


def test_contact_modulus_is_of_the_plane_strain_moduli():
    steel, glass = rc.Elastic(210e9, 0.3), rc.Elastic(70e9, 0.2)
    expected = 1 / ((1 - 0.3**2) / 210e9 + (1 - 0.2**2) / 70e9)
    assert contact_modulus(steel, glass) == pytest.approx(expected, rel=1e-15)


def test_the_papers_contact_modulus():
    assert contact_modulus(rc.Elastic(200e9, 0.3), rc.Rigid()) == pytest.approx(219.78e9, rel=1e-5)


@given(moduli, moduli)
def test_the_pair_is_softer_than_either(one, other):
    first, second = rc.Elastic(one, 0.3), rc.Elastic(other, 0.1)
    together = contact_modulus(first, second)
    assert together == contact_modulus(second, first)
    assert together < min(contact_modulus(first, rc.Rigid()), contact_modulus(second, rc.Rigid()))


def test_the_softer_limit_counts():
    soft, hard = rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e6), rc.ElasticPerfectlyPlastic(1e9, 0.3, 2e6)
    assert combined_pressure_limit(hard, soft) == 1e6
    assert combined_pressure_limit(rc.Rigid(), hard) == 2e6
    assert combined_pressure_limit(rc.Rigid(), rc.Elastic(1.0, 0.0)) == math.inf


def test_the_softer_limit_counts_cell_by_cell():
    hardness = np.array([[1e6, 3e6], [2e6, 4e6]])
    patchy, uniform = rc.ElasticPerfectlyPlastic(1e9, 0.3, hardness), rc.ElasticPerfectlyPlastic(1e9, 0.3, 2.5e6)
    np.testing.assert_array_equal(combined_pressure_limit(patchy, uniform), np.minimum(hardness, 2.5e6))
    other = rc.ElasticPerfectlyPlastic(1e9, 0.3, np.ones((3, 3)))
    with pytest.raises(rc.InputError, match="different shapes"):
        combined_pressure_limit(patchy, other)


class TestTypicalMaterials:
    """Named in a script, in a study file and on the command line, they are the same material."""

    def test_in_a_script(self):
        glass = rc.Body(rc.FlatSurface(), "glass").material
        assert (glass.young, glass.poisson, glass.hardness) == (70e9, 0.22, 5.5e9)
        assert isinstance(rc.Body(rc.FlatSurface(), "rubber").material, rc.Elastic)
        assert rc.Body(rc.FlatSurface(), "rigid").material == rc.Rigid()
        with pytest.raises(rc.InputError, match=r"There is no material named 'bras'\. Did you mean 'brass'"):
            rc.Body(rc.FlatSurface(), "bras")
        with pytest.raises(rc.InputError, match="a Material, or the name of one"):
            rc.Body(rc.FlatSurface(), 210e9)

    def test_values_are_those_of_solids(self):
        for name, material in TYPICAL.items():
            assert 1e6 < material.young < 1e12, name
            assert 0.2 <= material.poisson < 0.5, name
            # Tabor: about three times a yield stress of a thousandth to a twentieth of the modulus.
            assert 3e-3 < getattr(material, "hardness", 0.01 * material.young) / material.young < 0.1, name

    def test_in_a_study_file_and_on_the_command_line(self, tmp_path, run):
        heights = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=8e-6, longest=32e-6, seed=1)
        np.savez(tmp_path / "map.npz", heights=heights.heights(rc.Grid((32, 32), 64e-6)), size=(64e-6, 64e-6))
        (tmp_path / "study.toml").write_text(
            """[problems.one]
body = {surface = {type = "file", path = "map.npz"}, material = "brass"}
counterbody = {surface = "flat", material = "bearing steel"}
[study]
force = [0.01]
"""
        )
        study = read_study(tmp_path / "study.toml")
        (problem,) = study.problems.values()
        named = rc.Body(rc.read_surface(tmp_path / "map.npz"), "brass")
        same = rc.ContactProblem(named, rc.Body(rc.FlatSurface(), "bearing steel"))
        expected = same.solve(force=0.01).area().value
        assert problem.solve(force=0.01).area().value == expected
        options = ("--material", "brass", "--counterbody-material", "bearing steel")
        _, out, _ = run("solve", tmp_path / "map.npz", "--force", "0.01N", *options, "--json")
        assert json.loads(out)["area"]["value"] == expected
        _, _, err = run("solve", tmp_path / "map.npz", "--force", "1N", "--material", "brass", "--hardness", "1GPa")
        assert "--hardness is for a Young's modulus: 'brass' has its own." in err
        _, _, err = run("solve", tmp_path / "map.npz", "--force", "1N", "--material", "bras")
        assert "brass" in err
