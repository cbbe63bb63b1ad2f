"""Every combination of readings: largest over smallest load of both models, the errors, and the scatter of meshes.

Six numbers are printed: the ratio, "about 1.34", of both models, and four errors of one against the other. Each combination
is shown with what it misses of them; no tolerance decides which of them are met, and none is taken for what the source
did. No model reads a printed number.

A contact of case 1 is meshed as the source says, by first-order tetrahedra of about 0.08 mm, with several sizes near
that: each is another unstructured mesh. Its approach, with what it falls by with the size taken out, scatters by some share
s. A ball's load then changes as by a closure of s times the approach at each of its contacts, and what a closure does is
seen in case 2, whose ball 17 is 1 um too large in radius: closed by 1 um at both contacts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rollbench.compare.cases.lin.reconstruction.readings import (
    CASES,
    LOW,
    Combination,
    key_of,
    low_scene,
    stored_runs,
    together,
    wanted,
)
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import value_of
from rollbench.compare.reference.store import Run
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import nominal_hertz
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load

#: Ball of case 2 that is too large, and by how much [m] in radius.
LARGE, OVERSIZE = 16, 1e-6
#: Drawn pairs of meshes of case 1 and case 2.
DRAWN = 5000
#: Approach of such a contact by Hertz [m], mean error of the approach on meshes of about the source's size, and scatter [%]
#: of one contact between two bodies meshed apart: measured by `tests/sources/lin/literature/test_reconstruction.py`.
APPROACH, BIAS, SCATTER = 6.4839e-6, -4.4, 0.33


def share_of_closure(solid: tuple[Array, ...]) -> float:
    """Relative change of a ball's load over that of one of its approaches, from loads of cases 1 and 2 in 3D ``(n, 4)``."""
    before, after = (load[LARGE, 0] for load in solid)
    return float((after / before - 1.0) * 0.5 * APPROACH / OVERSIZE)


def drawn_errors(low: tuple[Array, ...], solid: tuple[Array, ...], percent: float, *, of_load: bool = True) -> Array:
    """Largest and RMS error of case 1, then of case 2, ``(DRAWN, 4)`` [%], with every contact's approach scattered by
    ``percent``, the two cases meshed apart; loads ``(n, 4)`` [N] of both; of_load: of each load, else of the mean load.

    Of both flanks the screw's: a ball in two-point contact has one load.
    """
    rng, share, out = np.random.default_rng(1), share_of_closure(solid), []
    for a, b in zip(low, solid, strict=True):
        change = 0.01 * percent * share * rng.normal(size=(DRAWN, len(b), 2)).sum(axis=2)
        meshed = b[:, 0] * (1.0 - change)
        meshed *= b[:, 0].sum() / meshed.sum(axis=1, keepdims=True)  # the axial force is the same
        errors = np.asarray(error_percent(a[:, 0], meshed, None if of_load else meshed.mean(axis=1, keepdims=True)))
        out += [np.abs(errors).max(axis=1), np.sqrt((errors**2).mean(axis=1))]
    return np.stack(out, axis=1)


def probability(errors: Array, falls: float, rises: float) -> float:
    """Share of `drawn_errors` whose largest error falls and whose RMS rises by so much [%] or more from case 1 to 2."""
    return float(((errors[:, 0] - errors[:, 2] >= falls) & (errors[:, 3] - errors[:, 1] >= rises)).mean())


# --- every combination of readings: largest over smallest load of both models, and the errors of one against the other


#: Readings of the low-order model that move the ratio by more than 0.5 %.
LOW_MOVERS = ("squared", "full", "source", "printed")
#: Errors in per cent of each contact's own load, or of the mean load.
Definition = Literal["own", "mean"]
DEFINITIONS: tuple[Definition, ...] = ("own", "mean")
#: The printed errors, in the order of `Combined.errors`.
ERRORS = ("case1_max_error", "case1_rms_error", "case2_max_error", "case2_rms_error")


@dataclass(frozen=True)
class Combined:
    """Readings of both models with the ratios of case 1, and the four errors [%] by definition."""

    low: Combination
    solid: Combination
    low_ratio: float
    solid_ratio: float
    errors: dict[Definition, tuple[float, ...]]

    @property
    def misses(self) -> Array:
        """What it misses of the printed numbers: both ratios [%], four errors of each contact's own load [points]."""
        ratios = error_percent(np.array([self.low_ratio, self.solid_ratio]), printed_ratio())
        return np.concatenate([ratios, np.array(self.errors["own"]) - np.array(printed_errors())])

    @property
    def against_text(self) -> bool:
        """Whether the text speaks against a reading."""
        return any(r.by_text for r in (*self.low, *self.solid))


