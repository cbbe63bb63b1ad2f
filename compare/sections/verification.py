"""Report sections that verify the 3D reference: against Hertz theory, and against the program CalculiX.

Against Hertz: error and unknowns of each element type, for a circular and an elliptical contact. Against
CalculiX: contact loads of two small scenes, whose bodies CalculiX meshes whole, without condensation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from rollbench.compare.measure import error_percent, load_error, mean_load
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.studies.crosscheck import results
from rollbench.compare.studies.crosscheck.study import STUDIES, digest_of_shipped_scene, load_nut_compliance
from rollbench.hifi.contact import block
from rollbench.hifi.contact.block import solve_hertz_contact as solve_block
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

#: Numbers of cells across the short semi-axis of the contact ellipse, by element type, for a total of 25 s on two cores.
#: Tetrahedra are not stretched like the ellipse, so P2 with 6 cells would take as long as all other meshes together.
LEVELS: dict[str, tuple[float, ...]] = {"P1": (2, 4, 6, 8), "P2": (2, 4, 5), "Q1": (2, 4, 6, 8), "Q2": (2, 4, 6)}

#: Numbers of cells across the short semi-axis of the contact ellipse in a quick report, by element type.
QUICK: dict[str, tuple[float, ...]] = {"P1": (2,), "P2": (2,), "Q1": (2,), "Q2": (4,)}

#: Element type, and cells across the short semi-axis (b/h), of the contact patches in the 3D reference.
PRODUCTION = ("Q2", 4.0)

#: Largest error against Hertz theory allowed on the mesh `PRODUCTION`, by quantity [%].
TARGETS = {"approach": 0.3, "semi-axes": 0.5, "pole pressure": 1.0}

NAMES = {"P1": "4-node tetrahedra", "P2": "10-node tetrahedra", "Q1": "8-node hexahedra", "Q2": "27-node hexahedra"}

SOURCE = "4-node tetrahedra, size of Lin"

#: Quantities whose errors against Hertz theory are shown in the table.
ERRORS = ("approach", "semi-axis a", "semi-axis b", "pole pressure", "fitted pole pressure")

#: Names of these quantities in column headings, where they differ.
ERROR_NAMES = {
    "pole pressure": "pressure at the centre of the contact",
    "fitted pole pressure": "pressure at the centre, by a fit to all nodal pressures",
}

WHAT = {"A": "ball on a flat", "B": "ball in a groove"}


@dataclass(frozen=True)
class HertzComputation:
    """Finite-element computation of one Hertz contact on one 3D mesh, with its errors against the closed form."""

    #: Label of the mesh: its element type, or that it has Lin's element sizes.
    mesh_label: str
    #: Computed contact: approach, semi-axes, pressures, and number of unknowns.
    computed: block.HertzContactSolution
    #: Error of each computed quantity against Hertz theory [%], by name of the quantity.
    error_percents: Mapping[str, float]


def hertz_computation_with_errors(label: str, run: block.HertzContactSolution) -> HertzComputation:
    """Return a computed Hertz contact together with its errors against the closed form [%].

    ``label``: label of the mesh. ``run``: the computed contact. The error "semi-axes" is the larger of the errors of both
    semi-axes.
    """
    exact = run.hertz_solution
    values = run.approach, run.semi_x, run.semi_y, run.pole_pressure, run.fitted_pole_pressure
    closed = exact.approach, exact.semi_x, exact.semi_y, exact.pole_pressure, exact.pole_pressure
    errors = dict(zip(ERRORS, error_percent(values, closed).tolist(), strict=True))
    return HertzComputation(label, run, errors | {"semi-axes": max(errors["semi-axis a"], errors["semi-axis b"], key=abs)})


def compute_hertz_contacts(
    step: Callable[[str], None], cell_counts: Mapping[str, Sequence[float]]
) -> list[HertzComputation]:
    """Compute two Hertz contacts in 3D on meshes of every element type, and on a mesh like that of Lin's thesis.

    The two contacts are a ball on a flat and a ball in a groove.

    Parameters
    ----------
    step
        Called with each line of progress.
    cell_counts
        Numbers of cells across the short semi-axis of the contact ellipse, by element type; one mesh for each.
    """
    out = []
    for job in block.JOBS.values():
        for element, refinements in cell_counts.items():
            step(f"job {job.name}, {NAMES[element]}")
            out += [hertz_computation_with_errors(NAMES[element], solve_block(job, element, float(n))) for n in refinements]
        out.append(hertz_computation_with_errors(SOURCE, block.solve_hertz_contact_on_lin_mesh(job)))
    return out


def computations_on_production_mesh(computations: Sequence[HertzComputation]) -> list[HertzComputation]:
    """Return the computations on the mesh `PRODUCTION`, which the 3D reference uses, one for each Hertz contact.

    ``computations``: computations on all meshes.
    """
    of_elements = [one for one in computations if one.mesh_label != SOURCE]
    return [one for one in of_elements if (one.computed.element, one.computed.b_over_h) == PRODUCTION]


def error_target_sentences(computations: Sequence[HertzComputation]) -> list[str]:
    """Return sentences on whether the mesh `PRODUCTION` meets its error targets, and on the errors of Lin's mesh.

    ``computations``: computations of each Hertz contact on all meshes.
    """
    sentences = []
    for one in computations_on_production_mesh(computations):
        run, off = one.computed, one.error_percents
        missed = [name for name, most in TARGETS.items() if not abs(off[name]) <= most]
        words = {name: "NOT within" if name in missed else "within" for name in TARGETS}
        parts = [f"{name} {off[name]:+.2f} % ({words[name]} {most} %)" for name, most in TARGETS.items()]
        sentences.append(
            f"Job {run.contact_name}, {WHAT[run.contact_name]}, mesh of the 3D reference with "
            f"{run.free_degree_of_freedom_count} unknowns: {', '.join(parts)}. "
            + (f"NOT MET: {', '.join(missed)}." if missed else "All targets are met.")
        )
    for one in computations:
        if one.mesh_label == SOURCE:
            run, off = one.computed, one.error_percents
            sentences.append(
                f"Job {run.contact_name} on first-order tetrahedra of the size of Lin's thesis ({run.b_over_h:.1f} across "
                f"the short semi-axis), errors against Hertz theory: approach {off['approach']:+.1f} %, "
                f"semi-axes {off['semi-axes']:+.1f} %, pole pressure {off['pole pressure']:+.1f} %, "
                f"fitted pole pressure {off['fitted pole pressure']:+.1f} %."
            )
    return sentences


def hertz_error_row(computation: HertzComputation) -> Row:
    """Return the row of the error table for one computed Hertz contact: mesh, unknowns and errors [%].

    ``computation``: the computed contact with its errors.
    """
    run = computation.computed
    return {
        "contact_a_or_b": run.contact_name,
        "element_type": computation.mesh_label,
        "cells_across_b": run.b_over_h,
        "unknowns": run.free_degree_of_freedom_count,
        "contact_nodes": run.contact_node_count,
        "iterations": run.newton_iteration_count,
        **{("error_of", ERROR_NAMES.get(name, name)): computation.error_percents[name] for name in ERRORS},
    }


def rows_of_computed_and_hertz_values(computations: Sequence[HertzComputation]) -> Iterator[Row]:
    """Yield table rows that compare the mesh `PRODUCTION` with Hertz: approach, semi-axes, peak pressure of each contact.

    ``computations``: computations on all meshes.
    """
    quantities = (
        ("approach", "µm", 1e6, "approach"),
        ("semi-axis a", "mm", 1e3, "semi_x"),
        ("semi-axis b", "mm", 1e3, "semi_y"),
        ("pole pressure", "MPa", 1e-6, "pole_pressure"),
    )
    for one in computations_on_production_mesh(computations):
        run = one.computed
        for name, unit, scale, key in quantities:
            most, error = TARGETS.get(name, TARGETS["semi-axes"]), one.error_percents[name]
            yield {
                "contact_problem": f"{run.contact_name}, {WHAT[run.contact_name]}",
                "quantity": name,
                "unit": unit,
                "value_by_elements": scale * getattr(run, key),
                "value_by_hertz": scale * getattr(run.hertz_solution, key),
                "error_against_hertz": error,
                "error_target": most,
                "error_within_target": "yes" if abs(error) <= most else "NO",
            }


def hertz_error_figure(computations: Sequence[HertzComputation], job: str) -> Figure:
    """Draw the errors of approach and peak pressure against Hertz theory, plotted over unknowns.

    ``computations``: computations on all meshes. ``job``: name of the Hertz contact, "A" (ball on a flat) or "B" (ball in a
    groove).
    """
    panels = []
    for quantity in ("approach", "pole pressure"):
        curves = []
        for label in (*NAMES.values(), SOURCE):
            runs = [one for one in computations if one.computed.contact_name == job and one.mesh_label == label]
            x = [float(one.computed.free_degree_of_freedom_count) for one in runs]
            y = [max(abs(one.error_percents[quantity]), 1e-3) for one in runs]
            style = "markers" if label == SOURCE else "line+markers"
            if runs:
                curves.append(Series(label, x, y, style, bold=label == NAMES[PRODUCTION[0]]))
        panels.append(Panel("", "number of unknowns", f"error of the {quantity} [%]", curves, log_axes="xy"))
    return Figure(
        f"verification-{job}",
        f"Error of the 3D contact against Hertz theory, plotted over unknowns: {WHAT[job]} (job {job})",
        panels,
        caption=(
            "Absolute values of the errors; at a minimum the error changes its sign. Errors below 0.001 % are drawn at "
            "that value. Pressures at single nodes of 4-node tetrahedra scatter with the mesh."
        ),
    )


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section that verifies the contact elements of the 3D reference against Hertz theory.

    ``step`` is called with each line of progress.
    """
    return hertz_section(compute_hertz_contacts(step, QUICK if cache.quick else LEVELS))


