"""Axial rigidity of a ball nut (axial load over axial displacement), in the three stages that ISO 3408-4 distinguishes.

Contacts only (R_b/t): equal balls lie between rigid bodies at the nominal contact angle. With s = sin(alpha) cos(phi), N
balls, and the constant C of both Hertz contacts of a ball together,

    F = N s (((c_1 + s u)/C)^(3/2) - ((c_2 - s u)/C)^(3/2)),   terms with a negative approach c +- s u are zero.       (1)

c_1 and c_2 are the approaches of both pairs of flanks at zero load (preload by oversized balls or errors). A nut with a
lead offset has its own c_1, c_2 in each half, and the sum is over both halves. Without preload u = C (F/(N s))^(2/3)/s.

With bodies (R_nu): the radial part F/tan(alpha) of the contact loads widens the nut and compresses the screw. Both are
taken as thick tubes under uniform pressure over the loaded length i P_h of each start (Lame), as in ISO 3408-4:

    u = F/(2 pi i P_h tan^2(alpha)) (((D_1^2 + D_c^2)/(D_1^2 - D_c^2) + nu_n)/E_n
                                      + ((d_c^2 + d_b^2)/(d_c^2 - d_b^2) - nu_s)/E_s).
                                                                                                                       (2)

i counts only turns that are filled with balls (`lowfi.rating.life.filled_turns`), so that gaps between circuits do not
change (2). In reality the wall next to the loaded turns carries a part of the load over a length of about sqrt(R t)/1.3
(R its mean radius, t its thickness). This is neglected, as in ISO 3408-4, and makes (2) too soft, mostly for short
circuits far apart.

With unequal loads (R_nu,ar): the displacement comes from a model that solves for the contact loads; it is that of the
screw's section at the nut's centre. ISO 3408-4 uses a factor of the tolerance class instead. This rigidity may exceed the
other two, because its contact angles are those under load and not the nominal ones. Valid for small displacements and balls
on whole turns.
"""

from __future__ import annotations

from math import cos, pi, sin, tan

import numpy as np

from rollbench.lowfi.hertz import contact_approach, contact_force
from rollbench.lowfi.rating.life import filled_turns
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.problem import place_balls
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import are_in_shifted_half, draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Ratio of the axial force to the sum of the contact loads below which the force is a round-off error.
ROUND_OFF = 1e-9
#: Part of a computed rigidity that THK advises to use, and that most makers print approximately; Rexroth prints half of it.
PRACTICE = 0.8


@result_record
class AxialRigidities:
    """Axial rigidities of a nut or bearing [N/m]: contacts only, contacts and bodies, and with unequal contact loads."""

    #: Axial rigidity by the deformation of the contacts alone, equally loaded [N/m].
    contacts_only: float = quantity_field(
        "rigidities_N_per_um.contacts_alone",
        "secant rigidity with rigid bodies and equal contact loads at the nominal contact angle, by Hertz's law",
        error="neglects bodies and unequal loads",
    )
    #: Axial rigidity by contacts, nut and screw, with equal contact loads [N/m]; None for bearings, to which the formula
    #: does not apply.
    with_bodies: float | None = quantity_field(
        "rigidities_N_per_um.with_bodies",
        "secant rigidity with nut and screw as thick tubes, which the contact loads widen and compress",
        error="neglects unequal loads",
    )
    #: Axial rigidity by a model that computes the unequal contact loads [N/m]; None if the model's axial displacement is
    #: not known.
    with_unequal_loads: float | None = quantity_field(
        "rigidities_N_per_um.with_unequal_loads",
        "secant rigidity by the model, `axial.rigidity_N_per_um`",
        error="that of the displacement",
    )

    @property
    @QuantityDescription(
        "rigidities_N_per_um.makers_practice",
        "rigidity that makers advise to use (THK): 0.8 times `with_bodies`; null for bearings",
        error="the factor 0.8 is a rule of practice",
        heading="0.8 times rigidity by formula",
        note="as makers advise",
    )
    def makers_practice(self) -> float | None:
        """Rigidity that manufacturers advise to use [N/m], 0.8 times ``with_bodies``; None for bearings."""
        return None if self.with_bodies is None else PRACTICE * self.with_bodies


