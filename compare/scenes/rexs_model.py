"""Reading and writing of REXS 1.7 (rexs.info), an open XML format for drive trains: components, relations, load cases.

Names of components, attributes, roles and units are those of FVA's schema of version 1.7 (``rexs_schema_1.7.xml`` and
``rexs-file.xsd`` in github.com/fva-net/rexs-api-java). This program reads and writes only the attributes in `UNITS`.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from rollbench.compare.errors import InputError
from rollbench.compare.scenes.scene_file import read_scene_text

#: Version of REXS that is read and written.
VERSION = "1.7"

#: Value of an attribute: a word, a number, true or false, or a list of numbers.
Value: TypeAlias = "str | float | bool | tuple[float, ...]"

#: Unit of each attribute as in the REXS schema; "none" for words, counts and factors.
UNITS = {
    name: unit
    for unit, names in {
        "none": "axial_force_absorption axial_force_absorption_of_row radial_force_absorption bearing_type "
        "number_of_bearing_rows number_of_rolling_elements bearing_ring_type level_of_detail material_designation "
        "poisson_ratio defines_speed transmits_torque reference_component_for_position rolling_element_contact_type "
        "static_load_safety model_name kind",
        "mm": "u_coordinate_on_shaft u_coordinate_on_shaft_inner_side u_coordinate_on_shaft_outer_side inner_diameter "
        "outer_diameter width length inner_diameter_begin inner_diameter_end outer_diameter_begin outer_diameter_end "
        "reference_diameter raceway_radius_of_inner_ring raceway_radius_of_outer_ring diameter_of_rolling_element "
        "length_of_rolling_element roller_crowning_radius distance_between_bearing_rows u_axis_vector w_axis_vector "
        "support_vector u_coordinates_of_beam_nodes half_length_of_contact_area half_width_of_contact_area "
        "rolling_element_coordinate",
        "mum": "operating_radial_bearing_clearance mounted_radial_bearing_clearance radial_bearing_clearance "
        "preload_distance axial_deflection radial_deflection_in_v radial_deflection_in_w displacement_u_of_nodes "
        "displacement_v_of_nodes displacement_w_of_nodes",
        "deg": "pressure_angle angular_position_around_u roller_angle operating_pressure_angle",
        "rad": "angular_deflection_in_v angular_deflection_in_w",
        "N": "force_u_direction force_v_direction force_w_direction preload_force force_acting_on_inner_component_u "
        "force_acting_on_inner_component_v force_acting_on_inner_component_w rolling_element_lamina_load "
        "dynamic_equivalent_reference_bearing_load_iso_16281_2008",
        "N m": "torque_around_u_axis torque_around_v_axis torque_around_w_axis torque_acting_on_inner_component_v "
        "torque_acting_on_inner_component_w",
        "kN": "rolling_element_force radial_dynamic_load_rating radial_static_load_rating axial_dynamic_load_rating "
        "axial_static_load_rating",
        "N / mm^2": "elastic_modulus maximum_hertzian_pressure maximum_hertzian_pressure_inner_ring "
        "maximum_hertzian_pressure_outer_ring",
        "1 / min": "rotational_speed",
        "mm^2 / s": "operating_viscosity",
        "%": "operating_time_fraction",
        "N mm / rad": "bending_stiffness",
        "MRev": "nominal_reference_rating_life_rotations_iso_16281_2008",
        "h": "nominal_reference_rating_life_time_iso_16281_2008",
    }.items()
    for name in names.split()
}
#: Tangent stiffness of a bearing: for each row and column of the matrix, the attribute, its unit, and this unit in SI.
STIFFNESS = {
    (i, j): (f"operating_point_stiffness_{row}_{column}", *unit)
    for i, row in enumerate(("f_v", "f_w", "f_u", "m_v", "m_w"))
    for j, column in enumerate(("d_v", "d_w", "d_u", "rot_v", "rot_w"))
    for unit in [((("N / m", 1.0), ("N / rad", 1.0)), (("N", 1.0), ("N mm / rad", 1e-3)))[i > 2][j > 2]]
}
UNITS |= {name: unit for name, unit, _ in STIFFNESS.values()}


@dataclass
class RexsComponent:
    """Component of a REXS model, such as a shaft, bearing or load: id, type, name, and attributes in the units of REXS."""

    #: Number that identifies the component in the file.
    id: int
    #: REXS type of the component, such as "shaft".
    type: str
    #: Name of the component; may be empty.
    name: str = ""
    #: Values of the attributes in the units of REXS, by name.
    attributes: dict[str, Value] = field(default_factory=dict)

    def number(self, attribute: str) -> float | None:
        """Return the value of an attribute as a number; None if it is missing or not a number."""
        value = self.attributes.get(attribute)
        try:
            return None if value is None or isinstance(value, (bool, tuple)) else float(value)
        except ValueError:
            return None

    def word(self, attribute: str) -> str:
        """Return the value of an attribute that is a word; empty if it is missing or not a word."""
        value = self.attributes.get(attribute, "")
        return value if isinstance(value, str) else ""


@dataclass(frozen=True)
class RexsRelation:
    """Relation between components of a REXS model, such as a bearing with its inner and outer part."""

    #: REXS type of the relation.
    type: str
    #: Id of the component in each role, by the name of the role.
    roles: dict[str, int]
    #: Position of a part among the other parts of the same component, from 1; None if the file states none.
    order: int | None = None


@dataclass
class RexsModel:
    """Contents of a REXS file: components of a drive train, their relations, and load cases."""

    #: Components by their ids.
    components: dict[int, RexsComponent] = field(default_factory=dict)
    #: Relations between the components.
    relations: list[RexsRelation] = field(default_factory=list)
    #: For each load case, the attributes that it states, by the ids of the components.
    load_cases: list[dict[int, dict[str, Value]]] = field(default_factory=list)

    def add_component(self, type: str, name: str = "", **attributes: Value | None) -> int:
        """Add a component to the REXS model.

        Parameters
        ----------
        type
            REXS type of the component.
        name
            Name of the component.
        **attributes
            Values of attributes in the units of `UNITS`; those that are None are omitted.

        Returns
        -------
        int
            Id of the component.
        """
        k = len(self.components) + 1
        self.components[k] = RexsComponent(k, type, name, {a: v for a, v in attributes.items() if v is not None})
        return k

    def add_relation(self, type: str, order: int | None = None, **roles: int) -> None:
        """Add a relation between components to the REXS model.

        Parameters
        ----------
        type
            REXS type of the relation.
        order
            Position of a part among the other parts of the same component, from 1; None: no position is stated.
        **roles
            Id of the component in each role.
        """
        self.relations.append(RexsRelation(type, roles, order))

    def parts(self, whole: int, type: str) -> list[RexsComponent]:
        """Return the parts of the component with the id ``whole`` that have the REXS type ``type``.

        The parts are in the order that the relations state.
        """
        found = [r for r in self.relations if r.roles.get("assembly") == whole and "part" in r.roles]
        found.sort(key=lambda r: r.order or 0)
        return [x for r in found if (x := self.components[r.roles["part"]]).type == type]

    def material(self, *ids: int) -> RexsComponent | None:
        """Return the material of the first of the components ``ids`` that has one, as a component; None if none has."""
        for k in ids:
            for r in self.relations:
                if r.type == "reference" and r.roles.get("origin") == k and "referenced" in r.roles:
                    found = self.components[r.roles["referenced"]]
                    if found.type == "material":
                        return found
        return None


def read_rexs_file(path: Path) -> RexsModel:
    """Read a REXS file.

    Parameters
    ----------
    path
        Path of the file.

    Returns
    -------
    RexsModel
        Components, relations and load cases, with the attributes in `UNITS`.

    Raises
    ------
    InputError
        If the file is not REXS 1.x, or contains an unknown id, an unexpected unit, or a number that cannot be read.
    """
    text = read_scene_text(path).lstrip("\ufeff")
    if "<!DOCTYPE" in text:
        raise InputError(str(path), "DOCTYPE", "a document type", "an XML file without one", "remove it")
    try:
        root = ET.fromstring(text)
    except ET.ParseError as error:
        raise InputError(str(path), "file", str(error), "an XML file of REXS", "export the file again") from None
    version = root.get("version", "")
    if root.tag != "model" or version.partition(".")[0] != "1":
        found = f"<{root.tag} version={version!r}>"
        advice = "export the file in one of these versions"
        raise InputError(str(path), "model", found, f"<model> of REXS 1.0 to {VERSION}", advice)
    model = RexsModel()
    for one in root.iterfind("components/component"):
        k = _component_id(one, path)
        name = one.get("name") or ""
        model.components[k] = RexsComponent(k, one.get("type", ""), name, _known_attributes(one, path))
    for one in root.iterfind("relations/relation"):
        roles = {ref.get("role", ""): _component_id(ref, path) for ref in one.iterfind("ref")}
        order = one.get("order", "")
        model.relations.append(RexsRelation(one.get("type", ""), roles, int(order) if order.isdigit() else None))
    for case in root.iterfind("load_spectrum/load_case"):
        model.load_cases.append(
            {_component_id(one, path): _known_attributes(one, path) for one in case.iterfind("component")}
        )
    for k in {*(k for r in model.relations for k in r.roles.values()), *(k for case in model.load_cases for k in case)}:
        if k not in model.components:
            advice = "export the file again; a relation or load case refers to a component that is missing"
            raise InputError(str(path), "id", str(k), "the id of a component", advice)
    return model


def _component_id(element: ET.Element, path: Path) -> int:
    """Return the id of an XML element as a number; InputError if it is not an integer.

    ``path``: the file, for messages.
    """
    text = element.get("id", "")
    if not text.isdigit():
        raise InputError(str(path), element.tag, f"id={text!r}", "a whole number", "export the file again")
    return int(text)


def _known_attributes(component: ET.Element, path: Path) -> dict[str, Value]:
    """Return the values of those attributes of a component that this program knows (`UNITS`), by their names.

    ``component``: its XML element; ``path``: the file, for messages. InputError for a wrong unit or an invalid number.
    """
    found = {}
    for one in component.iterfind("attribute"):
        name, unit = one.get("id", ""), one.get("unit", "")
        if name not in UNITS:
            continue
        where = f"component {component.get('id')}, attribute {name}"
        if unit not in ("", UNITS[name]) and not (unit == "°" and UNITS[name] == "deg"):
            advice = "convert the value; REXS defines one unit for each attribute"
            raise InputError(str(path), where, f"unit {unit!r}", f"unit {UNITS[name]!r}", advice)
        cells, text = one.findall("array/c"), (one.text or "").strip()
        try:
            value = tuple(float(c.text or "") for c in cells) if cells else _parse_attribute(text, UNITS[name])
        except ValueError:
            advice = "write a number with a decimal point and without unit"
            raise InputError(str(path), where, text or "no number", f"a number in {UNITS[name]}", advice) from None
        if value not in ((), ""):
            found[name] = value
    return found


def _parse_attribute(text: str, unit: str) -> Value:
    """Return the value of an attribute from its text: true or false, a number, or a word if ``unit`` is "none"."""
    if text in ("true", "false"):
        return text == "true"
    return float(text) if text and unit != "none" else text


def rexs_file_text(model: RexsModel, version: str, writing_date: str) -> str:
    """Return a REXS model as the text of a REXS file (XML).

    Parameters
    ----------
    model
        Components, relations and load cases.
    version
        Version of this program (rollbench), written to the file.
    writing_date
        Date of writing (ISO 8601).

    Returns
    -------
    str
        XML text.
    """
    head = {"version": VERSION, "applicationId": "rollbench", "applicationVersion": version, "date": writing_date}
    root = ET.Element("model", head | {"applicationLanguage": "en"})
    relations, components = ET.SubElement(root, "relations"), ET.SubElement(root, "components")
    for k, relation in enumerate(model.relations, 1):
        order = {} if relation.order is None else {"order": str(relation.order)}
        one = ET.SubElement(relations, "relation", {"id": str(k), "type": relation.type, **order})
        for role, ref in relation.roles.items():
            ET.SubElement(one, "ref", {"id": str(ref), "role": role, "hint": model.components[ref].type})
    for component in model.components.values():
        _write_component(components, component, component.attributes)
    if model.load_cases:
        spectrum = ET.SubElement(root, "load_spectrum", {"id": "1"})
        for k, case in enumerate(model.load_cases, 1):
            one = ET.SubElement(spectrum, "load_case", {"id": str(k)})
            for ref, attributes in case.items():
                _write_component(one, model.components[ref], attributes)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _write_component(parent: ET.Element, component: RexsComponent, attributes: dict[str, Value]) -> None:
    """Append a REXS component with the values ``attributes`` to the XML element ``parent``."""
    head = {"id": str(component.id), "type": component.type, "name": component.name}
    one = ET.SubElement(parent, "component", {k: v for k, v in head.items() if v})
    for name, value in attributes.items():
        attribute = ET.SubElement(one, "attribute", {"id": name, "unit": UNITS[name]})
        if isinstance(value, tuple):
            array = ET.SubElement(attribute, "array")
            for x in value:
                ET.SubElement(array, "c").text = _attribute_text(float(x))
        else:
            attribute.text = _attribute_text(value)


def _attribute_text(value: str | float | bool) -> str:
    """Return the value of an attribute as text; numbers get 15 digits, from which those of a scene file are recovered."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.15g}" if isinstance(value, float) else str(value)
