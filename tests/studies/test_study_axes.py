"""Studies whose problems are made by a function: its parameters are axes."""

from __future__ import annotations

import contextlib
import csv
import itertools
import multiprocessing
import re
import weakref
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import attrs
import numpy as np
import pytest

import roughcontact as rc
from scenes import ROUGH, STEEL, make_problem, make_study
from unit_files import read_index


def build(hurst, seed, boundary="periodic"):
    if hurst == 0.9 and seed == 1:
        raise KeyError("no such wave")
    return make_problem(attrs.evolve(ROUGH, hurst=hurst, seed=seed), boundary=boundary)


def over(**changes):
    return rc.Study(build, **{"hurst": [0.3, 0.8], "force": [0.1, 0.5], "seed": range(2), "fields": True, **changes})


class TestAxes:
    """The parameters of a function as axes."""

    def test_every_combination_is_a_problem_of_its_own(self, tmp_path):
        result = over().run(tmp_path)
        assert [(*record.parameters.values(), record.load) for record in result] == [
            (hurst, seed, load) for hurst in (0.3, 0.8) for seed in (0, 1) for load in (0.1, 0.5)
        ]
        assert result.computed == len({record.key for record in result}) == 8
        # Each is the solution of the problem that the function builds, under the key that it has in any study.
        record = result[-1]
        again = build(**record.parameters).solve(force=record.load)
        assert record.areas["blend"][0] == pytest.approx(again.area().value, rel=1e-3)
        named = rc.Study(problems=build(0.8, 1), force=[0.1, 0.5], fields=True).run(tmp_path)
        assert named.computed == 0
        assert [one.key for one in named] == [one.key for one in result[-2:]]

    def test_it_goes_on_where_it_was_and_solves_what_was_changed(self, tmp_path):
        first = over().run(tmp_path)
        assert over().run(tmp_path).computed == 0
        assert over().run(tmp_path).records == first.records
        assert over(hurst=[0.3, 0.8, 0.5]).run(tmp_path).computed == 4
        # A changed function builds other problems: they have other keys.
        changed = rc.Study(
            lambda hurst, seed: build(hurst, seed, boundary="free"), hurst=[0.3], seed=[0], force=[0.1, 0.5]
        )
        assert changed.run(tmp_path).computed == 2

    def test_problems_are_built_when_they_are_solved_and_not_kept(self, tmp_path):
        alive, most = weakref.WeakSet(), []

        def counted(seed):
            made = build(0.8, seed)
            alive.add(made.body)
            most.append(len(alive))
            return made

        study = rc.Study(counted, seed=range(12), force=[0.5])
        assert len(most) == 1
        study.run(tmp_path)
        assert max(most) <= 3

    @pytest.mark.slow
    @pytest.mark.parametrize("pool", ["threads", "processes"])
    def test_any_executor_gives_the_same_though_the_function_is_not_sent(self, tmp_path, pool):
        alone = over().run(tmp_path / "alone")
        study = rc.Study(lambda hurst, seed: build(hurst, seed), hurst=[0.3, 0.8], seed=range(2), force=[0.1, 0.5])
        spawn = multiprocessing.get_context("spawn")
        with ThreadPoolExecutor(2) if pool == "threads" else ProcessPoolExecutor(2, mp_context=spawn) as executor:
            pooled = study.run(tmp_path / "pooled", executor=executor)
        assert [attrs.evolve(one, seconds=0.0) for one in pooled] == [attrs.evolve(one, seconds=0.0) for one in alone]

    @pytest.mark.parametrize("threads", [0, 2])
    def test_what_cannot_be_built_is_in_the_records_with_its_place(self, tmp_path, threads):
        study = over(hurst=[0.8, 0.9])
        with ThreadPoolExecutor(threads) if threads else contextlib.nullcontext() as executor:
            result = study.run(tmp_path, executor=executor)
        assert result.computed == 6
        assert [(one.status, one.parameters) for one in result.failed] == [("REFUSED", {"hurst": 0.9, "seed": 1})] * 2
        assert result.failed[0].message == (
            "The problem with hurst=0.9, seed=1 cannot be built: KeyError: 'no such wave'."
        )
        assert np.isnan(result.failed[0].force)

    def test_a_data_frame_has_a_row_for_each_solve_and_a_column_for_each_axis(self, tmp_path):
        pytest.importorskip("pandas")
        result = over(areas=["blend", "cell-count"], hurst=[0.3, 0.9]).run(tmp_path)
        frame = result.to_pandas()
        assert list(frame.columns[:2]) == ["hurst", "seed"]
        assert len(frame) == len(result) == 8
        assert frame.attrs["units"]["load"] == "N"
        assert frame.attrs["units"]["area cell-count"] == "m2"
        mean = frame.groupby(["hurst", "load"])["area blend"].mean()
        expected = [record.areas["blend"][0] for record in result if record.parameters == {"hurst": 0.9, "seed": 0}]
        np.testing.assert_allclose(mean[0.9], expected)
        assert frame.query("status == 'REFUSED'")["area blend"].isna().all()
        result.to_csv(tmp_path / "records.csv")
        with (tmp_path / "records.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert [(float(row["hurst"]), int(row["seed"])) for row in rows] == list(
            zip(frame.hurst, frame.seed, strict=True)
        )

    def test_a_dataset_has_a_dimension_for_each_axis(self, tmp_path):
        pytest.importorskip("xarray")
        result = over(hurst=[0.9, 0.3]).run(tmp_path)
        dataset = result.to_xarray()
        assert dict(dataset.sizes) == {"hurst": 2, "seed": 2, "load": 2}
        for record in result:
            place = dataset.sel(**record.parameters, load=record.load)
            assert str(place.status.item()) == record.status
            area, uncertainty = record.areas.get("blend", (np.nan, np.nan))
            np.testing.assert_array_equal([place.area, place.area_uncertainty], [area, uncertainty])
            np.testing.assert_array_equal(place.p_max, record.p_max)
        assert dataset.area.units == "m2"
        assert int(dataset.area.isnull().sum()) == 2

    def test_named_problems_and_seeds_are_dimensions_too(self, tmp_path):
        pytest.importorskip("xarray")
        result = make_study().run(tmp_path)
        dataset = result.to_xarray()
        assert dataset.area.dims == ("estimator", "problem", "seed", "load")
        found = dataset.area.sel(estimator="cell-count", problem="free", seed=1, load=0.5)
        (record,) = [one for one in result if (one.problem, one.seed, one.load) == ("free", 1, 0.5)]
        assert float(found) == record.areas["cell-count"][0]
        assert list(result.to_pandas().columns[:2]) == ["problem", "seed"]

    def test_results_are_short_and_indexed(self, tmp_path):
        result = over(seed=[0]).run(tmp_path)
        assert repr(over(seed=[0])) == "<Study 2 values of hurst, 1 value of seed, 2 loads of force>"
        assert repr(make_study()) == "<Study 2 problems, 3 loads of force>"
        assert repr(result) == f"<StudyResult 4 solves, 4 of them now, in {tmp_path}>"
        assert result[0] is result.records[0]
        assert result[1:3] == result.records[1:3]
        with pytest.raises(rc.InputError, match="whole number from 0 to 3"):
            result[4]
        assert "<th>hurst</th>" in result._repr_html_()

    def test_the_plan_has_every_axis_and_the_time(self):
        """The rows behind the plans of the problems, before anything is solved."""

        def rows_of(study):
            rows = str(study.explain()).split("\n\n")[-1].splitlines()
            return {row[:10].strip(): row[11:] for row in rows}

        built = rows_of(over(seed=range(9)))
        assert built["hurst"] == "0.3, 0.8"
        assert built["seed"] == "0, 1, 2, 3, 4, 5, 6, ..., 8"
        assert built["force"] == "100 mN, 500 mN"
        assert built["solves"] == "36: 2 of hurst x 9 of seed x 2 of force"
        assert built[""] == "if all problems are like the first"
        named = rows_of(make_study())
        assert named["problem"] == "periodic, free"
        assert named["solves"] == "12: 2 of problem x 2 of seed x 3 of force"
        assert "" not in named
        assert re.fullmatch(r"about [\d.e+]+ (s|minutes|hours) in one process on this machine, .*", named["time"])

    def test_the_list_of_records_keeps_the_parameters_and_reads_older_ones(self, tmp_path):
        result = over(seed=[0]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        assert [one.parameters for one in read_index(index).values()] == [{"hurst": 0.3, "seed": 0}] * 2 + [
            {"hurst": 0.8, "seed": 0}
        ] * 2
        assert list(read_index(index).values()) == list(result)
        # One without axes is, byte for byte, what it was before there were any.
        plain = rc.Study(problems=make_problem(), force=[0.1]).run(tmp_path / "plain")
        (index,) = (tmp_path / "plain").glob("study-*.json")
        assert "parameters" not in index.read_text(encoding="utf-8")
        assert list(read_index(index).values()) == list(plain)

    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"hurts": [0.3]}, "Did you mean 'hurst'"),
            ({"hurst": 0.3}, r"must be a list .* One value is hurst=\[value\]"),
            ({"hurst": "rough"}, "must be a list"),
            ({"hurst": []}, "from 1 to 100000 values"),
            ({"hurst": itertools.count()}, "from 1 to 100000 values"),
            ({"hurst": [0.3, 0.3]}, "given twice"),
            ({"hurst": [np.nan]}, "finite number"),
            ({"hurst": [STEEL]}, "a number, a text, True or False"),
            ({"seed": range(10**5)}, "at most 100000"),
            ({"seeds": [0]}, r"seed=\[\.\.\.\] instead of seeds="),
            ({"hurst": [3.0]}, "hurst=3.0, seed=0 cannot be built: The Hurst exponent"),
            ({"hurst": [0.9], "seed": [1]}, "cannot be built: KeyError"),
            ({"force": None}, "exactly one list of loads"),
            ({"force": [1e30]}, "hurst=0.3, seed=0"),
        ],
    )
    def test_bad_axes_get_a_sentence(self, changes, words):
        with pytest.raises(rc.InputError, match=words):
            over(**changes)

    @pytest.mark.parametrize(
        ("function", "words"),
        [
            (lambda pressure: None, "uses the name 'pressure' itself"),
            (lambda status="x": None, "uses the name 'status' itself"),
            (lambda hurst: None, r"needs a value of 'hurst'"),
            (lambda: "problem", "must be a ContactProblem"),
        ],
    )
    def test_a_function_that_builds_no_problem_gets_a_sentence(self, function, words):
        with pytest.raises(rc.InputError, match=words):
            rc.Study(function, force=[1.0])

    def test_axes_need_a_function(self):
        with pytest.raises(rc.InputError, match="no argument of Study named 'hurst'"):
            rc.Study(make_problem(), hurst=[0.3], force=[1.0])


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return over().run(tmp_path_factory.mktemp("results"))


