"""Arguments that cannot be used: the library names the argument, and only the command line its option."""

import pytest
from tests.copies import ROOT

import rollbench
from rollbench.compare.cli import error_with_option_names
from rollbench.compare.errors import InputError

VARY = ["errors.balls.oversize=0 um:7 um"]
#: Calls with something that cannot be used, below the argument that each error names.
CALLS = [
    ("model", rollbench.solve, ("lin-case1", "nope"), {}),
    ("member", rollbench.solve, ("lin-case1", "lin"), {"member": 3}),
    ("max_error", rollbench.check, ("lin-case1",), {"max_error": 700}),
    ("levels", rollbench.check, ("lin-case1",), {"levels": 9}),
    ("levels", rollbench.check, ("lin-case1",), {"levels": 2, "reference": "mine.csv"}),
    ("loads", rollbench.check, ("lin-case1",), {"loads": "mine.csv", "model": "lin"}),
    ("values", rollbench.check, ("lin-case1",), {"values": "mine.csv", "model": "lin"}),
    ("model", rollbench.check, ("two-balls",), {"model": "mei", "compute": False}),
    ("limits", rollbench.check, ("lin-case1",), {"limits": {"rigidity": -1.0}}),
    ("models", rollbench.compare_models, ("lin-case1", ["nope"]), {}),
    ("reference", rollbench.compare_models, ("lin-case1",), {"reference": "mine.csv", "levels": 1}),
    ("mu", rollbench.friction, ("lin-case1",), {"mu": (3.0,)}),
    ("mu", rollbench.friction, ("clearance",), {}),
    ("mu", rollbench.friction, ("lin-pair-a",), {"mu": (0.1,)}),
    ("levels", rollbench.mesh_study, ("lin-case1",), {"levels": 9}),
    ("spread", rollbench.mesh_study, ("double-nut",), {"spread": True}),
    ("vary", rollbench.sweep, ("lin-case1", ["nope"]), {}),
    ("vary", rollbench.sweep, ("lin-case1", ["track.lead=1"]), {}),
    ("samples", rollbench.sweep, ("lin-case1", VARY), {"samples": 1}),
    ("method", rollbench.sweep, ("lin-case1", VARY), {"method": "nope"}),
    ("outputs", rollbench.sweep, ("lin-case1", VARY), {"outputs": ["nope"]}),
    ("out", rollbench.sweep, ("lin-case1", VARY), {"samples": 4, "out": ROOT}),
    ("only", rollbench.report, (), {"only": ["nope"]}),
    ("reference", rollbench.report, (), {"reference": "mine.csv"}),
    ("stored", rollbench.report, (), {"stored": True, "fresh": True}),
    ("quick", rollbench.report, ("two-balls",), {"quick": True}),
    ("scenes", rollbench.side_by_side, (["lin-case1"],), {}),
    ("scene", rollbench.solve, ({"track": 1},), {}),
    ("max_error", rollbench.check, ("lin-case1",), {"max_error": "7%"}),
    ("members", rollbench.ensemble, ("lin-random", "5"), {}),
    ("samples", rollbench.sweep, ("lin-case1", ("load=1 kN:2 kN",)), {"samples": "many"}),
    ("levels", rollbench.mesh_study, ("lin-case1",), {"levels": "2"}),
    ("mu", rollbench.friction, ("lin-case1",), {"mu": "0.1"}),
    ("out", rollbench.report, ("lin-case1",), {"out": ROOT}),
]


@pytest.mark.parametrize(("argument", "function", "given", "named"), CALLS)
def test_the_library_names_arguments_and_the_command_line_options(argument, function, given, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as raised:
        function(*given, **named)
    assert argument in f"{raised.value.key}; {raised.value.advice}"
    assert "--" not in str(raised.value)
    assert "`" not in "".join(error_with_option_names(raised.value).lines())


OPTIONS = [("max_error", {"max_error": 700}, "--max-error"), ("compute", {"levels": 2, "compute": False}, "--no-compute")]


@pytest.mark.parametrize(("argument", "given", "option"), OPTIONS)
def test_an_argument_becomes_its_option(argument, given, option):
    with pytest.raises(InputError) as raised:
        rollbench.check("lin-case1", **given)
    assert argument in str(raised.value)
    assert option in str(error_with_option_names(raised.value))
