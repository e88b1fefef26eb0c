"""An interrupt of the command ``roughcontact`` before it runs, while packages are imported, is a sentence as well."""

from __future__ import annotations

import sys
from pathlib import Path
from types import TracebackType


def _report(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if issubclass(kind, KeyboardInterrupt):
        print("roughcontact: interrupted", file=sys.stderr)
    else:
        sys.__excepthook__(kind, error, trace)


# While a package is imported for `python -m`, its place among the arguments is taken by "-m".
if Path(sys.argv[0]).stem == "roughcontact" or (sys.argv[0] == "-m" and "roughcontact" in sys.orig_argv):
    sys.excepthook = _report
