"""Report's section on friction in a ball screw, stability of friction, run times: entries, verdicts, data."""

from functools import cache

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.section_items import drawn, figures, tables
from tests.sources.entries import found

from rollbench.compare.cases.lin import extremes
from rollbench.compare.cases.lin.evidence import screw
from rollbench.compare.cases.lin.extremes import BALLS, ExtremeGroup
from rollbench.compare.cases.lin.pages import friction
from rollbench.lowfi.as_source.screw import simulate_by_root
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain
from rollbench.reports.content import Section

pytestmark = [pytest.mark.xdist_group(GROUP), pytest.mark.slow]


@pytest.fixture(scope="module")
def section() -> Section:
    """The section, with the first 15 of the 200 steps by the source's rule of contact, and with each fifth of the varied
    assumptions of the whole screw's run and each fourth oversize of two balls: these take most of its time."""
    varied = screw.simulation_input_variations()[::5]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(screw, "simulate_by_root", lambda run: simulate_by_root(run, 15))
        patch.setattr(screw, "simulation_input_variations", lambda: varied)
        patch.setattr(screw, "OVERSIZE", screw.OVERSIZE[::4])
        patch.setattr(screw, "pair_results_over_oversize", cache(screw.pair_results_over_oversize.__wrapped__))
        return friction.screw_section(STUDY, lambda _: None)


@pytest.fixture(scope="module")
def records() -> list[ExtremeGroup]:
    """The report's table but for chains of 10 to 200 balls (below: the longest once), from fewer random starts and for each
    second value of what is varied."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("BALLS", (2, 5)), ("CHAIN_STARTS", 1), ("STARTS", 3)):
            patch.setattr(extremes, name, value)
        for name in ("ANGLES", "MU", "LOADS", "RHO", "CLEARANCE", "SMALL"):
            patch.setattr(extremes, name, getattr(extremes, name)[::2])
        return extremes.solve_all_extreme_groups()


def test_both_readings_stand_side_by_side(section):
    """Errors belong to the plain reading; the inferred one is labelled and has its own."""
    of = [found(f"lin-3.7:{kind}_{case}") for kind in ("force", "increase") for case in "ab"]
    assert [f.value for f in of] == pytest.approx([0.98316, 1.29143, 37.855, 49.858], rel=2e-4)
    assert [f.reading for f in of] == pytest.approx([1.9615, 2.9468, 39.369, 60.176], rel=2e-4)
    rows = tables(section)["friction-readings"].rows
    assert all(r["status"] == "converged" for r in rows)
    by_kind = {r["interpretation"]: r for r in rows}
    assert by_kind["plain"]["ball_load_at", "2"] < 0.6 * by_kind["inferred"]["ball_load_at", "2"]


def test_whole_runs_the_parts_of_their_torque_and_what_the_first_step_makes_without_oversize(section):
    rows = tables(section)["friction-run-sensitivity"].rows
    assert all(len(set(r["time_steps_converged"].split(" of "))) == 1 for r in rows)
    assert [rows[k]["torque_ratio"] for k in (0, 1)] == pytest.approx([20.66, 80.47], abs=0.03), "limits of fine steps"
    assert all(r["angle_of_largest_ratio"] is None for r in rows if r["torque_ratio"] == 0.0)
    figure = next(f for f in figures(section) if f.name == "friction-run")
    for panel in [p for p in figure.panels if p.title.startswith("torque")]:
        groove, ball, total = (np.array(s.y) for s in panel.series)
        np.testing.assert_allclose(groove + ball, total, rtol=1e-12)
        assert ball.max() > 0.0
        assert 1.99 <= panel.series[0].x[-1] < 2.0
    loose = screw.simulate_screw_without_oversize()
    assert screw.summarise_screw_run(loose).groove_variation > 0.3
    assert screw.groove_torque_variation(loose) < 0.08


def test_figures_have_data_and_can_be_drawn(section):
    drawn(figures(section))


def test_ours_has_no_failure_and_unique_answers_and_solves_long_chains(records):
    """Chains of 200 balls of a linear bearing take a minute: they are in the report, 100 balls in property tests."""
    for r in records:
        assert r.ours == r.tries > 0, r
        assert max(r.energy, r.spread) < 1e-8, r
    linear, unloaded = (solve_motion_of_chain(extremes.random_linear_balls(50, 0.5, unloaded=x)) for x in (False, True))
    screws = solve_motion_of_chain(extremes.random_screw_balls(max(BALLS)))
    for long in (linear, unloaded, screws):
        assert long.converged
        assert long.input_power == pytest.approx(long.loss, rel=1e-8)


def test_stored_counts_of_root_finding_are_of_the_groups(records):
    """Every count stands in a row, and every row but that of whole bearings has one; chains are shorter here."""
    counts, found = extremes.root_finding_counts(), {(r.group, r.model, r.note) for r in records}
    assert all("200 balls" in model for _, model, _ in counts.keys() - found)
    assert all("2, 5 balls" in model or model.startswith("four-point") for _, model, _ in found - counts.keys())
    assert sum(c.solved for c in counts.values()) < 0.7 * sum(c.tries for c in counts.values())
    printed = [c.solved < c.tries for key, c in counts.items() if key[1] == "rotary, cases I to III as printed"]
    assert printed == 6 * [True]
