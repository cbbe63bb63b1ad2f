"""Where the printed errors of 2.4.1 come from: readings of what the text leaves open, combined; other statements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import value_of
from rollbench.comparison.reference.levels import SOURCE_LEVEL
from rollbench.comparison.reference.store import load, shipped_store
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.sources.lin.evidence.chapter_2 import READINGS
from rollbench.comparison.sources.lin.reconstruction import combined
from rollbench.comparison.sources.lin.reconstruction.readings import (
    CASES,
    FRICTION,
    MU,
    SOLID,
    Combination,
    key_of,
    largest_change,
    tilt_that_slides,
)
from rollbench.comparison.wings.rolling import runs as rolling
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

if TYPE_CHECKING:
    from rollbench.comparison.scenes.kinds import KindScene

#: Balls that are "the last few".
LAST = 3
FORCE = "force 1-2 N"
#: Scenes of the ball-to-ball forces by table and printed entries: low order, ANSYS.
FORCES = {
    "3.5 (a)": ("lin-3.5", "a_force_numerical", "a_force_ansys", "lin-pair-a"),
    "3.7 (a)": ("lin-3.7", "force_a", "ansys_a", "lin-screw-pair-a-inferred"),
    "3.7 (b)": ("lin-3.7", "force_b", "ansys_b", "lin-screw-pair-b-inferred"),
}


def other_table(study: Study) -> Table:
    """Each statement, what is computed for it, and what follows."""
    rows = [_times(study), _lateral(study), *(_case_3(study, model) for model in ("lin", DEFAULT)), *map(_force, FORCES)]
    return Table.of("reconstruction-others", "Other statements that compare the source's model with ANSYS", rows)


def _statement(place: str, printed: str, computed: str, verdict: str) -> Row:
    return {"place": place, "printed": printed, "computed here": computed, "verdict": verdict}


def _times(study: Study) -> Row:
    """Times of the source's machine beside that of this project's 3D model on a mesh of the same size."""
    run = load(study.scene("lin-case1"), SOURCE_LEVEL, stores=[shipped_store()])
    hours, elements = (value_of("lin-2.2", key) for key in ("time_ansys_1", "elements_ansys"))
    time = (
        "no stored run"
        if run is None
        else f"{run.setup_seconds + run.solve_seconds:.0f} s with {run.unknowns:,} unknowns, measured with {run.measured}"
    )
    return _statement(
        "Table 2.2",
        f"{hours:g} h with {elements:,.0f} elements",
        f"a 3D model of the same cells, condensed by contacts: {time}",
        "a time is its machine's and its method's: not judged; 6800 follows from the printed times",
    )


def _lateral(study: Study) -> Row:
    """Figure 2.10: the largest lateral displacement of the centreline by both models, at the stations of the 3D model."""
    low, found = study.solve("lin-case1"), study.reference("lin-case1")
    assert found is not None
    z, *motion = found.best.centreline.T
    there = [np.interp(z, low.centreline_z, low.centreline[:, k]) for k in range(2)]
    ours, theirs = (float(1e6 * np.hypot(x, y).max()) for x, y in (there, motion[:2]))
    off = 1e6 * float(np.hypot(there[0] - motion[0], there[1] - motion[1]).max())
    share = float(error_percent(off, 0.0, theirs))
    return _statement(
        "Figure 2.10",
        '"good agreement in predicting the presence of lateral deformation"',
        f"largest {ours:.2f} um by the low-order model, {theirs:.2f} um in 3D, {off:.2f} um apart ({share:.0f} %)",
        "the presence comes out; in amount the two differ by that much",
    )


def _case_3(study: Study, model: str) -> Row:
    """Which reading of the right end has the printed shape: by far the most change on SR and NL of the last balls."""
    largest, right = [], []
    for reading in READINGS:
        change = study.solve(reading.offset, model).load - study.solve(reading.plain, model).load
        ball, side = (int(k) for k in np.unravel_index(int(np.abs(change).argmax()), change.shape))
        shaped = has_shape(change)
        right += [reading.label] if shaped else []
        largest.append(f"{reading.label}: most at {ball + 1} {SIDES[side]} ({change[ball, side]:+.0f} N)")
    return _statement(
        "2.4.1.3, case 3",
        "the offset raises SR and NL of the last few balls most",
        f"{model}: {'; '.join(largest)}",
        f"the printed shape has: {', '.join(right) or 'none'}",
    )


def has_shape(change: Array) -> bool:
    """Whether the largest change of any contact ``(n, 4)`` is a rise on SR or NL of one of the last balls."""
    ball, side = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    return bool(side in (1, 2) and ball >= len(change) - LAST and change[ball, side] > 0.0)


def _force(case: str) -> Row:
    """A ball-to-ball force: the source's difference beside what bodies, and elements of its size, change in 3D rolling."""
    table, low_key, ansys_key, name = FORCES[case]
    low, ansys = (value_of(table, key) for key in (low_key, ansys_key))
    scene = cast("KindScene", catalogue.shipped(name))
    coarse, fine = (rolling.load(scene, level, [shipped_store()]) for level in (SOURCE_LEVEL, 3))
    printed = f"{low:g} N, ANSYS {ansys:g} N: {float(error_percent(low, ansys)):.2f} %"
    if coarse is None or fine is None:
        return _statement(f"Table {case}", printed, "no stored run", "not judged")
    value = fine.values[FORCE]
    bodies = float(error_percent(value, fine.limit[FORCE]))
    cells = float(error_percent(coarse.elastic[FORCE], value))
    needed = float(error_percent(ansys, low))
    enough = abs(needed) <= abs(cells) + abs(bodies)
    verdict = (
        "elements of that size do as much: may be its mesh"
        if enough
        else "neither bodies nor elements of that size do as much: the load state, which is not printed, or the solver"
    )
    computed = (
        f"{value:.3f} N; elastic bodies change it by {bodies:+.2f} %, elements of the source's size by {cells:+.1f} %"
    )
    return _statement(f"Table {case}", f"{printed}, that is {needed:+.2f} % of the low-order force", computed, verdict)


