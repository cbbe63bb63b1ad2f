"""Numerical stability: hard scenes against formulations, each converged or with the reason why not.

The scenes are extreme on purpose (100 t of load, a shaft a thousand times too soft): the question is whether the
equations are solved, not whether the model holds there. Most are scenes that a file may describe; where one is not (a
bore that leaves too thin a wall) that is said at the case.

The source's starts are those of ``lowfi.as_source``: the nominal state; a good guess, the screw moved along its
axis as if all balls shared the axial load (without an axial load that is the nominal state); ten load steps from there.

Random campaigns are run by ``python -m tests.campaign`` of the repository; here their records are read.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import with_balls
from rollbench.compare.scenes.catalogue import scene as shipped
from rollbench.lowfi.as_source import Start, solve_source
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.lowfi.statics.problem import build
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.static import solve_static
from rollbench.lowfi.statics.summary import BALANCE
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, Errors, Load, Material, Scene, Support
from rollbench.meshes.processes import local
from rollbench.meshes.section import volume_ratio
from rollbench.reports.content import Cell, Row

ENERGY = "energy solver"

SOURCE: dict[str, Start] = {
    "source, nominal start": "nominal",
    "source, good guess": "guess",
    "source, load steps": "load steps",
}

#: Models with elastic bodies by label: the same scenes must be solved with their backends.
BACKENDS = {m.label: m.name for m in MODELS.values() if m.extremes}

FORMULATIONS = (ENERGY, *BACKENDS, *SOURCE)

CONVERGED = "converged"

#: The source's dense Jacobian is not attempted above this many unknowns.
DENSE_LIMIT = 2000

#: Balls beyond which no elastic bodies are attempted.
ELASTIC_LIMIT = 250

#: Loads of two formulations that differ by less than this share of the largest load [%] are the same solution.
SAME = 1e-4

UNHELD = "not held: {}: no support and no contact resists it, and the loads drive it"

HELIX = UNHELD.format("screw motion along the helix")

ROTATION = UNHELD.format("rotation about the screw's axis")

TWO_BALLS = UNHELD.format("rigid motion in uy, uz, rx, ry at the nut's centre")


@dataclass(frozen=True)
class Case:
    """One hard scene; ``expected`` is ``"converged"`` or the status that names the mechanism."""

    name: str
    group: str
    scene: Scene
    expected: str = CONVERGED


@dataclass(frozen=True)
class Attempt:
    """One case solved by one formulation.

    residual: largest unbalanced force over the largest force (None where nothing was solved, or there is no force);
    round_off_bound: what double precision leaves of it at best (energy solver only); seconds include set-up;
    difference_percent: largest difference of a load from the energy solver's, on the same partition, in per cent of the
    largest load (None unless both converge); reason: the verdict in short, with what else a reader must know.
    """

    case: str
    group: str
    formulation: str
    status: str
    expected: str
    converged: bool
    iterations: int = 0
    residual: float | None = None
    round_off_bound: float = 0.0
    seconds: float = 0.0
    unknowns: int = 0
    difference_percent: float | None = None
    reason: str = ""

    @property
    def tried(self) -> bool:
        """Whether anything was solved for."""
        return not self.status.startswith("not attempted")


# --- the scenes


def _load(base: Scene, force: tuple[float, float, float], moment: float = 0.0, at: float = 0.0) -> Scene:
    return replace(base, loads=(Load(at, force, (moment, 0.0, 0.0)),))


def _balls(base: Scene, oversize: float, half_width: float = 0.0, seed: int = 0) -> Scene:
    drawn = BallErrors(oversize=oversize, sigma=half_width / math.sqrt(3.0), distribution="uniform")
    return replace(base, errors=Errors(balls=drawn, seed=seed))


def _materials(base: Scene, screw: float, nut: float, balls: float) -> Scene:
    def scaled(m: Material, factor: float) -> Material:
        return replace(m, youngs_modulus=m.youngs_modulus * factor)

    return replace(
        base,
        screw=replace(base.screw, material=scaled(base.screw.material, screw)),
        nut=replace(base.nut, material=scaled(base.nut.material, nut)),
        balls=replace(base.balls, material=scaled(base.balls.material, balls)),
    )


def shaft_scaled(base: Scene, factor: float) -> Scene:
    """The scene with the beam's stiffness scaled and every Hertz constant unchanged.

    Stiffer: the screw's modulus times ``factor``, the balls softened by ``2 - 1/factor`` so that ball and screw keep
    their contact modulus, and the nut stiffened like the screw (the parts of ``base`` share one material). Softer: no
    modulus can do that (the ball would need a negative one), so a bore leaves ``factor`` of the section's area, and
    ``factor (2 - factor)`` of its second moment; below about 0.2 that wall is thinner than the groove is deep, which a
    scene file may not ask for.
    """
    if factor >= 1.0:
        return _materials(base, factor, factor, 1.0 / (2.0 - 1.0 / factor))
    outer = base.screw.outer_diameter * math.sqrt(volume_ratio(base))
    return replace(base, screw=replace(base.screw, bore=outer * math.sqrt(1.0 - factor)))


def conforming(base: Scene, ratio: float) -> Scene:
    """Groove radii at ``ratio`` times the ball radius."""
    radius = ratio * base.balls.radius
    return replace(base, screw=replace(base.screw, groove_radius=radius), nut=replace(base.nut, groove_radius=radius))


def with_lead(base: Scene, lead: float) -> Scene:
    """The screw of ``base`` with another lead [m]: 0 is a bearing of 16 balls; below 6 mm with balls of 3 mm."""
    if lead == 0.0:
        ring = tuple(2.0 * math.pi * i / 16 for i in range(16))
        return replace(base, track=replace(base.track, lead=0.0), balls=replace(base.balls, azimuths=ring))
    long = replace(base, track=replace(base.track, lead=lead), nut=replace(base.nut, length=2.0 * lead + 14e-3))
    if lead > 6e-3:
        return long
    ratio = base.screw.groove_radius / base.balls.radius
    return conforming(replace(long, balls=replace(long.balls, radius=1.5e-3)), ratio)


def _free(base: Scene) -> Scene:
    """Held along and about the axis only, so that the balls carry any lateral load and moment."""
    return replace(base, supports=(Support(0.0, (("uz", 0.0), ("rz", 0.0))),))


def _offset(base: Scene, offset: float, oversize: float) -> Scene:
    moved = Support(base.screw.length, (("ux", offset), ("uy", 0.0)))
    return replace(_balls(base, oversize), supports=(*base.supports, moved))


def _load_cases(base: Scene) -> Iterator[Case]:
    for k in range(-2, 7):
        yield Case(f"axial {10.0**k:g} N", "axial load", _load(base, (0.0, 0.0, 10.0**k)))
    yield Case("axial -5000 N", "axial load", _load(base, (0.0, 0.0, -5000.0)))
    for force in (1.0, 100.0, 5000.0):
        yield Case(f"lateral {force:g} N", "lateral load", _load(_free(base), (force, 0.0, 0.0)))
    for moment in (0.5, 50.0):
        scene = _load(_free(base), (0.0, 0.0, 0.0), moment)
        yield Case(f"moment {moment:g} N m", "moment only", scene)
    clear = _load(_balls(base, -5e-6), (0.0, 0.0, 0.0), 0.01, at=0.3)
    yield Case("moment 0.01 N m, clearance, clamped", "moment only", clear)
    alone = _offset(with_balls(base, 1), -3e-3, -5e-6)
    yield Case("offset -3 mm, away from one loose ball", "offset", replace(alone, loads=()))
    for oversize in (0.0, 7e-6):
        for force in (0.0, 5000.0):
            name = f"offset 3 mm, {force:g} N, {'preloaded' if oversize else 'no preload'}"
            yield Case(name, "offset", _load(_offset(base, 3e-3, oversize), (0.0, 0.0, force)))


def _fit_cases(base: Scene) -> Iterator[Case]:
    for gap in (5e-6, 50e-6):
        for force in (0.01, 1.0, 5000.0):
            scene = _load(_balls(base, -gap), (0.0, 0.0, force))
            yield Case(f"clearance {gap * 1e6:g} um, {force:g} N", "clearance", scene)
    for tight in (0.0, 1e-6, 7e-6, 20e-6):
        for force in (0.0, 5000.0):
            scene = _load(_balls(base, tight), (0.0, 0.0, force))
            yield Case(f"preload {tight * 1e6:g} um, {force:g} N", "preload", scene)
    for half in (5e-6, 20e-6):
        for tight in (0.0, 7e-6):
            for seed in (1, 2, 3):
                name = f"random +-{half * 1e6:g} um, preload {tight * 1e6:g} um, seed {seed}"
                yield Case(name, "random balls", _balls(base, tight, half, seed))


def _stiffness_cases(base: Scene) -> Iterator[Case]:
    factors = [10.0**k for k in (-3, -2, -1, 1, 2, 3)]
    for f in factors:
        yield Case(f"shaft x {f:g}, contacts unchanged", "shaft stiffness", shaft_scaled(base, f))
    for f in (1e-3, 1e3):
        name = f"screw modulus x {f:g}, its contacts with it"
        yield Case(name, "shaft stiffness", _materials(base, f, 1.0, 1.0))
    for f in factors:
        yield Case(f"all moduli x {f:g}", "moduli", _materials(base, f, f, f))


def _geometry_cases(base: Scene) -> Iterator[Case]:
    for ratio in (1.01, 1.001, 1.0001, 1.00001):
        close = conforming(base, ratio)
        yield Case(f"r_G/r_B {ratio:g}, axial", "conformity", close)
        yield Case(f"r_G/r_B {ratio:g}, lateral", "conformity", _load(_free(close), (1000.0, 0.0, 0.0)))
    for count in (3, 10, 32, 100, 300, 1000):
        yield Case(f"{count} balls", "ball count", with_balls(base, count))
    for lead in (0.0, 5e-3, 7e-3, 20e-3, 40e-3):
        yield Case(f"lead {lead * 1e3:g} mm", "lead", with_lead(base, lead))
    for angle in (5, 15, 30, 45, 60, 75, 85):
        turned = replace(base, track=replace(base.track, contact_angle=math.radians(angle)))
        yield Case(f"contact angle {angle} deg", "contact angle", turned)
        if angle in (5, 85):
            held = replace(turned, supports=(Support(0.0, (("rz", 0.0),)),))
            loaded = _load(held, (1000.0, 0.0, 100.0))
            yield Case(f"contact angle {angle} deg, lateral", "contact angle", loaded)


def _mechanism_cases(base: Scene) -> Iterator[Case]:
    one = replace(base, balls=replace(base.balls, azimuths=(0.0,)))
    for force in (0.01, 5000.0):
        yield Case(f"one ball, {force:g} N", "one ball", _load(one, (0.0, 0.0, force)))
    pushed = replace(_free(_balls(one, 1e-6)), loads=())
    yield Case("one ball, squeezed, free to move off", "one ball", pushed)
    ring = with_lead(base, 0.0)
    rz = (Support(0.0, (("rz", 0.0),)),)
    yield Case("one support: rotation", "support", replace(base, supports=rz))
    yield Case("no support, no load", "support", replace(base, supports=(), loads=()))
    yield Case("bearing, no support", "support", replace(ring, supports=()))
    yield Case("no support", "support", replace(base, supports=()), HELIX)
    held = (Support(0.0, (("ux", 0.0),)),)
    yield Case("one support: lateral", "support", replace(base, supports=held), HELIX)
    twist = (Load(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 10.0)),)
    yield Case("bearing under torque", "support", replace(ring, supports=(), loads=twist), ROTATION)
    two = replace(base, supports=rz, balls=replace(base.balls, azimuths=(0.0, 0.5)))
    yield Case("two balls, one support", "support", two, TWO_BALLS)


def cases() -> list[Case]:
    """All hard scenes, from the shipped ``lin-case1`` by replacement, in a fixed order."""
    base = shipped("lin-case1")
    groups = (_load_cases, _fit_cases, _stiffness_cases, _geometry_cases, _mechanism_cases)
    return [replace(c, scene=replace(c.scene, name=c.name)) for group in groups for c in group(base)]


# --- solving


def attempt(case: Case, formulation: str) -> Attempt:
    """Solve one case by one of ``FORMULATIONS``; a failure is a row, never an exception of the solvers.

    Ours runs on the scene's own partition (a node at every contact). The source runs on its own 15 mm partition, with
    the rigid arcs of our model for the flanks (``kinematics="arc"``), so that both solve the same equations.
    """
    if formulation in BACKENDS:
        return _elastic(case, formulation)
    return _ours(case) if formulation == ENERGY else _source(case, formulation, _on_source_partition(case.scene))


@cache
def _load_kernels() -> None:
    """Load (or compile) the kernels of this process before anything is timed."""
    solve_static(shipped("lin-case1"), engine="compiled")


def _ours(case: Case) -> Attempt:
    _load_kernels()
    begin = perf_counter()
    row = _row_of(case, ENERGY, solve_static(case.scene, engine="compiled"), begin)
    return replace(row, difference_percent=0.0 if row.converged else None)


def _elastic(case: Case, formulation: str) -> Attempt:
    """A case with elastic bodies; where its dimensions leave no body (no land, no wall), or more balls than `ELASTIC_LIMIT`
    would take minutes, it is not attempted."""
    begin = perf_counter()
    try:
        if case.scene.ball_count > ELASTIC_LIMIT:
            raise ValueError(f"{case.scene.ball_count} balls")
        result = solve_elastic(case.scene, backend=LADDER[BACKENDS[formulation]], engine="compiled")
    except ValueError as error:
        status, spent = f"not attempted: {error}", perf_counter() - begin
        return _attempt(case, formulation, status, seconds=spent, reason=status)
    return _row_of(case, formulation, result, begin)


def _row_of(case: Case, formulation: str, result: StaticResult, begin: float) -> Attempt:
    """What a solver of this project made of a case since ``begin``; no difference from the energy solver."""
    status, s = _fault(result) or result.status, result.solver
    return _attempt(
        case,
        formulation,
        status,
        iterations=s.iterations,
        residual=_finite(s.residual),
        round_off_bound=s.round_off_bound,
        seconds=perf_counter() - begin,
        unknowns=s.unknowns,
        reason="; ".join((_short(status), *result.warnings)),
    )


def _attempt(case: Case, formulation: str, status: str, **found: Any) -> Attempt:
    """What became of a case; found: fields of `Attempt` on the solution."""
    return Attempt(case.name, case.group, formulation, status, case.expected, status == CONVERGED, **found)


def _fault(result: StaticResult) -> str:
    """Contradiction to a solver's claim of convergence; empty if there is none."""
    if not result.converged:
        return ""
    s, balance = result.solver, result.equilibrium
    if not (np.all(np.isfinite(result.load)) and np.all(np.isfinite(result.centreline))):
        return "claims convergence, but loads or motions are not finite"
    if not s.residual <= max(ACCEPTED, s.round_off_bound):
        return f"claims convergence, but the residual is {s.residual:.1e}"
    if balance is None or not balance.largest <= BALANCE:
        return "claims convergence, but forces and moments on the screw do not balance"
    return ""


