"""Balls of a linear bearing, a ball screw and a ring as `hifi.rolling.balls` takes them.

Order of a ball's grooves and senses of their directions are the caller's: contact angles and directions come in, loads are
solved here or given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.rolling.kinematics import Ball, Meeting, Rolling, Touch, Track, meeting
from rollbench.meshes.arrays import Array
from rollbench.meshes.roots import brentq


@dataclass(frozen=True)
class Layout:
    """Where balls and grooves are: track seen from every ball, frames ``(N, 3, 3)``, plane of the section in a ball's axes
    ``(2, 3)``, ball and groove radius [m], relative radii [m] along and across every groove ``(k, 2)``, speeds of the
    grooves' bodies ``(k,)`` and nominal speed of the balls, meetings of neighbours."""

    track: Track
    frames: Array
    section: Array
    radius: float
    groove_radius: float
    radii: Array
    ride: Array
    orbit: float
    meetings: tuple[Meeting, ...]


@dataclass(frozen=True)
class Material:
    """Young's modulus [Pa], Poisson's ratio, coefficients of friction at grooves and between balls."""

    young: float
    poisson: float
    mu: float
    mu_balls: float


def scene_of(layout: Layout, material: Material, normals: Array, loads: Array) -> Rolling:
    """Scene of contact directions in the section ``(N, k, 2)`` and loads ``(N, k)`` [N]."""
    balls = []
    for frame, n, force in zip(layout.frames, normals, loads, strict=True):
        touches = [
            Touch(
                n[k] @ layout.section,
                float(force[k]),
                (layout.radii[k, 0], layout.radii[k, 1]),
                float(layout.ride[k]),
                _bottom(n, layout.ride, k) @ layout.section,
            )
            for k in range(force.size)
        ]
        balls.append(Ball(frame, tuple(touches)))
    m = material
    return Rolling(
        layout.track, layout.radius, m.young, m.poisson, m.mu, m.mu_balls, layout.orbit, tuple(balls), layout.meetings
    )


def _bottom(normals: Array, ride: Array, k: int) -> Array:
    """Direction ``(2,)`` to the bottom of groove k: between the contacts with both arcs of its body."""
    bottom = normals[ride == ride[k]].sum(axis=0)
    return np.asarray(bottom / np.linalg.norm(bottom))


def hertz_constants(layout: Layout, material: Material) -> Array:
    """C ``(k,)`` [m/N^(2/3)] of every groove."""
    return np.array([hertz(1.0, a, b, material.young, material.poisson).approach for a, b in layout.radii])


# --- layouts


def linear_layout(
    radius: float, groove_radius: float, count: int, moving: ArrayLike, speed: float, touch: ArrayLike
) -> Layout:
    """``count`` balls of a straight track along z, sections in x and y; moving ``(k,)``: whether a groove moves at
    ``speed`` [m/s]; touch ``(count - 1,)``: which neighbours are in reach."""
    track = Track(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    frames = np.repeat(np.eye(3)[None], count, axis=0)
    along = np.array([0.0, 0.0, 1.0])
    pairs = tuple(
        meeting(k, k + 1, (frames[k], frames[k + 1]), along, track, radius)
        for k in np.flatnonzero(np.asarray(touch)).tolist()
    )
    radii = np.tile([radius, 1.0 / (1.0 / radius - 1.0 / groove_radius)], (np.size(moving), 1))
    return Layout(
        track, frames, np.eye(3)[:2], radius, groove_radius, radii, speed * np.asarray(moving, float), 0.5 * speed, pairs
    )


def along_radius(radius: float, pitch_radius: float, lead_angle: float, outward: float) -> float:
    """Relative radius [m] of ball and groove along a helix or ring; outward: radial part of the contact's direction."""
    return float(1.0 / (1.0 / radius - outward * np.cos(lead_angle) ** 2 / (pitch_radius + outward * radius)))


def screw_layout(
    radius: float,
    groove_radius: float,
    pitch_radius: float,
    lead: float,
    contact_angle: float,
    outward: Array,
    ride: Array,
    count: int,
) -> Layout:
    """``count`` balls in touch along a helix (lead [m], negative: left-hand), in axes x3, y3, z3 of Lin 3.4.1.

    outward ``(k,)``: -1 for the screw's grooves, 1 for the nut's; ride ``(k,)``: speeds [rad/s] of their bodies.
    """
    rise = lead / (2.0 * np.pi)
    length, angle = float(np.hypot(pitch_radius, rise)), float(np.arctan2(rise, pitch_radius))
    track = Track(np.array([0.0, np.sin(angle), np.cos(angle)]), np.array([0.0, length, 0.0]))

    def excess(step: float) -> float:
        return float(np.hypot(2.0 * pitch_radius * np.sin(0.5 * step), rise * step)) - 2.0 * radius

    step = float(brentq(excess, 0.0, 0.5 * np.pi, xtol=1e-15)) if count > 1 else 0.0
    azimuth = (np.arange(count) - 0.5 * (count - 1)) * step
    frames = np.array([_frame(phi, angle) for phi in azimuth])
    centres = np.stack([pitch_radius * np.cos(azimuth), pitch_radius * np.sin(azimuth), rise * azimuth], axis=1)
    pairs = []
    for k in range(count - 1):
        line = centres[k + 1] - centres[k]
        line = line / np.linalg.norm(line)
        pairs.append(meeting(k, k + 1, (frames[k], frames[k + 1]), line, track, radius))
    across = 1.0 / (1.0 / radius - 1.0 / groove_radius)
    radii = np.array([[along_radius(radius, pitch_radius, angle, o * np.cos(contact_angle)), across] for o in outward])
    inner, outer = (float(np.mean(ride[outward == o])) for o in (-1.0, 1.0))
    lever = radius * np.cos(contact_angle) * np.cos(angle) / length
    orbit = 0.5 * (outer + inner + lever * (outer - inner))
    return Layout(track, frames, np.eye(3)[[0, 2]], radius, groove_radius, radii, ride, orbit, tuple(pairs))


def _frame(azimuth: float, angle: float) -> Array:
    """Rows x3, y3, z3 in fixed axes (Lin 3.62)."""
    c, s, ca, sa = np.cos(azimuth), np.sin(azimuth), np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-ca * s, ca * c, sa], [sa * s, -sa * c, ca]])


def ring_layout(
    radius: float, groove_radius: float, pitch_radius: float, contact_angle: float, outward: Array, ride: Array
) -> Layout:
    """One ball of a ring bearing: x along its axis, y radially outward, z along the path (Lin 3.2.1)."""
    track = Track(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, pitch_radius]))
    across = 1.0 / (1.0 / radius - 1.0 / groove_radius)
    radii = np.array([[along_radius(radius, pitch_radius, 0.0, o * np.cos(contact_angle)), across] for o in outward])
    inner, outer = (float(np.mean(ride[outward == o])) for o in (-1.0, 1.0))
    orbit = 0.5 * (outer + inner + radius * np.cos(contact_angle) / pitch_radius * (outer - inner))
    return Layout(track, np.eye(3)[None], np.eye(3)[:2], radius, groove_radius, radii, ride, orbit, ())
