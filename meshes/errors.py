"""Geometric errors of a screw or bearing: random errors are drawn, and all errors are evaluated at the balls' positions.

After Lin (2019), eqs. (2.27), (4.1) and (4.3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import zip_longest
from math import cos
from typing import Any, cast

import numpy as np

from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.helix import BallLayout, lead_angle, nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import SIDES, FourierTerm, Scene, SideErrors

#: Axial distance from the nut's centre up to which a ball counts as at the centre, as a ratio to the ball's radius.
AT_CENTRE = 1e-6
#: Placeholder for the random generator where nothing is random, so that `numpy.random` need not be imported.
_UNUSED = cast("np.random.Generator", None)


@dataclass(frozen=True)
class GeometryWithErrors:
    """Geometry with errors of one screw or bearing (specimen) at its n balls: ball radii, groove centres, groove radii."""

    #: Ball radii ``(n,)`` [m].
    ball_radii: Array
    #: Centres of the arcs of the four flanks (screw left, screw right, nut left, nut right) in the section normal to the
    #: track at each ball ``(n, 4, 2)`` [m]: coordinates x3 radial, z3 across the track.
    groove_centres: Array
    #: First and second derivatives of the groove centres with respect to azimuth ``(2, n, 4, 2)`` [m/rad, m/rad2].
    groove_centre_derivatives: Array
    #: Groove radii of the flanks ``(4,)`` [m].
    groove_radii: Array
    #: Profile errors of the four flanks: offset of the groove surface towards its arc's centre, as d coefficients [m] of a
    #: polynomial in the section angle [rad], by ascending powers ``(4, d)``; d = 0 without profile errors.
    profile_coefficients: Array


def _draw_terms(terms: tuple[FourierTerm, ...], rng: np.random.Generator) -> list[tuple[float, float, float]]:
    """Add normal random numbers to the amplitudes of the Fourier terms of an error along the track.

    ``rng``: generator of random numbers. Returns, for each term, its harmonic and its amplitudes of sine and cosine [m].
    """
    drawn = []
    for term in terms:
        a, b = rng.normal(0.0, term.sigma, 2) if term.sigma > 0.0 else (0.0, 0.0)
        drawn.append((term.harmonic, term.sin + a, term.cos + b))
    return drawn


def _series_with_slopes(drawn: list[tuple[float, float, float]], phi: Array) -> Array:
    """Return the value of a Fourier series and its first two derivatives at n azimuths ``(3, n)`` [m, m/rad, m/rad2].

    ``drawn``: terms from `_draw_terms`, each with its harmonic and its amplitudes of sine and cosine [m];
    ``phi``: azimuths ``(n,)`` [rad].
    """
    total = np.zeros((3, phi.size))
    for h, a, b in drawn:
        s, c = np.sin(h * phi), np.cos(h * phi)
        total += np.stack([a * s + b * c, h * (a * c - b * s), -h * h * (a * s + b * c)])
    return total


def _draw_profile(side: SideErrors, rng: np.random.Generator) -> list[float]:
    """Return the coefficients of a flank's profile error [m], after normal random numbers are added to them.

    The error is an offset of the groove's surface towards its arc's centre, a polynomial in the section angle [rad].
    Returns its coefficients in ascending powers. ``side``: errors of the flank; ``rng``: generator of random numbers.
    """
    terms = zip_longest(side.profile, side.profile_sigma, fillvalue=0.0)
    return [float(m + (rng.normal(0.0, s) if s > 0.0 else 0.0)) for m, s in terms]


def ball_radii_without_random_errors(scene: Scene) -> Array:
    """Return the radii of all loaded balls ``(n,)`` [m]: nominal radius, oversize, and the error listed for the ball."""
    radii = np.full(scene.ball_count, scene.balls.radius + scene.errors.balls.oversize)
    for number, error in scene.errors.balls.listed:
        radii[number - 1] += error
    return radii


def draw_ball_radii(scene: Scene, rng: np.random.Generator, return_path_balls: int | None = None) -> Array:
    """Return the radii of all balls: nominal radius, oversize, the error listed for the ball, and a drawn random error.

    A uniform distribution has the half width sqrt(3) sigma, so that its standard deviation is sigma.

    Parameters
    ----------
    scene : Scene
        Scene with the errors of the balls.
    rng : np.random.Generator
        Generator of random numbers; not used where ``sigma`` is 0.
    return_path_balls : int | None, default None
        Number of balls in the return paths of a screw. If it is given, the radii of only these balls are drawn, without
        errors listed for single balls. None: the radii of the loaded balls are drawn.

    Returns
    -------
    (n,) Array
        Radii [m].
    """
    errors = scene.errors.balls
    if return_path_balls is None:
        radius = ball_radii_without_random_errors(scene)
    else:
        radius = np.full(return_path_balls, scene.balls.radius + errors.oversize)
    if errors.sigma > 0.0:
        if errors.distribution == "normal":
            radius += rng.normal(0.0, errors.sigma, radius.size)
        else:
            half = np.sqrt(3.0) * errors.sigma
            radius += rng.uniform(-half, half, radius.size)
    return radius


@dataclass(frozen=True)
class ErrorsAfterDrawing:
    """Errors of one screw or bearing (specimen) after random errors are drawn: ball radii, and errors along the flanks."""

    #: Radii of the balls ``(n,)`` [m].
    ball_radii: Array
    #: Pitch error of each flank: terms (harmonic, amplitude of the sine [m], of the cosine [m]).
    pitch_terms: tuple[list[tuple[float, float, float]], ...]
    #: Roundness error of each flank: terms (harmonic, amplitude of the sine [m], of the cosine [m]).
    roundness_terms: tuple[list[tuple[float, float, float]], ...]
    #: Profile error of each flank: offset of the groove surface towards its arc's centre, as coefficients [m] of a
    #: polynomial in the section angle [rad], by ascending powers.
    profile_coefficients: tuple[list[float], ...]

    def geometry_at_balls(
        self, scene: Scene, azimuths_on_screw: Array, azimuths_on_nut: Array, axial_positions: Array, ball_radii: Array
    ) -> GeometryWithErrors:
        """Evaluate the drawn errors at the positions of balls.

        Parameters
        ----------
        scene : Scene
            Scene with the nominal geometry.
        azimuths_on_screw, azimuths_on_nut : (n,) Array
            Azimuths of the balls in the axes of the screw, and in those of the nut [rad].
        axial_positions : (n,) Array
            Axial positions of the balls [m].
        ball_radii : (n,) Array
            Radii of the balls [m].

        Returns
        -------
        GeometryWithErrors
            Geometry with errors at these balls.

        References
        ----------
        Lin (2019), eqs. (2.27), (4.1) and (4.3).
        """
        n = ball_radii.size
        centre, slopes = _groove_centres_with_lead_offset(scene, axial_positions), np.zeros((2, n, 4, 2))
        for s, name in enumerate(SIDES):
            if not self.pitch_terms[s] and not self.roundness_terms[s]:
                continue
            phi = azimuths_on_nut if name.startswith("N") else azimuths_on_screw
            along = cos(lead_angle(scene.track)) if scene.errors.side(name).pitch_along == "axis" else 1.0
            # (2.27): roundness along x3, pitch along z3; (4.1) has the pitch error along the axis
            roundness, pitch = (_series_with_slopes(x[s], phi) for x in (self.roundness_terms, self.pitch_terms))
            offset = np.stack([roundness, along * pitch], axis=-1)
            centre[:, s] += offset[0]
            slopes[:, :, s] += offset[1:]
        degree = max(len(p) for p in self.profile_coefficients)
        table = np.array([p + [0.0] * (degree - len(p)) for p in self.profile_coefficients]).reshape(4, degree)
        radius = nominal_groove_radii(scene)
        if degree == 1:  # a constant offset is a change of radius, not of shape
            radius, table = radius - table[:, 0], np.zeros((4, 0))
        return GeometryWithErrors(ball_radii, centre, slopes, radius, table)


def are_in_shifted_half(scene: Scene, axial_positions: Array) -> Mask:
    """Return whether each ball is in the half of the nut at larger z, in which a lead offset shifts the groove.

    The groove has a step at the nut's centre, between two balls. A ball at this centre belongs to the half that is not
    shifted.

    Parameters
    ----------
    scene : Scene
        Scene with the nut's position and the ball radius.
    axial_positions : (n,) Array
        Axial positions of the balls [m].

    Returns
    -------
    (n,) Mask
        True for balls in the shifted half.
    """
    return np.asarray(axial_positions - scene.nut.position > AT_CENTRE * scene.balls.radius)


def _groove_centres_with_lead_offset(scene: Scene, axial_positions: Array) -> Array:
    """Return the nominal groove centres at the balls, shifted by the nut's lead offset ``(n, 4, 2)`` [m].

    ``axial_positions``: axial positions of the balls ``(n,)`` [m]. A groove shifted along the axis by d is shifted across
    the track by d cos(alpha), with the lead angle alpha. The shift along the track has no effect, because the groove is the
    same everywhere along the track.
    """
    centre, offset = np.empty((axial_positions.size, 4, 2)), scene.errors.lead_offset
    centre[:] = nominal_groove_centres(scene)
    if offset != 0.0:
        centre[are_in_shifted_half(scene, axial_positions), 2:, 1] += offset * cos(lead_angle(scene.track))
    return centre


def draw_errors(scene: Scene, specimen_number: int = 0) -> ErrorsAfterDrawing:
    """Draw the random errors of one specimen, that is, one screw or bearing with its own random errors.

    The same seed and number give the same specimen. Random numbers are drawn first for the ball radii, then for pitch,
    roundness and profile of one flank after the other (screw left, screw right, nut left, nut right).

    Parameters
    ----------
    scene : Scene
        Scene with errors and seed.
    specimen_number : int, default 0
        Number of the specimen.

    Returns
    -------
    ErrorsAfterDrawing
        Ball radii, and the errors along the flanks.
    """
    rng = np.random.default_rng([scene.errors.seed, specimen_number]) if scene.errors.random else _UNUSED
    radii = draw_ball_radii(scene, rng)
    sides = [scene.errors.side(name) for name in SIDES]
    terms = [(_draw_terms(e.pitch, rng), _draw_terms(e.roundness, rng), _draw_profile(e, rng)) for e in sides]
    pitch, roundness, profile = zip(*terms, strict=True)
    return ErrorsAfterDrawing(radii, pitch, roundness, profile)


def draw_geometry_with_errors(scene: Scene, layout: BallLayout, specimen_number: int = 0) -> GeometryWithErrors:
    """Draw the random errors of one screw or bearing (specimen), and return its geometry at the balls; see `draw_errors`.

    Parameters
    ----------
    scene : Scene
        Scene with errors and seed.
    layout : BallLayout
        Positions of the balls.
    specimen_number : int, default 0
        Number of the specimen.

    Returns
    -------
    GeometryWithErrors
        Geometry of the specimen at the balls.

    Examples
    --------
    >>> import rollbench
    >>> from rollbench.meshes.helix import ball_layout
    >>> scene = rollbench.read("lin-case1")
    >>> draw_geometry_with_errors(scene, ball_layout(scene)).ball_radii[:2].tolist()
    [0.002778, 0.002778]
    """
    return _geometry_at_scene_balls(scene, layout, draw_errors(scene, specimen_number))


def _geometry_at_scene_balls(scene: Scene, layout: BallLayout, drawn: ErrorsAfterDrawing) -> GeometryWithErrors:
    """Return the geometry with the errors ``drawn`` at a scene's balls, whose positions are ``layout``."""
    return drawn.geometry_at_balls(scene, layout.azimuth, layout.azimuth - scene.nut.azimuth, layout.z, drawn.ball_radii)


