"""Limits of a shaft by makers' pages, a beam's vibration and the load's path; modified life by the standard and SKF."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import scene_tables
from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.rating import catalogue_checks, iso_lives
from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.life import basic_rating_life
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Motion, Operation, Support

ENDS = [("fixed", "free"), ("supported", "supported"), ("fixed", "supported"), ("fixed", "fixed")]
FIXED = tuple((name, 0.0) for name in ("ux", "uy", "rx", "ry"))


def test_star_s_worked_example():
    """RE 83 301/12.99, p. 97: 63 x 10, free length 2.4 m, fixed and supported: 360 kN, of which half is allowed."""
    assert 1e-3 * catalogue_checks.buckling_load_and_critical_speed(2.4, ("fixed", "supported"), 56.5e-3, 0.0, 210e9)[
        0
    ] == pytest.approx(360.0, rel=0.01)


@pytest.mark.parametrize(("ends", "printed"), list(zip(ENDS, (2.6, 10.2, 20.4, 40.6), strict=True)))
def test_star_s_factors_of_the_buckling_load(ends, printed):
    """f_Fk of F = f_Fk d^4/l^2 10^4 N in mm, the same page."""
    assert 1e-4 * catalogue_checks.buckling_load_and_critical_speed(1.0, ends, 1e-3, 0.0, 210e9)[0] * 1e6 == pytest.approx(
        printed, abs=0.12
    )


@pytest.mark.parametrize(("ends", "printed"), list(zip(ENDS, (3.4, 9.7, 15.1, 21.9), strict=True)))
def test_thk_s_factors_of_the_critical_speed(ends, printed):
    """lambda_2 of 0.8 n_c = lambda_2 d/l^2 10^7 rpm in mm, 513-1E, A15-32."""
    critical = catalogue_checks.buckling_load_and_critical_speed(1.0, ends, 1e-3, 0.0, 206e9)[1] * 30.0 / pi
    assert 0.8 * critical * 1e6 * 1e-7 == pytest.approx(printed, abs=0.06)


def test_thk_s_worked_example_of_a_high_speed_transfer():
    """General catalogue, A-744 and A-745: roots of 17.5 and 26.4 mm, 1.1 m; half the buckling load 15,500 N, 0.8 n_c 2180
    and 3294 rpm; a DN of 70,000 allows 3370 rpm of pitch diameter 20.75 mm, 2240 of 31.25."""
    assert 0.5 * catalogue_checks.buckling_load_and_critical_speed(1.1, ("fixed", "fixed"), 17.5e-3, 0.0, 206e9)[
        0
    ] == pytest.approx(15500.0, rel=3e-3)
    for root, printed in ((17.5e-3, 2180.0), (26.4e-3, 3294.0)):
        critical = (
            catalogue_checks.buckling_load_and_critical_speed(1.1, ("fixed", "supported"), root, 0.0, 206e9)[1] * 30.0 / pi
        )
        assert 0.8 * critical == pytest.approx(printed, rel=2e-3)
    s = scene("unseen-16x5")
    result = run_model(s, "lin", ModelOptions(estimate_beam_mesh_error=False))
    ends = (Support(0.0, FIXED), Support(0.05, FIXED))  # so short that it cannot whirl
    for across, printed in ((20.75e-3, 3370.0), (31.25e-3, 2240.0)):
        of = replace(
            s, supports=ends, track=replace(s.track, pitch_radius=0.5 * across), motion=Motion(printed * pi / 30.0)
        )
        limits = catalogue_checks.shaft_limits(replace(of, operation=Operation(dn_limit=70e3)), result)
        assert limits.allowed_speed * 30.0 / pi == pytest.approx(printed, rel=2e-3)
        assert limits.dn / (1e-3 * pi / 30.0) == pytest.approx(70e3, rel=2e-3)


def test_misumi_s_worked_example():
    """Economy Series 2025, page 1676: 15 x 5, root 12.5 mm, 820 mm, fixed and supported: 3630 N are allowed."""
    assert 0.5 * catalogue_checks.buckling_load_and_critical_speed(0.82, ("fixed", "supported"), 12.5e-3, 0.0, 206e9)[
        0
    ] == pytest.approx(3630.0, rel=3e-3)


@pytest.mark.parametrize("ends", ENDS)
def test_a_beam_of_elements_whirls_and_buckles_there(ends):
    """Cubic beam elements of the same bar: lowest frequency and buckling load."""
    n, length, root, bore = 24, 1.3, 20e-3, 6e-3
    EI, mass = 210e9 * pi / 64.0 * (root**4 - bore**4), 7850.0 * pi / 4.0 * (root**2 - bore**2)
    h = length / n
    k = EI / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    k = np.vstack([k, -k[0], [EI / h**3 * x for x in (6 * h, 2 * h**2, -6 * h, 4 * h**2)]])
    rows = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]]
    rows += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]
    m = mass * h / 420.0 * np.array(rows)
    stress = [[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -(h**2)]]
    g = np.array([*stress, [-x for x in stress[0]], [3 * h, -(h**2), -3 * h, 4 * h**2]]) / (30.0 * h)
    K, M, G = (np.zeros((2 * n + 2, 2 * n + 2)) for _ in range(3))
    for e in range(n):
        at = np.s_[2 * e : 2 * e + 4]
        for whole, part in ((K, k), (M, m), (G, g)):
            whole[at, at] += part
    held = {"fixed": (0, 1), "supported": (0,), "free": ()}
    fixed = [*held[ends[0]], *(2 * n + i for i in held[ends[1]])]
    free = np.setdiff1d(np.arange(2 * n + 2), fixed)
    K, M, G = (x[np.ix_(free, free)] for x in (K, M, G))
    load, speed = catalogue_checks.buckling_load_and_critical_speed(length, ends, root, bore, 210e9)
    assert speed == pytest.approx(sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real.min()), rel=1e-3)
    exact = 1.0 / np.linalg.eigvals(np.linalg.solve(K, G)).real.max()
    assert load == pytest.approx(exact, rel=0.025 if ends == ("fixed", "supported") else 1e-3)


def test_holding_is_read_from_the_supports():
    s = scene("unseen-16x5")
    ends = (Support(0.0, FIXED), Support(s.screw.length, FIXED[:2]))
    assert catalogue_checks.free_lengths_with_supports(replace(s, supports=ends)) == [
        (s.screw.length, ("fixed", "supported"))
    ]
    three = replace(s, supports=(*ends, Support(0.1, FIXED)))
    assert [x[1] for x in catalogue_checks.free_lengths_with_supports(three)] == [
        ("fixed", "supported"),
        ("supported", "supported"),
    ]
    assert catalogue_checks.free_lengths_with_supports(replace(s, supports=ends[:1])) == [
        (s.screw.length, ("fixed", "free"))
    ]
    assert catalogue_checks.shaft_limits(replace(s, supports=ends[1:]), run_model(s, "lin")) is None
    assert all(ends in catalogue_checks.FACTORS for ends in ENDS)


def test_root_is_where_the_arcs_meet():
    s = scene("unseen-16x5")
    slack, angle = s.screw.groove_radius - s.balls.radius, s.track.contact_angle
    r = 0.5 * catalogue_checks.root_diameter(s) - s.track.pitch_radius
    assert np.hypot(r - slack * np.cos(angle), slack * np.sin(angle)) == pytest.approx(s.screw.groove_radius)
    assert 0.7 * s.screw.outer_diameter < catalogue_checks.root_diameter(s) < s.screw.outer_diameter


def test_only_what_presses_counts():
    """The load at the low end presses the shaft up to the nut, pulls it the other way round, and warns beyond half."""
    s = scene("unseen-16x5")
    options = ModelOptions(estimate_beam_mesh_error=False)
    pushed, pulled = (replace(s, loads=(replace(s.loads[0], at=0.0, force=(0.0, 0.0, f)),)) for f in (1500.0, -1500.0))
    assert catalogue_checks.shaft_compression(pushed, run_model(pushed, "lin", options)) == pytest.approx(1500.0, rel=1e-6)
    assert catalogue_checks.shaft_compression(pulled, run_model(pulled, "lin", options)) == pytest.approx(0.0, abs=1e-6)
    limits = catalogue_checks.shaft_limits(replace(pushed, motion=Motion(600.0)), run_model(pushed, "lin", options))
    assert limits.dn == pytest.approx(2.0 * s.track.pitch_radius * 600.0)
    assert [w.kind for w in limits.warnings] == ["speed"]
    slender = replace(limits, buckling=2900.0, allowed_load=1450.0, speed=None)
    assert [w.kind for w in slender.warnings] == ["buckling"]


# --- modified life

A_1 = {90: 1, 95: 0.64, 96: 0.55, 97: 0.47, 98: 0.37, 99: 0.25, 99.2: 0.22, 99.4: 0.19, 99.6: 0.16, 99.8: 0.12}
A_1 |= {99.9: 0.093, 99.92: 0.087, 99.94: 0.080, 99.95: 0.077}


@pytest.mark.parametrize(("share", "printed"), list(A_1.items()))
def test_reliability_by_the_standard_s_table(share, printed):
    """ISO 281:2007, Table 12."""
    assert iso_lives.reliability_factor(share) == pytest.approx(printed, abs=0.0051 if share < 99.9 else 0.00051)


def test_lubricant_factor_is_continuous_and_bounded():
    for kappa in (0.4, 1.0, 4.0):
        for thrust in (False, True):
            below, above = (
                iso_lives.life_factor_for_lubrication(kappa * f, 0.2, is_thrust_bearing=thrust)
                for f in (1.0 - 1e-9, 1.0 + 1e-9)
            )
            assert below == pytest.approx(above, rel=3e-3)
    assert iso_lives.life_factor_for_lubrication(0.1, 5.0) == pytest.approx(0.1, rel=1e-2)
    assert iso_lives.life_factor_for_lubrication(1.0, 0.0) == pytest.approx(0.1)
    assert iso_lives.life_factor_for_lubrication(4.0, 1.0) == iso_lives.life_factor_for_lubrication(40.0, 1.0) == 50.0
    assert iso_lives.life_factor_for_lubrication(2.0, 0.3, is_thrust_bearing=True) == pytest.approx(
        iso_lives.life_factor_for_lubrication(2.0, 0.1)
    )


def test_skf_s_two_values_of_one_bearing_follow_with_one_fatigue_limit():
    """6309, class Explorer: 8 at kappa 2.45 and 0.107 (catalogue), 20.7 at 2.08 and 0.55 x 1.34/4 (calculator)."""
    scale = 1.22
    assert iso_lives.life_factor_for_lubrication(2.45, scale * 0.107) == pytest.approx(8.0, abs=0.5)
    assert iso_lives.life_factor_for_lubrication(2.08, scale * 0.55 * 1.34 / 4.0) == pytest.approx(20.7, rel=0.02)


def test_fatigue_limit_is_the_load_of_1500_mpa():
    s = scene("unseen-four-point")
    assert iso_lives.fatigue_load_limit(s) == pytest.approx(static_rating(s) / 22.0)
    screw = scene("unseen-16x5")
    each = iso_lives.fatigue_load_limit(screw) / (
        screw.ball_count * np.sin(np.radians(45.0)) * np.cos(lead_angle(screw.track))
    )
    assert hertz_without_errors(screw).pressure(np.full(4, each)).max() == pytest.approx(1.5e9)


def test_modified_life_multiplies():
    s = scene("unseen-16x5")
    load = run_model(s, "lin", ModelOptions(estimate_beam_mesh_error=False)).load
    base = basic_rating_life(s, load)
    assert iso_lives.modified_life(s, base) is None
    of = Operation(reliability=95.0, viscosity_ratio=1.5, contamination=0.6)
    found = iso_lives.modified_life(replace(s, operation=of), base)
    expected = iso_lives.life_factor_for_lubrication(
        1.5, 0.6 * iso_lives.fatigue_load_limit(s) / base.equivalent, is_thrust_bearing=True
    )
    assert found.a_iso == pytest.approx(expected)
    assert found.revolutions == pytest.approx(iso_lives.reliability_factor(95.0) * expected * base.revolutions)
    alone = iso_lives.modified_life(replace(s, operation=Operation(reliability=99.0)), base)
    assert (alone.a_iso, alone.revolutions) == (None, pytest.approx(iso_lives.reliability_factor(99.0) * base.revolutions))


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"contamination": 0.5}, "operation.contamination"),
        ({"viscosity_ratio": 1.5}, "operation.viscosity_ratio"),
        ({"viscosity_ratio": 0.05, "contamination": 0.5}, "operation.viscosity_ratio"),
        ({"reliability": 50}, "operation.reliability"),
        ({"contamination": 2, "viscosity_ratio": 1}, "operation.contamination"),
        ({"dn_limit": 3}, "operation.dn_limit"),
    ],
)
def test_keys_are_refused(given, key):
    import tomllib

    tables = tomllib.loads(scene("unseen-16x5").to_toml()) | {"operation": given}
    with pytest.raises(InputError) as refused:
        scene_tables.scene_from_tables(tables, "mine.toml")
    assert refused.value.key == key
