"""Cases of the source as used by evidence, sections, benches and tests: read from the shipped scenes, changed by keyword.

No numbers of a case are written here: they, and what is assumed or inferred, are in ``compare/scenes``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from rollbench.compare.models.study import Study
from rollbench.compare.printed import value_of
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.catalogue import case
from rollbench.compare.scenes.friction_kinds.bearings import BearingBallScene, BearingPairScene, LinearPairScene
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.scenes.friction_kinds.screw_balls import ScrewPairScene, ScrewRunScene
from rollbench.lowfi.friction.bearing import BearingCase
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.run import Pair, Run

#: Scenes of the cases of 3.2: as computed here, and with the source's constants and law.
ROTARY_SCENES = {"I": "lin-rotary-1", "II": "lin-rotary-2", "III": "lin-rotary-3"}
PAIR_SCENES = {"a": "lin-screw-pair-a", "b": "lin-screw-pair-b"}
#: Scenes of 3.4.4 by the amplitude of theta [deg].
RUN_SCENES = {2.0: "lin-screw-run-2deg", 3.0: "lin-screw-run"}
LINEAR_PAIR, LINEAR_MATED, LINEAR_WORST = "lin-pair-a", "lin-pair-b", "lin-pair-worst"
BEARINGS = "lin-bearing-pairs"


def rotary(name: str, *, printed: bool = False) -> BearingBallScene:
    """Return case "I", "II" or "III" of Table 3.2; ``printed``: with the source's Hertz constants and law."""
    return case(ROTARY_SCENES[name] + "-printed" * printed, BearingBallScene)


def linear(name: str = LINEAR_PAIR) -> LinearPairScene:
    """Return a pair of the linear bearing of Table 3.3."""
    return case(name, LinearPairScene)


def k_f() -> float:
    """Return the slope of the friction force over c/a that the source read off its Figure 3.11 for its formulas."""
    return value_of("lin-G", "k_f")


def in_3d(study: Study, name: str) -> Mapping[str, float]:
    """Return results of a scene's finest stored 3D rolling run, such as "force 1-2 N"; empty without a run."""
    from rollbench.compare.studies.rolling.runs import LEVELS, load_run

    run = load_run(case(name, KindScene), max(LEVELS), study.stores or (shipped_store(),))
    return {} if run is None else run.values


def case_as_printed(theta: float | None = None) -> Pair:
    """Return the case of 3.4.3 exactly as the text states it: no clearance, friction coupled to the loads.

    theta: angle between neighbours [rad], if it differs.
    """
    return _with_theta(case(PAIR_SCENES["a"], ScrewPairScene).pair, theta)


def inferred(theta: float | None = None) -> Pair:
    """Return the pair with inferred (not printed) oversize balls, so that all four contacts carry load.

    ``theta``: deviation of the leading ball's contact angle [rad], if it differs from the scene's.
    """
    return _with_theta(case(f"{PAIR_SCENES['a']}-inferred", ScrewPairScene).pair, theta)


def _with_theta(pair: Pair, theta: float | None) -> Pair:
    """Return the pair with its second theta replaced, unless ``theta`` is None."""
    return pair if theta is None else replace(pair, theta=(pair.theta[0], theta))


def deviation(name: str) -> float:
    """Return the deviation theta [rad] of case "a" or "b" of Table 3.7."""
    return case(PAIR_SCENES[name], ScrewPairScene).pair.theta[1]


def inferred_oversize() -> float:
    """Return the oversize of the ball radius [m] inferred from Table 3.7."""
    return inferred().oversize


def table_3_6(**changes: object) -> ScrewGroove:
    """Return the screw of Table 3.6; ``changes``: other values."""
    return replace(case_as_printed().groove, **changes)  # type: ignore[arg-type]


def lin_3_4_4(**changes: object) -> Run:
    """Return the run of 3.4.4 (theta of 3 degrees) with its assumptions; ``changes``: fields to replace."""
    return replace(run_of(3.0), **changes)  # type: ignore[arg-type]


def run_of(degrees: float) -> Run:
    """Return the shipped run of 3.4.4 with theta of 2 or 3 degrees."""
    return case(RUN_SCENES[degrees], ScrewRunScene).run


def bearings() -> BearingPairScene:
    """Return both bearings of Table 4.2 and the angles of the load."""
    return case(BEARINGS, BearingPairScene)


def four_point(*, tilt: bool = True, **changes: object) -> BearingCase:
    """Return the four-point bearing of Table 4.2; tilt: inner ring free to tilt; ``changes``: of the case."""
    return replace(bearings().four_point, tilt=tilt, **changes)  # type: ignore[arg-type]


def double_row(*, tilt: bool = True, **changes: object) -> BearingCase:
    """Return the double-row bearing of Table 4.2; tilt: inner ring free to tilt; ``changes``: of the case."""
    return replace(bearings().double_row, tilt=tilt, **changes)  # type: ignore[arg-type]
