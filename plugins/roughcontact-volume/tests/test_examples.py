"""The examples of docstrings and README give what they say."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import roughcontact_volume

README = Path(__file__).parents[1] / "README.md"
MODULES = [
    module.name
    for module in pkgutil.iter_modules(roughcontact_volume.__path__)
    if ">>> " in Path(roughcontact_volume.__path__[0], f"{module.name}.py").read_text(encoding="utf-8")
]


@pytest.mark.parametrize("module", MODULES)
def test_the_examples_of_the_docstrings_give_what_they_say(module):
    results = doctest.testmod(importlib.import_module(f"roughcontact_volume.{module}"))
    assert results.attempted > 0
    assert results.failed == 0


def test_the_example_of_the_readme_prints_what_it_says(capsys):
    text = README.read_text(encoding="utf-8")
    (example,) = re.findall(r"^```python\n(.*?)^```$", text, re.S | re.M)
    (said,) = re.findall(r"^```text\n(.*?)^```$", text, re.S | re.M)
    exec(example, {})
    printed = capsys.readouterr().out.split()
    for one, other in zip(said.split(), printed, strict=True):
        assert one == other or float(other) == pytest.approx(float(one), rel=0.01)
