"""Kinds of scenes of chapters 3 and 4 of Lin's thesis, for which only friction is computed: how their files are read."""

from __future__ import annotations

from rollbench.compare.cases.lin.kinds import bearings, screw_balls
from rollbench.compare.scenes.kinds import FrictionSceneKind

_LINEAR = bearings.linear_bearing_faults, bearings.linear_bearing_scene
_SCREW = screw_balls.ball_screw_faults
#: How the file of each kind of friction scene is read, by the name of the kind.
KINDS = {
    "bearing ball": FrictionSceneKind(
        bearings.BearingBallKeys, bearings.bearing_ball_faults, bearings.bearing_ball_scene, "lin-rotary-1"
    ),
    "bearing pair": FrictionSceneKind(
        bearings.BearingPairKeys, bearings.bearing_pair_faults, bearings.bearing_pair_scene, "lin-bearing-pairs"
    ),
    "linear pair": FrictionSceneKind(bearings.LinearPairKeys, *_LINEAR, "lin-pair-a"),
    "linear chain": FrictionSceneKind(bearings.LinearChainKeys, *_LINEAR, "lin-chain-10"),
    "screw pair": FrictionSceneKind(screw_balls.ScrewPairKeys, _SCREW, screw_balls.screw_pair_scene, "lin-screw-pair-a"),
    "screw run": FrictionSceneKind(screw_balls.ScrewSimulationKeys, _SCREW, screw_balls.screw_run_scene, "lin-screw-run"),
}
