"""Survey: ball screws drawn at random within the range of catalogues, solved by the 3D reference and by low-order models.

Drawn are size, number of starts, hand of the thread, preload, geometric errors, offsets of supports, and moments. The
record of a screw has its features, the status of the 3D reference, and the errors of the models.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import product
from math import floor, pi
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import InputError, one_line
from rollbench.compare.measure import load_error
from rollbench.compare.models import many, model_form
from rollbench.compare.models.applicability import DESCRIPTORS, DOUBLE_NUT_SURVEY, NEW_SURVEY, SURVEY
from rollbench.compare.models.comparison import (
    SceneWithReference,
    references_from_runs,
    solution_from_run,
    stored_references,
)
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.estimate import largest_uncertainty_percent
from rollbench.compare.reference.jobs import ComputingSettings, store_runs_and_condensed_bodies
from rollbench.compare.reference.store import Run, read_run_file, shipped_store
from rollbench.compare.reference.tasks import ReferenceTask, Solvable
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.from_keys import angle_of_touching_balls
from rollbench.compare.scenes.template import LOAD, typical_dimensions
from rollbench.lowfi.rating.life import filled_turns
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.scene_text import toml_of_tables
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Seed of the survey; seed of the screws that were drawn after the last change of the models.
SEED, NEW_SEED = 20360, 20261130

#: Number of screws whose nut is a tube without flange, which are drawn first, and number of all screws.
TUBES, SCENES = 200, 300

#: Of the screws that were drawn after the last change, number with a tube, which come first, and number of all.
NEW_TUBES, NEW_SCENES = 40, 60

#: Number of all drawn screws.
DRAWN = SCENES + NEW_SCENES

#: Nominal diameters with their leads [mm].
SIZES = {
    16: (5, 10, 16),
    20: (5, 10, 20),
    25: (5, 10, 25),
    32: (5, 10, 20, 32),
    40: (5, 10, 20, 40),
    50: (10, 20),
    63: (10, 20),
    80: (10, 20),
}

#: Oversize of the ball radius over the ball diameter [1] for a light preload.
OVERSIZE = 4.7e-4

#: Circuits and turns per circuit, smallest first, with the allowed number of balls.
CIRCUITS, BALLS = ((1, 1.0), (1, 1.5), (2, 1.0), (1, 2.5), (2, 1.5), (3, 1.0), (2, 2.5)), 40

#: Number of drawn double nuts; allowed number of balls of each of the two nuts.
DOUBLE_NUTS, NUT_BALLS = 24, 24

#: Name of the shipped scene of a double nut.
SHIPPED_DOUBLE_NUT = "double-nut"

#: Kinds of preload of a double nut, of which one is drawn with double probability: axial preload of each nut in per cent of
#: its dynamic load rating, and offset of the nuts by the spacer.
BRACED = ("preload", "preload", "offset")

#: Preload of a double nut [% of the dynamic load rating]; dynamic load rating over the typical load of a nut [%].
PRELOAD_SHARES, TYPICAL_SHARE = (3.0, 8.0), 13.0

#: Surfaces at which the two nuts of a double nut are fixed: at the spacer between them, at their far ends, both at the same
#: end (the default of a scene file), or both around.
HELD_NUTS = (
    ("right face", "left face"),
    ("left face", "right face"),
    ("left face", "left face"),
    ("outer surface", "outer surface"),
)

#: Kinds of preload or clearance of a single nut; an entry that is listed twice is drawn with double probability.
PRELOADS = ("none", "oversize", "oversize", "force", "lead offset", "clearance")

#: Standard deviations [um] of ball radius, pitch (once per turn) and roundness (twice per turn) for classes 1, 3 and 5.
CLASSES = ((0.05, 0.5, 0.25), (0.1, 1.0, 0.5), (0.2, 2.0, 1.0))

#: Fixed surfaces of a nut without flange; an entry that is listed twice is drawn with double probability.
HELD = ("left face", "left face", "right face", "both faces", "outer surface")


def random_screw_scene_text(seed: int, number: int) -> str:
    """Return the scene file (TOML text) of one randomly drawn ball screw, which depends on seed and number only.

    ``seed``: seed of the survey; ``number``: number of the screw, from 0. Up to number `TUBES` - 1 the nut is a plain tube;
    from `TUBES` on it has a flange. From `SCENES` on the survey's screws are drawn with `NEW_SEED`: `NEW_TUBES` tubes, then
    flanges.
    """
    flange, new = number >= TUBES, number - SCENES
    if seed == SEED and new >= 0:
        seed, number, flange = NEW_SEED, new, new >= NEW_TUBES
    rng = np.random.default_rng([seed, number])
    outer = int(rng.choice(list(SIZES)))
    lead = int(rng.choice(SIZES[outer]))
    kind = str(rng.choice(PRELOADS))
    starts = 2 if lead > 0.3 * outer and kind != "lead offset" and rng.random() < 0.45 else 1
    sizes = typical_dimensions(f"{outer}x{lead / starts:g}")
    ball, pitch, wall = sizes["ball"], sizes["pitch"], sizes["outside"]
    touching = angle_of_touching_balls(pitch / 2.0, lead, ball)
    balls, count = _draw_ball_circuits(rng, starts, ball, touching, halved=kind == "lead offset")
    force = LOAD * ball**2 * count * np.sin(pi / 4.0)
    length = round(outer * rng.uniform(12.0, 30.0))
    track, screw = _draw_track_and_screw(rng, pitch, lead, length, outer)
    track["starts"] = starts
    position = length * rng.uniform(0.3, 0.7)
    outside = float(f"{wall * rng.uniform(0.95, 1.2):.3g}")
    scene: dict[str, Any] = {
        "title": f"survey {seed}, scene {number}: {outer}x{lead}, {kind}",
        "material": {"name": "bearing steel"},
        "track": track,
        "screw": screw,
        "nut": {
            "position": f"{position:.4g} mm",
            "length": f"{length * 0.58:.4g} mm",
            "outer_diameter": f"{outside:g} mm",
            "conformity": _draw_conformity(rng),
        },
        "balls": balls,
        "errors": _draw_geometric_errors(rng),
        "solid": {"nut_held": str(rng.choice(HELD))},
        "supports": _draw_supports(rng, length),
    }
    if rng.random() < 0.25:
        scene["screw"]["bore"] = f"{floor(0.4 * outer)} mm"
    if kind != "none":
        scene["preload"] = _draw_preload(rng, kind, ball, force)
    scene["loads"] = _draw_loads(rng, force, pitch / 2.0, scene["nut"]["position"])
    nut_length = _draw_nut_length(scene, rng)
    scene["nut"]["length"] = f"{nut_length:.3f} mm"
    if flange:
        del scene["solid"]
        scene["title"] += ", flange"
        scene["nut"] |= _draw_flange(rng, nut_length, outside)
    return toml_of_tables(scene)


def random_double_nut_scene_text(seed: int, number: int) -> str:
    """Return the scene file (TOML text) of one randomly drawn double nut, which depends on seed and number only.

    Two equal nuts on one screw, of one start and about `NUT_BALLS` balls each at most, are held by a rigid housing and
    braced against each other by their preload or by a spacer.
    ``seed``: seed of the survey; ``number``: number of the double nut, from 0.
    """
    rng = np.random.default_rng([seed, SCENES, number])
    outer = int(rng.choice(list(SIZES)))
    lead = int(rng.choice(SIZES[outer]))
    kind = str(rng.choice(BRACED))
    sizes = typical_dimensions(f"{outer}x{lead}")
    ball, pitch = sizes["ball"], sizes["pitch"]
    touching = angle_of_touching_balls(pitch / 2.0, lead, ball)
    balls, count = _draw_ball_circuits(rng, 1, ball, touching, halved=False, most=NUT_BALLS)
    length = round(outer * rng.uniform(14.0, 30.0))
    middle = length * rng.uniform(0.4, 0.6)
    share = rng.uniform(*PRELOAD_SHARES)
    force = LOAD * ball**2 * count * np.sin(pi / 4.0) * share / TYPICAL_SHARE
    track, screw = _draw_track_and_screw(rng, pitch, lead, length, outer)
    nut = {
        "position": f"{middle:.4g} mm",
        "length": f"{length * 0.58:.4g} mm",
        "outer_diameter": f"{sizes['outside'] * rng.uniform(0.95, 1.2):.3g} mm",
        "conformity": _draw_conformity(rng),
    }
    material = {"name": "bearing steel"}
    nut_length = _draw_nut_length(
        {"title": "one nut", "material": material, "track": track, "screw": screw, "nut": nut, "balls": balls}, rng
    )
    apart = nut_length * (1.0 + rng.uniform(0.05, 0.3))
    held, inwards = HELD_NUTS[int(rng.integers(len(HELD_NUTS)))], bool(rng.random() < 0.5)
    if rng.random() < 0.25:
        screw["bore"] = f"{floor(0.4 * outer)} mm"
    shift = 1e3 * OVERSIZE * ball * _draw_log_uniform(rng, 0.7, 2.5)
    sets = []
    for k, sign in enumerate((-1.0, 1.0)):
        pushed = -sign if inwards else sign
        braced = {"thrust": "+z" if pushed > 0.0 else "-z", "preload": f"{share:.1f} % of C"}
        place = {"position": f"{middle + 0.5 * sign * apart:.3f} mm", "length": f"{nut_length:.3f} mm"}
        sets.append(
            {"name": f"nut {k + 1}"}
            | (braced if kind == "preload" else {"offset": f"{pushed * shift:.3g} um"})
            | {"track": track, "nut": nut | place | {"held": {"at": held[k]}}, "balls": balls}
            | {"errors": _draw_geometric_errors(rng)}
        )
    scene: dict[str, Any] = {
        "title": f"survey {seed}, double nut {number}: {outer}x{lead}, {kind}",
        "kind": "axis",
        "material": material,
        "screw": screw,
        "supports": _draw_supports(rng, length),
        "loads": _draw_loads(rng, force, pitch / 2.0, f"{middle:.4g} mm"),
        "sets": sets,
    }
    return toml_of_tables(scene)


def _draw_track_and_screw(
    rng: np.random.Generator, pitch: float, lead: int, length: int, outer: int
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Draw contact angle, hand and conformity of a screw; return the scene keys of its track, then those of the screw.

    ``pitch``, ``lead``, ``length`` and ``outer``: pitch diameter, lead, length and outer diameter [mm].
    """
    track = {
        "pitch_diameter": f"{pitch:g} mm",
        "lead": f"{lead} mm",
        "contact_angle": f"{rng.uniform(40.0, 50.0):.1f} deg",
        "hand": str(rng.choice(["right", "right", "left"])),
    }
    return track, {"length": f"{length} mm", "outer_diameter": f"{outer} mm", "conformity": _draw_conformity(rng)}


