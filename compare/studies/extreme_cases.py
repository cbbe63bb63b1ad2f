"""Hard-to-solve scenes for the report's table of numerical stability.

The scenes are extreme on purpose (100 t of load, a shaft a thousand times too soft). They test whether a solver finds the
solution of the equations, not whether the model is valid there. Most can be described by a scene file; exceptions (such as
a bore that leaves too thin a wall) are stated at the scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from rollbench.compare.models.study import with_ball_count
from rollbench.compare.scenes import catalogue
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.parts import BallErrors, Errors, Load, Material, Scene, Support
from rollbench.meshes.section import grooved_volume_ratio

#: Status of a solved scene.
CONVERGED = "converged"

#: Status of a scene with a free rigid motion, whose name stands for the braces.
UNHELD = "not held: {}: no support and no contact resists it, and the loads drive it"

#: Statuses for three free rigid motions.
HELIX = UNHELD.format("screw motion along the helix")

ROTATION = UNHELD.format("rotation about the screw's axis")

TWO_BALLS = UNHELD.format("rigid motion in uy, uz, rx, ry at the nut's centre")


@dataclass(frozen=True)
class HardScene:
    """Scene that is hard to solve, with its group in the stability table and the status that a solver should report."""

    #: Name of the scene in the stability table.
    name: str
    #: Group of scenes in the stability table to which the scene belongs, such as "axis of rollers".
    table_group: str
    #: Scene of a screw or bearing, or of a shaft with several nuts or bearings.
    scene: Scene | Assembly
    #: Status that a solver should report: "converged", or the status that names a rigid motion that nothing resists.
    expected_status: str = CONVERGED


# --- scenes of one ball screw


def _loaded(
    base: Scene, force: tuple[float, float, float], moment_about_x: float = 0.0, axial_position: float = 0.0
) -> Scene:
    """Return a copy of the scene ``base`` with a single external load.

    ``force``: force along x, y, z [N]; ``moment_about_x``: moment about x [N m]; ``axial_position``: axial position of the
    load [m].
    """
    return replace(base, loads=(Load(axial_position, force, (moment_about_x, 0.0, 0.0)),))


def _with_ball_errors(base: Scene, oversize: float, half_width: float = 0.0, seed: int = 0) -> Scene:
    """Return a copy of the scene ``base`` whose only geometric errors are those of its ball radii.

    ``oversize``: excess of all ball radii over the nominal radius [m]; ``half_width``: largest random deviation of a radius
    from this oversize, uniformly distributed [m]; ``seed``: seed of the random deviations.
    """
    drawn = BallErrors(oversize=oversize, sigma=half_width / math.sqrt(3.0), distribution="uniform")
    return replace(base, errors=Errors(balls=drawn, seed=seed))


def _with_scaled_youngs_moduli(base: Scene, screw: float, nut: float, balls: float) -> Scene:
    """Return a copy of the scene ``base`` with Young's moduli of screw, nut and balls multiplied by one factor each."""

    def scaled_material(m: Material, factor: float) -> Material:
        """Return a copy of a material with Young's modulus multiplied by a factor."""
        return replace(m, youngs_modulus=m.youngs_modulus * factor)

    return replace(
        base,
        screw=replace(base.screw, material=scaled_material(base.screw.material, screw)),
        nut=replace(base.nut, material=scaled_material(base.nut.material, nut)),
        balls=replace(base.balls, material=scaled_material(base.balls.material, balls)),
    )


def with_shaft_stiffness(base: Scene, factor: float) -> Scene:
    """Return a copy of the scene ``base`` whose shaft is stiffer or softer as a beam, with unchanged Hertz contacts.

    ``factor``: new over old axial stiffness of the shaft, above 1 for a stiffer one. Stiffer shaft: Young's moduli of screw
    and nut are multiplied by ``factor``, and that of the balls is divided by ``2 - 1/factor``; the contact moduli do not
    change, because all parts of ``base`` have the same material. Softer shaft: the balls would need a negative modulus
    below a factor of 1/2, so the shaft gets a bore instead. The bore multiplies the area of the cross-section by
    ``factor``, and its second moment of area by ``factor (2 - factor)``. For factors below about 0.2 the wall is thinner
    than the groove is deep, which a scene file does not allow.
    """
    if factor >= 1.0:
        return _with_scaled_youngs_moduli(base, factor, factor, 1.0 / (2.0 - 1.0 / factor))
    outer = base.screw.outer_diameter * math.sqrt(grooved_volume_ratio(base))
    return replace(base, screw=replace(base.screw, bore=outer * math.sqrt(1.0 - factor)))


