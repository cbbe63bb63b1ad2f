"""`rollbench check` on angles, approaches, pressures and values of the whole: limits, uncertainty, units."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.gate import judged as judging
from rollbench.compare.gate.judged import UserValue, read_user_values
from rollbench.compare.gate.user import check_scenes, gate_request
from rollbench.compare.gate.verdict import LARGEST, Verdict, quantities_without_verdict
from rollbench.compare.models import loading, uncertainty
from rollbench.compare.models.comparison import stored_references
from rollbench.compare.models.loads_file import parse_heading, read_loads
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


def judged(**what: object) -> list[Verdict]:
    return check_scenes([GIVEN], gate_request(compute=False, **what), jobs.ComputingSettings(), lambda _: None)


#: Factors of headings by quantity.
HEADS = {
    "load": {"newton": 1.0, "kN": 1e3, "Load [kN]": 1e3},
    "angle": {"contact_angle_rad": 1.0, "angle (deg)": np.radians(1.0)},
    "approach": {"approach / mm": 1e-3, "approach_µm": 1e-6},
    "pressure": {"pressure_gpa": 1e9},
    "z": {"Z_UM": 1e-6},
    "uncertain share": {"uncertainty_%": 0.01},
    "": {"approach_N": 1.0, "angle": 1.0, "stress_MPa": 1.0},
}


@pytest.mark.parametrize("name", HEADS)
def test_headings_say_quantity_and_unit(name: str) -> None:
    found = {head: parse_heading(head) for head in HEADS[name]}
    assert {of.name for of in found.values()} == {name}
    assert {head: of.factor for head, of in found.items()} == pytest.approx(HEADS[name], rel=1e-14)


def test_units_of_the_header_are_obeyed(tmp_path) -> None:
    file = table(tmp_path / "a.csv", "kN,angle_rad,approach_mm", lambda b, _: f"{0.1 * b},0.8,{0.005 if b else ''}")
    found = read_loads(file, 32)
    places = found.load[3, 0], found.further_quantities["angle"][0, 0], found.further_quantities["approach"][3, 0]
    assert places == pytest.approx((300.0, 0.8, 5e-6), abs=0.0, rel=1e-6)


def test_each_quantity_of_contacts_is_judged_by_the_contact_that_decides(tmp_path) -> None:
    found = stored()
    approach, pressure = (
        judging.hertz_approach_or_pressure(GIVEN, x, found.load) for x in (judging.APPROACH, judging.PRESSURE)
    )
    angle = np.nan_to_num(found.best.angle)
    angle[4, 0] += 1.2
    approach[7, 3] *= 1.05
    pressure[9, 0] *= 0.97

    def cells(b: int, s: int) -> str:
        return f"{found.load[b, s]},{angle[b, s]},{1e6 * approach[b, s]},{1e-6 * pressure[b, s]}"

    file = table(tmp_path / "a.csv", "newton,angle_deg,approach_um,pressure_MPa", cells)
    load, turned, closer, less = judged(loads=file)
    assert (load.quantity, load.word) == (LARGEST, "pass")
    assert (turned.word, turned.ball, turned.flank, turned.unit, turned.limit) == ("fail", 5, "SL", "deg", 1.0)
    assert turned.as_json()["error_deg"] == turned.error == pytest.approx(1.2, abs=1e-9)
    assert turned.error_percent is None
    assert (closer.word, closer.ball, closer.flank) == ("fail", 8, "NR")
    assert (closer.error, closer.limit) == pytest.approx((5.0, 14.0 / 3.0))
    assert (less.word, less.error, less.limit) == ("fail", pytest.approx(-3.0), pytest.approx(7.0 / 3.0))
    wider = judged(loads=file, limits=["angle=1.5", "approach=6", "pressure=4"])
    assert [v.word for v in wider] == ["pass"] * 4
    share = found.uncertainty[7, 3] / found.load[7, 3]
    assert wider[2].uncertainty == pytest.approx(100.0 * 2.0 / 3.0 * share, rel=2e-3), "approach goes as F^(2/3)"
    assert wider[3].uncertainty == pytest.approx(100.0 / 3.0 * found.uncertainty[9, 0] / found.load[9, 0], rel=2e-3)


def test_the_uncertainty_by_loads_is_the_larger_end() -> None:
    load, bar = np.array([8.0, 0.0]), np.array([1.0, 1.0])
    assert judging.uncertainty_from_loads(lambda x: float(x.sum() ** -3), load, bar) == pytest.approx(7.0**-3 - 8.0**-3)


def values(path, *rows: str):
    path.write_text("\n".join(["quantity,value,unit,where", *rows]) + "\n", encoding="utf-8")
    return path


def test_values_of_the_whole_are_judged_with_the_uncertainty_of_each(tmp_path) -> None:
    rows = ("displacement,22.5,um,", "displacement,0.0225,mm,300 mm", "rigidity,230,N/um,", "life,9e6,revolutions,")
    file = values(tmp_path / "v.csv", *rows)
    moved, there, stiff, life = judged(values=file, limits=["rigidity=10"])
    found = stored()
    place, at = np.interp([GIVEN.nut.position, 0.3], found.best.centreline[:, 0], found.best.centreline[:, 3])
    assert moved.error == pytest.approx(100.0 * (22.5e-6 / place - 1.0))
    assert moved.uncertainty == pytest.approx(
        float(uncertainty.grid_uncertainty(GIVEN, found, uncertainty.QUANTITIES[2])[0]), rel=1e-6
    )
    assert there.error == pytest.approx(100.0 * (22.5e-6 / at - 1.0))
    assert stiff.pair == ("rigidity_N_per_um", pytest.approx(230.0), pytest.approx(5e-3 / place, rel=1e-4))
    assert (stiff.limit, life.limit, life.word) == (10.0, 21.0, "fail")
    assert "formula from the reference's loads" in life.detail
    assert quantities_without_verdict([moved, there, stiff, life]) == ["contact angle", "approach", "pressure", "torque"]


def test_torque_is_by_friction_on_the_reference_s_loads(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    loads = []

    def torque(sets, *_: object) -> float:
        loads.append(sets[0][1].load)
        return float(sets[0][1].load.sum())

    monkeypatch.setattr("rollbench.compare.models.friction_sums.total_friction_torque", torque)
    (found,) = judged(values=values(tmp_path / "v.csv", "torque,15,N m,"))
    reference = stored()
    assert found.pair == ("torque_Nmm", pytest.approx(15e3), pytest.approx(reference.load.sum()))
    assert found.uncertainty == pytest.approx(100.0 * reference.uncertainty.sum() / reference.load.sum())
    assert len(loads) == 4


def test_a_rigidity_curve_is_judged_load_by_load(tmp_path) -> None:
    """At another load the reference is that of the scene with its loads in proportion, here stored by the test."""
    half, run = loading.with_scaled_loads(GIVEN, 0.5), stored().best
    line = run.centreline * np.array([1.0, 0.5, 0.5, 0.55])
    settings = asdict(tasks.mesh_settings([half], run.level, ""))
    (tmp_path / "store").mkdir()
    store.save_run(tmp_path / "store", half, replace(run, load=0.5 * run.load, centreline=line, settings=settings))
    file = values(tmp_path / "v.csv", "rigidity,226,N/um,5 kN", "rigidity,206,N/um,2.5 kN", "rigidity,180,N/um,1 kN")
    whole, less, least = judged(values=file, store=tmp_path / "store")
    assert (whole.word, less.quantity) == ("pass", "rigidity at 2.5 kN")
    assert less.pair[2] == pytest.approx(2.5e-3 / float(np.interp(GIVEN.nut.position, line[:, 0], line[:, 3])), rel=1e-3)
    assert (less.word, less.uncertainty) == ("undecided", None), "one mesh level leaves it open"
    none = "no run of its 3D reference is stored, and none is to be computed"
    assert least.line() == f"NOT COVERED: lin-case1, v.csv: rigidity at 1 kN: {none}"


def test_a_model_is_judged_on_what_is_given_a_limit() -> None:
    found = judged(model="lin", limits=["approach=1", "displacement=2", "contact_angle=1"])
    expected = [(LARGEST, "fail"), ("contact angle", "pass"), ("approach", "fail"), ("displacement", "fail")]
    assert [(v.quantity, v.word) for v in found] == expected


def test_faulty_limits() -> None:
    for text in ("rigidity", "rigidity=x", "rigidity=-1", "rigidity=nan", "load=3", "=1"):
        with pytest.raises(InputError, match="limits: got"):
            judging.parse_error_limits([text])
    with pytest.raises(InputError, match="each NAME once"):
        judging.parse_error_limits(["life=1", "life=2"])


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
    file = str(table(tmp_path / "a.csv", "newton,note,approach_N", lambda b, s: f"{load[b, s]},x,1"))
    check = "check", SCENE, "--no-compute", "--loads", file
    code, data = command.json(*check, "--json")
    assert (code, data["verdict"], len(data["verdicts"])) == (0, "pass", 1)
    assert data["not_judged"] == ["contact angle", "approach", "pressure", "displacement", "rigidity", "torque", "life"]
    assert '"note", "approach_N"' in data["warnings"][0]
    assert command(*check).out.splitlines()[1].startswith("WARNING: a.csv: ")
    assert '"note", "approach_N"' in command.refused(*check, "--strict")


FAULTY = [
    ("newton,angle_deg", "100,", "no angle of ball 1 SL"),
    ("newton,load_kN", "100,0.1", "each quantity once"),
    ("newton,approach_um", "100,-1", "at least 0"),
    ("newton,pressure_MPa", "100,inf", "at least 0"),
]


@pytest.mark.parametrize(("heads", "cells", "words"), FAULTY)
def test_faulty_columns(tmp_path, heads: str, cells: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_loads(table(tmp_path / "a.csv", heads, lambda *_: cells), 32)
