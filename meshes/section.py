"""The grooved screw as a beam of the low-order models: its cross-section (Lin C.3-C.8), and where its nodes lie."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, ceil, cos, floor, hypot, pi, sin, sqrt

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, lead_angle, nominal_contact_points
from rollbench.meshes.parts import Material, Scene


@dataclass(frozen=True)
class GrooveSection:
    """Gothic-arch groove below the screw's surface (Lin Figure C.1).

    gamma_1, gamma_2: angles of the apex and of the land's edge [rad]; area: cut area of the section [m2].
    """

    gamma_1: float
    gamma_2: float
    area: float


def groove_section(scene: Scene) -> GrooveSection:
    """Groove range and area of the screw (Lin C.4, C.5), from the nominal groove radius and outer diameter.

    Valid while the screw's surface cuts both arcs: |D_2| < r_G.
    """
    r = scene.screw.groove_radius
    slack = r - scene.balls.radius
    beta = scene.track.contact_angle
    d1 = slack * sin(beta)
    d2 = slack * cos(beta) + scene.track.pitch_radius - scene.screw.outer_diameter / 2.0
    if abs(d2) >= r:
        raise ValueError("the screw's outer surface does not cut the groove")
    g1, g2 = asin(d1 / r), pi / 2.0 - asin(d2 / r)
    area = 2.0 * (0.5 * r * r * (g2 - g1) - 0.5 * (r * sin(g2) - d1) * d2 - 0.5 * (r * cos(g1) - d2) * d1)
    return GrooveSection(g1, g2, area)


def nut_groove_range(scene: Scene) -> tuple[float, float]:
    """Smallest contact angle of the nut's arcs, at the apex, and pi/2 [rad]; the nut's land is not dimensioned."""
    slack = scene.nut.groove_radius - scene.balls.radius
    return asin(slack * sin(scene.track.contact_angle) / scene.nut.groove_radius), pi / 2.0


def volume_ratio(scene: Scene) -> float:
    """Volume of the grooved screw over that of the full cylinder, per lead (Lin C.6, C.7); 1 for zero lead."""
    track = scene.track
    if track.lead == 0.0:
        return 1.0
    cut = groove_section(scene).area * track.starts * hypot(2.0 * pi * track.pitch_radius, track.lead)
    full = pi * (scene.screw.outer_diameter / 2.0) ** 2 * track.lead
    return 1.0 - cut / full


@dataclass(frozen=True)
class BeamSection:
    """Stiffnesses of a section: axial EA [N], bending EI [N m2], torsion GJ [N m2], shear kappa G A [N]."""

    EA: float
    EI: float
    GJ: float
    kGA: float


def shear_coefficient(ratio: float, poisson: float) -> float:
    """Shear coefficient of a circular tube of inner over outer radius ``ratio`` (Cowper 1966; 0: solid, Lin C.3)."""
    m2 = ratio**2
    denominator = (7.0 + 6.0 * poisson) * (1.0 + m2) ** 2 + (20.0 + 12.0 * poisson) * m2
    return 6.0 * (1.0 + poisson) * (1.0 + m2) ** 2 / denominator


def tube_section(outer: float, bore: float, material: Material) -> BeamSection:
    """Circular (hollow) section: diameters [m]; shear coefficient of Cowper 1966 (solid: Lin C.3)."""
    area = pi / 4.0 * (outer**2 - bore**2)
    inertia = pi / 64.0 * (outer**4 - bore**4)
    kappa = shear_coefficient(bore / outer, material.poissons_ratio)
    e, g = material.youngs_modulus, material.shear_modulus
    return BeamSection(e * area, e * inertia, 2.0 * g * inertia, kappa * g * area)


def screw_section(scene: Scene) -> BeamSection:
    """Section of the screw: outer diameter scaled by k_r (Lin C.8) as the scene's ``section`` says.

    ``"groove"`` keeps the volume (k_r = sqrt of the ratio), ``"groove squared"`` reads C.8 without the root,
    ``"full"`` ignores the groove.
    """
    ratio = volume_ratio(scene)
    if ratio <= 0.0:
        raise ValueError("the groove takes more volume than the screw has")
    factor = {"groove": sqrt(ratio), "groove squared": ratio, "full": 1.0}[scene.ingredients.section]
    return tube_section(scene.screw.outer_diameter * factor, scene.screw.bore, scene.screw.material)


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
