"""What an expected error covers: materials and loads that were compared; nuts held by a flange; how many compared scenes
were within. Displacements are compared beyond the nut, where a beam's section and a 3D one mean the same."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import ALL_BUT_AXIAL, small_screw

from rollbench.compare.models import model_form
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies import survey
from rollbench.lowfi.rating.catalogue_checks import shaft_limits
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.parts import Flange, Load, Material, Support

pytestmark = pytest.mark.slow

SCENE = catalogue.scene("lin-case1")
STEEL = SCENE.nut.material
#: Screws of a model that the others do not cover, as many as before moduli and loads across were looked at.
UNCOVERED = 3


def of(part: str, youngs_modulus: float, poissons_ratio: float = STEEL.poissons_ratio):
    """The screw of Lin's first case with another material of one part."""
    return replace(SCENE, **{part: replace(getattr(SCENE, part), material=Material(youngs_modulus, poissons_ratio))})


def solved(scene, model: str = "lin"):
    result = run_model(scene, model, ModelOptions(estimate_beam_mesh_error=False))
    assert result.converged
    return result


def expected(scene, model: str = "lin", points=None):
    return model_form.estimate_model_error(scene, solved(scene, model), points)


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
    assert (found.loads, found.loads_rms, found.displacement) == (None, None, None)
    assert word in found.words[-1]


def test_steels_and_balls_of_silicon_nitride_are_covered() -> None:
    for scene in (SCENE, of("nut", 200e9, 0.3), of("balls", 310e9, 0.26)):
        assert expected(scene).loads is not None


def test_a_shaft_more_slender_than_the_compared_ones_is_not_covered() -> None:
    held = Support(0.0, ALL_BUT_AXIAL)

    def of_length(length: float):
        screw, end = replace(SCENE.screw, length=length), Support(length, (("ux", 0.0), ("uy", 0.0)))
        return expected(replace(SCENE, screw=screw, supports=(held, end), loads=(Load(0.0, (0.0, 0.0, 500.0)),)))

    assert of_length(0.9).loads is not None
    assert "span of the shaft" in of_length(1.2).words[-1]


def test_a_shaft_near_buckling_is_not_covered() -> None:
    """Compared shafts are compressed by up to 0.24 of their buckling load; this one carries 0.15 and 0.6 of it."""
    slim = replace(SCENE, supports=(Support(0.0, ALL_BUT_AXIAL), Support(0.4, ALL_BUT_AXIAL[:2])))
    result = solved(slim)
    limits = shaft_limits(slim, result)
    assert limits.compression < 0.25 * limits.buckling
    assert expected(slim).loads is not None
    thin = replace(
        slim,
        screw=replace(slim.screw, material=Material(slim.screw.material.youngs_modulus, 0.3)),
        loads=tuple(replace(x, force=(0.0, 0.0, 0.6 * limits.buckling)) for x in slim.loads[:1]),
    )
    found = expected(thin)
    assert (found.loads, "load under which it buckles" in found.words[-1]) == (None, True)


@pytest.mark.parametrize("model", ["lin", "refined"])
def test_screws_that_calibrate_are_not_fitted_and_hold_the_share_of_their_kind(model: str) -> None:
    points = [p for p in model_form.model_errors_on_compared_scenes() if p.model == model]
    drawn = sum(model in record.get("models", {}) for record in survey.built_in_survey("double nut")["scenes"])
    assert drawn >= 12
    for kind, fewest, each in (("screw", 100, 1), (model_form.FLANGE, 59, 1), (model_form.DOUBLE, drawn, 2)):
        like = model_form.ScenesLike.of_kind(kind, points)
        assert (len(like.calibrating), {len(nuts) for nuts in like.calibrating}) == (fewest, {each})
        assert not {p.scene for p in like.fitted} & {p.scene for nuts in like.calibrating for p in nuts}
        assert (model_form.DOUBLE in {p.kind for p in like.points}) == (each == 2)
        held = 0
        for nuts in like.calibrating:
            places = np.array([model_form._scaled_features(p.features, like.scales) for p in nuts])
            bound = model_form._expected_errors(like, places)["percent"]
            held += max(p.percent for p in nuts) <= bound * (1.0 + 1e-9)
        assert held == np.ceil((fewest + 1) * model_form.SHARE)


TILTS = [
    (Load(0.5, (1500.0, 0.0, 0.0)), Load(0.7, (-1500.0, 0.0, 0.0))),  # a couple, whose forces cancel
    (Load(0.8, (0.0, 700.0, 0.0)),),  # a long arm
    (Load(0.6, moment=(0.0, 600.0, 0.0)),),
]


@pytest.mark.parametrize("loads", TILTS)
def test_what_tilts_the_nut_counts_wherever_it_comes_from(loads) -> None:
    level = [p for p in model_form.model_errors_on_compared_scenes() if p.features["moment"] < 0.1]
    found = expected(replace(SCENE, loads=(*SCENE.loads, *loads)), points=level)
    assert found.loads is None
    assert "tilting moment" in found.words[-1]
    assert expected(SCENE, points=level).loads is not None


