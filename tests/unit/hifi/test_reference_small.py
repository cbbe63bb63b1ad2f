"""The 3D reference on two balls: condensation against the whole mesh, statics, symmetry."""

import json
import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import block_diag

from rollbench.comparison.scenes import catalogue
from rollbench.hifi import condensed, contact_kinematics, coupling, reference, setup
from rollbench.hifi.bodies import grid_wave, submodel
from rollbench.hifi.bodies.coarse import freedoms, isostatic
from rollbench.hifi.bodies.patch import hat_rows
from rollbench.hifi.condensation import responses
from rollbench.hifi.condensation.side_by_side import Part, make
from rollbench.hifi.contact import balls
from rollbench.hifi.contact.balls import State, solve_balls
from rollbench.hifi.contact.compliance import uncoupled
from rollbench.hifi.elements.assembly import assemble
from rollbench.hifi.elements.forms import elasticity
from rollbench.hifi.elements.pressures import mean_weights
from rollbench.hifi.linear_algebra.response import compliance
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.fit import ball_place
from rollbench.hifi.meshing.part_meshes import placed
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.cache import Cache, key_of
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FourierTerm, Load, SideErrors, Support
from rollbench.meshes.sockets import local_points
from rollbench.meshes.solid import dimensions

pytestmark = pytest.mark.xdist_group("helped by processes")

SMALL = Settings(
    b_over_h=0.8,
    semi=(0.5e-3, 0.14e-3),
    reach=(0.5e-3, 0.14e-3),
    fine=3e-3,
    coarse=12e-3,
    ball_fine=1e-3,
    ball_coarse=2e-3,
    cell=9e-3,
    modes=10**6,
    ball_modes=10**6,
    own_cuts=(3, 2, 3),
    own_sizes=(2e-3, 8e-3),
    own_ball_sizes=(0.9e-3, 1.8e-3),
)


def two_balls(**changes):
    """Two balls side by side in a short nut, the screw held on both sides close to it."""
    s = catalogue.scene("lin-case1")
    scene = replace(
        s,
        nut=replace(s.nut, position=30e-3, length=16e-3),
        screw=replace(s.screw, length=60e-3),
        supports=(s.supports[0], Support(60e-3, (("ux", 0.0), ("uy", 0.0)))),
        balls=replace(s.balls, azimuths=(-0.35, 0.3)),
        loads=(Load(0.0, (0.0, 0.0, 400.0)),),
        solid=replace(s.solid, shaft=6e-3, shaft_diameter=30e-3),
    )
    return replace(scene, **changes)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return Cache(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="module")
def small(cache):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(submodel, "REALISATIONS", 1)
        return setup.prepare(two_balls(), (0, 3), SMALL, cache=cache)


@pytest.fixture(scope="module")
def meshes(small):
    return part_meshes.mesh_parts(small.scene, small.map, small.layout, small.dims, small.sides, SMALL)


def whole(body, patches, material, reduce):
    """Compliance of the hats from one mesh of the body and all its patches, tied node by node.

    patches: (mesh, rows of the hats, socket's nodes, rotation); reduce: (freedoms of the body) -> what holds it.
    """
    E, nu = material.youngs_modulus, material.poissons_ratio
    blocks, columns, loads = [assemble(elasticity(E, nu), body)], [], []
    size = body.doflocs.size
    inner_of = [np.setdiff1d(np.arange(len(p.points)), p.interface) for p, *_ in patches]
    total = size + 3 * sum(len(i) for i in inner_of)
    columns.append(sp.hstack([sp.identity(size), sp.csr_matrix((size, total - size))]))
    start = size
    for (mesh, hats, nodes, R), inner in zip(patches, inner_of, strict=True):
        blocks.append(assemble(elasticity(E, nu), mesh.mesh))
        C = sp.lil_matrix((3 * len(mesh.points), total))
        C[freedoms(inner), start + np.arange(3 * len(inner))] = 1.0
        turn = sp.kron(sp.identity(len(nodes)), R.T)  # the body moves in space, the patch in its own frame
        C[np.ix_(freedoms(mesh.interface), freedoms(nodes))] = (sp.kron(mesh.tie, sp.identity(3)) @ turn).toarray()
        columns.append(C.tocsr())
        left, right = (sp.csr_matrix((hats.shape[0], n)) for n in (start, total - start - 3 * len(inner)))
        loads.append(sp.hstack([left, hats[:, freedoms(inner)], right]))
        start += 3 * len(inner)
    C = sp.vstack(columns).tocsr()
    K = (C.T @ sp.block_diag(blocks) @ C).tocsc()
    T = sp.block_diag([reduce(size), sp.identity(total - size)]).tocsc()
    return compliance((T.T @ K @ T).tocsc(), sp.vstack(loads) @ T)


