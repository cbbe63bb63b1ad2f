"""Recovered displacements and stresses: against what was condensed, exact fields, equilibrium and Hertz."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from tests.fe_meshes import cube
from tests.helpers import relative, small_screw

from rollbench.hifi import fields as recovered
from rollbench.hifi.bodies.patch import condense_patch
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.meshing.part_meshes import mesh_parts
from rollbench.hifi.meshing.settings import Settings, estimate_contacts_of_scene, round_up_lengths
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import mesh_and_condense_geometry
from rollbench.meshes.cache import Cache
from rollbench.meshes.fem import build_mesh, node_coordinates
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Material, Solid

pytestmark = [pytest.mark.xdist_group("recovered fields"), pytest.mark.slow]

SIDES = (0, 3)


@pytest.fixture(scope="module")
def case(_one_submodel, tmp_path_factory):
    """Two balls in a short nut. Cells are between those of mesh levels 1 and 2: the largest pressure of hats on 1.7 cells
    across a short semi-axis, as on level 1, is 10 to 17 % too large by where the contact falls between them."""
    scene = small_screw(2, 0.2, force=(0.0, 0.0, 330.0), load_at=0.0)
    scene = replace(scene, nut=replace(scene.nut, length=16e-3), solid=Solid(shaft=6e-3, shaft_diameter=30e-3))
    expected = estimate_contacts_of_scene(scene)
    semi, reach = round_up_lengths(expected.typical_semi_axes()), round_up_lengths(expected.largest_reach())
    sizes = {"fine": 4e-3, "coarse": 10e-3, "ball_fine": 1e-3, "ball_coarse": 1.6e-3}
    own = {"own_cuts": (2, 2, 2), "own_sizes": (2.4e-3, 10e-3), "own_ball_sizes": (1.2e-3, 2e-3)}
    settings = Settings(b_over_h=2.1, semi=semi, reach=reach, modes=20, growth=2.0, **sizes, **own)
    cache = Cache(tmp_path_factory.mktemp("cache"))
    setup = mesh_and_condense_geometry(scene, SIDES, settings, cache=cache)
    meshes = mesh_parts(scene, setup.groove_map, setup.ball_positions, setup.solid_dimensions, SIDES, settings, cache)
    result = solve_reference(setup, scene)
    assert result.contact_solution.converged
    forces = recovered.contact_node_forces_by_flank(setup, result)
    u = {
        0: recovered.nodal_displacements_of_screw(setup, meshes.screw_mesh, forces),
        3: recovered.nodal_displacements_of_nut(setup, meshes.nut_mesh, forces),
    }
    fields = {s: recovered.stress_field_of_groove_patch(setup, meshes, u[s], 0, s, forces) for s in SIDES}
    return setup, meshes, result, forces, u, fields, recovered.stress_fields_of_ball(setup, meshes, 0, forces)


class TestStress:
    @pytest.mark.parametrize("kind", ["P1", "P2", "Q1", "Q2"])
    def test_of_a_uniform_strain_is_exact(self, kind):
        points, cells = cube(kind, 2)
        slope = 1e-4 * np.array([[1.0, 0.3, -0.2], [0.1, -0.5, 0.4], [0.7, 0.2, 0.9]])
        strain = 0.5 * (slope + slope.T)
        steel = Material(210e9, 0.28)
        lam, mu = 210e9 * 0.28 / (1.28 * 0.44), 210e9 / 2.56
        exact = 2.0 * mu * strain + lam * np.trace(strain) * np.eye(3)
        mesh, _ = build_mesh(points, cells, kind)
        found = recovered.nodal_stress(mesh, node_coordinates(mesh) @ slope.T, steel)
        assert relative(found, exact[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]) < 1e-10

    def test_von_mises(self):
        assert recovered.von_mises(np.array([5.0, 5.0, 5.0, 0.0, 0.0, 0.0])) == 0.0
        assert recovered.von_mises(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 2.0])) == pytest.approx(2.0 * np.sqrt(3.0))

    def test_below_a_hertz_contact(self):
        """Johnson, Contact Mechanics (1985), 4.2: a sphere; nearly a line contact, 0.558 p0 at 0.704 b."""
        sphere = solve_hertz(100.0, 5e-3, 5e-3, 210e9, 0.3)
        line = solve_hertz(100.0, 1.0, 5e-3, 210e9, 0.3)
        for h, depth, share, close in (
            (sphere, 0.481 * sphere.semi_x, 0.620, 2e-3),
            (line, 0.704 * line.semi_y, 0.558, 0.01),
        ):
            assert recovered.von_mises_below_hertz_contact(h, np.array([depth]), 0.3)[0] == pytest.approx(
                share * h.pole_pressure, rel=close
            )


class TestRecovered:
    @pytest.mark.parametrize("side", SIDES)
    def test_hats_of_the_grooves_move_as_condensed(self, case, side):
        """The field is the fine patch's; H of the coarser patch that is condensed in its stead, and the modes left out,
        change what the body adds little."""
        setup, meshes, _, forces, u, fields, _ = case
        patch, body = setup.patches_by_flank[side].groove_patch, meshes.screw_mesh if side < 2 else meshes.nut_mesh
        mesh, steel = recovered.mesh_groove_patch(setup, meshes, side), setup.scene.screw.material
        fine = condense_patch(mesh, patch.normals, steel.youngs_modulus, steel.poissons_ratio)
        nodal = np.einsum("ck,ck->c", fields[side].displacements[mesh.contact_nodes], patch.normals)
        found = normalise_weight_rows(mesh.pressure_weights) @ nodal
        c, s = np.cos(setup.ball_positions.azimuth[0]), np.sin(setup.ball_positions.azimuth[0])
        trace = u[side][body.nodes_on_box_faces[0]] @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        assert relative(found, fine.A @ forces[side][0] + fine.H @ trace.ravel()) < 1e-7
        assert relative(patch.H @ trace.ravel(), fine.H @ trace.ravel()) < 2e-3
        condensed = setup.condensed_screw if side < 2 else setup.condensed_nut
        V = condensed.modes_by_flank[side]
        z = np.concatenate([V.T @ f for f in forces[side]])
        G = (condensed.stretch.F if side < 2 else condensed.G)[: V.shape[1], : z.size]
        assert relative(found, fine.A @ forces[side][0] + V @ (G @ z)) < 2e-3

    def test_hats_of_the_ball_move_as_condensed(self, case):
        setup, meshes, _, forces, _, _, ball = case
        steel, response = setup.scene.balls.material, setup.condensed_ball
        V = block_diag(*(response.modes_by_flank[s] for s in SIDES))
        body = V @ (response.G @ (V.T @ np.concatenate([forces[s][0] for s in SIDES])))
        found, patches = [], []
        for s in SIDES:
            mesh, normals = recovered.mesh_ball_patch(setup, meshes, s), setup.patches_by_flank[s].ball_patch.normals
            fine = condense_patch(mesh, normals, steel.youngs_modulus, steel.poissons_ratio)
            nodal = np.einsum("ck,ck->c", ball[s].displacements[mesh.contact_nodes], normals)
            found.append(normalise_weight_rows(mesh.pressure_weights) @ nodal)
            patches.append(fine.A @ forces[s][0])
        assert relative(np.concatenate(found), np.concatenate(patches) + body) < 2e-3

    def test_what_has_no_field_is_refused(self, case):
        setup, meshes, _, forces, _, _, _ = case
        beyond = small_screw(2, 0.2, load_at=0.19)
        with pytest.raises(ValueError, match="190 mm"):
            recovered.nodal_displacements_of_screw(setup, meshes.screw_mesh, forces, beyond)
        with pytest.raises(ValueError, match="carries a force of 0 N"):
            recovered.pressure_from_nodal_forces(
                setup.scene, setup.groove_map, 0, setup.patches_by_flank[0].groove_patch, 0.0 * forces[0][0]
            )
        with pytest.raises(ValueError, match="ball 1 carries no load"):
            recovered.contact_pressures_of_ball(setup.scene, setup.mesh_settings, 0, np.zeros(4), np.zeros(4))

    def test_stress_fades_away_from_the_contact(self, case):
        setup, meshes, _, _, u, fields, _ = case
        coarse = recovered.stress_field_near_ball(setup, meshes.screw_mesh, u[0], 0, setup.scene.screw.material, 6e-3)
        assert 0.0 < coarse.von_mises.max() < 0.2 * fields[0].von_mises.max()


class TestPressure:
    @pytest.mark.parametrize("side", SIDES)
    def test_adds_up_to_the_load_and_is_near_hertz(self, case, side):
        setup, _, result, forces, _, _, _ = case
        found = recovered.pressure_from_nodal_forces(
            setup.scene, setup.groove_map, side, setup.patches_by_flank[side].groove_patch, forces[side][0]
        )
        assert found.pressure @ found.nodal_areas == pytest.approx(forces[side][0].sum(), rel=1e-12)
        assert found.load == pytest.approx(result.contact_loads[0, side], rel=1e-4)
        assert found.load == pytest.approx(found.pressure @ found.nodal_areas, rel=0.02)  # normals turn over the ellipse
        assert found.pressure.max() == pytest.approx(found.hertz_solution.pole_pressure, rel=0.10)

    def test_largest_stress_below_the_contact_is_near_hertz(self, case):
        setup, _, _, forces, _, fields, ball = case
        for s in SIDES:
            h = recovered.pressure_from_nodal_forces(
                setup.scene, setup.groove_map, s, setup.patches_by_flank[s].groove_patch, forces[s][0]
            ).hertz_solution
            depth = np.linspace(0.2, 1.6, 57) * min(h.semi_x, h.semi_y)
            expected = float(recovered.von_mises_below_hertz_contact(h, depth, 0.28).max())
            assert 0.55 * h.pole_pressure < expected < 0.65 * h.pole_pressure
            for piece in (fields[s], ball[s]):
                assert piece.von_mises.max() == pytest.approx(expected, rel=0.10)

    def test_curvatures_are_those_of_the_grid_on_the_screw(self):
        scene = small_screw()
        m = GrooveMap.from_scene(scene)
        across, along = m.relative_curvature_radii(0, m.beta)
        assert across == pytest.approx(1.0 / (1.0 / 2.778e-3 - 1.0 / 3.254e-3))
        assert along < scene.balls.radius < m.relative_curvature_radii(3, m.beta)[1]

    def test_ball_pressed_on_two_sides_as_in_the_whole_model(self, case):
        """On cells that grow faster outside the contact zone, of fewer modes."""
        setup, _, result, forces, _, _, _ = case
        settings = replace(setup.mesh_settings, growth=2.5, ball_fine=1.2e-3, modes=12, ball_modes=12)
        found = recovered.contact_pressures_of_ball(
            setup.scene, settings, 0, result.contact_loads[0], result.contact_angles[0]
        )
        assert sorted(found) == list(SIDES)
        for s in SIDES:
            whole = recovered.pressure_from_nodal_forces(
                setup.scene, setup.groove_map, s, setup.patches_by_flank[s].groove_patch, forces[s][0]
            )
            assert found[s].load == pytest.approx(whole.load, rel=1e-4)
            assert found[s].pressure.max() == pytest.approx(whole.pressure.max(), rel=0.05)
