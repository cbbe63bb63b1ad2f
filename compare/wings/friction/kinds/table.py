"""The kinds of scenes that only friction solves, in one table."""

from __future__ import annotations

from rollbench.compare.scenes.kinds import Kind
from rollbench.compare.wings.friction.kinds import bearings, linear, screw_balls
from rollbench.compare.wings.friction.kinds.bearings import BearingBallKeys, BearingPairKeys
from rollbench.compare.wings.friction.kinds.linear import LinearChainKeys, LinearPairKeys
from rollbench.compare.wings.friction.kinds.screw_balls import ScrewPairKeys, ScrewRunKeys

KINDS = {
    "bearing ball": Kind(BearingBallKeys, bearings.ball_faults, bearings.ball_record),
    "bearing pair": Kind(BearingPairKeys, bearings.pair_faults, bearings.pair_record),
    "linear pair": Kind(LinearPairKeys, linear.faults, linear.record),
    "linear chain": Kind(LinearChainKeys, linear.faults, linear.record),
    "screw pair": Kind(ScrewPairKeys, screw_balls.faults, screw_balls.pair_record),
    "screw run": Kind(ScrewRunKeys, screw_balls.faults, screw_balls.run_record),
}
