"""The sketch of a scene: its parts, how they are held, and what acts on them."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions
from rollbench.reports.records import Sketch

#: Newton and micrometre by what they are written in.
KILO, MICRO = 1e3, 1e-6


def sketch_of(scene: Scene, name: str, title: str) -> Sketch:
    """Sketch of a scene, seen along y with z to the right and x upwards."""
    nut, layout = scene.nut, ball_layout(scene)
    low, high = nut.position - nut.length / 2.0, nut.position + nut.length / 2.0
    held, outside = _held(scene, low, high)
    flange = None
    if nut.flange:
        start, end = sorted(nut.flange.stations(low, high)[:2])
        flange = nut.flange.diameter, start, end
    return Sketch(
        name=name,
        title=title,
        screw_length=scene.screw.length,
        screw_diameter=scene.screw.outer_diameter,
        bore=scene.screw.bore,
        nut=(low, high),
        nut_diameter=nut.outer_diameter,
        pitch_diameter=2.0 * scene.track.pitch_radius,
        ball_radius=scene.balls.radius,
        balls=[(float(z), float(x), float(y)) for x, y, z in layout.centre],
        supports=[(one.at, tuple(_support(one.fixed))) for one in scene.supports],
        loads=[(one.at, (one.force[2], one.force[0]), _load(one.force, one.moment)) for one in scene.loads],
        held=held,
        held_outside=outside,
        flange=flange,
        shaft="screw" if scene.track.lead else "inner ring",
        around="nut" if scene.track.lead else "outer ring",
        caption=inputs(scene),
    )


def inputs(scene: Scene) -> str:
    """The inputs that the drawing does not show, in words."""
    track, balls, errors = scene.track, scene.balls, scene.errors.balls
    lead = f"lead {1e3 * track.lead:.4g} mm" + (f", {track.starts} starts" if track.starts > 1 else "")
    words = [
        f"{scene.ball_count} balls of {2e3 * balls.radius:.5g} mm",
        lead if track.lead else "ball bearing",
        f"pitch diameter {2e3 * track.pitch_radius:.5g} mm",
        f"contact angle {degrees(track.contact_angle):.4g} deg",
        f"conformity {_conformity(scene)}",
    ]
    if errors.oversize:
        words.append(f"ball radii {errors.oversize / MICRO:+.3g} um")
    if scene.errors.lead_offset:
        words.append(f"lead offset {scene.errors.lead_offset / MICRO:.3g} um")
    return f"{', '.join(words)}."


def _conformity(scene: Scene) -> str:
    found = [f"{body.groove_radius / (2.0 * scene.balls.radius):.3g}" for body in (scene.screw, scene.nut)]
    return " and ".join(dict.fromkeys(found))


def _held(scene: Scene, low: float, high: float) -> tuple[list[tuple[float, float, float]], bool]:
    """Rings (station, inner and outer radius) by which the nut is held, and whether it is held by its outer surface."""
    solid = dimensions(scene)
    if solid.nut_held.startswith("outer surface"):
        return [], True
    if scene.nut.flange and solid.nut_held.startswith("flange face"):
        return [(scene.nut.flange.stations(low, high)[1], *solid.held_radii)], False
    faces = {"left": [low], "right": [high], "both": [low, high]}[solid.nut_held.split()[0]]
    return [(face, *solid.held_radii) for face in faces], False


def _support(fixed: tuple[tuple[str, float], ...]) -> Iterator[str]:
    """Freedoms that a support holds, and its prescribed displacements."""
    held = " ".join(freedom for freedom, value in fixed if value == 0.0)
    if held:
        yield f"holds {held}"
    for freedom, value in fixed:
        if value:
            turned = freedom.startswith("r")
            yield f"{freedom} = {1e3 * value:.4g} mrad" if turned else f"{freedom} = {value / MICRO:.4g} µm"


def _load(force: tuple[float, float, float], moment: tuple[float, float, float]) -> str:
    """The components of a load that are there."""
    forces = [
        f"F{axis} {value / KILO:.4g} kN" if abs(value) >= KILO else f"F{axis} {value:.4g} N"
        for axis, value in zip("xyz", force, strict=True)
        if value
    ]
    return ", ".join([*forces, *(f"M{axis} {value:.4g} N m" for axis, value in zip("xyz", moment, strict=True) if value)])
