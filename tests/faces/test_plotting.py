"""Figures: every panel draws for any contact, and what is drawn is what was solved."""

from __future__ import annotations

import io
import itertools
import re

import attrs
import matplotlib
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from matplotlib import pyplot
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import make_figure
from roughcontact.testing.strategies import height_maps, problems
from scenes import make_problem, make_rough

STEEL = rc.Elastic(210e9, 0.3)
# Of elastic bodies that do not attract each other.
PLAIN = [name for name in rc.panels if rc.panels[name].needs_law is None and not rc.panels[name].needs_adhesion]
BY_SUBJECT = {
    kind: [name for name in PLAIN if rc.panels[name].subject == kind] for kind in ("solution", "surface", "sweep")
}


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    pyplot.close("all")


def draw(kind, subject, name, dark=False):
    """Draw a panel to the end, as saving does."""
    figure = make_figure(kind, subject, name, dark)
    figure.savefig(io.BytesIO(), format="png", dpi=60)
    return figure.axes[0]


@pytest.mark.slow
@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
@given(made=problems(), dark=st.booleans(), data=st.data())
def test_every_panel_of_a_solution_draws(made, dark, data):
    problem, mean = made
    solution = problem.solve(pressure=mean, throw=False)
    draw("solution", solution, data.draw(st.sampled_from([None, *BY_SUBJECT["solution"]])), dark)


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(made=problems(), dark=st.booleans(), data=st.data())
def test_every_panel_of_many_solutions_draws(made, dark, data):
    problem, mean = made
    solution = problem.solve(pressure=mean, throw=False)
    draw("solution", solution, data.draw(st.sampled_from([None, *BY_SUBJECT["solution"]])), dark)


@pytest.mark.slow
@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
@given(surface=height_maps(), dark=st.booleans(), data=st.data())
def test_every_panel_of_a_surface_draws(surface, dark, data):
    values = surface.values.copy()
    if data.draw(st.booleans()):
        values.flat[0] = np.nan
    sampled = rc.plotting.SampledSurface(values, surface.own_grid, data.draw(st.booleans()))
    draw("surface", sampled, data.draw(st.sampled_from([None, *BY_SUBJECT["surface"]])), dark)


def ball(cells=64, hardness=None, force=0.15):
    material = STEEL if hardness is None else rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness)
    grid = rc.Grid((cells, cells), 30e-6)
    return make_problem(rc.SphereSurface(1e-3), material, grid=grid).solve(force=force)


def press_rough(**parts):
    waves = {"rms_slope": 0.05, "shortest": 6e-6, "longest": 30e-6, "seed": 4}
    return make_rough((96, 64), (90e-6, 60e-6), STEEL, **waves, **parts).solve(pressure=300e6)


@pytest.fixture(scope="module")
def hertz():
    return ball()


@pytest.fixture(scope="module")
def plastic():
    return ball(hardness=1e9)


@pytest.fixture(scope="module")
def periodic():
    return press_rough()


@pytest.fixture(scope="module")
def sweep():
    problem = rc.ContactProblem(rc.Body(rc.SphereSurface(1e-3), STEEL), grid=rc.Grid((32, 32), 30e-6))
    return problem.sweep(force=[0.02, 0.05, 0.1])


def enclosed(line):
    x, y = line.T
    return 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


