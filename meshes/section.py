"""The grooved screw as a beam: stiffnesses of a cross-section whose diameter is reduced for the groove, and beam nodes.

After Lin (2019), Appendix C, eqs. (C.3) to (C.8), and section 2.4.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, ceil, cos, floor, hypot, pi, sin, sqrt

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, lead_angle, nominal_contact_points
from rollbench.meshes.parts import Material, Scene


@dataclass(frozen=True)
class ScrewGrooveSection:
    """Section angles and area of the screw's gothic-arch groove below the screw's outer surface (Lin 2019, Figure C.1)."""

    #: Section angle of the apex, where both arcs meet [rad].
    apex_angle: float
    #: Section angle at which the arc meets the screw's outer surface [rad].
    edge_angle: float
    #: Area of the groove's cross-section below the outer surface [m2].
    area: float


def screw_groove_section(scene: Scene) -> ScrewGrooveSection:
    """Compute the section angles at which the screw's groove begins and ends, and the area of its cross-section.

    A section angle is measured around the centre of a groove arc, from the radial direction. The result is valid
    while the screw's outer surface intersects both arcs: abs(D_2) < r_G, with the radial distance D_2 from that surface to
    the centres of the arcs, and the groove radius r_G.

    Parameters
    ----------
    scene : Scene
        Scene with groove radius, ball radius, contact angle, pitch radius and outer diameter.

    Returns
    -------
    ScrewGrooveSection
        Range of the section angle [rad] and area of the groove [m2].

    Raises
    ------
    ValueError
        The screw's outer surface does not intersect the groove.

    References
    ----------
    Lin (2019), eqs. (C.4) and (C.5).

    Examples
    --------
    >>> import rollbench
    >>> groove = screw_groove_section(rollbench.read("lin-case1"))
    >>> [round(x / pi, 3) for x in (groove.apex_angle, groove.edge_angle)]  # Lin: [0.033, 0.417] pi
    [0.033, 0.417]
    >>> round(1e6 * groove.area, 4)  # mm2
    9.6251
    """
    r = scene.screw.groove_radius
    slack = r - scene.balls.radius
    beta = scene.track.contact_angle
    d1 = slack * sin(beta)
    d2 = slack * cos(beta) + scene.track.pitch_radius - scene.screw.outer_diameter / 2.0
    if abs(d2) >= r:
        raise ValueError("the screw's outer surface does not cut the groove: change its outer diameter or groove radius")
    g1, g2 = asin(d1 / r), pi / 2.0 - asin(d2 / r)  # (C.5)
    # (C.4): twice the sector of one arc less two triangles
    area = 2.0 * (0.5 * r * r * (g2 - g1) - 0.5 * (r * sin(g2) - d1) * d2 - 0.5 * (r * cos(g1) - d2) * d1)
    return ScrewGrooveSection(g1, g2, area)


def section_angle_range_of_nut_groove(scene: Scene) -> tuple[float, float]:
    """Return the section angles between which a flank of the nut's groove extends: from the apex to pi/2.

    A section angle is measured around the centre of a groove arc, from the radial direction. The flank ends at the nut's
    lands; because no publication gives their diameter, pi/2 is taken for this angle.

    Parameters
    ----------
    scene : Scene
        Scene with the nut's groove radius, the ball radius and the contact angle.

    Returns
    -------
    apex : float
        Section angle of the apex [rad].
    end : float
        pi/2.
    """
    slack = scene.nut.groove_radius - scene.balls.radius
    return asin(slack * sin(scene.track.contact_angle) / scene.nut.groove_radius), pi / 2.0


def grooved_volume_ratio(scene: Scene) -> float:
    """Return the ratio of the grooved screw's volume to that of a full cylinder with its outer diameter.

    Parameters
    ----------
    scene : Scene
        Scene with a ball screw or bearing: dimensions of the screw and its groove, lead and number of starts.

    Returns
    -------
    float
        Ratio over one lead, at most 1; 1 for zero lead (a bearing ring).

    Raises
    ------
    ValueError
        The screw's outer surface does not intersect the groove.

    References
    ----------
    Lin (2019), eqs. (C.6) and (C.7).

    Examples
    --------
    >>> import rollbench
    >>> round(grooved_volume_ratio(rollbench.read("lin-case1")), 4)
    0.9368
    """
    track = scene.track
    if track.lead == 0.0:
        return 1.0
    cut = screw_groove_section(scene).area * track.starts * hypot(2.0 * pi * track.pitch_radius, track.lead)  # (C.6)
    full = pi * (scene.screw.outer_diameter / 2.0) ** 2 * track.lead  # (C.7)
    return 1.0 - cut / full  # k_r^2 of (C.8)


@dataclass(frozen=True)
class BeamSection:
    """Stiffnesses of a beam's cross-section: axial EA, bending EI, torsional GJ and shear kappa G A."""

    #: Axial stiffness [N].
    EA: float
    #: Bending stiffness [N m2].
    EI: float
    #: Torsional stiffness [N m2].
    GJ: float
    #: Shear stiffness kappa G A [N].
    kGA: float


