"""What the mesh levels leave out of a nut's compliance beside a free face, from nuts of six balls solved alone.

``python -m tests.near_face`` writes it again (six minutes of one core): ``compare/references/near_face.json``.
"""

import json
from dataclasses import replace
from functools import partial

import numpy as np

from rollbench.compare.reference.estimate import LIP_FILE
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.reference.tasks import flanks_to_mesh, mesh_settings
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.survey import SEED, random_screw_scene_text
from rollbench.hifi.bodies.patch import condense_patch
from rollbench.hifi.condensation import condense_nut
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.helix import ball_layout, lead_per_radian
from rollbench.meshes.parts import Scene
from rollbench.meshes.sockets import points_in_box_at_azimuth_zero
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Scenes by number of the survey (None: lin-case1), distances of the last ball from the face in ball radii, levels.
CASES = ((None, (1.02, 1.1, 1.2, 1.35, 1.6, 2.0), (1, 2, 3, 4)), (6, (1.1, 1.3), (1,)), (89, (1.02, 1.2), (1,)))
#: What is finer than level 3 in the bodies that judge: sizes over the ball's radius, cuts of the sockets, modes.
FINE, COARSE, CUTS, MODES = 0.198, 1.08, (5, 4, 5), 28
#: Half the length of the nut over the ball's radius.
HALF = 5.0
#: Flank of the nut that is pressed towards its high, free face.
PRESSED = 3
#: What meshes a patch, and what a coarser one that carries it.
PATCHES = (part_meshes.mesh_patch, part_meshes.mesh_coarser_patch)


def scene_of(number: int | None) -> Scene:
    """Scene of a case."""
    if number is None:
        return catalogue.scene("lin-case1")
    return scene_file.scene_from_text(random_screw_scene_text(SEED, number), f"survey-{SEED}-{number}.toml")


def settings(scene: Scene, level: int | None) -> Settings:
    """Mesh settings of a level, or of the bodies that judge."""
    if level is not None:
        return mesh_settings([scene], level)
    r = scene.balls.radius
    return replace(mesh_settings([scene], 3), fine=FINE * r, coarse=COARSE * r, cuts=CUTS, modes=MODES)


def lip(scene: Scene, distance: float, choices: Settings) -> float:
    """Compliance [m/N] by which the nut's last contact, so many ball radii from its free face and pressed towards it,
    exceeds one in the middle: the mean motion under Hertz's pressure on its own patch."""
    r, rg = scene.balls.radius, lead_per_radian(scene.track)
    away, step = (HALF - distance) * r / rg, float(np.diff(np.sort(scene.balls.azimuths)).min())
    behind = step * (1.0 if rg > 0.0 else -1.0)
    azimuths = (-step, 0.0, step, away - 2.0 * behind, away - behind, away)
    near = replace(
        scene,
        balls=replace(scene.balls, azimuths=tuple(scene.track.phase + x for x in azimuths)),
        nut=replace(scene.nut, length=2.0 * HALF * r),
        solid=replace(scene.solid, nut_held="left face"),
    )
    m, layout, dims, nut = GrooveMap.from_scene(near), ball_layout(near), dimensions_of_3d_parts(near), near.nut
    sides = tuple(s for s in flanks_to_mesh(scene) if s >= 2)
    size = part_meshes.choose_refinement_box_size(near, m, layout, (0, 1, 2, 3), dims, choices)
    widths = (size.gamma * float(m.radius.mean()), size.phi * m.R)
    zone = part_meshes.choose_patch_cells(choices, widths, size.depth)[1]
    ends = nut.position - HALF * r, nut.position + HALF * r
    places = part_meshes.contact_positions_on_body(layout, sides, False)
    spec = GroovedBodySpec(
        dims.land, nut.outer_diameter / 2.0, *ends, False, places, size, choices.fine, choices.coarse, dims.groove_ends
    )
    body, e, patches = mesh_grooved_body(m, spec), nut.material, {}
    for side in sides:
        place, socket = partial(points_in_box_at_azimuth_zero, m, size, side), body.box_faces[side]
        fits = part_meshes.FlankSockets(socket, socket, size, zone, widths)
        mesh, carrier = (mesh_of(fits, socket, place, choices) for mesh_of in PATCHES)
        normals = part_meshes.contact_normals_of_patch(mesh, np.array([m.R, 0.0, 0.0]))
        patches[side] = condense_patch(mesh, normals, e.youngs_modulus, e.poissons_ratio, carrier)
    found, patch = condense_nut(e, body, layout, sides, patches, choices, dims), patches[PRESSED]
    flat = patch.contact_points - points_in_box_at_azimuth_zero(m, size, PRESSED, np.zeros((1, 3)))
    axes = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)[2][:2]
    force = patch.nodal_areas * np.sqrt(np.maximum(1.0 - ((flat @ axes.T / choices.semi) ** 2).sum(axis=1), 0.0))
    counts = [found.modes_by_flank[s].shape[1] for s in sides]
    v, start = force / force.sum() @ found.modes_by_flank[PRESSED], sum(counts[: sides.index(PRESSED)])

    def moved(ball: int) -> float:
        """Compliance [m/N] of a ball's contact."""
        rows = slice(ball * sum(counts) + start, ball * sum(counts) + start + v.size)
        return float(v @ found.G[rows, rows] @ v)

    return moved(5) - moved(1)


def measured(number: int | None, distance: float, level: int | None) -> float:
    """`lip` of a case, times Young's modulus and the ball's radius [-]."""
    scene = scene_of(number)
    return lip(scene, distance, settings(scene, level)) * scene.nut.material.youngs_modulus * scene.balls.radius


def main() -> None:
    """Measure all cases and write them."""
    rows = []
    for number, distance, levels in ((number, x, levels) for number, distances, levels in CASES for x in distances):
        fine = measured(number, distance, None)
        missing = {str(k): round(fine - measured(number, distance, k), 4) for k in levels}
        rows.append({"scene": scene_of(number).name, "radii": distance, "lip": round(fine, 4), "missing": missing})
        print(json.dumps(rows[-1]), flush=True)
    text = ",\n ".join(json.dumps(row) for row in rows)
    (shipped_store() / LIP_FILE).write_text(f"[\n {text}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
