"""`rollbench check` on angles, approaches, pressures and values of the whole: limits, uncertainty, units."""

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from rollbench.comparison.errors import InputError
from rollbench.comparison.gate import judged as judging
from rollbench.comparison.gate.further import not_judged, value_verdict
from rollbench.comparison.gate.loads_file import Column, column, read_loads
from rollbench.comparison.gate.user import asked, check_scenes
from rollbench.comparison.gate.values_file import GivenValue, read_values
from rollbench.comparison.gate.verdict import LARGEST, Limits, Verdict
from rollbench.comparison.models.loading import scaled
from rollbench.comparison.models.referenced import referenced
from rollbench.comparison.models.u_val import QUANTITIES as COMPARED
from rollbench.comparison.models.u_val import grid_uncertainty
from rollbench.comparison.reference.estimate import Reference
from rollbench.comparison.reference.jobs import Engine
from rollbench.comparison.reference.store import save, shipped_store
from rollbench.comparison.reference.tasks import settings_of
from rollbench.comparison.scenes import catalogue
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene

SCENE = "lin-case1"


def scene() -> Scene:
    found = catalogue.scene(SCENE)
    assert isinstance(found, Scene)
    return found


def stored(of: Scene) -> Reference:
    return referenced(of, (shipped_store(),))[0].found


def table(path: Path, heads: str, cells: Callable[[int, int], str]) -> Path:
    """A row of every contact of the 32 balls: ball, flank and cells."""
    rows = [f"{b + 1},{SIDES[s]},{cells(b, s)}" for b in range(32) for s in range(4)]
    path.write_text("\n".join([f"ball,flank,{heads}", *rows]) + "\n", encoding="utf-8")
    return path


def judged(**what: object) -> list[Verdict]:
    return check_scenes([scene()], asked(compute=False, **what), Engine(), lambda _: None)


@pytest.mark.parametrize(
    ("head", "expected"),
    [
        ("newton", Column("load")),
        ("kN", Column("load", 1e3)),
        ("Load [kN]", Column("load", 1e3)),
        ("contact_angle_rad", Column("angle")),
        ("angle (deg)", Column("angle", np.radians(1.0))),
        ("approach / mm", Column("approach", 1e-3)),
        ("approach_µm", Column("approach", 1e-6)),
        ("pressure_gpa", Column("pressure", 1e9)),
        ("Z_UM", Column("z", 1e-6)),
        ("uncertainty_%", Column("uncertain share", 0.01)),
        ("approach_N", Column("")),
        ("angle", Column("")),
        ("stress_MPa", Column("")),
    ],
)
def test_headings_say_quantity_and_unit(head: str, expected: Column) -> None:
    found = column(head)
    assert (found.name, found.factor) == (expected.name, pytest.approx(expected.factor, rel=1e-14))


def test_units_of_the_header_are_obeyed(tmp_path: Path) -> None:
    file = table(tmp_path / "a.csv", "kN,angle_rad,approach_mm", lambda b, _: f"{0.1 * b},0.8,{0.005 if b else ''}")
    found = read_loads(file, 32)
    assert found.load[3, 0] == pytest.approx(300.0)
    assert found.further["angle"][0, 0] == pytest.approx(0.8)
    assert found.further["approach"][3, 0] == pytest.approx(5e-6)


def test_each_quantity_of_contacts_is_judged_by_the_contact_that_decides(tmp_path: Path) -> None:
    found = stored(scene())
    approach = judging.hertz_of(scene(), judging.APPROACH, found.load)
    pressure = judging.hertz_of(scene(), judging.PRESSURE, found.load)
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
    assert turned.error == pytest.approx(1.2, abs=1e-9)
    assert turned.error_percent is None
    assert turned.as_json()["error_deg"] == turned.error
    assert (closer.word, closer.ball, closer.flank) == ("fail", 8, "NR")
    assert (closer.error, closer.limit) == (pytest.approx(5.0), pytest.approx(14.0 / 3.0))
    assert (less.word, less.error, less.limit) == ("fail", pytest.approx(-3.0), pytest.approx(7.0 / 3.0))
    wider = judged(loads=file, limits=["angle=1.5", "approach=6", "pressure=4"])
    assert [v.word for v in wider] == ["pass"] * 4
    share = found.uncertainty[7, 3] / found.load[7, 3]
    assert wider[2].uncertainty == pytest.approx(100.0 * 2.0 / 3.0 * share, rel=2e-3), "approach goes as F^(2/3)"
    assert wider[3].uncertainty == pytest.approx(100.0 / 3.0 * found.uncertainty[9, 0] / found.load[9, 0], rel=2e-3)


