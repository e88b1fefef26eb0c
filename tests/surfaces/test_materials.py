from __future__ import annotations

import json

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.faces import TYPICAL
from unit_files import read_study


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