def shear_coefficient(diameter_ratio: float, poisson: float) -> float:
    """Return the shear coefficient kappa of a circular tube or solid shaft (Timoshenko beam).

    Parameters
    ----------
    diameter_ratio : float
        Ratio of inner to outer radius, from 0 (solid) to 1.
    poisson : float
        Poisson's ratio.

    Returns
    -------
    float
        Shear coefficient, between 0.5 (thin tube) and about 0.9 (solid).

    References
    ----------
    Cowper (1966), J. Appl. Mech. 33, 335; solid section: Lin (2019), eq. (C.3).

    Examples
    --------
    >>> round(shear_coefficient(0.0, 0.28), 4), round(shear_coefficient(1.0, 0.3), 4)
    (0.8848, 0.5306)
    """
    m2 = diameter_ratio**2
    denominator = (7.0 + 6.0 * poisson) * (1.0 + m2) ** 2 + (20.0 + 12.0 * poisson) * m2
    return 6.0 * (1.0 + poisson) * (1.0 + m2) ** 2 / denominator


def tube_section(outer_diameter: float, bore_diameter: float, material: Material) -> BeamSection:
    """Return the beam stiffnesses of a solid or hollow circular cross-section.

    Parameters
    ----------
    outer_diameter, bore_diameter : float
        Outer and inner diameter [m]; ``bore_diameter`` 0 for a solid section.
    material : Material
        Material with the moduli E and G.

    Returns
    -------
    BeamSection
        EA, EI, GJ and kappa G A, with J = 2 I.

    References
    ----------
    Shear: `shear_coefficient`.

    Examples
    --------
    >>> shaft = tube_section(32e-3, 0.0, Material(210e9, 0.28))
    >>> round(shaft.EA / 1e6, 2), round(shaft.EI)  # MN, N m2
    (168.89, 10809)
    """
    area = pi / 4.0 * (outer_diameter**2 - bore_diameter**2)
    inertia = pi / 64.0 * (outer_diameter**4 - bore_diameter**4)
    kappa = shear_coefficient(bore_diameter / outer_diameter, material.poissons_ratio)
    e, g = material.youngs_modulus, material.shear_modulus
    return BeamSection(e * area, e * inertia, 2.0 * g * inertia, kappa * g * area)