def _on_source_partition(scene: Scene) -> Scene:
    return replace(scene, ingredients=replace(scene.ingredients, partition="source"))


def dense_unknowns(scene: Scene) -> int:
    """Unknowns of the source's formulation: two per ball's centre, four contact angles, and the free nodal motions."""
    layout = ball_layout(scene)
    problem = build(scene, specimen(scene, layout), layout, np.ones(4, dtype=bool))
    return 6 * layout.z.size + problem.unknowns


def _source(case: Case, formulation: str, scene: Scene, ours: StaticResult | None = None) -> Attempt:
    unknowns = dense_unknowns(scene)
    iterations, residual, seconds, difference = 0, math.nan, 0.0, None
    if unknowns > DENSE_LIMIT:
        status = f"not attempted: dense Jacobian of {unknowns} unknowns"
    elif scene.ingredients.screw == "rigid":
        status = "not attempted: the source's equations are those of a beam"
    else:
        found = solve_source(scene, kinematics="arc", start=SOURCE[formulation])
        status, iterations, residual, seconds = found.status, found.iterations, found.residual, found.seconds
        if found.converged:
            ours = ours if ours is not None else solve_static(scene, engine="compiled")
            difference = _difference(found.load, ours) if ours.converged else None
    return _attempt(
        case,
        formulation,
        status,
        iterations=iterations,
        residual=_finite(residual),
        seconds=seconds,
        unknowns=unknowns,
        difference_percent=difference,
        reason=_short(status) + _apart(difference),
    )


