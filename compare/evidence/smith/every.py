"""Smith (1994): the findings of all chapters, computed once."""

from __future__ import annotations

from functools import cache

from compare.evidence.smith import ball, screw, taper, trials
from compare.models.study import Study
from compare.printed.findings import Finding


@cache
def _every() -> tuple[Finding, ...]:
    return (*ball.findings(), *taper.findings(), *screw.findings(), *trials.findings())


def findings(study: Study) -> list[Finding]:  # noqa: ARG001 - every chapter's findings take the study
    """Every printed entry of Smith (1994)."""
    return list(_every())
