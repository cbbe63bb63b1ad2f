"""Write a complete contact problem as one input deck, an input file that both CalculiX and Abaqus can run.

The deck has one static step and only keywords of both programs: bodies of ten-node tetrahedra; named sets of nodes and
faces; frictionless surface-to-surface contact with a linear pressure-overclosure law; rigid sections as linear equations;
weak springs to the ground. Lines have at most 16 entries, entries at most 20 characters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.parts import Material

#: Corner nodes, counted from 0, of the faces S1 to S4 of a tetrahedron; and of the faces S1 to S6 of a hexahedron.
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
HEX_FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
#: Number, in gmsh's ten-node tetrahedron, of each node of Abaqus' element C3D10.
C3D10 = (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)
#: Number of coordinate axes.
AXES = 3
#: CalculiX's limits I_0, I_R, I_P and I_C on the number of iterations in one increment, in place of its defaults 4, 8, 9,
#: 16; contact under preload needs about 25 iterations.
PATIENCE = "30, 40, 9, 60"
#: Lever arm [m] with which a weak spring's stiffness is converted to that of a rotational spring.
WEAK_ARM = 1e-3


@dataclass(frozen=True)
class DeckUnits:
    """Units of length and stress in an input deck; forces are in N."""

    #: Size of the unit of length [m].
    length: float
    #: Size of the unit of stress [Pa].
    stress: float
    #: Names of the units, for the deck's heading.
    names: str


#: Units of an input deck, by the name of the unit of length.
UNITS = {"mm": DeckUnits(1e-3, 1e6, "mm, N, MPa"), "m": DeckUnits(1.0, 1.0, "m, N, Pa")}


@dataclass(frozen=True)
class DeckBody:
    """Elastic body of an input deck (CalculiX, Abaqus): mesh of ten-node tetrahedra, material, named sets, weak springs."""

    #: Name of the body, and of its element set.
    name: str
    #: Coordinates of the nodes ``(n, 3)`` [m].
    points: Array
    #: Nodes of the tetrahedra ``(m, 10)``, in gmsh's order.
    cells: Index
    #: Elastic material.
    material: Material
    #: Sets of nodes by name.
    node_sets: dict[str, Index] = field(default_factory=dict)
    #: Sets of faces by name; each face is given by its corners ``(k, 3)``.
    face_sets: dict[str, Index] = field(default_factory=dict)
    #: Nodes connected to the ground by weak springs.
    nodes_with_weak_springs: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    #: Pairs of nodes whose displacements along one axis are set equal, which prevents a rotation of the body without fixing
    #: it ``(k, 3)``: two nodes, and the axis 0 to 2.
    nodes_with_equal_displacement: Index = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))


@dataclass(frozen=True)
class RigidSection:
    """Rigid cross-section of a body in an input deck: its nodes move as a rigid plane with prescribed motion or load."""

    #: Name of the rigid section.
    name: str
    #: Name of the body to which the section belongs.
    body_name: str
    #: Name of the set of nodes that form the section.
    node_set: str
    #: Point on the axis to which motion and load refer ``(3,)`` [m].
    reference_point: Array
    #: Pairs of a degree of freedom (0 to 5) and its prescribed displacement [m] or small rotation [rad].
    prescribed_motion: tuple[tuple[int, float], ...]
    #: Force [N] and moment [N m] on the section ``(6,)``.
    load: Array
    #: Degrees of freedom (0 to 5) connected to the ground by weak springs.
    freedoms_with_weak_springs: tuple[int, ...] = ()


@dataclass(frozen=True)
class InputDeck:
    """Contents of an input deck for CalculiX or Abaqus: bodies, rigid sections, contact pairs, boundary conditions."""

    #: All bodies.
    bodies: tuple[DeckBody, ...]
    #: Rigid sections of the bodies.
    rigid_sections: tuple[RigidSection, ...]
    #: Names of the sets of nodes that are fixed in all directions.
    fixed_node_sets: tuple[str, ...]
    #: Contact pairs: names of the slave and the master surface, which may come into contact.
    contact_pairs: tuple[tuple[str, str], ...]
    #: Slope of the linear pressure-overclosure law of all contacts [Pa/m].
    contact_stiffness: float
    #: Stiffness of every weak spring [N/m].
    weak_spring_stiffness: float
    #: Lines of comment at the head of the deck.
    comment_lines: tuple[str, ...]
    #: Title of the model.
    title: str
    #: Whether the step is geometrically nonlinear (keyword NLGEOM).
    geometrically_nonlinear: bool = False
    #: Names of the sets of nodes on a plane of symmetry, which are fixed along y.
    symmetry_node_sets: tuple[str, ...] = ()

    @property
    def node_count(self) -> int:
        """Number of nodes of all bodies together."""
        return sum(len(b.points) for b in self.bodies)


def number_text(value: float) -> str:
    """Return a number as text of at most 20 characters, the largest length that CalculiX reads.

    Examples
    --------
    >>> number_text(-1.2345678901234567e-105), len(number_text(-1.2345678901234567e-105))
    ('-1.234567890123e-105', 20)
    """
    return f"{value:.12e}"


def comma_separated_lines(entries: Iterable[int | str]) -> Iterator[str]:
    """Yield the lines of a data row of an input deck: at most 16 entries each; all but the last end with a comma.

    Examples
    --------
    >>> list(comma_separated_lines(range(18)))
    ['0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,', '16, 17']
    """
    words = [str(x) for x in entries]
    for k in range(0, len(words), 16):
        yield ", ".join(words[k : k + 16]) + ("," if k + 16 < len(words) else "")


def cells_and_numbers_of_faces(cells: Index, corners: Index) -> Index:
    """Return, for each face of a mesh, the cell to which it belongs and the face's number in that cell.

    Parameters
    ----------
    cells : (m, nodes) Index
        Nodes of the tetrahedra or hexahedra.
    corners : (k, 3 or 4) Index
        Corners of the faces: three for tetrahedra, four for hexahedra.

    Returns
    -------
    (k, 2) Index
        For each face, the index of its cell (from 0) and its number in that cell (from 1).

    Raises
    ------
    ValueError
        A face belongs to no cell.
    """
    faces = np.array(FACES if corners.shape[1] == 3 else HEX_FACES)
    table = np.sort(cells[:, faces].reshape(-1, corners.shape[1]), axis=1)
    count = int(cells.max(initial=0)) + 1
    base = np.array([count * count, count, 1])  # three corners identify a face of a mesh
    keys, wanted = table[:, :3] @ base, np.sort(corners, axis=1)[:, :3] @ base
    order = np.argsort(keys, kind="stable")
    place = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
    if not np.array_equal(keys[place], wanted):
        raise ValueError("a face of a named surface belongs to no cell of the mesh")
    return np.stack([place // len(faces), place % len(faces) + 1], axis=1)


def outer_faces_of_tetrahedra(cells: Index) -> Index:
    """Return the faces of tetrahedra that lie on the surface of the body, that is, that belong to only one tetrahedron.

    Parameters
    ----------
    cells : (m, 10) Index
        Nodes of the tetrahedra; the first four are the corners.

    Returns
    -------
    (k, 3) Index
        Corners of the faces.
    """
    faces = cells[:, np.array(FACES)].reshape(-1, 3)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[count == 1])])


def deck_text(deck: InputDeck, unit: str = "mm") -> str:
    """Return an input deck for CalculiX or Abaqus as text.

    Parameters
    ----------
    deck : InputDeck
        Contents of the deck.
    unit : str, default 'mm'
        Unit of length, ``"mm"`` or ``"m"``.

    Returns
    -------
    str
        ASCII text of the input file.
    """
    text = "\n".join(_deck_lines(deck, UNITS[unit])) + "\n"
    return text.encode("ascii", "replace").decode("ascii")


def _deck_lines(deck: InputDeck, units: DeckUnits) -> Iterator[str]:
    """Yield all lines of an input deck."""
    yield "*HEADING"
    yield deck.title[:80]
    yield from (f"** {line}" for line in (*deck.comment_lines, f"Units: {units.names}"))
    starts: dict[str, tuple[int, int]] = {}
    nodes = cells = 0
    for body in deck.bodies:
        starts[body.name] = nodes, cells
        headers = f"*NODE, NSET={body.name}_ALL", f"*ELEMENT, TYPE=C3D10, ELSET={body.name}"
        sets = (("NSET", name, members) for name, members in body.node_sets.items())
        points, tetrahedra = body.points / units.length, body.cells[:, C3D10]
        yield from mesh_lines(headers, points, tetrahedra, sets, body.face_sets, (nodes, cells))
        nodes, cells = nodes + len(body.points), cells + len(body.cells)
    for body in deck.bodies:
        yield from (f"*MATERIAL, NAME=MAT_{body.name}", "*ELASTIC")
        yield f"{number_text(body.material.youngs_modulus / units.stress)}, {number_text(body.material.poissons_ratio)}"
        yield f"*SOLID SECTION, ELSET={body.name}, MATERIAL=MAT_{body.name}"
    references: dict[str, int] = {}
    for section in deck.rigid_sections:
        references[section.name] = nodes
        yield from _section_lines(section, deck, starts, nodes, units)
        nodes += 2
    for body in deck.bodies:
        for first, second, axis in (
            body.nodes_with_equal_displacement + [1, 1, 1] + np.array([1, 1, 0]) * starts[body.name][0]
        ).tolist():
            yield from ("*EQUATION", "2", f"{first}, {axis}, 1.0, {second}, {axis}, -1.0")
    springs = [
        (starts[b.name][0] + int(n), axis) for b in deck.bodies for n in b.nodes_with_weak_springs for axis in range(AXES)
    ]
    springs += [(references[s.name], f) for s in deck.rigid_sections for f in s.freedoms_with_weak_springs]
    yield from _spring_lines(springs, cells, deck.weak_spring_stiffness, units)
    yield from _contact_lines(deck, units)
    yield "*BOUNDARY"
    yield from (f"{name}, 1, 3" for name in deck.fixed_node_sets)
    yield from (f"{name}, 2, 2" for name in deck.symmetry_node_sets)
    yield from _prescribed_motion_lines(deck, references, units, moved=False)
    yield from _step_lines(deck, references, units)


def mesh_lines(
    headers: tuple[str, str],
    points: Array,
    cells: Index,
    sets: Iterable[tuple[str, str, Index]],
    surfaces: Mapping[str, Index],
    earlier: tuple[int, int] = (0, 0),
) -> Iterator[str]:
    """Yield the lines of an input file with the nodes, elements, sets and surfaces of a mesh.

    Parameters
    ----------
    headers : tuple[str, str]
        Lines before the nodes and before the elements, with keyword and parameters.
    points : (n, 3) Array
        Coordinates of the nodes in the unit of the file.
    cells : (m, nodes) Index
        Nodes of the elements, in Abaqus' order.
    sets : Iterable[tuple[str, str, Index]]
        Keyword (NSET or ELSET), name, and nodes or elements of each set.
    surfaces : dict of (k, 3 or 4) Index
        Corners of the faces of each surface, by the surface's name.
    earlier : tuple[int, int], default (0, 0)
        Numbers of nodes and elements before this mesh in the file.
    """
    nodes, elements = earlier
    yield headers[0]
    for k, (x, y, z) in enumerate(points.tolist(), start=nodes + 1):
        yield f"{k}, {number_text(x)}, {number_text(y)}, {number_text(z)}"
    yield headers[1]
    for k, row in enumerate((cells + nodes + 1).tolist(), start=elements + 1):
        yield from comma_separated_lines([k, *row])
    for keyword, name, members in sets:
        yield f"*{keyword}, {keyword}={name}"
        first = 1 + (nodes if keyword == "NSET" else elements)
        yield from (line.removesuffix(",") for line in comma_separated_lines((members + first).tolist()))
    for name, corners in surfaces.items():
        yield f"*SURFACE, NAME={name}, TYPE=ELEMENT"
        for cell, face in cells_and_numbers_of_faces(cells, corners).tolist():
            yield f"{elements + cell + 1}, S{face}"


def _section_lines(
    section: RigidSection, deck: InputDeck, starts: dict[str, tuple[int, int]], reference: int, units: DeckUnits
) -> Iterator[str]:
    """Yield the lines of a rigid section: two reference nodes, and the equation u = t + theta x r of each other node.

    u is the displacement of a node with the position r relative to the section's reference point. The displacements of the
    two reference nodes are the section's translation t and rotation theta. ``starts``: number of nodes and number of
    elements before each body in the deck, by the body's name; ``reference``: largest node number before the two reference
    nodes.
    """
    body = next(b for b in deck.bodies if b.name == section.body_name)
    place = ", ".join(number_text(x) for x in (section.reference_point / units.length).tolist())
    for k, motion in enumerate(("MOVE", "TURN"), start=1):
        yield f"*NODE, NSET={section.name}_{motion}"
        yield f"{reference + k}, {place}"
    first = starts[section.body_name][0]
    for node in body.node_sets[section.node_set].tolist():
        r = (body.points[node] - section.reference_point) / units.length
        for axis in range(AXES):
            b, c = (axis + 1) % AXES, (axis + 2) % AXES
            terms = [(first + node + 1, axis, 1.0), (reference + 1, axis, -1.0)]
            terms += [(reference + 2, b, -r[c]), (reference + 2, c, r[b])]
            yield "*EQUATION"
            yield str(len(terms))
            yield ", ".join(f"{n}, {k + 1}, {number_text(value)}" for n, k, value in terms)


def _spring_lines(springs: Sequence[tuple[int, int]], cells: int, stiffness: float, units: DeckUnits) -> Iterator[str]:
    """Yield the lines of weak springs between nodes and the ground.

    ``springs``: pairs of a node, counted from 0, and a degree of freedom 0 to 5; ``cells``: number of elements before the
    springs; ``stiffness``: stiffness of each spring [N/m]. Degrees of freedom 3 to 5, the rotations of a section, are
    displacements of the section's second reference node.
    """
    for freedom in range(2 * AXES):
        nodes = [node + freedom // AXES + 1 for node, k in springs if k == freedom]
        if nodes:
            axis, turn = freedom % AXES, freedom >= AXES
            name = f"WEAK_{'TURN_' if turn else ''}{'XYZ'[axis]}"
            value = stiffness * WEAK_ARM**2 / units.length if turn else stiffness * units.length
            yield f"*ELEMENT, TYPE=SPRING1, ELSET={name}"
            yield from (f"{cells + k}, {node}" for k, node in enumerate(nodes, start=1))
            yield from (f"*SPRING, ELSET={name}", str(axis + 1), number_text(value))
            cells += len(nodes)


def _prescribed_motion_lines(
    deck: InputDeck, references: dict[str, int], units: DeckUnits, *, moved: bool
) -> Iterator[str]:
    """Yield the lines of the rigid sections' prescribed motions: only zero motions, or (``moved``) only nonzero motions.

    ``references``: largest node number before the two reference nodes of each section, by its name. Abaqus accepts
    prescribed motions other than zero only inside a step.
    """
    for section in deck.rigid_sections:
        for freedom, value in section.prescribed_motion:
            if (value != 0.0) == moved:
                node, axis = references[section.name] + freedom // AXES + 1, freedom % AXES + 1
                tail = f", {number_text(value / units.length if freedom < AXES else value)}" if moved else ""
                yield f"{node}, {axis}, {axis}{tail}"


def _contact_lines(deck: InputDeck, units: DeckUnits) -> Iterator[str]:
    """Yield the lines of an input deck for the frictionless contact law and all contact pairs."""
    yield from ("*SURFACE INTERACTION, NAME=FRICTIONLESS", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR")
    yield number_text(deck.contact_stiffness / units.stress * units.length)
    for slave, master in deck.contact_pairs:
        yield "*CONTACT PAIR, INTERACTION=FRICTIONLESS, TYPE=SURFACE TO SURFACE"
        yield f"{slave}, {master}"


def _step_lines(deck: InputDeck, references: dict[str, int], units: DeckUnits) -> Iterator[str]:
    """Yield the lines of the static step: prescribed motions, loads and requested output.

    ``references``: largest node number before the two reference nodes of each section, by its name.
    """
    yield from (f"*STEP, INC=100{', NLGEOM' if deck.geometrically_nonlinear else ''}", "*STATIC", "1.0, 1.0, 1.0e-6, 1.0")
    yield from ("*CONTROLS, PARAMETERS=TIME INCREMENTATION", PATIENCE)
    moved = list(_prescribed_motion_lines(deck, references, units, moved=True))
    if moved:
        yield from ("*BOUNDARY", *moved)
    for section in deck.rigid_sections:
        place = references[section.name]
        loads = [(k, v if k < AXES else v / units.length) for k, v in enumerate(section.load.tolist()) if v]
        if loads:
            yield "*CLOAD"
            yield from (f"{place + k // AXES + 1}, {k % AXES + 1}, {number_text(v)}" for k, v in loads)
    for slave, master in deck.contact_pairs:
        yield from (f"*CONTACT PRINT, SLAVE={slave}, MASTER={master}", "CFN")
    for section in deck.rigid_sections:
        yield from (f"*NODE PRINT, NSET={section.name}_{motion}\nU" for motion in ("MOVE", "TURN"))
    for body in deck.bodies:
        if len(body.nodes_with_weak_springs):
            yield from (f"*NODE PRINT, NSET={body.name}_WEAK", "U")
    yield from ("*NODE FILE", "U", "*EL FILE", "S", "*END STEP")
