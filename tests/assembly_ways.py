"""What the assembly of `hifi.elements.forms` and its `CurvedMap` buy today: the same stiffness by scikit-fem's own
means, timed.

The meshes are of the kinds and sizes of level 1: hexahedra of a patch, tetrahedra of a body, all curved.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement
from statistics import median
from time import process_time

import numpy as np
import scipy.sparse as sp
from skfem import Basis, BilinearForm, ElementVector, Mesh, MeshTet1

from rollbench.hifi.elements.forms import CurvedMap, assemble, cells, elasticity, rule
from rollbench.meshes.arrays import Array
from rollbench.meshes.fem import mesh_of, moved, points_of, second_order, tensor_grid

YOUNG, POISSON = 210e9, 0.3
#: Runs whose median is told.
REPEATS = 3
#: Ways to the same matrix, by what they are called in the report.
OURS, OWN_MAP, SIX, VECTOR = "ours", "ours, scikit-fem's map", "six scalar forms", "one vector form"


@dataclass(frozen=True)
class AssemblyCost:
    """CPU seconds of one way to assemble the stiffness of a mesh, and its largest difference from this project's matrix,
    over the largest entry."""

    mesh: str
    cells: int
    way: str
    seconds: float
    difference: float


def bent(points: Array) -> Array:
    """Points of a unit cube on a piece of a thick helix: no face stays plane, no entry vanishes."""
    r, phi = 1.0 + 0.3 * points[:, 0] + 0.05 * points[:, 2] ** 2, 0.4 * np.pi * points[:, 1] + 0.1 * points[:, 2]
    return np.stack([r * np.cos(phi), r * np.sin(phi), points[:, 2] + 0.2 * phi + 0.1 * points[:, 0]], axis=1)


def meshes(share: float = 1.0) -> dict[str, Mesh]:
    """A patch's and a body's mesh, with so many times the cells along every edge."""
    x, y, z = (np.linspace(0.0, 1.0, 1 + round(share * n)) for n in (12, 8, 12))
    patch = tensor_grid(x, y, z, "Q2")
    edge = np.linspace(0.0, 1.0, 1 + round(share * 14))
    raw = MeshTet1.init_tensor(edge, edge, edge)
    corners = raw.t.T.astype(np.int64)
    a, b, c, d = (raw.p.T[corners[:, k]] for k in range(4))
    turned = np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) < 0.0
    corners[turned] = corners[turned][:, [0, 2, 1, 3]]
    body = second_order(mesh_of(raw.p.T, corners, "P1")[0])
    named = {"27-node hexahedra": patch, "10-node tetrahedra": body}
    return {name: moved(mesh, bent(points_of(mesh))) for name, mesh in named.items()}


def six_forms(mesh: Mesh) -> sp.csc_array:
    """int N_a,i N_b,j by a scalar form for each i <= j, the others by transposition; Hooke's law makes the blocks."""
    V, forms = cells(mesh, mapping=mesh.mapping()), {}
    for i, j in combinations_with_replacement(range(3), 2):
        form = BilinearForm(lambda u, v, _, i=i, j=j: u.grad[j] * v.grad[i])
        forms[i, j] = form.assemble(V).tocsr()
        forms[j, i] = forms[i, j].T.tocsr()  # of the same pattern
    pattern = forms[0, 0]
    G = np.stack([forms[i, j].data for i in range(3) for j in range(3)], axis=1).reshape(-1, 3, 3)
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    lame = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    blocks = lame * G + shear * G.swapaxes(1, 2) + shear * np.trace(G, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    return sp.bsr_array((blocks, pattern.indices, pattern.indptr), shape=(3 * V.N, 3 * V.N)).tocsc()


def vector_form(mesh: Mesh) -> sp.csc_array:
    """The weak form as it stands, on the vector space."""
    V = Basis(mesh, ElementVector(mesh.elem()), mesh.mapping(), quadrature=rule(mesh))
    return elasticity(YOUNG, POISSON).assemble(V).tocsc()


def with_own_map(mesh: Mesh) -> sp.csc_array:
    """This project's assembly, with scikit-fem's isoparametric map in place of `CurvedMap`."""
    return assemble(elasticity(YOUNG, POISSON), mesh, mesh.mapping())


WAYS: dict[str, Callable[[Mesh], sp.csc_array]] = {
    OURS: lambda mesh: assemble(elasticity(YOUNG, POISSON), mesh, CurvedMap(mesh)),
    OWN_MAP: with_own_map,
    SIX: six_forms,
    VECTOR: vector_form,
}


def assembly_costs(share: float = 1.0, repeats: int = REPEATS) -> list[AssemblyCost]:
    """Every way on every mesh, one after the other in turns; CPU seconds."""
    out = []
    for name, mesh in meshes(share).items():
        ours = WAYS[OURS](mesh)
        spent: dict[str, list[float]] = {way: [] for way in WAYS}
        matrices = {}
        for _ in range(repeats):
            for way, work in WAYS.items():
                fresh = moved(mesh, points_of(mesh))  # scikit-fem keeps a mesh's map
                begin = process_time()
                matrices[way] = work(fresh)
                spent[way].append(process_time() - begin)
        for way, matrix in matrices.items():
            off = float(abs(matrix - ours).max() / abs(ours).max())
            out.append(AssemblyCost(name, mesh.nelements, way, median(spent[way]), off))
    return out
