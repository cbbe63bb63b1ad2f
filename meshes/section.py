"""Cross-section of the grooved screw as the low-order models see it (Lin C.3-C.8)."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, cos, hypot, pi, sin, sqrt

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
