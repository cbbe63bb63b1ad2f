"""The role of a shipped scene is said in its file and changes neither its hash nor the key of its runs."""

import re
import subprocess
import sys
from dataclasses import replace

import pytest

from rollbench.comparison.errors import SceneError
from rollbench.comparison.models.comparison import REFERENCED
from rollbench.comparison.models.ladder import DEEP, UNSEEN
from rollbench.comparison.reference.store import key_of
from rollbench.comparison.scenes import catalogue, scene_file
from rollbench.comparison.wings.crosscheck.study import STUDIES


def test_roles_group_the_scenes_of_the_report():
    assert REFERENCED == ("lin-case1", "lin-case2", "lin-case3", "lin-case3-offset")
    assert {catalogue.scene(name).role for name in REFERENCED} == {"referenced"}
    assert [name.startswith("unseen-") for name in UNSEEN] == 11 * [True]
    assert set(DEEP) < {*UNSEEN, *STUDIES}


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


def test_list_and_solve_import_no_slow_package():
    """`list` reads no scene whole and needs no scipy; a solve begins without scipy, friction without scipy.spatial."""
    asked = "import sys; import {}; print(sorted({{'numba', 'scipy.{}', 'pydantic'}} & sys.modules.keys()))"
    for module, package, found in (
        ("rollbench.comparison.commands.listing", "linalg", "[]"),
        ("rollbench.comparison.commands.solving.solve", "linalg", "[]"),
        ("rollbench.comparison.commands.solving.solve", "special", "[]"),
        ("rollbench.comparison.wings.friction.solve", "spatial", "[]"),
    ):
        out = subprocess.run([sys.executable, "-c", asked.format(module, package)], capture_output=True, text=True)
        assert out.stdout.strip() == found, (module, package, out.stderr)
