"""One-line mutants drawn by seeds: ``python tests/mutants/draw.py [COUNT [SEED ...]]``; prints the rates that tests kill.

As many modules of physics as mutants are drawn, kernels included, and in each one place: a number, an operator, a
comparison or an index is another. Each mutant is tried by the nearest tests: those that import the module, else those that
import what imports it, the examples in its docstrings, and the golden numbers of what its functions return and of answers
of commands; kernels as plain Python first, then with machine code of their own. For those that live, all tests are run once
in a copy that notes which of them evaluate which place, and each is tried by these, the quickest first; what is evaluated
at import and kernels, which note nothing once compiled, are left to the nearest. A test that fails is run again without the
mutant. So the rate is that of all tests but the list of constants (`NO_TEST`), which any change of one breaks.
Seconds to minutes each, and minutes for all tests; exit code 1 below `GOAL`, 2 where a test fails only at times.
`RECORD` keeps what became of each: an interrupted run goes on, and survivors are tried again; one that changes no answer
is marked there by hand, "equivalent: why".
"""

from __future__ import annotations

import ast
import json
import random
import re
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from subprocess import TimeoutExpired

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.mutants.run import ROOT, copied, passes, pytest

#: Share of the mutants that the tests are to kill.
GOAL = 0.95
RECORD = Path(__file__).parent / "drawn.json"
#: Seconds of tests after which a mutant has made them endless; where all kernels are compiled again; of kernels as Python.
PATIENCE, COMPILING, PLAIN = 900.0, 3600.0, 120.0
#: Environment variable of the folder of machine code, see `lowfi.jit`.
CODE = "NUMBA_CACHE_DIR"
#: Options for the tests that need no compiled kernels.
SHORT = ("-m", "not survey and not each_wing and not installs and not compiles and not slow")
#: Most files of nearest tests, those that name the module most often.
NEAREST = 6
#: How many of the quickest tests are run before the rest.
FIRST = 60
#: Numbers of all kinds of answers and of the 3D models, for every module; a test of what functions return, by groups.
GOLDEN = tuple(f"tests/golden/test_{name}.py" for name in ("answers", "drawn", "golden", "reference", "studies"))
INSIDE = "tests/golden/test_inside.py::test_nothing_moves_inside[{}]"
#: A list of constants: no evidence that a number is watched.
NO_TEST = "tests/golden/test_constants.py"
#: A call around a drawn place: its value, and a line of the file `REACHED` for each test that evaluates it, in any process.
NOTE = """
def _note(number, value, seen=set()):
    import os
    test = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" (")[0]
    if test and (number, test) not in seen:
        seen.add((number, test))
        with open(os.environ["REACHED"], "a", encoding="utf-8") as file:
            file.write(f"{number} {test}\\n")
    return value
__import__("builtins")._note = _note
"""
EXAMPLES = "tests/unit/commands/test_doctests.py::test_examples[{}]"
PHYSICS = ("lowfi", "hifi", "meshes", "compare/models", "compare/reference", "compare/gate", "compare/wings/rolling")
#: And single modules of folders that hold more than physics.
SINGLE = (
    *(f"compare/wings/members/{name}.py" for name in ("blocks", "ensemble", "members")),
    "compare/wings/mesh_study/table.py",
    *(f"compare/sections/{name}.py" for name in ("ladder", "grid_coverage")),
)
#: What is no physics there: files, processes, stores, text.
OTHERS = re.compile(
    r"__init__|jit|leftovers|libraries|private|packed|cache|workers|memory|canonical|frozen|mesh_files|kernel_types|store|sealing|jobs"
    r"|parallel|side_by_side|publish|loads_file|names|registry"
)
_SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=", "!=": "=="}
_OPERATOR = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"} | {
    ast.Lt: "<", ast.Gt: ">", ast.LtE: "<=", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="
}  # fmt: skip


