"""The decks by which CalculiX checks a scene, and its answers as records."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.reference.levels import STUDIED
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.crosscheck.calculix import Outcome, digest, run_calculix
from rollbench.compare.studies.crosscheck.data import BodyMesh, CrossData, CrossRun, load, shipped
from rollbench.compare.studies.crosscheck.deck import DeckOptions, MeshedDeck, build_deck
from rollbench.compare.studies.crosscheck.fit import extrapolate
from rollbench.meshes.arrays import Array
from rollbench.meshes.exchange.deck import UNITS, write
from rollbench.meshes.libraries import version
from rollbench.meshes.parts import SIDES, Scene

#: Unit of the decks.
UNIT = "mm"


def _choices(*rows: tuple[float, float, float], half: bool = False, alike: bool = False) -> list[DeckOptions]:
    """Rows of elements across, growth and stiffness [N/mm3]."""
    return [DeckOptions(b, g, 1e9 * k, half=half, alike=alike) for b, g, k in rows]


#: Decks of every scene that is checked. Element size at the contacts and growth are varied one by one on coarse meshes, and
#: refined together (b/h times growth 0.48) on halves and on balls of one mesh; contact stiffness, large displacements.
STUDIES: dict[str, list[DeckOptions]] = {
    "two-balls": [
        *_choices((0.6, 0.8, 2e8), (0.8, 0.6, 2e8), (1.2, 0.4, 2e8), (1.1, 0.6, 2e8)),
        *_choices((1.5, 0.6, 2e8), (1.1, 0.8, 2e8), (0.8, 0.4, 2e8), (0.8, 0.6, 1e9)),
        DeckOptions(0.6, 0.8, 2e17, nlgeom=True),
        *_choices((0.6, 0.8, 2e8), (0.8, 0.6, 2e8), (1.2, 0.4, 2e8), (1.6, 0.3, 2e8), (1.92, 0.25, 2e8), half=True),
    ],
    "lin-case1-cut": [
        *_choices((0.8, 0.8, 2e8), (1.1, 0.8, 2e8), (0.8, 0.6, 2e8), (1.1, 0.6, 2e8), (0.8, 0.8, 1e9)),
        *_choices((1.2, 0.4, 2e8), alike=True),
    ],
}


def label(options: DeckOptions) -> str:
    """Name of a deck's folder."""
    tail = "-nlgeom" * options.nlgeom + "-half" * options.half + "-alike" * options.alike
    return f"bh{options.b_over_h:g}-g{options.growth:g}-k{1e-9 * options.stiffness:g}{tail}"


def scene_key(name: str) -> str:
    """Digest of a shipped scene's content without its remarks: stored results count for this content only."""
    content = {k: v for k, v in tomllib.loads(catalogue.scene_text(name)).items() if k not in ("source", "assumed")}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def checked_scene(name: str) -> Scene:
    """One of the shipped scenes that are checked. Raises InputError for others."""
    if name not in STUDIES:
        raise ArgumentError("scene", name, ", ".join(STUDIES), "choose one of these")
    return catalogue.scene(name)


def run_study(scene: Scene, work: Path, step: Callable[[str], None], stored: Sequence[CrossRun] = ()) -> CrossData:
    """Solve all decks of a scene with CalculiX, one after the other, in folders of their own below ``work``.

    A deck whose result is there or among the ``stored`` runs is not solved again: decks count as equal by their digests.
    Raises InputError where CalculiX is missing or fails.
    """
    runs, known = [], {r.deck: r for r in stored}
    for options in STUDIES[scene.name]:
        meshed = build_deck(scene, options)
        text = write(meshed.deck, UNIT)
        if digest(text) in known:
            runs.append(known[digest(text)])
            step(f"{label(options)}: stored")
            continue
        try:
            outcome = run_calculix(text, work / scene.name / label(options))
            runs.append(record(meshed, options, digest(text), outcome))
        except ValueError as error:
            raise InputError(
                scene.name, label(options), str(error), "a deck that CalculiX solves", "see its folder"
            ) from None
        step(f"{label(options)}: {meshed.deck.node_count} nodes, {outcome.iterations} iterations, {outcome.seconds:.0f} s")
    return CrossData(scene.name, scene_key(scene.name), __version__, version("gmsh") or "", tuple(runs))


def record(meshed: MeshedDeck, options: DeckOptions, deck: str, outcome: Outcome) -> CrossRun:
    """A run as it is stored. Raises ValueError where a contact is missing."""
    mirror = np.array([2.0, 0.0, 2.0]) if options.half else np.ones(3)  # with its mirror image
    forces = {slave: mirror * np.array(force) for slave, force in outcome.forces.items()}
    count = len(meshed.expected)
    load, resultant = np.zeros((count, len(SIDES))), np.zeros((count, 3))
    for contact in meshed.deck.contacts:
        if contact.slave not in forces:
            raise ValueError(f"CalculiX printed no force of {contact.slave}")
        ball, side = contact.slave.removeprefix("BALL").split("_")
        load[int(ball) - 1, SIDES.index(side)] = np.linalg.norm(forces[contact.slave])
        resultant[int(ball) - 1] += forces[contact.slave]
    spring = options.spring * UNITS[UNIT].length
    weak = [list(outcome.moved[f"BALL{i + 1}_WEAK"].values()) for i in range(count)]
    held = np.array([mirror * spring * np.sum(nodes, axis=0) for nodes in weak])
    loose = np.linalg.norm(resultant - held, axis=1)  # what is printed acts on the slave, the ball
    return CrossRun(
        **vars(options),
        fine=meshed.fine,
        deck=deck,
        meshes=tuple(BodyMesh(b.name, len(b.points), len(b.cells), meshed.quality[b.name]) for b in meshed.deck.bodies),
        load=load,
        weak=float(np.linalg.norm(held, axis=1).max()),
        unbalanced=float(loose.max()),
        **{name: getattr(outcome, name) for name in ("iterations", "correction", "seconds", "date")},
        program=f"CalculiX {outcome.version}",
    )


def extrapolated() -> tuple[str, dict[str, Array]]:
    """The program, and its extrapolated loads ``(n, 4)`` [N] of the scenes that it has solved in their state of today."""
    stored = {name: load(shipped(), name) for name in STUDIES}
    kept = {name: d for name, d in stored.items() if d is not None and d.key == scene_key(name)}
    return "CalculiX", {name: extrapolate(d.runs).load for name, d in kept.items()}


def references(fresh: bool) -> Iterator[tuple[tuple[str, ...], tuple[int, ...]]]:  # noqa: ARG001 - as every such function
    """Scenes and levels of the 3D reference that the report sets beside CalculiX."""
    yield tuple(STUDIES), STUDIED
