"""Hertz constants of all contacts with manufacturing errors, and corrections for close conformity of ball and groove.

Ball (radius r) and groove (radius rho) touch over an ellipse of semi-axes a, b. For a point of the ellipse, theta is the
angle at the ball's centre between this point and the contact's normal. Along the ball's normals an approach delta closes
the gap by delta cos(theta), whereas a growth e of the ball's radius closes it by e everywhere. The energy is the maximum
over pressures p >= 0 of (delta cos(theta) + e - gap) p - p C p / 2. Its derivative by delta is N = integral p cos(theta),
by e it is P = integral p. Hence the approach with the same effect on N as the growth e is

    delta_eq = e (dN/de) / (dN/ddelta) = e (dP/ddelta) / (dN/ddelta) = e dP/dN,

for any bodies. Hertz's moments <x^2> = a^2/5, <y^2> = b^2/5 give P = N (1 + (a^2 + b^2)/(10 r^2)), and a^2 ~ N^(2/3):

    delta_eq = e (1 + (a^2 + b^2)/(6 r^2)).                                                                            (1)

This equals an approach e with both relative curvatures reduced by e/r^2: per unit of curvature, Hertz's approach at
constant force changes by a^2/6 (1/2 d/dN of N a^2/5), so that the larger ball, which conforms more closely, gains
e (a^2 + b^2)/(6 r^2). If a groove's radius is smaller by e, only the curvature across the groove changes, by e/rho^2: along
the track the groove's normals do not turn with the ball's, so that the gap closes as by an approach. A profile error acts
through its offset and its curvature; the third and fourth derivatives contribute only at order (a/rho)^3 and are neglected.
Therefore Hertz's constants are evaluated at each contact's actual radii, which is exact. Limits: a flat contact (a << r)
has delta_eq = e; without errors nothing changes.

In addition, an approach is less effective than Hertz's theory assumes: it closes the gap by its cosine only, and only
p cos(theta) contributes to N. To first order in theta^2 the complementary energy grows by
delta integral p theta^2/2 = delta N (a^2 + b^2)/(10 r^2) ~ N^(7/3), and the approach by the derivative of this by N,

    delta = C N^(2/3) (1 + 7 (a^2 + b^2)/(30 r^2)).                                                                    (2)

The difference between arc and parabola changes the correction (2) by -3 % at a/r = 0.18. Valid for a < 0.3 r and
e << rho - r.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi import hertz
from rollbench.lowfi.compliance.parts import reduce_to_compliance_geometry
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, nominal_groove_radii
from rollbench.meshes.parts import SIDES, Errors, Material, Scene, UnfitKey
from rollbench.meshes.surface import ALL, groove_radius_with_slopes, principal_curvatures, printed_principal_radii


def curvature_changes(scene: Scene, drawn: GeometryWithErrors, ball_radius: Array) -> Array:
    """Return the changes of relative curvature between ball and flank by errors of ball radius, groove radius and profile.

    The groove's curvature is evaluated on its profile at the nominal contact angle.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    ball_radius
        Radii of the balls ``(..., N)`` [m].

    Returns
    -------
    Array
        ``(..., N, 4, 2)`` [1/m]: for each ball and flank the change across, then along the groove.
    """
    gamma = np.array(scene.track.contact_angle)
    profiles = [groove_radius_with_slopes(gamma, drawn.groove_radii[s], drawn.profile_coefficients[s]) for s in range(4)]
    nominal = _curvature_in_polar_coordinates(nominal_groove_radii(scene), np.zeros(4), np.zeros(4))
    change = _curvature_in_polar_coordinates(*np.stack(profiles, axis=1)) - nominal
    ball = 1.0 / ball_radius - 1.0 / scene.balls.radius
    changes = np.repeat(np.repeat(ball[..., None, None], 4, axis=-2), 2, axis=-1)
    changes[..., 0] -= change
    return np.asarray(changes)


def _curvature_in_polar_coordinates(radius: Array, slope: Array, bend: Array) -> Array:
    """Return the curvature [1/m] of a plane curve that is given in polar coordinates.

    Parameters
    ----------
    radius, slope, bend
        Radius [m] and its first and second derivatives by the angle [m].
    """
    return np.asarray((radius**2 + 2.0 * slope**2 - radius * bend) / np.hypot(radius, slope) ** 3)


def oblique_pressure_coefficient(constants: hertz.HertzConstants, ball_radius: float) -> Array:
    """Return the coefficient h [m/N^(4/3)] of the term h F^(4/3) that oblique pressure adds to a contact's approach.

    F is the contact force [N]. On a curved surface, the pressure at the edge of the contact ellipse acts at an angle to the
    contact's normal, which Hertz's theory neglects. With the Hertz constant C, the semi-axes a and b of the contact
    ellipse and the ball's radius r, the term is C F^(2/3) 7 (a^2 + b^2)/(30 r^2). It grows with F^(4/3), because a^2 and
    b^2 grow with F^(2/3).

    Parameters
    ----------
    constants
        Hertz constants of the flanks.
    ball_radius
        Radius of the balls [m].
    """
    return np.asarray(7.0 / 30.0 * constants.C * (constants.C_a**2 + constants.C_b**2) / ball_radius**2)


#: Number of ball radii between which `hertz_constants_by_scene_choice` interpolates the Hertz constant for many specimens;
#: and size of a coefficient of the interpolating polynomial, relative to the first one, below which it is round-off and
#: left out.
NODES, ROUND_OFF = 12, 1e-15


@lru_cache(maxsize=64)
def hertz_without_errors(scene: Scene) -> hertz.HertzConstants:
    """Return the Hertz constants of the four flanks ``(4,)`` for parts without errors at the nominal contact angle.

    The arrays come from a cache and must not be changed.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    return _cached_hertz_of_parts(_scene_of_parts_only(scene))


