"""Print the oldest versions that pyproject.toml allows, as constraints for pip."""

from __future__ import annotations

import itertools
import re
import tomllib
from pathlib import Path


def oldest(requirements: list[str]) -> list[str]:
    """Each lower bound as an exact version; a requirement without one is an error."""
    lines = []
    for requirement in requirements:
        found = re.fullmatch(r"([\w.-]+)>=([\w.]+)", requirement)
        if found:
            lines.append(f"{found[1]}=={found[2]}")
        elif not requirement.startswith("roughcontact["):
            raise SystemExit(f"pyproject.toml: {requirement!r} has no lower bound of the form name>=version.")
    return lines


if __name__ == "__main__":
    settings = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    project = settings["project"]
    parts = [project["dependencies"], *project["optional-dependencies"].values(), settings["dependency-groups"]["test"]]
    print("\n".join(oldest(list(itertools.chain(*parts)))))
