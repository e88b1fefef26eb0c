"""The site builds without a warning, and its links, notebooks and formulas are those of the pages.

It is built once for all tests here: `.ci/run docs` gives them to one process.
"""

from __future__ import annotations

import csv
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if "_build" not in page.parts]
# Built by `.ci/run docs` and `.ci/run site`.
WHEELS = DOCS / "_build" / "wheels"
SITE = (
    "docutils",
    "furo",
    "linkify_it",
    "matplotlib",
    "myst_parser",
    "numpydoc",
    "pandas",
    "sphinx",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery",
)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    for package in SITE:
        if importlib.util.find_spec(package) is None:
            pytest.skip(f"{package} is not installed: pip install --group docs")
    folder = tmp_path_factory.mktemp("site")
    build("html", folder)
    return folder


def build(builder, folder):
    """Build from a copy: the gallery writes its pages beside the others, and tests may run side by side."""
    source = folder / "source" / "docs"
    if not source.exists():
        shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("_build", "__pycache__"))
        for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
            shutil.copy(ROOT / name, source.parent)
        (source.parent / "plugins").symlink_to(ROOT / "plugins")
        if WHEELS.is_dir():
            shutil.copytree(WHEELS, source / "_build" / "wheels")
    command = (sys.executable, "-m", "sphinx", "-n", "-W", "-q", "-b", builder, "-d", folder / "doctrees")
    done = subprocess.run((*command, source, folder / builder), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_site_builds_without_a_warning(site):
    pages = {path.relative_to(site / "html").with_suffix("") for path in (site / "html").rglob("*.html")}
    assert {path.relative_to(DOCS).with_suffix("") for path in PAGES} <= pages


def test_gallery_has_a_picture_of_each_script(site):
    index = (site / "html" / "auto_gallery" / "index.html").read_text(encoding="utf-8")
    of_plugins = {"layered": ("15_layered", "18_crystals"), "volume": ("20_dented_raceway",)}
    missing = [name for name in of_plugins if importlib.util.find_spec(f"roughcontact_{name}") is None]
    left_to_others = [script for name in missing for script in of_plugins[name]]
    scripts = [path.stem for path in (DOCS / "gallery").glob("*.py") if path.stem not in left_to_others]
    assert len(scripts) >= 14
    for name in scripts:
        assert f"sphx_glr_{name}_thumb.png" in index
        page = (site / "html" / "auto_gallery" / f"{name}.html").read_text(encoding="utf-8")
        assert f"sphx_glr_{name}_001" in page


def own_pages(html):
    """All but the notebooks' application, which is others' and fetches Pyodide when it is opened."""
    return {page for page in html.rglob("*.html") if page.relative_to(html).parts[0] != "lite"}


def test_each_script_of_the_gallery_is_a_notebook_in_the_browser(site):
    if not WHEELS.is_dir():
        pytest.skip("no wheels in docs/_build/wheels: .ci/run docs builds them")
    lite = site / "html" / "lite"
    index = json.loads((lite / "pypi" / "all.json").read_text(encoding="utf-8"))
    for wheels in index.values():
        for files in wheels["releases"].values():
            assert all((lite / "pypi" / one["url"]).is_file() for one in files)
    pages = set((site / "html" / "auto_gallery").glob("[0-9]*.html"))
    assert len(pages) >= 14
    for page in pages:
        name = f"auto_gallery/{page.stem}.ipynb"
        assert f'href="../lite/notebooks/index.html?path={name}"' in page.read_text(encoding="utf-8")
        first, *others = json.loads((lite / "files" / name).read_text(encoding="utf-8"))["cells"]
        command = first["source"][-1].split()
        assert command[:3] == ["%pip", "install", "-q"]
        assert set(command[3:]) <= {*index, "matplotlib", "pandas"}
        text = "".join("".join(cell["source"]) for cell in others)
        plugins = {f"roughcontact_{one}": f"roughcontact-{one}" for one in ("layered", "volume")}
        needed = {"rc.": "roughcontact", **plugins, "to_pandas": "pandas"}
        assert {package for word, package in needed.items() if word in text} <= set(command), page.stem


def test_links_and_images_of_the_site_exist(site):
    html = site / "html"
    ids = {}
    for page in own_pages(html):
        ids[page.resolve()] = set(re.findall(r'\sid="([^"]+)"', page.read_text(encoding="utf-8")))
    # A page of source links back to where a name is documented, by the module that it was taken from.
    for page in own_pages(html) - set((html / "_modules").rglob("*.html")):
        for target in re.findall(r'(?:href|src)="([^"]*)"', page.read_text(encoding="utf-8")):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = (page.parent / path.partition("?")[0]).resolve() if path else page.resolve()
            assert file.exists(), f"{page.name}: {target}"
            if anchor and file in ids and file.stem not in ("genindex", "search"):
                assert anchor in ids[file], f"{page.name}: {target}"


def test_site_needs_no_network(site):
    for page in own_pages(site / "html"):
        text = page.read_text(encoding="utf-8")
        assert not re.findall(r'<(?:script|img)[^>]*\ssrc="(?:https?:)?//', text), page.name
        assert not re.findall(r'<link[^>]*rel="(?:stylesheet|preload)"[^>]*href="(?:https?:)?//', text), page.name


def test_site_shows_what_slots_hide(site):
    page = (site / "html" / "api" / "problem.html").read_text(encoding="utf-8")
    for name in (
        "results.ContactFields.gap",
        "results.ContactFields.contact",
        "results.ContactFields.patches",
        "ContactProblem.plan",
    ):
        assert f'id="roughcontact.{name}"' in page


def test_formulas_are_written_out(site):
    page = (site / "html" / "understand" / "theory.html").read_text(encoding="utf-8")
    sources = (DOCS / "understand" / "theory.md").read_text(encoding="utf-8").count("$$") // 2
    assert page.count('<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">') == sources
    estimator = (site / "html" / "api" / "areas.html").read_text(encoding="utf-8")
    assert "<mn>12</mn>" not in estimator  # \frac12 is a half


def test_examples_of_the_site_run(site):
    build("doctest", site)
    summary = (site / "doctest" / "output.txt").read_text(encoding="utf-8")
    assert int(re.search(r"(\d+) tests?\b", summary[summary.index("Doctest summary") :])[1]) >= 15


def find_pages(index, query):
    """The pages that the search lists, the best first, by the weights of Sphinx's searchtools.js and docs/scorer.js."""
    query, names, titles = query.lower(), index["docnames"], index["titles"]
    english = pytest.importorskip("sphinx.search.en").SearchEnglish({})
    terms = {english.stem(word) for word in re.findall(r"\w+", query) if word not in english.stopwords}
    found = []
    for title, places in index["alltitles"].items():
        if query in title.lower() and 2 * len(query) >= len(title):
            found += [(round(15 * len(query) / len(title)) + (titles[file] == title), file) for file, _ in places]
    for entry, places in index["indexentries"].items():
        if query in entry and 2 * len(query) >= len(entry):
            found += [(round(100 * len(query) / len(entry)), file) for file, _, main in places if main]
    files = []
    for term in terms:
        scores = {}
        for table, whole, part in (("terms", 5, 2), ("titleterms", 15, 7)):
            others = [] if term in index[table] or len(term) < 3 else [one for one in index[table] if term in one]
            for score, one in [(whole, term), *((part, other) for other in others)]:
                listed = index[table].get(one, [])
                scores |= dict.fromkeys([listed] if isinstance(listed, int) else listed, score)
        files.append(scores)
    found += [(max(scores[file] for scores in files), file) for file in set.intersection(*map(set, files))]
    less = {"api": 7, "changes": 8, "auto_gallery": 3}
    ordered = sorted(
        (less.get(names[file].split("/")[0], 0) - score, titles[file].lower(), file) for score, file in found
    )
    return list(dict.fromkeys(names[file] for *_, file in ordered))


def test_the_search_finds_the_page_of_each_question(site):
    text = (site / "html" / "searchindex.js").read_text(encoding="utf-8")
    index = json.loads(text.removeprefix("Search.setIndex(").removesuffix(")"))
    with (Path(__file__).parent / "questions.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 30
    for column in ("words", "other words"):
        ranks = {row[column]: find_pages(index, row[column]).index(row["page"]) for row in rows}
        assert sum(rank < 4 for rank in ranks.values()) >= 28, ranks
