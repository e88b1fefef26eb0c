"""Parts as plain data, and back; keys made from them and from the programs that they are."""

from roughcontact.description.plain import (
    Described,
    arrays_in,
    describe,
    key_of,
    key_of_description,
    missing_classes,
    parts,
    programs_of,
    public_class,
    rebuild,
    rebuild_fields,
)

__all__ = [
    "Described",
    "arrays_in",
    "describe",
    "key_of",
    "key_of_description",
    "missing_classes",
    "parts",
    "programs_of",
    "public_class",
    "rebuild",
    "rebuild_fields",
]
