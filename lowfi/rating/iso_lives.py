"""Modified rating life (ISO 281) of bearings and ball screws, and basic reference rating life (ISO/TS 16281) of bearings.

The modified life L_nm = a_1 a_ISO L_10 (ISO 281:2007; of bearings L_nmr = a_1 a_ISO L_10r of ISO/TS 16281) accounts for
reliability, lubricant and contamination. The factor a_1 for the reliability S (90 to 99.95 %) is the three-parameter
Weibull law of ISO/TR 1281-2, which the table of ISO 281 rounds,

    a_1 = 0.95 (ln(1/S)/ln(1/0.9))^(2/3) + 0.05.                                                                        (1)

The factor a_ISO for lubricant and contamination of ball bearings, with x = e_C C_u/P for radial bearings and a third of it
for thrust bearings, is

    a_ISO = 0.1 (1 - (2.5671 - k(kappa))^0.83 x^(1/3))^(-9.3),  at most 50,                                            (2)
    k = 2.2649/kappa^0.054381 (0.1 to 0.4), 1.9987/kappa^0.19087 (0.4 to 1), 1.9987/kappa^0.071739 (1 to 4; beyond as 4).

The fatigue load limit C_u is the load at which the most heavily loaded contact has 1500 MPa. For bearings it is C_0/22 (the
cube of 1500 over 4200 MPa), times (100 mm/D_pw)^(1/2) if the pitch diameter exceeds 100 mm (ISO 281, B.3.3). For a screw it
is the axial load under which all contacts have 1500 MPa. P is the load at which the rating C gives the same L_10.

The modified life is valid for a viscosity ratio kappa above 0.1, mineral oils and greases, and hardened steel. ISO 3408-5
has only a_1 for ball screws. For them, (2) for thrust bearings is used, as their rating has the form of that of a thrust
bearing and P is axial; this is an extension of the standard.

Comparison with published values: a_1 agrees with Table 12 of ISO 281 within its rounding; k is continuous at 0.4 and 1 to
1e-4, and equals 2.5671 at 0.1, where a_ISO is 0.1 under every load. SKF's a_SKF of its class Explorer, 8 and 20.7 for the
bearing 6309 (catalogue "Rolling bearings", example 1; a report of its calculator), agree with (2) if C_u is 1.22 times as
large.

The basic reference life L_10r (ISO/TS 16281:2008) follows from the loads of a bearing's rolling elements. For every raceway
the standard has the load Q_c that a contact bears for 10^6 revolutions, and the dynamic equivalent load
Q_e, a mean over all Z rolling elements. The mean is of order 3 (balls) or 4 (rollers) for the raceway that rotates relative
to the load, that of the ring that turns, and of order 10/3 or 9/2 for the stationary raceway.

Balls: Q_c is that of `lowfi.rating.life` (2), which the standard expresses by C_r,

    L_10r = ((Q_ci/Q_ei)^(-10/3) + (Q_ce/Q_ee)^(-10/3))^(-9/10),   P_ref = C/L_10r^(1/3).                             (3)

This is the life that `lowfi.rating.life.basic_rating_life` returns; for four-point contact the sum includes all four
flanks. If the rating C of a catalogue replaces the computed one, L_10r changes by the cube of their ratio, for rollers by
the fourth power.

Rollers are cut into n_s >= 30 laminae; lamina k of roller j carries q_jk, and at the roller's edges the stress is higher:

    q_c = Q_c n_s^(-7/9),   f_k = 1 - 0.01/ln(1.985 |2 k - n_s - 1|/(2 n_s - 2)),
    q_ek = (sum_j (f_k q_jk)^m/Z)^(1/m),   m = 4 (turning), 9/2 (standing),                                             (4)
    L_10r = (sum_k (q_ci/q_eik)^(-9/2) + (q_ce/q_eek)^(-9/2))^(-8/9),   P_ref = C/L_10r^(3/10).                         (5)

Q_c is here that of `lowfi.rating.roller_life` (1) without the factor lambda (0.83; thrust bearings 0.73), because f_k
accounts for edge stress and non-uniform load. For a uniform load on a straight roller, whose edges are fully loaded,
L_10r = (x P/C)^(-4) with x = lambda (mean of f_k^(9/2))^(2/9). This x depends on the number of laminae: 1.13 for 30, 0.96
for 120, 0.89 in the limit. The standard is therefore meant for profiled rollers: if the edges are unloaded, L_10r does not
depend on n_s.

The line loads come from the static model. The approach of cone and cup is linear along the roller and follows from rigid
motions of both rings, so that a tilt of the rings affects every lamina. A lamina deforms as Hertz's line contacts at both
races in series, in place of the standard's spring of 35948 N/mm^(10/9) L^(8/9), so that the tilt of the roller between the
races is included. If there are fewer than 30 slices, each is divided into equal laminae of the same line load.

The reference life is valid as `lowfi.rating.life` and `roller_life`, if one ring rotates relative to the load. ISO/TS 16281
covers radial and thrust bearings, not screws. Equations (4) and (5) are ISO/TS 16281:2008, (47) to (65), as
github.com/minzhun/ISO16281 implements them; the standard itself was not consulted.

It was compared with lives that MASTA prints for a deep-groove bearing (`external-masta`), and in limiting cases with ISO
281.
"""

