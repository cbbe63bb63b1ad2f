"""How the source's way enters bench and stability table: same answers or no ratio, failures and overlaps counted."""

import numpy as np
import pytest

from rollbench.compare.sources.lin import bench as friction_bench
from rollbench.compare.sources.lin.bench import FrictionJob, against_source
from rollbench.lowfi.friction.as_source.chain import SourceMotion

pytestmark = pytest.mark.xdist_group("ways of the source")


def motion(force, status) -> SourceMotion:
    n = len(force) + 1
    zero = np.zeros((n, 3))
    return SourceMotion(zero, zero, np.array(force), np.zeros((n, 4)), np.zeros(n - 1), 0.0, 1, status)


def test_ratio_only_for_the_same_answer():
    ours = np.array([2.0, 1.0])
    ratio, words = against_source(1e-9, lambda: motion([2.0, 1.0], "exact"), ours, 1)
    assert ratio > 1.0
    assert words.startswith("the source's root finding")
    for force, status, reason in (
        ([2.0, 1.0], "failed", "fails"),
        ([0.0, 1.0], "overlapping", "off by up to 100% of the largest"),
        ([1.5, 1.0], "exact", "ends 0.5 N off"),
    ):
        ratio, words = against_source(1e-9, lambda f=force, s=status: motion(f, s), ours, 1)
        assert ratio is None
        assert reason in words


@pytest.fixture(scope="module")
def rows() -> dict[str, FrictionJob]:
    # medians: one slow timing beside other work does not count
    return {r.name: r for group in (friction_bench.linear_jobs, friction_bench.pair_jobs) for r in group(3)}


def test_pairs_and_chains_have_ratios_where_the_source_finds_the_answer(rows):
    linear = {f"linear {name}" for name in ("pair, given loads", "pair, all of it", "chain, 5 balls")}
    for name in linear | {"screw pair, inferred reading", "screw pair, plain reading"}:
        assert rows[name].ratio > 1.0, name
        assert "ratio: the source's root finding" in rows[name].note
    assert rows["linear chain, 20 balls"].ratio is None
    assert "overlap" in rows["linear chain, 20 balls"].note
    assert "0.74 s on another machine" in rows["linear pair, all of it"].note
    assert all("15.3 s on another machine" in r.note for r in rows.values() if r.name.startswith("screw pair"))
    assert "from the solution" in rows["screw pair, plain reading"].note
    assert "from the solution" not in rows["screw pair, inferred reading"].note
