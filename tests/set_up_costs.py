"""Where the processor time of a level of a new screw goes, and what cheaper set-ups would do to its loads.

``python -m tests.set_up_costs`` measures it again (five minutes of one quiet core) and writes
``compare/references/set_up_costs.json``, which the report's tables on cold levels are made of.
"""

import json
from collections import defaultdict
from contextlib import contextmanager
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from tests import near_face

from rollbench.compare import __version__
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.reference.tasks import flanks_to_mesh, mesh_settings
from rollbench.compare.running import machine_description
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.run_times import SET_UP_COSTS, utc_date_today
from rollbench.hifi import condensation, linear_algebra, setup
from rollbench.hifi.bodies import coarse, patch
from rollbench.hifi.elements import forms
from rollbench.hifi.meshing.part_meshes import mesh_parts
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.shaft import section
from rollbench.meshes import ball_body, grooved_body
from rollbench.meshes.cache import Cache
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.processes import limit_to_one_thread
from rollbench.meshes.solid import dimensions_of_3d_parts

#: What a stage spends its time on: names of functions and the modules that call them; the dense algebra is a part of the
#: elimination.
WORK = {
    "meshing": ("best_of", (ball_body, grooved_body)),
    "assembly": ("assemble", (forms, section, patch)),
    "elimination": ("compliance_of_load_columns", (linear_algebra,)),
    "dense": ("_eliminate_front", (linear_algebra,)),
}
#: Jobs whose stages are measured: scene and level.
JOBS = (("new screw", 1), ("unseen-40x10", 1))
#: A flanged screw of the survey, which tries the cheaper set-ups too.
FLANGED = 200
#: Cells of the shafts that say what a cut does, over those of level 1: coarser ones, and those of levels 2 and 3.
CELLS = (1.3, 1.6, 0.86, 0.74)
#: Pitch radii over the screw's between which a library's patches are interpolated.
BETWEEN = (0.95, 1.05)


def scene_of(name):
    """The new screw is case 1 with another nut."""
    if name == "flanged":
        return near_face.scene_of(FLANGED)
    if name != "new screw":
        return catalogue.scene(name)
    scene = catalogue.scene("lin-case1")
    return replace(scene, nut=replace(scene.nut, length=56e-3, outer_diameter=50e-3))


@contextmanager
def timed(spent):
    """Add up the processor time of each kind of work."""

    def watched(kind, work):
        def run(*given, **named):
            begin = process_time()
            try:
                return work(*given, **named)
            finally:
                spent[kind] += process_time() - begin

        return run

    with pytest.MonkeyPatch.context() as put:
        for kind, (name, modules) in WORK.items():
            for module in modules:
                put.setattr(module, name, watched(kind, getattr(module, name)))
        yield


def stages_of(name, level):
    """Processor time [s] of every stage of a cold set-up and its loads in one process of one thread, by kind of work."""
    scene, spent, stages = scene_of(name), defaultdict(float), {}
    before = {"all": process_time()}

    def heard(text):
        total = {"all": process_time(), **spent}
        spent_here = {kind: round(value - before.get(kind, 0.0), 2) for kind, value in total.items()}
        stages[text.split(":")[0]] = {kind: value for kind, value in spent_here.items() if value}
        before.update(total)

    with timed(spent):
        settings = mesh_settings([scene], level)
        whole = setup.mesh_and_condense_geometry(scene, flanks_to_mesh(scene), settings, heard, cache=Cache(None))
        found = solve_reference(whole, scene)
    heard("contact loads:")
    return {"scene": name, "level": level, "contacts": int((found.contact_loads > 0.0).sum()), "stages": stages}


