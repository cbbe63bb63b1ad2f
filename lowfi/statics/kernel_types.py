"""Arguments and results of the static kernels, as named tuples: the plain and the compiled copy share them.

N balls, n nodes of the screw's beam, k free motions that nothing but the contacts resists, d motions of a ball's flanks: 8
for four flanks, 2 where one diagonal pair has a closed form. Sides in the order SL, SR, NL, NR.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Array of floats (masks and node numbers are passed the same way).
Array = NDArray[Any]


class BeamArrays(NamedTuple):
    """The screw as a beam, with supports and loads."""

    #: Lengths (n - 1,) of the elements [m].
    lengths: Array
    #: Which freedoms of the nodes are held (n, 6).
    fixed: Array
    #: Loads on the nodes (n, 6) [N, N m].
    load: Array
    #: Constants (n - 1, 5) of the elements, see `lowfi.statics.kernel.beam.element_constants`.
    constants: Array
    #: Stiffness of the elements in the lower band (6 n, half bandwidth + 1).
    band: Array


class BeamContacts(NamedTuple):
    """Balls between a screw that is a beam and a fixed nut."""

    #: First node (N, 2) whose motion moves the screw's flanks SL, SR.
    node: Array
    #: Motion of those flanks (N, 2, 2, m) along x3, z3 by the motions of the nodes from ``node`` on.
    B: Array
    #: Rows of the contacts (N, 4, 9), see `lowfi.statics.kernel.ball`.
    geometry: Array
    #: Nominal interference (N, 2) of the diagonal pairs [m].
    closure: Array
    #: Radii of the balls (N,) [m].
    r_ball: Array
    #: Deviation of the flanks' profile (4, d) [m], ascending powers of the contact angle.
    profile: Array
    #: Force [N] below which a contact carries none.
    tiny: float


class RowState(NamedTuple):
    """Unknowns of a system whose unknowns are rows of motions, and the contacts there."""

    #: Motions of the rows (r, 6) [m, rad]: n nodes of the shaft, then the other bodies.
    q: Array
    #: Deformations of the shaft's elements (n - 1, 6) [m, rad].
    d: Array
    #: Centres of the balls (N, 2) from their nominal places [m].
    p: Array
    #: Contacts (N, 4, 5), see `lowfi.statics.kernel.ball`.
    contact: Array
    #: Force [N] and stiffness [N/m] of the rollers' slices (M, 2).
    slices: Array


class MemberArrays(NamedTuple):
    """Arrays of m samples of one screw that replace those of `BeamContacts`; B has length one if all samples share it."""

    #: Lever arms (m, N, 2, 2, 6).
    B: Array
    #: Contacts (m, N, 4, 9).
    geometry: Array
    #: Interference of the diagonal pairs (m, N, 2) [m].
    closure: Array
    #: Radii of the balls (m, N) [m].
    r_ball: Array


class MemberStates(NamedTuple):
    """Solutions of specimens m of one screw."""

    #: Contact forces (m, N, 4) [N].
    force: Array
    #: How each ended (m,), see `lowfi.statics.kernel.search`.
    status: Array
    #: Relative residuals (m,).
    residual: Array
    #: Motions of the nodes (m, n, 6) [m, rad].
    q: Array
    #: Centres of the balls (m, N, 2) [m].
    p: Array


class Slopes(NamedTuple):
    """Derivatives of the energy of rows and balls."""

    #: Gradient by the motions of the rows (r, 6) [N, N m].
    gradient: Array
    #: Second derivatives of a ball's energy by the motion of its flanks [N/m]: (N, 4, 4) of the screw's, or (N, 8, 8).
    hessians: Array


class RowWorkspace(NamedTuple):
    """Work arrays for the iteration on rows of motions."""

    #: Derivatives of the energy.
    slopes: Slopes
    #: Stiffness of shaft and springs, in a lower band or an envelope.
    base: Array
    #: Factor of the whole stiffness, stored alike.
    matrix: Array
    #: Step of the rows (r, 6) [m, rad].
    step: Array
    #: Motions of the rows (r, 6) where the step begins.
    q0: Array
    #: Deformations of the elements (n - 1, 6) where the step begins.
    d0: Array


class Options(NamedTuple):
    """Iteration and stopping parameters of `lowfi.statics.kernel.descent`."""

    #: Relative residual to reach.
    tolerance: float
    #: Largest number of iterations.
    most: int
    #: Stiffness of a typical contact [N/m].
    stiffness: float
    #: Length that makes forces of moments [m].
    arm: float
    #: Largest motion before a body counts as not held [m].
    bound: float
    #: Least force that residuals are measured by [N].
    floor: float
    #: Furthest motion of a flank in one step [m]: the largest ball's radius.
    furthest: float


class BeamSystem(NamedTuple):
    """Screw and its balls."""

    #: Beam and loads.
    shaft: BeamArrays
    #: Balls on it.
    contacts: BeamContacts


class AxisArrays(NamedTuple):
    """Shaft, other bodies, springs between them, and loads; r rows of motions: n nodes, then the bodies."""

    #: Lengths (n - 1,) of the shaft's elements [m].
    lengths: Array
    #: EA [N], EI [N m^2], GJ [N m^2], kGA [N] of the elements (n - 1, 4).
    sections: Array
    #: Constants (n - 1, 5) of the elements, as in `BeamArrays`.
    constants: Array
    #: Which freedoms of the rows are held (r, 6).
    fixed: Array
    #: Loads on the rows (r, 6) [N, N m].
    load: Array
    #: Rows (k, 2) that springs join, -1 for the frame.
    ends: Array
    #: Motion of the springs' ends by those rows (k, 2, 6, 6), the second one with its sign.
    reach: Array
    #: Stiffness of the springs (k, 6, 6).
    springs: Array
    #: Place (r,) of each row in the order of elimination.
    place: Array
    #: First column (6 r,) of each line of the matrix, in the order of elimination.
    first: Array
    #: Where each line is stored (6 r + 1,).
    start: Array


class AxisBalls(NamedTuple):
    """Balls between flanks that move with rows of an `AxisArrays`, of all sets."""

    #: First row (N, 4) whose motion moves a flank, -1 where it is fixed.
    row: Array
    #: Motion of the flanks (N, 4, 2, m) along x3, z3 by that of their row, m = 6, or of that and the next one, m = 12.
    B: Array
    #: Prescribed motion of the flanks (N, 4, 2) [m].
    v0: Array
    #: Contacts (N, 4, 9), as in `BeamContacts`.
    geometry: Array
    #: Nominal interference (N, 2) of the diagonal pairs [m].
    closure: Array
    #: Radii of the balls (N,) [m].
    r_ball: Array
    #: Deviation of the flanks' profile (N, 4, d) [m], ascending powers of the contact angle.
    profile: Array
    #: Force [N] below which a contact carries none.
    tiny: float


class AxisRollers(NamedTuple):
    """Slices of rollers between two raceways, each with the line contact of both: approach B q - drop, force by g and S."""

    #: Rows (M, 2) of inner and outer ring, -1 where it is fixed.
    row: Array
    #: Approach (M, 2, 6) by the motions of those rows.
    B: Array
    #: Lost approach (M,) [m].
    drop: Array
    #: Widths of the slices (M,) [m].
    width: Array
    #: g (M,) of `lowfi.rollers.LineLaw` [m^2/N].
    g: Array
    #: S (M,) of `lowfi.rollers.LineLaw` [m^2/N].
    s: Array


class Progress(NamedTuple):
    """Progress of a Newton iteration."""

    #: Least residual.
    best: float
    #: Lowest energy [J].
    lowest: float
    #: Iterations since either fell.
    stalled: int
    #: Searches that found nothing.
    stuck: int


class AxisSystem(NamedTuple):
    """Shaft with all its rolling elements."""

    #: Shaft, other bodies and springs.
    shaft: AxisArrays
    #: All balls.
    balls: AxisBalls
    #: All slices of rollers.
    rollers: AxisRollers


#: Systems whose unknowns are rows of motions.
Rows = BeamSystem | AxisSystem


class Bodies(NamedTuple):
    """Motions of the flanks of all balls, v = v0 + G phi + R a, by forces phi on the flanks and free motions a."""

    #: G [m/N] of the flanks of the first body (4 N, 4 N), or of both together (2 N, 2 N).
    first: Array
    #: G [m/N] of the flanks of the second body, empty where ``first`` has both.
    second: Array
    #: Motions of the flanks (N, d, k) by the free motions, which are all in metres: rotations times an arm.
    R: Array
    #: Motions of the flanks (N, d) by loads and prescribed displacements [m].
    v0: Array
    #: Work of the loads on the free motions (k,) [N].
    work: Array


class RollerContacts(NamedTuple):
    """Rollers between rings of elastic bodies, K slices each at most; see `lowfi.statics.kernel.rollers`."""

    #: Positions (M, K) of the slices over the roller's length.
    place: Array
    #: Widths of the slices (M, K) [m], 0 where there is none.
    width: Array
    #: Lost approach (M, K) [m].
    drop: Array
    #: g (M,) of `lowfi.rollers.LineLaw` [m^2/N].
    g: Array
    #: S (M,) of `lowfi.rollers.LineLaw` [m^2/N].
    s: Array


class BallContacts(NamedTuple):
    """Balls between flanks of elastic bodies, and rollers after them."""

    #: Rows of the contacts (N, 4, 9), see `lowfi.statics.kernel.ball`.
    geometry: Array
    #: Nominal interference (N, 2) of the diagonal pairs [m].
    closure: Array
    #: e [m/N], what a unit amplitude of the ball's own body takes from the approach [m], h [m/N^(4/3)]; (N, 4, 3).
    local: Array
    #: Radii of the balls (N,) [m].
    r_ball: Array
    #: Deviation of the flanks' profile (N, 4, d) [m], ascending powers of the contact angle.
    profile: Array
    #: Rows (N, 7) of balls between two opposite arcs, see `lowfi.statics.kernel.elastic.pair_balls`.
    pair: Array
    #: Rollers, whose rows in all arrays over elements come after the balls'.
    rollers: RollerContacts
    #: Force [N] below which a contact carries none.
    tiny: float


#: Rows ``local`` of a ball that is rigid beyond its contacts, see `lowfi.statics.kernel.ball`.
RIGID = np.zeros((0, 3))
#: Balls only.
NO_ROLLERS = RollerContacts(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), np.zeros(0))


class BodyState(NamedTuple):
    """Unknowns of bodies and balls, and the contacts there."""

    #: Forces on the flanks (N, d) [N].
    phi: Array
    #: Free motions (k,) [m].
    a: Array
    #: Centre [m] and own amplitude of each ball (N, 3).
    inner: Array
    #: Contacts (N, 4, 5), or (N, 1, 5) of a pair, see `lowfi.statics.kernel.ball`.
    contact: Array


class ForceStep(NamedTuple):
    """Step of Newton's method on the forces."""

    #: Step of the forces on the flanks (N, d) [N].
    dphi: Array
    #: Step of the motions of the flanks (N, d) [m].
    dv: Array
    #: Step of the free motions (k,) [m].
    da: Array


