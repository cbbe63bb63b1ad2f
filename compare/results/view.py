"""Data of one nut or bearing for the 3D view: contact points and loads, geometric errors, and errors of the loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.set_results import SetResult
from rollbench.compare.reference.estimate import Reference
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import SIDE_SIGNS, Scene
from rollbench.meshes.surface import groove_radius_with_slopes
from rollbench.reports.content import NutOrBearingView


def view_of_ball_row(
    one: SetResult, reference: Reference | None = None, expected_load_error: float | None = None
) -> NutOrBearingView:
    """Return the data of one ball nut or ball bearing for the 3D view.

    Parameters
    ----------
    one
        Results of the nut or bearing.
    reference
        3D reference of the nut or bearing; None: no reference.
    expected_load_error
        Error to expect of the contact loads [N]; None: not known.

    Returns
    -------
    NutOrBearingView
        Data of the view.
    """
    assert isinstance(one.parts, Scene)
    assert one.balls is not None
    found, load = one.balls, one.loads
    bare = NutOrBearingView(
        one.name, one.kind, one.parts, one.position, closer=gap_reduction_by_errors(one.parts, found.member)
    )
    if load is None:
        return bare
    errors = None
    if reference is not None:
        either = (load > 0.0) | (reference.load > 0.0)
        percent = np.where(either, error_percent(load, reference.load, reference.mean), np.nan)
        errors = (reference.label, reference.load, reference.uncertainty, percent)
    forces = found.force_direction * load[..., None]
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
