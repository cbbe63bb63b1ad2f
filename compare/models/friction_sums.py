"""Friction torques and efficiencies of a ball screw or bearing, summed over its contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rollbench.compare.models.friction_torques import FrictionTorques
from rollbench.lowfi.friction.whole.torque import ONE_TURN, FrictionSums
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.cache import each_cached_on_disk
from rollbench.meshes.parts import Friction, Motion, Scene

if TYPE_CHECKING:
    from rollbench.lowfi.friction.whole.state import FrictionCase


def friction_torques(sums: FrictionSums, drag_torque: float | None = None) -> dict[str, Any]:
    """Return the fields of `FrictionTorques` of a whole screw or bearing.

    ``sums``: its torques and efficiencies; ``drag_torque``: drag torque without load [N m], None if it is not known.
    """
    screw, ideal = sums.moves_axial_load, sums.advance_per_radian != 0.0
    forward, backward = (None if math.isnan(x) else float(x) for x in sums.efficiency)
    on_nut = math.copysign(sums.friction_torque, sums.speed)
    moves = "with the load" if sums.axial_load * sums.advance_per_radian * sums.speed > 0.0 else "against the load"
    return {
        "torque": sums.friction_torque,
        "reverse_torque": sums.reverse_power / abs(sums.speed),
        "torque_on_screw": -on_nut,
        "torque_on_nut": on_nut,
        "drag_torque": drag_torque,
        "axial_load": sums.axial_load if screw or not ideal else 0.0,
        "driving_torque_on_screw": sums.driving_torque_on_screw,
        "driving_torque_on_nut": -sums.driving_torque_on_screw,
        "load_moves": moves if screw else None,
        "forward_torque": sums.forward_torque if screw else None,
        "backward_torque": sums.backward_torque if screw else None,
        "efficiency_forward": forward,
        "efficiency_backward": None if sums.is_self_locking else backward,
        "self_locking": sums.is_self_locking if screw else None,
    }


@each_cached_on_disk(FrictionSums)
def _friction_sums(cases: Sequence[FrictionCase]) -> list[FrictionSums]:
    """Return the friction torques and efficiencies of several cases; cached on disk. ValueError as `friction_states`."""
    from rollbench.lowfi.friction.whole.state import FrictionCase, friction_states

    return [state.friction_sums for state in friction_states([FrictionCase(*case) for case in cases])]


def friction_results_of_scenes(
    solved: Sequence[tuple[Scene, Friction, StaticResult]], member: int
) -> list[tuple[FrictionTorques | None, str]]:
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
        For each scene the torques and efficiencies, None if they are not determined; then why they are not
        available, with advice, else an empty text.
    """
    cases = [
        (scene, without_times_and_warnings(result), friction, scene.motion or ONE_TURN, member)
        for scene, friction, result in solved
    ]
    try:
        return [(FrictionTorques(**friction_torques(sums)), "") for sums in _friction_sums(cases)]
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
