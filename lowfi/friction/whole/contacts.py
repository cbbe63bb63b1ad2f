"""Contacts of a static result for the computation of friction: forces, directions, contact ellipses, pressures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from rollbench.lowfi.friction.screw.groove import SIGN_X, SIGN_Z, printed_hertz_constants
from rollbench.lowfi.statics import contacts as statics_contacts
from rollbench.lowfi.statics.nominal import ContactLoads
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout, nominal_groove_radii
from rollbench.meshes.parts import Scene

#: Fraction of a ball's largest contact load from which the ellipses of its unloaded contacts are computed, so that their
#: size is not zero.
FAINT = 1e-9


@dataclass(frozen=True)
class StaticContacts:
    """Forces, angles and ellipses of the contacts of N balls with the flanks SL, SR, NL, NR, from a static model.

    S and N stand for screw and nut, L and R for the left and the right flank.
    """

    #: Radius of each ball, errors included ``(N,)`` [m].
    ball_radius: Array
    #: Contact forces ``(N, 4)`` [N]; zero for an open contact.
    force: Array
    #: Contact angles ``(N, 4)`` [rad]; the nominal angle for an open contact.
    angle: Array
    #: Long semi-axes of the contact ellipses ``(N, 4)`` [m].
    a: Array
    #: Short semi-axes of the contact ellipses ``(N, 4)`` [m].
    b: Array
    #: Whether the long semi-axis of each contact ellipse lies across the groove ``(N, 4)``.
    across: Mask
    #: Azimuths, centres and section axes of the balls.
    layout: BallLayout

    @cached_property
    def normals(self) -> Array:
        """Unit vectors from each ball's centre to its contacts ``(N, 4, 3)``.

        Components are those along the axes x3 (radial), y3 (along the track), z3 (binormal) of the ball's section.
        """
        return np.stack([SIGN_X * np.cos(self.angle), np.zeros_like(self.angle), SIGN_Z * np.sin(self.angle)], axis=-1)

    @cached_property
    def section_axes(self) -> Array:
        """Axes x3 (radial), y3 (tangent), z3 (binormal) of each ball's section, as rows in fixed axes ``(N, 3, 3)``."""
        return np.stack([self.layout.radial, self.layout.tangent, self.layout.binormal], axis=1)

    @property
    def pressure(self) -> Array:
        """Largest Hertz pressures of the contacts ``(N, 4)`` [Pa]."""
        return np.asarray(1.5 * self.force / (np.pi * self.a * self.b))

    def subset(self, balls: Index | slice) -> StaticContacts:
        """Return the contacts of chosen balls only.

        ``balls``: indices of these balls, or a range of indices.
        """
        layout = BallLayout(*(getattr(self.layout, f.name)[balls] for f in fields(self.layout)))
        arrays = {f.name: getattr(self, f.name)[balls] for f in fields(self) if f.name != "layout"}
        return replace(self, layout=layout, **arrays)

    @classmethod
    def joined(cls, groups: Sequence[StaticContacts]) -> StaticContacts:
        """Return the contacts of all balls of several groups, one group after the other."""
        layout = BallLayout(*(np.concatenate([getattr(g.layout, f.name) for g in groups]) for f in fields(BallLayout)))
        arrays = {f.name: np.concatenate([getattr(g, f.name) for g in groups]) for f in fields(cls) if f.name != "layout"}
        return cls(layout=layout, **arrays)

    @property
    def axial_force(self) -> float:
        """Axial force that the normal contact loads of all balls exert on the screw, positive along +z [N]."""
        push = self.force[:, :2, None] * self.normals[:, :2]
        return float(np.einsum("nsi,ni->", push, self.section_axes[:, :, 2]))


def contacts_of_result(scene: Scene, result: StaticResult, member: int = 0) -> StaticContacts:
    """Return forces, angles and Hertz ellipses of all contacts of a static result.

    ``scene``: the scene, whose ingredient ``hertz`` chooses the Hertz constants; ``result``: its static result;
    ``member``: number of the specimen (one draw of the random geometric errors) for which ``result`` was solved. Raises
    ValueError if the result did not converge.
    """
    if not result.converged:
        raise ValueError(f"friction cannot be computed, because the contact loads did not converge: {result.status}")
    layout = ball_layout(scene)
    return contacts_of_solution(scene, result, draw_geometry_with_errors(scene, layout, member), layout)


