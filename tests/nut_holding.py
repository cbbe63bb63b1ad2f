"""What the way in which a nut is held does in 3D, six single bolts among the ways, for the report's section on it.

``python -m tests.nut_holding`` adds the ways that ``compare/references/nut_holding.json`` lacks (a minute or two of
one core each, five for the first of a size).
"""

import json
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from rollbench.compare.cases.external.evidence import scene_name_of_catalogue_size
from rollbench.compare.cases.external.page import FIXATION_FILE, scenes_by_nut_fixation
from rollbench.compare.models.model_form import axial_contact_force
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.reference.tasks import flanks_to_mesh, mesh_settings
from rollbench.compare.scenes import catalogue
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import mesh_and_condense_geometry
from rollbench.meshes.cache import Cache
from rollbench.meshes.parts import SIDES, Load, Scene

#: Sizes and mesh levels that are solved: a finer one for the size of fewest balls, which shows what the mesh changes; and
#: the element size of the shaft that says what a cut does, over the level's (twice as large: 0.02 % of the mean load).
CASES = (("bnf-3205-2p5", 1, 1.0), ("bnf-4010-5", 1, 2.0), ("hiwin-63-10k5", 1, 2.0), ("bnf-3205-2p5", 2, 1.0))


def solved(scene: Scene, first: Scene, level: int, cells: float, cache: Path) -> dict[str, object]:
    """Contact loads [N] by loaded side and rigidity [N/m] of a scene in 3D, on the meshes' settings of ``first``."""
    centre = scene.nut.position
    scene = replace(scene, loads=(*scene.loads, Load(centre)))  # of nothing, so that the section there is found
    sides, settings = flanks_to_mesh(first), mesh_settings([first], level)
    settings = replace(settings, cell=cells * settings.cell)
    found = solve_reference(mesh_and_condense_geometry(scene, sides, settings, print, cache=Cache(cache)), scene)
    moved = float(np.interp(centre, found.centreline_positions, found.centreline_motion[:, 2]))
    rigidity = round(axial_contact_force(scene, found.contact_loads, found.contact_angles) / moved)
    load = {SIDES[s]: found.contact_loads[:, s].round(3).tolist() for s in sides}
    return {"level": level, "status": found.status, "rigidity": rigidity, "load": load}


def main() -> None:
    """Solve all ways of all cases that are not yet there and write them."""
    path = shipped_store() / FIXATION_FILE
    rows = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    with TemporaryDirectory() as cache:
        for size, level, cells in CASES:
            shipped = catalogue.scene(scene_name_of_catalogue_size(size))
            scenes = scenes_by_nut_fixation(shipped)
            known = {row["held"] for row in rows if (row["scene"], row["level"]) == (shipped.name, level)}
            for held in [x for x in scenes if x not in known]:
                print(shipped.name, held, flush=True)
                found = solved(scenes[held], scenes["left face"], level, cells, Path(cache))
                rows.append({"scene": shipped.name, "held": held, **found})
                text = ",\n ".join(json.dumps(row) for row in rows)
                path.write_text(f"[\n {text}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
