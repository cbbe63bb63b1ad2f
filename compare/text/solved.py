"""A solved scene, of one set or several, and the load cases of a duty cycle for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.models.load_cases import Lives, Solved, SolvedAxis, Together
from rollbench.compare.models.programs import title_of
from rollbench.compare.models.registry import random_errors
from rollbench.compare.quantities import as_json, count_of, quantities, shown
from rollbench.compare.results.load_curve import LoadCurve
from rollbench.compare.results.scene_json import (
    cases_json,
    discretisation_percent,
    life_json,
    rollers,
    set_balls,
    sides_json,
)
from rollbench.compare.results.side_by_side import NUMBERS, Alternative, SideBySide
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.text.entries import block, entry, life_words, load_error, modified_words, reference_lines
from rollbench.compare.text.printing import Column, aligned, listed, plain, ruled, text_width
from rollbench.lowfi.rating.contacts import RACES
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, Equilibrium, SolverReport, by_freedoms
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import FREEDOMS, SIDES

if TYPE_CHECKING:
    from rich.console import RenderableType


#: Columns of a load curve: key of the point, heading, format.
CURVE_COLUMNS: tuple[Column, ...] = (
    ("load_factor", "factor", ".3g"),
    ("load_N", "load N", ".5g"),
    ("displacement_um", "displacement um", ".4f"),
    ("stiffness_N_per_um", "tangent N/um", ".5g"),
    ("largest_load_N", "largest contact N", ".5g"),
    ("friction_torque_Nmm", "friction N mm", ".3g"),
    ("status", "status", "s"),
)

#: What the table of sets says of each: key of `set_rows`, heading, format.
SETS = (
    *(("set", "set", "s"), ("name", "name", "s"), ("kind", "kind", "s"), ("z", "z mm", ".2f")),
    *((f"F{x}", f"F{x} N", ".2f") for x in "xyz"),
    *(("largest", "largest load N", ".2f"), ("loaded", "loaded", "s")),
    *(("uz", "axial N/um", ".2f"), ("ux", "along x N/um", ".2f"), ("uy", "along y N/um", ".2f")),
)


def case_table(one: Solved | SolvedAxis, *, balls: bool = False, details: bool = False) -> list[Any]:
    """A solved scene for the terminal: warnings and the block of answers, tables; then balance and solver, assumptions and
    what was left out, or where they are. balls: with the table of every ball; details: with what lies behind the answers
    (always where there are none)."""
    answers, result = block(one, text_width()), one.result
    above_all, measured = above(result.warnings), ""
    behind = [] if result.equilibrium is None else _balance(result.equilibrium, several=isinstance(one, SolvedAxis))
    if isinstance(one, SolvedAxis):
        sets = count_of(len(one.scene.sets), "set")
        titles = [f"{one.scene.name}, {sets}, model {result.model}: {result.status}", one.scene.title]
        tables = _set_tables(one.result, balls=balls)
    else:
        drawn = f", member {result.member} of its random errors" if random_errors(one.scene) else ""
        titles = [f"{one.scene.name}{drawn}, model {title_of(result.model)}: {result.status}"]
        tables = _ball_tables(one) if balls and (one.result.load > 0.0).any() else []
        grid = discretisation_percent(one.scene, one.result)
        measured = "" if grid is None else f" (discretisation error {grid:.1e} % of the mean load)"
    behind += solver_lines(result.solver, measured)
    notes = [f"note: {line}" for line in result.solver.notes]
    return [
        *titles,
        *(["", above_all] if above_all else []),
        *(["", answers, ""] if answers else []),
        *tables,
        *closing_lines(
            result.warnings, behind, result.assumed, result.left_out, details=details or not answers, notes=notes
        ),
    ]


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
        counted = f"{count_of(len(assumed), 'assumption')}, {count_of(len(left_out), 'thing')} left out"
        return [*warned, f"{counted}, balance and solver: --assumptions"]
    headed = ("assumed", assumed), ("left out", left_out)
    return [*behind, *warned, *notes, *(f"{heading}: {line}" for heading, lines in headed for line in lines)]


def solver_lines(s: SolverReport, measured: str = "") -> list[str]:
    """How the solution came about; only the time where nothing was solved. measured: of the elements."""
    if not math.isfinite(s.residual):
        return [f"refused before anything was solved for, in {s.seconds:.3g} s"]
    return [
        f"solver: {s.formulation}, {s.engine}; {count_of(s.iterations, 'iteration')}, residual {s.residual:.1e}, "
        f"{count_of(s.unknowns, 'unknown')}, {count_of(s.elements, 'beam element')}{measured}, {s.seconds:.3g} s"
    ]


def curve_lines(curve: LoadCurve, *, details: bool = False) -> list[Any]:
    """A load curve for the terminal: lash and stiffness, its points; details: with the assumptions."""
    x, y, z = curve.direction
    way = next((name for name, on in zip("xyz", curve.direction, strict=True) if on == 1.0), f"({x:.3g}, {y:.3g}, {z:.3g})")

    def size(value: float | None, factor: float, unit: str) -> str:
        return "unknown" if value is None else f"{shown(factor * value)} {unit}"

    lash = f"none: {curve.lash_words}" if curve.lash_words else size(curve.lash, 1e6, "um")
    stiff = " and ".join(
        f"{size(value, 1e-6, 'N/um')} {words}"
        for value, words in ((curve.backward, "below"), (curve.forward, "above"))
        if value is not None
    )
    rows = [as_json(p) or {} for p in curve.points]
    used = [c for c in CURVE_COLUMNS if any(row[c[0]] is not None for row in rows)]
    if curve.converged and not any(row["status"] != "converged" for row in rows):
        used.remove(CURVE_COLUMNS[-1])
    return [
        f"{curve.scene}, model {title_of(curve.model)}: load along {way} at {curve.at}, {len(rows)} points",
        *([curve.above] if curve.above else []),
        f"lash (dead zone between the signs): {lash}; from end to end {size(curve.peak_to_peak, 1e6, 'um')}",
        *([f"stiffness outside the lash, to the ends: {stiff}"] if stiff else []),
        listed("", used, rows),
        *(f"warning: {line}" for line in curve.warnings),
        *([f"assumed: {line}" for line in curve.assumed] if details else []),
    ]


def side_by_side_lines(found: SideBySide) -> list[Any]:
    """Scenes side by side for the terminal: a column for each, with its difference from the first."""
    rows, of = [], quantities(Alternative)
    answers = [as_json(one) or {} for one in found.scenes]
    for key in (k for k in NUMBERS if any(a[k] is not None for a in answers)):
        off = found.difference_percent(key)
        cells = [
            _sized(a[key]) + ("" if k == 0 or x is None else f"  {x:+.1f} %")
            for k, (a, x) in enumerate(zip(answers, off, strict=True))
        ]
        rows.append([f"{of[key].label} [{of[key].unit}]" if of[key].unit else of[key].label, *cells])
    if any(one.shortest for one in found.scenes):
        rows.append(["shortest set", *(one.shortest or "–" for one in found.scenes)])
    warned = [(one.scene, above(one.warnings)) for one in found.scenes]
    unknown = [f"{of[key].label} [{of[key].unit}]" for key in NUMBERS if all(a[key] is None for a in answers)]
    return [
        *(f"{name}: {line}" for name, line in warned if line),
        *(f"{one.scene}: {one.status}" for one in found.scenes if one.status != "converged"),
        ruled(f"model {found.model}: scenes side by side", ["", *(one.scene for one in found.scenes)], rows, [""]),
        f"not the same in all: {', '.join(found.differ)}"
        if found.differ
        else "shaft, loads and operation are the same in all",
        *([f"not answered: {', '.join(unknown)}; why: rollbench solve SCENE"] if unknown else []),
        "in per cent: difference from the first; all answers: rollbench solve SCENE",
    ]


def _sized(value: Any) -> str:
    if value is None:
        return "–"
    if not isinstance(value, list):
        return shown(value)
    low, high = map(shown, value)
    return low if low == high else f"{low} to {high}"


def _balance(e: Equilibrium, *, several: bool) -> list[str]:
    sums = f"force {e.force_residual:.1e}, moment {e.moment_residual:.1e}"
    if several:
        return [f"balance of the shaft: {sums} (relative)"]
    of_parts = f"(relative, sums over loads, reactions and contact points); of the balls: {e.ball_residual:.1e}"
    lines = [f"balance of the screw: {sums} {of_parts}"]
    if e.pin_share > 0.0:
        lines.append(
            f"no support of the scene holds a free motion: its pin takes {100.0 * e.pin_share:.2g} % of the largest "
            "force or moment, by which the balance of what the supports can carry is open"
        )
    return lines


def _ball_tables(one: Solved) -> list[RenderableType]:
    """Every ball, and the sums of each flank; loads to the digits that their expected error leaves."""
    result = one.result
    error = load_error(mean_load(result.load, nominal_contacts(one.scene, result)), one.expected)
    sides = [k for k in range(4) if (result.load[:, k] > 0.0).any()]
    headings, rows = ["ball", "deg", "z mm", *(x for k in sides for x in (f"{SIDES[k]} N", "angle"))], []
    for i in range(result.z.size):
        cells = [str(i + 1), f"{math.degrees(result.azimuth[i]):.1f}", f"{1e3 * result.z[i]:.2f}"]
        for k in sides:
            angle = math.degrees(result.contact_angle[i, k])
            cells += [shown(result.load[i, k], error), f"{angle:.2f}" if math.isfinite(angle) else "–"]
        rows.append(cells)
    sums = (
        (side, *(shown(row[k], error) for k in ("max_N", "min_N", "ratio")), str(row["loaded"]), str(row["lost"]))
        for side, row in sides_json(result.load).items()
    )
    summed = plain(("side", "max N", "min N", "max/min", "loaded", "lost"), sums)
    return [plain(headings, rows), "", summed, ""]


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


def _set_tables(result: AxisResult, *, balls: bool) -> list[RenderableType]:
    """Sets, balls and rollers where asked for, housings, stiffness."""
    out: list[RenderableType] = []
    if result.sets and result.converged:
        out += [listed("sets: force on the shaft, stiffness of the set alone", SETS, set_rows(result))]
        out += _element_tables(result) if balls else []
    for h in result.housings if result.converged else ():
        moved = ", ".join(f"{n.split('_')[0]} {x:.4g} {n.split('_')[1]}" for n, x in by_freedoms(h.motion).items())
        force = ", ".join(f"{x:.5g}" for x in h.wrench[:3])
        out.append(f"{h.name}: {moved}; the frame holds it with ({force}) N; balance {h.residual:.1e}")
    return [*out, *_stiffness_lines(result)]


def set_rows(result: AxisResult) -> Iterator[dict[str, Any]]:
    """Place, force on the shaft, loads and stiffness of each set."""
    for k, s in enumerate(result.sets, 1):
        head = {"set": k, "name": s.of.name, "kind": s.of.kind, "z": 1e3 * s.of.position}
        loads = {"largest": s.loads.max(initial=0.0), "loaded": int((s.loads > 0.0).sum())}
        forces = dict(zip(("Fx", "Fy", "Fz"), s.force, strict=True))
        yield head | forces | loads | dict(zip(FREEDOMS[:3], 1e-6 * np.diag(s.stiffness), strict=False))


def _element_tables(result: AxisResult) -> list[RenderableType]:
    """Balls by set and index, with the sides that carry load; rollers."""
    out: list[RenderableType] = []
    rows = set_balls(result)
    loaded = [s for s in SIDES if any((r["load_N"][s] or 0.0) > 0.0 for r in rows)]
    if loaded:
        columns: list[Column] = [("set", "set", "s"), ("index", "ball", "s"), ("azimuth_deg", "azimuth deg", ".2f")]
        for side in loaded:
            columns += [(f"{side} N", f"{side} N", ".3f"), (f"{side} deg", "angle deg", ".3f")]
        flat = [
            r | {f"{s} N": r["load_N"][s] for s in loaded} | {f"{s} deg": r["contact_angle_deg"][s] for s in loaded}
            for r in rows
        ]
        out.append(listed("balls", columns, flat))
    found = rollers(result)
    if found:
        names = (("set", "set", "s"), ("index", "roller", "s"), ("azimuth_deg", "azimuth deg", ".2f"))
        loads = (("load_N", "load N", ".3f"), ("largest_line_load_N_mm", "largest N/mm", ".3f"))
        races = [(f"{race} MPa", f"{race} MPa", ".0f") for race in RACES]
        flat = [r | {f"{race} MPa": r["pressure_MPa"][race] for race in RACES} for r in found]
        out.append(listed("rollers", (*names, *loads, *races), flat))
    return out


def _stiffness_lines(result: AxisResult) -> list[str]:
    if result.stiffness is None:
        return []
    d = np.diag(result.stiffness)
    words = [f"{n} {1e-6 * x:.5g} N/um" for n, x in zip(FREEDOMS[:3], d[:3], strict=True) if np.isfinite(x)]
    words += [f"{n} {1e-3 * x:.5g} kN m/rad" for n, x in zip(FREEDOMS[3:], d[3:], strict=True) if np.isfinite(x)]
    with np.errstate(all="ignore"):
        free = np.isfinite(d)
        C = np.linalg.inv(result.stiffness[np.ix_(free, free)])
    alone = dict(zip(np.array(FREEDOMS)[free], 1.0 / np.diag(C), strict=True))
    lone = [f"{n} {1e-6 * alone[n]:.5g} N/um" for n in FREEDOMS[:3] if n in alone]
    return [
        f"tangent stiffness of the whole, {result.stiffness_at}, the other freedoms held: {', '.join(words)}",
        f"the same, the other freedoms following: {', '.join(lone)}",
    ]


#: Columns of the table of cases: heading, group of a case's summary, and key.
COLUMNS = (
    ("largest load N", "loads", "max_N"),
    ("axial N", "axial", "force_N"),
    ("pressure MPa", "worst_contact", "pressure_MPa"),
    ("static safety", "static_safety", "factor"),
    ("life 1e6 rev", "life", "L10_million_revolutions"),
)


def cases_table(
    cycle: DutyCycle,
    solved: Sequence[Solved | SolvedAxis],
    whole: Together,
    tangents: Sequence[Tangent | None] = (),
    *,
    balls: bool = False,
    details: bool = False,
) -> list[Any]:
    """What the cases say together, a row on each, then each by itself; what is assumed is said once."""
    data = cases_json(cycle, solved, whole)
    parts: list[Any] = [f"{cycle.name}, model {data['model']}: {count_of(len(solved), 'load case')}, {data['status']}", ""]
    parts += [*(entry(label, text, text_width()) for label, text in together_entries(whole)), ""]
    parts += [aligned([*case_rows(data["cases"])], ".4g"), ""]
    shown: set[str] = set()
    for case, one, tangent in zip(cycle.cases, solved, tangents or [None] * len(solved), strict=True):
        lines = [x for x in case_table(one, balls=balls, details=details) if not (isinstance(x, str) and x in shown)]
        shown |= {x for x in lines if isinstance(x, str) and x.startswith(("assumed: ", "left out: "))}
        parts += [f"case {case.name}, share {case.share:.4g}", *lines, *(stiffness_lines(tangent) if tangent else []), ""]
    return parts


def case_rows(cases: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """A row on every case by `cases_json`."""
    for one in cases:
        row: dict[str, Any] = {"case": one["case"], "share": one["share"]}
        groups = ((heading, key, one["summary"].get(group)) for heading, group, key in COLUMNS)
        row |= {heading: None if group is None else group[key] for heading, key, group in groups}
        worth = one["model_form"]
        yield row | {"expected error %": None if worth is None else worth["largest_percent_of_mean"]}


def together_entries(whole: Together) -> tuple[tuple[str, str], ...]:
    """Labels and sentences of what the cases say together."""
    p, s, e = whole.pressure, whole.safety, whole.error
    lost = f"; not covered by comparisons: {', '.join(whole.uncovered)}" if whole.uncovered else ""
    lives = (x for of_set in whole.lives for x in _life_entries(of_set, whole.speed))
    return (
        ("pressure", "none" if p is None else f"largest in case {p.case}: {1e-6 * p.value:.0f} MPa"),
        ("static", "none" if s is None else f"least safety in case {s.case}: {s.value:.3g}"),
        (
            "error",
            ("none" if e is None else f"largest to expect in case {e.case}: {e.value:.1f} % of the mean load") + lost,
        ),
        *lives,
    )


def _life_entries(lives: Lives, speed: float | None) -> tuple[tuple[str, str], ...]:
    """Entries on the lives of a set."""
    basic = reference_lines(f"{lives.set}: " if lives.set else "", as_json(lives.reference))
    return (("life", _life(lives, speed)), *basic, ("standard", _standard(lives)))


def _life(lives: Lives, speed: float | None) -> str:
    """Life by the contact loads."""
    rated, of = lives.life, f"{lives.set}: " if lives.set else ""
    if rated is None:
        return of + lives.life_words
    return (
        f"{of}L10 {life_words(life_json(rated, speed) or {})} of the duty cycle, by the contact loads, the nut at "
        f"one position; rating {rated.rating:.0f} N as computed by {rated.standard}"
        f"{modified_words(as_json(lives.modified))}"
    )


def _standard(lives: Lives) -> str:
    """Life by the equivalent loads, and what the contact loads make of it."""
    rated, off, of = lives.standard, lives.difference_percent, f"{lives.set}: " if lives.set else ""
    if rated is None:
        return f"{of}no life by equivalent loads: {lives.standard_words}"
    loads = " and ".join(f"{load:.0f} N" for load in rated.loads if load > 0.0)
    than = "" if off is None else f"; by the contact loads {abs(off):.2g} % {'more' if off > 0.0 else 'less'}"
    return f"{of}L10 {rated.revolutions:.4g} million revolutions by {rated.standard}'s equivalent loads, {loads}{than}"
