"""Values published by other programs, makers' catalogues and textbooks, recomputed with the models of this package.

Bearings: displacements, contact angles, load zones, preloaded pairs. Single contacts: Hertz, rolling with creepage and spin
on half spaces. Ball nuts of catalogues: rigidities as ISO 3408-4 separates them, drag torque, equivalent loads. Inputs that
no scene describes are in ``cases.toml``, with the assumptions made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from math import pi
from typing import Any

import numpy as np

from rollbench.compare import files
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import load_printed_table, printed_entry
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.hifi.rolling import verification
from rollbench.hifi.rolling.patch import solve_elastic_contact_on_grid
from rollbench.lowfi.bearings import angular_contact, axis
from rollbench.lowfi.bearings.tapered_roller import load_zone_integrals
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.hertz import HertzConstants, contact_modulus, hertz_constants
from rollbench.lowfi.rating import life
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.rigidity import axial_compliance_of_bodies, axial_force, displacement_by_contacts_only
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import FREEDOMS, Friction, Motion, Scene
from rollbench.meshes.units import parse_quantity

#: Prefix of the names of the printed tables and scenes of all external cases.
PREFIX = "external-"


def external_inputs() -> dict[str, Any]:
    """Read the inputs of all external cases from ``cases.toml``, by name of the case.

    An external case is a result that another program, a maker's catalogue or a textbook publishes. Quantities with units
    remain text.
    """
    return files.read_shipped_toml("cases/external/cases.toml")


def external_input(case: str, key: str, quantity: str) -> float:
    """Read one input of a case from another program, a maker or a textbook, and convert it to SI units.

    ``case``: name of the case; ``key``: name of the input; ``quantity``: kind of quantity, such as "force" or "length".
    Raises KeyError for an unknown case or key.
    """
    return parse_quantity(external_inputs()[case][key], quantity)


def assumptions_by_external_case() -> dict[str, tuple[str, ...]]:
    """Return as sentences the assumptions of each external case that has no scene file, by name of the case.

    An external case is a result that another program, a maker's catalogue or a textbook publishes.
    """
    return {name: tuple(table["assumed"]) for name, table in external_inputs().items() if "assumed" in table}


def shipped_shaft_scene(name: str) -> Assembly:
    """Return the scene ``external-NAME``, included with rollbench, of a shaft with bearing rows or nuts.

    ``name``: NAME, such as "masta-radial". Raises InputError for a scene without such a shaft.
    """
    return catalogue.shipped_scene_of_kind(PREFIX + name, Assembly)


def solve_shaft_and_bearing_row(cache: SceneResultCache, name: str) -> tuple[AxisResult, SetResult]:
    """Solve the scene ``external-NAME``, a shaft with one bearing row that has rigid rings, by the beam model.

    ``cache``: caches the result, so that each scene is solved once; ``name``: NAME, such as "masta-radial". Returns the
    result of the shaft, then the result of its bearing row.
    """
    result = cache.compute_once(_solve_shaft_scene, name)
    return result, result.sets[0]


def _solve_shaft_scene(cache: SceneResultCache, name: str) -> AxisResult:  # noqa: ARG001 - kept by the study
    """Solve the scene ``external-NAME`` by the beam model; raises AssertionError if the solution does not converge.

    ``cache``: not used; ``name``: NAME, such as "masta-radial".
    """
    result = run_model(shipped_shaft_scene(name), "lin")
    assert result.converged, f"{PREFIX}{name}: {result.status}"
    return result


CLASSES = ("light", "medium", "strong")

#: Usual range of conformity (groove radius over ball diameter). The growth of rigidity with preload is compared with
#: GMN's at both ends of the range, so that no conformity has to be inferred.
ANY = (0.53, 0.56)


def _shaft_displacement_at(found: AxisResult, station: float, freedom: str) -> float:
    """Return the displacement [m] or rotation [rad] of the shaft at the computed section nearest to an axial position.

    ``found``: result of the shaft; ``station``: axial position [m]; ``freedom``: displacement "ux", "uy" or "uz" along an
    axis, or rotation "rx", "ry" or "rz" about it (z: axis of the shaft).
    """
    place = int(np.abs(found.centreline_z - station).argmin())
    return float(found.centreline[place, FREEDOMS.index(freedom)])


def deep_groove_bearing(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute displacements and rating lives of the deep-groove ball bearing that was also computed by the program MASTA.

    The rings are rigid, and under each load the inner ring moves only in the direction of this load. The lives are computed
    with the load rating that was entered in MASTA. ``findings``: receives the computed value to compare with each published
    number; ``cache``: gives the solved scenes.
    """
    rated = external_input("masta", "rating", "force")
    for key, name, freedom, unit in (
        ("radial", "masta-radial", "ux", 1e6),
        ("axial", "masta-axial", "uz", 1e6),
        ("tilt", "masta-moment", "ry", 1e3),
    ):
        result, ring = solve_shaft_and_bearing_row(cache, name)
        findings.add_number(key, unit * _shaft_displacement_at(result, ring.of.position, freedom))
        assert ring.balls is not None
        assert isinstance(ring.of.parts, Scene)
        found = life.basic_rating_life(ring.of.parts, ring.balls.load)
        assert found is not None
        findings.add_number(f"{key}_life", found.revolutions * (rated / found.rating) ** 3)