def _apart(difference: float | None) -> str:
    if difference is None or difference <= SAME:
        return ""
    root = "another root of the contact conditions (beyond the arc)"
    return f"; loads differ from the energy solver's by {difference:.3g} %: {root}"


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _difference(load: Array, ours: StaticResult) -> float:
    top = float(ours.load.max(initial=0.0))
    change = float(np.abs(load - ours.load).max())
    return float(np.abs(error_percent(change, 0.0, top))) if top > 0.0 else 0.0


def _short(status: str) -> str:
    """The first clause of a status, and the second where the first only says that the screw is not held."""
    parts = status.split(": ")
    return ": ".join(parts[:2]) if parts[0] == "not held" else status.split(" (")[0]


def _rows_of(case: Case) -> list[Attempt]:
    rows = [_ours(case)]
    scene = _on_source_partition(case.scene)
    ours = solve_static(scene, engine="compiled") if dense_unknowns(scene) <= DENSE_LIMIT else None
    return rows + [_elastic(case, f) for f in BACKENDS] + [_source(case, f, scene, ours) for f in SOURCE]


def table(progress: Callable[[int, int, str], None] = lambda *_: None, *, n_jobs: int = 2) -> list[Attempt]:
    """Every case by every formulation, in the order of ``cases``; two processes share the work.

    progress: called with the number of cases done, their total, and the name of the one just done.
    """
    from joblib import Parallel, delayed

    every, rows = cases(), list[Attempt]()
    with local():
        workers = Parallel(n_jobs=n_jobs, return_as="generator")
    for i, found in enumerate(workers(delayed(_rows_of)(c) for c in every)):
        rows += found
        progress(i + 1, len(every), every[i].name)
    return rows


