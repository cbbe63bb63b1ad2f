"""Forces of balls and rollers on the flanks of their raceways at given motions of the flanks, as arrays over many members.

Axes, in this order: member (specimen or load case of one model), rolling element, flank (screw left, screw right, nut left,
nut right), component in the ball's section plane (radial, along the helix's binormal). An array that all members share has
a member axis of length one.

The unknowns of a ball between four flanks are the position of its centre and one amplitude of the deformation of its body;
they are eliminated ball by ball. Where only two opposite flanks carry load, the forces depend on the relative motion of
these flanks only and have a closed form. A roller is one element between two rigid rings: in the place of the flanks screw
left and nut left stand its inner and outer ring (cone and cup), in that of the two components the ring's motion along the
contact's normal at the roller's middle, and its slope along the roller times the roller's length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.contact_law import (
    approach_to_arcs,
    approach_to_profiles,
    contact_law,
    lengths,
    line_contact_law,
)
from rollbench.meshes.arrays import Array, Mask

Ints = NDArray[np.int64]
#: Largest number of Newton steps to find a ball's equilibrium, and largest number of times that one step is halved.
SETTLING, HALVINGS = 60, 30
#: Round-off of an approach: as a fraction of the displacement of the ball's centre, or of the ball's radius where the flank
#: is no circular arc.
ROUND_OFF = float(np.finfo(float).eps)
#: A flank pair as slices of the flank axis: in the order of flanks, the opposite one of flank s is 3 - s.
FLANKS = 4


class Stacked:
    """Base class of records whose arrays have a leading axis of members; an axis of length one is shared by all members."""

    def take(self, members: Ints) -> Self:
        """Return a record with the given members only."""
        record: Any = self
        return replace(record, **{name: _taken(getattr(self, name), members) for name in field_names(self)})  # type: ignore[no-any-return]

    def put(self, members: Ints, other: Self) -> None:
        """Overwrite the given members by those of another record, none of whose arrays is shared."""
        for name in field_names(self):
            mine, new = getattr(self, name), getattr(other, name)
            if isinstance(mine, Stacked):
                mine.put(members, new)
            elif mine is not None:
                mine[members] = new


def field_names(record: Any) -> list[str]:
    """Return the names of the fields of a record."""
    return [x.name for x in fields(record)]


def _taken(value: Any, members: Ints) -> Any:
    if isinstance(value, Stacked):
        return value.take(members)
    return value[members] if isinstance(value, np.ndarray) and value.shape[0] > 1 else value


@dataclass(frozen=True)
class Balls(Stacked):
    """N balls between four flanks each. An approach is C F^(2/3) + e F + h F^(4/3) at the force F, see `contact_law`."""

    #: Nominal vector from groove centre to ball centre ``(M, N, 4, 2)`` [m], and its length ``(M, N, 4)`` [m].
    to_ball: Array
    distance: Array
    #: Nominal approach ``(M, N, 4)`` [m], negative for a gap.
    approach: Array
    #: Hertz constants C ``(M, N, 4)`` [m/N^(2/3)].
    C: Array
    #: Whether each flank can carry load ``(M, N, 4)``.
    used: Mask
    #: Nominal interference with the pairs screw left and nut right, screw right and nut left ``(M, N, 2)`` [m].
    interference: Array
    #: Coefficients e [m/N] and h [m/N^(4/3)] ``(M, N, 4)``.
    e: Array
    h: Array
    #: Decrease of the approach per unit amplitude of the ball's deformation ``(M, N, 4)``; its stiffness is one.
    body: Array
    #: Radii of balls ``(M, N)`` and of groove arcs ``(M, N, 4)`` [m].
    radius: Array
    groove_radius: Array
    #: Deviation of the flanks from circular arcs ``(M, N, 4, p)`` [m], see `approach_to_profiles`; p = 0 for exact arcs.
    profile: Array

    @property
    def normals(self) -> Array:
        """Unit vectors ``(M, N, 4, 2)`` from groove centres to ball centres."""
        return self.to_ball / np.maximum(self.distance, 1e-30)[..., None]

    @staticmethod
    def joined(each: Sequence[Balls]) -> Balls:
        """Return the balls of several nuts and bearings, one after the other, as one record; there may be none."""
        degree, none = max((b.profile.shape[3] for b in each), default=0), np.zeros((1, 0, 4))
        empty = Balls(
            none[..., None].repeat(2, axis=3), *(none,) * 3, none > 0.0, none[..., :2], *(none,) * 3, none[..., 0], none,
            np.zeros((1, 0, 4, degree)),
        )  # fmt: skip
        more = (np.pad(b.profile, ((0, 0),) * 3 + ((0, degree - b.profile.shape[3]),)) for b in each)
        every = (empty, *(replace(b, profile=x) for b, x in zip(each, more, strict=True)))
        return Balls(**{name: np.concatenate([getattr(b, name) for b in every], axis=1) for name in field_names(empty)})

    def one_by_one(self, members: int = 1) -> Balls:
        """Return the balls of all members in one axis: arrays ``(M N, ...)``."""
        arrays, count = {x.name: getattr(self, x.name) for x in fields(self)}, members * self.C.shape[1]
        every = {k: np.broadcast_to(a, (members, *a.shape[1:])).reshape(count, *a.shape[2:]) for k, a in arrays.items()}
        return Balls(**every)


@dataclass(frozen=True)
class FlankPairs(Stacked):
    """N balls between two opposite circular flanks a and b each, whose two contacts act in series."""

    #: Vector from the centre of arc b to that of arc a ``(M, N, 2)`` [m], and its length ``(M, N)`` [m].
    between: Array
    distance: Array
    #: Nominal interference ``(M, N)`` [m].
    interference: Array
    #: Coefficients ``(M, N)`` of both contacts: approach = C F^(2/3) + e F + h F^(4/3).
    C: Array
    e: Array
    h: Array


@dataclass(frozen=True)
class Rollers(Stacked):
    """R rollers, divided into at most K slices across their axes; law of a slice: `line_contact_law`."""

    #: Positions ``(1, R, K)`` of the slices along the roller, divided by its length.
    positions: Array
    #: Widths ``(1, R, K)`` [m], 0 for unused slices.
    widths: Array
    #: Gaps ``(1, R, K)`` [m] by crowning and by the ring's axial offset, without ring motions.
    gaps: Array
    #: Constants ``(1, R)`` [m^2/N] of the law.
    g: Array
    s: Array


@dataclass(frozen=True)
class RollingElements(Stacked):
    """All rolling elements between the bodies: the balls, then the rollers (None: there are none)."""

    balls: Balls | FlankPairs
    rollers: Rollers | None
    #: Force ``(M,)`` [N] up to which an element counts as unloaded.
    unloaded: Array


@dataclass(frozen=True)
class Contacts(Stacked):
    """Contacts of N balls with F flanks: four, or one that stands for both flanks of a pair (that of flank a)."""

    #: Force ``(M, N, F)`` [N].
    force: Array
    #: Unit normal from ball to groove ``(M, N, F, 2)``.
    normal: Array
    #: Derivative of the force by the approach ``(M, N, F)`` [N/m].
    stiffness: Array
    #: Force by the curvature of the flank: stiffness against motions across the normal ``(M, N, F)`` [N/m].
    tangential: Array

    @property
    def net_forces(self) -> Array:
        """Magnitude of the net contact force on each ball ``(M, N)`` [N]."""
        return lengths((self.force[..., None] * self.normal).sum(axis=-2))


@dataclass(frozen=True)
class ElementForces(Stacked):
    """Forces of the elements at given motions of the flanks, with what follows from them."""

    #: Forces on the flanks ``(M, N + R, F, 2)`` [N].
    on_flanks: Array
    #: Contacts of the balls.
    contacts: Contacts
    #: Displacement of the ball centres ``(M, N, 2)`` [m], and amplitude of the balls' deformation ``(M, N)``; for pairs 0.
    centres: Array
    amplitudes: Array
    #: Stiffness ``(M, R, 2, 2)`` [N/m] of rollers: force and moment per unit of displacement and slope between the rings.
    roller_stiffness: Array
    #: Energy of all elements ``(M,)`` [J].
    energy: Array
    #: Largest contact force ``(M,)`` [N].
    largest: Array


def between_opposite_flanks(balls: Balls, a: int) -> FlankPairs:
    """Return balls that touch only the opposite circular flanks a and 3 - a, whose contacts act in series."""
    b = 3 - a
    D = balls.to_ball[:, :, b] - balls.to_ball[:, :, a]
    C, e, h = (x[:, :, a] + x[:, :, b] for x in (balls.C, balls.e, balls.h))
    return FlankPairs(D, lengths(D), balls.interference[:, :, a], C, e, h)


def starting_springs(balls: Balls, pair: tuple[int, int] | None, stiffness: float) -> Array:
    """Return factors ``(1, N, w, F, 2)`` of linear springs between opposite flanks, which replace balls in the first solve.

    Each is the square root of the stiffness times the direction of the spring, so that their product with themselves is the
    stiffness [N/m] against motions of a ball's flanks. Zero where there is no spring.

    Parameters
    ----------
    balls
        Contacts of N balls before anything moves.
    pair
        Numbers of the two flanks if only one pair of diagonally opposite flanks is in use, else None.
    stiffness
        Stiffness of each spring [N/m].
    """
    w, used = np.sqrt(stiffness) * balls.normals[0], balls.used[0]
    if pair is not None:
        return np.asarray(w[None, :, pair[0], None, None, :])
    rows = np.zeros((1, len(w), 2, FLANKS, 2))
    for s in range(2):
        both = (used[:, s] & used[:, 3 - s])[:, None]
        rows[0, :, s, s], rows[0, :, s, 3 - s] = np.where(both, w[:, s], 0.0), np.where(both, -w[:, s], 0.0)
    return rows


def starting_springs_of_rollers(count: int, stiffness: float) -> Array:
    """Return factors ``(1, R, 2, 4, 2)`` of springs between the rings at the rollers' middles, as `starting_springs`."""
    rows = np.zeros((1, count, 2, FLANKS, 2))
    rows[0, :, 0, 0, 0], rows[0, :, 0, 2, 0] = np.sqrt(stiffness), -np.sqrt(stiffness)
    return rows