def bearing_218(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute contact angle, displacement and ball load of the textbooks' 218 bearing under thrust (Jones, Harris).

    ``findings``: receives the computed value to compare with each published number; ``cache``: gives the solved scenes.
    """
    result, ring = solve_shaft_and_bearing_row(cache, "harris-218")
    assert ring.balls is not None
    angle = float(np.degrees(ring.balls.contact_angle[0, 0]))
    moved = 1e6 * _shaft_displacement_at(result, ring.of.position, "uz")
    findings.numbers(dict.fromkeys(("angle", "angle_quoted"), angle))
    findings.numbers(dict.fromkeys(("displacement", "displacement_quoted"), moved))
    findings.add_number("ball_load", float(ring.balls.load[:, 0].mean()))


def half_load_zone(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute the load distribution of a bearing whose load zone is half the circumference (Sjövall).

    The ball loads are computed with a row of many balls, the thrust by load-distribution integrals. ``findings``: receives
    the computed value to compare with each published number; ``cache``: gives the solved scenes.
    """
    for key, name in (("radial", "sjovall-radial"), ("combined", "sjovall-combined")):
        ring = solve_shaft_and_bearing_row(cache, name)[1]
        assert ring.balls is not None
        across = shipped_shaft_scene(name).loads[0].force[0]
        load, rest = ring.balls.load[:, 0], ring.balls.contact_angle[:, 0]
        top = int(load.argmax())
        # a ball of the deep groove carries the same force at both its contacts: the inner one counts
        findings.add_number(key, float(load[top]) * load.size * float(np.cos(rest[top])) / across)
        if key == "combined":
            findings.add_number("loaded", float(np.count_nonzero(load > 0.0)))
    zone = load_zone_integrals(0.5, 1.5)
    findings.add_number("thrust", zone.thrust_integral / zone.radial_integral)


def _bearing_of_catalogue_row(case: str, row: Sequence[float], conformity: float) -> angular_contact.BallBearing:
    """Return a spindle bearing with the dimensions that a maker's catalogue prints for it.

    ``case``: name of the case in ``cases.toml`` from which contact angle and material are read; ``row``: pitch diameter
    [mm], ball diameter [mm] and number of balls; ``conformity``: groove radius over ball diameter.
    """
    d_m, d_w, balls = row[:3]
    angle, young = (external_input(case, "contact_angle", "angle"), external_input(case, "youngs_modulus", "pressure"))
    poisson = float(external_inputs()[case]["poissons_ratio"])
    grooves = conformity, conformity
    return angular_contact.bearing_with_contact_angle(int(balls), 1e-3 * d_w, 1e-3 * d_m, grooves, angle, young, poisson)


def _preloaded_bearing_pair(bearing: angular_contact.BallBearing, preload: float) -> axis.BearingRows:
    """Return a pair of opposed bearings, preloaded against each other by the axial force ``preload`` [N]."""
    return axis.equal_rows_with_preload(bearing, (1, -1), preload)


@cache
def gmn_pair_rigidity(name: str, preload_class: str, conformity: float) -> float:
    """Return the axial rigidity [N/um] of a preloaded pair of GMN's bearings: twice the rigidity of one bearing.

    ``name``: size of the bearing; ``preload_class``: preload class "light", "medium" or "strong"; ``conformity``: groove
    radius over ball diameter.
    """
    row = external_inputs()["gmn"]["rows"][name]
    one = _bearing_of_catalogue_row("gmn", row, conformity)
    return 2e-6 * one.stiffness(one.deflection(float(row[3 + CLASSES.index(preload_class)])))


def gmn_rigidity_growth_over_printed(conformity: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the computed growth of rigidity from light to strong preload divided by the printed one, for GMN's bearings.

    The growth is the rigidity of a preloaded pair at strong preload divided by its rigidity at light preload. The result is
    an array (n,) for n sizes of bearing. ``conformity``: groove radius over ball diameter.
    """
    out = []
    for name in external_inputs()["gmn"]["rows"]:
        printed = [printed_entry("external-gmn", f"{name}_{which}").value or np.nan for which in ("light", "strong")]
        ours = [gmn_pair_rigidity(name, which, conformity) for which in ("light", "strong")]
        out.append(ours[1] / ours[0] * printed[0] / printed[1])
    return np.array(out)


def gmn_rigidities(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the rigidities printed in GMN's catalogue for preloaded pairs of a series of spindle bearings.

    ``findings``: receives the computed rigidity to compare with each printed one, and whether the claim on their growth
    with preload holds. ``cache``: not used here.
    """
    inferred = float(external_inputs()["gmn"]["conformity"])
    for name in external_inputs()["gmn"]["rows"]:
        for which in CLASSES:
            findings.add_number(f"{name}_{which}", gmn_pair_rigidity(name, which, inferred))
    middle = {c: float(np.median(gmn_rigidity_growth_over_printed(c))) for c in (*ANY, inferred)}
    words = ", ".join(f"{m:.3f} at conformity {c:g}" for c, m in middle.items())
    findings.add_claim("growth", all(abs(float(error_percent(m, 1.0))) <= 2.0 for m in middle.values()), f"median {words}")


def gmn_rigidity_rms_error_percent() -> float:
    """Return the RMS error [%] of the computed rigidities of bearing pairs against those printed by GMN.

    Only printed values of class "band" count: values that need not agree exactly, but within a tolerance.
    """
    inferred = float(external_inputs()["gmn"]["conformity"])
    banded = [r for r in load_printed_table("external-gmn") if r.entry_class == "band"]
    rows = [(r.key.rsplit("_", 1), r.value) for r in banded if r.value is not None]
    off = [float(error_percent(gmn_pair_rigidity(name, which, inferred), value)) for (name, which), value in rows]
    return float(np.sqrt(np.mean(np.square(off))))


def snfa_rigidities(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute rigidity, its growth with preload, and lift-off load of a preloaded bearing pair in SNFA's catalogue.

    The values "as printed" follow the catalogue's formulas, which assume constant contact angles; in the correct values,
    the contact angles change under load. ``findings``: receives both values to compare with each printed number. ``cache``:
    not used here.
    """
    case = external_inputs()["snfa"]
    row = [1e3 * external_input("snfa", k, "length") for k in ("pitch_diameter", "ball_diameter")]
    bearing = _bearing_of_catalogue_row("snfa", [*row, case["balls"]], float(case["conformity"]))
    loads = [parse_quantity(text, "force") for text in case["preloads"]]
    right = [1e-6 * axis.solve_bearing_row_equilibrium(_preloaded_bearing_pair(bearing, p)).stiffness for p in loads]
    still = [1e-6 * pair_rigidity_at_constant_angle(bearing, p) for p in loads]
    for name, value, at in zip(("light", "medium", "heavy"), right, still, strict=True):
        words = f"{at:.1f} N/um at a constant angle, conformity {case['conformity']:g}"
        findings.add_number(f"rigidity_{name}", value, words)
    growth = right[-1] / right[0]
    words = f"{growth / (still[-1] / still[0]):.2f} times that at a constant angle: a bearing that may turn stiffens faster"
    findings.add_number("growth", growth, words, as_printed=still[-1] / still[0])
    off = axis.lift_off_force(_preloaded_bearing_pair(bearing, loads[-1])) / loads[-1]
    words = f"at {loads[-1]:g} N; the angle turns, and the pair holds together longer"
    findings.add_number("lift_off", off, words, as_printed=2.0**1.5)  # for constant contact angles


def pair_rigidity_at_constant_angle(bearing: angular_contact.BallBearing, preload: float) -> float:
    """Return the axial rigidity [N/m] of a preloaded bearing pair whose contact angle stays constant under load.

    ``preload``: axial force F [N] between the bearings. With the displacement u of one bearing, F ~ u^(3/2), so the
    rigidity of the pair is 3 F/u.
    """
    rest = angular_contact.bearing_state_at_displacement(bearing, 1e-9 * bearing.ball_diameter)
    sin = float(np.sin(bearing.free_angle))
    u = float(rest.inner_hertz.C + rest.outer_hertz.C) * float(np.cbrt(preload / (bearing.balls * sin))) ** 2 / sin
    return 3.0 * preload / u


#: Makers' examples of mean forces: key of the printed mean force, name of the case with the phases of the duty cycle.
EXAMPLES = {"mean_hiwin_mill": "hiwin_mill", "mean_hiwin": "hiwin", "mean_rexroth": "rexroth"}

#: Value that makers print for 2^(3/2), and the error [%] that this may cause in the force on one half of a preloaded nut.
ROUNDED, WITHIN = 3.0, 5.0

#: Scene whose dynamic rating is used for the combined life of both halves of a nut, its preload [N] and axial force [N].
SCENE, PRELOAD, FORCE = "external-thk-bnf-4010-5", 5000.0, 3000.0


def mean_speed_of_duty_cycle(case: str) -> float:
    """Return the mean speed [rpm] of a maker's example of a duty cycle, from its speeds and times.

    ``case``: name of the example in ``cases.toml``.
    """
    given = external_inputs()[case]
    phases = zip(given["speeds"], given["time"], strict=True)
    cases = [f'[[cases]]\nname = "p{k}"\nspeed = "{n} rpm"\ntime = "{t} s"\n' for k, (n, t) in enumerate(phases)]
    cycle = scene_file.parse_scene("\n".join([catalogue.shipped_scene_text(SCENE), *cases]), SCENE)
    assert isinstance(cycle, DutyCycle)
    assert cycle.speed is not None
    return cycle.speed * 30.0 / pi


def equivalent_force_of_duty_cycle(case: str) -> float:
    """Return the equivalent mean force of a maker's example of a duty cycle, in the unit of its forces.

    ``case``: name of the example in ``cases.toml``.
    """
    given = external_inputs()[case]
    turned = np.array(given["speeds"], dtype=float) * np.array(given["time"], dtype=float)
    forces = np.array(given["forces"], dtype=float)
    return float(given.get("factor", 1.0)) * life.mean_force(turned / turned.sum(), forces)


def equivalent_loads(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute makers' examples of equivalent loads of ball nuts, and ISO 281's load factors of bearings.

    The examples are mean forces of duty cycles, and forces and life of both halves of a preloaded nut; the factors are e, X
    and Y. ``findings``: receives the computed value to compare with each printed number; ``cache``: gives the scenes
    included with rollbench.
    """
    for key, case in EXAMPLES.items():
        findings.add_number(key, equivalent_force_of_duty_cycle(case))
    findings.add_number("speed_rexroth", mean_speed_of_duty_cycle("rexroth"))
    findings.add_number("parting", life.PARTING)
    force = np.linspace(0.0, life.PARTING, 50)
    loaded, other = life.forces_on_nut_halves(force, 1.0)
    lower = error_percent((1.0 + force / ROUNDED) ** 1.5, loaded)
    words = (
        f"with 3 the loaded half's force is {-float(lower.min()):.1f} % lower where the halves part, and no higher anywhere"
    )
    holds = bool((lower <= 1e-9).all() and lower.min() >= -WITHIN and np.allclose(loaded - other, force))
    findings.add_claim("loaded_half", holds, words)
    scene = cache.built_in_scene(SCENE)
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, FORCE)) for x in scene.loads))
    found = life.life_by_equivalent_loads([nut], [1.0], [np.array([0.0, 0.0, FORCE])], PRELOAD)
    assert found is not None
    lives = (life.dynamic_rating(nut) / np.array(found.equivalent_loads)) ** 3
    printed = float((lives ** (-10.0 / 9.0)).sum() ** -0.9)
    words = f"{found.revolutions:.4g} 10^6 revolutions, of {lives[0]:.4g} and {lives[1]:.4g}"
    findings.add_claim("combined_life", bool(np.isclose(found.revolutions, printed, rtol=1e-12)), words)
    for name, angle in (row.key.split("_") for row in load_printed_table(findings.table) if row.key[0] in "eXY"):
        factor = life.equivalent_load_factors(float(np.radians(float(angle))))["eXY".index(name)]
        of_table = float(angle) <= life.RADIAL_UP_TO  # the standard's table on both sides; above, its formula
        (findings.follow if of_table else findings.numbers)({f"{name}_{angle}": factor})


