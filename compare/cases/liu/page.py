"""Liu et al. (2025) in the report: the numbers of its sections as tables and its figures, with ours on both."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from rollbench.compare.case import CASES
from rollbench.compare.cases.liu import bodies, curves
from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.evidence import counts, evidence, trust
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.sections.source_tables import computation_tables, read_layouts, shown_tables
from rollbench.compare.sections.verdicts import misprints_table
from rollbench.reports.content import Quantity, Row, Section, Table, Text

#: Sections by name: title, printed tables.
CHAPTERS = {
    "liu-parameters": ("Section 2.1 and Table 2: the screw and its errors", ("liu-2",)),
    "liu-test": ("Section 3: algorithm and experiment", ("liu-3",)),
    "liu-mei": ("Section 4.1: against Mei's model", ("liu-4.1",)),
    "liu-one-ball": ("Section 4.2: one ball too small or too large", ("liu-4.2",)),
    "liu-loads": ("Section 4.3: random errors, loads and displacement", ("liu-4.3",)),
    "liu-stiffness": ("Section 4.4: random errors, stiffness", ("liu-4.4",)),
}
PRINTED = tuple(name for _, names in CHAPTERS.values() for name in names)
ABOUT = (
    (
        "One axial displacement, springs of screw and nut between neighbouring balls, unilateral Hertz "
        "contacts: the minimum of a convex energy, found by a tridiagonal Newton method that needs no sorting "
        "of unloaded balls. The source's elimination ends with the same loaded balls. Random results are "
        "compared with drawn screws: each number has its percentile, the sampling error of it, and the "
        "probability of a value as extreme."
    ),
    *(f"Assumed: {text}" for text in liu.ASSUMED),
    "The source's readings agree with its implicit contact angle, not with a constant or the exact angle.",
    "The measured displacements appear in a figure only, so no number of the experiment can be compared.",
)


def counts_in_words(found: dict[str, float]) -> str:
    """Return a text on how many printed counts of loaded balls lie within the central range of the draws."""
    total, out = 0, []
    for key, value in found.items():
        parts = re.fullmatch(r"(un)?loaded_(\d)_(\d+)(_again)?", key)
        if parts is None:
            continue
        half_range, load = int(parts[2]), float(parts[3])
        count = liu.balls() - value if parts[1] else value
        low, high = np.quantile(liu.drawn_sample(half_range, "loaded", load), [liu.UNLIKELY, 1.0 - liu.UNLIKELY])
        total += 1
        if not low <= count <= high:
            out.append(f"±{half_range} µm at {load:g} N {'below' if count < low else 'above'}")
    span = f"what {100.0 * (1.0 - 2.0 * liu.UNLIKELY):g} % of the draws span"
    beyond = f"; beyond it: {', '.join(dict.fromkeys(out))}" if out else ""
    return f"{total - len(out)} of {total} printed counts lie within {span}{beyond}"


def stiffness_in_words(found: dict[str, float]) -> str:
    """Return a text on the deviation of printed stiffness from the drawn median, where most draws load all balls."""
    off = []
    for key, value in found.items():
        parts = re.fullmatch(r"K_(\d)_(\d+)", key)
        half_range, load = (int(parts[1]), float(parts[2])) if parts else (0, 0.0)
        if load in liu.LOADS.get(half_range, ()) and np.median(liu.drawn_sample(half_range, "loaded", load)) == liu.balls():
            off.append(error_percent(1e8 * value, float(np.median(liu.drawn_sample(half_range, "stiffness", load)))))
    if not off:
        return "no printed stiffness stands at a load that all balls of most draws carry"
    return f"with all balls loaded printed stiffness is {min(off):+.1f} to {max(off):+.1f} % off the median of the draws"


def bodies_table(study: Study) -> Table:
    """Return the table of loads of screws with errors by the axial chain, the beam model and the refined model."""
    rows: list[Row] = []
    for c in study.once(bodies.compare_models):
        row: Row = {"errors": c.errors, Quantity("load", "axial load", "N", ".0f"): c.load}
        for name, words, model in (
            ("axial", "axial only", c.axial),
            ("beam", "beam model", c.beam),
            ("refined", "refined model", c.refined),
        ):
            row[Quantity(name, f"{words}: largest load", "N")] = float(model.max())
            row[Quantity(f"{name}_loaded", f"{words}: loaded balls", "", "s")] = int(np.count_nonzero(model > 0.0))
            if name != "axial":
                rms, most, ball = c.off(model)
                row[Quantity(f"{name}_rms", f"{words}: RMS off the axial one", "% of the mean", ".2f")] = rms
                largest = f"{most:+.1f} (ball {ball})"
                row[Quantity(f"{name}_most", f"{words}: largest difference", "% of the mean", "s")] = largest
        rows.append(row)
    note = (
        "Axial only: the chain with the axial compliance of the same screw and a rigid nut, as in the beam "
        "model. Areas and balls per turn are assumed (scene liu-screw)."
    )
    return Table.of("liu-bodies", "Where the axial-only idealisation misleads", rows, note)


def solid_table(study: Study) -> Table:
    """Return the table of errors of the low-order models against 3D on one screw."""
    words = {"axial": "axial only", "lin": "beam model", "refined": "refined model"}
    rows: list[Row] = [
        {
            "scene": c.scene,
            "model": words[c.model],
            Quantity("rms", "RMS error", "% of the mean", ".2f"): c.rms,
            Quantity("most", "largest error", "% of the mean", ".2f"): c.largest,
            Quantity("ball", "at ball", "", "s"): c.ball,
            Quantity("bar", "3D: grid uncertainty", "% of the mean", ".2f"): c.uncertainty,
            Quantity("loaded", "loaded balls", "", "s"): c.loaded,
            Quantity("solid", "in 3D", "", "s"): c.loaded_in_3d,
        }
        for c in study.once(bodies.compare_solid)
    ]
    levels = " and ".join(str(k) for k in bodies.SOLID_LEVELS)
    contacts = 2 * study.scene(bodies.SCENE).ball_count
    note = (
        f"3D reference on the mesh levels {levels}: {contacts} contacts. Both models of the first two rows hold the nut "
        "rigid. "
        "The drawn errors are those of the scene's seed, the same for all models."
    )
    return Table.of("liu-solid", "The axial-only idealisation, beam and refined model against 3D", rows, note)


def make_section(study: Study, step: Callable[[str], None]) -> tuple[Section, ...]:
    """Return the sections of the report."""
    step("random errors of a ball screw")
    found = evidence(study, *PRINTED)
    by_name = {f.printed.name: f for f in found}
    printed = {f.printed.key: f.printed.value for f in found if f.printed.value is not None}
    listed = read_layouts(next(case for case in CASES if case.name == "liu"))
    drawn = {
        "liu-test": (curves.deformation(), curves.test_curve(), curves.test_table()),
        "liu-mei": (curves.against_mei(),),
        "liu-one-ball": (curves.one_ball(),),
        "liu-loads": (
            curves.loads_2(),
            curves.loads_by_range(),
            curves.loaded_balls(printed, f"{counts_in_words(printed)}."),
            curves.displacement(),
        ),
        "liu-stiffness": (curves.stiffness(printed, f"{stiffness_in_words(printed)}."), curves.three_sets(printed)),
    }
    chapters = [
        Section(name, title, (*shown_tables(tables, listed, by_name), *drawn.get(name, ())))
        for name, (title, tables) in CHAPTERS.items()
    ]
    study.uses(bodies.SOLID)
    beyond = [bodies_table(study), *([solid_table(study)] if study.references(bodies.SOLID) else ())]
    return (
        Section(
            "liu",
            "Liu et al. (2025): contact loads of a ball screw with random geometric errors",
            (Text(ABOUT, bullets=True),),
            conclusion=trust(counts(found)[0]),
        ),
        *chapters,
        Section("liu-beyond", "The same screw by a beam, the refined model and in 3D", beyond),
        Section(
            "liu-audit",
            "Misprints of the publication, and how each number is computed here",
            (misprints_table("liu"), *computation_tables(PRINTED)),
        ),
    )
