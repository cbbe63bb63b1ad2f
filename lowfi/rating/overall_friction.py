"""Overall coefficients of friction, which catalogues and calculators give, against the one of sliding that scenes have.

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
    """Efficiency against the load by (1), of a screw with an overall coefficient."""
    phi = abs(lead_angle(track))
    return tan(phi) / tan(phi + atan(coefficient))


def overall_warnings(track: Track, friction: Friction) -> list[Warned]:
    """Warning where a coefficient of sliding lies where overall coefficients do."""
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
