"""Tables of plain numbers, read by numpy: the quick way, where nothing has to be asked."""

from __future__ import annotations

import io
import re

import numpy as np

from roughcontact._base.arrays import Array

# Words for non-measured points, in a field of their own, also as the C library of Windows writes them (1.#QNAN).
NON_MEASURED_WORDS = r"\*+|-+|bad|n/?a|null|none|no ?data|invalid|missing|[-+]?1\.#\w+"
_WORDS = NON_MEASURED_WORDS.encode()
# An exponent of Fortran.
FORTRAN_EXPONENT = r"(?<=[0-9.])[dD](?=[-+]?[0-9])"
_FORTRAN = re.compile(FORTRAN_EXPONENT.encode())


def read_plain(data: bytes, encoding: str, separator: str, decimal: str, first: int) -> Array | None:
    """Return the table of numbers from a line of a text on; None if it is not surely one without exceptions.

    It has the same number of fields in each line, no comment or blank line, no number that is too large, and no mark
    of quotation, decimal comma or word for a non-measured point that could mean anything else.
    """
    *above, body = _recode(data, encoding).split(b"\n", first - 1)
    body = body.rstrip(b" \t\r\n" if separator != "\t" else b"\r\n") if len(above) == first - 1 else b""
    if not body or b"#" in body.replace(b"1.#", b""):
        return None
    count = body.count(b"\n") + 1
    mark = separator.encode()
    plain = _unquote(body, mark, count)
    if plain is None:
        return None
    body, mark = plain
    if decimal == ",":
        if mark == b" " and re.search(rb",\s", body):
            return None
        body = body.replace(b",", b".")
    body = _FORTRAN.sub(b"e", body) if re.search(rb"[dD]", body[: body.find(b"\n")]) else body
    found = _parse(body, mark)
    if found is None:
        found = _parse(_fill_words(body, mark), mark)
    # Infinite numbers may be too large ones.
    return None if found is None or len(found) != count or np.isinf(found).any() else found


def _recode(data: bytes, encoding: str) -> bytes:
    """Return text in UTF-8, with the ends of lines of Unix."""
    if encoding == "utf-8-sig":
        data = data[3:]
    elif encoding != "utf-8":
        data = data.decode(encoding).encode()
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def _unquote(body: bytes, mark: bytes, count: int) -> tuple[bytes, bytes] | None:
    """Return lines without quotation marks, and their separator; None where some fields alone are quoted."""
    if b'"' not in body:
        return body, mark
    joint = b'"' + mark + b'"'
    inner = body.replace(joint, b";")
    # One mark at the beginning and one at the end of each line are left.
    if mark == b" " or inner.count(b'"') != 2 * count or inner.count(b'"\n"') != count - 1 or b";" in body:
        return None
    inner = inner.replace(b'"', b"")
    if b"," in inner and b"." in inner:
        return None
    return inner.replace(b",", b"."), b";"


def _fill_words(body: bytes, mark: bytes) -> bytes:
    """Return lines with nan for a word of a non-measured point, or for an empty field between separators."""
    if mark == b" ":
        return re.sub(rb"(?i)(?<!\S)(?:" + _WORDS + rb")(?!\S)", b"nan", body)
    found = re.escape(mark)
    return re.sub(rb"(?im)(?<![^" + found + rb"\n]) *(?:" + _WORDS + rb")? *(?=" + found + rb"|$)", b"nan", body)


def _parse(body: bytes, mark: bytes) -> Array | None:
    try:
        return np.loadtxt(
            io.BytesIO(body),
            delimiter=None if mark == b" " else mark.decode(),
            comments=None,
            encoding="utf-8",
            ndmin=2,
        )
    except (ValueError, OverflowError):
        return None