from __future__ import annotations

from math import log, pi

import numpy as np

from rollbench.lowfi.rating import life, roller_life
from rollbench.lowfi.rating.contacts import RACES, static_rating
from rollbench.lowfi.rating.life import Life, contact_capacity, is_thrust_bearing
from rollbench.lowfi.rating.rigidity import approach_per_displacement
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Pressure [Pa] up to which clean, well lubricated contacts do not fatigue (ISO 281); ratio C_0/C_u of bearings.
FATIGUE_PRESSURE, STATIC_OVER_FATIGUE = 1.5e9, 22.0

#: Largest a_ISO that the standard permits, and viscosity ratio kappa above which a_ISO does not increase.
MOST, FULL_FILM = 50.0, 4.0


@result_record
class ModifiedLife:
    """Modified rating life of a bearing or ball screw by ISO 281, with its factors."""

    #: Modified rating life L_nm [10^6 revolutions].
    revolutions: float = quantity_field(
        "Lnm_million_revolutions",
        "modified life: a_1 a_ISO times the life by the contact loads, L10 of a nut, L10r of a bearing (L_nmr)",
        error="that of the life by the contact loads, and that of a_ISO by the contamination, which is an estimate",
        heading="modified life",
        note="for {reliability_percent} %",
    )
    #: Reliability for which the life holds [%].
    reliability: float = quantity_field("reliability_percent", "share of screws or bearings that reach the modified life")
    #: Life modification factor a_1 for the reliability.
    a_1: float = quantity_field("a_1", "life modification factor a_1 for the reliability (ISO 281)")
    #: Life modification factor a_ISO for lubricant and contamination; None if the scene does not give both viscosity ratio
    #: and contamination.
    a_iso: float | None = quantity_field(
        "a_ISO", "life modification factor a_ISO for lubricant and contamination (ISO 281); null if they are not given"
    )
    #: Fatigue load limit C_u [N].
    limit: float = quantity_field("fatigue_load_limit_N", "load C_u at which the worst contact has 1500 MPa, as computed")


def reliability_factor(percent: float) -> float:
    """Return the life modification factor a_1 for a reliability, 0.95 (ln(1/S)/ln(1/0.9))^(2/3) + 0.05.

    Parameters
    ----------
    percent
        Reliability [%], 90 to 99.95; S is the same as a fraction, 0.9 to 0.9995.

    References
    ----------
    ISO/TR 1281-2; ISO 281:2007, Table 12.

    Examples
    --------
    >>> [round(reliability_factor(s), 3) for s in (90.0, 95.0, 99.0, 99.95)]
    [1.0, 0.638, 0.248, 0.077]
    """
    return 0.95 * float((log(100.0 / percent) / log(1.0 / 0.9)) ** (2.0 / 3.0)) + 0.05


def life_factor_for_lubrication(kappa: float, contamination_load_ratio: float, *, is_thrust_bearing: bool = False) -> float:
    """Return the life modification factor a_ISO for lubricant and contamination of a ball bearing, at most 50.

    It follows from eq. (2) of this module.

    Parameters
    ----------
    kappa
        Viscosity ratio, at least 0.1; values above 4 count as 4.
    contamination_load_ratio
        Product of the contamination factor e_C and the ratio C_u/P of fatigue load limit to equivalent load.
    is_thrust_bearing
        Whether the bearing is a thrust bearing.

    References
    ----------
    ISO 281:2007, 9.3.3.

    Examples
    --------
    >>> round(life_factor_for_lubrication(2.45, 0.107), 2)
    5.5
    """
    k = min(kappa, FULL_FILM)
    c, power = (2.2649, 0.054381) if k < 0.4 else (1.9987, 0.19087) if k < 1.0 else (1.9987, 0.071739)
    film = float(max(2.5671 - c / k**power, 0.0) ** 0.83)
    left = 1.0 - film * float(np.cbrt(contamination_load_ratio / 3.0 if is_thrust_bearing else contamination_load_ratio))
    return MOST if left <= 0.0 else min(0.1 * float(left**-9.3), MOST)


