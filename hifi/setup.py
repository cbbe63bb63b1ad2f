"""One geometry of the 3D reference: meshes, condensed patches, and how screw, nut and balls answer contact forces.

Screw, nut and one ball are meshed coarsely with a socket at every contact; one fine patch per side is condensed exactly and
fits every socket of that side. All load cases, supports and error patterns of the geometry share this set-up.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem import condense

from hifi.bodies import (
    Socket,
    assemble,
    end_transform,
    freedoms,
    held_transform,
    isostatic,
    mode_rows,
    of_order,
    patch_modes,
)
from hifi.cell import Homogenised, homogenise
from hifi.fit import Settings
from hifi.mounting import Stretch, as_stiff_as, without_cuts
from hifi.part_meshes import Meshes, body_kind, mesh_parts, placed, sockets_of
from hifi.patch import CondensedPatch
from hifi.response import compliance, transport
from hifi.rigid import rigid_modes
from hifi.shaft import ShaftSection, round_section
from hifi.side_by_side import Part, make
from hifi.sides import SidePatches, condense_side, congruent, turned
from meshes.ball_body import BallBody
from meshes.cache import Cache
from meshes.fem import nodes_on
from meshes.groove_map import GrooveMap
from meshes.grooved_body import GroovedBody
from meshes.helix import BallLayout, ball_layout
from meshes.parts import Scene
from meshes.sockets import AZIMUTH_TURNED
from meshes.solid import Dimensions, dimensions

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Step = Callable[[str], None]
#: Contacts up to which screw and nut are condensed at once: with more, each takes gigabytes.
TOGETHER = 160
#: Boundaries of the nut's mesh by where it is held.
NUT_HELD = {
    "outer surface": ("outside",),
    "left face": ("low end",),
    "right face": ("high end",),
    "both faces": ("low end", "high end"),
}


@dataclass(frozen=True)
class ScrewResponse:
    """3D stretch of the screw (that of a `Setup` is free of its cut ends), modes V of each side's patches, rigid rows
    ``(contacts, k, 6)`` of every contact's modes about its own station, unknowns."""

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
    """How one ball couples its contacts: response G of the modes V of its sides, side after side, rigid motions held
    isostatically; unknowns."""

    G: Array
    modes: dict[int, Array]
    unknowns: int


@dataclass(frozen=True)
class Shaft:
    """Section of the shaft beyond the 3D stretch, and where it comes from."""

    section: ShaftSection
    homogenised: Homogenised | None


@dataclass
class Setup:
    """Everything of one geometry that load cases share; ``nut`` is None where it is rigid.

    seconds: of every stage (their sum passed on the clock: of stages made at once each has a share); others_MB: sum of the
    peaks of memory of the other processes that helped.
    """

    scene: Scene
    map: GrooveMap
    layout: BallLayout
    dims: Dimensions
    settings: Settings
    sides: tuple[int, ...]
    patches: dict[int, SidePatches]
    screw: ScrewResponse
    nut: NutResponse | None
    ball: BallResponse
    section: ShaftSection
    homogenised: Homogenised | None
    unknowns: int
    quality: dict[str, float]
    seconds: dict[str, float] = field(default_factory=dict)
    others_MB: float = 0.0


