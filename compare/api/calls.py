"""Functions of ``import rollbench``: each computes what the command of the same name prints, and returns a record.

Linear algebra runs on one thread while a function runs; the former number of threads is restored when the function returns.
``OMP_NUM_THREADS``, or the variable of one library such as ``OPENBLAS_NUM_THREADS``, takes precedence where it is set.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import partial
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from rollbench.compare.errors import ArgumentError, show_file_in_scene_errors
from rollbench.compare.results.data import Ensemble
from rollbench.compare.results.friction import Friction
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle, FrictionScene
from rollbench.compare.scenes.scene_file import scene_or_shaft_or_raise, scenes_to_solve
from rollbench.meshes.axis import Assembly
from rollbench.meshes.processes import limited_to_one_thread

if TYPE_CHECKING:
    from rollbench.compare.models.model import ModelOptions
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.results.comparison import Comparison
    from rollbench.compare.results.load_curve import LoadCurve
    from rollbench.compare.results.mesh_study import MeshStudy
    from rollbench.compare.results.side_by_side import SideBySide
    from rollbench.compare.results.solved import Result
    from rollbench.compare.results.table import Table
    from rollbench.compare.results.verdict import Verdict
    from rollbench.compare.studies.survey_models import Survey
    from rollbench.compare.studies.sweep.run import Sweep

#: Logger that reports the progress of long computations; ``logging.basicConfig(level="INFO")`` shows its messages.
LOG = logging.getLogger("rollbench")


def read(name: str | Path) -> Described:
    """Read a scene (parts, supports and loads) from a TOML file, or by name one that is included with rollbench.

    Parameters
    ----------
    name
        Path of a scene file, or a name that ``rollbench list`` shows.

    Returns
    -------
    Scene or Assembly or DutyCycle or FrictionScene
        Frozen record in SI units: one ball nut or bearing (`Scene`), several nuts or bearings on one shaft (`Assembly`),
        a scene with several load cases (`DutyCycle`), or parts for which only friction is computed (`FrictionScene`).
        ``dataclasses.replace`` makes changed copies.

    Raises
    ------
    rollbench.InputError
        If no scene has this name, or if its file has faults; ``lines()`` of the error lists all faults.

    Examples
    --------
    >>> import rollbench
    >>> scene = rollbench.read("lin-case1")
    >>> scene.ball_count, scene.track.lead, scene.loads[0].force
    (32, 0.02, (0.0, 0.0, 5000.0))
    """
    return catalogue.scene_of_any_kind(str(name))


def new(size: str = "", *, kind: str = "ball screw") -> Described:
    """Make a scene to start from, with dimensions that are usual for a part of its kind and size.

    Parameters
    ----------
    size
        Nominal diameter and lead of a ball screw or double nut in mm, such as ``"40x10"``. If empty, the scene is a fixed
        example of its kind.
    kind
        Kind of the scene: ``"ball screw"``, ``"bearing"``, ``"double-nut"`` or another that ``rollbench new --help`` lists.

    Returns
    -------
    Scene or Assembly or FrictionScene
        The scene, complete: it can be solved without changes.

    Raises
    ------
    rollbench.InputError
        If the size does not have the form ``"40x10"``, if no screw of this size can be made, or if the kind is unknown or
        takes no size.

    Examples
    --------
    >>> import rollbench
    >>> rollbench.new("40x10").track.lead
    0.01
    """
    from rollbench.compare.scenes.template import new_scene_text

    return scene_file.parse_scene(new_scene_text(kind, size), size or kind)


@limited_to_one_thread()
def solve(
    scene: Described | str | Path,
    model: str = "",
    *,
    member: int = 0,
    everything: bool = False,
    condensed: str | Path | None = None,
    stiffness_at: float | None = None,
    store: str | Path | None = None,
) -> Result:
    """Compute the contact loads of a scene with a low-order model, and the stiffness, life and pressures that follow.

    Parameters
    ----------
    scene
        Scene as `read` returns it, its name, or the path of its file.
    model
        Name of a low-order model (``rollbench list`` shows all), or the model that `model_command` returns. If empty, the
        refined model solves the scene.
    member
        Number of the specimen, from 0, of a scene with random geometric errors; each specimen has its own errors.
    everything
        Whether the model also includes parts that cannot change the contact loads of this scene, such as groove flanks that
        no ball can touch, and unloaded ends of the shaft.
    condensed
        File that ``rollbench condense`` wrote, with the compliance of screw and nut from the 3D mesh. If it is given and
        ``model`` is empty, the model is ``"condensed"``.
    stiffness_at
        Axial position on the shaft [m] at which the stiffness is computed. If None, the nut's centre, or for several nuts
        or bearings on one shaft the position that the scene states.
    store
        Folder in which every load case of several is stored once solved; stored ones are not solved again. None: none.

    Returns
    -------
    Result
        Loads, contact angles, pressures, displacement, stiffness and life in SI units, and the errors [%] to expect of the
        model against the 3D finite-element reference. If no equilibrium exists, no exception is raised: `Result.status` and
        `Result.reason` say why there is none.

    Raises
    ------
    rollbench.InputError
        If scene or model cannot be read, the model does not cover the scene, or ``store`` is given and the scene has one
        load case, or the folder contains another computation.

    Examples
    --------
    >>> import rollbench
    >>> result = rollbench.solve("lin-case1", "lin")
    >>> result.loads.shape, round(float(result.loads.max()))
    ((32, 4), 243)
    >>> round(1e6 * float(result.displacement[2]), 1)  # of the section on which the load acts, along z, in um
    33.7
    """
    from rollbench.compare.models.model import ModelOptions

    options = ModelOptions(everything, member, condensed_bodies_file=None if condensed is None else Path(condensed))
    origin = str(scene) if isinstance(scene, (str, Path)) else ""
    chosen = model or ("" if condensed is None else "condensed")
    return solve_scene_record(_scene_record(scene), chosen, options, stiffness_at, origin, stiffness=True, store=store)


def solve_scene_record(
    described: Described,
    model: str,
    options: ModelOptions,
    stiffness_at: float | None = None,
    name_for_messages: str = "",
    *,
    stiffness: bool = False,
    store: str | Path | None = None,
) -> Result:
    """Solve a scene that has already been read from its file, as `solve` does.

    Parameters
    ----------
    described
        The scene, with all its load cases.
    model
        Name of the model; if empty, each load case is solved by its default model.
    options
        Options of the model.
    stiffness_at
        Axial position on the shaft [m] at which the stiffness is computed; None: as for `solve`.
    name_for_messages
        File or name by which error messages refer to the scene; if empty, the name of the scene.
    stiffness
        Whether the 6 x 6 stiffness at the nut's centre of a single nut or bearing row is computed.
    store
        Folder of solved load cases, as for `solve`.

    Returns
    -------
    Result
        The result, with the result of each load case in ``cases``.

    Raises
    ------
    rollbench.InputError
        If the model does not cover the scene, or if ``store`` cannot be used.
    """
    from rollbench.compare.models.many import in_order, solve_many, stored_in
    from rollbench.compare.models.registry import default_model_name
    from rollbench.compare.results.solving import combine_load_cases, solve_with_results

    if isinstance(described, DutyCycle):
        cases = {k: (case.scene, model, options, stiffness_at, name_for_messages) for k, case in enumerate(described.cases)}
        stored = stored_in(store, "load cases", model, described, *options.inputs, stiffness_at, stiffness)
        solved = solve_many(partial(solve_scene_record, stiffness=stiffness), cases, stored=stored)
        return combine_load_cases(described, [result for _, result in in_order(solved, [*cases])])
    if store is not None:
        given, advice = "this option for a scene with one load case", "leave it out"
        raise ArgumentError("store", given, "only for what solves several load cases, loads, specimens or scenes", advice)
    if isinstance(described, FrictionScene):
        raise scene_file.friction_only_error(described, name_for_messages or described.name)
    with show_file_in_scene_errors(described.name, name_for_messages or described.name):
        chosen = model or default_model_name(described)
        return solve_with_results(described, chosen, options, stiffness_at, stiffness=stiffness)


@limited_to_one_thread()
def load_curve(
    scene: Described | str | Path,
    loads: str,
    model: str = "",
    *,
    member: int = 0,
    everything: bool = False,
    condensed: str | Path | None = None,
    store: str | Path | None = None,
) -> LoadCurve:
    """Solve a scene under a range of loads: displacement and stiffness as functions of the load, and the backlash.

    Parameters
    ----------
    scene
        Scene, its name or the path of its file, as for `solve`. Of several load cases only the first is solved.
    loads
        Range of loads. ``"LOW:HIGH"`` with a unit, such as ``"-3000N:3000N"``: axial forces that replace the scene's loads
        and act where the scene's own load acts (without one: at the nut's centre, or at ``stiffness_at``). Without a
        unit, such as ``"0:1.5"``: factors by which all loads of the scene are multiplied. There may follow, each after a
        colon, the number of points (2 to 1001, 21 if left out), the direction of the force (``x``, ``45deg``), and the
        axial position or the housing on which the force acts (``300mm``): ``"-3kN:3kN:41:x"``.
    model
        Name of the model, as for `solve`.
    member, everything, condensed
        Number of the specimen, terms of the model and file of condensed bodies, as for `solve`.
    store
        Folder in which every group of points is stored once solved; stored ones are not solved again. None: none.

    Returns
    -------
    LoadCurve
        A point for each load. A point without equilibrium has no numbers; its ``status`` says why.

    Raises
    ------
    rollbench.InputError
        If the text of ``loads`` is no valid range, if scene or model cannot be used (see `solve`), or if the folder
        contains another computation.

    Examples
    --------
    >>> import rollbench
    >>> curve = rollbench.load_curve("lin-case1", "-3000N:3000N:5", "lin")
    >>> [round(1e6 * point.displacement, 1) for point in curve.points]
    [-22.4, -12.9, 0.0, 12.9, 22.3]
    """
    from rollbench.compare.models.many import stored_in
    from rollbench.compare.models.model import ModelOptions
    from rollbench.compare.results.load_curve import compute_load_curve, read_load_range

    course, described = read_load_range(loads), _scene_record(scene)
    name = _scene_name_for_messages(scene, described)
    options = ModelOptions(everything, member, condensed_bodies_file=None if condensed is None else Path(condensed))
    solved = scenes_to_solve(described, name)[0]
    with show_file_in_scene_errors(solved.name, name):
        stored = stored_in(store, "load curve", model, solved, course, *options.inputs)
        return compute_load_curve(solved, course, model or ("" if condensed is None else "condensed"), options, stored)


@limited_to_one_thread()
def side_by_side(
    scenes: Sequence[Described | str | Path],
    *,
    model: str = "",
    member: int = 0,
    stiffness_at: float | None = None,
    store: str | Path | None = None,
) -> SideBySide:
    """Solve two or more scenes with one model and compare their stiffness, torque and life.

    Parameters
    ----------
    scenes
        At least two scenes, each as for `solve`, such as the same feed axis with ball bearings and with tapered roller
        bearings. Of several load cases the first is compared; the life is that under all load cases.
    model
        Name of the model that solves all scenes, as for `solve`.
    member
        Number of the specimen, as for `solve`.
    stiffness_at
        Axial position [m] at which the stiffness is computed in scenes with several nuts or bearings on one shaft. If None,
        the position that each scene states.
    store
        Folder in which every scene is stored once solved; stored ones are not solved again. None: none.

    Returns
    -------
    SideBySide
        An `Alternative` for each scene. A scene without equilibrium has a status and no numbers.

    Raises
    ------
    rollbench.InputError
        If there are fewer than two scenes, if a scene or the model cannot be used (see `solve`), or if the folder contains
        another computation.

    Examples
    --------
    >>> import rollbench
    >>> both = rollbench.side_by_side(["lin-case1", "lin-case2"], model="lin")
    >>> [round(1e6 * one.load_point_displacement, 1) for one in both.scenes]
    [33.7, 33.5]
    >>> [round(x, 1) for x in both.difference_percent("largest_load_N")]
    [0.0, 16.0]
    """
    from rollbench.compare.models.many import in_order, solve_many, stored_in
    from rollbench.compare.models.model import ModelOptions
    from rollbench.compare.results.side_by_side import compare_results_side_by_side

    origins = [str(x) if isinstance(x, (str, Path)) else x.name for x in scenes]
    described = [_scene_record(x) for x in scenes]
    if len(described) < 2:
        raise ArgumentError("scenes", f"{len(described)} scene(s)", "at least two scenes", "use `solve` for one scene")
    options, names = ModelOptions(member=member), [x.name for x in described]
    solve = partial(solve_scene_record, stiffness=True)
    pairs = enumerate(zip(described, origins, strict=True))
    rows = {k: (x, model, options, stiffness_at, origin) for k, (x, origin) in pairs}
    stored = stored_in(store, "scenes side by side", model, described, *options.inputs, stiffness_at)
    found = [result for _, result in in_order(solve_many(solve, rows, stored=stored), [*rows])]
    return compare_results_side_by_side(found, names if len(set(names)) == len(names) else origins)


@limited_to_one_thread()
def friction(scene: Described | str | Path, *, mu: float | Sequence[float] = (), model: str = "") -> Friction:
    """Compute the motion of the rolling bodies, power loss, friction torque and efficiency of a scene.

    Parameters
    ----------
    scene
        Scene of any kind, as `read` returns it, its name, or the path of its file.
    mu
        Coefficient of friction in both grooves, or several of them, which replace the scene's. If several are given, the
        fields of the result belong to the first; ``over`` has the torques for each.
    model
        Name of the model that computes the contact loads, as for `solve`.

    Returns
    -------
    Friction
        Torques [N m], power loss [W] and efficiencies. ``converged`` is False if no motion was found in which the contact
        loads and the friction forces balance.

    Raises
    ------
    rollbench.InputError
        If neither the scene nor ``mu`` states a coefficient of friction, or if scene or model cannot be used (see `solve`).

    Examples
    --------
    >>> import rollbench
    >>> found = rollbench.friction("lin-case1", model="lin")
    >>> round(found.torque, 3), round(found.efficiency_forward, 3)
    (0.838, 0.95)
    """
    from rollbench.compare.studies.friction import solve
    from rollbench.compare.studies.friction.whole import FrictionChoices

    described = _scene_record(scene)
    coefficients = (mu,) if isinstance(mu, (Real, float, str)) else tuple(mu)
    for one in coefficients:
        _check_numbers(mu=one)
    return solve.solve_friction_of_scene(described, FrictionChoices(model, coefficients), described.name)


@limited_to_one_thread()
def ensemble(
    scene: Described | str | Path,
    members: int,
    model: str = "",
    *,
    seed: int | None = None,
    workers: int | None = None,
    store: str | Path | None = None,
) -> Ensemble:
    """Solve many specimens of a scene with random geometric errors, and return the scatter of load, stiffness and life.

    Parameters
    ----------
    scene
        Scene with random geometric errors, its name or file.
    members
        Number of specimens, at least 2. Each has its own random errors.
    model
        Name of the model, as for `solve`.
    seed
        Seed of the random numbers; None: the seed of the scene.
    workers
        Number of parallel processes; None: one for each core.
    store
        Folder in which every block of specimens is stored once solved; stored ones are not solved again. None: none.

    Returns
    -------
    Ensemble
        Statistics of each output over the specimens that have an equilibrium, and the reasons why the others have none.

    Raises
    ------
    rollbench.InputError
        If the scene has no random errors, if scene or model cannot be used (see `solve`), or if the folder contains
        another computation.

    Examples
    --------
    >>> import rollbench
    >>> several = rollbench.ensemble("lin-random", 4, "lin", workers=1)
    >>> several.converged, round(several.outputs["largest_load_N"].mean)
    (4, 350)
    """
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.studies.members.members import solve_random_draws_of_load_cases

    _check_numbers(members=members, seed=seed, workers=workers)
    described, engine = _scene_record(scene), ComputingSettings(parallel_jobs=workers)
    name, say = described.name, LOG.info
    return solve_random_draws_of_load_cases(described, name, model, members, seed, engine, say, store=store)


@limited_to_one_thread()
def compare_models(
    scene: Described | str | Path,
    models: Sequence[str] = (),
    *,
    levels: int | None = None,
    reference: str | Path | None = None,
    store: str | Path = "rollbench-reference",
) -> Comparison:
    """Compare low-order models with the 3D finite-element reference: errors of loads, largest pressure and displacement.

    Parameters
    ----------
    scene
        Scene, its name or the path of its file.
    models
        Names of the models. If empty, all models of the validation report that cover the scene.
    levels
        Number of mesh levels to use, counted from the coarsest; runs that are not stored yet are computed. If None, the
        most accurate stored run is used; if no run is stored, all levels are computed, which takes minutes to hours.
    reference
        CSV file with contact loads, in the columns of the argument ``loads`` of `check`; it replaces the 3D reference.
    store
        Folder in which runs of the 3D reference are looked up and stored, in addition to the runs included with rollbench.

    Returns
    -------
    Comparison
        Errors of each model in per cent of the mean contact load of the reference.

    Raises
    ------
    rollbench.InputError
        If scene, model or reference cannot be used; the subclass ``SceneNotCoveredError`` if no run of the 3D reference
        converged.

    Examples
    --------
    >>> import rollbench
    >>> comparison = rollbench.compare_models("lin-case1", ["refined", "mei"])
    >>> {name: round(comparison.errors[name], 1) for name in ("refined", "mei")}
    {'refined': 0.2, 'mei': 19.1}
    """
    from rollbench.compare.models.registry import model_by_name
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.results.comparing import make_comparison, prepare_comparison

    if reference is not None and levels is not None:
        allowed, advice = "either a reference file or `levels`", "leave out one of the two arguments"
        raise ArgumentError("reference", str(reference), allowed, advice)
    described = _scene_record(scene)
    found = prepare_comparison(
        [described],
        [_scene_name_for_messages(scene, described)],
        [model_by_name(name, "models") for name in models],
        _computing_settings(),
        LOG.info,
        store=Path(store),
        levels=None if levels is None else range(1, levels + 1),
        otherwise=range(1, len(LEVELS) + 1),
        reference=None if reference is None else Path(reference),
    )
    return make_comparison(described, list(found.compare_each()), found.warnings)


@limited_to_one_thread()
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
    """Judge whether contact loads agree with those of the 3D finite-element reference within a limit.

    Parameters
    ----------
    scene
        Scene, its name or the path of its file.
    max_error
        Largest permitted error of a contact load [% of its reference load; of the mean load for loads below a tenth of
        the mean]; None: the limit that the scene states, or 7.
    model
        Name of the model whose loads are judged, as for `solve`.
    loads
        CSV file with contact loads of another program, which are judged instead of a model's: columns ball, flank (SL, SR,
        NL or NR: screw or nut, left or right), newton.
    values
        CSV file with further values that are judged: columns quantity (displacement, rigidity, torque, life),
        value, unit, where (a load such as 5 kN, or an axial position).
    limits
        Permitted errors of further quantities, by the quantity's name: in %, for contact angles in degrees.
    reference
        CSV file with contact loads and their uncertainty, which replaces the 3D reference; columns as for ``loads``.
    strict
        Whether unknown columns of the files are an error, and a model's result outside its range of validity fails (True);
        or both are only said (False).
    levels
        Number of mesh levels of the 3D reference, counted from the coarsest; None: those that are stored, at least two.
    store
        Folder in which runs of the 3D reference are looked up and stored, in addition to the runs included with rollbench.
    compute
        Whether missing runs of the 3D reference are computed. If False, a quantity without a stored run is "not covered".

    Returns
    -------
    Verdict
        A row for each quantity with its judgement, such as pass, undecided or fail, and the worst of these judgements. It
        is true only if all rows pass.

    Raises
    ------
    rollbench.InputError
        If the scene, a file or a limit cannot be used.

    Examples
    --------
    >>> import rollbench
    >>> assert rollbench.check("lin-case1")  # a verdict is true if it passed; "undecided" is false
    >>> verdict = rollbench.check("lin-case1", model="lin")
    >>> verdict.word, round(verdict.worst.error, 1), verdict.worst.limit
    ('fail', 7.3, 7.0)
    """
    from rollbench.compare.gate.user import GateRequest
    from rollbench.compare.results.verdict import judge_scenes

    described = _scene_record(scene)
    _check_numbers(max_error=max_error, levels=levels)
    request = GateRequest(
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
    return judge_scenes([described], [_scene_name_for_messages(scene, described)], request, _computing_settings(), LOG.info)


@limited_to_one_thread()
def mesh_study(
    scene: Described | str | Path,
    *,
    levels: int | None = None,
    spread: bool = False,
    store: str | Path = "rollbench-reference",
) -> MeshStudy:
    """Solve the 3D reference on several mesh levels, and return its convergence and the uncertainty of every contact load.

    Parameters
    ----------
    scene
        Scene, its name or the path of its file.
    levels
        Number of the finest mesh level; all levels from 1 (the coarsest) to this one are compared. An order of convergence
        needs three levels. None: levels 1 and 3.
    spread
        Whether modelling choices that the publication of the scene leaves open are also varied, on the coarsest level.
    store
        Folder in which runs of the 3D reference are looked up and stored, in addition to the runs included with rollbench.
        Missing runs are computed, which takes minutes to hours.

    Returns
    -------
    MeshStudy
        The mesh levels, and for each quantity its values, observed order of convergence and uncertainty. For a scene with
        tapered roller bearings, all bearings with equal rollers have one common entry, which lists the bearings' names.

    Raises
    ------
    rollbench.InputError
        If the scene cannot be used; the subclass ``SceneNotCoveredError`` if no run converged.

    Examples
    --------
    >>> import rollbench
    >>> study = rollbench.mesh_study("lin-case1-cut")
    >>> [(one.level, round(one.difference, 2)) for one in study.levels]  # largest difference of a load in %
    [(1, 0.08), (3, 0.0)]
    """
    from rollbench.compare.studies import roller
    from rollbench.compare.studies.mesh_study import run_mesh_study

    _check_numbers(levels=levels)
    described = _scene_record(scene)
    if isinstance(described, Assembly) and roller.has_rollers(described):
        return roller.run_roller_mesh_study(described, levels, LOG.info, Path(store))
    target = scene_or_shaft_or_raise(described, described.name)
    return run_mesh_study(target, levels, LOG.info, spread=spread, store=Path(store))


@limited_to_one_thread()
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
    """Solve a scene for sampled values of its parameters, and return statistics and Sobol indices of the outputs.

    Parameters
    ----------
    scene
        Name or file of the scene.
    vary
        Keys of the scene file that are varied, each with its range or values: ``["errors.balls.oversize=0 um:7 um"]``; one
        key may be a text.
    samples
        Number of samples. For ``"grid"`` it is an upper limit; for ``"sobol"`` it is approximate, because that design needs
        n (k + 2) samples for k keys, with n a power of two.
    method
        Design of the samples: Sobol sequence, Latin hypercube, or all combinations (``"grid"``).
    model
        Name of the model, as for `solve`.
    seed
        Seed of the random numbers that determine the samples.
    out
        Folder for the samples (``samples.csv``) and the summary. Samples that are stored there are not solved again.
    outputs
        Names of the outputs to compute; if empty, all.

    Returns
    -------
    Sweep
        Statistics of each output over the samples, and Sobol indices if the method is ``"sobol"``.

    Raises
    ------
    rollbench.InputError
        If a key, range, output or model cannot be used, or if the folder contains another computation.

    Examples
    --------
    >>> import rollbench, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     vary = ["errors.balls.oversize=0 um,2 um"]
    ...     found = rollbench.sweep("lin-case1", vary, method="grid", model="lin", out=folder)
    >>> found.converged, round(found.outputs["largest_load_N"].largest)
    (2, 245)
    """
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.studies.sweep.run import solve_sweep, sweep_definition

    _check_numbers(samples=samples, seed=seed)
    what = sweep_definition(str(scene), vary, samples, method, seed, model, outputs)
    return solve_sweep(what, Path(out), ComputingSettings(), LOG.info)


@limited_to_one_thread()
def table(
    scene: str | Path,
    over: Sequence[str] = (),
    *,
    quantities: Sequence[str] = (),
    model: str = "",
    stiffness_at: float | str | None = None,
    store: str | Path | None = None,
) -> Table:
    """Solve a scene for listed values of its parameters, and return a row with stiffness, preload and life for each.

    Parameters
    ----------
    scene
        Name or file of the scene.
    over
        Keys of the scene file with their values, written as first value, last value and number of values:
        ``["nut.position=100:900:9 mm", "load=1:10:4 kN"]``.
    quantities
        Columns of the table, out of ``stiffness``, ``displacement``, ``load``, ``preload``, ``pressure``, ``life``. If
        empty, all but displacement and load.
    model
        Name of the model, as for `solve`.
    stiffness_at
        Axial position on the shaft [m] at which the stiffness is computed. With several nuts or bearings on the shaft, also
        the name of one of them, for the stiffness of this nut or bearing alone. None: the nut's centre.
    store
        Folder in which every row is stored as soon as it is solved; rows that it holds are not solved again. None: none.

    Returns
    -------
    Table
        Rows with the 6 x 6 tangent stiffness [N/m, N/rad, N m/rad], the other quantities, and the errors to expect of the
        model against the 3D reference. A row without equilibrium has a status that says why.

    Raises
    ------
    rollbench.InputError
        If a key, its values, a quantity or the model cannot be used, or if the folder contains another computation.

    Examples
    --------
    >>> import rollbench
    >>> stiffness = rollbench.table("lin-case1", ["load=2:6:3 kN"], model="lin").stiffness
    >>> [round(float(K[2, 2]) / 1e6) for K in stiffness]  # axial stiffness in N/um
    [301, 381, 438]
    """
    from rollbench.compare.studies.table import check_table_request, solve_table

    request = check_table_request(str(scene), over, quantities, model, stiffness_at)
    return solve_table(request, _computing_settings(), LOG.info, store)


@limited_to_one_thread()
def survey(
    model: str | Sequence[str],
    *,
    count: int = 360,
    max_error: float = 7.0,
    workers: int | None = None,
    store: str | Path | None = None,
) -> Survey:
    """Compare models with stored loads of the 3D reference on up to 360 random ball screws.

    Parameters
    ----------
    model
        Name of a model, the model that `model_command` returns, or a list of these. Stored results of the models refined
        and lin are always added for comparison.
    count
        Number of screws to solve, counted from the first of the 360. Their dimensions are within the range of catalogues.
    max_error
        Largest error that passes [% of the mean contact load].
    workers
        Number of parallel processes; None: one for each core.
    store
        Folder in which each solved screw is stored, and from which an interrupted run of the same model resumes.

    Returns
    -------
    Survey
        Errors of each model on each screw. If a model does not solve a screw, the row states the reason.

    Raises
    ------
    rollbench.InputError
        If a model cannot be used, or fails on each of the first screws.

    Examples
    --------
    >>> import rollbench
    >>> found = rollbench.survey("lin-printed-hertz", count=4, workers=1)
    >>> {name: round(error, 1) for name, error in found.median.items()}
    {'lin-printed-hertz': 15.2, 'refined': 0.4, 'lin': 2.6}
    """
    from rollbench.compare.studies.survey_models import compare_models_on_random_screws

    _check_numbers(count=count, max_error=max_error, workers=workers)
    models = [model] if isinstance(model, str) else list(dict.fromkeys(model))
    return compare_models_on_random_screws(models, count, workers, max_error, LOG.info, store)


def _computing_settings() -> ComputingSettings:
    """Return the settings by which missing 3D runs are computed: on this machine, with the usual cache of meshes."""
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.meshes.cache import default_cache_folder

    return ComputingSettings(cache_folder=default_cache_folder())


def _scene_record(scene: Described | str | Path) -> Described:
    """Return the record of a scene that is given as record, name or file."""
    if isinstance(scene, (str, Path)):
        return catalogue.scene_of_any_kind(str(scene))
    if hasattr(scene, "name") and hasattr(scene, "title"):
        return scene
    advice = "read a file by `read`, or make a scene by `new`"
    raise ArgumentError("scene", repr(scene)[:80], "a scene, its name, or the path of its file", advice)


def _check_numbers(**numbers: object) -> None:
    """Raise ArgumentError for the first of some arguments that is neither a number nor None."""
    for argument, value in numbers.items():
        if value is not None and (isinstance(value, bool) or not isinstance(value, Real)):
            advice = "write a number without a unit and without quotation marks"
            raise ArgumentError(argument, repr(value)[:80], "a number", advice)


def _scene_name_for_messages(scene: Described | str | Path, described: Described) -> str:
    """Return the file or name by which error messages refer to a scene given as record, name or file."""
    return str(scene) if isinstance(scene, (str, Path)) else described.name
