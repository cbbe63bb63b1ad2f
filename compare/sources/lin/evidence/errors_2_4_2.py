"""Section 2.4.2, geometric errors: printed numbers and claims; those on random errors need drawn screws."""

from __future__ import annotations

import numpy as np

from rollbench.comparison.measure import load_error
from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.lin.evidence.loads_2_4_1 import two_point
from rollbench.comparison.wings.evidence.record import Evidence, Sheet, count_of
from rollbench.comparison.wings.members.ensemble import of_study
from rollbench.meshes.section import groove_section

#: Change of a load, in per cent of the mean load, from which a distribution counts as significantly changed: twice the
#: largest error that the source reports of its own model (5.38 %).
SIGNIFICANT = 2.0 * 5.38
#: Fraction of the drawn screws that a claim on random errors must hold in.
SEEN = 0.05


def section_2_4_2(study: Study) -> tuple[Evidence, ...]:
    """Numbers and claims of 2.4.2; those on random errors stay open where the study draws no screws."""
    sheet = Sheet("lin-2.4.2")
    groove = groove_section(study.scene("lin-case1"))
    sheet.number("gamma_low", groove.gamma_1 / np.pi, "Lin C.5")
    sheet.number("gamma_high", groove.gamma_2 / np.pi, "Lin C.5")
    _single_errors(study, sheet)
    if study.members != 0:
        _drawn_errors(study, sheet)
    return sheet.evidence()


def _single_errors(study: Study, sheet: Sheet) -> None:
    base, profile, pitch = (study.solve(name).load for name in ("lin-case1", "lin-profile", "lin-pitch"))
    for name, load in (("profile", profile), ("pitch", pitch)):
        words = f"SL {count_of(load[:, 0] > 0)}, SR {count_of(load[:, 1] > 0)} loaded"
        sheet.claim(f"{name}_two_point", two_point(load), words)
    little, much = load_error(profile, base), load_error(pitch, base)
    sheet.claim(
        "profile_little",
        little.max_percent < SIGNIFICANT,
        f"largest change {little.max_percent:.2f} % of the mean load (pitch errors: {much.max_percent:.1f} %)",
    )
    sheet.claim(
        "pitch_much",
        much.max_percent > SIGNIFICANT,
        f"largest change {much.max_percent:.1f} % of the mean load, ball {much.ball} {much.side}",
    )


def _drawn_errors(study: Study, sheet: Sheet) -> None:
    base = study.solve("lin-case1").load
    random, combined = (of_study(study, name).loads for name in ("lin-random", "lin-combined"))
    kept = np.array([two_point(load) for load in random])
    sheet.claim("random_two_point", bool(kept.mean() > SEEN), f"holds in {count_of(kept)} drawn screws")
    changed = np.array([load_error(load, base).max_percent for load in random])
    low, high = np.percentile(changed, [5, 95])
    sheet.claim(
        "random_much",
        bool((changed > SIGNIFICANT).mean() > SEEN),
        f"largest change {low:.0f} to {high:.0f} % of the mean load in nine of ten drawn screws; significant in "
        f"{count_of(changed > SIGNIFICANT)}",
    )
    four = np.array([bool(np.any(load[:, [1, 2]] > 0.0)) for load in combined])
    words = f"some ball carries on SR or NL in {count_of(four)} drawn screws"
    sheet.claim("combined_four_point", bool(four.mean() > SEEN), words)
