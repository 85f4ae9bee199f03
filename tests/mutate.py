"""Would the tests see a mistake? Random small ones are made in copies of the code, one at a time, and the tests that reach them are run.

Run `python tests/mutate.py --count 200 --seed 1`; pytest does not collect this file. It prints every mutant that no test saw, and their
share. The first run measures which test reaches which line (the default tests, but for those of pages, films and processes) and keeps that
in out/mutation, with the judgement of each mutant: the same command again goes on where `--minutes` ended it. A mutant is left to the tests
that reach its line, the quickest first, for `--seconds` of their time at most; what a line does once for many tests (a press that is kept)
counts for the test that came first. So a survivor is a question, not yet a verdict.

mutmut and cosmic-ray do not draw a sample by a seed and do not drop statements, and cosmic-ray changes the checkout itself.
"""

import argparse
import ast
import copy
import hashlib
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "out" / "mutation"
CORE = ["engines/*", "linkage/linkage", "linkage/assembly", "kinematics/*", "dynamics/*", "simulation/*"]  # * matches folders too
# Tests of pages, films, packages and processes: they take long, and the numbers in them have tests of their own.
LEFT_OUT = ["docs", "filming", "integration", "packaging", "recording", "report", "reproduce", "sweep_cluster", "sweep_kill", "tour"]
COPIED = ("pinpress", "tests", "urdf", "viz", "docs", "pyproject.toml", "README.md", "CHANGELOG.md", "CONTRIBUTING.md", ".ci")
HANGS = 60.0  # [s] beyond the time its tests usually take


# ----------------------------------------------------------------------------------------------------------------------------- mutants


@dataclass(frozen=True)
class Mutant:
    """A module's source between two offsets, and what stands there instead."""

    module: str
    line: int
    last_line: int
    begin: int
    end: int
    before: str
    after: str
    at_import: bool  # outside of all functions
    text: str  # of its first line
    column: int

    def place(self, seed: int) -> str:
        """Where it stands in the draw of a seed; the same before and after changes elsewhere."""
        return hashlib.sha256(f"{seed} {self.module} {self.text} {self.column} {self.after}".encode()).hexdigest()

    def __str__(self) -> str:
        return f"pinpress/{self.module}.py:{self.line}: {' '.join(self.before.split())}  ->  {self.after}"


Comparisons = dict[type[ast.cmpop], type[ast.cmpop]]
NEGATED: Comparisons = {ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.Is: ast.IsNot, ast.In: ast.NotIn}
NEGATED |= {value: key for key, value in NEGATED.items()}
SHIFTED: Comparisons = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
OTHER: dict[type[ast.operator], type[ast.operator]] = {ast.Add: ast.Sub, ast.Mult: ast.Div, ast.BitAnd: ast.BitOr}
OTHER |= {value: key for key, value in OTHER.items()} | {ast.Pow: ast.Mult, ast.FloorDiv: ast.Div, ast.Mod: ast.Add}
TWINS = dict(item.split("/") for item in ["min/max", "minimum/maximum", "argmin/argmax", "any/all", "sin/cos", "floor/ceil", "zeros/ones"])
TWINS |= {value: key for key, value in TWINS.items()}
ABSOLUTE = ("abs", "absolute", "fabs")
SMALLEST = 1e-4  # smaller constants are tolerances: twice as much is no mistake


def with_field(node: ast.AST, field: str, value: object) -> Any:
    changed = copy.copy(node)
    setattr(changed, field, value)
    return changed


def is_counted(node: ast.expr) -> bool:
    """Whether a number is surely whole: there, < and <= differ."""
    return (isinstance(node, ast.Constant) and type(node.value) is int and node.value != 0) or (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "len"
    )


def is_immaterial(node: ast.BinOp) -> bool:
    """Whether it makes no difference: by a sign, one multiplies as well as divides; and of rounding only the order of magnitude counts."""
    sides = {ast.unparse(side) for side in (node.left, node.right)}
    return any("ROUNDING" in side or "sign(" in side for side in sides)


