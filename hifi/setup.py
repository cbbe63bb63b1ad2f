"""One geometry of the 3D reference: meshes, condensed patches, and how screw, nut and balls answer contact forces.

Screw, nut and one ball are meshed coarsely with a socket at every contact; one fine patch per side is condensed exactly and
fits every socket of that side. All load cases, supports and error patterns of the geometry share this set-up.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from time import perf_counter
from typing import Literal

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from hifi.bodies import Socket, assemble, freedoms, isostatic, mode_rows, patch_modes
from hifi.cell import Homogenised, homogenise, with_core
from hifi.elasticity import rigid_modes
from hifi.fit import Settings, ball_place, patch_lines, socket_size
from hifi.mounting import Stretch
from hifi.patch import CondensedPatch, PatchMesh, build_patch, build_tet_patch, condense_patch
from hifi.response import compliance, transport
from hifi.shaft import ShaftSection, round_section
from meshes.ball_body import BallBody, build_ball
from meshes.cache import Cache
from meshes.groove_map import GrooveMap
from meshes.grooved_body import BodySpec, GroovedBody, build_body
from meshes.helix import BallLayout, ball_layout
from meshes.parts import Scene
from meshes.sockets import SocketMesh, SocketSize, local_points
from meshes.solid import Dimensions, dimensions
from meshes.tet_patch import build_tets, source_box

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Step = Callable[[str], None]
#: Edges [m] of first-order tetrahedra tried at a patch's rim; long ones may be turned inside out by the map to space.
FAR = (0.5e-3, 0.35e-3, 0.25e-3, 0.15e-3)
#: Contact as a socket of a body: (azimuth [rad], z [m], side).
Place = tuple[float, float, int]


@dataclass(frozen=True)
class SidePatches:
    """Patches of one side: of the groove and of the ball, on the same contact nodes."""

    groove: CondensedPatch
    ball: CondensedPatch


@dataclass(frozen=True)
class ScrewResponse:
    """3D stretch of the screw, modes V of each side's patches, rigid rows ``(contacts, k, 6)`` of every contact's modes
    about its own station, unknowns."""

    stretch: Stretch
    modes: dict[int, Array]
    rigid: Array
    unknowns: int


@dataclass(frozen=True)
class NutResponse:
    """Coupling G of the modes of all contacts, modes V of each side's patches, unknowns."""

    G: Array
    modes: dict[int, Array]
    unknowns: int


@dataclass(frozen=True)
class BallResponse:
    """Compliance D of one ball on the contact nodes of all its sides, rigid motions held isostatically; unknowns."""

    D: Array
    unknowns: int


@dataclass(frozen=True)
class Shaft:
    """Section of the shaft beyond the 3D stretch, and where it comes from."""

    section: ShaftSection
    homogenised: Homogenised | None


@dataclass
class Setup:
    """Everything of one geometry that load cases share; ``nut`` is None where it is rigid. ``left_out``: bound on the
    relative change of a contact's compliance by the modes left out."""

    scene: Scene
    map: GrooveMap
    layout: BallLayout
    dims: Dimensions
    settings: Settings
    sides: tuple[int, ...]
    patches: dict[int, SidePatches]
    screw: ScrewResponse
    nut: NutResponse | None
    ball: Array
    section: ShaftSection
    homogenised: Homogenised | None
    left_out: float
    unknowns: int
    quality: dict[str, float]
    seconds: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Meshes:
    """Meshes of one geometry: coarse screw, nut (None: rigid) and ball, socket size, contact zone of the patches."""

    screw: GroovedBody
    nut: GroovedBody
    ball: BallBody
    size: SocketSize
    zone: tuple[float, float]
    widths: tuple[float, float]


