"""Records that `rollbench.check` returns: whether the contact loads of a scene agree with a reference within a limit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rollbench.compare.gate.publish import row_for_load_chart, worst_ball_figure
from rollbench.compare.gate.user import GateRequest, check_scenes
from rollbench.compare.gate.verdict import (
    CODES,
    LARGEST,
    Judgement,
    VerdictRow,
    quantities_without_verdict,
    worst_judgement,
)
from rollbench.compare.models.comparison import RULE
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version
from rollbench.compare.scenes.duty_cycle import Described, LoadCaseOfDutyCycle, load_cases_by_scene_name
from rollbench.compare.scenes.scene_file import scenes_to_solve
from rollbench.reports.content import Figure

#: Advice to the user for each judgement that is not "pass".
ADVICE = {
    "fail": "compare every contact with its reference: rollbench compare SCENE --balls",
    "not converged": "see why there is no equilibrium: rollbench solve SCENE",
    "undecided": "reduce the uncertainty of the reference by more mesh levels: --levels 3",
    "not covered": "compute the 3D reference: --levels 2",
}


@dataclass(frozen=True, repr=False, eq=False)
class Verdict(TabularRecord):
    """Judgement of contact loads and other quantities of scenes against their reference, with a row for each quantity.

    A verdict is true if all rows pass, and false if one fails, is undecided or is not covered.

    Examples
    --------
    >>> import rollbench
    >>> assert rollbench.check("lin-case1")
    >>> verdict = rollbench.check("lin-case1", model="lin")
    >>> verdict.passed, verdict.worst.ball, verdict.worst.side
    (False, 31, 'SL')
    """

    rows: tuple[VerdictRow, ...]
    """Judgement of every quantity, in the order of scenes, load cases, and nuts and bearings."""
    warnings: tuple[str, ...]
    """Warnings, such as those about unknown columns of a file."""
    not_judged: tuple[str, ...]
    """Quantities that are not judged, because the user's file or the reference does not contain them."""
    described: tuple[Described, ...]
    """The judged scenes."""

    @property
    def judgement(self) -> Judgement:
        """Worst judgement of all rows."""
        return worst_judgement([row.judgement for row in self.rows])

    @property
    def passed(self) -> bool:
        """Whether all rows pass."""
        return bool(self.judgement)

    def __bool__(self) -> bool:
        """Whether all rows pass (`passed`), for ``assert rollbench.check(...)``."""
        return self.passed

    @property
    def worst(self) -> VerdictRow | None:
        """Row that determines the verdict; None without rows.

        Of the rows with the worst judgement, it is the one with the largest ratio of error to limit.
        """
        gravest = [row for row in self.rows if row.judgement is self.judgement]
        return max(gravest, key=lambda row: abs(row.error or 0.0) / row.limit, default=None)

    @property
    def cases(self) -> list[tuple[LoadCaseOfDutyCycle, Verdict]]:
        """Load cases of the judged scenes, each with the verdict on it; empty without load cases."""
        out = []
        for case in load_cases_by_scene_name(self.described).values():
            names = case.duty_cycle.name, case.load_case.name
            out.append((case, replace(self, rows=tuple(row for row in self.rows if (row.scene, row.case) == names))))
        return out

    @property
    def worst_cases(self) -> list[tuple[LoadCaseOfDutyCycle, Verdict]]:
        """Load case that determines the verdict on each scene, with the verdict on the case; the worst case first."""
        found: dict[str, tuple[LoadCaseOfDutyCycle, Verdict]] = {}
        for case, one in sorted(self.cases, key=lambda pair: pair[1]._graveness):
            found.setdefault(case.duty_cycle.name, (case, one))
        return [*found.values()]

    @property
    def _graveness(self) -> tuple[int, float]:
        """Order among verdicts, the worst first: by judgement, then by the largest ratio of error to limit."""
        ratios = (abs(row.error or 0.0) / row.limit for row in self.rows)
        return [*CODES].index(self.judgement), -max(ratios, default=0.0)

    @property
    def word(self) -> str:
        """Worst judgement of all rows as text, such as "undecided"."""
        return self.judgement.value

    def to_dict(self) -> dict[str, JSON]:
        """Return the verdict as a dictionary, as ``rollbench check SCENE --json`` prints it.

        Returns
        -------
        dict
            JSON values by key.
        """
        data: dict[str, Any] = {"verdict": self.word, "passed": self.passed, "verdicts": [v.as_json() for v in self.rows]}
        if self.cases:
            data["worst_cases"] = [
                {"scene": x.duty_cycle.name, "case": x.load_case.name, "verdict": one.word} for x, one in self.worst_cases
            ]
            data["cases"] = [
                x.identifying_values | {"verdict": one.word, "verdicts": [v.as_json() for v in one.rows]}
                for x, one in self.cases
            ]
        return add_schema_version(data | {"warnings": list(self.warnings), "not_judged": list(self.not_judged)})

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each judged quantity; mesh levels are a text such as "1, 3".

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        return [v.as_json() | {"levels": ", ".join(map(str, v.levels))} for v in self.rows]

    def figure(self) -> Figure | None:
        """Return the figure of judged and reference loads around the worst contact; None if no contact load was judged.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        shown = row_for_load_chart(self.rows)
        return None if shown is None else worst_ball_figure(shown)

    headings = ("verdict", "scene", "model or file", "quantity", "error", "uncertainty", "limit", "note")

    def table(self) -> Sequence[Sequence[str]]:
        """Return a row of texts for each quantity that was judged.

        The cells for the scene are left empty if all rows have the same scene, and the cells for the model or file if all
        rows have the same model or file; `answer` names them.

        Returns
        -------
        Sequence[Sequence[str]]
            Texts of each row, one for each of `headings`.
        """
        rows = []
        for v in self.rows:
            numbers = (f"{abs(x):.2f} {v.unit}" if x is not None else "–" for x in (v.error, v.uncertainty))
            ball = "" if v.ball is None else f"ball {v.ball} {v.side}"
            note = "; ".join(filter(None, (ball, v.note)))
            rows.append((str(v.judgement), v.subject, v.judged, v.quantity, *numbers, f"{v.limit:.4g} {v.unit}", note))
        same = [len({row[k] for row in rows}) == 1 for k in range(len(self.headings))]
        return [["" if same[k] and k in (1, 2) else text for k, text in enumerate(row)] for row in rows]

    @property
    def answer(self) -> str:
        """Verdict as one line: worst judgement, scenes, models, largest error of a contact load, numbers of judgements."""
        counts = ", ".join(f"{n} {x}" for x in CODES if (n := sum(v.judgement is x for v in self.rows)))
        scenes, models = ([getattr(v, name) for v in self.rows] for name in ("subject", "judged"))
        of = f"{', '.join(dict.fromkeys(scenes))} by {', '.join(dict.fromkeys(models))}"
        loads = [v for v in self.rows if v.of_mean is not None and v.error is not None]
        v = max(loads, key=lambda v: abs(v.error or 0.0), default=None)
        where = "" if v is None else f"; worst contact {abs(v.error or 0.0):.2f} % off (ball {v.ball} {v.side})"
        if v is not None and v.uncertainty is not None:
            where += f", {'numerical uncertainty (mesh)' if any(v.levels) else 'uncertainty'} {v.uncertainty:.2f} %"
        return f"{self.word.upper()}: {of}{where}; {counts}"

    @property
    def advice(self) -> list[str]:
        """Sentences that state to which load the errors are relative, and what to do about quantities that do not pass."""
        words = {v.judgement for v in self.rows}
        rule = [f"errors of contact loads: {RULE}"] if any(v.quantity == LARGEST for v in self.rows) else []
        return rule + [f"{word}: {ADVICE[word]}" for word in ("fail", "undecided", "not covered") if word in words]

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: each warning, then a line for each judged quantity."""
        return (*(f"WARNING: {words}" for words in self.warnings), *(row.line for row in self.rows))

    def __repr__(self) -> str:
        """Return lines of text: the worst judgement, then each warning, then each row."""
        return "\n".join([f"verdict: {self.word}", *self._notes])


