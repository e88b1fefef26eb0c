import doctest
import importlib

import pytest


@pytest.mark.parametrize("module", ["flow", "hardening", "plastic"])
def test_the_examples_of_the_docstrings_give_what_they_say(module):
    results = doctest.testmod(importlib.import_module(f"roughcontact_volume.{module}"))
    assert results.attempted > 0
    assert results.failed == 0
