"""The functions of the library: each does what the command of its name does, and returns its result.

Linear algebra has one thread while a function runs, and as many as before when it returns. ``OMP_NUM_THREADS``, or the
variable of one library such as ``OPENBLAS_NUM_THREADS``, is the switch: where it is set, it holds.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from rollbench.compare.errors import ArgumentError, named
from rollbench.compare.results.data import (
    Ensemble,
    Friction,
    MeshStudy,
    Survey,
    Sweep,
    ensemble_of,
    friction_of,
    mesh_study_of,
    survey_of,
    sweep_of,
)
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.scenes.scene_file import each_case, solvable
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.meshes.processes import held_to_one_thread

if TYPE_CHECKING:
    from rollbench.compare.models.registry import Options
    from rollbench.compare.results.comparison import Comparison
    from rollbench.compare.results.load_curve import LoadCurve
    from rollbench.compare.results.side_by_side import SideBySide
    from rollbench.compare.results.solved import Result
    from rollbench.compare.results.table import Table
    from rollbench.compare.results.verdict import Verdict

#: Takes the lines of progress of long computations; shown by ``logging.basicConfig(level="INFO")``.
LOG = logging.getLogger("rollbench")


def read(name: str | Path) -> Described:
    """The scene of a file, or the shipped scene of that name: a frozen record in SI units, to be changed by
    ``dataclasses.replace``.

    Raises rollbench.InputError, whose ``lines()`` hold every fault of the file.
    """
    return catalogue.any_scene(str(name))


def new(size: str = "", *, kind: str = "ball screw") -> Described:
    """A scene to begin with: a ball screw or double nut of a nominal size, the rest as is usual for it.

    size: diameter and lead in mm, such as ``"40x10"``; without it a scene of the kind that solves as it stands. kind: as
    `rollbench new` has it. Raises InputError.
    """
    from rollbench.compare.scenes.template import text_of

    return scene_file.read(text_of(kind, size), size or kind)


@held_to_one_thread()
def solve(
    scene: Described | str | Path,
    model: str = "",
    *,
    member: int = 0,
    everything: bool = False,
    condensed: str | Path | None = None,
    stiffness_at: float | None = None,
) -> Result:
    """Contact loads and all that they answer, by a low-order model.

    scene: as `read` gives it, or a name or file; model: refined unless given; member: specimen of a scene with random
    errors; everything: build all parts, even those that the scene does not need; condensed: file of ``rollbench
    condense``, for the model of that name; stiffness_at: station of the screw [m] whose stiffness is asked for.
    Raises InputError for what cannot be solved so; no equilibrium is no error: see `Result.status`.
    """
    from rollbench.compare.models.registry import Options

    options = Options(everything, member, condensed=None if condensed is None else Path(condensed))
    origin = str(scene) if isinstance(scene, (str, Path)) else ""
    chosen = model or ("" if condensed is None else "condensed")
    return solve_described(_described(scene), chosen, options, stiffness_at, origin, stiffness=True)


def solve_described(
    described: Described,
    model: str,
    options: Options,
    stiffness_at: float | None = None,
    origin: str = "",
    *,
    stiffness: bool = False,
) -> Result:
    """The same of a scene that is read; origin: what errors name it, its name unless given; stiffness: compute that at the
    nut's centre even where nothing that is printed needs it: without axial force."""
    from rollbench.compare.models.answers import Answers, tangent_at_nut, tangent_of
    from rollbench.compare.models.load_cases import solve_any, together
    from rollbench.compare.models.registry import default_model
    from rollbench.compare.results.solved import result_of

    solved, tangents, at_nut = [], [], []
    for scene in each_case(described, origin or described.name):
        with named(scene.name, origin or scene.name):
            chosen, tangent = model or default_model(scene), None
            if isinstance(scene, Assembly) and stiffness_at is not None:
                scene = replace(scene, stiffness_at=stiffness_at)
            one = solve_any(scene, chosen, options)
            if isinstance(scene, Scene) and stiffness_at is not None and one.answers is not None:
                tangent = tangent_of(scene, stiffness_at, chosen, options)
            K = one.answers.at_nut if isinstance(one.answers, Answers) else None
            if K is None and stiffness and isinstance(scene, Scene) and one.answers is not None:
                K, _ = tangent_at_nut(scene, chosen, options)
            solved.append(one)
            tangents.append(tangent)
            at_nut.append(K)
    if not isinstance(described, DutyCycle):
        return result_of(solved, tangents, at_nut)
    return result_of(solved, tangents, at_nut, described, together(described, solved))


@held_to_one_thread()
def load_curve(scene: Described | str | Path, loads: str, model: str = "", *, member: int = 0) -> LoadCurve:
    """Displacement and stiffness over a force of either sign, lash and the stiffness outside it.

    loads: as `rollbench solve --curve` takes them, ``"-3000N:3000N"``: forces in place of the scene's loads, along the axis
    at the nut's centre (of several sets where the loads act) unless ``:x``, ``:45deg``, ``:300mm`` or the name of a housing
    follow; ``"0:1.5"``: times all loads of the scene; model: refined unless given; member: as in `solve`. Of load cases the
    first. Raises InputError; a load without equilibrium is a point with its status.
    """
    from rollbench.compare.models.registry import Options

    origin = str(scene) if isinstance(scene, (str, Path)) else ""
    return load_curve_of(_described(scene), loads, model, Options(member=member), origin)


