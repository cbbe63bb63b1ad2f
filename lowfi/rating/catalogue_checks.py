"""Checks of a ball screw by catalogue formulas: buckling, critical speed, DN value and overall coefficient of friction.

The shaft between its bearings is a bar of the thread's root diameter d (bore d_b) over the free length L, with the nut at
its far end:

    F_c = c pi^2 E I / L^2,                            I = pi (d^4 - d_b^4)/64,                                        (1)
    n_c = lambda^2/(2 pi L^2) sqrt(E I/(rho A)),       A = pi (d^2 - d_b^2)/4,                                         (2)

The factors c and lambda depend on the support of both ends; manufacturers print

    fixed, free: 1/4, 1.875    supported both: 1, 3.142    fixed, supported: 2, 3.927    fixed both: 4, 4.730

(c: STAR/Rexroth RE 83 301/12.99, p. 97, f_Fk 2.6, 10.2, 20.4 and 40.6; lambda: THK general catalogue 513-1E, A15-32; the
exact c for a fixed and a supported end is 2.05). Manufacturers permit half of F_c, and a speed of 0.8 n_c (same pages). The
DN value is pitch diameter times speed. Its limit depends on the return of the balls and is given by the manufacturer; if it
is not given, 76,200 mm/min is used, 3000 in rpm for returns by tubes (Engineers Edge, critical speed of ball screws).

Valid for slender shafts, L above some 25 d (a shorter one yields before it buckles, and its bearings deflect before it
whirls), with a thread over the whole length, of steel of 7850 kg/m3. Only loads and reactions that compress the shaft
count. On a shaft with several bearing rows, rows closer than their pitch diameter are one bearing, which holds the shaft's
tilt if it has two rows or more.

A scene's coefficient of sliding friction must not be confused with the overall coefficient of a catalogue. Catalogues and
calculators treat a ball screw as a sliding thread with one small coefficient f for all losses. With the lead angle phi of
the pitch circle its efficiency against the load is

    eta = tan(phi)/tan(phi + arctan(f)).                                                                              (3)

The coefficient of a scene, by contrast, is that of sliding in the contacts of the balls, which mostly roll: about 0.1 with
grease, less with a full film. If f is used in its place, the computed loss is several times too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan, cos, pi, sin, sqrt, tan

import numpy as np

from rollbench.lowfi.rollers import tapered_bearing_of_row
from rollbench.lowfi.statics.result import AxisResult, StaticSolution
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.axis import Assembly, RollingSet
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Friction, Scene, Support, Track
from rollbench.meshes.quantity import quantity_field, result_record

#: Factors c (buckling) and lambda (critical speed) by the supports of both ends of a shaft.
FACTORS = {
    ("fixed", "fixed"): (4.0, 4.730),
    ("fixed", "supported"): (2.0, 3.927),
    ("supported", "supported"): (1.0, 3.142),
    ("fixed", "free"): (0.25, 1.875),
}

#: Density of steel [kg/m3].
DENSITY = 7850.0

#: Fractions of buckling load and critical speed that manufacturers permit.
SHARE_OF_LOAD, SHARE_OF_SPEED = 0.5, 0.8


@result_record
class ShaftLimits:
    """Buckling load, critical speed and DN value of a screw shaft's weakest free length, with permissible values."""

    #: Supports at both ends of the free length: fixed, supported or free.
    ends: str = quantity_field("ends", "supports at both ends of the free length: fixed (no tilt), supported or free")
    #: Free length L [m].
    length: float = quantity_field(
        "length_mm", "free length of the shaft: between bearings, or from a single bearing to the free end"
    )
    #: Root diameter of the thread [m].
    root: float = quantity_field("root_diameter_mm", "root diameter of the thread, used as the shaft's diameter")
    #: Euler's buckling load F_c [N].
    buckling: float = quantity_field(
        "buckling_N", "Euler's buckling load of the free length", error="depends on the stiffness of the supports"
    )
    #: Largest axial compression of the shaft by its loads [N]; 0 if the shaft is only in tension.
    compression: float = quantity_field("compression_N", "largest axial compression of the shaft under its loads")
    #: Critical (whirling) speed of the shaft [rad/s].
    critical: float = quantity_field(
        "critical_speed_rpm", "critical speed of the free length (first whirl)", error="as above"
    )
    #: Speed of the shaft in the scene's motion [rad/s]; None if the scene gives no speed.
    speed: float | None = quantity_field("speed_rpm", "speed of the scene's motion")
    #: DN value, pitch diameter times speed [m rad/s]; None without a speed.
    dn: float | None = quantity_field("dn_mm_rpm", "DN value: pitch diameter times speed")
    #: Largest permissible DN value [m rad/s].
    dn_limit: float = quantity_field("dn_limit_mm_rpm", "largest permissible DN value, from `operation.dn_limit`")
    #: Permissible compression, half of the buckling load [N].
    allowed_load: float = quantity_field(
        "allowed_compression_N",
        "permissible compression: half the buckling load, as makers state",
        heading="allowed compression",
        note="buckles under {buckling_N} N",
    )
    #: Permissible speed, the smaller of 0.8 times the critical speed and the speed at the DN limit [rad/s].
    allowed_speed: float = quantity_field(
        "allowed_speed_rpm",
        "permissible speed: the smaller of 0.8 times the critical speed and the speed at the DN limit",
        heading="allowed speed",
        note="whirls at {critical_speed_rpm} rpm; DN limit {dn_limit_mm_rpm} mm/min",
    )

    @property
    def warnings(self) -> list[ResultWarning]:
        """Warnings if the scene exceeds the permissible compression or speed of the shaft."""
        found = []
        if self.compression > self.allowed_load:
            words = f"{self.compression:.4g} N compress {1e3 * self.length:.4g} mm of shaft with the ends {self.ends}"
            text = f"{words}; makers allow {self.allowed_load:.4g} N, half of the buckling load"
            brief = f"compression {self.compression:.4g} N, above {self.allowed_load:.4g} N"
            found.append(ResultWarning("buckling", text, brief))
        if self.speed is not None and self.speed > self.allowed_speed:
            turns, most, critical = (x * 30.0 / pi for x in (self.speed, self.allowed_speed, self.critical))
            words = f"the shaft turns at {turns:.4g} rpm; {most:.4g} rpm are allowed"
            text = f"{words}, by the critical speed of {critical:.4g} rpm and by the DN value"
            found.append(ResultWarning("speed", text, f"{turns:.4g} rpm, above {most:.4g} rpm"))
        return found


