"""Modified rating life L_nm = a_1 a_ISO L_10 (ISO 281:2007): reliability, lubricant and contamination.

The factor a_1 for the reliability S (90 to 99.95 %) is the three-parameter Weibull law of ISO/TR 1281-2, which the table of
ISO 281 rounds,

    a_1 = 0.95 (ln(1/S)/ln(1/0.9))^(2/3) + 0.05.                                                                        (1)

The factor a_ISO for lubricant and contamination of ball bearings, with x = e_C C_u/P for radial bearings and a third of it
for thrust bearings, is

    a_ISO = 0.1 (1 - (2.5671 - k(kappa))^0.83 x^(1/3))^(-9.3),  at most 50,                                            (2)
    k = 2.2649/kappa^0.054381 (0.1 to 0.4), 1.9987/kappa^0.19087 (0.4 to 1), 1.9987/kappa^0.071739 (1 to 4; beyond as 4).

The fatigue load limit C_u is the load at which the most heavily loaded contact has 1500 MPa. For bearings it is C_0/22 (the
cube of 1500 over 4200 MPa), times (100 mm/D_pw)^(1/2) if the pitch diameter exceeds 100 mm (ISO 281, B.3.3). For a screw it
is the axial load under which all contacts have 1500 MPa. P is the load at which the rating C gives the same L_10.

Valid for a viscosity ratio kappa above 0.1, mineral oils and greases, and hardened steel. ISO 3408-5 has only a_1 for ball
screws. For them, (2) for thrust bearings is used, as their rating has the form of that of a thrust bearing and P is axial;
this is an extension of the standard.

Comparison with published values: a_1 agrees with Table 12 of ISO 281 within its rounding; k is continuous at 0.4 and 1 to
1e-4, and equals 2.5671 at 0.1, where a_ISO is 0.1 under every load. SKF's a_SKF of its class Explorer, 8 and 20.7 for the
bearing 6309 (catalogue "Rolling bearings", example 1; a report of its calculator), agree with (2) if C_u is 1.22 times as
large.
"""

from __future__ import annotations

from math import log

import numpy as np

from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.life import Life, is_thrust
from rollbench.lowfi.rating.rigidity import approach_per_displacement
from rollbench.lowfi.statics.contacts import error_free_hertz
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

#: Pressure [Pa] up to which clean, well lubricated contacts do not fatigue (ISO 281); ratio C_0/C_u of bearings.
FATIGUE_PRESSURE, STATIC_OVER_FATIGUE = 1.5e9, 22.0

#: Largest a_ISO that the standard permits, and viscosity ratio kappa above which a_ISO does not increase.
MOST, FULL_FILM = 50.0, 4.0


@record
class ModifiedLife:
    """Modified rating life by ISO 281, with its factors."""

    #: Modified rating life L_nm [10^6 revolutions].
    revolutions: float = quantity(
        "Lnm_million_revolutions",
        "modified life a_1 a_ISO L10",
        error="as in L10, and a_ISO: by the contamination, which is an estimate",
        heading="modified life",
        note="for {reliability_percent} %",
    )
    #: Reliability [%].
    reliability: float = quantity("reliability_percent", "share of screws or bearings that reach it")
    #: Factor a_1 for the reliability.
    a_1: float = quantity("a_1", "factor of the reliability (ISO 281)")
    #: Factor a_ISO for lubricant and contamination; None if the scene does not give them.
    a_iso: float | None = quantity(
        "a_ISO", "factor of lubricant and contamination (ISO 281); null where they are not given"
    )
    #: Fatigue load limit C_u [N].
    limit: float = quantity("fatigue_load_limit_N", "load C_u at which the worst contact has 1500 MPa, as computed")


def reliability_factor(percent: float) -> float:
    """Return the life modification factor a_1 for a reliability by eq. (1) of this module.

    Parameters
    ----------
    percent
        Reliability S [%], 90 to 99.95.

    References
    ----------
    ISO/TR 1281-2; ISO 281:2007, Table 12.

    Examples
    --------
    >>> [round(reliability_factor(s), 3) for s in (90.0, 95.0, 99.0, 99.95)]
    [1.0, 0.638, 0.248, 0.077]
    """
    return 0.95 * float((log(100.0 / percent) / log(1.0 / 0.9)) ** (2.0 / 3.0)) + 0.05


def iso_factor(kappa: float, clean: float, *, thrust: bool = False) -> float:
    """Return the life modification factor a_ISO for lubricant and contamination of a ball bearing, at most 50.

    It follows from eq. (2) of this module.

    Parameters
    ----------
    kappa
        Viscosity ratio, at least 0.1; values above 4 count as 4.
    clean
        Contamination factor times fatigue load limit over equivalent load, e_C C_u/P.
    thrust
        Whether the bearing is a thrust bearing.

    References
    ----------
    ISO 281:2007, 9.3.3.

    Examples
    --------
    >>> round(iso_factor(2.45, 0.107), 2)
    5.5
    """
    k = min(kappa, FULL_FILM)
    c, power = (2.2649, 0.054381) if k < 0.4 else (1.9987, 0.19087) if k < 1.0 else (1.9987, 0.071739)
    film = float(max(2.5671 - c / k**power, 0.0) ** 0.83)
    left = 1.0 - film * float(np.cbrt(clean / 3.0 if thrust else clean))
    return MOST if left <= 0.0 else min(0.1 * float(left**-9.3), MOST)


def fatigue_limit(scene: Scene) -> float:
    """Return the fatigue load limit C_u [N]: axial for a screw and a thrust bearing, radial for other bearings.

    References
    ----------
    ISO 281:2007, B.3.3, for bearings. For screws it is the load at which all contacts, equally loaded, have the same
    pressure of 1500 MPa.
    """
    if scene.track.lead == 0.0:
        across = 2.0 * scene.track.pitch_radius
        return float(static_rating(scene) / STATIC_OVER_FATIGUE * min(1.0, (0.1 / across) ** 0.5))
    of_one_newton = float(error_free_hertz(scene).pressure(np.ones(4)).max())
    return float(scene.ball_count * approach_per_displacement(scene) * (FATIGUE_PRESSURE / of_one_newton) ** 3)


def modified_life(scene: Scene, life: Life | None) -> ModifiedLife | None:
    """Return the modified rating life for the reliability, lubricant and contamination that a scene states.

    Parameters
    ----------
    scene
        Scene whose table [operation] may state reliability, viscosity ratio and contamination.
    life
        Basic rating life by the contact loads; None if it is not known.

    Returns
    -------
    ModifiedLife | None
        The modified life; None if the basic life is None, or if the scene gives neither reliability nor viscosity ratio.
    """
    of = scene.operation
    if life is None or (of.reliability is None and of.viscosity_ratio is None):
        return None
    limit = fatigue_limit(scene)
    share = 90.0 if of.reliability is None else of.reliability
    a_1, a_iso = reliability_factor(share), None
    if of.viscosity_ratio is not None and of.contamination is not None:
        thrust = is_thrust(scene) or scene.track.lead > 0.0
        a_iso = iso_factor(of.viscosity_ratio, of.contamination * limit / life.equivalent, thrust=thrust)
    return ModifiedLife(a_1 * (1.0 if a_iso is None else a_iso) * life.revolutions, share, a_1, a_iso, limit)
