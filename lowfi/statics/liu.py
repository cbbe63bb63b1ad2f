"""Liu's self-adjusting model of a single nut (Liu et al. 2025, section 2) on a scene: see `lowfi.random_errors.chain`.

The axial load reaches screw and nut at the end of the balls that is nearest to it. Each segment behind a ball carries what
the balls behind it carry (5), as a bar of the screw's grooved section and one of the nut's tube; contact angles turn by
(10); an error is what a pair of flanks is closed by at the nominal place, along the contact normal (3).
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.random_errors.chain import Chain, ChainState, Law, solve_chain
from rollbench.lowfi.statics.contacts import error_free, error_free_hertz, hertz_C, own_hertz
from rollbench.lowfi.statics.mei import nut_bar
from rollbench.lowfi.statics.problem import SIGNS, distances
from rollbench.lowfi.statics.result import Equilibrium, SolverReport, StaticResult, Status
from rollbench.lowfi.statics.validity import contact_warnings
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.one_arc import distance_of_centres
from rollbench.meshes.parts import Scene, UnfitKey
from rollbench.meshes.section import screw_section

ASSUMPTIONS = (
    "axial displacements only: no bending, no torsion, no lateral load or moment (Liu et al. 2025, 2.2)",
    "screw and nut are held and loaded at the same end of the balls, that of the load (Liu's 5)",
    "contact angles by Liu's (10); errors count along the contact normal (Liu's 3)",
)
LEFT_OUT = (
    "lateral forces, moments, bending and torsion: the model is axial",
    "flanks that press against the load: a ball touches screw and nut once each",
)


@dataclass(frozen=True)
class Row:
    """Balls of a scene as Liu's axial chain of M balls, ordered from the loaded end on."""

    #: The chain.
    chain: Chain
    #: Numbers of the balls in that order ``(M,)``.
    order: NDArray[np.int64]
    #: Excess of each ball along the contact normal, in that order ``(M,)`` [m].
    errors: Array
    #: Axial load on the screw [N].
    force: float
    #: 1 where the load points towards larger z, else -1.
    forward: int
    #: Station of the ball at the loaded end [m].
    at: float
    #: Station of the load [m].
    beyond: float
    #: Part of the screw in the chain's compliance.
    share: float
    #: E A of the screw [N].
    bar: float

    def solved(self, force: float, *, compiled: bool = False) -> ChainState:
        """Return the chain's state under a load above zero [N]."""
        return solve_chain(self.chain, self.errors, force, compiled=compiled)

    def stiffness(self, step: float = 0.0) -> float | None:
        """Return the axial stiffness at the load [N/m].

        The tangent at the loaded end, or with a step of load [N] as Liu's (19) to (22), by the approach of the first loaded
        ball. None without load.
        """
        if self.force == 0.0:
            return None
        first = self.solved(abs(self.force))
        if step == 0.0:
            return first.stiffness
        last = self.solved(abs(self.force) + step)
        return step / (last.displacement_first_loaded - first.displacement_first_loaded)


def row_of(scene: Scene, *, member: int = 0, law: Law = "implicit") -> Row:
    """Return the balls of a scene as Liu's chain.

    Parameters
    ----------
    scene
        The scene.
    member
        Number of the specimen, for a scene with random errors.
    law
        Interpretation of the equation of the contact angle; Liu's is ``"implicit"``.

    Raises
    ------
    UnfitKey
        What the model does not cover: preload, a screw fixed along its axis, axial loads that do not act at one end of the
        balls.
    """
    layout = ball_layout(scene)
    force, beyond, low = _loaded_end(scene, layout.z)
    order = np.argsort(layout.z if low else -layout.z, kind="stable").astype(np.int64)
    gaps = np.abs(np.diff(layout.z[order]))
    mean = float(gaps.mean()) if gaps.any() else 0.0
    rigid = scene.ingredients.screw == "rigid"
    screw, nut = 0.0 if rigid else 1.0 / screw_section(scene).EA, 1.0 / nut_bar(scene)
    angle, pair = scene.track.contact_angle, 0 if force >= 0.0 else 1
    C = error_free_hertz(scene).C
    chain = Chain(
        scene.ball_count,
        float((C[pair] + C[3 - pair]) ** -1.5),
        mean * (screw + nut),
        distance_of_centres(scene),
        angle,
        abs(lead_angle(scene.track)),
        law,
        tuple(float(x) for x in gaps / mean) if mean > 0.0 else (),
    )
    errors = distances(scene, specimen(scene, layout, member))[1][order, pair]
    forward = 1 if force >= 0.0 else -1
    bar = np.inf if rigid else 1.0 / screw
    return Row(chain, order, errors, force, forward, float(layout.z[order[0]]), beyond, screw / (screw + nut), bar)


