"""Preload of a scene, load at which a contact opens, and shares of the loads that supports and contacts carry."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Generic, NamedTuple, TypeVar, overload

import numpy as np

from rollbench.compare.measure import mean_load
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.lowfi.rating.rigidity import approach_per_displacement, axial_force
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult, StaticSolution
from rollbench.lowfi.statics.result import SetResult as SetOnShaft
from rollbench.lowfi.statics.summary import resultant_about_origin
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing
from rollbench.meshes.parts import SIDES, Load, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record, text_or_none

#: Type with a force and a moment: a load on the shaft, or a housing with its load.
Loaded = TypeVar("Loaded", Load, Housing)
#: Type of the solution of a scene.
Solution = TypeVar("Solution", bound=StaticSolution)

#: Search for the factor on the loads at which a contact opens: relative accuracy and largest value of the factor, largest
#: number of solutions.
TOLERANCE, FURTHEST, MOST = 0.005, 20.0, 16

#: Share that is taken of the step to the load factor at which a contact is expected to open: with two points, with more.
#: Beyond that factor the contact is open and its approach, from which the next step is computed, is not known.
FAR, NEAR = 0.75, 0.8

#: Share of the contact loads under load up to which loads without load are none: parts that just touch keep such loads,
#: because the energy of contacts that close by nothing is flat.
TOUCHING = 1e-6

#: Share of a root above which the solution that it is extrapolated from has to lie, and share of the root by which this
#: solution may have moved it: what it left to extrapolate is some times less.
CLOSE, SETTLED = 0.8, 0.01


@result_record
class Preload:
    """Contact loads that remain without external loads, due to ball oversize, geometric errors and misaligned supports."""

    #: Mean load of the loaded contacts (`compare.measure.mean_load`) [N].
    mean: float = quantity_field(
        "mean_N",
        "mean load of a contact or roller without the scene's loads",
        error="as `loads.max_N`; the input's tolerance is larger",
        heading="preload of a contact, mean",
        note="without the loads",
    )
    #: Largest contact load without external loads [N].
    largest: float = quantity_field(
        "max_N", "largest load of a contact or roller without the scene's loads", error="as `preload.mean_N`"
    )
    #: Number of contacts that carry load without external loads.
    contacts: int = quantity_field(
        "loaded_contacts",
        "number of contacts that carry load without the scene's loads; for a row of rollers, number of rollers",
    )
    #: Internal axial force [N], the smaller of the axial forces with which contacts push the screw in the two directions;
    #: zero if they push in one direction only.
    axial: float = quantity_field(
        "axial_N",
        "without the scene's loads, axial force with which the contacts press the screw in one direction, balanced by that "
        "in the other; for one of several nuts or bearing rows, its axial force on the shaft",
        error="as `preload.mean_N`",
        heading="preload, axial",
    )


@result_record
class LiftOff:
    """External load at which the first preloaded contact opens, when all loads of the scene grow in proportion."""

    #: Factor on the loads of the scene at which the contact opens; None if none was found.
    factor: float | None = quantity_field(
        "load_factor",
        "factor on the scene's loads at which the first preloaded contact opens",
        heading="factor on loads that opens a contact",
        form="g3",
        note="{place}",
    )
    #: Number of the ball or roller of the contact that opens, from 1; 0 if none was found.
    ball: int = quantity_field(
        "ball", "ball, or roller, of the contact that opens", show=lambda ball: ball or None, default=0
    )
    #: Flank of the contact that opens: SL, SR, NL, NR; empty for rollers, and if none was found.
    side: str = text_or_none("side", "flank of the contact that opens")
    #: Axial force on the nut, or of several nuts or bearings the sum of the axial loads, when the contact opens [N]; 0 if
    #: none was found.
    axial: float = 0.0
    #: Number of times that the scene was solved for the search.
    solves: int = 0
    words: str = text_or_none("words", "why no load was found at which a contact opens")
    #: Name of the nut or bearing; empty if the scene has only one.
    set: str = ""

    @property
    @QuantityDescription(
        "axial_force_N",
        "axial force on the nut when the contact opens; of several nuts or bearings, sum of the axial loads",
    )
    def force(self) -> float | None:
        """Axial force on the nut, or sum of the axial loads, at which the contact opens [N]; None if none was found."""
        return None if self.factor is None else self.axial

    @property
    @QuantityDescription("place", "nut or bearing, if the scene has several, and ball or roller whose contact opens")
    def place(self) -> str | None:
        """Nut or bearing, and ball with flank, or roller, of the contact that opens; None if none was found."""
        contact = f"ball {self.ball} {self.side}" if self.side else f"roller {self.ball}"
        return ", ".join(filter(None, (self.set, contact))) if self.ball else None


@overload
def with_scaled_loads(scene: Scene, factor: float) -> Scene: ...


@overload
def with_scaled_loads(scene: Assembly, factor: float) -> Assembly: ...


def with_scaled_loads(scene: Scene | Assembly, factor: float) -> Scene | Assembly:
    """Return a copy of a scene with all loads on shaft and housings multiplied by a factor.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    factor
        Factor on forces and moments.

    Returns
    -------
    Scene or Assembly
        The copy. Displacement and stiffness refer to the same position as those of the original.
    """

    def multiplied_load(x: Loaded) -> Loaded:
        """Return a copy of an external load with force and moment multiplied by ``factor``."""
        (fx, fy, fz), (mx, my, mz) = x.force, x.moment
        force, moment = (factor * fx, factor * fy, factor * fz), (factor * mx, factor * my, factor * mz)
        return replace(x, force=force, moment=moment)

    loads = tuple(map(multiplied_load, scene.loads))
    if isinstance(scene, Scene):
        return replace(scene, loads=loads if factor else ())
    from rollbench.lowfi.statics.axis.system import location_of_reported_stiffness  # heavy import

    housings = tuple(map(multiplied_load, scene.housings))
    return replace(scene, loads=loads, housings=housings, stiffness_at=location_of_reported_stiffness(scene))


def solve_with_scaled_loads(scene: Scene, factor: float, model: str, options: ModelOptions) -> StaticResult:
    """Solve a scene with all loads multiplied by a factor.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    factor
        Factor on forces and moments.
    model
        Name of the model.
    options
        Options of the model.

    Returns
    -------
    StaticResult
        The result.

    Raises
    ------
    InputError
        If the model does not cover the scene.
    """
    return run_model(with_scaled_loads(scene, factor), model, replace(options, estimate_beam_mesh_error=False))


def preload_from_unloaded(scene: Scene, unloaded: StaticResult) -> Preload:
    """Return the preload of a scene: contact loads and axial force in its result ``unloaded`` without external loads."""
    loads = unloaded.load[unloaded.load > 0.0]
    if not loads.size:
        return Preload(0.0, 0.0, 0, 0.0)
    mean = mean_load(loads, count_nominal_contacts(with_scaled_loads(scene, 0.0), unloaded))
    return Preload(mean, float(loads.max()), int(loads.size), axial_preload(scene, unloaded))


def preload_on_shaft(unloaded: SetOnShaft) -> Preload:
    """Return the preload of one of several nuts or bearings on a shaft from its solution without external loads."""
    loads = unloaded.loads[unloaded.loads > 0.0]
    mean = mean_load(loads) if loads.size else 0.0
    return Preload(mean, float(loads.max(initial=0.0)), int(loads.size), float(unloaded.force[2]))


def axial_preload(scene: Scene, unloaded: StaticResult) -> float:
    """Return the internal axial force due to preload [N]; ``unloaded``: result of the scene without external loads.

    Returned is the smaller of the axial forces with which the contacts push the screw in the two directions.
    """
    return min(float(unloaded.load[:, s].sum()) for s in (0, 1)) * approach_per_displacement(scene)


def absolute_axial_preload(preload: Preload | None) -> float:
    """Return the magnitude of the internal axial force due to preload [N]; zero if the preload is None (not known)."""
    return 0.0 if preload is None else abs(preload.axial)


@dataclass
class SolutionsByLoad(Generic[Solution]):
    """Solutions of a scene under multiples of its loads, each computed once."""

    #: Scene with one nut or bearing row, or with several on one shaft.
    scene: Scene | Assembly
    #: Solution of the scene.
    result: Solution
    #: Name of the model.
    model: str
    #: Options of the model.
    options: ModelOptions

    @cached_property
    def known(self) -> dict[float, Solution]:
        """Solutions by the factor on the loads."""
        return {1.0: self.result}

    def at(self, factor: float) -> Solution:
        """Return the solution under all loads multiplied by ``factor``; InputError if the model does not cover it."""
        if factor not in self.known:
            options = replace(self.options, estimate_beam_mesh_error=False)
            found = run_model(with_scaled_loads(self.scene, factor), self.model, options)
            assert isinstance(found, type(self.result))
            self.known[factor] = found
        return self.known[factor]


def loads_of_sets(solution: StaticSolution) -> tuple[Array, ...]:
    """Return the loads [N] of each nut or bearing: of contacts (n, 4), or of rollers (count,)."""
    if isinstance(solution, AxisResult):
        return tuple(s.loads for s in solution.sets)
    return (solution.load,) if isinstance(solution, StaticResult) else ()


def find_lift_off_loads(solutions: SolutionsByLoad[Any]) -> tuple[LiftOff | None, ...]:
    """Find for each nut or bearing the factor on the scene's loads at which its first preloaded contact opens.

    The elastic approach of the bodies at a contact is nearly linear in the external load, and proportional to F^(2/3),
    where F is the contact load. The load factor is therefore interpolated over F^(2/3) of each contact.

    Parameters
    ----------
    solutions
        Solutions of the scene under multiples of its loads.

    Returns
    -------
    tuple[LiftOff | None, ...]
        Factor on the loads, with the contact that opens, or the reason why no factor was found; None for a nut or bearing
        without preload, for a scene without loads, and if the unloaded scene has no equilibrium.
    """
    scene, result, unloaded = solutions.scene, solutions.result, solutions.at(0.0)
    axial = axial_force(result) if isinstance(result, StaticResult) else axial_load(scene)
    names = [s.name for s in scene.sets] if isinstance(scene, Assembly) else [""]
    if not has_loads(scene) or not unloaded.converged:
        return (None,) * len(names)
    before, least = loads_of_sets(unloaded), _least_preload(result, unloaded)

    def of_set(k: int) -> LiftOff | None:
        """Return the lift-off load of the nut or bearing with index ``k``."""
        tracked = before[k] > 0.0
        if not float(before[k].sum()) > least:
            return None

        def preloaded_loads(solution: StaticSolution) -> Array:
            """Return F^(2/3) of the loads F [N] of the contacts that preload closes."""
            return np.asarray(loads_of_sets(solution)[k][tracked] ** (2.0 / 3.0))

        found = _search_first_zero_over_loads(solutions, preloaded_loads)
        if found.factor is None:
            words = found.words or f"no contact opens up to {FURTHEST:g} times the loads"
            return LiftOff(None, solves=found.solves, words=words, set=names[k])
        place = int(np.flatnonzero(tracked)[found.place])
        ball, side = divmod(place, len(SIDES)) if tracked.ndim == 2 else (place, None)
        flank = "" if side is None else SIDES[side]
        return LiftOff(found.factor, ball + 1, flank, found.factor * axial, found.solves, set=names[k])

    return tuple(map(of_set, range(len(names))))


def _least_preload(result: StaticSolution, unloaded: StaticSolution) -> float:
    """Return the sum of contact loads [N] of a nut or bearing up to which it counts as not preloaded.

    ``result``, ``unloaded``: solutions with and without the loads.
    """
    least = NOTHING * max(float(loads.sum()) for loads in loads_of_sets(unloaded))
    if result.converged:
        least = max(least, TOUCHING * max(float(loads.sum()) for loads in loads_of_sets(result)))
    return least


class _ZeroOverLoads(NamedTuple):
    """Factor on the loads at which the first of some quantities reaches zero."""

    #: The factor; None if none was found.
    factor: float | None
    #: Index of the quantity that reaches zero.
    place: int
    #: Number of solutions.
    solves: int
    #: Why no factor was found; empty if there is one, or if it lies beyond `FURTHEST`.
    words: str = ""


def _search_first_zero_over_loads(
    solutions: SolutionsByLoad[Any], quantities: Callable[[StaticSolution], Array]
) -> _ZeroOverLoads:
    """Return the factor on the loads at which the first of some quantities reaches zero.

    ``quantities``: function that returns the quantities in a solution. Each falls nearly in proportion to the loads, and is
    zero beyond the factor at which it reaches zero. A root is found if the last solution lies near it (`CLOSE`) and moved
    it by little (`SETTLED`).
    """
    high, beyond, opened, known, before = np.inf, np.zeros(1), 0, list[tuple[float, Array]](), np.nan
    for factor, solution in sorted(solutions.known.items()):
        if factor < high and solution.converged:
            values = quantities(solution)
            if values.all():
                known.append((factor, values))
            else:
                high, beyond, opened = factor, values, int(values.argmin())
    for solves in range(MOST):
        low, roots = known[-1][0], _zeros_beyond(known)
        place, root = int(roots.argmin()), float(roots.min())
        if root > FURTHEST and high == np.inf and len(known) > 1:
            return _ZeroOverLoads(None, place, solves)
        if root < high and low >= CLOSE * root and abs(root - before) <= SETTLED * root:
            return _ZeroOverLoads(root, place, solves)
        if np.isfinite(high) and high - low <= TOLERANCE * high:
            return _ZeroOverLoads(high, opened, solves)
        before = root
        if len(known) == 1:  # the loads that open a contact are to those at `high` about as the quantities are
            preloaded = float(known[0][1].max())
            factor = 0.5 * high * preloaded / max(float(beyond.max()), preloaded)
        else:
            factor = low + (FAR if len(known) == 2 else NEAR) * (root - low) if root < high else 0.5 * (low + high)
        trial = solutions.at(factor)
        if not trial.converged:
            words = f"not found, because the solution at {factor:.3g} times the loads is {trial.status}"
            return _ZeroOverLoads(None, place, solves + 1, words)
        values = quantities(trial)
        if values.all():
            known.append((factor, values))
        else:
            high, beyond, opened = factor, values, int(values.argmin())
    return _ZeroOverLoads(None, opened, MOST, f"not found in {MOST} solutions")


def _zeros_beyond(known: Sequence[tuple[float, Array]]) -> Array:
    """Return the factor at which each quantity reaches zero; infinite if it does not fall, or if one point is known only.

    The factor is interpolated over the value, through the last three points and the first. ``known``: (factor, values)
    in the order of the factors.
    """
    points = [known[0], *known[1:][-3:]][::-1]
    differences, y = map(list, zip(*points, strict=True))
    last, root, product = known[-1][0], np.full(y[0].shape, known[-1][0]), np.ones(y[0].shape)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for order in range(1, len(points)):  # Newton's form, by divided differences
            differences = [(low - high) / (y[k + order] - y[k]) for k, (high, low) in enumerate(pairwise(differences))]
            product = -product * y[order - 1]
            further = root + product * differences[0]
            root = np.where((order == 1) | (further > last) & np.isfinite(further), further, root)
    return np.where((root > last) & (y[0] < y[min(1, len(y) - 1)]), root, np.inf)


#: Share of the preload of one of several nuts or bearing rows, below which it counts as lost.
LOST = 0.1


def lost_preload_warnings(solutions: SolutionsByLoad[Any]) -> Iterator[ResultWarning]:
    """Yield a warning for each preloaded nut or row on a shaft that the loads leave with less than `LOST` of its loads.

    The warning has the factor on the loads at which the last contact of the nut or row opens. ``solutions``: solutions of
    the shaft under multiples of its loads.
    """
    result, unloaded = solutions.result, solutions.at(0.0)
    if isinstance(solutions.scene, Scene) or not has_loads(solutions.scene) or not unloaded.converged:
        return
    sums, least = [float(loads.sum()) for loads in loads_of_sets(unloaded)], _least_preload(result, unloaded)
    for k, (now, bare, before) in enumerate(zip(result.sets, unloaded.sets, sums, strict=True)):
        if not before > least or float(now.loads.sum()) >= LOST * before:
            continue

        def sum_of_loads_of_set(solution: StaticSolution, k: int = k) -> Array:
            """Return (sum of contact loads)^(2/3) of the nut or row, (1,)."""
            return np.array([loads_of_sets(solution)[k].sum() ** (2.0 / 3.0)])

        found = _search_first_zero_over_loads(solutions, sum_of_loads_of_set)
        axial = f"{abs(now.force[2]):.3g} N of {abs(bare.force[2]):.4g} N are left"
        opens = "" if found.factor is None else f"; {found.factor:.3g} times the loads open it"
        brief = f"{now.of.name} has lost its preload: {axial}{opens}"
        yield ResultWarning("lost preload", f"{brief}; more preload, or smaller loads, keep both sides in contact", brief)


def axial_load(scene: Scene | Assembly) -> float:
    """Return the sum of the axial forces of all external loads on the shaft and its housings [N]."""
    return sum(x.force[2] for x in loaded_parts(scene))


def has_loads(scene: Scene | Assembly) -> bool:
    """Return whether any force or moment acts on the shaft or a housing."""
    return any(np.any(x.force) or np.any(x.moment) for x in loaded_parts(scene))


def loaded_parts(scene: Scene | Assembly) -> tuple[Load | Housing, ...]:
    """Return the loads on the shaft, and the housings with their loads."""
    return (*scene.loads, *(scene.housings if isinstance(scene, Assembly) else ()))


#: Share of a load that the contacts carry, below which a warning is shown [1].
LITTLE = 0.05

#: Ratio of a reaction to the load, below which the reaction counts as round-off [1].
NOTHING = 5e-4

#: Names of the six components of a load.
COMPONENTS = tuple(f"{way} {axis}" for way in ("along", "about") for axis in "xyz")


def _wrench_field(key: str, force: str, moment: str) -> Any:
    """Return a field with three forces and three moments (6,) [N, N m], which has a key for each of both.

    ``key``: beginning of both keys; ``force``, ``moment``: their definitions.
    """
    of_moment = QuantityDescription(f"{key}moment_Nm", moment, show=lambda load: load[3:], parts="[]")
    return quantity_field(f"{key}force_N", force, of_moment, show=lambda load: load[:3], parts="[]")


@result_record
class SupportShare:
    """Share of the external loads that one support of the shaft, or the frame that holds a housing, carries."""

    #: Name of the support (its axial position) or of the housing.
    name: str = quantity_field("name", "support of the shaft, named by its axial position, or frame that holds a housing")
    #: Force and moment of the external loads that the support or frame carries, (6,) [N, N m].
    carried_load: Array = _wrench_field(
        "",
        "share of the loads that this support or frame carries: force on it, less the force on it without the loads",
        "share of the loads that this support or frame carries: moment on it at its axial position, less the moment "
        "without the loads",
    )


@result_record(kw_only=True)
class LoadPath:
    """Shares of the external loads that each support and the rolling contacts carry.

    All values are differences from the scene without its loads, so preload and prescribed displacements are not included.
    """

    #: Force and moment of all loads, (6,) [N, N m].
    applied_load: Array = _wrench_field(
        "applied.",
        "sum of the forces of the scene's loads, on shaft and housings, along x, y, z",
        "sum of the moments of the scene's loads about x, y, z, as stated there; lever arms of forces are not included",
    )
    #: Force and moment of the loads on the shaft, (6,) [N, N m].
    load_on_shaft: Array = _wrench_field(
        "on_shaft.",
        "sum of the forces of the scene's loads on the shaft along x, y, z",
        "sum of the moments of the scene's loads on the shaft about x, y, z, without lever arms of forces",
    )
    #: Shares that the supports of the shaft and the frames of housings carry.
    support_shares: tuple[SupportShare, ...] = quantity_field("supports")
    #: Force and moment (6,) [N, N m] of the external loads that the contacts carry, the moment about the centre of their
    #: nut or ring; for several nuts or rows the sum of the absolute values.
    contact_load: Array = _wrench_field(
        "contacts.",
        "change, due to the loads, of the force of the screw on the contacts; of several nuts or bearing rows the sum of "
        "the absolute changes",
        "change, due to the loads, of the moment of the screw on the contacts about the centre of the nut or ring; of "
        "several nuts or bearing rows the sum of the absolute changes",
    )
    #: Lever arm by which moments are divided to compare them with forces: the pitch radius [m].
    lever_arm: float = quantity_field("lever_arm_mm", "pitch radius, by which moments are compared with forces")
    #: Name of the only body (housing, or "the shaft") whose loads are considered; empty: the loads on all bodies.
    loaded_body: str = ""


def load_path(
    scene: Scene | Assembly, result: StaticResult | AxisResult, unloaded: StaticResult | AxisResult, body: str = ""
) -> LoadPath | None:
    """Return the shares of the loads that supports, frames of housings and contacts carry.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    result
        Result of the scene.
    unloaded
        Result of the scene without loads.
    body
        Name of the only loaded body in ``scene`` (a housing, or "the shaft"); empty: several bodies may be loaded.

    Returns
    -------
    LoadPath or None
        Loads, reactions and contact forces; None without loads.
    """
    on_shaft = sum_of_loads(scene.loads)
    applied = on_shaft + sum_of_loads([x for x in loaded_parts(scene) if isinstance(x, Housing)])
    if not applied.any():
        return None
    shares = _support_shares(scene, result, unloaded)
    if isinstance(scene, Scene):
        change = _contact_wrench_on_screw(result) - _contact_wrench_on_screw(unloaded)
        contacts = -resultant_about_origin(np.array([-scene.nut.position]), change[None])  # moment about the nut's centre
        arm = scene.track.pitch_radius
    else:
        assert isinstance(result, AxisResult)
        assert isinstance(unloaded, AxisResult)
        each = np.array([np.concatenate([s.force, s.moment]) for s in result.sets])
        idle, frames = np.zeros(each.shape), [np.zeros(6)] * len(result.housings)
        if unloaded.converged:
            idle = np.array([np.concatenate([s.force, s.moment]) for s in unloaded.sets])
            frames = [h.wrench for h in unloaded.housings]
        held = zip(result.housings, frames, strict=True)
        shares += tuple(SupportShare(f"the frame of {h.name}", -(h.wrench - before)) for h, before in held)
        radii = [s.parts.track.pitch_radius for s in scene.sets if isinstance(s.parts, Scene)]
        arm = max(radii, default=scene.screw.outer_diameter / 2.0)
        contacts = np.abs(each - idle).sum(axis=0)
    return LoadPath(
        applied_load=applied,
        load_on_shaft=on_shaft,
        support_shares=shares,
        contact_load=contacts,
        lever_arm=arm,
        loaded_body=body,
    )


def assemblies_by_loaded_body(assembly: Assembly) -> dict[str, tuple[Assembly, Assembly]]:
    """Return two copies of an assembly with split loads for each loaded body (shaft or housing), by the name of the body.

    In the first copy only the loads on this body act, in the second only the loads on all other bodies.
    """
    none, out = (0.0, 0.0, 0.0), dict[str, tuple[Assembly, Assembly]]()
    bare = tuple(replace(h, force=none, moment=none) for h in assembly.housings)
    off = tuple(replace(x, force=none, moment=none) for x in assembly.loads)
    if sum_of_loads(assembly.loads).any():
        out["the shaft"] = replace(assembly, housings=bare), replace(assembly, loads=off)
    for i, h in enumerate(assembly.housings):
        if any((*h.force, *h.moment)):
            alone, others = (*bare[:i], h, *bare[i + 1 :]), (*assembly.housings[:i], bare[i], *assembly.housings[i + 1 :])
            out[h.name] = replace(assembly, loads=off, housings=alone), replace(assembly, housings=others)
    return out


def sum_of_loads(loads: Sequence[Load | Housing]) -> Array:
    """Return the sum of the forces and the sum of the moments of external loads, (6,) [N, N m].

    Moments of the forces about a common point are not included.
    """
    return np.asarray(np.array([(*x.force, *x.moment) for x in loads]).reshape(-1, 6).sum(axis=0))


def _support_shares(scene: Scene | Assembly, result: StaticSolution, unloaded: StaticSolution) -> tuple[SupportShare, ...]:
    """Return the share of the loads that each support of the shaft carries; empty if the model computes no reactions.

    ``result``: solution under the scene's loads; ``unloaded``: solution without them.
    """
    if not len(result.reactions):  # Mei's axial models do not distinguish supports
        return ()
    idle = unloaded.reactions if unloaded.converged else np.zeros(result.reactions.shape)
    parts = zip(scene.supports, -(result.reactions - idle), strict=True)
    return tuple(SupportShare(f"the support at {1e3 * s.at:.6g} mm", part) for s, part in parts)


def _contact_wrench_on_screw(result: StaticSolution) -> Array:
    """Return the force of all contacts on the screw and its moment about the origin, (6,) [N, N m].

    Force and moment are zero for a result without equilibrium.
    """
    e = result.equilibrium
    return np.zeros(6) if e is None or not result.converged else np.concatenate([e.contact_force, e.contact_moment])


def load_path_text(path: LoadPath) -> str:
    """Return a text with the share of each load component that each support carries; empty if supports carry nothing."""
    out = []
    for k in np.flatnonzero(path.applied_load):
        load, unit = float(path.applied_load[k]), "N" if k < 3 else "N m"
        into = [(t.name, float(t.carried_load[k])) for t in path.support_shares]
        each = [f"{part:.5g} {unit} into {name}" for name, part in into if abs(part) > NOTHING * abs(load)]
        if each:
            through = f"{float(path.contact_load[k]):.3g} {unit} through contacts"
            out.append(f"of {load:.5g} {unit} {COMPONENTS[k]} {', '.join(each)}, {through}")
    return "; ".join(out)


def load_path_warnings(path: LoadPath | None) -> Iterator[ResultWarning]:
    """Yield a warning if supports carry nearly all of the axial load, or nearly all loads on the shaft, past the contacts.

    The contact loads then do not represent the applied load. ``path``: shares of the loads on all bodies, or on one body.
    """
    if path is None:
        return
    size, axial = np.repeat([1.0, 1.0 / path.lever_arm], 3), path.applied_load[2]
    given = path.load_on_shaft != 0.0
    load = float(np.linalg.norm((path.load_on_shaft * size)[given]))
    reached = float(np.linalg.norm((path.contact_load * size)[given]))
    if axial and abs(path.contact_load[2]) < LITTLE * abs(axial):
        on = f" on {path.loaded_body}" if path.loaded_body else ""
        what, share = f"the axial load of {axial:.5g} N{on}", abs(path.contact_load[2] / axial)
    elif load and reached < LITTLE * load:
        what, share = "the loads on the shaft", reached / load
    else:
        return
    head = f"only {100.0 * share:.2g} % of {what} reaches the contacts"
    text = (
        f"{head}, and contact results hold for this share only: {load_path_text(path)}; "
        "free the direction in which a support carries the load, unless this is intended"
    )
    yield ResultWarning("held load", text, f"{head}, supports carry the rest")
