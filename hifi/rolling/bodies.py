"""Kernels of finite bodies (`hifi.rolling.regular`) from finite elements: ball and groove.

On rings and helices both are patches of the static reference in pieces of their bodies (`hifi.rolling.static_patches`); on
straight tracks, which it has none of, a whole ball and a grooved bar (`hifi.rolling.contact_bodies`). A body's answers to
smooth tractions on its contact zone, in all three directions, less those of a half space whose zone has the same nodes
(`hifi.rolling.answers`): what the grid does to the singular part is in both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache, partial, wraps
from time import process_time
from typing import Any, ParamSpec, TypeVar

import numpy as np

from rollbench.hifi.bodies.submodel import piece_compliance
from rollbench.hifi.condensation.side_by_side import Job, make
from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.rolling.answers import Frame, beside, free_answer, held_answer, tractions
from rollbench.hifi.rolling.contact_bodies import ContactBody, Groove, Zone, grooved_bar, whole_ball
from rollbench.hifi.rolling.regular import Regular
from rollbench.hifi.rolling.static_patches import Curve, cuts_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import Cache
from rollbench.meshes.fields import keyed, usual


@keyed
@dataclass(frozen=True)
class Sizes:
    """Numerical choices: cells of the contact zone along and across, ratio of cells beyond it, zone over the contact's
    semi-axes, degree of the kernel; of bars: size over the ball's radius, half of the grooves' opening [rad]; whether rings
    and helices are patches of the static reference, or bent bars too."""

    cells: tuple[int, int] = usual((4, 4))
    growth: float = usual(2.5)
    margin: float = usual(1.1)
    degree: int = usual(4)
    bar: float = usual(5.0)
    opening: float = usual(1.4)
    patches: bool = usual(True)


P = ParamSpec("P")
T = TypeVar("T")
#: What bodies answered, by function and arguments, made here or by other processes; most that are kept.
_KEPT: dict[tuple[object, ...], Any] = {}
MOST = 32


def kept(make: Callable[P, T]) -> Callable[P, T]:
    """Make the same but once; arguments are hashed."""

    @wraps(make)
    def cached(*arguments: P.args, **named: P.kwargs) -> T:
        key = _key(partial(make, *arguments, **named))
        if key not in _KEPT:
            _keep(key, make(*arguments, **named))
        value: T = _KEPT[key]
        return value

    return cached


def _key(call: partial[Any]) -> tuple[object, ...]:
    return call.func.__name__, call.args, *call.keywords.items()


def _keep(key: tuple[object, ...], value: Any) -> None:
    _KEPT[key] = value
    while len(_KEPT) > MOST:
        del _KEPT[next(iter(_KEPT))]


@kept
def ball_kernel(
    radius: float, zone: Zone, bends: tuple[float, float], young: float, poisson: float, degree: int
) -> Regular:
    """What a whole ball of ``radius`` [m] adds to a half space."""
    body = whole_ball(radius, zone)
    answer = free_answer(body, tractions(body, zone, degree, bends), young, poisson)
    return Regular(answer - beside(body, zone, radius, young, poisson, degree), zone.half, degree)


@kept
def bar_kernel(
    groove: Groove, size: float, zone: Zone, bends: tuple[float, float], young: float, poisson: float, degree: int
) -> Regular:
    """What a grooved bar of ``size`` [m] adds to a half space, as it counts in the motion of a ball past it."""
    body = grooved_bar(groove, size, zone)
    answer = held_answer(body, tractions(body, zone, degree, bends), young, poisson)
    return of_groove(answer - beside(body, zone, groove.ball, young, poisson, degree), zone, degree)


@kept
def patch_kernels(
    curve: Curve,
    radii: tuple[float, float],
    angle: float,
    zone: Zone,
    bends: tuple[float, float],
    young: float,
    poisson: float,
    degree: int,
    *,
    outer: bool,
) -> tuple[Regular, Regular]:
    """What the static reference's patches of groove and ball (radii [m]: ball, groove) add to a half space, each."""
    kernels = []
    for cut, sense in zip(cuts_of(curve, *radii, angle, zone, outer=outer), (1, -1), strict=True):
        body = ContactBody(cut.patch.mesh, cut.patch.contact, sense, cut.number)
        frame = Frame(cut.centre, cut.axes)
        matrix = piece_compliance(cut.piece, cut.patch, tractions(body, zone, degree, bends, frame), young, poisson)
        kernels.append(matrix - beside(body, zone, radii[0], young, poisson, degree, frame, cut.cells))
    return of_groove(kernels[0], zone, degree), Regular(kernels[1], zone.half, degree)