class TestEdges:
    def test_the_line_around_a_ball_encloses_its_area(self, hertz):
        (line,) = rc.LevelSet().contours(hertz)
        np.testing.assert_array_equal(line[0], line[-1])
        assert enclosed(line) == pytest.approx(hertz.area("level-set").value, rel=0.01)

    def test_lines_on_a_periodic_domain_are_closed(self, periodic):
        lines, size = rc.LevelSet().contours(periodic), np.array(periodic.grid.size)
        assert len(lines) > 10
        for line in lines:
            turns = (line[-1] - line[0]) / size
            np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)
        area = sum(enclosed(line) for line in lines)
        assert area == pytest.approx(periodic.area("level-set").value, rel=0.08)

    @settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
    @given(made=problems())
    def test_lines_end_nowhere_but_at_a_free_border(self, made):
        problem, mean = made
        solution = problem.solve(pressure=mean, throw=False)
        size = np.array(solution.grid.size)
        for line in rc.LevelSet().contours(solution):
            turns = (line[-1] - line[0]) / size
            if solution.boundary is not rc.Boundary.FREE:
                np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
            elif np.any(line[0] != line[-1]):
                at_border = np.isclose(np.abs(line[[0, -1]]), 0.5 * size, rtol=1e-9).any(axis=1)
                assert at_border.all()

    def test_pieces_share_their_ends(self, periodic):
        # Along a side both dual cells used to have points of their own, so that lines were torn.
        pieces = rc.LevelSet().outline(periodic)
        size = np.array(periodic.grid.size)
        begins, ends = (np.round((pieces[:, k] / size) % 1.0 * 1e9).astype(int) % 10**9 for k in (0, 1))
        assert sorted(map(tuple, begins)) == sorted(map(tuple, ends))

    def test_a_line_across_the_border_is_drawn_at_both_sides(self, periodic):
        axes = draw("solution", periodic, "pressure")
        (drawn,) = axes.collections
        lines, half = rc.LevelSet().contours(periodic), 0.5 * np.array(periodic.grid.size)
        crossing = sum(bool(np.any(np.abs(line) > half)) for line in lines)
        assert crossing > 0
        assert len(drawn.get_paths()) >= len(lines) + crossing

    def test_lines_do_not_hide_narrow_patches(self, hertz):
        heights = 1e-7 * np.random.default_rng(5).standard_normal((128, 128))
        narrow = rc.ContactProblem(rc.Body(rc.HeightMap(heights, 1e-4), STEEL)).solve(pressure=1e8)
        widths = []
        for solution in (hertz, narrow):
            axes = draw("solution", solution, "pressure")
            cell = 72.0 * axes.get_window_extent().width / axes.figure.dpi / solution.grid.shape[0]
            widths.append(axes.collections[0].get_linewidth()[0] / cell)
        assert widths[0] > 0.2
        assert widths[1] < 0.1


class TestFields:
    def test_the_image_is_the_pressure_in_the_unit_of_its_label(self, hertz):
        axes = draw("solution", hertz, "pressure")
        shown = axes.images[0].get_array()
        assert axes.get_xlabel() == "x, µm"
        assert axes.child_axes[0].get_ylabel() == "pressure, GPa"
        expected = np.where(hertz.contact, hertz.pressure / 1e9, np.nan).T
        np.testing.assert_allclose(shown.filled(np.nan), expected, rtol=1e-6)

    def test_the_origin_is_the_centre_and_proportions_are_true(self, periodic):
        axes = draw("solution", periodic, "heights")
        assert axes.images[0].get_extent() == pytest.approx((-45.0, 45.0, -30.0, 30.0))
        assert axes.get_aspect() == 1.0

    def test_saturated_and_non_measured_cells_are_seen(self, plastic):
        axes = draw("solution", plastic, "pressure")
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["saturated"]
        assert np.count_nonzero(~axes.images[1].get_array().mask) == np.count_nonzero(plastic.saturated)
        values = np.random.default_rng(1).standard_normal((24, 24))
        surface = rc.HeightMap(1e-7 * values, 1e-5, non_measured=values > 1.5)
        solution = rc.ContactProblem(rc.Body(surface, STEEL)).solve(pressure=1e8)
        for name in ("heights", "pressure", "gap", "patches"):
            axes = draw("solution", solution, name)
            assert np.count_nonzero(~axes.images[-1].get_array().mask) == np.count_nonzero(values > 1.5)

    def test_the_contact_is_white_in_the_gap(self, hertz):
        axes = draw("solution", hertz, "gap")
        assert axes.get_facecolor() == (1.0, 1.0, 1.0, 1.0)
        np.testing.assert_array_equal(axes.images[0].get_array().mask.T, hertz.contact)

    def test_patches_have_the_colours_of_their_areas(self, periodic):
        axes = draw("solution", periodic, "patches")
        shown = axes.images[0].get_array().T
        areas = periodic.area().patches
        largest = int(np.argmax(areas))
        np.testing.assert_allclose(shown[periodic.patches.labels == largest + 1], 1e12 * areas[largest], rtol=1e-6)
        assert axes.get_title(loc="left") == f"{periodic.patches.count} patches"

    def test_no_cell_is_lost_in_a_file(self, periodic, tmp_path):
        wave = rc.WavySurface(1e-8, (90e-6, 60e-6))
        problem = rc.ContactProblem(rc.Body(wave, STEEL), grid=rc.Grid((800, 8), (90e-6, 60e-6)), boundary="periodic")
        fine = problem.solve(pressure=1e6)
        figure = make_figure("solution", fine, "pressure")
        figure.savefig(tmp_path / "fine.png")
        width = pyplot.imread(tmp_path / "fine.png").shape[1]
        assert width >= 800

    def test_heights_of_one_body(self, hertz):
        axes = draw("solution", hertz, rc.panels.create("heights", of="body"))
        assert axes.child_axes[0].get_ylabel() == "height, nm"
        with pytest.raises(rc.InputError, match="heights to draw must be one of 'combined', 'body', 'counterbody'"):
            rc.panels.create("heights", of="bodies")


