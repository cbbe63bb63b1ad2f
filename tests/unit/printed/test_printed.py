"""Printed tables: values as printed, tolerances, validation, agreement with each other and the scenes."""

import math

import pytest

from rollbench.compare import printed as printed_data
from rollbench.compare.scenes import catalogue

TABLES = printed_data.printed_table_names()
ROW = '[[row]]\nkey = "a"\nlabel = "b"\nprinted = "1.20"\nunit = "mm"\nclass = "hard"\n'


def row(table, key):
    (found,) = (r for r in printed_data.load_printed_table(table) if r.key == key)
    return found


@pytest.mark.parametrize("name", TABLES)
def test_every_row_is_complete(name):
    rows = printed_data.load_printed_table(name)
    assert rows
    for r in rows:
        assert r.table == name
        assert r.place.partition(", ")[2]
        assert r.remark
        assert (r.value is None) == bool(r.claim)
        assert r.value is None or r.value == float(r.number_as_printed)
        if r.entry_class == "band":
            assert len(r.origin_of_limits) > 20
            assert r.value is None or r.low <= r.value <= r.high


def test_b1_agrees_with_itself():
    """B.2 between the table's own rows: rho_eq is the geometric mean of R' and R'', to the digits printed."""
    v = {r.key: r.value for r in printed_data.load_printed_table("lin-B1")}
    for side in "SN":
        assert math.sqrt(v[f"R1_{side}"] * v[f"R2_{side}"]) == pytest.approx(v[f"rho_eq_{side}"], abs=2e-3)
    # The screw's R' goes with rho'' and its R'' with rho', as the remark says.
    assert 1.0 / (1.0 / 2.778 + 1.0 / v["rho2_S"]) == pytest.approx(v["R1_S"], abs=1e-3)
    assert 1.0 / (1.0 / 2.778 + 1.0 / v["rho1_S"]) == pytest.approx(v["R2_S"], rel=2e-3)


def test_speed_ratio_follows_from_table_2_2():
    ansys, proposed = ([row("lin-2.2", f"time_{of}_{i}").value for i in (1, 2, 3)] for of in ("ansys", "proposed"))
    least = min(3600.0 * one / other for one, other in zip(ansys, proposed, strict=True))
    printed = row("lin-2.4.1", "speed_ratio")
    assert printed.entry_class == "hard"
    assert 0.0 < least - printed.value < printed.tolerance


def test_given_errors_and_force_of_4_3_2_are_in_the_scenes():
    for screw in ("4p1", "2p1"):
        pitch, roundness = catalogue.scene(f"lin-pitch-{screw}"), catalogue.scene(f"lin-roundness-{screw}")
        for side in ("SL", "SR"):
            assert pitch.errors.side(side).pitch[0].sin * 1e6 == pytest.approx(row("lin-4.3.2", "e_p").value)
            assert pitch.errors.side(side).pitch_along == "axis"
            term = roundness.errors.side(side).roundness[0]
            assert (term.sin * 1e6, term.harmonic) == (pytest.approx(row("lin-4.3.2", "e_R").value), 2.0)
        assert pitch.loads[0].force[2] == roundness.loads[0].force[2] == row("lin-4.3.2", "force").value


HALVES = {"0.978": 5e-4, "1.812e-7": 5e-11, "10.040": 5e-4, "27": 0.5, "-3.137": 5e-4, "5.38": 5e-3, "1E3": 500.0}


@pytest.mark.parametrize("printed", HALVES)
def test_tolerance_is_half_a_unit_of_the_last_digit(printed):
    assert printed_data.half_unit_of_last_digit(printed) == pytest.approx(HALVES[printed], rel=1e-12)


BAND = ROW.replace('"hard"', '"band"')


def test_good_rows():
    """A band may reach a quarter of its middle to either side."""
    place, ends = 'source = "S"\nplace = "T"\n', 'origin = "x"\nlow = 0.75\nhigh = 1.25\n'
    texts = place + ROW, ROW + "tolerance = 0.1\n", BAND + ends
    plain, loose, band = (printed_data.parse_printed_table(text, "t")[0] for text in texts)
    found = plain.value, plain.tolerance, plain.number_as_printed, plain.place, plain.entry_class
    assert found == (1.2, 0.005, "1.20", "S, T", "hard")
    assert (loose.tolerance, band.low, band.high) == (0.1, 0.75, 1.25)
