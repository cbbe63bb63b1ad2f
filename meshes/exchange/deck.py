"""A whole contact problem as one input deck that CalculiX runs and Abaqus reads.

Only keywords that both programs know, one step, static, small strains. Bodies of ten-node tetrahedra, named sets and
faces, surface-to-surface contact without friction and with a linear pressure-overclosure law, rigid sections by linear
equations, weak springs to the ground. Lines have at most 16 entries, entries at most 20 characters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.parts import Material

#: Corners of the faces S1 to S4 of a tetrahedron, and S1 to S6 of a hexahedron.
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
HEX_FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
#: gmsh's node at every place of a C3D10.
C3D10 = (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)
LONGEST_NAME = 80
AXES = 3
#: Iterations before a step is cut, instead of the usual 4, 8, 9, 16: contact under preload takes about 25.
PATIENCE = "30, 40, 9, 60"
#: Arm [m] at which the springs of rotations act.
WEAK_ARM = 1e-3


@dataclass(frozen=True)
class Units:
    """Units of a deck; forces are in N."""

    #: Unit of length [m].
    length: float
    #: Unit of stress [Pa].
    stress: float
    #: Names of the units, for the heading.
    words: str


UNITS = {"mm": Units(1e-3, 1e6, "mm, N, MPa"), "m": Units(1.0, 1.0, "m, N, Pa")}


@dataclass(frozen=True)
class DeckBody:
    """A body of second-order tetrahedra."""

    #: Name of its element set.
    name: str
    #: Nodes ``(n, 3)`` [m].
    points: Array
    #: Tetrahedra ``(m, 10)``, in gmsh's order.
    cells: Index
    #: Elastic material.
    material: Material
    #: Sets of nodes by name.
    nodes: dict[str, Index] = field(default_factory=dict)
    #: Sets of faces by name, as their corners ``(k, 3)``.
    faces: dict[str, Index] = field(default_factory=dict)
    #: Nodes on weak springs to the ground.
    weak: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    #: Two nodes and an axis along which their displacements are equal ``(k, 3)``: keeps a body from turning without
    #: fixing it elsewhere.
    alike: Index = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))


@dataclass(frozen=True)
class RigidSection:
    """A set of nodes of a body that moves as a rigid section."""

    #: Name of the section.
    name: str
    #: Name of the body.
    body: str
    #: Name of the set of nodes.
    nodes: str
    #: Reference point ``(3,)`` [m], on the axis.
    point: Array
    #: Pairs of a freedom (0 to 5) and its prescribed displacement [m] or small rotation [rad].
    held: tuple[tuple[int, float], ...]
    #: Force [N] and moment [N m] ``(6,)``.
    load: Array
    #: Freedoms on weak springs to the ground.
    weak: tuple[int, ...] = ()


@dataclass(frozen=True)
class Contact:
    """Pair of surfaces that may touch."""

    #: Name of the slave's set of faces.
    slave: str
    #: Name of the master's set of faces.
    master: str


@dataclass(frozen=True)
class Deck:
    """Contents of a deck."""

    #: All bodies.
    bodies: tuple[DeckBody, ...]
    #: Rigid sections.
    sections: tuple[RigidSection, ...]
    #: Sets of nodes that are fixed in all directions.
    fixed: tuple[str, ...]
    #: Surfaces that may touch.
    contacts: tuple[Contact, ...]
    #: Contact pressure per overclosure [Pa/m].
    stiffness: float
    #: Stiffness of every weak spring [N/m].
    spring: float
    #: Lines of comment.
    heading: tuple[str, ...]
    #: Title of the model.
    title: str
    #: Whether displacements are large.
    nlgeom: bool = False
    #: Sets of nodes that are fixed along y, on a plane of symmetry.
    mirrored: tuple[str, ...] = ()

    @property
    def node_count(self) -> int:
        """Number of nodes of all bodies."""
        return sum(len(b.points) for b in self.bodies)


def deck_number(value: float) -> str:
    """Write a number in at most 20 characters, the most that CalculiX reads.

    Examples
    --------
    >>> deck_number(-1.2345678901234567e-105), len(deck_number(-1.2345678901234567e-105))
    ('-1.234567890123e-105', 20)
    """
    return f"{value:.12e}"


def data_lines(entries: Iterable[int | str]) -> Iterator[str]:
    """Entries with commas, at most 16 on a line; a line that is continued ends with a comma.

    Examples
    --------
    >>> list(data_lines(range(18)))
    ['0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,', '16, 17']
    """
    words = [str(x) for x in entries]
    for k in range(0, len(words), 16):
        yield ", ".join(words[k : k + 16]) + ("," if k + 16 < len(words) else "")


def set_lines(entries: Iterable[int]) -> Iterator[str]:
    """Entries with commas as `data_lines`, for sets, which continue without a comma."""
    return (line.removesuffix(",") for line in data_lines(entries))


def checked_names(names: Sequence[str]) -> None:
    """Raise ValueError for a name that is too long, has blanks or commas, or comes twice but for its case."""
    seen = set[str]()
    for name in names:
        if not name or len(name) > LONGEST_NAME or not name.isascii() or any(c in " ,=*" for c in name):
            raise ValueError(f"set {name!r}: a name in a deck has 1 to {LONGEST_NAME} letters, digits or underscores")
        if name.upper() in seen:
            raise ValueError(f"set {name!r} comes twice: names in a deck do not distinguish capitals")
        seen.add(name.upper())


def element_faces(cells: Index, corners: Index) -> Index:
    """Cells and face numbers of faces that are given by their corners.

    Parameters
    ----------
    cells : (m, nodes) Index
        Tetrahedra or hexahedra.
    corners : (k, 3 or 4) Index
        Corners of the faces; four where cells are hexahedra.

    Returns
    -------
    (k, 2) Index
        Cell, and number of its face (from 1).

    Raises
    ------
    ValueError
        A face belongs to no cell.
    """
    faces = np.array(FACES if corners.shape[1] == 3 else HEX_FACES)
    table = np.sort(cells[:, faces].reshape(-1, corners.shape[1]), axis=1)
    count = int(cells.max(initial=0)) + 1
    base = np.array([count * count, count, 1])  # three corners name a face of a mesh
    keys, wanted = table[:, :3] @ base, np.sort(corners, axis=1)[:, :3] @ base
    order = np.argsort(keys, kind="stable")
    place = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
    if not np.array_equal(keys[place], wanted):
        raise ValueError("a face of a deck's surface belongs to no cell")
    return np.stack([place // len(faces), place % len(faces) + 1], axis=1)


def outer_faces(cells: Index) -> Index:
    """Faces that belong to only one cell.

    Parameters
    ----------
    cells : (m, 10) Index
        Tetrahedra; their first four nodes are corners.

    Returns
    -------
    (k, 3) Index
        Corners of the faces.
    """
    faces = cells[:, np.array(FACES)].reshape(-1, 3)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[count == 1])])


def deck_text(deck: Deck, unit: str = "mm") -> str:
    """Text of a deck.

    Parameters
    ----------
    deck : Deck
        Contents.
    unit : str, default 'mm'
        Unit of length, ``"mm"`` or ``"m"``.

    Returns
    -------
    str
        ASCII text.

    Raises
    ------
    ValueError
        A name is bad or comes twice.
    """
    text = "\n".join(_deck_lines(deck, UNITS[unit])) + "\n"
    return text.encode("ascii", "replace").decode("ascii")


def _deck_lines(deck: Deck, units: Units) -> Iterator[str]:
    names = [n for b in deck.bodies for n in (f"{b.name}_ALL", *b.nodes, *b.faces)]
    ends = [f"{s.name}_{what}" for s in deck.sections for what in ("MOVE", "TURN")]
    checked_names([*(b.name for b in deck.bodies), *names, *ends])
    yield "*HEADING"
    yield deck.title[:80]
    yield from (f"** {line}" for line in (*deck.heading, f"Units: {units.words}"))
    starts: dict[str, tuple[int, int]] = {}
    nodes = cells = 0
    for body in deck.bodies:
        starts[body.name] = nodes, cells
        yield from _body_lines(body, nodes, cells, units)
        nodes, cells = nodes + len(body.points), cells + len(body.cells)
    for body in deck.bodies:
        yield from (f"*MATERIAL, NAME=MAT_{body.name}", "*ELASTIC")
        yield f"{deck_number(body.material.youngs_modulus / units.stress)}, {deck_number(body.material.poissons_ratio)}"
        yield f"*SOLID SECTION, ELSET={body.name}, MATERIAL=MAT_{body.name}"
    references: dict[str, int] = {}
    for section in deck.sections:
        references[section.name] = nodes
        yield from _section_lines(section, deck, starts, nodes, units)
        nodes += 2
    for body in deck.bodies:
        for first, second, axis in (body.alike + [1, 1, 1] + np.array([1, 1, 0]) * starts[body.name][0]).tolist():
            yield from ("*EQUATION", "2", f"{first}, {axis}, 1.0, {second}, {axis}, -1.0")
    springs = [(starts[b.name][0] + int(n), axis) for b in deck.bodies for n in b.weak for axis in range(AXES)]
    springs += [(references[s.name], f) for s in deck.sections for f in s.weak]
    yield from _spring_lines(springs, cells, deck.spring, units)
    yield from _contact_lines(deck, units)
    yield "*BOUNDARY"
    yield from (f"{name}, 1, 3" for name in deck.fixed)
    yield from (f"{name}, 2, 2" for name in deck.mirrored)
    yield from _motion_lines(deck, references, units, moved=False)
    yield from _step_lines(deck, references, units)


def _body_lines(body: DeckBody, nodes: int, cells: int, units: Units) -> Iterator[str]:
    yield f"*NODE, NSET={body.name}_ALL"
    for k, x in enumerate((body.points / units.length).tolist(), start=nodes + 1):
        yield f"{k}, {deck_number(x[0])}, {deck_number(x[1])}, {deck_number(x[2])}"
    yield f"*ELEMENT, TYPE=C3D10, ELSET={body.name}"
    for k, row in enumerate((body.cells[:, C3D10] + nodes + 1).tolist(), start=cells + 1):
        yield from data_lines([k, *row])
    for name, members in body.nodes.items():
        yield f"*NSET, NSET={name}"
        yield from set_lines((members + nodes + 1).tolist())
    for name, corners in body.faces.items():
        yield f"*SURFACE, NAME={name}, TYPE=ELEMENT"
        yield from (f"{cell + cells + 1}, S{face}" for cell, face in element_faces(body.cells, corners).tolist())


def _section_lines(
    section: RigidSection, deck: Deck, starts: dict[str, tuple[int, int]], reference: int, units: Units
) -> Iterator[str]:
    """Two nodes, whose displacements are the section's translation and rotation, and u = t + theta x r of all others."""
    body = next(b for b in deck.bodies if b.name == section.body)
    place = ", ".join(deck_number(x) for x in (section.point / units.length).tolist())
    for k, motion in enumerate(("MOVE", "TURN"), start=1):
        yield f"*NODE, NSET={section.name}_{motion}"
        yield f"{reference + k}, {place}"
    first = starts[section.body][0]
    for node in body.nodes[section.nodes].tolist():
        r = (body.points[node] - section.point) / units.length
        for axis in range(AXES):
            b, c = (axis + 1) % AXES, (axis + 2) % AXES
            terms = [(first + node + 1, axis, 1.0), (reference + 1, axis, -1.0)]
            terms += [(reference + 2, b, -r[c]), (reference + 2, c, r[b])]
            yield "*EQUATION"
            yield str(len(terms))
            yield ", ".join(f"{n}, {k + 1}, {deck_number(value)}" for n, k, value in terms)


