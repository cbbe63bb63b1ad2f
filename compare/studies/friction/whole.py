"""Friction of a whole screw or bearing: contact loads by a static model, then friction of every ball and the torques.

A scene may leave out the coefficient of friction, the preload and the play of the balls: the effect of these inputs on the
torques is also shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.models.answers import results_of_contact_loads, warnings_of_set
from rollbench.compare.models.friction_sums import friction_torques, without_times_and_warnings
from rollbench.compare.models.friction_torques import TORQUE_KEYS
from rollbench.compare.models.loading import axial_preload
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import DEFAULT, run_model
from rollbench.compare.quantities import count_with_noun, json_number
from rollbench.compare.results import friction as records
from rollbench.compare.results.friction import FrictionBand, FrictionOnset, FrictionPlay
from rollbench.compare.scenes.scene_file import kind_of_scene
from rollbench.compare.studies.friction import answer as output
from rollbench.compare.studies.friction import run as friction_run
from rollbench.compare.text.friction import format_three_digits
from rollbench.lowfi.friction.whole.circuit import contact_onset
from rollbench.lowfi.friction.whole.state import FrictionCase, FrictionState, friction_of_curved_contacts, friction_states
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.cache import each_cached_on_disk
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import SIDES, BallErrors, Friction, Motion, Scene, SideErrors, Support

#: Smallest and largest coefficient of sliding friction of lubricated contacts. The 0.003 to 0.01 of catalogues are overall
#: coefficients of a whole screw, which hold for its lead angle and not for sliding.
MEASURED = (0.03, 0.1)

#: Factor of THK's formula of a preloaded nut's drag torque (general catalogue); those of Rexroth and HIWIN are in
#: `compare/cases/makers/nuts.py`.
MAKERS = 0.05

#: Reduction of the ball radius [m] to show the effect of a play that is not stated.
SMALLER = 5e-6

#: A note is given if the torque grows by at least this factor because friction moves the balls.
FED_BACK = 1.5

#: Smaller coefficients of friction at which the note states this factor.
SMALLER_COEFFICIENTS = (0.03, 0.01)

_friction_states_on_disk = each_cached_on_disk(FrictionState)(friction_states)


@dataclass(frozen=True)
class StaticallySolvedPart:
    """Screw or bearing with its static result without loads, and the settings for computing its friction torque."""

    #: Scene of the screw or bearing.
    scene: Scene
    #: Name of the static model that computes the contact loads.
    model: str
    #: Options of the static model.
    options: ModelOptions
    #: Coefficients of friction at the contacts of screw and nut (of inner and outer ring).
    friction: Friction
    #: Motion of screw or nut.
    motion: Motion
    #: Static result without the loads of the scene.
    unloaded_result: StaticResult
    #: Friction of the cases that are solved already, each with its static result, which keeps its id.
    known: dict[object, tuple[FrictionState, StaticResult]] = field(default_factory=dict)

    @property
    def preload(self) -> float:
        """Axial preload [N]; 0 if the static result without loads did not converge."""
        return axial_preload(self.scene, self.unloaded_result) if self.unloaded_result.converged else 0.0

    def case(self, result: StaticResult, friction: Friction, scene: Scene | None = None) -> FrictionCase:
        """Return the case of a static result and coefficients of friction; ``scene``: None for the scene of this object."""
        return FrictionCase(scene or self.scene, result, friction, self.motion, self.options.member)

    def states(self, cases: Sequence[FrictionCase]) -> list[FrictionState]:
        """Return the friction of several cases as `friction_states` computes it, new ones together; cached on disk.

        Cases are equal if their static results are the same object, and all else is equal.
        """
        keys = [(case.scene, case.friction, case.drive, case.member, id(case.result)) for case in cases]
        new = {key: case for key, case in zip(keys, cases, strict=True) if key not in self.known}
        timeless = [c._replace(result=without_times_and_warnings(c.result)) for c in new.values()]
        for (key, case), state in zip(new.items(), _friction_states_on_disk(timeless), strict=True):
            self.known[key] = state, case.result
        return [self.known[key][0] for key in keys]

    def torques(self, cases: Sequence[FrictionCase]) -> list[float]:
        """Return the friction torques [N m] of several cases.

        A torque is nan if the static result did not converge, or if no balance of friction was found.
        """
        states = iter(self.states([case for case in cases if case.result.converged]))
        found = [next(states) if case.result.converged else None for case in cases]
        return [s.friction_sums.friction_torque if s is not None and s.all_balanced else float("nan") for s in found]


def drag_torque_by_makers_formula(scene: Scene, force: float) -> float:
    """Return the drag torque of a screw by the formula of screw makers, 0.05/sqrt(tan(lead angle)) F l/(2 pi), l: lead.

    Parameters
    ----------
    scene
        Scene of a ball screw.
    force
        Axial preload F [N].

    Returns
    -------
    float
        Torque [N m].
    """
    return MAKERS / float(np.sqrt(abs(np.tan(lead_angle(scene.track))))) * force * scene.track.lead / (2.0 * pi)


def measured_coefficients(friction: Friction) -> list[Friction]:
    """Return ``friction`` with the smallest, then the largest coefficient of friction in measurements (`MEASURED`)."""
    return [with_coefficient(friction, mu) for mu in MEASURED]


def with_coefficient(friction: Friction, mu: float) -> Friction:
    """Return ``friction`` with one coefficient of friction ``mu`` in all contacts."""
    return replace(friction, screw=mu, nut=mu, balls=None)


def torques_at_measured_coefficients(solved: StaticallySolvedPart, result: StaticResult) -> FrictionBand:
    """Return friction torques at the smallest and largest coefficient of friction in measurements (`MEASURED`).

    The band has the torques under the scene's loads, the drag torques (friction torques without these loads), the axial
    preload, and the drag torque by the makers' formula `drag_torque_by_makers_formula`. Preload and drag torques are None
    for a scene without preload. ``solved``: the scene with its static result without loads; ``result``:
    static result under the loads.
    """
    scene, idle = solved.scene, solved.unloaded_result
    preload, ends = solved.preload, measured_coefficients(solved.friction)
    pressed = preload > 0.0 and scene.track.lead > 0.0
    drag = None
    if pressed:
        drag = [json_number(torque) for torque in solved.torques([solved.case(idle, end) for end in ends])]
    return FrictionBand(
        coefficients=MEASURED,
        torque=[json_number(x) for x in solved.torques([solved.case(result, end) for end in ends])],
        drag_torque=drag,
        preload=preload if pressed else None,
        makers=drag_torque_by_makers_formula(scene, preload) if pressed else None,
    )


def result_with_play(solved: StaticallySolvedPart, result: StaticResult) -> tuple[Scene, StaticResult] | None:
    """Return a screw with balls that are smaller by `SMALLER` in radius, which have play, and its static result.

    None if the scene states play or preload, if its balls carry no load under its loads, or if they carry load even without
    them. ``solved``: the scene with its static result without loads; ``result``: static result under the loads.
    """
    scene = solved.scene
    fits = scene.track.lead > 0.0 and scene.errors.balls == BallErrors() and not scene.errors.lead_offset
    if not fits or not (result.load > 0.0).any() or (solved.unloaded_result.load > 0.0).any():
        return None
    balls = replace(scene.errors.balls, oversize=-SMALLER)
    smaller = replace(scene, errors=replace(scene.errors, balls=balls))
    return smaller, run_model(smaller, solved.model, replace(solved.options, estimate_beam_mesh_error=False))


def torque_with_play(
    solved: StaticallySolvedPart, state: FrictionState, with_play: tuple[Scene, StaticResult]
) -> FrictionPlay:
    """Return a screw's friction torques with the balls of the scene and with smaller balls, which have play.

    ``solved``: the scene; ``state``: friction with its balls; ``with_play``: `result_with_play`.
    """
    scene, result = with_play
    (torque,) = solved.torques([solved.case(result, solved.friction, scene)])
    as_given = state.friction_sums.friction_torque
    return FrictionPlay(smaller=SMALLER, torque=json_number(torque), as_given=json_number(as_given))


def play_warning(play: FrictionPlay) -> ResultWarning:
    """Return a warning that the scene states neither play nor preload, with the friction torques with and without play.

    ``play``: `torque_with_play`.
    """
    other = "none found" if play.torque is None else f"{1e3 * play.torque:.4g} N mm"
    as_given = float("nan") if play.as_given is None else play.as_given
    text = (
        "no preload and no play are stated, and the play decides: friction torque "
        f"{1e3 * as_given:.4g} N mm with balls that fit exactly, {other} with balls "
        f"{1e6 * play.smaller:g} um smaller in radius; state [errors.balls] oversize or a preload"
    )
    return ResultWarning("play", text, text)


#: Factors on the geometric errors that are tried to find where neighbouring balls touch, and number of bisections between
#: two successive factors.
FACTORS, HALVINGS = tuple(2.0**k for k in range(-4, 5)), 4


def with_scaled_geometric_errors(scene: Scene, factor: float) -> Scene:
    """Return a scene with the geometric errors of its grooves and of single balls multiplied by ``factor``.

    The oversize that all balls share (preload or play) does not change.
    """

    def scaled_errors(side: SideErrors) -> SideErrors:
        """Return the errors of the screw's or the nut's groove, multiplied by the factor."""
        pitch, roundness = (
            tuple(replace(t, sin=factor * t.sin, cos=factor * t.cos, sigma=factor * t.sigma) for t in terms)
            for terms in (side.pitch, side.roundness)
        )
        profile, sigma = (tuple(factor * x for x in values) for values in (side.profile, side.profile_sigma))
        return replace(side, profile=profile, profile_sigma=sigma, pitch=pitch, roundness=roundness)

    errors = scene.errors
    listed = tuple((number, factor * x) for number, x in errors.balls.listed)
    balls = replace(errors.balls, listed=listed, sigma=factor * errors.balls.sigma)
    sides: dict[str, Any] = {side: scaled_errors(errors.side(side)) for side in SIDES}
    return replace(scene, errors=replace(errors, balls=balls, **sides))


def onset_of_ball_to_ball_contact(
    solved: StaticallySolvedPart, result: StaticResult, state: FrictionState
) -> FrictionOnset | None:
    """Return after which rotation of screw or nut neighbouring balls touch, and how large geometric errors cause it.

    The size of the errors is a factor on the geometric errors of the scene. ``solved``: the scene with its model and
    motion; ``result``: static result with the contact loads; ``state``: friction at these loads. The returned value is None
    if the balls overlap, or do not fit into their circuits.
    """

    def balls_touch_with_scaled_errors(factor: float) -> bool:
        """Return whether neighbouring balls touch if the scene's geometric errors are multiplied by a factor."""
        scene = with_scaled_geometric_errors(solved.scene, factor)
        options = solved.options if scene.errors.random else replace(solved.options, member=0)
        loads = run_model(scene, solved.model, options)
        return loads.converged and contact_onset(scene, loads, drive=solved.motion).touches_under_load

    orbits = state.orbital_speeds_without_feedback if solved.friction.screw == solved.friction.nut else None
    try:
        standing, rolling = (contact_onset(solved.scene, result, idle, solved.motion, orbits) for idle in (0.0, 1.0))
    except ValueError:  # overlapping balls or impossible circuits: no statement on neighbours
        return None
    factor, has_errors = None, with_scaled_geometric_errors(solved.scene, 0.0) != solved.scene
    if has_errors:
        known = {1.0: standing.touches_under_load}
        tried = (x for x in (0.0, *FACTORS) if (known[x] if x in known else balls_touch_with_scaled_errors(x)))
        factor = next(tried, None)
    if factor:
        low = 0.5 * factor if factor > FACTORS[0] else 0.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + factor)
            low, factor = (low, middle) if balls_touch_with_scaled_errors(middle) else (middle, factor)
    meets = bool(np.isfinite(standing.rotation_to_first_meeting))
    later = rolling.rotation_to_first_meeting
    return FrictionOnset(
        touch=standing.touches_under_load,
        first=standing.rotation_to_first_meeting if meets else None,
        ball=int(standing.neighbour_pairs[standing.rotation_to_meeting.argmin(), 0]) + 1 if meets else None,
        rolling=later if np.isfinite(later) else None,
        closing=int(np.isfinite(standing.rotation_to_meeting).sum()),
        pairs=len(standing.neighbour_pairs),
        unloaded=int((standing.contact_load_sums == 0.0).sum()),
        factor=factor,
        has_errors=has_errors,
    )


