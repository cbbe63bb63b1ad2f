"""Contact on a grid of rectangular cells: positions, normal forces, and displacements under tangential forces.

Local axes: x against the flow of material through the contact (the leading edge is at largest x), y across, and the
normal from body 1 (the ball) into body 2 (the groove). A patch of n cells has tangential unknowns (n, 2) along x and y,
as vectors of length 2 n with all x first. Forces are those on body 1.

The contribution of finite bodies is a smooth polynomial kernel. The displacement at x by a force at x' on a finite body is
the half-space's, singular at x = x', plus a part that varies slowly over a contact,

    G(x, x') = G_half(x, x') + Phi(x) M Phi(x')^T,

Phi the monomials of x and y for each of the three directions. Rows: displacement of the ball past the groove along x and
y, and the separation along the normal; columns: forces on the ball along x and y, and normal force, as in
`hifi.rolling.patch.displacement_by_rectangle`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.meshes.arrays import Array, Index


def monomial_exponents(degree: int) -> Array:
    """List the exponents of x and y in all monomials x^i y^j up to a degree.

    Parameters
    ----------
    degree : int
        Largest degree.

    Returns
    -------
    (k, 2) Array
        Powers of x and of y in each of the k monomials.

    Examples
    --------
    >>> monomial_exponents(1).tolist()
    [[0, 0], [1, 0], [0, 1]]
    """
    return np.array([(i, n - i) for n in range(degree + 1) for i in range(n, -1, -1)])


def monomial_values(at: Array, scale: tuple[float, float], degree: int) -> Array:
    """Evaluate all monomials x^i y^j up to a degree at given points.

    Parameters
    ----------
    at : (n, 2) Array
        Coordinates x, y of n points [m].
    scale : tuple[float, float]
        Lengths by which the coordinates are divided [m].
    degree : int
        Largest degree.

    Returns
    -------
    (n, k) Array
        Values of the k monomials.
    """
    unit = at / np.array(scale)
    return np.asarray(np.prod(unit[:, None] ** monomial_exponents(degree), axis=2))


@dataclass(frozen=True, eq=False)
class ComplianceKernel:
    """Contact compliance of finite bodies less that of half-spaces, as polynomials in coordinates on the contact zone.

    The coordinates are those of the loaded point and of the point whose displacement is computed.
    """

    #: Coefficients M of the kernel between k monomials ``(3 k, 3 k)`` [m/N]: k for the direction x, then k for y, then k
    #: for the normal.
    M: Array
    #: Lengths by which x and y are divided in the monomials of the kernel [m].
    coordinate_scales: tuple[float, float]
    #: Degree of the monomials x^i y^j of the kernel.
    degree: int

    def __add__(self, other: ComplianceKernel) -> ComplianceKernel:
        """Add the kernels of two bodies. Raises ValueError if their monomials differ."""
        if (self.coordinate_scales, self.degree) != (other.coordinate_scales, other.degree):
            raise ValueError(
                "the compliance kernels of two bodies cannot be added, because they differ in the degree or the scale of "
                "their polynomials: compute both for the same contact zone and degree"
            )
        return replace(self, M=self.M + other.M)

    @cached_property
    def rotated_by_half_turn(self) -> ComplianceKernel:
        """The same kernel in axes that are turned by 180 degrees about the contact normal."""
        odd = (-1.0) ** monomial_exponents(self.degree).sum(axis=1)
        signs = np.concatenate([-odd, -odd, odd])
        return replace(self, M=self.M * np.outer(signs, signs))

    @cached_property
    def symmetric_in_x(self) -> ComplianceKernel:
        """Mean of the kernel and its mirror image x -> -x, for bodies that are symmetric along the rolling direction."""
        odd = (-1.0) ** monomial_exponents(self.degree)[:, 0]
        signs = np.concatenate([-odd, odd, odd])
        return replace(self, M=0.5 * (self.M + self.M * np.outer(signs, signs)))

    def _evaluate(self, to: Array, by: Array, rows: slice, columns: slice) -> Array:
        """Evaluate the kernel for given values of the monomials where displacements are taken, and where forces act.

        ``to``, ``by``: values of the k monomials at n points (n, k); ``rows``, ``columns``: the r directions of the
        displacements and the c directions of the forces (`TANGENTS`, `NORMAL`). The result is ``(r n, c n)``.
        """
        k = len(self.M) // 3
        block = self.M[rows.start * k : rows.stop * k, columns.start * k : columns.stop * k]
        left, right = (np.kron(np.eye(x.stop - x.start), at) for x, at in ((rows, to), (columns, by)))
        return np.asarray(left @ block @ right.T)

    def displacements_by_unit_forces(self, at: Array, rows: slice, columns: slice, shift: float = 0.0) -> Array:
        """Compute the displacements that the kernel gives at n points by unit forces at these points.

        Parameters
        ----------
        at : (n, 2) Array
            Coordinates x, y of the forces [m].
        rows, columns : slice
            The r directions of the displacements and the c directions of the forces (`TANGENTS`, `NORMAL`).
        shift : float, default 0.0
            Distance along x from each force's point to the point where its displacement is taken [m].

        Returns
        -------
        (r n, c n) Array
            Displacements per unit of force [m/N]; rows and columns are n for the first direction, then n for the second.
        """
        to = monomial_values(at + np.array([shift, 0.0]), self.coordinate_scales, self.degree)
        return self._evaluate(to, monomial_values(at, self.coordinate_scales, self.degree), rows, columns)

    def displacement_slopes(self, at: Array, rows: slice, columns: slice) -> Array:
        """Compute the derivatives along x of the displacements that the kernel gives by unit forces ``(r n, c n)`` [1/N].

        ``at``: points of forces and displacements (n, 2) [m]; ``rows``, ``columns``: the r directions of the displacements
        and the c directions of the forces (`TANGENTS`, `NORMAL`). Rows and columns are n for each direction in turn.
        """
        powers = monomial_exponents(self.degree)
        lower = np.maximum(powers - np.array([1, 0]), 0)
        unit = at / np.array(self.coordinate_scales)
        to = powers[:, 0] / self.coordinate_scales[0] * np.prod(unit[:, None] ** lower, axis=2)
        return self._evaluate(to, monomial_values(at, self.coordinate_scales, self.degree), rows, columns)


#: Directions of a kernel: along tangents, and the normal.
TANGENTS, NORMAL = slice(0, 2), slice(2, 3)

#: Ratio of the width of a grid to the width of Hertz's ellipse.
MARGIN = 1.08

#: Step of the differences along the flow, in cells; with a step of a whole cell the differences are less exact, because all
#: points then lie at the same position within their cells.
STEP = 0.5

#: Points along each axis of Hertz's ellipse at which the displacement of finite bodies is evaluated.
POINTS = 12

#: Largest number of changes of the active set.
MOST = 100


# --- half spaces


def _double_integral_over_rectangle(corner: Array) -> Array:
    """Compute a double integral over a rectangle from the antiderivative's values at the rectangle's corners.

    ``corner``: these values (2, 2, ...), those at the upper limits of x and y first. The sum
    is ordered so that points on opposite sides of the rectangle have the same value to the last digit.
    """
    return np.asarray((corner[0, 0] + corner[1, 1]) - (corner[0, 1] + corner[1, 0]))


def _corner_coordinates(x: Array, y: Array, dx: float, dy: float) -> tuple[Array, Array]:
    """Return the coordinates x and y ``(2, 2, ...)`` [m] of points relative to the corners of a rectangle.

    ``x``, ``y``: coordinates of the points [m]; ``dx``, ``dy``: sides of the rectangle, centred at the
    origin [m].
    """
    ends = np.array([0.5, -0.5])
    X = np.broadcast_to(x + dx * ends.reshape(2, 1, *([1] * np.ndim(x))), (2, 2, *np.shape(x)))
    Y = np.broadcast_to(y + dy * ends.reshape(1, 2, *([1] * np.ndim(y))), (2, 2, *np.shape(y)))
    return X, Y


def _log_term_without_cancellation(x: Array, y: Array) -> Array:
    """Evaluate x arsinh(y/abs(x)), which equals x ln(y + R) with R^2 = x^2 + y^2 up to a function of x only.

    Evaluated as here, there is no cancellation for y < 0. The value at x = 0 is the limit 0.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(x == 0.0, 0.0, x * np.arcsinh(y / np.abs(x)))


