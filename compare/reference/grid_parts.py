"""Uncertainty of contact loads by the mesh, the sum of a part for each kind of refinement.

A level refines by different ratios: cells of the contact by 4/3, those of the bodies by 1.15, the cut of the coarse sockets
not at all, so that no order over one cell size describes its loads. Nor do the loads approach a limit from one side:
consecutive changes of a contact load correlate by -0.5, like independent errors, because no cell of one level's mesh is a
cell of the next; extrapolated with any order they are further from the next level than without
(tests/unit/models/test_grid_coverage.py). So errors of a level count as scatter, whose variance falls by part,

    s^2 = contact^2 h_c^4 + bodies^2 h_b^4 + sockets^2 + common^2,

with sizes h_c and h_b over those of the finest level (second-order cells: errors fall as h^2). The changes between the
scene's levels give the first two, whose variances add between two levels. The others are taken from experience: sockets,
from a run in which only they are cut finer; common, which moves all loads of a level together and so does not average over
the contacts of one scene, from the mean changes of all scenes whose sum of loads is not fixed by equilibrium: those with
load on both flanks of the screw.

The uncertainty is twice the root of the sum for the finest level and a next one together (2.2 times if it rests on the
change between two neighbouring levels only): in 95 % of contacts it covers what a finer mesh finds. Errors of bodies and
sockets are displacements, which a contact turns into load by its stiffness, dF / dx ~ F^(1/3) (Hertz): these two parts are
distributed over the contacts accordingly. Errors that all meshes share are not covered (`compare.models.uncertainty`).

Near a free face of the nut a level neglects a part of a contact's compliance. A contact's local compliance is that of a
finely meshed piece of its body (`hifi.bodies.coarse`), far from any face. Near a free face the lip adds compliance, which
the cells of the level's body underestimate. Nuts of six balls with ever finer bodies give the difference
(``near_face.json``, written by ``tests/near_face.py``). In terms of 1 / (E r) the missing compliance is the same for balls
and leads of all sizes within a quarter, and depends on the distance d from the face over the ball radius r: on level 1 it
is 0.4 at d = 1.1 r and 0.03 at 2.5 r.

It concerns the flank that is pressed towards the face, and through its ball the opposite flank of the screw. At a given
approach of the bodies a missing compliance dC makes their load F too large by

    dF = F dC / (2/3 (delta_s + delta_n) / F + C_lip),

delta: Hertz's approaches, whose tangent is 2/3 delta / F. Fixed faces, and balls far from faces, have no such part. If one
flank of the screw carries load, equilibrium fixes the sum of loads, and the excess of these contacts is missing on the
others of their side, in proportion to their stiffness (`error_near_faces`). The changes between the levels of a scene show
that, and of a ring, all of whose contacts are near both faces, the rest as well.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.reference.levels import LEVELS, PRODUCTION
from rollbench.compare.reference.store import shipped_store
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import solid_dimensions

FILE = "grid_parts.json"

#: Number of standard deviations in an uncertainty that covers 95 %: usual, and if only the change between two neighbouring
#: levels is known. That change scatters from scene to scene: a factor of 2 covered 87 % of the contacts of one drawn screw.
COVER, COVER_OF_ONE_CHANGE = 2.0, 2.2

#: Second-order cells.
ORDER = 2

#: Exponent of the load in the stiffness of a contact.
STIFFNESS = 1.0 / 3.0

#: Cell size of contact and bodies over that of the level before, for a level after the last.
NEXT = (0.75, 0.87)

#: Shares of contacts that the uncertainty of a single level covers: of all compared scenes, and of each scene with one
#: loaded flank of the screw, and with both (of which there are fewer).
SHARE, LEAST = 0.95, (0.93, 0.95)

#: Rounds of reweighting in a fit of variances, and the smallest variance [%^2] that differs from zero.
ROUNDS, TINY = 20, 1e-12

#: Loads ``(n, 4)`` [N] of a scene by level.
Levelled = Mapping[int, Array]


@dataclass(frozen=True)
class Experience:
    """Parts of the uncertainty that a scene's mesh levels do not show, from other scenes [% of the mean load]."""

    #: Standard deviation by the cut of the sockets.
    sockets: float
    #: Standard deviation of an error that all contacts share.
    common: float
    #: Uncertainty of the coarsest level without others, with one and with both flanks of the screw loaded: it covers 95 %
    #: of the errors (93 % of those of every scene with one).
    single: tuple[float, float]
    #: Names of the scenes.
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class GridParts:
    """Discretisation of the finest level and a next one together [% of the mean load], RMS over the contacts.

    With a single level only the uncertainty is known, from experience; the parts are None.
    """

    #: Uncertainty at 95 %; zero without load.
    bar: float
    #: Standard deviation by the cells of the contact.
    contact: float | None = None
    #: Standard deviation by the cells of the bodies.
    bodies: float | None = None
    #: Standard deviation by the cut of the sockets.
    sockets: float | None = None
    #: Standard deviation of an error that all contacts share.
    common: float | None = None
    #: Factor of the uncertainty over the root of the sum of squares of the parts.
    cover: float = COVER

    @property
    def by_experience(self) -> bool:
        """Whether the uncertainty is that of a single level, taken from experience."""
        return self.contact is None

    def bars(self, loads: Levelled) -> Array:
        """Return the uncertainty at 95 % of each contact, (n, 4) [% of the mean load]; zero where no level has load."""
        on = loaded_on_any_level(loads)
        if self.contact is None or self.bodies is None or self.sockets is None or self.common is None:
            return np.where(on, self.bar, 0.0)
        stiffness = loads[max(loads)] ** STIFFNESS
        share = stiffness**2 / (stiffness[on] ** 2).mean()
        displaced, shared = self.bodies**2 + self.sockets**2, self.contact**2 + self.common**2
        return np.where(on, self.cover * np.sqrt(shared + displaced * share), 0.0)