def _draw_flange(rng: np.random.Generator, length: float, tube_diameter: float) -> dict[str, dict[str, str]]:
    """Draw a flange for a nut, and the annulus of its face that is fixed; return the scene keys that describe both.

    ``rng``: generator of the random numbers; ``length``: length of the nut [mm]; ``tube_diameter``: outer diameter of its
    tubular part [mm].
    """
    wide, thick = tube_diameter * rng.uniform(1.3, 1.8), min(tube_diameter * rng.uniform(0.15, 0.3), 0.4 * length)
    room, fit = wide - tube_diameter, rng.uniform(0.05, 0.5) * (length - thick)
    low, high = tube_diameter + room * rng.uniform(0.0, 0.3), wide - room * rng.uniform(0.0, 0.3)
    bonded = rng.random() < 0.4
    flange = {"diameter": wide, "thickness": thick, "centring": fit if bonded else 0.0}
    return {
        "flange": {name: f"{x:.2f} mm" for name, x in flange.items()} | {"side": str(rng.choice(["left", "right"]))},
        "held": {
            "inner_diameter": f"{low:.2f} mm",
            "outer_diameter": f"{high:.2f} mm",
            "centring": "bonded" if bonded else "free",
        },
    }


def _draw_log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number from ``low`` to ``high`` whose logarithm is uniformly distributed."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _draw_conformity(rng: np.random.Generator) -> float:
    """Draw the conformity of a groove (groove radius over ball diameter), from 0.515 to 0.54."""
    return round(float(rng.uniform(0.515, 0.54)), 3)