def hertz_section(computations: Sequence[HertzComputation]) -> Section:
    """Return the section that compares contacts computed by 3D finite elements with Hertz theory.

    ``computations``: computations of each Hertz contact on all meshes.
    """
    job, mesh = block.JOBS["A"], f"{NAMES[PRODUCTION[0]]}, b/h = {PRODUCTION[1]:g}"
    text = (
        f"A ball of radius {1000.0 * block.BALL:g} mm (E = {1e-09 * job.young:g} GPa, nu = {job.poisson:g}, both bodies "
        f"elastic) is pressed with {job.load:g} N on a flat (job A) and into a groove of radius {1000.0 * block.GROOVE:g} "
        f"mm that is convex along its length with radius {1000.0 * block.ALONG:g} mm (job B). One elastic body is "
        "modelled, a quarter by symmetry, and its compliance is doubled. The cut faces of the block are displaced as in "
        "the half-space (Boussinesq); fixed faces would change the approach.",
        "h is the cell edge along the short semi-axis b. Semi-axes are those of the ellipsoid of pressure with the same "
        "load and second moments as the nodal forces. The pole pressure is the nodal force over its area at the pole, not "
        "the largest nodal value; the fitted pole pressure is that of the ellipsoid. On 10-node tetrahedra only mid-side "
        "nodes may come into contact, because a uniform pressure causes no force on corner nodes. The mesh of Lin's thesis "
        f"has cells of {1000.0 * block.SOURCE_FINE:g} mm within a sphere of {1000.0 * block.SOURCE_RADIUS:g} mm (the size "
        f"of the sphere is not printed) and of up to {1000.0 * block.SOURCE_COARSE:g} mm outside.",
    )
    of_mesh = f"Error against Hertz theory of the mesh that the 3D reference uses ({mesh})"
    of_all = "Ball contact by 3D finite elements: error against Hertz theory, unknowns of each element and mesh"
    items: tuple[Text | Table | Figure, ...] = (
        Text(text),
        Text(error_target_sentences(computations), bullets=True),
        Table.from_rows("verification-targets", of_mesh, rows_of_computed_and_hertz_values(computations)),
        Table.from_rows("verification-errors", of_all, map(hertz_error_row, computations)),
        *(hertz_error_figure(computations, job) for job in block.JOBS),
    )
    return Section("verification", "Error of the 3D contact elements against Hertz theory", items)


