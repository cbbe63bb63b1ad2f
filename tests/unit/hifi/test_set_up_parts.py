"""Parts of a set-up: what the cache keeps, what other processes make, and which are another one turned."""

import os
from dataclasses import replace

import numpy as np
import pytest
from tests.two_balls import SMALL, two_balls

from rollbench.hifi import setup
from rollbench.hifi.setup import RecordJob, compute_records
from rollbench.meshes.cache import Cache

pytestmark = pytest.mark.xdist_group("helped by processes")


def test_a_prepared_geometry_comes_whole_from_the_cache(small, small_cache):
    """Also what depends on records that came from the cache themselves."""
    again = Cache(small_cache.root)
    found = setup.mesh_and_condense_geometry(two_balls(), (0, 3), SMALL, cache=again)
    assert small_cache.hits == again.misses == 0
    assert small_cache.misses == again.hits > 5
    assert found.seconds_by_stage == pytest.approx(small.seconds_by_stage, rel=0.1), (
        "those of making its stages, not of reading"
    )
    assert min(found.seconds_by_stage.values()) > 0.0
    np.testing.assert_array_equal(found.condensed_ball.G, small.condensed_ball.G)
    np.testing.assert_array_equal(found.patches_by_flank[0].local_compliance, small.patches_by_flank[0].local_compliance)
    np.testing.assert_array_equal(found.condensed_screw.stretch.F, small.condensed_screw.stretch.F)


def test_a_set_up_in_two_processes_is_the_same(small, small_cache, tmp_path):
    given = small.scene, small.loaded_flanks, replace(SMALL, element="P1", tet=0.35e-3, modes=16, ball_modes=16)
    here = setup.mesh_and_condense_geometry(*given, cache=Cache(small_cache.root))
    shared = setup.mesh_and_condense_geometry(*given, cache=Cache(tmp_path), processes=2)
    assert shared.worker_peak_memory_MB > 100.0
    assert list(shared.seconds_by_stage) == list(here.seconds_by_stage)
    parts = [
        (
            *(x.patches_by_flank[s].local_compliance for s in small.loaded_flanks),
            x.condensed_nut.G,
            x.condensed_screw.stretch.F,
        )
        for x in (shared, here)
    ]
    for one, other in zip(*parts, strict=True):
        np.testing.assert_array_equal(one, other)
    again = Cache(tmp_path)
    setup.mesh_and_condense_geometry(*given, cache=again)
    assert again.misses == 0


def test_a_process_that_is_ended_from_outside_is_a_lack_of_memory():
    ended = f"__import__('os')._exit(1) if __import__('os').getpid() != {os.getpid()} else __import__('time').sleep(1)"
    part = RecordJob("any", eval, (ended,), type(None))
    with pytest.raises(MemoryError, match="ended from outside"):
        compute_records([part, part], Cache(None), 2)


def test_parts_are_made_here_and_by_others_in_their_order():
    parts = [RecordJob("any", eval, (f"({k}, __import__('time').sleep(0.5))[0]",), int) for k in range(4)]
    found = compute_records(parts, Cache(None), 2)
    assert [one.result for one in found] == [0, 1, 2, 3]
    assert len({one.process_id for one in found}) == 2
    assert os.getpid() in {one.process_id for one in found}
    with pytest.raises(ZeroDivisionError):
        compute_records([*parts, RecordJob("any", eval, ("1 / 0",), int)], Cache(None), 2)
