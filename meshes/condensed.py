"""File of the compliance of a screw's bodies between its contacts, from a condensed 3D model for a low-order one.

The file is an ordinary .npz without pickles; it is read whole and checked before anything uses it.
"""

from __future__ import annotations

import hashlib
import io
import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.canonical import digest
from rollbench.meshes.leftovers import folder_for_group, for_group, temporary_name
from rollbench.meshes.parts import Scene

#: Number of this format; files of another are refused.
FORMAT = 2
#: Largest size of all arrays of a file together [bytes]: a screw of 1000 contacts has a tenth of it.
LARGEST_FILE = 200_000_000
#: What the archive's reader raises of a damaged one.
DAMAGE = (zipfile.BadZipFile, zlib.error, struct.error, EOFError, NotImplementedError, OverflowError, ValueError)
#: How numpy packs members.
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
#: Header of an array as numpy writes it: numbers of one kind or a text, the first index slowest or fastest, and the shape.
HEAD = re.compile(
    rb"\{'descr': '([<>|=][fiuU]\d{1,4})', 'fortran_order': (True|False), 'shape': \(((?:\d{1,12},? ?)*)\), \} *\n"
)
#: Beginning of an array by numpy's formats 1.0 and 2.0, and the format of its header's length.
BEGINNING = {b"\x93NUMPY\x01\x00": "<H", b"\x93NUMPY\x02\x00": "<I"}
#: Difference of a compliance from its transpose, and negative eigenvalue, over its largest entry, that a mesh may leave.
ASYMMETRY, NEGATIVE = 1e-6, 1e-3
#: Largest numbers that are read: compliances [m/N], Hertz's [m/N^(2/3)], forces [N], place of the screw's support [m].
LARGEST = {"screw": 1e-2, "nut": 1e-2, "ball": 1e-2, "local": 1e-2, "hertz": 1e-3, "force": 1e9, "base": 1e3}


@dataclass(frozen=True)
class CondensedBodies:
    """Compliance between all contacts of one geometry, along the nominal contact normals (from ball to groove).

    There are N balls with k contacts each; k' of these are on the screw, or on the nut. Matrices count contacts ball
    after ball.
    """

    #: Digest of the parts, by `geometry_digest`.
    geometry: str
    #: Mesh level of the 3D model.
    level: int
    #: Flanks (0 to 3) that carry contacts ``(k,)``, ascending.
    sides: Array
    #: Station of the section by which the screw is fixed [m].
    base: float
    #: Compliance of the screw ``(N k', N k')`` [m/N].
    screw: Array
    #: Compliance of the nut ``(N k', N k')`` [m/N].
    nut: Array
    #: Compliance of one ball between its contacts ``(k, k)`` [m/N].
    ball: Array
    #: Approach of a contact over its force F beyond Hertz's C F^(-1/3) and the matrices, the same for all balls, at f
    #: forces ``(k, f)`` [m/N].
    local: Array
    #: Forces at which ``local`` is sampled ``(k, f)`` [N].
    force: Array
    #: Hertz constants C ``(k,)`` [m/N^(2/3)]: approach C F^(2/3).
    hertz: Array

    def local_law(self, side: int) -> tuple[float, float]:
        """Fit the approach e F + h F^(4/3) of one flank's contacts beyond Hertz's.

        Beyond the linear elasticity of the bodies (e) the next term of a smooth contact is of the order of its area times
        F, F^(4/3) (h); a logarithm of its size fits no better. Least squares over the samples, relative to the approach.

        Parameters
        ----------
        side : int
            Flank 0 to 3.

        Returns
        -------
        e : float
            [m/N].
        h : float
            [m/N^(4/3)].
        """
        e, h = self._fit(list(self.sides).index(side))[0]
        return float(e), float(h)

    def scatter(self, side: int) -> float:
        """Root mean square deviation of the samples from `local_law`, over the approach; what the contact grid leaves."""
        return self._fit(list(self.sides).index(side))[1]

    def _fit(self, k: int) -> tuple[Array, float]:
        force = self.force[k]
        share = np.cbrt(force) / self.hertz[k]
        rows, wanted = np.column_stack([share, share * np.cbrt(force)]), share * self.local[k]
        line = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        return line, float(np.sqrt(np.mean((rows @ line - wanted) ** 2)))

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all.

        Parameters
        ----------
        path : Path
            File to write; missing folders are made.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        values = asdict(self)
        _write_arrays(path, values | {"format": FORMAT, "checksum": arrays_digest(values)})


