"""What a scene asks of friction, and its sums beside static answers: without what computes them, where these are kept."""

from __future__ import annotations

from rollbench.lowfi.friction.whole.torque import ScrewTorque
from rollbench.lowfi.jit import CONTACT, cached
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import Friction, Motion, Scene

#: Balls from which compiling the kernels (20 s, once) pays for a single solve, without feedback and with it.
COMPILE_ABOVE, COUPLED_ABOVE = 1000, 8


def feeds_back(scene: Scene, friction: Friction) -> bool:
    """Whether friction moves balls in their grooves: it is asked for, there is friction, and a lead."""
    return friction.feedback and scene.track.lead != 0.0 and max(friction.screw, friction.nut) > 0.0


def will_compile(scene: Scene, friction: Friction) -> bool:
    """Whether so many balls are solved that the kernels are compiled, unless machine code lies on disk (``cached``)."""
    often = feeds_back(scene, friction) or friction.neighbours
    return scene.ball_count > (COUPLED_ABOVE if often else COMPILE_ABOVE)


def torque_of(scene: Scene, result: StaticResult, friction: Friction, drive: Motion, member: int) -> ScrewTorque:
    """Sums of `lowfi.friction.whole.state.friction_state`. Raises ValueError as that does, and where a kernel would have to
    be compiled first."""
    if will_compile(scene, friction) and not cached(CONTACT):
        raise ValueError("kernels are not compiled yet; rollbench friction SCENE does it, once")
    from rollbench.lowfi.friction.whole.state import friction_state

    return friction_state(scene, result, friction, drive, member).torque
