"""What the stability table of friction counts: a record per group of cases, and its tally while they are solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.as_source.chain import SourceMotion
from rollbench.meshes.arrays import Array

#: Sharpness of the source's sigmoid, Lin's k_S, in its own formulation; 100 where it is not what is varied.
SHARPNESS = (100.0, 1e3, 1e4)
#: Random starts of one ball and of chains, besides the solver's own; how far they are off the solution, relative.
STARTS, CHAIN_STARTS, NEAR_START, FAR_START = 12, 3, 0.01, 0.5
#: Power [W] and, over the friction bound, ball-to-ball force below which random starts and balances are not scaled.
NO_POWER, NO_FORCE = 1e-13, 0.01
ANGLES, MU, LOADS = (-5.0, -1.0, 1e-3, 2.0, 5.0), (1e-3, 0.01, 0.1, 0.3, 0.5), (1e-3, 0.1, 10.0, 1e3, 1e5)
RHO, CLEARANCE = (-0.999, -0.9, -0.3, 0.3, 0.9, 0.999), (1e-7, 1e-6, 5e-6, 1e-5)
#: Small axial loads [N] of pairs of a screw with clearance.
SMALL = (1e-3, 1e-2, 0.1, 0.3)
#: Sizes of the chains, of a linear bearing and of a ball screw.
BALLS = (2, 5, 10, 20, 50, 100, 200)
#: Largest chain that the source's method is tried on, in the groups of chains over friction.
SOURCE_BALLS = 20
#: Fraction of the contacts without load in the chains that lack some.
UNLOADED = 0.25
#: Difference of ball-to-ball force over the friction bound from which a root of the source's is another answer.
OTHER = 1e-3


@dataclass(frozen=True)
class Record:
    """One group of cases.

    ours, tries: solutions of the solvers here that converged, and all that were tried; energy: largest relative excess of
    power in over dissipation; spread: largest difference of the answers from several starts, relative (loss of one ball,
    ball-to-ball forces of more); source, source_tries: roots found by the source's method and tried, None where it has no
    such model.
    """

    group: str
    model: str
    cases: int
    ours: int
    tries: int
    energy: float
    spread: float
    source: int | None = None
    source_tries: int | None = None
    note: str = ""


@dataclass
class Tally:
    """Counts of a group as its cases are solved."""

    cases: int = 0
    ours: int = 0
    tries: int = 0
    energy: float = 0.0
    spread: float = 0.0
    source: int = 0
    source_tries: int = 0
    direct: int = 0
    restarts: int = 0
    overlapping: int = 0
    other: int = 0

    def theirs(self, found: SourceMotion | None, force: Array, bound: float) -> None:
        """Count one run of the source's method (None: it found no loads) against the ball-to-ball forces found here [N];
        bound [N].

        Solved: a root whose balls neither overlap nor pull. ``other`` counts those that are not our answer.
        """
        self.source_tries += 1
        if found is None or found.status == "failed":
            return
        self.overlapping += found.status == "overlapping"
        if found.status == "exact":
            self.source += 1
            self.other += float(np.max(np.abs(found.ball_force - force), initial=0.0)) > OTHER * (bound or 1.0)

    def add(self, good: bool, power: float, loss: float, apart: float) -> None:
        """One solution: whether it converged, power in and dissipation [W], difference from the first, relative."""
        self.tries += 1
        self.ours += good
        self.energy = max(self.energy, abs(power - loss) / max(loss, NO_POWER))
        self.spread = max(self.spread, apart)

    def record(self, group: str, model: str, note: str = "") -> Record:
        """The group's record."""
        tried = self.source_tries or None
        if self.restarts:
            led = f"{self.direct} of {self.restarts} random starts led there by themselves"
            note = f"{note}; {led}" if note else led
        for count, what in ((self.overlapping, "let balls overlap"), (self.other, "differ from the answer found here")):
            if count:
                roots = f"roots of the source's that {what}: {count}"
                note = f"{note}; {roots}" if note else roots
        return Record(
            group,
            model,
            self.cases,
            self.ours,
            self.tries,
            self.energy,
            self.spread,
            self.source if tried else None,
            tried,
            note,
        )