class TestDistributions:
    def test_the_histogram_integrates_to_the_contact(self, plastic):
        axes = draw("solution", plastic, "pressure-histogram")
        (bars,) = axes.containers
        area = sum(bar.get_width() * bar.get_height() for bar in bars)
        below = plastic.contact & ~plastic.saturated
        assert area == pytest.approx(below.mean(), rel=1e-12)
        (label,) = (text.get_text() for text in axes.get_legend().get_texts() if "saturated" in text.get_text())
        # That of the printed solution, not of the cells.
        assert label.split()[1] in str(plastic).partition("saturated")[2].splitlines()[0]
        assert float(label.split()[1]) != pytest.approx(100 * plastic.saturated.mean(), rel=1e-3)

    def test_the_law_of_the_edge_is_all_of_hertz(self, hertz):
        # The distribution of Hertz's pressure is in proportion to p up to its maximum.
        axes = draw("solution", hertz, "pressure-histogram")
        law = next(line for line in axes.lines if line.get_label().startswith("law"))
        slope = law.get_ydata()[1] / law.get_xdata()[1]
        highest = float(hertz.pressure.max()) / 1e9
        assert 0.5 * slope * highest**2 == pytest.approx(hertz.contact.mean(), rel=0.05)

    def test_as_many_patches_as_there_are(self, periodic):
        axes = draw("solution", periodic, "patch-sizes")
        points = axes.lines[-1]
        assert points.get_ydata()[0] == periodic.patches.count
        assert points.get_xdata().sum() == pytest.approx(1e12 * periodic.area().patches.sum(), rel=1e-9)
        assert axes.get_xscale() == axes.get_yscale() == "log"


class TestProfile:
    @pytest.mark.parametrize("axis", [0, 1])
    def test_the_cut_is_that_of_the_fields(self, periodic, axis):
        axes = draw("solution", periodic, rc.panels.create("profile", axis=axis))
        lower, upper = (line.get_ydata() for line in axes.lines[:2])
        place = np.unravel_index(np.argmax(periodic.pressure), periodic.grid.shape)
        cut = (slice(None), place[1]) if axis == 0 else (place[0], slice(None))
        np.testing.assert_allclose(upper - lower, 1e9 * np.maximum(periodic.gap[cut], 0.0), atol=1e-6)
        heights = periodic.origin.problem["body"].heights(periodic.grid)[cut] - periodic.displacement[cut]
        np.testing.assert_allclose(lower - lower.mean(), 1e9 * (heights - heights.mean()), atol=1e-2)
        np.testing.assert_array_equal(np.isfinite(axes.lines[2].get_ydata()), periodic.contact[cut])

    def test_the_position_is_chosen(self, hertz):
        axes = draw("solution", hertz, rc.panels.create("profile", position=5e-6))
        assert axes.get_legend().get_texts()[-1].get_text() == "y = 4.92 µm"
        with pytest.raises(rc.InputError, match="position of a profile must be within 15 µm of the centre, but got"):
            draw("solution", hertz, rc.panels.create("profile", position=1.0))
        with pytest.raises(rc.InputError, match="axis of a profile must be 0 for a cut along x"):
            rc.panels.create("profile", axis=2)


PLANE = rc.Grid((64, 48), (64e-6, 48e-6))