def mesh_parts(
    scene: Scene, m: GrooveMap, layout: BallLayout, dims: Dimensions, sides: tuple[int, ...], settings: Settings,
    cache: Cache | None = None,
) -> Meshes:  # fmt: skip
    """Mesh screw, nut and one ball of a scene."""
    cache = cache or Cache(None)
    size = socket_size(scene, m, layout, sides, dims)
    widths = (size.gamma * float(m.radius.mean()), size.phi * m.R)
    _, zone = patch_lines(settings, widths, size.depth)
    low, high = dims.ends(scene)
    nut, position = scene.nut, scene.nut.position
    screw_spec = BodySpec(
        dims.hole, scene.screw.outer_diameter / 2.0, low, high, True, sockets_of(layout, sides, True), size,
        settings.fine, settings.coarse,
    )  # fmt: skip
    nut_spec = BodySpec(
        dims.land, nut.outer_diameter / 2.0, position - nut.length / 2.0, position + nut.length / 2.0, False,
        sockets_of(layout, sides, False), size, settings.fine, settings.coarse,
    )  # fmt: skip
    sockets = tuple(ball_place(m, size, s, zone)[0] for s in sides)
    fine, coarse = settings.ball_fine, settings.ball_coarse
    ball = cache.get("ball", (m, sockets, fine, coarse), lambda: build_ball(m, sockets, fine, coarse), BallBody)
    screw = cache.get("screw", (m, screw_spec), lambda: build_body(m, screw_spec), GroovedBody)
    outer = cache.get("nut", (m, nut_spec), lambda: build_body(m, nut_spec), GroovedBody)
    return Meshes(screw, outer, ball, size, zone, widths)


def prepare(
    scene: Scene, sides: tuple[int, ...], settings: Settings, step: Step = lambda _: None,
    scenes: Sequence[Scene] = (), *, cache: Cache | None = None,
) -> Setup:  # fmt: skip
    """Meshes, patches and bodies of one geometry; ``sides``: which of SL, SR, NL, NR (0 to 3) may carry load.

    scenes: further scenes of the same parts that will be solved with this set-up; they may differ in loads, supports and
    errors. cache: of meshes and condensed parts, keyed by all that they depend on. Raises ValueError where a mesh cannot
    be built.
    """
    cache = cache or Cache(None)
    seconds: dict[str, float] = {}
    m, layout, dims = GrooveMap.of(scene), ball_layout(scene), dimensions(scene)

    def timed(name: str, start: float) -> None:
        seconds[name] = perf_counter() - start
        step(f"{name}: {seconds[name]:.1f} s")

    start = perf_counter()
    meshes = mesh_parts(scene, m, layout, dims, sides, settings, cache)
    timed("meshes", start)
    start = perf_counter()
    patches = {}
    for s in sides:
        body, part = (meshes.screw, scene.screw) if s < 2 else (meshes.nut, scene.nut)
        recipe = (m, meshes.size, s, settings, body.sockets[s].xi, body.sockets[s].triangles, meshes.ball.sockets[s].xi,
                  meshes.ball.sockets[s].triangles, part.material, scene.balls.material)  # fmt: skip
        patches[s] = cache.get("patch", recipe, partial(condense_side, scene, m, meshes, s, settings), SidePatches)
    timed("patches", start)
    start = perf_counter()
    ball = cache.get(
        "ball-response", (meshes.ball.points, meshes.ball.cells, scene.balls.material, patches, settings.element),
        lambda: ball_compliance(scene, meshes.ball, patches, settings), BallResponse,
    )  # fmt: skip
    timed("ball", start)
    start = perf_counter()
    low, high = dims.ends(scene)
    stations = tuple(sorted({z for c in (scene, *scenes) for z in (*(x.at for x in c.supports), *(x.at for x in c.loads))}))
    shaft = cache.get(
        "shaft", (m, dims, scene.screw, low, high, stations, settings.cell),
        lambda: shaft_section(scene, m, dims, settings.cell, stations), Shaft,
    )  # fmt: skip
    timed("shaft section", start)
    start = perf_counter()
    own = {s: p.groove for s, p in patches.items() if s < 2}
    inside = tuple(z for z in stations if low < z < high)
    made_of = (meshes.screw.points, meshes.screw.cells, own, layout, sides, settings, dims, scene.screw, scene.nut, inside)
    screw = cache.get(
        "screw-response", made_of,
        lambda: screw_response(scene, inside, meshes.screw, layout, sides, own, settings, dims), ScrewResponse,
    )  # fmt: skip
    timed("screw", start)
    start = perf_counter()
    nut = None
    if scene.solid.nut == "elastic":
        facing = {s: p.groove for s, p in patches.items() if s >= 2}
        nut_of = (meshes.nut.points, meshes.nut.cells, facing, layout, sides, settings, dims, scene.nut)
        nut = cache.get(
            "nut-response", nut_of,
            lambda: nut_response(scene, meshes.nut, layout, sides, facing, settings, dims), NutResponse,
        )  # fmt: skip
        timed("nut", start)
    count = layout.z.size
    unknowns = screw.unknowns + (nut.unknowns if nut else 0) + ball.unknowns * count
    unknowns += sum(p.groove.unknowns + p.ball.unknowns for p in patches.values()) * count
    left = max(
        (_left_out(patches[s].groove, settings.modes, G) for s, G in _self_blocks(screw, nut, sides).items()),
        default=0.0,
    )
    across = 2.0 * settings.b_over_h if settings.element == "Q2" else 2.0 * settings.semi[1] / settings.tet
    quality = {
        "elements across 2b": across, "screw": meshes.screw.quality.smallest, "nut": meshes.nut.quality.smallest,
        "ball": meshes.ball.quality.smallest, "deviation": max(meshes.screw.deviation, meshes.nut.deviation),
    }  # fmt: skip
    return Setup(
        scene, m, layout, dims, settings, sides, patches, screw, nut, ball.D, shaft.section, shaft.homogenised, left,
        unknowns, quality, seconds,
    )  # fmt: skip