def notes_on_friction_feedback(
    solved: StaticallySolvedPart, result: StaticResult, state: FrictionState
) -> list[ResultWarning]:
    """Return a note if the displacement of balls by friction raises the friction torque by more than factor `FED_BACK`.

    The list is empty otherwise. The note names the flank onto which friction presses the balls, that of the reversed
    motion, and the factor at smaller coefficients of friction. ``solved``: the scene; ``result``: static result under its
    loads; ``state``: friction at these loads.
    """
    if not state.friction_changes_loads or not factor_of_feedback(state) > FED_BACK:
        return []
    load, bare, back = (
        output.mean_flank_loads(force)
        for force in (state.contacts.force, state.loads_without_friction, state.loads_in_reverse)
    )
    flank, reversed_flank = (int(np.argmax(pressed - bare)) for pressed in (load, back))
    torque, without = (
        format_three_digits(1e3 * sums.friction_torque) for sums in (state.friction_sums, state.sums_without_feedback)
    )
    smaller = [mu for mu in SMALLER_COEFFICIENTS if mu < max(solved.friction.screw, solved.friction.nut)]
    others = solved.states([solved.case(result, with_coefficient(solved.friction, mu)) for mu in smaller])
    factors = [
        f"{format_three_digits(factor_of_feedback(other))} at {mu:g}"
        for mu, other in zip(smaller, others, strict=True)
        if other.all_balanced
    ]
    text = (
        f"friction presses the balls onto flank {SIDES[flank]}, {load[flank]:.3g} N a ball ({bare[flank]:.3g} without "
        f"friction), where they slide: torque {torque}, not {without} N mm, factor {factor_of_feedback(state):.3g}"
        + f" ({', '.join(factors)})" * bool(factors)
        + f"; reversed, flank {SIDES[reversed_flank]}"
    )
    return [ResultWarning("third flank", text)]