def with_groove_radius_ratio(base: Scene, ratio: float) -> Scene:
    """Return a copy of the scene ``base`` with groove radii of screw and nut of ``ratio`` times the ball radius."""
    radius = ratio * base.balls.radius
    return replace(base, screw=replace(base.screw, groove_radius=radius), nut=replace(base.nut, groove_radius=radius))


def with_lead(base: Scene, lead: float) -> Scene:
    """Return a copy of the screw ``base`` with another lead [m], and with a nut that is long enough for it.

    A lead of zero gives a bearing with 16 balls. With a lead of at most 6 mm the ball diameter becomes 3 mm, with the same
    ratio of groove radius to ball radius.
    """
    if lead == 0.0:
        ring = tuple(2.0 * math.pi * i / 16 for i in range(16))
        return replace(base, track=replace(base.track, lead=0.0), balls=replace(base.balls, azimuths=ring))
    long = replace(base, track=replace(base.track, lead=lead), nut=replace(base.nut, length=2.0 * lead + 14e-3))
    if lead > 6e-3:
        return long
    ratio = base.screw.groove_radius / base.balls.radius
    return with_groove_radius_ratio(replace(long, balls=replace(long.balls, radius=1.5e-3)), ratio)


def _free_laterally(base: Scene) -> Scene:
    """Return a copy of the scene ``base`` whose screw has supports only along and about its axis z.

    Lateral loads on the screw, and moments about x and y, are then carried by the balls alone.
    """
    return replace(base, supports=(Support(0.0, (("uz", 0.0), ("rz", 0.0))),))


def _with_displaced_screw_end(base: Scene, offset: float, oversize: float) -> Scene:
    """Return a copy of the scene ``base`` with oversized balls and a support that displaces the screw's right end along x.

    ``offset``: displacement of the end [m]; ``oversize``: excess of the ball radii over the nominal radius [m].
    """
    moved = Support(base.screw.length, (("ux", offset), ("uy", 0.0)))
    return replace(_with_ball_errors(base, oversize), supports=(*base.supports, moved))


def _scenes_of_loads(base: Scene) -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of the screw ``base``: axial and lateral loads, moments, and a laterally displaced end."""
    for k in range(-2, 7):
        yield HardScene(f"axial {10.0**k:g} N", "axial load", _loaded(base, (0.0, 0.0, 10.0**k)))
    yield HardScene("axial -5000 N", "axial load", _loaded(base, (0.0, 0.0, -5000.0)))
    for force in (1.0, 100.0, 5000.0):
        yield HardScene(f"lateral {force:g} N", "lateral load", _loaded(_free_laterally(base), (force, 0.0, 0.0)))
    for moment in (0.5, 50.0):
        scene = _loaded(_free_laterally(base), (0.0, 0.0, 0.0), moment)
        yield HardScene(f"moment {moment:g} N m", "moment only", scene)
    clear = _loaded(_with_ball_errors(base, -5e-6), (0.0, 0.0, 0.0), 0.01, axial_position=0.3)
    yield HardScene("moment 0.01 N m, clearance, clamped", "moment only", clear)
    alone = _with_displaced_screw_end(with_ball_count(base, 1), -3e-3, -5e-6)
    yield HardScene("offset -3 mm, away from one loose ball", "offset", replace(alone, loads=()))
    for oversize in (0.0, 7e-6):
        for force in (0.0, 5000.0):
            name = f"offset 3 mm, {force:g} N, {'preloaded' if oversize else 'no preload'}"
            yield HardScene(name, "offset", _loaded(_with_displaced_screw_end(base, 3e-3, oversize), (0.0, 0.0, force)))


def _scenes_of_clearance_and_preload(base: Scene) -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of the screw ``base``: clearance, preload and random ball sizes."""
    for gap in (5e-6, 50e-6):
        for force in (0.01, 1.0, 5000.0):
            scene = _loaded(_with_ball_errors(base, -gap), (0.0, 0.0, force))
            yield HardScene(f"clearance {gap * 1e6:g} um, {force:g} N", "clearance", scene)
    for tight in (0.0, 1e-6, 7e-6, 20e-6):
        for force in (0.0, 5000.0):
            scene = _loaded(_with_ball_errors(base, tight), (0.0, 0.0, force))
            yield HardScene(f"preload {tight * 1e6:g} um, {force:g} N", "preload", scene)
    for half in (5e-6, 20e-6):
        for tight in (0.0, 7e-6):
            for seed in (1, 2, 3):
                name = f"random +-{half * 1e6:g} um, preload {tight * 1e6:g} um, seed {seed}"
                yield HardScene(name, "random balls", _with_ball_errors(base, tight, half, seed))


