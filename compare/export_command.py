"""The command ``rollbench export``: a mesh of the 3D reference as a file for other programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from compare.errors import InputError, Refusal
from compare.reference import needed_sides, settings_of
from compare.system import need_gmsh
from meshes.bridge import FORMATS, MeshData, form_of, need, reduced, write_mesh
from meshes.parts import SIDES, Scene

if TYPE_CHECKING:
    from hifi.patch import PatchMesh
    from hifi.setup import Meshes

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Show = Callable[..., None]

#: The source's body of influence for Hertz contact (a quarter of the block), without any scene's geometry.
BLOCK = "block-source"


def parts_of(scene: Scene) -> tuple[str, ...]:
    """Names of the parts that can be exported: bodies, patches of groove and ball of the sides that may touch, block."""
    sides = [SIDES[s] for s in needed_sides(scene)]
    return ("screw", "nut", "ball", *(f"patch-{s}" for s in sides), *(f"ball-patch-{s}" for s in sides), BLOCK)


def run_export(
    scene: Scene, part: str, form: str, out: Path | None, level: int, *, cache: Path | None = None, show: Show = print,
    ball: int | None = None,
) -> int:  # fmt: skip
    """Write the mesh of a part, with the sockets, contact zones and end faces as named groups; lengths in m.

    ball: solve the scene and add displacement [m], stress and von Mises stress [Pa] of that ball's parts (from 1), or of
    the whole screw or nut; None: the mesh alone.
    form: vtu, msh, med or inp, by the suffix of ``out`` unless given, vtu without one; out: the file, which is replaced
    if it exists; None: ``<scene>-<part>.<form>``; level: mesh level of the reference (0: the source's mesh); cache: folder
    of the reference's meshes, None for none.
    Raises InputError for an unknown part, format or level, a package that is missing, a mesh that cannot be built and a
    file that cannot be written; all but the last two before anything is meshed.
    """
    if part not in parts_of(scene):
        raise InputError("command line", "part", part, ", ".join(parts_of(scene)), "choose one of these")
    if form and form not in FORMATS:
        raise InputError("command line", "--format", form, ", ".join(FORMATS), "leave it out to go by the file's name")
    need_gmsh()
    if out is None:
        out = Path(f"{scene.name}-{part}.{form or 'vtu'}")
    elif out.suffix == "":
        out = out.with_name(f"{out.name}.{form or 'vtu'}")
    try:
        form = form_of(out, form)
        need(form)
    except ValueError:
        allowed = ", ".join(f".{name}" for name in FORMATS)
        raise InputError("command line", "--out", str(out), f"a name ending in {allowed}", "or give --format") from None
    except ImportError as error:
        raise InputError("command line", "--format", form, "a format whose packages are installed", str(error)) from None
    if ball is not None and not (1 <= ball <= scene.ball_count and part != BLOCK and form != "inp"):
        allowed = f"1 to {scene.ball_count}, for parts of the scene, in vtu, msh or med"
        raise InputError("command line", "--ball", str(ball), allowed, "leave it out for the mesh alone")
    fields: dict[str, Array] = {}
    try:
        data = part_mesh(scene, part, level, cache)
        if ball is not None:
            fields = result_fields(scene, part, level, ball - 1, cache)
    except ValueError as error:
        raise Refusal(scene.name, part, str(error), "see solid.* and the nut's length in the scene") from error
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_mesh(out, data, fields, form=form)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(out), "file", reason, "a folder that can be written to", "check the path") from None
    cells = ", ".join(f"{len(own)} {_LABELS[kind]}" for kind, own in data.cells.items())
    show(f"wrote {out}: {len(data.points)} nodes, {cells}; lengths in m; groups: {', '.join(data.boundaries) or 'none'}")
    if reduced(data, form):
        show(f".{form} holds no 27-node hexahedra: their face and centre nodes were left out (20 nodes remain)")
    return 0


_LABELS = {
    "P1": "4-node tetrahedra", "P2": "10-node tetrahedra", "Q1": "8-node hexahedra", "Q2": "27-node hexahedra",
}  # fmt: skip


def part_mesh(scene: Scene, part: str, level: int, cache: Path | None = None) -> MeshData:
    """Mesh of a part as the reference of that level uses it; raises ValueError where it cannot be built."""
    if part == BLOCK:
        return _block()
    from hifi.setup import mesh_parts
    from meshes.cache import Cache
    from meshes.groove_map import GrooveMap
    from meshes.helix import ball_layout
    from meshes.solid import dimensions

    settings, sides, m = settings_of([scene], level), needed_sides(scene), GrooveMap.of(scene)
    meshes = mesh_parts(scene, m, ball_layout(scene), dimensions(scene), sides, settings, Cache(cache))
    if part in ("screw", "nut", "ball"):
        return _body(meshes, part, first_order=settings.element == "P1")
    kind, _, side = part.rpartition("-")
    return _patch(_patch_mesh(meshes, m, SIDES.index(side), settings, of_ball=kind == "ball-patch"))


def result_fields(scene: Scene, part: str, level: int, ball: int, cache: Path | None = None) -> dict[str, Array]:
    """Displacement ``(n, 3)`` [m], stress ``(n, 6)`` [Pa] (xx, yy, zz, yz, xz, xy) and von Mises stress of a part's nodes.

    ball: from 0. Raises ValueError where the scene is not solved, or its screw is held or loaded beyond the low end.
    """
    from hifi import fields
    from hifi.reference import solve_reference
    from hifi.setup import body_kind, mesh_parts, prepare
    from meshes.cache import Cache

    settings, sides, store = settings_of([scene], level), needed_sides(scene), Cache(cache)
    made = prepare(scene, sides, settings, cache=store)
    result = solve_reference(made, scene)
    if result.status != "converged":
        raise ValueError(result.status)
    meshes = mesh_parts(scene, made.map, made.layout, made.dims, sides, settings, store)
    forces = fields.contact_forces(made, result)
    if part in ("screw", "nut"):
        body, material = (meshes.screw, scene.screw.material) if part == "screw" else (meshes.nut, scene.nut.material)
        if part == "screw":
            u = fields.screw_displacement(made, body, forces, scene)
        else:
            u = fields.nut_displacement(made, body, forces)
        kind, cells = body_kind(settings), body.cells
        if kind == "P1":
            from meshes.tet_patch import split_second_order

            cells = split_second_order(body.points, cells)
        stress = fields.nodal_stress(body.points, cells, kind, u, material)
    else:
        own, _, side = part.rpartition("-")
        if own == "patch":
            if side.startswith("S"):
                u = fields.screw_displacement(made, meshes.screw, forces, scene)
            else:
                u = fields.nut_displacement(made, meshes.nut, forces)
            found = fields.groove_patch_field(made, meshes, u, ball, SIDES.index(side), forces)
        else:
            found = fields.ball_fields(made, meshes, ball, forces)[SIDES.index(side) if own == "ball-patch" else None]
        u, stress = found.displacement, found.stress
    six = {f"stress_{name}": stress[:, k] for k, name in enumerate(("xx", "yy", "zz", "yz", "xz", "xy"))}
    return {"displacement": u, "von_mises": fields.von_mises(stress), **six}


def _body(meshes: Meshes, part: str, *, first_order: bool) -> MeshData:
    """Screw, nut or ball, with its sockets' inner faces and the flat ends; first_order: divided as the reference does."""
    if part == "ball":
        points, cells = meshes.ball.points, meshes.ball.cells
        groups = {f"socket {SIDES[s]}": nodes for s, nodes in meshes.ball.socket_nodes.items()}
        sockets: Sequence[Index] = list(meshes.ball.socket_nodes.values())
    else:
        body = meshes.screw if part == "screw" else meshes.nut
        points, cells, sockets = body.points, body.cells, list(body.socket_nodes)
        groups = {"low end": body.low_end, "high end": body.high_end}
    kind = "P2"
    if first_order:
        from meshes.tet_patch import split_second_order

        kind, cells = "P1", split_second_order(points, cells)
    boundaries = {name: faces_within(cells, kind, [nodes]) for name, nodes in groups.items()}
    if part != "ball":
        boundaries["sockets"] = faces_within(cells, kind, sockets)
    return MeshData(points, {kind: cells}, {}, {name: faces for name, faces in boundaries.items() if len(faces)})


def _patch_mesh(meshes: Meshes, m: Any, side: int, settings: Any, *, of_ball: bool) -> PatchMesh:
    from hifi.fit import ball_place
    from hifi.setup import patch_mesh
    from meshes.sockets import local_points

    if of_ball:
        place = ball_place(m, meshes.size, side, meshes.zone)[1]
        return patch_mesh(meshes, meshes.ball.sockets[side], place, settings)
    body = meshes.screw if side < 2 else meshes.nut
    return patch_mesh(meshes, body.sockets[side], partial(local_points, m, meshes.size, side), settings)


def _patch(mesh: PatchMesh) -> MeshData:
    """A patch with its contact zone and the faces that are tied to the body."""
    boundaries = {
        "contact": faces_within(mesh.cells, mesh.kind, [mesh.contact]),
        "interface": faces_within(mesh.cells, mesh.kind, [mesh.interface]),
    }
    return MeshData(mesh.points, {mesh.kind: mesh.cells}, {}, {k: f for k, f in boundaries.items() if len(f)})


def _block() -> MeshData:
    from hifi.block import SOURCE_COARSE, SOURCE_FINE, SOURCE_RADIUS
    from meshes.block import Influence, tetrahedra

    radius = SOURCE_RADIUS
    mesh = tetrahedra(1, Influence(SOURCE_FINE, (radius, radius, radius), 0.2, SOURCE_COARSE), SOURCE_COARSE)
    return MeshData(mesh.points, {mesh.element: mesh.cells}, {}, {"contact": mesh.faces})


def faces_within(cells: Index, kind: str, groups: Sequence[Index]) -> Index:
    """Faces ``(k, nodes of a face)`` of single cells, in gmsh's order, all of whose nodes lie in one of the groups."""
    from hifi.elements import ELEMENTS

    faces = cells[:, ELEMENTS[kind].face_nodes()]
    faces = faces.reshape(-1, faces.shape[2])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[first[count == 1]]
    found = [outer[np.isin(outer, nodes).all(axis=1)] for nodes in groups]
    return np.concatenate(found) if found else outer[:0]