def both_flanks(load: Array) -> bool:
    """Return whether both flanks of the screw carry load (n, 4); then equilibrium does not fix the sum of loads."""
    return bool((load[:, :2] > 0.0).any(axis=0).all())


def loaded_on_any_level(loads: Levelled) -> Array:
    """Return a mask (n, 4) of the contacts that carry load on any mesh level."""
    return np.asarray(np.max([loads[k] for k in loads], axis=0) > 0.0)


def parts(loads: Levelled, known: Experience) -> GridParts:
    """Compute the parts of the discretisation uncertainty from loads on several levels and from experience.

    Parameters
    ----------
    loads
        Contact loads (n, 4) [N] by level.
    known
        Experience with compared scenes.

    Returns
    -------
    GridParts
        The parts.
    """
    levels = sorted(loads)
    finest, both = levels[-1], both_flanks(loads[levels[-1]])
    if not (loads[finest] > 0.0).any():
        return GridParts(0.0)
    if len(levels) == 1:
        return GridParts(known.single[both])
    steps, fixed = list(pairwise(levels)), 2.0 * known.sockets**2
    shown = np.array([float((_load_change(loads, a, b, finest) ** 2).mean()) for a, b in steps])
    amounts = _fit_variances(np.array([_variance_factors(a, b) for a, b in steps]), np.maximum(shown - fixed, 0.0), fixed)
    left = (*(amounts * _variance_factors(finest, finest + 1)), fixed, 2.0 * known.common**2 if both else 0.0)
    cover = COVER_OF_ONE_CHANGE if levels == [finest - 1, finest] else COVER
    contact, bodies, sockets, common = (float(np.sqrt(v)) for v in left)
    return GridParts(cover * float(np.sqrt(sum(left))), contact, bodies, sockets, common, cover)


def _load_change(loads: Levelled, level: int, other: int, finest: int) -> Array:
    """Return the changes of the loaded contacts from one level to another [% of the mean load on ``finest``]."""
    on = loaded_on_any_level(loads)
    return np.asarray(error_percent(loads[other][on], loads[level][on], mean_load(loads[finest])))


