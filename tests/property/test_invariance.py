"""What must not matter: units, the origin of the azimuth, the hand, the direction of the load, what is left out."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import FLANK_ERRORS, mirrored, relative, small_screw, solved, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import SIDES, BallErrors, Errors, Load, Material, SideErrors, Support

COMBINED = replace(
    small_screw(count=12, turns=2.0, force=(150.0, -80.0, 2500.0), moment=(2.0, 3.0, 0.0)),
    errors=replace(FLANK_ERRORS, balls=BallErrors(oversize=2e-6, listed=((3, 1e-6), (7, -2e-6)))),
)
SCENES = {name: catalogue.scene(name) for name in ("lin-case1", "lin-case2", "lin-case3-offset", "bearing-9")}
SCENES["combined"] = COMBINED
LATERAL = small_screw(12, 2.0, phase=0.3, oversize=2e-6, force=(150.0, -80.0, 2500.0), moment=(2.0, 3.0, 0.0))


def scaled(scene, length, modulus):
    """The same screw with all lengths times ``length``, moduli times ``modulus``, forces to match."""
    force = modulus * length**2

    def part(of, *names):
        longer = {name: getattr(of, name) * length for name in names}
        if hasattr(of, "material"):
            longer["material"] = Material(of.material.youngs_modulus * modulus, of.material.poissons_ratio)
        return replace(of, **longer)

    def terms(series):
        return tuple(replace(t, sin=t.sin * length, cos=t.cos * length) for t in series)

    def side(e):
        profile = tuple(c * length for c in e.profile)
        return replace(e, profile=profile, pitch=terms(e.pitch), roundness=terms(e.roundness))

    def support(s):
        return Support(s.at * length, tuple((n, v * length if n[0] == "u" else v) for n, v in s.fixed))

    def load(x):
        return Load(x.at * length, tuple(f * force for f in x.force), tuple(m * force * length for m in x.moment))

    listed = tuple((i, e * length) for i, e in scene.errors.balls.listed)
    sides = {name: side(scene.errors.side(name)) for name in SIDES}
    return replace(
        scene,
        track=part(scene.track, "pitch_radius", "lead"),
        screw=part(scene.screw, "length", "outer_diameter", "groove_radius", "bore"),
        nut=part(scene.nut, "position", "length", "outer_diameter", "groove_radius"),
        balls=part(scene.balls, "radius"),
        errors=replace(scene.errors, balls=replace(part(scene.errors.balls, "oversize"), listed=listed), **sides),
        supports=tuple(map(support, scene.supports)),
        loads=tuple(map(load, scene.loads)),
    )


UNITS = {"inch": (1 / 0.0254, 1.450377e-4), "stiff": (1.0, 1e3), "large": (20.0, 0.1)}


@pytest.mark.parametrize(("length", "modulus"), UNITS.values(), ids=UNITS)
@pytest.mark.parametrize("name", SCENES)
def test_units(name, length, modulus):
    """Inches and pounds, a stiffer metal, a larger screw: loads scale as E l2, angles stay."""
    one, other = solved(SCENES[name]), solved(scaled(SCENES[name], length, modulus))
    assert relative(other.load, one.load * modulus * length**2) < 1e-9
    loaded = one.load > 0.0
    assert other.contact_angle[loaded] == pytest.approx(one.contact_angle[loaded], abs=1e-9)


def turned(scene, angle):
    """The whole screw, with loads and errors, turned about its axis."""
    c, s = np.cos(angle), np.sin(angle)

    def turn(v):
        return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])

    return replace(
        scene,
        track=replace(scene.track, phase=scene.track.phase + angle),
        balls=replace(scene.balls, azimuths=tuple(a + angle for a in scene.balls.azimuths)),
        loads=tuple(replace(x, force=turn(x.force), moment=turn(x.moment)) for x in scene.loads),
    )


@pytest.mark.parametrize("angle", [0.1, -2.0, 7.0])
@pytest.mark.parametrize("name", ["lin-case1", "lin-case2", "bearing-9", "lateral"])
def test_origin_of_the_azimuth(name, angle):
    scene = SCENES.get(name, LATERAL)
    assert relative(solved(turned(scene, angle)).load, solved(scene).load) < 1e-9


@pytest.mark.parametrize("name", SCENES)
def test_mirror(name):
    one, other = solved(SCENES[name]), solved(mirrored(SCENES[name]))
    assert relative(other.load, one.load) < 1e-9
    assert relative(other.centreline, one.centreline * [1, -1, 1, -1, 1, -1]) < 1e-8


def end_for_end(scene):
    """The screw turned by half a turn about the x axis: the same hand, ends exchanged, balls in the other order."""
    length = scene.screw.length
    signs = {"ux": 1, "uy": -1, "uz": -1, "rx": 1, "ry": -1, "rz": -1}

    def turn(v):
        return (v[0], -v[1], -v[2])

    def support(s):
        return Support(length - s.at, tuple((n, signs[n] * v) for n, v in s.fixed))

    return replace(
        scene,
        track=replace(scene.track, phase=-scene.track.phase),
        nut=replace(scene.nut, position=length - scene.nut.position),
        balls=replace(scene.balls, azimuths=tuple(-a for a in reversed(scene.balls.azimuths))),
        supports=tuple(map(support, scene.supports)),
        loads=tuple(Load(length - x.at, turn(x.force), turn(x.moment)) for x in scene.loads),
    )


@pytest.mark.parametrize("name", ["lin-case1", "lin-case3-offset", "lateral"])
def test_reversed_force(name):
    """Turned end for end the force points in -z: SL takes over from SR and NL from NR, last ball from first."""
    scene = SCENES.get(name, LATERAL)
    one, other = solved(scene), solved(end_for_end(scene))
    assert relative(other.load[::-1, [1, 0, 3, 2]], one.load) < 1e-9


def test_reversed_force_in_place():
    """One full ring of balls without lead in the middle of a rigid shaft: the flanks swap, each ball its own."""
    scene = small_screw(count=7, lead=0.0, screw="rigid", oversize=4e-6)
    one, other = (solved(replace(scene, loads=(Load(0.1, (0.0, 0.0, f)),))).load for f in (900.0, -900.0))
    assert relative(other[:, [1, 0, 3, 2]], one) < 1e-10
    assert one[:, 0] == pytest.approx(np.full(7, one[0, 0]), rel=1e-10)
    assert one[0, 0] > 1.5 * one[0, 1] > 0.0


@pytest.mark.parametrize("name", ["bearing-9", "bearing-9-preload"])
@pytest.mark.parametrize("pitches", [1, 4])
def test_bearing_turned_by_ball_pitches(name, pitches):
    """The load turned by whole ball pitches: the balls' loads move on by as many balls."""
    scene = catalogue.scene(name)
    loads = turned(scene, 2 * np.pi * pitches / 9).loads
    one, other = solved(scene), solved(replace(scene, loads=loads))
    assert relative(np.roll(one.load, pitches, axis=0), other.load) < 1e-10
    assert relative(one.load, other.load) > 1e-2


