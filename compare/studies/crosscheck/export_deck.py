"""The command ``rollbench export SCENE --deck ccx``: a small scene, or a few neighbouring balls cut out of a larger one
with short pieces of screw and nut, as a deck for CalculiX and Abaqus."""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import replace_file
from rollbench.compare.running import need_gmsh
from rollbench.compare.studies.crosscheck.deck import DeckOptions, build_deck, refuse
from rollbench.meshes.exchange.deck import UNITS, write
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Load, Scene, Support

#: Programs that a deck can be written for; Abaqus reads CalculiX's.
PROGRAMS = ("ccx",)
#: Bounds of the choices: elements across, growth, contact stiffness [N/mm3].
BOUNDS = {"b_over_h": (0.4, 8.0), "growth": (0.1, 1.5), "stiffness": (1e5, 1e12)}
#: Nut beyond the outermost balls, and 3D screw beyond the nut, over the ball's radius.
NUT, SHAFT = 3.0, 3.0


def write_deck(
    program: str, unit: str, balls: str, b_over_h: float, growth: float, stiffness: float, scene: Scene, out: Path | None
) -> str:
    """Write a scene's deck, and a line about it: for a program, in a unit, with some balls kept, elements across the short
    half axis, growth of the element sizes, contact stiffness [N/mm3]. out: the file, replaced if it exists; None:
    ``<scene>.inp``.

    Raises InputError for a bad choice, a scene too large or not representable, and a file that cannot be written.
    """
    faults = [
        (program not in PROGRAMS, "deck", program, ", ".join(PROGRAMS), "Abaqus reads CalculiX's deck"),
        (unit not in UNITS, "unit", unit, ", ".join(UNITS), "forces are in N"),
    ]
    for (name, (low, high)), value in zip(BOUNDS.items(), (b_over_h, growth, stiffness), strict=True):
        within = low <= value <= high
        faults.append((not within, name, f"{value:g}", f"{low:g} to {high:g}", "leave it out for the default"))
    ending = out is None or out.suffix.lower() == ".inp"
    faults.append((not ending, "out", str(out), "a name ending in .inp", "CalculiX reads no other"))
    for there, *said in faults:
        if there:
            raise ArgumentError(*said)
    need_gmsh()
    if balls:
        scene = cut_scene(scene, *parse_balls(balls, scene))
    out = out or Path(f"{scene.name}.inp")
    deck = build_deck(scene, DeckOptions(b_over_h, growth, 1e9 * stiffness)).deck
    replace_file(out, write(deck, unit))
    name = shlex.quote(str(out.with_suffix("")))
    return (
        f"wrote {out}: {deck.node_count} nodes, {sum(len(b.cells) for b in deck.bodies)} 10-node tetrahedra, "
        f"{len(deck.contacts)} contacts; units {UNITS[unit].words}; run it with: ccx -i {name}"
    )


def parse_balls(text: str, scene: Scene) -> tuple[int, int]:
    """First and last ball (from 1) of ``3:5``. Raises InputError."""
    allowed = f"FIRST:LAST with balls from 1 to {scene.ball_count}"
    words = re.fullmatch(r"([0-9]{1,9}):([0-9]{1,9})", text)
    first, last = (int(words[1]), int(words[2])) if words else (0, 0)
    if not 1 <= first <= last <= scene.ball_count:
        raise ArgumentError("balls", text, allowed, "3:5 keeps balls 3, 4 and 5")
    return first, last


def cut_scene(scene: Scene, first: int, last: int) -> Scene:
    """Balls ``first`` to ``last`` (from 1) of a screw of one start, in a piece of nut and of screw around them.

    Every load and support moves to the nearer end of the piece of screw (its station there), loads are reduced to the
    balls' share; listed errors of ball radii keep their balls. Raises InputError for a bearing, a screw of several starts,
    random errors (their draws depend on the number of balls) and prescribed displacements, which have no counterpart.
    """
    track, layout = scene.track, ball_layout(scene)
    faults = (
        (track.lead == 0.0, "track.lead", "0 mm", "a screw: a ring cannot be cut"),
        (track.starts != 1, "track.starts", str(track.starts), "one start"),
        (scene.nut.flange is not None, "nut.flange", "a flange", "a nut without one: a piece of it has none"),
        (scene.errors.random, "errors", "random errors", "errors that are given"),
        (any(v for s in scene.supports for _, v in s.fixed), "supports", "a prescribed displacement", "supports at zero"),
    )
    refuse(scene.name, [(*fault, "write the small scene yourself and leave `balls` out") for fault in faults])
    kept = slice(first - 1, last)
    z, azimuth = layout.z[kept], layout.azimuth[kept]
    r, middle = scene.balls.radius, float(0.5 * (z.min() + z.max()))
    length = float(np.ptp(z)) + 2.0 * NUT * r
    low, high = middle - length / 2.0 - SHAFT * r, middle + length / 2.0 + SHAFT * r
    if low < 0.0 or high > scene.screw.length:
        raise ArgumentError(
            "balls", f"{first}:{last}", "balls away from the screw's ends", "cut nearer to the nut's middle", scene.name
        )
    share = (last - first + 1) / scene.ball_count

    def end(at: float) -> float:
        return low if at <= middle else high

    def scaled(v: tuple[float, float, float]) -> tuple[float, float, float]:
        return share * v[0], share * v[1], share * v[2]

    listed = tuple((n - first + 1, e) for n, e in scene.errors.balls.listed if first <= n <= last)
    return replace(
        scene,
        name=f"{scene.name}-balls-{first}-{last}",
        title=f"Balls {first} to {last} of: {scene.title}",
        track=replace(track, phase=float(0.5 * (azimuth[0] + azimuth[-1]))),
        nut=replace(scene.nut, position=middle, length=length),
        balls=replace(scene.balls, azimuths=tuple(azimuth.tolist())),
        errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=listed)),
        supports=tuple(Support(end(s.at), s.fixed) for s in scene.supports),
        loads=tuple(Load(end(x.at), scaled(x.force), scaled(x.moment)) for x in scene.loads),
        solid=replace(scene.solid, shaft=SHAFT * r, screw_held="ends"),
        assumed=(
            *scene.assumed,
            f"Cut of balls {first} to {last}: nut {NUT:g} ball radii beyond the outermost balls, screw {SHAFT:g} beyond "
            f"the nut; supports and loads moved to the nearer end, loads times {share:.4g}.",
        ),
    )
