"""Arguments and results of the numerical kernels of the static models, as named tuples.

The interpreted and the compiled kernels share these types. There are N balls, n nodes of the screw's beam, and k free
motions: rigid motions of a body that nothing but the contacts resists. Each ball has d motions of its flanks: 8 for four
flanks, or 2 for one diagonal pair, between which the ball's position has a closed form. Flanks are in the order SL, SR, NL,
NR: screw left and right, nut left and right.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Array of floats, also used for masks and node numbers.
Array = NDArray[Any]


class BeamArrays(NamedTuple):
    """Arrays of the screw as a beam, with supports and loads."""

    #: Lengths (n - 1,) of the beam elements [m].
    lengths: Array
    #: Which degrees of freedom of the nodes are fixed, as truth values (n, 6): displacements x, y, z, rotations x, y, z.
    fixed: Array
    #: Loads on the nodes (n, 6) [N, N m].
    load: Array
    #: Stiffness constants (n - 1, 5) of the beam elements: lateral, coupling, bending, axial and torsional, see
    #: `lowfi.statics.kernel.beam.element_constants`.
    constants: Array
    #: Lower band of the beam's stiffness matrix (6 n, half bandwidth + 1), see `lowfi.statics.kernel.matrices`.
    band: Array


class BeamContacts(NamedTuple):
    """Arrays of the balls between a screw, modelled as a beam, and a fixed nut."""

    #: Number (N, 2) of the first beam node that moves the screw's left flank, and of the one that moves its right flank, at
    #: each ball.
    first_nodes: Array
    #: Motions (N, 2, 2, m) of the screw's left and right flank, with two components in the ball's section plane (radial,
    #: and along the helix's binormal), per unit of the six motions of the node in ``first_nodes`` (m = 6), or of this node
    #: and the next one (m = 12).
    B: Array
    #: Constants of each contact (N, 4, 9): nominal vector from groove centre to ball centre (two components), its length
    #: and the nominal approach [m], Hertz constant [m/N^(2/3)], 1 if the flank can carry load (else 0), groove radius [m],
    #: signs of the contact direction (two).
    geometry: Array
    #: Nominal interference (N, 2) [m] of each ball with the two pairs of opposite flanks: screw left and nut right, screw
    #: right and nut left.
    interference: Array
    #: Radii of the balls (N,) [m].
    r_ball: Array
    #: Profile errors of the flanks (4, p) [m]: p coefficients of a polynomial of the contact angle, ascending powers.
    profile: Array
    #: Force [N] below which a contact counts as unloaded.
    unloaded_force_limit: float


class MotionState(NamedTuple):
    """State of the Newton iteration whose unknowns are the motions of shaft nodes and housings, with balls and contacts.

    Each of the r bodies (shaft nodes, then moving housings) has one row of six motions.
    """

    #: Motions of the bodies (r, 6) [m, rad]: n nodes of the shaft, then the moving housings.
    q: Array
    #: Deformations of the shaft's elements (n - 1, 6) [m, rad].
    d: Array
    #: Displacements of the ball centres in their section planes (N, 2) [m].
    p: Array
    #: Force [N], unit normal (two components), normal and tangential stiffness [N/m] of each contact (N, 4, 5).
    contact: Array
    #: Contact force [N] and stiffness [N/m] of each of the M slices into which the rollers are divided (M, 2).
    slices: Array


class SpecimenArrays(NamedTuple):
    """Arrays of m specimens of one screw with different manufacturing errors; they replace fields of `BeamContacts`."""

    #: Motions of the flanks per unit motion of the nodes (m, N, 2, 2, 6); (1, N, 2, 2, 6) if all specimens share them.
    B: Array
    #: Constants of each contact of m specimens (m, N, 4, 9): nominal vector from groove centre to ball centre (two
    #: components), its length and the nominal approach [m], Hertz constant [m/N^(2/3)], 1 if the flank can carry load (else
    #: 0), groove radius [m], signs of the contact direction (two).
    geometry: Array
    #: Nominal interference (m, N, 2) [m] of each ball with the two pairs of opposite flanks: screw left and nut right,
    #: screw right and nut left.
    interference: Array
    #: Radii of the balls (m, N) [m].
    r_ball: Array


class SpecimenSolutions(NamedTuple):
    """Solutions of m specimens of one screw with different manufacturing errors."""

    #: Contact forces (m, N, 4) [N].
    force: Array
    #: How each iteration ended (m,), a number defined in `lowfi.statics.kernel.search`: converged or a kind of failure.
    status: Array
    #: Largest unbalanced force of each specimen, as a fraction of the largest force in the model (m,).
    residual: Array
    #: Motions of the nodes (m, n, 6) [m, rad].
    q: Array
    #: Displacements of the ball centres in their section planes (m, N, 2) [m].
    p: Array


class EnergyDerivatives(NamedTuple):
    """First and second derivatives of the energy of shaft, housings and balls."""

    #: Gradient of the energy by the motions of the bodies (r, 6) [N, N m].
    gradient: Array
    #: Second derivatives of each ball's energy by the motions of its flanks [N/m]: (N, 4, 4) for the screw's flanks only,
    #: or (N, 8, 8) for all four flanks.
    ball_hessians: Array


class MotionWorkspace(NamedTuple):
    """Work arrays of the Newton iteration whose unknowns are the motions of shaft nodes and housings."""

    #: Derivatives of the energy of shaft, housings and balls.
    derivatives: EnergyDerivatives
    #: Stiffness matrix of shaft and springs without contacts, stored as lower band or envelope.
    base: Array
    #: Factor of the stiffness matrix of shaft, springs and contacts, stored as lower band or envelope.
    matrix: Array
    #: Newton step: change of the motions (r, 6) [m, rad] of shaft nodes and housings.
    step: Array
    #: Motions of shaft nodes and housings (r, 6) [m, rad] before the Newton step.
    q0: Array
    #: Deformations of the shaft's beam elements (n - 1, 6) [m, rad] before the Newton step.
    d0: Array


class NewtonOptions(NamedTuple):
    """Parameters of the Newton iteration in `lowfi.statics.kernel.descent`: tolerance, limits and typical values."""

    #: Largest unbalanced force, as a fraction of the largest force in the model, at which the iteration ends.
    tolerance: float
    #: Largest number of iterations.
    max_iterations: int
    #: Stiffness of a typical contact [N/m], by which the stiffness added to the diagonal is scaled.
    stiffness: float
    #: Length [m] by which moments are divided where they are compared with forces.
    moment_arm: float
    #: Motion [m] above which a body counts as not restrained.
    unrestrained_motion_limit: float
    #: Lower bound of the force [N] by which unbalanced forces are divided.
    least_force_scale: float
    #: Largest motion of a flank in one step [m]: the largest ball's radius.
    max_flank_step: float


class BeamSystem(NamedTuple):
    """Arrays of a screw as a beam and of its balls."""

    #: The screw as a beam, with supports and loads.
    shaft: BeamArrays
    #: Balls between screw and nut.
    contacts: BeamContacts


class AxisArrays(NamedTuple):
    """Arrays of a shaft, moving housings, springs between them, and loads.

    Each of the r bodies has one row of six motions: first the n nodes of the shaft, then the housings.
    """

    #: Lengths (n - 1,) of the shaft's elements [m].
    lengths: Array
    #: Section stiffnesses EA [N], EI [N m^2], GJ [N m^2], kGA [N] of the shaft's elements (n - 1, 4).
    sections: Array
    #: Stiffness constants (n - 1, 5) of the shaft's beam elements: lateral, coupling, bending, axial and torsional, see
    #: `lowfi.statics.kernel.beam.element_constants`.
    constants: Array
    #: Whether each degree of freedom of shaft nodes and housings is fixed by a support (r, 6).
    fixed: Array
    #: Loads on shaft nodes and housings (r, 6) [N, N m].
    load: Array
    #: Numbers of the two bodies that each of k springs joins (k, 2), -1 for the fixed frame.
    spring_bodies: Array
    #: Matrices from the motions of the two bodies that a spring joins to the motions of its ends (k, 2, 6, 6). The second
    #: has a negative sign, so that the sum of both end motions is the spring's deformation.
    spring_end_matrices: Array
    #: Stiffness matrices of the springs (k, 6, 6) [N/m, N, N m].
    springs: Array
    #: Position (r,) of each body (shaft node or housing) in the order in which the stiffness matrix is factored.
    body_order: Array
    #: Column (6 r,) of the first stored coefficient in each row of the stiffness matrix, in the order of
    #: ``body_order``.
    first_columns: Array
    #: Offset (6 r + 1,) of each row in the array of stored coefficients: row i, column j is at row_offsets[i] + j; the
    #: last value is the number of coefficients.
    row_offsets: Array


class AxisBalls(NamedTuple):
    """Arrays of the balls of all bearings and nuts of an assembly, whose flanks move with the bodies of an `AxisArrays`."""

    #: Number (N, 4) of the first body (shaft node or housing) that moves each flank; -1 if the flank is fixed.
    first_bodies: Array
    #: Motions of the flanks, with two components in the ball's section plane (radial, and along the helix's binormal), per
    #: unit of the six motions of the body in ``first_bodies`` (m = 6), or of this body and the next one (m = 12):
    #: (N, 4, 2, m).
    B: Array
    #: Prescribed motion of the flanks (N, 4, 2) [m] by axial offsets of nuts and outer rings.
    v0: Array
    #: Constants of each contact (N, 4, 9): nominal vector from groove centre to ball centre (two components), its length
    #: and the nominal approach [m], Hertz constant [m/N^(2/3)], 1 if the flank can carry load (else 0), groove radius [m],
    #: signs of the contact direction (two).
    geometry: Array
    #: Nominal interference (N, 2) [m] of each ball with the two pairs of opposite flanks: screw left and nut right, screw
    #: right and nut left.
    interference: Array
    #: Radii of the balls (N,) [m].
    r_ball: Array
    #: Profile errors of the flanks (N, 4, p) [m]: p coefficients of a polynomial of the contact angle, ascending powers.
    profile: Array
    #: Force [N] below which a contact counts as unloaded.
    unloaded_force_limit: float


class AxisRollers(NamedTuple):
    """Arrays of the M slices into which the rollers of all bearings are divided across their axes.

    The line contacts of a slice with both raceways are in series. The approach of the raceways at a slice is B q - gap,
    with the motions q of the bodies that carry the rings and the coefficients B. The slice's force per width, p, follows
    from approach = p (g - S ln p) with constants g and S of roller and raceways, see `lowfi.rollers.LineContactLaw`.
    """

    #: Numbers (M, 2) of the bodies (shaft node or housing) that carry inner and outer ring; -1 if the ring is fixed.
    ring_bodies: Array
    #: Approach of the raceways at each slice per unit motion of the bodies that carry inner and outer ring (M, 2, 6).
    B: Array
    #: Gap (M,) [m] between roller slice and raceways by crowning and by the ring's axial offset, without motions of the
    #: rings.
    gap: Array
    #: Widths of the slices (M,) [m].
    width: Array
    #: Constants g (M,) [m^2/N] of the force law approach = p (g - S ln p), with the force per width p.
    g: Array
    #: Constants S (M,) [m^2/N] of the force law approach = p (g - S ln p), with the force per width p.
    s: Array


class IterationProgress(NamedTuple):
    """Progress of a Newton iteration (smallest residual, lowest energy), by which a stalled iteration is recognised."""

    #: Smallest residual so far: largest unbalanced force as a fraction of the largest force in the model.
    smallest_residual: float
    #: Lowest energy so far [J].
    lowest_energy: float
    #: Number of iterations since residual or energy last decreased.
    stalled_iterations: int
    #: Number of line searches that ended because they had tried the largest number of step lengths.
    exhausted_searches: int


class AxisSystem(NamedTuple):
    """Arrays of a shaft with housings and springs, and of the balls and rollers of all its bearings and nuts."""

    #: Shaft, moving housings and springs.
    shaft: AxisArrays
    #: Balls of all bearings and nuts.
    balls: AxisBalls
    #: Roller slices of all roller bearings.
    rollers: AxisRollers


#: Arrays of a static problem whose unknowns are the motions of shaft nodes and housings.
Rows = BeamSystem | AxisSystem


class ElasticBodies(NamedTuple):
    """Compliance of the elastic bodies (screw and nut) at the flanks under all balls, and motions of these flanks.

    The flanks move by v = v0 + G phi + R a, under the forces phi on the flanks and with the amplitudes a of the free rigid
    motions of the bodies, which nothing but the contacts resists.
    """

    #: Compliance matrix G [m/N] of the flanks of the screw (4 N, 4 N), or of screw and nut together for one diagonal pair
    #: of flanks (2 N, 2 N).
    first_compliance: Array
    #: Compliance matrix G [m/N] of the flanks of the nut (4 N, 4 N); empty if ``first_compliance`` contains both.
    second_compliance: Array
    #: Motions of the flanks at each ball or roller per metre of each of k free rigid motions: (N, 8, k) for four flanks,
    #: (N, 2, k) for one flank pair. A rotation's amplitude is its angle times a length.
    R: Array
    #: Motions v0 of the flanks by external loads and prescribed displacements [m]: (N, 8), two components for each of the
    #: four flanks of a ball or roller, or (N, 2), two components for one pair of opposite flanks.
    v0: Array
    #: Work of the external loads on the free rigid motions, per metre of amplitude (k,) [N].
    work_on_free_motions: Array


class RollerContacts(NamedTuple):
    """Arrays of M rollers between rigid rings on an elastic shaft; at most K slices each.

    The force per width of a slice, p, follows from the approach of the raceways: approach = p (g - S ln p) with constants g
    and S of roller and raceways, see `lowfi.rollers.LineContactLaw`.
    """

    #: Positions (M, K) of the slices along the roller, divided by the roller's length.
    slice_positions: Array
    #: Widths of the slices (M, K) [m], 0 for unused slices.
    width: Array
    #: Gap (M, K) [m] between roller slice and raceways by crowning and by the ring's axial offset, without ring motions.
    gap: Array
    #: Constants g (M,) [m^2/N] of the force law approach = p (g - S ln p), with the force per width p.
    g: Array
    #: Constants S (M,) [m^2/N] of the force law approach = p (g - S ln p), with the force per width p.
    s: Array


class BallContacts(NamedTuple):
    """Contact data of the balls between elastic bodies, and of the rollers, which follow the balls in joint arrays."""

    #: Constants of each contact (N, 4, 9): nominal vector from groove centre to ball centre (two components), its length
    #: and the nominal approach [m], Hertz constant [m/N^(2/3)], 1 if the flank can carry load (else 0), groove radius [m],
    #: signs of the contact direction (two).
    geometry: Array
    #: Nominal interference (N, 2) [m] of each ball with the two pairs of opposite flanks: screw left and nut right, screw
    #: right and nut left.
    interference: Array
    #: Coefficients of the terms that are added to Hertz's approach of each contact (N, 4, 3): e [m/N] of the term e F at
    #: the force F; decrease of the approach per unit amplitude of the ball's deformation; h [m/N^(4/3)] of h F^(4/3).
    compliance_terms: Array
    #: Radii of the balls (N,) [m].
    r_ball: Array
    #: Profile errors of the flanks (N, 4, p) [m]: p coefficients of a polynomial of the contact angle, ascending powers.
    profile: Array
    #: Contact data (N, 7) of balls between one diagonal pair of circular flanks: vector from one groove centre to the other
    #: (two components), its length and the interference [m], coefficients C, e, h of approach = C F^(2/3) + e F + h F^(4/3)
    #: at the force F. Zeros if balls are solved between four flanks instead.
    flank_pair_data: Array
    #: Data of the rollers; in arrays over all rolling elements they come after the balls.
    rollers: RollerContacts
    #: Force [N] below which a contact counts as unloaded.
    unloaded_force_limit: float


#: Field ``compliance_terms`` for a ball that is rigid apart from its Hertz contacts (array ``local`` in `kernel.ball`).
RIGID = np.zeros((0, 3))
#: Contact data without rollers.
NO_ROLLERS = RollerContacts(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), np.zeros(0))


class ForceState(NamedTuple):
    """State of the Newton iteration whose unknowns are the contact forces on elastic bodies.

    Further unknowns are the free rigid motions of the bodies, which only the contacts resist. Ball centres and contacts
    follow from the unknowns.
    """

    #: Forces on the flanks [N]: (N, 8), two components for each of the four flanks of a ball or roller, or (N, 2), two
    #: components for one pair of opposite flanks.
    phi: Array
    #: Amplitudes of the bodies' free rigid motions, which only the contacts resist (k,) [m].
    a: Array
    #: Displacement of each ball's centre in its section plane (two components [m]) and amplitude of the ball's deformation
    #: (N, 3).
    ball_unknowns: Array
    #: Force [N], unit normal (two components), normal and tangential stiffness [N/m] of each contact (N, 4, 5), or of the
    #: single contact that stands for a diagonal pair of flanks (N, 1, 5).
    contact: Array


class ForceStep(NamedTuple):
    """Step of Newton's method for the contact forces on elastic bodies, and the motions of the flanks in this step."""

    #: Change of the forces on the flanks in the step [N]: (N, 8), two components for each of the four flanks of a ball or
    #: roller, or (N, 2), two components for one pair of opposite flanks.
    dphi: Array
    #: Change of the motions of the flanks in the step [m]: (N, 8), two components for each of the four flanks of a ball or
    #: roller, or (N, 2), two components for one pair of opposite flanks.
    dv: Array
    #: Change of the amplitudes of the bodies' k free rigid motions in the step (k,) [m].
    da: Array


