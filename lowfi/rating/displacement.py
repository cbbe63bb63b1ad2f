"""Displacements from which stiffness is stated, of two kinds: of a nut or bearing, and of the point on which a load acts.

Of the nut or bearing: axial displacement of the inner part's section, relative to the outer part, less the advance of the
thread for the rotation between both,

    u = u_z,i - u_z,o - r_g (r_z,i - r_z,o),   r_g = lead/(2 pi), negative for a left-hand thread, 0 for a bearing.    (1)

The section is that at the nut's centre, and of a bearing that of its loaded contacts: an angular contact bearing loads its
shaft beside its centre, and the shaft between both is not the bearing's. A screw that turns by r_z and advances by r_g r_z
loads no ball. So u does not contain the wind-up of a shaft that is held against rotation elsewhere, nor the shaft and the
supports; it is what the balls, the nut and the shaft within it yield.

Of the load's point, to ground: displacement of the section or housing on which the load acts, along the load. It contains
the shaft between load and nut, its wind-up, all bearings, supports and housings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult, StaticSolution
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.helix import lead_per_radian
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import MERGE


@dataclass(frozen=True)
class LoadPoint:
    """Point on which the load of a scene acts, direction in which its displacement is stated, and the load along it."""

    #: Axial position on the shaft [m], or name of the housing.
    at: float | str
    #: Unit vector: z if the scene has an axial force, else along its largest force.
    direction: tuple[float, float, float]
    #: Sum of all forces on shaft and housings along this direction [N].
    force: float


def load_point(scene: Scene | Assembly) -> LoadPoint | None:
    """Return the point on which the load of a scene acts; None without a force.

    With several forces it is the point of the one with the largest component along the direction.

    Examples
    --------
    >>> import rollbench
    >>> load_point(rollbench.read("lin-case1")).force
    5000.0
    """
    pairs: list[tuple[float | str, tuple[float, float, float]]] = [(x.at, x.force) for x in scene.loads]
    pairs += [(h.name, h.force) for h in scene.housings] if isinstance(scene, Assembly) else []
    forces = np.array([force for _, force in pairs]).reshape(-1, 3)
    if not forces.any():
        return None
    direction = np.array([0.0, 0.0, 1.0])
    if not forces[:, 2].any():
        largest = forces[int(np.linalg.norm(forces, axis=1).argmax())]
        direction = largest / np.linalg.norm(largest)
    along = forces @ direction
    x, y, z = map(float, direction)
    return LoadPoint(pairs[int(np.abs(along).argmax())][0], (x, y, z), float(along.sum()))


def motion_at(result: StaticSolution, at: float | str) -> Array:
    """Return the motion (6,) [m, rad] of the shaft at an axial position [m], or of the housing of this name.

    The motion is zero for a housing that cannot move, and nan if the model gives no motion there.
    """
    if isinstance(at, str):
        assert isinstance(result, AxisResult), "only an assembly has housings"
        return next((h.motion for h in result.housings if h.name == at), np.zeros(6))
    z = result.centreline_z
    if not z.size or (z.size == 1 and abs(at - z[0]) > MERGE):  # a model may give the motion of one section only
        return np.full(6, np.nan)
    return np.array([np.interp(at, result.centreline_z, u) for u in result.centreline.T])


def displacement_of_load_point(result: StaticSolution, point: LoadPoint) -> float:
    """Return the displacement of a load's point along its direction [m], from the nominal position, to ground."""
    return float(np.dot(motion_at(result, point.at)[:3], point.direction))


def displacements_of_sets(scene: Scene | Assembly, result: StaticSolution) -> Array:
    """Return the axial displacement [m] between inner and outer part of each of n nuts or bearings ``(n,)``.

    It follows from eq. (1) of the module, and is counted from the nominal position.

    Examples
    --------
    >>> import rollbench
    >>> scene, result = rollbench.read("lin-case1"), rollbench.solve("lin-case1", "lin").solution
    >>> (1e6 * displacements_of_sets(scene, result)).round(2)
    array([18.51])
    """
    parts = [s.of.parts for s in result.sets] if isinstance(result, AxisResult) else [scene]
    advance = [lead_per_radian(x.track) if isinstance(x, Scene) else 0.0 for x in parts]
    moved = motions_in_sets(scene, result)
    return np.asarray(moved[:, 2] - advance * moved[:, 5])


def motions_in_sets(scene: Scene | Assembly, result: StaticSolution) -> Array:
    """Return the motion of the inner relative to the outer part of n nuts or bearings ``(n, 6)`` [m, rad], from nominal."""
    if isinstance(scene, Assembly):
        assert isinstance(result, AxisResult), "an assembly has the result of an axis"
        return np.array([_motion_in_set(scene, result, s) for s in result.sets])
    assert isinstance(result, StaticResult), "a scene with one nut or bearing has the result of one"
    return motion_at(result, section_of_nut(scene, result))[None]


def section_of_nut(scene: Scene, result: StaticResult) -> float:
    """Return the axial position of the section whose motion is the displacement of a nut or bearing [m]."""
    return _section(scene, result, scene.nut.position)


def _section(parts: Scene | RollerRow, balls: StaticResult, position: float) -> float:
    """Return the axial position of the section of a nut or bearing at ``position`` whose motion is its displacement [m]."""
    load = balls.load[:, :2]
    if (isinstance(parts, Scene) and parts.track.lead) or not load.any():
        return position
    return float((load * balls.contact_point[:, :2, 2]).sum() / load.sum())


def _motion_in_set(assembly: Assembly, result: AxisResult, of_set: SetResult) -> Array:
    """Return the motion (6,) [m, rad] of the inner relative to the outer part of one nut or bearing, from nominal."""
    of = of_set.of
    if of.carrier is None:
        at = of.position if of_set.balls is None else _section(of.parts, of_set.balls, of.position)
        inner = motion_at(result, at)
    else:  # the inner part sits on a housing
        reach = of.position - next(h.at for h in assembly.housings if h.name == of.carrier)
        inner = rigid_motion_transfer_matrix(reach) @ motion_at(result, of.carrier)
    return np.asarray(inner - of_set.outer)
