"""External evidence: values of other programs, of makers' catalogues and of classic theory, computed with these models.

Inputs that no scene describes, in SI, with what was assumed to run them; bearings (displacements, contact angles, load
zones, preloaded pairs); single contacts (Hertz's constants, rolling with creepage and spin on half spaces); ball nuts of
catalogues (the three rigidities that ISO 3408-4 separates, drag torque).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from math import pi
from typing import Any

import numpy as np

from rollbench.compare import files
from rollbench.compare.evidence import Findings
from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry, load_table
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.hifi.rolling.patch import hertz_patch
from rollbench.hifi.rolling.verification import Creep, Onset, onset, steady, steady_by_cells
from rollbench.lowfi.bearings.angular_contact import (
    BallBearing,
    BallRow,
    bearing_of_contact_angle,
    relative_curvatures,
    thrust_state,
)
from rollbench.lowfi.bearings.axis import BearingSet, equilibrium, lift_off_force, preloaded_rows
from rollbench.lowfi.bearings.combined_load import load_zone
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.hertz import HertzConstants, contact_modulus, hertz_constants
from rollbench.lowfi.rating.life import (
    PARTING,
    dynamic_rating,
    equivalent_life,
    forces_on_halves,
    life,
    mean_force,
    radial_and_axial_factors,
)
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force, body_compliance, contacts_displacement
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import FREEDOMS, Friction, Motion, Scene
from rollbench.meshes.units import parse

#: Beginning of the names of tables and scenes of this kind.
PREFIX = "external-"


def inputs() -> dict[str, Any]:
    """Return the tables of ``cases.toml`` unparsed: quantities with units remain text."""
    return files.shipped_table("cases/external/cases.toml")


def input_in_SI(case: str, key: str, quantity: str) -> float:
    """Return an input of a case in SI.

    Raises KeyError for one that is not there.
    """
    return parse(inputs()[case][key], quantity)


def assumptions() -> dict[str, tuple[str, ...]]:
    """Return the assumptions of each case that has no separate scene file, by name of the case."""
    return {name: tuple(table["assumed"]) for name, table in inputs().items() if "assumed" in table}


def assembly(name: str) -> Assembly:
    """Return a shipped scene ``external-NAME`` with sets on a shaft.

    Raises AssertionError where it is another kind.
    """
    found = catalogue.shipped(PREFIX + name)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{PREFIX}{name} has sets on a shaft")
    return found


def solved(study: Study, name: str) -> tuple[AxisResult, SetResult]:
    """Solve a shipped scene ``external-NAME`` with one rolling set between rigid rings.

    Returns the result, and that of its set.
    """
    result = study.once(_solved, name)
    return result, result.sets[0]


def _solved(study: Study, name: str) -> AxisResult:  # noqa: ARG001 - kept by the study
    """Solve a shipped scene for `solved`; raises AssertionError if it does not converge."""
    result = run_model(assembly(name), "lin")
    if not result.converged:
        raise AssertionError(f"{PREFIX}{name}: {result.status}")
    return result


CLASSES = ("light", "medium", "strong")

#: Conformities between which the growth of rigidity is looked at without an inferred number.
ANY = (0.53, 0.56)


def _motion(found: AxisResult, station: float, freedom: str) -> float:
    """Return a displacement [m] or rotation [rad] of the shaft at the computed station nearest to a given one [m]."""
    place = int(np.abs(found.centreline_z - station).argmin())
    return float(found.centreline[place, FREEDOMS.index(freedom)])


def masta(findings: Findings, study: Study) -> None:
    """Compute the entries of a deep-groove bearing between rigid rings, the inner ring free only along each load.

    The entries are displacements and lives; life is proportional to the cube of the load rating given to MASTA.
    """
    rated = input_in_SI("masta", "rating", "force")
    for key, name, freedom, unit in (
        ("radial", "masta-radial", "ux", 1e6),
        ("axial", "masta-axial", "uz", 1e6),
        ("tilt", "masta-moment", "ry", 1e3),
    ):
        result, ring = solved(study, name)
        findings.number(key, unit * _motion(result, ring.of.position, freedom))
        assert ring.balls is not None
        assert isinstance(ring.of.parts, Scene)
        found = life(ring.of.parts, ring.balls.load)
        assert found is not None
        findings.number(f"{key}_life", found.revolutions * (rated / found.rating) ** 3)


def harris(findings: Findings, study: Study) -> None:
    """Compute the entries of the 218 bearing under thrust."""
    result, ring = solved(study, "harris-218")
    assert ring.balls is not None
    angle, moved = float(np.degrees(ring.balls.contact_angle[0, 0])), 1e6 * _motion(result, ring.of.position, "uz")
    findings.number("angle", angle)
    findings.number("angle_quoted", angle)
    findings.number("displacement", moved)
    findings.number("displacement_quoted", moved)
    findings.number("ball_load", float(ring.balls.load[:, 0].mean()))


def half_zone(findings: Findings, study: Study) -> None:
    """Compute the load zone of half the circumference, by a row of many balls and by the integrals."""
    for key, name in (("radial", "sjovall-radial"), ("combined", "sjovall-combined")):
        ring = solved(study, name)[1]
        assert ring.balls is not None
        across = assembly(name).loads[0].force[0]
        load, rest = ring.balls.load[:, 0], ring.balls.contact_angle[:, 0]
        top = int(load.argmax())
        # a ball of the deep groove carries the same force at both its contacts: the inner one counts
        findings.number(key, float(load[top]) * load.size * float(np.cos(rest[top])) / across)
        if key == "combined":
            findings.number("loaded", float(np.count_nonzero(load > 0.0)))
    zone = load_zone(0.5, 1.5)
    findings.number("thrust", zone.axial / zone.radial)


def _spindle(case: str, row: Sequence[float], conformity: float) -> BallBearing:
    """Return the bearing of a catalogue row (pitch diameter mm, ball diameter mm, number of balls)."""
    d_m, d_w, balls = row[:3]
    angle, young = input_in_SI(case, "contact_angle", "angle"), input_in_SI(case, "youngs_modulus", "pressure")
    poisson = float(inputs()[case]["poissons_ratio"])
    return bearing_of_contact_angle(int(balls), 1e-3 * d_w, 1e-3 * d_m, (conformity, conformity), angle, young, poisson)


def _pair(bearing: BallBearing, preload: float) -> BearingSet:
    """Return two opposed bearings, preloaded against each other by a force [N]."""
    return preloaded_rows(BallRow(bearing), (1, -1), preload)


@cache
def gmn_rigidity(name: str, which: str, conformity: float) -> float:
    """Return the axial rigidity [N/um] of a catalogue pair at its preload: twice that of one row.

    ``which``: preload class; ``conformity``: of the grooves of the series.
    """
    row = inputs()["gmn"]["rows"][name]
    one = BallRow(_spindle("gmn", row, conformity))
    return 2e-6 * one.stiffness(one.deflection(float(row[3 + CLASSES.index(which)])))


def gmn_growth(conformity: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return, for every row, the growth of rigidity from light to strong preload: computed over printed."""
    out = []
    for name in inputs()["gmn"]["rows"]:
        printed = [entry("external-gmn", f"{name}_{which}").value or np.nan for which in ("light", "strong")]
        ours = [gmn_rigidity(name, which, conformity) for which in ("light", "strong")]
        out.append(ours[1] / ours[0] * printed[0] / printed[1])
    return np.array(out)


