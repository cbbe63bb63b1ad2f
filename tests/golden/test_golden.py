"""Golden values guard against change, not against error: they were written by the code they test.

Whoever changes the model on purpose writes them again with ``python -m tests.golden.test_golden`` from the repository's
root and says why in the commit. Correctness is the business of the closed forms, literature and property tests.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.helpers import solved

from rollbench.compare.scenes import catalogue

FOLDER = Path(__file__).parent
SCENES = ("lin-case1", "lin-case2", "lin-case3-offset", "lin-combined", "bearing-9-preload")
TOLERANCE = 1e-8


def digits(x):
    return float(f"{x:.10g}")


def record(name):
    """Largest and smallest load of the loaded contacts, their ratio, some balls' loads, and the shaft's ends."""
    result = solved(catalogue.scene(name))
    loaded = result.load[result.load > 0.0]
    picks = np.unique(np.linspace(0, result.load.shape[0] - 1, 5).astype(int))
    return {
        "scene": name,
        "max_N": digits(loaded.max()),
        "min_N": digits(loaded.min()),
        "ratio": digits(loaded.max() / loaded.min()),
        "loads_N": {str(i + 1): [digits(f) for f in result.load[i]] for i in picks},
        "end_uz_um": [digits(1e6 * result.centreline[k, 2]) for k in (0, -1)],
    }


@pytest.mark.parametrize("name", SCENES)
def test_golden(name):
    expected = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    found = record(name)
    assert found.keys() == expected.keys()
    for ball, loads in expected.pop("loads_N").items():
        assert found["loads_N"][ball] == pytest.approx(loads, rel=TOLERANCE, abs=TOLERANCE * expected["max_N"])
    for key, value in expected.items():
        assert found[key] == (name if key == "scene" else pytest.approx(value, rel=TOLERANCE)), key


if __name__ == "__main__":
    for scene in SCENES:
        (FOLDER / f"{scene}.json").write_text(json.dumps(record(scene), indent=2) + "\n", encoding="utf-8")
