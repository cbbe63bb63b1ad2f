"""Cold times are those of a new process with empty caches."""

from dataclasses import replace

import pytest

from rollbench.compare.reference.measured import Measured
from rollbench.compare.sections.reference_time import level_table
from rollbench.compare.studies.run_times import cold
from rollbench.compare.studies.run_times.kept import Kept, load_times, save_times


def test_a_new_process_pays_for_imports_and_first_solve() -> None:
    with pytest.raises(RuntimeError, match="no-such-model"):
        cold.measure("lin-case1", "no-such-model", repeats=1)
    found = cold.measure("lin-case1", "lin-nut", repeats=2)
    assert found.status == "converged"
    assert found.process > found.first > 2.0 * found.warm > 0.0
    assert found.process > found.first + 0.1  # interpreter and imports
    assert found.memory is None or 30.0 < found.memory < 1000.0


def test_cold_levels_are_kept(tmp_path) -> None:
    stages = {"ball": 0.2, "nut": 1.5, "patches": 5.0, "screw": 3.0}
    level = cold.ColdLevel(1, 12.0, 20.0, 1400.0, "converged", "unseen-25x5", 264, 4.0, stages)
    kept = Kept(Measured("0.1", "abc", "a machine"), "today", {}, {}, (level,))
    save_times(tmp_path, kept)
    assert load_times([tmp_path]) == kept
    (row,) = level_table(kept).rows
    costs = {"load_case": 4.0, "stages": "patches 5.0 s, screw 3.0 s, nut 1.5 s", "memory": 1400.0, "status": "converged"}
    assert row == {"scene": "unseen-25x5", "contacts": 264, "level": 1, "cold": 12.0, "cpu": 20.0} | costs
    assert level_table(replace(kept, levels=[replace(level, stages=None)])).rows[0]["stages"] == "not measured"
