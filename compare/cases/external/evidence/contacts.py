"""Single contacts of other programs: Hertz's constants, and rolling with creepage and spin on half spaces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.compare.cases.external.evidence.case import assembly, given, inputs
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import load_table
from rollbench.hifi.rolling.patch import hertz_patch
from rollbench.hifi.rolling.verification import Creep, Onset, onset, steady, steady_by_cells
from rollbench.lowfi.bearings.angular_contact import curvatures, of_angle
from rollbench.lowfi.hertz import HertzConstants, contact_modulus, hertz_constants
from rollbench.meshes.parts import Scene

#: Cells of CONTACT's grid along each axis, and its width over the contact's.
EXAMPLE_CELLS, EXAMPLE_MARGIN = 44, 1.1
#: Cells of its wheel, along and across.
WHEEL_CELLS = (48, 44)
#: Cells by which its ball rolls from rest here, of 28 along the contact: past the largest creepage. The example has 56.
ONSET_STEPS = 20


def ball_of_bearing(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """One ball of NSK's screw-support bearing at the quoted load and contact angle."""
    parts = assembly("nsk-25bswz01").sets[0].parts
    assert isinstance(parts, Scene)
    d, steel, track = 2.0 * parts.balls.radius, parts.nut.material, parts.track
    grooves = (parts.screw.groove_radius / d, parts.nut.groove_radius / d)
    young, poisson = steel.youngs_modulus, steel.poissons_ratio
    bearing = of_angle(1, d, 2.0 * track.pitch_radius, grooves, track.contact_angle, young, poisson)
    angle = np.arccos(inputs()["nsk"]["cosine"])
    sheet.number("angle", float(np.degrees(angle)))
    modulus = contact_modulus(young, poisson, young, poisson)
    inner, outer = (hertz_constants(*pair, modulus) for pair in curvatures(bearing, np.array(angle)))
    cube = float(np.cbrt(given("nsk", "normal_load", "force")))
    sheet.number("approach_outer", 1e6 * float(outer.C) * cube**2)
    sheet.number("approach_inner", 1e6 * float(inner.C) * cube**2)
    sheet.number("a_outer", 1e3 * float(outer.C_a) * cube)
    sheet.number("b_outer", 1e3 * float(outer.C_b) * cube)


def sphere(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Elastic sphere on a rigid plane."""
    radius = given("vm63", "radius", "length")
    modulus = given("vm63", "youngs_modulus", "pressure") / (1.0 - inputs()["vm63"]["poissons_ratio"] ** 2)
    found = hertz_constants(np.array(1.0 / radius), np.array(1.0 / radius), modulus)
    sheet.number("radius", 1e3 * float(found.C_a) * float(np.cbrt(given("vm63", "force", "force"))))


def _example(case: str) -> tuple[float, tuple[float, float], float, float]:
    """Load [N], relative radii [m], Young's modulus [Pa] and Poisson's ratio of an example of CONTACT."""
    poisson, shear = inputs()[case]["poissons_ratio"], given(case, "shear_modulus", "pressure")
    radii = (given(case, "along", "length"), given(case, "across", "length"))
    return given(case, "force", "force"), radii, 2.0 * shear * (1.0 + poisson), poisson


def _hertz(case: str) -> tuple[float, HertzConstants]:
    """Load [N] and Hertz's constants of an example."""
    load, radii, young, poisson = _example(case)
    modulus = contact_modulus(young, poisson, young, poisson)
    return load, hertz_constants(np.array(1.0 / radii[0]), np.array(1.0 / radii[1]), modulus)


@dataclass(frozen=True)
class Example:
    """CONTACT's example as computed: lateral force over mu P and moment [N mm]; cells in contact, and of them those that
    stick; power of friction at 1 m/s [W]."""

    lateral: float
    moment: float
    cells: int
    sticking: int
    power: float


@lru_cache(maxsize=8)
def example(cells: int, *, by_cells: bool = False) -> Example:
    """CONTACT's example on a grid of so many cells along each axis; by_cells: discretised as by CONTACT."""
    case, touch = inputs()["contact"], _example("contact")
    creep, mu = Creep(0.0, case["creep_across"], case["spin"]), case["friction"]
    if by_cells:
        found = steady_by_cells(hertz_patch(*touch, (cells, cells), margin=EXAMPLE_MARGIN), creep, mu)
    else:
        found = steady(hertz_patch(*touch, (cells, cells)), creep, mu)
    sticking = int(np.count_nonzero(found.friction.stick[0]))
    return Example(float(found.force[1]) / (mu * touch[0]), 1e3 * found.moment, len(found.patch.at), sticking, found.loss)


def rolling(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """CONTACT's example with lateral creepage and spin: Hertz's part, and the force and moment of exact half spaces."""
    load, hertz = _hertz("contact")
    cube = float(np.cbrt(load))
    sheet.number("a", 1e3 * float(hertz.C_a) * cube)
    sheet.number("b", 1e3 * float(hertz.C_b) * cube)
    sheet.number("approach", 1e3 * float(hertz.C) * cube**2)
    sheet.number("pressure", 1e-6 * float(hertz.pressure(np.array(load))))
    theirs, ours = example(EXAMPLE_CELLS, by_cells=True), example(EXAMPLE_CELLS)
    for key in ("lateral", "moment"):
        note = f"by CONTACT's differences over one cell; by those of rolling in 3D {getattr(ours, key):.4g}"
        sheet.number(key, getattr(theirs, key), note)
    _wheel(sheet)
    _transients(sheet)


def _wheel(sheet: Sheet) -> None:
    """Creep-force curve of a locomotive wheel by CONTACT's differences, where most of the contact slips: that is quick."""
    load, hertz = _hertz("wheel")
    cube, mu = float(np.cbrt(load)), float(inputs()["wheel"]["friction"])
    sheet.number("wheel_a", 1e3 * float(hertz.C_b) * cube)
    sheet.number("wheel_b", 1e3 * float(hertz.C_a) * cube)
    patch = hertz_patch(*_example("wheel"), WHEEL_CELLS, margin=EXAMPLE_MARGIN)
    for row in load_table(sheet.table):
        curve, _, creep = row.key.rpartition("_")
        if curve == "wheel_creep":
            force = steady_by_cells(patch, Creep(float(creep), 0.0, 0.0), mu).force
            sheet.number(row.key, float(force[0]) / (mu * load))


@lru_cache(maxsize=4)
def transient(case: str, steps: int) -> list[Onset]:
    """CONTACT's example of a ball that is pushed aside, and then rolls by so many cells under that force."""
    numbers, (load, circle) = inputs()[case], _hertz(case)
    margin = 0.5 * given(case, "grid", "length") / (float(circle.C_a) * float(np.cbrt(load)))
    patch = hertz_patch(*_example(case), (numbers["cells"], numbers["cells"]), margin=margin)
    return onset(patch, numbers["friction"], numbers["share"], steps)


def _transients(sheet: Sheet) -> None:
    """A push aside, and the way from there to steady rolling, cell by cell as CONTACT takes it."""
    found = {"cattaneo": transient("cattaneo", 0), "onset": transient("onset", ONSET_STEPS)}
    for row in load_table(sheet.table):
        case, _, rest = row.key.partition("_")
        if case in found:
            what, _, step = rest.partition("_")
            one = found[case][int(step or 0)]
            value = {"shift": 1e3 * one.motion, "creep": one.motion, "sticking": float(one.sticking)}
            sheet.number(row.key, value[what])
