"""The mean load that percentages are of."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.measure import load_error, mean_load
from rollbench.compare.models.set_results import ball_load_summary
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics import nominal, static
from rollbench.meshes.parts import BallErrors, Errors


def loads(stray=0.0):
    """32 balls on one diagonal, and a contact of the other that is barely touched."""
    found = np.zeros((32, 4))
    found[:, [0, 3]] = 358.0
    found[7, 1] = stray
    return found


def test_a_contact_that_is_barely_touched_moves_no_percentage():
    assert mean_load(loads()) == 358.0
    assert mean_load(loads(0.2)) == pytest.approx(358.0 + 0.2 / 64, rel=1e-12)
    said = ball_load_summary(loads(0.2))
    assert [said.mean, said.loaded_contacts, said.contacts_in_mean] == [mean_load(loads(0.2)), 65, 64]
    value = loads()
    value[3, 0] = 365.0
    errors = [load_error(value, reference).max_percent for reference in (loads(), loads(0.2))]
    assert errors[1] == pytest.approx(errors[0], rel=1e-4)


@pytest.mark.parametrize(("name", "contacts", "loaded"), [("lin-pitch-2p1", 64, 76), ("lin-roundness-4p1", 142, 146)])
def test_the_mean_is_over_the_contacts_that_the_screw_without_errors_loads(name, contacts, loaded):
    """One number for a scene and all its specimens: errors load further contacts, or leave some without load."""
    scene = catalogue.scene(name)
    assert nominal.count_nominal_contacts(scene) == contacts
    load = static.solve_static(scene).load
    assert np.count_nonzero(load) == loaded
    assert mean_load(load, contacts) == pytest.approx(load.sum() / contacts, rel=1e-12)
    said = ball_load_summary(load, contacts)
    assert (said.mean, said.contacts_in_mean) == (mean_load(load, contacts), contacts)
    value = load + load.max() * (load == load.max())
    assert load_error(value, load, contacts).max_percent == pytest.approx(100.0 * load.max() * contacts / load.sum())


def test_preload_is_no_error_and_a_screw_that_only_errors_press_is_counted_by_its_loads():
    preloaded = catalogue.scene("lin-case3")
    assert nominal.count_nominal_contacts(preloaded) == 128
    bare = replace(preloaded, loads=(), errors=Errors(balls=BallErrors(sigma=2e-6)))
    assert nominal.count_nominal_contacts(bare) == 0
    assert mean_load(loads(0.2), 0) == mean_load(loads(0.2))


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_contacts_that_bear_little_count_and_the_mean_is_as_small_as_they_are(scale):
    assert mean_load(np.zeros((3, 4))) == mean_load(np.zeros(0)) == 0.0
    few = np.array([[100.0, 0.0, 0.0, 100.0], [2.0, 0.0, 0.5, 2.0]])
    assert mean_load(scale * few) == pytest.approx(scale * 204.5 / 4.0, rel=1e-12)
    assert mean_load(scale * few, 5) == pytest.approx(scale * 204.5 / 5.0, rel=1e-12)