def screw_section(scene: Scene) -> BeamSection:
    """Return the beam stiffnesses of the grooved screw: of a circular section with a diameter reduced for the groove.

    The outer diameter is multiplied by a factor, which the scene's ``ingredients.section`` selects. With the ratio k of the
    screw's volume to that of a full cylinder (`grooved_volume_ratio`) it is for
    ``"groove"`` sqrt(k), which preserves the volume; for ``"groove squared"`` k, that is, eq. (C.8) without its square
    root; for ``"full"`` 1.

    Parameters
    ----------
    scene : Scene
        Scene with screw, track and ``ingredients.section``.

    Returns
    -------
    BeamSection
        Stiffnesses, uniform along the screw.

    Raises
    ------
    ValueError
        The groove's volume exceeds that of the screw, or the screw's outer surface does not intersect the groove.

    References
    ----------
    Lin (2019), eq. (C.8).

    Examples
    --------
    >>> import rollbench
    >>> round(screw_section(rollbench.read("lin-case1")).EA / 1e6, 2)  # MN
    158.22
    """
    ratio = grooved_volume_ratio(scene)
    if ratio <= 0.0:
        raise ValueError("the groove's volume exceeds the volume of the screw: raise the lead or reduce the groove radius")
    factor = {"groove": sqrt(ratio), "groove squared": ratio, "full": 1.0}[scene.ingredients.section]  # k_r of (C.8)
    return tube_section(scene.screw.outer_diameter * factor, scene.screw.bore, scene.screw.material)


#: Axial positions closer together than this [m] share a node of the beam and are connected to it rigidly.
MERGE = 1.0e-5

#: Length of the beam elements inside the nut in Lin's thesis (section 2.4.1) [m].
SOURCE_ELEMENT = 15.0e-3


def contact_force_positions(scene: Scene, layout: BallLayout) -> Array:
    """Return the axial positions at which the contact forces on the screw's two flanks act on the beam.

    These are the positions of the nominal contact points; with ``ingredients.arm = "ball"``, of the ball centres.

    Parameters
    ----------
    scene : Scene
        Scene with contact angle, radii and ``ingredients.arm``.
    layout : BallLayout
        Positions of its n balls.

    Returns
    -------
    (n, 2) Array
        Axial positions [m] on the screw's left and right flank (SL, SR), for each ball.
    """
    if scene.ingredients.arm == "ball":
        return np.repeat(layout.z[:, None], 2, axis=1)
    rise = nominal_contact_points(scene)[:2, 1] * cos(lead_angle(scene.track))
    return layout.z[:, None] + rise[None, :]


def merge_close_positions(positions: Array, preferred_positions: Array) -> Array:
    """Sort axial positions; of positions closer together than `MERGE` only one remains.

    Parameters
    ----------
    positions : (n,) Array
        Axial positions [m], in any order.
    preferred_positions : Array
        Axial positions [m] that remain where other positions are closer to them than `MERGE`.

    Returns
    -------
    (m,) Array
        Ascending axial positions [m].
    """
    ordered = np.sort(positions)
    if np.all(ordered[1:] - ordered[:-1] > MERGE):
        return ordered
    named = frozenset(preferred_positions.tolist())
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


def _nodes_of_equal_elements(start: float, end: float, length: float) -> Array:
    """Divide an interval of the shaft into the fewest equal elements of at most ``length`` [m], and return their nodes [m].

    ``start``, ``end``: axial positions of the interval's ends [m]; both are nodes.
    """
    count = max(1, ceil((end - start) / length - 1e-9))
    return np.linspace(start, end, count + 1)


