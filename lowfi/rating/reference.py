"""Basic reference rating life of a bearing from the loads of its rolling elements (ISO/TS 16281:2008).

For every raceway the standard has the load Q_c that a contact bears for 10^6 revolutions, and the dynamic equivalent load
Q_e, a mean over all Z rolling elements. The mean is of order 3 (balls) or 4 (rollers) for the raceway that rotates relative
to the load (inner), and of order 10/3 or 9/2 for the stationary raceway (outer).

Balls: Q_c is that of `lowfi.rating.life` (2), which the standard expresses by C_r,

    L_10r = ((Q_ci/Q_ei)^(-10/3) + (Q_ce/Q_ee)^(-10/3))^(-9/10),   P_ref = C/L_10r^(1/3).                             (1)

This is the life that `life` returns; for four-point contact the sum includes all four flanks. If the rating C of a
catalogue replaces the computed one, L_10r changes by the cube of their ratio.

Rollers are cut into n_s >= 30 laminae; lamina k of roller j carries q_jk, and at the roller's edges the stress is higher:

    q_c = Q_c n_s^(-7/9),   f_k = 1 - 0.01/ln(1.985 |2 k - n_s - 1|/(2 n_s - 2)),
    q_ek = (sum_j (f_k q_jk)^m/Z)^(1/m),   m = 4 (inner), 9/2 (outer),                                                (2)
    L_10r = (sum_k (q_ci/q_eik)^(-9/2) + (q_ce/q_eek)^(-9/2))^(-8/9),   P_ref = C/L_10r^(3/10).                         (3)

Q_c is here that of `lowfi.rating.roller_life` (1) without the factor lambda (0.83; thrust bearings 0.73), because f_k
accounts for edge stress and non-uniform load. For a uniform load on a straight roller, whose edges are fully loaded,
L_10r = (x P/C)^(-4) with x = lambda (mean of f_k^(9/2))^(2/9). This x depends on the number of laminae: 1.13 for 30, 0.96
for 120, 0.89 in the limit. The standard is therefore meant for profiled rollers: if the edges are unloaded, L_10r does not
depend on n_s.

The line loads come from the static model. The approach of cone and cup is linear along the roller and follows from rigid
motions of both rings, so that a tilt of the rings affects every lamina. A lamina deforms as Hertz's line contacts at both
races in series, in place of the standard's spring of 35948 N/mm^(10/9) L^(8/9), so that the tilt of the roller between the
races is included. If there are fewer than 30 slices, each is divided into equal laminae of the same line load.

Valid as `lowfi.rating.life` and `roller_life`, if the inner ring rotates relative to the load. ISO/TS 16281 covers radial
and thrust bearings, not screws. Equations (2) and (3) are ISO/TS 16281:2008, (47) to (65), as github.com/minzhun/ISO16281
implements them; the standard itself was not consulted.

Compared with lives that MASTA prints for a deep-groove bearing (`external-masta`), and in limiting cases with ISO 281.
"""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.rating import roller_life
from rollbench.lowfi.rating.contacts import RACES
from rollbench.lowfi.rating.life import Life, contact_capacity
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import quantity, record

#: Least number of laminae of a roller (ISO/TS 16281).
LAMINAE = 30


@record
class ReferenceLife:
    """Basic reference rating life (reliability 90 %) by ISO/TS 16281, with the capacities and loads of the raceways."""

    #: Basic reference rating life L_10r [10^6 revolutions].
    revolutions: float = quantity(
        "L10r_million_revolutions",
        "basic reference rating life by ISO/TS 16281; of balls the same as L10",
        error="as in L10; of rollers also the stress at their edges, a formula of the standard",
        heading="life L10r, ISO/TS 16281",
        expected=("rms_percent", 3.0),
    )
    #: Dynamic equivalent reference load P_ref [N].
    equivalent: float = quantity(
        "equivalent_reference_load_N",
        "dynamic equivalent reference load P_ref, C/L10r^(1/3), of rollers C/L10r^(3/10)",
        error="that of the loads",
    )
    #: Load Q_c [N] that a contact bears for 10^6 revolutions, for each loaded raceway by its name.
    capacities: dict[str, float] = quantity(
        "raceway_capacity_N", "load Q_c that one contact of the raceway bears for 10^6 revolutions", parts=".*"
    )
    #: Dynamic equivalent contact load Q_e [N] of each loaded raceway, by its name.
    loads: dict[str, float] = quantity(
        "raceway_equivalent_load_N",
        "dynamic equivalent load Q_e of one contact of the raceway; of rollers that which every lamina alike would carry",
        error="that of the loads",
        parts=".*",
    )


def ball_reference_life(scene: Scene, life: Life | None) -> ReferenceLife | None:
    """Return the basic reference rating life of a ball bearing by eq. (1) of this module.

    Parameters
    ----------
    scene
        Scene of the bearing.
    life
        Basic rating life under its contact loads (`rollbench.lowfi.rating.life.life`).

    Returns
    -------
    ReferenceLife | None
        The life; None for a screw, and without load.
    """
    if life is None or scene.track.lead:
        return None
    rated = dict(zip(SIDES, contact_capacity(scene), strict=True))
    capacities = {side: float(rated[side]) for side in life.raceways}
    loads = {side: Q / float(np.cbrt(life.raceways[side])) for side, Q in capacities.items()}
    return ReferenceLife(life.revolutions, life.equivalent, capacities, loads)


def edge_stress(laminae: int) -> Array:
    """Return the stress concentration factors f_k along a roller by eq. (2) of this module.

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
    >>> edge_stress(30)[:3].round(3).tolist()
    [2.328, 1.127, 1.064]
    """
    k = np.arange(1, laminae + 1)
    place = np.abs(2 * k - laminae - 1) / (2.0 * laminae - 2.0)
    with np.errstate(divide="ignore"):  # middle lamina of an odd number: ln(0), and f is one
        return np.asarray(1.0 - 0.01 / np.log(1.985 * place))


def roller_reference_life(row: RollerRow, line_loads: Array) -> ReferenceLife | None:
    """Return the basic reference rating life of a row of rollers by eqs. (2) and (3) of this module.

    Parameters
    ----------
    row
        Row of tapered rollers.
    line_loads
        Loads per length ``(count, slices)`` [N/m] of each roller in equal slices.

    Returns
    -------
    ReferenceLife | None
        The life; None without load.
    """
    top = float(line_loads.max(initial=0.0))
    if top <= 0.0:
        return None
    pieces = -(-LAMINAE // line_loads.shape[-1])
    q = np.repeat(line_loads, pieces, axis=-1) / top  # loads over the largest: no overflow
    n = q.shape[-1]
    reduced = roller_life.THRUST if roller_life.is_thrust(row) else roller_life.RADIAL
    stress, capacities, loads = edge_stress(n), {}, {}
    for race, Q, order in zip(
        RACES, roller_life.race_capacities(row) / reduced, (roller_life.TURNING, roller_life.STANDING), strict=True
    ):
        mean = stress * np.mean(q**order, axis=0) ** (1.0 / order)
        capacities[race] = float(Q)
        loads[race] = top * row.length * float(np.mean(mean**4.5)) ** (2.0 / 9.0)
    damage = sum((loads[race] / capacities[race]) ** 4.5 for race in RACES)
    found = damage ** (-8.0 / 9.0)
    return ReferenceLife(found, roller_life.dynamic_rating(row) / found**0.3, capacities, loads)