def _draw_ball_circuits(
    rng: np.random.Generator, starts: int, ball_diameter: float, touching_angle: float, *, halved: bool, most: int = BALLS
) -> tuple[dict[str, Any], int]:
    """Draw the ball circuits of a nut and their filling; return the scene keys of the balls, then the number of balls.

    ``rng``: generator of the random numbers; ``starts``: number of starts of the thread; ``ball_diameter``: ball diameter
    [mm]; ``touching_angle``: difference in azimuth between neighbouring balls that touch [rad]; ``halved``: whether the nut
    is preloaded by a lead offset between two halves, so that circuits come in pairs; ``most``: number of balls up to which
    circuits are drawn beyond the smallest ones.
    """
    filling = round(float(rng.uniform(0.8, 0.95)), 2)

    def balls_in_circuits(circuits: int, turns: float) -> int:
        """Return the number of balls of all starts, for ``circuits`` circuits per start with ``turns`` turns each."""
        return starts * circuits * max(1, floor(filling * turns * 2.0 * pi / touching_angle))

    allowed = [c for c in CIRCUITS if not (halved and c[0] % 2)]
    circuits, turns = allowed[int(rng.integers(max(1, sum(balls_in_circuits(*c) <= most for c in allowed))))]
    keys = {"diameter": f"{ball_diameter:g} mm", "filling": filling, "turns": turns, "circuits": circuits}
    return keys | ({"circuit_gap": 0.5} if circuits > 1 else {}), balls_in_circuits(circuits, turns)


def _draw_preload(rng: np.random.Generator, kind: str, ball_diameter: float, typical_load: float) -> dict[str, str]:
    """Draw the amount of a preload or clearance, and return the key of the scene's table [preload] that states it.

    ``kind``: one of `PRELOADS`; ``ball_diameter``: ball diameter [mm]; ``typical_load``: typical axial load [N].
    """
    size = 1e3 * OVERSIZE * ball_diameter * _draw_log_uniform(rng, 0.3, 2.5)
    if kind == "force":
        return {"force": f"{typical_load * _draw_log_uniform(rng, 0.1, 0.6):.3g} N"}
    if kind == "lead offset":
        return {"lead_offset": f"{2.0 * size * rng.choice([-1.0, 1.0]):.3g} um"}
    return {"oversize": f"{size if kind == 'oversize' else -size:.3g} um"}


def _draw_geometric_errors(rng: np.random.Generator) -> dict[str, Any]:
    """Draw one of three tolerance classes or none; return scene keys with the standard deviations of geometric errors."""
    chosen = int(rng.integers(len(CLASSES) + 1))
    if chosen == len(CLASSES):
        return {}
    radius, pitch, round_ = (f"{x:g} um" for x in CLASSES[chosen])
    flank = {"pitch": [{"harmonic": 1, "sigma": pitch}], "roundness": [{"harmonic": 2, "sigma": round_}]}
    return {"seed": int(rng.integers(2**31)), "balls": {"sigma": radius}} | dict.fromkeys(("SL", "SR", "NL", "NR"), flank)


