"""Fatigue life of ball bearings by ISO 281 (L10) and ISO/TS 16281 (L10r), and of ball screws by ISO 3408-5 (L10).

All three standards rest on Lundberg and Palmgren (1947). Each flank of a groove is a raceway. It has a capacity Q_c [N],
the contact load that it bears for 10^6 revolutions (90 % reliability), and an equivalent contact load Q_e, a mean of the
forces of its balls. The mean is of order 3 for a raceway that rotates relative to the load (the ring that turns), and of
order 10/3 for a stationary one (the ring that stands). In a ball screw the axial pattern of the loads stays with the nut,
whichever of the two turns: the screw's raceways have the order 3, those of the nut 10/3. Then, for the contact loads,

    L = (sum over raceways of (Q_c/Q_e)^(-10/3))^(-9/10).                                                              (1)

The capacity of a contact, with lengths in mm, gamma = D cos(alpha)/D_pw, f the groove radius over the ball diameter, and
the upper sign for the inner raceway, is

    q(f, Z) = 98.1 (2f/(2f - 1))^0.41 (1 -+ gamma)^1.39/(1 +- gamma)^(1/3) (gamma/cos(alpha))^0.3 D^1.8 Z^(-1/3).       (2)

Bearings with Z balls and a contact angle up to 45 deg are radial bearings: Q_c = 1.3 * 0.95 q, with the factors of
contemporary steel and of single-row radial bearings. Bearings above 45 deg are thrust bearings: Q_c = 1.3 * 0.90 (1 -
sin(alpha)/3) q, with their reduction factor and their factor for the angle, and C_a = Z sin(alpha) (Q_ci^(-10/3) +
Q_co^(-10/3))^(-3/10) (ISO 281, ISO/TR 1281-1).
Ball screws have the load rating of one turn with z balls, for screw and nut each,

    C = 93.2 (1 - sin(alpha)/3) (2f/(2f - 1))^0.41 gamma^0.3 (1 -+ gamma)^1.39/(1 +- gamma)^(1/3)
        cos(alpha)^0.86 tan(alpha) cos(phi)^1.3 z^(2/3) D^1.8,  times i^0.86 for i turns,                              (3)

to which i z contacts contribute: Q_c = C i^0.86/(i z sin(alpha) cos(phi)). Turns without balls, between circuits or within
one, do not count in i: a start with n balls, whose median angle between neighbours is d, fills i = n d/2 pi turns
(`filled_turns`). Equal loads then give L = (C_a/F_a)^3 with C_a = i^0.86 (C_s^(-10/3) + C_n^(-10/3))^(-3/10).

Several load cases with the nut at one position: fatigue damage accumulates at each position on a raceway in proportion to
the fraction n_j of the revolutions (Miner). A contact of the nut remains at its position, and its life is proportional to
F^-3. A position on the screw meets all contacts, whose F^3 are averaged. The life over all cases therefore follows from (1)
if each contact force is replaced by its mean of order 3 over the cases,

    F = (sum_j n_j F_j^3)^(1/3).                                                                                      (4)

Valid for grooves with f > 0.5 of hardened bearing steel, balls of up to 25 mm, no plastic contact, and full lubrication;
factors for hardness, accuracy, material, reliability and lubricant are one. The ratings are computed and not those of a
manufacturer.

Equation (1) gives the life L10 of a screw (ISO 3408-5) and L10r of a bearing (ISO/TS 16281). The life L10 of a bearing
(ISO 281), and the life of a screw over a duty cycle by ISO 3408-5, follow from equivalent loads, which know neither the
distribution nor the ring that turns. They take the force on the whole nut or bearing in every case j, with its fraction n_j
of the revolutions, and a mean of order 3,

    F_m = (sum_j n_j F_j^3)^(1/3),  L = (C/F_m)^3 in 10^6 revolutions.                                               (5)

Ball screws carry axial forces only. A nut with play carries each direction on another pair of flanks. If two halves of a
nut are preloaded against each other with F_pr, each half carries one direction, and both deflect in proportion to F^(2/3).
The unloaded half therefore loses contact at F = 2^(3/2) F_pr. By the standard, the loaded and the other half carry

    F_1 = F_pr (1 + F/(2^(3/2) F_pr))^(3/2),  F_2 = F_1 - F;  beyond  F_1 = F,  F_2 = 0.                             (6)

The lives of both, each with its rating, combine to L = (L_1^(-10/9) + L_2^(-10/9))^(-9/10).                         (7)

For bearings P = X F_r + Y F_a with the factors of a single row, for contact angles of 20 deg and more (below, they follow
from C_0 and tabulated factors f_0, which are not computed here). Above 45 deg the factors are those of thrust bearings,
X = 1.25 tan(alpha) (1 - 2/3 sin(alpha)) and Y = 1, if F_a > 1.25 tan(alpha) F_r. The standards cover neither moments nor
the four-point preload of a single nut.

Comparison with values that manufacturers print (``external-equivalent``, with pages): (5) agrees with worked examples of
HIWIN and Rexroth. (6) before loss of contact and (7) are compared with HIWIN and NBS, who write 3 for 2^(3/2), as does THK
after deriving it: their F_1 is up to 4 % lower, and their F_2 negative before contact is lost. e, X and Y at 25, 30 and
40 deg, and 1.25 tan(alpha) and X at 50, 55 and 60 deg, agree with NSK. Factors at 20, 35 and 45 deg are not printed there;
at all angles the two branches of P meet within 0.3 % (X + e Y).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, degrees, hypot, pi, sin, tan
from typing import Literal

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.errors import are_in_shifted_half
from rollbench.meshes.helix import ball_layout, lead_angle, nominal_groove_radii
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import SIDE_SIGNS, SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: Constant of (2) for mm and N (Lundberg and Palmgren 1947).
CONTACT = 98.1

#: Reduction factors of single-row radial bearings (also in (3)) and of thrust bearings; factor of contemporary steel (ISO
#: 281, ISO 3408-5).
SINGLE_ROW, THRUST, STEEL = 0.95, 0.90, 1.3

#: Contact angle [deg] above which a bearing is rated as a thrust bearing (ISO 281, ISO 76).
RADIAL_UP_TO = 45.0

#: Orders of the mean force of a raceway that rotates relative to the load, and of a stationary one.
TURNING, STANDING = 3.0, 10.0 / 3.0

#: Ring of a bearing that turns; "none" where both stand still.
TurningRing = Literal["inner", "outer", "none"]

#: Why a bearing has no life whose rings stand still.
RINGS_STAND = "its rings do not turn"

#: Factors of the rotating and the stationary raceway in the radial rating of a bearing: J_r/J_1 and J_r/J_2 for a load zone
#: of half the circumference.
RADIAL = (0.407, 0.389)


@result_record
class Life:
    """Life L10, which 90 % of identical screws or bearings reach.

    Of a nut by its contact loads (ISO 3408-5), of a bearing (C/P)^p by the equivalent load P of ISO 281.
    """

    #: Basic rating life L10 [10^6 revolutions].
    revolutions: float = quantity_field(
        "L10_million_revolutions",
        "basic rating life, reached by 90 %: of a nut under this load distribution (ISO 3408-5), of a bearing (C/P)^p with "
        "the equivalent load P of its force, p = 3 for balls and 10/3 for rollers (ISO 281)",
        error="of a nut about three times that of the loads; in addition fatigue lives scatter",
        heading="life L10",
        expected=("loads_rms", 3.0),
        note="{standard}",
    )
    #: Basic rating life of each loaded raceway [10^6 revolutions], by the name of the raceway; empty for L10 of a bearing.
    raceways: dict[str, float] = quantity_field(
        "raceways_million_revolutions", "life of one raceway of a nut, a groove flank", error="as above", parts=".*"
    )
    #: Basic dynamic load rating C [N], axial for screws and thrust bearings, radial for other bearings.
    rating: float = quantity_field("rating_as_computed_N", "basic dynamic load rating C")
    #: Equivalent load P [N], at which the rating C gives the same life.
    equivalent_load: float = quantity_field(
        "equivalent_load_N",
        "equivalent load P: of a nut that for which C gives the same life, C/L10^(1/3); of a bearing that of ISO 281",
        error="that of the loads",
    )
    #: Standard whose formulas give the life.
    standard: str = quantity_field("standard", "standard of the life formulas")
    #: Lead of the screw [m]; 0 for a bearing.
    lead: float = 0.0
    #: Speed of the rotating part [rad/s]; None if the scene states none.
    speed: float | None = None
    #: The same life with the maker's C in place of the computed one [10^6 revolutions]; None without such a C.
    revolutions_by_maker: float | None = quantity_field(
        "maker_L10_million_revolutions",
        "life L10 with the maker's C (key `rating.dynamic`) in place of the computed one; null if it is not given",
        heading="life L10 by the maker's C",
        error="as in revolutions",
        note="{standard}",
        default=None,
    )

    @property
    @QuantityDescription(
        "L10_km",
        "life L10 as the distance that the nut travels, L10 times the lead; null for bearings",
        error="as in revolutions",
        heading="life L10",
        expected=("loads_rms", 3.0),
    )
    def distance(self) -> float | None:
        """Travel of the nut until the end of the life L10 [m]; None for bearings."""
        return 1e6 * self.revolutions * self.lead if self.lead else None

    @property
    @QuantityDescription(
        "L10_hours",
        "life L10 in hours, if the scene states a speed; for a duty cycle at its mean speed",
        heading="life L10",
        expected=("loads_rms", 3.0),
        error="as in revolutions",
        optional=True,
    )
    def hours(self) -> float | None:
        """Running time until the end of the life L10 [h]; None if no speed is known."""
        return 1e6 * self.revolutions * 2.0 * pi / abs(self.speed) / 3600.0 if self.speed else None

    @property
    def L10(self) -> float:
        """Life L10 [revolutions]."""
        return 1e6 * self.revolutions

    @property
    def seconds(self) -> float | None:
        """Running time until the end of the life L10 [s]; None if no speed is known."""
        return None if self.hours is None else 3600.0 * self.hours

    @property
    def by_maker(self) -> float | None:
        """Life L10 with the maker's C of the scene in place of the computed one [revolutions]; None without such a C."""
        return None if self.revolutions_by_maker is None else 1e6 * self.revolutions_by_maker


