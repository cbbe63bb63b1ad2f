"""What each function of physics returns on the way to golden answers: a guard against change of numbers that none shows.

The functions of the low-order models, the 3D reference and comparisons are watched in a process of its own, with empty
caches and kernels as plain Python. One number is kept for each: a sum over its first calls, of all that it returns and of
what it was given, as it leaves that. What round-off moves is left out, found by moduli that differ by `SHIFT`.
A function that is gone is no fault. Whoever changes numbers on purpose writes them again with
``python -m tests.golden.test_inside [GROUP ...]`` and says why in the commit.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import is_dataclass
from importlib.metadata import version
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest
from tests.copies import ROOT
from tests.golden.means import leaves
from tests.golden.otherwise import PATIENCE, WAYS, Call, Late
from tests.golden.test_answers import kept as answered
from tests.golden.test_drawn import MAKERS
from tests.golden.test_reference import set_up
from tests.golden.test_studies import choices, exact, faces, grids, mesh_studies, references, uncertainties, verdicts
from tests.mutants.draw import modules

RECORD = Path(__file__).parent / "inside.json"
#: Share by which the moduli differ for the choice of what is kept; by how much that may move; tolerance of the tests.
SHIFT, STEADY, TOLERANCE = 1e-11, 1e-8, 1e-7
#: Calls of a function that are watched in one item and in all, and numbers of an array that are looked at.
IN_ITEM, IN_ALL, MOST = 3, 60, 20_000
#: Calls of a function with other numbers, what is said of it then; seconds of the longest, and when it is ended at once.
IN_ALL_OTHERWISE, OTHERWISE, LONG, LATE = 12, " with other numbers", 0.015, 0.5
#: Files whose functions are not called with other numbers: meshes are made in other processes, or by what does not end.
MESHED = re.compile(
    r"meshes/(?!parts|errors|helix|surface|section|partition|roots|one_arc|near)|gmsh|side_by_side|threads|meshing/"
)
ENDED = ("late", "MemoryError", "RecursionError")
#: How many functions may be gone before the record has to be made again.
GONE = 0.1
#: One processor for all machines: what linear algebra, numpy and the C library's functions choose by it is fixed.
ONE_PROCESSOR = {
    "OPENBLAS_CORETYPE": "Nehalem",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-FMA4",
}
#: Old memory is no zeros, two threads, this machine's own processor.
OTHER_MACHINE = {
    "MALLOC_PERTURB_": "99",
    "OMP_NUM_THREADS": "2",
    "OPENBLAS_NUM_THREADS": "2",
    "OPENBLAS_CORETYPE": "Haswell",
    "NPY_DISABLE_CPU_FEATURES": "",
    "GLIBC_TUNABLES": "",
}
#: What machines, versions and round-off decide.
LEFT_OUT = re.compile(r"second|memory|MB|version|residual|iteration|balance|round_off|imbalance|digest|\bkey\b|path|folder")
#: What round-off decides on one machine and not on another, and the order of fronts, which another build of metis changes.
DECIDED = re.compile(
    r"equilibrium|border|evaluations|ball$|worst|engine|slack|upwind|remainder|rounds|goal|change$|_error$"
)
NO_WORDS = re.compile(r"[0-9a-f]{12}|/")
#: Where a key of a mapping says which object it is.
ADDRESS = re.compile(r" at 0x[0-9a-f]+")
#: Functions whose arrays hold nothing yet.
NOT_FILLED = re.compile(r"room|__hash__")
#: Numbers of items of each kind of drawn scenes, see `test_drawn`: those that plain Python solves in few seconds.
DRAWN: dict[str, dict[str, Iterable[int]]] = {
    "statics": {
        "extreme": range(24),
        "extreme, other models": range(28),
        "usual": range(1, 8),
        "usual, refined": range(1),
        "cases": range(1),
        "members": range(2),
        "pressed": range(20),
    },
    "axes": {
        "axes": (0, 2, 3, *range(7, 11), *range(12, 16), 17, 19, 20),
        "axes, refined": range(6),
        "axes, commands": range(3),
    },
    "friction": {
        "friction of extremes": (0, 1, 2, *range(4, 16)),
        "friction of axes": (1, 2, 3),
        "friction of kinds": range(31),
    },
    "reference": {"parts": range(12), "shafts": range(30), "rolled": range(10), "judged": (2, 5, 6, 11, 16)},
}
ANSWERS: dict[str, tuple[str, ...]] = {
    "statics": ("solve bearing-9-preload", "solve liu-drawn --model mei", "solve lin-random --members 4 --model lin"),
    "axes": ("solve double-nut --model lin", "solve smith-axis-taper --model lin"),
    "friction": ("friction lin-chain-10",),
    "reference": ("compare lin-pair-a", "mesh-study lin-case2 --levels 4", "check lin-case2 --no-compute"),
    "wings": (
        *(f"audit --only smith-{table}" for table in ("2.1", "2.2", "3", "4.1", "4.2", "4.3", "5")),
        *(f"audit --only external-{table}" for table in ("contact", "equivalent", "harris", "nsk")),
        *(
            f"audit --only {table}"
            for table in ("kalker-E3", "liu-4.1", "liu-4.2", "lin-4.2", "lin-G", "lin-3.2", "lin-3.3")
        ),
        *(f"audit --only {table}" for table in ("lin-3.5", "lin-3.7")),
        "friction lin-bearing-pairs",
        "friction lin-rotary-3",
        "friction lin-pair-worst",
        "mesh-study lin-screw-pair-a",
        "compare lin-screw-pair-a",
        "compare lin-case1",
        "compare two-balls",
        "check lin-case3-offset --no-compute",
        "solve lin-case3-tolerances --members 20 --model lin",
        "solve lin-random --members 4",
        "solve double-nut",
        "check double-nut --no-compute",
    ),
}
#: And tests on whose way functions are watched that no answer above needs.
TESTS: dict[str, tuple[str, ...]] = {
    "bodies": (
        "convergence/test_elasticity_orders.py",
        "convergence/test_hertz_convergence.py",
        "convergence/test_rolling_contacts.py",
        "unit/compliance/test_grooved_cell.py",
        "unit/hifi/test_cut.py",
        "unit/hifi/test_enlarged_patches.py",
        "unit/hifi/test_fields.py",
        "unit/hifi/test_forms.py",
        "unit/hifi/test_mounting.py",
        "unit/hifi/test_patch.py",
        "unit/hifi/test_reference_rounds.py",
        "unit/hifi/test_rolling_bodies.py",
        "unit/hifi/test_rolling_time.py",
        "unit/meshes/test_flanged_nut.py",
        "unit/meshes/test_groove_end.py",
        "unit/meshes/test_half_bodies.py",
        "unit/meshes/test_sockets.py",
    ),
    "wings": (
        "unit/axis/test_arrangements.py",
        "unit/bearings/test_angular_contact.py",
        "unit/bearings/test_tapered_roller.py",
        "unit/friction/test_jammed_chain.py",
        "unit/friction/test_run_steps.py",
        "unit/friction/test_screw_coupled.py::test_a_contact_past_the_apex_keeps_its_sign",
        "unit/friction/test_screw_coupled.py::test_mixed_rounds_settle_where_plain_ones_run_away_and_keep_their_history",
        "unit/friction/test_screw_coupled.py::test_one_system_gives_what_rounds_give",
        "unit/friction/test_screw_kernels.py",
        "unit/friction/test_screw_pair.py::test_chain_jacobian_against_differences",
        "unit/friction/test_screw_pair.py::test_frictionless_chain_is_a_constrained_least_dissipation",
        "unit/friction/test_screw_pair.py::test_pair_in_equilibrium",
        "unit/friction/test_screw_pair.py::test_two_point_chain_with_unloaded_balls_converges",
        "unit/friction/test_screw_run.py::test_groups",
        "unit/friction/test_screw_run.py::test_recirculation_folds_balls_into_the_nut",
        "unit/friction/test_screw_run.py::test_without_deviation_nothing_touches",
        "unit/friction/test_source_screw.py",
        "unit/friction/test_travelling.py",
        "unit/friction/test_whole_feedback.py::test_feedback_keeps_the_load_of_contacts_past_the_apex",
        "unit/friction/test_whole_feedback.py::test_feedback_mirrors_reverses_and_leaves_rings_alone",
        "unit/friction/test_whole_feedback.py::test_feedback_on_a_ball_is_that_of_the_coupled_solver",
        "unit/friction/test_whole_feedback.py::test_second_states_are_those_that_differ_and_settle",
        "unit/friction/test_whole_run.py::test_a_tiny_run_is_the_state_at_the_instant",
        "unit/friction/test_whole_run.py::test_balls_leave_and_enter_and_bear_load_on_the_loaded_arc_alone",
        "unit/friction/test_whole_run.py::test_balls_of_unlike_sizes_touch_where_their_radii_meet",
        "unit/friction/test_whole_run.py::test_friction_that_moves_balls_is_that_of_the_instant",
        "unit/friction/test_whole_run.py::test_left_hand_is_the_mirrored_right_hand",
        "unit/models/test_changed_scenes.py",
        "unit/models/test_displacement_place.py",
        "unit/models/test_total_uncertainty.py",
        "unit/models/test_u_val.py",
        "unit/random_errors/test_chain.py",
        "unit/random_errors/test_elimination.py",
        "unit/random_errors/test_ensemble.py::test_every_member_as_solved_alone",
        "unit/random_errors/test_ensemble.py::test_same_numbers_whatever_the_chunk",
        "unit/reference/test_reference_jobs.py",
    ),
}
STUDIES = (references, grids, mesh_studies, choices, uncertainties, faces, exact, verdicts)


class Watch:
    """Folds what functions return into numbers: of each function and each name below its answers a sum.

    slow: functions that are not called with other numbers, whose calls take more than `LONG`; found where it is None.
    """

    def __init__(self, slow: Iterable[str] | None) -> None:
        self._file = {str(path): path.relative_to(ROOT).as_posix() for path in modules()}
        self._code: dict[CodeType, str] = {}
        self._in_item: Counter[CodeType] = Counter()
        self._calls: Counter[str] = Counter()
        self._begins: dict[CodeType, int] = {}
        self._search = slow is None
        self.slow = set(slow or ())
        self.sums: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))

    def next_item(self) -> None:
        """Watch first calls again."""
        self._in_item.clear()

    def __call__(self, frame: FrameType, event: str, value: Any) -> None:
        """As `sys.setprofile` wants it."""
        if event not in ("call", "return"):
            return
        code = frame.f_code
        name = self._code.get(code)
        if name is None:
            file = self._file.get(path_of(os.path.realpath(code.co_filename)), "")
            watched = file and code.co_flags & CO_OPTIMIZED and not re.search(rf"^<|{NOT_FILLED.pattern}", code.co_name)
            name = self._code[code] = f"{file}:{code.co_qualname}" if watched else ""
        if not name or self._in_item[code] >= IN_ITEM or self._calls[name] >= IN_ALL:
            return
        sys.setprofile(None)
        try:
            if event == "call":
                self._otherwise(name, frame)
            else:
                self._in_item[code] += 1
                self._calls[name] += 1
                count = code.co_argcount + code.co_kwonlyargcount
                given = {key: frame.f_locals[key] for key in code.co_varnames[:count] if key in frame.f_locals}
                self._fold(name, {"": value, "given": given}, self._calls[name])
        finally:
            sys.setprofile(self)

    def _otherwise(self, name: str, frame: FrameType) -> None:
        """Call a function that is about to begin with other numbers."""
        code, also = frame.f_code, f"{name}{OTHERWISE}"
        begins = self._begins.setdefault(code, frame.f_lasti) == frame.f_lasti  # no generator that goes on
        left_out = MESHED.search(name) or name in self.slow
        if not begins or left_out or self._in_item[code] or self._calls[also] >= IN_ALL_OTHERWISE:
            return
        call = Call(frame)
        for way in range(WAYS):
            self._calls[also] += 1
            started = time.process_time()
            try:
                answer = call.again(code, way, LATE if self._search else PATIENCE)
            except Late:
                answer = {"": "late"}
            self._fold(also, answer, self._calls[also])
            ended = isinstance(answer[""], str) and answer[""] in ENDED
            if self._search and (ended or time.process_time() - started > LONG):
                self.slow.add(name)
                return

    def _fold(self, name: str, answer: dict[str, Any], number: int) -> None:
        weight = 1.3 + np.cos(number)
        given = answer.get("given", {}).items()
        answer = {"": held(answer[""]), "given": {key: held(value) for key, value in given if may_change(value)}}
        for place, share in contributions(answer):
            self.sums[name][place] += weight * share


def path_of(file: str) -> str:
    """Path of a source; of a copy that kernels are compiled from, see `lowfi.jit`, that of its source."""
    package, name = os.path.split(file)
    words = os.path.basename(package).split(".")
    return str(ROOT.joinpath(*words[1:], name)) if words[0] == "rollbench" and len(words) > 1 else file


def may_change(value: Any) -> bool:
    """Whether a call may leave other numbers in an argument."""
    return not is_dataclass(value) or isinstance(value, type) or not type(value).__dataclass_params__.frozen


def held(value: Any) -> Any:
    """What an object holds; of others, the same."""
    ours = type(value).__module__.startswith("rollbench.") and not is_dataclass(value)
    return vars(value) if ours and hasattr(value, "__dict__") else value


def contributions(value: Any) -> Iterator[tuple[str, float]]:
    """Names below a value, and what each leaf adds: the share and the place of its numbers' signs and sizes."""
    for place, (name, leaf) in enumerate(leaves_and_words(value)):
        name = ADDRESS.sub("", name)
        if isinstance(leaf, str):
            yield name, zlib.crc32(leaf.encode()) / 2.0**32
            continue
        x = np.asarray(leaf, dtype=float).ravel()
        x = x[:: 1 + x.size // MOST]
        x = x[np.isfinite(x)]
        size = float(np.abs(x).sum())
        yield name, 0.01 * x.size
        if size > 0.0:
            shape = float((x * np.cos(1.0 + np.arange(x.size))).sum()) / size
            yield name, (1.0 + 0.3 * np.cos(place)) * (shape + np.log10(size))


def leaves_and_words(value: Any) -> Iterator[tuple[str, Any]]:
    """Leaves of a value: numbers, and words that name no file or digest."""
    yield from leaves(value, LEFT_OUT.search)
    below = [("", value)]
    while below:
        name, one = below.pop()
        if isinstance(one, str) and len(one) < 400 and not NO_WORDS.search(one):
            yield f"{name} in words", one
        elif isinstance(one, dict):
            below += [(f"{name}.{key}", each) for key, each in one.items() if not LEFT_OUT.search(str(key))]
        elif isinstance(one, list | tuple):
            below += [(name, each) for each in one[:50]]


def items(group: str, shift: float) -> Iterator[Callable[[], Any]]:
    """What is watched."""
    for kind, numbers in DRAWN.get(group, {}).items():
        for number in numbers:
            yield lambda kind=kind, number=number: MAKERS[kind][0](number, shift)
    for command in ANSWERS.get(group, ()):
        yield lambda command=command: answered(command)
    for name in TESTS.get(group, ()):
        yield lambda name=name: run_tests(f"{ROOT}/tests/{name}")
    yield from {"reference": STUDIES, "3D": (set_up,)}.get(group, ())


def run_tests(name: str) -> None:
    """Run tests, of a file or one, that need no compiled kernels, in this process."""
    plain = "-n0 --timeout=0 -p no:cacheprovider --assert=plain -o filterwarnings="
    marks = "not compiles and not survey"
    with contextlib.redirect_stdout(sys.stderr):
        ended = pytest.main([*plain.split(), "-m", marks, name])
    # a call with other numbers may be one too many for a test that counts them
    assert ended in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED), name


