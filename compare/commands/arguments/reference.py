"""The 3D reference of scenes, and what goes to other programs: mesh-study, compare, export."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.comparison.commands.arguments.terminal import Flag, Json, Where, Word, app, cache_folder, engine
from rollbench.comparison.commands.printing import print_answer
from rollbench.comparison.errors import InputError
from rollbench.comparison.registration import needed


@app.command(name="mesh-study")
def mesh_study(
    scenes: list[str],
    *,
    levels: int | None = None,
    store: Path = Path("rollbench-reference"),
    spread: Flag = False,
    source_mesh: Flag = False,
    fresh: Flag = False,
    bodies: str = "half-space",
    as_json: Json = False,
    where: Where | None = None,
) -> int:
    """Run the 3D reference on several mesh levels: observed orders, uncertainty, modelling spread.

    Exit code 5 where loads did not settle: what they may still move by is said, kept with the run and added to its bars.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files; those of the same parts share their meshes.
    levels
        Levels 1 to this one; unless given, levels 1 and 3, of which the second is clearly more accurate (of scenes of
        friction 1 to 3). Each is stored when it is done, so an interrupted study resumes.
    store
        Folder of the results; the table goes there as CSV, the figure as SVG.
    spread
        Also vary the modelling choices that are not printed, on the coarsest level.
    source_mesh
        Also run the source's mesh: first-order tetrahedra of 0.08 mm around every contact.
    fresh
        Compute runs even where they are stored.
    bodies
        Of scenes of friction: half-space, or finite (patches of the static reference, or a ball and grooved bars).
    """
    from rollbench.comparison.commands.comparing.kinds import all_rolling
    from rollbench.comparison.commands.comparing.study import run_mesh_study

    if rolling := all_rolling(scenes, bodies, "rolling study", {"--spread": spread}):
        answer = rolling(scenes, levels, store, engine(where), source=source_mesh, fresh=fresh, bodies=bodies)
    else:
        answer = run_mesh_study(scenes, levels, store, engine(where), spread=spread, source=source_mesh, fresh=fresh)
    return print_answer(answer, as_json)


@app.command
def compare(
    scenes: list[str],
    *,
    model: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    levels: str | None = None,
    store: Path = Path("rollbench-reference"),
    fresh: Flag = False,
    balls: Flag = False,
    reference: Path | None = None,
    bodies: str = "half-space",
    as_json: Json = False,
    where: Where | None = None,
) -> int:
    """Compare low-order models with the 3D reference of scenes; the reference is computed where none is stored.

    A verdict, ten answers beside the reference's, a table of models; every contact goes to <scene>-compare.csv and .svg in
    the store. For a page to send: rollbench report SCENE. Exit code 5 where loads of the reference did not settle: what
    they may still move by is said, kept with the run and added to its uncertainty.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files.
    model
        Low-order models of rollbench list; condensed takes the bodies of the reference's finest level. Unless given:
        refined, the default of every command, whose error is the verdict, and beside it the others that the report
        compares.
    levels
        Mesh levels of the reference: 3 for levels 1 to 3, or a list such as source,1,2; the best stored one unless given,
        levels 1 and 3 where there is none.
    store
        Folder of the reference's results, besides those shipped.
    fresh
        Compute runs even where they are stored or shipped.
    balls
        Also print every contact.
    reference
        Compare with this file in place of the 3D reference, which stands beside it where it is stored; as for rollbench
        check.
    bodies
        Of scenes of friction: half-space, or finite (patches of the static reference, or a ball and grooved bars).
    """
    from rollbench.comparison.commands.comparing.kinds import all_rolling
    from rollbench.comparison.commands.comparing.study import parse_levels, run_compare

    wanted = None if levels is None else parse_levels(levels)
    means_nothing = {"--model": model is not None, "--balls": balls, "--reference": reference is not None}
    if rolling := all_rolling(scenes, bodies, "rolling compare", means_nothing):
        answer = rolling(scenes, wanted, store, engine(where), fresh=fresh, bodies=bodies)
    else:
        answer = run_compare(
            scenes, model or (), wanted, store, engine(where), fresh=fresh, balls=balls, reference=reference
        )
    return print_answer(answer, as_json)


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
    """Write a mesh or a result field of the 3D reference for other programs (VTU, MSH, MED or INP, lengths in m), or a
    small scene as one deck that CalculiX runs (--deck ccx).

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    part
        screw, nut or ball, whole; screw-with-sockets (nut, ball): as the reference condenses it, a hole at every contact,
        which patch-SL (the groove's fine patch; SR, NL, NR) and ball-patch-SL fill; or block-source; none with --deck.
    out
        File to write, replaced if it exists; <scene>-<part>.vtu unless given, <scene>.inp with --deck.
    format
        vtu, msh, med or inp; by the file's name unless given.
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
    from rollbench.comparison.commands.export import run_export
    from rollbench.comparison.scenes import catalogue

    if deck:
        if part or format or level != 1 or ball is not None:
            raise InputError(
                "command line", "--deck", deck, "no part, --format, --level or --ball with it", "leave them out"
            )
        write_deck = needed("deck", "command line", "--deck", deck)
        return print_answer(write_deck(deck, unit, balls, b_over_h, growth, stiffness, catalogue.scene(scene), out))
    if (unit, balls, b_over_h, growth, stiffness) != ("mm", "", 1.5, 0.4, 2e8):
        raise InputError(
            "command line", "--unit, --balls, --b-over-h, --growth, --stiffness", "given", "with --deck", "add --deck ccx"
        )
    return print_answer(run_export(catalogue.scene(scene), part, format, out, level, cache=cache_folder(), ball=ball))
