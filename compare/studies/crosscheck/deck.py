"""Contact problem of a small scene as a deck for another program: bodies, contacts, supports and loads.

For each contact: where it is expected, how large, and which faces of balls and grooves belong to it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import InputError
from rollbench.compare.models.model_form import estimate
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.reference.tasks import needed_sides
from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import directions, parting
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.exchange.deck import Contact, Deck, DeckBody, RigidSection, outer_faces
from rollbench.meshes.exchange.whole_bodies import (
    Refinement,
    WholeBody,
    grid,
    groove_points,
    half_ball,
    half_body,
    place_ball,
    sphere_points,
    whole_ball,
    whole_body,
)
from rollbench.meshes.groove import BodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import BallLayout, ball_layout, groove_radii, lead_angle, nominal_groove_centres
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene
from rollbench.meshes.sockets import SocketSize, socket_coordinates
from rollbench.meshes.solid import Dimensions, dimensions

#: Semi-axes of the refined zone and of the slave's and master's faces, over those of the expected ellipse; the zones of the
#: faces are also wider by some elements.
FINE, SLAVE, MASTER = 1.1, (1.6, 2.0), (2.0, 4.0)

#: Smallest load for which a zone is sized, over the mean load.
LEAST = 0.1


@dataclass(frozen=True)
class ExpectedContact:
    """Expected contact."""

    #: Number of the ball, from 0.
    ball: int
    #: Flank.
    side: int
    #: Azimuth [rad], axial position [m], flank.
    at: tuple[float, float, int]
    #: Semi-axes across and along the groove [m].
    half: tuple[float, float]


def unit_load_semi_axes(scene: Scene, side: int) -> tuple[float, float]:
    """Return the semi-axes of the contact ellipse at 1 N, across and along the groove [m/N^(1/3)].

    By Hertz on the nominal geometry. The long one lies across the groove, where ball and groove conform.
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


def contact_places(scene: Scene, load: Array, sides: tuple[int, ...]) -> tuple[list[ExpectedContact], float]:
    """Return the expected contacts on ``sides``, and the minor semi-axis of a screw contact of mean load [m]."""
    layout, mean = ball_layout(scene), float(load[load > 0.0].mean())
    unit = {s: unit_load_semi_axes(scene, s) for s in sides}
    places = []
    for i in range(scene.ball_count):
        for s in sides:
            root = float(np.cbrt(max(load[i, s], LEAST * mean)))
            at = (float(layout.azimuth[i]), float(layout.z[i]), s)
            places.append(ExpectedContact(i, s, at, (unit[s][0] * root, unit[s][1] * root)))
    return places, unit[sides[0]][1] * float(np.cbrt(mean))


def ball_face_name(place: ExpectedContact) -> str:
    """Return the name of the ball's faces at a contact."""
    return f"BALL{place.ball + 1}_{SIDES[place.side]}"


def groove_face_name(place: ExpectedContact) -> str:
    """Return the name of the groove's faces at a contact."""
    return f"{'SCREW' if place.side < 2 else 'NUT'}_{SIDES[place.side]}_{place.ball + 1}"


def _widened_semi_axes(place: ExpectedContact, fine: float, wide: tuple[float, float]) -> tuple[float, float]:
    """Return the semi-axes of the faces of a contact [m]."""
    across, along = (wide[0] * x + wide[1] * fine for x in place.half)
    return across, along


def refined_zone_points(place: ExpectedContact, fine: float) -> Array:
    """Return points that fill the refined zone of a contact, (k, 2) across and along [m]."""
    return grid((FINE * place.half[0], FINE * place.half[1]), 0.7 * fine)


def flank_contact_faces(m: GrooveMap, mesh: WholeBody, place: ExpectedContact, fine: float) -> Index:
    """Return the faces of a flank within the master's zone of a contact."""
    flank = mesh.named[f"flank {SIDES[place.side]}"]
    x, radius = mesh.points[flank], float(m.radius[place.side])
    xi = socket_coordinates(
        m, SocketSize(1.0, radius, 1.0), place.at, np.arctan2(x[:, 1], x[:, 0]), x[:, 2], np.hypot(x[:, 0], x[:, 1])
    )
    half = _widened_semi_axes(place, fine, MASTER)
    inside = (radius * xi[:, 0] / half[0]) ** 2 + (m.R * xi[:, 2] / half[1]) ** 2 <= 1.0
    return _faces_within(mesh, flank[inside])