def gmn(findings: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of preloaded pairs of a series of spindle bearings."""
    inferred = float(inputs()["gmn"]["conformity"])
    for name in inputs()["gmn"]["rows"]:
        for which in CLASSES:
            findings.number(f"{name}_{which}", gmn_rigidity(name, which, inferred))
    middle = {c: float(np.median(gmn_growth(c))) for c in (*ANY, inferred)}
    words = ", ".join(f"{m:.3f} at conformity {c:g}" for c, m in middle.items())
    findings.claim("growth", all(abs(float(error_percent(m, 1.0))) <= 2.0 for m in middle.values()), f"median {words}")


def gmn_rms_percent() -> float:
    """Return the RMS error [%] of the computed rigidities against all printed ones of class band."""
    inferred = float(inputs()["gmn"]["conformity"])
    rows = [(r.key.rsplit("_", 1), r.value) for r in load_table("external-gmn") if r.cls == "band" and r.value is not None]
    off = [float(error_percent(gmn_rigidity(name, which, inferred), value)) for (name, which), value in rows]
    return float(np.sqrt(np.mean(np.square(off))))


def snfa(findings: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of a catalogue that keeps contact angles constant.

    The values as printed keep the angles constant; the correct ones let them change under load.
    """
    case = inputs()["snfa"]
    row = [1e3 * input_in_SI("snfa", k, "length") for k in ("pitch_diameter", "ball_diameter")]
    bearing = _spindle("snfa", [*row, case["balls"]], float(case["conformity"]))
    loads = [parse(text, "force") for text in case["preloads"]]
    right = [1e-6 * equilibrium(_pair(bearing, p)).stiffness for p in loads]
    still = [1e-6 * frozen_rigidity(bearing, p) for p in loads]
    for name, value, at in zip(("light", "medium", "heavy"), right, still, strict=True):
        findings.number(f"rigidity_{name}", value, f"{at:.1f} N/um at a constant angle, conformity {case['conformity']:g}")
    growth = right[-1] / right[0]
    words = f"{growth / (still[-1] / still[0]):.2f} times that at a constant angle: a bearing that may turn stiffens faster"
    findings.number("growth", growth, words, as_printed=still[-1] / still[0])
    off = lift_off_force(_pair(bearing, loads[-1])) / loads[-1]
    words = f"at {loads[-1]:g} N; the angle turns, and the pair holds together longer"
    findings.number("lift_off", off, words, as_printed=frozen_lift_off())


def frozen_rigidity(bearing: BallBearing, preload: float) -> float:
    """Return the rigidity [N/m] of a pair at its preload [N] with a constant contact angle: 3 F/u, as F ~ u^(3/2)."""
    rest = thrust_state(bearing, 1e-9 * bearing.ball_diameter)
    sin = float(np.sin(bearing.free_angle))
    u = float(rest.inner.C + rest.outer.C) * float(np.cbrt(preload / (bearing.balls * sin))) ** 2 / sin
    return 3.0 * preload / u


def frozen_lift_off() -> float:
    """Return the load that unloads one row of a pair, over the preload, if contact angles were constant: 2^(3/2)."""
    return float(2.0**1.5)


#: Examples of mean forces: key of the entry, and of the case with its phases.
EXAMPLES = {"mean_hiwin_mill": "hiwin_mill", "mean_hiwin": "hiwin", "mean_rexroth": "rexroth"}

#: What makers print for 2^(3/2), and how far [%] that may move the force of a half before the halves part.
ROUNDED, WITHIN = 3.0, 5.0

#: Scene whose ratings the combined life is computed with, its preload and force [N].
SCENE, PRELOAD, FORCE = "external-thk-bnf-4010-5", 5000.0, 3000.0


def mean_speed(case: str) -> float:
    """Return the mean speed [rpm] of the shipped scene with the speeds and times of a case's phases."""
    given = inputs()[case]
    phases = zip(given["speeds"], given["time"], strict=True)
    cases = [f'[[cases]]\nname = "p{k}"\nspeed = "{n} rpm"\ntime = "{t} s"\n' for k, (n, t) in enumerate(phases)]
    cycle = scene_file.parse_scene("\n".join([catalogue.scene_text(SCENE), *cases]), SCENE)
    assert isinstance(cycle, DutyCycle)
    assert cycle.speed is not None
    return cycle.speed * 30.0 / pi


def mean_of_phases(case: str) -> float:
    """Return the mean force of a case's phases (force, speed, share of time), in the unit of the forces."""
    given = inputs()[case]
    turned = np.array(given["speeds"], dtype=float) * np.array(given["time"], dtype=float)
    return float(given.get("factor", 1.0)) * mean_force(turned / turned.sum(), np.array(given["forces"], dtype=float))


def loads(findings: Findings, study: Study) -> None:
    """Compute entries on mean forces, force and life of the halves of a preloaded nut, factors e, X, Y by angle."""
    for key, case in EXAMPLES.items():
        findings.number(key, mean_of_phases(case))
    findings.number("speed_rexroth", mean_speed("rexroth"))
    findings.number("parting", PARTING)
    force = np.linspace(0.0, PARTING, 50)
    loaded, other = forces_on_halves(force, 1.0)
    lower = error_percent((1.0 + force / ROUNDED) ** 1.5, loaded)
    words = (
        f"with 3 the loaded half's force is {-float(lower.min()):.1f} % lower where the halves part, and no higher anywhere"
    )
    holds = bool((lower <= 1e-9).all() and lower.min() >= -WITHIN and np.allclose(loaded - other, force))
    findings.claim("loaded_half", holds, words)
    scene = study.scene(SCENE)
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, FORCE)) for x in scene.loads))
    found = equivalent_life([nut], [1.0], [np.array([0.0, 0.0, FORCE])], PRELOAD)
    assert found is not None
    lives = (dynamic_rating(nut) / np.array(found.loads)) ** 3
    printed = float((lives ** (-10.0 / 9.0)).sum() ** -0.9)
    words = f"{found.revolutions:.4g} 10^6 revolutions, of {lives[0]:.4g} and {lives[1]:.4g}"
    findings.claim("combined_life", bool(np.isclose(found.revolutions, printed, rtol=1e-12)), words)
    for name, angle in (row.key.split("_") for row in load_table(findings.table) if row.key[0] in "eXY"):
        findings.number(f"{name}_{angle}", radial_and_axial_factors(float(np.radians(float(angle))))["eXY".index(name)])