def test_the_uncertainty_by_loads_is_the_larger_end() -> None:
    load, bar = np.array([8.0, 0.0]), np.array([1.0, 1.0])
    assert judging.by_loads(lambda x: float(x.sum() ** -3), load, bar) == pytest.approx(7.0**-3 - 8.0**-3)


def values(path: Path, *rows: str) -> Path:
    path.write_text("\n".join(["quantity,value,unit,where", *rows]) + "\n", encoding="utf-8")
    return path


def test_values_of_the_whole_are_judged_with_the_uncertainty_of_each(tmp_path: Path) -> None:
    rows = ("displacement,22.5,um,", "displacement,0.0225,mm,300 mm", "rigidity,230,N/um,", "life,9e6,revolutions,")
    file = values(tmp_path / "v.csv", *rows)
    moved, there, stiff, life = judged(values=file, limits=["rigidity=10"])
    found = stored(scene())
    place = float(np.interp(scene().nut.position, found.best.centreline[:, 0], found.best.centreline[:, 3]))
    assert moved.error == pytest.approx(100.0 * (22.5e-6 / place - 1.0))
    assert moved.uncertainty == pytest.approx(float(grid_uncertainty(scene(), found, COMPARED[2])[0]), rel=1e-6)
    at = float(np.interp(0.3, found.best.centreline[:, 0], found.best.centreline[:, 3]))
    assert there.error == pytest.approx(100.0 * (22.5e-6 / at - 1.0))
    assert stiff.pair == ("rigidity_N_per_um", pytest.approx(230.0), pytest.approx(5e-3 / place, rel=1e-4))
    assert (stiff.limit, life.limit, life.word) == (10.0, 21.0, "fail")
    assert "this project's formula on the reference's loads" in life.detail
    assert not_judged([moved, there, stiff, life]) == ["contact angle", "approach", "pressure", "torque"]


