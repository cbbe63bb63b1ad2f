"""Export of a shaft with its bearings as a REXS model, with the results of one load case or several.

Components describe the arrangement as `rollbench.compare.scenes.from_rexs` reads it; load cases hold the results. The axes
u, v, w of REXS are z, x, y of a scene. A ball nut, for which REXS has no component, is written as the load that it exerts
on the shaft.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from math import degrees, pi
from typing import Any

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.models.answers import NutOrBearingResults
from rollbench.compare.models.load_cases import ShaftSolution
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.scenes.from_rexs import RIGID, SEAT
from rollbench.compare.scenes.rexs_model import STIFFNESS, RexsModel, Value, rexs_file_text
from rollbench.lowfi.rating.contacts import contact_pressures, race_pressures
from rollbench.lowfi.rating.iso_lives import ReferenceLife
from rollbench.lowfi.rating.life import is_thrust_bearing
from rollbench.lowfi.rating.roller_life import is_thrust_bearing_row as is_thrust_row
from rollbench.lowfi.rollers import slice_middles, tapered_bearing_of_row
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly, Housing, RollerRow, RollingSet
from rollbench.meshes.one_arc import internal_clearance
from rollbench.meshes.parts import Errors, Material, Scene

#: REXS name for the direction of the axial force on the inner ring that a bearing row supports, by the scene's name.
TAKES = {"+z": "positive", "-z": "negative", "both": "both_directions", "deep groove": "both_directions"}

#: Results of one load case: REXS attributes by the id of the component.
CaseAttributes = dict[int, dict[str, Value]]


class RexsWriter:
    """REXS model of a shaft with bearings while it is written, with the ids of components that other components refer to.

    ``model``: the REXS model; ``notes``: sentences on what the REXS model does not describe; ``unit``, ``casing`` and
    ``shaft``: ids of the gear unit, its casing and the shaft; ``steels``: id of each material.
    """

    def __init__(self, shaft: Assembly) -> None:
        """Begin the REXS model with gear unit, casing and shaft; ``shaft``: scene of the shaft with its bearings."""
        self.model, self.steels = RexsModel(), dict[Material, int]()
        self.notes: list[str] = []
        self.unit = self.model.add_component("gear_unit", shaft.title)
        self.casing = self.model.add_component("gear_casing", "casing")
        turns = shaft.motion is not None and shaft.motion.turns == "screw"
        speed = _revolutions_per_minute(shaft.motion.speed) if shaft.motion is not None and turns else None
        self.shaft = self.model.add_component(
            "shaft", shaft.name, **_position_attributes(0.0, self.unit), rotational_speed=speed
        )
        for part in (self.casing, self.shaft):
            self.model.add_relation("assembly", assembly=self.unit, part=part)
        self.assign_material(self.shaft, shaft.screw.material)
        #: Names of the housings in which an outer ring can slide.
        self.sliding_housings = {h.name for h in shaft.housings if _is_unloaded_sliding_housing(h)}
        #: For each bearing row: id of the bearing, and for each rolling element the ids of its contacts.
        self.rows: list[tuple[int, list[list[int]]]] = []

    def assign_material(self, part: int, material: Material) -> None:
        """Assign a material to the REXS component with the id ``part``; a new material is first added to the model."""
        if material not in self.steels:
            constants = {"elastic_modulus": 1e-6 * material.youngs_modulus, "poisson_ratio": material.poissons_ratio}
            self.steels[material] = self.model.add_component("material", f"material {len(self.steels) + 1}", **constants)
        self.model.add_relation("reference", origin=part, referenced=self.steels[material])

    def add_component_as_part(
        self, whole: int, type: str, name: str = "", order: int | None = None, **attributes: Value | None
    ) -> int:
        """Add a component to the REXS model as a part of another component, and return its id.

        ``whole``: id of the other component; ``type`` and ``name``: REXS type and name of the new one; ``order``: its
        number among the parts of the other component, None without numbers; ``attributes``: its REXS attributes in their
        REXS units.
        """
        k = self.model.add_component(type, name, **attributes)
        self.model.add_relation("assembly" if order is None else "ordered_assembly", order, assembly=whole, part=k)
        return k


def _is_unloaded_sliding_housing(housing: Housing) -> bool:
    """Return whether a housing can only slide along the shaft, and no load acts on it."""
    held = housing.fixed == tuple((name, 0.0) for name in SEAT)
    return held and housing.stiffness is None and not any((*housing.force, *housing.moment))


def _revolutions_per_minute(speed: float) -> float:
    """Return a speed [rad/s] in revolutions per minute."""
    return speed * 30.0 / pi


def _position_attributes(z: float, gear_unit: int) -> dict[str, Value]:
    """Return the REXS attributes that state a component's position on the shaft, in the coordinates of the gear unit.

    ``z``: position along the shaft [m]; ``gear_unit``: id of the gear unit.
    """
    vectors: dict[str, Value] = {"support_vector": (1e3 * z, 0.0, 0.0), "u_axis_vector": (1.0, 0.0, 0.0)}
    return vectors | {"w_axis_vector": (0.0, 0.0, 1.0), "reference_component_for_position": gear_unit}


def rexs_file_with_results(described: Assembly | DutyCycle, solved: Sequence[ShaftSolution]) -> tuple[str, list[str]]:
    """Return the text of a REXS file with a shaft, its bearings and the results.

    Parameters
    ----------
    described
        Scene of a shaft, or duty cycle of load cases on a shaft.
    solved
        Converged solution of the shaft, or of each load case in order.

    Returns
    -------
    str
        XML text of the file.
    list of str
        Sentences on what the file does not hold.

    Raises
    ------
    SceneNotCoveredError
        For supports that REXS cannot describe.
    """
    shaft = described.parts if isinstance(described, DutyCycle) else described
    assert isinstance(shaft, Assembly)
    writer = RexsWriter(shaft)
    _write_shaft_sections(writer, shaft)
    for row in shaft.sets:
        if isinstance(row.parts, RollerRow):
            writer.rows.append(_write_roller_bearing(writer, row, row.parts))
        elif not row.parts.track.lead:
            writer.rows.append(_write_ball_bearing(writer, row, row.parts))
    if shaft.lubricant is not None:
        for bearing, _ in writer.rows:
            writer.model.components[bearing].attributes["operating_viscosity"] = 1e6 * shaft.lubricant.viscosity
    _write_supports(writer, shaft)
    loads = _write_loads(writer, shaft, solved)
    cases = described.cases if isinstance(described, DutyCycle) else ()
    for k, (one, acting) in enumerate(zip(solved, loads, strict=True)):
        case, speed = CaseAttributes(), None
        if cases:
            of, speed = cases[k], cases[k].speed
            part = of.share if of.time is None else of.time / sum(x.time or 0.0 for x in cases)
            case = {writer.unit: {"operating_time_fraction": 100.0 * part}, **acting}
        writer.model.load_cases.append(case | _attributes_of_load_case_results(writer, one, speed))
    _note_omitted_features(writer, shaft)
    return rexs_file_text(writer.model, __version__, datetime.now(UTC).isoformat(timespec="seconds")), writer.notes


def _write_shaft_sections(writer: RexsWriter, shaft: Assembly) -> None:
    """Add the sections of the shaft to the REXS model as cylinders.

    The thread, and gaps between plain sections, become cylinders with the outer diameter of the screw.
    """
    screw = shaft.screw
    plain = sorted((p.start, p.end, p.diameter, p.bore) for p in shaft.segments)
    ends = [0.0, *(p[1] for p in plain)]
    gaps = zip(ends, [*(p[0] for p in plain), screw.length], strict=True)
    rest = [(a, b, screw.outer_diameter, screw.bore) for a, b in gaps if b - a > 1e-9]
    for start, end, diameter, bore in sorted([*plain, *rest]):
        at = 1e3 * start
        section: dict[str, Any] = {"u_coordinate_on_shaft": at, "length": 1e3 * end - at}
        for side, size in (("outer", diameter), ("inner", bore)):
            section |= {f"{side}_diameter_begin": 1e3 * size, f"{side}_diameter_end": 1e3 * size}
        writer.add_component_as_part(writer.shaft, "shaft_section", **section)
    if rest and any(isinstance(s.parts, Scene) and s.parts.track.lead for s in shaft.sets):
        writer.notes.append("the thread is written as a cylinder of its outer diameter")


def _write_single_row_bearing(writer: RexsWriter, row: RollingSet, bearing_type: str, **attributes: Value | None) -> int:
    """Add a single-row bearing between shaft and casing to the REXS model, and return its id.

    ``row``: row of the shaft scene; ``bearing_type``: REXS type of the bearing; ``attributes``: further REXS attributes in
    their REXS units.
    """
    at, shift = 1e3 * row.position, 1e6 * row.offset * (-1.0 if row.thrust == "+z" else 1.0)
    common: dict[str, Value | None] = {
        "bearing_type": bearing_type,
        "number_of_bearing_rows": 1,
        "axial_force_absorption": "no_direction" if row.housing in writer.sliding_housings else TAKES[row.thrust],
        "radial_force_absorption": True,
        "u_coordinate_on_shaft_inner_side": at,
        "u_coordinate_on_shaft_outer_side": at,
        "preload_distance": shift or None,
        "preload_force": row.preload or None,
    }
    where = _position_attributes(row.position, writer.unit)
    bearing = writer.model.add_component(
        "rolling_bearing_with_detailed_geometry", row.name, **common, **attributes, **where
    )
    writer.model.add_relation("side", assembly=bearing, inner_part=writer.shaft, outer_part=writer.casing)
    return bearing


def _write_rolling_elements(
    writer: RexsWriter,
    row_id: int,
    azimuths: Iterable[float],
    contact_types: Sequence[str],
    material: Material,
    **size: Value | None,
) -> list[list[int]]:
    """Add balls or rollers of a bearing row and their contacts to the REXS model; return the contact ids of each element.

    ``row_id``: id of the bearing row; ``azimuths``: azimuths of the elements [rad]; ``contact_types``: REXS types of the
    contacts of an element; ``material``: material of the elements; ``size``: REXS attributes of an element's size in mm and
    degrees.
    """
    found = []
    for k, azimuth in enumerate(azimuths, 1):
        at: dict[str, Value] = {"angular_position_around_u": degrees(azimuth)}
        one = writer.add_component_as_part(row_id, "rolling_element", str(k), k, **size, **at)
        writer.assign_material(one, material)
        contact = "rolling_element_contact"
        found.append(
            [writer.add_component_as_part(one, contact, rolling_element_contact_type=kind) for kind in contact_types]
        )
    return found


def _write_ball_bearing(writer: RexsWriter, placed_row: RollingSet, parts: Scene) -> tuple[int, list[list[int]]]:
    """Add a ball bearing to the REXS model; return its id, then for each ball the ids of its contacts.

    ``placed_row``: row of the shaft with its position; ``parts``: rings and balls of this row.
    """
    nut, pitch, found = parts.nut, 2e3 * parts.track.pitch_radius, internal_clearance(parts)
    thrust = "axial_" if is_thrust_bearing(parts) else ""
    kind = {"deep groove": "radial_grooved_ball_bearing", "both": f"{thrust}four_point_contact_ball_bearing"}
    size: dict[str, Value | None] = {"width": 1e3 * nut.length, "outer_diameter": 1e3 * nut.outer_diameter}
    if placed_row.thrust == "deep groove" and found is not None:
        size["operating_radial_bearing_clearance"] = 1e6 * found.radial
    bearing = _write_single_row_bearing(
        writer, placed_row, kind.get(placed_row.thrust, f"{thrust}angular_contact_ball_bearing"), **size
    )
    for ring, outer, material in (
        ("inner_ring", parts.screw.outer_diameter, parts.screw.material),
        ("outer_ring", nut.outer_diameter, nut.material),
    ):
        one = writer.add_component_as_part(
            bearing, "bearing_ring", ring, bearing_ring_type=ring, outer_diameter=1e3 * outer
        )
        writer.assign_material(one, material)
    of_row: dict[str, Value | None] = {
        "number_of_rolling_elements": parts.ball_count,
        "axial_force_absorption_of_row": TAKES[placed_row.thrust],
        "pressure_angle": degrees(parts.track.contact_angle),
        "reference_diameter": pitch,
        "raceway_radius_of_inner_ring": 1e3 * parts.screw.groove_radius,
        "raceway_radius_of_outer_ring": 1e3 * nut.groove_radius,
    }
    k, balls = writer.add_component_as_part(bearing, "rolling_bearing_row", placed_row.name, 1, **of_row), parts.balls
    sides = ("left_", "right_") if placed_row.thrust == "both" else ("",)
    kinds = [f"{side}{race}_raceway_contact" for race in ("inner", "outer") for side in sides]
    diameter = 2e3 * balls.radius
    return bearing, _write_rolling_elements(
        writer, k, balls.azimuths, kinds, balls.material, diameter_of_rolling_element=diameter
    )


def _write_roller_bearing(writer: RexsWriter, placed_row: RollingSet, parts: RollerRow) -> tuple[int, list[list[int]]]:
    """Add a tapered roller bearing to the REXS model; return its id, then for each roller the ids of its contacts.

    ``placed_row``: row of the shaft with its position; ``parts``: rings and rollers of this row.
    """
    kind = f"{'axial' if is_thrust_row(parts) else 'radial'}_tapered_roller_bearing"
    bearing = _write_single_row_bearing(writer, placed_row, kind)
    of_row: dict[str, Value | None] = {
        "number_of_rolling_elements": parts.count,
        "axial_force_absorption_of_row": TAKES[placed_row.thrust],
        "pressure_angle": degrees(parts.cup_angle),
        "reference_diameter": 1e3 * tapered_bearing_of_row(parts).pitch_diameter,
    }
    k = writer.add_component_as_part(bearing, "rolling_bearing_row", placed_row.name, 1, **of_row)
    crown = None if np.isinf(parts.crown) else 1e3 * parts.crown
    size: dict[str, Value | None] = {
        "diameter_of_rolling_element": 1e3 * parts.diameter,
        "length_of_rolling_element": 1e3 * parts.length,
        "roller_angle": degrees(parts.roller_angle),
        "roller_crowning_radius": crown,
    }
    azimuths = [parts.phase + 2.0 * pi * j / parts.count for j in range(parts.count)]
    kinds = ("inner_raceway_contact", "outer_raceway_contact")
    writer.notes.append(f"{placed_row.name}: the depth of the rings, {1e3 * parts.depth:g} mm, and what describes the rib")
    return bearing, _write_rolling_elements(writer, k, azimuths, kinds, parts.material, **size)


def _write_supports(writer: RexsWriter, shaft: Assembly) -> None:
    """Add the supports of the shaft to the REXS model as rigid concept bearings (REXS bearings without geometry).

    The drive, which prevents the rotation about the axis, is left out.

    Raises SceneNotCoveredError for supports that a concept bearing cannot describe.
    """
    for s in shaft.supports:
        fixed = {name for name, value in s.fixed if value == 0.0}
        across, tilt = fixed & {"ux", "uy"}, fixed & {"rx", "ry"}
        if fixed != {name for name, _ in s.fixed} or len(across) == 1 or len(tilt) == 1:
            names = ", ".join(name for name, _ in s.fixed)
            reason = f"REXS has no component for a support at {1e3 * s.at:g} mm that fixes {names}"
            advice = "fix ux together with uy, rx together with ry, all at zero, or model the support by bearings"
            raise SceneNotCoveredError(shaft.name, "supports", reason, advice)
        if fixed - {"rz"}:
            axial = "both_directions" if "uz" in fixed else "no_direction"
            at: dict[str, Value] = {"u_coordinate_on_shaft_inner_side": 1e3 * s.at, "axial_force_absorption": axial}
            at |= {"bending_stiffness": RIGID} if tilt else {}
            k = writer.model.add_component("concept_bearing", "support", radial_force_absorption=bool(across), **at)
            writer.model.add_relation("side", assembly=k, inner_part=writer.shaft, outer_part=writer.casing)


def _write_loads(writer: RexsWriter, shaft: Assembly, solved: Sequence[ShaftSolution]) -> list[CaseAttributes]:
    """Add the external loads and the forces of ball nuts on the shaft to the REXS model, as components of the shaft.

    Returns, for each load case, the force and moment of each of these components as REXS attributes, by id of the
    component. With a single load case, the attributes are also written to the components. ``solved``: solution of each
    load case.
    """
    names, acting = list[tuple[str, float]](), list[dict[tuple[str, float], np.ndarray]]()
    for one in solved:
        found = dict[tuple[str, float], np.ndarray]()
        for x in one.scene.loads:
            same = sum(at == x.at for _, at in found)
            found[f"load {same + 1}", x.at] = np.array([*x.force, *x.moment])
        for nut in one.result.sets:
            if isinstance(nut.of.parts, Scene) and nut.of.parts.track.lead:
                found[nut.of.name, nut.of.position] = np.array([*nut.force, *nut.moment])
        names += [x for x in found if x not in names]
        acting.append(found)
    ids = {}
    for name, at in names:
        ids[name, at] = writer.add_component_as_part(writer.shaft, "external_load", name, u_coordinate_on_shaft=1e3 * at)
    cases = [{ids[x]: _force_and_moment_attributes(found.get(x, np.zeros(6))) for x in names} for found in acting]
    if len(solved) == 1:
        for k, attributes in cases[0].items():
            writer.model.components[k].attributes |= attributes
    for s in shaft.sets:
        if isinstance(s.parts, Scene) and s.parts.track.lead:
            text = "a ball nut, for which REXS has no component, is written as its load on the shaft"
            writer.notes.append(f"{s.name}: {text}")
    return cases


def _force_and_moment_attributes(load: np.ndarray) -> dict[str, Value]:
    """Return a force and moment as REXS attributes; moments of zero are left out.

    ``load``: force along x, y, z [N] and moment about x, y, z [N m], (6,).
    """
    force = {f"force_{axis}_direction": float(F) for axis, F in zip("vwu", load[:3], strict=True)}
    moment = {f"torque_around_{axis}_axis": float(M) for axis, M in zip("vwu", load[3:], strict=True) if M}
    return {**force, **moment}


def _attributes_of_load_case_results(writer: RexsWriter, solution: ShaftSolution, speed: float | None) -> CaseAttributes:
    """Return the results of one load case as REXS attributes of shaft, bearings and contacts, by id of the component.

    ``solution``: solution of the load case; ``speed``: speed of the shaft in the load case [rad/s], None for that of the
    scene.
    """
    result, motion = solution.result, solution.scene.motion
    assert solution.derived_results is not None
    place: dict[str, Value] = {"u_coordinates_of_beam_nodes": tuple(1e3 * result.centreline_z)}
    moved = {f"displacement_{axis}_of_nodes": tuple(1e6 * result.centreline[:, i]) for i, axis in enumerate("vwu")}
    case: CaseAttributes = {writer.shaft: {**place, **moved}}
    if speed is not None:
        case[writer.shaft]["rotational_speed"] = _revolutions_per_minute(speed)
    turning = speed if speed is not None else None if motion is None else motion.speed
    pairs = zip(result.sets, solution.derived_results.set_results, strict=True)
    bearings = [(s, x) for s, x in pairs if isinstance(s.of.parts, RollerRow) or not s.of.parts.track.lead]
    for (bearing, contacts), (s, answers) in zip(writer.rows, bearings, strict=True):
        case[bearing] = _bearing_result_attributes(result, s, answers, turning)
        if isinstance(s.of.parts, RollerRow):
            case |= _roller_contact_result_attributes(contacts, s, s.of.parts)
        else:
            case |= _ball_contact_result_attributes(contacts, s)
    return case


def _bearing_result_attributes(
    result: AxisResult, bearing: SetResult, answers: NutOrBearingResults, speed: float | None
) -> dict[str, Value]:
    """Return forces, deflections, stiffness, ratings and life of one bearing as REXS attributes.

    ``result``: solution of the shaft; ``bearing``: solution of the bearing in it; ``answers``: ratings, pressures and life
    of the bearing; ``speed``: speed of the shaft [rad/s] for the life in hours, None if it is not known.
    """
    at = [float(np.interp(bearing.of.position, result.centreline_z, x)) for x in result.centreline.T]
    relative = np.array(at) - bearing.outer
    relative[2] += bearing.of.offset
    forces = {f"force_acting_on_inner_component_{axis}": float(F) for axis, F in zip("vwu", bearing.force, strict=True)}
    found: dict[str, Value] = {
        **forces,
        **{f"torque_acting_on_inner_component_{axis}": float(M) for axis, M in zip("vw", bearing.moment[:2], strict=True)},
        "radial_deflection_in_v": 1e6 * float(relative[0]),
        "radial_deflection_in_w": 1e6 * float(relative[1]),
        "axial_deflection": 1e6 * float(relative[2]),
        "angular_deflection_in_v": float(relative[3]),
        "angular_deflection_in_w": float(relative[4]),
    }
    stiffness = np.asarray(bearing.stiffness)
    found |= {
        name: float(stiffness[i, j]) / si for (i, j), (name, _, si) in STIFFNESS.items() if np.isfinite(stiffness[i, j])
    }
    loads = answers.load_results
    if loads.worst_contact is not None and loads.safety is not None:
        found["maximum_hertzian_pressure"] = 1e-6 * loads.worst_contact.pressure
        found["static_load_safety"] = loads.safety.factor
    if loads.ratings is not None:
        way = "axial" if loads.ratings.is_axial else "radial"
        found[f"{way}_dynamic_load_rating"] = 1e-3 * loads.ratings.dynamic
        found[f"{way}_static_load_rating"] = 1e-3 * loads.ratings.static
    return found | _life_attributes(loads.reference, speed)


def _life_attributes(life: ReferenceLife | None, speed: float | None) -> dict[str, Value]:
    """Return the rating life by ISO/TS 16281 as REXS attributes, also in hours if a speed is given.

    ``life``: rating life, None if it cannot be computed; ``speed``: speed of the shaft [rad/s], None if it is not known.
    """
    if life is None:
        return {}
    name = "nominal_reference_rating_life"
    found: dict[str, Value] = {f"{name}_rotations_iso_16281_2008": life.revolutions}
    if speed:
        found[f"{name}_time_iso_16281_2008"] = 1e6 * life.revolutions * 2.0 * pi / abs(speed) / 3600.0
    return found | {"dynamic_equivalent_reference_bearing_load_iso_16281_2008": life.equivalent}


def _ball_contact_result_attributes(contact_ids: list[list[int]], bearing_result: SetResult) -> CaseAttributes:
    """Return force, contact angle and pressure of each ball contact as REXS attributes.

    ``contact_ids``: for each ball the ids of its contacts; ``bearing_result``: solution of the bearing. A groove of a
    single arc has one contact in REXS but two flanks in the scene: the flank with the larger load is taken.
    """
    assert bearing_result.balls is not None
    assert isinstance(bearing_result.of.parts, Scene)
    load, angle = bearing_result.balls.load, np.degrees(bearing_result.balls.contact_angle)
    pressure = contact_pressures(bearing_result.of.parts, bearing_result.balls)
    case: CaseAttributes = {}
    for i, ids in enumerate(contact_ids):
        flanks = [(2 * k, 2 * k + 1) for k in range(2)] if len(ids) == 2 else [(k,) for k in range(4)]
        for k, of in zip(ids, flanks, strict=True):
            j = max(of, key=lambda flank: load[i, flank])
            case[k] = {"rolling_element_force": 1e-3 * float(load[i, j])}
            if load[i, j] > 0.0:
                case[k]["operating_pressure_angle"] = float(angle[i, j])
                case[k]["maximum_hertzian_pressure"] = 1e-6 * float(pressure[i, j])
    return case


def _roller_contact_result_attributes(contact_ids: list[list[int]], bearing: SetResult, row: RollerRow) -> CaseAttributes:
    """Return force, lamina (slice) loads and largest pressure of each roller contact as REXS attributes.

    ``contact_ids``: for each roller the ids of its contacts; ``bearing``: solution of the bearing; ``row``: its rollers.
    """
    assert bearing.line_loads is not None
    assert bearing.roller_load is not None
    places = tuple(1e3 * slice_middles(row.length, row.slices))
    pressure, width = 1e-6 * race_pressures(row, bearing.line_loads), row.length / row.slices
    return {
        k: {
            "rolling_element_force": 1e-3 * float(bearing.roller_load[i]),
            "rolling_element_coordinate": places,
            "rolling_element_lamina_load": tuple(width * bearing.line_loads[i]),
            "maximum_hertzian_pressure": float(pressure[i, race]),
        }
        for i, ids in enumerate(contact_ids)
        for race, k in enumerate(ids)
    }


def _note_omitted_features(writer: RexsWriter, shaft: Assembly) -> None:
    """Add sentences to the notes of ``writer`` on what the REXS file does not describe of the scene ``shaft``."""
    moving = [h.name for h in shaft.housings if not h.is_fixed and h.name not in writer.sliding_housings]
    if moving:
        writer.notes.append(f"{', '.join(moving)}: a housing that moves is written as a casing at rest")
    if any(s.carrier for s in shaft.sets):
        writer.notes.append("bearings around a nut are written as bearings of the shaft")
    wrong = [s.name for s in shaft.sets if isinstance(s.parts, Scene) and replace(s.parts.errors, seed=0) != Errors()]
    if wrong:
        writer.notes.append(f"{', '.join(wrong)}: geometric errors of grooves and balls")
    if shaft.thermal_strain:
        writer.notes.append("the thermal expansion of the shaft")