def watch(group: str, shift: float, slow: list[str] | None) -> tuple[dict[str, dict[str, float]], list[str]]:
    """Sums of a group's functions, in this process, and those that are slow."""
    watch = Watch(slow)
    for item in items(group, shift):
        watch.next_item()
        sys.setprofile(watch)
        try:
            item()
        finally:
            sys.setprofile(None)
    return watch.sums, sorted(watch.slow)


def watched(
    group: str, shift: float, slow: list[str] | None, **environment: str
) -> tuple[dict[str, dict[str, float]], list[str]]:
    """The same in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        alone = {
            "ROLLBENCH_CACHE": folder,
            "NUMBA_DISABLE_JIT": "1",
            "PYTHONHASHSEED": "0",
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONPATH": str(ROOT / ".import"),
            **ONE_PROCESSOR,
        }
        out = Path(folder) / "sums.json"
        out.write_text(json.dumps(slow), encoding="utf-8")
        command = [sys.executable, "-m", "tests.golden.test_inside", "--watch", group, str(shift), str(out)]
        done = subprocess.run(
            command, cwd=ROOT, env=os.environ | alone | environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr[-3000:]
        return json.loads(out.read_text(encoding="utf-8"))


def written(group: str) -> dict[str, Any]:
    """The record of a group: each function's number, and the names that round-off, threads or old memory moves."""
    _, slow = watched(group, 0.0, None)
    again, _ = watched(group, 0.0, slow, **OTHER_MACHINE)
    (first, _), (other, _) = watched(group, 0.0, slow), watched(group, SHIFT, slow)
    record: dict[str, Any] = {"slow": slow}
    for name, sums in sorted(first.items()):
        moving = sorted(
            place
            for place in sums.keys() | again.get(name, {}).keys() | other.get(name, {}).keys()
            if not DECIDED.search(place)
            and (
                len({place in each.get(name, {}) for each in (first, again, other)}) > 1
                or max(abs(sums[place] - each[name][place]) for each in (again, other)) > STEADY
            )
        )
        if steady(sums, moving):
            record[name] = [total(sums, moving), moving] if moving else [total(sums, moving)]
    return record


