"""A report made in two processes is the report made in one."""

from __future__ import annotations

from contextlib import contextmanager

import pytest

from rollbench.comparison.commands.reporting import halves as report_halves
from rollbench.comparison.commands.reporting.halves import Made, build, make, split
from rollbench.comparison.commands.reporting.parts import PARTS
from rollbench.comparison.models.study import Study
from rollbench.comparison.registration import Part

ASIDE, OWN = Part("crosscheck", "wings.crosscheck.section", beside=True), Part("tolerances", "wings.sweep.section")


def test_what_is_timed_and_one_core_make_one_process(monkeypatch):
    wanted = [ASIDE, OWN]
    monkeypatch.setattr(report_halves, "cores", lambda: 2)
    assert split(wanted, Study()) == ([ASIDE], [OWN])
    assert split(wanted, Study(timed=True)) == ([], wanted)
    assert split([ASIDE], Study()) == ([], [ASIDE])
    monkeypatch.setattr(report_halves, "cores", lambda: 1)
    assert split(wanted, Study()) == ([], wanted)


def test_sections_of_both_processes_are_those_of_one():
    alone, steps = Study(), []
    whole = make([ASIDE, OWN], steps.append, lambda _: None, alone, lambda _: None).sections
    study = Study()
    halves = build([ASIDE], [OWN], steps.append, lambda _: None, study, abs)
    assert halves == whole
    assert list(study.used) == list(alone.used) != []
    assert steps == ["crosscheck", "tolerances", "tolerances", "what is left of crosscheck"]


def test_what_measures_times_is_made_last_and_alone(monkeypatch):
    order = []

    @contextmanager
    def another(*_):
        yield iter([Made({}, Study())])

    def note(parts, *_):
        order.extend(part.name for part in parts)
        return Made({}, Study())

    monkeypatch.setattr(report_halves, "_another", another)
    monkeypatch.setattr(report_halves, "make", note)
    monkeypatch.setattr(report_halves, "cores", lambda: 2)
    timing = Part("timing", "wings.bench.section", alone=True)
    aside, others = split([timing, ASIDE, OWN], Study())
    assert (aside, others) == ([ASIDE], [timing, OWN])
    build(aside, others, order.append, lambda _: None, Study(), abs)
    assert order == ["tolerances", "what is left of crosscheck", "timing"]
    assert split([timing, ASIDE], Study()) == ([], [timing, ASIDE])
    assert [part.name for part in PARTS if part.alone] == ["timing"]


def test_scenes_of_both_processes_are_noted(monkeypatch):
    there = Study()
    there.uses(["two-balls", "lin-pair-a"])

    @contextmanager
    def another(*_):
        yield iter([Made({"aside": None}, there)])

    monkeypatch.setattr(report_halves, "_another", another)
    study = Study()
    assert set(build([ASIDE], [OWN], lambda _: None, lambda _: None, study, abs)) == {"aside", "tolerances"}
    assert {"two-balls", "lin-pair-a"} <= set(study.used)


def test_a_fault_of_the_second_process_is_told():
    with pytest.raises(ModuleNotFoundError, match="nothing_of_this_name"):
        build([Part("x", "nothing_of_this_name", beside=True)], [OWN], lambda _: None, lambda _: None, Study(), abs)


def test_sections_of_the_second_process():
    assert sorted(part.name for part in PARTS if part.beside) == [
        "crosscheck",
        "history",
        "holding",
        "how-to-read",
        "ladder",
        "overview",
        "pictures",
        "reference",
        "reference-mesh",
        "rolling",
        "sheets",
        "u-val",
        "verification",
    ]