def root_diameter(scene: Scene) -> float:
    """Return the root diameter of a screw's thread [m], at the apex where the two arcs of the groove meet."""
    track, slack = scene.track, scene.screw.groove_radius - scene.balls.radius
    deep = sqrt(scene.screw.groove_radius**2 - (slack * sin(track.contact_angle)) ** 2)
    return 2.0 * (track.pitch_radius + slack * cos(track.contact_angle) - deep)


def lateral_bearings(scene: Scene | Assembly) -> list[tuple[float, bool]]:
    """Return the axial position [m] of each bearing that holds a shaft laterally, and whether it holds its tilt too.

    A support holds what it fixes: both lateral displacements, and the tilt if it fixes both tilting rotations. So do the
    bearing rows of an assembly whose outer rings are fixed, or stand in housings that supports or springs hold laterally.
    Rows closer to each other than their pitch diameter are one bearing, in the middle between them. Two or more rows hold
    the tilt, a single row does not.

    Returns
    -------
    list[tuple[float, bool]]
        Position and whether the tilt is held, from left to right.
    """
    found = [(s.at, _support_fixes(s, "rx", "ry")) for s in scene.supports if _support_fixes(s, "ux", "uy")]
    if isinstance(scene, Assembly):
        found += [(_middle(rows), len(rows) > 1) for rows in _bearings_of_rows(scene)]
    return sorted(found)


def _bearings_of_rows(assembly: Assembly) -> list[list[RollingSet]]:
    """Return the bearing rows that hold a shaft laterally, those of one bearing together, from left to right."""
    bearings: list[list[RollingSet]] = []
    for row in sorted((s for s in assembly.sets if _holds_laterally(s, assembly)), key=lambda s: s.position):
        if bearings and row.position - bearings[-1][-1].position < _pitch_diameter(row):
            bearings[-1].append(row)
        else:
            bearings.append([row])
    return bearings


def _middle(rows: Sequence[RollingSet]) -> float:
    """Return the axial position in the middle of the rows of a bearing [m]."""
    return 0.5 * (rows[0].position + rows[-1].position)


