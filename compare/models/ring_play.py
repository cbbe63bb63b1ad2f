"""Clearance of deep-groove bearings: what a scene's rows rest at, and rings that a held shaft keeps at one end of it."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, sin

from rollbench.lowfi.warned import Warned
from rollbench.meshes.axis import Assembly, RollingSet
from rollbench.meshes.one_arc import Clearance, clearance_of, distance_of_centres
from rollbench.meshes.parts import Scene, Support

#: Part of the way from the middle of the play to its end from which on a ring is called to be at the end.
AT_END = 0.9


def clearance_in(parts: Scene, thrust: str = "deep groove") -> Clearance | None:
    """Clearance of a row that carries thrust both ways by one arc; None of other rows, and where there is no play."""
    found = clearance_of(parts) if thrust == "deep groove" else None
    return found if found is not None and found.axial > 0.0 else None


def play_warnings(scene: Scene | Assembly) -> Iterator[Warned]:
    """A note on each deep-groove row between whose rings the axial place is held, at one end of its play."""
    shaft = _held(scene.supports)
    if shaft is None:
        return
    if isinstance(scene, Scene):
        yield from _of_row(scene, shaft)
        return
    for row in scene.sets:
        outer = _outer(scene, row)
        if isinstance(row.parts, Scene) and row.carrier is None and row.thrust == "deep groove" and outer is not None:
            yield from (w.of(row.name) for w in _of_row(row.parts, shaft - outer))


def _of_row(parts: Scene, place: float) -> Iterator[Warned]:
    """The note on a row whose inner ring is held at a place [m] against its outer one."""
    clearance = clearance_in(parts)
    if clearance is None:
        return
    middle = -distance_of_centres(parts) * sin(parts.track.contact_angle)
    if abs(place - middle) < AT_END * 0.5 * clearance.axial:
        return
    yield Warned(
        "play",
        f"the held uz keeps a ring at one end of its axial play of {1e6 * clearance.axial:.4g} um, where balls touch "
        f"at {degrees(clearance.angle):.3g} deg at rest, so that it moves less across than its clearance lets it; free "
        f"uz, or hold it {1e6 * (middle - place):+.4g} um from there, in the middle of the play",
    )


def _held(supports: tuple[Support, ...]) -> float | None:
    """Axial displacement [m] at which supports hold the shaft; None where it is free."""
    return next((value for s in supports for name, value in s.fixed if name == "uz"), None)


def _outer(assembly: Assembly, row: RollingSet) -> float | None:
    """Axial place [m] of a row's outer part; None where its housing moves."""
    if row.housing is None:
        return row.offset
    housing = next(h for h in assembly.housings if h.name == row.housing)
    return next((row.offset + value for name, value in housing.fixed if name == "uz"), None)
