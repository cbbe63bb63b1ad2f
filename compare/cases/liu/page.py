"""Report pages on Liu et al. (2025): printed numbers and figures of each section, with the computed ones.

Another page shows the error of Liu's model, which has axial displacements only: there, one screw is computed by Liu's
model, the beam model, the refined model and the 3D reference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.case import CASES
from rollbench.compare.cases.liu import curves
from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.evidence import count_entries_by_verdict, evidence, reproduction_sentence
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import largest_uncertainty_percent
from rollbench.compare.sections import source_tables
from rollbench.compare.sections.verdicts import misprints_table
from rollbench.lowfi.as_source.liu.chain import BallScrewChain, solve_ball_screw
from rollbench.lowfi.as_source.liu.ensemble import draw_uniform_errors
from rollbench.lowfi.as_source.liu.model import SpringRow as ModelInputs
from rollbench.lowfi.as_source.liu.model import nut_as_spring_row
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Calibration, Scene
from rollbench.reports.content import Row, Section, Table, Text

#: Sections of the report by name: title, names of the printed tables.
CHAPTERS = {
    "liu-parameters": ("Liu (2025), Section 2.1 and Table 2: the ball screw and its ball errors", ("liu-2",)),
    "liu-test": ("Liu (2025), Section 3: algorithm and experiment", ("liu-3",)),
    "liu-mei": ("Liu (2025), Section 4.1: contact loads by Liu's and Mei's models", ("liu-4.1",)),
    "liu-one-ball": ("Liu (2025), Section 4.2: contact loads with one ball too small or too large", ("liu-4.2",)),
    "liu-loads": ("Liu (2025), Section 4.3: contact loads and displacement with random ball errors", ("liu-4.3",)),
    "liu-stiffness": ("Liu (2025), Section 4.4: axial stiffness with random ball errors", ("liu-4.4",)),
}
PRINTED = tuple(name for _, names in CHAPTERS.values() for name in names)
ABOUT = (
    (
        "One axial displacement, springs of screw and nut between neighbouring balls, unilateral Hertz contacts: the "
        "minimum of a convex energy, found by a tridiagonal Newton method that needs no sorting of unloaded balls. The "
        "publication's elimination of unloaded balls gives the same loaded balls. Random results are compared with drawn "
        "screws: each number has its percentile, the sampling error of it, and the probability of a value as extreme."
    ),
    *(f"Assumed: {text}" for text in liu.ASSUMED),
    "The publication's printed values agree with its implicit contact angle, not with a constant or the exact angle.",
    "The measured displacements appear in a figure only, so no number of the experiment can be compared.",
)


def loaded_ball_counts_in_words(found: dict[str, float]) -> str:
    """Return in words how many printed numbers of loaded balls lie in the central 99 % interval of randomly drawn screws.

    ``found``: printed values by key, such as "loaded_2_500" for ball errors within ±2 um and a load of 500 N.
    """
    total, out = 0, []
    for key, value in found.items():
        parts = re.fullmatch(r"(un)?loaded_(\d)_(\d+)(_again)?", key)
        if parts is None:
            continue
        half_range, load = int(parts[2]), float(parts[3])
        count = liu.ball_count() - value if parts[1] else value
        low, high = np.quantile(liu.random_screw_values(half_range, "loaded", load), [liu.UNLIKELY, 1.0 - liu.UNLIKELY])
        total += 1
        if not low <= count <= high:
            out.append(f"±{half_range} µm at {load:g} N {'below' if count < low else 'above'} it")
    span = f"the central {100.0 * (1.0 - 2.0 * liu.UNLIKELY):g} % of the random screws"
    beyond = f"; the others: {', '.join(dict.fromkeys(out))}" if out else ""
    return f"Of {total} printed numbers, {total - len(out)} lie within {span}{beyond}"


def stiffness_deviation_in_words(found: dict[str, float]) -> str:
    """Return in words the deviation of printed stiffnesses from the median stiffness of randomly drawn screws.

    Only axial loads count at which the median screw has no unloaded ball. ``found``: printed values by key, such as
    "K_2_3000" for ball errors within ±2 um and a load of 3000 N.
    """
    off = []
    for key, value in found.items():
        parts = re.fullmatch(r"K_(\d)_(\d+)", key)
        half_range, load = (int(parts[1]), float(parts[2])) if parts else (0, 0.0)
        if (
            load in liu.LOADS.get(half_range, ())
            and np.median(liu.random_screw_values(half_range, "loaded", load)) == liu.ball_count()
        ):
            off.append(error_percent(1e8 * value, float(np.median(liu.random_screw_values(half_range, "stiffness", load)))))
    if not off:
        return "No stiffness is printed for a load under which most random screws have all balls loaded"
    return f"With all balls loaded, printed stiffness is {min(off):+.1f} to {max(off):+.1f} % off the median random screw"


#: Name of the scene of Liu's screw.
SCENE = "liu-screw"

#: Scenes of Liu's screw with 3D reference solutions, and the mesh levels of these (156 contacts).
SOLID = (SCENE, "liu-small", "liu-drawn", "liu-drawn-1kN")

SOLID_LEVELS = (1, 2)

#: Axial loads [N]; half range of the random errors of the ball diameters [m]; number of screws with random errors.
LOADS, HALF_RANGE, DRAWN = (1000.0, 5000.0), 2e-6, 3


@dataclass(frozen=True)
class LoadsByThreeModels:
    """Contact loads of the 78 balls of one screw under one axial load, by three models.

    ``ball_errors_in_words``: ball errors of the screw; ``axial_load``: [N]; ``loads_by_axial_model``,
    ``loads_by_beam_model``, ``loads_by_refined_model``: contact loads (78,) [N] by Liu's axial model, the beam model and
    the refined model.
    """

    ball_errors_in_words: str
    axial_load: float
    loads_by_axial_model: Array
    loads_by_beam_model: Array
    loads_by_refined_model: Array

    def differences_of_axial_model(self, model: Array) -> tuple[float, float, int]:
        """Return the differences of another model's contact loads from those of the axial model: other minus axial.

        First: RMS difference [% of the mean load]; second: largest difference, with its sign [% of the mean load]; third:
        number of the ball with the largest difference, from 1. ``model``: contact loads (78,) [N] by that other model.
        """
        change = error_percent(model, self.loads_by_axial_model, float(model.mean()))
        ball = int(np.abs(change).argmax())
        return float(np.sqrt(np.mean(change**2))), float(change[ball]), ball + 1


def with_ball_errors_and_axial_load(scene: Scene, errors: Array, load: float) -> Scene:
    """Return a copy of the scene with other ball errors and another axial load.

    ``errors``: errors of the ball diameters (78,) [m]; ``load``: axial load [N].
    """
    listed = tuple((i + 1, 0.5 * float(e)) for i, e in enumerate(errors) if e != 0.0)
    balls = replace(scene.errors.balls, listed=listed)
    force = replace(scene.loads[0], force=(0.0, 0.0, load))
    return replace(scene, errors=replace(scene.errors, balls=balls), loads=(force,))


def axial_model_inputs_with_rigid_nut(scene: Scene) -> ModelInputs:
    """Return inputs of Liu's axial model for a scene, with a rigid nut and exact contact angles, as the beam model has.

    Exact contact angles follow from the displacements without approximation.
    """
    row = nut_as_spring_row(replace(scene, calibration=Calibration()), law="exact")
    return replace(row, liu_chain=replace(row.liu_chain, compliance=row.screw_compliance_share * row.liu_chain.compliance))


def compare_models(cache: SceneResultCache) -> tuple[LoadsByThreeModels, ...]:
    """Return the contact loads of Liu's screw by the axial, the beam and the refined model.

    There is an entry for each axial load and each of these ball errors: none, ball 33 too small or too large by 2 um, and
    random errors. ``cache``: gives the solved scenes.
    """
    scene = cache.built_in_scene(SCENE)
    chain = axial_model_inputs_with_rigid_nut(scene).liu_chain
    drawn = draw_uniform_errors(liu.SEED + 2, 0, DRAWN, liu.ball_count(), HALF_RANGE)
    kinds = [
        ("none", np.zeros(liu.ball_count())),
        ("ball 33: -2 um", liu.ball_errors_with_faulty_ball_33(-2e-6)),
        ("ball 33: +2 um", liu.ball_errors_with_faulty_ball_33(2e-6)),
    ]
    kinds += [(f"drawn, +-2 um, screw {i + 1}", errors) for i, errors in enumerate(drawn)]
    return tuple(
        _loads_of_screw_by_three_models(cache, scene, chain, name, errors, load) for name, errors in kinds for load in LOADS
    )


def _loads_of_screw_by_three_models(
    cache: SceneResultCache, scene: Scene, chain: BallScrewChain, name: str, errors: Array, load: float
) -> LoadsByThreeModels:
    """Compute the contact loads of one screw under one axial load by Liu's axial, the beam and the refined model.

    ``chain``: axial model of the scene; ``name``: ball errors in words; ``errors``: errors of the ball diameters (78,) [m];
    ``load``: axial load [N]. ``cache``: gives the solved scenes.
    """
    changed = with_ball_errors_and_axial_load(scene, errors, load)
    beam, refined = (cache.solve_once(changed, model).load[:, 0] for model in ("lin", "refined"))
    return LoadsByThreeModels(name, load, solve_ball_screw(chain, errors, load).load, beam, refined)


@dataclass(frozen=True)
class DifferenceFrom3D:
    """Errors of one low-order model's contact loads against the 3D reference, for one scene of Liu's screw."""

    #: Name of the scene.
    scene: str
    #: Title of the scene.
    title: str
    #: Name of the low-order model.
    model: str
    #: RMS difference of the contact loads from those in 3D [% of the mean load].
    rms_percent: float
    #: Largest difference between a ball's contact load by the model and in 3D [% of the mean load].
    largest_percent: float
    #: Number of the ball with this largest difference, counted from 1.
    worst_ball: int
    #: Largest uncertainty of any 3D contact load due to the mesh [% of the mean load]; None if unknown.
    mesh_uncertainty_percent: float | None
    #: Number of balls that carry load by the model.
    loaded_balls: int
    #: Number of balls that carry load in 3D.
    loaded_balls_in_3d: int


def differences_from_3d(cache: SceneResultCache) -> tuple[DifferenceFrom3D, ...]:
    """Return the differences of contact loads by Liu's axial, the beam and the refined model from the 3D reference.

    There are three entries for each scene that has a stored reference. ``cache``: gives solved scenes and stored 3D
    references.
    """
    rows = []
    for name, found in cache.stored_references(SOLID).items():
        scene, bar = cache.built_in_scene(name), largest_uncertainty_percent(found)
        for model in ("axial", "lin", "refined"):
            load = loads_by_axial_model(scene) if model == "axial" else cache.solve_once(scene, model).load
            e = load_error(load, found.load, found.contacts)
            carried, held = (int(np.count_nonzero(x[:, 0] > 0.0)) for x in (load, found.load))
            rows.append(
                DifferenceFrom3D(name, scene.title, model, e.rms_percent, e.max_percent, e.ball, bar, carried, held)
            )
    return tuple(rows)


def loads_by_axial_model(scene: Scene) -> Array:
    """Return the contact loads (78, 4) [N] of a scene by Liu's axial model.

    The columns are the flanks SL, SR, NL and NR (screw or nut, left or right). The loads of a ball on SL and NR are equal,
    those on SR and NL are zero.
    """
    row, load = axial_model_inputs_with_rigid_nut(scene), np.zeros((scene.ball_count, 4))
    load[row.ball_order, 0] = load[row.ball_order, 3] = row.solve_under_load(row.axial_load).load
    return load


def scenes_and_levels_to_solve_again_in_3d(fresh: bool) -> Iterator[tuple[tuple[str, ...], tuple[int, ...]]]:
    """Yield names of scenes of Liu's screw, with the mesh levels on which a report must solve them in 3D again.

    ``fresh``: whether 3D solutions are to be computed again; else nothing is yielded, and the stored ones are used.
    """
    if fresh:
        yield SOLID, SOLID_LEVELS


def model_loads_table(cache: SceneResultCache) -> Table:
    """Return the table of contact loads of Liu's screw by the axial, the beam and the refined model, by ball errors.

    ``cache``: gives the solved scenes.
    """
    rows: list[Row] = []
    for c in cache.compute_once(compare_models):
        row: Row = {"diameter_errors": c.ball_errors_in_words, "axial_load": c.axial_load}
        for words, model in (
            ("axial-only model", c.loads_by_axial_model),
            ("beam model", c.loads_by_beam_model),
            ("refined model", c.loads_by_refined_model),
        ):
            row["largest_load_by_g4", words] = float(model.max())
            row["loaded_balls", words] = int(np.count_nonzero(model > 0.0))
            if model is not c.loads_by_axial_model:
                rms, most, ball = c.differences_of_axial_model(model)
                row["rms_difference_from_axial", words] = rms
                row["largest_difference_from_axial", words] = f"{most:+.1f} (ball {ball})"
        rows.append(row)
    note = (
        "Axial-only model: Liu's model with a rigid nut and the axial compliance of the beam model's screw. Cross "
        "sections and balls per turn are assumed (scene liu-screw)."
    )
    title = "Liu's screw: contact loads by the axial-only, the beam and the refined model"
    return Table.from_rows("liu-bodies", title, rows, note)


def errors_against_3d_table(cache: SceneResultCache) -> Table:
    """Return the table of the low-order models' errors against the 3D reference, for scenes of Liu's screw.

    ``cache``: gives the solved scenes.
    """
    words = {"axial": "axial-only model", "lin": "beam model", "refined": "refined model"}
    rows: list[Row] = [
        {
            "scene": c.scene,
            "model": words[c.model],
            "rms_error": c.rms_percent,
            "largest_load_error": c.largest_percent,
            "ball_of_largest_error": c.worst_ball,
            "mesh_uncertainty": c.mesh_uncertainty_percent,
            ("loaded_balls", "model"): c.loaded_balls,
            ("loaded_balls", "3D reference"): c.loaded_balls_in_3d,
        }
        for c in cache.compute_once(differences_from_3d)
    ]
    levels = " and ".join(str(k) for k in SOLID_LEVELS)
    contacts = 2 * cache.built_in_scene(SCENE).ball_count
    note = (
        f"3D reference on the mesh levels {levels}, with {contacts} contacts. The nut is rigid in the axial-only and the "
        "beam model. Random ball errors are the same for all models."
    )
    title = "Liu's screw: errors of contact loads against the 3D reference, for the axial-only, beam and refined model"
    return Table.from_rows("liu-solid", title, rows, note)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> tuple[Section, ...]:
    """Return the report's sections on Liu et al. (2025).

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("random errors of a ball screw")
    found = evidence(cache, *PRINTED)
    by_name = {f.printed.name: f for f in found}
    printed = {f.printed.key: f.printed.value for f in found if f.printed.value is not None}
    listed = source_tables.read_table_layouts(next(case for case in CASES if case.name == "liu"))
    drawn = {
        "liu-test": (curves.ball_deformation_figure(), curves.displacement_test_figure(), curves.displacement_test_table()),
        "liu-mei": (curves.liu_and_mei_loads_figure(),),
        "liu-one-ball": (curves.loads_with_one_faulty_ball_figure(),),
        "liu-loads": (
            curves.loads_with_random_errors_figure(),
            curves.loads_by_error_range_figure(),
            curves.loaded_balls_figure(printed, f"{loaded_ball_counts_in_words(printed)}."),
            curves.displacement_figure(),
        ),
        "liu-stiffness": (
            curves.stiffness_figure(printed, f"{stiffness_deviation_in_words(printed)}."),
            curves.stiffness_of_three_screws_figure(printed),
        ),
    }
    chapters = [
        Section(name, title, (*source_tables.tables_of_printed_numbers(tables, listed, by_name), *drawn.get(name, ())))
        for name, (title, tables) in CHAPTERS.items()
    ]
    cache.record_used_scenes(SOLID)
    beyond = [model_loads_table(cache), *([errors_against_3d_table(cache)] if cache.stored_references(SOLID) else ())]
    return (
        Section(
            "liu",
            "Liu et al. (2025): contact loads of a ball screw with random geometric errors",
            (Text(ABOUT, bullets=True),),
            conclusion=reproduction_sentence(count_entries_by_verdict(found)[0]),
        ),
        *chapters,
        Section("liu-beyond", "Liu's screw computed by three low-order models and by the 3D reference", beyond),
        Section(
            "liu-audit",
            "Liu (2025): misprints, and how each of the printed numbers is recomputed",
            (misprints_table("liu"), *source_tables.tables_on_computation_of_numbers(PRINTED)),
        ),
    )
