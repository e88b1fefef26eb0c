"""Studies in TOML, and the command that runs them."""

from __future__ import annotations

import re

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.faces import build_problem
from scenes import ROUGH
from unit_files import read_study

STUDY = """
[problems.rough]
boundary = "periodic"
grid = {shape = [48, 48], size = 1e-4}
[problems.rough.body]
surface = {type = "self-affine", hurst = 0.8, rms_height = 1e-7, longest = 1e-4, shortest = 8e-6, seed = 5}
material = {type = "elastic-perfectly-plastic", young = 210e9, poisson = 0.3, hardness = 6e9}
[problems.ball]
grid = {shape = [48, 48], size = 1e-4}
solver = {type = "projected-cg", tolerance = 1e-9}
[problems.ball.body]
surface = {type = "sum", parts = [{type = "sphere", radius = 5e-3}, {type = "file", path = "map.npz", detrend = 1}]}
material = {type = "elastic", young = 210e9, poisson = 0.3}
[study]
force = [0.1, 1.0]
areas = ["blend", "cell-count"]
"""


@pytest.fixture
def study_file(tmp_path):
    np.savez(tmp_path / "map.npz", heights=1e-8 * np.random.default_rng(0).random((48, 48)), size=1e-4)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


class TestFiles:
    """Studies in TOML."""

    def test_a_file_is_the_objects_it_says(self, study_file):
        read = read_study(study_file)
        assert [load.arguments for load in read.loads] == [{"force": 0.1}, {"force": 1.0}]
        assert read.problems["rough"].body.surface == ROUGH
        assert read.problems["rough"].boundary == "periodic"
        assert read.problems["ball"].solver == rc.ProjectedConjugateGradient(tolerance=1e-9)
        assert "less" not in read.explain()
        assert "the best plane subtracted" in read.explain()

    def test_the_command_runs_and_goes_on(self, study_file, capsys):
        assert main(["run", str(study_file), "--dry-run"]) == 0
        assert "4: 2 of problem x 2 of force" in capsys.readouterr().out
        assert main(["run", str(study_file)]) == 0
        folder = study_file.with_suffix("")
        out = capsys.readouterr().out
        printed = out.split()
        begins = f"4 solves, 4 of them now, in {folder}".split()
        # Only estimates are doubtful, which leaves the status at 0, as of `solve`.
        assert printed[: len(begins)] == begins
        assert "warning The contact area is uncertain: the" in " ".join(printed)
        assert max(map(len, out.splitlines())) <= 80
        lines = [line.split() for line in out.splitlines()]
        start = next(place for place, line in enumerate(lines) if line[:4] == ["problem", "load", "area", "blend,"])
        assert [line[:3] for line in lines[start + 1 : start + 5]] == [
            [name, load, unit] for name in ("rough", "ball") for load, unit in (("100", "mN"), ("1", "N"))
        ]
        unit = {"µm2": 1e-12, "nm2": 1e-18}[lines[start][4]]
        for line, record in zip(lines[start + 1 :], read_study(study_file).run(folder), strict=False):
            area, uncertainty = record.areas["blend"]
            assert float(line[3]) * unit == pytest.approx(area, abs=0.1 * uncertainty)
            assert float(line[5]) * unit == pytest.approx(uncertainty, rel=0.06)
        assert main(["run", str(study_file), "--workers", "2"]) == 0
        assert "0 of them now" in capsys.readouterr().out
        assert (folder / "records.csv").read_text().count("CONVERGED") == 4

    def test_the_command_prints_each_warning_once_and_ends_as_solve_does(self, study_file, capsys):
        text = study_file.read_text().replace("young = 210e9, poisson = 0.3}", "young = 210, poisson = 0.3}")
        study_file.write_text(text.replace("force = [0.1, 1.0]", "force = [1e-11, 1e-10]"))
        assert main(["run", str(study_file)]) == 3
        printed = " ".join(capsys.readouterr().out.split())
        assert printed.count("A Young's modulus of 210 Pa is that of a foam or a gel.") == 1
        assert "and the unit of heights from a file. [2 of 4 solves]" in printed
        assert main(["run", str(study_file)]) == 3

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ("hurst = 0.8", "hurts = 0.8", "required field 'hurst' is missing @ problems.rough.body.surface"),
            ("hurst = 0.8", "hurst = 0.8, hurts = 1", "unknown field 'hurts' (did you mean 'hurst'?) @ problems.rough"),
            (
                '"periodic"',
                '"perodic"',
                "'wrapped', 'free-periodic', 'periodic-free', but got 'perodic'. @ problems.rough",
            ),
            ('"sphere"', '"shere"', "Did you mean 'sphere'? Known:"),
            (
                "young = 210e9",
                "young = -1",
                "Young's modulus must be a finite number, above 0 (Pa), but got -1. @ problems.rough.body.material",
            ),
            ("[study]", "[studi]", "unknown table (did you mean 'study'?) @ studi"),
            ("force =", "forces =", "unknown field 'forces' (did you mean 'force'?) @ study"),
            ("parts =", "part =", "unknown field 'part' (did you mean 'parts'?)"),
            ("[problems.ball]", "[problems.ball", "is not TOML"),
            ("0.1, 1.0", "1e9", "more than the bodies can carry"),
            ('path = "map.npz"', 'path = "none.npz"', "There is no file"),
            ("detrend = 1", "detrand = 1", "unknown field 'detrand' (did you mean 'detrend'?)"),
            ('type = "projected-cg"', 'typ = "projected-cg"', "with the name as type"),
            ("shape = [48, 48], ", "", "required field 'shape' is missing @ problems.rough.grid"),
            (
                '"map.npz"',
                '"../map.npz"',
                "must be that of a file in the folder of the study file, but got '../map.npz'",
            ),
            ('"map.npz"', '"/etc/hostname"', "must be that of a file in the folder of the study file"),
            ('"map.npz"', '"link.npz"', "must be that of a file in the folder of the study file"),
            ('"map.npz"', "3", "must be that of a file in the folder of the study file, but got 3"),
            ('"sphere"', '"subprocess:Popen"', "There is no surface named 'subprocess:Popen'"),
            ("seed = 5", f"seed = {'9' * 5000}", "is not TOML: Exceeds the limit"),
            ("force = [0.1, 1.0]", f"force = {'[' * 5000}", "is not TOML"),
        ],
    )
    def test_what_is_wrong_is_named_with_its_path(self, study_file, capsys, old, new, words):
        (study_file.parent / "link.npz").symlink_to("/etc/hostname")
        study_file.write_text(STUDY.replace(old, new, 1))
        assert main(["run", str(study_file), "--dry-run"]) == 2
        error = capsys.readouterr().err
        assert words in error
        assert error.startswith(("roughcontact: In study.toml:", "roughcontact: The file study.toml"))


