"""Finite bodies of other sizes: kept where the key of sources and scene holds, one recomputed."""

import json
import math
import re

import pytest

from rollbench.compare.reference.store import shipped_store
from rollbench.compare.studies.rolling import body_sizes
from rollbench.compare.studies.rolling.body_sizes import LIVE, NAMES, Variant, sizes, variants


@pytest.fixture
def solved(monkeypatch):
    """Choices that were computed, one after the other."""
    found = []

    def variant(choice):
        found.append(choice)
        return Variant(choice, dict.fromkeys(NAMES, 2.0))

    monkeypatch.setattr(body_sizes, "variant", variant)
    monkeypatch.setattr(body_sizes, "body_sizes", lambda: tuple(variant(choice) for choice in variants()))
    return found


def test_only_one_is_computed_where_they_are_kept(tmp_path, solved, monkeypatch):
    fresh = sizes([tmp_path], fresh=True)
    assert solved == list(variants())
    solved.clear()
    found = sizes([tmp_path / "none", tmp_path], fresh=False)
    assert (found.variants, solved) == (fresh.variants, [LIVE])
    assert found.words == f'Kept with the package; "{LIVE}" recomputed differs by up to 0 %.'
    monkeypatch.setattr(body_sizes, "variant", lambda choice: Variant(choice, dict.fromkeys(NAMES, 2.002)))
    assert "differs by up to 0.1 %" in sizes([tmp_path], fresh=False).words


def test_kept_ones_of_other_sources_are_not_taken(tmp_path, solved, monkeypatch):
    sizes([tmp_path], fresh=True)
    solved.clear()
    monkeypatch.setattr(body_sizes, "key", lambda: "of other sources")
    assert sizes([tmp_path], fresh=False).words == "Computed for this report."
    assert solved == list(variants())


@pytest.mark.parametrize("text", ["", "{}", '{"key": "of other sources", "variants": []}'])
def test_all_are_computed_where_the_key_does_not_hold(text, tmp_path, solved):
    (tmp_path / body_sizes.FILE).write_text(text)
    assert sizes([tmp_path], fresh=False).words == "Computed for this report."
    assert solved == list(variants())


def test_what_choices_change_is_counted_from_the_shipped_ones_without_half_spaces(tmp_path, monkeypatch):
    rows = []
    for k, (choice, (_, bodies)) in enumerate(variants().items()):
        value = 9.0 if bodies is None else 2.0 if "as shipped" in choice else 2.0 * (1.0 + 0.01 * k)
        forces_and_losses = dict.fromkeys(NAMES[:3], value)
        rows.append({"choice": choice, "values": forces_and_losses | {"increase %": 5.0 + k}})
    (tmp_path / body_sizes.FILE).write_text(json.dumps({"variants": rows}))
    monkeypatch.setattr(body_sizes, "shipped_store", lambda: tmp_path)
    assert [body_sizes.choices_share(straight) for straight in (True, False)] == pytest.approx([0.06, 0.10])


def test_every_choice_is_kept_with_the_package_and_has_the_sizes_that_its_name_says():
    text = (shipped_store() / body_sizes.FILE).read_text(encoding="utf-8")
    for name, (_, sizes_) in variants().items():
        assert name in text
        if "cells" in name:
            count = int(re.search(r"(\d) x \1 cells", name)[1])
            assert sizes_.cells == (count, count)
        if found := re.search(r"bars of (\d) ball radii|degree (\d) |open to (\d+) deg", name):
            bar, degree, opening = found.groups()
            assert not bar or sizes_.bar == int(bar)
            assert not degree or sizes_.degree == int(degree)
            assert not opening or round(math.degrees(sizes_.opening)) == int(opening)
        assert ("half spaces" in name) == (sizes_ is None)
        assert sizes_ is None or sizes_.patches != ("whole ball" in name)