def prepare(
    scene: Scene,
    sides: tuple[int, ...],
    settings: Settings,
    step: Step = lambda _: None,
    scenes: Sequence[Scene] = (),
    *,
    cache: Cache | None = None,
    processes: int = 1,
) -> Setup:
    """Meshes, patches and bodies of one geometry; ``sides``: which of SL, SR, NL, NR (0 to 3) may carry load.

    scenes: further scenes of the same parts that will be solved with this set-up; they may differ in loads, supports and
    errors. cache: of meshes and condensed parts, keyed by all that they depend on. processes: that condense patches, then
    bodies, at once. Raises ValueError where a mesh cannot be built, MemoryError where a process was ended from outside.
    """
    cache = cache or Cache(None)
    seconds: dict[str, float] = {}
    m, layout, dims = GrooveMap.of(scene), ball_layout(scene), dimensions(scene)
    others: dict[int, float] = {}

    def told(stage: str, spent: float, origin: str) -> None:
        seconds[stage] = spent
        step(f"{stage}: {spent:.1f} s{origin}")

    def made(parts: Sequence[Part], at_once: int) -> list[Any]:
        """Records of the parts; each stage has its share of the time that all took."""
        start = perf_counter()
        found = make(parts, cache, at_once)
        share = (perf_counter() - start) / max(sum(one.seconds for one in found), 1e-9)
        for stage in dict.fromkeys(part.stage for part in parts):
            own = [one for part, one in zip(parts, found, strict=True) if part.stage == stage]
            told(stage, share * sum(one.seconds for one in own), _origin([one.cached for one in own]))
        for one in found:
            if one.process != os.getpid() and one.peak_MB is not None:
                others[one.process] = max(others.get(one.process, 0.0), one.peak_MB)
        return [one.value for one in found]

    start, known = perf_counter(), (cache.hits, cache.misses)
    meshes = mesh_parts(scene, m, layout, dims, sides, settings, cache)
    hits, misses = cache.hits - known[0], cache.misses - known[1]
    told("meshes", perf_counter() - start, _origin([True] * hits + [False] * misses))
    like = {
        s: s - 1
        for s in sides
        if s - 1 in sides and settings.element == "Q2" and congruent(m, s) and _same_boxes(meshes, s)
    }
    alone = [s for s in sides if s not in like]
    patches = dict(
        zip(alone, made([_patch_part(scene, m, dims, meshes, s, settings) for s in alone], processes), strict=True)
    )
    patches = {s: patches[s] if s in patches else turned(patches[like[s]]) for s in sides}

    low, high = dims.ends(scene)
    stations = tuple(sorted({z for c in (scene, *scenes) for z in (*(x.at for x in c.supports), *(x.at for x in c.loads))}))
    inside = tuple(z for z in stations if low < z < high)
    own = {s: p.groove for s, p in patches.items() if s < 2}
    facing = {s: p.groove for s, p in patches.items() if s >= 2}
    ball_of = (meshes.ball.points, meshes.ball.cells, scene.balls.material, patches, settings)
    shaft_of = (m, dims, scene.screw, low, high, stations, settings.cell)
    screw_of = (meshes.screw.points, meshes.screw.cells, own, layout, sides, settings, dims, scene.screw, scene.nut, inside)
    nut_of = (meshes.nut.points, meshes.nut.cells, facing, layout, sides, settings, dims, scene.nut)
    screw_from = (scene, inside, meshes.screw, layout, sides, own, settings, dims)
    bodies = [
        Part("shaft section", "shaft", shaft_of, shaft_section, (scene, m, dims, settings.cell, stations), Shaft),
        Part("screw", "screw-response", screw_of, screw_response, screw_from, ScrewResponse),
        Part("ball", "ball-response", ball_of, ball_compliance, (scene, meshes.ball, patches, settings), BallResponse),
    ]
    if scene.solid.nut == "elastic":
        nut_from = (scene, meshes.nut, layout, sides, facing, settings, dims)
        bodies.insert(2, Part("nut", "nut-response", nut_of, nut_response, nut_from, NutResponse))
    shaft, screw, *nuts, ball = made(bodies, processes if layout.z.size * len(sides) <= TOGETHER else 1)
    nut: NutResponse | None = nuts[0] if nuts else None
    if shaft.homogenised is not None:
        along = np.repeat(layout.z, sum(s < 2 for s in sides))
        stretch = as_stiff_as(screw.stretch, screw.rigid, along, shaft.section, shaft.homogenised.cut, m)
        screw = replace(screw, stretch=without_cuts(stretch, shaft.homogenised.cut, m, stations))
    count = layout.z.size
    unknowns = screw.unknowns + (nut.unknowns if nut else 0) + ball.unknowns * count
    unknowns += sum(p.groove.unknowns + p.ball.unknowns for p in patches.values()) * count
    across = 2.0 * settings.b_over_h if settings.element == "Q2" else 2.0 * settings.semi[1] / settings.tet
    quality = {
        "elements across 2b": across,
        "screw": meshes.screw.quality.smallest,
        "nut": meshes.nut.quality.smallest,
        "ball": meshes.ball.quality.smallest,
        "deviation": max(meshes.screw.deviation, meshes.nut.deviation),
    }
    return Setup(
        scene,
        m,
        layout,
        dims,
        settings,
        sides,
        patches,
        screw,
        nut,
        ball,
        shaft.section,
        shaft.homogenised,
        unknowns,
        quality,
        seconds,
        sum(others.values()),
    )


