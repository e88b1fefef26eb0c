"""The measured numbers behind the warnings of a contact, of fields that are known, at both sides of their bounds."""

from __future__ import annotations