def condense_side(scene: Scene, m: GrooveMap, meshes: Meshes, side: int, settings: Settings) -> SidePatches:
    """Condensed patches of groove and ball at one side, on the same contact nodes."""
    body = meshes.screw if side < 2 else meshes.nut
    mesh = patch_mesh(meshes, body.sockets[side], partial(local_points, m, meshes.size, side), settings)
    place = ball_place(m, meshes.size, side, meshes.zone)[1]
    ball_patch = patch_mesh(meshes, meshes.ball.sockets[side], place, settings)
    normals = patch_normals(mesh, np.array([m.R, 0.0, 0.0]))
    found = patch_normals(ball_patch, np.zeros(3))
    spread = float(np.abs(found - normals).max())
    if spread > 1e-9:
        raise ValueError(f"contact nodes of ball and groove do not match ({spread:.1e})")
    e, b = (scene.screw if side < 2 else scene.nut).material, scene.balls.material
    return SidePatches(
        condense_patch(mesh, normals, e.youngs_modulus, e.poissons_ratio),
        condense_patch(ball_patch, -normals, b.youngs_modulus, b.poissons_ratio),
    )


def patch_mesh(
    meshes: Meshes, socket: SocketMesh, place: Callable[[Array], Array], settings: Settings
) -> PatchMesh:
    """Mesh of a patch in a socket: graded hexahedra, or the source's tetrahedra."""
    lines, zone = patch_lines(settings, meshes.widths, meshes.size.depth)
    if settings.element == "Q2":
        return build_patch(lines, zone, place, socket)
    for far in FAR:
        box = source_box(meshes.widths, meshes.size.depth, zone, settings.tet, far)
        try:
            return build_tet_patch(build_tets(box, socket), place, socket, linear=True)
        except ValueError:
            if far == FAR[-1]:
                raise
    raise AssertionError("unreachable")


