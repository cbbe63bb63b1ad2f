"""Mesh settings of the 3D reference, and the estimated contact sizes from which they follow.

The contacts are estimated with a simple model that serves only to size the mesh, and needs no finite-element packages. The
screw is a Timoshenko beam through its supports, loads and balls (or one rigid section, where the scene says so), nuts are
rigid, every ball moves freely in its section, and every contact is Hertz's. Groove and ball stay circular, so that the
contact angle follows the motion: with the vector d from the groove's to the ball's centre, the approach is |d| + r_ball -
r_groove. The energy is convex, as a convex function of |d|, so that damped Newton steps find its minimum.

Forces, moments, oversize, groove errors and prescribed displacements are included. The compliance of the bodies is left
out. The largest contact is therefore overestimated by some per cent, and loads caused by prescribed displacements by more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from rollbench.hifi.contact.hertz import HertzSolution, solve_hertz
from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.shaft.beam import ShaftSupports, beam_stiffness, round_section
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Thrust
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout, lead_angle, nominal_groove_radii
from rollbench.meshes.one_arc import flanks_of_single_arc_contacts
from rollbench.meshes.parts import SIDE_SIGNS, Scene
from rollbench.meshes.record_keys import frozen_default, frozen_record
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Expected semi-axes are rounded to this length [m], so that similar scenes share their patches.
ROUNDING = 5e-6


@frozen_record
class Settings:
    """Mesh settings of the 3D reference: cell sizes at contacts and in bodies, submodels, modes and element type."""

    #: Number of mesh cells across the short semi-axis b of a contact ellipse.
    b_over_h: float = frozen_default(4.0)
    #: Semi-axes a (across the groove) and b (along it) of a typical contact ellipse [m].
    semi: tuple[float, float] = frozen_default((0.40e-3, 0.105e-3))
    #: Largest distances from the nominal contact point to the edge of a contact ellipse, across and along the groove [m].
    reach: tuple[float, float] = frozen_default((0.40e-3, 0.105e-3))
    #: Element size of the coarse bodies at the refinement boxes [m].
    fine: float = frozen_default(1.0e-3)
    #: Element size of the coarse bodies far from the refinement boxes [m].
    coarse: float = frozen_default(5.0e-3)
    #: Element size of the balls at the refinement boxes [m].
    ball_fine: float = frozen_default(0.35e-3)
    #: Element size of the balls far from the refinement boxes [m].
    ball_coarse: float = frozen_default(0.8e-3)
    #: Numbers of subdivisions of the refinement boxes' edges across the groove, in depth and along the groove.
    cuts: tuple[int, int, int] = frozen_default((3, 2, 3))
    #: Ratio of the sizes of neighbouring cells of a fine mesh (patch) outside the contact zone.
    growth: float = frozen_default(1.6)
    #: Numbers of subdivisions of the refinement box's edges (across, in depth, along the groove) in submodels of one
    #: contact.
    own_cuts: tuple[int, int, int] = frozen_default((4, 4, 4))
    #: Element sizes of the submodels of grooves, near the refinement box and far from it [m].
    own_sizes: tuple[float, float] = frozen_default((0.5e-3, 2.5e-3))
    #: Element sizes of the submodels of balls, near the refinement box and far from it [m].
    own_ball_sizes: tuple[float, float] = frozen_default((0.3e-3, 0.6e-3))
    #: Element size of the auxiliary 3D shafts by which the additional flexibility of a cut shaft end is computed [m].
    cell: float = frozen_default(4.5e-3)
    #: Number of displacement modes by which each contact of screw and nut is coupled to its body.
    modes: int = frozen_default(16)
    #: Number of displacement modes by which each contact of a ball is coupled to the ball.
    ball_modes: int = frozen_default(24)
    #: ``"Q2"``: patches of 27-node hexahedra on second-order bodies; ``"P1"``: first-order tetrahedra on first-order
    #: bodies, as in Lin's thesis, without submodels.
    element: str = frozen_default("Q2")
    #: Edge length of the tetrahedra around each contact, for ``"P1"`` [m].
    tet: float = frozen_default(0.08e-3)


def round_up_lengths(lengths: tuple[float, float]) -> tuple[float, float]:
    """Round two lengths [m] up to multiples of `ROUNDING`, so that similar scenes get the same contact meshes.

    Parameters
    ----------
    lengths : tuple[float, float]
        Two lengths [m].

    Returns
    -------
    tuple[float, float]
        The lengths, rounded up [m].

    Examples
    --------
    >>> round_up_lengths((0.4001e-3, 0.105e-3))
    (0.00040500000000000003, 0.000105)
    """
    a, b = (max(1.0, float(np.ceil(x / ROUNDING - 1e-9))) * ROUNDING for x in lengths)
    return a, b


#: Largest number of Newton steps of the contact estimate, and unbalanced force over the largest force at which they end.
STEPS, BALANCED = 200, 1e-6

#: Stiffness of soft springs on unloaded balls and unsupported screws, and stiffness of supports, both over that of a
#: loaded contact.
SOFT, HELD = 1e-7, 1e4

#: Largest force of the soft springs over the largest contact load. If their force is larger, nothing else supports the
#: screw.
CARRIED = 1e-2

#: Balls that carry less than this fraction of the largest load are left out of the mean contact size.
LOADED = 0.05

#: Gaps below this fraction of the largest approach count as nearly closed.
NEAR = 0.2


@dataclass(frozen=True)
class ExpectedContacts:
    """Estimated loads, angles and ellipses of the contacts of n balls with the groove flanks, in the order SL, SR, NL, NR.

    S: screw, N: nut; L: left, R: right.
    """

    #: Estimated contact loads of n balls on four groove flanks ``(n, 4)`` [N].
    loads: Array
    #: Estimated contact angles of n balls on four groove flanks ``(n, 4)`` [rad]; the nominal angle where a contact is
    #: open.
    angles: Array
    #: Semi-axes of the contact ellipses across the groove ``(n, 4)`` [m].
    semi_axes_across: Array
    #: Semi-axes of the contact ellipses along the groove ``(n, 4)`` [m].
    semi_axes_along: Array
    #: Distance of each contact's centre from the nominal contact point along the groove's arc, towards the edge ``(n, 4)``
    #: [m].
    centre_shifts: Array
    #: Gaps between ball and groove flank ``(n, 4)`` [m]; negative where they are pressed together.
    gaps: Array

    def typical_semi_axes(self) -> tuple[float, float]:
        """Return the semi-axes of a typical loaded contact ellipse, across and along the groove [m].

        Each is a mean over the loaded balls. For every ball the ellipse of its most heavily loaded contact is taken, scaled
        to the mean of these largest loads over the balls.
        """
        largest = self.loads.max(axis=1)
        ball = np.flatnonzero(largest > LOADED * largest.max(initial=0.0))
        if not ball.size:
            return float(self.semi_axes_across.max()), float(self.semi_axes_along.max())
        side = self.loads[ball].argmax(axis=1)
        scale = np.cbrt(float(largest[ball].mean()) / largest[ball])
        across, along = (float((x[ball, side] * scale).mean()) for x in (self.semi_axes_across, self.semi_axes_along))
        return across, along

    def largest_reach(self) -> tuple[float, float]:
        """Return how far the contact ellipses reach from the nominal contact points, across and along the groove [m]."""
        return float((self.semi_axes_across + np.abs(self.centre_shifts)).max()), float(self.semi_axes_along.max())

    def nearly_touching_flanks(self) -> tuple[int, ...]:
        """List the groove flanks (0 to 3) that touch, or whose smallest gap is below a fifth of the largest approach."""
        return tuple(int(s) for s in np.flatnonzero(self.gaps.min(axis=0) < -NEAR * self.gaps.min()))


@dataclass(frozen=True)
class _ContactEstimateModel:
    """Equations of the simple model (rigid nut, beam, Hertz springs) that estimates the contacts of n balls."""

    #: Stiffness K of shaft, housings, supports and soft springs ``(f, f)``, on all f degrees of freedom: six of each shaft
    #: section and of each movable housing, and two displacements of each ball in the groove's section.
    K: sp.csc_array
    #: Loads P on the f degrees of freedom of shaft sections, housings and balls ``(f,)`` [N, N m].
    P: Array
    #: Change of the ``unloaded_centre_vectors`` by a unit of each of the f degrees of freedom of ``K`` ``(8 n, f)``.
    A: sp.csr_array
    #: Vectors from the centre of each groove flank's arc to the ball's centre in the unloaded state, in the groove's
    #: section ``(n, 4, 2)`` [m].
    unloaded_centre_vectors: Array
    #: Distances from groove centre to ball centre at which ball and groove touch ``(n, 4)`` [m].
    touching_distance: Array
    #: Hertz's constant, force F over approach^(3/2) ``(n, 4)`` [N/m^(3/2)]; zero on flanks that cannot touch.
    hertz_constants: Array
    #: Stiffness of a typical Hertz contact, with which Newton's method regularises lightly loaded contacts [N/m].
    typical_stiffness: float
    #: Stiffness of the soft springs, contained in ``K``, that prevent unsupported rigid motions ``(f,)`` [N/m, N m].
    soft_springs: Array
    #: Factors that turn the degrees of freedom into displacements ``(f,)``: 1 for displacements, a length [m] for
    #: rotations.
    lengths: Array


@dataclass(frozen=True)
class _EstimatedNut:
    """One nut or bearing on the shaft, as input of the model that estimates its contacts."""

    #: Scene with the nut or bearing, its balls and the shaft.
    scene: Scene
    #: Whether each of the four groove flanks can touch a ball.
    touchable_flanks: tuple[bool, ...]
    #: Shift of the nut along the shaft [m].
    nut_offset: float = 0.0
    #: Index of the movable housing that carries the nut; None: the nut is fixed.
    housing_index: int | None = None


@lru_cache(maxsize=64)
@cached_on_disk(ExpectedContacts)
def estimate_contacts_of_scene(scene: Scene) -> ExpectedContacts:
    """Estimate the contact loads and ellipses of a ball screw or bearing, to size its meshes.

    Parameters
    ----------
    scene : Scene
        Screw or bearing.

    Returns
    -------
    ExpectedContacts
        Contacts of all balls.

    Raises
    ------
    ValueError
        The model finds no equilibrium, or a contact ellipse is too thin for Hertz's formulas.
    """
    nut = _EstimatedNut(scene, _which_flanks_can_touch(scene, "both"))
    return _estimate_contacts((nut,), ShaftSupports.from_scene(scene))[0]


@lru_cache(maxsize=64)
@cached_on_disk(tuple)
def estimate_contacts_of_each_set(assembly: Assembly) -> tuple[ExpectedContacts, ...]:
    """Estimate the contact loads and ellipses of each nut or bearing on a shaft, to size its meshes.

    A preload by force is replaced by the axial shift of the nut that produces it if only the contacts are elastic.

    Parameters
    ----------
    assembly : Assembly
        The shaft with its nuts and bearings.

    Returns
    -------
    tuple[ExpectedContacts, ...]
        Contacts of each nut or bearing.

    Raises
    ------
    ValueError
        The model finds no equilibrium, or a contact ellipse is too thin for Hertz's formulas.
    """
    frame, sets = ShaftSupports.from_scene(assembly), []
    for s in assembly.sets:
        if isinstance(s.parts, Scene):
            away = -1.0 if s.thrust == "+z" else 1.0
            offset = s.offset + (away * nut_shift_for_axial_force(s.parts, s.preload) if s.preload else 0.0)
            flanks = _which_flanks_can_touch(s.parts, s.thrust)
            sets.append(_EstimatedNut(s.parts, flanks, offset, frame.housing_index(s.housing)))
    return _estimate_contacts(tuple(sets), frame)


def estimate_contacts_under_assumed_load(scene: Scene, unloaded: ExpectedContacts, load: float) -> ExpectedContacts:
    """Estimate the contacts of an unloaded nut or bearing as if a load pressed the flanks with the smallest gaps.

    Parameters
    ----------
    scene : Scene
        Scene with the nut or bearing, its balls and the shaft.
    unloaded : ExpectedContacts
        Estimated contacts of the nut or bearing without load.
    load : float
        Load of each contact [N].

    Returns
    -------
    ExpectedContacts
        Estimated contacts under that load.
    """
    nearest = int(unloaded.gaps.min(axis=0).argmin())
    on = np.isin(np.arange(4), (nearest, 3 - nearest)) & np.ones_like(unloaded.loads, dtype=bool)
    loads, gaps = np.where(on, load, 0.0), np.where(on, -1.0, np.inf)
    across, along = _contact_semi_axes(scene, loads)
    return replace(unloaded, loads=loads, semi_axes_across=across, semi_axes_along=along, gaps=gaps)


def _contact_semi_axes(scene: Scene, loads: Array) -> tuple[Array, Array]:
    """Compute the semi-axes of Hertz's contact ellipses across and along the groove ``(n, 4)`` each [m].

    ``loads``: contact loads of n balls on the four groove flanks (n, 4) [N].
    """
    units = hertz_contacts_under_unit_force(scene)
    across, along = (np.cbrt(loads) * np.array([getattr(x, name) for x in units]) for name in ("semi_x", "semi_y"))
    return across, along


def nut_shift_for_axial_force(scene: Scene, force: float) -> float:
    """Compute the axial shift of a nut under an axial force if all parts are rigid except for the Hertz contacts.

    Parameters
    ----------
    scene : Scene
        Scene with the nut or bearing, its balls and the shaft.
    force : float
        Axial force that all balls carry together [N].

    Returns
    -------
    float
        Shift relative to the shaft [m]: (C_1 + C_2) (F/(n sin beta))^(2/3)/sin beta, with the approach C Q^(2/3) of either
        contact of a ball under the load Q, the number n of balls and the contact angle beta.
    """
    sin, units = float(np.sin(scene.track.contact_angle)), hertz_contacts_under_unit_force(scene)
    return (units[0].approach + units[3].approach) * float(np.cbrt(force / (scene.ball_count * sin))) ** 2 / sin


def _which_flanks_can_touch(scene: Scene, thrust: Thrust) -> tuple[bool, ...]:
    """Return whether each of the four groove flanks can touch a ball, if the nut carries thrust in a given direction.

    ``thrust``: direction of the axial force that the nut can carry, such as "+z" or "both". With grooves of a single arc,
    only one flank of the screw and one of the nut can touch.
    """
    if (sides := flanks_of_single_arc_contacts(scene)) and thrust in ("both", "deep groove"):
        return tuple(s in sides for s in range(4))
    return thrust != "-z", thrust != "+z", thrust != "+z", thrust != "-z"


def _estimate_contacts(sets: tuple[_EstimatedNut, ...], frame: ShaftSupports) -> tuple[ExpectedContacts, ...]:
    """Estimate the contacts of each nut or bearing on a shaft by a beam, rigid nuts and Hertz springs.

    ``sets``: the nuts and bearings; ``frame``: supports and loads of the shaft. Raises ValueError without equilibrium.
    """
    model = _assemble_estimate_model(sets, frame)
    load, vectors = _solve_estimated_equilibrium(model)
    gap = model.touching_distance - np.linalg.norm(vectors, axis=2)
    gap[model.hertz_constants == 0.0] = np.inf
    signs, ends = np.array(SIDE_SIGNS), np.cumsum([s.scene.ball_count for s in sets])[:-1]
    contacts = []
    for s, F, v, g in zip(sets, *(np.split(x, ends) for x in (load, vectors, gap)), strict=True):
        beta = s.scene.track.contact_angle
        angle = np.where(F > 0.0, np.arctan2(v[..., 1] * signs[:, 1], v[..., 0] * signs[:, 0]), beta)
        shifts = (angle - beta) * nominal_groove_radii(s.scene)
        contacts.append(ExpectedContacts(F, angle, *_contact_semi_axes(s.scene, F), shifts, g))
    return tuple(contacts)


def hertz_contacts_under_unit_force(scene: Scene) -> tuple[HertzSolution, ...]:
    """Solve the Hertz contact of a ball with each groove flank (SL, SR, NL, NR) under 1 N; x is across the groove.

    Parameters
    ----------
    scene : Scene
        Scene with the nut or bearing, its balls and the shaft.

    Returns
    -------
    tuple[HertzSolution, ...]
        Contact of each of the four flanks, with the curvatures of the helical grooves.
    """
    m, units = GrooveMap.from_scene(scene), []
    for side, part in ((0, scene.screw), (2, scene.nut)):
        materials = (scene.balls.material, part.material)
        modulus = 2.0 / sum((1.0 - x.poissons_ratio**2) / x.youngs_modulus for x in materials)  # twice the contact modulus
        units += [solve_hertz(1.0, *m.relative_curvature_radii(side, m.beta), modulus, 0.0)] * 2
    return tuple(units)


def _assemble_estimate_model(sets: tuple[_EstimatedNut, ...], frame: ShaftSupports) -> _ContactEstimateModel:
    """Assemble the equations of the contact estimate for all nuts or bearings on a shaft.

    ``sets``: the nuts and bearings; ``frame``: supports and loads of the shaft.
    """
    layouts, count = [ball_layout(s.scene) for s in sets], len(frame.housings)
    first, n = sets[0].scene, sum(x.z.size for x in layouts)
    rigid = any(s.scene.ingredients.screw == "rigid" or dimensions_of_3d_parts(s.scene).screw_held == "bore" for s in sets)
    acted = frame.support_and_load_positions
    nodes = [first.nut.position] if rigid else sorted({round(z, 9) for x in layouts for z in acted | set(x.z.tolist())})
    thread, e = next((s.scene for s in sets if s.scene.track.lead > 0.0), first), first.screw.material
    mean = 0.5 * (thread.screw.outer_diameter / 2.0 + thread.track.pitch_radius - thread.balls.radius)  # of land and groove
    section = round_section(mean, e.youngs_modulus, e.poissons_ratio)
    shaft = 6 * len(nodes)
    K = sp.lil_array((shaft + 6 * count,) * 2)
    for k, (a, b) in enumerate(pairwise(nodes)):
        K[6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += beam_stiffness(b - a, section)
    for spring, stiff in frame.spring_stiffnesses():
        K[shaft:, shaft:] += spring.T @ stiff @ spring

    def rigid_motion_at(body: int, z: float) -> sp.csr_array:
        """Return the matrix ``(6, f)`` that gives the rigid motion of a body at z from the f motions of all bodies.

        ``body``: 0 for the screw, k for the nut on housing k, from 1; ``z``: axial position [m].
        """
        if body:
            first, at = shaft + 6 * (body - 1), frame.housings[body - 1].at
        else:
            k = 0 if rigid else nodes.index(round(z, 9))
            first, at = 6 * k, nodes[k]
        out = sp.lil_array((6, K.shape[0]))
        out[:, first : first + 6] = rigid_motion_transfer_along_z(z - at)
        return out.tocsr()

    wrenches = frame.forces_and_moments()
    lever = frame.length_per_rotation
    share = sum(float(np.linalg.norm(w[:3])) + float(np.linalg.norm(w[3:])) / lever for *_, w in wrenches)
    hertz_constants = [np.array([unit.approach for unit in hertz_contacts_under_unit_force(s.scene)]) ** -1.5 for s in sets]
    for s, constants in zip(sets, hertz_constants, strict=True):
        constants[~np.array(s.touchable_flanks)] = 0.0
    constant = np.concatenate([np.tile(k, (x.z.size, 1)) for k, x in zip(hertz_constants, layouts, strict=True)])
    stiffness = 1.5 * float(constant.max()) ** (2.0 / 3.0) * max(share / n, 1.0) ** (1.0 / 3.0)
    P, held = np.zeros(K.shape[0]), sp.csr_array(K.shape)
    for body, at, wrench in wrenches:
        P += rigid_motion_at(body, at).T @ wrench
    for body, at, k, value in frame.prescribed_motions():
        row, spring = rigid_motion_at(body, at)[[k]], HELD * n * stiffness * frame.lengths_of_unit_motions[k] ** 2
        held = held + spring * (row.T @ row)
        P += spring * value * row.toarray()[0]
    blocks, arms, touch = [], [], []
    for s, layout in zip(sets, layouts, strict=True):
        drawn, track = draw_geometry_with_errors(s.scene, layout), s.scene.track
        for i, z in enumerate(layout.z.tolist()):
            section_frame = np.stack([layout.radial[i], layout.binormal[i]])
            arm = layout.centre[i] - np.array([0.0, 0.0, z])
            turn = np.array([[0.0, arm[2], -arm[1]], [-arm[2], 0.0, arm[0]], [arm[1], -arm[0], 0.0]])
            rows = -sp.csr_array(np.hstack([section_frame, section_frame @ turn]))
            screw, nut = rows @ rigid_motion_at(0, z), sp.csr_array((4, K.shape[0]))
            if s.housing_index is not None:
                nut = sp.vstack([rows @ rigid_motion_at(1 + s.housing_index, z)] * 2)
            blocks.append(sp.vstack([screw, screw, nut]))
        inward = [np.polynomial.Polynomial(p if p.size else [0.0])(track.contact_angle) for p in drawn.profile_coefficients]
        arms.append(-drawn.groove_centres)
        arms[-1][:, 2:, 1] -= s.nut_offset * np.cos(lead_angle(track))
        touch.append((drawn.groove_radii - np.array(inward))[None, :] - drawn.ball_radii[:, None])
    A = sp.hstack([sp.vstack(blocks), sp.kron(sp.eye_array(n), np.tile(np.eye(2), (4, 1)))]).tocsr()
    lengths = np.concatenate([np.tile(frame.lengths_of_unit_motions, len(nodes) + count), np.ones(2 * n)])
    soft = SOFT * stiffness * lengths**2
    K_all = sp.block_diag([K.tocsr() + held, sp.csr_array((2 * n, 2 * n))]) + sp.diags_array(soft)
    P = np.append(P, np.zeros(2 * n))
    vectors, touching = np.concatenate(arms), np.concatenate(touch)
    return _ContactEstimateModel(K_all.tocsc(), P, A, vectors, touching, constant, stiffness, soft, lengths)


def _energy_and_contact_loads(model: _ContactEstimateModel, x: Array) -> tuple[float, Array, Array, Array, Array]:
    """Evaluate the energy and the contact loads of the estimation model at given degrees of freedom x ``(f,)`` [m, rad].

    Returns the energy [J], the contact loads (n, 4) [N], their derivatives by the approach (n, 4) [N/m], the vectors from
    groove to ball centre (n, 4, 2) [m] and the lengths of these vectors (n, 4) [m].
    """
    k, vectors = model.hertz_constants, model.unloaded_centre_vectors
    vectors = vectors + (model.A @ x).reshape(vectors.shape)
    length = np.linalg.norm(vectors, axis=2)
    closed = np.maximum(length - model.touching_distance, 0.0)
    energy = 0.5 * x @ (model.K @ x) - model.P @ x + 0.4 * float((k * closed**2.5).sum())
    return energy, k * closed**1.5, 1.5 * k * np.sqrt(closed), vectors, length


def _solve_estimated_equilibrium(model: _ContactEstimateModel) -> tuple[Array, Array]:
    """Find the equilibrium of the estimation model, the state of least energy, by damped Newton steps.

    Returns the contact loads (n, 4) [N] and the vectors from groove centre to ball centre (n, 4, 2) [m]. Raises ValueError
    if there is no equilibrium.
    """
    K, P, A = model.K, model.P, model.A
    x = np.zeros(P.size)
    energy, load, slope, vectors, length = _energy_and_contact_loads(model, x)
    for step in range(STEPS):
        unit = vectors / length[..., None]
        wrong = P - K @ x - A.T @ (load[..., None] * unit).ravel()
        scale = max(float(load.max()), 1e-3 * float(np.abs(P).max(initial=0.0)), 1e-9)
        if float(np.abs(wrong).max()) < BALANCED * scale and step:
            if float(np.abs(model.soft_springs * x / model.lengths).max()) > CARRIED * scale:
                break
            return load, vectors
        # a stiffness of open contacts that dies out keeps the first steps short
        normal = np.maximum(slope, model.typical_stiffness * 10.0 ** (-step / 4.0))
        turned = (load / length)[..., None, None] * np.eye(2)
        blocks = turned + (normal - load / length)[..., None, None] * unit[..., :, None] * unit[..., None, :]
        H = K + A.T @ sp.block_diag([sp.csr_array(b) for b in blocks.reshape(-1, 2, 2)], format="csr") @ A
        move = spsolve(H.tocsc(), wrong)
        descent, size = float(wrong @ move), 1.0
        while size > 1e-9:
            trial = _energy_and_contact_loads(model, x + size * move)
            if trial[0] <= energy - 1e-4 * size * descent or abs(size * descent) < 1e-12 * abs(energy):
                break
            size *= 0.5
        x = x + size * move
        energy, load, slope, vectors, length = trial
    raise ValueError(
        "the model that estimates contact sizes for the mesh (rigid nut, Hertz springs) finds no equilibrium: support the "
        "screw against the motion that its loads cause"
    )
