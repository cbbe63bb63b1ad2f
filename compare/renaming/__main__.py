"""``python -m rollbench.comparison.renaming FOLDER [SCENE.toml ...]``: a store of version 0.4.4 or before, renamed.

Runs and condensed bodies of the shipped scenes and of those that are given. Exit codes: 0 all have the new names, 1 some
keep theirs (with the reason), 2 bad input.
"""

from __future__ import annotations

import sys
from pathlib import Path

from rollbench.comparison.errors import InputError
from rollbench.comparison.renaming.files import rename
from rollbench.comparison.scenes import catalogue


def main(arguments: list[str]) -> int:
    """Rename the files of a folder; returns the exit code."""
    try:
        if not arguments or not Path(arguments[0]).is_dir():
            given = arguments[0] if arguments else "nothing"
            raise InputError(
                "command line", "FOLDER", given, "a folder of stored runs", "name the folder, then scene files"
            )
        scenes = [catalogue.shipped(name) for name in catalogue.scene_names()]
        found = rename(Path(arguments[0]), [*map(catalogue.any_scene, arguments[1:]), *scenes])
    except InputError as error:
        print(f"rollbench: {error}", file=sys.stderr)
        return 2
    for name, reason in found.left.items():
        print(f"{name}: left as it is: {reason}")
    print(f"{len(found.done)} renamed, {len(found.new)} had the new name, {len(found.left)} left as they are")
    return 1 if found.left else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
