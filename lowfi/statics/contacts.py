"""Hertz constants of a scene's contacts with all errors, and corrections where ball and groove conform.

Ball (radius r) and groove (radius rho) touch over an ellipse of semi-axes a, b; theta is the angle of a point of it at the
ball's centre from the contact's normal. Along the ball's normals an approach delta closes the gap by delta cos(theta), a
growth e of the ball by e, everywhere. With the energy max over p >= 0 of (delta cos(theta) + e - gap) p - p C p / 2, of
slope N = integral p cos(theta) by delta and P = integral p by e, the approach that does to N what the growth does is

    delta_eq = e (dN/de) / (dN/ddelta) = e (dP/ddelta) / (dN/ddelta) = e dP/dN,

for any bodies. Hertz's moments <x^2> = a^2/5, <y^2> = b^2/5 give P = N (1 + (a^2 + b^2)/(10 r^2)), and a^2 ~ N^(2/3):

    delta_eq = e (1 + (a^2 + b^2)/(6 r^2)).                                                                            (1)

That is the approach e with both relative curvatures less by e/r^2: Hertz's approach at a given force grows by a^2/6 per
curvature (1/2 d/dN of N a^2/5), so that the larger ball, which conforms more, gains e (a^2 + b^2)/(6 r^2). A groove
smaller by e closes the gap by more than an approach across it, where its arc shrinks, and like one along the track, where
its normals do not turn with the ball's: only the curvature across changes, by e/rho^2. A profile's offset does it by its
curvature; its third and fourth derivatives join by moments of order (a/rho)^3 and are left out. So Hertz's constants are
taken at each contact's actual radii, exactly. Limits: a flat contact (a << r) keeps delta_eq = e; without errors nothing
changes.

The approach itself does less than Hertz's: it closes the gap by its cosine, and only p cos(theta) carries N. To first
order in theta^2 the complementary energy grows by delta integral p theta^2/2 = delta N (a^2 + b^2)/(10 r^2) ~ N^(7/3), and
the approach by its derivative by N,

    delta = C N^(2/3) (1 + 7 (a^2 + b^2)/(30 r^2)).                                                                    (2)

The arc's departure from a parabola is worth -3 % of (2) at a/r = 0.18. Valid for a < 0.3 r and e << rho - r.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.parts import geometry_only
from rollbench.lowfi.hertz import HertzConstants, PrintedHertz, contact_modulus, hertz_constants, printed_hertz
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.helix import ball_layout, groove_radii
from rollbench.meshes.parts import SIDES, Errors, Material, Scene, UnfitKey
from rollbench.meshes.surface import ALL, groove_profile, principal_curvatures, printed_radii


def curvature_changes(scene: Scene, drawn: Specimen, ball_radius: Array) -> Array:
    """Return the change of each contact's relative curvatures by the errors of its radii.

    The groove's curvature is that of its profile at the nominal contact angle.

    Parameters
    ----------
    scene, drawn
        The scene and its parts with their errors.
    ball_radius
        ``(..., N)`` [m].

    Returns
    -------
    Array
        ``(..., N, 4, 2)`` [1/m], across the groove first.
    """
    gamma = np.array(scene.track.contact_angle)
    profiles = [groove_profile(gamma, drawn.radius[s], drawn.profile[s]) for s in range(4)]
    change = _curvature(*np.stack(profiles, axis=1)) - _curvature(groove_radii(scene), np.zeros(4), np.zeros(4))
    ball = 1.0 / ball_radius - 1.0 / scene.balls.radius
    changes = np.repeat(np.repeat(ball[..., None, None], 4, axis=-2), 2, axis=-1)
    changes[..., 0] -= change
    return np.asarray(changes)


def _curvature(radius: Array, slope: Array, bend: Array) -> Array:
    """Return the curvature [1/m] of a curve in polar coordinates from its radius and derivatives by angle."""
    return np.asarray((radius**2 + 2.0 * slope**2 - radius * bend) / np.hypot(radius, slope) ** 3)


def oblique_term(constants: HertzConstants, ball_radius: float) -> Array:
    """Return the factor h [m/N^(4/3)] of the approach h F^(4/3) that oblique pressure adds, by (2)."""
    return np.asarray(7.0 / 30.0 * constants.C * (constants.C_a**2 + constants.C_b**2) / ball_radius**2)


#: Number of radii at which `hertz_C` takes exact values for many specimens, and share of a coefficient that is round-off.
NODES, ROUND_OFF = 12, 1e-15


@lru_cache(maxsize=64)
def error_free_hertz(scene: Scene) -> HertzConstants:
    """Return the Hertz constants ``(4,)`` of the error-free parts at the nominal contact angle.

    Cached for all solutions of a scene: not to be written to.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    return _hertz_of(_parts_alone(scene))


