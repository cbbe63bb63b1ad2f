"""Report sections that explain error and uncertainty of contact loads, and when a printed number counts as reproduced.

A further section lists assumptions of the scenes, and printed numbers that are not reproduced.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rollbench.compare.evidence import PrintedEntryComparison, evidence
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.comparison import RULE
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import VERDICT_NAMES
from rollbench.lowfi.statics.summary import MODEL_ASSUMPTIONS
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Cell, Row, Section, Table, Text

#: Scene and low-order model of the example that explains error and uncertainty.
SCENE, MODEL = "lin-case1", "lin"

TERMS = (
    (
        "Error: 100 (value - reference) / |reference|. Errors of contact loads are in per cent of the mean load over "
        "the contacts that carry load in the screw without geometric errors, so that an error of one newton on a nearly "
        "unloaded ball does not count as 100 %; columns state this as [% of mean load]. Errors relative to the load of the "
        "contact itself are in [% of contact's load]."
    ),
    (
        f"Limit of {LIMIT:g} %: that of rollbench check for the largest error of a contact load {RULE}. Errors "
        "in per cent of the mean load have no limit."
    ),
    (
        "Mesh uncertainty of the 3D reference: 95 %, by its mesh (cells of contacts, cells of bodies, and boxes around the "
        "contacts, combined as independent errors). Modelling choices and input tolerances are separate terms; the "
        "total uncertainty combines all three."
    ),
    (
        "Class of a printed number. hard: the text of the publication determines the number, so all printed digits must be "
        "reproduced. as-printed: the number is reproduced only with the publication's mistake repeated; the correct value "
        "is shown too. band: the number is under-specified or random, and compared with a range of stated origin, which "
        "extends by at most a quarter of its middle to either side. open: the text does not determine the number; it is "
        "shown, but never fails a check. input: the number is an input, or was used to infer one; it is never counted as "
        "reproduced."
    ),
    (
        "Whether a printed number is reproduced: reproduced; only with the publication's mistake repeated; "
        "within a tolerance band; contradicted; not determined by the data in the publication; or input or identity, "
        "which do not test a model. Section verdicts lists all numbers."
    ),
    (
        "A reproduced number tests a model, a reproduced claim in words its trend. A number that follows from other "
        "printed numbers tests the publication's arithmetic, and a zero by symmetry or definition a sign: both are "
        "identities, stand in columns of their own and are not counted as reproduced."
    ),
    (
        "A table of more than 20 rows is folded; a click on its title shows all rows. Flanks are SL and SR (screw, "
        "left and right), NL and NR (nut, left and right)."
    ),
)


def verdict_example_paragraph(cache: SceneResultCache) -> str:
    """Return a paragraph that explains error, uncertainty and verdict, with one contact load of `SCENE` as example.

    ``cache``: has the solutions and the stored 3D reference. The text is empty if the reference is not stored.
    """
    found = cache.stored_reference(SCENE)
    if found is None:
        return ""
    result = cache.solve_once(SCENE, MODEL)
    e = load_error(result.load, found.load, found.contacts)
    i, s = e.ball - 1, SIDES.index(e.side)
    value, truth, mean = float(result.load[i, s]), float(found.load[i, s]), found.mean
    error = float(error_percent(value, truth))
    bar = float(error_percent(found.uncertainty[i, s], 0.0, truth))
    verdict = "fail" if abs(error) - bar > LIMIT else "pass" if abs(error) + bar <= LIMIT else "undecided"
    return (
        f"Example: on ball {e.ball} {e.side} of {SCENE}, {MODELS[MODEL].label} gives {value:.1f} N "
        f"and the 3D reference {truth:.1f} N. The error is {float(error_percent(value, truth, mean)):+.2f} % "
        f"of the mean load of {mean:.1f} N, or {error:+.2f} % of the load of the contact itself. The "
        f"uncertainty of the reference on this contact is {bar:.2f} %, so rollbench check with its limit of {LIMIT:g} % "
        f"says: {verdict}."
    )


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section that explains the terms of the report (error, uncertainty, class, reproduced), with one example.

    ``step`` is called with each line of progress.
    """
    step("example of an error and its uncertainty")
    items = Text((verdict_example_paragraph(cache),)), Text(TERMS, bullets=True)
    return Section("how-to-read", "How to read this report", items)


def rows_of_assumed_inputs(cache: SceneResultCache) -> list[dict[str, Cell]]:
    """Return table rows of the values that scenes assume for inputs that a publication does not print.

    ``cache``: has the scenes that the report uses. A row names the assumed value and the scenes that assume it.
    """
    by_text: dict[str, list[str]] = {}
    for name, scene in cache.used_scenes.items():
        for sentence in scene.assumed:
            by_text.setdefault(sentence, []).append(name)
    total = len(cache.used_scenes)
    return [
        {"assumed_value": text, "assumed_for": "all" if len(names) == total else ", ".join(names)}
        for text, names in sorted(by_text.items(), key=lambda item: -len(item[1]))
    ]


def rows_not_reproduced(entries: Sequence[PrintedEntryComparison]) -> list[Row]:
    """Return table rows of printed numbers that are contradicted, or for which the publication states too few data.

    ``entries``: printed numbers with their computed values and verdicts.
    """
    return [
        {
            "entry": p.claim or f"{p.label}: {p.number_as_printed} {p.unit}",
            "place": p.place,
            "class": p.entry_class,
            "verdict": VERDICT_NAMES[verdict],
            "explanation_of_difference": f.remark if f.remark and f.agrees_with_printed is not None else p.remark,
        }
        for f in entries
        for p, verdict in ((f.printed, f.verdict),)
        if verdict in ("contradicted", "not identifiable")
    ]


def assumptions_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on assumptions of scenes and models, and on printed numbers that are not reproduced.

    ``step`` is called with each line of progress.
    """
    step("assumptions, and numbers that are not reproduced")
    title = "Numbers and claims that are contradicted, or not determined by the data in the publication"
    contradicted = Table.from_rows("not-reproduced", title, rows_not_reproduced(evidence(cache)))
    title = "Values assumed for inputs that a publication does not print"
    assumed = Table.from_rows("assumptions", title, rows_of_assumed_inputs(cache))
    title = "Values assumed for missing inputs, and printed numbers that are not reproduced"
    return Section("notes", title, (contradicted, assumed, Text(MODEL_ASSUMPTIONS, bullets=True)))