#: Weibull slope of the lives of point contacts (Lundberg and Palmgren 1947).
SLOPE = 10.0 / 9.0


@result_record
class SystemLife:
    """Life of all nuts and bearings on one shaft together, which ends when the first of them fails."""

    #: Life of the whole system [10^6 revolutions].
    revolutions: float = quantity_field(
        "life_million_revolutions",
        "revolutions that 90 % of equal axes reach without failure of any nut or bearing (set) that turns: product of the "
        "sets' probabilities of survival, each a Weibull distribution; lives by contact loads, L10 of nuts and L10r of "
        "bearings",
        error="that of the lives",
        heading="life of the whole axis, by loads",
        note="shortest life: {shortest_set}",
    )
    #: Name of the nut or bearing with the shortest life.
    shortest: str = quantity_field("shortest_set", "name of the nut or bearing with the shortest life")
    #: Lead of the screw [m]; 0 without a nut.
    lead: float = 0.0
    #: Speed of the shaft [rad/s]; None if the scene gives no speed.
    speed: float | None = None
    #: The same by the lives L10 of all sets [10^6 revolutions]; None if that of one is not known.
    basic: float | None = quantity_field(
        "L10_million_revolutions",
        "the same by the lives L10 of all nuts (ISO 3408-5) and bearings (ISO 281); null if that of one is not known",
        error="that of the lives",
        heading="life L10 of the whole axis",
        default=None,
    )

    @property
    @QuantityDescription(
        "life_km",
        "life of the whole axis as the distance that the nut travels; null without a nut",
        error="as in revolutions",
        heading="life of the whole axis, by loads",
    )
    def distance(self) -> float | None:
        """Life of the system as the distance that the nut travels [m]; None without a nut."""
        return 1e6 * self.revolutions * self.lead if self.lead else None

    @property
    @QuantityDescription(
        "life_hours",
        "life of the whole axis in hours, if a speed is stated",
        error="as in revolutions",
        heading="life of the whole axis, by loads",
    )
    def hours(self) -> float | None:
        """Life of the system in hours; None without a speed."""
        return 1e6 * self.revolutions * 2.0 * pi / abs(self.speed) / 3600.0 if self.speed else None


