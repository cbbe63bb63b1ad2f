"""Condensed bodies of two balls against one mesh of the whole: compliances, loads, approaches."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import block_diag
from tests.helpers import sockets_of
from tests.two_balls import SMALL

from rollbench.hifi import condensation, condensed, coupling, reference
from rollbench.hifi.bodies import grid_wave
from rollbench.hifi.bodies.coarse import degrees_of_freedom_of_nodes, select_isostatic_freedoms
from rollbench.hifi.bodies.patch import mean_normal_displacement_matrix
from rollbench.hifi.contact.balls import SolverState, contact_compliance_of_single_ball, solve_contacts_of_all_balls
from rollbench.hifi.elements.forms import assemble_constant_form, elasticity_form, normalise_weight_rows
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.part_meshes import ball_refinement_box_and_map, refinement_boxes_at_contact_azimuths
from rollbench.meshes import ball_body
from rollbench.meshes.sockets import points_in_box_at_azimuth_zero

pytestmark = pytest.mark.xdist_group("helped by processes")


def whole(body, patches, material, held):
    """Compliance of the hats from one mesh of the body and all its patches, tied node by node.

    patches: (mesh, rows of the hats, socket's nodes, rotation); held: the body's freedoms by those that are free.
    """
    E, nu = material.youngs_modulus, material.poissons_ratio
    blocks, columns, loads = [assemble_constant_form(elasticity_form(E, nu), body)], [], []
    size = body.doflocs.size
    inner_of = [np.setdiff1d(np.arange(len(p.points)), p.interface_nodes) for p, *_ in patches]
    total = size + 3 * sum(len(i) for i in inner_of)
    columns.append(sp.hstack([sp.identity(size), sp.csr_matrix((size, total - size))]))
    start = size
    for (mesh, hats, nodes, R), inner in zip(patches, inner_of, strict=True):
        blocks.append(assemble_constant_form(elasticity_form(E, nu), mesh.mesh))
        C = sp.lil_matrix((3 * len(mesh.points), total))
        C[degrees_of_freedom_of_nodes(inner), start + np.arange(3 * len(inner))] = 1.0
        turn = sp.kron(sp.identity(len(nodes)), R.T)  # the body moves in space, the patch in its own frame
        C[np.ix_(degrees_of_freedom_of_nodes(mesh.interface_nodes), degrees_of_freedom_of_nodes(nodes))] = (
            sp.kron(mesh.interface_weights, sp.identity(3)) @ turn
        ).toarray()
        columns.append(C.tocsr())
        left, right = (sp.csr_matrix((hats.shape[0], n)) for n in (start, total - start - 3 * len(inner)))
        loads.append(sp.hstack([left, hats[:, degrees_of_freedom_of_nodes(inner)], right]))
        start += 3 * len(inner)
    C = sp.vstack(columns).tocsr()
    K = (C.T @ sp.block_diag(blocks) @ C).tocsc()
    T = sp.block_diag([held, sp.identity(total - size)]).tocsc()
    return symmetric_compliance_of_loads((T.T @ K @ T).tocsc(), sp.vstack(loads) @ T)


def patch(small, meshes, side, *, ball=False):
    """The patch that is condensed with its socket, and the rows of the finer one's hats on it."""
    body = meshes.ball_mesh if ball else meshes.screw_mesh if side < 2 else meshes.nut_mesh
    in_groove = partial(points_in_box_at_azimuth_zero, small.groove_map, meshes.socket_size, side)
    place = (
        ball_refinement_box_and_map(small.groove_map, meshes.socket_size, side, meshes.relative_zone_size)[1]
        if ball
        else in_groove
    )
    mesh = part_meshes.mesh_patch(meshes, body.box_faces[side], place, SMALL)
    carrier = part_meshes.mesh_coarser_patch(meshes, body.box_faces[side], place, SMALL)
    centre = np.zeros(3) if ball else np.array([small.groove_map.R, 0.0, 0.0])
    normals = (-1.0 if ball else 1.0) * part_meshes.contact_normals_of_patch(mesh, centre)
    return carrier, mean_normal_displacement_matrix(mesh, normals, carrier)


def bodies(small, meshes):
    """Compliance of screw, nut and ball at their hats, each from one whole mesh."""
    out, scene, high = {}, small.scene, small.solid_dimensions.ends_of_meshed_screw(small.scene)[1]
    for name, side, mesh, material, held in (
        (
            "screw",
            0,
            meshes.screw_mesh,
            scene.screw.material,
            condensation.screw_freedoms_from_free_ones(meshes.screw_mesh, small.solid_dimensions, high),
        ),
        (
            "nut",
            3,
            meshes.nut_mesh,
            scene.nut.material,
            condensation.nut_freedoms_from_free_ones(meshes.nut_mesh, small.solid_dimensions),
        ),
    ):
        groove, hats = patch(small, meshes, side)
        parts = [
            (groove, hats, s.node_indices, s.rotation)
            for s in refinement_boxes_at_contact_azimuths(mesh, sockets_of(scene, (side,)))
        ]
        out[name] = whole(mesh.mesh, parts, material, held)
    parts = [(*patch(small, meshes, s, ball=True), meshes.ball_mesh.nodes_on_box_faces[s], np.eye(3)) for s in (0, 3)]
    held, size = (
        select_isostatic_freedoms(meshes.ball_mesh.points, np.concatenate([p[2] for p in parts])),
        meshes.ball_mesh.mesh.doflocs.size,
    )
    free = sp.identity(size, format="csc")[:, np.setdiff1d(np.arange(size), held)]
    return out | {"ball": whole(meshes.ball_mesh.mesh, parts, scene.balls.material, free)}


@pytest.fixture(scope="module")
def meshes(small):
    return part_meshes.mesh_parts(
        small.scene, small.groove_map, small.ball_positions, small.solid_dimensions, small.loaded_flanks, SMALL
    )


def test_condensed_bodies_are_those_of_the_whole_mesh(small, meshes):
    found = bodies(small, meshes)
    A = {s: p.groove_patch.A for s, p in small.patches_by_flank.items()}
    V = {0: small.condensed_screw.modes_by_flank[0], 3: small.condensed_nut.modes_by_flank[3]}
    m = small.condensed_screw.stretch.mode_count
    for name, side, G in (("screw", 0, small.condensed_screw.stretch.F[:m, :m]), ("nut", 3, small.condensed_nut.G)):
        U = block_diag(V[side], V[side])
        wanted = block_diag(A[side], A[side]) + U @ G @ U.T
        np.testing.assert_allclose(found[name], wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())
    U = block_diag(*small.condensed_ball.modes_by_flank.values())
    wanted = block_diag(*(p.ball_patch.A for p in small.patches_by_flank.values())) + U @ small.condensed_ball.G @ U.T
    np.testing.assert_allclose(found["ball"], wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())


def test_contact_loads_are_those_of_the_whole_mesh(small, meshes):
    """Two balls, both bodies, same mesh, each contact's own compliance exchanged as submodels ask for, the grid's wave left
    in: loads with nothing condensed agree to 1e-10."""
    small = replace(
        small, patches_by_flank={s: replace(pair, gap_correction=None) for s, pair in small.patches_by_flank.items()}
    )
    found = bodies(small, meshes)
    sides = (0, 3)
    mounted = coupling.compliance_of_supported_screw(small, small.scene)
    m = small.condensed_screw.stretch.mode_count
    placed_set = coupling.PlacedNut(small, small.scene, sides)
    C, rows = coupling.assemble_contact_compliance((placed_set,), mounted)
    pick = np.flatnonzero(rows < m)
    # the beam to the support is not meshed: its share of the screw's compliance comes on top
    beam = np.zeros((C.mode_compliance.shape[0],) * 2)
    beam[np.ix_(pick, pick)] = (mounted.G - small.condensed_screw.stretch.F[:m, :m])[np.ix_(rows[pick], rows[pick])]
    n = [len(small.patches_by_flank[s].groove_patch.A) for s in sides]
    U = np.zeros((2 * sum(n), len(beam)))
    for i, (V, c) in enumerate(zip(C.modes_by_ball, C.mode_slices_by_ball, strict=True)):
        U[i * sum(n) : (i + 1) * sum(n), c] = V
    exchanged = block_diag(
        *(
            small.patches_by_flank[s].local_compliance
            - small.patches_by_flank[s].groove_patch.A
            - small.patches_by_flank[s].ball_patch.A
            for s in sides
        )
    )
    dense = U @ beam @ U.T + block_diag(*2 * [found["ball"] + exchanged])
    for name, hats in (("screw", slice(0, n[0])), ("nut", slice(n[0], sum(n)))):
        rows_of_body = np.concatenate([i * sum(n) + np.arange(sum(n))[hats] for i in range(2)])
        dense[np.ix_(rows_of_body, rows_of_body)] += found[name]
    normals = np.concatenate(
        [small.patches_by_flank[s].groove_patch.contact_points - [small.groove_map.R, 0, 0] for s in sides]
    )
    length = np.linalg.norm(normals, axis=1)
    mean = sp.block_diag([normalise_weight_rows(small.patches_by_flank[s].groove_patch.pressure_weights) for s in sides])
    gap = np.tile(mean @ (length - small.groove_map.ball), 2)
    directions = np.broadcast_to(normals / length[:, None], (2, sum(n), 3))
    by_screw = coupling.normal_motion_by_rigid_motions(placed_set, directions, mounted.origin_position, screw=True).reshape(
        -1, 6
    )
    by_screw = sp.block_diag([mean, mean]) @ by_screw
    directions = np.stack([mean @ d for d in directions])
    N = coupling.gap_closing_matrix([directions], by_screw @ mounted.free_motions)
    f = np.concatenate([np.zeros(6), mounted.work_on_free_motions])
    frozen = reference.solve_reference(small, small.scene, updates=0)
    start = SolverState(np.zeros(0), frozen.contact_solution.rigid_motions * 1.01)
    by_loads = np.zeros(rows.size)
    by_loads[pick] = mounted.mode_displacements_by_loads[rows[pick]]
    at_rest = coupling.normal_motion_of_nodes(C, by_loads)
    other, _ = solve_contacts_of_all_balls(
        contact_compliance_of_single_ball(dense), gap + at_rest, N, f, start=start, tolerance=1e-12
    )
    assert other.converged
    assert frozen.status == "converged"
    largest = frozen.contact_solution.forces.max()
    np.testing.assert_allclose(other.forces, frozen.contact_solution.forces, rtol=0, atol=1e-10 * largest)


def test_own_approaches_of_condensed_bodies(small, monkeypatch):
    """Spread forces have unit resultants, the matrices' own force adds nothing, the place on the grid hardly matters.

    Cells are wider here than the ellipse is thick.
    """
    forces = {s: condensed.sampled_contact_forces(small, s) for s in small.loaded_flanks}
    spreads = {s: condensed.hertz_shares_of_nodes(small, s, float(np.median(f))) for s, f in forces.items()}
    for s, f in spreads.items():
        groove = small.patches_by_flank[s].groove_patch
        nodal = normalise_weight_rows(groove.pressure_weights).T @ f
        assert nodal @ (groove.normals @ ball_body.contact_frame_vectors(small.groove_map, s)[0]) == pytest.approx(
            1.0, rel=1e-12
        )
    found = condensed.collect_condensed_bodies(small, 1)
    middle = np.array([float(np.median(f)) for f in forces.values()])
    again = {s: condensed.hertz_shares_of_nodes(small, s, x) for s, x in zip(small.loaded_flanks, middle, strict=True)}
    np.testing.assert_allclose(
        condensed.contact_compliance_of_bodies(small, again),
        condensed.contact_compliance_of_bodies(small, spreads),
        rtol=1e-12,
    )
    for k, s in enumerate(small.loaded_flanks):
        loads = forces[s]
        assert found.force[k] == pytest.approx(loads, rel=1e-12)
        assert (
            found.relative_deviation_of_fit(s) < 0.02
        )  # cells are wider than the ellipse is thick: 1 % here, 0.1 % on level 1
        approach = condensed.approaches_with_fixed_bodies(small, s, loads)
        assert np.all(np.diff(approach) > 0.0)
        # Hertz's 2/3, less what the held sockets take away
        assert 0.59 < np.log(approach[-1] / approach[0]) / np.log(loads[-1] / loads[0]) < 2 / 3
        with monkeypatch.context() as patch:
            patch.setattr(grid_wave, "MEAN", (12, 10))
            assert condensed.approaches_with_fixed_bodies(small, s, loads) == pytest.approx(approach, rel=8e-3)
