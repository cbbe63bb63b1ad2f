"""Error against run time: one definition of error and error bar for all points; tables of levels and convergence."""

from functools import cache

import numpy as np
import pytest

from rollbench.compare.models import comparison, modelling, study
from rollbench.compare.sections import reference_mesh as reference_mesh
from rollbench.compare.sections import reference_time

STUDY = study.SceneResultCache()


@cache
def stored():
    return STUDY.stored_references((*comparison.REFERENCED, *modelling.UNSEEN))


def test_every_point_has_the_same_reference_and_its_bar() -> None:
    found = stored()["lin-case1"]
    assert reference_time.errors_against_reference(found.load, found)["error"] == 0.0
    same = reference_time.errors_against_reference(found.best.load, found)
    unit = 100.0 / found.load[found.load > 0.0].mean()
    off, bar = unit * np.abs(found.best.load - found.load), unit * found.uncertainty
    ends = off.max(), max(0.0, (off - bar).max()), (off + bar).max()
    assert (same["error"], same["low"], same["high"]) == pytest.approx(ends)
    more = reference_time.errors_against_reference(found.load * 1.05, found)
    assert 0.0 < more["low"] < more["error"] < more["high"]
    assert more["rms"] < more["error"]
    assert more["gate"].error == pytest.approx(5.0)
