"""Report pages on Liu et al. (2025): printed numbers and figures of each section, with the computed ones.

Another page shows the error of Liu's model, which has axial displacements only: there, one screw is computed by Liu's
model, the beam model, the refined model and the 3D reference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from rollbench.compare.cases.liu import curves
from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.evidence import evidence
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import largest_uncertainty_percent
from rollbench.compare.sections.source_tables import publication_sections
from rollbench.lowfi.as_source.liu.chain import solve_ball_screw
from rollbench.lowfi.as_source.liu.ensemble import draw_uniform_errors
from rollbench.lowfi.as_source.liu.model import SpringRow as ModelInputs
from rollbench.lowfi.as_source.liu.model import nut_as_spring_row
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Calibration, Scene
from rollbench.reports.content import Row, Section, Table

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

#: Models that are compared, in words: Liu's axial one with a rigid nut, and two models of this package.
MODEL_WORDS = {"axial": "axial-only model", "lin": "beam model", "refined": "refined model"}


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


def difference_from_axial_cells(words: str, model: Array, axial: Array) -> Row:
    """Return table cells with RMS and largest difference of a model's contact loads from those of the axial model.

    The differences are other minus axial, in per cent of the mean load. ``words``: name of the other model; ``model``,
    ``axial``: contact loads (78,) [N] by the other and by the axial model.
    """
    change = error_percent(model, axial, float(model.mean()))
    ball = int(np.abs(change).argmax())
    return {
        ("rms_difference_from_axial", words): float(np.sqrt(np.mean(change**2))),
        ("largest_difference_from_axial", words): f"{change[ball]:+.1f} (ball {ball + 1})",
    }


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

    There is a row for each axial load and each of these ball errors: none, ball 33 too small or too large by 2 um, and
    random errors. ``cache``: gives the solved scenes.
    """
    scene = cache.built_in_scene(SCENE)
    chain = axial_model_inputs_with_rigid_nut(scene).liu_chain
    kinds = {
        "none": np.zeros(liu.ball_count()),
        "ball 33: -2 um": liu.ball_errors_with_faulty_ball_33(-2e-6),
        "ball 33: +2 um": liu.ball_errors_with_faulty_ball_33(2e-6),
    }
    drawn = draw_uniform_errors(liu.SEED + 2, 0, DRAWN, liu.ball_count(), HALF_RANGE)
    kinds |= {f"drawn, +-2 um, screw {i + 1}": errors for i, errors in enumerate(drawn)}
    rows: list[Row] = []
    for (name, errors), load in product(kinds.items(), LOADS):
        changed, axial = with_ball_errors_and_axial_load(scene, errors, load), solve_ball_screw(chain, errors, load).load
        row: Row = {"diameter_errors": name, "axial_load": load}
        for model, words in MODEL_WORDS.items():
            found = axial if model == "axial" else cache.solve_once(changed, model).load[:, 0]
            row["largest_load_by_g4", words] = float(found.max())
            row["loaded_balls", words] = int(np.count_nonzero(found > 0.0))
            row |= difference_from_axial_cells(words, found, axial) if model != "axial" else {}
        rows.append(row)
    note = (
        "Axial-only model: Liu's model with a rigid nut and the axial compliance of the beam model's screw. Cross "
        "sections and balls per turn are assumed (scene liu-screw)."
    )
    title = "Liu's screw: contact loads by the axial-only, the beam and the refined model"
    return Table.from_rows("liu-bodies", title, rows, note)


def errors_against_3d_table(cache: SceneResultCache) -> Table:
    """Return the table of the low-order models' errors against the 3D reference, for scenes of Liu's screw.

    ``cache``: gives the solved scenes and stored 3D references.
    """
    rows: list[Row] = []
    for name, found in cache.stored_references(SOLID).items():
        scene, bar = cache.built_in_scene(name), largest_uncertainty_percent(found)
        for model, words in MODEL_WORDS.items():
            load = loads_by_axial_model(scene) if model == "axial" else cache.solve_once(scene, model).load
            e = load_error(load, found.load, found.contacts)
            rows.append(
                {
                    "scene": name,
                    "model": words,
                    "rms_error": e.rms_percent,
                    "largest_load_error": e.max_percent,
                    "ball_of_largest_error": e.ball,
                    "mesh_uncertainty": bar,
                    ("loaded_balls", "model"): int(np.count_nonzero(load[:, 0] > 0.0)),
                    ("loaded_balls", "3D reference"): int(np.count_nonzero(found.load[:, 0] > 0.0)),
                }
            )
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
    printed = {f.printed.key: f.printed.value for f in found if f.printed.value is not None}
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
    cache.record_used_scenes(SOLID)
    beyond = [model_loads_table(cache), *([errors_against_3d_table(cache)] if cache.stored_references(SOLID) else ())]
    return publication_sections(
        "liu",
        "Liu (2025)",
        "Liu et al. (2025): contact loads of a ball screw with random geometric errors",
        ABOUT,
        CHAPTERS,
        found,
        drawn,
        Section("liu-beyond", "Liu's screw computed by three low-order models and by the 3D reference", beyond),
    )
