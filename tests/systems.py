"""Marks of tests that need what not every operating system has."""

from __future__ import annotations

import os
import sys

import pytest

posix = pytest.mark.skipif(os.name != "posix", reason="signals, pipes, permissions and limits are those of POSIX")
linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits and figures are those of Linux")
