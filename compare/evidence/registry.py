"""Which function computes the evidence of which printed table, from which scenes, and which test asserts it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase

from rollbench.comparison.evidence.record import Evidence
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import KINDS, Printed, load_table, tables
from rollbench.comparison.sources.external.evidence import bearings, contacts, screws
from rollbench.comparison.sources.kalker.evidence import table_e3
from rollbench.comparison.sources.lin.evidence import rotary_linear, screw, steering_4_2
from rollbench.comparison.sources.lin.evidence.errors_2_4_2 import section_2_4_2
from rollbench.comparison.sources.lin.evidence.errors_4_3_2 import section_4_3_2
from rollbench.comparison.sources.lin.evidence.hertz_b1 import table_b_1
from rollbench.comparison.sources.lin.evidence.loads_2_4_1 import section_2_4_1
from rollbench.comparison.sources.liu.evidence import drawn as liu_drawn
from rollbench.comparison.sources.liu.evidence import given as liu_given
from rollbench.comparison.sources.liu.evidence import single_error as liu_single
from rollbench.comparison.sources.smith.evidence import ball as smith_ball
from rollbench.comparison.sources.smith.evidence import screw as smith_axis
from rollbench.comparison.sources.smith.evidence import taper as smith_taper
from rollbench.comparison.sources.smith.evidence import trials as smith_trials

CHAPTER_2 = "tests/literature/test_lin_chapter2.py"
ROTARY = "tests/literature/test_lin_chapter3_rotary.py"
LINEAR = "tests/literature/test_lin_chapter3_linear.py"
SCREW = "tests/literature/test_lin_chapter3_screw.py"
CHAPTER_4 = "tests/literature/test_lin_chapter4_friction.py"
AXES = "tests/literature/test_lin_chapter4_axes.py"
SMITH = "tests/literature/test_smith.py"
LIU = "tests/literature/test_liu.py"
KALKER = "tests/literature/test_kalker.py"
EXTERNAL = "tests/literature/test_external.py"


#: Scenes, or why there is none; empty where the kind of the entry says so (an input, arithmetic on printed numbers).
Behind = tuple[str, ...] | str


@dataclass(frozen=True)
class Computation:
    """One printed table: the function that computes its evidence, the test file that asserts every entry of it, and what is
    behind its entries, by pattern of the key (the first that fits counts)."""

    table: str
    compute: Callable[[Study], tuple[Evidence, ...]]
    test: str
    behind: tuple[tuple[str, Behind], ...]

    @property
    def function(self) -> str:
        """``module:function`` of the computation."""
        return f"{self.compute.__module__}:{self.compute.__qualname__}"

    @property
    def every_scene(self) -> tuple[str, ...]:
        """Scenes behind any entry, each once."""
        return tuple(dict.fromkeys(name for _, names in self.behind if not isinstance(names, str) for name in names))

    def origin(self, row: Printed) -> tuple[tuple[str, ...], str]:
        """Scenes behind an entry, and where there are none, why."""
        found = next((behind for pattern, behind in self.behind if fnmatchcase(row.key, pattern)), "")
        if not isinstance(found, str) and found:
            return found, ""
        return (), KINDS[row.kind] if row.kind in ("input", "arithmetic") else str(found or "")


#: Why an entry has no scene.
ELSEWHERE = "another program or machine: shown, not computed"
SMITH_DATA = "formulas on the document's data: compare/sources/smith/evidence/case.py"
UNEXPLAINED = "printed without what it is computed from: shown, not computed"
MEASURED = "measured by the source: shown, not computed"
CATALOGUE = "formulas on the catalogue's data: compare/sources/external/cases.toml"
WORDING = "a formula of the source, judged as printed"
LIU_SCREW = ("*", ("liu-screw",))

CASE_1 = ("lin-case1",)
CASE_3 = ("lin-case3", "lin-case3-clamped", "lin-case3-ux")
OFFSET = tuple(name.replace("case3", "case3-offset") for name in CASE_3)
PAIRS = ("lin-pair-a", "lin-pair-b")

COMPUTATIONS = (
    Computation("lin-B1", table_b_1, CHAPTER_2, (("*", CASE_1),)),
    Computation(
        "lin-2.4.1",
        section_2_4_1,
        CHAPTER_2,
        (("speed_ratio", ()), ("case2_*", ("lin-case2", "lin-case1")), ("case3_*", CASE_3 + OFFSET), ("*", CASE_1)),
    ),
    Computation(
        "lin-2.4.2",
        section_2_4_2,
        CHAPTER_2,
        (
            ("gamma_*", CASE_1),
            ("profile_*", ("lin-profile", "lin-case1")),
            ("pitch_*", ("lin-pitch", "lin-case1")),
            ("random_*", ("lin-random", "lin-case1")),
            ("combined_*", ("lin-combined",)),
        ),
    ),
    Computation(
        "lin-4.3.2",
        section_4_3_2,
        CHAPTER_2,
        (
            ("e_p", ("lin-pitch-4p1",)),
            ("e_R", ("lin-roundness-4p1",)),
            ("force", ("lin-pitch-4p1",)),
            ("*_4p1", ("lin-pitch-4p1", "lin-roundness-4p1")),
            ("*_2p1", ("lin-pitch-2p1", "lin-roundness-2p1")),
        ),
    ),
    Computation("lin-3.1", rotary_linear.table_3_1, ROTARY, (("*", ("lin-rotary-1",)),)),
    Computation(
        "lin-3.2",
        rotary_linear.table_3_2,
        ROTARY,
        (
            ("*_III", ("lin-rotary-3-printed", "lin-rotary-3")),
            ("*_II", ("lin-rotary-2-printed", "lin-rotary-2")),
            ("*_I", ("lin-rotary-1-printed", "lin-rotary-1")),
        ),
    ),
    Computation("lin-3.3", rotary_linear.table_3_3, LINEAR, (("worst_ratio", ("lin-pair-worst",)), ("*", ("lin-pair-a",)))),
    Computation("lin-3.4", rotary_linear.table_3_4, LINEAR, (("a_*", PAIRS[:1]), ("b_*", PAIRS[1:]))),
    Computation(
        "lin-3.5",
        rotary_linear.table_3_5,
        LINEAR,
        (("error_numerical", ()), ("*_time_*", ELSEWHERE), ("*_ansys", ELSEWHERE), ("b_*", PAIRS[1:]), ("*", PAIRS[:1])),
    ),
    Computation(
        "lin-G",
        rotary_linear.appendix_g,
        ROTARY,
        (
            ("k_f", ("lin-pair-a",)),
            ("reach", "a choice of the source"),
            ("*", "closed form of a groove at a given pressure"),
        ),
    ),
    Computation("lin-3.6", screw.given_3_6, SCREW, (("*", ("lin-screw-pair-a",)),)),
    Computation(
        "lin-3.7",
        screw.table_3_7,
        SCREW,
        (
            ("ansys_*", ELSEWHERE),
            ("time_*", ELSEWHERE),
            ("difference_*", ()),
            ("*_a", ("lin-screw-pair-a", "lin-screw-pair-a-inferred")),
            ("*_b", ("lin-screw-pair-b", "lin-screw-pair-b-inferred")),
        ),
    ),
    Computation("lin-3.4.4", screw.section_3_4_4, SCREW, (("*", ("lin-screw-run", "lin-screw-run-2deg")),)),
    Computation(
        "lin-4.2.1",
        steering_4_2.section_4_2,
        AXES,
        (
            ("ratio_*", ("lin-steering-rack",)),
            ("grows", ("lin-steering-rack",)),
            ("even_*", ("lin-steering-rack",)),
            ("*", ("lin-nominal-4p1",)),
        ),
    ),
    Computation("lin-4.2", screw.table_4_2, CHAPTER_4, (("*", ("lin-bearing-pairs",)),)),
    Computation(
        "lin-4.3",
        screw.section_4_3,
        CHAPTER_4,
        (("roundness_quicker", ("lin-pitch-4p1", "lin-roundness-4p1")), ("*", ("lin-bearing-pairs",))),
    ),
    Computation("smith-table-2-1", smith_ball.table_2_1, SMITH, (("*", "Hertz's elliptic integrals: no bearing"),)),
    Computation("smith-2.1", smith_ball.section_2_1, SMITH, (("*", SMITH_DATA),)),
    Computation("smith-2.2", smith_ball.section_2_2, SMITH, (("*", SMITH_DATA),)),
    Computation("smith-2.3", smith_ball.section_2_3, SMITH, (("*", SMITH_DATA),)),
    Computation("smith-3", smith_taper.chapter_3, SMITH, (("M", UNEXPLAINED), ("M_test", MEASURED), ("*", SMITH_DATA))),
    Computation("smith-4.1", smith_axis.section_4_1, SMITH, (("*", SMITH_DATA),)),
    Computation(
        "smith-4.2",
        smith_axis.section_4_2,
        SMITH,
        (
            ("total_ball", ("smith-axis",)),
            ("total_taper", ("smith-axis-taper",)),
            ("supported", ("smith-axis", "smith-axis-supported")),
            ("*", SMITH_DATA),
        ),
    ),
    Computation("smith-4.3", smith_axis.section_4_3, SMITH, (("*", UNEXPLAINED),)),
    Computation(
        "smith-5",
        smith_trials.chapter_5,
        SMITH,
        (
            *((f"{name}_*", MEASURED) for name in ("accuracy", "reversal", "repeat", "rise", "t750", "t1500")),
            ("*", SMITH_DATA),
        ),
    ),
    Computation("kalker-E3", table_e3, KALKER, (("*", "one contact of half spaces, of the table's ellipse and material"),)),
    Computation(
        "liu-2",
        liu_given.section_2,
        LIU,
        (("v_2pi", ()), ("*_error", ()), ("e_?", ()), ("plus_or_minus", WORDING), LIU_SCREW),
    ),
    Computation("liu-3", liu_given.section_3, LIU, (("load", ()), ("free_length", ()), ("deviation", MEASURED), LIU_SCREW)),
    Computation("liu-4.1", liu_given.section_4_1, LIU, (LIU_SCREW,)),
    Computation("liu-4.2", liu_single.section_4_2, LIU, (LIU_SCREW,)),
    Computation("liu-4.3", liu_drawn.section_4_3, LIU, (LIU_SCREW,)),
    Computation("liu-4.4", liu_drawn.section_4_4, LIU, (("spread_*", ()), LIU_SCREW)),
    Computation(
        "external-masta",
        bearings.masta,
        EXTERNAL,
        (
            ("radial", ("external-masta-radial",)),
            ("axial", ("external-masta-axial",)),
            ("tilt", ("external-masta-moment",)),
        ),
    ),
    Computation("external-nsk", contacts.ball_of_bearing, EXTERNAL, (("*", ("external-nsk-25bswz01",)),)),
    Computation("external-harris", bearings.harris, EXTERNAL, (("*", ("external-harris-218",)),)),
    Computation(
        "external-sjovall",
        bearings.half_zone,
        EXTERNAL,
        (
            ("radial", ("external-sjovall-radial",)),
            ("thrust", "closed form: thrust shared evenly"),
            ("*", ("external-sjovall-combined",)),
        ),
    ),
    Computation("external-contact", contacts.rolling, EXTERNAL, (("*", "one contact, the example of the program"),)),
    Computation("external-vm63", contacts.sphere, EXTERNAL, (("*", "one contact, Hertz's closed form"),)),
    Computation("external-snfa", bearings.snfa, EXTERNAL, (("*", CATALOGUE),)),
    Computation("external-gmn", bearings.gmn, EXTERNAL, (("*", CATALOGUE),)),
    Computation(
        "external-thk",
        screws.nuts,
        EXTERNAL,
        (
            *((f"*_{size}", (screws.scene_name(size),)) for size in (*screws.THK, *screws.HIWIN)),
            ("turns_5", ("external-thk-bnf-3205-5", "external-thk-bnf-3205-2p5")),
            ("turns_7p5", ("external-thk-bnf-3205-7p5", "external-thk-bnf-3205-2p5")),
            ("drag_formula", ()),
            ("*", ("external-thk-bnf-4010-5",)),
        ),
    ),
)
BY_TABLE = {c.table: c for c in COMPUTATIONS}
#: Printed tables that nothing is computed for, and why.
NOT_COMPUTED = {"lin-2.2": "run times and element counts of the source's programs and machine: shown, not compared"}


def evidence(study: Study, *names: str) -> list[Evidence]:
    """Evidence of the printed tables ``names`` (all that are computed unless given), each computed once
    per study, which notes their scenes."""
    wanted = [BY_TABLE[name] for name in names or BY_TABLE]
    for computation in wanted:
        study.uses(computation.every_scene)
    return [e for computation in wanted for e in study.once(computation.compute)]


@dataclass(frozen=True)
class Trace:
    """Where a printed entry comes from: its scenes or why there are none, its one computation (``module:function``), its
    test."""

    table: str
    key: str
    printed: str
    cls: str
    scenes: tuple[str, ...]
    no_scene: str
    computation: str
    test: str


def traces(table: str = "") -> Iterator[Trace]:
    """Every printed entry of one shipped table, or of all, in order. Raises InputError for an unknown table."""
    for name in [table] if table else tables():
        own = BY_TABLE.get(name)
        for row in load_table(name):
            printed = row.claim or f"{row.printed} {row.unit}".rstrip()
            if own is None:
                yield Trace(name, row.key, printed, row.cls, (), NOT_COMPUTED[name], "none", "")
            else:
                test = f"{own.test}::test_entry[{name}:{row.key}]"
                yield Trace(name, row.key, printed, row.cls, *own.origin(row), own.function, test)
