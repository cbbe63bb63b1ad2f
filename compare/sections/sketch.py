"""The sketch of a scene: its parts, how they are held, and what acts on them."""

from __future__ import annotations

from math import degrees

from rollbench.meshes.parts import Scene
from rollbench.reports.content import Sketch


def sketch_of(scene: Scene, name: str, title: str) -> Sketch:
    """Sketch of a scene with the inputs that the drawing does not show."""
    return Sketch(name, title, scene, inputs(scene))


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
        words.append(f"ball radii {errors.oversize * 1e6:+.3g} um")
    if scene.errors.lead_offset:
        words.append(f"lead offset {scene.errors.lead_offset * 1e6:.3g} um")
    return f"{', '.join(words)}."


def _conformity(scene: Scene) -> str:
    found = [f"{body.groove_radius / (2.0 * scene.balls.radius):.3g}" for body in (scene.screw, scene.nut)]
    return " and ".join(dict.fromkeys(found))