@dataclass(frozen=True)
class GeometriesWithErrors:
    """Geometry of m screws or bearings with different random errors, at their n balls; all have the same groove radii."""

    #: Ball radii ``(m, n)`` [m].
    ball_radii: Array
    #: Centres of the arcs of the four flanks, at each of n balls of m specimens ``(m, n, 4, 2)`` [m], or ``(1, n, 4, 2)``
    #: where they are the same in all specimens; coordinates x3 radial, z3 across the track.
    groove_centres: Array
    #: Groove radii ``(4,)`` [m].
    groove_radii: Array


def have_equal_circular_grooves(scene: Scene) -> bool:
    """Return whether the grooves of all specimens are equal circular arcs, as `draw_geometries_with_errors` needs.

    A specimen is one screw or bearing with its own random errors.

    Parameters
    ----------
    scene : Scene
        Scene with the errors.

    Returns
    -------
    bool
        False where profile errors are random, or vary with the angle around the arc of the groove section.
    """
    sides = [scene.errors.side(name) for name in SIDES]
    return not any(len(e.profile) > 1 or any(s > 0.0 for s in e.profile_sigma) for e in sides)


def draw_geometries_with_errors(scene: Scene, layout: BallLayout, first_number: int, count: int) -> GeometriesWithErrors:
    """Draw the errors of several screws or bearings (specimens), and return their geometry at the balls.

    The grooves of all must be equal circular arcs (`have_equal_circular_grooves`).

    Parameters
    ----------
    scene, layout
        Scene with errors and seed; and positions of its balls, as for `draw_geometry_with_errors`.
    first_number, count : int
        Number of the first specimen, and number of specimens.

    Returns
    -------
    GeometriesWithErrors
        Geometry of the specimens at the balls.
    """
    drawn = [draw_errors(scene, member) for member in range(first_number, first_number + count)]
    along_tracks = [(one.pitch_terms, one.roundness_terms) for one in drawn]
    shared = all(errors == along_tracks[0] for errors in along_tracks)
    places = [_geometry_at_scene_balls(scene, layout, one) for one in (drawn[:1] if shared else drawn)]
    radii, centres = np.stack([one.ball_radii for one in drawn]), np.stack([x.groove_centres for x in places])
    return GeometriesWithErrors(radii, centres, places[0].groove_radii)