ABOUT = (
    "CalculiX solves two small scenes with whole bodies, without fine patches, condensation or beams: ten-node "
    "tetrahedra, surface-to-surface contact with a linear pressure-overclosure law, free balls, oversize in the geometry. "
    "rollbench export SCENE --deck ccx writes an input deck; rollbench crosscheck SCENE --run solves all decks again. The "
    "two computations share the exact surfaces and gmsh, but not elements, integration, contact and solver."
)

EXTRAPOLATED = (
    "The loads by CalculiX are extrapolated to zero element size. Elements have the size h at a contact and h + g d at the "
    "depth d below it; h and the growth g are refined together. The loads F of all contacts on all meshes are fitted "
    "together by F = F0 + A e + B / k, with the extrapolated load F0, the mesh error e, the contact stiffness k and the "
    "coefficients A and B. Stress and strain below a contact change over the distance c + d, with a length c, so the "
    "relative element size there is (h + g d) / (c + d). With the strain energy distributed evenly over x = c / (c + d), e "
    "is the mean of (x h / c + (1 - x) g)^p over x. The order p (2 to 4) and the length c, in minor semi-axes, are common "
    "to all contacts; B follows from two runs on one mesh with two contact stiffnesses k. Meshes are weighted by their e, "
    "because both the misfit of this law and the scatter between meshes of equal size decrease with it. The uncertainty of "
    "a contact load is the change of its limit F0 over all orders and lengths that fit nearly as well as the best (two "
    "standard deviations), combined with two standard errors and a tenth of the extrapolated change. Where the plane "
    "through the balls divides a pair of rings into mirror images, some runs mesh one half; runs marked "
    '"equal balls" use one mesh for all balls.'
)

