"""The 3D reference on two balls: parts of its set-up, balance, symmetry, errors, ingredients that are left out, and rounds
that settle or do not."""

import os
from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest
from tests.shipped_texts import own_text
from tests.two_balls import SMALL, two_balls

from rollbench.hifi import reference, setup
from rollbench.hifi.setup import RecordJob, compute_records
from rollbench.meshes.cache import Cache
from rollbench.meshes.parts import FourierTerm, SideErrors, Support

pytestmark = [pytest.mark.xdist_group("helped by processes"), pytest.mark.slow]


def test_balance_and_that_what_is_left_out_changes_the_answer(small):
    """No force acts along the groove; a wrong name is refused."""
    result = reference.solve_reference(small, small.scene)
    assert result.status == "converged"
    assert result.unbalanced_ball_force < 1e-8
    assert abs(result.unbalanced_force_along_groove) < 1e-3
    assert result.unbalanced_shaft_force < 1e-8
    m = small.groove_map
    axial = result.contact_loads[:, 0] @ np.sin(result.contact_angles[:, 0]) * np.cos(m.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)
    assert (result.contact_loads[:, [1, 2]] == 0.0).all()
    for name in reference.INGREDIENTS:
        other = reference.solve_reference(small, small.scene, leave_out=frozenset([name]))
        assert other.status == "converged"
        assert np.abs(other.contact_loads - result.contact_loads).max() > 1e-6 * result.contact_loads.max(), name
    with pytest.raises(ValueError, match="got elastic ball"):
        reference.solve_reference(small, small.scene, leave_out=frozenset(["elastic ball"]))


def test_ball_errors_and_lost_contact(small):
    errors = replace(small.scene.errors, balls=replace(small.scene.errors.balls, listed=((1, -60e-6),)))
    lost = reference.solve_reference(small, replace(small.scene, errors=errors))
    assert lost.contact_loads[0, 0] == 0.0
    assert lost.contact_loads[1, 0] > 400.0
    assert np.isnan(lost.contact_angles[0, 0])


def test_a_lead_offset_is_the_pitch_error_of_the_nut_that_shifts_ball_2_alone(small):
    """The groove beyond the nut's centre, at ball 2, by 2 um; against a series that is zero at ball 1."""
    shift, errors = 2e-6, small.scene.errors
    first, second = small.ball_positions.azimuth - small.scene.nut.azimuth
    a, b = np.linalg.solve([[np.sin(x), np.cos(x)] for x in (first, second)], [0.0, shift])
    pitch = SideErrors(pitch=(FourierTerm(1.0, sin=float(a), cos=float(b)),), pitch_along="axis")
    found, wanted, without = (
        reference.solve_reference(small, replace(small.scene, errors=e)).contact_loads
        for e in (replace(errors, lead_offset=shift), replace(errors, NL=pitch, NR=pitch), errors)
    )
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * wanted.max())
    assert abs(found - without).max() > 10.0


def assert_equal_parts(one, other):
    for name in ("condensed_screw.stretch.F", "condensed_nut.G", "condensed_ball.G"):
        np.testing.assert_array_equal(attrgetter(name)(one), attrgetter(name)(other), err_msg=name)
    for side, pair in one.patches_by_flank.items():
        np.testing.assert_array_equal(pair.local_compliance, other.patches_by_flank[side].local_compliance)


def test_a_prepared_geometry_comes_whole_from_the_cache(small, small_cache):
    """Also what depends on records that came from the cache themselves."""
    again = Cache(small_cache.root)
    found = setup.mesh_and_condense_geometry(two_balls(), (0, 3), SMALL, cache=again)
    assert small_cache.hits == again.misses == 0
    assert small_cache.misses == again.hits > 5
    assert found.seconds_by_stage == pytest.approx(small.seconds_by_stage, rel=0.1)  # of making, not of reading
    assert min(found.seconds_by_stage.values()) > 0.0
    assert_equal_parts(found, small)


def test_a_set_up_in_two_processes_is_the_same(small, small_cache, tmp_path):
    given = small.scene, small.loaded_flanks, replace(SMALL, element="P1", tet=0.35e-3, modes=16, ball_modes=16)
    here = setup.mesh_and_condense_geometry(*given, cache=Cache(small_cache.root))
    shared = setup.mesh_and_condense_geometry(*given, cache=Cache(tmp_path), processes=2)
    assert shared.worker_peak_memory_MB > 100.0
    assert list(shared.seconds_by_stage) == list(here.seconds_by_stage)
    assert_equal_parts(shared, here)
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


def test_loads_that_did_not_settle_say_what_they_may_still_move_by(small):
    """Places of the balls are solved with the loads, so that few rounds settle these."""
    moved = Support(60e-3, (("ux", 5e-6), ("uy", 0.0)))
    turned = replace(small.scene, supports=(Support(0.0, small.scene.supports[0].fixed), moved))
    whole = reference.solve_reference(small, turned)
    assert (whole.status, whole.remaining_load_change) == ("converged", 0.0)
    assert whole.normal_update_count <= 3
    few = reference.solve_reference(small, turned, updates=1)
    assert few.status.startswith("not settled: loads may still move by")
    assert 0.0 < np.abs(few.contact_loads - whole.contact_loads).max() <= few.remaining_load_change < np.inf


@pytest.mark.slow
def test_a_command_whose_reference_does_not_settle_says_so_and_ends_with_a_code_of_its_own(
    small, tmp_path, monkeypatch, command
):
    """One update of directions and gaps does not settle these loads."""
    file, words = tmp_path / "two.toml", ("--levels", "1", "--fresh", "--store", tmp_path / "store", "--json")
    file.write_text(own_text("two-balls-across"))
    monkeypatch.setattr(setup, "mesh_and_condense_geometry", lambda *given, **_: replace(small, mesh_settings=given[2]))
    for updates, code, status in (
        (1, 5, "level 1 not settled: loads may still move by"),
        (reference.ROUNDS, 0, "converged"),
    ):
        monkeypatch.setitem(reference.solve_reference.__kwdefaults__, "updates", updates)
        ended, found = command.json("compare", file, *words)
        assert ended == code
        assert found["scenes"][0]["reference_status"].startswith(status)