def patch(small, meshes, side, *, ball=False):
    """The patch that is condensed with its socket, and the rows of the finer one's hats on it."""
    body = meshes.ball if ball else meshes.screw if side < 2 else meshes.nut
    place = (
        ball_place(small.map, meshes.size, side, meshes.zone)[1]
        if ball
        else (lambda xi: local_points(small.map, meshes.size, side, xi))
    )
    mesh = part_meshes.patch_mesh(meshes, body.sockets[side], place, SMALL)
    carrier = part_meshes.carrier_mesh(meshes, body.sockets[side], place, SMALL)
    centre = np.zeros(3) if ball else np.array([small.map.R, 0.0, 0.0])
    normals = (-1.0 if ball else 1.0) * part_meshes.patch_normals(mesh, centre)
    return carrier, hat_rows(mesh, normals, carrier)


def bodies(small, meshes):
    """Compliance of screw, nut and ball at their hats, each from one whole mesh."""
    places = {
        s: [(float(a), float(z), s) for a, z in zip(small.layout.azimuth, small.layout.z, strict=True)] for s in (0, 3)
    }
    out = {}
    for name, side, mesh, material in (
        ("screw", 0, meshes.screw, small.scene.screw.material),
        ("nut", 3, meshes.nut, small.scene.nut.material),
    ):
        own, hats = patch(small, meshes, side)
        parts = [(own, hats, s.nodes, s.rotation) for s in placed(mesh, tuple(places[side]))]
        if name == "screw":
            reduce = lambda _, m=mesh: responses.screw_transform(m, small.dims, small.dims.ends(small.scene)[1])  # noqa: E731
        else:
            reduce = lambda _, m=mesh: responses.nut_transform(m, small.dims)  # noqa: E731
        out[name] = whole(mesh.mesh, parts, material, reduce)
    parts = [(*patch(small, meshes, s, ball=True), meshes.ball.socket_nodes[s], np.eye(3)) for s in (0, 3)]
    held = isostatic(meshes.ball.points, np.concatenate([p[2] for p in parts]))
    out["ball"] = whole(
        meshes.ball.mesh,
        parts,
        small.scene.balls.material,
        lambda size: sp.identity(size, format="csc")[:, np.setdiff1d(np.arange(size), held)],
    )
    return out


def test_condensed_bodies_are_those_of_the_whole_mesh(small, meshes):
    found = bodies(small, meshes)
    A = {s: p.groove.A for s, p in small.patches.items()}
    V = {0: small.screw.modes[0], 3: small.nut.modes[3]}
    m = small.screw.stretch.modes
    for name, side, G in (("screw", 0, small.screw.stretch.F[:m, :m]), ("nut", 3, small.nut.G)):
        U = block_diag(V[side], V[side])
        wanted = block_diag(A[side], A[side]) + U @ G @ U.T
        np.testing.assert_allclose(found[name], wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())
    U = block_diag(*small.ball.modes.values())
    wanted = block_diag(*(p.ball.A for p in small.patches.values())) + U @ small.ball.G @ U.T
    np.testing.assert_allclose(found["ball"], wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())


