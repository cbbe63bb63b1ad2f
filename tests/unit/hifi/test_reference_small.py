"""Statics of the 3D reference on two balls: balance, symmetry, errors, rounds that settle and those that do not."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.shipped_texts import own_text
from tests.two_balls import SMALL

from rollbench.comparison.scenes import catalogue
from rollbench.hifi import coupling, reference, setup
from rollbench.hifi.bodies import submodel
from rollbench.hifi.contact import balls
from rollbench.meshes.parts import FourierTerm, Load, SideErrors, Support

pytestmark = pytest.mark.xdist_group("helped by processes")


def test_a_screw_without_its_3d_shaft_does_not_depend_on_which_flanks_bear(small):
    """The same bodies with their flanks named SR and NL."""
    named = {
        "screw": replace(small.screw, modes={1: small.screw.modes[0]}),
        "nut": replace(small.nut, modes={2: small.nut.modes[3]}),
    }
    other = replace(small, sides=(1, 2), **named)
    one, two = (coupling.mounted_screw(s, small.scene, frozenset({"3D shaft"})) for s in (small, other))
    np.testing.assert_array_equal(one.G, two.G)
    shaft = coupling.mounted_screw(small, small.scene).G
    assert one.G.shape == shaft.shape
    assert not np.allclose(one.G, shaft, rtol=1e-6, atol=0.0)


def test_balance_and_no_force_along_the_groove(small):
    result = reference.solve_reference(small, small.scene)
    assert result.status == "converged"
    assert result.balance < 1e-8
    assert abs(result.along_groove) < 1e-3
    assert result.screw_balance < 1e-8
    m = small.map
    axial = result.load[:, 0] @ np.sin(result.contact_angle[:, 0]) * np.cos(m.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)
    assert (result.load[:, [1, 2]] == 0.0).all()


def test_a_helical_motion_of_the_screw_changes_no_load(small):
    """A screw that is turned by 2 mrad and free to follow its lead; by linear kinematics its radius would grow by 33 nm."""
    at_rest = reference.solve_reference(small, small.scene)
    first = small.scene.supports[0]
    held = tuple((name, 2e-3 if name == "rz" else value) for name, value in first.fixed)
    turned = replace(small.scene, supports=(replace(first, fixed=held), *small.scene.supports[1:]))
    result = reference.solve_reference(small, turned)
    assert result.status == "converged"
    assert result.updates <= 5  # by the middle of the pressures, which sticks to so few nodes, it were 12
    np.testing.assert_allclose(result.load, at_rest.load, rtol=0, atol=1e-4 * at_rest.load.max())
    across = np.nan_to_num(result.contact_angle - at_rest.contact_angle)
    assert np.abs(across).max() < 1e-4  # a straight step along a curved track: 16 um leave 8 nm of its section
    axial = result.load[:, 0] @ np.sin(result.contact_angle[:, 0]) * np.cos(small.map.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)


def test_loads_that_did_not_settle_say_what_they_may_still_move_by(small):
    """Places of the balls are solved with the loads, so that few rounds settle these."""
    turned = replace(
        small.scene, supports=(Support(0.0, small.scene.supports[0].fixed), Support(60e-3, (("ux", 5e-6), ("uy", 0.0))))
    )
    whole = reference.solve_reference(small, turned)
    assert (whole.status, whole.moving) == ("converged", 0.0)
    assert whole.updates <= 3
    few = reference.solve_reference(small, turned, updates=1)
    assert few.status.startswith("not settled: loads may still move by")
    assert 0.0 < np.abs(few.load - whole.load).max() <= few.moving < np.inf


@pytest.mark.slow
def test_a_command_whose_reference_does_not_settle_says_so_keeps_it_and_ends_with_a_code_of_its_own(
    small, tmp_path, monkeypatch, command
):
    """One update of directions and gaps does not settle these loads."""
    file, store = tmp_path / "two.toml", tmp_path / "store"
    file.write_text(own_text("two-balls-across"))
    monkeypatch.setattr(setup, "prepare", lambda *given, **_: replace(small, settings=given[2]))
    for updates, code in ((1, 5), (reference.ROUNDS, 0)):
        monkeypatch.setitem(reference.solve_reference.__kwdefaults__, "updates", updates)
        ended, found = command.json("compare", file, "--levels", "1", "--fresh", "--store", store, "--json")
        assert ended == code
        (said,) = found["scenes"]
        (kept,) = (json.loads(run.read_text()) for run in store.glob("two-level1-*.json"))
        load, told = np.array(kept["load"]), said["uncertainty"]["discretisation_percent"]
        may_move = 100.0 * kept["moving"] / load[load > 0.0].mean()
        if code:
            assert kept["status"].startswith("not settled: loads may still move by")
            assert said["reference_status"] == f"level 1 {kept['status']}"
            assert told >= may_move > 1.0
        else:
            assert (kept["status"], said["reference_status"], may_move) == ("converged", "converged", 0.0)
            assert told < 1.0


def test_what_is_left_is_the_rest_of_a_geometric_series():
    loads = [np.array([[10.0 - 4.0 * 0.25**k, 5.0]]) for k in range(4)]
    assert reference.left_over(loads[:3]) == pytest.approx(10.0 - loads[2][0, 0])
    assert reference.left_over(loads) == pytest.approx(10.0 - loads[3][0, 0])
    assert reference.left_over(loads[:2]) == pytest.approx(99.0 * 3.0)
    assert reference.left_over(loads[:1]) == np.inf
    assert reference.left_over([loads[0]] * 2) == 0.0


def test_two_opposite_balls_without_lead_carry_the_same(monkeypatch):
    """A ring free to tilt on two opposite balls: statics alone divides the load."""
    monkeypatch.setattr(submodel, "REALISATIONS", 1)
    s = catalogue.scene("bearing-9")
    scene = replace(
        s,
        balls=replace(s.balls, azimuths=(0.0, np.pi)),
        loads=(Load(8e-3, (0.0, 0.0, 600.0)),),
        supports=(Support(8e-3, (("uy", 0.0), ("rx", 0.0), ("rz", 0.0))),),
    )
    ratio = s.balls.radius / 2.778e-3
    settings = replace(
        SMALL,
        semi=(1.0e-3, 0.3e-3),
        reach=(1.0e-3, 0.3e-3),
        fine=3e-3 * ratio,
        coarse=12e-3 * ratio,
        ball_fine=1e-3 * ratio,
        ball_coarse=2e-3 * ratio,
        own_sizes=(3e-3 * ratio, 12e-3 * ratio),
        own_ball_sizes=(1e-3 * ratio, 2e-3 * ratio),
        modes=16,
        ball_modes=16,
    )
    made = setup.prepare(scene, (0, 3), settings)
    result = reference.solve_reference(made, scene)
    assert result.status == "converged"
    load = result.load[:, [0, 3]]
    assert np.ptp(load) < 1e-6 * load.mean()
    assert load.mean() * 2.0 * np.sin(result.contact_angle[0, 0]) == pytest.approx(600.0, rel=5e-3)


def test_what_is_left_out_changes_the_answer_and_a_wrong_name_is_refused(small):
    full = reference.solve_reference(small, small.scene)
    for name in reference.INGREDIENTS:
        other = reference.solve_reference(small, small.scene, leave_out=frozenset([name]))
        assert other.status == "converged"
        assert np.abs(other.load - full.load).max() > 1e-6 * full.load.max(), name
    with pytest.raises(ValueError, match="unknown"):
        reference.solve_reference(small, small.scene, leave_out=frozenset(["elastic ball"]))


def test_ball_errors_and_lost_contact(small):
    errors = replace(small.scene.errors, balls=replace(small.scene.errors.balls, listed=((1, -60e-6),)))
    lost = reference.solve_reference(small, replace(small.scene, errors=errors))
    assert lost.load[0, 0] == 0.0
    assert lost.load[1, 0] > 400.0
    assert np.isnan(lost.contact_angle[0, 0])


def test_a_lead_offset_is_the_pitch_error_of_the_nut_that_shifts_ball_2_alone(small):
    """The groove beyond the nut's centre, at ball 2, by 2 um; against a series that is zero at ball 1."""
    shift, errors = 2e-6, small.scene.errors
    first, second = small.layout.azimuth - small.scene.nut.azimuth
    a, b = np.linalg.solve([[np.sin(x), np.cos(x)] for x in (first, second)], [0.0, shift])
    pitch = SideErrors(pitch=(FourierTerm(1.0, sin=float(a), cos=float(b)),), pitch_along="axis")
    scenes = [
        replace(small.scene, errors=e) for e in (replace(errors, lead_offset=shift), replace(errors, NL=pitch, NR=pitch))
    ]
    found, wanted = (reference.solve_reference(small, s).load for s in scenes)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * wanted.max())
    assert abs(found - reference.solve_reference(small, small.scene).load).max() > 10.0


