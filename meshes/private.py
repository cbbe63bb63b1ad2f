"""Folders to which only this user can write; needed because files of a cache are trusted, and machine code in it is run."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def private_folder(root: Path, *below: str) -> Path:
    """Create a folder to which only this user can write, inside a root folder, and check the permissions.

    On Windows permissions are not checked.

    Parameters
    ----------
    root : Path
        Root folder; it may be shared by all users, as the folder of temporary files is (sticky bit).
    *below : str
        Names of the nested folders inside the root.

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

    A ``shared`` folder may belong to root, and others may write to it if its sticky bit is set.
    """
    if not hasattr(os, "getuid"):
        return
    owners = {os.getuid(), 0} if shared else {os.getuid()}
    if not stat.S_ISDIR(status.st_mode) or status.st_uid not in owners:
        raise PermissionError(13, "the folder belongs to another user, or is a link", str(folder))
    if status.st_mode & 0o022 and not (shared and status.st_mode & stat.S_ISVTX):
        raise PermissionError(13, "other users may write to the folder (remedy: chmod go-w)", str(folder))
