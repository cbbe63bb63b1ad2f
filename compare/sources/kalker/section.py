"""Rolling in 3D in the report: verification, Tables 3.5 and 3.7 beside low-order and 3D, the rotary ball, runs from
rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.body_names import FINITE
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.scenes.catalogue import shipped
from rollbench.comparison.scenes.kinds import KindScene
from rollbench.comparison.sources.kalker.proof import AS_RUNS, BY_GRID, RESOLVED, Proof, proofs
from rollbench.comparison.system import gmsh_fault
from rollbench.comparison.wings.rolling.body_sizes import NAMES
from rollbench.comparison.wings.rolling.changes import Change, changes
from rollbench.comparison.wings.rolling.from_rest import GAP, Series, from_rest
from rollbench.comparison.wings.rolling.kept_sizes import Sizes
from rollbench.comparison.wings.rolling.kept_sizes import sizes as body_sizes
from rollbench.comparison.wings.rolling.patches import PatchField, fields
from rollbench.comparison.wings.rolling.rows import KNOWN, LIMIT, PAIRS, RINGS, RollingRow, load_state, stored_rows, within
from rollbench.comparison.wings.rolling.runs import LEVELS, SOURCE_LEVEL, RollingRun, load
from rollbench.reports.records import Column, Figure, Panel, PressureMap, PressurePanel, Section, Table, Text
from rollbench.reports.records import Series as Curve

PROOF = (
    Column("case", "case", "", "s"),
    Column("quantity", "quantity", "", "s"),
    Column("coarse", "coarse grid", "", "g5"),
    Column("middle", "middle grid", "", "g5"),
    Column("fine", "fine grid", "", "g5"),
    Column("exact", "exact or printed", "", "g5"),
    Column("error", "error of the answer", "%", ".2f"),
    Column("order", "order", "", ".1f"),
    Column("reach", "to reach", "%", "g3"),
    Column("verdict", "verdict", "", "s"),
)
COMPARISON = (
    Column("scene", "scene", "", "s"),
    Column("state", "load state", "", "s"),
    Column("quantity", "quantity", "", "s"),
    Column("unit", "unit", "", "s"),
    Column("low", "low-order", "", "g5"),
    Column("reference", "3D", "", "g5"),
    Column("uncertainty", "+-", "", "g2"),
    Column("error", "low-order against 3D", "%", ".2f"),
    Column("share", "+-", "%", ".2f"),
    Column("printed", "printed low-order", "", "g4"),
    Column("ansys", "printed ANSYS", "", "g4"),
    Column("flat", "3D, flat contacts", "", "g5"),
    Column("rigid", "rigid limit", "", "g5"),
    Column("ms", "low-order", "ms", "g3"),
    Column("seconds", "3D", "s", "g3"),
    Column("verdict", "verdict", "", "s"),
)
GRIDS = (
    Column("scene", "scene", "", "s"),
    Column("state", "load state", "", "s"),
    Column("level", "level", "", "s"),
    Column("cells", "cells", "", "s"),
    Column("value", "force or torque", "", "g5"),
    Column("alone", "by the grid alone", "", "g5"),
    Column("elasticity", "change by elasticity", "", "g3"),
    Column("lost", "power lost by differences", "%", ".3f"),
    Column("stick", "cells that stick", "", "d"),
    Column("seconds", "processor time", "s", "g3"),
)
BODIES = (
    Column("scene", "scene", "", "s"),
    Column("quantity", "quantity", "", "s"),
    Column("unit", "unit", "", "s"),
    Column("rigid", "rigid bodies", "", "g5"),
    Column("half", "half spaces", "", "g5"),
    Column("finite", "finite bodies", "", "g5"),
    Column("uncertainty", "+-", "", "g2"),
    Column("change", "change by finite bodies", "%", ".3f"),
    Column("error", "low-order against finite bodies", "%", ".2f"),
)
SIZES = (Column("choice", "choice", "", "s"), *(Column(name, name, "", "g6") for name in NAMES))
REST = (
    Column("steps", "steps", "", "d"),
    Column("force", "force at the end", "N", "g5"),
    Column("steady", "steady", "N", "g5"),
    Column("error", "error", "%", ".2f"),
    Column("meet", "balls meet at", "ms", ".1f"),
    Column("seconds", "processor time", "s", "g3"),
)
CHOICES = (
    Column("scene", "scene", "", "s"),
    Column("choice", "choice", "", "s"),
    Column("tried", "tried", "", "s"),
    Column("change", "largest change of the force", "%", "g2"),
    Column("uncertainty", "stated uncertainty", "%", "g2"),
    Column("verdict", "verdict", "", "s"),
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report. Runs of scenes come from the stores; the report says which are missing."""
    stores = study.stores or (shipped_store(),)
    step("rolling contacts with known answers")
    meshing = not gmsh_fault()
    proof = proofs(meshing=meshing)
    found = {name: stored_rows(name, stores) for name in (*PAIRS, *RINGS)}
    study.uses([name for name, own in found.items() if own])
    step("linear bearing from rest")
    series = from_rest()
    step("slip and traction; finite bodies of other sizes")
    left = "Left out of a quick report." if study.quick else "" if meshing else "Left out: gmsh cannot be loaded."
    sizes = Sizes((), left) if left else body_sizes(stores, fresh=study.timed)
    patches = fields()
    step("other grids, steps and paths")
    changed = changes(stores, series, sizes.variants)
    missing = [name for name, own in found.items() if not own]
    items: list[Text | Table | Figure | PressureMap] = [
        Text(_words(found, proof)),
        Table("rolling-verification", "Contacts with known answers on three grids", PROOF, [_proof(p) for p in proof]),
        Table(
            "rolling-pairs",
            "Two balls: Tables 3.5 and 3.7, low-order against 3D",
            COMPARISON,
            [_compared(row) for name in PAIRS for row in found[name]],
            "3D: elastic half spaces; its uncertainty is the scatter of three grids. Plain and inferred readings of the "
            "load state, which Table 3.7 does not print, are scenes of their own; the uncertainty of either holds "
            "nothing of what that reading leaves open." + (f" No stored runs: {', '.join(missing)}." if missing else ""),
        ),
        Table(
            "rolling-ring",
            "One ball of a rotary bearing: low-order against 3D",
            COMPARISON,
            [_compared(row) for name in RINGS for row in found[name]],
        ),
        *_finite(stores, sizes, proof),
        *_maps(patches),
        Table("rolling-grids", "What the grids do", GRIDS, _grid_rows(stores)),
        Table("rolling-from-rest", "Linear bearing, case (a), from rest", REST, [_rest(s) for s in series]),
        _figure(series),
        Table(
            "rolling-choices",
            "Ball-to-ball force when a numerical choice changes",
            CHOICES,
            [_choice(c) for c in changed],
            "The grid is finer than all behind the uncertainty; that of finite bodies holds their own choices. Runs from "
            "rest are compared with steady rolling on their grid.",
        ),
    ]
    times = _times(stores)
    if times is not None:
        items.append(times)
    return Section("rolling", "Rolling in 3D: balls that touch", items, _headline(found))