class LineSearchStart(NamedTuple):
    """Contact forces and flank motions from which a line search along a Newton step starts."""

    #: Forces on the flanks [N]: (N, 8), two components for each of the four flanks of a ball or roller, or (N, 2), two
    #: components for one pair of opposite flanks.
    phi: Array
    #: Amplitudes of the bodies' free rigid motions (k,) [m].
    a: Array
    #: Elastic motions G phi of the flanks [m], with the bodies' compliance G and the forces phi on the flanks: (N, 8), two
    #: components for each of the four flanks of a ball or roller, or (N, 2), two components for one pair of opposite
    #: flanks.
    g: Array
    #: Total motions of the flanks [m] by elastic deformation, external loads and free rigid motions: (N, 8), two components
    #: for each of the four flanks of a ball or roller, or (N, 2), two components for one pair of opposite flanks.
    v: Array


class StiffnessFactors(NamedTuple):
    """Factors S of the tangent stiffness S^T S [N/m] of balls and rollers against motions of their flanks or rings."""

    #: Factor S of the tangent stiffness S^T S of each ball or roller [(N/m)^(1/2)]: a matrix of at most six rows, with a
    #: column for each of the d motions of its flanks (N, 6 or 2, d).
    S: Array
    #: Number of rows of S that are not empty, for each ball or roller (N,).
    counts: Array
    #: Number (N,) of the first row of each ball or roller if the rows of all S that are not empty are numbered
    #: consecutively.
    starts: Array


