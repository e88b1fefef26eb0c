"""What stands in a picture, in numbers: limits, ticks, units, bands and sizes beside what was solved or is known."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace

import attrs
import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.colors import LogNorm, to_rgba
from matplotlib.ticker import LogLocator, MaxNLocator

import roughcontact as rc
from exact_contacts import ball, with_fields
from roughcontact._faces.panels import results
from roughcontact._faces.panels.curves import _count_columns, draw_band, scale_axes
from roughcontact._faces.panels.figures import arrange, draw_panel, title_of
from roughcontact._faces.panels.maps import (
    _find_limits,
    _measure_patches,
    _spread,
    draw_edges,
    draw_map,
    draw_mask,
    length_scale,
    proportion,
    set_plane,
)
from roughcontact._faces.panels.solid import _choose, view_solution, view_surface
from roughcontact._faces.panels.solution import areas_of_patches, find_surfaces
from roughcontact._faces.panels.surfaces import average_in_bands, average_radially, correlate, spectral_density
from roughcontact._faces.panels.theme import DARK, LIGHT, plain_logarithms, theme_of
from roughcontact._work.studies import StudyNames
from roughcontact.results import ErrorReport, LawColumn, PowerFit, ReportRow, Timing


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    pyplot.close("all")


@pytest.fixture
def axes():
    with rc.plotting.style():
        yield pyplot.figure(figsize=(5.0, 4.0)).add_subplot()


def labels(axes):
    legend = axes.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


class TestMaps:
    @pytest.mark.parametrize(
        ("sides", "expected"), [((6.0, 1.0), 6.0), ((6.1, 1.0), 2.0), ((1.0, 6.0), 1 / 6), ((1.0, 6.1), 0.5)]
    )
    def test_domains_of_up_to_one_to_six_are_in_true_proportions(self, sides, expected, axes):
        grid = rc.Grid((6, 4), sides)
        assert proportion(grid) == pytest.approx(expected)
        extent = set_plane(axes, grid)
        assert axes.get_xlim() == pytest.approx(extent[:2])
        assert axes.get_ylim() == pytest.approx(extent[2:])
        assert extent == pytest.approx((-sides[0] / 2, sides[0] / 2, -sides[1] / 2, sides[1] / 2))
        # Height over width of the box as drawn, where a unit of y is `aspect` units of x long.
        assert axes.get_aspect() * sides[1] / sides[0] == pytest.approx(1.0 / expected)
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("x, m", "y, m")

    @pytest.mark.parametrize(("sides", "unit"), [((3e-6, 90e-6), "µm"), ((1.9e-3, 1e-6), "µm"), ((2.1e-3, 1e-6), "mm")])
    def test_the_unit_suits_half_the_longer_side(self, sides, unit):
        factor, named = length_scale(rc.Grid((4, 4), sides))
        assert named == unit
        assert factor == {"µm": 1e6, "mm": 1e3}[unit]

    def test_narrow_domains_have_fewer_ticks_across(self, axes):
        set_plane(axes, rc.Grid((4, 4), (1.0, 4.0)))
        assert 3 <= sum(abs(tick) <= 0.5 for tick in axes.get_xticks()) <= 4
        assert 5 <= sum(abs(tick) <= 2.0 for tick in axes.get_yticks()) <= 7

    def test_the_colours_end_at_the_percentiles_of_spiky_fields_alone(self):
        even = np.linspace(0.0, 1.0, 10_001)
        assert _spread(even) == (0.0, 1.0)
        assert _spread(np.append(even, 1.25))[1] == 1.25
        low, high = _spread(np.append(even, 9.0))
        assert (low, high) == pytest.approx((0.001, 0.999), abs=1e-3)
        assert _find_limits(np.append(even, 9.0), None, False)[2] == "both"
        assert _find_limits(even, None, False) == (0.0, 1.0, "neither")
        assert _find_limits(even, (0.5, 1.0), False)[2] == "min"
        assert _find_limits(even, (0.0, 0.5), False)[2] == "max"

    def test_uniform_fields_have_a_range_around_their_value(self):
        assert _find_limits(np.full(9, 4.0), None, False)[:2] == (2.0, 6.0)
        assert _find_limits(np.full(9, -4.0), None, False)[:2] == (-6.0, -2.0)
        assert _find_limits(np.zeros(9), None, False)[:2] == (-1.0, 1.0)
        assert _find_limits(np.full(9, 4.0), None, True)[:2] == (2.0, 8.0)
        assert _find_limits(np.array([4.0, 4.03]), None, True)[:2] == (2.0, 8.06)
        assert _find_limits(np.array([4.0, 4.05]), None, True)[:2] == (4.0, 4.05)
        low, high, _ = _find_limits(np.full(4, np.nan), None, True)
        assert 0.0 < low < high

    def test_an_image_has_the_values_in_their_places_and_a_bar_beside_it(self, axes):
        grid = rc.Grid((6, 4), (3.0, 2.0))
        values = np.arange(24.0).reshape(6, 4) + 1.0
        image = draw_map(axes, values, grid, "depth", "µm", logarithmic=True)
        assert image.origin == "lower"
        np.testing.assert_array_equal(image.get_array(), values.T)
        assert isinstance(image.norm, LogNorm)
        assert (image.norm.vmin, image.norm.vmax) == (1.0, 24.0)
        assert image.colorbar.ax.get_ylabel() == "depth, µm"
        assert image.cmap.name == "viridis"
        plain = draw_map(pyplot.figure().add_subplot(), values, grid, "share", "")
        assert plain.colorbar.ax.get_ylabel() == "share"
        assert len(plain.colorbar.get_ticks()) >= 3
        draw_mask(axes, values > 20.0, "#ff0000")
        mask = axes.images[-1]
        np.testing.assert_array_equal(~mask.get_array().mask.T, values > 20.0)
        assert mask.get_extent() == list(image.get_extent())
        assert mask.cmap(0.0) == to_rgba("#ff0000")

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_the_edge_of_a_disc_is_drawn_where_it_is(self, boundary, axes):
        """One that crosses the corner of a periodic domain is drawn four times."""
        grid = rc.Grid((40, 50), (80.0, 50.0))
        centre = (0.0, 0.0) if boundary == "free" else (40.0, 25.0)
        solution = ball(grid, 9.0, 100.0, centre, boundary)
        set_plane(axes, grid)
        draw_edges(axes, solution, "k")
        paths = [path.vertices for path in axes.collections[0].get_paths()]
        assert len(paths) == (1 if boundary == "free" else 4)
        middles = {tuple(np.round(path[:-1].mean(axis=0))) for path in paths}
        assert middles == ({(0, 0)} if boundary == "free" else {(x, y) for x in (-40, 40) for y in (-25, 25)})
        for path in paths:
            reach = np.hypot(*(path - path[:-1].mean(axis=0)).T)
            np.testing.assert_allclose(reach, 9.0, rtol=0.06)
        # Twice the area over the length, a disc's radius, in cells.
        assert _measure_patches(solution) == pytest.approx(9.0 / math.sqrt(2.0), rel=0.03)
        across = 72.0 * axes.get_window_extent().width / axes.figure.dpi
        assert axes.collections[0].get_linewidth()[0] == pytest.approx(
            min(9.0 / math.sqrt(2.0) / 8.0 * 0.3 * across / 40, 1.0), rel=0.05
        )


class TestCurves:
    def test_a_band_is_two_standard_deviations_wide(self, axes):
        x, y, std = np.array([1.0, 2.0, 4.0]), np.array([1.0, 3.0, 2.0]), np.array([0.1, 0.2, 1.5])
        line = draw_band(axes, x, y, std, label="mine")
        np.testing.assert_array_equal(line.get_xydata(), np.stack((x, y), axis=1))
        assert (line.get_label(), line.get_marker(), line.get_linestyle()) == ("mine", "o", "-")
        vertices = axes.collections[0].get_paths()[0].vertices
        for at, low, high in ((1.0, 0.8, 1.2), (2.0, 2.6, 3.4), (4.0, 0.1, 5.0)):
            there = vertices[vertices[:, 0] == at, 1]
            assert (there.min(), there.max()) == pytest.approx((low, high))
        # Below zero there are no logarithms: the band is whole.
        draw_band(axes, x, y - 2.0, std)
        vertices = axes.collections[1].get_paths()[0].vertices
        assert vertices[vertices[:, 0] == 4.0, 1].min() == pytest.approx(-3.0)
        assert [one.get_color() for one in axes.lines] == list(LIGHT.lines[:2])

    def test_axes_are_named_and_scaled(self, axes):
        axes.plot([1.0, 2000.0], [0.0, 1.0])
        scale_axes(axes, x="load, N", y="share", logarithmic="x")
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("load, N", "share")
        axes.figure.draw_without_rendering()
        shown = [text.get_text() for text in axes.get_xticklabels() if text.get_text()]
        assert {"1", "10", "100", "1000"} <= set(shown)
        assert 3 <= len(axes.get_yticks()) <= 8

    def test_logarithms_are_plain_between_a_ten_thousandth_and_ten_thousand(self, axes):
        axes.set(xscale="log", xlim=(1e-6, 1e6))
        axes.xaxis.set_major_formatter(plain_logarithms())
        axes.figure.draw_without_rendering()
        write = axes.xaxis.get_major_formatter()
        assert [write(10.0**power) for power in (-4, -1, 0, 4)] == ["0.0001", "0.1", "1", "10000"]
        assert all("10^" in write(10.0**power) for power in (-5, 5))

    def test_legends_have_as_many_columns_as_there_is_room_for(self):
        assert _count_columns([5, 5, 5], 45.0) == 3
        assert _count_columns([5, 5, 5], 44.0) == 2
        assert _count_columns([5, 5, 5], 29.0) == 1
        assert _count_columns([5, 30, 5, 5], 55.0) == 2
        assert _count_columns([5, 30, 5, 5], 54.0) == 1

    def test_the_theme_is_that_of_the_background(self, axes):
        assert theme_of(axes) is LIGHT
        for color, theme in (("black", DARK), ((0.0, 0.0, 0.0, 0.3), LIGHT), ("#0000ff", DARK), ("#00ff00", LIGHT)):
            axes.figure.set_facecolor(color)
            assert theme_of(axes) is theme
        with rc.plotting.style(dark=True):
            assert matplotlib.rcParams["axes.labelcolor"] == DARK.ink
            assert matplotlib.rcParams["axes.prop_cycle"].by_key()["color"] == list(DARK.lines)


class TestLayouts:
    @pytest.mark.parametrize("ratio", [0.2, 0.5, 0.6, 1.0, 1.7, 2.1, 2.3, 5.0])
    @pytest.mark.parametrize("kind", ["solution", "surface"])
    def test_of_maps(self, ratio, kind):
        """Wide maps stand below each other, narrow ones side by side, others in a square."""
        subject = SimpleNamespace(grid=rc.Grid((40, 40), (ratio, 1.0)))
        found = arrange(kind, subject, 4)
        expected = (2, 2)
        if kind == "solution":
            expected = (4, 1) if ratio > 2.2 else (1, 4) if ratio < 0.55 else (2, 2)
        assert (found.rows, found.columns) == expected
        width, height = found.size[0] / found.columns - 1.3, found.size[1] / found.rows - 0.65
        assert min(width, height) >= (0.8 if kind == "solution" else 2.4) - 1e-9
        assert 3.0 <= max(width, height) < 6.0
        if kind == "solution" and width > 1.31 and height > 0.81:
            assert width / height == pytest.approx(ratio)
            assert max(width, height) == pytest.approx(3.0 * max(ratio, 1.0 / ratio) ** 0.35)
        assert found.engine == ("compressed" if kind == "solution" else "constrained")
        alone = arrange(kind, subject, 1)
        assert (alone.rows, alone.columns, alone.engine) == (1, 1, "compressed")
        assert alone.size[0] >= 2.8 + 1.3
        assert alone.size[1] >= 2.4 + 0.65

    @pytest.mark.parametrize(("cells", "dpi"), [(300, 150.0), (600, 200.0), (5000, 300.0)])
    def test_each_cell_has_a_pixel_where_the_file_may_be_so_large(self, cells, dpi):
        for shape in ((cells, 10), (10, cells)):
            assert arrange("solution", SimpleNamespace(grid=rc.Grid(shape, 1.0)), 4).dpi == pytest.approx(dpi)

    def test_of_curves(self):
        found = arrange("sweep", None, 3)
        assert (found.rows, found.columns, found.dpi, found.engine) == (1, 3, 150.0, "constrained")
        assert found.size == pytest.approx((10.8, 2.9))

    def test_titles(self):
        contact = ball(rc.Grid((40, 40), 40.0), 9.0, 100.0)
        title = title_of("solution", contact)
        area = contact.area()
        percent = float(title.split("(")[1].split()[0])
        assert percent == pytest.approx(100.0 * area.fraction, rel=area.uncertainty / area.value)
        assert f"at {contact.force / 1e9:.3g} GN, free boundary" in title
        periodic = ball(rc.Grid((40, 40), 40.0), 9.0, 100.0, boundary="periodic", status=rc.Status.STALLED)
        title = title_of("solution", periodic)
        assert title.startswith("NOT CONVERGED. Contact area")
        assert f"at {periodic.mean_pressure / 1e6:.3g} MPa mean pressure, periodic boundary" in title
        heights = np.zeros((4, 6))
        heights[::2] = 2e-6
        for size, words in ((3e-6, "3 µm, 4 x 6"), ((2e-6, 3e-6), "2 µm x 3 µm, 4 x 6")):
            sampled = rc.plotting.SampledSurface(heights, rc.Grid((4, 6), size), True)
            assert title_of("surface", sampled) == f"Rms height 1 µm on {words} cells"

    def test_a_picture_of_a_page_is_a_png(self):
        assert draw_panel("solution", ball(rc.Grid((20, 20), 20.0), 5.0, 50.0), "pressure").startswith(
            "data:image/png;base64,iVBOR"
        )


class TestPanelsOfSolutions:
    @staticmethod
    def draw(axes, name, solution, **options):
        rc.panels.create(name, **options).draw(solution, axes)
        return axes

    @pytest.fixture
    def contact(self):
        """Hertz's contact in micrometres, off the centre, on oblong cells."""
        return ball(rc.Grid((40, 30), (40e-6, 60e-6)), 9e-6, 1e-3, (4.3e-6, -6.1e-6))

    @pytest.mark.parametrize("axis", [0, 1])
    def test_a_profile_fills_its_axes_but_for_a_margin(self, contact, axis, axes):
        self.draw(axes, "profile", contact, axis=axis)
        half = 0.5e6 * contact.grid.size[axis]
        assert axes.get_xlim() == pytest.approx((-half, half))
        lines = [line.get_ydata() for line in axes.lines[:2]]
        low, high = np.min(lines), np.max(lines)
        margin = 0.08 * (high - low)
        assert axes.get_ylim() == pytest.approx((low - margin, high + margin))
        assert lines[0].mean() == pytest.approx(0.0, abs=1e-9 * (high - low))
        row = int(np.unravel_index(np.argmax(contact.pressure), contact.grid.shape)[1 - axis])
        cut = (slice(None), row) if axis == 0 else (row, slice(None))
        np.testing.assert_allclose(lines[1] - lines[0], 1e9 * contact.gap[cut], atol=1e-6)
        place = (contact.grid.y[0, row], contact.grid.x[row, 0])[axis]
        assert labels(axes)[-1] == f"{'yx'[axis]} = {1e6 * place:.3g} µm".replace("-", "−")
        assert labels(axes)[:3] == ["body", "counterbody", "contact"]
        assert (axes.get_xlabel(), axes.get_ylabel()) == (f"{'xy'[axis]}, µm", "height, nm")
        np.testing.assert_array_equal(np.isfinite(axes.lines[2].get_ydata()), contact.contact[cut])

    def test_of_two_maxima_a_profile_goes_through_the_longer_contact(self, axes):
        grid = rc.Grid((12, 10), (12.0, 10.0))
        pressure = np.zeros(grid.shape)
        pressure[2:5, 3] = 1.0
        pressure[2:9, 7] = 1.0
        self.draw(axes, "profile", with_fields(grid, pressure, pressure == 0.0))
        assert labels(axes)[-1] == "y = 2.5 m"

    def test_deformed_bodies_share_the_displacement_by_their_compliances(self):
        soft, hard = rc.Elastic(1e9, 0.3), rc.Elastic(3e9, 0.3)
        grid = rc.Grid((16, 16), 16e-6)
        problem = rc.ContactProblem(
            rc.Body(rc.ParaboloidSurface(1e-4), hard), rc.Body(rc.FlatSurface(), soft), grid=grid
        )
        solution = problem.solve(force=1e-4)
        lower, upper = find_surfaces(solution)
        heights = problem.body.heights(grid)
        np.testing.assert_allclose(heights - lower, 0.25 * solution.displacement, rtol=1e-5)
        np.testing.assert_allclose(upper - lower, np.maximum(solution.gap, 0.0), atol=1e-18)

    def test_the_gap_is_drawn_from_its_small_values_on(self, contact, axes):
        self.draw(axes, "gap", contact)
        opened = 1e9 * contact.gap[~contact.contact]
        norm = axes.images[0].norm
        assert norm.vmax == pytest.approx(np.percentile(opened, 99.9))
        assert norm.vmin == pytest.approx(max(np.percentile(opened, 0.5), 1e-4 * norm.vmax))
        linear = self.draw(pyplot.figure().add_subplot(), "gap", contact, logarithmic=False)
        assert linear.images[0].norm.vmin == 0.0
        full = with_fields(contact.grid, 1.0, 0.0, initial_gap=1e-9)
        assert self.draw(pyplot.figure().add_subplot(), "gap", full).images[0].get_array().mask.all()

    def test_pressures_have_colours_from_zero_to_their_maximum(self, contact, axes):
        self.draw(axes, "pressure", contact)
        assert (axes.images[0].norm.vmin, axes.images[0].norm.vmax) == pytest.approx(
            (0.0, contact.pressure.max() / 1e6)
        )
        assert len(axes.collections) == 1
        assert not self.draw(pyplot.figure().add_subplot(), "pressure", contact, edge=False).collections

    def test_areas_of_patches_have_a_range_of_colours(self, contact, axes):
        self.draw(axes, "patches", contact)
        (area,) = 1e12 * areas_of_patches(contact)
        assert (axes.images[0].norm.vmin, axes.images[0].norm.vmax) == pytest.approx((area / 2.0, 2.0 * area))
        assert axes.get_title(loc="left") == "1 patch"

    def test_the_axes_of_distributions(self, contact, axes):
        self.draw(axes, "pressure-histogram", contact)
        highest = contact.pressure.max() / 1e6
        count = np.count_nonzero(contact.contact)
        bars = axes.containers[0]
        assert len(bars) == round(2.0 * count ** (1.0 / 3.0))
        assert axes.get_xlim() == pytest.approx((0.0, 1.03 * highest))
        assert axes.get_ylim() == pytest.approx((0.0, 1.08 * max(bar.get_height() for bar in bars)))
        (law,) = axes.lines
        assert law.get_xdata()[1] <= 0.7 * highest * (1.0 + 1e-12)
        assert law.get_ydata()[1] <= axes.get_ylim()[1] * (1.0 + 1e-12)
        sizes = self.draw(pyplot.figure().add_subplot(), "patch-sizes", contact)
        cell = 1e12 * contact.grid.cell_area
        (area,) = 1e12 * areas_of_patches(contact)
        assert sizes.get_xlim() == pytest.approx((0.5 * cell, 2.0 * max(area, 10.0 * cell)))
        assert sizes.get_ylim() == pytest.approx((0.7, 10.0))
        shaded = sizes.patches[0].get_extents()
        small = sizes.transData.inverted().transform(shaded.get_points())
        assert small[:, 0] == pytest.approx([0.5 * cell, 4.0 * cell])
        assert sizes.lines[-1].get_xydata().tolist() == [[pytest.approx(area), 1.0]]