def life_of_parts_in_series(lives: Sequence[tuple[float, float]]) -> float:
    """Return the life that 90 % of systems reach, where a system fails as soon as one of its parts fails.

    A part survives the life L with the probability 0.9^((L/L_i)^e_i), and the system with the product of these. L therefore
    solves sum_i (L/L_i)^e_i = 1; for equal slopes L = (sum L_i^-e)^(-1/e). Failures are taken to be independent.

    Parameters
    ----------
    lives
        For each part the life L_i that 90 % reach, in any unit, and the Weibull slope e_i.

    Returns
    -------
    float
        Life of the system, in the same unit.

    References
    ----------
    Lundberg and Palmgren (1947). Smith (1994), 4.3.6, takes the shortest life instead, the upper limit.

    Examples
    --------
    >>> round(life_of_parts_in_series([(100.0, SLOPE), (100.0, SLOPE)]), 3)  # 100/2^0.9
    53.589
    """
    shortest: float = min(life for life, _ in lives)

    def damage_sum_less_one(x: float) -> float:
        """Return sum (L/L_i)^e_i - 1 over parts of life L_i and slope e_i, for a system life L = x times the least L_i."""
        return float(sum((x * shortest / life) ** slope for life, slope in lives)) - 1.0

    share = 1.0 if len(lives) == 1 else float(brentq(damage_sum_less_one, 0.5 / len(lives), 1.0, rtol=1e-12))
    return shortest * share


