"""``rollbench friction``: whole screws and bearings, shafts with several of them, and single parts.

For a shaft with several nuts and bearings, the friction of each of them and the torque of the shaft are computed. The load
cases of a duty cycle are solved as separate scenes, and the mean torque over all revolutions is added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rollbench.compare.case import brought_by_cases
from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.models.friction_sums import friction_torques
from rollbench.compare.models.friction_torques import FrictionTorques
from rollbench.compare.models.load_cases import motor_torques_and_inertias
from rollbench.compare.models.loading import absolute_axial_preload
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.set_results import SetResult as ResultOfSet
from rollbench.compare.results import friction as records
from rollbench.compare.results.friction import FrictionCases, FrictionOfRollers, FrictionOfSet
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.scenes.scene_file import kind_of_scene
from rollbench.compare.studies.friction import answer
from rollbench.compare.studies.friction import whole as friction_whole
from rollbench.lowfi.friction.whole.state import FrictionCase, FrictionState, friction_states
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Friction, Motion, Scene


def solve_friction_of_named_scene(name: str, choices: friction_whole.FrictionChoices) -> records.Friction:
    """Compute the friction of a scene that is given by its name in the package or by its file.

    Parameters
    ----------
    name
        Name or file of the scene.
    choices
        Model, coefficients of friction and number of the specimen (draw of random errors).

    Returns
    -------
    Friction
        Torques, losses and motion of the balls.

    Raises
    ------
    InputError
        If the scene cannot be read, or the choices do not fit it.
    """
    return solve_friction_of_scene(catalogue.scene_of_any_kind(name), choices, name)


def solve_friction_of_scene(scene: Described, choices: friction_whole.FrictionChoices, origin: str) -> records.Friction:
    """Compute the friction of a scene of any kind.

    Parameters
    ----------
    scene
        Scene of a screw, bearing, shaft, duty cycle or of single parts.
    choices
        Model, coefficients of friction and number of the specimen (draw of random errors).
    origin
        Name or file of the scene, for an error message.

    Returns
    -------
    Friction
        Torques, losses and motion of the balls.

    Raises
    ------
    InputError
        If the choices do not fit the scene.
    """
    if isinstance(scene, Scene):
        return friction_whole.solve_friction_of_screw_or_bearing(scene, choices)
    if isinstance(scene, DutyCycle):
        return solve_friction_of_duty_cycle(scene, choices)
    if isinstance(scene, Assembly):
        return solve_friction_of_shaft(scene, choices)
    if choices != friction_whole.FrictionChoices():
        advice = (
            "leave these arguments out: a scene of single balls, two bearings or a screw over time states its loads and "
            "coefficients of friction"
        )
        given = f"at least one of these arguments for {origin}"
        raise ArgumentError("model, mu, member, condensed", given, "these only for a whole screw, bearing or shaft", advice)
    found: records.Friction = brought_by_cases("friction")[scene.kind](scene)
    return found


#: Note if the scene states no coefficient of friction for its balls.
NO_COEFFICIENT = "No coefficient of friction is given: torques of bearings are those of the formulas."

#: Keys of the torques of a shaft, in the order of the JSON.
SHAFT_KEYS = (
    "friction_torque_Nmm",
    "reverse_friction_torque_Nmm",
    "drag_torque_Nmm",
    "driving_torque_on_screw_Nmm",
    "forward_torque_Nmm",
    "backward_torque_Nmm",
    "efficiency_forward_percent",
    "efficiency_backward_percent",
)

#: First keys of the JSON of a shaft.
HEAD = ("scene", "title", "kind", "model", "status", "converged")

#: Keys of the JSON of a shaft.
KEYS = (
    *(*HEAD, "law", "friction.screw", "friction.nut", "motion.turns", "motion.speed_rad_s", "sets", "balls"),
    *(f"torque.{key}" for key in SHAFT_KEYS),
    *("drive", "band", "losses.total_W", "losses.by_contact_W", *answer.BALANCE_KEYS),
    *("energy.axial_load_power_W", "energy.torque_power_W", "energy.efficiency_percent"),
    *friction_whole.REMARKS,
)

#: Nuts and ball bearings of a shaft: number from 0, static result and friction.
SolvedSets = list[tuple[int, SetResult, FrictionState]]


def solve_friction_of_shaft(assembly: Assembly, choices: friction_whole.FrictionChoices) -> records.Friction:
    """Compute the friction of every nut and ball bearing on a shaft, and the torque that turns the shaft.

    ``choices``: model, coefficients of friction and number of the specimen (draw of random errors). Raises InputError
    for choices that do not fit the scene.
    """
    if choices.condensed is not None:
        allowed = "this file only for a scene with a single nut or bearing"
        raise ArgumentError("condensed", str(choices.condensed), allowed, "leave `condensed` out")
    pairs = _friction_coefficients_of_shaft(assembly, choices.mu)
    motion = assembly.motion or ONE_TURN
    if motion.turns != "screw":
        raise InputError(
            assembly.name, "motion.turns", '"nut"', '"screw"', "let the shaft turn: its nuts and housings stand still"
        )
    options = ModelOptions(member=choices.member)
    answers = solve_with_results(assembly, choices.model, options, drives=False)
    result = answers.solution
    assert isinstance(result, AxisResult)
    head: dict[str, Any] = {"scene": assembly.name, "title": assembly.title, "kind": assembly.kind, "model": result.model}
    if not answers.converged:
        status, keys = f"contact loads: {result.status}", (*HEAD, *friction_whole.REMARKS)
        return records.Friction(**head, reason=status, converged=False, assumed=assembly.assumed, keys=keys)
    each = _friction_of_nuts_and_bearings(result, pairs, motion) if pairs else [[]]
    drag = _drag_torques_of_nuts_and_bearings(assembly, result, pairs[0], motion) if pairs else {}
    friction, solved, sets = pairs[0] if pairs else Friction(0.0, 0.0), each[0], answers.sets
    rubbing = {
        s.of.name: replace(sets[s.of.name], friction=FrictionTorques(**friction_torques(x.friction_sums)))
        for _, s, x in solved
        if x.all_balanced
    }
    drive = motor_torques_and_inertias(assembly, {**sets, **rubbing})
    of_sets = tuple(
        FrictionOfSet(
            set=i + 1, name=s.of.name, loss=x.friction_sums.power, **friction_torques(x.friction_sums, drag.get(i))
        )
        for i, s, x in solved
    )
    balls = tuple(
        ball for i, s, x in solved if s.balls is not None for ball in answer.balls_with_friction(s.balls, x, i + 1)
    )
    losses = (answer.losses_by_contact_and_cause(state, number=i + 1) for i, _, state in solved)
    failed = next((x for x in solved if not x[2].all_balanced), None)
    imbalance = [x.ball_friction.largest_imbalance_ratio for _, _, x in solved]
    of_rollers = tuple(f"{s.of.name}: " for s in result.sets if s.balls is None)  # whose loads friction leaves as they are
    warnings = [w for w in result.warnings if w.startswith(of_rollers)]
    warnings += answer.warnings_without_pressure_and_size([w for w in result.warnings if not w.startswith(of_rollers)])
    for _, s, state in solved:
        if isinstance(s.of.parts, Scene):
            warnings += [w.with_part_name(s.of.name) for w in answer.friction_warnings(s.of.parts, friction, state, ())]
    rollers = tuple(
        FrictionOfRollers(set=i, name=name, torque=x.torque)
        for i, (name, x) in enumerate(sets.items(), 1)
        if x.torque is not None
    )
    over = tuple(
        records.FrictionAtCoefficients(screw=f.screw, nut=f.nut, keys=SHAFT_KEYS, **_torques_of_shaft(states, {}))
        for f, states in zip(pairs, each if pairs else (), strict=True)
    )
    return records.Friction(
        **head,
        **_torques_of_shaft(solved, drag),
        **_powers_of_shaft(solved),
        reason="converged" if failed is None else f"{failed[1].of.name}: {friction_whole.friction_status(failed[2])}",
        converged=failed is None,
        law="coulomb",
        screw_coefficient=friction.screw,
        nut_coefficient=friction.nut,
        turns=motion.turns,
        speed=motion.speed,
        by_contact=tuple(row for rows in losses for row in rows),
        residual=result.solver.residual,
        imbalance=max(imbalance, default=0.0),
        roller_torques=rollers,
        sets=of_sets,
        balls=balls,
        drive=drive,
        band=_drag_torque_of_nuts_by_makers_formula(assembly, sets),
        assumed=(
            *friction.assumed,
            *(() if assembly.motion else (friction_whole.NO_SPEED,)),
            *assembly.assumed,
            *(f"contact loads: {x}" for x in result.assumed if x not in assembly.assumed),
            *(() if solved else (NO_COEFFICIENT,)),
        ),
        left_out=tuple(answer.effects_neglected_at_one_instant(friction) if solved else ()),
        warnings=tuple(warnings),
        over=over,
        keys=(*KEYS, *(("roller_torques",) if rollers else ()), *(("over_friction",) if pairs else ())),
    )


def _friction_coefficients_of_shaft(assembly: Assembly, mu: Sequence[float]) -> list[Friction]:
    """Return the coefficients of friction for which a shaft is solved: those in ``mu``, else those of the scene.

    ``mu``: coefficients that replace those of the scene; empty: none. The list is empty for a shaft without nuts if neither
    ``mu`` nor the scene has a coefficient. Raises InputError for a nut without coefficient, and if a coefficient is given
    for a shaft without balls.
    """
    balls = [s.parts for s in assembly.sets if isinstance(s.parts, Scene)]
    if not mu and (not balls or (assembly.friction is None and not any(parts.track.lead for parts in balls))):
        return []
    if not balls:
        given = f"{', '.join(f'{x:g}' for x in mu)} for a shaft without balls"
        allowed = "a shaft with a ball nut or ball bearing"
        raise ArgumentError("mu", given, allowed, "leave `mu` out: all bearings have rollers")
    return friction_whole.friction_coefficients(replace(balls[0], name=assembly.name, friction=assembly.friction), mu)


def _friction_of_nuts_and_bearings(result: AxisResult, frictions: Sequence[Friction], motion: Motion) -> list[SolvedSets]:
    """Compute the friction of every nut and ball bearing on a shaft; return number, static result and friction of each.

    The result has an entry for each of ``frictions``, coefficients of friction. Numbers count nuts and bearings from 0.
    ``result``: static solution of the shaft; ``motion``: motion of the shaft.
    """
    sets = [(i, s, s.of.parts, s.balls) for i, s in enumerate(result.sets)]
    of_balls = [(i, s, parts, balls) for i, s, parts, balls in sets if balls is not None and isinstance(parts, Scene)]
    cases = [FrictionCase(parts, balls, f, motion, result.member) for f in frictions for _, _, parts, balls in of_balls]
    states = iter(friction_states(cases))
    return [[(i, s, next(states)) for i, s, *_ in of_balls] for _ in frictions]


def _drag_torques_of_nuts_and_bearings(
    assembly: Assembly, loaded: AxisResult, friction: Friction, motion: Motion
) -> dict[int, float]:
    """Return the friction torques [N m] of nuts and ball bearings on an unloaded shaft, by number of the nut or bearing.

    All loads on shaft and housings are removed. ``loaded``: static solution under the loads; the solution without loads
    uses the same model. Nuts and bearings without a solution are left out.
    """
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in assembly.housings)
    bare = replace(assembly, loads=(), housings=idle)
    result = run_model(bare, loaded.model, ModelOptions(member=loaded.member))
    if not result.converged:
        return {}
    (states,) = _friction_of_nuts_and_bearings(result, [friction], motion)
    return {i: state.friction_sums.friction_torque for i, _, state in states if state.all_balanced}


def _drag_torque_of_nuts_by_makers_formula(
    assembly: Assembly, sets: Mapping[str, ResultOfSet]
) -> records.FrictionBand | None:
    """Return preload and drag torque, by the makers' formula, of all nuts that are braced against each other on a shaft.

    Each nut of a pair presses with the preload, which the formula counts once for both. ``sets``: results of nuts and
    bearings by name. Returns None without such nuts.
    """
    halves = [
        (s.parts, 0.5 * absolute_axial_preload(sets[s.name].preload))
        for s in assembly.sets
        if isinstance(s.parts, Scene) and s.parts.track.lead > 0.0
    ]
    preload = sum(half for _, half in halves)
    if preload == 0.0:
        return None
    makers = sum(friction_whole.drag_torque_by_makers_formula(parts, half) for parts, half in halves)
    return records.FrictionBand(
        coefficients=friction_whole.MEASURED, torque=None, drag_torque=None, preload=preload, makers=makers
    )


def _powers_of_shaft(solved: SolvedSets) -> dict[str, Any]:
    """Return input power, losses and further powers [W], summed over nuts and ball bearings of a shaft, and the efficiency.

    Powers are input power and friction loss of the contacts, power of the driving torque, and power of the axial loads. The
    efficiency is None unless the torque does work against the axial loads, or the axial loads do work against the torque.
    They are fields of `Friction`.
    """
    torques = [x.friction_sums for _, _, x in solved]
    turning = float(np.sum([t.driving_torque_on_screw * t.speed for t in torques]))
    along = float(np.sum([t.axial_load * t.advance_per_radian * t.speed for t in torques]))
    taken = float(np.sum([t.input_power for t in torques]))
    driving, driven = max(turning, along), min(turning, along)
    return answer.power_balance(taken, float(sum(t.power for t in torques))) | {
        "load_power": along,
        "torque_power": turning,
        "power_efficiency": -100.0 * driven / driving if driven < -answer.NOTHING * driving else None,
    }


def _torques_of_shaft(solved: SolvedSets, drag: dict[int, float]) -> dict[str, Any]:
    """Return friction, drag and driving torques of all nuts and ball bearings of a shaft, and their efficiencies.

    They are fields of `FrictionTorques`. Torques in both senses of rotation are those of the contacts: the frictionless
    torque of all axial loads, and friction. ``solved``: nuts and ball bearings with their friction; ``drag``: friction
    torques without loads [N m] by number of the nut or bearing. The sum of the drag torques is None unless all are known.
    """
    torques = [x.friction_sums for _, _, x in solved]
    known = len(drag) == len(solved)
    rubs = float(np.sum([t.friction_torque for t in torques]))
    reverse = float(np.sum([t.reverse_power / abs(t.speed) for t in torques]))
    moved = float(np.sum([t.advance_per_radian * t.axial_load for t in torques]))  # by the axial loads, about -z
    frictionless, size = abs(moved), sum(abs(t.advance_per_radian * t.axial_load) for t in torques)
    with_load = bool(torques) and moved * torques[0].speed > 0.0
    against, back = (reverse, rubs) if with_load else (rubs, reverse)
    loaded = frictionless > answer.NOTHING * size
    return {
        "torque": rubs,
        "reverse_torque": reverse,
        "drag_torque": float(sum(drag.values())) if known else None,
        "driving_torque_on_screw": float(np.sum([t.driving_torque_on_screw for t in torques])),
        "forward_torque": frictionless + against if loaded else None,
        "backward_torque": frictionless - back if loaded else None,
        "efficiency_forward": frictionless / (frictionless + against) if loaded else None,
        "efficiency_backward": (frictionless - back) / frictionless if loaded and back < frictionless else None,
    }


def solve_friction_of_duty_cycle(cycle: DutyCycle, choices: friction_whole.FrictionChoices) -> records.Friction:
    """Compute the friction of every load case of a duty cycle, and the mean friction torque over all revolutions.

    The mean torque is the work of friction in all revolutions divided by their angle. If a load case does not converge, the
    results of the other load cases are returned without a mean torque. Raises InputError for inputs for which
    `solve_friction_of_screw_or_bearing` or `solve_friction_of_shaft` raises it.
    """
    answers = [solve_friction_of_scene(case.scene, choices, cycle.name) for case in cycle.cases]
    each = [
        replace(one, scene=cycle.name, case=case.name, share=case.share, keys=("case", "share", *one.keys))
        for case, one in zip(cycle.cases, answers, strict=True)
    ]
    failed = [one.case for one in each if not one.converged]
    known = [(one.torque, one.case) for one in each if one.torque is not None]
    worst = max(known, key=lambda row: abs(row[0]), default=(None, None))
    turned = [(one.share or 0.0, one.torque if one.converged else None) for one in each if one.share]
    mean = None if any(torque is None for _, torque in turned) else sum(share * (torque or 0.0) for share, torque in turned)
    words = "" if mean is not None else f"none, because case {failed[0]} has no friction" if failed else "no load"
    return records.Friction(
        scene=cycle.name,
        title=cycle.title,
        kind=kind_of_scene(cycle),
        reason="; ".join(f"case {one.case}: {one.reason}" for one in each if not one.converged) or "converged",
        converged=not failed,
        together=FrictionCases(largest=worst[0], case=worst[1], mean=mean, words=words or None),
        cases={str(one.case): one for one in each},
        assumed=tuple(dict.fromkeys(line for one in each for line in one.assumed)),
        left_out=tuple(dict.fromkeys(line for one in each for line in one.left_out)),
        warnings=tuple(w.with_part_name(f"case {one.case}") for one in each for w in one.warnings),
        keys=("scene", "title", "kind", "status", "converged", "summary", "cases", *friction_whole.REMARKS),
    )
