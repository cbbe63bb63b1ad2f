"""Results of ``rollbench friction``: records, tables and lines for the terminal, and neglected effects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.friction_sums import friction_results_json, motion_relative_to_load
from rollbench.compare.quantities import json_number
from rollbench.compare.results import data as records
from rollbench.compare.results.data import FrictionBall
from rollbench.compare.text.printing import Column
from rollbench.lowfi.friction.whole.feedback import JAMMED
from rollbench.lowfi.friction.whole.losses import CAUSES, BallFriction
from rollbench.lowfi.friction.whole.state import FrictionState
from rollbench.lowfi.friction.whole.torque import FrictionSums
from rollbench.lowfi.rating.catalogue_checks import warn_of_overall_friction_coefficient
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.validity import contact_warnings
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.parts import SIDES, Friction, Motion, Scene

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


def neglected_effects_of_kind(kind: str, coupling: str | None = None) -> list[str]:
    """Return sentences on physical effects that the friction results of single parts (balls, one bearing) neglect.

    ``kind``: kind of the scene, such as "bearing ball"; ``coupling``: for a screw, which balance of loads includes
    friction: "none", "ball" (of the ball) or "ball and screw" (of both), as in the scene file; None for other kinds.
    """
    return [*_OF_KIND[kind], *(_COUPLING[coupling] if coupling else ()), *_KINDS]


# --- records and JSON values of an answer


#: Ratio of the dissipation to that of full sliding, below which the dissipation is round-off or an effect of the
#: regularised friction law.
NOTHING = 1e-6

#: Text line that the terminal shows: label and text.
Line = tuple[str, str]

#: Labels of text lines that the terminal always shows.
ALWAYS = ("touch",)

#: Labels of the text lines on the unbalanced forces of the solver and on the friction law, which --verbose shows.
BEHIND = ("solver", "law")

#: Relative difference between two computations of a loss that counts as round-off.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class FrictionAnswer:
    """Friction of one scene with the tables and text lines in which the terminal shows it."""

    #: The friction.
    record: records.Friction
    #: Tables for the terminal, each with its title, columns and rows.
    tables: Sequence[tuple[str, Sequence[Column], Sequence[dict[str, Any]]]] = ()
    #: Text lines for the terminal, each with its label and text.
    lines: Sequence[Line] = ()
    #: Tables for the terminal with a row for each ball, each with its title, columns and rows; shown on request.
    ball_tables: Sequence[tuple[str, Sequence[Column], Sequence[dict[str, Any]]]] = ()

    @property
    def text(self) -> str:
        """All text lines of the terminal as one text, each with its label if it has one."""
        return "\n".join(f"{label}: {text}" if label else text for label, text in self.lines)


def from_fields(*keys: str) -> dict[str, Any]:
    """Return entries of the JSON whose values are those of the record's fields with these keys."""
    return dict.fromkeys(keys, ...)


def friction_of_parts(
    scene: FrictionScene, status: str, converged: bool, entries: dict[str, Any], coupling: str | None = None, **fields: Any
) -> records.Friction:
    """Return the friction of single parts, with the names, status and neglected effects that all kinds of them have.

    ``status``: "converged", or why not; ``converged``: whether loads and friction converged; ``entries``: further entries
    of the JSON; ``coupling``: for a screw, which balance of loads includes friction, see `neglected_effects_of_kind`; None
    for other kinds of scenes; ``fields``: further fields.
    """
    return records.Friction(
        scene=scene.name,
        title=scene.title,
        kind=scene.kind,
        reason=status,
        converged=converged,
        assumed=tuple(scene.assumed),
        left_out=tuple(neglected_effects_of_kind(scene.kind, coupling)),
        entries=_HEAD_OF_PARTS | entries | from_fields("warnings"),
        **fields,
    )


#: First entries of the JSON of single parts.
_HEAD_OF_PARTS = from_fields("scene", "title", "kind", "status", "converged", "assumed", "left_out")


def format_three_digits(value: float) -> str:
    """Return a value as text with three significant digits, without exponent below a million."""
    return f"{float(f'{value:.3g}'):g}"


