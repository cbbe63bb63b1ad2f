"""Case study 1 under the choices that the source leaves open, and under its faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rollbench.comparison.measure import LoadError, load_error
from rollbench.comparison.models.study import Study, with_groove
from rollbench.comparison.sources.lin.evidence.hertz_b1 import TABLE_CONFORMITY
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class Choice:
    """One choice: what it is, the result with it, and what it changes against the first, in per cent of its mean load."""

    label: str
    result: StaticResult
    change: LoadError


def choices(study: Study) -> list[Choice]:
    """Case 1 under every choice that the source leaves open, and under its faults; the first is the default."""
    base = study.solve("lin-case1")
    case = study.scene("lin-case1")
    small = with_groove(case, TABLE_CONFORMITY)
    variants: Sequence[tuple[str, Scene, str]] = (
        ("default: node at every contact, C.8 with its root, right Hertz constants", case, "lin"),
        ("partition of the source (15 mm in the nut)", study.changed("lin-case1", partition="source"), "lin"),
        ("C.8 read without the root", study.changed("lin-case1", section="groove squared"), "lin"),
        ("groove ignored in the beam's section", study.changed("lin-case1", section="full"), "lin"),
        (
            "source's partition and C.8 without the root",
            study.changed("lin-case1", partition="source", section="groove squared"),
            "lin",
        ),
        ("Hertz constants as printed (faults of Table B.1)", study.changed("lin-case1", hertz="as printed"), "lin"),
        ("groove radius 0.56 x diameter, right Hertz constants", small, "lin"),
        (
            "groove radius 0.56 x diameter, as printed (Table B.1 itself)",
            replace(small, ingredients=replace(small.ingredients, hertz="as printed")),
            "lin",
        ),
        ("Hertz constants at each contact's actual geometry", study.changed("lin-case1", hertz="actual"), "lin"),
        ("lever arm frozen at the nominal contact point", study.changed("lin-case1", arm="nominal"), "lin"),
        ("force enters the beam at the ball's station", study.changed("lin-case1", arm="ball"), "lin"),
        ("source's own equations (lever arm and station follow the contact angle)", case, "source"),
        ("axial bars only, rigid nut (Mei)", case, "mei"),
        ("axial bars only, nut an elastic bar (Mei)", case, "mei-nut"),
    )
    found = [(label, study.solve(scene, model)) for label, scene, model in variants]
    return [Choice(label, result, load_error(result.load, base.load)) for label, result in found]
