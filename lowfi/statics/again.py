"""One scene solved for many places of its balls: contact loads alone, by the same equations as a single solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, whole_body
from rollbench.lowfi.compliance.imported import Condensed
from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics import elastic, static
from rollbench.lowfi.statics.elastic_system import Elastic, Rebuild, one_thread
from rollbench.lowfi.statics.problem import Problem, distances
from rollbench.lowfi.statics.selection import all_sides, choose_sides
from rollbench.lowfi.statics.settle import contact_angles, verdict
from rollbench.lowfi.statics.static import Engine, Unheld, pick_engine, round_off_bound, unheld
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import BallLayout, layout_at, reduced_lead
from rollbench.meshes.parts import Scene, Track

#: Length of a window of `Travelling` and the least one [rad], how far beyond it balls may be as a part of it, and how far
#: they may move against each other [rad].
WINDOW, LEAST, BEYOND, APART = np.radians(8.0), 1e-4, 0.01, 5e-4


@dataclass(frozen=True)
class ContactLoads:
    """Contact forces (N, 4) [N], contact angles (N, 4) [rad], nan without contact, Hertz constants (N, 4), and status."""

    load: Array
    contact_angle: Array
    hertz_C: Array
    status: str

    @property
    def converged(self) -> bool:
        """Whether forces are in balance."""
        return self.status == "converged"


def beam_loads(scene: Scene, drawn: Specimen, layout: BallLayout, engine: Engine = "auto") -> ContactLoads:
    """Contact loads of balls with errors ``drawn`` at places ``layout``: ``solve_static``."""
    known = distances(scene, drawn)
    use = choose_sides(scene, drawn, known)
    solved = static.solve_sides(scene, drawn, layout, pick_engine(engine, layout.z.size), use, known=known)
    if isinstance(solved, Unheld):
        return _none(solved.problem.C, solved.status)
    prepared, outcome = solved.prepared, solved.outcome
    status = verdict(outcome, round_off_bound(prepared, outcome.scale), partial(unheld, prepared.problem))
    return _loads(prepared.force, prepared.normal, prepared.problem.C, status)


def elastic_loads(
    scene: Scene,
    drawn: Specimen,
    layout: BallLayout,
    engine: Engine = "auto",
    backend: Backend = REFINED,
    whole: WholeBody = whole_body,
) -> ContactLoads:
    """The same with elastic bodies, ``solve_elastic``; whole: see `body_compliance`."""
    use = all_sides(scene) if drawn.profile.shape[1] else choose_sides(scene, drawn)
    with one_thread():
        system, status = solved_system(scene, drawn, layout, backend, None, engine, use, whole)
        if isinstance(system, Problem):
            return _none(system.C, status)
        _, contact, _ = elastic.contacts_of(system)
    return _loads(contact[..., 0], contact[..., 1:3], system.problem.C, status)


def solved_system(
    scene: Scene,
    drawn: Specimen,
    layout: BallLayout,
    backend: Backend,
    condensed: Condensed | None,
    engine: Engine,
    use: Mask,
    whole: WholeBody = whole_body,
) -> tuple[Elastic | Problem, str]:
    """Elastic bodies at their solution, with the sides ``use`` (4,) or all four, and its status; the problem alone where
    nothing holds the screw."""
    kernels = pick_engine(engine, layout.z.size)
    solved = elastic.solve_sides(Rebuild(scene, drawn, layout, use, None, backend, condensed, kernels, False, 1, whole))
    if isinstance(solved, Unheld):
        return solved.problem, solved.status
    system, outcome = solved.elastic, solved.outcome
    return system, verdict(outcome, elastic.round_off(system, outcome.scale), partial(unheld, system.problem))


class Window(NamedTuple):
    """Compliance of a body ``(3, 2 c, 2 c)`` [m/N] where its balls are, and half a length [rad] and a length on."""

    azimuth: Array
    z: Array
    length: float
    G: tuple[Array, Array, Array]


@dataclass
class Travelling:
    """Compliance of bodies between contacts that travel round the track together, in place of `whole_body`: computed at
    three places of a window, between them by the parabola through these.

    ahead: length of a window [rad], signed as the balls travel in the nut. A body of revolution with a groove in it answers
    balls that turn and advance together alike, but for its ends: the compliance changes slowly. Where balls move by more
    than ``APART`` against each other, or others are on the loaded arc, a new window begins. Kept for one scene and backend.
    """

    ahead: float
    windows: dict[tuple[object, ...], list[Window]] = field(default_factory=dict)

    def __call__(self, scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int]) -> Array:
        """As `whole_body`."""
        track, rate = scene.track, reduced_lead(scene.track)
        known = self.windows.setdefault((screw, tuple(flanks), layout.z.size), [])
        for window in known:
            moved = layout.azimuth - window.azimuth
            part = float(np.mean(moved if rate == 0.0 else (layout.z - window.z) / rate)) / window.length
            apart = np.abs(moved - moved.mean()).max()
            if apart <= APART and -BEYOND <= part <= 1.0 + BEYOND:
                break
        else:
            part, window = 0.0, self.begin(layout, track, lambda place: whole_body(scene, place, screw, backend, flanks))
            known.append(window)
        first, second, third = window.G
        left = 1.0 - part
        return np.asarray(left * (left - part) * first + 4.0 * part * left * second + part * (part - left) * third)

    def begin(self, layout: BallLayout, track: Track, compute: Callable[[BallLayout], Array]) -> Window:
        """A window from ``layout`` on, shorter where a ball would pass the nut's face. Raises as `whole_body`."""
        rate, length = reduced_lead(track), self.ahead
        while True:
            places = (layout_at(track, layout.azimuth + s, layout.z + s * rate) for s in (length, 0.5 * length, 0.0))
            try:
                third, second, first = map(compute, places)
            except ValueError:
                if abs(length) < LEAST:
                    raise
                length /= 8.0
                continue
            return Window(layout.azimuth, layout.z, length, (first, second, third))


def in_motion(model: str, ahead: float) -> Callable[..., ContactLoads]:
    """How a model finds the loads of balls that travel; ahead: 1.0 or -1.0, as they do in the nut."""
    if model != "refined":
        return AGAIN[model]
    return partial(elastic_loads, whole=Travelling(WINDOW * ahead))


#: How the models of a static run find loads again and again, by name.
AGAIN: dict[str, Callable[..., ContactLoads]] = {"lin": beam_loads, "refined": elastic_loads}


def _loads(force: Array, normal: Array, C: Array, status: str) -> ContactLoads:
    angle = np.where(force > 0.0, contact_angles(normal), np.nan)
    return ContactLoads(force.copy(), angle, C.copy(), status)


def _none(C: Array, status: str) -> ContactLoads:
    nan: Any = np.full(C.shape, np.nan)
    return ContactLoads(nan, nan, C.copy(), status)
