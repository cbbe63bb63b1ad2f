"""Linear ball bearing of two V-grooves: geometry, contact directions, Hertz contacts, and normal loads of one ball.

Contacts are ordered BL, BR, TR, TL (bottom left, bottom right, top right, top left; Lin Figure 3.10). The bottom is at
rest, the top (the carriage) moves along z. Angles are measured from -y (bottom) and +y (top) towards the sides. Contact
loads are those under the forces N_y (pressing) and N_x = rho N_y on the carriage, computed in three ways. These loads do
not depend on friction, which acts along the track (section 3.3.2 of Lin's thesis).

The closed formulas of section 3.3.3 of Lin's thesis, rederived, give ball velocity, ball-to-ball force and loss in
four-point contact. These formulas are valid where all four contacts carry load and their centres of rotation stay within
about half a semi-axis of the contact centres. The printed eqs. (3.42), (3.43), (3.51) of Lin's thesis have 1 - cos 2 beta_0
where the derivation gives tan beta_0; both are 1 at the 45 degrees of the case study.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import solve_contact_loads
from rollbench.lowfi.friction.contact.normal_force import BallContactArrays
from rollbench.lowfi.hertz import HertzConstants, contact_modulus, hertz_constants
from rollbench.meshes.arrays import Array

#: How contact loads are computed: by `loads_equal_on_diagonals`, `loads_in_equilibrium` or `loads_of_elastic_contacts`.
Loads = Literal["diagonal", "balanced", "elastic"]

#: Indices that put the contacts of a ball on the carriage (the top) first; applied twice they restore the original order.
TOP_FIRST = [2, 3, 0, 1]

#: Names of the four contacts of a ball in the order of all arrays of contacts: B and T stand for bottom and top, L and R
#: for left and right.
CONTACTS = ("BL", "BR", "TR", "TL")

#: Signs of the components along x, then y, of the directions from the ball's centre to its contacts, in the order of
#: ``CONTACTS``.
SENSE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

#: For the contacts of a ball in the order of ``CONTACTS``: 1 for a contact on the moving carriage, 0 for one on the rail.
MOVING = np.array([0.0, 0.0, 1.0, 1.0])


@dataclass(frozen=True)
class LinearBearing:
    """Linear ball bearing with V-grooves: geometry, speed, friction and material (parameters of Lin's Table 3.3)."""

    #: Ball radius R_B [m].
    ball_radius: float
    #: Conformity of the grooves: groove radius divided by ball diameter.
    conformity: float
    #: Nominal contact angle beta_0 [rad].
    contact_angle: float
    #: Speed of the carriage along z, of either sign [m/s].
    speed: float
    #: Coefficient of friction of the grooves.
    mu: float
    #: Coefficient of friction between two balls.
    mu_balls: float
    #: Young's modulus [Pa].
    young: float
    #: Poisson's ratio.
    poisson: float

    def __post_init__(self) -> None:
        """Raise ValueError for dimensions, angles, material constants or coefficients of friction out of range."""
        if not self.ball_radius > 0.0 or not self.young > 0.0 or not -1.0 < self.poisson <= 0.5:
            raise ValueError(
                "ball radius and Young's modulus must be positive, Poisson's ratio in (-1, 0.5], "
                f"got ball_radius {self.ball_radius} m, young {self.young} Pa, poisson {self.poisson}"
            )
        if not self.conformity > 0.5:
            raise ValueError(f"conformity (groove radius over ball diameter) must exceed 0.5, got {self.conformity}")
        if not 0.0 < self.contact_angle < 0.5 * np.pi:
            raise ValueError(f"contact angle must lie between 0 and pi/2, got {self.contact_angle} rad")
        if not (self.mu >= 0.0 and self.mu_balls >= 0.0 and np.isfinite(self.mu + self.mu_balls + self.speed)):
            raise ValueError(
                "the coefficients of friction mu and mu_balls must not be negative, and they and the speed must be finite, "
                f"got mu {self.mu}, mu_balls {self.mu_balls}, speed {self.speed} m/s"
            )

    def contact_hertz_constants(self) -> HertzConstants:
        """Return the Hertz constants of a ball in a straight groove; semi-axis a lies across the groove, b along it."""
        return _hertz_constants(self.ball_radius, self.conformity, self.young, self.poisson)

    def semi_axis_constant(self) -> float:
        """Return the constant Psi [(m2/N)^(1/3)] of the semi-axis a = Psi (R_B F)^(1/3) at a contact load F (Lin 3.36)."""
        return float(self.contact_hertz_constants().C_a / np.cbrt(self.ball_radius))


@lru_cache(maxsize=64)
def _hertz_constants(ball_radius: float, conformity: float, young: float, poisson: float) -> HertzConstants:
    """Return the Hertz constants of a ball in a straight groove of the same material; results are cached.

    ``ball_radius`` [m]; ``conformity``: groove radius over ball diameter; ``young``: Young's modulus [Pa]; ``poisson``:
    Poisson's ratio.
    """
    across = 1.0 - 0.5 / conformity
    modulus = contact_modulus(young, poisson, young, poisson)
    return hertz_constants(np.array(1.0 / ball_radius), np.array(across / ball_radius), modulus)


def contact_directions(angles: Array) -> Array:
    """Return unit vectors along x, y from the ball's centre to its four contacts ``(..., 4, 2)``.

    Parameters
    ----------
    angles
        Contact angles ``(..., 4)`` [rad].
    """
    return np.asarray(SENSE * np.stack([np.sin(angles), np.cos(angles)], axis=-1))


def contact_semi_axes(bearing: LinearBearing, loads: Array) -> tuple[Array, Array]:
    """Return semi-axes a, then b <= a, of contact ellipses under given loads [m], each array in the shape of the loads.

    Parameters
    ----------
    bearing
        Bearing with the Hertz constants of its contacts.
    loads
        Normal forces [N], any shape.
    """
    constants, root = bearing.contact_hertz_constants(), np.cbrt(loads)
    return np.asarray(constants.C_a * root), np.asarray(constants.C_b * root)


def contact_angle_deviations(theta: Array, *, mated: bool = False) -> Array:
    """Return by how much a ball's four contact angles differ from the nominal contact angle ``(..., 4)`` [rad].

    The order is bottom left, bottom right, top right, top left. The differences are those in the case study of Lin's
    thesis: -theta and theta on the bottom groove.

    Parameters
    ----------
    theta
        Contact angle at the bottom right contact less the nominal contact angle [rad], any shape ``(...)``.
    mated
        Whether the contact angles on the top groove differ from the nominal one by the same amounts as those opposite to
        them on the bottom groove, as in design (b) of section 3.3.4.2 of Lin's thesis: the two contacts of each diagonal
        then remain opposite to each other, so that the deviation of the velocity by eq. (3.43) of the thesis is zero under
        any load. Otherwise both contact angles on the top groove are the nominal one.
    """
    t = np.asarray(theta, dtype=float)
    bottom = np.stack([-t, t], axis=-1)
    top = bottom if mated else np.zeros_like(bottom)
    return np.concatenate([bottom, top], axis=-1)


def loads_equal_on_diagonals(vertical: float, side_ratio: Array, contact_angle: float = 0.25 * np.pi) -> Array:
    """Return loads of a ball's contacts that are equal on each diagonal, BL with TR and BR with TL.

    These loads are F_BL = F_TR = (N_y/cos beta_0 - N_x/sin beta_0)/2 and F_BR = F_TL = (N_y/cos beta_0 + N_x/sin
    beta_0)/2 with the vertical force N_y, the side force N_x and the contact angle beta_0. B and T stand for bottom and
    top, L and R for left and right.

    Parameters
    ----------
    vertical
        Vertical force N_y on the carriage [N].
    side_ratio
        Ratio rho = N_x/N_y of side force to vertical force, any shape ``(...)``.
    contact_angle
        Nominal contact angle beta_0 [rad].

    Returns
    -------
    Array
        Loads of the contacts BL, BR, TR, TL ``(..., 4)`` [N].

    Raises
    ------
    ValueError
        abs(rho) > tan(contact angle), where a diagonal would have to pull.

    References
    ----------
    Lin (2019), text before 3.54.

    Examples
    --------
    >>> loads_equal_on_diagonals(100.0, np.array(0.5)).round(3).tolist()
    [35.355, 106.066, 35.355, 106.066]
    """
    rho = np.asarray(side_ratio, dtype=float)
    upright, across = 0.5 / np.cos(contact_angle), 0.5 * rho / np.sin(contact_angle)
    up, down = vertical * (upright - across), vertical * (upright + across)
    if np.any(np.minimum(up, down) < -1e-12 * vertical):
        raise ValueError(
            "the ratio of side force to vertical force on the carriage must lie within +-tan(contact angle) = "
            f"+-{np.tan(contact_angle):.6g}, got up to {float(np.max(np.abs(rho))):.6g}: beyond these limits, two opposite "
            "contacts would have to pull"
        )
    up, down = np.maximum(up, 0.0), np.maximum(down, 0.0)
    return np.stack([up, down, up, down], axis=-1)


def loads_in_equilibrium(angles: Array, vertical: float, side_ratio: Array) -> Array:
    """Return contact loads ``(N, 4)`` [N] of N balls that are in equilibrium at given contact angles.

    The two equations of equilibrium of the carriage determine the two loads at the top, those of the ball the two loads
    at the bottom. Negative loads are set to zero.

    Parameters
    ----------
    angles
        Contact angles of N balls ``(N, 4)`` [rad].
    vertical
        Vertical force N_y on the carriage at each ball [N].
    side_ratio
        Ratio rho = N_x/N_y of side force to vertical force ``(N,)``.
    """
    n, rho = contact_directions(angles), np.asarray(side_ratio, dtype=float)
    carriage = vertical * np.stack([rho, -np.ones_like(rho)], axis=-1)
    top = np.linalg.solve(np.swapaxes(n[:, 2:], 1, 2), -carriage[..., None])[..., 0]
    bottom = np.linalg.solve(np.swapaxes(n[:, :2], 1, 2), carriage[..., None])[..., 0]
    return np.asarray(np.maximum(np.concatenate([bottom, top], axis=1), 0.0))


def loads_of_elastic_contacts(
    bearing: LinearBearing, angles: Array, vertical: float, side_ratio: Array
) -> tuple[Array, Array]:
    """Return the contact loads [N], then the contact angles under load [rad], of N balls with elastic contacts, ``(N, 4)``.

    Balls and grooves have Hertz contacts without clearance and friction. The loads are those at the minimum of the
    energy sum 2/5 C^(-3/2) <approach>^(5/2) - N_x u_x + N_y u_y over the displacements of ball and carriage. C is the
    Hertz constant of the contacts, <approach> the approach where positive, and u_x, u_y is the displacement of the
    carriage.

    Parameters
    ----------
    bearing
        Bearing with the Hertz constants of its contacts.
    angles
        Contact angles of the unloaded ball, which touches all four grooves ``(N, 4)`` [rad].
    vertical
        Vertical force N_y on the carriage at each ball [N].
    side_ratio
        Ratio rho = N_x/N_y of side force to vertical force ``(N,)``.

    Raises
    ------
    ArithmeticError
        The search for the minimum finds no balance of forces.
    """
    pairs = [_elastic_loads_and_angles(bearing, a, vertical, float(r)) for a, r in zip(angles, side_ratio, strict=True)]
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])