def _finite(stores: Sequence[Path], sizes: Sizes, proof: Sequence[Proof]) -> list[Text | Table | Figure | PressureMap]:
    """What finite bodies change, and how far that depends on the choices behind them."""
    found = {name: stored_rows(name, stores, FINITE) for name in (*PAIRS, *RINGS)}
    missing = [name for name, own in found.items() if not own]
    shown = [row for own in found.values() for row in own if row.half_space is not None]
    changes = [abs(c) for row in shown if row.quantity in ("force 1-2", "torque") and (c := _change(row)) is not None]
    rub = max(abs(p.error) for p in proof if p.case.startswith("balls that touch"))
    most = f" They change forces and torques by up to {max(changes):.2f} %." if changes else ""
    return [
        Text(
            [
                "Finite bodies, normal and along tangents: on rings and screws the static reference's patches of groove "
                "and ball in pieces of their bodies, on straight rails, which it has none of, a whole ball and grooved "
                "bars of the same elements. What they answer beyond a half space of the same cells is a smooth kernel, "
                "added to the closed form of half spaces. Without motion they press as the static reference's patches do "
                "(first rows of the verification). Left out: balls that touch do so at a point. Over Hertz's circle and "
                "over the patch of two finite balls, all of which slides, force and loss of that friction are the same to "
                f"{rub:.2g} % (verification), whatever the elasticity. "
                "The kernel changes the pressure, adds a strain by the normal forces that half spaces of one material do "
                "not have, and the ball rolls on a radius shortened by half of the approach. Contact forces are the same, "
                "by Hertz's law; contacts of one ball do not feel one another, and friction does not change pressures."
                + most
            ]
        ),
        Table(
            "rolling-bodies",
            "What finite bodies change",
            BODIES,
            [_beside(row) for row in shown],
            "Uncertainty: scatter of three grids, and the largest change of a force or loss by a choice in the next table."
            + (f" No stored runs: {', '.join(missing)}." if missing else ""),
        ),
        Table(
            "rolling-body-sizes",
            "Two balls: sizes and meshes of finite bodies",
            SIZES,
            [{"choice": v.choice, **v.values} for v in sizes.variants],
            f"All on one grid of the contacts. {sizes.words}",
        ),
    ]


def _change(row: RollingRow) -> float | None:
    change = None if row.half_space is None else float(error_percent(row.reference, row.half_space))
    return change if change is not None and np.isfinite(change) and row.error_percent != 0.0 else None