def factor_of_feedback(state: FrictionState) -> float:
    """Return the ratio of the friction torque to that at the contact loads without friction; 1 without friction."""
    alone = state.sums_without_feedback.friction_torque
    return state.friction_sums.friction_torque / alone if alone > 0.0 else 1.0


#: Largest allowed coefficient of friction.
MOST = 2.0

#: Assumption of a scene without a motion.
NO_SPEED = (
    "The scene has no [motion]: the screw turns once a second. Losses and speeds are proportional to that, torques and "
    "efficiencies do not depend on it."
)


@dataclass(frozen=True)
class FrictionChoices:
    """Options of a friction computation that a user chooses: model, coefficients of friction, draw of random errors."""

    #: Name of the low-order model that computes the contact loads; empty: the default.
    model: str = ""
    #: Coefficients of friction that replace the scene's; empty: the scene's are used.
    mu: tuple[float, ...] = ()
    #: Number, from 0, of the random draw of the scene's geometric errors (specimen) that is solved.
    member: int = 0
    #: File with the condensed stiffness of screw and nut, which the model "condensed" reads; None: no file.
    condensed: Path | None = None


def friction_coefficients(scene: Scene, mu: Sequence[float]) -> list[Friction]:
    """Return the coefficients of friction for which a screw or bearing is solved: those in ``mu``, else the scene's.

    ``mu``: coefficients that replace those of the scene, each for the contacts of both screw and nut; empty: none.
    Raises InputError for a scene without a coefficient of friction, and for a coefficient out of range.
    """
    for value in mu:
        if not 0.0 <= value <= MOST:
            raise ArgumentError("mu", str(value), f"0 to {MOST:g}", "give a smaller coefficient, such as 0.1")
    if mu:
        given = Friction(0.0, 0.0) if scene.friction is None else scene.friction
        assumed = ("The coefficient of friction is that of the command line.",)
        return [Friction(value, value, assumed, given.feedback, neighbours=given.neighbours) for value in mu]
    if scene.friction is None:
        advice = "add a [friction] table with e.g. coefficient = 0.1, or give `mu=0.1`"
        raise InputError(scene.name, "friction", "no coefficient", "a coefficient of friction", advice)
    return [scene.friction]


