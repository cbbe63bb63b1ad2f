"""An independent judge of static results: only from the printed numbers of a result and the scene.

It shares no code with the solvers: forces on every ball and on the screw are summed again from loads, contact angles and
azimuths; a refusal is checked by a linear program (`check_axes.proven`); loads of a rigid screw by plain minimisation.
"""

import numpy as np
from scipy.optimize import minimize

from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.one_arc import flanks_of_single_arc_contacts
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene

#: Signs of the contact directions of SL, SR, NL, NR in the section: along the radius, along the binormal.
WAYS = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
FREEDOM = {name: k for k, name in enumerate(FREEDOMS)}
#: Share of the largest force (or moment) that may be out of balance, or off Hertz' law, besides round-off.
EXACT = 1e-12
#: Round-off of a contact's force over its stiffness times the lengths that make its approach: some digits of each.
DIGITS = 4.0 * float(np.finfo(float).eps)
#: Approach [m] of a contact force that counts as none, whatever the others are.
NOTHING = 1e-11
#: Nodes of a beam closer than this are one [m].
ONE_NODE = 1e-5
#: Share of the forces of a strained screw that double precision leaves out of balance.
STRAINED = 1e-13
#: Share of the largest force (or moment) that the pin of a motion which moves no flank may take, as the result states it.
PIN = 0.05


def along(station: float) -> Array:
    """A place on the axis."""
    return np.array([0.0, 0.0, station])


def wrench(at: Array, force: Array, moment: Array | float = 0.0) -> Array:
    """Forces ``(..., 3)`` with their moments about a point from which they act at ``at``, ``(..., 6)``."""
    return np.concatenate([force, np.cross(at, force) + moment], axis=-1)


def carried(at: Array, motion: Array) -> Array:
    """Motion ``(..., 3)`` of points at ``at`` (..., 3) from a rigid body's place, by its motion (..., 6)."""
    return np.asarray(motion[..., :3] + np.cross(motion[..., 3:], at))


def motion_in_freedom(name: str, reach: float) -> Array:
    """Row ``(6,)`` that takes from a rigid body's motion that of its section so far along the axis in a freedom."""
    axis = np.eye(3)[FREEDOM[name] % 3]
    return wrench(along(reach), axis) if name[0] == "u" else wrench(np.zeros(3), np.zeros(3), axis)


def largest(values: Array) -> float:
    """Largest size of some values; 0 of none."""
    return float(np.abs(values).max(initial=0.0))


def frames(scene: Scene) -> tuple[Array, Array]:
    """Centres ``(N, 3)`` [m] and section axes ``(N, 2, 3)`` of all balls, from the helix's equation."""
    track, layout = scene.track, ball_layout(scene)
    hand = 1.0 if track.hand == "right" else -1.0
    a, z = layout.azimuth, layout.z
    slope = hand * np.arctan2(track.lead, 2.0 * np.pi * track.pitch_radius)
    c, s, zero = np.cos(a), np.sin(a), np.zeros_like(a)
    radial = np.stack([c, s, zero], axis=1)
    binormal = np.stack([s * np.sin(slope), -c * np.sin(slope), zero + np.cos(slope)], axis=1)
    centre = np.stack([track.pitch_radius * c, track.pitch_radius * s, z], axis=1)
    return centre, np.stack([radial, binormal], axis=1)


def forces(scene: Scene, result: StaticResult) -> Array:
    """Force ``(N, 4, 3)`` [N] of every ball on its flanks, by load and contact angle."""
    _, axes = frames(scene)
    angle = np.nan_to_num(result.contact_angle)
    way = WAYS * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.asarray(result.load[..., None] * np.einsum("nsa,nak->nsk", way, axes))


def middle_of_nut(scene: Scene) -> Array:
    """The nut's centre."""
    return along(scene.nut.position)


def arms(scene: Scene) -> Array:
    """What wrenches about the nut's centre are divided by ``(6,)``: moments by the pitch radius."""
    return np.repeat([1.0, scene.track.pitch_radius], 3)


def free_of(scene: Scene) -> Array:
    """Motions ``(6, k)`` of a rigid screw about the nut's centre that no support holds (rotations times pitch radius)."""
    held = [(name, s.at - scene.nut.position) for s in scene.supports for name, _ in s.fixed]
    if not held:
        return np.eye(6)
    _, size, vt = np.linalg.svd(np.array([motion_in_freedom(*one) / arms(scene) for one in held]))
    return np.asarray(vt[int((size > 1e-9 * size[0]).sum()) :].T)


def wrench_of_loads(scene: Scene) -> Array:
    """Loads about the nut's centre (moments over the pitch radius) ``(6,)`` [N]."""
    wrenches = [wrench(along(x.at) - middle_of_nut(scene), np.array(x.force), np.array(x.moment)) for x in scene.loads]
    return np.sum([np.zeros(6), *wrenches], axis=0) / arms(scene)


def nothing(result: StaticResult) -> float:
    """Force [N] of a contact that counts as none: of an approach of ``NOTHING``."""
    return float((NOTHING / result.hertz_C.mean()) ** 1.5)


