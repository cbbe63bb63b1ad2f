"""Sums of friction shown with static answers: kept of a known scene, they are read without what computes them."""

from __future__ import annotations

from rollbench.lowfi.friction.whole.settings import will_compile
from rollbench.lowfi.friction.whole.torque import ScrewTorque
from rollbench.lowfi.jit import CONTACT, cached
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import Friction, Motion, Scene


def torque_of(scene: Scene, result: StaticResult, friction: Friction, drive: Motion, member: int) -> ScrewTorque:
    """Sums of `lowfi.friction.whole.state.friction_state`. Raises ValueError as that does, and where a kernel would have to
    be compiled first."""
    if will_compile(scene, friction) and not cached(CONTACT):
        raise ValueError("kernels are not compiled yet; rollbench friction SCENE does it, once")
    from rollbench.lowfi.friction.whole.state import friction_state

    return friction_state(scene, result, friction, drive, member).torque
