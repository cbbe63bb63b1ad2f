"""What a stretched or bent screw does to its contacts by Poisson's ratio: closed forms, reciprocity, and where nothing."""

from dataclasses import replace

import numpy as np
import pytest

from compare.scenes import catalogue
from lowfi.compliance.bodies import geometry_only, grooved_section
from lowfi.statics.problem import Problem, build
from lowfi.statics.shaft import shaft_of
from lowfi.statics.squeeze import loaded_beyond, squeeze_rows, squeezed
from meshes.errors import specimen
from meshes.helix import ball_layout, nominal_contact_points
from meshes.parts import FREEDOMS, Load, Scene, Support

CASE = catalogue.scene("lin-case1")
HELD = Support(0.0, tuple((name, 0.0) for name in FREEDOMS))
RIGHT = CASE.screw.length


def problem_of(scene: Scene) -> Problem:
    layout = ball_layout(scene)
    section = grooved_section(geometry_only(scene), True)
    return build(scene, specimen(scene, layout), layout, np.ones(4, dtype=bool), everything=True, section=section)


def pulled(force: tuple[float, float, float], moment: tuple[float, float, float]) -> Problem:
    """Held at the left end, loaded at the right one."""
    return problem_of(replace(CASE, supports=(HELD,), loads=(Load(RIGHT, force, moment),)))


@pytest.mark.parametrize("kind", ["tension", "bending about x", "bending about y"])
def test_outward_motion_is_saint_venants(kind: str) -> None:
    N, M = 8e3, 40.0
    load = {
        "tension": ((0, 0, N), (0, 0, 0)),
        "bending about x": ((0, 0, 0), (M, 0, 0)),
        "bending about y": ((0, 0, 0), (0, M, 0)),
    }
    problem = pulled(*load[kind])
    nu, s = CASE.screw.material.poissons_ratio, problem.section
    moved = squeezed(shaft_of(problem), [0, 1])[1].reshape(2, -1, 2)
    radius = CASE.track.pitch_radius + np.array([nominal_contact_points(CASE)[k][0] for k in (0, 1)])[:, None]
    x, y = problem.layout.radial[:, 0], problem.layout.radial[:, 1]
    wanted = {
        "tension": -nu * radius * N / s.EA + 0.0 * x,
        # u_z = y M / EI: what is stretched on the side of y shrinks across
        "bending about x": -nu * radius**2 / 2.0 * y * M / s.EI,
        "bending about y": nu * radius**2 / 2.0 * x * M / s.EI,
    }[kind]
    np.testing.assert_allclose(moved[..., 0], wanted, rtol=0, atol=1e-7 * np.abs(wanted).max())
    np.testing.assert_array_equal(moved[..., 1], 0.0)


def test_rigid_motions_squeeze_nothing() -> None:
    problem = pulled((0, 0, 1e3), (0, 0, 0))
    rigid = np.zeros((problem.nodes.size, 6, 6))
    rigid[:] = np.eye(6)
    rigid[:, 0, 4], rigid[:, 1, 3] = problem.nodes, -problem.nodes
    rows = squeeze_rows(problem, [0, 1])
    assert np.abs(rows @ rigid.reshape(-1, 6)).max() < 1e-9 * np.abs(rows).max()


def test_an_end_that_nothing_holds_adds_nothing() -> None:
    """A free upper end: the beam is the cantilever of the smooth body; a support there makes the difference, symmetric."""
    free = problem_of(replace(CASE, supports=(HELD,), loads=()))
    held = problem_of(replace(CASE, supports=(HELD, replace(HELD, at=RIGHT)), loads=()))
    assert not loaded_beyond(free)
    assert loaded_beyond(held)
    none, some = (squeezed(shaft_of(p), [0, 1])[0] for p in (free, held))
    assert np.abs(some - some.T).max() == 0.0
    assert np.abs(none).max() < 1e-6 * np.abs(some).max()


def test_contacts_that_press_lengthen_the_screw() -> None:
    """Reciprocity: radial forces F push the ends apart by nu r F / EA, as tension N moves their points inward by
    nu r N / EA; held at both ends, the screw answers with N = nu r F / L."""
    scene = replace(CASE, supports=(HELD, replace(HELD, at=RIGHT)), loads=())
    problem = problem_of(scene)
    shaft = shaft_of(problem)
    outward = squeezed(shaft, [0])[2].reshape(-1, 2, 6 * problem.nodes.size)[:, 0]
    force = -100.0 * np.ones(len(outward))
    loads = outward.T @ force
    taken = shaft.times(shaft.solve(loads[:, None])[:, 0]) - loads
    radius = CASE.track.pitch_radius + float(nominal_contact_points(CASE)[0][0])
    wanted = CASE.screw.material.poissons_ratio * radius * 100.0 * len(outward) / RIGHT
    assert taken[2] == pytest.approx(wanted, rel=1e-6)
    assert taken[-4] == pytest.approx(-wanted, rel=1e-6)