def _scenes_of_stiffness(base: Scene) -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of the screw ``base``: a softer or stiffer shaft, and other Young's moduli."""
    factors = [10.0**k for k in (-3, -2, -1, 1, 2, 3)]
    for f in factors:
        yield HardScene(f"shaft x {f:g}, contacts unchanged", "shaft stiffness", with_shaft_stiffness(base, f))
    for f in (1e-3, 1e3):
        name = f"screw modulus x {f:g}, its contacts with it"
        yield HardScene(name, "shaft stiffness", _with_scaled_youngs_moduli(base, f, 1.0, 1.0))
    for f in factors:
        yield HardScene(f"all moduli x {f:g}", "moduli", _with_scaled_youngs_moduli(base, f, f, f))


def _scenes_of_geometry(base: Scene) -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of the screw ``base``: other conformities, numbers of balls, leads and contact angles."""
    for ratio in (1.01, 1.001, 1.0001, 1.00001):
        close = with_groove_radius_ratio(base, ratio)
        yield HardScene(f"r_G/r_B {ratio:g}, axial", "conformity", close)
        yield HardScene(f"r_G/r_B {ratio:g}, lateral", "conformity", _loaded(_free_laterally(close), (1000.0, 0.0, 0.0)))
    for count in (3, 10, 32, 100, 300, 1000):
        yield HardScene(f"{count} balls", "ball count", with_ball_count(base, count))
    for lead in (0.0, 5e-3, 7e-3, 20e-3, 40e-3):
        yield HardScene(f"lead {lead * 1e3:g} mm", "lead", with_lead(base, lead))
    for angle in (5, 15, 30, 45, 60, 75, 85):
        turned = replace(base, track=replace(base.track, contact_angle=math.radians(angle)))
        yield HardScene(f"contact angle {angle} deg", "contact angle", turned)
        if angle in (5, 85):
            held = replace(turned, supports=(Support(0.0, (("rz", 0.0),)),))
            loaded = _loaded(held, (1000.0, 0.0, 100.0))
            yield HardScene(f"contact angle {angle} deg, lateral", "contact angle", loaded)


def _scenes_with_free_rigid_motion(base: Scene) -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of the screw ``base``: one or two balls, or missing supports that may leave it free."""
    one = replace(base, balls=replace(base.balls, azimuths=(0.0,)))
    for force in (0.01, 5000.0):
        yield HardScene(f"one ball, {force:g} N", "one ball", _loaded(one, (0.0, 0.0, force)))
    pushed = replace(_free_laterally(_with_ball_errors(one, 1e-6)), loads=())
    yield HardScene("one ball, squeezed, free to move off", "one ball", pushed)
    ring = with_lead(base, 0.0)
    rz = (Support(0.0, (("rz", 0.0),)),)
    yield HardScene("one support: rotation", "support", replace(base, supports=rz))
    yield HardScene("no support, no load", "support", replace(base, supports=(), loads=()))
    yield HardScene("bearing, no support", "support", replace(ring, supports=()))
    yield HardScene("no support", "support", replace(base, supports=()), HELIX)
    held = (Support(0.0, (("ux", 0.0),)),)
    yield HardScene("one support: lateral", "support", replace(base, supports=held), HELIX)
    twist = (Load(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 10.0)),)
    yield HardScene("bearing under torque", "support", replace(ring, supports=(), loads=twist), ROTATION)
    two = replace(base, supports=rz, balls=replace(base.balls, azimuths=(0.0, 0.5)))
    yield HardScene("two balls, one support", "support", two, TWO_BALLS)


# --- parts of other materials and sizes, and shafts with a nut and several bearings

