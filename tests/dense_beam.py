"""Lin's static equations with the motions of shaft and housings as unknowns, dense: an oracle for the contact loads.

E(q, p) = q K q/2 - load q + (energy of balls and rollers at the flank motions L q + v0 and ball centres p), minimised by
Newton's method. It shares no code with the solver (`lowfi.statics.equilibrium`), which condenses the bodies to the contacts
and eliminates the balls; only the arrays that describe the problem are the same. Flanks are circular arcs. Its round-off is
that of K q.
"""

from typing import NamedTuple

import numpy as np

from rollbench.lowfi.statics.problem import Problem
from rollbench.meshes.arrays import Array
from rollbench.meshes.section import BeamSection


def beam_element_stiffness_matrix(length: float, s: BeamSection) -> Array:
    """Return the stiffness matrix ``(12, 12)`` [N/m, N, N m] of a Timoshenko beam element along z.

    Rows and columns are ux, uy, uz, rx, ry, rz of the first node, then of the second.

    Parameters
    ----------
    length
        Length of the element [m].
    s
        Stiffnesses of the cross-section.

    References
    ----------
    Przemieniecki (1968); corrects Lin (2019), D.1 and D.2.
    """
    phi = 12.0 * s.EI / (s.kGA * length**2)
    c = s.EI / (length**3 * (1.0 + phi))
    k = np.zeros((12, 12))
    for u, r, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        i = [u, r, u + 6, r + 6]
        m, near, far = sign * 6.0 * length, (4.0 + phi) * length**2, (2.0 - phi) * length**2
        k[np.ix_(i, i)] = c * np.array([[12.0, m, -12.0, m], [m, near, -m, far], [-12.0, -m, 12.0, -m], [m, far, -m, near]])
    for u, value in ((2, s.EA / length), (5, s.GJ / length)):
        k[np.ix_([u, u + 6], [u, u + 6])] = value * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return k


def screw_beam_stiffness_matrix(problem: Problem) -> Array:
    """Return the stiffness matrix ``(6 n, 6 n)`` of the screw, a beam with n nodes, as a dense array.

    ``problem``: arrays of the scene, with the positions of the nodes and the section of the beam.
    """
    n = problem.nodes.size
    k = np.zeros((6 * n, 6 * n))
    for e, length in enumerate(np.diff(problem.nodes)):
        k[6 * e : 6 * e + 12, 6 * e : 6 * e + 12] += beam_element_stiffness_matrix(float(length), problem.section)
    return k


class Frame(NamedTuple):
    """Bodies with D degrees of freedom, N balls between flanks that move by L q + v0, and S slices of rollers."""

    K: np.ndarray
    load: np.ndarray
    fixed: np.ndarray
    given: np.ndarray
    L: np.ndarray  # (N, 4, 2, D)
    v0: np.ndarray  # (N, 4, 2)
    balls: dict  # arrays of `Balls` of one member
    rows: np.ndarray  # (S, D)
    slices: tuple  # gap, width, g, s, (S,) each


def of_one_member(balls):
    """Arrays of balls without the axis of members."""
    return {name: x[0] for name, x in vars(balls).items()}


def frame_of_problem(problem):
    """The screw of a static problem in a nut that does not move."""
    D, N, m = problem.fixed.size, len(problem.C), problem.B.shape[3]
    K = np.zeros((D, D)) if problem.rigid_motion_basis is not None else screw_beam_stiffness_matrix(problem)
    L, at = np.zeros((N, 4, 2, D)), 6 * problem.first_nodes[..., None] + np.arange(m)
    for s in np.flatnonzero(problem.used_flanks[:2]):
        for i in range(N):
            L[i, s][:, at[i, s]] = problem.B[i, s]
    flat = problem.load.ravel(), problem.fixed.ravel(), np.where(problem.fixed, problem.prescribed, 0.0).ravel()
    return Frame(K, *flat, L, np.zeros((N, 4, 2)), of_one_member(problem.balls), np.zeros((0, D)), (np.zeros(0),) * 4)


def frame_of_assembly(arrays):
    """Shaft, housings and springs of an assembly with all its balls and rollers."""
    s = arrays.structure
    D, N = s.fixed.size, arrays.ball_count
    K, L, v0 = np.zeros((D, D)), np.zeros((N, 4, 2, D)), np.zeros((N, 4, 2))
    for e, (length, section) in enumerate(zip(np.diff(s.nodes), s.sections, strict=True)):
        K[6 * e : 6 * e + 12, 6 * e : 6 * e + 12] += beam_element_stiffness_matrix(length, section)
    for ends, reach, stiffness in s.each_spring():
        J = np.zeros((6, D))
        for end, row in enumerate(ends):
            if row >= 0:
                J[:, 6 * row : 6 * row + 6] += reach[end]
        K += J.T @ stiffness @ J
    for b in arrays.ball_sets:
        v0[b.ball_indices] = b.v0
        for i, of_ball in enumerate(b.first_body_rows):
            for f, row in enumerate(of_ball):
                if row >= 0:
                    L[b.ball_indices.start + i, f][:, 6 * row : 6 * row + b.B.shape[3]] = b.B[i, f]
    rows, slices = [np.zeros((0, D))], [np.zeros((4, 0))]
    for r in arrays.roller_sets:
        x, count = r.rollers, r.row.count * r.row.slices
        of = np.zeros((count, D))
        for ring, row in enumerate(r.ring_bodies):
            if row >= 0:
                of[:, 6 * row : 6 * row + 6] += (1.0, -1.0)[ring] * r.slice_motions(ring)
        rows.append(of)
        each = (x.gaps, x.widths, x.g[..., None], x.s[..., None])
        slices.append(np.stack([np.broadcast_to(y, x.gaps.shape).ravel() for y in each]))
    flat = s.load.ravel(), s.fixed.ravel(), np.where(s.fixed, s.prescribed, 0.0).ravel()
    return Frame(K, *flat, L, v0, of_one_member(arrays.balls), np.concatenate(rows), tuple(np.concatenate(slices, axis=1)))


