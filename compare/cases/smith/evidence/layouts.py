"""Smith's axis in its layouts, each as a scene over the nut's position, beside closed formulas and the sum in series."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from rollbench.compare.cases.smith.evidence import case
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.bearings import as_printed
from rollbench.lowfi.bearings.angular_contact import BallRow
from rollbench.lowfi.bearings.axis import shaft_stiffness
from rollbench.lowfi.bearings.sets import BearingSet, arrangement, equilibrium
from rollbench.meshes.axis import Assembly
from rollbench.meshes.roots import brentq

#: Station of the left end's middle [m], and positions of the nut over the length between the ends.
FIRST, PLACES = 2.0 * case.INCH, (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class Layout:
    """A layout: shipped scene, words, kind of bearing, directions of the rows by end (none: free to slide)."""

    scene: str
    words: str
    kind: str
    left: tuple[int, ...]
    right: tuple[int, ...]

    def rows(self, end: str) -> BearingSet:
        """Rows of an end by their laws."""
        directions = self.left if end == "left" else self.right
        if directions == case.DIRECTIONS[self.kind][end]:
            return case.bearing_set(self.kind, end)
        return arrangement(BallRow(case.ball_bearing()), directions, 0.0)


TRIPLEX = Layout("smith-axis", "triplex, fixed-fixed", "ball", *case.DIRECTIONS["ball"].values())
SUPPORTED = Layout("smith-axis-supported", "triplex, fixed-supported", "ball", case.DIRECTIONS["ball"]["left"], ())
TANDEM = Layout("smith-axis-tandem", "tandem pairs, fixed-fixed", "ball", (1, 1), (1, 1))
TAPERED = Layout("smith-axis-taper", "two-row tapered, fixed-fixed", "taper", *case.DIRECTIONS["taper"].values())
LAYOUTS = TRIPLEX, SUPPORTED, TANDEM, TAPERED


@dataclass(frozen=True)
class Ends:
    """Thrust of the shaft's tension on both ends [N], and stiffness of shaft and supports at the nut [N/m]."""

    left: float
    right: float
    stiffness: float


@cache
def by_formulas(layout: Layout, place: float, applied: float = case.APPLIED) -> Ends:
    """Rows by their laws, all of an end at one place, and a bar: the stretch is that of the ends, preload included.

    place: of the nut over the length; applied: force [N] on the screw there, towards the left end.
    """
    a, first = case.axis(), layout.rows("left")
    bars = np.array([place, 1.0 - place]) * a.length / (a.young * a.area)
    if not layout.right:
        k = equilibrium(first, -applied).stiffness
        return Ends(-applied, 0.0, 1.0 / (1.0 / k + float(bars[0])))
    second = layout.rows("right")

    def gap(left: float) -> float:
        forces = left, left + applied
        moved = sum(equilibrium(rows, f).displacement for rows, f in zip((first, second), forces, strict=True))
        return moved + float(bars @ forces) - case.STRETCH

    low = 1e-3 if min(layout.left) > 0 else -2e4  # tandem rows carry tension only
    left = float(brentq(gap, low, 4e4, xtol=1e-6))
    ends = [equilibrium(rows, f).stiffness for rows, f in ((first, left), (second, left + applied))]
    return Ends(left, left + applied, sum(1.0 / (1.0 / k + float(b)) for k, b in zip(ends, bars, strict=True)))


def by_scene(study: Study, layout: Layout, place: float) -> Ends:
    """The same by the scene: beam, contacts, rows apart from one another."""
    return study.once(_by_scene, layout, place)


def _by_scene(study: Study, layout: Layout, place: float) -> Ends:  # noqa: ARG001 - kept by the study
    found = catalogue.shipped(layout.scene)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{layout.scene} is an axis")
    at = FIRST + place * case.axis().length
    loads = tuple(replace(x, at=at, force=(0.0, 0.0, -case.APPLIED)) for x in found.loads)
    result = run_model(replace(found, loads=loads, stiffness_at=at), "lin", Options(engine="compiled"))
    if not result.converged or result.stiffness is None:
        raise AssertionError(f"{layout.scene}: {result.status}")
    thrust = {end: sum(float(s.force[2]) for s in result.sets if s.of.name.startswith(end)) for end in ("left", "right")}
    return Ends(-thrust["left"], thrust["right"], float(result.stiffness[2, 2]))


def in_series(layout: Layout) -> float:
    """The source's sum (4.6) of both ends and the whole screw between rigid walls, without the nut [N/m].

    nan for a fixed-supported screw, for which it has none.
    """
    if not layout.right:
        return float("nan")
    a, force = case.axis(), by_formulas(layout, 0.5, 0.0).left
    ends = [equilibrium(layout.rows(end), force).stiffness for end in ("left", "right")]
    return as_printed.series_stiffness(ends, float(shaft_stiffness(a, 0.5 * a.length)), float("inf"))


def words(study: Study, layout: Layout) -> str:
    """A layout with the load in the middle by scene and by formulas in one sentence, in the source's units."""
    scene, closed = by_scene(study, layout, 0.5), by_formulas(layout, 0.5)
    ends = [f"{x.left / case.POUND:.0f} and {x.right / case.POUND:.0f} lbf" for x in (scene, closed)]
    stiff = [f"{x.stiffness / case.POUND_PER_INCH / 1e6:.3f}e6 lbf/in" for x in (scene, closed)]
    return f"as a scene the ends carry {ends[0]} ({stiff[0]} without the nut), by formulas {ends[1]} ({stiff[1]})"


def every_place(study: Study) -> Iterator[tuple[Layout, float, Ends, Ends]]:
    """Each layout at each place: by the scene, by formulas."""
    for layout in LAYOUTS:
        for place in PLACES:
            yield layout, place, by_scene(study, layout, place), by_formulas(layout, place)
