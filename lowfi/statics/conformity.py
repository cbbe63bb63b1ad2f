"""What Hertz's flat contact leaves out where ball and groove conform: errors of radius, and pressure at an angle.

Ball (radius r) and groove (radius rho) touch over an ellipse of semi-axes a, b; theta is the angle of a point of it at the
ball's centre from the contact's normal. Along the ball's normals an approach delta closes the gap by delta cos(theta), a
growth e of the ball by e, everywhere. With the energy max over p >= 0 of (delta cos(theta) + e - gap) p - p C p / 2, of
slope N = integral p cos(theta) by delta and P = integral p by e, the approach that does to N what the growth does is

    delta_eq = e (dN/de) / (dN/ddelta) = e (dP/ddelta) / (dN/ddelta) = e dP/dN,

for any bodies. Hertz's moments <x^2> = a^2/5, <y^2> = b^2/5 give P = N (1 + (a^2 + b^2)/(10 r^2)), and a^2 ~ N^(2/3):

    delta_eq = e (1 + (a^2 + b^2)/(6 r^2)).                                                                            (1)

That is the approach e with both relative curvatures less by e/r^2: Hertz's approach at a given force grows by a^2/6 per
curvature (1/2 d/dN of N a^2/5), so that the larger ball, which conforms more, gains e (a^2 + b^2)/(6 r^2). A groove
smaller by e closes the gap by more than an approach across it, where its arc shrinks, and like one along the track, where
its normals do not turn with the ball's: only the curvature across changes, by e/rho^2. A profile's offset does it by its
curvature; its third and fourth derivatives join by moments of order (a/rho)^3 and are left out. So Hertz's constants are
taken at each contact's own radii, exactly. Limits: a flat contact (a << r) keeps delta_eq = e; without errors nothing
changes.

The approach itself does less than Hertz's: it closes the gap by its cosine, and only p cos(theta) carries N. To first
order in theta^2 the complementary energy grows by delta integral p theta^2/2 = delta N (a^2 + b^2)/(10 r^2) ~ N^(7/3), and
the approach by its derivative by N,

    delta = C N^(2/3) (1 + 7 (a^2 + b^2)/(30 r^2)).                                                                    (2)

The arc's departure from a parabola is worth -3 % of (2) at a/r = 0.18. Valid for a < 0.3 r and e << rho - r.
"""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.hertz import HertzConstants
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import groove_radii
from rollbench.meshes.parts import Scene
from rollbench.meshes.surface import groove_profile


def curvature_changes(scene: Scene, drawn: Specimen, ball_radius: Array) -> Array:
    """Change of each contact's relative curvatures by the errors of its radii, ``(..., N, 4, 2)`` [1/m], across the groove
    first; ball_radius: ``(..., N)`` [m].

    The groove's is that of its profile at the nominal contact angle.
    """
    gamma = np.array(scene.track.contact_angle)
    profiles = [groove_profile(gamma, drawn.radius[s], drawn.profile[s]) for s in range(4)]
    change = _curvature(*np.stack(profiles, axis=1)) - _curvature(groove_radii(scene), np.zeros(4), np.zeros(4))
    ball = 1.0 / ball_radius - 1.0 / scene.balls.radius
    changes = np.repeat(np.repeat(ball[..., None, None], 4, axis=-2), 2, axis=-1)
    changes[..., 0] -= change
    return np.asarray(changes)


def _curvature(radius: Array, slope: Array, bend: Array) -> Array:
    """Curvature [1/m] of a curve in polar coordinates from its radius and derivatives by angle."""
    return np.asarray((radius**2 + 2.0 * slope**2 - radius * bend) / np.hypot(radius, slope) ** 3)


def oblique_term(constants: HertzConstants, ball_radius: float) -> Array:
    """h [m/N^(4/3)] of what pressure at an angle adds to the approach, h F^(4/3): (2)."""
    return np.asarray(7.0 / 30.0 * constants.C * (constants.C_a**2 + constants.C_b**2) / ball_radius**2)