def _beside(row: RollingRow) -> dict[str, str | float | None]:
    finite = np.isfinite(row.uncertainty)
    return {
        "scene": row.scene,
        "quantity": row.quantity,
        "unit": row.unit,
        "rigid": row.rigid,
        "half": row.half_space,
        "finite": row.reference,
        "uncertainty": row.uncertainty if finite else None,
        "change": _change(row),
        "error": row.error_percent,
    }


def _maps(patches: Sequence[PatchField]) -> list[Text | Table | Figure | PressureMap]:
    """Slip, and traction with the cells that stick."""

    def panel(p: PatchField, what: NDArray[np.float64], unit_of: float, note: str, *, marked: bool) -> PressurePanel:
        size = np.linalg.norm(what, axis=1)
        unit = what / np.maximum(size, 1e-300)[:, None]
        x, y = (1e6 * p.at).T
        ellipse = (0.0, 0.0, 1e6 * p.semi[0], 1e6 * p.semi[1])
        arrows = (unit[:, 0].tolist(), unit[:, 1].tolist())
        stick = p.stick.tolist() if marked and p.stick.any() else None
        return PressurePanel(p.title, x, y, size / unit_of, ellipse, note, arrows, 5, stick)

    axes = ("across the groove [um]", "along [um]")
    fastest = [float(np.linalg.norm(p.slip, axis=1).max()) for p in patches]
    sticking = [f"{int(p.stick.sum())} of {len(p.stick)} cells stick" for p in patches]
    return [
        PressureMap(
            "rolling-slip",
            "Slip in the contacts",
            [
                panel(p, p.slip, most, f"largest: {100.0 * most:.3g} % of the rolling speed", marked=False)
                for p, most in zip(patches, fastest, strict=True)
            ],
            *axes,
            "slip over the contact's largest",
            caption="Two contacts of the first ball of the linear pair, and the ball of a ring in two-point contact. "
            "Material flows downwards.",
        ),
        PressureMap(
            "rolling-traction",
            "Tangential traction and stick zones",
            [panel(p, p.traction, 1e6, note, marked=True) for p, note in zip(patches, sticking, strict=True)],
            *axes,
            "tangential traction on the ball [MPa]",
            marked_label="sticks",
            caption="Where traction is below mu p, ball and groove stick.",
        ),
    ]


def _headline(found: dict[str, list[RollingRow]]) -> tuple[tuple[str, str], ...]:
    row = next((r for r in found["lin-pair-a"] if r.quantity == "force 1-2"), None)
    if row is None or row.error_percent is None:
        return ()
    return (("ball-to-ball force, low-order against 3D", f"{row.error_percent:+.2f} %"),)


def _words(found: dict[str, list[RollingRow]], proof: Sequence[Proof]) -> list[str]:
    """What the tables say."""
    reached = sum(p.reached for p in proof)
    gated = [r for own in found.values() for r in own if r.quantity in ("force 1-2", "torque")]
    beyond = [r for r in gated if not within(r)]
    out = [
        "The 3D model of rolling solves normal and tangential contact of elastic bodies on a grid in every contact. "
        "Coulomb's law holds in every cell to round-off, elastic displacements are carried along by the material, and each "
        "ball moves so that its forces and moments balance. Bodies are elastic half spaces, beside them finite ones. "
        "What a grid does to rigid bodies too, by its cells, its staircase edge and a spin pole inside a cell, is taken "
        "out by nearly rigid bodies on the same grid and the rigid limit by quadrature.",
        f"{reached} of {len(proof)} known answers are met as closely as was to be reached.{_pole(proof)}",
    ]
    if gated:
        causes = {(r.scene, r.quantity): KNOWN.get((r.scene, r.quantity), "cause unknown") for r in beyond}
        names = "; ".join(f"{scene}, {what}: {cause}" for (scene, what), cause in causes.items())
        out.append(
            f"{len(gated) - len(beyond)} of {len(gated)} ball-to-ball forces and torques of the low-order models are "
            f"within {LIMIT:g} % of 3D" + (f"; beyond it: {names}." if beyond else ".")
        )
    return out


def _pole(proof: Sequence[Proof]) -> str:
    """What a spin pole inside a cell does, and what takes it out; nothing where that was not computed."""
    worst = [
        max((abs(p.error) for p in proof if p.case == f"full slip {way}, pole inside"), default=np.nan)
        for way in (BY_GRID, RESOLVED, AS_RUNS)
    ]
    if not np.isfinite(worst).all():
        return ""
    alone, resolved, differenced = worst
    return (
        f" Where all slips about a pole inside a cell, a grid alone is off by {alone:.2g} %. The cause is the slip's turn "
        f"within cells: with that resolved, the staircase edge leaves {resolved:.2g} %. Differenced as runs are, every "
        f"level is within {differenced:.2g} %."
    )


