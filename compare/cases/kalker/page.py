"""Page on rolling in 3D: verification, Tables 3.5 and 3.7 by low-order model and 3D, the rotary ball, runs from rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rollbench.compare.cases.kalker.evidence import AS_RUNS, BY_GRID, RESOLVED, Proof, proofs
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.reference.levels import FINITE
from rollbench.compare.reference.store import most_of, shipped_store
from rollbench.compare.running import gmsh_fault
from rollbench.compare.scenes.catalogue import case as shipped_case
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.rolling.cases import case_of
from rollbench.compare.studies.rolling.rows import (
    GAP,
    KNOWN,
    LIMIT,
    PAIRS,
    RINGS,
    ChoiceEffect,
    RollingRow,
    RunFromRest,
    effects_of_choices,
    is_within_limit,
    load_state,
    runs_from_rest,
    stored_rows,
)
from rollbench.compare.studies.rolling.runs import LEVELS, NAMES, SOURCE_LEVEL, RollingRun, StoredVariants, load_run
from rollbench.compare.studies.rolling.runs import find_body_variants as body_sizes
from rollbench.hifi.rolling.balls import Choices, ContactOut, hertz_size, solve_rolling
from rollbench.hifi.rolling.kinematics import Rolling, rolling_speed
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, PressureMap, PressurePanel, Quantity, Row, Section, Table, Text
from rollbench.reports.content import Series as Curve

SIZES = (Quantity("choice", "choice", "", "s"), *(Quantity(name, name, "", "g6") for name in NAMES))
#: Contacts shown: scene, ball, name of the contact.
SHOWN = (("lin-pair-a", 0, "BL"), ("lin-pair-a", 0, "TR"), ("lin-rotary-1", 0, "IL"), ("lin-rotary-1", 0, "OR"))
#: Grid of the contacts.
SHAPE = LEVELS[1]


@dataclass(frozen=True)
class PatchField:
    """Slip and traction of one contact."""

    #: Title.
    title: str
    #: Centres of cells across and along, (n, 2) [m].
    at: Array
    #: Slip over the rolling speed across and along, (n, 2).
    slip: Array
    #: Tangential traction across and along, (n, 2) [Pa].
    traction: Array
    #: Whether each cell sticks.
    stick: NDArray[np.bool_]
    #: Semi-axes across and along [m].
    semi: tuple[float, float]


@lru_cache(maxsize=1)
def fields() -> tuple[PatchField, ...]:
    """Return slip and traction of the contacts of `SHOWN`, with balls that touch each other, on half spaces."""
    choices, out = Choices(SHAPE), []
    for name in dict.fromkeys(shown[0] for shown in SHOWN):
        scene = shipped_case(name, KindScene)
        case = case_of(scene, choices)
        found = solve_rolling(case.touching, choices)
        for _, ball, contact in (s for s in SHOWN if s[0] == name):
            touch = case.contacts.index(contact)
            one = next(c for c in found.contacts if (c.ball, c.touch) == (ball, touch))
            out.append(_field(f"{name}, {contact}", case.touching, one))
    return tuple(out)


def _field(title: str, scene: Rolling, one: ContactOut) -> PatchField:
    """Return the fields of one contact, the axis across the groove first; slip relative to the rolling speed."""
    touch = scene.balls[one.ball].touches[one.touch]
    speed = rolling_speed(touch, scene)
    along, across = hertz_size(scene, touch)
    area = float(one.size.prod())
    turned = [1, 0]
    return PatchField(
        title, one.at[:, turned], one.slip[:, turned] / speed, one.tangential[:, turned] / area, one.stick, (across, along)
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report.

    Runs of scenes come from the stores; the report says which are missing.
    """
    stores = study.stores or (shipped_store(),)
    step("rolling contacts with known answers")
    meshing = not gmsh_fault()
    proof = proofs(meshing=meshing)
    found = {name: stored_rows(name, stores) for name in (*PAIRS, *RINGS)}
    study.uses([name for name, rows in found.items() if rows])
    step("linear bearing from rest")
    series = runs_from_rest()
    step("slip and traction; finite bodies of other sizes")
    left = "Left out of a quick report." if study.quick else "" if meshing else "Left out: gmsh cannot be loaded."
    sizes = StoredVariants((), left) if left else body_sizes(stores, fresh=study.timed)
    patches = fields()
    step("other grids, steps and paths")
    changed = effects_of_choices(stores, series, sizes.variants)
    missing = [name for name, rows in found.items() if not rows]
    items: list[Text | Table | Figure | PressureMap] = [
        Text(_words(found, proof)),
        Table.of(
            "rolling-verification",
            "Contacts with known answers on three grids",
            [_proof(p) for p in proof],
            "No order where an error is no smaller than on the grid before: it follows where cells lie.",
        ),
        Table.of(
            "rolling-pairs",
            "Two balls: Tables 3.5 and 3.7, low-order against 3D",
            [_compared(row) for name in PAIRS for row in found[name]],
            (
                "3D: elastic half spaces, with the scatter of three grids as uncertainty. Table 3.7 does not "
                "print its load state: the plain and the inferred reading are separate scenes, and the "
                "uncertainty of either does not include what that reading leaves open."
            )
            + (f" No stored runs: {', '.join(missing)}." if missing else ""),
        ),
        Table.of(
            "rolling-ring",
            "One ball of a rotary bearing: low-order against 3D",
            [_compared(row) for name in RINGS for row in found[name]],
        ),
        *_finite(stores, sizes, proof),
        *_maps(patches),
        Table.of("rolling-grids", "What the grids do", _grid_rows(stores)),
        Table.of("rolling-from-rest", "Linear bearing, case (a), from rest", [_rest(s) for s in series]),
        _figure(series),
        Table.of(
            "rolling-choices",
            "Ball-to-ball force when a numerical choice changes",
            [_choice(c) for c in changed],
            "The uncertainty comes from coarser grids than this one; for finite bodies it includes their "
            "own choices. Runs from rest are compared with steady rolling on the same grid.",
        ),
    ]
    times = _times(stores)
    if times is not None:
        items.append(times)
    return Section("rolling", "Rolling in 3D: balls that touch", items, conclusion=_conclusion(found))