def solve_friction_of_all_cases(
    solved: StaticallySolvedPart,
    pairs: Sequence[Friction],
    result: StaticResult,
    with_play: tuple[Scene, StaticResult] | None,
) -> None:
    """Solve the friction of all cases that an answer needs together, and keep them in ``solved``.

    ``pairs``: coefficients of friction that are asked for; ``result``: static result under the loads; ``with_play``: scene
    with play and its static result, None if it is not needed.
    """
    bare, ends = solved.unloaded_result, measured_coefficients(solved.friction)
    cases = [solved.case(result, friction) for friction in (*pairs, *ends)]
    if bare.converged:
        of_drag = [*pairs, *(ends if solved.preload > 0.0 and solved.scene.track.lead > 0.0 else ())]
        cases += [solved.case(bare, friction) for friction in of_drag]
    if with_play is not None and with_play[1].converged:
        cases.append(solved.case(with_play[1], solved.friction, with_play[0]))
    solved.states(cases)


def solve_friction_of_screw_or_bearing(scene: Scene, choices: FrictionChoices) -> records.Friction:
    """Compute contact loads of a screw or bearing by a static model, then its friction for every friction coefficient.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    choices
        Model, coefficients of friction and number of the specimen (draw of random errors); single balls are shown for the
        first coefficient.

    Returns
    -------
    Friction
        The friction.

    Raises
    ------
    InputError
        If the model does not cover the scene, or the scene has no coefficient of friction.
    """
    pairs = friction_coefficients(scene, choices.mu)
    if not 0 <= choices.member < 10**9:
        advice = "state the number of a specimen (one random draw of the geometric errors)"
        raise ArgumentError("member", str(choices.member), "0 to 999999999", advice)
    model = choices.model or (DEFAULT if choices.condensed is None else "condensed")
    if choices.condensed is not None and model != "condensed":
        allowed = 'a file of condensed bodies only with the model "condensed"'
        advice = 'leave `model` out: the file selects the model "condensed"'
        raise ArgumentError("condensed", f"{choices.condensed} with the model {model}", allowed, advice)
    options = ModelOptions(member=choices.member, condensed_bodies_file=choices.condensed, estimate_beam_mesh_error=False)
    result = run_model(scene, model, options)
    head: dict[str, Any] = {"scene": scene.name, "title": scene.title, "kind": kind_of_scene(scene), "model": result.model}
    head["member"] = choices.member if scene.errors.random else None
    if not result.converged:
        status = f"contact loads: {result.status}"
        return records.Friction(**head, reason=status, converged=False, assumed=scene.assumed, keys=(*HEAD, *REMARKS))
    motion = scene.motion or ONE_TURN
    bare = result if not has_external_loads(scene) else run_model(replace(scene, loads=()), model, options)
    solved = StaticallySolvedPart(scene, model, options, pairs[0], motion, bare)
    with_play = result_with_play(solved, result)
    try:
        solve_friction_of_all_cases(solved, pairs, result, with_play)
        states = solved.states([solved.case(result, pair) for pair in pairs])
    except ValueError as error:  # balls that overlap by their random sizes
        raise SceneNotCoveredError(
            scene.name, "balls", str(error), "increase the angles between the balls, or set friction.neighbours = false"
        ) from error
    found = friction_of_solved_loads(
        solved,
        result,
        pairs,
        states,
        band=torques_at_measured_coefficients(solved, result),
        play=None if with_play is None else torque_with_play(solved, states[0], with_play),
        onset=onset_of_ball_to_ball_contact(solved, result, states[0]) if states[0].loaded else None,
        **head,
    )
    if scene.time is None:
        return found
    run = friction_run.simulate_friction_over_time(scene, pairs[0], motion, model, choices.member)
    if found.converged and not run.converged:
        found = replace(found, reason=f"simulation over time: {run.status}", converged=False)
    return replace(found, run=run, keys=(*found.keys, "run"))


