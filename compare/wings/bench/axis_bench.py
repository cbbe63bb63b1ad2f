"""Run times of several rolling sets on one shaft: a double nut, and how the cost grows with the number of sets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from rollbench.compare.scenes.catalogue import shipped
from rollbench.compare.wings.bench.costs.timing import Job, timed
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.contacts import forget_nominal
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.axis import Assembly, Housing, RollingSet, diagonal
from rollbench.meshes.memory import peak_MB
from rollbench.meshes.parts import Scene

#: Numbers of nuts in the row whose slope is given; time of a double nut that is aimed at [s].
SETS, AIM = (2, 4, 8, 16), 5e-3


def double_nut() -> Assembly:
    """The shipped double nut of 136 balls."""
    found = shipped("double-nut")
    if not isinstance(found, Assembly):
        raise AssertionError("double-nut has two sets")
    return found


def row_of_nuts(count: int) -> Assembly:
    """Nuts of the double nut, each in a housing on springs, along one shaft."""
    base = double_nut()
    first, pitch = base.sets[0], 0.06
    screw = replace(base.screw, length=pitch * (count + 1))
    sets, housings = [], []
    for i in range(count):
        z, name = pitch * (i + 1), f"housing {i}"
        if not isinstance(first.parts, Scene):
            raise AssertionError("the set is a nut")
        set_screw = replace(first.parts.screw, length=screw.length)
        parts = replace(first.parts, screw=set_screw, nut=replace(first.parts.nut, position=z))
        sets.append(RollingSet(f"nut {i}", "ball nut", parts, z, name))
        housings.append(Housing(name, z, (), diagonal((1e9, 1e9, 1e9, 1e6, 1e6, 1e6))))
    return replace(base, screw=screw, sets=tuple(sets), housings=tuple(housings))


def jobs(repeats: int = 5) -> Iterator[Job]:
    """The double nut cold (geometry unknown) beside one nut of as many balls, and rows of nuts; compiled, one core."""
    pair = double_nut()
    nut = pair.sets[0].parts
    if not isinstance(nut, Scene):
        raise AssertionError("the set is a nut")
    whole = replace(nut, nut=replace(nut.nut, position=0.2, length=0.1), supports=pair.supports, loads=pair.loads)
    one = replace(whole, balls=replace(nut.balls, azimuths=tuple(float(x) for x in np.linspace(-27.0, 27.0, 136))))
    single = timed(lambda: solve_static(one, engine="compiled"), repeats, forget_nominal)
    double = timed(lambda: solve_assembly(pair, engine="compiled"), repeats, forget_nominal)
    rows = [row_of_nuts(count) for count in SETS]
    times = [timed(partial(solve_assembly, row, engine="compiled"), repeats) for row in rows]
    note = f"136 balls, set-up and stiffness included (aim {1e3 * AIM:g} ms); one nut of 136 balls takes "
    yield Job("double nut, lin", double, None, None, peak_MB(), f"{note}{single / double:.2f} of it")
    slope = float(np.polyfit(np.log(SETS), np.log(times), 1)[0])
    per_set = ", ".join(f"{1e3 * t / c:.1f}" for t, c in zip(times, SETS, strict=True))
    note = f"{SETS[-1]} nuts of 68 balls in housings on springs; {per_set} ms a set with {', '.join(map(str, SETS))}, "
    yield Job("nuts on one shaft, lin", times[-1], None, None, peak_MB(), f"{note}exponent {slope:.2f}")
