"""Choices of the refined model that its derivation leaves open, and what each changes on a scene with a 3D reference."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rollbench.comparison.measure import LoadError, error_percent, load_error
from rollbench.comparison.models.study import Study
from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.meshes.loads import mean_load

#: Choices of the refined model that its derivation leaves open, varied one at a time.
CHOICES: dict[str, Backend] = {
    "patch of the kernels half as wide again": replace(REFINED, width=1.5),
    "patch of the kernels two thirds as wide": replace(REFINED, width=1.0 / 1.5),
    "bore of the smooth nut by wall^3, no layer": replace(REFINED, bore="ring"),
    "bore of the smooth nut by volume": replace(REFINED, bore="volume"),
    "bore of the smooth nut at its lands": replace(REFINED, bore="land"),
    "half as many harmonics again": replace(REFINED, harmonics=1.5),
    "two thirds of the harmonics": replace(REFINED, harmonics=1.0 / 1.5),
    "elements of the kernels half as large": replace(REFINED, mesh=2.0),
    "elements of the kernels half as large again": replace(REFINED, mesh=1.0 / 1.5),
    "flanks as plain half spaces": replace(REFINED, flank=False),
    "balls as half spaces": replace(REFINED, ball="half space"),
    "screw a beam beyond its contacts": replace(REFINED, screw="beam"),
    "section of the screw by Lin C.8": replace(REFINED, section="scene"),
}
#: Scenes on which they are varied.
VARIED = ("lin-case1", "lin-case3", "unseen-thin-nut")


@dataclass(frozen=True)
class Changed:
    """One choice on one scene: the largest change of a load [% of the mean load], and the error against the reference."""

    scene: str
    label: str
    change: float
    error: LoadError


def choices_of(study: Study, name: str) -> Iterator[Changed]:
    """The refined model as it is and with every choice varied; nothing for a scene without a stored reference."""
    scene, reference = study.scene(name), study.reference(name)
    if reference is None:
        return
    base = solve_elastic(scene, engine="interpreted").load
    mean = mean_load(base, reference.contacts)
    for label, backend in {"as it is": REFINED, **CHOICES}.items():
        load = solve_elastic(scene, backend=backend, engine="interpreted").load
        change = float(np.abs(np.asarray(error_percent(load, base, mean))).max())
        yield Changed(name, label, change, load_error(load, reference.load, reference.contacts))
