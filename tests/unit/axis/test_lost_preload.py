"""A nut that the load frees is warned of, with the factor on the loads at which its last contact opens."""

import re

import pytest

import rollbench
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.scenes.template import new_scene_text


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    path = tmp_path_factory.mktemp("pair") / "pair.toml"
    path.write_text(new_scene_text("double nut", "25x5"), encoding="utf-8")
    return rollbench.read(path)


def lost(scene):
    return [w for w in rollbench.solve(scene, "lin").warnings if "lost its preload" in w]


def test_both_nuts_of_the_template_keep_a_fifth_of_their_preload(pair):
    result = rollbench.solve(pair, "lin")
    assert not [w for w in result.warnings if "lost its preload" in w]
    assert min(abs(x.force[2] / x.preload.axial) for x in result.sets.values()) > 0.2


@pytest.mark.slow
@pytest.mark.parametrize("factor", [2.6, 4.0])
def test_the_factor_is_where_the_last_contact_opens(pair, factor):
    """One load leaves the freed nut a few newtons, the other nothing."""
    scene = with_scaled_loads(pair, factor)
    (words,) = lost(scene)
    opens = float(re.search(r"([\d.]+) times the loads open it", words)[1])
    before, after = (rollbench.solve(with_scaled_loads(scene, x * opens), "lin").sets["nut 1"] for x in (0.98, 1.02))
    assert words.startswith("nut 1 has lost its preload")
    assert (before.loads.sum() > 0.0, after.loads.sum()) == (True, 0.0)
