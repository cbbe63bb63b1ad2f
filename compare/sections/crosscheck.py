"""The 3D reference checked by another program: contact loads of two small scenes by CalculiX, on whole bodies."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import Study
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.studies.crosscheck.data import CrossData, load, shipped
from rollbench.compare.studies.crosscheck.fit import Extrapolation, extrapolate, mesh_of
from rollbench.compare.studies.crosscheck.nut import load_nut
from rollbench.compare.studies.crosscheck.rows import COLUMNS, agreement, contact_rows, mesh_columns
from rollbench.compare.studies.crosscheck.study import STUDIES, scene_key
from rollbench.meshes.loads import mean_load
from rollbench.reports.content import Quantity, Row, Section, Table, Text

ABOUT = (
    "CalculiX solves two small scenes on whole bodies, without sockets, patches, condensation or beams: ten-node "
    "tetrahedra, surface-to-surface contact by a linear pressure-overclosure law, balls free, oversize in the geometry. "
    "A deck is what "
    "rollbench export SCENE --deck ccx writes; rollbench crosscheck SCENE --run solves them all again. Shared with the "
    "reference are the exact surfaces and gmsh; elements, integration, contact and solver are not."
)
EXTRAPOLATED = (
    "A single mesh of another program proves nothing. Element size h at the contacts and growth g of the "
    "elements away from them are refined together, and all contacts of all meshes are fitted at once by F0 "
    "+ A e + B / k. Here (h + g d) / (c + d) is the element size at depth d over the distance in which the "
    "contact's field changes there; with the field's energy spread evenly over x = c / (c + d), e is the "
    "mean of (x h / c + (1 - x) g)^p over x. Order p (2 to 4) and length c, in short half axes, are common "
    "to all contacts; B comes from two runs on one mesh with two contact stiffnesses k. A mesh is weighted "
    "by its e, because both the deviation from the law and the scatter between meshes of one size shrink "
    "with it. The uncertainty of a contact is the change of its limit over all orders and lengths that fit "
    "nearly as well as the best (two standard deviations), combined with two standard errors and a tenth of "
    "what is extrapolated. Where the plane through its balls divides a ring pair into mirror images, some "
    'runs mesh one half; runs marked "equal balls" use one mesh for all balls.'
)
NUT = (
    "The nut alone, by the reference's elements and by CalculiX on the same cells: forces of 1 kN on one "
    "contact after the other, the corner nodes of its faces a rigid section."
)


def run_table(data: CrossData) -> Table:
    """Every run: choices, meshes, effort, and what the weak springs and the last correction change."""
    rows: list[Row] = []
    base = {(mesh_of(r), r.stiffness): r for r in data.runs if not r.nlgeom}
    for run in data.runs:
        mean = mean_load(run.load)
        twin = base.get((mesh_of(run), run.stiffness))
        loose = float(error_percent(run.unbalanced, 0.0, mean))
        change = load_error(run.load, twin.load).max_percent if run.nlgeom and twin else None
        rows.append(
            {
                Quantity("across", "b/h at mean load", "", ".1f"): run.b_over_h,
                Quantity("fine", "h", "mm", ".3f"): 1e3 * run.fine,
                Quantity("growth", "growth", "", ".2f"): run.growth,
                Quantity("stiffness", "contact stiffness", "N/mm3", "g2"): 1e-9 * run.stiffness,
                Quantity("large", "displacements", "", "s"): "large" if run.nlgeom else "small",
                "bodies": "half" if run.half else "equal balls" if run.alike else "whole",
                "nodes": run.nodes,
                Quantity("cells", "tetrahedra", "", "s"): sum(m.cells for m in run.meshes),
                Quantity("jacobian", "smallest scaled Jacobian", "", ".2f"): min(m.smallest for m in run.meshes),
                "iterations": run.iterations,
                Quantity("seconds", "processor time", "s", ".0f"): run.seconds,
                Quantity("sum", "sum of loads", "N", ".1f"): float(run.load.sum()),
                Quantity("weak", "weak spring of a ball", "% of mean", "g2"): float(error_percent(run.weak, 0.0, mean)),
                Quantity("loose", "unbalanced force of a ball", "% of mean", "g2"): loose,
                Quantity("large_change", "change by large displacements", "% of mean", ".3f"): change,
            }
        )
    first = data.runs[0]
    note = (
        f"{first.program}, {first.date}; meshes by gmsh {data.gmsh} and rollbench {data.rollbench}. "
        "Processor time of one thread. The weak spring only keeps a ball from sliding along its track."
    )
    return Table.of(f"crosscheck-runs-{data.scene}", f"{data.scene}: runs of CalculiX", rows, note)


def contact_tables(data: CrossData, ours: Reference, limit: Extrapolation) -> list[Table]:
    """Every contact by both programs, CalculiX extrapolated; and on every mesh of either."""
    rows = contact_rows(data, ours, limit)
    heads = mesh_columns(data, ours)
    ends, each = ([{c.key: r.cells()[c.key] for c in shown} for r in rows] for shown in (COLUMNS, heads))
    fixed = f" Not varied: {', '.join(limit.fixed)}." if limit.fixed else ""
    note = (
        f"{agreement(data.scene, rows)} Order {limit.order:.2f}, length {limit.length:.2f} short half axes, RMS misfit "
        f"{limit.misfit:.2f} N; in CalculiX's finest run elements add up to {abs(limit.by_elements).max():.2f} N, the "
        f"contact law up to {abs(limit.by_stiffness).max():.2f} N.{fixed}"
    )
    meshes = "CalculiX's columns are runs whose contact stiffness is as equal as possible."
    return [
        Table(f"crosscheck-{data.scene}", f"{data.scene}: contact loads, CalculiX extrapolated", COLUMNS, ends, note),
        Table(f"crosscheck-meshes-{data.scene}", f"{data.scene}: contact loads on every mesh", heads, each, meshes),
    ]


def section(study: Study, step: Callable[[str], None], folder: Path | None = None) -> Section:
    """Section of the report; folder: of CalculiX's results (None: those of the package)."""
    items: list[Text | Table] = [Text((ABOUT, EXTRAPOLATED))]
    for name in STUDIES:
        step(f"{name}: the 3D reference and CalculiX")
        data, ours = load(folder or shipped(), name), study.reference(name)
        if data is None or data.key != scene_key(name):
            items.append(Text((f"{name}: no results of CalculiX are stored for the present scene.",)))
            continue
        if ours is None:
            items.append(Text((f"{name}: no run of the 3D reference was found.",)))
        else:
            items += contact_tables(data, ours, extrapolate(data.runs))
        items.append(run_table(data))
    alone = load_nut(folder or shipped())
    if alone is not None and alone.key == scene_key(alone.scene):
        items.append(Text((NUT, alone.sentence())))
    return Section("crosscheck", "The 3D reference checked by another program", tuple(items))
