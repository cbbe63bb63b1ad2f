"""What is computed for the printed tables of Lin (2019): function, test, scenes."""

from __future__ import annotations

from rollbench.comparison.evidence.registry import Computation

CHAPTER_2 = "tests/literature/test_lin_chapter2.py"
ROTARY = "tests/literature/test_lin_chapter3_rotary.py"
LINEAR = "tests/literature/test_lin_chapter3_linear.py"
SCREW = "tests/literature/test_lin_chapter3_screw.py"
CHAPTER_4 = "tests/literature/test_lin_chapter4_friction.py"
AXES = "tests/literature/test_lin_chapter4_axes.py"
ELSEWHERE = "another program or machine: shown, not computed"
CASE_1 = ("lin-case1",)
CASE_3 = ("lin-case3", "lin-case3-clamped", "lin-case3-ux")
OFFSET = tuple(name.replace("case3", "case3-offset") for name in CASE_3)
PAIRS = ("lin-pair-a", "lin-pair-b")

COMPUTATIONS = (
    Computation("lin-B1", "sources.lin.evidence.hertz_b1:table_b_1", CHAPTER_2, (("*", CASE_1),)),
    Computation(
        "lin-2.4.1",
        "sources.lin.evidence.loads_2_4_1:section_2_4_1",
        CHAPTER_2,
        (("speed_ratio", ()), ("case2_*", ("lin-case2", "lin-case1")), ("case3_*", CASE_3 + OFFSET), ("*", CASE_1)),
    ),
    Computation(
        "lin-2.4.2",
        "sources.lin.evidence.errors_2_4_2:section_2_4_2",
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
        "sources.lin.evidence.errors_4_3_2:section_4_3_2",
        CHAPTER_2,
        (
            ("e_p", ("lin-pitch-4p1",)),
            ("e_R", ("lin-roundness-4p1",)),
            ("force", ("lin-pitch-4p1",)),
            ("*_4p1", ("lin-pitch-4p1", "lin-roundness-4p1")),
            ("*_2p1", ("lin-pitch-2p1", "lin-roundness-2p1")),
        ),
    ),
    Computation(
        "lin-3.1", "sources.lin.evidence.rotary_linear:table_3_1", ROTARY, (("*", ("lin-rotary-1",)),), needs=("friction",)
    ),
    Computation(
        "lin-3.2",
        "sources.lin.evidence.rotary_linear:table_3_2",
        ROTARY,
        (
            ("*_III", ("lin-rotary-3-printed", "lin-rotary-3")),
            ("*_II", ("lin-rotary-2-printed", "lin-rotary-2")),
            ("*_I", ("lin-rotary-1-printed", "lin-rotary-1")),
        ),
        needs=("friction",),
    ),
    Computation(
        "lin-3.3",
        "sources.lin.evidence.rotary_linear:table_3_3",
        LINEAR,
        (("worst_ratio", ("lin-pair-worst",)), ("*", ("lin-pair-a",))),
        needs=("friction",),
    ),
    Computation(
        "lin-3.4",
        "sources.lin.evidence.rotary_linear:table_3_4",
        LINEAR,
        (("a_*", PAIRS[:1]), ("b_*", PAIRS[1:])),
        needs=("friction",),
    ),
    Computation(
        "lin-3.5",
        "sources.lin.evidence.rotary_linear:table_3_5",
        LINEAR,
        (("error_numerical", ()), ("*_time_*", ELSEWHERE), ("*_ansys", ELSEWHERE), ("b_*", PAIRS[1:]), ("*", PAIRS[:1])),
        needs=("friction",),
    ),
    Computation(
        "lin-G",
        "sources.lin.evidence.rotary_linear:appendix_g",
        ROTARY,
        (
            ("k_f", ("lin-pair-a",)),
            ("reach", "a choice of the source"),
            ("*", "closed form of a groove at a given pressure"),
        ),
        needs=("friction",),
    ),
    Computation(
        "lin-3.6", "sources.lin.evidence.screw:given_3_6", SCREW, (("*", ("lin-screw-pair-a",)),), needs=("friction",)
    ),
    Computation(
        "lin-3.7",
        "sources.lin.evidence.screw:table_3_7",
        SCREW,
        (
            ("ansys_*", ELSEWHERE),
            ("time_*", ELSEWHERE),
            ("difference_*", ()),
            ("*_a", ("lin-screw-pair-a", "lin-screw-pair-a-inferred")),
            ("*_b", ("lin-screw-pair-b", "lin-screw-pair-b-inferred")),
        ),
        needs=("friction",),
    ),
    Computation(
        "lin-3.4.4",
        "sources.lin.evidence.screw:section_3_4_4",
        SCREW,
        (("*", ("lin-screw-run", "lin-screw-run-2deg")),),
        needs=("friction",),
    ),
    Computation(
        "lin-4.2.1",
        "sources.lin.evidence.steering_4_2:section_4_2",
        AXES,
        (
            ("ratio_*", ("lin-steering-rack",)),
            ("grows", ("lin-steering-rack",)),
            ("even_*", ("lin-steering-rack",)),
            ("*", ("lin-nominal-4p1",)),
        ),
    ),
    Computation(
        "lin-4.2", "sources.lin.evidence.screw:table_4_2", CHAPTER_4, (("*", ("lin-bearing-pairs",)),), needs=("friction",)
    ),
    Computation(
        "lin-4.3",
        "sources.lin.evidence.screw:section_4_3",
        CHAPTER_4,
        (("roundness_quicker", ("lin-pitch-4p1", "lin-roundness-4p1")), ("*", ("lin-bearing-pairs",))),
        needs=("friction",),
    ),
    Computation(
        "lin-2.2",
        "",
        "",
        (("*", "run times and element counts of the source's programs and machine: shown, not compared"),),
    ),
)
