"""The functions of the library: each does what the command of its name does, and returns its result.

Linear algebra has one thread while a function runs, and as many as before when it returns. ``OMP_NUM_THREADS``, or the
variable of one library such as ``OPENBLAS_NUM_THREADS``, is the switch: where it is set, it holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rollbench.compare.api.results import Friction, Judged, Result, Solution
from rollbench.compare.errors import ArgumentError
from rollbench.compare.registration import needed
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle, cases_by_name
from rollbench.compare.scenes.scene_file import each_case, solvable
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.meshes.threads import held_to_one_thread

if TYPE_CHECKING:
    from rollbench.compare.commands.comparing.compare_output import Comparison
    from rollbench.compare.reference.estimate import Reference
    from rollbench.compare.reference.store import Run


def read(name: str | Path) -> Described:
    """The scene of a file, or the shipped scene of that name: a frozen record in SI units, to be changed by
    ``dataclasses.replace``.

    Raises rollbench.InputError, whose ``lines()`` hold every fault of the file.
    """
    return catalogue.any_scene(str(name))


@held_to_one_thread()
def solve(scene: Described | str | Path, model: str = "", *, member: int = 0) -> Solution:
    """Contact loads and all that they answer, by a low-order model.

    scene: as `read` gives it, or a name or file; model: refined unless given; member: specimen of a scene with
    random errors.
    Raises InputError for what cannot be solved so; no equilibrium is no error: see ``Solution.converged``.
    """
    from rollbench.compare.commands.solving.cases_output import cases_json
    from rollbench.compare.commands.solving.output import case_json
    from rollbench.compare.models.load_cases import solve_any
    from rollbench.compare.models.registry import Options, default_model
    from rollbench.compare.models.together import together

    described, options = _described(scene), Options(member=member)
    scenes = each_case(described, described.name)
    solved = [solve_any(one, model or default_model(one), options) for one in scenes]
    cycle = described if isinstance(described, DutyCycle) else None
    data = case_json(solved[0]) if cycle is None else cases_json(cycle, solved, together(cycle, solved))
    notes = (f"{described.name}, {data['model']}: {data['status']}", *(w for one in solved for w in one.result.warnings))
    each = [loads_and_angles(one.result) for one in solved if isinstance(one.result, StaticResult)]
    if not each:
        return Solution(data, "sets" if cycle is None else "summary", notes)
    return Solution(data, "summary", notes, *(each[0] if cycle is None else map(np.array, zip(*each, strict=True))))


def loads_and_angles(result: StaticResult) -> tuple[Array, Array]:
    """Contact loads [N] and, where there is load, angles [deg], ``(n, 4)`` each."""
    return result.load, np.where(result.load > 0.0, np.degrees(result.contact_angle), np.nan)


@held_to_one_thread()
def friction(scene: Described | str | Path, *, mu: Sequence[float] = (), model: str = "") -> Friction:
    """Ball motion, losses, friction torque, efficiency, of a scene of any kind.

    mu: coefficients of friction in place of the scene's; model: of the contact loads, refined unless given. The first use
    compiles kernels for some 20 s. Raises InputError.
    """
    data = needed("friction of a scene", "friction", "scene", str(scene))(_described(scene), tuple(mu), model)
    shown = "torque" if "torque" in data else ""
    return Friction(data, shown, tuple(data.get("warnings", ())))


@held_to_one_thread()
def compare_models(
    scene: Described | str | Path,
    models: Sequence[str] = (),
    *,
    levels: int | None = None,
    reference: str | Path | None = None,
    store: str | Path = "rollbench-reference",
) -> Result:
    """Low-order models beside the 3D reference: for each model its errors in per cent of the mean load, its largest load,
    pressure and displacement.

    models: those that the report compares unless given; levels: mesh levels to compute where they are not stored (None:
    the best stored reference; all levels where there is none, which takes long); reference: your own, in place of the 3D
    reference; store: folder of the reference's runs. Raises InputError, Refusal where no run of the reference converged.
    """
    from rollbench.compare.commands.comparing.compare_output import verdict
    from rollbench.compare.commands.comparing.study import each_compared, named, own_references, together_json
    from rollbench.compare.commands.printing import on_terminal
    from rollbench.compare.models.comparison import compared_models
    from rollbench.compare.models.referenced import referenced
    from rollbench.compare.reference.jobs import Engine, ensure, plan
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.reference.store import shipped_store
    from rollbench.meshes.cache import default_root

    described = _described(scene)
    scenes, stores = each_case(described, described.name), (Path(store), shipped_store())
    chosen, cases = compared_models(tuple(models)), cases_by_name([described])
    warnings: list[str] = []
    failed: list[Run] = []
    if reference is not None:
        if levels is not None:
            raise ArgumentError("reference", str(reference), "without `levels`", "leave one out")
        names = {name: case.case.name for name, case in cases.items()}
        references = own_references(scenes, Path(reference), names, warnings)
    else:
        if missing := [x for x in scenes if levels is not None or not referenced(x, stores)]:
            wanted = range(1, (levels or len(LEVELS)) + 1)
            failed = ensure(plan(missing, wanted), stores[0], Engine(cache=default_root()), on_terminal, stores)
        references = [referenced(x, stores) for x in scenes]
    pairs = list(each_compared(scenes, references, chosen, stores, failed, own=reference is not None))
    lines = (*(f"WARNING: {words}" for words in warnings), *(verdict(each, one.found) for one, each in pairs))
    results = [_compared_json(each, one.found) | named(one) for one, each in pairs]
    if isinstance(described, DutyCycle):
        rows = [row | cases[one.described].keys for row, (one, _) in zip(results, pairs, strict=True)]
        whole = together_json(described, {(one.described, one.set): each for one, each in pairs})
        summary = whole[0] if len(whole) == 1 else {row["set"]: row for row in whole}
        return Result({"scene": described.name, "summary": summary, "cases": rows}, "summary", lines)
    if isinstance(described, Scene):
        return Result(results[0], "models", lines)
    return Result({"scene": described.name, "sets": results}, "sets", lines)


def _compared_json(each: Comparison, reference: Reference) -> dict[str, Any]:
    """What `compare` tells of a scene, or of one of several sets on a shaft."""
    from rollbench.compare.commands.comparing.compare_output import answers_of

    return {
        "scene": reference.scene,
        "levels": list(reference.levels),
        "reference_status": reference.unsettled or "converged",
        "models": {
            b.label: {
                "largest_error_percent": None if b.error is None else b.error.max_percent,
                "rms_error_percent": None if b.error is None else b.error.rms_percent,
                "largest_load_N": float(b.answer.load.max(initial=0.0)),
                "pressure_MPa": 1e-6 * b.pressure,
                "displacement_um": 1e6 * b.displacement,
            }
            for b in each.models
        },
        "answers": {b.label: answers_of(b) for b in (each.itself, *each.models)},
    }


@held_to_one_thread()
def check(
    scene: Described | str | Path,
    *,
    max_error: float | None = None,
    model: str = "",
    loads: str | Path | None = None,
    values: str | Path | None = None,
    limits: Mapping[str, float] | None = None,
    reference: str | Path | None = None,
    strict: bool = False,
    levels: int | None = None,
    store: str | Path = "rollbench-reference",
    compute: bool = True,
) -> Judged:
    """The gate: whether a model's loads, or those of another program, agree with the 3D reference within a limit.

    max_error: limit in per cent, the scene's own or 7 unless given; loads: CSV file with the columns ball, flank, newton;
    values: CSV file with the columns quantity, value, unit, where; limits: of other quantities by name, in
    per cent, of a contact angle in degrees; reference: your own, in place of the 3D reference; strict: unknown columns are
    an error; compute: whether runs of the reference that are missing are computed. Raises InputError.
    """
    from rollbench.compare.commands.comparing.check import judged_cases, verdicts_json
    from rollbench.compare.gate.user import asked
    from rollbench.compare.reference.jobs import Engine
    from rollbench.meshes.cache import default_root

    described = _described(scene)
    request = asked(
        model=model,
        loads=None if loads is None else Path(loads),
        values=None if values is None else Path(values),
        max_error=max_error,
        limits=[f"{name}={number}" for name, number in (limits or {}).items()],
        reference=None if reference is None else Path(reference),
        strict=strict,
        levels=levels,
        store=Path(store),
        compute=compute,
    )
    warnings: list[str] = []
    verdicts = judged_cases([described], [described.name], request, Engine(cache=default_root()), warnings.append)
    lines = (*(f"WARNING: {warning}" for warning in warnings), *(v.line() for v in verdicts))
    return Judged(verdicts_json([described], verdicts) | {"warnings": warnings}, "verdicts", lines)


@held_to_one_thread()
def mesh_study(
    scene: Described | str | Path,
    *,
    levels: int | None = None,
    spread: bool = False,
    store: str | Path = "rollbench-reference",
) -> Result:
    """The 3D reference on several mesh levels: what each level gives, observed orders, uncertainty of every contact.

    levels: 1 to this one; unless given, 1 and 3, of which the second is clearly more accurate; spread: modelling choices
    that are not printed are varied too, on the coarsest level; store: folder of the runs, where those that are missing are
    computed. Raises InputError, Refusal where no run converged.
    """
    described = _described(scene)
    study = needed("mesh study", "mesh_study", "scene", described.name)
    return Result(*study(solvable(described, described.name), levels, spread=spread, store=Path(store)))


@held_to_one_thread()
def sweep(
    scene: str | Path,
    vary: Sequence[str],
    *,
    samples: int = 256,
    method: Literal["sobol", "lhs", "grid"] = "sobol",
    model: str = "",
    seed: int = 0,
    out: str | Path = "rollbench-sweep",
    outputs: Sequence[str] = (),
) -> Result:
    """A scene solved at many values of its keys: statistics, effects and Sobol indices of its outputs.

    scene: name or file; vary: keys with their range or values, ``["errors.balls.oversize=0 um:7 um"]``; out: folder of the
    samples (samples.csv) and the summary: samples stored there are not solved again; outputs: names of the outputs that are
    computed, all unless given. Raises InputError.
    """
    swept = needed("sweep", "sweep", "vary", " ".join(vary))
    data = swept(str(scene), vary, samples, method, model, seed, Path(out), outputs)
    return Result(data, "outputs", (f"{data['converged']} of {data['solved']} samples converged: {Path(out)}",))


@held_to_one_thread()
def report(
    scene: str | Path | None = None,
    *,
    only: Sequence[str] = (),
    out: str | Path = "rollbench-report",
    store: str | Path = "rollbench-reference",
    reference: str | Path | None = None,
    quick: bool = False,
    stored: bool = False,
    fresh: bool = False,
    everything: bool = False,
) -> Result:
    """The validation report, or one page on a scene (a name or file), written to the folder ``out``.

    only, quick, stored, fresh, everything: of the whole report, as the command's options (everything: the slow sections
    too); reference: of a page, your own in place of the 3D reference.
    ``["passed"]`` of the result is False where a run of the reference that was recomputed does not agree with the stored
    one. Raises InputError, Refusal where the scene does not solve.
    """
    folder = Path(out)
    choices = {"only": only, "quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    given = [name for name, value in choices.items() if value]
    if scene is not None and given:
        raise ArgumentError(given[0], "given", "without a scene", "leave it out")
    data: dict[str, Any] = {"page": str(folder / "index.html"), "passed": True}
    if scene is not None:
        from rollbench.compare.commands.reporting.scene_page import make_page

        page = make_page(str(scene), folder, Path(store), None if reference is None else Path(reference))
        warned = tuple(f"WARNING: {warning}" for warning in page.warnings)
        return Result(data | {"verdict": page.verdict}, "", (*warned, page.verdict))
    if reference is not None:
        raise ArgumentError("reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.commands.printing import print_answer
    from rollbench.compare.commands.reporting.report import make_report

    answer = make_report(only, folder, store=Path(store), quick=quick, stored=stored, fresh=fresh, everything=everything)
    data["passed"] = print_answer(answer) == 0
    return Result(data)


def _described(scene: Described | str | Path) -> Described:
    return read(scene) if isinstance(scene, (str, Path)) else scene