def approach_per_displacement(scene: Scene) -> float:
    """Return the sum of the approaches at a ball's two contacts per unit of axial displacement of the nut.

    It is sin(alpha) cos(phi), with the contact angle alpha and the lead angle phi.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    return sin(scene.track.contact_angle) * cos(lead_angle(scene.track))


def displacement_by_contacts_only(scene: Scene, force: float) -> float:
    """Return the axial displacement of a nut or bearing by deformation of the contacts only [m].

    Equal balls lie between rigid bodies at the nominal contact angle; see eq. (1) of this module.

    Parameters
    ----------
    scene
        The screw or bearing.
    force
        Axial load [N], above zero.

    Returns
    -------
    float
        Displacement [m]: for nut halves that a lead offset preloads against each other, counted from their equilibrium
        without load; otherwise from the first contact.
    """
    layout = ball_layout(scene)
    of_balls = place_balls(scene, draw_geometry_with_errors(scene, layout)).interference
    beyond = are_in_shifted_half(scene, layout.z)
    halves = [beyond, ~beyond] if scene.errors.lead_offset else [np.ones_like(beyond)]
    closure = np.array([of_balls[half].mean(axis=0) for half in halves])
    counts = np.array([half.sum() for half in halves])
    C = hertz_without_errors(scene).C
    pair = np.array([C[0] + C[3], C[1] + C[2]])
    s, n = approach_per_displacement(scene), scene.ball_count

    def axial_force_above_given(u: float, start: Array, force: float) -> float:
        """Return the axial force of all balls at an axial displacement u [m] of the nut or ring, less ``force`` [N].

        ``start``: interference of the balls with each pair of opposite flanks at u = 0 [m], for each half of the nut.
        """
        pressed = contact_force(start + s * u * np.array([1.0, -1.0]), pair)
        return float(s * counts @ (pressed[:, 0] - pressed[:, 1])) - force

    reach = 2.0 * float(np.abs(closure).max()) / s
    held = float(brentq(lambda u: axial_force_above_given(u, closure, 0.0), -reach, reach, xtol=1e-15))
    begun = closure + s * max(held, -float(closure[:, 0].max()) / s) * np.array([1.0, -1.0])
    free = reach * (len(halves) - 1) + float(contact_approach(force / (n * s), pair[0])) / s
    # displacement counted from that state: that of a small load would be lost to round-off against its position
    return float(brentq(lambda u: axial_force_above_given(u, begun, force), 0.0, 2.0 * free, xtol=1e-18 * free, rtol=1e-12))


def axial_compliance_of_bodies(scene: Scene) -> float | None:
    """Return the axial compliance of nut and screw as thick tubes under radial pressure [m/N], by eq. (2) of this module.

    Parameters
    ----------
    scene
        Screw or bearing.

    Returns
    -------
    float | None
        Axial displacement per axial load; None for bearings, which have no lead.

    Raises
    ------
    ValueError
        Nut or screw has no wall behind its contacts.

    References
    ----------
    ISO 3408-4; Lame's thick tube.
    """
    track = scene.track
    if track.lead == 0.0:
        return None
    reach = scene.balls.radius * cos(track.contact_angle)
    inner, outer = 2.0 * (track.pitch_radius - reach), 2.0 * (track.pitch_radius + reach)
    if scene.nut.outer_diameter <= outer or scene.screw.bore >= inner:
        raise ValueError(
            "axial compliance: got a nut or screw without a wall behind its contacts; allowed: a nut with an "
            f"outer diameter above {1e3 * outer:.4g} mm and a screw with a bore below {1e3 * inner:.4g} mm"
        )
    length = filled_turns(scene) / track.starts * track.lead
    nut, screw = scene.nut.material, scene.screw.material
    widen = (scene.nut.outer_diameter**2 + outer**2) / (scene.nut.outer_diameter**2 - outer**2) + nut.poissons_ratio
    squeeze = (inner**2 + scene.screw.bore**2) / (inner**2 - scene.screw.bore**2) - screw.poissons_ratio
    radial = widen / nut.youngs_modulus + squeeze / screw.youngs_modulus
    return radial / (2.0 * pi * length * tan(track.contact_angle) ** 2)


def axial_force(result: StaticResult) -> float:
    """Return the axial force of the screw on the nut [N]; zero if it does not exceed the contact loads' round-off error.

    Parameters
    ----------
    result
        Static result of a screw or bearing.
    """
    balance = result.equilibrium
    force = 0.0 if balance is None else -float(balance.contact_force[2])
    return force if abs(force) > ROUND_OFF * float(result.load.sum()) else 0.0


def three_axial_rigidities(scene: Scene, force: float, displacement: float | None) -> AxialRigidities | None:
    """Return three axial rigidities of a nut or bearing: contacts only, with bodies, and with unequal contact loads.

    Parameters
    ----------
    scene
        The screw or bearing.
    force
        Axial load [N], with its sign.
    displacement
        Axial displacement [m] by a model that solves for unequal loads, with the same sign; None if it is not known.

    Returns
    -------
    AxialRigidities | None
        The rigidities; None without axial load, or for a contact angle of zero.

    Raises
    ------
    ValueError
        Nut or screw has no wall behind its contacts.

    References
    ----------
    ISO 3408-4.

    Examples
    --------
    >>> import rollbench
    >>> found = three_axial_rigidities(rollbench.read("lin-case1"), 5e3, 20e-6)
    >>> [round(x * 1e-6) for x in (found.contacts_only, found.with_bodies, found.with_unequal_loads)]  # N/um
    [271, 265, 250]
    """
    size = abs(force)
    if size == 0.0 or approach_per_displacement(scene) <= 0.0:
        return None
    alone = displacement_by_contacts_only(scene, size)
    body = axial_compliance_of_bodies(scene)
    unequal = force / displacement if displacement is not None and displacement * force > 0.0 else None
    return AxialRigidities(size / alone, None if body is None else 1.0 / (alone / size + body), unequal)
