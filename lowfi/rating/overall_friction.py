"""Overall coefficients of friction of catalogues and calculators, as distinct from the sliding coefficient of a scene.

Calculators treat a ball screw as a sliding thread with one small coefficient f. At the lead angle phi of the pitch circle
its efficiency against the load is

    eta = tan(phi)/tan(phi + arctan(f)).                                                                              (1)

In it f stands for all losses. A scene's coefficient is that of sliding in the contacts of the balls, which mostly roll:
about 0.1 with grease, less with a full film. With f in its place a computed loss is several times too small.
"""

from __future__ import annotations

from math import atan, tan

from rollbench.lowfi.warned import Warned
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Friction, Track

#: Largest overall coefficient of calculators and catalogues (0.003 to 0.01 for ball screws, 0.001 to 0.002 for ball
#: bearings), doubled.
OVERALL = 0.02


def efficiency(track: Track, coefficient: float) -> float:
    """Return the efficiency of a screw that moves its load against the force, by (1).

    Parameters
    ----------
    track
        Track of the screw, for its lead angle.
    coefficient
        Overall coefficient of friction f, for all losses together; 0.003 to 0.01 for ball screws.

    Examples
    --------
    A lead of 10 mm at a pitch diameter of 40 mm:

    >>> round(efficiency(Track(20e-3, 10e-3, 0.785), 0.005), 4)
    0.9405
    """
    phi = abs(lead_angle(track))
    return tan(phi) / tan(phi + atan(coefficient))


def overall_warnings(track: Track, friction: Friction) -> list[Warned]:
    """Return a warning where a scene's coefficient of sliding is as small as an overall coefficient of catalogues.

    Parameters
    ----------
    track
        Path of the balls, whose lead angle decides.
    friction
        Coefficients of friction of the scene.
    """
    mu = max(friction.screw, friction.nut)
    if not 0.0 < mu <= OVERALL:
        return []
    as_one = f", by which the efficiency would be {100.0 * efficiency(track, mu):.3g} %" if track.lead else ""
    brief = (
        f"friction coefficient {mu:g}, that of sliding in the contacts, is as low as overall coefficients of catalogues "
        f"and calculators{as_one}"
    )
    text = (
        f"{brief}; here it is about 0.1 with grease, less with a full film: if an overall one was meant, friction torque "
        "and losses are several times too small"
    )
    return [Warned("coefficient", text, brief)]