class TestPanelsOfSurfaces:
    GRID = rc.Grid((60, 40), (60e-6, 80e-6))

    def sampled(self, heights, periodic=True):
        return rc.plotting.SampledSurface(heights + np.zeros(self.GRID.shape), self.GRID, periodic)

    def test_bands_are_an_eighth_of_a_decade_wide(self):
        q = np.geomspace(1.0, 1e3, 4001)
        centre, mean = average_in_bands(q, q**-2.0)
        assert centre.size == 24
        np.testing.assert_allclose(np.log10(centre[1:] / centre[:-1]), 0.125, rtol=0.01)
        # Over a band of ratio r the mean in log q of q^-2 is (r - 1 / r) / 2 log r times that at its centre.
        ratio = 10.0**0.125
        np.testing.assert_allclose(mean * centre**2, (ratio - 1.0 / ratio) / (2.0 * math.log(ratio)), rtol=0.01)
        assert [one.size for one in average_in_bands(np.array([0.0]), np.array([1.0]))] == [0, 0]
        centre, mean = average_in_bands(np.array([0.0, 2.0]), np.array([9.0, 3.0]))
        assert (centre.tolist(), mean.tolist()) == ([pytest.approx(2.0)], [3.0])
        assert average_in_bands(np.array([1.0, 10.0]), np.array([1.0, 1e-13]))[0].size == 1

    def test_a_spectrum_is_that_along_both_axes(self, axes):
        x, y = self.GRID.x, self.GRID.y
        wave = 1e-6 * np.cos(2 * np.pi * 3 * x / 60e-6) + 2e-6 * np.cos(2 * np.pi * 5 * y / 80e-6)
        qx, qy, density = spectral_density(self.sampled(wave))
        assert (qx.shape, qy.shape) == ((60, 1), (1, 40))
        assert np.argwhere(density > 0.5 * density.max()).tolist() == [[0, 5], [0, 35]]
        assert qy[0, 5] == -qy[0, 35] == pytest.approx(2 * np.pi * 5 / 80e-6)
        assert qx[3, 0] == pytest.approx(2 * np.pi * 3 / 60e-6)
        # A cosine of amplitude a has two coefficients a / 2: C = A a^2 / 4.
        assert density.max() == pytest.approx(self.GRID.area * (2e-6) ** 2 / 4)
        assert density[3, 0] == pytest.approx(self.GRID.area * (1e-6) ** 2 / 4)
        rc.panels.create("spectrum").draw(self.sampled(wave), axes)
        assert labels(axes) == ["along x", "along y", "all directions"]
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("wave number, rad/µm", "power spectral density, m⁴")
        for line, wanted in zip(axes.lines, (3 / 60, 5 / 80, 5 / 80), strict=True):
            highest = line.get_xdata()[np.argmax(line.get_ydata())]
            assert highest == pytest.approx(2 * np.pi * wanted, rel=0.2)
        missing = np.where(np.indices(self.GRID.shape).sum(axis=0) == 40, np.nan, wave)
        rc.panels.create("spectrum").draw(self.sampled(missing, False), pyplot.figure().add_subplot())
        assert labels(pyplot.gca())[-1] == "non-measured points filled"

    def test_means_over_rings(self):
        """Of the distance itself and of its square, over whole rings."""
        for spacing in ((1.0, 1.0), (1.0, 2.0), (3.0, 1.0)):
            r = np.hypot(np.arange(31)[:, np.newaxis] * spacing[0], np.arange(25) * spacing[1])
            radius, mean = average_radially(r, spacing)
            np.testing.assert_allclose(radius, mean)
            step = max(spacing)
            np.testing.assert_allclose(radius, step * np.arange(radius.size), atol=0.4 * step)
            assert radius[-1] == pytest.approx(min(30 * spacing[0], 24 * spacing[1]), abs=step)
            assert radius[0] < 0.5 * step
        # Points on the axes stand for two, others for four: cos^2 has the mean one half in each ring.
        x, y = np.arange(41.0)[:, np.newaxis], np.arange(41.0)
        square = np.divide(x**2, x**2 + y**2, out=np.full((41, 41), 0.5), where=x + y > 0)
        np.testing.assert_allclose(average_radially(square, (1.0, 1.0))[1], 0.5)
        weighed = average_radially(np.where(y == 0, 1.0, 0.0) + 0.0 * x, (1.0, 1.0))[1]
        # The first ring has the four neighbours on the axes and the four on the diagonals.
        assert weighed[1] == pytest.approx(2.0 / 8.0)

    def test_the_length_of_an_autocorrelation(self, axes):
        """That of a rough map falls to 0.2 where the drawn point says; a cosine along x is one along y."""
        rng = np.random.default_rng(2)
        spectrum = np.fft.fft2(rng.normal(size=(60, 40)))
        qx, qy = np.fft.fftfreq(60)[:, np.newaxis], np.fft.fftfreq(40)
        heights = 1e-6 * np.fft.ifft2(spectrum * np.exp(-200.0 * (qx**2 + 0.25 * qy**2))).real
        rc.panels.create("autocorrelation").draw(self.sampled(heights), axes)
        along_x, along_y, mean, point = axes.lines[:4]
        assert along_x.get_xdata()[-1] == pytest.approx(30.0)
        assert along_y.get_xdata()[-1] == pytest.approx(40.0)
        length = float(point.get_xdata()[0])
        assert point.get_ydata()[0] == 0.2
        assert np.interp(length, *mean.get_data()) == pytest.approx(0.2)
        assert f"0.2 at {length:.3g} µm" in labels(axes)
        assert axes.get_xlim() == pytest.approx((0.0, mean.get_xdata()[-1]))
        assert axes.lines[4].get_ydata()[0] == 0.0
        np.testing.assert_allclose(along_x.get_ydata(), correlate(heights, True)[:, 0])

    def test_the_bearing_curve_of_a_ramp_is_straight(self, axes):
        ramp = 1e-6 * (np.arange(2400.0).reshape(60, 40) / 2399.0)
        rc.panels.create("bearing-curve").draw(self.sampled(ramp), axes)
        ratio, level = axes.lines[0].get_data()
        assert level.size == 201
        assert (level[0], level[-1]) == pytest.approx((-500.0, 500.0))
        np.testing.assert_allclose(ratio, 50.0 - 0.1 * level, atol=0.2)
        bars = axes.containers[0]
        assert len(bars) == 40
        assert max(bar.get_width() for bar in bars) == pytest.approx(40.0)
        assert min(bar.get_width() for bar in bars) > 35.0
        assert axes.get_xlim() == (0.0, 100.0)
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("material ratio, %", "height, nm")
        holes = ramp.copy()
        holes[:, 20:] = np.nan
        rc.panels.create("bearing-curve").draw(self.sampled(holes), pyplot.figure().add_subplot())
        ratio, level = pyplot.gca().lines[0].get_data()
        np.testing.assert_allclose(np.interp(0.0, level, ratio), 50.0, atol=1.5)
        assert (ratio[0], ratio[-1]) == (pytest.approx(100.0, abs=0.2), 0.0)

    def test_a_legend_names_points_that_were_not_measured_where_there_are_some(self, axes):
        heights = 1e-6 * np.cos(2 * np.pi * self.GRID.x / 60e-6) + np.zeros(self.GRID.shape)
        rc.panels.create("map").draw(self.sampled(heights), axes)
        assert (labels(axes), len(axes.images)) == ([], 1)
        assert axes.images[0].norm.vmax == pytest.approx(1000.0, rel=0.01)
        heights[3, 5] = np.nan
        rc.panels.create("map").draw(self.sampled(heights), pyplot.figure().add_subplot())
        assert (labels(pyplot.gca()), len(pyplot.gca().images)) == (["non-measured"], 2)

    def test_solids_are_raised_by_a_round_number(self):
        """To an eighth of the longer side at most: 1, 2 or 5 times a power of ten."""
        grid = rc.Grid((4, 4), (1.0, 0.5))
        cases = {0.12: 1.0, 0.061: 1.0, 0.06: 2.0, 0.02: 5.0, 0.0121: 5.0, 1e-6: 1e5, 1.3: 0.05, 0.0: 1.0}
        for tallest, expected in cases.items():
            assert _choose(grid, np.array([0.0, 0.999 * tallest])) == pytest.approx(expected)