def _write_arrays(path: Path, values: Mapping[str, Any]) -> None:
    folder_for_group(path.parent)
    name = temporary_name(path)
    try:
        with open(name, "xb") as file:
            np.savez_compressed(file, **values)
        for_group(name)
        os.replace(name, path)
    finally:
        name.unlink(missing_ok=True)


def geometry_digest(scene: Scene) -> str:
    """Digest of everything that the compliance of the bodies depends on.

    Parameters
    ----------
    scene : Scene
        Its track, screw, nut, balls, solid dimensions, and whether the screw is rigid.

    Returns
    -------
    str
        16 hexadecimal digits.
    """
    return digest(scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw)[:16]


def load_condensed(path: Path) -> CondensedBodies:
    """Read and check a file of condensed bodies.

    Parameters
    ----------
    path : Path
        File that `CondensedBodies.save` wrote.

    Returns
    -------
    CondensedBodies
        Its contents.

    Raises
    ------
    ValueError
        The file is damaged, foreign, too large or of another format, or its matrices are not those of elastic bodies
        (finite, symmetric, positive).
    OSError
        There is no such file, or it cannot be read.
    """
    if path.exists() and not path.is_file():
        raise ValueError("no regular file")
    values = _read_arrays(path)
    bodies = CondensedBodies(
        str(values["geometry"]),
        int(values["level"]),
        np.asarray(values["sides"], dtype=float),
        float(values["base"]),
        *(np.asarray(values[name], dtype=float) for name in ("screw", "nut", "ball", "local", "force", "hertz")),
    )
    _check_arrays(bodies)
    return bodies


def _read_arrays(path: Path) -> dict[str, Array]:
    """Read all arrays of a file, after a check of their sizes. Raises ValueError, OSError."""
    names = [f.name for f in fields(CondensedBodies)]
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"more than {LARGEST_FILE:.3g} bytes")
    members = _read_members(path.read_bytes())
    values = {name: _read_array(name, members[name]) for name in ("format", "checksum", *names) if name in members}
    number, said = values.pop("format", np.array(FORMAT)), values.pop("checksum", None)
    if number.shape != () or number.dtype.kind not in "iu" or int(number) != FORMAT:
        raise ValueError(f"format {str(number)[:40]}, this version reads {FORMAT}")
    missing = [name for name in names if name not in values]
    if missing:
        raise ValueError(f"it has no {', '.join(missing)}")
    kinds = {"geometry": "U", "level": "iu"}
    for name, value in values.items():
        if value.dtype.kind not in kinds.get(name, "fiu") or (name in ("geometry", "level", "base") and value.shape != ()):
            raise ValueError(f"{name}: an array of another kind")
    if said is None or str(said) != arrays_digest(values):
        raise ValueError("its checksum does not fit what it holds: it was damaged or changed")
    return values