def _draw_supports(rng: np.random.Generator, length: int) -> list[dict[str, Any]]:
    """Draw the supports of a screw, and return the scene keys of each; ``length``: length of the screw [mm].

    The left end is fixed except along z. The right end is floating or clamped, with or without offset or tilt, or it is
    free.
    """
    left = {"at": "0 mm", "fix": ["ux", "uy", "rx", "ry", "rz"]}
    right = str(rng.choice(["floating", "floating", "clamped", "none"]))
    offset, tilt = rng.random() < 0.35, rng.random() < 0.25
    moved, turned = _draw_log_uniform(rng, 10.0, 200.0), _draw_log_uniform(rng, 0.03, 0.3)
    if right == "none":
        return [left]
    held, given = ["uy"], {}
    if offset:
        given["ux"] = f"{moved:.3g} um"
    else:
        held.append("ux")
    if right == "clamped":
        held.append("rx")
        if tilt:
            given["ry"] = f"{turned:.3g} mrad"
        else:
            held.append("ry")
    return [left, {"at": f"{length} mm", "fix": held} | ({"displace": given} if given else {})]


def _draw_loads(
    rng: np.random.Generator, typical_load: float, pitch_radius: float, nut_position: str
) -> list[dict[str, Any]]:
    """Draw the loads on a screw, and return the scene keys of each load.

    An axial load acts on the left end; a moment and a radial force act at the nut, each on three of ten screws.
    ``typical_load``: typical axial load [N]; ``pitch_radius``: pitch radius [mm]; ``nut_position``: axial position of the
    nut as text with its unit.
    """
    axial = typical_load * _draw_log_uniform(rng, 0.15, 1.6) * rng.choice([-1.0, 1.0])
    moment = typical_load * pitch_radius * 1e-3 * rng.uniform(0.05, 0.5) * (rng.random() < 0.3)
    radial, turn = typical_load * rng.uniform(0.02, 0.2) * (rng.random() < 0.3), rng.uniform(0.0, 2.0 * pi)
    out: list[dict[str, Any]] = [{"at": "0 mm", "force": ["0 N", "0 N", f"{axial:.4g} N"]}]
    if moment or radial:
        x, y = np.cos(turn), np.sin(turn)
        across = [f"{radial * x:.4g} N", f"{radial * y:.4g} N", "0 N"]
        out.append(
            {"at": nut_position, "force": across, "moment": [f"{-moment * y:.4g} N m", f"{moment * x:.4g} N m", "0 N m"]}
        )
    return out


def _draw_nut_length(scene: Mapping[str, Any], rng: np.random.Generator) -> float:
    """Draw the length of a nut [mm], whose end face lies 1 to 6 ball radii beyond the centre of the outermost ball.

    The length is rounded up to micrometres. ``scene``: keys of the scene drawn so far, with a nut that is
    long enough for all balls.
    """
    read = scene_file.scene_from_text(toml_of_tables({k: v for k, v in scene.items() if k != "preload"}), "survey.toml")
    reach = float(np.abs(ball_layout(read).z - read.nut.position).max())
    return round(1e3 * 2.0 * (reach + read.balls.radius * _draw_log_uniform(rng, 1.0, 6.0)) + 5e-4, 3)


#: Models that are compared with the 3D reference, and its mesh level.
MODELS, LEVEL = ("refined", "lin"), 1

#: Cell size at the cut ends of the shaft over the usual one of the mesh level: the coarser cells halve the time and change
#: loads by 0.02 % of the mean load.
CUT_CELLS = 2.0

#: Factor on the loads for a second solution, from which the tangent rigidity follows.
RAISED = 1.05

Record = dict[str, Any]


class DrawnKind(NamedTuple):
    """Kind of scenes of the survey: how they are named and drawn, how many, and where their records are stored."""

    #: Words with which names of these scenes begin.
    name: str
    #: Function that returns the text of a scene file, of the survey's seed and the number of the scene.
    scene_text: Callable[[int, int], str]
    #: Number of scenes.
    scenes: int
    #: Name of the file with the records.
    file: str
    #: Number of the first scene.
    first: int = 0

    @property
    def loads(self) -> str:
        """Name of the file with the contact loads of the 3D reference, next to the records."""
        return self.file.replace(".json", "-loads.json")

    def scenes_under_given_and_raised_loads(self, seed: int, number: int) -> tuple[Solvable, Solvable]:
        """Return a drawn scene under its loads, then the same scene under these loads times `RAISED` (1.05).

        The axial tangent rigidity follows from the solutions under both loads.
        """
        name = f"{self.name}-{seed}-{number}"
        scene = scene_file.parse_scene(self.scene_text(seed, number), f"{name}.toml")
        assert isinstance(scene, Scene | Assembly)
        return scene, replace(with_scaled_loads(scene, RAISED), name=f"{name}-raised")


