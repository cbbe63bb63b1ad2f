"""Fields of the records of friction that several kinds of scene share, neglected effects, and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.quantities import json_number
from rollbench.compare.results.friction import BallsTouching, FlankLosses, Friction, FrictionBall
from rollbench.lowfi.friction.whole.feedback import JAMMED
from rollbench.lowfi.friction.whole.losses import CAUSES, BallFriction
from rollbench.lowfi.friction.whole.state import FrictionState
from rollbench.lowfi.rating.catalogue_checks import warn_of_overall_friction_coefficient
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.validity import contact_warnings
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.parts import Friction as Coefficients

if TYPE_CHECKING:
    from rollbench.compare.scenes.duty_cycle import FrictionScene


LUBRICANT = "lubricant: film thickness, churning, and a coefficient that depends on speed, slip and temperature"

HYSTERESIS = "rolling hysteresis of the materials"

PARTS = "cage or spacers, return tube or deflectors, wipers and seals"

INERTIA = "gyroscopic moments and centrifugal forces of the balls"

#: Effects that the result of a whole screw or bearing at one instant neglects.
WHOLE = (
    "feedback of friction on how the balls share the load: each keeps the load that it carries without friction",
    LUBRICANT,
    HYSTERESIS,
    "Heathcote slip over curved contacts, in torques and efficiencies; the losses with it stand beside those without",
    PARTS,
    INERTIA,
    "ripple: the work of loads that change as balls roll over errors, and enter and leave the loaded track",
    "torques of a second, jammed state of a ball, which may exist at high coefficients of friction (seen from 0.3 on)",
)

#: Further effects neglected at one instant, by two Booleans: whether friction moves the balls, and whether neighbouring
#: balls push each other.
BESIDES = {
    (False, False): ("movement of a ball across its grooves by friction", "contact between balls at the scene's instant"),
    (True, False): ("contact between balls at the scene's instant",),
    (False, True): (
        "movement of a ball across its grooves by friction and by forces between balls",
        "forces between balls in the balance of contact loads",
    ),
    (True, True): (
        "movement of a ball across its grooves by forces between balls, and by the friction that they cause",
        "forces between balls in the balance of contact loads",
    ),
}

#: Effects that are neglected for every kind of scene.
_KINDS = (
    LUBRICANT,
    HYSTERESIS,
    "Heathcote slip over the curved contact, which counts where contacts are wide or contact angles small",
    PARTS,
    INERTIA,
    "yielding: contacts are elastic at every pressure",
    "elastic bodies: screw, shaft, nut and rings are rigid but for Hertz's contacts",
)

#: Neglected effects that several kinds of scene share.
_LOADS_GIVEN = "friction in the balance of loads: the contacts carry the loads that they carry without friction"

_FEW = "the other balls of the track, and how all of them share the load"

_INSTANT = "time: one instant, whose ball motions are steady"

_JAMMED = "a second, jammed state of a ball, which may exist at high coefficients of friction"

#: Further neglected effects of a screw, by the scene's word for the balance of loads that includes friction.
_COUPLING = {
    "none": (_LOADS_GIVEN,),
    "ball": ("friction in the balance of loads on the screw: friction moves the balls only",),
    "ball and screw": (),
}

#: Further neglected effects by the kind of the scene.
_OF_KIND = {
    "bearing ball": (_LOADS_GIVEN, _FEW, _INSTANT, "tilt of the rings"),
    "bearing pair": (
        _LOADS_GIVEN,
        "contact between balls",
        "time: one position of the balls at every load angle",
        "geometric errors but for clearance",
    ),
    "linear pair": (_LOADS_GIVEN, _FEW, _INSTANT),
    "linear chain": (_LOADS_GIVEN, "the ends of the loaded zone and the return: balls that enter and leave", _INSTANT),
    "screw pair": (_FEW, _INSTANT, _JAMMED),
    "screw run": (
        "geometric errors but for the deviations of contact angles and the oversize that the scene gives",
        "run-in of the grooves, and balls in the return: they roll along without load",
        "inertia of the balls: every instant is steady",
        _JAMMED,
    ),
}


# --- fields of records


#: Ratio of the dissipation to that of full sliding, below which the dissipation is round-off or an effect of the
#: regularised friction law.
NOTHING = 1e-6

#: Relative difference between two computations of a loss that counts as round-off.
ROUND_OFF = 1e-9


def friction_of_parts(
    kind: type[Parts], scene: FrictionScene, status: str, converged: bool, keys: Sequence[str], **fields: Any
) -> Parts:
    """Return the friction of single parts, with the names, status and neglected effects that all kinds of them have.

    ``kind``: class of the record; ``status``: "converged", or why not; ``converged``: whether loads and friction converged;
    ``keys``: further keys of the JSON; ``fields``: further fields.
    """
    coupling = fields.get("coupling")  # of a screw: which balance of loads includes friction
    return kind(
        scene=scene.name,
        title=scene.title,
        kind=scene.kind,
        reason=status,
        converged=converged,
        assumed=tuple(scene.assumed),
        left_out=(*_OF_KIND[scene.kind], *(_COUPLING[coupling] if coupling else ()), *_KINDS),
        keys=(*_HEAD_OF_PARTS, *keys, "warnings"),
        **fields,
    )


#: Class of a record of the friction of single parts.
Parts = TypeVar("Parts", bound=Friction)

#: First keys of the JSON of single parts.
_HEAD_OF_PARTS = ("scene", "title", "kind", "status", "converged", "assumed", "left_out")


def contact_values(sides: Sequence[str], values: Array) -> dict[str, Any]:
    """Return values at the n contacts of a ball by the names of the contacts; None for a value that is not finite.

    ``sides``: names of the contacts; ``values``: a number or a vector for each contact, (n,) or (n, k).
    """
    return {
        side: [json_number(v) for v in x] if np.ndim(x) else json_number(x) for side, x in zip(sides, values, strict=True)
    }


def ball_loads(sides: Sequence[str], force: Array, angle: Array) -> dict[str, Any]:
    """Return contact loads and angles of a ball as fields of `FrictionBall`; the angle of a contact without load is None.

    ``sides``: names of the n contacts; ``force``: contact loads (n,) [N]; ``angle``: contact angles (n,) [rad].
    """
    return {"load": contact_values(sides, force), "angle": contact_values(sides, np.where(force > 0.0, angle, np.nan))}


#: Keys of the contact loads and of the motion of a ball, and of sliding and friction at its contacts.
LOAD_KEYS = ("load_N", "contact_angle_deg")
MOTION_KEYS = ("orbit_rad_s", "rotation_rad_s")
CONTACT_KEYS = ("sliding_mm_s", "spin_rad_s", "friction_N", "moment_Nmm", "loss_mW", "at_rest")


def ball_motion(ball_speeds: Array) -> dict[str, Any]:
    """Return the orbital speed and the rotation of a ball as fields of `FrictionBall`; None for a speed that is not known.

    ``ball_speeds``: orbital speed of the ball, then its angular velocity about the axes x, y, z, (4,) [rad/s].
    """
    return {"orbit": json_number(ball_speeds[0]), "rotation": [json_number(w) for w in ball_speeds[1:]]}


def sliding_and_friction(
    sides: Sequence[str], motion: Array, force: Array, moment: Array, loss: Array, rest: Mask
) -> dict[str, Any]:
    """Return sliding, friction force and moment, and losses at a ball's contacts as fields of `FrictionBall`.

    ``sides``: names of the n contacts; ``motion``: sliding velocity across and along the groove [m/s], then spin
    [rad/s], (n, 3); ``force``: friction force across and along the groove (n, 2) [N]; ``moment``: friction moment about
    the contact normal (n,) [N m]; ``loss``: dissipation (n,) [W]; ``rest``: whether each contact sticks (n,).
    """
    return {
        "sliding": contact_values(sides, motion[:, :2]),
        "spin": contact_values(sides, motion[:, 2]),
        "force": contact_values(sides, force),
        "moment": contact_values(sides, moment),
        "loss": contact_values(sides, loss),
        "at_rest": {s: bool(r) for s, r in zip(sides, rest, strict=True)},
    }


def zero_if_round_off(difference: float, magnitude: float) -> float:
    """Return the difference of two computed values; zero if the difference is no larger than round-off.

    ``difference``: the difference; ``magnitude``: magnitude of the two values, in the same unit. The limit is
    `ROUND_OFF` times ``magnitude``.
    """
    return 0.0 if abs(difference) <= ROUND_OFF * abs(magnitude) else difference


#: Keys of the balance of powers, without and with the difference in % of the loss.
BALANCE_KEYS = ("energy.input_power_W", "energy.loss_W", "energy.balance_W")
BALANCE_KEYS_WITH_PERCENT = (*BALANCE_KEYS, "energy.balance_percent")


def power_balance(power: float, loss: float) -> dict[str, Any]:
    """Return the fields of `Friction` on the balance of powers; a difference within round-off is zero.

    ``power``: input power [W]; ``loss``: friction loss [W].
    """
    return {"loss": loss, "input_power": power, "power_balance": zero_if_round_off(power - loss, loss)}


def power_balance_with_percent(power: float, loss: float, round_off: float) -> dict[str, Any]:
    """Return the fields of `power_balance`, and the difference in % of the loss.

    ``power``: input power [W]; ``loss``: friction loss [W]; ``round_off``: scale of the round-off, which is the loss
    that the contacts would have if all of them slid fully [W]. The percentage is None if ``loss`` is at most `NOTHING`
    times ``round_off``.
    """
    return power_balance(power, loss) | {"power_balance_percent": loss_increase_percent(power, loss, round_off)}


def loss_increase_percent(loss: float, reference_loss: float, round_off: float) -> float | None:
    """Return by how much a friction loss exceeds a reference loss, in % of the latter; zero if the difference is round-off.

    ``loss`` and ``reference_loss``: the two losses [W]; ``round_off``: scale of the round-off, which is the loss that the
    contacts would have if all of them slid fully [W]. None if ``reference_loss`` is at most `NOTHING` times ``round_off``.
    """
    if not reference_loss > NOTHING * round_off:
        return None
    change = zero_if_round_off(loss - reference_loss, reference_loss)
    return json_number(float(error_percent(reference_loss + change, reference_loss)))


def ball_to_ball_contact_effect(
    power: float, loss: float, loss_apart: float, loss_between_balls: float, full_sliding_loss: float
) -> dict[str, Any]:
    """Return the fields of `FrictionOfNeighbours` on how contact between balls changes the losses.

    ``power`` and ``loss``: input power and loss with balls that touch [W]; ``loss_apart``: loss with the balls far apart
    [W]; ``loss_between_balls``: the part of ``loss`` in the contacts between balls [W]; ``full_sliding_loss``: loss that
    the contacts would have if all of them slid fully [W], the scale of the round-off.
    """
    rubs = loss_apart > NOTHING * full_sliding_loss
    return {
        "loss_apart": loss_apart,
        "increase": loss_increase_percent(loss, loss_apart, full_sliding_loss),
        "between_balls_percent": 100.0 * loss_between_balls / loss_apart if rubs else None,
        "between_balls": loss_between_balls,
        **power_balance_with_percent(power, loss, full_sliding_loss),
    }


#: Keys of these fields.
CONTACT_EFFECT_KEYS = (
    *("loss_apart_W", "friction_increase_percent", "ball_to_ball_percent", "ball_to_ball_loss_W"),
    *BALANCE_KEYS_WITH_PERCENT,
)


def scene_word_for_hertz_constants(hertz: str) -> str:
    """Return the name of a kind of Hertz constants in scene files: "nominal" for the internal "right", else unchanged."""
    return "nominal" if hertz == "right" else hertz


def effects_neglected_at_one_instant(friction: Coefficients) -> list[str]:
    """Return sentences on the effects that are neglected in the friction of a whole screw or bearing at one instant.

    ``friction``: coefficients of friction, and whether friction moves the balls and neighbouring balls push each other.
    """
    return [*WHOLE, *BESIDES[friction.feedback, friction.neighbours]]


def sentence_on_jammed_states(state: FrictionState) -> str:
    """Return a sentence on whether balls have a second equilibrium with friction, in which they are jammed in the grooves.

    Such equilibria may exist at high coefficients of friction. ``state``: friction of the screw or bearing.
    """
    start = "at this coefficient of friction a ball may have a second, jammed state"
    if state.jammed_balls is None:
        why = "it takes friction that moves balls in grooves, feedback = true"
        if state.friction_sums.advance_per_radian == 0.0:
            why = "without lead friction runs along the grooves and moves no ball across them"
        return f"{start}; none was searched for: {why}"
    if not state.jammed_balls:
        return f"{start}; none was found from four displaced starts of every ball"
    numbers = ", ".join(str(k + 1) for k in state.jammed_balls[:8])
    what = "1 ball has" if len(state.jammed_balls) == 1 else f"{len(state.jammed_balls)} balls have"
    return f"{what} a second, jammed state: {numbers}; this is the one that rolls on"


def change_of_losses(flat: BallFriction | None, curved: BallFriction | None) -> float:
    """Return the ratio of the losses in curved contacts to those in flat ones, less 1; nan if one of them is not known.

    ``flat``, ``curved``: friction of the balls with flat and with curved contact ellipses.
    """
    if flat is None or curved is None or not (flat.converged and curved.converged and flat.total_power_lost > 0.0):
        return float("nan")
    return curved.total_power_lost / flat.total_power_lost - 1.0


def ball_to_ball_forces(state: FrictionState) -> BallsTouching | None:
    """Return the forces between touching balls and their effect on the friction torque.

    ``state``: friction of the screw or bearing. None if forces between neighbouring balls are not computed.
    """
    n, t = state.neighbour_friction, state.friction_sums
    if n is None:
        return None
    return BallsTouching(
        pairs=n.touching_pair_count,
        gap=n.smallest_gap,
        force=n.force_on_next_ball.tolist(),
        loss=n.power_lost_between_balls,
        torque_change=loss_increase_percent(t.power, state.sums_without_feedback.power, 0.0),
    )


#: Keys of a ball of a whole screw or bearing.
BALL_KEYS = ("index", "azimuth_deg", "z_mm", *LOAD_KEYS, *MOTION_KEYS, "closing_mm_s", *CONTACT_KEYS, "status")


def balls_with_friction(result: StaticResult, state: FrictionState, number: int | None = None) -> tuple[FrictionBall, ...]:
    """Return each ball: position, contact loads, motion, sliding and friction, and status of the friction.

    ``result``: static result; ``state``: friction of the balls; ``number``: number of the nut or bearing on a shaft, from
    1. The axes x and z of a contact lie across and along its groove.
    """
    at, f, q = state.contacts, state.ball_friction, state.ball_friction.ball_motions
    return tuple(
        FrictionBall(
            set=number,
            index=i + 1,
            closing=json_number(state.closing_speeds[i]),
            **ball_motion(q[i]),
            **sliding_and_friction(
                SIDES, f.contact_motions[i], f.force[i], f.moment[i], f.loss[i].sum(axis=1), f.sticking_contacts[i]
            ),
            azimuth=result.azimuth[i],
            z=result.z[i],
            **ball_loads(SIDES, at.force[i], at.angle[i]),
            status=f.status[i],
            keys=BALL_KEYS if number is None else ("set", *BALL_KEYS),
        )
        for i in range(at.force.shape[0])
    )


def losses_by_contact_and_cause(
    state: FrictionState, curved: BallFriction | None = None, number: int | None = None
) -> tuple[FlankLosses, ...]:
    """Return the friction losses, summed over all balls: one record for each flank, and one for all flanks.

    Each has the mean load of the balls that carry load, with and without friction, the loss and its parts by cause (sliding
    across the groove, sliding along it, spin), and the loss in contacts that are curved across the groove. ``state``:
    friction of the screw or bearing; ``curved``: friction of its balls with curved contacts, None if it is not known;
    ``number``: number of the nut or bearing on a shaft, from 1.
    """
    table = state.ball_friction.loss.sum(axis=0)
    bent = np.full(4, np.nan) if curved is None or not curved.converged else curved.loss.sum(axis=(0, 2))
    loads = [mean_flank_loads(force) for force in (state.contacts.force, state.loads_without_friction)]
    named = [*zip(SIDES, *loads, table, bent, strict=True), ("sum", None, None, table.sum(axis=0), bent.sum())]
    return tuple(
        FlankLosses(
            number,
            name,
            load,
            bare,
            row.sum(),
            **dict(zip(CAUSES, row, strict=True)),
            curved=None if curved is None else of,
        )
        for name, load, bare, row, of in named
    )


def mean_flank_loads(force: Array) -> Array:
    """Return the mean load of each flank over the balls that carry load ``(4,)`` [N]; 0 if none does.

    ``force``: contact loads of N balls ``(N, 4)`` [N].
    """
    loaded = force.sum(axis=1) > 0.0
    return force[loaded].mean(axis=0) if loaded.any() else np.zeros(4)


def warnings_without_pressure_and_size(warnings: Sequence[ResultWarning]) -> list[ResultWarning]:
    """Return those of several warnings on a static result that concern neither contact pressure nor contact size.

    Pressure and size are checked again after the friction is computed, because friction changes the contact loads.
    """
    return [w for w in warnings if w.kind not in ("pressure", "size")]


def friction_warnings(
    scene: Scene, friction: Coefficients, state: FrictionState, static: Sequence[ResultWarning]
) -> list[ResultWarning]:
    """Return warnings on a friction result, and those on the static contact loads that still apply.

    ``friction``: coefficients of friction; ``state``: the friction result; ``static``: warnings on the static contact
    loads. Of these, the warnings on pressure and size of contacts are replaced by new ones, because friction changes
    the contact loads.
    """
    at = state.contacts
    loaded = at.force > 0.0
    notes = warnings_without_pressure_and_size(static)
    notes += warn_of_overall_friction_coefficient(scene.track, friction)
    notes += contact_warnings(np.where(loaded, at.pressure, 0.0), np.where(loaded, at.a, 0.0), scene.balls.radius)
    if max(friction.screw, friction.nut) >= JAMMED:
        notes.append(ResultWarning("jam" if state.jammed_balls else "jam search", sentence_on_jammed_states(state)))
    two = (loaded.sum(axis=1) == 2) & (state.ball_friction.total_power_lost > 0.0)
    sums = state.friction_sums
    if two.any() and sums.advance_per_radian != 0.0 and not state.friction_changes_loads:
        text = (
            f"{int(two.sum())} balls touch two flanks only: friction pushes them across the groove, up to "
            f"{sums.cross_groove_friction_ratio:.2g} of their load, onto other contact angles or a third flank; without "
            "feedback the friction torque may be too small by a factor of two or more"
        )
        brief = f"friction torque without feedback, which {int(two.sum())} balls on two flanks only have"
        notes.append(ResultWarning("feedback", text, brief))
    unsure = state.ball_friction.status.count("regularised")
    if unsure:
        text = f"{unsure} balls have a contact on the verge of slip: their friction balances to 1e-6 only"
        notes.append(ResultWarning("balance of slip", text))
    return notes
