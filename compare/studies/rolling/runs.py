"""Solutions ("runs") of the 3D model of rolling, on three grids for each scene, and the folder in which they are stored.

Bodies are half spaces, or finite (`hifi.rolling.bodies`): contact patches of the static 3D reference; on straight
tracks a ball and grooved bars.

The value on a grid is the rigid limit by quadrature (`hifi.rolling.balls`), plus the value of elastic bodies less that
of nearly rigid ones on the same grid.

The effect of assumptions in the models of finite bodies on two balls of a linear bearing and of a screw is stored with the
package. A report computes one of these models again and shows the agreement.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.files import read_from_first_valid_folder, replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.reference.levels import FINITE, HALF_SPACE
from rollbench.compare.reference.parallel import run_jobs
from rollbench.compare.reference.store import MeasuringConditions, measuring_conditions, shipped_store
from rollbench.compare.running import out_of_memory_error, show_progress_message
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind as shipped_case
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling.cases import RollingCase, prepare_rolling_case
from rollbench.hifi.rolling import balls
from rollbench.hifi.rolling.balls import NEARLY_RIGID, RigidRollingResult, RollingResult, RollingSettings
from rollbench.hifi.rolling.bodies import Sizes
from rollbench.hifi.rolling.patch import MARGIN
from rollbench.meshes.record_keys import digest_of_values

#: Numbers of cells of a contact along and across the groove, by level of the grid.
LEVELS = {1: (16, 24), 2: (20, 30), 3: (24, 36)}

#: Version of the mechanics and of the records in the names of stored runs; raise it when either changes.
SCHEMA = 1

#: Version of the mechanics of finite bodies in the names of stored runs; raise it when they change.
MESHED = 2

#: Sizes of the bodies by kind; None for half spaces.
BODIES = {HALF_SPACE: None, FINITE: Sizes()}

#: Points of the two quadratures of the rigid limit, whose difference is its uncertainty.
QUADRATURES = (160, 187)

#: Level of the grid with the element size of Lin's thesis, and that size by kind of scene [m].
SOURCE_LEVEL = 0

SOURCE_SIZE = {"linear pair": 0.13e-3, "linear chain": 0.13e-3, "screw pair": 0.05e-3}


@dataclass(frozen=True)
class RollingRun:
    """Solution of one scene of rolling balls by the 3D model of rolling on one grid: values, status and run time."""

    #: Name of the scene.
    scene: str
    #: Level of the grid; 0: element size of Lin's thesis.
    level: int
    #: Numbers of cells of a contact along and across the groove.
    shape: tuple[int, int]
    #: Values of the quantities with elastic bodies, by name of the quantity with its unit.
    elastic: dict[str, float]
    #: Values of the quantities with nearly rigid bodies on the same grid, by name.
    near_rigid: dict[str, float]
    #: Values of the quantities for rigid bodies (without tangential elasticity), by name, from quadrature over the
    #: contacts.
    limit: dict[str, float]
    #: Difference between the values for rigid bodies by two quadratures, by name of the quantity.
    limit_spread: dict[str, float]
    #: Values of the quantities with elastic bodies and friction in the contacts' tangent planes (flat contacts), by name.
    flat: dict[str, float]
    #: Status of the solver.
    status: str
    #: Ratio of the power that the upwind difference scheme dissipates (numerical dissipation) to the input power.
    upwind: float
    #: Largest residual of the equations.
    residual: float
    #: Processor time of the elastic solution [s].
    seconds: float
    #: Processor time of all solutions (elastic, nearly rigid, flat, rigid) [s].
    all_seconds: float
    #: Number of contact cells that stick.
    sticking: int
    #: Kind of bodies, half spaces or finite: a key of `BODIES`.
    bodies: str = HALF_SPACE
    #: Version of rollbench with which the times were measured.
    version: str = ""
    #: Digest (hash value) of the solvers' sources with which the times were measured (empty before version 0.15).
    sources: str = ""
    #: Machine on which the times were measured (empty before version 0.15).
    machine: str = ""

    @property
    def measured(self) -> MeasuringConditions:
        """Version of rollbench, sources and machine with which the run times were measured."""
        return MeasuringConditions(self.version, self.sources, self.machine)

    @property
    def converged(self) -> bool:
        """Whether all solutions converged: with elastic bodies, nearly rigid bodies, and flat (not curved) contacts."""
        return self.status == "converged"

    @property
    def values(self) -> dict[str, float]:
        """Final values by name: for rigid bodies, plus the change from nearly rigid to elastic bodies on this grid."""
        return {k: self.limit[k] + self.elastic[k] - self.near_rigid[k] for k in self.elastic}


def rolling_run_key(scene: FrictionScene, level: int, bodies: str = HALF_SPACE) -> str:
    """Return the digest (16 hexadecimal digits) of all inputs that affect the numbers of a 3D solution of rolling.

    Names and remarks of the scene do not change it. ``level``: level of the grid; ``bodies``: kind of the bodies, a key
    of `BODIES`.
    """
    scene = replace(scene, name="", title="", source="", assumed=())
    content = (SCHEMA, scene, level, LEVELS.get(level), SOURCE_SIZE.get(scene.kind), QUADRATURES, balls.NEARLY_RIGID)
    sizes = BODIES[bodies]
    return digest_of_values(*content, *(() if sizes is None else (sizes, MESHED)))[:16]


def rolling_run_path(store: Path, scene: FrictionScene, level: int, bodies: str = HALF_SPACE) -> Path:
    """Return the path of the JSON file of a 3D solution of rolling.

    ``store``: folder; ``level``: level of the grid; ``bodies``: kind of the bodies, a key of `BODIES`.
    """
    what = "" if bodies == HALF_SPACE else f"-{bodies}"
    return store / f"rolling-{Path(scene.name).stem}{what}-level{level}-{rolling_run_key(scene, level, bodies)}.json"


def load_rolling_run(
    scene: FrictionScene, level: int, stores: Sequence[Path], bodies: str = HALF_SPACE
) -> RollingRun | None:
    """Return the stored 3D solution of a scene of rolling balls on one grid; None if there is none.

    ``level``: level of the grid; ``stores``: folders, which are searched in this order; ``bodies``: kind of the bodies, a
    key of `BODIES`. A solution is also found if the scene had another name when it was stored. Damaged files are ignored.
    """
    own = rolling_run_path(Path(), scene, level, bodies).name
    renamed = f"rolling-*-level{own.rpartition('-level')[2]}"
    runs = (read_from_first_valid_folder(stores, name, _rolling_run_from_json) for name in (own, renamed))
    return next(filter(None, runs), None)


def _rolling_run_from_json(data: dict[str, Any]) -> RollingRun:
    """Return a 3D solution of rolling from the JSON values of its file."""
    return RollingRun(**(data | {"shape": tuple(data["shape"])}))


def save_rolling_run(store: Path, scene: FrictionScene, run: RollingRun) -> Path:
    """Write a 3D solution of rolling to a JSON file in the folder ``store``, and return the path of the file."""
    path = rolling_run_path(store, scene, run.level, run.bodies)
    replace_file(path, json.dumps(asdict(run), indent=1) + "\n")
    return path


def grid_shape(case: RollingCase, level: int) -> tuple[int, int]:
    """Return the numbers of grid cells of a contact along and across the groove on one level of the grid.

    On `SOURCE_LEVEL` the cells have the element size of Lin's thesis, and there are as many of them as fit into the
    largest contact.
    """
    if level != SOURCE_LEVEL:
        return LEVELS[level]
    size = SOURCE_SIZE[case.kind]
    largest = max((t for b in case.touching.balls for t in b.groove_contacts), key=lambda t: t.contact_force)
    along, across = (max(1, round(2.0 * MARGIN * a / size)) for a in balls.hertz_semi_axes(case.touching, largest))
    return along, across


def compute_run(scene: FrictionScene, level: int, bodies: str = HALF_SPACE, processes: int = 1) -> RollingRun:
    """Solve a scene of rolling balls by the 3D model on one grid.

    Parameters
    ----------
    scene
        Friction scene of rolling balls.
    level
        Level of the grid.
    bodies
        Kind of bodies, a key of `BODIES`.
    processes
        Number of processes for meshing.

    Returns
    -------
    RollingRun
        Forces, speeds and losses on this grid.

    Raises
    ------
    SceneNotCoveredError
        If the 3D model does not cover the scene, or its bodies cannot be meshed.
    InputError
        If there is not enough memory.
    """
    try:
        return _solve_on_grid(scene, level, bodies, processes)
    except MemoryError as error:
        raise out_of_memory_error(error) from error
    except ValueError as error:
        if bodies == HALF_SPACE:
            raise
        raise SceneNotCoveredError(scene.name, "bodies", str(error), f'take bodies = "{HALF_SPACE}"') from error


def _solve_on_grid(scene: FrictionScene, level: int, bodies: str, processes: int) -> RollingRun:
    """Solve a scene of rolling balls on one grid: with elastic, nearly rigid and rigid bodies, and with flat contacts.

    Contacts are curved like ball and groove except in the solution with flat contacts, whose bodies are elastic. The
    arguments are those of `compute_run`.
    """
    begin, sizes = process_time(), BODIES[bodies]
    case = prepare_rolling_case(scene, RollingSettings(LEVELS.get(level, LEVELS[1])))
    shape = grid_shape(case, level)
    systems = (case.apart, case.touching)
    elsewhere = balls.cache_kernels_of_scenes(systems, sizes, processes)
    variants = (("elastic", 1.0, True), ("near", NEARLY_RIGID, True), ("flat", 1.0, False))
    pairs = {}
    for name, share, curved in variants:
        choices = RollingSettings(shape, share, curved, sizes)
        alone = balls.solve_rolling(case.apart, choices)
        pairs[name] = alone, alone if case.touching is case.apart else balls.solve_rolling(case.touching, choices)
    limits = [[balls.solve_rigid_rolling(s, n, bodies=sizes) for s in systems] for n in QUADRATURES]
    measured = {name: forces_speeds_and_losses_by_name(case, *pair) for name, pair in pairs.items()}
    fine, other = (forces_speeds_and_losses_by_name(case, *pair) for pair in limits)
    apart, touching = pairs["elastic"]
    states = [r.status for pair in pairs.values() for r in pair if not r.converged]
    return RollingRun(
        scene=scene.name,
        level=level,
        shape=shape,
        elastic=measured["elastic"],
        near_rigid=measured["near"],
        limit={k: 0.5 * (fine[k] + other[k]) for k in fine},
        limit_spread={k: abs(fine[k] - other[k]) for k in fine},
        flat=measured["flat"],
        status=states[0] if states else "converged",
        upwind=max(r.numerical_dissipation / r.driving_power for r in (apart, touching)),
        residual=max(r.residual for pair in pairs.values() for r in pair),
        seconds=elsewhere + apart.cpu_seconds + touching.cpu_seconds,
        all_seconds=elsewhere + process_time() - begin,
        sticking=int(sum(int(c.sticks.sum()) for c in touching.contacts)),
        bodies=bodies,
        **asdict(measuring_conditions()),
    )


def forces_speeds_and_losses_by_name(
    case: RollingCase, apart: RollingResult | RigidRollingResult, touching: RollingResult | RigidRollingResult
) -> dict[str, float]:
    """Return forces, speeds, losses and torque of a 3D solution by names that end with the unit, such as "force 1-2 N".

    ``case``: scene in the form that the 3D model needs; ``apart`` and ``touching``: its solutions with balls far apart, and
    with balls that touch. "deviation 1 apart %" is the deviation of the speed of ball 1 from half the speed of the
    carriage, "orbit" is the angular speed of a ball along the track, "drive" the force that moves the carriage, and
    "increase" the relative increase of the friction loss from balls far apart to touching balls.
    """
    out: dict[str, float] = {}
    linear = case.kind.startswith("linear")
    for k, force in enumerate(touching.ball_to_ball_forces):
        out[f"force {k + 1}-{k + 2} N"] = float(force)
    for k, speed in enumerate(apart.track_speeds):
        if linear:
            out[f"deviation {k + 1} apart %"] = float(200.0 * speed / case.speed - 100.0)
        else:
            out[f"orbit {k + 1} apart rad/s" if len(apart.track_speeds) > 1 else "orbit rad/s"] = float(speed)
    if case.apart is case.touching:
        out |= {f"omega {axis} rad/s": float(w) for axis, w in zip("xy", apart.rotations[0][:2], strict=True)}
        named = zip(case.contact_names, case.apart.balls[0].groove_contacts, strict=True)
        names = [name for name, contact in named if contact.contact_force > 0.0]
        out |= {f"loss {n} mW": 1e3 * float(v) for n, v in zip(names, apart.groove_losses, strict=True)}
        return out | {"torque N mm": 1e3 * float(apart.friction_loss) / abs(case.speed)}
    out["loss apart mW"], out["loss touching mW"] = 1e3 * float(apart.friction_loss), 1e3 * float(touching.friction_loss)
    if linear:
        out["drive apart N"], out["drive touching N"] = (r.friction_loss / abs(case.speed) for r in (apart, touching))
    out["increase %"] = 100.0 * (float(touching.friction_loss / apart.friction_loss) - 1.0)
    return out


#: Scenes for choices of finite bodies: two balls of a linear bearing on bars, two of a screw on patches of the static 3D
#: reference.
LINEAR, SCREW = SCENES = ("lin-pair-a", "lin-screw-pair-b-inferred")

#: Cells of a contact along and across the groove for these choices: differences between bodies need no fine grid.
SHAPE = (12, 16)

#: Quantities that are shown for these choices.
NAMES = ("force 1-2 N", "loss apart mW", "loss touching mW", "increase %")


#: Results of rolling balls by a model of finite bodies: force between balls [N], friction losses with balls apart and
#: touching [mW], and increase of the loss if balls touch [%], by names such as "force 1-2 N".
BodyValues = dict[str, float]


def scenes_and_sizes_of_body_variants() -> dict[str, tuple[str, Sizes | None]]:
    """Return the compared models of finite bodies: by description, the name of a scene and the settings of its bodies.

    The settings are None for half-spaces.
    """
    sizes = BODIES[FINITE]
    assert sizes is not None
    return {
        "linear bearing: as shipped": (LINEAR, sizes),
        "bars of 3 ball radii instead of 5": (LINEAR, replace(sizes, bar=3.0)),
        "bars of 8 ball radii": (LINEAR, replace(sizes, bar=8.0)),
        "grooves open to 69 deg instead of 80": (LINEAR, replace(sizes, opening=1.2)),
        "3 x 3 cells in the contact zone instead of 4 x 4": (LINEAR, replace(sizes, cells=(3, 3))),
        "6 x 6 cells in the contact zone": (LINEAR, replace(sizes, cells=(6, 6))),
        "kernel of degree 3 instead of 4": (LINEAR, replace(sizes, degree=3)),
        "half spaces": (LINEAR, None),
        "screw: as shipped, the static reference's patches": (SCREW, sizes),
        "screw: a whole ball and bent bars instead": (SCREW, replace(sizes, patches=False)),
        "screw: 6 x 6 cells in the contact zone": (SCREW, replace(sizes, cells=(6, 6))),
        "screw: half spaces": (SCREW, None),
    }


def compute_body_variant(choice: str) -> BodyValues:
    """Solve rolling balls by the 3D model with one of the compared models of finite bodies.

    ``choice``: a description of `scenes_and_sizes_of_body_variants`.
    """
    name, sizes = scenes_and_sizes_of_body_variants()[choice]
    scene = shipped_case(name, FrictionScene)
    case = prepare_rolling_case(scene, RollingSettings(SHAPE))
    systems = (case.apart, case.touching)
    values = []
    for share in (1.0, NEARLY_RIGID):
        choices = RollingSettings(SHAPE, share, finite_bodies=sizes)
        values.append(forces_speeds_and_losses_by_name(case, *(balls.solve_rolling(s, choices) for s in systems)))
    elastic, near = values
    rigid = (balls.solve_rigid_rolling(s, 2 * balls.FIRST, bodies=sizes) for s in systems)
    limit = forces_speeds_and_losses_by_name(case, *rigid)
    return {k: limit[k] + elastic[k] - near[k] for k in NAMES}


# --- stored variants of the finite bodies, whose computation takes half a minute


#: Name of the file with the variants in a store.
FILE = "body_sizes.json"

#: Variant that a report computes again.
LIVE = "3 x 3 cells in the contact zone instead of 4 x 4"


def body_variants_key() -> str:
    """Return a digest of all inputs, except names and remarks, that affect the stored results for finite bodies."""
    keys = (rolling_run_key(shipped_case(name, FrictionScene), 1, FINITE) for name in SCENES)
    return digest_of_values(*keys, scenes_and_sizes_of_body_variants())


def find_body_variants(stores: Sequence[Path], *, fresh: bool) -> tuple[dict[str, BodyValues], str]:
    """Return the results of the compared models of finite bodies, and a sentence on whether they were stored or computed.

    They are computed if inputs have changed. ``stores``: folders, the first of which takes new results; ``fresh``: whether
    stored results are computed again, and stored.
    """
    kept = None if fresh else read_from_first_valid_folder(stores, FILE, _body_variants_of_present_inputs)
    if kept is None:
        found = {choice: compute_body_variant(choice) for choice in scenes_and_sizes_of_body_variants()}
        if fresh:
            rows = ",\n ".join(json.dumps({"choice": choice, "values": values}) for choice, values in found.items())
            replace_file(stores[0] / FILE, f'{{"key": "{body_variants_key()}", "variants": [\n {rows}]}}\n')
        return found, "Computed for this report."
    again = compute_body_variant(LIVE)
    off = max(abs(float(error_percent(again[name], value))) for name, value in kept[LIVE].items())
    return kept, f'Stored with the package; "{LIVE}" computed again differs by up to {off:.1g} %.'


def _body_variants_of_present_inputs(data: dict[str, Any]) -> dict[str, BodyValues]:
    """Return the results of the compared models from the JSON values of their file; ValueError for other inputs."""
    found = {row["choice"]: row["values"] for row in data["variants"]}
    if data["key"] != body_variants_key() or LIVE not in found:
        raise ValueError("results of other inputs")
    return found


def largest_change_by_body_choice(straight: bool) -> float:
    """Return the largest relative change of a force or loss if one assumption on the finite bodies is changed.

    The change is taken from the results that are part of the package. ``straight``: True for straight rails (linear
    bearing), False for rings and helices (screw).
    """
    found = json.loads((shipped_store() / FILE).read_text(encoding="utf-8"))["variants"]
    values = {row["choice"]: row["values"] for row in found}
    variants = scenes_and_sizes_of_body_variants().items()
    choices = [x for x, (name, sizes) in variants if (name == LINEAR) == straight and sizes is not None]
    first, *others = (values[choice] for choice in choices)
    return float(max(abs(other[name] / first[name] - 1.0) for other in others for name in NAMES[:3]))


def find_or_compute_rolling_runs(
    scene: FrictionScene,
    levels: Sequence[int],
    store: Path,
    engine: ComputingSettings,
    *,
    fresh: bool,
    bodies: str = "half-space",
) -> list[RollingRun]:
    """Return the 3D solutions of a scene of rolling balls on several grids; solutions that are not stored are computed.

    ``levels``: levels of the grids; ``store``: folder for new solutions, each of which is stored when it is done;
    ``engine``: number of processes, or cluster, that compute the solutions; ``fresh``: whether stored solutions are
    computed again; ``bodies``: kind of the bodies, a key of `BODIES`. Raises SceneNotCoveredError if a solution did not
    converge.
    """
    stores = (store, shipped_store())
    found = {} if fresh else {k: run for k in levels if (run := load_rolling_run(scene, k, stores, bodies)) is not None}
    missing = [k for k in levels if k not in found]
    jobs = [(compute_run, (scene, k, bodies, engine.processes_per_job)) for k in missing]
    for number, run in run_jobs(jobs, engine.backend, engine.scheduler_address, engine.parallel_jobs):
        save_rolling_run(store, scene, run)
        found[missing[number]] = run
        cells = f"{run.shape[0]} x {run.shape[1]} cells"
        show_progress_message(f"{scene.name}: level {run.level}, {cells}, {run.all_seconds:.1f} s")
    bad = next((found[k] for k in levels if not found[k].converged), None)
    if bad is not None:
        raise SceneNotCoveredError(scene.name, f"level {bad.level}", bad.status, "choose another level of the grid")
    return [found[k] for k in levels]


def check_rolling_levels(levels: Sequence[int]) -> list[int]:
    """Return the given grid levels as a list; raise InputError for a level that the 3D model of rolling does not have."""
    other = [k for k in levels if k not in LEVELS]
    if other:
        got = ", ".join("source" if k == SOURCE_LEVEL else str(k) for k in other)
        advice = "choose other levels; mesh-study with `source_mesh=True` shows the element size of Lin's thesis"
        allowed = f"1 to {len(LEVELS)} for scenes in which single balls roll with friction"
        raise ArgumentError("levels", got, allowed, advice)
    return list(levels)
