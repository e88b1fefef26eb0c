"""The measured constants of the area estimators are those that their scripts measure again."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

from roughcontact._answers.areas import calibration

ROOT = Path(__file__).parents[2]
TEXT = Path(calibration.__file__).read_text(encoding="utf-8")


def load(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_constant_says_how_and_by_which_script_it_was_measured():
    # Sections begin with the path of their script.
    _, *parts = re.split(r"^# --- (\S+): .*$", TEXT, flags=re.MULTILINE)
    scripts, sections = parts[::2], parts[1::2]
    assert all((ROOT / script).is_file() for script in scripts)
    groups = re.findall(r"((?:^#.*\n)+)((?:^[A-Z_]+ = .*\n)+)", "".join(sections), flags=re.MULTILINE)
    rows = [(comment, name) for comment, lines in groups for name in re.findall(r"^[A-Z_]+", lines, flags=re.MULTILINE)]
    assert len(rows) == len(re.findall(r"^[A-Z_]+ = ", TEXT, flags=re.MULTILINE)) == 88
    # Those of all other numbers were fitted together, as the head of their section says.
    fitted = re.findall(
        r"^[A-Z_]+(?= = )", sections[scripts.index("benchmarks/quantity_classes.py")], flags=re.MULTILINE
    )
    unmeasured = {name for comment, name in rows if "Measured" not in comment and "Set on" not in comment}
    assert unmeasured <= set(fitted)
    for section, script in zip(sections, scripts, strict=True):
        if script in ("benchmarks/area_classes.py", "benchmarks/quantity_classes.py"):
            continue  # they judge all of them together
        source = (ROOT / script).read_text(encoding="utf-8")
        for name in re.findall(r"^([A-Z_]+) = ", section, flags=re.MULTILINE):
            assert name in source or name.split("_")[0].title() in source or name.endswith("POSITION_STD"), (
                f"{name}: {script}"
            )


def test_places_of_straight_edges():
    script = load("edge_constants")
    places, traced = script.measure_straight_edges(half_width=60).T
    assert traced == pytest.approx(np.interp(places, *calibration.STRAIGHT_EDGE_PLACES), abs=0.003)


@pytest.mark.slow
def test_constants_of_the_edge():
    found = load("edge_constants").measure(80)
    assert found["PIECE_AREA_DEFICIT"] == pytest.approx(calibration.PIECE_AREA_DEFICIT, abs=0.2)
    assert found["edge shift on spheres"] == pytest.approx(0.018, abs=0.008)
    assert found["EDGE_AREA_STD"] == pytest.approx(calibration.EDGE_AREA_STD, rel=0.2)
    assert found["CUT_BORDER_STD (rms)"] <= calibration.CUT_BORDER_STD


@pytest.mark.slow
def test_constants_of_the_pressure_limit():
    growth, error = load("limit_constants").measure(4)
    assert growth == pytest.approx(calibration.PLASTIC_GROWTH[1], rel=0.002)
    assert calibration.SATURATED_POSITION_STD <= error <= 2.5 * calibration.SATURATED_POSITION_STD


@pytest.mark.slow
def test_constants_of_rough_contacts():
    found = load("rough_constants").measure(2)
    for name, value in found.items():
        if name.startswith("Hertz error"):
            # Patches of several summits are among them, which the blend hardly weights.
            assert value <= 2.0 * found[name.replace("Hertz error", "stated")]
    assert (
        max(found["HERTZ_COMMON_FRACTION, one summit"], found["HERTZ_COMMON_FRACTION, all"])
        <= calibration.HERTZ_COMMON_FRACTION
    )


@pytest.mark.slow
def test_constants_of_layers():
    pytest.importorskip("roughcontact_layered")
    found = load("layer_constants").measure()
    for unit in ("cells", "radii"):
        errors = {length: found[f"rms error with MODULUS_LENGTH, {unit} {length}"] for length in (0.25, 0.5, 1.0)}
        assert min(errors, key=errors.get) == calibration.MODULUS_LENGTH
    assert (
        0.5 * calibration.LAYERED_POSITION_STD
        <= found["LAYERED_POSITION_STD (rms)"]
        <= calibration.LAYERED_POSITION_STD
    )
    assert (
        0.5 * calibration.HERTZ_LAYERED_ERROR <= found["HERTZ_LAYERED_ERROR (rms)"] <= calibration.HERTZ_LAYERED_ERROR
    )
