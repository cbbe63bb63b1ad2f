"""Command ``rollbench table``: prints stiffness, preload, pressure and life for values of a scene's parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import ComputeOptions, Json, Word, app, engine_of
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, print_answer


@app.command
def table(
    scene: str,
    *,
    over: Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)] = None,
    quantities: Word = "",
    model: Word = "",
    stiffness_at: Word = "",
    out: Path | None = None,
    as_json: Json = False,
    where: ComputeOptions | None = None,
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
        Quantities to tabulate, NAME,NAME, out of stiffness, displacement, load, preload, pressure, life. Default:
        stiffness,preload,pressure,life.
    model
        Low-order model (rollbench list shows all). Default: refined.
    stiffness_at
        Axial position on the shaft at which the stiffness is computed. With several nuts or bearings on the shaft, also the
        name of one, whose own stiffness is then computed. Default: the nut's centre.
    out
        File of the table: .csv, .json, .parquet (needs pyarrow) or .nc (needs xarray). A figure of the same name is
        written as SVG.
    """
    from rollbench.compare.files import need_writable, write_figure
    from rollbench.compare.studies.table import check_request, solve_table
    from rollbench.compare.studies.table_files import check_format, table_figure, write_table
    from rollbench.compare.text.table import table_parts

    texts: list[str] = []
    for text in over or ():
        if "=" in text or not texts:
            texts.append(text)
        else:
            texts[-1] += f" {text}"  # the unit of a range that was not in quotes
    names = [name.strip() for name in quantities.split(",") if name.strip()]
    asked = check_request(scene, texts, names, model, stiffness_at)
    if out is not None:
        check_format(out)
        need_writable(out)
    found = solve_table(asked, engine_of(where), on_terminal)
    parts = table_parts(found)
    if out is not None:
        write_table(out, found)
        drawn = table_figure(found)
        picture = "no figure" if drawn is None else write_figure(out.with_suffix(".svg"), drawn)
        parts.append(f"wrote {out}: {len(found.rows)} rows; {picture}")
    return print_answer(Answer(found.to_dict(), parts, 0 if found.converged else 1, folded=True), as_json)
