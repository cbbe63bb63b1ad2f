"""Contacts in which friction acts from a static load distribution: forces, directions, ellipses, pressures."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.groove import SIGN_X, SIGN_Z
from rollbench.lowfi.hertz import contact_modulus, printed_hertz
from rollbench.lowfi.statics.contacts import (
    actual_hertz,
    distinct_hertz,
    error_free_hertz,
    nominal_curvatures,
    relative_curvatures,
)
from rollbench.lowfi.statics.nominal import ContactLoads
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.helix import BallLayout, ball_layout, groove_radii
from rollbench.meshes.parts import Errors, Scene
from rollbench.meshes.surface import printed_radii

#: Part of a ball's largest contact load below which a contact keeps the ellipse of that part.
FAINT = 1e-9


@dataclass(frozen=True)
class StaticContacts:
    """Contacts of N balls (order SL, SR, NL, NR) by a static model."""

    #: Radius of the balls with errors ``(N,)`` [m].
    ball_radius: Array
    #: ``(N, 4)`` [N], zero without contact.
    force: Array
    #: ``(N, 4)`` [rad], the nominal one without contact.
    angle: Array
    #: Long semi-axes ``(N, 4)`` [m].
    a: Array
    #: Short semi-axes ``(N, 4)`` [m].
    b: Array
    #: Whether the long one lies across the groove ``(N, 4)``.
    across: NDArray[np.bool_]
    #: Azimuths, centres and section frames of the balls.
    layout: BallLayout

    @cached_property
    def normals(self) -> Array:
        """Directions from the ball's centre to its contacts in x3, y3, z3 ``(N, 4, 3)``."""
        return np.stack([SIGN_X * np.cos(self.angle), np.zeros_like(self.angle), SIGN_Z * np.sin(self.angle)], axis=-1)

    @cached_property
    def frames(self) -> Array:
        """Axes x3, y3, z3 of each ball's section in fixed axes, as rows ``(N, 3, 3)``."""
        return np.stack([self.layout.radial, self.layout.tangent, self.layout.binormal], axis=1)

    @property
    def pressure(self) -> Array:
        """Largest pressures ``(N, 4)`` [Pa]."""
        return np.asarray(1.5 * self.force / (np.pi * self.a * self.b))

    def subset(self, balls: NDArray[np.int64] | slice) -> StaticContacts:
        """Return the contacts of some of the balls."""
        layout = BallLayout(*(getattr(self.layout, f.name)[balls] for f in fields(self.layout)))
        return StaticContacts(
            self.ball_radius[balls],
            self.force[balls],
            self.angle[balls],
            self.a[balls],
            self.b[balls],
            self.across[balls],
            layout,
        )

    @property
    def axial_force(self) -> float:
        """Force along +z with which the normal contact loads push the screw [N]."""
        push = self.force[:, :2, None] * self.normals[:, :2]
        return float(np.einsum("nsi,ni->", push, self.frames[:, :, 2]))


def contacts_of_result(scene: Scene, result: StaticResult, member: int = 0) -> StaticContacts:
    """Return the contacts of a solved scene with the Hertz constants that its ingredients name.

    member: the specimen that ``result`` was solved for. Raises ValueError for a result that did not converge.
    """
    if not result.converged:
        raise ValueError(f"no loads to take friction from: {result.status}")
    layout = ball_layout(scene)
    return contacts_at(scene, result, specimen(scene, layout, member), layout)


def contacts_at(scene: Scene, result: StaticResult | ContactLoads, drawn: Specimen, layout: BallLayout) -> StaticContacts:
    """Return the contacts of a solution for the balls of ``drawn`` at the positions of ``layout``."""
    force = np.maximum(result.load, 0.0)
    angle = np.where(force > 0.0, np.nan_to_num(result.contact_angle), scene.track.contact_angle)
    c_a, c_b, across = _ellipse_constants(scene, drawn, angle)
    cube = _force_cube_root(force)
    return StaticContacts(drawn.ball_radius, force, angle, c_a * cube, c_b * cube, across, layout)