def scene_with_drawn_errors(scene: Scene, specimen_number: int = 0) -> Scene:
    """Return a scene with fixed errors: the values drawn for one specimen replace the random errors.

    Parameters
    ----------
    scene : Scene
        Scene with errors and seed.
    specimen_number : int, default 0
        Number of the specimen, see `draw_errors`.

    Returns
    -------
    Scene
        Scene without random errors; the scene itself where nothing is random.
    """
    if not scene.errors.random:
        return scene
    drawn, errors = draw_errors(scene, specimen_number), scene.errors
    nominal = scene.balls.radius + errors.balls.oversize
    listed = tuple((i, float(radius - nominal)) for i, radius in enumerate(drawn.ball_radii, 1))
    SL, SR, NL, NR = (
        replace(
            errors.side(name),
            pitch=tuple(FourierTerm(*term) for term in drawn.pitch_terms[s]),
            roundness=tuple(FourierTerm(*term) for term in drawn.roundness_terms[s]),
            profile=tuple(drawn.profile_coefficients[s]),
            profile_sigma=(),
        )
        for s, name in enumerate(SIDES)
    )
    balls = replace(errors.balls, listed=listed, sigma=0.0)
    return replace(scene, errors=replace(errors, balls=balls, SL=SL, SR=SR, NL=NL, NR=NR))


def scene_without_random_errors(scene: Scene) -> Scene:
    """Return a scene whose errors have standard deviations of 0; errors that are not random are unchanged.

    Parameters
    ----------
    scene : Scene
        Scene with the errors.

    Returns
    -------
    Scene
        Copy of the scene without random errors.
    """
    errors = scene.errors
    sides: dict[str, Any] = {}
    for name in SIDES:
        e = errors.side(name)
        pitch, roundness = (tuple(replace(term, sigma=0.0) for term in terms) for terms in (e.pitch, e.roundness))
        sides[name] = replace(e, profile_sigma=(), pitch=pitch, roundness=roundness)
    balls = replace(errors.balls, sigma=0.0, distribution="normal")
    return replace(scene, errors=replace(errors, balls=balls, **sides))
