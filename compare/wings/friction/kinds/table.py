"""The kinds of scenes that only friction solves, in one table."""

from __future__ import annotations

from rollbench.compare.scenes.kinds import Kind
from rollbench.compare.wings.friction.kinds import bearings, linear, screw_balls
from rollbench.compare.wings.friction.kinds.bearings import BearingBallKeys, BearingPairKeys
from rollbench.compare.wings.friction.kinds.linear import LinearChainKeys, LinearPairKeys
from rollbench.compare.wings.friction.kinds.screw_balls import ScrewPairKeys, ScrewRunKeys
from rollbench.compare.wings.friction.kinds.written import tables

KINDS = {
    "bearing ball": Kind(BearingBallKeys, bearings.ball_faults, bearings.ball_record, tables),
    "bearing pair": Kind(BearingPairKeys, bearings.pair_faults, bearings.pair_record, tables),
    "linear pair": Kind(LinearPairKeys, linear.faults, linear.record, tables),
    "linear chain": Kind(LinearChainKeys, linear.faults, linear.record, tables),
    "screw pair": Kind(ScrewPairKeys, screw_balls.faults, screw_balls.pair_record, tables),
    "screw run": Kind(ScrewRunKeys, screw_balls.faults, screw_balls.run_record, tables),
}
