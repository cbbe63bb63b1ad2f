"""Coulomb friction in contacts on grids, with rigid motions that balance their forces: Newton's method to round-off.

In every cell of a contact the slip s = M q + J y + w [m/s] comes from the elastic displacement by the tangential forces q
[N], the motions y and the prescribed part w; and

    |q| <= g,   s = -c q with c >= 0,   c (g - |q|) = 0,                                          (1)
    sum J^T q + f(y) = 0,                                                                          (2)

g: coefficient of friction times normal force. (1) is the root of q - P(q - r s), P the projection onto the disk of radius
g, for any r > 0; Newton's method on that root (Alart and Curnier 1991) solves both without smoothing. A smoothed law, q =
-g s/sqrt(s^2 + eps^2), only leads there: first without elasticity, and where that start is too poor with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.arrays import Array, Index

Flags = NDArray[np.bool_]
#: Function that returns the forces f ``(k,)`` [N] on the k motions besides friction, and df/dy ``(k, k)``, at motions y
#: ``(k,)``.
Balance = Callable[[Array], tuple[Array, Array]]

#: Slip speeds, over the largest slip, by which Coulomb's law is smoothed one after the other; largest number of Newton's
#: steps at each.
PATH, STEPS = tuple(10.0**-k for k in range(7)), 25
#: Slip speed of the smoothed law, over the largest slip, at and below which each solution with elasticity is tried as the
#: start of a solution of Coulomb's law without smoothing.
SHARPEST = 0.02
#: Largest number of Newton's steps without smoothing, and residual, over the largest friction limit, at which they end.
MOST, TOLERANCE = 60, 1e-11
#: Parameter r of the projection, over the force of one cell per elastic slip that it causes there. From 0.3 on, stiff stick
#: zones of many cells make Newton's method cycle.
SOFT = 0.03
#: Unbalanced force over the largest friction of a contact up to which rigid bodies count as in equilibrium.
RIGID = 1e-8
#: Growth of the residual at which Newton's steps without smoothing are given up.
LOST = 1e4


@dataclass(frozen=True)
class FrictionContact:
    """Input of the friction solver for one contact of n cells whose bodies have m rigid motions."""

    #: Largest tangential force g of each cell, friction coefficient times normal force ``(n,)`` [N].
    friction_limits: Array
    #: Slip M of the cells by elastic displacements under unit tangential forces ``(2 n, 2 n)`` [m/s/N].
    elastic_slip_matrix: Array
    #: Slip J of the cells by unit rigid motions of the bodies ``(2 n, m)``.
    motion_slip_matrix: Array
    #: Indices of the m motions that act on this contact in the vector y of all motions ``(m,)``.
    motion_indices: Index
    #: Prescribed slip w of the cells ``(2 n,)`` [m/s].
    prescribed_slip: Array

    def slip(self, q: Array, y: Array) -> Array:
        """Compute the slip velocity of body 1 past body 2 in every cell ``(2 n,)`` [m/s], all x and then all y.

        ``q``: tangential forces on body 1 (2 n,) [N]; ``y``: motions of all bodies.
        """
        by_motions = self.motion_slip_matrix @ y[self.motion_indices]
        return np.asarray(self.elastic_slip_matrix @ q + by_motions + self.prescribed_slip)

    def rigid_slip(self, y: Array) -> Array:
        """Compute the slip velocities ``(2 n,)`` [m/s] that the rigid motions y cause, without elastic displacements."""
        return np.asarray(self.motion_slip_matrix @ y[self.motion_indices] + self.prescribed_slip)


@dataclass(frozen=True)
class FrictionSolution:
    """Tangential forces, slips and rigid motions that satisfy Coulomb's law in all contacts and equilibrium."""

    #: For every contact, the tangential forces q of its cells ``(2 n,)`` [N].
    forces: list[Array]
    #: For every contact, the slips s of its cells ``(2 n,)`` [m/s].
    slips: list[Array]
    #: Rigid motions y of all bodies, such as the velocities of balls.
    motions: Array
    #: Number of Newton steps.
    steps: int
    #: "converged", or the reason why the solution did not converge.
    status: str
    #: Largest violation of Coulomb's law, as a force, and of equilibrium, over the largest friction limit.
    residual: float
    #: For every contact, whether each cell sticks ``(n,)``.
    stick: list[Flags]

    @property
    def converged(self) -> bool:
        """Whether Coulomb's law and equilibrium are satisfied."""
        return self.status == "converged"


