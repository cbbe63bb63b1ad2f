"""Commands ``sweep`` and ``table``: solve a scene for many values of its parameters.

``sweep`` prints statistics over sampled values; ``table`` prints stiffness, preload, pressure and life for each value.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from rollbench.compare.commands import terminal
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, TextTable, format_cell, print_command_output

if TYPE_CHECKING:
    from rollbench.compare.studies.sweep.run import Sweep


@terminal.app.command
def sweep(
    scene: str,
    *,
    vary: Annotated[list[str], Parameter(negative="")],
    samples: int = 256,
    method: Literal["sobol", "lhs", "grid"] = "sobol",
    model: terminal.Word = "",
    seed: int = 0,
    outputs: terminal.Word = "",
    out: Path = Path("rollbench-sweep"),
    as_json: terminal.Json = False,
    program: terminal.ProgramOptions | None = None,
    where: terminal.ComputeOptions | None = None,
) -> int:
    """Solve a scene for many sampled values of its parameters, and print statistics and the effect of each parameter.

    Each sample is stored as soon as it is solved, so an interrupted sweep resumes.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    vary
        Parameter with its range or values, KEY=A:B, KEY=A:B:N or KEY=v1,v2; repeat the option for every parameter. KEY is
        the key in the scene file with its tables and indices, with units as there, such as "track.lead=8 mm:12 mm"; the key
        load is the axial load.
        KEY+KEY=... varies several keys together. A range of whole numbers without unit is sampled in whole numbers
        (errors.seed=1:1000).
    samples
        Number of samples. sobol uses the nearest n (k + 2) for k parameters with n a power of two; grid uses at most this
        number.
    method
        Design of the samples: sobol (Sobol sequence, with Sobol indices), lhs (Latin hypercube) or grid.
    model
        Low-order model (rollbench list shows all). Default: refined.
    seed
        Seed of the random numbers from which the samples are drawn.
    outputs
        NAME,NAME: quantities to compute in addition to the largest load; their names are the columns of samples.csv.
        Default: all; a wrong name lists them. A sample needs one solution, with rigidity_N_per_um or preload_N two.
    out
        Folder of samples and summary; samples that are stored there are not solved again.
    """
    from rollbench.compare.files import reason_without_figure
    from rollbench.compare.studies.sweep.run import solve_sweep, sweep_definition

    names = [name.strip() for name in outputs.split(",") if name.strip()]
    model = terminal.model_or_program_name(program, model)
    what = sweep_definition(scene, vary, samples, method, seed, model, names)
    found = solve_sweep(what, out, terminal.engine_from_options(where), show_progress_message)
    written = f"wrote to {out}: samples.csv, summary.json and {reason_without_figure() or 'figures (SVG)'}"
    answer = CommandOutput(found.to_dict(), [*sweep_terminal_parts(found), written], 0 if found.converged else 1)
    return print_command_output(answer, as_json)


def sweep_terminal_parts(found: Sweep) -> list[Any]:
    """Return the texts and tables in which the terminal shows a sweep.

    These are counts, statistics of all outputs, effects and Sobol indices of the largest load, and the samples with the
    largest loads.
    """
    from rollbench.compare.studies.columns import COLUMNS, MAIN

    parts: list[Any] = [f"{found.solved} samples, {found.converged} converged"]
    parts += [f"failed: {count} samples: {reason}" for reason, count in found.failures[:5]]
    names = ("mean", "standard_error", "standard_deviation", "smallest", "quantile_0.05", "quantile_0.95", "largest")
    stats = {name: {} if x is None else x.as_json() for name, x in found.outputs.items()}
    rows = [[COLUMNS[name].heading, *(format_cell(x.get(n), ".5g") for n in names)] for name, x in stats.items()]
    parts.append(TextTable(["", *(n.replace("_", " ") for n in names)], rows, "computed quantities"))
    parts.append(_parameter_effects_table(found))
    worst = [[str(row["sample"]), f"{row[MAIN]:.5g}", row["at"], *map(str, row["values"])] for row in found.worst]
    headings = ["sample", COLUMNS[MAIN].heading, "at contact", *(v.short_name for v in found.design.keys)]
    return [*parts, TextTable(headings, worst, "samples with the largest loads")]


def _parameter_effects_table(found: Sweep) -> TextTable:
    """Return the table of the effect of each parameter on the largest load, with first-order and total Sobol indices."""
    from rollbench.compare.studies.columns import MAIN

    indices = None if isinstance(found.indices, str) else found.indices.outputs.get(MAIN)
    why = found.indices if isinstance(found.indices, str) else "no Sobol indices: the largest load does not change"
    title = "effect of each parameter on the largest contact load" + (f" ({why})" if indices is None else "")
    rows = []
    for vary in found.design.keys:
        means = [g.mean for g in found.main_effects[vary.key]]
        cells = [f"{min(means):.5g}", f"{max(means):.5g}"] if means else ["–", "–"]
        if indices is None:
            cells += ["–", "–"]
        else:
            of = indices[vary.key]
            ends = ((of.first, of.first_low, of.first_high), (of.total, of.total_low, of.total_high))
            cells += ["{:.3f} ({:.3f} to {:.3f})".format(*values) for values in ends]
        rows.append([vary.axis_label, *cells])
    headings = ("parameter", "smallest mean / N", "largest mean / N", "first-order index", "total index")
    return TextTable(headings, rows, title)


@terminal.app.command
def table(
    scene: str,
    *,
    over: Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)] = None,
    quantities: terminal.Word = "",
    model: terminal.Word = "",
    stiffness_at: terminal.Word = "",
    out: Path | None = None,
    store: Path | None = None,
    as_json: terminal.Json = False,
    where: terminal.ComputeOptions | None = None,
) -> int:
    """Print a table of 6 x 6 stiffness, preload, pressure and life over values of a scene's parameters.

    The table also has the errors to expect.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    over
        Parameter with its values: KEY=A:B:N for N equally spaced values from A to B, or KEY=v1,v2; repeat the option for
        every parameter. KEY is the key in the scene file, with units as there, such as nut.position=100:900:9 mm; the key
        load is the axial load.
    quantities
        Quantities to tabulate, NAME,NAME, out of stiffness, displacement, load (the largest contact load), preload,
        pressure, life. Default: stiffness,preload,pressure,life.
    model
        Low-order model (rollbench list shows all). Default: refined.
    stiffness_at
        Axial position on the shaft at which the stiffness is computed. With several nuts or bearings on the shaft, also the
        name of one, whose own stiffness is then computed. Default: the nut's centre.
    out
        File of the table: .csv, .json, .parquet (needs pyarrow) or .nc (needs xarray). A figure of the same name is
        written as SVG.
    store
        Folder in which every row is stored as soon as it is solved, so that an interrupted table resumes.
    """
    from rollbench.compare.files import check_writable, write_figure, written_together
    from rollbench.compare.studies.table import check_table_request, solve_table
    from rollbench.compare.studies.table_files import check_file_format, write_table_file
    from rollbench.compare.text.solved import parameter_table_parts

    texts: list[str] = []
    for text in over or ():
        if "=" in text or not texts:
            texts.append(text)
        else:
            texts[-1] += f" {text}"  # the unit of a range that was not in quotes
    names = [name.strip() for name in quantities.split(",") if name.strip()]
    asked = check_table_request(scene, texts, names, model, stiffness_at)
    if out is not None:
        check_file_format(out)
        check_writable(out)
    found = solve_table(asked, terminal.engine_from_options(where), show_progress_message, store)
    parts = parameter_table_parts(found)
    if out is not None:
        with written_together():
            write_table_file(out, found)
            drawn = found.figure()
            picture = "no figure" if drawn is None else write_figure(out.with_suffix(".svg"), drawn)
        parts.append(f"wrote {out}: {len(found.rows)} rows; {picture}")
    answer = CommandOutput(found.to_dict(), parts, 0 if found.converged else 1, wrap_always=True)
    return print_command_output(answer, as_json)