def displacement_by_rectangle(x: Array, y: Array, dx: float, dy: float, young: float, poisson: float) -> Array:
    """Compute the relative displacement of two half-spaces of one material under unit tractions on a rectangle.

    Boussinesq's and Cerruti's point forces are integrated exactly. As both bodies are of one material, normal tractions
    separate the surfaces along the normal only, and tangential ones displace them along tangents only.

    Parameters
    ----------
    x, y : Array
        Coordinates of the points at which the displacement is computed [m]; the rectangle lies about the origin.
    dx, dy : float
        Sides of the rectangle [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (..., 3, 3) Array
        Relative displacement per unit of traction [m/Pa]; rows: displacement of body 1 past body 2 along x, y, and the
        separation along the normal; columns: traction on body 1 along x, y, and pressure.

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (3.22), (3.75) and (3.77).

    Examples
    --------
    >>> square = displacement_by_rectangle(np.array(0.0), np.array(0.0), 2e-4, 2e-4, 210e9, 0.3)[2, 2]
    >>> f"{square * 210e9 / (2.0 * (1.0 - 0.3**2)) / 1e-4:.4f}"  # 8 ln(1 + sqrt 2) / pi
    '2.2444'
    """
    X, Y = _corner_coordinates(x, y, dx, dy)
    R = np.hypot(X, Y)
    over, shear = _double_integral_over_rectangle, 0.5 * young / (1.0 + poisson)
    along_x = over(_log_term_without_cancellation(Y, X))  # double integral of X^2/R^3
    along_y = over(_log_term_without_cancellation(X, Y))  # double integral of Y^2/R^3
    upright, aslant = (1.0 - poisson) / (np.pi * shear), poisson / (np.pi * shear)
    inverse = along_x + along_y
    out = np.zeros((*np.shape(x), 3, 3))
    out[..., 0, 0] = upright * inverse + aslant * along_x  # Cerruti, Johnson's eq. (3.75)
    out[..., 1, 1] = upright * inverse + aslant * along_y
    out[..., 0, 1] = out[..., 1, 0] = aslant * over(-R)
    out[..., 2, 2] = upright * inverse  # Boussinesq, Johnson's eq. (3.22)
    return out