def _elastic_loads_and_angles(
    bearing: LinearBearing, angles: Array, vertical: float, side_force_ratio: float
) -> tuple[Array, Array]:
    """Return first the contact loads ``(4,)`` [N], then the contact angles ``(4,)`` [rad] of one ball under load.

    ``bearing``: bearing with the Hertz constants of its contacts; ``angles``: contact angles of the unloaded ball ``(4,)``
    [rad]; ``vertical``: vertical force N_y on the carriage [N]; ``side_force_ratio``: ratio N_x/N_y of side force to
    vertical force. The method is described in `loads_of_elastic_contacts`.
    """
    n = contact_directions(angles)
    slack = bearing.ball_radius * (2.0 * bearing.conformity - 1.0)
    C = float(bearing.contact_hertz_constants().C)
    # the carriage, with contacts 2 and 3, is the inner body of the cell
    pull = vertical * np.array([side_force_ratio, -1.0])
    place = np.array([side_force_ratio, -1.0]) * C * vertical ** (2.0 / 3.0)
    cell = BallContactArrays(
        groove_to_ball_vectors=np.ascontiguousarray(slack * n[None, TOP_FIRST]),
        interference=np.zeros((1, 4)),
        C=np.full(4, C),
        inner_displacement_maps=np.eye(2)[None],
        given_inner_displacement=np.zeros((1, 2)),
        ball_forces=np.zeros((1, 2)),
        inner_body_forces=pull,
        groove_ball_centre_distance=slack,
    )

    def angles_from_normals(normal: Array) -> Array:
        """Return the contact angles ``(N, 4)`` [rad] that belong to contact normals.

        The angles are in the order bottom left, bottom right, top right, top left. ``normal``: contact normals in the
        order top right, top left, bottom left, bottom right ``(N, 4, 2)``.
        """
        outward = SENSE * normal[:, TOP_FIRST]
        return np.asarray(np.arctan2(outward[..., 0], outward[..., 1]))

    settled = solve_contact_loads(cell, float(np.linalg.norm(pull)), place[None].copy(), 2.0 * place, angles_from_normals)
    if not settled.converged:
        raise ArithmeticError(
            "no equilibrium of a ball in the linear bearing was found: "
            f"{settled.largest_unbalanced_force:.1e} N are out of balance after {settled.steps} steps"
        )
    return settled.force[0, TOP_FIRST], settled.angle[0]


