"""Records that `rollbench.check` returns: whether the contact loads of a scene agree with a reference within a limit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from typing import Any

from rollbench.compare.gate import verdict as gate
from rollbench.compare.gate.user import GateRequest, check_scenes
from rollbench.compare.gate.verdict import CODES, LARGEST, Word, quantities_without_verdict, worst_verdict
from rollbench.compare.models.comparison import RULE
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.results.base import JSON, Record, add_schema_version
from rollbench.compare.scenes.duty_cycle import Described, load_cases_by_scene_name
from rollbench.compare.scenes.scene_file import scenes_to_solve


class Judgement(StrEnum):
    """Judgement of a quantity by its error e against a reference, the reference's uncertainty u, and the error's limit.

    Only `PASS` is true, so that an ``assert`` of a judgement fails on every other one.
    """

    PASS = "pass"
    """The error is within the limit even with the uncertainty added: e + u <= limit."""
    FAIL = "fail"
    """The error is beyond the limit even with the uncertainty subtracted: e - u > limit."""
    NOT_CONVERGED = "not converged"
    """The model found no equilibrium in the load case."""
    UNDECIDED = "undecided"
    """The limit lies between e - u and e + u: the reference is not accurate enough to decide."""
    NOT_COVERED = "not covered"
    """The reference has no value of the quantity."""

    def __bool__(self) -> bool:
        """Whether the judgement is `PASS`."""
        return self is Judgement.PASS


#: Advice to the user for each judgement that is not "pass".
ADVICE = {
    "fail": "compare every contact with its reference: rollbench compare SCENE --balls",
    "not converged": "see why there is no equilibrium: rollbench solve SCENE",
    "undecided": "reduce the uncertainty of the reference by more mesh levels: --levels 3",
    "not covered": "compute the 3D reference: --levels 2",
}


@dataclass(frozen=True)
class VerdictRow:
    """Judgement of one quantity of a scene, of a load case, or of one nut or bearing out of several; true if it passes."""

    scene: str
    """Name of the scene."""
    case: str | None
    """Name of the load case; None without load cases."""
    set: str | None
    """Name of the nut or bearing; None if the scene has only one."""
    judged: str
    """Name of the model or of the file whose values are judged."""
    quantity: str
    """Name of the judged quantity, such as "largest error of a contact load"."""
    judgement: Judgement
    """Judgement of the quantity."""
    unit: str
    """Unit of error, uncertainty and limit: ``%`` of the reference value (for small contact loads, of the mean load), or
    the unit in which the limit is stated, such as ``deg``."""
    error: float | None
    """Error of the quantity, or of the contact that determines the judgement [unit]; None if nothing could be compared."""
    uncertainty: float | None
    """Uncertainty of the reference for the judged quantity or contact [unit]; None if not known."""
    limit: float
    """Largest permitted error [unit]."""
    ball: int | None
    """Number of the ball, from 1, of the contact that determines the judgement; None for quantities of the whole scene."""
    side: str | None
    """Groove flank of the contact that determines the judgement: SL, SR, NL or NR; None for quantities of the whole
    scene."""
    contacts: int
    """Number of judged contacts."""
    levels: tuple[int, ...]
    """Mesh levels of the 3D reference."""
    detail: str
    """Further explanation of the judgement; may be empty."""
    line: str
    """The judgement as one line of text."""

    def __bool__(self) -> bool:
        """Whether the quantity passes."""
        return bool(self.judgement)


@dataclass(frozen=True, repr=False, eq=False)
class Verdict(Record):
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
    judged: tuple[gate.Verdict, ...]
    """Records of the judgement with further details, one for each row."""
    described: tuple[Described, ...]
    """The judged scenes."""

    @property
    def judgement(self) -> Judgement:
        """Worst judgement of all rows."""
        return Judgement(worst_verdict([row.judgement.value for row in self.rows]))

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
        rest: dict[str, Any] = {"warnings": list(self.warnings), "not_judged": list(self.not_judged)}
        return add_schema_version(verdicts_json(self.described, self.judged) | rest)

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
        for v in self.judged:
            numbers = (f"{abs(x):.2f} {v.unit}" if x is not None else "–" for x in (v.error, v.uncertainty))
            ball = "" if v.ball is None else f"ball {v.ball} {v.flank}"
            note = "; ".join(filter(None, (ball, v.pair_text.strip(", "), v.detail)))
            rows.append((v.word, v.subject, v.judged, v.quantity, *numbers, f"{v.limit:.4g} {v.unit}", note))
        same = [len({row[k] for row in rows}) == 1 for k in range(len(self.headings))]
        return [["" if same[k] and k in (1, 2) else text for k, text in enumerate(row)] for row in rows]

    @property
    def answer(self) -> str:
        """Verdict as one line: worst judgement, scenes, models, largest error of a contact load, numbers of judgements."""
        counts = ", ".join(f"{n} {word}" for word in CODES if (n := sum(v.word == word for v in self.judged)))
        scenes, models = ([getattr(v, name) for v in self.judged] for name in ("subject", "judged"))
        of = f"{', '.join(dict.fromkeys(scenes))} by {', '.join(dict.fromkeys(models))}"
        loads = [v for v in self.judged if v.of_mean is not None and v.error is not None]
        v = max(loads, key=lambda v: abs(v.error or 0.0), default=None)
        where = "" if v is None else f"; worst contact {abs(v.error or 0.0):.2f} % off (ball {v.ball} {v.flank})"
        if v is not None and v.uncertainty is not None:
            where += f", {'numerical uncertainty (mesh)' if any(v.levels) else 'uncertainty'} {v.uncertainty:.2f} %"
        return f"{self.word.upper()}: {of}{where}; {counts}"

    @property
    def advice(self) -> list[str]:
        """Sentences that state to which load the errors are relative, and what to do about quantities that do not pass."""
        words = {v.word for v in self.judged}
        rule = [f"errors of contact loads: {RULE}"] if any(v.quantity == LARGEST for v in self.judged) else []
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
        A row for each judged quantity.

    Raises
    ------
    rollbench.InputError
        If a scene, file or limit cannot be used.
    """
    warnings: list[str] = []
    judged = judge_load_cases(described, names, request, engine, step, warnings.append)
    left = quantities_without_verdict(judged) if request.loads_file or request.values_file else []
    return Verdict(tuple(map(_verdict_row, judged)), tuple(warnings), tuple(left), tuple(judged), tuple(described))