def modules() -> list[Path]:
    """All modules of physics."""
    found = sorted((*(path for folder in PHYSICS for path in (ROOT / folder).rglob("*.py")), *(ROOT / x for x in SINGLE)))
    return [path for path in found if not OTHERS.search(path.stem)]


def mutants(text: str) -> Iterator[tuple[int, int, str, int, int]]:
    """Places of a source that may be another: offsets of its beginning and end, what stands there then, and the offsets of
    the whole expression."""
    lines, starts = text.splitlines(keepends=True), [0]
    for line in lines:
        starts.append(starts[-1] + len(line))

    def place(line: int, column: int) -> int:
        return starts[line - 1] + len(lines[line - 1].encode()[:column].decode())

    tree = ast.parse(text)
    skipped = {id(x) for node in ast.walk(tree) for kind in ("decorator_list", "annotation", "returns")
               for part in [getattr(node, kind, None)] for one in (part if isinstance(part, list) else [part]) if one
               for x in ast.walk(one)}  # fmt: skip
    for node in ast.walk(tree):
        if id(node) in skipped or not isinstance(node, ast.expr):
            continue
        whole = place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset)
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            value = node.value + 1 if isinstance(node.value, int) else 1.01 * node.value or 0.01
            yield *whole, repr(value), *whole
        elif isinstance(node, ast.BinOp | ast.Compare):
            left, right = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.left, node.comparators[0])
            sign = _OPERATOR.get(type(node.op if isinstance(node, ast.BinOp) else node.ops[0]))
            low = place(left.end_lineno, left.end_col_offset)
            between = text[low : place(right.lineno, right.col_offset)]
            if sign and between.strip(" ()\n") == sign:
                at = low + between.index(sign)
                yield at, at + len(sign), _SWAPPED[sign], *whole


@cache
def sources() -> dict[Path, str]:
    """Texts of all tests, and of all modules."""
    folders = ("tests", "lowfi", "hifi", "meshes", "compare", "reports")
    return {path: path.read_text(encoding="utf-8") for folder in folders for path in (ROOT / folder).rglob("*.py")}


def dotted(path: Path) -> str:
    """Name that a module is imported by."""
    name = path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".")
    return "rollbench." + re.sub(r"^compare\b", "comparison", name)


def importing(path: Path) -> list[Path]:
    """Files that import a module; of a kernel, those that import the package it belongs to or is solved by."""
    name = dotted(path)
    package, _, own = name.rpartition(".")
    wanted = rf"{re.escape(name)}\b|from {re.escape(package)} import [^\n]*\b{own}\b"
    if ".kernel" in name:
        wanted += rf"|from {re.escape(name.split('.kernel')[0])}\b"
    found = [other for other, text in sources().items() if other != path and re.search(wanted, text)]
    return sorted(found, key=lambda other: -len(re.findall(own, sources()[other])))


def nearest(path: Path) -> list[str]:
    """Tests of a module: files, and the examples in its docstrings."""
    found, examples = [path], [EXAMPLES.format(dotted(path))] if ">>> " in path.read_text(encoding="utf-8") else []
    for _ in range(3):
        users = list(dict.fromkeys(user for one in found for user in importing(one)))
        files = dict.fromkeys(user.relative_to(ROOT).as_posix() for user in users if user.name.startswith("test_"))
        tests = [file for file in files if "survey" not in file and file != NO_TEST and file not in GOLDEN]
        if tests:
            return [*tests[:NEAREST], *examples]
        found = users
    return []


def inside(path: Path) -> list[str]:
    """Golden tests of what functions of a module return, those that take least first."""
    record = json.loads((ROOT / "tests/golden/inside.json").read_text(encoding="utf-8"))
    begins = f"{path.relative_to(ROOT).as_posix()}:"
    groups = [name for name, kept in record.items() if any(key.startswith(begins) for key in kept)]
    return [INSIDE.format(name) for name in sorted(groups, key=lambda name: len(record[name]))]


