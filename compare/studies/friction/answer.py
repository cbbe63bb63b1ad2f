"""An answer of ``rollbench friction``: JSON-ready values, tables and lines, what is left out, looks on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.quantities import number
from rollbench.compare.text.printing import Column
from rollbench.lowfi.warned import above
from rollbench.meshes.arrays import Array, Mask

if TYPE_CHECKING:
    from rollbench.compare.scenes.friction_kinds.common import KindScene

LUBRICANT = "lubricant: film thickness, churning, and a coefficient that depends on speed, slip and temperature"
HYSTERESIS = "rolling hysteresis of the materials"
PARTS = "cage or spacers, return tube or deflectors, wipers and seals"
INERTIA = "gyroscopic moments and centrifugal forces of the balls"

#: What a whole screw or bearing leaves out at its instant.
WHOLE = (
    "feedback of friction on how the balls share the load: each keeps the load that it carries without friction",
    LUBRICANT,
    HYSTERESIS,
    "Heathcote slip over the curved contact in torques and losses: losses.heathcote_percent says what it would add",
    PARTS,
    INERTIA,
    "ripple: the work of loads that change as balls roll over errors, and enter and leave the loaded track",
    "torques of a second, jammed state of a ball, which may exist at high coefficients of friction (seen from 0.3 on)",
)
#: What an instant leaves out besides, by whether friction feeds back and whether neighbours push.
BESIDES = {
    (False, False): ("friction that moves a ball across its grooves", "contact between balls at the scene's instant"),
    (True, False): ("contact between balls at the scene's instant",),
    (False, True): (
        "friction, and forces between balls, that move a ball across its grooves",
        "forces between balls in the balance of contact loads",
    ),
    (True, True): (
        "forces between balls, and what they change of friction, that move a ball across its grooves",
        "forces between balls in the balance of contact loads",
    ),
}

#: What every kind leaves out.
_KINDS = (
    LUBRICANT,
    HYSTERESIS,
    "Heathcote slip over the curved contact, which counts where contacts are wide or contact angles small",
    PARTS,
    INERTIA,
    "yielding: contacts are elastic at every pressure",
    "elastic bodies: screw, shaft, nut and rings are rigid but for Hertz's contacts",
)
_LOADS_GIVEN = "friction in the balance of loads: the contacts carry what they carry without it"
_FEW = "the other balls of the track, and how all of them share the load"
_INSTANT = "time: one instant, whose ball motions are steady"
_JAMMED = "a second, jammed state of a ball, which may exist at high coefficients of friction"
#: What a screw leaves out besides, by the word of its coupling.
_COUPLING = {
    "none": (_LOADS_GIVEN,),
    "ball": ("friction in the balance of loads on the screw: it moves the balls only",),
    "ball and screw": (),
}
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


def left_out_of_kind(kind: str, coupling: str | None = None) -> list[str]:
    """Effects that the result of a scene of a kind leaves out; coupling: of friction to loads, of a screw."""
    return [*_OF_KIND[kind], *(_COUPLING[coupling] if coupling else ()), *_KINDS]


# --- an answer of ``rollbench friction``: JSON-ready values, tables and lines, and how they look on the terminal


#: Dissipation over that of full sliding below which it is an artefact of regularisation and round-off.
NOTHING = 1e-6
#: An entry of the block of answers: its label and what it says.
Line = tuple[str, str]
#: Labels of lines that say what lies behind the answers.
BEHIND = ("solver", "law")
#: Part of a loss by which two computations of it differ without a cause.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class FrictionAnswer:
    """A solved scene: JSON-ready values, tables (title, headings, rows), lines (label, text), whether all converged;
    tables of every ball of a whole screw, which are shown where asked for."""

    data: dict[str, Any]
    tables: Sequence[tuple[str, Sequence[Column], Sequence[dict[str, Any]]]]
    lines: Sequence[Line]
    converged: bool
    ball_tables: Sequence[tuple[str, Sequence[Column], Sequence[dict[str, Any]]]] = ()

    @property
    def text(self) -> str:
        """The lines as running text."""
        return "\n".join(f"{label}: {text}" for label, text in self.lines)

    @property
    def warning(self) -> str:
        """The line above the answers, or nothing."""
        return above(self.data.get("warnings", ()))


def head(scene: KindScene, status: str, converged: bool, coupling: str | None = None) -> dict[str, Any]:
    """Entries that every answer of a kind has; coupling: of friction to loads, of a screw."""
    named = {"scene": scene.name, "title": scene.title, "kind": scene.kind}
    return named | {
        "status": status,
        "converged": converged,
        "assumed": list(scene.assumed),
        "left_out": left_out_of_kind(scene.kind, coupling),
    }


def three(value: float) -> str:
    """A value with three digits, without an exponent below a million."""
    return f"{float(f'{value:.3g}'):g}"


def by_side(sides: Sequence[str], values: Array) -> dict[str, Any]:
    """Values (n,) or vectors (n, k) by the names of their contacts."""
    return {side: [number(v) for v in x] if np.ndim(x) else number(x) for side, x in zip(sides, values, strict=True)}


def load_row(sides: Sequence[str], force: Array, angle: Array) -> dict[str, Any]:
    """Contact loads [N] and angles [rad], (n,), of a ball; no angle without load."""
    loaded = np.where(force > 0.0, np.degrees(angle), np.nan)
    return {"load_N": by_side(sides, force), "contact_angle_deg": by_side(sides, loaded)}


def motion_row(q: Array) -> dict[str, Any]:
    """Motion of a ball (4,) [rad/s]: orbit, then rotation."""
    return {"orbit_rad_s": number(q[0]), "rotation_rad_s": [number(w) for w in q[1:]]}


def rubbing_row(
    sides: Sequence[str], motion: Array, force: Array, moment: Array, loss: Array, rest: Mask
) -> dict[str, Any]:
    """Sliding of a ball across and along the groove and spin at its contacts (n, 3); friction, losses and rest there."""
    return {
        "sliding_mm_s": by_side(sides, 1e3 * motion[:, :2]),
        "spin_rad_s": by_side(sides, motion[:, 2]),
        "friction_N": by_side(sides, force),
        "moment_Nmm": by_side(sides, 1e3 * moment),
        "loss_mW": by_side(sides, 1e3 * loss),
        "at_rest": {s: bool(r) for s, r in zip(sides, rest, strict=True)},
    }


def flat_ball(sides: Sequence[str], row: dict[str, Any]) -> dict[str, Any]:
    """A ball's row for the terminal: loads and rotations each in a column of their own."""
    flat = row | {f"{side} N": row["load_N"][side] for side in sides}
    return flat | {f"omega {n}": w for n, w in zip("xyz", row["rotation_rad_s"], strict=True)}


