"""Two solvers, one set of equations: agreement, and the measured difference of the two kinematic forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from rollbench.comparison.measure import load_error
from rollbench.comparison.models.source_start import best_start
from rollbench.comparison.models.study import Study
from rollbench.reports.records import Cell, Quantity, Section, Table, Text

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


def agreement(study: Study, name: str) -> dict[str, Cell]:
    """Differences of the source's solver from the energy solver on one scene, in per cent of the mean load."""
    scene, by_energy = study.scene(name), study.solve(name)
    row: dict[str, Cell] = {"scene": name, "iterations": by_energy.solver.iterations, "residual": by_energy.solver.residual}
    kinds: tuple[Literal["arc", "source"], ...] = ("arc", "source")
    for kinematics in kinds:
        by_source = best_start(scene, kinematics)
        row[kinematics] = load_error(by_energy.load, by_source.load).max_percent if by_source.converged else None
        row[f"{kinematics}_status"] = by_source.status
        row[f"{kinematics}_iterations"] = by_source.iterations
    for arm in ("nominal", "ball"):
        frozen = study.solve(study.changed(name, arm=arm))
        row[arm] = load_error(frozen.load, by_energy.load).max_percent
    return row


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    rows = []
    for name in SCENES:
        step(f"both solvers on {name}")
        rows.append(agreement(study, name))
    columns = (
        Quantity("scene", "scene", "", "s"),
        Quantity("iterations", "iterations, energy solver", "", "s"),
        Quantity("residual", "residual", "", "g2"),
        Quantity("arc", "same equations", "% of mean", "g2"),
        Quantity("arc_iterations", "iterations, source's Newton", "", "s"),
        Quantity("source", "source's own kinematics", "% of mean", "g3"),
        Quantity("source_iterations", "iterations", "", "s"),
        Quantity("nominal", "arm frozen at nominal contact", "% of mean", ".3f"),
        Quantity("ball", "force at the ball's station", "% of mean", ".3f"),
        Quantity("source_status", "status of the source's Newton", "", "s"),
    )
    return Section(
        "formulations",
        "Two formulations of the same model",
        (
            Text(
                (
                    "The energy solver eliminates contact angles and ball centres and minimises a convex energy; the "
                    "source's own equations (2.25) keep them as unknowns and are solved by plain Newton (2.26), dense, "
                    "with a Jacobian of their own. On the same equations both agree to round-off.",
                    (
                        "The remaining difference between the two forms is kinematic. Here the groove's arc "
                        "moves rigidly with the section at the nominal contact, so that every contact force "
                        "keeps its line of action through the arc's centre. In the source's form the point of "
                        "application, its lever arm and its station follow the contact angle, and a linearised "
                        "rotation stretches the arc by half the square of the rotation. Freezing the lever arm "
                        "at the nominal contact changes more than either."
                    ),
                )
            ),
            Table("formulations-agreement", "Differences of the loads", columns, rows),
        ),
    )
