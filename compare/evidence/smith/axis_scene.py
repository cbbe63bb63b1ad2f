"""Smith's axis as a scene, beside the closed formulas of its bearings and its shaft."""

from __future__ import annotations

from dataclasses import dataclass, replace

from scipy.optimize import brentq

from compare.evidence.smith.case import APPLIED, POUND, POUND_PER_INCH, STRETCH, axis, bearing_set
from compare.models.axis import run_axis
from compare.models.study import Study
from compare.scenes import catalogue
from lowfi.bearings.sets import equilibrium
from meshes.axis import Assembly

#: The shipped scene.
SCENE = "smith-axis"


@dataclass(frozen=True)
class Ends:
    """Thrust of the shaft's tension on both ends [N], and stiffness of shaft and supports at mid-span [N/m]."""

    left: float
    right: float
    stiffness: float


def by_formulas(applied: float) -> Ends:
    """Rows by their laws, all of an end at one place, and a bar: the stretch is that of the ends, preload included.

    applied: force on the screw at mid-span towards the left end [N]. One equation for the left end's thrust.
    """
    a = axis()
    bar = 0.5 * a.length / (a.young * a.area)

    def gap(left: float) -> float:
        right = left + applied
        moved = [equilibrium(bearing_set("ball", end), f).displacement for end, f in (("left", left), ("right", right))]
        return sum(moved) + bar * (left + right) - STRETCH

    left = float(brentq(gap, -2e4, 4e4, xtol=1e-9))
    ends = [equilibrium(bearing_set("ball", end), f).stiffness for end, f in (("left", left), ("right", left + applied))]
    return Ends(left, left + applied, sum(1.0 / (1.0 / k + bar) for k in ends))


def by_scene(study: Study, applied: float) -> Ends:
    """The same by the scene: beam, contacts, rows apart from one another."""
    return study.once(_by_scene, applied)


def _by_scene(study: Study, applied: float) -> Ends:  # noqa: ARG001 - kept by the study
    found = catalogue.shipped(SCENE)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{SCENE} is an axis")
    loads = tuple(replace(x, force=(0.0, 0.0, -applied)) for x in found.loads)
    result = run_axis(replace(found, loads=loads), "lin")
    thrust = {end: sum(s.force[2] for s in result.sets if s.of.name.startswith(end)) for end in ("left", "right")}
    stiffness = float("nan") if result.stiffness is None else float(result.stiffness[2, 2])
    return Ends(-float(thrust["left"]), float(thrust["right"]), stiffness)


def words(study: Study) -> str:
    """Both in one sentence, in the source's units."""
    scene, closed = by_scene(study, APPLIED), by_formulas(APPLIED)
    ends = [f"{x.left / POUND:.0f} and {x.right / POUND:.0f} lbf" for x in (scene, closed)]
    stiff = [f"{x.stiffness / POUND_PER_INCH / 1e6:.3f}e6 lbf/in" for x in (scene, closed)]
    return f"as a scene the ends carry {ends[0]} ({stiff[0]} without the nut), by formulas {ends[1]} ({stiff[1]})"