# --- where the printed errors of 2.4.1 come from: readings of what the text leaves open, combined


#: In words.
WORDS: dict[combined.Definition, str] = {"own": "of each load", "mean": "of the mean load"}
#: Scatters [%] of an approach that are tried beside the measured one.
TRIED = (1.0, 2.0, 3.0)
#: Points [%] within which a combination has all four printed errors.
NEAR = 0.3
#: Other widths of "about 1.34".
WIDTHS = (0.01, 0.03)
ABOUT_IT = (
    "This is inference: what the source did is not known. Readings of the gaps in its text are judged by "
    'one number only, the one it prints for both models: a largest load of "about 1.34" times the smallest. '
    "The four errors are predicted, not fitted. 3D runs are on the coarsest mesh. The default model and the "
    "3D reference are unchanged."
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report, which opens with the answer."""
    step("combinations of readings")
    found = study.once(combined.combinations)
    shown = [combined.predicted(study, d) for d in combined.DEFINITIONS]
    return Section(
        "reconstruction",
        "Where does 5.38 % come from (2.4.1)",
        (
            Text((first_paragraph(study), ABOUT_IT, second_paragraph(study, found), friction_paragraph(study))),
            predicted_table(shown),
            figure(found),
            one_at_a_time(found),
            met_table(found),
            combination_table(found),
            other_table(study),
        ),
        conclusion=conclusion(study, found),
    )


def names(readings: Combination) -> str:
    """A combination in words."""
    return "; ".join(f"{r.choice}: {r.label}" for r in readings) or "as by default"


def _four(values: Sequence[float]) -> str:
    return f"{values[0]:.2f} / {values[1]:.2f} % (case 1) and {values[2]:.2f} / {values[3]:.2f} % (case 2)"


def conclusion(study: Study, found: list[combined.Combined]) -> str:
    """How many of the printed errors come out where the text's gaps are read so that the printed ratio does."""
    errors, good = combined.predicted(study, "own"), combined.meeting(found)
    if not good:
        return f"No combination of readings meets the printed ratio of {combined.printed_ratio():g} in both models."
    return (
        f"The printed {errors[0].printed:.2f} % comes out at {errors[0].nearest:.2f} % where the gaps in the text "
        f"are read so that both models have its ratio, and as {found[0].errors['own'][0]:.2f} % by default; "
        f"of the four printed errors {sum(p.comes_out for p in errors)} come out."
    )


def first_paragraph(study: Study) -> str:
    """The answer, computed."""
    found = study.once(combined.combinations)
    base, good = found[0], combined.meeting(found)
    errors = combined.predicted(study, "own")
    printed = _four([p.printed for p in errors])
    if not good:
        return f"Where does 5.38 % come from? No combination of readings meets {combined.printed_ratio():g} in both models."
    best = good[0]
    spans = [f"{p.low:.2f} to {p.high:.2f}" for p in errors]
    meshed = [f"{p.meshed_low:.2f} to {p.meshed_high:.2f}" for p in errors]
    inside = [p for p in errors if p.comes_out]
    rest = ", ".join(_label(p) for p in errors if not p.comes_out)
    return (
        f"Where does 5.38 % come from? It comes out at {errors[0].nearest:.2f} % if the gaps in the text are read so that "
        f"both models have the printed ratio: {names(best.low)}; {names(best.solid)}. The ratios are then "
        f"{best.low_ratio:.3f} and {best.solid_ratio:.3f}, the errors {_four(best.errors['own'])}, largest / RMS; printed "
        f"are {printed}. By default they are {base.low_ratio:.3f} and {base.solid_ratio:.3f}, {_four(base.errors['own'])}. "
        f"{len(good)} of {len(found)} combinations of readings have a ratio within {100.0 * combined.ABOUT:g} % of "
        f"{combined.printed_ratio():g} in both models; their errors start from {spans[0]} and {spans[1]} % (case 1), "
        f"{spans[2]} and {spans[3]} % (case 2), with the scatter of the source's mesh from {meshed[0]} and {meshed[1]} %, "
        f"{meshed[2]} and {meshed[3]} %: {len(inside)} of the four come out{(f'; beside it lie {rest}' if rest else '')}."
    )


def _label(p: combined.Predicted) -> str:
    case, kind, _ = p.key.split("_")
    return f"{p.printed:g} ({'largest' if kind == 'max' else 'RMS'}, case {case[-1]})"


def second_paragraph(study: Study, found: list[combined.Combined]) -> str:
    """What no combination meets, and how large a scatter of the mesh would have to be."""
    falls, rises = (
        combined.printed_error(combined.ERRORS[a]) - combined.printed_error(combined.ERRORS[b]) for a, b in ((0, 2), (3, 1))
    )
    changes = [(e[0] - e[2], e[3] - e[1]) for c in found for e in c.errors.values()]
    seen = sum(fall >= 0.5 * falls and rise >= 0.5 * rises for fall, rise in changes)
    near, best = combined.all_four(found, NEAR), combined.meeting(found)[0]
    loads = combined.low_loads(study, best.low), combined.solid_loads(study, best.solid)
    odds = {
        s: combined.probability(combined.drawn_errors(*loads, s), 0.5 * falls, 0.5 * rises)
        for s in (combined.SCATTER, *TRIED)
    }
    widths = "; ".join(_by_width(found, width) for width in WIDTHS)
    chances = ", ".join(f"{s:g} %: {100.0 * p:.1f} %" for s, p in odds.items())
    return (
        f"What {'no combination does' if not seen else f'only {seen} combinations do'}: from case 1 to case 2 the printed "
        f"largest error falls by {falls:.2f} and the RMS rises by {rises:.2f} points; one oversize ball changes both "
        f"models alike, and nothing moves half as much. Tetrahedra of about 0.08 mm make a contact {-combined.BIAS:g} % "
        f"too stiff, and its approach scatters by {combined.SCATTER:g} % from mesh to mesh. Were both cases meshed apart, "
        f"half of that fall and rise had the following probability by scatter of the approach: {chances}. The scatter of "
        f"the mesh explains it only where it is several times what is measured on one contact. Of any ratio, {len(near)} "
        f"combinations have all four errors within {NEAR:g} points{_first(near)}. "
        f'How wide "about" is taken decides what meets it: {widths}.'
    )


def friction_paragraph(study: Study) -> str:
    """What the printed coefficient of friction does to the loads in 3D: of balls that roll, and of balls that do not."""
    scene, base = study.scene(CASES[0]), combined.solid_loads(study, ())
    changed = {r.key: combined.solid_loads(study, (r,)) for r in SOLID if r.choice == FRICTION}
    moved = {key: float(error_percent(combined.ratio(loads[0]), combined.ratio(base[0]))) for key, loads in changed.items()}
    most = max(
        float(np.abs(error_percent(a, b, mean_load(b))).max()) for a, b in zip(changed["off-line"], base, strict=True)
    )
    mean = {key: float(error_percent(mean_load(loads[0]), mean_load(base[0]))) for key, loads in changed.items()}
    worst = 100.0 * largest_change(scene, lambda s: combined.ratio(study.solve(s, "lin").load))
    slope = float(np.abs(study.solve(scene, "lin").centreline[:, 3:5]).max())
    return (
        f"Friction of {MU:g} is computed, too. Two forces act on a ball, on the line through its contacts. One that rolls "
        "feels friction only where it stands beside the line of its arcs' centres, and that shifts both forces and turns "
        f"neither. All balls as far off as {MU:g} can hold them change no load by more than {most:.3f} % of the mean and "
        f"the ratio by {moved['off-line']:+.3f} %; only those by which the ratio rises, by {worst:+.1f} % (low order). "
        f"For that the grooves would have to tilt by {1e3 * tilt_that_slides(scene):.1f} mrad against each other, and "
        f"the shaft's largest slope is {1e3 * slope:.2f} mrad: balls that roll feel next to nothing of it. In a model "
        f"whose balls cannot turn, grooves slide on them. Friction then bears {-mean['sliding']:.2f} % of the load where "
        f"the screw is pushed on, and adds {mean['sliding-back']:.2f} % where it is let back; the ratio changes by "
        f"{moved['sliding']:+.2f} and {moved['sliding-back']:+.2f} %, less than the 0.5 % from which readings are combined."
    )


def _by_width(found: list[combined.Combined], width: float) -> str:
    """How many combinations meet the ratio within another share, and their largest errors of case 1."""
    values = [c.errors["own"][0] for c in combined.meeting(found, width)]
    span = f", whose largest error of case 1 is {min(values):.2f} to {max(values):.2f} %" if values else ""
    return f"within {100.0 * width:g} % {len(values) or 'no'} combinations{span}"


def _first(near: Sequence[combined.Combined]) -> str:
    return f", such as {names(near[0].low)} with {names(near[0].solid)}" if near else ""


def predicted_table(shown: Sequence[Sequence[combined.Predicted]]) -> Table:
    """The printed errors beside what is predicted."""
    rows: list[Row] = [
        {
            "error": f"{_label(p).partition('(')[2].rstrip(')')}, {WORDS[definition]}",
            Quantity("printed", "printed", "%", ".2f"): p.printed,
            Quantity("nearest", "nearest to the ratio", "%", ".2f"): p.nearest,
            Quantity("low", "from", "%", ".2f"): p.low,
            Quantity("high", "to", "%", ".2f"): p.high,
            Quantity("meshed_low", "from, with scatter of the mesh", "%", ".2f"): p.meshed_low,
            Quantity("meshed_high", "to, with scatter of the mesh", "%", ".2f"): p.meshed_high,
            "verdict": "comes out under readings that also give the ratio" if p.comes_out else "does not come out",
        }
        for definition, predictions in zip(combined.DEFINITIONS, shown, strict=True)
        for p in predictions
    ]
    title = "The printed errors, and what the readings that meet the ratio predict"
    return Table.of("reconstruction", title, rows)


def _cells(c: combined.Combined) -> Row:
    row: Row = {
        Quantity("low_ratio", "ratio, low order", "", ".3f"): c.low_ratio,
        Quantity("solid_ratio", "ratio, 3D", "", ".3f"): c.solid_ratio,
    }
    for definition in combined.DEFINITIONS:
        for key, value in zip(combined.ERRORS, c.errors[definition], strict=True):
            label = key.removesuffix("_error").replace("case", "case ").replace("_", " ")
            row[Quantity(f"{definition}_{key}", label, f"% {WORDS[definition]}", ".2f")] = value
    return row


def one_at_a_time(found: list[combined.Combined]) -> Table:
    """Every reading alone, the other model by default."""
    base, rows = found[0], []
    for c in found:
        if len(c.low) + len(c.solid) > 1:
            continue
        ratio, before = (c.low_ratio, base.low_ratio) if c.low else (c.solid_ratio, base.solid_ratio)
        reading = (*c.low, *c.solid)
        row: Row = {
            "model": "low order" if c.low else "3D" if c.solid else "both",
            "reading": names(reading),
            "text": reading[0].by_text if reading else "",
            Quantity("moves", "moves the ratio by", "%", "+.2f"): float(error_percent(ratio, before)),
        }
        rows.append(row | _cells(c))
    return Table.of("reconstruction-alone", "Every reading alone", rows)


def met_table(found: list[combined.Combined]) -> Table:
    """The combinations that meet the ratio, the nearest first."""
    rows = [_row(c) for c in combined.meeting(found)]
    note = "The words of the keys stand in the table before, in its order; base: as by default."
    return Table.of(
        "reconstruction-met", f"Combinations whose models both have about {combined.printed_ratio():g}", rows, note
    )


def combination_table(found: list[combined.Combined]) -> Table:
    """Every combination."""
    rows = [
        _row(c) | {"meets the ratio": "yes" if c.meets() else "no", "text": "against it" if c.against_text else "silent"}
        for c in found
    ]
    note = "Keys as in the table before; combinations that the source's text contradicts are not in that table."
    return Table.of("reconstruction-combinations", f"All {len(found)} combinations of readings", rows, note)


def _row(c: combined.Combined) -> Row:
    row: Row = {"low order": key_of(c.low), "3D": key_of(c.solid)}
    return row | _cells(c)


def figure(found: list[combined.Combined]) -> Figure:
    """Ratios of all combinations, and their errors in both cases with the printed ones."""
    good, aim = combined.meeting(found), combined.printed_ratio()
    others = [c for c in found if c not in good]
    printed_errors = [combined.printed_error(key) for key in combined.ERRORS]

    def cloud(pick: Callable[[combined.Combined], tuple[float, float]], printed: tuple[float, float]) -> tuple[Series, ...]:
        out = []
        for label, of, light in (("other combinations", others, True), ("meet the ratio", good, False)):
            points = [pick(c) for c in of]
            out.append(Series(label, [x for x, _ in points], [y for _, y in points], style="markers", light=light))
        return (*out, Series("printed", [printed[0]], [printed[1]], style="markers", emphasis=True))

    def errors_of(k: int) -> Callable[[combined.Combined], tuple[float, float]]:
        return lambda c: (c.errors["own"][2 * k + 1], c.errors["own"][2 * k])

    panels = (
        Panel("Largest over smallest load", "low order", "3D", cloud(lambda c: (c.low_ratio, c.solid_ratio), (aim, aim))),
        *(
            Panel(
                f"Errors of case {k + 1}, % of each load",
                "RMS [%]",
                "largest [%]",
                cloud(errors_of(k), (printed_errors[2 * k + 1], printed_errors[2 * k])),
            )
            for k in range(2)
        ),
    )
    return Figure("reconstruction", "All combinations of readings", panels, columns=3)