def strained(scene: Scene) -> float:
    """Force [N] that the round-off of prescribed motions makes in an elastic screw between its supports."""
    arm = scene.track.pitch_radius
    moved = [abs(v) * (arm if name[0] == "r" else 1.0) for s in scene.supports for name, v in s.fixed]
    apart = np.diff(sorted({s.at for s in scene.supports}))
    if scene.ingredients.screw == "rigid" or not apart.size:
        return 0.0
    stiff = scene.screw.material.youngs_modulus * np.pi * (scene.screw.outer_diameter / 2.0) ** 2 / float(apart.min())
    return STRAINED * stiff * max(moved, default=0.0)


def round_off(scene: Scene, result: StaticResult) -> tuple[float, float]:
    """Force [N] that the last digits of motions and lengths make in the contacts of one ball at most, and in all of them.

    An approach is the difference of the lengths of groove and ball from one centre where flanks are no arcs."""
    stiff = 1.5 * np.cbrt(result.load) / result.hertz_C
    lengths = largest(result.centreline[:, :3]) + max(scene.screw.groove_radius, scene.nut.groove_radius)
    if not any(scene.errors.side(name).profile for name in SIDES):
        lengths -= scene.balls.radius
    return DIGITS * lengths * float(stiff.sum(axis=1).max()), DIGITS * lengths * float(stiff.sum())


def unbalanced(scene: Scene, result: StaticResult) -> str:
    """Imbalance of a converged result in words; empty if it is in balance."""
    load = result.load
    if not np.isfinite(load).all() or (load < 0.0).any():
        return "loads are not finite, or negative"
    force, (centre, _) = forces(scene, result), frames(scene)
    total, middle = wrench_of_loads(scene), middle_of_nut(scene)
    size = max(largest(load), largest(total))
    if size == 0.0:
        return ""
    felt = nothing(result) if largest(load) <= nothing(result) else 0.0
    of_ball, of_all = round_off(scene, result)
    of_balls = np.linalg.norm(force.sum(axis=1), axis=1)
    if largest(of_balls) > max(EXACT * size, of_ball, felt):
        return f"ball {int(of_balls.argmax()) + 1} is not in balance"
    total = total + wrench(result.contact_point[:, :2] - middle, force[:, :2]).sum(axis=(0, 1)) / arms(scene)
    # what no support can carry must vanish; a free motion along the helix is held by a pin, which the result states
    free = free_of(scene)
    met = max(size, largest(force[:, :2].sum(axis=(0, 1))), float(load.sum()) * 1e-3)
    none = max(of_all, strained(scene), felt)
    arm = max(1.0, largest(centre[:, 2] - middle[2]) / scene.track.pitch_radius)
    if neutral(scene, free).size and (balance := result.equilibrium) is not None:
        taken = wrench(-middle, balance.pin_force, balance.pin_moment) / arms(scene)
        if largest(taken) > max(PIN * met, none) * arm:
            return f"the pin of a free motion takes {largest(taken):.3g} N"
        total += taken
    left = largest(free.T @ total)
    return f"the screw is out of balance by {left:.3g} N" if left > max(EXACT * met, none) * arm else ""


def by_law(scene: Scene, result: StaticResult, drawn: GeometryWithErrors, moved: Array) -> Array:
    """Loads ``(n, 4)`` [N] by Hertz' law of the balls' motions, and motions ``moved`` (n, 4, 3) [m] of their flanks."""
    across = np.einsum("nak,nsk->nsa", frames(scene)[1], moved)
    away = result.centre_shift[:, None, :] - drawn.groove_centres - across
    approach = drawn.ball_radii[:, None] - drawn.groove_radii + np.hypot(away[..., 0], away[..., 1])
    return np.asarray((np.maximum(approach, 0.0) / result.hertz_C) ** 1.5)


def stiffness_by_law(law: Array, result: StaticResult) -> Array:
    """Stiffness ``(n, 4)`` [N/m] of the contacts at the larger of two loads: by the law, and of a result."""
    return np.asarray(1.5 * np.cbrt(np.maximum(law, result.load)) / result.hertz_C)


def farthest_off(law: Array, load: Array, allowed: Array, of: str = "") -> str:
    """Which contact differs most from its load by Hertz' law, in words; empty where none does by more than is allowed."""
    off = np.abs(law - load) / allowed
    ball, side = np.unravel_index(int(off.argmax()), off.shape)
    if off[ball, side] <= 1.0:
        return ""
    return f"Hertz' law gives {law[ball, side]:.9g} N, not {load[ball, side]:.9g} N, on ball {ball + 1} {SIDES[side]}{of}"