def made_up(estimator, cells, error, cpu, **more):
    timing = Timing.of([0.5 * cpu, cpu, 3.0 * cpu])
    parts = {"kernel": "love", "convolver": "dc-fft", "solver": "projected-cg", "tolerance": 1e-8} | more
    return ReportRow(
        shape=(cells, cells), estimator=estimator, area=1.0, area_error=error, p_max_error=2 * error, cpu=timing,
        solve_cpu=timing, **parts
    )  # fmt: skip


def report_of(*rows, error=0.0):
    reference = rc.results.KnownAnswer(area=1.0, area_error=error, p_max=1.0, p_max_error=error)
    return ErrorReport(rows=rows, reference=reference, nominal=2.0, description="made up", repeats=3)


class TestReports:
    ROWS = (
        made_up("blend", 32, -0.02, 0.01),
        made_up("blend", 64, 0.004, 0.1),
        made_up("hertz", 32, 0.05, 0.02, unresolved=frozenset({"area"})),
        made_up("hertz", 64, -0.01, 0.2),
    )

    def test_lines_are_errors_over_times_with_their_ranges(self, axes):
        results.draw_errors(axes, report_of(*self.ROWS, error=0.003), "area")
        assert axes.get_title() == "real contact area"
        (first, second) = (container.lines[0] for container in axes.containers)
        np.testing.assert_allclose(first.get_xydata(), [[0.01, 2.0], [0.1, 0.4]])
        np.testing.assert_allclose(second.get_xydata(), [[0.02, 5.0], [0.2, 1.0]])
        bars = axes.containers[0].lines[2][0].get_segments()
        np.testing.assert_allclose([bar[:, 0] for bar in bars], [[0.005, 0.03], [0.05, 0.3]])
        assert first.get_color() != second.get_color()
        points = [line for line in axes.lines if line.get_marker() == "o" and len(line.get_xdata()) == 1]
        faces = {line.get_ydata()[0]: line.get_markerfacecolor() for line in points}
        assert [error for error, face in faces.items() if face == "white"] == [pytest.approx(5.0)]
        assert labels(axes) == ["blend", "hertz", "Pareto front", "error bound of the reference"]
        front = next(line for line in axes.lines if line.get_label() == "Pareto front")
        np.testing.assert_allclose(front.get_xydata(), [[0.01, 2.0], [0.1, 0.4]])
        bound = next(line for line in axes.lines if line.get_label().startswith("error bound"))
        assert bound.get_ydata()[0] == pytest.approx(0.3)
        assert sorted(text.get_text() for text in axes.texts) == ["32", "32", "64", "64"]
        assert (axes.get_xscale(), axes.get_yscale(), axes.get_ylabel()) == ("log", "log", "error, %")

    def test_numbers_cover_neither_points_nor_each_other(self, axes):
        results.draw_errors(axes, report_of(*self.ROWS, *(made_up("cell-count", 48, 0.0205, 0.0101),) * 9), "area")
        boxes = [text.get_window_extent() for text in axes.texts]
        assert len(boxes) < 13
        for k, box in enumerate(boxes):
            assert sum(box.overlaps(other) for other in boxes[:k]) == 0
        beside = [np.hypot(*text.get_position()) for text in axes.texts]
        assert min(beside) < 7.0
        box = (0.0, 0.0, 2.0, 1.0)
        for other, expected in (
            ((2.0, 0.0, 3.0, 1.0), False),
            ((1.9, 0.0, 3.0, 1.0), True),
            ((0.0, 1.0, 2.0, 2.0), False),
            ((0.0, 0.9, 2.0, 2.0), True),
            ((-1.0, -1.0, 0.1, 0.1), True),
            ((-1.0, -1.0, 0.1, 0.0), False),
            ((-1.0, -1.0, 0.0, 0.1), False),
        ):
            assert results._overlap(box, other) == results._overlap(other, box) == expected

    def test_errors_below_the_bound_of_the_reference_are_drawn_on_it(self, axes):
        results.draw_errors(axes, report_of(*self.ROWS, error=0.015), "area")
        assert axes.containers[0].lines[0].get_ydata().tolist() == pytest.approx([2.0, 1.5])
        exact = report_of(made_up("blend", 32, 0.0, 0.1), made_up("blend", 64, 0.1, 0.2))
        results.draw_errors(pyplot.figure().add_subplot(), exact, "area")
        assert pyplot.gca().containers[0].lines[0].get_ydata().tolist() == pytest.approx([1e-7, 10.0])
        assert "error bound of the reference" not in labels(pyplot.gca())

    def test_pressures_need_no_estimator(self, axes):
        rows = (*self.ROWS, made_up("blend", 32, 0.03, 0.02, solver="polonsky-keer"))
        results.draw_errors(axes, report_of(*rows), "p_max")
        assert axes.get_title() == "maximum pressure"
        assert len(axes.containers) == 2
        assert axes.containers[0].lines[0].get_ydata().tolist() == pytest.approx([4.0, 0.8])
        assert labels(axes)[:2] == ["projected-cg", "polonsky-keer"]
        first, second = (container.lines[0] for container in axes.containers)
        assert first.get_linestyle() != second.get_linestyle()
        assert first.get_color() != second.get_color()

    @pytest.mark.parametrize(("ratio", "kind"), [(3.0, "even"), (30.0, "fine"), (3000.0, "decades")])
    def test_ticks_suit_the_range(self, ratio, kind, axes):
        rows = made_up("blend", 32, 0.1, 1.0), made_up("blend", 64, 0.1 / ratio, 1.2)
        results.draw_errors(axes, report_of(*rows), "area")
        locator = axes.yaxis.get_major_locator()
        assert isinstance(locator, MaxNLocator if kind == "even" else LogLocator)
        low, high = axes.get_ylim()
        shown = [tick for tick in axes.get_yticks() if low <= tick <= high]
        assert 2 <= len(shown) <= 9
        if kind == "fine":
            assert {1.0, 2.0, 5.0} <= {round(tick, 9) for tick in shown}
        if kind == "decades":
            assert {0.01, 0.1, 1.0, 10.0} <= {round(tick, 9) for tick in shown}
            assert 2.0 not in shown
        assert axes.yaxis.get_major_formatter()(0.5, 0) == "0.5"

    def test_a_single_error_has_axes_around_it(self, axes):
        results.draw_errors(axes, report_of(made_up("blend", 32, 0.1, 1.0)), "area")
        assert axes.get_ylim() == pytest.approx((5.0, 20.0))
        own = attrs.evolve(self.ROWS[0], of_reference=frozenset({"area"}))
        results.draw_errors(pyplot.figure().add_subplot(), report_of(own), "area")
        assert [text.get_text() for text in pyplot.gca().texts] == ["nothing to compare"]