def _holds_laterally(row: RollingSet, assembly: Assembly) -> bool:
    """Return whether a set is a bearing on the shaft whose outer ring the frame holds laterally, rigidly or by springs."""
    if row.kind == "ball nut" or row.carrier is not None:
        return False
    if row.housing is None:
        return True
    housing = next(h for h in assembly.housings if h.name == row.housing)
    joined = [j.stiffness for j in assembly.joints if housing.name in (j.first, j.second)]
    springs = [K for K in (housing.stiffness, *joined) if K is not None]
    fixed = {name for name, _ in housing.fixed}
    return all(name in fixed or any(K[k][k] > 0.0 for K in springs) for k, name in enumerate(("ux", "uy")))


def _pitch_diameter(row: RollingSet) -> float:
    """Return the pitch diameter of a row of balls or rollers [m]."""
    if isinstance(row.parts, Scene):
        return 2.0 * row.parts.track.pitch_radius
    return tapered_bearing_of_row(row.parts).pitch_diameter


def free_lengths_with_supports(scene: Scene | Assembly) -> list[tuple[float, tuple[str, str]]]:
    """Return the free lengths of a screw shaft, each with the supports of its ends: "fixed", "supported" or "free".

    The first or last bearing (`lateral_bearings`) is a fixed end if it holds the shaft's tilt.

    Returns
    -------
    list[tuple[float, tuple[str, str]]]
        For each free length its value [m], between neighbouring bearings or from a single bearing to the farther end of the
        shaft, and the supports of its two ends, the stiffer one first.
    """
    bearings = lateral_bearings(scene)
    held = ["fixed" if tilt else "supported" for _, tilt in bearings]
    if len(bearings) == 1:
        ((at, _),) = bearings
        return [(max(at, scene.screw.length - at), (held[0], "free"))]
    kinds = [held[i] if i in (0, len(held) - 1) else "supported" for i in range(len(held))]
    pairs = zip(bearings, bearings[1:], kinds, kinds[1:], strict=False)
    return [(b - a, (x, y) if x == "fixed" else (y, x)) for (a, _), (b, _), x, y in pairs]


def _support_fixes(support: Support, *names: str) -> bool:
    """Return whether a support fixes all degrees of freedom with the given names, such as "ux"."""
    return {*names} <= {name for name, _ in support.fixed}


def buckling_load_and_critical_speed(
    length: float, ends: tuple[str, str], root: float, bore: float, modulus: float
) -> tuple[float, float]:
    """Return Euler's buckling load and the critical speed of a steel shaft.

    They are c pi^2 E I/L^2 and (lambda/L)^2 sqrt(E I/(rho A)), with factors c and lambda by the supports of both ends.

    Parameters
    ----------
    length
        Free length L [m].
    ends
        Supports of the two ends, the stiffer one first: "fixed", "supported" or "free", a key of `FACTORS`.
    root, bore
        Outer and inner diameter of the shaft [m].
    modulus
        Young's modulus [Pa].

    Returns
    -------
    tuple[float, float]
        Buckling load F_c [N] and critical speed 2 pi n_c [rad/s]; valid for L above some 25 diameters.

    References
    ----------
    Rexroth RE 83 301/12.99, p. 97; THK 513-1E, A15-32.

    Examples
    --------
    >>> load, speed = buckling_load_and_critical_speed(2.4, ("fixed", "supported"), 56.5e-3, 0.0, 210e9)
    >>> round(1e-3 * load), round(speed * 30.0 / pi)
    (360, 1868)
    """
    c, factor = FACTORS[ends]
    stiff, area = modulus * pi / 64.0 * (root**4 - bore**4), pi / 4.0 * (root**2 - bore**2)
    return c * pi**2 * stiff / length**2, factor**2 / length**2 * sqrt(stiff / (DENSITY * area))


def shaft_compression(scene: Scene | Assembly, result: StaticSolution) -> float:
    """Return the largest axial compression of a screw shaft [N] by its loads, the reactions of its supports and its sets.

    The force of each nut and bearing acts at its middle, that of rows which are one bearing (`lateral_bearings`) in the
    middle between them, so that their preload does not count. The compression is zero if the shaft is only in tension.

    ``result``: static result of the scene, with the reactions and contact loads.
    """
    forces = [(x.at, x.force[2]) for x in scene.loads]
    forces += [(s.at, float(r[2])) for s, r in zip(scene.supports, result.reactions, strict=False)]
    if isinstance(scene, Assembly) and isinstance(result, AxisResult):
        middle = {row.name: _middle(rows) for rows in _bearings_of_rows(scene) for row in rows}
        on_shaft = [s for s in result.sets if s.of.carrier is None]
        forces += [(middle.get(s.of.name, s.of.position), float(s.force[2])) for s in on_shaft]
    elif isinstance(scene, Scene) and result.equilibrium is not None:
        forces.append((scene.nut.position, float(result.equilibrium.contact_force[2])))
    at = sorted({z for z, _ in forces})
    pushed = np.cumsum([sum(f for z, f in forces if z == x) for x in at])
    return max(float(pushed[:-1].max(initial=0.0)), 0.0)


