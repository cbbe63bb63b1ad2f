"""What other programs and textbooks print: the entries of the external sources, and contact loads by CalculiX."""

from __future__ import annotations

from collections.abc import Iterator

from rollbench.compare.cases.makers.outside import MAKER, PROGRAM, Band, Outside
from rollbench.compare.evidence.computations import by_table, evidence
from rollbench.compare.models.study import Study

#: Tables of the external sources that are judged here: who, and of which class. Those of THK stand among the nuts.
PRINTED = {
    "external-masta": ("MASTA", PROGRAM),
    "external-nsk": ("NSK's programs", PROGRAM),
    "external-contact": ("CONTACT", PROGRAM),
    "external-vm63": ("Ansys", PROGRAM),
    "external-harris": ("Jones and Harris", PROGRAM),
    "external-sjovall": ("NSK", MAKER),
    "external-gmn": ("GMN", MAKER),
}
#: Quantity of an entry by its unit; those without unit are ratios of loads.
QUANTITIES = {
    "um": "displacement",
    "mrad": "displacement",
    "mm": "contact patch",
    "deg": "contact patch",
    "MPa": "pressure",
    "N": "contact load",
    "": "contact load",
    "balls": "contact load",
    "N/um": "rigidity",
    "N mm": "contact patch",
}
#: Entries whose unit says something else.
OTHERS = {("external-contact", "approach"): "displacement"}


def printed_elsewhere(study: Study) -> Iterator[Outside]:
    """Every number of the tables in `PRINTED` that is computed; open ones are not judged."""
    for name, (maker, cls) in PRINTED.items():
        if name not in by_table():
            continue
        for e in evidence(study, name):
            p = e.printed
            if p.value is None or e.value is None:
                continue
            patch = "contact patch" if name == "external-contact" and not p.unit else QUANTITIES[p.unit]
            quantity = OTHERS.get((name, p.key), patch)
            rounding = p.tolerance if p.cls == "hard" else max(p.value - (p.low or p.value), (p.high or p.value) - p.value)
            yield Outside(
                quantity,
                "the model of its table",
                maker,
                f"{name}: {p.label}",
                cls,
                p.place,
                p.unit,
                p.value,
                rounding,
                Band.of((e.value,)),
                left="" if p.cls in ("hard", "band") else "open: what it rests on is not printed",
            )


def calculix(study: Study) -> Iterator[Outside]:
    """Contact loads of the 3D reference beside those of CalculiX, extrapolated, both with their uncertainties; errors
    in per cent of the mean load."""
    from rollbench.compare.studies.crosscheck.results import contact_rows, load, path_of, shipped
    from rollbench.compare.studies.crosscheck.study import STUDIES

    for name in STUDIES:
        data, ours = load(shipped(), name), study.reference(name)
        if data is None or ours is None:
            continue
        mean = float(ours.mean)
        for row in contact_rows(data, ours):
            off = 0.01 * row.ours_percent * mean
            words = ("contact load", "3D reference", "CalculiX", f"{name}: ball {row.ball} {row.side}", PROGRAM)
            value = (row.theirs, 0.01 * row.theirs_percent * mean, Band.of((row.ours,), off), mean)
            yield Outside(*words, f"stored run, compare/studies/crosscheck/{path_of(shipped(), name).name}", "N", *value)
