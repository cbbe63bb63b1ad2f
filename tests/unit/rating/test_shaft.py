"""Limits of a shaft by makers' pages, a beam's vibration and the load's path; modified life by the standard and SKF;
overall coefficients of calculators in place of that of sliding contacts."""

import tomllib
from dataclasses import replace
from itertools import product
from math import atan, cos, cosh, pi, sin, sinh, sqrt, tan

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.axes import one_set

from rollbench.compare.errors import InputError
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue, scene_tables
from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.rating import catalogue_checks, iso_lives
from rollbench.lowfi.rating.catalogue_checks import buckling_load_and_critical_speed
from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.iso_lives import life_factor_for_lubrication
from rollbench.lowfi.rating.life import basic_rating_life
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Friction, Motion, Operation, Support, Track

ENDS = [("fixed", "free"), ("supported", "supported"), ("fixed", "supported"), ("fixed", "fixed")]
FIXED = tuple((name, 0.0) for name in ("ux", "uy", "rx", "ry"))
OPTIONS = ModelOptions(estimate_beam_mesh_error=False)


#: Half the load at which shafts of a length, a root and ends buckle [N], as makers print it: STAR, RE 83 301/12.99, p. 97;
#: THK, general catalogue, A-744; MISUMI, Economy Series 2025, p. 1676.
HALF_LOADS = [
    (2.4, ("fixed", "supported"), 56.5e-3, 210e9, 180e3, 0.01),
    (1.1, ("fixed", "fixed"), 17.5e-3, 206e9, 15500.0, 3e-3),
    (0.82, ("fixed", "supported"), 12.5e-3, 206e9, 3630.0, 3e-3),
]


@pytest.mark.parametrize(("length", "ends", "root", "young", "printed", "close"), HALF_LOADS, ids=["STAR", "THK", "MISUMI"])
def test_buckling_loads_of_makers_worked_examples(length, ends, root, young, printed, close):
    assert 0.5 * buckling_load_and_critical_speed(length, ends, root, 0.0, young)[0] == pytest.approx(printed, rel=close)


#: By ends, f_Fk of the load f_Fk d^4/l^2 10^4 N (STAR, the same page) and lambda_2 of 0.8 n_c = lambda_2 d/l^2 10^7 rpm
#: (THK 513-1E, A15-32), in mm.
FACTORS = list(zip(ENDS, (2.6, 10.2, 20.4, 40.6), (3.4, 9.7, 15.1, 21.9), strict=True))


@pytest.mark.parametrize(("ends", "of_load", "of_speed"), FACTORS)
def test_makers_factors_of_buckling_load_and_critical_speed(ends, of_load, of_speed):
    load, _ = buckling_load_and_critical_speed(1.0, ends, 1e-3, 0.0, 210e9)
    assert 1e-4 * load * 1e6 == pytest.approx(of_load, abs=0.12)
    _, critical = buckling_load_and_critical_speed(1.0, ends, 1e-3, 0.0, 206e9)
    assert 0.8 * critical * 30.0 / pi * 1e6 * 1e-7 == pytest.approx(of_speed, abs=0.06)


def test_thk_s_worked_example_of_a_high_speed_transfer():
    """General catalogue, A-744 and A-745: roots of 17.5 and 26.4 mm, 1.1 m: 0.8 n_c 2180 and 3294 rpm; a DN of 70,000
    allows 3370 rpm of pitch diameter 20.75 mm, 2240 of 31.25."""
    for root, printed in ((17.5e-3, 2180.0), (26.4e-3, 3294.0)):
        _, critical = buckling_load_and_critical_speed(1.1, ("fixed", "supported"), root, 0.0, 206e9)
        assert 0.8 * critical * 30.0 / pi == pytest.approx(printed, rel=2e-3)
    ends = (Support(0.0, FIXED), Support(0.05, FIXED))  # so short that it cannot whirl
    s = replace(scene("unseen-16x5"), supports=ends, operation=Operation(dn_limit=70e3))
    result = run_model(scene("unseen-16x5"), "lin", OPTIONS)
    for across, printed in ((20.75e-3, 3370.0), (31.25e-3, 2240.0)):
        of = replace(s, track=replace(s.track, pitch_radius=0.5 * across), motion=Motion(printed * pi / 30.0))
        limits = catalogue_checks.shaft_limits(of, result)
        assert limits.allowed_speed * 30.0 / pi == pytest.approx(printed, rel=2e-3)
        assert limits.dn / (1e-3 * pi / 30.0) == pytest.approx(70e3, rel=2e-3)