def ways_of(name):
    """Cheaper shafts and patches of a scene on level 1: processor time that they save [s], largest change of a load [% of
    the mean load]."""
    scene = scene_of(name)
    choices, wanted, shafts, compliances, spent, begun = mesh_settings([scene], 1), flanks_to_mesh(scene), [], [], [], []
    begin, local = coarse.contact_compliance_in_fine_submodel, coarse.local_contact_compliance
    finish = setup._correct_screw_stiffness

    def started(*given):
        begun.append(process_time())
        return begin(*given)

    def watched(*given):
        compliances.append(local(*given))
        spent.append(process_time() - begun[-1])
        return compliances[-1]

    with pytest.MonkeyPatch.context() as put:
        put.setattr(coarse, "contact_compliance_in_fine_submodel", started)
        put.setattr(coarse, "local_contact_compliance", watched)  # of groove and ball of one side after the other
        put.setattr(setup, "_correct_screw_stiffness", lambda *given: shafts.append(given) or finish(*given))
        base = setup.mesh_and_condense_geometry(scene, wanted, choices, cache=Cache(None))
    load = solve_reference(base, scene).contact_loads

    def row(way, changed, saved):
        moved = np.abs(solve_reference(changed, scene).contact_loads - load).max() / load[load > 0.0].mean()
        print(name, way, f"saves {saved:.2f} s, moves a load by {100.0 * moved:.4f} %", flush=True)
        return {"scene": name, "way": way, "saved": round(saved, 2), "moved": round(100.0 * float(moved), 4)}

    def of_right_flank(patches, compliance):
        return condensation.turn_patches_to_right_flank(replace(patches, local_compliance=compliance))

    def with_own(side, compliance):
        own = base.patches_by_flank[side]
        patches = {**base.patches_by_flank, side: replace(own, local_compliance=compliance)}
        if len(wanted) == 4:
            patches[side + 1] = of_right_flank(own, compliance)
        return replace(base, patches_by_flank=patches)

    one, other = (s for s in wanted if len(wanted) == 2 or s % 2 == 0)
    ball, nut = compliances[1], base.patches_by_flank[other].local_compliance
    if one % 2 != other % 2:
        ball = of_right_flank(base.patches_by_flank[one], ball).local_compliance
    between = np.mean([_own_of(scene, share, choices, wanted) for share in BETWEEN], axis=0)
    return [
        row("one ball's patch for screw and nut", with_own(other, nut - compliances[3] + ball), spent[3]),
        row("screw's patch from a library", with_own(one, between), spent[0] + spent[1]),
        *_shafts(scene, base, shafts[0], choices, row),
    ]


def _own_of(scene, share, choices, wanted):
    """Own compliance of the first flank of a screw whose pitch radius is a share of the scene's."""
    away = 2.0 * (share - 1.0) * scene.track.pitch_radius
    track = replace(scene.track, pitch_radius=share * scene.track.pitch_radius)
    screw, nut = (replace(x, outer_diameter=x.outer_diameter + away) for x in (scene.screw, scene.nut))
    near = replace(scene, track=track, screw=screw, nut=nut)
    m, dims = GrooveMap.from_scene(near), dimensions_of_3d_parts(near)
    meshes = mesh_parts(near, m, ball_layout(near), dims, wanted, choices)
    given = condensation.collect_flank_condensation_arguments(near, m, dims, meshes, wanted[0], choices)
    return condensation.condense_patches_of_flank(*given).local_compliance


def _shafts(scene, base, given, choices, row):
    """What other meshes, and another length, of the shafts do that say what a cut does."""
    screw, _, *rest = given
    m, e, outer, bore = base.groove_map, scene.screw.material, scene.screw.outer_diameter / 2.0, scene.screw.bore / 2.0
    grooved = section.stiffness_of_grooved_shaft(m, outer, bore, e)

    def shafts(size, lengths):
        begin, hole, cells = process_time(), base.solid_dimensions.hole, size * choices.cell
        meshed = [section.meshed_shaft_flexibility(m, outer, hole, e, cells, length) for length in lengths]
        spent, found = process_time() - begin, section.compute_equivalent_beam(m, bore, e, grooved, meshed)
        return replace(base, condensed_screw=setup._correct_screw_stiffness(screw, found, *rest)), spent

    whole = section.choose_lengths_of_fitted_shafts(m)
    longer = (whole[0], whole[0] + 2.0 * np.pi * abs(m.rg), whole[2])
    ways = {f"cut's cells {size:g} times as long": (size, whole) for size in CELLS}
    ways["long shaft one lead longer than the short one"] = (1.0, longer)
    usual = shafts(1.0, whole)[1]
    made = ((way, *shafts(*of)) for way, of in ways.items())
    return [row(way, changed, usual - spent) for way, changed, spent in made]


if __name__ == "__main__":
    limit_to_one_thread()
    found = {"version": __version__, "machine": machine_description(), "date": utc_date_today()}
    found["jobs"] = [stages_of(*job) for job in JOBS]
    found["ways"] = [row for name in ("new screw", "flanged") for row in ways_of(name)]
    (shipped_store() / SET_UP_COSTS).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