#: Kinds of scenes of the survey.
KINDS = {
    "ball screw": DrawnKind("survey", random_screw_scene_text, SCENES, SURVEY),
    "new screw": DrawnKind("survey", random_screw_scene_text, NEW_SCENES, NEW_SURVEY, SCENES),
    "double nut": DrawnKind("double-nut", random_double_nut_scene_text, DOUBLE_NUTS, DOUBLE_NUT_SURVEY),
}


def survey_screw(seed: int, number: int, run_folder: Path | None = None, kind: str = "ball screw") -> Record:
    """Draw a random ball screw or double nut, and compare the low-order models with the 3D reference on it.

    If a solution fails, the returned record says so; no exception is raised.

    Parameters
    ----------
    seed
        Seed of the survey.
    number
        Number of the screw.
    run_folder
        Folder of stored 3D solutions, which are not computed again; None: no solution is stored.
    kind
        Kind of the scene, a key of `KINDS`.

    Returns
    -------
    dict
        Record of the screw as JSON values: its properties, status of the 3D reference, and errors of the models.
    """
    begin = process_time()
    record: Record = {"number": number, "version": __version__}
    try:
        scene, raised = KINDS[kind].scenes_under_given_and_raised_loads(seed, number)
        record |= double_nut_properties(scene) if isinstance(scene, Assembly) else screw_properties_for_record(scene)
        found = [run for one in (scene, raised) if (run := stored_run(run_folder, one)) is not None]
        if len(found) < 2:
            task = ReferenceTask((scene, raised), LEVEL, cut_end_cell_ratio=CUT_CELLS)
            found = compute_reference_runs(task)
            if run_folder is not None:
                store_runs_and_condensed_bodies(run_folder, task, found, None)
        if isinstance(scene, Assembly) and isinstance(raised, Assembly):
            record |= compare_models_on_double_nut(scene, raised, found)
        elif isinstance(scene, Scene) and isinstance(raised, Scene):
            record |= compare_models_with_reference(scene, raised, found)
    except InputError as error:
        record["status"] = one_line(str(error), 400)
    except Exception as error:  # the survey looks for programming errors too
        record["status"] = one_line(f"{type(error).__name__}: {error}", 400)
    return record | {"seconds": round(process_time() - begin, 1)}


def stored_run(run_folder: Path | None, scene: Solvable) -> Run | None:
    """Return the stored solution of a scene by the 3D reference on mesh level 1; None if there is none.

    ``run_folder``: folder of stored solutions; None: nothing is stored.
    """
    paths = [] if run_folder is None else sorted(run_folder.glob(f"{scene.name}-level{LEVEL}-*.json"))
    return next((run for path in paths if (run := read_run_file(path, scene, LEVEL, "")) is not None), None)


def screw_properties_for_record(scene: Scene) -> Record:
    """Return the properties of a screw that affect the errors of low-order models, as far as known before it is solved.

    Their names end in the unit. "low_face_radii" and "high_face_radii" are the distances from the nut's
    faces at low and high z to the nearest ball centre, in ball radii; "offset_um" and "tilt_mrad" are the largest lateral
    displacement and rotation that a support imposes.
    """
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
        "nut_held": dimensions_of_3d_parts(scene).nut_held,
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


def compare_models_with_reference(scene: Scene, raised: Scene, runs: Sequence[Run]) -> Record:
    """Compare the models with the 3D reference on a randomly drawn screw; return status, loads and errors as JSON values.

    ``raised``: the same screw with raised loads; ``runs``: solutions by the 3D reference under the drawn loads, then under
    the raised loads. Without two converged solutions or without loaded contacts the record has the status only.
    """
    (run, raised_run), state = runs, _state_of_runs(*runs)
    if not (run.answers and raised_run.answers and run.load.any()):
        return state
    mean = float(run.load[run.load > 0.0].mean())
    sums = run.load.sum(axis=0)
    first, second = max(sums[0], sums[1]), min(sums[0], sums[1])
    answers, seconds, options = {}, {}, ModelOptions(estimate_beam_mesh_error=False)
    for name in MODELS:
        begin = process_time()
        answer = run_model(scene, name, options)
        further = process_time()
        answers[name] = answer, run_model(raised, name, options)
        seconds[name] = {"seconds": round(further - begin, 3), "further_seconds": round(process_time() - further, 3)}
    title = f"survey {scene.name.rpartition('-')[2]}"
    points = {
        name: model_form.measure_model_error(title, scene, low, run, (raised, high, raised_run))
        for name, (low, high) in answers.items()
        if low.converged and high.converged
    }
    pairs = ((scene, run), (raised, raised_run))
    places = [model_form.state_of_loaded_section(one, solution_from_run(of, "")) for one, of in pairs]
    state |= {
        "contacts": int((run.load > 0.0).sum()),
        "mean_N": round(mean, 4),
        "spread": round(float(run.load[run.load > 0.0].std()) / mean, 4),
        "preload_over_load": round(float(second / first), 4),
        "displacement_um": round(1e6 * places[0][0], 5),
        "rigidity_N_per_um": _round_or_none(model_form.axial_rigidity_between_states(*places), 1e-6),
        "models": {
            name: _record_of_model_errors(scene, answers[name][0], run, p) | seconds[name] for name, p in points.items()
        },
        "places": descriptors_for_record(scene),
        "points": [asdict(p) for p in points.values()],
    }
    return state