def fatigue_load_limit(scene: Scene) -> float:
    """Return the fatigue load limit C_u [N] of ISO 281: axial for a screw and a thrust bearing, radial for other bearings.

    References
    ----------
    ISO 281:2007, B.3.3, for bearings. For screws it is the axial load at which equally loaded contacts reach a pressure of
    1500 MPa.
    """
    if scene.track.lead == 0.0:
        across = 2.0 * scene.track.pitch_radius
        return float(static_rating(scene) / STATIC_OVER_FATIGUE * min(1.0, (0.1 / across) ** 0.5))
    of_one_newton = float(hertz_without_errors(scene).pressure(np.ones(4)).max())
    return float(scene.ball_count * approach_per_displacement(scene) * (FATIGUE_PRESSURE / of_one_newton) ** 3)


def modified_life(scene: Scene, by_loads: Life | ReferenceLife | None) -> ModifiedLife | None:
    """Return the modified rating life for the reliability, lubricant and contamination that a scene states.

    Parameters
    ----------
    scene
        Scene whose table [operation] may state reliability, viscosity ratio and contamination.
    by_loads
        Rating life under the contact loads, L10 of a screw or L10r of a bearing; None if it is not known.

    Returns
    -------
    ModifiedLife | None
        The modified life; None if the basic life is None, or if the scene gives neither reliability nor viscosity ratio.
        The factor a_ISO is taken as 1 if the scene does not give both viscosity ratio and contamination.
    """
    of = scene.operation
    if by_loads is None or (of.reliability is None and of.viscosity_ratio is None):
        return None
    limit = fatigue_load_limit(scene)
    share = 90.0 if of.reliability is None else of.reliability
    a_1, a_iso = reliability_factor(share), None
    if of.viscosity_ratio is not None and of.contamination is not None:
        thrust = is_thrust_bearing(scene) or scene.track.lead > 0.0
        clean = of.contamination * limit / by_loads.equivalent_load
        a_iso = life_factor_for_lubrication(of.viscosity_ratio, clean, is_thrust_bearing=thrust)
    return ModifiedLife(a_1 * (1.0 if a_iso is None else a_iso) * by_loads.revolutions, share, a_1, a_iso, limit)


#: Least number of laminae of a roller (ISO/TS 16281).
LAMINAE = 30


@result_record
class ReferenceLife:
    """Basic reference rating life of a bearing (ISO/TS 16281, 90 % reliability), with capacity and load of each raceway."""

    #: Basic reference rating life L_10r [10^6 revolutions].
    revolutions: float = quantity_field(
        "L10r_million_revolutions",
        "basic reference rating life by ISO/TS 16281, from the loads of all rolling elements and the ring that turns",
        error="about three times that of the loads; for rollers also that of the formula for the stress at their edges",
        heading="life L10r, ISO/TS 16281",
        expected=("loads_rms", 3.0),
    )
    #: Dynamic equivalent reference load P_ref [N].
    equivalent_load: float = quantity_field(
        "equivalent_reference_load_N",
        "dynamic equivalent reference load P_ref, C/L10r^(1/3), for rollers C/L10r^(3/10)",
        error="that of the loads",
    )
    #: Dynamic capacity Q_c [N] of each loaded raceway, by its name: load that one of its contacts bears for 10^6
    #: revolutions.
    capacities: dict[str, float] = quantity_field(
        "raceway_capacity_N", "load Q_c that one contact of the raceway bears for 10^6 revolutions", parts=".*"
    )
    #: Dynamic equivalent contact load Q_e [N] of each loaded raceway, by its name.
    loads: dict[str, float] = quantity_field(
        "raceway_equivalent_load_N",
        "dynamic equivalent load Q_e of one contact of the raceway; for rollers, of a roller with equally loaded laminae",
        error="that of the loads",
        parts=".*",
    )
    #: Life of each loaded raceway [10^6 revolutions], by its name.
    raceways: dict[str, float] = quantity_field(
        "raceways_million_revolutions",
        "life of one raceway, (Q_c/Q_e)^3 for balls, (Q_c/Q_e)^4 for rollers",
        error="as L10r",
        parts=".*",
    )
    #: Ring that turns relative to the load.
    turning: life.TurningRing = quantity_field("turning_ring", "ring that turns: inner or outer")
    #: Speed of the turning ring [rad/s]; None: the scene states none.
    speed: float | None = None
    #: The same life with the maker's C in place of the computed one [10^6 revolutions]; None: the scene gives no such C.
    by_maker: float | None = quantity_field(
        "maker_L10r_million_revolutions",
        "life L10r with the maker's C (key `rating.dynamic`) in place of the computed one; null if it is not given",
        heading="life L10r by the maker's C",
        error="as L10r",
        default=None,
    )

    @property
    @QuantityDescription(
        "L10r_hours",
        "life L10r in hours, if the scene states a speed",
        heading="life L10r, ISO/TS 16281",
        error="as L10r",
        optional=True,
    )
    def hours(self) -> float | None:
        """Life in hours; None if no speed is known."""
        return 1e6 * self.revolutions * 2.0 * pi / abs(self.speed) / 3600.0 if self.speed else None


