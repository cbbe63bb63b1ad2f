"""What an engineer asks of a solved scene: contacts, rigidity, safety, preload, friction, life, of one result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rollbench.comparison.errors import InputError, Refusal
from rollbench.comparison.models.loading import LiftOff, Preload, lift_off, preload, solve_scaled
from rollbench.comparison.models.registry import MODELS, Options, blamed, read_condensed
from rollbench.comparison.registration import offered
from rollbench.lowfi.compliance.parts import LADDER, REFINED
from rollbench.lowfi.rating.contacts import Contact, StaticSafety, Truncation, static_safety, truncation, worst_contact
from rollbench.lowfi.rating.life import Life, life
from rollbench.lowfi.rating.rigidity import Rigidities, axial_displacement, axial_force, rigidities
from rollbench.lowfi.rating.static import Ratings, ratings
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import Tangent, tangent_stiffness
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: Ladder step whose bodies give the tangent of a model; the others have none.
TANGENT_OF = {"lin-source-partition": "lin", "lin-printed-hertz": "lin", "source": "lin"}


@dataclass(frozen=True)
class LoadAnswers:
    """What contact loads alone answer, of any model or of the 3D reference: the worst contact, its static safety, where the
    ellipses reach, and the life; None without load, words where a formula does not take the scene."""

    worst: Contact | None
    safety: StaticSafety | None
    reach: Truncation | None
    life: Life | None
    ratings: Ratings | None
    words: str = ""


@dataclass(frozen=True)
class Answers:
    """Answers of one low-order result. displacement: axial [m] of the screw at the nut's centre from that without loads
    (from the nominal place where nothing holds the screw then); force: axial on the nut [N]; tangent: axial rigidity [N/m],
    rotation held, None where the model has no tangent, or none is found, for which ``tangent_words`` say why; friction: its
    sums, JSON-ready, or words why it is not computed."""

    loads: LoadAnswers
    force: float
    displacement: float
    rigidities: Rigidities | None
    tangent: float | None
    tangent_words: str
    preload: Preload | None
    lift: LiftOff | None
    friction: dict[str, Any] | None
    friction_words: str


def load_answers(scene: Scene, load: Array, angle: Array) -> LoadAnswers:
    """Answers of contact loads ``(n, 4)`` [N] at contact angles ``(n, 4)`` [rad]."""
    words = ""
    rated_life: Life | None = None
    reach: Truncation | None = None
    rated: Ratings | None = None
    try:
        reach = truncation(scene, load, angle)
        rated = ratings(scene)
        rated_life = life(scene, load)
    except ValueError as error:
        words = str(error)
    worst = worst_contact(scene, load, angle)
    return LoadAnswers(worst, None if worst is None else static_safety(scene, worst), reach, rated_life, rated, words)


def tangent_of(scene: Scene, station: float, model: str, options: Options) -> Tangent:
    """Tangent stiffness at a station [m] of the screw by a model with beams or elastic bodies. Raises InputError for
    another model, Refusal for a scene that its bodies cannot be made of."""
    step = TANGENT_OF.get(model, model)
    if step not in (*LADDER, "condensed"):
        allowed = ", ".join((*LADDER, "condensed", *TANGENT_OF))
        raise InputError("command line", "--stiffness-at", f"with the model {model}", allowed, "choose another model")
    condensed = read_condensed(scene, options) if step == "condensed" else None
    modelled = MODELS[model].scene(scene)
    try:
        return tangent_stiffness(
            modelled, station, backend=LADDER.get(step, REFINED), condensed=condensed, member=options.member
        )
    except ValueError as error:
        advice = "the loads are solved without it: leave the stiffness out"
        raise Refusal(scene.name, blamed(error), str(error), advice) from error


def axial_tangent(scene: Scene, model: str, options: Options) -> tuple[float | None, str]:
    """Tangent axial rigidity [N/m] at the nut's centre, rotation held, None where the model has none; words where the
    bodies that it needs cannot be made, or do not come to rest."""
    if TANGENT_OF.get(model, model) not in (*LADDER, "condensed"):
        return None, ""
    try:
        tangent = tangent_of(scene, scene.nut.position, model, options)
    except Refusal as refused:
        return None, refused.value.partition(";")[0]  # what to do instead is of other answers
    return (tangent.rigidity("uz"), "") if tangent.status == "converged" else (None, tangent.status)


def unloaded_place(scene: Scene, bare: StaticResult) -> float:
    """Axial displacement [m] of the screw at the nut's centre without loads, from which displacements are counted; zero,
    its nominal place, where no contact holds it then. bare: the result without loads."""
    return axial_displacement(scene, bare) if bare.converged and (bare.load > 0.0).any() else 0.0


def gather(scene: Scene, result: StaticResult, model: str, options: Options) -> Answers:
    """All answers of a converged result, with the further solutions that they need: without loads, and with the loads at
    which a preloaded contact opens."""
    bare = solve_scaled(scene, 0.0, model, options)
    held = preload(scene, bare) if bare.converged else None
    start = unloaded_place(scene, bare)
    force, moved = axial_force(result), axial_displacement(scene, result) - start
    try:
        three = rigidities(scene, force, moved)
    except ValueError:
        three = None
    lift = lift_off(scene, result, bare, model, options) if held is not None else None
    friction, words = quick_friction(scene, result, options)
    slope, why = axial_tangent(scene, model, options) if force != 0.0 else (None, "")
    loads = load_answers(scene, result.load, result.contact_angle)
    return Answers(loads, force, moved, three, slope, why, held, lift, friction, words)


def quick_friction(scene: Scene, result: StaticResult, options: Options) -> tuple[dict[str, Any] | None, str]:
    """JSON-ready sums of friction where the scene gives a coefficient and no kernel has to be compiled for it; else what to
    do."""
    if scene.friction is None:
        return None, "no coefficient in the scene; for one of 0.1: rollbench friction SCENE --mu 0.1"
    for friction in offered("friction"):
        sums: tuple[dict[str, Any] | None, str] = friction(scene, result, options)
        return sums
    return None, "friction is left out of this installation"
