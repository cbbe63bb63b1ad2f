"""The command ``rollbench export SCENE --deck ccx``: a small scene as a deck for CalculiX and Abaqus."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.errors import InputError
from rollbench.comparison.system import need_gmsh
from rollbench.comparison.wings.crosscheck.deck import DeckOptions, build_deck
from rollbench.comparison.wings.crosscheck.deck_cut import cut_scene, parse_balls
from rollbench.comparison.writing import replace_file
from rollbench.meshes.deck import UNITS, write
from rollbench.meshes.parts import Scene

#: Programs that a deck can be written for; Abaqus reads CalculiX's.
PROGRAMS = ("ccx",)
#: Bounds of the choices: elements across, growth, contact stiffness [N/mm3].
BOUNDS = {"--b-over-h": (0.4, 8.0), "--growth": (0.1, 1.5), "--stiffness": (1e5, 1e12)}


@dataclass(frozen=True)
class DeckChoices:
    """What the command line says: program, unit, balls to keep, elements across the short half axis, growth of the element
    sizes, contact stiffness [N/mm3]."""

    program: str
    unit: str = "mm"
    balls: str = ""
    b_over_h: float = DeckOptions.b_over_h
    growth: float = DeckOptions.growth
    stiffness: float = 1e-9 * DeckOptions.stiffness


def run_deck(scene: Scene, choices: DeckChoices, out: Path | None) -> Answer:
    """Write a scene's deck; out: the file, replaced if it exists; None: ``<scene>.inp``.

    Raises InputError for a bad choice, a scene too large or not representable, and a file that cannot be written.
    """
    if choices.program not in PROGRAMS:
        raise InputError("command line", "--deck", choices.program, ", ".join(PROGRAMS), "Abaqus reads CalculiX's deck")
    if choices.unit not in UNITS:
        raise InputError("command line", "--unit", choices.unit, ", ".join(UNITS), "forces are in N")
    given = {"--b-over-h": choices.b_over_h, "--growth": choices.growth, "--stiffness": choices.stiffness}
    for name, value in given.items():
        low, high = BOUNDS[name]
        if not low <= value <= high:
            raise InputError("command line", name, f"{value:g}", f"{low:g} to {high:g}", "leave it out for the default")
    if out is not None and out.suffix.lower() != ".inp":
        raise InputError("command line", "--out", str(out), "a name ending in .inp", "CalculiX reads no other")
    need_gmsh()
    if choices.balls:
        scene = cut_scene(scene, *parse_balls(choices.balls, scene))
    out = out or Path(f"{scene.name}.inp")
    meshed = build_deck(scene, DeckOptions(choices.b_over_h, choices.growth, 1e9 * choices.stiffness))
    replace_file(out, write(meshed.deck, choices.unit))
    deck = meshed.deck
    line = (
        f"wrote {out}: {deck.node_count} nodes, {sum(len(b.cells) for b in deck.bodies)} 10-node tetrahedra, "
        f"{len(deck.contacts)} contacts; units {UNITS[choices.unit].words}; run it with: ccx -i {out.with_suffix('')}"
    )
    return Answer(parts=[line])


def run(
    program: str, unit: str, balls: str, b_over_h: float, growth: float, stiffness: float, scene: Scene, out: Path | None
) -> Answer:
    """The answer of ``rollbench export --deck``: `run_deck` of the options as they come. Raises InputError."""
    return run_deck(scene, DeckChoices(program, unit, balls, b_over_h, growth, stiffness), out)
