"""Line scans: what they tell of a surface, and how they are read."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

SIDE = 512


def make_surface(seed, peklenik=1.0, lay=0.0, longest=64e-6):
    """Return the heights of a surface of 64 of the shortest waves a side, and its rms slope."""
    surface = rc.SelfAffineSurface(
        hurst=0.7, rms_slope=0.1, shortest=8e-6, longest=longest, rolloff=64e-6, peklenik=peklenik, lay=lay, seed=seed
    )
    return surface.heights(rc.Grid((SIDE, SIDE), SIDE * 1e-6))


def test_a_wave_has_its_slope_and_height():
    x = np.arange(640) * 1e-6
    wave = 2e-7 * np.sin(2.0 * np.pi * x / 20e-6)
    found = rc.reference.profile(wave + 3e-6 + 0.01 * x, 1e-6, isotropic=True)
    slope = 2e-7 * 2.0 * np.pi / 20e-6 / np.sqrt(2.0)
    assert found.Rq.value == pytest.approx(2e-7 / np.sqrt(2.0), rel=2e-3)
    assert found.Rdq.value == pytest.approx(slope, rel=4e-3)
    assert found.Sdq.value == pytest.approx(np.sqrt(2.0) * slope, rel=4e-3)
    assert found.m2.value == pytest.approx(slope**2, rel=8e-3)
    crossed = rc.reference.profile(wave, 1e-6, across=3.0 * wave)
    assert crossed.Sdq.value == pytest.approx(np.sqrt(10.0) * slope, rel=4e-3)
    assert crossed.Rdq_across.value == pytest.approx(3.0 * slope, rel=4e-3)
    # Persson's area of a wave vector's slope.
    area = found.persson_area("10MPa", "1GPa")
    assert area.value == pytest.approx(np.sqrt(8.0 / np.pi) * 0.01 / found.Sdq.value, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("laid", [False, True])
def test_the_slope_is_within_its_uncertainty(laid):
    misses = []
    for seed in range(24):
        heights = make_surface(seed, peklenik=3.0 if laid else 1.0, lay=0.4 * seed % np.pi)
        places = np.arange(4) * 128 + 5 * seed
        kinds = {"across": heights[places]} if laid else {"isotropic": True}
        found = rc.reference.profile(heights[:, places].T, 1e-6, **kinds).Sdq
        misses.append((found.value - 0.1) / found.uncertainty)
    assert np.mean(np.abs(misses) < 2.0) > 0.85
    assert 0.6 < np.sqrt(np.mean(np.square(misses))) < 1.4


def test_without_a_statement_there_is_no_slope_of_the_surface():
    heights = make_surface(1, peklenik=4.0)
    found = rc.reference.profile(heights[:, ::64].T, 1e-6)
    assert found.Sdq is None
    assert found.m2 is None
    # The lay is along x.
    assert found.Rdq.value < 0.5 * 0.1 / np.sqrt(2.0)
    with pytest.raises(rc.InputError, match="there is no Sdq"):
        found.persson_area(1e6, 1e9)


def test_lines_side_by_side_are_found():
    heights = make_surface(2)
    apart = rc.reference.profile(heights[:, ::64].T, 1e-6, isotropic=True).Sdq
    beside = rc.reference.profile(heights[:, :8].T, 1e-6, isotropic=True).Sdq
    assert apart.warnings == ()
    assert [text.rule for text in beside.warnings] == ["lines side by side"]
    assert beside.uncertainty > 1.5 * apart.uncertainty
    assert beside.value == pytest.approx(0.1, abs=2.5 * beside.uncertainty)


def test_a_surface_of_the_same_spectrum():
    found = rc.reference.fit_surface(make_surface(3, longest=512e-6)[:, ::64].T, 1e-6, "8um", seed=5)
    assert found.hurst.value == pytest.approx(0.7, abs=2.0 * found.hurst.uncertainty)
    assert found.rolloff.value == pytest.approx(64e-6, abs=2.5 * found.rolloff.uncertainty)
    assert found.hurst.uncertainty < 0.2
    assert found.surface.rms_slope == pytest.approx(0.1, rel=0.1)
    assert found.surface.seed == 5


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: rc.reference.profile(np.zeros(10), 1e-6), "at least 32 points"),
        (lambda: rc.reference.profile(np.arange(64.0), 1e-6), "The lines are straight"),
        (lambda: rc.reference.profile(np.full(64, np.nan), 1e-6), "The lines must be heights"),
        (lambda: rc.reference.profile(np.zeros((2, 2, 64)), 1e-6), "The lines must be heights"),
        (lambda: rc.reference.profile(np.eye(64), 0.0), "The spacing of the points must be"),
        (lambda: rc.reference.profile(np.eye(64), 1e-6, isotropic=True, across=np.eye(64)), "tell of any lay"),
        (lambda: rc.reference.fit_surface(np.eye(64)[:4], 1e-6, 8e-6), "at least 5 for a spectrum"),
        (lambda: rc.reference.fit_surface(np.eye(64), 1e-6, 2e-6), "shortest wavelength must be from four points"),
    ],
)
def test_what_tells_nothing_is_refused(call, sentence):
    with pytest.raises(rc.InputError, match=sentence):
        call()


def test_line_scans_are_read(tmp_path):
    heights = 1e-7 * np.random.default_rng(0).standard_normal((3, 40))
    x = 5e-7 * np.arange(40)
    files = {
        "one.txt": (heights[:1].T, {"spacing": "500nm"}),
        "row.csv": (heights[:1], {"spacing": 5e-7}),
        "columns.txt": (heights.T, {"spacing": 5e-7}),
        "rows.csv": (heights, {"spacing": 5e-7}),
        "placed.txt": (np.column_stack([x, *heights]), {}),
        "micro.txt": (1e6 * np.column_stack([x, heights[0]]), {"unit": "um", "position_unit": "um"}),
    }
    for name, (table, options) in files.items():
        np.savetxt(tmp_path / name, table, delimiter="," if name.endswith("csv") else " ")
        found = rc.read_profile(tmp_path / name, **options)
        assert found.spacing == pytest.approx(5e-7, rel=1e-9), name
        np.testing.assert_allclose(found.heights, heights[: len(found.heights)], rtol=1e-12)
        assert len(found.heights) == (3 if table.size > 80 else 1), name
    np.save(tmp_path / "one.npy", heights[0])
    np.testing.assert_array_equal(rc.read_profile(tmp_path / "one.npy", spacing=1e-6).heights, heights[:1])
    text = "x (mm);z (um)\n" + "\n".join(f"{1e3 * a:.5f};{1e6 * b:.5f}" for a, b in zip(x, heights[0], strict=True))
    (tmp_path / "named.csv").write_text(text.replace(".", ","))
    found = rc.read_profile(tmp_path / "named.csv")
    np.testing.assert_allclose(found.heights, heights[:1], atol=1e-11)
    assert found.history == ("read from named.csv: 1 line of 40 points, 500 nm apart, 20 µm long, heights in um",)


@pytest.mark.parametrize(
    ("text", "options", "sentence"),
    [
        ("1\n2\n", {"spacing": 1e-6}, "lines of 2 points"),
        ("\n".join("123456789"), {}, "does not state the positions"),
        ("\n".join(f"{k} {k % 3}" for k in range(20)), {"spacing": 2.0}, "which is not the spacing given"),
        ("\n".join(f"{k % 3}" for k in range(20)), {"spacing": 1.0, "position_unit": "um"}, "has no positions"),
        ("x (mm) z (um)\n" + "\n".join(f"{k} {k % 3}" for k in range(20)), {"unit": "nm"}, "states its own unit"),
        ("\n".join(f"{k} nan" for k in range(20)), {}, "20 points have no height"),
        ("no numbers", {"spacing": 1.0}, "cannot be used"),
    ],
)
def test_files_that_are_no_line_scans_are_refused(tmp_path, text, options, sentence):
    (tmp_path / "x.txt").write_text(text)
    with pytest.raises(rc.InputError, match=sentence):
        rc.read_profile(tmp_path / "x.txt", **options)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(rc.InputError, match="There is no file"):
        rc.read_profile(tmp_path / "x.txt")