def _verdict_row(v: gate.Verdict) -> VerdictRow:
    """Convert the detailed verdict on one quantity to a row of the record that `rollbench.check` returns."""
    shared = {f.name: getattr(v, f.name) for f in fields(VerdictRow) if f.name not in ("judgement", "side", "line")}
    return VerdictRow(**shared, judgement=Judgement(v.word), side=v.flank, line=v.line())


def judge_load_cases(
    described: Sequence[Described],
    names: Sequence[str],
    request: GateRequest,
    engine: ComputingSettings,
    step: Callable[[str], None],
    warn: Callable[[str], None],
) -> list[gate.Verdict]:
    """Judge scenes and their load cases, and return a detailed record for each quantity.

    Parameters
    ----------
    described, names, request, engine, step
        As for `judge_scenes`.
    warn
        Function that is called with each warning.

    Returns
    -------
    list[gate.Verdict]
        A record for each quantity, with the name of its load case. Its judgement is "not converged" if the model found no
        equilibrium in that load case.

    Raises
    ------
    rollbench.InputError
        If a scene, file or limit cannot be used.
    """
    cases = load_cases_by_scene_name(described)
    scenes = [scene for one, name in zip(described, names, strict=True) for scene in scenes_to_solve(one, name)]
    of_one = {scene: case.load_case.name for scene, case in cases.items()} if len(described) == 1 else {}
    out = []
    for v in check_scenes(scenes, request, engine, step, warn, of_one):
        case = cases.get(v.scene)
        lost: Word = "not converged" if v.word == "fail" and v.error is None else v.word
        out.append(v if case is None else replace(v, scene=case.duty_cycle.name, case=case.load_case.name, word=lost))
    return out


def verdicts_json(described: Sequence[Described], verdicts: Sequence[gate.Verdict]) -> dict[str, Any]:
    """Convert the judgements of all scenes to JSON values.

    Parameters
    ----------
    described
        The judged scenes.
    verdicts
        Judgements of all scenes and load cases.

    Returns
    -------
    dict
        The judgements and the worst of them. With load cases, also the judgements of each case, and the case that
        determines the verdict of each scene.
    """
    gravest = worst_verdict([v.word for v in verdicts])
    data: dict[str, Any] = {"verdict": gravest, "passed": gravest == "pass", "verdicts": [v.as_json() for v in verdicts]}
    cases, graveness = [], []
    for case in load_cases_by_scene_name(described).values():
        its = [v for v in verdicts if (v.scene, v.case) == (case.duty_cycle.name, case.load_case.name)]
        word, beyond = worst_verdict([v.word for v in its]), max((abs(v.error or 0.0) / v.limit for v in its), default=0.0)
        cases.append(case.identifying_values | {"verdict": word, "verdicts": [v.as_json() for v in its]})
        graveness.append(([*CODES].index(word), -beyond))
    if not cases:
        return data
    worst: dict[str, dict[str, Any]] = {}
    for k in sorted(range(len(cases)), key=graveness.__getitem__):
        worst.setdefault(cases[k]["scene"], {key: cases[k][key] for key in ("scene", "case", "verdict")})
    return data | {"worst_cases": [*worst.values()], "cases": cases}
