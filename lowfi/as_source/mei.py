"""Mei's axial model (Mei et al. 2003; Lin's thesis, 2.4.1): the screw is a row of bars, contact directions are constant.

Lin compares his own model with it in case study 1. Mei's model has no bending, no twist and no change of contact
angles, so that contact loads under an axial load decrease monotonically along the nut.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import cos, sin
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_approach, contact_force, contact_stiffness_at_approach
from rollbench.lowfi.statics.contact_law import SIGNS
from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice, scene_with_error_free_hertz
from rollbench.lowfi.statics.problem import place_balls
from rollbench.lowfi.statics.result import Equilibrium, SolverReport, StaticResult, Status
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import merge_close_positions, screw_section, tube_section

#: Largest number of Newton steps of one solve.
MAX_ITERATIONS = 100
#: Assumptions of every result of Mei's model.
ASSUMPTIONS = (
    "axial displacements only: no bending, no torsion, no lateral load or moment (Mei et al. 2003; Lin 2.4.1)",
    "contact angles stay nominal; geometric errors count along the nominal contact normal",
)


@dataclass(frozen=True)
class _AxialBarModel:
    """Arrays of Mei's axial model: screw and nut as rows of elastic bars that N balls join.

    Unknowns are the axial motions of the screw at its nodes, each followed by that of the nut at the same position. All
    motions of a rigid nut are fixed.
    """

    #: Axial positions of the nodes of the bars [m].
    nodes: Array
    #: Stiffness matrix of the bars ``(unknowns, unknowns)`` [N/m].
    K: Array
    #: Axial load [N] on the node of each unknown motion.
    load: Array
    #: Whether each of the unknown motions is fixed: by a support, or because the nut has no bar there.
    fixed: NDArray[np.bool_]
    #: Prescribed values of the fixed motions [m].
    prescribed: Array
    #: Index of the unknown that is the screw's motion at each ball ``(N,)``.
    screw: NDArray[np.int64]
    #: Index of the unknown that is the nut's motion at each ball ``(N,)``.
    nut: NDArray[np.int64]
    #: Approach of opposite flanks of screw and nut per axial motion of the screw: sine of the contact angle times cosine of
    #: the lead angle.
    approach_per_axial_motion: float
    #: Interference of each ball by manufacturing errors and oversize with the two pairs of opposite flanks (screw left and
    #: nut right, screw right and nut left) ``(N, 2)`` [m].
    interference: Array
    #: Hertz constants of the two contacts in series of each ball with a pair of opposite flanks (screw left and nut right,
    #: screw right and nut left) ``(N, 2)`` [m/N^(2/3)].
    C: Array


def nut_tensile_stiffness(scene: Scene) -> float:
    """Return the tensile stiffness E A [N] of the nut, a tube whose bore is the diameter of the contacts in its groove."""
    bore = 2.0 * (scene.track.pitch_radius + scene.balls.radius * cos(scene.track.contact_angle))
    return tube_section(scene.nut.outer_diameter, bore, scene.nut.material).EA


def _add_bar_stiffness(K: Array, unknowns: NDArray[np.int64], stations: Array, stiffness: float) -> None:
    """Add the tensile stiffness of a row of bars to a stiffness matrix, which is changed in place.

    Parameters
    ----------
    K
        Stiffness matrix [N/m], changed in place.
    unknowns
        Indices of the unknown axial motions at the ends of the bars, in ascending order.
    stations
        Axial positions of these ends [m].
    stiffness
        Tensile stiffness E A of the bars [N].
    """
    a, b, s = unknowns[:-1], unknowns[1:], stiffness / np.diff(stations)
    for row, column, sign in ((a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)):
        K[row, column] += sign * s


def _build_bar_model(scene: Scene, layout: BallLayout, closure: Array, C: Array, *, elastic_nut: bool) -> _AxialBarModel:
    """Return the arrays of Mei's axial model of a scene: bars, loads, supports and contacts.

    ``layout``: positions of the N balls; ``closure``: interference of each ball with the diagonal pairs of flanks
    ``(N, 2)`` [m]; ``C``: Hertz constants ``(N, 4)``; ``elastic_nut``: whether the nut is a row of bars too, else rigid.
    """
    pair = np.stack([C[:, 0] + C[:, 3], C[:, 1] + C[:, 2]], axis=1)
    held = {s.at: v for s in scene.supports for name, v in s.fixed if name == "uz"}
    loads = {f.at: f.force[2] for f in scene.loads if f.force[2] != 0.0}
    nodes = merge_close_positions(np.concatenate([layout.z, list(held), list(loads)]), np.array(list(held)))
    n = nodes.size
    k = np.zeros((2 * n, 2 * n))
    order = 2 * np.arange(n, dtype=np.int64)
    if n > 1:
        _add_bar_stiffness(k, order, nodes, screw_section(scene).EA)
    fixed, prescribed, load = np.arange(2 * n) % 2 == 1, np.zeros(2 * n), np.zeros(2 * n)
    for z, value in held.items():
        j = order[int(np.argmin(np.abs(nodes - z)))]
        fixed[j], prescribed[j] = True, value
    for z, value in loads.items():
        load[order[int(np.argmin(np.abs(nodes - z)))]] += value
    screw = order[np.abs(nodes[None, :] - layout.z[:, None]).argmin(axis=1)]
    if elastic_nut:
        face = scene.nut.position - scene.nut.length / 2.0
        inside = np.flatnonzero((nodes >= layout.z.min() - 1e-9) & (nodes <= layout.z.max() + 1e-9))
        area = nut_tensile_stiffness(scene)
        members = order[inside] + 1
        _add_bar_stiffness(k, members, nodes[inside], area)
        k[members[0], members[0]] += area / max(float(nodes[inside[0]] - face), 1e-6)
        fixed[members] = False
    slope = sin(scene.track.contact_angle) * cos(lead_angle(scene.track))
    return _AxialBarModel(nodes, k, load, fixed, prescribed, screw, screw + 1, slope, closure, pair)


def _contact_forces_and_stiffness(chain: _AxialBarModel, x: Array) -> tuple[Array, Array]:
    """Return the contact forces ``(N, 2)`` [N] of both pairs of opposite flanks at each ball, and their stiffness [N/m].

    The first pair is screw left and nut right, the second screw right and nut left. The stiffness ``(N, 2)`` is the
    derivative of the force by the approach of the two flanks (both contacts in series).

    Parameters
    ----------
    chain
        Arrays of the model.
    x
        Axial motions of all unknowns [m].
    """
    relative = x[chain.screw] - x[chain.nut]
    delta = chain.interference + chain.approach_per_axial_motion * relative[:, None] * np.array([1.0, -1.0])
    return contact_force(delta, chain.C), contact_stiffness_at_approach(delta, chain.C)


def _unbalanced_and_contact_forces(chain: _AxialBarModel, x: Array) -> tuple[Array, Array, Array]:
    """Return unbalanced axial forces of all unknowns [N], contact forces ``(N, 2)`` [N], and axial contact stiffness.

    The axial stiffness ``(N,)`` [N/m] between screw and nut is the sum over both flank pairs of each ball.

    Parameters
    ----------
    chain
        Arrays of the model.
    x
        Axial motions of all unknowns [m].
    """
    force, tangent = _contact_forces_and_stiffness(chain, x)
    axial = chain.approach_per_axial_motion * (force[:, 0] - force[:, 1])
    g = chain.K @ x - chain.load
    np.add.at(g, chain.screw, axial)
    np.add.at(g, chain.nut, -axial)
    return g, force, chain.approach_per_axial_motion**2 * tangent.sum(axis=1)


def _minimise_by_newton(chain: _AxialBarModel) -> tuple[Array, int, float]:
    """Minimise the convex energy of Mei's model by a regularised Newton iteration.

    Returns the axial motions of all unknowns [m], the number of Newton steps, and the relative residual.
    """
    x = np.where(chain.fixed, chain.prescribed, 0.0)
    free = ~chain.fixed
    total = max(float(np.abs(chain.load).sum()), 1e-300)
    share = total / (chain.screw.size * chain.approach_per_axial_motion)
    guess = np.sign(chain.load.sum()) * float(contact_approach(share, chain.C.mean())) / chain.approach_per_axial_motion
    x[free] += guess
    residual, iteration = np.inf, 0
    for iteration in range(MAX_ITERATIONS):  # noqa: B007
        g, force, stiffness = _unbalanced_and_contact_forces(chain, x)
        scale = max(float(force.max(initial=0.0)), float(np.abs(chain.load).max(initial=0.0)))
        residual = float(np.abs(g[free]).max(initial=0.0)) / scale if scale else 0.0
        if residual <= 1e-12:
            break
        h = chain.K.copy()
        for row, column in product((chain.screw, chain.nut), repeat=2):
            np.add.at(h, (row, column), stiffness if row is column else -stiffness)
        h += 1e-9 * min(1.0, residual) * float(h.diagonal().max()) * np.eye(len(h))
        step = np.zeros_like(x)
        step[free] = np.linalg.solve(h[np.ix_(free, free)], -g[free])
        slope = float(g @ step)
        t = 1.0
        for _ in range(40):
            ahead = float(_unbalanced_and_contact_forces(chain, x + t * step)[0][free] @ step[free])
            if ahead <= 0.5 * abs(slope) or residual < 1e-9:
                break
            t *= 0.5
        x = x + t * step
    return x, iteration, residual


def solve_mei(scene: Scene, *, member: int = 0, elastic_nut: bool = False) -> StaticResult:
    """Compute the contact loads of a ball screw by Mei's axial model.

    Lateral loads, moments and lateral supports are neglected; the result states so in ``left_out``.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    member
        Number of the specimen, for a scene with random errors: each number gives other errors.
    elastic_nut
        Whether the nut is a bar clamped at its left face, as in Mei's model; otherwise it is rigid, as in the model lin.

    Returns
    -------
    StaticResult
        Loads and axial motions; if nothing can carry the axial load, ``status`` says so.

    References
    ----------
    Mei, Tsutsumi, Tao and Sun (2003); Lin (2019), 2.4.1.

    Examples
    --------
    >>> import rollbench
    >>> result = solve_mei(rollbench.read("lin-case1"))
    >>> result.status, bool(np.all(np.diff(result.load[:, 0]) <= 0.0) or np.all(np.diff(result.load[:, 0]) >= 0.0))
    ('converged', True)
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout, member)
    C = hertz_constants_by_scene_choice(scene_with_error_free_hertz(scene), drawn)
    closure = place_balls(scene, drawn).interference
    chain = _build_bar_model(scene, layout, closure, C, elastic_nut=elastic_nut)
    x, iterations, residual = _minimise_by_newton(chain)
    force, _ = _contact_forces_and_stiffness(chain, x)
    load = np.zeros((layout.z.size, 4))
    load[:, [0, 3]], load[:, [1, 2]] = force[:, :1], force[:, 1:]
    good = residual <= 1e-10
    axial = float((chain.approach_per_axial_motion * (force[:, 0] - force[:, 1])).sum())
    applied, n = float(chain.load.sum()), chain.nodes.size
    on_screw = slice(0, None, 2)
    unbalanced = _unbalanced_and_contact_forces(chain, x)[0]
    reaction = float(unbalanced[on_screw][chain.fixed[on_screw]].sum())
    stations = np.unique(np.concatenate([chain.nodes, [0.0, scene.screw.length]]))
    seconds, unknowns = perf_counter() - start, int(np.count_nonzero(~chain.fixed))
    nut_text = "the nut is an elastic bar fixed at its left face" if elastic_nut else "the nut is rigid"
    return axial_result(
        scene,
        load,
        np.where(load > 0.0, scene.track.contact_angle, np.nan),
        (stations, np.interp(stations, chain.nodes, x[on_screw])),
        model="mei-nut" if elastic_nut else "mei",
        status=Status("converged") if good else Status("not converged", f"relative residual {residual:.1e}"),
        hertz_C=C,
        equilibrium=axial_equilibrium(applied, reaction, -axial, max(abs(applied), abs(axial), 1e-300)),
        solver=SolverReport(iterations, iterations, residual, seconds, unknowns, n - 1, "axial bars"),
        assumed=(*scene.assumed, *ASSUMPTIONS, nut_text),
        left_out=("lateral forces, moments, bending and torsion: the model is axial",),
    )