def _finite(
    stores: Sequence[Path], sizes: StoredVariants, proof: Sequence[Proof]
) -> list[Text | Table | Figure | PressureMap]:
    """Return text and tables on what finite bodies change, and on how sensitive that is to numerical choices."""
    found = {name: stored_rows(name, stores, FINITE) for name in (*PAIRS, *RINGS)}
    missing = [name for name, rows in found.items() if not rows]
    shown = [row for rows in found.values() for row in rows if row.half_space is not None]
    changes = [abs(c) for row in shown if row.quantity in ("force 1-2", "torque") and (c := _change(row)) is not None]
    rub = max(abs(p.error) for p in proof if p.case.startswith("balls that touch"))
    most = f" They change forces and torques by up to {max(changes):.2f} %." if changes else ""
    return [
        Text(
            [
                (
                    "Finite bodies, normal and tangential: for rings and screws the static reference's patches of groove "
                    "and ball, set into pieces of their bodies; for straight rails, which the static reference does not "
                    "have, a whole ball and grooved bars of the same elements. Their response beyond a half space of the "
                    "same cells is a smooth kernel, added to the closed form of half spaces. Without motion they give the "
                    "pressures of the static reference's patches (first rows of the verification). Simplified: balls "
                    "touch each other in a point. Over Hertz's circle and over the patch of two finite balls, all of "
                    f"which slides, force and loss of that friction agree to {rub:.2g} % (verification), whatever the "
                    "elasticity. The kernel changes the pressure, adds a strain by normal forces that half spaces of one "
                    "material do not have, and shortens the rolling radius of the ball by half of the approach. Contact "
                    "forces are unchanged, by Hertz's law; the contacts of one ball do not influence each other, and "
                    "friction does not change pressures."
                )
                + most
            ]
        ),
        Table.of(
            "rolling-bodies",
            "What finite bodies change",
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
    """Return the change [%] of a quantity by finite bodies; None where it means nothing."""
    change = None if row.half_space is None else float(error_percent(row.reference, row.half_space))
    return change if change is not None and np.isfinite(change) and row.error_percent != 0.0 else None


def _beside(row: RollingRow) -> Row:
    """Return the table row of a quantity by rigid bodies, half spaces and finite bodies."""
    finite = np.isfinite(row.uncertainty)
    return {
        "scene": row.scene,
        "quantity": row.quantity,
        "unit": row.unit,
        Quantity("rigid", "rigid bodies", "", "g5"): row.rigid,
        Quantity("half", "half spaces", "", "g5"): row.half_space,
        Quantity("finite", "finite bodies", "", "g5"): row.reference,
        Quantity("uncertainty", "±", "", "g2"): row.uncertainty if finite else None,
        Quantity("change", "change by finite bodies", "%", ".3f"): _change(row),
        Quantity("error", "low-order against finite bodies", "%", ".2f"): row.error_percent,
    }


def _maps(patches: Sequence[PatchField]) -> list[Text | Table | Figure | PressureMap]:
    """Return maps of the slip, and of the traction with the cells that stick."""

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


def _conclusion(found: dict[str, list[RollingRow]]) -> str:
    """Return a sentence on the low-order error of the force between two balls; empty without a stored run."""
    row = next((r for r in found["lin-pair-a"] if r.quantity == "force 1-2"), None)
    if row is None or row.error_percent is None:
        return ""
    return f"The low-order model's force between two touching balls is off by {row.error_percent:+.2f} % of the 3D model's."


def _words(found: dict[str, list[RollingRow]], proof: Sequence[Proof]) -> list[str]:
    """Return the paragraphs that explain the tables."""
    reached = sum(p.reached for p in proof)
    gated = [r for rows in found.values() for r in rows if r.quantity in ("force 1-2", "torque")]
    beyond = [r for r in gated if not is_within_limit(r)]
    out = [
        "The 3D model of rolling solves the normal and tangential contact of elastic bodies on a grid in every "
        "contact. Coulomb's law holds in every cell to round-off, elastic displacements travel with the material, and "
        "each ball moves so that its forces and moments balance. Bodies are elastic half spaces; finite bodies are "
        "computed for comparison. Grid errors that also occur for rigid bodies (cells, staircase edge, a spin pole "
        "inside a cell) are removed with nearly rigid bodies on the same grid and the rigid limit by quadrature.",
        f"{reached} of {len(proof)} known answers are met within their targets.{_pole(proof)}",
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
    """Return a sentence on the error by a spin pole inside a cell, and on what removes it; empty if not computed."""
    worst = [
        max((abs(p.error) for p in proof if p.case == f"full slip {way}, pole inside"), default=np.nan)
        for way in (BY_GRID, RESOLVED, AS_RUNS)
    ]
    if not np.isfinite(worst).all():
        return ""
    alone, resolved, differenced = worst
    return (
        f" Where a whole contact slips about a pole inside a cell, the error of the grid alone is {alone:.2g} %: the "
        f"direction of slip turns within the cell. With that resolved, the staircase edge leaves {resolved:.2g} %. "
        f"Evaluated as differences, as runs are, every level is within {differenced:.2g} %."
    )


def _proof(p: Proof) -> Row:
    return {
        "case": p.case,
        "quantity": p.quantity,
        Quantity("coarse", "coarse grid", "", "g5"): p.values[0],
        Quantity("middle", "middle grid", "", "g5"): p.values[1],
        Quantity("fine", "fine grid", "", "g5"): p.values[2],
        Quantity("exact", "exact or printed", "", "g5"): p.exact,
        Quantity("error", "error of the answer", "%", ".2f"): p.error,
        Quantity("order", "order", "", ".1f"): p.order,
        Quantity("reach", "to reach", "%", "g3"): p.reach,
        "verdict": "reached" if p.reached else "not reached",
    }


def _compared(row: RollingRow) -> Row:
    """Return the table row of a quantity by the low-order and the 3D model."""
    finite = np.isfinite(row.uncertainty)
    return {
        "scene": row.scene,
        Quantity("state", "load state", "", "s"): row.load_state,
        "quantity": row.quantity,
        "unit": row.unit,
        Quantity("low", "low-order", "", "g5"): row.low,
        Quantity("reference", "3D", "", "g5"): row.reference,
        Quantity("uncertainty", "±", "", "g2"): row.uncertainty if finite else None,
        Quantity("error", "low-order against 3D", "%", ".2f"): row.error_percent,
        Quantity("share", "±", "%", ".2f"): row.uncertainty_percent,
        Quantity("printed", "printed low-order", "", "g4"): row.printed,
        Quantity("ansys", "printed ANSYS", "", "g4"): row.printed_ansys,
        Quantity("flat", "3D, flat contacts", "", "g5"): row.flat,
        Quantity("rigid", "rigid limit", "", "g5"): row.rigid,
        "verdict": f"within {LIMIT:g} %" if is_within_limit(row) else f"beyond {LIMIT:g} %",
    }


def _runs(name: str, stores: Sequence[Path]) -> list[RollingRun]:
    """Return the stored runs of a scene of rolling, the one with the source's cell size first."""
    scene = shipped_case(name, KindScene)
    found = (load_run(scene, level, stores) for level in (SOURCE_LEVEL, *LEVELS))
    return [run for run in found if run is not None]


def _grid_rows(stores: Sequence[Path]) -> list[Row]:
    """Return the table rows of all stored runs: grid, value, effect of elasticity, processor time."""
    out: list[Row] = []
    every = [(name, run) for name in (*PAIRS, *RINGS) for run in _runs(name, stores)]
    common = most_of(run.measured for _, run in every)
    for name, run in every:
        key = next(k for k in run.elastic if k.startswith(("force", "torque")))
        out.append(
            {
                "scene": name,
                Quantity("state", "load state", "", "s"): load_state(name),
                "level": "source's size" if run.level == SOURCE_LEVEL else str(run.level),
                "cells": f"{run.shape[0]} x {run.shape[1]}",
                Quantity("value", "force or torque", "", "g5"): run.values[key],
                Quantity("alone", "by the grid alone", "", "g5"): run.elastic[key],
                Quantity("elasticity", "change by elasticity", "", "g3"): run.elastic[key] - run.near_rigid[key],
                Quantity("lost", "power lost by differences", "%", ".3f"): 100.0 * run.upwind,
                Quantity("stick", "cells that stick", "", "d"): run.sticking,
                Quantity("seconds", "processor time", "s", "g3"): run.seconds if run.measured == common else None,
            }
        )
    return out


def _rest(s: RunFromRest) -> Row:
    """Return the table row of a run from rest."""
    meet = next((t for t, f in zip(s.time, s.force, strict=True) if f > 0.0), None)
    return {
        Quantity("steps", "steps", "", "d"): s.steps,
        Quantity("force", "force at the end", "N", "g5"): s.force[-1],
        Quantity("steady", "steady", "N", "g5"): s.steady,
        Quantity("error", "error", "%", ".2f"): float(error_percent(s.force[-1], s.steady)),
        Quantity("meet", "balls meet at", "ms", ".1f"): None if meet is None else 1e3 * meet,
        Quantity("seconds", "processor time", "s", "g3"): s.seconds,
    }


def _choice(c: ChoiceEffect) -> Row:
    return {
        "scene": c.scene,
        "choice": c.choice,
        "tried": c.tried,
        Quantity("change", "largest change of the force", "%", "g2"): c.change,
        Quantity("uncertainty", "stated uncertainty", "%", "g2"): c.uncertainty,
        "verdict": "within" if c.within else "beyond",
    }


def _figure(series: Sequence[RunFromRest]) -> Figure:
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
    """Return the figure of each grid's difference from the finest over its processor time; None without runs."""
    curves = []
    found = {name: [r for r in _runs(name, stores) if r.level != SOURCE_LEVEL] for name in PAIRS}
    common = most_of(r.measured for runs in found.values() for r in runs)
    for name, every in found.items():
        runs = [r for r in every if r.measured == common]
        if len(runs) < len(LEVELS) or not runs[-1].values["force 1-2 N"] > 0.0:
            continue
        top = runs[-1].values["force 1-2 N"]
        errors = [max(abs(float(error_percent(r.values["force 1-2 N"], top))), 1e-3) for r in runs[:-1]]
        curves.append(Curve(name, [r.seconds for r in runs[:-1]], errors))
    if not curves:
        return None
    panel = Panel("ball-to-ball force", "processor time [s]", "difference from the finest grid [%]", curves, log="xy")
    return Figure("rolling-times", "Error against run time of the 3D model of rolling", [panel], f"Measured with {common}.")
