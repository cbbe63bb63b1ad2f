"""STEP files of a scene's parts hold the exact bodies, and their helical flanks are near the exact ones."""

import numpy as np
import pytest

from rollbench.compare.commands.export import write_step_bodies
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.export import nuts_and_bearings_on_shaft
from rollbench.meshes import shell
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout


def volumes(path):
    """Sorted volumes [mm3] of a file's solids, and how many surfaces it has."""
    with shell.gmsh_session() as gmsh:
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        return sorted(gmsh.model.occ.getMass(*e) for e in gmsh.model.getEntities(3)), len(gmsh.model.getEntities(2))


def test_rings_have_their_grooves_in_the_solids(tmp_path):
    (path,) = write_step_bodies(catalogue.scene_of_any_kind("two-balls"), tmp_path / "parts.step").data["files"]
    found, _ = volumes(path)
    ball = 4.0 / 3.0 * np.pi * 4.005**3
    r = np.linspace(18.4 - 4.0, 18.4, 200001)[:-1]  # the groove of the inner ring: 2 pi r times its width at r
    centre, radius = 20.0 + 0.4 * np.cos(np.pi / 4.0), 4.4
    width = 2.0 * np.maximum(np.sqrt(np.maximum(radius**2 - (r - centre) ** 2, 0.0)) - 0.4 * np.sin(np.pi / 4.0), 0.0)
    inner = np.pi * (18.4**2 - 11.0**2) * 14.0 - float((2.0 * np.pi * r * width).sum() * (r[1] - r[0]))
    assert found[:3] == pytest.approx([ball, ball, inner], rel=1e-5)
    assert len(found) == 4


def test_helical_flanks_are_surfaces_in_a_second_file(tmp_path):
    answer = write_step_bodies(catalogue.scene_of_any_kind("lin-case1-cut"), tmp_path / "parts.step")
    assert 0.0 < answer.data["largest_distance_um"] < 1.0
    solids, surfaces = volumes(answer.data["files"][1])
    assert (len(solids), surfaces) == (0, 4)


def test_both_nuts_of_a_double_nut_are_in_place():
    scene = catalogue.scene_of_any_kind("double-nut")
    one, two = nuts_and_bearings_on_shaft(scene)
    assert one.shaft_segment_ends[1] == pytest.approx(two.shaft_segment_ends[0])
    assert (one.nut_displacement, two.nut_displacement) == pytest.approx([s.offset for s in scene.sets])


def test_balls_have_their_errors(tmp_path):
    scene = catalogue.scene("lin-case2")
    radii = draw_geometry_with_errors(scene, ball_layout(scene)).ball_radii
    (path, _) = write_step_bodies(scene, tmp_path / "parts.step").data["files"]
    found, _ = volumes(path)
    assert found[: radii.size] == pytest.approx(4.0 / 3.0 * np.pi * (1e3 * np.sort(radii)) ** 3, rel=1e-6)