def test_a_long_solution_tells_its_rounds(small, monkeypatch):
    monkeypatch.setattr(reference, "SLOW", -1.0)
    heard = []
    found = reference.solve_reference(small, small.scene, step=heard.append)
    assert [line.split(", ")[0] for line in heard] == [
        f"contacts of {small.scene.name}: round {k + 1}" for k in range(found.updates + 1)
    ]


def test_frozen_loads_are_found_on_the_way_at_less_than_half_of_their_work(small, monkeypatch):
    """Both solutions have their first round in common, the one that begins from nothing."""
    work = {"factors": 0, "from nothing": 0}
    factor, solve = balls._System.factor, reference.solve_balls

    def factored(*given):
        work["factors"] += 1
        return factor(*given)

    def solved(*given, start, touching):
        work["from nothing"] += start is None
        return solve(*given, start=start, touching=touching)

    monkeypatch.setattr(balls._System, "factor", factored)
    monkeypatch.setattr(reference, "solve_balls", solved)
    moving = reference.solve_reference(small, small.scene)
    alone = work["factors"]
    still = reference.solve_reference(small, small.scene, updates=0)
    again = work["factors"] - alone
    assert work["from nothing"] == 2
    work.update(dict.fromkeys(work, 0))
    found = reference.solve_reference(small, small.scene, frozen=True)
    np.testing.assert_array_equal(found.load, moving.load)
    np.testing.assert_array_equal(found.frozen, still.load)
    assert np.abs(found.frozen - found.load).max() > 1e-6 * found.load.max()
    assert moving.frozen is None
    assert work["from nothing"] == 1
    assert 2 * (work["factors"] - alone) < again
