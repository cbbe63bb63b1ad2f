"""A user's scenes against their 3D reference: loads of a model, or of any other program, with a verdict on each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rollbench.comparison.errors import InputError, Refusal
from rollbench.comparison.gate.loads_file import GivenLoads, read_loads
from rollbench.comparison.gate.loads_looks import looks
from rollbench.comparison.gate.verdict import LARGEST, LIMIT, Limits, Verdict, judge
from rollbench.comparison.models.comparison import compared_models, options_for
from rollbench.comparison.models.referenced import Referenced, answered, referenced
from rollbench.comparison.models.registry import DEFAULT, MODELS, run_model
from rollbench.comparison.reference.estimate import Reference
from rollbench.comparison.reference.jobs import Engine, ensure, plan
from rollbench.comparison.reference.levels import LEVELS
from rollbench.comparison.reference.store import load, shipped_store
from rollbench.comparison.reference.tasks import Solvable, groups
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES

#: Mesh levels that are computed where none is asked for: the fewest that give an uncertainty.
ENOUGH = 2


@dataclass(frozen=True)
class Asked:
    """What is asked: model, or file of loads; limit [%] in place of the scenes' own (None: theirs, or `LIMIT`); levels of
    the reference to compute at least (None: the best stored, `ENOUGH` where there are fewer); compute: whether runs that
    are missing may be computed; stores: folders of runs, the first takes those that are computed."""

    stores: tuple[Path, ...]
    model: str = DEFAULT
    loads: Path | None = None
    max_error: float | None = None
    levels: int | None = None
    compute: bool = True


def asked(
    *,
    model: str = "",
    loads: Path | None = None,
    max_error: float | None = None,
    levels: int | None = None,
    store: Path = Path("rollbench-reference"),
    stored: Path | None = None,
    compute: bool = True,
) -> Asked:
    """What is asked, checked. Raises InputError for what cannot be asked together, or is out of range."""
    if max_error is not None and not 0.0 < max_error <= 100.0:
        raise InputError("command line", "--max-error", str(max_error), "above 0 to 100 per cent", "the gate uses 7")
    if levels is not None and not 1 <= levels <= len(LEVELS):
        raise InputError("command line", "--levels", str(levels), f"1 to {len(LEVELS)}", "two give an uncertainty")
    if levels is not None and (stored is not None or not compute):
        advice = "leave one out: stored runs are taken with all levels that are there"
        raise InputError("command line", "--levels", str(levels), "without --stored and --no-compute", advice)
    if loads is not None and model:
        advice = "the file's loads are judged: leave one out"
        raise InputError("command line", "--loads", str(loads), "without --model", advice)
    if stored is not None and not stored.is_dir():
        raise InputError("command line", "--stored", str(stored), "a folder of stored runs", "check the path")
    compared_models((model,) if model else ())
    own = store if stored is None else stored
    return Asked((own, shipped_store()), model or DEFAULT, loads, max_error, levels, compute and stored is None)


def check_scenes(scenes: Sequence[Solvable], what: Asked, engine: Engine, step: Callable[[str], None]) -> list[Verdict]:
    """Verdicts on scenes, in their order; each has one, or two where it limits the RMS error too; of several sets on one
    shaft each set has its own.

    References that are missing are computed first, scenes of one geometry together. Raises InputError for loads that do not
    fit the scene, Refusal where the model cannot take it.
    """
    if what.loads is not None and len(scenes) != 1:
        advice = "check the scenes one by one, each with its file"
        raise InputError("command line", "--loads", str(what.loads), f"one scene, not {len(scenes)}", advice)
    given = None if what.loads is None else _given(what.loads, scenes[0])
    why = _computed(scenes, what, engine, step) if what.compute else {}
    out: list[Verdict] = []
    for scene in scenes:
        limits = limits_of(scene, what.max_error)
        judged = MODELS[what.model].name if what.loads is None else what.loads.name
        each = referenced(scene, what.stores)
        if not each:
            reason = why.get(scene.name, "no stored run of its 3D reference, and none is to be computed")
            out.append(Verdict(scene.name, judged, LARGEST, "not covered", None, None, limits.largest, detail=reason))
        for one in each:
            if given is not None:
                detail = "; ".join(part for part in _said(given, one.found, limits) if part)
                verdicts = judge(judged, given.load, one.found, limits, given.flanks, detail)
            else:
                verdicts = _model(one, what.model, limits, what.stores)
            out += verdicts if one.of is None else [replace(v, scene=scene.name, set=one.of.name) for v in verdicts]
    return out


def _given(path: Path, scene: Solvable) -> GivenLoads:
    """Loads of a file. Raises InputError as `read_loads`, and for several sets on one shaft."""
    if isinstance(scene, Assembly):
        allowed = "a scene of one set"
        raise InputError(
            "command line", "--loads", f"with {scene.name}", allowed, "leave it out: a model is judged set by set"
        )
    return read_loads(path, scene.ball_count, scene)


def _said(given: GivenLoads, found: Reference, limits: Limits) -> Iterator[str]:
    """What is said of loads of another program beside their errors."""
    left = [side for side in SIDES if side not in given.flanks]
    yield f"not judged, because not given: {', '.join(left)}" if left else ""
    if given.renumbered:
        yield f"{given.renumbered} balls are numbered otherwise in the file, and were matched by azimuth and z"
    yield looks(given.load, found.load, given.flanks, limits.largest)


def limits_of(scene: Solvable, max_error: float | None) -> Limits:
    """Limits of a scene: that of the command line for the largest error, or the scene's own, or `LIMIT`."""
    if isinstance(scene, Assembly):
        return Limits(LIMIT if max_error is None else max_error)
    own = LIMIT if scene.gate.max_error is None else scene.gate.max_error
    return Limits(own if max_error is None else max_error, scene.gate.rms_error)