def test_a_screw_without_its_3d_shaft_does_not_depend_on_which_flanks_bear(small):
    """The same bodies with their flanks named SR and NL."""
    named = {
        "screw": replace(small.screw, modes={1: small.screw.modes[0]}),
        "nut": replace(small.nut, modes={2: small.nut.modes[3]}),
    }
    other = replace(small, sides=(1, 2), **named)
    one, two = (coupling.mounted_screw(s, small.scene, frozenset({"3D shaft"})) for s in (small, other))
    np.testing.assert_array_equal(one.G, two.G)
    shaft = coupling.mounted_screw(small, small.scene).G
    assert one.G.shape == shaft.shape
    assert not np.allclose(one.G, shaft, rtol=1e-6, atol=0.0)


def test_contact_loads_are_those_of_the_whole_mesh(small, meshes):
    """Two balls, both bodies, same mesh, each contact's own compliance exchanged as submodels ask for, the grid's wave left
    in: loads with nothing condensed agree to 1e-10."""
    small = replace(small, patches={s: replace(pair, wave=None) for s, pair in small.patches.items()})
    found = bodies(small, meshes)
    sides = (0, 3)
    mounted = coupling.mounted_screw(small, small.scene)
    m = small.screw.stretch.modes
    C, rows = coupling.compliance_of((coupling.PlacedSet(small, small.scene, sides),), mounted)
    pick = np.flatnonzero(rows < m)
    # the beam to the support is not meshed: its share of the screw's compliance comes on top
    beam = np.zeros((C.coupling.shape[0],) * 2)
    beam[np.ix_(pick, pick)] = (mounted.G - small.screw.stretch.F[:m, :m])[np.ix_(rows[pick], rows[pick])]
    n = [len(small.patches[s].groove.A) for s in sides]
    U = np.zeros((2 * sum(n), len(beam)))
    for i, (V, c) in enumerate(zip(C.modes, C.columns, strict=True)):
        U[i * sum(n) : (i + 1) * sum(n), c] = V
    exchanged = block_diag(*(small.patches[s].own - small.patches[s].groove.A - small.patches[s].ball.A for s in sides))
    dense = U @ beam @ U.T + block_diag(*2 * [found["ball"] + exchanged])
    for name, part in (("screw", slice(0, n[0])), ("nut", slice(n[0], sum(n)))):
        own = np.concatenate([i * sum(n) + np.arange(sum(n))[part] for i in range(2)])
        dense[np.ix_(own, own)] += found[name]
    normals = np.concatenate([small.patches[s].groove.points - [small.map.R, 0, 0] for s in sides])
    length = np.linalg.norm(normals, axis=1)
    mean = sp.block_diag([mean_weights(small.patches[s].groove.weights) for s in sides])
    gap = np.tile(mean @ (length - small.map.ball), 2)
    directions = np.broadcast_to(normals / length[:, None], (2, sum(n), 3))
    zones = coupling.zones_of(small, sides)
    by_screw = contact_kinematics.rigid_rows(small, directions, zones, mounted.origin, screw=True).reshape(-1, 6)
    by_screw = sp.block_diag([mean, mean]) @ by_screw
    directions = np.stack([mean @ d for d in directions])
    N = contact_kinematics.directions_matrix([directions], by_screw @ mounted.motions)
    f = np.concatenate([np.zeros(6), mounted.work])
    frozen = reference.solve_reference(small, small.scene, updates=0)
    start = State(np.zeros(0), frozen.contact.motions * 1.01)
    by_loads = np.zeros(rows.size)
    by_loads[pick] = mounted.loads[rows[pick]]
    at_rest = coupling.modal_motion(C, by_loads)
    other, _ = solve_balls(uncoupled(dense), gap + at_rest, N, f, start=start, tolerance=1e-12)
    assert other.converged
    assert frozen.status == "converged"
    largest = frozen.contact.forces.max()
    np.testing.assert_allclose(other.forces, frozen.contact.forces, rtol=0, atol=1e-10 * largest)