def _origin(cached: Sequence[bool]) -> str:
    """What is said of records, some of which came from the cache."""
    if not any(cached):
        return ""
    return ", from the cache" if all(cached) else ", partly from the cache"


def _patch_part(scene: Scene, m: GrooveMap, dims: Dimensions, meshes: Meshes, s: int, settings: Settings) -> Part:
    """The patches of a side, as a part to be made."""
    body, part = (meshes.screw, scene.screw) if s < 2 else (meshes.nut, scene.nut)
    recipe = (
        m,
        dims,
        meshes.size,
        s,
        settings,
        body.sockets[s].xi,
        body.sockets[s].triangles,
        meshes.ball.sockets[s].xi,
        meshes.ball.sockets[s].triangles,
        part,
        scene.balls.material,
    )
    return Part("patches", "patch", recipe, condense_side, (scene, m, dims, meshes, s, settings), SidePatches)


def _same_boxes(meshes: Meshes, side: int) -> bool:
    """Whether the sockets of a right flank have the nodes of the left one's, azimuths turned round, in groove and ball."""
    bodies = (meshes.screw if side < 2 else meshes.nut, meshes.ball)
    return all(
        np.array_equal(x.sockets[side].xi, x.sockets[side - 1].xi * AZIMUTH_TURNED)
        and np.array_equal(np.sort(x.sockets[side].triangles[:, :3]), np.sort(x.sockets[side - 1].triangles[:, :3]))
        for x in bodies
    )


def ball_compliance(scene: Scene, mesh: BallBody, patches: dict[int, SidePatches], settings: Settings) -> BallResponse:
    """How one ball couples the contacts of all its sides, rigid motions held isostatically (its loads balance)."""
    e = scene.balls.material
    own = {s: p.ball for s, p in patches.items()}
    sockets = [Socket(mesh.socket_nodes[s], np.eye(3), s) for s in own]
    K = assemble(of_order(mesh.mesh, body_kind(settings)), sockets, own, e.youngs_modulus, e.poissons_ratio)
    held = isostatic(mesh.points, np.concatenate([s.nodes for s in sockets]))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    kept = {s: patch_modes(p, settings.ball_modes) for s, p in own.items()}
    rows = mode_rows(sockets, {s: k[1] for s, k in kept.items()}, K.shape[0])[:, free]
    G = compliance(condense(K, D=held, expand=False), rows)
    return BallResponse(G, {s: k[0] for s, k in kept.items()}, int(free.size))


def shaft_section(scene: Scene, m: GrooveMap, dims: Dimensions, size: float, stations: Sequence[float]) -> Shaft:
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
    found = homogenise(m, outer, scene.screw.bore / 2.0, dims.hole, e, size)
    return Shaft(found.section, found)


