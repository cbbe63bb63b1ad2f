"""Geometric errors of one screw: from their description to the numbers of one (drawn) specimen (Lin 2.27, 4.1, 4.3)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import zip_longest
from math import cos
from typing import Any, cast

import numpy as np

from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.helix import BallLayout, groove_radii, lead_angle, nominal_groove_centres
from rollbench.meshes.parts import SIDES, FourierTerm, Scene, SideErrors

#: Distance from the nut's centre, over the ball's radius, up to which a ball stands at it.
AT_CENTRE = 1e-6
#: In place of a generator where nothing is random: `numpy.random` is not loaded there.
_UNUSED = cast("np.random.Generator", None)


@dataclass(frozen=True)
class Specimen:
    """One screw with all its errors drawn.

    ball_radius: shape ``(n,)`` [m].
    centre: groove centres in each ball's section frame, ``(n, 4, 2)`` [m], the last axis (x3, z3).
    centre_slopes: first and second derivatives of the centres by azimuth, ``(2, n, 4, 2)`` [m/rad, m/rad2].
    radius: groove radius of each side, ``(4,)`` [m].
    profile: polynomial coefficients of the inward offset in gamma, ``(4, d)`` [m]; ``d`` is 0 where no side has any.
    """

    ball_radius: Array
    centre: Array
    centre_slopes: Array
    radius: Array
    profile: Array


def _draw_terms(terms: tuple[FourierTerm, ...], rng: np.random.Generator) -> list[tuple[float, float, float]]:
    drawn = []
    for term in terms:
        a, b = rng.normal(0.0, term.sigma, 2) if term.sigma > 0.0 else (0.0, 0.0)
        drawn.append((term.harmonic, term.sin + a, term.cos + b))
    return drawn


def _series(drawn: list[tuple[float, float, float]], phi: Array) -> Array:
    """Value and first two derivatives of a Fourier series, shape ``(3, n)``."""
    total = np.zeros((3, phi.size))
    for h, a, b in drawn:
        s, c = np.sin(h * phi), np.cos(h * phi)
        total += np.stack([a * s + b * c, h * (a * c - b * s), -h * h * (a * s + b * c)])
    return total


def _profile(side: SideErrors, rng: np.random.Generator) -> list[float]:
    terms = zip_longest(side.profile, side.profile_sigma, fillvalue=0.0)
    return [float(m + (rng.normal(0.0, s) if s > 0.0 else 0.0)) for m, s in terms]


def draw_ball_radii(scene: Scene, rng: np.random.Generator, others: int | None = None) -> Array:
    """Ball radii [m], shape ``(n,)``: nominal + oversize + listed errors + one random draw each.

    others: radii of so many other balls, in the return of a screw, which no listed error can name.
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
    """All errors of one screw, drawn: ball_radius (n,) of the scene's balls [m]; of each side the terms (harmonic, sine,
    cosine [m]) of pitch and roundness and the coefficients of its profile [m]."""

    ball_radius: Array
    pitch: tuple[list[tuple[float, float, float]], ...]
    roundness: tuple[list[tuple[float, float, float]], ...]
    profile: tuple[list[float], ...]

    def at(self, scene: Scene, on_screw: Array, on_nut: Array, station: Array, ball_radius: Array) -> Specimen:
        """What balls of these radii (n,) [m] meet at azimuths (n,) [rad] on the screw and from the nut's axis of errors, at
        stations (n,) [m] along the axis."""
        n = ball_radius.size
        centre, slopes = _shifted_centres(scene, station), np.zeros((2, n, 4, 2))
        for s, name in enumerate(SIDES):
            if not self.pitch[s] and not self.roundness[s]:
                continue
            phi = on_nut if name.startswith("N") else on_screw
            along = cos(lead_angle(scene.track)) if scene.errors.side(name).pitch_along == "axis" else 1.0
            offset = np.stack([_series(self.roundness[s], phi), along * _series(self.pitch[s], phi)], axis=-1)
            centre[:, s] += offset[0]
            slopes[:, :, s] += offset[1:]
        degree = max(len(p) for p in self.profile)
        table = np.array([p + [0.0] * (degree - len(p)) for p in self.profile]).reshape(4, degree)
        radius = groove_radii(scene)
        if degree == 1:  # a constant offset is a change of radius, not of shape
            radius, table = radius - table[:, 0], np.zeros((4, 0))
        return Specimen(ball_radius, centre, slopes, radius, table)


