"""Folders that only this user may write to: what is read from a cache is trusted, and machine code in it is run."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def private_folder(root: Path, *below: str) -> Path:
    """Make a folder for this user only, below a root, and check its permissions.

    On Windows nothing is checked.

    Parameters
    ----------
    root : Path
        Folder to start from; it may be one that all users share, as that of temporary files (sticky).
    *below : str
        Names of nested folders below the root.

    Returns
    -------
    Path
        The innermost folder.

    Raises
    ------
    PermissionError
        The root or a folder below belongs to another user, or others may write to it.
    OSError
        A folder cannot be made.
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
    if not hasattr(os, "getuid"):
        return
    owners = {os.getuid(), 0} if shared else {os.getuid()}
    if not stat.S_ISDIR(status.st_mode) or status.st_uid not in owners:
        raise PermissionError(13, "it is not this user's alone", str(folder))
    if status.st_mode & 0o022 and not (shared and status.st_mode & stat.S_ISVTX):
        raise PermissionError(13, "other users may write there (chmod go-w)", str(folder))
