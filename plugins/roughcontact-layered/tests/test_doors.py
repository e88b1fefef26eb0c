"""Layers by the command line and by study files."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.faces import build_problem

from roughcontact_layered import Layer, LayeredKernel, PairKernel

RIGID = rc.Rigid()
STEEL = rc.Elastic(210e9, 0.3)
HARD = Layer(400e9, 0.25, 3e-6, yield_stress=8e9)
SOFT = Layer(60e9, 0.3, 2e-6)
HARD_TEXT = "young=400GPa poisson=0.25 thickness=3um yield=8GPa"
SOFT_TEXT = "young=60GPa poisson=0.3 thickness=0.002mm"
# Cells 1:3, odd numbers of them.
GRID = rc.Grid((63, 27), (84e-6, 108e-6))


@pytest.fixture
def ball(tmp_path):
    path = tmp_path / "ball.npz"
    np.savez(path, heights=rc.ParaboloidSurface(1e-3).heights(GRID), size=GRID.size)
    return path


def solve(capsys, *arguments):
    status = main(["solve", *map(str, arguments)])
    found = capsys.readouterr()
    return status, found.out, found.err


def read_layers(*texts, option="--layer"):
    return [part for text in texts for part in (option, *text.split())]


def solve_as_script(kernel, body=STEEL, counterbody=RIGID, boundary="free"):
    bodies = rc.Body(rc.ParaboloidSurface(1e-3), body), rc.Body(rc.FlatSurface(), counterbody)
    return rc.ContactProblem(*bodies, grid=GRID, boundary=boundary, kernel=kernel).solve(force=2.0)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize(
    ("texts", "layers"), [((HARD_TEXT, SOFT_TEXT), (HARD, SOFT)), ((SOFT_TEXT, HARD_TEXT), (SOFT, HARD))]
)
def test_layers_of_the_command_line_are_those_of_a_script(ball, capsys, texts, layers, boundary):
    given = ["--force", "2N", "--young", "210GPa", "--boundary", boundary, *read_layers(*texts), "--json"]
    _, out, _ = solve(capsys, ball, *given)
    found = json.loads(out)
    expected = solve_as_script(LayeredKernel(layers, STEEL, carrier="body"), boundary=boundary)
    # Heights of a map are known at the cells alone, so that its area may be another one.
    assert found["approach"]["value"] == pytest.approx(expected.approach, rel=1e-6)
    assert found["peak_pressure"]["value"] == pytest.approx(expected.peak_pressure().value, rel=1e-3)
    stated = found["inputs"]["body"]["layers"]
    assert [one["young"] for one in stated] == [{"value": one.young, "unit": "Pa"} for one in layers]
    assert [one["thickness"]["value"] for one in stated] == [one.thickness for one in layers]
    assert "layers" not in found["inputs"]["counterbody"]
    assert "roughcontact_layered.LayeredKernel(" in found["inputs"]["kernel"]


def test_layers_lie_on_the_body_that_is_named(ball, capsys):
    # Two bodies of one material: only the name says which is coated, and the stress depends on it.
    given = ["--force", "2N", "--young", "210GPa", "--counterbody-young", "210GPa"]
    asked = ["--stress", "depths=20um,30um", "body=body", "--quiet", "-o"]
    stress = {}
    for option in ("--layer", "--counterbody-layer"):
        target = ball.with_name(f"{option}.json")
        solve(capsys, ball, *given, *read_layers(SOFT_TEXT, option=option), *asked, target)
        stress[option] = json.loads(target.read_text())["responses"]["stress"]["von_mises"]["value"]
    for carrier, option in (("body", "--layer"), ("counterbody", "--counterbody-layer")):
        solution = solve_as_script(LayeredKernel(SOFT, STEEL, carrier=carrier), counterbody=STEEL)
        expected = solution.stress(depths=[20e-6, 30e-6]).maximum.value
        assert stress[option] == pytest.approx(expected, rel=1e-4)
    assert stress["--layer"] != pytest.approx(stress["--counterbody-layer"], rel=1e-3)


def test_both_bodies_have_layers(ball, capsys):
    layers = [*read_layers(HARD_TEXT), *read_layers(SOFT_TEXT, option="--counterbody-layer")]
    given = ["--force", "2N", "--young", "210GPa", "--counterbody-material", "glass", *layers, "--json"]
    found = json.loads(solve(capsys, ball, *given)[1])
    glass = rc.Elastic(70e9, 0.22)
    pair = PairKernel(LayeredKernel(HARD, STEEL), LayeredKernel(SOFT, glass))
    assert found["approach"]["value"] == pytest.approx(solve_as_script(pair, counterbody=glass).approach, rel=1e-6)
    assert [len(found["inputs"][name]["layers"]) for name in ("body", "counterbody")] == [1, 1]


def test_layers_without_a_material_lie_on_a_rigid_base(ball, capsys):
    pad = Layer(2e9, 0.49, 50e-6)
    given = [
        "--force",
        "2mN",
        "--young",
        "210GPa",
        "--counterbody-layer",
        "young=2GPa",
        "poisson=0.49",
        "thickness=50um",
    ]
    found = json.loads(solve(capsys, ball, *given, "--json")[1])
    kernel = LayeredKernel(pad, rc.Rigid())
    bodies = rc.Body(rc.ParaboloidSurface(1e-3), STEEL), rc.Body(rc.FlatSurface(), rc.Elastic(2e9, 0.49))
    expected = rc.ContactProblem(*bodies, grid=GRID, kernel=kernel).solve(force=2e-3)
    assert found["approach"]["value"] == pytest.approx(expected.approach, rel=1e-6)


def test_a_typical_material_under_layers_has_no_hardness(ball, capsys):
    given = ["--force", "20N", "--material", "structural steel", *read_layers(HARD_TEXT)]
    _, out, _ = solve(capsys, ball, *given, "--dry-run")
    assert "pressure limit none" in " ".join(out.split())
    assert "1 layer on the body: 3 µm of 400 GPa, Poisson's ratio 0.25, yield stress 8 GPa" in " ".join(out.split())
    _, out, _ = solve(
        capsys, ball, "--force", "20N", "--young", "210GPa", "--hardness", "9GPa", *given[4:], "--dry-run"
    )
    assert "pressure limit 9 GPa" in " ".join(out.split())


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("--layer young=400 poisson=0.25 thickness=2um", "--layer young: '400' has no unit"),
        ("--layer yong=400GPa poisson=0.25 thickness=2um", "--layer: unknown field 'yong' (did you mean 'young'?)"),
        ("--layer young=400GPa thickness=2um", "--layer: required field 'poisson' is missing"),
        ("--layer young=4GPa poisson=0.2 thickness=-2um", "--layer: The thickness of a layer must be a finite number"),
        ("--layer young=4GPa poisson=0.7 thickness=2um", "--layer: Poisson's ratio must be"),
        ("--layer young=4GPa poisson=0.2 thickness=2um thickness=1um", "--layer has thickness twice"),
        ("--layer 4GPa", "A field of --layer must be FIELD=VALUE"),
        (f"--layer {HARD_TEXT} --layer young=4GPa poisson=0.2 thickness=0m", "--layer 2: The thickness of a layer"),
        (f"--counterbody-layer {HARD_TEXT.replace('GPa', 'kg')}", "--counterbody-layer young: '400kg' is not"),
        (f"--layer {HARD_TEXT} --kernel love", "omit --kernel, or the layers"),
        ("--kernel layered", "--kernel layered needs layers: give --layer"),
        ("--kernel layerd", "There is no kernel named 'layerd'. Did you mean 'layered'?"),
        ("--kernel graded gradient=1e4m-1 slope=3", "unknown field 'slope'"),
    ],
)
def test_wrong_layers_are_explained(ball, capsys, given, words):
    status, out, err = solve(capsys, ball, "--force", "1N", "--young", "210GPa", *given.split())
    assert (status, out) == (2, "")
    assert words in " ".join(err.split())


def test_fields_of_a_kernel_are_given_behind_its_name(ball, capsys):
    _, out, _ = solve(
        capsys, ball, *["--force", "1N", "--young", "210GPa", "--kernel", "graded", "gradient=1e4m-1", "--dry-run"]
    )
    assert "Graded Kernel, gradient 10000.0, surface Elastic (young 210000000000.0" in " ".join(out.split())


def test_without_the_plug_in_a_sentence_says_what_to_install(ball, capsys, monkeypatch):
    from roughcontact._base.archive.plain import parts

    monkeypatch.setattr(parts, "_installed", {})
    monkeypatch.setattr(parts, "_classes", {})
    status, _, err = solve(capsys, ball, "--force", "1N", "--young", "210GPa", *read_layers(HARD_TEXT))
    assert status == 2
    assert "pip install roughcontact-layered" in err
    with pytest.raises(rc.MissingPackage, match="roughcontact-layered"):
        build_problem({"body": {"surface": "flat", "layers": []}, "grid": {"shape": [8, 8], "size": 1e-3}})


STUDY = """
[problems.coated]
grid = {shape = [31, 17], size = ["84 um", "108 um"]}
boundary = "periodic"
adhesion = {type = "exponential", work = "50 J/m2", range = "0.4 um"}

