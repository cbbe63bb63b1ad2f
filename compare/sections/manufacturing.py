"""Pitch against roundness errors (Lin 4.3.2) on both screws, and how the claims depend on what is not printed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from compare.models.study import Study
from compare.printed.findings import Finding, collect, entry, share
from compare.sections.cases import FINDING_COLUMNS, finding_rows, loads
from lowfi.statics.result import StaticResult
from meshes.helix import ball_layout, lead_angle
from meshes.parts import Errors, Scene, SideErrors, Support
from reports.records import Cell, Column, Figure, Panel, Section, Series, Table, Text

SCREWS = {"4p1": "Table 4.1", "2p1": "Table 2.1"}
#: Clearances tried for the claim of two-point contact: change of every ball's radius [m].
CLEARANCES = (0.0, -1e-6, -2e-6, -3e-6, -4e-6, -5e-6)


def spread(result: StaticResult) -> float:
    """Standard deviation of the loads on SL over their mean."""
    return float(result.load[:, 0].std() / result.load[:, 0].mean())


def unloaded(result: StaticResult) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Balls without any contact."""
    return np.asarray(result.load.sum(axis=1) == 0.0)


def cycles(scene: Scene, lost: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[int, float]:
    """Dominant number of cycles per turn (1 to 4) in the pattern of lost balls, and its share of the power."""
    phi = ball_layout(scene).azimuth
    x = lost.astype(float) - lost.mean()
    power = np.array([np.abs((x * np.exp(-1j * k * phi)).sum()) ** 2 for k in range(1, 5)])
    if power.sum() == 0.0:
        return 0, 0.0
    return int(power.argmax()) + 1, float(power.max() / power.sum())


def readings(scene: Scene) -> list[tuple[str, Scene]]:
    """Supports and clearances that the source does not print."""
    rotation = (Support(0.0, (("rz", 0.0),)),)
    lateral = (Support(0.0, (("ux", 0.0), ("uy", 0.0), ("rz", 0.0))),)
    no_right = replace(scene.errors, SR=SideErrors())
    out = [
        ("as shipped: left end clamped but for axial motion", scene),
        ("left end: only rotation about the axis held", replace(scene, supports=rotation)),
        ("left end: lateral displacement and rotation about the axis held", replace(scene, supports=lateral)),
        ("error on SL only, as the formula is printed", replace(scene, errors=no_right)),
    ]
    for c in CLEARANCES[1:]:
        errors = replace(scene.errors, balls=replace(scene.errors.balls, oversize=c))
        out.append((f"ball radius smaller by {-1e6 * c:.0f} um", replace(scene, errors=errors)))
    return out


def findings(study: Study) -> list[Finding]:
    """Numbers and claims of 4.3.2."""
    table = "lin-4.3.2"
    pitch_terms = study.scene("lin-pitch-4p1").errors.SL.pitch
    round_terms = study.scene("lin-roundness-4p1").errors.SL.roundness
    force = study.scene("lin-pitch-4p1").loads[0].force[2]
    found = {
        "e_p": Finding(entry(table, "e_p"), value=1e6 * pitch_terms[0].sin, evidence="key of the scene"),
        "e_R": Finding(entry(table, "e_R"), value=1e6 * round_terms[0].sin, evidence="key of the scene"),
        "force": Finding(entry(table, "force"), value=force, evidence="key of the scene"),
    }
    for screw in SCREWS:
        pitch, roundness = study.solve(f"lin-pitch-{screw}"), study.solve(f"lin-roundness-{screw}")
        third = [r.load[:, [1, 2]].max() for r in (pitch, roundness)]
        lost = unloaded(roundness)
        count, power = cycles(study.scene(f"lin-roundness-{screw}"), lost)
        found |= {
            f"two_point_{screw}": Finding(
                entry(table, f"two_point_{screw}"),
                holds=max(third) == 0.0,
                evidence=f"a third contact carries up to {third[0]:.1f} N (pitch) and {third[1]:.1f} N (roundness); "
                "with clearance it vanishes, see table manufacturing-readings",
            ),
            f"less_uniform_{screw}": Finding(
                entry(table, f"less_uniform_{screw}"),
                holds=spread(roundness) > spread(pitch),
                evidence=f"standard deviation over mean {spread(roundness):.2f} with roundness, "
                f"{spread(pitch):.2f} with pitch error",
            ),
            f"lost_{screw}": Finding(
                entry(table, f"lost_{screw}"),
                holds=bool(lost.any()),
                evidence=f"{share(lost)} balls without contact; with pitch error {share(unloaded(pitch))}",
            ),
            f"pattern_{screw}": Finding(
                entry(table, f"pattern_{screw}"),
                holds=count == 2 if lost.any() else False,
                evidence=f"{power:.0%} of the pattern's power is at {count} cycles per turn"
                if lost.any()
                else "no ball loses contact",
            ),
        }
    return collect(table, found)


def equivalent_errors(scene: Scene) -> Panel:
    """Errors along the nominal contact normal over the azimuth (Lin 4.2, 4.4)."""
    phi = np.linspace(0.0, 2.0 * np.pi, 181)
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    pitch = 5.0 * np.cos(alpha) * np.sin(beta) * np.sin(phi)
    roundness = 5.0 * np.cos(beta) * np.sin(2.0 * phi)
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
    rows: list[dict[str, Cell]] = []
    for screw, label in SCREWS.items():
        step(f"pitch and roundness errors on the screw of {label}")
        curves = []
        for kind in ("pitch", "roundness"):
            scene = study.scene(f"lin-{kind}-{screw}")
            curves.append(loads(f"{kind} error", study.solve(scene), 0, emphasis=True))
            for reading, variant in readings(scene):
                r = study.solve(variant)
                rows.append(
                    {
                        "screw": label,
                        "error": kind,
                        "reading": reading,
                        "max": float(r.load[:, 0].max()),
                        "min": float(r.load[:, 0].min()),
                        "spread": spread(r),
                        "lost": int(unloaded(r).sum()),
                        "third": int((r.load[:, [1, 2]] > 0.0).any(axis=1).sum()),
                        "third_max": float(r.load[:, [1, 2]].max()),
                        "status": r.status,
                    }
                )
        bare = replace(study.scene(f"lin-pitch-{screw}"), errors=Errors())
        curves.append(loads("no errors", study.solve(bare), 0))
        panels.append(Panel(f"screw of {label}, 1000 N: SL", "ball", "contact load / N", tuple(curves), integer_x=True))
    columns = (
        Column("screw", "screw", "", "s"),
        Column("error", "error", "", "s"),
        Column("reading", "reading", "", "s"),
        Column("max", "max SL", "N", ".1f"),
        Column("min", "min SL", "N", ".1f"),
        Column("spread", "st. dev. / mean", "", ".3f"),
        Column("lost", "balls without contact", "", "s"),
        Column("third", "balls with a third contact", "", "s"),
        Column("third_max", "largest third contact", "N", ".1f"),
        Column("status", "status", "", "s"),
    )
    return Section(
        "manufacturing",
        "Pitch against roundness errors (4.3.2)",
        (
            Table(
                "manufacturing-claims",
                "What 4.3.2 prints, and what we find",
                FINDING_COLUMNS,
                finding_rows(findings(study)),
            ),
            Figure("manufacturing-loads", "Errors and load distribution", tuple(panels), "", 3),
            Table(
                "manufacturing-readings",
                "How the findings depend on what is not printed",
                columns,
                rows,
                "The source's statement of two-point contact needs clearance in the grooves, which it does not give.",
            ),
            Text(
                (
                    "The conclusion holds: roundness error unloads balls and pitch error does not. One cycle per turn "
                    "of pitch error is nearly a tilt of the screw, which the screw can follow; two cycles per turn are "
                    "not. The statement that all balls stay in two-point contact does not hold without clearance: "
                    "a groove displaced by 5 µm touches balls on their unloaded side.",
                )
            ),
        ),
    )
