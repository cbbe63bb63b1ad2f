"""Warnings for solutions of the static models that are outside the models' range of validity."""

from __future__ import annotations

from typing import Literal

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.statics.contact_law import SIGNS, radius_with_derivatives
from rollbench.lowfi.statics.contacts import hertz_of_every_contact
from rollbench.lowfi.statics.problem import ContactState, Problem
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import pairs_of_close_points
from rollbench.meshes.one_arc import has_single_arc_grooves
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import screw_groove_section, section_angle_range_of_nut_groove
from rollbench.meshes.washers import has_washers, section_angle_limits

Element = Literal["ball", "roller"]

#: Limits of the theory of small rotations: tilt of the screw [rad], which is the error of force directions; and neglected
#: second-order motion of a groove, relative to the largest contact approach.
SMALL_TILT, SECOND_ORDER = 3e-3, 0.01
#: Largest rotation of a shaft section [rad] for which the linear beam is valid: half its square is 0.1 %.
SMALL_ROTATION = 0.045
#: Largest contact pressure [Pa] by ISO 76 for hardened steel in ball and in roller bearings. Higher pressures leave a
#: permanent indentation of more than about 1e-4 of the rolling element's diameter.
DENT_PRESSURE, ROLLER_DENT_PRESSURE = 4.2e9, 4.0e9
#: Largest ratio of a contact's semi-axis to the ball radius for which Hertz's half space is valid. At this ratio the sphere
#: differs from its paraboloid by a quarter of the ratio's square, 2 %.
LARGE = 0.3
#: Largest shift of a profile's centre of curvature by profile errors, relative to the distance of groove and ball centre.
PROFILE_SHARE = 0.5
#: Overlap of neighbouring balls [m] above which a warning is given that they are wedged.
OVERLAP = 1e-9


def validity_warnings(contacts: ContactState, gamma: Array, z: Array, motion: Array) -> tuple[ResultWarning, ...]:
    """Return all warnings that a static solution lies outside the model's range of validity.

    Parameters
    ----------
    contacts
        Contacts of N balls in the solution.
    gamma
        Contact angles ``(N, 4)`` [rad].
    z
        Axial positions of the shaft's centreline ``(k,)`` [m].
    motion
        Motions of the shaft at these positions ``(k, 6)`` [m, rad].
    """
    problem, force = contacts.problem, contacts.force
    constants = hertz_of_every_contact(problem.scene, problem.drawn)
    semi_axis = constants.C_a * np.cbrt(force)  # the long one, across the groove
    half = semi_axis / problem.drawn.groove_radii
    loaded = (force.sum(axis=1, keepdims=True) > 0.0) * 1.0
    shift = contacts.ball_centres * loaded
    return (
        *_arc_limit_warnings(problem, force, gamma, half, shift),
        *_overlapping_contact_warning(force, gamma, half),
        *contact_warnings(constants.pressure(force), semi_axis, problem.scene.balls.radius),
        *_ball_overlap_warning(problem, shift),
        *profile_warning(contacts),
        *tilt_warning(problem, force, z, motion),
        *rotation_warning(z, motion),
    )


def contact_angle_limits(scene: Scene) -> tuple[Array, Array]:
    """Return the smallest and the largest contact angle that each flank's arc allows, ``(4,)`` each [rad].

    The arc of a Gothic groove reaches from the apex at the groove's bottom to the edge of the land, the cylindrical surface
    beside the groove. A groove of a single arc reaches from one land to the other, with shoulders of equal height; that of
    a washer from one side of its face to the other.
    """
    if has_washers(scene):
        return section_angle_limits(scene)
    screw, nut = screw_groove_section(scene), section_angle_range_of_nut_groove(scene)
    if has_single_arc_grooves(scene):
        return np.repeat([-screw.edge_angle, -nut[1]], 2), np.repeat([screw.edge_angle, nut[1]], 2)
    low, high = (screw.apex_angle, nut[0]), (screw.edge_angle, nut[1])
    return np.repeat(low, 2), np.repeat(high, 2)


def arc_end_names(scene: Scene) -> str:
    """Return the names of the ends of a groove's arc for messages: "land edge", or "apex or land edge".

    The land is the cylindrical surface beside the groove, the apex the line where the two arcs of a Gothic groove meet.
    """
    return "land edge" if has_single_arc_grooves(scene) else "apex or land edge"


