"""How to read the report: what an error, an uncertainty, a class and a verdict are, with one row worked through."""

from __future__ import annotations

from collections.abc import Callable

from rollbench.comparison.measure import error_percent, load_error
from rollbench.comparison.models.registry import MODELS
from rollbench.comparison.models.study import Study
from rollbench.meshes.parts import SIDES
from rollbench.reports.records import Section, Text

#: Scene and model of the worked row, and the limit that it is judged by [%].
SCENE, MODEL, LIMIT = "lin-case1", "lin", 7.0
TERMS = (
    "Error: 100 (value - reference) / |reference|. Contact loads are compared in per cent of the mean load of the contacts "
    "that the nominal screw loads, so that a ball about to unload does not turn a newton into a hundred per cent; the "
    'error of a load against itself stands beside it as "own load".',
    "Uncertainty of the 3D reference: 95 %, by its mesh (parts of contact cells, body cells and sockets, added as "
    "independent errors). Modelling choices that no mesh shows, and tolerances of the input, are terms of their own; the "
    "total has all three.",
    "Class of a printed number. hard: the text determines it, and it must come out to the digits printed. as-printed: it "
    "comes out only when a fault of the source is repeated; the right value stands beside it. band: under-specified or "
    "random, compared with a range whose origin is stated. open: not determined by the text; shown, never gated on. input: "
    "given by the source, or what something was inferred from; never counted as reproduced.",
    "Verdict of a printed number: reproduced, only as printed, within its band, contradicted, not identifiable, or an "
    "input or identity, which say nothing of a model. One list has them all: section verdicts.",
    "A reproduced entry says as much as its kind: a computed number tests a model, a claim in words its tendency, "
    "arithmetic on printed numbers the source, a zero by symmetry a sign.",
    "Tables show their first rows and columns; every CSV file has all. Flanks are SL, SR (screw, left and right) and NL, "
    "NR (nut).",
)


def worked(study: Study) -> str:
    """One row of a table of loads, word by word; empty without the reference."""
    found = study.reference(SCENE)
    if found is None:
        return ""
    result = study.solve(SCENE, MODEL)
    e = load_error(result.load, found.load, found.contacts)
    i, s = e.ball - 1, SIDES.index(e.side)
    value, truth, mean = float(result.load[i, s]), float(found.load[i, s]), found.mean
    own = float(error_percent(value, truth))
    bar = float(error_percent(found.uncertainty[i, s], 0.0, truth))
    verdict = "fails" if abs(own) - bar > LIMIT else "passes" if abs(own) + bar <= LIMIT else "is undecided"
    return (
        f"One row, read aloud: on ball {e.ball} {e.side} of {SCENE} {MODELS[MODEL].label} has {value:.1f} N and the 3D "
        f"reference {truth:.1f} N. That is {float(error_percent(value, truth, mean)):+.2f} % of the mean load of "
        f"{mean:.1f} N and {own:+.2f} % of its own load; the reference is known to {bar:.2f} % there, so that a "
        f"limit of {LIMIT:g} % {verdict}."
    )


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("one worked row")
    return Section("how-to-read", "How to read this report", (Text(TERMS, bullets=True),), conclusion=worked(study))