def elliptic_integral_second_kind(axis_ratio: float) -> float:
    """Return the complete elliptic integral of the second kind E(e), with e = sqrt(1 - (b/a)^2).

    ``axis_ratio``: ratio b/a of the semi-axes, up to 1.
    """
    from scipy.special import ellipe

    return float(ellipe(1.0 - axis_ratio**2))


def relative_velocity_deviation(contact_angle: float, deviation: Array, bl_tr_load: Array, br_tl_load: Array) -> Array:
    """Return the relative deviation of a ball's velocity from half the carriage's velocity, by Lin's closed formula.

    Parameters
    ----------
    contact_angle
        Nominal contact angle beta_0 [rad].
    deviation
        Deviations Delta beta of the contact angles at bottom left, bottom right, top right, top left ``(..., 4)``
        [rad].
    bl_tr_load, br_tl_load
        Contact loads: F_U on the diagonal from bottom left to top right, F_D on the other diagonal ``(...)`` [N].

    References
    ----------
    Lin (2019), 3.43, with tan beta_0 in place of 1 - cos 2 beta_0.
    """
    bl, br, tr, tl = np.moveaxis(np.asarray(deviation, dtype=float), -1, 0)
    u, d = np.cbrt(np.square(bl_tr_load)), np.cbrt(np.square(br_tl_load))
    return np.asarray(0.5 * np.tan(contact_angle) * ((tr - bl) * u + (tl - br) * d) / (u + d))


