"""Stiffness of the nut and of the load's point: each tangent is the slope of the displacement of the same name."""

from dataclasses import replace
from itertools import cycle

import pytest
from tests.campaign.draw import scene_text
from tests.campaign.draw_axes import axis_text
from tests.slow import all_slow_but

import rollbench
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.stiffness import change_of_loads, stiffness_of_scene
from rollbench.compare.scenes.catalogue import kind_of_shipped_scene, scene_names
from rollbench.compare.scenes.template import new_scene_text
from rollbench.lowfi.rating.displacement import load_point
from rollbench.lowfi.rating.rigidity import three_axial_rigidities
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Load, Support

#: The change of the loads for a slope, over that of the product.
WIDER = 2.0
#: Round-off of a displacement [m]: that of positions along half a metre of shaft, 2e-16 of them. It matters where the
#: change of the loads moves a nut or bearing by less than 1e-10 m.
ROUND_OFF = 1e-16
#: Scenes with loads on nuts and bearings.
SHIPPED = [name for name in scene_names() if kind_of_shipped_scene(name) in ("ball screw", "bearing", "axis")]
#: Where the loads on the shaft act; each scene takes one of them in turns.
PLACES = ("own", "nut", "end")
TURNS = [*zip(SHIPPED, cycle(PLACES))]
#: Most balls of a drawn scene.
MOST = 150
#: Scenes whose refined solution takes long.
SLOW = ("axis", "smith", "liu", "lin-combined", "lin-profile", "external", "steering", "double", "63x20", "unseen-25x5")


def solved(scene, model):
    result = run_model(scene, model, ModelOptions())
    if not result.converged:
        pytest.skip(f"no equilibrium: {result.status}")
    return result


def without_loads(scene, model):
    try:
        return run_model(with_scaled_loads(scene, 0.0), model, ModelOptions())
    except rollbench.InputError as refused:  # a contact angle of zero, by the model refined
        pytest.skip(str(refused))


def answered(scene, model):
    return stiffness_of_scene(scene, solved(scene, model), without_loads(scene, model), model, ModelOptions())


def check_law(scene, model, accuracy):
    """Each tangent is the difference quotient of the displacement of its name, of two scenes with other loads."""
    if load_point(scene) is None:
        return
    bare = without_loads(scene, model)
    found = stiffness_of_scene(scene, solved(scene, model), bare, model, ModelOptions())
    change = WIDER * change_of_loads(scene, bare)
    ends = [with_scaled_loads(scene, 1.0 + x) for x in (-change, change)]
    no_tangent = "no model of ours"
    less, more = (stiffness_of_scene(x, solved(x, model), bare, no_tangent, ModelOptions()) for x in ends)
    known = zip(*((*x.sets, x.load_point) for x in (found, less, more)), strict=True)
    for one, low, high in known:
        stated = None not in (one.tangent, low.displacement, high.displacement)
        if stated and abs(one.displacement) > 1e-15:  # below, under drawn loads of millinewtons, there is round-off only
            moved = high.displacement - low.displacement
            exact = max(accuracy, ROUND_OFF / abs(moved))
            assert one.tangent == pytest.approx((high.force - low.force) / moved, rel=exact), one


def loaded_at(scene, place):
    """The scene with its loads on the shaft moved to the nut (or first nut or bearing), or to the shaft's end."""
    nut = scene.sets[0].position if isinstance(scene, Assembly) else scene.nut.position
    at = {"nut": nut, "end": scene.screw.length}.get(place)
    return scene if at is None else replace(scene, loads=tuple(replace(x, at=at) for x in scene.loads))


def scene_from(tmp_path, *words, **more):
    path = tmp_path / "made.toml"
    path.write_text(new_scene_text(*words, **more), encoding="utf-8")
    return rollbench.read(path)


@pytest.mark.parametrize(("name", "place"), all_slow_but([("lin-case1", "own")], TURNS))
def test_each_tangent_is_the_slope_of_its_displacement(name, place) -> None:
    check_law(loaded_at(rollbench.read(name), place), "lin", 1e-6)


QUICK = [x for x in SHIPPED if not x.startswith(SLOW)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "place"),
    [
        *((x, p) for x, p in TURNS if x in QUICK),
        *(pytest.param(x, p, marks=pytest.mark.survey) for x in SHIPPED if x not in QUICK for p in PLACES),
    ],
)
def test_the_law_holds_for_the_refined_model(name, place) -> None:
    check_law(loaded_at(rollbench.read(name), place), "refined", 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "accuracy"), [("lin", 1e-6), pytest.param("refined", 1e-3, marks=pytest.mark.survey)], ids=["lin", "refined"]
)
@pytest.mark.parametrize(("number", "place"), [*zip(range(20), cycle(PLACES))])
def test_the_law_holds_for_drawn_scenes(tmp_path, number, place, model, accuracy) -> None:
    text = axis_text(77, number) if number % 5 == 0 else scene_text(77, number)
    path = tmp_path / "drawn.toml"
    path.write_text(text, encoding="utf-8")
    try:
        scene = rollbench.read(path)
    except rollbench.InputError as refused:
        pytest.skip(str(refused))
    if scene.ball_count > MOST:
        pytest.skip(f"{scene.ball_count} balls take long")
    check_law(loaded_at(scene, place), model, accuracy)