TABLE = {
    "body": {"surface": {"type": "sphere", "radius": "1mm"}, "material": {"young": "210GPa", "poisson": 0.3}},
    "grid": {"shape": (24, 12), "size": ("120um", 60e-6)},
}


class TestTables:
    """Problems in tables, of a script."""

    def test_a_table_is_the_objects_it_says(self):
        found = build_problem(TABLE)
        body = rc.Body(rc.SphereSurface(1e-3), rc.Elastic(210e9, 0.3))
        expected = rc.ContactProblem(body, grid=rc.Grid((24, 12), (120e-6, 60e-6)))
        assert found.parts | {"kernel": "love"} == expected.parts

    def test_parts_may_be_objects_or_names(self):
        law = rc.Exponential(work=0.05, range=60e-9)
        texts = {"type": "exponential", "work": "50mJ/m2", "range": "60nm"}
        made = [build_problem({**TABLE, "kernel": rc.Love(), "adhesion": one}) for one in (law, texts)]
        assert made[0].adhesion is law
        assert attrs.asdict(made[1].adhesion) == attrs.asdict(law)
        assert build_problem({**TABLE, "adhesion": None}).adhesion is None

    def test_a_hardness_makes_the_material_plastic(self):
        steel = {"young": "210GPa", "poisson": 0.3, "hardness": "6GPa"}
        material = build_problem({**TABLE, "counterbody": {"surface": "flat", "material": steel}}).counterbody.material
        assert type(material) is rc.ElasticPerfectlyPlastic
        assert material.hardness == 6e9

    def test_classes_of_a_script_have_a_form(self, monkeypatch):
        class Step(rc.Surface):
            def __init__(self, height):
                self.height = height

            def heights(self, grid):
                return self.height * (grid.x > 0.0) + 0.0 * grid.y

        monkeypatch.setitem(rc.surfaces._classes, "step", Step)
        body = {"surface": {"type": "step", "height": 1e-7}, "material": "glass"}
        assert build_problem({**TABLE, "body": body}).body.surface.height == 1e-7
        body["surface"]["depth"] = 1.0
        with pytest.raises(rc.InputError, match=re.escape("unknown field 'depth' (known: height)")):
            build_problem({**TABLE, "body": body})

    @pytest.mark.parametrize(
        ("changed", "words"),
        [
            ({"body": 3}, "A Body must be a table of its fields, but got 3."),
            ({"grid": [24, 24]}, "A Grid must be a table of its fields"),
            ({"boundaries": "free"}, "unknown field 'boundaries' (did you mean 'boundary'?)"),
            ({"adhesion": {"type": "exponential"}}, "required field 'work' is missing"),
            ({"adhesion": {"type": "exponential", "work": "1N", "range": 1e-9}}, "is not a quantity in units of J/m2"),
            ({"body": {**TABLE["body"], "surface": {"type": "sum", "parts": 1}}}, "must be a list, but got 1."),
            ({"body": {**TABLE["body"], "surface": {"type": "file", "path": "x.npz"}}}, "Only a study file names"),
            ({"match": 1}, "The entry 'match' must be a table"),
            ({"match": {}}, "Maps are matched in pairs: the counterbody is missing."),
            ({"match": {}, "counterbody": TABLE["body"]}, "Maps are matched in pairs: the body has 0 height maps."),
        ],
    )
    def test_what_is_wrong_is_a_sentence(self, changed, words):
        with pytest.raises(rc.InputError, match=re.escape(words)):
            build_problem({**TABLE, **changed})


