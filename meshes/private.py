"""Folders of this user only: what is read from a cache is trusted, machine code in it is run."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def private_folder(root: Path, *below: str) -> Path:
    """The folder ``below`` a root, made where it is missing, for this user only.

    Raises OSError where it cannot be made, and PermissionError where the root or a folder below is another user's or may be
    written to by others; only the root may be one that all share, as that of temporary files is (sticky). On Windows
    nothing is looked at.
    """
    root.mkdir(mode=0o700, parents=True, exist_ok=True)
    _check(root.stat(), root, shared=True)
    folder = root
    for name in below:
        folder /= name
        folder.mkdir(mode=0o700, exist_ok=True)
        _check(folder.lstat(), folder, shared=False)
    return folder


def _check(status: os.stat_result, folder: Path, *, shared: bool) -> None:
    if not hasattr(os, "getuid"):
        return
    owners = {os.getuid(), 0} if shared else {os.getuid()}
    if not stat.S_ISDIR(status.st_mode) or status.st_uid not in owners:
        raise PermissionError(13, "it is not this user's alone", str(folder))
    if status.st_mode & 0o022 and not (shared and status.st_mode & stat.S_ISVTX):
        raise PermissionError(13, "it is not this user's alone, others may write there (chmod go-w)", str(folder))