def _loaded_end(scene: Scene, z: Array) -> tuple[float, float, bool]:
    """Return the axial load [N], its station [m] (of several the nearest), and whether it acts below the balls at z [m]."""
    if scene.errors.balls.oversize > 0.0 or scene.errors.lead_offset != 0.0:
        key = "errors.lead_offset" if scene.errors.lead_offset else "errors.balls.oversize"
        raise UnfitKey(key, "Liu's model knows no preload: a ball touches screw and nut once each; leave the preload out")
    if any(name == "uz" for s in scene.supports for name, _ in s.fixed):
        raise UnfitKey("supports", "Liu's model takes the load from the nut: let uz of the screw free, or use lin")
    loads = [x for x in scene.loads if x.force[2] != 0.0]
    slack = 0.5 * scene.balls.radius
    below, above = ([x for x in loads if s * (x.at - end) <= slack] for s, end in ((1.0, z.min()), (-1.0, z.max())))
    if len(below) < len(loads) and len(above) < len(loads):
        raise UnfitKey("loads", "Liu's model is loaded at one end of the balls: put all axial loads beyond the same one")
    low = len(below) == len(loads)
    ends = [x.at for x in loads] or [float(z.min())]
    return sum(x.force[2] for x in loads), max(ends) if low else min(ends), low


