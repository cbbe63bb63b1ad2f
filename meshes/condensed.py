"""Compliance matrices of screw, nut and ball between their contacts, condensed from the 3D model; writing and reading.

Low-order models read the file. It is an ordinary .npz file without pickled objects, and is checked completely before use.
"""

from __future__ import annotations

import hashlib
import io
import math
import os
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.files import create_folder_for_group, make_readable_for_group, temporary_path
from rollbench.meshes.parts import Scene
from rollbench.meshes.record_keys import digest_of_values, static_part

#: Version of the format of files with compliance matrices; files of other versions are not read.
FORMAT = 2
#: Largest size of all arrays in a file together [bytes]; those of a screw with 1000 contacts need a tenth of it.
LARGEST_FILE = 200_000_000
#: Largest accepted difference of a compliance matrix from its transpose, and largest accepted negative eigenvalue, both as
#: ratios to its largest entry: numerical errors of the 3D model.
ASYMMETRY, NEGATIVE = 1e-6, 1e-3
#: Largest accepted absolute values: compliances [m/N], Hertz constants [m/N^(2/3)], forces [N], position of the screw's
#: support [m].
LARGEST = {"screw": 1e-2, "nut": 1e-2, "ball": 1e-2, "local": 1e-2, "hertz": 1e-3, "force": 1e9, "base": 1e3}


