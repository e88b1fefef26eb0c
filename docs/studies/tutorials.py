"""Run the tutorials and keep the figures that they write: docs/figures/tutorial_*.png.

python docs/studies/tutorials.py [NAME ...]
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent.parent


def run(page: Path, folder: Path) -> None:
    """Run the blocks of a page one after the other in a folder."""
    blocks = re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.S | re.M)
    environment = {**os.environ, "MPLBACKEND": "agg"}
    subprocess.run([sys.executable, "-c", "\n".join(blocks)], cwd=folder, check=True, env=environment)


def main(names: list[str]) -> None:
    for page in sorted(DOCS.rglob("tutorial_*.md")):
        if names and page.stem not in names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            run(page, Path(folder))
            for figure in Path(folder).glob("tutorial_*.png"):
                shutil.copy(figure, DOCS / "figures" / figure.name)
                print(figure.name)


if __name__ == "__main__":
    main(sys.argv[1:])