def contact_values_json(sides: Sequence[str], values: Array) -> dict[str, Any]:
    """Return values at the n contacts of a ball as a JSON object, by the names of the contacts.

    ``sides``: names of the contacts; ``values``: a number or a vector for each contact, (n,) or (n, k).
    """
    return {
        side: [json_number(v) for v in x] if np.ndim(x) else json_number(x) for side, x in zip(sides, values, strict=True)
    }


def ball_loads_json(sides: Sequence[str], force: Array, angle: Array) -> dict[str, Any]:
    """Return a ball's contact loads and contact angles as JSON; the angle of a contact without load is null.

    ``sides``: names of the n contacts; ``force``: contact loads (n,) [N]; ``angle``: contact angles (n,) [rad].
    """
    loaded = np.where(force > 0.0, np.degrees(angle), np.nan)
    return {"load_N": contact_values_json(sides, force), "contact_angle_deg": contact_values_json(sides, loaded)}


#: Keys of the motion of a ball, and of sliding and friction at its contacts.
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
        "sliding": contact_values_json(sides, motion[:, :2]),
        "spin": contact_values_json(sides, motion[:, 2]),
        "force": contact_values_json(sides, force),
        "moment": contact_values_json(sides, moment),
        "loss": contact_values_json(sides, loss),
        "at_rest": {s: bool(r) for s, r in zip(sides, rest, strict=True)},
    }