def failures(rows: Sequence[Attempt]) -> list[Attempt]:
    """Rows of the solvers of this project whose status is not the expected one: converged, or the mechanism by name."""
    ours = [r for r in rows if r.formulation == ENERGY or r.formulation in BACKENDS]
    return [r for r in ours if r.status != r.expected and r.tried]


# --- the table


def wide_rows(rows: Sequence[Attempt]) -> list[dict[str, Cell]]:
    """One row per case, one status per formulation."""
    by_case: dict[str, dict[str, Cell]] = {}
    for row in rows:
        line = by_case.setdefault(row.case, {"case": row.case, "group": row.group})
        line[row.formulation] = short(row)
        if row.formulation == ENERGY:
            line |= {key: getattr(row, key) for key in ("iterations", "residual", "seconds", "unknowns")}
            line["bound"] = row.round_off_bound
    return list(by_case.values())


def short(row: Attempt) -> str:
    """Status for a table: how it ended, with iterations and residual where it converged."""
    if row.status == CONVERGED:
        apart = row.difference_percent
        other = f", another root ({apart:.2g} % off)" if apart is not None and apart > SAME else ""
        return f"converged, {row.iterations} it.{other}"
    return row.status.split(" (")[0]


def tally(rows: Sequence[Attempt]) -> dict[str, tuple[int, int, int]]:
    """Per formulation: cases solved (or its mechanism named), cases tried, cases."""
    out = {}
    for formulation in FORMULATIONS:
        attempts = [r for r in rows if r.formulation == formulation]
        tried = [r for r in attempts if r.tried]
        out[formulation] = (sum(r.status == r.expected for r in tried), len(tried), len(attempts))
    return out


