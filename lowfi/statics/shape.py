"""Shape functions of the Timoshenko beam element (Lin C.1 and C.2; the transpose in Lin's equation 2.20 is corrected)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.arrays import Array
from rollbench.meshes.section import BeamSection


def beam_interpolation_matrices(z: Array, nodes: Array, section: BeamSection) -> tuple[NDArray[np.int64], Array]:
    """Return the matrices that give the shaft's motions at axial positions from the motions of the two adjacent nodes.

    Parameters
    ----------
    z
        Axial positions ``(k,)`` [m]; beyond the nodes the shaft moves as a rigid body.
    nodes
        Axial positions of the nodes ``(n,)`` [m].
    section
        Cross-section of the shaft.

    Returns
    -------
    tuple[NDArray[np.int64], Array]
        Number of the first of the two adjacent nodes for each position ``(k,)``; and matrices ``(k, 6, 12)`` from the
        twelve motions of both nodes to the six motions at the position.
    """
    last = nodes.size - 1
    j = np.clip(np.searchsorted(nodes, z, side="right") - 1, 0, last - 1).astype(np.int64)
    length = nodes[j + 1] - nodes[j]
    xi = (z - nodes[j]) / length
    m = beam_shape_functions(np.clip(xi, 0.0, 1.0), length, section)
    for end, beyond in ((0, xi < 0.0), (1, xi > 1.0)):
        for i in np.flatnonzero(beyond):
            m[i] = 0.0
            m[i, :, 6 * end : 6 * end + 6] = rigid_motion_transfer_matrix(float(z[i] - nodes[j[i] + end]))
    return j, m


def rigid_motion_transfer_matrix(reach: float | Array) -> Array:
    """Return the matrix from a rigid body's six motions at one point of the z axis to those at another point of the axis.

    The displacement u and the rotation theta at the first point give the displacement u + theta x reach e_z at the second.

    Parameters
    ----------
    reach
        Axial distance from the first to the second point [m], any shape.

    Returns
    -------
    Array
        ``(..., 6, 6)`` for ``reach`` of the shape ``(...)``.
    """
    t = np.zeros((*np.shape(reach), 6, 6))
    t[...] = np.eye(6)
    t[..., 0, 4] = reach
    t[..., 1, 3] = -np.asarray(reach)
    return t


def beam_shape_functions(xi: Array, length: Array, section: BeamSection, order: int = 0) -> Array:
    """Return the shape functions of n Timoshenko beam elements, or their derivatives by the relative position xi.

    The functions are exact for an element that is loaded at its nodes only.

    Parameters
    ----------
    xi
        Relative position in the element, 0 to 1 ``(n,)``.
    length
        Lengths of the elements ``(n,)`` [m].
    section
        Cross-section of the shaft.
    order
        Order of the derivative, 0 to 2.

    Returns
    -------
    Array
        Matrices from the motions of both nodes to the motions at xi ``(n, 6, 12)``.

    References
    ----------
    Lin (2019), C.1 and C.2.
    """
    phi = np.asarray(12.0 * section.EI / (section.kGA * length**2))  # ratio of shear to bending deformation
    k = 1.0 / (1.0 + phi)
    ones, zero = np.ones_like(xi), np.zeros_like(xi)
    derivatives = (ones, xi, xi**2, xi**3), (zero, ones, 2.0 * xi, 3.0 * xi**2), (zero, zero, 2.0 * ones, 6.0 * xi)
    powers = derivatives[order]

    def polynomial_at_xi(*coefficients: Array | float) -> Array:
        """Return a polynomial of the relative position xi in the element, or its derivative of ``order``, at xi ``(n,)``.

        ``coefficients``: coefficients of the polynomial, lowest power first.
        """
        return sum((c * p for c, p in zip(coefficients, powers[: len(coefficients)], strict=True)), start=zero)

    n = np.zeros((xi.size, 6, 12))
    u = (
        k * polynomial_at_xi(1.0 + phi, -phi, -3.0, 2.0),
        k * length * polynomial_at_xi(0.0, 1.0 + phi / 2.0, -(2.0 + phi / 2.0), 1.0),
        k * polynomial_at_xi(0.0, phi, 3.0, -2.0),
        k * length * polynomial_at_xi(0.0, -phi / 2.0, -(1.0 - phi / 2.0), 1.0),
    )
    t = (
        6.0 * k / length * polynomial_at_xi(0.0, -1.0, 1.0),
        k * polynomial_at_xi(1.0 + phi, -(4.0 + phi), 3.0),
        -6.0 * k / length * polynomial_at_xi(0.0, -1.0, 1.0),
        k * polynomial_at_xi(0.0, -(2.0 - phi), 3.0),
    )
    for axis, columns, sign in ((0, (0, 4, 6, 10), 1.0), (1, (1, 3, 7, 9), -1.0)):
        rotation = 4 if axis == 0 else 3
        for i, column in enumerate(columns):
            odd = i % 2 == 1
            n[:, axis, column] = u[i] * (sign if odd else 1.0)
            n[:, rotation, column] = t[i] * (1.0 if odd else sign)
    for axis in (2, 5):
        n[:, axis, axis] = polynomial_at_xi(1.0, -1.0)
        n[:, axis, axis + 6] = polynomial_at_xi(0.0, 1.0)
    return n


def right_singular_vectors(matrix: Array) -> tuple[Array, Array]:
    """Return the singular values and all right singular vectors ``(k, k)`` of a matrix ``(m, k)``.

    A QR decomposition comes first, so that the cost does not grow with the square of the number of rows.
    """
    _, size, vt = np.linalg.svd(np.linalg.qr(matrix, mode="r"))
    return np.asarray(size), np.asarray(vt)


def null_space_of_constraints(constraints: Array) -> Array:
    """Return c independent combinations ``(c, k)`` of k motions that satisfy all constraints: the constraints' null space.

    Parameters
    ----------
    constraints
        Constraints ``(m, k)``, each with a norm of about one.
    """
    if not constraints.size:
        return np.eye(constraints.shape[1])
    size, vt = right_singular_vectors(constraints)
    return vt[int((size > 1e-9 * max(1.0, size.max(initial=0.0))).sum()) :]


def independent_columns(matrix: Array) -> list[int]:
    """Return the indices of linearly independent columns of a matrix ``(k, m)``, at most min(k, m) of them.

    A QR decomposition with column pivoting chooses the columns: each is the one with the largest part normal to the columns
    chosen before.
    """
    remainder, chosen = matrix.copy(), []
    for _ in range(min(matrix.shape)):
        sizes = (remainder * remainder).sum(axis=0)
        k = int(sizes.argmax())
        if sizes[k] == 0.0:
            break
        chosen.append(k)
        along = remainder[:, k] / np.sqrt(sizes[k])
        remainder -= np.outer(along, along @ remainder)
        remainder[:, chosen] = 0.0
    return chosen


def thermal_nodal_loads(EA: Array, strain: float) -> Array:
    """Return nodal loads ``(n, 6)`` [N, N m] in place of free thermal expansion: they push the ends of each element apart.

    The section force of an element is its tension by the motions of its nodes less ``EA`` times ``strain``; these loads are
    no forces from outside.

    Parameters
    ----------
    EA
        Tensile stiffness of the n - 1 beam elements [N].
    strain
        Free thermal strain of the shaft.
    """
    out = np.zeros((len(EA) + 1, 6))
    out[:-1, 2] -= strain * EA
    out[1:, 2] += strain * EA
    return out
