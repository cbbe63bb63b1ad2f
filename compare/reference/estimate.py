"""The 3D reference of a scene: contact loads of the finest stored run, and their uncertainty due to the mesh.

The uncertainty has a part for each kind of refinement.

From one mesh level to the next, the cells at the contact are refined by 4/3, those of the bodies by 1.15, and the mesh of
the refinement boxes (blocks below the contacts, into which finely meshed patches fit) not at all. Therefore no order
of convergence in a single cell size describes the loads. The loads do not approach a limit from one side either.
Consecutive changes of a contact load have a correlation of -0.5, like independent errors, because no cell of one level's
mesh is a cell of the next. Extrapolation with any order increases the distance to the next level
(tests/unit/models/test_grid_coverage.py). The errors of a level are therefore treated as scatter with the variance

    s^2 = contact^2 h_c^4 + bodies^2 h_b^4 + boxes^2 + common^2,

where contact, bodies, boxes and common are standard deviations of a contact load [% of the mean load] due to the cells at
the contact, the cells of the bodies, the refinement boxes, and a cause common to all contacts; h_c and h_b are the cell
sizes of contact and bodies over those of the finest level (second-order cells, whose errors fall as h^2). The first two
parts are determined from the changes between the levels of the scene; the variance of a change is the sum of those of two
levels. The part boxes is measured by a separate run with more finely meshed refinement boxes. The part common changes all
loads of a level alike and does not average out over the contacts of one scene. It is determined from the mean changes of
all scenes with loads on both flanks of the screw, where equilibrium does not fix the sum of the loads.

The uncertainty is twice the root of the sum of the variances of the finest level and the next one, or 2.2 times this root
if only the change between two neighbouring levels is known. In 95 % of the contacts it covers the change to a finer mesh.
Errors of bodies and refinement boxes are displacements. A contact converts these to loads by its stiffness, dF / dx ~
F^(1/3) (Hertz), and these two parts are distributed over the contacts accordingly. Errors that all meshes share are not
included (`compare.models.uncertainty`).

Near a free face of the nut, a mesh level neglects a part of a contact's compliance. The local compliance of a contact is
that of a finely meshed piece of its body (`hifi.bodies.coarse`), far from any face. Near a free face the thin lip adds
compliance, which the cells of the level's body underestimate. Nuts with six balls and increasingly fine bodies give the
difference (``near_face.json``, written by ``tests/near_face.py``). The missing compliance times Young's modulus and ball
radius r is the same for balls and leads of all sizes within a quarter. It depends on the distance d from the face over r:
on level 1 it is 0.4 at d = 1.1 r and 0.03 at 2.5 r.

The missing compliance affects the flank that is pressed towards the face, and, through its ball, the opposite flank of the
screw. At a given approach of the bodies, a missing compliance dC increases their load F by

    dF = F dC / (2/3 (delta_s + delta_n) / F + C_lip),

where delta_s and delta_n are Hertz's approaches at screw and nut, of which 2/3 delta / F is the tangent compliance, and
C_lip is the compliance of the lip. There is no such error at fixed faces and at balls far from the faces. If only one flank
of the screw carries load, equilibrium fixes the sum of the loads, and the excess of these contacts is missing on the others
of their flank, in proportion to their stiffness (`load_error_near_faces`). The changes between the levels of a scene
contain this effect on the other contacts; for a bearing, all of whose contacts are near both faces, they contain the excess
near the faces as well.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.reference.convergence import relative_cell_size
from rollbench.compare.reference.levels import LEVELS, PRODUCTION
from rollbench.compare.reference.store import Run, load_stored_run, shipped_store
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Name of the file with the parts of the mesh uncertainty that hold for all scenes.
FILE = "grid_parts.json"

#: Ratio of an uncertainty that covers 95 % of the contacts to the standard deviation: normally, and if only the change
#: between two neighbouring mesh levels is known. This change scatters between scenes: a factor of 2 covered 87 % of the
#: contacts of one random screw.
COVER, COVER_OF_ONE_CHANGE = 2.0, 2.2

#: Order with which the errors of the (second-order) cells fall with their size.
ORDER = 2

#: Exponent of the load in the stiffness of a contact.
STIFFNESS = 1.0 / 3.0

#: Cell sizes (at the contact, of the bodies) of an assumed level finer than the last one, over those of the last level.
NEXT = (0.75, 0.87)

#: Shares of contacts whose error the uncertainty of a scene with a single mesh level must cover: over all compared scenes
#: together; in each scene with one loaded flank of the screw, and in each with both flanks loaded.
SHARE, LEAST = 0.95, (0.93, 0.95)

#: Number of reweighting rounds in a fit of variances, and the smallest variance that counts [%^2].
ROUNDS, TINY = 20, 1e-12

#: Contact loads ``(n, 4)`` [N] of a scene for each mesh level.
Levelled = Mapping[int, Array]


@dataclass(frozen=True)
class UncertaintyFromOtherScenes:
    """Parts of the mesh uncertainty that hold for all scenes, determined from scenes that were solved on several levels.

    The parts are in % of the mean contact load.
    """

    #: Standard deviation of a contact load due to the mesh of the refinement boxes (blocks below the contacts).
    sockets: float
    #: Standard deviation, over scenes, of the error that is common to all contact loads of a scene.
    common: float
    #: Uncertainty of the contact loads of a scene that was solved on the coarsest mesh level only: first for scenes with
    #: one loaded flank of the screw, then for scenes with both loaded. It covers 95 % of the errors (at least 93 % in every
    #: scene with one loaded flank).
    single: tuple[float, float]
    #: Names of the scenes from which these values were determined.
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class MeshUncertainty:
    """Uncertainty of a scene's contact loads due to the mesh, and its parts [% of the mean load], RMS over the contacts.

    The parts, such as that due to the cells at the contact, are standard deviations of the change of a contact load that
    one more level of refinement, beyond the finest level computed, would cause. With a single level only the uncertainty is
    known, from other scenes, and the parts are None.
    """

    #: Uncertainty of a contact load that covers 95 % of the contacts; zero without load.
    uncertainty: float
    #: Standard deviation of a contact load due to the cells at the contact.
    contact_cell_deviation: float | None = None
    #: Standard deviation of a contact load due to the cells of the bodies.
    body_cell_deviation: float | None = None
    #: Standard deviation of a contact load due to the mesh of the refinement boxes (blocks below the contacts).
    refinement_box_deviation: float | None = None
    #: Standard deviation of the error that is common to all contact loads of the scene.
    common_deviation: float | None = None
    #: Ratio of the uncertainty to the root of the sum of squares of the parts.
    coverage_factor: float = COVER

    @property
    def is_from_other_scenes(self) -> bool:
        """Whether the uncertainty is taken from other scenes, because this one was solved on a single mesh level."""
        return self.contact_cell_deviation is None

    def uncertainties_of_loads(self, loads: Levelled) -> Array:
        """Return the uncertainty of every contact load due to the mesh, (n, 4) [% of the mean load].

        ``loads``: contact loads of n balls on 4 flanks (n, 4) [N] by mesh level. The uncertainty covers 95 % of the
        contacts, and is zero for contacts that carry load on no level.
        """
        on = is_loaded_on_any_level(loads)
        contact, body = self.contact_cell_deviation, self.body_cell_deviation
        box, common = self.refinement_box_deviation, self.common_deviation
        if contact is None or body is None or box is None or common is None:
            return np.where(on, self.uncertainty, 0.0)
        stiffness = loads[max(loads)] ** STIFFNESS
        share = stiffness**2 / (stiffness[on] ** 2).mean()
        displaced, shared = body**2 + box**2, contact**2 + common**2
        return np.where(on, self.coverage_factor * np.sqrt(shared + displaced * share), 0.0)


def has_both_flanks_loaded(load: Array) -> bool:
    """Return whether both flanks of the screw carry load, so that equilibrium does not fix the sum of the contact loads.

    ``load``: contact loads of n balls on 4 flanks (n, 4) [N], first those of the screw.
    """
    return bool((load[:, :2] > 0.0).any(axis=0).all())


def is_loaded_on_any_level(loads: Levelled) -> Array:
    """Return a mask (n, 4) of the contacts that carry load on at least one mesh level.

    ``loads``: contact loads of n balls on 4 flanks (n, 4) [N] by mesh level.
    """
    return np.asarray(np.max([loads[k] for k in loads], axis=0) > 0.0)


def mesh_uncertainty(loads: Levelled, other_scenes: UncertaintyFromOtherScenes) -> MeshUncertainty:
    """Compute the uncertainty of a scene's contact loads due to the mesh, and its parts.

    Parameters
    ----------
    loads
        Contact loads (n, 4) [N] for each mesh level.
    other_scenes
        Parts of the uncertainty that are determined from other scenes.

    Returns
    -------
    MeshUncertainty
        Uncertainty and parts.
    """
    levels = sorted(loads)
    finest, both = levels[-1], has_both_flanks_loaded(loads[levels[-1]])
    if not (loads[finest] > 0.0).any():
        return MeshUncertainty(0.0)
    if len(levels) == 1:
        return MeshUncertainty(other_scenes.single[both])
    steps, fixed = list(pairwise(levels)), 2.0 * other_scenes.sockets**2
    shown = np.array([float((_load_change(loads, a, b, finest) ** 2).mean()) for a, b in steps])
    amounts = _fit_variances(np.array([_variance_factors(a, b) for a, b in steps]), np.maximum(shown - fixed, 0.0), fixed)
    left = (*(amounts * _variance_factors(finest, finest + 1)), fixed, 2.0 * other_scenes.common**2 if both else 0.0)
    cover = COVER_OF_ONE_CHANGE if levels == [finest - 1, finest] else COVER
    contact, bodies, sockets, common = (float(np.sqrt(v)) for v in left)
    return MeshUncertainty(cover * float(np.sqrt(sum(left))), contact, bodies, sockets, common, cover)


def _load_change(loads: Levelled, level: int, other_level: int, finest: int) -> Array:
    """Return by how much contact loads change from one mesh level to another [% of the mean load on level ``finest``].

    ``loads``: contact loads of n balls on 4 flanks (n, 4) [N] by mesh level; ``level``, ``other_level``: first and second
    level. The result is a vector with the changes of all contacts that carry load on at least one level.
    """
    on = is_loaded_on_any_level(loads)
    return np.asarray(error_percent(loads[other_level][on], loads[level][on], mean_load(loads[finest])))


def _relative_cell_sizes_of_level(level: int) -> Array:
    """Return the relative cell sizes of a mesh level, (2,): first at the contact, then of the bodies.

    For assumed levels finer than the last one, the sizes fall by the factors `NEXT` from level to level.
    """
    last = max(LEVELS)
    cells = LEVELS[min(level, last)]
    size = np.array([1.0 / cells["b_over_h"], cells["fine"] / LEVELS[PRODUCTION]["fine"]])
    return np.asarray(size * np.power(NEXT, max(level - last, 0)))


def _variance_factors(level: int, other: int) -> Array:
    """Return the factors (2,) with which two error variances enter the variance of the load change between two mesh levels.

    ``level``, ``other``: the two levels. The first factor belongs to the error due to the cells at the contact, the second
    to the error due to the cells of the bodies.
    """
    first, second = (_relative_cell_sizes_of_level(k) ** (2 * ORDER) for k in (level, other))
    return np.asarray(first + second)


def _fit_variances(columns: Array, observed: Array, known_variance: float) -> Array:
    """Fit the error variances due to contact cells and to body cells (2,) to the observed changes between mesh levels.

    ``columns``: `_variance_factors` of each of k pairs of levels, (k, 2); ``observed``: observed variances, (k,) [%^2],
    from which ``known_variance``, the variance by all other causes, is already subtracted. The fit minimises the squares of
    the deviations divided by the observed variances; no fitted variance is negative. With two levels the whole variance is
    attributed to the body cells, whose error decreases more slowly with refinement.
    """
    from scipy.optimize import nnls

    columns = columns * [0.0, 1.0] if len(observed) == 1 else columns
    variances, scale = np.zeros(2), np.maximum(observed + known_variance, TINY)
    for _ in range(ROUNDS):
        variances = nnls(columns / scale[:, None], observed / scale)[0]
        scale = np.maximum(columns @ variances + known_variance, TINY)
    return np.asarray(variances)


def derive_uncertainty_of_other_scenes(
    scenes: Mapping[str, Levelled], refinement_boxes: float, known_errors: Mapping[str, Array] | None = None
) -> UncertaintyFromOtherScenes:
    """Determine the parts of the mesh uncertainty that hold for all scenes, from scenes solved on several mesh levels.

    Parameters
    ----------
    scenes
        Contact loads of n balls on 4 flanks (n, 4) [N] on each mesh level, for each scene.
    refinement_boxes
        Standard deviation of a contact load due to the mesh of the refinement boxes below the contacts [% of the mean
        load], from a separate run.
    known_errors
        For each scene, the errors on the coarsest level near free faces of the nut (`load_error_near_faces`), (n, 4) [% of
        the mean load]. They have a separate uncertainty and are subtracted. None: nothing is subtracted.

    Returns
    -------
    UncertaintyFromOtherScenes
        Parts of the mesh uncertainty for other scenes.

    Raises
    ------
    ValueError
        If there is no scene with one loaded flank of the screw, or none with both.
    """
    shifts, errors = list[float](), (list[Array](), list[Array]())
    for name, loads in scenes.items():
        levels, finest = sorted(loads), max(loads)
        both = has_both_flanks_loaded(loads[finest])
        if both:
            shifts += [float(_load_change(loads, a, b, finest).mean()) for a, b in pairwise(levels) if a >= PRODUCTION]
        if levels[0] == min(LEVELS) and finest >= PRODUCTION:
            held = known_errors[name][is_loaded_on_any_level(loads)] if known_errors and name in known_errors else 0.0
            errors[both].append(np.maximum(np.abs(_load_change(loads, levels[0], finest, finest)) - held, 0.0))
    if not shifts or not all(errors):
        raise ValueError(
            "a scene solved on a single mesh level takes its mesh uncertainty from other scenes, solved on several levels; "
            "two such scenes are needed: one in which a single flank of the screw is loaded, and one in which both are"
        )
    common = float(np.sqrt(np.mean(np.square(shifts)) / 2.0))
    one, both_flanks = (_smallest_covering_bound(errors[k], LEAST[k]) for k in (0, 1))
    return UncertaintyFromOtherScenes(refinement_boxes, common, (one, both_flanks), tuple(scenes))


def _smallest_covering_bound(errors: Sequence[Array], least: float) -> float:
    """Return the smallest bound that covers the share `SHARE` of all errors and, in each scene, the share ``least``.

    ``errors``: absolute errors of the contacts of each scene.
    """
    return float(max(np.quantile(np.concatenate(errors), SHARE), *(np.quantile(of_scene, least) for of_scene in errors)))


def save_uncertainty_of_other_scenes(store: Path, known: UncertaintyFromOtherScenes) -> None:
    """Write the parts of the mesh uncertainty that hold for all scenes, ``known``, to a file in the folder ``store``."""
    replace_file(store / FILE, json.dumps(asdict(known), indent=1) + "\n")


@cache
def read_uncertainty_of_other_scenes(store: Path) -> UncertaintyFromOtherScenes:
    """Read the parts of the mesh uncertainty that were determined from other scenes.

    OSError, ValueError, KeyError or TypeError if the file in the folder ``store`` cannot be used.
    """
    data = json.loads((store / FILE).read_text(encoding="utf-8"))
    one, both = (float(x) for x in data["single"])
    return UncertaintyFromOtherScenes(float(data["sockets"]), float(data["common"]), (one, both), tuple(data["scenes"]))


#: Name of the file with the compliance of the lip between a contact and a free face of the nut.
LIP_FILE = "near_face.json"

#: Distance [ball radii] from which on a face has no influence; from the last computed distance the influence falls linearly
#: to zero at this one.
AWAY = 3.0

#: Distance by which the influence is extrapolated towards the face [ball radii]; closer to the face no contact can be
#: meshed.
CLOSER = 0.25

#: Smallest denominator (an approach in m, or a sum of stiffnesses), which avoids division by zero without load.
NO_STIFFNESS = 1e-30

#: Numbers of the flanks of the nut that are pressed towards its face of low z and towards that of high z.
TOWARDS = (2, 3)


@dataclass(frozen=True)
class LipCompliance:
    """Compliance that the thin lip between a contact and a free face of the nut adds, against the distance to the face."""

    #: Distances from the face [ball radii], increasing.
    relative_distances: Array
    #: Compliance that the lip adds, multiplied by Young's modulus and ball radius [1], at each of the distances.
    compliance: Array
    #: For each mesh level, the part of the lip's compliance that the mesh fails to represent, in the same dimensionless
    #: form.
    missing_compliance_by_level: dict[int, Array]

    def interpolate(self, radii: Array, level: int) -> tuple[Array, Array]:
        """Return the lip's compliance at distances from the nut's face, and the part that a mesh level fails to represent.

        ``radii``: distances from the face over the ball radius; ``level``: the mesh level. Both compliances are
        dimensionless: multiplied by Young's modulus and by the ball radius.
        """
        missing = self.missing_compliance_by_level[min(max(level, 1), max(self.missing_compliance_by_level))]
        lip, neglected = (np.interp(radii, self.relative_distances, x) for x in (self.compliance, missing))
        return lip, neglected


@cache
def read_lip_compliance(store: Path) -> LipCompliance:
    """Read the compliance of the lip between a contact and a free face of the nut from the folder ``store``.

    The compliance was computed for one scene on all mesh levels. The part of it that a mesh level fails to represent is
    multiplied by the largest ratio of this part in any scene of the file to that in the first scene, so that it holds for
    the worst of these scenes. Values are extrapolated from the two smallest distances towards the face, and fall to zero
    beyond the largest distance. OSError, ValueError or KeyError if the file is missing or damaged.
    """
    rows = json.loads((store / LIP_FILE).read_text(encoding="utf-8"))
    first = [row for row in rows if row["scene"] == rows[0]["scene"]]
    radii = np.array([row["radii"] for row in first])
    step = CLOSER / (radii[1] - radii[0])

    def extrapolated_to_face_and_zero(values: list[float]) -> Array:
        return np.array([values[0] + step * (values[0] - values[1]), *values, 0.0])

    missing = {int(k): [row["missing"][k] for row in first] for k in first[0]["missing"]}
    spread = max(row["missing"]["1"] / np.interp(row["radii"], radii, missing[1]) for row in rows)
    places, lip = np.array([radii[0] - CLOSER, *radii, AWAY]), extrapolated_to_face_and_zero([row["lip"] for row in first])
    return LipCompliance(places, lip, {k: spread * extrapolated_to_face_and_zero(x) for k, x in missing.items()})


def load_overestimate_near_faces(scene: Scene, load: Array, level: int) -> Array:
    """Return upper bounds on how much a mesh level overestimates contact loads near free faces of the nut, (n, 4) [N].

    ``load``: contact loads of n balls on 4 flanks (n, 4) [N] of the level.
    """
    from rollbench.hifi.meshing.settings import hertz_contacts_under_unit_force

    out = np.zeros_like(load)
    if scene.solid.nut != "elastic" or scene.track.lead == 0.0:
        return out
    r, held = scene.balls.radius, dimensions_of_3d_parts(scene).nut_held
    z, half = ball_layout(scene).z - scene.nut.position, scene.nut.length / 2.0
    soft = [2.0 / 3.0 * unit.approach for unit in hertz_contacts_under_unit_force(scene)]
    known, unit = read_lip_compliance(shipped_store()), 1.0 / (scene.nut.material.youngs_modulus * r)
    for side, face, away in ((TOWARDS[0], "left face", half + z), (TOWARDS[1], "right face", half - z)):
        if held in (face, "both faces"):
            continue
        lip, missing = (unit * x for x in known.interpolate(away / r, level))
        for flank in (side, 3 - side):
            force = load[:, flank]
            springs = (soft[side] + soft[3 - side]) * np.cbrt(force) ** 2  # force times their tangent
            added = force**2 * missing / np.maximum(springs + lip * force, NO_STIFFNESS)
            out[:, flank] = np.maximum(out[:, flank], added)
    return out


def load_error_near_faces(scene: Scene, load: Array, level: int) -> Array:
    """Return an upper bound of each contact load's error on a mesh level due to free faces of the nut, (n, 4) [N].

    ``load``: contact loads of n balls on 4 flanks (n, 4) [N] of the level. If equilibrium fixes the sum of the loads, the
    excess of the loads near the faces is missing on the other contacts, whose loads then have errors, too.
    """
    excess = load_overestimate_near_faces(scene, load, level)
    if has_both_flanks_loaded(load) or not excess.any():
        return excess
    stiffness = load**STIFFNESS
    return np.asarray(excess + excess.sum(axis=0) * stiffness / np.maximum(stiffness.sum(axis=0), NO_STIFFNESS))


#: Number of the finest levels from which the uncertainty is estimated. Coarser levels say little about the finest.
FITTED = 4


@dataclass(frozen=True)
class Reference:
    """Reference contact loads with which models of a scene are compared: from the 3D reference or from a user's file."""

    #: Name of the scene.
    scene: str
    #: Runs of the 3D reference, coarse to fine; for a user's file a single run without mesh, displacements or times.
    runs: tuple[Run, ...]
    #: Contact loads of the finest run, (n, 4) [N].
    load: Array
    #: Uncertainty of the loads due to mesh and incomplete convergence, (n, 4) [N]; zero for contacts without load.
    uncertainty: Array
    #: RMS uncertainty of the contact loads due to the mesh, with its parts [% of the mean load].
    parts: MeshUncertainty
    #: Number of contacts that carry load if the screw has no geometric errors; 0: not known.
    contacts: int = 0
    #: Name of the reference; for a user's file, the name of the file.
    label: str = "3D reference"
    #: Text on a user's reference file: its name, the origin of its loads, and the uncertainty that it states; empty for the
    #: 3D reference.
    stated: str = ""
    #: Contact angles, approaches and pressures that a user's file states, (n, 4) in SI units, by name.
    further: Mapping[str, Array] = field(default_factory=dict)
    #: Part of each load's uncertainty due to a free face of the nut near the contact, (n, 4) [N].
    beside_face: Array | None = None

    @property
    def levels(self) -> tuple[int, ...]:
        """Mesh levels of the runs, coarse to fine; empty for a user's file."""
        return () if self.stated else tuple(run.level for run in self.runs)

    @property
    def mean(self) -> float:
        """Mean load [N] of the loaded contacts, to which errors refer (`compare.measure.mean_load`)."""
        return mean_load(self.load, self.contacts)

    @property
    def best(self) -> Run:
        """Run on the finest mesh level."""
        return self.runs[-1]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs, coarse to fine."""
        return (1.0,) if self.stated else tuple(relative_cell_size(run.settings) for run in self.runs)

    @property
    def unsettled(self) -> str:
        """Text with mesh level and status of each 3D run that did not fully converge; empty if all converged."""
        return "; ".join(f"level {run.level} {run.status}" for run in self.runs if run.moving > 0.0)


def reference_of_scene(scene: Scene, stores: Sequence[Path] | None = None) -> Reference | None:
    """Return the reference contact loads of a scene, with their uncertainty, from its finest stored 3D runs.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    stores
        Folders with runs; None: those included with rollbench.

    Returns
    -------
    Reference or None
        Contact loads and uncertainty from at most `FITTED` runs; None without a stored run.
    """
    runs = tuple(run for level in LEVELS if (run := load_stored_run(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.answers)[-FITTED:]
    return reference_from_runs(scene.name, scene, runs, contacts=count_nominal_contacts(scene)) if runs else None


def reference_from_runs(name: str, scene: Scene, runs: tuple[Run, ...], contacts: int = 0) -> Reference:
    """Return the reference contact loads of a scene, with their uncertainty, from 3D runs on one or more mesh levels.

    Parameters
    ----------
    name
        Name of the scene.
    scene
        Scene with one nut or bearing row. If a shaft has several, the nut or row of this reference as a separate scene.
    runs
        Runs, coarse to fine.
    contacts
        Number of contacts that carry load if the screw has no geometric errors; 0: not known.

    Returns
    -------
    Reference
        Loads of the finest run with their uncertainty.
    """
    loads = {run.level: run.load for run in runs}
    grid, best = mesh_uncertainty(loads, read_uncertainty_of_other_scenes(shipped_store())), runs[-1]
    bars = np.zeros_like(best.load)
    if grid.uncertainty:
        bars = 0.01 * mean_load(best.load) * grid.uncertainties_of_loads(loads)
    lips = load_overestimate_near_faces(scene, best.load, best.level)
    beside = load_error_near_faces(scene, best.load, best.level) if grid.is_from_other_scenes else lips
    return Reference(name, runs, best.load, bars + beside + best.moving, grid, contacts, beside_face=lips)


def largest_uncertainty_percent(reference: Reference) -> float:
    """Return the largest uncertainty of a contact load of the reference [% of the mean load]; zero without load."""
    return float(error_percent(reference.uncertainty.max(), 0.0, reference.mean)) if reference.parts.uncertainty else 0.0
