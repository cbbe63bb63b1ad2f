"""The answers of a solved scene, of one set or several, as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.models.answers import LoadAnswers, RollerAnswers
from rollbench.compare.models.load_cases import Solved, SolvedAxis
from rollbench.compare.models.load_path import LoadPath
from rollbench.compare.models.ring_play import clearance_in
from rollbench.compare.quantities import number, quantity, record
from rollbench.lowfi.rating.contacts import ALLOWED
from rollbench.lowfi.rating.life import Life
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import counted, mean_load
from rollbench.meshes.parts import FREEDOMS, SIDES, Motion, Scene

if TYPE_CHECKING:
    from rollbench.compare.models.answers import AxisAnswers, SetAnswers

CONTACT = (
    quantity("ball"),
    quantity("side"),
    quantity("force_N"),
    quantity("contact_angle_deg", "angle"),
    quantity("approach_um", heading="approach of its contact", form=".3f"),
    quantity("semi_axis_a_mm", "a", "larger semi-axis", ".4f"),
    quantity("semi_axis_b_mm", "b"),
    quantity("pressure_MPa", heading="peak pressure", form=".0f"),
)
ROLLER_CONTACT = (
    quantity("roller"),
    quantity("race"),
    quantity("force_N"),
    quantity("line_load_N_mm"),
    quantity("place_mm"),
    quantity("half_width_mm"),
    quantity("pressure_MPa", heading="peak pressure", form=".0f"),
    quantity("other_race_pressure_MPa", "other"),
    quantity("middle_pressure_MPa", "middle"),
)
TRUNCATION = (
    quantity("ball"),
    quantity("side"),
    quantity("edge"),
    quantity("contact_angle_deg", "angle"),
    quantity("ellipse_half_width_deg", "half"),
    quantity("edge_angle_deg", "limit"),
    quantity("margin_deg", heading="ellipse to edge of groove", form=".2f"),
    quantity("contacts_cut", "cut"),
)
STATIC_SAFETY = (
    quantity("factor", heading="static safety", form=".2f"),
    quantity("permanent_over_diameter", "permanent"),
    quantity("allowed_over_diameter", lambda _: ALLOWED),
    quantity("allowed_pressure_MPa", "allowed"),
)
ROLLER_SAFETY = (STATIC_SAFETY[0], STATIC_SAFETY[-1])
LIFE = (
    quantity("L10_million_revolutions", "revolutions", "life L10", ".1f"),
    quantity("L10_km", "distance"),
    quantity("raceways_million_revolutions", "raceways"),
    quantity("rating_as_computed_N", "rating"),
    quantity("equivalent_load_N", "equivalent"),
    quantity("standard"),
)
RATINGS = (
    quantity("dynamic_N"),
    quantity("static_N"),
    quantity("direction", lambda rated: "axial" if rated.axial else "radial"),
    quantity("dynamic_standard"),
    quantity("static_standard"),
)
RIGIDITIES = (
    quantity("contacts_alone", lambda three: 1e-6 * three.contacts),
    quantity("with_bodies", lambda three: three.bodies and 1e-6 * three.bodies),
    quantity("with_unequal_loads", lambda three: three.unequal and 1e-6 * three.unequal),
    quantity("makers_practice", lambda three: three.practice and 1e-6 * three.practice),
)
PRELOAD = (quantity("mean_N"), quantity("max_N", "largest"), quantity("axial_N"), quantity("loaded_contacts", "loaded"))
CONTACT_LOST = (
    quantity("load_factor", "factor"),
    quantity("axial_force_N", lambda lift: None if lift.factor is None else lift.axial),
    quantity("ball", lambda lift: lift.ball or None),
    quantity("side", lambda lift: lift.side or None),
    quantity("words", lambda lift: lift.words or None),
)
#: Play of a deep-groove row without load.
CLEARANCE = (quantity("rest_angle_deg", "angle"), quantity("radial_um"), quantity("axial_um"))
#: Force and moment (6,).
WRENCH = (quantity("force_N", lambda x: x[:3]), quantity("moment_Nm", lambda x: x[3:]))
#: Answers on a bearing's torque.
STARTING = (
    quantity("torque_Nmm"),
    quantity("factor"),
    quantity("equivalent_load_N"),
    quantity("static_rating_N", "rating"),
)
#: Answers that each set has for itself.
OF_A_SET = ("sides", "preload", "starting_torque", "clearance")
#: Groups of answers that contact loads give by themselves.
GROUPS = {"worst_contact": CONTACT, "truncation": TRUNCATION, "static_safety": STATIC_SAFETY, "life": LIFE}


def sides_json(load: Array) -> dict[str, dict[str, Any]]:
    """Per loaded side: largest and smallest load of the loaded balls [N], their ratio, balls with and without load."""
    out: dict[str, dict[str, Any]] = {}
    for side, values in zip(SIDES, load.T, strict=True):
        loaded = values[values > 0.0]
        if loaded.size:
            most, least = number(loaded.max()), number(loaded.min())
            ends = {"max_N": most, "min_N": least, "ratio": number(loaded.max() / loaded.min())}
            out[side] = ends | {"loaded": int(loaded.size), "lost": int(load.shape[0] - loaded.size)}
    return out


def loads_json(load: Array, contacts: int = 0) -> dict[str, Any] | None:
    """Worst ball, mean and extremes of the loaded contacts ``(n, 4)`` [N]; None without load. contacts: see
    `meshes.loads.mean_load`."""
    loaded = load > 0.0
    if not loaded.any():
        return None
    carried = load[loaded]
    i, s = np.unravel_index(int(load.argmax()), load.shape)
    return {
        "worst_ball": int(i) + 1,
        "worst_side": SIDES[int(s)],
        "max_N": number(carried.max()),
        "mean_N": number(mean_load(load, contacts)),
        "min_N": number(carried.min()),
        "loaded_contacts": int(carried.size),
        "contacts_in_mean": counted(load, contacts),
        "balls_without_load": int((~loaded.any(axis=1)).sum()),
    }


def roller_loads(load: Array) -> dict[str, Any] | None:
    """Worst roller, mean and extremes of the loaded ones of a row ``(count,)`` [N]; None without load."""
    carried = load[load > 0.0]
    if not carried.size:
        return None
    return {
        "worst_roller": int(load.argmax()) + 1,
        "max_N": number(carried.max()),
        "mean_N": number(carried.mean()),
        "min_N": number(carried.min()),
        "loaded_contacts": int(carried.size),
        "rollers_without_load": int(load.size - carried.size),
    }


def stiffness_json(station: float | None, status: str, matrix: Array) -> dict[str, Any]:
    """A stiffness (6, 6) at a station [m]: N/m, N/rad, N m/rad; null where a freedom is held."""
    rows = [[number(x) for x in row] for row in matrix]
    at = None if station is None else number(1e3 * station)
    return {"station_mm": at, "status": status, "freedoms": list(FREEDOMS), "matrix": rows}


def life_json(life: Life | None, speed: float | None) -> dict[str, Any] | None:
    """A life, in hours too where a speed [rad/s] is known."""
    hours = {"L10_hours": number(life.hours(speed))} if life is not None and speed else {}
    data = record(LIFE, life)
    return None if data is None else data | hours


def contacts_json(answers: LoadAnswers | RollerAnswers, motion: Motion | None = None) -> dict[str, Any]:
    """Worst contact, truncation (of balls), static safety, life and ratings; null where there is none."""
    if isinstance(answers, RollerAnswers):
        data = {
            "worst_contact": record(ROLLER_CONTACT, answers.worst),
            "static_safety": record(ROLLER_SAFETY, answers.safety),
        }
        return data | {"life": None, "ratings": None, "rating_refused": "life and ratings of rollers are not computed"}
    return {
        "worst_contact": record(CONTACT, answers.worst),
        "truncation": record(TRUNCATION, answers.reach),
        "static_safety": record(STATIC_SAFETY, answers.safety),
        "life": life_json(answers.life, None if motion is None else motion.speed),
        "ratings": record(RATINGS, answers.ratings),
        "rating_refused": answers.words or None,
    }


def answers_json(one: Solved) -> dict[str, Any]:
    """All answers of one set: forces in N, displacements in um, rigidities in N/um; empty without."""
    scene, answers = one.scene, one.answers
    if answers is None:
        return {}
    three = answers.rigidities
    return {
        "loads": loads_json(one.result.load, nominal_contacts(scene, one.result)),
        "axial": {
            "force_N": number(answers.force),
            "displacement_um": number(1e6 * answers.displacement),
            "rigidity_N_per_um": None if three is None or three.unequal is None else number(1e-6 * three.unequal),
            "tangent_N_per_um": None if answers.tangent is None else number(1e-6 * answers.tangent),
            "tangent_words": answers.tangent_words or None,
        },
        "rigidities_N_per_um": record(RIGIDITIES, three),
        **contacts_json(answers.loads, scene.motion),
        "preload": record(PRELOAD, answers.preload),
        "contact_lost": record(CONTACT_LOST, answers.lift),
        "friction": answers.friction,
        "friction_words": answers.friction_words or None,
        "load_path": path_json(answers.path),
        "clearance": record(CLEARANCE, clearance_in(scene)),
    }


def path_json(path: LoadPath | None) -> dict[str, Any] | None:
    """Where the loads go: force and couple of all, what each support takes of them, what goes through contacts."""
    if path is None:
        return None
    takers = [{"name": t.name} | (record(WRENCH, t.part) or {}) for t in path.takers]
    return {"applied": record(WRENCH, path.applied), "supports": takers, "contacts": record(WRENCH, path.contacts)}


def starting_torque(s: SetResult, answers: SetAnswers) -> dict[str, Any] | None:
    """Starting torque of a ball bearing that carries thrust one way, under its preload; None without one, and for nuts."""
    parts, preload = answers.parts, answers.preload
    if (
        not isinstance(parts, Scene)
        or s.of.kind != "bearing"
        or s.of.thrust not in ("+z", "-z")
        or not (preload and preload.axial)
    ):
        return None
    from rollbench.compare.scenes.bearing_pairs import starting_torque as formula_torque

    return record(STARTING, formula_torque(parts, preload.axial))


def set_json(s: SetResult, answers: SetAnswers | None, motion: Motion | None) -> dict[str, Any]:
    """Summary of one set of several, of balls or of rollers, on a shaft in motion."""
    if not np.isfinite(s.loads).all():
        return {}
    data: dict[str, Any] = {} if s.balls is None else {"sides": sides_json(s.balls.load)}
    if answers is None:
        return data
    loads = roller_loads(s.loads) if s.balls is None else loads_json(s.balls.load)
    data |= {"loads": loads, **contacts_json(answers.loads, motion), "preload": record(PRELOAD, answers.preload)}
    if not isinstance(answers.parts, Scene):
        return data
    data["clearance"] = record(CLEARANCE, clearance_in(answers.parts, s.of.thrust))
    return data | {"starting_torque": starting_torque(s, answers)}


def whole_stiffness(result: AxisResult) -> dict[str, Any] | None:
    """The stiffness of several sets as a whole, in the keys of a single set's."""
    if result.stiffness is None:
        return None
    return {"at": result.stiffness_at, **stiffness_json(result.station, result.status, result.stiffness)}


