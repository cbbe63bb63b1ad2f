"""Report section with pictures of the 3D reference: meshes, contact pressures, stresses around a ball, contact loads.

Pressures are shown as maps, as curves along lines of nodes, and in a table, next to those by Hertz theory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.levels import PRODUCTION
from rollbench.compare.reference.tasks import mesh_settings
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports import content

if TYPE_CHECKING:
    from rollbench.hifi.fields import ContactPressure, SolidField
    from rollbench.hifi.meshing.part_meshes import PartMeshes
    from rollbench.hifi.reference import ReferenceResult
    from rollbench.hifi.setup import CondensedGeometry


#: Factors from metres to millimetres, and from pascals to megapascals.
MM, MPA = 1e3, 1e-6


def contact_pressure_panel(name: str, contact: ContactPressure) -> content.PressurePanel:
    """Return the contour plot of the nodal pressures of one contact, with its contact ellipse by Hertz theory.

    ``name``: title of the map, such as "ball 5, SL" (SL: left flank of the screw's groove). ``contact``: pressures at the
    nodes of the contact, with Hertz's solution.
    """
    h = contact.hertz_solution
    return content.PressurePanel(
        name,
        MM * contact.position_across,
        MM * contact.position_along,
        MPA * contact.pressure,
        (MM * contact.pressure_centre[0], MM * contact.pressure_centre[1], MM * h.semi_x, MM * h.semi_y),
        f"{contact.load:.1f} N; largest {MPA * contact.pressure.max():.0f} MPa, peak pressure by Hertz "
        f"{MPA * h.pole_pressure:.0f} MPa",
    )


def pressure_profiles_figure(pressures: dict[str, ContactPressure]) -> content.Figure:
    """Draw the pressure of each contact across and along the groove, by the 3D reference and by Hertz theory.

    The curves follow the two lines of nodes through the node with the largest pressure. ``pressures``: pressures at the
    nodes of each contact, by the contact's name.
    """
    panels = []
    for name, one in pressures.items():
        assert one.grid_shape is not None
        grid = np.arange(one.pressure.size).reshape(one.grid_shape)
        i, k = np.unravel_index(int(one.pressure.argmax()), one.grid_shape)
        for title, line, distance, axis in (
            ("across the groove", grid[:, k], one.position_across, 0),
            ("along the groove", grid[i], one.position_along, 1),
        ):
            at = np.linspace(distance[line].min(), distance[line].max(), 161)
            other = (one.position_along if axis == 0 else one.position_across)[line].mean() - one.pressure_centre[1 - axis]
            along_line, beside = at - one.pressure_centre[axis], other + 0.0 * at
            across, along = (along_line, beside) if axis == 0 else (beside, along_line)
            nodal, hertz = MPA * one.pressure[line], MPA * one.hertz_solution.pressure(across, along)
            curves = (
                content.Series("3D reference, nodes", list(MM * distance[line]), list(nodal), "markers"),
                content.Series("Hertz", list(MM * at), list(hertz), "line"),
            )
            x, y = "distance from the nominal contact / mm", "pressure / MPa"
            panels.append(content.Panel(f"{name}, {title}", x, y, curves, include_zero=True))
    return content.Figure(
        "pressure-profiles",
        "Contact pressure of one ball across and along the groove, by the 3D reference and by Hertz theory",
        tuple(panels),
        "Dots: the lines of nodes through the largest pressure. Curves: Hertz theory for the same load, centred on the "
        "resultant force.",
    )


def node_spacing_along_groove(contact: ContactPressure) -> float:
    """Return the mean distance [m] of neighbouring nodes in the groove direction, in the fine mesh patch of one contact.

    ``contact``: pressures of the contact, with the positions of its nodes.
    """
    assert contact.grid_shape is not None
    return float(np.abs(np.diff(contact.position_along.reshape(contact.grid_shape), axis=1)).mean())


def largest_pressure_table(pressures_by_scene: dict[str, dict[str, ContactPressure]]) -> content.Table:
    """Return the table of the largest pressure of each contact, by the 3D reference and by Hertz theory.

    ``pressures_by_scene``: nodal pressures by name of the scene, then by name of the contact.
    """
    rows: list[content.Row] = [
        {
            "contact": f"{scene}, {name}",
            "contact_load": x.load,
            "nodal_pressure": MPA * float(x.pressure.max()),
            "hertz_pressure": MPA * h.pole_pressure,
            "pressure_ratio": float(x.pressure.max() / h.pole_pressure),
            "semi_axis_a": MM * h.semi_x,
            "semi_axis_b": MM * h.semi_y,
            "node_spacings": 2.0 * h.semi_y / node_spacing_along_groove(x),
        }
        for scene, found in pressures_by_scene.items()
        for name, x in found.items()
        for h in (x.hertz_solution,)
    ]
    return content.Table.from_rows(
        "pictures-pressure",
        "Largest nodal pressure of each contact by the 3D reference, and peak pressure by Hertz theory",
        rows,
        (
            "Nodal pressure: nodal force over tributary area. Where the pressure varies nonlinearly, this value is too "
            "high at corner nodes of second-order cells and too low at mid-side nodes, in proportion to the square of the "
            "cell size. The largest value is at a corner node, so the ratio exceeds 1. Loads and approaches are not "
            "affected."
        ),
    )


Step = Callable[[str], None]

SCENE, FOUR = "lin-case1", "lin-case3-offset"

#: Mesh level of the pictures of meshes and stresses, and mesh level of the pictures of contact pressures.
LEVEL, FINE_LEVEL = 1, PRODUCTION

#: Colours of screw, nut, ball, fine patches of the grooves, and fine patches of the ball.
STEEL, NUT, BALL, FINE, FINE_BALL = "#c9ced4", "#a9bccd", "#e4dcc8", "#f0a35e", "#7fb7a2"

#: Distance [m] of the cutting plane from the ball centre, so that no face of a cell lies in the plane.
BESIDE = 0.02e-3


@dataclass(frozen=True)
class PicturedSolution:
    """Solution of one scene by the 3D reference on its coarsest mesh level, from which the report's pictures are drawn."""

    #: Scene that is shown: screw, nut, balls and loads.
    scene: Scene
    #: Set-up of the 3D computation: condensed meshes and dimensions of screw, nut and balls.
    setup: CondensedGeometry
    #: Meshes of screw, nut, balls and contact patches.
    meshes: PartMeshes
    #: Solution of the 3D reference.
    result: ReferenceResult
    #: Contact force at each node of the fine patches of all balls [N], by flank: 0 to 3 for SL, SR, NL, NR (screw or
    #: nut, left or right).
    nodal_contact_forces: dict[int, Array]
    #: Index (from 0) of the ball around which meshes and stresses are drawn.
    ball_index: int


@dataclass(frozen=True)
class StressFields:
    """Stress fields of the 3D reference around one ball, rotated so that the ball lies at azimuth 0."""

    #: Fields in the coarse meshes of screw and nut, in this order.
    screw_and_nut: tuple[SolidField, SolidField]
    #: Field in the coarse mesh of the ball.
    ball_mesh: SolidField
    #: Fields in the fine patches of the grooves, by index of the flank in SL, SR, NL, NR.
    groove_patches: dict[int, SolidField]
    #: Fields in the fine patches of the ball, by index of the flank that each touches.
    ball_patches: dict[int, SolidField]


def solve_scene_for_pictures(cache: SceneResultCache, step: Step) -> PicturedSolution:
    """Solve the scene of the pictures by the 3D reference on the coarsest mesh level, and choose the ball to draw.

    It is the ball with the largest load on flank SL (screw left). Contact is possible on SL and NR (nut right) only.
    ``step`` is called with each line of progress. Raises RuntimeError if the solution does not converge.
    """
    from rollbench.hifi import fields
    from rollbench.hifi.meshing.part_meshes import mesh_parts
    from rollbench.hifi.reference import solve_reference
    from rollbench.hifi.setup import mesh_and_condense_geometry
    from rollbench.meshes.cache import Cache

    scene = cache.built_in_scene(SCENE)
    sides = (0, 3)
    settings = mesh_settings([scene], LEVEL)
    step(f"{SCENE} on mesh level {LEVEL}")
    with TemporaryDirectory() as folder:
        store = Cache(cache.mesh_cache or Path(folder))  # the meshes are needed twice
        setup = mesh_and_condense_geometry(scene, sides, settings, lambda _: None, cache=store)
        meshes = mesh_parts(scene, setup.groove_map, setup.ball_positions, setup.solid_dimensions, sides, settings, store)
    result = solve_reference(setup, scene, sides=sides)
    if not result.contact_solution.converged:
        raise RuntimeError(f"pictures of the 3D reference: {SCENE} on mesh level {LEVEL} was not solved: {result.status}")
    forces, ball_index = fields.contact_node_forces_by_flank(setup, result), int(result.contact_loads[:, 0].argmax())
    return PicturedSolution(scene, setup, meshes, result, forces, ball_index)


def compute_stress_fields(solution: PicturedSolution, step: Step) -> StressFields:
    """Compute the stress fields around one ball: in screw, nut and ball, and in their fine contact patches.

    ``solution``: 3D solution of the scene, which states the number of the ball. ``step`` is called with each line of
    progress.
    """
    from rollbench.hifi import fields

    step("displacements and stresses around the ball")
    setup, meshes, ball, forces = solution.setup, solution.meshes, solution.ball_index, solution.nodal_contact_forces
    scene, reach = solution.scene, 3.2 * setup.groove_map.ball
    u = (
        fields.nodal_displacements_of_screw(setup, meshes.screw_mesh, forces),
        fields.nodal_displacements_of_nut(setup, meshes.nut_mesh, forces),
    )
    of_ball = fields.stress_fields_of_ball(setup, meshes, ball, forces)
    centre = np.array([setup.groove_map.R, 0.0, 0.0])
    return StressFields(
        (
            fields.stress_field_near_ball(setup, meshes.screw_mesh, u[0], ball, scene.screw.material, reach),
            fields.stress_field_near_ball(setup, meshes.nut_mesh, u[1], ball, scene.nut.material, reach),
        ),
        replace(of_ball[None], points=of_ball[None].points + centre),
        {s: fields.stress_field_of_groove_patch(setup, meshes, u[s >= 2], ball, s, forces) for s in setup.loaded_flanks},
        {s: replace(of_ball[s], points=of_ball[s].points + centre) for s in setup.loaded_flanks},
    )


def mesh_part_with_used_nodes(points: Array, cells: Index, kind: str, colour: str) -> content.MeshPart:
    """Return selected cells of a mesh as a `MeshPart` for a picture, without the nodes that these cells do not use.

    Parameters
    ----------
    points
        Nodes of the whole mesh, (m, 3) [m].
    cells
        Node numbers of the cells to draw.
    kind
        Element type of the cells, as in `MeshPart`.
    colour
        Colour of the part.
    """
    nodes, local = np.unique(cells, return_inverse=True)
    return content.MeshPart(points[nodes], local.reshape(cells.shape), kind, colour=colour)


def screw_and_nut_mesh_picture(solution: PicturedSolution) -> content.FieldPicture:
    """Return the picture of the meshes of the screw, of the rear half of the nut, and of the fine patches at all contacts.

    ``solution``: solution of the scene on the coarsest mesh level.
    """
    from rollbench.hifi import fields
    from rollbench.hifi.meshing.part_meshes import element_type_of_bodies, rotation_about_z

    setup, meshes = solution.setup, solution.meshes
    toward = np.array([0.55, -0.83, 0.0])
    nut = meshes.nut_mesh
    behind = nut.points[nut.cells[:, :4]].mean(axis=1) @ toward < 0.0
    kind = element_type_of_bodies(setup.mesh_settings)
    parts = [
        mesh_part_with_used_nodes(meshes.screw_mesh.points, meshes.screw_mesh.cells, kind, STEEL),
        mesh_part_with_used_nodes(nut.points, nut.cells[behind], kind, NUT),
    ]
    patch_of = partial(fields.mesh_contact_patch, setup.groove_map, setup.mesh_settings, meshes)
    for s in setup.loaded_flanks:
        mesh = patch_of(s)
        for phi, z in zip(setup.ball_positions.azimuth, setup.ball_positions.z, strict=True):
            points = mesh.points @ rotation_about_z(float(phi)).T + np.array([0.0, 0.0, z])
            if s < 2 or points.mean(axis=0) @ toward < 0.0:
                parts.append(content.MeshPart(points, mesh.cells, mesh.element_type, colour=FINE))
    scene = solution.scene
    return content.FieldPicture(
        "mesh-screw",
        "Mesh of the 3D reference: screw, nut cut open, and fine patches at all contacts",
        tuple(parts),
        sight=(*(toward[:2] + 0.0), 0.25),
        up=(-toward[1], toward[0], 0.0),
        focus=(0.0, 0.0, scene.nut.position),
        height=2.35 * scene.nut.outer_diameter / 2.0,
        scale_bar=10e-3,
        caption=(
            f"{SCENE}, level {LEVEL}: {len(meshes.screw_mesh.cells)} second-order tetrahedra in the screw and "
            f"{len(nut.cells)} in the nut; orange: a patch of {len(patch_of(0).cells)} "
            "second-order hexahedra at every contact. A single mesh of all bodies, equally fine at the contacts, would "
            f"have {setup.degree_of_freedom_count / 1e6:.2f} million unknowns. Balls are not drawn; the round hollows "
            "along the cut are cross-sections of the nut's groove."
        ),
    )


def _mesh_part(piece: SolidField, colour: str, **look: Any) -> content.MeshPart:
    """Return a part of a picture with the mesh of a field; ``colour``, ``look``: further fields of `MeshPart`."""
    return content.MeshPart(piece.points, piece.cell_nodes, piece.element_type, colour=colour, **look)


def _mesh_parts_around_ball(stresses: StressFields, *, colour_by_stress: bool) -> tuple[content.MeshPart, ...]:
    """Return the meshes of screw, nut, ball and fine patches around one ball, as parts of a picture.

    ``stresses``: these meshes with their stress fields. ``colour_by_stress``: whether the parts are coloured by the von
    Mises stress [MPa]; if not, the edges of their cells are drawn.
    """
    pieces = [
        *zip(stresses.screw_and_nut, (STEEL, NUT), strict=True),
        (stresses.ball_mesh, BALL),
        *((patch, FINE) for patch in stresses.groove_patches.values()),
        *((patch, FINE_BALL) for patch in stresses.ball_patches.values()),
    ]
    look: dict[str, Any] = {"edges": not colour_by_stress, "outline": True}
    return tuple(
        _mesh_part(x, colour, values=MPA * x.von_mises if colour_by_stress else None, **look) for x, colour in pieces
    )


def pictures_around_ball(solution: PicturedSolution, stresses: StressFields) -> tuple[content.FieldPicture, ...]:
    """Return the pictures of meshes and stresses around one ball and its contact with the left flank of the screw's groove.

    These are: meshes of screw (below), ball and nut in the groove's cross-section through the ball's centre; the groove's
    mesh seen from the ball; the ball's mesh with this contact in front; stresses in the cross-section, of the whole ball
    and, enlarged, at this contact. ``solution``: solution of the scene. ``stresses``: meshes and stresses around the ball.
    """
    from rollbench.meshes.ball_body import contact_frame_vectors

    m, settings, ball = solution.setup.groove_map, solution.setup.mesh_settings, f"ball {solution.ball_index + 1}"
    up, along = np.array([1.0, 0.0, 0.0]), np.array([0.0, np.cos(m.alpha), np.sin(m.alpha)])
    centre, normal = m.R * up, contact_frame_vectors(m, 0)[0]
    point = centre + m.ball * normal
    picture = partial(content.FieldPicture, up=up, scale_bar=1e-3)
    section = picture(
        "mesh-section",
        f"Mesh around {ball} in the cross-section of the groove",
        _mesh_parts_around_ball(stresses, colour_by_stress=False),
        sight=along,
        focus=centre,
        height=3.3 * m.ball,
        cuts=((centre + BESIDE * along, along),),
        section=True,
        words=((centre, "ball"), (centre - 1.36 * m.ball * up, "screw"), (centre + 1.40 * m.ball * up, "nut")),
        caption="Lines: faces of cells cut by the plane. Orange: fine patches of the grooves of screw and nut; green: "
        "those of the ball.",
    )
    groove = picture(
        "mesh-contact",
        f"Mesh of the screw's groove at the contact of {ball}",
        (_mesh_part(stresses.screw_and_nut[0], STEEL, line=1.8), _mesh_part(stresses.groove_patches[0], FINE, line=1.5)),
        sight=-normal + 0.25 * along,
        focus=point,
        height=1.6 * m.ball,
        caption="Seen from the ball. Cells are smallest in the middle of the fine patch, where contact may occur: "
        f"{MM * settings.semi[1] / settings.b_over_h:.2f} mm long along the groove.",
    )
    coloured = [(stresses.ball_mesh, BALL), *((patch, FINE_BALL) for patch in stresses.ball_patches.values())]
    whole_ball = picture(
        "mesh-ball",
        "Mesh of a ball with fine patches at its contacts",
        [_mesh_part(x, colour, line=1.5) for x, colour in coloured],
        sight=normal + 0.75 * along,
        focus=centre,
        height=2.2 * m.ball,
        caption=f"{len(stresses.ball_mesh.cell_nodes)} second-order tetrahedra and a patch of "
        f"{len(stresses.ball_patches[0].cell_nodes)} second-order hexahedra at each contact. Every node in the contact "
        "zone lies opposite a node of the groove.",
    )
    stressed = replace(
        section,
        name="stress-section",
        title=f"Von Mises stress around {ball} in the cross-section of the groove",
        parts=_mesh_parts_around_ball(stresses, colour_by_stress=True),
        label="von Mises stress [MPa]",
        limits=(2.0, 2000.0),
        log=True,
        words=(),
        caption="Linear elastic; logarithmic colour scale. Screw and nut carry the contact loads of all balls; the screw "
        f"is fixed at the lower end of its 3D section, the nut at its {solution.setup.solid_dimensions.nut_held}.",
    )
    near = replace(
        stressed,
        name="stress-contact",
        title=f"Von Mises stress at the contact of {ball} with the screw",
        caption=von_mises_caption(solution, stresses),
        limits=(0.0, 1800.0),
        log=False,
        focus=point,
        cuts=((point + BESIDE * along, along),),
        height=0.5 * m.ball,
        scale_bar=0.2e-3,
    )
    return section, groove, whole_ball, stressed, near


def solve_ball_contact_pressures(cache: SceneResultCache, name: str) -> tuple[int, dict[str, ContactPressure]]:
    """Compute the nodal contact pressures of one ball of a scene on a fine 3D mesh.

    The contact loads of the ball are those of the stored 3D reference, or of the default low-order model if no reference is
    stored. The ball is the one with the largest minimum contact load: of the loads on its flanks, the smallest is larger
    than on any other ball. Flanks that carry no load on any ball do not count. ``name``: name of the scene. Returns the
    index of the ball, from 0, and the pressures by name of the contact, such as "ball 5, SL" (SL: left flank of the screw's
    groove).
    """
    from rollbench.hifi import fields

    scene, found = cache.built_in_scene(name), cache.stored_reference(name)
    if found is not None:
        load, angle = found.load, np.radians(found.best.angle)
    else:
        low = cache.solve_once(name, DEFAULT)
        load, angle = low.load, low.contact_angle
    ball = int(load[:, (load > 0.0).any(axis=0)].min(axis=1).argmax())
    pressures = fields.contact_pressures_of_ball(scene, mesh_settings([scene], FINE_LEVEL), ball, load[ball], angle[ball])
    return ball, {f"ball {ball + 1}, {SIDES[s]}": x for s, x in pressures.items()}


def contact_load_picture(solution: PicturedSolution) -> content.LoadedScrew:
    """Return the 3D picture of a loaded screw: balls coloured by their contact loads, contact forces as arrows.

    ``solution``: solution of the scene by the 3D reference.
    """
    scene, result = solution.scene, solution.result
    layout, m = ball_layout(scene), solution.setup.groove_map
    ball = float(draw_geometry_with_errors(scene, layout).ball_radii.max())
    points, forces = [], []
    for s in result.closable_flanks:
        sx, sz = m.signs[s]
        angle, load = result.contact_angles[:, s, None], result.contact_loads[:, s, None]
        direction = sx * np.cos(angle) * layout.radial + sz * np.sin(angle) * layout.binormal
        held = result.contact_loads[:, s] > 0.0
        points.append((layout.centre + ball * direction)[held])
        forces.append((-load * direction)[held])
    return content.LoadedScrew(
        "loaded-screw-3d",
        "Contact loads on the balls of Lin's case 1 by the 3D reference",
        scene,
        result.contact_loads,
        np.concatenate(points),
        np.concatenate(forces),
        f"Mesh level {LEVEL}. Balls are coloured by their contact load, {result.contact_loads[:, 0].min():.0f} to "
        f"{result.contact_loads[:, 0].max():.0f} N.",
    )


def von_mises_caption(solution: PicturedSolution, stresses: StressFields) -> str:
    """Return a caption with the largest von Mises stresses near one ball's contact with the screw, in 3D and by Hertz.

    ``solution``: solution of the scene, which states the number of the ball. ``stresses``: stress fields around this ball.
    """
    from rollbench.hifi import fields

    setup = solution.setup
    side = setup.loaded_flanks[0]
    patch, forces = setup.patches_by_flank[side].groove_patch, solution.nodal_contact_forces[side][solution.ball_index]
    h = fields.pressure_from_nodal_forces(solution.scene, setup.groove_map, side, patch, forces).hertz_solution
    depth = np.linspace(0.2, 1.6, 141) * min(h.semi_x, h.semi_y)
    closed = fields.von_mises_below_hertz_contact(h, depth, solution.scene.balls.material.poissons_ratio)
    top, at = float(closed.max()), float(depth[closed.argmax()])
    return (
        f"Largest nodal values: {MPA * stresses.groove_patches[0].von_mises.max():.0f} MPa in the groove and "
        f"{MPA * stresses.ball_patches[0].von_mises.max():.0f} MPa in the ball. Closed form, half-space under Hertz "
        f"pressure: {MPA * top:.0f} MPa ({top / h.pole_pressure:.3f} of Hertz's peak pressure), {1e6 * at:.0f} µm below "
        "the surface."
    )


def pressure_map_of_ball(name: str, title: str, pressures: dict[str, ContactPressure], caption: str) -> content.PressureMap:
    """Return the figure with pressure contours of all contacts of one ball, and their contact ellipses by Hertz theory.

    ``name``: file name of the figure. ``pressures``: nodal pressures by name of the contact, such as "ball 5, SL" (SL: left
    flank of the screw's groove).
    """
    panels = tuple(contact_pressure_panel(contact, x) for contact, x in pressures.items())
    axes = "across the groove / mm", "along the groove / mm", "pressure / MPa"
    return content.PressureMap(name, title, panels, *axes, "contact ellipse by Hertz", caption=caption)


def make_section(cache: SceneResultCache, step: Step) -> content.Section:
    """Return the section with pictures of the meshes, pressures, stresses and contact loads of the 3D reference.

    ``step`` is called with each line of progress.
    """
    from rollbench.reports.field3d import drawn_picture

    solved = solve_scene_for_pictures(cache, step)
    step(f"pressures of a ball of {SCENE}, mesh level {FINE_LEVEL}")
    ball2, two = solve_ball_contact_pressures(cache, SCENE)
    step(f"pressures of a ball of {FOUR}, mesh level {FINE_LEVEL}")
    ball4, four = solve_ball_contact_pressures(cache, FOUR)
    text = (
        f"Meshes and stresses are shown for the scene {SCENE} on mesh level {LEVEL}, the coarsest of the mesh study, on "
        f"which single cells can be seen; contact pressures are shown on level {FINE_LEVEL}. Sections lie in the plane of "
        "the groove's cross-section, with the radial direction upwards and the screw axis to the right."
    )
    pressure = (
        f"Mesh level {FINE_LEVEL}; dots: nodes. Pressure: nodal force over tributary area. Ellipse: Hertz theory for the "
        "same load. The pressures are from a separate computation of this ball: its contact loads in the 3D reference "
        "press it between patches of both grooves, which are held where they join screw and nut."
    )
    *meshes, stressed, near = pictures_around_ball(solved, compute_stress_fields(solved, step))
    items: tuple[content.Item, ...] = (
        content.Text((text,)),
        screw_and_nut_mesh_picture(solved),
        *meshes,
        pressure_map_of_ball(
            "pressure-two", f"Contact pressure on both contacts of ball {ball2 + 1} of {SCENE}", two, pressure
        ),
        pressure_profiles_figure(two),
        pressure_map_of_ball(
            "pressure-four",
            f"Contact pressure on all four flanks of ball {ball4 + 1} of {FOUR}",
            four,
            f"Mesh level {FINE_LEVEL}. Pressure: nodal force over tributary area. Ellipse: Hertz theory, same load.",
        ),
        largest_pressure_table({SCENE: two, FOUR: four}),
        stressed,
        near,
        contact_load_picture(solved),
    )
    drawn = [drawn_picture(item) if isinstance(item, content.FieldPicture) else item for item in items]
    return content.Section("pictures", "Meshes, contact pressures and stresses of the 3D reference", drawn)