def test_wind_up_is_in_the_load_point_and_not_in_the_nut() -> None:
    """A screw held against rotation at its end winds up by its lead; held in the nut it does not."""
    scene = rollbench.read("lin-case1")
    at = scene.nut.position
    loads = (Load(at, (0.0, 0.0, 5e3)),)
    held = replace(scene, loads=loads, supports=(Support(at, (("rz", 0.0),)),))
    far = replace(scene, loads=loads, supports=(Support(0.0, (("rz", 0.0),)),))
    near, wound = (answered(x, "lin") for x in (held, far))
    assert near.nut.tangent == pytest.approx(near.load_point.tangent, rel=1e-9)
    assert wound.nut.tangent == pytest.approx(near.nut.tangent, rel=5e-3)
    assert wound.load_point.tangent < 0.95 * near.load_point.tangent
    left = replace(far, track=replace(far.track, hand="left"))
    assert answered(left, "lin").nut.tangent == pytest.approx(near.nut.tangent, rel=5e-3)


def test_rows_of_support_bearings_together_are_their_own_stiffness(tmp_path) -> None:
    """NSK prints 1520 N/um for 30TAC62B DBD; the rows alone, not the shaft to the load's point."""
    scene = scene_from(tmp_path, "support bearings")
    found, result = answered(scene, "lin"), run_model(scene, "lin", ModelOptions())
    assert found.nut.of == "3 bearings"
    assert found.nut.tangent == pytest.approx(sum(s.stiffness[2, 2] for s in result.sets), rel=1e-4)
    assert 1e-6 * found.nut.tangent == pytest.approx(1520.0, rel=0.01)
    assert 1e-6 * found.load_point.tangent == pytest.approx(1036.5, rel=1e-3)


def test_displacement_across_by_a_moment_is_the_tilt_by_a_force() -> None:
    """Maxwell's reciprocity at the nut of a preloaded screw, in both planes, but for lever arms that do not move (Lin)."""
    scene = rollbench.new("40x10")
    at = scene.nut.position

    def points(force, moment):
        found = answered(replace(scene, loads=(Load(at, force, moment),)), "lin")
        return found.nut, found.load_point

    by_force, by_moment = (
        [points(f, m) for f, m in pairs]
        for pairs in (
            [((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((0.0, 1.0, 0.0), (0.0, 0.0, 0.0))],
            [((0.0, 0.0, 0.0), (0.0, 0.1, 0.0)), ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0))],
        )
    )
    for k in range(2):
        (nut_f, end_f), (nut_m, end_m) = by_force[k], by_moment[k]
        tilt, across = (end_f.tilt_y, end_m.across_x) if k == 0 else (end_f.tilt_x, end_m.across_y)
        assert tilt == pytest.approx(across / 0.1, rel=3e-3)
        assert [nut_f.across, nut_f.tilt, nut_m.across, nut_m.tilt] == pytest.approx(
            [end_f.across, end_f.tilt, end_m.across, end_m.tilt], rel=1e-12
        ), "the nut stands, and the load acts at its centre"


def test_displacement_across_and_tilt_stand_in_the_table_with_loads_that_cause_them() -> None:
    scene = rollbench.new("40x10")
    moment = replace(scene, loads=(Load(scene.nut.position, (0.0, 1200.0, 5700.0), (150.0, 0.0, 0.0)),))
    for one, shown in ((scene, False), (moment, True)):
        result = rollbench.solve(one, "lin")
        rows = {row.quantity for row in result.table()}
        for name in ("displacement across", "tilt"):
            assert all((f"{of}: {name}" in rows) is shown for of in ("nut", "load's point"))
        assert (result.nut.tilt is not None, result.load_point.across is not None) == (shown, shown)


@pytest.mark.slow
def test_a_nut_of_an_axis_that_nothing_braces_answers_the_rigidities_of_the_formula() -> None:
    """As the only nut of a scene does; the formula does not know the preload by another nut or row."""
    axis, double = (rollbench.solve(name, "lin") for name in ("axis-fixed-fixed", "double-nut"))
    nut, *rows = axis.sets.values()
    alone = three_axial_rigidities(nut.parts, nut.nut.force, nut.nut.displacement)
    assert nut.rigidities == alone
    assert alone.with_unequal_loads == pytest.approx(nut.nut.secant, rel=1e-12)
    assert [one.rigidities for one in (*rows, *double.sets.values())] == [None] * 6