def total(sums: dict[str, float], moving: list[str]) -> float:
    """What is kept of a function."""
    names = steady(sums, moving)
    return float(f"{sum(sums[place] * (1.0 + 0.1 * np.sin(k)) for k, place in enumerate(names)):.9g}")


def steady(sums: dict[str, float], moving: list[str]) -> list[str]:
    """Names of a function's sums that neither round-off nor chance decides."""
    return sorted(place for place in sums.keys() - set(moving) if not DECIDED.search(place))


GROUPS = (*DRAWN, "3D", *TESTS)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("group", GROUPS)
def test_nothing_moves_inside(group):
    record = json.loads(RECORD.read_text(encoding="utf-8"))
    if group in ("3D", "bodies") and record["gmsh"] != version("gmsh"):
        pytest.skip("the record's meshes are another gmsh's")
    kept = record[group]
    sums, _ = watched(group, 0.0, kept.pop("slow"))
    assert len(kept.keys() - sums.keys()) <= GONE * len(kept)
    moved = {
        name: (total(sums[name], moving[0] if moving else []), number)
        for name, (number, *moving) in kept.items()
        if name in sums
    }
    assert {name: pair for name, pair in moved.items() if abs(pair[0] - pair[1]) > TOLERANCE * max(1.0, abs(pair[1]))} == {}


if __name__ == "__main__":
    if sys.argv[1:2] == ["--watch"]:
        group, shift, out = sys.argv[2], float(sys.argv[3]), Path(sys.argv[4])
        out.write_text(json.dumps(watch(group, shift, json.loads(out.read_text(encoding="utf-8")))), encoding="utf-8")
        sys.exit()
    old = json.loads(RECORD.read_text(encoding="utf-8")) if sys.argv[1:] else {}
    record = {"gmsh": version("gmsh")} | {g: written(g) if g in (sys.argv[1:] or GROUPS) else old[g] for g in GROUPS}
    text = json.dumps(record, separators=(",", ":"))
    RECORD.write_text(re.sub(r',("[^"]+\.py:)', r",\n\1", text) + "\n", encoding="utf-8")
