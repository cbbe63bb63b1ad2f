"""Low-order models of users: functions that an installed package registers in the entry point group ``rollbench.models``.

In the ``pyproject.toml`` of that package::

    [project.entry-points."rollbench.models"]
    mine = "my_package:contact_loads"

``rollbench compare my.toml --model mine`` then compares this model with the 3D reference, like the models of rollbench. The
package is imported only if its model is used. Instead of a function, a model can be an external program (`programs`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from math import cos, sin
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from rollbench.compare.errors import ArgumentError, ProgramError, SceneNotCoveredError
from rollbench.compare.models import programs
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array, RecordWithArrays
from rollbench.meshes.errors import draw_geometry_with_errors, scene_with_drawn_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from rollbench.lowfi.statics.result import Equilibrium, StaticResult

#: Entry point group in which packages register models.
GROUP = "rollbench.models"
#: Largest imbalance of forces or moments on the screw without a warning, as a share of the largest force or moment.
UNBALANCED = 0.01
#: Descriptions of a user's model in results.
WORDS = "the model is a function of an installed package, or a program"
NOT_COMPARED = "your model has not been compared with the 3D reference"
ASSUMPTION = "contact angles are nominal, because the model gives loads only"


@dataclass(frozen=True)
class ModelAnswer(RecordWithArrays):
    """Contact loads and, optionally, displacement and pressures that a user's model computes for a scene, in SI units.

    Parameters
    ----------
    loads
        Contact loads, (n, 4) [N]: balls in the order of the scene, flanks SL, SR, NL, NR (left and right flank of screw and
        nut); zero without contact.
    displacement
        Displacement of the screw at the nut's centre from its nominal position, (6,) [m, rad]; None: not known.
    pressure
        Largest pressure of each contact, (n, 4) [Pa]; None: computed from the loads by Hertz' equations.

    Examples
    --------
    >>> import numpy as np, rollbench
    >>> def shared_equally(scene):
    ...     loads = np.zeros((scene.ball_count, 4))
    ...     axial = sum(load.force[2] for load in scene.loads)
    ...     loads[:, [0, 3]] = axial / scene.ball_count / np.sin(scene.track.contact_angle)
    ...     return rollbench.ModelAnswer(loads)
    >>> answer = shared_equally(rollbench.read("lin-case1"))
    >>> round(float(answer.loads[0, 0]), 1)
    221.0
    """

    loads: Array
    displacement: Array | None = None
    pressure: Array | None = None


#: Function that takes a scene and returns its contact loads ``(n, 4)`` [N] or a `ModelAnswer`.
UserModel = Callable[[Scene], Array | ModelAnswer]


@cache
def entry_points_of_installed_models() -> dict[str, EntryPoint]:
    """Return the entry points of all models in installed packages, without importing the packages.

    Returns
    -------
    dict
        Entry point of each model by its name, sorted by name.
    """
    from importlib.metadata import entry_points  # takes longer to import than a small solve

    return {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda point: point.name)}


def origin_of_model(name: str) -> str:
    """Return where a user's model comes from: its function and package, or the files in its command with file hashes.

    Parameters
    ----------
    name
        Name of an installed model, or a `programs.ModelCommand`.

    Returns
    -------
    str
        Function ``module:name``, with name and version of its package; for a command, the names of its files with hashes of
        their contents.
    """
    if programs.is_program_command(name):
        return programs.parse_command(name).file_names_with_hashes
    point = entry_points_of_installed_models()[name]
    return point.value if point.dist is None else f"{point.value}, {point.dist.name} {point.dist.version}"


@lru_cache(maxsize=None, typed=True)  # a command is no name, even of equal text
def load_user_model(name: str) -> UserModel:
    """Return a user's model as a function: imported from its package, or running an external program.

    Parameters
    ----------
    name
        Name of an installed model, or a `programs.ModelCommand`.

    Returns
    -------
    callable
        Function that takes a scene and returns the contact loads of n balls on 4 flanks (n, 4) [N], or a `ModelAnswer`.

    Raises
    ------
    ArgumentError
        If several packages have a model of this name, if the package cannot be imported or lacks the function, or if the
        command is not valid.
    """
    if programs.is_program_command(name):
        return partial(_run_program_as_model, programs.parse_command(name))
    from importlib.metadata import entry_points

    point = entry_points_of_installed_models()[name]
    if others := [other.value for other in entry_points(group=GROUP, name=name) if other.value != point.value]:
        reason = f"another installed model also has this name: {', '.join(others)}"
        raise _unusable_model_error(point, reason, "a name that only one model has")
    try:
        function = point.load()
    except Exception as error:  # whatever the user's package raises when it is imported
        raise _unusable_model_error(point, f"{type(error).__name__}: {error}") from error
    if not callable(function):
        raise _unusable_model_error(point, f"an object of type {type(function).__name__} instead of a function")
    found: UserModel = function
    return found


def _run_program_as_model(program: programs.ExternalProgram, scene: Scene) -> ModelAnswer:
    """Run an external program for a scene, and return the contact loads, displacement and pressures that it wrote."""
    given, moved = program(scene)
    pressure = given.further_quantities.get("pressure")
    return ModelAnswer(given.load, moved, None if pressure is None else np.nan_to_num(pressure))


def _unusable_model_error(point: EntryPoint, reason: str, allowed: str = "a function that solves a scene") -> ArgumentError:
    """Return the ArgumentError for a model of an installed package that cannot be used.

    ``point``: entry point of the model in the package; ``reason``: why it cannot be used; ``allowed``: what can.
    """
    advice = "correct the package that provides the model, or uninstall it"
    return ArgumentError("model", f"{point.name} ({point.value}): {reason}", allowed, advice)


def solve_by_user_model(name: str, scene: Scene, member: int = 0) -> StaticResult:
    """Solve a scene with a user's model, and check its contact loads; a warning states loads that are not in equilibrium.

    Contact angles are the nominal ones.

    Parameters
    ----------
    name
        Name of an installed model, or a `programs.ModelCommand`.
    scene
        The scene. If its geometric errors are random, the model gets a copy with the values of one random draw.
    member
        Number of this draw, from 0.

    Returns
    -------
    StaticResult
        Result of the same form as that of rollbench's models.

    Raises
    ------
    ArgumentError
        If an array has a wrong shape, or contains negative loads or values that are not finite.
    SceneNotCoveredError
        If the function of the model raises an exception.
    ProgramError
        If the external program fails.
    """
    from rollbench.lowfi.statics.contact_law import SIGNS
    from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice, scene_with_error_free_hertz
    from rollbench.lowfi.statics.result import SolverReport, StaticResult, Status

    function, layout, shown = load_user_model(name), ball_layout(scene), programs.model_title(name)
    given, start = scene_with_drawn_errors(scene, member), perf_counter()
    try:
        found = function(given)
    except ProgramError:
        raise
    except Exception as error:  # whatever the user's function raises
        reason, advice = f"{shown} fails with {type(error).__name__}: {error}", "correct the model, or choose another one"
        raise SceneNotCoveredError(scene.name, "model", reason, advice) from error
    seconds = perf_counter() - start
    answer = found if isinstance(found, ModelAnswer) else ModelAnswer(found)
    load_of = _check_model_array(shown, "loads", answer.loads, (layout.z.size, 4), least=0.0)
    pressure, moved = None, np.full(6, np.nan)
    if answer.pressure is not None:
        pressure = _check_model_array(shown, "pressure", answer.pressure, load_of.shape, least=0.0)
    if answer.displacement is not None:
        moved = _check_model_array(shown, "displacement", answer.displacement, (6,))
    beta = scene.track.contact_angle
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    normal = np.einsum("sa,nak->nsk", SIGNS * np.array([cos(beta), sin(beta)]), axes)
    points = layout.centre[:, None, :] + scene.balls.radius * normal
    balance = _equilibrium_of_contact_loads(scene, load_of, points, normal)
    drawn = draw_geometry_with_errors(scene, layout, member)
    return StaticResult(
        model=name,
        status=Status("converged"),
        azimuth=layout.azimuth,
        z=layout.z,
        load=load_of,
        contact_angle=np.where(load_of > 0.0, beta, np.nan),
        contact_point=points,
        force_direction=-normal,
        centre_shift=np.zeros((layout.z.size, 2)),
        hertz_C=hertz_constants_by_scene_choice(scene_with_error_free_hertz(scene), drawn),
        centreline_z=np.array([scene.nut.position]),
        centreline=moved[None],
        equilibrium=balance,
        solver=SolverReport(1, 1, balance.largest, seconds, load_of.size, 0, "of the model"),
        assumed=(*scene.assumed, ASSUMPTION),
        left_out=(),
        warnings=tuple(_imbalance_warnings(shown, balance)),
        pressure=pressure,
    )


def _imbalance_warnings(model_name: str, balance: Equilibrium) -> Iterator[ResultWarning]:
    """Yield a warning if a user model's contact loads do not balance the external loads and support reactions.

    ``balance``: forces and moments on the screw, with their part that is not balanced.
    """
    if balance.largest > UNBALANCED:
        brief = f"loads of {model_name} out of balance by {100.0 * balance.largest:.3g} % of the largest force or moment"
        yield ResultWarning("balance", f"{brief}: check their units, signs and the order of the flanks", brief)


def _equilibrium_of_contact_loads(scene: Scene, loads: Array, points: Array, normals: Array) -> Equilibrium:
    """Return the balance of external loads, contact loads and support reactions on the screw.

    ``loads``: contact loads of n balls (n, 4) [N]; ``points``: contact points (n, 4, 3) [m]; ``normals``: unit vectors from
    the ball centres to these points (n, 4, 3). Support reactions are fitted by least squares; the rest is the imbalance.
    """
    from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
    from rollbench.lowfi.statics.summary import check_equilibrium, resultant_of_loads

    force = loads[..., None] * normals  # of the balls on screw and nut
    moments = np.cross(points[:, :2], force[:, :2])
    contact = np.concatenate([force[:, :2].sum(axis=(0, 1)), moments.sum(axis=(0, 1))])
    applied, arm = resultant_of_loads(scene.loads), scene.track.pitch_radius
    held = [rigid_motion_transfer_matrix(s.at)[FREEDOMS.index(freedom)] for s in scene.supports for freedom, _ in s.fixed]
    reaction = np.zeros(6)
    if held:
        scale = np.array([1.0, 1.0, 1.0, arm, arm, arm])
        unit = np.array(held).T / scale[:, None]
        sizes = np.linalg.lstsq(unit, -(applied + contact) / scale, rcond=None)[0]
        reaction = scale * (unit @ sizes)
    size = max(float(loads.max(initial=0.0)), *(float(np.abs(x[:3]).max()) for x in (applied, contact, reaction)))
    sums = applied, reaction, contact, np.zeros(6)
    return check_equilibrium(sums, size, arm, (0.0, 0.0), np.linalg.norm(force.sum(axis=1), axis=1))


def _check_model_array(model_name: str, quantity: str, value: Array, shape: Sequence[int], least: float = -np.inf) -> Array:
    """Check shape and values of an array that a user's model returned, and return it as an array of floats.

    ``model_name``: name of the model; ``quantity``: name of the quantity, for error messages; ``value``: the array.
    ArgumentError if it does not have the shape ``shape``, or if one of its numbers is not finite or is below ``least``.
    """
    advice = "correct the model"
    allowed_shape = f"an array of shape {shape}"
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError("model", f"{quantity} from {model_name} that are not numbers", allowed_shape, advice) from None
    if array.shape != tuple(shape):
        raise ArgumentError("model", f"{quantity} of shape {array.shape} from {model_name}", allowed_shape, advice)
    wrong = ~np.isfinite(array) | (array < least)
    if wrong.any():
        place = tuple(int(k) for k in np.argwhere(wrong)[0])
        where = f" on ball {place[0] + 1}, {SIDES[place[1]]}" if len(place) > 1 else ""
        allowed = "finite numbers" if least == -np.inf else f"finite numbers, at least {least:g}"
        raise ArgumentError("model", f"{quantity} of {array[place]:g}{where} from {model_name}", allowed, advice)
    return array