#: What vanishes, in the order of ENDS, at k l of the lowest vibration of a bar and of its buckled shape, and between where.
VIBRATION = [
    (lambda x: cos(x) * cosh(x) + 1.0, 1.0, 3.0),
    (sin, 2.0, 4.0),
    (lambda x: sin(x) * cosh(x) - cos(x) * sinh(x), 3.0, 5.0),
    (lambda x: cos(x) * cosh(x) - 1.0, 4.0, 6.0),
]
BUCKLING = [(cos, 1.0, 2.0), (sin, 2.0, 4.0), (lambda x: sin(x) - x * cos(x), 4.0, 5.0), (lambda x: sin(0.5 * x), 5.0, 7.0)]


@pytest.mark.parametrize(("ends", "vibration", "buckling"), list(zip(ENDS, VIBRATION, BUCKLING, strict=True)))
def test_a_slender_bar_whirls_and_buckles_there(ends, vibration, buckling):
    """The bar's own equations: E I v'''' = rho A w^2 v, E I v'''' = -F v''."""
    length, root, bore = 1.3, 20e-3, 6e-3
    EI, mass = 210e9 * pi / 64.0 * (root**4 - bore**4), 7850.0 * pi / 4.0 * (root**2 - bore**2)
    load, speed = buckling_load_and_critical_speed(length, ends, root, bore, 210e9)
    assert speed == pytest.approx((brentq(*vibration) / length) ** 2 * sqrt(EI / mass), rel=1e-3)
    close = 0.025 if ends == ("fixed", "supported") else 1e-3  # makers round the factor to 2
    assert load == pytest.approx(EI * (brentq(*buckling) / length) ** 2, rel=close)


def test_holding_is_read_from_the_supports():
    s = scene("unseen-16x5")
    ends = (Support(0.0, FIXED), Support(s.screw.length, FIXED[:2]))
    length, middle = s.screw.length, (("fixed", "supported"), ("supported", "supported"))
    for supports, expected in (
        (ends, [(length, ("fixed", "supported"))]),
        (ends[:1], [(length, ("fixed", "free"))]),
        ((*ends, Support(0.1, FIXED)), [(0.1, middle[0]), (length - 0.1, middle[1])]),
    ):
        assert catalogue_checks.free_lengths_with_supports(replace(s, supports=supports)) == expected
    assert catalogue_checks.shaft_limits(replace(s, supports=ends[1:]), run_model(s, "lin")) is None


def test_root_is_where_the_arcs_meet():
    s = scene("unseen-16x5")
    slack, angle = s.screw.groove_radius - s.balls.radius, s.track.contact_angle
    r = 0.5 * catalogue_checks.root_diameter(s) - s.track.pitch_radius
    assert np.hypot(r - slack * np.cos(angle), slack * np.sin(angle)) == pytest.approx(s.screw.groove_radius)
    assert 0.7 * s.screw.outer_diameter < catalogue_checks.root_diameter(s) < s.screw.outer_diameter


