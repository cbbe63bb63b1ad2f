"""Liu's self-adjusting axial model of a single nut (Liu et al. 2025, section 2), applied to a scene.

Numbers in parentheses are equations of Liu et al.; the equations are solved in `lowfi.as_source.liu.chain`. The axial load
enters screw and nut at that end of the row of balls which is nearer to it. Seen from this end, a segment of the screw (a
bar with grooved section) and of the nut (a tube) behind each ball carries the sum of the loads of all balls behind it (5).
Contact angles change by (10). The error of a ball is its interference with a pair of flanks along the nominal contact
normal (3). The stiffness of both segments together may be given in place of their cross-sections, which is how the
publication's own screw is described: it prints no cross-sections.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.as_source.liu.chain import BallScrewChain, BallScrewState, Law, contact_angle_sine, solve_ball_screw
from rollbench.lowfi.as_source.mei import axial_equilibrium, axial_result, nut_tensile_stiffness
from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.statics import contacts
from rollbench.lowfi.statics.problem import place_balls
from rollbench.lowfi.statics.result import SolverReport, StaticResult, Status
from rollbench.lowfi.statics.validity import contact_warnings
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.one_arc import distance_of_groove_centres
from rollbench.meshes.parts import Scene, UnfitKey
from rollbench.meshes.section import screw_section

#: Assumptions of every result of Liu's model.
ASSUMPTIONS = (
    "axial displacements only: no bending, no torsion, no lateral load or moment (Liu et al. 2025, 2.2)",
    "screw and nut are fixed and loaded at the same end of the row of balls, the one at the load (Liu et al. 2025, eq. 5)",
    "contact angles change by Liu et al. 2025, eq. 10; errors count along the contact normal (eq. 3)",
)
#: Effects that Liu's model neglects.
LEFT_OUT = (
    "lateral forces, moments, bending and torsion: the model is axial",
    "flanks that press against the load: each ball has one contact with the screw and one with the nut",
)


@dataclass(frozen=True)
class SpringRow:
    """The M balls of a single nut in Liu's axial model: springs between screw and nut, ordered from the loaded end."""

    #: Parameters of Liu's equations: stiffness of the contacts, compliance of the segments of screw and nut between balls,
    #: and contact geometry.
    liu_chain: BallScrewChain
    #: Number in the scene of each ball of the row, which is ordered from the loaded end ``(M,)``.
    ball_order: NDArray[np.int64]
    #: Interference of each ball by errors along the contact normal, ordered from the loaded end ``(M,)`` [m].
    interferences: Array
    #: Axial load on the screw [N].
    axial_load: float
    #: 1 if the load points towards larger z, else -1.
    load_direction: int
    #: Axial position of the ball at the loaded end [m].
    loaded_end_position: float
    #: Axial position of the load that is nearest to the balls [m].
    load_position: float
    #: Tensile compliance of a screw segment between two balls, as a fraction of the summed compliances of this segment and
    #: the nut segment beside it.
    screw_compliance_share: float
    #: Tensile stiffness E A of the screw [N].
    screw_tensile_stiffness: float

    def solve_under_load(self, force: float) -> BallScrewState:
        """Return the loads and motions of the balls by Liu's equations under a positive axial load ``force`` [N]."""
        return solve_ball_screw(self.liu_chain, self.interferences, force)

    def stiffness(self, step: float = 0.0) -> float | None:
        """Return the axial stiffness of the nut under the scene's load [N/m]; None without load.

        Parameters
        ----------
        step
            Load increment [N] of Liu's secant stiffness, equations (19) to (22): increment divided by the change of the
            first loaded ball's displacement. With 0 the result is the tangent stiffness at the loaded end.
        """
        if self.axial_load == 0.0:
            return None
        first = self.solve_under_load(abs(self.axial_load))
        if step == 0.0:
            return float(first.stiffness)
        last = self.solve_under_load(abs(self.axial_load) + step)
        return float(step / (last.displacement_first_loaded - first.displacement_first_loaded))


