"""Contact pressures as hats on half cells, weighed against the displacements that they work on.

The nodes of a 9-node face carry 1 : 4 : 16 of its area, so that nodal forces make the law of a contact wavy. Pressures that
are bilinear between all nodes of the contact's grid, hats phat_k on the faces' halves, give nodal forces f = W^T p and
weighted gaps W g with W_ki = int phat_k N_i dA over the contact zone, N_i the displacements' own traces.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from skfem import ElementHex2, Mesh
from skfem.quadrature import get_quadrature

from rollbench.hifi.elements.assembly import faces, products
from rollbench.hifi.elements.forms import share
from rollbench.meshes.arrays import Array, Index


class ElementHexHats(ElementHex2):  # type: ignore[misc]
    """Hats on the eight halves of a hexahedron, one for each node of ElementHex2: trilinear on every half."""

    maxdeg = 3

    def lbasis(self, X: Array, i: int) -> tuple[Array, Array]:
        """Value and reference gradient of hat i at X."""
        away = np.asarray(X) - self.doflocs[i].reshape((3,) + (1,) * (np.ndim(X) - 1))
        value = np.maximum(1.0 - 2.0 * np.abs(away), 0.0)
        slope = np.where(value > 0.0, -2.0 * np.sign(away), 0.0)
        gradient = [np.prod([slope[k] if k == axis else value[k] for k in range(3)], axis=0) for axis in range(3)]
        return np.prod(value, axis=0), np.array(gradient)


def halves(refdom: Any, degree: int) -> tuple[Array, Array]:
    """Gauss's rule of that degree on each of the four quarters of the unit square."""
    points, weights = get_quadrature(refdom, degree)
    shifts = [(i, j) for i in (0.0, 0.5) for j in (0.0, 0.5)]
    return np.hstack([0.5 * points + np.array(s)[:, None] for s in shifts]), np.tile(0.25 * weights, 4)


def contact_weights(mesh: Mesh, contact: Index) -> sp.csr_array:
    """W ``(c, c)`` [m2] on the boundary "contact" of a patch, rows and columns in the order of its nodes ``contact``.

    W 1 are the areas of the hats, 1^T W those of the displacements' functions, both over the contact zone. 27-node
    hexahedra: hats are bilinear on the halves of faces. First-order tetrahedra, which stand for the source's mesh, keep
    nodal forces: W is diagonal (the hats' consistent mass would make so coarse a contact stiffer still).
    """
    if mesh.elem is not ElementHex2:
        return sp.csr_array(sp.diags_array(share().assemble(faces(mesh, "contact"))[contact]))
    rule = halves(mesh.brefdom, 7)
    u = faces(mesh, "contact", quadrature=rule)
    p = faces(mesh, "contact", element=ElementHexHats(), quadrature=rule, mapping=u.mapping, dofs=u.dofs)
    W = products(u, p)
    return sp.csr_array(W[contact][:, contact])


def mean_weights(weights: sp.csr_array) -> sp.csr_array:
    """Weights with rows of sum one: means over hats instead of integrals."""
    return sp.csr_array(sp.diags_array(1.0 / np.asarray(weights.sum(axis=1)).ravel()) @ weights)
