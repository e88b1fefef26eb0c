"""Pages by the templates of this package, in which every text is escaped."""

from __future__ import annotations

import functools
from typing import Any

from roughcontact._faces.html.words import allowed
from roughcontact.errors import requiring


def require_jinja() -> None:
    """Raise `MissingPackage` without Jinja2."""
    with requiring("Reports need the package jinja2: pip install 'roughcontact[report]'."):
        import jinja2  # noqa: F401 - whether it is there


def make_page(template: str, **given: Any) -> str:
    """Return the page that a template makes of what it is given, which must be all that it uses."""
    require_jinja()
    return allowed(_load_templates().get_template(template).render(given))


@functools.cache
def _load_templates() -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
