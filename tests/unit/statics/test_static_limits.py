"""Results at the edge of what the static models hold for: contacts at the groove's apex, tilts, and what results say."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.helpers import ALL_BUT_AXIAL, small_screw, solved

from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.helix import lead_angle

FLAT = np.radians(0.001)


def turned_contacts(scene, second=1.0):
    """Loads of both diagonals [N] of every ball of a rigid screw shifted axially under its load, and their angles [rad].

    Groove centres of a diagonal lie d apart at the nominal angle; shifted by s they lie D = |(d cos b, d sin b +- s cos a)|
    apart, which presses two contacts by D - d. Where the arcs of both flanks are one circle, the second diagonal is the
    first one counted again, as the models do; second = 0 leaves it out.
    """
    force = sum(load.force[2] for load in scene.loads)
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    d = scene.screw.groove_radius + scene.nut.groove_radius - 2.0 * scene.balls.radius
    pair = 2.0 * float(hertz_without_errors(scene).C.mean())

    def diagonals(s):
        x, z = d * np.cos(beta), np.array([d * np.sin(beta) + s * np.cos(alpha), d * np.sin(beta) - s * np.cos(alpha)])
        size = np.hypot(x, z)
        return (np.maximum(size - d, 0.0) / pair) ** 1.5, np.arctan2(z, x)

    def excess(s):
        load, angle = diagonals(s)
        push = load[0] * np.sin(angle[0]) - second * load[1] * np.sin(angle[1])
        return scene.ball_count * float(push) * np.cos(alpha) - force

    return diagonals(brentq(excess, 0.0, 5e-3, xtol=1e-18, rtol=1e-14))


def on_the_apex(beta=FLAT):
    """A rigid screw under axial load with contacts near the apex of grooves of one radius."""
    scene = small_screw(8, beta=beta, force=(0.0, 0.0, 1250.0), screw="rigid")
    return replace(scene, nut=replace(scene.nut, groove_radius=scene.screw.groove_radius))


@pytest.mark.parametrize("degrees", [0.001, 0.01, 0.1, 0.5])
def test_axial_load_on_contacts_at_the_apex_is_carried_by_turned_contacts(degrees):
    """The spring start of fixed directions went kilometres away, and a screw in equilibrium was called not held."""
    scene = on_the_apex(np.radians(degrees))
    result = solved(scene)
    load, angle = turned_contacts(scene)
    for side in (0, 1):  # C of screw and nut differ by their curvature
        assert result.load[:, side] == pytest.approx(load[side], rel=5e-3)
    assert result.contact_angle[:, 0] == pytest.approx(angle[0], rel=5e-3)
    assert result.equilibrium.force_residual < 1e-9


TWICE = r"one contact counted twice \(.* up to ([\d.]+) N\); its pressure .* up to (\d+) %, its approach .* up to (\d+) %"


def counted_twice(result):
    """Numbers of the warning: force [N], excess of pressure and approach as parts; None without it."""
    found = [m for m in (re.search(TWICE, w) for w in result.warnings) if m]
    return (float(found[0][1]), 0.01 * float(found[0][2]), 0.01 * float(found[0][3])) if found else None


def test_one_contact_on_one_arc_is_not_passed_off_as_two():
    """What the single circle of both flanks carries lies between the forces printed and what the warning says."""
    scene = on_the_apex()
    both, (one, _) = turned_contacts(scene)[0], turned_contacts(scene, second=0.0)[0]
    assert both[0] == pytest.approx(both[1], rel=0.01)
    for result in (solved(scene), solve_elastic(scene, backend=LADDER["lin-cell"])):
        force, pressure, approach = counted_twice(result)
        assert force == pytest.approx(both.sum(), rel=0.01)
        assert (pressure, approach) == pytest.approx((2.0 ** (1.0 / 3.0) - 1.0, 2.0 ** (2.0 / 3.0) - 1.0), abs=0.01)
        assert result.load.max() < one < force
        assert 1.1 < np.cbrt(one / result.load.max()) < 1.0 + pressure


#: Contact angle [deg], force, oversize, and whether one contact is counted twice.
ARCS = [
    (0.001, (900.0, 0.0, 0.0), 0.0, True),  # both flanks at the apex
    (2.0, (0.0, 0.0, 1250.0), 0.0, True),  # one past it, on the other's arc
    (2.0, (0.0, 0.0, 5.0), 0.0, False),  # flanks of one diagonal only
    (15.0, (300.0, 0.0, 900.0), 2e-5, False),
    (45.0, (300.0, 0.0, 900.0), 5e-6, False),
]


@pytest.mark.parametrize(("beta", "force", "oversize", "twice"), ARCS)
def test_contacts_of_two_arcs_are_two(beta, force, oversize, twice):
    fixed = ALL_BUT_AXIAL[1:] if force[0] else ALL_BUT_AXIAL
    result = solved(small_screw(8, beta=np.radians(beta), force=force, oversize=oversize, fixed=fixed, screw="rigid"))
    assert (counted_twice(result) is not None) is twice


def test_elastic_flanks_at_the_apex_are_refused_in_full_words():
    scene = small_screw(8, beta=FLAT, force=(0.0, 0.0, 1250.0))
    words = r"contact angle of 0\.001 deg.* need at least 3\.8 deg.*lin, lin-cell or lin-nut"
    with pytest.raises(SceneNotCoveredError, match=words):
        run_model(scene, "refined")
    for name in ("lin-cell", "lin-nut"):
        assert run_model(scene, name).load[:, 0].mean() == pytest.approx(solved(scene).load[:, 0].mean(), rel=0.03)
    assert run_model(small_screw(8, beta=np.radians(5.0), force=(0.0, 0.0, 1250.0)), "refined").converged


def test_a_moment_that_tilts_the_screw_is_warned_of_and_shipped_case_studies_tilt_less():
    scene = small_screw(6, 1.0, oversize=-20e-6, fixed=(("rz", 0.0),), force=(0.0, 0.0, 10.0), moment=(0.0, 3.0, 0.0))
    shipped = (catalogue.scene(name) for name in ("lin-case1", "lin-case3-offset", "lin-combined"))
    for tilting, case in ((True, scene), *((False, case) for case in shipped)):
        assert any("tilts" in text for text in solved(case).warnings) is tilting
