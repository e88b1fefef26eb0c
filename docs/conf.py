"""The site: `sphinx-build -n -W -b html docs docs/_build/html`.

Nothing is fetched: no other project's inventory, and formulas become MathML while the site is
built, so that it reads the same without a network.
"""

from __future__ import annotations

import doctest
import inspect
import os
import re
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import attrs
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import inspect as sphinx_inspect

import roughcontact

project = "roughcontact"
author = "The roughcontact developers"
project_copyright = "2026, the roughcontact developers"
version = release = roughcontact.__version__
language = "en"

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.doctest",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "_contents", "gallery", "auto_gallery/*.ipynb"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}

html_theme = "furo"
html_title = f"roughcontact {release}"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["sidebar.js"]
html_search_scorer = str(Path(__file__).parent / "scorer.js")

# Prompts and output are not copied.
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
of_plugins = {"roughcontact_layered": "layered|crystals", "roughcontact_volume": "raceway"}
missing = [scripts for plugin, scripts in of_plugins.items() if find_spec(plugin) is None]
# The scripts of docs/gallery are run while the site is built; a script that fails fails the build.
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "filename_pattern": r"\.py$",
    "ignore_pattern": "|".join(["__init__", *missing]),
    "within_subsection_order": "FileNameSortKey",
    "capture_repr": (),
    "download_all_examples": False,
    "thumbnail_size": (800, 560),
    "write_computation_times": False,
    "show_signature": False,
    "min_reported_time": 3600,
    "remove_config_comments": True,
}
# Beside wheels of this project, which `.ci/run` builds first, each script gets a button that runs it in the browser.
# Only that page fetches something: Pyodide, when it is opened.
wheels = Path(__file__).parent / "_build" / "wheels"
if wheels.is_dir():
    sys.path.insert(0, str(Path(__file__).parent))
    extensions.append("jupyterlite_sphinx")
    sphinx_gallery_conf["jupyterlite"] = {
        "use_jupyter_lab": False,
        "jupyterlite_contents": "_build/gallery",
        "notebook_modification_function": "in_browser.install_first",
    }
    jupyterlite_dir = str(wheels.parent)
    jupyterlite_content_dir = "_build/gallery"
    jupyterlite_build_command_options = {"piplite-wheels": str(wheels), "LiteBuildConfig.no_sourcemaps": "True"}

myst_enable_extensions = ["dollarmath", "linkify"]
myst_linkify_fuzzy_links = False
myst_heading_anchors = 3

autosummary_generate = False
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("Array", "IntArray", "Mask", "Pair", "RealArray")}
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
doctest_default_flags = doctest.ELLIPSIS
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

# `name` in a docstring is a link where there is something of that name, and code where there is not.
default_role = "py:obj"
# What other packages, the standard library and our private modules call their types.
nitpick_ignore_regex = [
    (r"py:class", r"(abc|argparse|attrs?|collections|concurrent|contextlib|enum|numpy|os|pathlib|typing)\..*"),
    (r"py:class", r"(Array|(npt\.)?ArrayLike|Callable|IntArray|Mask|Pair|Path|Sequence|RealArray|NameOfNumber|T|T_co)"),
    (r"py:class", r"roughcontact\._(parts\.grid\.Load|base\.registry\.[A-Z]|work\.studies\.chain\.Chain)"),
    (r"py:class", r"roughcontact\.(_solve\.solution\.\w+|errors\.door)\.(S|T|T_co)"),
    (r"py:class", r"roughcontact\.(_faces\.panels\.base\.Panel|_solve\.problem\.scene\.Scene)"),
    (r"py:class", r"roughcontact\._solve\.solution\.answers\.ContactAnswers"),
    (r"py:class", r"(roughcontact\._answers\.flow\.network\.)?FlowNetwork"),
    (r"py:class", r"roughcontact\._(answers\.subsurface\.inputs\.SupportsResidualStress|base\.machine\.[ST])"),
    (r"py:class", r"(roughcontact\._base\.units\.)?Deferred|roughcontact\._work\.studies\.result\.SolvedAgain"),
    (r"py:class", r"(roughcontact\._base\.units\.(quantities\.)?)?HasUnit"),
    (r"py:class", r"roughcontact\.(errors\.sentence\.Argument|_parts\.materials\.isotropic\._Isotropic)"),
    (r"py:class", r"roughcontact\._solve\.problem\.slabs\.(arrays\.Extent|contact\.T)|types\.SimpleNamespace"),
    (r"py:class", r"roughcontact\._solve\.problem\.load_(path\.S|march\.Place)"),
    (r"py:class", r"roughcontact\._parts\.surfaces\.(synthetic\.SpectralSurface|treatment\.TreatedMap)"),
]


def mathml(tex: str, *, block: bool) -> str:
    r"""Translate a formula; docutils would take \frac12 for the fraction of 12 and what follows."""
    spelled = re.sub(r"\\([dt]?frac)(\d)(\d)", r"\\\1{\2}{\3}", tex)
    return str(tex2mathml(spelled, as_block=block))


def visit_math(translator: Any, node: nodes.math) -> None:
    """Write a formula in a line."""
    translator.body.append(mathml(node.astext(), block=False))
    raise nodes.SkipNode


def visit_math_block(translator: Any, node: nodes.math_block) -> None:
    """Write a formula on lines of its own."""
    translator.body.append(f'<div class="math">{mathml(node.astext(), block=True)}</div>')
    raise nodes.SkipNode


def plain_name(app: Sphinx, env: BuildEnvironment, node: Any, content: nodes.Node) -> nodes.Node | None:
    """Leave what the default role cannot find as code: an argument, an attribute, a word."""
    return content if node.get("refdomain") == "py" and node.get("reftype") == "obj" else None


def name_aliases() -> None:
    """Let `Array | None` be written so: Sphinx shows an alias within a union by its repr."""
    alias = getattr(sphinx_inspect, "TypeAliasForwardRef", None)
    if alias is not None:
        alias.__repr__ = lambda self: self.name


def show_cached_properties() -> None:
    """Put the cached properties of attrs classes where autodoc sees them: slots hide their docstrings."""
    modules = [module for name, module in sys.modules.items() if name.partition(".")[0] == "roughcontact"]
    for cls in {one for module in modules for one in vars(module).values() if isinstance(one, type)}:
        if cls.__module__.partition(".")[0] == "roughcontact" and attrs.has(cls):
            found = inspect.unwrap(vars(cls).get("__getattr__", object))
            cached = getattr(found, "__globals__", {}).get("cached_properties", {})
            # What no page shows stays cached.
            hidden = {name: function for name, function in cached.items() if not name.startswith("_")}
            for name, function in hidden.items():
                setattr(cls, name, property(function))
            if hidden:
                cls.__slots__ = tuple(name for name in cls.__slots__ if name not in hidden)


README = r"^```\{include\} ((?:\.\./)+plugins/[\w/-]*README\.md)\n```$"


def find_pages_of_plugins(docs: Path) -> dict[Path, Path]:
    """Which page shows the README of a plug-in."""
    pages = {docs.parent / "plugins/roughcontact-app/README.md": docs / "start/app.md"}
    for page in docs.glob("*/*.md"):
        for readme in re.findall(README, page.read_text(encoding="utf-8"), re.M):
            pages[Path(os.path.normpath(page.parent / readme))] = page
    return pages


