"""Motion, friction and losses of every ball of a screw or bearing at the contact loads of a static model.

The motion of each ball is that of least dissipation (``lowfi.friction.screw.motion``); friction does not change the loads.
The torques and efficiencies that follow from the losses are in ``lowfi.friction.whole.torque``.

Heathcote slip is what the curvature of the contact across the groove adds to the losses of flat contact ellipses. Ball and
groove meet in a surface of radius R_d across the groove, 1/R_d = (1/R_ball + 1/R_groove)/2. A ball that rolls with the
angular speed Omega about the axis across the groove moves a point at distance x from the contact's middle by Omega x^2 /(2
R_d) more along the path than the middle. The motion of least dissipation is found once with that speed and once without,
both by quadrature over the ellipses, so that each motion suits the contact surface for which it is computed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import STATUS
from rollbench.lowfi.friction.screw.chain import FrictionContacts
from rollbench.lowfi.friction.screw.groove import ON_SCREW, HelicalMotion, contact_axes
from rollbench.lowfi.friction.screw.motion import friction_wrench_at_contacts
from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.lowfi.jit import CONTACT, load_kernel_package
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.helix import lead_per_radian, nominal_groove_radii
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Causes of the losses of a contact: sliding of its centre across the groove, sliding of its centre along the path, spin
#: about the normal.
CAUSES = ("sliding_across", "sliding_along", "spin")

#: Unbalanced force on a ball, as a fraction of the sum of its friction bounds mu F, above which the solution for its motion
#: counts as failed.
UNBALANCED = 1e-6


@dataclass(frozen=True)
class BallKinematics(HelicalMotion):
    """Radii, contact angle, lead and speeds of screw and nut that determine the motion of a ball; lead 0 for a bearing."""

    #: Radius of the ball [m].
    ball_radius: float
    #: Radius of the helix of ball centres [m].
    pitch_radius: float
    #: Nominal contact angle [rad].
    contact_angle: float
    #: Advance per turn [m], negative for a left-hand thread.
    lead: float
    #: Angular speed of the nut [rad/s].
    nut_speed: float
    #: Angular speed of the screw [rad/s].
    screw_speed: float


@lru_cache(maxsize=64)
def ball_kinematics(scene: Scene, drive: Drive, ball_radius: float) -> BallKinematics:
    """Return the helix, contact angle and body speeds that determine the motion of a ball; results are cached.

    ``scene``: screw or bearing; ``drive``: which part turns, screw or nut, and its angular speed; ``ball_radius``: radius
    of the ball [m].
    """
    screw = drive.speed if drive.turns == "screw" else 0.0
    track = scene.track
    lead = 2.0 * np.pi * lead_per_radian(track)
    return BallKinematics(ball_radius, track.pitch_radius, track.contact_angle, lead, drive.speed - screw, screw)


@dataclass(frozen=True)
class BallFriction:
    """Motion, friction and losses of N balls; four contacts each, in the order SL, SR, NL, NR (screw, nut; left, right)."""

    #: Angular speed of each ball's centre about the screw's axis, relative to the part (screw or nut) that does not rotate
    #: ``(N,)`` [rad/s]; nan for a ball without load.
    orbital_speed: Array
    #: Angular speeds of each ball about x3, y3, z3, relative to these axes, which go round with the ball ``(N, 3)``
    #: [rad/s]; nan for a ball without load.
    rotation: Array
    #: Motion of the ball relative to the groove at each contact: sliding of the contact's centre across (x) and along (z)
    #: the groove [m/s], and spin about the normal [rad/s] ``(N, 4, 3)``.
    contact_motions: Array
    #: Force of friction on the ball at each contact, across (x) and along (z) the groove ``(N, 4, 2)`` [N].
    force: Array
    #: Moment of friction on the ball about the normal of each contact ``(N, 4)`` [N m].
    moment: Array
    #: Power lost in each contact by sliding across the groove, by sliding along it, and by spin ``(N, 4, 3)`` [W].
    loss: Array
    #: Whether each contact sticks ``(N, 4)``.
    sticking_contacts: Mask
    #: Status of the solution for each ball, such as ``"exact"`` or ``"failed"``; ``"no load"`` for a ball without contact
    #: forces.
    status: tuple[str, ...]
    #: Largest ratio, over all balls, of the unbalanced force on a ball to the sum of its friction bounds mu F (coefficient
    #: of friction times contact force).
    largest_imbalance_ratio: float

    @property
    def converged(self) -> bool:
        """Whether the friction forces on every ball are in balance."""
        return "failed" not in self.status

    @property
    def ball_motions(self) -> Array:
        """Motions of the balls ``(N, 4)`` [rad/s]: orbital speed, then the three rotations."""
        return np.column_stack([self.orbital_speed, self.rotation])

    @property
    def total_power_lost(self) -> float:
        """Power lost by friction in all contacts of all balls [W]."""
        return float(self.loss.sum())

    def contact_wrenches(self, normals: Array) -> Array:
        """Return force, then moment of friction on each ball at its contacts, along x3, y3, z3 each ``(N, 4, 6)`` [N, N m].

        x3 is radial, y3 along the track, z3 the binormal. ``normals``: unit vectors from each ball's centre to its
        contacts in these axes ``(N, 4, 3)``.
        """
        return friction_wrench_at_contacts(normals, self.force, self.moment)


def ball_friction(
    scene: Scene, contacts: StaticContacts, friction: Friction, drive: Drive, fast: bool = False, start: Array | None = None
) -> BallFriction:
    """Return the motion of least dissipation and the friction of every ball at given contact loads.

    If all coefficients of friction are zero, the motion is the limit of motions with equal coefficients that tend to
    zero. The function is valid for a helix of any hand and number of starts and for a ring (zero lead). Groove errors
    and the bending of the screw influence the loads and contact angles, but not the directions in which screw and nut
    move.

    Parameters
    ----------
    scene
        Screw or bearing.
    contacts
        Contacts of its N balls.
    friction
        Coefficients of friction.
    drive
        Which part turns, screw or nut, and its angular speed.
    fast
        Whether to use the compiled functions instead of plain Python.
    start
        First estimates of the motions ``(N, 4)`` [rad/s], from a similar state (``BallFriction.ball_motions``); nan for
        balls without an estimate. If None, there are no estimates.

    Raises
    ------
    ValueError
        The speed of screw and nut is zero.
    """
    if drive.speed == 0.0:
        raise ValueError("screw or nut must turn: the speed is zero, and friction at rest is not determined")
    count = contacts.force.shape[0]
    loaded = np.flatnonzero(contacts.force.sum(axis=1) > 0.0)
    pressed = contacts.subset(loaded)
    share, top = relative_friction_coefficients(friction)
    rubs = friction_contacts(scene, pressed, share, drive)
    n = loaded.size
    q = np.full((n, 4), np.nan) if start is None else start[loaded]
    forces, rests, outcome = np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 2))
    load_kernel_package(CONTACT, compiled=fast).least_dissipation_of_bodies(
        rubs.semi_axes_and_bound, rubs.contact_motion_maps, rubs.imposed_contact_motions, q, forces, rests, outcome
    )
    seen = rubs.imposed_contact_motions + np.einsum("nirj,nj->nir", rubs.contact_motion_maps, q)
    seen[rests > 0.0] = 0.0
    rotate_to_groove_axes(pressed, seen)
    rotate_to_groove_axes(pressed, forces)
    every, motion, pull = np.full((count, 4), np.nan), np.zeros((count, 4, 3)), np.zeros((count, 4, 3))
    rest, status = np.zeros((count, 4), dtype=bool), ["no load"] * count
    every[loaded], motion[loaded], pull[loaded] = q, seen, -top * forces
    rest[loaded] = (rests > 0.0) & (pressed.force > 0.0)
    left = outcome[:, 1] / rubs.semi_axes_and_bound[..., 2].sum(axis=1)
    for k, code, off in zip(loaded, outcome[:, 0].astype(int), left, strict=True):
        status[k] = STATUS[code] if off <= UNBALANCED else "failed"
    return ball_friction_from_motions(contacts, every, motion, pull, rest, status, float(left.max(initial=0.0)))


def ball_friction_from_motions(
    contacts: StaticContacts, motions: Array, motion: Array, pull: Array, rest: Mask, status: list[str], imbalance: float
) -> BallFriction:
    """Return motion, friction and losses of N balls as one record; the losses are friction times motion.

    ``contacts``: contacts of the balls; ``motions``: motions ``(N, 4)`` [rad/s], orbit and then rotation, nan without load;
    ``motion``: sliding of the contacts across and along the groove [m/s], and spin about the normal [rad/s], ``(N, 4, 3)``;
    ``pull``: friction on the ball, force across and along the groove [N], and moment about the normal [N m], ``(N, 4, 3)``;
    ``rest``: whether each contact sticks ``(N, 4)``; ``status``: status of the solution for each ball; ``imbalance``:
    largest unbalanced force on a ball, as a fraction of the sum of friction bounds (coefficient of friction times contact
    force) of this ball.
    """
    loaded = contacts.force[..., None] > 0.0
    loss = np.where(loaded, -pull * np.nan_to_num(motion), 0.0) + 0.0
    seen = np.where(loaded, motion, np.nan)
    return BallFriction(
        motions[:, 0], motions[:, 1:], seen, pull[..., :2], pull[..., 2], loss, rest, tuple(status), imbalance
    )


def relative_friction_coefficients(friction: Friction) -> tuple[Array, float]:
    """Return the ratios of the contacts' coefficients of friction to the largest one ``(4,)``, then the largest one.

    The ratios are in the order screw left, screw right, nut left, nut right. The ratios are 1 if all coefficients are zero:
    the motions depend only on the ratios, so that motions without friction are the limit for equal coefficients that tend
    to zero. ``friction``: coefficients of friction of screw and nut.
    """
    mu = np.array([friction.screw, friction.screw, friction.nut, friction.nut])
    top = float(mu.max())
    return (mu / top if top > 0.0 else np.ones(4)), top


def friction_contacts(
    scene: Scene, contacts: StaticContacts, friction_coefficients: Array, drive: Drive
) -> FrictionContacts:
    """Return ellipses, friction bounds and kinematics of all contacts, with x along the long semi-axis of each ellipse.

    ``contacts``: contact forces and ellipses; ``friction_coefficients``: coefficients of friction of the contacts with the
    four flanks (screw left, screw right, nut left, nut right) ``(4,)``, or their ratios to the largest one; the friction
    bounds in the result are the products of these values and the forces. ``drive``: which part turns, screw or nut, and its
    angular speed.
    """
    path = ball_kinematics(scene, drive, scene.balls.radius)
    maps, drives = path.contact_kinematics(contacts.normals, contacts.ball_radius)
    for rows in (maps, drives):
        rows[~contacts.across] = _rotate_quarter_turn(rows[~contacts.across])
    return FrictionContacts(
        np.stack([contacts.a, contacts.b, friction_coefficients * contacts.force], axis=-1),
        np.ascontiguousarray(maps),
        np.ascontiguousarray(drives),
    )


def rotate_to_groove_axes(at: StaticContacts, values: Array) -> None:
    """Rotate components from axes x, z along the semi-axes of each contact ellipse to axes x across the groove, z along it.

    On input, x lies along the long semi-axis of each ellipse, as in `friction_contacts`. ``at``: contacts of the N balls;
    ``values`` ``(N, 4, 3)``: components along x and z and about the normal for each contact, which are overwritten.
    """
    values[~at.across] = _rotate_quarter_turn(values[~at.across], -1.0)


def _rotate_quarter_turn(components: Array, sign: float = 1.0) -> Array:
    """Return the components of k contacts after their axes x, z have turned by 90 degrees about the contact normal.

    ``components`` ``(k, 3, ...)``: components along x and z and about the normal; ``sign``: 1 or, for the opposite sense,
    -1.
    """
    return np.stack([sign * components[:, 1], -sign * components[:, 0], components[:, 2]], axis=1)


def closing_speeds_of_neighbours(scene: Scene, contacts: StaticContacts, by_ball: BallFriction, drive: Drive) -> Array:
    """Return the speed at which each ball approaches the next one of the same thread start ``(N,)`` [m/s].

    The speed is negative if the balls separate. The next ball is the neighbour at the larger azimuth; in a ring, the last
    ball is followed by the first. The speed is nan for a ball without a next one, and where one of the two balls has no
    load. ``contacts``: contacts of the N balls; ``by_ball``: their motions; ``drive``: which part turns, screw or nut, and
    its angular speed.
    """
    path = ball_kinematics(scene, drive, scene.balls.radius)
    count, starts = contacts.force.shape[0], scene.track.starts
    closing = np.full(count, np.nan)
    per_start = count // starts
    for k in range(starts):
        balls = np.arange(k * per_start, (k + 1) * per_start)
        order = balls[np.argsort(contacts.layout.azimuth[balls], kind="stable")]
        speed = by_ball.orbital_speed[order]
        closing[order] = path.radius * (speed - np.roll(speed, -1))
        if scene.track.lead != 0.0 or per_start == 1:
            closing[order[-1]] = np.nan
    return closing


#: Numbers of quadrature points of a contact ellipse: along a radius, and around the ellipse.
OUTWARDS, ROUND = 10, 20

#: Regularising speeds of friction as fractions of a typical sliding speed, used one after the other; largest number of
#: Newton steps at each; largest number of halvings of a step.
SPEEDS, STEPS, HALVINGS = (0.3, 0.1, 0.03, 0.01, 0.003), 12, 12

#: Relative increase of the contact losses by Heathcote slip above which a warning is given.
WIDE = 0.03


def hertz_pressure_quadrature(outwards: int = OUTWARDS, around: int = ROUND) -> tuple[Array, Array, Array]:
    """Return points x, z, then weights of a quadrature over the unit disc, with the Hertz pressure as weight function.

    ``outwards``, ``around``: numbers of points along a radius and around the disc, k in all.

    Returns
    -------
    tuple
        Coordinates x, then z, of the points ``(k,)`` as fractions of the semi-axes of a contact ellipse, then the weights
        ``(k,)``, whose sum is 1.
    """
    node, weight = np.polynomial.legendre.leggauss(outwards)
    height, half = 0.5 * (1.0 + node), 0.5 * weight  # radius^2 = 1 - height^2 makes pressure a polynomial
    radius = np.sqrt(1.0 - height**2)
    turn = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    mass = np.repeat(3.0 * half * height**2 / around, around)
    return np.outer(radius, np.cos(turn)).ravel(), np.outer(radius, np.sin(turn)).ravel(), mass


def surface_speeds_in_contacts(
    scene: Scene, contacts: StaticContacts, drive: Drive, curvature_factor: float
) -> tuple[Array, Array]:
    """Return the sliding velocities of k points in each contact, as a linear function of the motions of the N balls.

    ``contacts``: contacts of the balls, each with the k points of `hertz_pressure_quadrature`; ``drive``: which part turns,
    screw or nut, and its angular speed; ``curvature_factor``: factor by which the curvature of the contacts across the
    groove is multiplied, 1 for the actual one and 0 for flat contact ellipses.

    Returns
    -------
    tuple
        First the sliding across and along the groove per unit of each ball's four motions ``(N, 4, k, 2, 4)`` [m]; then the
        sliding by screw and nut while the ball rests ``(N, 4, k, 2)`` [m/s].
    """
    path = ball_kinematics(scene, drive, scene.balls.radius)
    maps, drives = path.contact_kinematics(contacts.normals, contacts.ball_radius)
    body = np.where(ON_SCREW, path.screw_speed, path.nut_speed)
    # angular speed Omega of a ball about the axis across the groove: rolling @ q less the part of screw or nut
    rolling = np.einsum("nsi,ji->nsj", contact_axes(contacts.normals)[:, :, 0], path.ball_rotation_axes)
    bend = 0.25 * curvature_factor * (1.0 / contacts.ball_radius[:, None] + 1.0 / nominal_groove_radii(scene))
    x, z, _ = hertz_pressure_quadrature()
    px = np.where(contacts.across, contacts.a, contacts.b)[..., None] * x
    pz = np.where(contacts.across, contacts.b, contacts.a)[..., None] * z
    lift = bend[..., None] * px**2
    rows = np.stack(
        [
            maps[:, :, None, 0] + pz[..., None] * maps[:, :, None, 2],
            maps[:, :, None, 1] - px[..., None] * maps[:, :, None, 2] + lift[..., None] * rolling[:, :, None],
        ],
        axis=3,
    )
    roll = -(body * rolling[..., 0])[..., None] * lift
    added = np.stack(
        [drives[..., None, 0] + pz * drives[..., None, 2], drives[..., None, 1] - px * drives[..., None, 2] + roll], axis=-1
    )
    return rows, added


def least_dissipated_power(rows: Array, added: Array, strength: Array, start: Array, typical_sliding_speed: float) -> Array:
    """Return the power that friction dissipates on each of N balls in its motion of least dissipation ``(N,)``.

    The motion is found by Newton's method. The sliding speed v is regularised as sqrt(v^2 + eps^2), with eps reduced in
    steps. ``rows``, ``added``: sliding of the points in the contacts per unit of the balls' motions and while the balls
    rest, the two results of `surface_speeds_in_contacts`; ``strength`` ``(N, 4)``: friction bound of each contact,
    coefficient times force [N] (if the coefficients are ratios, the power is in the same proportion); ``start`` ``(N,
    4)``: motions to begin from [rad/s]; ``typical_sliding_speed``: a typical sliding speed [m/s], which sets the scale
    of eps.
    """
    loaded = (strength > 0.0).any(axis=0)
    weight = (strength[:, loaded, None] * hertz_pressure_quadrature()[2]).reshape(len(strength), -1)
    rows, added = rows[:, loaded].reshape(len(weight), -1, 4), added[:, loaded].reshape(*weight.shape, 2)
    q = start.copy()

    def power_and_sliding(motion: Array, eps: float) -> tuple[Array, Array, Array]:
        """Return the dissipated power of each ball [W], then sliding velocities and regularised speeds in contacts [m/s].

        ``motion`` ``(n, 4)``: motions of the n balls [rad/s]. The regularised speed of a sliding velocity v is
        sqrt(v^2 + eps^2).
        """
        v = (rows @ motion[..., None]).reshape(added.shape) + added
        size = np.sqrt(v[..., 0] ** 2 + v[..., 1] ** 2 + eps * eps)
        return (weight * size).sum(axis=1), v, size

    for eps in typical_sliding_speed * np.array(SPEEDS):
        total, v, size = power_and_sliding(q, eps)
        for _ in range(STEPS):
            w = weight / size
            along = np.einsum("npci,npc->npi", rows.reshape(*v.shape, 4), v)
            gradient = (w[:, None] @ along)[:, 0]
            hessian = rows.swapaxes(1, 2) @ (np.repeat(w, 2, axis=1)[..., None] * rows)
            hessian -= along.swapaxes(1, 2) @ ((w / size**2)[..., None] * along)
            floor = 1e-10 * np.einsum("nii->n", hessian)
            step = -np.linalg.solve(hessian + floor[:, None, None] * np.eye(4), gradient[..., None])[..., 0]
            length = np.ones(q.shape[0])
            for _ in range(HALVINGS):
                worse = ~(power_and_sliding(q + length[:, None] * step, eps)[0] <= total)
                if not worse.any():
                    break
                length = np.where(worse, 0.5 * length, length)
            length[worse] = 0.0
            before, q = total, q + length[:, None] * step
            total, v, size = power_and_sliding(q, eps)
            if float((before - total).max()) <= 1e-12 * float(before.max()):
                break
    return power_and_sliding(q, 0.0)[0]


def heathcote_loss_increase(
    scene: Scene, contacts: StaticContacts, by_ball: BallFriction, friction: Friction, drive: Drive
) -> float:
    """Return the relative increase of the summed contact losses by Heathcote slip at given loads; nan without any loss.

    Heathcote slip comes from the curvature of the contact surfaces across the groove. The increase is the ratio of the
    loss with curved contact surfaces to that with flat ones, less 1. Quadrature and regularised friction, which are the
    same for both, limit its accuracy to about 0.002.

    Parameters
    ----------
    scene
        Screw or bearing.
    contacts
        Contacts under the static loads.
    by_ball
        Motion and friction of each ball.
    friction
        Coefficients of friction.
    drive
        Which part turns, screw or nut, and its angular speed.
    """
    balls = np.flatnonzero(np.isfinite(by_ball.orbital_speed))
    if balls.size == 0:
        return float("nan")
    pressed, share = contacts.subset(balls), relative_friction_coefficients(friction)[0]
    strength = share * pressed.force
    start = by_ball.ball_motions[balls]
    seen = np.nan_to_num(by_ball.contact_motions[balls])
    slide = float(np.sqrt(np.max(seen[..., 0] ** 2 + seen[..., 1] ** 2 + (pressed.a * seen[..., 2]) ** 2)))
    if slide == 0.0:
        return float("nan")
    speeds = (surface_speeds_in_contacts(scene, pressed, drive, factor) for factor in (0.0, 1.0))
    flat, curved = (float(least_dissipated_power(*speed, strength, start, slide).sum()) for speed in speeds)
    return curved / flat - 1.0