def nominal_curvatures(scene: Scene) -> Array:
    """Return the relative principal curvatures ``(4, 2)`` [1/m] of ball and each flank, for parts without errors.

    The curvature across the groove comes first. Curvatures are taken at the nominal contact angle. The array comes from a
    cache and must not be changed.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    return _cached_curvatures(_scene_of_parts_only(scene))


@lru_cache(maxsize=64)
def _scene_of_parts_only(scene: Scene) -> Scene:
    """Return a copy of a scene without loads, supports, errors and nut position, which serves as the key of caches."""
    return replace(reduce_to_compliance_geometry(scene), nut=replace(scene.nut, position=0.0, azimuth=0.0))


@lru_cache(maxsize=64)
def _cached_hertz_of_parts(bare: Scene) -> hertz.HertzConstants:
    """Return the Hertz constants ``(4,)`` of error-free parts, from a cache; ``bare``: scene with these parts only."""
    return _make_read_only(hertz_from_curvatures(bare, _cached_curvatures(bare)))


def _make_read_only(constants: hertz.HertzConstants) -> hertz.HertzConstants:
    """Make the arrays of Hertz constants read-only, because a cache shares them, and return the constants."""
    for values in (constants.C, constants.C_a, constants.C_b, constants.eccentricity):
        values.flags.writeable = False
    return constants


@lru_cache(maxsize=64)
def _cached_curvatures(bare: Scene) -> Array:
    """Return the relative principal curvatures ``(4, 2)`` [1/m] of the error-free parts of scene ``bare``, from a cache."""
    scene, layout = bare, ball_layout(bare)
    drawn = draw_geometry_with_errors(bare, layout)
    curvatures: Array = relative_curvatures(bare, drawn, np.full((layout.z.size, 4), scene.track.contact_angle))[0]
    curvatures.flags.writeable = False
    return curvatures


def hertz_with_errors(scene: Scene, drawn: GeometryWithErrors, ball_radius: Array | None = None) -> hertz.HertzConstants:
    """Return the Hertz constants ``(..., N, 4)`` of every contact from its radii with errors, at the nominal contact angle.

    For example, an oversize e of a ball of radius r reduces both relative curvatures by e/r^2; the approach e that it
    causes is not part of the result.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    ball_radius
        Radii of the balls ``(..., N)`` [m]; None: those in ``drawn``.
    """
    radius = drawn.ball_radii if ball_radius is None else ball_radius
    return hertz_from_curvatures(scene, nominal_curvatures(scene) + curvature_changes(scene, drawn, radius))


def hertz_with_errors_if_distinct(scene: Scene, drawn: GeometryWithErrors, ball_radius: Array) -> hertz.HertzConstants:
    """Return the Hertz constants ``(N, 4)`` of N balls and four flanks with errors; a single row if all balls are alike.

    The values are those of `hertz_with_errors`. For balls that are all alike the shape is ``(4,)`` or ``(1, 4)``.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    ball_radius
        Radii of the balls ``(N,)`` [m].
    """
    if not (ball_radius == ball_radius[0]).all():
        return hertz_with_errors(scene, drawn, ball_radius)
    nominal = ball_radius[0] == scene.balls.radius and (drawn.groove_radii == nominal_groove_radii(scene)).all()
    if nominal and not drawn.profile_coefficients.size:
        return hertz_without_errors(scene)
    return hertz_with_errors(scene, drawn, ball_radius[:1])


def hertz_of_every_contact(scene: Scene, drawn: GeometryWithErrors) -> hertz.HertzConstants:
    """Return the Hertz constants ``(N, 4)`` of every contact from its radii with errors, at the nominal contact angle.

    The values are those of `hertz_with_errors`, but computed only once if all balls are alike. The arrays must not be
    changed.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    """
    h, shape = hertz_with_errors_if_distinct(scene, drawn, drawn.ball_radii), (drawn.ball_radii.size, 4)
    return hertz.HertzConstants(*(np.broadcast_to(x, shape) for x in (h.C, h.C_a, h.C_b, h.eccentricity)))


def hertz_at_contact_angles(scene: Scene, drawn: GeometryWithErrors, gamma: Array) -> hertz.HertzConstants:
    """Return the Hertz constants ``(N, 4)`` at given contact angles, from the curvatures of the surfaces with their errors.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    gamma
        Contact angles ``(N, 4)`` [rad].

    Raises
    ------
    UnfitKey
        If a relative curvature of ball and groove is not positive; the message names the first such contact.
    """
    curvatures = relative_curvatures(scene, drawn, gamma)
    bad = np.argwhere(~(curvatures.min(axis=-1) > 0.0) | ~np.isfinite(curvatures).all(axis=-1))
    if bad.size:
        i, s = (int(k) for k in bad[0])
        across, along = curvatures[i, s]
        raise UnfitKey(
            f"errors.{SIDES[s]}",
            f"ball {i + 1} and flank {SIDES[s]} conform too closely at a contact angle of "
            f"{np.degrees(gamma[i, s]):.4g} deg: relative curvatures are {across:.3g} 1/m across the "
            f"groove and {along:.3g} 1/m along it, but Hertz's theory needs positive ones",
        )
    return hertz_from_curvatures(scene, curvatures)


def relative_curvatures(scene: Scene, drawn: GeometryWithErrors, gamma: Array) -> Array:
    """Return the relative principal curvatures ``(N, 4, 2)`` [1/m] of each ball and flank, across the groove first.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    gamma
        Contact angles ``(N, 4)`` [rad] at which curvatures are taken.
    """
    return np.asarray(1.0 / drawn.ball_radii[:, None, None] + principal_curvatures(scene, drawn, ALL, gamma))


def hertz_from_curvatures(scene: Scene, curvatures: Array) -> hertz.HertzConstants:
    """Return the Hertz constants ``(..., 4)`` of ball and flanks from their materials and relative curvatures.

    Parameters
    ----------
    scene
        Scene with the materials of balls, screw and nut.
    curvatures
        Relative curvatures ``(..., 4, 2)`` [1/m] across and along the groove, for the four flanks (screw left, screw right,
        nut left, nut right).
    """
    modulus = np.repeat([_contact_modulus(scene, body) for body in (scene.screw.material, scene.nut.material)], 2)
    return hertz.hertz_constants(curvatures[..., 0], curvatures[..., 1], modulus)


def _contact_modulus(scene: Scene, body: Material) -> float:
    """Return the contact modulus [Pa] of a ball and a ``body`` of another material."""
    ball = scene.balls.material
    return hertz.contact_modulus(ball.youngs_modulus, ball.poissons_ratio, body.youngs_modulus, body.poissons_ratio)


def misprinted_hertz_of_flanks(scene: Scene) -> tuple[hertz.PrintedHertzConstants, hertz.PrintedHertzConstants]:
    """Return the Hertz constants of a screw flank and of a nut flank as misprinted in Table B.1 of Lin's thesis.

    The principal radii in that table are not the radii of curvature of the surfaces; see
    `meshes.surface.printed_principal_radii`.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    bare = replace(scene, errors=Errors())
    drawn = draw_geometry_with_errors(bare, ball_layout(bare))
    gamma = np.full(scene.ball_count, scene.track.contact_angle)

    def misprinted_hertz_of_flank(side: int, body: Material) -> hertz.PrintedHertzConstants:
        """Return the Hertz constants of one flank by Table B.1 of Lin's thesis; ``body``: material of screw or nut.

        ``side``: number of the flank in the order screw left, screw right, nut left, nut right.
        """
        low, high = printed_principal_radii(bare, drawn, side, gamma)[0]
        radii = float(low), float(high)
        return hertz.hertz_constants_as_printed(scene.balls.radius, radii, _contact_modulus(scene, body))

    return misprinted_hertz_of_flank(0, scene.screw.material), misprinted_hertz_of_flank(3, scene.nut.material)


