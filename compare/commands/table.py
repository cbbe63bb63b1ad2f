"""The command rollbench table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Json, Where, Word, app, engine
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
    where: Where | None = None,
) -> int:
    """Tabulate 6 x 6 stiffness, preload, pressure and life of a scene over values of its keys, with expected errors.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    over
        KEY=A:B:N for N equal steps, or KEY=v1,v2; repeat for every key, units as in the scene: nut.position=100:900:9 mm.
        The key load is the axial load.
    quantities
        NAME,NAME of stiffness, displacement, load, preload, pressure, life. Default: stiffness,preload,pressure,life.
    model
        Low-order model (see: rollbench list). Default: refined.
    stiffness_at
        Position on the shaft at which the stiffness is taken. Default: the nut's centre. With several sets also the name
        of one, for its stiffness only.
    out
        File of the table: .csv, .json, .parquet (needs pyarrow) or .nc (needs xarray); a figure of the same name is
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
            texts[-1] += f" {text}"  # the unit of a range that nobody quoted
    names = [name.strip() for name in quantities.split(",") if name.strip()]
    asked = check_request(scene, texts, names, model, stiffness_at)
    if out is not None:
        check_format(out)
        need_writable(out)
    found = solve_table(asked, engine(where), on_terminal)
    parts = table_parts(found)
    if out is not None:
        write_table(out, found)
        drawn = table_figure(found)
        picture = "no figure" if drawn is None else write_figure(out.with_suffix(".svg"), drawn)
        parts.append(f"wrote {out}: {len(found.rows)} rows; {picture}")
    return print_answer(Answer(found.to_dict(), parts, 0 if found.converged else 1, folded=True), as_json)