def _spring_lines(springs: Sequence[tuple[int, int]], cells: int, stiffness: float, units: Units) -> Iterator[str]:
    """Weak springs at (node from 0, freedom): a section's rotations are the displacements of its second node."""
    for freedom in range(2 * AXES):
        nodes = [node + freedom // AXES + 1 for node, k in springs if k == freedom]
        if nodes:
            axis, turn = freedom % AXES, freedom >= AXES
            name = f"WEAK_{'TURN_' if turn else ''}{'XYZ'[axis]}"
            value = stiffness * WEAK_ARM**2 / units.length if turn else stiffness * units.length
            yield f"*ELEMENT, TYPE=SPRING1, ELSET={name}"
            yield from (f"{cells + k}, {node}" for k, node in enumerate(nodes, start=1))
            yield from (f"*SPRING, ELSET={name}", str(axis + 1), deck_number(value))
            cells += len(nodes)


def _motion_lines(deck: Deck, references: dict[str, int], units: Units, *, moved: bool) -> Iterator[str]:
    """Return the prescribed motions of the sections: zero or, if ``moved``, nonzero (Abaqus: only inside a step)."""
    for section in deck.sections:
        for freedom, value in section.held:
            if (value != 0.0) == moved:
                node, axis = references[section.name] + freedom // AXES + 1, freedom % AXES + 1
                tail = f", {deck_number(value / units.length if freedom < AXES else value)}" if moved else ""
                yield f"{node}, {axis}, {axis}{tail}"


def _contact_lines(deck: Deck, units: Units) -> Iterator[str]:
    yield from ("*SURFACE INTERACTION, NAME=FRICTIONLESS", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR")
    yield deck_number(deck.stiffness / units.stress * units.length)
    for contact in deck.contacts:
        yield "*CONTACT PAIR, INTERACTION=FRICTIONLESS, TYPE=SURFACE TO SURFACE"
        yield f"{contact.slave}, {contact.master}"


def _step_lines(deck: Deck, references: dict[str, int], units: Units) -> Iterator[str]:
    yield from (f"*STEP, INC=100{', NLGEOM' if deck.nlgeom else ''}", "*STATIC", "1.0, 1.0, 1.0e-6, 1.0")
    yield from ("*CONTROLS, PARAMETERS=TIME INCREMENTATION", PATIENCE)
    moved = list(_motion_lines(deck, references, units, moved=True))
    if moved:
        yield from ("*BOUNDARY", *moved)
    for section in deck.sections:
        place = references[section.name]
        loads = [(k, v if k < AXES else v / units.length) for k, v in enumerate(section.load.tolist()) if v]
        if loads:
            yield "*CLOAD"
            yield from (f"{place + k // AXES + 1}, {k % AXES + 1}, {deck_number(v)}" for k, v in loads)
    for contact in deck.contacts:
        yield from (f"*CONTACT PRINT, SLAVE={contact.slave}, MASTER={contact.master}", "CFN")
    for section in deck.sections:
        yield from (f"*NODE PRINT, NSET={section.name}_{motion}\nU" for motion in ("MOVE", "TURN"))
    for body in deck.bodies:
        if len(body.weak):
            yield from (f"*NODE PRINT, NSET={body.name}_WEAK", "U")
    yield from ("*NODE FILE", "U", "*EL FILE", "S", "*END STEP")