@dataclass(frozen=True)
class Mutant:
    """A module, the offsets between which its text is another, what stands there then, and those of the expression."""

    path: Path
    low: int
    high: int
    new: str
    start: int
    end: int

    @property
    def name(self) -> str:
        """File, line, change, and the line: the same as long as the line stands where it did."""
        text = self.path.read_text(encoding="utf-8")
        line = text.count("\n", 0, self.low) + 1
        file, what = self.path.relative_to(ROOT).as_posix(), text.splitlines()[line - 1].strip()
        return f"{file}:{line}: {text[self.low : self.high]} to {self.new}: {what}"

    @property
    def is_kernel(self) -> bool:
        """Whether its module is compiled."""
        return "kernel" in self.path.parts

    def tried(self, tests: list[str], folder: Path, patience: float, **environment: str) -> bool:
        """Whether it survives tests in a copy that holds it; it is killed too where it makes them endless.

        Raises RuntimeError where they fail without it.
        """
        text = self.path.read_text(encoding="utf-8")
        copy = folder / self.path.relative_to(ROOT)
        copy.write_text(text[: self.low] + self.new + text[self.high :], encoding="utf-8")
        files = list(dict.fromkeys(test.partition("::")[0] for test in tests))  # names of tests that passed are none
        again, endless = ["--lf", *files], None
        try:
            if passes(["--cache-clear", *tests], folder, patience, **environment):
                return True
        except RuntimeError:  # not even imported
            again = ["--collect-only", *files]
        except TimeoutExpired:
            again, endless = tests, patience
        finally:
            copy.write_text(text, encoding="utf-8")
        without = {name: word for name, word in environment.items() if name != CODE}  # the user's has no mutant
        try:
            if not passes(again, folder, endless, **without):
                raise RuntimeError(f"{self.name}: its tests fail without it")
        except TimeoutExpired:  # nor do they end in time without it: no verdict
            return True
        return False

    def survives_nearest(self, folder: Path) -> bool:
        """Whether the nearest tests and golden numbers pass in a copy that holds it."""
        tests = nearest(self.path)
        plain = {"NUMBA_DISABLE_JIT": "1"} if self.is_kernel else {}
        first = [*SHORT, *tests] if self.is_kernel else tests
        if not self.tried(first, folder, PLAIN if self.is_kernel else PATIENCE, **plain):
            return False
        if not all(self.tried([test], folder, PATIENCE) for test in inside(self.path)):
            return False
        if not self.is_kernel:
            return self.tried(list(GOLDEN), folder, PATIENCE)
        with tempfile.TemporaryDirectory() as code:
            return self.tried([*tests, *GOLDEN], folder, COMPILING, **{CODE: code})

    def survives(self, tests: list[str], folder: Path) -> bool:
        """Whether tests that evaluate its place, the quickest first, pass in a copy that holds it."""
        return all(self.tried(some, folder, PATIENCE) for some in (tests[:FIRST], tests[FIRST:]) if some)


def draw(seed: int, count: int) -> Iterator[Mutant]:
    """Mutants of a seed, each of another module; a change of one module leaves those of the others."""
    dice = {path: random.Random(f"{seed} {dotted(path)}") for path in modules()}
    for path in sorted(dice, key=lambda path: dice[path].random())[:count]:
        places = list(mutants(path.read_text(encoding="utf-8")))
        if places and nearest(path):
            yield Mutant(path, *dice[path].choice(places))


def plain(test: str) -> str:
    """Name of a test without the group that several workers add to it."""
    return re.sub(r"@[^\]]*$", "", test)


