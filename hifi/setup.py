"""One geometry of the 3D reference: meshes, condensed patches, and how screw, nut and balls answer contact forces.

Screw, nut and one ball are meshed coarsely with a socket at every contact; one fine patch per side is condensed exactly and
fits every socket of that side. All load cases and error patterns of the geometry share this set-up.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from time import perf_counter

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import qr

from hifi.bodies import BodyResponse, Socket, assemble, isostatic, respond
from hifi.elasticity import rigid_modes
from hifi.fit import Settings, ball_place, patch_lines, socket_size
from hifi.patch import CondensedPatch, build_patch, condense_patch
from hifi.shaft import beam_stiffness, round_section
from meshes.ball_body import BallBody, build_ball
from meshes.groove_map import GrooveMap
from meshes.grooved_body import BodySpec, GroovedBody, SocketSize, build_body, local_points
from meshes.helix import BallLayout, ball_layout
from meshes.parts import FREEDOMS, Load, Scene, Support

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Step = Callable[[str], None]
#: (nodes, motions of their freedoms (3 n, 6), the six freedoms of the section) of a rigid end section.
EndSection = tuple[Index, Array, Index]


@dataclass(frozen=True)
class SidePatches:
    """Patches of one side: of the groove and of the ball, on the same contact nodes."""

    groove: CondensedPatch
    ball: CondensedPatch


@dataclass
class Setup:
    """Everything of one geometry that load cases share."""

    scene: Scene
    map: GrooveMap
    layout: BallLayout
    sides: tuple[int, ...]
    patches: dict[int, SidePatches]
    screw: BodyResponse
    nut: BodyResponse | None
    ball: Array
    screw_pins: Array
    cases: tuple[tuple[tuple[Support, ...], tuple[Load, ...]], ...]
    unknowns: int
    seconds: dict[str, float] = field(default_factory=dict)


def prepare(
    scene: Scene, sides: tuple[int, ...], settings: Settings, step: Step = lambda _: None,
    cases: tuple[Scene, ...] = (),
) -> Setup:  # fmt: skip
    """Meshes, patches and bodies of one geometry; ``sides``: which of SL, SR, NL, NR (0 to 3) may carry load.

    cases: further scenes of the same geometry and held freedoms that will be solved with this setup; they may differ in
    loads, prescribed values and errors.
    """
    seconds: dict[str, float] = {}
    m, layout = GrooveMap.of(scene), ball_layout(scene)
    size = socket_size(m, settings)
    widths = (settings.gamma * float(m.radius.mean()), settings.along)
    lines, zone = patch_lines(settings, widths)

    def timed(name: str, start: float) -> None:
        seconds[name] = perf_counter() - start
        step(f"{name}: {seconds[name]:.1f} s")

    start = perf_counter()
    screw_mesh = build_body(m, _screw_spec(scene, layout, sides, size, settings))
    nut_mesh = build_body(m, _nut_spec(scene, layout, sides, size, settings))
    places = {s: ball_place(m, size, s, zone) for s in sides}
    ball_mesh = build_ball(m, tuple(places[s][0] for s in sides), settings.ball_fine, settings.ball_coarse)
    timed("meshes", start)

    start = perf_counter()
    patches: dict[int, SidePatches] = {}
    materials = {True: scene.screw.material, False: scene.nut.material}
    centre = np.array([m.R, 0.0, 0.0])
    total = 0
    for s in sides:
        body = screw_mesh if s < 2 else nut_mesh
        mesh = build_patch(lines, zone, partial(local_points, m, size, s), body.sockets[s])
        arms = mesh.points[mesh.contact] - centre
        normals = arms / np.linalg.norm(arms, axis=1)[:, None]
        e = materials[s < 2]
        groove = condense_patch(mesh, normals, e.youngs_modulus, e.poissons_ratio)
        ball_patch = build_patch(lines, zone, places[s][1], ball_mesh.sockets[s])
        found = ball_patch.points[ball_patch.contact]
        spread = np.linalg.norm(found / np.linalg.norm(found, axis=1)[:, None] - normals, axis=1).max()
        if spread > 1e-9:
            raise ValueError(f"contact nodes of ball and groove do not match ({spread:.1e})")
        b = scene.balls.material
        ball = condense_patch(ball_patch, -normals, b.youngs_modulus, b.poissons_ratio)
        patches[s] = SidePatches(groove, ball)
        total += (groove.unknowns + ball.unknowns) * layout.z.size
    timed("patches", start)

    start = perf_counter()
    ball_C, ball_unknowns = _ball_compliance(scene, ball_mesh, patches)
    timed("ball", start)
    start = perf_counter()
    cases = (scene, *cases)
    screw, pins = _screw_response(cases, screw_mesh, layout, sides, patches, settings)
    timed("screw", start)
    start = perf_counter()
    nut = _nut_response(scene, nut_mesh, layout, sides, patches, settings) if settings.elastic_nut else None
    timed("nut", start)
    unknowns = total + screw.unknowns + (nut.unknowns if nut else 0) + ball_unknowns * layout.z.size
    return Setup(
        scene, m, layout, sides, patches, screw, nut, ball_C, pins, tuple((c.supports, c.loads) for c in cases),
        unknowns, seconds,
    )  # fmt: skip


def _sockets_of(layout: BallLayout, sides: tuple[int, ...], screw: bool) -> tuple[tuple[float, float, int], ...]:
    own = [s for s in sides if (s < 2) == screw]
    return tuple((float(a), float(z), s) for a, z in zip(layout.azimuth, layout.z, strict=True) for s in own)


def _screw_spec(
    scene: Scene, layout: BallLayout, sides: tuple[int, ...], size: SocketSize, settings: Settings
) -> BodySpec:
    half = scene.nut.length / 2.0 + settings.shaft
    low, high = scene.nut.position - half, scene.nut.position + half
    return BodySpec(
        max(settings.screw_hole, scene.screw.bore / 2.0), scene.screw.outer_diameter / 2.0, max(low, 0.0),
        min(high, scene.screw.length), True, _sockets_of(layout, sides, True), size, settings.fine, settings.coarse,
    )  # fmt: skip


def _nut_spec(
    scene: Scene, layout: BallLayout, sides: tuple[int, ...], size: SocketSize, settings: Settings
) -> BodySpec:
    nut = scene.nut
    return BodySpec(
        settings.nut_land, nut.outer_diameter / 2.0, nut.position - nut.length / 2.0, nut.position + nut.length / 2.0,
        False, _sockets_of(layout, sides, False), size, settings.fine, settings.coarse,
    )  # fmt: skip


def rotation(phi: float) -> Array:
    """Rotation about z."""
    c, s = np.cos(phi), np.sin(phi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _placed(mesh: GroovedBody, sockets: tuple[tuple[float, float, int], ...]) -> list[Socket]:
    return [Socket(n, rotation(x[0]), x[2]) for n, x in zip(mesh.socket_nodes, sockets, strict=True)]


def _ball_compliance(
    scene: Scene, mesh: BallBody, patches: dict[int, SidePatches]
) -> tuple[Array, int]:
    """Dense compliance of one ball on the contact nodes of all its sides, rigid motions held isostatically."""
    e = scene.balls.material
    own = {s: p.ball for s, p in patches.items()}
    sockets = [Socket(mesh.socket_nodes[s], np.eye(3), s) for s in own]
    K = assemble(mesh.points, mesh.cells, sockets, own, e.youngs_modulus, e.poissons_ratio)
    held = isostatic(mesh.points, np.concatenate([s.nodes for s in sockets]))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    C = sp.identity(K.shape[0], format="csc")[:, free]
    found = respond(K, sockets, own, C, np.zeros((free.size, 0)), count=10**6)
    V = [found.modes[s] for s in own]
    whole = np.zeros((sum(v.shape[0] for v in V), sum(v.shape[1] for v in V)))
    r = c = 0
    for v in V:
        whole[r : r + v.shape[0], c : c + v.shape[1]] = v
        r, c = r + v.shape[0], c + v.shape[1]
    D = whole @ found.G @ whole.T
    r = 0
    for p in own.values():
        D[r : r + len(p.A), r : r + len(p.A)] += p.A
        r += len(p.A)
    return np.asarray(0.5 * (D + D.T)), found.unknowns


def _end_transform(size: int, sections: list[EndSection], extra: int) -> sp.csc_matrix:
    """C of rigid end sections: (nodes, matrix (3 n, 6), freedoms (6,)) each; identity elsewhere, slaves dropped."""
    keep = np.ones(size + extra, dtype=bool)
    for nodes, _, _ in sections:
        keep[(3 * nodes[:, None] + np.arange(3)).ravel()] = False
    free = np.flatnonzero(keep)
    column = np.full(size + extra, -1, dtype=np.int64)
    column[free] = np.arange(free.size)
    rows, cols, vals = [free], [np.arange(free.size)], [np.ones(free.size)]
    for nodes, matrix, target in sections:
        dof = (3 * nodes[:, None] + np.arange(3)).ravel()
        r, c = np.nonzero(matrix)
        rows.append(dof[r])
        cols.append(column[target[c]])
        vals.append(matrix[r, c])
    return sp.coo_matrix(
        (np.concatenate(vals), (np.concatenate(rows), np.concatenate(cols))), (size + extra, free.size)
    ).tocsc()


def _screw_response(
    cases: tuple[Scene, ...], mesh: GroovedBody, layout: BallLayout, sides: tuple[int, ...],
    patches: dict[int, SidePatches], settings: Settings,
) -> tuple[BodyResponse, Array]:  # fmt: skip
    """Response of the screw with its shaft as beams to the supports; also its unheld rigid motions ``(6, k)``."""
    scene = cases[0]
    e = scene.screw.material
    own = {s: p.groove for s, p in patches.items() if s < 2}
    sockets = _placed(mesh, _sockets_of(layout, sides, True))
    K3 = assemble(mesh.points, mesh.cells, sockets, own, e.youngs_modulus, e.poissons_ratio)
    size = K3.shape[0]
    low, high = float(mesh.points[mesh.low_end, 2].mean()), float(mesh.points[mesh.high_end, 2].mean())
    section = round_section(settings.shaft_radius, e.youngs_modulus, e.poissons_ratio)
    stations = sorted({x.at for x in scene.supports} | {x.at for x in scene.loads})
    nodes = sorted({low, high} | set(stations))
    place = {z: 6 * k + size for k, z in enumerate(nodes)}
    extra = 6 * len(nodes)
    blocks = []
    for a, b in pairwise(nodes):
        if a >= low and b <= high:
            continue  # that stretch is 3D
        k = beam_stiffness(b - a, section)
        dof = np.concatenate([place[a] + np.arange(6), place[b] + np.arange(6)])
        blocks.append((k, dof))
    K = sp.block_diag([K3, sp.csc_matrix((extra, extra))]).tolil()
    K = K.tocsc()
    for k, dof in blocks:
        K = K + sp.coo_matrix(
            (k.ravel(), (np.repeat(dof, 12), np.tile(dof, 12))), shape=K.shape
        ).tocsc()
    ends = []
    for face, z in ((mesh.low_end, low), (mesh.high_end, high)):
        matrix = rigid_modes(mesh.points[face], np.array([0.0, 0.0, z]))
        ends.append((face, matrix, place[z] + np.arange(6)))
    C = _end_transform(size, ends, extra)
    fixed = [(place[x.at] + FREEDOMS.index(name)) for x in scene.supports for name, _ in x.fixed]
    motions = _unheld(scene, nodes)
    held = np.array(fixed + [place[nodes[0]] + k for k in _pin_freedoms(motions)], dtype=np.int64)
    column = np.asarray(C[held].argmax(axis=1)).ravel()
    free = np.setdiff1d(np.arange(C.shape[1]), column)
    full = C.T @ K @ C
    right = np.zeros((free.size, len(cases)))
    for number, case in enumerate(cases):
        if [(x.at, tuple(n for n, _ in x.fixed)) for x in case.supports] != [
            (x.at, tuple(n for n, _ in x.fixed)) for x in scene.supports
        ]:
            raise ValueError(f"{case.name} holds other freedoms than {scene.name}: prepare it on its own")
        lift = np.zeros(C.shape[1])
        values = [value for x in case.supports for _, value in x.fixed]
        lift[column[: len(values)]] = values
        force = np.zeros(size + extra)
        for load in case.loads:
            force[place[load.at] + np.arange(3)] += load.force
            force[place[load.at] + 3 + np.arange(3)] += load.moment
        right[:, number] = (C.T @ force - full @ lift)[free]
    return respond(K, sockets, own, C[:, free].tocsc(), right, count=settings.modes), motions


def _unheld(scene: Scene, nodes: list[float]) -> Array:
    """Rigid motions of the screw (about its first node) that no support holds, ``(6, k)``."""
    rows = []
    arm = scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    for support in scene.supports:
        t = np.eye(6)
        reach = support.at - nodes[0]
        t[0, 4], t[1, 3] = reach, -reach
        rows += [t[FREEDOMS.index(name)] * scale for name, _ in support.fixed]
    if not rows:
        return np.diag(scale)
    _, s, vt = np.linalg.svd(np.array(rows))
    rank = int((s > 1e-9 * s[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def _pin_freedoms(motions: Array) -> list[int]:
    if motions.shape[1] == 0:
        return []
    _, _, order = qr(motions.T, pivoting=True)
    return [int(k) for k in order[: motions.shape[1]]]


def _nut_response(
    scene: Scene, mesh: GroovedBody, layout: BallLayout, sides: tuple[int, ...], patches: dict[int, SidePatches],
    settings: Settings,
) -> BodyResponse:  # fmt: skip
    """Response of the nut held at its left face."""
    e = scene.nut.material
    own = {s: p.groove for s, p in patches.items() if s >= 2}
    sockets = _placed(mesh, _sockets_of(layout, sides, False))
    K = assemble(mesh.points, mesh.cells, sockets, own, e.youngs_modulus, e.poissons_ratio)
    held = (3 * mesh.low_end[:, None] + np.arange(3)).ravel()
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    C = sp.identity(K.shape[0], format="csc")[:, free]
    return respond(K, sockets, own, C, np.zeros((free.size, 0)), count=settings.modes)
