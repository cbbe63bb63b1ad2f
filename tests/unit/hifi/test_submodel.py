"""A contact's own compliance from a submodel, in a unit cube with a block under its upper face as the patch."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.helpers import relative
from tests.patch_meshes import flat, holed_cube, socket

from rollbench.hifi.bodies import coarse
from rollbench.hifi.bodies.coarse import (
    Piece,
    Socket,
    assemble,
    coarse_compliance,
    contact_pressures,
    fine_compliance,
    freedoms,
    own_compliance,
    patch_modes,
)
from rollbench.hifi.bodies.patch import Lines, build_patch, condense_patch, hat_rows
from rollbench.hifi.elements.forms import mean_weights
from rollbench.hifi.elements.rigid import rigid_modes
from rollbench.meshes.fem import moved, points_of

pytestmark = pytest.mark.xdist_group("submodel")

E, NU = 1.0, 0.3
TURN = np.array([[0.0, 0.8, 0.6], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]])


@cache
def holed(*held):
    """The unit cube without the block; held: boundaries of it."""
    mesh, nodes, _ = holed_cube()
    return Piece(mesh, nodes, np.eye(3), held)


@cache
def patch(cells=4, zone=0.5):
    """Patch of cells x cells / 2 x cells hexahedra, and directions of its forces, not quite upright."""
    line = np.linspace(-1.0, 1.0, cells + 1)
    mesh = build_patch(Lines(line, np.linspace(0.0, 1.0, cells // 2 + 1), line), (zone, zone), flat, socket())
    arms = mesh.points[mesh.contact] - [0.5, 0.4, 0.0]
    return mesh, arms / np.linalg.norm(arms, axis=1)[:, None]


@cache
def condensed():
    return condense_patch(*patch(), E, NU)


def turned(piece):
    """The piece in another frame: its nodes turned, its patch left in its own frame."""
    return replace(piece, mesh=moved(piece.mesh, points_of(piece.mesh) @ TURN.T), rotation=TURN)


@pytest.mark.parametrize("rotated", [False, True])
def test_of_a_held_piece_is_that_of_patch_and_body_condensed(rotated):
    """Same socket, no carrier: C_fine = A + H (K + S)^-1 H^T, dense algebra on the body's freedoms; also in a frame that is
    not the patch's."""
    piece, c = holed("floor"), condensed()
    K = assemble(piece.mesh, [Socket(piece.socket, np.eye(3), 0)], {0: c}, E, NU).toarray()
    free = np.flatnonzero(np.repeat(points_of(piece.mesh)[:, 2] > 1e-9, 3))
    H = np.zeros((len(c.A), len(K)))
    H[:, freedoms(piece.socket)] = c.H
    wanted = c.A + H[:, free] @ np.linalg.solve(K[np.ix_(free, free)], H[:, free].T)
    found = fine_compliance(turned(piece) if rotated else piece, *patch(), E, NU)
    assert relative(found, wanted) < 1e-9


@pytest.mark.parametrize("rotated", [False, True])
def test_modes_answer_as_the_whole_piece(rotated):
    """With all modes kept, A + V G V^T of the coarse piece is its C_fine; held or free."""
    for held in (("floor",), ()):
        piece = turned(holed(*held)) if rotated else holed(*held)
        V, rows = patch_modes(condensed(), 10**6)
        G = coarse_compliance(piece, condensed(), rows, E, NU)
        fine = fine_compliance(piece, *patch(), E, NU)
        inside = fine - V @ G @ V.T
        wanted = condensed().A
        if not held:  # the patch's own mass is not the coarse piece's; rigid motions of the patch tell which forces balance
            mesh, normals = patch()
            rigid = hat_rows(mesh, normals) @ rigid_modes(mesh.points)
            null = np.linalg.svd(rigid.T)[2][6:]
            inside, wanted = null @ inside @ null.T, null @ wanted @ null.T
        assert relative(inside, wanted) < 1e-9


