from __future__ import annotations

import json

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.faces import TYPICAL
from unit_files import read_study

GRID = rc.Grid((16, 12), 1e-4)


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

    def test_those_of_installed_distributions(self, tmp_path, monkeypatch):
        (tmp_path / "somebody_elses_metals.py").write_text(
            "import roughcontact as rc\nMETAL = rc.Elastic('30GPa', 0.4)\nOTHER = 1\n"
        )
        for number, points in enumerate(("lead = {0}:METAL\ntin = {0}:OTHER\nbrass = {0}:METAL", "zinc = {0}:METAL")):
            metadata = tmp_path / f"metals_{number}-1.0.dist-info"
            metadata.mkdir()
            (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: metals-{number}\nVersion: 1.0\n")
            gold = ("METAL", "OTHER")[number]
            text = f"[roughcontact.typical]\n{points}\ngold = {{0}}:{gold}\nno = {{0}}:ABSENT\n"
            (metadata / "entry_points.txt").write_text(text.format("somebody_elses_metals"))
        monkeypatch.syspath_prepend(tmp_path)
        found = type(TYPICAL)({"brass": TYPICAL["brass"]})
        assert {"lead", "tin", "brass", "zinc", "gold"} < {*found}
        assert len(found) == len([*found])
        assert "lead" in found
        assert found["lead"] == found["zinc"] == rc.Elastic(30e9, 0.4)
        # What ships is not replaced.
        assert found["brass"].young == 100e9
        for name, sentence in (
            ("tin", "The typical material 'tin' must be a Material"),
            ("gold", "is claimed by"),
            ("no", "cannot be loaded: AttributeError"),
        ):
            with pytest.raises(rc.InputError, match=sentence):
                found[name]

    def test_any_registered_material_on_the_command_line(self, tmp_path, run):
        np.savez(tmp_path / "map.npz", heights=rc.WavySurface(1e-7, 5e-5).heights(GRID), size=GRID.size)
        command = ("solve", tmp_path / "map.npz", "--force", "0.01N", "--json")
        _, out, _ = run(*command, "--young", "210GPa", "--counterbody-young", "70GPa", "--counterbody-hardness", "5GPa")
        body = ("--material", "elastic", "--fields", "young=210GPa", "poisson=0.3")
        fields = ("young=70GPa,poisson=0.3", "hardness=5GPa")
        counterbody = ("--counterbody-material", "elastic-perfectly-plastic", "--counterbody-fields", *fields)
        _, again, _ = run(*command, *body, *counterbody)
        for key in ("area", "approach", "inputs"):
            assert json.loads(again)[key] == json.loads(out)[key]

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ("--material brass --fields young=1GPa", "--material must be one of"),
            ("--young 1GPa --fields young=1GPa", "but got None"),
            ("--material elastic", "--material elastic: required field 'young' is missing"),
            (
                "--material elastic --fields young=1GPa poisson=0.3 --hardness 1GPa",
                "--hardness is for a Young's modulus",
            ),
            ("--young 1GPa --counterbody-fields young=1GPa", "--counterbody-fields needs --counterbody-material"),
            (
                "--material elastic --fields young=1GPa poisson.a=1 poisson.a=2",
                "--material elastic has poisson.a twice",
            ),
            ("--material elastic --fields poisson=1 poisson.a=2", "--material elastic has poisson.a twice"),
        ],
    )
    def test_wrong_fields_are_named(self, tmp_path, run, options, words):
        np.savez(tmp_path / "map.npz", heights=np.zeros((8, 8)), size=1e-4)
        status, _, err = run("solve", tmp_path / "map.npz", "--force", "1N", *options.split())
        assert status == 2
        assert words in " ".join(err.split())
