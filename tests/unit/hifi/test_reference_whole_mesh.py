"""Condensed bodies of two balls against one mesh of the whole: compliances, loads, approaches."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import block_diag
from tests.fe_meshes import freedoms
from tests.helpers import sockets_of
from tests.two_balls import SMALL, relative_deviation_of_fit

from rollbench.hifi import condensation, condensed, coupling, reference
from rollbench.hifi.bodies import grid_wave
from rollbench.hifi.bodies.coarse import select_isostatic_freedoms
from rollbench.hifi.bodies.patch import mean_normal_displacement_matrix
from rollbench.hifi.contact.balls import SolverState, contact_compliance_of_single_ball, solve_contacts_of_all_balls
from rollbench.hifi.elements.forms import elastic_stiffness, normalise_weight_rows
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.meshing import part_meshes
from rollbench.meshes import ball_body
from rollbench.meshes.sockets import points_in_box_at_azimuth_zero

pytestmark = [pytest.mark.xdist_group("helped by processes"), pytest.mark.slow]


def whole(body, patches, material, held):
    """Compliance of the hats from one mesh of the body and all its patches, tied node by node.

    patches: (mesh, rows of the hats, socket's nodes, rotation); held: the body's freedoms by those that are free.
    """
    elastic = material.youngs_modulus, material.poissons_ratio
    blocks, loads, size = [elastic_stiffness(body, *elastic)], [], body.doflocs.size
    inner_of = [freedoms(np.setdiff1d(np.arange(len(p.points)), p.interface_nodes)) for p, *_ in patches]
    total, start = size + sum(len(i) for i in inner_of), size
    columns = [sp.eye(size, total)]
    for (mesh, hats, nodes, R), inner in zip(patches, inner_of, strict=True):
        blocks.append(elastic_stiffness(mesh.mesh, *elastic))
        own = slice(start, start + len(inner))
        C, load = sp.lil_matrix((3 * len(mesh.points), total)), sp.lil_matrix((hats.shape[0], total))
        C[inner, start + np.arange(len(inner))] = 1.0
        turn = sp.kron(sp.identity(len(nodes)), R.T)  # the body moves in space, the patch in its own frame
        tie = sp.kron(mesh.interface_weights, sp.identity(3)) @ turn
        C[np.ix_(freedoms(mesh.interface_nodes), freedoms(nodes))] = tie.toarray()
        load[:, own] = hats[:, inner]
        columns.append(C)
        loads.append(load)
        start = own.stop
    C = sp.vstack(columns).tocsr()
    K = (C.T @ sp.block_diag(blocks) @ C).tocsc()
    T = sp.block_diag([held, sp.identity(total - size)]).tocsc()
    return symmetric_compliance_of_loads((T.T @ K @ T).tocsc(), sp.vstack(loads) @ T)


def patch(small, meshes, side, *, ball=False):
    """The patch that is condensed with its socket, and the rows of the finer one's hats on it."""
    body = meshes.ball_mesh if ball else meshes.screw_mesh if side < 2 else meshes.nut_mesh
    place = partial(points_in_box_at_azimuth_zero, small.groove_map, meshes.socket_size, side)
    if ball:
        zone = meshes.socket_size, side, meshes.relative_zone_size
        place = part_meshes.ball_refinement_box_and_map(small.groove_map, *zone)[1]
    mesh = part_meshes.mesh_patch(meshes, body.box_faces[side], place, SMALL)
    carrier = part_meshes.mesh_coarser_patch(meshes, body.box_faces[side], place, SMALL)
    centre = np.zeros(3) if ball else np.array([small.groove_map.R, 0.0, 0.0])
    normals = (-1.0 if ball else 1.0) * part_meshes.contact_normals_of_patch(mesh, centre)
    return carrier, mean_normal_displacement_matrix(mesh, normals, carrier)


@pytest.fixture(scope="module")
def bodies(small):
    """Compliance of screw, nut and ball at their hats, each from one whole mesh."""
    scene, dims = small.scene, small.solid_dimensions
    meshes = part_meshes.mesh_parts(scene, small.groove_map, small.ball_positions, dims, small.loaded_flanks, SMALL)
    of_screw = condensation.screw_freedoms_from_free_ones(meshes.screw_mesh, dims, dims.ends_of_meshed_screw(scene)[1])
    of_nut = condensation.nut_freedoms_from_free_ones(meshes.nut_mesh, dims)

    def grooved(side, body, material, held):
        boxes = part_meshes.refinement_boxes_at_contact_azimuths(body, sockets_of(scene, (side,)))
        groove = patch(small, meshes, side)
        return whole(body.mesh, [(*groove, s.node_indices, s.rotation) for s in boxes], material, held)

    ball = meshes.ball_mesh
    parts = [(*patch(small, meshes, s, ball=True), ball.nodes_on_box_faces[s], np.eye(3)) for s in (0, 3)]
    held = select_isostatic_freedoms(ball.points, np.concatenate([p[2] for p in parts]))
    free = np.delete(np.arange(ball.mesh.doflocs.size), held)
    return {
        "screw": grooved(0, meshes.screw_mesh, scene.screw.material, of_screw),
        "nut": grooved(3, meshes.nut_mesh, scene.nut.material, of_nut),
        "ball": whole(ball.mesh, parts, scene.balls.material, sp.identity(ball.mesh.doflocs.size, format="csc")[:, free]),
    }


def test_condensed_bodies_are_those_of_the_whole_mesh(small, bodies):
    screw, nut, ball = small.condensed_screw, small.condensed_nut, small.condensed_ball
    m = screw.stretch.mode_count
    groove = {s: p.groove_patch.A for s, p in small.patches_by_flank.items()}
    condensed_bodies = {
        "screw": (2 * [groove[0]], 2 * [screw.modes_by_flank[0]], screw.stretch.F[:m, :m]),
        "nut": (2 * [groove[3]], 2 * [nut.modes_by_flank[3]], nut.G),
        "ball": ([p.ball_patch.A for p in small.patches_by_flank.values()], ball.modes_by_flank.values(), ball.G),
    }
    for name, (patches, modes, G) in condensed_bodies.items():
        wanted = block_diag(*patches) + block_diag(*modes) @ G @ block_diag(*modes).T
        np.testing.assert_allclose(bodies[name], wanted, rtol=0, atol=1e-10 * np.abs(wanted).max(), err_msg=name)


def test_contact_loads_are_those_of_the_whole_mesh(small, bodies):
    """Two balls, both bodies, same mesh, each contact's own compliance exchanged as submodels ask for, the grid's wave left
    in: loads with nothing condensed agree to 1e-10."""
    pairs = {s: replace(pair, gap_correction=None) for s, pair in small.patches_by_flank.items()}
    small, sides = replace(small, patches_by_flank=pairs), (0, 3)
    mounted = coupling.compliance_of_supported_screw(small, small.scene)
    m = small.condensed_screw.stretch.mode_count
    placed_set = coupling.PlacedNut(small, small.scene, sides)
    C, rows = coupling.assemble_contact_compliance((placed_set,), mounted)
    pick = np.flatnonzero(rows < m)
    # the beam to the support is not meshed: its share of the screw's compliance comes on top
    beam = np.zeros((C.mode_compliance.shape[0],) * 2)
    beam[np.ix_(pick, pick)] = (mounted.G - small.condensed_screw.stretch.F[:m, :m])[np.ix_(rows[pick], rows[pick])]
    grooves = [pairs[s].groove_patch for s in sides]
    n = [len(groove.A) for groove in grooves]
    U = np.zeros((2 * sum(n), len(beam)))
    for i, (V, c) in enumerate(zip(C.modes_by_ball, C.mode_slices_by_ball, strict=True)):
        U[i * sum(n) : (i + 1) * sum(n), c] = V
    exchanged = block_diag(*(pairs[s].local_compliance - pairs[s].groove_patch.A - pairs[s].ball_patch.A for s in sides))
    dense = U @ beam @ U.T + block_diag(*2 * [bodies["ball"] + exchanged])
    hats = np.arange(2 * sum(n)).reshape(2, -1)
    for name, of_body in (("screw", hats[:, : n[0]].ravel()), ("nut", hats[:, n[0] :].ravel())):
        dense[np.ix_(of_body, of_body)] += bodies[name]
    normals = np.concatenate([groove.contact_points - [small.groove_map.R, 0, 0] for groove in grooves])
    length = np.linalg.norm(normals, axis=1)
    mean = sp.block_diag([normalise_weight_rows(groove.pressure_weights) for groove in grooves])
    gap = np.tile(mean @ (length - small.groove_map.ball), 2)
    directions = np.broadcast_to(normals / length[:, None], (2, sum(n), 3))
    by_screw = coupling.normal_motion_by_rigid_motions(placed_set, directions, mounted.origin_position, screw=True)
    by_screw = sp.block_diag([mean, mean]) @ by_screw.reshape(-1, 6)
    N = coupling.gap_closing_matrix([np.stack([mean @ d for d in directions])], by_screw @ mounted.free_motions)
    f = np.concatenate([np.zeros(6), mounted.work_on_free_motions])
    frozen = reference.solve_reference(small, small.scene, updates=0)
    start = SolverState(np.zeros(0), frozen.contact_solution.rigid_motions * 1.01)
    by_loads = np.zeros(rows.size)
    by_loads[pick] = mounted.mode_displacements_by_loads[rows[pick]]
    gap = gap + coupling.normal_motion_of_nodes(C, by_loads)
    compliance = contact_compliance_of_single_ball(dense)
    other, _ = solve_contacts_of_all_balls(compliance, gap, N, f, start=start, tolerance=1e-12)
    assert other.converged
    assert frozen.status == "converged"
    largest = frozen.contact_solution.forces.max()
    np.testing.assert_allclose(other.forces, frozen.contact_solution.forces, rtol=0, atol=1e-10 * largest)


def test_own_approaches_of_condensed_bodies(small, monkeypatch):
    """Spread forces have unit resultants, the place on the grid hardly matters.

    Cells are wider here than the ellipse is thick.
    """
    forces = {s: condensed.sampled_contact_forces(small, s) for s in small.loaded_flanks}
    for s, f in forces.items():
        groove = small.patches_by_flank[s].groove_patch
        spread = condensed.hertz_shares_of_nodes(small, s, float(np.median(f)))
        nodal = normalise_weight_rows(groove.pressure_weights).T @ spread
        inward = ball_body.contact_frame_vectors(small.groove_map, s)[0]
        assert nodal @ (groove.normals @ inward) == pytest.approx(1.0, rel=1e-12)
    found = condensed.collect_condensed_bodies(small, 1)
    for s, loads in forces.items():
        # cells are wider than the ellipse is thick: 1 % here, 0.1 % on level 1
        assert relative_deviation_of_fit(found, s) < 0.02
        approach = condensed.approaches_with_fixed_bodies(small, s, loads)
        assert np.all(np.diff(approach) > 0.0)
        # Hertz's 2/3, less what the held sockets take away
        assert 0.59 < np.log(approach[-1] / approach[0]) / np.log(loads[-1] / loads[0]) < 2 / 3
        with monkeypatch.context() as patch:
            patch.setattr(grid_wave, "MEAN", (12, 10))
            assert condensed.approaches_with_fixed_bodies(small, s, loads) == pytest.approx(approach, rel=8e-3)
