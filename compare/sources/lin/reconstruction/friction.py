"""Friction of the contacts in the source's 3D model, "0.01": what it can do to the loads of balls that touch twice.

Two forces act on such a ball, so that they lie on the line through its two contacts. Nothing keeps it from rolling along
the track: no friction acts that way. Across it, the ball may stand beside the line of the arcs' centres by e. Both normals
then turn by phi = e/h against the line of the contacts, h the arc's radius less the ball's, and friction holds the ball
while tan(phi) <= mu. With arcs of one radius the line of the contacts stays parallel to that of the arcs' centres, so that
friction turns no force. It shifts both by the arc's radius times phi, and the ball fills the grooves as a ball does whose
radius is larger by h phi^2/2 (`closure`).

How far a ball stands beside its line follows from how it gets there. Rolling on both grooves, it goes half of the way that
one surface goes past the other. So does the middle of the arcs' centres, but for the tilt of one groove against the other:
phi = r tilt/(2 h), r the arc's radius (`tilt_that_slides`).

Where a model keeps its balls from turning, the grooves slide on them instead, and friction does turn the forces, by mu
(`rollbench.comparison.sources.lin.reconstruction.dragging`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from rollbench.meshes.parts import Scene

#: The coefficient that the source prints for the contacts of its 3D model.
MU = 0.01


def slack(scene: Scene) -> float:
    """h [m]: the arc's radius less the ball's. Raises ValueError for grooves of different radii."""
    if scene.screw.groove_radius != scene.nut.groove_radius:
        raise ValueError("arcs of different radii: a ball that rolls leaves the line of their centres")
    return scene.screw.groove_radius - scene.balls.radius


def closure(scene: Scene, phi: float = MU) -> float:
    """What a ball is larger by [m in radius] in effect whose normals are turned by ``phi`` [rad]."""
    return 0.5 * slack(scene) * phi**2


def tilt_that_slides(scene: Scene) -> float:
    """Tilt [rad] of one groove against the other in their section at which a ball that rolled there begins to slide."""
    return 2.0 * MU * slack(scene) / scene.screw.groove_radius


def off_line(scene: Scene, balls: Iterable[int] | None = None) -> Scene:
    """The scene with these balls, from 1 (all unless given), as far beside the lines of their arcs' centres as friction can
    hold them."""
    oversize, gap = dict(scene.errors.balls.listed), closure(scene)
    for k in range(1, scene.ball_count + 1) if balls is None else balls:
        oversize[k] = oversize.get(k, 0.0) + gap
    listed = tuple(sorted(oversize.items()))
    return replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=listed)))


def largest_change(scene: Scene, of: Callable[[Scene], float]) -> float:
    """Relative change of a quantity ``of`` a scene by friction on those balls alone by which it rises."""
    base = of(scene)
    return of(off_line(scene, [k for k in range(1, scene.ball_count + 1) if of(off_line(scene, (k,))) > base])) / base - 1.0
