"""Modelling uncertainty: what each variant changes, what counts, and how choices add."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from skfem import MeshHex
from tests.reference_records import run_of

from rollbench.compare.models import modelling
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import DEFAULT, run_model
from rollbench.compare.reference import levels
from rollbench.compare.reference.store import save_run
from rollbench.compare.scenes import catalogue
from rollbench.hifi.condensation import nut_freedoms_from_free_ones
from rollbench.meshes import parts, solid

CASE1 = catalogue.scene("lin-case1")


def loads(*first: float) -> np.ndarray:
    """Loads of 32 balls on SL and NR, 100 N but for the first few on SL."""
    out = np.zeros((32, 4))
    out[:, [0, 3]] = 100.0
    out[: len(first), 0] = first
    return out


def test_a_ring_is_held_by_the_nodes_in_it() -> None:
    mesh = MeshHex.init_tensor(np.linspace(17e-3, 24e-3, 15), np.array([0.0, 1e-6]), np.array([0.0, 0.05]))
    mesh = mesh.with_boundaries({"low end": lambda x: x[2] < 0.01, "high end": lambda x: x[2] > 0.04})
    body = SimpleNamespace(mesh=mesh, points=mesh.p.T)

    def held(where: str) -> list[int]:
        """Places of the nodes held, counted from the inside, on one side of the thin strip; z [mm] comes first."""
        dims = solid.dimensions_of_3d_parts(replace(CASE1, solid=parts.Solid(nut_held=where)))
        fixed = np.setdiff1d(np.arange(3 * len(body.points)), nut_freedoms_from_free_ones(body, dims).indices)
        x, y, z = body.points[np.unique(fixed // 3)].T
        assert fixed.size == 3 * x.size  # in all three directions
        assert np.unique(z).size == 1
        return [round(1e3 * z[0]), *np.sort(np.rint((x[y == 0.0] - 17e-3) / 0.5e-3).astype(int)).tolist()]

    assert held("left face") == [0, *range(15)]
    assert held("left face, outer half") == [0, *range(7, 15)]
    assert held("left face, inner half") == [0, *range(8)]
    assert held("right face, outer half") == [50, *range(7, 15)]
    with pytest.raises(ValueError, match="outer surface"):
        levels.fix_half_of_face("outer")(replace(CASE1, solid=parts.Solid(nut_held="outer surface")))


def test_the_dropped_twist_turns_supports_and_moves_no_load() -> None:
    """Axial force and torque of the beams are statically determinate, so the stretch turns as a whole."""
    scene = replace(CASE1, supports=(*CASE1.supports, parts.Support(0.8, (("ux", 0.0), ("uy", 0.0)))))
    turned = levels.with_supports_turned_by_coupling(scene)
    before, after = (dict(s.supports[0].fixed) for s in (scene, turned))
    assert {k for k in before if before[k] != after[k]} == {"rz"}
    core = 16.5e-3 - 3.254e-3
    flexibility = 1.0 / np.sqrt(210e9 * np.pi * core**2 * 210e9 / 2.56 * np.pi * core**4 / 2.0)
    assert after["rz"] == pytest.approx(levels.COUPLING * 5000.0 * 0.4 * flexibility, rel=1e-9)
    assert turned.supports[1] == scene.supports[1]
    options = ModelOptions(estimate_beam_mesh_error=False)
    a, b = (run_model(s, DEFAULT, options).load for s in (CASE1, levels.with_supports_turned_by_coupling(CASE1)))
    assert 0.0 < np.abs(a - b).max() < 2e-5 * a.max()


def test_choices_add_by_the_root_of_squares_contact_by_contact() -> None:
    effects = [
        modelling.effect_of_changed_choice("lin-case1", name, name, choice, kind, loads(*to), loads())
        for name, choice, kind, *to in (
            ("land", levels.LANDS, "modelling", 103.0, 100.0),
            ("land-wide", levels.LANDS, "modelling", 98.0, 101.0),
            ("hole", levels.HOLE, "modelling", 96.0, 100.0),
            ("nut-right", "nut", "scene", 150.0),
            ("modes", "modes", "numerical", 150.0),
        )
    ]
    found = modelling.combined_modelling_uncertainty(CASE1, effects)
    assert found.contacts[:2, 0] == pytest.approx([np.hypot(3.0, 4.0), 1.0])
    assert (found.largest, found.rms) == pytest.approx((5.0, np.sqrt((25.0 + 1.0) / 2.0)))
    assert found.ratio == pytest.approx(np.hypot(3.0612, 4.1667), rel=1e-3)  # 101/98 and 100/96
    assert list(found.choices) == [levels.HOLE, levels.LANDS]
    assert modelling.combined_modelling_uncertainty(catalogue.scene("lin-case3"), effects) is None
    assert modelling.applicable_modelling_uncertainty("lin-case2", {"lin-case1": found}) == found.largest
    assert modelling.applicable_modelling_uncertainty("lin-case3", {"lin-case1": found}) is None


def test_what_a_store_holds(tmp_path) -> None:
    assert modelling.effects_of_changed_choices(CASE1, (tmp_path,)) == []
    for variant, first in (("", 101.0), ("base", 100.0), ("junction", 102.0)):
        save_run(tmp_path, CASE1, run_of("lin-case1", 1, loads(first), variant))
    with pytest.raises(ValueError, match="did not converge"):
        save_run(tmp_path, CASE1, replace(run_of("lin-case1", 1, loads(110.0), "hole"), status="no"))
    found = {e.variant: e for e in modelling.effects_of_changed_choices(CASE1, (tmp_path,))}
    assert set(found) == {"base", "junction", "coupling"}  # what did not converge says nothing
    assert found["junction"].error.max_percent == pytest.approx(2.0)
    assert found["junction"].choice == levels.LENGTH
    assert found["base"].error.max_percent == pytest.approx(100.0 * 1.0 / loads(101.0)[:, [0, 3]].mean())
    assert found["coupling"].error.max_percent < 0.01