def has_external_loads(scene: Scene) -> bool:
    """Return whether a scene has loads other than zero."""
    return any(np.any(load.force) or np.any(load.moment) for load in scene.loads)


#: Friction torque without loads for each pair of coefficients of friction [N m], None where it is not known; why it is not
#: known for the first pair; and a note that the screw was left free along its axis. Texts may be empty.
DragTorques = tuple[list[float | None], str, str]


def drag_torques(solved: StaticallySolvedPart, states: Sequence[FrictionState], pairs: Sequence[Friction]) -> DragTorques:
    """Compute the friction torque without the scene's loads (drag torque), for each pair of friction coefficients.

    Supports and their prescribed displacements stay. If the supports load the screw axially, they are released along the
    axis, because the drag torque is the friction torque at zero axial load.

    Parameters
    ----------
    solved
        Scene of one nut or bearing, with its static result without loads.
    states
        Friction under the loads, for each pair of coefficients.
    pairs
        Coefficients of friction of screw and nut.

    Returns
    -------
    DragTorques
        Drag torques with the reason why there are none.
    """
    scene, unloaded, note = solved.scene, solved.unloaded_result, ""
    none: list[float | None] = [None] * len(pairs)
    if has_external_loads(scene):
        if not unloaded.converged:
            return none, unloaded.status, ""
        states = solved.states([solved.case(unloaded, pair) for pair in pairs])
    if any(state.friction_sums.moves_axial_load for state in states):
        pressed = f"its supports press it with {states[0].friction_sums.axial_load:.4g} N along its axis"
        freed = replace(scene, loads=(), supports=without_axial_supports(scene.supports))
        let_go = run_model(freed, unloaded.model, solved.options)
        if not let_go.converged:
            return none, f"{pressed}, and without them: {let_go.status}", ""
        states = solved.states([solved.case(let_go, pair, freed) for pair in pairs])
        note = f"the screw left free along its axis: {pressed}"
    torques = [state.friction_sums.friction_torque if state.all_balanced else None for state in states]
    return torques, "no balance of friction found" if torques[0] is None else "", note


