"""Scenes of chapter 3 as rolling balls: input of the 3D model, and the values by the low-order model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.compare.cases.lin.kinds.bearings import BearingBallScene, LinearBearingScene
from rollbench.compare.cases.lin.kinds.linear_friction import linear_bearing_loads
from rollbench.compare.cases.lin.kinds.screw_balls import ScrewPairScene
from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling.cases import MOST, RollingCase, RollingOfKind
from rollbench.hifi.rolling import scenes as rolling_scenes
from rollbench.hifi.rolling.balls import RollingSettings
from rollbench.lowfi.friction.bearing import SIDES as RING_SIDES
from rollbench.lowfi.friction.bearing import solve_ball_of_bearing
from rollbench.lowfi.friction.linear.chain import carriage_drive_force, prepare_linear_chain, velocity_deviations
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain
from rollbench.lowfi.friction.screw.run import solve_pair_of_screw_balls
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDE_SIGNS, SIDES

#: Signs of the components x, y of the directions of a ball's contacts, in the order BL, BR, TR, TL (bottom left to top
#: left) of a linear bearing, or IL, IR, OR, OL (inner left to outer left) of a rotary one.
LINEAR = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
RING = LINEAR
#: Whether each contact of a linear bearing is on the part that moves.
MOVING = np.array([False, False, True, True])


def _refuse_scene(scene: FrictionScene, key: str, reason: str, advice: str) -> None:
    """Raise SceneNotCoveredError for a feature of a scene that the 3D model of rolling does not cover.

    ``key``: key of the scene file with this feature; ``reason`` and ``advice``: parts of the message.
    """
    raise SceneNotCoveredError(scene.name, key, reason, advice)


def _contact_directions(angles: Array, signs: Array) -> Array:
    """Return unit vectors (..., 2) along contact normals in the cross-section of the groove.

    ``angles``: contact angles (...,) [rad]; ``signs``: signs of the two components (..., 2).
    """
    return np.asarray(signs * np.stack([np.sin(angles), np.cos(angles)], axis=-1))


def _linear_bearing_as_rolling_case(scene: LinearBearingScene, _: RollingSettings) -> RollingCase:
    """Return a linear bearing's balls as input of the 3D model of rolling.

    Raises SceneNotCoveredError for too many balls or no motion.
    """
    b, count = scene.bearing, len(scene.side)
    if count > MOST:
        reason = f"the 3D model of rolling solves at most {MOST} balls, got {count}"
        _refuse_scene(scene, "chain", reason, "take fewer balls")
    if b.speed == 0.0:
        _refuse_scene(scene, "motion.carriage", "balls at rest do not roll", "let the carriage move")
    layout = rolling_scenes.place_balls_on_straight_track(
        b.ball_radius, 2.0 * b.conformity * b.ball_radius, count, MOVING, b.speed, np.asarray(scene.gap) <= 0.0
    )
    material = rolling_scenes.RollingMaterial(b.young, b.poisson, b.mu, b.mu_balls)
    normals = _contact_directions(scene.angles, LINEAR)
    each = [(n, float(ratio)) for n, ratio in zip(normals, scene.side, strict=True)]
    if scene.distribution == "elastic":
        found = [_loads_with_elastic_angles(scene, layout, material, *of_ball) for of_ball in each]
        normals, loads = (np.array(x) for x in zip(*found, strict=True))
    else:
        loads = np.array([_loads_at_given_angles(scene, *of_ball) for of_ball in each])
    whole = rolling_scenes.create_rolling_balls(layout, material, normals, loads)
    apart = replace(whole, ball_to_ball_contacts=())
    return RollingCase(scene.kind, apart, whole, b.speed, ("BL", "BR", "TR", "TL"))


def _loads_at_given_angles(scene: LinearBearingScene, normals: Array, rho: float) -> Array:
    """Return the contact loads (4,) [N] in equilibrium on one ball of a linear bearing, at given contact angles.

    ``normals``: contact normals (4, 2) at the bottom left, bottom right, top right and top left of the ball, which are
    replaced by those of the nominal contact angle if the scene's distribution of loads is "diagonal"; ``rho``: side force
    over vertical force.
    """
    if scene.distribution == "diagonal":
        normals = _contact_directions(np.full(4, scene.bearing.contact_angle), LINEAR)
    carriage = scene.vertical * np.array([rho, -1.0])
    bottom, top = np.linalg.solve(normals[:2].T, carriage), np.linalg.solve(normals[2:].T, -carriage)
    return np.asarray(np.maximum(np.concatenate([bottom, top]), 0.0))


def _loads_with_elastic_angles(
    scene: LinearBearingScene,
    layout: rolling_scenes.BallLayoutOnTrack,
    material: rolling_scenes.RollingMaterial,
    normals: Array,
    rho: float,
) -> tuple[Array, Array]:
    """Return contact normals (4, 2), then contact loads (4,) [N], of a linear bearing's ball with elastic contact angles.

    ``layout``: geometry of the balls; ``normals``: contact normals without load (4, 2); ``rho``: side force over
    vertical force.
    """
    C = rolling_scenes.hertz_constants(layout, material)
    pull = scene.vertical * np.array([rho, -1.0])
    reach = layout.groove_radius - layout.ball_radius
    none, tight = np.zeros((1, 2)), np.zeros((1, 4))
    problem = rolling_scenes.StaticProblem(normals[None], reach, tight, C[None], MOVING, np.eye(2)[None], none, pull, none)
    found = rolling_scenes.solve_static_problem(problem)
    if not found.converged:
        advice = 'change the forces on the balls, or take distribution = "balanced"'
        _refuse_scene(scene, "load", "the contact loads find no equilibrium with the forces on a ball", advice)
    return found.normal[0], found.force[0]


def _screw_balls_as_rolling_case(scene: ScrewPairScene, choices: RollingSettings) -> RollingCase:
    """Return two balls of a ball screw as input of the 3D model of rolling.

    ``choices``: grid of the contacts. Raises SceneNotCoveredError for features that the model does not have: Hertz
    constants as printed in Lin's thesis, friction that moves the screw, and a groove at rest.
    """
    pair, g = scene.pair, scene.pair.groove
    if g.hertz != "right":
        reason = "the 3D model of rolling cannot use the Hertz constants printed in Lin's thesis"
        _refuse_scene(scene, "ingredients.hertz", reason, 'take hertz = "nominal"')
    if pair.coupling == "ball and screw":
        reason = "friction does not move the screw in the 3D model of rolling"
        _refuse_scene(scene, "friction.coupling", reason, 'take coupling = "none" or "ball"')
    if g.speed == 0.0:
        _refuse_scene(scene, "motion.speed", "balls at rest do not roll", "let nut or screw turn")
    signs = np.array(SIDE_SIGNS, dtype=float)
    outward = signs[:, 0]
    groove_speeds = np.where(outward < 0.0, g.screw_speed, g.nut_speed)
    radii, count = (g.ball_radius, g.groove_radius, g.pitch_radius), len(pair.theta)
    layout = rolling_scenes.place_balls_along_helix(*radii, g.lead, g.contact_angle, outward, groove_speeds, count)
    material = rolling_scenes.RollingMaterial(g.young, g.poisson, g.mu, g.mu if g.mu_balls is None else g.mu_balls)
    angles = g.contact_angle + np.array(pair.theta)[:, None] * np.array(pair.pattern)
    normals = signs * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    fixed = dict(zip("xyz", np.eye(3), strict=True))
    motions = np.empty((count, 2, len(pair.free)))
    for i, axes in enumerate(layout.ball_axes):
        for k, name in enumerate(pair.free):
            motions[i, :, k] = [1.0, 0.0] if name == "r" else layout.section_directions @ (axes @ fixed[name])
    problem = rolling_scenes.StaticProblem(
        unloaded_normals=normals,
        radius_difference=layout.groove_radius - layout.ball_radius,
        interference=np.full((count, 4), pair.oversize),
        hertz_constants=np.tile(rolling_scenes.hertz_constants(layout, material), (count, 1)),
        on_inner_body=outward < 0.0,
        inner_body_motions=motions,
        inner_body_displacement=np.zeros((count, 2)),
        forces_on_inner_body=np.array(pair.force),
        forces_on_balls=np.zeros((count, 2)),
    )
    coupled = pair.coupling == "ball"
    scenes = []
    for meet in (False, True):
        if coupled:
            loads, good = rolling_scenes.solve_loads_with_rolling(layout, material, problem, choices, balls_may_touch=meet)
        else:
            loads = rolling_scenes.solve_static_problem(problem)
            good = loads.converged
        if not good:
            _refuse_scene(scene, "load", "the contact loads find no equilibrium with friction", 'take coupling = "none"')
        scenes.append(rolling_scenes.create_rolling_balls(layout, material, loads.normal, loads.force))
    apart = replace(scenes[0], ball_to_ball_contacts=())
    return RollingCase(scene.kind, apart, scenes[1], g.speed, SIDES)


def _bearing_ball_as_rolling_case(scene: BearingBallScene, _: RollingSettings) -> RollingCase:
    """Return one ball of a rotary bearing as input of the 3D model of rolling.

    Raises SceneNotCoveredError for features that the model does not have: friction laws other than Coulomb's, Hertz
    constants other than the exact ones, and a ring at rest.
    """
    b = scene.bearing
    if scene.law != "coulomb" or b.hertz != "right":
        reason = "the 3D model of rolling has Coulomb's law and exact geometry only"
        _refuse_scene(scene, "friction.law", reason, 'take law = "coulomb"')
    if b.screw_speed == 0.0:
        _refuse_scene(scene, "motion.speed", "a ball at rest does not roll", "let the ring turn")
    outward = RING[:, 1]
    speeds = np.where(outward < 0.0, b.screw_speed, 0.0)
    radii = b.ball_radius, b.groove_radius, b.pitch_radius
    layout = rolling_scenes.place_ball_in_ring(*radii, b.contact_angle, outward, speeds)
    material = rolling_scenes.RollingMaterial(b.young, b.poisson, b.mu, b.mu)
    problem = rolling_scenes.StaticProblem(
        unloaded_normals=_contact_directions(np.full(4, b.contact_angle), RING)[None],
        radius_difference=b.groove_radius - b.ball_radius,
        interference=np.full((1, 4), -b.clearance),
        hertz_constants=rolling_scenes.hertz_constants(layout, material)[None],
        on_inner_body=outward < 0.0,
        inner_body_motions=np.array([[[1.0], [0.0]]]),
        inner_body_displacement=np.array([[0.0, scene.displacement]]),
        forces_on_inner_body=np.array([scene.force]),
        forces_on_balls=np.zeros((1, 2)),
    )
    loads = rolling_scenes.solve_static_problem(problem)
    if not loads.converged:
        _refuse_scene(
            scene, "load", "the contact loads find no equilibrium with the load", "take a load that presses the ball"
        )
    whole = rolling_scenes.create_rolling_balls(layout, material, loads.normal, loads.force)
    return RollingCase(scene.kind, whole, whole, b.screw_speed, ("IL", "IR", "OR", "OL"))


def _linear_bearing_values(scene: LinearBearingScene) -> tuple[dict[str, float], str]:
    """Solve the balls of a linear bearing by the low-order model; return forces, speeds and losses, then the status.

    The values are in a dictionary by names that end in the unit, such as "force 1-2 N".
    """
    angles, force, _ = linear_bearing_loads(scene)
    chains = (prepare_linear_chain(scene.bearing, angles, force, touch) for touch in (False, scene.gap <= 0.0))
    apart, near = (solve_motion_of_chain(chain) for chain in chains)
    out = {f"force {k + 1}-{k + 2} N": float(f) for k, f in enumerate(near.ball_force[:-1])}
    deviations = velocity_deviations(scene.bearing, apart)
    out |= {f"deviation {k + 1} apart %": 100.0 * float(v) for k, v in enumerate(deviations)}
    out |= {"loss apart mW": 1e3 * apart.loss, "loss touching mW": 1e3 * near.loss}
    out |= {"drive apart N": carriage_drive_force(apart.wrench), "drive touching N": carriage_drive_force(near.wrench)}
    out["increase %"] = 100.0 * (near.loss / apart.loss - 1.0)
    return out, "converged" if apart.converged and near.converged else "not converged"


def _screw_pair_values(scene: ScrewPairScene) -> tuple[dict[str, float], str]:
    """Solve two balls of a screw by the low-order model; return forces, speeds and losses, then the status.

    The values are in a dictionary by names that end in the unit, such as "force 1-2 N".
    """
    found = solve_pair_of_screw_balls(scene.pair)
    apart, near = found.apart.motion, found.touching.motion
    out = {"force 1-2 N": found.force}
    out |= {f"orbit {k + 1} apart rad/s": float(q[0]) for k, q in enumerate(apart.q)}
    out |= {"loss apart mW": 1e3 * apart.loss, "loss touching mW": 1e3 * near.loss}
    out["increase %"] = 100.0 * found.friction_increase
    return out, "converged" if found.converged else "loads and friction do not agree"


def _bearing_ball_values(scene: BearingBallScene) -> tuple[dict[str, float], str]:
    """Solve one ball of a rotary bearing by the low-order model; return forces, speeds, losses and torque, then the status.

    The values are in a dictionary by names that end in the unit, such as "torque N mm".
    """
    found = solve_ball_of_bearing(scene.bearing, scene.force, scene.displacement)
    q, loss = found.motion.unknown_velocities, found.motion.friction.loss
    out = {"orbit rad/s": float(q[0]), "omega x rad/s": float(q[1]), "omega y rad/s": float(q[2])}
    out |= {f"loss {n} mW": 1e3 * float(v) for n, v, f in zip(RING_SIDES, loss, found.load.force, strict=True) if f > 0.0}
    out["torque N mm"] = 1e3 * found.inner_ring_torque
    return out, "failed" if found.motion.status == "failed" else "converged"


_LINEAR = _linear_bearing_as_rolling_case, _linear_bearing_values
#: How the scenes of each kind are solved as rolling balls.
ROLLING: dict[str, RollingOfKind] = {
    "linear pair": _LINEAR,
    "linear chain": _LINEAR,
    "screw pair": (_screw_balls_as_rolling_case, _screw_pair_values),
    "bearing ball": (_bearing_ball_as_rolling_case, _bearing_ball_values),
}
