"""Numbers that comparisons rest on, of stored 3D runs and of a screw that differs on every flank: a guard against change,
as those beside them.

All fields and properties of the records are kept, printed or not. Whoever changes them on purpose writes them again with
``python -m tests.golden.test_studies`` and says why in the commit.
"""

import contextlib
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.golden.means import means, same, write
from tests.helpers import FLANK_ERRORS, small_screw

from rollbench.compare.gate import gate, judged, verdict
from rollbench.compare.models import applicability, loading, model_form, modelling, uncertainty
from rollbench.compare.models.comparison import REFERENCED, solution_from_result
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.models.study import SceneResultCache, with_ball_count, with_conformity
from rollbench.compare.quantities import record_as_json
from rollbench.compare.reference import convergence, estimate, levels, tasks
from rollbench.compare.scenes import catalogue
from rollbench.compare.sections import u_val
from rollbench.compare.studies import mesh_study

#: The numbers by the function below that makes them: a new one is added with none and written.
RECORD = Path(__file__).parent / "studies.json"
RECORDED = json.loads(RECORD.read_text(encoding="utf-8"))
STUDY = SceneResultCache()
scene_of, stored = STUDY.built_in_scene, STUDY.stored_reference
NAMES = (*REFERENCED, "unseen-flange", "unseen-four-point")
OPTIONS = ModelOptions(estimate_beam_mesh_error=False)


def by_lin(name):
    return STUDY.solve_once(name, "lin")


def uneven():
    """A screw whose flanks, balls and loads are all different, far from the origin."""
    scene = small_screw(7, 1.7, oversize=4e-6, force=(70.0, -40.0, 300.0), moment=(1.0, -2.0, 0.5), load_at=0.13)
    return replace(scene, errors=replace(FLANK_ERRORS, balls=scene.errors.balls))


def loads_of_levels():
    """Loads [N] of three contacts on four meshes of decreasing cells, none of them converging alike."""
    sizes = np.array([1.0, 0.7, 0.45, 0.3])
    return np.stack([100.0 + 3.0 * sizes**1.3, 50.0 - 2.0 * sizes**2 + 0.3 * sizes, 20.0 + 0.5 * sizes], axis=-1), sizes


def references():
    return [stored(name) for name in NAMES]


def grids():
    y, h = loads_of_levels()
    fits = []
    for weighted in (False, True):
        fits += [convergence.fit_searched_order(y, h, weighted), convergence.fit_given_order(y, h, 1.5, weighted)]
    return {
        "own": [convergence.grid_convergence(y[4 - k :, i], h[4 - k :]) for k in range(1, 5) for i in range(3)],
        "pooled": [convergence.pooled_grid_uncertainty(y[-k:], h[-k:]) for k in range(1, 5)],
        "fits": fits,
        "mixed": convergence.fit_fixed_orders(y, h, with_mixed_order=True),
        "allowed": convergence.range_of_compatible_orders(y, h, fits[0]),
        "at": [levels.mesh_settings_of_level(k, 3e-3, finer) for k in levels.LEVELS for finer in ((), ("cuts", "fine"))],
    }


def mesh_studies():
    return [
        [
            [record_as_json(x) for x in mesh_study.mesh_levels_of_reference(stored(name))],
            [x.as_json() for x in mesh_study.mesh_study_table_of_scene(scene_of(name), None)],
        ]
        for name in STUDY.stored_references(NAMES)
    ]


def choices():
    scenes = [scene_of(name) for name in NAMES]
    effects = [effect for scene in scenes for effect in modelling.effects_of_changed_choices(scene)]
    return {"effects": effects, "combined": [modelling.combined_modelling_uncertainty(scene, effects) for scene in scenes]}


def validation():
    answers = {name: solution_from_result(by_lin(name)) for name in REFERENCED}
    rows = [
        uncertainty.error_with_validation_uncertainty(STUDY, name, "lin", quantity, answer)
        for name, answer in answers.items()
        for quantity in uncertainty.QUANTITIES
    ]
    rows = [row for row in rows if row is not None]
    return {"rows": rows, "scatter": u_val.bias_and_scatter(rows)}


