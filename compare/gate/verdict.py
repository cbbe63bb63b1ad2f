"""Whether loads agree with a reference within a limit, the reference's own uncertainty counted openly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from rollbench.comparison.measure import LoadError, load_error
from rollbench.comparison.models.comparison import RULE, gate_points
from rollbench.comparison.reference.estimate import Reference
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES

Word = Literal["pass", "fail", "not converged", "undecided", "not covered"]

#: Limit [%] where neither the command line nor the scene gives one.
LIMIT = 7.0
#: Exit code of each verdict; of several verdicts the first of these counts.
CODES: dict[Word, int] = {"fail": 1, "not converged": 1, "undecided": 3, "not covered": 4, "pass": 0}
LARGEST = "largest error of a contact load"
RMS = "RMS error of the contact loads"
#: What is said where the reference has one mesh level.
ONE_LEVEL = "one mesh level: its uncertainty is from experience with other scenes; --levels 2 or 3 gives its own"


@dataclass(frozen=True)
class Limits:
    """Limits in per cent: of the largest error of a contact load (of its own reference load, of the mean where that is
    small), and of the RMS error (of the mean load; None: not judged)."""

    largest: float = LIMIT
    rms: float | None = None


@dataclass(frozen=True)
class Verdict:
    """One judgement: scene, whose loads, which quantity; error, the reference's uncertainty in the same per cent (None: not
    known) and the limit; ball (from 1) and flank that decide; mesh levels of the reference; contacts that were judged;
    of_mean: the errors that head every output, in per cent of the mean load of the loaded contacts; set: its name, where
    several are on one shaft; case: of the scene's load cases."""

    scene: str
    judged: str
    quantity: str
    word: Word
    error_percent: float | None
    uncertainty_percent: float | None
    limit_percent: float
    ball: int | None = None
    flank: str | None = None
    levels: tuple[int, ...] = ()
    contacts: int = 0
    detail: str = ""
    of_mean: LoadError | None = None
    set: str | None = None
    case: str | None = None

    @property
    def of(self) -> str:
        """Scene and set or case, in words."""
        inner = self.set or (self.case and f"case {self.case}")
        return f"{self.scene}, {inner}" if inner else self.scene

    def as_json(self) -> dict[str, Any]:
        """JSON-ready."""
        data = asdict(self) | {"levels": list(self.levels)}
        for key in ("set", "case"):
            if data[key] is None:
                del data[key]
        e = data.pop("of_mean")
        both = ("max_percent", "rms_percent")
        return data | {f"{key}_of_mean": None if e is None else e[key] for key in both}

    def line(self) -> str:
        """The verdict as one line of text, with both numbers and the limit."""
        head = f"{self.word.upper()}: {self.of}, {self.judged}"
        if self.error_percent is None:
            return f"{head}: {self.detail}"
        at = "" if self.ball is None else f" (ball {self.ball} {self.flank})"
        tail = f"; {self.detail}" if self.detail else ""
        if self.of_mean is None:
            return f"{head}: {self.quantity} {self.compared()}{at}{tail}"
        e = self.of_mean
        first = f"{e.max_percent:.2f} % of the mean load on the worst contact (ball {e.ball} {e.side})"
        return f"{head}: {first}, {e.rms_percent:.2f} % RMS; {self.quantity} {self.compared()}{at}, {RULE}{tail}"

    def compared(self) -> str:
        """Error, uncertainty and limit as a comparison: ``1.4 % + 0.2 % <= 7 %``."""
        error, limit = abs(self.error_percent or 0.0), f"{self.limit_percent:g} %"
        if self.uncertainty_percent is None:
            return f"{error:.2f} %, uncertainty not known, limit {limit}"
        u = f"{self.uncertainty_percent:.2f} %"
        if self.word == "pass":
            return f"{error:.2f} % + {u} <= {limit}"
        return f"{error:.2f} % - {u} > {limit}" if self.word == "fail" else f"{error:.2f} % +- {u}, limit {limit}"


def word(error: float, uncertainty: float | None, limit: float) -> Word:
    """Pass where error + uncertainty is within the limit, fail where error - uncertainty is beyond it, undecided between,
    and where the uncertainty is not known. All in per cent.

    >>> word(-6.0, 0.5, 7.0), word(6.8, 0.5, 7.0), word(8.0, 0.5, 7.0)
    ('pass', 'undecided', 'fail')
    """
    if uncertainty is None:
        return "undecided"
    if abs(error) + uncertainty <= limit:
        return "pass"
    return "fail" if abs(error) - uncertainty > limit else "undecided"


def judge(
    judged: str, load: Array, found: Reference, limits: Limits, flanks: Sequence[str] = SIDES, detail: str = ""
) -> list[Verdict]:
    """Verdicts on loads ``(n, 4)`` [N] against a reference: on the largest error, and on the RMS error if it has a limit.

    flanks: the sides that are judged; what the others carry is no part of any error. The contact named is the one that
    decides: the first to fail, or the one nearest to it.
    """
    chosen = np.array([side in flanks for side in SIDES])
    levels = tuple(run.level for run in found.runs)
    points = [p for p in gate_points(found.scene, found, limits.largest, load) if p.side in flanks]
    one = ONE_LEVEL if found.parts.by_experience else ""
    detail = "; ".join(part for part in (detail, found.unsettled, one) if part)
    of_mean = load_error(np.where(chosen, load, 0.0), np.where(chosen, found.load, 0.0), found.contacts)
    shared = {"levels": levels, "contacts": len(points), "detail": detail}
    if not points:
        why = f"the reference carries no load on {', '.join(flanks)}"
        return [Verdict(found.scene, judged, LARGEST, "not covered", None, None, limits.largest, levels=levels, detail=why)]

    def verdict_of(k: int) -> Verdict:
        p = points[k]
        bar = abs(p.uncertainty_percent) if np.isfinite(p.uncertainty_percent) else None
        own = word(p.error_percent, bar, limits.largest)
        return Verdict(
            found.scene,
            judged,
            LARGEST,
            own,
            p.error_percent,
            bar,
            limits.largest,
            p.ball,
            p.side,
            of_mean=of_mean,
            **shared,  # type: ignore[arg-type]
        )

    each = [verdict_of(k) for k in range(len(points))]
    worst = worst_of([v.word for v in each])
    sign = -1.0 if worst == "fail" else 1.0
    out = [
        max(
            (v for v in each if v.word == worst),
            key=lambda v: abs(v.error_percent or 0.0) + sign * (v.uncertainty_percent or 0.0),
        )
    ]
    if limits.rms is not None:
        error, bar = of_mean.rms_percent, found.parts.bar
        out.append(
            Verdict(found.scene, judged, RMS, word(error, bar, limits.rms), error, bar, limits.rms, **shared)  # type: ignore[arg-type]
        )
    return out


def worst_of(words: Sequence[Word]) -> Word:
    """The verdict on several: the first of them in the order of `CODES`."""
    return next((w for w in CODES if w in words), "pass")