class TestPlot:
    """Columns over each other."""

    def test_each_value_has_a_curve_of_means(self, result):
        axes = result.plot(color="hurst", over="seed")
        assert [line.get_label() for line in axes.lines] == ["hurst 0.3", "hurst 0.8"]
        assert axes.get_xlabel() == "load, mN"
        areas = [record.areas["blend"][0] for record in result if record.parameters["hurst"] == 0.8]
        means = np.array([np.mean(areas[place::2]) for place in range(2)])
        drawn = axes.lines[1].get_ydata()
        np.testing.assert_allclose(drawn / drawn[0], means / means[0])

    def test_without_a_mean_the_band_is_the_uncertainty(self, result):
        axes = result.plot("load", "peak_pressure", color="key")
        assert len(axes.lines) == len(result)
        (lower, upper) = np.sort(axes.collections[0].get_paths()[0].vertices[:, 1])[[0, -1]]
        record = result[0]
        ratio = (upper - lower) / (upper + lower)
        assert ratio == pytest.approx(2.0 * record.peak_pressure_uncertainty / record.peak_pressure, rel=1e-6)

    @pytest.mark.parametrize(
        ("names", "sentence"),
        [
            ({"y": "aera"}, "There is no column named 'aera'"),
            ({"y": "status"}, "has no numbers"),
            ({}, "Several solves have the same load"),
            ({"colour": "seed"}, "Did you mean color"),
        ],
    )
    def test_a_wrong_column_gets_a_sentence(self, result, names, sentence):
        with pytest.raises(rc.InputError, match=sentence):
            result.plot(**names)
