"""Table B.1: the Hertz constants as printed, with the source's faults repeated, and right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from compare.measure import error_percent
from compare.models.study import Study, with_groove
from compare.printed.findings import Finding, collect, entry
from lowfi.hertz import PrintedHertz, contact_modulus, printed_hertz
from lowfi.statics.problem import nominal_hertz
from meshes.errors import specimen
from meshes.helix import ball_layout
from meshes.parts import Errors, Scene
from meshes.surface import principal_curvatures, printed_radii
from reports.records import Column, Section, Table, Text

#: Conformity that Table B.1 was computed with (Table 3.6), not Table 2.1's groove radius.
TABLE_CONFORMITY = 0.56


def printed_sides(scene: Scene) -> dict[str, PrintedHertz]:
    """Table B.1's quantities with its faults, for the screw (S) and nut (N) sides."""
    bare = replace(scene, errors=Errors())
    drawn = specimen(bare, ball_layout(bare))
    gamma = np.full(scene.ball_count, scene.track.contact_angle)
    out = {}
    for letter, side, body in (("S", 0, scene.screw), ("N", 3, scene.nut)):
        modulus = contact_modulus(
            scene.balls.material.youngs_modulus,
            scene.balls.material.poissons_ratio,
            body.material.youngs_modulus,
            body.material.poissons_ratio,
        )
        low, high = printed_radii(bare, drawn, side, gamma)[0]
        out[letter] = printed_hertz(scene.balls.radius, (float(low), float(high)), modulus)
    return out


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


def findings(study: Study) -> list[Finding]:
    """Every row of Table B.1: as printed with conformity 0.56 and the faults, right with the same groove."""
    scene = with_groove(study.scene("lin-case1"), TABLE_CONFORMITY)
    faulty, right = printed_sides(scene), right_sides(scene)
    found: dict[str, Finding] = {}
    for s in ("S", "N"):
        p = faulty[s]
        values = {
            f"e_{s}": (p.e, right[s]["e"], 1.0),
            f"C_{s}": (p.C, right[s]["C"], 1.0),
            f"C_a{s}": (p.C_a, right[s]["C_a"], 1.0),
            f"C_b{s}": (p.C_b, right[s]["C_b"], 1.0),
            f"rho1_{s}": (p.rho_1, right[s]["rho1"], 1e3),
            f"rho2_{s}": (p.rho_2, right[s]["rho2"], 1e3),
            f"R1_{s}": (p.R_1, right[s]["R1"], 1e3),
            f"R2_{s}": (p.R_2, right[s]["R2"], 1e3),
            f"rho_eq_{s}": (p.rho_eq, right[s]["rho_eq"], 1e3),
        }
        for key, (as_printed, true, unit) in values.items():
            found[key] = Finding(
                entry("lin-B1", key),
                unit * true,
                unit * as_printed,
                evidence=f"with the faults repeated (section hertz); right: {unit * true:.5g}",
            )
        if s == "N":  # the table's rows 1 and 2 of the nut are along, across
            for key, name in (("rho1_N", "rho2"), ("rho2_N", "rho1")):
                found[key] = replace(found[key], value=1e3 * right["N"][name])
    found["F_1"] = Finding(entry("lin-B1", "F_1"), as_printed=faulty["S"].F_1)
    return collect("lin-B1", found)


COLUMNS = (
    Column("label", "quantity", "", "s"),
    Column("unit", "unit", "", "s"),
    Column("printed", "printed", "", "s"),
    Column("as_printed", "as printed, ours", "", "g5"),
    Column("right", "right", "", "g5"),
    Column("error", "as printed against printed", "%", ".3f"),
    Column("fault", "printed against right", "%", ".1f"),
    Column("class", "class", "", "s"),
    Column("verdict", "verdict", "", "s"),
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("Table B.1")
    rows = []
    for f in findings(study):
        p = f.printed
        rows.append(
            {
                "label": p.label,
                "unit": p.unit,
                "printed": p.printed,
                "as_printed": f.as_printed,
                "right": f.value,
                "error": f.error_percent,
                "fault": None if f.value is None or p.value is None else float(error_percent(p.value, f.value)),
                "class": p.cls,
                "verdict": f.verdict,
            }
        )
    own = study.scene("lin-case1")
    compared = [
        ("Table 2.1's groove, 3.254 mm", own),
        ("Table B.1's groove, 0.56 x diameter", with_groove(own, TABLE_CONFORMITY)),
    ]
    constants = []
    for label, scene in compared:
        right, faulty = nominal_hertz(scene), printed_sides(scene)
        for s, side in (("S", 0), ("N", 3)):
            percent = partial(error_percent, faulty[s].C)
            constants.append(
                {
                    "groove": label,
                    "side": "screw" if s == "S" else "nut",
                    "right": float(right.C[side]),
                    "faulty": faulty[s].C,
                    "error": float(percent(float(right.C[side]))),
                    "a": 1e3 * float(right.C_a[side]) * 225.0 ** (1 / 3),
                    "b": 1e3 * float(right.C_b[side]) * 225.0 ** (1 / 3),
                    "p0": 1e-6 * float(right.pressure(np.array(225.0))[side]),
                    "approach": 1e6 * float(right.C[side]) * 225.0 ** (2 / 3),
                }
            )
    return Section(
        "hertz",
        "Hertz contact: Table B.1",
        (
            Text(
                (
                    "Table B.1 comes out to every printed digit when the source's faults are repeated: groove radius "
                    "0.56 x ball diameter instead of Table 2.1's 3.254 mm, eigenvalues of the second fundamental form "
                    "alone, the correction factor set to 1, and the ratio of B.8 inverted against the table's labels. "
                    "The right values beside it use I⁻¹ II and exact elliptic integrals with the same groove radius.",
                )
            ),
            Table("hertz-B1", "Table B.1: printed, as printed, right", COLUMNS, rows),
            Table(
                "hertz-grooves",
                "What the faults and the groove radius do to the Hertz constant, and the contact at 225 N",
                (
                    Column("groove", "groove", "", "s"),
                    Column("side", "side", "", "s"),
                    Column("right", "C, right", "m/N^(2/3)", "g5"),
                    Column("faulty", "C, as printed", "m/N^(2/3)", "g5"),
                    Column("error", "as printed against right", "%", ".1f"),
                    Column("approach", "approach", "µm", ".3f"),
                    Column("a", "semi-axis a", "mm", ".4f"),
                    Column("b", "semi-axis b", "mm", ".4f"),
                    Column("p0", "pole pressure", "MPa", ".1f"),
                ),
                constants,
            ),
        ),
    )
