"""One-line mutants drawn by a seed: ``python tests/mutants/draw.py [SEED [COUNT]]``; prints the rate that the tests kill.

As many modules of physics as mutants are drawn, kernels included, and in each one place: a number, an operator, a
comparison or an index is another. The nearest tests are those that import the module, else those that import what imports
it, the examples in its docstrings, and the golden answers of commands; the one that fails is run again without the mutant.
Before the first mutant the golden answers are tried, which also makes the machine code that all use; mutants of kernels
have machine code of their own. Seconds to minutes each; exit code 1 below `GOAL`, 2 where a test fails without a mutant.
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
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from subprocess import TimeoutExpired

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.mutants.run import ROOT, copied, passes

#: Share of the mutants that the tests are to kill.
GOAL = 0.95
RECORD = Path(__file__).parent / "drawn.json"
#: Seconds of tests after which a mutant has made them endless; where all kernels are compiled anew; of kernels as Python.
PATIENCE, COMPILING, PLAIN = 900.0, 3600.0, 120.0
#: Environment variable of the folder of machine code, see `lowfi.jit`.
CODE = "NUMBA_CACHE_DIR"
#: Options for the tests that need no compiled kernels.
SHORT = ("-m", "not survey and not wings and not installs and not compiles and not slow")
#: Most files of nearest tests, those that name the module most often.
NEAREST = 6
#: Numbers of all kinds of answers and of the 3D models, for every module.
GOLDEN = "tests/golden"
EXAMPLES = "tests/unit/commands/test_doctests.py::test_examples[{}]"
PHYSICS = ("lowfi", "hifi", "meshes", "compare/models", "compare/reference", "compare/gate", "compare/wings/rolling")
#: What is no physics there: files, processes, stores, text.
OTHERS = re.compile(
    r"__init__|jit|leftovers|libraries|private|packed|cache|workers|memory|canonical|frozen|bridge|records|store|sealing|jobs"
    r"|parallel|side_by_side|publish|loads_file|names|registry"
)
_SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=", "!=": "=="}
_OPERATOR = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"} | {
    ast.Lt: "<", ast.Gt: ">", ast.LtE: "<=", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="
}  # fmt: skip


def modules() -> list[Path]:
    """All modules of physics."""
    found = sorted(path for folder in PHYSICS for path in (ROOT / folder).rglob("*.py"))
    return [path for path in found if not OTHERS.search(path.stem)]


def mutants(text: str) -> Iterator[tuple[int, int, str]]:
    """Places of a source that may be another: offsets of its beginning and end, and what stands there then."""
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
        if id(node) in skipped:
            continue
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            value = node.value + 1 if isinstance(node.value, int) else 1.01 * node.value or 0.01
            yield place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset), repr(value)
        elif isinstance(node, ast.BinOp | ast.Compare):
            left, right = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.left, node.comparators[0])
            sign = _OPERATOR.get(type(node.op if isinstance(node, ast.BinOp) else node.ops[0]))
            low = place(left.end_lineno, left.end_col_offset)
            between = text[low : place(right.lineno, right.col_offset)]
            if sign and between.strip(" ()\n") == sign:
                at = low + between.index(sign)
                yield at, at + len(sign), _SWAPPED[sign]


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
        tests = [user for user in users if user.name.startswith("test_") and "survey" not in user.name]
        if tests:
            return [*(test.relative_to(ROOT).as_posix() for test in tests[:NEAREST]), *examples, GOLDEN]
        found = users
    return []


@dataclass(frozen=True)
class Mutant:
    """A module, the offsets between which its text is another, and what stands there then."""

    path: Path
    low: int
    high: int
    new: str

    @property
    def name(self) -> str:
        """File, line, change, and the line: the same as long as the line stands where it did."""
        text = self.path.read_text(encoding="utf-8")
        line = text.count("\n", 0, self.low) + 1
        file, what = self.path.relative_to(ROOT).as_posix(), text.splitlines()[line - 1].strip()
        return f"{file}:{line}: {text[self.low : self.high]} to {self.new}: {what}"

    def tried(self, tests: list[str], folder: Path, patience: float, **environment: str) -> str:
        """What tests do in a copy that holds it: "pass", "fail", "run on", or "fail without it"."""
        text = self.path.read_text(encoding="utf-8")
        copy = folder / self.path.relative_to(ROOT)
        copy.write_text(text[: self.low] + self.new + text[self.high :], encoding="utf-8")
        try:
            if passes(tests, folder, patience, **environment):
                return "pass"
        except RuntimeError:  # not even imported
            return "fail"
        except TimeoutExpired:
            return "run on"
        finally:
            copy.write_text(text, encoding="utf-8")
        again = {name: word for name, word in environment.items() if name != CODE}  # the user's has no mutant
        return "fail" if passes(["--lf", *tests], folder, **again) else "fail without it"

    def survives(self, folder: Path) -> bool:
        """Whether the nearest tests pass in a copy that holds it; a kernel's short ones are tried as plain Python first,
        and its machine code is kept apart. Raises RuntimeError where tests fail without it."""
        tests = nearest(self.path)
        if "kernel" not in self.path.parts:
            found = self.tried(tests, folder, PATIENCE)
        elif self.tried([*SHORT, *tests[:-1]], folder, PLAIN, NUMBA_DISABLE_JIT="1") == "fail":
            return False
        else:
            with tempfile.TemporaryDirectory() as code:
                found = self.tried(tests, folder, COMPILING, **{CODE: code})
        if found == "fail without it":
            raise RuntimeError(f"{self.name}: its tests {found}")
        return found == "pass"


def draw(seed: int, count: int) -> Iterator[Mutant]:
    """Mutants of a seed, each of another module."""
    dice = random.Random(seed)
    for path in dice.sample(modules(), count):
        places = list(mutants(path.read_text(encoding="utf-8")))
        if places and nearest(path):
            yield Mutant(path, *dice.choice(places))


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


def main(seed: int, count: int) -> int:
    """Try those of which nothing is kept, and survivors again; print and keep each, and the rates."""
    drawn, before = list(draw(seed, count)), kept(seed)
    found = {mutant.name: before.get(mutant.name, "") for mutant in drawn}
    with tempfile.TemporaryDirectory() as temporary:
        folder = copied(Path(temporary))
        if not passes([GOLDEN], folder):
            print(f"{GOLDEN} fails without a mutant", file=sys.stderr)
            return 2
        for mutant in drawn:
            if found[mutant.name] in ("", "survives"):
                try:
                    lives = mutant.survives(folder)
                except RuntimeError as error:
                    print(error, file=sys.stderr)
                    return 2
                killed = "killed by a later test" if found[mutant.name] else "killed"
                found[mutant.name] = "survives" if lives else killed
                keep(seed, {name: word for name, word in found.items() if word})
            print(f"{found[mutant.name]}: {mutant.name}", flush=True)
    first, now = rate(found.values())
    said = f"{100.0 * first:.0f} % killed when drawn, {100.0 * now:.0f} % today"
    print(f"seed {seed}: {len(drawn)} mutants in as many of {len(modules())} modules: {said}")
    return 0 if now >= GOAL else 1


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:3]]
    sys.exit(main(*given, *(1, 30)[len(given) :]))
