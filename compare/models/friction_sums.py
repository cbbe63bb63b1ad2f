"""Friction torques and efficiencies of statically solved scenes, summed over all contacts, as JSON values."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from rollbench.compare.models.registry import Options
from rollbench.compare.quantities import number
from rollbench.lowfi.friction.whole.torque import ONE_TURN, ScrewTorque, will_compile
from rollbench.lowfi.jit import CONTACT, is_machine_code_cached
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.kept import kept
from rollbench.meshes.parts import Friction, Motion, Scene


def friction_sums_json(t: ScrewTorque, drag: float | None) -> dict[str, Any]:
    """Return torques about +z [N mm], axial load [N] and efficiencies [%] as JSON values; None where undefined."""
    screw, ideal = t.translating, t.ratio != 0.0
    forward, backward = t.efficiency
    return {
        "friction_torque_Nmm": number(1e3 * t.friction),
        "friction_torque_on_screw_Nmm": number(-math.copysign(1e3 * t.friction, t.speed)),
        "friction_torque_on_nut_Nmm": number(math.copysign(1e3 * t.friction, t.speed)),
        "drag_torque_Nmm": None if drag is None else number(1e3 * drag),
        "axial_load_N": number(t.load) if screw or not ideal else 0.0,
        "driving_torque_on_screw_Nmm": number(1e3 * t.on_screw),
        "driving_torque_on_nut_Nmm": number(-1e3 * t.on_screw),
        "load_moves": motion_against_load(t),
        "forward_torque_Nmm": number(1e3 * t.forward) if screw else None,
        "backward_torque_Nmm": number(1e3 * t.backward) if screw else None,
        "efficiency_forward_percent": percent(forward),
        "efficiency_backward_percent": None if t.locking else percent(backward),
        "self_locking": t.locking if screw else None,
    }


def motion_against_load(torque: ScrewTorque) -> str | None:
    """Return whether the motion is ``with the load`` or ``against the load`` (axial); None if nothing translates."""
    if not torque.translating:
        return None
    return "with the load" if torque.load * torque.ratio * torque.speed > 0.0 else "against the load"


def percent(share: float) -> float | None:
    """Return a share in per cent."""
    return number(100.0 * share)


@kept(ScrewTorque)
def _cached_torque(scene: Scene, result: StaticResult, friction: Friction, drive: Motion, member: int) -> ScrewTorque:
    """Return the torque record of `lowfi.friction.whole.state.friction_state`, from the cache if solved before.

    Raises ValueError as that function does, and if a kernel would have to be compiled first.
    """
    if will_compile(scene, friction) and not is_machine_code_cached(CONTACT):
        raise ValueError("kernels are not compiled yet; rollbench friction SCENE does it, once")
    from rollbench.lowfi.friction.whole.state import friction_state

    return friction_state(scene, result, friction, drive, member).torque


def cached_friction_sums(scene: Scene, result: StaticResult, options: Options) -> tuple[dict[str, Any] | None, str]:
    """Return friction torques and efficiencies of a scene that has [friction], if no kernel must be compiled.

    Results are cached on disk by scene and loads, as loading machine code would take longer than the rest of the
    solution.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    result
        Its converged result.
    options
        Options of the model.

    Returns
    -------
    dict or None
        Sums as JSON values.
    str
        Reason why there are none; else empty.
    """
    assert scene.friction is not None
    loads = replace(result, solver=replace(result.solver, seconds=0.0, setup_seconds=0.0), warnings=())
    try:
        return friction_sums_json(
            _cached_torque(scene, loads, scene.friction, scene.motion or ONE_TURN, options.member), None
        ), ""
    except ValueError as error:
        return None, str(error)


def torque(
    sets: list[tuple[Scene, StaticResult]], friction: Friction, motion: Motion | None, options: Options
) -> float | None:
    """Compute the sum of the friction torques of all sets.

    Parameters
    ----------
    sets
        Parts and result of each set.
    friction
        Coefficients of friction.
    motion
        Motion of the scene, if stated.
    options
        Options of the model.

    Returns
    -------
    float or None
        Torque [N mm]; None if the iteration does not converge, or a set is not covered.
    """
    from rollbench.lowfi.friction.whole.state import friction_state

    total = 0.0
    for scene, result in sets:
        try:
            state = friction_state(scene, result, friction, motion or ONE_TURN, options.member)
        except ValueError:
            return None
        if not state.settled:
            return None
        total += 1e3 * state.torque.friction
    return total