def without_axial_supports(supports: Sequence[Support]) -> tuple[Support, ...]:
    """Return the supports of a screw without their constraints along the axis.

    A support that constrains nothing else is left out.
    """
    freed = (replace(s, fixed=tuple(held for held in s.fixed if held[0] != "uz")) for s in supports)
    return tuple(s for s in freed if s.fixed)


def friction_status(state: FrictionState) -> str:
    """Return the status of the friction of a screw or bearing: "converged", or what failed on which balls."""
    failed = [str(i + 1) for i, word in enumerate(state.ball_friction.status) if word == "failed"]
    if failed:
        return f"no balance of friction found on {count_with_noun(len(failed), 'ball')}: {', '.join(failed[:8])}"
    if state.unsettled_balls:
        numbers = ", ".join(str(k + 1) for k in state.unsettled_balls[:8])
        balls = count_with_noun(len(state.unsettled_balls), "ball")
        return f"friction and position do not agree on {balls}: {numbers}; see feedback = false"
    return "converged" if state.loaded else "converged: no contact carries load, so that nothing rubs"


#: First and last keys of the JSON of a screw or bearing.
HEAD = ("scene", "title", "kind", "model", "member", "status", "converged")
REMARKS = ("assumed", "left_out", "warnings")

#: Keys of the JSON of a screw or bearing.
KEYS = (
    *HEAD,
    *("law", "coupled", "friction.screw", "friction.nut", "motion.turns", "motion.speed_rad_s", "balls"),
    *(f"torque.{key}" for key in TORQUE_KEYS),
    *("band", "onset", "play", "drag_unknown", "drag_note", "over_friction", "losses.total_W", "losses.by_contact_W"),
    *("losses.between_balls_W", "losses.heathcote_percent", *output.BALANCE_KEYS),
    *("energy.axial_load_power_W", "energy.torque_power_W"),
    *("feedback.friction_torque_without_Nmm", "feedback.unsettled_balls", "feedback.axial_friction_on_screw_N"),
    *("feedback.balls_touching", "feedback.friction_over_load"),
    *("solver.static_residual", "solver.friction_imbalance", "solver.feedback_change", "solver.second_states"),
    *REMARKS,
)