def beyond_step(scene: Scene, station: Array) -> Mask:
    """Which balls at stations (n,) [m] are in the half of the nut that a lead offset shifts, ``(n,)``.

    The groove steps between two balls: one that stands at the nut's centre has the step beside it, and counts to the half
    that is not shifted.
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


def draw(scene: Scene, member: int = 0) -> Drawn:
    """Draw specimen number ``member`` of a scene: same seed and number, same screw.

    Draws are taken in the order ball radii; then per side SL, SR, NL, NR: pitch, roundness, profile.
    A uniform distribution has the stated standard deviation (half width sqrt(3) sigma).
    """
    rng = np.random.default_rng([scene.errors.seed, member]) if scene.errors.random else _UNUSED
    radii = draw_ball_radii(scene, rng)
    sides = [scene.errors.side(name) for name in SIDES]
    terms = [(_draw_terms(e.pitch, rng), _draw_terms(e.roundness, rng), _profile(e, rng)) for e in sides]
    pitch, roundness, profile = zip(*terms, strict=True)
    return Drawn(radii, pitch, roundness, profile)


def specimen(scene: Scene, layout: BallLayout, member: int = 0) -> Specimen:
    """Specimen number ``member`` of a scene (see ``draw``) at the places of its balls."""
    return _at_balls(scene, layout, draw(scene, member))


def _at_balls(scene: Scene, layout: BallLayout, drawn: Drawn) -> Specimen:
    return drawn.at(scene, layout.azimuth, layout.azimuth - scene.nut.azimuth, layout.z, drawn.ball_radius)


@dataclass(frozen=True)
class Specimens:
    """Many screws whose grooves have the same radii: ball_radius (m, n) [m]; centre (m, n, 4, 2) [m] of the grooves, the
    first axis one long where all are the same; radius (4,) [m]. Axes as in ``Specimen``."""

    ball_radius: Array
    centre: Array
    radius: Array


def alike_in_shape(scene: Scene) -> bool:
    """Whether the specimens of a scene have grooves of the same radii, all of them exact arcs: see ``specimens``."""
    sides = [scene.errors.side(name) for name in SIDES]
    return not any(len(e.profile) > 1 or any(s > 0.0 for s in e.profile_sigma) for e in sides)


def specimens(scene: Scene, layout: BallLayout, first: int, count: int) -> Specimens:
    """Specimens number ``first`` and on of a scene that is ``alike_in_shape``."""
    drawn = [draw(scene, member) for member in range(first, first + count)]
    shared = all((one.pitch, one.roundness) == (drawn[0].pitch, drawn[0].roundness) for one in drawn)
    places = [_at_balls(scene, layout, one) for one in (drawn[:1] if shared else drawn)]
    return Specimens(np.stack([one.ball_radius for one in drawn]), np.stack([x.centre for x in places]), places[0].radius)


def with_draws(scene: Scene, member: int = 0) -> Scene:
    """The scene with the errors of specimen number ``member`` (see ``draw``) written into it, and nothing random left."""
    if not scene.errors.random:
        return scene
    drawn, errors = draw(scene, member), scene.errors
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
    """The scene without its random errors."""

    def certain(terms: tuple[FourierTerm, ...]) -> tuple[FourierTerm, ...]:
        return tuple(replace(term, sigma=0.0) for term in terms)

    errors = scene.errors
    sides: dict[str, Any] = {
        name: replace(e, profile_sigma=(), pitch=certain(e.pitch), roundness=certain(e.roundness))
        for name, e in ((name, errors.side(name)) for name in SIDES)
    }
    balls = replace(errors.balls, sigma=0.0, distribution="normal")
    return replace(scene, errors=replace(errors, balls=balls, **sides))