def ball_contact_faces(m: GrooveMap, mesh: WholeBody, place: ExpectedContact, radius: float, fine: float) -> Index:
    """Return the faces of a ball within the slave's zone of a contact; the ball is meshed in the frame of azimuth 0."""
    (n, t1, t2), sphere, half = directions(m, place.side), mesh.named["sphere"], _widened_semi_axes(place, fine, SLAVE)
    x = mesh.points[sphere]
    height = np.where(x @ n > 0.0, x @ n, 1e-9 * radius)  # nodes behind are far outside
    across, along = radius * (x @ t1) / height, radius * (x @ t2) / height
    inside = (x @ n > 0.0) & ((across / half[0]) ** 2 + (along / half[1]) ** 2 <= 1.0)
    return _faces_within(mesh, sphere[inside])


def _faces_within(mesh: WholeBody, nodes: Index) -> Index:
    """Return the corners of the outer faces all of whose corners are among ``nodes``; not those of the cut of a half.

    ValueError if there is none.
    """
    faces = outer_faces(mesh.cells)
    within = faces[np.isin(faces, nodes).all(axis=1) & ~np.isin(faces, mesh.named.get("cut", [])).all(axis=1)]
    if not len(within):
        raise ValueError(
            "no face of the mesh lies within an expected contact: take more elements across it, or less growth"
        )
    return within


#: Largest number of balls and nodes of a deck, for a direct solver in minutes.
MOST_BALLS = 4

MOST_NODES = 120_000

#: Fixed surfaces of the nut.
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
    """Choices of mesh and contact of a deck."""

    #: Elements across the minor semi-axis of a contact of mean load; all contacts have this element size.
    b_over_h: float = 1.5
    #: Growth of element size per distance from the contacts.
    growth: float = 0.4
    #: Contact pressure per overclosure [Pa/m].
    stiffness: float = 2e17
    #: Weak springs at every ball and free degree of freedom of the screw [N/m].
    spring: float = 1e3
    #: Whether displacements are large.
    nlgeom: bool = False
    #: Whether only y >= 0 of a ring pair is meshed, if this is a plane of symmetry.
    half: bool = False
    #: Whether all balls of one radius have the same mesh, so that differences of meshes do not scatter their loads (halves:
    #: always).
    alike: bool = False


@dataclass(frozen=True)
class MeshedDeck:
    """A deck with data of its mesh."""

    #: The deck.
    deck: Deck
    #: Contact loads of the refined low-order model, (n, 4) [N].
    expected: Array
    #: Element size at the contacts [m].
    fine: float
    #: Smallest scaled Jacobian of the cells of each body.
    quality: dict[str, float]


def raise_first_fault(where: str, faults: Iterable[tuple[bool, str, str, str, str]]) -> None:
    """Raise InputError for the first fault that applies: condition, key, value, allowed values and advice."""
    for there, key, value, allowed, advice in faults:
        if there:
            raise InputError(where, key, value, allowed, advice)


def _refuse_unlike_decks(scene: Scene, half: bool) -> None:
    """Raise InputError if a deck cannot describe a scene, or it has too many balls for whole bodies.

    With ``half`` also if the plane y = 0 is no plane of symmetry: because of a helix, balls next to the plane, loads, or a
    screw that is not fixed along y and about x and z.
    """
    balls, solid = scene.ball_count, scene.solid
    large = f"1 to {MOST_BALLS} balls in a deck of whole bodies"
    cut = "cut the screw to a few neighbouring balls: `balls=3:5` keeps balls 3 to 5"
    half_face = solid.nut_held is not None and solid.nut_held not in HELD
    bolts = scene.nut.flange is not None and bool(scene.nut.flange.bolts)
    at = f'"{solid.nut_held}"' if half_face else "single bolts"
    groove, whole = f'"{solid.nut_groove}"', "leave it out: a deck has whole grooves"
    azimuth = ball_layout(scene).azimuth
    held = {n for s in scene.supports for n, v in s.fixed if v == 0.0}
    beside = bool(np.abs(np.sin(azimuth)).max() > 1e-9) or not {"uy", "rx", "rz"} <= held
    unlike = bool(scene.track.lead or scene.loads) or beside
    pair = "a ring pair with balls at 0 and 180 deg, moved by supports that hold uy, rx, rz"
    faults = (
        (balls > MOST_BALLS, "balls", str(balls), large, cut),
        (solid.nut == "rigid", "solid.nut", '"rigid"', '"elastic"', "leave it out: a deck holds whole bodies"),
        (half_face or bolts, "nut.held.at", at, ", ".join(HELD), "a deck holds whole surfaces"),
        (solid.nut_groove != "through", "solid.nut_groove", groove, '"through"', whole),
        (half and unlike, "half", "not its own mirror image", pair, "mesh whole bodies"),
    )
    raise_first_fault(scene.name, faults)


