"""A result as one JSON object, and as a table to read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.comparison.commands.tables import plain
from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.model_form import ModelForm
from rollbench.comparison.quantities import number, quantity, record, shown
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import Equilibrium, Solved, SolverReport, StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene

if TYPE_CHECKING:
    from rich.console import RenderableType


def per_side(row: Array) -> dict[str, float | None]:
    """Values (4,) by the names of the flanks."""
    return {side: number(value) for side, value in zip(SIDES, row, strict=True)}


def summary(load: Array) -> dict[str, dict[str, Any]]:
    """Per loaded side: largest and smallest load of the loaded balls [N], their ratio, balls with and without load."""
    out: dict[str, dict[str, Any]] = {}
    for s, side in enumerate(SIDES):
        loaded = load[:, s][load[:, s] > 0.0]
        if loaded.size:
            out[side] = {
                "max_N": number(loaded.max()),
                "min_N": number(loaded.min()),
                "ratio": number(loaded.max() / loaded.min()),
                "loaded": int(loaded.size),
                "lost": int(load.shape[0] - loaded.size),
            }
    return out


#: Forces and moments on the shaft, and what they leave.
EQUILIBRIUM = (
    quantity("external_force_N", "applied_force"),
    quantity("external_moment_Nm", "applied_moment"),
    quantity("reaction_force_N"),
    quantity("reaction_moment_Nm"),
    quantity("contact_force_N"),
    quantity("contact_moment_Nm"),
    quantity("force_residual"),
    quantity("moment_residual"),
    quantity("pin_force_N"),
    quantity("pin_moment_Nm"),
    quantity("pin_share"),
    quantity("ball_residual"),
)
#: How the solution came about; the error of the beam is told by who measured it.
SOLVER = (
    quantity("iterations"),
    quantity("residual"),
    quantity("seconds"),
    quantity("unknowns"),
    quantity("elements"),
    quantity("evaluations"),
    quantity("engine"),
    quantity("formulation"),
    quantity("round_off_bound"),
    quantity("discretisation_percent", lambda _: None),
    quantity("notes"),
)


def _model_form(m: ModelForm | None) -> dict[str, Any] | None:
    if m is None:
        return None
    return {
        "covered": m.percent is not None,
        "largest_percent_of_mean": None if m.percent is None else number(m.percent),
        "rms_percent_of_mean": None if m.rms_percent is None else number(m.rms_percent),
        **expected_json(m, "{}_percent"),
        "distance": number(m.distance),
        "nearest": m.nearest,
        "compared": m.compared,
        "words": list(m.words),
    }


def expected_json(m: ModelForm | None, key: str) -> dict[str, float | None]:
    """Expected errors [%] beside those of loads, by ``key`` with the quantity's name; null where not covered."""
    errors = {
        name: None if m is None else getattr(m, f"{name}_percent") for name in ("displacement", "rigidity", "pressure")
    }
    return {key.format(name): None if value is None else number(value) for name, value in errors.items()}


def model_form_text(m: ModelForm) -> str:
    """The estimate in one sentence."""
    return f"model-form error{': ' if m.percent is None else ' '}{model_form_words(m)}"


def model_form_words(m: ModelForm) -> str:
    """The same behind a label that says what it is of."""
    if m.percent is None or m.rms_percent is None:
        away = f" (nearest {m.nearest})" if m.nearest else ""
        return f"not covered by the comparisons with the 3D reference{away}; " + "; ".join(m.words)
    kind = "scene of its kind" if m.compared == 1 else "scenes of its kind"
    others = {
        "displacement": m.displacement_percent,
        "rigidity": m.rigidity_percent,
        "largest pressure": m.pressure_percent,
    }
    further = "".join(f", {name} {value:.1f} %" for name, value in others.items() if value is not None)
    return (
        f"to expect: {m.percent:.1f} % of the mean load on the worst contact, {m.rms_percent:.1f} % RMS{further} "
        f"(nine of ten of {m.compared} {kind} were within, nearest {m.nearest}); " + "; ".join(m.words)
    )


