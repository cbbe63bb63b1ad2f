"""3D stretches of the screw between beams: compliance of their contacts for the supports and loads of a scene.

A stretch is the part of the screw around a nut that is meshed in 3D. It is fixed at its base section, and loaded by forces
f_m on the displacement modes m of its contacts and by forces f_p at its ports p: its other end, and the supports and loads
inside. The modes and ports (x stands for either) move by u_x = F_xm f_m + F_xp f_p + B_x u_base, with the flexibility F of
the stretch, the motion u_base of the base, and the motions B by unit motions of the base. K is the beams' stiffness, and
S_p and S_base select the degrees of freedom of the nodes to which ports and base are joined. With L = S_p - S_base B_p^T,
loads P on the nodes move them by U:

    (K + L F_pp^-1 L^T) U = P + Y^T f_m,  Y = B_m S_base^T + F_mp F_pp^-1 L^T,

and the contacts' modes by u_m = (F_mm - F_mp F_pp^-1 F_pm) f_m + Y U: exact, and small enough to redo for every load case.
Several stretches add their L F_pp^-1 L^T. A nut on a housing has the housing as its base, and no port.

The stretch ends in flat rigid sections. Where a beam continues it, the real shaft does not end, and the effect of such a
cut (`hifi.shaft.section`) is subtracted: at the base, in series with all that is attached there, by B A B^T; at the upper
end from the flexibility of that port.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve, qr

from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.shaft.beam import ShaftSection, ShaftSupports, beam_stiffness
from rollbench.hifi.shaft.section import flexibility_of_lower_cut_end, flexibility_of_upper_cut_end
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import SAME

#: Stiffness of a spring in one direction, over that in its stiffest direction, below which it counts as zero.
SLACK = 1e-12


@dataclass(frozen=True)
class MeshedShaftPart:
    """Flexibility of the part of the screw that is meshed in 3D around the nut (stretch), with its base section fixed."""

    #: Flexibility with the base section fixed: displacements of the contacts' modes, then of ports and observers (six rows
    #: each), by unit forces and moments on all of these ``(x, x)``.
    F: Array
    #: Displacements of the contacts' modes, ports and observers by unit rigid motions of the base section ``(x, 6)``.
    B: Array
    #: Axial position of the base section [m].
    base_position: float
    #: Axial positions of the ports, the sections that can be loaded or supported [m]; each has six rows of F.
    ports: tuple[float, ...]
    #: Axial positions of the observers, the sections whose motion is computed [m]; each has six rows of F.
    observers: tuple[float, ...]
    #: Axial positions of the lower and upper end of this part of the screw [m].
    ends: tuple[float, float]
    #: Number of displacement modes of all contacts on this part of the screw together.
    mode_count: int
    #: Whether all supported and loaded sections move rigidly with the base section (as for a ring on a stiff shaft).
    moves_with_base: bool = False

    def contains(self, z: float) -> bool:
        """Return whether an axial position z [m] lies in the part of the screw that is meshed in 3D, ends included."""
        return self.ends[0] - SAME <= z <= self.ends[1] + SAME

    def is_at_unloadable_section(self, z: float) -> bool:
        """Return whether an axial position z [m] in the 3D part of the screw is at no section that can be loaded.

        The base section and the ports can be loaded.
        """
        inside = self.ends[0] + SAME < z < self.ends[1] - SAME
        return inside and not any(abs(z - known) <= SAME for known in (self.base_position, *self.ports))

    def shift_along_shaft(self, shift: float) -> MeshedShaftPart:
        """Return a copy of this part of the screw whose axial positions are increased by ``shift`` [m]."""
        stations = {name: tuple(z + shift for z in getattr(self, name)) for name in ("ports", "observers", "ends")}
        return replace(self, base_position=self.base_position + shift, **stations)  # type: ignore[arg-type]


@dataclass(frozen=True)
class NutOnHousing:
    """Compliance of a nut on a movable housing, to be joined to the shaft and its supports."""

    #: Compliance between the k displacement modes of the nut's contacts, with the housing fixed ``(k, k)`` [m/N].
    G: Array
    #: Displacements of the k modes by unit rigid motions of the housing ``(k, 6)``.
    B: Array
    #: Index of the nut's housing in `ShaftSupports.housings`, from 0.
    housing: int


@dataclass(frozen=True)
class SupportedShaft:
    """Compliance and displacements of a supported and loaded shaft at its contacts, with its h movable housings.

    The contacts of shaft and nuts on movable housings have m displacement modes in all.
    """

    #: Compliance between the m displacement modes of all contacts ``(m, m)`` [m/N].
    G: Array
    #: Displacements of the contacts' modes by the loads and prescribed motions of the shaft ``(m,)`` [m].
    mode_displacements_by_loads: Array
    #: The k rigid motions that no support prevents, of the shaft about ``origin_position`` and of the housings ``(6 (1 +
    #: h), k)``.
    free_motions: Array
    #: Work of the loads in a unit of each of the ``free_motions`` ``(k,)``.
    work_on_free_motions: Array
    #: Axial position of the reference point of the shaft's rigid motion [m].
    origin_position: float
    #: Axial positions at which the motion of the shaft's centreline is given ``(s,)`` [m].
    centreline_positions: tuple[float, ...]
    #: Motion of the shaft's centreline by the loads ``(s, 6)`` [m, rad].
    centreline_by_loads: Array
    #: Motion of the shaft's centreline by unit forces on the contacts' modes ``(s, 6, m)``.
    centreline_by_modal_forces: Array
    #: Motion of the housings by the loads ``(h, 6)`` [m, rad].
    housings_by_loads: Array
    #: Motion of the housings by unit forces on the contacts' modes ``(h, 6, m)``.
    housings_by_modal_forces: Array


def subtract_cut_end_flexibility(
    stretch: MeshedShaftPart, cut: Array, m: GrooveMap, support_and_load_positions: Sequence[float]
) -> MeshedShaftPart:
    """Correct the flexibility of the screw's 3D part for its ends, where the mesh is cut but the real shaft continues.

    An end beyond which no support or load lies is not corrected: the real screw is then taken to end there too.

    Parameters
    ----------
    stretch : MeshedShaftPart
        The part of the shaft that is meshed in 3D.
    cut : (6, 6) Array
        Flexibility E that one cut end adds to a beam [m/N, 1/N, 1/(N m)], of `hifi.shaft.section`.
    m : GrooveMap
        Geometry of the track.
    support_and_load_positions : Sequence[float]
        Axial positions of supports and loads [m].

    Returns
    -------
    MeshedShaftPart
        The corrected 3D part.
    """
    low, high = stretch.ends
    F = stretch.F.copy()
    if min(support_and_load_positions) < low:
        F -= stretch.B @ flexibility_of_lower_cut_end(cut, m, low) @ stretch.B.T
    if max(support_and_load_positions) > high:
        first = stretch.mode_count + 6 * stretch.ports.index(high)
        F[first : first + 6, first : first + 6] -= flexibility_of_upper_cut_end(cut, m, high)
    return replace(stretch, F=0.5 * (F + F.T))


def correct_beam_stiffness(
    stretch: MeshedShaftPart,
    modes_by_rigid_motions: Array,
    contact_positions: Array,
    section: ShaftSection,
    cut: Array,
    m: GrooveMap,
) -> MeshedShaftPart:
    """Correct the 3D part of the screw, whose mesh is too stiff, to the beam stiffness of a given cross-section.

    The motion of its upper end under forces and moments there, less the effect of both cut ends, shows to which uniform
    beam the mesh is equivalent. The flexibility of that beam is subtracted, and that of a beam with ``section`` is added
    (local defect correction, as for the local compliance of a contact).

    Parameters
    ----------
    stretch : MeshedShaftPart
        The part of the shaft that is meshed in 3D.
    modes_by_rigid_motions : (c, k, 6) Array
        Displacements of the k modes of each of the c contacts by unit rigid motions of the shaft about the contact's axial
        position.
    contact_positions : (c,) Array
        Axial positions of the contacts [m].
    section : ShaftSection
        Stiffnesses of the shaft.
    cut : (6, 6) Array
        Flexibility E of one cut end [m/N, 1/N, 1/(N m)].
    m : GrooveMap
        Geometry of the track.

    Returns
    -------
    MeshedShaftPart
        The corrected 3D part.
    """
    low, high = stretch.ends
    first = stretch.mode_count + 6 * stretch.ports.index(high)
    end = np.s_[first : first + 6]
    lower, upper = flexibility_of_lower_cut_end(cut, m, low), flexibility_of_upper_cut_end(cut, m, high)
    B = stretch.B[end]
    per_length = np.diag(stretch.F[end, end] - B @ lower @ B.T - upper) / (high - low)
    bend = 0.5 * (per_length[3] + per_length[4])
    change = np.array([1.0 / section.EA - per_length[2], 1.0 / section.EI - bend, 1.0 / section.GJ - per_length[5]])
    turn, arms = _motions_by_section_motions(modes_by_rigid_motions, contact_positions, stretch)
    F = stretch.F + turn @ _flexibility_between_beam_sections(arms, *change) @ turn.T
    return replace(stretch, F=0.5 * (F + F.T))


def support_shaft_part(stretch: MeshedShaftPart, scene: Scene, section: ShaftSection) -> SupportedShaft:
    """Join the 3D part of the screw to beams at both ends, and apply the supports and loads of a scene.

    Parameters
    ----------
    stretch : MeshedShaftPart
        The part of the shaft that is meshed in 3D.
    scene : Scene
        Supports and loads.
    section : ShaftSection
        Section of the beams.

    Returns
    -------
    SupportedShaft
        Compliance and displacements at the contacts.

    Raises
    ------
    ValueError
        A support or load inside the 3D part lies at none of its ports (sections that can be loaded).
    """
    return join_and_support_shaft_parts((stretch,), ShaftSupports.from_scene(scene), lambda _: section)


def join_and_support_shaft_parts(
    stretches: Sequence[MeshedShaftPart],
    frame: ShaftSupports,
    section_at: Callable[[float], ShaftSection],
    section_changes: Sequence[float] = (),
    nuts_on_housings: Sequence[NutOnHousing] = (),
) -> SupportedShaft:
    """Join the 3D parts of a shaft by beams, and apply its supports and loads.

    Parameters
    ----------
    stretches : Sequence[MeshedShaftPart]
        Parts of the shaft that are meshed in 3D, from left to right.
    frame : ShaftSupports
        Supports, loads and housings.
    section_at : Callable[[float], ShaftSection]
        Function that returns the section of the beam at an axial position [m].
    section_changes : Sequence[float], optional
        Axial positions where the section changes [m].
    nuts_on_housings : Sequence[NutOnHousing], optional
        Nuts on the housings of the frame, whose modes follow those of the stretches.

    Returns
    -------
    SupportedShaft
        Compliance and displacements at the contacts of shaft and carried nuts.

    Raises
    ------
    ValueError
        A support or load inside a 3D part lies at none of its ports (sections that can be loaded), or some 3D parts are
        rigid and others are not.
    """
    rigid = stretches[0].moves_with_base
    if any(s.moves_with_base != rigid for s in stretches):
        raise ValueError(
            "some rings on the shaft have a rigid bore, which moves with the shaft, and others an elastic one: give all "
            "rings the same kind of bore"
        )
    acted = frame.support_and_load_positions
    ends = {z for s in stretches for z in (s.base_position, *s.ports)}
    low, high = min((*acted, *ends)), max((*acted, *ends))
    between = {z for z in section_changes if low < z < high and not any(s.contains(z) for s in stretches)}
    stations = sorted({*ends, *acted, *between})
    nodes = [z for k, z in enumerate(stations) if k == 0 or z - stations[k - 1] > SAME]
    n = 6 * len(nodes)

    def first_freedom_of(body: int, at: float) -> int:
        """Return the index of the first degree of freedom of the shaft's node at an axial position, or of a housing.

        ``body``: 0 for the shaft, 1 and up for the housings; ``at``: axial position on the shaft [m].
        """
        return 6 * int(np.abs(np.array(nodes) - at).argmin()) if body == 0 else n + 6 * (body - 1)

    for z in sorted(acted):
        if not rigid and any(s.is_at_unloadable_section(z) for s in stretches):
            raise ValueError(
                f"the support or load at z = {1e3 * z:.4g} mm lies inside the part of the shaft that is meshed in 3D, at a "
                "section whose motion was not kept in the condensation: condense the shaft with the supports and loads of "
                "all scenes that will be solved"
            )
    K = np.zeros((n + 6 * len(frame.housings),) * 2)
    for a, b in pairwise(nodes):
        if rigid or any(s.contains(a) and s.contains(b) for s in stretches):
            continue
        dof = np.concatenate([first_freedom_of(0, z) + np.arange(6) for z in (a, b)])
        K[np.ix_(dof, dof)] += beam_stiffness(b - a, section_at(0.5 * (a + b)))
    for rows, stiffness in frame.spring_stiffnesses():
        K[n:, n:] += rows.T @ stiffness @ rows
    joined = []
    for s in stretches:
        joined.append(_contribution_of_shaft_part(s, partial(first_freedom_of, 0), len(K)))
        K = K + joined[-1].K
    Y = np.concatenate([j.modes_by_node_motions for j in joined] + [np.zeros((len(c.G), len(K))) for c in nuts_on_housings])
    G = block_diag(*(j.G for j in joined), *(c.G for c in nuts_on_housings))
    first = sum(len(j.G) for j in joined)
    for c in nuts_on_housings:
        Y[first : first + len(c.G), n + 6 * c.housing : n + 6 * c.housing + 6] = c.B
        first += len(c.G)

    T = np.eye(len(K))
    if rigid:
        transfers = [rigid_motion_transfer_along_z(z - stretches[0].base_position) for z in nodes]
        T = block_diag(np.concatenate(transfers), np.eye(len(K) - n))
    P = np.zeros(len(K))
    for body, at, wrench in frame.forces_and_moments():
        P[first_freedom_of(body, at) : first_freedom_of(body, at) + 6] += wrench
    held = [first_freedom_of(body, at) + k for body, at, k, _ in frame.prescribed_motions()]
    values = [value for *_, value in frame.prescribed_motions()]
    motions = find_unconstrained_rigid_motions(frame, nodes[0])
    pins = [k if k < 6 else n + k - 6 for k in select_freedoms_to_constrain(motions)]  # of the first node, of housings
    # U = T W, constraints R U = r: a basis of the free motions, and one state that meets the constraints
    rows = np.zeros((len(held) + len(pins), len(K)))
    rows[np.arange(len(rows)), held + pins] = 1.0
    prescribed = np.array(values + [0.0] * len(pins))
    length = np.tile(1.0 / frame.lengths_of_unit_motions, T.shape[1] // 6)
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
    observed = np.concatenate([j.observers_by_node_motions for j in joined])
    inside = block_diag(*(j.observers_by_modal_forces for j in joined))
    inside = np.hstack([inside, np.zeros((len(inside), len(G) - inside.shape[1]))])
    centreline = (*nodes, *(z for s in stretches for z in s.observers))
    return SupportedShaft(
        0.5 * (G + G.T),
        Y @ line,
        motions,
        _work_of_loads_on_motions(frame, motions, nodes[0]),
        nodes[0],
        centreline,
        np.concatenate([line[:n], observed @ line]).reshape(-1, 6),
        np.concatenate([by_modes[:n], inside + observed @ by_modes]).reshape(-1, 6, len(G)),
        line[n:].reshape(-1, 6),
        by_modes[n:].reshape(-1, 6, len(G)),
    )


class _ShaftPartContribution(NamedTuple):
    """Stiffness and compliance that one 3D part of the shaft adds to the structure of shaft and housings.

    The structure has d degrees of freedom.
    """

    #: Stiffness that the 3D part adds to the structure ``(d, d)``.
    K: Array
    #: Displacements of the m contact modes of the 3D part by unit motions of all degrees of freedom ``(m, d)``.
    modes_by_node_motions: Array
    #: Displacements of the contact modes by unit forces on them, with the structure's nodes fixed ``(m, m)`` [m/N].
    G: Array
    #: Motion of the 3D part's o observers (sections whose motion is computed) by unit motions of all degrees of freedom
    #: ``(6 o, d)``.
    observers_by_node_motions: Array
    #: Motion of the observers by unit forces on the contact modes, with the structure's nodes fixed ``(6 o, m)``.
    observers_by_modal_forces: Array


def _contribution_of_shaft_part(
    stretch: MeshedShaftPart, first_freedom_at: Callable[[float], int], freedom_count: int
) -> _ShaftPartContribution:
    """Compute the stiffness and compliance that one 3D part of the shaft adds to the structure of shaft and housings.

    ``first_freedom_at``: function that gives, for an axial position, the first degree of freedom of the node there;
    ``freedom_count``: number of degrees of freedom of the structure.
    """
    m, p = stretch.mode_count, 6 * len(stretch.ports)
    F_mm, F_mp, F_pp = stretch.F[:m, :m], stretch.F[:m, m : m + p], stretch.F[m : m + p, m : m + p]
    L = np.zeros((freedom_count, p))
    for k, z in enumerate(stretch.ports):
        L[first_freedom_at(z) : first_freedom_at(z) + 6, 6 * k : 6 * k + 6] += np.eye(6)
    first = first_freedom_at(stretch.base_position)
    base = slice(first, first + 6)
    L[base] -= stretch.B[m : m + p].T
    joined = np.linalg.solve(F_pp, np.hstack([L.T, F_mp.T])) if p else np.zeros((0, freedom_count + m))
    by_nodes, by_modes = joined[:, :freedom_count], joined[:, freedom_count:]
    Y = F_mp @ by_nodes  # F_mp F_pp^-1 L^T + B_m S_base^T
    Y[:, base] += stretch.B[:m]
    o = slice(m + p, stretch.F.shape[0])
    F_op = stretch.F[o, m : m + p]
    Y_o = F_op @ by_nodes
    Y_o[:, base] += stretch.B[o]
    return _ShaftPartContribution(L @ by_nodes, Y, F_mm - F_mp @ by_modes, Y_o, stretch.F[o, :m] - F_op @ by_modes)


def find_unconstrained_rigid_motions(frame: ShaftSupports, origin: float) -> Array:
    """Find the rigid motions of screw and housings that neither supports nor springs constrain.

    Parameters
    ----------
    frame : ShaftSupports
        Supports and housings.
    origin : float
        Axial position of the reference point of the screw's motion [m]; a housing moves about its own position.

    Returns
    -------
    (6 (1 + h), k) Array
        The k motions as columns: six components of the screw, then six of each of the h housings [m, rad].
    """
    scale = np.tile(1.0 / frame.lengths_of_unit_motions, 1 + len(frame.housings))
    rows = []
    for body, at, k, _ in frame.prescribed_motions():
        row = np.zeros(scale.size)
        row[6 * body : 6 * body + 6] = rigid_motion_transfer_along_z(at - origin if body == 0 else 0.0)[k]
        rows.append(row * scale)
    size = np.diag(frame.lengths_of_unit_motions)
    for moved, stiffness in frame.spring_stiffnesses():
        value, vector = np.linalg.eigh(np.linalg.inv(size) @ stiffness @ np.linalg.inv(size))
        stiff = vector[:, value > SLACK * value.max(initial=0.0)].T @ size @ moved
        rows += [np.concatenate([np.zeros(6), direction]) * scale for direction in stiff]
    if not rows:
        return np.diag(scale)
    _, s, vt = np.linalg.svd(np.array(rows))
    rank = int((s > 1e-9 * s[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def select_freedoms_to_constrain(motions: Array) -> list[int]:
    """Select k degrees of freedom that must be constrained to prevent k rigid motions of shaft and housings.

    ``motions``: the motions from `find_unconstrained_rigid_motions` as columns (6 (1 + h), k). Returns the indices of their
    rows.
    """
    if motions.shape[1] == 0:
        return []
    _, _, order = qr(motions.T, pivoting=True)
    return [int(k) for k in order[: motions.shape[1]]]


def _work_of_loads_on_motions(frame: ShaftSupports, motions: Array, origin: float) -> Array:
    """Compute the work ``(k,)`` of all loads on shaft and housings in k unit rigid motions.

    ``motions``: the rigid motions of `find_unconstrained_rigid_motions` (6 (1 + h), k); ``origin``: reference point of the
    screw's motion [m].
    """
    total = np.zeros(len(motions))
    for body, at, wrench in frame.forces_and_moments():
        total[6 * body : 6 * body + 6] += rigid_motion_transfer_along_z(at - origin if body == 0 else 0.0).T @ wrench
    return np.asarray(motions.T @ total)


def replace_shaft_part_by_beam(
    modes_by_rigid_motions: Array, contact_positions: Array, stretch: MeshedShaftPart, section: ShaftSection
) -> MeshedShaftPart:
    """Replace the flexibility of the screw's 3D part by that of a Timoshenko beam, to see what the 3D mesh contributes.

    Parameters
    ----------
    modes_by_rigid_motions : (c, k, 6) Array
        Displacements of the k modes of each of the c contacts by unit rigid motions of the shaft about the contact's axial
        position.
    contact_positions : (c,) Array
        Axial positions of the contacts [m].
    stretch : MeshedShaftPart
        The part of the shaft that is meshed in 3D.
    section : ShaftSection
        Stiffnesses of the beam.

    Returns
    -------
    MeshedShaftPart
        Flexibility of the beam in place of that 3D part.

    Raises
    ------
    ValueError
        A contact or section lies below the base.
    """
    c, k, _ = modes_by_rigid_motions.shape
    turn, arms = _motions_by_section_motions(modes_by_rigid_motions, contact_positions, stretch)
    flexibility = _flexibility_between_beam_sections(arms, 1.0 / section.EA, 1.0 / section.EI, 1.0 / section.GJ)
    shear = np.minimum(arms[:, None], arms) / section.kGA
    flexibility[0::6, 0::6] += shear
    flexibility[1::6, 1::6] += shear
    F = turn @ flexibility @ turn.T
    B = turn @ np.concatenate([rigid_motion_transfer_along_z(a) for a in arms])
    return MeshedShaftPart(0.5 * (F + F.T), B, stretch.base_position, stretch.ports, stretch.observers, stretch.ends, c * k)


def _motions_by_section_motions(rows: Array, stations: Array, stretch: MeshedShaftPart) -> tuple[Array, Array]:
    """Compute the matrix ``(x, 6 s)`` from the motions of s beam sections to all x motions of a 3D part of the shaft.

    The x motions are the rows of `MeshedShaftPart.F`: contact modes, ports (sections that can be loaded) and observers
    (sections whose motion is computed); each follows the cross-section at its axial position. The distances of the sections
    from the base ``(s,)`` [m] are returned as well. ``rows``: displacements of the k modes of each of c contacts by unit
    rigid motions of the shaft about the contact's axial position (c, k, 6); ``stations``: axial positions of the contacts
    (c,) [m]; ``stretch``: the 3D part. Raises ValueError if a section lies below the base.
    """
    c, k, _ = rows.shape
    arms = np.concatenate([stations, stretch.ports, stretch.observers]) - stretch.base_position
    if arms.min() < 0.0:
        raise ValueError(
            "the shaft's 3D part is fixed at its end of smallest z, and a contact, support or load lies "
            f"{-1e3 * arms.min():.4g} mm beyond this end; allowed: only at larger z than this end"
        )
    turn = np.zeros((c * k + 6 * (arms.size - c), 6 * arms.size))
    for i in range(c):
        turn[i * k : (i + 1) * k, 6 * i : 6 * i + 6] = rows[i]
    turn[c * k :, 6 * c :] = np.eye(6 * (arms.size - c))
    return turn, arms


def _flexibility_between_beam_sections(arms: Array, axial: float, bending: float, torsion: float) -> Array:
    """Compute the flexibility between s cross-sections of a cantilever without shear ``(6 s, 6 s)`` [m/N, 1/N, 1/(N m)].

    ``arms``: distances of the sections from the fixed end (s,) [m]; ``axial``, ``bending``, ``torsion``: flexibilities per
    unit length. The motion of section a by loads on section b comes from the part of the beam from its fixed end up
    to the nearer of the two sections.
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
