"""Friction torques and efficiencies of a ball screw or bearing, summed over its contacts, as JSON values."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from rollbench.compare.quantities import json_number
from rollbench.lowfi.friction.whole.torque import ONE_TURN, FrictionSums, compiling_saves_time
from rollbench.lowfi.jit import CONTACT, is_machine_code_cached
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.parts import Friction, Motion, Scene


def friction_results_json(torque: FrictionSums, drag_torque: float | None) -> dict[str, Any]:
    """Return friction and driving torques about +z [N mm], axial load [N] and efficiencies [%] as JSON values.

    ``torque``: torques and efficiencies of the whole screw or bearing; ``drag_torque``: drag torque without load [N m],
    None if it is not known. Values that are not defined, such as the efficiency of a bearing, are None.
    """
    screw, ideal = torque.moves_axial_load, torque.advance_per_radian != 0.0
    forward, backward = torque.efficiency
    return {
        "friction_torque_Nmm": json_number(1e3 * torque.friction_torque),
        "friction_torque_on_screw_Nmm": json_number(-math.copysign(1e3 * torque.friction_torque, torque.speed)),
        "friction_torque_on_nut_Nmm": json_number(math.copysign(1e3 * torque.friction_torque, torque.speed)),
        "drag_torque_Nmm": None if drag_torque is None else json_number(1e3 * drag_torque),
        "axial_load_N": json_number(torque.axial_load) if screw or not ideal else 0.0,
        "driving_torque_on_screw_Nmm": json_number(1e3 * torque.driving_torque_on_screw),
        "driving_torque_on_nut_Nmm": json_number(-1e3 * torque.driving_torque_on_screw),
        "load_moves": motion_relative_to_load(torque),
        "forward_torque_Nmm": json_number(1e3 * torque.forward_torque) if screw else None,
        "backward_torque_Nmm": json_number(1e3 * torque.backward_torque) if screw else None,
        "efficiency_forward_percent": json_number(100.0 * forward),
        "efficiency_backward_percent": None if torque.is_self_locking else json_number(100.0 * backward),
        "self_locking": torque.is_self_locking if screw else None,
    }


def motion_relative_to_load(torque: FrictionSums) -> str | None:
    """Return the text "with the load" or "against the load" for the axial motion of screw or nut; None without such motion.

    ``torque``: friction torques, axial load and speed of the screw.
    """
    if not torque.moves_axial_load:
        return None
    return "with the load" if torque.axial_load * torque.advance_per_radian * torque.speed > 0.0 else "against the load"


@cached_on_disk(FrictionSums)
def _cached_torque(scene: Scene, result: StaticResult, friction: Friction, motion: Motion, member: int) -> FrictionSums:
    """Return the friction torque and efficiencies of a screw or bearing under its contact loads; cached on disk.

    ``result``: solution with the contact loads; ``friction``: coefficients of friction; ``motion``: speed of screw or nut;
    ``member``: number of the random draw of the geometric errors, from 0. ValueError if `friction_state` cannot compute
    them, or if a kernel must be compiled first.
    """
    if compiling_saves_time(scene, friction) and not is_machine_code_cached(CONTACT):
        raise ValueError("the friction kernels are not compiled yet; run rollbench friction SCENE once")
    from rollbench.lowfi.friction.whole.state import friction_state

    return friction_state(scene, result, friction, motion, member).friction_sums


def friction_results_if_compiled(scene: Scene, result: StaticResult, member: int) -> tuple[dict[str, Any] | None, str]:
    """Return friction torques and efficiencies of a scene if no kernel must be compiled for them.

    The results are cached on disk by scene and loads, because loading machine code would take longer than the rest of the
    solution.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, and with coefficients of friction.
    result
        Converged result of the scene.
    member
        Number of the random draw of the geometric errors, from 0; 0 without random errors.

    Returns
    -------
    dict or None
        Torques and efficiencies as JSON values; None if they are not available.
    str
        Reason why they are not available; else empty.
    """
    assert scene.friction is not None
    loads = replace(result, solver=replace(result.solver, seconds=0.0, setup_seconds=0.0), warnings=())
    try:
        torque = _cached_torque(scene, loads, scene.friction, scene.motion or ONE_TURN, member)
        return friction_results_json(torque, None), ""
    except ValueError as error:
        return None, str(error)


def total_friction_torque(
    scenes_with_results: list[tuple[Scene, StaticResult]], friction: Friction, motion: Motion | None, member: int
) -> float | None:
    """Compute the sum of the friction torques of several nuts and ball bearings.

    Parameters
    ----------
    scenes_with_results
        Each nut or ball bearing as a separate scene, with its static result.
    friction
        Coefficients of friction.
    motion
        Motion of the scene; None: the rotation `ONE_TURN`, because the speed is not known.
    member
        Number of the random draw of the geometric errors, from 0; 0 without random errors.

    Returns
    -------
    float or None
        Torque [N mm]; None if friction does not converge, or if the friction model does not cover a nut or bearing.
    """
    from rollbench.lowfi.friction.whole.state import friction_state

    total = 0.0
    for scene, result in scenes_with_results:
        try:
            state = friction_state(scene, result, friction, motion or ONE_TURN, member)
        except ValueError:
            return None
        if not state.all_balanced:
            return None
        total += 1e3 * state.friction_sums.friction_torque
    return total
