import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.studies.sweep import keys

KEYS = keys.read_varied_keys(["a=0.0:1.0", "b=1 um:3 um", "c=x,y,z"])


def test_sobol_design_is_a_b_and_their_mixtures():
    found = keys.sample_coordinates("sobol", KEYS, 100, 1)
    n = keys.base_point_count(100, 3)
    assert (n, found.shape) == (16, (5 * 16, 3))
    a, b = found[:n], found[n : 2 * n]
    for k in range(3):
        mixed = found[(2 + k) * n : (3 + k) * n]
        assert np.array_equal(mixed[:, k], b[:, k])
        assert np.array_equal(np.delete(mixed, k, axis=1), np.delete(a, k, axis=1))


def test_latin_hypercube_has_one_sample_in_every_slice():
    slices = (50 * keys.sample_coordinates("lhs", KEYS, 50, 3)).astype(int)
    np.testing.assert_array_equal(np.sort(slices, axis=0), np.arange(50)[:, None] * np.ones((1, 3)))


def test_grid_has_all_combinations_and_the_ends():
    found = keys.sample_coordinates("grid", KEYS, 30, 0)
    rows = [tuple(keys.key_values_at_coordinates(KEYS, place)) for place in found]
    assert len(rows) == len(set(rows)) == 3 * 3 * 3
    assert [{row[k] for row in rows} for k in (1, 2)] == [{"1.0 um", "2.0 um", "3.0 um"}, {*"xyz"}]


def test_same_seed_same_places_and_another_seed_others():
    for method in ("sobol", "lhs"):
        first = keys.sample_coordinates(method, KEYS, 64, 5)
        assert np.array_equal(first, keys.sample_coordinates(method, KEYS, 64, 5))
        assert not np.array_equal(first, keys.sample_coordinates(method, KEYS, 64, 6))


@pytest.mark.parametrize(("method", "samples"), [("random", 10), ("lhs", 1), ("grid", 5), ("lhs", 10**7)])
def test_bad_designs_are_refused(method, samples):
    with pytest.raises(InputError):
        keys.sample_coordinates(method, KEYS, samples, 0)
