"""Data for the 3D view of a solved scene: contact points and loads, geometric errors, and errors of the loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.models.load_cases import SceneSolution, ShaftSolution
from rollbench.compare.quantities import count_with_noun
from rollbench.compare.reference.estimate import Reference, reference_of_scene
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import SIDE_SIGNS, Scene
from rollbench.meshes.surface import groove_radius_with_slopes
from rollbench.reports.content import LoadCaseView, NutOrBearingView, SceneView


def collect_view_data(
    title: str,
    solved: Sequence[SceneSolution | ShaftSolution],
    results: Mapping[str, Any],
    cases: Sequence[str] = (),
    stores: Sequence[Path] | None = None,
    given: Reference | None = None,
) -> SceneView:
    """Collect the data for the 3D view of a solved scene and its load cases.

    Parameters
    ----------
    title
        Title of the page.
    solved
        Solution of each load case.
    results
        Results of the scene as JSON.
    cases
        Names of the load cases; empty for a single one.
    stores
        Folders with runs of the 3D reference; None: the runs shipped with rollbench.
    given
        User's reference loads, shown instead of the stored runs; None: there are none.

    Returns
    -------
    SceneView
        Data of the view.
    """
    each = [_view_data_of_case(name, one, stores, given) for name, one in zip(cases or [""], solved, strict=True)]
    words = [count_with_noun(len(cases), "load case")] if cases else []
    sets = len(each[0].nuts_and_bearings)
    words += [count_with_noun(sets, "set")] if sets > 1 else []
    scene = results["scene"] if cases else solved[0].scene.name
    return SceneView(title, ", ".join([scene, f"model {results['model']}", *words]), each, results)


def _view_data_of_case(
    name: str, one: SceneSolution | ShaftSolution, stores: Sequence[Path] | None, given: Reference | None
) -> LoadCaseView:
    """Return the data of one solved load case for the 3D view.

    ``name``: name of the load case. ``one``: solution of the load case. ``stores``: folders with runs of the 3D reference.
    ``given``: user's reference loads, shown instead of the stored runs; None: there are none.
    """
    solved = one.derived_results is not None
    if isinstance(one, SceneSolution):
        known, error = given or reference_of_scene(one.scene, stores), None
        if one.expected_errors is not None and one.expected_errors.percent is not None:
            mean = mean_load(one.result.load, count_nominal_contacts(one.scene, one.result)) if solved else 0.0
            error = 0.01 * one.expected_errors.percent * mean
        kind, position = "ball nut" if one.scene.track.lead else "bearing", one.scene.nut.position
        found = _view_data_of_ball_row("", kind, one.scene, position, one.result, solved, known, error)
        return LoadCaseView(name, [found])
    sets = []
    for s in one.result.sets:
        if s.balls is not None and isinstance(s.of.parts, Scene):
            sets.append(_view_data_of_ball_row(s.of.name, s.of.kind, s.of.parts, s.of.position, s.balls, solved))
        else:
            sets.append(NutOrBearingView(s.of.name, s.of.kind, s.of.parts, s.of.position, s.of.thrust))
    return LoadCaseView(name, sets, one.scene)


def _view_data_of_ball_row(
    name: str,
    kind: str,
    parts: Scene,
    position: float,
    found: StaticResult,
    solved: bool,
    reference: Reference | None = None,
    expected_load_error: float | None = None,
) -> NutOrBearingView:
    """Return the data of one solved ball nut or ball bearing for the 3D view.

    ``name``, ``kind``: name of the nut or bearing, and the text "ball nut" or "bearing". ``position``: its axial position
    [m]. ``found``: solution of the nut or bearing. ``solved``: whether there is an equilibrium. ``reference``: 3D reference
    of the nut or bearing; None: no reference. ``expected_load_error``: error to expect of the contact loads [N].
    """
    bare = NutOrBearingView(name, kind, parts, position, closer=gap_reduction_by_errors(parts, found.member))
    if not solved:
        return bare
    errors = None
    if reference is not None:
        either = (found.load > 0.0) | (reference.load > 0.0)
        percent = np.where(either, error_percent(found.load, reference.load, reference.mean), np.nan)
        errors = (reference.label, reference.load, reference.uncertainty, percent)
    forces = found.force_direction * found.load[..., None]
    return replace(bare, points=found.contact_point, forces=forces, reference=errors, expected=expected_load_error)


def gap_reduction_by_errors(scene: Scene, member: int = 0) -> Array:
    """Return by how much geometric errors reduce the gap between each of n balls and its four groove flanks, (n, 4) [m].

    ``member``: number of the specimen with its random errors. The gap is measured along the nominal contact normal e.
    The returned values are (r_B - r_B0) - ((c - c_0) . e + r_G - r_G0), with ball radius r_B, groove centre c, and groove
    radius r_G at the nominal contact angle; r_B0, c_0 and r_G0 are the nominal values of ball radius, groove centre and
    groove radius. The formula is of first order in the errors.
    """
    drawn, beta = draw_geometry_with_errors(scene, ball_layout(scene), member), scene.track.contact_angle
    normal = np.array(SIDE_SIGNS) * np.array([np.cos(beta), np.sin(beta)])
    moved = np.einsum("nsk,sk->ns", drawn.groove_centres - nominal_groove_centres(scene), normal)
    flanks = zip(drawn.groove_radii, drawn.profile_coefficients, strict=True)
    radius = np.array([groove_radius_with_slopes(np.array(beta), r, profile)[0] for r, profile in flanks])
    return np.asarray((drawn.ball_radii - scene.balls.radius)[:, None] - moved - (radius - nominal_groove_radii(scene)))
