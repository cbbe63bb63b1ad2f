"""What is kept of shaft and bodies serves the problems that share it, and no others."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.response import cached_compliance
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.parts import FREEDOMS, BallErrors, FourierTerm, Load, Scene, SideErrors, Support

BARE = small_screw(count=8, turns=1.5, lead=12e-3, force=(40.0, 20.0, 900.0), oversize=3e-6)
LENGTH = BARE.screw.length
#: With a node beyond the nut that carries nothing.
SCREW = replace(BARE, loads=(*BARE.loads, Load(LENGTH, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))))


def with_errors(**errors: object) -> Scene:
    return replace(SCREW, errors=replace(SCREW.errors, **errors))


def ends(first: float, *, tilt: float = 0.0) -> Scene:
    held = Support(first, tuple((name, 0.0) for name in ("ux", "uy", "rx", "ry", "rz")))
    return replace(SCREW, supports=(held, Support(LENGTH, (("ux", tilt), ("uy", 0.0)))))


#: Changes that leave the response as it is, and others; of the screw, but for one whose supports are displaced.
SAME = {
    "another load": replace(SCREW, loads=tuple(replace(x, force=tuple(0.5 * f for f in x.force)) for x in SCREW.loads)),
    "larger balls": with_errors(balls=BallErrors(oversize=5e-6)),
    "one ball larger": with_errors(balls=BallErrors(oversize=3e-6, listed=((3, 1e-6),))),
    "an end displaced": ends(0.0, tilt=2e-6),
}
OTHER = {
    "no load at all": replace(SCREW, loads=()),
    "a load beyond the nut": replace(BARE, loads=(*BARE.loads, Load(LENGTH, (0.0, 0.0, 50.0), (0.0, 0.0, 0.0)))),
    "held along its axis": replace(SCREW, supports=(Support(0.0, tuple((name, 0.0) for name in FREEDOMS)),)),
    "two supports": ends(0.0),
    "one of them elsewhere": ends(0.01),
    "pitch errors": with_errors(SL=SideErrors(pitch=(FourierTerm(1.0, 20e-6, 0.0),))),
    "uneven flanks": with_errors(NR=SideErrors(profile=(0.0, 2e-6))),
    "nominal arms": replace(SCREW, ingredients=replace(SCREW.ingredients, arm="nominal")),
    "another nut": replace(SCREW, nut=replace(SCREW.nut, outer_diameter=1.1 * SCREW.nut.outer_diameter)),
    "balls turned on": replace(SCREW, balls=replace(SCREW.balls, azimuths=tuple(a + 0.1 for a in SCREW.balls.azimuths))),
}


def alike(a: StaticResult, b: StaticResult) -> bool:
    """Whether two results are the same to the last digit."""
    assert a.status == b.status == "converged"
    return np.array_equal(a.load, b.load) and np.array_equal(a.centreline, b.centreline)


@pytest.mark.parametrize("change", [*SAME, *OTHER])
def test_a_kept_response_gives_the_digits_of_a_new_one(change: str) -> None:
    scene = (SAME | OTHER)[change]

    def solve(scene: Scene) -> StaticResult:
        return solve_elastic(scene, backend=LADDER["lin-nut"])

    cached_compliance.cache_clear()
    new = solve(scene)
    cached_compliance.cache_clear()
    other = solve(ends(0.0) if change == "an end displaced" else SCREW)
    before = len(cached_compliance.kept)
    assert alike(solve(scene), new)
    assert not alike(other, new)
    assert (len(cached_compliance.kept) == before) == (change in SAME)