def _tabulate_half_space_influence(
    cells: Index, size: Array, material: tuple[float, float], directions: slice, shift: float = 0.0
) -> Array:
    """Tabulate the relative displacements of two half-spaces at all cells of a grid by unit forces on one cell.

    ``cells``: columns and rows of the cells (n, 2); ``size``: sides of a cell (2,) [m]; ``material``: Young's modulus [Pa]
    and Poisson's ratio; ``directions``: the k directions of displacements and forces; ``shift``: distance upstream of the
    cells' centres at which displacements are taken [m]. The result is ``(2 w - 1, 2 h - 1, k, k)`` [m/N] for all offsets in
    a grid of w by h cells. Each force is uniform over its cell.
    """
    span = np.ptp(cells, axis=0)
    dx, dy = size
    x, y = np.meshgrid(np.arange(-span[0], span[0] + 1) * dx + shift, np.arange(-span[1], span[1] + 1) * dy, indexing="ij")
    return np.asarray(displacement_by_rectangle(x, y, dx, dy, *material)[..., directions, directions] / (dx * dy))


def _expand_influence_table(cells: Index, table: Array) -> Array:
    """Expand a table of displacements by cell offset to the compliance matrix between n cells ``(k n, k n)``.

    ``cells``: columns and rows of the cells (n, 2); ``table``: values at all offsets for k directions, as from
    `_tabulate_half_space_influence`. The matrix has n rows and columns for the first direction, then n for the second.
    """
    span, n, k = np.ptp(cells, axis=0), len(cells), table.shape[-1]
    line = cells @ (2 * span[1] + 1, 1)
    apart = line[:, None] - line + ((2 * span[1] + 1) * span[0] + span[1])
    out = np.empty((k, n, k, n))
    for a, b in np.ndindex(k, k):
        out[a, :, b] = table[..., a, b].ravel()[apart]
    return out.reshape(k * n, k * n)


