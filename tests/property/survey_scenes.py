"""Scenes that the 3D reference must take: Lin's case 1 with one thing changed, and other sizes, by name."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from rollbench.compare.models.study import with_conformity
from rollbench.compare.scenes import catalogue
from rollbench.hifi.meshing.settings import hertz_contacts_under_unit_force
from rollbench.meshes.parts import Load, Scene, Support

CASE = catalogue.scene("lin-case1")


def axial(scene: Scene, force: float) -> Scene:
    """The scene under an axial force [N] alone."""
    return replace(scene, loads=(Load(0.0, (0.0, 0.0, force)),))


def pressed(scene: Scene, pressure: float) -> Scene:
    """The scene under the axial force whose even share gives a contact's pole the pressure [Pa]."""
    pole = max(unit.pole_pressure for unit in hertz_contacts_under_unit_force(scene))
    return axial(scene, (pressure / pole) ** 3 * scene.ball_count * float(np.sin(scene.track.contact_angle)))


def even(count: int, turns: float) -> tuple[float, ...]:
    """Azimuths [rad] of balls spread evenly over some turns."""
    return tuple(float(a) for a in 2.0 * np.pi * turns * ((np.arange(count) + 0.5) / count - 0.5))


def with_track(scene: Scene, lead: float, count: int, turns: float, length: float, **track: int) -> Scene:
    """The scene with another lead [m], balls of one start, and length of nut [m]."""
    balls, nut = replace(scene.balls, azimuths=even(count, turns)), replace(scene.nut, length=length)
    return replace(scene, track=replace(scene.track, lead=lead, **track), nut=nut, balls=balls)


def conformities() -> Iterator[tuple[str, Scene]]:
    """Groove radius over ball diameter at 2.5 GPa. At 0.51 the ellipse ends beyond case 1's lands: higher lands there."""
    for conformity in (0.51, 0.515, 0.52, 0.525, 0.53, 0.55, 0.58):
        scene = with_conformity(CASE, conformity)
        if conformity < 0.515:
            scene = replace(scene, screw=replace(scene.screw, outer_diameter=32.9e-3))
        yield f"conformity {conformity}", pressed(scene, 2.5e9)


def survey() -> Iterator[tuple[str, Scene]]:
    """All scenes of the survey."""
    yield from conformities()
    yield "60 kN", axial(CASE, 60e3)
    for angle in (20, 30, 60, 70):
        yield f"contact angle {angle}", replace(CASE, track=replace(CASE.track, contact_angle=float(np.radians(angle))))
    yield "3 balls", axial(replace(CASE, balls=replace(CASE.balls, azimuths=even(3, 0.8))), 500.0)
    yield "120 balls", axial(with_track(CASE, 10e-3, 120, 7.5, 92e-3), 20e3)
    yield "lead 5", catalogue.scene("unseen-16x5")
    for lead, *nut in ((6.2, 32, 2.0, 30e-3), (10, 32, 2.0, 36e-3), (40, 24, 1.5, 76e-3)):
        yield f"lead {lead}", with_track(CASE, 1e-3 * lead, *nut)
    yield "two starts", with_track(CASE, 20e-3, 16, 1.0, 36e-3, starts=2)
    unseen = (f"unseen-{name}" for name in ("25x5", "32x10", "40x10", "63x20", "four-point"))
    for name in ("bearing-9", "bearing-9-preload", *unseen):
        yield name, catalogue.scene(name)


def tipped() -> Scene:
    """Case 1 with a station beside the nut displaced by 1 mm: most of what its contacts carry comes from that."""
    return replace(CASE, supports=(*CASE.supports, Support(0.5, (("ux", 1e-3), ("uy", 0.0)))))


def shortened(scene: Scene) -> Scene:
    """The same sockets with two neighbouring balls in a nut as short as it may be: quick to mesh."""
    track, r = scene.track, scene.balls.radius
    azimuths = sorted(scene.balls.azimuths, key=lambda a: abs(a - track.phase))[:2]
    scene = replace(scene, balls=replace(scene.balls, azimuths=tuple(azimuths)))
    if track.lead == 0.0:
        return scene
    spread = track.lead * max(abs(a - track.phase) for a in azimuths) / (2.0 * np.pi)
    return replace(scene, nut=replace(scene.nut, length=2.0 * spread + 7.0 * r), solid=replace(scene.solid, shaft=2.0 * r))