def nut_as_spring_row(scene: Scene, *, member: int = 0, law: Law = "implicit") -> SpringRow:
    """Return the balls of a single nut as nonlinear springs between screw and nut, for Liu's axial model.

    Parameters
    ----------
    scene
        Screw, nut, balls and loads.
    member
        Number of the specimen, for a scene with random errors: each number gives other errors.
    law
        How the contact angle depends on the approach: ``"implicit"``, by Liu's equations (10) and (14); ``"constant"``, not
        at all; ``"exact"``, by the geometry of the groove centres, which move along the axis only.

    Raises
    ------
    UnfitKey
        If the model does not cover the scene: preload, a screw fixed along its axis, or axial loads that do not act at one
        end of the row of balls.
    """
    layout = ball_layout(scene)
    force, beyond, low = _axial_load_and_position(scene, layout.z)
    order = np.argsort(layout.z if low else -layout.z, kind="stable").astype(np.int64)
    gaps = np.abs(np.diff(layout.z[order]))
    mean = float(gaps.mean()) if gaps.any() else 0.0
    rigid = scene.ingredients.screw == "rigid"
    screw, nut = 0.0 if rigid else 1.0 / screw_section(scene).EA, 1.0 / nut_tensile_stiffness(scene)
    pair = 0 if force >= 0.0 else 1
    C = contacts.hertz_without_errors(scene).C
    given = scene.calibration.segment_stiffness
    springs = float((C[pair] + C[3 - pair]) ** -1.5), mean * (screw + nut) if given is None else 1.0 / given
    angles = scene.track.contact_angle, abs(lead_angle(scene.track))
    spacing = tuple(float(x) for x in gaps / mean) if mean > 0.0 else ()
    chain = BallScrewChain(scene.ball_count, *springs, distance_of_groove_centres(scene), *angles, law, spacing)
    errors = place_balls(scene, draw_geometry_with_errors(scene, layout, member)).interference[order, pair]
    forward = 1 if force >= 0.0 else -1
    bar = np.inf if rigid else 1.0 / screw
    return SpringRow(chain, order, errors, force, forward, float(layout.z[order[0]]), beyond, screw / (screw + nut), bar)


def _axial_load_and_position(scene: Scene, z: Array) -> tuple[float, float, bool]:
    """Return the axial load [N], its axial position [m], and whether it acts at lower z than all balls.

    The load is the sum of all axial loads; the position is that of the load nearest to the balls.

    Parameters
    ----------
    scene
        Screw, nut, balls and loads.
    z
        Axial positions of the balls [m].

    Raises
    ------
    UnfitKey
        If Liu's model does not cover the scene.
    """
    if scene.errors.balls.oversize > 0.0 or scene.errors.lead_offset != 0.0:
        key = "errors.lead_offset" if scene.errors.lead_offset else "errors.balls.oversize"
        reason = "Liu's model has no preload, since each ball has one contact with the screw and one with the nut"
        raise UnfitKey(key, f"{reason}; set it to 0, or use the model lin")
    if any(name == "uz" for s in scene.supports for name, _ in s.fixed):
        reason = "Liu's model balances the axial load by the nut only; leave uz of the screw free, or use the model lin"
        raise UnfitKey("supports", reason)
    loads = [x for x in scene.loads if x.force[2] != 0.0]
    slack = 0.5 * scene.balls.radius
    below, above = ([x for x in loads if s * (x.at - end) <= slack] for s, end in ((1.0, z.min()), (-1.0, z.max())))
    if len(below) < len(loads) and len(above) < len(loads):
        reason = "Liu's model has axial loads at one end of the ball row only; move all axial loads beyond the same end"
        raise UnfitKey("loads", reason)
    low = len(below) == len(loads)
    ends = [x.at for x in loads] or [float(z.min())]
    return sum(x.force[2] for x in loads), max(ends) if low else min(ends), low