#: Cells of CONTACT's grid along each axis, and its width over the contact's.
EXAMPLE_CELLS, EXAMPLE_MARGIN = 44, 1.1

#: Cells of its wheel, along and across.
WHEEL_CELLS = (48, 44)

#: Cells by which its ball rolls from rest here, of 28 along the contact: past the largest creepage. The example has 56.
ONSET_STEPS = 20


def ball_of_bearing(findings: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of one ball of NSK's screw-support bearing at the quoted load and contact angle."""
    parts = assembly("nsk-25bswz01").sets[0].parts
    assert isinstance(parts, Scene)
    d, steel, track = 2.0 * parts.balls.radius, parts.nut.material, parts.track
    grooves = (parts.screw.groove_radius / d, parts.nut.groove_radius / d)
    young, poisson = steel.youngs_modulus, steel.poissons_ratio
    bearing = bearing_of_contact_angle(1, d, 2.0 * track.pitch_radius, grooves, track.contact_angle, young, poisson)
    angle = np.arccos(inputs()["nsk"]["cosine"])
    findings.number("angle", float(np.degrees(angle)))
    modulus = contact_modulus(young, poisson, young, poisson)
    inner, outer = (hertz_constants(*pair, modulus) for pair in relative_curvatures(bearing, np.array(angle)))
    cube = float(np.cbrt(input_in_SI("nsk", "normal_load", "force")))
    findings.number("approach_outer", 1e6 * float(outer.C) * cube**2)
    findings.number("approach_inner", 1e6 * float(inner.C) * cube**2)
    findings.number("a_outer", 1e3 * float(outer.C_a) * cube)
    findings.number("b_outer", 1e3 * float(outer.C_b) * cube)


def sphere(findings: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of an elastic sphere on a rigid plane."""
    radius = input_in_SI("vm63", "radius", "length")
    modulus = input_in_SI("vm63", "youngs_modulus", "pressure") / (1.0 - inputs()["vm63"]["poissons_ratio"] ** 2)
    found = hertz_constants(np.array(1.0 / radius), np.array(1.0 / radius), modulus)
    findings.number("radius", 1e3 * float(found.C_a) * float(np.cbrt(input_in_SI("vm63", "force", "force"))))


def _example(case: str) -> tuple[float, tuple[float, float], float, float]:
    """Return the load [N], relative radii [m], Young's modulus [Pa] and Poisson's ratio of an example of CONTACT."""
    poisson, shear = inputs()[case]["poissons_ratio"], input_in_SI(case, "shear_modulus", "pressure")
    radii = (input_in_SI(case, "along", "length"), input_in_SI(case, "across", "length"))
    return input_in_SI(case, "force", "force"), radii, 2.0 * shear * (1.0 + poisson), poisson


def _hertz(case: str) -> tuple[float, HertzConstants]:
    """Return the load [N] and Hertz's constants of an example."""
    load, radii, young, poisson = _example(case)
    modulus = contact_modulus(young, poisson, young, poisson)
    return load, hertz_constants(np.array(1.0 / radii[0]), np.array(1.0 / radii[1]), modulus)


@dataclass(frozen=True)
class Example:
    """Computed results of CONTACT's rolling example."""

    #: Lateral force over mu P.
    lateral: float
    #: Moment [N mm].
    moment: float
    #: Number of cells in contact.
    cells: int
    #: Number of cells that stick.
    sticking: int
    #: Power of friction at 1 m/s [W].
    power: float


@lru_cache(maxsize=8)
def example(cells: int, *, by_cells: bool = False) -> Example:
    """Solve CONTACT's example on a grid of cells x cells; ``by_cells``: with CONTACT's difference scheme."""
    case, touch = inputs()["contact"], _example("contact")
    creep, mu = Creep(0.0, case["creep_across"], case["spin"]), case["friction"]
    if by_cells:
        found = steady_by_cells(hertz_patch(*touch, (cells, cells), margin=EXAMPLE_MARGIN), creep, mu)
    else:
        found = steady(hertz_patch(*touch, (cells, cells)), creep, mu)
    sticking = int(np.count_nonzero(found.friction.stick[0]))
    return Example(float(found.force[1]) / (mu * touch[0]), 1e3 * found.moment, len(found.patch.at), sticking, found.loss)


def rolling(findings: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of CONTACT's examples: steady rolling, a wheel, and transients.

    Steady rolling has lateral creepage and spin: the Hertz contact, then force and moment on half spaces.
    """
    load, hertz = _hertz("contact")
    cube = float(np.cbrt(load))
    findings.number("a", 1e3 * float(hertz.C_a) * cube)
    findings.number("b", 1e3 * float(hertz.C_b) * cube)
    findings.number("approach", 1e3 * float(hertz.C) * cube**2)
    findings.number("pressure", 1e-6 * float(hertz.pressure(np.array(load))))
    theirs, ours = example(EXAMPLE_CELLS, by_cells=True), example(EXAMPLE_CELLS)
    for key in ("lateral", "moment"):
        note = f"by CONTACT's differences over one cell; by those of rolling in 3D {getattr(ours, key):.4g}"
        findings.number(key, getattr(theirs, key), note)
    _wheel(findings)
    _transients(findings)


def _wheel(findings: Findings) -> None:
    """Compute the creep-force curve of a locomotive wheel with CONTACT's difference scheme.

    It is quick because most of the contact slips.
    """
    load, hertz = _hertz("wheel")
    cube, mu = float(np.cbrt(load)), float(inputs()["wheel"]["friction"])
    findings.number("wheel_a", 1e3 * float(hertz.C_b) * cube)
    findings.number("wheel_b", 1e3 * float(hertz.C_a) * cube)
    patch = hertz_patch(*_example("wheel"), WHEEL_CELLS, margin=EXAMPLE_MARGIN)
    for row in load_table(findings.table):
        curve, _, creep = row.key.rpartition("_")
        if curve == "wheel_creep":
            force = steady_by_cells(patch, Creep(float(creep), 0.0, 0.0), mu).force
            findings.number(row.key, float(force[0]) / (mu * load))


@lru_cache(maxsize=4)
def transient(case: str, steps: int) -> list[Onset]:
    """Solve a CONTACT example: a ball is pushed sideways, then rolls ``steps`` cells under that force."""
    numbers, (load, circle) = inputs()[case], _hertz(case)
    margin = 0.5 * input_in_SI(case, "grid", "length") / (float(circle.C_a) * float(np.cbrt(load)))
    patch = hertz_patch(*_example(case), (numbers["cells"], numbers["cells"]), margin=margin)
    return onset(patch, numbers["friction"], numbers["share"], steps)


def _transients(findings: Findings) -> None:
    """Compute the entries of the sideways push, and of the steps of one cell from there towards steady rolling."""
    found = {"cattaneo": transient("cattaneo", 0), "onset": transient("onset", ONSET_STEPS)}
    for row in load_table(findings.table):
        case, _, rest = row.key.partition("_")
        if case in found:
            what, _, step = rest.partition("_")
            one = found[case][int(step or 0)]
            value = {"shift": 1e3 * one.motion, "creep": one.motion, "sticking": float(one.sticking)}
            findings.number(row.key, value[what])


#: Sizes of THK and one of HIWIN: names of scenes after the prefix and the maker.
THK = ("bnf-4010-5", "bnf-4010-3p5", "bnf-3205-2p5", "bnf-3205-5", "bnf-3205-7p5")

HIWIN = ("hiwin-63-10k5",)

#: Scene of the double nut's single nut.
DOUBLE = "bnf-4010-5"

#: Shares of the rigidity of the contacts alone that an independent code found: lowest and highest, THK and HIWIN.
SHARES = {THK: (0.567, 0.586), HIWIN: (0.75, 0.75)}

#: What filling and pitch diameter, which are not printed, may change.
UNPRINTED = 0.05


def scene_name(size: str) -> str:
    """Name of the shipped scene of a size."""
    return f"{PREFIX}{size}" if size in HIWIN else f"{PREFIX}thk-{size}"


def rigidity_by_parts(scene: Scene, force: float) -> tuple[float, float]:
    """Return the axial rigidity [N/m] at an axial load [N]: of the contacts only, and of contacts and bodies.

    Raises ValueError without a wall.
    """
    alone, body = contacts_displacement(scene, force), body_compliance(scene)
    assert body is not None
    return force / alone, force / (alone + body * force)


def rigidity_unequal_loads(study: Study, name: str, model: str) -> float:
    """Return the axial rigidity [N/m] by a model in which ball loads may differ; zero if it did not converge."""
    scene, found = study.scene(name), study.solve(name, model)
    return axial_force(found) / axial_displacement(scene, found) if found.converged else 0.0


def nuts(findings: Findings, study: Study) -> None:
    """Compute the rigidities at 0.3 times the rating, their growth with the turns, the double nut, and the drag torque."""
    alone, bodies = {}, {}
    for size in (*THK, *HIWIN):
        scene = study.scene(scene_name(size))
        alone[size], bodies[size] = (1e-6 * x for x in rigidity_by_parts(scene, scene.loads[0].force[2]))
        printed = entry(findings.table, f"rigidity_{size}").value or 0.0
        share = printed / alone[size]
        words = f"catalogue {printed / bodies[size]:.3f} of it; contacts alone {alone[size]:.0f} N/um"
        findings.number(f"rigidity_{size}", bodies[size], words)
        low, high = next(ends for sizes, ends in SHARES.items() if size in sizes)
        words = f"{share:.3f} of {alone[size]:.0f} N/um"
        findings.claim(f"share_{size}", low * (1.0 - UNPRINTED) <= share <= high * (1.0 + UNPRINTED), words)
    for turns, size in (("5", "bnf-3205-5"), ("7p5", "bnf-3205-7p5")):
        findings.number(f"turns_{turns}", alone[size] / alone["bnf-3205-2p5"], "contacts alone")
    words = f"contacts alone {2.0**1.5 / 3.0 ** (1.0 / 3.0):.3f}"
    findings.number("double", double_over_single(study), f"with the bodies; {words}")
    _drag(study, findings)


def double_over_single(study: Study) -> float:
    """Return the rigidity of a double nut over that of a single nut, both with their bodies.

    The preload is a third of the single nut's load. The double nut carries the load that just unloads one of its
    nuts: it has then moved by the deflection of one nut under the preload.
    """
    scene = study.scene(scene_name(DOUBLE))
    full = scene.loads[0].force[2]
    preload = full / 3.0
    single = rigidity_by_parts(scene, full)[1]
    moved = preload / rigidity_by_parts(scene, preload)[1]

    def excess(force: float) -> float:
        return force / rigidity_by_parts(scene, force)[1] - 2.0 * moved

    unloads = float(brentq(excess, preload, 4.0 * preload, rtol=1e-6))
    return unloads / moved / single


def _drag(study: Study, findings: Findings) -> None:
    """Compute the preload drag torque by the maker's formula, and by sliding of the balls in both nuts."""
    case = inputs()["thk"]
    preload, lead, mu = (
        input_in_SI("thk", "preload", "force"),
        input_in_SI("thk", "lead", "length"),
        float(case["friction"]),
    )
    formula = 0.05 * case["tangent"] ** -0.5 * preload * lead / (2.0 * pi)
    findings.number("drag_formula", 1e3 * formula)
    torque = study.once(drag_torque, preload, mu)
    printed = entry(findings.table, "drag").value or 0.0
    words = (
        f"both nuts at a coefficient of {mu:g}, friction moving each ball across its grooves as in every scene that says "
        f"nothing else: {1e3 * torque / printed:.2f} times the printed torque"
    )
    findings.number("drag", 1e3 * torque, words)


def drag_torque(study: Study, preload: float, mu: float) -> float:
    """Return the friction torque [N m] of a double nut under a preload [N]: twice that of a single nut."""
    scene = study.scene(scene_name(DOUBLE))
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, preload)) for x in scene.loads))
    found = run_model(nut, "lin", Options(discretisation=False))
    return 2.0 * friction_state(nut, found, Friction(mu, mu), Motion(2.0 * pi)).torque.friction
