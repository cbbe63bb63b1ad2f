"""A changed number of an answer shows in every spelling: JSON, rows of the table, text and notebook, and columns."""

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.slow import all_slow_but

import rollbench
from rollbench.compare.results.comparison import Comparison, ModelLoads
from rollbench.compare.results.solved import Result
from rollbench.meshes.quantity import quantity_descriptions

#: Fields that are not walked, and why.
LEFT_OUT = {
    "described": "the scene",
    "parts": "the scene",
    "of": "the scene",
    "on_shaft.balls": "the same record as `balls` of the set",
    "solution.sets": "the same records as `on_shaft` of the sets",
    "solution.load": "the same array as in `balls` of the set",
    "solution.contact_angle": "the same array as in `balls` of the set",
    "solution.pressure": "the same array as in `balls` of the set",
    "solution.azimuth": "the same array as in `balls` of the set",
    "solution.z": "the same array as in `balls` of the set",
    "balls.centreline": "the centreline is that of `solution`",
    "balls.centreline_z": "the centreline is that of `solution`",
    "balls.equilibrium": "the equilibrium is that of `solution`",
    "balls.solver": "the solver is that of `solution`",
    "member": "the specimen, an input",
    "reactions": "the state of the solver, from which `load_path` follows",
    "reaction": "the state of the solver; that on the shaft is shown",
    "contact_point": "the state of the solver, for the 3D view",
    "force_direction": "the state of the solver, for the 3D view",
    "centre_shift": "the state of the solver, for friction",
    "hertz_C": "the state of the solver, for friction",
    "worst_ball": "where the solver left the largest residual",
    "setup_seconds": "time of the solver",
    "solves": "effort of the search",
}
SCENES = ("lin-case1", "lin-case3", "bearing-9-preload", "axis-fixed-fixed", "double-nut", "smith-axis-taper")


@cache
def solved(name: str) -> Result:
    """The result of a shipped scene by the model lin."""
    return rollbench.solve(name, "lin")


def changed_number(value: Any) -> Any:
    """Another number, or an array of which each number is another."""
    if isinstance(value, tuple):
        return tuple(changed_number(x) for x in value)
    return value * 1.25 + (1 if isinstance(value, int) else 0) if not isinstance(value, int) else value + 1


def is_number(value: Any) -> bool:
    """Whether a value is a number that can be changed, an array or a tuple of such numbers."""
    if isinstance(value, tuple):
        return bool(value) and all(map(is_number, value))
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "f" and bool((np.isfinite(value) & (value != 0.0)).any())
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value)) and value != 0.0


def numbers(record: Any, path: str, put: Callable[[Any], Any]) -> Iterator[tuple[str, str, type, Callable[[], Any]]]:
    """Path, field and class of each numeric field below a record, and what makes the whole with this number changed."""
    for field in fields(record):
        where = f"{path}.{field.name}".lstrip(".")
        if field.name in LEFT_OUT or ".".join(where.split(".")[-2:]) in LEFT_OUT:
            continue
        value = getattr(record, field.name)

        def put_field(new: Any, name: str = field.name) -> Any:
            """The whole with another value of this field."""
            return put(replace(record, **{name: new}))

        if is_number(value):
            yield where, field.name, type(record), lambda value=value, put_field=put_field: put_field(changed_number(value))
        elif isinstance(value, dict):
            for key, one in value.items():

                def put_key(new: Any, key: str = key, value: Any = value, put_field: Any = put_field) -> Any:
                    """The whole with another value at this key."""
                    return put_field({**value, key: new})

                if is_dataclass(one):
                    yield from numbers(one, where, put_key)
                elif is_number(one):
                    yield f"{where}.{key}", key, dict, lambda one=one, put_key=put_key: put_key(changed_number(one))
        elif is_dataclass(value):
            yield from numbers(value, where, put_field)


def heading(kind: type, name: str) -> bool:
    """Whether the quantity of a field has a row in the table that `solve` prints."""
    return any(key == name and x.heading for key, x in quantity_descriptions(kind)) if is_dataclass(kind) else False


@pytest.mark.parametrize("scene", all_slow_but([SCENES[0]], SCENES))
def test_a_changed_number_shows_in_every_spelling(scene: str) -> None:
    result, silent = solved(scene), []
    json, page = result.to_dict(), result._repr_html_()
    rows = result.rows(details=True)
    worst = result.worst_set.name
    for path, name, kind, change in numbers(result, "", lambda new: new):
        other = change()
        if other.to_dict() == json:
            silent.append(f"{path}: JSON")
        own = (
            result.only is not None
            or not path.startswith("sets.")
            or all(other.sets[key] is one for key, one in result.sets.items() if key != worst)
        )
        of_one = {"nut", "preload", "clearance", "bearing_torque", "torque"}  # stand in the table of the nuts and bearings
        hidden = of_one & set(path.split(".")) and result.only is None
        if heading(kind, name) and own and not hidden and other.rows(details=True) == rows:
            silent.append(f"{path}: rows")
        if heading(kind, name) and own and not hidden and other._repr_html_() == page:
            silent.append(f"{path}: notebook")
    assert not silent, "\n".join(dict.fromkeys(silent))


