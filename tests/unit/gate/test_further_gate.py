"""`rollbench check` on angles, approaches, pressures and values of the whole: limits, uncertainty, units."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.gate import judged as judging
from rollbench.compare.gate.judged import UserValue, read_user_values
from rollbench.compare.gate.user import GateRequest, check_scenes
from rollbench.compare.gate.verdict import LARGEST, VerdictRow, quantities_without_verdict
from rollbench.compare.models import friction_sums, loading, uncertainty
from rollbench.compare.models.comparison import stored_references
from rollbench.compare.reference import jobs, store, tasks
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import SIDES

SCENE = "lin-case1"


GIVEN = catalogue.scene(SCENE)


def stored():
    return stored_references(GIVEN, (store.shipped_store(),))[0].reference


def table(path, heads: str, cells):
    """A row of every contact of the 32 balls: ball, flank and cells."""
    rows = [f"{b + 1},{SIDES[s]},{cells(b, s)}" for b in range(32) for s in range(4)]
    path.write_text("\n".join([f"ball,flank,{heads}", *rows]) + "\n", encoding="utf-8")
    return path


def judged(**what: object) -> list[VerdictRow]:
    return check_scenes([GIVEN], GateRequest(compute=False, **what), jobs.ComputingSettings(), lambda _: None)


def test_each_quantity_of_contacts_is_judged_by_the_contact_that_decides(tmp_path) -> None:
    found = stored()
    hertz = judging.hertz_approach_or_pressure
    approach, pressure = (hertz(GIVEN, quantity, found.load) for quantity in (judging.APPROACH, judging.PRESSURE))
    angle = np.nan_to_num(found.best.angle)
    angle[4, 0] += 1.2
    approach[7, 3] *= 1.05
    pressure[9, 0] *= 0.97

    def cells(*at: int) -> str:
        return f"{1e-3 * found.load[at]},{np.radians(angle[at])},{1e3 * approach[at]},{1e-9 * pressure[at]}"

    file = table(tmp_path / "a.csv", "kN,contact_angle_rad,approach / mm,pressure_gpa", cells)
    load, turned, closer, less = judged(loads=file)
    assert (load.quantity, load.judgement) == (LARGEST, "pass")
    assert (turned.judgement, turned.ball, turned.side, turned.unit, turned.limit) == ("fail", 5, "SL", "deg", 1.0)
    assert turned.as_json()["error_deg"] == turned.error == pytest.approx(1.2, abs=1e-9)
    assert turned.as_json()["error_percent"] is None
    assert (closer.judgement, closer.ball, closer.side) == ("fail", 8, "NR")
    assert (closer.error, closer.limit) == pytest.approx((5.0, 14.0 / 3.0))
    assert (less.judgement, less.error, less.limit) == ("fail", pytest.approx(-3.0), pytest.approx(7.0 / 3.0))
    wider = judged(loads=file, limits=["angle=1.5", "approach=6", "pressure=4"])
    assert [v.judgement for v in wider] == ["pass"] * 4
    for verdict, power, at in ((wider[2], 2.0 / 3.0, (7, 3)), (wider[3], 1.0 / 3.0, (9, 0))):
        expected = 100.0 * power * found.uncertainty[at] / found.load[at]
        assert verdict.uncertainty == pytest.approx(expected, rel=2e-3), f"{verdict.quantity} goes as F^{power:.2f}"


def test_the_uncertainty_by_loads_is_the_larger_end() -> None:
    load, bar = np.array([8.0, 0.0]), np.array([1.0, 1.0])
    assert judging.uncertainty_from_loads(lambda x: float(x.sum() ** -3), load, bar) == pytest.approx(7.0**-3 - 8.0**-3)


def values(path, *rows: str):
    path.write_text("\n".join(["quantity,value,unit,where", *rows]) + "\n", encoding="utf-8")
    return path


def test_values_of_the_whole_are_judged_with_the_uncertainty_of_each(tmp_path) -> None:
    rows = ("displacement,36.2,um,", "displacement,0.0225,mm,300 mm", "rigidity,143,N/um,", "life,9e6,revolutions,")
    file = values(tmp_path / "v.csv", *rows)
    moved, there, stiff, life = judged(values=file, limits=["rigidity=10"])
    found = stored()
    place, at = np.interp([GIVEN.loads[0].at, 0.3], found.best.centreline[:, 0], found.best.centreline[:, 3])
    assert moved.error == pytest.approx(100.0 * (36.2e-6 / place - 1.0))
    (bar,) = uncertainty.grid_uncertainty(GIVEN, found, uncertainty.QUANTITIES[2])
    assert moved.uncertainty == pytest.approx(float(bar), rel=1e-6)
    assert there.error == pytest.approx(100.0 * (22.5e-6 / at - 1.0))
    assert stiff.pair == ("load_point_secant_N_per_um", pytest.approx(143.0), pytest.approx(5e-3 / place, rel=1e-4))
    assert (stiff.limit, life.limit, life.judgement) == (10.0, 21.0, "fail")
    assert "formula from the reference's loads" in life.detail
    assert quantities_without_verdict([moved, there, stiff, life]) == ["contact angle", "approach", "pressure", "torque"]


def test_torque_is_by_friction_on_the_reference_s_loads(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    monkeypatch.setattr(friction_sums, "total_friction_torques", lambda asked: [float(asked[0].solved[0][1].load.sum())])
    (found,) = judged(values=values(tmp_path / "v.csv", "torque,15,N m,"))
    reference = stored()
    assert found.pair == ("torque_Nmm", pytest.approx(15e3), pytest.approx(reference.load.sum()))
    assert found.uncertainty == pytest.approx(100.0 * reference.uncertainty.sum() / reference.load.sum())


def test_a_rigidity_curve_is_judged_load_by_load(tmp_path) -> None:
    """At another load the reference is that of the scene with its loads in proportion, here stored by the test."""
    half, run = loading.with_scaled_loads(GIVEN, 0.5), stored().best
    line = run.centreline * np.array([1.0, 0.5, 0.5, 0.55])
    settings = asdict(tasks.mesh_settings([half], run.level, ""))
    (tmp_path / "store").mkdir()
    store.save_run(tmp_path / "store", half, replace(run, load=0.5 * run.load, centreline=line, settings=settings))
    file = values(tmp_path / "v.csv", "rigidity,140.5,N/um,5 kN", "rigidity,128,N/um,2.5 kN", "rigidity,112,N/um,1 kN")
    whole, less, least = judged(values=file, store=tmp_path / "store")
    assert (whole.judgement, less.quantity) == ("pass", "rigidity at 2.5 kN")
    assert less.pair[2] == pytest.approx(2.5e-3 / float(np.interp(GIVEN.loads[0].at, line[:, 0], line[:, 3])), rel=1e-3)
    assert (less.judgement, less.uncertainty) == ("undecided", None), "one mesh level leaves it open"
    assert (least.judgement, least.quantity) == ("not covered", "rigidity at 1 kN")


def test_a_model_is_judged_on_what_is_given_a_limit() -> None:
    found = judged(model="lin", limits=["approach=1", "displacement=2", "contact_angle=1"])
    expected = [(LARGEST, "fail"), ("contact angle", "pass"), ("approach", "fail"), ("displacement", "fail")]
    assert [(v.quantity, v.judgement) for v in found] == expected


@pytest.mark.parametrize("text", ["rigidity", "rigidity=x", "rigidity=-1", "rigidity=nan", "load=3", "=1", "life=1 life=2"])
def test_faulty_limits(text: str) -> None:
    with pytest.raises(InputError, match="limits: got"):
        judging.parse_error_limits(text.split())


def test_faulty_values_are_refused_by_line(tmp_path) -> None:
    faulty = {
        "line 2: quantity": ("mass,1,kg,",),
        "line 2: value, unit": ("rigidity,1,um,", "rigidity,x,N/um,", "life,3,h,", "life,-3,revolutions,"),
        "line 2: where": ("rigidity,1,N/um,400 mm", "displacement,1,um,somewhere"),
        "file": ("",),
    }
    for key, row in ((key, row) for key, rows in faulty.items() for row in rows):
        with pytest.raises(InputError) as caught:
            read_user_values(values(tmp_path / "v.csv", row))
        assert caught.value.key == key, row


def test_values_of_several_loads_and_decimal_commas(tmp_path) -> None:
    text = "quantity;value;unit;where;who\nrigidity;210,5;N/um;2,5 kN\nlife;3;million revolutions\n"
    (tmp_path / "v.csv").write_text(text)
    found, unknown = read_user_values(tmp_path / "v.csv")
    assert found == [UserValue(judging.RIGIDITY, 210.5e6, 2500.0, None, "2,5 kN"), UserValue(judging.LIFE, 3.0)]
    assert unknown == ('"who"',)


def test_an_unknown_column_is_a_warning_and_with_strict_an_error(command, tmp_path) -> None:
    load = stored().load
    file = table(tmp_path / "a.csv", "newton,note,approach_N", lambda *at: f"{load[at]},x,1")
    check = "check", SCENE, "--no-compute", "--loads", file
    code, data = command.json(*check, "--json")
    assert (code, data["verdict"], len(data["verdicts"])) == (0, "pass", 1)
    assert data["not_judged"] == ["contact angle", "approach", "pressure", "displacement", "rigidity", "torque", "life"]
    assert '"note", "approach_N"' in data["warnings"][0]
    assert '"note", "approach_N"' in command.refused(*check, "--strict")
