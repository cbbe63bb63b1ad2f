"""Processor time of cold set-ups: what is kept, and the tables made of it."""

import json
from dataclasses import asdict, replace

from rollbench.compare.reference import expected, store
from rollbench.compare.sections.reference_time import cost_tables
from rollbench.compare.studies.run_times.kept import SET_UP_COSTS, Costs, SetUp, Way, load_costs

JOB = SetUp(
    "a screw", 1, 64, {"nut": {"all": 3.0, "elimination": 2.0, "dense": 1.0}, "meshes": {"all": 1.0, "meshing": 0.5}}
)
COSTS = Costs("a machine", "a day", [JOB], [Way("a screw", "coarser", 2.0, 0.01)])


def test_costs_are_read_as_they_were_written(tmp_path) -> None:
    (tmp_path / SET_UP_COSTS).write_text(json.dumps(asdict(COSTS)))
    assert load_costs([tmp_path / "none", tmp_path]) == COSTS
    (tmp_path / SET_UP_COSTS).write_text("{}")
    assert load_costs([tmp_path]) is None


def test_tables_say_the_floor_of_two_cores_and_what_ways_move() -> None:
    stages, ways = cost_tables(replace(COSTS, jobs=[JOB, replace(JOB, scene="other")]))
    spent = [("nut", 3.0, 2.0, 1.0), ("meshes", 1.0, 0.0, 0.0), ("all", 4.0, 2.0, 1.0)]
    assert [(row["stage"], row["all"], row["elimination"], row["dense"]) for row in stages.rows] == 2 * spent
    assert "at least 2.0 s (a screw, level 1), 2.0 s (other, level 1)" in stages.note
    assert [(row["way"], row["saved"], row["moved"]) for row in ways.rows] == [("coarser", 2.0, 0.01)]


def test_the_shipped_record_has_every_stage_and_bounds_the_missed_targets() -> None:
    costs = load_costs([store.shipped_store()])
    for job in costs.jobs:
        assert set(job.stages) == set(expected.STAGES)
        for stage in job.stages.values():
            parts = stage.get("meshing", 0.0) + stage.get("assembly", 0.0) + stage.get("elimination", 0.0)
            assert stage.get("dense", 0.0) <= stage.get("elimination", 0.0) <= parts <= stage["all"]
    small, large = costs.jobs
    assert (small.contacts, large.contacts) == (64, 228)
    assert small.of("all") / 2.0 > 12.0, "two cores cannot reach 12 s"
    assert large.of("all") > 50.0
    assert all(way.moved > 1e-3 for way in costs.ways), "a way that moves no load is to be taken"
