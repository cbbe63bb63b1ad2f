"""Finite bodies of other sizes: kept where the key of sources and scene holds, one recomputed."""

import math
import re

from rollbench.compare.reference.store import shipped_store
from rollbench.compare.studies.rolling import body_sizes
from rollbench.compare.studies.rolling.body_sizes import variants


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