def test_a_free_piece_is_answered_by_inertia_relief(monkeypatch):
    """Any six freedoms may keep the matrix from being singular: the motions under any force, which a rigid field of body
    forces balances, stay the same up to a rigid motion, as nothing is left that the six would have to hold."""
    piece, (mesh, normals) = holed(), patch()
    rows = patch_modes(condensed(), 12)[1]

    def both():
        """Motions of hats and of modes without rigid ones, under all forces."""
        at_socket = rigid_modes(points_of(piece.mesh)[piece.socket])
        rigid = (hat_rows(mesh, normals) @ rigid_modes(mesh.points), rows @ at_socket)
        answers = (fine_compliance(piece, mesh, normals, E, NU), coarse_compliance(piece, condensed(), rows, E, NU))
        # orthogonal to the six rigid motions
        return [np.linalg.svd(R)[0][:, 6:].T @ F for F, R in zip(answers, rigid, strict=True)]

    found = both()
    corners = [int(np.abs(points_of(piece.mesh) - x).sum(axis=1).argmin()) for x in ([0, 0, 0], [1, 0, 0], [0, 1, 0])]
    other = freedoms(np.array(corners))[[0, 1, 2, 4, 5, 8]]
    monkeypatch.setattr(coarse, "isostatic", lambda *_: other)
    for again, before in zip(both(), found, strict=True):
        assert relative(again, before) < 1e-8


def test_own_compliance_of_like_pieces_is_the_patch_s_up_to_the_modes_left_out(monkeypatch):
    """Where the submodel is the coarse body itself A_own is A, the nearer the more modes are taken out; under pressures of
    contacts a dozen are enough."""
    monkeypatch.setattr(coarse, "REALISATIONS", 1)
    piece = holed("floor")
    fine, A = fine_compliance(piece, *patch(), E, NU), condensed().A
    p = contact_pressures(condensed())
    errors, pressed = [], []
    for count in (6, 12, 10**6):
        V, rows = patch_modes(condensed(), count)
        A_own = own_compliance(fine, V, lambda _, rows=rows: coarse_compliance(piece, condensed(), rows, E, NU))
        assert np.array_equal(A_own, A_own.T)
        errors.append(relative(A_own, A))
        pressed.append(relative(p.T @ A_own @ p, p.T @ A @ p))
    assert pressed[0] > pressed[1] > pressed[2]
    assert errors[0] < 0.05
    assert pressed[1] < 1e-3
    assert errors[2] < 1e-9


def test_few_modes_carry_pressures_of_contacts_to_their_socket():
    """Elliptic pressures of other sizes and places than those that modes are made of are carried by twelve modes to
    one per cent of what reaches the socket, several times better than by the strongest modes of all forces; by all modes
    everything is."""
    c = condensed()
    x = c.points[:, :2] - 0.5 * (c.points.max(axis=0) + c.points.min(axis=0))[:2]
    x = x / np.abs(x).max(axis=0)
    forces = []
    for size, place in ((0.42, (0.3, -0.2)), (0.58, (-0.1, 0.3)), (0.73, (0.2, 0.1)), (0.88, (-0.05, 0.02))):
        pressure = c.areas * np.sqrt(np.maximum(1.0 - (((x - place) / size) ** 2).sum(axis=1), 0.0))
        forces.append(pressure / pressure.sum())
    p = np.array(forces).T
    V, rows = patch_modes(c, 12)
    assert V.shape[1] == 12
    assert np.abs(V.T @ V - np.eye(12)).max() < 1e-12
    lost = relative(rows.T @ (V.T @ p), c.H.T @ p)
    strongest = np.linalg.svd(c.H)[0][:, :12]
    assert lost < 1e-2
    assert lost < 0.4 * relative(c.H.T @ (strongest @ (strongest.T @ p)), c.H.T @ p)
    V, rows = patch_modes(c, 10**6)
    assert relative(V @ rows, c.H) < 1e-9


def test_what_the_body_answers_to_few_modes_is_what_it_answers_to_all():
    """Twelve modes with the forces' resultants exact miss 0.04 % of the response; the strongest traces alone, 0.3 %."""
    piece, c = holed("floor"), condensed()
    p = contact_pressures(c)
    found = []
    for count in (12, 10**6):
        V, rows = patch_modes(c, count)
        found.append(p.T @ V @ coarse_compliance(piece, c, rows, E, NU) @ V.T @ p)
    assert relative(*found) < 8e-4