def is_solvable_by_liu(scene: Scene) -> bool:
    """Return whether Liu's model covers a scene and only axial loads act on its screw.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    try:
        _axial_load_and_position(scene, ball_layout(scene).z)
    except UnfitKey:
        return False
    return all(x.force[0] == x.force[1] == 0.0 and not any(x.moment) for x in scene.loads)


def solve_liu(scene: Scene, *, member: int = 0, law: Law = "implicit") -> StaticResult:
    """Compute the contact loads of a single nut by Liu's self-adjusting axial model.

    The model is valid if contact approaches are small against the distance of the groove centres, and if the balls are
    distributed evenly, so that the nut's wall is not widened locally. The result contains motions of the screw relative to
    the nut's loaded end, which is at rest; without load the screw is at its nominal position.

    Parameters
    ----------
    scene
        Screw, nut, balls and loads.
    member
        Number of the specimen, for a scene with random errors: each number gives other errors.
    law
        How the contact angle depends on the approach: ``"implicit"``, by Liu's equations (10) and (14); ``"constant"``, not
        at all; ``"exact"``, by the geometry of the groove centres, which move along the axis only.

    Raises
    ------
    UnfitKey
        If the model does not cover the scene, see `nut_as_spring_row`.
    ValueError
        If errors reach half the distance of the groove centres.

    References
    ----------
    Liu et al. (2025), section 2.
    """
    start = perf_counter()
    row, layout = nut_as_spring_row(scene, member=member, law=law), ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout, member)
    m, pair, chain = layout.z.size, 0 if row.load_direction > 0 else 1, row.liu_chain
    force, sine = np.zeros(m), np.full(m, np.sin(chain.contact_angle))
    moved, state = np.zeros(m), None
    if row.axial_load != 0.0:
        state = row.solve_under_load(abs(row.axial_load))
        force = state.load
        sine, _ = contact_angle_sine(chain, row.interferences, contact_approach(force, chain.C))
        stretch = np.concatenate([[0.0], np.cumsum(-np.diff(state.motion))])  # of screw and nut, from the loaded end
        moved = np.asarray(state.motion[0] - row.screw_compliance_share * stretch)
    load, angle = np.zeros((m, 4)), np.full((m, 4), np.nan)
    for flank in (pair, 3 - pair):
        load[row.ball_order, flank] = force
        angle[row.ball_order, flank] = np.where(force > 0.0, np.arcsin(sine), np.nan)
    axial = row.load_direction * float((force * sine).sum() * np.cos(chain.lead_angle))
    good = state is None or bool(state.converged)
    residual = 0.0 if state is None else float(state.residual)
    line = _axial_motions_along_screw(scene, row, layout.z[row.ball_order], row.load_direction * moved)
    own = contacts.hertz_of_every_contact(scene, drawn)
    steps, seconds = 0 if state is None else int(state.iterations), perf_counter() - start
    return axial_result(
        scene,
        load,
        angle,
        line,
        model="liu",
        status=Status("converged") if good else Status("not converged", f"relative residual {residual:.1e}"),
        hertz_C=contacts.hertz_constants_by_scene_choice(contacts.scene_with_error_free_hertz(scene), drawn),
        equilibrium=axial_equilibrium(row.axial_load, 0.0, -axial, max(abs(row.axial_load), 1e-300)),
        solver=SolverReport(steps, steps, residual, seconds, m, m - 1, "axial chain"),
        assumed=(*scene.assumed, *ASSUMPTIONS),
        left_out=LEFT_OUT,
        warnings=tuple(contact_warnings(own.pressure(load), own.C_a * np.cbrt(load), scene.balls.radius)),
    )


def _axial_motions_along_screw(scene: Scene, row: SpringRow, at_balls: Array, motions: Array) -> tuple[Array, Array]:
    """Return axial positions along the screw ``(k,)`` [m] and the axial motions there ``(k,)`` [m].

    Between balls and load the screw is a stretched bar. Beyond the other end of the ball row it moves as a rigid body.

    Parameters
    ----------
    scene
        Scene with the length of the screw.
    row
        Balls in Liu's model.
    at_balls
        Axial positions of the balls, from the loaded end ``(M,)`` [m].
    motions
        Motions of the screw at the balls ``(M,)`` [m].
    """
    ends = np.array([0.0, scene.screw.length, row.load_position])
    outside = ends[(ends < at_balls.min()) | (ends > at_balls.max())]
    near = np.abs(outside - at_balls[0]) <= np.abs(outside - at_balls[-1])
    reach = np.minimum(np.abs(outside - row.loaded_end_position), abs(row.load_position - row.loaded_end_position))
    motion = np.where(near, motions[0] + row.axial_load * reach / row.screw_tensile_stiffness, motions[-1])
    stations, first = np.unique(np.concatenate([at_balls, outside]), return_index=True)
    return stations, np.concatenate([motions, motion])[first]
