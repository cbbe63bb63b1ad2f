"""Report pages on Liu et al. (2025): printed numbers and figures of each section, with the computed ones."""

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

#: Sections of the report by name: title, names of the printed tables.
CHAPTERS = {
    "liu-parameters": ("Liu (2025), Section 2.1 and Table 2: the screw and its errors", ("liu-2",)),
    "liu-test": ("Liu (2025), Section 3: algorithm and experiment", ("liu-3",)),
    "liu-mei": ("Liu (2025), Section 4.1: contact loads by Liu's and Mei's models", ("liu-4.1",)),
    "liu-one-ball": ("Liu (2025), Section 4.2: contact loads with one ball too small or too large", ("liu-4.2",)),
    "liu-loads": ("Liu (2025), Section 4.3: contact loads and displacement with random errors", ("liu-4.3",)),
    "liu-stiffness": ("Liu (2025), Section 4.4: axial stiffness with random errors", ("liu-4.4",)),
}
PRINTED = tuple(name for _, names in CHAPTERS.values() for name in names)
ABOUT = (
    (
        "One axial displacement, springs of screw and nut between neighbouring balls, unilateral Hertz "
        "contacts: the minimum of a convex energy, found by a tridiagonal Newton method that needs no sorting "
        "of unloaded balls. The publication's elimination of unloaded balls gives the same loaded balls. Random results "
        "are compared with drawn screws: each number has its percentile, the sampling error of it, and the "
        "probability of a value as extreme."
    ),
    *(f"Assumed: {text}" for text in liu.ASSUMED),
    "The publication's printed values agree with its implicit contact angle, not with a constant or the exact angle.",
    "The measured displacements appear in a figure only, so no number of the experiment can be compared.",
)


def loaded_counts_sentence(found: dict[str, float]) -> str:
    """Return in words how many printed numbers of loaded balls lie in the central 99 % interval of computed ones.

    The computed numbers are those of randomly drawn screws. ``found``: printed values by key, such as "loaded_2_500".
    """
    total, out = 0, []
    for key, value in found.items():
        parts = re.fullmatch(r"(un)?loaded_(\d)_(\d+)(_again)?", key)
        if parts is None:
            continue
        half_range, load = int(parts[2]), float(parts[3])
        count = liu.ball_count() - value if parts[1] else value
        low, high = np.quantile(liu.sample_of_drawn_screws(half_range, "loaded", load), [liu.UNLIKELY, 1.0 - liu.UNLIKELY])
        total += 1
        if not low <= count <= high:
            out.append(f"±{half_range} µm at {load:g} N {'below' if count < low else 'above'}")
    span = f"what {100.0 * (1.0 - 2.0 * liu.UNLIKELY):g} % of the draws span"
    beyond = f"; beyond it: {', '.join(dict.fromkeys(out))}" if out else ""
    return f"{total - len(out)} of {total} printed counts lie within {span}{beyond}"


def stiffness_sentence(found: dict[str, float]) -> str:
    """Return in words the deviation of printed stiffnesses from the median of the randomly drawn screws.

    Only axial loads count under which most of these screws have no unloaded ball. ``found``: printed values by key,
    such as "K_2_3000".
    """
    off = []
    for key, value in found.items():
        parts = re.fullmatch(r"K_(\d)_(\d+)", key)
        half_range, load = (int(parts[1]), float(parts[2])) if parts else (0, 0.0)
        if (
            load in liu.LOADS.get(half_range, ())
            and np.median(liu.sample_of_drawn_screws(half_range, "loaded", load)) == liu.ball_count()
        ):
            off.append(
                error_percent(1e8 * value, float(np.median(liu.sample_of_drawn_screws(half_range, "stiffness", load))))
            )
    if not off:
        return "no printed stiffness stands at a load that all balls of most draws carry"
    return f"with all balls loaded printed stiffness is {min(off):+.1f} to {max(off):+.1f} % off the median of the draws"


def model_loads_table(study: Study) -> Table:
    """Return the table of contact loads by Liu's axial model, the beam model and the refined model, for several errors."""
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
                rms, most, ball = c.difference_from_axial(model)
                row[Quantity(f"{name}_rms", f"{words}: RMS off the axial one", "% of the mean", ".2f")] = rms
                largest = f"{most:+.1f} (ball {ball})"
                row[Quantity(f"{name}_most", f"{words}: largest difference", "% of the mean", "s")] = largest
        rows.append(row)
    note = (
        "Axial only: the chain with the axial compliance of the same screw and a rigid nut, as in the beam "
        "model. Areas and balls per turn are assumed (scene liu-screw)."
    )
    return Table.of(
        "liu-bodies", "Contact loads of Liu's screw by the axial-only, the beam and the refined model", rows, note
    )


def errors_against_3d_table(study: Study) -> Table:
    """Return the table of the low-order models' errors against the 3D reference, for scenes of Liu's screw."""
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
        for c in study.once(bodies.compare_with_3d)
    ]
    levels = " and ".join(str(k) for k in bodies.SOLID_LEVELS)
    contacts = 2 * study.scene(bodies.SCENE).ball_count
    note = (
        f"3D reference on the mesh levels {levels}: {contacts} contacts. Both models of the first two rows hold the nut "
        "rigid. "
        "The drawn errors are those of the scene's seed, the same for all models."
    )
    return Table.of(
        "liu-solid",
        "Error of the axial-only, the beam and the refined model against the 3D reference, Liu's screw",
        rows,
        note,
    )


def make_section(study: Study, step: Callable[[str], None]) -> tuple[Section, ...]:
    """Return the report's sections on Liu et al. (2025)."""
    step("random errors of a ball screw")
    found = evidence(study, *PRINTED)
    by_name = {f.printed.name: f for f in found}
    printed = {f.printed.key: f.printed.value for f in found if f.printed.value is not None}
    listed = read_layouts(next(case for case in CASES if case.name == "liu"))
    drawn = {
        "liu-test": (curves.ball_deformation_figure(), curves.test_figure(), curves.test_table()),
        "liu-mei": (curves.mei_figure(),),
        "liu-one-ball": (curves.one_ball_figure(),),
        "liu-loads": (
            curves.loads_figure(),
            curves.loads_by_range_figure(),
            curves.loaded_balls_figure(printed, f"{loaded_counts_sentence(printed)}."),
            curves.displacement_figure(),
        ),
        "liu-stiffness": (
            curves.stiffness_figure(printed, f"{stiffness_sentence(printed)}."),
            curves.three_draws_figure(printed),
        ),
    }
    chapters = [
        Section(name, title, (*shown_tables(tables, listed, by_name), *drawn.get(name, ())))
        for name, (title, tables) in CHAPTERS.items()
    ]
    study.uses(bodies.SOLID)
    beyond = [model_loads_table(study), *([errors_against_3d_table(study)] if study.references(bodies.SOLID) else ())]
    return (
        Section(
            "liu",
            "Liu et al. (2025): contact loads of a ball screw with random geometric errors",
            (Text(ABOUT, bullets=True),),
            conclusion=trust(counts(found)[0]),
        ),
        *chapters,
        Section("liu-beyond", "Liu's screw by the axial-only model, a beam, the refined model and in 3D", beyond),
        Section(
            "liu-audit",
            "Misprints of the publication, and how each number is computed here",
            (misprints_table("liu"), *computation_tables(PRINTED)),
        ),
    )