def judge_scenes(
    described: Sequence[Described],
    names: Sequence[str],
    request: GateRequest,
    engine: ComputingSettings,
    step: Callable[[str], None],
) -> Verdict:
    """Judge scenes and their load cases, and return all judgements as one record.

    Parameters
    ----------
    described
        The scenes.
    names
        File or name of each scene, for error messages.
    request
        The user's request: which values are judged, by which limits, against which reference.
    engine
        Settings that determine where runs of the 3D reference are computed.
    step
        Function that is called with each line of progress.

    Returns
    -------
    Verdict
        A row for each judged quantity, with the name of its load case. Its judgement is "not converged" if the model found
        no equilibrium in that load case.

    Raises
    ------
    rollbench.InputError
        If a scene, file or limit cannot be used.
    """
    warnings: list[str] = []
    cases = load_cases_by_scene_name(described)
    scenes = [scene for one, name in zip(described, names, strict=True) for scene in scenes_to_solve(one, name)]
    of_one = {scene: case.load_case.name for scene, case in cases.items()} if len(described) == 1 else {}
    judged = []
    for v in check_scenes(scenes, request, engine, step, warnings.append, of_one):
        case = cases.get(v.scene)
        if case is not None:
            lost = Judgement.NOT_CONVERGED if v.judgement is Judgement.FAIL and v.error is None else v.judgement
            v = replace(v, scene=case.duty_cycle.name, case=case.load_case.name, judgement=lost)
        judged.append(v)
    left = quantities_without_verdict(judged) if request.loads or request.values else []
    return Verdict(tuple(judged), tuple(warnings), tuple(left), tuple(described))