def on_the_site(app: Sphinx, docname: str, source: list[str]) -> None:
    """Turn links to the files beside this folder, which GitHub shows, to the pages that include them."""
    docs = Path(app.srcdir).resolve()
    here = (docs / docname).parent
    shown = {docs.parent / "README.md": docs / "index.md", docs.parent / "CHANGELOG.md": docs / "changes.md"}
    shown |= find_pages_of_plugins(docs)

    def relink(text: str, folder: Path) -> str:
        def turn(link: re.Match[str]) -> str:
            target = Path(os.path.normpath(folder / link[1]))
            return f"]({Path(os.path.relpath(shown.get(target, target), here)).as_posix()}{link[2]})"

        return re.sub(r"\]\(([^):#]+)((?:#[^)]*)?)\)", turn, text)

    def include(found: re.Match[str]) -> str:
        readme = Path(os.path.normpath(here / found[1]))
        app.env.note_dependency(readme)
        return relink(readme.read_text(encoding="utf-8"), readme.parent)

    if (docs / f"{docname}.md").exists():
        source[0] = re.sub(README, include, relink(source[0], here), flags=re.M)


def add_words(app: Sphinx, docname: str, source: list[str]) -> None:
    """Enter the words of search.toml in the index of a page, which the search reads, below its title."""
    table = Path(app.srcdir) / "search.toml"
    words = tomllib.loads(table.read_text(encoding="utf-8")).get(docname)
    if words:
        app.env.note_dependency(table)
        entries = ", ".join(f"! {word}" for word in words)
        source[0] = re.sub(r"^(# .*\n)", rf"\1\n```{{index}} {entries}\n```\n", source[0], count=1, flags=re.M)


def list_names(app: Sphinx, docname: str, source: list[str]) -> None:
    """Add the names of each page of the reference to its index, with the first sentence of each."""
    if docname != "api/index":
        return
    for page in re.findall(r"^   (\w+)$", source[0], re.M):
        text = (Path(app.srcdir) / "api" / f"{page}.rst").read_text(encoding="utf-8")
        module, names = "roughcontact", []
        for kind, name, members in re.findall(
            r"^\.\. (currentmodule|auto\w+):: ([\w.]+)$(?:\n   :members: ([\w, ]+)$)?", text, re.M
        ):
            if kind in ("currentmodule", "automodule"):
                module = name
                names += [f"{name}.{member}" for member in members.split(", ") if member]
            elif kind != "autosummary":
                names.append(name if name.startswith("roughcontact.") else f"{module}.{name}")
        title = text.partition("\n")[0]
        lines = ["", title, "-" * len(title), "", ".. autosummary::", "   :nosignatures:", ""]
        source[0] += "\n".join([*lines, *(f"   ~{name}" for name in names), ""])


def fetch_nothing(app: Sphinx, pagename: str, templatename: str, context: dict[str, Any], doctree: Any) -> None:
    """Drop the web fonts that jupyterlite_sphinx has every page fetch for an iframe, which no page has."""
    context["css_files"] = [file for file in context["css_files"] if not str(file.filename).startswith("https:")]


def setup(app: Sphinx) -> None:
    """Enter the above."""
    name_aliases()
    show_cached_properties()
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_math_block, None))
    app.connect("missing-reference", plain_name)
    app.connect("html-page-context", fetch_nothing)
    app.connect("source-read", on_the_site)
    app.connect("source-read", add_words)
    app.connect("source-read", list_names)


html_math_renderer = "mathml"
