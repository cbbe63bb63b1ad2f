"""Pitch against roundness errors (Lin 4.3.2) on both screws, and how the claims depend on what is not printed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rollbench.compare.cases.lin.evidence.chapter_2 import SCREWS, readings, spread, unloaded
from rollbench.compare.evidence.computations import evidence
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import entry, value_of
from rollbench.compare.sections.curves import loads
from rollbench.compare.sections.verdicts import printed_table
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Errors, Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text


def equivalent_errors(scene: Scene) -> Panel:
    """Errors along the nominal contact normal over the azimuth (Lin 4.2, 4.4)."""
    phi = np.linspace(0.0, 2.0 * np.pi, 181)
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    size = {key: value_of("lin-4.3.2", key) for key in ("e_p", "e_R")}
    pitch = size["e_p"] * np.cos(alpha) * np.sin(beta) * np.sin(phi)
    roundness = size["e_R"] * np.cos(beta) * np.sin(2.0 * phi)
    degrees = [float(x) for x in np.degrees(phi)]
    return Panel(
        "equivalent error along the contact normal",
        "azimuth / deg",
        "error / µm",
        (
            Series("pitch error", degrees, [float(x) for x in pitch], "line"),
            Series("roundness error", degrees, [float(x) for x in roundness], "line"),
        ),
    )


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    panels = [equivalent_errors(study.scene("lin-pitch-4p1"))]
    rows: list[Row] = []
    for screw, label in SCREWS.items():
        step(f"pitch and roundness errors on the screw of {label}")
        curves = []
        for kind in ("pitch", "roundness"):
            scene = study.scene(f"lin-{kind}-{screw}")
            curves.append(loads(f"{kind} error", study.solve(scene), 0, emphasis=True))
            for reading, variant in readings(scene):
                r = study.solve(variant)
                third = r.load[:, [1, 2]]
                rows.append(
                    {
                        "screw": label,
                        "error": kind,
                        "reading": reading,
                        Quantity("max", "max SL", "N", ".1f"): float(r.load[:, 0].max()),
                        Quantity("min", "min SL", "N", ".1f"): float(r.load[:, 0].min()),
                        Quantity("spread", "st. dev. / mean", "", ".3f"): spread(r),
                        Quantity("lost", "balls without contact", "", "s"): int(unloaded(r).sum()),
                        Quantity("third", "balls with a third contact", "", "s"): int((third > 0.0).any(axis=1).sum()),
                        Quantity("third_max", "largest third contact", "N", ".1f"): float(third.max()),
                        "status": r.status,
                    }
                )
        bare = replace(study.scene(f"lin-pitch-{screw}"), errors=Errors())
        curves.append(loads("no errors", study.solve(bare), 0))
        panels.append(Panel(f"screw of {label}, 1000 N: SL", "ball", "contact load / N", tuple(curves), integer_x=True))
    return Section(
        "manufacturing",
        "Steering gear (4.2), pitch against roundness errors (4.3.2)",
        (
            printed_table("manufacturing-claims", "Section 4.3.2: printed and computed", evidence(study, "lin-4.3.2")),
            Figure("manufacturing-loads", "Errors and load distribution", tuple(panels), "", 3),
            Table.of(
                "manufacturing-readings",
                "How the findings depend on what is not printed",
                rows,
                "The source's statement of two-point contact needs clearance in the grooves, which it does not give.",
            ),
            Text(
                (
                    "The conclusion holds: roundness error unloads balls and pitch error does not. One cycle per turn "
                    "of pitch error is nearly a tilt of the screw, which the screw can follow; two cycles per turn are "
                    "not. The statement that all balls stay in two-point contact does not hold without clearance: "
                    f"a groove displaced by {entry('lin-4.3.2', 'e_p').printed} µm touches balls on their unloaded side.",
                )
            ),
        ),
    )
