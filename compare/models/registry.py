"""Registry of the low-order models: their names, descriptions, and the functions that run them on a scene.

To add a model of rollbench, add its `Model` here; models of publications come from their cases (`compare.case`). A model of
another package registers itself by the entry point ``rollbench.models``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from rollbench.compare.case import CASES
from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.files import similar_paths
from rollbench.compare.models import programs, user_models
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene, UnfitKey

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance
    from rollbench.lowfi.statics.result import AxisResult, StaticResult


@dataclass(frozen=True)
class ModelOptions:
    """Options with which a low-order model is run."""

    #: Whether the model also computes those of its terms that cannot change the contact loads of the scene.
    include_ineffective_terms: bool = False
    #: Number of the random draw of the scene's geometric errors, from 0; 0 without random errors.
    member: int = 0
    #: Whether the error due to the division of the screw into beam elements is estimated.
    estimate_beam_mesh_error: bool = True
    #: File with the stiffness of screw and nut condensed to the contacts, for the model "condensed"; None: no file.
    condensed_bodies_file: Path | None = None


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


def covers_any_scene(scene: Scene) -> bool:  # noqa: ARG001 - the signature of Model.covers_scene
    """Return True for every scene: `Model.covers_scene` of models that cover all scenes with one nut or bearing row."""
    return True


def has_beam_screw(scene: Scene) -> bool:
    """Return whether the options of the scene ask for a screw modelled as a beam instead of a rigid body."""
    return scene.ingredients.screw == "beam"


@dataclass(frozen=True)
class Model:
    """Low-order model: its name, description and solver, as commands, tables and the report use them."""

    #: Name of the model on the command line.
    name: str
    #: Description of the model in the output of ``rollbench list``.
    description: str
    #: Name of the model in tables and figures.
    label: str
    #: Text on how the model describes the elasticity of screw, nut and balls.
    elasticity_text: str
    #: Function that solves a scene with one nut or bearing row.
    solve_scene: Callable[[Scene, ModelOptions], StaticResult]
    #: Function that solves a shaft with several nuts or bearing rows, or a text that says why the model cannot.
    solve_assembly_or_reason: Callable[[Assembly, ModelOptions], AxisResult] | str = (
        "it solves scenes with a single nut or bearing row only"
    )
    #: Function that returns whether the model covers a scene with one nut or bearing row.
    covers_scene: Callable[[Scene], bool] = covers_any_scene
    #: Whether ``rollbench compare`` shows the model by default.
    compared: bool = False
    #: Whether the model is run on the difficult scenes of the report's table of numerical stability.
    solves_hard_scenes: bool = False
    #: Modelling options (scene table [ingredients]) that distinguish this model from another one with the same solver.
    ingredients: tuple[tuple[str, Any], ...] = ()
    #: Position in the sequence of models from Lin's to the refined one, and what the model adds to the one before it; None:
    #: the model is not in the sequence.
    refinement_step: tuple[int, str] | None = None
    #: Name of another model whose measured errors hold for this one, too; empty: none.
    model_with_same_errors: str = ""
    #: Function that returns the axial stiffness of the nut under the scene's load [N/m]: the secant over a load step [N],
    #: or the tangent for a step of 0; None without load. Only a model without 6 x 6 tangent stiffness needs it.
    axial_stiffness: Callable[[Scene, ModelOptions, float], float | None] | None = None

    def scene_with_settings(self, scene: Scene) -> Scene:
        """Return a copy of the scene with the modelling options (`Scene.ingredients`) that this model prescribes."""
        return replace(scene, ingredients=replace(scene.ingredients, **dict(self.ingredients)))

    def assembly_with_settings(self, assembly: Assembly) -> Assembly:
        """Return a copy of the assembly whose nuts and rows all have the modelling options that this model prescribes."""
        parts = [self.scene_with_settings(s.parts) if isinstance(s.parts, Scene) else s.parts for s in assembly.sets]
        sets = tuple(replace(s, parts=p) for s, p in zip(assembly.sets, parts, strict=True))
        return replace(assembly, sets=sets, ingredients=replace(assembly.ingredients, **dict(self.ingredients)))


#: Parts of the texts on how models describe the elasticity of screw, nut and balls.
C_8, HALF_SPACES = "screw a beam by equation C.8 of Lin's thesis, nut rigid, balls as half spaces", "balls as half spaces"
_ALL = (
    Model(
        "refined",
        "elastic grooved screw, nut and balls with Hertz contacts, without a 3D solution; the default",
        "refined model",
        "screw, nut and balls elastic, by kernels",
        partial(_solve_with_elastic_bodies, name="refined"),
        partial(_solve_assembly_elastically, name="refined"),
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
        refinement_step=(2, "+ cross-section of the grooved shaft"),
    ),
    Model(
        "lin-nut",
        "lin-cell with the nut as a beam, too",
        "Lin's model, nut also a beam",
        f"screw and nut beams with their grooved cross-sections, {HALF_SPACES}",
        partial(_solve_with_elastic_bodies, name="lin-nut"),
        partial(_solve_assembly_elastically, name="lin-nut"),
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
    *(model for case in CASES if case.models for model in case.import_object(case.models)()),
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
    if name in MODELS:
        return MODELS[name]
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
    run = _function_that_solves(scene, name)
    if options.member and not has_random_errors(scene):
        allowed = "0, because the scene has no random geometric errors and therefore only one specimen"
        raise ArgumentError("member", str(options.member), allowed, "leave `member` out", scene.name)
    try:
        with np.errstate(all="ignore"):
            result = run(options)
    except ValueError as error:
        single = isinstance(scene, Scene)
        where, what = (scene_key_of_error(error), "geometry and [ingredients]") if single else ("scene", "geometry")
        raise SceneNotCoveredError(scene.name, where, str(error), f"check the {what}") from error
    return replace(result.nan_unless_converged(), model=name, member=options.member)


def _function_that_solves(scene: Scene | Assembly, name: str) -> Callable[[ModelOptions], StaticResult | AxisResult]:
    """Return a function that solves the scene with the model ``name`` for given options; InputError if the model cannot."""
    if isinstance(scene, Scene):
        model = model_by_name(name)
        return partial(model.solve_scene, model.scene_with_settings(scene))
    if name in AXIS_MODELS:
        model = MODELS[name]
        assert not isinstance(model.solve_assembly_or_reason, str)
        return partial(model.solve_assembly_or_reason, model.assembly_with_settings(scene))
    advice = "choose one of these"
    if is_model_name(name):
        advice += f"; {name} does not solve several nuts or bearing rows: {model_by_name(name).solve_assembly_or_reason}"
    raise ArgumentError("model", f'"{name}"', ", ".join(AXIS_MODELS), advice, scene.name)