def nodes_of_whole_beam(scene: Scene, *others: Scene) -> Array:
    """Return the nodes of a beam over the whole screw, divided as in Lin's thesis or into equal elements in the nut.

    ``ingredients.partition`` of the scene selects one of the two. ``"source"`` is the partition of Lin's thesis: inside the
    nut as many elements of 15 mm as fit, centred in the nut; outside, equal elements of at most the pitch diameter. For the
    screw of Table 2.1 these are 12 + 3 + 12 = 27 elements, the number in Table 2.2. ``"uniform"``: inside the nut, elements
    of at most ``ingredients.element_length``; outside as for ``"source"``.

    Parameters
    ----------
    scene : Scene
        Scene with the screw and its nut.
    *others : Scene
        Scenes of further nuts or bearings on the same screw.

    Returns
    -------
    (n,) Array
        Ascending nodes [m], from 0 to the length of the screw.

    References
    ----------
    Lin (2019), section 2.4.1, Tables 2.1 and 2.2.
    """
    parts, at, longest = [], 0.0, 2.0 * min(x.track.pitch_radius for x in (scene, *others))
    for inside in sorted((_nodes_in_nut(x) for x in (scene, *others)), key=lambda x: float(x[0])):
        if inside[0] - at > MERGE:
            parts.append(_nodes_of_equal_elements(at, inside[0], longest)[:-1])
        parts.append(inside)
        at = float(inside[-1])
    if scene.screw.length - at > MERGE:
        parts.append(_nodes_of_equal_elements(at, scene.screw.length, longest)[1:])
    return np.unique(np.concatenate(parts))


def _nodes_in_nut(scene: Scene) -> Array:
    """Return the axial positions of the beam's nodes inside the nut [m]."""
    nut = scene.nut
    low, high = nut.position - nut.length / 2.0, nut.position + nut.length / 2.0
    if scene.ingredients.partition == "source":
        count = max(1, floor(nut.length / SOURCE_ELEMENT + 1e-9))
        half = min(count * SOURCE_ELEMENT, nut.length) / 2.0
        return np.linspace(nut.position - half, nut.position + half, count + 1)
    return _nodes_of_equal_elements(low, high, scene.ingredients.element_length)


def beam_nodes(scene: Scene, contact_positions: Array, *, whole_screw: bool = False) -> tuple[Array, int]:
    """Return the nodes of the beam between the outermost supports, loads and contacts.

    Each support has a node. A load or contact closer than `MERGE` to a node is connected to it rigidly.

    Parameters
    ----------
    scene : Scene
        Scene whose ``ingredients.partition`` selects the nodes.
    contact_positions : Array of any shape
        Axial positions of the contacts [m].
    whole_screw : bool, default False
        Whether to include the nodes beyond the outermost support, load or contact, where the screw carries no load.

    Returns
    -------
    nodes : (n,) Array
        Ascending axial positions of the nodes [m].
    left_out : int
        Number of elements of the whole screw that are not included.
    """
    needed = np.concatenate([scene.stations, contact_positions.ravel()])
    held = np.array([s.at for s in scene.supports])
    if scene.ingredients.partition == "nodal":
        ends = np.array([0.0, scene.screw.length])
        nodes = merge_close_positions(np.concatenate([needed, ends, [scene.nut.position]]), held)
    else:
        nodes = merge_close_positions(np.concatenate([nodes_of_whole_beam(scene), scene.stations]), held)
    return (nodes, 0) if whole_screw else nodes_enclosing_positions(nodes, needed)


def nodes_enclosing_positions(nodes: Array, enclosed_positions: Array) -> tuple[Array, int]:
    """Return the part of a beam's nodes that encloses given axial positions; at least two nodes.

    Parameters
    ----------
    nodes : (n,) Array
        Ascending axial positions of the nodes [m].
    enclosed_positions : Array
        Axial positions [m] that the selected nodes enclose.

    Returns
    -------
    nodes : (m,) Array
        Axial positions of the selected nodes [m].
    left_out : int
        Number of elements outside the selected nodes.

    Examples
    --------
    >>> nodes_enclosing_positions(np.array([0.0, 1.0, 2.0, 3.0]), np.array([1.2, 1.9]))
    (array([1., 2.]), 2)
    """
    first = int(np.searchsorted(nodes, enclosed_positions.min() + MERGE, side="right")) - 1
    last = int(np.searchsorted(nodes, enclosed_positions.max() - MERGE, side="left"))
    first, last = max(first, 0), min(last, nodes.size - 1)
    if last == first:
        last, first = min(first + 1, nodes.size - 1), max(0, min(first, nodes.size - 2))
    return nodes[first : last + 1], nodes.size - 1 - (last - first)