def _read_members(content: bytes) -> dict[str, bytes]:
    """Read the members of an archive by their names, after a check of their sizes. Raises ValueError."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = archive.infolist()
            declared = sum(info.file_size for info in entries)
            plain = all(x.compress_type in PACKED and not x.flag_bits & 1 for x in entries)
            read = plain and declared <= LARGEST_FILE
            members = {info.filename.removesuffix(".npy"): archive.read(info) for info in entries if read}
    except DAMAGE as e:
        raise ValueError("no file of condensed bodies, or a damaged one") from e
    if not plain:
        raise ValueError("no file of condensed bodies: its archive is encrypted or packed otherwise")
    if declared > LARGEST_FILE:
        raise ValueError(f"it declares {declared:.3g} bytes, at most {LARGEST_FILE:.3g} are read")
    return members


def _read_array(name: str, content: bytes) -> Array:
    """Read an array in numpy's format. Raises ValueError for another format, or a size that its header does not give."""
    length = BEGINNING.get(content[:8])
    first = 8 + (struct.calcsize(length) if length else 0)
    if length is None or len(content) < first:
        raise ValueError(f"{name}: no array, or a damaged one")
    end = first + int(struct.unpack_from(length, content, 8)[0])
    head = HEAD.fullmatch(content[first:end])
    if head is None:
        raise ValueError(f"{name}: a damaged array, or one of another kind")
    kind, shape = np.dtype(head[1].decode()), tuple(int(n) for n in head[3].replace(b",", b" ").split())
    if math.prod(shape) * kind.itemsize != len(content) - end:
        raise ValueError(f"{name} says that it is larger than it is, or smaller")
    return np.ndarray(shape, kind, content, end, order="F" if head[2] == b"True" else "C").copy("K")


def arrays_digest(values: Mapping[str, Any]) -> str:
    """Digest of the arrays of a file, with their names, types and shapes.

    Parameters
    ----------
    values : Mapping[str, Any]
        Arrays by the field names of `CondensedBodies`.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for name in sorted(f.name for f in fields(CondensedBodies)):
        value = np.asarray(values[name])
        digest.update(f"{name} {value.dtype.str} {value.shape}\n".encode() + value.tobytes())
    return digest.hexdigest()


def _check_arrays(bodies: CondensedBodies) -> None:
    """Raise ValueError for arrays that do not belong together, or that no elastic bodies have."""
    k = bodies.sides.size
    sides = bodies.sides.tolist()
    if bodies.sides.ndim != 1 or not k or any(s not in (0.0, 1.0, 2.0, 3.0) for s in sides) or sides != sorted(set(sides)):
        raise ValueError("sides: not some of 0 to 3 in order")
    if {3.0 - s for s in sides} != set(sides):
        raise ValueError("sides: a side without its opposite one")
    square = all(x.ndim == 2 and x.shape[0] == x.shape[1] for x in (bodies.screw, bodies.nut, bodies.ball))
    fits = bodies.ball.shape[0] == k == len(bodies.local) and bodies.hertz.shape == (k,) and bodies.local.ndim == 2
    if not square or not fits or bodies.local.shape != bodies.force.shape:
        raise ValueError("arrays of the wrong shape")
    for name in ("base", "screw", "nut", "ball", "local", "force", "hertz"):
        if not np.isfinite(getattr(bodies, name)).all():
            raise ValueError(f"{name}: not all numbers are finite")
    if not (bodies.hertz > 0.0).all() or not (bodies.force > 0.0).all():
        raise ValueError("hertz, force: not all positive")
    for name, most in LARGEST.items():
        if float(np.abs(getattr(bodies, name)).max(initial=0.0)) > most:
            raise ValueError(f"{name}: more than {most:g}, which no steel part has")
    order = np.argsort(bodies.force, axis=1)
    force, local = (np.take_along_axis(x, order, axis=1) for x in (bodies.force, bodies.local))
    approach = bodies.hertz[:, None] * np.cbrt(force) ** 2 + local * force
    if not (np.diff(approach, axis=1, prepend=0.0) > 0.0).all():
        raise ValueError("local: an approach that does not grow with the force, so that a contact would do work")
    for name in ("screw", "nut", "ball"):
        matrix = getattr(bodies, name)
        size = float(np.abs(matrix).max(initial=0.0))
        if float(np.abs(matrix - matrix.T).max(initial=0.0)) > ASYMMETRY * size:
            raise ValueError(f"{name}: a compliance that is not symmetric")
        if size and float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0]) < -NEGATIVE * size:
            raise ValueError(f"{name}: a compliance that is not positive, so that a body would do work")
