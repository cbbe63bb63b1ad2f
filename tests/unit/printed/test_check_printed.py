"""rollbench check --printed: what it judges, its exit codes, what it refuses; the name that it had before."""

from dataclasses import replace

import pytest

from rollbench.compare import printed

HERE = ("check", "--printed")


def test_sources_tables_and_entries_can_be_chosen(command):
    whole = command.answer(*HERE, "--only", "lin-B1")
    assert {row["entry"] for row in whole["entries"]} == {row.name for row in printed.load_printed_table("lin-B1")}
    assert command.answer("audit", "--only", "lin-B1") == whole
    (one,) = command.answer(*HERE, "--only", "lin-B1:e_S")["entries"]
    assert one in whole["entries"]
    kalker = command.answer(*HERE, "--source", "kalker", "--only", "kalker-E3")
    assert {row["source"] for row in kalker["entries"]} == {"Kalker (1990)"}


def test_a_verdict_that_differs_from_the_expected_is_shown_and_fails(command, monkeypatch):
    rows = [
        replace(row, expected_verdict="identity") if row.key == "e_S" else row
        for row in printed.load_printed_table("lin-B1")
    ]
    monkeypatch.setattr("rollbench.compare.evidence.load_printed_table", lambda _: tuple(rows))
    code, data = command.json(*HERE, "--only", "lin-B1:e_S", "--json")
    assert (code, data["changed_verdicts"]) == (
        1,
        ["lin-B1:e_S: the expected verdict is identity, the actual verdict is only as printed"],
    )
    code, out, _ = command(*HERE, "--only", "lin-B1")
    assert (code, "changed: lin-B1:e_S" in out) == (1, True)
    assert command(*HERE, "--only", "lin-B1:rho_eq_S").code == 0


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((*HERE, "--source", "smit"), "did you mean smith?"),
        ((*HERE, "--only", "lin-b1"), "did you mean lin-B1"),
        ((*HERE, "--only", "lin-B1:e_s"), "lin-B1:e_S"),
        ((*HERE, "--source", "smith", "--only", "lin-B1"), '--only: got "lin-B1"'),
        ((*HERE, "lin-case1"), "without --printed"),
        ((*HERE, "--max-error", "7"), "without --printed"),
        (("check", "--source", "lin"), "with --printed"),
        (("check", "lin-case1", "--only", "lin-B1"), "with --printed"),
    ],
)
def test_what_cannot_be_judged_is_refused(command, words, expected):
    assert expected in command.refused(*words)
