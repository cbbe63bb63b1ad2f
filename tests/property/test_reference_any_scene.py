"""The 3D reference takes any scene through one path: coarse meshes, few balls, the low-order model as a rough check."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from tests.helpers import ALL_BUT_AXIAL
from tests.property.survey_scenes import CASE, even, pressed, shortened, survey, tipped
from tests.slow import all_slow_but

from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.measure import load_error
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import with_conformity
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.levels import BALL
from rollbench.compare.reference.tasks import ReferenceTask, flanks_to_mesh, mesh_settings
from rollbench.compare.scenes import catalogue
from rollbench.hifi.bodies import coarse
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.settings import Settings, estimate_contacts_of_scene, round_up_lengths
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import mesh_and_condense_geometry
from rollbench.meshes.cache import Cache
from rollbench.meshes.fem import mesh_quality
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Balls, Load, Nut, Scene, Screw, Solid, Support, Track
from rollbench.meshes.sockets import points_in_box_at_azimuth_zero
from rollbench.meshes.solid import dimensions_of_3d_parts


def screw(R, lead, ball, groove, outer, nut, azimuths, force=300.0, **track):
    """A short screw held close to its nut; ``nut``: length and outer diameter."""
    middle, steel = nut[0] / 2.0 + 5e-3, CASE.screw.material
    return Scene(
        "any",
        "any",
        Track(R, lead, np.pi / 4, **track),
        Screw(2.0 * middle, outer, groove, steel),
        Nut(middle, nut[0], nut[1], groove, steel),
        Balls(ball, steel, azimuths),
        supports=(Support(0.0, ALL_BUT_AXIAL), Support(2.0 * middle, (("ux", 0.0), ("uy", 0.0)))),
        loads=(Load(0.0, (0.0, 0.0, force)),),
        solid=Solid(shaft=4e-3, shaft_diameter=outer),
    )


def left_handed(**solid):
    """Left hand, load the other way, uneven pattern, lead offset."""
    uneven = (-2.9, -2.4, -0.6, 0.4, 0.85, 2.6)
    left = screw(16.5e-3, 20e-3, 2.778e-3, 3.254e-3, 32e-3, (36e-3, 48e-3), uneven, force=-300.0, hand="left")
    held = replace(left.solid, nut_held="outer surface", **solid)
    return replace(left, errors=replace(left.errors, lead_offset=1.5e-6), solid=held)


TURNS = even(71, 3.75)[25:47:3]  # of 19 balls a turn every third: those of the next turn lie between
FEW = even(45, 2.5)[20:24]
ALL = {
    "turns that do not line up": screw(14.5e-3, 7e-3, 2e-3, 2.16e-3, 28e-3, (20e-3, 44e-3), TURNS),
    "another lead and section, two starts": screw(20e-3, 18e-3, 3e-3, 3.18e-3, 38.6e-3, (20e-3, 64e-3), FEW, starts=2),
    "left hand": left_handed(),
    "bearing of 9 balls, preload": catalogue.scene("bearing-9-preload"),
    "rigid nut": left_handed(nut="rigid"),
}
#: Those of one geometry but for the nut's elasticity go to one worker.
ONE_GEOMETRY = ("left hand", "rigid nut")
NAMES = [pytest.param(name, marks=pytest.mark.xdist_group("left hand")) if name in ONE_GEOMETRY else name for name in ALL]


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """What two scenes share (the flanks of the elastic and the rigid nut) is condensed once."""
    return Cache(tmp_path_factory.mktemp("cache"))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_any_scene_converges_in_balance_and_near_the_low_order_model(name, cache, monkeypatch):
    """Cells are as coarse as that allows; one mesh of each submodel will do."""
    monkeypatch.setattr(coarse, "REALISATIONS", 1)
    scene = ALL[name]
    ratio = scene.balls.radius / BALL
    contacts = estimate_contacts_of_scene(scene)
    few = {"b_over_h": 0.8, "cuts": (2, 2, 2), "own_cuts": (2, 2, 2), "modes": 6, "ball_modes": 8, "growth": 2.5}
    sizes = {"fine": 3e-3 * ratio, "coarse": 12e-3 * ratio, "ball_fine": 1e-3 * ratio, "ball_coarse": 2e-3 * ratio}
    sizes |= {"own_sizes": (3e-3 * ratio, 8e-3 * ratio), "own_ball_sizes": (1.2e-3 * ratio, 2.4e-3 * ratio)}
    sizes |= {"semi": round_up_lengths(contacts.typical_semi_axes()), "reach": round_up_lengths(contacts.largest_reach())}
    set_up = mesh_and_condense_geometry(scene, flanks_to_mesh(scene), Settings(**few, **sizes), cache=cache)
    result = solve_reference(set_up, scene)
    assert result.status == "converged"
    assert max(result.unbalanced_ball_force, result.unbalanced_shaft_force) < 1e-8
    assert abs(result.unbalanced_force_along_groove) < 1e-3
    low = run_model(scene, "lin", ModelOptions(estimate_beam_mesh_error=False))
    assert low.converged
    error = load_error(low.load, result.contact_loads)
    assert error.rms_percent < 4.0, error
    assert min(set_up.mesh_quality[k] for k in ("screw", "nut", "ball")) > 0.0
    assert set_up.mesh_quality["deviation"] < 1e-12 or scene.track.lead == 0.0


SURVEY = dict(survey())
#: Those of which a patch and its sockets are meshed in every run of the tests; all with `pytest -m survey`.
TIGHT = ("conformity 0.51", "conformity 0.515", "60 kN", "contact angle 20", "contact angle 70", "lead 5")
TIGHT += ("unseen-63x20", "unseen-four-point")


def sockets_of(scene, cuts):
    """Meshes of a scene shortened to two balls, with the sockets of the whole scene; its map and settings."""
    settings, sides = replace(mesh_settings([scene], 1), cuts=cuts), flanks_to_mesh(scene)
    (m, layout, dimensions), (m_whole, layout_whole, dimensions_whole) = (
        (GrooveMap.from_scene(s), ball_layout(s), dimensions_of_3d_parts(s)) for s in (shortened(scene), scene)
    )
    meshes = part_meshes.mesh_parts(shortened(scene), m, layout, dimensions, sides, settings)
    of_whole = scene, m_whole, layout_whole, sides, dimensions_whole, settings
    whole = part_meshes.choose_refinement_box_size(*of_whole)
    assert (meshes.socket_size.gamma, meshes.socket_size.edge_divisions) == (pytest.approx(whole.gamma, rel=0.15), cuts)
    return m, meshes, settings, sides


CUT = [(name, cuts) for name in ("lead 5", "conformity 0.515") for cuts in ((3, 3, 3), (4, 3, 4), (4, 4, 4), (6, 4, 6))]


@pytest.mark.parametrize(
    ("name", "cuts"), all_slow_but([("lead 5", (3, 3, 3))], [*((name, (2, 2, 2)) for name in TIGHT), *CUT]), ids=str
)
def test_patches_and_sockets_of_tight_scenes_are_meshed_however_they_are_cut(name, cuts):
    m, meshes, settings, sides = sockets_of(SURVEY[name], cuts)
    assert min(body.quality.smallest_jacobian for body in (meshes.screw_mesh, meshes.nut_mesh, meshes.ball_mesh)) > 0.0
    zone = part_meshes.choose_patch_cells(settings, meshes.half_widths, meshes.socket_size.depth)[1]
    assert zone[0] * meshes.half_widths[0] >= settings.reach[0]
    assert zone[1] * meshes.half_widths[1] >= settings.reach[1]
    for side in sides:
        size, body = meshes.socket_size, meshes.screw_mesh if side < 2 else meshes.nut_mesh
        in_groove = partial(points_in_box_at_azimuth_zero, m, size, side)
        in_ball = part_meshes.ball_refinement_box_and_map(m, size, side, meshes.relative_zone_size)[1]
        groove = part_meshes.mesh_patch(meshes, body.box_faces[side], in_groove, settings)
        ball = part_meshes.mesh_patch(meshes, meshes.ball_mesh.box_faces[side], in_ball, settings)
        assert min(mesh_quality(x.mesh).smallest_jacobian for x in (groove, ball)) > 0.1
        found = part_meshes.contact_normals_of_patch(ball, np.zeros(3))
        wanted = part_meshes.contact_normals_of_patch(groove, np.array([m.R, 0.0, 0.0]))
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_displaced_supports_widen_the_patches():
    assert mesh_settings([tipped()], 1).reach[0] > 1.3 * mesh_settings([CASE], 1).reach[0]


def test_what_does_not_fit_is_refused_before_anything_is_meshed(monkeypatch):
    for name in ("mesh_grooved_body", "mesh_ball_with_refinement_boxes"):
        monkeypatch.setattr(f"rollbench.hifi.meshing.part_meshes.{name}", lambda *_: pytest.fail("meshed"))
    with pytest.raises(SceneNotCoveredError) as refused:
        compute_reference_runs(ReferenceTask((pressed(with_conformity(CASE, 0.515), 4e9),), 1))
    words = str(refused.value)
    assert "no room for the contact ellipse" in words
    assert words.count(" mm (") == 2
    assert "lower the load" in words


@pytest.mark.slow
@pytest.mark.survey
@pytest.mark.parametrize("name", SURVEY)
def test_survey(name):
    """Level 1 converges in balance, within a time and memory that a machine of two cores has."""
    (run,) = compute_reference_runs(ReferenceTask((SURVEY[name],), 1))
    assert run.status == "converged"
    assert max(run.balance, run.screw_balance) < 1e-8
    low = run_model(SURVEY[name], "refined", ModelOptions(estimate_beam_mesh_error=False))
    assert load_error(low.load, run.load).rms_percent < 5.0