#: An axial load with a lateral one at the far end: it tilts the shaft, so idle flanks come into touch.
TILTING = replace(SCENES["lin-case1"], loads=(*SCENES["lin-case1"].loads, Load(0.8, (200.0, 0.0, 0.0))))
LEFT_OUT = [*SCENES, "lin-case3", "lin-pitch", "lin-profile", "lin-roundness-2p1", "lin-nominal-4p1", "tilting"]


@pytest.mark.parametrize("name", LEFT_OUT)
def test_leaving_out_changes_nothing_and_sides_that_touch_after_all_are_taken_back(name):
    scene = TILTING if name == "tilting" else SCENES.get(name) or catalogue.scene(name)
    short, long = solved(scene), solved(scene, everything=True)
    assert relative(short.load, long.load) < 1e-9
    assert short.solver.unknowns <= long.solver.unknowns
    assert relative(short.centreline[[0, -1]], long.centreline[[0, -1]]) < 1e-8
    if name == "tilting":
        assert any("solved again with all four" in note for note in short.solver.notes)
        assert (short.load[:, [1, 2]] > 1.0).any()


@pytest.mark.parametrize(("force", "idle"), [(5000.0, "SR and NL"), (-5000.0, "SL and NR")])
def test_something_is_left_out(force, idle):
    scene = replace(catalogue.scene("lin-case1"), loads=(Load(0.0, (0.0, 0.0, force)),))
    short, long = solved(scene), solved(scene, everything=True)
    assert short.solver.unknowns < 0.6 * long.solver.unknowns
    assert any(f"flanks {idle}" in note for note in short.left_out)
    assert not any("solved again" in note for note in short.solver.notes)
    assert not any("between them" in note for note in long.left_out)


def test_rigid_screw_feels_only_the_wrench():
    """A force at the shaft's end is the same force at the nut's centre with its moment about that."""
    scene = small_screw(9, 2.0, oversize=2e-6, screw="rigid", fixed=(("rz", 0.0),))
    fx, fy, reach = 60.0, -40.0, 0.07
    away = replace(scene, loads=(Load(0.1 + reach, (fx, fy, 900.0)),))
    centre = replace(scene, loads=(Load(0.1, (fx, fy, 900.0), (-reach * fy, reach * fx, 0.0)),))
    assert relative(solved(away).load, solved(centre).load) < 1e-10
    assert solved(away).equilibrium.moment_residual < 1e-10


def test_rigid_screw_is_the_limit_of_a_stiff_one():
    """The difference falls as 1/E of the shaft; held by a tilted, shifted support away from the nut."""
    held = (("ux", 4e-6), ("uy", -2e-6), ("rx", 1e-5), ("ry", 2e-5), ("rz", 0.0))
    scene = small_screw(9, 2.0, oversize=2e-6, force=(100.0, 50.0, 1500.0), moment=(2.0, 1.0, 0.0), fixed=held)
    errors = []
    for factor in (1e4, 1e6, 1e8):
        stiff = replace(scene, screw=replace(scene.screw, material=Material(210e9 * factor, 0.28)))
        rigid = solved(with_ingredients(stiff, screw="rigid"))
        errors.append(relative(solved(stiff).load, rigid.load))
    assert errors[0] < 1e-3
    assert errors[1] == pytest.approx(errors[0] / 100, rel=0.05)
    assert errors[2] == pytest.approx(errors[1] / 100, rel=0.05)


def test_errors_of_no_size_and_the_outer_diameter_of_a_rigid_screw_change_nothing():
    scene = catalogue.scene("lin-case2")
    zero = dict.fromkeys(SIDES, SideErrors(profile=(0.0, 0.0)))
    other = replace(scene, errors=Errors(balls=scene.errors.balls, **zero))
    assert relative(solved(other).load, solved(scene).load) < 1e-9
    rigid = with_ingredients(scene, screw="rigid")
    thick = replace(rigid, screw=replace(scene.screw, outer_diameter=32.5e-3))
    assert np.array_equal(solved(rigid).load, solved(thick).load), "the beam's section is the only use of the diameter"
