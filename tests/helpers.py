"""Shared by the physics tests: small scenes, changes of scenes, and problems ready for the solver."""

from dataclasses import replace

import numpy as np

from rollbench.lowfi.statics.problem import build_problem
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes import parts
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.sockets import largest_fitting_refinement_box

STEEL = parts.Material(210e9, 0.28)
ALL_BUT_AXIAL = (("ux", 0.0), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0), ("rz", 0.0))

#: One error of every kind on every flank, all different.
FLANK_ERRORS = parts.Errors(
    SL=parts.SideErrors(profile=(1e-6, -3e-6, 2e-6), pitch=(parts.FourierTerm(2.0, 3e-6, 1e-6),), pitch_along="axis"),
    SR=parts.SideErrors(profile=(-2e-6, 2e-6), roundness=(parts.FourierTerm(1.0, 0.0, 4e-6),)),
    NL=parts.SideErrors(
        profile=(0.0, 0.0, 4e-6), pitch=(parts.FourierTerm(0.5, 2e-6),), roundness=(parts.FourierTerm(3.0, 1e-6),)
    ),
    NR=parts.SideErrors(profile=(0.0, -2e-6), pitch=(parts.FourierTerm(1.0, 0.0, 2e-6),), pitch_along="axis"),
)
#: Keywords for ``replace`` that keep their pitch and roundness but make the flanks even.
NO_PROFILES = {name: replace(FLANK_ERRORS.side(name), profile=()) for name in parts.SIDES}


def small_screw(
    count=6,
    turns=1.0,
    *,
    lead=20e-3,
    beta=np.pi / 4,
    hand="right",
    phase=0.0,
    oversize=0.0,
    fixed=ALL_BUT_AXIAL,
    force=(0.0, 0.0, 0.0),
    moment=(0.0, 0.0, 0.0),
    load_at=0.1,
    **ingredients,
):
    """Screw of 200 mm with ``count`` balls spread evenly over ``turns`` about its middle, held at its left end."""
    sign = 1.0 if hand == "right" else -1.0
    places = phase + sign * 2.0 * np.pi * turns * ((np.arange(count) + 0.5) / count - 0.5)
    return parts.Scene(
        name="small",
        title="small screw",
        track=parts.Track(16.5e-3, lead, beta, hand=hand, phase=phase),
        screw=parts.Screw(0.2, 32e-3, 3.254e-3, STEEL),
        nut=parts.Nut(0.1, 54e-3, 48e-3, 3.3e-3, STEEL),
        balls=parts.Balls(2.778e-3, STEEL, tuple(places)),
        errors=parts.Errors(balls=parts.BallErrors(oversize=oversize)),
        supports=(parts.Support(0.0, fixed),) if fixed else (),
        loads=(parts.Load(load_at, force, moment),),
        ingredients=parts.Ingredients(**ingredients),
    )


def with_ingredients(scene, **changes):
    return replace(scene, ingredients=replace(scene.ingredients, **changes))


def four_flank_problem(scene, *, everything=False):
    """The arrays of a scene's static problem with all four flanks."""
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout)
    return build_problem(scene, drawn, layout, np.ones(4, dtype=bool), everything=everything)


def solved(scene, **options):
    """Result of a scene that must converge."""
    result = solve_static(scene, **options)
    assert result.status == "converged"
    return result


def relative(found, expected):
    """Largest difference over the largest expected size."""
    return float(np.abs(np.asarray(found) - expected).max() / np.abs(expected).max())


def mirrored(scene):
    """Mirror image in the plane y = 0: other hand, opposite azimuths; forces as vectors, moments as pseudovectors."""
    sign = {name: -1.0 if name in ("uy", "rx", "rz") else 1.0 for name in parts.FREEDOMS}
    force_sign, moment_sign = np.split(np.array(list(sign.values())), 2)

    def side(e):
        pitch, roundness = (tuple(replace(t, sin=-t.sin) for t in terms) for terms in (e.pitch, e.roundness))
        return replace(e, pitch=pitch, roundness=roundness)

    def load(x):
        force, moment = force_sign * x.force, moment_sign * x.moment
        return parts.Load(x.at, tuple(force.tolist()), tuple(moment.tolist()))

    return replace(
        scene,
        track=replace(scene.track, hand="left" if scene.track.hand == "right" else "right", phase=-scene.track.phase),
        nut=replace(scene.nut, azimuth=-scene.nut.azimuth),
        balls=replace(scene.balls, azimuths=tuple(-a for a in scene.balls.azimuths)),
        errors=replace(scene.errors, **{n: side(scene.errors.side(n)) for n in parts.SIDES}),
        supports=tuple(replace(s, fixed=tuple((f, sign[f] * v) for f, v in s.fixed)) for s in scene.supports),
        loads=tuple(map(load, scene.loads)),
    )


def dense(band):
    """Symmetric matrix of a lower band stored column by column, ``band[j, i - j] = A[i, j]``."""
    n, width = band.shape
    full = np.zeros((n, n))
    for k in range(width):
        i = np.arange(n - k)
        full[i + k, i] = full[i, i + k] = band[: n - k, k]
    return full


def solid_sizes(scene, *, hole=None):
    """Radii [m] that a body's mesh needs: screw's land and bore, nut's land and outside; flat ends of the nut."""
    R, outer = scene.track.pitch_radius, scene.screw.outer_diameter / 2.0
    bore = max(scene.screw.bore / 2.0, R / 11.0) if hole is None else hole
    middle, half = scene.nut.position, scene.nut.length / 2.0
    return outer, bore, 2.0 * R - outer, scene.nut.outer_diameter / 2.0, (middle - half, middle + half)


def sockets_of(scene, sides):
    """Azimuth, station and side of every socket of a body."""
    layout = ball_layout(scene)
    return tuple((float(a), float(z), s) for a, z in zip(layout.azimuth, layout.z, strict=True) for s in sides)


def body_specs(scene, sides, *, fine=1.6e-3, coarse=8e-3, beyond=20e-3, size=None, hole=None):
    """Screw and nut with fitted sockets; fine, coarse for balls of 2.778 mm radius; beyond: shaft beside the nut [m]."""
    m, layout = GrooveMap.from_scene(scene), ball_layout(scene)
    outer, bore, land, outside, ends = solid_sizes(scene, hole=hole)
    size = size or largest_fitting_refinement_box(m, layout, sides, outer, bore, land, outside, ends)
    scale = m.ball / 2.778e-3
    beyond = beyond if m.rg else 0.0
    reach = max(ends[0] - beyond, 0.0), min(ends[1] + beyond, scene.screw.length)

    def spec(radii, z, screw):
        sockets = sockets_of(scene, [s for s in sides if (s < 2) == screw])
        return GroovedBodySpec(*radii, *z, screw, sockets, size, scale * fine, scale * coarse)

    return {"screw": spec((bore, outer), reach, True), "nut": spec((land, outside), ends, False)}


#: Contact forces [N] and angles [rad] of a ball of a ball screw in two-, three- and four-point contact.
SCREW_STATES = {
    "two": (np.array([40.0, 0.0, 0.0, 40.0]), np.full(4, np.pi / 4)),
    "three": (np.array([38.0, 0.0, 4.0, 37.0]), np.array([0.80, 0.78, 0.78, 0.79])),
    "four": (np.array([53.0, 18.0, 17.0, 54.0]), np.array([0.82, 0.81, 0.78, 0.79])),
}
