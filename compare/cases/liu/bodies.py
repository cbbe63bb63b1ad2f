"""Limits of the axial-only idealisation: Liu's screw by the axial chain, the beam model, the refined model and in 3D."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.cases.liu import evidence
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.study import Study
from rollbench.compare.reference.estimate import uncertainty_percent
from rollbench.lowfi.random_errors.chain import Chain, draw_errors, solve_chain
from rollbench.lowfi.statics.liu import Row, row_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

SCENE = "liu-screw"

#: Scenes of that screw with references in 3D, and the mesh levels of these: 156 contacts, minutes a level.
SOLID = (SCENE, "liu-small", "liu-drawn", "liu-drawn-1kN")

SOLID_LEVELS = (1, 2)

#: Loads [N]; half range of the drawn errors [m] and how many screws are drawn.
LOADS, HALF_RANGE, DRAWN = (1000.0, 5000.0), 2e-6, 3


@dataclass(frozen=True)
class Compared:
    """Loads (78,) [N] of one screw under one axial load [N], by the axial chain, the beam and the refined model."""

    errors: str
    load: float
    axial: Array
    beam: Array
    refined: Array

    def off(self, model: Array) -> tuple[float, float, int]:
        """Return RMS and largest difference of a model from the chain [% of the mean load], and the ball of the largest."""
        change = error_percent(model, self.axial, float(model.mean()))
        ball = int(np.abs(change).argmax())
        return float(np.sqrt(np.mean(change**2))), float(change[ball]), ball + 1


def with_errors(scene: Scene, errors: Array, load: float) -> Scene:
    """Return the scene with ball diameter errors (78,) [m] under an axial load [N]."""
    listed = tuple((i + 1, 0.5 * float(e)) for i, e in enumerate(errors) if e != 0.0)
    balls = replace(scene.errors.balls, listed=listed)
    force = replace(scene.loads[0], force=(0.0, 0.0, load))
    return replace(scene, errors=replace(scene.errors, balls=balls), loads=(force,))


def same_screw(scene: Scene) -> Row:
    """Return the axial chain of a scene, with a rigid nut and exact contact angles."""
    row = row_of(scene, law="exact")
    return replace(row, chain=replace(row.chain, compliance=row.share * row.chain.compliance))


def compare_models(study: Study) -> tuple[Compared, ...]:
    """Compare the models without errors, with one ball too small or too large, and drawn screws, under both loads."""
    scene = study.scene(SCENE)
    chain = same_screw(scene).chain
    drawn = draw_errors(evidence.SEED + 2, 0, DRAWN, evidence.balls(), HALF_RANGE)
    kinds = [
        ("none", np.zeros(evidence.balls())),
        ("ball 33: -2 um", evidence.one_error(-2e-6)),
        ("ball 33: +2 um", evidence.one_error(2e-6)),
    ]
    kinds += [(f"drawn, +-2 um, screw {i + 1}", errors) for i, errors in enumerate(drawn)]
    return tuple(_compared(study, scene, chain, name, errors, load) for name, errors in kinds for load in LOADS)


def _compared(study: Study, scene: Scene, chain: Chain, name: str, errors: Array, load: float) -> Compared:
    """Compare the models on one screw under one load."""
    changed = with_errors(scene, errors, load)
    beam, refined = (study.solve(changed, model).load[:, 0] for model in ("lin", "refined"))
    return Compared(name, load, solve_chain(chain, errors, load).load, beam, refined)


@dataclass(frozen=True)
class Solid:
    """Differences of one model from the 3D reference on one scene of the screw."""

    #: Name of the scene.
    scene: str
    #: Title of the scene.
    title: str
    #: Name of the model.
    model: str
    #: RMS difference [% of the mean load].
    rms: float
    #: Largest difference [% of the mean load].
    largest: float
    #: Ball with the largest difference.
    ball: int
    #: Grid uncertainty of the reference [% of the mean load].
    uncertainty: float | None
    #: Number of loaded balls in the model.
    loaded: int
    #: Number of loaded balls in 3D.
    loaded_in_3d: int


def compare_solid(study: Study) -> tuple[Solid, ...]:
    """Return the differences of chain, beam and refined model from 3D, on scenes with a stored reference."""
    rows = []
    for name, found in study.references(SOLID).items():
        scene, bar = study.scene(name), uncertainty_percent(found)
        for model in ("axial", "lin", "refined"):
            load = axial_loads(scene) if model == "axial" else study.solve(scene, model).load
            e = load_error(load, found.load, found.contacts)
            carried, held = (int(np.count_nonzero(x[:, 0] > 0.0)) for x in (load, found.load))
            rows.append(Solid(name, scene.title, model, e.rms_percent, e.max_percent, e.ball, bar, carried, held))
    return tuple(rows)


def axial_loads(scene: Scene) -> Array:
    """Return the loads (78, 4) [N] of the axial chain on a scene of the screw, equal at both contacts of a ball."""
    row, load = same_screw(scene), np.zeros((scene.ball_count, 4))
    load[row.order, 0] = load[row.order, 3] = row.solved(row.force).load
    return load


def references(fresh: bool) -> Iterator[tuple[tuple[str, ...], tuple[int, ...]]]:
    """Yield the scenes and levels of the 3D reference that a report computes again if ``fresh``.

    They are not shipped, since they take longer than the rest of a first report.
    """
    if fresh:
        yield SOLID, SOLID_LEVELS