def forces_of_elements(elements: RollingElements, motions: Array) -> ElementForces:
    """Return the forces of all balls and rollers for motions of their flanks ``(M, N + R, F, 2)`` [m].

    For `FlankPairs` F is 1, and the motion is that of flank a relative to flank b.
    """
    if isinstance(elements.balls, FlankPairs):
        return _forces_of_flank_pairs(elements.balls, motions, elements.unloaded)
    members, count = motions.shape[0], elements.balls.C.shape[1]
    found = ball_equilibrium(elements.balls.one_by_one(members), motions[:, :count].reshape(-1, FLANKS, 2),
                             np.repeat(elements.unloaded, count))  # fmt: skip
    x, contacts, energy = (_member_by_member(y, members, count) for y in found)
    f = np.zeros(motions.shape)
    f[:, :count] = contacts.force[..., None] * contacts.normal
    stored, largest = energy.sum(axis=1), contacts.force.max(axis=(1, 2), initial=0.0)
    stiffness = np.zeros((members, 0, 2, 2))
    if elements.rollers is not None:
        force, stiffness, work = roller_forces(elements.rollers, motions[:, count:, 0] - motions[:, count:, 2])
        loaded = force[..., 0] > elements.unloaded[:, None]
        force, stiffness = np.where(loaded[..., None], force, 0.0), np.where(loaded[..., None, None], stiffness, 0.0)
        f[:, count:, 0], f[:, count:, 2] = -force, force
        stored = stored + np.where(loaded, work, 0.0).sum(axis=1)
        largest = np.maximum(largest, force[..., 0].max(axis=1, initial=0.0))
    return ElementForces(f, contacts, x[..., :2], x[..., 2], stiffness, stored, largest)