def _cell_sizes(level: int) -> Array:
    """Return a level's relative cell sizes of contact and bodies, (2,); beyond the last level by ``NEXT``."""
    last = max(LEVELS)
    cells = LEVELS[min(level, last)]
    size = np.array([1.0 / cells["b_over_h"], cells["fine"] / LEVELS[PRODUCTION]["fine"]])
    return np.asarray(size * np.power(NEXT, max(level - last, 0)))


def _variance_factors(level: int, other: int) -> Array:
    """Return the variances of the difference between two levels, for contact and bodies, if their amounts are one."""
    return np.asarray(_cell_sizes(level) ** (2 * ORDER) + _cell_sizes(other) ** (2 * ORDER))


def _fit_variances(columns: Array, shown: Array, fixed: float) -> Array:
    """Fit the variances of contact and bodies to the variances observed between levels, by relative least squares.

    ``fixed`` is a known further variance. Results are at least zero; with two levels all is attributed to the bodies,
    whose part falls more slowly.
    """
    from scipy.optimize import nnls

    columns = columns * [0.0, 1.0] if len(shown) == 1 else columns
    variances, scale = np.zeros(2), np.maximum(shown + fixed, TINY)
    for _ in range(ROUNDS):
        variances = nnls(columns / scale[:, None], shown / scale)[0]
        scale = np.maximum(columns @ variances + fixed, TINY)
    return np.asarray(variances)


def derive_experience(
    scenes: Mapping[str, Levelled], sockets: float, known: Mapping[str, Array] | None = None
) -> Experience:
    """Derive the experience with mesh errors from scenes solved on several levels.

    Parameters
    ----------
    scenes
        Contact loads by level, for each scene.
    sockets
        Standard deviation by the cut of the sockets [% of the mean load], from a separate run.
    known
        Errors of the coarsest level with a separate uncertainty (`error_near_faces`), (n, 4) [% of the mean load] by scene.

    Returns
    -------
    Experience
        The experience.

    Raises
    ------
    ValueError
        Without a scene of each kind.
    """
    shifts, errors = list[float](), (list[Array](), list[Array]())
    for name, loads in scenes.items():
        levels, finest = sorted(loads), max(loads)
        both = both_flanks(loads[finest])
        if both:
            shifts += [float(_load_change(loads, a, b, finest).mean()) for a, b in pairwise(levels) if a >= PRODUCTION]
        if levels[0] == min(LEVELS) and finest >= PRODUCTION:
            held = known[name][loaded_on_any_level(loads)] if known and name in known else 0.0
            errors[both].append(np.maximum(np.abs(_load_change(loads, levels[0], finest, finest)) - held, 0.0))
    if not shifts or not all(errors):
        raise ValueError("no experience without scenes that load one flank of the screw, and both, on fine levels")
    common = float(np.sqrt(np.mean(np.square(shifts)) / 2.0))
    return Experience(
        sockets, common, (_covering_bound(errors[0], LEAST[0]), _covering_bound(errors[1], LEAST[1])), tuple(scenes)
    )


def _covering_bound(errors: Sequence[Array], least: float) -> float:
    """Return the bound that covers ``SHARE`` of all errors, and the share ``least`` of each scene's errors."""
    return float(max(np.quantile(np.concatenate(errors), SHARE), *(np.quantile(of_scene, least) for of_scene in errors)))


def save_experience(store: Path, known: Experience) -> None:
    """Write the experience to a store; OSError if the file cannot be written."""
    replace_file(store / FILE, json.dumps(asdict(known), indent=1) + "\n")


@cache
def read_experience(store: Path) -> Experience:
    """Read the experience from a store; OSError, ValueError, KeyError or TypeError if the file cannot be used."""
    data = json.loads((store / FILE).read_text(encoding="utf-8"))
    one, both = (float(x) for x in data["single"])
    return Experience(float(data["sockets"]), float(data["common"]), (one, both), tuple(data["scenes"]))


LIP_FILE = "near_face.json"

#: Distance [ball radii] beyond which a face has no influence; linear to zero from the last measured one.
AWAY = 3.0