def ball_reference_life(scene: Scene, by_loads: Life | None, turning: life.TurningRing = "inner") -> ReferenceLife | None:
    """Return the basic reference rating life of a ball bearing by eq. (3) of this module.

    Parameters
    ----------
    scene
        Scene of the bearing.
    by_loads
        Rating life under its contact loads (`lowfi.rating.life.basic_rating_life`).
    turning
        Ring that turns, for which ``by_loads`` was computed.

    Returns
    -------
    ReferenceLife | None
        The life; None for a screw, without load, and if both rings stand still.
    """
    if by_loads is None or scene.track.lead:
        return None
    rated = dict(zip(SIDES, contact_capacity(scene), strict=True))
    capacities = {side: float(rated[side]) for side in by_loads.raceways}
    loads = {side: Q / float(np.cbrt(by_loads.raceways[side])) for side, Q in capacities.items()}
    x = by_loads
    maker = x.revolutions_by_maker
    return ReferenceLife(x.revolutions, x.equivalent_load, capacities, loads, x.raceways, turning, by_maker=maker)


def edge_stress_factors(laminae: int) -> Array:
    """Return the edge-stress factors f_k of the laminae of a roller (ISO/TS 16281).

    Lamina k of n_s laminae has the factor f_k = 1 - 0.01/ln(1.985 |2 k - n_s - 1|/(2 n_s - 2)).

    Parameters
    ----------
    laminae
        Number n_s of laminae, 2 or more.

    Returns
    -------
    Array
        Dimensionless factors ``(laminae,)``; 1 for the middle one of an odd number of laminae.

    Examples
    --------
    >>> edge_stress_factors(30)[:3].round(3).tolist()
    [2.328, 1.127, 1.064]
    """
    k = np.arange(1, laminae + 1)
    place = np.abs(2 * k - laminae - 1) / (2.0 * laminae - 2.0)
    with np.errstate(divide="ignore"):  # middle lamina of an odd number: ln(0), and f is one
        return np.asarray(1.0 - 0.01 / np.log(1.985 * place))


def roller_reference_life(row: RollerRow, line_loads: Array, turning: life.TurningRing = "inner") -> ReferenceLife | None:
    """Return the basic reference rating life of a row of rollers by eqs. (4) and (5) of this module.

    Parameters
    ----------
    row
        Row of tapered rollers.
    line_loads
        Loads per length ``(count, slices)`` [N/m] of each roller in equal slices.
    turning
        Ring that turns, see `lowfi.rating.life.turning_ring`.

    Returns
    -------
    ReferenceLife | None
        The life; None without load, and if both rings stand still.
    """
    top = float(line_loads.max(initial=0.0))
    if top <= 0.0 or turning == "none":
        return None
    pieces = -(-LAMINAE // line_loads.shape[-1])
    q = np.repeat(line_loads, pieces, axis=-1) / top  # loads over the largest: no overflow
    n = q.shape[-1]
    reduced = roller_life.THRUST if roller_life.is_thrust_bearing_row(row) else roller_life.RADIAL
    stress, capacities, loads = edge_stress_factors(n), {}, {}
    for race, Q in zip(RACES, roller_life.race_capacities(row) / reduced, strict=True):
        order = roller_life.TURNING if race == turning else roller_life.STANDING
        mean = stress * np.mean(q**order, axis=0) ** (1.0 / order)
        capacities[race] = float(Q)
        loads[race] = top * row.length * float(np.mean(mean**4.5)) ** (2.0 / 9.0)
    races = {race: (capacities[race] / loads[race]) ** 4 for race in RACES}
    found, C = sum(x ** (-9.0 / 8.0) for x in races.values()) ** (-8.0 / 9.0), roller_life.dynamic_rating_of_row(row)
    return ReferenceLife(
        found, C / found**0.3, capacities, loads, races, turning, by_maker=life.by_maker(row, C, found, 4.0)
    )
