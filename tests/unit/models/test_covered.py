"""What an expected error covers: materials and loads that were compared; how many compared scenes were within."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.models import model_form
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import Load, Material, Support

SCENE = catalogue.scene("lin-case1")
STEEL = SCENE.nut.material
#: Screws of a model that the others do not cover, as many as before moduli and loads across were looked at.
UNCOVERED = 3


def of(part: str, youngs_modulus: float, poissons_ratio: float = STEEL.poissons_ratio):
    """The screw of Lin's first case with another material of one part."""
    return replace(SCENE, **{part: replace(getattr(SCENE, part), material=Material(youngs_modulus, poissons_ratio))})


def expected(scene, model: str = "lin", points=None):
    result = run_model(scene, model, ModelOptions(estimate_beam_mesh_error=False, engine="interpreted"))
    assert result.converged
    return model_form.estimate_model_error(scene, result, points)


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize(
    ("scene", "word"),
    [
        (of("nut", 3e9), "modulus of the nut"),
        (of("nut", 1e12), "modulus of the nut"),
        (of("screw", 70e9), "modulus of the nut"),
        (of("balls", 10e9), "modulus of the balls"),
        (of("nut", 210e9, 0.45), "Poisson"),
    ],
)
def test_materials_that_were_not_compared_are_not_covered(scene, word: str, model: str) -> None:
    light = replace(scene, loads=(Load(0.0, (0.0, 0.0, 100.0)),))
    found = expected(light, model)
    assert (found.percent, found.rms_percent, found.displacement_percent) == (None, None, None)
    assert word in found.words[-1]


def test_steels_and_balls_of_silicon_nitride_are_covered() -> None:
    for scene in (SCENE, of("nut", 200e9, 0.3), of("balls", 310e9, 0.26)):
        assert expected(scene).percent is not None


TILTS = [
    (Load(0.5, (1500.0, 0.0, 0.0)), Load(0.7, (-1500.0, 0.0, 0.0))),  # a couple, whose forces cancel
    (Load(0.8, (0.0, 700.0, 0.0)),),  # a long arm
    (Load(0.6, moment=(0.0, 600.0, 0.0)),),
]


@pytest.mark.parametrize("loads", TILTS)
def test_what_tilts_the_nut_counts_wherever_it_comes_from(loads) -> None:
    level = [p for p in model_form.model_errors_on_compared_scenes() if p.features["moment"] < 0.1]
    found = expected(replace(SCENE, loads=(*SCENE.loads, *loads)), points=level)
    assert found.percent is None
    assert "tilting moment" in found.words[-1]
    assert expected(SCENE, points=level).percent is not None


def test_force_and_moment_on_the_contacts_balance_those_of_the_shaft() -> None:
    """Held at its left end against nothing across: the nut takes a force, and its moment about the nut's centre."""
    free = replace(SCENE, supports=(Support(0.0, (("rz", 0.0),)),), loads=(*SCENE.loads, Load(0.45, (300.0, 400.0, 0.0))))
    result = run_model(free, "lin", ModelOptions(estimate_beam_mesh_error=False, engine="interpreted"))
    assert result.converged
    assert model_form.lateral_force_and_tilting_moment(free, result) == pytest.approx((500.0, 500.0 * 0.05), rel=1e-3)


def test_a_load_that_a_support_takes_is_none_of_the_contacts() -> None:
    held = replace(SCENE, loads=(*SCENE.loads, Load(0.0, (2e4, 0.0, 0.0))))
    assert expected(held).percent == pytest.approx(expected(SCENE).percent, rel=1e-9)


def test_nothing_is_expected_of_contacts_without_load() -> None:
    found = expected(replace(SCENE, loads=()))
    assert (found.percent, found.rms_percent) == (None, None)
    assert "no contact carries load" in found.words[-1]


@pytest.mark.parametrize("model", ["lin", "refined"])
def test_as_many_compared_screws_were_within_as_is_promised(model: str) -> None:
    """Counted by the whole bound made anew from the others, of all screws and of those held by a flange."""
    found = model_form.leave_one_out_errors(model_form.model_errors_on_compared_scenes(), model)
    covered = [one for one in found if one.expected is not None]
    assert len(found) - len(covered) <= UNCOVERED
    flanged = [one for one in covered if model_form.FLANGE in one.point.features]
    assert len(flanged) > 30
    for quantity in model_form.QUANTITIES:
        for group, share in ((covered, 0.9), (flanged, 0.8)):
            pairs = [(getattr(one.point, quantity), one.expected[quantity]) for one in group]
            held = [abs(measured) <= bound for measured, bound in pairs if measured is not None and bound is not None]
            assert np.mean(held) >= share, (quantity, len(held), sum(held))
