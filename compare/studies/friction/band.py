"""What decides a friction torque beside the scene's own numbers: coefficient, preload, and the play of the balls."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from rollbench.compare.models.loading import preload
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.quantities import number
from rollbench.compare.studies.friction.answer import Line, three
from rollbench.lowfi.friction.whole.state import FrictionState, friction_state
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.warned import Warned
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.kept import kept
from rollbench.meshes.parts import BallErrors, Friction, Motion, Scene

#: Coefficients of friction of rolling contacts that are measured with lubricants, least and largest.
MEASURED = (0.003, 0.1)
#: Factor of the makers' formula of a preloaded nut's drag torque (THK, general catalogue; Rexroth, HIWIN alike).
MAKERS = 0.05
#: How much less than nominal balls are in radius [m] where the effect of a play that nobody stated is shown.
SMALLER = 5e-6
#: Factor of the feedback of friction on the balls' places from which on it is said.
FED_BACK = 1.5


_kept_state = kept(FrictionState)(friction_state)


def kept_state(scene: Scene, result: StaticResult, friction: Friction, motion: Motion, member: int) -> FrictionState:
    """`friction_state`, kept on disc between commands for equal scenes and loads."""
    loads = replace(result, solver=replace(result.solver, seconds=0.0, setup_seconds=0.0), warnings=())
    return _kept_state(scene, loads, friction, motion, member)


@dataclass(frozen=True)
class Solved:
    """What is solved: scene, model, its options, friction, how the screw turns, the scene without its loads."""

    scene: Scene
    model: str
    options: Options
    friction: Friction
    motion: Motion
    bare: StaticResult

    def torque(self, result: StaticResult, friction: Friction, scene: Scene | None = None) -> float:
        """Friction torque [N m] at the loads of a result; nan where there is none."""
        if not result.converged:
            return float("nan")
        state = kept_state(scene or self.scene, result, friction, self.motion, self.options.member)
        return state.torque.friction if state.settled else float("nan")


def makers_torque(scene: Scene, force: float) -> float:
    """Drag torque [N m] of a screw under an axial preload [N]: 0.05/sqrt(tan(lead angle)) F l/(2 pi)."""
    return MAKERS / float(np.sqrt(abs(np.tan(lead_angle(scene.track))))) * force * scene.track.lead / (2.0 * pi)


def band(solved: Solved, result: StaticResult) -> dict[str, Any]:
    """Torques at the ends of the measured coefficients, of the loaded scene and without its loads, and the makers' formula
    where a screw is preloaded (null where it is not)."""
    scene, held = solved.scene, preload(solved.scene, solved.bare) if solved.bare.converged else None
    ends = [replace(solved.friction, screw=mu, nut=mu, balls=None) for mu in MEASURED]
    pressed = held is not None and held.axial > 0.0 and scene.track.lead > 0.0
    drags = [1e3 * solved.torque(solved.bare, end) for end in ends] if pressed else []
    return {
        "coefficients": list(MEASURED),
        "friction_torque_Nmm": [number(1e3 * solved.torque(result, end)) for end in ends],
        "drag_torque_Nmm": [number(x) for x in drags] if drags else None,
        "preload_N": number(held.axial) if held is not None and pressed else None,
        "makers_formula_Nmm": number(1e3 * makers_torque(scene, held.axial)) if held is not None and pressed else None,
    }


def band_lines(data: dict[str, Any]) -> list[Line]:
    """The band in words."""
    words = f"at the coefficients that are measured with lubricants, {MEASURED[0]:g} to {MEASURED[1]:g}"
    lines = [("band", f"friction torque {_range(data['friction_torque_Nmm'])} N mm {words}")]
    if data["makers_formula_Nmm"] is not None:
        text = (
            f"without load drag torque {_range(data['drag_torque_Nmm'])} N mm at these; makers' formula 0.05/sqrt(tan(lead "
            f"angle)) F l/(2 pi) for the preload of {data['preload_N']:.4g} N: {three(data['makers_formula_Nmm'])} N mm"
        )
        lines.append(("drag", text))
    return lines


def _range(values: list[float | None]) -> str:
    return " to ".join("(none found)" if x is None else f"{x:.3g}" for x in values)


def states_no_play(scene: Scene) -> bool:
    """Whether a screw's file states neither the sizes of its balls nor a preload."""
    return scene.track.lead > 0.0 and scene.errors.balls == BallErrors() and not scene.errors.lead_offset


def play(solved: Solved, state: FrictionState) -> dict[str, Any] | None:
    """Torque with balls that are smaller by ``SMALLER``, of a screw that has no preload and states no play; else None."""
    scene = solved.scene
    if not states_no_play(scene) or not state.loaded or (solved.bare.load > 0.0).any():
        return None
    balls = replace(scene.errors.balls, oversize=-SMALLER)
    smaller = replace(scene, errors=replace(scene.errors, balls=balls))
    options = replace(solved.options, discretisation=False)
    torque = solved.torque(run_model(smaller, solved.model, options), solved.friction, smaller)
    return {
        "smaller_by_um": 1e6 * SMALLER,
        "friction_torque_Nmm": number(1e3 * torque),
        "friction_torque_as_given_Nmm": number(1e3 * state.torque.friction),
    }


def play_warning(data: dict[str, Any]) -> Warned:
    """Warning where neither play nor preload is stated."""
    value = data["friction_torque_Nmm"]
    other = "none found" if value is None else f"{value:.4g} N mm"
    text = (
        "no preload and no play are stated, and the play decides: friction torque "
        f"{data['friction_torque_as_given_Nmm']:.4g} N mm with balls that fit exactly, {other} with balls "
        f"{data['smaller_by_um']:g} um smaller in radius; state [errors.balls] oversize or a preload"
    )
    return Warned("play", text, text)


def feedback_warnings(state: FrictionState) -> list[Warned]:
    """Warning where friction that moves the balls raises the torque much."""
    alone, found = state.bare.friction, state.torque.friction
    if not state.coupled or not alone > 0.0 or found <= FED_BACK * alone:
        return []
    text = (
        f"friction that moves the balls across their grooves raises the torque {found / alone:.2g} times, from "
        f"{1e3 * alone:.4g} to {1e3 * found:.4g} N mm; without that: feedback = false"
    )
    return [Warned("feedback", text)]
