"""Names of temporary files and folders, and removal of those that ended processes have left behind.

A temporary file is in the same folder as its target. Its name contains machine and process, so that the next process which
writes the same target recognises abandoned ones.
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

#: Age [s] from which a temporary file of another machine counts as abandoned.
OLD = 86_400.0


def temporary_name(path: Path, ending: str = "tmp") -> Path:
    """Return a name for a temporary file in the folder of its target, and remove abandoned temporary files of the target.

    Parameters
    ----------
    path : Path
        Target file or folder, which the temporary one will replace.
    ending : str, default 'tmp'
        Suffix of the name.

    Returns
    -------
    Path
        Path of the temporary file, which is not created.
    """
    remove_leftovers(path, ending)
    return path.with_name(f".{path.name}.{_machine_name()}-{os.getpid()}-{os.urandom(4).hex()}.{ending}")


def make_readable_for_group(path: Path) -> None:
    """Make a file of this user readable for its group, whatever the umask, because stored files are meant to be shared.

    Parameters
    ----------
    path : Path
        The file.
    """
    with suppress(OSError):  # another user's file, or a file system without permissions
        path.chmod(path.stat().st_mode | 0o440)


def make_folder_for_group(path: Path) -> None:
    """Create a folder and its missing parents; the new folders are readable for the group.

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
    """Remove the abandoned temporary files and folders of a target.

    Abandoned ones were written by a process of this machine that has ended, or by another machine more than a day ago.

    Parameters
    ----------
    path : Path
        Target file or folder, as for `temporary_name`.
    ending : str, default 'tmp'
        Suffix of the temporary names.
    """
    name = re.compile(rf"\.{re.escape(path.name)}\.([0-9a-f]{{8}})-(\d+)-[0-9a-f]{{8}}\.{re.escape(ending)}")
    with suppress(OSError):  # the folder does not exist, or cannot be listed
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
    """Return whether the process that wrote a temporary file has ended, or the file of another machine is old."""
    try:
        if machine != _machine_name():
            return time.time() - path.lstat().st_mtime > OLD
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except OSError:  # the file is gone, or the process belongs to another user
        return False
    return False


def _machine_name() -> str:
    """Return eight hexadecimal digits that identify this machine."""
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]