def nominal_curvatures(scene: Scene) -> Array:
    """Return the relative principal curvatures ``(4, 2)`` [1/m] of the error-free parts, across the groove first.

    At the nominal contact angle; cached for all scenes of the same parts: not to be written to.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    return _curvatures_of(_parts_alone(scene))


@lru_cache(maxsize=64)
def _parts_alone(scene: Scene) -> Scene:
    return replace(geometry_only(scene), nut=replace(scene.nut, position=0.0, azimuth=0.0))


def forget_nominal() -> None:
    """Clear the caches of nominal contacts, so that the next solve is timed with its set-up."""
    for kept in (_curvatures_of, _hertz_of, _hertz_at, error_free_hertz):
        kept.cache_clear()


@lru_cache(maxsize=64)
def _hertz_of(bare: Scene) -> HertzConstants:
    return _unwritable(constants_of(bare, _curvatures_of(bare)))


@lru_cache(maxsize=64)
def _hertz_at(bare: Scene, ball_radius: float) -> HertzConstants:
    """Return the constants ``(1, 4)`` of error-free grooves with balls of another radius [m]."""
    return _unwritable(drawn_hertz(bare, specimen(bare, ball_layout(bare)), np.array([ball_radius])))


def _unwritable(constants: HertzConstants) -> HertzConstants:
    for values in (constants.C, constants.C_a, constants.C_b, constants.eccentricity):
        values.flags.writeable = False
    return constants


@lru_cache(maxsize=64)
def _curvatures_of(bare: Scene) -> Array:
    scene, layout = bare, ball_layout(bare)
    drawn = specimen(bare, layout)
    curvatures: Array = relative_curvatures(bare, drawn, np.full((layout.z.size, 4), scene.track.contact_angle))[0]
    curvatures.flags.writeable = False
    return curvatures


def drawn_hertz(scene: Scene, drawn: Specimen, ball_radius: Array | None = None) -> HertzConstants:
    """Return the Hertz constants ``(..., N, 4)`` of every contact at the nominal contact angle, with the actual radii.

    Parameters
    ----------
    scene, drawn
        The scene and its parts with their errors.
    ball_radius
        Radii ``(..., N)`` [m] in place of the drawn ones. Their effect on an oversize is (1).
    """
    radius = drawn.ball_radius if ball_radius is None else ball_radius
    return constants_of(scene, nominal_curvatures(scene) + curvature_changes(scene, drawn, radius))


def distinct_hertz(scene: Scene, drawn: Specimen, ball_radius: Array) -> HertzConstants:
    """Return the constants of `drawn_hertz` for balls of radii ``(N,)`` [m], as one row where all balls are alike."""
    if not (ball_radius == ball_radius[0]).all():
        return drawn_hertz(scene, drawn, ball_radius)
    if drawn.profile.size or not (drawn.radius == groove_radii(scene)).all():
        return drawn_hertz(scene, drawn, ball_radius[:1])
    if ball_radius[0] == scene.balls.radius:
        return error_free_hertz(scene)
    return _hertz_at(_parts_alone(scene), float(ball_radius[0]))


def own_hertz(scene: Scene, drawn: Specimen) -> HertzConstants:
    """Return the Hertz constants ``(N, 4)`` of every contact with its actual radii, at the nominal contact angle.

    As `drawn_hertz`, computed once where all balls are alike; not to be written to.

    Parameters
    ----------
    scene, drawn
        The scene and its parts with their errors.
    """
    h, shape = distinct_hertz(scene, drawn, drawn.ball_radius), (drawn.ball_radius.size, 4)
    return HertzConstants(*(np.broadcast_to(x, shape) for x in (h.C, h.C_a, h.C_b, h.eccentricity)))


def actual_hertz(scene: Scene, drawn: Specimen, gamma: Array) -> HertzConstants:
    """Return the Hertz constants ``(N, 4)`` from the exact surfaces with all errors.

    Parameters
    ----------
    scene, drawn
        The scene and its parts with their errors.
    gamma
        Contact angles ``(N, 4)`` [rad].

    Raises
    ------
    UnfitKey
        Ball and groove that conform; the text names the first such contact.
    """
    curvatures = relative_curvatures(scene, drawn, gamma)
    bad = np.argwhere(~(curvatures.min(axis=-1) > 0.0) | ~np.isfinite(curvatures).all(axis=-1))
    if bad.size:
        i, s = (int(k) for k in bad[0])
        across, along = curvatures[i, s]
        raise UnfitKey(
            f"errors.{SIDES[s]}",
            f"ball {i + 1} and flank {SIDES[s]} conform at their contact angle of {np.degrees(gamma[i, s]):.4g} deg: "
            f"relative curvatures {across:.3g} 1/m across the groove, {along:.3g} 1/m along it; Hertz needs positive ones",
        )
    return constants_of(scene, curvatures)


def relative_curvatures(scene: Scene, drawn: Specimen, gamma: Array) -> Array:
    """Return the relative principal curvatures ``(N, 4, 2)`` [1/m], across the groove first.

    At contact angles ``(N, 4)`` [rad].
    """
    return np.asarray(1.0 / drawn.ball_radius[:, None, None] + principal_curvatures(scene, drawn, ALL, gamma))


def constants_of(scene: Scene, curvatures: Array) -> HertzConstants:
    """Return the Hertz constants ``(..., 4)`` of the flanks' materials at relative curvatures ``(..., 4, 2)`` [1/m]."""
    ball = scene.balls.material
    bodies = [scene.screw.material] * 2 + [scene.nut.material] * 2
    modulus = np.array(
        [contact_modulus(ball.youngs_modulus, ball.poissons_ratio, x.youngs_modulus, x.poissons_ratio) for x in bodies]
    )
    return hertz_constants(curvatures[..., 0], curvatures[..., 1], modulus)


