"""What the survey keeps of one scene: what it is, whether the 3D reference answered, how far off the models are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import InputError, one_line
from rollbench.compare.measure import load_error
from rollbench.compare.models.applicability import DESCRIPTORS
from rollbench.compare.models.comparison import from_run
from rollbench.compare.models.model_form import QUANTITIES, Point, estimate, point, rigidity, section, shipped_points
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.reference.computing import compute
from rollbench.compare.reference.jobs import keep
from rollbench.compare.reference.store import Run, read
from rollbench.compare.reference.tasks import Task
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies.survey.draw import scene_text
from rollbench.lowfi.rating.life import filled_turns
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions

#: Models that are compared, and the mesh level.
MODELS, LEVEL = ("refined", "lin"), 1
#: Element size of the shafts that say what a cut does, over the level's: half of the time, for 0.02 % of the mean load.
CUT_CELLS = 2.0
#: By how much the loads are raised for the tangent rigidity.
RAISED = 1.05

Record = dict[str, Any]


def surveyed(seed: int, number: int, runs: Path | None = None) -> Record:
    """Draw a scene, solve it and compare: JSON-ready; whatever becomes of it is a record, never an exception.

    runs: folder that keeps the runs of the reference; those it has are not solved again.
    """
    begin = process_time()
    text, name = scene_text(seed, number), f"survey-{seed}-{number}"
    record: Record = {"number": number, "version": __version__}
    try:
        scene = scene_file.loads(text, f"{name}.toml")
        record |= described(scene)
        raised = replace(scene, name=f"{name}-raised", loads=tuple(_raised(x) for x in scene.loads))
        found = [run for one in (scene, raised) if (run := kept(runs, one)) is not None]
        if len(found) < 2:
            task = Task((scene, raised), LEVEL, cut_cells=CUT_CELLS)
            found = compute(task)
            if runs is not None:
                keep(runs, task, found, None)
        record |= compared(scene, raised, found)
    except InputError as error:
        record["status"] = one_line(str(error), 400)
    except Exception as error:  # a traceback is what the survey looks for
        record["status"] = one_line(f"{type(error).__name__}: {error}", 400)
    return record | {"seconds": round(process_time() - begin, 1)}


def kept(runs: Path | None, scene: Scene) -> Run | None:
    """Run of a scene that a folder has; None without one."""
    paths = [] if runs is None else sorted(runs.glob(f"{scene.name}-level{LEVEL}-*.json"))
    return next((run for path in paths if (run := read(path, scene, LEVEL, "")) is not None), None)


def _raised(load: Any) -> Any:
    force, moment = (tuple(RAISED * x for x in values) for values in (load.force, load.moment))
    return replace(load, force=force, moment=moment)


def described(scene: Scene) -> Record:
    """Features that decide a model's error, known without a solution."""
    z, half, r = ball_layout(scene).z - scene.nut.position, scene.nut.length / 2.0, scene.balls.radius
    given: dict[str, float] = {}
    for support in scene.supports:
        given |= {k: max(given.get(k, 0.0), abs(v)) for k, v in support.fixed}
    force = np.sum([x.force for x in scene.loads], axis=0)
    moment = np.sum([x.moment for x in scene.loads], axis=0)
    return {
        "title": scene.title,
        "starts": scene.track.starts,
        "hand": "left" if lead_angle(scene.track) < 0.0 else "right",
        "balls": scene.ball_count,
        "balls_per_turn": round(scene.ball_count / filled_turns(scene), 2),
        "low_face_radii": round(float((half + z.min()) / r), 3),
        "high_face_radii": round(float((half - z.max()) / r), 3),
        "nut_held": dimensions(scene).nut_held,
        "contact_angle_deg": round(float(np.degrees(scene.track.contact_angle)), 2),
        "conformity_screw": round(scene.screw.groove_radius / (2.0 * r), 4),
        "conformity_nut": round(scene.nut.groove_radius / (2.0 * r), 4),
        "oversize_um": round(1e6 * scene.errors.balls.oversize, 4),
        "lead_offset_um": round(1e6 * scene.errors.lead_offset, 4),
        "offset_um": round(1e6 * max(given.get("ux", 0.0), given.get("uy", 0.0)), 3),
        "tilt_mrad": round(1e3 * max(given.get("rx", 0.0), given.get("ry", 0.0)), 4),
        "axial_N": round(float(force[2]), 3),
        "radial_N": round(float(np.hypot(force[0], force[1])), 3),
        "moment_Nm": round(float(np.hypot(moment[0], moment[1])), 5),
    }


def compared(scene: Scene, raised: Scene, runs: Sequence[Run]) -> Record:
    """Status of the runs of a scene and of it with its loads raised; its loads and the models' errors, where it has any."""
    run, raised_run = runs
    state = {
        "status": run.status,
        "raised_status": raised_run.status,
        "rest_N": max(run.moving, raised_run.moving),
        "load_seconds": round(run.solve_seconds, 2),
    }
    if not (run.answers and raised_run.answers and run.load.any()):
        return state
    mean = float(run.load[run.load > 0.0].mean())
    sums = run.load.sum(axis=0)
    first, second = max(sums[0], sums[1]), min(sums[0], sums[1])
    answers = {name: [run_model(one, name, Options(discretisation=False)) for one in (scene, raised)] for name in MODELS}
    points = {
        name: point(f"survey {scene.name.rpartition('-')[2]}", scene, first, run, (raised, second, raised_run))
        for name, (first, second) in answers.items()
        if first.converged and second.converged
    }
    places = section(scene, from_run(run, "")), section(raised, from_run(raised_run, ""))
    state |= {
        "contacts": int((run.load > 0.0).sum()),
        "mean_N": round(mean, 4),
        "spread": round(float(run.load[run.load > 0.0].std()) / mean, 4),
        "preload_over_load": round(float(second / first), 4),
        "displacement_um": round(1e6 * places[0].moved, 5),
        "rigidity_N_per_um": _rounded(rigidity(places), 1e-6),
        "models": {name: _model(scene, answers[name][0], run, p) for name, p in points.items()},
        "places": {d.name: round(d.of(scene), 4) for d in DESCRIPTORS},
        "points": [asdict(p) for p in points.values()],
    }
    return state


def _rounded(value: float | None, factor: float = 1.0) -> float | None:
    return None if value is None else round(factor * value, 5)


def _model(scene: Scene, result: StaticResult, run: Run, point: Point) -> Record:
    """Errors of a model in per cent, and what the other scenes compared so far expect of it."""
    error = load_error(result.load, run.load, nominal_contacts(scene))
    expected = estimate(scene, result, [p for p in shipped_points() if p.scene != point.scene])
    return {
        "status": result.status,
        "largest_percent": point.percent,
        "at": f"{error.ball} {error.side}",
        **{name: getattr(point, name) for name in ("gate_percent", *QUANTITIES[1:])},
        **{name.replace("percent", "expected_percent"): _rounded(getattr(expected, name)) for name in QUANTITIES},
        "not_covered": "" if expected.percent is not None else one_line(expected.words[-1], 200),
    }
