"""How screw, nut and balls of the 3D reference answer contact forces: meshed bodies with a socket at every contact,
condensed to the modes of their patches; the shaft beyond the 3D stretch of the screw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from skfem import Mesh, condense
from skfem.models.poisson import mass

from rollbench.hifi.bodies.coarse import (
    Socket,
    assemble,
    end_transform,
    free_transform,
    freedoms,
    isostatic,
    mode_rows,
    of_order,
    patch_modes,
)
from rollbench.hifi.bodies.patch import CondensedPatch
from rollbench.hifi.condensation.sides import SidePatches
from rollbench.hifi.elements.assembly import cells
from rollbench.hifi.elements.rigid import rigid_modes, transport
from rollbench.hifi.linear_algebra.solvers import compliance
from rollbench.hifi.meshing.part_meshes import body_kind, placed, sockets_of
from rollbench.hifi.meshing.settings import Settings
from rollbench.hifi.shaft.mounting import Stretch
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import BallBody
from rollbench.meshes.fem import freedoms_on, nodes_on, points_of
from rollbench.meshes.grooved_body import GroovedBody
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Material, Nut
from rollbench.meshes.solid import Dimensions

#: Boundaries of the nut's mesh by where it is held.
NUT_HELD = {
    "outer surface": ("outside",),
    "left face": ("low end",),
    "right face": ("high end",),
    "both faces": ("low end", "high end"),
    "flange face": ("seat",),
}
#: What follows the name of a flange's face whose centring fit is bonded.
FIT = " and centring"
#: Half the thickness of the slice whose mean motion is that of a section, over the screw's radius; least cells of one.
SLICE, LEAST = 0.25, 30


class Modal:
    """A body condensed to the modes V ``(c, k)`` of its contacts, by side: ball after ball, side after side."""

    modes: dict[int, Array]

    @property
    def per_ball(self) -> int:
        """Number of the modes of one ball's contacts."""
        return sum(V.shape[1] for V in self.modes.values())

    def rows(self, side: int, ball: int = 0) -> Index:
        """Rows of a contact's modes in the coupling of the body."""
        before = sum(V.shape[1] for V in list(self.modes.values())[: list(self.modes).index(side)])
        return np.asarray(ball * self.per_ball + before + np.arange(self.modes[side].shape[1]))


@dataclass(frozen=True)
class ScrewResponse(Modal):
    """3D stretch of the screw (that of a `Setup` is free of its cut ends), modes V of each side's patches, rigid rows
    ``(contacts, k, 6)`` of every contact's modes about its own station, unknowns."""

    stretch: Stretch
    modes: dict[int, Array]
    rigid: Array
    unknowns: int

    @property
    def G(self) -> Array:
        """Coupling of the modes of all contacts [m/N]."""
        return self.stretch.F[: self.stretch.modes, : self.stretch.modes]


@dataclass(frozen=True)
class NutResponse(Modal):
    """Coupling G of the modes of all contacts, modes V of each side's patches, unknowns; rigid: motion ``(k, 6)`` of the
    modes with the nut as a rigid body, about the station zero."""

    G: Array
    modes: dict[int, Array]
    unknowns: int
    rigid: Array


@dataclass(frozen=True)
class BallResponse(Modal):
    """How one ball couples its contacts: response G of the modes V of its sides, side after side, rigid motions held
    isostatically; unknowns."""

    G: Array
    modes: dict[int, Array]
    unknowns: int


def with_modes(
    material: Material,
    mesh: Mesh,
    sockets: Sequence[Socket],
    patches: dict[int, CondensedPatch],
    count: int,
    settings: Settings,
) -> tuple[sp.csc_array, sp.csr_array, dict[int, tuple[Array, Array]]]:
    """Stiffness of a body with its patches, rows of the ``count`` modes of every socket; modes V and their rows by side."""
    K = assemble(of_order(mesh, body_kind(settings)), sockets, patches, material.youngs_modulus, material.poissons_ratio)
    kept = {s: patch_modes(p, count) for s, p in patches.items()}
    return K, mode_rows(sockets, {s: k[1] for s, k in kept.items()}, K.shape[0]), kept


def ball_compliance(
    material: Material, mesh: BallBody, patches: dict[int, SidePatches], settings: Settings
) -> BallResponse:
    """How one ball couples the contacts of all its sides, rigid motions held isostatically (its loads balance)."""
    ball_patches = {s: p.ball for s, p in patches.items()}
    sockets = [Socket(mesh.socket_nodes[s], np.eye(3), s) for s in ball_patches]
    K, rows, kept = with_modes(material, mesh.mesh, sockets, ball_patches, settings.ball_modes, settings)
    held = isostatic(mesh.points, np.concatenate([s.nodes for s in sockets]))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    G = compliance(condense(K, D=held, expand=False), rows[:, free])
    return BallResponse(G, {s: k[0] for s, k in kept.items()}, int(free.size))