def _member_by_member(found: Any, members: int, count: int) -> Any:
    """Return arrays ``(M N, ...)``, or a record of them, with the axes member and ball apart."""
    if isinstance(found, Contacts):
        return Contacts(*(_member_by_member(getattr(found, x.name), members, count) for x in fields(found)))
    return found.reshape(members, count, *found.shape[1:])


def _forces_of_flank_pairs(pairs: FlankPairs, v: Array, unloaded: Array) -> ElementForces:
    """Return the forces of balls between two opposite circular flanks a and b, in closed form.

    The vector D from the centre of arc b to that of arc a becomes D + v; the centre of the ball lies on its line. The
    interference is the nominal value plus |D + v| - |D|. ``v`` ``(M, N, 1, 2)``: motion of flank a relative to b [m].
    """
    v = v[:, :, 0]
    w = pairs.between + v
    size = np.maximum(lengths(w), 1e-30)
    approach = pairs.interference + (v * (pairs.between + w)).sum(axis=-1) / (size + pairs.distance)
    force, stiffness, work = contact_law(approach, *np.broadcast_arrays(pairs.C, pairs.e, pairs.h, approach)[:3])
    on = force > unloaded[:, None]
    force, stiffness, work = (np.where(on, x, 0.0) for x in (force, stiffness, work))
    normal = -w / size[..., None]
    contacts = Contacts(*(x[:, :, None] for x in (force, normal, stiffness, force / size)))
    none, count = np.zeros((*force.shape, 2)), len(force)
    f = force[..., None, None] * normal[:, :, None]
    return ElementForces(f, contacts, none, none[..., 0], np.zeros((count, 0, 2, 2)), work.sum(axis=1), force.max(axis=1))


