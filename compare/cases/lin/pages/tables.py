"""Report pages with the tables of Lin's thesis in its layout: printed and computed numbers, run times, figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import product

from rollbench.compare.case import CASES
from rollbench.compare.cases.lin.evidence import chapter_2
from rollbench.compare.cases.lin.evidence.rotary_linear import solve_linear_ball_pair
from rollbench.compare.cases.lin.evidence.source_cases import finest_rolling_run
from rollbench.compare.cases.lin.pages.friction import bearing_torque_figure, rotary_bearing_torque_figure
from rollbench.compare.cases.lin.times import LINEAR, SCREW, STATIC, stored_run_times
from rollbench.compare.evidence import PrintedEntryComparison, evidence
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import SceneResultCache, with_conformity
from rollbench.compare.printed import VERDICT_NAMES, printed_entry, printed_table_names, printed_value
from rollbench.compare.reference.convergence import relative_cell_size
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import UNMEASURED, load_stored_run, shipped_store
from rollbench.compare.running import show_progress_message
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind as case_of
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.sections import source_tables
from rollbench.compare.sections.curves import contact_load_curve, contact_load_panel
from rollbench.compare.sections.reference_time import run_times_to_show
from rollbench.compare.sections.verdicts import printed_numbers_table
from rollbench.compare.studies.rolling import runs as rolling
from rollbench.meshes.section import nodes_of_whole_beam
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

LIN = next(case for case in CASES if case.name == "lin")
#: Computer and programs of the printed run times (footnotes of Tables 2.2 and 3.5, sections 3.4.3 and 2.4.1).
MACHINE = "Intel Core i7-3770, 3.40 GHz, 16 GB; ANSYS Workbench 16.2, and Lin's own program"
UNITS = {"s": 1.0, "h": 3600.0}

#: Scene and model, by name of the printed run time.
TIMED = {f"lin-2.2:time_proposed_{k}": (name, "lin") for k, name in STATIC.items()}
TIMED |= {f"lin-2.2:time_ansys_{k}": (name, "3D") for k, name in STATIC.items()}
TIMED |= {
    f"lin-3.5:{case}_time_{column}": (name, way)
    for case, name in LINEAR.items()
    for column, way in (("numerical", "numerical"), ("analytic", "formula"), ("ansys", "3D"))
}
TIMED |= {f"lin-3.7:time_{case}": (name, "numerical") for case, name in SCREW.items()}
TIMED |= {f"lin-3.7:time_ansys_{case}": (name, "3D") for case, name in SCREW.items()}
#: Names of the printed numbers of elements, by scene and model.
SIZES = {(name, "lin"): "lin-2.2:elements_proposed" for name in STATIC.values()}
SIZES |= {(name, "3D"): "lin-2.2:elements_ansys" for name in STATIC.values()}
SIZES |= {(name, "3D"): "lin-3.5:elements_ansys" for name in LINEAR.values()}
SIZES |= {(name, "3D"): f"lin-3.7:elements_{case}" for case, name in SCREW.items()}


def printed_run_time_seconds(name: str) -> float:
    """Return a printed run time [s]; ``name``: table and key of the printed number, such as "lin-2.2:time_ansys_1"."""
    one = printed_entry(*name.split(":"))
    return UNITS[one.unit] * (one.value or 0.0)


def model_size_in_3d_in_words(cache: SceneResultCache, name: str) -> str:
    """Return in words the number of unknowns or cells of a scene's finest stored 3D model; empty if none is stored.

    ``cache``: gives stored 3D results; ``name``: name of the scene.
    """
    if name in STATIC.values():
        found = cache.stored_reference(name)
        if found is None:
            return ""
        return f"{found.best.unknowns:,} unknowns of the equivalent mesh (level {found.best.level})"
    run = finest_rolling_run(cache, name)
    return "" if run is None else f"{run.shape[0]} x {run.shape[1]} cells a contact"


def beam_element_count_in_words(cache: SceneResultCache, name: str) -> str:
    """Return in words the number of beam elements in a scene's low-order model, by default and with Lin's partition.

    ``cache``: gives the scenes included with rollbench; ``name``: name of the scene.
    """
    count = len(nodes_of_whole_beam(cache.built_in_scene(name))) - 1
    return f"{count} ({chapter_2.lin_beam_element_count(cache)} with Lin's partition)"


def model_size_in_words(cache: SceneResultCache, name: str, model: str) -> str:
    """Return in words the size of this package's model of a scene; ``model``: "lin" (static model) or "3D".

    ``cache``: gives solved scenes and stored 3D results; ``name``: name of the scene.
    """
    return (beam_element_count_in_words if model == "lin" else model_size_in_3d_in_words)(cache, name)


def run_time_ratio(slow_seconds: float | None, fast_seconds: float | None) -> float | None:
    """Return the run time ``slow_seconds`` divided by ``fast_seconds``; None if one of them is missing or zero."""
    return None if not slow_seconds or not fast_seconds else slow_seconds / fast_seconds


def run_times_table(
    cache: SceneResultCache, layout: source_tables.PrintedLayout, found: Mapping[str, PrintedEntryComparison]
) -> Table:
    """Return the table of run times and model sizes for a table of Lin's thesis: printed and measured, with their ratios.

    ``cache``: gives stored run times; ``layout``: rows and columns of the table in the thesis; ``found``: printed values
    with the computed ones, by name ``table:key``.
    """
    names = [
        (label, head, n) for label, row in layout.rows for head, n in zip(layout.columns, row, strict=True) if n in TIMED
    ]
    ansys = {TIMED[n][0]: printed_run_time_seconds(n) for _, _, n in names if TIMED[n][1] == "3D"}
    rows: list[Row] = []
    for label, head, name in names:
        scene, way = TIMED[name]
        printed, own = found[name].printed, stored_run_times(cache, scene, way)
        solid, slow = ((None, None), None) if way == "3D" else (stored_run_times(cache, scene, "3D"), ansys[scene])
        size = SIZES.get((scene, way))
        rows.append(
            {
                "printed_row": label,
                "printed_column": head,
                "printed_run_time": f"{printed.number_as_printed} {printed.unit}",
                "printed_time_ratio": run_time_ratio(slow, printed_run_time_seconds(name)),
                "cold_start": own[0],
                "further_load_case": own[1],
                ("time_ratio_here", "cold start"): run_time_ratio(solid[0], own[0]),
                ("time_ratio_here", "further load case"): run_time_ratio(solid[1], own[1]),
                "printed_elements": f"{printed_value(*size.split(':')):,.0f}" if size else "",
                "elements": model_size_in_words(cache, scene, way) if size else "",
                "verdict": VERDICT_NAMES[found[name].verdict],
                "how": f"how-{printed.table}",
            }
        )
    note = f"The text: {SPEED[layout.number]}. {run_times_note(cache)}"
    title = f"Lin's Table {layout.number}: printed and measured run times"
    return Table.from_rows(layout.stem("times"), title, rows, note, unfolded=True)


def further_cells(cache: SceneResultCache) -> dict[str, Row]:
    """Return further cells of the report's copies of Lin's tables, by name of the printed number beside which they stand.

    For Tables 3.4 and 3.5: velocity deviations [%] and ball-to-ball force [N] under the contact loads that section 3.3.4.1
    of the thesis assumes, equal at both contacts of each diagonal; for Tables 3.5 and 3.7: printed differences from ANSYS
    [%]; for Table B.1: correct values for the groove with which Lin computed the table (his Table 2.1 states another one).
    ``cache``: gives the solved scenes.
    """
    cells: dict[str, Row] = {}
    for case, k in product("ab", (1, 2)):
        value = 100.0 * float(solve_linear_ball_pair(loads="diagonal", mated=case == "b").velocity_deviation[k - 1])
        cells[f"lin-3.4:{case}_eps{k}_numerical"] = {"value_at_equal_loads": value if abs(value) > 1e-9 else 0.0}
    low, ansys = (printed_value("lin-3.5", f"a_force_{way}") for way in ("analytic", "ansys"))
    cells["lin-3.5:a_force_numerical"] = {
        "lin_difference_from_ansys": printed_value("lin-3.5", "error_numerical"),
        "value_at_equal_loads": solve_linear_ball_pair(loads="diagonal").ball_to_ball_force,
    }
    cells["lin-3.5:a_force_analytic"] = {"lin_difference_from_ansys": float(error_percent(low, ansys))}
    for case in SCREW:
        off = printed_value("lin-3.7", f"difference_{case}")
        cells[f"lin-3.7:force_{case}"] = {"lin_difference_from_ansys": off}
    scene = with_conformity(cache.built_in_scene("lin-case1"), chapter_2.TABLE_CONFORMITY)
    column = "value_at_conformity", f"{chapter_2.TABLE_CONFORMITY:g}"
    return cells | {f"lin-B1:{k}": {column: x} for k, x in chapter_2.correct_values_of_table_b_1(scene).items()}


#: Lin's statements on run times, by number of the table.
SPEED = {
    "2.2": "over 6800 times faster (2.4.1.4)",
    "3.5": "three orders of magnitude, the formula another two (3.3.5); at least three (3.5)",
    "3.7": "three orders of magnitude (3.4.3); at least three (3.5)",
}
#: Notes of tables, by number of the table.
NOTES = {
    "3.2": "Case (I), losses P_f,IL and P_f,OR: the contact that sticks between rigid bodies creeps in 3D, as bodies are "
    "elastic, and both contacts share the ball's spin; sum and torque change little (table rolling-ring).",
    "3.4": "Δβ_TR, Δβ_TL: deviation of the contact angle on the right and left flank of the top groove; θ: on the right "
    "flank of the bottom groove, −θ on its left one. Low-order and 3D values computed here: contact loads in equilibrium "
    "at the stated contact angles, as in Table 3.5.",
    "3.5": "Low-order and 3D values computed here: contact loads in equilibrium at the stated contact angles, as in Table "
    "3.4.",
    "B.1": "Low-order value computed here: groove radius of Table 2.1, 3.254 mm; the printed values belong to another "
    "groove radius.",
}
#: Reason why a printed number has no 3D value, by the first characters of its name.
WHY = {
    "lin-3.2:F_": "none: statics",
    "lin-3.2:P_": "none: no contact",
    "lin-B1:": "none: closed form",
    "lin-2.4.1:case1_ratio": "none: is of the low-order model",
    "lin-2.4.1:case": "none: is an error against 3D",
    "lin-2.4.1:": "none: of run times",
    "lin-3.2:": "none: of the table",
    "lin-3.3:": "none: of the map",
    "lin-3.5:error": "none: of the table",
    "lin-3.7:difference": "none: of the table",
    "lin-3.4.4:": "none: 37 balls over time exceed the 3D model",
    "lin-3.7:within": "none: of the tables",
    "lin-4.2.1:": "none: layout is not printed",
    "lin-4.3:": "none: many rolling balls exceed the 3D model",
}


def reason_for_missing_3d_value(name: str) -> str:
    """Return the reason why a printed number has no 3D value, empty if none is given.

    ``name``: table and key of the printed number, such as "lin-2.2:time_ansys_1".
    """
    return next((text for start, text in WHY.items() if name.startswith(start)), "")


def run_time_and_size_texts(cache: SceneResultCache) -> dict[str, str]:
    """Return texts on run times and model sizes, to be shown in Lin's tables instead of computed numbers.

    The keys are names of printed numbers, such as "lin-2.2:time_ansys_1". ``cache``: gives stored run times and 3D results.
    """

    def run_times_in_words(name: str, model: str) -> str:
        """Return in words the run times of the scene ``name`` by the model ``model``, as in `stored_run_times`."""
        cold, further = stored_run_times(cache, name, model)
        return "–" if cold is None else f"{cold:.3g} s cold, {further or 0.0:.2g} s further"

    out = {name: run_times_in_words(*of) for name, of in TIMED.items()}
    for of, name in SIZES.items():  # of several scenes with one printed number, the first one counts
        out.setdefault(name, model_size_in_words(cache, *of))
    return out


# --- figures


def case_study_loads_figure(cache: SceneResultCache) -> Figure:
    """Draw contact loads over the ball's number in Lin's case studies, by low-order model and 3D reference.

    Lin's statements on the loads are shown as markers and lines.

    ``cache``: gives solved scenes and stored 3D references.
    """
    panels, case_3 = [], chapter_2.END_SUPPORTS[0]
    plain, offset = (cache.solve_once(name) for name in (case_3.plain_scene, case_3.offset_scene))
    printed = [printed_value("lin-2.4.1", "case1_ratio") * float(cache.solve_once("lin-case1").load[:, 0].min())] * 2
    rise = float(cache.solve_once("lin-case2").load[16, 0])
    statements = (
        [
            contact_load_curve("Mei: uniformly decreasing", cache.solve_once("lin-case1", "mei"), 0, "line"),
            Series("printed: largest is 1.34 times the smallest", [1.0, 32.0], printed, "line"),
        ],
        [Series("printed: abrupt increase at ball 17 alone", [17.0], [rise], "markers")],
        [contact_load_curve("low-order, no offset", plain, 0, "line")],
    )
    studies = zip((STATIC[1], STATIC[2], case_3.offset_scene), statements, strict=True)
    for k, (name, of_text) in enumerate(studies, start=1):
        low, found = cache.solve_once(name), cache.stored_reference(name)
        series = [contact_load_curve("low-order (Lin's model)", low, 0, emphasis=True)]
        if found is not None:
            series.append(contact_load_curve(f"3D reference, level {found.best.level}", found, 0, "line"))
        panels.append(contact_load_panel(f"case study {k}, flank SL", *series, *of_text))
    last = Series("printed: SR and NL of the last few balls increase most", [32.0], [float(offset.load[31, 1])], "markers")
    curves = (
        contact_load_curve("SR, offset of 300 µm", offset, 1, emphasis=True),
        contact_load_curve("SR, no offset", plain, 1),
        last,
    )
    panels.append(contact_load_panel("case study 3, flank SR", *curves))
    caption = (
        "SL, SR: left and right flank of the screw; NL, NR: left and right flank of the nut. Opposite contacts (SL and "
        "NR, SR and NL) have equal loads. Markers and straight lines: statements of Lin's text."
    )
    title = "Lin's case studies: contact load of each ball, computed, and as Lin's text describes it"
    return Figure("lin-loads", title, tuple(panels), caption)


def error_over_cell_size_figure(cache: SceneResultCache) -> Figure:
    """Draw the errors of contact loads and ball-to-ball forces in 3D against the finest grid, over the cell size.

    ``cache``: gives solved scenes and stored 3D references.
    """
    static, balls = [], []
    for name in STATIC.values():
        found = cache.stored_reference(name)
        if found is None:
            continue
        coarse = load_stored_run(cache.built_in_scene(name), SOURCE_LEVEL, stores=cache.reference_folders)
        runs = [*([coarse] if coarse is not None else []), *found.runs[:-1]]
        sizes = [relative_cell_size(r.settings) / found.sizes[-1] for r in runs]
        errors = [load_error(r.load, found.load, found.contacts).own_max_percent for r in runs]
        static.append(Series(f"{name}, 3D", sizes, errors))
        low = load_error(cache.solve_once(name).load, found.load, found.contacts).own_max_percent
        static.append(Series(f"{name}, low-order", [1.0, max(sizes)], [low, low], "line", pale=True))
    printed = printed_value("lin-2.4.1", "case1_max_error")
    static.append(Series("printed: low-order against ANSYS, case 1", [1.0, 4.0], [printed, printed], "line"))
    for name in (LINEAR["a"], *SCREW.values()):
        stores = cache.reference_folders or (shipped_store(),)
        scene, levels = case_of(name, FrictionScene), (0, *rolling.LEVELS)
        good = [run for level in levels if (run := rolling.load_rolling_run(scene, level, stores)) is not None]
        if len(good) > 1:
            finest = good[-1].values["force 1-2 N"]
            cells = [1.0 / run.shape[1] * good[-1].shape[1] for run in good[:-1]]
            off = [abs(float(error_percent(run.values["force 1-2 N"], finest))) for run in good[:-1]]
            balls.append(Series(f"{name}, 3D", cells, off))
    axes = "cell size over that of the finest grid", "largest error / % of contact's load"
    title = "error of the ball-to-ball force in 3D (Tables 3.5, 3.7)"
    panels = (
        Panel("largest error of a contact load in 3D (Table 2.2)", *axes, tuple(static), log_axes="xy"),
        Panel(title, axes[0], "error of the force / %", tuple(balls), log_axes="xy"),
    )
    caption = (
        "Errors against the finest mesh; pale lines: errors of the low-order model. The coarsest point has the element "
        "sizes of Lin's ANSYS models: 0.08 mm at the contacts of his ball screw, 0.13 and 0.05 mm at those of his models "
        "of two balls."
    )
    title = "Lin's case studies: error of the 3D models, plotted against their cell size"
    return Figure("lin-mesh", title, panels, caption)


def case_study_load_and_error_rows(cache: SceneResultCache) -> Iterator[Row]:
    """Yield table rows of Lin's case studies, one for each model: largest and smallest load, errors against 3D reference.

    Case 3 stands with and without offset, for each support of the right end that has a 3D reference; the first is that of
    Lin's text. ``cache``: gives solved scenes and stored 3D references.
    """
    studies = [("1", STATIC[1]), ("2", STATIC[2])]
    for reading in chapter_2.END_SUPPORTS:
        beside = "" if reading.is_stated_by_text else f", other reading: {reading.restraint}"
        studies += [(f"3{beside}", reading.offset_scene), (f"3 without offset{beside}", reading.plain_scene)]
    for study, name in studies:
        found = cache.stored_reference(name)
        if found is None:
            continue
        keys = [f"case{study}_{what}_error" for what in ("max", "rms")] if study in ("1", "2") else []
        models = ("lin", "refined", *(("mei",) if name == STATIC[1] else ()))
        answers = {"3D reference": found.load} | {model: cache.solve_once(name, model).load for model in models}
        for model, value in answers.items():
            e = load_error(value, found.load, found.contacts)
            apart = model != "3D reference"
            shown = " / ".join(printed_entry("lin-2.4.1", key).number_as_printed for key in keys) if model == "lin" else ""
            loaded = value[value > 0.0]
            own_max, own_rms, mean_max = (e.own_max_percent, e.own_rms_percent, e.max_percent) if apart else (None,) * 3
            yield {
                "case_study": study,
                "scene": name,
                "model": model,
                "largest_load": float(loaded.max()),
                "smallest_load": float(loaded.min()),
                "load_ratio_on_sl_f4": chapter_2.load_ratio(value[:, 0]),
                "largest_load_error_own": own_max,
                "rms_error_own": own_rms,
                "largest_load_error": mean_max,
                "lin_errors_max_rms": shown,
            }


def case_study_loads_and_errors_table(cache: SceneResultCache) -> Table:
    """Return the table of contact loads and model errors in Lin's case studies, one row for each model.

    ``cache``: gives solved scenes and stored 3D references.
    """
    title = "Lin's case studies: largest and smallest contact load, and errors of each model against the 3D reference"
    note = (
        "Case 3: the right end is restrained in x only, as Lin's text says; other reading: in x and y, as by a bearing. "
        "mei: the model of Mei et al., which Lin compares with in case 1. Command for case 1: rollbench compare lin-case1."
    )
    return Table.from_rows("lin-answers", title, case_study_load_and_error_rows(cache), note)


def case_study_answer_table(cache: SceneResultCache) -> Table:
    """Return the table with a line for each of Lin's case studies: load error and run time of his model, printed and found.

    ``cache``: gives solved scenes, stored 3D references and run times.
    """
    rows: list[Row] = []
    for row in case_study_load_and_error_rows(cache):
        study = str(row["case_study"])
        if row["model"] == "lin" and study in ("1", "2", "3", "3 without offset"):
            printed = study in ("1", "2", "3")
            seconds = stored_run_times(cache, STATIC[int(study)], "lin")[0] if printed else None
            rows.append(
                {
                    "case_study": study,
                    "printed_load_error": printed_value("lin-2.4.1", f"case{study}_max_error")
                    if study in ("1", "2")
                    else None,
                    "largest_load_error_own": row["largest_load_error_own"],
                    "printed_seconds": printed_run_time_seconds(f"lin-2.2:time_proposed_{study}") if printed else None,
                    "cold_start": seconds,
                }
            )
    note = (
        "Found: against the 3D reference; the right end of case 3 is held as the text says. Table lin-answers has the "
        f"loads, errors in per cent of the mean load, and the other reading of case 3. Printed run times: {MACHINE}. "
        f"{cache.compute_once(run_times_to_show, show_progress_message) or UNMEASURED}"
    )
    title = "Lin's case studies: load error and run time of Lin's model, as printed and as found"
    return Table.from_rows("lin-answer", title, rows, note)


def case_study_answer_sentence(answer: Table) -> str:
    """Return the sentence on the load errors of Lin's model in the case studies; ``answer``: `case_study_answer_table`."""
    rows = [row for row in answer.rows if row["printed_load_error"] is not None]
    if not rows:
        return ""
    found, printed = (
        " and ".join(f"{row[key]:.2f}" for row in rows) for key in ("largest_load_error_own", "printed_load_error")
    )
    cases = " and ".join(str(row["case_study"]) for row in rows)
    return (
        f"Lin's model is off by up to {found} % of a contact's load in cases {cases}; against ANSYS the thesis prints "
        f"{printed} %."
    )


