"""Arrays of a static problem from its parts, and supports that contradict each other on a rigid screw."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.contacts import hertz_C
from rollbench.lowfi.statics.shape import motion_matrices, principal, rigid_transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen, Specimens
from rollbench.meshes.helix import BallLayout, groove_radii, nominal_contact_points, nominal_groove_centres
from rollbench.meshes.parts import FREEDOMS, SIDE_SIGNS, Scene
from rollbench.meshes.section import MERGE, BeamSection, beam_nodes, contact_stations, screw_section

#: Signs of the contact directions, shape (4, 2).
SIGNS = np.array(SIDE_SIGNS)


@dataclass(frozen=True)
class Problem:
    """Arrays of one static problem with n nodes, N balls and m = 6 or 12 freedoms per flank."""

    #: The scene.
    scene: Scene
    #: Positions of the balls.
    layout: BallLayout
    #: Parts with their errors.
    drawn: Specimen
    #: Stations of the beam's nodes ``(n,)`` [m].
    nodes: Array
    #: Section of the screw.
    section: BeamSection
    #: Fixed freedoms ``(n, 6)``.
    fixed: NDArray[np.bool_]
    #: Their values ``(n, 6)`` [m, rad].
    prescribed: Array
    #: Loads on the nodes ``(n, 6)`` [N, N m].
    load: Array
    #: First node that moves each screw flank of a ball ``(N, 2)``.
    node: NDArray[np.int64]
    #: Motion of those flanks in the section plane by the nodes' motions ``(N, 2, 2, m)``.
    B: Array
    #: Contacts as the kernels take them ``(N, 4, 9)``, see ``kernel.ball``.
    geometry: Array
    #: Nominal interference of the diagonal pairs of flanks ``(N, 2)`` [m].
    closure: Array
    #: Flanks that are built ``(4,)``.
    use: NDArray[np.bool_]
    #: Number of beam elements left out.
    left_out_elements: int
    #: For a rigid screw, motions by the free and fixed coordinates ``(6, 6)``; else None.
    basis: Array | None = None
    #: Freedoms of the first node (columns of the basis) that are fixed because nothing drives or resists them.
    pins: tuple[int, ...] = ()
    #: Section of every element, where they differ.
    sections: tuple[BeamSection, ...] | None = None

    @property
    def C(self) -> Array:
        """Hertz constants of each ball and flank ``(N, 4)`` [m/N^(2/3)], a view that is updated in place."""
        return self.geometry[:, :, 4]

    @property
    def unknowns(self) -> int:
        """Number of free motions of the screw; centres and contact angles of the balls are eliminated."""
        return int(np.count_nonzero(~self.fixed))

    @property
    def half_bandwidth(self) -> int:
        """Half bandwidth of the stiffness matrix."""
        width = 11 if self.nodes.size > 1 else 5
        used = [s for s in range(2) if self.use[s]]
        if used:
            reach = self.B.shape[3] - 1
            apart = int(np.abs(self.node[:, 0] - self.node[:, 1]).max()) if len(used) == 2 else 0
            width = max(width, 6 * apart + reach)
        return width


@dataclass(frozen=True)
class SolvedState:
    """Motions, contacts and reactions at the end of a solve, with n nodes and N balls."""

    #: The problem.
    problem: Problem
    #: Of the nodes ``(n, 6)`` [m, rad].
    motion: Array
    #: Shifts of the balls in their sections ``(N, 2)`` [m].
    centre: Array
    #: Contact forces ``(N, 4)`` [N].
    force: Array
    #: Unit vectors from ball to groove in the section ``(N, 4, 2)``.
    normal: Array
    #: Of the supports on the nodes ``(n, 6)`` [N, N m]; zero for a rigid screw, whose reactions follow from the balance.
    reactions: Array
    #: Motions of the flanks in the section ``(N, 4, 2)`` [m]; None where all flanks are circular arcs.
    shifts: Array | None
    #: Largest force met [N].
    scale: float


def pack_geometry(
    scene: Scene, drawn: Specimen, C: Array, use: NDArray[np.bool_], known: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """Return the contacts ``(N, 4, 9)`` and pair closures ``(N, 2)`` [m] as the kernels take them (see ``kernel.ball``).

    Parameters
    ----------
    scene, drawn
        The scene and its parts with their errors.
    C
        Hertz constants ``(N, 4)`` or ``(4,)`` [m/N^(2/3)].
    use
        Flanks that are built ``(4,)``.
    known
        `distances` of the parts, where they have been computed.
    """
    offset, closure = known or distances(scene, drawn)
    n = offset.shape[0]
    rows = np.empty((n, 4, 9))
    rows[..., :4] = offset
    rows[..., 4] = C
    rows[..., 5] = use
    rows[..., 6] = drawn.radius
    rows[..., 7:] = SIGNS
    return rows, closure


def distances(scene: Scene, drawn: Specimen | Specimens) -> tuple[Array, Array]:
    """Return the distances of ball centres and groove centres, and the interference of diagonal pairs of flanks.

    Built from differences, so that a nominal contact has an approach of zero to round-off of its errors.

    Parameters
    ----------
    scene
        The scene.
    drawn
        Its parts with their errors, of one specimen or many.

    Returns
    -------
    tuple[Array, Array]
        Vectors from groove to ball centre, their length and the nominal approach ``(..., N, 4, 4)`` [m], and pair closures
        ``(..., N, 2)`` [m], positive for interference.
    """
    x, z, radii = drawn.centre[..., 0], drawn.centre[..., 1], groove_radii(scene)
    size, nominal = _length(x, z), _length(*nominal_groove_centres(scene).T)
    wider = (drawn.radius - radii) + (radii - scene.balls.radius - nominal)
    offset = np.empty((*drawn.ball_radius.shape, 4, 4))
    offset[..., 0], offset[..., 1], offset[..., 2] = -x, -z, size
    approach, closure = offset[..., 3], np.empty((*drawn.ball_radius.shape, 2))
    approach[...] = (drawn.ball_radius - scene.balls.radius)[..., None] - wider + (size - nominal)
    for a, b in ((0, 3), (1, 2)):  # pair by pair, over all balls: numpy is slow along short axes
        grown = _length(x[..., a] - x[..., b], z[..., a] - z[..., b]) - size[..., a] - size[..., b]
        closure[..., a] = approach[..., a] + approach[..., b] + grown
    return offset, closure


def tightest(problem: Problem) -> float:
    """Return the interference of the tightest ball [m]; zero where it is round-off of the lengths that make it."""
    closed = float(problem.closure.max(initial=0.0))
    return closed if closed > round_off_approach(problem) else 0.0


def round_off_approach(problem: Problem) -> float:
    """Return the approach [m] that is round-off of the lengths that make it."""
    return 16.0 * float(np.finfo(float).eps) * problem.scene.balls.radius


def _length(x: Array, z: Array) -> Array:
    """Return length of vectors by operations that round alike everywhere (numpy's hypot depends on memory alignment)."""
    return np.asarray(np.sqrt(x * x + z * z))


def flank_rows(parts: tuple[Scene, Specimen, BallLayout, Array | None], side: int, origin_z: Array) -> Array:
    """Return rows e . (u + theta x r) that give the motion of the flank's loaded point from u, theta at ``origin_z``.

    That point is the groove's centre of curvature, which lies on every line of action of the arc (plus ``arms`` ``(N, 4,
    2)``
    where the profile is no arc), or, with frozen arms, the nominal contact point.

    Returns
    -------
    Array
        ``(..., N, 2, 6)``, for both axes e of each ball's section.
    """
    scene, drawn, layout, arms = parts
    if scene.ingredients.arm == "nominal":
        point = np.broadcast_to(nominal_contact_points(scene)[side], (layout.z.size, 2))
    else:
        point = drawn.centre[..., side, :] + (arms[:, side] if arms is not None else 0.0)
    x = layout.centre + point[..., :1] * layout.radial
    x += point[..., 1:] * layout.binormal
    x[..., 2] -= origin_z
    return wrench_rows(layout, x)


def wrench_rows(layout: BallLayout, r: Array) -> Array:
    """Return rows (e, r x e) for both axes e of each ball's section at points r ``(..., N, 3)`` [m].

    Returns
    -------
    Array
        ``(..., N, 2, 6)``: motions there by those of the body about its origin.
    """
    rows = np.empty((*r.shape[:-1], 2, 6))
    rows[..., 0, :3], rows[..., 1, :3] = layout.radial, layout.binormal
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rows[..., 3 + k] = r[..., i, None] * rows[..., j] - r[..., j, None] * rows[..., i]
    return rows


def lever_arms(problem: Problem, centre: Array) -> Array:
    """Return ``Problem.B`` of k specimens ``(k, N, 2, 2, m)`` from the centres of their grooves ``(k, N, 4, 2)`` [m].

    Parameters
    ----------
    problem
        The static problem of N balls.
    centre
        Centres of the grooves' arcs, ``(k, N, 4, 2)`` [m].
    """
    parts = (problem.scene, replace(problem.drawn, centre=centre), problem.layout, None)
    B = np.zeros((len(centre), *problem.B.shape))
    stations = contact_stations(problem.scene, problem.layout)
    for s in range(2):
        if problem.basis is not None:
            B[:, :, s] = flank_rows(parts, s, np.full(len(stations), problem.nodes[0])) @ problem.basis
        elif problem.use[s] and B.shape[-1] == 6:
            B[:, :, s] = flank_rows(parts, s, problem.nodes[problem.node[:, s]])
        elif problem.use[s]:
            _, m = motion_matrices(stations[:, s], problem.nodes, problem.section)
            B[:, :, s] = flank_rows(parts, s, stations[:, s]) @ m
    return B


def _supports(scene: Scene, nodes: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """Return fixed freedoms, their values, and loads of the nodes, ``(n, 6)`` each; ValueError for one fixed twice."""
    fixed = np.zeros((nodes.size, 6), dtype=bool)
    prescribed, load = np.zeros((nodes.size, 6)), np.zeros((nodes.size, 6))
    for support in scene.supports:
        j = int(np.abs(nodes - support.at).argmin())
        for name, value in support.fixed:
            if fixed[j, FREEDOMS.index(name)]:
                raise ValueError(f"two supports hold {name} at {1e3 * support.at:g} mm, less than {1e6 * MERGE:g} um apart")
            fixed[j, FREEDOMS.index(name)] = True
            prescribed[j, FREEDOMS.index(name)] = value
    for x in scene.loads:
        j = int(np.abs(nodes - x.at).argmin())
        load[j] += (*x.force, *x.moment)
        load[j, 3] -= (x.at - nodes[j]) * x.force[1]
        load[j, 4] += (x.at - nodes[j]) * x.force[0]
    return fixed, prescribed, load


def build(
    scene: Scene,
    drawn: Specimen,
    layout: BallLayout,
    use: NDArray[np.bool_],
    *,
    everything: bool = False,
    refine: int = 1,
    arms: Array | None = None,
    section: BeamSection | None = None,
    known: tuple[Array, Array] | None = None,
) -> Problem:
    """Return the arrays of the static problem.

    Parameters
    ----------
    scene, drawn, layout
        The scene, its parts with their errors, positions of the balls.
    use
        Flanks to build ``(4,)``.
    everything
        Whether the shaft without influence is built too.
    refine
        Elements that each beam element is split into.
    arms
        Additional lever arms ``(N, 4, 2)`` [m], see `flank_rows`.
    section
        Section of the screw in place of the scene's (Lin C.8).
    known
        `distances` of the parts, where they have been computed.

    Raises
    ------
    ValueError
        Supports that contradict each other.
    """
    parts = (scene, drawn, layout, arms)
    geometry, closure = pack_geometry(scene, drawn, hertz_C(scene, drawn), use, known)
    section = section or screw_section(scene)
    stations = contact_stations(scene, layout)
    used = [s for s in range(2) if use[s]]
    if scene.ingredients.screw == "rigid":
        return _rigid(parts, use, geometry, closure, section)
    nodes, left_out = beam_nodes(scene, stations[:, used], everything=everything)
    if refine > 1:
        steps = np.arange(refine) / refine
        nodes = np.append((nodes[:-1, None] + np.diff(nodes)[:, None] * steps[None, :]).ravel(), nodes[-1])
    fixed, prescribed, load = _supports(scene, nodes)
    count = layout.z.size
    node = np.zeros((count, 2), dtype=np.int64)
    nodal = scene.ingredients.partition == "nodal"
    B = np.zeros((count, 2, 2, 6 if nodal else 12))
    for s in used:
        if nodal:
            node[:, s] = (
                np.abs(nodes[None, :] - stations[:, s, None]).argmin(axis=1)
                if count < 400
                else (_nearest(nodes, stations[:, s]))
            )
            B[:, s] = flank_rows(parts, s, nodes[node[:, s]])
        else:
            node[:, s], m = motion_matrices(stations[:, s], nodes, section)
            B[:, s] = flank_rows(parts, s, stations[:, s]) @ m
    for s in range(2):
        if not use[s]:
            node[:, s] = node[:, used[0]] if used else 0
    return Problem(scene, layout, drawn, nodes, section, fixed, prescribed, load, node, B, geometry, closure, use, left_out)


def _nearest(nodes: Array, stations: Array) -> NDArray[np.int64]:
    j = np.clip(np.searchsorted(nodes, stations), 1, nodes.size - 1)
    return np.where(stations - nodes[j - 1] < nodes[j] - stations, j - 1, j).astype(np.int64)


def _rigid(
    parts: tuple[Scene, Specimen, BallLayout, Array | None],
    use: NDArray[np.bool_],
    geometry: Array,
    closure: Array,
    section: BeamSection,
) -> Problem:
    """Return the problem of a rigid screw, its motion taken at the nut's centre.

    Supports are linear constraints on that motion; ValueError where they contradict each other.
    """
    scene, drawn, layout, _ = parts
    z0 = scene.nut.position
    arm = scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    clash = contradiction(scene)
    if clash is not None:
        raise ValueError(clash.message(scene))
    a, values, _ = rigid_rows(scene)
    load = np.zeros(6)
    for x in scene.loads:
        load += rigid_transport(x.at - z0).T @ np.concatenate([x.force, x.moment])
    held = 0
    basis = np.eye(6)
    lift = np.zeros(6)
    if values.size:
        sv, vt = principal(a)
        held = int(np.sum(sv > 1e-9 * sv[0]))
        basis = np.concatenate([vt[held:], vt[:held]]).T
        lift[:] = np.linalg.lstsq(a, values, rcond=None)[0]
    to_motion = scale[:, None] * basis / scale[None, :]
    count = layout.z.size
    B = np.stack([flank_rows(parts, s, np.full(count, z0)) @ to_motion for s in range(2)], axis=1)
    fixed = np.arange(6)[None] >= 6 - held
    prescribed, work = np.linalg.solve(to_motion, scale * lift)[None, :], (to_motion.T @ load)[None, :]
    shaft = np.array([z0]), section, fixed, prescribed, work, np.zeros((count, 2), dtype=np.int64), B
    return Problem(scene, layout, drawn, *shaft, geometry, closure, use, 0, to_motion)


#: Part of a constraint that must be new, relative to its size, for it to count as independent of those before it.
INDEPENDENT = 1e-9
#: Difference of prescribed values that counts as none, relative to the largest of them.
AGREES = 1e-9


@dataclass(frozen=True)
class Held:
    """One freedom fixed by a support."""

    #: Number of the support in the scene, from 0.
    support: int
    #: Name of the freedom.
    freedom: str
    #: Its value [m or rad].
    value: float


@dataclass(frozen=True)
class Contradiction:
    """Freedom of a rigid screw that other supports already fix at another value."""

    #: The freedom and its value.
    held: Held
    #: Value that the others give it [m or rad].
    implied: float
    #: Those other freedoms.
    by: tuple[Held, ...]

    def message(self, scene: Scene) -> str:
        """Return the contradiction as one sentence, with stations in mm."""
        names = ", ".join(f"{x.freedom} at {_station(scene, x)}" for x in self.by)
        contradicted = f"{self.held.freedom} at {_station(scene, self.held)}"
        return (
            f"the supports contradict each other on a rigid screw: {contradicted} is {show(self.held)}, but {names} "
            f"make it {show(Held(0, self.held.freedom, self.implied))}"
        )


def _station(scene: Scene, held: Held) -> str:
    return f"{1e3 * scene.supports[held.support].at:g} mm (supports[{held.support}])"


def show(held: Held) -> str:
    """Return the value of a fixed freedom as text with its unit, um or mrad.

    Parameters
    ----------
    held
        A fixed freedom with its value.
    """
    return f"{1e6 * held.value:.6g} um" if held.freedom in FREEDOMS[:3] else f"{1e3 * held.value:.6g} mrad"


def rigid_rows(scene: Scene) -> tuple[Array, Array, list[Held]]:
    """Return the constraints of the supports on a rigid screw.

    Returns
    -------
    tuple[Array, Array, list[Held]]
        Rows ``(k, 6)`` on its motion at the nut's centre, values ``(k,)``, and the fixed freedoms. Rotations count as
        lengths at the pitch radius in rows and values [m].
    """
    arm = scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    held = [Held(i, name, value) for i, s in enumerate(scene.supports) for name, value in s.fixed]
    rows, values = np.zeros((len(held), 6)), np.zeros(len(held))
    for j, x in enumerate(held):
        k = FREEDOMS.index(x.freedom)
        rows[j] = rigid_transport(scene.supports[x.support].at - scene.nut.position)[k] * scale / scale[k]
        values[j] = x.value / scale[k]
    return rows, values, held


def contradiction(scene: Scene) -> Contradiction | None:
    """Return the first fixed freedom that earlier ones fix at another value if the screw is rigid; None where all agree.

    Parameters
    ----------
    scene
        Screw with supports.
    """
    rows, values, held = rigid_rows(scene)
    size = float(np.abs(values).max(initial=0.0))
    if size == 0.0:
        return None
    kept: list[int] = []
    for j in range(len(held)):
        if not kept:
            kept.append(j)
            continue
        share = np.linalg.lstsq(rows[kept].T, rows[j], rcond=None)[0]
        new = rows[j] - share @ rows[kept]
        if float(np.linalg.norm(new)) > INDEPENDENT * float(np.linalg.norm(rows[j])):
            kept.append(j)
            continue
        implied = float(share @ values[kept])
        if abs(implied - values[j]) > AGREES * size:
            by = tuple(held[k] for k, x in zip(kept, share, strict=True) if abs(x) > INDEPENDENT)
            arm = 1.0 if held[j].freedom in FREEDOMS[:3] else 1.0 / scene.track.pitch_radius
            return Contradiction(held[j], implied * arm, by)
    return None
