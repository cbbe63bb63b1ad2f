"""Bearings, screws and ball pairs of Lin's chapters 3 and 4, read from the scenes included with rollbench.

Arguments of the functions replace single values of the scenes. Dimensions and loads, and what is assumed or inferred, are
in ``compare/cases/lin/scenes/friction``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING

from rollbench.compare.cases.lin.kinds.bearings import BearingBallScene, BearingPairScene, LinearPairScene
from rollbench.compare.cases.lin.kinds.screw_balls import ScrewPairScene, ScrewRunScene
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.lowfi.friction.bearing import BearingCase
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.run import Pair, Run

if TYPE_CHECKING:
    from rollbench.compare.studies.rolling.runs import RollingRun

#: Scenes of the cases of section 3.2, by number; of the cases of Table 3.7.
ROTARY_SCENES = {"I": "lin-rotary-1", "II": "lin-rotary-2", "III": "lin-rotary-3"}
PAIR_SCENES = {"a": "lin-screw-pair-a", "b": "lin-screw-pair-b"}
#: Scenes of 3.4.4 by the amplitude [deg] of theta, the deviation of the contact angles from nominal.
RUN_SCENES = {2.0: "lin-screw-run-2deg", 3.0: "lin-screw-run"}
LINEAR_PAIR, LINEAR_MATED, LINEAR_WORST = "lin-pair-a", "lin-pair-b", "lin-pair-worst"
BEARINGS = "lin-bearing-pairs"


def rotary_ball_scene(name: str, *, printed: bool = False) -> BearingBallScene:
    """Return the scene of one ball of the rotary bearing in a case of Lin's Table 3.2.

    ``name``: case "I", "II" or "III"; ``printed``: whether with the Hertz constants and the friction law that Lin used.
    """
    return shipped_scene_of_kind(ROTARY_SCENES[name] + "-printed" * printed, BearingBallScene)


def linear_pair_scene(name: str = LINEAR_PAIR) -> LinearPairScene:
    """Return a scene of two neighbouring balls in the linear bearing of Lin's Table 3.3; ``name``: name of the scene."""
    return shipped_scene_of_kind(name, LinearPairScene)


def printed_friction_slope_over_spin_pole_offset() -> float:
    """Return the slope of the friction force over c/a that Lin reads off his Figure 3.11.

    The friction force is divided by its largest value; c is the distance of the spin pole from the contact's centre, a
    the major semi-axis of the contact ellipse.
    """
    return printed_value("lin-G", "k_f")


def finest_rolling_run(cache: SceneResultCache, name: str) -> RollingRun | None:
    """Return the stored result of the 3D rolling model for a scene on the finest grid; None if none is stored.

    ``cache``: gives the folders of stored results; ``name``: name of the scene.
    """
    from rollbench.compare.studies.rolling.runs import LEVELS, load_rolling_run

    stores = cache.reference_folders or (shipped_store(),)
    return load_rolling_run(shipped_scene_of_kind(name, FrictionScene), max(LEVELS), stores)


def stored_3d_results(cache: SceneResultCache, name: str) -> Mapping[str, float]:
    """Return the results of a scene by the 3D rolling model on its finest stored grid.

    The keys are quantities with unit, such as "force 1-2 N". The mapping is empty if no result is stored. ``cache``: gives
    the folders of stored results; ``name``: name of the scene.
    """
    run = finest_rolling_run(cache, name)
    return {} if run is None else run.values


def pair_as_printed(theta: float | None = None) -> Pair:
    """Return two balls of the screw of section 3.4.3 as Lin states them: no clearance, friction changes the contact loads.

    ``theta``: deviation of the second ball's contact angle from nominal [rad]; None: that of the scene.
    """
    return _replace_second_angle_deviation(shipped_scene_of_kind(PAIR_SCENES["a"], ScrewPairScene).pair, theta)


def oversized_pair(theta: float | None = None) -> Pair:
    """Return two balls of the screw of section 3.4.3 with the inferred oversize of the ball radius.

    The oversize is not printed; with it, all four contacts of each ball are loaded. ``theta``: deviation of the second
    ball's contact angle from nominal [rad], if it differs from the scene's.
    """
    scene = shipped_scene_of_kind(f"{PAIR_SCENES['a']}-inferred", ScrewPairScene)
    return _replace_second_angle_deviation(scene.pair, theta)


def _replace_second_angle_deviation(pair: Pair, theta: float | None) -> Pair:
    """Replace the second ball's deviation of the contact angle from nominal by ``theta`` [rad], unless it is None."""
    return pair if theta is None else replace(pair, theta=(pair.theta[0], theta))


def second_ball_angle_deviation(name: str) -> float:
    """Return the second ball's contact angle less nominal [rad] in a case of Lin's Table 3.7; ``name``: "a" or "b"."""
    return shipped_scene_of_kind(PAIR_SCENES[name], ScrewPairScene).pair.theta[1]


def inferred_oversize() -> float:
    """Return the oversize of the ball radius [m] that was inferred from force and friction loss in Lin's Table 3.7."""
    return oversized_pair().oversize


def screw_groove(**changes: object) -> ScrewGroove:
    """Return grooves, speed, friction and material of the ball screw of Lin's Table 3.6.

    ``changes``: new values of fields of `ScrewGroove`, by name.
    """
    return replace(pair_as_printed().groove, **changes)  # type: ignore[arg-type]


def simulation_inputs(**changes: object) -> Run:
    """Return the inputs of the whole-screw simulation of section 3.4.4, with an amplitude of theta of 3 deg.

    Theta is the deviation of the contact angles from nominal. ``changes``: new values of fields of `Run`, by name.
    """
    return replace(simulation_with_angle_deviation(3.0), **changes)  # type: ignore[arg-type]


def simulation_with_angle_deviation(theta_amplitude: float) -> Run:
    """Return the inputs of the whole-screw simulation of section 3.4.4 of Lin's thesis.

    ``theta_amplitude``: amplitude of theta, the deviation of the contact angles from nominal, 2 or 3 [deg].
    """
    return shipped_scene_of_kind(RUN_SCENES[theta_amplitude], ScrewRunScene).run


def four_point_and_double_row_scene() -> BearingPairScene:
    """Return the scene of both bearings of Lin's Table 4.2, four-point and double-row, with their load angles."""
    return shipped_scene_of_kind(BEARINGS, BearingPairScene)


def four_point_bearing(*, tilt: bool = True, **changes: object) -> BearingCase:
    """Return the four-point bearing of Lin's Table 4.2.

    ``tilt``: whether the inner ring is free to tilt; ``changes``: new values of fields of `BearingCase`, by name.
    """
    return replace(four_point_and_double_row_scene().four_point, tilt=tilt, **changes)  # type: ignore[arg-type]


def double_row_bearing(*, tilt: bool = True, **changes: object) -> BearingCase:
    """Return the double-row bearing of Lin's Table 4.2.

    ``tilt``: whether the inner ring is free to tilt; ``changes``: new values of fields of `BearingCase`, by name.
    """
    return replace(four_point_and_double_row_scene().double_row, tilt=tilt, **changes)  # type: ignore[arg-type]


def groove_inputs(groove: ScrewGroove) -> dict[str, float]:
    """Return the inputs that Lin's Tables 3.1 and 3.6 have in common, by key of the printed numbers, in printed units."""
    return {
        "R_B": 1e3 * groove.ball_radius,
        "conformity": 0.5 * groove.groove_radius / groove.ball_radius,
        "R_P": 1e3 * groove.pitch_radius,
        "beta": degrees(groove.contact_angle),
        "mu": groove.mu,
        "nu": groove.poisson,
    }
