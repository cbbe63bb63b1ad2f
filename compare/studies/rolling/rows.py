"""Low-order against 3D against printed, with the 3D model's own uncertainty, for scenes of rolling balls; their gate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.gate.gate import GateRow
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry
from rollbench.compare.reference.body_names import HALF_SPACE
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.catalogue import case as shipped_case
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.rolling.body_sizes import choices_share
from rollbench.compare.studies.rolling.low_order import low_order
from rollbench.compare.studies.rolling.runs import LEVELS, RollingRun, load

#: Factor on the scatter of the grids, as grid convergence indices have it for three grids.
SAFETY = 1.25
#: Printed numbers of both sides by scene: (table, low-order entry, ANSYS entry) of the ball-to-ball force.
PRINTED = {
    "lin-pair-a": ("lin-3.5", "a_force_numerical", "a_force_ansys"),
    "lin-pair-b": ("lin-3.5", "b_force_numerical", "b_force_ansys"),
    "lin-screw-pair-a": ("lin-3.7", "force_a", "ansys_a"),
    "lin-screw-pair-a-inferred": ("lin-3.7", "force_a", "ansys_a"),
    "lin-screw-pair-b": ("lin-3.7", "force_b", "ansys_b"),
    "lin-screw-pair-b-inferred": ("lin-3.7", "force_b", "ansys_b"),
}
#: Scenes of the report and the gate: those of Tables 3.5 and 3.7, and the rotary ball of 3.2.2.
PAIRS = tuple(PRINTED)
RINGS = ("lin-rotary-1", "lin-rotary-2", "lin-rotary-3")
#: Limit [%] of the low-order model against 3D where the load state is the same.
LIMIT = 2.0
#: Value of either model, in the unit of its name, below which it is round-off.
ROUND_OFF = 1e-6
#: Quantities that are gated, and where the low-order model is beyond the limit, and why.
GATED = ("force 1-2", "torque")
KNOWN = {
    ("lin-rotary-1", "torque"): "two contacts only: the one that rigid bodies let stick creeps by its elasticity, and "
    "both share the ball's spin"
}


@dataclass(frozen=True)
class RollingRow:
    """One quantity of one scene: low-order, 3D and its uncertainty, printed low-order and ANSYS values (None: none),
    error of the low-order model against 3D [%] and that uncertainty [%] (None: of nothing); orders of the grids'
    differences are in the mesh study. ablation: elastic bodies on flat contacts; rigid bodies on curved ones; half spaces
    beside finite bodies on the finest grid (None: not solved beside these); load_state: "plain" or "inferred" where the
    source does not print it, else None; low_seconds are of now, seconds were measured with what measured_with says."""

    scene: str
    quantity: str
    unit: str
    low: float | None
    reference: float
    uncertainty: float
    printed: float | None
    printed_ansys: float | None
    flat: float
    rigid: float
    error_percent: float | None
    uncertainty_percent: float | None
    low_seconds: float
    seconds: float
    half_space: float | None = None
    load_state: str | None = None
    measured_with: str = ""

    def as_json(self) -> dict[str, Any]:
        """JSON-ready."""
        return asdict(self)


def split(name: str) -> tuple[str, str]:
    """Quantity and unit of a name."""
    for unit in ("N mm", "rad/s", "mW", "N", "%"):
        if name.endswith(f" {unit}"):
            return name.removesuffix(f" {unit}"), unit
    raise KeyError(name)


#: What the uncertainty of a scene does not hold whose load state is not printed.
UNSTATED = ": +- is the scatter of the grids and holds nothing of what that reading of the load leaves open"


def load_state(name: str) -> str | None:
    """ "plain" or "inferred" of a scene of Table 3.7, which does not print its load state; None of others."""
    table = PRINTED.get(name.removesuffix(".toml"))
    if table is None or table[0] != "lin-3.7":
        return None
    return "inferred" if name.removesuffix(".toml").endswith("-inferred") else "plain"


def uncertainty(runs: Sequence[RollingRun], name: str) -> float:
    """Scatter of the grids about the finest, by `SAFETY`, and the difference of the limit's quadratures; inf of one
    grid."""
    values = [r.values[name] for r in runs]
    if len(values) < 2:
        return float("inf")
    return SAFETY * max(abs(v - values[-1]) for v in values[:-1]) + runs[-1].limit_spread[name]


def rows(scene: KindScene, runs: Sequence[RollingRun], beside: RollingRun | None = None) -> list[RollingRow]:
    """Rows of a scene from runs of rising level, the last one the reference.

    beside: half spaces on its grid, where the runs are of finite bodies; their choices then count as uncertainty.
    """
    low, low_seconds, _ = low_order(scene)
    finest = runs[-1]
    table = PRINTED.get(scene.name.removesuffix(".toml"))
    by_bodies = 0.0 if beside is None else choices_share("linear" in scene.kind)
    out = []
    for name, value in finest.values.items():
        quantity, unit = split(name)
        total_uncertainty = uncertainty(runs, name) + by_bodies * abs(value)
        printed = ansys = None
        if table is not None and quantity == "force 1-2":
            printed, ansys = (entry(table[0], key).value for key in table[1:])
        error = float(error_percent(low[name], value)) if name in low else np.nan
        share = float(error_percent(value + total_uncertainty, value))
        if max(abs(value), abs(low.get(name, value))) < ROUND_OFF:  # both are nothing
            error, share = 0.0, np.nan
        flat = value + finest.flat[name] - finest.elastic[name]
        out.append(
            RollingRow(
                scene.name,
                quantity,
                unit,
                low.get(name),
                value,
                total_uncertainty,
                printed,
                ansys,
                flat,
                finest.limit[name],
                error if np.isfinite(error) else None,
                share if np.isfinite(share) else None,
                low_seconds,
                finest.seconds,
                None if beside is None else beside.values[name],
                load_state(scene.name),
                str(finest.measured),
            )
        )
    return out


def within(row: RollingRow) -> bool:
    """Whether the low-order model is within `LIMIT` of 3D, the uncertainty deducted up to the limit itself."""
    if row.error_percent is None:
        return row.low == row.reference or (row.low is not None and abs(row.low - row.reference) <= row.uncertainty + 1e-9)
    return abs(row.error_percent) - min(row.uncertainty_percent or 0.0, LIMIT) <= LIMIT


def stored_rows(name: str, stores: Sequence[Path], bodies: str = HALF_SPACE) -> list[RollingRow]:
    """Rows of a shipped scene from the stored runs of all levels; none where one is missing."""
    scene = shipped_case(name, KindScene)
    found = [load(scene, level, stores, bodies) for level in LEVELS]
    runs = [run for run in found if run is not None and run.converged]
    beside = None if bodies == HALF_SPACE else load(scene, max(LEVELS), stores)
    return rows(scene, runs, beside) if len(runs) == len(LEVELS) else []


# --- rows of the gate on rolling: low-order balls against the 3D model's


def rolling_rows(study: Study, max_error: float) -> list[GateRow]:
    """Low-order balls in motion against the stored runs of the 3D model of rolling: ball-to-ball forces and torques.

    A quantity beyond the line passes where the list of known ones names it with its cause, and fails where it names one
    that is not.
    """
    out: list[GateRow] = []
    stores = study.stores or (shipped_store(),)
    limit = min(LIMIT, max_error)
    for name in (*PAIRS, *RINGS):
        rows = [row for row in stored_rows(name, stores) if row.quantity in GATED]
        if not rows:
            text = f"no stored runs of the 3D model of rolling: run rollbench mesh-study {name}"
            out.append(GateRow(f"{name}: 3D rolling", "3D rolling", None, None, None, limit, False, text))
        for row in rows:
            cause = KNOWN.get((name, row.quantity), "")
            passed = within(row) != bool(cause)
            state = f", {row.load_state} load state" if row.load_state else ""
            label = f"{name}: {row.quantity} [{row.unit}] against 3D rolling{state}" + (
                f" (known: {cause})" if cause else ""
            )
            text = f"uncertainty of the 3D model {row.uncertainty:.2g} {row.unit}"
            out.append(GateRow(label, "3D rolling", row.low, row.reference, row.error_percent, limit, passed, text))
    return out
