"""Registry of the low-order models: their names, descriptions, and the functions that run them on a scene.

To add a model of rollbench, add its `Model` here; models of publications come from their cases (`compare.case`). A model of
another package registers itself by the entry point ``rollbench.models``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, overload

import numpy as np

from rollbench.compare.case import CASES
from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.files import similar_paths
from rollbench.compare.models import programs, user_models
from rollbench.compare.models.model import C_8, HALF_SPACES, Model, ModelOptions
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene, UnfitKey

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance
    from rollbench.lowfi.statics.result import AxisResult, StaticResult
    from rollbench.lowfi.together import Search

#: Number of balls of a scene that is solved alone; of scenes with a tenth of it a hundred are solved together, in as much
#: memory.
LARGEST_TOGETHER = 400


def _solve_lin(scene: Scene, options: ModelOptions) -> StaticResult:
    """Solve a scene by the model "lin", the low-order model of Lin's thesis: beam screw, rigid nut, Hertz contacts."""
    from rollbench.lowfi.statics.static import solve_static

    return solve_static(
        scene,
        everything=options.include_ineffective_terms,
        member=options.member,
        discretisation=options.estimate_beam_mesh_error,
    )


def read_condensed_bodies(scene: Scene, options: ModelOptions) -> CondensedCompliance:
    """Read the stiffness of screw and nut, condensed to the contacts, from ``options.condensed_bodies_file``.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    options
        Options that name the file.

    Returns
    -------
    CondensedCompliance
        Condensed stiffness of screw and nut.

    Raises
    ------
    InputError
        If the options name no file, or the file is missing or was made for other parts than those of the scene.
    """
    from rollbench.lowfi.compliance.bodies import CondensedCompliance

    if options.condensed_bodies_file is None:
        advice = "write such a file with rollbench condense, and pass it as `condensed=FILE`"
        raise InputError(scene.name, "model", '"condensed"', "condensed only with a file of condensed bodies", advice)
    try:
        return CondensedCompliance.read_checked(options.condensed_bodies_file, scene)
    except OSError as error:
        near = similar_paths(options.condensed_bodies_file) if isinstance(error, FileNotFoundError) else ""
        words = error.strerror or str(error), "a file of condensed bodies", near or "check the path"
    except ValueError as error:
        allowed = "a file that rollbench condense wrote for the parts of this scene"
        words = f"an unusable file: {error}", allowed, "write the file again with rollbench condense"
    raise InputError(str(options.condensed_bodies_file), "file", *words)


def _solve_with_elastic_bodies(scene: Scene, options: ModelOptions, *, name: str) -> StaticResult:
    """Solve a scene by a model (``name``) with elastic screw and nut, whose stiffness "condensed" reads from a file."""
    from rollbench.lowfi.compliance.parts import LADDER, REFINED
    from rollbench.lowfi.statics.static import solve_elastic, with_discretisation_error

    condensed = read_condensed_bodies(scene, options) if name == "condensed" else None
    solve = partial(
        solve_elastic,
        backend=REFINED if condensed is not None else LADDER[name],
        condensed=condensed,
        name=name,
        everything=options.include_ineffective_terms,
        member=options.member,
    )
    result = solve(scene)
    wanted = options.estimate_beam_mesh_error and result.converged and scene.ingredients.screw != "rigid"
    return with_discretisation_error(scene, result, solve) if wanted else result


def _solve_assembly_by_lin(assembly: Assembly, options: ModelOptions) -> AxisResult:
    """Solve a shaft with several nuts or bearing rows by the low-order model of Lin's thesis ("lin")."""
    from rollbench.lowfi.statics.axis.solve import solve_assembly

    return solve_assembly(assembly, member=options.member)


def _solve_assembly_elastically(assembly: Assembly, options: ModelOptions, *, name: str) -> AxisResult:
    """Solve a shaft with several nuts or bearing rows by the model ``name``, in which shaft and rings are elastic."""
    from rollbench.lowfi.compliance.parts import LADDER
    from rollbench.lowfi.statics.axis.solve import solve_assembly_with_elastic_bodies

    return solve_assembly_with_elastic_bodies(assembly, member=options.member, backend=LADDER[name], name=name)