def test_balance_and_no_force_along_the_groove(small):
    result = reference.solve_reference(small, small.scene)
    assert result.status == "converged"
    assert result.balance < 1e-8
    assert abs(result.along_groove) < 1e-3
    assert result.screw_balance < 1e-8
    m = small.map
    axial = result.load[:, 0] @ np.sin(result.contact_angle[:, 0]) * np.cos(m.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)
    assert (result.load[:, [1, 2]] == 0.0).all()


def test_a_helical_motion_of_the_screw_changes_no_load(small):
    """A screw that is turned by 2 mrad and free to follow its lead; by linear kinematics its radius would grow by 33 nm."""
    at_rest = reference.solve_reference(small, small.scene)
    first = small.scene.supports[0]
    held = tuple((name, 2e-3 if name == "rz" else value) for name, value in first.fixed)
    turned = replace(small.scene, supports=(replace(first, fixed=held), *small.scene.supports[1:]))
    result = reference.solve_reference(small, turned)
    assert result.status == "converged"
    assert result.updates <= 5  # by the middle of the pressures, which sticks to so few nodes, it were 12
    np.testing.assert_allclose(result.load, at_rest.load, rtol=0, atol=1e-4 * at_rest.load.max())
    across = np.nan_to_num(result.contact_angle - at_rest.contact_angle)
    assert np.abs(across).max() < 1e-4  # a straight step along a curved track: 16 um leave 8 nm of its section
    axial = result.load[:, 0] @ np.sin(result.contact_angle[:, 0]) * np.cos(small.map.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)


def test_loads_that_did_not_settle_say_what_they_may_still_move_by(small):
    """Places of the balls are solved with the loads, so that few rounds settle these."""
    turned = replace(
        small.scene, supports=(Support(0.0, small.scene.supports[0].fixed), Support(60e-3, (("ux", 5e-6), ("uy", 0.0))))
    )
    whole = reference.solve_reference(small, turned)
    assert (whole.status, whole.moving) == ("converged", 0.0)
    assert whole.updates <= 3
    few = reference.solve_reference(small, turned, updates=1)
    assert few.status.startswith("not settled: loads may still move by")
    assert 0.0 < np.abs(few.load - whole.load).max() <= few.moving < np.inf


#: `two_balls` as a file, with one end of the screw displaced.
TWO_BALLS = """title = "two balls"
[material]
youngs_modulus = "210 GPa"
poissons_ratio = 0.28
[track]
pitch_radius = "16.5 mm"
lead = "20 mm"
contact_angle = "45 deg"
[screw]
length = "60 mm"
outer_diameter = "32 mm"
groove_radius = "3.254 mm"
[nut]
position = "30 mm"
length = "16 mm"
outer_diameter = "48 mm"
groove_radius = "3.254 mm"
[balls]
radius = "2.778 mm"
azimuths = ["-0.35 rad", "0.3 rad"]
[solid]
shaft = "6 mm"
shaft_diameter = "30 mm"
[[supports]]
at = "0 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]
[[supports]]
at = "60 mm"
fix = ["uy"]
displace = { ux = "5 um" }
[[loads]]
at = "0 mm"
force = ["0 N", "0 N", "400 N"]
"""


@pytest.mark.slow
def test_a_command_whose_reference_does_not_settle_says_so_keeps_it_and_ends_with_a_code_of_its_own(
    small, tmp_path, monkeypatch, command
):
    """One update of directions and gaps does not settle these loads."""
    file, store = tmp_path / "two.toml", tmp_path / "store"
    file.write_text(TWO_BALLS)
    monkeypatch.setattr(setup, "prepare", lambda *given, **_: replace(small, settings=given[2]))
    for updates, code in ((1, 5), (reference.ROUNDS, 0)):
        monkeypatch.setitem(reference.solve_reference.__kwdefaults__, "updates", updates)
        ended, found = command.json("compare", file, "--levels", "1", "--fresh", "--store", store, "--json")
        assert ended == code
        (said,) = found["scenes"]
        (kept,) = (json.loads(run.read_text()) for run in store.glob("two-level1-*.json"))
        load, told = np.array(kept["load"]), said["uncertainty"]["discretisation_percent"]
        may_move = 100.0 * kept["moving"] / load[load > 0.0].mean()
        if code:
            assert kept["status"].startswith("not settled: loads may still move by")
            assert said["reference_status"] == f"level 1 {kept['status']}"
            assert told >= may_move > 1.0
        else:
            assert (kept["status"], said["reference_status"], may_move) == ("converged", "converged", 0.0)
            assert told < 1.0