def representable_errors(scene: Scene) -> Specimen:
    """Return the errors of a scene if real geometry can have them: radii of balls and of grooves; else InputError."""
    drawn = specimen(scene, ball_layout(scene))
    moved = bool(np.abs(drawn.centre - nominal_groove_centres(scene)).max() > 0.0 or drawn.centre_slopes.any())
    uneven = bool(drawn.radius[0] != drawn.radius[1] or drawn.radius[2] != drawn.radius[3])
    faults = (
        (drawn.profile.size > 0, "errors.*.profile", "a profile of varying shape"),
        (moved, "errors.*.pitch, roundness", "a displaced groove"),
        (uneven, "errors.*.profile", "grooves of two radii"),
    )
    allowed = "errors of ball radii and, the same on both flanks, of groove radii"
    raise_first_fault(scene.name, [(*fault, allowed, "leave this error out of the scene") for fault in faults])
    return drawn


def real_groove_map(m: GrooveMap, drawn: Specimen, scene: Scene, screw: bool) -> GrooveMap:
    """Return the map of the real groove of screw or nut.

    The centres of the arcs stay; the radius, and that of the ball that would fit, change by the same amount.
    """
    change = drawn.radius - groove_radii(scene)
    return replace(m, radius=drawn.radius, ball=m.ball + float(change[0 if screw else 2]))


def solve_expected_loads(scene: Scene) -> StaticResult:
    """Solve a scene by the refined low-order model; InputError if it has no equilibrium or nothing is loaded."""
    found = run_model(scene, "refined", Options(discretisation=False))
    allowed = "a scene with loaded contacts that the model refined solves"
    advice = "meshes are refined at the contacts it finds: load or preload the scene"
    idle = not found.converged or not (found.load > 0.0).any()
    raise_first_fault(scene.name, [(bool(idle), "loads", found.status, allowed, advice)])
    return found


def build_deck(scene: Scene, options: DeckOptions | None = None) -> MeshedDeck:
    """Mesh the whole bodies of a scene and make its deck.

    Parameters
    ----------
    scene
        Scene with one set.
    options
        Choices of mesh and contact.

    Returns
    -------
    MeshedDeck
        The deck.

    Raises
    ------
    InputError
        If the scene is too large, cannot be described by a deck or cannot be meshed.
    """
    options = options or DeckOptions()
    _refuse_unlike_decks(scene, options.half)
    drawn, found, sides = representable_errors(scene), solve_expected_loads(scene), needed_sides(scene)
    m, layout = GrooveMap.of(scene), ball_layout(scene)
    places, short = contact_places(scene, found.load, sides)
    fine = short / options.b_over_h
    try:
        dims = dimensions(scene)
        meshed = _mesh_screw_and_nut(scene, dims, drawn, m, places, fine, options)
        meshed += _mesh_balls(scene, drawn, m, layout, places, fine, options)
    except ValueError as error:
        raise InputError(
            scene.name, "deck", str(error), "a scene that can be meshed", "see solid.* and the nut's length in the scene"
        ) from error
    bodies = tuple(body for body, _ in meshed)
    quality = {body.name: smallest for body, smallest in meshed}
    count = sum(len(b.points) for b in bodies)
    smaller = "lower `b_over_h`, raise `growth`, or cut the screw: `balls`"
    raise_first_fault(scene.name, [(count > MOST_NODES, "deck", f"{count} nodes", f"at most {MOST_NODES} nodes", smaller)])
    contacts = tuple(Contact(ball_face_name(p), groove_face_name(p)) for p in places)
    deck = Deck(
        bodies,
        _rigid_sections(scene, dims),
        ("NUT_HELD",),
        contacts,
        options.stiffness,
        options.spring,
        _deck_heading(scene, dims, found, fine, count, options),
        f"{scene.name}: {scene.title}",
        options.nlgeom,
        tuple(f"{b.name}_CUT" for b in bodies if options.half),
    )
    return MeshedDeck(deck, found.load, fine, quality)


def _deck_refinement(points: list[Array], fine: float, coarse: float, options: DeckOptions) -> Refinement:
    return Refinement(np.concatenate(points), fine, options.growth, max(coarse, fine))