def solve_normal_contact(
    cells: Index, size: Array, gap: Array, load: float, material: tuple[float, float], added_compliance: Array | None = None
) -> tuple[Array, float]:
    """Solve the frictionless normal contact of two bodies on a grid of cells by an active-set method.

    Open cells carry exactly zero force.

    Parameters
    ----------
    cells : (n, 2) Index
        Columns and rows of the cells on the grid.
    size : (2,) Array
        Sides of a cell along x and y [m].
    gap : (n,) Array
        Gap of the undeformed bodies [m].
    load : float
        Normal load [N].
    material : tuple[float, float]
        Young's modulus [Pa] and Poisson's ratio of both bodies.
    added_compliance : (n, n) Array, optional, default None
        Compliance of finite bodies along the normal, in addition to that of half-spaces [m/N]; None: half-spaces.

    Returns
    -------
    forces : (n,) Array
        Normal forces [N], >= 0, of sum ``load``.
    approach : float
        Approach of the bodies, which closes the gap where the forces act [m].

    Raises
    ------
    ValueError
        The set of cells in contact does not converge.
    """
    C = _expand_influence_table(cells, _tabulate_half_space_influence(cells, size, material, NORMAL))
    if added_compliance is not None:
        C = C + added_compliance
    active = gap <= np.quantile(gap, 0.5)
    for _ in range(MOST):
        i = np.flatnonzero(active)
        K = np.ones((i.size + 1, i.size + 1))
        K[:-1, :-1], K[:-1, -1], K[-1, -1] = C[np.ix_(i, i)], -1.0, 0.0
        solved = np.linalg.solve(K, np.append(-gap[i], load))
        forces, approach = np.zeros(gap.size), float(solved[-1])
        forces[i] = solved[:-1]
        overlap = approach - gap - C @ forces
        closed = np.where(active, forces > 0.0, overlap > 0.0)
        if np.array_equal(closed, active):
            return forces, approach
        active = closed
    raise ValueError(
        f"normal contact on a grid of cells: the set of cells in contact still changes after {MOST} iterations; change the "
        "load or the number of cells"
    )


# --- a contact