def test_what_is_left_is_the_rest_of_a_geometric_series():
    loads = [np.array([[10.0 - 4.0 * 0.25**k, 5.0]]) for k in range(4)]
    assert reference.left_over(loads[:3]) == pytest.approx(10.0 - loads[2][0, 0])
    assert reference.left_over(loads) == pytest.approx(10.0 - loads[3][0, 0])
    assert reference.left_over(loads[:2]) == pytest.approx(99.0 * 3.0)
    assert reference.left_over(loads[:1]) == np.inf
    assert reference.left_over([loads[0]] * 2) == 0.0


def test_two_opposite_balls_without_lead_carry_the_same(monkeypatch):
    """A ring free to tilt on two opposite balls: statics alone divides the load."""
    monkeypatch.setattr(submodel, "REALISATIONS", 1)
    s = catalogue.scene("bearing-9")
    scene = replace(
        s,
        balls=replace(s.balls, azimuths=(0.0, np.pi)),
        loads=(Load(8e-3, (0.0, 0.0, 600.0)),),
        supports=(Support(8e-3, (("uy", 0.0), ("rx", 0.0), ("rz", 0.0))),),
    )
    ratio = s.balls.radius / 2.778e-3
    settings = replace(
        SMALL,
        semi=(1.0e-3, 0.3e-3),
        reach=(1.0e-3, 0.3e-3),
        fine=3e-3 * ratio,
        coarse=12e-3 * ratio,
        ball_fine=1e-3 * ratio,
        ball_coarse=2e-3 * ratio,
        own_sizes=(3e-3 * ratio, 12e-3 * ratio),
        own_ball_sizes=(1e-3 * ratio, 2e-3 * ratio),
        modes=16,
        ball_modes=16,
    )
    made = setup.prepare(scene, (0, 3), settings)
    result = reference.solve_reference(made, scene)
    assert result.status == "converged"
    load = result.load[:, [0, 3]]
    assert np.ptp(load) < 1e-6 * load.mean()
    assert load.mean() * 2.0 * np.sin(result.contact_angle[0, 0]) == pytest.approx(600.0, rel=5e-3)


def test_what_is_left_out_changes_the_answer_and_a_wrong_name_is_refused(small):
    full = reference.solve_reference(small, small.scene)
    for name in reference.INGREDIENTS:
        other = reference.solve_reference(small, small.scene, leave_out=frozenset([name]))
        assert other.status == "converged"
        assert np.abs(other.load - full.load).max() > 1e-6 * full.load.max(), name
    with pytest.raises(ValueError, match="unknown"):
        reference.solve_reference(small, small.scene, leave_out=frozenset(["elastic ball"]))


def test_ball_errors_and_lost_contact(small):
    errors = replace(small.scene.errors, balls=replace(small.scene.errors.balls, listed=((1, -60e-6),)))
    lost = reference.solve_reference(small, replace(small.scene, errors=errors))
    assert lost.load[0, 0] == 0.0
    assert lost.load[1, 0] > 400.0
    assert np.isnan(lost.contact_angle[0, 0])


def test_a_lead_offset_is_the_pitch_error_of_the_nut_that_shifts_ball_2_alone(small):
    """The groove beyond the nut's centre, at ball 2, by 2 um; against a series that is zero at ball 1."""
    shift, errors = 2e-6, small.scene.errors
    first, second = small.layout.azimuth - small.scene.nut.azimuth
    a, b = np.linalg.solve([[np.sin(x), np.cos(x)] for x in (first, second)], [0.0, shift])
    pitch = SideErrors(pitch=(FourierTerm(1.0, sin=float(a), cos=float(b)),), pitch_along="axis")
    scenes = [
        replace(small.scene, errors=e) for e in (replace(errors, lead_offset=shift), replace(errors, NL=pitch, NR=pitch))
    ]
    found, wanted = (reference.solve_reference(small, s).load for s in scenes)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * wanted.max())
    assert abs(found - reference.solve_reference(small, small.scene).load).max() > 10.0


