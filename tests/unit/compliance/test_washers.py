"""Washers of a thrust ball bearing: contact angles up to 90 deg, the compliance of a washer, its keys."""

from dataclasses import replace

import numpy as np
import pytest

import rollbench
from rollbench.compare.scenes import scene_file
from rollbench.lowfi.compliance import beyond_hertz, groove, parts, washer
from rollbench.meshes.washers import has_washers, washer_of_ring

SCENE = """
title = "Thrust ball bearing"
kind = "axis"
[material]
youngs_modulus = "206 GPa"
poissons_ratio = 0.3
[screw]
length = "200 mm"
outer_diameter = "30 mm"
conformity = 0.52
[[screw.plain]]
start = "0 mm"
end = "200 mm"
diameter = "1000 mm"
[[supports]]
at = "100 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]
[[loads]]
at = "100 mm"
force = ["0 N", "0 N", "3000 N"]
[ingredients]
hertz = "actual"
section = "full"
[[sets]]
name = "t"
thrust = "+z"
[sets.track]
pitch_diameter = "27.5 mm"
lead = "0 mm"
contact_angle = "ANGLE deg"
[sets.screw]
outer_diameter = "24.166 mm"
groove_radius = "2.57202 mm"
[sets.nut]
position = "100 mm"
length = "14 mm"
outer_diameter = "37.979 mm"
groove_radius = "2.57202 mm"
[sets.balls]
diameter = "4.763 mm"
count = 15
turns = 1
"""


def read(text: str):
    return scene_file.parse_scene(text, "washers.toml")


def displacement(angle: float, model: str, more: str = "") -> float:
    result = rollbench.solve(read(SCENE.replace("ANGLE", f"{angle:g}") + more), model=model)
    assert result.status == "converged"
    assert result.sets["t"].loads[:, 0] == pytest.approx(200.0 / np.sin(np.radians(angle)), rel=1e-3)
    assert not [warning for warning in result.warnings if "arc" in warning]
    return 1e6 * float(result.displacement[2])


@pytest.mark.slow
def test_displacement_is_smooth_up_to_90_deg():
    """The approach of rigid rings by Hertz at 90 deg, and the refined model's values (turn to 90 deg without a jump)."""
    assert displacement(90.0, "lin") == pytest.approx(10.737, abs=1e-3)
    angles = (80.0, 85.0, 88.0, 89.0, 90.0)
    refined = np.array([displacement(angle, "refined") for angle in angles])
    assert 10.2 < refined[-1] < 10.5
    assert displacement(89.999, "refined") == pytest.approx(refined[-1], rel=1e-6)
    # even in the distance from 90 deg: a parabola meets all values
    away = np.radians(90.0 - np.array(angles)) ** 2
    assert refined == pytest.approx(np.polyval(np.polyfit(away, refined, 2), away), rel=2e-5)


@pytest.mark.slow
def test_washer_is_nearly_a_half_space_where_it_is_large():
    """A groove of a large thick washer: a narrow patch sees a half space with the curvature of the flank."""
    scene = read(SCENE.replace("ANGLE", "90")).sets[0].parts
    geometry = parts.reduce_to_compliance_geometry(scene)
    flank, ring = parts.half_groove_of_body(geometry, True), washer_of_ring(geometry, True)
    large = replace(ring, bore=0.2 * ring.bore, outer=4.0 * ring.outer, back=ring.face + 12.0 * (ring.back - ring.face))

    def self_motion(of, fineness=1.0):
        found = washer.washer_compliance(flank, of, fineness)
        n = np.arange(float(len(found.harmonics)))
        shares = groove.gaussian_patch_harmonic_factors(n, found.patch_width, found.contact_radius)
        return float(shares @ found.harmonics[:, 3, 3]), found.patch_width

    thin, width = self_motion(ring)
    space = beyond_hertz.half_space_compliance(width, flank.material)
    assert thin == pytest.approx(self_motion(ring, 2.0)[0], rel=5e-4)
    assert thin < 0.8 * space  # the back is near
    assert self_motion(large, 2.0)[0] == pytest.approx(space, rel=0.1)


def test_dimensions_of_washers_are_keys():
    plain = displacement(90.0, "refined")
    thick = displacement(90.0, "refined", '[sets.track.washers]\nthickness = "8 mm"\n')
    assert 1.005 * plain < thick < 1.1 * plain
    scene = read(SCENE.replace("ANGLE", "90") + '[sets.track.washers]\nbore = "20 mm"\n').sets[0].parts
    assert has_washers(scene)
    assert washer_of_ring(scene, True).bore == pytest.approx(0.01)
    assert not any(has_washers(read(SCENE.replace("ANGLE", f"{angle}")).sets[0].parts) for angle in (20, 45))


@pytest.mark.parametrize(
    ("key", "value", "angle"),
    [
        ("bore", "26 mm", 90),
        ("outer_diameter", "28 mm", 90),
        ("groove_depth", "3 mm", 90),
        ("thickness", "1 mm", 90),
        ("bore", "20 mm", 40),
    ],
)
def test_impossible_washers_are_refused(key, value, angle):
    with pytest.raises(rollbench.InputError, match=key):
        read(SCENE.replace("ANGLE", f"{angle}") + f'[sets.track.washers]\n{key} = "{value}"\n')


def test_a_screw_has_no_contact_angle_of_90_deg():
    text = rollbench.read("lin-case1").to_toml()
    with pytest.raises(rollbench.InputError, match="contact_angle"):
        read(text.replace('contact_angle = "45 deg"', 'contact_angle = "90 deg"'))
