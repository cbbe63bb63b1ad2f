"""Life of a duty cycle by the standards' equivalent loads: ISO 3408-5 for ball screws, ISO 281 for rings.

Both take the force on the whole part in every case j, with its share n_j of the revolutions, and a mean of order 3,

    F_m = (sum_j n_j F_j^3)^(1/3),  L = (C/F_m)^3 in 10^6 revolutions.                                               (1)

Ball screws, axial forces only. A nut with play carries either direction on another pair of flanks; of two halves that are
preloaded against each other with F_pr each carries one, and both give way by F^(2/3). So they part at 2^(3/2) F_pr, and up
to there, as the standard has it, the half that the force loads and the other one carry

    F_1 = F_pr (1 + F/(2^(3/2) F_pr))^(3/2),  F_2 = F_1 - F;  beyond  F_1 = F,  F_2 = 0.                             (2)

The lives of both, each with its rating, combine to L = (L_1^(-10/9) + L_2^(-10/9))^(-9/10).                         (3)

Rings: P = X F_r + Y F_a with the factors of a single row, from 20 deg on (below they follow from C_0 and tabulated factors
f_0, which are not computed here), above 45 deg with those of thrust bearings,
X = 1.25 tan(alpha) (1 - 2/3 sin(alpha)), Y = 1 where F_a > 1.25 tan(alpha) F_r. The standards know neither moments nor
the four-point preload of one nut.

Held against what makers print (``external-equivalent``, with pages): (1) by worked examples of HIWIN and Rexroth; (2) below
parting and (3) by HIWIN and NBS, who write 3 for 2^(3/2), as THK does after deriving it: their F_1 is up to 4 % lower, and
their F_2 negative before the halves part; e, X, Y at 25, 30 and 40 deg, and 1.25 tan(alpha) and X at 50, 55 and 60 deg by
NSK. Those at 20, 35 and 45 deg are not printed there; at all of them the two branches of P meet within 0.3 % (X + e Y).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, hypot, sin, tan

import numpy as np

from rollbench.lowfi.rating.life import RADIAL_UP_TO, TURNING, is_thrust, rating
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import beyond_step
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

#: Force at which two preloaded halves part, over the preload: springs of F ~ delta^(3/2).
PARTING = 2.0**1.5
#: Contact angles [deg], and e, X and Y of a single row there (ISO 281).
ANGLES = (20.0, 25.0, 30.0, 35.0, 40.0, 45.0)
LIMITS, RADIAL_FACTORS, AXIAL_FACTORS = (
    (0.57, 0.68, 0.80, 0.95, 1.14, 1.34),
    (0.43, 0.41, 0.39, 0.37, 0.35, 0.33),
    (1.00, 0.87, 0.76, 0.66, 0.57, 0.50),
)


@record
class EquivalentLife:
    """Life by (1) to (3). revolutions: in 10^6; loads: equivalent loads [N] of the two directions or halves of a screw, the
    first of a force on the nut along +z, or of a ring's one; standard: whose formulas."""

    revolutions: float = quantity(
        "L10_million_revolutions",
        "life by the standard's equivalent loads, (C/F_m)^3, of both directions or halves together",
    )
    loads: tuple[float, ...] = quantity(
        "equivalent_loads_N",
        "means of order 3 of the axial forces over the revolutions: of what carries forces along +z, and against it",
        parts="[]",
    )
    standard: str = quantity("standard", "whose formulas")


def equivalent_life(
    scenes: Sequence[Scene], shares: Sequence[float], forces: Sequence[Array], preload: float
) -> EquivalentLife | None:
    """Life of cases of the same parts by the standards; None without load.

    shares: of the revolutions; forces: of the screw on the nut in each case, ``(3,)`` [N]; preload: axial force [N] between
    two halves with a lead offset, 0 with play. Raises ValueError, in words, where the standard does not apply.
    """
    used = [(scene, n, np.asarray(F, dtype=float)) for scene, n, F in zip(scenes, shares, forces, strict=True) if n > 0.0]
    ring = scenes[0].track.lead == 0.0
    standard = "ISO 281" if ring else "ISO 3408-5"
    for scene, _, _ in used:
        reason = _outside(scene, ring=ring)
        if reason:
            raise ValueError(f"{standard} does not know {reason} (as in {scene.name})")
    n = np.array([share for _, share, _ in used])
    if ring:
        loads: tuple[float, ...] = (mean_force(n, np.array([_of_ring(scenes[0], F) for _, _, F in used])),)
        rated: tuple[float, ...] = (rating(scenes[0]),)
    else:
        axial = np.array([F[2] for _, _, F in used])
        along, against = halves(axial, preload)
        loads, rated = (mean_force(n, along), mean_force(n, against)), _ratings(scenes[0])
    wear = sum((F / C) ** (10.0 / 3.0) for F, C in zip(loads, rated, strict=True))
    return EquivalentLife(float(wear**-0.9), loads, standard) if wear > 0.0 else None