def discretisation_percent(scene: Scene, result: StaticResult) -> float | None:
    """Discretisation error of the beam in per cent of the mean contact load, where it was measured."""
    change = result.solver.discretisation
    if change is None:
        return None
    return number(float(error_percent(change, 0.0, mean_load(result.load, nominal_contacts(scene, result)))))


def stiffness_json(station: float | None, status: str, matrix: Array) -> dict[str, Any]:
    """A stiffness (6, 6) at a station [m]: N/m, N/rad, N m/rad."""
    rows = [[number(x) for x in row] for row in matrix]
    at = None if station is None else number(1e3 * station)
    return {"station_mm": at, "status": status, "freedoms": list(FREEDOMS), "matrix": rows}


def as_json(
    scene: Scene, result: StaticResult, worth: ModelForm | None = None, answers: dict[str, Any] | None = None
) -> dict[str, Any]:
    """The result as a JSON-ready object: angles in deg, stations in mm, displacements in um, forces in N; worth: the
    model-form error to expect, where it was estimated; answers: what else stands in the summary."""
    finite = np.isfinite(result.load).all()
    return {
        "scene": scene.name,
        "model": result.model,
        "member": result.member if scene.errors.random else None,
        "status": result.status,
        "balls": ball_rows(result),
        "summary": {"sides": summary(result.load), **(answers or {})} if finite else {},
        **behind_json(result, discretisation_percent(scene, result), worth),
    }


def ball_rows(balls: StaticResult) -> list[dict[str, Any]]:
    """Place, loads and contact angles of every ball, numbered from 1."""
    return [
        {
            "index": i + 1,
            "azimuth_deg": number(math.degrees(balls.azimuth[i])),
            "z_mm": number(1e3 * balls.z[i]),
            "load_N": per_side(balls.load[i]),
            "contact_angle_deg": per_side(np.degrees(balls.contact_angle[i])),
        }
        for i in range(balls.z.size)
    ]


def behind_json(result: Solved, discretisation: float | None = None, worth: ModelForm | None = None) -> dict[str, Any]:
    """What the JSON of one set and of several ends with: centreline, balance, solver, expected error, assumptions,
    warnings. discretisation: error of the beam in per cent of the mean contact load."""
    return {
        "centreline": [
            {"z_mm": number(1e3 * z), "ux_um": number(1e6 * u[0]), "uy_um": number(1e6 * u[1]), "uz_um": number(1e6 * u[2])}
            for z, u in zip(result.centreline_z, result.centreline, strict=True)
        ],
        "equilibrium": record(EQUILIBRIUM, result.equilibrium),
        "solver": (record(SOLVER, result.solver) or {}) | {"discretisation_percent": discretisation},
        "model_form": _model_form(worth),
        "assumed": list(result.assumed),
        "left_out": list(result.left_out),
        "warning": above(result.warnings) or None,
        "warnings": list(result.warnings),
    }