def printed_ratio() -> float:
    """The ratio that the text prints for both models."""
    return value_of("lin-2.4.1", "case1_ratio")


def ratio(load: Array) -> float:
    """Largest over smallest load of SL."""
    return float(load[:, 0].max() / load[:, 0].min())


def errors(low: tuple[Array, ...], solid: tuple[Array, ...]) -> dict[Definition, tuple[float, ...]]:
    """Largest and RMS error of cases 1 and 2 [%] by definition; loads ``(n, 4)`` [N] of both cases."""
    found = [load_error(a, b) for a, b in zip(low, solid, strict=True)]
    of_load = tuple(x for e in found for x in (e.own_max_percent, e.own_rms_percent))
    return {"own": of_load, "mean": tuple(x for e in found for x in (e.max_percent, e.rms_percent))}


def low_readings() -> list[Combination]:
    """Combinations of the low-order model: none, every reading alone, pairs and triples of `LOW_MOVERS`."""
    movers = tuple(r for r in LOW if r.key in LOW_MOVERS)
    return [*together(LOW, 1), *(c for c in together(movers, 3) if len(c) > 1)]


def low_loads(study: Study, readings: Combination) -> tuple[Array, ...]:
    """Loads of the cases by the low-order model."""
    return tuple(study.solve(low_scene(catalogue.scene(c), readings), "lin").load for c in CASES)


def solid_loads(study: Study, readings: Combination, level: int | None = None) -> tuple[Array, ...]:
    """Loads of the cases by the 3D model, on their mesh level unless another is given. Raises LookupError where a run is
    missing."""
    return tuple(run.load for run in study.once(_runs, readings, level))


def _runs(study: Study, readings: Combination, level: int | None = None) -> tuple[Run, ...]:  # noqa: ARG001 - for `Study.once`
    found = stored_runs(readings, level)
    if found is None:
        raise LookupError(f"no run of {key_of(readings)}: python -m {__package__}")
    return found


def combinations(study: Study) -> list[Combined]:
    """All combinations, the defaults first. Raises LookupError where a run is missing."""
    low = [(c, low_loads(study, c)) for c in low_readings()]
    solid = [(c, solid_loads(study, c)) for c in wanted()]
    return [Combined(a, b, ratio(x[0]), ratio(y[0]), errors(x, y)) for a, x in low for b, y in solid]


def printed_errors() -> tuple[float, ...]:
    """The four printed errors [%]."""
    return tuple(value_of("lin-2.4.1", key) for key in ERRORS)


def nearest(found: list[Combined], first: int = 6) -> Combined:
    """The combination that the text does not speak against with the smallest root mean square of its ``first`` misses: 2,
    of the ratios; 6, of all that is printed."""
    allowed = [c for c in found if not c.against_text]
    return min(allowed, key=lambda c: float(np.linalg.norm(c.misses[:first])))


def without_penalty(found: list[Combined]) -> list[Combined]:
    """Combinations whose contacts do not penetrate."""
    return [c for c in found if not any(r.penalty for r in c.solid)]


def explanations(found: list[Combined]) -> dict[str, Combined]:
    """Combinations that are shown one by one, in words: the defaults, the nearest in the printed ratio (without a penalty,
    one of which gives any ratio), softer contacts with all else by default, the nearest in all that is printed."""
    softer = {
        f"penalty of the 3D contacts: {c.solid[0].label}": c for c in found if not c.low and any(r.penalty for r in c.solid)
    }
    return {
        "all by default": found[0],
        "nearest in the ratio, no penalty": nearest(without_penalty(found), 2),
        **softer,
        "nearest in all six": nearest(found),
    }


def softened(study: Study, readings: Combination) -> float:
    """What a penalty adds to the approach of a contact, by Hertz under the mean load, as a share of it.

    By the shaft's axial motion in case 1, which both contacts of a ball add to: the force on it is the same, and so, on
    the mean, is what its bodies do.
    """
    scene = catalogue.scene(CASES[0])
    still, moved = (study.once(_runs, r)[0] for r in ((), readings))
    track = scene.track
    lead = np.arctan(track.lead / (2.0 * np.pi * track.pitch_radius))
    added = (
        0.5 * float((moved.centreline[:, 3] - still.centreline[:, 3]).mean()) * np.sin(track.contact_angle) * np.cos(lead)
    )
    load = mean_load(still.load)
    return float(added / (np.mean(nominal_hertz(scene).C[[0, 3]]) * load ** (2.0 / 3.0)))
