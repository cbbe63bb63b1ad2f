"""Small scenes by CalculiX (decks written, solved, read), and the compliance of a nut by CalculiX and by the 3D reference.

For the compliance of the nut both programs take the same mesh, forces and fixed face. Around every expected contact the
corner nodes of the groove's mesh faces are coupled to a rigid section that can turn freely. A unit force along the contact
normal is applied to one section after the other. There is no contact: each force takes one linear solution.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.files import replace_file
from rollbench.compare.reference.levels import STUDIED
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.crosscheck import results
from rollbench.compare.studies.crosscheck.deck import DeckOptions, MeshedDeck, build_deck
from rollbench.compare.studies.run_times import utc_date_today
from rollbench.hifi.bodies.coarse import degrees_of_freedom_of_nodes
from rollbench.hifi.elements.forms import elastic_stiffness
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.hifi.linear_algebra import factorise_positive_definite
from rollbench.meshes.arrays import Array
from rollbench.meshes.exchange.deck import UNITS, DeckBody, InputDeck, RigidSection, deck_text
from rollbench.meshes.fem import build_mesh
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.libraries import installed_version
from rollbench.meshes.parts import SIDES, Scene

#: Name of the files of deck and results in their folder.
NAME = "deck"

#: Longest time that CalculiX may take for one deck [s].
LONGEST = 7200.0

#: Components of a vector along x, y, z.
Triple = tuple[float, ...]


@dataclass(frozen=True)
class CalculixResult:
    """Contact forces, displacements and solver data that the program CalculiX wrote for one input deck."""

    #: Resultant contact force on a ball along x, y, z, by the name of the ball's faces in the deck [N].
    forces: dict[str, Triple]
    #: Displacements of those nodes for which the deck requests output, by node set and node, in the unit of the deck.
    node_displacements: dict[str, dict[int, Triple]]
    #: Number of iterations of CalculiX.
    iterations: int
    #: Last correction of the displacements in the iteration [% of the largest displacement].
    correction: float
    #: Processor time of CalculiX [s].
    seconds: float
    #: Date of the solution.
    date: str
    #: Version of CalculiX.
    version: str


def find_calculix_program() -> str:
    """Return the path of the program CalculiX (ccx); InputError if CalculiX is not installed."""
    found = shutil.which("ccx")
    if found is None:
        advice = "install it (Debian: apt-get install calculix-ccx), or leave `run` out"
        raise InputError("this machine", "ccx", "no such program", "CalculiX on the path", advice)
    return found


def installed_calculix_version(program: str) -> str:
    """Return the version that the program CalculiX reports, or "unknown".

    ``program``: path of the program.
    """
    text = subprocess.run([program, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"[Vv]ersion\s+(\S+)", text)
    return found.group(1) if found else "unknown"


def deck_digest(text: str) -> str:
    """Return a digest (hash value, 16 hexadecimal digits) of a deck's text without comments and solver controls."""
    content, control = [], False
    for line in text.splitlines():
        if line.startswith("*") and not line.startswith("**"):
            control = line.startswith("*CONTROLS")
        if not (control or line.startswith("**")):
            content.append(line)
    return hashlib.sha256("\n".join(content).encode()).hexdigest()[:16]