class TestColumns:
    @staticmethod
    def draw(values, names, axes, units=None):
        table = SimpleNamespace(columns=values, units=units or {})
        return results.draw_study(table, StudyNames(**{"spread": "", "color": "", "over": ""} | names), axes)

    def test_means_and_scatter_over_another_axis(self, axes):
        columns = {"x": [1.0, 1.0, 1.0, 9.0, 9.0], "y": [1.0, 2.0, 6.0, 4.0, 8.0], "seed": [0, 1, 2, 0, 1]}
        self.draw(columns, {"x": "x", "y": "y", "over": "seed"}, axes)
        np.testing.assert_allclose(axes.lines[0].get_xydata(), [[1.0, 3.0], [9.0, 6.0]])
        vertices = axes.collections[0].get_paths()[0].vertices
        for at, mean, std in ((1.0, 3.0, math.sqrt(7.0)), (9.0, 6.0, math.sqrt(8.0))):
            there = vertices[vertices[:, 0] == at, 1]
            assert there.max() == pytest.approx(mean + 2.0 * std)
        assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "linear")

    def test_axes_of_a_decade_are_logarithmic_and_units_suit_the_values(self, axes):
        columns = {"load_x": [2e-3, 2e-2, 5e-3], "area_y": [1e-12, 9e-12, None], "group": ["a", "b", "a"]}
        units = {"load_x": "N", "area_y": "m2"}
        self.draw(columns, {"x": "load_x", "y": "area_y", "color": "group"}, axes, units)
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("load x, mN", "area y, µm²")
        assert labels(axes) == ["group a", "group b"]
        np.testing.assert_allclose(axes.lines[0].get_xydata(), [[2.0, 1.0]])
        np.testing.assert_allclose(axes.lines[1].get_xydata(), [[20.0, 9.0]])

    def test_curves_are_sorted_and_have_their_bands(self, axes):
        columns = {"x": [3.0, 1.0, 2.0], "y": [30.0, 10.0, 20.0], "std": [3.0, 1.0, 2.0]}
        self.draw(columns, {"x": "x", "y": "y", "spread": "std"}, axes)
        np.testing.assert_allclose(axes.lines[0].get_xydata(), [[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]])
        vertices = axes.collections[0].get_paths()[0].vertices
        assert vertices[vertices[:, 0] == 3.0, 1].max() == pytest.approx(36.0)
        assert vertices[vertices[:, 0] == 1.0, 1].min() == pytest.approx(8.0)

    @pytest.mark.parametrize("name", ["stiffness", "mean_gap", "area"])
    def test_a_law_and_the_power_through_it(self, name, axes):
        pressures = np.array([1e6, 1e7, 1e8])
        values = np.array([2e-6, 2e-5, 2e-4])
        unit = {"stiffness": "Pa/m", "mean_gap": "m", "area": "1"}[name]
        column = LawColumn(name, unit, values, 0.1 * values)
        fit = PowerFit(
            factor=2e-5, exponent=1.0, exponent_std=0.02, pressures=(1e6, 1e8), pivot=1e7, loads=3, misfit=0.0
        ) if name == "stiffness" else None  # fmt: skip
        results.draw_column(pressures, column, fit, axes, False)
        scale = 1e6 if name == "mean_gap" else 1.0
        np.testing.assert_allclose(axes.lines[0].get_xydata(), np.stack((pressures / 1e6, scale * values), axis=1))
        assert axes.get_xlabel() == "nominal mean pressure, MPa"
        known = {"stiffness": "stiffness, Pa/m", "mean_gap": "mean gap, µm", "area": "area, fraction of nominal"}
        assert axes.get_ylabel() == known[name]
        assert axes.get_xscale() == "log"
        assert axes.get_yscale() == ("linear" if name == "mean_gap" else "log")
        if fit is not None:
            np.testing.assert_allclose(axes.lines[1].get_xydata(), [[1.0, 2e-6], [100.0, 2e-4]])
            assert labels(axes) == ["stiffness", "exponent 1.000 ± 0.02"]


