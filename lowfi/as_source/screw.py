"""Lin's method for a ball screw, for comparison: root finding of contact loads, of balls, and of balls over time.

Numbers of sections and equations in this module are those of Lin's thesis (2019); the method is described in section 3.4.

Contact loads without friction: the unknowns are the position of each ball in its groove section (2), its contact angles
gamma (4), and the screw's motions. For a rigid screw, this is the state of chapter 2 (equations 2.11 to 2.25), which is
searched by the hybrid method.

A whole ball screw over time (section 3.4.4): in each step the loads are found as a root, then the motion of every ball
separately, then the motion of groups of balls which are near enough to touch and approach each other (equation 3.77). The
positions advance with these speeds. The method does not prevent negative gaps; the property
`ScrewHistoryByLin.largest_overlap` gives the largest overlap of balls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from rollbench.lowfi.as_source import balls as lin
from rollbench.lowfi.friction.contact.equilibrium import HYBRID, ContactLoadSolution
from rollbench.lowfi.friction.contact.laws import FrictionLaw
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z, ScrewGroove
from rollbench.lowfi.friction.screw.run import Run, balls_at_instant
from rollbench.lowfi.hertz import contact_force
from rollbench.meshes.arrays import Array, Mask


@dataclass(frozen=True)
class BallPositions:
    """Displacements and contact angles of N balls between their grooves, and displacement of the screw in m motions."""

    #: Displacement of the balls along x3, z3 ``(N, 2)`` [m].
    ball_displacements: Array
    #: Contact angles gamma of the balls ``(N, 4)`` [rad].
    contact_angles: Array
    #: Displacement of the screw in each of its m motions ``(m,)`` [m].
    screw_displacements: Array


def contact_loads_at_positions(
    cell: screw_motion.BallsBetweenGrooves, positions: BallPositions
) -> tuple[Array, Array, Array]:
    """Return the contact loads of N balls in given positions, and the residuals of the conditions for the contact angles.

    Loads and residuals follow from the contact conditions in chapter 2 of Lin's thesis: at the contact angle gamma, the
    tangent of the groove is perpendicular to the line of centres. ``cell``: the balls and their grooves; ``positions``:
    positions of balls and screw.

    Returns
    -------
    tuple
        Contact loads ``(N, 4)`` [N]; scalar product of the line of centres and the groove's tangent, divided by the
        distance of the centres, which is zero if the contact angle satisfies its condition ``(N, 4)``; unit normals of
        the contacts ``(N, 4, 2)``.
    """
    g, c, s = cell.groove, np.cos(positions.contact_angles), np.sin(positions.contact_angles)
    screw = (cell.section_displacement_maps @ positions.screw_displacements + cell.given_screw_displacement)[:, None, :]
    line = g.groove_ball_centre_distance * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    line = line + positions.ball_displacements[:, None, :] - np.where(ON_SCREW[:, None], screw, 0.0)
    normal, tangent = np.stack([SIGN_X * c, SIGN_Z * s], axis=-1), np.stack([-SIGN_X * s, SIGN_Z * c], axis=-1)
    approach = np.sum(line * normal, axis=-1) - g.groove_ball_centre_distance + cell.interference
    miss = np.sum(line * tangent, axis=-1) / g.groove_ball_centre_distance
    return contact_force(approach, g.contact_hertz_constants.C), miss, normal


def load_per_ball_and_its_approach(cell: screw_motion.BallsBetweenGrooves) -> tuple[float, float]:
    """Return the load on the screw per ball [N], then the approach of a ball and a groove under this load [m].

    Forces and displacements in the equations of `solve_contact_loads_by_root` are divided by these values.
    """
    share = max(float(np.linalg.norm(cell.external_screw_force)) / cell.angle.shape[0], 1e-300)
    return share, float(np.max(cell.groove.contact_hertz_constants.C)) * share ** (2.0 / 3.0)


def solve_contact_loads_by_root(
    cell: screw_motion.BallsBetweenGrooves, start: BallPositions | None = None
) -> ContactLoadSolution:
    """Return the contact loads of N balls without friction, as the root of 6 N + m equations for a screw with m motions.

    The unknowns are two coordinates and four contact angles of each ball, and the screw's displacements. ``start``:
    positions from which the search starts; None: those of `screw_motion.starting_displacements`. In the result,
    ``largest_unbalanced_force`` is the largest force out of balance [N], ``steps`` the number of evaluations of the
    equations, and ``converged`` is False if no root was found.
    """
    n = cell.angle.shape[0]
    scale, size = load_per_ball_and_its_approach(cell)
    if start is None:
        ball, screw = screw_motion.starting_displacements(cell)
        start = BallPositions(ball, cell.angle, screw)

    def positions_from_unknowns(x: Array) -> BallPositions:
        """Return positions of balls and screw from the scaled unknowns x."""
        return BallPositions(x[: 2 * n].reshape(n, 2) * size, x[2 * n : 6 * n].reshape(n, 4), x[6 * n :] * size)

    def residual(x: Array) -> Array:
        """Return the residuals of the equations: scaled forces on the balls, contact conditions, forces on the screw."""
        force, bent, normal = contact_loads_at_positions(cell, positions_from_unknowns(x))
        pull = force[..., None] * normal
        on_screw = np.einsum("nim,ni->m", cell.section_displacement_maps, pull[:, ON_SCREW].sum(axis=1))
        on_screw = on_screw + cell.external_screw_force + cell.screw_friction_forces
        on_balls = cell.ball_friction_forces - pull.sum(axis=1)
        return np.concatenate([(on_balls / scale).ravel(), bent.ravel(), on_screw / (n * scale)])

    x = np.concatenate(
        [(start.ball_displacements / size).ravel(), start.contact_angles.ravel(), start.screw_displacements / size]
    )
    solution = root(residual, x, method="hybr", options=HYBRID)
    places = positions_from_unknowns(solution.x)
    force, _, _ = contact_loads_at_positions(cell, places)
    left = float(np.max(np.abs(solution.fun))) * scale
    good = left <= lin.ACCEPTED * (scale * n + float(force.sum()))
    return ContactLoadSolution(
        force, places.contact_angles, places.ball_displacements, places.screw_displacements, left, int(solution.nfev), good
    )


def ball_to_ball_contact_of_screw(groove: ScrewGroove) -> lin.BallToBallContact:
    """Return kinematics and friction of touching balls of a screw, on the exact helix.

    The unknowns of a ball are its angular speeds omega_B around the axis and omega_x, omega_y, omega_z [rad/s]. The exact
    helix corrects equations 3.73 to 3.75 of Lin's thesis.
    """
    p, r = groove.pair, groove.ball_radius
    return lin.BallToBallContact(
        p.first_ball_surface_speeds,
        p.second_ball_surface_speeds,
        p.closing_speed_factor,
        groove.ball_to_ball_mu,
        np.array([groove.radius, r, r, r]),
        least_sliding_motion(groove),
    )


def least_sliding_motion(groove: ScrewGroove) -> Array:
    """Return the motion of a ball that slides least at its four contacts at the nominal contact angle ``(4,)`` [rad/s].

    The four values are the angular speeds omega_B around the axis and omega_x, omega_y, omega_z. Searches start from this
    motion, which is an assumption, because Lin's text does not say where they start.
    """
    maps, drives = groove.contact_kinematics(groove.normals(np.full(4, groove.contact_angle)))
    units = np.array([groove.radius, *[groove.ball_radius] * 3])
    x = np.linalg.lstsq((maps[:, :2] / units).reshape(8, 4), -drives[:, :2].ravel(), rcond=None)[0]
    return np.asarray(x / units)


def balls_of_screw(groove: ScrewGroove, force: Array, angle: Array) -> lin.LoadedBalls:
    """Return N balls of a screw at given contact loads, with the kinematics of their contacts.

    ``force``: contact loads ``(N, 4)`` [N]; ``angle``: contact angles ``(N, 4)`` [rad], both in the order SL, SR, NL, NR
    (screw or nut, left or right).
    """
    maps, drives = groove.contact_kinematics(groove.normals(angle))
    ellipses = screw_motion.contact_ellipses_of_screw(groove, force)
    return lin.LoadedBalls(ellipses, maps, drives, ball_to_ball_contact_of_screw(groove))


@dataclass(frozen=True)
class ScrewHistoryByLin:
    """Simulation over time of N balls of a screw by Lin's method in T steps.

    Ball k pushes ball k + 1; the last one pushes the first.
    """

    #: Angle of the nut at the beginning of each step ``(T,)`` [rad].
    nut_angle: Array
    #: Gap between each ball and the next one at the end of each step, as an azimuth ``(T, N)`` [rad]; zero if the two
    #: touch, negative if they overlap.
    gap: Array
    #: Force of each ball on the next one ``(T, N)`` [N].
    ball_force: Array
    #: Angular speed of each ball's centre about the axis, relative to the screw ``(T, N)`` [rad/s].
    omega: Array
    #: Friction torque due to losses at the contacts of balls and grooves ``(T,)`` [N m].
    groove_torque: Array
    #: Friction torque due to losses at the contacts between balls ``(T,)`` [N m].
    ball_torque: Array
    #: Status of the solution for the motion in each step (`BallMotionsByLin.status`); ``"failed"`` also if no contact loads
    #: were found. After a failure the speeds of the previous step continue.
    status: tuple[str, ...]

    @property
    def failed_step_count(self) -> int:
        """Number of steps for which no root was found."""
        return self.status.count("failed")

    @property
    def overlapping_step_count(self) -> int:
        """Number of steps with an impossible root: separate balls approach, or touching balls pull each other."""
        return self.status.count("overlapping")

    @property
    def largest_overlap(self) -> float:
        """Largest angle by which two neighbouring balls overlap, over all steps [rad]; 0 without overlap."""
        return max(0.0, -float(self.gap.min()))


@dataclass
class _PreviousStep:
    """Positions, motions and forces of N balls in the previous time step, from which searches start."""

    #: Positions of balls and screw in the previous step.
    positions: BallPositions
    #: Motions that the balls would have without forces on each other ``(N, 4)`` [rad/s].
    motions_without_ball_forces: Array
    #: Motions of the balls under the forces that they exert on each other ``(N, 4)`` [rad/s].
    ball_motions: Array
    #: Force of each ball on the next one ``(N,)`` [N].
    force: Array


def simulate_by_root(run: Run, steps: int | None = None) -> ScrewHistoryByLin:
    """Return the first time steps of a transient simulation of a screw by Lin's method with his sigmoid friction law.

    The balls are spread evenly at the beginning. Every search starts from the result of the previous step, the first one
    from nominal rolling; this is an assumption, because Lin's text does not say where they start.

    Parameters
    ----------
    run
        Ball screw with the settings of its simulation.
    steps
        Number of time steps to simulate; None: all steps of ``run``.

    Raises
    ------
    ValueError
        ``run`` has a return tube, or friction is to change its contact loads: this simulation covers neither.
    """
    if run.tube > 0.0 or run.coupling != "none":
        raise ValueError(
            "a simulation by Lin's method needs a track without return tube (tube = 0) and contact loads without influence "
            'of friction (coupling = "none")'
        )
    g, n, dt = run.groove, run.count, run.duration / run.steps
    law = screw_motion.lin_sigmoid_law(g, lin.SHARPNESS)
    azimuth = run.ring * (np.arange(n) + run.first) / n - np.pi * run.turns
    gap = np.full(n, run.ring / n - g.pair.spacing)
    before: _PreviousStep | None = None
    omega, rows, status = np.zeros(n), list[tuple[Array, Array, Array, float, float]](), list[str]()
    for k in range(steps or run.steps):
        turned = g.speed * dt * k
        azimuths, loaded = run.fold_into_track(azimuth, turned)
        cell = balls_at_instant(run, azimuths, loaded, turned)
        load = solve_contact_loads_by_root(cell, None if before is None else before.positions)
        at = BallPositions(load.ball_displacements, load.angle, load.inner_body_displacements)
        motion, order = _solve_motion_of_step(run, load.force, load.angle, gap <= 0.0, law, before)
        good = load.converged and motion.status != "failed"
        force, q, free = np.zeros(n), np.empty((n, 4)), np.empty((n, 4))
        force[order[:-1]] = motion.ball_force
        q[order] = motion.ball_motions
        free[order] = motion.motions_without_ball_forces
        if good:
            before, omega = _PreviousStep(at, free, q, force), q[:, 0] - g.screw_speed
        gap = gap + dt * (np.roll(omega, -1) - omega)
        speed = abs(g.speed)
        rows.append((gap, force, omega, float(motion.groove_loss.sum()) / speed, float(motion.ball_loss.sum()) / speed))
        status.append(motion.status if good else "failed")
        azimuth = azimuth + dt * omega
    gaps, forces, speeds, groove, ball = (np.array(c, dtype=float) for c in zip(*rows, strict=True))
    nut_angle = np.array([g.speed * dt * k for k in range(len(rows))])
    return ScrewHistoryByLin(nut_angle, gaps, forces, speeds, groove, ball, tuple(status))


def _solve_motion_of_step(
    run: Run, force: Array, angle: Array, may_touch: Mask, law: FrictionLaw, previous: _PreviousStep | None
) -> tuple[lin.BallMotionsByLin, NDArray[np.intp]]:
    """Return the motion of the balls in one time step, and the indices of the balls in the order of this motion ``(N,)``.

    The order begins after a ball that cannot touch the next one: there the ring of balls is cut open. ``force`` [N],
    ``angle`` [rad]: contact loads and angles ``(N, 4)``; ``may_touch``: whether each ball is near enough to the next one to
    touch it ``(N,)``; ``law``: friction law; ``previous``: state in the previous step, from which the searches start, None
    for nominal rolling. Raises RuntimeError if every ball may touch the next one.
    """
    if np.all(may_touch):
        raise RuntimeError(
            "the motion of the balls cannot be solved because every ball touches the next one; leave at least one gap"
        )
    order = np.roll(np.arange(run.count), -int(np.argmin(may_touch)) - 1)
    balls = balls_of_screw(run.groove, force[order], angle[order])
    near = may_touch[order[:-1]]
    if previous is None:
        return lin.solve_motions_of_balls_by_root(balls, law, near), order
    free = previous.motions_without_ball_forces[order]
    touching = (previous.ball_motions[order], previous.force[order[:-1]])
    motion = lin.solve_motions_of_balls_by_root(balls, law, near, free, touching, nearby=True)
    return (motion if motion.status != "failed" else lin.solve_motions_of_balls_by_root(balls, law, near, free)), order