@pytest.mark.parametrize("parallel", [False, True])
def test_resultants_of_forces_that_meet_or_are_parallel(parallel):
    """Forces through a point have three resultants, parallel ones too; the first three modes hold them, to round-off."""
    mesh, normals = patch()
    if parallel:
        normals = np.tile([0.0, 0.6, 0.8], (len(normals), 1))
    c = condense_patch(mesh, normals, E, NU)
    wanted = hat_rows(mesh, normals) @ rigid_modes(mesh.points)
    V, rows = patch_modes(c, 3)
    assert V.shape[1] == 3
    assert np.abs(V @ (rows @ rigid_modes(c.socket)) - wanted).max() < 1e-12


def test_own_compliance_averages_the_coarse_piece_over_its_meshes():
    asked = []

    def response(scale):
        asked.append(scale)
        return np.array([[scale]])

    V = np.array([[1.0], [2.0]])
    found = own_compliance(10.0 * np.eye(2), V, response)
    assert asked == pytest.approx([1.0 + coarse.STEP * n for n in range(coarse.REALISATIONS)])
    np.testing.assert_allclose(found, 10.0 * np.eye(2) - np.mean(asked) * V @ V.T, rtol=1e-12)


@pytest.mark.parametrize("cells", [2, 4])
def test_hats_on_a_carrier_are_exact_for_a_quadratic_field(cells):
    """Displacements of second order in the local coordinates lie in the carrier's space: their means over the fine hats are
    the fine patch's own; they are not for fourth order."""
    fine, normals = patch(8)
    carrier = patch(cells, zone=1.0)[0]

    def means(field):
        on_carrier = hat_rows(fine, normals, carrier) @ field(carrier.points).ravel()
        on_patch = mean_weights(fine.weights) @ (field(fine.points)[fine.contact] * normals).sum(axis=1)
        np.testing.assert_allclose(hat_rows(fine, normals) @ field(fine.points).ravel(), on_patch, rtol=1e-12)
        return relative(on_carrier, on_patch)

    slope = np.array([[1.0, 0.5, -0.3, 2.0, 0.7, -1.1], [0.2, -0.4, 0.9, 0.3, 1.3, 0.8], [-0.6, 1.2, 0.1, 0.5, -0.9, 1.0]])

    def quadratic(x):
        terms = np.column_stack([np.ones(len(x)), x[:, 0], x[:, 1], x[:, 0] ** 2, x[:, 0] * x[:, 1], x[:, 1] ** 2])
        return terms @ slope.T

    assert means(quadratic) < 1e-12
    assert means(lambda x: quadratic(x) * (1.0 + x[:, :1] ** 2)) > 1e-7


def test_condensed_with_a_carrier():
    """S is the carrier's, H near the fine patch's; A misses what the carrier's cells cannot follow and is stiffer. A patch
    that carries itself changes nothing, one without a grid carries none."""
    fine, normals = patch(8)
    whole, carried = condense_patch(fine, normals, E, NU), condense_patch(fine, normals, E, NU, patch()[0])
    assert carried.A.shape == whole.A.shape
    assert carried.unknowns == whole.unknowns
    assert relative(carried.S, condensed().S) < 1e-12
    misses = relative(carried.A, whole.A)
    assert relative(carried.H.T @ whole.areas, whole.H.T @ whole.areas) < 0.5 * misses
    assert np.all(np.diag(carried.A) < 0.9 * np.diag(whole.A))
    np.testing.assert_array_equal(carried.areas, whole.areas)
    again = condense_patch(fine, normals, E, NU, fine)
    assert max(relative(getattr(again, x), getattr(whole, x)) for x in "AHS") < 1e-10
    with pytest.raises(ValueError, match="only a patch of hexahedra has a grid"):
        hat_rows(fine, normals, replace(patch()[0], contact_shape=None))