def alternatives(node: ast.AST) -> Iterator[ast.AST]:
    """What a slip of the pen makes of an expression."""
    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            yield with_field(node, "ops", [NEGATED[type(op)]()])
            if type(op) in SHIFTED and (is_counted(left) or is_counted(right)):
                yield with_field(node, "ops", [SHIFTED[type(op)]()])
        case ast.Compare(ops=[first, *others]) if type(first) in NEGATED:
            yield with_field(node, "ops", [NEGATED[type(first)](), *others])
        case ast.BinOp(op=op) if type(op) in OTHER and not is_immaterial(node):
            yield with_field(node, "op", OTHER[type(op)]())
        case ast.BoolOp(op=op):
            yield with_field(node, "op", ast.Or() if isinstance(op, ast.And) else ast.And())
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            yield operand
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1 if abs(value) < 10 else 2 * value)
        case ast.Constant(value=float(value)) if value == 0 or abs(value) >= SMALLEST:
            yield ast.Constant(2 * value or 1.0)
        case ast.Name(id=name, ctx=ast.Load()) if name in TWINS:
            yield with_field(node, "id", TWINS[name])
        case ast.Attribute(attr=name) if name in TWINS:
            yield with_field(node, "attr", TWINS[name])
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=[only], keywords=[]) if name in ABSOLUTE:
            yield only
        case ast.IfExp(test=test):
            yield with_field(node, "test", ast.UnaryOp(ast.Not(), test))
        case ast.Call(keywords=[_, *_]):
            for number in range(len(node.keywords)):
                if node.keywords[number].arg in ("axis", "default", "initial"):
                    yield with_field(node, "keywords", node.keywords[:number] + node.keywords[number + 1 :])


def can_be_dropped(node: ast.stmt) -> bool:
    """Statements without which the code still runs: what they set was there before."""
    match node:
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Continue() | ast.Break():
            return True
        case ast.Assign(targets=[ast.Subscript() | ast.Attribute()]):
            return True
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            return any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(value))
    return False


UNTOUCHED = (ast.Assert, ast.JoinedStr, ast.Import, ast.ImportFrom, ast.arg, ast.Global, ast.Nonlocal)


def parts(node: ast.AST, at_import: bool) -> Iterator[tuple[ast.AST, bool]]:
    """All nodes whose meaning matters, with whether they run at import: neither annotations nor messages."""
    if isinstance(node, UNTOUCHED) or (isinstance(node, ast.FunctionDef) and node.name in ("__repr__", "__str__")):
        return
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        return
    yield node, at_import
    if isinstance(node, ast.Raise) or (isinstance(node, ast.Call) and ast.unparse(node.func).endswith("warn")):
        return
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "isinstance":
        yield from parts(node.args[0], at_import)
        return
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list") or (isinstance(node, ast.keyword) and node.arg == "strict"):
            continue
        within = at_import and not (isinstance(node, ast.FunctionDef | ast.Lambda) and field == "body")
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from parts(child, within)


def name_of(path: Path) -> str:
    """A module's path in the package without its ending: engines/branch."""
    return path.relative_to(ROOT / "pinpress").with_suffix("").as_posix()


def mutants(module: str) -> list[Mutant]:
    """All of a module."""
    text = (ROOT / "pinpress" / f"{module}.py").read_text(encoding="utf-8")
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))  # offsets of ast are in bytes
    found = []
    for node, at_import in parts(ast.parse(text), True):
        replaced = [ast.unparse(other) for other in alternatives(node)]
        replaced = [f"({other})" if isinstance(node, ast.expr) else other for other in replaced]
        replaced += ["pass"] if isinstance(node, ast.stmt) and can_be_dropped(node) else []
        for after in replaced:
            begin, end = starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
            before = text.encode()[begin:end].decode()
            words = text.splitlines()[node.lineno - 1].strip()  # type: ignore[attr-defined]
            found.append(Mutant(module, node.lineno, node.end_lineno, begin, end, before, after, at_import, words, node.col_offset))  # type: ignore[attr-defined]
    return found


# ----------------------------------------------------------------------------------------------------------- which test reaches what


@dataclass(frozen=True)
class Reach:
    """Seconds of every test that passes, and the tests that reach each line (module, number)."""

    seconds: dict[str, float]
    tests: dict[tuple[str, int], tuple[str, ...]]

    def of(self, mutant: Mutant) -> list[str]:
        """Tests that reach a mutant; of what runs at import, those that reach anything of the module."""
        lines = range(mutant.line, mutant.last_line + 1)
        if mutant.at_import:
            reached = {test for (module, _), tests in self.tests.items() if module == mutant.module for test in tests}
        else:
            reached = {test for line in lines for test in self.tests.get((mutant.module, line), ())}
        return sorted(reached & self.seconds.keys(), key=lambda test: (self.seconds[test], test))


