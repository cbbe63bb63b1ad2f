"""Where the nodes of the screw's beam lie."""

from __future__ import annotations

from math import ceil, cos, floor

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, lead_angle, nominal_contact_points
from rollbench.meshes.parts import Scene

#: Stations closer than this share a node; the rest of the way is rigid. [m]
MERGE = 1.0e-5
#: Element length of the source inside the nut (Lin 2.4.1). [m]
SOURCE_ELEMENT = 15.0e-3


def contact_stations(scene: Scene, layout: BallLayout) -> Array:
    """Station at which each screw flank's force enters the beam, shape ``(n, 2)`` [m], sides SL and SR.

    The nominal contact point's z; with ``arm = "ball"`` the ball's own.
    """
    if scene.ingredients.arm == "ball":
        return np.repeat(layout.z[:, None], 2, axis=1)
    rise = nominal_contact_points(scene)[:2, 1] * cos(lead_angle(scene.track))
    return layout.z[:, None] + rise[None, :]


def needed_stations(scene: Scene) -> Array:
    """Stations of supports and loads [m]."""
    return np.array([s.at for s in scene.supports] + [f.at for f in scene.loads])


def merge(stations: Array, exact: Array) -> Array:
    """Sorted stations without those closer than ``MERGE`` to the one before; of two so close an ``exact`` one stays."""
    ordered = np.sort(stations)
    if np.all(ordered[1:] - ordered[:-1] > MERGE):
        return ordered
    named = frozenset(exact.tolist())
    first, *others = ordered.tolist()
    keep, firm = [first], first in named
    for z in others:
        own = z in named
        if z - keep[-1] > MERGE:
            keep.append(z)
            firm = own
        elif own and not firm:
            keep[-1], firm = z, own
    return np.array(keep)


def _steps(start: float, end: float, length: float) -> Array:
    count = max(1, ceil((end - start) / length - 1e-9))
    return np.linspace(start, end, count + 1)


def fixed_partition(scene: Scene, *others: Scene) -> Array:
    """Nodes of the ``"source"`` or ``"uniform"`` partition over the whole screw [m], of one scene, or of several on one
    screw, which is that of the first.

    source: as many 15 mm elements as fit the nut, centred on it; outside equal elements of at most the pitch diameter.
    For Table 2.1's screw that makes 12 + 3 + 12 = 27 elements, the number of Table 2.2.
    """
    parts, at, longest = [], 0.0, 2.0 * min(x.track.pitch_radius for x in (scene, *others))
    for inside in sorted((_inside(x) for x in (scene, *others)), key=lambda x: float(x[0])):
        if inside[0] - at > MERGE:
            parts.append(_steps(at, inside[0], longest)[:-1])
        parts.append(inside)
        at = float(inside[-1])
    if scene.screw.length - at > MERGE:
        parts.append(_steps(at, scene.screw.length, longest)[1:])
    return np.unique(np.concatenate(parts))


def _inside(scene: Scene) -> Array:
    """Nodes in the nut [m]."""
    nut = scene.nut
    low, high = nut.position - nut.length / 2.0, nut.position + nut.length / 2.0
    if scene.ingredients.partition == "source":
        count = max(1, floor(nut.length / SOURCE_ELEMENT + 1e-9))
        half = min(count * SOURCE_ELEMENT, nut.length) / 2.0
        return np.linspace(nut.position - half, nut.position + half, count + 1)
    return _steps(low, high, scene.ingredients.element_length)


def beam_nodes(scene: Scene, stations: Array, *, everything: bool = False) -> tuple[Array, int]:
    """Nodes of the beam [m] for contact ``stations``, and how many elements of the partition were left out.

    Elements beyond the outermost support, load or contact carry nothing and are left out unless ``everything``. A support
    is a node itself; a load or contact within ``MERGE`` of a node is carried to it by a rigid arm.
    """
    needed = np.concatenate([needed_stations(scene), stations.ravel()])
    held = np.array([s.at for s in scene.supports])
    if scene.ingredients.partition == "nodal":
        ends = np.array([0.0, scene.screw.length])
        nodes = merge(np.concatenate([needed, ends]), held)
    else:
        nodes = merge(np.concatenate([fixed_partition(scene), needed_stations(scene)]), held)
    return (nodes, 0) if everything else between(nodes, needed)


def between(nodes: Array, needed: Array) -> tuple[Array, int]:
    """The nodes that the stations ``needed`` lie between, at least two, and how many elements are left out."""
    first = int(np.searchsorted(nodes, needed.min() + MERGE, side="right")) - 1
    last = int(np.searchsorted(nodes, needed.max() - MERGE, side="left"))
    first, last = max(first, 0), min(last, nodes.size - 1)
    if last == first:
        last, first = min(first + 1, nodes.size - 1), max(0, min(first, nodes.size - 2))
    return nodes[first : last + 1], nodes.size - 1 - (last - first)