def _arc_limit_warnings(problem: Problem, force: Array, gamma: Array, half: Array, shift: Array) -> list[ResultWarning]:
    """Return warnings of contacts or contact ellipses beyond the groove's arc, and of balls with large displacements.

    A displacement is large if it exceeds a tenth of the ball's radius.

    Parameters
    ----------
    problem
        Static problem of N balls.
    force
        Contact forces ``(N, 4)`` [N].
    gamma
        Contact angles ``(N, 4)`` [rad].
    half
        Half widths of the contact ellipses as angles on the groove's arc ``(N, 4)`` [rad].
    shift
        Displacements of the loaded balls' centres in their section planes ``(N, 2)`` [m].
    """
    notes: list[ResultWarning] = []
    loaded = force > 0.0
    low, high = contact_angle_limits(problem.scene)
    radius, ends = problem.scene.balls.radius, arc_end_names(problem.scene)
    off = loaded & ((gamma < low) | (gamma > high))
    if off.any():
        text = f"{int(off.sum())} contact(s) lie beyond the groove's arc ({ends}), where the model is not valid"
        notes.append(ResultWarning("off arc", text, f"{int(off.sum())} contact(s) beyond the groove's arc"))
    cut = loaded & ~off & ((gamma - half < low) | (gamma + half > high))
    if cut.any():
        worst = int(np.argmax(np.where(cut, np.maximum(low - gamma + half, gamma + half - high), -np.inf)))
        text = (
            f"the contact ellipse of {int(cut.sum())} contact(s) reaches beyond the groove's arc ({ends}), farthest on "
            f"ball {worst // 4 + 1}: pressure and approach are higher there than by Hertz"
        )
        notes.append(ResultWarning("edge", text))
    if float(np.abs(shift).max(initial=0.0)) > 0.1 * radius:
        brief = "a ball moves by more than a tenth of its radius"
        notes.append(ResultWarning("motion", f"{brief}: the theory of small displacements is not valid", brief))
    return notes


def _overlapping_contact_warning(force: Array, gamma: Array, half: Array) -> list[ResultWarning]:
    """Return a warning if a ball's contacts with both flanks of a groove are so close that they merge into one.

    This is the case if their distance is less than a semi-axis of the contact ellipse. The groove is a single arc there,
    and the model counts one contact twice. Since contact angles count from the groove's bottom to either side, the angle
    between both contacts is the sum of their contact angles.

    Parameters
    ----------
    force
        Contact forces ``(N, 4)`` [N].
    gamma
        Contact angles ``(N, 4)`` [rad].
    half
        Half widths of the contact ellipses as angles on the groove's arc ``(N, 4)`` [rad].
    """
    pairs = force.reshape(-1, 2, 2)
    double = (pairs > 0.0).all(axis=2) & (np.abs(gamma.reshape(-1, 2, 2).sum(axis=2)) < half.reshape(-1, 2, 2).max(axis=2))
    if not double.any():
        return []
    total = np.where(double, pairs.sum(axis=2), 0.0)
    share = np.where(double, total / np.maximum(pairs.max(axis=2), 1e-300), 0.0)
    worst = float(np.cbrt(share.max()))
    ball, body = np.unravel_index(int(total.argmax()), total.shape)
    left, right = pairs[ball, body]
    place = f"ball {int(ball) + 1} of the {('screw', 'nut')[body]}"
    brief = f"{int(double.any(axis=1).sum())} ball(s) with two forces that are one contact counted twice"
    text = (
        f"{int(double.any(axis=1).sum())} ball(s) touch both flanks of a groove within one contact ellipse, where the "
        f"flanks are a single arc: the two forces are those of one contact counted twice ({place}: {left:.4g} N and "
        f"{right:.4g} N in place of one force of up to {left + right:.4g} N); its pressure is higher by up to "
        f"{100.0 * (worst - 1.0):.2g} %, its approach by up to {100.0 * (worst**2 - 1.0):.2g} %"
    )
    return [ResultWarning("two flanks", text, brief)]