class Stopwatch:
    """A plugin that notes how long each test took that passed."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()

    def pytest_runtest_logreport(self, report: Any) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration
        if report.outcome != "passed":
            self.failed.add(report.nodeid)


def measured() -> Reach:
    """Of the checkout as it is, by coverage.py; kept until code or tests change."""
    code = [path for folder in ("pinpress", "tests") for path in sorted((ROOT / folder).rglob("*.py"))]
    stamp = hashlib.sha256(b"".join(path.read_bytes() for path in code if path != Path(__file__).resolve())).hexdigest()[:12]
    KEPT.mkdir(parents=True, exist_ok=True)
    data, seconds = KEPT / f"{stamp}.coverage", KEPT / f"{stamp}.json"
    if not seconds.exists():
        print("measuring which test reaches which line; this takes minutes", flush=True)
        command = [sys.executable, __file__, "--measure", str(seconds)]
        subprocess.run(command, cwd=ROOT, env=os.environ | {"COVERAGE_FILE": str(data), "PYTHONPATH": str(ROOT)}, check=True)
    from coverage import CoverageData

    kept = CoverageData(str(data))
    kept.read()
    tests: dict[tuple[str, int], tuple[str, ...]] = {}
    for file in kept.measured_files():
        for line, contexts in kept.contexts_by_lineno(file).items():
            tests[name_of(Path(file)), line] = tuple({context.partition("|")[0] for context in contexts if context})
    return Reach(json.loads(seconds.read_text()), tests)


def files_of_tests() -> list[str]:
    return [str(path.relative_to(ROOT)) for path in sorted(ROOT.glob("tests/*/**/test_*.py")) if path.stem[5:] not in LEFT_OUT]


def measure(to: Path) -> None:
    stopwatch = Stopwatch()
    arguments = ["--cov=pinpress", "--cov-context=test", "--cov-report=", "-q", "-W", "default", "-p", "no:cacheprovider"]
    pytest.main([*arguments, "-n", "2", *files_of_tests()], plugins=[stopwatch])
    to.write_text(json.dumps({test: taken for test, taken in stopwatch.seconds.items() if test not in stopwatch.failed}))


# ------------------------------------------------------------------------------------------------------------------------------- judgement


class Chosen:
    """A plugin that keeps these tests alone, in this order, and notes which one failed."""

    def __init__(self, tests: list[str]) -> None:
        self.order = {test: number for number, test in enumerate(tests)}
        self.failed = ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        items[:] = sorted((item for item in items if item.nodeid in self.order), key=lambda item: self.order[item.nodeid])

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.failed = report.nodeid


def judge(tree: Path, tests: list[str], verdict: Any) -> None:
    """In a process of its own: the first of the tests that fails in this tree, "" if none does."""
    os.setsid()
    os.chdir(tree)
    sys.path[:0] = [str(tree), str(tree / "tests")]
    os.environ |= {"PYTHONPATH": str(tree)}
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    chosen = Chosen(tests)
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    options = ["-n", "0", "-x", "-q", "--tb=no", "-p", "no:cacheprovider", "-m", "", "-o", "faulthandler_timeout=0", "--rootdir", str(tree)]
    code = pytest.main([*options, *files], plugins=[chosen])
    verdict.send("" if code == 0 else chosen.failed or f"exit code {int(code)}")
    os._exit(0)


def copy_of_tree(number: int) -> Path:
    tree = KEPT / f"tree{number}"
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        elif (ROOT / name).exists():
            shutil.copy(ROOT / name, tree / name)
    return tree


def write(tree: Path, mutant: Mutant | None, module: str, number: int) -> None:
    """A module, mutated or as it was, with a time of its own: else Python might take the compiled one of the mutant before."""
    text = (ROOT / "pinpress" / f"{module}.py").read_bytes()
    if mutant is not None:
        text = text[: mutant.begin] + mutant.after.encode() + text[mutant.end :]
    path = tree / "pinpress" / f"{module}.py"
    path.write_bytes(text)
    os.utime(path, (1e9 + number, 1e9 + number))


def judged(work: list[tuple[Mutant, list[str], float]], until: float, processes: int) -> Iterator[tuple[Mutant, str]]:
    """Each mutant with the test that saw it, "" if none did. The first mutant's tests are run in a copy without a mutant before."""
    os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")  # NumPy reads them once
    import numpy  # noqa: F401 (loaded once, for all)
    import pinocchio  # noqa: F401
    import scipy.integrate
    import scipy.optimize  # noqa: F401

    context = multiprocessing.get_context("fork")
    waiting, free = list(enumerate(work)), [copy_of_tree(number) for number in range(processes if work else 0)]
    running: list[tuple[Any, Any, Path, Mutant, float]] = []
    if work:
        receives, sends = context.Pipe(duplex=False)
        process = context.Process(target=judge, args=(free[0], work[0][1], sends))
        process.start()
        sends.close()
        failed = receives.recv()
        process.join()
        if failed:  # all mutants would count as seen
            raise SystemExit(f"the tests fail without a mutant: {failed}")
    while waiting or running:
        while waiting and free and time.monotonic() < until:
            number, (mutant, tests, seconds) = waiting.pop(0)
            tree = free.pop()
            write(tree, mutant, mutant.module, 2 * number)
            receives, sends = context.Pipe(duplex=False)
            process = context.Process(target=judge, args=(tree, tests, sends))
            process.start()
            sends.close()
            running.append((process, receives, tree, mutant, time.monotonic() + HANGS + 4 * seconds))
        if not running:
            return
        time.sleep(0.02)
        for entry in list(running):
            process, receives, tree, mutant, latest = entry
            if process.is_alive() and not receives.poll() and time.monotonic() < latest:
                continue
            try:
                seen = receives.recv() if receives.poll() else "it hangs" if process.is_alive() else "it crashes"
            except EOFError:
                seen = "it crashes"
            if process.is_alive():
                os.killpg(process.pid, signal.SIGKILL) if seen == "it hangs" else None
            process.join()
            write(tree, None, mutant.module, 2 * len(work) + 1)
            running.remove(entry)
            free.append(tree)
            yield mutant, seen


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=100, help="mutants (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of their choice (default: %(default)s)")
    parser.add_argument("--modules", nargs="+", default=CORE, help="modules, e.g. engines/planar/* (default: the core)")
    parser.add_argument("--minutes", type=float, default=60.0, help="no new mutant afterwards (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=30.0, help="of tests a mutant gets, as they usually take (default: %(default)s)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        measure(arguments.measure)
        return
    until = time.monotonic() + 60 * arguments.minutes
    reach = measured()
    names = sorted(map(name_of, (ROOT / "pinpress").rglob("*.py")))
    modules = [name for name in names if any(fnmatch(name, wanted) for wanted in arguments.modules)]
    drawn = sorted((mutant for module in modules for mutant in mutants(module)), key=lambda mutant: mutant.place(arguments.seed))
    drawn = drawn[: arguments.count]
    texts = {module: (ROOT / "pinpress" / f"{module}.py").read_bytes() for module in modules}
    store = KEPT / "judgements.jsonl"
    known: dict[str, str] = dict(map(json.loads, store.read_text().splitlines())) if store.exists() else {}

    def key(mutant: Mutant, tests: list[str]) -> str:
        return hashlib.sha256(repr((mutant, texts[mutant.module], tests)).encode()).hexdigest()[:20]

    verdicts, work = {}, []
    for mutant in drawn:
        tests, total = [], 0.0
        for test in reach.of(mutant):
            total += reach.seconds[test]
            if total > arguments.seconds and tests:
                break
            tests.append(test)
        if not tests:
            verdicts[mutant] = ""
        elif key(mutant, tests) in known:
            verdicts[mutant] = known[key(mutant, tests)]
        else:
            work.append((mutant, tests, min(total, arguments.seconds)))
    asked = {mutant: tests for mutant, tests, _ in work}
    with store.open("a") as file:
        for mutant, seen in judged(work, until, arguments.processes):
            verdicts[mutant] = seen
            file.write(json.dumps([key(mutant, asked[mutant]), seen]) + "\n")
            file.flush()
    survivors = [mutant for mutant in drawn if verdicts.get(mutant) == ""]
    for mutant in sorted(survivors, key=lambda mutant: (mutant.module, mutant.line)):
        print(mutant, "" if reach.of(mutant) else "  (no test reaches it)")
    print(f"{len(survivors)} of {len(verdicts)} mutants survive: {100 * len(survivors) / max(len(verdicts), 1):.1f} %", end="")
    print(f"; {len(drawn) - len(verdicts)} more are drawn: the same command goes on" if len(drawn) > len(verdicts) else "")


if __name__ == "__main__":
    main()
