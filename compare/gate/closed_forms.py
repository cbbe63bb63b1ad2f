"""Cases with a closed form, computed here independently of the solvers, for the gate and the report."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin

import numpy as np

from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.statics.contacts import drawn_hertz, nominal_hertz
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Errors, Ingredients, Load, Scene, Support
from rollbench.meshes.roots import brentq
from rollbench.meshes.section import screw_section


def sphere_on_flat(scene: Scene, force: float) -> list[tuple[str, str, float, float]]:
    """Hertz 1881: approach, radius and pole pressure of the scene's ball on a flat, from its textbook formulas.

    Returns (name, unit, computed, closed form).
    """
    m = scene.balls.material
    modulus = contact_modulus(m.youngs_modulus, m.poissons_ratio, m.youngs_modulus, m.poissons_ratio)
    r = scene.balls.radius
    c = hertz_constants(np.array(1.0 / r), np.array(1.0 / r), modulus)
    a = (3.0 * force * r / (4.0 * modulus)) ** (1.0 / 3.0)
    return [
        ("Hertz, sphere on flat: approach", "um", 1e6 * float(c.C) * force ** (2.0 / 3.0), 1e6 * a * a / r),
        ("Hertz, sphere on flat: contact radius", "mm", 1e3 * float(c.C_a) * force ** (1.0 / 3.0), 1e3 * a),
        (
            "Hertz, sphere on flat: pole pressure",
            "MPa",
            1e-6 * float(c.pressure(np.array(force))),
            1e-6 * 1.5 * force / (pi * a * a),
        ),
    ]


def rigid_axial(scene: Scene) -> tuple[float, float]:
    """Load of every ball of an error-free rigid screw under its axial load, computed and in closed form [N].

    Closed form: shifting the screw by s lengthens the line between the groove centres of each ball from d to
    D = |(d cos beta, d sin beta + s cos alpha)|; F = ((D - d)/(C_S + C_N))^(3/2) acts along that line.
    """
    rigid = replace(
        scene,
        errors=Errors(),
        ingredients=Ingredients(screw="rigid"),
        supports=(Support(0.0, tuple((k, 0.0) for k in ("ux", "uy", "rx", "ry", "rz"))),),
    )
    force = sum(load.force[2] for load in scene.loads)
    constants = nominal_hertz(rigid).C
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    d = scene.screw.groove_radius + scene.nut.groove_radius - 2.0 * scene.balls.radius
    pair = float(constants[0] + constants[3])

    def ball(s: float) -> tuple[float, float]:
        x, z = d * cos(beta), d * sin(beta) + s * cos(alpha)
        size = hypot(x, z)
        return ((size - d) / pair) ** 1.5, z / size * cos(alpha)

    def excess(s: float) -> float:
        load, share = ball(s)
        return scene.ball_count * load * share - force

    s = float(brentq(excess, 0.0, 1e-3, xtol=1e-20, rtol=1e-15))
    return float(solve_static(rigid).load[:, 0].mean()), ball(s)[0]


def cantilever(scene: Scene) -> tuple[float, float]:
    """Tip deflection of only the scene's shaft as a cantilever under 1 N, computed and in closed form [m].

    Closed form: L^3/(3 E I) + L/(kappa G A) (Timoshenko), the ball contacts being left without load by clearance.
    """
    length = scene.screw.length
    alone = replace(
        scene,
        errors=replace(Errors(), balls=replace(Errors().balls, oversize=-0.4 * scene.balls.radius)),
        supports=(Support(0.0, tuple((k, 0.0) for k in ("ux", "uy", "uz", "rx", "ry", "rz"))),),
        loads=(Load(length, force=(1.0, 0.0, 0.0)),),
    )
    section = screw_section(alone)
    result = solve_static(alone)
    return float(result.centreline[-1, 0]), length**3 / (3.0 * section.EI) + length / section.kGA


def two_opposite_balls(scene: Scene) -> tuple[float, float]:
    """Two opposite balls without lead under an axial load: each carries F / (2 sin gamma), computed and closed form."""
    ring = replace(
        scene,
        errors=Errors(),
        track=replace(scene.track, lead=0.0),
        balls=replace(scene.balls, azimuths=(0.0, pi)),
        supports=(Support(0.0, tuple((k, 0.0) for k in ("ux", "uy", "rx", "ry", "rz"))),),
        ingredients=Ingredients(screw="rigid"),
        loads=(Load(0.0, force=(0.0, 0.0, 100.0)),),
    )
    result = solve_static(ring)
    gamma = float(result.contact_angle[0, 0])
    return float(result.load[0, 0]), 100.0 / (2.0 * sin(gamma))


def preload(scene: Scene, oversize: float) -> tuple[float, float]:
    """Load of a screw contact of an unloaded rigid screw with oversized balls, computed and in closed form [N].

    By symmetry a ball only shifts radially, by x: each screw flank closes by e + |(x - d cos beta, d sin beta)| - d,
    each nut flank likewise with x + d cos beta, d the groove centre's distance from the ball; radial forces balance.
    """
    squeezed = replace(
        scene,
        errors=replace(Errors(), balls=replace(Errors().balls, oversize=oversize)),
        loads=(),
        ingredients=Ingredients(screw="rigid"),
    )
    constants = drawn_hertz(squeezed, specimen(squeezed, ball_layout(squeezed))).C[0]
    beta = scene.track.contact_angle
    screw, nut = (body.groove_radius - scene.balls.radius for body in (scene.screw, scene.nut))

    def contact(x: float, d: float, sign: float, c: float) -> tuple[float, float]:
        reach = d * cos(beta) + sign * x
        size = hypot(reach, d * sin(beta))
        return ((oversize + size - d) / c) ** 1.5, reach / size

    def excess(x: float) -> float:
        fs, cs = contact(x, screw, -1.0, float(constants[0]))
        fn, cn = contact(x, nut, 1.0, float(constants[3]))
        return fs * cs - fn * cn

    x = float(brentq(excess, -oversize, oversize, xtol=1e-20, rtol=1e-15))
    return float(solve_static(squeezed).load[:, :2].mean()), contact(x, screw, -1.0, float(constants[0]))[0]