def describes(scene: Scene) -> bool:
    """Return whether Liu's model covers a scene and only axial loads act on its screw.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    try:
        _loaded_end(scene, ball_layout(scene).z)
    except UnfitKey:
        return False
    return all(x.force[0] == x.force[1] == 0.0 and not any(x.moment) for x in scene.loads)


def solve_liu(scene: Scene, *, member: int = 0, law: Law = "implicit", compiled: bool = False) -> StaticResult:
    """Compute contact loads by Liu's self-adjusting model.

    Range: approaches small against the distance of the groove centres, balls evenly spread along bars, so that no wall of
    the nut widens. Motions are of the screw, with the nut at rest at its loaded end; without load the screw is at its
    nominal position.

    Parameters
    ----------
    scene
        The scene.
    member
        Number of the specimen, for a scene with random errors.
    law
        Interpretation of the equation of the contact angle; Liu's unless given.
    compiled
        Whether to use compiled kernels.

    Raises
    ------
    UnfitKey
        What the model does not cover, see `row_of`.
    ValueError
        Errors that reach half the distance of the groove centres.

    References
    ----------
    Liu et al. (2025), section 2.
    """
    start = perf_counter()
    row, layout = row_of(scene, member=member, law=law), ball_layout(scene)
    drawn = specimen(scene, layout, member)
    m, pair, chain = layout.z.size, 0 if row.forward > 0 else 1, row.chain
    force, sine = np.zeros(m), np.full(m, np.sin(chain.contact_angle))
    moved, state = np.zeros(m), None
    if row.force != 0.0:
        state = row.solved(abs(row.force), compiled=compiled)
        force, sine, moved = state.load, sines(chain, row.errors, state), _screw_motion(row, state)
    load, angle = np.zeros((m, 4)), np.full((m, 4), np.nan)
    for flank in (pair, 3 - pair):
        load[row.order, flank] = force
        angle[row.order, flank] = np.where(force > 0.0, np.arcsin(sine), np.nan)
    turned = np.where(np.isnan(angle), chain.contact_angle, angle)
    direction = SIGNS * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    world = np.einsum("nsa,nak->nsk", direction, np.stack([layout.radial, layout.binormal], axis=1))
    axial = row.forward * float((force * sine).sum() * np.cos(chain.lead_angle))
    good = state is None or state.converged
    residual = 0.0 if state is None else state.residual
    stations, along = _centreline(scene, row, layout.z[row.order], row.forward * moved)
    line = np.zeros((stations.size, 6))
    line[:, 2] = along
    own = own_hertz(scene, drawn)
    steps = 0 if state is None else state.iterations
    return StaticResult(
        model="liu",
        status=Status("converged") if good else Status("not converged", f"relative residual {residual:.1e}"),
        azimuth=layout.azimuth,
        z=layout.z,
        load=load,
        contact_angle=angle,
        contact_point=layout.centre[:, None, :] + scene.balls.radius * world,
        force_direction=-world,
        centre_shift=np.zeros((m, 2)),
        hertz_C=hertz_C(error_free(scene), drawn),
        centreline_z=stations,
        centreline=line,
        equilibrium=_balance(row.force, axial),
        solver=SolverReport(
            steps,
            steps,
            residual,
            perf_counter() - start,
            m,
            m - 1,
            "compiled" if compiled else "interpreted",
            "axial chain",
        ),
        assumed=(*scene.assumed, *ASSUMPTIONS),
        left_out=LEFT_OUT,
        warnings=tuple(contact_warnings(own.pressure(load), own.C_a * np.cbrt(load), scene.balls.radius)),
    )


def sines(chain: Chain, errors: Array, state: ChainState) -> Array:
    """Return the sine of the contact angle of every loaded ball of a solved chain ``(M,)``; the free angle's for others."""
    cosine = np.full(errors.size, np.cos(chain.contact_angle))
    if chain.law != "constant":
        apart = chain.groove_distance - errors + contact_approach(state.load, chain.C)
        free = chain.groove_distance - (errors if chain.law == "implicit" else 0.0)
        cosine = np.where(state.load > 0.0, free * cosine / apart, cosine)
    return np.asarray(np.sqrt(1.0 - cosine**2))


def _screw_motion(row: Row, state: ChainState) -> Array:
    """Return the motion of the screw at the balls in the load's direction ``(M,)`` [m]; the nut's loaded end is fixed."""
    lost = np.concatenate([[0.0], np.cumsum(-np.diff(state.motion))])
    return np.asarray(state.motion[0] - row.share * lost)


def _centreline(scene: Scene, row: Row, at_balls: Array, moved: Array) -> tuple[Array, Array]:
    """Return stations of the shaft and its axial motion ``(k,)`` [m]: a bar up to the load, at rest beyond the balls."""
    ends = np.array([0.0, scene.screw.length, row.beyond])
    outside = ends[(ends < at_balls.min()) | (ends > at_balls.max())]
    near = np.abs(outside - at_balls[0]) <= np.abs(outside - at_balls[-1])
    reach = np.minimum(np.abs(outside - row.at), abs(row.beyond - row.at))
    motion = np.where(near, moved[0] + row.force * reach / row.bar, moved[-1])
    stations, first = np.unique(np.concatenate([at_balls, outside]), return_index=True)
    return stations, np.concatenate([moved, motion])[first]


def _balance(applied: float, carried: float) -> Equilibrium:
    """Return the balance of axial forces on the screw [N]: of the loads, and what its contacts carry."""
    zero = np.zeros(3)
    pushed, held = np.array([0.0, 0.0, applied]), np.array([0.0, 0.0, -carried])
    return Equilibrium(pushed, zero, zero, zero, held, zero, abs(applied - carried) / max(abs(applied), 1e-300), 0.0)
