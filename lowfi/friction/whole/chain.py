"""Balls of a scene that push each other along their track: motions, ball-to-ball forces and losses at given contacts."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field

import numpy as np

from rollbench.lowfi.friction.screw.chain import AnyChain, ChainMotion, Rubs, solve_chain
from rollbench.lowfi.friction.screw.groove import ON_SCREW, Constants, Grooved
from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.lowfi.friction.whole.losses import BallPath, ball_path, rubs_of, shares, turn_back
from rollbench.lowfi.friction.whole.torque import about_axis
from rollbench.lowfi.statics.contacts import nominal_hertz
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive


@dataclass(frozen=True, eq=False)
class SceneGrooves(BallPath, Grooved):
    """The nominal grooves of a scene in motion, one for a whole run: kernels keep arrays by it."""

    mu: float
    hertz: Constants = field(repr=False)

    @property
    def constants(self) -> Constants:
        """Hertz constants of nominal contacts."""
        return self.hertz


def grooves_of(scene: Scene, friction: Friction, drive: Drive) -> SceneGrooves:
    """Nominal grooves of a scene whose screw or nut turns."""
    path, h = ball_path(scene, drive, scene.balls.radius), nominal_hertz(scene)
    return SceneGrooves(**asdict(path), mu=max(friction.screw, friction.nut), hertz=Constants(h.C, h.C_a, h.C_b))


@dataclass(frozen=True)
class SceneChain(AnyChain):
    """Balls of their own sizes and coefficients; contacts: as friction sees them."""

    at: StaticContacts
    contacts: Rubs
    between: float

    @property
    def rubs(self) -> Rubs:
        """The contacts with their semi-axes and maps."""
        return self.contacts

    @property
    def mu_balls(self) -> float:
        """Coefficient of friction from ball to ball."""
        return self.between

    def wrench(self, pull: Array) -> Array:
        """Friction on the balls (N, 4, 6) in x3, y3, z3 of forces in the contacts' own axes (N, 4, 3)."""
        turned = pull.copy()
        turn_back(self.at, turned)
        return super().wrench(turned)

    def input_power(self, wrench: Array) -> float:
        """Power [W] of screw and nut, from forces and moments about the axis in space."""
        axial, moment = about_axis(self.at, wrench)
        helical = moment + self.groove.ratio * axial
        return float(np.sum(helical * np.where(ON_SCREW, self.groove.screw_speed, self.groove.nut_speed)))


def chain_motion(
    scene: Scene,
    at: StaticContacts,
    slack: Array,
    friction: Friction,
    drive: Drive,
    grooves: SceneGrooves,
    start: tuple[Array, Array] | None = None,
    fast: bool = True,
) -> ChainMotion:
    """Motion of the balls of one closed track, in order, ball k + 1 at the larger azimuth, and the forces between them.

    slack (N,): as in ``AnyChain``; start: motions (N, 4) [rad/s] and forces (N,) [N] to begin from. The contact of two
    balls is that of nominal ones; their sizes count in the slack. Failure is data: see ``ChainMotion.converged``.
    """
    share, top = shares(friction)
    rubs = rubs_of(scene, at, top * share, drive)
    motion = solve_chain(
        SceneChain(grooves, at.force, at.normals, slack, at, rubs, friction.between_balls), start, fast, True
    )
    for rows in (motion.seen, motion.pull):
        turn_back(at, rows)
    return motion