def roller_forces(rollers: Rollers, v: Array) -> tuple[Array, Array, Array]:
    """Return force and moment ``(M, R, 2)`` [N], stiffness ``(M, R, 2, 2)`` [N/m] and energy ``(M, R)`` [J] of rollers.

    The moment is divided by the roller's length. ``v`` ``(M, R, 2)``: displacement of the cone (inner ring) relative to the
    cup at the roller's middle, and its slope along the roller times the roller's length [m].
    """
    at = np.stack([np.ones_like(rollers.positions), rollers.positions], axis=-1)
    load, stiffness, energy = slice_forces(rollers, v)
    turned = at[..., :, None] * at[..., None, :]
    return (load[..., None] * at).sum(axis=2), (stiffness[..., None, None] * turned).sum(axis=2), energy.sum(axis=2)


def slice_forces(rollers: Rollers, v: Array) -> tuple[Array, Array, Array]:
    """Return force [N], stiffness [N/m], energy [J] of each slice of rollers ``(M, R, K)``; ``v``: see `roller_forces`."""
    approach = v[..., :1] + v[..., 1:] * rollers.positions - rollers.gaps
    g, s = (np.broadcast_to(x[..., None], approach.shape) for x in (rollers.g, rollers.s))
    load, stiffness, energy = (rollers.widths * x for x in line_contact_law(approach, g, s))
    return load, stiffness, energy


def pair_interference(balls: Balls, shift: Array, a: int) -> tuple[Array, Array, Array]:
    """Return the interference ``(B,)`` [m] of balls with the opposite flanks a and 3 - a, and how the groove centres lie.

    The second result is the vector ``(B, 2)`` from the groove centre of the flank 3 - a to that of the flank a, the third
    the growth of its length by the motions ``shift`` ``(B, 4, 2)`` of the flanks.
    """
    b = 3 - a
    D, v = balls.to_ball[:, b] - balls.to_ball[:, a], shift[:, a] - shift[:, b]
    change = (v * (2.0 * D + v)).sum(axis=-1) / np.maximum(lengths(D + v) + lengths(D), 1e-30)
    return balls.interference[:, a] + change, D, change


