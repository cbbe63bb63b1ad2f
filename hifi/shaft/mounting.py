"""3D stretches of screw between beams: compliance of their contacts once supports and loads of a scene are known.

A stretch is fixed at its base section and loaded at the modes m of its contact patches and at ports p (its other end,
stations inside): u_x = F_xm f_m + F_xp f_p + B_x u_base. With the beams' stiffness K and the ports joined to nodes, L =
S_p - S_base B_p^T, the nodes move by

    (K + L F_pp^-1 L^T) U = P + Y^T f_m,  Y = B_m S_base^T + F_mp F_pp^-1 L^T,

and the patches by u_m = (F_mm - F_mp F_pp^-1 F_pm) f_m + Y U: exact, and small enough to redo for every load case.
Several stretches add their L F_pp^-1 L^T; a nut on a housing has that as base, and no port.

The stretch ends in flat rigid sections. Where a beam continues it, the real shaft does not end, and the effect of such a
cut (`hifi.shaft.section`) is subtracted: at the base, in series with all that is attached there, by B A B^T; at the upper
end from the flexibility of that port.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve, qr

from rollbench.hifi.elements.rigid import transport
from rollbench.hifi.shaft.beam import Frame, ShaftSection, beam_stiffness
from rollbench.hifi.shaft.section import at_high, at_low
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import SAME

#: Stiffness of a spring's softest direction over its stiffest one that counts as none.
SLACK = 1e-12


@dataclass(frozen=True)
class Stretch:
    """Flexibility of the part of the screw that is a 3D body (the nut's range and a little beyond), fixed at its base."""

    #: Flexibility over [modes, ports, observers] ``(x, x)``.
    F: Array
    #: Motion of these nodes with the base section ``(x, 6)``.
    B: Array
    #: Station of the base [m].
    base: float
    #: Stations of the ports [m], six rows of F each.
    ports: tuple[float, ...]
    #: Stations of the observers [m], six rows of F each.
    observers: tuple[float, ...]
    #: Stations of its ends [m].
    ends: tuple[float, float]
    #: Number of modes.
    modes: int
    #: Whether every station of the scene moves with the base (a ring on a stiff shaft).
    rigid: bool = False

    def holds(self, z: float) -> bool:
        """Whether a station [m] lies in the stretch, ends included."""
        return self.ends[0] - SAME <= z <= self.ends[1] + SAME

    def lacks(self, z: float) -> bool:
        """Whether a station [m] lies within the ends of the stretch and has no port."""
        inside = self.ends[0] + SAME < z < self.ends[1] - SAME
        return inside and not any(abs(z - known) <= SAME for known in (self.base, *self.ports))

    def moved(self, shift: float) -> Stretch:
        """Stretch moved by ``shift`` [m] along the shaft."""
        stations = {name: tuple(z + shift for z in getattr(self, name)) for name in ("ports", "observers", "ends")}
        return replace(self, base=self.base + shift, **stations)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Carried:
    """A nut on a housing that can move, as one more body of the mounted structure."""

    #: Coupling of its modes with the housing fixed ``(k, k)`` [m/N].
    G: Array
    #: Motion of the modes with the housing ``(k, 6)``.
    B: Array
    #: Number of the housing in its `Frame`.
    housing: int


@dataclass(frozen=True)
class Mounted:
    """Stretches and carried nuts with m modes, under the supports and loads of a frame with h housings."""

    #: Coupling of the modes ``(m, m)`` [m/N].
    G: Array
    #: Motion of the modes by loads and prescribed displacements ``(m,)``.
    loads: Array
    #: Unconstrained rigid motions of the shaft about ``origin`` and of the housings ``(6 (1 + h), k)``.
    motions: Array
    #: Work of the loads on them ``(k,)``.
    work: Array
    #: Station of the reference point of the shaft's rigid motion [m].
    origin: float
    #: Stations of the centreline ``(s,)`` [m].
    stations: tuple[float, ...]
    #: Motion of the centreline by the loads ``(s, 6)`` [m, rad].
    line: Array
    #: Motion of the centreline by modal forces ``(s, 6, m)``.
    line_modes: Array
    #: Motion of the housings by the loads ``(h, 6)`` [m, rad].
    housings: Array
    #: Motion of the housings by modal forces ``(h, 6, m)``.
    housings_modes: Array


def without_cuts(stretch: Stretch, cut: Array, m: GrooveMap, stations: Sequence[float]) -> Stretch:
    """Subtract the effect of the cut ends of a stretch, where the shaft continues.

    An end beyond which there are no supports or loads is unchanged: it is the screw's end, free, or held flat as the
    scene says.

    Parameters
    ----------
    stretch : Stretch
        The stretch.
    cut : (6, 6) Array
        Flexibility of one cut, of `hifi.shaft.section`.
    m : GrooveMap
        Track.
    stations : Sequence[float]
        Stations of supports and loads [m].

    Returns
    -------
    Stretch
        The corrected stretch.
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
    """Correct the beam stiffness of a stretch, whose mesh is too stiff, to that of a section.

    The motion of its end by a force, torque or moment there, without the effect of both cut ends, gives the uniform beam
    as which the mesh behaves; that beam is subtracted, and one of ``section`` added (local defect correction, as for the
    local compliance of a contact).

    Parameters
    ----------
    stretch : Stretch
        The stretch.
    rows : (c, k, 6) Array
        Rigid motions of every contact's modes, as for `beam_stretch`.
    stations : (c,) Array
        Stations of the contacts [m].
    section : ShaftSection
        Stiffnesses of the shaft.
    cut : (6, 6) Array
        Flexibility of one cut.
    m : GrooveMap
        Track.

    Returns
    -------
    Stretch
        The corrected stretch.
    """
    low, high = stretch.ends
    first = stretch.modes + 6 * stretch.ports.index(high)
    end = np.s_[first : first + 6]
    B = stretch.B[end]
    per_length = np.diag(stretch.F[end, end] - B @ at_low(cut, m, low) @ B.T - at_high(cut, m, high)) / (high - low)
    bend = 0.5 * (per_length[3] + per_length[4])
    change = np.array([1.0 / section.EA - per_length[2], 1.0 / section.EI - bend, 1.0 / section.GJ - per_length[5]])
    turn, arms = _followed(rows, stations, stretch)
    F = stretch.F + turn @ _cantilevers(arms, *change) @ turn.T
    return replace(stretch, F=0.5 * (F + F.T))


def mount(stretch: Stretch, scene: Scene, section: ShaftSection) -> Mounted:
    """Mount a stretch on the supports and under the loads of a scene, continued by beams.

    Parameters
    ----------
    stretch : Stretch
        The stretch.
    scene : Scene
        Supports and loads.
    section : ShaftSection
        Section of the beams.

    Returns
    -------
    Mounted
        The mounted stretch.

    Raises
    ------
    ValueError
        As `mount_all`.
    """
    return mount_all((stretch,), Frame.of(scene), lambda _: section)


def mount_all(
    stretches: Sequence[Stretch],
    frame: Frame,
    section_at: Callable[[float], ShaftSection],
    steps: Sequence[float] = (),
    carried: Sequence[Carried] = (),
) -> Mounted:
    """Join stretches on one shaft by beams, with their supports and loads.

    Parameters
    ----------
    stretches : Sequence[Stretch]
        From left to right.
    frame : Frame
        Supports, loads and housings.
    section_at : Callable[[float], ShaftSection]
        Section of the beam at a station [m].
    steps : Sequence[float], optional
        Stations where it changes [m].
    carried : Sequence[Carried], optional
        Nuts on the housings of the frame, whose modes follow those of the stretches.

    Returns
    -------
    Mounted
        The mounted stretches.

    Raises
    ------
    ValueError
        A station inside a stretch has no port, or some stretches are rigid and others are not.
    """
    rigid = stretches[0].rigid
    if any(s.rigid != rigid for s in stretches):
        raise ValueError("the bore of one ring moves as a rigid shaft, and that of another set does not")
    acted = frame.stations
    ends = {z for s in stretches for z in (s.base, *s.ports)}
    low, high = min((*acted, *ends)), max((*acted, *ends))
    between = {z for z in steps if low < z < high and not any(s.holds(z) for s in stretches)}
    nodes = _apart(sorted({*ends, *acted, *between}))
    place = _Places(nodes)
    for z in sorted(acted):
        if not rigid and any(s.lacks(z) for s in stretches):
            raise ValueError(f"the station at {1e3 * z:.4g} mm lies inside the 3D stretch and has no port there")
    n = 6 * len(nodes)
    K = np.zeros((n + 6 * len(frame.housings),) * 2)
    for a, b in pairwise(nodes):
        if rigid or any(s.holds(a) and s.holds(b) for s in stretches):
            continue
        dof = np.r_[place[a] : place[a] + 6, place[b] : place[b] + 6]
        K[np.ix_(dof, dof)] += beam_stiffness(b - a, section_at(0.5 * (a + b)))
    for rows, stiffness in frame.springs():
        K[n:, n:] += rows.T @ stiffness @ rows
    joined = []
    for s in stretches:
        joined.append(_join(s, place, len(K)))
        K = K + joined[-1].K
    Y = np.concatenate([j.Y for j in joined] + [np.zeros((len(c.G), len(K))) for c in carried])
    G = block_diag(*(j.G for j in joined), *(c.G for c in carried))
    first = sum(len(j.G) for j in joined)
    for c in carried:
        Y[first : first + len(c.G), n + 6 * c.housing : n + 6 * c.housing + 6] = c.B
        first += len(c.G)

    T = np.eye(len(K))
    if rigid:
        T = block_diag(np.concatenate([transport(z - stretches[0].base) for z in nodes]), np.eye(len(K) - n))

    def freedom(body: int, at: float) -> int:
        """First freedom of the shaft at a station, or of a housing."""
        return place[at] if body == 0 else n + 6 * (body - 1)

    P = np.zeros(len(K))
    for body, at, wrench in frame.wrenches():
        P[freedom(body, at) : freedom(body, at) + 6] += wrench
    held = [freedom(body, at) + k for body, at, k, _ in frame.holds()]
    values = [value for *_, value in frame.holds()]
    motions = free_motions(frame, nodes[0])
    pins = [place[nodes[0]] + k if k < 6 else n + k - 6 for k in pin_freedoms(motions)]
    # U = T W, constraints R U = r: a basis of what is free, and one state that meets them
    rows = np.zeros((len(held) + len(pins), len(K)))
    rows[np.arange(len(rows)), held + pins] = 1.0
    prescribed = np.array(values + [0.0] * len(pins))
    length = np.tile(1.0 / frame.lengths, T.shape[1] // 6)
    R = rows @ T * length
    if len(rows):
        _, sizes, vt = np.linalg.svd(R)
        rank = int((sizes > 1e-10 * sizes[0]).sum())
        start = length * (np.linalg.pinv(R, rcond=1e-10) @ prescribed)
        free = length[:, None] * vt[rank:].T
    else:
        start, free = np.zeros(T.shape[1]), np.diag(length)
    reduced = free.T @ (T.T @ K @ T) @ free
    at_start = T @ start
    line, by_modes = at_start, np.zeros((len(K), len(G)))
    if free.shape[1]:
        scale = 1.0 / np.sqrt(np.diag(reduced))
        cholesky = cho_factor(reduced * np.outer(scale, scale), lower=True)
        Z = T @ free * scale
        answer = cho_solve(cholesky, Z.T)  # K_ff^-1 on the free motions
        line = at_start + Z @ (answer @ (P - K @ at_start))
        G = G + (Y @ Z) @ (answer @ Y.T)
        by_modes = Z @ (answer @ Y.T)
    observed = np.concatenate([j.Y_o for j in joined])
    inside = block_diag(*(j.G_o for j in joined))
    inside = np.hstack([inside, np.zeros((len(inside), len(G) - inside.shape[1]))])
    stations = (*nodes, *(z for s in stretches for z in s.observers))
    return Mounted(
        0.5 * (G + G.T),
        Y @ line,
        motions,
        _work(frame, motions, nodes[0]),
        nodes[0],
        stations,
        np.concatenate([line[:n], observed @ line]).reshape(-1, 6),
        np.concatenate([by_modes[:n], inside + observed @ by_modes]).reshape(-1, 6, len(G)),
        line[n:].reshape(-1, 6),
        by_modes[n:].reshape(-1, 6, len(G)),
    )


class _Joined(NamedTuple):
    """A stretch between its nodes, d degrees of freedom in all."""

    #: Stiffness that it adds ``(d, d)``.
    K: Array
    #: Motion of its modes by all degrees of freedom ``(m, d)``.
    Y: Array
    #: Motion of its modes by their forces with the nodes fixed ``(m, m)``.
    G: Array
    #: Motion of its observers by all degrees of freedom ``(6 o, d)``.
    Y_o: Array
    #: Motion of its observers by the modes' forces with the nodes fixed ``(6 o, m)``.
    G_o: Array


def _join(stretch: Stretch, place: _Places, size: int) -> _Joined:
    m, p = stretch.modes, 6 * len(stretch.ports)
    F_mm, F_mp, F_pp = stretch.F[:m, :m], stretch.F[:m, m : m + p], stretch.F[m : m + p, m : m + p]
    L = np.zeros((size, p))
    for k, z in enumerate(stretch.ports):
        L[place[z] : place[z] + 6, 6 * k : 6 * k + 6] += np.eye(6)
    base = slice(place[stretch.base], place[stretch.base] + 6)
    L[base] -= stretch.B[m : m + p].T
    joined = np.linalg.solve(F_pp, np.hstack([L.T, F_mp.T])) if p else np.zeros((0, size + m))
    Y = F_mp @ joined[:, :size]  # F_mp F_pp^-1 L^T + B_m S_base^T
    Y[:, base] += stretch.B[:m]
    o = slice(m + p, stretch.F.shape[0])
    F_op = stretch.F[o, m : m + p]
    Y_o = F_op @ joined[:, :size]
    Y_o[:, base] += stretch.B[o]
    return _Joined(L @ joined[:, :size], Y, F_mm - F_mp @ joined[:, size:], Y_o, stretch.F[o, :m] - F_op @ joined[:, size:])


class _Places:
    """First freedom of the node at a station [m]: the nearest one."""

    def __init__(self, nodes: Sequence[float]) -> None:
        self.nodes = np.array(nodes)

    def __getitem__(self, z: float) -> int:
        return 6 * int(np.abs(self.nodes - z).argmin())


def _apart(stations: Sequence[float]) -> list[float]:
    """Sorted stations [m] without those within `SAME` of the one before."""
    return [z for k, z in enumerate(stations) if k == 0 or z - stations[k - 1] > SAME]


def free_motions(frame: Frame, origin: float) -> Array:
    """Rigid motions of screw and housings that neither supports nor springs constrain.

    Parameters
    ----------
    frame : Frame
        Supports and housings.
    origin : float
        Station of the reference point of the screw's motion [m]; a housing moves about its station.

    Returns
    -------
    (6 (1 + h), k) Array
        The motions, as columns.
    """
    scale = np.tile(1.0 / frame.lengths, 1 + len(frame.housings))
    rows = []
    for body, at, k, _ in frame.holds():
        row = np.zeros(scale.size)
        row[6 * body : 6 * body + 6] = transport(at - origin if body == 0 else 0.0)[k]
        rows.append(row * scale)
    size = np.diag(frame.lengths)
    for moved, stiffness in frame.springs():
        value, vector = np.linalg.eigh(np.linalg.inv(size) @ stiffness @ np.linalg.inv(size))
        stiff = vector[:, value > SLACK * value.max(initial=0.0)].T @ size @ moved
        rows += [np.concatenate([np.zeros(6), direction]) * scale for direction in stiff]
    if not rows:
        return np.diag(scale)
    _, s, vt = np.linalg.svd(np.array(rows))
    rank = int((s > 1e-9 * s[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def pin_freedoms(motions: Array) -> list[int]:
    """Degrees of freedom of the origin that fix rigid motions ``(6, k)``."""
    if motions.shape[1] == 0:
        return []
    _, _, order = qr(motions.T, pivoting=True)
    return [int(k) for k in order[: motions.shape[1]]]


def _work(frame: Frame, motions: Array, origin: float) -> Array:
    total = np.zeros(len(motions))
    for body, at, wrench in frame.wrenches():
        total[6 * body : 6 * body + 6] += transport(at - origin if body == 0 else 0.0).T @ wrench
    return np.asarray(motions.T @ total)


def beam_stretch(rows: Array, stations: Array, stretch: Stretch, section: ShaftSection) -> Stretch:
    """Stretch as a plain beam: F of the contacts by beam theory, to see what the 3D shaft contributes.

    Parameters
    ----------
    rows : (c, k, 6) Array
        Rigid motions of every contact's modes about its station.
    stations : (c,) Array
        Stations of the contacts [m].
    stretch : Stretch
        The 3D stretch.
    section : ShaftSection
        Stiffnesses of the beam.

    Returns
    -------
    Stretch
        The beam.

    Raises
    ------
    ValueError
        A section lies below the base.
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
    """Rigid motions of modes, ports and observers with the sections of a beam ``(x, 6 s)``, and arms of these ``(s,)`` [m].

    Arms count from the base. Raises ValueError for a section below the base.
    """
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
    """Flexibility ``(6 s, 6 s)`` of the sections of a beam at ``arms`` ``(s,)`` [m] from its fixed end; no shear.

    axial, bending, torsion: flexibilities of a metre. The motion of section a by loads on section b comes from the part
    up to the nearer one, m.
    """
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