def test_a_prepared_geometry_comes_whole_from_the_cache(small, cache):
    """Also what depends on records that came from the cache themselves."""
    again = Cache(cache.root)
    found = setup.prepare(two_balls(), (0, 3), SMALL, cache=again)
    assert cache.hits == again.misses == 0
    assert cache.misses == again.hits > 5
    assert found.seconds == pytest.approx(small.seconds, rel=0.1), (
        "the seconds that its stages took when they were made, not those of reading"
    )
    assert min(found.seconds.values()) > 0.0
    np.testing.assert_array_equal(found.ball.G, small.ball.G)
    np.testing.assert_array_equal(found.patches[0].own, small.patches[0].own)
    np.testing.assert_array_equal(found.screw.stretch.F, small.screw.stretch.F)


def test_own_approaches_of_condensed_bodies(small, monkeypatch):
    """Spread forces have unit resultants, the matrices' own force adds nothing, the place on the grid hardly matters.

    Cells are wider here than the ellipse is thick.
    """
    forces = {s: condensed.forces_of(small, s) for s in small.sides}
    spreads = {s: condensed.spread(small, s, float(np.median(f))) for s, f in forces.items()}
    for s, f in spreads.items():
        groove = small.patches[s].groove
        nodal = mean_weights(groove.weights).T @ f
        assert nodal @ (groove.normals @ grid_wave.contact_frame(small.map, s)[0]) == pytest.approx(1.0, rel=1e-12)
    found = condensed.condensed_bodies(small, 1)
    middle = np.array([float(np.median(f)) for f in forces.values()])
    own = {s: condensed.spread(small, s, x) for s, x in zip(small.sides, middle, strict=True)}
    np.testing.assert_allclose(condensed.rest_of(small, own), condensed.rest_of(small, spreads), rtol=1e-12)
    for k, s in enumerate(small.sides):
        loads = forces[s]
        assert found.force[k] == pytest.approx(loads, rel=1e-12)
        assert found.scatter(s) < 0.02  # cells are wider than the ellipse is thick: 1 % here, 0.1 % on level 1
        approach = condensed.patch_approaches(small, s, loads)
        assert np.all(np.diff(approach) > 0.0)
        # Hertz's 2/3, less what the held sockets take away
        assert 0.59 < np.log(approach[-1] / approach[0]) / np.log(loads[-1] / loads[0]) < 2 / 3
        with monkeypatch.context() as patch:
            patch.setattr(grid_wave, "MEAN", (12, 10))
            assert condensed.patch_approaches(small, s, loads) == pytest.approx(approach, rel=8e-3)


def test_a_long_solution_tells_its_rounds(small, monkeypatch):
    monkeypatch.setattr(reference, "SLOW", -1.0)
    heard = []
    found = reference.solve_reference(small, small.scene, step=heard.append)
    assert [line.split(", ")[0] for line in heard] == [
        f"contacts of {small.scene.name}: round {k + 1}" for k in range(found.updates + 1)
    ]


def test_frozen_loads_are_found_on_the_way_at_less_than_half_of_their_work(small, monkeypatch):
    """Both solutions have their first round in common, the one that begins from nothing."""
    work = {"factors": 0, "from nothing": 0}
    factor, solve = balls._System.factor, reference.solve_balls

    def factored(*given):
        work["factors"] += 1
        return factor(*given)

    def solved(*given, start, touching):
        work["from nothing"] += start is None
        return solve(*given, start=start, touching=touching)

    monkeypatch.setattr(balls._System, "factor", factored)
    monkeypatch.setattr(reference, "solve_balls", solved)
    moving = reference.solve_reference(small, small.scene)
    alone = work["factors"]
    still = reference.solve_reference(small, small.scene, updates=0)
    again = work["factors"] - alone
    assert work["from nothing"] == 2
    work.update(dict.fromkeys(work, 0))
    found = reference.solve_reference(small, small.scene, frozen=True)
    np.testing.assert_array_equal(found.load, moving.load)
    np.testing.assert_array_equal(found.frozen, still.load)
    assert np.abs(found.frozen - found.load).max() > 1e-6 * found.load.max()
    assert moving.frozen is None
    assert work["from nothing"] == 1
    assert 2 * (work["factors"] - alone) < again