def test_only_what_presses_counts():
    """The load at the low end presses the shaft up to the nut, pulls it the other way round, and warns beyond half."""
    s = scene("unseen-16x5")
    pushed, pulled = (replace(s, loads=(replace(s.loads[0], at=0.0, force=(0.0, 0.0, f)),)) for f in (1500.0, -1500.0))
    result = run_model(pushed, "lin", OPTIONS)
    assert catalogue_checks.shaft_compression(pushed, result) == pytest.approx(1500.0, rel=1e-6)
    assert catalogue_checks.shaft_compression(pulled, run_model(pulled, "lin", OPTIONS)) == pytest.approx(0.0, abs=1e-6)
    limits = catalogue_checks.shaft_limits(replace(pushed, motion=Motion(600.0)), result)
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
    for kappa, thrust in product((0.4, 1.0, 4.0), (False, True)):
        both = (kappa * (1.0 - 1e-9), kappa * (1.0 + 1e-9))
        below, above = (life_factor_for_lubrication(x, 0.2, is_thrust_bearing=thrust) for x in both)
        assert below == pytest.approx(above, rel=3e-3)
    assert life_factor_for_lubrication(0.1, 5.0) == pytest.approx(0.1, rel=1e-2)
    assert life_factor_for_lubrication(1.0, 0.0) == pytest.approx(0.1)
    assert life_factor_for_lubrication(4.0, 1.0) == life_factor_for_lubrication(40.0, 1.0) == 50.0
    radial = life_factor_for_lubrication(2.0, 0.1)
    assert life_factor_for_lubrication(2.0, 0.3, is_thrust_bearing=True) == pytest.approx(radial)


def test_skf_s_two_values_of_one_bearing_follow_with_one_fatigue_limit():
    """6309, class Explorer: 8 at kappa 2.45 and 0.107 (catalogue), 20.7 at 2.08 and 0.55 x 1.34/4 (calculator)."""
    scale = 1.22
    assert life_factor_for_lubrication(2.45, scale * 0.107) == pytest.approx(8.0, abs=0.5)
    assert life_factor_for_lubrication(2.08, scale * 0.55 * 1.34 / 4.0) == pytest.approx(20.7, rel=0.02)


def test_fatigue_limit_is_the_load_of_1500_mpa():
    s = scene("unseen-four-point")
    assert iso_lives.fatigue_load_limit(s) == pytest.approx(static_rating(s) / 22.0)
    screw = scene("unseen-16x5")
    axial_share = np.sin(np.radians(45.0)) * np.cos(lead_angle(screw.track))
    each = iso_lives.fatigue_load_limit(screw) / (screw.ball_count * axial_share)
    assert hertz_without_errors(screw).pressure(np.full(4, each)).max() == pytest.approx(1.5e9)


def test_modified_life_multiplies():
    s = scene("unseen-16x5")
    base = basic_rating_life(s, run_model(s, "lin", OPTIONS).load)
    assert iso_lives.modified_life(s, base) is None
    of = Operation(reliability=95.0, viscosity_ratio=1.5, contamination=0.6)
    found = iso_lives.modified_life(replace(s, operation=of), base)
    clean = 0.6 * iso_lives.fatigue_load_limit(s) / base.equivalent_load
    expected = life_factor_for_lubrication(1.5, clean, is_thrust_bearing=True)
    assert found.a_iso == pytest.approx(expected)
    assert found.revolutions == pytest.approx(iso_lives.reliability_factor(95.0) * expected * base.revolutions)
    alone = iso_lives.modified_life(replace(s, operation=Operation(reliability=99.0)), base)
    assert (alone.a_iso, alone.revolutions) == (None, pytest.approx(iso_lives.reliability_factor(99.0) * base.revolutions))


#: Tables that are refused, by the key that is named.
REFUSED = [
    ("contamination", {"contamination": 0.5}),
    ("viscosity_ratio", {"viscosity_ratio": 1.5}),
    ("viscosity_ratio", {"viscosity_ratio": 0.05, "contamination": 0.5}),
    ("reliability", {"reliability": 50}),
    ("contamination", {"contamination": 2, "viscosity_ratio": 1}),
    ("dn_limit", {"dn_limit": 3}),
]