def whole_json(one: SolvedAxis) -> dict[str, Any]:
    """Summary of several sets: sides of all balls, what the set of the worst contact says, with its number, axial
    answers."""
    result, answers = one.result, one.answers
    if not result.converged:
        return {}
    loads = [balls.load for balls in result.of_balls()]
    data: dict[str, Any] = {"sides": sides_json(np.concatenate(loads))} if loads else {}
    if answers is None:
        return data
    K = None if result.stiffness is None else result.stiffness[2, 2]
    moved = answers.displacement
    data["axial"] = {
        "force_N": number(answers.force),
        "displacement_um": None if moved is None else number(1e6 * moved),
        "rigidity_N_per_um": number(1e-6 * answers.force / moved) if moved and answers.force else None,
        "tangent_N_per_um": None if K is None else number(1e-6 * K),
        "lost_motion_um_per_100N": None if K is None or K <= 0.0 else number(1e6 * 2.0 * 100.0 / K),
    }
    data["stiffness"] = whole_stiffness(result)
    data["load_path"] = path_json(answers.path)
    for i in by_pressure(answers)[:1]:
        of_set = set_json(result.sets[i], answers.sets[i], one.scene.motion)
        data |= {"worst_set": i + 1} | {k: of_set[k] for k in of_set if k not in OF_A_SET}
    return data


def by_pressure(answers: AxisAnswers) -> list[int]:
    """Numbers (from 0) of the loaded sets, first that whose highest pressure is the largest share of what is allowed."""
    found = [x.loads for x in answers.sets]
    shares = {i: x.worst.pressure / x.safety.allowed for i, x in enumerate(found) if x.worst and x.safety}
    return sorted(shares, key=lambda i: -shares[i])
