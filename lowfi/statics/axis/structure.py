"""Shaft, housings and springs of an assembly as a linear elastic structure, with supports and loads.

Each shaft node and each moving housing has six motions, which form one row of the arrays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.problem import fixed_motions
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix, thermal_nodal_loads
from rollbench.meshes import section as meshes_section
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing
from rollbench.meshes.parts import Scene

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Structure:
    """Shaft, moving housings and springs of an assembly without its rolling elements.

    The r bodies are the n nodes of the shaft, followed by the moving housings; each has six motions.
    """

    #: Axial positions of the shaft's nodes ``(n,)`` [m].
    nodes: Array
    #: Axial positions of the moving housings ``(r - n,)`` [m].
    housing_positions: Array
    #: Cross-section of each beam element of the shaft.
    sections: tuple[meshes_section.BeamSection, ...]
    #: Whether each degree of freedom of the r bodies (shaft nodes, then moving housings) is fixed ``(r, 6)``.
    fixed: NDArray[np.bool_]
    #: Prescribed values of the fixed degrees of freedom of shaft nodes and moving housings ``(r, 6)`` [m, rad].
    prescribed: Array
    #: Loads on the r bodies (shaft nodes, then moving housings) ``(r, 6)`` [N, N m], with the forces that represent thermal
    #: expansion.
    load: Array
    #: Numbers of the two bodies (shaft nodes, then moving housings) that each of k springs joins ``(k, 2)``; -1 for the
    #: fixed frame.
    spring_bodies: Ints
    #: Matrices ``(k, 2, 6, 6)`` from the motions of the two bodies that a spring joins to the motions of its two ends. The
    #: second matrix has a negative sign, so that the sum of both end motions is the spring's deformation.
    spring_end_matrices: Array
    #: Stiffness matrices of the springs ``(k, 6, 6)`` [N/m, N, N m].
    springs: Array
    #: Number of each housing, by its name, among the shaft nodes and moving housings; -1 for a fixed housing.
    housing_numbers: dict[str, int]

    @property
    def body_positions(self) -> Array:
        """Return the axial positions ``(r,)`` [m] of the shaft nodes, then those of the moving housings."""
        return np.concatenate([self.nodes, self.housing_positions])

    @property
    def section_stiffnesses(self) -> Array:
        """Return EA [N], EI [N m^2], GJ [N m^2], kappa G A [N] of each beam element ``(n - 1, 4)``."""
        return np.array([(s.EA, s.EI, s.GJ, s.kGA) for s in self.sections])

    def each_spring(self) -> Iterator[tuple[Ints, Array, Array]]:
        """Iterate over the springs: their entries of ``spring_bodies``, ``spring_end_matrices`` and ``springs``."""
        return zip(self.spring_bodies, self.spring_end_matrices, self.springs, strict=True)


def shaft_nodes(assembly: Assembly, stations: Array) -> Array:
    """Return the axial positions of the shaft's nodes [m].

    Nodes lie at supports, loads, changes of cross-section and the position at which the stiffness is reported. They also
    lie at contacts and centres of nuts, or at fixed distances, depending on the scene's ``partition``. The shaft beyond the
    outermost support, load or contact carries no load and is left out.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    stations
        Axial positions of the contacts [m].
    """
    needed = [*stations, *(s.at for s in assembly.supports), *(x.at for x in assembly.loads)]
    if isinstance(assembly.stiffness_at, float):
        needed.append(assembly.stiffness_at)
    low, high, held = min(needed), max(needed), np.array([s.at for s in assembly.supports])
    steps = [z for s in assembly.segments for z in (s.start, s.end) if low < z < high]
    on_shaft = [s.parts for s in assembly.sets if isinstance(s.parts, Scene) and s.carrier is None]
    if assembly.ingredients.partition != "nodal" and on_shaft:
        extra = [*needed[len(stations) :], *(s.position for s in assembly.sets if not isinstance(s.parts, Scene)), *steps]
        scenes = [replace(x, screw=replace(x.screw, length=assembly.screw.length)) for x in on_shaft]
        every = np.concatenate([meshes_section.nodes_of_whole_beam(*scenes), extra])
        merged = meshes_section.merge_close_positions(every, held)
        return meshes_section.nodes_enclosing_positions(merged, np.array(needed))[0]
    centres = [s.position for s in assembly.sets if isinstance(s.parts, Scene) and s.parts.track.lead and s.carrier is None]
    nodes = meshes_section.merge_close_positions(np.array([*needed, *steps, *centres]), held)
    if nodes.size == 1:  # a beam needs one element
        step = meshes_section.MERGE * 100.0
        nodes = np.sort(np.array([low, low - step if low > 0.5 * assembly.screw.length else low + step]))
    return nodes


def first_ball_nut(assembly: Assembly) -> Scene | None:
    """Return the first ball nut of an assembly, whose thread determines the shaft's cross-section; None: no ball nut."""
    return next((s.parts for s in assembly.sets if isinstance(s.parts, Scene) and s.parts.track.lead > 0.0), None)