def _model(one: Referenced, name: str, limits: Limits, stores: Sequence[Path]) -> list[Verdict]:
    """Verdicts on a model's own loads; a solver that did not converge has none, and fails."""
    scene, found = one.scene, one.found
    if one.of is not None:
        answer = answered(one.of, name)
        load, status = (None, answer) if isinstance(answer, str) else (answer.result.load, "converged")
    else:
        if not MODELS[name].suits(scene):
            advice = "rollbench list tells what each model describes"
            raise InputError("command line", "--model", f'"{name}"', f"a model that can describe {scene.name}", advice)
        result = run_model(scene, name, options_for(MODELS[name], scene, found, stores))
        load, status = result.load if result.converged else None, result.status
    if load is None:
        detail, levels = f"the model has no loads: {status}", tuple(run.level for run in found.runs)
        return [Verdict(scene.name, name, LARGEST, "fail", None, None, limits.largest, levels=levels, detail=detail)]
    return judge(name, load, found, limits)


def _computed(scenes: Sequence[Solvable], what: Asked, engine: Engine, step: Callable[[str], None]) -> dict[str, str]:
    """Compute what is missing; by scene, why it has no reference. A refusal leaves the other geometries alone."""
    why: dict[str, str] = {}
    for group in groups(scenes):
        for levels, own in _missing(group, what).items():
            try:
                failed = ensure(plan(own, levels), what.stores[0], engine, step, what.stores[1:])
            except Refusal as error:
                why |= {scene.name: str(error) for scene in own}
                continue
            why |= {run.scene: f"level {run.level} of its 3D reference: {run.status}" for run in failed}
    return why


def _missing(scenes: Sequence[Solvable], what: Asked) -> dict[tuple[int, ...], list[Solvable]]:
    """Scenes by the levels that they lack."""
    out: dict[tuple[int, ...], list[Solvable]] = {}
    for scene in scenes:
        here = [k for k in LEVELS if load(scene, k, stores=what.stores) is not None]
        least = what.levels or (ENOUGH if len(here) < ENOUGH else 0)
        lacking = tuple(k for k in range(1, least + 1) if k not in here)
        if lacking:
            out.setdefault(lacking, []).append(scene)
    return out
