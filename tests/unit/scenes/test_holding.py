"""How a nut is held: keys of its flange and of where it is held, what is assumed, what is refused."""

import pytest

from rollbench.compare.errors import SceneError
from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.template import commented_template
from rollbench.meshes import parts, solid

FLANGE = '[nut.flange]\ndiameter = "72 mm"\nthickness = "11 mm"\n'


def read(text: str, lead: str = "20 mm"):
    tables = commented_template().replace('lead = "20 mm"', f'lead = "{lead}"', 1) + text
    return scene_file.scene_from_text(tables, "a.toml")


def test_a_flange_holds_its_nut_by_its_whole_face_unless_the_file_says_more() -> None:
    scene = read(FLANGE)
    assert scene.nut.flange == parts.Flange(72e-3, 11e-3, (24e-3, 36e-3))
    dims = solid.dimensions_of_3d_parts(scene)
    assert (dims.nut_held, dims.held_radii) == ("flange face", (24e-3, 36e-3))
    assert "bonded to a rigid housing all over its annulus, 48 to 72 mm in diameter" in " ".join(dims.assumed)
    bolted = solid.dimensions_of_3d_parts(read(FLANGE + "[nut.held]\nbolts = 6\n"))
    assert bolted.nut_held == "flange face, 6 bolts"
    assert "low-order models hold the whole annulus" in " ".join(bolted.assumed)
    fit = FLANGE + 'side = "right"\ncentring = "10 mm"\n[nut.held]\nouter_diameter = "60 mm"\ncentring = "bonded"\n'
    scene = read(fit)
    assert scene.nut.flange == parts.Flange(72e-3, 11e-3, (24e-3, 30e-3), "right", 10e-3, bonded=True)
    assert solid.dimensions_of_3d_parts(scene).nut_held == "flange face and centring"
    at = pytest.approx([0.427, 0.416, 0.406])
    assert scene.nut.flange.stations(0.373, 0.427) == at


def test_the_face_at_a_flange_reaches_as_far_as_the_flange() -> None:
    for side, radius in (("left", 36e-3), ("right", 24e-3)):
        dims = solid.dimensions_of_3d_parts(read(FLANGE + f'side = "{side}"\n[nut.held]\nat = "left face"\n'))
        assert dims.held_radii == pytest.approx((17e-3, radius))


def test_the_former_key_is_read_and_the_new_one_said() -> None:
    old, new = (read(f"[{where}]\n{key} = 'right face'\n") for where, key in (("solid", "nut_held"), ("nut.held", "at")))
    assert old.solid == new.solid
    assert set(old.assumed) - set(new.assumed) == {'The former key solid.nut_held = "right face" is read as nut.held.at.'}


def test_a_ring_has_no_flange() -> None:
    with pytest.raises(SceneError, match=r"nut.flange: .* a lead above 0 mm"):
        read(FLANGE, lead="0 mm")