def patch_normals(mesh: PatchMesh, centre: Array) -> Array:
    """Unit vectors ``(c, 3)`` from the ball's centre to the contact nodes of a patch."""
    arms = mesh.points[mesh.contact] - centre
    return np.asarray(arms / np.linalg.norm(arms, axis=1)[:, None])


def body_kind(settings: Settings) -> Literal["P1", "P2"]:
    """Elements of the coarse bodies: those of the patches' order."""
    return "P2" if settings.element == "Q2" else "P1"


def sockets_of(layout: BallLayout, sides: tuple[int, ...], screw: bool) -> tuple[Place, ...]:
    """Contacts of all balls on the screw's sides, or on the nut's."""
    own = [s for s in sides if (s < 2) == screw]
    return tuple((float(a), float(z), s) for a, z in zip(layout.azimuth, layout.z, strict=True) for s in own)


def rotation(phi: float) -> Array:
    """Rotation about z."""
    c, s = np.cos(phi), np.sin(phi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def placed(mesh: GroovedBody, places: tuple[Place, ...]) -> list[Socket]:
    """Sockets of a body with their rotations."""
    return [Socket(n, rotation(x[0]), x[2]) for n, x in zip(mesh.socket_nodes, places, strict=True)]


def _self_blocks(screw: ScrewResponse, nut: NutResponse | None, sides: tuple[int, ...]) -> dict[int, Array]:
    """First contact's own block of G, per side."""
    found = {}
    for body, G in ((screw, screw.stretch.F), (nut, nut.G if nut else None)):
        start = 0
        for s in sides:
            if body is not None and G is not None and s in body.modes:
                k = body.modes[s].shape[1]
                found[s] = G[start : start + k, start : start + k]
                start += k
    return found


def _left_out(patch: CondensedPatch, count: int, G: Array) -> float:
    """Bound on the relative change of one contact's compliance by the modes left out.

    With H = V Sigma W^T and the body's compliance lambda on the kept directions, what is left out is at most
    (2 sigma_1 sigma_k+1 + sigma_k+1^2) lambda in the norm; smooth directions are the most compliant ones.
    """
    sigma = np.linalg.svd(patch.H, compute_uv=False)
    k = min(count, int((sigma > 1e-12 * sigma[0]).sum()))
    if k >= sigma.size:
        return 0.0
    scaled = G[:k, :k] / np.outer(sigma[:k], sigma[:k])
    lam = float(np.linalg.norm(scaled, 2))
    f = patch.areas / patch.areas.sum()
    own = float(f @ patch.A @ f)
    return float((2.0 * sigma[0] * sigma[k] + sigma[k] ** 2) * lam * (f @ f) / own)


def ball_compliance(
    scene: Scene, mesh: BallBody, patches: dict[int, SidePatches], settings: Settings
) -> BallResponse:
    """Dense compliance of one ball on the contact nodes of all its sides, rigid motions held isostatically."""
    e = scene.balls.material
    own = {s: p.ball for s, p in patches.items()}
    sockets = [Socket(mesh.socket_nodes[s], np.eye(3), s) for s in own]
    K = assemble(mesh.points, mesh.cells, sockets, own, e.youngs_modulus, e.poissons_ratio, kind=body_kind(settings))
    held = isostatic(mesh.points, np.concatenate([s.nodes for s in sockets]))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    kept = {s: patch_modes(p, 10**6) for s, p in own.items()}
    rows = mode_rows(sockets, {s: k[1] for s, k in kept.items()}, K.shape[0])[:, free]
    G = compliance(K[free][:, free], rows)
    V = [kept[s][0] for s in own]
    D = np.zeros((sum(v.shape[0] for v in V),) * 2)
    whole = np.zeros((D.shape[0], sum(v.shape[1] for v in V)))
    r = c = 0
    for v in V:
        whole[r : r + v.shape[0], c : c + v.shape[1]] = v
        r, c = r + v.shape[0], c + v.shape[1]
    D = whole @ G @ whole.T
    r = 0
    for p in own.values():
        D[r : r + len(p.A), r : r + len(p.A)] += p.A
        r += len(p.A)
    return BallResponse(np.asarray(0.5 * (D + D.T)), int(free.size))


def shaft_section(
    scene: Scene, m: GrooveMap, dims: Dimensions, size: float, stations: Sequence[float]
) -> Shaft:
    """Section of the shaft beyond the 3D stretch; where no station lies there, any will do."""
    e, outer = scene.screw.material, scene.screw.outer_diameter / 2.0
    low, high = dims.ends(scene)
    plain = round_section(outer, e.youngs_modulus, e.poissons_ratio)
    if dims.screw_held == "bore" or all(low <= z <= high for z in stations):
        return Shaft(plain, None)
    if dims.shaft_radius is not None:
        return Shaft(round_section(dims.shaft_radius, e.youngs_modulus, e.poissons_ratio), None)
    if scene.track.lead == 0.0:
        if scene.screw.bore == 0.0:
            return Shaft(plain, None)
        bore = round_section(scene.screw.bore / 2.0, e.youngs_modulus, e.poissons_ratio)
        own = ShaftSection(plain.EA - bore.EA, plain.EI - bore.EI, plain.GJ - bore.GJ, plain.kGA - bore.kGA)
        return Shaft(own, None)
    found = homogenise(m, outer, dims.hole, e, size)
    return Shaft(with_core(found.section, dims.hole, e) if scene.screw.bore == 0.0 else found.section, found)


def screw_response(
    scene: Scene, inside: Sequence[float], mesh: GroovedBody, layout: BallLayout, sides: tuple[int, ...],
    own: dict[int, CondensedPatch], settings: Settings, dims: Dimensions,
) -> ScrewResponse:  # fmt: skip
    """The 3D stretch of the screw, held at its base; ``inside``: stations of supports and loads within it."""
    e = scene.screw.material
    places = sockets_of(layout, sides, True)
    sockets = placed(mesh, places)
    K = assemble(mesh.points, mesh.cells, sockets, own, e.youngs_modulus, e.poissons_ratio, kind=body_kind(settings))
    size = K.shape[0]
    low, high = dims.ends(scene)
    kept = {s: patch_modes(p, settings.modes) for s, p in own.items()}
    modes = mode_rows(sockets, {s: k[1] for s, k in kept.items()}, size)
    bore = dims.screw_held == "bore"
    hole = np.flatnonzero(np.abs(np.hypot(mesh.points[:, 0], mesh.points[:, 1]) - dims.hole) < 1e-7)
    base = scene.nut.position if bore else low
    if bore:
        ports: tuple[float, ...] = ()
        observers: tuple[float, ...] = ()
        T = held_transform(size, hole)
        rows = modes @ T
    else:
        ports = (high, *inside)
        half = scene.nut.length / 2.0
        observers = tuple(float(scene.nut.position + x * half) for x in (-1.0, -0.5, 0.0, 0.5, 1.0))
        T = end_transform(size, mesh, high)
        end = sp.csr_matrix((np.ones(6), (np.arange(6), T.shape[1] - 6 + np.arange(6))), (6, T.shape[1]))
        follow = [section_motion(mesh.points, hole, z, size) @ T for z in (*inside, *observers)]
        rows = sp.vstack([modes @ T, end, *follow]).tocsr()
    F = compliance((T.T @ K @ T).tocsc(), rows)
    rigid = np.asarray(modes @ rigid_modes(mesh.points, np.array([0.0, 0.0, base])))
    B = np.concatenate([rigid, *(transport(z - base) for z in (*ports, *observers))])
    stretch = Stretch(F, B, base, ports, observers, (low, high), modes.shape[0], rigid=bore)
    starts = np.concatenate([[0], np.cumsum([kept[p[2]][1].shape[0] for p in places])])
    least = min(k[1].shape[0] for k in kept.values()) if kept else 0
    about = np.array(
        [rigid[starts[i] : starts[i] + least] @ transport(base - p[1]) for i, p in enumerate(places)]
    ).reshape(len(places), least, 6)
    return ScrewResponse(stretch, {s: k[0] for s, k in kept.items()}, about, T.shape[1])


def section_motion(points: Array, hole: Index, z: float, size: int, least: int = 30) -> sp.csr_matrix:
    """Rows ``(6, size)`` of the mean rigid motion at z of the nearest nodes ``hole`` of the screw's hole."""
    order = np.argsort(np.abs(points[hole, 2] - z), kind="stable")
    reach = np.abs(points[hole, 2] - z)[order[min(least, order.size) - 1]]
    near = hole[np.abs(points[hole, 2] - z) <= 1.0001 * reach + 1e-12]
    motion = np.linalg.pinv(rigid_modes(points[near], np.array([0.0, 0.0, z])))
    return sp.csr_matrix(
        (motion.ravel(), (np.repeat(np.arange(6), 3 * near.size), np.tile(freedoms(near), 6))), (6, size)
    )


def held_transform(size: int, nodes: Index) -> sp.csc_matrix:
    """C of a body whose ``nodes`` are held."""
    free = np.setdiff1d(np.arange(size), freedoms(nodes))
    return sp.identity(size, format="csc")[:, free]


def end_transform(size: int, mesh: GroovedBody, high: float) -> sp.csc_matrix:
    """C of the stretch held at its low end, its high end a rigid section whose six freedoms come last."""
    slaves = freedoms(mesh.high_end)
    free = np.setdiff1d(np.arange(size), np.concatenate([freedoms(mesh.low_end), slaves]))
    matrix = rigid_modes(mesh.points[mesh.high_end], np.array([0.0, 0.0, high]))
    r, c = np.nonzero(matrix)
    rows = np.concatenate([free, slaves[r]])
    columns = np.concatenate([np.arange(free.size), free.size + c])
    values = np.concatenate([np.ones(free.size), matrix[r, c]])
    return sp.coo_matrix((values, (rows, columns)), (size, free.size + 6)).tocsc()


def nut_held(mesh: GroovedBody, dims: Dimensions, outer: float) -> Index:
    """Nodes at which the nut of ``outer`` radius [m] is held."""
    if dims.nut_held == "outer surface":
        return np.flatnonzero(np.abs(np.hypot(mesh.points[:, 0], mesh.points[:, 1]) - outer) < 1e-7)
    faces = {"left face": (mesh.low_end,), "right face": (mesh.high_end,), "both faces": (mesh.low_end, mesh.high_end)}
    found = np.concatenate(faces[dims.nut_held])
    r = np.hypot(mesh.points[found, 0], mesh.points[found, 1])
    return np.asarray(found[(r >= dims.held_radii[0] - 1e-7) & (r <= dims.held_radii[1] + 1e-7)])


def nut_response(
    scene: Scene, mesh: GroovedBody, layout: BallLayout, sides: tuple[int, ...], own: dict[int, CondensedPatch],
    settings: Settings, dims: Dimensions,
) -> NutResponse:  # fmt: skip
    """Response of the nut held where the scene says."""
    e = scene.nut.material
    sockets = placed(mesh, sockets_of(layout, sides, False))
    K = assemble(mesh.points, mesh.cells, sockets, own, e.youngs_modulus, e.poissons_ratio, kind=body_kind(settings))
    T = held_transform(K.shape[0], nut_held(mesh, dims, scene.nut.outer_diameter / 2.0))
    kept = {s: patch_modes(p, settings.modes) for s, p in own.items()}
    rows = mode_rows(sockets, {s: k[1] for s, k in kept.items()}, K.shape[0]) @ T
    return NutResponse(compliance((T.T @ K @ T).tocsc(), rows), {s: k[0] for s, k in kept.items()}, T.shape[1])
