"""Warnings of solutions that leave the range in which the static models are valid."""

from __future__ import annotations

from typing import Literal

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.statics.contacts import own_hertz
from rollbench.lowfi.statics.problem import SIGNS, Problem, SolvedState
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import close_pairs
from rollbench.meshes.one_arc import is_one_arc
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.section import groove_section, nut_groove_range

Element = Literal["ball", "roller"]

#: Tilt [rad] from which on a result warns of small rotations (directions off by as much), or from which share of the
#: largest contact approach that they neglect.
SMALL_TILT, SECOND_ORDER = 3e-3, 0.01
#: Rotation of any section of the shaft [rad] beyond which a linear beam is left: half its square is a per mille.
SMALL_ROTATION = 0.045
#: Largest pressure [Pa] that ISO 76 rates contacts of hardened bearing steel at, of ball and of roller bearings: beyond it
#: they keep a dent of more than about 1e-4 of the element's diameter.
DENT_PRESSURE, ROLLER_DENT_PRESSURE = 4.2e9, 4.0e9
#: Semi-axis over ball radius up to which Hertz's half space holds: there the ball leaves its paraboloid by a quarter of the
#: square, 2 %.
LARGE = 0.3
#: Part of the distance between groove centre and ball centre by which an uneven profile may shift the centre of curvature.
PROFILE_SHARE = 0.5
#: Overlap of neighbouring balls [m] from which on they are called wedged.
OVERLAP = 1e-9


def warnings_of(solved: SolvedState, gamma: Array, z: Array, motion: Array) -> tuple[Warned, ...]:
    """Return all warnings of a solved state.

    Parameters
    ----------
    solved
        The solved state.
    gamma
        Contact angles ``(N, 4)`` [rad].
    z, motion
        Stations ``(k,)`` [m] and motions ``(k, 6)`` [m, rad] of the centreline.
    """
    problem, force = solved.problem, solved.force
    constants = own_hertz(problem.scene, problem.drawn)
    loaded = (force.sum(axis=1, keepdims=True) > 0.0) * 1.0
    shift = solved.centre * loaded
    return (
        *_places(problem, force, gamma, shift),
        *_counted_twice(problem, force, gamma),
        *contact_warnings(constants.pressure(force), constants.C_a * np.cbrt(force), problem.scene.balls.radius),
        *_wedged(problem, shift),
        *profile_warning(solved),
        *tilt_warning(problem, force, z, motion),
        *rotation_warning(z, motion),
    )


def groove_range(scene: Scene) -> tuple[Array, Array]:
    """Return the smallest and largest contact angle of each flank's arc, ``(4,)`` each [rad].

    From the apex between two arcs to the land; for one arc from one land to the other, with shoulders of equal height, as a
    scene gives one diameter for both.
    """
    screw, nut = groove_section(scene), nut_groove_range(scene)
    if is_one_arc(scene):
        return np.repeat([-screw.gamma_2, -nut[1]], 2), np.repeat([screw.gamma_2, nut[1]], 2)
    low, high = (screw.gamma_1, nut[0]), (screw.gamma_2, nut[1])
    return np.repeat(low, 2), np.repeat(high, 2)


def ends_of_arc(scene: Scene) -> str:
    """Return the names of what a groove's arc ends at."""
    return "land edge" if is_one_arc(scene) else "apex or land edge"


def _places(problem: Problem, force: Array, gamma: Array, shift: Array) -> list[Warned]:
    """Return warnings of contacts or ellipses beyond the arc, and of balls that move far."""
    notes: list[str] = []
    loaded = force > 0.0
    low, high = groove_range(problem.scene)
    radius = problem.scene.balls.radius
    off = loaded & ((gamma < low) | (gamma > high))
    if off.any():
        notes.append(
            f"{int(off.sum())} contact(s) lie beyond the groove's arc ({ends_of_arc(problem.scene)}), where the model does "
            "not hold"
        )
    semi_axis = own_hertz(problem.scene, problem.drawn).C_a * np.cbrt(force)  # the long axis lies across the groove
    half = semi_axis / problem.drawn.radius
    cut = loaded & ~off & ((gamma - half < low) | (gamma + half > high))
    if cut.any():
        worst = int(np.argmax(np.where(cut, np.maximum(low - gamma + half, gamma + half - high), -np.inf)))
        notes.append(
            f"the ellipse of {int(cut.sum())} contact(s) reaches beyond the groove's arc ({ends_of_arc(problem.scene)}), "
            f"most on ball {worst // 4 + 1}: pressure is higher there than Hertz's, and so is the approach"
        )
    if float(np.abs(shift).max(initial=0.0)) > 0.1 * radius:
        notes.append("a ball moves by more than a tenth of its radius: small-displacement theory no longer holds")
    return [Warned("place", note) for note in notes]