def axial_result(scene: Scene, load: Array, angle: Array, line: tuple[Array, Array], **fields: Any) -> StaticResult:
    """Return the static result of an axial model, in which neither screw nor balls move laterally.

    Parameters
    ----------
    scene
        Screw, nut and balls.
    load
        Contact forces ``(N, 4)`` [N].
    angle
        Contact angles ``(N, 4)`` [rad]; nan without contact.
    line
        Axial positions along the screw ``(k,)`` [m], and axial motions of the screw there ``(k,)`` [m].
    **fields
        The other fields of `StaticResult`.
    """
    layout, (stations, along) = ball_layout(scene), line
    turned = np.where(np.isnan(angle), scene.track.contact_angle, angle)
    direction = SIGNS * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    world = np.einsum("nsa,nak->nsk", direction, np.stack([layout.radial, layout.binormal], axis=1))
    return StaticResult(
        azimuth=layout.azimuth,
        z=layout.z,
        load=load,
        contact_angle=angle,
        contact_point=layout.centre[:, None, :] + scene.balls.radius * world,
        force_direction=-world,
        centre_shift=np.zeros((layout.z.size, 2)),
        centreline_z=stations,
        centreline=along[:, None] * np.eye(6)[2],
        **fields,
    )


def axial_equilibrium(applied: float, reaction: float, contact: float, size: float) -> Equilibrium:
    """Return the check of equilibrium of a screw on which only axial forces act.

    Parameters
    ----------
    applied, reaction, contact
        Sums of the axial loads, of the supports' reactions and of the contact forces on the screw [N].
    size
        Force [N] by which the unbalanced force is divided for the residual.
    """
    zero = np.zeros(3)
    along = [np.array([0.0, 0.0, x]) for x in (applied, reaction, contact)]
    return Equilibrium(along[0], zero, along[1], zero, along[2], zero, abs(applied + reaction + contact) / size, 0.0)
