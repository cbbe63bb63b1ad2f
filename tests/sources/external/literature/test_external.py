"""Other programs, makers' catalogues and textbooks: every entry by its class, what was inferred, and what is left out."""

from dataclasses import replace

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.sources.entries import check, found, keys, of_source

from rollbench.compare.cases.external import evidence
from rollbench.compare.evidence import uncompared_number_rows
from rollbench.compare.gate.gate import check_external_tolerance_bands, gate_check_of_tolerance_band
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.schema import FrictionKeys
from rollbench.compare.studies.friction.whole import friction_coefficients
from rollbench.lowfi.bearings import angular_contact
from rollbench.lowfi.bearings.axis import equal_rows_with_preload, lift_off_force, solve_bearing_row_equilibrium
from rollbench.lowfi.rating.life import dynamic_rating
from rollbench.meshes.parts import Friction

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.mark.parametrize("key", keys(*of_source("external")))
def test_entry(key: str) -> None:
    check(key)


def test_every_case_is_run_or_left_out_with_its_reason() -> None:
    makers = ("gmn", "harris", "masta", "nsk", "sjovall", "snfa", "thk", "vm63")
    assert of_source("external") == [f"{evidence.PREFIX}{name}" for name in ("contact", "equivalent", *makers)]
    left = [row["place"] for row in uncompared_number_rows() if row["source"] == "other programs, makers, textbooks"]
    assert left == ["eng-tools.dev, calculator of a 6206", "GMN, series KH, 25 deg", "SNFA, catalogue of spindle bearings"]


def test_what_was_inferred_is_said_of_every_scene_and_case() -> None:
    names = [name for name in catalogue.scene_names() if name.startswith(evidence.PREFIX)]
    assert [bool(catalogue.shipped_scene(name).assumed) for name in names] == 13 * [True]
    assert set(evidence.assumptions_by_external_case()) == {"vm63", "contact", "wheel", "snfa", "thk", "gmn"}


def test_the_gate_fails_for_a_value_beyond_its_band() -> None:
    rows = check_external_tolerance_bands(STUDY)
    assert [row.passed for row in rows] == 79 * [True]
    tilt = found("external-masta:tilt")
    values = (share * tilt.printed.high for share in (1.001, 0.999))
    beyond, within = (gate_check_of_tolerance_band(replace(tilt, value=value)) for value in values)
    assert (beyond.judgement, beyond.limit, within.judgement) == ("FAIL", pytest.approx(2.0), "ok")


@pytest.mark.parametrize(("size", "times", "printed"), [("5", 2, 1.814), ("7p5", 3, 2.578)])
def test_ratings_of_nuts_of_more_circuits_grow_as_the_catalogue_prints(size: str, times: int, printed: float) -> None:
    """Circuits of 2.5 turns half a turn apart: twice and three times the turns, by ISO 3408-5 to the power of 0.86."""
    more, one = (dynamic_rating(catalogue.scene(f"external-thk-bnf-3205-{name}")) for name in (size, "2p5"))
    assert more / one == pytest.approx(times**0.86, rel=1e-3)
    assert more / one == pytest.approx(printed, rel=3e-3)


def test_masta_axial_load_by_the_formulas_of_a_bearing() -> None:
    """From a contact angle of zero, as the scene of sets on a shaft has it."""
    b = angular_contact.BallBearing(7, 11.5e-3, 32e-3, 55e-3, 5.98e-3, 6.095e-3, 210e9, 0.3)
    assert b.free_angle == 0.0
    assert b.deflection(1000.0) * 1e6 == pytest.approx(133.5381, rel=2e-4)


def test_gmn_series_by_one_inferred_number() -> None:
    assert evidence.gmn_rigidity_rms_error_percent() < 1.0
    for conformity in evidence.ANY:
        growth = evidence.gmn_rigidity_growth_over_printed(conformity)
        assert np.median(growth) == pytest.approx(1.0, abs=0.02)
        assert np.ptp(growth) < 0.05


def test_snfa_catalogue_has_frozen_its_angles() -> None:
    """Balls as good as rigid keep the angle: then rigidity grows as 6^(1/3), and a row opens at 2^1.5 times the preload."""
    rigid = angular_contact.bearing_with_contact_angle(12, 2.38e-3, 14.5e-3, (0.53, 0.53), np.radians(15.0), 208e15, 0.3)
    light, heavy = (equal_rows_with_preload(rigid, (1, -1), p) for p in (10.0, 60.0))
    soft, stiff = (solve_bearing_row_equilibrium(pair).stiffness for pair in (light, heavy))
    assert stiff / soft == pytest.approx(6.0 ** (1 / 3), rel=1e-3)
    assert lift_off_force(heavy) / 60.0 == pytest.approx(2.0**1.5, rel=1e-3)
    assert stiff == pytest.approx(evidence.pair_rigidity_at_constant_angle(rigid, 60.0), rel=1e-3)


@pytest.mark.parametrize("size", [*evidence.THK, *evidence.HIWIN])
def test_bodies_make_a_nut_softer_than_its_contacts(size: str) -> None:
    scene = STUDY.built_in_scene(evidence.scene_name_of_catalogue_size(size))
    alone, bodies = evidence.nut_rigidities_without_and_with_bodies(scene, scene.loads[0].force[2])
    assert 0.85 * alone < bodies < alone


def test_double_nut_of_contacts_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """2^(3/2)/3^(1/3): where the load that unloads one nut is 2^(3/2) times the preload."""
    monkeypatch.setattr(evidence, "axial_compliance_of_bodies", lambda scene: 0.0)  # noqa: ARG005 - rigid bodies
    assert evidence.double_over_single_nut_rigidity(STUDY) == pytest.approx(2.0**1.5 / 3.0 ** (1 / 3), rel=1e-5)


def test_friction_moves_balls_wherever_nothing_else_is_said():
    """One default: of the record, of scene files, of the command, and so of the maker's worked example of drag torque."""
    assert Friction(0.1, 0.1).feedback is Friction.feedback is FrictionKeys.feedback is True
    nut = catalogue.scene("external-thk-bnf-3205-5")
    assert [f.feedback for f in friction_coefficients(replace(nut, friction=None), (0.1,))] == [True]
    drag = found("external-thk:drag")
    assert drag.value == pytest.approx(941.0, rel=2e-3)
    assert "1.09 times the printed torque" in drag.reason
