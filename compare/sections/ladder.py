"""Section on the model ladder: from the source's model to the refined one, step by step against the 3D reference."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.measure import LoadError, error_percent, load_error
from rollbench.compare.models.comparison import REFERENCED
from rollbench.compare.models.model_form import SHARE
from rollbench.compare.models.modelling import RUNGS, UNSEEN, Rung, errors_by_replaced_body, ladder, left_out_one
from rollbench.compare.models.study import Study
from rollbench.lowfi.compliance.bodies import PARTS
from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.meshes.loads import mean_load
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Number of scenes from which on a model's expected errors are drawn.
MANY = 40
#: Choices of the refined model that its derivation leaves open, varied one at a time.
CHOICES: dict[str, Backend] = {
    "patch of the kernels half as wide again": replace(REFINED, width=1.5),
    "patch of the kernels two thirds as wide": replace(REFINED, width=1.0 / 1.5),
    "bore of the smooth nut by wall^3, no layer": replace(REFINED, bore="ring"),
    "bore of the smooth nut by volume": replace(REFINED, bore="volume"),
    "bore of the smooth nut at its lands": replace(REFINED, bore="land"),
    "half as many harmonics again": replace(REFINED, harmonics=1.5),
    "two thirds of the harmonics": replace(REFINED, harmonics=1.0 / 1.5),
    "elements of the kernels half as large": replace(REFINED, mesh=2.0),
    "elements of the kernels half as large again": replace(REFINED, mesh=1.0 / 1.5),
    "flanks as plain half spaces": replace(REFINED, flank=False),
    "balls as half spaces": replace(REFINED, ball="half space"),
    "screw a beam beyond its contacts": replace(REFINED, screw="beam"),
    "section of the screw by Lin C.8": replace(REFINED, section="scene"),
}
#: Scenes on which these choices are varied.
VARIED = ("lin-case1", "lin-case3", "unseen-thin-nut")


@dataclass(frozen=True)
class Changed:
    """Effect of one modelling choice of the refined model on one scene."""

    #: Name of the scene.
    scene: str
    #: Description of the choice.
    label: str
    #: Largest change of a load [% of the mean load].
    change: float
    #: Errors against the reference.
    error: LoadError


def vary_choices(study: Study, name: str) -> Iterator[Changed]:
    """Yield the refined model unchanged and with every choice varied; nothing for a scene without a stored reference."""
    scene, reference = study.scene(name), study.reference(name)
    if reference is None:
        return
    base = solve_elastic(scene, engine="interpreted").load
    mean = mean_load(base, reference.contacts)
    for label, backend in {"as it is": REFINED, **CHOICES}.items():
        load = solve_elastic(scene, backend=backend, engine="interpreted").load
        change = float(np.abs(np.asarray(error_percent(load, base, mean))).max())
        yield Changed(name, label, change, load_error(load, reference.load, reference.contacts))


def ladder_table(rungs: Sequence[Rung]) -> Table:
    """Return the table of the errors of every model of the ladder on every scene."""
    rows: list[Row] = [
        {
            "scene": r.scene,
            "model": r.model,
            Quantity("max", "largest error", "% of mean", ".2f"): r.error.max_percent,
            Quantity("at", "at ball", "", "s"): f"{r.error.ball} {r.error.side}",
            Quantity("rms", "RMS error", "% of mean", ".2f"): r.error.rms_percent,
            Quantity("own", "largest error", "% of own load", ".2f"): r.error.own_max_percent,
            Quantity("bias", "sum of loads", "%", "+.2f"): r.bias,
            Quantity("bar", "grid uncertainty", "% of mean", ".2f"): r.uncertainty,
            Quantity("seconds", "new geometry, interpreted", "s", "g3"): r.seconds,
        }
        for r in rungs
    ]
    note = "; ".join(f"{m.name}: {m.ladder_step[1]}" for m in RUNGS if m.ladder_step) + (
        ". Against the finest stored level of the 3D reference. Scenes named unseen were fixed before they "
        "were solved in 3D, and no choice of the model was based on them. A reference of two levels has "
        "three times their difference as uncertainty. Seconds are those of a new geometry in a running "
        "process; the table of run times has new processes."
    )
    return Table.of("ladder", "Errors of the models on each scene, from the simplest model to the refined one", rows, note)


def ladder_figure(rungs: Sequence[Rung]) -> Figure:
    """Draw largest and RMS error by model: every scene, and the median of the scenes."""
    order = [m.name for m in RUNGS]
    scenes = list(dict.fromkeys(r.scene for r in rungs))

    def panel(title: str, error: Callable[[Rung], float]) -> Panel:
        found = {(r.scene, order.index(r.model) + 1.0): error(r) for r in rungs}
        steps = sorted({x for _, x in found})
        curves = [(name, [x for x in steps if (name, x) in found]) for name in scenes]
        series = [Series(name, x, [found[name, v] for v in x], "line", light=True) for name, x in curves]
        middle = [float(np.median([y for (_, x), y in found.items() if x == step])) for step in steps]
        series.append(Series("median of the scenes", steps, middle, "line+markers", emphasis=True))
        return Panel(title, "", "error / % of the mean load", tuple(series), log="y", names=order)

    panels = (
        panel("largest error", lambda r: float(r.error.max_percent)),
        panel("RMS error", lambda r: float(r.error.rms_percent)),
    )
    caption = f"Pale: each of the {len(scenes)} scenes."
    return Figure(
        "ladder-rungs",
        "Error of each model against the 3D reference, from the simplest to the refined one",
        panels,
        caption,
        same_y=True,
    )


def choices_table(study: Study, step: Callable[[str], None]) -> Table:
    """Return the table of the effect of each choice of the refined model, changed one at a time."""
    rows: list[Row] = []
    for name in VARIED:
        step(f"choices of the refined model varied on {name}")
        rows += [
            {
                "scene": c.scene,
                "choice": c.label,
                Quantity("change", "largest change of a load", "% of mean", ".2f"): c.change,
                Quantity("max", "largest error with it", "% of mean", ".2f"): c.error.max_percent,
                Quantity("rms", "RMS error", "% of mean", ".2f"): c.error.rms_percent,
            }
            for c in vary_choices(study, name)
        ]
    note = (
        "Choices of the refined model, made by argument and not fitted: a patch as wide as the groove (half "
        "the distance between the contacts of its two flanks), because a smooth body cannot resolve "
        "anything finer; nut grooves as a layer that is softer along the axis than around it, because lands "
        "are rings supported only from below; as many harmonics as a patch can excite."
    )
    return Table.of(
        "ladder-choices", "Change of the refined model's errors when one of its modelling choices is varied", rows, note
    )


def shares_table(study: Study) -> Table:
    """Return the table of how much each body's simplification contributes to the refined model's error."""
    found = study.once(errors_by_replaced_body)
    names: dict[tuple[str, ...], str] = {(): "none", ("screw",): "screw", ("nut",): "nut", PARTS: "both"}
    rows: list[Row] = []
    for share in found:
        row: Row = {"scene": share.scene}
        for parts, name in names.items():
            error = share.errors[parts]
            row[Quantity(f"max {name}", f"{name} from 3D: largest", "% of mean", ".2f")] = error.max_percent
            row[Quantity(f"rms {name}", f"{name} from 3D: RMS", "% of mean", ".2f")] = error.rms_percent
        row[Quantity("bias", "sum, none from 3D", "%", ".2f")] = share.bias[()]
        row[Quantity("bias both", "sum, both", "%", ".2f")] = share.bias[PARTS]
        rows.append(row)
    note = (
        "The refined model with one part replaced by the finest 3D run: either the compliance of a body "
        "between its contacts, or the contact laws on it. What a replacement removes is that body's share "
        "of the error. What remains belongs to the rest of the low-order model (contact law, kinematics, "
        "beam beyond the nut) and to the reference's own uncertainty."
    )
    return Table.of("ladder-shares", "Where the refined model's error comes from", rows, note)


def estimate_items(study: Study, rungs: Sequence[Rung]) -> list[Table | Figure]:
    """Return table and figure of each screw's error as expected from all other screws, and as measured."""
    rows = left_out_one(study, rungs)
    lines: list[Row] = []
    panels = []
    for model in dict.fromkeys(row["model"] for row in rows):
        of_model = [row for row in rows if row["model"] == model]
        covered = [row for row in of_model if row["expected"] is not None]
        if not covered:
            continue
        measured, expected = (np.array([row[key] for row in covered], float) for key in ("measured", "expected"))
        held = f"{int((measured <= expected).sum())} of {len(covered)}"
        ratio = expected / np.maximum(measured, 1e-9)
        lines.append(
            {
                "model": model,
                "scenes": str(len(of_model)),
                Quantity("covered", "covered by the others", "", "s"): str(len(covered)),
                Quantity("held", "within what was expected", "", "s"): held,
                Quantity("ratio", "expected over measured, median", "", ".2f"): float(np.median(ratio)),
                Quantity("expected", "expected, median", "% of mean", ".2f"): float(np.median(expected)),
                Quantity("largest", "expected, largest", "% of mean", ".2f"): float(expected.max()),
            }
        )
        if len(covered) >= MANY:
            ends = [float(min(measured.min(), expected.min())), float(max(measured.max(), expected.max()))]
            series = (
                Series("scenes", measured.tolist(), expected.tolist(), "markers", emphasis=True),
                Series("expected as measured", ends, ends, "line"),
            )
            panels.append(Panel(model, "measured / % of the mean load", "expected / %", series, log="xy"))
    note = (
        "For every screw, shipped or surveyed, the largest load error is estimated from all other screws: a "
        "linear fit of the logarithm of the error over the features, times the factor that covers "
        f"{SHARE:.0%} of the other scenes."
    )
    out: list[Table | Figure] = [
        Table.of("ladder-estimate", "The model-form estimate tested on the compared scenes", lines, note)
    ]
    if panels:
        caption = "On or above the line the error was no larger than expected."
        out.append(
            Figure(
                "ladder-estimate-figure",
                "Measured over expected error of the models, for each compared screw",
                tuple(panels),
                caption,
            )
        )
    return out


