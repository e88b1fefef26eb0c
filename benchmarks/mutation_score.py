"""Mutation score: of places drawn at random where the code is changed, how many do the fast tests notice.

`python benchmarks/mutation_score.py record` runs the fast tests once and notes which test runs which line (10 minutes);
`python benchmarks/mutation_score.py score --places 300 --seed 7` then draws places and runs, for each, the tests that
run its line, those that run little else first. All happens in copies of the tree; needs the package coverage besides
those of the tests. Tests beyond the bound of seconds do not run, so that the score is a lower bound.
"""

from __future__ import annotations

import argparse
import ast
import collections
import functools
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "src/roughcontact"
SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "**": "*", "//": "/", "%": "*"}
SWAPPED |= {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "and": "or", "or": "and"}
SWAPPED |= {"is not": "is", "is": "is not", "not in": "in", "in": "not in"}
SWAPPED |= {low + end: high + end for low, high in (("min", "max"), ("max", "min")) for end in ("", "imum")}
SWAPPED |= {"argmin": "argmax", "argmax": "argmin", "fmin": "fmax", "fmax": "fmin"}
# Arguments that change no result: of the transforms, of attrs and of a reader.
_NO_RESULT = {"eq", "maxworkers", "overwrite_x", "repr", "workers"}
# Tests of a place that run before the others are collected.
_FIRST = 20
OPERATOR = re.compile(r"\*\*|//|<=|>=|==|!=|[-+*/%<>]|\b(?:is not|not in|is|in|and|or)\b")


class Places(ast.NodeVisitor):
    """All changes of a module: the first and last line of the statement, the bytes replaced, and what replaces them."""

    def __init__(self, path: Path):
        self.path, self.source, self.found = path, path.read_bytes(), []
        self.starts = [0]
        for line in self.source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.lines, self.functions = (0, 0), 0
        self.visit(ast.parse(self.source))

    def at(self, line: int, column: int) -> int:
        return self.starts[line - 1] + column

    def span(self, node: ast.AST) -> tuple[int, int]:
        return self.at(node.lineno, node.col_offset), self.at(node.end_lineno, node.end_col_offset)

    def text(self, node: ast.AST) -> str:
        return self.source[slice(*self.span(node))].decode()

    def change(self, begin: int, end: int, new: str) -> None:
        self.found.append((str(self.path.relative_to(ROOT)), *self.lines, self.functions, begin, end, new))

    def swap(self, left: ast.AST, right: ast.AST) -> None:
        begin, end = self.span(left)[1], self.span(right)[0]
        between = re.sub(rb"#.*", lambda one: b" " * len(one[0]), self.source[begin:end]).decode()
        operator = OPERATOR.search(between)
        if operator and operator[0] in SWAPPED:
            self.change(begin + operator.start(), begin + operator.end(), SWAPPED[operator[0]])

    def visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            self.lines = (node.lineno, body[0].lineno - 1 if isinstance(body, list) else node.end_lineno)
            self.lines = (self.lines[0], max(self.lines))
        super().visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        lines = self.lines
        for default in [*node.args.defaults, *(one for one in node.args.kw_defaults if one)]:
            self.visit(default)
        self.functions += 1
        for one in node.body:
            self.visit(one)
        self.functions -= 1
        self.lines = lines

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value:
            self.visit(node.value)

    def visit_Raise(self, node: ast.Raise) -> None:
        pass

    visit_JoinedStr = visit_Raise  # noqa: N815

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call) and "warn" not in self.text(node.value.func):
            self.change(*self.span(node), "pass")
            self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self.change(*self.span(node), "pass")
        self.swap(node.target, node.value)
        self.generic_visit(node)

    def visit_Return(self, node: ast.Return) -> None:
        if node.value and not (isinstance(node.value, ast.Constant) and node.value.value is None):
            self.change(*self.span(node.value), "None")
            self.generic_visit(node)

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" not in self.text(node.test):
            self.change(*self.span(node.test), f"not ({self.text(node.test)})")
            self.generic_visit(node)

    visit_While = visit_IfExp = visit_If  # noqa: N815

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not any(isinstance(one, ast.JoinedStr) or type(getattr(one, "value", 0)) is str for one in ast.walk(node)):
            self.swap(node.left, node.right)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        self.swap(*node.values[:2])
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, right in zip([node.left, *node.comparators], node.comparators, strict=False):
            self.swap(left, right)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        self.change(*self.span(node), f"({self.text(node.operand)})")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool):
            self.change(*self.span(node), str(not node.value))
        elif isinstance(node.value, int | float):
            value = self.text(node)
            self.change(
                *self.span(node),
                random.Random(str(self.span(node))).choice([f"(2 * {value} + 1)", f"({value} + 1)", f"(-{value} - 1)"]),
            )

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg in _NO_RESULT:
            return
        if node.arg == "axis" and isinstance(node.value, ast.Constant | ast.UnaryOp):
            self.change(*self.span(node.value), "1" if self.text(node.value) == "0" else "0")
        else:
            self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = self.text(node.func).rsplit(".", 1)[-1]
        if name in SWAPPED:
            end = self.span(node.func)[1]
            self.change(end - len(name), end, SWAPPED[name])
        if "warn" not in name:
            self.generic_visit(node)

    def visit_Slice(self, node: ast.Slice) -> None:
        if node.lower:
            self.change(*self.span(node.lower), f"({self.text(node.lower)}) + 1")
        if node.upper:
            self.change(*self.span(node.upper), f"({self.text(node.upper)}) - 1")
        self.generic_visit(node)