def halves(force: Array, preload: float) -> tuple[Array, Array]:
    """Forces [N] by (2) of what carries axial forces ``(n,)`` [N] along +z, and of what carries those against it."""
    size = np.abs(force)
    if preload > 0.0:
        loaded = np.where(size < PARTING * preload, preload * (1.0 + size / (PARTING * preload)) ** 1.5, size)
    else:
        loaded = size
    other = loaded - size
    return np.where(force >= 0.0, loaded, other), np.where(force >= 0.0, other, loaded)


def mean_force(shares: Array, force: Array) -> float:
    """F_m [N] of (1), of forces no less than zero ``(n,)`` [N] with their shares of the revolutions ``(n,)``."""
    top = float(force.max(initial=0.0))
    return 0.0 if top == 0.0 else top * float(shares @ (force / top) ** TURNING) ** (1.0 / TURNING)


def _ratings(scene: Scene) -> tuple[float, float]:
    """Ratings [N] of a screw along +z and against it: of the nut with play, of its halves with a lead offset, of which the
    one that is shifted along +z carries the forces against it."""
    capacity = rating(scene)
    offset = scene.errors.lead_offset
    if offset == 0.0:
        return capacity, capacity
    beyond = float(np.mean(beyond_step(scene, ball_layout(scene).z)))
    before, after = capacity * (1.0 - beyond) ** 0.86, capacity * beyond**0.86
    return (before, after) if offset > 0.0 else (after, before)


def factors(alpha: float) -> tuple[float, float, float]:
    """Limit e of axial over radial force, and X and Y beyond it, of a single row of contact angle alpha [rad] (ISO 281): a
    radial bearing from 20 deg on, above 45 deg a thrust bearing. Raises ValueError, in words, below 20 deg."""
    angle = degrees(alpha)
    if angle > RADIAL_UP_TO + 1e-9:
        return 1.25 * tan(alpha), 1.25 * tan(alpha) * (1.0 - 2.0 / 3.0 * sin(alpha)), 1.0
    if angle < ANGLES[0] - 1e-9:
        raise ValueError("below 20 deg ISO 281's factors for axial force follow from its f0, which is not computed here")
    e, X, Y = (float(np.interp(angle, ANGLES, values)) for values in (LIMITS, RADIAL_FACTORS, AXIAL_FACTORS))
    return e, X, Y


def _of_ring(scene: Scene, force: Array) -> float:
    """Equivalent load P [N] of a ring."""
    radial, axial, thrust = hypot(force[0], force[1]), abs(float(force[2])), is_thrust(scene)
    if not thrust and axial <= 1e-9 * radial:
        return radial
    e, X, Y = factors(scene.track.contact_angle)
    if axial > e * radial:
        return X * radial + Y * axial
    if thrust:
        raise ValueError("ISO 281 has no thrust bearing of one direction with so much radial force")
    return radial


def _outside(scene: Scene, *, ring: bool) -> str:
    """What of a case the standard does not cover; empty where it covers all."""
    moved = {name for s in scene.supports for name, value in s.fixed if value != 0.0}
    if any(x.moment[0] or x.moment[1] for x in scene.loads) or moved & {"rx", "ry"}:
        return "moments across the axis"
    if not ring and (any(x.force[0] or x.force[1] for x in scene.loads) or moved & {"ux", "uy"}):
        return "radial force"
    if scene.errors.balls.oversize > 0.0:
        return "the preload of balls with oversize, in four-point contact" if not ring else "preload"
    return ""