def shaft_limits(scene: Scene | Assembly, result: StaticSolution, nut: Scene | None = None) -> ShaftLimits | None:
    """Return the permissible compression and speed of a screw shaft, and its compression in a solved scene.

    Parameters
    ----------
    scene
        Screw with supports, or shaft with several nuts and bearings.
    result
        Static result of the scene.
    nut
        Nut on the shaft whose thread and DN value count; None: the only nut of the scene.

    Returns
    -------
    ShaftLimits | None
        Limits of the weakest free length. None for bearings, for a shaft that no bearing fixes laterally, and for a shaft
        that tilts freely about its only bearing.
    """
    if nut is None:
        assert isinstance(scene, Scene), "several nuts: say which"
        nut = scene
    spans = [(x, ends) for x, ends in free_lengths_with_supports(scene) if ends in FACTORS and x > 0.0]
    if nut.track.lead == 0.0 or not spans:
        return None
    root, across = root_diameter(nut), 2.0 * nut.track.pitch_radius
    shaft = root, scene.screw.bore, scene.screw.material.youngs_modulus
    found = [buckling_load_and_critical_speed(x, ends, *shaft) for x, ends in spans]
    weakest = min(range(len(spans)), key=lambda k: found[k][0])
    load, critical = found[weakest][0], min(speed for _, speed in found)
    length, ends = spans[weakest]
    speed = None if scene.motion is None else abs(scene.motion.speed)
    dn = None if speed is None else across * speed
    dn_limit = nut.operation.dn_limit * 1e-3 * pi / 30.0
    limits = SHARE_OF_LOAD * load, min(SHARE_OF_SPEED * critical, dn_limit / across)
    compression = shaft_compression(scene, result)
    return ShaftLimits(", ".join(ends), length, root, load, compression, critical, speed, dn, dn_limit, *limits)


#: Coefficient of friction up to which a warning is given: twice the largest overall coefficient of catalogues (0.003 to
#: 0.01 for ball screws, 0.001 to 0.002 for ball bearings).
OVERALL = 0.02


def efficiency_by_overall_friction(track: Track, coefficient: float) -> float:
    """Return the efficiency of a ball screw that moves against its load, from an overall coefficient of friction.

    It is tan(phi)/tan(phi + arctan(f)), phi being the lead angle of the pitch circle.

    Parameters
    ----------
    track
        Track of the screw, for its lead angle.
    coefficient
        Overall coefficient of friction f of a catalogue, for all losses; 0.003 to 0.01 for ball screws.

    Examples
    --------
    A lead of 10 mm at a pitch diameter of 40 mm:

    >>> round(efficiency_by_overall_friction(Track(20e-3, 10e-3, 0.785), 0.005), 4)
    0.9405
    """
    phi = abs(lead_angle(track))
    return tan(phi) / tan(phi + atan(coefficient))


def warn_of_overall_friction_coefficient(track: Track, friction: Friction) -> list[ResultWarning]:
    """Return a warning if a scene's coefficient of sliding friction is as small as overall coefficients of catalogues.

    The list is empty if there is nothing to warn of.

    Parameters
    ----------
    track
        Track of the balls; if it has a lead, the warning also states the efficiency that would follow.
    friction
        Coefficients of friction of the scene.
    """
    mu = max(friction.screw, friction.nut)
    if not 0.0 < mu <= OVERALL:
        return []
    percent = 100.0 * efficiency_by_overall_friction(track, mu)
    as_one = f", by which the efficiency would be {percent:.3g} %" if track.lead else ""
    brief = (
        f"friction coefficient {mu:g}, that of sliding in the contacts, is as low as overall coefficients of catalogues "
        f"and calculators{as_one}"
    )
    text = (
        f"{brief}; in contacts it is about 0.1 with grease, less with a full film: if an overall coefficient was meant, "
        "friction torque and losses are several times too small"
    )
    return [ResultWarning("coefficient", text, brief)]
