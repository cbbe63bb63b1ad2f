"""Report section with pictures of the 3D reference: meshes, contact pressures, stresses around a ball, contact loads.

Pressures are shown as maps, as curves along lines of nodes, and in a table, next to those by Hertz theory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.reference.levels import PRODUCTION
from rollbench.compare.reference.tasks import mesh_settings
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.errors import draw_specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import (
    FieldPicture,
    Figure,
    LoadedScrew,
    MeshPart,
    Panel,
    PressureMap,
    PressurePanel,
    Quantity,
    Row,
    Section,
    Series,
    Table,
    Text,
)

if TYPE_CHECKING:
    from rollbench.hifi.fields import ContactPressure, SolidField
    from rollbench.hifi.meshing.part_meshes import Meshes
    from rollbench.hifi.reference import ReferenceResult
    from rollbench.hifi.setup import Setup


#: Factors from metres to millimetres, and from pascals to megapascals.
MM, MPA = 1e3, 1e-6


def pressure_panel(name: str, found: ContactPressure) -> PressurePanel:
    """Return the contour plot of the nodal pressures of one contact, with its contact ellipse by Hertz theory.

    ``name``: title of the map, such as "ball 5, SL". ``found``: pressures at the nodes of the contact, with Hertz's
    solution.
    """
    h = found.hertz
    return PressurePanel(
        name,
        MM * found.across,
        MM * found.along,
        MPA * found.pressure,
        (MM * found.centre[0], MM * found.centre[1], MM * h.semi_x, MM * h.semi_y),
        f"{found.load:.1f} N; largest {MPA * found.pressure.max():.0f} MPa, pole pressure by Hertz "
        f"{MPA * h.pole_pressure:.0f} MPa",
    )


def pressure_profiles_figure(found: dict[str, ContactPressure]) -> Figure:
    """Draw the pressure of each contact across and along the groove, by the 3D reference and by Hertz theory.

    The curves follow the two lines of nodes through the node with the largest pressure. ``found``: pressures at the nodes
    of each contact, by the contact's name.
    """
    panels = []
    for name, one in found.items():
        assert one.shape is not None
        grid = np.arange(one.pressure.size).reshape(one.shape)
        i, k = np.unravel_index(int(one.pressure.argmax()), one.shape)
        for title, line, distance, axis in (
            ("across the groove", grid[:, k], one.across, 0),
            ("along the groove", grid[i], one.along, 1),
        ):
            at = np.linspace(distance[line].min(), distance[line].max(), 161)
            other = (one.along if axis == 0 else one.across)[line].mean() - one.centre[1 - axis]
            across, along = (at - one.centre[0], other + 0.0 * at) if axis == 0 else (other + 0.0 * at, at - one.centre[1])
            panels.append(
                Panel(
                    f"{name}, {title}",
                    "distance from the nominal contact / mm",
                    "pressure / MPa",
                    (
                        Series("3D reference, nodes", list(MM * distance[line]), list(MPA * one.pressure[line]), "markers"),
                        Series("Hertz", list(MM * at), list(MPA * one.hertz.pressure(across, along)), "line"),
                    ),
                    zero=True,
                )
            )
    return Figure(
        "pressure-profiles",
        "Contact pressure of one ball across and along the groove, by the 3D reference and by Hertz theory",
        tuple(panels),
        "Dots: the lines of nodes through the largest pressure. Curves: Hertz theory for the same load, centred on the "
        "resultant force.",
    )


def node_spacing_along_groove(found: ContactPressure) -> float:
    """Return the mean distance [m] of neighbouring nodes in the groove direction, in the fine mesh patch of one contact.

    ``found``: pressures of the contact, with the positions of its nodes.
    """
    assert found.shape is not None
    return float(np.abs(np.diff(found.along.reshape(found.shape), axis=1)).mean())


def pressure_table(groups: dict[str, dict[str, ContactPressure]]) -> Table:
    """Return the table of the largest pressure of each contact, by the 3D reference and by Hertz theory.

    ``groups``: nodal pressures by name of the scene, then by name of the contact.
    """
    rows: list[Row] = [
        {
            Quantity("contact", "Contact", format="s"): f"{scene}, {name}",
            Quantity("load", "Load", "N", ".1f"): x.load,
            Quantity("ours", "Largest pressure, 3D", "MPa", ".0f"): MPA * float(x.pressure.max()),
            Quantity("hertz", "Pole pressure, Hertz", "MPa", ".0f"): MPA * x.hertz.pole_pressure,
            Quantity("ratio", "3D / Hertz", "", ".3f"): float(x.pressure.max() / x.hertz.pole_pressure),
            Quantity("a", "Semi-axis a across the groove", "mm", ".3f"): MM * x.hertz.semi_x,
            Quantity("b", "Semi-axis b along the groove", "mm", ".3f"): MM * x.hertz.semi_y,
            Quantity("cells", "Node spacings in the width 2b", "", ".1f"): 2.0
            * x.hertz.semi_y
            / node_spacing_along_groove(x),
        }
        for scene, found in groups.items()
        for name, x in found.items()
    ]
    return Table.of(
        "pictures-pressure",
        "Largest nodal pressure of each contact by the 3D reference, and pole pressure by Hertz theory",
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

#: Mesh levels of the pictures of meshes and stresses, and of contact pressures.
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
    setup: Setup
    #: Meshes of screw, nut, balls and contact patches.
    meshes: Meshes
    #: Solution of the 3D reference.
    result: ReferenceResult
    #: Nodal forces in the contacts of all balls [N], by index of the flank in SL, SR, NL, NR.
    forces: dict[int, Array]
    #: Index (from 0) of the ball around which meshes and stresses are drawn.
    ball: int


@dataclass(frozen=True)
class StressFields:
    """Stress fields of the 3D reference around one ball, rotated so that the ball lies at azimuth 0."""

    #: Fields in the coarse meshes of screw and nut, in this order.
    bodies: tuple[SolidField, SolidField]
    #: Field in the coarse mesh of the ball.
    ball: SolidField
    #: Fields in the fine patches of the grooves, by index of the flank in SL, SR, NL, NR.
    grooves: dict[int, SolidField]
    #: Fields in the fine patches of the ball, by index of the flank that each touches.
    patches: dict[int, SolidField]


def solve_pictured_scene(study: Study, step: Step) -> PicturedSolution:
    """Solve the scene of the pictures by the 3D reference on the coarsest mesh level, and choose its most loaded ball.

    Two flanks are meshed, SL and NR. ``step`` is called with each line of progress. Raises RuntimeError if the solution
    does not converge.
    """
    from rollbench.hifi.fields import pressure_function_forces_by_flank
    from rollbench.hifi.meshing.part_meshes import mesh_parts
    from rollbench.hifi.reference import solve_reference
    from rollbench.hifi.setup import prepare
    from rollbench.meshes.cache import Cache

    scene = study.scene(SCENE)
    sides = (0, 3)
    settings = mesh_settings([scene], LEVEL)
    step(f"{SCENE} on mesh level {LEVEL}")
    with TemporaryDirectory() as folder:
        store = Cache(study.cache or Path(folder))  # the meshes are needed twice
        setup = prepare(scene, sides, settings, lambda _: None, cache=store)
        meshes = mesh_parts(scene, setup.map, setup.layout, setup.dims, sides, settings, store)
    result = solve_reference(setup, scene, sides=sides)
    if not result.contact.converged:
        raise RuntimeError(f"pictures of the 3D reference: {SCENE} on mesh level {LEVEL} was not solved: {result.status}")
    return PicturedSolution(
        scene, setup, meshes, result, pressure_function_forces_by_flank(setup, result), int(result.load[:, 0].argmax())
    )


def compute_stresses(solved: PicturedSolution, step: Step) -> StressFields:
    """Compute the stress fields around the pictured ball: in screw, nut and ball, and in their fine contact patches.

    ``solved``: solution of the scene under its loads. ``step`` is called with each line of progress.
    """
    from rollbench.hifi.fields import (
        groove_patch_field,
        nut_displacement,
        screw_displacement,
        stress_field_near_ball,
        stress_fields_of_ball,
    )

    step("displacements and stresses around the ball")
    setup, meshes, ball, forces = solved.setup, solved.meshes, solved.ball, solved.forces
    scene, reach = solved.scene, 3.2 * setup.map.ball
    u = screw_displacement(setup, meshes.screw, forces), nut_displacement(setup, meshes.nut, forces)
    of_ball = stress_fields_of_ball(setup, meshes, ball, forces)
    centre = np.array([setup.map.R, 0.0, 0.0])
    return StressFields(
        (
            stress_field_near_ball(setup, meshes.screw, u[0], ball, scene.screw.material, reach),
            stress_field_near_ball(setup, meshes.nut, u[1], ball, scene.nut.material, reach),
        ),
        replace(of_ball[None], points=of_ball[None].points + centre),
        {s: groove_patch_field(setup, meshes, u[s >= 2], ball, s, forces) for s in setup.sides},
        {s: replace(of_ball[s], points=of_ball[s].points + centre) for s in setup.sides},
    )


def groove_unit_vectors(solved: PicturedSolution) -> tuple[Array, Array, Array]:
    """Return three unit vectors of the groove at azimuth 0: radial, along the groove, and normal to both, each (3,).

    The screw's axis is z. The first and third vector span the groove's cross-section, which is inclined by the lead angle.
    """
    alpha = solved.setup.map.alpha
    return (
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, np.cos(alpha), np.sin(alpha)]),
        np.array([0.0, -np.sin(alpha), np.cos(alpha)]),
    )


def contact_point(solved: PicturedSolution, side: int) -> Array:
    """Return the nominal contact point (3,) [m] between a ball at azimuth 0 and one flank, in the screw's frame.

    ``side``: index of the flank in SL, SR, NL, NR.
    """
    from rollbench.meshes.ball_body import contact_frame_vectors

    m = solved.setup.map
    return np.asarray(np.array([m.R, 0.0, 0.0]) + m.ball * contact_frame_vectors(m, side)[0])


def keep_used_nodes(points: Array, cells: Index, kind: str, colour: str) -> MeshPart:
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
    return MeshPart(points[nodes], local.reshape(cells.shape), kind, colour=colour)


def mesh_overview(solved: PicturedSolution) -> FieldPicture:
    """Return the picture of the meshes of the screw, of the rear half of the nut, and of the fine patches at all contacts.

    ``solved``: solution of the scene on the coarsest mesh level.
    """
    from rollbench.hifi.fields import mesh_groove_patch
    from rollbench.hifi.meshing.part_meshes import element_order_of_bodies, rotation_about_z

    setup, meshes = solved.setup, solved.meshes
    toward = np.array([0.55, -0.83, 0.0])
    nut = meshes.nut
    behind = nut.points[nut.cells[:, :4]].mean(axis=1) @ toward < 0.0
    kind = element_order_of_bodies(setup.settings)
    parts = [
        keep_used_nodes(meshes.screw.points, meshes.screw.cells, kind, STEEL),
        keep_used_nodes(nut.points, nut.cells[behind], kind, NUT),
    ]
    for s in setup.sides:
        mesh = mesh_groove_patch(setup, meshes, s)
        for phi, z in zip(setup.layout.azimuth, setup.layout.z, strict=True):
            points = mesh.points @ rotation_about_z(float(phi)).T + np.array([0.0, 0.0, z])
            if s < 2 or points.mean(axis=0) @ toward < 0.0:
                parts.append(MeshPart(points, mesh.cells, mesh.kind, colour=FINE))
    scene = solved.scene
    return FieldPicture(
        "mesh-screw",
        "Mesh of the 3D reference: screw, nut cut open, and fine patches at all contacts",
        tuple(parts),
        sight=(*(toward[:2] + 0.0), 0.25),
        up=(-toward[1], toward[0], 0.0),
        focus=(0.0, 0.0, scene.nut.position),
        height=2.35 * scene.nut.outer_diameter / 2.0,
        scale_bar=10e-3,
        caption=(
            f"{SCENE}, level {LEVEL}: {len(meshes.screw.cells)} and {len(nut.cells)} second-order tetrahedra in screw and "
            f"nut; orange: a patch of {len(mesh_groove_patch(setup, meshes, 0).cells)} second-order hexahedra at every "
            f"contact. As one mesh: {setup.unknowns / 1e6:.2f} million unknowns. Balls are not drawn; the round hollows "
            "along the cut are cross-sections of the nut's groove."
        ),
    )


def _mesh_parts_around_ball(found: StressFields, *, values: bool) -> tuple[MeshPart, ...]:
    """Return the meshes of screw, nut, ball and fine patches around the pictured ball, as parts of a picture.

    ``found``: these meshes with their stress fields. ``values``: whether the parts are coloured by the von Mises stress
    [MPa]; if not, the edges of their cells are drawn.
    """

    def coloured(piece: SolidField, colour: str) -> MeshPart:
        stress = MPA * piece.von_mises if values else None
        return MeshPart(piece.points, piece.cells, piece.kind, stress, colour, edges=not values, outline=True)

    return (
        coloured(found.bodies[0], STEEL),
        coloured(found.bodies[1], NUT),
        coloured(found.ball, BALL),
        *(coloured(x, FINE) for x in found.grooves.values()),
        *(coloured(x, FINE_BALL) for x in found.patches.values()),
    )


def groove_section_picture(
    solved: PicturedSolution,
    found: StressFields,
    name: str,
    title: str,
    caption: str,
    *,
    height: float,
    side: int | None = None,
) -> FieldPicture:
    """Return the picture of the meshes of screw, ball and nut in the groove's cross-section through the ball's centre.

    The screw is below, the nut above. ``solved``: solution of the scene. ``found``: meshes and stresses around the ball.
    ``name``: file name of the picture. ``height``: height of the shown region [m]. ``side``: index in SL, SR, NL, NR of the
    flank whose contact alone is shown, enlarged; None: the whole ball is shown.
    """
    x3, y3, _ = groove_unit_vectors(solved)
    m = solved.setup.map
    centre = np.array([m.R, 0.0, 0.0])
    focus = centre if side is None else contact_point(solved, side)
    places = (centre, "ball"), (centre - 1.36 * m.ball * x3, "screw"), (centre + 1.40 * m.ball * x3, "nut")
    return FieldPicture(
        name,
        title,
        _mesh_parts_around_ball(found, values=False),
        sight=tuple(y3),
        up=tuple(x3),
        focus=tuple(focus),
        height=height,
        cuts=((tuple(focus + BESIDE * y3), tuple(y3)),),
        section=True,
        words=[(tuple(place), word) for place, word in places] if side is None else (),
        scale_bar=1e-3,
        caption=caption,
    )


def contact_picture(solved: PicturedSolution, found: StressFields) -> FieldPicture:
    """Return the picture of the mesh of the screw's groove around the ball's contact on flank SL, seen from the ball.

    ``solved``: solution of the scene. ``found``: meshes and stresses around the ball.
    """
    x3, y3, _ = groove_unit_vectors(solved)
    point, b = contact_point(solved, 0), solved.setup.map.ball
    normal = point - np.array([solved.setup.map.R, 0.0, 0.0])
    body, patch = found.bodies[0], found.grooves[0]
    parts = (
        MeshPart(body.points, body.cells, body.kind, colour=STEEL, line=1.8),
        MeshPart(patch.points, patch.cells, patch.kind, colour=FINE, line=1.5),
    )
    return FieldPicture(
        "mesh-contact",
        f"Mesh of the screw's groove at the contact of ball {solved.ball + 1}",
        parts,
        sight=tuple(-normal / b + 0.25 * y3),
        up=tuple(x3),
        focus=tuple(point),
        height=1.6 * b,
        scale_bar=1e-3,
        caption="Seen from the ball. Cells are smallest in the middle of the fine patch, where contact may occur: "
        f"{MM * solved.setup.settings.semi[1] / solved.setup.settings.b_over_h:.2f} mm "
        "long along the groove.",
    )


def ball_picture(solved: PicturedSolution, found: StressFields) -> FieldPicture:
    """Return the picture of the mesh of a ball with a fine patch at each contact; the screw's contact faces the viewer.

    ``solved``: solution of the scene. ``found``: meshes and stresses around the ball.
    """
    x3, y3, _ = groove_unit_vectors(solved)
    m = solved.setup.map
    centre = np.array([m.R, 0.0, 0.0])
    whole = [found.ball, *found.patches.values()]
    colours = [BALL, *[FINE_BALL] * len(found.patches)]
    parts = tuple(MeshPart(x.points, x.cells, x.kind, colour=c, line=1.5) for x, c in zip(whole, colours, strict=True))
    sight = (contact_point(solved, 0) - centre) / m.ball + 0.75 * y3
    return FieldPicture(
        "mesh-ball",
        "Mesh of a ball with fine patches at its contacts",
        parts,
        sight=tuple(sight),
        up=tuple(x3),
        focus=tuple(centre),
        height=2.2 * m.ball,
        scale_bar=1e-3,
        caption=(
            f"{len(found.ball.cells)} second-order tetrahedra and a patch of {len(found.patches[0].cells)} second-order "
            "hexahedra at each contact. Every node in the contact zone lies opposite a node of the groove."
        ),
    )


def solve_contact_pressures(study: Study, name: str) -> tuple[int, dict[str, ContactPressure]]:
    """Compute the nodal contact pressures of one ball of a scene on a fine 3D mesh.

    The ball carries its contact loads from the stored 3D reference, or from the default model if no reference is stored. It
    is the ball whose least loaded contact has the largest load. ``name``: name of the scene. Returns the index of the ball,
    from 0, and the pressures by name of the contact, such as "ball 5, SL".
    """
    from rollbench.hifi.fields import ball_contact_pressures

    scene, found = study.scene(name), study.reference(name)
    if found is not None:
        load, angle = found.load, np.radians(found.best.angle)
    else:
        low = study.solve(name, DEFAULT)
        load, angle = low.load, low.contact_angle
    ball = int(load[:, (load > 0.0).any(axis=0)].min(axis=1).argmax())
    pressures = ball_contact_pressures(scene, mesh_settings([scene], FINE_LEVEL), ball, load[ball], angle[ball])
    return ball, {f"ball {ball + 1}, {SIDES[s]}": x for s, x in pressures.items()}


def loaded_balls_picture(solved: PicturedSolution) -> LoadedScrew:
    """Return the 3D picture of a loaded screw: balls coloured by their contact loads, contact forces as arrows.

    ``solved``: solution of the scene by the 3D reference.
    """
    scene, result = solved.scene, solved.result
    layout, m = ball_layout(scene), solved.setup.map
    ball = float(draw_specimen(scene, layout).ball_radius.max())
    points, forces = [], []
    for s in result.sides:
        sx, sz = m.signs[s]
        angle, load = result.contact_angle[:, s, None], result.load[:, s, None]
        direction = sx * np.cos(angle) * layout.radial + sz * np.sin(angle) * layout.binormal
        held = result.load[:, s] > 0.0
        points.append((layout.centre + ball * direction)[held])
        forces.append((-load * direction)[held])
    return LoadedScrew(
        "loaded-screw-3d",
        "Contact loads on the balls of Lin's case 1 by the 3D reference",
        scene,
        result.load,
        np.concatenate(points),
        np.concatenate(forces),
        f"Mesh level {LEVEL}. Balls are coloured by their contact load, {result.load[:, 0].min():.0f} to "
        f"{result.load[:, 0].max():.0f} N.",
    )


def von_mises_caption(solved: PicturedSolution, found: StressFields) -> str:
    """Return a caption with the largest von Mises stresses near the ball's contact with the screw, in 3D and by Hertz.

    ``solved``: solution of the scene. ``found``: stress fields around the ball.
    """
    from rollbench.hifi.fields import contact_pressure, hertz_von_mises

    setup = solved.setup
    side = setup.sides[0]
    h = contact_pressure(solved.scene, setup.map, side, setup.patches[side].groove, solved.forces[side][solved.ball]).hertz
    depth = np.linspace(0.2, 1.6, 141) * min(h.semi_x, h.semi_y)
    closed = hertz_von_mises(h, depth, solved.scene.balls.material.poissons_ratio)
    top, at = float(closed.max()), float(depth[closed.argmax()])
    return (
        f"Largest nodal values: {MPA * found.grooves[0].von_mises.max():.0f} MPa in the groove and "
        f"{MPA * found.patches[0].von_mises.max():.0f} MPa in the ball. Closed form, half-space under Hertz pressure: "
        f"{MPA * top:.0f} MPa ({top / h.pole_pressure:.3f} of the pole pressure), {1e6 * at:.0f} µm below the surface."
    )


def pressure_map(name: str, title: str, found: dict[str, ContactPressure], caption: str) -> PressureMap:
    """Return the figure with pressure contours of all contacts of one ball, and their contact ellipses by Hertz theory.

    ``name``: file name of the figure. ``found``: nodal pressures by name of the contact, such as "ball 5, SL".
    """
    panels = tuple(pressure_panel(contact, x) for contact, x in found.items())
    axes = "across the groove / mm", "along the groove / mm", "pressure / MPa"
    return PressureMap(name, title, panels, *axes, "contact ellipse by Hertz", caption=caption)


def make_section(study: Study, step: Step) -> Section:
    """Return the section with pictures of the meshes, pressures, stresses and contact loads of the 3D reference.

    ``step`` is called with each line of progress.
    """
    solved = solve_pictured_scene(study, step)
    found = compute_stresses(solved, step)
    ball, b = f"ball {solved.ball + 1}", solved.setup.map.ball
    step(f"pressures of a ball of {SCENE}, mesh level {FINE_LEVEL}")
    ball2, two = solve_contact_pressures(study, SCENE)
    step(f"pressures of a ball of {FOUR}, mesh level {FINE_LEVEL}")
    ball4, four = solve_contact_pressures(study, FOUR)
    text = (
        f"Meshes and stresses are shown for the scene {SCENE} on mesh level {LEVEL}, the coarsest of the mesh study, on "
        f"which single cells can be seen; contact pressures are shown on level {FINE_LEVEL}. Sections lie in the plane of "
        "the groove's cross-section, with the radial direction upwards and the screw axis to the right."
    )
    mesh = (
        "Lines: faces of cells cut by the plane. Orange: fine patches of the grooves of screw and nut; green: those of the "
        "ball."
    )
    pressure = (
        f"Mesh level {FINE_LEVEL}; dots: nodes. Pressure: nodal force over tributary area. Ellipse: Hertz theory for the "
        "same load. The ball is pressed with its contact loads in the 3D reference between groove patches that are held "
        "where they join screw and nut."
    )
    stress = (
        "Linear elastic; logarithmic colour scale. Screw and nut carry the contact loads of all balls; the screw is fixed "
        f"at the lower end of its 3D section, the nut at its {solved.setup.dims.nut_held}."
    )
    title = f"Mesh around {ball} in the cross-section of the groove"
    whole = groove_section_picture(solved, found, "mesh-section", title, mesh, height=3.3 * b)
    stressed = _mesh_parts_around_ball(found, values=True)
    shown = replace(whole, parts=stressed, label="von Mises stress [MPa]", words=())
    title = f"Von Mises stress around {ball} in the cross-section of the groove"
    around = replace(shown, name="stress-section", title=title, caption=stress, limits=(2.0, 2000.0), log=True)
    title = f"Von Mises stress at the contact of {ball} with the screw"
    near = groove_section_picture(
        solved, found, "stress-contact", title, von_mises_caption(solved, found), side=0, height=0.5 * b
    )
    near = replace(near, parts=stressed, label=shown.label, limits=(0.0, 1800.0), scale_bar=0.2e-3)
    return Section(
        "pictures",
        "Meshes, contact pressures and stresses of the 3D reference",
        (
            Text((text,)),
            mesh_overview(solved),
            whole,
            contact_picture(solved, found),
            ball_picture(solved, found),
            pressure_map(
                "pressure-two", f"Contact pressure on both contacts of ball {ball2 + 1} of {SCENE}", two, pressure
            ),
            pressure_profiles_figure(two),
            pressure_map(
                "pressure-four",
                f"Contact pressure on all four flanks of ball {ball4 + 1} of {FOUR}",
                four,
                f"Mesh level {FINE_LEVEL}. Pressure: nodal force over tributary area. Ellipse: Hertz theory, same load.",
            ),
            pressure_table({SCENE: two, FOUR: four}),
            around,
            near,
            loaded_balls_picture(solved),
        ),
    )
