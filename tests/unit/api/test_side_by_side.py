"""Scenes side by side: the question of ball or taper for one axis, against the springs of its parts and `solve` of each."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, bearing, fixed_axis

import rollbench
from rollbench.meshes.axis import RollingSet
from rollbench.meshes.parts import Load, Lubricant, Motion, Support
from rollbench.meshes.section import tube_section

SMITH = ("smith-axis", "smith-axis-taper")


@pytest.fixture(scope="module")
def smith() -> rollbench.SideBySide:
    return rollbench.side_by_side(SMITH, model="lin")


def test_every_number_is_that_of_the_scene_alone(smith: rollbench.SideBySide) -> None:
    for name, one in zip(SMITH, smith.scenes, strict=True):
        alone = rollbench.solve(name, "lin")
        assert one.scene == name
        numbers = one.load_point_tangent, one.life, one.inertia, *one.starting
        drive = alone.drive
        expected = alone.load_point.tangent, alone.axis_life.revolutions, drive.inertia, *drive.starting
        assert numbers == pytest.approx(expected, rel=1e-9)
        assert one.running == pytest.approx(drive.running)
        assert one.radial_stiffness == pytest.approx(np.linalg.eigvalsh(alone.stiffness[:2, :2])[0])
        largest = max(s.loads.max() if s.loads is not None else s.roller_loads.max() for s in alone.sets.values())
        assert one.largest == pytest.approx(largest, rel=1e-9)
    assert smith.differ == ()


def test_stiffness_of_both_is_that_of_springs_in_series(smith: rollbench.SideBySide) -> None:
    """At mid-span: from either end row by row, what is further out in series with the shaft up to here, and the row."""
    for name, one in zip(SMITH, smith.scenes, strict=True):
        scene, sets = rollbench.read(name), rollbench.solve(name, "lin").sets
        EA = tube_section(scene.screw.outer_diameter, 0.0, scene.screw.material).EA
        by_hand = 0.0
        for end in ("left", "right"):
            of_end = [s for s in sets.values() if s.name.startswith(end)]
            rows = sorted(((abs(s.position - scene.stiffness_at), s.stiffness[2, 2]) for s in of_end), reverse=True)
            at, stiff = rows[0]
            for far, row in [*rows[1:], (0.0, 0.0)]:
                stiff = 1.0 / (1.0 / stiff + (at - far) / EA) + row
                at = far
            by_hand += stiff
        assert one.load_point_tangent == pytest.approx(by_hand, rel=1e-3)


def axis(*, rollers: bool):
    """A shaft between two rows, of balls or of rollers, that carries a force along and across."""
    places = (("a", 0.05, "-z", 4e-6), ("b", 0.25, "+z", -4e-6))
    sets = [bearing(n, z, t, offset=by) for n, z, t, by in places]
    if rollers:
        sets = [RollingSet(n, "tapered roller bearing", ROLLERS, z, offset=by, thrust=t) for n, z, t, by in places]
    one = assembly(*sets, loads=(Load(0.15, (200.0, 0.0, 500.0)),), supports=fixed_axis().supports)
    return replace(one, name="rollers" if rollers else "balls", motion=Motion(100.0), lubricant=Lubricant(40e-6))


def test_differences_are_from_the_first_and_what_is_not_shared_is_named() -> None:
    balls, rollers = axis(rollers=False), axis(rollers=True)
    found = rollbench.side_by_side([balls, rollers], model="lin")
    first, second = found.scenes
    ratios = {"load_point_tangent_N_per_um": second.load_point_tangent / first.load_point_tangent}
    ratios |= {"running_torque_Nmm": sum(second.running) / sum(first.running)}
    ratios |= {"life_million_revolutions": second.life / first.life}
    ratios |= {"L10_million_revolutions": second.basic / first.basic}
    for quantity, ratio in ratios.items():
        assert found.difference_percent(quantity) == (0.0, pytest.approx(100.0 * (ratio - 1.0)))
    assert found.differ == ()
    other = replace(rollers, loads=(), motion=Motion(50.0))
    assert rollbench.side_by_side([balls, other], model="lin").differ == ("loads", "[motion]")
    screw = rollbench.side_by_side([balls, rollbench.read("lin-case1")], model="lin")
    assert screw.differ[1:] == ("shaft", "loads", "supports", "[motion]", "[lubricant]", "[friction]")


def test_a_scene_without_equilibrium_has_its_reason_and_no_numbers() -> None:
    screw = rollbench.read("lin-case1")
    loose = replace(screw, name="loose", supports=(Support(0.0, (("ux", 0.0), ("uy", 0.0))),))
    found = rollbench.side_by_side([screw, loose], model="lin")
    assert not found.converged
    assert "screw motion along the helix" in found.scenes[1].status
    assert (found.scenes[1].nut_tangent, found.scenes[1].life, found.scenes[1].largest) == (None, None, None)
    assert found.difference_percent("nut_displacement_um") == (0.0, None)
    assert found.differ == ("supports",)


@pytest.mark.parametrize("option", [["--members", "3"], ["--balls"], ["--curve", "-1N:1N"], ["--loads-csv", "x.csv"]])
def test_what_is_of_one_scene_is_refused_in_one_line(command, option: list[str]) -> None:
    assert option[0] in command.refused("solve", *SMITH, *option)


def test_a_comparison_is_a_frame_of_contacts_and_a_panel_of_each_loaded_flank() -> None:
    pytest.importorskip("pandas")
    found = rollbench.compare_models("lin-case1", ["lin"])
    frame = found.to_dataframe()
    worst = frame.loc[frame["lin_error_percent"].abs().idxmax()]
    lin = found.models["lin"]
    assert (worst["ball"], worst["flank"]) == (lin.ball, lin.side)
    assert abs(worst["lin_error_percent"]) == pytest.approx(lin.largest_error)
    assert frame.attrs["units"]["reference_N"] == "N"
    assert [axes.get_title(loc="left") for axes in found.plot().axes] == ["flank SL", "flank NR"]