def first_ball_centres(balls: Balls, shift: Array) -> Array:
    """Return first guesses of the displacements of B ball centres ``(B, 2)`` [m] at flank motions ``(B, 4, 2)`` [m].

    The guess is the mean of the two-contact solutions of all diagonal pairs with interference, or the mean motion of the
    flanks if there is none. If only one pair can carry load, it is used even with clearance. The contacts of a pair share
    its interference in the ratio of their Hertz constants, which is exact for circular flanks.
    """
    at, count, used = np.zeros((len(shift), 2)), np.zeros(len(shift)), balls.used
    for a in range(2):
        b = 3 - a
        total, D, change = pair_interference(balls, shift, a)
        v, nominal, size = shift[:, a] - shift[:, b], lengths(D), lengths(D + shift[:, a] - shift[:, b])
        alone = ~(used[:, 1 - a] | used[:, 2 + a])
        met = used[:, a] & used[:, b] & (nominal > 1e-30) & (size > 1e-30) & ((total > 0.0) | alone)
        # The ball's centre lies on the line D + v, at the distance from b's groove centre that gives b its share of the
        # interference. The rotation of that line is (v - D/|D| change)/|D + v|, without subtracting unit vectors.
        n, share = D / np.maximum(nominal, 1e-30)[:, None], balls.C[:, b] / (balls.C[:, a] + balls.C[:, b])
        added, far = (total * share - balls.approach[:, b])[:, None], balls.distance[:, b, None]
        turned = ((D + v) * added + (v - n * change[:, None]) * far) / np.maximum(size, 1e-30)[:, None]
        at += np.where(met[:, None], shift[:, b] + turned + (n * far - balls.to_ball[:, b]), 0.0)
        count += met
    mean = (shift * used[..., None]).sum(axis=1) / np.maximum(used.sum(axis=1), 1)[:, None]
    return np.where(count[:, None] > 0.0, at / np.maximum(count, 1.0)[:, None], mean)


def ball_contacts(balls: Balls, x: Array, shift: Array) -> tuple[Contacts, Array]:
    """Return the contacts of B balls with their four flanks, and the energy of each ball ``(B,)`` [J].

    Parameters
    ----------
    balls
        Balls with arrays ``(B, 4, ...)``.
    x
        Displacement of each centre (two components [m]) and amplitude of the ball's deformation ``(B, 3)``.
    shift
        Motions of the flanks ``(B, 4, 2)`` [m].
    """
    moved = x[:, None, :2] - shift
    if balls.profile.shape[-1]:
        met = approach_to_profiles(moved, balls.to_ball, balls.radius, balls.groove_radius, balls.profile)
    else:
        met = approach_to_arcs(moved, balls.to_ball, balls.distance, balls.approach)
    approach, normal, curvature = met
    approach = np.where(balls.used, approach - balls.body * x[:, 2, None], -1.0)
    force, stiffness, work = contact_law(approach, balls.C, balls.e, balls.h)
    return Contacts(force, normal, stiffness, force * curvature), work.sum(axis=1) + 0.5 * x[:, 2] ** 2