def off_the_law(scene: Scene, result: StaticResult) -> str:
    """Which contact of arcs has another load than Hertz' law gives it by the motions of ball and screw, in words; empty
    where none has. For a rigid nut and balls, and screws whose flanks move with a station of the centreline."""
    choices = scene.ingredients
    if choices.arm == "nominal" or (choices.screw != "rigid" and choices.partition != "nodal"):
        return ""
    drawn, (centre, axes) = draw_geometry_with_errors(scene, ball_layout(scene)), frames(scene)
    if drawn.profile_coefficients.shape[1] or largest(result.load) <= nothing(result):
        return ""
    z, u, furthest = result.centreline_z, result.centreline, 0.0
    slope, beta = np.arctan2(scene.track.lead, 2.0 * np.pi * scene.track.pitch_radius), scene.track.contact_angle
    law, moved = np.full(result.load.shape, np.inf), np.zeros((*result.load.shape, 3))
    for nearest in (0, 1):  # the station next to the contact, or the second one, where nodes so close are one
        for s in (0, 1):
            rise = 0.0 if choices.arm == "ball" else scene.balls.radius * np.sin(beta) * np.cos(slope) * WAYS[s, 1]
            apart = np.abs(z[None, :] - centre[:, 2:] - rise)
            first, station = np.argsort(apart, axis=1)[:, [0, nearest]].T
            station = np.where(np.take_along_axis(apart, station[:, None], axis=1)[:, 0] > ONE_NODE, first, station)
            from_axis = centre + np.einsum("na,nak->nk", drawn.groove_centres[:, s], axes)
            from_axis[:, 2] -= z[station]
            moved[:, s] = carried(from_axis, u[station])
            furthest = max(furthest, largest(u[station][:, :3]))  # a flank's motion may be the small sum of large parts
        furthest = max(furthest, largest(moved))
        here = by_law(scene, result, drawn, moved)
        law = np.where(np.abs(here - result.load) < np.abs(law - result.load), here, law)
    if sides := flanks_of_single_arc_contacts(scene):  # one contact of a ball with either groove
        law[:, [s for s in range(4) if s not in sides]] = 0.0
    digits = DIGITS * (furthest + drawn.groove_radii) * stiffness_by_law(law, result)
    allowed = np.maximum(EXACT * largest(result.load), digits)
    allowed[result.load == 0.0] = np.maximum(allowed[result.load == 0.0], nothing(result))
    return farthest_off(law, result.load, allowed)


def neutral(scene: Scene, free: Array) -> Array:
    """Those of the free motions, as coordinates ``(k, c)``, that move no flank at the balls' centres."""
    centre, axes = frames(scene)
    if not free.shape[1]:
        return np.zeros((0, 0))
    rows = wrench((centre - middle_of_nut(scene))[:, None, :], axes).reshape(-1, 6) / arms(scene)
    _, size, vt = np.linalg.svd(rows @ free)
    return np.asarray(vt[int((size > 1e-9 * max(1.0, size.max(initial=0.0))).sum()) :].T)


def brute_force(scene: Scene, result: StaticResult) -> float | None:
    """How much less energy plain minimisation finds than the result has, over its stored energy; None where it does not
    apply: a rigid screw with loads and without a free motion (which the model pins), all supports at zero, no uneven
    flanks, up to 40 balls."""
    moved = any(value != 0.0 for s in scene.supports for _, value in s.fixed)
    drawn, free = draw_geometry_with_errors(scene, ball_layout(scene)), free_of(scene)
    if (
        scene.ingredients.screw != "rigid"
        or scene.ingredients.arm == "nominal"
        or moved
        or drawn.profile_coefficients.shape[1]
        or len(drawn.ball_radii) > 40
        or largest(result.load) <= nothing(result)
        or neutral(scene, free).size
    ):
        return None
    applied, (_, axes), groove = wrench_of_loads(scene), frames(scene), drawn.groove_centres
    N, k, unit = len(axes), free.shape[1], 1e-6
    point = (ball_layout(scene).centre - middle_of_nut(scene))[:, None, :] + np.einsum("nsa,nak->nsk", groove, axes)
    rows = wrench(point[:, :, None, :], np.repeat(axes[:, None], 4, axis=1)) / arms(scene) @ free
    rows[:, 2:] = 0.0  # the nut is fixed

    def energy(x: Array) -> tuple[float, Array]:
        a, p = unit * x[:k], unit * x[k:].reshape(N, 2)
        w = -groove + p[:, None, :] - rows @ a
        size = np.maximum(np.hypot(w[..., 0], w[..., 1]), 1e-15)
        delta = np.maximum(drawn.ball_radii[:, None] - (drawn.groove_radii - size), 0.0)
        force = (delta / result.hertz_C) ** 1.5
        push = force[..., None] * w / size[..., None]
        slope = np.concatenate([-np.einsum("nsa,nsak->k", push, rows) - free.T @ applied, push.sum(axis=1).ravel()])
        return float((0.4 * force * delta).sum() - (free.T @ applied) @ a) / stored, unit * slope / stored

    stored = float((0.4 * result.load ** (5.0 / 3.0) * result.hertz_C).sum())
    start = np.zeros(k + 2 * N)
    best, _ = energy(start)
    with np.errstate(all="ignore"):  # trial steps of the minimisation may go anywhere
        for _ in range(3):
            found = minimize(energy, start, jac=True, method="BFGS", options={"gtol": 1e-9})
            start, best = found.x, min(best, float(found.fun))
    motion = np.array([np.interp(scene.nut.position, result.centreline_z, one) for one in result.centreline.T])
    return 1.0 - float(applied @ (motion * arms(scene))) / stored - best