_ALL = (
    Model(
        "refined",
        "elastic grooved screw, nut and balls with Hertz contacts, without a 3D solution; the default",
        "refined model",
        "screw, nut and balls elastic, by kernels",
        partial(_solve_with_elastic_bodies, name="refined"),
        partial(_solve_assembly_elastically, name="refined"),
        compliances="refined",
        compared=True,
        solves_hard_scenes=True,
        refinement_step=(4, "+ elastic grooved screw and nut, flanks and balls (the default)"),
    ),
    Model(
        "lin",
        "model of Lin's thesis (chapter 2, misprints corrected): beam screw, rigid nut, Hertz contacts; by least energy",
        "low-order model of Lin's thesis",
        C_8,
        _solve_lin,
        _solve_assembly_by_lin,
        compliances="lin",
        compared=True,
        refinement_step=(1, "Lin's model: screw as a beam, rigid nut"),
    ),
    Model(
        "lin-source-partition",
        "lin with beam elements of 15 mm inside the nut, as in Lin's thesis",
        "Lin's model, 15 mm beam elements in the nut",
        C_8,
        _solve_lin,
        _solve_assembly_by_lin,
        compliances="lin",
        compared=True,
        ingredients=(("partition", "source"),),
    ),
    Model(
        "lin-printed-hertz",
        "lin with the Hertz constants as Lin's thesis prints them (Table B.1, which has errors)",
        "Lin's model, the thesis's Hertz constants",
        C_8,
        _solve_lin,
        'use the model lin, with hertz = "as printed" under [ingredients]',
        compliances="lin",
        compared=True,
        ingredients=(("hertz", "as printed"),),
    ),
    Model(
        "lin-cell",
        "lin with the cross-section of the grooved shaft for the beam",
        "Lin's model, cross-section of the grooved shaft",
        f"screw a beam with the cross-section of the grooved shaft, nut rigid, {HALF_SPACES}",
        partial(_solve_with_elastic_bodies, name="lin-cell"),
        partial(_solve_assembly_elastically, name="lin-cell"),
        compliances="lin-cell",
        refinement_step=(2, "+ cross-section of the grooved shaft"),
    ),
    Model(
        "lin-nut",
        "lin-cell with the nut as a beam, too",
        "Lin's model, nut also a beam",
        f"screw and nut beams with their grooved cross-sections, {HALF_SPACES}",
        partial(_solve_with_elastic_bodies, name="lin-nut"),
        partial(_solve_assembly_elastically, name="lin-nut"),
        compliances="lin-nut",
        solves_hard_scenes=True,
        refinement_step=(3, "+ nut as a beam"),
    ),
    Model(
        "condensed",
        "refined, with the stiffness of screw and nut from a 3D model, read from a file that rollbench condense made",
        "refined model, bodies from the condensed 3D model",
        "screw, nut and balls from a condensed 3D model",
        partial(_solve_with_elastic_bodies, name="condensed"),
        "a file of condensed bodies contains one nut or bearing row",
        refinement_step=(5, "bodies from the condensed 3D model"),
    ),
    *(model for case in CASES if case.models for model in case.import_object(case.models)),
)
#: All models by name, in the order of tables.
MODELS: dict[str, Model] = {m.name: m for m in _ALL}


#: Models that solve a shaft with several nuts or bearing rows.
AXIS_MODELS = tuple(name for name, model in MODELS.items() if callable(model.solve_assembly_or_reason))
#: Default model.
DEFAULT = "refined"


def default_model_name(scene: Scene | Assembly) -> str:
    """Return the name of the default model of a scene.

    The name is `DEFAULT`, or "lin" if an inner ring sits on a housing that springs support, which no other model covers.
    """
    if isinstance(scene, Scene):
        return DEFAULT
    sprung = {h.name for h in scene.housings if h.stiffness is not None}
    sprung |= {name for j in scene.joints for name in (j.first, j.second)}
    return "lin" if any(s.carrier in sprung for s in scene.sets) else DEFAULT


def is_model_name(name: str) -> bool:
    """Return whether a name denotes a model of rollbench, a model of an installed package, or an external command."""
    return name in MODELS or programs.is_program_command(name) or name in user_models.entry_points_of_installed_models()


def model_by_name(name: str, argument: str = "model", excluded_names: Sequence[str] = ()) -> Model:
    """Return the record of a model: of rollbench, of an installed package (which is imported), or of an external command.

    Parameters
    ----------
    name
        Name of the model, or a `programs.ModelCommand`.
    argument
        Name of the argument that error messages refer to.
    excluded_names
        Names of models that are not accepted.

    Returns
    -------
    Model
        The model.

    Raises
    ------
    ArgumentError
        If there is no such model, its name is in ``excluded_names``, or `user_models.load_user_model` cannot load it.
    """
    if name in MODELS and name not in excluded_names:
        return MODELS[name]
    command = programs.is_program_command(name)
    others = () if command else user_models.entry_points_of_installed_models()
    names = [x for x in (*MODELS, *(x for x in others if x not in MODELS)) if x not in excluded_names]
    if name not in names and not command:
        import difflib

        near = difflib.get_close_matches(name.lower(), names, n=1)
        advice = f"did you mean {near[0]}?" if near else "choose one of these; lin is the model of Lin's thesis"
        if programs.SCENE in name or programs.LOADS in name:
            advice = "state the command of a program by `model_command`: a name runs no program"
        raise ArgumentError(argument, f'"{name}"', ", ".join(names), advice)
    user_models.load_user_model(name)

    def run_users_model(scene: Scene, options: ModelOptions) -> StaticResult:
        """Solve a scene by the user's model whose name `model_by_name` got: function of a package, or external program."""
        return user_models.solve_by_user_model(name, scene, options.member)

    reason = "a user's model is a function of a scene with one nut or bearing row"
    return Model(name, "", programs.model_title(name), user_models.WORDS, run_users_model, reason)


def has_random_errors(scene: Scene | Assembly) -> bool:
    """Return whether the scene, or any nut or row on its shaft, has random geometric errors."""
    if isinstance(scene, Scene):
        return scene.errors.random
    return any(isinstance(s.parts, Scene) and s.parts.errors.random for s in scene.sets)


