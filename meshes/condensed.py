"""Compliance of a screw's bodies between its contacts as a file: what a condensed 3D model tells a low-order one.

The file is an ordinary .npz without pickles; it is read whole and checked before anything uses it.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import zipfile
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from meshes.parts import Scene

Array = NDArray[np.float64]

#: Number of this format; files of another are refused.
FORMAT = 2


@dataclass(frozen=True)
class CondensedBodies:
    """Compliance [m/N] along the nominal contact normals (ball to groove) between all contacts of one geometry.

    geometry: digest of the parts (`geometry_digest`); level: mesh level; sides ``(k,)`` in order; screw, nut
    ``(N k', N k')``: contacts ball after ball, of each ball its sides on that body; the screw is held at ``base`` [m] by
    its section; ball ``(k, k)``: one ball on its contacts. local ``(k, f)`` [m/N]: what each contact's own approach over
    its force F has beside Hertz's C F^(-1/3) and those matrices, the same for every ball; force ``(k, f)`` [N]; hertz
    ``(k,)``: C [m/N^(2/3)].
    """

    geometry: str
    level: int
    sides: Array
    base: float
    screw: Array
    nut: Array
    ball: Array
    local: Array
    force: Array
    hertz: Array

    def own_law(self, side: int) -> tuple[float, float]:
        """e [m/N] and h [m/N^(4/3)] of a side's approach e F + h F^(4/3) beside Hertz, a straight line in a contact's size.

        Fitted to the samples by least squares over their shares of the approach. Beyond linear elasticity of the bodies (e)
        the next term of a smooth contact is of the order of its area, F^(4/3); a logarithm of its size fits no better.
        """
        e, h = self._fit(list(self.sides).index(side))[0]
        return float(e), float(h)

    def scatter(self, side: int) -> float:
        """Root mean square distance of the samples from `own_law`, over the approach: what the contact grid leaves."""
        return self._fit(list(self.sides).index(side))[1]

    def _fit(self, k: int) -> tuple[Array, float]:
        force = self.force[k]
        share = np.cbrt(force) / self.hertz[k]
        rows, wanted = np.column_stack([share, share * np.cbrt(force)]), share * self.local[k]
        line = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        return line, float(np.sqrt(np.mean((rows @ line - wanted) ** 2)))

    def save(self, path: Path) -> None:
        """Write the file whole or not at all. Raises OSError."""
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez_compressed(file, format=FORMAT, **asdict(self))
            os.replace(name, path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise


def geometry_digest(scene: Scene) -> str:
    """Digest of what the bodies' compliance depends on: track, screw, nut, balls, solid dimensions, rigid screw or not."""
    parts = (scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def load_condensed(path: Path) -> CondensedBodies:
    """Read a file. Raises ValueError for one that is damaged, foreign, or of another format; OSError without one."""
    try:
        with np.load(path, allow_pickle=False) as data:
            if int(data["format"]) != FORMAT:
                raise ValueError(f"format {int(data['format'])}, this version reads {FORMAT}")
            values = {f.name: data[f.name] for f in fields(CondensedBodies)}
    except (zipfile.BadZipFile, KeyError, EOFError) as error:
        raise ValueError("no file of condensed bodies, or a damaged one") from error
    found = CondensedBodies(
        str(values["geometry"]),
        int(values["level"]),
        np.asarray(values["sides"], dtype=float),
        float(values["base"]),
        *(np.asarray(values[name], dtype=float) for name in ("screw", "nut", "ball", "local", "force", "hertz")),
    )
    k = found.sides.size
    square = all(x.ndim == 2 and x.shape[0] == x.shape[1] for x in (found.screw, found.nut, found.ball))
    fits = found.ball.shape[0] == k == len(found.local) and found.hertz.shape == (k,)
    if not square or not fits or found.local.shape != found.force.shape or not np.isfinite(found.screw).all():
        raise ValueError("arrays of the wrong shape")
    return found
