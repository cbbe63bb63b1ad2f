"""The grooved screw as a beam: cross-section with the groove smeared out, and the beam's nodes.

Source: Lin (2019), Appendix C, eqs. (C.3) to (C.8), and section 2.4.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, ceil, cos, floor, hypot, pi, sin, sqrt

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, lead_angle, nominal_contact_points
from rollbench.meshes.parts import Material, Scene


@dataclass(frozen=True)
class GrooveSection:
    """Gothic-arch groove below the screw's outer surface (Lin 2019, Figure C.1)."""

    #: Section angle of the apex, where both arcs meet [rad].
    gamma_1: float
    #: Section angle at which the arc leaves the outer surface [rad].
    gamma_2: float
    #: Area that the groove takes from the section [m2].
    area: float


def groove_section(scene: Scene) -> GrooveSection:
    """Angles and area of the screw's groove, from its nominal radius and the outer diameter.

    Valid while the outer surface cuts both arcs: abs(D_2) < r_G.

    Parameters
    ----------
    scene : Scene
        Gives groove radius, ball radius, contact angle, pitch radius and outer diameter.

    Returns
    -------
    GrooveSection
        Range of the section angle [rad] and cut area [m2].

    Raises
    ------
    ValueError
        The outer surface does not cut the groove.

    References
    ----------
    Lin (2019), eqs. (C.4) and (C.5).

    Examples
    --------
    >>> import rollbench
    >>> groove = groove_section(rollbench.read("lin-case1"))
    >>> [round(x / pi, 3) for x in (groove.gamma_1, groove.gamma_2)]  # printed: [0.033, 0.417] pi
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
        raise ValueError("the screw's outer surface does not cut the groove")
    g1, g2 = asin(d1 / r), pi / 2.0 - asin(d2 / r)  # (C.5)
    # (C.4): twice the sector of one arc less two triangles
    area = 2.0 * (0.5 * r * r * (g2 - g1) - 0.5 * (r * sin(g2) - d1) * d2 - 0.5 * (r * cos(g1) - d2) * d1)
    return GrooveSection(g1, g2, area)


def nut_groove_range(scene: Scene) -> tuple[float, float]:
    """Range of the section angle on a nut's flank, from the apex to pi/2.

    No source gives the diameter of the nut's lands, so the upper end is not where the flank ends.

    Parameters
    ----------
    scene : Scene
        Gives groove radius, ball radius and contact angle.

    Returns
    -------
    apex : float
        Section angle of the apex [rad].
    end : float
        pi/2.
    """
    slack = scene.nut.groove_radius - scene.balls.radius
    return asin(slack * sin(scene.track.contact_angle) / scene.nut.groove_radius), pi / 2.0


def volume_ratio(scene: Scene) -> float:
    """Volume of the grooved screw over that of the full cylinder.

    Parameters
    ----------
    scene : Scene
        As for `groove_section`, with lead and starts.

    Returns
    -------
    float
        Ratio per lead, in (0, 1]; 1 for zero lead (a bearing ring).

    Raises
    ------
    ValueError
        As `groove_section`.

    References
    ----------
    Lin (2019), eqs. (C.6) and (C.7).

    Examples
    --------
    >>> import rollbench
    >>> round(volume_ratio(rollbench.read("lin-case1")), 4)
    0.9368
    """
    track = scene.track
    if track.lead == 0.0:
        return 1.0
    cut = groove_section(scene).area * track.starts * hypot(2.0 * pi * track.pitch_radius, track.lead)  # (C.6)
    full = pi * (scene.screw.outer_diameter / 2.0) ** 2 * track.lead  # (C.7)
    return 1.0 - cut / full  # k_r^2 of (C.8)


@dataclass(frozen=True)
class BeamSection:
    """Stiffnesses of a beam's cross-section."""

    #: Axial stiffness [N].
    EA: float
    #: Bending stiffness [N m2].
    EI: float
    #: Torsional stiffness [N m2].
    GJ: float
    #: Shear stiffness kappa G A [N].
    kGA: float


