"""Every printed entry is traced to scenes, one computation and one test, and every trace resolves."""

import ast
from collections import Counter
from importlib import import_module

import pytest
from tests.copies import ROOT
from tests.sources.entries import keys

from rollbench.compare.evidence.computations import by_table, computations, evidence, traces
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import load_table, tables
from rollbench.compare.scenes import catalogue

#: The cases' modules are imported by the names that ``computations.toml`` gives.
pytestmark = pytest.mark.further
BY_TABLE, NOT_COMPUTED = by_table(), computations().keys() - by_table().keys()
COMPUTATIONS = tuple(BY_TABLE.values())
TRACES = list(traces())


def test_every_printed_entry_is_traced_once():
    entries = Counter((r.table, r.key) for name in tables() for r in load_table(name))
    assert Counter((t.table, t.key) for t in TRACES) == entries
    assert set(computations()) == set(tables())


@pytest.mark.parametrize("computation", COMPUTATIONS, ids=lambda c: c.table)
def test_computation_resolves_to_a_function_and_a_test_file_that_asserts_every_entry_of_the_table(computation):
    """The file's function test_entry is parametrised with the keys of the table."""
    module, name = computation.function.split(":")
    assert callable(getattr(import_module(module), name))
    tree = ast.parse((ROOT / computation.test).read_text(encoding="utf-8"))
    (entry,) = (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == "test_entry")
    assert "check(key)" in ast.unparse(entry)
    (marked,) = import_module(computation.test.removesuffix(".py").replace("/", ".")).test_entry.pytestmark
    assert set(keys(computation.table)) <= set(marked.args[1])


def test_scenes_exist_and_every_pattern_is_needed():
    shipped = set(catalogue.scene_names())
    used = {(t.table, behind) for t in TRACES for behind in (t.scenes, t.no_scene)}
    for t in TRACES:
        assert set(t.scenes) <= shipped, t
        assert bool(t.scenes) != bool(t.no_scene), t
    for c in COMPUTATIONS:
        for _, behind in c.behind:
            assert (c.table, behind) in used, (c.table, behind)


def test_only_what_needs_no_scene_has_none():
    """Choices, arithmetic on printed numbers, other programs and machines; Smith's formulas but three."""
    lin = [t for t in TRACES if t.table.startswith("lin")]
    external = [t for t in TRACES if t.table.startswith("external")]
    assert [t.key for t in TRACES if t.table.startswith("smith") and t.scenes] == ["total_ball", "total_taper", "supported"]
    assert {t.key for t in TRACES if t.table.startswith("liu") and not t.scenes} == {
        *("v_2pi", "ball_error", "profile_error", "e_1", "e_2", "e_3", "plus_or_minus", "load", "free_length", "deviation"),
        *("spread_100", "spread_1100", "spread_2100", "spread_percent"),
    }
    formulas = {"external-contact", "external-vm63", "external-snfa", "external-gmn", "external-equivalent"}
    assert {t.table for t in external if not t.scenes} == formulas | {"external-sjovall", "external-thk"}
    assert {t.key for t in external if not t.scenes and t.table not in formulas} == {"thrust", "drag_formula"}
    without = {t.key for t in lin if not t.scenes and t.table not in NOT_COMPUTED}
    others = {"speed_ratio", "error_numerical", "reach", "pressure", "a_over_R", "eta", "difference_a", "difference_b"}
    elsewhere = {t.key for t in TRACES if t.table in ("lin-3.5", "lin-3.7") and ("ansys" in t.key or "time" in t.key)}
    assert without == others | elsewhere


def test_evidence_of_a_table_is_in_its_order_and_computed_once():
    study = Study()
    first, again = (evidence(study, "lin-B1") for _ in range(2))
    assert [e.printed for e in first] == list(load_table("lin-B1"))
    assert first[0] is again[0]


def test_command(command):
    rows = command.answer("list", "--trace")
    assert len(rows) == len(TRACES)
    (row,) = (r for r in rows if (r["table"], r["key"]) == ("lin-3.2", "F_IR_II"))
    assert row["computation"] == "rollbench.compare.cases.lin.evidence.rotary_linear:table_3_2"
    assert row["scenes"] == ["lin-rotary-2-printed", "lin-rotary-2"]
    assert row["test"] == "tests/sources/lin/literature/test_lin_chapter3_rotary.py::test_entry[lin-3.2:F_IR_II]"
    assert "F_IR_II" in command.said("list", "--trace")

    rows = command.answer("list", "--trace", "--table", "smith-5")
    assert [(r["table"], r["key"]) for r in rows] == [("smith-5", row.key) for row in load_table("smith-5")]
    assert {r["key"]: r["no_scene"] for r in rows}["accuracy_ball"] == "measured by the source: shown, not computed"
    out = command("list", "--table", "smith-5").out
    for row in rows:
        assert {row["key"], row["computation"], row["test"].removeprefix("tests/sources/")} <= set(out.split())
        assert row["no_scene"] in out