def test_the_shaft_is_kept_whatever_nut_and_stations_are():
    """Its section costs a fifth of a coarse set-up, and depends on the screw alone."""

    def key(scene, stations, sizes=SMALL):
        m, layout, dims = (of(scene) for of in (GrooveMap.of, ball_layout, dimensions))
        none = SimpleNamespace(screw=None, nut=None, ball=None)
        part = setup._body_parts(scene, m, layout, dims, none, (0, 3), sizes, {}, stations)[0]
        assert part.stage == "shaft section"
        return key_of(part.build, part.arguments, part.type_)

    scene, ends = two_balls(), (0.0, 60e-3)
    known = key(scene, ends)
    thicker = replace(scene, nut=replace(scene.nut, outer_diameter=scene.nut.outer_diameter + 1e-3))
    assert key(thicker, ends) == known == key(scene, (0.0, 55e-3, 60e-3))
    other = replace(scene, screw=replace(scene.screw, bore=3e-3))
    assert len({known, key(other, ends), key(scene, ends, replace(SMALL, cell=8e-3)), key(scene, (30e-3,))}) == 4


def test_a_set_up_in_two_processes_is_the_same(small, cache, tmp_path):
    source_s_mesh = replace(SMALL, element="P1", tet=0.35e-3, modes=16, ball_modes=16)
    here = setup.prepare(small.scene, small.sides, source_s_mesh, cache=Cache(cache.root))
    made = setup.prepare(small.scene, small.sides, source_s_mesh, cache=Cache(tmp_path), processes=2)
    assert made.others_MB > 100.0
    assert list(made.seconds) == list(here.seconds)
    for s in small.sides:
        np.testing.assert_array_equal(made.patches[s].own, here.patches[s].own)
    assert made.nut is not None
    np.testing.assert_array_equal(made.nut.G, here.nut.G)
    np.testing.assert_array_equal(made.screw.stretch.F, here.screw.stretch.F)
    again = Cache(tmp_path)
    setup.prepare(small.scene, small.sides, source_s_mesh, cache=again)
    assert again.misses == 0


def test_a_process_that_is_ended_from_outside_is_a_lack_of_memory():
    ended = f"__import__('os')._exit(1) if __import__('os').getpid() != {os.getpid()} else __import__('time').sleep(1)"
    part = Part("any", eval, (ended,), type(None))
    with pytest.raises(MemoryError, match="ended from outside"):
        make([part, part], Cache(None), 2)


@pytest.mark.parametrize("processes", [1, 2])
def test_parts_are_told_as_they_are_made(processes):
    parts = [Part("any", eval, (text,), int) for text in ("1", "2", "(__import__('time').sleep(0.5), 1 // 0)[1]")]
    heard = {}
    with pytest.raises(ZeroDivisionError):
        make(parts, Cache(None), processes, lambda k, one: heard.update({k: one.value}))
    assert heard == {0: 1, 1: 2}


def test_parts_are_made_here_and_by_others_in_their_order():
    parts = [Part("any", eval, (f"({k}, __import__('time').sleep(0.5))[0]",), int) for k in range(4)]
    found = make(parts, Cache(None), 2)
    assert [one.value for one in found] == [0, 1, 2, 3]
    assert len({one.process for one in found}) == 2
    assert os.getpid() in {one.process for one in found}
    with pytest.raises(ZeroDivisionError):
        make([*parts, Part("any", eval, ("1 / 0",), int)], Cache(None), 2)