#: Smallest distance to which the influence is extrapolated [ball radii]; closer to a face no socket can be meshed.
CLOSER = 0.25

#: Approach [m] below which there is no load.
NO_STIFFNESS = 1e-30

#: Flanks of the nut that are pressed towards its low and its high face.
TOWARDS = (2, 3)


@dataclass(frozen=True)
class LipCompliance:
    """Compliance of the nut's lip between a contact and a free face, by the distance of the contact."""

    #: Distances from the face [ball radii], rising.
    radii: Array
    #: Compliance of the lip, times Young's modulus and ball radius.
    lip: Array
    #: The part that a level neglects, by level.
    missing: dict[int, Array]

    def at(self, radii: Array, level: int) -> tuple[Array, Array]:
        """Return the lip's compliance at distances [ball radii], and the part of it that a level neglects."""
        missing = self.missing[min(max(level, 1), max(self.missing))]
        return np.interp(radii, self.radii, self.lip), np.interp(radii, self.radii, missing)


@cache
def read_lip(store: Path) -> LipCompliance:
    """Read the compliance of lips from a store.

    It is measured on one scene on all levels; the missing part is raised by the largest ratio of any other scene. Values
    are extrapolated closer to the face from the two nearest distances, and to zero further away. OSError, ValueError or
    KeyError if the file is missing or damaged.
    """
    rows = json.loads((store / LIP_FILE).read_text(encoding="utf-8"))
    first = [row for row in rows if row["scene"] == rows[0]["scene"]]
    radii = np.array([row["radii"] for row in first])
    step = CLOSER / (radii[1] - radii[0])

    def ended(values: list[float]) -> Array:
        return np.array([values[0] + step * (values[0] - values[1]), *values, 0.0])

    missing = {int(k): [row["missing"][k] for row in first] for k in first[0]["missing"]}
    spread = max(row["missing"]["1"] / np.interp(row["radii"], radii, missing[1]) for row in rows)
    places = np.array([radii[0] - CLOSER, *radii, AWAY])
    return LipCompliance(
        places, ended([row["lip"] for row in first]), {k: spread * ended(values) for k, values in missing.items()}
    )


def excess_near_faces(scene: Scene, load: Array, level: int) -> Array:
    """Return the largest excess (n, 4) [N] of a level's contact loads (n, 4) [N] due to free faces of the nut."""
    from rollbench.hifi.meshing.settings import hertz_units

    out = np.zeros_like(load)
    if scene.solid.nut != "elastic" or scene.track.lead == 0.0:
        return out
    r, held = scene.balls.radius, solid_dimensions(scene).nut_held
    z, half = ball_layout(scene).z - scene.nut.position, scene.nut.length / 2.0
    soft = [2.0 / 3.0 * unit.approach for unit in hertz_units(scene)]
    known, unit = read_lip(shipped_store()), 1.0 / (scene.nut.material.youngs_modulus * r)
    for side, face, away in ((TOWARDS[0], "left face", half + z), (TOWARDS[1], "right face", half - z)):
        if held in (face, "both faces"):
            continue
        lip, missing = (unit * x for x in known.at(away / r, level))
        for flank in (side, 3 - side):
            force = load[:, flank]
            springs = (soft[side] + soft[3 - side]) * np.cbrt(force) ** 2  # force times their tangent
            added = force**2 * missing / np.maximum(springs + lip * force, NO_STIFFNESS)
            out[:, flank] = np.maximum(out[:, flank], added)
    return out


def error_near_faces(scene: Scene, load: Array, level: int) -> Array:
    """Return the largest error (n, 4) [N] of a level's contact loads (n, 4) [N] due to free faces of the nut.

    If equilibrium fixes the sum of loads, the other contacts of the same flank have errors too.
    """
    excess = excess_near_faces(scene, load, level)
    if both_flanks(load) or not excess.any():
        return excess
    stiffness = load**STIFFNESS
    return np.asarray(excess + excess.sum(axis=0) * stiffness / np.maximum(stiffness.sum(axis=0), NO_STIFFNESS))