@pytest.mark.parametrize("scene", SCENES[:3])
def test_the_short_text_and_the_columns_follow_the_fields(scene: str) -> None:
    """A pressure or displacement that is set in the record stands in `repr`, in the JSON and in the columns."""
    result, one = solved(scene), solved(scene).only
    other = replace(result, sets={"": replace(one, worst=replace(one.worst, pressure=1.0e9))})
    assert "1000 MPa" in repr(other)
    assert other.to_dict()["summary"]["worst_contact"]["pressure_MPa"] == pytest.approx(1000.0)
    other = replace(result, load_point=replace(result.load_point, displacement=1e-3))
    assert "1000 um" in repr(other)
    assert other.to_dict()["summary"]["load_point"]["displacement_um"] == pytest.approx(1000.0)
    other = replace(result, sets={"": replace(one, balls=replace(one.balls, load=2.0 * one.balls.load))})
    assert other.columns()["load_SL_N"] == pytest.approx(2.0 * result.columns()["load_SL_N"])
    assert other.to_dict()["summary"]["loads"]["max_N"] == pytest.approx(2.0 * result.loads.max())
    assert f"{2.0 * result.loads.max():.5g} N" in repr(other)


#: Fields of the loads of a model in a comparison, how they are changed, and where the change must show.
OF_COMPARISON: dict[str, tuple[Callable[[ModelLoads], ModelLoads], tuple[str, ...]]] = {
    "largest error": (lambda x: replace(x, error=replace(x.error, max_percent=77.0)), ("JSON", "text", "notebook", "repr")),
    "mean error": (lambda x: replace(x, error=replace(x.error, rms_percent=77.0)), ("JSON", "text", "notebook", "repr")),
    "error of the check": (lambda x: replace(x, gate_error=77.0), ("text", "notebook", "repr")),
    "displacement": (lambda x: replace(x, displacement=77e-6), ("JSON", "text", "notebook")),
    "pressure": (
        lambda x: replace(
            x, derived_results=replace(x.derived_results, worst=replace(x.derived_results.worst, pressure=7e9))
        ),
        ("JSON", "text", "notebook"),
    ),
    "loads": (
        lambda x: replace(x, contact_loads=replace(x.contact_loads, load=2.0 * x.loads)),
        ("JSON", "text", "notebook", "frame"),
    ),
    "errors": (lambda x: replace(x, errors=2.0 * x.errors), ("frame",)),
    "force": (lambda x: replace(x, axial_force=7e3), ("JSON", "text", "notebook")),
}


#: Spellings of an answer, as values that can be compared.
SPELLINGS: dict[str, Callable[[Any], Any]] = {
    "JSON": lambda x: x.to_dict(),
    "text": str,
    "notebook": lambda x: x._repr_html_(),
    "repr": repr,
    "frame": lambda x: x.columns(),
}
#: Numbers of a comparison that it does not show: of the solver and the search for models like this scene, errors by other
#: measures (the gate's is `gate_error`), and what only the judged model has.
NOT_OF_COMPARISON = (
    *("contact_loads.angle", "contact_loads.stations", "contact_loads.line", "contact_loads.seconds"),
    *("error.own_max_percent", "error.own_rms_percent", "error.gate_percent"),
    *("expected_error.distance", "expected_error.compared", "expected_error.calibrated"),
)


@cache
def compared() -> Comparison:
    """The comparison of the model lin with the 3D reference of a shipped scene."""
    return rollbench.compare_models("lin-case1", ["lin"])


@pytest.mark.parametrize("name", OF_COMPARISON)
def test_a_changed_number_of_a_comparison_shows_in_every_spelling(name: str) -> None:
    found = compared()
    change, where = OF_COMPARISON[name]
    other = replace(found, models={**found.models, "lin": change(found.models["lin"])})
    for shown in where:
        before, after = (SPELLINGS[shown](x) for x in (found, other))
        assert before != after, shown


def test_every_number_of_a_comparison_shows() -> None:
    """In JSON, frame or text; the page of a notebook shows what the text does."""
    found = compared()
    found = replace(found, models={"lin": found.models["lin"]})
    before = {name: spell(found) for name, spell in SPELLINGS.items()}
    silent = []
    for path, _, _, change in numbers(found, "", lambda new: new):
        after = {name: spell(change()) for name, spell in SPELLINGS.items()}
        shown = {name for name in SPELLINGS if after[name] != before[name]}
        if path.endswith(NOT_OF_COMPARISON) == bool(shown) or ("text" in shown) != ("notebook" in shown):
            silent.append((path, shown))
    assert not silent
