"""Statics of the 3D reference on two balls: balance, symmetry, errors, ingredients that are left out."""

from dataclasses import replace

import numpy as np
import pytest
from tests.two_balls import SMALL

from rollbench.compare.scenes import catalogue
from rollbench.hifi import coupling, reference, setup
from rollbench.meshes.parts import FourierTerm, Load, SideErrors, Support

pytestmark = pytest.mark.xdist_group("helped by processes")


def test_a_screw_without_its_3d_shaft_does_not_depend_on_which_flanks_bear(small):
    """The same bodies with their flanks named SR and NL."""
    named = {
        "condensed_screw": replace(small.condensed_screw, modes_by_flank={1: small.condensed_screw.modes_by_flank[0]}),
        "condensed_nut": replace(small.condensed_nut, modes_by_flank={2: small.condensed_nut.modes_by_flank[3]}),
    }
    other = replace(small, loaded_flanks=(1, 2), **named)
    one, two = (coupling.compliance_of_supported_screw(s, small.scene, frozenset({"3D shaft"})) for s in (small, other))
    np.testing.assert_array_equal(one.G, two.G)
    shaft = coupling.compliance_of_supported_screw(small, small.scene).G
    assert one.G.shape == shaft.shape
    assert not np.allclose(one.G, shaft, rtol=1e-6, atol=0.0)


def test_balance_and_that_what_is_left_out_changes_the_answer(small):
    """No force acts along the groove; a wrong name is refused."""
    result = reference.solve_reference(small, small.scene)
    assert result.status == "converged"
    assert result.unbalanced_ball_force < 1e-8
    assert abs(result.unbalanced_force_along_groove) < 1e-3
    assert result.unbalanced_shaft_force < 1e-8
    m = small.groove_map
    axial = result.contact_loads[:, 0] @ np.sin(result.contact_angles[:, 0]) * np.cos(m.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)
    assert (result.contact_loads[:, [1, 2]] == 0.0).all()
    for name in reference.INGREDIENTS:
        other = reference.solve_reference(small, small.scene, leave_out=frozenset([name]))
        assert other.status == "converged"
        assert np.abs(other.contact_loads - result.contact_loads).max() > 1e-6 * result.contact_loads.max(), name
    with pytest.raises(ValueError, match="got elastic ball"):
        reference.solve_reference(small, small.scene, leave_out=frozenset(["elastic ball"]))


@pytest.mark.usefixtures("_one_submodel")
def test_two_opposite_balls_without_lead_carry_the_same():
    """A ring free to tilt on two opposite balls: statics alone divides the load."""
    s = catalogue.scene("bearing-9")
    scene = replace(
        s,
        balls=replace(s.balls, azimuths=(0.0, np.pi)),
        loads=(Load(8e-3, (0.0, 0.0, 600.0)),),
        supports=(Support(8e-3, (("uy", 0.0), ("rx", 0.0), ("rz", 0.0))),),
    )
    names, ratio = ("fine", "coarse", "ball_fine", "ball_coarse"), s.balls.radius / 2.778e-3
    sizes = {name: ratio * getattr(SMALL, name) for name in names}
    own = {"own_sizes": (sizes["fine"], sizes["coarse"]), "own_ball_sizes": (sizes["ball_fine"], sizes["ball_coarse"])}
    settings = replace(SMALL, semi=(1.0e-3, 0.3e-3), reach=(1.0e-3, 0.3e-3), modes=16, ball_modes=16, **sizes, **own)
    set_up = setup.mesh_and_condense_geometry(scene, (0, 3), settings)
    result = reference.solve_reference(set_up, scene)
    assert result.status == "converged"
    load = result.contact_loads[:, [0, 3]]
    assert np.ptp(load) < 1e-6 * load.mean()
    assert load.mean() * 2.0 * np.sin(result.contact_angles[0, 0]) == pytest.approx(600.0, rel=5e-3)


def test_ball_errors_and_lost_contact(small):
    errors = replace(small.scene.errors, balls=replace(small.scene.errors.balls, listed=((1, -60e-6),)))
    lost = reference.solve_reference(small, replace(small.scene, errors=errors))
    assert lost.contact_loads[0, 0] == 0.0
    assert lost.contact_loads[1, 0] > 400.0
    assert np.isnan(lost.contact_angles[0, 0])


def test_a_lead_offset_is_the_pitch_error_of_the_nut_that_shifts_ball_2_alone(small):
    """The groove beyond the nut's centre, at ball 2, by 2 um; against a series that is zero at ball 1."""
    shift, errors = 2e-6, small.scene.errors
    first, second = small.ball_positions.azimuth - small.scene.nut.azimuth
    a, b = np.linalg.solve([[np.sin(x), np.cos(x)] for x in (first, second)], [0.0, shift])
    pitch = SideErrors(pitch=(FourierTerm(1.0, sin=float(a), cos=float(b)),), pitch_along="axis")
    scenes = [
        replace(small.scene, errors=e) for e in (replace(errors, lead_offset=shift), replace(errors, NL=pitch, NR=pitch))
    ]
    found, wanted = (reference.solve_reference(small, s).contact_loads for s in scenes)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * wanted.max())
    assert abs(found - reference.solve_reference(small, small.scene).contact_loads).max() > 10.0