@dataclass(frozen=True)
class GridContact:
    """Solved normal contact of two bodies on a grid of n cells, with the data for its tangential compliance."""

    #: Column and row of each cell on its grid ``(n, 2)``.
    cell_indices: Index
    #: Centres x, y of the cells ``(n, 2)`` [m].
    cell_centres: Array
    #: Sides of a cell along x and y ``(2,)`` [m].
    cell_size: Array
    #: Normal force of each cell ``(n,)`` [N].
    normal_forces: Array
    #: Young's modulus [Pa] and Poisson's ratio of both bodies.
    elastic_constants: tuple[float, float]
    #: Approach of the two bodies [m].
    approach: float
    #: Contact compliance of the finite bodies less that of half-spaces; None: the bodies are half-spaces.
    finite_body_kernel: ComplianceKernel | None = None

    @property
    def normal_load(self) -> float:
        """Normal force of the contact, the sum over its cells [N]."""
        return float(self.normal_forces.sum())

    def _tabulate_tangential_influence(self, shift: float) -> Array:
        """Tabulate half-spaces' tangential displacements, ``shift`` [m] upstream of cells, by unit forces on one cell."""
        return _tabulate_half_space_influence(self.cell_indices, self.cell_size, self.elastic_constants, TANGENTS, shift)

    def tangential_compliance(self, shift: float = 0.0) -> Array:
        """Compute the tangential compliance between the cells: relative displacement by unit forces, uniform over a cell.

        Parameters
        ----------
        shift : float, default 0.0
            Distance upstream of the cells' centres at which displacements are taken [m].

        Returns
        -------
        (2 n, 2 n) Array
            Displacement of body 1 past body 2 by unit forces [m/N], n rows and columns along x, then n along y.
        """
        half_space = _expand_influence_table(self.cell_indices, self._tabulate_tangential_influence(shift))
        kernel, at = self.finite_body_kernel, self.cell_centres
        if kernel is None:
            return half_space
        return half_space + kernel.displacements_by_unit_forces(at, TANGENTS, TANGENTS, shift)

    @property
    def tangential_displacement_rate(self) -> Array:
        """Tangential slip of the cells by normal forces, per length of rolling ``(2 n,)`` [m/m], all x and then all y.

        The slip is zero for half-spaces of the same material.
        """
        kernel, at = self.finite_body_kernel, self.cell_centres
        if kernel is None:
            return np.zeros(2 * len(at))
        return np.asarray(-kernel.displacement_slopes(at, TANGENTS, NORMAL) @ self.normal_forces)

    @property
    def depth_of_contact_centre(self) -> float:
        """Depth of the contact's centre below the surface of the undeformed ball [m]: half of the approach.

        If the bodies are half-spaces, the depth is 0, so that the ball rolls with its own radius.
        """
        return 0.0 if self.finite_body_kernel is None else 0.5 * self.approach

    @cached_property
    def elastic_slip_per_rolling_length(self) -> Array:
        """Elastic slip per length of rolling by unit tangential forces on the cells, all x then all y ``(2 n, 2 n)`` [1/N].

        The slip is the change of the displacement along the flow of material through the contact, by a backward difference
        of second order with steps of `STEP` cells. Displacements are known everywhere, so that nothing is interpolated. The
        symmetric part of the matrix is positive: the differences dissipate work.
        """
        step = STEP * float(self.cell_size[0])
        tables = [self._tabulate_tangential_influence(k * step) for k in range(3)]
        half_space = _expand_influence_table(self.cell_indices, _backward_difference(tables, step))
        kernel, at = self.finite_body_kernel, self.cell_centres
        if kernel is None:
            return half_space
        added = [kernel.displacements_by_unit_forces(at, TANGENTS, TANGENTS, k * step) for k in range(3)]
        return half_space + _backward_difference(added, step)

    def similar_contact(self, length: float, force: float) -> GridContact:
        """Return a geometrically similar contact of half-spaces, whose lengths and normal forces are multiplied by factors.

        Parameters
        ----------
        length : float
            Factor on lengths.
        force : float
            Factor on forces; it is ``length ** 3`` for a similar contact.

        Returns
        -------
        GridContact
            The similar contact.

        Raises
        ------
        ValueError
            The bodies are finite, so that contacts under different forces are not similar.
        """
        if self.finite_body_kernel is not None:
            raise ValueError(
                "a contact of finite bodies cannot be scaled to another force, because their contacts are not similar: "
                "solve it for that force"
            )
        square = length * length
        out = replace(
            self,
            cell_centres=self.cell_centres * length,
            cell_size=self.cell_size * length,
            normal_forces=self.normal_forces * force,
            approach=self.approach * square,
        )
        if "elastic_slip_per_rolling_length" in self.__dict__:  # [1/N]: compliance over length
            out.__dict__["elastic_slip_per_rolling_length"] = self.elastic_slip_per_rolling_length / square
        return out


def _backward_difference(values: list[Array], step: float) -> Array:
    """Compute a derivative along the flow of material by a backward difference of second order.

    ``values``: values at a point, and one and two steps upstream of it; ``step``: length of a step [m].
    """
    current, before, first = values
    return np.asarray((3.0 * current - 4.0 * before + first) / (2.0 * step))


def create_cell_grid(shape: tuple[int, int], size: Array) -> tuple[Index, Array]:
    """Create a rectangular grid of cells about the origin.

    Parameters
    ----------
    shape : tuple[int, int]
        Numbers of cells along x and y.
    size : (2,) Array
        Sides of a cell along x and y [m].

    Returns
    -------
    cells : (n, 2) Index
        Columns and rows of the cells.
    at : (n, 2) Array
        Centres x, y of the cells [m].

    Examples
    --------
    >>> create_cell_grid((2, 1), np.array([1.0, 1.0]))[1].tolist()
    [[-0.5, 0.0], [0.5, 0.0]]
    """
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    cells = np.stack([i.ravel(), j.ravel()], axis=1)
    return cells, (cells + 0.5 - 0.5 * np.array(shape)) * size


