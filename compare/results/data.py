"""What `rollbench.friction`, `ensemble`, `mesh_study`, `sweep` and `report` give: records of what their commands answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rollbench.compare.results.base import JSON, Record, with_schema


@dataclass(frozen=True, eq=False, repr=False)
class Data(Record):
    """A result with the JSON that its command prints."""

    values: Mapping[str, JSON]
    """The JSON without its version."""
    shown: str = ""
    """Path in it of what tables show; empty: all."""
    notes: tuple[str, ...] = ()
    """Sentences below tables."""

    def to_dict(self) -> dict[str, JSON]:
        """The JSON, its version first."""
        return with_schema(self.values)

    @property
    def _shown(self) -> str:
        return self.shown

    @property
    def _notes(self) -> tuple[str, ...]:
        return self.notes

    def __repr__(self) -> str:
        """The first five lines of the table."""
        return "\n".join(str(self).splitlines()[:5])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Friction(Data):
    """Friction of a scene. A field is None where its kind of scene has no such answer, and without convergence."""

    scene: str
    """Name of the scene."""
    kind: str
    """Kind of the scene: ball screw, bearing, or what only friction solves; empty of load cases."""
    converged: bool
    """Whether loads and friction balance."""
    reason: str
    """Status in words."""
    torque: float | None = None
    """Friction torque [N m]."""
    drag_torque: float | None = None
    """Friction torque [N m] without the loads of the scene, by its preload."""
    forward_torque: float | None = None
    """Torque that drives the screw against its axial load [N m]."""
    backward_torque: float | None = None
    """Torque that holds the screw with its axial load [N m]."""
    efficiency_forward: float | None = None
    """Work on the load over work of the torque, driven against the load [1]."""
    efficiency_backward: float | None = None
    """Work of the torque over work of the load, driven by the load [1]."""
    self_locking: bool | None = None
    """Whether friction holds the load without a torque."""
    loss: float | None = None
    """Loss in all contacts [W]."""
    warnings: tuple[str, ...] = ()
    """Where answers leave what the models mean."""
    cases: Mapping[str, Friction] = field(default_factory=dict)
    """Load cases by name; empty without."""


def friction_of(data: Mapping[str, Any]) -> Friction:
    """The record of what ``rollbench friction`` answers."""
    torque, losses = data.get("torque") or {}, data.get("losses") or {}
    converged = bool(data.get("converged"))

    def known(group: Mapping[str, Any], key: str, factor: float) -> float | None:
        value = group.get(key) if converged else None
        return None if value is None else factor * float(value)

    loss = known(losses, "total_W", 1.0)
    return Friction(
        values=data,
        shown="torque" if torque else "",
        notes=tuple(data.get("warnings", ())),
        scene=str(data["scene"]),
        kind=str(data.get("kind", "")),
        converged=converged,
        reason=str(data["status"]),
        torque=known(torque, "friction_torque_Nmm", 1e-3),
        drag_torque=known(torque, "drag_torque_Nmm", 1e-3),
        forward_torque=known(torque, "forward_torque_Nmm", 1e-3),
        backward_torque=known(torque, "backward_torque_Nmm", 1e-3),
        efficiency_forward=known(torque, "efficiency_forward_percent", 1e-2),
        efficiency_backward=known(torque, "efficiency_backward_percent", 1e-2),
        self_locking=torque.get("self_locking") if converged else None,
        loss=known(data.get("energy") or {}, "loss_W", 1.0) if loss is None else loss,
        warnings=tuple(map(str, data.get("warnings", ()))),
        cases={str(one["case"]): friction_of(one) for one in data.get("cases", ())},
    )


@dataclass(frozen=True)
class MeshLevel:
    """One mesh level of a study."""

    level: int
    """Number, from 1, the coarsest."""
    cell_size: float
    """Size of its cells over that of the finest level [1]."""
    unknowns: int
    """Unknowns of the mesh as one."""
    seconds: float
    """Run time [s]."""
    difference: float
    """Largest difference of a contact load from the finest level [% of the mean contact load]."""
    enough_for: float
    """What contact loads are good for with this level and those before it [% of the mean contact load]."""


@dataclass(frozen=True)
class MeshQuantity:
    """One quantity of a mesh study."""

    name: str
    """What it is."""
    unit: str
    """Its unit."""
    values: tuple[float, ...]
    """On every level, coarsest first [unit]."""
    order: float | None
    """Observed order of convergence [1]; None where there is none (contact loads scatter from mesh to mesh)."""
    extrapolated: float | None
    """Value at cells of no size [unit]; None without order."""
    uncertainty: float | None
    """Uncertainty of the finest level's value [unit]; None of one level."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MeshStudy(Data):
    """The 3D reference on several mesh levels."""

    scene: str
    """Name of the scene."""
    levels: tuple[MeshLevel, ...] = ()
    """Levels, coarsest first; empty of several sets."""
    quantities: tuple[MeshQuantity, ...] = ()
    """What is followed from level to level; empty of several sets."""
    sets: Mapping[str, MeshStudy] = field(default_factory=dict)
    """Several sets on one shaft by name; empty of one."""


