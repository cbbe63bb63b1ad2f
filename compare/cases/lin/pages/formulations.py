"""Two solvers, one set of equations: agreement, and the measured difference of the two kinematic forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from rollbench.compare.measure import load_error
from rollbench.compare.models.study import Study
from rollbench.lowfi.as_source.static import best_start
from rollbench.reports.content import Quantity, Row, Section, Table, Text

SCENES = (
    "lin-case1",
    "lin-case2",
    "lin-case3",
    "lin-case3-offset",
    "lin-case3-clamped",
    "lin-case3-offset-clamped",
    "lin-pitch",
    "lin-random",
    "lin-nominal-4p1",
)


def agreement(study: Study, name: str) -> Row:
    """Differences of the source's solver from the energy solver on one scene, in per cent of the mean load."""
    scene, by_energy = study.scene(name), study.solve(name)
    solver = by_energy.solver
    row: Row = {
        "scene": name,
        Quantity("iterations", "iterations, energy solver", "", "s"): solver.iterations,
        Quantity("residual", "residual", "", "g2"): solver.residual,
    }
    kinds: tuple[tuple[Literal["arc", "source"], str, str, str], ...] = (
        ("arc", "same equations", "g2", "iterations, source's Newton"),
        ("source", "source's own kinematics", "g3", "iterations"),
    )
    for kinematics, heading, form, counted in kinds:
        by_source = best_start(scene, kinematics)
        off = load_error(by_energy.load, by_source.load).max_percent if by_source.converged else None
        row[Quantity(kinematics, heading, "% of mean", form)] = off
        row[Quantity(f"{kinematics}_iterations", counted, "", "s")] = by_source.iterations
    for arm, heading in (("nominal", "arm frozen at nominal contact"), ("ball", "force at the ball's station")):
        frozen = study.solve(study.changed(name, arm=arm))
        row[Quantity(arm, heading, "% of mean", ".3f")] = load_error(frozen.load, by_energy.load).max_percent
    return row | {Quantity("source_status", "status of the source's Newton", "", "s"): by_source.status}


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    rows = []
    for name in SCENES:
        step(f"both solvers on {name}")
        rows.append(agreement(study, name))
    return Section(
        "formulations",
        "Two formulations of the same model",
        (
            Text(
                (
                    "The energy solver eliminates contact angles and ball centres and minimises a convex energy; the "
                    "source's own equations (2.25) keep them as unknowns and are solved by plain Newton (2.26), dense, "
                    "with a Jacobian of their own. On the same equations both agree to round-off.",
                    "The remaining difference between the two forms is kinematic. Here the groove's arc moves rigidly "
                    "with the section at the nominal contact, so that every contact force keeps its line of action "
                    "through the arc's centre. In the source's form the point of application, its lever arm and its "
                    "station follow the contact angle, and a linearised rotation stretches the arc by half the square "
                    "of the rotation. Freezing the lever arm at the nominal contact changes more than either.",
                )
            ),
            Table.of("formulations-agreement", "Differences of the loads", rows),
        ),
    )
