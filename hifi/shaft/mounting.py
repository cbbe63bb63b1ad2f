"""A 3D stretch of screw between beams: how its contacts answer once supports and loads of a scene are known.

The stretch is held at its base section and answers generalised loads there: modes m of the contact patches and ports p
(its other end, stations inside) by u_x = F_xm f_m + F_xp f_p + B_x u_base. With the beams' stiffness K and the ports
joined to nodes, L = S_p - S_base B_p^T, the nodes move by

    (K + L F_pp^-1 L^T) U = P + Y^T f_m,  Y = B_m S_base^T + F_mp F_pp^-1 L^T,

and the patches by u_m = (F_mm - F_mp F_pp^-1 F_pm) f_m + Y U: exact, and small enough to redo for every load case.

The stretch ends in flat rigid sections. Where a beam goes on, the real shaft does not end, and what such a cut does
(`hifi.shaft.cut`) is taken off: at the base, where it is in series with all that hangs there, by B A B^T; at the upper end
from the flexibility of that port.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr

from rollbench.hifi.linear_algebra.response import transport
from rollbench.hifi.shaft.beam import ShaftSection, beam_stiffness
from rollbench.hifi.shaft.cut import at_high, at_low
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import FREEDOMS, Scene


@dataclass(frozen=True)
class Stretch:
    """The 3D stretch of screw, held at its base: F over [modes, ports, observers] ``(x, x)``, motion B ``(x, 6)`` of all
    of them with the base section; stations [m] of base, ports and observers (six rows each), the stretch's ends, number
    of modes; ``rigid``: every station of the scene moves with the base (a ring on a stiff shaft)."""

    F: Array
    B: Array
    base: float
    ports: tuple[float, ...]
    observers: tuple[float, ...]
    ends: tuple[float, float]
    modes: int
    rigid: bool = False


@dataclass(frozen=True)
class Mounted:
    """Stretch with a scene's supports and loads: coupling G of the modes ``(m, m)``, their motion by loads and prescribed
    displacements ``(m,)``, unheld rigid motions about ``origin`` ``(6, k)`` and the work of the loads on them ``(k,)``;
    stations of the centreline, its motion by loads ``(s, 6)`` and by modal forces ``(s, 6, m)``."""

    G: Array
    loads: Array
    motions: Array
    work: Array
    origin: float
    stations: tuple[float, ...]
    line: Array
    line_modes: Array


def without_cuts(stretch: Stretch, cut: Array, m: GrooveMap, stations: Sequence[float]) -> Stretch:
    """The stretch as a piece of a shaft that goes on, free of what its cut ends do.

    cut: flexibility ``(6, 6)`` of one (`hifi.shaft.cut`); stations [m]: of supports and loads. An end beyond which there is
    none is unchanged: it is the screw's own, free, or held flat as the scene says.
    """
    low, high = stretch.ends
    F = stretch.F.copy()
    if min(stations) < low:
        F -= stretch.B @ at_low(cut, m, low) @ stretch.B.T
    if max(stations) > high:
        first = stretch.modes + 6 * stretch.ports.index(high)
        F[first : first + 6, first : first + 6] -= at_high(cut, m, high)
    return replace(stretch, F=0.5 * (F + F.T))


def as_stiff_as(stretch: Stretch, rows: Array, stations: Array, section: ShaftSection, cut: Array, m: GrooveMap) -> Stretch:
    """The stretch, its mesh too stiff as a beam, made to stretch, twist and bend as a shaft of ``section`` does.

    What its end yields to a force, a torque or a moment there, free of what both cut ends do, says as what uniform beam the
    mesh behaves; that beam is taken off, and one of ``section`` put in its place (local defect correction, as for a
    contact's own compliance). rows ``(c, k, 6)``, stations ``(c,)`` as for `beam_stretch`; cut: as for `without_cuts`.
    """
    low, high = stretch.ends
    first = stretch.modes + 6 * stretch.ports.index(high)
    end = np.s_[first : first + 6]
    B = stretch.B[end]
    own = np.diag(stretch.F[end, end] - B @ at_low(cut, m, low) @ B.T - at_high(cut, m, high)) / (high - low)
    bend = 0.5 * (own[3] + own[4])
    change = np.array([1.0 / section.EA - own[2], 1.0 / section.EI - bend, 1.0 / section.GJ - own[5]])
    turn, arms = _followed(rows, stations, stretch)
    F = stretch.F + turn @ _cantilevers(arms, *change) @ turn.T
    return replace(stretch, F=0.5 * (F + F.T))


def mount(stretch: Stretch, scene: Scene, section: ShaftSection) -> Mounted:
    """Supports and loads of a scene on a stretch continued by beams of ``section``.

    Raises ValueError where a station inside the stretch has no port.
    """
    own = sorted({x.at for x in scene.supports} | {x.at for x in scene.loads})
    nodes = sorted({stretch.base, *stretch.ports, *own})
    place = {z: 6 * k for k, z in enumerate(nodes)}
    low, high = stretch.ends
    for z in own:
        if low < z < high and z not in stretch.ports and not stretch.rigid and z != stretch.base:
            raise ValueError(f"the station at {1e3 * z:.4g} mm lies inside the 3D stretch and has no port there")
    K = np.zeros((6 * len(nodes), 6 * len(nodes)))
    for a, b in pairwise(nodes):
        if stretch.rigid or (a >= low and b <= high):
            continue
        dof = np.r_[place[a] : place[a] + 6, place[b] : place[b] + 6]
        K[np.ix_(dof, dof)] += beam_stiffness(b - a, section)
    m, p = stretch.modes, 6 * len(stretch.ports)
    F_mm, F_mp, F_pp = stretch.F[:m, :m], stretch.F[:m, m : m + p], stretch.F[m : m + p, m : m + p]
    L = np.zeros((len(K), p))
    for k, z in enumerate(stretch.ports):
        L[place[z] : place[z] + 6, 6 * k : 6 * k + 6] += np.eye(6)
    base = slice(place[stretch.base], place[stretch.base] + 6)
    L[base] -= stretch.B[m : m + p].T
    joined = np.linalg.solve(F_pp, np.hstack([L.T, F_mp.T])) if p else np.zeros((0, len(K) + m))
    K = K + L @ joined[:, : len(K)]
    Y = F_mp @ joined[:, : len(K)]
    Y[:, base] += stretch.B[:m]
    fixed_G = F_mm - F_mp @ joined[:, len(K) :]
    o = slice(m + p, stretch.F.shape[0])
    F_op = stretch.F[o, m : m + p]
    Y_o = F_op @ joined[:, : len(K)]
    Y_o[:, base] += stretch.B[o]
    fixed_o = stretch.F[o, :m] - F_op @ joined[:, len(K) :]

    T = _followers(nodes, stretch) if stretch.rigid else np.eye(len(K))
    P = np.zeros(len(K))
    for load in scene.loads:
        P[place[load.at] : place[load.at] + 3] += load.force
        P[place[load.at] + 3 : place[load.at] + 6] += load.moment
    held, values = _held(scene, place)
    motions = unheld(scene, nodes[0])
    pins = [place[nodes[0]] + k for k in pin_freedoms(motions)]
    # U = T W, constraints R U = r: a basis of what is free, and one state that meets them
    rows = np.zeros((len(held) + len(pins), len(K)))
    rows[np.arange(len(rows)), held + pins] = 1.0
    given = np.concatenate([values, np.zeros(len(pins))])
    length = np.tile(np.r_[np.ones(3), np.full(3, 1.0 / scene.track.pitch_radius)], T.shape[1] // 6)
    R = rows @ T * length
    if len(rows):
        _, s, vt = np.linalg.svd(R)
        rank = int((s > 1e-10 * s[0]).sum())
        start = length * (np.linalg.pinv(R, rcond=1e-10) @ given)
        free = length[:, None] * vt[rank:].T
    else:
        start, free = np.zeros(T.shape[1]), np.diag(length)
    reduced = free.T @ (T.T @ K @ T) @ free
    first = T @ start
    moved, line0 = first, first
    if free.shape[1]:
        scale = 1.0 / np.sqrt(np.diag(reduced))
        found = cho_factor(reduced * np.outer(scale, scale), lower=True)
        Z = T @ free * scale
        answer = cho_solve(found, Z.T)  # K_ff^-1 on the free motions
        moved = first + Z @ (answer @ (P - K @ first))
        line0 = moved
        G = fixed_G + (Y @ Z) @ (answer @ Y.T)
        nodes_modes = Z @ (answer @ Y.T)
    else:
        G, nodes_modes = fixed_G, np.zeros((len(K), m))
    stations = (*nodes, *stretch.observers)
    line = np.concatenate([line0, Y_o @ line0]).reshape(-1, 6)
    line_modes = np.concatenate([nodes_modes, fixed_o + Y_o @ nodes_modes]).reshape(-1, 6, m)
    return Mounted(
        0.5 * (G + G.T), Y @ moved, motions, _work(scene, motions, nodes[0]), nodes[0], stations, line, line_modes
    )


def _followers(nodes: Sequence[float], stretch: Stretch) -> Array:
    """U of all nodes from the base's motion, for a stretch whose stations move with its base."""
    return np.concatenate([transport(z - stretch.base) for z in nodes])


def _held(scene: Scene, place: dict[float, int]) -> tuple[list[int], Array]:
    fixed = [(place[x.at] + FREEDOMS.index(name), value) for x in scene.supports for name, value in x.fixed]
    return [k for k, _ in fixed], np.array([v for _, v in fixed], dtype=float)


def unheld(scene: Scene, origin: float) -> Array:
    """Rigid motions of the screw about ``origin`` that no support holds, ``(6, k)``."""
    arm = scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    rows = [transport(x.at - origin)[FREEDOMS.index(name)] * scale for x in scene.supports for name, _ in x.fixed]
    if not rows:
        return np.diag(scale)
    _, s, vt = np.linalg.svd(np.array(rows))
    rank = int((s > 1e-9 * s[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def pin_freedoms(motions: Array) -> list[int]:
    """Freedoms of the origin that hold the rigid ``motions`` ``(6, k)``."""
    if motions.shape[1] == 0:
        return []
    _, _, order = qr(motions.T, pivoting=True)
    return [int(k) for k in order[: motions.shape[1]]]


def _work(scene: Scene, motions: Array, origin: float) -> Array:
    wrench = np.zeros(6)
    for load in scene.loads:
        force, moment = np.array(load.force), np.array(load.moment)
        wrench[:3] += force
        wrench[3:] += moment + np.cross([0.0, 0.0, load.at - origin], force)
    return np.asarray(motions.T @ wrench)


def beam_stretch(rows: Array, stations: Array, stretch: Stretch, section: ShaftSection) -> Stretch:
    """The stretch as a plain beam: F of the contacts by beam theory, for the ablation of the 3D shaft.

    rows: rigid rows ``(c, k, 6)`` of every contact's modes about its own station; stations ``(c,)`` [m].
    """
    c, k, _ = rows.shape
    turn, arms = _followed(rows, stations, stretch)
    flexibility = _cantilevers(arms, 1.0 / section.EA, 1.0 / section.EI, 1.0 / section.GJ)
    shear = np.minimum(arms[:, None], arms) / section.kGA
    flexibility[0::6, 0::6] += shear
    flexibility[1::6, 1::6] += shear
    F = turn @ flexibility @ turn.T
    B = turn @ np.concatenate([transport(a) for a in arms])
    return Stretch(0.5 * (F + F.T), B, stretch.base, stretch.ports, stretch.observers, stretch.ends, c * k)


def _followed(rows: Array, stations: Array, stretch: Stretch) -> tuple[Array, Array]:
    """Modes, ports and observers of a stretch that follow the sections of a beam rigidly ``(x, 6 s)``, and the arms
    ``(s,)`` [m] of these sections from the base. Raises ValueError for one below the base."""
    c, k, _ = rows.shape
    arms = np.concatenate([stations, stretch.ports, stretch.observers]) - stretch.base
    if arms.min() < 0.0:
        raise ValueError("a section lies below the base of the 3D stretch")
    turn = np.zeros((c * k + 6 * (arms.size - c), 6 * arms.size))
    for i in range(c):
        turn[i * k : (i + 1) * k, 6 * i : 6 * i + 6] = rows[i]
    turn[c * k :, 6 * c :] = np.eye(6 * (arms.size - c))
    return turn, arms


def _cantilevers(arms: Array, axial: float, bending: float, torsion: float) -> Array:
    """Flexibility ``(6 s, 6 s)`` of a beam's sections at ``arms`` ``(s,)`` [m] from where it is held, from that of its
    length: motion of section a by loads on section b, to which the part up to the nearer one, m, yields; no shear."""
    a, b = arms[:, None], arms[None, :]
    m = np.minimum(a, b)
    F = np.zeros((6 * arms.size, 6 * arms.size))
    across = bending * (a * b * m - 0.5 * (a + b) * m**2 + m**3 / 3.0)
    by_moment = bending * (a * m - 0.5 * m**2)  # u_x by M_y, -u_y by M_x
    for i, j, entry in ((0, 0, across), (1, 1, across), (0, 4, by_moment), (1, 3, -by_moment)):
        F[i::6, j::6] = entry
    F[4::6, 0::6], F[3::6, 1::6] = by_moment.T, -by_moment.T
    F[3::6, 3::6] = F[4::6, 4::6] = bending * m
    F[2::6, 2::6], F[5::6, 5::6] = axial * m, torsion * m
    return F
