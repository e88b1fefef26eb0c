"""What the scripts of the gallery need before they run in a browser, where no package is installed."""

from __future__ import annotations

from typing import Any

# Beside what every script needs, packages that some do, by a word of theirs.
_NEEDED_BY = {
    "roughcontact_layered": "roughcontact-layered",
    "roughcontact_volume": "roughcontact-volume",
    "to_pandas": "pandas",
}


def install_first(notebook: dict[str, Any], name: str) -> None:
    """Put a cell that installs them before the others: the project's own wheels lie beside the notebooks."""
    text = "".join("".join(cell["source"]) for cell in notebook["cells"])
    packages = ["roughcontact", "matplotlib", *(package for word, package in _NEEDED_BY.items() if word in text)]
    source = ["# Some seconds at the first time.\n", f"%pip install -q {' '.join(packages)}"]
    cell = {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": source}
    notebook["cells"].insert(0, cell)
