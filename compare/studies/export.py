"""Export of the 3D reference (finite-element model) as files for other programs (``rollbench export``).

Written are meshes of single parts, or with ``--deck ccx`` an input deck for CalculiX and Abaqus. The deck describes a small
scene, or a few neighbouring balls that are cut out of a larger screw together with short pieces of screw and nut.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import replace_file
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.reference.tasks import Solvable, flanks_to_mesh, mesh_settings
from rollbench.compare.running import check_gmsh
from rollbench.compare.studies.crosscheck.deck import DeckOptions, build_deck, raise_first_fault
from rollbench.hifi import fields
from rollbench.hifi.bodies.coarse import convert_mesh_order
from rollbench.hifi.contact.block import SOURCE_COARSE, SOURCE_FINE, SOURCE_RADIUS
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.part_meshes import element_type_of_bodies, mesh_parts
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import mesh_and_condense_geometry
from rollbench.hifi.several_sets import meshed_geometry_of_each_set
from rollbench.meshes.arrays import Array
from rollbench.meshes.block import EllipsoidElementSizes, mesh_block_with_tetrahedra
from rollbench.meshes.cache import Cache
from rollbench.meshes.exchange import whole_bodies
from rollbench.meshes.exchange.deck import UNITS, deck_text
from rollbench.meshes.exchange.mesh_files import with_only_boundaries
from rollbench.meshes.exchange.step_files import PlacedNutOrBearing
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Load, Scene, Support
from rollbench.meshes.solid import dimensions_of_3d_parts

if TYPE_CHECKING:
    from skfem import Mesh


#: Name of the quarter block for a Hertz contact, refined as in Lin's thesis; it does not depend on the scene.
BLOCK = "block-source"

#: Names of the bodies. Ending of the names of bodies with a refinement box (a hole for a fine contact patch) at every
#: contact, which the 3D reference condenses to the nodes of the refinement boxes.
BODIES, SOCKETS = ("screw", "nut", "ball"), "-with-sockets"

#: Growth of element size per distance from the contacts, in meshes of whole bodies.
AWAY = 0.4


def names_of_exportable_parts(scene: Scene) -> tuple[str, ...]:
    """Return the names of the parts of a scene whose meshes can be exported: bodies, fine contact patches, a test block.

    Parameters
    ----------
    scene
        Scene with one nut or bearing.

    Returns
    -------
    tuple of str
        Names of the whole bodies; of the bodies with refinement boxes (holes for fine contact patches); of the patches of
        groove and ball on the flanks that may touch; and of the quarter block that is pressed to verify Hertz contact.
    """
    sides = [SIDES[s] for s in flanks_to_mesh(scene)]
    patches = (f"{kind}-{s}" for kind in ("patch", "ball-patch") for s in sides)
    return (*BODIES, *(body + SOCKETS for body in BODIES), *patches, BLOCK)


def nuts_and_bearings_on_shaft(described: Solvable) -> list[PlacedNutOrBearing]:
    """Return each nut or ball bearing of a scene, with its axial position and the ends of the shaft's 3D mesh at it [m].

    Beyond these ends the shaft is a beam in the 3D reference. Raises ValueError for a row of rollers, whose geometry cannot
    be written.
    """
    if isinstance(described, Scene):
        return [PlacedNutOrBearing(described, 0.0, dimensions_of_3d_parts(described).ends_of_meshed_screw(described))]
    out = []
    for s, bodies in zip(described.sets, meshed_geometry_of_each_set(described), strict=True):
        if not isinstance(s.parts, Scene):
            raise ValueError(
                f"the geometry of {s.name} cannot be written, because it has rollers: only ball nuts and ball bearings can"
            )
        low, high = dimensions_of_3d_parts(bodies.parts_without_errors).ends_of_meshed_screw(bodies.parts_without_errors)
        out.append(PlacedNutOrBearing(s.parts, s.offset, (low + bodies.origin_on_shaft, high + bodies.origin_on_shaft)))
    return out


def part_mesh(scene: Scene, part: str, level: int, cache: Path | None = None) -> Mesh:
    """Mesh one part of a scene, with the element sizes of a mesh level of the 3D reference.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    part
        Name of the part, one of `names_of_exportable_parts`.
    level
        Mesh level of the 3D reference, from 1 (coarse).
    cache
        Folder of stored meshes, which takes new ones; None: nothing is stored.

    Returns
    -------
    Mesh
        The mesh, whose contact surfaces and cut faces are named boundaries.

    Raises
    ------
    ValueError
        If the part cannot be meshed.
    """
    if part == BLOCK:
        influence = EllipsoidElementSizes(SOURCE_FINE, (SOURCE_RADIUS,) * 3, 0.2, SOURCE_COARSE)
        return with_only_boundaries(mesh_block_with_tetrahedra(1, influence, SOURCE_COARSE).mesh, "contact")
    if part in BODIES:
        return _mesh_whole_body(scene, part, level)

    settings, sides, m = mesh_settings([scene], level), flanks_to_mesh(scene), GrooveMap.from_scene(scene)
    layout, dims = ball_layout(scene), dimensions_of_3d_parts(scene)
    meshes = part_meshes.mesh_parts(scene, m, layout, dims, sides, settings, Cache(cache))
    bodies: dict[str, Any] = {"ball": meshes.ball_mesh, "screw": meshes.screw_mesh, "nut": meshes.nut_mesh}
    if part.endswith(SOCKETS):  # shown are the inner faces of the refinement boxes ("socket"), the flat ends and held faces
        mesh = bodies[part.removesuffix(SOCKETS)].mesh
        names = [name for name in mesh.boundaries if "socket" in name or " end" in name or name in ("seat", "centring")]
        return with_only_boundaries(convert_mesh_order(mesh, part_meshes.element_type_of_bodies(settings)), *names)
    kind, _, side = part.rpartition("-")
    patch = fields.mesh_contact_patch(m, settings, meshes, SIDES.index(side), on_ball=kind == "ball-patch")
    return with_only_boundaries(patch.mesh, "contact", "interface")


def solve_displacement_and_stress_of_part(
    scene: Scene, part: str, level: int, ball: int, cache: Path | None = None
) -> dict[str, Array]:
    """Solve a scene by the 3D reference, and return displacement and stress at the mesh nodes of one part.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    part
        Name of the part, one of `names_of_exportable_parts`.
    level
        Mesh level of the 3D reference, from 1 (coarse).
    ball
        Number of the ball, from 0, for a part that each ball has (the ball, or a contact patch).
    cache
        Folder of stored meshes, which takes new ones; None: nothing is stored.

    Returns
    -------
    dict
        Fields at the n nodes by name: displacement (n, 3) [m], von Mises stress (n,) [Pa], and the six components of the
        stress (n,) [Pa], such as "stress_xx".

    Raises
    ------
    ValueError
        If the scene cannot be solved, or if a support or load acts on the screw at a larger z than the low end of its 3D
        mesh.
    """
    settings, sides, store = mesh_settings([scene], level), flanks_to_mesh(scene), Cache(cache)
    setup = mesh_and_condense_geometry(scene, sides, settings, cache=store)
    result = solve_reference(setup, scene)
    if result.status != "converged" and result.remaining_load_change == 0.0:
        raise ValueError(result.status)
    meshes = mesh_parts(scene, setup.groove_map, setup.ball_positions, setup.solid_dimensions, sides, settings, store)
    forces = fields.contact_node_forces_by_flank(setup, result)

    def nodal_displacement_of_body(screw: bool) -> Array:
        """Return the displacements of the n mesh nodes of the screw (``screw`` true) or of the nut (false), (n, 3) [m]."""
        if screw:
            return fields.nodal_displacements_of_screw(setup, meshes.screw_mesh, forces, scene)
        return fields.nodal_displacements_of_nut(setup, meshes.nut_mesh, forces)

    kind, _, side = part.removesuffix(SOCKETS).rpartition("-")
    if side in ("screw", "nut"):
        screw = side == "screw"
        body, material = (meshes.screw_mesh if screw else meshes.nut_mesh), (scene.screw if screw else scene.nut).material
        u = nodal_displacement_of_body(screw)
        stress = fields.nodal_stress(convert_mesh_order(body.mesh, element_type_of_bodies(settings)), u, material)
    else:
        if kind == "patch":
            u = nodal_displacement_of_body(side.startswith("S"))
            field = fields.stress_field_of_groove_patch(setup, meshes, u, ball, SIDES.index(side), forces)
        else:
            of_ball = fields.stress_fields_of_ball(setup, meshes, ball, forces)
            field = of_ball[SIDES.index(side) if kind == "ball-patch" else None]
        u, stress = field.displacements, field.stresses
    six = {f"stress_{name}": stress[:, k] for k, name in enumerate(("xx", "yy", "zz", "yz", "xz", "xy"))}
    return {"displacement": u, "von_mises": fields.von_mises(stress), **six}


def _mesh_whole_body(scene: Scene, part: str, level: int) -> Mesh:
    """Mesh a whole body, without holes for contact patches; its finest elements lie at the expected contacts.

    ``part``: "screw" (the length of it that is modelled in 3D), "nut" or "ball"; ``level``: mesh level of the 3D reference.
    """
    settings, sides, m = mesh_settings([scene], level), flanks_to_mesh(scene), GrooveMap.from_scene(scene)
    layout, dims, middle = ball_layout(scene), dimensions_of_3d_parts(scene), np.zeros((1, 2))
    if part == "ball":
        near = np.concatenate([whole_bodies.points_on_ball_surface(m, side, m.ball, middle) for side in sides])
        sizes = whole_bodies.ElementSizesNearPoints(near, settings.ball_fine, AWAY, settings.ball_coarse)
        body = whole_bodies.mesh_whole_ball(m, m.ball, sizes)
    else:
        recipes, _ = part_meshes.list_part_mesh_calls(scene, m, layout, dims, sides, settings)
        _, (_, spec), _ = recipes[BODIES.index(part)]
        near = np.concatenate([whole_bodies.points_on_groove(m, place, middle) for place in spec.contact_positions])
        sizes = whole_bodies.ElementSizesNearPoints(near, settings.fine, AWAY, settings.coarse)
        body = whole_bodies.mesh_whole_body(m, spec, sizes)
    mesh = convert_mesh_order(body.mesh, part_meshes.element_type_of_bodies(settings))
    return with_only_boundaries(mesh, *sorted(mesh.boundaries))


#: Programs for which decks are written; Abaqus reads the deck of CalculiX.
PROGRAMS = ("ccx",)

#: Allowed ranges: elements across the minor semi-axis, growth of element size per distance, contact stiffness [N/mm3].
BOUNDS = {"b_over_h": (0.4, 8.0), "growth": (0.1, 1.5), "stiffness": (1e5, 1e12)}

#: Length of the nut beyond the outermost balls, and of the 3D screw beyond the nut, over the ball radius.
NUT, SHAFT = 3.0, 3.0


def write_calculix_deck(
    program: str, unit: str, balls: str, b_over_h: float, growth: float, stiffness: float, scene: Scene, out: Path | None
) -> str:
    """Write the input deck of a scene for CalculiX, and return a line on its size and how to run it.

    Parameters
    ----------
    program
        Name of the program that reads the deck; only ``ccx``.
    unit
        Unit of length of the deck.
    balls
        Range of the balls, numbered from 1, to which the scene is reduced, with a shortened screw and nut, such as ``3:5``;
        empty: the whole scene.
    b_over_h
        Number of elements across the minor semi-axis of the contact ellipse.
    growth
        Increase of the element size per unit of distance from the contacts.
    stiffness
        Penalty stiffness of the contact: pressure per depth of penetration [N/mm3].
    scene
        Scene of one nut or bearing.
    out
        File of the deck, replaced if it exists; None: ``<scene>.inp``.

    Returns
    -------
    str
        A line on the size of the deck and how to run it.

    Raises
    ------
    InputError
        If an argument is out of range, if the scene is too large or has features that a deck cannot describe, or if the
        file cannot be written.
    """
    faults = [
        (program not in PROGRAMS, "deck", program, ", ".join(PROGRAMS), "write the deck for ccx, which Abaqus reads too"),
        (unit not in UNITS, "unit", unit, ", ".join(UNITS), "choose the unit of length; forces are in N"),
    ]
    for (name, (low, high)), value in zip(BOUNDS.items(), (b_over_h, growth, stiffness), strict=True):
        within = low <= value <= high
        faults.append((not within, name, f"{value:g}", f"{low:g} to {high:g}", "leave it out for the default"))
    ending = out is None or out.suffix.lower() == ".inp"
    faults.append((not ending, "out", str(out), "a name ending in .inp", "rename the file: CalculiX reads no other"))
    for there, *said in faults:
        if there:
            raise ArgumentError(*said)
    check_gmsh()
    if balls:
        scene = cut_balls_out_of_screw(scene, *parse_ball_range(balls, scene))
    out = out or Path(f"{scene.name}.inp")
    deck = build_deck(scene, DeckOptions(b_over_h, growth, 1e9 * stiffness)).deck
    replace_file(out, deck_text(deck, unit))
    name = shlex.quote(str(out.with_suffix("")))
    return (
        f"wrote {out}: {deck.node_count} nodes, {sum(len(b.cells) for b in deck.bodies)} 10-node tetrahedra, "
        f"{len(deck.contact_pairs)} contacts; units {UNITS[unit].names}; run it with: ccx -i {name}"
    )


def parse_ball_range(range_text: str, scene: Scene) -> tuple[int, int]:
    """Return the numbers of the first and last ball, from 1, that a text such as "3:5" states.

    Raises InputError for another text, and for balls that the scene does not have.
    """
    allowed = f"FIRST:LAST with balls from 1 to {scene.ball_count}"
    words = re.fullmatch(r"([0-9]{1,9}):([0-9]{1,9})", range_text)
    first, last = (int(words[1]), int(words[2])) if words else (0, 0)
    if not 1 <= first <= last <= scene.ball_count:
        raise ArgumentError("balls", range_text, allowed, "give a range such as 3:5 for balls 3, 4 and 5")
    return first, last


def cut_balls_out_of_screw(scene: Scene, first: int, last: int) -> Scene:
    """Return the scene of a few neighbouring balls of a screw with one start, between shortened nut and screw.

    Every load and support moves to the nearer end of the shortened screw. Loads are multiplied by the ratio of the number
    of these balls to the number of all balls. Geometric errors of single balls stay with these balls.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    first, last
        Numbers of the first and last ball of the new scene, from 1.

    Returns
    -------
    Scene
        The scene with only these balls.

    Raises
    ------
    InputError
        For a bearing, several starts, a flange, random errors (their draws depend on the number of balls), prescribed
        displacements, and balls too near to the end of the screw.
    """
    track, layout = scene.track, ball_layout(scene)
    moved = any(v for s in scene.supports for _, v in s.fixed)
    faults = (
        (track.lead == 0.0, "track.lead", "0 mm", "a lead above 0 mm: a bearing ring cannot be cut"),
        (track.starts != 1, "track.starts", str(track.starts), "1"),
        (scene.nut.flange is not None, "nut.flange", "a flange", "a nut without a flange"),
        (scene.errors.random, "errors", "random errors", "errors with stated values only"),
        (moved, "supports", "a prescribed displacement", "supports that fix at zero displacement"),
    )
    advice = "write a scene of a few balls yourself, and leave `balls` out"
    raise_first_fault(scene.name, [(*fault, advice) for fault in faults])
    kept = slice(first - 1, last)
    z, azimuth = layout.z[kept], layout.azimuth[kept]
    r, middle = scene.balls.radius, float(0.5 * (z.min() + z.max()))
    length = float(np.ptp(z)) + 2.0 * NUT * r
    low, high = middle - length / 2.0 - SHAFT * r, middle + length / 2.0 + SHAFT * r
    if low < 0.0 or high > scene.screw.length:
        allowed, advice = "balls away from the screw's ends", "choose balls nearer to the middle of the nut"
        raise ArgumentError("balls", f"{first}:{last}", allowed, advice, scene.name)
    share = (last - first + 1) / scene.ball_count

    def nearer_end(at: float) -> float:
        """Return the axial position [m] of the end of the shortened screw that is nearer to the position ``at`` [m]."""
        return low if at <= middle else high

    listed = tuple((n - first + 1, e) for n, e in scene.errors.balls.listed if first <= n <= last)
    return replace(
        scene,
        name=f"{scene.name}-balls-{first}-{last}",
        title=f"Balls {first} to {last} of: {scene.title}",
        track=replace(track, phase=float(0.5 * (azimuth[0] + azimuth[-1]))),
        nut=replace(scene.nut, position=middle, length=length),
        balls=replace(scene.balls, azimuths=tuple(azimuth.tolist())),
        errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=listed)),
        supports=tuple(Support(nearer_end(s.at), s.fixed) for s in scene.supports),
        loads=tuple(Load(nearer_end(x.at), x.force, x.moment) for x in with_scaled_loads(scene, share).loads),
        solid=replace(scene.solid, shaft=SHAFT * r, screw_held="ends"),
        assumed=(
            *scene.assumed,
            f"Cut of balls {first} to {last}: nut {NUT:g} ball radii beyond the outermost balls, screw {SHAFT:g} beyond "
            f"the nut; supports and loads moved to the nearer end, loads times {share:.4g}.",
        ),
    )