def reaching(drawn: Sequence[Mutant], folder: Path, *options: str) -> dict[Mutant, list[str]]:
    """Tests that pass and evaluate the place of each, the quickest first, found by one run of all tests in a copy."""
    noted, init = folder / "reached.txt", folder / ".import/rollbench/__init__.py"
    future = "from __future__ import annotations\n"
    texts = {init: init.read_text(encoding="utf-8").replace(future, future + NOTE)}
    for path in {mutant.path for mutant in drawn if not mutant.is_kernel}:
        text, added = path.read_text(encoding="utf-8"), []
        for number, mutant in enumerate(drawn):
            if mutant.path == path:
                added += [(mutant.start, -mutant.end, f"_note({number}, "), (mutant.end, 0, ")")]
        for at, _, word in sorted(added, reverse=True):
            text = text[:at] + word + text[at:]
        texts[folder / path.relative_to(ROOT)] = text
    before = {path: path.read_text(encoding="utf-8") for path in texts}
    try:
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8")
        left_out = (word for path in ("tests/mutants", NO_TEST) for word in ("--ignore", path))
        all_tests = ("tests", *left_out, "--durations", "0", "--durations-min", "0", *options)
        said = pytest(all_tests, folder, REACHED=str(noted)).stdout
    finally:
        for path, text in before.items():
            path.write_text(text, encoding="utf-8")
    failed = {plain(test) for test in re.findall(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", said, re.MULTILINE)}
    took: dict[str, float] = {}
    for seconds, test in re.findall(r"^([\d.]+)s \w+ +(.*)$", said, re.MULTILINE):
        took[plain(test)] = took.get(plain(test), 0.0) + float(seconds)
    found: dict[Mutant, list[str]] = {mutant: [] for mutant in drawn}
    for line in noted.read_text(encoding="utf-8").splitlines():
        number, _, test = line.partition(" ")
        found[drawn[int(number)]].append(plain(test))
    return {mutant: sorted(set(tests) - failed, key=lambda test: took.get(test, 0.0)) for mutant, tests in found.items()}


def kept(seed: int) -> dict[str, str]:
    """What became of the mutants of a seed: name -> "killed", "killed by a later test", "survives" or "equivalent: why"."""
    return json.loads(RECORD.read_text(encoding="utf-8")).get(str(seed), {}) if RECORD.exists() else {}


def keep(seed: int, found: dict[str, str]) -> None:
    """Write what became of a seed's mutants."""
    every = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    RECORD.write_text(json.dumps(every | {str(seed): found}, indent=1) + "\n", encoding="utf-8")


def rate(found: Iterable[str]) -> tuple[float, float]:
    """Shares of mutants that are not equivalent: killed by the tests that there were, and by those of today."""
    real = [word for word in found if not word.startswith("equivalent")]
    return real.count("killed") / len(real), sum(word.startswith("killed") for word in real) / len(real)


def main(count: int, seeds: Sequence[int]) -> int:
    """Try those of which nothing is kept, and survivors again; print and keep each, and the rates of each seed."""
    drawn = {mutant: seed for seed in seeds for mutant in draw(seed, count)}
    found = {seed: kept(seed) for seed in seeds}

    def note(mutant: Mutant, lives: bool) -> None:
        known = found[drawn[mutant]]
        killed = "killed by a later test" if known.get(mutant.name) == "survives" else "killed"
        known[mutant.name] = "survives" if lives else killed
        keep(drawn[mutant], known)
        print(f"{known[mutant.name]}: {mutant.name}", flush=True)

    todo = [mutant for mutant, seed in drawn.items() if found[seed].get(mutant.name, "survives") == "survives"]
    with tempfile.TemporaryDirectory() as temporary:
        folder, alive = copied(Path(temporary)), []
        try:
            for mutant in todo:
                if mutant.survives_nearest(folder):
                    alive.append(mutant)
                else:
                    note(mutant, lives=False)
            tests = reaching(alive, folder) if alive else {}
            for mutant in alive:
                note(mutant, mutant.survives(tests[mutant], folder))
        except RuntimeError as error:
            print(error, file=sys.stderr)
            return 2
    reached = True
    for seed, own in found.items():
        first, now = rate(own.values())
        print(f"seed {seed}: {len(own)} mutants: {100.0 * first:.0f} % killed when drawn, {100.0 * now:.0f} % today")
        reached &= now >= GOAL
    return 0 if reached else 1


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]] or [30]
    sys.exit(main(given[0], given[1:] or [1]))
