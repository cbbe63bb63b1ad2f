"""The functions of the library: each does what the command of its name does, and returns its result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from compare.api.results import Friction, Judged, Result, Solution
from compare.errors import InputError
from compare.scenes import catalogue
from compare.scenes.scene_file import whole
from meshes.axis import Assembly
from meshes.parts import Scene

if TYPE_CHECKING:
    from compare.scenes.kinds.common import KindScene


def read(name: str | Path) -> Scene | Assembly | KindScene:
    """The scene of a file, or the shipped scene of that name: a frozen record in SI units, to be changed by
    ``dataclasses.replace``.

    Raises compare.errors.InputError, whose ``lines()`` hold every fault of the file.
    """
    return catalogue.any_scene(str(name))


def solve(scene: Scene | Assembly | str | Path, model: str = "", *, member: int = 0) -> Solution:
    """Contact loads and all that they answer, by a low-order model.

    scene: as `read` gives it, or a name or file; model: refined unless given; member: specimen of a scene with
    random errors.
    Raises InputError for what cannot be solved so; no equilibrium is no error: see ``Solution.converged``.
    """
    described = _described(scene)
    if isinstance(described, Assembly):
        return _solve_axis(described, model, member)
    from compare.commands.solve_output import as_json
    from compare.commands.summary import answers_json
    from compare.models.answers import gather
    from compare.models.model_form import estimate
    from compare.models.registry import DEFAULT, Options, run_model

    own = whole(described, described.name)
    name, options = model or DEFAULT, Options(member=member)
    result = run_model(own, name, options)
    found = gather(own, result, name, options) if result.converged else None
    worth = estimate(own, result) if found is not None else None
    data = as_json(own, result, worth, None if found is None else answers_json(own, result, found))
    angle = np.where(result.load > 0.0, np.degrees(result.contact_angle), np.nan)
    head = f"{own.name}, {name}: {result.status}"
    return Solution(data, "summary", (head, *result.warnings), result.load, angle)


def _solve_axis(axis: Assembly, model: str, member: int) -> Solution:
    """A shaft with several rolling sets."""
    from compare.commands.axis_output import as_json
    from compare.models.axis import run_axis
    from compare.models.axis_answers import gather

    result = run_axis(axis, model, member=member)
    data = as_json(axis, result, gather(axis, result, member) if result.converged else None, member)
    return Solution(data, "sets", (f"{axis.name}, {data['model']}: {data['status']}",))


def friction(scene: Scene | Assembly | KindScene | str | Path, *, mu: Sequence[float] = (), model: str = "") -> Friction:
    """Ball motion, losses, friction torque, efficiency, of a scene of any kind.

    mu: coefficients of friction in place of the scene's; model: of the contact loads, refined unless given. The first use
    compiles kernels for some 20 s. Raises InputError.
    """
    from compare.commands.friction_whole import Choices, solve_scene

    described = _described(scene)
    choices = Choices(model, tuple(mu))
    if isinstance(described, Scene):
        answer = solve_scene(described, choices)
    elif isinstance(described, Assembly):
        from compare.commands.axis_friction import solve_axis

        answer = solve_axis(described, choices)
    else:
        from compare.commands.friction_kinds import solve_kind

        if choices != Choices():
            raise InputError("friction", "mu, model", "given", f"none for a {described.kind}", "the scene holds its own")
        answer = solve_kind(described)
    shown = "torque" if "torque" in answer.data else ""
    return Friction(answer.data, shown, tuple(answer.data.get("warnings", ())))


def compare(
    scene: Scene | str | Path,
    models: Sequence[str] = (),
    *,
    levels: int | None = None,
    store: str | Path = "rollbench-reference",
) -> Result:
    """Low-order models beside the 3D reference: for each model its errors in per cent of the mean load, its largest load,
    pressure and displacement.

    models: those that the report compares unless given; levels: mesh levels to compute where they are not stored (None:
    the best stored reference; all levels where there is none, which takes long); store: folder of the reference's runs.
    Raises InputError, Refusal where no run of the reference converged.
    """
    from compare.commands.compare_output import answers_of, compared, verdict
    from compare.commands.study import on_terminal, unconverged
    from compare.models.comparison import compared_models, suited
    from compare.reference.estimate import reference
    from compare.reference.jobs import Engine, ensure, plan
    from compare.reference.levels import LEVELS
    from compare.reference.store import shipped_store
    from meshes.cache import default_root

    described = _described(scene)
    own, stores = whole(described, described.name), (Path(store), shipped_store())
    chosen = compared_models(tuple(models)) or suited(own)
    failed = []
    if levels is not None or reference(own, stores) is None:
        wanted = range(1, (levels or len(LEVELS)) + 1)
        failed = ensure(plan([own], wanted), stores[0], Engine(cache=default_root()), on_terminal, stores)
    found = reference(own, stores)
    if found is None:
        raise unconverged(own.name, failed)
    each = compared(own, chosen, found, stores)
    data = {
        "scene": own.name,
        "levels": [run.level for run in found.runs],
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
    return Result(data, "models", (verdict(each, found),))


def check(
    scene: Scene | str | Path,
    *,
    max_error: float | None = None,
    model: str = "",
    loads: str | Path | None = None,
    levels: int | None = None,
    store: str | Path = "rollbench-reference",
    compute: bool = True,
) -> Judged:
    """The gate: whether a model's loads, or those of another program, agree with the 3D reference within a limit.

    max_error: limit in per cent, the scene's own or 7 unless given; loads: CSV file with the columns ball, flank, newton;
    compute: whether runs of the reference that are missing are computed. Raises InputError.
    """
    from compare.commands.study import on_terminal
    from compare.gate.user import asked, check_scenes
    from compare.gate.verdict import worst_of
    from compare.reference.jobs import Engine
    from meshes.cache import default_root

    described = _described(scene)
    own = whole(described, described.name)
    what = asked(
        model=model,
        loads=None if loads is None else Path(loads),
        max_error=max_error,
        levels=levels,
        store=Path(store),
        compute=compute,
    )
    verdicts = check_scenes([own], what, Engine(cache=default_root()), on_terminal)
    gravest = worst_of([v.word for v in verdicts])
    data = {"verdict": gravest, "passed": gravest == "pass", "verdicts": [v.as_json() for v in verdicts]}
    return Judged(data, "verdicts", tuple(v.line() for v in verdicts))


def _described(scene: Scene | Assembly | KindScene | str | Path) -> Scene | Assembly | KindScene:
    return read(scene) if isinstance(scene, (str, Path)) else scene
