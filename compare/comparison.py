"""Low-order models beside the 3D reference: rows per contact, errors with the reference's own uncertainty, the gate."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from compare.measure import LoadError, error_percent, load_error
from compare.models import Options, run_model
from compare.reference import Reference
from lowfi.result import StaticResult
from meshes.parts import SIDES, Scene

#: Scenes whose reference runs come with the package.
REFERENCED = ("lin-case1", "lin-case2", "lin-case3", "lin-case3-offset")
#: A contact below this share of the mean load is compared in per cent of the mean load, not of its own [-].
SMALL = 0.1


@dataclass(frozen=True)
class Row:
    """One quantity of one scene on one model against the reference, as ``rollbench compare --json`` prints it."""

    scene: str
    quantity: str
    ball: int | None
    side: str | None
    unit: str
    printed: float | None
    model: str
    value: float | None
    reference: float | None
    reference_error: float | None
    error_percent: float | None
    seconds: float | None


def timed(scene: Scene, model: str) -> tuple[StaticResult, float]:
    """Result of a model and the seconds of the whole call."""
    start = perf_counter()
    result = run_model(scene, model, Options(discretisation=False))
    return result, perf_counter() - start


def rows(scene: Scene, model: str, found: Reference) -> list[Row]:
    """Loads of every contact, then the largest and RMS error (in per cent of the mean, and of each load)."""
    result, seconds = timed(scene, model)
    out = []
    for i in range(result.z.size):
        for s, side in enumerate(SIDES):
            value, ref = float(result.load[i, s]), float(found.load[i, s])
            if value == 0.0 and ref == 0.0:
                continue
            bar = None if found.uncertainty is None else float(found.uncertainty[i, s])
            percent = float(error_percent(value, ref)) if ref > 0.0 else None
            out.append(Row(scene.name, "load", i + 1, side, "N", None, model, value, ref, bar, percent, seconds))
    e = load_error(result.load, found.load)
    for name, number in (
        (f"largest error, of mean (ball {e.ball} {e.side})", e.max_percent), ("RMS error, of mean", e.rms_percent),
        ("largest error, of own load", e.own_max_percent), ("RMS error, of own load", e.own_rms_percent),
    ):  # fmt: skip
        out.append(Row(scene.name, name, None, None, "%", None, model, None, None, None, number, seconds))
    return out


def as_json(row: Row) -> dict[str, Any]:
    """JSON-ready."""
    return asdict(row)


@dataclass(frozen=True)
class Exceedance:
    """A contact of a scene whose low-order error is known to lie beyond the gate, with its cause."""

    scene: str
    ball: int
    side: str
    cause: str


def known_exceedances() -> list[Exceedance]:
    """Named exceedances of the gate, shipped as data."""
    text = resources.files("compare").joinpath("references", "known_exceedances.toml").read_text(encoding="utf-8")
    return [Exceedance(**row) for row in tomllib.loads(text).get("row", [])]


@dataclass(frozen=True)
class GatePoint:
    """Error of one contact: per cent of its own reference load (of the mean where the load is small), the reference's
    uncertainty in the same per cent, and whether the gate allows it."""

    scene: str
    ball: int
    side: str
    error_percent: float
    uncertainty_percent: float
    exceeds: bool


def gate_points(scene: Scene, found: Reference, max_error: float) -> list[GatePoint]:
    """Every loaded contact of the reference against the ``lin`` model."""
    load = timed(scene, "lin")[0].load
    mean = float(found.load[found.load > 0.0].mean())
    points = []
    for i, s in zip(*np.nonzero((found.load > 0.0) | (load > 0.0)), strict=True):
        own = float(found.load[i, s])
        scale = own if own >= SMALL * mean else mean
        error = float(error_percent(load[i, s], own, scale))
        bar = 0.0 if found.uncertainty is None else float(error_percent(found.uncertainty[i, s], 0.0, scale))
        points.append(
            GatePoint(scene.name, int(i) + 1, SIDES[int(s)], error, bar, abs(error) - bar > max_error)
        )
    return points


def summary(scene: Scene, model: str, found: Reference) -> tuple[LoadError, StaticResult, float]:
    """Errors of a model against the reference, its result and seconds."""
    result, seconds = timed(scene, model)
    return load_error(result.load, found.load), result, seconds


def stores(extra: Path | None) -> Sequence[Path]:
    """Where to look for runs besides the shipped ones."""
    return (extra,) if extra is not None else ()
