"""The pages: the site builds without a warning, the examples in docstrings run, and nothing public is missing."""

from __future__ import annotations

import doctest
import importlib
import importlib.util
import inspect
import json
import pkgutil
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import roughcontact
import roughcontact.testing
import roughcontact.typing

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if "_build" not in page.parts]
MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(roughcontact.__path__, "roughcontact.")
    if not module.name.endswith("__main__")
)
CLASSES = [name for name in roughcontact.__all__ if inspect.isclass(getattr(roughcontact, name))]
WITH_EXAMPLES = {
    "roughcontact.extrapolation",
    "roughcontact.kernels.love",
    "roughcontact.reference.closed_forms",
    "roughcontact.reference.persson",
    "roughcontact._base.registry",
    "roughcontact.testing.claim",
}
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


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings(name):
    result = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert result.failed == 0
    assert result.attempted > 0 or name not in WITH_EXAMPLES


@pytest.mark.parametrize("name", CLASSES)
def test_examples_of_a_public_class(name):
    """They belong to no private module, and their methods to no public one."""
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for example in doctest.DocTestFinder().find(getattr(roughcontact, name), name, module=False, globs={}):
        runner.run(example)
    assert runner.tries > runner.failures == 0


@pytest.mark.parametrize("name", sorted(roughcontact.__all__))
def test_each_public_class_and_function_shows_an_example(name):
    public = getattr(roughcontact, name)
    if inspect.isclass(public) or inspect.isfunction(public):
        assert re.search(r"^Examples\n-{8}\n[^>]*>>> ", inspect.getdoc(public), flags=re.MULTILINE)


def test_examples_in_the_reference():
    results = [
        doctest.testfile(str(page), module_relative=False, encoding="utf-8") for page in (DOCS / "api").glob("*.rst")
    ]
    assert sum(result.failed for result in results) == 0
    assert sum(result.attempted for result in results) > 5


def test_every_public_name_has_its_entry():
    pages = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "api").glob("*.rst"))
    entered = re.findall(
        r"^\.\. (?:auto\w+|data):: (?:roughcontact\.(?:faces|responses|results|solving|testing|typing)\.)?(\w+)$",
        pages,
        re.M,
    )
    arrays = {"Array", "IntArray", "Mask", "Pair", "RealArray"}
    modules = (getattr(roughcontact, name) for name in ("faces", "results", "solving", "testing", "typing"))
    public = {*roughcontact.__all__}.union(*(module.__all__ for module in modules))
    assert public - arrays <= set(entered)


def shown_on(page):
    """The figures of a page."""
    return set(re.findall(r"\]\((?:docs/|\.\./)?figures/([\w-]+)\.png\)", page.read_text(encoding="utf-8")))


def test_every_figure_has_its_script():
    """One of its name, or one that the page of figures gives; the tutorials draw theirs in their own blocks."""
    shown = set().union(*map(shown_on, (ROOT / "README.md", *PAGES)))
    assert shown == {path.stem for path in (DOCS / "figures").glob("*.png")}
    text = (DOCS / "figures.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*`) \| `(.*)` \|$", text, re.M)
    given = {name: script for names, script in rows for name in re.findall(r"`(\w+)`", names)}
    tutorials = {name for name in shown if name.startswith("tutorial_")}
    assert set(given) <= shown - tutorials
    for name in shown - tutorials:
        script = given.get(name, f"docs/studies/{name}.py")
        assert script == "roughcontact paper --pairs" or (ROOT / script.split()[0]).exists(), name
    for name in tutorials:
        assert any(f'savefig("{name}.png")' in page.read_text(encoding="utf-8") for page in DOCS.rglob("tutorial_*.md"))


@pytest.mark.parametrize("page", [pytest.param(page, id=page.stem) for page in PAGES])
def test_no_page_is_longer_than_a_reader_stays(page):
    """Words outside code and tables; references are looked up, not read."""
    text = re.sub(r"^(`{3,})\w*.*?^\1$|^\$\$.*?^\$\$$", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    lines = [line for line in text.splitlines() if not line.startswith(("|", "<!--"))]
    assert len(" ".join(lines).split()) <= 1200


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


def test_the_pages_are_in_five_parts():
    parts = ("start", "use", "understand", "trust", "extend")
    assert {path.relative_to(DOCS).parts[0] for path in PAGES} == {
        *parts,
        "index.md",
        "figures.md",
        "references.md",
        "changes.md",
    }
    captions = re.findall(r"^:caption: (\w+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.M)
    assert [caption.lower() for caption in captions] == [*parts, "besides"]


def test_gallery_has_a_picture_of_each_script(site):
    index = (site / "html" / "auto_gallery" / "index.html").read_text(encoding="utf-8")
    left_to_others = () if importlib.util.find_spec("roughcontact_layered") else ("15_layered", "18_crystals")
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
        needed = {"rc.": "roughcontact", "roughcontact_layered": "roughcontact-layered", "to_pandas": "pandas"}
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


@pytest.mark.parametrize("pattern", ["*.md", "docs/**/*.md", "plugins/*/README.md"])
def test_plugins_are_installed_as_old_versions_of_pip_can(pattern):
    """Before 23.3 pip finds the roughcontact of a plug-in only with the same extras, or in an earlier command."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in ROOT.glob(pattern))
    for command in re.findall(r"pip install (?:[^&`\n]*)", text):
        given = re.search(r"-e '?\.(\[[a-z,]+\])?", command)
        for name in re.findall(r"\./plugins/([a-z-]+)", command):
            project = tomllib.loads((ROOT / "plugins" / name / "pyproject.toml").read_text(encoding="utf-8"))["project"]
            if given is not None:
                assert f"roughcontact{given[1] or ''}" in project["dependencies"], command