class BodySystem(NamedTuple):
    """Arrays of elastic bodies with all balls and rollers."""

    #: Compliance of the bodies at the flanks, and motions of the flanks by loads and free rigid motions.
    bodies: ElasticBodies
    #: Contact data of all balls and rollers.
    contacts: BallContacts
    #: Linear springs between opposite flanks, which replace the contacts in the first solve: for each of w springs of a
    #: ball, the square root of its stiffness times its direction in the d flank motions (N, w, d) [(N/m)^(1/2)]; zero where
    #: there is no spring.
    springs: Array


class BodyWorkspace(NamedTuple):
    """Work arrays of the Newton iteration whose unknowns are the contact forces on elastic bodies."""

    #: Forces [N] that balls and rollers exert on the flanks at the present flank motions: (N, 8), two components for each
    #: of the four flanks of a ball or roller, or (N, 2), two components for one pair of opposite flanks.
    f: Array
    #: Elastic motions G phi of the flanks [m], with the bodies' compliance G and the forces phi on the flanks: (N, 8), two
    #: components for each of the four flanks of a ball or roller, or (N, 2), two components for one pair of opposite
    #: flanks.
    g: Array
    #: Total motions of the flanks [m] by elastic deformation, external loads and free rigid motions: (N, 8), two components
    #: for each of the four flanks of a ball or roller, or (N, 2), two components for one pair of opposite flanks.
    v: Array
    #: Newton step of contact forces, flank motions and free rigid motions.
    step: ForceStep
    #: Contact forces and flank motions from which the line search starts.
    search_start: LineSearchStart
    #: Factors S of the tangent stiffness S^T S of balls and rollers.
    stiffness_factors: StiffnessFactors