def ball_equilibrium(balls: Balls, shift: Array, unloaded: Array) -> tuple[Array, Contacts, Array]:
    """Return the equilibrium of B balls at given motions of their flanks: unknowns ``(B, 3)``, contacts, energies ``(B,)``.

    Newton's method with halved steps on the energy of each ball, which is convex; balls that have settled leave it.

    Parameters
    ----------
    balls
        Balls with arrays ``(B, 4, ...)``.
    shift
        Motions of the flanks ``(B, 4, 2)`` [m].
    unloaded
        Force ``(B,)`` [N] up to which a ball counts as unloaded.
    """
    x = np.zeros((len(shift), 3))
    x[:, :2] = first_ball_centres(balls, shift)
    contacts, energy = ball_contacts(balls, x, shift)
    left, best = np.arange(len(x)), np.full(len(x), np.inf)
    shortest = ROUND_OFF * (balls.radius if balls.profile.shape[-1] else np.abs(x[:, :2]).max(axis=1))
    for _ in range(SETTLING):
        c, body, y = contacts.take(left) if len(x) > 1 else contacts, balls.body[left], x[left, 2]
        net = (c.force[..., None] * c.normal).sum(axis=1)
        rest = y - (c.force * body).sum(axis=1)
        largest, reach = c.force.max(axis=1), np.abs(body).max(axis=1)
        off = np.maximum(lengths(net), np.where(reach > 0.0, np.abs(rest) / np.where(reach > 0.0, reach, 1.0), 0.0))
        idle = largest <= unloaded[left]
        contacts.force[left[idle]], energy[left[idle]] = 0.0, 0.0
        enough = np.maximum(1e-11 * largest, shortest[left] * c.stiffness.max(axis=1))
        done = idle | (off <= 2e-15 * largest) | ((off <= enough) & (off >= 0.5 * best[left]))
        best[left] = np.minimum(best[left], off)
        step, slope = _newton_step_of_balls(c, body, np.column_stack([net, rest]))
        moved = np.maximum(np.abs(step[:, :2]).max(axis=1), reach * np.abs(step[:, 2]))
        go = np.flatnonzero(~done & (slope != 0.0) & (moved > shortest[left]))
        left, step, slope, moved = left[go], step[go], slope[go], moved[go]
        if not left.size:
            break
        t, some, lower = np.ones(left.size), np.arange(left.size), np.zeros(left.size, dtype=bool)
        for _ in range(HALVINGS):
            i = left[some]
            at = x[i] + t[some, None] * step[some]
            new, stored = ball_contacts(balls.take(i) if len(x) > 1 else balls, at, shift[i])
            gain = t[some] * slope[some]
            rounding = 1e-13 * energy[i] + shortest[i] * contacts.force[i].sum(axis=1)
            fine = (stored <= energy[i] + 1e-4 * gain) | (np.abs(gain) <= rounding)
            j, kept = i[fine], np.flatnonzero(fine)
            x[j], energy[j], lower[some[fine]] = at[fine], stored[fine], True
            contacts.put(j, new.take(kept) if len(i) > 1 else new) if j.size else None
            some = some[~fine]
            t[some] *= 0.5
            some = some[t[some] * moved[some] > shortest[left[some]]]
            if not some.size:
                break
        left = left[lower]
        if not left.size:
            break
    return x, contacts, energy


def _newton_step_of_balls(c: Contacts, body: Array, gradient: Array) -> tuple[Array, Array]:
    """Return the Newton steps ``(B, 3)`` of centre and amplitude of B balls, and the energy's slope along them ``(B,)``.

    The Hessian is the sum of F' r r^T + (F/R) t t^T over the contacts, with r = (normal, -body) and the tangent t, plus one
    for the amplitude. Zeros where it is not positive definite. ``gradient`` ``(B, 3)``: derivatives of the energy.
    """
    loaded = c.force > 0.0
    kn, kt = np.where(loaded, c.stiffness, 0.0), np.where(loaded, c.tangential, 0.0)
    mx, mz = c.normal[..., 0], c.normal[..., 1]
    hxx, hzz = (kn * mx * mx + kt * mz * mz).sum(axis=1), (kn * mz * mz + kt * mx * mx).sum(axis=1)
    hxz, hyy = ((kn - kt) * mx * mz).sum(axis=1), 1.0 + (kn * body * body).sum(axis=1)
    hxy, hzy = -(kn * mx * body).sum(axis=1), -(kn * mz * body).sum(axis=1)
    bump = 1e-14 * (hxx + hzz)  # a ball with one contact has no stiffness across it
    hxx, hzz = hxx + bump, hzz + bump
    with np.errstate(all="ignore"):  # Cholesky's factor, then both substitutions
        lxx = np.sqrt(hxx)
        lxz, lxy = hxz / lxx, hxy / lxx
        lzz = np.sqrt(hzz - lxz * lxz)
        lzy = (hzy - lxy * lxz) / lzz
        lyy = np.sqrt(hyy - lxy * lxy - lzy * lzy)
        sx = -gradient[:, 0] / lxx
        sz = (-gradient[:, 1] - lxz * sx) / lzz
        sy = (-gradient[:, 2] - lxy * sx - lzy * sz) / lyy / lyy
        sz = (sz - lzy * sy) / lzz
        sx = (sx - lxz * sz - lxy * sy) / lxx
    step = np.column_stack([sx, sz, sy])
    step[~((lxx > 0.0) & (lzz > 0.0) & (lyy > 0.0))] = 0.0
    return step, (step * gradient).sum(axis=1)


