"""Friction torques and efficiencies of a ball screw or bearing, summed over its contacts, as JSON values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rollbench.compare.quantities import json_number
from rollbench.lowfi.friction.whole.torque import ONE_TURN, FrictionSums
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.cache import each_cached_on_disk
from rollbench.meshes.parts import Friction, Motion, Scene

if TYPE_CHECKING:
    from rollbench.lowfi.friction.whole.state import FrictionCase


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
        "reverse_friction_torque_Nmm": json_number(1e3 * torque.reverse_power / abs(torque.speed)),
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


@each_cached_on_disk(FrictionSums)
def _friction_sums(cases: Sequence[FrictionCase]) -> list[FrictionSums]:
    """Return the friction torques and efficiencies of several cases; cached on disk. ValueError as `friction_states`."""
    from rollbench.lowfi.friction.whole.state import FrictionCase, friction_states

    return [state.friction_sums for state in friction_states([FrictionCase(*case) for case in cases])]


def friction_results_of_scenes(
    solved: Sequence[tuple[Scene, Friction, StaticResult]], member: int
) -> list[tuple[dict[str, Any] | None, str]]:
    """Return friction torques and efficiencies of several scenes, which are cached on disk by scene and loads.

    Parameters
    ----------
    solved
        Scenes with one nut or bearing row, each with its coefficients of friction and its converged result.
    member
        Number of the random draw of the geometric errors, from 0; 0 without random errors.

    Returns
    -------
    list
        For each scene the torques and efficiencies as JSON values, None if they are not determined; then why they are not
        available, with advice, else an empty text.
    """
    cases = [
        (scene, without_times_and_warnings(result), friction, scene.motion or ONE_TURN, member)
        for scene, friction, result in solved
    ]
    try:
        return [(friction_results_json(sums, None), "") for sums in _friction_sums(cases)]
    except ValueError as error:
        if len(solved) == 1:
            return [(None, str(error))]
        return [each for one in solved for each in friction_results_of_scenes([one], member)]


def without_times_and_warnings(result: StaticResult) -> StaticResult:
    """Return a static result without what its friction does not depend on, so that it is found again on the disk."""
    return replace(result, solver=replace(result.solver, seconds=0.0, setup_seconds=0.0), warnings=())


class UnsolvedTorque(NamedTuple):
    """Nuts and ball bearings, the sum of whose friction torques is asked for."""

    #: Each nut or ball bearing as a separate scene, with its static result.
    solved: Sequence[tuple[Scene, StaticResult]]
    #: Coefficients of friction.
    friction: Friction
    #: Motion of the scene; None: the rotation `ONE_TURN`, because the speed is not known.
    motion: Motion | None
    #: Number of the random draw of the geometric errors, from 0; 0 without random errors.
    member: int


def total_friction_torques(unsolved: Sequence[UnsolvedTorque]) -> list[float | None]:
    """Compute sums of friction torques of nuts and ball bearings [N mm], all together.

    A sum is None if friction does not converge, or if the friction model does not cover a nut or bearing.
    """
    from rollbench.lowfi.friction.whole.state import FrictionCase, friction_states

    cases = [[FrictionCase(*each, of.friction, of.motion or ONE_TURN, of.member) for each in of.solved] for of in unsolved]
    try:
        states = iter(friction_states([case for group in cases for case in group]))
    except ValueError:
        return [None] if len(unsolved) == 1 else [torque for one in unsolved for torque in total_friction_torques([one])]
    out: list[float | None] = []
    for group in cases:
        found = [next(states) for _ in group]
        balanced = all(state.all_balanced for state in found)
        out.append(sum(1e3 * state.friction_sums.friction_torque for state in found) if balanced else None)
    return out