class LineSearchTrial(NamedTuple):
    """Next step length to try in a line search, with the bounds from earlier trials; see `lowfi.statics.kernel.search`."""

    #: Energy at the start of the search [J].
    energy: float
    #: Derivative of the energy by the step length at the start of the search [J].
    start_slope: float
    #: Largest step length allowed, as a fraction of the Newton step.
    max_step: float
    #: Largest step length known to be too short.
    too_short: float
    #: Smallest step length known to be too long; zero: none yet.
    too_long: float
    #: Step length to try next, as a fraction of the Newton step.
    t: float
    #: Number of step lengths tried so far.
    trial_count: int


class Outcome(NamedTuple):
    """Result of a kernel's Newton iteration: how it ended, effort, residual, energy and largest force."""

    #: How the iteration ended, a number defined in ``lowfi.statics.kernel.search``: converged, too many iterations, a body
    #: moved without limit, or singular stiffness.
    status: int
    #: Number of iterations.
    iterations: int
    #: Number of evaluations of the energy.
    evaluations: int
    #: Largest unbalanced force, as a fraction of the force in the field ``scale``.
    residual: float
    #: Energy of the model at the end [J].
    energy: float
    #: Force by which the residual was divided [N]: the largest force in the model, or a lower limit if that is larger.
    scale: float