def element_sections(
    assembly: Assembly, nodes: Array, section: meshes_section.BeamSection | None = None
) -> tuple[meshes_section.BeamSection, ...]:
    """Return the cross-section of each beam element of the shaft: that of a plain segment or of the thread.

    Parameters
    ----------
    assembly
        Shaft with plain segments, bearings and ball nuts.
    nodes
        Axial positions of the nodes [m].
    section
        Cross-section of the threaded shaft; None: computed from its dimensions.
    """
    screw, thread = assembly.screw, first_ball_nut(assembly)
    plain_screw = partial(meshes_section.tube_section, screw.outer_diameter, screw.bore, screw.material)
    base = section or (plain_screw() if thread is None else meshes_section.screw_section(thread))
    plain = [(s.start, s.end, meshes_section.tube_section(s.diameter, s.bore, screw.material)) for s in assembly.segments]
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    return tuple(next((x for low, high, x in plain if low <= z <= high), base) for z in middles)


def build_structure(assembly: Assembly, stations: Array, section: meshes_section.BeamSection | None = None) -> Structure:
    """Return shaft, moving housings and springs of an assembly as arrays.

    Parameters
    ----------
    assembly
        Shaft with bearings, ball nuts and housings.
    stations
        Axial positions at which contacts load the shaft [m].
    section
        Cross-section of the threaded shaft; None: computed from its dimensions.

    Raises
    ------
    ValueError
        If two supports fix the same degree of freedom of one node.
    """
    nodes = shaft_nodes(assembly, stations)
    moving = [h for h in assembly.housings if not h.is_fixed]
    r = nodes.size + len(moving)
    holds = ((int(np.abs(nodes - s.at).argmin()), s) for s in assembly.supports)
    fixed, prescribed = fixed_motions(r, chain(holds, enumerate(moving, nodes.size)))
    load = np.zeros((r, 6))
    for x in assembly.loads:
        j = int(np.abs(nodes - x.at).argmin())
        load[j] += rigid_motion_transfer_matrix(x.at - nodes[j]).T @ np.concatenate([x.force, x.moment])
    for i, body in enumerate(moving):
        load[nodes.size + i] += np.concatenate([body.force, body.moment])
    sections = element_sections(assembly, nodes, section)
    load[: nodes.size] += thermal_nodal_loads(np.array([s.EA for s in sections]), assembly.thermal_strain)
    row = {h.name: -1 for h in assembly.housings} | {h.name: nodes.size + i for i, h in enumerate(moving)}
    ends, reach, springs = _spring_arrays(assembly, moving, row)
    places = np.array([h.at for h in moving])
    return Structure(nodes, places, sections, fixed, prescribed, load, ends, reach, springs, row)