def contact_size_warnings(semi_axis: Array, radius: float, element: Element = "ball") -> list[ResultWarning]:
    """Return a warning if a contact is too large, relative to its ball or roller, for Hertz's theory of half spaces.

    Parameters
    ----------
    semi_axis
        Semi-axes of contact ellipses, or half-widths of line contacts [m], any shape.
    radius
        Radius of the ball or roller [m].
    element
        Rolling element that the warning is about: "ball" or "roller".
    """
    most = float(semi_axis.max(initial=0.0)) / radius
    if most <= LARGE:
        return []
    shape, half = ("contact ellipse", "semi-axis") if element == "ball" else ("line contact", "half-width")
    words = f"a {half} is {most:.2g} of the {element}'s radius; Hertz's half space is valid up to {LARGE:g}"
    return [ResultWarning("size", f"{shape} too large: {words}", f"{shape} of {most:.2g} of the {element}'s radius")]


def contact_warnings(pressure: Array, semi_axis: Array, radius: float, element: Element = "ball") -> list[ResultWarning]:
    """Return warnings of contacts too large for Hertz's theory, or with a pressure that leaves a permanent indentation.

    Parameters
    ----------
    pressure
        Largest pressure [Pa] of the contacts of each ball ``(N, 4)``, or of each roller with both raceways ``(N, 2)``.
    semi_axis
        Long semi-axis of contact ellipses, or half-width of line contacts [m], of the same contacts.
    radius
        Radius of the ball or roller [m].
    element
        Rolling element that the warning is about: "ball" or "roller".
    """
    allow = DENT_PRESSURE if element == "ball" else ROLLER_DENT_PRESSURE
    notes, beyond = contact_size_warnings(semi_axis, radius, element), pressure > allow
    if beyond.any():
        worst = int(pressure.argmax()) // pressure.shape[1] + 1
        allowed, most = f"{1e-9 * allow:g} GPa", f"{1e-9 * float(pressure.max()):.3g} GPa"
        text = (
            f"contact pressure too high: {int(beyond.sum())} contact(s) above {allowed}, up to {most} on {element} "
            f"{worst}; above this pressure hardened steel is permanently indented by more than 1e-4 of the {element}'s "
            "diameter (ISO 76), while the computed loads assume elastic contacts"
        )
        notes.append(ResultWarning("pressure", text, f"contact pressure {most}, above {allowed}"))
    return notes


def _ball_overlap_warning(problem: Problem, shift: Array) -> list[ResultWarning]:
    """Return a warning if neighbouring balls overlap in the solution, since the model has no contact between balls.

    Parameters
    ----------
    problem
        Static problem of N balls.
    shift
        Displacements of the balls' centres in their section planes ``(N, 2)`` [m].
    """
    layout, radius = problem.layout, problem.drawn.ball_radii
    centre = layout.centre + shift[:, :1] * layout.radial + shift[:, 1:] * layout.binormal
    if not np.isfinite(centre).all():
        return []
    pairs = pairs_of_close_points(centre, 2.0 * float(radius.max()) + OVERLAP)
    if not pairs.size:
        return []
    a, b = pairs.T
    overlap = radius[a] + radius[b] - np.linalg.norm(centre[a] - centre[b], axis=1)
    worst = int(overlap.argmax())
    if overlap[worst] <= OVERLAP:
        return []
    i, j = sorted((int(a[worst]) + 1, int(b[worst]) + 1))
    brief = f"balls {i} and {j} overlap by {1e6 * overlap[worst]:.3g} um"
    text = (
        f"{brief} ({int((overlap > OVERLAP).sum())} pair(s) in all): "
        "in reality they are wedged against one another; the model neglects contact between balls"
    )
    return [ResultWarning("wedged", text, brief)]


