"""Loads by the solver, which condenses the bodies to the contacts, against dense equations in the motions of the shaft."""

import numpy as np
import pytest
from tests.campaign.draw import scene_text
from tests.campaign.draw_axes import axis_text
from tests.dense_beam import frame_of_assembly, frame_of_problem, loads_of

from rollbench.compare.errors import InputError
from rollbench.compare.models.study import with_ball_count
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies import extremes
from rollbench.lowfi.statics import settle, static
from rollbench.lowfi.statics.axis import solve, system
from rollbench.lowfi.statics.axis.equations import assembly_equations
from rollbench.lowfi.statics.axis.held import pin_unresisted_motions, unresisted_motions
from rollbench.lowfi.statics.equations import StaticInput
from rollbench.lowfi.statics.selection import choose_flanks
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.axis import Assembly
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout

SEED, SCREWS, AXES, MOST = 20261128, 160, 80, 40
#: Force [N] below which contacts carry nothing but round-off; largest difference over the largest force.
NOTHING, NEAR = 1e-6, 1e-8


def drawn(draw, number):
    """A random scene; None where it is refused or large, or its offsets follow from preload forces."""
    try:
        scene = scene_file.parse_scene(draw(SEED, number), "drawn.toml")
    except InputError:
        return None
    if scene.ball_count > MOST or (isinstance(scene, Assembly) and any(s.preload for s in scene.sets)):
        return None
    return scene


def solved_screw(scene):
    """Solved equations of a screw, or None where there is no equilibrium."""
    layout = ball_layout(scene)
    geometry = draw_geometry_with_errors(scene, layout)
    found = solve_alone(
        static.solve_with_chosen_flanks(StaticInput(scene, geometry, layout, choose_flanks(scene, geometry)))
    )
    return found.system if found.status == "converged" else None


def solved_axis(assembly):
    """Solved equations of an axis with the flanks that thrust can load, or None where there is no equilibrium."""
    arrays = system.build_assembly_arrays(assembly)
    loose = unresisted_motions(arrays)
    if loose.is_driven_by_loads:
        return None
    found, outcome = solve_alone(
        settle.solve_with_updated_contacts(assembly_equations(pin_unresisted_motions(arrays, loose), None))
    )
    far = solve.moved_too_far(found.body_motions_and_reactions()[0], arrays)
    return found if settle.is_solve_accepted(outcome, found.round_off_residual()) and not far else None


def forces_of_slices(found):
    """Forces of the slices of all rollers of solved equations of an axis [N]."""
    sets = found.assembly_arrays.roller_sets
    each = found.forces_and_stiffness_of_slices()[0] if sets else ()
    return np.concatenate([np.zeros(0), *(each[r.roller_indices, : r.row.slices].ravel() for r in sets)])


def check(scene):
    """Whether the loads of a scene were compared: they must agree."""
    found = solved_axis(scene) if isinstance(scene, Assembly) else solved_screw(scene)
    if found is None or any(p.drawn.profile_coefficients.shape[1] for p in found.problems):
        return False
    if isinstance(scene, Assembly):
        frame, slices = frame_of_assembly(found.assembly_arrays), forces_of_slices(found)
    else:
        frame, slices = frame_of_problem(found.problem), np.zeros(0)
    balls = [s.force for s in found.contact_states()]
    mine = np.concatenate([np.zeros((0, 4)), *balls])
    reach = max((float(p.drawn.ball_radii.max()) for p in found.problems), default=1.0)
    force, of_slices, unbalanced = loads_of(frame, reach)
    largest = max(mine.max(initial=0.0), slices.max(initial=0.0))
    if largest < NOTHING:
        return False
    if unbalanced > 0.01 * NEAR * largest:  # the oracle's own round-off
        return False
    assert np.abs(force - mine).max(initial=0.0) < NEAR * largest
    assert np.abs(of_slices - slices).max(initial=0.0) < NEAR * largest
    return True


@pytest.mark.further
def test_random_screws():
    assert sum(check(s) for s in (drawn(scene_text, k) for k in range(SCREWS)) if s is not None) > SCREWS // 4


@pytest.mark.further
def test_random_axes():
    assert sum(check(s) for s in (drawn(axis_text, k) for k in range(AXES)) if s is not None) > AXES // 8


@pytest.mark.further
@pytest.mark.parametrize("balls", [1000, 5000])
def test_thousands_of_balls_are_in_balance(balls):
    """Too many for the dense equations; the balance of all forces on the screw does not use the solved ones."""
    scene = with_ball_count(catalogue.scene("lin-case1"), balls)
    result = static.solve_static(scene)
    assert result.status == "converged"
    found = result.equilibrium
    assert max(found.force_residual, found.moment_residual, found.ball_residual) < NEAR
    assert abs(found.contact_force[2]) == pytest.approx(5000.0, rel=NEAR)


@pytest.mark.parametrize("name", ["lin-case1", "lin-case3-offset", "bearing-9-preload", "smith-axis-taper"])
def test_shipped_scenes(name):
    assert check(catalogue.shipped_scene(name))


@pytest.mark.further
def test_hard_scenes():
    cases = [c for c in extremes.hard_scenes() if c.scene.ball_count <= MOST]
    assert sum(check(c.scene) for c in cases) > len(cases) // 2
