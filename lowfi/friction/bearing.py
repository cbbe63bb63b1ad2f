"""Friction of balls in rotary bearings: one ball with up to four contacts, and whole bearings.

The one ball follows section 3.2, the whole bearings section 4.3.1 of Lin's thesis. A bearing is treated as a ball screw of
zero lead whose "screw" is the inner ring. At the ball, x is along the bearing's axis, y radially outward, and z along the
ball's path (z3, x3, y3 of a screw). The contacts are IL, IR, OR, OL (inner or outer ring; left or right, towards -x or +x).
The inner ring rotates about x, the outer ring is at rest. Contact loads lie in the x-y plane and friction acts along z, so
that friction does not change the loads.

The whole bearings are a four-point bearing and a double-row angular-contact bearing, whose friction torque is computed
against the angle of the load: first the loads of all balls between two rigid rings, then each ball's motion of least
dissipation.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.contact import equilibrium
from rollbench.lowfi.friction.contact.laws import EllipticalContacts, SigmoidLaw
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z, ScrewGroove, section_axes
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.record_keys import frozen_default, frozen_record

#: Names of a ball's contacts, of which I and O stand for inner and outer ring, L and R for left and right.
SIDES = ("IL", "IR", "OR", "OL")

#: Indices of a screw's contacts (SL, SR, NL, NR) in the order of ``SIDES``; indices of a screw's unknowns (omega_B,
#: omega_x3, omega_y3, omega_z3) in the order of this module (omega_B, omega_x, omega_y, omega_z).
AROUND, TURNS = [0, 1, 3, 2], [0, 3, 1, 2]

#: For the contacts in the order of ``SIDES``: signs of their positions relative to the ball's centre along x, then along y,
#: and whether they are on the inner ring.
AXIAL, RADIAL, INNER = SIGN_Z[AROUND], SIGN_X[AROUND], ON_SCREW


@frozen_record
class Bearing(ScrewGroove):
    """Ball bearing with gothic-arch grooves, described as a ball screw of zero lead.

    The inner ring takes the place of the screw and rotates at ``screw_speed``; the outer ring is at rest.
    """

    #: Clearance of the ball along each contact normal [m], negative for an oversized ball.
    clearance: float = frozen_default(0.0)


@dataclass(frozen=True)
class BearingBallSolution:
    """Contact loads, motion and friction of one ball of a bearing."""

    #: Bearing to which the ball belongs.
    bearing: Bearing
    #: Contact loads and contact angles of the ball.
    load: equilibrium.ContactLoadSolution
    #: Contacts, kinematics and forces that determine the ball's motion.
    problem: equilibrium.BodyMotionProblem
    #: Motion and friction of the ball.
    motion: equilibrium.BodyMotion
    #: Torque on the inner ring that keeps it rotating against the friction of this ball [N m].
    inner_ring_torque: float

    @property
    def input_power(self) -> float:
        """Power that drives the inner ring, torque times speed [W]; in equilibrium it equals the friction loss."""
        return self.inner_ring_torque * self.bearing.screw_speed


def contact_loads_of_ball(
    bearing: Bearing, axial_force: float, radial_displacement: float
) -> equilibrium.ContactLoadSolution:
    """Return the contact loads of one ball between inner and outer ring, found at the minimum of elastic energy.

    The contact forces are unique. A ball with clearance and without force has no unique position; the position at the
    end of the search is then returned.

    Parameters
    ----------
    bearing
        The bearing.
    axial_force
        Axial force on the inner ring [N].
    radial_displacement
        Radial displacement of the inner ring towards the ball [m].

    Returns
    -------
    ContactLoadSolution
        Contact loads ``(4,)`` [N], contact angles from the radial direction ``(4,)`` [rad], positions of the ball along x,
        y ``(2,)`` [m] and of the inner ring along x ``(1,)`` [m].

    References
    ----------
    Lin (2019), 3.2.2: groove centres at the nominal contact angle.
    """
    none, along_axis = np.zeros((1, 2)), np.array([[[0.0], [0.0], [1.0]]])
    cell = screw_motion.BallsBetweenGrooves(
        groove=bearing,
        angle=np.full((1, 4), bearing.contact_angle),
        interference=np.full((1, 4), -bearing.clearance),
        screw_displacement_maps=along_axis,
        external_screw_force=np.array([axial_force]),
        given_screw_displacement=np.array([[radial_displacement, 0.0]]),
        ball_friction_forces=none,
        screw_friction_forces=np.zeros(1),
    )
    approach = float(np.max(bearing.contact_hertz_constants.C)) * max(abs(axial_force), 1e-6) ** (2.0 / 3.0)
    way = float(np.sign(axial_force)) * (approach + max(bearing.clearance, 0.0) + abs(radial_displacement))
    start = np.array([[0.5 * radial_displacement, 2.0 * way]]), np.array([4.0 * way])
    found = screw_motion.solve_screw_contact_loads(cell, start)
    force, angle, moved = found.force[0, AROUND], found.angle[0, AROUND], found.ball_displacements[0, ::-1]
    return replace(found, force=force, angle=angle, ball_displacements=moved)


def contact_kinematics(bearing: Bearing, angles: Array) -> tuple[Array, Array]:
    """Return the linear relation between the motion of a ball and the sliding and spin at its four contacts with the rings.

    ``bearing``: the bearing with its speed; ``angles``: contact angles ``(4,)`` [rad]. The unknowns are the orbital
    speed omega_B and the ball's rotation omega_x (about the bearing's axis), omega_y (radial), omega_z (along the
    ball's path) [rad/s], relative to a frame that rotates with the orbit.

    Returns
    -------
    tuple[Array, Array]
        Motion of each contact per unit of each unknown ``(4, 3, 4)``: sliding vx across the groove and vz along the ball's
        path [m/s], and spin about the normal [rad/s]; then the motion of each contact that the inner ring imposes while the
        ball does not move ``(4, 3)``.

    References
    ----------
    Rederived from Lin 3.4 to 3.9; corrects the signs of 3.13 (compare F.1 to F.3).
    """
    maps, drives = bearing.contact_kinematics(bearing.normals(angles[AROUND]))
    return maps[AROUND][..., TURNS], drives[AROUND]


def ball_motion_problem(
    bearing: Bearing, load: equilibrium.ContactLoadSolution, at: EllipticalContacts
) -> equilibrium.BodyMotionProblem:
    """Return the contacts, kinematics and forces that determine a ball's motion at given contact loads and angles.

    The unknowns are the orbital speed omega_B and the ball's rotation omega_x about the bearing's axis and omega_y
    about the radial direction [rad/s]; the rotation omega_z about the ball's path is left out, because it is zero by
    symmetry.

    Parameters
    ----------
    bearing
        The bearing.
    load
        Contact loads and angles of the ball.
    at
        Contacts of the ball, by `screw_motion.contact_ellipses_of_screw`.
    """
    maps, drives = contact_kinematics(bearing, load.angle)
    return equilibrium.BodyMotionProblem(
        contacts=at,
        contact_motion_maps=np.ascontiguousarray(maps[..., :3]),
        imposed_contact_motions=drives,
        other_forces=np.zeros(3),
    )


def inner_ring_torque(bearing: Bearing, load: equilibrium.ContactLoadSolution, motion: equilibrium.BodyMotion) -> float:
    """Return the torque about the bearing's axis that keeps the inner ring rotating against the friction of one ball [N m].

    Parameters
    ----------
    bearing
        The bearing.
    load
        Contact loads and angles of the ball.
    motion
        Motion and friction of the ball.
    """
    radius = bearing.pitch_radius + RADIAL * bearing.ball_radius * np.cos(load.angle)
    along = -AXIAL * np.sin(load.angle)  # component of each contact's normal along the axis
    moments = radius * motion.friction.force[:, 1] + along * motion.friction.moment
    return float(np.sum(moments[INNER]))


def solve_ball_of_bearing(bearing: Bearing, axial_force: float, radial_displacement: float) -> BearingBallSolution:
    """Return the contact loads and the motion of least dissipation of one ball of a bearing, with Coulomb friction.

    Parameters
    ----------
    bearing
        The bearing.
    axial_force
        Axial force on the inner ring [N].
    radial_displacement
        Radial displacement of the inner ring towards the ball [m].

    References
    ----------
    Lin (2019), 3.2, with exact Coulomb friction in place of the sigmoid 3.20.
    """
    return solve_balls_of_bearing(bearing, axial_force, [radial_displacement])[0]


def solve_balls_of_bearing(
    bearing: Bearing, axial_force: float, radial_displacements: Iterable[float]
) -> list[BearingBallSolution]:
    """Return what `solve_ball_of_bearing` returns, for several radial displacements of the inner ring [m]."""
    loads = [contact_loads_of_ball(bearing, axial_force, float(u)) for u in radial_displacements]
    problems = [
        ball_motion_problem(bearing, load, screw_motion.contact_ellipses_of_screw(bearing, load.force)) for load in loads
    ]
    return [
        BearingBallSolution(bearing, load, problem, motion, inner_ring_torque(bearing, load, motion))
        for load, problem, motion in zip(loads, problems, equilibrium.least_dissipations(problems), strict=True)
    ]


def solve_ball_by_lin_method(
    bearing: Bearing, axial_force: float, radial_displacement: float, law: SigmoidLaw
) -> BearingBallSolution:
    """Return the contact loads and the motion of one ball of a bearing by Lin's method, errors in its equations included.

    The method uses the Hertz constants of Table B.1 of Lin's thesis, the sigmoid friction law, a root of equation 3.19
    and the torque by equation 3.21. The root is searched from the motion of least dissipation and, if this fails, over
    sigmoids of increasing sharpness.

    Parameters
    ----------
    bearing
        The bearing.
    axial_force
        Axial force on the inner ring [N].
    radial_displacement
        Radial displacement of the inner ring towards the ball [m].
    law
        Lin's sigmoid friction law.
    """
    least = solve_ball_of_bearing(replace(bearing, hertz="as printed"), axial_force, radial_displacement)
    motion = equilibrium.motion_by_sigmoid(least.problem, law, least.motion.unknown_velocities)
    return replace(least, motion=motion, inner_ring_torque=motion.loss / bearing.screw_speed)


#: Names of the inner ring's degrees of freedom (translations, then rotations) in the order of the unknowns; relative size
#: below which a value counts as round-off.
UNKNOWNS, RANK = ("ux", "uy", "uz", "rx", "ry"), 1e-9

#: Which of the contacts SL, SR, NL, NR (S: inner ring, N: outer ring; left or right) a row of balls has: all four, or the
#: two opposite ones of one or the other diagonal.
ALL, DIAGONAL, OTHER = (True, True, True, True), (True, False, False, True), (False, True, True, False)


@dataclass(frozen=True)
class BallRow:
    """One row of balls of a bearing: its axial position, and which of the four contacts its grooves allow."""

    #: Axial position of the row of balls [m].
    place: float
    #: Whether the balls of the row can touch the flanks SL, SR, NL, NR (S: inner ring, N: outer ring; L, R: left or right
    #: flank).
    contacts: tuple[bool, bool, bool, bool]


@frozen_record
class BearingCase:
    """Ball bearing with a rotating, loaded inner ring and a fixed outer ring: rows of balls, clearance and force."""

    #: Grooves of the bearing, described as those of a screw with zero lead.
    groove: ScrewGroove
    #: Number of balls in a row.
    count: int
    #: Rows of balls with their axial positions.
    rows: tuple[BallRow, ...]
    #: Magnitude of the force on the inner ring [N]. The force lies in the x-z plane; its angle from the bearing's axis z is
    #: an argument of `solve_bearing`.
    force: float
    #: Clearance between ball and groove along the contact normal at each contact [m], negative for preload.
    clearance: float = frozen_default(0.0)
    #: Whether the inner ring may tilt.
    tilt: bool = frozen_default(False)
    #: Azimuth of the first ball, measured from the axis x, as a fraction of the angle between balls.
    phase: float = frozen_default(0.0)
    #: Axial position at which the force acts [m].
    arm: float = frozen_default(0.0)

    def __post_init__(self) -> None:
        """Check that the lead is zero and that there are rows with balls; raise ValueError otherwise."""
        if self.groove.lead != 0.0 or self.count < 1 or not self.rows:
            raise ValueError(
                "a bearing needs zero lead, at least one row, and at least one ball in a row, "
                f"got lead {self.groove.lead} m, {len(self.rows)} rows, {self.count} balls in a row"
            )


@dataclass(frozen=True)
class BearingStates:
    """Contact loads and friction of a bearing at n angles of the force on its inner ring (Figure 4.7 of Lin's thesis).

    Arrays list all N balls, row after row.
    """

    #: Angles of the force from the bearing's axis ``(n,)`` [rad].
    angle: Array
    #: Contact loads and contact angles of the balls, with the displacements of balls and inner ring, at each angle.
    load: list[equilibrium.ContactLoadSolution]
    #: Friction losses at the contacts ``(n, N, 4)`` [W].
    loss: Array
    #: Friction torque on the inner ring ``(n,)`` [N m]: the power lost, divided by the angular speed of this ring.
    torque: Array
    #: Power that drives the inner ring ``(n,)`` [W].
    input_power: Array
    #: Whether the loads and the motions of all balls converged ``(n,)``.
    converged: Mask

    @property
    def force(self) -> Array:
        """Contact forces of all balls at each angle ``(n, N, 4)`` [N]."""
        return np.array([load.force for load in self.load])

    @property
    def balls_beyond_two_contacts(self) -> Index:
        """Number of balls with more than two loaded contacts at each angle of the force ``(n,)``."""
        return np.asarray(((self.force > 0.0).sum(axis=2) > 2).sum(axis=1))

    @property
    def largest_over_smallest_torque(self) -> float:
        """Ratio of the largest to the smallest friction torque over all angles of the force."""
        return float(self.torque.max() / self.torque.min())


def inner_ring_displacement_maps(case: BearingCase) -> Array:
    """Return the displacement of the inner ring at each of N balls per unit of its m rigid-body motions ``(N, 3, m)``.

    The motions are three translations and, if the ring may tilt, rotations about x and y; rotations are multiplied by
    the pitch radius, so that all unknowns are lengths [m]. The displacements are along x3 (radial), y3 (tangential) and
    z3 (axial) at each ball. ``case``: the bearing.
    """
    radius, out = case.groove.pitch_radius, []
    for row in case.rows:
        for k in range(case.count):
            turn = section_axes(case.groove, 2.0 * np.pi * (k + case.phase) / case.count)
            move = np.eye(3)
            if case.tilt:
                at = radius * turn[0] + np.array([0.0, 0.0, row.place])
                move = np.column_stack([move, np.cross(np.eye(3)[:2], at).T / radius])
            out.append(turn @ move)
    return np.array(out)


def bearing_geometry_and_load(case: BearingCase, force_angle: float) -> screw_motion.BallsBetweenGrooves:
    """Return all balls of a bearing between its rings under the force on the inner ring, for `solve_screw_contact_loads`.

    ``case``: the bearing and the magnitude of the force; ``force_angle``: angle of the force from the bearing's axis
    [rad].
    """
    g, rows = case.groove, inner_ring_displacement_maps(case)
    has = np.repeat(np.array([r.contacts for r in case.rows]), case.count, axis=0)
    force = case.force * np.array([np.sin(force_angle), 0.0, np.cos(force_angle)])
    if case.tilt:
        force = np.append(force, np.cross([0.0, 0.0, case.arm], force)[:2] / g.pitch_radius)
    interference = np.where(has, -case.clearance, -2.0 * g.groove_ball_centre_distance)
    return screw_motion.balls_without_friction(g, np.full(has.shape, g.contact_angle), interference, rows, force)


def describe_unresisted_motion(case: BearingCase, force_angle: float) -> str:
    """Return a phrase that names a rigid motion of the inner ring which the force causes and no contact resists.

    An empty text is returned if there is no such motion.

    Parameters
    ----------
    case
        Bearing under a force.
    force_angle
        Angle of the force from the axis [rad].
    """
    cell, beta = bearing_geometry_and_load(case, force_angle), case.groove.contact_angle
    normal = np.stack([SIGN_X * np.cos(beta), SIGN_Z * np.sin(beta)], axis=1)[ON_SCREW]
    has = cell.interference[:, ON_SCREW] > -case.groove.groove_ball_centre_distance
    resists = np.einsum("sx,nxm->nsm", normal, cell.section_displacement_maps)[has]
    _, size, v = np.linalg.svd(resists, full_matrices=True)
    null = v[int(np.sum(size > RANK * size.max(initial=0.0))) :]
    drive = null @ cell.external_screw_force
    if not np.abs(drive).max(initial=0.0) > RANK * float(np.linalg.norm(cell.external_screw_force)):
        return ""
    motion = np.abs(drive @ null)
    parts = [name for name, share in zip(UNKNOWNS, motion, strict=False) if share > RANK * motion.max()]
    return f"rigid motion of the inner ring in {', '.join(parts)}"


def solve_bearing(case: BearingCase, force_angles: Array | float) -> BearingStates:
    """Return contact loads, friction losses and torque of a bearing at one or several angles of the force on it.

    The search for the loads at each angle starts from those at the angle before; all balls are then moved together.

    Parameters
    ----------
    case
        Bearing under a force.
    force_angles
        Angles of the force from the axis, ``(n,)`` [rad].

    References
    ----------
    Lin (2019), 4.3.1.
    """
    angles, loads = np.atleast_1d(np.asarray(force_angles, dtype=float)), list[equilibrium.ContactLoadSolution]()
    for angle in angles:
        cell = bearing_geometry_and_load(case, float(angle))
        loads.append(screw_motion.solve_screw_contact_loads(cell, loads[-1].displacements if loads else None))
    force, contact_angle = np.array([load.force for load in loads]), np.array([load.angle for load in loads])
    pressed = force.sum(axis=2) > 0.0
    moved = screw_motion.solve_ball_motions(case.groove, force[pressed], contact_angle[pressed])
    loss, power, good = np.zeros_like(force), np.zeros(pressed.shape), np.ones(pressed.shape, dtype=bool)
    if moved:
        loss[pressed] = [ball.motion.friction.loss for ball in moved]
        power[pressed] = [ball.input_power for ball in moved]
        good[pressed] = [ball.motion.status != "failed" for ball in moved]
    converged = np.array([load.converged for load in loads]) & good.all(axis=1)
    torque = loss.sum(axis=(1, 2)) / abs(case.groove.speed)
    return BearingStates(angles, loads, loss, torque, power.sum(axis=1), converged)
