"""A user's own reference: measured loads, or those of another 3D program, in the place of this project's."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.gate.given_files import EVERY, GivenLoads, Only, comma_or, read_loads
from rollbench.compare.gate.judged import OF_CONTACTS
from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import gate_points
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.grid_parts import GridParts
from rollbench.compare.reference.store import Run
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.units import parse

#: Notes above the table.
UNCERTAINTY, PROVENANCE = "uncertainty", "provenance"


def read_reference(
    path: Path, scene: Scene, only: Only = EVERY, contacts: int | None = None
) -> tuple[Reference, tuple[str, ...]]:
    """The reference of a file with the columns of `given_files`, of every flank; headings that nothing is known of. only:
    rows that are read; contacts: how many the nominal screw loads, where the scene itself does not tell.

    Its uncertainty is a column (``uncertainty_N``, or ``uncertainty_percent`` of each load), or one note above the table,
    ``# uncertainty: 0.5 %`` of the mean load or ``2 N``; zero without, which is said. Raises InputError.
    """
    given = read_loads(path, scene.ball_count, scene, only)
    left = [side for side in SIDES if side not in given.flanks]
    if left:
        advice = "write 0 for contacts that carry nothing: what is not known cannot judge"
        raise InputError(str(path), "rows", f"no loads on {', '.join(left)}", "every ball on SL, SR, NL and NR", advice)
    if not given.load.any():
        raise InputError(str(path), "file", "no loads but zero", "a load", "is this the scene's reference?")
    contacts = nominal_contacts(scene) if contacts is None else contacts
    bars, words = _uncertainty(path, given, mean_load(given.load, contacts))
    source = given.notes.get(PROVENANCE, "")
    stated = f"against {path.name}{f' ({source})' if source else ''}, {words}"
    angle = np.degrees(given.further.get("angle", np.full(given.load.shape, np.nan)))
    further = {q.name: given.further[name] for name, q in OF_CONTACTS.items() if name in given.further}
    share = float(error_percent(bars.max(), 0.0, mean_load(given.load, contacts)))
    parts = GridParts(share)
    run = _as_run(scene, given.load, angle)
    label = re.sub(r"\s+", " ", path.name)
    return Reference(scene.name, (run,), given.load, bars, parts, contacts, label, stated, further), given.unknown


def exceeding(ref: Reference, limit: float) -> str:
    """A warning where a reference is more uncertain than the limit [%] that it should judge; empty where it is not."""
    worst = max(gate_points(ref.scene, ref, limit, ref.load), key=lambda p: p.uncertainty_percent)
    if worst.uncertainty_percent <= limit:
        return ""
    return (
        f"the uncertainty of {ref.label}, {worst.uncertainty_percent:.3g} % at ball {worst.ball} {worst.side}, exceeds "
        f"the limit of {limit:g} % that it should judge"
    )


def _uncertainty(path: Path, given: GivenLoads, mean: float) -> tuple[Array, str]:
    """Uncertainty of every contact [N], and what is said of it."""
    on = given.load > 0.0
    stated = [name for name in ("uncertainty", "uncertain share") if name in given.further]
    note = given.notes.get(UNCERTAINTY)
    if len(stated) + (note is not None) > 1:
        allowed = "one column or one note"
        raise InputError(str(path), "uncertainty", "several", allowed, "leave the others out")
    if stated:
        values = given.further[stated[0]] * (given.load if stated[0] == "uncertain share" else 1.0)
        gaps = np.argwhere(np.isnan(values) & on)
        if gaps.size:
            value = f"none of ball {gaps[0][0] + 1} {SIDES[gaps[0][1]]}"
            raise InputError(str(path), "uncertainty", value, "one of every loaded contact", "fill the column, or drop it")
        return np.nan_to_num(values), "with its uncertainty contact by contact"
    if note is None:
        return np.zeros_like(given.load), "whose uncertainty is taken as zero: it states none"
    share = re.fullmatch(r"([0-9.eE+-]+)\s*(?:%|percent)", note)
    try:
        size = 0.01 * float(share[1]) * mean if share else parse(note, "force")
    except ValueError:  # a UnitError too
        size = float("nan")
    if not 0.0 <= size < float("inf"):
        allowed = "0.5 % (of the mean load), or a force such as 2 N"
        advice = comma_or("or write a column uncertainty_N", note)
        raise InputError(str(path), f"note {UNCERTAINTY}", note or "nothing", allowed, advice)
    return np.full(given.load.shape, size), f"uncertain by {note}{' of the mean load' if share else ''}"


def _as_run(scene: Scene, load: Array, angle: Array) -> Run:
    """A run without mesh: loads [N] and angles [deg]."""
    return Run(
        scene=scene.name,
        level=0,
        variant="",
        status="converged",
        load=load,
        angle=np.where(load > 0.0, angle, np.nan),
        frozen=load,
        centreline=np.zeros((0, 4)),
        without={},
        without_seconds={},
        sides=tuple(range(4)),
        unknowns=0,
        stages={},
        solve_seconds=0.0,
        peak_MB=None,
        balance=0.0,
        along_groove=0.0,
        screw_balance=0.0,
        quality={},
        settings={},
        assumed=(),
        versions={},
        date="",
    )
