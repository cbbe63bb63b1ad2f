"""Geometric errors of one screw: from their description to the numbers of one (drawn) specimen (Lin 2.27, 4.1, 4.3)."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos

import numpy as np
from numpy.typing import NDArray

from meshes.helix import BallLayout, groove_radii, lead_angle, nominal_groove_centres
from meshes.parts import SIDES, FourierTerm, Scene, SideErrors

Array = NDArray[np.float64]


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
    size = max(len(side.profile), len(side.profile_sigma))
    mean = np.pad(np.array(side.profile), (0, size - len(side.profile)))
    sigma = np.pad(np.array(side.profile_sigma), (0, size - len(side.profile_sigma)))
    return [float(m + (rng.normal(0.0, s) if s > 0.0 else 0.0)) for m, s in zip(mean, sigma, strict=True)]


def draw_ball_radii(scene: Scene, rng: np.random.Generator) -> Array:
    """Ball radii [m], shape ``(n,)``: nominal + oversize + listed errors + one random draw each."""
    errors = scene.errors.balls
    radius = np.full(scene.ball_count, scene.balls.radius + errors.oversize)
    for number, error in errors.listed:
        radius[number - 1] += error
    if errors.sigma > 0.0:
        if errors.distribution == "normal":
            radius += rng.normal(0.0, errors.sigma, radius.size)
        else:
            half = np.sqrt(3.0) * errors.sigma
            radius += rng.uniform(-half, half, radius.size)
    return radius


def specimen(scene: Scene, layout: BallLayout, member: int = 0) -> Specimen:
    """Draw specimen number ``member`` of a scene: same seed and number, same screw.

    Draws are taken in the order ball radii; then per side SL, SR, NL, NR: pitch, roundness, profile.
    A uniform distribution has the stated standard deviation (half width sqrt(3) sigma).
    """
    rng = np.random.default_rng([scene.errors.seed, member])
    radii = draw_ball_radii(scene, rng)
    n = radii.size
    centre = np.broadcast_to(nominal_groove_centres(scene), (n, 4, 2)).copy()
    slopes = np.zeros((2, n, 4, 2))
    profiles: list[list[float]] = []
    for s, name in enumerate(SIDES):
        side = scene.errors.side(name)
        phi = layout.azimuth - (scene.nut.azimuth if name.startswith("N") else 0.0)
        along = cos(lead_angle(scene.track)) if side.pitch_along == "axis" else 1.0
        pitch = along * _series(_draw_terms(side.pitch, rng), phi)
        roundness = _series(_draw_terms(side.roundness, rng), phi)
        offset = np.stack([roundness, pitch], axis=-1)
        centre[:, s] += offset[0]
        slopes[:, :, s] += offset[1:]
        profiles.append(_profile(side, rng))
    degree = max(len(p) for p in profiles)
    table = np.array([p + [0.0] * (degree - len(p)) for p in profiles]).reshape(4, degree)
    radius = groove_radii(scene)
    if degree == 1:  # a constant offset is a change of radius, not of shape
        radius, table = radius - table[:, 0], np.zeros((4, 0))
    return Specimen(radii, centre, slopes, radius, table)