def _mesh_screw_and_nut(
    scene: Scene,
    dims: Dimensions,
    drawn: Specimen,
    m: GrooveMap,
    places: list[ExpectedContact],
    fine: float,
    options: DeckOptions,
) -> list[tuple[DeckBody, float]]:
    """Mesh screw (its 3D stretch) and nut; return each with the smallest scaled Jacobian of its cells."""
    low, high = dims.ends(scene)
    half, z = scene.nut.length / 2.0, scene.nut.position
    unused = SocketSize(1.0, m.ball, 1.0)
    bodies = []
    for name, part, ends, radii in (
        ("SCREW", scene.screw, (low, high), (dims.hole, scene.screw.outer_diameter / 2.0)),
        ("NUT", scene.nut, (z - half, z + half), (dims.land, scene.nut.outer_diameter / 2.0)),
    ):
        screw = name == "SCREW"
        on_body = [p for p in places if (p.side < 2) == screw]
        groove = real_groove_map(m, drawn, scene, screw)
        near = [groove_points(groove, p.at, refined_zone_points(p, fine)) for p in on_body]
        size = _deck_refinement(near, fine, FAR_SIZES[0] * options.growth * m.ball, options)
        flange = None if screw else scene.nut.flange
        spec = BodySpec(*radii, *ends, screw, (), unused, fine, size.coarse, flange=flange)
        mesh = (half_body if options.half else whole_body)(groove, spec, size)
        faces = {groove_face_name(p): flank_contact_faces(groove, mesh, p, fine) for p in on_body}
        if screw:
            held = (
                {"SCREW_BORE": mesh.named["bore"]}
                if dims.screw_held == "bore"
                else {"SCREW_LOW": mesh.named["low end"], "SCREW_HIGH": mesh.named["high end"]}
            )
        else:
            held = {"NUT_HELD": np.unique(np.concatenate([mesh.named[x] for x in HELD[dims.nut_held]]))}
        if options.half:  # nodes that are held or move with a rigid section stay in the plane by that
            held[f"{name}_CUT"] = np.setdiff1d(mesh.named["cut"], np.concatenate(list(held.values())))
        body = DeckBody(name, mesh.points, mesh.cells, part.material, held, faces)
        bodies.append((body, mesh.quality.smallest))
    return bodies


def _mesh_balls(
    scene: Scene,
    drawn: Specimen,
    m: GrooveMap,
    layout: BallLayout,
    places: list[ExpectedContact],
    fine: float,
    options: DeckOptions,
) -> list[tuple[DeckBody, float]]:
    """Mesh every ball with its radius at its position."""
    bodies, meshed, shared = [], dict[tuple[float, float], WholeBody](), options.half or options.alike
    for i, radius in enumerate(drawn.ball_radius.tolist()):
        on_ball, side = [p for p in places if p.ball == i], float(np.sign(np.cos(layout.azimuth[i])))
        kind = radius, side * options.half
        mesh = meshed.get(kind)
        if mesh is None:
            near = [p for p in places if drawn.ball_radius[p.ball] == radius] if shared else on_ball
            zones = [sphere_points(m, p.side, radius, refined_zone_points(p, fine)) for p in near]
            size = _deck_refinement(zones, fine, FAR_SIZES[1] * options.growth * m.ball, options)
            mesh = half_ball(radius, size, side) if options.half else whole_ball(m, radius, size)
            if shared:
                meshed[kind] = mesh
        faces = {ball_face_name(p): ball_contact_faces(m, mesh, p, radius, fine) for p in on_ball}
        name = f"BALL{i + 1}"
        points = place_ball(m, (float(layout.azimuth[i]), float(layout.z[i])), mesh.points)
        axes = [parting(m)] if options.half else [parting(m), directions(m, 0)[2]]
        poles = np.argmax(mesh.points @ np.stack([sign * x for x in axes for sign in (1.0, -1.0)]).T, axis=0)
        pairs = poles.reshape(-1, 2)
        alike = half_ball_turning_constraint(points, pairs[0]) if options.half else turning_constraints(points, pairs)
        weak = poles[:1]
        nodes = {f"{name}_WEAK": weak}
        if options.half:
            nodes[f"{name}_CUT"] = mesh.named["cut"]
        body = DeckBody(name, points, mesh.cells, scene.balls.material, nodes, faces, weak, alike)
        bodies.append((body, mesh.quality.smallest))
    return bodies


