"""The role of a shipped scene is said in its file and changes neither its hash nor the key of its runs."""

import re
import subprocess
import sys
from dataclasses import replace

import pytest

from rollbench.compare.errors import SceneError
from rollbench.compare.reference.store import content_key_of_run
from rollbench.compare.scenes import catalogue, scene_file


def test_hash_and_key_do_not_know_the_role():
    text = catalogue.shipped_scene_text("lin-case1")
    bare = re.sub(r'(?m)^role = "referenced"\n', "", text)
    assert bare != text
    assert scene_file.hash_of_scene_text(bare) == scene_file.hash_of_scene_text(text)
    assert scene_file.hash_of_scene_text(text.replace("lead", "Lead")) != scene_file.hash_of_scene_text(text)
    scene = catalogue.scene("lin-case1")
    other = replace(scene, role="")
    assert other == scene
    assert content_key_of_run(other, "", {"b_over_h": 2.0}, (0, 3)) == content_key_of_run(
        scene, "", {"b_over_h": 2.0}, (0, 3)
    )
    with pytest.raises(SceneError, match="role"):
        scene_file.scene_from_text(text.replace('role = "referenced"', 'role = "seen"'), "mine.toml")


DRAWING = {"gmsh", "pyvista", "matplotlib", "scipy.spatial"}


def test_no_slow_package_is_imported():
    """`list` reads no scene whole and needs no scipy; a solve begins without scipy, friction without scipy.spatial; names
    of scenes need no meshes and pictures, records of a report nothing that draws."""
    for code, heavy in (
        ("import rollbench.reports.content", {"matplotlib", "pyvista", "vtk", "jinja2"}),
        ("import rollbench.compare.commands.printed", {"numba", "scipy.linalg", "pydantic"}),
        ("import rollbench.compare.commands.solve", {"numba", "pydantic", "scipy.linalg", "scipy.special"}),
        ("import rollbench.compare.studies.friction.solve", {"numba", "scipy.spatial", "pydantic"}),
        ("from rollbench.compare.scenes import catalogue; catalogue.scene_names()", DRAWING),
    ):
        asked = f"import sys; {code}; print({heavy!r} & sys.modules.keys() or 'none')"
        out = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True)
        assert out.stdout.strip() == "none", (code, out.stdout, out.stderr)