def all_places() -> list[tuple]:
    """Every place of the package."""
    return [one for path in sorted(PACKAGE.rglob("*.py")) for one in Places(path).found]


class Recorder:
    """A pytest plug-in that notes which test runs which line, and how long each test takes."""

    def __init__(self, folder: Path):
        import coverage

        self.folder, self.seconds = folder, {}
        self.coverage = coverage.Coverage(data_file=None, include=[f"{PACKAGE}/*"])
        self.coverage.start()

    def pytest_runtest_logreport(self, report) -> None:
        # A test that fails or is skipped where nothing is changed judges nothing.
        took = report.duration if report.passed else -1e9
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + took

    def pytest_runtest_setup(self, item) -> None:
        # A cached value is computed anew, or only the first test would run its lines.
        for name, module in list(sys.modules.items()):
            if name.startswith(("roughcontact.", "test_")):
                for one in list(vars(module).values()):
                    if isinstance(one, functools._lru_cache_wrapper):
                        one.cache_clear()
        self.coverage.switch_context(item.nodeid)

    def pytest_sessionfinish(self) -> None:
        self.coverage.stop()
        data = self.coverage.get_data()
        lines = {str(Path(one).relative_to(ROOT)): data.contexts_by_lineno(one) for one in data.measured_files()}
        self.folder.mkdir(exist_ok=True, parents=True)
        kept = {"lines": lines, "seconds": self.seconds}
        (self.folder / f"record-{os.environ.get('PYTEST_XDIST_WORKER', 'main')}.json").write_text(json.dumps(kept))


class Chosen:
    """A pytest plug-in that runs the given tests in the given order."""

    def __init__(self, order: dict[str, int]):
        self.order = order

    def pytest_collection_modifyitems(self, items) -> None:
        items[:] = sorted((one for one in items if one.nodeid in self.order), key=lambda one: self.order[one.nodeid])


def pytest_configure(config) -> None:
    """Register the recorder: in workers of xdist, or in the one process without them."""
    if not config.getoption("numprocesses", None) or "PYTEST_XDIST_WORKER" in os.environ:
        config.pluginmanager.register(Recorder(Path(os.environ["MUTATION_RECORDS"])))


