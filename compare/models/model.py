"""Record of a low-order model, and its options; the models stand in the registry, or in the case of their publication."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.meshes.parts import Scene
from rollbench.reports.manifest import sha256

if TYPE_CHECKING:
    from rollbench.lowfi.statics.result import AxisResult, StaticResult
    from rollbench.meshes.axis import Assembly

#: Parts of the texts on how models describe the elasticity of screw, nut and balls.
C_8, HALF_SPACES = "screw a beam by equation C.8 of Lin's thesis, nut rigid, balls as half spaces", "balls as half spaces"


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

    @property
    def inputs(self) -> tuple[object, ...]:
        """Values on which results depend: the options, with a digest of the file in place of its path."""
        path = self.condensed_bodies_file
        return replace(self, condensed_bodies_file=None), path and sha256(path.read_bytes())


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
    #: Name in `LADDER` of the compliances with which `lowfi.statics.static` solves a scene; empty: it has another solver.
    compliances: str = ""
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