def _spring_arrays(assembly: Assembly, moving_housings: list[Housing], row: dict[str, int]) -> tuple[Ints, Array, Array]:
    """Return which bodies the springs of the housings join, the motions of the springs' ends, and the springs' stiffness.

    Springs join two housings, or a housing and the fixed frame.

    Parameters
    ----------
    assembly
        Assembly with housings and joints.
    moving_housings
        Housings that move.
    row
        Number of each housing among the bodies of the `Structure`.

    Returns
    -------
    tuple[Ints, Array, Array]
        Fields ``spring_bodies``, ``spring_end_matrices`` and ``springs`` of `Structure`.
    """
    at = {h.name: h.at for h in moving_housings}
    unit, none = np.eye(6), np.zeros((6, 6))
    springs: list[tuple[int, int, Array, Array, Array]] = [
        (row[h.name], -1, unit, none, np.array(h.stiffness)) for h in moving_housings if h.stiffness is not None
    ]
    for j in assembly.joints:
        names = j.first, j.second
        near = [rigid_motion_transfer_matrix(j.at - at[name]) if name in at else none for name in names]
        springs.append((row[names[0]], row[names[1]], near[0], -near[1], np.array(j.stiffness)))
    ends = np.array([x[:2] for x in springs], dtype=np.int64).reshape(-1, 2)
    reach = np.array([x[2:4] for x in springs]).reshape(-1, 2, 6, 6)
    return ends, reach, np.array([x[4] for x in springs]).reshape(-1, 6, 6)


def largest_spring_force_term(structure: Structure, q: Array, arm: float) -> float:
    """Return the largest spring force [N] that would result if all its terms (stiffness times motion) had the same sign.

    The round-off error of the spring forces is proportional to this force. If two housings joined by a stiff spring move
    far together, the spring force itself is a small difference of large terms.

    Parameters
    ----------
    structure
        Shaft, housings and springs.
    q
        Motions of all bodies ``(r, 6)`` [m, rad].
    arm
        Length [m] by which moments are divided where they are compared with forces.
    """
    worst, per = 0.0, np.repeat([1.0, arm], 3)
    for ends, matrices, K in structure.each_spring():
        reach = np.abs(matrices)
        moved = sum((reach[e] @ np.abs(q[row]) for e, row in enumerate(ends) if row >= 0), start=np.zeros(6))
        force = np.abs(K) @ moved
        worst = max([worst, *(float((reach[e].T @ force / per).max()) for e, row in enumerate(ends) if row >= 0)])
    return worst


def rigid_motions_of_shaft_and_housings(structure: Structure, arm: float) -> Array:
    """Return the rigid motions of the shaft and of each of m moving housings, as motions of the r shaft nodes and housings.

    Parameters
    ----------
    structure
        Shaft, housings and springs.
    arm
        Length [m] by which rotations are scaled: a unit of rotation is 1/arm rad.

    Returns
    -------
    Array
        ``(6 r, 6 (1 + m))``: six motions of the shaft, then of each housing.
    """
    scale = np.diag(np.repeat([1.0, 1.0 / arm], 3))
    n, m = structure.nodes.size, structure.housing_positions.size
    out = np.zeros((n + m, 6, 6 * (1 + m)))
    out[:n, :, :6] = rigid_motion_transfer_matrix(structure.nodes - structure.nodes[0]) @ scale
    for j in range(m):
        out[n + j, :, 6 + 6 * j : 12 + 6 * j] = scale
    return out.reshape(6 * (n + m), -1)


def restraints_on_rigid_motions(structure: Structure, motions: Array) -> Array:
    """Return the constraints by supports and springs on rigid motions of shaft and housings, as normalised rows.

    Each row is one constraint, each column one rigid motion. The product of the result with the amplitudes of the motions
    is zero if no support or spring resists their combination.

    Parameters
    ----------
    structure
        Shaft, housings and springs.
    motions
        Result of `rigid_motions_of_shaft_and_housings`.
    """
    arms = motions.reshape(-1, 6, motions.shape[1])
    rows = [arms[i, k] for i, k in np.argwhere(structure.fixed)]
    for ends, near, K in structure.each_spring():
        moved = sum((near[e] @ arms[i] for e, i in enumerate(ends) if i >= 0), start=np.zeros((6, motions.shape[1])))
        size = np.sqrt(np.where(np.diag(K) > 0.0, np.diag(K), 1.0))
        value, vector = np.linalg.eigh(K / size[:, None] / size[None, :])
        rows += [(v * size) @ moved for v, x in zip(vector.T, value, strict=True) if x > 1e-12 * value.max(initial=0.0)]
    stacked = np.array(rows).reshape(-1, motions.shape[1])
    norm = np.linalg.norm(stacked, axis=1, keepdims=True)
    return np.asarray(stacked / np.where(norm > 0.0, norm, 1.0))
