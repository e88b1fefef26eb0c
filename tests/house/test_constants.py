"""Every number that a module is named by says what it is: value, unit, meaning and where it comes from.

`python tests/house/test_constants.py` prints the constants that do not.
"""

from __future__ import annotations

import ast
import tokenize
from pathlib import Path

import roughcontact

ROOT = Path(roughcontact.__file__).parent
MODULES = sorted(ROOT.rglob("*.py"))
# Calls that make a number of numbers.
NUMERIC_CALLS = {
    "array",
    "asarray",
    "float",
    "int",
    "sqrt",
    "log",
    "exp",
    "finfo",
    "geomspace",
    "linspace",
    "frozenset",
}


def is_numeric(node):
    """Tell whether an expression holds numbers and nothing but numbers."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, (int, float, complex)) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return is_numeric(node.operand)
    if isinstance(node, ast.BinOp):
        return any(map(is_numeric, (node.left, node.right)))
    if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
        return bool(node.elts) and all(map(is_numeric, node.elts))
    if isinstance(node, ast.Dict):
        return bool(node.values) and all(map(is_numeric, node.values))
    if isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        return name in NUMERIC_CALLS and all(map(is_numeric, node.args))
    if isinstance(node, ast.Attribute):
        return ast.unparse(node) in {"math.pi", "math.e", "math.inf", "np.pi", "np.inf"} or is_numeric(node.value)
    return False


def find_constants(path):
    """Return (line, name, whether a comment explains it) of each numeric constant of a module.

    A comment explains the constants on the lines right below it.
    """
    with tokenize.open(path) as file:
        comments = {
            token.start[0] for token in tokenize.generate_tokens(file.readline) if token.type == tokenize.COMMENT
        }
    found = []
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        lines = set(range(node.lineno, node.end_lineno + 1))
        explained = node.lineno - 1 in comments or bool(comments & lines)
        if targets and explained:
            comments |= lines
        if targets and node.value is not None and is_numeric(node.value):
            found.append((node.lineno, ast.unparse(targets[0]), explained))
    return found


def list_unexplained():
    return [
        f"{path.relative_to(ROOT)}:{line} {name}"
        for path in MODULES
        for line, name, explained in find_constants(path)
        if not explained
    ]


def test_every_constant_is_explained():
    assert list_unexplained() == []


if __name__ == "__main__":
    print("\n".join(list_unexplained()))
