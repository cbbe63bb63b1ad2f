"""Response of a scene to its loads: preload at zero load, load at which a contact opens, and the load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeVar, overload

import numpy as np

from rollbench.compare.models.registry import Options, run_model
from rollbench.lowfi.rating.rigidity import approach_per_displacement, axial_force
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, Solved, StaticResult
from rollbench.lowfi.statics.summary import about_origin
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Load, Scene
from rollbench.meshes.quantity import Stated, quantity, record

Loaded = TypeVar("Loaded", Load, Housing)

#: Relative accuracy of the load factor at which a contact opens, largest factor tried, and most solutions for it.
TOLERANCE, FURTHEST, MOST = 0.005, 20.0, 16

#: Share of the step to the expected factor that is taken, as an open contact beyond that factor has no approach.
NEAR = 0.9


@record
class Preload:
    """Contact loads that errors and supports of the scene cause without its loads."""

    #: Mean load of the loaded contacts (`meshes.loads.mean_load`) [N].
    mean: float = quantity(
        "mean_N",
        "mean load of a contact or roller without the scene's loads",
        error="as `loads.max_N`; the input's tolerance is larger",
        heading="preload of a contact, mean",
        note="without the loads",
    )
    #: Largest contact load [N].
    largest: float = quantity("max_N", "largest load of a contact or roller without the scene's loads", error="as above")
    #: Number of loaded contacts.
    loaded: int = quantity("loaded_contacts", "contacts that preload loads; of a row of rollers, rollers")
    #: Internal axial force [N]: the smaller of the sums by which the flanks push the screw either way; zero if only one
    #: way.
    axial: float = quantity(
        "axial_N",
        "axial sum of one direction's contacts without the scene's loads; of one of several sets the axial force on the "
        "shaft then",
        error="as above",
        heading="preload, axial",
    )


@record
class LiftOff:
    """Load at which the first preloaded contact opens, as the loads grow in proportion."""

    #: Factor on the loads of the scene; None if none was found.
    factor: float | None = quantity(
        "load_factor",
        "factor of the scene's loads at which the first preloaded contact opens",
        heading="contact lost at load factor",
        form="g3",
        note="ball {ball} {side}",
    )
    #: Ball of this contact, from 1.
    ball: int = quantity("ball", "ball of that contact", show=lambda ball: ball or None, default=0)
    #: Flank of this contact: SL, SR, NL, NR.
    side: str = quantity("side", "its flank", show=lambda side: side or None, default="")
    #: Axial force on the nut at this factor [N].
    axial: float = 0.0
    #: Number of solutions that were needed.
    solves: int = 0
    words: str = quantity("words", "why no such load was found", show=lambda words: words or None, default="")

    @property
    @Stated("axial_force_N", "axial force at that factor")
    def force(self) -> float | None:
        """Axial force on the nut [N]; None if no factor was found."""
        return None if self.factor is None else self.axial


@overload
def scaled(scene: Scene, factor: float) -> Scene: ...


@overload
def scaled(scene: Assembly, factor: float) -> Assembly: ...


def scaled(scene: Scene | Assembly, factor: float) -> Scene | Assembly:
    """Return a copy of a scene with all loads times a factor, those on housings included.

    Parameters
    ----------
    scene
        Scene with one set or several.
    factor
        The factor; with zero a scene with one set has no loads.

    Returns
    -------
    Scene or Assembly
        The copy; motion and stiffness are reported at the same place.
    """

    def times(x: Loaded) -> Loaded:
        (fx, fy, fz), (mx, my, mz) = x.force, x.moment
        force, moment = (factor * fx, factor * fy, factor * fz), (factor * mx, factor * my, factor * mz)
        return replace(x, force=force, moment=moment)

    loads = tuple(map(times, scene.loads))
    if isinstance(scene, Scene):
        return replace(scene, loads=loads if factor else ())
    from rollbench.lowfi.statics.axis.system import asked  # loads the solver of several sets

    return replace(scene, loads=loads, housings=tuple(map(times, scene.housings)), stiffness_at=asked(scene))


def solve_scaled(scene: Scene, factor: float, model: str, options: Options) -> StaticResult:
    """Solve a scene with its loads times a factor.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    factor
        The factor.
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
        As `run_model`.
    """
    return run_model(scaled(scene, factor), model, replace(options, discretisation=False))


def preload(scene: Scene, bare: StaticResult) -> Preload:
    """Return the preload record of a scene from its result without loads (``bare``)."""
    loads = bare.load[bare.load > 0.0]
    if not loads.size:
        return Preload(0.0, 0.0, 0, 0.0)
    mean = mean_load(loads, nominal_contacts(scaled(scene, 0.0), bare))
    return Preload(mean, float(loads.max()), int(loads.size), axial_preload(scene, bare))


def axial_preload(scene: Scene, bare: StaticResult) -> float:
    """Return the internal axial force `Preload.axial` [N] from the result without loads."""
    return min(float(bare.load[:, s].sum()) for s in (0, 1)) * approach_per_displacement(scene)


def absolute_axial_preload(held: Preload | None) -> float:
    """Return the absolute axial preload [N]; zero if not known."""
    return 0.0 if held is None else abs(held.axial)


def lift_off(scene: Scene, result: StaticResult, bare: StaticResult, model: str, options: Options) -> LiftOff | None:
    """Find the factor on the loads at which the first preloaded contact opens.

    The approach of a contact is nearly linear in the load, so secant steps are taken on F^(2/3) of the smallest load.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    result
        Its result.
    bare
        Its result without loads.
    model
        Name of the model.
    options
        Options of the model.

    Returns
    -------
    LiftOff or None
        The factor; None without preload or without loads.
    """
    tracked = bare.load > 0.0
    if not tracked.any() or not any(np.any(x.force) or np.any(x.moment) for x in scene.loads):
        return None
    unit = axial_force(result)

    def least(solution: StaticResult) -> tuple[float, int]:
        values = np.where(tracked, solution.load, np.inf)
        k = int(values.argmin())
        return float(values.flat[k]) ** (2.0 / 3.0), k

    (approach, nearest), (first, contact) = least(result), least(bare)
    known, high = [(0.0, first)], np.inf
    if approach > 0.0:
        known.append((1.0, approach))
        contact = nearest
    else:
        high, contact = 1.0, nearest
    before = np.nan
    for solves in range(MOST):
        root = _secant_root(known)
        if root > FURTHEST and high == np.inf and len(known) > 1:
            return LiftOff(None, solves=solves, words=f"none up to {FURTHEST:g} times the loads")
        low = known[-1][0]
        if root < high and abs(root - before) <= TOLERANCE * root:
            return LiftOff(root, contact // 4 + 1, SIDES[contact % 4], root * unit, solves)
        if np.isfinite(high) and high - low <= TOLERANCE * high:
            return LiftOff(high, contact // 4 + 1, SIDES[contact % 4], high * unit, solves)
        before = root
        factor = low + NEAR * (root - low) if root < high else 0.5 * (low + high)
        trial = solve_scaled(scene, factor, model, options)
        if not trial.converged:
            return LiftOff(None, solves=solves + 1, words=f"not found: at {factor:.3g} times the loads {trial.status}")
        value, nearest = least(trial)
        if value > 0.0:
            known.append((factor, value))
            contact = nearest
        else:
            high, contact = factor, nearest
    return LiftOff(None, solves=MOST, words=f"not found in {MOST} solutions")


def _secant_root(known: Sequence[tuple[float, float]]) -> float:
    """Return the zero of the line through the last two points (x, y); infinite if there is one point or no fall."""
    if len(known) < 2:
        return float("inf")
    (a, f), (b, g) = known[-2:]
    return b + g * (b - a) / (f - g) if f > g else float("inf")


def axial_load(assembly: Assembly) -> float:
    """Return the sum of the axial loads on shaft and housings [N]."""
    return sum(x.force[2] for x in assembly.loads) + sum(h.force[2] for h in assembly.housings)


def displacement_of_interest(assembly: Assembly, result: AxisResult) -> Array:
    """Return the displacement of the station or housing of interest (``stiffness_at``), (6,) [m, rad]."""
    from rollbench.lowfi.statics.axis.system import asked  # loads the solver of several sets

    at = asked(assembly)
    if isinstance(at, str):
        return next((h.motion for h in result.housings if h.name == at), np.zeros(6))
    return np.array([np.interp(at, result.centreline_z, u) for u in result.centreline.T])


#: Share of a load that counts as small.
LITTLE = 0.05

#: Share of a load that counts as round-off.
NOTHING = 5e-4

#: Names of the six components of a load.
COMPONENTS = tuple(f"{way} {axis}" for way in ("along", "about") for axis in "xyz")


@record
class LoadTaker:
    """Support or frame of a housing, with its share of the loads."""

    #: Name: station of the support, or housing.
    name: str = quantity("name", "support of the shaft by its station, or frame of a housing")
    #: Force and moment that it takes, (6,) [N, N m].
    part: Array = quantity(
        "force_N",
        "what the support of this name (of several sets also the frame of a housing) takes of the loads: the force on it, "
        "less that without the loads",
        Stated("moment_Nm", "the same of the moment on it, at its station", show=lambda part: part[3:], parts="[]"),
        show=lambda part: part[:3],
        parts="[]",
    )


@record
class LoadPath:
    """Share of the loads that each support and the contacts take.

    All values are differences from the scene without its loads: preload and prescribed displacements do not count.
    """

    #: Force and moment of all loads, (6,) [N, N m].
    applied: Array = quantity(
        "applied.force_N",
        "sum of the forces of the scene's loads, on shaft and housings, along x, y, z",
        Stated(
            "applied.moment_Nm",
            "sum of the couples of its loads about x, y, z, as they are written",
            show=lambda applied: applied[3:],
            parts="[]",
        ),
        show=lambda applied: applied[:3],
        parts="[]",
    )
    #: Force and moment of the loads on the shaft, (6,) [N, N m].
    on_shaft: Array
    #: Shares of supports and frames.
    takers: tuple[LoadTaker, ...] = quantity("supports")
    #: Force and moment of the contacts about their nut or ring, (6,) [N, N m]; of several sets the sum of the absolute
    #: values.
    contacts: Array = quantity(
        "contacts.force_N",
        "what the loads change of the force that the contacts take from the screw; of several sets the sum of the changes' "
        "sizes",
        Stated(
            "contacts.moment_Nm",
            "the same of the moment about the centre of the nut or ring",
            show=lambda contacts: contacts[3:],
            parts="[]",
        ),
        show=lambda contacts: contacts[:3],
        parts="[]",
    )
    #: Pitch radius, which converts moments to forces [m].
    arm: float
    #: Body on which the loads act, if they are those on one body only; empty for all loads.
    where: str = ""


def load_path_of_set(scene: Scene, result: StaticResult, bare: StaticResult) -> LoadPath | None:
    """Return the load path of a scene with one set.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    result
        Its result.
    bare
        Its result without loads.

    Returns
    -------
    LoadPath or None
        The path; None without loads.
    """
    applied = sum_of_loads(scene.loads)
    if not applied.any():
        return None
    contacts = _wrench_at(scene.nut.position, _contact_wrench_on_screw(result) - _contact_wrench_on_screw(bare))
    return LoadPath(applied, applied, _support_shares(scene, result, bare), -contacts, scene.track.pitch_radius)


def load_path_of_assembly(assembly: Assembly, result: AxisResult, bare: AxisResult, where: str = "") -> LoadPath | None:
    """Return the load path of several sets on one shaft.

    Parameters
    ----------
    assembly
        Shaft with several sets.
    result
        Its result.
    bare
        Its result without loads.
    where
        Body on which the loads act; empty: all bodies.

    Returns
    -------
    LoadPath or None
        The path; None without loads.
    """
    on_shaft = sum_of_loads(assembly.loads)
    applied = on_shaft + sum_of_loads([Load(h.at, h.force, h.moment) for h in assembly.housings])
    if not applied.any():
        return None
    pairs = zip(result.housings, bare.housings, strict=True) if bare.converged else ((h, None) for h in result.housings)
    frames = (LoadTaker(f"the frame of {a.name}", -(a.wrench - (0.0 if b is None else b.wrench))) for a, b in pairs)
    each = [np.concatenate([s.force, s.moment]) for s in result.sets]
    idle = [np.concatenate([s.force, s.moment]) for s in bare.sets] if bare.converged else [np.zeros(6)] * len(each)
    contacts = np.abs(np.array(each) - np.array(idle)).sum(axis=0)
    radii = [s.parts.track.pitch_radius for s in assembly.sets if isinstance(s.parts, Scene)]
    arm = max(radii, default=assembly.screw.outer_diameter / 2.0)
    return LoadPath(applied, on_shaft, (*_support_shares(assembly, result, bare), *frames), contacts, arm, where)


def loaded_bodies(assembly: Assembly) -> dict[str, tuple[Assembly, Assembly]]:
    """Return, by loaded body (shaft or housing), the assembly with only its loads, and with all loads but its own."""
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


def sum_of_loads(loads: Sequence[Load]) -> Array:
    """Return the sums of forces and of given moments, (6,) [N, N m]; lever arms of the forces do not count."""
    return np.asarray(np.array([(*x.force, *x.moment) for x in loads]).reshape(-1, 6).sum(axis=0))


def _support_shares(scene: Scene | Assembly, result: Solved, bare: Solved) -> tuple[LoadTaker, ...]:
    """Return what each support takes of the loads; empty if the model has no reactions by support."""
    if not len(result.reactions):  # the axial models of Mei know no single support
        return ()
    idle = bare.reactions if bare.converged else np.zeros(result.reactions.shape)
    parts = zip(scene.supports, -(result.reactions - idle), strict=True)
    return tuple(LoadTaker(f"the support at {1e3 * s.at:.6g} mm", part) for s, part in parts)


def _contact_wrench_on_screw(result: StaticResult) -> Array:
    """Return force and moment (6,) of the contacts on the screw about the origin; zero without equilibrium."""
    e = result.equilibrium
    return np.zeros(6) if e is None or not result.converged else np.concatenate([e.contact_force, e.contact_moment])


def _wrench_at(station: float, wrench: Array) -> Array:
    """Move a wrench (6,) from the origin to a station [m] of the axis."""
    return about_origin(np.array([-station]), wrench[None])


def load_path_text(path: LoadPath) -> str:
    """Return a text on how much of each load component each support takes; empty if supports take nothing."""
    out = []
    for k in np.flatnonzero(path.applied):
        load, unit = float(path.applied[k]), "N" if k < 3 else "N m"
        into = [(t.name, float(t.part[k])) for t in path.takers if abs(t.part[k]) > NOTHING * abs(load)]
        if into:
            each = ", ".join(f"{part:.5g} {unit} into {name}" for name, part in into)
            out.append(
                f"of {load:.5g} {unit} {COMPONENTS[k]} {each}, {float(path.contacts[k]):.3g} {unit} through contacts"
            )
    return "; ".join(out)


def load_path_warnings(path: LoadPath | None) -> Iterator[Warned]:
    """Yield a warning if little of the axial force, or of all loads on the shaft, reaches the contacts.

    The contact loads then do not represent the applied load. Loads on several bodies are judged body by body.
    """
    if path is None:
        return
    size, axial = np.repeat([1.0, 1.0 / path.arm], 3), path.applied[2]
    given = path.on_shaft != 0.0
    load = float(np.linalg.norm((path.on_shaft * size)[given]))
    reached = float(np.linalg.norm((path.contacts * size)[given]))
    if axial and abs(path.contacts[2]) < LITTLE * abs(axial):
        on = f" on {path.where}" if path.where else ""
        what, share = f"the axial load of {axial:.5g} N{on}", abs(path.contacts[2] / axial)
    elif load and reached < LITTLE * load:
        what, share = "the loads on the shaft", reached / load
    else:
        return
    words = load_path_text(path)
    text = (
        f"of {what} only {100.0 * share:.2g} % reaches the contacts, and what is computed of them holds for that: {words}; "
        "free the freedom that holds it, unless that is meant"
    )
    yield Warned("held load", text, f"only {100.0 * share:.2g} % of {what} reaches the contacts, supports take the rest")