def shear_coefficient(ratio: float, poisson: float) -> float:
    """Shear coefficient kappa of a circular tube.

    Parameters
    ----------
    ratio : float
        Inner over outer radius, from 0 (solid) to 1.
    poisson : float
        Poisson's ratio.

    Returns
    -------
    float
        kappa, between 0.5 (thin tube) and about 0.9 (solid).

    References
    ----------
    Cowper (1966), J. Appl. Mech. 33, 335; solid section: Lin (2019), eq. (C.3).

    Examples
    --------
    >>> round(shear_coefficient(0.0, 0.28), 4), round(shear_coefficient(1.0, 0.3), 4)
    (0.8848, 0.5306)
    """
    m2 = ratio**2
    denominator = (7.0 + 6.0 * poisson) * (1.0 + m2) ** 2 + (20.0 + 12.0 * poisson) * m2
    return 6.0 * (1.0 + poisson) * (1.0 + m2) ** 2 / denominator


def tube_section(outer: float, bore: float, material: Material) -> BeamSection:
    """Stiffnesses of a solid or hollow circular section.

    Parameters
    ----------
    outer, bore : float
        Diameters [m]; bore 0: solid.
    material : Material
        Its moduli E and G.

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
    area = pi / 4.0 * (outer**2 - bore**2)
    inertia = pi / 64.0 * (outer**4 - bore**4)
    kappa = shear_coefficient(bore / outer, material.poissons_ratio)
    e, g = material.youngs_modulus, material.shear_modulus
    return BeamSection(e * area, e * inertia, 2.0 * g * inertia, kappa * g * area)


def screw_section(scene: Scene) -> BeamSection:
    """Beam section of the grooved screw: full section with its diameter scaled for the groove.

    The scene's ``ingredients.section`` chooses the factor on the outer diameter: ``"groove"`` sqrt(k) with k the
    `volume_ratio` (keeps the volume), ``"groove squared"`` k (eq. (C.8) read without the root), ``"full"`` 1.

    Parameters
    ----------
    scene : Scene
        Gives screw, track and ``ingredients.section``.

    Returns
    -------
    BeamSection
        Stiffnesses, the same all along the screw.

    Raises
    ------
    ValueError
        The groove takes more volume than the screw has, or as `groove_section`.

    References
    ----------
    Lin (2019), eq. (C.8).

    Examples
    --------
    >>> import rollbench
    >>> round(screw_section(rollbench.read("lin-case1")).EA / 1e6, 2)  # MN
    158.22
    """
    ratio = volume_ratio(scene)
    if ratio <= 0.0:
        raise ValueError("the groove takes more volume than the screw has")
    factor = {"groove": sqrt(ratio), "groove squared": ratio, "full": 1.0}[scene.ingredients.section]  # k_r of (C.8)
    return tube_section(scene.screw.outer_diameter * factor, scene.screw.bore, scene.screw.material)


#: Stations closer than this share a node, and are joined to it rigidly. [m]
MERGE = 1.0e-5

#: Element length of the source inside the nut (Lin 2.4.1). [m]
SOURCE_ELEMENT = 15.0e-3


def contact_stations(scene: Scene, layout: BallLayout) -> Array:
    """Stations at which the forces of the screw's flanks enter the beam.

    Those of the nominal contact points; with ``ingredients.arm = "ball"`` those of the ball centres.

    Parameters
    ----------
    scene : Scene
        Its contact angle, radii and ``ingredients.arm``.
    layout : BallLayout
        Places of its n balls.

    Returns
    -------
    (n, 2) Array
        Stations [m] of SL and SR.
    """
    if scene.ingredients.arm == "ball":
        return np.repeat(layout.z[:, None], 2, axis=1)
    rise = nominal_contact_points(scene)[:2, 1] * cos(lead_angle(scene.track))
    return layout.z[:, None] + rise[None, :]


def needed_stations(scene: Scene) -> Array:
    """Stations [m] of a scene's supports, then of its loads, at which the beam must have nodes or end.

    Parameters
    ----------
    scene : Scene
        Gives supports and loads.

    Returns
    -------
    (n,) Array
        Stations [m].
    """
    return np.array([s.at for s in scene.supports] + [f.at for f in scene.loads])


def merge_stations(stations: Array, exact: Array) -> Array:
    """Sort stations and drop those within `MERGE` of the one before.

    Parameters
    ----------
    stations : (n,) Array
        Stations [m], in any order.
    exact : Array
        Stations [m] that stay as they are where they are close to others.

    Returns
    -------
    (m,) Array
        Ascending stations [m].
    """
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


def _steps_between(start: float, end: float, length: float) -> Array:
    count = max(1, ceil((end - start) / length - 1e-9))
    return np.linspace(start, end, count + 1)


def fixed_partition(scene: Scene, *others: Scene) -> Array:
    """Beam nodes of the ``"source"`` or ``"uniform"`` partition over the whole screw.

    ``"source"``: as many 15 mm elements as fit the nut, centred on it, and equal elements of at most the pitch diameter
    outside. For the screw of Table 2.1 that makes 12 + 3 + 12 = 27 elements, the number of Table 2.2. ``"uniform"``:
    elements of ``ingredients.element_length`` in the nut.

    Parameters
    ----------
    scene : Scene
        Gives the screw.
    *others : Scene
        Further rolling sets on the same screw.

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
            parts.append(_steps_between(at, inside[0], longest)[:-1])
        parts.append(inside)
        at = float(inside[-1])
    if scene.screw.length - at > MERGE:
        parts.append(_steps_between(at, scene.screw.length, longest)[1:])
    return np.unique(np.concatenate(parts))


