"""Preload of one nut by a force, turned into the oversize of its balls that gives it."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

from rollbench.compare.measure import error_percent
from rollbench.compare.scenes.quantity import ShareOfRating
from rollbench.compare.scenes.schema import PreloadKeys
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Scene


def oversize_for(scene: Scene, force: float) -> float:
    """Oversize of the ball radius [m] at which screw and nut, both rigid, press on each pair of flanks with ``force`` [N]
    along the axis, without load.

    All four contacts of a ball carry Q = force / (n sin beta cos alpha); along a diagonal, both approaches together make up
    for twice the oversize e: 2 e = (C_S + C_N) Q^(2/3), with the Hertz constants C [m N^(-2/3)] at the nominal contact
    angle. Valid where e is small against the distance of ball and groove centre, so that the angle hardly changes (a
    per cent of the force at 7 um and 0.5 mm).
    """
    from rollbench.lowfi.statics.contacts import nominal_hertz

    beta, alpha = scene.track.contact_angle, lead_angle(scene.track)
    each = force / (scene.ball_count * sin(beta) * cos(alpha))
    constants = nominal_hertz(scene).C
    pair = float(constants[0] + constants[3])
    return float(0.5 * pair * each ** (2.0 / 3.0))


def force_of(scene: Scene, given: float | ShareOfRating) -> tuple[float, str]:
    """Preload force [N], and in words where it comes from."""
    if not isinstance(given, ShareOfRating):
        return given, ""
    from rollbench.lowfi.rating.life import rating

    C = rating(scene)
    percent = float(error_percent(given.share * C, 0.0, C))
    return given.share * C, f" ({percent:.3g} % of the dynamic load rating as computed, {C:.4g} N)"


def preloaded(scene: Scene, keys: PreloadKeys | None) -> Scene:
    """The scene with its preload as an oversize, and what is idealised by it among the assumptions."""
    if keys is None or keys.lead_offset is not None:
        return scene
    size, assumed = keys.oversize or 0.0, scene.assumed
    if keys.force is not None:
        force, of = force_of(scene, keys.force)
        size = oversize_for(scene, force)
        assumed += (
            f"The preload of {force:g} N{of} was turned into an oversize of {1e6 * size:.3g} um in ball radius, by Hertz "
            "contacts between a rigid screw and a rigid nut; elastic ones give way, so that less than it is left.",
        )
    balls = replace(scene.errors.balls, oversize=size)
    return replace(scene, errors=replace(scene.errors, balls=balls), assumed=assumed)