def profile_warning(contacts: ContactState) -> list[ResultWarning]:
    """Return a warning if profile errors of a groove allow several contact points of one ball and flank, or none.

    Profile errors shift the centre of curvature of the profile off the groove's centre, by the derivative of the groove's
    radius with respect to the contact angle [m]. If this shift is not small against the distance between groove centre and
    ball centre, there may be several contact points. ``contacts``: contacts in the solution.
    """
    profile = contacts.problem.drawn.profile_coefficients
    if not profile.shape[1]:
        return []
    slope = np.abs(
        radius_with_derivatives(contact_angles(contacts.normal), contacts.problem.drawn.groove_radii, profile)[1]
    )
    w = SIGNS * (contacts.ball_centres[:, None, :] - contacts.flank_motions - contacts.problem.drawn.groove_centres)
    share = np.where(contacts.force > 0.0, slope / np.maximum(np.hypot(w[..., 0], w[..., 1]), 1e-12), 0.0)
    ball, side = np.unravel_index(int(share.argmax()), share.shape)
    if share[ball, side] <= PROFILE_SHARE:
        return []
    why = (
        "the groove's profile error shifts the flank's centre of curvature by "
        f"{100.0 * share[ball, side]:.3g} % of its distance from the ball's centre, so that the ball may touch that "
        "flank at several points; the model finds one of them"
    )
    brief = "the contact pattern is not unique"
    return [ResultWarning("profile", f"{brief}: at ball {ball + 1} {why}", f"{brief} at ball {ball + 1}")]


def tilt_warning(problem: Problem, force: Array, z: Array, motion: Array) -> list[ResultWarning]:
    """Return a warning if the screw tilts so much at the balls that neglected second-order terms matter for the contacts.

    In addition to its linear motion, a tilt t moves a groove by R t^2/2, with the pitch radius R. Rotations about the
    screw's axis have no such error.

    Parameters
    ----------
    problem
        Static problem of N balls.
    force
        Contact forces ``(N, 4)`` [N].
    z
        Axial positions of the shaft's centreline ``(k,)`` [m].
    motion
        Motions of the shaft at these positions ``(k, 6)`` [m, rad].
    """
    approach = float(contact_approach(force, problem.C).max(initial=0.0))
    low, high = float(problem.layout.z.min()), float(problem.layout.z.max())
    stations = np.array([low, high])
    tilt = max(float(np.hypot(*(np.interp(s, z, motion[:, k]) for k in (3, 4)))) for s in stations)
    inside = (z >= low) & (z <= high)
    tilt = max(tilt, float(np.hypot(motion[inside, 3], motion[inside, 4]).max(initial=0.0)))
    return large_tilt_warning(tilt, problem.scene.track.pitch_radius, approach)


def large_tilt_warning(tilt: float, radius: float, approach: float, element: Element = "ball") -> list[ResultWarning]:
    """Return a warning if the shaft's tilt is too large for the theory of small rotations, see `tilt_warning`.

    Parameters
    ----------
    tilt
        Tilt of the shaft at the balls or rollers [rad].
    radius
        Pitch radius [m].
    approach
        Largest contact approach [m].
    element
        Rolling element that the warning is about: "ball" or "roller".
    """
    beyond = 0.5 * radius * tilt**2
    if approach == 0.0 or (tilt <= SMALL_TILT and beyond <= SECOND_ORDER * approach):
        return []
    share = f"{100.0 * beyond / approach:.2g} % of" if beyond < approach else "more than"
    brief = f"the screw tilts by {1e3 * tilt:.2g} mrad at the {element}s"
    text = (
        f"{brief}: the theory of small rotations neglects "
        f"{1e6 * beyond:.2g} um of a {'groove' if element == 'ball' else 'raceway'}'s motion, {share} the largest contact "
        "approach"
    )
    return [ResultWarning("tilt", text, brief)]


def rotation_warning(z: Array, motion: Array) -> list[ResultWarning]:
    """Return a warning if a section of the shaft rotates too much for a linear beam.

    Parameters
    ----------
    z
        Axial positions of the shaft's centreline ``(k,)`` [m].
    motion
        Motions of the shaft at these positions ``(k, 6)`` [m, rad].
    """
    size = np.abs(motion[:, 3:]).max(axis=1)
    if not size.size or not float(size.max()) > SMALL_ROTATION:
        return []
    at = int(size.argmax())
    most, small = f"{1e3 * size[at]:.3g} mrad", f"{1e3 * SMALL_ROTATION:g} mrad"
    text = f"a section of the screw rotates by {most} (at {1e3 * z[at]:.4g} mm): the linear beam is valid up to {small}"
    return [ResultWarning("rotation", text, f"rotations of {most}, above {small}")]
