"""What the repository needs to be public: workflows, metadata for citation and packages, and the paper."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest

import roughcontact as rc

ROOT = Path(__file__).parents[2]
if not (ROOT / ".github").exists():
    pytest.skip("needs the repository", allow_module_level=True)
yaml = pytest.importorskip("yaml")

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CI = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
HELPERS = {"bounded", "environment", "newest_python", "page", "python_in", "wheels_of_the_site"}
STAGES = set(re.findall(r"^(\w+)\(\) \{", CI, re.M)) - HELPERS
DEFAULT = set(re.search(r"set -- ([\w ]+)", CI)[1].split())
WORKFLOWS = {path.stem: path for path in (ROOT / ".github" / "workflows").glob("*.yml")}
# The sections that the Journal of Open Source Software requires, and its bounds for words.
SECTIONS = [
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
    "AI usage disclosure",
]
WORDS = (750, 1750)


def load(path):
    return yaml.safe_load((ROOT / path).read_text(encoding="utf-8"))


def steps_of(name):
    return [step for job in load(WORKFLOWS[name])["jobs"].values() for step in job["steps"]]


def commands_of(name):
    return "\n".join(step.get("run", "") for step in steps_of(name))


def stages_of(name):
    """The stages that a workflow runs, by name or by its matrix."""
    found = set()
    for words in re.findall(r"\.ci/run ([^\n;&|]+)", commands_of(name)):
        found |= set(words.split()) - {"$STAGES"}
    for job in load(WORKFLOWS[name])["jobs"].values():
        for one in job.get("strategy", {}).get("matrix", {}).get("include", []):
            found |= set(one["stages"].split())
    return found


def jobs_on_linux():
    return load(WORKFLOWS["ci"])["jobs"]["linux"]["strategy"]["matrix"]["include"]


@pytest.mark.parametrize("name", sorted(WORKFLOWS))
class TestWorkflows:
    def test_call_stages_that_there_are(self, name):
        assert stages_of(name)
        assert stages_of(name) <= STAGES

    def test_call_scripts_that_there_are(self, name):
        for script in re.findall(r"bash (\S+)", commands_of(name)):
            assert (ROOT / script).is_file()

    def test_may_only_read_where_nothing_else_is_said(self, name):
        workflow = load(WORKFLOWS[name])
        assert workflow["permissions"] == {"contents": "read"}
        assert workflow["concurrency"]
        for job in workflow["jobs"].values():
            assert job["timeout-minutes"] <= 120

    def test_name_actions_by_their_versions(self, name):
        actions = [step["uses"] for step in steps_of(name) if "uses" in step]
        assert all(re.fullmatch(r"(actions|pypa)/[\w-]+@(release/)?v\d+", action) for action in actions)


def test_ci_runs_every_stage():
    assert DEFAULT < STAGES
    assert stages_of("ci") == DEFAULT | {"portable", "build"}
    # Stages that use the environment of `tests` run after it.
    for one in jobs_on_linux():
        stages = one["stages"].split()
        assert stages[0] == "tests" or not {"browser", "random", "slow", "docs", "plugins"} & set(stages)


def test_ci_runs_the_oldest_and_a_newer_python():
    pythons = {one["stages"]: one["python"] for one in jobs_on_linux()}
    assert PROJECT["requires-python"] == f">={pythons['oldest']}"
    assert int(pythons["newest"].split(".")[1]) > int(pythons["oldest"].split(".")[1])


class TestPublishing:
    def test_builds_every_project_that_an_extra_needs(self):
        (places,) = re.findall(r"for project in (.*); do", CI)
        built = {
            tomllib.loads((ROOT / place / "pyproject.toml").read_text(encoding="utf-8"))["project"]["name"]
            for place in places.split()
        }
        extras = {re.match(r"[\w-]+", one)[0] for extra in PROJECT["optional-dependencies"].values() for one in extra}
        assert built == {name for name in extras | {PROJECT["name"]} if name.startswith("roughcontact")}

    def test_keeps_no_password_and_only_follows_a_release(self):
        job = load(WORKFLOWS["publish"])["jobs"]["publish"]
        assert job["permissions"] == {"id-token": "write"}
        assert job["environment"] == "release"
        assert job["if"] == "github.event_name == 'release'"
        assert job["needs"] == "build"
        assert "secrets." not in WORKFLOWS["publish"].read_text(encoding="utf-8")
        assert "run" not in {key for step in job["steps"] for key in step}

    def test_uploads_what_was_built(self):
        made, taken, last = [one for one in steps_of("publish") if re.search("artifact|pypa/", one.get("uses", ""))]
        assert made["with"]["name"] == taken["with"]["name"]
        assert made["with"]["path"] == taken["with"]["path"] == "dist/"
        assert last["uses"].startswith("pypa/gh-action-pypi-publish@")

    def test_compares_the_tag_with_the_name_of_the_sdist(self):
        assert f"dist/{PROJECT['name']}-${{TAG#v}}.tar.gz" in commands_of("publish")


def test_versions_agree():
    assert load("CITATION.cff")["version"] == rc.__version__
    assert load("recipe/recipe.yaml")["context"]["version"] == rc.__version__


def test_the_conda_recipe_is_that_of_the_project():
    recipe = load("recipe/recipe.yaml")
    needed = [line.split() for line in recipe["requirements"]["run"] if not line.startswith("python ")]
    wanted = dict(re.fullmatch(r"([\w-]+)(>=[\d.]+)", one).groups() for one in PROJECT["dependencies"])
    assert dict(needed) == wanted
    assert f">={recipe['context']['python_min']}" == PROJECT["requires-python"]
    system = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]
    assert {one.replace(">=", " >=") for one in system["requires"]} <= set(recipe["requirements"]["host"])
    assert recipe["about"]["summary"] == PROJECT["description"]
    assert recipe["about"]["license"] == PROJECT["license"]
    (script,) = recipe["build"]["python"]["entry_points"]
    assert script == f"roughcontact = {PROJECT['scripts']['roughcontact']}"


def test_citations_agree():
    citation, zenodo = load("CITATION.cff"), json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    assert zenodo["title"] == citation["title"] == PROJECT["name"]
    assert zenodo["description"] == citation["abstract"]
    assert zenodo["license"] == citation["license"] == PROJECT["license"]
    assert zenodo["keywords"] == citation["keywords"] == PROJECT["keywords"]
    assert [one["name"] for one in zenodo["creators"]] == [one["name"] for one in citation["authors"]]
    related = [one["identifier"] for one in zenodo["related_identifiers"]]
    assert related == [one["doi"] for one in citation["references"]]


class TestPaper:
    TEXT = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")

    def test_has_the_sections_of_the_journal(self):
        assert re.findall(r"^# (.*)$", self.TEXT, re.M)[:6] == SECTIONS

    def test_has_the_length_of_the_journal(self):
        body = self.TEXT.split("---", 2)[2]
        assert WORDS[0] <= len(body.split()) <= WORDS[1]

    def test_cites_what_it_lists(self):
        keys = set(re.findall(r"^@\w+\{(\w+),", (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8"), re.M))
        assert set(re.findall(r"@(\w+)", self.TEXT.split("---", 2)[2])) == keys

    def test_names_the_script_of_each_figure(self):
        figures = re.findall(r"!\[(.*?)\]\(\.\./(docs/figures/\w+\.png)\)", self.TEXT, re.S)
        assert len(figures) == self.TEXT.count("![")
        page = (ROOT / "docs" / "figures.md").read_text(encoding="utf-8")
        for caption, figure in figures:
            assert (ROOT / figure).is_file()
            (script,) = re.findall(r"Made by\s+`(docs/studies/\w+\.py)`", caption)
            name = Path(figure).stem
            assert Path(script).stem == name or re.search(rf"^\| .*`{name}`.* \| `{script}", page, re.M)
