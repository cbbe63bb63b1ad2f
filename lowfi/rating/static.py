"""Basic static load ratings C0 of rings (ISO 76) and ball screws (ISO 3408-5), by the most heavily loaded contact.

A contact's own rating Q_0 is the lesser of its two raceways'. Rings, as ISO 76 has it for all but self-aligning ball
bearings: the force of a pole pressure of 4,200 MPa by Hertz, whose lasting dent in ball and raceway together is about 1e-4
of the ball's diameter D. Screws, as ISO 3408-5 has it: the force of that dent itself by Palmgren's formula, lengths in mm,

    1.3e-7 Q^2/D (1/D across)(1/D along) = 1e-4 D,  so  Q_0 = 27.74 D/sqrt(across along),                             (1)

across and along the relative curvatures [1/mm] of ball and groove. Of Z balls, all loads along the axis even, or radial
ones on half a circle without clearance (Stribeck's 5):

    C_0a = Z Q_0 sin(alpha) cos(phi)  (screws; rings above 45 deg),   C_0r = Z Q_0 cos(alpha)/5  (rings up to 45 deg).  (2)

Range: parts of hardened bearing steel; ISO 76's tables take E = 207 GPa and nu = 0.3, this the materials of the scene.
"""

from __future__ import annotations

from math import cos

import numpy as np

from rollbench.lowfi.rating.contacts import ALLOWED, PALMGREN
from rollbench.lowfi.rating.life import is_thrust, rating, standard_of
from rollbench.lowfi.rating.rigidity import slope_of
from rollbench.lowfi.statics.contacts import nominal_curvatures, nominal_hertz
from rollbench.lowfi.statics.validity import DENT_PRESSURE
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

#: Largest contact force over the mean radial share of a ball, radial load and no clearance (Stribeck; ISO 76).
STRIBECK = 5.0


def contact_rating(scene: Scene) -> float:
    """Force Q_0 [N] that a contact of the scene is rated at, of one pair of opposite raceways."""
    if scene.track.lead > 0.0:
        dent = nominal_curvatures(scene)[[0, 3]].prod(axis=1)
        diameter = 2.0 * scene.balls.radius
        return float(diameter * np.sqrt(ALLOWED / (PALMGREN * dent.max())))
    of_one_newton = nominal_hertz(scene).pressure(np.ones((1, 4)))[0, [0, 3]]
    return float((DENT_PRESSURE / of_one_newton.max()) ** 3)


def static_rating(scene: Scene) -> float:
    """Basic static load rating C_0 [N] by (2): axial for a screw and a thrust bearing, radial for a ring up to 45 deg."""
    ratings = scene.ball_count * contact_rating(scene)
    if is_thrust(scene) or scene.track.lead > 0.0:
        return ratings * slope_of(scene)
    return ratings * cos(scene.track.contact_angle) / STRIBECK


@record
class Ratings:
    """Basic load ratings as computed [N]: dynamic C, static C_0; axial or radial; whose formulas."""

    dynamic: float = quantity("dynamic_N", "basic dynamic load rating C")
    static: float = quantity("static_N", "basic static load rating C0")
    axial: bool = quantity("direction", "axial or radial", show=lambda axial: "axial" if axial else "radial")
    dynamic_standard: str = quantity("dynamic_standard", "whose formulas")
    static_standard: str = quantity("static_standard", "whose formulas")


def ratings(scene: Scene) -> Ratings:
    """Both ratings of a scene. Raises ValueError as `lowfi.rating.life.contact_capacity`."""
    axial = is_thrust(scene) or scene.track.lead > 0.0
    static_standard = "ISO 3408-5" if scene.track.lead > 0.0 else "ISO 76"
    return Ratings(rating(scene), static_rating(scene), axial, standard_of(scene), static_standard)
