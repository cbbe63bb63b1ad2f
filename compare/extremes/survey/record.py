"""What the survey keeps of one scene: what it is, whether the 3D reference answered, how far off the models are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from rollbench.comparison.errors import InputError, one_line
from rollbench.comparison.extremes.survey.draw import scene_text
from rollbench.comparison.measure import error_percent, load_error
from rollbench.comparison.models.model_form import estimate
from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.reference.computing import compute_with_bodies
from rollbench.comparison.reference.jobs import keep
from rollbench.comparison.reference.store import Run
from rollbench.comparison.reference.tasks import Task
from rollbench.comparison.scenes import scene_file
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene

#: Models that are compared, and the mesh level.
MODELS, LEVEL = ("refined", "lin"), 1
#: By how much the loads are raised for the tangent rigidity.
RAISED = 1.05

Record = dict[str, Any]


def surveyed(seed: int, number: int, runs: Path | None = None) -> Record:
    """Draw a scene, solve it and compare: JSON-ready; whatever becomes of it is a record, never an exception.

    runs: folder that keeps the runs of the reference and their condensed bodies.
    """
    begin = process_time()
    text, name = scene_text(seed, number), f"survey-{seed}-{number}"
    record: Record = {"number": number}
    try:
        scene = scene_file.loads(text, f"{name}.toml")
        record |= described(scene)
        raised = replace(scene, name=f"{name}-raised", loads=tuple(_raised(x) for x in scene.loads))
        task = Task((scene, raised), LEVEL)
        found, bodies = compute_with_bodies(task)
        if runs is not None:
            keep(runs, task, found, bodies)
        record |= compared(scene, raised, found)
    except InputError as error:
        record["status"] = one_line(str(error), 400)
    except Exception as error:  # a traceback is what the survey looks for
        record["status"] = one_line(f"{type(error).__name__}: {error}", 400)
    return record | {"seconds": round(process_time() - begin, 1)}


def _raised(load: Any) -> Any:
    force, moment = (tuple(RAISED * x for x in values) for values in (load.force, load.moment))
    return replace(load, force=force, moment=moment)


def described(scene: Scene) -> Record:
    """What decides how far off a model may be, without a solution."""
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
        "balls_per_turn": round(2.0 * np.pi * (scene.ball_count / scene.track.starts - 1) / max(_turned(scene), 1e-9), 2),
        "low_face_radii": round(float((half + z.min()) / r), 3),
        "high_face_radii": round(float((half - z.max()) / r), 3),
        "nut_held": scene.solid.nut_held,
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


def _turned(scene: Scene) -> float:
    """Angle [rad] that the balls of one start take, without the gaps between circuits."""
    azimuths = np.sort(scene.balls.azimuths)
    steps = np.diff(azimuths)
    usual = float(np.median(steps)) if steps.size else 0.0
    return float(np.minimum(steps, usual).sum())


def compared(scene: Scene, raised: Scene, runs: Sequence[Run]) -> Record:
    """Status of the runs of a scene and of it with its loads raised; its loads and the models' errors, where it has any."""
    run, more = runs
    state = {"status": run.status, "raised_status": more.status, "load_seconds": round(run.solve_seconds, 2)}
    if not run.load.any():
        return state
    mean = float(run.load[run.load > 0.0].mean())
    sums = run.load.sum(axis=0)
    first, second = max(sums[0], sums[1]), min(sums[0], sums[1])
    line = (run.centreline, more.centreline)
    moved = [_at_nut(scene, one[:, 0], one[:, 3]) for one in line]
    pushed = [pull(scene, one.load, np.radians(one.angle)) for one in runs]
    state |= {
        "contacts": int((run.load > 0.0).sum()),
        "mean_N": round(mean, 4),
        "spread": round(float(run.load[run.load > 0.0].std()) / mean, 4),
        "preload_over_load": round(float(second / first), 4),
        "displacement_um": round(1e6 * moved[0], 5),
        "rigidity_N_per_um": _ratio(pushed, moved),
        "models": {name: _model(name, scene, raised, run, moved, pushed) for name in MODELS},
    }
    return state


def _model(name: str, scene: Scene, raised: Scene, run: Run, moved: Sequence[float], pushed: Sequence[float]) -> Record:
    """Errors of a model in per cent: loads (largest, RMS, of the mean load), displacement, rigidity; what it expected."""
    first, second = (run_model(one, name, Options(discretisation=False)) for one in (scene, raised))
    if not first.converged:
        return {"status": first.status}
    error, own = load_error(first.load, run.load, nominal_contacts(scene)), [_moved(scene, one) for one in (first, second)]
    stiff, reference = _ratio([_pull(scene, one) for one in (first, second)], own), _ratio(pushed, moved)
    expected = estimate(scene, first)
    rigidity = None if stiff is None or reference is None else round(float(error_percent(stiff, reference)), 4)
    return {
        "status": first.status,
        "largest_percent": round(error.max_percent, 4),
        "at": f"{error.ball} {error.side}",
        "rms_percent": round(error.rms_percent, 4),
        "displacement_percent": round(float(error_percent(own[0], moved[0])), 4),
        "rigidity_percent": rigidity,
        "expected_percent": None if expected.percent is None else round(expected.percent, 4),
        "expected_rms_percent": None if expected.rms_percent is None else round(expected.rms_percent, 4),
        "not_covered": "" if expected.percent is not None else one_line(expected.words[-1], 200),
    }


def _ratio(forces: Sequence[float], moved: Sequence[float]) -> float | None:
    """Tangent rigidity [N/um] between two states."""
    step = 1e6 * (moved[1] - moved[0])
    return round((forces[1] - forces[0]) / step, 5) if step != 0.0 else None


def pull(scene: Scene, load: Array, angle: Array) -> float:
    """Axial force [N] of the screw on the nut by loads and contact angles ``(n, 4)`` [N, rad]."""
    along = np.where(load > 0.0, load * np.sin(angle), 0.0).sum(axis=0) * np.cos(lead_angle(scene.track))
    return float(along[0] - along[1])


def _pull(scene: Scene, result: StaticResult) -> float:
    return pull(scene, result.load, result.contact_angle)


def _moved(scene: Scene, result: StaticResult) -> float:
    return _at_nut(scene, result.centreline_z, result.centreline[:, 2])


def _at_nut(scene: Scene, stations: Array, along: Array) -> float:
    """Axial motion [m] of the screw's section at the nut's centre."""
    return float(np.interp(scene.nut.position, stations, along))