NUT = (
    "Deformation of the nut alone, by the elements of the 3D reference and by CalculiX on the same cells: a force of 1 kN "
    "acts on one contact after the other; the corner nodes of the nut faces form a rigid section."
)


def calculix_run_table(calculix_runs: results.CalculixRunsOfScene) -> Table:
    """Return the table of the CalculiX runs on one scene: mesh, contact stiffness and residual forces.

    ``calculix_runs``: stored results of CalculiX on this scene.
    """
    rows: list[Row] = []
    base = {(results.mesh_options_of_run(r), r.stiffness): r for r in calculix_runs.runs if not r.nlgeom}
    for run in calculix_runs.runs:
        mean, twin = mean_load(run.load), base.get((results.mesh_options_of_run(run), run.stiffness))
        rows.append(
            {
                "elements_across_b": run.b_over_h,
                "element_size": 1e3 * run.fine,
                "element_growth": run.growth,
                "contact_stiffness": 1e-9 * run.stiffness,
                "large_displacements": "large" if run.nlgeom else "small",
                "half_or_whole": "half" if run.half else "equal balls" if run.alike else "whole",
                "nodes": run.nodes,
                "tetrahedra": sum(m.cells for m in run.meshes),
                "scaled_jacobian": min(m.smallest for m in run.meshes),
                "iterations": run.iterations,
                "load_sum": float(run.load.sum()),
                "weak_spring_force": float(error_percent(run.weak, 0.0, mean)),
                "unbalanced_force": float(error_percent(run.unbalanced, 0.0, mean)),
                "change_by_large_displacements": (
                    load_error(run.load, twin.load).max_percent if run.nlgeom and twin else None
                ),
            }
        )
    first = calculix_runs.runs[0]
    note = (
        f"{first.program}, {first.date}; meshes by gmsh {calculix_runs.gmsh} and rollbench {calculix_runs.rollbench}. "
        "A weak spring prevents each ball from sliding along its track."
    )
    title = f"Meshes and residual forces of the CalculiX runs on {calculix_runs.scene}"
    return Table.from_rows(f"crosscheck-runs-{calculix_runs.scene}", title, rows, note)


