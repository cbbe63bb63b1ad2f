"""Sets of bearings by name: rows, preload of a set and a pair, conformity from a rigidity, starting torque, refusals."""

import numpy as np
import pytest
from tests import shipped_texts

from rollbench.compare.errors import InputError
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.axis_file import preload_of_arrangement
from rollbench.lowfi.bearings.angular_contact import BallBearing, bearing_with_contact_angle
from rollbench.lowfi.bearings.axis import HertzPowerLawRow, equal_rows_with_gap, solve_bearing_row_equilibrium
from rollbench.meshes.axis import ARRANGEMENTS, Assembly
from rollbench.meshes.parts import Scene

#: What a set by the rigidity of a pair says, and the conformities that it may say instead.
BY_RIGIDITY = (('pair_rigidity = "1030 N/um"', ""), ("# conf", "conf"), ("# conf", "conf"))


def changed(*pairs: tuple[str, str]) -> Assembly:
    found = scene_file.parse_scene(shipped_texts.changed("support-bearings", *pairs), "set.toml")
    assert isinstance(found, Assembly)
    return found


def row_of(found: Assembly) -> BallBearing:
    parts = found.sets[0].parts
    assert isinstance(parts, Scene)
    ball, steel = 2.0 * parts.balls.radius, parts.nut.material
    size = (ball, 2.0 * parts.track.pitch_radius, (parts.nut.groove_radius / ball,) * 2, parts.track.contact_angle)
    return bearing_with_contact_angle(parts.ball_count, *size, steel.youngs_modulus, steel.poissons_ratio)


@pytest.mark.parametrize("name", [name for name in ARRANGEMENTS if name != "DT"])
def test_preload_of_a_set_follows_from_that_of_a_pair(name: str) -> None:
    """Against the equilibrium of point contacts with equal gaps."""
    rows = tuple(1 if way == "+z" else -1 for way in ARRANGEMENTS[name])
    one = HertzPowerLawRow(1e10)
    loads = solve_bearing_row_equilibrium(equal_rows_with_gap(one, rows, one.deflection(2150.0))).row_thrusts
    assert preload_of_arrangement(name, 2150.0) == pytest.approx(loads[np.array(rows) == 1].sum(), rel=1e-9)


def test_rows_stand_side_by_side_and_share_the_preload() -> None:
    found = changed()
    assert [(s.name, s.thrust) for s in found.sets] == [("support 1", "-z"), ("support 2", "+z"), ("support 3", "+z")]
    assert [s.position for s in found.sets] == pytest.approx([0.035, 0.05, 0.065])
    total = preload_of_arrangement("DBD", 3350.0)
    assert [s.preload for s in found.sets] == pytest.approx([total, 0.5 * total, 0.5 * total])
    stated = changed(('pair_preload = "3350 N"', 'preload = "4500 N"'), *BY_RIGIDITY)
    assert [s.preload for s in stated.sets] == pytest.approx([4500.0, 2250.0, 2250.0])
    free = changed(('arrangement = "DBD"', 'arrangement = "DT"'), ('pair_preload = "3350 N"', ""), *BY_RIGIDITY)
    assert [(s.thrust, s.preload) for s in free.sets] == [("+z", 0.0)] * 2


def test_conformity_gives_the_rigidity_of_the_pair_back() -> None:
    found = changed()
    one = row_of(found)
    assert 2e-6 * one.stiffness(one.deflection(3350.0)) == pytest.approx(1030.0, rel=1e-6)
    assert any("from the rigidity of a pair, 1030 N/um at 3350 N" in text for text in found.assumed)


def test_a_solved_set_carries_its_preload_as_the_rows_alone_do() -> None:
    """The source's model, without the load; NSK's ratio of rigidities is 1.43."""
    found = changed(('force = ["0 N", "0 N", "2 kN"]', 'force = ["0 N", "0 N", "0 N"]'))
    result = run_model(found, "lin")
    assert result.converged
    total = preload_of_arrangement("DBD", 3350.0)
    assert [abs(s.force[2]) for s in result.sets] == pytest.approx([total, 0.5 * total, 0.5 * total], rel=1e-6)
    one = row_of(found)
    alone = one.stiffness(one.deflection(total)) + 2.0 * one.stiffness(one.deflection(0.5 * total))
    assert sum(s.stiffness[2, 2] for s in result.sets) == pytest.approx(alone, rel=2e-3)
    assert alone / 1030e6 == pytest.approx(1.433, abs=0.01)


def test_a_rigidity_that_no_conformity_gives_is_refused() -> None:
    with pytest.raises(InputError, match=r"sets\[0\]\.pair_rigidity"):
        changed(('pair_rigidity = "1030 N/um"', 'pair_rigidity = "9000 N/um"'))
