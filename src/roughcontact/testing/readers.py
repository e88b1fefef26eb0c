"""Claims about surface readers."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from roughcontact.files import SurfaceReader
from roughcontact.testing.claim import Claim, require
from roughcontact.testing.common import common


def _suffixes(reader: SurfaceReader) -> str:
    suffixes = reader.suffixes
    require(isinstance(suffixes, frozenset), f"its endings are a {type(suffixes).__name__}, no frozenset")
    wrong = [suffix for suffix in suffixes if not suffix.startswith(".") or suffix != suffix.lower()]
    require(not wrong, f"the endings {wrong} are not lower case with a dot")
    return " ".join(sorted(suffixes)) or "none: it is asked for by name, or last"


def _damaged(reader: SurfaceReader) -> str:
    noise = np.random.default_rng(0).bytes(999)
    with tempfile.TemporaryDirectory() as folder:
        for suffix in sorted(reader.suffixes) or [".unknown"]:
            for number, content in enumerate((b"", b"\0" * 64, noise)):
                path = Path(folder) / f"damaged{number}{suffix}"
                path.write_bytes(content)
                try:
                    found = reader.read(path)
                # Any error will do: `read_surface` says which file it was.
                except Exception:
                    continue
                require(False, f"{len(content)} bytes of nothing with the ending {suffix} were read as {found!r:.60}")
    return "empty and damaged files raise"


CLAIMS = (
    Claim("reader", "endings", _suffixes),
    Claim("reader", "damaged files are refused", _damaged),
    *common("reader"),
)