@dataclass(frozen=True)
class CondensedBodies:
    """Compliance of screw, nut and balls between their contacts, along the nominal contact normals from ball to groove.

    An entry of a matrix is the displacement along one contact normal due to a unit force along another one. There are N
    balls with k contacts each, k' of them on the screw and as many on the nut. Rows and columns are sorted by ball, then by
    flank.
    """

    #: Digest of the scene's parameters on which the compliance depends, from `digest_of_geometry`.
    geometry: str
    #: Level of the 3D mesh from which the compliances were computed, from 1 (coarsest).
    level: int
    #: Flanks (0 to 3) that carry contacts ``(k,)``, ascending.
    sides: Array
    #: Axial position of the cross-section at which the screw is fixed for its compliance matrix [m].
    base: float
    #: Compliance of the screw between its contacts with the N balls, k' for each ball ``(N k', N k')`` [m/N].
    screw: Array
    #: Compliance of the nut between its contacts with the N balls, k' for each ball ``(N k', N k')`` [m/N].
    nut: Array
    #: Compliance of one ball between its contacts ``(k, k)`` [m/N].
    ball: Array
    #: Remaining approach of ball and groove at a contact, divided by the contact force F: total approach minus Hertz's C
    #: F^(2/3) and minus the part from the three compliance matrices. Given for each of k flanks at f forces, the same for
    #: all balls ``(k, f)`` [m/N].
    local: Array
    #: Contact forces for which ``local`` is given, for each flank ``(k, f)`` [N].
    force: Array
    #: Hertz constants C of the flanks, with the approach C F^(2/3) under the force F ``(k,)`` [m/N^(2/3)].
    hertz: Array

    def fit_local_approach_over_load(self, side: int) -> tuple[float, float]:
        """Fit e F + h F^(4/3) to the approach at a contact minus Hertz's part and the part from the compliance matrices.

        F is the contact force. The first term is the linear elasticity of the bodies. The next term for a smooth contact is
        of the order of F times the contact area, that is F^(4/3); a logarithm of the contact's size does not fit better.
        The fit minimises the squared deviations, each divided by Hertz's approach under the force F.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut; one of ``sides``.

        Returns
        -------
        e : float
            Coefficient of F [m/N].
        h : float
            Coefficient of F^(4/3) [m/N^(4/3)].
        """
        k = list(self.sides).index(side)
        share = np.cbrt(self.force[k]) / self.hertz[k]
        rows = np.column_stack([share, share * np.cbrt(self.force[k])])
        e, h = np.linalg.lstsq(rows, share * self.local[k], rcond=None)[0]
        return float(e), float(h)

    def save(self, path: Path) -> None:
        """Write these compliance matrices to a file; after an error, no incomplete file remains.

        Parameters
        ----------
        path : Path
            File to write; missing folders are created.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        values = asdict(self)
        create_folder_for_group(path.parent)
        name = temporary_path(path)
        try:
            with open(name, "xb") as file:
                np.savez_compressed(file, **values, format=FORMAT, checksum=checksum_of_arrays(values))
            make_readable_for_group(name)
            os.replace(name, path)
        finally:
            name.unlink(missing_ok=True)


def digest_of_geometry(scene: Scene) -> str:
    """Compute a digest of all parameters of a scene on which the compliance of screw, nut and balls depends.

    Parameters
    ----------
    scene : Scene
        Scene with track, screw, nut, balls, dimensions of the 3D model, and whether the screw is rigid.

    Returns
    -------
    str
        16 hexadecimal digits.
    """
    parts = static_part((scene.track, scene.screw, scene.nut, scene.balls, scene.solid))
    return digest_of_values(*parts, scene.ingredients.screw)[:16]


def read_condensed_bodies(path: Path) -> CondensedBodies:
    """Read the compliance matrices of screw, nut and balls from their file, and check them.

    Parameters
    ----------
    path : Path
        File written by `CondensedBodies.save`.

    Returns
    -------
    CondensedBodies
        Compliance of screw, nut and balls between their contacts.

    Raises
    ------
    ValueError
        The file is damaged, of another kind or format, or too large; or its matrices are not finite, symmetric and
        positive semidefinite, as those of elastic bodies are.
    OSError
        The file does not exist, or cannot be read.
    """
    if path.exists() and not path.is_file():
        raise ValueError("the path is not that of a regular file")
    values = _read_arrays(path)
    bodies = CondensedBodies(
        str(values["geometry"]),
        int(values["level"]),
        np.asarray(values["sides"], dtype=float),
        float(values["base"]),
        *(np.asarray(values[name], dtype=float) for name in ("screw", "nut", "ball", "local", "force", "hertz")),
    )
    _check_condensed_bodies(bodies)
    return bodies


def _read_arrays(path: Path) -> dict[str, Array]:
    """Read all arrays of a file of compliance matrices, and check their sizes, types and checksum.

    Raises ValueError for a file that fails a check, OSError for one that cannot be read.
    """
    names = [f.name for f in fields(CondensedBodies)]
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"the file has more than {LARGEST_FILE:.3g} bytes, too many for compliance matrices")
    members = _read_archive_members(path.read_bytes())
    values = {name: _parse_array(name, members[name]) for name in ("format", "checksum", *names) if name in members}
    number, said = values.pop("format", np.array(FORMAT)), values.pop("checksum", None)
    if number.shape != () or number.dtype.kind not in "iu" or int(number) != FORMAT:
        raise ValueError(f"the file has format {str(number)[:40]}, but this version reads only format {FORMAT}")
    missing = [name for name in names if name not in values]
    if missing:
        raise ValueError(f"the file lacks the arrays {', '.join(missing)}")
    kinds = {"geometry": "U", "level": "iu"}
    for name, value in values.items():
        if value.dtype.kind not in kinds.get(name, "fiu") or (name in ("geometry", "level", "base") and value.shape != ()):
            raise ValueError(f"the array {name} has an unexpected type or shape")
    if said is None or str(said) != checksum_of_arrays(values):
        raise ValueError("the checksum of the file does not match its arrays: the file was damaged or changed")
    return values


def _read_archive_members(content: bytes) -> dict[str, bytes]:
    """Return the bytes of each member of a zip archive by its name; raise ValueError for a damaged or too large archive."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            declared = sum(info.file_size for info in archive.infolist())
            entries = archive.infolist() if declared <= LARGEST_FILE else []
            members = {info.filename.removesuffix(".npy"): archive.read(info) for info in entries}
    except Exception as e:  # a damaged archive can raise many: of the zip format, of a compression, of encryption
        raise ValueError("the file is damaged, or not an archive of arrays (.npz)") from e
    if declared > LARGEST_FILE:
        raise ValueError(f"the archive states {declared:.3g} bytes of content; at most {LARGEST_FILE:.3g} are read")
    return members


