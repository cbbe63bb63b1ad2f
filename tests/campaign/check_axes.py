"""An independent judge of several sets on one shaft: only from the numbers of a result and the scene.

It shares no code with the solvers. A state of the model lin is the answer where every ball is in balance, every contact
carries what Hertz' law gives it by the motions that are told, and every node of the shaft and every housing is in balance:
the energy is convex, so that it has no other minimum. A refusal is checked by a linear program of its own, or, of a row
whose balls cross the bottom of its groove, by the same state with arcs that go on there.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.optimize import linprog
from tests.campaign import check
from tests.campaign.check import along, carried, wrench

from rollbench.lowfi.rollers import TaperedBearing
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, Joint, RollerRow, RollingSet, diagonal_stiffness
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, Scene
from rollbench.meshes.section import contact_force_positions, screw_section, tube_section

#: Sides that a set has, by its thrust.
SIDES_OF = {"both": (0, 1, 2, 3), "+z": (0, 3), "-z": (1, 2), "deep groove": (0, 3)}
#: Share of the largest force that may be out of balance; force [N] that may be, the round-off of rollers that just touch.
CLOSE, TOUCH = 1e-9, 1e-15
#: Round-off of an elastic force over its stiffness times the motions: some operations of each.
STIFF = 64.0 * float(np.finfo(float).eps)
#: Words for a free motion that is pinned at the shaft's first node or at a housing, where planar sections may ask for a
#: share of the forces.
HELD = "fixed at its initial position"
#: Motion over the pitch radius, and rotation, from which on a linear program must not find an opening motion.
FAR = 0.1
#: Work of the loads along an opening motion of size one, over the largest, from which on it is a proof.
PROVEN = 1e-7
#: Springs [N/m, N m] of an outer part that slides on a housing: they yield by some nanometres.
TIE = diagonal_stiffness((1e11, 1e11, 0.0, 1e8, 1e8, 1e8))


def beam(assembly: Assembly, z: Array, q: Array) -> tuple[Array, Array]:
    """Forces ``(n, 6)`` that hold the nodes of the shaft at their motions, and their round-off: Timoshenko's element,
    clamped at its first end, by the flexibility of its tip."""
    thread = next((s.parts for s in assembly.sets if isinstance(s.parts, Scene) and s.parts.track.lead > 0.0), None)
    screw = assembly.screw
    base = tube_section(screw.outer_diameter, screw.bore, screw.material) if thread is None else screw_section(thread)
    out, noise = np.zeros((z.size, 6)), np.zeros((z.size, 6))
    for e, L in enumerate(np.diff(z)):
        middle, (a, b) = z[e] + 0.5 * L, q[e : e + 2]
        plain = next((p for p in assembly.segments if p.start <= middle <= p.end), None)
        s = base if plain is None else tube_section(plain.diameter, plain.bore, screw.material)
        tip = [[L**3 / (3 * s.EI) + L / s.kGA, L**2 / (2 * s.EI)], [L**2 / (2 * s.EI), L / s.EI]]
        k = np.linalg.inv(np.array(tip))
        px, my = k @ (b[0] - a[0] - L * a[4], b[4] - a[4])
        py, mx = k @ (b[1] - a[1] + L * a[3], a[3] - b[3])
        pz = s.EA * ((b[2] - a[2]) / L - assembly.thermal_strain)
        end = np.array([px, py, pz, -mx, my, s.GJ / L * (b[5] - a[5])])
        out[e + 1] += end
        out[e] -= end + np.array([0.0, 0.0, 0.0, -L * py, L * px, 0.0])
        moved, turned = (float(np.abs([a[h], b[h]]).max()) for h in (slice(3), slice(3, 6)))
        force = max(k[0, 0], s.EA / L) * (moved + L * turned)
        moment = max(k[1, 1], s.GJ / L) * turned + abs(k[0, 1]) * (moved + L * turned) + L * force
        noise[e : e + 2] += STIFF * np.repeat([force, moment], 3)
    return out, noise


def size_of(assembly: Assembly, result: AxisResult) -> float:
    """Largest force [N] met."""
    given = [x.force for x in assembly.loads] + [h.force for h in assembly.housings] + [s.force for s in result.sets]
    loads = [float(s.loads.max(initial=0.0)) for s in result.sets]
    return max([*loads, *(float(np.abs(v).max()) for v in given)])


def faults(assembly: Assembly, result: AxisResult) -> str:
    """Faults of a state of the model lin in words; empty if there are none.

    Where a free motion is held at one place, what moves may take a share there, unless the loads drive a motion that no
    contact resists; nor may such a motion go far.
    """
    free = " ".join(words for words in result.left_out if HELD in words)
    fault = unbalanced(assembly, result, "")
    motions = np.concatenate([result.centreline, *(h.motion[None] for h in result.housings)])
    far = float((np.abs(motions) / np.repeat([pitch_of(assembly), 1.0], 3)).max()) > FAR
    if not far and not (fault and free):
        return fault
    if proven(assembly, False) or (any(s.preload for s in assembly.sets) and proven(assembly, True)):
        return fault or "a motion that nothing resists goes far"
    return unbalanced(assembly, result, free)


def pitch_of(assembly: Assembly) -> float:
    """Largest pitch radius of balls [m], of 20 mm where there are none."""
    return max([s.parts.track.pitch_radius for s in assembly.sets if isinstance(s.parts, Scene)], default=0.02)


def unbalanced(assembly: Assembly, result: AxisResult, free: str) -> str:
    """The same where free motions, in words, are held: the shaft's first node and the housings that they name may take a
    share of the largest force."""
    if not all(np.isfinite(s.loads).all() and (s.loads >= 0.0).all() for s in result.sets):
        return "loads are not finite, or negative"
    size, z, q = size_of(assembly, result), result.centreline_z, result.centreline
    internal, noise = beam(assembly, z, q)
    rest, slack = -internal, TOUCH
    places = {h.name: h.at for h in assembly.housings}
    bodies = {h.name: np.concatenate([h.force, h.moment]) for h in assembly.housings}
    for x in assembly.loads:
        k = int(np.abs(z - x.at).argmin())
        rest[k] += wrench(along(x.at - z[k]), np.array(x.force), np.array(x.moment))
    for s in result.sets:
        at, push = [along(s.of.position)[None]] * 2, [s.force[None], -s.force[None]]
        couple, station = wrench(np.zeros(3), np.zeros(3), s.moment), np.array([s.of.position])
        if s.balls is not None and isinstance(s.of.parts, Scene):
            fault, felt = _law(assembly, result, s)
            if fault:
                return fault
            slack, couple = slack + felt, np.zeros(6)
            force = check.forces(s.of.parts, s.balls)
            at, push = ([x[:, h].reshape(-1, 3) for h in (slice(2), slice(2, 4))] for x in (s.balls.contact_point, force))
            station = contact_force_positions(s.of.parts, ball_layout(s.of.parts)).ravel()
        for end, name in enumerate((s.of.carrier, s.of.housing)):
            if name is not None:
                bodies[name] += wrench(at[end] - along(places[name]), push[end]).sum(axis=0)
                bodies[name] += (1.0 - 2.0 * end) * couple
        if s.of.carrier is None:
            k = np.abs(z[None, :] - station[:, None]).argmin(axis=1)
            from_node = at[0].copy()
            from_node[:, 2] -= z[k]
            np.add.at(rest, k, wrench(from_node, push[0]))
            rest[k[0]] += couple
    arms = np.repeat([1.0, pitch_of(assembly)], 3)
    for support in assembly.supports:
        rest[int(np.abs(z - support.at).argmin()), [check.FREEDOM[name] for name, _ in support.fixed]] = 0.0
    left = (np.abs(rest) - noise) / arms
    pinned = {name: check.PIN * size * (f" {name} in " in free) for name in ("the shaft", *bodies)}
    left[0] -= pinned["the shaft"]
    if float(left.max()) > CLOSE * size + slack:
        return f"the shaft is out of balance by {left.max():.3g} N at {1e3 * z[int(left.max(axis=1).argmax())]:.5g} mm"
    springs = _springs_on_housings(assembly, result, bodies)
    for h in assembly.housings:
        unheld = np.array([f not in dict(h.fixed) for f in check.FREEDOM])
        out = check.largest((bodies[h.name] / arms)[unheld])
        if out > CLOSE * size + slack + pinned[h.name] + springs[h.name] / float(arms.min()):
            return f"{h.name} is out of balance by {out:.3g} N"
    return ""


def _springs_on_housings(assembly: Assembly, result: AxisResult, rest: dict[str, Array]) -> dict[str, float]:
    """Add the wrenches of springs and joints to those on the housings; their round-off of each."""
    motion = {h.name: np.zeros(6) for h in assembly.housings} | {h.name: h.motion for h in result.housings}
    at, noise = {h.name: h.at for h in assembly.housings}, dict.fromkeys(rest, 0.0)

    def spring(K: Array, name: str, station: float, moved: Array) -> None:
        pull = -K @ moved
        rest[name] += wrench(along(station - at[name]), pull[:3], pull[3:])
        noise[name] += STIFF * check.largest(np.abs(K) @ np.abs(moved))

    def there(name: str, station: float) -> Array:
        return np.concatenate([carried(along(station - at[name]), motion[name]), motion[name][3:]])

    for h in assembly.housings:
        if h.stiffness is not None:
            spring(np.array(h.stiffness), h.name, h.at, motion[h.name])
    for j in assembly.joints:
        apart = there(j.first, j.at) - there(j.second, j.at)
        spring(np.array(j.stiffness), j.first, j.at, apart)
        spring(np.array(j.stiffness), j.second, j.at, -apart)
    return noise


def _law(assembly: Assembly, result: AxisResult, s: SetResult) -> tuple[str, float]:
    """Which ball is out of balance, or which contact has another load than Hertz' law gives it; and the round-off [N] of
    all contacts of the set."""
    scene, found = s.of.parts, s.balls
    layout = ball_layout(scene)
    drawn, (centre, axes) = draw_geometry_with_errors(scene, layout, result.member), check.frames(scene)
    stations = contact_force_positions(scene, layout)
    z, moved = result.centreline_z, np.zeros((*found.load.shape, 3))
    bodies, at = {h.name: h.motion for h in result.housings}, {h.name: h.at for h in assembly.housings}
    for side in range(4):
        point = centre + np.einsum("na,nak->nk", drawn.groove_centres[:, side], axes)
        name = s.of.carrier if side < 2 else s.of.housing
        if name is not None:
            moved[:, side] = carried(point - along(at[name]), bodies.get(name, np.zeros(6)))
        elif side < 2:
            k = np.abs(z[None, :] - stations[:, side, None]).argmin(axis=1)
            point[:, 2] -= z[k]
            moved[:, side] = carried(point, result.centreline[k])
    moved[:, 2:] += along(s.of.offset)
    law = check.by_law(scene, found, drawn, moved)
    law[:, [k for k in range(4) if k not in SIDES_OF[s.of.thrust]]] = 0.0
    digits = check.DIGITS * (check.largest(moved) + drawn.groove_radii)
    none, noise = check.nothing(found), digits * check.stiffness_by_law(law, found)
    net = np.linalg.norm(check.forces(scene, found).sum(axis=1), axis=1)
    size, worst = size_of(assembly, result), int(net.argmax())
    if net[worst] > max(check.EXACT * size, none) + float(noise[worst].sum()):
        return f"ball {worst + 1} of {s.of.name} is not in balance", 0.0
    fault = check.farthest_off(law, found.load, np.maximum(CLOSE * size, noise) + none, f" of {s.of.name}")
    return fault, float(noise.sum()) + none


def crossed(assembly: Assembly, result: AxisResult) -> bool:
    """Whether a row that carries thrust one way has a loaded ball across the bottom of its groove, or on it: with less
    thrust than is out of balance, whose sign says nothing."""
    none = CLOSE * size_of(assembly, result)
    rows = [s.balls for s in result.sets if s.balls is not None and s.of.thrust in ("+z", "-z")]
    return any(bool(((b.load * np.sin(b.contact_angle) <= none) & (b.load > none)).any()) for b in rows)


def as_mounted(assembly: Assembly) -> Assembly:
    """The assembly at mounting, without loads and heat: outer parts with a preload are pushed by it and slide along the
    axis, against the frame, or against a housing that moves, which is pushed back; ``TIE`` holds all else between the two.

    The energy is convex in the slides too, so that the preloads have no other equilibrium.
    """
    bodies = {h.name: replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in assembly.housings}
    sets, joints, slides = [], list(assembly.joints), tuple((f, 0.0) for f in FREEDOMS if f != "uz")
    for s in assembly.sets:
        if not s.preload:
            sets.append(s)
            continue
        name, push = f"outer part of {s.name}", push_of(s)
        on = None if s.housing is None or bodies[s.housing].is_fixed else bodies[s.housing]
        if on is not None:
            bodies[on.name] = replace(on, force=(0.0, 0.0, on.force[2] - push))
            joints.append(Joint(name, on.name, s.position, TIE))
        bodies[name] = Housing(name, s.position, () if on else slides, None, (0.0, 0.0, push))
        sets.append(replace(s, housing=name, preload=0.0))
    bare = replace(assembly, loads=(), thermal_strain=0.0)
    return replace(bare, sets=tuple(sets), housings=tuple(bodies.values()), joints=tuple(joints))


def proven(assembly: Assembly, mounting: bool) -> bool:
    """Whether a rigid motion of shaft and housings that no support, spring or contact resists lets the loads do work; at
    mounting: the preloads, on outer parts that slide along the axis."""
    names, pitch = [None, *(h.name for h in assembly.housings)], pitch_of(assembly)
    start = {name: 6 * i for i, name in enumerate(names)}  # the shaft's motion, then that of each housing
    place = {None: 0.0} | {h.name: h.at for h in assembly.housings}
    slide = {s.name: 6 * len(names) + i for i, s in enumerate(assembly.sets)}
    rigid = first = 6 * len(names) + len(slide)
    wide = rigid + 2 * sum(s.parts.ball_count for s in assembly.sets if isinstance(s.parts, Scene))

    def of_body(name: str | None, way: Array) -> Array:
        """A row that takes the motion of a body along a wrench about its place."""
        row = np.zeros(wide)
        row[start[name] : start[name] + 6] = way / np.repeat([1.0, pitch], 3)
        return row

    def in_freedom(name: str | None, freedom: str, station: float) -> Array:
        return of_body(name, check.motion_in_freedom(freedom, station - place[name]))

    def approach(s: RollingSet, at: Array, direction: Array, inner: bool) -> Array:
        name = s.carrier if inner else s.housing
        row = np.zeros(wide) if name is None and not inner else -of_body(name, wrench(at - along(place[name]), direction))
        if not inner:
            row[slide[s.name]] -= direction[2]
        return row

    slides, rows = np.eye(wide)[rigid - len(slide) : rigid], []
    preloads = sum((slides[i] * push_of(s) for i, s in enumerate(assembly.sets)), np.zeros(wide))
    loads = [of_body(None, wrench(along(x.at), np.array(x.force), np.array(x.moment))) for x in assembly.loads]
    loads += [of_body(h.name, np.concatenate([h.force, h.moment])) for h in assembly.housings]
    work = preloads if mounting else np.sum([np.zeros(wide), *loads], axis=0)
    held = [slides[i] for i, s in enumerate(assembly.sets) if not (mounting and s.preload)]
    held += [in_freedom(None, name, support.at) for support in assembly.supports for name, _ in support.fixed]
    for h in assembly.housings:
        sprung = [] if h.stiffness is None else [f for f, k in zip(FREEDOMS, np.diag(h.stiffness), strict=True) if k]
        held += [in_freedom(h.name, f, h.at) for f in [*dict(h.fixed), *sprung]]
    held += [in_freedom(j.first, f, j.at) - in_freedom(j.second, f, j.at) for j in assembly.joints for f in FREEDOMS]
    for s in assembly.sets:
        if isinstance(s.parts, RollerRow):
            rows += _rollers(s, s.parts, approach)
            continue
        (centre, axes), beta = check.frames(s.parts), s.parts.track.contact_angle
        ways = check.WAYS * np.array([np.cos(beta), np.sin(beta)])
        for (i, at), side in product(enumerate(centre), SIDES_OF[s.thrust]):
            row = approach(s, at, ways[side] @ axes[i], side < 2)
            row[first + 2 * i : first + 2 * i + 2] += ways[side]
            rows.append(row)
        first += 2 * s.parts.ball_count
    size = check.largest(work)
    if size == 0.0:
        return False
    bounds = [(-1.0, 1.0)] * rigid + [(None, None)] * (wide - rigid)
    equal = np.array(held).reshape(-1, wide)
    found = linprog(-work / size, np.array(rows), np.zeros(len(rows)), equal, np.zeros(len(equal)), bounds)
    return found.status == 0 and bool(found.fun < -PROVEN)


def push_of(s: RollingSet) -> float:
    """Force [N] along the axis on an outer part by its preload."""
    return -s.preload if s.thrust == "+z" else s.preload


def _rollers(s: RollingSet, row: RollerRow, approach: Callable[[RollingSet, Array, Array, bool], Array]) -> list[Array]:
    """Approach of cone and cup at both ends of every roller."""
    young, poisson = row.material.youngs_modulus, row.material.poissons_ratio
    shape = TaperedBearing(row.count, row.diameter, row.length, row.cup_angle, row.roller_angle, young, poisson, row.depth)
    sin, cos, way = np.sin(row.cup_angle), np.cos(row.cup_angle), 1.0 if s.thrust == "+z" else -1.0
    out = []
    for a in row.phase + 2.0 * np.pi * np.arange(row.count) / row.count:
        outward = np.array([np.cos(a), np.sin(a), 0.0])
        normal, generator = cos * outward + along(way * sin), sin * outward - along(way * cos)
        for end in 0.5 * row.length * (1.0 - 1.0 / row.slices) * np.array([-1.0, 1.0]):
            at = shape.apex_distance * sin * outward + end * generator + along(s.position)
            out.append(approach(s, at, normal, False) - approach(s, at, normal, True))
    return out
