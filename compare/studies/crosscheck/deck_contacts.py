"""Where the contacts of a deck are expected, how large, and which faces of balls and grooves belong to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import directions
from rollbench.meshes.exchange.deck import outer_faces
from rollbench.meshes.exchange.whole_bodies import WholeBody, grid
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.sockets import SocketSize, socket_coordinates

#: Half axes of the refined zone, the slave's and the master's faces over those of the expected ellipse; the faces' zones
#: are wider by some elements, too.
FINE, SLAVE, MASTER = 1.1, (1.6, 2.0), (2.0, 4.0)
#: Least load that a zone is sized for, over the mean load.
LEAST = 0.1


@dataclass(frozen=True)
class Place:
    """An expected contact: ball (from 0), side, place (azimuth [rad], z [m], side), half axes across and along [m]."""

    ball: int
    side: int
    at: tuple[float, float, int]
    half: tuple[float, float]


def half_axes(scene: Scene, side: int) -> tuple[float, float]:
    """Half axes across and along the groove of the contact ellipse at 1 N [m/N^(1/3)]: Hertz on the nominal geometry.

    The long one lies across the groove, where ball and groove conform.
    """
    track, balls = scene.track, scene.balls
    part = scene.screw if side < 2 else scene.nut
    sign = 1.0 if side < 2 else -1.0
    along = np.cos(track.contact_angle) * np.cos(lead_angle(track)) ** 2
    along /= track.pitch_radius - sign * balls.radius * np.cos(track.contact_angle)
    one, two = balls.material, part.material
    modulus = contact_modulus(one.youngs_modulus, one.poissons_ratio, two.youngs_modulus, two.poissons_ratio)
    across = 1.0 / balls.radius - 1.0 / part.groove_radius
    found = hertz_constants(np.array(across), np.array(1.0 / balls.radius + sign * along), modulus)
    return float(found.C_a), float(found.C_b)


def places_of(scene: Scene, load: Array, sides: tuple[int, ...]) -> tuple[list[Place], float]:
    """Expected contacts on ``sides``, and the short half axis [m] of a contact of mean load on the screw."""
    layout, mean = ball_layout(scene), float(load[load > 0.0].mean())
    unit = {s: half_axes(scene, s) for s in sides}
    places = []
    for i in range(scene.ball_count):
        for s in sides:
            root = float(np.cbrt(max(load[i, s], LEAST * mean)))
            at = (float(layout.azimuth[i]), float(layout.z[i]), s)
            places.append(Place(i, s, at, (unit[s][0] * root, unit[s][1] * root)))
    return places, unit[sides[0]][1] * float(np.cbrt(mean))


def ball_faces(place: Place) -> str:
    """Name of the ball's faces at a contact."""
    return f"BALL{place.ball + 1}_{SIDES[place.side]}"


def groove_faces(place: Place) -> str:
    """Name of the groove's faces at a contact."""
    return f"{'SCREW' if place.side < 2 else 'NUT'}_{SIDES[place.side]}_{place.ball + 1}"


def _zone(place: Place, fine: float, wide: tuple[float, float]) -> tuple[float, float]:
    """Half axes [m] of the faces of a contact."""
    across, along = (wide[0] * x + wide[1] * fine for x in place.half)
    return across, along


def fine_zone(place: Place, fine: float) -> Array:
    """Points ``(k, 2)`` [m] across and along that fill the refined zone of a contact."""
    return grid((FINE * place.half[0], FINE * place.half[1]), 0.7 * fine)


def flank_faces(m: GrooveMap, mesh: WholeBody, place: Place, fine: float) -> Index:
    """Faces of a flank within the master's zone of a contact."""
    flank = mesh.named[f"flank {SIDES[place.side]}"]
    x, radius = mesh.points[flank], float(m.radius[place.side])
    xi = socket_coordinates(
        m, SocketSize(1.0, radius, 1.0), place.at, np.arctan2(x[:, 1], x[:, 0]), x[:, 2], np.hypot(x[:, 0], x[:, 1])
    )
    half = _zone(place, fine, MASTER)
    inside = (radius * xi[:, 0] / half[0]) ** 2 + (m.R * xi[:, 2] / half[1]) ** 2 <= 1.0
    return _faces_within(mesh, flank[inside])


def sphere_faces(m: GrooveMap, mesh: WholeBody, place: Place, radius: float, fine: float) -> Index:
    """Faces of a ball of a radius [m], meshed in the frame of azimuth 0, within the slave's zone of a contact."""
    (n, t1, t2), sphere, half = directions(m, place.side), mesh.named["sphere"], _zone(place, fine, SLAVE)
    x = mesh.points[sphere]
    height = np.where(x @ n > 0.0, x @ n, 1e-9 * radius)  # nodes behind are far outside
    across, along = radius * (x @ t1) / height, radius * (x @ t2) / height
    inside = (x @ n > 0.0) & ((across / half[0]) ** 2 + (along / half[1]) ** 2 <= 1.0)
    return _faces_within(mesh, sphere[inside])


def _faces_within(mesh: WholeBody, nodes: Index) -> Index:
    """Corners of the outer faces all of whose corners are among ``nodes``, those of a half's cut left out.

    Raises ValueError where there is none.
    """
    faces = outer_faces(mesh.cells)
    within = faces[np.isin(faces, nodes).all(axis=1) & ~np.isin(faces, mesh.named.get("cut", [])).all(axis=1)]
    if not len(within):
        raise ValueError(
            "no face of the mesh lies within an expected contact: take more elements across it, or less growth"
        )
    return within