def expectations():
    points = model_form.model_errors_on_compared_scenes()
    return {
        "features": [model_form.features_of_scene(scene_of(name), by_lin(name)) for name in NAMES],
        "left out": model_form.leave_one_out_errors(points, "lin")[:12],
        "places": [applicability.descriptors_with_ranges(scene_of(name)) for name in NAMES],
        "points": [
            model_form.measure_model_error(name, scene_of(name), by_lin(name), stored(name).best) for name in REFERENCED
        ],
    }


def uncertainties():
    return [uncertainty.uncertainty_of_loads(scene_of(name), one) for name, one in STUDY.stored_references(NAMES).items()]


def faces():
    errors = (estimate.load_overestimate_near_faces, estimate.load_error_near_faces)
    return [[error(scene_of(name), stored(name).load, 1) for error in errors] for name in ("unseen-flange", "lin-case1")]


def varied():
    """Scenes that variants make, and the settings of their meshes."""
    out = []
    for name in ("lin-case3", "unseen-flange"):
        scene = scene_of(name)
        for key, variant in levels.VARIANTS.items():
            with contextlib.suppress(ValueError):
                out += [variant.change(scene), vars(tasks.mesh_settings([scene], variant.level, key))]
        out += [levels.with_supports_turned_by_coupling(scene), with_ball_count(scene, 9), with_conformity(scene, 0.54)]
    return out


def shafts():
    """Set-ups of several sets, all of a shaft and each alone."""
    found = [
        tasks.mesh_specifications([catalogue.shipped_scene(name)], level)
        for name in ("double-nut", "axis-fixed-fixed")
        for level in (1, 3)
    ]
    return [tasks.mesh_settings_to_store(ups) for every in found for ups in (every, *([one] for one in every))]


def verdicts():
    out, limits = [], verdict.ErrorLimits(7.0, 2.0, dict.fromkeys(judged.QUANTITIES, 3.0))
    for name in ("lin-case3", "unseen-flange"):
        scene, found, answer = scene_of(name), stored(name), solution_from_result(by_lin(name))
        quantities = verdict.contact_values_by_model(scene, answer, limits.limits_by_quantity)
        values = verdict.screw_values_by_model(scene, answer, limits.limits_by_quantity)
        out += verdict.judge_contact_loads("lin", answer.load, found, limits)
        out += verdict.judge_contact_quantities("lin", quantities, scene, found, limits)
        out += [verdict.judge_value("lin", value, scene, found, limits) for value in values]
    return {"records": out, "json": [one.as_json() for one in out]}


def exact():
    scene = scene_of("lin-case1")
    rigid, tip = gate.rigid_screw_load_by_solver_and_formula(scene), gate.tip_deflection_by_solver_and_formula(scene)
    return [
        gate.sphere_on_flat_by_program_and_formula(scene, 225.0),
        [rigid, tip, gate.two_ball_load_by_solver_and_formula(scene)],
        gate.oversize_preload_by_solver_and_formula(scene, 7e-6),
    ]


def results():
    """Of every model that needs no file, on a scene that suits it."""
    scenes = [scene_of("lin-case2"), uneven()]
    every = [model for model in MODELS.values() if model.name != "condensed"]
    return [run_model(scene, model.name, OPTIONS) for scene in scenes for model in every if model.covers_scene(scene)]


def loaded():
    scene = uneven()
    result = loading.solve_with_scaled_loads(scene, 1.0, "lin", OPTIONS)
    bare = loading.solve_with_scaled_loads(scene, 0.0, "lin", OPTIONS)
    return {
        "result": result,
        "preload": loading.preload_from_unloaded(scene, bare),
        "lift off": loading.find_lift_off_loads(loading.SolutionsByLoad(scene, result, "lin", OPTIONS))[0],
    }


#: Makers of some seconds.
SLOW = ("results", "verdicts")
#: The last three are of the worst contact: two of unseen-flange have the same error, and round-off decides which is shown.
LEFT_OUT = re.compile(
    r"second|residual|iteration|memory|MB|balance|equilibrium|evaluations|round_off|^records\.pair|^json\.value|^json\.reference"
)


def kept(maker):
    """Means of all numbers that a function of this module makes."""
    return means(globals()[maker](), LEFT_OUT.search, properties=True)


@pytest.mark.parametrize("maker", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in RECORDED])
def test_no_number_of_a_study_moves(maker):
    same(kept(maker), RECORDED[maker])


if __name__ == "__main__":
    write(RECORD, {maker: kept(maker) for maker in RECORDED})