def stiffness_factors(elements: RollingElements, forces: ElementForces) -> Array:
    """Return factors S ``(M, N + R, w, F, 2)`` of the stiffness S^T S [N/m] of each element against motions of its flanks.

    The w rows of an element that are not needed are zero.
    """
    balls, c = elements.balls, forces.contacts
    members, count = c.force.shape[:2]
    if isinstance(balls, FlankPairs):
        return _contact_factors(c)[:, :, 0, :, None]
    every = (getattr(c, x.name) for x in fields(c))
    of_ball = Contacts(*(x.reshape(members * count, *x.shape[2:]) for x in every))
    body = np.broadcast_to(balls.body, c.force.shape).reshape(-1, FLANKS)
    S = _ball_factors(of_ball, body)
    S = S.reshape(members, count, S.shape[1], FLANKS, 2)
    if elements.rollers is None:
        return S
    K, rollers = forces.roller_stiffness, forces.roller_stiffness.shape[1]
    out = np.zeros((members, count + rollers, max(S.shape[2], 2), FLANKS, 2))
    out[:, :count, : S.shape[2]] = S
    root = np.sqrt(K[..., 0, 0])
    side = K[..., 0, 1] / np.where(root > 0.0, root, 1.0)
    rest = np.sqrt(np.maximum(0.0, K[..., 1, 1] - side * side))
    for ring, sign in ((0, 1.0), (2, -1.0)):
        out[:, count:, 0, ring, 0], out[:, count:, 0, ring, 1], out[:, count:, 1, ring, 1] = (
            sign * root,
            sign * side,
            sign * rest,
        )
    return out


def _contact_factors(c: Contacts) -> Array:
    """Return sqrt(k) d ``(..., F, 2, 2)`` of each contact: normal and tangential stiffness k with their directions d."""
    on = c.force > 0.0
    kn, kt = np.sqrt(np.where(on, c.stiffness, 0.0)), np.sqrt(np.where(on, c.tangential, 0.0))
    tangent = np.stack([-c.normal[..., 1], c.normal[..., 0]], axis=-1)
    return np.stack([kn[..., None] * c.normal, kt[..., None] * tangent], axis=-2)


def _ball_factors(c: Contacts, body: Array) -> Array:
    """Return factors S ``(B, w, 8)`` of the stiffness of B balls against motions of their four flanks.

    The columns of a ball's flanks are made orthogonal to those of its centre and amplitude (QR), which eliminates these
    unknowns without subtracting large numbers. Contacts with load come first, so that n of them fill 2 n - 2 rows.
    """
    order = np.argsort(-c.force, axis=1, kind="stable")
    roots = np.take_along_axis(_contact_factors(c), order[..., None, None], axis=1)  # (B, 4, normal or tangent, 2)
    along = np.take_along_axis(np.sqrt(np.where(c.force > 0.0, c.stiffness, 0.0)) * body, order, axis=1)
    most, count = int((c.force > 0.0).sum(axis=1).max(initial=0)), len(order)
    width = max(2 * most - 2, 1)
    own, flanks = np.zeros((count, 9, 3)), np.zeros((count, 9, FLANKS, 2))
    own[:, 0, 2], own[:, 1:, :2], own[:, 1::2, 2] = 1.0, roots.reshape(count, 8, 2), -along
    ball = np.arange(count)[:, None, None]
    flanks[ball, 1 + np.arange(8).reshape(4, 2), order[..., None]] = roots
    Q = np.linalg.qr(own[:, : 3 + width], mode="complete")[0]
    return Q[..., 3:].swapaxes(1, 2) @ flanks[:, : 3 + width].reshape(count, 3 + width, 2 * FLANKS)
