"""Conformance: what every kernel, convolver, solver, material, estimator and other part must do, claim by claim.

For authors of plug-ins; nothing else of the package needs it. The hypothesis strategies are in
`roughcontact.testing.strategies`, which alone needs hypothesis.
"""

from roughcontact.testing.claim import Claim, DoesNotApply, Finding, Report, require
from roughcontact.testing.kit import KINDS, check, claims, kind_of

__all__ = ["KINDS", "Claim", "DoesNotApply", "Finding", "Report", "check", "claims", "kind_of", "require"]