def keep_prescribed_motions(y: Array) -> tuple[Array, Array]:
    """Return zero forces f with a unit derivative df/dy, so that the friction solver leaves the motions y unchanged.

    They replace the equations of equilibrium if the motions are prescribed.
    """
    return np.zeros(y.size), np.eye(y.size)


def _vector_to_xy_rows(v: Array) -> Array:
    """Rearrange a vector (2 n,) of all x, then all y components into rows (x, y) ``(n, 2)``."""
    return v.reshape(2, -1).T


def _xy_rows_to_vector(v: Array) -> Array:
    """Rearrange rows (x, y) of shape (n, 2) into a vector ``(2 n,)`` of all x components and then all y components."""
    return np.asarray(v.T.ravel())


def coulomb_friction_forces(friction_limits: Array, slip: Array, smoothing_speed: float = 0.0) -> Array:
    """Compute friction forces opposite to the slip, by Coulomb's law or by a smoothed law without jump at zero slip.

    Parameters
    ----------
    friction_limits : (n,) Array
        Largest tangential forces [N].
    slip : (2 n,) Array
        Slip [m/s], all x first.
    smoothing_speed : float, default 0.0
        Slip speed v [m/s] below which the smoothed law makes forces fall to zero with the slip; 0: Coulomb's law.

    Returns
    -------
    (2 n,) Array
        Forces -g s / sqrt(s^2 + v^2) [N] with the bound g and the slip s; zero where nothing slips.

    Examples
    --------
    >>> coulomb_friction_forces(np.array([2.0]), np.array([3.0, 4.0])).round(12).tolist()
    [-1.2, -1.6]
    """
    s = _vector_to_xy_rows(slip)
    size = np.sqrt((s**2).sum(axis=1) + smoothing_speed * smoothing_speed)
    return _xy_rows_to_vector(-np.divide(friction_limits, size, out=np.zeros_like(size), where=size > 0.0)[:, None] * s)


# --- one Newton step: forces dq = first + rest @ dy of every contact


def _newton_terms_of_smoothed_law(
    c: FrictionContact, q: Array, y: Array, smoothing_speed: float, elastic: bool
) -> tuple[Array, Array, Array]:
    """Compute the residual of the smoothed friction law, and the terms of Newton's step dq = first + rest @ dy.

    dq: step of the tangential forces; dy: step of the motions. ``c``: the contact; ``q``: tangential forces (2 n,) [N];
    ``y``: motions of all bodies; ``smoothing_speed``: slip speed by which the law is smoothed [m/s]; ``elastic``: whether
    the slip by elastic displacements is included. Returns the residual (2 n,) [N], first (2 n,) [N] and rest (2 n, m).
    """
    s = _vector_to_xy_rows(c.slip(q, y) if elastic else c.rigid_slip(y))
    size = np.sqrt((s**2).sum(axis=1) + smoothing_speed * smoothing_speed)
    left = q + _xy_rows_to_vector((c.friction_limits / size)[:, None] * s)
    unit = s / size[:, None]
    D = (c.friction_limits / size)[:, None, None] * (np.eye(2) - unit[:, :, None] * unit[:, None, :])

    def multiply_by_derivative(A: Array) -> Array:
        two = A.reshape(2, len(s), -1)
        return np.asarray(np.einsum("nij,jnk->ink", D, two).reshape(2 * len(s), -1))

    by_motion = multiply_by_derivative(c.motion_slip_matrix)
    if not elastic:
        return left, -left, -by_motion
    K = np.eye(q.size) + multiply_by_derivative(c.elastic_slip_matrix)
    solved = np.linalg.solve(K, -np.column_stack([left, by_motion]))
    return left, np.asarray(solved[:, 0]), np.asarray(solved[:, 1:])