def _state_of_runs(run: Run, raised_run: Run) -> Record:
    """Return the status of both solutions by the 3D reference for the record, with moving loads and time."""
    return {
        "status": run.status,
        "raised_status": raised_run.status,
        "rest_N": max(run.moving, raised_run.moving),
        "load_seconds": round(run.solve_seconds, 2),
    }


def double_nut_properties(assembly: Assembly) -> Record:
    """Return the properties of a double nut that affect the errors of low-order models, those of its nuts in a list."""
    nuts = [
        replace(s.parts, supports=assembly.supports, loads=assembly.loads)
        for s in assembly.sets
        if isinstance(s.parts, Scene)
    ]
    first = screw_properties_for_record(replace(nuts[0], title=assembly.title))
    own = ("low_face_radii", "high_face_radii", "nut_held")
    braced = [{"preload_N": round(s.preload, 2), "offset_of_nut_um": round(1e6 * s.offset, 3)} for s in assembly.sets]
    each = [{k: screw_properties_for_record(nut)[k] for k in own} | given for nut, given in zip(nuts, braced, strict=True)]
    return {k: v for k, v in first.items() if k not in own} | {"nuts": each}


def compare_models_on_double_nut(assembly: Assembly, raised: Assembly, runs: Sequence[Run]) -> Record:
    """Compare the models with the 3D reference on a drawn double nut; return status and errors as JSON values.

    Errors of contact loads are in per cent of the mean load of their own nut; the larger of the two nuts is that of the
    scene. Displacement and rigidity are those of the shaft's cross-section on which the axial load acts.

    ``raised``: the same double nut with raised loads; ``runs``: solutions by the 3D reference under the drawn loads, then
    under the raised loads. Without two converged solutions, or with a nut without load, the record has the status only.
    """
    (run, raised_run), state = runs, _state_of_runs(*runs)
    if not (run.answers and raised_run.answers):
        return state
    references = references_from_runs(assembly, (run,))
    if not all(of.reference.load.any() for of in references):
        return state
    options, title = ModelOptions(estimate_beam_mesh_error=False), f"double nut {assembly.name.rpartition('-')[2]}"
    points, models = [], {}
    for name in MODELS:
        begin = process_time()
        low, seconds = run_model(assembly, name, options), process_time() - begin
        high = run_model(raised, name, options)
        if not (low.converged and high.converged):
            continue
        of_axis: Any = model_form.errors_of_shaft_section(assembly, raised, (low, high), runs)
        found = []
        for (nut, result), of in zip(model_form.nuts_of_double_nut(assembly, low), references, strict=True):
            words = f"{title}, {of.set_name}"
            point = model_form.measure_model_error(words, nut, result, of.reference.best, contacts=of.reference.contacts)
            found.append(replace(point, features=point.features | {model_form.DOUBLE: 1.0}, **of_axis))
        points += found
        expected = model_form.estimate_double_nut_error(
            assembly, low, [p for p in model_form.model_errors_on_compared_scenes() if p.described_scene != title]
        )
        models[name] = _record_of_double_nut_errors(low, found, expected, references) | {"seconds": round(seconds, 3)}
    return state | {
        "contacts": int((run.load > 0.0).sum()),
        "mean_N": [round(float(of.reference.load[of.reference.load > 0.0].mean()), 4) for of in references],
        "uncertainty_percent": [round(largest_uncertainty_percent(of.reference), 3) for of in references],
        "models": models,
        "points": [asdict(p) for p in points],
    }


def errors_on_shipped_double_nut() -> list[Record]:
    """Return the record of the shipped double nut, in a list, as those of the drawn ones: errors of the models on it.

    Its reference is the stored one, on several mesh levels. The list is empty if no run is stored.
    """
    assembly = catalogue.shipped_scene(SHIPPED_DOUBLE_NUT)
    assert isinstance(assembly, Assembly)
    references = stored_references(assembly, None)
    if not references:
        return []
    models, options = {}, ModelOptions(estimate_beam_mesh_error=False)
    for name in MODELS:
        result = run_model(assembly, name, options)
        found = [
            model_form.measure_model_error(of.set_name, nut, one, of.reference.best, contacts=of.reference.contacts)
            for (nut, one), of in zip(model_form.nuts_of_double_nut(assembly, result), references, strict=True)
        ]
        expected = model_form.estimate_double_nut_error(assembly, result)
        models[name] = _record_of_double_nut_errors(result, found, expected, references)
    bars = [round(largest_uncertainty_percent(of.reference), 3) for of in references]
    levels = ", ".join(map(str, references[0].reference.levels))
    words = {"number": SHIPPED_DOUBLE_NUT, "title": f"{assembly.title} (mesh levels {levels})", "status": ANSWERED}
    return [words | {"uncertainty_percent": bars, "models": models}]