def printed_sides(scene: Scene) -> tuple[PrintedHertz, PrintedHertz]:
    """Return the Hertz constants of a flank of screw and nut with the errors of Lin's Table B.1.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    bare = replace(scene, errors=Errors())
    drawn = specimen(bare, ball_layout(bare))
    gamma = np.full(scene.ball_count, scene.track.contact_angle)
    ball = scene.balls.material

    def of(side: int, body: Material) -> PrintedHertz:
        modulus = contact_modulus(ball.youngs_modulus, ball.poissons_ratio, body.youngs_modulus, body.poissons_ratio)
        low, high = printed_radii(bare, drawn, side, gamma)[0]
        return printed_hertz(scene.balls.radius, (float(low), float(high)), modulus)

    return of(0, scene.screw.material), of(3, scene.nut.material)


def _as_printed(scene: Scene) -> Array:
    """Return the constants C of each flank with the errors of Lin's Table B.1, ``(4,)`` [m/N^(2/3)]."""
    return np.repeat([side.C for side in printed_sides(scene)], 2)


def error_free(scene: Scene) -> Scene:
    """Return the scene with Hertz constants of error-free parts, as the publications' models use them, or as printed.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    if scene.ingredients.hertz == "as printed":
        return scene
    return replace(scene, ingredients=replace(scene.ingredients, hertz="error-free"))


def hertz_C(scene: Scene, drawn: Specimen, ball_radius: Array | None = None) -> Array:
    """Return the Hertz constant C of each ball and flank ``(..., N, 4)`` [m/N^(2/3)] by the scene's ``hertz``.

    Before any update to the solved contact angles.

    Parameters
    ----------
    scene, drawn
        The scene and its parts with their errors.
    ball_radius
        Radii ``(..., N)`` [m] in place of the drawn ones.
    """
    radius = drawn.ball_radius if ball_radius is None else ball_radius
    kind = scene.ingredients.hertz
    if kind in ("as printed", "error-free"):
        return _repeated(_as_printed(scene) if kind == "as printed" else error_free_hertz(scene).C, radius.shape)
    if radius.ndim == 1:
        return _repeated(distinct_hertz(scene, drawn, radius).C, radius.shape)
    from numpy.polynomial.chebyshev import chebinterpolate, chebval

    # C is smooth in the radius: for many specimens a polynomial through few exact values has all digits
    middle, half = 0.5 * (radius.max() + radius.min()), max(0.5 * float(radius.max() - radius.min()), 1e-9)
    series = chebinterpolate(lambda x: drawn_hertz(scene, drawn, middle + half * x).C, NODES - 1)  # type: ignore[type-var]
    shown = np.flatnonzero((np.abs(series) > ROUND_OFF * np.abs(series[0])).any(axis=1))[-1]
    distinct, of_side = np.unique(series[: shown + 1], axis=1, return_inverse=True)
    values = chebval((radius - middle) / half, distinct)
    return np.stack([values[k] for k in of_side.ravel()], axis=-1)


def _repeated(row: Array, shape: tuple[int, ...]) -> Array:
    """Return values ``(4,)`` of the flanks, or ``(*shape, 4)``, for every ball."""
    values = np.empty((*shape, 4))
    values[...] = row
    return values
