"""Choices of the refined model that are varied: each differs from the model in what its name says, by as much."""

from dataclasses import asdict

import pytest

from rollbench.compare.sections.ladder import CHOICES
from rollbench.lowfi.compliance.parts import REFINED

#: What words of a name say of the part that they are of.
FACTORS = {
    "half as wide again": 1.5,
    "two thirds as wide": 2.0 / 3.0,
    "half as many harmonics again": 1.5,
    "two thirds of the harmonics": 2.0 / 3.0,
    "half as large again": 2.0 / 3.0,  # of the elements: so many fewer along an edge
    "half as large": 2.0,
}
PARTS = {"width": "patch of the kernels", "harmonics": "harmonics", "mesh": "elements of the kernels"}


@pytest.mark.parametrize("name", CHOICES)
def test_a_choice_is_one_and_as_large_as_its_name_says(name):
    before, after = asdict(REFINED), asdict(CHOICES[name])
    (changed,) = (key for key in before if after[key] != before[key])
    said = next((factor for words, factor in FACTORS.items() if name.endswith(words)), None)
    assert (said is not None) == (changed in PARTS)
    if said is not None:
        assert PARTS[changed] in name
        assert after[changed] == pytest.approx(said * before[changed], rel=1e-12)
