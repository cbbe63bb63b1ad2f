"""An independent judge of static results: only from the printed numbers of a result and the scene.

It shares no code with the solvers: forces on every ball and on the screw are summed again from loads, contact angles and
azimuths; a refusal is checked by a linear program of its own; the loads of a rigid screw by plain minimisation.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog, minimize

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


def free_of(scene: Scene) -> Array:
    """Motions ``(6, k)`` of a rigid screw about the nut's centre that no support holds (rotations times pitch radius)."""
    rows = [row for support in scene.supports for row in _held(scene, support.at, [name for name, _ in support.fixed])]
    if not rows:
        return np.eye(6)
    _, size, vt = np.linalg.svd(np.array(rows))
    return np.asarray(vt[int((size > 1e-9 * size[0]).sum()) :].T)


def _held(scene: Scene, at: float, names: list[str]) -> list[Array]:
    arm, reach = scene.track.pitch_radius, at - scene.nut.position
    rigid = np.eye(6)
    rigid[0, 4], rigid[1, 3] = reach, -reach
    rigid[:, 3:] /= arm
    return [rigid[FREEDOM[name]] for name in names]


def wrench_of_loads(scene: Scene) -> Array:
    """Loads about the nut's centre (moments over the pitch radius) ``(6,)`` [N]."""
    total, middle = np.zeros(6), np.array([0.0, 0.0, scene.nut.position])
    for load in scene.loads:
        total[:3] += load.force
        total[3:] += (np.array(load.moment) + np.cross([0.0, 0.0, load.at] - middle, load.force)) / scene.track.pitch_radius
    return total


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
    lengths = float(np.abs(result.centreline[:, :3]).max()) + max(scene.screw.groove_radius, scene.nut.groove_radius)
    if not any(scene.errors.side(name).profile for name in ("SL", "SR", "NL", "NR")):
        lengths -= scene.balls.radius
    return DIGITS * lengths * float(stiff.sum(axis=1).max()), DIGITS * lengths * float(stiff.sum())


def unbalanced(scene: Scene, result: StaticResult) -> str:
    """Imbalance of a converged result in words; empty if it is in balance."""
    load = result.load
    if not np.isfinite(load).all() or (load < 0.0).any():
        return "loads are not finite, or negative"
    force, (centre, _) = forces(scene, result), frames(scene)
    applied = wrench_of_loads(scene)
    size = max(float(load.max()), float(np.abs(applied).max()))
    if size == 0.0:
        return ""
    felt = nothing(result) if float(load.max()) <= nothing(result) else 0.0
    of_ball, of_all = round_off(scene, result)
    if float(np.linalg.norm(force.sum(axis=1), axis=1).max()) > max(EXACT * size, of_ball, felt):
        return f"ball {int(np.linalg.norm(force.sum(axis=1), axis=1).argmax()) + 1} is not in balance"
    middle = np.array([0.0, 0.0, scene.nut.position])
    total = applied.copy()
    for s in (0, 1):
        total[:3] += force[:, s].sum(axis=0)
        total[3:] += np.cross(result.contact_point[:, s] - middle, force[:, s]).sum(axis=0) / scene.track.pitch_radius
    # what no support can carry must vanish; a free motion along the helix is held by a pin, which the result states
    free = free_of(scene)
    largest = max(size, float(np.abs(force[:, :2].sum(axis=(0, 1))).max()), float(load.sum()) * 1e-3)
    none = max(of_all, strained(scene), felt)
    arm = max(1.0, float(np.abs(centre[:, 2] - scene.nut.position).max()) / scene.track.pitch_radius)
    if neutral(scene, free).size:
        taken = wrench_of_pin(scene, result)
        if float(np.abs(taken).max()) > max(PIN * largest, none) * arm:
            return f"the pin of a free motion takes {float(np.abs(taken).max()):.3g} N"
        total += taken
    left = free.T @ total
    if float(np.abs(left).max(initial=0.0)) > max(EXACT * largest, none) * arm:
        return f"the screw is out of balance by {float(np.abs(left).max()):.3g} N"
    return ""


def by_law(drawn: GeometryWithErrors, hertz_C: Array, away: Array) -> Array:
    """Loads ``(n, 4)`` [N] by Hertz' law of balls that stand ``away`` (n, 4, 2) [m] from their flanks' centres."""
    approach = drawn.ball_radii[:, None] - drawn.groove_radii + np.hypot(away[..., 0], away[..., 1])
    return np.asarray((np.maximum(approach, 0.0) / hertz_C) ** 1.5)