def load_curve_of(described: Described, loads: str, model: str, options: Options, origin: str = "") -> LoadCurve:
    """The same of a scene that is read; origin: what errors name it."""
    from rollbench.compare.results.load_curve import load_curve, read_course

    course = read_course(loads)
    scene: Scene | Assembly = each_case(described, origin or described.name)[0]
    with named(scene.name, origin or scene.name):
        return load_curve(scene, course, model, options)


@held_to_one_thread()
def side_by_side(
    scenes: Sequence[Described | str | Path], *, model: str = "", member: int = 0, stiffness_at: float | None = None
) -> SideBySide:
    """Two scenes or more side by side, such as one axis on ball bearings and on tapered rollers: stiffness, torque, life.

    model: of all, refined unless given; member: as in `solve`; stiffness_at [m]: of several sets, where the stiffness is
    taken in all of them, in place of where each asks for it. Of load cases the first, and the life over all. Raises
    InputError; a scene without equilibrium has its status and no numbers.
    """
    origins = [str(x) if isinstance(x, (str, Path)) else x.name for x in scenes]
    described = [_described(x) for x in scenes]
    return side_by_side_described(described, origins, model, member, stiffness_at)


def side_by_side_described(
    described: Sequence[Described], origins: Sequence[str], model: str, member: int, stiffness_at: float | None
) -> SideBySide:
    """The same of scenes that are read; origins: what errors name them, and headings where two have one name."""
    from rollbench.compare.models.registry import Options
    from rollbench.compare.results.side_by_side import side_by_side_of

    if len(described) < 2:
        raise ArgumentError("scenes", str(len(described)), "two scenes or more", "`solve` answers one")
    options, names = Options(member=member), [x.name for x in described]
    pairs = zip(described, origins, strict=True)
    found = [solve_described(x, model, options, stiffness_at, origin, stiffness=True) for x, origin in pairs]
    return side_by_side_of(found, names if len(set(names)) == len(names) else origins)


@held_to_one_thread()
def friction(scene: Described | str | Path, *, mu: Sequence[float] = (), model: str = "") -> Friction:
    """Ball motion, losses, friction torque, efficiency, of a scene of any kind.

    mu: coefficients of friction in place of the scene's; model: of the contact loads, refined unless given. The first use
    compiles kernels for some 20 s. Raises InputError.
    """
    from rollbench.compare.studies.friction.solve import library

    data = library(_described(scene), tuple(mu), model)
    return friction_of(data)


@held_to_one_thread()
def ensemble(
    scene: Described | str | Path, members: int, model: str = "", *, seed: int | None = None, workers: int | None = None
) -> Ensemble:
    """Many specimens of a scene with random errors: distributions of the largest load, stiffness, lost contacts, life.

    members: how many; model: refined unless given; seed: of the random errors in place of the scene's; workers: parallel
    processes. Raises InputError.
    """
    from rollbench.compare.studies.members.members import library

    return ensemble_of(library(_described(scene), model, members, seed, workers, LOG.info))


@held_to_one_thread()
def compare_models(
    scene: Described | str | Path,
    models: Sequence[str] = (),
    *,
    levels: int | None = None,
    reference: str | Path | None = None,
    store: str | Path = "rollbench-reference",
) -> Comparison:
    """Low-order models compared with the 3D reference: for each model its errors in per cent of the mean load, its
    largest load, pressure and displacement.

    models: those that the report compares unless given; levels: mesh levels to compute where they are not stored (None:
    the best stored reference; all levels where there is none, which takes long); reference: your own, in place of the 3D
    reference; store: folder of the reference's runs. Raises InputError, Refusal where no run of the reference converged.
    """
    from rollbench.compare.models.comparison import compared_models
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.results.comparison import comparing, comparison_of
    from rollbench.meshes.cache import default_root

    if reference is not None and levels is not None:
        raise ArgumentError("reference", str(reference), "without `levels`", "leave one out")
    described = _described(scene)
    found = comparing(
        [described],
        [_origin(scene, described)],
        compared_models(tuple(models)),
        Engine(cache=default_root()),
        LOG.info,
        store=Path(store),
        levels=None if levels is None else range(1, levels + 1),
        otherwise=range(1, len(LEVELS) + 1),
        reference=None if reference is None else Path(reference),
    )
    return comparison_of(described, list(found.each()), found.warnings)


