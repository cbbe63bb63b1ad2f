"""The other statements of the source that compare two models: Table 2.2, Figure 2.10, case 3, Tables 3.5 and 3.7."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.reference.levels import SOURCE_LEVEL
from rollbench.comparison.reference.store import load, shipped_store
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.sources.lin.evidence.loads_2_4_1 import READINGS
from rollbench.comparison.wings.rolling import runs as rolling
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.records import Row, Table

if TYPE_CHECKING:
    from rollbench.comparison.scenes.kinds import KindScene

#: Balls that are "the last few".
LAST = 3
FORCE = "force 1-2 N"
#: Scenes of the ball-to-ball forces by table and printed entries: low order, ANSYS.
FORCES = {
    "3.5 (a)": ("lin-3.5", "a_force_numerical", "a_force_ansys", "lin-pair-a"),
    "3.7 (a)": ("lin-3.7", "force_a", "ansys_a", "lin-screw-pair-a-inferred"),
    "3.7 (b)": ("lin-3.7", "force_b", "ansys_b", "lin-screw-pair-b-inferred"),
}


def other_table(study: Study) -> Table:
    """Each statement, what is computed for it, and what follows."""
    rows = [_times(study), _lateral(study), *(_case_3(study, model) for model in ("lin", DEFAULT)), *map(_force, FORCES)]
    return Table.of("reconstruction-others", "Other statements that compare the source's model with ANSYS", rows)


def _row(place: str, printed: str, computed: str, verdict: str) -> Row:
    return {"place": place, "printed": printed, "computed here": computed, "verdict": verdict}


def _times(study: Study) -> Row:
    """Times of the source's machine beside that of this project's 3D model on a mesh of the same size."""
    run = load(study.scene("lin-case1"), SOURCE_LEVEL, stores=[shipped_store()])
    hours, elements = (entry("lin-2.2", key).value or 0.0 for key in ("time_ansys_1", "elements_ansys"))
    time = (
        "no stored run" if run is None else f"{run.setup_seconds + run.solve_seconds:.0f} s with {run.unknowns:,} unknowns"
    )
    return _row(
        "Table 2.2",
        f"{hours:g} h with {elements:,.0f} elements",
        f"a 3D model of the same cells, condensed by contacts: {time}",
        "a time is its machine's and its method's: not judged; 6800 follows from the printed times",
    )


def _lateral(study: Study) -> Row:
    """Figure 2.10: the largest lateral displacement of the centreline by both models, at the stations of the 3D model."""
    low, found = study.solve("lin-case1"), study.reference("lin-case1")
    assert found is not None
    z, *motion = found.best.centreline.T
    there = [np.interp(z, low.centreline_z, low.centreline[:, k]) for k in range(2)]
    ours, theirs = (float(1e6 * np.hypot(x, y).max()) for x, y in (there, motion[:2]))
    off = 1e6 * float(np.hypot(there[0] - motion[0], there[1] - motion[1]).max())
    share = float(error_percent(off, 0.0, theirs))
    return _row(
        "Figure 2.10",
        '"good agreement in predicting the presence of lateral deformation"',
        f"largest {ours:.2f} um by the low-order model, {theirs:.2f} um in 3D, {off:.2f} um apart ({share:.0f} %)",
        "the presence comes out; in amount the two differ by that much",
    )


def _case_3(study: Study, model: str) -> Row:
    """Which reading of the right end has the printed shape: by far the most change on SR and NL of the last balls."""
    largest, right = [], []
    for reading in READINGS:
        change = study.solve(reading.offset, model).load - study.solve(reading.plain, model).load
        ball, side = (int(k) for k in np.unravel_index(int(np.abs(change).argmax()), change.shape))
        shaped = has_shape(change)
        right += [reading.label] if shaped else []
        largest.append(f"{reading.label}: most at {ball + 1} {SIDES[side]} ({change[ball, side]:+.0f} N)")
    return _row(
        "2.4.1.3, case 3",
        "the offset raises SR and NL of the last few balls most",
        f"{model}: {'; '.join(largest)}",
        f"the printed shape has: {', '.join(right) or 'none'}",
    )


def has_shape(change: Array) -> bool:
    """Whether the largest change of any contact ``(n, 4)`` is a rise on SR or NL of one of the last balls."""
    ball, side = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    return bool(side in (1, 2) and ball >= len(change) - LAST and change[ball, side] > 0.0)


def _force(case: str) -> Row:
    """A ball-to-ball force: the source's difference beside what bodies, and elements of its size, change in 3D rolling."""
    table, low_key, ansys_key, name = FORCES[case]
    low, ansys = (entry(table, key).value or np.nan for key in (low_key, ansys_key))
    scene = cast("KindScene", catalogue.shipped(name))
    coarse, fine = (rolling.load(scene, level, [shipped_store()]) for level in (SOURCE_LEVEL, 3))
    printed = f"{low:g} N, ANSYS {ansys:g} N: {float(error_percent(low, ansys)):.2f} %"
    if coarse is None or fine is None:
        return _row(f"Table {case}", printed, "no stored run", "not judged")
    value = fine.values[FORCE]
    bodies = float(error_percent(value, fine.limit[FORCE]))
    cells = float(error_percent(coarse.elastic[FORCE], value))
    needed = float(error_percent(ansys, low))
    enough = abs(needed) <= abs(cells) + abs(bodies)
    verdict = (
        "elements of that size do as much: may be its mesh"
        if enough
        else "neither bodies nor elements of that size do as much: the load state, which is not printed, or the solver"
    )
    computed = (
        f"{value:.3f} N; elastic bodies change it by {bodies:+.2f} %, elements of the source's size by {cells:+.1f} %"
    )
    return _row(f"Table {case}", f"{printed}, that is {needed:+.2f} % of the low-order force", computed, verdict)