def off_the_law(scene: Scene, result: StaticResult) -> str:
    """Which contact of arcs has another load than Hertz' law gives it by the motions of ball and screw, in words; empty
    where none has. For a rigid nut and balls, and screws whose flanks move with a station of the centreline."""
    choices = scene.ingredients
    if choices.arm == "nominal" or (choices.screw != "rigid" and choices.partition != "nodal"):
        return ""
    drawn, (centre, axes) = draw_geometry_with_errors(scene, ball_layout(scene)), frames(scene)
    if drawn.profile_coefficients.shape[1] or float(result.load.max()) <= nothing(result):
        return ""
    z, u = result.centreline_z, result.centreline
    slope, beta = np.arctan2(scene.track.lead, 2.0 * np.pi * scene.track.pitch_radius), scene.track.contact_angle
    law, furthest = np.full(result.load.shape, np.inf), 0.0
    for nearest in (0, 1):  # the station next to the contact, or the second one, where nodes so close are one
        w = result.centre_shift[:, None, :] - drawn.groove_centres
        for s in (0, 1):
            rise = 0.0 if choices.arm == "ball" else scene.balls.radius * np.sin(beta) * np.cos(slope) * WAYS[s, 1]
            apart = np.abs(z[None, :] - centre[:, 2:] - rise)
            first, station = np.argsort(apart, axis=1)[:, [0, nearest]].T
            station = np.where(np.take_along_axis(apart, station[:, None], axis=1)[:, 0] > ONE_NODE, first, station)
            from_axis = centre + np.einsum("na,nak->nk", drawn.groove_centres[:, s], axes)
            from_axis[:, 2] -= z[station]
            moved = u[station, :3] + np.cross(u[station, 3:], from_axis)
            furthest = max(furthest, float(np.abs(moved).max()))
            w[:, s] -= np.einsum("nak,nk->na", axes, moved)
        here = by_law(drawn, result.hertz_C, w)
        law = np.where(np.abs(here - result.load) < np.abs(law - result.load), here, law)
    if sides := flanks_of_single_arc_contacts(scene):  # one contact of a ball with either groove
        law[:, [s for s in range(4) if s not in sides]] = 0.0
    stiff = 1.5 * np.cbrt(np.maximum(law, result.load)) / result.hertz_C
    allowed = np.maximum(EXACT * float(result.load.max()), DIGITS * (furthest + drawn.groove_radii) * stiff)
    allowed[result.load == 0.0] = np.maximum(allowed[result.load == 0.0], nothing(result))
    off = np.abs(law - result.load) / allowed
    ball, side = (int(k) for k in np.unravel_index(int(off.argmax()), off.shape))
    if off[ball, side] <= 1.0:
        return ""
    at = f"ball {ball + 1} {SIDES[side]}"
    return f"Hertz' law gives {law[ball, side]:.9g} N, not {result.load[ball, side]:.9g} N, on {at}"


def wrench_of_pin(scene: Scene, result: StaticResult) -> Array:
    """Wrench that the pin takes in the result, about the nut's centre (moments over the pitch radius) ``(6,)`` [N]."""
    balance = result.equilibrium
    if balance is None:
        return np.zeros(6)
    moment = balance.pin_moment - np.cross([0.0, 0.0, scene.nut.position], balance.pin_force)
    return np.concatenate([balance.pin_force, moment / scene.track.pitch_radius])


def neutral(scene: Scene, free: Array) -> Array:
    """Those of the free motions, as coordinates ``(k, c)``, that move no flank at the balls' centres."""
    centre, axes = frames(scene)
    if not free.shape[1]:
        return np.zeros((0, 0))
    x = centre - np.array([0.0, 0.0, scene.nut.position])
    rows = np.concatenate([axes, np.cross(x[:, None, :], axes) / scene.track.pitch_radius], axis=2).reshape(-1, 6)
    _, size, vt = np.linalg.svd(rows @ free)
    return np.asarray(vt[int((size > 1e-9 * max(1.0, size.max(initial=0.0))).sum()) :].T)