class Drawn:
    """What pyvista is given, without it."""

    def __init__(self, window_size):
        self.window_size, self.calls = window_size, {}

    def __getattr__(self, name):
        return lambda *arguments, **options: self.calls.update({name: (arguments, options)})


class TestSolids:
    GRID = rc.Grid((1500, 6), (3e-3, 1e-3))

    @pytest.fixture(autouse=True)
    def pyvista(self, monkeypatch):
        mesh = SimpleNamespace(StructuredGrid=lambda *points: SimpleNamespace(points=points, point_data={}))
        monkeypatch.setitem(sys.modules, "pyvista", SimpleNamespace(**vars(mesh), Plotter=Drawn))

    def test_a_surface_is_drawn_in_longer_sides_with_every_other_point(self):
        x, y = self.GRID.x, self.GRID.y
        heights = 2e-6 * np.cos(2.0 * np.pi * x / 3e-3) + 1e-3 * y
        heights[7, 2] = np.nan
        view = view_surface(rc.plotting.SampledSurface(heights, self.GRID, True), 50.0, True)
        (mesh,), options = view.calls["add_mesh"]
        across, along, raised = mesh.points
        assert across.shape == raised.shape == (750, 6)
        np.testing.assert_allclose(across[:, 0], x[::2, 0] / 3e-3)
        np.testing.assert_allclose(along[0], y[0] / 3e-3)
        known = np.where(np.isnan(heights), np.nanmean(heights), heights)
        np.testing.assert_allclose(raised, 50.0 / 3e-3 * (known - known.mean())[::2], atol=1e-12)
        field = mesh.point_data["height, µm"].reshape(750, 6, order="F")
        np.testing.assert_allclose(field, 1e6 * (heights - np.nanmean(heights))[::2])
        end = 1e6 * np.nanmax(np.abs(heights - np.nanmean(heights)))
        assert options["clim"] == pytest.approx((-end, end))
        assert (options["cmap"], options["nan_color"]) == ("cividis", DARK.unknown)
        assert "above_color" not in options
        bar = options["scalar_bar_args"]
        assert (bar["title"], bar["color"], bar["n_labels"], bar["vertical"]) == ("height, µm", DARK.ink, 3, True)
        assert (bar["title_font_size"], bar["label_font_size"]) == (24, 20)
        assert 0.5 < bar["position_x"] < 1.0
        assert 0.0 < bar["position_y"] < 0.5
        assert options["smooth_shading"] is options["interpolate_before_map"] is True
        assert view.calls["set_background"][0] == (DARK.paper,)
        (said,), _ = view.calls["add_text"]
        assert said.endswith("\n3 mm x 1 mm; heights drawn 50 times as high")
        assert said.startswith("Rms height")
        # Seen from the right, the front and above, at the origin, with z upwards.
        place, focus, up = view.camera_position
        assert (focus, up) == ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        assert place[0] > 0.0 > place[1]
        assert place[2] > 0.0
        assert 1.5 < math.hypot(*place) < 3.0
        assert view.window_size[0] > view.window_size[1] > 500

    def test_a_contact_has_the_colours_of_its_pressure(self):
        grid = rc.Grid((30, 40), (30e-6, 40e-6))
        contact = ball(grid, 9e-6, 1e-3)
        holes = np.zeros(grid.shape, dtype=bool)
        holes[2, 3] = True
        limited = attrs.evolve(contact, pressure_limit=float(contact.pressure.max()), non_measured=holes)
        for solution, saturated in ((contact, False), (limited, True)):
            view = view_solution(solution, None, False)
            (mesh,), options = view.calls["add_mesh"]
            highest = solution.pressure.max() / 1e6
            field = mesh.point_data["pressure, MPa"].reshape(grid.shape, order="F")
            np.testing.assert_array_equal(np.isfinite(field), solution.contact)
            below = solution.contact & ~solution.saturated
            np.testing.assert_allclose(field[below], solution.pressure[below] / 1e6)
            assert options["clim"] == pytest.approx((0.0, highest))
            assert (options["cmap"], options["nan_color"]) == ("viridis", LIGHT.counterbody)
            assert ("above_color" in options) == saturated
            assert (options["scalar_bar_args"].get("above_label") == "saturated") == saturated
            if saturated:
                assert (field[solution.saturated] > highest).all()
            heights = np.where(holes & saturated, np.nan, -solution.initial_gap)
            heights = np.where(np.isnan(heights), np.nanmean(heights), heights)
            raised = mesh.points[2] * 40e-6 / (heights - heights.mean())
            times = _choose(grid, heights)
            np.testing.assert_allclose(raised, times)
            assert 0.04 < np.ptp(mesh.points[2]) <= 0.12
            assert view.calls["add_text"][0][0].endswith(f"heights drawn {times:g} times as high")
            assert view.calls["set_background"][0] == (LIGHT.paper,)
            assert "Contact area" in view.calls["add_text"][0][0]
