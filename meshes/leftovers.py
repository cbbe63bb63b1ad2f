"""Names of temporary files and folders next to those they become, and what killed processes left of them.

A name tells machine and process, so that the next writer of the same file knows which are nobody's any more.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import time
from contextlib import suppress
from pathlib import Path

#: Age [s] at which a temporary file of another machine counts as left behind.
OLD = 86_400.0


def temporary(path: Path, ending: str = "tmp") -> Path:
    """A new name next to ``path`` for what will become it; leftovers of earlier ones of dead processes are removed."""
    clean(path, ending)
    return path.with_name(f".{path.name}.{_machine()}-{os.getpid()}-{os.urandom(4).hex()}.{ending}")


def for_group(path: Path) -> None:
    """Let the group read a file of this user's, whatever the mask of new files: what is stored is meant to be shared."""
    with suppress(OSError):  # another user's file, or a file system without modes: the owner reads it all the same
        path.chmod(path.stat().st_mode | 0o440)


def folder_for_group(path: Path) -> None:
    """Make a folder and those above it that are missing; what is made lets the group read in it."""
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for folder in missing:
        with suppress(OSError):  # as above
            folder.chmod(folder.stat().st_mode | 0o050)


def clean(path: Path, ending: str = "tmp") -> None:
    """Remove the temporary files and folders of ``path`` whose process is dead, or that are a day old."""
    name = re.compile(rf"\.{re.escape(path.name)}\.([0-9a-f]{{8}})-(\d+)-[0-9a-f]{{8}}\.{re.escape(ending)}")
    with suppress(OSError):  # no such folder, or one that may not be listed: nothing to tidy
        for other in path.parent.iterdir():
            match = name.fullmatch(other.name)
            if match is None or not _dead(other, match[1], int(match[2])):
                continue
            if other.is_dir() and not other.is_symlink():
                shutil.rmtree(other, ignore_errors=True)
            else:
                with suppress(OSError):  # another process was faster
                    other.unlink()


def _dead(path: Path, machine: str, process: int) -> bool:
    """Whether nobody writes a temporary file any more."""
    try:
        if machine != _machine():
            return time.time() - path.lstat().st_mtime > OLD
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except OSError:  # another user's, or gone
        return False
    return False


def _machine() -> str:
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]
