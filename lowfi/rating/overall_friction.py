"""Check that a scene's coefficient of sliding friction is not confused with the overall coefficient of a catalogue.

Catalogues and calculators treat a ball screw as a sliding thread with one small coefficient f for all losses. With the lead
angle phi of the pitch circle its efficiency against the load is

    eta = tan(phi)/tan(phi + arctan(f)).                                                                              (1)

The coefficient of a scene, by contrast, is that of sliding in the contacts of the balls, which mostly roll: about 0.1 with
grease, less with a full film. If f is used in its place, the computed loss is several times too small.
"""

from __future__ import annotations

from math import atan, tan

from rollbench.lowfi.warned import Warned
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Friction, Track

#: Twice the largest overall coefficient of catalogues (0.003 to 0.01 for ball screws, 0.001 to 0.002 for ball bearings).
OVERALL = 0.02


def efficiency(track: Track, coefficient: float) -> float:
    """Return the efficiency of a ball screw that drives its load, from an overall coefficient of friction.

    It follows from eq. (1) of this module.

    Parameters
    ----------
    track
        Track of the screw, for its lead angle.
    coefficient
        Overall coefficient of friction f for all losses; 0.003 to 0.01 for ball screws.

    Examples
    --------
    A lead of 10 mm at a pitch diameter of 40 mm:

    >>> round(efficiency(Track(20e-3, 10e-3, 0.785), 0.005), 4)
    0.9405
    """
    phi = abs(lead_angle(track))
    return tan(phi) / tan(phi + atan(coefficient))


def overall_warnings(track: Track, friction: Friction) -> list[Warned]:
    """Return a warning if a scene's coefficient of sliding friction is as small as overall coefficients of catalogues.

    Parameters
    ----------
    track
        Track of the balls; the efficiency is stated for a track with a lead.
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
        f"{brief}; here it is about 0.1 with grease, less with a full film: if an overall coefficient was meant, friction "
        "torque and losses are several times too small"
    )
    return [Warned("coefficient", text, brief)]
