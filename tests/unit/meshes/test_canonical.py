"""The canonical form that keys are made of: it survives new fields, and nothing that numbers depend on escapes it."""

import dataclasses
import tomllib
import typing
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from tests.keyed_records import built, changed, default, example, keyed_records, names, other

from rollbench.compare.reference import store as reference_store
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.result import Status
from rollbench.meshes import record_keys
from rollbench.meshes import record_keys as module
from rollbench.meshes.parts import Errors, Scene

pytestmark = pytest.mark.every_run  # records of studies are among those of one solve
RECORDS = keyed_records()
FIELDS = [(name, field) for name, record in RECORDS.items() for field in names(record)]
#: Frozen defaults as they were in 0.15, by record and field.
FROZEN_THEN = tomllib.loads(Path(__file__).with_name("frozen_defaults.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", sorted(FROZEN_THEN))
def test_frozen_defaults_stay(name: str) -> None:
    """A default that is changed is written `frozen_default(FORMER, now=NEW)`: the former one stays frozen."""
    frozen = module._frozen_default_texts(RECORDS[name])
    assert {field: frozen.get(field) for field in FROZEN_THEN[name]} == FROZEN_THEN[name]


def test_a_default_that_is_not_frozen_fails_at_import_and_one_that_is_changed_later_changes_the_form() -> None:
    class Forgotten:
        known: float
        added: float = 0.25

    with pytest.raises(TypeError, match=r"Forgotten\.added: its default is not frozen: write frozen_default"):
        record_keys.frozen_record(Forgotten)

    @record_keys.frozen_record
    class Later:
        sign: float = record_keys.scene_key(usual=1.0, default=-1.0)

    assert list(map(record_keys.canonical_text, (Later(), Later(1.0)))) == ["Later(sign=-1)", "Later()"]


def test_a_field_of_any_part_that_has_no_effect_on_static_loads_changes_no_key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(record_keys.FROZEN, "Nut", {})

    @record_keys.frozen_record
    class Nut(RECORDS["Nut"]):  # type: ignore[misc]
        drawing_number: str = record_keys.frozen_default("", static=False)

    monkeypatch.setattr(module, "_frozen_default_texts", module._frozen_default_texts.__wrapped__)
    scene = catalogue.scene("lin-case1")
    named = dataclasses.replace(scene, nut=Nut(**vars(scene.nut), drawing_number="BS-4010"))
    assert run_and_body_keys(named, {}) == run_and_body_keys(scene, {})
    longer = dataclasses.replace(named, nut=dataclasses.replace(named.nut, length=0.1))
    assert run_and_body_keys(longer, {})[1] != run_and_body_keys(scene, {})[1]


def test_the_static_part_of_a_scene_is_without_names_and_friction() -> None:
    nut, axis = catalogue.shipped_scene("lin-case1"), catalogue.shipped_scene("smith-axis-taper")
    for scene in (nut, axis):
        renamed = dataclasses.replace(scene, name="x", title="y", source="z", assumed=("a",), friction=None)
        assert record_keys.static_part(renamed) == record_keys.static_part(scene) != scene
    assert record_keys.static_part(dataclasses.replace(nut, loads=())) != record_keys.static_part(nut)
    assert {one.name for one in record_keys.static_part(axis).sets} == {""}


@pytest.mark.parametrize("name", sorted(RECORDS))
def test_every_record_of_keys_is_keyed(name: str) -> None:
    """So that a default that is not frozen fails when the record is imported, before a key is made."""
    record = RECORDS[name]
    has_default = [field for field in names(record) if default(record, field) is not dataclasses.MISSING]
    assert set(has_default) == set(record_keys.FROZEN.get(name, {}))


def with_field(record: type, field: str, value: object) -> type:
    """The record's class as it will be with a new field, or a new default."""
    new = dataclasses.field(default_factory=lambda: value, metadata={"usual": value})
    return dataclasses.make_dataclass(record.__name__, [(field, typing.Any, new)], bases=(record,), frozen=True)


def as_class(value: object, record: type) -> object:
    """The value with every record of that name made one of that class."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        of = record if type(value).__name__ == record.__name__ else type(value)
        return built(of, **{name: as_class(getattr(value, name), record) for name in names(type(value))})
    return tuple(as_class(x, record) for x in value) if isinstance(value, tuple) else value


def run_and_body_keys(scene: object, settings: dict[str, float]) -> tuple[str, str]:
    run = reference_store.content_key_of_run(scene, "land", settings, (0, 3))
    return run, reference_store.content_key_of_condensed_bodies(scene, settings, (0, 3))


@pytest.mark.parametrize("name", sorted(RECORDS))
def test_a_new_field_changes_no_key_of_records_runs_and_bodies(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, cell = catalogue.scene("lin-case3-offset"), {"cell": 1.0}
    before = {key: record_keys.canonical_text(example(record)) for key, record in RECORDS.items()}
    keys = run_and_body_keys(scene, cell)
    later = with_field(RECORDS[name], "added", 0.25)
    monkeypatch.setitem(record_keys.FROZEN, name, record_keys.FROZEN.get(name, {}) | {"added": 0.25})
    monkeypatch.setattr(module, "_frozen_default_texts", module._frozen_default_texts.__wrapped__)
    for key, record in RECORDS.items():
        changed_record = as_class(example(record), later)
        assert record_keys.canonical_text(changed_record) == before[key], key
        if key == name:
            assert record_keys.canonical_text(changed(changed_record, added=0.5)) != before[key]
    settings = cell | ({"added": 0.25} if name == "Settings" else {})
    assert run_and_body_keys(as_class(scene, later), settings) == keys


@pytest.mark.parametrize(("name", "field"), FIELDS)
def test_another_value_of_any_field_changes_the_form(name: str, field: str) -> None:
    record, hints = example(RECORDS[name]), typing.get_type_hints(RECORDS[name])
    another = changed(record, **{field: other(getattr(record, field), hints[field])})
    assert record_keys.canonical_text(another) != record_keys.canonical_text(record)


@pytest.mark.parametrize(("name", "field"), [x for x in FIELDS if x[1] in record_keys.FROZEN.get(x[0], {})])
def test_another_default_of_any_field_changes_the_form_of_what_relies_on_it(name: str, field: str) -> None:
    record = RECORDS[name]
    later = with_field(record, field, other(default(record, field), typing.get_type_hints(record)[field]))
    given = {key: getattr(example(record), key) for key in names(record) if key not in record_keys.FROZEN.get(name, {})}
    assert record_keys.canonical_text(built(later, **given)) != record_keys.canonical_text(built(record, **given))


@pytest.mark.parametrize("field", [f.name for f in dataclasses.fields(Scene) if f.metadata.get("static", True)])
def test_any_field_that_static_loads_depend_on_changes_the_key_of_a_run(
    field: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reference_store, "dimensions_of_3d_parts", lambda _: example(RECORDS["Dimensions"]))
    scene = catalogue.scene("lin-case3-offset")
    value = other(getattr(scene, field), typing.get_type_hints(Scene)[field])
    another = dataclasses.replace(scene, **{field: value})
    assert run_and_body_keys(another, {})[0] != run_and_body_keys(scene, {})[0]


def test_every_shipped_run_is_found_by_todays_key() -> None:
    """None is renamed or lost, of any level."""
    store, found = reference_store.shipped_store(), 0
    for name in catalogue.scene_names():
        for path in store.glob(f"{name}-level[1-9]-{reference_store.KEY}.json"):
            level = int(path.stem.removeprefix(f"{name}-level")[0])
            assert path in reference_store.files_of_stored_runs(store, catalogue.shipped_scene(name), level), path.name
            found += 1
    assert found > 60


def test_equal_numbers_have_one_text() -> None:
    for same in ((3, 3.0, np.float64(3.0), np.int32(3), np.float32(3.0)), (10**20, 1e20), (0.1, np.float64(0.1)), (0, 0.0)):
        assert len(set(map(record_keys.canonical_text, same))) == 1
    numbers = [0, -0.0, 1, True, False, 0.1, 0.1 + 1e-17 * 2, np.float32(0.1), 5e-324, 1e308, np.nan, np.inf, -np.inf]
    others = ["1", "nan", "None", None, (), [], {}, (1,), [1], (1, 1), np.array([1.0]), np.array([1]), np.array([[1.0]])]
    apart = [*numbers, *others]
    assert len(set(map(record_keys.canonical_text, apart))) == len(apart)
    assert record_keys.canonical_text(float("nan")) == record_keys.canonical_text(-float("nan"))


def test_containers_and_arrays_count_by_content() -> None:
    assert record_keys.canonical_text({"a": 1, (1, 2): 3}) == record_keys.canonical_text({(1, 2): 3.0, "a": 1})
    square = np.arange(6.0).reshape(2, 3)
    assert record_keys.canonical_text(np.asfortranarray(square)) == record_keys.canonical_text(square)
    rows, columns, more = sp.csr_matrix(square), sp.csc_matrix(square), sp.csr_matrix(square + 1.0)
    assert len(set(map(record_keys.canonical_text, (square, square.T, rows, columns, more)))) == 5
    for same in (record_keys.RecordFields(Errors, {"seed": 0}), Errors()):
        assert record_keys.canonical_text(same) == "Errors()"
    assert record_keys.canonical_text(Errors(lead_offset=2e-6)) == "Errors(lead_offset=2e-06)"
    assert record_keys.canonical_text(Status("not held", "why")) == record_keys.canonical_text("not held: why")
    assert record_keys.digest_of_values(1, "a") != record_keys.digest_of_values((1, "a"))


FORMLESS = [object(), Path("a"), {1}, len, np.array([None]), 1j, np.ma.array([1.0])]


@pytest.mark.parametrize("value", FORMLESS, ids=lambda value: type(value).__name__)
def test_what_has_no_form_is_refused(value: object) -> None:
    for inside in (value, (value,), {"a": value}):
        with pytest.raises(TypeError, match="no canonical text"):
            record_keys.canonical_text(inside)