def line_loads(slices, delta):
    """Force, stiffness and energy of slices of the approach ``delta`` = q (g - s ln q)."""
    _, width, g, s = slices
    d = np.maximum(delta, 1e-12)
    q = d / g
    for _ in range(60):
        q = np.maximum(q - (q * (g - s * np.log(q)) - d) / (g - s * (1.0 + np.log(q))), 0.1 * q)
    stiff, energy = 1.0 / (g - s * (1.0 + np.log(q))), 0.5 * q * q * (g - s * (0.5 + np.log(q)))
    return (np.where(delta > 0.0, width * x, 0.0) for x in (q, stiff, energy))


def loads_of(frame, reach, steps=500):
    """Contact forces ``(N, 4)`` and slice forces in equilibrium [N], and the largest unbalanced force [N].

    The unknowns are the motions of the frame and the displacements of all ball centres. ``reach``: largest motion of a
    centre relative to a flank in one step [m].
    """
    D, N = frame.load.size, len(frame.L)
    J, K, load = np.zeros((N, 4, 2, D + 2 * N)), np.zeros((D + 2 * N,) * 2), np.zeros(D + 2 * N)
    J[..., :D], K[:D, :D], load[:D] = -frame.L, frame.K, frame.load
    for i in range(N):
        J[i, :, 0, D + 2 * i] = J[i, :, 1, D + 2 * i + 1] = 1.0
    rows, free = (
        np.hstack([frame.rows, np.zeros((len(frame.rows), 2 * N))]),
        np.append(~frame.fixed, np.ones(2 * N, dtype=bool)),
    )

    def at(z):
        moved = J @ z - frame.v0
        w = frame.balls["to_ball"] + moved
        size = np.linalg.norm(w, axis=-1)
        delta = frame.balls["approach"] + (moved * (frame.balls["to_ball"] + w)).sum(axis=-1) / (
            size + frame.balls["distance"]
        )
        C, n = frame.balls["C"], w / size[..., None]
        x = np.sqrt(np.where(frame.balls["used"], np.maximum(delta, 0.0), 0.0) / C)
        force, stiff, stored = line_loads(frame.slices, rows @ z - frame.slices[0])
        energy = 0.5 * z @ K @ z - load @ z + (0.4 * C * x**5).sum() + stored.sum()
        g = K @ z - load + np.einsum("nsa,nsaj->j", (x**3)[..., None] * n, J) + rows.T @ force

        def hessian():  # not of the points that a search along a step only tries
            t = np.stack([-n[..., 1], n[..., 0]], axis=-1)
            h = (1.5 * x / C)[..., None, None] * n[..., :, None] * n[..., None, :]
            h = h + (x**3 / size)[..., None, None] * t[..., :, None] * t[..., None, :]
            H = K + np.einsum("nsai,nsab,nsbj->ij", J, h, J, optimize=True) + (rows.T * stiff) @ rows
            return H[np.ix_(free, free)]

        return energy, g[free], hessian, x**3, force

    z, typical = np.append(frame.given, np.zeros(2 * N)), float(np.median(frame.balls["C"])) if N else 1.0
    now, soft, best, stalled = at(z), 1.0, np.inf, 0
    for _ in range(steps):
        energy, g, hessian, force, of_slices = now
        most = max(force.max(initial=0.0), of_slices.max(initial=0.0), np.abs(load).max(), 1e-12)
        off = float(np.abs(g).max()) / most
        best, stalled = min(best, off), 0 if off < 0.5 * best else stalled + 1
        if off <= 1e-13 or (off < 1e-8 and stalled > 4):
            break
        mu = soft * min(1.0, off) * np.cbrt(most) / typical
        step = np.zeros(z.size)
        step[free] = -np.linalg.solve(hessian() + mu * np.eye(len(g)), g)
        far = np.abs(J @ step).max(initial=0.0)
        t, slope = min(1.0, reach / far) if far else 1.0, float(step[free] @ g)
        for _ in range(40):
            new = at(z + t * step)
            if new[0] <= energy + 1e-4 * t * slope or np.abs(new[1]).max() <= 0.5 * np.abs(g).max():
                break
            t *= 0.5
        else:
            if soft > 1e6:
                break
        soft = soft * (4.0 if t < 0.1 else 0.1)
        soft = min(max(soft, 1e-6), 1e8)
        z, now = z + t * step, new
    return now[3], now[4], float(np.abs(now[1]).max())