def proven(scene: Scene) -> bool:
    """Whether a motion that no support holds and no contact resists lets the load do work: by rank, or a linear program."""
    free, applied = free_of(scene), wrench_of_loads(scene)
    size = float(np.abs(applied).max())
    if size == 0.0 or not free.shape[1]:
        return False
    still = free @ neutral(scene, free)
    if still.shape[1] and float(np.abs(still.T @ applied).max()) > 1e-8 * size:
        return True
    centre, axes = frames(scene)
    x, N, k = centre - np.array([0.0, 0.0, scene.nut.position]), len(centre), free.shape[1]
    beta = scene.track.contact_angle
    rows = np.zeros((4 * N, k + 2 * N))
    for s, way in enumerate(WAYS * np.array([np.cos(beta), np.sin(beta)])):
        for i in range(N):
            rows[4 * i + s, k + 2 * i : k + 2 * i + 2] = way
            if s < 2:
                normal = way @ axes[i]
                rows[4 * i + s, :k] = -np.concatenate([normal, np.cross(x[i], normal) / scene.track.pitch_radius]) @ free
    cost = np.concatenate([-(free.T @ applied) / size, np.zeros(2 * N)])
    bounds = [(-1.0, 1.0)] * k + [(None, None)] * (2 * N)
    found = linprog(cost, A_ub=rows, b_ub=np.zeros(4 * N), bounds=bounds)
    return found.status == 0 and bool(found.fun < -1e-7)


def brute_force(scene: Scene, result: StaticResult) -> float | None:
    """How much less energy plain minimisation finds than the result has, over its stored energy; None where it does not
    apply: a rigid screw with loads and without a free motion (which the model pins), all supports at zero, no uneven
    flanks, up to 40 balls."""
    moved = any(value != 0.0 for s in scene.supports for _, value in s.fixed)
    drawn = draw_geometry_with_errors(scene, ball_layout(scene))
    few = len(drawn.ball_radii) <= 40
    if (
        scene.ingredients.screw != "rigid"
        or moved
        or drawn.profile_coefficients.shape[1]
        or not few
        or scene.ingredients.arm == "nominal"
        or float(result.load.max()) <= nothing(result)
    ):
        return None
    free, applied = free_of(scene), wrench_of_loads(scene)
    if neutral(scene, free).size:
        return None
    _, axes = frames(scene)
    centre, arm = ball_layout(scene).centre - np.array([0.0, 0.0, scene.nut.position]), scene.track.pitch_radius
    N, k, unit = len(centre), free.shape[1], 1e-6
    C, groove = result.hertz_C, drawn.groove_centres
    point = centre[:, None, :] + np.einsum("nsa,nak->nsk", groove, axes)
    rows = np.zeros((N, 4, 2, k))
    for s in (0, 1):
        arms = np.cross(point[:, s, None, :], axes) / arm
        rows[:, s] = np.concatenate([axes, arms], axis=2) @ free

    def energy(x: Array) -> tuple[float, Array]:
        a, p = unit * x[:k], unit * x[k:].reshape(N, 2)
        w = -groove + p[:, None, :] - rows @ a
        size = np.maximum(np.hypot(w[..., 0], w[..., 1]), 1e-15)
        delta = np.maximum(drawn.ball_radii[:, None] - (drawn.groove_radii - size), 0.0)
        force = (delta / C) ** 1.5
        push = force[..., None] * w / size[..., None]
        slope = np.concatenate([-np.einsum("nsa,nsak->k", push, rows) - free.T @ applied, push.sum(axis=1).ravel()])
        return float((0.4 * force * delta).sum() - (free.T @ applied) @ a), unit * slope

    stored = float((0.4 * result.load ** (5.0 / 3.0) * C).sum())
    start = np.zeros(k + 2 * N)
    best, _ = energy(start)
    with np.errstate(all="ignore"):  # trial steps of the minimisation may go anywhere
        for _ in range(3):
            found = minimize(
                lambda x: tuple(v / stored for v in energy(x)), start, jac=True, method="BFGS", options={"gtol": 1e-9}
            )
            start, best = found.x, min(best, float(found.fun) * stored)
    return (stored - _work(scene, result, applied) - best) / stored


def _work(scene: Scene, result: StaticResult, applied: Array) -> float:
    """Work of the loads on the screw's motion at the nut's centre [J]."""
    z, u = result.centreline_z, result.centreline
    at = np.array([np.interp(scene.nut.position, z, u[:, k]) for k in range(6)])
    at[3:] *= scene.track.pitch_radius
    return float(applied @ at)
