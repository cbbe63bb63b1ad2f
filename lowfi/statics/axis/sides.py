"""Which flanks of an assembly's balls are worth building: those that its preload closes, and the test that they suffice.

A flank that is left out needs no node of the shaft and no rows of the matrix. The energy is convex: where every ball clears
the flanks left out at the solution without them, that is the solution with them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lowfi.statics.axis.system import USE, BallSet, System
from lowfi.statics.problem import distances
from lowfi.statics.records import AxisState
from lowfi.statics.selection import all_clear, motions_in_section
from lowfi.statics.shape import motion_matrices
from meshes.axis import Assembly, RollingSet
from meshes.errors import specimen
from meshes.helix import ball_layout
from meshes.partition import contact_stations
from meshes.parts import SIDES, Scene
from meshes.section import BeamSection

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def likely_sides(assembly: Assembly, member: int = 0) -> list[Mask]:
    """Sides (4,) of each set of balls, in order, that its thrust and its offset leave: a guess, to be tested by ``clear``."""
    return [_of_set(s, s.parts, member) for s in assembly.sets if isinstance(s.parts, Scene)]


def _of_set(one: RollingSet, scene: Scene, member: int) -> Mask:
    """An outer part moved towards -z closes SL-NR and opens SR-NL, by the sine of the contact angle each."""
    use = USE[one.thrust]
    if one.thrust != "both" or one.offset == 0.0:
        return use
    drawn = specimen(scene, ball_layout(scene), member)
    if drawn.profile.shape[1]:
        return use
    closed = distances(scene, drawn)[1] - one.offset * np.sin(scene.track.contact_angle) * np.array([1.0, -1.0])
    if closed[:, 0].min() > 0.0 >= closed[:, 1].max():
        return USE["+z"]
    return USE["-z"] if closed[:, 1].min() > 0.0 >= closed[:, 0].max() else use


def clear(system: System, state: AxisState) -> bool:
    """Whether all balls clear the flanks that a set could use and that were left out, at a solution without them."""
    return all(_set_clear(system, b, state) for b in system.balls if np.any(USE[b.of.thrust] & ~b.problem.use))


def _set_clear(system: System, b: BallSet, state: AxisState) -> bool:
    contact = state.contact[b.balls]
    shift = np.zeros((len(contact), 4, 2))
    shift[:, 2:] = b.v0[:, 2:]
    if b.outer >= 0:
        shift[:, 2:] += b.B[:, 2:] @ state.q[b.outer]
    for s in range(2):
        shift[:, s] = (
            np.einsum("nak,nk->na", b.B[:, s], state.q[b.problem.node[:, s]])
            if b.problem.use[s] or b.of.carrier is not None
            else _flank_motion(system, b, s, state.q)
        )
    return bool(all_clear(state.p[None, b.balls], shift[None], b.problem.geometry[None], contact[None, ..., 0], b.problem.use)[0])


def _flank_motion(system: System, b: BallSet, s: int, q: Array) -> Array:
    """Motion (N, 2) [m] of a screw flank that has no node: the beam's at its station."""
    nodes, stations = system.structure.nodes, contact_stations(b.problem.scene, b.problem.layout)[:, s]
    element = np.clip(np.searchsorted(nodes, stations, side="right") - 1, 0, nodes.size - 2)
    EA, EI, GJ, kGA = system.axis.sections[element].T
    j, m = motion_matrices(stations, nodes, BeamSection(EA, EI, GJ, kGA))
    moved = np.einsum("nab,nb->na", m, np.concatenate([q[j], q[j + 1]], axis=1))
    return motions_in_section(b.problem.layout, b.problem.drawn.centre[:, s], stations, moved)


def left_out(system: System) -> tuple[str, ...]:
    """Sentences on the sides that were left out though their sets could use them."""
    found = []
    for b in system.balls:
        idle = [name for name, could, used in zip(SIDES, USE[b.of.thrust], b.problem.use, strict=True) if could and not used]
        if idle:
            found.append(f"{b.of.name}: sides {' and '.join(idle)}: its offset opens them, and every ball clears them")
    return tuple(found)


def all_sides(assembly: Assembly) -> list[Mask]:
    """All sides (4,) that each set of balls can use."""
    return [USE[s.thrust] for s in assembly.sets if isinstance(s.parts, Scene)]


def complete(uses: Sequence[Mask], assembly: Assembly) -> bool:
    """Whether nothing that the sets can use is left out."""
    return all(np.array_equal(a, b) for a, b in zip(uses, all_sides(assembly), strict=True))