def _force_cube_root(force: Array) -> Array:
    """Return cube roots of forces ``(N, 4)``, for the ellipses: a contact without load keeps a vanishing one."""
    most = force.max(axis=1, keepdims=True)
    return np.asarray(np.cbrt(np.maximum(force, np.maximum(FAINT * most, 1e-30))))


def replace_loads(at: StaticContacts, force: Array, angle: Array) -> StaticContacts:
    """Return the contacts with other forces ``(N, 4)`` [N] and contact angles ``(N, 4)`` [rad]; Hertz constants stay."""
    grown = _force_cube_root(force) / _force_cube_root(at.force)
    return replace(at, force=force, angle=angle, a=at.a * grown, b=at.b * grown)


def spread_to_all_balls(
    at: StaticContacts | None, layout: BallLayout, balls: NDArray[np.int64], ball_radius: Array, angle: float
) -> StaticContacts:
    """Return the contacts of all N balls of ``layout``, some of which are in ``at``; no load on the others.

    Parameters
    ----------
    at
        Contacts of some balls.
    layout
        Positions of all balls.
    balls
        Indices of those in ``at``.
    ball_radius
        Of all balls ``(N,)`` [m].
    angle
        Contact angle of balls without load [rad].
    """
    n = ball_radius.size
    least = 1e-30 ** (1.0 / 3.0)
    full = StaticContacts(
        ball_radius,
        np.zeros((n, 4)),
        np.full((n, 4), angle),
        np.full((n, 4), least),
        np.full((n, 4), least),
        np.ones((n, 4), dtype=bool),
        layout,
    )
    if at is not None:
        for name in ("force", "angle", "a", "b", "across"):
            getattr(full, name)[balls] = getattr(at, name)
    return full


def _ellipse_constants(scene: Scene, drawn: Specimen, angle: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the constants of the semi-axes ``(N, 4)`` and whether the long one lies across the groove, by ``hertz``."""
    kind, shape = scene.ingredients.hertz, angle.shape
    if kind == "as printed":
        c_a, c_b = _printed_ellipse_constants(scene)
        return np.broadcast_to(c_a, shape), np.broadcast_to(c_b, shape), np.ones(shape, dtype=bool)
    if kind == "actual":
        h, curvature = actual_hertz(scene, drawn, angle), relative_curvatures(scene, drawn, angle)
    else:
        h = error_free_hertz(scene) if kind == "error-free" else distinct_hertz(scene, drawn, drawn.ball_radius)
        curvature = nominal_curvatures(scene)
    # curvatures come in ascending order: that of the groove's profile tells which one lies across
    profile = 1.0 / drawn.ball_radius[:, None] - 1.0 / groove_radii(scene)
    across = np.abs(curvature[..., 0] - profile) <= np.abs(curvature[..., 1] - profile)
    return np.broadcast_to(h.C_a, shape), np.broadcast_to(h.C_b, shape), np.broadcast_to(across, shape)


def _printed_ellipse_constants(scene: Scene) -> tuple[Array, Array]:
    """Return the constants of the semi-axes ``(4,)`` with the errors of Lin's Table B.1."""
    bare = replace(scene, errors=Errors())
    drawn = specimen(bare, ball_layout(bare))
    gamma, ball = np.full(scene.ball_count, scene.track.contact_angle), scene.balls.material
    rows = []
    for body, side in ((scene.screw, 0), (scene.nut, 3)):
        steel = body.material
        modulus = contact_modulus(ball.youngs_modulus, ball.poissons_ratio, steel.youngs_modulus, steel.poissons_ratio)
        low, high = printed_radii(bare, drawn, side, gamma)[0]
        constants = printed_hertz(scene.balls.radius, (float(low), float(high)), modulus)
        rows += 2 * [(constants.C_a, constants.C_b)]
    table = np.array(rows)
    return table[:, 0], table[:, 1]