class TestSurfaces:
    def test_a_wave_stands_at_its_wave_number(self):
        surface = rc.WavySurface(amplitude=(1e-6, 0.0), wavelength=8e-6)
        axes = surface.plot(PLANE, "spectrum")
        line = next(line for line in axes.lines if line.get_label() == "along x")
        assert axes.get_xlabel() == "wave number, rad/µm"
        highest = line.get_xdata()[np.argmax(line.get_ydata())]
        assert highest == pytest.approx(2 * np.pi / 8.0, rel=0.2)

    def test_the_bearing_curve_falls_from_all_to_nothing(self):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, shortest=4e-6, longest=48e-6, seed=1)
        axes = surface.plot(PLANE, "bearing-curve")
        height_map = rc.HeightMap(surface.heights(PLANE), PLANE.size)
        # The name of the panel alone, as of a solution and a sweep.
        again = height_map.plot("bearing-curve")
        np.testing.assert_array_equal(again.lines[0].get_data(), axes.lines[0].get_data())
        with pytest.raises(rc.InputError, match="no grid of its own: give one"):
            surface.plot("bearing-curve")
        with pytest.raises(rc.InputError, match=r"There is no panel named 'bearing'. Did you mean 'bearing-curve'\?"):
            height_map.plot("bearing")
        ratio, levels = axes.lines[0].get_data()
        assert ratio[0] == pytest.approx(100.0, abs=0.1)
        assert ratio[-1] == 0.0
        assert np.all(np.diff(ratio) <= 0.0)
        heights = surface.heights(PLANE)
        middle = np.interp(0.0, levels, ratio)
        assert middle == pytest.approx(100 * np.mean(heights > heights.mean()), abs=1.0)

    @pytest.mark.parametrize("name", ["spectrum", "autocorrelation"])
    def test_a_flat_surface_says_that_it_has_no_spectrum(self, name):
        with pytest.raises(rc.InputError, match=f"flat, so that it has no {name}"):
            rc.FlatSurface().plot(PLANE, name)
        figure = rc.FlatSurface().plot(PLANE)
        assert "no spectrum" in " ".join(figure.axes[1].texts[0].get_text().split())


class TestSweeps:
    def test_bands_are_two_standard_deviations(self, sweep):
        axes = draw("sweep", sweep, "area-load")
        found = [solution.area() for solution in sweep.states]
        fractions = np.array([100 * area.fraction for area in found])
        np.testing.assert_allclose(axes.lines[0].get_ydata(), fractions)
        (band,) = axes.collections
        height = band.get_paths()[0].get_extents().ymax
        nominal = sweep.states[0].grid.area
        expected = max(f + 200 * area.uncertainty / nominal for f, area in zip(fractions, found, strict=True))
        assert height == pytest.approx(expected)
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("force, mN", "contact area, % of nominal")

    def test_stiffness_is_that_of_each_solution(self, sweep):
        axes = draw("sweep", sweep, "stiffness-load")
        assert axes.get_ylabel() == "stiffness, MN/m"
        found = [1e-6 * solution.stiffness().value for solution in sweep.states]
        np.testing.assert_allclose(axes.lines[0].get_ydata(), found)

    def test_what_is_refused_stands_in_its_place(self):
        surface = rc.WavySurface(1e-7, 1e-5)
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((16, 16), 1e-5), boundary="wrapped")
        wrapped = problem.sweep(pressure=[1e8, 2e8])
        figure = wrapped.plot()
        assert "wrapped boundary" in " ".join(figure.axes[2].texts[0].get_text().split())
        with pytest.raises(rc.InputError, match="wrapped boundary"):
            wrapped.plot("stiffness-load")


