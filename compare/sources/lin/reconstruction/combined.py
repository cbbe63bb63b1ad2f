"""Every combination of readings: largest over smallest load of both models, and the errors of one against the other.

Inference, and said to be so: the readings are judged by the ratio that the text prints for both models, "about 1.34", and
by nothing else; the four printed errors are then predicted by those that meet it. No model reads a printed number.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rollbench.comparison.measure import load_error
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.sources.lin.reconstruction.readings import CASES, LOW, Combination, key_of, low_scene, together
from rollbench.comparison.sources.lin.reconstruction.runs import stored, wanted
from rollbench.comparison.sources.lin.reconstruction.scatter import SCATTER, drawn_errors
from rollbench.meshes.arrays import Array

#: "About 1.34", said of two models at once: each from 1.32 to 1.36.
ABOUT = 0.015
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

    def meets(self, about: float = ABOUT) -> bool:
        """Whether both models have the printed ratio within a share."""
        aim = printed_ratio()
        return all(abs(r - aim) <= about * aim for r in (self.low_ratio, self.solid_ratio))

    @property
    def against_text(self) -> bool:
        """Whether the text speaks against a reading."""
        return any(r.by_text for r in (*self.low, *self.solid))


def printed_ratio() -> float:
    """The ratio that the text prints for both models."""
    value = entry("lin-2.4.1", "case1_ratio").value
    assert value is not None
    return value


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


def solid_loads(study: Study, readings: Combination) -> tuple[Array, ...]:
    """Loads of the cases by the 3D model. Raises LookupError where a run is missing."""
    return study.once(_solid_loads, readings)


def _solid_loads(study: Study, readings: Combination) -> tuple[Array, ...]:  # noqa: ARG001 - as `Study.once` calls it
    found = stored(readings)
    if found is None:
        raise LookupError(f"no run of {key_of(readings)}: python -m {__package__}")
    return found


def combinations(study: Study) -> list[Combined]:
    """All combinations, the defaults first. Raises LookupError where a run is missing."""
    low = [(c, low_loads(study, c)) for c in low_readings()]
    solid = [(c, solid_loads(study, c)) for c in wanted()]
    return [Combined(a, b, ratio(x[0]), ratio(y[0]), errors(x, y)) for a, x in low for b, y in solid]


@dataclass(frozen=True)
class Predicted:
    """What the combinations that meet the ratio say of one printed error [%]: printed, the prediction of the one whose
    ratios are nearest, range over all of them, and that range with the scatter of the source's mesh (5 to 95 %)."""

    key: str
    printed: float
    nearest: float
    low: float
    high: float
    meshed_low: float
    meshed_high: float

    @property
    def comes_out(self) -> bool:
        """Whether the printed number lies within the range, with the scatter of the mesh."""
        return self.meshed_low <= self.printed <= self.meshed_high


def meeting(found: list[Combined], about: float = ABOUT) -> list[Combined]:
    """Combinations that meet the ratio within a share and that the text does not speak against, the nearest first."""
    aim = printed_ratio()
    good = [c for c in found if c.meets(about) and not c.against_text]
    return sorted(good, key=lambda c: np.hypot(c.low_ratio - aim, c.solid_ratio - aim))


def predicted(study: Study, definition: Definition) -> list[Predicted]:
    """The four printed errors as predicted by the combinations that meet the ratio."""
    good = meeting(study.once(combinations))
    drawn = [
        np.percentile(
            drawn_errors(low_loads(study, c.low), solid_loads(study, c.solid), SCATTER, of_load=definition == "own"),
            [5.0, 95.0],
            axis=0,
        )
        for c in good
    ]
    meshed_low, meshed_high = np.min(drawn, axis=0)[0], np.max(drawn, axis=0)[1]
    out = []
    for k, key in enumerate(ERRORS):
        values = [c.errors[definition][k] for c in good]
        printed = printed_error(key)
        meshed = float(meshed_low[k]), float(meshed_high[k])
        out.append(Predicted(key, printed, values[0], min(values), max(values), *meshed))
    return out


def printed_error(key: str) -> float:
    """A printed error [%]."""
    value = entry("lin-2.4.1", key).value
    assert value is not None
    return value


def all_four(found: list[Combined], within: float) -> list[Combined]:
    """Combinations, of any ratio, with all four errors by one definition within ``within`` per cent (points) of the
    printed ones."""
    aim = np.array([printed_error(key) for key in ERRORS])
    return [c for c in found if min(np.abs(np.array(c.errors[d]) - aim).max() for d in DEFINITIONS) <= within]