def screw_response(
    material: Material,
    nut: Nut,
    ends: tuple[float, float],
    inside: Sequence[float],
    mesh: GroovedBody,
    layout: BallLayout,
    sides: tuple[int, ...],
    patches: dict[int, CondensedPatch],
    settings: Settings,
    dims: Dimensions,
) -> ScrewResponse:
    """The 3D stretch of the screw between its ``ends``, held at its base; ``inside``: stations of supports and loads
    within it."""
    places = sockets_of(layout, sides, True)
    K, modes, kept = with_modes(material, mesh.mesh, placed(mesh, places), patches, settings.modes, settings)
    low, high = ends
    bore = dims.screw_held == "bore"
    T = screw_transform(mesh, dims, high)
    base = nut.position if bore else low
    if bore:
        ports: tuple[float, ...] = ()
        observers: tuple[float, ...] = ()
        rows = modes @ T
    else:
        ports = (high, *inside)
        half = nut.length / 2.0
        observers = tuple(float(nut.position + x * half) for x in (-1.0, -0.5, 0.0, 0.5, 1.0))
        end = sp.eye_array(T.shape[1], format="csr")[-6:]
        follow = [section_motion(mesh.mesh, z) @ T for z in (*inside, *observers)]
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


def section_motion(mesh: Mesh, z: float) -> sp.csr_array:
    """Rows ``(6, freedoms)`` of the mean rigid motion at z [m] of the material in a thin slice there, by least squares over
    its volume; turned about, a load on the section is shared out over the slice in proportion to rigid motions."""
    points, corners = points_of(mesh), mesh.p[2, mesh.t]
    radius = float(np.hypot(points[:, 0], points[:, 1]).max())
    away = np.abs(corners.mean(axis=0) - z)
    reach = max(SLICE * radius, float(np.partition(away, LEAST)[LEAST]))
    volume = mass.assemble(cells(mesh, elements=np.flatnonzero(away <= reach)))
    nodes = np.flatnonzero(volume.diagonal())
    rigid = rigid_modes(points[nodes], np.array([0.0, 0.0, z]))
    carried = (volume[nodes][:, nodes] @ rigid.reshape(nodes.size, 18)).reshape(-1, 6)
    motion = np.linalg.solve(rigid.T @ carried, carried.T)
    place = (np.repeat(np.arange(6), 3 * nodes.size), np.tile(freedoms(nodes), 6))
    return sp.csr_array((motion.ravel(), place), (6, 3 * len(points)))


def screw_transform(mesh: GroovedBody, dims: Dimensions, high: float) -> sp.csc_array:
    """C of the screw's 3D stretch: its bore held, or its low end, the high end at ``high`` [m] then a rigid section."""
    if dims.screw_held == "bore":
        return free_transform(mesh.mesh, freedoms_on(mesh.mesh, "bore"))
    return end_transform(mesh.mesh, high)


def on_bolts(x: Array, y: Array, seat: tuple[float, float], count: int) -> Array:
    """Whether points ``(n,)`` [m] of a flange's face lie in one of ``count`` circles, the first towards x, as wide as the
    annulus between the radii ``seat`` [m]."""
    middles = 0.5 * sum(seat) * np.exp(2j * np.pi / count * np.arange(count))
    return np.asarray((np.abs((x + 1j * y)[:, None] - middles) <= 0.5 * (seat[1] - seat[0]) + 1e-7).any(axis=1))


def nut_transform(mesh: GroovedBody, dims: Dimensions) -> sp.csc_array:
    """C of the nut, held where ``dims`` says."""
    surface, _, bolts = dims.nut_held.partition(", ")
    fit = surface.endswith(FIT) or (surface == "outer surface" and "centring" in (mesh.mesh.boundaries or {}))
    nodes = nodes_on(mesh.mesh, *NUT_HELD[surface.removesuffix(FIT)])
    low, high = dims.held_radii
    x, y = mesh.points[nodes, 0], mesh.points[nodes, 1]
    on = (np.hypot(x, y) >= low - 1e-7) & (np.hypot(x, y) <= high + 1e-7)
    if bolts:
        on &= on_bolts(x, y, (low, high), int(bolts.split()[0]))
    held = freedoms(np.union1d(nodes[on], nodes_on(mesh.mesh, "centring")) if fit else nodes[on])
    return free_transform(mesh.mesh, held)


def nut_response(
    material: Material,
    mesh: GroovedBody,
    layout: BallLayout,
    sides: tuple[int, ...],
    patches: dict[int, CondensedPatch],
    settings: Settings,
    dims: Dimensions,
) -> NutResponse:
    """Response of the nut held where ``dims`` says."""
    sockets = placed(mesh, sockets_of(layout, sides, False))
    K, rows, kept = with_modes(material, mesh.mesh, sockets, patches, settings.modes, settings)
    T = nut_transform(mesh, dims)
    K = (T.T @ K @ T).tocsc()
    rigid = np.asarray(rows @ rigid_modes(mesh.points, np.zeros(3)))
    return NutResponse(compliance(K, rows @ T), {s: k[0] for s, k in kept.items()}, T.shape[1], rigid)
