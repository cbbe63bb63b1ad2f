"""Contact loads of the refined model balance where its bodies bend far more than the contacts yield."""

from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import scene_file

RING = """title = "thin ring with many small balls"
[material]
youngs_modulus = "310 GPa"
poissons_ratio = 0
[track]
pitch_radius = "100 mm"
lead = "0 mm"
contact_angle = "53.6 deg"
[screw]
length = "30 mm"
outer_diameter = "199.3 mm"
bore = "100 mm"
groove_radius = "2.216 mm"
[nut]
position = "10 mm"
length = "8.7 mm"
outer_diameter = "250 mm"
groove_radius = "2.216 mm"
[balls]
radius = "2.1845 mm"
count = 38
[errors]
seed = 255582823
[errors.balls]
oversize = "15.7 um"
sigma = "0.025 um"
[[supports]]
at = "18.8 mm"
fix = ["ux", "uy", "rx", "ry"]
displace = { rz = "-2.22 mrad" }
[[supports]]
at = "14 mm"
fix = ["ux", "uy", "rx", "ry"]
[[loads]]
at = "13.6 mm"
moment = ["0.1 N m", "-1.8 N m", "0 N m"]
[ingredients]
hertz = "nominal"
screw = "rigid"
"""


def test_loads_that_almost_cancel_balance_to_round_off_of_the_loads() -> None:
    """Motions G f of a plate that bends are sums of large terms, whose round-off must not become a force."""
    scene = scene_file.single_nut_scene_or_raise(scene_file.parse_scene(RING, "ring.toml"), "ring.toml")
    result = run_model(scene, "refined", ModelOptions(engine="compiled", estimate_beam_mesh_error=False))
    assert result.converged
    assert result.equilibrium.force_residual < 2e-14
