"""The role of a shipped scene is said in its file and changes neither its hash nor the key of its runs."""

import re
import subprocess
import sys
from dataclasses import replace

import pytest

from rollbench.compare.errors import SceneError
from rollbench.compare.models import comparison, ladder
from rollbench.compare.reference.store import key_of
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.crosscheck.study import STUDIES


def test_roles_group_the_scenes_of_the_report():
    assert comparison.REFERENCED == ("lin-case1", "lin-case2", "lin-case3", "lin-case3-offset")
    assert {catalogue.scene(name).role for name in comparison.REFERENCED} == {"referenced"}
    assert [name.startswith("unseen-") for name in ladder.UNSEEN] == 11 * [True]
    assert set(ladder.DEEP) < {*ladder.UNSEEN, *STUDIES}


def test_hash_and_key_do_not_know_the_role():
    text = catalogue.scene_text("lin-case1")
    bare = re.sub(r'(?m)^role = "referenced"\n', "", text)
    assert bare != text
    assert scene_file.scene_hash(bare) == scene_file.scene_hash(text)
    assert scene_file.scene_hash(text.replace("lead", "Lead")) != scene_file.scene_hash(text)
    scene = catalogue.scene("lin-case1")
    other = replace(scene, role="")
    assert other == scene
    assert key_of(other, "", {"b_over_h": 2.0}, (0, 3)) == key_of(scene, "", {"b_over_h": 2.0}, (0, 3))
    with pytest.raises(SceneError, match="role"):
        scene_file.loads(text.replace('role = "referenced"', 'role = "seen"'), "mine.toml")


def test_headings_say_what_whole_scenes_say():
    for name in catalogue.scene_names():
        scene = catalogue.shipped(name)
        assert (catalogue.heading(name)["title"], catalogue.kind(name)) == (scene.title, scene_file.kind_of(scene)), name


DRAWING = {"gmsh", "pyvista", "matplotlib", "scipy.spatial"}


def test_no_slow_package_is_imported():
    """`list` reads no scene whole and needs no scipy; a solve begins without scipy, friction without scipy.spatial; names
    of scenes need no meshes and pictures, records of a report nothing that draws."""
    for code, heavy in (
        ("import rollbench.reports.content", {"matplotlib", "pyvista", "vtk", "jinja2"}),
        ("import rollbench.compare.commands.list", {"numba", "scipy.linalg", "pydantic"}),
        ("import rollbench.compare.commands.solve", {"numba", "pydantic", "scipy.linalg", "scipy.special"}),
        ("import rollbench.compare.studies.friction.solve", {"numba", "scipy.spatial", "pydantic"}),
        ("from rollbench.compare.scenes import catalogue; catalogue.scene_names()", DRAWING),
    ):
        asked = f"import sys; {code}; print({heavy!r} & sys.modules.keys() or 'none')"
        out = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True)
        assert out.stdout.strip() == "none", (code, out.stdout, out.stderr)