def test_torque_is_by_friction_on_the_reference_s_loads(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    loads: list[Array] = []

    def torque(sets, *_: object) -> float:
        loads.append(sets[0][1].load)
        return float(sets[0][1].load.sum())

    monkeypatch.setattr("rollbench.comparison.gate.judged.offered", lambda hook: [torque] if hook == "torque" else [])
    (found,) = judged(values=values(tmp_path / "v.csv", "torque,15,N m,"))
    reference = stored(scene())
    assert found.pair == ("torque_Nmm", pytest.approx(15e3), pytest.approx(reference.load.sum()))
    assert found.uncertainty == pytest.approx(100.0 * reference.uncertainty.sum() / reference.load.sum())
    assert len(loads) == 4


def test_a_rigidity_curve_is_judged_load_by_load(tmp_path: Path) -> None:
    """At another load the reference is that of the scene with its loads in proportion, here stored by the test."""
    half, run = scaled(scene(), 0.5), stored(scene()).best
    line = run.centreline * np.array([1.0, 0.5, 0.5, 0.55])
    settings = asdict(settings_of([half], run.level, ""))
    other = replace(run, load=0.5 * run.load, centreline=line, settings=settings)
    (tmp_path / "store").mkdir()
    save(tmp_path / "store", half, other)
    file = values(tmp_path / "v.csv", "rigidity,226,N/um,5 kN", "rigidity,206,N/um,2.5 kN", "rigidity,180,N/um,1 kN")
    whole, less, least = judged(values=file, store=tmp_path / "store")
    assert whole.word == "pass"
    assert less.quantity == "rigidity at 2.5 kN"
    assert less.pair[2] == pytest.approx(2.5e-3 / float(np.interp(scene().nut.position, line[:, 0], line[:, 3])), rel=1e-3)
    assert (less.word, less.uncertainty) == ("undecided", None), "one mesh level leaves it open"
    assert least.line() == (
        "NOT COVERED: lin-case1, v.csv: rigidity at 1 kN: no stored run of its 3D reference, and none is to be computed"
    )


def test_a_model_is_judged_on_what_is_given_a_limit() -> None:
    words = {v.quantity: v for v in judged(model="lin", limits=["approach=1", "displacement=2", "contact_angle=1"])}
    assert list(words) == [LARGEST, "contact angle", "approach", "displacement"]
    assert [v.word for v in words.values()] == ["fail", "pass", "fail", "fail"]


def test_a_place_without_load_is_counted_from(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rollbench.comparison.gate.judged.unloaded_place", lambda *_: 2e-6)
    found = stored(scene())
    verdict = value_verdict("x", GivenValue(judging.DISPLACEMENT, 2.005e-5), scene(), found, Limits())
    assert verdict.word == "pass"
    assert verdict.detail == "from the place without loads, by refined 2 um"


@pytest.mark.parametrize("text", ["rigidity", "rigidity=x", "rigidity=-1", "rigidity=nan", "load=3", "=1"])
def test_faulty_limits(text: str) -> None:
    with pytest.raises(InputError, match="--limit: got"):
        judging.parse_limits([text])
    with pytest.raises(InputError, match="each once"):
        judging.parse_limits(["life=1", "life=2"])


@pytest.mark.parametrize(
    ("row", "key"),
    [
        ("mass,1,kg,", "line 2: quantity"),
        ("rigidity,1,um,", "line 2: value, unit"),
        ("rigidity,x,N/um,", "line 2: value, unit"),
        ("life,3,h,", "line 2: value, unit"),
        ("life,-3,revolutions,", "line 2: value, unit"),
        ("rigidity,1,N/um,400 mm", "line 2: where"),
        ("displacement,1,um,somewhere", "line 2: where"),
        ("", "file"),
    ],
)
def test_faulty_values_are_refused_by_line(tmp_path: Path, row: str, key: str) -> None:
    with pytest.raises(InputError) as caught:
        read_values(values(tmp_path / "v.csv", row))
    assert caught.value.key == key


def test_values_of_several_loads_and_decimal_commas(tmp_path: Path) -> None:
    (tmp_path / "v.csv").write_text(
        "quantity;value;unit;where;who\nrigidity;210,5;N/um;2,5 kN\nlife;3;million revolutions\n"
    )
    found, unknown = read_values(tmp_path / "v.csv")
    assert found == [GivenValue(judging.RIGIDITY, 210.5e6, 2500.0, None, "2,5 kN"), GivenValue(judging.LIFE, 3.0)]
    assert unknown == ('"who"',)


def test_an_unknown_column_is_a_warning_and_with_strict_an_error(command, tmp_path: Path) -> None:
    load = stored(scene()).load
    file = str(table(tmp_path / "a.csv", "newton,note,approach_N", lambda b, s: f"{load[b, s]},x,1"))
    code, data = command.json("check", SCENE, "--no-compute", "--loads", file, "--json")
    assert (code, data["verdict"], len(data["verdicts"])) == (0, "pass", 1)
    assert data["not_judged"] == ["contact angle", "approach", "pressure", "displacement", "rigidity", "torque", "life"]
    assert '"note", "approach_N"' in data["warnings"][0]
    code, out, _ = command("check", SCENE, "--no-compute", "--loads", file)
    assert out.startswith("WARNING: a.csv: ")
    said = command.refused("check", SCENE, "--no-compute", "--loads", file, "--strict")
    assert '"note", "approach_N"' in said


@pytest.mark.parametrize(
    ("heads", "cells", "words"),
    [
        ("newton,angle_deg", "100,", "no angle of ball 1 SL"),
        ("newton,load_kN", "100,0.1", "each quantity once"),
        ("newton,approach_um", "100,-1", "from 0"),
        ("newton,pressure_MPa", "100,inf", "from 0"),
    ],
)
def test_faulty_columns(tmp_path: Path, heads: str, cells: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_loads(table(tmp_path / "a.csv", heads, lambda *_: cells), 32)