FIGURES: Mapping[str, tuple[Callable[[SceneResultCache], Table | Figure], ...]] = {
    "2.2": (case_study_loads_and_errors_table, case_study_loads_figure, error_over_cell_size_figure),
    "3.2": (lambda _: rotary_bearing_torque_figure(),),
    "4.2": (lambda _: bearing_torque_figure(),),
}

GUIDE = (
    "The tables of the thesis stand here in its order and layout, each with what is computed for its numbers; then the "
    "sentences with numbers, claims in words, and the other numbers. A table of results stands twice: in the layout of the "
    "thesis with the computed value at each number, and with a row for each number. Low-order: the text as printed with "
    "correct constants; with the thesis's faults: those named in the remark repeated; inferred: under an assumption that "
    "was inferred from printed results."
)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> tuple[Section, ...]:
    """Return the report's sections with the tables of Lin's thesis.

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("printed numbers of the thesis")
    names = [name for name in printed_table_names() if name.startswith("lin-")]
    found = {f.printed.name: f for f in evidence(cache, *names)}
    every = source_tables.read_table_layouts(LIN)
    placed = {name for layout in every for name in layout.names}
    claims = [f for f in found.values() if f.printed.claim and f.printed.name not in placed]
    others = [f for f in found.values() if not f.printed.claim and f.printed.name not in placed]
    answer, counts = case_study_answer_table(cache), printed_results_sentences(found.values())
    first = Section(
        "lin",
        "Lin's thesis: error and run time of its model, and number of printed values that are reproduced",
        (answer, Text((*counts[1:], GUIDE)), source_tables.counts_of_reproduced_numbers_table(list(found.values()))),
        conclusion=" ".join(filter(None, (case_study_answer_sentence(answer), counts[0]))),
    )

    def section(name: str, title: str, heading: str, entries: list[PrintedEntryComparison]) -> Section:
        """Return a section with one table of printed numbers or claims; ``heading``: title of the table."""
        return Section(name, title, (printed_numbers_table(name, heading, entries, with_place=True),))

    title = "Claims of Lin's thesis in words, and whether each claim holds"
    last = [section("lin-claims", title, "Claims of Lin's thesis in words: whether each claim holds", claims)]
    title = "Numbers that Lin's thesis prints outside its tables"
    last.append(section("lin-others", title, f"{title} and figures", others))
    title = "How each printed number of Lin's thesis is recomputed"
    last.append(Section("lin-how", title, tuple(source_tables.tables_on_computation_of_numbers(names))))
    return first, *(printed_table_section(cache, layout, found) for layout in every), *last


def printed_results_sentences(found: Iterable[PrintedEntryComparison]) -> tuple[str, str]:
    """Return the sentence on how many printed results are reproduced or contradicted, and the sentences on the others.

    ``found``: printed values and claims with the computed ones.
    """
    numbers = [f for f in found if not f.printed.claim]
    tally = Counter(f.verdict for f in numbers)
    results = len(numbers) - tally["input"] - tally["identity"]
    return (
        f"Of {results} results that Lin's thesis prints, {tally['reproduced']} are reproduced, {tally['only as printed']} "
        f"only with the thesis's own mistake repeated, {tally['band']} lie within a tolerance band, and "
        f"{tally['contradicted']} are contradicted.",
        f"{tally['not identifiable']} printed results are not determined by the text: they are measured, computed by "
        f"another program, or depend on what is not printed. The other {len(numbers) - results} of {len(numbers)} printed "
        "numbers are inputs and identities.",
    )


def printed_table_section(
    cache: SceneResultCache, layout: source_tables.PrintedLayout, found: Mapping[str, PrintedEntryComparison]
) -> Section:
    """Return the report's section on one table of Lin's thesis, or on the numbers in the thesis's sentences.

    ``layout``: rows and columns of the table in the thesis; ``found``: printed values with the computed ones, by name.
    ``cache``: gives the solved scenes.
    """
    items: list[Table | Figure] = []
    if layout.kind == "inputs":
        items.append(source_tables.printed_input_table(layout, found))
    else:
        if layout.kind == "results":
            items.append(source_tables.printed_and_computed_table_in_layout(layout, found, run_time_and_size_texts(cache)))
        reasons = {name: reason_for_missing_3d_value(name) for name in layout.names}
        note = NOTES.get(layout.number, "")
        more = {name: cells for name, cells in cache.compute_once(further_cells).items() if name in layout.names}
        items.append(source_tables.printed_and_computed_table(layout, found, more, reasons, list(TIMED), note))
        if any(name in TIMED for name in layout.names):
            items.append(run_times_table(cache, layout, found))
    items += [draw(cache) for draw in FIGURES.get(layout.number, ())]
    return Section(f"lin-table-{layout.number}", layout.heading, items)


def run_times_note(cache: SceneResultCache) -> str:
    """Return the note on how printed and measured run times were obtained; ``cache``: gives stored run times."""
    kept = cache.compute_once(run_times_to_show, show_progress_message)
    return (
        f"Printed: {MACHINE}. Computed here, cold start: a new process with empty caches, imports included; further load "
        f"case: the next one in that process; ANSYS rows: this package's 3D model. {kept or UNMEASURED}"
    )
