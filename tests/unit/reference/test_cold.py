"""Cold times are those of a new process with empty caches."""

import pytest

from compare.costs import cold
from compare.costs.cold import measure


def test_a_new_process_pays_for_imports_and_first_solve() -> None:
    found = measure("lin-case1", "lin-nut", repeats=2)
    assert found.status == "converged"
    assert found.process > found.first > 2.0 * found.warm > 0.0
    assert found.process > found.first + 0.1  # interpreter and imports
    assert found.memory is None or 30.0 < found.memory < 1000.0


def test_caches_of_the_child_are_empty_and_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROLLBENCH_CACHE", "/nowhere")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/nowhere")
    looked = "import os; found = [(p := os.environ[k], os.listdir(p)) for k in ('ROLLBENCH_CACHE', 'NUMBA_CACHE_DIR')]\n"
    code = looked + "raise SystemExit(repr([(p != '/nowhere', x) for p, x in found]))"
    monkeypatch.setattr(cold, "CHILD", code.replace("{", "{{").replace("}", "}}"))
    with pytest.raises(RuntimeError, match=r"\[\(True, \[\]\), \(True, \[\]\)\]"):
        measure("lin-case1", "lin")


def test_a_process_that_fails_is_no_time() -> None:
    with pytest.raises(RuntimeError, match="no-such-model"):
        measure("lin-case1", "no-such-model", repeats=1)