def of_groove(added: Array, zone: Zone, degree: int) -> Regular:
    """Kernel of a groove's own answers ``(3 k, 3 k)`` [m/N]: forces on it and its motion count the other way along
    tangents."""
    signs = np.repeat([-1.0, -1.0, 1.0], len(added) // 3)
    return Regular(added * np.outer(signs, signs), zone.half, degree)


#: Zones are made for loads of whole powers of two, and grooves for whole tenths of a radian, so that like contacts share
#: their kernel.
STEP = 0.1


@dataclass(frozen=True)
class Place:
    """Where a ball touches a groove: the ball's radius [m], relative radii along and across the groove [m], angle from the
    groove's bottom [rad], radius and rise of the path (None: straight, see `hifi.rolling.kinematics.Track.curve`)."""

    ball: float
    radii: tuple[float, float]
    angle: float
    curve: tuple[float, float] | None

    @property
    def arc(self) -> float:
        """Radius of the groove [m]."""
        return 1.0 / (1.0 / self.ball - 1.0 / self.radii[1])

    @property
    def bend(self) -> float:
        """Curvature of the groove along the track [1/m], positive: concave."""
        return 1.0 / self.ball - 1.0 / self.radii[0]

    @property
    def bends(self) -> tuple[float, float]:
        """Curvatures of the surface that ball and groove share [1/m]."""
        one, two = (1.0 / self.ball - 0.5 / r for r in self.radii)
        return one, two

    def zone(self, load: float, young: float, poisson: float, sizes: Sizes) -> Zone:
        """Contact zone under a load [N]."""
        ellipse = hertz(load, *self.radii, young, poisson)
        return Zone((sizes.margin * ellipse.semi_x, sizes.margin * ellipse.semi_y), sizes.cells, sizes.growth)


def _parts(at: Place, load: float, young: float, poisson: float, sizes: Sizes) -> list[partial[Any]]:
    """Calls for the kernels whose sum is a contact's: ball and bar, or both patches at once."""
    zone, common = at.zone(load, young, poisson, sizes), (at.bends, young, poisson, sizes.degree)
    if sizes.patches and at.curve is not None:
        curve, radii = Curve(*at.curve), (at.ball, at.arc)
        return [partial(patch_kernels, curve, radii, at.angle, zone, *common, outer=at.bend > 0.0)]
    groove = Groove(at.ball, at.arc, at.angle, sizes.opening, at.bend)
    return [partial(ball_kernel, at.ball, zone, *common), partial(bar_kernel, groove, sizes.bar * at.ball, zone, *common)]


@lru_cache(maxsize=8)
def _kernel(at: Place, load: float, young: float, poisson: float, sizes: Sizes) -> Regular:
    kernels = [call() for call in _parts(at, load, young, poisson, sizes)]
    first, second = kernels if len(kernels) == 2 else kernels[0]
    kernel: Regular = first + second
    return kernel if len(kernels) == 1 else kernel.even


def _shared(at: Place, load: float) -> tuple[Place, float]:
    """Place and load of the kernel that contacts like this one share."""
    return replace(at, angle=STEP * round(at.angle / STEP)), float(2.0 ** np.ceil(np.log2(load)))


def contact_kernel(at: Place, load: float, young: float, poisson: float, sizes: Sizes) -> Regular:
    """What ball and groove add to half spaces; y towards the bottom of the groove, x right-handed with it and the normal.

    load: the largest of the contacts that share it [N]. Other contacts of the ball are not felt. Raises ValueError where
    groove, ring or nut have no room for the zone, the bar or a socket.
    """
    return _kernel(*_shared(at, load), young, poisson, sizes)


def make_kernels(
    contacts: Iterable[tuple[Place, float]], young: float, poisson: float, sizes: Sizes, processes: int
) -> float:
    """Make what the kernels of contacts (places, loads) need in so many processes at once; their processor time [s].

    By one process, or of one part, nothing is made before it is needed. Raises as `contact_kernel`.
    """
    calls = [call for at, load in contacts for call in _parts(*_shared(at, load), young, poisson, sizes)]
    missing = {key: call for call in calls if (key := _key(call)) not in _KEPT}
    if processes == 1 or len(missing) < 2:
        return 0.0
    jobs = [Job("kernels", _anew, (call,), tuple) for call in missing.values()]
    results = make(jobs, Cache(None), processes)
    for key, result in zip(missing, results, strict=True):
        _keep(key, result.value[0])
    return float(sum(result.value[1] for result in results))


def _anew(call: partial[Any]) -> tuple[Any, float]:
    """Result of a call, not kept by the process that makes it, and its processor time [s]."""
    begin = process_time()
    return call.func.__wrapped__(*call.args, **call.keywords), process_time() - begin  # type: ignore[attr-defined]


def forget_kernels() -> None:
    """Let the next contact mesh its bodies again."""
    _kernel.cache_clear()
    _KEPT.clear()