def mesh_study_of(data: Mapping[str, Any], shown: str = "", notes: Sequence[str] = ()) -> MeshStudy:
    """The record of what a mesh study finds."""
    rows = data.get("levels", ())
    levels = [
        MeshLevel(x["level"], x["cell_size"], x["unknowns"], x["seconds"], x["difference_percent"], x["enough_for_percent"])
        for x in rows
    ]
    quantities = [
        MeshQuantity(
            x["quantity"],
            x["unit"],
            tuple(x[f"level {row['level']}"] for row in rows),
            x.get("order"),
            x.get("extrapolated"),
            x.get("uncertainty"),
        )
        for x in data.get("quantities", ())
    ]
    return MeshStudy(
        values=data,
        shown=shown,
        notes=tuple(notes),
        scene=str(data["scene"]),
        levels=tuple(levels),
        quantities=tuple(quantities),
        sets={str(one["set"]): mesh_study_of(one, "levels") for one in data.get("sets", ())},
    )


@dataclass(frozen=True)
class Statistics:
    """An output over the samples of a sweep or the specimens of an ensemble, in the unit that its name ends with."""

    mean: float
    """Mean."""
    standard_error: float
    """Standard error of the mean."""
    standard_deviation: float
    """Standard deviation."""
    smallest: float
    """Smallest value."""
    largest: float
    """Largest value."""
    quantiles: Mapping[float, float]
    """Quantiles by share: 0.01, 0.05, 0.5, 0.95, 0.99."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Ensemble(Data):
    """Many specimens of a scene with random errors."""

    scene: str
    """Name of the scene."""
    members: int
    """How many specimens were solved; of load cases, of each."""
    converged: int
    """How many of them have an equilibrium; of load cases, the fewest."""
    outputs: Mapping[str, Statistics | None]
    """Outputs by name; None of those with less than two values. Empty of load cases."""
    failed: Mapping[int, str]
    """Why specimens have no equilibrium, by their number from 0. Empty of load cases."""
    sets: Mapping[str, Mapping[str, Statistics | None]]
    """The outputs of each of several sets by name; empty of one."""
    cases: Mapping[str, Ensemble]
    """Load cases by name; empty without."""


def ensemble_of(data: Mapping[str, Any]) -> Ensemble:
    """The record of what ``rollbench solve --members`` answers."""
    cases = {str(one["case"]): ensemble_of(one) for one in data.get("cases", ())}
    return Ensemble(
        values=data,
        shown="cases" if cases else "statistics",
        scene=str(data["scene"]),
        members=data["members"] if not cases else min(one.members for one in cases.values()),
        converged=data["converged"] if not cases else min(one.converged for one in cases.values()),
        outputs=_outputs(data.get("statistics", {})),
        failed={one["member"]: one["status"] for one in data.get("failed", ())},
        sets={one["name"]: _outputs(one["statistics"]) for one in data.get("sets", ())},
        cases=cases,
    )


def _outputs(each: Mapping[str, Any]) -> dict[str, Statistics | None]:
    return {name: None if x is None else _statistics(x) for name, x in each.items()}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Sweep(Data):
    """A scene solved at many values of its keys."""

    folder: Path
    """Where every sample stands (samples.csv), and the summary."""
    solved: int
    """How many samples were solved."""
    converged: int
    """How many of them have an equilibrium."""
    outputs: Mapping[str, Statistics | None]
    """Outputs by name; None of those with less than two values."""
    sobol: Mapping[str, Mapping[str, float]]
    """Total Sobol index of every key by output [1]; empty for other designs and too few samples, and without outputs that
    are constant."""


def sweep_of(data: Mapping[str, Any], folder: Path) -> Sweep:
    """The record of the summary of a sweep."""
    indices = data["indices"].get("outputs", {})
    return Sweep(
        values=data,
        shown="outputs",
        notes=(f"{data['converged']} of {data['solved']} samples converged: {folder}",),
        folder=folder,
        solved=data["solved"],
        converged=data["converged"],
        outputs=_outputs(data["outputs"]),
        sobol={name: {key: x["total"] for key, x in of.items()} for name, of in indices.items() if of is not None},
    )


def _statistics(x: Mapping[str, Any]) -> Statistics:
    quantiles = {float(k.removeprefix("quantile_")): v for k, v in x.items() if k.startswith("quantile_")}
    quantiles |= {float(one["level"]): one["value"] for one in x.get("quantiles", ())}
    names = ("mean", "standard_error", "standard_deviation", "smallest", "largest")
    numbers: dict[str, float] = {name: x[name] for name in names}
    return Statistics(**numbers, quantiles=quantiles)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Written(Data):
    """A report that was written."""

    page: Path
    """Its first page."""
    passed: bool
    """False where a run of the reference that was recomputed does not agree with the stored one."""
    verdict: str = ""
    """Of the page of a scene: its verdict in words."""
