"""One side of the balls: its groove's and ball's patches, condensed, and what a contact of that side answers by itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rollbench.hifi.bodies.coarse import patch_modes
from rollbench.hifi.bodies.grid_wave import GridWave, grid_wave
from rollbench.hifi.bodies.patch import CondensedPatch, condense_patch
from rollbench.hifi.bodies.submodel import Piece, coarse_compliance, fine_compliance, own_compliance
from rollbench.hifi.meshing.fit import ball_place
from rollbench.hifi.meshing.part_meshes import Meshes, Sockets, carrier_mesh, patch_mesh, patch_normals, rotation
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import build_ball
from rollbench.meshes.groove import BodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import GroovedBody, build_body
from rollbench.meshes.parts import Material, Scene
from rollbench.meshes.sockets import SocketMesh, local_points, reach
from rollbench.meshes.solid import Dimensions

#: Length of a submodel beyond its socket, over the ball's radius: what the mesh of the coarse body has wrong has died out.
BEYOND = 1.5
#: Turn by 180 degrees about the radius through a ball at azimuth 0: left flanks onto right ones.
TURN = np.array([1.0, -1.0, -1.0])

SideArguments = tuple[GrooveMap, int, tuple[float, float], tuple[Material, Material], Sockets, Settings]


@dataclass(frozen=True)
class SidePatches:
    """Patches of one side: of the groove and of the ball, on the same contact nodes; local ``(c, c)`` [m/N]: what a contact
    of both answers by itself, beyond what the modes kept of the coarse bodies say (`hifi.bodies.submodel`); wave: what its
    place on the grid does to its approach (None: not taken out)."""

    groove: CondensedPatch
    ball: CondensedPatch
    local: Array
    wave: GridWave | None


def side_of(scene: Scene, m: GrooveMap, dims: Dimensions, meshes: Meshes, side: int, settings: Settings) -> SideArguments:
    """Arguments of `condense_side` for a side of a scene."""
    part, inner = (scene.screw, dims.hole) if side < 2 else (scene.nut, dims.land)
    radii, materials = (inner, part.outer_diameter / 2.0), (part.material, scene.balls.material)
    return m, side, radii, materials, meshes.sockets(side), settings


def condense_side(
    m: GrooveMap,
    side: int,
    radii: tuple[float, float],
    materials: tuple[Material, Material],
    sockets: Sockets,
    settings: Settings,
) -> SidePatches:
    """Condensed patches of groove and ball at one side, on the same contact nodes, and their own compliance.

    radii: of the grooved body's plain surface away from the groove (hole, or land) and of the other one [m]; materials: of
    that body and of the ball. Raises ValueError where the contact nodes of both do not match, or a submodel cannot be
    meshed.
    """
    groove_place = partial(local_points, m, sockets.size, side)
    ball_socket, place = ball_place(m, sockets.size, side, sockets.zone)
    mesh = patch_mesh(sockets, sockets.groove, groove_place, settings)
    ball_mesh = patch_mesh(sockets, sockets.ball, place, settings)
    normals = patch_normals(mesh, np.array([m.R, 0.0, 0.0]))
    ball_normals = patch_normals(ball_mesh, np.zeros(3))
    spread = float(np.abs(ball_normals - normals).max())
    if spread > 1e-9:
        raise ValueError(f"contact nodes of ball and groove do not match ({spread:.1e})")
    e, b = materials
    groove = condense_patch(mesh, normals, *_constants(e), carrier_mesh(sockets, sockets.groove, groove_place, settings))
    ball = condense_patch(ball_mesh, -normals, *_constants(b), carrier_mesh(sockets, sockets.ball, place, settings))
    if settings.element == "P1":  # the source's mesh is not changed
        return SidePatches(groove, ball, groove.A + ball.A, None)
    fine = replace(sockets.size, cuts=settings.own_cuts)

    def groove_piece(scale: float, *, coarse: bool) -> tuple[Piece, SocketMesh]:
        size, sizes = (sockets.size, (settings.fine, settings.coarse)) if coarse else (fine, settings.own_sizes)
        half = max(reach(m, sockets.size, (side,))) + BEYOND * m.ball
        spec = BodySpec(
            *radii, m.z0 - half, m.z0 + half, side < 2, ((m.phase, m.z0, side),), size, scale * sizes[0], scale * sizes[1]
        )
        body: GroovedBody = build_body(m, spec)
        return Piece(body.mesh, body.socket_nodes[0], rotation(m.phase), ("low end", "high end")), body.sockets[side]

    def ball_piece(scale: float, *, coarse: bool) -> tuple[Piece, SocketMesh]:
        sizes = (settings.ball_fine, settings.ball_coarse) if coarse else settings.own_ball_sizes
        cuts = sockets.size.cuts if coarse else settings.own_cuts
        body = build_ball(m, (ball_socket,), scale * sizes[0], scale * sizes[1], cuts)
        return Piece(body.mesh, body.socket_nodes[side], np.eye(3), ()), body.sockets[side]

    local, total = np.zeros_like(groove.A), np.zeros_like(groove.A)
    for piece_of, points_at, condensed, along, material, modes in (
        (groove_piece, groove_place, groove, normals, e, settings.modes),
        (ball_piece, place, ball, -normals, b, settings.ball_modes),
    ):
        piece, socket = piece_of(1.0, coarse=False)
        C = fine_compliance(piece, patch_mesh(sockets, socket, points_at, settings), along, *_constants(material))
        V, rows = patch_modes(condensed, modes)

        def response(scale: float, piece_of=piece_of, condensed=condensed, rows=rows, material=material) -> Array:  # type: ignore[no-untyped-def]
            return coarse_compliance(piece_of(scale, coarse=True)[0], condensed, rows, *_constants(material))

        local += own_compliance(C, V, response)
        total += C
    return SidePatches(groove, ball, local, grid_wave(m, side, groove, total, b))


def _constants(material: Material) -> tuple[float, float]:
    return material.youngs_modulus, material.poissons_ratio


def congruent(m: GrooveMap, side: int) -> bool:
    """Whether the side is the other flank of the same groove turned about the radius through the ball's centre."""
    return side % 2 == 1 and float(m.radius[side]) == float(m.radius[side - 1])


def turned(patches: SidePatches) -> SidePatches:
    """Patches of the right flank from those of the left one: contact nodes in their own order, azimuths turned round."""
    shape = patches.groove.shape
    assert shape is not None  # a grid
    order = np.arange(shape[0] * shape[1]).reshape(shape)[:, ::-1].ravel()

    def turn(patch: CondensedPatch) -> CondensedPatch:
        signs = np.tile(TURN, patch.H.shape[1] // 3)
        return replace(
            patch,
            A=patch.A[np.ix_(order, order)],
            H=patch.H[order] * signs,
            S=patch.S * np.outer(signs, signs),
            points=patch.points[order] * TURN,
            normals=patch.normals[order] * TURN,
            areas=patch.areas[order],
            rim=patch.rim[order],
            weights=patch.weights[order][:, order],
            socket=patch.socket * TURN,
        )

    wave = patches.wave
    if wave is not None:
        wave = replace(wave, middle=wave.middle * TURN, directions=wave.directions * TURN)
    return SidePatches(turn(patches.groove), turn(patches.ball), patches.local[np.ix_(order, order)], wave)
