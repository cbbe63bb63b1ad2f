"""A stretch of screw between beams: against one beam model of the whole screw, and against statics."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.shaft import mounting
from rollbench.hifi.shaft.beam import beam_stiffness, round_section
from rollbench.hifi.shaft.section import flexibility_of_lower_cut_end, flexibility_of_upper_cut_end
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import FREEDOMS, Load, Support

CASE = catalogue.scene("lin-case1")
CLAMPED = tuple((f, 0.0) for f in FREEDOMS)
SECTION = round_section(15e-3, 210e9, 0.28)
STATIONS = np.array([0.36, 0.39, 0.42, 0.43])
LOW, HIGH = 0.35, 0.45


def stretch(ports=(HIGH,), observers=(0.4,)):
    """A stretch that is itself a beam; every contact has the six motions of its section as modes."""
    empty = mounting.MeshedShaftPart(np.zeros((0, 0)), np.zeros((0, 6)), LOW, ports, observers, (LOW, HIGH), 0)
    return mounting.replace_shaft_part_by_beam(np.broadcast_to(np.eye(6), (4, 6, 6)), STATIONS, empty, SECTION)


def whole_beam(scene, stations):
    """Compliance at ``stations`` and their motion by loads and prescribed values, from one beam of all nodes."""
    given = [x.at for x in (*scene.supports, *scene.loads)]
    nodes = sorted({LOW, HIGH, 0.4, *given, *stations})
    place = {z: 6 * k for k, z in enumerate(nodes)}
    K, P = np.zeros((6 * len(nodes),) * 2), np.zeros(6 * len(nodes))
    for a, b in pairwise(nodes):
        dof = np.r_[place[a] : place[a] + 6, place[b] : place[b] + 6]
        K[np.ix_(dof, dof)] += beam_stiffness(b - a, SECTION)
    for load in scene.loads:
        P[place[load.at] : place[load.at] + 6] += [*load.force, *load.moment]
    fixed = [place[x.at] + FREEDOMS.index(f) for x in scene.supports for f, _ in x.fixed]
    values = np.array([v for x in scene.supports for _, v in x.fixed])
    free = np.setdiff1d(np.arange(len(K)), fixed)
    F = np.zeros_like(K)
    F[np.ix_(free, free)] = np.linalg.inv(K[np.ix_(free, free)])
    U = F @ (P - K[:, fixed] @ values)
    U[fixed] = values
    pick = np.concatenate([np.arange(place[z], place[z] + 6) for z in stations])
    return F[np.ix_(pick, pick)], U[pick]


def close(found, wanted, scale=1e-9):
    np.testing.assert_allclose(found, wanted, rtol=0, atol=scale * np.abs(wanted).max())


SCENES = {
    "clamped left, guided right": (
        (Support(0.0, CLAMPED), Support(0.8, (("ux", 3e-4), ("uy", 0.0)))),
        (Load(0.6, (0.0, 100.0, 0.0)), Load(0.8, (0.0, 0.0, 5e3), (1.0, 2.0, 3.0))),
    ),
    "both ends clamped": (tuple(Support(z, CLAMPED) for z in (0.0, 0.8)), (Load(0.1, (50.0, 0.0, 7.0)),)),
    "the stretch is the screw's end": ((Support(HIGH, CLAMPED),), (Load(LOW, (10.0, -20.0, 30.0)),)),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_stretch_that_is_a_beam_answers_like_the_whole_beam(name):
    supports, loads = SCENES[name]
    scene = replace(CASE, supports=supports, loads=loads)
    found = mounting.support_shaft_part(stretch(), scene, SECTION)
    nodes = [*found.centreline_positions]
    n = 6 * len(nodes)
    G, U = whole_beam(scene, nodes + STATIONS.tolist())
    scale = np.tile(np.r_[np.ones(3), np.full(3, 0.016)], 4)
    close(found.G * np.outer(scale, scale), G[n:, n:] * np.outer(scale, scale))
    close(found.mode_displacements_by_loads * scale, U[n:] * scale, 1e-8)
    assert found.free_motions.shape == (6, 0)
    translations = np.arange(n).reshape(-1, 6)[:, :3].ravel()
    close(found.centreline_by_loads[:, :3].ravel(), U[translations], 1e-8)
    by_modes = found.centreline_by_modal_forces.reshape(n, -1)
    close(by_modes[translations][:, ::6], G[translations, n::6], 1e-8)


def test_a_station_inside_the_stretch_has_a_port():
    scene = replace(CASE, supports=(Support(0.0, CLAMPED),), loads=(Load(0.4, (1e3, 0.0, 0.0)),))
    with pytest.raises(ValueError, match="400 mm lies inside"):
        mounting.support_shaft_part(stretch(), scene, SECTION)
    found = mounting.support_shaft_part(stretch(ports=(HIGH, 0.4)), scene, SECTION)
    close(found.mode_displacements_by_loads, whole_beam(scene, STATIONS.tolist())[1], 1e-8)


def test_an_unheld_screw_moves_rigidly_and_its_loads_do_work():
    scene = replace(CASE, supports=(Support(0.0, (("rz", 0.0),)),), loads=(Load(0.8, (0.0, 4.0, 9.0)),))
    found = mounting.support_shaft_part(stretch(), scene, SECTION)
    assert np.linalg.matrix_rank(found.free_motions) == found.free_motions.shape[1] == 5
    arm = 0.8 - found.origin_position
    wrench = np.array([0.0, 4.0, 9.0, -4.0 * arm, 0.0, 0.0])
    np.testing.assert_allclose(found.work_on_free_motions, found.free_motions.T @ wrench, atol=1e-12)
    held = [rigid_motion_transfer_along_z(0.0 - found.origin_position)[5]]
    np.testing.assert_allclose(held @ found.free_motions, 0.0, atol=1e-15)


def test_a_ring_on_a_stiff_shaft_follows_its_bore():
    F = np.diag(np.full(6, 1e-9))
    ring = mounting.MeshedShaftPart(F, np.eye(6), 0.4, (), (), (0.39, 0.41), 6, moves_with_base=True)
    fixed = tuple(zip(FREEDOMS, (1e-6, 0.0, 0.0, 0.0, 2e-3, 0.0), strict=True))
    scene = replace(CASE, supports=(Support(0.45, fixed),), loads=())
    found = mounting.support_shaft_part(ring, scene, SECTION)
    np.testing.assert_allclose(found.G, F)
    moved = [1e-6 - 0.05 * 2e-3, 0.0, 0.0, 0.0, 2e-3, 0.0]
    np.testing.assert_allclose(found.mode_displacements_by_loads, moved, atol=1e-15)


@pytest.mark.parametrize("ends", [0.0, 1e-9])
def test_a_mesh_that_is_too_stiff_is_made_as_stiff_as_its_section(ends):
    """A beam of another section, with cuts that yield at its ends: the right beam, and the cuts as they were."""
    m, rows, cut = GrooveMap.from_scene(CASE), np.broadcast_to(np.eye(6), (4, 6, 6)), ends * np.eye(6)
    stiff = replace(SECTION, EA=1.02 * SECTION.EA, EI=1.013 * SECTION.EI, GJ=1.008 * SECTION.GJ)

    def with_cuts(section):
        beam = mounting.replace_shaft_part_by_beam(rows, STATIONS, stretch(), section)
        F = beam.F + beam.B @ flexibility_of_lower_cut_end(cut, m, LOW) @ beam.B.T
        end = slice(beam.mode_count, beam.mode_count + 6)
        F[end, end] += flexibility_of_upper_cut_end(cut, m, HIGH)
        return replace(beam, F=F)

    found, wanted = mounting.correct_beam_stiffness(with_cuts(stiff), rows, STATIONS, SECTION, cut, m), with_cuts(SECTION)
    assert np.abs(with_cuts(stiff).F - wanted.F).max() > 5e-3 * np.abs(wanted.F).max()
    close(found.F, wanted.F)
