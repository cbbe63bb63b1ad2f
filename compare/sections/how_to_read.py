"""Sections on how to read the report: error, uncertainty, class and verdict, with one example row.

Also assumptions of the scenes, misprints of the sources, and what is not reproduced.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rollbench.compare.evidence import Evidence, evidence
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.comparison import RULE
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import Study
from rollbench.lowfi.statics.summary import MODEL_ASSUMPTIONS
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Cell, Quantity, Row, Section, Table, Text

#: Scene and model of the example row.
SCENE, MODEL = "lin-case1", "lin"

TERMS = (
    (
        "Error: 100 (value - reference) / |reference|. Contact loads are compared in per cent of the mean load "
        "over the contacts that the nominal screw loads, so that an error of one newton on a nearly unloaded "
        "ball does not count as 100 %. The error relative to the contact's own load is given beside it as \"own "
        'load".'
    ),
    (
        f"Line of {LIMIT:g} %: that of the gate (rollbench check), on the largest error of a contact load {RULE}. An error "
        "of the mean load has no such line."
    ),
    (
        "Uncertainty of the 3D reference: 95 %, from its mesh (contact cells, body cells and sockets, added as "
        "independent errors). Modelling choices that no mesh shows and input tolerances are separate terms; the "
        "total has all three."
    ),
    (
        "Class of a printed number. hard: the text determines it, so it must come out to the digits printed. "
        "as-printed: it comes out only when a fault of the source is repeated; the right value stands beside "
        "it. band: under-specified or random, compared with a range whose origin is stated and that is at most a "
        "quarter of its middle wide to either side. open: the text does not determine it; it is shown but never gated. "
        "input: given by the source, or used to infer something; never counted as reproduced."
    ),
    (
        "Verdict of a printed number: reproduced, only as printed, within its band, contradicted, not "
        "identifiable, or input or identity (which test no model). Section verdicts lists all of them."
    ),
    (
        "What a reproduced entry proves depends on its kind: a computed number tests a model, a claim in words "
        "tests its trend, arithmetic on printed numbers tests the source, and a zero by symmetry tests a sign."
    ),
    (
        "A table of more than 20 rows is folded: its title opens it, with all rows. Flanks are SL and SR (screw, "
        "left and right), NL and NR (nut)."
    ),
)


def explain_one_row(study: Study) -> str:
    """Return an explanation of one row of a table of loads, word by word; empty without the reference."""
    found = study.reference(SCENE)
    if found is None:
        return ""
    result = study.solve(SCENE, MODEL)
    e = load_error(result.load, found.load, found.contacts)
    i, s = e.ball - 1, SIDES.index(e.side)
    value, truth, mean = float(result.load[i, s]), float(found.load[i, s]), found.mean
    error = float(error_percent(value, truth))
    bar = float(error_percent(found.uncertainty[i, s], 0.0, truth))
    verdict = "fails" if abs(error) - bar > LIMIT else "passes" if abs(error) + bar <= LIMIT else "is undecided"
    return (
        f"An example row: on ball {e.ball} {e.side} of {SCENE}, {MODELS[MODEL].label} gives {value:.1f} N "
        f"and the 3D reference {truth:.1f} N. The error is {float(error_percent(value, truth, mean)):+.2f} % "
        f"of the mean load of {mean:.1f} N, or {error:+.2f} % of the contact's own load. The reference is "
        f"known to {bar:.2f} % there, so a limit of {LIMIT:g} % {verdict}."
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("one worked row")
    return Section("how-to-read", "How to read this report", (Text((explain_one_row(study),)), Text(TERMS, bullets=True)))


def collect_assumptions(study: Study) -> list[dict[str, Cell]]:
    """Return the assumptions, with the scenes that make them."""
    by_text: dict[str, list[str]] = {}
    for name, scene in study.used.items():
        for sentence in scene.assumed:
            by_text.setdefault(sentence, []).append(name)
    total = len(study.used)
    return [
        {"assumed": text, "scenes": "all" if len(names) == total else ", ".join(names)}
        for text, names in sorted(by_text.items(), key=lambda item: -len(item[1]))
    ]


def _explain_verdict(f: Evidence) -> str:
    """Return the explanation of an entry: that of its computed value, else its printed remark."""
    return f.words if f.words and f.agrees is not None else f.printed.remark


def not_reproduced(found: Sequence[Evidence]) -> list[Row]:
    """Return the entries that are contradicted, and those that the text does not determine."""
    return [
        {
            Quantity("entry", "printed", "", "s"): p.claim or f"{p.label}: {p.printed} {p.unit}",
            "place": p.place,
            "class": p.cls,
            "verdict": verdict,
            Quantity("why", "best explanation and its evidence", "", "s"): _explain_verdict(f),
        }
        for f in found
        for p, verdict in ((f.printed, f.verdict),)
        if verdict in ("contradicted", "not identifiable")
    ]


def notes_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section on assumptions, misprints and what is not reproduced."""
    step("assumptions and misprints")
    return Section(
        "notes",
        "Assumptions, misprints, and printed numbers that are not reproduced",
        (
            Table.of(
                "not-reproduced",
                "Printed numbers that are contradicted, or that the text does not determine",
                not_reproduced(evidence(study)),
            ),
            Table(
                "assumptions",
                "Inputs that a publication leaves open, and what its scene assumes",
                (Quantity("assumed", "assumed", "", "s"), Quantity("scenes", "scenes", "", "s")),
                collect_assumptions(study),
            ),
            Text(MODEL_ASSUMPTIONS, bullets=True),
        ),
    )
