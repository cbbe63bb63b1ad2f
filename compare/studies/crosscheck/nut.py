"""Compliance of a nut by the elements of the 3D reference and by CalculiX: the same mesh, forces and fixed face.

Around every expected contact the corner nodes of the groove's faces move as a rigid section that can turn freely. A unit
force pushes one section after the other along the contact normal. There is no contact: each force takes one linear
solution.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from rollbench.compare.errors import InputError
from rollbench.compare.files import replace_file
from rollbench.compare.studies.crosscheck.deck import DeckOptions, build_deck
from rollbench.compare.studies.crosscheck.results import read_json
from rollbench.compare.studies.crosscheck.study import run_calculix
from rollbench.hifi.elements.forms import assemble, elasticity
from rollbench.hifi.elements.rigid import rigid_modes
from rollbench.hifi.linear_algebra import factor
from rollbench.meshes.arrays import Array
from rollbench.meshes.exchange.deck import UNITS, Deck, DeckBody, RigidSection, deck_text
from rollbench.meshes.fem import mesh_of
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene

#: Scene whose nut is compared, and mesh sizes.
SCENE, MESH = "lin-case1-cut", DeckOptions(b_over_h=0.7, growth=0.8)
#: Target of the agreement [%].
TARGET = 0.1
#: Force on one section in CalculiX [N].
FORCE = 1000.0


@dataclass(frozen=True)
class NutCheck:
    """Compliance of a nut between its contacts by two finite-element programs.

    Entry [i][j] is the displacement along the normal of contact i by a unit force on contact j.
    """

    #: Name of the scene.
    scene: str
    #: Digest of its content.
    key: str
    #: Number of nodes.
    nodes: int
    #: Compliances by the elements of the 3D reference [m/N].
    ours: list[list[float]]
    #: Compliances by CalculiX [m/N].
    theirs: list[list[float]]
    #: Date of the run.
    date: str
    #: Version of CalculiX.
    program: str

    @property
    def difference(self) -> float:
        """Largest difference of a compliance between both programs, over the smallest one under its own force [%]."""
        ours, theirs = np.array(self.ours), np.array(self.theirs)
        return float(100.0 * np.abs(ours - theirs).max() / np.diag(theirs).min())

    def sentence(self) -> str:
        """Return a sentence on the agreement of both programs."""
        met = "within" if self.difference <= TARGET else "NOT within"
        return (
            f"{self.scene}: the nut's compliance between {len(self.ours)} contacts on one mesh of {self.nodes} nodes "
            f"differs by at most {self.difference:.3f} % between the reference's elements and {self.program}, "
            f"{met} {TARGET} %."
        )


def nut_decks(scene: Scene, options: DeckOptions = MESH) -> tuple[list[Deck], Array]:
    """Return one deck of the nut for each of k contacts, with a force on that contact only, then the normals (k, 3).

    ``options``: mesh sizes of the decks. InputError for the faults that `build_deck` refuses.
    """
    whole = build_deck(scene, options).deck
    nut = next(b for b in whole.bodies if b.name == "NUT")
    layout = ball_layout(scene)
    names, centres, normals = [], [], []
    for name, corners in nut.faces.items():
        ball, middle = int(name.rsplit("_", 1)[1]) - 1, nut.points[np.unique(corners)].mean(axis=0)
        phi = float(layout.azimuth[ball])
        away = middle - [*(scene.track.pitch_radius * np.array([np.cos(phi), np.sin(phi)])), float(layout.z[ball])]
        names.append(name)
        centres.append(middle)
        normals.append(away / np.linalg.norm(away))
    patches = {name: np.unique(corners) for name, corners in nut.faces.items()}
    body = replace(nut, nodes={**nut.nodes, **patches}, faces={})
    decks = []
    for pushed in names:
        sections = tuple(
            RigidSection(name, "NUT", name, centre, (), np.append(FORCE * n, np.zeros(3)) * (name == pushed))
            for name, centre, n in zip(names, centres, normals, strict=True)
        )
        head = (f"The nut alone, {FORCE:g} N on {pushed}.",)
        decks.append(replace(whole, bodies=(body,), sections=sections, contacts=(), heading=head, mirrored=()))
    return decks, np.array(normals)


def section_translations(decks: list[Deck]) -> Array:
    """Return the translations of the rigid sections under each deck's force, (decks, sections, 3) [m].

    They are computed by the elements and the solver of the 3D reference. ``decks``: decks that differ only in loads; they
    have one body, no contacts, and sections without fixed degrees of freedom.
    """
    body, sections = decks[0].bodies[0], decks[0].sections
    mesh, number = mesh_of(body.points, body.cells, "P2")
    K = assemble(elasticity(body.material.youngs_modulus, body.material.poissons_ratio), mesh)
    C = _section_transform(body, sections, number, decks[0].fixed)
    loads = np.zeros((C.shape[1], len(decks)))
    count = 6 * len(sections)
    for k, deck in enumerate(decks):
        loads[-count:, k] = np.concatenate([s.load for s in deck.sections])
    moved = factor((C.T @ K @ C).tocsc())(loads)[-count:]
    return np.asarray(moved.reshape(len(sections), 6, len(decks)).transpose(2, 0, 1)[:, :, :3])


def _section_transform(
    body: DeckBody, sections: tuple[RigidSection, ...], number: NDArray[np.int64], fixed: tuple[str, ...]
) -> sp.csc_array:
    """Return the matrix from the free degrees of freedom of a body with rigid sections to all nodal displacements.

    The last columns are the six degrees of freedom of each section. ``number``: number in the mesh of each node of the
    body; ``fixed``: names of fixed node sets.
    """
    free = np.ones(3 * len(body.points), dtype=bool)
    for name in (*fixed, *(s.nodes for s in sections)):
        free[(3 * number[body.nodes[name]][:, None] + np.arange(3)).ravel()] = False
    parts = [sp.eye_array(free.size, format="csc")[:, np.flatnonzero(free)]]
    for s in sections:
        freedoms = (3 * number[body.nodes[s.nodes]][:, None] + np.arange(3)).ravel()
        modes = sp.coo_array(rigid_modes(body.points[body.nodes[s.nodes]], s.point))
        parts.append(sp.csc_array((modes.data, (freedoms[modes.row], modes.col)), (free.size, 6)))
    return sp.hstack(parts, format="csc")


def compare_nut_compliance(scene: Scene, work: Path, options: DeckOptions = MESH, key: str = "") -> NutCheck:
    """Compute the compliance of a scene's nut by the 3D reference's elements and by CalculiX on one mesh.

    ``work``: folder for the runs of CalculiX; ``key``: digest of the scene's content. InputError if CalculiX is missing or
    fails.
    """
    decks, normals = nut_decks(scene, options)
    ours = section_translations(decks)
    theirs, date, version = np.zeros_like(ours), "", ""
    for k, deck in enumerate(decks):
        try:
            found = run_calculix(deck_text(deck, "mm"), work / f"{scene.name}-nut-{k + 1}")
        except ValueError as error:
            raise InputError(
                scene.name, "nut", str(error), "a deck that CalculiX solves", f"see the files in {work}"
            ) from None
        date, version = found.date, found.version
        for i, s in enumerate(deck.sections):
            (moved,) = found.moved[f"{s.name}_MOVE"].values()
            theirs[k, i] = UNITS["mm"].length * np.array(moved)
    along = [(np.einsum("jid,id->ij", x, normals) / FORCE).tolist() for x in (ours, theirs)]
    return NutCheck(scene.name, key, decks[0].node_count, along[0], along[1], date, f"CalculiX {version}")


def save_nut(folder: Path, found: NutCheck) -> Path:
    """Write the compliance of a nut to ``nut.json`` in a folder; InputError if that fails."""
    plain = asdict(found)
    for key in ("ours", "theirs"):
        plain[key] = [[float(f"{x:.8g}") for x in row] for row in plain[key]]
    path = folder / "nut.json"
    replace_file(path, json.dumps(plain, indent=1) + "\n")
    return path


def load_nut(folder: Path) -> NutCheck | None:
    """Return the stored compliance of a nut from a folder; None if there is none, InputError for a damaged file."""
    found = "a result of rollbench crosscheck", "compute the result again by `run=True`"
    return read_json(folder / "nut.json", lambda plain: NutCheck(**plain), *found)