def _record_of_double_nut_errors(
    result: AxisResult,
    found: Sequence[model_form.MeasuredModelErrors],
    expected: model_form.ExpectedError | None,
    references: Sequence[SceneWithReference],
) -> Record:
    """Return a model's errors on a drawn double nut [%], and the errors expected from other scenes.

    ``result``: the model's solution; ``found``: the model's errors on each nut; ``references``: 3D reference of each nut.
    """
    places = []
    for s, of in zip(result.sets, references, strict=True):
        assert s.balls is not None
        error = load_error(s.balls.load, of.reference.load, of.reference.contacts)
        places.append(f"{of.set_name}, {error.ball} {error.side}")
    worst = max(range(len(found)), key=lambda k: found[k].percent)
    largest = {
        name: max(abs(getattr(p, name) or 0.0) for p in found) for name in ("gate_percent", *model_form.QUANTITIES[1:])
    }
    return {
        "status": result.status,
        "largest_percent": found[worst].percent,
        "at": places[worst],
        "percent_of_nuts": [p.percent for p in found],
        **largest,
        **_expected_percents(expected),
    }


def _expected_percents(expected: model_form.ExpectedError | None) -> Record:
    """Return the errors expected from other scenes [%], rounded, by the keys of the record, and why there are none."""
    if expected is None:
        return {"not_covered": ""}
    names = (name.replace("percent", "expected_percent") for name in model_form.QUANTITIES)
    found = {n: _round_or_none(getattr(expected, field)) for n, field in zip(names, model_form.EXPECTED, strict=True)}
    return found | {"not_covered": "" if expected.loads is not None else one_line(expected.words[-1], 200)}


def _round_or_none(value: float | None, factor: float = 1.0) -> float | None:
    """Return a value multiplied by a factor and rounded to five decimal places; None if the value is None."""
    return None if value is None else round(factor * value, 5)


def _record_of_model_errors(
    scene: Scene, result: StaticResult, run: Run, measured_errors: model_form.MeasuredModelErrors
) -> Record:
    """Return a model's errors on a randomly drawn screw [%], and the errors predicted for it from those on other scenes.

    ``result``: the model's solution; ``run``: solution of the 3D reference; ``measured_errors``: the model's errors against
    it.
    """
    error, names = load_error(result.load, run.load, count_nominal_contacts(scene)), model_form.QUANTITIES
    others = [p for p in model_form.model_errors_on_compared_scenes() if p.scene != measured_errors.scene]
    expected = model_form.estimate_model_error(scene, result, others)
    return {
        "status": result.status,
        "largest_percent": measured_errors.percent,
        "at": f"{error.ball} {error.side}",
        **{name: getattr(measured_errors, name) for name in ("gate_percent", *names[1:])},
        **_expected_percents(expected),
    }


#: Status of a solved screw.
ANSWERED = "converged"

#: Errors in the table of errors, by their names in the records.
ERRORS = ("largest_percent", "gate_percent", "rms_percent", "displacement_percent", "rigidity_percent", "pressure_percent")


def solve_screws_of_survey(
    seed: int,
    count: int,
    folder: Path,
    workers: int,
    show_progress: Callable[[str], None],
    record_file: Path | None = None,
    kind: str = "ball screw",
) -> list[Record]:
    """Compare the models on the first ``count`` screws of a survey, and return the records; stored records are reused.

    Parameters
    ----------
    seed
        Seed of the survey.
    count
        Number of screws.
    folder
        Folder in which the record of each screw is stored once it is solved.
    workers
        Number of parallel processes.
    show_progress
        Function that is called with a line of progress for every screw.
    record_file
        File of an earlier survey, whose records are used if seed, mesh level and version are the same; None: no file.
    kind
        Kind of the scenes, a key of `KINDS`.

    Returns
    -------
    list of dict
        Records in the order of their numbers.

    Raises
    ------
    InputError
        If the folder belongs to another survey, or another process works in it.
    """
    asked = {"survey": seed, "level": LEVEL, "version": __version__} | ({} if kind == "ball screw" else {"kind": kind})
    numbers = range(KINDS[kind].first, KINDS[kind].first + count)
    kept = _valid_records_in_file(record_file, seed)
    known = {record["number"]: record for record in kept if record["number"] in numbers and _has_loads(record)}
    if known:
        show_progress(f"{len(known)} scenes of {count} are known")
    left = {number: (seed, number, folder / "runs", kind) for number in numbers if number not in known}
    stored = many.StoredIn(folder, asked, "out", _has_loads)
    engine = ComputingSettings(parallel_jobs=workers)
    for number, record in many.solve_many(survey_screw, left, engine, show_progress, stored=stored):
        known[number] = record
        show_progress(f"[{len(known)}/{count}] scene {number}: {record['status']}, {record['seconds']:.0f} s")
    return [known[number] for number in numbers]


