"""Every number of an answer is read from its field: where the field changes, JSON and data frame show the change."""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from rollbench.compare.commands.friction import friction_terminal_parts
from rollbench.compare.gate.verdict import Judgement, VerdictRow
from rollbench.compare.measure import LoadError
from rollbench.compare.results.base import TabularRecord
from rollbench.compare.results.data import Ensemble, Statistics
from rollbench.compare.results.friction import (
    FlankLosses,
    Friction,
    FrictionAtCoefficients,
    FrictionBall,
    FrictionCases,
    FrictionOfRollers,
    FrictionOfSet,
)
from rollbench.compare.results.mesh_study import MeshLevel, MeshQuantity, MeshStudy
from rollbench.compare.results.table import Over, Table, TableRow
from rollbench.compare.results.verdict import Verdict
from rollbench.compare.studies.friction.solve import solve_friction_of_named_scene
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.compare.studies.survey_models import Survey, SurveyRow
from rollbench.compare.studies.sweep.keys import read_varied_keys
from rollbench.compare.studies.sweep.run import GroupMean, SobolIndex, SobolIndices, Sweep, SweepDefinition
from rollbench.compare.text.friction import friction_tables
from rollbench.lowfi.bearings.torque import RollerBearingTorque

OF_LOADS = LoadError(5.0, 2.0, 6.0, 3.0, 4, "SL", 5.5)
ROWS = (
    VerdictRow("a", "lin", "load", Judgement.PASS, 5.0, 0.1, 7.0, 4, "SL", (1, 3), 8, "", OF_LOADS),
    VerdictRow("a", "lin", "angle", Judgement.FAIL, 2.0, 0.1, 1.0, unit="deg", pair=("angle_deg", 45.0, 43.0)),
)
OVER = (Over("load", "load_kN", (1.0, 2.0)),)
QUANTITIES = ("stiffness", "displacement", "load", "preload", "pressure", "life")
RIGID = {"nut_tangent": 10.0, "load_point_tangent": 11.0, "nut_displacement": 12.0, "load_point_displacement": 13.0}
ROW = TableRow("converged", np.eye(6), *(float(k) for k in range(1, 10)), "", **RIGID)
STATISTICS = Statistics(
    members=5, mean=1.0, standard_error=2.0, standard_deviation=3.0, smallest=4.0, largest=5.0, quantiles={0.5: 6.0}
)
WITH_INTERVALS = replace(STATISTICS, intervals={0.5: (7.0, 8.0)})
SAMPLES = SweepDefinition("", "a.toml", read_varied_keys(["nut.length=1 mm:2 mm"]), 8)
CONTACT = {"index": 1, "side": "SL", "mean_N": 2.0}
LEVEL = MeshLevel(
    level=1, cell_size=2.0, unknowns=3, seconds=4.0, cells=5, cpu_seconds=6.0, imbalance=7.0, difference=8.0, enough_for=9.0
)
QUANTITY = MeshQuantity("largest load, SL", "N", (1, 3), (8.0, 9.0), 1.0, 2.0, 3.0, "alike", 5.0, 6.0)
ROLLER = MeshQuantity("approach", "um", (1, 3), (8.0, 9.0), 1.0, 2.0, 3.0, by_laws={"norm": 4.0})
SCREW = SurveyRow(screw=3, title="", status="converged", largest_percent=5.0, rms_percent=6.0, verdict="pass")
OF_BALL = ("index", "orbit_rad_s", "loss_mW")
BALL = FrictionBall(index=1, orbit=2.0, loss={"SL": 3.0}, keys=OF_BALL)
LOSSES = FlankLosses(None, "SL", 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
OF_FRICTION = (
    *("scene", "torque.friction_torque_Nmm", "torque.efficiency_forward_percent", "losses.total_W", "balls"),
    *("losses.by_contact_W", "solver.static_residual"),
)

ANSWERS = (
    Friction(
        scene="a",
        title="",
        kind="ball screw",
        converged=True,
        reason="converged",
        torque=1.0,
        efficiency_forward=0.5,
        loss=2.0,
        balls=(BALL, replace(BALL, index=2)),
        by_contact=(LOSSES,),
        residual=1e-9,
        keys=OF_FRICTION,
    ),
    Verdict(ROWS, (), (), ()),
    Table(
        scene="a",
        model="lin",
        over=OVER,
        quantities=QUANTITIES,
        stiffness_of="nut",
        station=0.1,
        rows=(ROW, replace(ROW, load=3.0)),
    ),
    Sweep(
        design=SAMPLES,
        folder=Path(),
        solved=8,
        converged=7,
        failures=(("refused", 1),),
        outputs={"largest_load_N": replace(STATISTICS, members=None)},
        main_effects={"nut.length": [GroupMean(1.0, 2.0, 3.0, 4)]},
        worst=({"sample": 1, "largest_load_N": 4.0},),
        indices=SobolIndices(1, 2, 0.9, {"largest_load_N": {"nut.length": SobolIndex(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)}}),
    ),
    Ensemble(
        scene="a",
        model="lin",
        seed=1,
        members=5,
        converged=4,
        outputs={"largest_load_N": WITH_INTERVALS},
        sets={"nut": {"mean_load_N": WITH_INTERVALS}},
        contacts=(CONTACT,),
        band_resolution=9.0,
    ),
    MeshStudy(scene="a", levels=(LEVEL, replace(LEVEL, level=3)), quantities=(QUANTITY,)),
    MeshStudy(scene="a", set="x", load=3.0, levels=(LEVEL,), quantities=(ROLLER,), profile=({"along_mm": 1.0},)),
    Survey(screws=2, of=3, max_error=7.0, judged=("lin",), rows={"lin": [SCREW]}),
)

#: Numbers that JSON leaves to others: largest and smallest error for other scales, keys with their text, computing time.
ELSEWHERE = ("of_mean.own", "of_mean.ball", "of_mean.gate", "design.keys", "seconds", "levels[0].seconds")
#: Numbers that a frame has neither as a cell nor among its values: lists beside the rows.
BESIDE = ("levels", "profile", "main_effects", "worst", "failures", "contacts", "design", "by_contact")
#: Numbers that text and notebook leave to JSON and frame, beside those: of balls, contacts, screws.
NOT_IN_TEXT = (
    "balls",
    "rows[0].levels",
    "rows[0].contacts",
    "rows[1].contacts",
    "rows[lin]",
    "max_error",
    "indices",
    "load",
)


def changes(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """The value with one number changed, for every number in it, with the number's path."""
    if isinstance(value, bool) or value is None:
        return
    if isinstance(value, int | float):
        yield path, value + 1
    elif isinstance(value, np.ndarray):
        yield path, value + 1.0
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from ((at, {**value, key: new}) for at, new in changes(inner, f"{path}[{key}]"))
    elif isinstance(value, tuple | list) and not isinstance(value, str):
        for k, inner in enumerate(value):
            yield from ((at, type(value)([*value[:k], new, *value[k + 1 :]])) for at, new in changes(inner, f"{path}[{k}]"))
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            each = changes(getattr(value, field.name), f"{path}.{field.name}".removeprefix("."))
            yield from ((at, replace(value, **{field.name: new})) for at, new in each)


@pytest.mark.parametrize("answer", ANSWERS, ids=lambda x: type(x).__name__)
def test_every_changed_number_is_shown(answer: TabularRecord) -> None:
    pandas = pytest.importorskip("pandas")
    before, frame = answer.to_dict(), answer.to_dataframe()
    found = [(path, changed) for path, changed in changes(answer) if not any(x in path for x in ELSEWHERE)]
    assert len(found) > 4
    for path, changed in found:
        assert changed.to_dict() != before, path
        if not path.startswith(BESIDE):
            after = changed.to_dataframe()
            same = frame.attrs == after.attrs and frame.shape == after.shape and frame.equals(after)
            assert not same, path
            assert isinstance(after, pandas.DataFrame)
            if not path.startswith(NOT_IN_TEXT):
                assert str(changed) != str(answer), path
                assert changed._repr_html_() != answer._repr_html_(), path


@pytest.mark.parametrize("answer", ANSWERS, ids=lambda x: type(x).__name__)
def test_frames_state_their_units(answer: TabularRecord) -> None:
    pytest.importorskip("pandas")
    frame = answer.to_dataframe()
    assert set(frame.attrs["units"]) <= set(frame.columns)
    assert "" not in frame.attrs["units"].values()


#: Torques that the JSON has for the first coefficient of friction only.
OF_FIRST = ("reverse_torque", "torque_on_screw", "torque_on_nut", "axial_load", "driving_torque")


@pytest.mark.parametrize("scene", ["lin-rotary-1", "lin-screw-pair-a", "lin-pair-a", "lin-case3"])
def test_every_number_of_friction_is_in_its_json_and_the_loss_in_its_text(scene: str) -> None:
    found = solve_friction_of_named_scene(
        scene, FrictionChoices("lin", (0.1,)) if scene == "lin-case3" else FrictionChoices()
    )
    before = found.to_dict()
    silent = [
        path
        for path, changed in changes(found)
        if changed.to_dict() == before and not (path.startswith("over[") and path.split(".")[-1].startswith(OF_FIRST))
    ]
    assert not silent
    assert replace(found, loss=2.0 * found.loss).rows() != found.rows()


TORQUES = {"torque": 1.0, "driving_torque_on_screw": 2.0}
WHOLE_BALL = FrictionBall(
    set=1,
    index=2,
    azimuth=3.0,
    orbit=4.0,
    rotation=(5.0, 6.0, 7.0),
    closing=8.0,
    load={"SL": 9.0, "SR": 10.0, "NL": 11.0, "NR": 12.0},
    loss={"SL": 13.0, "SR": 14.0, "NL": 15.0, "NR": 16.0},
    keys=OF_BALL,
)
FILM = RollerBearingTorque(1.0, 2.0, 3.0, low=4.0, high=5.0, timken=6.0, words="")
OVER_KEYS = ("friction_torque_Nmm", "driving_torque_on_screw_Nmm")
AT_COEFFICIENTS = FrictionAtCoefficients(screw=0.1, nut=0.1, keys=OVER_KEYS, **TORQUES)
ON_SHAFT = Friction(
    scene="a",
    title="",
    kind="axis",
    law="coulomb",
    converged=True,
    reason="converged",
    speed=1.0,
    residual=1.0,
    imbalance=1.0,
    sets=(FrictionOfSet(set=1, name="nut", loss=1.0, drag_torque=3.0, axial_load=4.0, **TORQUES),),
    over=(AT_COEFFICIENTS, AT_COEFFICIENTS),
    balls=(WHOLE_BALL,),
    roller_torques=(FrictionOfRollers(set=2, name="rollers", torque=FILM),),
    keys=OF_FRICTION,
)
OF_SCREW = {"forward_torque": 6.0, "backward_torque": 7.0, "efficiency_forward": 0.8, "efficiency_backward": 0.7}
OF_SCREW |= {"drag_torque": 3.0}
KEYS_OF_SCREW = ("drag_torque_Nmm", "forward_torque_Nmm", "backward_torque_Nmm")
KEYS_OF_SCREW += ("efficiency_forward_percent", "efficiency_backward_percent")
ONE_NUT = replace(
    ON_SHAFT,
    kind="ball screw",
    turns="screw",
    friction_over_load=0.1,
    axial_friction=1.0,
    torque_without_feedback=1.0,
    sets=None,
    over=(replace(AT_COEFFICIENTS, keys=(*OVER_KEYS, *KEYS_OF_SCREW), **OF_SCREW),) * 2,
    by_contact=(LOSSES,),
    roller_torques=(),
    **TORQUES,
)
OF_CASES = replace(
    ON_SHAFT,
    sets=None,
    cases={
        "push": replace(
            ONE_NUT, case="push", share=0.5, axial_load=4.0, drag_torque=3.0, efficiency_forward=0.8, keys=OF_FRICTION
        )
    },
    together=FrictionCases(largest=1.0, case="push", mean=2.0, words=None),
)
#: Friction of several nuts, of one and in load cases; starts of the paths that tables show, and fields they leave out.
OF_TABLES = (
    (ON_SHAFT, ("sets", "over", "balls", "roller_torques[0].torque"), ("hysteresis", "film", "rib")),
    (ONE_NUT, ("over", "balls", "by_contact"), ()),
    (OF_CASES, ("cases[push].balls", "cases[push].share", "cases[push].drag_torque", "cases[push].axial_load"), ()),
)


def table_cells(found: Friction) -> list[list[object]]:
    """The cells of every row of all tables that the terminal shows."""
    tables = [part for part in friction_terminal_parts(found, balls=True) if not isinstance(part, str)]
    return [[*row] for table in tables for row in table.rows]


@pytest.mark.parametrize(("found", "starts", "left_out"), OF_TABLES, ids=("shaft", "nut", "cases"))
def test_every_changed_number_of_friction_is_shown_in_its_tables(
    found: Friction, starts: tuple[str, ...], left_out: tuple[str, ...]
) -> None:
    before = table_cells(found)
    moved = [(path, changed) for path, changed in changes(found) if path.startswith(starts)]
    assert {path.split(".")[0].split("[")[0] for path, _ in moved} == {
        start.split(".")[0].split("[")[0] for start in starts
    }
    for path, changed in moved:
        assert (table_cells(changed) == before) == (path.split(".")[-1] in left_out), path


def test_a_shaft_without_balls_has_no_table_of_balls() -> None:
    shown = [
        [title for title, _ in friction_tables(found, balls=True)] for found in (ON_SHAFT, replace(ON_SHAFT, balls=()))
    ]
    assert [titles.count("per ball") for titles in shown] == [1, 0]