def _parse_array(name: str, content: bytes) -> Array:
    """Convert bytes in the format of numpy's .npy files to an array.

    ``name``: name of the array, for messages; ``content``: the bytes. ValueError for another format, or for a size other
    than that in the header, before memory for the array is allocated.
    """
    file, formats = io.BytesIO(content), np.lib.format
    try:
        version = formats.read_magic(file)
        read_header = formats.read_array_header_1_0 if version == (1, 0) else formats.read_array_header_2_0
        shape, _, kind = read_header(file)
        fits = math.prod(shape) * kind.itemsize == len(content) - file.tell()
        file.seek(0)
        if fits:
            return np.asarray(formats.read_array(file, allow_pickle=False))
    except Exception as e:  # a damaged header can raise many
        raise ValueError(f"the array {name} is damaged, or of another type") from e
    raise ValueError(f"the header of the array {name} states a size other than that of the array")


def checksum_of_arrays(values: Mapping[str, Any]) -> str:
    """Compute the checksum of the arrays of a file of compliance matrices, with their names, types and shapes.

    Parameters
    ----------
    values : Mapping[str, Any]
        Arrays, by the names of the fields of `CondensedBodies`.

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


def _check_condensed_bodies(bodies: CondensedBodies) -> None:
    """Raise ValueError for arrays whose shapes do not match, or whose values are impossible for elastic bodies."""
    k = bodies.sides.size
    sides = bodies.sides.tolist()
    if bodies.sides.ndim != 1 or not k or any(s not in (0.0, 1.0, 2.0, 3.0) for s in sides) or sides != sorted(set(sides)):
        raise ValueError("the numbers of the flanks (sides) are not among 0 to 3 in ascending order")
    if {3.0 - s for s in sides} != set(sides):
        raise ValueError("a flank (in sides) occurs without the flank at the opposite contact of the ball")
    square = all(x.ndim == 2 and x.shape[0] == x.shape[1] for x in (bodies.screw, bodies.nut, bodies.ball))
    fits = bodies.ball.shape[0] == k == len(bodies.local) and bodies.hertz.shape == (k,) and bodies.local.ndim == 2
    if not square or not fits or bodies.local.shape != bodies.force.shape:
        raise ValueError("the shapes of the arrays do not match each other")
    for name in ("base", "screw", "nut", "ball", "local", "force", "hertz"):
        if not np.isfinite(getattr(bodies, name)).all():
            raise ValueError(f"the array {name} contains a number that is not finite")
    if not (bodies.hertz > 0.0).all() or not (bodies.force > 0.0).all():
        raise ValueError("a Hertz constant (hertz) or a force is not positive")
    for name, most in LARGEST.items():
        if float(np.abs(getattr(bodies, name)).max(initial=0.0)) > most:
            raise ValueError(f"a value of {name} exceeds {most:g}, more than is possible for steel parts")
    order = np.argsort(bodies.force, axis=1)
    force, local = (np.take_along_axis(x, order, axis=1) for x in (bodies.force, bodies.local))
    approach = bodies.hertz[:, None] * np.cbrt(force) ** 2 + local * force
    if not (np.diff(approach, axis=1, prepend=0.0) > 0.0).all():
        raise ValueError("the approach of a contact (local) does not increase with its force")
    for name in ("screw", "nut", "ball"):
        matrix = getattr(bodies, name)
        size = float(np.abs(matrix).max(initial=0.0))
        if float(np.abs(matrix - matrix.T).max(initial=0.0)) > ASYMMETRY * size:
            raise ValueError(f"the compliance matrix of the {name} is not symmetric")
        if size and float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0]) < -NEGATIVE * size:
            raise ValueError(f"the compliance matrix of the {name} is not positive semidefinite")