def _counted_twice(problem: Problem, force: Array, gamma: Array) -> list[Warned]:
    """Return a warning of balls whose contacts with both flanks of a groove lie within one ellipse.

    The angles ``(N, 4)`` [rad] are apart by their sum. The flanks' arcs are one circle there, and two springs represent one
    contact.
    """
    half = own_hertz(problem.scene, problem.drawn).C_a * np.cbrt(force) / problem.drawn.radius
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
    text = (
        f"{int(double.any(axis=1).sum())} ball(s) touch both flanks of a groove within one contact ellipse: there the arcs "
        f"are one groove, and the forces are those of one contact counted twice ({place}: {left:.4g} N and {right:.4g} N "
        f"for one of up to {left + right:.4g} N); its pressure is higher by up to "
        f"{100.0 * (worst - 1.0):.2g} %, its approach by up to {100.0 * (worst**2 - 1.0):.2g} %"
    )
    return [Warned("two flanks", text)]


def size_warnings(semi_axis: Array, radius: float, element: Element = "ball") -> list[Warned]:
    """Return a warning of contacts that are large against their ball or roller.

    Parameters
    ----------
    semi_axis
        Of the ellipses, or half-width of line contacts [m], any shape.
    radius
        Of the ball or roller [m].
    element
        Which of the two.
    """
    most = float(semi_axis.max(initial=0.0)) / radius
    if most <= LARGE:
        return []
    shape, half = ("contact ellipse", "semi-axis") if element == "ball" else ("line contact", "half-width")
    words = f"a {half} is {most:.2g} of the {element}'s radius; Hertz's half space does not hold beyond {LARGE:g}"
    return [Warned("size", f"{shape} too large: {words}", f"{shape} of {most:.2g} of the {element}'s radius")]


def contact_warnings(pressure: Array, semi_axis: Array, radius: float, element: Element = "ball") -> list[Warned]:
    """Return warnings of contacts that are too large for Hertz's half space or leave a permanent indentation.

    Parameters
    ----------
    pressure, semi_axis
        Largest pressure [Pa] and semi-axis [m] of the contacts of each ball ``(N, 4)``, or of each roller with its races
        ``(N, 2)``.
    radius
        Of the ball or roller [m].
    element
        Which of the two.
    """
    allow = DENT_PRESSURE if element == "ball" else ROLLER_DENT_PRESSURE
    notes, beyond = size_warnings(semi_axis, radius, element), pressure > allow
    if beyond.any():
        worst = int(pressure.argmax()) // pressure.shape[1] + 1
        allowed, most = f"{1e-9 * allow:g} GPa", f"{1e-9 * float(pressure.max()):.3g} GPa"
        text = (
            f"contact pressure too high: {int(beyond.sum())} contact(s) above {allowed}, up to {most} on {element} "
            f"{worst}; hardened steel keeps a dent of more than 1e-4 of the {element}'s diameter there (ISO 76), and the "
            "computed loads assume elastic bodies"
        )
        notes.append(Warned("pressure", text, f"contact pressure {most}, above {allowed}"))
    return notes


def _wedged(problem: Problem, shift: Array) -> list[Warned]:
    """Return a warning of neighbouring balls that overlap at the solution, by their shifts in their sections."""
    layout, radius = problem.layout, problem.drawn.ball_radius
    centre = layout.centre + shift[:, :1] * layout.radial + shift[:, 1:] * layout.binormal
    if not np.isfinite(centre).all():
        return []
    pairs = close_pairs(centre, 2.0 * float(radius.max()) + OVERLAP)
    if not pairs.size:
        return []
    a, b = pairs.T
    overlap = radius[a] + radius[b] - np.linalg.norm(centre[a] - centre[b], axis=1)
    worst = int(overlap.argmax())
    if overlap[worst] <= OVERLAP:
        return []
    i, j = sorted((int(a[worst]) + 1, int(b[worst]) + 1))
    text = (
        f"balls {i} and {j} overlap by {1e6 * overlap[worst]:.3g} um ({int((overlap > OVERLAP).sum())} pair(s) in all): "
        "they are wedged against one another, and contact between balls is left out"
    )
    return [Warned("wedged", text)]