def screw_response(
    scene: Scene,
    inside: Sequence[float],
    mesh: GroovedBody,
    layout: BallLayout,
    sides: tuple[int, ...],
    own: dict[int, CondensedPatch],
    settings: Settings,
    dims: Dimensions,
) -> ScrewResponse:
    """The 3D stretch of the screw, held at its base; ``inside``: stations of supports and loads within it."""
    e = scene.screw.material
    places = sockets_of(layout, sides, True)
    sockets = placed(mesh, places)
    K = assemble(of_order(mesh.mesh, body_kind(settings)), sockets, own, e.youngs_modulus, e.poissons_ratio)
    size = K.shape[0]
    low, high = dims.ends(scene)
    kept = {s: patch_modes(p, settings.modes) for s, p in own.items()}
    modes = mode_rows(sockets, {s: k[1] for s, k in kept.items()}, size)
    bore = dims.screw_held == "bore"
    T = screw_transform(mesh, dims, high)
    base = scene.nut.position if bore else low
    if bore:
        ports: tuple[float, ...] = ()
        observers: tuple[float, ...] = ()
        rows = modes @ T
    else:
        ports = (high, *inside)
        half = scene.nut.length / 2.0
        observers = tuple(float(scene.nut.position + x * half) for x in (-1.0, -0.5, 0.0, 0.5, 1.0))
        end = sp.csr_matrix((np.ones(6), (np.arange(6), T.shape[1] - 6 + np.arange(6))), (6, T.shape[1]))
        hole = nodes_on(mesh.mesh, "bore")
        follow = [section_motion(mesh.points, hole, z, size) @ T for z in (*inside, *observers)]
        rows = sp.vstack([modes @ T, end, *follow]).tocsr()
    K = (T.T @ K @ T).tocsc()  # the free body's is dropped: a gigabyte with 400 contacts
    F = compliance(K, rows)
    rigid = np.asarray(modes @ rigid_modes(mesh.points, np.array([0.0, 0.0, base])))
    B = np.concatenate([rigid, *(transport(z - base) for z in (*ports, *observers))])
    stretch = Stretch(F, B, base, ports, observers, (low, high), modes.shape[0], rigid=bore)
    starts = np.concatenate([[0], np.cumsum([kept[p[2]][1].shape[0] for p in places])])
    least = min(k[1].shape[0] for k in kept.values()) if kept else 0
    about = np.array([rigid[starts[i] : starts[i] + least] @ transport(base - p[1]) for i, p in enumerate(places)]).reshape(
        len(places), least, 6
    )
    return ScrewResponse(stretch, {s: k[0] for s, k in kept.items()}, about, T.shape[1])


#: Least number of nodes that the motion of a section is taken from.
LEAST = 30


def section_motion(points: Array, hole: Index, z: float, size: int) -> sp.csr_matrix:
    """Rows ``(6, size)`` of the mean rigid motion at z of the nearest nodes ``hole`` of the screw's hole."""
    order = np.argsort(np.abs(points[hole, 2] - z), kind="stable")
    reach = np.abs(points[hole, 2] - z)[order[min(LEAST, order.size) - 1]]
    near = hole[np.abs(points[hole, 2] - z) <= 1.0001 * reach + 1e-12]
    motion = np.linalg.pinv(rigid_modes(points[near], np.array([0.0, 0.0, z])))
    return sp.csr_matrix((motion.ravel(), (np.repeat(np.arange(6), 3 * near.size), np.tile(freedoms(near), 6))), (6, size))


def screw_transform(mesh: GroovedBody, dims: Dimensions, high: float) -> sp.csc_matrix:
    """C of the screw's 3D stretch: its bore held, or its low end, the high end at ``high`` [m] then a rigid section."""
    return held_transform(mesh.mesh, "bore") if dims.screw_held == "bore" else end_transform(mesh.mesh, high)


def nut_transform(mesh: GroovedBody, dims: Dimensions) -> sp.csc_matrix:
    """C of the nut, held where ``dims`` says."""
    found = nodes_on(mesh.mesh, *NUT_HELD[dims.nut_held])
    r = np.hypot(mesh.points[found, 0], mesh.points[found, 1])
    held = freedoms(found[(r >= dims.held_radii[0] - 1e-7) & (r <= dims.held_radii[1] + 1e-7)])
    size = mesh.mesh.doflocs.size
    return sp.identity(size, format="csc")[:, np.setdiff1d(np.arange(size), held)]


def nut_response(
    scene: Scene,
    mesh: GroovedBody,
    layout: BallLayout,
    sides: tuple[int, ...],
    own: dict[int, CondensedPatch],
    settings: Settings,
    dims: Dimensions,
) -> NutResponse:
    """Response of the nut held where the scene says."""
    e = scene.nut.material
    sockets = placed(mesh, sockets_of(layout, sides, False))
    K = assemble(of_order(mesh.mesh, body_kind(settings)), sockets, own, e.youngs_modulus, e.poissons_ratio)
    T = nut_transform(mesh, dims)
    kept = {s: patch_modes(p, settings.modes) for s, p in own.items()}
    rows = mode_rows(sockets, {s: k[1] for s, k in kept.items()}, K.shape[0]) @ T
    K = (T.T @ K @ T).tocsc()
    return NutResponse(compliance(K, rows), {s: k[0] for s, k in kept.items()}, T.shape[1])
