"""3D elastic-contact reference of a ball screw or bearing: contacts of all balls of a meshed and condensed geometry.

Contact is unilateral and frictionless on matching grids of ball and groove; the balls' rigid motions are free. The pressure
is bilinear on the grid (`hifi.elements.forms`), and the mean of the gap over each of its basis functions may not be
negative. Gaps are exact distances from the ball's centre. Contact normals and gaps follow the motion of ball and groove,
and are updated until the loads no longer change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from time import perf_counter
from typing import NamedTuple

import numpy as np

from rollbench.hifi import coupling
from rollbench.hifi.contact.balls import ContactResult, SolverState, solve_contacts_of_all_balls
from rollbench.hifi.coupling import PlacedNut
from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.setup import CondensedGeometry
from rollbench.hifi.shaft.beam import ShaftSupports
from rollbench.hifi.shaft.mounting import SupportedShaft
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.parts import Scene

#: Remaining change of any contact load at which contact normals and gaps count as settled, over the mean load: a hundredth
#: of the mesh uncertainty on the finest level (0.1 %).
SETTLED = 1e-5
#: Largest number of updates of contact normals and gaps; most scenes take three or four.
ROUNDS = 30
#: Largest ratio of successive changes from which the remaining change is extrapolated: changes that decrease more slowly do
#: not converge.
SLOWEST = 0.99
#: Reason of a solution that does not converge because a contact presses on the outermost nodes of its zone.
AT_RIM = "a contact reaches the rim of its patch: the expected semi-axes are too small"
#: Seconds after which every round of a solution is reported.
SLOW = 5.0
#: Names of the parts of the 3D reference's model that can be left out, to see their effect.
INGREDIENTS = ("elastic nut", "3D shaft", "finite ball", "patch coupling", "moving normals")
#: Zero motions across and along the track, for balls in their nominal positions (`ball_motion_relative_to_grooves`).
_NO_MOTION = np.zeros((1, 1, 3)), np.zeros((1, 1))


@dataclass(frozen=True)
class ReferenceResult:
    """Contact loads, displacements and equilibrium checks of one load case, computed by the 3D reference.

    The n balls are those of the first nut or bearing on the shaft, then those of the next.
    """

    #: "converged", or the reason why the solution did not converge.
    status: str
    #: Contact load of each ball on its four groove flanks ``(n, 4)`` [N].
    contact_loads: Array
    #: Contact angle of each ball on its four groove flanks ``(n, 4)`` [rad]; not a number where a contact is open.
    contact_angles: Array
    #: Contact loads with normals and gaps frozen at the nominal state ``(n, 4)`` [N]; None if not requested.
    loads_with_nominal_normals: Array | None
    #: Axial positions at which the motion of the shaft's centreline is given ``(s,)`` [m].
    centreline_positions: Array
    #: Translation and rotation of the shaft's centreline at the ``centreline_positions`` ``(s, 6)`` [m, rad].
    centreline_motion: Array
    #: Translation and rotation of the h housings that can move ``(h, 6)`` [m, rad].
    housing_motions: Array
    #: Force of each nut or bearing on the shaft and moment about its centre ``(6,)`` [N, N m].
    forces_on_shaft: tuple[Array, ...]
    #: Axial shift of each nut relative to its housing [m].
    nut_offsets: tuple[float, ...]
    #: Forces and gaps of all contact pairs (facing nodes of ball and groove).
    contact_solution: ContactResult
    #: Groove flanks (0, 1: screw, 2, 3: nut) whose contacts may close.
    closable_flanks: tuple[int, ...]
    #: Contact normals at the contact nodes of every ball, for each nut or bearing ``(balls, nodes, 3)``.
    contact_normals: tuple[Array, ...]
    #: Largest unbalanced force on a ball, over the largest contact load.
    unbalanced_ball_force: float
    #: Largest unbalanced force on a ball along its groove, over the largest contact load.
    unbalanced_force_along_groove: float
    #: Largest unbalanced force on shaft and housings along the rigid-body motions that no support prevents, over the
    #: largest contact load.
    unbalanced_shaft_force: float
    #: Number of degrees of freedom that one mesh of all bodies, without condensation, would have.
    degree_of_freedom_count: int
    #: Computing time of the solution [s].
    solve_seconds: float
    #: Number of updates of contact normals and gaps to the displaced state.
    normal_update_count: int
    #: Largest change of a contact load that further updates of normals and gaps may cause [N]; 0 if the loads no longer
    #: change.
    remaining_load_change: float


def solve_reference(
    setup: CondensedGeometry,
    scene: Scene,
    *,
    updates: int = ROUNDS,
    sides: tuple[int, ...] | None = None,
    leave_out: frozenset[str] = frozenset(),
    frozen: bool = False,
    step: Callable[[str], None] = lambda _: None,
) -> ReferenceResult:
    """Solve all contacts of a meshed and condensed ball screw or bearing by the 3D reference, for one load case.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    scene : Scene
        The load case, with manufacturing errors.
    updates : int, default ROUNDS
        Largest number of updates of contact normals and gaps to the displaced state; 0: both keep their nominal values,
        except that gaps are corrected for the position of each contact on its mesh grid.
    sides : tuple[int, ...] | None, default None
        Flanks (0 to 3) whose contacts may close; None: all flanks that carry contacts in ``setup``.
    leave_out : frozenset[str], optional
        Names of the features to leave out of the model, from `INGREDIENTS`, such as "elastic nut" (the nut is then
        rigid).
    frozen : bool, default False
        Whether to compute, in addition, the contact loads with nominal contact normals and gaps
        (`ReferenceResult.loads_with_nominal_normals`); both solutions share the first round.
    step : Callable[[str], None], optional
        Function that is called with a progress text in every round of a solution that takes longer than `SLOW` seconds.

    Returns
    -------
    ReferenceResult
        The solution; its ``status`` says whether it converged.

    Raises
    ------
    ValueError
        ``leave_out`` contains an unknown name.
    """
    if leave_out - set(INGREDIENTS):
        unknown = sorted(leave_out - set(INGREDIENTS))
        raise ValueError(f"parts of the model to leave out: got {', '.join(unknown)}; allowed: {', '.join(INGREDIENTS)}")
    begin, moving = perf_counter(), updates > 0 and "moving normals" not in leave_out
    placed = PlacedNut(setup, scene, tuple(s for s in setup.loaded_flanks if sides is None or s in sides))
    mounted = coupling.compliance_of_supported_screw(setup, scene, leave_out)
    case = LoadCase((placed,), ShaftSupports.from_scene(scene), mounted, leave_out)
    return case.solve(updates or ROUNDS, make_slow_round_reporter(scene.name, begin, step), moving=moving, frozen=frozen)


class ContactRound(NamedTuple):
    """Contact forces and rigid motions for given contact normals and gaps: one iteration (round) of `LoadCase`."""

    #: Contact forces, gaps, and rigid motions of shaft and housings.
    contact_solution: ContactResult
    #: State of the contact solver from which the next iteration starts.
    solver_state: SolverState
    #: Contact normals at the n contact nodes of every ball, for each nut or bearing ``(balls, n, 3)``.
    contact_normals: list[Array]
    #: Motion of the n nodes of each ball along their normals by unit rigid motions of the shaft and of h housings, for each
    #: nut or bearing ``(balls, n, 6 (1 + h))``.
    normal_motion_by_rigid_motions: list[Array]
    #: Motion of the nodes of all contact pairs along their normals by the k rigid motions of shaft and housings that no
    #: support prevents ``(pairs, k)``.
    normal_motion_by_free_motions: Array
    #: Contact forces at the n contact nodes of every ball, for each nut or bearing ``(balls, n)`` [N].
    nodal_forces_by_set: list[Array]
    #: Contact loads of all balls on their four flanks ``(balls, 4)`` [N].
    contact_loads: Array
    #: Contact angles of all balls on their four flanks ``(balls, 4)`` [rad].
    contact_angles: Array


class LoadCase:
    """Loads on one shaft with its nuts or bearings, solved by iterations (rounds) that update contact normals and gaps."""

    def __init__(
        self,
        sets: Sequence[PlacedNut],
        frame: ShaftSupports,
        mounted: SupportedShaft,
        leave_out: frozenset[str] = frozenset(),
    ) -> None:
        """Prepare the compliance, manufacturing errors and contact normals of a load case.

        Parameters
        ----------
        sets : Sequence[PlacedNut]
            Nuts or bearings on the shaft.
        frame : ShaftSupports
            Supports, loads and housings.
        mounted : SupportedShaft
            Parts of the shaft that are meshed in 3D, and nuts on housings, under the supports and loads.
        leave_out : frozenset[str], optional
            Names of parts of the model to leave out, from `INGREDIENTS`.
        """
        self.sets, self.frame, self.mounted = sets, frame, mounted
        self.C, self.rows = coupling.assemble_contact_compliance(sets, mounted, leave_out)
        self.on_mounted = self.rows < len(mounted.G)
        self.at_rest = np.zeros(self.rows.size)
        self.at_rest[self.on_mounted] = mounted.mode_displacements_by_loads[self.rows[self.on_mounted]]
        drawn = [draw_geometry_with_errors(p.scene_with_errors, p.geometry.ball_positions) for p in sets]
        self.radii = [d.ball_radii for d in drawn]
        self.arms = [coupling.vectors_from_ball_centre_to_nodes(p, d) for p, d in zip(sets, drawn, strict=True)]
        self.along = [coupling.track_velocity_at_nodes(p) for p in sets]
        self.load_motion = coupling.normal_motion_of_nodes(self.C, self.at_rest)
        self.balls = sum(p.ball_count for p in sets)

    def solve_next_round(self, last: ContactRound, *, moving: bool) -> ContactRound:
        """Solve the contacts again, with normals and gaps updated by the displacements of the previous round.

        Parameters
        ----------
        last : ContactRound
            Solution of the previous round.
        moving : bool
            Whether normals and gaps follow the motion of balls and grooves; if not, only the gaps are corrected for the
            contacts' positions on their mesh grids.

        Returns
        -------
        ContactRound
            The next round.
        """
        moved = [_NO_MOTION for _ in self.sets]
        if moving:
            z = self.C.mode_compliance @ self.C.modal_forces(last.contact_solution.forces) + self.at_rest
            rigid = last.normal_motion_by_free_motions @ self.free_motion_amplitudes(last)
            along = self.split_by_nut_or_bearing(coupling.normal_motion_of_nodes(self.C, z) + rigid)
            ends = np.cumsum([p.ball_count for p in self.sets])[:-1]
            displaced = np.split(last.contact_solution.rigid_motions[: 3 * self.balls].reshape(-1, 3), ends)
            each = zip(self.sets, displaced, along, last.contact_normals, strict=True)
            moved = [coupling.ball_motion_relative_to_grooves(*of_set) for of_set in each]
        pressed = zip(self.sets, last.nodal_forces_by_set, last.contact_normals, strict=True)
        level = [coupling.grid_position_gap_corrections(*of_set) for of_set in pressed]
        return self._solve_round(moved, level, last.solver_state)

    def free_motion_amplitudes(self, last: ContactRound) -> Array:
        """Return the factors ``(k,)`` on the k rigid motions that no support prevents, as solved in a round.

        ``last``: solution of the round. The rigid motions of shaft and housings [m, rad] are the columns of
        `SupportedShaft.free_motions`.
        """
        return last.contact_solution.rigid_motions[3 * self.balls :]

    def split_by_nut_or_bearing(self, pairs: Array) -> list[Array]:
        """Split values at the contact nodes of all balls into one array ``(balls, n)`` for each nut or bearing.

        ``pairs``: values at all contact pairs (pairs,); n: number of contact nodes of one ball.
        """
        ends = np.cumsum([p.ball_count * p.nodes_per_ball for p in self.sets])[:-1]
        return [of_set.reshape(p.ball_count, -1) for p, of_set in zip(self.sets, np.split(pairs, ends), strict=True)]

    def _solve_round(
        self, ball_motions: Iterable[tuple[Array, Array]], gap_corrections: Sequence[Array], start: SolverState | None
    ) -> ContactRound:
        """Solve the contacts for given motions of the balls relative to their grooves and given corrections of the gaps.

        ``ball_motions``: for each nut or bearing, the motion across and along the track, as
        `ball_motion_relative_to_grooves` gives it [m]; ``gap_corrections``: for each, the corrections of the gaps for the
        mesh grid (balls, n) [m]; ``start``: state of the last round, or None.
        """
        directions, by_rigid, rests, touching = [], [], [], []
        for k, (p, (shift, slid)) in enumerate(zip(self.sets, ball_motions, strict=True)):
            arms = self.arms[k] - shift
            length = np.linalg.norm(arms, axis=2)
            normals = arms / length[..., None]
            back = shift + slid[..., None] * self.along[k]  # by these motions the solver closes the gaps again
            gap = length - self.radii[k][:, None] + np.einsum("ink,ink->in", normals, np.broadcast_to(back, arms.shape))
            average = partial(coupling.average_over_pressure_functions, p)
            by_rigid.append(average(self._normal_motion_by_rigid_motions(p, normals)))
            gap = average(gap)
            directions.append(average(normals))
            rests.append((gap + gap_corrections[k]).ravel())
            touching += list(coupling.expected_touching_nodes(p, gap)) if start is None else []
        motions = self.mounted.free_motions
        free_motions = np.concatenate([rows.reshape(-1, len(motions)) for rows in by_rigid]) @ motions
        f = np.concatenate([np.zeros(3 * self.balls), self.mounted.work_on_free_motions])
        N, gaps = coupling.gap_closing_matrix(directions, free_motions), np.concatenate(rests) + self.load_motion
        result, state = solve_contacts_of_all_balls(self.C, gaps, N, f, start=start, touching=tuple(touching))
        forces = self.split_by_nut_or_bearing(result.forces)
        resultants = [_contact_loads_and_angles(*of_set) for of_set in zip(self.sets, forces, directions, strict=True)]
        load, angle = (np.concatenate(x) for x in zip(*resultants, strict=True))
        return ContactRound(result, state, directions, by_rigid, free_motions, forces, load, angle)

    def _normal_motion_by_rigid_motions(self, p: PlacedNut, normals: Array) -> Array:
        """Compute the motion of contact nodes along their normals by unit rigid motions of shaft and housings.

        ``normals``: contact normals at the n nodes of each ball (balls, n, 3). The result ``(balls, n, 6 (1 + h))`` holds
        six motions of the shaft, then six of each of h housings.
        """
        out = np.zeros((*normals.shape[:2], len(self.mounted.free_motions)))
        out[..., :6] = coupling.normal_motion_by_rigid_motions(p, normals, self.mounted.origin_position, screw=True)
        if p.housing_index is not None:
            first, at = 6 + 6 * p.housing_index, self.frame.housings[p.housing_index].at
            out[..., first : first + 6] = coupling.normal_motion_by_rigid_motions(p, normals, at, screw=False)
        return out

    def iterate_to_constant_loads(
        self, last: ContactRound, max_updates: int, step: Callable[[int], None], *, moving: bool
    ) -> tuple[ContactRound, int, float]:
        """Solve the contacts again with updated normals and gaps until the contact loads no longer change.

        Parameters
        ----------
        last : ContactRound
            Round to start from.
        max_updates : int
            Largest number of updates.
        step : Callable[[int], None]
            Function that is called with the number of each round before it is solved.
        moving : bool
            Whether normals and gaps follow the motion of balls and grooves; if not, only the gaps are corrected for the
            contacts' positions on their mesh grids.

        Returns
        -------
        last : ContactRound
            The last round.
        updates : int
            Number of updates that were made.
        left : float
            Largest change of any load that further rounds may cause [N].
        """
        loads = [last.contact_loads]
        for done in range(max_updates + 1):
            left = remaining_load_change(loads)
            settled = left <= SETTLED * _mean_of_nonzero_loads(last.contact_loads)
            if settled or done == max_updates or not last.contact_solution.converged:
                break
            step(done + 2)
            last = self.solve_next_round(last, moving=moving)
            loads = [*loads[-2:], last.contact_loads]
        return last, done, left

    def judge_convergence(self, last: ContactRound, updates: int, remaining_load_change: float) -> tuple[str, float]:
        """Return whether a solution has converged, or the reason why not.

        Parameters
        ----------
        last : ContactRound
            The last round.
        updates : int
            Number of updates.
        remaining_load_change : float
            Largest change of any load that further rounds may cause [N].

        Returns
        -------
        status : str
            "converged", or the reason why the solution did not converge.
        left : float
            ``remaining_load_change`` if it prevents convergence, else 0 [N].
        """
        if not last.contact_solution.converged:
            return last.contact_solution.status, 0.0
        if any(_is_outermost_node_loaded(p, forces) for p, forces in zip(self.sets, last.nodal_forces_by_set, strict=True)):
            return AT_RIM, 0.0
        if remaining_load_change > SETTLED * _mean_of_nonzero_loads(last.contact_loads):
            change = f"loads may still move by {remaining_load_change:.2g} N after {updates} updates of normals and gaps"
            return f"not settled: {change}", remaining_load_change
        return "converged", 0.0

    def shaft_and_housing_motion(self, last: ContactRound) -> tuple[Array, Array, Array]:
        """Compute the motion of the shaft's centreline, at axial positions along it, and of the housings.

        Parameters
        ----------
        last : ContactRound
            The last round.

        Returns
        -------
        stations : (s,) Array
            Axial positions from left to right [m].
        motions : (s, 6) Array
            Motion of the centreline [m, rad].
        housings : (h, 6) Array
            Motion of the housings [m, rad].
        """
        m, z = self.mounted, np.array(self.mounted.centreline_positions)
        rigid = m.free_motions @ self.free_motion_amplitudes(last)
        # contact loads press on the grooves: along the normals counted from ball to groove
        forces, rows = self.C.modal_forces(last.contact_solution.forces)[self.on_mounted], self.rows[self.on_mounted]
        line = m.centreline_by_loads + m.centreline_by_modal_forces[:, :, rows] @ forces
        line = line + np.array([rigid_motion_transfer_along_z(x - m.origin_position) @ rigid[:6] for x in z])
        housings = m.housings_by_loads + m.housings_by_modal_forces[:, :, rows] @ forces + rigid[6:].reshape(-1, 6)
        z, first = np.unique(z, return_index=True)
        return z, line[first], housings

    def unbalanced_forces(self, last: ContactRound) -> tuple[float, float, float]:
        """Compute the largest unbalanced forces on balls, shaft and housings, relative to the largest contact load.

        Parameters
        ----------
        last : ContactRound
            The last round.

        Returns
        -------
        ball : float
            Largest unbalanced force on a ball, over the largest contact load.
        along : float
            Largest unbalanced force on a ball along its groove, over the largest contact load.
        rigid : float
            Largest unbalanced force on shaft and housings along the rigid motions that no support prevents, over the
            largest contact load.
        """
        nets = [(f[..., None] * d).sum(axis=1) for f, d in zip(last.nodal_forces_by_set, last.contact_normals, strict=True)]
        along = [net @ p.geometry.groove_map.section_axes()[1] for p, net in zip(self.sets, nets, strict=True)]
        rigid = last.normal_motion_by_free_motions.T @ last.contact_solution.forces + self.mounted.work_on_free_motions
        a, b, c = (float(np.abs(np.concatenate(x)).max(initial=0.0)) for x in (nets, along, [rigid]))
        largest = max(float(last.contact_loads.max()), 1e-300)
        return a / largest, b / largest, c / largest

    def forces_on_shaft(self, last: ContactRound) -> tuple[Array, ...]:
        """Compute the force and moment ``(6,)`` [N, N m] that each nut or bearing exerts on the shaft.

        Moments are about the centre of the nut or bearing.
        """
        arms = [self.mounted.origin_position - p.origin_on_shaft - p.geometry.scene.nut.position for p in self.sets]
        each = zip(arms, last.normal_motion_by_rigid_motions, last.nodal_forces_by_set, strict=True)
        return tuple(
            rigid_motion_transfer_along_z(arm).T @ np.einsum("ink,in->k", rows[..., :6], f) for arm, rows, f in each
        )

    def solve(
        self, max_updates: int, report: Callable[[int], None] = lambda _: None, *, moving: bool = True, frozen: bool = False
    ) -> ReferenceResult:
        """Solve the load case until its contact loads no longer change.

        Parameters
        ----------
        max_updates : int
            Largest number of updates.
        report : Callable[[int], None], optional
            Function that is called with the number of each round before it is solved.
        moving : bool, default True
            Whether normals and gaps follow the motion of balls and grooves; if not, only the gaps are corrected for the
            contacts' positions on their mesh grids.
        frozen : bool, default False
            Whether to compute, in addition, the contact loads with normals and gaps frozen at the nominal state.

        Returns
        -------
        ReferenceResult
            The solution.
        """
        begin = perf_counter()
        report(1)
        nominal = [_NO_MOTION for _ in self.sets], [np.zeros((1, 1)) for _ in self.sets]
        first = self._solve_round(*nominal, None)
        last, done, left = self.iterate_to_constant_loads(first, max_updates, report, moving=moving)
        seconds = perf_counter() - begin
        still = self.iterate_to_constant_loads(first, ROUNDS, report, moving=False)[0] if frozen and moving else last
        status, may_move = self.judge_convergence(last, done, left)
        stations, centreline, housings = self.shaft_and_housing_motion(last)
        balance, along_groove, screw_balance = self.unbalanced_forces(last)
        return ReferenceResult(
            status=status,
            contact_loads=last.contact_loads,
            contact_angles=last.contact_angles,
            loads_with_nominal_normals=still.contact_loads if frozen else None,
            centreline_positions=stations,
            centreline_motion=centreline,
            housing_motions=housings,
            forces_on_shaft=self.forces_on_shaft(last),
            nut_offsets=tuple(p.nut_offset for p in self.sets),
            contact_solution=last.contact_solution,
            closable_flanks=tuple(sorted({s for p in self.sets for s in p.closable_flanks})),
            contact_normals=tuple(last.contact_normals),
            unbalanced_ball_force=balance,
            unbalanced_force_along_groove=along_groove,
            unbalanced_shaft_force=screw_balance,
            degree_of_freedom_count=sum(p.geometry.degree_of_freedom_count for p in self.sets),
            solve_seconds=seconds,
            normal_update_count=done,
            remaining_load_change=may_move,
        )


def make_slow_round_reporter(name: str, begin: float, step: Callable[[str], None]) -> Callable[[int], None]:
    """Return a function that reports each round of an iterative solution, once that has taken longer than `SLOW` seconds.

    ``name``: name of the scene; ``begin``: time at which the solution began, of `perf_counter` [s]; ``step``: function that
    is called with the progress text.
    """

    def report_round(number: int) -> None:
        if perf_counter() - begin > SLOW:
            step(f"contacts of {name}: round {number}, {perf_counter() - begin:.0f} s")

    return report_round


def remaining_load_change(loads: Sequence[Array]) -> float:
    """Estimate how much any contact load would still change if normals and gaps were updated further.

    The contacts are solved in rounds, each with updated normals and gaps. The estimate is the remainder of a geometric
    series: last change x ratio / (1 - ratio). The ratio is the last change over the change before it, or the assumed
    `SLOWEST` if only one change is known.

    Parameters
    ----------
    loads : Sequence[Array]
        Contact loads [N] of each round, the last round last; at most the last three rounds are used.

    Returns
    -------
    float
        Largest further change of a load [N]; infinite after one round.

    Examples
    --------
    >>> round(remaining_load_change([np.array([1.0]), np.array([1.5]), np.array([1.75])]), 6)
    0.25
    """
    changes = [float(np.abs(b - a).max()) for a, b in pairwise(loads[-3:])]
    if not changes:
        return np.inf
    ratio = min(changes[1] / changes[0], SLOWEST) if len(changes) == 2 and changes[0] > 0.0 else SLOWEST
    return changes[-1] * ratio / (1.0 - ratio)


def _mean_of_nonzero_loads(load: Array) -> float:
    """Return the mean of the contact loads above zero [N]; 0 if there are none.

    ``load``: contact loads of all balls (balls, 4) [N].
    """
    return float(load[load > 0.0].mean()) if load.any() else 0.0


def _contact_loads_and_angles(p: PlacedNut, forces: Array, normals: Array) -> tuple[Array, Array]:
    """Compute the resultant load [N] and contact angle [rad] of every contact of a nut or bearing, ``(balls, 4)`` each.

    ``forces``: contact forces (balls, n) [N]; ``normals``: contact normals (balls, n, 3).
    """
    x3, _, z3 = p.geometry.groove_map.section_axes()
    load, angle = np.zeros((p.ball_count, 4)), np.full((p.ball_count, 4), np.nan)
    for nodes, s in p.node_slices_of_flanks:
        total = (forces[:, nodes, None] * normals[:, nodes]).sum(axis=1)
        load[:, s] = np.linalg.norm(total, axis=1)
        sx, sz = p.geometry.groove_map.signs[s]
        angle[:, s] = np.where(load[:, s] > 0.0, np.arctan2(sz * (total @ z3), sx * (total @ x3)), np.nan)
    return load, angle


def _is_outermost_node_loaded(p: PlacedNut, forces: Array) -> bool:
    """Return whether any ball of a nut or bearing presses on the outermost nodes of the meshed zone around its contacts.

    ``forces``: contact forces (balls, n) [N].
    """
    rim = np.concatenate([p.groove_patch(s).on_zone_edge for s in p.closable_flanks])
    return bool((forces[:, rim] > 0.0).any())
