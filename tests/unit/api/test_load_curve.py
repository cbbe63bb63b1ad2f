"""The signed load curve: lash and stiffness against closed forms and the solvers' tangents, points without equilibrium."""

from dataclasses import replace
from math import cos, radians, sin, sqrt

import numpy as np
import pytest

import rollbench
from rollbench.compare.models.answers import tangent_stiffness_at
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import BallErrors, Errors, Load, Scene, Support

RING = catalogue.scene("bearing-9")


def loose(scene: Scene, gap: float) -> Scene:
    """The scene with balls too small in radius by a gap [m]."""
    return replace(scene, errors=Errors(balls=BallErrors(oversize=-gap)))


def play(gap: float) -> float:
    """Axial play [m] of arcs at 45 deg, balls too small by a gap [m]: centres move until the ball touches both."""
    apart = RING.screw.groove_radius + RING.nut.groove_radius - 2.0 * RING.balls.radius
    angle = radians(45.0)
    return 2.0 * (sqrt((apart + 2.0 * gap) ** 2 - (apart * cos(angle)) ** 2) - apart * sin(angle))


@pytest.mark.parametrize("gap", [1e-6, 4e-6, 30e-6])
def test_lash_of_a_four_point_bearing_is_its_axial_play(gap: float) -> None:
    found = rollbench.load_curve(loose(RING, gap), "-2kN:2kN:5", "lin")
    assert found.lash == pytest.approx(play(gap), abs=1e-9)
    low, mid, high = found.points[0], found.points[2], found.points[4]
    assert (mid.displacement, mid.stiffness, mid.largest) == (None, None, 0.0)
    assert high.displacement == pytest.approx(-low.displacement, rel=1e-9)
    assert found.forward == pytest.approx(2e3 / (high.displacement - 0.5 * found.lash), rel=1e-9)
    assert found.peak_to_peak == pytest.approx(found.lash + 2e3 / found.forward + 2e3 / found.backward, rel=1e-9)


def test_preload_and_an_exact_fit_have_no_lash() -> None:
    tight = rollbench.load_curve("bearing-9-preload", "-500N:500N:3", "lin")
    fit = rollbench.load_curve(RING, "-500N:500N:3", "lin")
    assert (tight.lash, fit.lash) == (0.0, 0.0)
    assert (tight.points[1].stiffness > 0.0, fit.points[1].stiffness) == (True, None)
    assert [tight.points[1].displacement, fit.points[1].displacement] == [0.0, 0.0]


@pytest.mark.parametrize("along", ["z", "x", "30deg"])
def test_tangent_is_that_of_the_solver_in_every_direction(along: str) -> None:
    """The compliance along the force of the tangent stiffness, without the freedom that a support holds."""
    scene = replace(RING, errors=replace(RING.errors, balls=BallErrors(oversize=2e-6)))
    found = rollbench.load_curve(scene, f"-800N:1600N:4:{along}", "lin")
    d = np.array([*found.direction, 0.0, 0.0])
    for point in (found.points[0], found.points[3]):
        loads = (Load(RING.nut.position, tuple(point.load * d[:3])),)
        K = tangent_stiffness_at(replace(scene, loads=loads), RING.nut.position, "lin", ModelOptions()).matrix
        assert point.stiffness == pytest.approx(1.0 / (d @ np.linalg.solve(K[:5, :5], d)), rel=1e-4)


def test_factors_are_on_all_loads_and_their_curve_passes_the_scene_as_it_is() -> None:
    found = rollbench.load_curve("bearing-9", "0:1.5:4", "lin")
    solved = rollbench.solve("bearing-9", "lin")
    at = found.points[2]
    assert (at.factor, at.largest) == (1.0, pytest.approx(solved.loads.max()))
    assert at.displacement == pytest.approx(np.dot(solved.displacement[:3], found.direction))
    assert (found.lash, found.lash_words) == (None, "all loads have the same sign")
    frame, figure = found.to_dataframe(), found.figure()
    assert frame["largest_load_N"][2] == pytest.approx(solved.loads.max())
    assert (frame.attrs["units"]["nut_displacement_um"], len(figure.panels)) == ("um", 5)


def test_a_load_without_equilibrium_is_a_point_with_its_reason() -> None:
    """A screw that may turn runs off its nut under any load along it."""
    scene = replace(catalogue.scene("lin-case1"), supports=(Support(0.0, (("ux", 0.0), ("uy", 0.0))),))
    found = rollbench.load_curve(scene, "-1kN:1kN:3", "lin")
    low, mid, high = found.points
    assert (mid.status, found.converged) == ("converged", False)
    for point in (low, high):
        assert "screw motion along the helix" in point.status
        assert (point.displacement, point.largest, point.stiffness) == (None, None, None)
    assert (found.lash, found.forward) == (None, None)


@pytest.mark.slow
def test_forces_take_the_place_of_the_loads_where_asked_also_on_housings() -> None:
    axis = rollbench.read("axis-fixed-fixed")
    found = rollbench.load_curve(axis, "-1kN:1kN:3", "lin")
    assert found.at == axis.housings[0].name
    pushed = replace(axis, housings=tuple(replace(h, force=(0.0, 0.0, 1e3)) for h in axis.housings))
    solved = rollbench.solve(pushed, "lin")
    assert found.points[2].displacement == pytest.approx(solved.displacement[2], rel=1e-9)
    assert found.points[2].largest == pytest.approx(max(s.loads.max() for s in solved.sets.values()), rel=1e-9)
    assert found.points[2].nut_displacement == pytest.approx(solved.nut.displacement, rel=1e-9)


@pytest.mark.slow
def test_several_nuts_together_have_the_displacement_that_solve_states() -> None:
    nuts = rollbench.read("double-nut")
    (at, force) = (nuts.loads[0].at, nuts.loads[0].force)
    assert force[:2] == (0.0, 0.0)
    found = rollbench.load_curve(nuts, f"0N:{force[2]}N:2:{1e3 * at}mm", "lin")
    known = rollbench.solve(nuts, "lin").nut
    assert (known.of, found.points[0].nut_displacement) == ("2 nuts", None)
    assert found.points[1].nut_displacement == pytest.approx(known.displacement, rel=1e-9)