class SearchStart(NamedTuple):
    """Start of a line search on the forces."""

    #: Forces on the flanks (N, d) [N].
    phi: Array
    #: Free motions (k,) [m].
    a: Array
    #: Motions of the flanks by the bodies, G phi (N, d) [m].
    g: Array
    #: All motions of the flanks (N, d) [m].
    v: Array


class BallRows(NamedTuple):
    """Square roots of the balls' stiffness: S^T S of all rows is that of the flanks."""

    #: Rows (N, 6 or 2, d) [(N/m)^(1/2)].
    S: Array
    #: Number of rows of each ball (N,).
    counts: Array
    #: Number of rows before each ball's first (N,).
    starts: Array


class BodySystem(NamedTuple):
    """Elastic bodies with all rolling elements."""

    #: Compliance of the bodies.
    bodies: Bodies
    #: All rolling elements.
    contacts: BallContacts
    #: Linear springs between opposite flanks in place of two contacts, to start with (N, w, d): rows sqrt(stiffness) x
    #: direction, zero where there is none.
    springs: Array


class BodyWorkspace(NamedTuple):
    """Work arrays for the iteration on them."""

    #: Forces of the balls on the flanks (N, d) [N].
    f: Array
    #: Motions of the flanks by the bodies (N, d) [m].
    g: Array
    #: All motions of the flanks (N, d) [m].
    v: Array
    #: Newton step.
    step: ForceStep
    #: Where the line search begins.
    begin: SearchStart
    #: Square roots of the balls' stiffness.
    rows: BallRows


class Trial(NamedTuple):
    """A trial of a line search, see `lowfi.statics.kernel.search`."""

    #: Where the search begins [J].
    energy: float
    #: Slope by the step length, where the search begins [J].
    slope: float
    #: Largest step length.
    limit: float
    #: Longest step length that is too short.
    low: float
    #: Shortest step length that is too long; zero: none yet.
    high: float
    #: Step length to try.
    t: float
    #: Trials before this one.
    tried: int


class Outcome(NamedTuple):
    """Result of a kernel's iteration: status, counts, residual, energy, largest force."""

    #: See ``lowfi.statics.kernel.search``: converged, out of iterations, not held, singular.
    status: int
    #: Number of iterations.
    iterations: int
    #: Number of evaluations of the energy.
    evaluations: int
    #: Relative residual.
    residual: float
    #: Energy [J].
    energy: float
    #: Largest force met [N].
    scale: float