def contacts_of_solution(
    scene: Scene, result: StaticResult | ContactLoads, drawn: GeometryWithErrors, layout: BallLayout
) -> StaticContacts:
    """Return forces, angles and ellipses of the contacts of a static solution at given positions of the balls.

    Parameters
    ----------
    scene
        Scene that was solved.
    result
        Contact loads and angles.
    drawn
        Radii and groove centres of the parts, with the random errors of the specimen that was solved.
    layout
        Positions of the balls.
    """
    force = np.maximum(result.load, 0.0)
    angle = np.where(force > 0.0, np.nan_to_num(result.contact_angle), scene.track.contact_angle)
    c_a, c_b, across = _ellipse_constants(scene, drawn, angle)
    cube = _force_cube_root(force)
    return StaticContacts(drawn.ball_radii, force, angle, c_a * cube, c_b * cube, across, layout)


def _force_cube_root(force: Array) -> Array:
    """Return the cube roots of contact forces, to which the semi-axes of contact ellipses are proportional [N^(1/3)].

    ``force``: contact forces ``(N, 4)`` [N]. For unloaded contacts the result is tiny but not zero, so that one can
    divide by semi-axes.
    """
    most = force.max(axis=1, keepdims=True)
    return np.asarray(np.cbrt(np.maximum(force, np.maximum(FAINT * most, 1e-30))))


def contacts_with_loads(contacts: StaticContacts, force: Array, angle: Array) -> StaticContacts:
    """Return contacts with new forces and contact angles, and with the ellipses that belong to the new forces.

    ``contacts``: contacts whose Hertz constants are used; ``force``: new contact forces ``(N, 4)`` [N]; ``angle``: new
    contact angles ``(N, 4)`` [rad].
    """
    grown = _force_cube_root(force) / _force_cube_root(contacts.force)
    return replace(contacts, force=force, angle=angle, a=contacts.a * grown, b=contacts.b * grown)


def contacts_of_all_balls(
    contacts: StaticContacts | None, layout: BallLayout, balls: Index, ball_radius: Array, unloaded_angle: float
) -> StaticContacts:
    """Return the contacts of all N balls of a scene from those of balls that may carry load; all other balls have no load.

    Parameters
    ----------
    contacts
        Contacts of the balls that may be loaded; None if no ball is loaded.
    layout
        Positions of all balls.
    balls
        Indices of the balls to which ``contacts`` belongs.
    ball_radius
        Radii of all balls ``(N,)`` [m].
    unloaded_angle
        Contact angle of unloaded balls [rad].
    """
    n = ball_radius.size
    least = 1e-30 ** (1.0 / 3.0)
    force, angle, across = np.zeros((n, 4)), np.full((n, 4), unloaded_angle), np.ones((n, 4), dtype=bool)
    full = StaticContacts(ball_radius, force, angle, np.full((n, 4), least), np.full((n, 4), least), across, layout)
    if contacts is not None:
        for name in ("force", "angle", "a", "b", "across"):
            getattr(full, name)[balls] = getattr(contacts, name)
    return full


def _ellipse_constants(scene: Scene, drawn: GeometryWithErrors, angle: Array) -> tuple[Array, Array, Mask]:
    """Return the Hertz constants of long and short semi-axes, then whether the long semi-axis lies across the groove.

    Each array is ``(N, 4)``; the semi-axes [m] are the constants times the cube root of the force [N]. The scene's
    ingredient ``hertz`` chooses the radii of curvature: without errors, with the errors of ``drawn``, or as printed in
    Lin's thesis. ``angle``: contact angles ``(N, 4)`` [rad].
    """
    kind, shape = scene.ingredients.hertz, angle.shape
    if kind == "as printed":
        h = printed_hertz_constants(scene)
        return np.broadcast_to(h.C_a, shape), np.broadcast_to(h.C_b, shape), np.ones(shape, dtype=bool)
    if kind == "actual":
        h = statics_contacts.hertz_at_contact_angles(scene, drawn, angle)
        curvature = statics_contacts.relative_curvatures(scene, drawn, angle)
    else:
        h = statics_contacts.hertz_without_errors(scene)
        if kind != "error-free":
            h = statics_contacts.hertz_with_errors_if_distinct(scene, drawn, drawn.ball_radii)
        curvature = statics_contacts.nominal_curvatures(scene)
    # curvatures are in ascending order; the one that equals the groove profile's belongs to the semi-axis across
    profile = 1.0 / drawn.ball_radii[:, None] - 1.0 / nominal_groove_radii(scene)
    across = np.abs(curvature[..., 0] - profile) <= np.abs(curvature[..., 1] - profile)
    return np.broadcast_to(h.C_a, shape), np.broadcast_to(h.C_b, shape), np.broadcast_to(across, shape)
