"""Temporary files and folders next to their targets: names, and removal of those that killed processes left.

A name contains machine and process, so that the next writer of the same target recognises abandoned ones.
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


def temporary_name(path: Path, ending: str = "tmp") -> Path:
    """Return a temporary name next to a target, and remove abandoned ones of earlier processes.

    Parameters
    ----------
    path : Path
        Target that the temporary file or folder will replace.
    ending : str, default 'tmp'
        Suffix of the name.

    Returns
    -------
    Path
        The name; nothing is created.
    """
    remove_leftovers(path, ending)
    return path.with_name(f".{path.name}.{_machine_name()}-{os.getpid()}-{os.urandom(4).hex()}.{ending}")


def for_group(path: Path) -> None:
    """Let the group read a file of this user's, whatever the umask: stored files are meant to be shared.

    Parameters
    ----------
    path : Path
        The file.
    """
    with suppress(OSError):  # another user's file, or a file system without modes: the owner reads it all the same
        path.chmod(path.stat().st_mode | 0o440)


def folder_for_group(path: Path) -> None:
    """Make a folder and its missing parents; new ones may be read by the group.

    Parameters
    ----------
    path : Path
        The folder.
    """
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for folder in missing:
        with suppress(OSError):  # as above
            folder.chmod(folder.stat().st_mode | 0o050)


def remove_leftovers(path: Path, ending: str = "tmp") -> None:
    """Remove temporary files and folders of a target whose process is dead, or that are older than a day.

    Parameters
    ----------
    path : Path
        Target, as for `temporary_name`.
    ending : str, default 'tmp'
        Suffix of the names.
    """
    name = re.compile(rf"\.{re.escape(path.name)}\.([0-9a-f]{{8}})-(\d+)-[0-9a-f]{{8}}\.{re.escape(ending)}")
    with suppress(OSError):  # no such folder, or one that may not be listed: nothing to tidy
        for other in path.parent.iterdir():
            match = name.fullmatch(other.name)
            if match is None or not _is_abandoned(other, match[1], int(match[2])):
                continue
            if other.is_dir() and not other.is_symlink():
                shutil.rmtree(other, ignore_errors=True)
            else:
                with suppress(OSError):  # another process was faster
                    other.unlink()


def _is_abandoned(path: Path, machine: str, process: int) -> bool:
    """Whether nobody writes a temporary file any more."""
    try:
        if machine != _machine_name():
            return time.time() - path.lstat().st_mtime > OLD
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except OSError:  # another user's, or gone
        return False
    return False


def _machine_name() -> str:
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]
