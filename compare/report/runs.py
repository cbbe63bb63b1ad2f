"""Runs of the 3D reference that the validation report needs: the missing ones are computed before its sections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from pathlib import Path

from rollbench.compare.case import all_cases
from rollbench.compare.models import uncertainty
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.modelling import DEEP, REFINED, UNSEEN, VARIED
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference import estimate, jobs
from rollbench.compare.reference.levels import LEVELS, STUDIED
from rollbench.compare.sections.reference import modelling_uncertainty_by_scene
from rollbench.compare.sections.u_val import mesh_uncertainty_parameters

Step = Callable[[str], None]


def compute_missing_3d_runs(
    cache: SceneResultCache, engine: jobs.ComputingSettings, step: Step, *, fresh: bool = False
) -> list[str]:
    """Compute those runs of the 3D reference that the report needs and that are not stored yet; return what it needs.

    The runs are written to the first folder of stored runs; without such a folder, nothing is done. ``engine``: settings of
    the computation. ``step`` is called with each line of progress. ``fresh``: whether stored runs are computed anew.
    """
    if cache.reference_folders is None:
        return []
    # loads scikit-fem, which the page of a scene does without
    from rollbench.compare.studies.crosscheck.study import scenes_and_levels_for_report as checked_references

    scenes = [cache.built_in_scene(name) for name in REFERENCED]
    if cache.quick:
        tasks = jobs.plan_reference_tasks(scenes[:2], (min(LEVELS),))
    else:
        tasks = jobs.plan_reference_tasks(scenes, STUDIED, with_source_mesh=True, leave_out_each_part=True)
        for name in VARIED:
            refined = jobs.variant_names(refined=True) if name == REFINED else ()
            tasks += jobs.plan_reference_tasks(
                [cache.built_in_scene(name)], (), (*jobs.variant_names(refined=False), *refined)
            )
        tasks += jobs.plan_reference_tasks([cache.built_in_scene(name) for name in UNSEEN], STUDIED)
        of_cases = (case.import_object(case.references) for case in all_cases() if case.references)
        for names, levels in chain.from_iterable(of(fresh) for of in (checked_references, *of_cases)):
            tasks += jobs.plan_reference_tasks([cache.built_in_scene(name) for name in names], levels)
        tasks += jobs.plan_reference_tasks([cache.built_in_scene(name) for name in DEEP], (max(LEVELS),))
        tasks.sort(key=lambda task: -jobs.expected_time_and_memory(task).seconds)
    stores = cache.reference_folders
    jobs.ensure_runs_are_stored(tasks, stores[0], engine, step, stores[1:], compute_again=fresh)
    if not cache.quick:
        save_uncertainty_parameters(stores)
    return [task.label for task in tasks]


def save_uncertainty_parameters(stores: Sequence[Path]) -> None:
    """Store the two contributions to the uncertainty of the 3D reference that are estimated from all compared scenes.

    One is the part of the mesh uncertainty that the mesh levels of a single scene do not show; the other is due to
    modelling choices. ``stores``: folders of 3D runs, to the first of which both are written.
    """
    study = SceneResultCache(stores)
    known = mesh_uncertainty_parameters(study)
    if known is not None:
        estimate.save_uncertainty_of_other_scenes(stores[0], known)
    found = [*modelling_uncertainty_by_scene(study).values()]
    if len(found) == len(VARIED):
        uncertainty.save_choice_effects(stores[0], found)