class TestMatchedPairs:
    """Two maps on different grids, in a study file."""

    @pytest.fixture
    def pair_file(self, tmp_path):
        rng = np.random.default_rng(3)
        np.savez(tmp_path / "low.npz", heights=1e-7 * rng.random((32, 20)), size=(32e-6, 20e-6))
        np.savez(tmp_path / "high.npz", heights=1e-7 * rng.random((27, 27)), size=(40e-6, 30e-6))
        (tmp_path / "pair.toml").write_text("""
[problems.pair]
match = {interpolation = "cubic", offset = ["1um", "-2um"], rotation = "5deg", mirrored = true, shape = [30, 18]}
[problems.pair.body]
surface = {type = "sum", parts = [{type = "file", path = "low.npz"}, {type = "sphere", radius = "1mm"}]}
material = "bearing steel"
[problems.pair.counterbody]
surface = {type = "file", path = "high.npz"}
material = "glass"
[study]
force = ["50mN"]
""")
        return tmp_path / "pair.toml"

    def test_is_the_pair_of_a_script_and_of_the_command_line(self, pair_file, capsys):
        (problem,) = read_study(pair_file).problems.values()
        low, high = (rc.read_surface(pair_file.parent / name) for name in ("low.npz", "high.npz"))
        placed = {"offset": (1e-6, -2e-6), "rotation": np.deg2rad(5.0), "mirrored": True}
        pair = rc.match(low, high, interpolation="cubic", shape=(30, 18), **placed)
        body = rc.Body(pair.body + rc.SphereSurface(1e-3), "bearing steel")
        expected = rc.ContactProblem(body, rc.Body(pair.counterbody, "glass"), grid=pair.grid)
        assert problem.plan.grid == pair.grid
        np.testing.assert_array_equal(problem.initial_gap, expected.initial_gap)
        maps = [str(pair_file.parent / name) for name in ("low.npz", "high.npz")]
        materials = ["--material", "bearing steel", "--counterbody-material", "glass"]
        how = ["--match", "cubic", "--offset", "1um,-2um", "--rotation", "5deg", "--mirror", "--resample", "30", "18"]
        saved = pair_file.with_name("pair.npz")
        load = ["--ball", "1mm", "--force", "50mN", "-o", str(saved)]
        assert main(["solve", *maps, *materials, *how, *load]) in (0, 3)
        capsys.readouterr()
        np.testing.assert_array_equal(rc.ContactSolution.load(saved).gap, problem.solve(force=0.05).gap)

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ("mirrored", "mirror", "unknown field 'mirror' (did you mean 'mirrored'?) @ problems.pair"),
            ('"5deg"', '"5"', "The rotation of a map: '5' has no unit"),
            ('["1um", "-2um"]', '["1mm", "-2um"]', "do not overlap"),
            ('"cubic"', '"quadratic"', "The interpolation must be"),
        ],
    )
    def test_what_is_wrong_has_its_place(self, pair_file, capsys, old, new, words):
        pair_file.write_text(pair_file.read_text().replace(old, new))
        assert main(["run", str(pair_file), "--dry-run"]) == 2
        error = capsys.readouterr().err
        assert words in error
        assert "@ problems.pair" in error