class TestFigures:
    def test_the_title_says_the_answer(self, hertz):
        title = hertz.plot().get_suptitle()
        area = hertz.area()
        assert title.startswith(f"Contact area ({100 * area.fraction:.2f}"[:20])
        assert "±" in title
        assert "at 150 mN, free boundary" in title

    def test_warnings_are_hinted_at(self):
        tilted = rc.HeightMap(np.add.outer(np.arange(16.0), np.cos(np.arange(16.0))) * 1e-8, 1e-5)
        solution = rc.ContactProblem(rc.Body(tilted, STEEL), boundary="periodic").solve(pressure=1e8)
        title = solution.plot().get_suptitle()
        assert solution.warnings
        assert re.search(r"\n[1-9]\d* warnings?$", title)

    def test_one_panel_has_the_title_too_but_axes_of_the_user_have_none(self, hertz, sweep):
        title = hertz.plot("pressure").figure.get_suptitle()
        assert title.replace("\n", " ") == hertz.plot().get_suptitle().replace("\n", " ")
        assert sweep.plot("area-load").figure.get_suptitle() == sweep.plot().get_suptitle()
        axes = pyplot.figure().add_subplot()
        assert hertz.plot("pressure", axes=axes).figure.get_suptitle() == ""

    def test_titles_of_sweeps_state_the_loads_that_are_on_the_axis(self, sweep):
        assert sweep.plot("area-load").get_xlabel() == "force, mN"
        assert sweep.plot().get_suptitle() == "3 loads, force 20 mN to 100 mN"
        wave = rc.ContactProblem(rc.Body(rc.WavySurface(1e-7, 1e-5), STEEL), grid=rc.Grid((16, 16), 1e-5))
        drawn = attrs.evolve(wave, boundary="periodic").sweep(pressure=[1e8, 2e8]).plot()
        assert drawn.get_suptitle() == "2 loads, mean pressure 100 MPa to 200 MPa"
        assert sweep[:1].plot().get_suptitle() == "1 load, force 20 mN"

    @pytest.mark.parametrize("size", [(83e-6, 204e-6), (256e-6, 256e-6), (4e-4, 1e-4)])
    def test_the_legend_of_a_profile_stays_on_the_paper(self, size):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_height=3e-7, shortest=6e-5, longest=1e-4, seed=3)
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((24, 18), size))
        axes = problem.solve(pressure=1e7).plot(rc.panels.create("profile", position=-0.4826 * size[1]))
        axes.figure.draw_without_rendering()
        assert axes.get_legend().get_window_extent().x1 < axes.figure.bbox.x1

    @pytest.mark.slow
    @pytest.mark.parametrize("size", [(256e-6, 256e-6), (3e-4, 1e-4), (1e-4, 5e-4)])
    def test_nothing_is_cut_off_at_the_border(self, size):
        grid = rc.Grid((24, 18), size)
        surface = rc.SelfAffineSurface(hurst=0.8, rms_height=3e-7, shortest=6e-5, longest=1e-4, seed=3)
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary="periodic")
        sweep = problem.sweep(pressure=[1e7, 1.2e8])
        subjects = {"solution": sweep.states[-1], "sweep": sweep}
        for kind, names in BY_SUBJECT.items():
            for name in (None, *names):
                drawn = surface.plot(grid, name) if kind == "surface" else subjects[kind].plot(name)
                content = io.BytesIO()
                drawn.figure.savefig(content, format="png")
                content.seek(0)
                pixels = pyplot.imread(content)
                ring = (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:])
                assert all((side == 1.0).all() for side in ring), f"{kind} {name}"
                pyplot.close("all")

    def test_parameters_of_the_user_stay(self, hertz):
        before = dict(matplotlib.rcParams)
        hertz.plot(dark=True)
        hertz.plot("gap")
        with rc.plotting.style(dark=True):
            assert matplotlib.rcParams["axes.facecolor"] == rc.plotting.DARK.paper
        assert dict(matplotlib.rcParams) == before

    def test_axes_of_the_user_are_filled_alone(self, hertz):
        figure, (left, right) = pyplot.subplots(1, 2)
        right.plot([0, 1], [2, 3])
        before = (right.get_xlim(), right.get_ylim(), right.get_position().bounds, len(right.lines))
        assert hertz.plot("pressure", axes=left) is left
        assert before == (right.get_xlim(), right.get_ylim(), right.get_position().bounds, len(right.lines))
        assert left.images
        assert figure.get_facecolor() == (1.0, 1.0, 1.0, 1.0)

    def test_the_background_of_axes_chooses_the_theme(self, hertz):
        with pyplot.style.context("dark_background"):
            axes = pyplot.figure(layout="constrained").add_subplot()
        hertz.plot("pressure", axes=axes)
        (edge,) = axes.collections
        assert tuple(edge.get_color()[0]) == (1.0, 1.0, 1.0, 1.0)
        assert axes.child_axes[0].yaxis.label.get_color() == rc.plotting.DARK.ink

    def test_ticks_made_at_drawing_are_in_the_colours_of_the_theme(self, hertz):
        figure = hertz.plot(dark=True)
        for axes in figure.axes:
            axes.set_xlim(-2.0, 3.0)
        figure.canvas.draw()
        for axes in figure.axes:
            colors = {tick.label1.get_color() for tick in axes.xaxis.get_major_ticks()}
            assert colors == {rc.plotting.DARK.ink}

    @pytest.mark.slow
    @pytest.mark.parametrize("size", [(1e-5, 1e-5), (4e-5, 1e-5), (1e-5, 4e-5), (1e-4, 1e-6), (1e-6, 1e-4)])
    def test_axes_have_three_ticks(self, size):
        surface = rc.WavySurface(1e-8, (size[0], size[1]))
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((16, 12), size), boundary="periodic")
        figure = problem.solve(pressure=1e7).plot()
        figure.canvas.draw()
        for axes in figure.axes[:4]:
            for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
                shown = [place for place in axis.get_majorticklocs() if low <= place <= high]
                assert len(shown) >= 3

    @pytest.mark.slow
    @pytest.mark.parametrize("ratio", [0.17, 5.9])
    def test_narrow_domains_have_room_for_all_panels(self, ratio):
        values = np.random.default_rng(1).standard_normal((16, 16))
        surface = rc.HeightMap(1e-7 * values, (ratio * 1e-5, 1e-5), non_measured=values > 1.5)
        hard = rc.ElasticPerfectlyPlastic(210e9, 0.3, 2e9)
        solution = rc.ContactProblem(rc.Body(surface, hard)).solve(pressure=3e8)
        for name in (None, *BY_SUBJECT["solution"]):
            draw("solution", solution, name)

    def test_what_cannot_be_drawn_is_said(self, hertz, sweep):
        with pytest.raises(rc.InputError, match="Axes hold one panel: name it"):
            hertz.plot(axes=pyplot.figure().add_subplot())
        for axes in (5, pyplot.figure().add_subplot(projection="polar"), pyplot.figure().add_subplot(projection="3d")):
            with pytest.raises(rc.InputError, match="The axes must be plane, rectangular Axes of matplotlib, or None"):
                hertz.plot("gap", axes=axes)
        with pytest.raises(rc.InputError, match="draws a sweep, not a solution: the panels of a solution are '"):
            hertz.plot("area-load")
        with pytest.raises(rc.InputError, match=r"There is no panel named 'pressur'\. Did you mean 'pressure'"):
            hertz.plot("pressur")
        open_before = pyplot.get_fignums()
        with pytest.raises(rc.InputError):
            hertz.plot(rc.panels.create("profile", position=1.0))
        assert pyplot.get_fignums() == open_before

    def test_pyplot_shows_what_plot_returns_but_not_what_files_get(self, hertz):
        assert hertz.plot("gap").figure.number in pyplot.get_fignums()
        before = pyplot.get_fignums()
        assert isinstance(make_figure("solution", hertz), Figure)
        assert pyplot.get_fignums() == before

    @pytest.mark.parametrize("theme", [rc.plotting.LIGHT, rc.plotting.DARK])
    def test_colours_differ_in_lightness(self, theme):
        def lightness(color):
            linear = [((c + 0.055) / 1.055) ** 2.4 if c > 0.04 else c / 12.92 for c in to_rgb(color)]
            y = np.dot((0.2126, 0.7152, 0.0722), linear)
            return 116.0 * y ** (1.0 / 3.0) - 16.0

        lines = [lightness(color) for color in theme.lines]
        assert all(abs(one - other) > 10.0 for one, other in itertools.pairwise(lines))
        paper = lightness(theme.paper)
        assert all(abs(lightness(color) - paper) > 25.0 for color in (*theme.lines, theme.ink, theme.limit, theme.edge))


def test_a_panel_of_ones_own(hertz):
    class Residual(rc.Panel):
        def draw(self, subject, axes):
            rc.plotting.draw_map(axes, subject.gap, subject.grid, "gap", "m")

    assert hertz.plot(Residual()).images[0].get_array().shape == (64, 64)