def is_thrust_bearing(scene: Scene) -> bool:
    """Return whether a scene is a thrust bearing: a bearing with a contact angle above 45 deg."""
    return scene.track.lead == 0.0 and degrees(scene.track.contact_angle) > RADIAL_UP_TO + 1e-9


def filled_turns(scene: Scene) -> float:
    """Return the number of turns of the track that are filled with balls, without gaps: the sum over all thread starts.

    The number is the number of balls times the median angle between neighbours, over a whole turn; a single ball counts as
    one turn. It is exact for equal spacing within circuits of at least two balls, for any gaps between the circuits. Where
    neighbours are further apart than the median, only the median is counted.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    azimuths = np.sort(scene.balls.azimuths)
    angle = float(np.median(np.diff(azimuths))) if azimuths.size > 1 else 2.0 * pi
    return scene.ball_count * angle / (2.0 * pi)


def _contact_capacity_factors_and_ball_diameter(scene: Scene) -> tuple[Array, float]:
    """Return the factors of conformity and curvature in a contact's dynamic capacity ``(4,)``, then the ball diameter [mm].

    The factors, of eq. (2) of this module, include gamma^0.3 with gamma = D cos(alpha)/D_pw (ball diameter D, contact angle
    alpha, pitch diameter D_pw). Their order is SL, SR, NL, NR (S: screw or inner ring, N: nut or outer ring; L: left, R:
    right flank).
    """
    alpha, D = scene.track.contact_angle, 2.0 * scene.balls.radius
    gamma = D * cos(alpha) / (2.0 * scene.track.pitch_radius)
    f = nominal_groove_radii(scene) / D
    sign = np.array([-1.0, -1.0, 1.0, 1.0])
    curve = (1.0 + sign * gamma) ** 1.39 / (1.0 - sign * gamma) ** (1.0 / 3.0)
    return np.asarray((2.0 * f / (2.0 * f - 1.0)) ** 0.41 * curve * gamma**0.3), 1e3 * D


def contact_capacity(scene: Scene) -> Array:
    """Return the basic dynamic capacity Q_c of a contact on each raceway ``(4,)`` [N].

    It is the contact load that a contact bears for 10^6 revolutions; eqs. (2) (bearings) and (3) (screws) of this module.
    The raceways are screw left, screw right, nut left, nut right, or inner ring left to outer ring right.

    Raises
    ------
    ValueError
        A groove radius does not exceed the ball's, or the contact angle of a screw is zero.
    """
    alpha = scene.track.contact_angle
    least = float(nominal_groove_radii(scene).min())
    if least <= scene.balls.radius:
        raise ValueError(
            f"load rating: got a groove radius of {1e3 * least:.4g} mm; allowed: more than the ball's radius of "
            f"{1e3 * scene.balls.radius:.4g} mm"
        )
    shape, D = _contact_capacity_factors_and_ball_diameter(scene)
    if scene.track.lead == 0.0:
        base = CONTACT * STEEL * (THRUST * (1.0 - sin(alpha) / 3.0) if is_thrust_bearing(scene) else SINGLE_ROW)
        return np.asarray(base * shape * cos(alpha) ** -0.3 * D**1.8 * scene.ball_count ** (-1.0 / 3.0))
    if sin(alpha) <= 0.0:
        raise ValueError("load rating of a screw: got a contact angle of 0 deg; allowed: above 0 deg")
    return _ratings_of_raceways(scene) / (scene.ball_count * sin(alpha) * cos(lead_angle(scene.track)))


def _ratings_of_raceways(scene: Scene) -> Array:
    """Return the dynamic load rating of each raceway of a screw by eq. (3) of this module, for all turns ``(4,)`` [N].

    The raceways are screw left, screw right, nut left, nut right.
    """
    alpha = scene.track.contact_angle
    shape, D = _contact_capacity_factors_and_ball_diameter(scene)
    angle = (1.0 - sin(alpha) / 3.0) * cos(alpha) ** 0.86 * tan(alpha) * cos(lead_angle(scene.track)) ** 1.3
    turns = filled_turns(scene)
    one_turn = CONTACT * SINGLE_ROW * shape * angle * (scene.ball_count / turns) ** (2.0 / 3.0) * D**1.8
    return np.asarray(one_turn * turns**0.86)


def dynamic_rating(scene: Scene) -> float:
    """Return the basic dynamic load rating C of a ball screw or ball bearing, for one pair of opposite raceways.

    Parameters
    ----------
    scene
        Screw or bearing.

    Returns
    -------
    float
        C [N]: axial for a screw (ISO 3408-5) and for a bearing above 45 deg, radial for other bearings (ISO 281).

    Raises
    ------
    ValueError
        A groove radius does not exceed the ball's, or the contact angle of a screw is zero.

    References
    ----------
    ISO 3408-5, ISO 281 and ISO/TR 1281-1, written out in (1) to (3) of this module.

    Examples
    --------
    Nine balls of 10 mm, groove radii 0.52 D, D/D_pw = 0.2; the table of ISO 281 has f_c = 59.9:

    >>> from rollbench.meshes.parts import Balls, Material, Nut, Screw, Track
    >>> steel = Material(206e9, 0.3)
    >>> balls = Balls(5e-3, steel, tuple(2.0 * pi * k / 9 for k in range(9)))
    >>> inner, outer = Screw(0.02, 0.049, 5.2e-3, steel), Nut(0.01, 0.02, 0.1, 5.2e-3, steel)
    >>> bearing = Scene("ring", "ring", Track(25e-3, 0.0, 0.0), inner, outer, balls)
    >>> C = dynamic_rating(bearing)
    >>> round(C), round(C / (1.3 * 9 ** (2 / 3) * 10**1.8), 1)
    (21109, 59.5)
    """
    if scene.track.lead > 0.0:
        screw, nut = _ratings_of_raceways(scene)[[0, 3]]
    else:
        alpha, capacities = scene.track.contact_angle, contact_capacity(scene)[[0, 3]] * scene.ball_count
        screw, nut = capacities * sin(alpha) if is_thrust_bearing(scene) else capacities * cos(alpha) * np.array(RADIAL)
    return float((screw ** (-10.0 / 3.0) + nut ** (-10.0 / 3.0)) ** -0.3)


def turning_ring(assembly: Scene | Assembly, row: RollingSet | None = None) -> TurningRing:
    """Return which ring of a bearing turns, by the scene's table [motion]; without that table the inner ring.

    If the nuts of an axis turn, its shaft and the bearings on it stand still, and bearings around a nut (with a carrier)
    turn with the nut. If the shaft turns, bearings around a nut stand still. In an axis without nuts, ``turns = "nut"``
    means the outer rings.

    Parameters
    ----------
    assembly
        Scene of a single bearing, or axis with several nuts and bearings.
    row
        Bearing of the axis; None for a single bearing. For a nut, the ring that turns against the pattern of the loads is
        returned, the screw ("inner"), whichever part turns.
    """
    by_nut = assembly.motion is not None and assembly.motion.turns == "nut"
    if isinstance(assembly, Scene) or row is None:
        return "outer" if by_nut and isinstance(assembly, Scene) and assembly.track.lead == 0.0 else "inner"
    if row.kind == "ball nut" or assembly.motion is None:
        return "inner"
    if row.carrier is not None:
        return "inner" if by_nut else "none"
    if not by_nut:
        return "inner"
    return "none" if any(s.kind == "ball nut" for s in assembly.sets) else "outer"


def basic_rating_life(scene: Scene, load: Array, turning: TurningRing = "inner") -> Life | None:
    """Return the rating life of a ball screw (L10) or ball bearing (L10r) under given contact loads.

    It is (sum over raceways of (Q_c/Q_e)^(-10/3))^(-9/10), with capacity Q_c and equivalent contact load Q_e of a raceway.

    Parameters
    ----------
    scene
        The screw or bearing.
    load
        Contact forces ``(n, 4)`` [N] of the balls on the four flanks.
    turning
        Ring of a bearing that turns, see `turning_ring`; "inner" for a screw.

    Returns
    -------
    Life | None
        The life; None without load, and for a bearing whose rings stand still.

    Raises
    ------
    ValueError
        A groove radius does not exceed the ball's, or the contact angle of a screw is zero.

    Examples
    --------
    Under equal contact loads the life is (C/F)^3, with the dynamic load rating C and the axial force F:

    >>> import rollbench
    >>> scene = rollbench.read("lin-case1")
    >>> load = np.zeros((scene.ball_count, 4))
    >>> load[:, [0, 3]] = 100.0
    >>> found = basic_rating_life(scene, load)
    >>> axial = 100.0 * scene.ball_count * sin(scene.track.contact_angle) * cos(lead_angle(scene.track))
    >>> round(found.revolutions / (found.rating / axial) ** 3, 9)
    1.0
    """
    if not (load > 0.0).any() or turning == "none":
        return None
    capacity = contact_capacity(scene)
    raceways = {}
    for s, side in enumerate(SIDES):
        if (load[:, s] > 0.0).any():
            order = TURNING if (s < 2) == (turning == "inner") else STANDING
            top = float(load[:, s].max())  # forces over the largest: no overflow
            mean = top * float(np.mean((load[:, s] / top) ** order)) ** (1.0 / order)
            raceways[side] = float((capacity[s] / mean) ** 3)
    shares = np.array(list(raceways.values())) ** (-10.0 / 9.0)
    total, rated = float(shares.sum() ** -0.9), dynamic_rating(scene)
    equivalent = rated / float(np.cbrt(total))
    standard = name_life_standard(scene, by_loads=True)
    maker = by_maker(scene, rated, total)
    return Life(total, raceways, rated, equivalent, standard, scene.track.lead, revolutions_by_maker=maker)


def by_maker(parts: Scene | RollerRow, rating: float, revolutions: float, exponent: float = 3.0) -> float | None:
    """Return a life with the maker's dynamic load rating in place of the computed one; None if the scene gives no such C.

    ``rating``: computed rating [N]; ``revolutions``: life by it; ``exponent``: of C in the life.
    """
    given = parts.rating.dynamic
    return None if given is None else revolutions * (given / rating) ** exponent


def damage_equivalent_loads(loads: Sequence[Array], shares: Sequence[float], order: float = TURNING) -> Array:
    """Return the loads that cause the same fatigue damage as several load cases together.

    Each load is a mean over the load cases, weighted by the revolutions, F = (sum_j n_j F_j^3)^(1/3) for balls.

    Parameters
    ----------
    loads
        Contact forces of each case, ``(n, 4)`` [N], or loads per length of the slices of rollers [N/m].
    shares
        Fractions of the revolutions in each case, with the sum 1; cases with a fraction of zero are ignored.
    order
        Order of the mean: 3 for balls, 4 for rollers.

    Returns
    -------
    Array
        Loads of the same shape, which give the life over all cases (`basic_rating_life`).
    """
    used = [(load, share) for load, share in zip(loads, shares, strict=True) if share > 0.0]
    if len(used) == 1:
        return used[0][0]
    top = max(float(load.max(initial=0.0)) for load, _ in used) or 1.0  # loads over the largest: no overflow
    return np.asarray(top * sum(share * (load / top) ** order for load, share in used) ** (1.0 / order))


def name_life_standard(scene: Scene, *, by_loads: bool = False) -> str:
    """Return the name of the standard, for example "ISO 3408-5", by which a screw's or bearing's life is computed.

    ``by_loads``: whether the life follows from the contact loads, and not from load rating and equivalent load.
    """
    if scene.track.lead > 0.0:
        return "ISO 3408-5"
    return ("ISO/TS 16281" if by_loads else "ISO 281") + (" (thrust bearing)" if is_thrust_bearing(scene) else "")


#: External force over preload at which one of two nut halves, preloaded against each other, loses contact (F ~
#: delta^(3/2)).
PARTING = 2.0**1.5

#: Contact angles [deg] of the table of e, X and Y for a single row (ISO 281).
ANGLES = (20.0, 25.0, 30.0, 35.0, 40.0, 45.0)

#: Values of e, X and Y at the angles of ``ANGLES``.
LIMITS, RADIAL_FACTORS, AXIAL_FACTORS = (
    (0.57, 0.68, 0.80, 0.95, 1.14, 1.34),
    (0.43, 0.41, 0.39, 0.37, 0.35, 0.33),
    (1.00, 0.87, 0.76, 0.66, 0.57, 0.50),
)


@result_record
class EquivalentLoadLife:
    """Life of a duty cycle by the equivalent loads of a standard, eqs. (5) to (7) of the module `lowfi.rating.life`."""

    #: Life L10 over the duty cycle [10^6 revolutions].
    revolutions: float = quantity_field(
        "L10_million_revolutions",
        "life by the standard's equivalent loads, (C/F_m)^3, of both load directions or nut halves together",
        heading="life L10 by equivalent loads",
        note="{standard}",
    )
    #: Equivalent loads [N]: for a screw two, one of the flanks or nut half that carry forces on the nut along +z, one of
    #: those that carry forces along -z; for a bearing its equivalent load P.
    equivalent_loads: tuple[float, ...] = quantity_field(
        "equivalent_loads_N",
        "means of order 3 over the revolutions: axial load of the flanks or nut half that carry forces along +z, then of "
        "the others; for a bearing its equivalent load P",
        parts="[]",
    )
    #: Standard whose formulas give the life.
    standard: str = quantity_field("standard", "standard of the equivalent loads")


def life_by_equivalent_loads(
    scenes: Sequence[Scene], shares: Sequence[float], forces: Sequence[Array], preload: float
) -> EquivalentLoadLife | None:
    """Return the life of a screw or bearing over several load cases by the standard's equivalent loads.

    Parameters
    ----------
    scenes
        Scene of each load case; all have the same parts.
    shares
        Fractions of the revolutions in each case.
    forces
        For each load case the force of the screw on the nut (or of the inner on the outer ring) along x, y, z ``(3,)`` [N].
    preload
        Axial force [N] with which a lead offset presses two halves of a nut against each other; 0 for a nut with play.

    Returns
    -------
    EquivalentLoadLife | None
        The life; None without load.

    Raises
    ------
    ValueError
        A load is not covered by the standard (moments, radial force on a screw, four-point preload); the message names it.
    """
    used = [(scene, n, F) for scene, n, F in zip(scenes, shares, forces, strict=True) if n > 0.0]
    ring = scenes[0].track.lead == 0.0
    standard = "ISO 281" if ring else "ISO 3408-5"
    for scene, _, _ in used:
        reason = _name_of_uncovered_load(scene, is_bearing=ring)
        if reason:
            raise ValueError(f"{standard} does not cover {reason} (as in {scene.name})")
    n = np.array([share for _, share, _ in used])
    if ring:
        cases: tuple[Array, ...] = (np.array([_equivalent_bearing_load(scenes[0], F) for _, _, F in used]),)
        rated: tuple[float, ...] = (dynamic_rating(scenes[0]),)
    else:
        cases, rated = forces_on_nut_halves(np.array([F[2] for _, _, F in used]), preload), _ratings_by_direction(scenes[0])
    loads = tuple(mean_force(n, force) for force in cases)
    wear = sum((F / C) ** (10.0 / 3.0) for F, C in zip(loads, rated, strict=True))
    return EquivalentLoadLife(float(wear**-0.9), loads, standard) if wear > 0.0 else None


def bearing_life_of_equivalent_loads(
    scenes: Sequence[Scene], shares: Sequence[float], forces: Sequence[Array]
) -> Life | None:
    """Return the life L10 = (C/P)^3 of a ball bearing by ISO 281, with the equivalent load P of one or several load cases.

    Arguments and errors are those of `life_by_equivalent_loads`.

    Returns
    -------
    Life | None
        The life; None without load.
    """
    found = life_by_equivalent_loads(scenes, shares, forces, 0.0)
    if found is None:
        return None
    C, standard, (P,) = dynamic_rating(scenes[0]), name_life_standard(scenes[0]), found.equivalent_loads
    maker = by_maker(scenes[0], C, found.revolutions)
    return Life(found.revolutions, {}, C, P, standard, revolutions_by_maker=maker)


def force_of_contact_loads(azimuth: Array, load: Array, angle: Array) -> Array:
    """Return the force of the inner on the outer ring of a ball bearing along x, y and its axis z, from its contacts [N].

    Parameters
    ----------
    azimuth
        Azimuths of the n balls ``(n,)`` [rad].
    load, angle
        Contact loads [N] and contact angles [rad] on the four flanks ``(n, 4)``.

    Returns
    -------
    Array
        The force ``(3,)`` [N].
    """
    Q, signs = load[:, 2:], np.array(SIDE_SIGNS)[2:]
    angles = np.where(Q > 0.0, angle[:, 2:], 0.0)
    radial = (Q * np.cos(angles) * signs[:, 0]).sum(axis=1)
    return np.array([radial @ np.cos(azimuth), radial @ np.sin(azimuth), (Q * np.sin(angles) * signs[:, 1]).sum()])


def forces_on_nut_halves(force: Array, preload: float) -> tuple[Array, Array]:
    """Return the axial forces on the two halves of a preloaded nut.

    Under a force F the loaded half carries F_pr (1 + F/(2^(3/2) F_pr))^(3/2), until the other half loses contact. From then
    on it carries F.

    Parameters
    ----------
    force
        Axial forces of all cases ``(n,)`` [N], positive along +z.
    preload
        Preload F_pr [N]; 0 for a nut with play, in which another pair of flanks carries each direction.

    Returns
    -------
    tuple[Array, Array]
        Forces ``(n,)`` [N] on the half (or pair of flanks) that carries forces along +z, and on the other one.

    References
    ----------
    ISO 3408-5, with 2^(3/2) where manufacturers print 3.

    Examples
    --------
    >>> [x.round(1).tolist() for x in forces_on_nut_halves(np.array([0.0, 1e3, 5e3, -5e3]), 1e3)]
    [[1000.0, 1574.8, 5000.0, 0.0], [1000.0, 574.8, 0.0, 5000.0]]
    """
    size = np.abs(force)
    if preload > 0.0:
        loaded = np.where(size < PARTING * preload, preload * (1.0 + size / (PARTING * preload)) ** 1.5, size)
    else:
        loaded = size
    other = loaded - size
    return np.where(force >= 0.0, loaded, other), np.where(force >= 0.0, other, loaded)


def mean_force(shares: Array, force: Array, order: float = TURNING) -> float:
    """Return the mean force over the revolutions [N], by default of order 3, F_m = (sum_j n_j F_j^3)^(1/3).

    Parameters
    ----------
    shares
        Fractions n_j of the revolutions ``(n,)``.
    force
        Forces F_j ``(n,)`` [N], not negative.
    order
        Order of the mean.

    Examples
    --------
    >>> round(mean_force(np.array([0.5, 0.3, 0.2]), np.array([1e3, 2e3, 4e3])), 1)
    2504.0
    """
    top = float(force.max(initial=0.0))
    return 0.0 if top == 0.0 else top * float(shares @ (force / top) ** order) ** (1.0 / order)


def _ratings_by_direction(scene: Scene) -> tuple[float, float]:
    """Return the dynamic load ratings of a screw for forces on the nut along +z, then along -z [N].

    A nut with a lead offset has one rating for each half; the half that is shifted along +z carries forces along -z. A nut
    with play has the same rating in both directions.
    """
    capacity = dynamic_rating(scene)
    offset = scene.errors.lead_offset
    if offset == 0.0:
        return capacity, capacity
    beyond = float(np.mean(are_in_shifted_half(scene, ball_layout(scene).z)))
    before, after = capacity * (1.0 - beyond) ** 0.86, capacity * beyond**0.86
    return (before, after) if offset > 0.0 else (after, before)


def equivalent_load_factors(alpha: float) -> tuple[float, float, float]:
    """Return the factors e, X and Y of a single row of balls by ISO 281.

    The equivalent load is P = X F_r + Y F_a if F_a > e F_r, with the radial force F_r and the axial force F_a.

    Parameters
    ----------
    alpha
        Contact angle [rad]: radial bearings from 20 to 45 deg, interpolated linearly in the table, and thrust bearings
        above.

    Raises
    ------
    ValueError
        The contact angle is below 20 deg, where the factors depend on C_0 and tabulated factors f_0.

    Examples
    --------
    >>> from math import radians
    >>> [round(x, 2) for x in equivalent_load_factors(radians(40.0))]
    [1.14, 0.35, 0.57]
    >>> [round(x, 2) for x in equivalent_load_factors(radians(60.0))]
    [2.17, 0.92, 1.0]
    """
    angle = degrees(alpha)
    if angle > RADIAL_UP_TO + 1e-9:
        return 1.25 * tan(alpha), 1.25 * tan(alpha) * (1.0 - 2.0 / 3.0 * sin(alpha)), 1.0
    if angle < ANGLES[0] - 1e-9:
        raise ValueError(
            f"factors X and Y of ISO 281: got a contact angle of {angle:.4g} deg; allowed: at least 20 deg, because "
            "below that they depend on the standard's factor f_0"
        )
    e, X, Y = (float(np.interp(angle, ANGLES, values)) for values in (LIMITS, RADIAL_FACTORS, AXIAL_FACTORS))
    return e, X, Y


#: Axial over radial force up to which a bearing counts as loaded by a radial force alone.
NO_THRUST = 1e-6


def _equivalent_bearing_load(scene: Scene, force: Array) -> float:
    """Return the dynamic equivalent load P of a ball bearing by ISO 281 [N].

    ``force``: force on the bearing along x, y and its axis z (3,) [N]. Raises ValueError for a thrust bearing with a radial
    force that ISO 281 does not cover.
    """
    radial, axial, thrust = hypot(force[0], force[1]), abs(float(force[2])), is_thrust_bearing(scene)
    if not thrust and axial <= NO_THRUST * radial:
        return radial
    e, X, Y = equivalent_load_factors(scene.track.contact_angle)
    if axial > e * radial:
        return X * radial + Y * axial
    if thrust:
        raise ValueError(
            f"ISO 281 does not cover a thrust bearing with a radial force above {1.0 / e:.2g} times the axial force"
        )
    return radial


def _name_of_uncovered_load(scene: Scene, *, is_bearing: bool) -> str:
    """Return a phrase that names a load which the life standard does not cover; empty if it covers all of a scene's loads.

    ``is_bearing``: whether the scene is a bearing (ISO 281); otherwise it is a ball screw (ISO 3408-5).
    """
    moved = {name for s in scene.supports for name, value in s.fixed if value != 0.0}
    if any(x.moment[0] or x.moment[1] for x in scene.loads) or moved & {"rx", "ry"}:
        return "moments across the axis"
    if not is_bearing and (any(x.force[0] or x.force[1] for x in scene.loads) or moved & {"ux", "uy"}):
        return "radial force"
    if scene.errors.balls.oversize > 0.0:
        return "the preload of balls with oversize, in four-point contact" if not is_bearing else "preload"
    return ""