#: Relative change of the contact losses by Heathcote slip above which a warning is given.
WIDE = 0.03

#: Keys of the torques for each pair of coefficients of friction.
OVER_KEYS = (
    *("friction_torque_Nmm", "drag_torque_Nmm", "forward_torque_Nmm", "backward_torque_Nmm"),
    *("efficiency_forward_percent", "efficiency_backward_percent", "self_locking"),
)


def friction_of_solved_loads(
    solved: StaticallySolvedPart,
    result: StaticResult,
    pairs: Sequence[Friction],
    states: Sequence[FrictionState],
    **more: Any,
) -> records.Friction:
    """Return the friction of a whole screw or bearing.

    ``solved``: the scene with its static result without loads; ``result``: static result under the loads; ``pairs``:
    coefficients of friction; ``states``: friction for each pair of them; ``more``: further fields, such as those on scene
    and model, the play and the onset of contact between balls.
    """
    scene, friction, state, play = solved.scene, pairs[0], states[0], more.get("play")
    drags, drag_unknown, drag_note = drag_torques(solved, states, pairs)
    status = friction_status(next((s for s in states if not s.all_balanced), state))
    flat, curved = friction_of_curved_contacts(solved.case(result, friction), state) if state.loaded else (None, None)
    # assumptions of the model alone are marked, because the model neglects friction
    of_loads = [line if line in scene.assumed else f"contact loads: {line}" for line in result.assumed]
    e, slip = state.friction_sums, output.change_of_losses(flat, curved)
    loads = results_of_contact_loads(scene, result.load, result.contact_angle, result.member)
    warnings = [*result.warnings, *warnings_of_set(loads, solved.preload)]
    warnings += notes_on_friction_feedback(solved, result, state)
    if abs(slip) > WIDE:
        text = "the contacts are so wide that their curvature (Heathcote slip) would change the friction torque, which"
        warnings.append(ResultWarning("slip", f"{text} leaves it out, by {100.0 * slip:+.2g} %"))
    over = (
        records.FrictionAtCoefficients(screw=f.screw, nut=f.nut, keys=OVER_KEYS, **friction_torques(s.friction_sums, drag))
        for f, s, drag in zip(pairs, states, drags, strict=True)
    )
    return records.Friction(
        **more,
        **friction_torques(e, drags[0]),
        **output.power_balance(e.input_power, e.power),
        reason=status,
        converged=all(s.all_balanced for s in states),
        law="coulomb",
        coupled=state.friction_changes_loads,
        screw_coefficient=friction.screw,
        nut_coefficient=friction.nut,
        turns=solved.motion.turns,
        speed=solved.motion.speed,
        balls=output.balls_with_friction(result, state),
        drag_unknown=drag_unknown or None,
        drag_note=drag_note or None,
        over=tuple(over),
        by_contact=output.losses_by_contact_and_cause(state, curved),
        loss_between_balls=0.0 if state.neighbour_friction is None else state.neighbour_friction.power_lost_between_balls,
        slip=slip,
        load_power=e.axial_load * e.advance_per_radian * e.speed,
        torque_power=e.driving_torque_on_screw * e.speed,
        torque_without_feedback=state.sums_without_feedback.friction_torque,
        unsettled_balls=len(state.unsettled_balls),
        axial_friction=e.axial_friction_on_screw,
        touching=output.ball_to_ball_forces(state),
        friction_over_load=e.cross_groove_friction_ratio,
        residual=result.solver.residual,
        imbalance=state.ball_friction.largest_imbalance_ratio,
        change=state.change,
        jammed_balls=None if state.jammed_balls is None else tuple(k + 1 for k in state.jammed_balls),
        assumed=(*friction.assumed, *(() if scene.motion else (NO_SPEED,)), *of_loads),
        left_out=tuple(output.effects_neglected_at_one_instant(friction)),
        warnings=(
            *(() if play is None else (play_warning(play),)),
            *output.friction_warnings(scene, friction, state, warnings),
        ),
        keys=KEYS,
    )
