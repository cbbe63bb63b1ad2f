"""The command ``rollbench condense``: the 3D bodies of a scene, condensed to its contacts, as a file."""

from __future__ import annotations

import shlex
from pathlib import Path

from rollbench.compare.commands.terminal import app, cache_folder
from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.running import cores, need_reference, out_of_memory
from rollbench.compare.text.printing import Answer, on_terminal, print_answer


def run_condense(typed: str, out: Path | None, level: int, *, cache: Path | None) -> Answer:
    """Mesh, condense all four sides and write the file, whole or not at all, for all load cases of the scene that was
    ``typed``.

    Raises InputError for a bad level, a mesh that cannot be built, and a file that cannot be written.
    """
    from rollbench.compare.files import need_writable, written
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.reference.tasks import settings_of
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case, whole

    if level not in LEVELS:
        raise ArgumentError("level", str(level), f"1 to {len(LEVELS)}", "choose a mesh level")
    described = catalogue.any_scene(typed)
    scenes = [whole(x, typed) for x in each_case(described, typed)]
    scene = scenes[0]
    out = out or Path(f"{described.name}-condensed.npz")
    need_writable(out)
    need_reference()
    from rollbench.hifi.condensed import condensed_bodies
    from rollbench.hifi.setup import prepare
    from rollbench.meshes.cache import Cache

    try:
        setup = prepare(scene, (0, 1, 2, 3), settings_of(scenes, level), on_terminal, cache=Cache(cache), processes=cores())
    except MemoryError as error:
        raise out_of_memory(error) from error
    except ValueError as error:
        raise Refusal(scene.name, "3D bodies", str(error), "change what it names") from error
    with written(out):
        condensed_bodies(setup, level).save(out)
    command = f"rollbench solve {shlex.quote(typed)} --condensed {shlex.quote(str(out))}"
    return Answer(parts=[f"wrote {out}; use it with: {command}"])


@app.command
def condense(scene: str, *, out: Path | None = None, level: int = 1) -> int:
    """Condense the 3D bodies of a scene to the contacts, for: rollbench solve SCENE --condensed FILE.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file. The file serves all loads, supports and errors of the same parts.
    out
        File to write, replaced if it exists; <scene>-condensed.npz unless given.
    level
        Mesh level, 1 (coarse) to 3.
    """

    return print_answer(run_condense(scene, out, level, cache=cache_folder()))