def scene_with_error_free_hertz(scene: Scene) -> Scene:
    """Return a copy of a scene that selects the Hertz constants of parts without errors, as published models use them.

    A scene that selects those printed in Lin's thesis (``hertz`` is "as printed") is returned unchanged.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    if scene.ingredients.hertz == "as printed":
        return scene
    return replace(scene, ingredients=replace(scene.ingredients, hertz="error-free"))


def hertz_constants_by_scene_choice(scene: Scene, drawn: GeometryWithErrors, ball_radius: Array | None = None) -> Array:
    """Return the Hertz constant C ``(..., N, 4)`` [m/N^(2/3)] of each ball and flank; approach = C Q^(2/3) at the force Q.

    The scene's ``hertz`` decides from which dimensions C is computed: "error-free", the nominal dimensions; "as printed",
    Table B.1 of Lin's thesis with its misprints; otherwise the radii with their manufacturing errors. The contact angle is
    the nominal one.

    Parameters
    ----------
    scene
        Scene with the nominal dimensions of screw, nut and balls.
    drawn
        Dimensions of screw, nut and balls with their manufacturing errors.
    ball_radius
        Radii of the balls ``(..., N)`` [m]; None: those in ``drawn``.
    """
    radius = drawn.ball_radii if ball_radius is None else ball_radius
    kind, of_every_ball = scene.ingredients.hertz, (*radius.shape, 4)
    if kind == "as printed":
        return np.array(np.broadcast_to(np.repeat([x.C for x in misprinted_hertz_of_flanks(scene)], 2), of_every_ball))
    if kind == "error-free":
        return np.array(np.broadcast_to(hertz_without_errors(scene).C, of_every_ball))
    if radius.ndim == 1:
        return np.array(np.broadcast_to(hertz_with_errors_if_distinct(scene, drawn, radius).C, of_every_ball))
    from numpy.polynomial.chebyshev import chebinterpolate, chebval

    # C is smooth in the radius: a polynomial through few exact values is exact to round-off for all specimens
    middle, half = 0.5 * (radius.max() + radius.min()), max(0.5 * float(radius.max() - radius.min()), 1e-9)
    series = chebinterpolate(lambda x: hertz_with_errors(scene, drawn, middle + half * x).C, NODES - 1)  # type: ignore[type-var]
    shown = np.flatnonzero((np.abs(series) > ROUND_OFF * np.abs(series[0])).any(axis=1))[-1]
    distinct, of_side = np.unique(series[: shown + 1], axis=1, return_inverse=True)
    values = chebval((radius - middle) / half, distinct)
    return np.stack([values[k] for k in of_side.ravel()], axis=-1)