#: A polymer (POM) and a ceramic (silicon nitride), warming [K] with the expansion of steel [1/K], a long shaft [m].
POLYMER, CERAMIC = Material(3e9, 0.4), Material(310e9, 0.26)
WARMING, EXPANSION = (40.0, -300.0), 11.5e-6
LONG = 6.0
#: Axial offset of each bearing row of the package's ball-screw axis, which preloads it [m].
OFFSET = 5e-6
#: Status of a single row of tapered rollers whose shaft is pulled out of it.
PULLED = (
    "not held: the loads open every contact that could carry them (linear program: rigid motion of the shaft in ux, uy, "
    "uz, rx, ry)"
)


def _scenes_of_material_and_size(base: Scene) -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of the screw ``base``: other materials, one large ball, four balls, and a long shaft."""
    nut = replace(base, nut=replace(base.nut, material=POLYMER))
    balls = replace(base, balls=replace(base.balls, material=CERAMIC))
    for name, scene in (("polymer nut", nut), ("ceramic balls", balls)):
        yield HardScene(name, "material", scene)
        yield HardScene(f"{name}, no load", "material", replace(scene, loads=()))
        yield HardScene(f"{name}, lateral", "material", _loaded(_free_laterally(scene), (1000.0, 0.0, 0.0)))
    for excess in (10e-6, 50e-6):
        large = replace(base, errors=Errors(balls=BallErrors(listed=((7, excess),))))
        for force in (0.0, 0.01, 5000.0):
            name = f"one ball {excess * 1e6:g} um too large, {force:g} N"
            yield HardScene(name, "one large ball", _loaded(large, (0.0, 0.0, force)))
    four = with_ball_count(base, 4)
    yield HardScene("4 balls, 0.01 N", "four balls", _loaded(four, (0.0, 0.0, 0.01)))
    yield HardScene("4 balls, 100 kN", "four balls", _loaded(four, (0.0, 0.0, 1e5)))
    yield HardScene("4 balls, lateral", "four balls", _loaded(_free_laterally(four), (1000.0, 0.0, 0.0)))
    long = replace(base, screw=replace(base.screw, length=LONG), nut=replace(base.nut, position=0.5 * LONG))
    yield HardScene("6 m shaft", "long shaft", long)
    free = _free_laterally(long)
    yield HardScene("6 m shaft, lateral", "long shaft", _loaded(free, (1000.0, 0.0, 0.0)))
    moment = _loaded(free, (0.0, 0.0, 0.0), 50.0, axial_position=LONG)
    yield HardScene("6 m shaft, moment at its end", "long shaft", moment)


def built_in_shaft_scene(name: str) -> Assembly:
    """Return the built-in scene ``name`` of a shaft with several nuts or bearings; TypeError if the scene has only one."""
    found = catalogue.shipped_scene(name)
    if not isinstance(found, Assembly):
        raise TypeError(f"{name} has a single nut or bearing, not several on a shaft")
    return found


def axis_of_balls_and_rollers() -> Assembly:
    """Return the built-in ball-screw axis with tapered roller bearings (of Smith's example) at its right end.

    The bearings are preloaded by axial offsets.
    """
    axis, row = _axis_preloaded_by_offsets(), built_in_shaft_scene("smith-axis-taper").sets[0].parts
    right = tuple(replace(s, kind="tapered roller bearing", parts=row) for s in axis.sets[3:])
    return replace(axis, sets=(*axis.sets[:3], *right))


def _axis_preloaded_by_offsets() -> Assembly:
    """Return the built-in ball-screw axis with ball bearings that are preloaded by axial offsets.

    With this kind of preload the energy solver and all other formulations of the static problem solve the same equations.
    """
    towards = {"+z": -OFFSET, "-z": OFFSET, "both": 0.0}
    return _change_sets(
        built_in_shaft_scene("axis-fixed-fixed"), lambda s: replace(s, preload=0.0, offset=towards.get(s.thrust, 0.0))
    )


def _loaded_axis(axis: Assembly, axial_force: float, lateral_force: float = 0.0, moment: float = 0.0) -> Assembly:
    """Return a copy of a ball-screw axis with other external loads.

    ``axial_force``: axial force [N], which acts on the carriage, or on the shaft without a carriage; ``lateral_force``:
    lateral force on the shaft along x [N], half of which also acts along y; ``moment``: moment on the shaft about x [N m].
    """
    at = axis.screw.length / 3.0
    carriage = tuple(h for h in axis.housings if h.name == "carriage")
    side = Load(at, (lateral_force, 0.5 * lateral_force, 0.0 if carriage else axial_force), (moment, 0.0, 0.0))
    moved = tuple(replace(h, force=(0.0, 0.0, axial_force)) if h in carriage else h for h in axis.housings)
    return replace(axis, housings=moved, loads=(side,))


def _change_sets(axis: Assembly, change: Callable[[RollingSet], RollingSet]) -> Assembly:
    """Return a copy of a ball-screw axis in which a function replaces each nut and each bearing row.

    ``change``: function that takes a nut or row and returns its replacement.
    """
    return replace(axis, sets=tuple(change(s) for s in axis.sets))


def _change_balls(axis: Assembly, change: Callable[[Scene], Scene]) -> Assembly:
    """Return a copy of a ball-screw axis in which a function replaces the geometry of each ball nut and row of balls.

    ``change``: function that takes the geometry and returns its replacement.
    """
    return _change_sets(axis, lambda s: replace(s, parts=change(s.parts)) if isinstance(s.parts, Scene) else s)


def _change_rollers(axis: Assembly, **changes: Any) -> Assembly:
    """Return a copy of a ball-screw axis with changed rows of rollers; ``changes``: new values by field of `RollerRow`."""
    return _change_sets(
        axis, lambda s: replace(s, parts=replace(s.parts, **changes)) if isinstance(s.parts, RollerRow) else s
    )


def _without_preload(axis: Assembly) -> Assembly:
    """Return a copy of a ball-screw axis without preload, axial offsets of bearings and geometric errors."""
    bare = _change_sets(axis, lambda s: replace(s, preload=0.0, offset=0.0))
    return _change_balls(bare, lambda p: replace(p, errors=Errors()))


def _with_ball_count(scene: Scene, count: int) -> Scene:
    """Return a nut with only its first ``count`` balls, or a bearing with ``count`` evenly spaced balls."""
    ring = tuple(2.0 * math.pi * i / count for i in range(count))
    azimuths = ring if scene.track.lead == 0.0 else scene.balls.azimuths[:count]
    return replace(scene, balls=replace(scene.balls, azimuths=azimuths))


def _with_longer_shaft(axis: Assembly, length: float) -> Assembly:
    """Return a copy of a ball-screw axis with a longer shaft.

    ``length``: new length of the shaft [m]. Parts near the right end move with this end; the carriage and other parts
    near the middle move half as far.
    """
    more = length - axis.screw.length

    def moved_position(z: float) -> float:
        """Return where a part at the axial position ``z`` [m] is on the longer shaft [m]."""
        return z + (more if z > 0.6 * axis.screw.length else 0.5 * more if z > 0.4 * axis.screw.length else 0.0)

    def moved_row(s: RollingSet) -> RollingSet:
        """Return a nut or bearing row at its position on the longer shaft."""
        at = moved_position(s.position)
        if isinstance(s.parts, Scene):
            screw, nut = replace(s.parts.screw, length=length), replace(s.parts.nut, position=at)
            s = replace(s, parts=replace(s.parts, screw=screw, nut=nut))
        return replace(s, position=at)

    return replace(
        _change_sets(axis, moved_row),
        screw=replace(axis.screw, length=length),
        housings=tuple(replace(h, at=moved_position(h.at)) for h in axis.housings),
        segments=tuple(replace(x, start=moved_position(x.start), end=moved_position(x.end)) for x in axis.segments),
    )


def _axis_variants_of_loads(axis: Assembly) -> Iterator[tuple[str, Assembly]]:
    """Yield names and hard-to-solve variants of a ball-screw axis: other loads, no preload, a warmer or colder shaft."""
    for force in (0.0, 0.01, 3000.0, -3000.0, 1e6):
        yield f"axial {force:g} N", _loaded_axis(axis, force)
    for force in (1.0, 1e3, 1e5):
        yield f"across {force:g} N", _loaded_axis(axis, 0.0, force)
    yield "along 30 kN and across 10 kN", _loaded_axis(axis, 3e4, 1e4)
    yield "moment 500 N m", _loaded_axis(axis, 0.0, 0.0, 500.0)
    loose = _without_preload(axis)
    yield "no preload, no load", _loaded_axis(loose, 0.0)
    yield "no preload, axial 3000 N", _loaded_axis(loose, 3000.0)
    yield "no preload, across 1000 N", _loaded_axis(loose, 0.0, 1e3)
    for warming in WARMING:
        yield f"{warming:+g} K", replace(axis, thermal_strain=warming * EXPANSION)


def _axis_variants_of_parts(axis: Assembly) -> Iterator[tuple[str, Assembly]]:
    """Yield names and hard-to-solve variants of a ball-screw axis: other materials, conformity, balls, and a long shaft."""

    def with_polymer_nut(p: Scene) -> Scene:
        """Return a ball nut (lead above zero) of polymer; a ball bearing is returned unchanged."""
        return replace(p, nut=replace(p.nut, material=POLYMER)) if p.track.lead > 0.0 else p

    yield "polymer nut", _change_balls(axis, with_polymer_nut)
    yield "ceramic balls", _change_balls(axis, lambda p: replace(p, balls=replace(p.balls, material=CERAMIC)))
    yield "conformity 0.505", _change_balls(axis, lambda p: with_groove_radius_ratio(p, 1.01))
    one = Errors(balls=BallErrors(listed=((7, 20e-6),)))
    yield "one ball 20 um too large in each set", _change_balls(axis, lambda p: replace(p, errors=one))
    four = _change_balls(axis, lambda p: _with_ball_count(p, 4))
    yield "4 balls in each set", four
    yield "4 balls in each set, across 1000 N", _loaded_axis(four, 3000.0, 1e3)
    long = _with_longer_shaft(axis, LONG)
    yield "6 m shaft", long
    yield "6 m shaft, across 1000 N", _loaded_axis(long, 3000.0, 1e3)
    yield "6 m shaft, -300 K", replace(long, thermal_strain=-300.0 * EXPANSION)


def _axis_variants_of_rollers(axis: Assembly) -> Iterator[tuple[str, Assembly]]:
    """Yield names and hard-to-solve variants of a ball-screw axis with other rollers: other crown, number, material etc."""
    crossed = _loaded_axis(axis, 2000.0, 2000.0)
    yield "1 slice, across", _change_rollers(crossed, slices=1)
    yield "101 slices, across", _change_rollers(crossed, slices=101)
    yield "crown of 0.1 m, across", _change_rollers(crossed, crown=0.1)
    yield "3 rollers, across", _change_rollers(crossed, count=3)
    yield "100 rollers", _change_rollers(crossed, count=100)
    yield "cup angle 5 deg", _change_rollers(crossed, cup_angle=math.radians(5.0), roller_angle=math.radians(0.7))
    yield "ceramic rings and rollers", _change_rollers(crossed, material=CERAMIC)


def _hard_axis_scenes() -> Iterator[HardScene]:
    """Yield hard-to-solve scenes of ball-screw axes with ball bearings and tapered roller bearings."""
    rollers, balls = built_in_shaft_scene("smith-axis-taper"), _axis_preloaded_by_offsets()
    of_loads, of_parts, of_rollers = _axis_variants_of_loads, _axis_variants_of_parts, _axis_variants_of_rollers
    for kind, axis, groups in (
        ("balls and rollers", axis_of_balls_and_rollers(), (of_loads, of_parts, of_rollers)),
        ("rollers", rollers, (of_loads, of_rollers)),
    ):
        for group in groups:
            for name, scene in group(axis):
                yield HardScene(f"axis of {kind}: {name}", f"axis of {kind}", scene)
    for warming in WARMING:
        heated = replace(balls, thermal_strain=warming * EXPANSION)
        yield HardScene(f"axis of balls: {warming:+g} K", "axis of balls", heated)
    alone = replace(rollers, sets=rollers.sets[:1], housings=())
    for force in (1000.0, -1000.0):
        held = PULLED if force > 0.0 else CONVERGED
        yield HardScene(f"one row of rollers: axial {force:g} N", "axis of rollers", _loaded_axis(alone, force), held)


def hard_scenes() -> list[HardScene]:
    """Return all hard-to-solve scenes in a fixed order: variants of the screw ``lin-case1``, then shafts with bearings."""
    base = catalogue.scene("lin-case1")
    groups = (
        _scenes_of_loads,
        _scenes_of_clearance_and_preload,
        _scenes_of_stiffness,
        _scenes_of_geometry,
        _scenes_with_free_rigid_motion,
        _scenes_of_material_and_size,
    )
    found = [*(c for group in groups for c in group(base)), *_hard_axis_scenes()]
    return [replace(c, scene=replace(c.scene, name=c.name)) for c in found]