[problems.coated.body]
surface = {type = "paraboloid", radius = "1 mm"}
material = "bearing steel"
layers = [
    {young = "400 GPa", poisson = 0.25, thickness = "3 um", yield_stress = "8 GPa"},
    {young = "60 GPa", poisson = 0.3, thickness = "2 um"},
]

[study]
force = [2.0]
responses = ["pull-off", {type = "first-yield", yield_stress = "2 GPa"}]
"""


def test_a_coated_ball_its_first_yield_and_pull_off_in_one_line_and_one_study(tmp_path, capsys):
    ball = tmp_path / "ball.npz"
    size = (84e-6, 108e-6)
    np.savez(ball, heights=rc.ParaboloidSurface(1e-3).heights(rc.Grid((31, 17), size)), size=size)
    adhesion = ["--adhesion", "exponential", "work=50J/m2", "range=0.4um", "--boundary", "periodic"]
    asked = ["--pull-off", "--first-yield", "2GPa", "--json"]
    given = ["--force", "2N", "--material", "bearing steel", *read_layers(HARD_TEXT, SOFT_TEXT), *adhesion, *asked]
    status, out, err = solve(capsys, ball, *given)
    assert status == 0, err
    found = json.loads(out)["responses"]
    (tmp_path / "coated.toml").write_text(STUDY)
    main(["run", str(tmp_path / "coated.toml"), "--json"])
    written = json.loads(capsys.readouterr().out)
    (record,) = written["records"]
    for name, one in (("pull-off", found["pull-off"]), ("first-yield force", found["first-yield"]["force"])):
        assert record[name] == pytest.approx(one["value"], rel=1e-3)
    # Between those of Bradley and of Johnson, Kendall and Roberts.
    assert -2.0 < record["pull-off"] / (math.pi * 50.0 * 1e-3) < -1.5
    layers = written["inputs"]["problems"]["coated"]["body"]["layers"]
    assert [one["yield_stress"]["value"] for one in layers] == [8e9, None]


@pytest.mark.parametrize(
    ("layer", "words"),
    [
        ("{young = 4e9, poisson = 0.2, thickness = -1.0}", "The thickness of a layer must be a finite number"),
        ("{young = '4 GPa', poisson = 0.2, thick = 1.0}", "unknown field 'thick' (did you mean 'thickness'?)"),
        ("{young = '4', poisson = 0.2, thickness = '1um'}", "'4' has no unit"),
    ],
)
def test_wrong_layers_of_a_study_are_explained_with_their_place(tmp_path, capsys, layer, words):
    path = tmp_path / "wrong.toml"
    path.write_text(STUDY.replace('{young = "60 GPa", poisson = 0.3, thickness = "2 um"}', layer))
    assert main(["run", str(path), "--dry-run"]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert "problems.coated.body.layers[1]" in error
