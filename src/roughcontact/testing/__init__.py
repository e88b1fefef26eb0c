"""Conformance tests: claims about every kernel, convolver, solver, material, estimator and other part.

For authors of plug-ins; the rest of the package does not need it. The hypothesis strategies are in
`roughcontact.testing.strategies`, which alone needs hypothesis.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from roughcontact._base.registry import Registry
from roughcontact.testing import (  # noqa: F401 - claims
    answers,
    convolvers,
    inputs,
    kernels,
    laws,
    panels,
    shear,
    solvers,
)
from roughcontact.testing.claim import (
    Claim,
    DoesNotApply,
    Finding,
    Report,
    check,
    claims,
    kind_of,
    known_kinds,
    require,
)
from roughcontact.testing.problems import Judgement, judge

KINDS: Mapping[str, Registry[Any]] = MappingProxyType(known_kinds())

__all__ = [
    "KINDS",
    "Claim",
    "DoesNotApply",
    "Finding",
    "Judgement",
    "Report",
    "check",
    "claims",
    "judge",
    "kind_of",
    "require",
]