def test_force_and_moment_on_the_contacts_balance_those_of_the_shaft() -> None:
    """Held at its left end against nothing across: the nut takes a force, and its moment about the nut's centre."""
    free = replace(SCENE, supports=(Support(0.0, (("rz", 0.0),)),), loads=(*SCENE.loads, Load(0.45, (300.0, 400.0, 0.0))))
    assert model_form.lateral_force_and_tilting_moment(free, solved(free)) == pytest.approx((500.0, 500.0 * 0.05), rel=1e-3)


def test_a_load_that_a_support_takes_is_none_of_the_contacts() -> None:
    held = replace(SCENE, loads=(*SCENE.loads, Load(0.0, (2e4, 0.0, 0.0))))
    assert expected(held).loads == pytest.approx(expected(SCENE).loads, rel=1e-9)


def test_nothing_is_expected_of_contacts_without_load() -> None:
    found = expected(replace(SCENE, loads=()))
    assert (found.loads, found.loads_rms) == (None, None)
    assert "no contact carries load" in found.words[-1]


@pytest.mark.parametrize("model", ["lin", "refined"])
def test_as_many_compared_screws_were_within_as_is_promised(model: str) -> None:
    """Counted by the whole bound made anew from the others, of the screws that do not calibrate: none of them sets its own
    bound. The share of n such screws has a standard deviation of 3.5 %: 100 screws calibrate, n is about 150."""
    found = model_form.leave_one_out_errors(model_form.model_errors_on_compared_scenes(), model)
    covered = [one for one in found if one.expected is not None]
    assert len(found) - len(covered) <= UNCOVERED
    covered = [one for one in covered if not one.point.calibrates]
    flanged = [one for one in covered if model_form.FLANGE in one.point.features]
    assert len(flanged) > 30
    for quantity in model_form.QUANTITIES:
        for group, share in ((covered, model_form.SHARE - 2.0 * 0.035), (flanged, 0.8)):
            pairs = [(getattr(one.point, quantity), one.expected[quantity]) for one in group]
            held = [abs(measured) <= bound for measured, bound in pairs if measured is not None and bound is not None]
            assert np.mean(held) >= share, (quantity, len(held), sum(held))


ON_FLANGE = replace(SCENE, nut=replace(SCENE.nut, flange=Flange(72e-3, 11e-3, (24e-3, 36e-3))))
RESULT = solved(SCENE)
OF_LIN = [p for p in model_form.model_errors_on_compared_scenes() if p.model == "lin"]
PLAIN = [p for p in OF_LIN if model_form.FLANGE not in p.features]


def flanged(count: int, factor: float):
    """Compared scenes made up: those of the package, off by a factor more, on flanges."""
    return [
        replace(p, scene=f"{p.scene}, flange", percent=factor * p.percent, features=p.features | {model_form.FLANGE: 1.0})
        for p in [p for p in PLAIN if p.features["lead"] > 0.0][:count]
    ]


def test_a_nut_on_a_flange_is_not_covered_by_nuts_without() -> None:
    assert model_form.FLANGE in model_form.features_of_scene(ON_FLANGE, RESULT)
    assert model_form.FLANGE not in model_form.features_of_scene(SCENE, RESULT)
    found = model_form.estimate_model_error(ON_FLANGE, RESULT, [*PLAIN, *flanged(2, 1.0)])
    assert (found.loads, "too few nuts held by a flange" in found.words[-1]) == (None, True)


def test_flanges_with_larger_errors_are_expected_to_have_them_and_change_no_other() -> None:
    many = [*PLAIN, *flanged(40, 5.0)]
    plain, other = (model_form.estimate_model_error(SCENE, RESULT, points) for points in (PLAIN, many))
    assert other == plain
    assert model_form.estimate_model_error(ON_FLANGE, RESULT, many).loads > 2.0 * plain.loads
    judged, alone = ({x.point.scene: x for x in model_form.leave_one_out_errors(points, "lin")} for points in (many, PLAIN))
    assert {k: v for k, v in judged.items() if model_form.FLANGE not in v.point.features} == alone
    assert len(judged) == len(alone) + 40


def test_a_flange_that_does_not_hold_its_nut_is_of_no_compared_kind() -> None:
    face = replace(SCENE.solid, nut_held="left face")
    found = model_form.estimate_model_error(replace(ON_FLANGE, solid=face), RESULT, PLAIN)
    assert (found.loads, "is not fixed at it" in found.words[-1]) == (None, True)
    plain, same = (model_form.estimate_model_error(scene, RESULT, PLAIN) for scene in (replace(SCENE, solid=face), SCENE))
    assert plain.loads == pytest.approx(same.loads)


@pytest.mark.parametrize("force", [900.0, -1400.0, 0.03])
@pytest.mark.parametrize("oversize", [0.0, 3e-6])
def test_contacts_pull_the_nut_by_the_load(force, oversize):
    """Axial equilibrium of the screw; contacts without load pull nothing, whatever angle they are given."""
    scene = small_screw(9, 1.5, force=(0.0, 0.0, force), oversize=oversize)
    result = solve_static(scene, discretisation=False)
    for angle in (result.contact_angle, np.where(result.load > 0.0, result.contact_angle, 1.0)):
        assert model_form.axial_contact_force(scene, result.load, angle) == pytest.approx(force, rel=1e-9)