def _valid_records_in_file(path: Path | None, seed: int) -> list[Record]:
    """Return those records in a survey's file that have this seed and the present mesh level and program version.

    What describes a screw before it is solved is computed anew, so that a new descriptor needs no new solution.

    ``path``: the file; None: no file; ``seed``: seed of the survey. The list is empty without such records.
    """
    if path is None or not path.exists():
        return []
    found = json.loads(path.read_text(encoding="utf-8"))
    same = (found.get("seed"), found.get("level")) == (seed, LEVEL)
    kept = [record for record in found["scenes"] if same and record["version"] == __version__]
    for record in kept:
        if "places" in record:
            scene = scene_file.scene_from_text(random_screw_scene_text(seed, record["number"]), "survey.toml")
            record["places"] = descriptors_for_record(scene)
    return kept


def descriptors_for_record(scene: Scene) -> dict[str, float]:
    """Return the rounded values of all descriptors of a scene (`DESCRIPTORS`), by name."""
    return {d.name: round(d.value_of_scene(scene), 4) for d in DESCRIPTORS}


def _has_loads(record: Record) -> bool:
    """Return whether the 3D reference converged under the loads of a record."""
    return not records_without_converged_loads([record])


def records_without_converged_loads(records: Sequence[Record]) -> list[Record]:
    """Return the survey records of screws for which the 3D reference did not converge under drawn or raised loads."""
    return [r for r in records if r["status"] != ANSWERED or r.get("raised_status", ANSWERED) != ANSWERED]


def survey_records_as_json(seed: int, records: Sequence[Record], kind: str = "ball screw") -> str:
    """Return the records of a survey as JSON text, one screw per line after the numbers of requested and solved screws."""
    asked = 1 + max((r["number"] - KINDS[kind].first for r in records), default=-1)
    of = "" if kind == "ball screw" else f" --kind {kind.replace(' ', '-')}"
    head = {"command": f"rollbench stability --survey {asked}{of}", "seed": seed, "level": LEVEL, "solved": len(records)}
    rows = ",\n".join(json.dumps(r, ensure_ascii=False) for r in records)
    return json.dumps(head)[:-1] + f', "scenes": [\n{rows}\n]}}\n'


def built_in_survey(kind: str = "ball screw") -> dict[str, Any]:
    """Return the survey of random screws in the package as JSON values; a survey without screws if the file is missing.

    ``kind``: kind of the scenes, a key of `KINDS`.
    """
    path = shipped_store() / KINDS[kind].file
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"scenes": []}
    return found


def records_of_all_screws() -> list[Record]:
    """Return the stored records of all drawn screws, in the order of their numbers."""
    return [*built_in_survey()["scenes"], *built_in_survey("new screw")["scenes"]]


#: Aims for the errors of the refined model on random screws: of the worst contact, and root mean square [% of the mean
#: load].
WORST_AIM, RMS_AIM = 1.5, 0.5


class ModelAccuracy(NamedTuple):
    """Accuracy of a low-order model on randomly drawn screws, against the 3D reference."""

    #: Number of randomly drawn screws.
    screw_count: int
    #: Number of screws whose largest and root-mean-square load errors are within the aims `WORST_AIM` and `RMS_AIM`.
    within_aims: int
    #: Median over the screws of the largest error of a contact load [% of the mean load of the screw].
    median_error: float
    #: 95th percentile of this error [%].
    percentile_95: float
    #: Largest error of a contact load on any of the screws [% of the mean load of the screw].
    largest_error: float
    #: Number of screws whose largest load error does not exceed the error that was expected when they were solved.
    within_expected_error: int


def model_accuracy_on_random_screws(records: Sequence[Record], model: str = "refined") -> ModelAccuracy:
    """Return the accuracy of a low-order model against the 3D reference, over all records with errors of this model."""
    errors = [r["models"][model] for r in records if model in r.get("models", {})]
    worst = [abs(e["largest_percent"]) for e in errors]
    within = sum(w <= WORST_AIM and e["rms_percent"] <= RMS_AIM for w, e in zip(worst, errors, strict=True))
    held = sum(w <= (e["expected_percent"] or 0.0) for w, e in zip(worst, errors, strict=True))
    median, most = map(float, np.percentile(worst, [50, 95])) if worst else (0.0, 0.0)
    return ModelAccuracy(len(errors), within, median, most, max(worst, default=0.0), held)


def median_p95_and_largest(sizes: Sequence[float]) -> dict[str, float]:
    """Return median, 95th percentile and maximum of sizes of errors, by the keys of a table row."""
    median, most = map(float, np.percentile(sizes, [50, 95]))
    return {"median": median, "p95": most, "largest": max(sizes)}


def error_summary_rows_of_all_models(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Return table rows with median, 95th percentile and maximum of each model's errors over randomly drawn screws.

    There is a row for each model and kind of error of a screw, such as the largest or the root mean square; "scenes" is the
    number of screws for which the kind of error is known.
    """
    rows = []
    for model, error in product(MODELS, ERRORS):
        known = (r.get("models", {}).get(model, {}).get(error) for r in records if r["status"] == ANSWERED)
        if sizes := [abs(value) for value in known if value is not None]:
            rows.append({"model": model, "error": error, "scenes": len(sizes), **median_p95_and_largest(sizes)})
    return rows
