"""What the mesh leaves uncertain in contact loads: every part found again in loads made of it, and kept records."""

import numpy as np
import pytest

from rollbench.compare.reference import estimate
from rollbench.compare.reference.levels import LEVELS

KNOWN = estimate.UncertaintyFromOtherScenes(0.02, 0.015, (0.11, 0.23), ("a", "b"))
MANY = 4000


def drawn_loads(seed, levels, contact=0.0, bodies=0.0, sockets=0.0, *, shift=0.0, both=False) -> dict[int, np.ndarray]:
    """Loads around 100 N on levels whose errors have these standard deviations [N] at the size of level 3, independent
    from level to level; every level's mean is shifted by a draw of ``shift``."""
    rng, out = np.random.default_rng(seed), {}
    for k in levels:
        h_contact, h_bodies = LEVELS[3]["b_over_h"] / LEVELS[k]["b_over_h"], LEVELS[k]["fine"] / LEVELS[3]["fine"]
        spread = np.sqrt((contact * h_contact**2) ** 2 + (bodies * h_bodies**2) ** 2 + sockets**2)
        on = [0, 1, 2, 3] if both else [0, 3]
        out[k] = np.zeros((MANY, 4))
        out[k][:, on] = 100.0 + spread * rng.normal(size=(MANY, len(on))) + shift * rng.normal()
    return out


@pytest.mark.parametrize(("contact", "bodies"), [(0.05, 0.0), (0.0, 0.04), (0.06, 0.05)])
def test_parts_of_the_own_levels_are_found(contact: float, bodies: float) -> None:
    found = estimate.mesh_uncertainty(drawn_loads(1, (1, 2, 3), contact, bodies, 0.02), KNOWN)
    h = [LEVELS[3][key] / LEVELS[4][key] for key in ("b_over_h", "fine")]
    assert found.contact_cell_deviation == pytest.approx(contact * np.sqrt(1.0 + h[0] ** 4), abs=0.015)
    assert found.body_cell_deviation == pytest.approx(bodies * np.sqrt(1.0 + h[1] ** -4), abs=0.015)
    assert found.refinement_box_deviation == pytest.approx(0.02 * np.sqrt(2.0))
    assert found.common_deviation == 0.0
    parts = found.contact_cell_deviation, found.body_cell_deviation, found.refinement_box_deviation
    assert found.uncertainty == pytest.approx(estimate.COVER * np.linalg.norm(parts))
    assert not found.is_from_other_scenes


def test_the_bar_holds_95_per_cent_of_the_next_level() -> None:
    loads = drawn_loads(2, (1, 2, 3, 4), 0.06, 0.03, 0.02)
    bars = estimate.mesh_uncertainty({k: loads[k] for k in (1, 2, 3)}, KNOWN).uncertainties_of_loads(loads)
    held = np.abs(loads[4] - loads[3]) <= bars
    assert np.mean(held[estimate.is_loaded_on_any_level(loads)]) == pytest.approx(0.955, abs=0.012)


def test_displacements_become_loads_by_the_stiffness_of_a_contact() -> None:
    """Parts of bodies and sockets go as the cube root of the load, the others are alike; their mean square stays."""
    loads = drawn_loads(8, (1, 2, 3), 0.0, 0.05, 0.0, both=True)
    for load in loads.values():
        load[:, :2] *= 8.0
    found = estimate.mesh_uncertainty(loads, estimate.UncertaintyFromOtherScenes(0.02, 0.0, (0.1, 0.2), ()))
    bars = found.uncertainties_of_loads(loads)
    assert np.sqrt((bars**2).mean()) == pytest.approx(found.uncertainty)
    of_bodies = bars**2 - (2.0 * found.contact_cell_deviation) ** 2
    assert np.sqrt(of_bodies[:, 0].mean() / of_bodies[:, 3].mean()) == pytest.approx(2.0, rel=1e-3)
    for load in loads.values():
        load[0] = 0.0
    assert (found.uncertainties_of_loads(loads)[0] == 0.0).all()
    single = {1: loads[1]}
    assert set(estimate.mesh_uncertainty(single, KNOWN).uncertainties_of_loads(single).ravel()) == {0.0, 0.23}


def test_a_part_that_all_contacts_share_counts_where_equilibrium_does_not_hold_the_sum() -> None:
    one, both = (
        estimate.mesh_uncertainty(drawn_loads(4, (1, 2, 3), 0.05, 0.03, 0.02, both=b), KNOWN) for b in (False, True)
    )
    assert (one.common_deviation, both.common_deviation) == (0.0, pytest.approx(0.015 * np.sqrt(2.0)))
    assert both.uncertainty > one.uncertainty


def test_a_single_level_has_the_bar_of_experience_by_the_flanks_that_carry_load() -> None:
    one, both = (estimate.mesh_uncertainty(drawn_loads(5, (1,), 0.0, 0.0, 0.0, both=b), KNOWN) for b in (False, True))
    assert (one.uncertainty, both.uncertainty) == KNOWN.single
    assert one.is_from_other_scenes
    assert estimate.has_both_flanks_loaded(drawn_loads(5, (1,), 0.0, 0.0, 0.0, both=True)[1])
    assert estimate.mesh_uncertainty({1: np.zeros((2, 4)), 2: np.zeros((2, 4))}, KNOWN).uncertainty == 0.0


def test_experience_is_measured_and_kept(tmp_path) -> None:
    """The common part from mean changes between fine levels of scenes with both flanks loaded; single from level 1, as
    large as the scene needs whose contacts scatter most."""
    scenes = {f"both {k}": drawn_loads(k, (1, 2, 3, 4), 0.05, 0.0, 0.0, shift=0.03, both=True) for k in range(60)}
    for loads in scenes.values():
        loads[2] += 1.0 * (loads[2] > 0.0)  # the common part is that of fine levels
    scenes |= {"one": drawn_loads(90, (1, 2, 3), 0.04, 0.0, 0.0, shift=5.0)}
    found = estimate.derive_uncertainty_of_other_scenes(scenes, 0.02)
    assert (found.common, found.sockets) == (pytest.approx(0.03, rel=0.25), 0.02)
    h = (LEVELS[3]["b_over_h"] / LEVELS[1]["b_over_h"]) ** 2
    spread = np.sqrt((0.05 * h) ** 2 + 0.05**2 * (LEVELS[3]["b_over_h"] / LEVELS[4]["b_over_h"]) ** 4 + 2.0 * 0.03**2)
    assert 1.96 * spread < found.single[1] < 3.0 * spread
    wide = scenes | {"wide": drawn_loads(91, (1, 2, 3), 0.4, 0.0, 0.0, both=True)}
    assert estimate.derive_uncertainty_of_other_scenes(wide, 0.02).single[1] > 3.0 * found.single[1]
    known = estimate.derive_uncertainty_of_other_scenes(wide, 0.02, {"wide": np.full(wide["wide"][1].shape, 5.0)})
    assert known.single[1] == pytest.approx(found.single[1], rel=0.05)
    assert found.scenes == tuple(scenes)
    estimate.save_uncertainty_of_other_scenes(tmp_path, found)
    assert estimate.read_uncertainty_of_other_scenes(tmp_path) == found
    with pytest.raises(ValueError, match="a single flank of the screw is loaded, and one in which both are"):
        estimate.derive_uncertainty_of_other_scenes({"one": scenes["one"]}, 0.02)