def _newton_terms_of_coulomb_law(
    c: FrictionContact, q: Array, y: Array, projection_parameter: Array
) -> tuple[Array, Array, Array]:
    """Compute the residual of Coulomb's law, q - P(q - r s), and the terms of Newton's step dq = first + rest @ dy.

    dq: step of the tangential forces; dy: step of the motions. ``c``: the contact; ``q``: tangential forces (2 n,) [N];
    ``y``: motions of all bodies; ``projection_parameter``: the parameter r of each cell (n,) [N s/m]; P: projection onto
    the disk of the largest tangential force; s: slip. Returns the residual (2 n,) [N], first (2 n,) [N] and rest (2 n, m).
    There is one unknown for each slipping cell, and two for each cell that sticks.
    """
    n = c.friction_limits.size
    s = c.slip(q, y)
    pull = _vector_to_xy_rows(q) - projection_parameter[:, None] * _vector_to_xy_rows(s)  # q - r s; (1) is q = P(q - r s)
    size = np.linalg.norm(pull, axis=1)
    stick = size <= c.friction_limits
    slip = np.flatnonzero(~stick)
    unit = pull[slip] / size[slip, None]
    left = _vector_to_xy_rows(np.tile(projection_parameter / SOFT, 2) * s)
    left[slip] = _vector_to_xy_rows(q)[slip] - c.friction_limits[slip, None] * unit
    known = np.zeros((n, 2))
    known[slip] = -np.sum(left[slip] * unit, axis=1)[:, None] * unit
    across = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    held = np.flatnonzero(stick)

    def rows_of_free_unknowns(A: Array) -> Array:
        """Return the rows of a matrix (2 n, k) for the unknowns of Newton's step.

        A slipping cell has one unknown, across the direction of q - r s (q: tangential force, r: projection parameter, s:
        slip of the cell); a cell that sticks has two, along x and y.
        """
        return np.concatenate([across[:, :1] * A[slip] + across[:, 1:] * A[n + slip], A[held], A[n + held]])

    MR = rows_of_free_unknowns(c.elastic_slip_matrix)
    K = rows_of_free_unknowns(MR.T).T  # the same of its columns
    share = c.friction_limits[slip] / size[slip]
    weight = np.concatenate([share * projection_parameter[slip], np.ones(2 * held.size)])
    by_motions = rows_of_free_unknowns(c.motion_slip_matrix)
    right = np.column_stack([MR @ _xy_rows_to_vector(known), by_motions]) * -weight[:, None]
    right[:, 0] -= np.concatenate([np.sum(left[slip] * across, axis=1), s[held], s[n + held]])
    K *= weight[:, None]
    K[np.arange(slip.size), np.arange(slip.size)] += 1.0 - share
    solved = np.linalg.solve(K, right)
    out = np.zeros((2, n, right.shape[1]))
    out[:, slip] = across.T[:, :, None] * solved[: slip.size]
    out[0, held], out[1, held] = solved[slip.size : slip.size + held.size], solved[slip.size + held.size :]
    flat = out.reshape(2 * n, -1)
    return _xy_rows_to_vector(left), flat[:, 0] + _xy_rows_to_vector(known), flat[:, 1:]


# --- all contacts together


@dataclass
class _FrictionProblem:
    """Friction problem of several contacts together with the equilibrium of their bodies: Newton steps and residuals."""

    #: Contacts whose friction is solved together.
    contacts: Sequence[FrictionContact]
    #: Function of the rigid motions y that returns the generalised forces other than friction, and their derivatives by y.
    equilibrium: Balance

    def newton_step(self, parts: list[tuple[Array, Array, Array]], q: list[Array], y: Array) -> tuple[list[Array], Array]:
        """Compute Newton's step dq of the forces of every contact ``(2 n,)`` [N], and dy of the motions of all bodies.

        ``parts``: for every contact three arrays: the residual, and a and B of dq = a + B @ dy; ``q``: tangential forces of
        every contact [N]; ``y``: motions of all bodies.
        """
        f, S = self.equilibrium(y)
        f, S = f.copy(), S.copy()
        for c, force, (_, first, by_y) in zip(self.contacts, q, parts, strict=True):
            f[c.motion_indices] += c.motion_slip_matrix.T @ (force + first)
            S[np.ix_(c.motion_indices, c.motion_indices)] += c.motion_slip_matrix.T @ by_y
        dy: Array = np.asarray(-np.linalg.solve(S, f)) if y.size else y
        return [first + by_y @ dy[c.motion_indices] for c, (_, first, by_y) in zip(self.contacts, parts, strict=True)], dy

    def unbalanced_forces(self, q: list[Array], y: Array) -> Array:
        """Evaluate the unbalanced generalised forces on all rigid motions: friction forces plus the other forces f(y) [N].

        ``q``: tangential forces of every contact [N]; ``y``: motions of all bodies.
        """
        f = self.equilibrium(y)[0].copy()
        for c, force in zip(self.contacts, q, strict=True):
            f[c.motion_indices] += c.motion_slip_matrix.T @ force
        return f