def record(scratch: Path, workers: int) -> None:
    """Run the fast tests once, and note which test runs which line; a test that fails is noted as one that fails."""
    tree = copy_of_tree(scratch / "record")
    shutil.rmtree(scratch / "records", ignore_errors=True)
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(workers), "-p", Path(__file__).stem]
    command += ["-p", "no:cacheprovider"]
    environment = {"MUTATION_RECORDS": str(scratch / "records"), "PYTHONPATH": f"{tree}/src:{tree}/benchmarks"}
    ended = subprocess.run(command, cwd=tree, env={**os.environ, **environment}, check=False).returncode
    if ended not in (0, 1):
        raise SystemExit(f"pytest has ended with {ended}")


def copy_of_tree(target: Path) -> Path:
    """Copy what git knows, without its history, and return where."""
    shutil.rmtree(target, ignore_errors=True)
    for name in subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).splitlines():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target / name)
    return target


def name_of(place: tuple) -> str:
    """Return the name that the statement of a place at the head of a module gives a value; empty if it gives none."""
    found = re.match(r"(\w+)(?:\s*:[^=]+)?\s*\|?=[^=]", (ROOT / place[0]).read_text().split("\n", place[1] - 1)[-1])
    return found[1] if found else ""


@functools.lru_cache
def lines_with(name: str) -> list[tuple[str, int]]:
    """Return the files and lines of the package where a name stands."""
    found = re.compile(rf"\b{name}\b") if name else re.compile("(?!)")
    return [
        (str(path.relative_to(ROOT)), number)
        for path in PACKAGE.rglob("*.py")
        for number, line in enumerate(path.read_text().split("\n"), 1)
        if found.search(line)
    ]


def tests_of(place: tuple, lines: dict, seconds: dict, breadth: dict, bound: float) -> list[str]:
    """The tests that run the place, those that are fast and run little else first, up to a bound of seconds."""
    path, first, last, inside, *_ = place
    module = lines.get(path, {})
    chosen = {one for line in range(first, last + 1) for one in module.get(line, ()) if inside}
    if not inside:  # what runs at import is noticed where its name stands, or by any test of the module
        chosen = {one for where, line in lines_with(name_of(place)) for one in lines.get(where, {}).get(line, ())}
    if not chosen:
        chosen = {one for names in module.values() for one in names}
    order = sorted(chosen & seconds.keys(), key=lambda one: (seconds[one] + 0.01) * breadth[one])
    total, kept = 0.0, []
    for one in order:
        total += seconds[one]
        if total > bound and kept:
            break
        kept.append(one)
    return kept


def killed(tree: Path, place: tuple, tests: list[str], seconds: dict) -> bool:
    """Whether one of the tests fails, or they do not end, where the place is changed, in a process of its own."""
    import pytest

    # In time of the processor: others on the machine must not stop tests that go on.
    limit = int(30.0 + 4.0 * sum(seconds[one] for one in tests))
    path, *_, begin, end, new = place
    file = tree / path
    kept, times = file.read_bytes(), file.stat()
    file.write_bytes(kept[:begin] + new.encode() + kept[end:])
    child = os.fork()
    if child == 0:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        with open(tree.with_suffix(".log"), "w") as log:
            os.dup2(log.fileno(), 1)
            os.dup2(log.fileno(), 2)
            files = sorted({one.split("::")[0] for one in tests})
            order = {one: number for number, one in enumerate(tests)}
            status = 1
            try:
                status = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *files], plugins=[Chosen(order)]))
            finally:
                sys.stdout.flush()
                os._exit(status)
    try:
        deadline = time.monotonic() + 10.0 * limit
        while time.monotonic() < deadline:
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                # Five: none of the tests was found, so that none has failed.
                return os.waitstatus_to_exitcode(status) not in (0, 5)
            time.sleep(0.02)
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return True
    finally:
        file.write_bytes(kept)
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))


