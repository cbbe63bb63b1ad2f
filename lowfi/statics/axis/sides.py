"""Which flanks of an assembly's balls are worth building: those that load and preload close. And the test that they do.

A flank that is left out needs no node of the shaft and no rows of the matrix. The energy is convex: where every ball clears
the flanks left out at the solution without them, that is the solution with them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollbench.lowfi.hertz import contact_approach, contact_force
from rollbench.lowfi.statics.axis.system import USE, BallSet, Placed, System, motions_of, moved_flanks
from rollbench.lowfi.statics.kernel_types import RowState
from rollbench.lowfi.statics.problem import distances, nominal_hertz
from rollbench.lowfi.statics.selection import all_clear, motions_in_section
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.axis import Assembly, RollingSet
from rollbench.meshes.errors import Specimen
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.section import contact_stations


def likely_sides(assembly: Assembly, places: Sequence[Placed]) -> list[Mask]:
    """Sides (4,) of each set of balls that thrust, load and offsets leave it: a guess, to be tested by ``clear``."""
    sets = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    if len(sets) < len(assembly.sets) or any(s.carrier is not None for s, _ in sets):
        return all_sides(assembly)
    along = axial_place(assembly, sets)
    return [_of_set(s, scene, along - s.offset, drawn) for (s, scene), (_, drawn) in zip(sets, places, strict=True)]


def axial_place(assembly: Assembly, sets: Sequence[tuple[RollingSet, Scene]]) -> float:
    """Where along z the shaft goes [m], all else rigid: where it is held, or where the sets' forces balance its load."""
    held = [value for s in assembly.supports for name, value in s.fixed if name == "uz"]
    force = sum(x.force[2] for x in assembly.loads)
    if held:
        return float(held[0])
    sin = np.array([np.sin(scene.track.contact_angle) for _, scene in sets])
    C = np.array([nominal_hertz(scene).C for _, scene in sets])
    share, pair = sin * [scene.ball_count for _, scene in sets], C[:, 0] + C[:, 3]
    offset = np.array([s.offset for s, _ in sets])

    def excess(u: float) -> float:
        return float(np.sum(np.sign(u - offset) * share * contact_force(abs(u - offset) * sin, pair))) - force

    reach = 1e-9 + float((contact_approach(abs(force) / share, pair) / sin).max())
    return float(brentq(excess, offset.min() - reach, offset.max() + reach, xtol=1e-9))


def _of_set(rolling: RollingSet, scene: Scene, shift: float, drawn: Specimen) -> Mask:
    """A shaft that moves by ``shift`` > 0 along z in its nut closes SL-NR and opens SR-NL, by the contact angle's sine."""
    use = USE[rolling.thrust]
    if rolling.thrust != "both" or drawn.profile.shape[1]:
        return use
    closed = distances(scene, drawn)[1] + shift * np.sin(scene.track.contact_angle) * np.array([1.0, -1.0])
    if closed[:, 0].max() > 0.0 >= closed[:, 1].max():
        return USE["+z"]
    return USE["-z"] if closed[:, 1].max() > 0.0 >= closed[:, 0].max() else use


def clear(system: System, state: RowState) -> bool:
    """Whether all balls clear the flanks that a set could use and that were left out, at a solution without them."""
    return all(_set_clear(system, b, state) for b in system.balls if np.any(USE[b.of.thrust] & ~b.problem.use))


def _set_clear(system: System, b: BallSet, state: RowState) -> bool:
    contact = state.contact[b.balls]
    shift = moved_flanks(b, state.q)
    for s in range(2):
        if not b.problem.use[s] and b.of.carrier is None:
            shift[:, s] = _flank_motion(system, b, s, state.q)
    place, load = state.p[None, b.balls], contact[None, ..., 0]
    return bool(all_clear(place, shift[None], b.problem.geometry[None], load, b.problem.use)[0])


def _flank_motion(system: System, b: BallSet, s: int, q: Array) -> Array:
    """Motion (N, 2) [m] of a screw flank that has no node: the beam's at its station."""
    stations = contact_stations(b.problem.scene, b.problem.layout)[:, s]
    j, m = motions_of(system.structure, stations)
    moved = np.einsum("nab,nb->na", m, np.concatenate([q[j], q[j + 1]], axis=1))
    return motions_in_section(b.problem.layout, b.problem.drawn.centre[:, s], stations, moved)


def left_out(system: System) -> tuple[str, ...]:
    """Sentences on the sides that were left out though their sets could use them."""
    notes = []
    for b in system.balls:
        idle = [SIDES[k] for k in np.flatnonzero(USE[b.of.thrust] & ~b.problem.use)]
        if idle:
            notes.append(f"{b.of.name}: sides {' and '.join(idle)}: load or offset opens them, and every ball clears them")
    return tuple(notes)


def all_sides(assembly: Assembly) -> list[Mask]:
    """All sides (4,) that each set of balls can use."""
    return [USE[s.thrust] for s in assembly.sets if isinstance(s.parts, Scene)]


def complete(uses: Sequence[Mask], assembly: Assembly) -> bool:
    """Whether nothing that the sets can use is left out."""
    return all(np.array_equal(a, b) for a, b in zip(uses, all_sides(assembly), strict=True))
