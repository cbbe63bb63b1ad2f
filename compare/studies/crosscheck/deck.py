"""Contact problem of a small scene as an input deck for the finite-element program CalculiX.

The deck has the bodies, contacts, supports and loads. For each contact it is estimated where it lies and how large it is,
so that meshes are refined there and the faces of balls and grooves that may touch are known.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import InputError
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import estimate_model_error
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.tasks import flanks_to_mesh
from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import contact_frame_vectors, normal_between_hemispheres
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.exchange import whole_bodies
from rollbench.meshes.exchange.deck import DeckBody, InputDeck, RigidSection, outer_faces_of_tetrahedra
from rollbench.meshes.exchange.whole_bodies import ElementSizesNearPoints, ExportedBodyMesh
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import BallLayout, ball_layout, lead_angle, nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene
from rollbench.meshes.sockets import RefinementBoxSize, local_coordinates_in_refinement_box
from rollbench.meshes.solid import Dimensions, dimensions_of_3d_parts

#: How semi-axes of three zones follow from those of the expected contact ellipse. Zone of small elements: a factor. Zones
#: of contact faces on the slave (ball), then on the master (groove): a factor, and a number of element sizes that are
#: added.
FINE, SLAVE, MASTER = 1.1, (1.6, 2.0), (2.0, 4.0)

#: Smallest load with which the size of a contact is estimated, as a fraction of the mean load.
LEAST = 0.1


@dataclass(frozen=True)
class ExpectedContact:
    """Expected position and size of the contact between a ball and one flank of a groove, where meshes are refined."""

    #: Number of the ball, from 0.
    ball: int
    #: Number of the flank, 0 to 3 for SL, SR, NL, NR (screw left and right, nut left and right).
    side: int
    #: Azimuth [rad] and axial position [m] of the ball's centre, and the number of the flank.
    ball_position_and_flank: tuple[float, float, int]
    #: Semi-axes of the contact ellipse across and along the groove [m].
    semi_axes: tuple[float, float]


def unit_load_semi_axes(scene: Scene, side: int) -> tuple[float, float]:
    """Return the semi-axes of a contact ellipse under a load of 1 N, across and along the groove [m/N^(1/3)].

    The semi-axes follow from Hertz's theory for the nominal geometry. The longer semi-axis lies across the groove,
    where ball and groove conform. ``side``: number of the flank, 0 to 3 for SL, SR, NL, NR (screw left and right, nut
    left and right).
    """
    track, balls = scene.track, scene.balls
    part = scene.screw if side < 2 else scene.nut
    sign = 1.0 if side < 2 else -1.0
    along = np.cos(track.contact_angle) * np.cos(lead_angle(track)) ** 2
    along /= track.pitch_radius - sign * balls.radius * np.cos(track.contact_angle)
    one, two = balls.material, part.material
    modulus = contact_modulus(one.youngs_modulus, one.poissons_ratio, two.youngs_modulus, two.poissons_ratio)
    across = 1.0 / balls.radius - 1.0 / part.groove_radius
    found = hertz_constants(np.array(across), np.array(1.0 / balls.radius + sign * along), modulus)
    return float(found.C_a), float(found.C_b)


def expected_contacts(scene: Scene, load: Array, sides: tuple[int, ...]) -> tuple[list[ExpectedContact], float]:
    """Return the expected contacts of balls and grooves, then the minor semi-axis [m] of a contact at mean contact load.

    ``load``: contact loads (N, 4) [N] of a low-order solution for N balls and the flanks SL, SR, NL, NR (screw left and
    right, nut left and right); ``sides``: numbers, 0 to 3 in this order, of the flanks that may carry load. The semi-axis
    is computed for the first of these flanks.
    """
    layout, mean = ball_layout(scene), float(load[load > 0.0].mean())
    unit = {s: unit_load_semi_axes(scene, s) for s in sides}
    places = []
    for i in range(scene.ball_count):
        for s in sides:
            root = float(np.cbrt(max(load[i, s], LEAST * mean)))
            at = (float(layout.azimuth[i]), float(layout.z[i]), s)
            places.append(ExpectedContact(i, s, at, (unit[s][0] * root, unit[s][1] * root)))
    return places, unit[sides[0]][1] * float(np.cbrt(mean))


def ball_contact_face_set_name(contact: ExpectedContact) -> str:
    """Return the name, in a CalculiX deck, of the mesh faces of a ball that may touch the groove at ``contact``."""
    return f"BALL{contact.ball + 1}_{SIDES[contact.side]}"


def groove_contact_face_set_name(contact: ExpectedContact) -> str:
    """Return the name, in a CalculiX deck, of the mesh faces of a groove that the ball may touch at ``contact``."""
    return f"{'SCREW' if contact.side < 2 else 'NUT'}_{SIDES[contact.side]}_{contact.ball + 1}"


def refined_zone_points(contact: ExpectedContact, element_size: float) -> Array:
    """Return points (k, 2) [m] that fill the zone of small elements at a contact, across and along the groove.

    ``contact``: expected contact; ``element_size``: element size in the zone [m]; k: number of points.
    """
    across, along = contact.semi_axes
    return whole_bodies.grid_points_in_ellipse((FINE * across, FINE * along), 0.7 * element_size)


def flank_contact_faces(groove: GrooveMap, mesh: ExportedBodyMesh, contact: ExpectedContact, element_size: float) -> Index:
    """Return the mesh faces of a groove's flank that may touch the ball (master faces), each by its node numbers.

    ``groove``: geometry of the groove; ``mesh``: mesh of screw or nut; ``contact``: expected contact; ``element_size``:
    element size there [m].
    """
    flank = mesh.nodes_of_boundaries[f"flank {SIDES[contact.side]}"]
    x, radius = mesh.points[flank], float(groove.radius[contact.side])
    at = np.arctan2(x[:, 1], x[:, 0]), x[:, 2], np.hypot(x[:, 0], x[:, 1])
    unit = RefinementBoxSize(1.0, radius, 1.0)
    xi = local_coordinates_in_refinement_box(groove, unit, contact.ball_position_and_flank, *at)
    half = MASTER[0] * np.array(contact.semi_axes) + MASTER[1] * element_size
    inside = (radius * xi[:, 0] / half[0]) ** 2 + (groove.R * xi[:, 2] / half[1]) ** 2 <= 1.0
    return _outer_faces_with_corners(mesh, flank[inside])


def ball_contact_faces(
    groove: GrooveMap, mesh: ExportedBodyMesh, contact: ExpectedContact, radius: float, element_size: float
) -> Index:
    """Return the mesh faces of a ball that may touch the groove (slave faces), each by its node numbers.

    ``groove``: geometry of the groove; ``mesh``: mesh of the ball with its centre in the origin, turned to azimuth
    zero; ``contact``: expected contact; ``radius``: radius of the ball [m]; ``element_size``: element size at the
    contact [m].
    """
    n, t1, t2 = contact_frame_vectors(groove, contact.side)
    half = SLAVE[0] * np.array(contact.semi_axes) + SLAVE[1] * element_size
    sphere = mesh.nodes_of_boundaries["sphere"]
    x = mesh.points[sphere]
    height = np.where(x @ n > 0.0, x @ n, 1e-9 * radius)  # nodes behind are far outside
    across, along = radius * (x @ t1) / height, radius * (x @ t2) / height
    inside = (x @ n > 0.0) & ((across / half[0]) ** 2 + (along / half[1]) ** 2 <= 1.0)
    return _outer_faces_with_corners(mesh, sphere[inside])


def _outer_faces_with_corners(mesh: ExportedBodyMesh, nodes: Index) -> Index:
    """Return the outer mesh faces whose corner nodes all belong to ``nodes``, each face by its node numbers.

    Faces in the cut plane of a half body are left out. ``nodes``: node numbers. Raises ValueError if no face remains.
    """
    faces = outer_faces_of_tetrahedra(mesh.cells)
    in_cut = np.isin(faces, mesh.nodes_of_boundaries.get("cut", np.zeros(0, dtype=np.int64)))
    within = faces[np.isin(faces, nodes).all(axis=1) & ~in_cut.all(axis=1)]
    if not len(within):
        raise ValueError(
            "no face of the mesh lies within an expected contact, because the elements are too large: raise `b_over_h` "
            "(elements along the minor semi-axis of the contact ellipse), or lower `growth` (increase of the element size "
            "per unit of distance from the contacts)"
        )
    return within


#: Largest numbers of balls and nodes of a deck, so that a direct solver takes minutes.
MOST_BALLS = 4

MOST_NODES = 120_000

#: Fixed surfaces of the nut by the scene's name of its mounting.
HELD = {
    "left face": ("low end",),
    "right face": ("high end",),
    "both faces": ("low end", "high end"),
    "outer surface": ("outside",),
    "flange face": ("seat",),
    "flange face and centring": ("seat", "centring"),
}

#: Element sizes far from all contacts, over growth times ball radius: of screw and nut, and of a ball.
FAR_SIZES = (2.0, 0.6)


@dataclass(frozen=True)
class DeckOptions:
    """Mesh sizes and contact options of an input deck for CalculiX."""

    #: Number of elements along the minor semi-axis of the contact ellipse at the mean contact load; all contacts have the
    #: same element size.
    b_over_h: float = 1.5
    #: Increase of the element size per unit of distance from the contacts.
    growth: float = 0.4
    #: Contact stiffness: pressure per overclosure (overlap of the surfaces) [Pa/m].
    stiffness: float = 2e17
    #: Stiffness of the weak springs that prevent rigid-body motions of the balls and of the screw where no support does
    #: [N/m].
    spring: float = 1e3
    #: Whether large displacements are taken into account (geometric nonlinearity).
    nlgeom: bool = False
    #: Whether only the half y >= 0 of a pair of rings is meshed, y = 0 being a plane of symmetry.
    half: bool = False
    #: Whether all balls of one radius have identical meshes, so that the contact loads do not scatter from ball to ball
    #: because of different meshes; half balls always have identical meshes.
    alike: bool = False


@dataclass(frozen=True)
class MeshedDeck:
    """Input deck for CalculiX, with the expected contact loads and the quality of its meshes."""

    #: Input deck: nodes, elements, contacts, supports and loads.
    deck: InputDeck
    #: Contact loads by the low-order model "refined", (n, 4) [N], for n balls and the four flanks (screw left, screw right,
    #: nut left, nut right).
    expected_loads: Array
    #: Element size at the contacts [m].
    contact_element_size: float
    #: Smallest scaled Jacobian of the elements of each body, by name of the body.
    smallest_jacobians: dict[str, float]


def raise_first_fault(where: str, faults: Iterable[tuple[bool, str, str, str, str]]) -> None:
    """Raise InputError for the first of several possible faults that a scene has; do nothing if it has none of them.

    ``where``: name of the scene or file in the error message; ``faults``: for each possible fault, whether the scene has
    it, the key of the scene file, the refused value, the allowed values, and advice.
    """
    for there, key, value, allowed, advice in faults:
        if there:
            raise InputError(where, key, value, allowed, advice)


def _refuse_unsupported_scene(scene: Scene, half: bool) -> None:
    """Raise InputError if a CalculiX deck cannot describe a scene, or if the scene has too many balls to be meshed.

    ``half``: whether only the half y >= 0 is meshed. Then a scene is also refused if y = 0 is not a plane of symmetry: if
    the scene has a helix, balls outside this plane, loads, or a screw that can move along y or turn about x or z.
    """
    balls, solid = scene.ball_count, scene.solid
    large = f"1 to {MOST_BALLS} balls, because a deck has the whole meshes of all bodies"
    cut = "cut the screw to a few neighbouring balls: `balls=3:5` keeps balls 3 to 5"
    half_face = solid.nut_held is not None and solid.nut_held not in HELD
    bolts = scene.nut.flange is not None and bool(scene.nut.flange.bolts)
    at = f'"{solid.nut_held}"' if half_face else "single bolts"
    groove, whole = f'"{solid.nut_groove}"', "leave the key out: grooves of a deck run through the whole nut"
    azimuth = ball_layout(scene).azimuth
    held = {n for s in scene.supports for n, v in s.fixed if v == 0.0}
    beside = bool(np.abs(np.sin(azimuth)).max() > 1e-9) or not {"uy", "rx", "rz"} <= held
    unlike = bool(scene.track.lead or scene.loads) or beside
    pair = "a pair of rings with balls at 0 and 180 deg, moved by supports that fix uy, rx and rz"
    faults = (
        (balls > MOST_BALLS, "balls", str(balls), large, cut),
        (solid.nut == "rigid", "solid.nut", '"rigid"', '"elastic"', "leave the key out: bodies of a deck are elastic"),
        (half_face or bolts, "nut.held.at", at, ", ".join(HELD), "choose one of these: a deck can only fix whole surfaces"),
        (solid.nut_groove != "through", "solid.nut_groove", groove, '"through"', whole),
        (half and unlike, "half", "a scene that is not symmetric about the plane y = 0", pair, "leave `half` out"),
    )
    raise_first_fault(scene.name, faults)


def geometric_errors_for_deck(scene: Scene) -> GeometryWithErrors:
    """Return the manufacturing errors of a scene if a CalculiX deck can describe all of them; raise InputError otherwise.

    A deck can describe errors of ball radii and of groove radii, which are included in the meshed geometry.
    """
    drawn = draw_geometry_with_errors(scene, ball_layout(scene))
    moved = bool((drawn.groove_centres != nominal_groove_centres(scene)).any() or drawn.groove_centre_derivatives.any())
    uneven = bool((drawn.groove_radii[::2] != drawn.groove_radii[1::2]).any())
    faults = (
        (drawn.profile_coefficients.size > 0, "errors.*.profile", "a profile of varying shape"),
        (moved, "errors.*.pitch, roundness", "a displaced groove"),
        (uneven, "errors.*.profile", "grooves of two radii"),
    )
    allowed = "errors of ball radii, and errors of groove radii that are equal on both flanks of a groove"
    raise_first_fault(scene.name, [(*fault, allowed, "leave this error out of the scene") for fault in faults])
    return drawn


def groove_with_real_radius(groove: GrooveMap, errors: GeometryWithErrors, scene: Scene, screw: bool) -> GrooveMap:
    """Return the geometry of a groove whose radius includes its geometric (manufacturing) error.

    ``groove``: nominal geometry; ``errors``: geometric errors of the scene; ``screw``: whether it is the groove of the
    screw, else of the nut. The centres of the groove's arcs stay; the groove radius, and the radius of the ball that
    just touches the groove, change by the same amount.
    """
    change = errors.groove_radii - nominal_groove_radii(scene)
    return replace(groove, radius=errors.groove_radii, ball=groove.ball + float(change[0 if screw else 2]))


def solve_expected_contact_loads(scene: Scene) -> StaticResult:
    """Solve a scene by the refined low-order model, whose contact loads show where contacts are expected.

    Raises InputError if the scene has no equilibrium or no contact carries load.
    """
    found = run_model(scene, "refined", ModelOptions(estimate_beam_mesh_error=False))
    allowed = 'a scene with loaded contacts that the low-order model "refined" can solve'
    advice = "load or preload the scene: meshes are refined where that model finds loaded contacts"
    idle = not found.converged or not (found.load > 0.0).any()
    value = "no loaded contact" if found.converged else found.status
    raise_first_fault(scene.name, [(bool(idle), "loads", value, allowed, advice)])
    return found


def build_deck(scene: Scene, options: DeckOptions | None = None) -> MeshedDeck:
    """Mesh the whole bodies of a scene (screw, nut and balls) and build its input deck for CalculiX.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    options
        Mesh sizes and contact options; None: the defaults.

    Returns
    -------
    MeshedDeck
        Deck, expected contact loads and quality of the meshes.

    Raises
    ------
    InputError
        If the scene is too large, cannot be described by a deck or cannot be meshed.
    """
    options = options or DeckOptions()
    _refuse_unsupported_scene(scene, options.half)
    drawn, found, sides = geometric_errors_for_deck(scene), solve_expected_contact_loads(scene), flanks_to_mesh(scene)
    m, layout = GrooveMap.from_scene(scene), ball_layout(scene)
    places, short = expected_contacts(scene, found.load, sides)
    fine = short / options.b_over_h
    try:
        dims = dimensions_of_3d_parts(scene)
        meshed = _mesh_screw_and_nut(scene, dims, drawn, m, places, fine, options)
        meshed += _mesh_balls(scene, drawn, m, layout, places, fine, options)
    except ValueError as error:
        advice = "check solid.* and the nut's length in the scene"
        raise InputError(scene.name, "deck", str(error), "a scene that can be meshed", advice) from error
    bodies = tuple(body for body, _ in meshed)
    quality = {body.name: smallest for body, smallest in meshed}
    count = sum(len(b.points) for b in bodies)
    smaller = "lower `b_over_h`, raise `growth`, or cut the screw by `balls`"
    raise_first_fault(scene.name, [(count > MOST_NODES, "deck", f"{count} nodes", f"at most {MOST_NODES} nodes", smaller)])
    contacts = tuple((ball_contact_face_set_name(p), groove_contact_face_set_name(p)) for p in places)
    sections = _rigid_sections_of_screw(scene, dims)
    comment, title = _deck_comment_lines(scene, dims, found, fine, count, options), f"{scene.name}: {scene.title}"
    cuts = tuple(f"{b.name}_CUT" for b in bodies if options.half)
    deck = InputDeck(
        bodies, sections, ("NUT_HELD",), contacts, options.stiffness, options.spring, comment, title, options.nlgeom, cuts
    )
    return MeshedDeck(deck, found.load, fine, quality)


def _element_sizes_near_contacts(
    points: list[Array], finest_size: float, coarsest_size: float, options: DeckOptions
) -> ElementSizesNearPoints:
    """Return the element sizes in the mesh of a body, which grow with the distance from its contacts.

    ``points``: for each contact the points (k, 3) in its zone of small elements [m]; ``finest_size``: element size
    there [m]; ``coarsest_size``: largest element size [m]; ``options``: options of the deck with the growth of the
    element size.
    """
    return ElementSizesNearPoints(np.concatenate(points), finest_size, options.growth, max(coarsest_size, finest_size))


def _mesh_screw_and_nut(
    scene: Scene,
    dims: Dimensions,
    errors: GeometryWithErrors,
    groove_map: GrooveMap,
    contacts: list[ExpectedContact],
    element_size: float,
    options: DeckOptions,
) -> list[tuple[DeckBody, float]]:
    """Mesh the nut and a piece of the screw; return each body with the smallest scaled Jacobian of its elements.

    ``dims``: dimensions of the bodies, with the ends of the piece of the screw; ``errors``: geometric errors;
    ``groove_map``: nominal geometry of the grooves; ``contacts``: expected contacts; ``element_size``: element size at
    the contacts [m].
    """
    low, high = dims.ends_of_meshed_screw(scene)
    half, z = scene.nut.length / 2.0, scene.nut.position
    unused = RefinementBoxSize(1.0, groove_map.ball, 1.0)
    bodies = []
    for name, part, ends, radii in (
        ("SCREW", scene.screw, (low, high), (dims.hole, scene.screw.outer_diameter / 2.0)),
        ("NUT", scene.nut, (z - half, z + half), (dims.land, scene.nut.outer_diameter / 2.0)),
    ):
        screw = name == "SCREW"
        on_body = [p for p in contacts if (p.side < 2) == screw]
        groove = groove_with_real_radius(groove_map, errors, scene, screw)
        zones = [(p.ball_position_and_flank, refined_zone_points(p, element_size)) for p in on_body]
        near = [whole_bodies.points_on_groove(groove, place, points) for place, points in zones]
        size = _element_sizes_near_contacts(near, element_size, FAR_SIZES[0] * options.growth * groove_map.ball, options)
        flange = None if screw else scene.nut.flange
        spec = GroovedBodySpec(*radii, *ends, screw, (), unused, element_size, size.largest_edge_length, flange=flange)
        mesh = (whole_bodies.mesh_half_ring if options.half else whole_bodies.mesh_whole_body)(groove, spec, size)
        faces = {groove_contact_face_set_name(p): flank_contact_faces(groove, mesh, p, element_size) for p in on_body}
        nodes_on = mesh.nodes_of_boundaries
        if not screw:
            held = {"NUT_HELD": np.unique(np.concatenate([nodes_on[x] for x in HELD[dims.nut_held]]))}
        elif dims.screw_held == "bore":
            held = {"SCREW_BORE": nodes_on["bore"]}
        else:
            held = {"SCREW_LOW": nodes_on["low end"], "SCREW_HIGH": nodes_on["high end"]}
        if options.half:  # nodes that are held or move with a rigid section stay in the plane by that
            held[f"{name}_CUT"] = np.setdiff1d(nodes_on["cut"], np.concatenate(list(held.values())))
        body = DeckBody(name, mesh.points, mesh.cells, part.material, held, faces)
        bodies.append((body, mesh.quality.smallest_jacobian))
    return bodies


def _mesh_balls(
    scene: Scene,
    errors: GeometryWithErrors,
    groove: GrooveMap,
    layout: BallLayout,
    contacts: list[ExpectedContact],
    element_size: float,
    options: DeckOptions,
) -> list[tuple[DeckBody, float]]:
    """Mesh every ball with its real radius at its position; return each with the smallest scaled Jacobian of its mesh.

    ``errors``: geometric errors; ``groove``: nominal geometry of the grooves; ``layout``: positions of the balls;
    ``contacts``: expected contacts; ``element_size``: element size at the contacts [m].
    """
    bodies, meshed, shared = [], dict[tuple[float, float], ExportedBodyMesh](), options.half or options.alike
    for i, radius in enumerate(errors.ball_radii.tolist()):
        on_ball, side = [p for p in contacts if p.ball == i], float(np.sign(np.cos(layout.azimuth[i])))
        kind = radius, side * options.half
        mesh = meshed.get(kind)
        if mesh is None:
            near = [p for p in contacts if errors.ball_radii[p.ball] == radius] if shared else on_ball
            zones = [(p.side, radius, refined_zone_points(p, element_size)) for p in near]
            on_sphere = [whole_bodies.points_on_ball_surface(groove, *zone) for zone in zones]
            size = _element_sizes_near_contacts(
                on_sphere, element_size, FAR_SIZES[1] * options.growth * groove.ball, options
            )
            if options.half:
                mesh = whole_bodies.mesh_half_ball(radius, size, side)
            else:
                mesh = whole_bodies.mesh_whole_ball(groove, radius, size)
            if shared:
                meshed[kind] = mesh
        faces = {ball_contact_face_set_name(p): ball_contact_faces(groove, mesh, p, radius, element_size) for p in on_ball}
        name = f"BALL{i + 1}"
        points = whole_bodies.move_to_ball_position(groove, (float(layout.azimuth[i]), float(layout.z[i])), mesh.points)
        axes = [normal_between_hemispheres(groove)]
        if not options.half:
            axes.append(contact_frame_vectors(groove, 0)[2])
        poles = np.argmax(mesh.points @ np.stack([sign * x for x in axes for sign in (1.0, -1.0)]).T, axis=0)
        pairs = poles.reshape(-1, 2)
        alike = half_ball_turning_constraint(points, pairs[0]) if options.half else ball_rotation_constraints(points, pairs)
        weak = poles[:1]
        nodes = {f"{name}_WEAK": weak}
        if options.half:
            nodes[f"{name}_CUT"] = mesh.nodes_of_boundaries["cut"]
        body = DeckBody(name, points, mesh.cells, scene.balls.material, nodes, faces, weak, alike)
        bodies.append((body, mesh.quality.smallest_jacobian))
    return bodies


def half_ball_turning_constraint(points: Array, pair: Index) -> Index:
    """Return the constraint (1, 3) that keeps a half ball from turning about y: two nodes move alike along an axis.

    The three entries are the numbers of the two nodes, and the number of the axis. The cut of the half ball stays in
    the plane y = 0, so that no other rotation is possible. ``points``: nodes of the ball (n, 3) [m]; ``pair``: numbers
    of two nodes.
    """
    arms = [abs(float(np.cross(points[pair[0]] - points[pair[1]], np.eye(3)[k])[1])) for k in range(3)]
    return np.array([(*pair, int(np.argmax(arms)))], dtype=np.int64)


def ball_rotation_constraints(points: Array, pairs: Index) -> Index:
    """Return three constraints (3, 3) that keep a ball from turning: in each, two nodes move alike along an axis.

    Each row holds the numbers of the two nodes and the number of the axis (0, 1, 2: x, y, z). A small rotation vector theta
    [rad] displaces two nodes at a distance vector d by theta x d relative to each other, whose component along axis k is
    theta . (d x e_k). The three constraints are chosen among the candidate pairs to be as independent as possible, so that
    they prevent every rotation. Their forces are couples and do not affect the ball's equilibrium of forces. ``points``:
    nodes of the ball (n, 3) [m]; ``pairs``: numbers of the nodes of each candidate pair (p, 2).
    """
    found = [(int(a), int(b), k) for a, b in pairs for k in range(3)]
    arms = np.array([np.cross(points[a] - points[b], np.eye(3)[k]) for a, b, k in found])
    best = max(combinations(range(len(found)), 3), key=lambda rows: abs(float(np.linalg.det(arms[list(rows)]))))
    return np.array([found[k] for k in best], dtype=np.int64)


def _rigid_sections_of_screw(scene: Scene, dims: Dimensions) -> tuple[RigidSection, ...]:
    """Return those surfaces of the screw (its ends or its bore) that move as rigid sections and carry supports and loads.

    ``dims``: dimensions of the bodies. Raises InputError if supports or loads act elsewhere.
    """
    stations = sorted({s.at for s in scene.supports} | {x.at for x in scene.loads})
    if dims.screw_held == "bore":
        ends = {"SCREW_BORE": stations[0] if stations else scene.nut.position}
        allowed = "supports and loads at one axial position"
    else:
        low, high = dims.ends_of_meshed_screw(scene)
        ends = {"SCREW_LOW": low, "SCREW_HIGH": high}
        allowed = f"z = {1e3 * low:.6g} mm and {1e3 * high:.6g} mm, the ends of the meshed part of the screw"
    advice = (
        "cut the screw (`balls=3:5`), or set solid.shaft to the positions of the supports and loads: a deck has no beams"
    )
    for z in stations:
        away = min(abs(z - end) for end in ends.values()) > 1e-9
        value = f"a support or load at {1e3 * z:.6g} mm"
        raise_first_fault(scene.name, [(away, "supports, loads", value, allowed, advice)])
    free = [k for k, name in enumerate(FREEDOMS) if not any(name == n for s in scene.supports for n, _ in s.fixed)]
    sections: list[RigidSection] = []
    for name, z in ends.items():
        fixed = [(FREEDOMS.index(n), v) for s in scene.supports if abs(s.at - z) <= 1e-9 for n, v in s.fixed]
        wrench = np.zeros(6)
        for load in scene.loads:
            if abs(load.at - z) <= 1e-9:
                wrench += np.array([*load.force, *load.moment])
        weak = tuple(free) if not sections else ()
        sections.append(RigidSection(name, "SCREW", name, np.array([0.0, 0.0, z]), tuple(sorted(fixed)), wrench, weak))
    return tuple(sections)


def _deck_comment_lines(
    scene: Scene, dims: Dimensions, static_result: StaticResult, element_size: float, count: int, options: DeckOptions
) -> tuple[str, ...]:
    """Return the comment lines at the top of a CalculiX deck: scene, mesh sizes, contact options, expected contact loads.

    ``static_result``: static result of the low-order model; ``element_size``: element size at the contacts [m]; ``count``:
    number of nodes.
    """
    load = static_result.load
    mean = float(load[load > 0.0].mean())
    return (
        f"Scene {scene.name}, by rollbench {__version__}. Whole bodies, {count} nodes, C3D10; z is the screw's axis.",
        f"Elements of {1e3 * element_size:.4g} mm at the contacts, {options.b_over_h:.4g} across the minor semi-axis at "
        "mean load,",
        f"growing by {options.growth:.4g} per length away from them.",
        f"Contact without friction, pressure per overclosure {options.stiffness * 1e-9:.4g} N/mm3.",
        "Balls cannot turn: two pairs of their nodes move alike along three axes (couples, no force on the ball).",
        f"Weak springs of {1e-3 * options.spring:.4g} N/mm hold one node of every ball (sets BALL..._WEAK) and freedoms",
        "of the screw that no support holds (turning: N mm/rad); their force is that times the motion that is printed.",
        "Oversize of balls and errors of groove radii are in the geometry; flanks are exact arcs.",
        *dims.assumed,
        f"Expected contact loads / N: low-order model refined, {_clause_on_load_error(scene, static_result)}; mean "
        f"{mean:.1f} N.",
        "ball " + " ".join(f"{s:>10}" for s in SIDES),
        *(f"{i:>4} " + " ".join(f"{x:10.2f}" for x in row) for i, row in enumerate(load, start=1)),
        "CalculiX: ccx -i FILE (without .inp); loads by *CONTACT PRINT in FILE.dat.",
        "Abaqus documents every keyword used here (*CONTACT PRINT with SLAVE, MASTER and CFN too); it was not run there.",
    )


def _clause_on_load_error(scene: Scene, static_result: StaticResult) -> str:
    """Return a clause for the comments at the top of a CalculiX deck on the expected error of the low-order contact loads.

    ``static_result``: static result of the low-order model.
    """
    form = estimate_model_error(scene, static_result)
    if not static_result.converged or form.loads is None:
        return "no similar scene was compared with the 3D reference"
    return f"error to expect {form.loads:.1f} % of the mean load on the worst contact (nearest compared: {form.nearest})"