def score(scratch: Path, count: int, seed: int, workers: int, bound: float, only: str) -> None:
    """Draw places and print which of them live, and the fraction killed by package."""
    lines, seconds, breadth = {}, {}, collections.Counter()
    for one in (scratch / "records").glob("record-*.json"):
        read = json.loads(one.read_text())
        seconds |= {name: took for name, took in read["seconds"].items() if took > 0}
        for path, module in read["lines"].items():
            for line, names in module.items():
                lines.setdefault(path, {}).setdefault(int(line), set()).update(names)
                breadth.update(names)
    places = [one for one in all_places() if only in one[0]]
    places = random.Random(seed).sample(places, min(count, len(places)))
    results = scratch / f"results-{seed}.jsonl"
    results.unlink(missing_ok=True)
    children = []
    for number in range(workers):
        child = os.fork()
        if child:
            children.append(child)
            continue
        tree = copy_of_tree(scratch / f"tree-{number}")
        os.chdir(tree)
        sys.dont_write_bytecode = True
        sys.path[0] = f"{tree}/src"
        os.environ |= {"PYTHONPATH": f"{tree}/src", "OMP_NUM_THREADS": "1"}
        # Compiled once: only the module that is changed, whose time is another, is compiled for each place.
        subprocess.run([sys.executable, "-m", "pytest", "--collect-only", "-qq"], stdout=subprocess.DEVNULL, check=True)
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        for name in (
            "scipy.optimize",
            "scipy.interpolate",
            "scipy.ndimage",
            "scipy.sparse.linalg",
            "scipy.sparse.csgraph",
            "scipy.integrate",
            "scipy.signal",
            "scipy.spatial",
            "mpmath",
        ):
            __import__(name)
        for place in places[number::workers]:
            tests = tests_of(place, lines, seconds, breadth, bound)
            if place is places[number]:  # nothing may fail where nothing is changed
                assert not killed(tree, (*place[:4], 0, 0, ""), tests[:_FIRST], seconds), f"see {tree}.log"
            # Most changes are noticed by the first tests: the files of the others need not be collected.
            dead = any(killed(tree, place, part, seconds) for part in (tests[:_FIRST], tests[_FIRST:]) if part)
            old = (ROOT / place[0]).read_bytes()[place[4] : place[5]].decode()
            row = {"place": f"{place[0]}:{place[1]}", "old": old, "new": place[6], "killed": dead, "tests": len(tests)}
            if dead:  # none where the tests do not end
                row["by"] = re.findall(r"^(?:FAILED|ERROR) (\S+)", tree.with_suffix(".log").read_text(), re.M)
            with results.open("a") as file:
                file.write(json.dumps(row) + "\n")
        os._exit(0)
    for child in children:
        if os.waitpid(child, 0)[1]:
            raise SystemExit("a worker has failed")
    report([json.loads(one) for one in results.read_text().splitlines()])


def report(rows: list[dict]) -> None:
    """Print the living ones, and the score of each package."""
    packages = collections.defaultdict(list)
    for row in sorted(rows, key=lambda one: one["place"]):
        packages[row["place"].split("/")[2]].append(row["killed"])
        if not row["killed"]:
            print(f"lives: {row['place']} ({row['tests']} tests)\n    {row['old']}\n    -> {row['new']}")
    for name, dead in packages.items():
        print(f"{name:12s} {sum(dead):3d} of {len(dead):3d}")
    print(f"all          {sum(one['killed'] for one in rows):3d} of {len(rows):3d}")


def main() -> None:
    """Read the arguments and do what they say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("record", "score"))
    parser.add_argument("--scratch", type=Path, required=True, help="an empty folder for copies of the tree")
    parser.add_argument("--places", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=40.0, help="tests of a place run this long at most")
    parser.add_argument("--only", default="", help="a part of the path of the files")
    given = parser.parse_args()
    if given.what == "record":
        record(given.scratch, given.workers)
    else:
        score(given.scratch, given.places, given.seed, given.workers, given.seconds, given.only)


if __name__ == "__main__":
    main()
