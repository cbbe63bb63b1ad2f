"""Geometric errors of one screw: from their description to the numbers of one specimen.

Source: Lin (2019), eqs. (2.27), (4.1) and (4.3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import zip_longest
from math import cos
from typing import Any, cast

import numpy as np

from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.helix import BallLayout, groove_radii, lead_angle, nominal_groove_centres
from rollbench.meshes.parts import SIDES, FourierTerm, Scene, SideErrors

#: Distance from the nut's centre, over the ball's radius, up to which a ball counts as at the centre.
AT_CENTRE = 1e-6
#: In place of a generator where nothing is random: `numpy.random` is not loaded there.
_UNUSED = cast("np.random.Generator", None)


@dataclass(frozen=True)
class Specimen:
    """Geometric errors of one screw at its n balls, random ones drawn."""

    #: Ball radii ``(n,)`` [m].
    ball_radius: Array
    #: Groove centres (x3, z3) of the flanks SL, SR, NL, NR in the section of each ball ``(n, 4, 2)`` [m].
    centre: Array
    #: First and second derivatives of the centres by azimuth ``(2, n, 4, 2)`` [m/rad, m/rad2].
    centre_slopes: Array
    #: Groove radii of the flanks ``(4,)`` [m].
    radius: Array
    #: Coefficients of the inward offset in powers of the section angle in rad ``(4, d)`` [m]; d = 0 without profile
    #: errors.
    profile: Array


def _draw_terms(terms: tuple[FourierTerm, ...], rng: np.random.Generator) -> list[tuple[float, float, float]]:
    drawn = []
    for term in terms:
        a, b = rng.normal(0.0, term.sigma, 2) if term.sigma > 0.0 else (0.0, 0.0)
        drawn.append((term.harmonic, term.sin + a, term.cos + b))
    return drawn


def _fourier_series(drawn: list[tuple[float, float, float]], phi: Array) -> Array:
    """Value and first two derivatives of a Fourier series, shape ``(3, n)``."""
    total = np.zeros((3, phi.size))
    for h, a, b in drawn:
        s, c = np.sin(h * phi), np.cos(h * phi)
        total += np.stack([a * s + b * c, h * (a * c - b * s), -h * h * (a * s + b * c)])
    return total


def _draw_profile(side: SideErrors, rng: np.random.Generator) -> list[float]:
    terms = zip_longest(side.profile, side.profile_sigma, fillvalue=0.0)
    return [float(m + (rng.normal(0.0, s) if s > 0.0 else 0.0)) for m, s in terms]


def draw_ball_radii(scene: Scene, rng: np.random.Generator, others: int | None = None) -> Array:
    """Ball radii: nominal radius, oversize, listed errors and one random draw each.

    A uniform distribution has the given standard deviation: half width sqrt(3) sigma.

    Parameters
    ----------
    scene : Scene
        Gives the errors of the balls.
    rng : np.random.Generator
        Source of the draws; not used where ``sigma`` is 0.
    others : int | None, default None
        Draw radii of so many further balls, in the return of a screw, to which no listed error belongs.

    Returns
    -------
    (n,) Array
        Radii [m].
    """
    errors = scene.errors.balls
    radius = np.full(scene.ball_count if others is None else others, scene.balls.radius + errors.oversize)
    for number, error in errors.listed if others is None else ():
        radius[number - 1] += error
    if errors.sigma > 0.0:
        if errors.distribution == "normal":
            radius += rng.normal(0.0, errors.sigma, radius.size)
        else:
            half = np.sqrt(3.0) * errors.sigma
            radius += rng.uniform(-half, half, radius.size)
    return radius


@dataclass(frozen=True)
class Drawn:
    """Error functions of one screw, random ones drawn, not yet evaluated at its balls."""

    #: Radii of the scene's balls ``(n,)`` [m].
    ball_radius: Array
    #: Pitch of each flank, terms (harmonic, sine [m], cosine [m]) of the pitch error.
    pitch: tuple[list[tuple[float, float, float]], ...]
    #: Roundness of each flank, terms (harmonic, sine [m], cosine [m]) of the roundness error.
    roundness: tuple[list[tuple[float, float, float]], ...]
    #: Profile of each flank, coefficients of the inward offset [m], ascending powers of the section angle in rad.
    profile: tuple[list[float], ...]

    def at(self, scene: Scene, on_screw: Array, on_nut: Array, station: Array, ball_radius: Array) -> Specimen:
        """Evaluate the errors where balls are.

        Parameters
        ----------
        scene : Scene
            Nominal geometry.
        on_screw, on_nut : (n,) Array
            Azimuths of the balls [rad] on the screw, and from the nut's axis of errors.
        station : (n,) Array
            Stations of the balls along the axis [m].
        ball_radius : (n,) Array
            Radii of the balls [m].

        Returns
        -------
        Specimen
            Errors at these balls.

        References
        ----------
        Lin (2019), eqs. (2.27), (4.1) and (4.3).
        """
        n = ball_radius.size
        centre, slopes = _shifted_centres(scene, station), np.zeros((2, n, 4, 2))
        for s, name in enumerate(SIDES):
            if not self.pitch[s] and not self.roundness[s]:
                continue
            phi = on_nut if name.startswith("N") else on_screw
            along = cos(lead_angle(scene.track)) if scene.errors.side(name).pitch_along == "axis" else 1.0
            # (2.27): roundness along x3, pitch along z3; (4.1) has the pitch error along the axis
            offset = np.stack(
                [_fourier_series(self.roundness[s], phi), along * _fourier_series(self.pitch[s], phi)], axis=-1
            )
            centre[:, s] += offset[0]
            slopes[:, :, s] += offset[1:]
        degree = max(len(p) for p in self.profile)
        table = np.array([p + [0.0] * (degree - len(p)) for p in self.profile]).reshape(4, degree)
        radius = groove_radii(scene)
        if degree == 1:  # a constant offset is a change of radius, not of shape
            radius, table = radius - table[:, 0], np.zeros((4, 0))
        return Specimen(ball_radius, centre, slopes, radius, table)


def beyond_step(scene: Scene, station: Array) -> Mask:
    """Mask of the balls in the half of the nut that a lead offset shifts.

    The groove steps between two balls. A ball at the nut's centre counts to the half that is not shifted.

    Parameters
    ----------
    scene : Scene
        Gives the nut's position and the ball radius.
    station : (n,) Array
        Stations of the balls [m].

    Returns
    -------
    (n,) Mask
        True beyond the step.
    """
    return np.asarray(station - scene.nut.position > AT_CENTRE * scene.balls.radius)


def _shifted_centres(scene: Scene, station: Array) -> Array:
    """Groove centres ``(n, 4, 2)`` [m] of balls at stations (n,) [m]: nominal but for the nut's lead offset.

    A helical groove that is shifted along the axis is shifted by cos(alpha) of it across the track, and along the track,
    where it is the same everywhere.
    """
    centre = np.empty((station.size, 4, 2))
    centre[:] = nominal_groove_centres(scene)
    if scene.errors.lead_offset != 0.0:
        centre[beyond_step(scene, station), 2:, 1] += scene.errors.lead_offset * cos(lead_angle(scene.track))
    return centre


def draw_errors(scene: Scene, member: int = 0) -> Drawn:
    """Draw the errors of one specimen of a scene.

    The same seed and number give the same screw. Draws are taken in the order: ball radii; then for each flank SL, SR,
    NL, NR pitch, roundness, profile.

    Parameters
    ----------
    scene : Scene
        Gives errors and seed.
    member : int, default 0
        Number of the specimen.

    Returns
    -------
    Drawn
        Its error functions.
    """
    rng = np.random.default_rng([scene.errors.seed, member]) if scene.errors.random else _UNUSED
    radii = draw_ball_radii(scene, rng)
    sides = [scene.errors.side(name) for name in SIDES]
    terms = [(_draw_terms(e.pitch, rng), _draw_terms(e.roundness, rng), _draw_profile(e, rng)) for e in sides]
    pitch, roundness, profile = zip(*terms, strict=True)
    return Drawn(radii, pitch, roundness, profile)


def specimen(scene: Scene, layout: BallLayout, member: int = 0) -> Specimen:
    """Errors of one specimen of a scene at its balls; see `draw_errors`.

    Parameters
    ----------
    scene : Scene
        Gives errors and seed.
    layout : BallLayout
        Places of the balls.
    member : int, default 0
        Number of the specimen.

    Returns
    -------
    Specimen
        Errors at the balls.

    Examples
    --------
    >>> import rollbench
    >>> from rollbench.meshes.helix import ball_layout
    >>> scene = rollbench.read("lin-case1")
    >>> specimen(scene, ball_layout(scene)).ball_radius[:2].tolist()
    [0.002778, 0.002778]
    """
    return _at_balls(scene, layout, draw_errors(scene, member))


def _at_balls(scene: Scene, layout: BallLayout, drawn: Drawn) -> Specimen:
    return drawn.at(scene, layout.azimuth, layout.azimuth - scene.nut.azimuth, layout.z, drawn.ball_radius)


@dataclass(frozen=True)
class Specimens:
    """Errors of m samples with equal groove radii."""

    #: Ball radii ``(m, n)`` [m].
    ball_radius: Array
    #: Groove centres ``(m, n, 4, 2)`` [m], or ``(1, n, 4, 2)`` where they are the same in all specimens.
    centre: Array
    #: Groove radii ``(4,)`` [m].
    radius: Array


def alike_in_shape(scene: Scene) -> bool:
    """Return whether all samples of a scene have exact arcs of equal radii as grooves; see `specimens`.

    Parameters
    ----------
    scene : Scene
        Gives the errors.

    Returns
    -------
    bool
        False where profile errors of higher than constant degree, or random ones, occur.
    """
    sides = [scene.errors.side(name) for name in SIDES]
    return not any(len(e.profile) > 1 or any(s > 0.0 for s in e.profile_sigma) for e in sides)


def specimens(scene: Scene, layout: BallLayout, first: int, count: int) -> Specimens:
    """Errors of several specimens of a scene that is `alike_in_shape`.

    Parameters
    ----------
    scene, layout
        As for `specimen`.
    first, count : int
        Number of the first specimen, and how many.

    Returns
    -------
    Specimens
        Their errors at the balls.
    """
    drawn = [draw_errors(scene, member) for member in range(first, first + count)]
    shared = all((one.pitch, one.roundness) == (drawn[0].pitch, drawn[0].roundness) for one in drawn)
    places = [_at_balls(scene, layout, one) for one in (drawn[:1] if shared else drawn)]
    return Specimens(np.stack([one.ball_radius for one in drawn]), np.stack([x.centre for x in places]), places[0].radius)


def with_draws(scene: Scene, member: int = 0) -> Scene:
    """Scene with the errors of one specimen written into it, so that nothing is random any more.

    Parameters
    ----------
    scene : Scene
        Gives errors and seed.
    member : int, default 0
        Number of the specimen, see `draw_errors`.

    Returns
    -------
    Scene
        The new scene; the same one where nothing is random.
    """
    if not scene.errors.random:
        return scene
    drawn, errors = draw_errors(scene, member), scene.errors
    nominal = scene.balls.radius + errors.balls.oversize
    listed = tuple((i, float(radius - nominal)) for i, radius in enumerate(drawn.ball_radius, 1))
    SL, SR, NL, NR = (
        replace(
            errors.side(name),
            pitch=tuple(FourierTerm(*term) for term in drawn.pitch[s]),
            roundness=tuple(FourierTerm(*term) for term in drawn.roundness[s]),
            profile=tuple(drawn.profile[s]),
            profile_sigma=(),
        )
        for s, name in enumerate(SIDES)
    )
    balls = replace(errors.balls, listed=listed, sigma=0.0)
    return replace(scene, errors=replace(errors, balls=balls, SL=SL, SR=SR, NL=NL, NR=NR))


def without_draws(scene: Scene) -> Scene:
    """Scene without its random errors: all standard deviations 0.

    Parameters
    ----------
    scene : Scene
        Gives the errors.

    Returns
    -------
    Scene
        The new scene.
    """

    def certain(terms: tuple[FourierTerm, ...]) -> tuple[FourierTerm, ...]:
        return tuple(replace(term, sigma=0.0) for term in terms)

    errors = scene.errors
    sides: dict[str, Any] = {
        name: replace(e, profile_sigma=(), pitch=certain(e.pitch), roundness=certain(e.roundness))
        for name, e in ((name, errors.side(name)) for name in SIDES)
    }
    balls = replace(errors.balls, sigma=0.0, distribution="normal")
    return replace(scene, errors=replace(errors, balls=balls, **sides))