def without_round_off(difference: float, size: float) -> float:
    """A difference of two computations of something of this size, zero where it is round-off."""
    return 0.0 if abs(difference) <= ROUND_OFF * abs(size) else difference


def balance(power: float, loss: float) -> dict[str, Any]:
    """Input power against dissipation [W]."""
    left = without_round_off(power - loss, loss)
    return {"input_power_W": number(power), "loss_W": number(loss), "balance_W": number(left)}


def energy(power: float, loss: float, bound: float) -> dict[str, Any]:
    """`balance`, and as a percentage of the dissipation; none where less than ``NOTHING`` of full sliding is lost."""
    return balance(power, loss) | {"balance_percent": increase(power, loss, bound)}


def increase(loss: float, before: float, bound: float) -> float | None:
    """Increase of losses [%], zero where it is round-off; None where next to nothing was lost before."""
    if not before > NOTHING * bound:
        return None
    return number(float(error_percent(before + without_round_off(loss - before, before), before)))


def by_contact(power: float, loss: float, apart: float, balls: float, bound: float) -> dict[str, Any]:
    """What contact between balls adds: losses [W] with it and apart, between the balls only, and if all slid fully."""
    return {
        "loss_apart_W": number(apart),
        "friction_increase_percent": increase(loss, apart, bound),
        "ball_to_ball_percent": number(100.0 * balls / apart) if apart > NOTHING * bound else None,
        "ball_to_ball_loss_W": number(balls),
        "energy": energy(power, loss, bound),
    }


def solver_line(solver: dict[str, Any], suffix: str = "") -> Line:
    """Imbalance of loads and of friction [N]."""
    loads, friction = solver["load_imbalance_N"], solver["friction_imbalance_N"]
    return "solver", f"loads out of balance by {loads:.1e} N, friction by {friction:.1e} N{suffix}"


def hertz_word(hertz: str) -> str:
    """The word of scene files for the Hertz constants."""
    return "nominal" if hertz == "right" else hertz


def energy_line(values: dict[str, Any], digits: int = 6) -> Line:
    """The energy balance in words."""
    power, loss, left = (float(values[f"{name}_W"]) for name in ("input_power", "loss", "balance"))
    if left == 0.0 or loss == 0.0:
        return "energy", f"{loss:.{digits}g} W are put in and lost"
    return "energy", f"{power:.{digits}g} W are put in and {loss:.{digits}g} W lost, {left:+.1e} W out of balance"
