"""Extreme scenes of a random campaign: a right answer or a proven refusal."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.axes import one_set
from tests.helpers import four_flank_problem, small_screw
from tests.shipped_texts import parse_file

from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.lowfi.rating.rigidity import axial_force
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.held import describe_motion, find_opening_motion
from rollbench.lowfi.statics.static import solve_elastic, solve_static, status_of_runaway_screw
from rollbench.lowfi.statics.tangent import tangent_stiffness

pytestmark = pytest.mark.slow

SCENES = Path(__file__).parent / "scenes"


def read(name):
    return parse_file(SCENES / f"{name}.toml")


@pytest.mark.parametrize("number", [3182, 90])
def test_a_small_load_beside_a_large_twist(number):
    """A whole step was taken at once, and went kilometres away."""
    scene = read(f"extreme-{number}")
    result = solve_static(scene)
    assert result.status == "converged"
    assert result.equilibrium.largest < 1e-9
    problem = four_flank_problem(scene)
    assert find_opening_motion(problem) is None, "loads of compressive forces are not called unheld"
    assert status_of_runaway_screw(problem).startswith("not converged")


def test_a_load_that_opens_every_contact_is_proven():
    """One ball at the top, and a pull away from it: no contact can carry it."""
    held = tuple((name, 0.0) for name in ("uy", "uz", "rx", "ry", "rz"))
    scenes = (small_screw(8, fixed=held, force=(force, 0.0, 0.0)) for force in (-5.0, 5.0))
    alone = (replace(scene, balls=replace(scene.balls, azimuths=(0.0,))) for scene in scenes)
    pulled, pushed = (four_flank_problem(scene) for scene in alone)
    motion = find_opening_motion(pulled)
    assert motion[0] < 0.0
    assert "ux" in describe_motion(motion)
    assert status_of_runaway_screw(pulled).startswith("not held: the load opens every contact")
    assert find_opening_motion(pushed) is None


def test_a_ball_on_one_contact_is_no_equilibrium():
    """Residual of the screw 2e-15, and ball 5 pushed by one contact alone: convergence is judged on every ball."""
    result = solve_static(read("extreme-3570"))
    assert not result.converged
    assert "contact pattern is not unique" in result.status
    assert result.equilibrium.ball_residual > 1e-5
    assert result.solver.residual > 1e-5


def test_so_it_is_on_a_shaft_of_several_sets():
    result = solve_assembly(one_set(read("extreme-3570")))
    assert result.status.cause == "not unique"


def test_a_ball_behind_the_centre_of_its_groove_is_found():
    """Its contact angle is near 180 deg, where the polynomial of the profile error once ended with a jump."""
    assert solve_static(read("extreme-2028-110")).converged


@pytest.mark.parametrize("solve", [solve_static, solve_elastic])
def test_a_pin_is_no_support(solve):
    """A screw free along its helix under lateral load: no support of the scene carries what the pin takes."""
    held = (("ux", 20e-6), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0))
    result = solve(small_screw(9, 1.5, fixed=held, oversize=3e-6))
    assert result.converged
    balance = result.equilibrium
    assert np.abs([*balance.pin_moment, *balance.pin_force]).max() > 0.0
    assert balance.pin_share > 1e-8
    assert balance.reaction_force[2] == 0.0  # no support holds uz or rz
    assert balance.reaction_moment[2] + balance.pin_moment[2] + balance.contact_moment[2] == pytest.approx(0.0, abs=1e-9)
    assert any("fixed instead, contact loads change by up to" in note for note in result.solver.notes)


#: Scenes that one model solved and another did not, by what they need.
SOLVED_BY_ALL = {
    "furthest-steps": "more than a hundred steps of a ball's radius each, every one of which lowers the energy",
    "rigid-under-moments": "a residual that jumps while the energy falls",
    "one-ball-without-load": "the answer that nothing is loaded: its interference is round-off, which residuals counted by",
    "bearing-refined-stalls": "rings of plastic that 97 kN turn inside out: far from where a search begins",
    "bearing-refined-stalls-2": "moments of 1e-3 N m on a bearing that nothing holds but its balls",
    "uneven-at-round-off": "the round-off of forces by that of motions, counted alike with and without elastic bodies",
}


@pytest.mark.parametrize("name", SOLVED_BY_ALL)
def test_what_one_model_solves_all_models_solve(name):
    scene = read(name)
    lin, refined = solve_static(scene), solve_elastic(scene)
    assert lin.status == refined.status == "converged"
    assert refined.load.sum() == pytest.approx(lin.load.sum(), rel=0.25)
    assert (lin.load.max() == 0.0) == (name == "one-ball-without-load")
    if name == "one-ball-without-load":
        found = tangent_stiffness(scene, scene.nut.position)
        assert found.status == "converged"
        assert not found.matrix.any(), "a screw that nothing loads has no tangent stiffness"
    if name == "bearing-refined-stalls-2":
        # moments alone: 2e-12 of the contact loads was an axial force, and the rigidity 8e-14 N/um
        assert axial_force(refined) == 0.0, "an axial force of round-off has no rigidity"


def test_a_twisted_shaft_carries_a_load_ten_billion_times_smaller():
    """The residual over the twist's force looked like a solution before one contact carried the load of 4 mN.

    The shaft's shear stiffness times the last digit of its motion of 10 um is 1e-8 N.
    """
    scene = read("twisted-without-load")
    result = solve_static(scene)
    assert result.converged
    applied = np.array(scene.loads[0].force)
    assert result.equilibrium.contact_force == pytest.approx(-applied, abs=1e-7)


def test_loads_that_almost_cancel_balance_to_round_off_of_the_loads():
    """Motions G f of a plate that bends are sums of large terms, whose round-off must not become a force: a thin ring with
    many small balls, which bends far more than its contacts yield."""
    result = run_model(read("thin-ring"), "refined", ModelOptions(estimate_beam_mesh_error=False))
    assert result.converged
    assert result.equilibrium.force_residual < 2e-14