Record = dict[str, Any]

#: How a scene may end, the good ways first.
RIGHT, REFUSED, PROVEN, NOT_UNIQUE = "right", "refused as input", "refused, proven", "refused, contacts not unique"

WRONG, UNPROVEN, SILENT, CRASHED = "wrong", "refused, unproven", "refused without a mechanism", "traceback"

MISSTATED = "misstated by the command line"

GOOD, BAD = (RIGHT, REFUSED, PROVEN, NOT_UNIQUE), (WRONG, UNPROVEN, SILENT, CRASHED, MISSTATED)


def read(path: Path) -> list[Record]:
    """Records of a file; none where there is none, or it holds something else."""
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return []
    good = isinstance(records, list) and all(
        isinstance(r, dict) and {"command", "scenes", "files", "bad"} <= set(r) for r in records
    )
    return records if good else []


def shipped_records() -> list[Record]:
    """Records that come with the package."""
    return read(Path(__file__).with_name("campaign.json"))


def rows(records: Sequence[Record]) -> list[Row]:
    """Rows of the report's table, a campaign each: its command and version, and how many scenes, damaged files and killed
    processes ended in which way."""
    out = []
    for r in records:
        bad: Row = {verdict: r["scenes"].get(verdict, 0) for verdict in BAD}
        files = [row for kind, row in r["files"].items() if kind != "kill"]
        ended: Row = {
            "command": r["command"],
            "version": r.get("version", ""),
            "right": r["scenes"][RIGHT],
            "refused with a proven reason": sum(r["scenes"][verdict] for verdict in GOOD[1:]),
            "wrong or unproven": sum(r["scenes"].get(verdict, 0) for verdict in BAD),
            "damaged files": sum(sum(row.values()) for row in files),
            "of these read wrongly": sum(row["bad"] for row in files),
            "killed processes": sum(r["files"].get("kill", {}).values()),
            "of these not whole": r["files"].get("kill", {}).get("bad", 0),
        }
        out.append(ended | bad)
    return out
