"""Contacts at the rim of their patch: patches grow to what was found, only where that changes them, or say both numbers."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.reference.computing import BEYOND, settings_with_larger_patches
from rollbench.compare.reference.tasks import mesh_settings
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.survey import SEED, random_screw_scene_text
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.settings import estimate_contacts_of_scene, hertz_contacts_under_unit_force
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.solid import dimensions_of_3d_parts

CASE = catalogue.scene("lin-case1")


def prepared(scene=CASE, **changes):
    """What `enlarged` reads of a set-up."""
    return SimpleNamespace(
        scene=scene,
        groove_map=GrooveMap.from_scene(scene),
        ball_positions=ball_layout(scene),
        solid_dimensions=dimensions_of_3d_parts(scene),
        loaded_flanks=(0, 3),
        mesh_settings=replace(mesh_settings([scene], 1), **changes),
    )


def zone(settings, setup=None):
    """Half widths [m] of the contact zone across and along the groove."""
    setup = setup or prepared()
    m, layout, dims = setup.groove_map, setup.ball_positions, setup.solid_dimensions
    size = part_meshes.choose_refinement_box_size(setup.scene, m, layout, setup.loaded_flanks, dims, settings)
    widths = np.array([size.gamma * m.radius.mean(), size.phi * m.R])
    return part_meshes.choose_patch_cells(settings, tuple(widths), size.depth)[1] * widths


def found(factor):
    """The expected loads times a factor, at the nominal angles."""
    load = factor * estimate_contacts_of_scene(CASE).loads
    return load, np.where(load > 0.0, np.radians(45.0), np.nan)


@pytest.mark.parametrize("factor", [1.0, 3.0])
def test_patches_grow_to_the_loads_found(factor):
    setup = prepared()
    larger, words = settings_with_larger_patches(setup, [found(factor)], 2)
    assert larger is not None
    needs = factor ** (1.0 / 3.0) * estimate_contacts_of_scene(CASE).semi_axes_across.max()
    assert larger.reach[0] >= max(BEYOND * setup.mesh_settings.reach[0], needs) * (1.0 - 1e-12)
    assert np.max(zone(larger) / zone(setup.mesh_settings)) > 1.0
    assert f"need {1e3 * needs:.3g} mm across" in words


def test_a_patch_is_as_long_as_a_contact_that_its_lead_sets_askew():
    """A random screw 16x16: by its ellipse's semi-axes a contact is within the patch, askew by the lead it is not."""
    drawn = scene_file.scene_from_text(random_screw_scene_text(SEED, 85), "drawn.toml")
    setup = prepared(drawn)
    load = np.tile([31.35, 0.0, 0.0, 31.35], (drawn.ball_count, 1))
    run = load, np.where(load > 0.0, np.radians(48.6), np.nan)
    unit, m = hertz_contacts_under_unit_force(drawn)[0], setup.groove_map
    across, along = (np.cbrt(31.35) * x for x in (unit.semi_x, unit.semi_y))
    lead = float(np.hypot(across * np.cos(m.beta) * np.sin(m.alpha), along))
    larger, words = settings_with_larger_patches(setup, [run], 2)
    assert along < zone(setup.mesh_settings, setup)[1] < lead
    assert "skew contacts" in words
    assert lead < larger.reach[1] < 1.5 * lead
    assert larger.reach[1] < zone(larger, setup)[1]
    assert "skew contacts" not in settings_with_larger_patches(setup, [run], 5)[1], "that many steps would do"


def test_patches_that_fill_the_flank_are_not_built_again():
    larger, words = settings_with_larger_patches(prepared(reach=(1.568e-3, 0.2e-3)), [found(1.0)], 2)
    assert larger is None
    assert "a larger one is refused: no room for the contact ellipse" in words


def test_patches_grow_to_the_edge_where_a_whole_step_is_refused():
    setup = prepared(reach=(1.45e-3, 0.2e-3))
    larger, _ = settings_with_larger_patches(setup, [found(1.0)], 2)
    assert larger is not None
    assert zone(setup.mesh_settings)[0] < zone(larger)[0]
    assert 1.54e-3 < larger.reach[0] < 1.58e-3