#: Cells along each axis of the grid of the program CONTACT's example, and width of the grid over that of the contact.
EXAMPLE_CELLS, EXAMPLE_MARGIN = 44, 1.1

#: Cells of CONTACT's wheel example, along and across.
WHEEL_CELLS = (48, 44)

#: Number of steps, of one cell's length each, that CONTACT's ball is rolled from rest. They go past the step with the
#: largest creepage; the example has 56 steps.
ONSET_STEPS = 20


def ball_of_bearing(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the Hertz contacts of one ball of NSK's screw-support bearing at the published ball load and contact angle.

    ``findings``: receives contact angle, approaches and semi-axes, to compare with the published numbers. ``cache``: not
    used here.
    """
    parts = shipped_shaft_scene("nsk-25bswz01").sets[0].parts
    assert isinstance(parts, Scene)
    d, steel, track = 2.0 * parts.balls.radius, parts.nut.material, parts.track
    grooves = (parts.screw.groove_radius / d, parts.nut.groove_radius / d)
    young, poisson = steel.youngs_modulus, steel.poissons_ratio
    pitch, rest = 2.0 * track.pitch_radius, track.contact_angle
    bearing = angular_contact.bearing_with_contact_angle(1, d, pitch, grooves, rest, young, poisson)
    angle = np.arccos(external_inputs()["nsk"]["cosine"])
    findings.follow({"angle": float(np.degrees(angle))})
    modulus = contact_modulus(young, poisson, young, poisson)
    curvatures = angular_contact.relative_curvatures(bearing, np.array(angle))
    inner, outer = (hertz_constants(*pair, modulus) for pair in curvatures)
    cube = float(np.cbrt(external_input("nsk", "normal_load", "force")))
    findings.numbers({"approach_outer": 1e6 * outer.C * cube**2, "approach_inner": 1e6 * inner.C * cube**2})
    findings.numbers({"a_outer": 1e3 * outer.C_a * cube, "b_outer": 1e3 * outer.C_b * cube})


def sphere_on_plane(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the contact radius of an elastic sphere on a rigid plane, Ansys's verification case 63.

    ``findings``: receives the contact radius [mm], to compare with the published one. ``cache``: not used here.
    """
    radius = external_input("vm63", "radius", "length")
    poisson, young = external_inputs()["vm63"]["poissons_ratio"], external_input("vm63", "youngs_modulus", "pressure")
    modulus = young / (1.0 - poisson**2)
    found = hertz_constants(np.array(1.0 / radius), np.array(1.0 / radius), modulus)
    findings.add_number("radius", 1e3 * float(found.C_a) * float(np.cbrt(external_input("vm63", "force", "force"))))


def _load_radii_and_material(case: str) -> tuple[float, tuple[float, float], float, float]:
    """Return the inputs of the normal contact in an example of the program CONTACT.

    First: load [N]; second: relative radii of curvature [m] along and across the rolling direction; third: Young's modulus
    [Pa]; fourth: Poisson's ratio. ``case``: name of the example.
    """
    poisson, shear = external_inputs()[case]["poissons_ratio"], external_input(case, "shear_modulus", "pressure")
    radii = (external_input(case, "along", "length"), external_input(case, "across", "length"))
    return external_input(case, "force", "force"), radii, 2.0 * shear * (1.0 + poisson), poisson


def _load_and_hertz_constants(case: str) -> tuple[float, HertzConstants]:
    """Return load [N], then Hertz's constants, of the contact in the program CONTACT's example ``case``."""
    load, radii, young, poisson = _load_radii_and_material(case)
    modulus = contact_modulus(young, poisson, young, poisson)
    return load, hertz_constants(np.array(1.0 / radii[0]), np.array(1.0 / radii[1]), modulus)


@lru_cache(maxsize=8)
def solve_rolling_example(cells: int, *, by_contact_scheme: bool = False) -> verification.RolledContact:
    """Solve the steady-rolling example of the program CONTACT, which has lateral creepage and spin.

    ``cells``: number of cells of the grid along each axis; ``by_contact_scheme``: whether to use CONTACT's grid and its
    finite differences of slip over one cell, instead of the scheme of this package.
    """
    case, touch = external_inputs()["contact"], _load_radii_and_material("contact")
    creep, mu = verification.Creep(0.0, case["creep_across"], case["spin"]), case["friction"]
    if by_contact_scheme:
        patch = solve_elastic_contact_on_grid(*touch, (cells, cells), margin=EXAMPLE_MARGIN)
        return verification.solve_steady_rolling_like_kalker(patch, creep, mu)
    return verification.solve_steady_rolling_for_creepages(solve_elastic_contact_on_grid(*touch, (cells, cells)), creep, mu)


def lateral_force_and_moment(cells: int, *, by_contact_scheme: bool = False) -> dict[str, float]:
    """Return lateral force over mu P, and moment [N mm], of the example of `solve_rolling_example`, by their keys."""
    found = solve_rolling_example(cells, by_contact_scheme=by_contact_scheme)
    bound = external_inputs()["contact"]["friction"] * external_input("contact", "force", "force")
    return {"lateral": float(found.friction_force[1]) / bound, "moment": 1e3 * found.friction_moment}


def rolling_examples(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the published examples of the program CONTACT: steady rolling, a wheel, and rolling from rest.

    Steady rolling has lateral creepage and spin; its Hertz contact, force and moment on elastic half spaces are computed.
    ``findings``: receives the computed value to compare with each published number. ``cache``: not used here.
    """
    load, hertz = _load_and_hertz_constants("contact")
    cube = float(np.cbrt(load))
    findings.numbers({"a": 1e3 * hertz.C_a * cube, "b": 1e3 * hertz.C_b * cube, "approach": 1e3 * hertz.C * cube**2})
    findings.numbers({"pressure": 1e-6 * hertz.pressure(np.array(load))})
    ours = lateral_force_and_moment(EXAMPLE_CELLS)
    for key, value in lateral_force_and_moment(EXAMPLE_CELLS, by_contact_scheme=True).items():
        note = f"by CONTACT's differences over one cell; by those of rolling in 3D {ours[key]:.4g}"
        findings.add_number(key, value, note)
    _compute_wheel_creep_curve(findings)
    _compute_examples_of_rolling_from_rest(findings)


def _compute_wheel_creep_curve(findings: ComputedEntryValues) -> None:
    """Compute the creep-force curve of CONTACT's locomotive wheel, by CONTACT's difference scheme.

    ``findings``: receives the results.
    """
    load, hertz = _load_and_hertz_constants("wheel")
    cube, mu = float(np.cbrt(load)), float(external_inputs()["wheel"]["friction"])
    findings.numbers({"wheel_a": 1e3 * hertz.C_b * cube, "wheel_b": 1e3 * hertz.C_a * cube})
    patch = solve_elastic_contact_on_grid(*_load_radii_and_material("wheel"), WHEEL_CELLS, margin=EXAMPLE_MARGIN)
    for row in load_printed_table(findings.table):
        curve, _, creep = row.key.rpartition("_")
        if curve == "wheel_creep":
            found = verification.solve_steady_rolling_like_kalker(patch, verification.Creep(float(creep), 0.0, 0.0), mu)
            findings.add_number(row.key, float(found.friction_force[0]) / (mu * load))


@lru_cache(maxsize=4)
def solve_push_and_roll_example(case: str, steps: int) -> list[verification.RollingOnsetStep]:
    """Solve an example of the program CONTACT in which a ball is pushed sideways at rest, and then rolls.

    ``case``: name of the example; ``steps``: number of steps, each of one cell's length, that the ball rolls. Returns the
    state at rest, then the states after each step.
    """
    numbers, (load, circle) = external_inputs()[case], _load_and_hertz_constants(case)
    margin = 0.5 * external_input(case, "grid", "length") / (float(circle.C_a) * float(np.cbrt(load)))
    patch = solve_elastic_contact_on_grid(*_load_radii_and_material(case), (numbers["cells"],) * 2, margin=margin)
    return verification.simulate_rolling_onset(patch, numbers["friction"], numbers["share"], steps)


def _compute_examples_of_rolling_from_rest(findings: ComputedEntryValues) -> None:
    """Compute CONTACT's examples of a ball pushed sideways, then rolled towards steady rolling.

    ``findings``: receives the results.
    """
    found = {
        "cattaneo": solve_push_and_roll_example("cattaneo", 0),
        "onset": solve_push_and_roll_example("onset", ONSET_STEPS),
    }
    for row in load_printed_table(findings.table):
        case, _, rest = row.key.partition("_")
        if case in found:
            what, _, step = rest.partition("_")
            one = found[case][int(step or 0)]
            value = {
                "shift": 1e3 * one.shift_or_creepage,
                "creep": one.shift_or_creepage,
                "sticking": float(one.sticking_cell_count),
            }
            findings.add_number(row.key, value[what])


#: Sizes of THK's nuts and of one of HIWIN: last part of the scenes' names.
THK = ("bnf-4010-5", "bnf-4010-3p5", "bnf-3205-2p5", "bnf-3205-5", "bnf-3205-7p5")

HIWIN = ("hiwin-63-10k5",)

#: Size of the single nut of which a double nut is made.
DOUBLE = "bnf-4010-5"

#: Rigidity in the catalogue divided by the rigidity of the Hertz contacts alone, computed by an independent program:
#: lowest and highest ratio, by sizes of a maker.
SHARES = {THK: (0.567, 0.586), HIWIN: (0.75, 0.75)}

#: Relative error of a rigidity that the number of balls and the pitch diameter may cause, which are not printed.
UNPRINTED = 0.05


def scene_name_of_catalogue_size(size: str) -> str:
    """Return the name of the scene for a nut of THK or HIWIN; ``size``: size of the nut, such as "bnf-4010-5"."""
    return f"{PREFIX}{size}" if size in HIWIN else f"{PREFIX}thk-{size}"


def nut_rigidities_without_and_with_bodies(scene: Scene, force: float) -> tuple[float, float]:
    """Return two axial rigidities [N/m] of a nut with equally loaded balls: with rigid bodies, then with elastic bodies.

    Rigid bodies: only the Hertz contacts deform; elastic bodies: nut and screw deform as thick tubes, too. ``scene``: screw
    and nut; ``force``: axial load [N]. Raises AssertionError for a bearing, which has no lead, and ValueError if nut or
    screw has no wall behind its contacts.
    """
    alone, body = displacement_by_contacts_only(scene, force), axial_compliance_of_bodies(scene)
    assert body is not None
    return force / alone, force / (alone + body * force)


def nut_rigidity_with_unequal_loads(cache: SceneResultCache, name: str, model: str) -> float:
    """Return the axial rigidity [N/m] of a nut by a model in which ball loads differ; zero if the model did not converge.

    ``cache``: gives the solved scenes; ``name``: name of the scene; ``model``: name of the model.
    """
    scene, found = cache.built_in_scene(name), cache.solve_once(name, model)
    return axial_force(found) / float(motion_at(found, scene.nut.position)[2]) if found.converged else 0.0


def nut_rigidities(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute the rigidities of THK's and HIWIN's nuts at 0.3 of their dynamic rating C, and related printed values.

    The related values are the growth of rigidity with the number of turns, the rigidity of a double nut, and its drag
    torque. ``findings``: receives the computed value to compare with each printed number, and whether each printed claim
    holds; ``cache``: gives the solved scenes.
    """
    alone, bodies = {}, {}
    for size in (*THK, *HIWIN):
        scene = cache.built_in_scene(scene_name_of_catalogue_size(size))
        rigidities = nut_rigidities_without_and_with_bodies(scene, scene.loads[0].force[2])
        alone[size], bodies[size] = (1e-6 * x for x in rigidities)
        printed = printed_entry(findings.table, f"rigidity_{size}").value or 0.0
        share = printed / alone[size]
        words = f"catalogue {printed / bodies[size]:.3f} of it; contacts alone {alone[size]:.0f} N/um"
        findings.add_number(f"rigidity_{size}", bodies[size], words)
        low, high = next(ends for sizes, ends in SHARES.items() if size in sizes)
        words = f"{share:.3f} of {alone[size]:.0f} N/um"
        findings.add_claim(f"share_{size}", low * (1.0 - UNPRINTED) <= share <= high * (1.0 + UNPRINTED), words)
    for turns in ("5", "7p5"):
        findings.add_number(f"turns_{turns}", alone[f"bnf-3205-{turns}"] / alone["bnf-3205-2p5"], "contacts alone")
    words = f"contacts alone {2.0**1.5 / 3.0 ** (1.0 / 3.0):.3f}"
    findings.add_number("double", double_over_single_nut_rigidity(cache), f"with the bodies; {words}")
    _compute_double_nut_drag_torque(cache, findings)


def double_over_single_nut_rigidity(cache: SceneResultCache) -> float:
    """Return the axial rigidity of a preloaded double nut divided by that of a single nut; contacts and bodies are elastic.

    The preload is a third of the single nut's load. The double nut's rigidity is the axial load that just unloads one of
    its two nuts, divided by the displacement at this load, which equals the deflection of one nut by the preload.
    ``cache``: gives the scenes included with rollbench.
    """
    scene = cache.built_in_scene(scene_name_of_catalogue_size(DOUBLE))
    full = scene.loads[0].force[2]
    preload = full / 3.0
    single = nut_rigidities_without_and_with_bodies(scene, full)[1]
    moved = preload / nut_rigidities_without_and_with_bodies(scene, preload)[1]

    def displacement_beyond_lift_off(force: float) -> float:
        """Return the deflection [m] of one nut under ``force`` [N], less its deflection when the other nut unloads."""
        return force / nut_rigidities_without_and_with_bodies(scene, force)[1] - 2.0 * moved

    unloads = float(brentq(displacement_beyond_lift_off, preload, 4.0 * preload, rtol=1e-6))
    return unloads / moved / single


def _compute_double_nut_drag_torque(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Compute the drag torque of a preloaded double nut by THK's formula, and by sliding balls.

    ``cache``: gives the scenes and caches the drag torque; ``findings``: receives the results.
    """
    case = external_inputs()["thk"]
    preload, lead = external_input("thk", "preload", "force"), external_input("thk", "lead", "length")
    mu = float(case["friction"])
    formula = 0.05 * case["tangent"] ** -0.5 * preload * lead / (2.0 * pi)
    findings.follow({"drag_formula": 1e3 * formula})
    torque = cache.compute_once(double_nut_drag_torque, preload, mu)
    printed = printed_entry(findings.table, "drag").value or 0.0
    words = (
        f"both nuts at a coefficient of {mu:g}, friction moving each ball across its grooves as in every scene that says "
        f"nothing else: {1e3 * torque / printed:.2f} times the printed torque"
    )
    findings.add_number("drag", 1e3 * torque, words)


def double_nut_drag_torque(cache: SceneResultCache, preload: float, mu: float) -> float:
    """Return the friction torque [N m] of a preloaded double nut of the size `DOUBLE` by the sliding of its balls.

    ``preload``: axial force between both nuts [N]; ``mu``: coefficient of friction. ``cache``: gives the solved scenes.
    """
    scene = cache.built_in_scene(scene_name_of_catalogue_size(DOUBLE))
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, preload)) for x in scene.loads))
    found = run_model(nut, "lin", ModelOptions(estimate_beam_mesh_error=False))
    return 2.0 * friction_state(nut, found, Friction(mu, mu), Motion(2.0 * pi)).friction_sums.friction_torque