def half_ball_turning_constraint(points: Array, pair: Index) -> Index:
    """Return the row (1, 3) of two nodes and an axis along which they move alike, so that a half ball cannot turn about y.

    Its cut stays in the plane y = 0.
    """
    arms = [abs(float(np.cross(points[pair[0]] - points[pair[1]], np.eye(3)[k])[1])) for k in range(3)]
    return np.array([(*pair, int(np.argmax(arms)))], dtype=np.int64)


def turning_constraints(points: Array, pairs: Index) -> Index:
    """Return rows (3, 3) of two nodes and an axis along which they move alike, so that a body cannot turn.

    A rotation theta moves the nodes of a pair, d apart, by theta x d relative to each other: along axis k by
    theta . (d x e_k). Three such rows that are as independent as possible leave no rotation; their forces are couples, so
    that the balance of forces is not affected. ``pairs``: nodes (p, 2).
    """
    found = [(int(a), int(b), k) for a, b in pairs for k in range(3)]
    arms = np.array([np.cross(points[a] - points[b], np.eye(3)[k]) for a, b, k in found])
    best = max(combinations(range(len(found)), 3), key=lambda rows: abs(float(np.linalg.det(arms[list(rows)]))))
    return np.array([found[k] for k in best], dtype=np.int64)


def _rigid_sections(scene: Scene, dims: Dimensions) -> tuple[RigidSection, ...]:
    """Return rigid sections of the screw with supports and loads; InputError if they act elsewhere."""
    stations = sorted({s.at for s in scene.supports} | {x.at for x in scene.loads})
    if dims.screw_held == "bore":
        ends = {"SCREW_BORE": stations[0] if stations else scene.nut.position}
        allowed = "one station"
    else:
        low, high = dims.ends(scene)
        ends = {"SCREW_LOW": low, "SCREW_HIGH": high}
        allowed = f"the ends of the 3D stretch, {1e3 * low:.6g} mm and {1e3 * high:.6g} mm"
    advice = "a deck has no beams: cut the screw (`balls=3:5`), or set solid.shaft and the stations to match"
    for z in stations:
        away = min(abs(z - end) for end in ends.values()) > 1e-9
        raise_first_fault(scene.name, [(away, "supports, loads", f"a station at {1e3 * z:.6g} mm", allowed, advice)])
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


def _deck_heading(
    scene: Scene, dims: Dimensions, found: StaticResult, fine: float, count: int, options: DeckOptions
) -> tuple[str, ...]:
    """Return comment lines of a deck: scene, choices, expected loads."""
    load = found.load
    mean = float(load[load > 0.0].mean())
    return (
        f"Scene {scene.name}, by rollbench {__version__}. Whole bodies, {count} nodes, C3D10; z is the screw's axis.",
        f"Elements of {1e3 * fine:.4g} mm at the contacts, {options.b_over_h:.4g} across the minor semi-axis at mean load,",
        f"growing by {options.growth:.4g} per length away from them.",
        f"Contact without friction, pressure per overclosure {options.stiffness * 1e-9:.4g} N/mm3.",
        "Balls cannot turn: two pairs of their nodes move alike along three axes (couples, no force on the ball).",
        f"Weak springs of {1e-3 * options.spring:.4g} N/mm hold one node of every ball (sets BALL..._WEAK) and freedoms",
        "of the screw that no support holds (turning: N mm/rad); their force is that times the motion that is printed.",
        "Oversize of balls and errors of groove radii are in the geometry; flanks are exact arcs.",
        *dims.assumed,
        f"Expected contact loads / N: low-order model refined, {_expected_error_clause(scene, found)}; mean {mean:.1f} N.",
        "ball " + " ".join(f"{s:>10}" for s in SIDES),
        *(f"{i:>4} " + " ".join(f"{x:10.2f}" for x in row) for i, row in enumerate(load, start=1)),
        "CalculiX: ccx -i FILE (without .inp); loads by *CONTACT PRINT in FILE.dat.",
        "Abaqus documents every keyword used here (*CONTACT PRINT with SLAVE, MASTER and CFN too); it was not run there.",
    )


def _expected_error_clause(scene: Scene, found: StaticResult) -> str:
    """Return a sentence on the error to expect of the loads."""
    form = estimate(scene, found)
    if not found.converged or form.percent is None:
        return "nothing like the scene was compared with a 3D reference"
    return f"error to expect {form.percent:.1f} % of the mean load on the worst contact (nearest compared: {form.nearest})"
