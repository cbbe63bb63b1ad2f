"""A problem of the benchmark as plain numbers in SI units, for programs that read no scene (``schema.json``)."""

from __future__ import annotations

from typing import Any

from rollbench.comparison.errors import Refusal
from rollbench.comparison.wings.benchmark.problems import NAME, Problem
from rollbench.hifi.several_sets import bodies_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Material, Scene, SideErrors
from rollbench.meshes.solid import dimensions

UNITS = {"length": "m", "angle": "rad", "force": "N", "moment": "N m", "stress": "Pa"}


def described(one: Problem) -> dict[str, Any]:
    """A problem as JSON-ready numbers. Raises Refusal for one whose errors this form does not hold."""
    scene = one.described
    sets = placed(one)
    number, bodies = 1, []
    for name, parts, offset, ends in sets:
        bodies.append(_set(one, name, parts, offset, ends, number))
        number += parts.ball_count
    first = sets[0][1]
    bore = first.screw.bore / 2.0 or dimensions(first).hole
    return {
        "benchmark": NAME,
        "problem": one.name,
        "title": scene.title,
        "shows": one.shows,
        "units": UNITS,
        "shaft": {
            "z": [0.0, scene.screw.length] if len(sets) > 1 or _to_the_ends(first) else list(dimensions(first).ends(first)),
            "land_radius": scene.screw.outer_diameter / 2.0,
            "bore_radius": bore,
            "bore_moves_as_rigid_body": dimensions(first).screw_held == "bore",
            "material": _material(scene.screw.material),
        },
        "sets": bodies,
        "supports": [{"z": s.at, "motion": dict(s.fixed)} for s in scene.supports],
        "loads": [{"z": x.at, "force": list(x.force), "moment": list(x.moment)} for x in scene.loads],
    }


def placed(one: Problem) -> list[tuple[str, Scene, float, tuple[float, float]]]:
    """Sets of a problem: name, parts in their place on the shaft, shift of the nut along z [m], ends of the stretch of
    shaft with its groove that the reference meshes [m]."""
    scene = one.described
    if isinstance(scene, Scene):
        return [("", scene, 0.0, dimensions(scene).ends(scene))]
    out = []
    for s, bodies in zip(scene.sets, bodies_of(scene), strict=True):
        assert isinstance(s.parts, Scene)
        low, high = dimensions(bodies.bodies).ends(bodies.bodies)
        out.append((s.name, s.parts, s.offset, (low + bodies.shift, high + bodies.shift)))
    return out


def _to_the_ends(scene: Scene) -> bool:
    """Whether the whole shaft is part of the problem: it is held or loaded beyond the stretch of the reference."""
    low, high = dimensions(scene).ends(scene)
    return any(not low <= z <= high for z in scene.stations)


def _set(one: Problem, name: str, scene: Scene, offset: float, ends: tuple[float, float], first: int) -> dict[str, Any]:
    track, nut, dims, e = scene.track, scene.nut, dimensions(scene), scene.errors
    if e.lead_offset or nut.azimuth or track.starts > 1 or any(e.side(s) != SideErrors() for s in SIDES):
        raise Refusal(one.name, "errors", "an error that the plain form does not hold", "choose a scene without it")
    layout = ball_layout(scene)
    drawn = specimen(scene, layout)
    half = nut.length / 2.0
    return {
        "name": name,
        "helix": {
            "pitch_radius": track.pitch_radius,
            "lead": track.lead,
            "hand": track.hand,
            "azimuth_at_nut_centre": track.phase,
        },
        "contact_angle": track.contact_angle,
        "nut": {
            "z": [nut.position - half, nut.position + half],
            "shift_z": offset,
            "land_radius": dims.land,
            "outer_radius": nut.outer_diameter / 2.0,
            "material": _material(nut.material),
            "held": {"surface": dims.nut_held, "motion": {"ux": 0.0, "uy": 0.0, "uz": 0.0}},
        },
        "flanks": {
            side: {"radius": float(drawn.radius[s]), "centre_x3_z3": _numbers(drawn.centre[0, s])}
            for s, side in enumerate(SIDES)
        },
        "stretch_meshed_by_the_reference": list(ends),
        "ball_material": _material(scene.balls.material),
        "balls": [
            {
                "number": first + i,
                "radius": float(drawn.ball_radius[i]),
                "azimuth": float(layout.azimuth[i]),
                "centre": _numbers(layout.centre[i]),
            }
            for i in range(scene.ball_count)
        ],
    }


def _material(material: Material) -> dict[str, float]:
    return {"youngs_modulus": material.youngs_modulus, "poissons_ratio": material.poissons_ratio}


def _numbers(values: Array) -> list[float]:
    return [float(f"{x:.15g}") for x in values]