def profile_warning(solved: SolvedState) -> list[Warned]:
    """Return a warning where an uneven profile lets a ball touch a flank at several positions, or at none that balances.

    The profile's centre of curvature lies off the groove's centre by its slope rho' [m]: where that is of the size of the
    distance of the ball's centre from there, there may be several contact positions. The profile is a polynomial of the
    angle from -180 to 180 deg: where it ends it jumps, and a ball that is pressed onto the jump balances on neither side of
    it.
    """
    profile = solved.problem.drawn.profile
    if not profile.shape[1] or solved.shifts is None:
        return []
    powers, angle = np.arange(profile.shape[1]), contact_angles(solved.normal)
    slope = np.abs(np.einsum("sk,nsk->ns", profile[:, 1:] * powers[1:], angle[..., None] ** powers[:-1]))
    jump = 2.0 * np.abs(profile[:, 1::2] @ np.pi ** powers[1::2])
    w = SIGNS * (solved.centre[:, None, :] - solved.shifts - solved.problem.drawn.centre)
    loaded, size = solved.force > 0.0, np.maximum(np.hypot(w[..., 0], w[..., 1]), 1e-12)
    share = np.where(loaded, slope / size, 0.0)
    at_end = loaded & (size * (np.pi - np.abs(np.arctan2(w[..., 1], w[..., 0]))) < jump)
    ball, side = np.unravel_index(int((share + at_end * share.max()).argmax()), share.shape)
    if at_end[ball, side]:
        why = (
            f"the centre has gone to the far side of groove {SIDES[side]}'s, where the profile error, a polynomial of the "
            f"angle, ends with a jump of {1e6 * jump[side]:.3g} um, so that it may balance on neither side of it"
        )
    elif share[ball, side] > PROFILE_SHARE:
        why = (
            "the groove's profile error shifts the flank's centre of curvature by "
            f"{100.0 * share[ball, side]:.3g} % of its distance from the ball's, so that it may touch that flank in more "
            "than one place; the model finds one of them"
        )
    else:
        return []
    return [Warned("profile", f"the contact pattern is not unique: at ball {ball + 1} {why}")]


def tilt_warning(problem: Problem, force: Array, z: Array, motion: Array) -> list[Warned]:
    """Return a warning where the screw tilts so far at the balls that neglected second-order terms show in the contacts.

    A tilt t moves a groove by R t^2/2 beyond its linear motion, R the pitch radius; rotations about the axis are exact on
    the helix. force ``(N, 4)`` [N]; z ``(k,)`` [m] and motion ``(k, 6)`` [m, rad] of the centreline.
    """
    approach = float(contact_approach(force, problem.C).max(initial=0.0))
    low, high = float(problem.layout.z.min()), float(problem.layout.z.max())
    stations = np.array([low, high])
    tilt = max(float(np.hypot(*(np.interp(s, z, motion[:, k]) for k in (3, 4)))) for s in stations)
    inside = (z >= low) & (z <= high)
    tilt = max(tilt, float(np.hypot(motion[inside, 3], motion[inside, 4]).max(initial=0.0)))
    return tilted(tilt, problem.scene.track.pitch_radius, approach)


def tilted(tilt: float, radius: float, approach: float, element: Element = "ball") -> list[Warned]:
    """Return the warning of `tilt_warning`.

    Parameters
    ----------
    tilt
        Of the shaft at the elements [rad].
    radius
        Pitch radius [m].
    approach
        Largest contact approach [m].
    element
        Ball or roller.
    """
    beyond = 0.5 * radius * tilt**2
    if approach == 0.0 or (tilt <= SMALL_TILT and beyond <= SECOND_ORDER * approach):
        return []
    share = f"{100.0 * beyond / approach:.2g} % of" if beyond < approach else "more than"
    text = (
        f"the screw tilts by {1e3 * tilt:.2g} mrad at the {element}s: small rotations neglect {1e6 * beyond:.2g} um "
        f"of a {'groove' if element == 'ball' else 'race'}'s motion, {share} the largest contact approach"
    )
    return [Warned("tilt", text)]


def rotation_warning(z: Array, motion: Array) -> list[Warned]:
    """Return a warning where a section of the shaft rotates beyond the range of a linear beam.

    z ``(k,)`` [m] and motion ``(k, 6)`` [m, rad] of the centreline.
    """
    size = np.abs(motion[:, 3:]).max(axis=1)
    if not size.size or not float(size.max()) > SMALL_ROTATION:
        return []
    at = int(size.argmax())
    most, small = f"{1e3 * size[at]:.3g} mrad", f"{1e3 * SMALL_ROTATION:g} mrad"
    text = f"a section of the screw turns by {most} (at {1e3 * z[at]:.4g} mm): the linear beam holds up to {small}"
    return [Warned("rotation", text, f"rotations of {most}, above {small}")]