def _cell(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "–"


def as_table(
    scene: Scene,
    result: StaticResult,
    worth: ModelForm | None = None,
    *,
    block: str = "",
    balls: bool = True,
    details: bool = True,
) -> list[RenderableType]:
    """The result for the terminal: block of answers (before all tables), ball table, warnings; then, with details or
    without a block, model-form error, balance, solver, assumptions and what was left out, else where they are."""
    drawn = f", member {result.member} of its random errors" if scene.errors.random else ""
    title = f"{scene.name}{drawn}, model {result.model}: {result.status}"
    parts: list[Any] = [title, *first_lines(result, block)]
    if balls and (result.load > 0.0).any():
        error = None if worth is None or worth.percent is None else worth.percent / 100.0
        error = error and error * mean_load(result.load, nominal_contacts(scene, result))
        parts += [_ball_table(result, error), "", _summary_table(result, error), ""]
    grid = discretisation_percent(scene, result)
    measured = "" if grid is None else f" (discretisation error {grid:.1e} % of the mean load)"
    behind = [] if result.equilibrium is None else _balance(result.equilibrium)
    behind += solver_lines(result.solver, measured)
    if worth is not None and not block:
        behind.append(model_form_text(worth))
    return [*parts, *last_lines(result, behind, details=details or not block)]


def first_lines(result: Solved, block: str) -> list[str]:
    """The warnings that stand above the answers, and the block of these."""
    line = above(result.warnings)
    return [*(["", line] if line else []), *(["", block, ""] if block else [])]


def last_lines(result: Solved, behind: Sequence[str], *, details: bool) -> list[str]:
    """`closing_lines` of a result, with its notes."""
    notes = [f"note: {line}" for line in result.solver.notes]
    return closing_lines(result.warnings, behind, result.assumed, result.left_out, details=details, notes=notes)


def closing_lines(
    warnings: Sequence[str],
    behind: Sequence[str],
    assumed: Sequence[str],
    left_out: Sequence[str],
    *,
    details: bool,
    notes: Sequence[str] = (),
) -> list[str]:
    """Warnings, then what lies behind the answers: lines on balance and solver, notes, assumptions, what was left out; or
    where to find it."""
    warned = [f"warning: {line}" for line in warnings]
    if not details:
        return [*warned, f"{len(assumed)} assumptions, {len(left_out)} things left out, balance and solver: --assumptions"]
    headed = ("assumed", assumed), ("left out", left_out)
    return [*behind, *warned, *notes, *(f"{heading}: {line}" for heading, lines in headed for line in lines)]


def solver_lines(s: SolverReport, measured: str = "") -> list[str]:
    """How the solution came about; only the time where nothing was solved. measured: of the elements."""
    if not math.isfinite(s.residual):
        return [f"refused before anything was solved for, in {s.seconds:.3g} s"]
    return [
        f"solver: {s.formulation}, {s.engine}; {s.iterations} iterations, residual {s.residual:.1e}, "
        f"{s.unknowns} unknowns, {s.elements} beam elements{measured}, {s.seconds:.3g} s"
    ]


def _balance(e: Equilibrium) -> list[str]:
    lines = [
        f"balance of the screw: force {e.force_residual:.1e}, moment {e.moment_residual:.1e} (relative, sums over "
        f"loads, reactions and contact points); of the balls: {e.ball_residual:.1e}"
    ]
    if e.pin_share > 0.0:
        lines.append(
            f"no support of the scene holds a free motion: its pin takes {100.0 * e.pin_share:.2g} % of the largest "
            "force or moment, by which the balance of what the supports can carry is open"
        )
    return lines


def _ball_table(result: StaticResult, error: float | None) -> RenderableType:
    """Every ball; error [N] to expect of a load."""
    sides = [k for k in range(4) if (result.load[:, k] > 0.0).any()]
    headings, rows = ["ball", "deg", "z mm", *(x for k in sides for x in (f"{SIDES[k]} N", "angle"))], []
    for i in range(result.z.size):
        cells = [str(i + 1), f"{math.degrees(result.azimuth[i]):.1f}", f"{1e3 * result.z[i]:.2f}"]
        for k in sides:
            cells += [shown(result.load[i, k], error), _cell(math.degrees(result.contact_angle[i, k]), ".2f")]
        rows.append(cells)
    return plain(headings, rows)


def stiffness_lines(tangent: Tangent) -> list[RenderableType]:
    """The stiffness at a section as a table to read, N/um and kN m/rad in their places."""
    if tangent.status != "converged":
        return [f"stiffness at {1e3 * tangent.station:.6g} mm: {tangent.status}"]
    rows = ((name, *(f"{x:.4g}" for x in row)) for name, row in zip(FREEDOMS, tangent.matrix, strict=True))
    head = (
        f"tangent stiffness of the screw's section at {1e3 * tangent.station:.6g} mm against the held nut, without the "
        "screw's supports; forces and moments over displacements and rotations, N, m, rad"
    )
    return ["", head, plain(("", *FREEDOMS), rows)]


def _summary_table(result: StaticResult, error: float | None) -> RenderableType:
    rows = (
        (side, *(shown(row[k], error) for k in ("max_N", "min_N", "ratio")), str(row["loaded"]), str(row["lost"]))
        for side, row in summary(result.load).items()
    )
    return plain(("side", "max N", "min N", "max/min", "loaded", "lost"), rows)