def _solve_smoothed_friction(
    system: _FrictionProblem, q: list[Array], y: Array, smoothing_speed: float, *, elastic: bool
) -> tuple[list[Array], Array]:
    """Solve the smoothed friction law together with equilibrium by Newton's method with step control.

    ``q``, ``y``: starting values of the tangential forces of every contact [N] and of the motions of all bodies;
    ``smoothing_speed``: slip speed by which the law is smoothed [m/s]; ``elastic``: whether the slip by elastic
    displacements is included. Returns the forces and the motions.
    """
    scale = max(float(c.friction_limits.max()) for c in system.contacts)

    def norm_of_residuals(q: list[Array], y: Array) -> float:
        lefts = []
        for c, v in zip(system.contacts, q, strict=True):
            slip = c.slip(v, y) if elastic else c.rigid_slip(y)
            lefts.append(v - coulomb_friction_forces(c.friction_limits, slip, smoothing_speed))
        return float(sum(v @ v for v in lefts) ** 0.5 + np.linalg.norm(system.unbalanced_forces(q, y)))

    norm = norm_of_residuals(q, y)
    for _ in range(STEPS):
        each = zip(system.contacts, q, strict=True)
        parts = [_newton_terms_of_smoothed_law(c, v, y, smoothing_speed, elastic) for c, v in each]
        dq, dy = system.newton_step(parts, q, y)
        t = 1.0
        for _ in range(12):
            trial = [v + t * d for v, d in zip(q, dq, strict=True)], y + t * dy
            new = norm_of_residuals(*trial)
            if new <= (1.0 - 0.1 * t) * norm:
                break
            t *= 0.5
        if not new < norm:
            break
        (q, y), norm = trial, new
        if norm <= 1e-6 * scale:
            break
    return q, y


def _solve_coulomb_friction(system: _FrictionProblem, q: list[Array], y: Array) -> FrictionSolution:
    """Solve Coulomb's law, without smoothing, together with equilibrium by Newton's method.

    ``q``, ``y``: starting values of the tangential forces of every contact [N] and of the motions of all bodies.
    """
    grips = [_projection_parameter(c) for c in system.contacts]
    largest = max(float(c.friction_limits.max()) for c in system.contacts)
    residual, best, steps = np.inf, np.inf, 0
    for steps in range(1, MOST + 1):  # noqa: B007
        parts = [_newton_terms_of_coulomb_law(c, v, y, g) for c, v, g in zip(system.contacts, q, grips, strict=True)]
        residual = max(float(np.abs(p[0]).max()) for p in parts) / largest
        residual = max(residual, float(np.abs(system.unbalanced_forces(q, y)).max(initial=0.0)) / largest)
        if residual <= TOLERANCE or (residual <= 100.0 * TOLERANCE and residual >= best):
            break
        if residual > LOST * max(1.0, best):
            break
        best = min(best, residual)
        try:
            dq, dy = system.newton_step(parts, q, y)
        except np.linalg.LinAlgError:  # an iterate with slipping cells may leave a motion unconstrained
            break
        q, y = [v + d for v, d in zip(q, dq, strict=True)], y + dy
    slips = [c.slip(v, y) for c, v in zip(system.contacts, q, strict=True)]
    stick = []
    for c, v, g, s in zip(system.contacts, q, grips, slips, strict=True):
        pull = _vector_to_xy_rows(v) - g[:, None] * _vector_to_xy_rows(s)
        stick.append(np.linalg.norm(pull, axis=1) <= c.friction_limits)
    good = residual <= 100.0 * TOLERANCE
    status = "converged" if good else f"not converged after {steps} steps (residual {residual:.1e})"
    return FrictionSolution(q, slips, y, steps, status, residual, stick)


def _projection_parameter(c: FrictionContact) -> Array:
    """Choose the projection parameter r of each cell ``(n,)`` [N s/m]: a fraction of force over elastic slip speed."""
    compliance = 0.5 * np.diag(c.elastic_slip_matrix).reshape(2, -1).sum(axis=0)
    return np.asarray(SOFT / compliance)