def calculix_contact_tables(
    calculix_runs: results.CalculixRunsOfScene, reference: Reference, extrapolation: results.LoadExtrapolation
) -> list[Table]:
    """Return two tables of a scene's contact loads by the 3D reference and by CalculiX.

    The loads by CalculiX are extrapolated to zero element size in the first table, and those of every mesh in the second.

    Parameters
    ----------
    calculix_runs
        Stored results of CalculiX on one scene.
    reference
        3D reference of the scene.
    extrapolation
        Loads by CalculiX extrapolated to zero element size.
    """
    rows = results.compare_contact_loads(calculix_runs, reference, extrapolation)
    by_mesh = results.columns_of_contact_load_table(calculix_runs, reference)
    ends, each = ({column: [r[key] for r in rows] for column, key in shown.items()} for shown in (results.COLUMNS, by_mesh))
    fixed = f" Not varied: {', '.join(extrapolation.unvaried_options)}." if extrapolation.unvaried_options else ""
    note = (
        f"{results.agreement_sentence(calculix_runs.scene, rows)} Order {extrapolation.error_order:.2f}, length "
        f"{extrapolation.field_length:.2f} minor semi-axes, RMS "
        f"misfit {extrapolation.misfit:.2f} N. In the finest run of CalculiX, the element size changes a load by up to "
        f"{abs(extrapolation.element_size_effect).max():.2f} N and the finite contact stiffness by up to "
        f"{abs(extrapolation.contact_stiffness_effect).max():.2f} N.{fixed}"
    )
    meshes = (
        "For CalculiX, runs with contact stiffnesses as equal as possible are shown. b/h: elements across the minor "
        "semi-axis b of the contact ellipse; g: growth of the element size with the distance from the contact; half: one "
        "half of each body is meshed; equal balls: one mesh for all balls."
    )
    first = f"Contact loads of {calculix_runs.scene} by the 3D reference and by CalculiX, extrapolated to cell size zero"
    second = f"Contact loads of {calculix_runs.scene} by the 3D reference and by CalculiX: b/h elements across b, growth g"
    return [
        Table(f"crosscheck-{calculix_runs.scene}", first, ends, note),
        Table(f"crosscheck-meshes-{calculix_runs.scene}", second, each, meshes),
    ]


def crosscheck_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section that compares contact loads of two scenes by the 3D reference and by the program CalculiX.

    ``step`` is called with each line of progress.
    """
    stored = results.shipped_calculix_results_folder()
    items: list[Text | Table] = [Text((ABOUT, EXTRAPOLATED))]
    for name in STUDIES:
        step(f"{name}: the 3D reference and CalculiX")
        data, ours = results.load_calculix_results(stored, name), cache.stored_reference(name)
        if data is None or data.key != digest_of_shipped_scene(name):
            items.append(Text((f"{name}: no results of CalculiX are stored for the present version of this scene.",)))
            continue
        if ours is None:
            items.append(Text((f"{name}: no run of the 3D reference is stored.",)))
        else:
            items += calculix_contact_tables(data, ours, results.extrapolate_calculix_loads(data.runs))
        items.append(calculix_run_table(data))
    alone = load_nut_compliance(stored)
    if alone is not None and alone.key == digest_of_shipped_scene(alone.scene):
        items.append(Text((NUT, alone.sentence_on_agreement())))
    return Section("crosscheck", "Contact loads of the 3D reference compared with CalculiX", tuple(items))