def ball_force_by_formula(bearing: LinearBearing, loads: Array, difference: Array, k_f: float) -> Array:
    """Return the force between two neighbouring balls [N] by Lin's closed formula; zero unless they approach each other.

    Parameters
    ----------
    bearing
        Bearing with its ball radius, contact angle and coefficients of friction.
    loads
        Contact loads of balls 1 and 2, in the last axis F_U (diagonal from bottom left to top right) and F_D (other
        diagonal) ``(..., 2, 2)`` [N].
    difference
        Difference epsilon_1 - epsilon_2 of the relative deviations of the balls' velocities without ball-to-ball contact
        ``(...)``.
    k_f
        Slope of friction force divided by mu F (coefficient of friction times contact load), per c/a, see
        `linear_friction_force_factor`; c is the distance of the centre of rotation from the centre of the contact
        ellipse along its semi-axis a.

    References
    ----------
    Lin (2019), 3.51, with exponents +2/3 and tan beta_0.
    """
    stiff = np.cbrt(np.square(loads)).sum(axis=-1)
    in_series = stiff[..., 0] * stiff[..., 1] / (stiff[..., 0] + stiff[..., 1])
    factor = 2.0 * k_f * bearing.mu * np.cbrt(bearing.ball_radius**2)
    factor /= bearing.semi_axis_constant() * np.tan(bearing.contact_angle)
    return np.asarray(factor * in_series * np.maximum(difference, 0.0))


def ball_to_ball_sliding_speed(bearing: LinearBearing) -> float:
    """Return the speed at which two rolling balls that touch slide on each other, abs(v)/cos beta_0 [m/s] (Lin 3.52).

    ``bearing``: bearing with the speed v of its carriage and the contact angle beta_0.
    """
    return float(abs(bearing.speed) / np.cos(bearing.contact_angle))


def ball_to_ball_loss(bearing: LinearBearing, force: Array) -> Array:
    """Return the friction loss [W] between two balls that press on each other with ``force`` [N] (Lin 3.53)."""
    return np.asarray(bearing.mu_balls * force * ball_to_ball_sliding_speed(bearing))


def groove_spin_loss(bearing: LinearBearing, loads: Array) -> Array:
    """Return the friction loss of each contact of ball and groove that only spins, at nominal rolling [W].

    The sum over all contacts is the groove loss to which Lin compares the loss between balls, eq. (3.53) of his thesis.
    ``bearing``: bearing with speed v, contact angle beta_0 and ball radius R_B; ``loads``: contact loads F [N], any
    shape, which is that of the result. The spin is v tan(beta_0)/(2 R_B), and the moment 3/8 mu F a E(e) by eq. (3.32)
    of Lin's thesis, with the coefficient of friction mu, the long semi-axis a, and the complete elliptic integral of
    the second kind E(e) (`elliptic_integral_second_kind`).
    """
    constants = bearing.contact_hertz_constants()
    spin = 0.5 * abs(bearing.speed) * np.tan(bearing.contact_angle) / bearing.ball_radius
    ellip = elliptic_integral_second_kind(float(constants.C_b / constants.C_a))
    return np.asarray(0.375 * bearing.mu * loads * constants.C_a * np.cbrt(loads) * ellip * spin)
