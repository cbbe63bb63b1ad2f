"""Table B.1: the Hertz constants with the source's faults repeated, and right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.comparison.models.study import Study, with_groove
from rollbench.comparison.wings.evidence.record import Evidence, Sheet
from rollbench.lowfi.statics.problem import nominal_hertz, printed_sides
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Errors, Scene
from rollbench.meshes.surface import principal_curvatures

#: Conformity that Table B.1 was computed with (Table 3.6), not Table 2.1's groove radius.
TABLE_CONFORMITY = 0.56


def right_sides(scene: Scene) -> dict[str, dict[str, float]]:
    """The same quantities from I^-1 II and exact elliptic integrals, keyed as in Table B.1.

    rho1 is the radius across the groove, rho2 along it (convex positive), R1 <= R2 the relative radii.
    """
    bare = replace(scene, errors=Errors())
    drawn = specimen(bare, ball_layout(bare))
    gamma = np.full(scene.ball_count, scene.track.contact_angle)
    constants = nominal_hertz(bare)
    out = {}
    for letter, side in (("S", 0), ("N", 3)):
        across, along = principal_curvatures(bare, drawn, side, gamma)[0]
        r2, r1 = 1.0 / (1.0 / scene.balls.radius + across), 1.0 / (1.0 / scene.balls.radius + along)
        out[letter] = {
            "e": float(constants.eccentricity[side]),
            "C": float(constants.C[side]),
            "C_a": float(constants.C_a[side]),
            "C_b": float(constants.C_b[side]),
            "rho1": float(1.0 / across),
            "rho2": float(1.0 / along),
            "R1": float(r1),
            "R2": float(r2),
            "rho_eq": float(np.sqrt(r1 * r2)),
        }
    return out


#: Quantities of the table by the key's first part: attribute with the faults, key of the right value, unit of the table.
QUANTITIES = {
    "e_": ("e", "e", 1.0),
    "C_": ("C", "C", 1.0),
    "C_a": ("C_a", "C_a", 1.0),
    "C_b": ("C_b", "C_b", 1.0),
    "rho1_": ("rho_1", "rho1", 1e3),
    "rho2_": ("rho_2", "rho2", 1e3),
    "R1_": ("R_1", "R1", 1e3),
    "R2_": ("R_2", "R2", 1e3),
    "rho_eq_": ("rho_eq", "rho_eq", 1e3),
}
#: The table's rows 1 and 2 of the nut are along and across the groove, those of the screw across and along.
SWAPPED = {"rho1_N": "rho2", "rho2_N": "rho1"}


def table_b_1(study: Study) -> tuple[Evidence, ...]:
    """Table B.1: as printed with conformity 0.56 and the faults, right with the same groove."""
    scene = with_groove(study.scene("lin-case1"), TABLE_CONFORMITY)
    faulty, right = dict(zip("SN", printed_sides(scene), strict=True)), right_sides(scene)
    sheet = Sheet("lin-B1")
    for letter, printed in faulty.items():
        for start, (attribute, name, unit) in QUANTITIES.items():
            key = f"{start}{letter}"
            words = f"with the faults repeated (section hertz); right: {unit * right[letter][name]:.5g}"
            true = unit * right[letter][SWAPPED.get(key, name)]
            sheet.number(key, true, words, as_printed=unit * getattr(printed, attribute))
    sheet.number("F_1", None, as_printed=faulty["S"].F_1)
    return sheet.evidence()
