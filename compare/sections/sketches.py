"""Sketch of a scene with its dimensions."""

from __future__ import annotations

from math import degrees

from rollbench.meshes.parts import Scene
from rollbench.reports.content import Sketch


def sketch_scene(scene: Scene, name: str, title: str) -> Sketch:
    """Return the sketch of a scene, with a caption on the inputs that the drawing does not show.

    ``name``: file name of the sketch. ``title``: title of the sketch.
    """
    return Sketch(name, title, scene, scene_inputs_sentence(scene))


def scene_inputs_sentence(scene: Scene) -> str:
    """Return a sentence on the inputs that a sketch does not show: balls, lead, contact angle, conformity, errors."""
    track, balls, errors = scene.track, scene.balls, scene.errors.balls
    lead = f"lead {1e3 * track.lead:.4g} mm" + (f", {track.starts} starts" if track.starts > 1 else "")
    words = [
        f"{scene.ball_count} balls of {2e3 * balls.radius:.5g} mm diameter",
        *([lead] if track.lead else []),
        f"pitch diameter {2e3 * track.pitch_radius:.5g} mm",
        f"contact angle {degrees(track.contact_angle):.4g} deg",
        f"groove radius/ball diameter {_conformity_text(scene)}",
    ]
    if errors.oversize:
        words.append(f"ball radii {errors.oversize * 1e6:+.3g} um from nominal")
    if scene.errors.lead_offset:
        words.append(f"lead offset {scene.errors.lead_offset * 1e6:.3g} um")
    return f"{', '.join(words)}."


def _conformity_text(scene: Scene) -> str:
    """Return the conformities (groove radius over ball diameter) of screw and nut, or of both rings, as text.

    They are one number if both are equal.
    """
    screw, nut = (f"{body.groove_radius / (2.0 * scene.balls.radius):.3g}" for body in (scene.screw, scene.nut))
    names = ("in the screw", "in the nut") if scene.track.lead else ("in the inner ring", "in the outer ring")
    return screw if screw == nut else f"{screw} {names[0]} and {nut} {names[1]}"