def _proof(p: Proof) -> dict[str, str | float | None]:
    return {
        "case": p.case,
        "quantity": p.quantity,
        "coarse": p.values[0],
        "middle": p.values[1],
        "fine": p.values[2],
        "exact": p.exact,
        "error": p.error,
        "order": p.order,
        "reach": p.reach,
        "verdict": "reached" if p.reached else "not reached",
    }


def _compared(row: RollingRow) -> dict[str, str | float | None]:
    finite = np.isfinite(row.uncertainty)
    return {
        "scene": row.scene,
        "state": row.load_state,
        "quantity": row.quantity,
        "unit": row.unit,
        "low": row.low,
        "reference": row.reference,
        "uncertainty": row.uncertainty if finite else None,
        "error": row.error_percent,
        "share": row.uncertainty_percent,
        "printed": row.printed,
        "ansys": row.printed_ansys,
        "flat": row.flat,
        "rigid": row.rigid,
        "ms": 1e3 * row.low_seconds,
        "seconds": row.seconds,
        "verdict": f"within {LIMIT:g} %" if within(row) else f"beyond {LIMIT:g} %",
    }


def _runs(name: str, stores: Sequence[Path]) -> list[RollingRun]:
    scene = shipped(name)
    assert isinstance(scene, KindScene)
    found = (load(scene, level, stores) for level in (SOURCE_LEVEL, *LEVELS))
    return [run for run in found if run is not None]


def _grid_rows(stores: Sequence[Path]) -> list[dict[str, str | float | int | None]]:
    out: list[dict[str, str | float | int | None]] = []
    for name in (*PAIRS, *RINGS):
        for run in _runs(name, stores):
            key = next(k for k in run.elastic if k.startswith(("force", "torque")))
            out.append(
                {
                    "scene": name,
                    "state": load_state(name),
                    "level": "source's size" if run.level == SOURCE_LEVEL else str(run.level),
                    "cells": f"{run.shape[0]} x {run.shape[1]}",
                    "value": run.values[key],
                    "alone": run.elastic[key],
                    "elasticity": run.elastic[key] - run.near_rigid[key],
                    "lost": 100.0 * run.upwind,
                    "stick": run.sticking,
                    "seconds": run.seconds,
                }
            )
    return out


def _rest(s: Series) -> dict[str, float | int | None]:
    meet = next((t for t, f in zip(s.time, s.force, strict=True) if f > 0.0), None)
    return {
        "steps": s.steps,
        "force": s.force[-1],
        "steady": s.steady,
        "error": float(error_percent(s.force[-1], s.steady)),
        "meet": None if meet is None else 1e3 * meet,
        "seconds": s.seconds,
    }


def _choice(c: Change) -> dict[str, str | float | None]:
    return {
        "scene": c.scene,
        "choice": c.choice,
        "tried": c.tried,
        "change": c.change,
        "uncertainty": c.uncertainty,
        "verdict": "within" if c.within else "beyond",
    }


def _figure(series: Sequence[Series]) -> Figure:
    forces = [Curve(f"{s.steps} steps", [1e3 * t for t in s.time], s.force) for s in series]
    last = series[-1]
    time = [1e3 * t for t in last.time]
    speeds = [Curve(f"ball {k + 1}", time, [1e3 * v[k] for v in last.speed], "line") for k in range(2)]
    return Figure(
        "rolling-from-rest",
        f"Linear bearing, case (a): two balls begin to roll {1e6 * GAP:g} um apart",
        [
            Panel("ball-to-ball force", "time [ms]", "force [N]", forces, zero=True),
            Panel(f"speed of the balls, {last.steps} steps", "time [ms]", "speed [mm/s]", speeds),
        ],
        f"The source ran {series[0].steps} steps.",
    )


def _times(stores: Sequence[Path]) -> Figure | None:
    """Error of a grid against the finest one, over its processor time."""
    curves = []
    for name in PAIRS:
        runs = [r for r in _runs(name, stores) if r.level != SOURCE_LEVEL]
        if len(runs) < len(LEVELS) or not runs[-1].values["force 1-2 N"] > 0.0:
            continue
        top = runs[-1].values["force 1-2 N"]
        errors = [max(abs(float(error_percent(r.values["force 1-2 N"], top))), 1e-3) for r in runs[:-1]]
        curves.append(Curve(name, [r.seconds for r in runs[:-1]], errors))
    if not curves:
        return None
    panel = Panel("ball-to-ball force", "processor time [s]", "difference from the finest grid [%]", curves, log="xy")
    return Figure("rolling-times", "Error against run time of the 3D model of rolling", [panel])