@held_to_one_thread()
def check(
    scene: Described | str | Path,
    *,
    max_error: float | None = None,
    model: str = "",
    loads: str | Path | None = None,
    values: str | Path | None = None,
    limits: Mapping[str, float] | None = None,
    reference: str | Path | None = None,
    strict: bool = False,
    levels: int | None = None,
    store: str | Path = "rollbench-reference",
    compute: bool = True,
) -> Verdict:
    """The gate: whether a model's loads, or those of another program, agree with the 3D reference within a limit.

    max_error: limit in per cent, the scene's own or 7 unless given; loads: CSV file with the columns ball, flank, newton;
    values: CSV file with the columns quantity, value, unit, where; limits: of other quantities by name, in
    per cent, of a contact angle in degrees; reference: your own, in place of the 3D reference; strict: unknown columns are
    an error; compute: whether runs of the reference that are missing are computed. Raises InputError.
    """
    from rollbench.compare.gate.user import asked
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.results.verdict import verdict_of
    from rollbench.meshes.cache import default_root

    described = _described(scene)
    request = asked(
        model=model,
        loads=None if loads is None else Path(loads),
        values=None if values is None else Path(values),
        max_error=max_error,
        limits=[f"{name}={number}" for name, number in (limits or {}).items()],
        reference=None if reference is None else Path(reference),
        strict=strict,
        levels=levels,
        store=Path(store),
        compute=compute,
    )
    return verdict_of([described], [_origin(scene, described)], request, Engine(cache=default_root()), LOG.info)


@held_to_one_thread()
def mesh_study(
    scene: Described | str | Path,
    *,
    levels: int | None = None,
    spread: bool = False,
    store: str | Path = "rollbench-reference",
) -> MeshStudy:
    """The 3D reference on several mesh levels: what each level gives, observed orders, uncertainty of every contact.

    levels: 1 to this one; unless given, 1 and 3, of which the second is clearly more accurate; spread: modelling choices
    that are not printed are varied too, on the coarsest level; store: folder of the runs, where those that are missing are
    computed. Raises InputError, Refusal where no run converged.
    """
    from rollbench.compare.studies.mesh_study import library

    described = _described(scene)
    found = library(solvable(described, described.name), levels, LOG.info, spread=spread, store=Path(store))
    return mesh_study_of(*found)


@held_to_one_thread()
def sweep(
    scene: str | Path,
    vary: Sequence[str],
    *,
    samples: int = 256,
    method: Literal["sobol", "lhs", "grid"] = "sobol",
    model: str = "",
    seed: int = 0,
    out: str | Path = "rollbench-sweep",
    outputs: Sequence[str] = (),
) -> Sweep:
    """A scene solved at many values of its keys: statistics, effects and Sobol indices of its outputs.

    scene: name or file; vary: keys with their range or values, ``["errors.balls.oversize=0 um:7 um"]``; out: folder of the
    samples (samples.csv) and the summary: samples stored there are not solved again; outputs: names of the outputs that are
    computed, all unless given. Raises InputError.
    """
    from rollbench.compare.studies.sweep.summary import library

    data = library(str(scene), vary, samples, method, model, seed, Path(out), outputs, LOG.info)
    return sweep_of(data, Path(out))


@held_to_one_thread()
def table(
    scene: str | Path,
    over: Sequence[str] = (),
    *,
    quantities: Sequence[str] = (),
    model: str = "",
    stiffness_at: float | str | None = None,
) -> Table:
    """A scene at places of its keys: 6 x 6 tangent stiffness [N/m, N/rad, N m/rad], preload, pressure, life, and the error
    to expect of each; a place without an answer is a row whose status says why.

    scene: name or file; over: keys with their values, ``["nut.position=100:900:9 mm", "load=1:10:4 kN"]``; quantities:
    stiffness, displacement, load, preload, pressure, life, without the second and third unless given; stiffness_at: place
    on the shaft [m], the nut's centre unless given; of several sets also the name of one. Raises InputError.
    """
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.studies.table import asked_for, solve_table
    from rollbench.meshes.cache import default_root

    return solve_table(asked_for(str(scene), over, quantities, model, stiffness_at), Engine(cache=default_root()), LOG.info)


@held_to_one_thread()
def survey(model: str | Sequence[str], *, count: int = 240, max_error: float = 7.0, workers: int | None = None) -> Survey:
    """How wrong a model is on ball screws drawn as catalogues have them, against stored loads of the 3D reference.

    model: one or several, by name or as `rollbench.model_command` gives it; refined and lin stand beside them as the
    survey's record has them; count: of the first screws; max_error: limit of the verdicts in per cent; workers: parallel
    processes. A screw without answer is a row with its reason. Raises InputError, also where a model fails on each of the
    first screws.
    """
    from rollbench.compare.studies.survey_models import run_models

    return survey_of(run_models([model] if isinstance(model, str) else model, count, workers, max_error, LOG.info))


def _described(scene: Described | str | Path) -> Described:
    return read(scene) if isinstance(scene, (str, Path)) else scene


def _origin(scene: Described | str | Path, described: Described) -> str:
    """What errors name a scene."""
    return str(scene) if isinstance(scene, (str, Path)) else described.name
