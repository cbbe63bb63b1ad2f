"""Every printed entry is traced to scenes, one computation and one test, and every trace resolves."""

from collections import Counter
from importlib import import_module

import pytest
from tests.sources.entries import keys

from rollbench.compare.evidence import all_computations, computations_of_entries, computations_with_function
from rollbench.compare.printed import load_printed_table, printed_table_names

#: The cases' modules are imported by the names that ``computations.toml`` gives.
pytestmark = pytest.mark.further
BY_TABLE = computations_with_function()
COMPUTATIONS = tuple(BY_TABLE.values())
TRACES = list(computations_of_entries())


def test_every_printed_entry_is_traced_once():
    entries = Counter((r.table, r.key) for name in printed_table_names() for r in load_printed_table(name))
    assert Counter((t["table"], t["key"]) for t in TRACES) == entries
    assert set(all_computations()) == set(printed_table_names())


@pytest.mark.parametrize("computation", COMPUTATIONS, ids=lambda c: c.table)
def test_computation_resolves_to_a_function_and_a_test_file_that_asserts_every_entry_of_the_table(computation, monkeypatch):
    """The file's function test_entry is parametrised with the keys of the table."""
    module, name = computation.function_name.split(":")
    assert callable(getattr(import_module(module), name))
    tests, asserted = import_module(computation.test_file.removesuffix(".py").replace("/", ".")), []
    monkeypatch.setattr(tests, "check", asserted.append)
    tests.test_entry("an entry")
    assert asserted == ["an entry"]
    (marked,) = tests.test_entry.pytestmark
    assert set(keys(computation.table)) <= set(marked.args[1])


def test_command(command):
    rows = command.answer("list", "--trace")
    assert len(rows) == len(TRACES)
    (row,) = (r for r in rows if (r["table"], r["key"]) == ("lin-3.2", "F_IR_II"))
    assert row["computation"] == "rollbench.compare.cases.lin.evidence.rotary_linear:table_3_2"
    assert row["scenes"] == ["lin-rotary-2-printed", "lin-rotary-2"]
    assert row["test"] == "tests/sources/lin/literature/test_lin_chapter3_rotary.py::test_entry[lin-3.2:F_IR_II]"