def terminal_ball_row(sides: Sequence[str], row: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a ball in a table of the terminal, with a column for each contact load and rotation component.

    ``sides``: names of the contacts; ``row``: JSON row of the ball.
    """
    flat = row | {f"{side} N": row["load_N"][side] for side in sides}
    return flat | {f"omega {n}": w for n, w in zip("xyz", row["rotation_rad_s"], strict=True)}


def zero_if_round_off(difference: float, magnitude: float) -> float:
    """Return the difference of two computed values; zero if the difference is no larger than round-off.

    ``difference``: the difference; ``magnitude``: magnitude of the two values, in the same unit. The limit is
    `ROUND_OFF` times ``magnitude``.
    """
    return 0.0 if abs(difference) <= ROUND_OFF * abs(magnitude) else difference


def power_balance(power: float, loss: float) -> dict[str, Any]:
    """Return entries of the JSON: input power, friction loss (a field of the record) and their difference.

    ``power``: input power [W]; ``loss``: friction loss [W]. The JSON value of a difference within round-off is zero.
    """
    left = json_number(zero_if_round_off(power - loss, loss))
    return {"energy.input_power_W": json_number(power), "energy.loss_W": ..., "energy.balance_W": left}


def power_balance_with_percent(power: float, loss: float, round_off: float) -> dict[str, Any]:
    """Return the entries of `power_balance`, and the difference in % of the loss.

    ``power``: input power [W]; ``loss``: friction loss [W]; ``round_off``: scale of the round-off, which is the loss
    that the contacts would have if all of them slid fully [W]. The percentage is null if ``loss`` is at most `NOTHING`
    times ``round_off``.
    """
    return power_balance(power, loss) | {"energy.balance_percent": loss_increase_percent(power, loss, round_off)}


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
    """Return entries of the JSON: how the losses with touching neighbouring balls differ from those with balls far apart.

    ``power`` and ``loss``: input power and loss with balls that touch [W]; ``loss_apart``: loss with the balls far apart
    [W]; ``loss_between_balls``: the part of ``loss`` in the contacts between balls [W]; ``full_sliding_loss``: loss that
    the contacts would have if all of them slid fully [W], the scale of the round-off.
    """
    rubs = loss_apart > NOTHING * full_sliding_loss
    return {
        "loss_apart_W": json_number(loss_apart),
        "friction_increase_percent": loss_increase_percent(loss, loss_apart, full_sliding_loss),
        "ball_to_ball_percent": json_number(100.0 * loss_between_balls / loss_apart) if rubs else None,
        "ball_to_ball_loss_W": json_number(loss_between_balls),
        **power_balance_with_percent(power, loss, full_sliding_loss),
    }


def line_on_solver_residuals(loads: float, friction: float, suffix: str = "") -> Line:
    """Return a terminal line (label, text) on the unbalanced forces of the contact loads and of friction.

    ``loads``, ``friction``: unbalanced forces [N]; ``suffix``: text that is appended to the line.
    """
    return "solver", f"loads out of balance by {loads:.1e} N, friction by {friction:.1e} N{suffix}"


def scene_word_for_hertz_constants(hertz: str) -> str:
    """Return the name of a kind of Hertz constants in scene files: "nominal" for the internal "right", else unchanged."""
    return "nominal" if hertz == "right" else hertz


def line_on_energy_balance(power: float, loss: float) -> Line:
    """Return a terminal line (label, text) on input power [W], friction loss [W] and their difference."""
    left = zero_if_round_off(power - loss, loss)
    if left == 0.0 or loss == 0.0:
        return "energy", f"{loss:.6g} W are put in and lost"
    return "energy", f"{power:.6g} W are put in and {loss:.6g} W lost, {left:+.1e} W out of balance"


def effects_neglected_at_one_instant(friction: Friction) -> list[str]:
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


def heathcote_slip_clause(loss_increase: float) -> str:
    """Return a clause that says by how many per cent the neglected Heathcote slip would change friction.

    ``loss_increase``: ratio of the additional losses by Heathcote slip to the losses without it.
    """
    percent = f"{100.0 * loss_increase:+.2g} %"
    return f"their curvature (Heathcote slip) would change the friction torque, which leaves it out, by {percent}"


def ball_to_ball_forces_as_json(state: FrictionState) -> dict[str, Any] | None:
    """Return the forces between touching balls and their effect on the friction torque as JSON.

    ``state``: friction of the screw or bearing. None if forces between neighbouring balls are not computed.
    """
    n, t = state.neighbour_friction, state.friction_sums
    if n is None:
        return None
    return {
        "pairs": n.touching_pair_count,
        "smallest_gap_um": json_number(1e6 * n.smallest_gap),
        "force_on_next_N": [json_number(f) for f in n.force_on_next_ball],
        "loss_W": json_number(n.power_lost_between_balls),
        "friction_torque_change_percent": loss_increase_percent(t.power, state.sums_without_feedback.power, 0.0),
    }


#: Entries of the JSON of a ball of a whole screw or bearing that are fields.
_OF_BALL = from_fields(*MOTION_KEYS, "closing_mm_s", *CONTACT_KEYS)


def balls_with_friction(result: StaticResult, state: FrictionState, number: int | None = None) -> tuple[FrictionBall, ...]:
    """Return each ball: position, contact loads, motion, sliding and friction, and status of the friction.

    ``result``: static result; ``state``: friction of the balls; ``number``: number of the nut or bearing on a shaft, from
    1. The axes x and z of a contact lie across and along its groove.
    """
    at, f, q = state.contacts, state.ball_friction, state.ball_friction.ball_motions
    of_set = {} if number is None else from_fields("set")
    return tuple(
        FrictionBall(
            set=number,
            index=i + 1,
            closing=json_number(state.closing_speeds[i]),
            **ball_motion(q[i]),
            **sliding_and_friction(
                SIDES, f.contact_motions[i], f.force[i], f.moment[i], f.loss[i].sum(axis=1), f.sticking_contacts[i]
            ),
            entries=of_set
            | {
                "index": ...,
                "azimuth_deg": json_number(math.degrees(result.azimuth[i])),
                "z_mm": json_number(1e3 * result.z[i]),
                **ball_loads_json(SIDES, at.force[i], at.angle[i]),
                **_OF_BALL,
                "status": f.status[i],
            },
        )
        for i in range(at.force.shape[0])
    )


def terminal_ball_rows(balls: Sequence[FrictionBall]) -> list[dict[str, Any]]:
    """Return the rows of a terminal table, one for each ball; cells for load and loss of unloaded contacts are empty."""
    out = []
    for row in [ball.as_json() for ball in balls]:
        flat = terminal_ball_row(SIDES, row)
        for side, load in row["load_N"].items():
            shown = (load, row["loss_mW"][side]) if load > 0.0 else (None, None)
            flat |= dict(zip((f"{side} N", f"{side} mW"), shown, strict=True))
        out.append(flat)
    return out


#: Columns of the terminal's table of balls; N stands for the contact load, mW for the friction loss on a flank.
BALL_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    ("azimuth_deg", "azimuth deg", ".2f"),
    ("orbit_rad_s", "orbit rad/s", ".6g"),
    *((f"omega {n}", f"omega_{n}", ".5g") for n in "xyz"),
    ("closing_mm_s", "closing mm/s", ".3g"),
    *((f"{s} N", f"{s} N", ".2f") for s in SIDES),
    *((f"{s} mW", f"{s} mW", ".4g") for s in SIDES),
)

#: Columns of the table over the coefficient of friction: the coefficient, two torques, then what only a screw has.
OVER_COLUMNS: tuple[Column, ...] = (
    ("screw", "coefficient", ".4g"),
    ("friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("drag_torque_Nmm", "drag torque N mm", ".5g"),
    ("forward_torque_Nmm", "driving torque forward N mm", ".6g"),
    ("backward_torque_Nmm", "braking torque backward N mm", ".6g"),
    ("efficiency_forward_percent", "efficiency forward %", ".2f"),
    ("efficiency_backward_percent", "efficiency backward %", ".2f"),
    ("self_locking", "self-locking", "s"),
)

#: Columns of the terminal's table of friction losses by contact and cause.
LOSS_COLUMNS: tuple[Column, ...] = (
    ("contact", "contact", "s"),
    ("mean_load_N", "mean load N", ".4g"),
    ("mean_load_without_friction_N", "without friction N", ".4g"),
    ("loss_W", "loss W", ".4g"),
    *((name, f"{name.removeprefix('sliding_')} W", ".4g") for name in CAUSES),
    ("with_curvature_W", "curved W", ".4g"),
)


def losses_by_contact_and_cause(state: FrictionState, curved: BallFriction | None = None) -> list[dict[str, Any]]:
    """Return table rows of the friction losses [W], summed over all balls: one for each flank, and one for all flanks.

    The flanks are SL, SR, NL, NR (screw left and right, nut left and right). Each row has the mean load of the balls that
    carry load, with and without friction [N], the loss and its parts by cause (sliding across the groove, sliding along it,
    spin), and the loss in contacts that are curved across the groove. ``state``: friction of the screw or bearing;
    ``curved``: friction of its balls with curved contacts, None if it is not known.
    """
    table = state.ball_friction.loss.sum(axis=0)
    bent = np.full(4, np.nan) if curved is None or not curved.converged else curved.loss.sum(axis=(0, 2))
    loads = [mean_flank_loads(force) for force in (state.contacts.force, state.loads_without_friction)]
    named = [*zip(SIDES, *loads, table, bent, strict=True), ("sum", np.nan, np.nan, table.sum(axis=0), bent.sum())]
    return [
        {
            "contact": name,
            "mean_load_N": json_number(load),
            "mean_load_without_friction_N": json_number(bare),
            "loss_W": json_number(row.sum()),
            **{cause: json_number(value) for cause, value in zip(CAUSES, row, strict=True)},
            **({} if curved is None else {"with_curvature_W": json_number(in_curved)}),
        }
        for name, load, bare, row, in_curved in named
    ]


def mean_flank_loads(force: Array) -> Array:
    """Return the mean load of each flank over the balls that carry load ``(4,)`` [N]; 0 if none does.

    ``force``: contact loads of N balls ``(N, 4)`` [N].
    """
    loaded = force.sum(axis=1) > 0.0
    return force[loaded].mean(axis=0) if loaded.any() else np.zeros(4)


def torque_row_for_coefficients(friction: Friction, state: FrictionState, drag: float | None) -> dict[str, Any]:
    """Return a table row with torques and efficiencies for one pair of coefficients of friction (of screw and of nut).

    ``friction``: the coefficients; ``state``: friction computed with them; ``drag``: friction torque without loads [N
    m], None if it is not known.
    """
    found = friction_results_json(state.friction_sums, drag)
    names = [name for name, *_ in OVER_COLUMNS[1:]]
    return {"screw": friction.screw, "nut": friction.nut} | {name: found[name] for name in names}


def warnings_without_pressure_and_size(warnings: Sequence[ResultWarning]) -> list[ResultWarning]:
    """Return those of several warnings on a static result that concern neither contact pressure nor contact size.

    Pressure and size are checked again after the friction is computed, because friction changes the contact loads.
    """
    return [w for w in warnings if w.kind not in ("pressure", "size")]


def friction_warnings(
    scene: Scene, friction: Friction, state: FrictionState, static: Sequence[ResultWarning]
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


def _line_on_driving_torque(torque: FrictionSums, motion: Motion, part: str) -> Line:
    """Return a terminal line (label, text) on the torque that a motor must give or a brake must hold.

    ``torque``: torque on the screw; ``motion``: motion of screw or nut; ``part``: name of the part that turns.
    """
    needed = 1e3 * torque.driving_torque_on_screw * np.sign(torque.speed)
    role = "which a motor must give" if needed >= 0.0 else "with which a brake must hold"
    moving = f", which moves {motion_relative_to_load(torque)}" if torque.moves_axial_load else ""
    return "torque", f"{format_three_digits(abs(needed))} N mm, {role} the {part} at {motion.speed:.6g} rad/s{moving}"


def line_on_remaining_imbalance(residual: float, friction_residual: float) -> Line:
    """Return a terminal line (label, text) on the imbalance that the solver leaves in contact loads and in friction.

    ``residual``: relative residual of the static solution; ``friction_residual``: largest unbalanced force of a ball
    over its friction bound, the sum of friction coefficient times contact load.
    """
    loads = f"contact loads with a residual of {residual:.1e}"
    return "solver", f"{loads}, friction out of balance by {friction_residual:.1e} of its bound"


def lines_on_friction_of_screw(motion: Motion, state: FrictionState, drag: tuple[float | None, str]) -> list[Line]:
    """Return terminal lines (label, text) on the friction of a whole screw or bearing, the driving torque first.

    ``state``: the friction; ``drag``: friction torque without loads [N m], None if it is not known, and a remark on it.
    Values that depend on the coefficient of friction are shown with three digits, as that coefficient is hardly known to
    one.
    """
    t, ring = state.friction_sums, state.friction_sums.advance_per_radian == 0.0
    inner, outer = ("inner ring", "outer ring") if ring else ("screw", "nut")
    idle, remark = drag
    without = (
        f"unknown: {remark}" if idle is None else f"{format_three_digits(1e3 * idle)} N mm" + f" ({remark})" * bool(remark)
    )
    torque = f"torque {format_three_digits(1e3 * t.friction_torque)} N mm of {inner} in {outer}"
    lines = [
        _line_on_driving_torque(t, motion, inner if motion.turns == "screw" else outer),
        ("friction", f"{torque}; drag torque without loads {without}"),
    ]
    bare = f"{format_three_digits(1e3 * state.sums_without_feedback.friction_torque)} N mm"
    if state.neighbour_friction is not None:
        n = state.neighbour_friction
        text = (
            f"{n.touching_pair_count} pairs of neighbours touch, with up to {n.force_on_next_ball.max(initial=0.0):.3g} N; "
            f"between balls {n.power_lost_between_balls:.3g} W are lost; without them the friction torque is {bare}"
        )
        lines.append(("balls", text))
    elif not ring and t.friction_torque != 0.0:
        fed = state.friction_changes_loads
        how = "friction moves the balls in their grooves" if fed else "loads are those without friction"
        text = (
            f"{how}: it pulls the screw along its axis with {t.axial_friction_on_screw:.3g} N and a ball across its path "
            f"with up to {t.cross_groove_friction_ratio:.3g} of its largest load"
        )
        lines.append(("feedback", text + f"; without this feedback the friction torque is {bare}" * fed))
    return lines