def largest_errors_sentence(rungs: Sequence[Rung]) -> str:
    """Return a sentence on the largest errors by model, on case studies and on screws not used in development."""
    words = []
    for label, names in (("case studies", REFERENCED), ("unseen screws", UNSEEN)):
        for model in ("lin", "refined", "condensed"):
            of_label = [r for r in rungs if r.model == model and r.scene in names]
            if of_label:
                worst = max(of_label, key=lambda r: r.error.max_percent)
                words.append(
                    f"{label}, {model}: largest {worst.error.max_percent:.2f} % ({worst.scene}), RMS up to "
                    f"{max(r.error.rms_percent for r in of_label):.2f} %"
                )
    return "In per cent of the mean load against the 3D reference: " + "; ".join(words) + "."


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("every rung on every scene with a reference")
    rungs = study.once(ladder)
    title = "From the source's model to the refined one"
    if not rungs:
        return Section("ladder", title, (Text(("No run of the 3D reference was found.",)),))
    text = (
        (
            "The refined model keeps the source's contact mechanics and its energy, and adds the elasticity of "
            "screw, nut and balls. The screw is a beam with the section of half a lead of grooved shaft "
            "(axisymmetric elements, harmonics 0 and 1); the nut is a beam too. Both gain what a smooth body of "
            "revolution does beyond a beam (Fourier harmonics around the axis: ovalisation, ends, clamped "
            "face), and what the true flank adds to that, less the half space already in Hertz's law. Tension "
            "and bending of a screw that continues beyond the nut squeeze its contacts by Poisson's ratio "
            "(Saint-Venant). Balls are elastic spheres (Lur'e's series); bearing rings are bodies of revolution "
            "with their groove. It contains no 3D solve, and nothing is fitted to one."
        ),
        largest_errors_sentence(rungs),
    )
    step("bodies exchanged for those from 3D")
    items = (Text(text), ladder_table(rungs), ladder_figure(rungs), shares_table(study), choices_table(study, step))
    median = {
        name: float(np.median([r.error.max_percent for r in rungs if r.model == name])) for name in ("lin", "refined")
    }
    conclusion = (
        f"The median of the largest error falls from {median['lin']:.1f} % in lin to {median['refined']:.1f} % of the mean "
        "load in the refined model."
    )
    return Section("ladder", title, (*items, *estimate_items(study, rungs)), conclusion=conclusion)