def solve_deck_or_read_result(text: str, folder: Path) -> CalculixResult:
    """Solve an input deck with CalculiX in a folder, or read the results there if they belong to an equal deck.

    ``text``: text of the deck. CalculiX uses one thread. Raises InputError if CalculiX is missing, and ValueError with
    its last output if it does not converge.
    """
    program, key = find_calculix_program(), deck_digest(text)
    kept = folder / "run.json"
    try:
        facts = json.loads(kept.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        facts = {}
    if facts.get("deck") != key:
        facts = {"deck": key, **_solve_deck(program, text, folder)}
        kept.write_text(json.dumps(facts), encoding="utf-8")
    forces, moved = read_forces_and_displacements((folder / f"{NAME}.dat").read_text(encoding="ascii"))
    iterations, correction = read_iterations_and_correction((folder / f"{NAME}.cvg").read_text(encoding="ascii"))
    return CalculixResult(forces, moved, iterations, correction, facts["seconds"], facts["date"], facts["version"])


def _solve_deck(program: str, text: str, folder: Path) -> dict[str, Any]:
    """Run CalculiX on an input deck in a folder; return the processor time [s], the date and the version of CalculiX.

    ``program``: path of CalculiX; ``text``: text of the deck. Raises ValueError if it fails or takes longer than `LONGEST`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{NAME}.inp").write_text(text, encoding="ascii")
    for old in folder.glob(f"{NAME}.[dcfs]*"):
        old.unlink()
    before = os.times()
    try:
        command = [program, "-i", NAME]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        raise ValueError(f"CalculiX took longer than {LONGEST:.0f} s") from None
    after = os.times()
    if done.returncode or "*ERROR" in done.stdout or "Job finished" not in done.stdout:
        faults = [line.strip() for line in done.stdout.splitlines() if "*ERROR" in line] or done.stdout.split("\n")[-3:]
        raise ValueError(f"CalculiX failed (code {done.returncode}): {' '.join(faults[:3])}")
    seconds = after.children_user + after.children_system - before.children_user - before.children_system
    elapsed = after.elapsed - before.elapsed  # where children are not accounted for (Windows); of one thread, too
    return {"seconds": seconds or elapsed, "date": utc_date_today(), "version": installed_calculix_version(program)}


def read_forces_and_displacements(text: str) -> tuple[dict[str, Triple], dict[str, dict[int, Triple]]]:
    """Return contact forces and displacements of the last time step from the text of a .dat file of CalculiX.

    The first dictionary has the contact force along x, y, z by the name of the ball's faces. The second has the
    displacement along x, y, z by node set and number of the node. Forces and displacements are in the units of the
    deck.
    """
    forces: dict[str, Triple] = {}
    moved: dict[str, dict[int, Triple]] = {}
    head = re.compile(r"(?:statistics for slave set (\S+), master|displacements .* for set (\S+) and time).*")
    ends = [*(m.start() for m in head.finditer(text)), len(text)]
    for found, end in zip(head.finditer(text), ends[1:], strict=True):
        rows = [line.split() for line in text[found.end() : end].splitlines() if re.match(r"\s+[-\d]", line)]
        if found[1]:
            forces[found[1]] = tuple(map(float, rows[0][:3]))
        else:
            moved[found[2]] = {int(node): tuple(map(float, x)) for node, *x in rows}
    return forces, moved


def read_iterations_and_correction(text: str) -> tuple[int, float]:
    """Return the number of iterations of all increments, and the last correction over the largest displacement [%].

    ``text``: text of a .cvg file of CalculiX. A linear step has no entry in this file and counts as one iteration.
    """
    rows = [line.split() for line in text.splitlines() if re.match(r"\s+\d+\s+\d+\s+\d+\s+\d+", line)]
    return (len(rows), float(rows[-1][6])) if rows else (1, 0.0)


#: Unit of length of the decks.
UNIT = "mm"


def _deck_options(*rows: tuple[float, float, float], half: bool = False, alike: bool = False) -> list[DeckOptions]:
    """Return the options of several CalculiX decks that differ in mesh sizes and contact stiffness.

    ``rows``: for each deck the elements across the minor semi-axis, growth of the element size, and contact stiffness
    [N/mm3]; ``half`` and ``alike``: fields of `DeckOptions`, equal for all decks.
    """
    return [DeckOptions(b, g, 1e9 * k, half=half, alike=alike) for b, g, k in rows]


#: Decks of every scene that is checked. Element size at the contacts and growth are varied one by one on coarse meshes, and
#: refined together (b/h times growth 0.48) on half bodies and on balls that have the same mesh. Further decks vary the
#: contact stiffness, or take large displacements into account.
STUDIES: dict[str, list[DeckOptions]] = {
    "two-balls": [
        *_deck_options((0.6, 0.8, 2e8), (0.8, 0.6, 2e8), (1.2, 0.4, 2e8), (1.1, 0.6, 2e8)),
        *_deck_options((1.5, 0.6, 2e8), (1.1, 0.8, 2e8), (0.8, 0.4, 2e8), (0.8, 0.6, 1e9)),
        DeckOptions(0.6, 0.8, 2e17, nlgeom=True),
        *_deck_options((0.6, 0.8, 2e8), (0.8, 0.6, 2e8), (1.2, 0.4, 2e8), (1.6, 0.3, 2e8), (1.92, 0.25, 2e8), half=True),
    ],
    "lin-case1-cut": [
        *_deck_options((0.8, 0.8, 2e8), (1.1, 0.8, 2e8), (0.8, 0.6, 2e8), (1.1, 0.6, 2e8), (0.8, 0.8, 1e9)),
        *_deck_options((1.2, 0.4, 2e8), alike=True),
    ],
}


def deck_folder_name(options: DeckOptions) -> str:
    """Return the name of the folder in which CalculiX solves a deck; the name states the options of the deck."""
    tail = "-nlgeom" * options.nlgeom + "-half" * options.half + "-alike" * options.alike
    return f"bh{options.b_over_h:g}-g{options.growth:g}-k{1e-9 * options.stiffness:g}{tail}"


def digest_of_shipped_scene(name: str) -> str:
    """Return the digest of a scene of the package, by which stored CalculiX results are recognised as those of this scene.

    Remarks in the scene file do not change the digest. ``name``: name of the scene.
    """
    content = {k: v for k, v in tomllib.loads(catalogue.shipped_scene_text(name)).items() if k not in ("source", "assumed")}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def scene_compared_with_calculix(name: str) -> Scene:
    """Return a scene of the package that is compared with CalculiX; raise InputError for other names."""
    if name not in STUDIES:
        raise ArgumentError("scene", name, ", ".join(STUDIES), "choose one of these")
    return catalogue.scene(name)


def solve_decks_of_scene(
    scene: Scene, deck_folder: Path, step: Callable[[str], None], stored: Sequence[results.CalculixRun] = ()
) -> results.CalculixRunsOfScene:
    """Solve all decks of a scene with CalculiX one after the other, each in a folder of its own below ``deck_folder``.

    ``step``: function that is called with each line of progress; ``stored``: known solutions. A deck is not solved again if
    its folder or the stored solutions have a solution with the same digest. Raises InputError if CalculiX is missing or
    fails.
    """
    runs, known = [], {r.deck: r for r in stored}
    for options in STUDIES[scene.name]:
        meshed, name = build_deck(scene, options), deck_folder_name(options)
        text = deck_text(meshed.deck, UNIT)
        digest = deck_digest(text)
        if digest in known:
            runs.append(known[digest])
            step(f"{name}: stored")
            continue
        try:
            outcome = solve_deck_or_read_result(text, deck_folder / scene.name / name)
            runs.append(calculix_run_record(meshed, options, digest, outcome))
        except ValueError as error:
            raise _unsolved_deck_error(scene, name, error, "its folder") from None
        step(f"{name}: {meshed.deck.node_count} nodes, {outcome.iterations} iterations, {outcome.seconds:.0f} s")
    key, gmsh = digest_of_shipped_scene(scene.name), installed_version("gmsh") or ""
    return results.CalculixRunsOfScene(scene.name, key, __version__, gmsh, tuple(runs))


def _unsolved_deck_error(scene: Scene, deck: str, error: ValueError, folder: str) -> InputError:
    """Return the error that says why CalculiX did not solve a deck of a scene, and in which ``folder`` its output is."""
    return InputError(scene.name, deck, str(error), "a deck that CalculiX solves", f"see the output files in {folder}")


def calculix_run_record(
    meshed: MeshedDeck, options: DeckOptions, deck: str, outcome: CalculixResult
) -> results.CalculixRun:
    """Return the results of one CalculiX solution as the record that is stored.

    ``meshed``: the deck with its meshes; ``options``: options of the deck; ``deck``: digest of the deck's text;
    ``outcome``: results of CalculiX. Raises ValueError if the results of a contact are missing.
    """
    mirror = np.array([2.0, 0.0, 2.0]) if options.half else np.ones(3)  # with its mirror image
    forces = {slave: mirror * np.array(force) for slave, force in outcome.forces.items()}
    count = len(meshed.expected_loads)
    load, resultant = np.zeros((count, len(SIDES))), np.zeros((count, 3))
    for faces, _ in meshed.deck.contact_pairs:
        if faces not in forces:
            raise ValueError(
                f"CalculiX printed no contact force for the faces {faces}: every contact of the deck needs one"
            )
        ball, side = faces.removeprefix("BALL").split("_")
        load[int(ball) - 1, SIDES.index(side)] = np.linalg.norm(forces[faces])
        resultant[int(ball) - 1] += forces[faces]
    spring = options.spring * UNITS[UNIT].length
    weak = [list(outcome.node_displacements[f"BALL{i + 1}_WEAK"].values()) for i in range(count)]
    held = np.array([mirror * spring * np.sum(nodes, axis=0) for nodes in weak])
    loose = np.linalg.norm(resultant - held, axis=1)  # what is printed acts on the slave, the ball
    worst = meshed.smallest_jacobians
    meshes = (results.BodyMesh(b.name, len(b.points), len(b.cells), worst[b.name]) for b in meshed.deck.bodies)
    return results.CalculixRun(
        **vars(options),
        fine=meshed.contact_element_size,
        deck=deck,
        meshes=tuple(meshes),
        load=load,
        weak=float(np.linalg.norm(held, axis=1).max()),
        unbalanced=float(loose.max()),
        **{name: getattr(outcome, name) for name in ("iterations", "correction", "seconds", "date")},
        program=f"CalculiX {outcome.version}",
    )


def scenes_and_levels_for_report(fresh: bool) -> Iterator[tuple[tuple[str, ...], tuple[int, ...]]]:  # noqa: ARG001 - as every such function
    """Yield the scenes that the report compares with CalculiX, and the mesh levels of the 3D reference that it needs.

    ``fresh``: not used; the report calls all functions of this kind with it.
    """
    yield tuple(STUDIES), STUDIED


#: Name of the scene whose nut is compared, and mesh sizes of its decks.
NUT_SCENE, NUT_MESH = "lin-case1-cut", DeckOptions(b_over_h=0.7, growth=0.8)
#: Largest allowed difference between both programs [%].
NUT_TARGET = 0.1
#: Force on one section in CalculiX [N].
SECTION_FORCE = 1000.0


@dataclass(frozen=True)
class NutComplianceComparison:
    """Compliance of a nut between its contacts by two programs: the 3D reference ("ours") and CalculiX ("theirs").

    Entry [i][j] is the displacement along the normal of contact i by a unit force on contact j.
    """

    #: Name of the scene.
    scene: str
    #: Digest (hash value) of the scene's content.
    key: str
    #: Number of nodes of the nut's mesh.
    nodes: int
    #: Compliance matrix of the nut between its contacts, by the elements of the 3D reference [m/N].
    ours: list[list[float]]
    #: Compliance matrix of the nut between its contacts, by CalculiX [m/N].
    theirs: list[list[float]]
    #: Date of the solution.
    date: str
    #: Version of CalculiX.
    program: str

    @property
    def difference(self) -> float:
        """Largest difference of a compliance between both programs [% of the smallest diagonal entry of the matrix]."""
        ours, theirs = np.array(self.ours), np.array(self.theirs)
        return float(100.0 * np.abs(ours - theirs).max() / np.diag(theirs).min())

    def sentence_on_agreement(self) -> str:
        """Return a sentence that states the largest difference of the nut's compliance between both programs."""
        met = "within" if self.difference <= NUT_TARGET else "NOT within"
        return (
            f"{self.scene}: the nut's compliance between {len(self.ours)} contacts on one mesh of {self.nodes} nodes "
            f"differs by at most {self.difference:.3f} % between the reference's elements and {self.program}, "
            f"{met} {NUT_TARGET} %."
        )


def nut_decks_loaded_at_one_contact(scene: Scene, options: DeckOptions = NUT_MESH) -> tuple[list[InputDeck], Array]:
    """Return k CalculiX decks of the nut, each loaded at one of its k contacts only, and the contact normals (k, 3).

    ``options``: mesh sizes of the decks. Raises InputError for scenes that `build_deck` refuses.
    """
    whole = build_deck(scene, options).deck
    nut = next(b for b in whole.bodies if b.name == "NUT")
    layout = ball_layout(scene)
    patches = {name: np.unique(corners) for name, corners in nut.face_sets.items()}
    centres, normals = [], []
    for name, nodes in patches.items():
        ball, middle = int(name.rsplit("_", 1)[1]) - 1, nut.points[nodes].mean(axis=0)
        phi = float(layout.azimuth[ball])
        away = middle - [*(scene.track.pitch_radius * np.array([np.cos(phi), np.sin(phi)])), float(layout.z[ball])]
        centres.append(middle)
        normals.append(away / np.linalg.norm(away))
    body = replace(nut, node_sets={**nut.node_sets, **patches}, face_sets={})
    alone = replace(whole, bodies=(body,), contact_pairs=(), symmetry_node_sets=())
    decks = []
    for pushed in patches:
        sections = tuple(
            RigidSection(name, "NUT", name, centre, (), np.append(SECTION_FORCE * n, np.zeros(3)) * (name == pushed))
            for name, centre, n in zip(patches, centres, normals, strict=True)
        )
        head = (f"The nut alone, {SECTION_FORCE:g} N on {pushed}.",)
        decks.append(replace(alone, rigid_sections=sections, comment_lines=head))
    return decks, np.array(normals)


def rigid_section_translations(decks: list[InputDeck]) -> Array:
    """Return the translations (decks, sections, 3) [m] of rigid sections under the forces of each deck, without CalculiX.

    The translations are computed by the elements and the linear solver of the 3D reference. ``decks``: decks that
    differ only in loads; they have one body, no contacts, and sections without fixed degrees of freedom.
    """
    body, sections = decks[0].bodies[0], decks[0].rigid_sections
    mesh, number = build_mesh(body.points, body.cells, "P2")
    K = elastic_stiffness(mesh, body.material.youngs_modulus, body.material.poissons_ratio)
    C = _matrix_of_rigid_sections(body, sections, number, decks[0].fixed_node_sets)
    loads = np.zeros((C.shape[1], len(decks)))
    count = 6 * len(sections)
    for k, deck in enumerate(decks):
        loads[-count:, k] = np.concatenate([s.load for s in deck.rigid_sections])
    moved = factorise_positive_definite((C.T @ K @ C).tocsc())(loads)[-count:]
    return np.asarray(moved.reshape(len(sections), 6, len(decks)).transpose(2, 0, 1)[:, :, :3])


def _matrix_of_rigid_sections(
    body: DeckBody, sections: tuple[RigidSection, ...], number: NDArray[np.int64], fixed: tuple[str, ...]
) -> sp.csc_array:
    """Return the matrix that converts free degrees of freedom of a body and its rigid sections to nodal displacements.

    The last columns belong to the six degrees of freedom of each rigid section. ``number``: number in the
    finite-element mesh of each node of the body; ``fixed``: names of the fixed node sets.
    """
    freedoms_of = {name: degrees_of_freedom_of_nodes(number[nodes]) for name, nodes in body.node_sets.items()}
    free = np.ones(3 * len(body.points), dtype=bool)
    for name in (*fixed, *(s.node_set for s in sections)):
        free[freedoms_of[name]] = False
    parts = [sp.eye_array(free.size, format="csc")[:, np.flatnonzero(free)]]
    for s in sections:
        freedoms, points = freedoms_of[s.node_set], body.points[body.node_sets[s.node_set]]
        modes = sp.coo_array(nodal_displacements_of_rigid_motions(points, s.reference_point))
        parts.append(sp.csc_array((modes.data, (freedoms[modes.row], modes.col)), (free.size, 6)))
    return sp.hstack(parts, format="csc")


def compare_nut_compliance(
    scene: Scene, deck_folder: Path, options: DeckOptions = NUT_MESH, key: str = ""
) -> NutComplianceComparison:
    """Compute the compliance of a nut by the elements of the 3D reference and by CalculiX, on the same mesh.

    ``deck_folder``: folder in which CalculiX solves its decks; ``options``: mesh sizes; ``key``: digest of the scene's
    content. Raises InputError if CalculiX is missing or fails.
    """
    decks, normals = nut_decks_loaded_at_one_contact(scene, options)
    ours = rigid_section_translations(decks)
    theirs, date, version = np.zeros_like(ours), "", ""
    for k, deck in enumerate(decks):
        try:
            found = solve_deck_or_read_result(deck_text(deck, "mm"), deck_folder / f"{scene.name}-nut-{k + 1}")
        except ValueError as error:
            raise _unsolved_deck_error(scene, "deck of the nut", error, str(deck_folder)) from None
        date, version = found.date, found.version
        for i, s in enumerate(deck.rigid_sections):
            (moved,) = found.node_displacements[f"{s.name}_MOVE"].values()
            theirs[k, i] = UNITS["mm"].length * np.array(moved)
    along = [(np.einsum("jid,id->ij", x, normals) / SECTION_FORCE).tolist() for x in (ours, theirs)]
    return NutComplianceComparison(scene.name, key, decks[0].node_count, along[0], along[1], date, f"CalculiX {version}")


def save_nut_compliance(folder: Path, comparison: NutComplianceComparison) -> Path:
    """Write the compliance of a nut by both programs to ``nut.json`` in a folder; return the path.

    Raises InputError if the file cannot be written.
    """
    plain = asdict(comparison)
    for key in ("ours", "theirs"):
        plain[key] = [[float(f"{x:.8g}") for x in row] for row in plain[key]]
    path = folder / "nut.json"
    replace_file(path, json.dumps(plain, indent=1) + "\n")
    return path


def load_nut_compliance(folder: Path) -> NutComplianceComparison | None:
    """Return the stored compliance of a nut by both programs from a folder; None if it is not stored.

    Raises InputError for a damaged file.
    """
    found = "a result of rollbench crosscheck", "compute the result again by `run=True`"
    return results.read_object_from_json(folder / "nut.json", lambda plain: NutComplianceComparison(**plain), *found)
