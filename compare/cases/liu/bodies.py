"""Error of Liu's axial-only model: the same screw by this model, the beam model, the refined model and in 3D."""

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

#: Scenes of Liu's screw with 3D reference solutions, and the mesh levels of these (156 contacts).
SOLID = (SCENE, "liu-small", "liu-drawn", "liu-drawn-1kN")

SOLID_LEVELS = (1, 2)

#: Axial loads [N]; half range of the random ball errors [m]; number of randomly drawn screws.
LOADS, HALF_RANGE, DRAWN = (1000.0, 5000.0), 2e-6, 3


@dataclass(frozen=True)
class ModelLoads:
    """Contact loads of the 78 balls of one screw under one axial load, by three models.

    ``errors``: ball errors of the screw in words; ``load``: axial load [N]; ``axial``, ``beam``, ``refined``: contact
    loads (78,) [N] by Liu's axial model, the beam model and the refined model.
    """

    errors: str
    load: float
    axial: Array
    beam: Array
    refined: Array

    def difference_from_axial(self, model: Array) -> tuple[float, float, int]:
        """Return the differences of the axial model's loads from those of another model.

        First: RMS difference; second: largest difference, with its sign [both in % of the mean load]; third: number of the
        ball with the largest difference, from 1. ``model``: contact loads (78,) [N] by the other model.
        """
        change = error_percent(model, self.axial, float(model.mean()))
        ball = int(np.abs(change).argmax())
        return float(np.sqrt(np.mean(change**2))), float(change[ball]), ball + 1


def change_errors_and_load(scene: Scene, errors: Array, load: float) -> Scene:
    """Return a copy of the scene with other ball errors and another axial load.

    ``errors``: errors of the ball diameters (78,) [m]; ``load``: axial load [N].
    """
    listed = tuple((i + 1, 0.5 * float(e)) for i, e in enumerate(errors) if e != 0.0)
    balls = replace(scene.errors.balls, listed=listed)
    force = replace(scene.loads[0], force=(0.0, 0.0, load))
    return replace(scene, errors=replace(scene.errors, balls=balls), loads=(force,))


def rigid_nut_model(scene: Scene) -> Row:
    """Return the inputs of Liu's axial model of a scene, with two assumptions of the beam model.

    These are a rigid nut, and contact angles that follow exactly from the displacements.
    """
    row = row_of(scene, law="exact")
    return replace(row, chain=replace(row.chain, compliance=row.share * row.chain.compliance))


def compare_models(study: Study) -> tuple[ModelLoads, ...]:
    """Return the contact loads of Liu's screw by all models, for several ball errors and axial loads.

    The ball errors are none, ball 33 too small or too large by 2 um, and random errors.
    """
    scene = study.scene(SCENE)
    chain = rigid_nut_model(scene).chain
    drawn = draw_errors(evidence.SEED + 2, 0, DRAWN, evidence.ball_count(), HALF_RANGE)
    kinds = [
        ("none", np.zeros(evidence.ball_count())),
        ("ball 33: -2 um", evidence.errors_of_ball_33(-2e-6)),
        ("ball 33: +2 um", evidence.errors_of_ball_33(2e-6)),
    ]
    kinds += [(f"drawn, +-2 um, screw {i + 1}", errors) for i, errors in enumerate(drawn)]
    return tuple(_compute_loads(study, scene, chain, name, errors, load) for name, errors in kinds for load in LOADS)


def _compute_loads(study: Study, scene: Scene, chain: Chain, name: str, errors: Array, load: float) -> ModelLoads:
    """Compute the contact loads of one screw under one axial load by Liu's axial, the beam and the refined model.

    ``chain``: axial model of the scene; ``name``: ball errors in words; ``errors``: errors of the ball diameters (78,)
    [m]; ``load``: axial load [N].
    """
    changed = change_errors_and_load(scene, errors, load)
    beam, refined = (study.solve(changed, model).load[:, 0] for model in ("lin", "refined"))
    return ModelLoads(name, load, solve_chain(chain, errors, load).load, beam, refined)


@dataclass(frozen=True)
class DifferenceFrom3D:
    """Differences of one model's contact loads from the 3D reference, for one scene of Liu's screw."""

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


def compare_with_3d(study: Study) -> tuple[DifferenceFrom3D, ...]:
    """Return the differences of Liu's axial, the beam and the refined model from 3D, for scenes with a stored reference."""
    rows = []
    for name, found in study.references(SOLID).items():
        scene, bar = study.scene(name), uncertainty_percent(found)
        for model in ("axial", "lin", "refined"):
            load = axial_model_loads(scene) if model == "axial" else study.solve(scene, model).load
            e = load_error(load, found.load, found.contacts)
            carried, held = (int(np.count_nonzero(x[:, 0] > 0.0)) for x in (load, found.load))
            rows.append(
                DifferenceFrom3D(name, scene.title, model, e.rms_percent, e.max_percent, e.ball, bar, carried, held)
            )
    return tuple(rows)


def axial_model_loads(scene: Scene) -> Array:
    """Return the contact loads (78, 4) [N] by Liu's axial model, which are equal at both contacts SL and NR of a ball."""
    row, load = rigid_nut_model(scene), np.zeros((scene.ball_count, 4))
    load[row.order, 0] = load[row.order, 3] = row.solved(row.force).load
    return load


def references(fresh: bool) -> Iterator[tuple[tuple[str, ...], tuple[int, ...]]]:
    """Yield the scenes of Liu's screw and their mesh levels, whose 3D solutions a report computes again.

    ``fresh``: whether the report computes 3D solutions again; else nothing is yielded, and stored solutions are used,
    since these take longer than the rest.
    """
    if fresh:
        yield SOLID, SOLID_LEVELS