def solve_rigid_friction(
    contacts: Sequence[FrictionContact], balance: Balance, y: Array, smoothing_ratios: tuple[float, ...]
) -> tuple[Array, float]:
    """Find the motions of rigid bodies at which friction in all contacts and the other forces are in equilibrium.

    Parameters
    ----------
    contacts : Sequence[FrictionContact]
        The contacts.
    balance : Balance
        Function of the k rigid motions y that returns the generalised forces f other than friction, and df/dy.
    y : (k,) Array
        Starting values of the motions of all bodies.
    smoothing_ratios : tuple[float, ...]
        Two or more slip speeds by which Coulomb's law is smoothed in successive solutions, divided by the largest slip; in
        descending order.

    Returns
    -------
    y : (k,) Array
        Motions of all bodies.
    remainder : float
        Error left by the smoothing of Coulomb's law: largest change of a slip in the last step of ``smoothing_ratios``,
        over the largest slip.

    Raises
    ------
    ValueError
        The search ends without equilibrium.
    """
    system = _FrictionProblem(contacts, balance)
    *_, (_, _, last), (_, forces, y) = _solve_with_less_and_less_smoothing(system, y, smoothing_ratios, elastic=False)
    left = float(np.abs(system.unbalanced_forces(forces, y)).max()) / max(float(c.friction_limits.sum()) for c in contacts)
    if not left <= RIGID:
        raise ValueError(
            "the search for the steady rolling of rigid bodies ends without equilibrium: the unbalanced force is "
            f"{left:.1e} times the largest friction of a contact; allowed: up to {RIGID:.0e} times"
        )
    slip = max(float(np.abs(c.motion_slip_matrix @ (y - last)[c.motion_indices]).max()) for c in contacts)
    return y, slip / max(float(np.abs(c.rigid_slip(y)).max()) for c in contacts)


def solve_friction(
    contacts: Sequence[FrictionContact],
    balance: Balance = keep_prescribed_motions,
    y: Array | None = None,
    q: list[Array] | None = None,
    smoothing_ratios: tuple[float, ...] = PATH,
) -> FrictionSolution:
    """Solve Coulomb's law in several contacts together with the equilibrium of the bodies.

    The results are tangential forces, slips and rigid motions. If Coulomb's law does not converge from the starting values,
    the smoothed law provides better ones. `FrictionSolution.status` tells whether the solution converged.

    Parameters
    ----------
    contacts : Sequence[FrictionContact]
        The contacts.
    balance : Balance, default keep_prescribed_motions
        Function of the k rigid motions y that returns the generalised forces f other than friction, and df/dy; by default
        the motions are prescribed.
    y : (k,) Array, optional, default None
        Starting values of the motions of all bodies; None: there are no motions.
    q : list[Array] | None, default None
        Starting values: tangential forces of every contact ``(2 n,)`` [N] of a similar solution; None: no such values.
    smoothing_ratios : tuple[float, ...], default PATH
        Slip speeds by which Coulomb's law is smoothed in successive solutions, divided by the largest slip; in descending
        order.

    Returns
    -------
    FrictionSolution
        The solution.
    """
    system = _FrictionProblem(contacts, balance)
    y = np.zeros(0) if y is None else np.asarray(y, dtype=float)
    if q is not None:
        solution = _solve_coulomb_friction(system, q, y)
        if solution.converged:
            return solution
    *_, (_, forces, moved) = _solve_with_less_and_less_smoothing(system, y, smoothing_ratios, elastic=False)
    solution = _solve_coulomb_friction(system, forces, moved)
    if solution.converged:
        return solution
    for ratio, forces, moved in _solve_with_less_and_less_smoothing(system, y, smoothing_ratios, elastic=True):
        if ratio <= SHARPEST:
            solution = _solve_coulomb_friction(system, forces, moved)
            if solution.converged:
                break
    return solution


def _solve_with_less_and_less_smoothing(
    system: _FrictionProblem, y: Array, smoothing_ratios: Sequence[float], *, elastic: bool
) -> Iterator[tuple[float, list[Array], Array]]:
    """Yield each ratio with the forces and motions under Coulomb's law smoothed by it, each solved from those before.

    ``y``: starting values of the motions; ``smoothing_ratios``: slip speeds by which the law is smoothed, divided by the
    largest slip of rigid bodies at ``y``; ``elastic``: whether the contacts yield tangentially.
    """
    speed = max(float(np.abs(c.rigid_slip(y)).max()) for c in system.contacts)
    forces = [coulomb_friction_forces(c.friction_limits, c.rigid_slip(y), speed) for c in system.contacts]
    for ratio in smoothing_ratios:
        forces, y = _solve_smoothed_friction(system, forces, y, ratio * speed, elastic=elastic)
        yield ratio, forces, y
