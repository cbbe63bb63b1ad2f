"""Options and help of ``rollbench export``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.arguments.terminal import Word, app, cache_folder
from rollbench.compare.commands.printing import print_answer
from rollbench.compare.errors import ArgumentError
from rollbench.compare.registration import needed


@app.command
def export(
    scene: str,
    part: Word = "",
    *,
    out: Path | None = None,
    format: Annotated[Word, Parameter(name="--format")] = "",
    level: int = 1,
    ball: int | None = None,
    deck: Word = "",
    unit: str = "mm",
    balls: Word = "",
    b_over_h: float = 1.5,
    growth: float = 0.4,
    stiffness: float = 2e8,
) -> int:
    """Write a mesh or a result field of the 3D reference for other programs (VTU, MSH, MED or INP, lengths in m), all parts
    as CAD (STEP, lengths in mm), or a small scene as one deck that CalculiX runs (--deck ccx).

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    part
        screw, nut or ball, whole; screw-with-sockets (nut, ball): as the reference condenses it, a hole at every contact,
        which patch-SL (the groove's fine patch; SR, NL, NR) and ball-patch-SL fill; or block-source; none with --deck
        and --format step.
    out
        File to write, replaced if it exists; <scene>-<part>.vtu unless given, <scene>.step or, with --deck, <scene>.inp.
    format
        vtu, msh, med, inp or step; by the file's name unless given.
    level
        Mesh level, 1 (coarse) to 3; 0 is the source's mesh.
    ball
        Solve the scene and add displacement and stress: of this ball and its patches, or of screw or nut, with sockets.
    deck
        Program to write the whole contact problem for: ccx (CalculiX; Abaqus reads the same file).
    unit
        Unit of length in the deck: mm (with N and MPa) or m (with N and Pa).
    balls
        Cut the screw of the deck to some neighbouring balls: 3:5 keeps balls 3, 4 and 5.
    b_over_h
        Elements of the deck across the short half axis of a contact of mean load.
    growth
        Growth of the deck's element sizes per distance from the contacts.
    stiffness
        Contact pressure per overclosure of the deck, in N/mm3.
    """
    from rollbench.compare.scenes import catalogue, scene_file
    from rollbench.compare.wings.export.command import run_export, run_step

    if deck:
        if part or format or level != 1 or ball is not None:
            raise ArgumentError("deck", deck, "no `part`, `format`, `level` or `ball` with it", "leave them out")
        write_deck = needed("deck", "command line", "--deck", deck)
        return print_answer(write_deck(deck, unit, balls, b_over_h, growth, stiffness, catalogue.scene(scene), out))
    if (unit, balls, b_over_h, growth, stiffness) != ("mm", "", 1.5, 0.4, 2e8):
        raise ArgumentError("unit, balls, b_over_h, growth, stiffness", "given", "with --deck", "add --deck ccx")
    if format == "step" or (not format and out is not None and out.suffix == ".step"):
        if part or level != 1 or ball is not None:
            raise ArgumentError("format", "step", "no `part`, `level` or `ball` with it", "leave them out")
        return print_answer(run_step(scene_file.solvable(catalogue.any_scene(scene), scene), out))
    return print_answer(run_export(catalogue.scene(scene), part, format, out, level, cache=cache_folder(), ball=ball))