def scene_key_of_error(error: ValueError) -> str:
    """Return the key of the scene file that a solver's error names as its cause; "scene" if it names none.

    Examples
    --------
    >>> scene_key_of_error(UnfitKey("solid.nut_inner_diameter", "9 mm leave no groove"))
    'solid.nut_inner_diameter'
    >>> scene_key_of_error(ValueError("no"))
    'scene'
    """
    return error.key if isinstance(error, UnfitKey) else "scene"


@overload
def run_model(scene: Scene, name: str = "", options: ModelOptions | None = None) -> StaticResult: ...
@overload
def run_model(scene: Assembly, name: str = "", options: ModelOptions | None = None) -> AxisResult: ...
def run_model(scene: Scene | Assembly, name: str = "", options: ModelOptions | None = None) -> StaticResult | AxisResult:
    """Solve a scene with a low-order model.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft; one load case.
    name
        Name of the model; empty: the default.
    options
        Options of the model.

    Returns
    -------
    StaticResult or AxisResult
        Contact loads and displacements; loads are nan if the solution did not converge.

    Raises
    ------
    InputError
        If the name is unknown, the model does not cover the scene, or ``options.member`` is above 0 for a scene without
        random errors.
    """
    name, options = name or default_model_name(scene), options or ModelOptions()
    run: Callable[[ModelOptions], StaticResult | AxisResult]
    if isinstance(scene, Scene):
        model = model_by_name(name)
        run = partial(model.solve_scene, model.scene_with_settings(scene) if model.ingredients else scene)
    else:
        run = _function_that_solves_shaft(scene, name)
    if options.member and not has_random_errors(scene):
        allowed = "0, because the scene has no random geometric errors and therefore only one specimen"
        raise ArgumentError("member", str(options.member), allowed, "leave `member` out", scene.name)
    try:
        with np.errstate(all="ignore"):
            result = run(options)
    except ValueError as error:
        raise _scene_not_covered(scene, error) from error
    return replace(result.nan_unless_converged(), model=name, member=options.member)


def run_model_on_scenes(scenes: Sequence[Scene | Assembly], name: str) -> list[StaticResult | AxisResult | InputError]:
    """Solve scenes as `run_model` does, and return each result, or the error that `run_model` raises.

    Scenes with one nut or bearing row are solved together by the models that `lowfi.statics.static` solves, without an
    estimate of the error by beam elements. Each result depends on the other scenes by round-off.

    Parameters
    ----------
    scenes
        Scenes with one load case each.
    name
        Name of the model.
    """
    singles = [scene for scene in scenes if isinstance(scene, Scene)]
    if name in MODELS and MODELS[name].compliances and len(singles) == len(scenes):
        from rollbench.lowfi.together import solve_together

        size = max(1, int(LARGEST_TOGETHER / max((scene.ball_count for scene in singles), default=1)) ** 2)
        found: list[StaticResult | AxisResult | InputError] = []
        with np.errstate(all="ignore"):
            for first in range(0, len(scenes), size):
                found += solve_together([_solving(MODELS[name], scene) for scene in singles[first : first + size]])
        return found
    found = []
    for scene in scenes:
        try:
            found.append(run_model(scene, name, ModelOptions(estimate_beam_mesh_error=isinstance(scene, Assembly))))
        except InputError as error:
            found.append(error)
    return found


def _solving(model: Model, scene: Scene) -> Search[StaticResult | InputError]:
    """Compute the result of a scene by a model of `LADDER`, or the error of `run_model`, together with other scenes."""
    from rollbench.lowfi.compliance.parts import LADDER
    from rollbench.lowfi.statics.static import elastic_solution

    backend = LADDER[model.compliances]
    try:
        result = yield from elastic_solution(model.scene_with_settings(scene), backend=backend, name=model.name)
    except ValueError as error:
        return _scene_not_covered(scene, error)
    return replace(result.nan_unless_converged(), model=model.name)


def _scene_not_covered(scene: Scene | Assembly, error: ValueError) -> SceneNotCoveredError:
    """Return the error for a scene whose solver raised ``error``."""
    single = isinstance(scene, Scene)
    where, what = (scene_key_of_error(error), "geometry and [ingredients]") if single else ("scene", "geometry")
    return SceneNotCoveredError(scene.name, where, str(error), f"check the {what}")


def _function_that_solves_shaft(scene: Assembly, name: str) -> Callable[[ModelOptions], AxisResult]:
    """Return a function that solves a shaft with the model ``name`` for given options; InputError if the model cannot."""
    if name in AXIS_MODELS:
        model = MODELS[name]
        assert not isinstance(model.solve_assembly_or_reason, str)
        return partial(model.solve_assembly_or_reason, model.assembly_with_settings(scene))
    advice = "choose one of these"
    if is_model_name(name):
        advice += f"; {name} does not solve several nuts or bearing rows: {model_by_name(name).solve_assembly_or_reason}"
    raise ArgumentError("model", f'"{name}"', ", ".join(AXIS_MODELS), advice, scene.name)
