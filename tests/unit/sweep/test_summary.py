from pathlib import Path

import numpy as np
import pytest

from rollbench.compare.results.data import output_statistics
from rollbench.compare.studies import columns
from rollbench.compare.studies.columns import MAIN
from rollbench.compare.studies.sweep import keys, run
from rollbench.compare.studies.sweep.run import main_effects, sobol_indices_by_output, sweep_summary

KEYS = keys.read_varied_keys([f"{name}={-np.pi!r}:{np.pi!r}" for name in "abc"])
NAMES = tuple(columns.COLUMNS)


def records(sweep, function):
    out = {}
    for n, place in enumerate(sweep.coordinates()):
        x = [vary.value_at_relative_position(u) for vary, u in zip(KEYS, place, strict=True)]
        out[n] = {"sample": n, "values": x, "status": "converged", "at": "1 SL", **dict.fromkeys(NAMES, 1.0)}
        out[n][MAIN] = function(*x)
    return out


def ishigami(a, b, c):
    return float(np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a))


def sweep(samples, method="sobol"):
    return run.SweepDefinition("", "x.toml", KEYS, samples, method, 3, "lin")


def test_indices_of_ishigami_lie_in_their_intervals():
    # Ishigami and Homma (1990): closed forms for coefficients 7 and 0.1
    v = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2
    total = 7.0**2 / 8.0 + 0.1 * np.pi**4 / 5.0 + 0.1**2 * np.pi**8 / 18.0 + 0.5
    cross = 0.1**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    exact = {"a": (v / total, (v + cross) / total), "b": (7.0**2 / 8.0 / total,) * 2, "c": (0.0, cross / total)}
    what = sweep(10240)
    found = sobol_indices_by_output(what, records(what, ishigami))
    assert found.base_points == 2048
    of_main = found.outputs[MAIN]
    for key, (first, last) in exact.items():
        for kind, value in (("first", first), ("total", last)):
            low, high = getattr(of_main[key], f"{kind}_low"), getattr(of_main[key], f"{kind}_high")
            assert low < getattr(of_main[key], kind) < high
            assert abs(getattr(of_main[key], kind) - value) < 1.5 * (high - low)
            assert high - low < 0.15
    assert found.outputs["mean_load_N"] is None  # it does not change


def test_a_single_key_has_all_of_the_variance():
    what = run.SweepDefinition("", "x.toml", KEYS[:1], 192, "sobol", 3, "lin")
    samples = {n: row for n, row in records(sweep(640), ishigami).items() if n < 192}
    for n, place in enumerate(what.coordinates()):
        samples[n][MAIN] = KEYS[0].value_at_relative_position(place[0]) ** 3
    (name, found), *others = sobol_indices_by_output(what, samples).outputs[MAIN].items()
    assert (name, others) == ("a", [])
    assert (found.first, found.total) == pytest.approx((1.0, 1.0), abs=0.1)


def test_indices_are_the_same_every_time_and_leave_out_base_points_with_a_failed_sample():
    what = sweep(640)
    samples = records(what, ishigami)
    assert sobol_indices_by_output(what, samples) == sobol_indices_by_output(what, samples)
    samples[128 + 5] = {"sample": 133, "values": samples[133]["values"], "status": "refused: x"}
    found = sobol_indices_by_output(what, samples)
    assert (found.base_points, found.of) == (64, 128)
    summary = sweep_summary(what, samples, Path())
    assert (summary.solved, summary.converged) == (640, 639)
    assert summary.failures == (("refused: x", 1),)


def test_other_designs_say_that_they_give_no_indices_and_worst_samples_come_first():
    what = sweep(50, "lhs")
    samples = records(what, ishigami)
    assert "sobol" in sobol_indices_by_output(what, samples)
    worst = sweep_summary(what, samples, Path()).worst
    assert len(worst) == 10
    assert [row[MAIN] for row in worst] == sorted((row[MAIN] for row in samples.values()), reverse=True)[:10]


def test_main_effect_of_a_linear_function():
    what = sweep(4000, "lhs")
    samples = records(what, lambda a, b, c: 2.0 * a)  # noqa: ARG005
    groups = main_effects(KEYS, list(samples.values()))
    assert (len(groups["a"]), sum(g.samples for g in groups["a"])) == (8, 4000)
    for g in groups["a"]:
        assert g.mean == pytest.approx(2.0 * g.at)
    for g in groups["b"]:
        assert abs(g.mean) < 5.0 * g.standard_error


def test_statistics_of_known_values():
    found = output_statistics(np.arange(101.0))
    assert (found.mean, found.quantiles[0.95]) == (50.0, 95.0)
    assert found.standard_deviation == pytest.approx(np.sqrt(101 * 102 / 12))
    assert found.standard_error == pytest.approx(found.standard_deviation / np.sqrt(101))
    assert output_statistics(np.array([1.0, np.nan])) is None