def _nodes_in_nut(scene: Scene) -> Array:
    """Nodes in the nut [m]."""
    nut = scene.nut
    low, high = nut.position - nut.length / 2.0, nut.position + nut.length / 2.0
    if scene.ingredients.partition == "source":
        count = max(1, floor(nut.length / SOURCE_ELEMENT + 1e-9))
        half = min(count * SOURCE_ELEMENT, nut.length) / 2.0
        return np.linspace(nut.position - half, nut.position + half, count + 1)
    return _steps_between(low, high, scene.ingredients.element_length)


def beam_nodes(scene: Scene, stations: Array, *, everything: bool = False) -> tuple[Array, int]:
    """Nodes of the beam between the outermost supports, loads and contacts.

    A support is a node; a load or contact within `MERGE` of a node is carried to it by a rigid arm.

    Parameters
    ----------
    scene : Scene
        Its ``ingredients.partition`` chooses the nodes.
    stations : Array of any shape
        Stations of the contacts [m].
    everything : bool, default False
        Keep the elements beyond the outermost support, load or contact, which carry nothing.

    Returns
    -------
    nodes : (n,) Array
        Ascending nodes [m].
    left_out : int
        Number of elements of the partition that are left out.
    """
    needed = np.concatenate([needed_stations(scene), stations.ravel()])
    held = np.array([s.at for s in scene.supports])
    if scene.ingredients.partition == "nodal":
        ends = np.array([0.0, scene.screw.length])
        nodes = merge_stations(np.concatenate([needed, ends]), held)
    else:
        nodes = merge_stations(np.concatenate([fixed_partition(scene), needed_stations(scene)]), held)
    return (nodes, 0) if everything else enclosing_nodes(nodes, needed)


def enclosing_nodes(nodes: Array, needed: Array) -> tuple[Array, int]:
    """Return the nodes that enclose some stations, at least two.

    Parameters
    ----------
    nodes : (n,) Array
        Ascending nodes [m].
    needed : Array
        Stations [m] that the kept nodes enclose.

    Returns
    -------
    nodes : (m,) Array
        Kept nodes [m].
    left_out : int
        Number of elements that are dropped.

    Examples
    --------
    >>> enclosing_nodes(np.array([0.0, 1.0, 2.0, 3.0]), np.array([1.2, 1.9]))
    (array([1., 2.]), 2)
    """
    first = int(np.searchsorted(nodes, needed.min() + MERGE, side="right")) - 1
    last = int(np.searchsorted(nodes, needed.max() - MERGE, side="left"))
    first, last = max(first, 0), min(last, nodes.size - 1)
    if last == first:
        last, first = min(first + 1, nodes.size - 1), max(0, min(first, nodes.size - 2))
    return nodes[first : last + 1], nodes.size - 1 - (last - first)
