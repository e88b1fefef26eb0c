"""The pages: the site builds without a warning, the examples in docstrings run, and nothing public is missing."""

from __future__ import annotations

import doctest
import importlib
import importlib.util
import inspect
import pkgutil
import re
import tomllib
from pathlib import Path

import pytest

import roughcontact
import roughcontact.slabs
import roughcontact.testing
import roughcontact.typing

ROOT = Path(__file__).parents[2]
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
    "roughcontact.reference.theories",
    "roughcontact._base.registry",
    "roughcontact.testing.claim",
}


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


@pytest.mark.parametrize(
    ("module", "name"),
    [(module, name) for module in (roughcontact, roughcontact.testing) for name in sorted(module.__all__)],
)
def test_each_public_class_and_function_shows_an_example(module, name):
    public = getattr(module, name)
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
        r"^\.\. (?:auto\w+|data):: (?:roughcontact\.(?:faces|responses|results|slabs|solving|testing|typing)\.)?(\w+)$",
        pages,
        re.M,
    )
    arrays = {"Array", "IntArray", "Mask", "Pair", "RealArray"}
    modules = (getattr(roughcontact, name) for name in ("faces", "results", "slabs", "solving", "testing", "typing"))
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


def count_words(page):
    """Words outside code and tables; references are looked up, not read."""
    text = re.sub(r"^(`{3,})\w*.*?^\1$|^\$\$.*?^\$\$$", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    lines = [line for line in text.splitlines() if not line.startswith(("|", "<!--"))]
    return len(" ".join(lines).split())


# Not those that pytest leaves in the folders of plug-ins.
READMES = [ROOT / "plugins" / "README.md", *sorted(ROOT.glob("plugins/*/README.md"))]


def name(page):
    return f"{page.parent.name}/{page.stem}"


@pytest.mark.parametrize("page", [pytest.param(page, id=name(page)) for page in (*PAGES, *READMES)])
def test_no_page_is_longer_than_a_reader_stays(page):
    assert count_words(page) <= 1200


def test_all_pages_together_are_no_longer_than_a_book():
    assert sum(map(count_words, (*PAGES, *READMES))) <= 36_000


@pytest.mark.parametrize("readme", READMES, ids=name)
def test_the_site_has_a_page_for_each_plugin(readme):
    if readme.parent.name != "roughcontact-app":
        includes = f"plugins/{readme.relative_to(ROOT / 'plugins').as_posix()}\n"
        assert any(includes in page.read_text(encoding="utf-8") for page in PAGES)


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
