"""Temporary files, and permissions of files and folders.

A temporary file is in the same folder as its target. Its name contains machine and process, so that the next process which
writes the same target recognises abandoned ones.

A cache needs a folder to which only this user can write, because its files are trusted.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import stat
import time
from contextlib import suppress
from pathlib import Path

#: Age [s] from which a temporary file of another machine counts as abandoned.
OLD = 86_400.0


def temporary_path(path: Path, ending: str = "tmp") -> Path:
    """Return a path for a temporary file in the folder of its target, and delete abandoned temporary files there.

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
    remove_abandoned_files(path, ending)
    return path.with_name(f".{path.name}.{machine_code()}-{os.getpid()}-{os.urandom(4).hex()}.{ending}")


def make_readable_for_group(path: Path) -> None:
    """Make a file of this user readable for its group, whatever the umask says; stored files are meant to be shared.

    Parameters
    ----------
    path : Path
        The file.
    """
    with suppress(OSError):  # another user's file, or a file system without permissions
        path.chmod(path.stat().st_mode | 0o440)


def create_folder_for_group(path: Path) -> None:
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


def remove_abandoned_files(path: Path, ending: str = "tmp") -> None:
    """Delete the abandoned temporary files and folders of a target.

    A file is abandoned if a process of this machine that has ended wrote it, or another machine more than a day ago.

    Parameters
    ----------
    path : Path
        Target file or folder, as for `temporary_path`.
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
    """Return whether a temporary file is abandoned: its process has ended, or another machine wrote it over a day ago.

    ``path``: the file; ``machine``: code of the machine in the file's name; ``process``: id of the process that wrote it.
    """
    try:
        if machine != machine_code():
            return time.time() - path.lstat().st_mtime > OLD
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except OSError:  # the file is gone, or the process belongs to another user
        return False
    return False


def machine_code() -> str:
    """Return eight hexadecimal digits, computed from this machine's network name, that identify the machine."""
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]


def create_private_folder(root: Path, *below: str) -> Path:
    """Create nested folders in a root folder to which only this user can write, and check the permissions.

    On Windows permissions are not checked.

    Parameters
    ----------
    root : Path
        Root folder; it may be shared by all users, as the folder of temporary files is (sticky bit).
    *below : str
        Names of the nested folders inside the root, the outermost one first.

    Returns
    -------
    Path
        The innermost folder.

    Raises
    ------
    PermissionError
        The root or a folder inside belongs to another user, or others may write to it.
    OSError
        A folder cannot be created.
    """
    root.mkdir(mode=0o700, parents=True, exist_ok=True)
    _check_ownership(root.stat(), root, shared=True)
    folder = root
    for name in below:
        folder /= name
        folder.mkdir(mode=0o700, exist_ok=True)
        _check_ownership(folder.lstat(), folder, shared=False)
    return folder


def _check_ownership(status: os.stat_result, folder: Path, *, shared: bool) -> None:
    """Raise PermissionError where a folder belongs to another user, or others may write to it.

    ``status``: the folder's owner and permissions. A ``shared`` folder may belong to root, and others may write to it if
    its sticky bit is set.
    """
    if not hasattr(os, "getuid"):
        return
    owners = {os.getuid(), 0} if shared else {os.getuid()}
    if not stat.S_ISDIR(status.st_mode) or status.st_uid not in owners:
        raise PermissionError(13, "the folder belongs to another user, or is a link", str(folder))
    if status.st_mode & 0o022 and not (shared and status.st_mode & stat.S_ISVTX):
        raise PermissionError(13, "other users may write to the folder (remedy: chmod go-w)", str(folder))