@pytest.mark.parametrize(("key", "given"), REFUSED)
def test_keys_are_refused(key, given):
    tables = tomllib.loads(scene("unseen-16x5").to_toml()) | {"operation": given}
    with pytest.raises(InputError) as refused:
        scene_tables.scene_from_tables(tables, "mine.toml")
    assert refused.value.key == f"operation.{key}"


TRACK = Track(16.5e-3, 20e-3, pi / 4.0)


def test_the_efficiency_of_a_calculator() -> None:
    """Pitch circle 33 mm, lead 20 mm, f 0.01: a public sheet has 0.9484; without friction nothing is lost."""
    found, phi = catalogue_checks.efficiency_by_overall_friction(TRACK, 0.01), atan(20.0 / (33.0 * pi))
    assert found == pytest.approx(0.9484, abs=1e-3)
    assert found == pytest.approx(tan(phi) / tan(phi + 0.01), rel=1e-5)
    assert catalogue_checks.efficiency_by_overall_friction(TRACK, 0.0) == 1.0


def test_low_coefficients_are_met_by_a_warning_and_a_ring_s_without_an_efficiency() -> None:
    for given, warned in (((0.01, 0.01), 1), ((0.003, 0.003), 1), ((0.1, 0.1), 0), ((0.01, 0.05), 0)):
        assert len(catalogue_checks.warn_of_overall_friction_coefficient(TRACK, Friction(*given))) == warned, given
    (found,) = catalogue_checks.warn_of_overall_friction_coefficient(Track(20e-3, 0.0, 0.0), Friction(0.0015, 0.0015))
    assert "efficiency" not in found


def test_bearing_pairs_clamp_the_shaft_of_an_axis():
    """Pairs at 35 and 865 mm. Half of the load presses the part on the right; the preload within a pair does not count."""
    axis = catalogue.scene_of_any_kind("axis-fixed-fixed")
    nut = axis.sets[0].parts
    ((length, ends),) = catalogue_checks.free_lengths_with_supports(axis)
    assert (length, ends) == (pytest.approx(0.83), ("fixed", "fixed"))
    result = run_model(axis, "lin")
    force = {s.of.name: s.force[2] for s in result.sets}
    right = -force["right, inner row"] - force["right, outer row"]
    assert 1400.0 < right < 1600.0
    limits = catalogue_checks.shaft_limits(axis, result, nut)
    assert limits.compression == pytest.approx(right, rel=1e-9)
    load, _ = buckling_load_and_critical_speed(length, ends, catalogue_checks.root_diameter(nut), 0.0, 210e9)
    assert limits.buckling == pytest.approx(load, rel=0.02)  # the screw's own modulus
    single = replace(axis, sets=tuple(s for s in axis.sets if "outer" not in s.name))
    ((span, kinds),) = catalogue_checks.free_lengths_with_supports(single)
    assert (span, kinds) == (pytest.approx(0.815), ("supported", "supported"))
    loose = replace(axis, sets=axis.sets[:3])
    ((reach, kinds),) = catalogue_checks.free_lengths_with_supports(loose)
    assert (reach, kinds) == (pytest.approx(axis.screw.length - 0.035), ("fixed", "free"))


def test_one_set_on_a_shaft_has_the_limits_of_the_scene():
    s = scene("unseen-16x5")
    s = replace(s, loads=(replace(s.loads[0], at=0.0, force=(0.0, 0.0, 1500.0)),), motion=Motion(60.0))
    axis = replace(one_set(s), motion=s.motion)
    one = catalogue_checks.shaft_limits(axis, run_model(axis, "lin"), s)
    assert one == replace(catalogue_checks.shaft_limits(s, run_model(s, "lin", OPTIONS)), compression=one.compression)
    assert one.compression == pytest.approx(1500.0, rel=1e-9)