def equivalent_half_space_radii(
    load: float, radii: tuple[float, float], young: float, poisson: float, finite_body_kernel: ComplianceKernel | None
) -> tuple[float, float]:
    """Compute relative radii of curvature with which half-spaces have nearly the same contact as finite bodies.

    The radii follow from the curvatures of the displacement that finite bodies add under Hertz's pressure.

    Parameters
    ----------
    load : float
        Normal load [N].
    radii : tuple[float, float]
        Relative radii of the bodies along x and y [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    finite_body_kernel : ComplianceKernel | None
        Kernel of finite bodies: their compliance less that of half-spaces; None: half-spaces.

    Returns
    -------
    tuple[float, float]
        Relative radii of the half-spaces along x and y [m].
    """
    if finite_body_kernel is None:
        return radii
    ellipse = solve_hertz(load, *radii, young, poisson)
    unit = (np.arange(POINTS) + 0.5) / POINTS * 2.0 - 1.0
    at = np.stack(np.meshgrid(unit * ellipse.semi_x, unit * ellipse.semi_y, indexing="ij"), axis=-1).reshape(-1, 2)
    pressure = np.nan_to_num(ellipse.pressure(at[:, 0], at[:, 1]))
    force = load * pressure / pressure.sum()
    added = finite_body_kernel.displacements_by_unit_forces(at, NORMAL, NORMAL) @ force
    weight = np.sqrt(force)
    rows = np.column_stack([np.ones(len(at)), at, 0.5 * at**2])
    bend = np.linalg.lstsq(rows * weight[:, None], added * weight, rcond=None)[0][-2:]
    one, two = 1.0 / (1.0 / np.array(radii) + bend)
    return float(one), float(two)


def solve_elastic_contact_on_grid(
    load: float,
    relative_radii: tuple[float, float],
    young: float,
    poisson: float,
    shape: tuple[int, int],
    finite_body_kernel: ComplianceKernel | None = None,
    margin: float = MARGIN,
) -> GridContact:
    """Solve the normal contact of two bodies of one material on a grid of cells that covers Hertz's ellipse.

    The pressure solves the contact problem of the grid. Cells that carry no force are left out of the result.

    Parameters
    ----------
    load : float
        Normal load [N].
    relative_radii : tuple[float, float]
        Relative radii along x and y [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    shape : tuple[int, int]
        Numbers of cells along x and y.
    finite_body_kernel : ComplianceKernel | None, default None
        Kernel of finite bodies: their compliance less that of half-spaces; None: half-spaces. Only
        `GridContact.tangential_displacement_rate` contains the tangential displacement that their pressure causes.
    margin : float, default MARGIN
        Ratio of the width of the grid to the width of Hertz's ellipse.

    Returns
    -------
    GridContact
        The contact.

    Raises
    ------
    ValueError
        Load, radii or material are not those of a Hertzian contact, or the set of closed cells does not converge.
    """
    radii = equivalent_half_space_radii(load, relative_radii, young, poisson, finite_body_kernel)
    ellipse = solve_hertz(load, *radii, young, poisson)
    size = 2.0 * margin * np.array([ellipse.semi_x, ellipse.semi_y]) / np.array(shape)
    cells, at = create_cell_grid(shape, size)
    gap = 0.5 * (at[:, 0] ** 2 / relative_radii[0] + at[:, 1] ** 2 / relative_radii[1])
    extra = None if finite_body_kernel is None else finite_body_kernel.displacements_by_unit_forces(at, NORMAL, NORMAL)
    forces, approach = solve_normal_contact(cells, size, gap, load, (young, poisson), extra)
    inside = forces > 0.0
    return GridContact(cells[inside], at[inside], size, forces[inside], (young, poisson), approach, finite_body_kernel)
