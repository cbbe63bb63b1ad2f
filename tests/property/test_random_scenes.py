"""Random scenes over the ranges of the stability table: ours converges, balanced, or names a mechanism."""

import math
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from rollbench.compare.models.study import with_ball_count
from rollbench.compare.scenes.catalogue import scene as shipped
from rollbench.compare.studies.extreme_cases import HardScene, with_groove_radius_ratio, with_shaft_stiffness
from rollbench.compare.studies.extremes import ENERGY, solve_hard_scene_by_formulation
from rollbench.meshes.parts import BallErrors, Errors, Load, Support

BASE = shipped("lin-case1")


def powers(low: float, high: float) -> st.SearchStrategy[float]:
    """10 to a power between ``low`` and ``high``."""
    return st.floats(low, high).map(lambda x: 10.0**x)


@st.composite
def loads(draw):
    size = draw(powers(-2, 6))
    kind = draw(st.sampled_from(("axial", "lateral", "moment", "all", "none")))
    if kind == "none":
        return ()
    x, y, z = (size * draw(st.integers(-4, 4)) / 4.0 for _ in range(3))
    force = {"axial": (0.0, 0.0, size), "lateral": (x, y, 0.0), "moment": (0.0, 0.0, 0.0), "all": (x, y, z)}[kind]
    moment = (0.02 * y, 0.02 * x, 0.0) if kind in ("moment", "all") else (0.0, 0.0, 0.0)
    return (Load(draw(st.sampled_from((0.0, 0.3))), force, moment),)


SUPPORTS = st.one_of(
    st.sampled_from((BASE.supports, (Support(0.0, (("uz", 0.0), ("rz", 0.0))),), ())),
    st.sampled_from(("ux", "uz", "rz")).map(lambda name: (Support(0.0, ((name, 0.0),)),)),
    st.integers(-6, 6).map(lambda k: (*BASE.supports, Support(0.8, (("ux", 0.5e-3 * k), ("uy", 0.0))))),
)


def all_moduli(scene, factor):
    steel = replace(scene.screw.material, youngs_modulus=factor * scene.screw.material.youngs_modulus)
    return replace(scene, **{name: replace(getattr(scene, name), material=steel) for name in ("screw", "nut", "balls")})


@st.composite
def random_scenes(draw):
    scene = replace(BASE, loads=draw(loads()), supports=draw(SUPPORTS))
    angle, lead = math.radians(draw(st.floats(5, 85))), draw(st.sampled_from((7e-3, 20e-3, 40e-3)))
    track = replace(scene.track, contact_angle=angle, lead=lead, hand=draw(st.sampled_from(("right", "left"))))
    scene = replace(scene, track=track, nut=replace(scene.nut, length=0.1))
    extreme = draw(st.sampled_from(("conformity", "shaft", "moduli")))
    if extreme == "conformity":
        scene = with_groove_radius_ratio(scene, 1.0 + draw(powers(-5, -1)))
    elif extreme == "shaft":
        scene = with_shaft_stiffness(scene, draw(powers(-3, 3)))
    else:
        scene = all_moduli(scene, draw(powers(-3, 3)))
    # A screw that balls alone must hold in five freedoms, by one-sided contacts: not for a handful of them.
    clamped = len(scene.supports) > 0 and len(scene.supports[0].fixed) == 5
    scene = with_ball_count(scene, draw(st.sampled_from((1, 2, 3, 10, 32) if clamped else (32,))))
    room = 0.49 * (scene.screw.groove_radius - scene.balls.radius)  # a ball larger than its groove jams: refused
    half_width = min(draw(st.sampled_from((0.0, 2e-6, 20e-6))), room)
    oversize = min(draw(st.integers(-50, 20)) * 1e-6, room)
    balls = BallErrors(oversize=oversize, sigma=half_width / math.sqrt(3.0), distribution="uniform")
    return replace(scene, errors=Errors(balls=balls, seed=draw(st.integers(0, 99))), name="random")


@settings(max_examples=40, derandomize=True, deadline=None)
@given(random_scenes())
def test_ours_converges_or_names_the_mechanism(scene):
    row = solve_hard_scene_by_formulation(HardScene("random", "random", scene), ENERGY)
    if row.converged:
        assert row.residual is not None
        assert row.residual <= max(1e-10, row.round_off_bound)
    else:
        assert row.status.startswith("not held: "), row.status
