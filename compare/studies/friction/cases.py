"""Friction of the load cases of a duty cycle: each as a scene of its own, and the mean torque over all revolutions."""

from __future__ import annotations

from typing import Any

from rollbench.compare.quantities import number
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.scenes.scene_file import kind_of
from rollbench.compare.studies.friction.answer import FrictionAnswer, three
from rollbench.compare.studies.friction.axis import solve_axis
from rollbench.compare.studies.friction.whole import Choices, solve_scene
from rollbench.meshes.axis import Assembly

COLUMNS = (
    ("case", "case", "s"),
    ("share", "share", ".4g"),
    ("axial_load_N", "axial load N", ".5g"),
    ("friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("drag_torque_Nmm", "drag N mm", ".4g"),
    ("efficiency_forward_percent", "efficiency %", ".4g"),
)


def solve_cycle(cycle: DutyCycle, choices: Choices) -> FrictionAnswer:
    """Friction of every case in order; the mean torque is that of the whole work of friction over the revolutions.

    A case that does not converge leaves the others as they are, and the cycle without a mean. Raises InputError as
    `solve_scene` and `solve_axis`.
    """
    each = [
        (case, solve_axis(scene, choices) if isinstance(scene := case.scene, Assembly) else solve_scene(scene, choices))
        for case in cycle.cases
    ]
    rows: list[dict[str, Any]] = []
    for case, one in each:
        torque = one.data.get("torque") or {}
        rows.append({"case": case.name, "share": case.share} | {name: torque.get(name) for name, *_ in COLUMNS[2:]})
    failed = [case.name for case, one in each if not one.converged]
    known = [row for row in rows if row["friction_torque_Nmm"] is not None]
    worst = max(known, key=lambda row: abs(row["friction_torque_Nmm"]), default=None)
    needed = [row["friction_torque_Nmm"] if row["case"] not in failed else None for row in rows if row["share"] > 0.0]
    mean = None if None in needed else sum(row["share"] * row["friction_torque_Nmm"] for row in rows if row["share"] > 0.0)
    words = "" if mean is not None else f"none, because case {failed[0]} has no friction" if failed else "no load"
    largest = "none" if worst is None else f"{three(worst['friction_torque_Nmm'])} N mm in case {worst['case']}"
    known_mean = words if mean is None else f"{three(mean)} N mm"
    lines = [("torque", f"largest of friction {largest}; mean over the duty cycle {known_mean}")]
    for case, one in each:
        lines += [("", ""), ("case", f"{case.name}, share {case.share:.4g}: {one.data['status']}"), *one.lines]

    def every(key: str) -> list[Any]:
        return list(dict.fromkeys(line for _, one in each for line in one.data.get(key, ())))

    data: dict[str, Any] = {
        "scene": cycle.name,
        "title": cycle.title,
        "kind": kind_of(cycle),
        "status": "; ".join(f"case {c.name}: {one.data['status']}" for c, one in each if not one.converged) or "converged",
        "converged": not failed,
        "summary": {
            "largest_friction_torque_Nmm": worst and worst["friction_torque_Nmm"],
            "largest_friction_torque_case": worst and worst["case"],
            "mean_friction_torque_Nmm": None if mean is None else number(mean),
            "mean_words": words or None,
        },
        "cases": [{"case": c.name, "share": c.share} | one.data | {"scene": cycle.name} for c, one in each],
        "assumed": every("assumed"),
        "left_out": every("left_out"),
        "warnings": [w.of(f"case {case.name}") for case, one in each for w in one.data.get("warnings", ())],
    }
    tables = [(f"case {c.name}: {title}", heads, body) for c, one in each for title, heads, body in one.tables]
    balls = [(f"case {c.name}: {title}", heads, body) for c, one in each for title, heads, body in one.ball_tables]
    return FrictionAnswer(data, [("load cases", COLUMNS, rows), *tables], lines, not failed, balls)
