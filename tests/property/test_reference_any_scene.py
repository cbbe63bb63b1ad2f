"""The 3D reference takes any scene through one path: coarse meshes, few balls, the low-order model as a rough check."""

from dataclasses import replace

import numpy as np
import pytest

from compare import catalogue
from compare.measure import load_error
from compare.models import Options, run_model
from compare.reference import BALL, needed_sides
from hifi.fit import Settings, expected_semi_axes
from hifi.reference import solve_reference
from hifi.setup import prepare
from meshes.parts import Balls, Load, Nut, Scene, Screw, Solid, Support, Track

HELD = (Support(0.0, (("ux", 0.0), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0), ("rz", 0.0))),)


def screw(R, lead, ball, groove, outer, nut, azimuths, force=300.0, **changes):
    """A short screw held close to its nut; ``nut``: length and outer diameter."""
    s = catalogue.scene("lin-case1")
    middle = nut[0] / 2.0 + 5e-3
    scene = Scene(
        "any", "any", Track(R, lead, np.pi / 4), Screw(2.0 * middle, outer, groove, s.screw.material),
        Nut(middle, nut[0], nut[1], groove, s.nut.material),
        Balls(ball, s.balls.material, tuple(float(a) for a in azimuths)),
        supports=(*HELD, Support(2.0 * middle, (("ux", 0.0), ("uy", 0.0)))), loads=(Load(0.0, (0.0, 0.0, force)),),
        solid=Solid(shaft=4e-3, shaft_diameter=outer),
    )  # fmt: skip
    return replace(scene, **changes)


def even(count, turns):
    return 2.0 * np.pi * turns * ((np.arange(count) + 0.5) / count - 0.5)


def scenes():
    table41 = even(71, 3.75)[24:47:2]  # 19 balls a turn: those of the next turn lie between
    yield "turns that do not line up", screw(14.5e-3, 7e-3, 2e-3, 2.16e-3, 28e-3, (20e-3, 44e-3), table41)
    own = even(45, 2.5)[18:27]
    yield "another lead and section", screw(20e-3, 10e-3, 3e-3, 3.18e-3, 38.6e-3, (20e-3, 64e-3), own)
    uneven = (-2.9, -2.4, -0.6, 0.4, 0.85, 2.6)
    yield "uneven pattern", screw(16.5e-3, 20e-3, 2.778e-3, 3.254e-3, 32e-3, (36e-3, 48e-3), uneven)
    left = screw(16.5e-3, 20e-3, 2.778e-3, 3.254e-3, 32e-3, (36e-3, 48e-3), even(6, 1.0))
    yield "left hand, load the other way", replace(
        left, track=replace(left.track, hand="left"), loads=(Load(0.0, (0.0, 0.0, -300.0)),),
        solid=replace(left.solid, nut_held="outer surface"),
    )  # fmt: skip
    starts = screw(16.5e-3, 40e-3, 2.778e-3, 3.254e-3, 32e-3, (36e-3, 48e-3), even(4, 0.7))
    yield "two starts", replace(starts, track=replace(starts.track, starts=2))
    yield "bearing of 9 balls, preload", catalogue.scene("bearing-9-preload")
    rigid = replace(left, solid=replace(left.solid, nut="rigid"))
    yield "rigid nut", rigid


ALL = dict(scenes())


@pytest.mark.parametrize("name", ALL)
def test_any_scene_converges_in_balance_and_near_the_low_order_model(name):
    scene = ALL[name]
    ratio = scene.balls.radius / BALL
    axes = expected_semi_axes(scene)
    settings = Settings(
        b_over_h=1.2, semi=axes, reach=axes, fine=2.5e-3 * ratio, coarse=10e-3 * ratio, ball_fine=0.9e-3 * ratio,
        ball_coarse=1.8e-3 * ratio, modes=12,
    )  # fmt: skip
    sides = needed_sides(scene)
    made = prepare(scene, sides, settings)
    result = solve_reference(made, scene)
    assert result.status == "converged"
    assert max(result.balance, result.screw_balance) < 1e-8
    assert abs(result.along_groove) < 1e-3
    low = run_model(scene, "lin", Options(discretisation=False))
    assert low.converged
    error = load_error(low.load, result.load)
    assert error.rms_percent < 12.0, error
    assert min(made.quality[k] for k in ("screw", "nut", "ball")) > 0.0
    assert made.quality["deviation"] < 1e-12 or scene.track.lead == 0.0
