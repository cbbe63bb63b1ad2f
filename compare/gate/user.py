"""Acceptance check of users' scenes: contact loads of a model, or of another program, against the 3D reference.

A user's file of contact loads, measured or from another 3D program, can replace the 3D reference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.gate import verdict
from rollbench.compare.gate.judged import ANGLE, LIFE, OF_CONTACTS, UserValue, parse_error_limits, read_user_values
from rollbench.compare.gate.verdict import LARGEST, LIMIT, ErrorLimits, Judgement, VerdictRow
from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.models import comparison
from rollbench.compare.models.comparison import SceneWithReference, scene_of_set
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.loads_file import EVERY, ContactLoadsFromFile, Only, read_loads
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import DEFAULT, model_by_name, run_model
from rollbench.compare.reference.estimate import MeshUncertainty, Reference
from rollbench.compare.reference.jobs import ComputingSettings, ensure_runs_are_stored, plan_reference_tasks
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.reference.store import Run, load_stored_run, shipped_store
from rollbench.compare.reference.tasks import Solvable, group_scenes_by_geometry
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.warned import OUTSIDE
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.units import number_advice, parse_quantity

#: Keys of the notes (``# key: text``) above the table of a reference file.
UNCERTAINTY, PROVENANCE = "uncertainty", "provenance"


def read_reference_file(
    path: Path, scene: Scene, row_filter: Only = EVERY, contacts: int | None = None
) -> tuple[Reference, tuple[str, ...]]:
    """Read a user's reference loads of all balls and flanks from a file with the columns of `loads_file`.

    The file states the uncertainty of its loads in a column (``uncertainty_N``, or ``uncertainty_percent`` of each load) or
    in a note above the table (``# uncertainty: 0.5 %`` of the mean load, or ``2 N``). If it states none, the uncertainty is
    taken as zero, and the description of the reference says so.

    Parameters
    ----------
    path
        Path of the file.
    scene
        Scene with a single ball nut or bearing.
    row_filter
        Accepted texts of the columns ``case`` (load case) and ``set`` (nut or bearing); rows with other texts are skipped.
    contacts
        Number of contacts that carry load in the screw without geometric errors, over which the mean load is taken; None:
        computed from the scene.

    Returns
    -------
    Reference
        Reference with the loads and uncertainties of the file.
    tuple[str, ...]
        Column headings of the file that are not known.

    Raises
    ------
    InputError
        If the file cannot be read or does not fit the scene.
    """
    given = read_loads(path, scene, row_filter)
    left = [side for side in SIDES if side not in given.flanks_with_rows]
    if left:
        advice = "add the missing rows, with the load 0 for contacts that carry none"
        allowed = "a load of every ball on its four flanks: left and right flank of screw (SL, SR) and nut (NL, NR)"
        raise InputError(str(path), "rows", f"no rows for {', '.join(left)}", allowed, advice)
    if not given.load.any():
        advice = "check that the file holds the reference loads of this scene"
        raise InputError(str(path), "file", "only loads of 0", "at least one contact load above 0", advice)
    contacts = count_nominal_contacts(scene) if contacts is None else contacts
    bars, words = _load_uncertainty_in_file(path, given, mean_load(given.load, contacts))
    source = given.notes.get(PROVENANCE, "")
    stated = f"against {path.name}{f' ({source})' if source else ''}, {words}"
    angle = np.degrees(given.further_quantities.get("angle", np.full(given.load.shape, np.nan)))
    further = {q.name: given.further_quantities[k] for k, q in OF_CONTACTS.items() if k in given.further_quantities}
    parts = MeshUncertainty(float(error_percent(bars.max(), 0.0, mean_load(given.load, contacts))))
    run, label = loads_as_run_record(scene, given.load, angle), re.sub(r"\s+", " ", path.name)
    return Reference(scene.name, (run,), given.load, bars, parts, contacts, label, stated, further), given.unknown_headings


def uncertainty_warning(ref: Reference, limit: float) -> str:
    """Return a warning if the uncertainty of a contact load of the reference exceeds the error limit; otherwise "".

    ``ref``: the reference; ``limit``: error limit of contact loads [% of the contact's load; of the mean load for small
    loads].
    """
    worst = max(comparison.contact_load_errors(ref, ref.load), key=lambda p: p.uncertainty)
    if worst.uncertainty <= limit:
        return ""
    return (
        f"the uncertainty of {ref.label}, {worst.uncertainty:.3g} % at ball {worst.ball} {worst.side}, exceeds "
        f"the error limit of {limit:g} %: errors near the limit cannot be judged"
    )


def _load_uncertainty_in_file(path: Path, given: ContactLoadsFromFile, mean: float) -> tuple[Array, str]:
    """Return the uncertainty of the contact loads (n, 4) [N] that a user's reference file states, and a text about it.

    n is the number of balls; each has 4 flanks.

    ``given``: contents of the file; ``mean``: mean contact load [N], to which a percentage in a note refers. InputError if
    the file states the uncertainty in several ways or not validly.
    """
    on = given.load > 0.0
    stated = [name for name in ("uncertainty", "uncertain share") if name in given.further_quantities]
    note = given.notes.get(UNCERTAINTY)
    if len(stated) + (note is not None) > 1:
        allowed = f"one column or one note (a line such as # {UNCERTAINTY}: 0.5 %)"
        value, advice = "several columns or notes that state it", "keep one and delete the others"
        raise InputError(str(path), "uncertainty", value, allowed, advice)
    if stated:
        values = given.further_quantities[stated[0]] * (given.load if stated[0] == "uncertain share" else 1.0)
        gaps = np.argwhere(np.isnan(values) & on)
        if gaps.size:
            value = f"no uncertainty of ball {gaps[0][0] + 1} {SIDES[gaps[0][1]]}"
            advice = "fill the column, or delete it"
            raise InputError(str(path), "uncertainty", value, "an uncertainty of every loaded contact", advice)
        return np.nan_to_num(values), "with an uncertainty stated for each contact"
    if note is None:
        return np.zeros_like(given.load), "whose uncertainty is taken as zero because the file states none"
    share = re.fullmatch(r"([0-9.eE+-]+)\s*(?:%|percent)", note)
    try:
        size = 0.01 * float(share[1]) * mean if share else parse_quantity(note, "force")
    except ValueError:  # a UnitError too
        size = float("nan")
    if not 0.0 <= size < float("inf"):
        allowed = "per cent of the mean contact load, such as 0.5 %, or a force such as 2 N"
        advice = number_advice(note, "or write a column uncertainty_N")
        raise InputError(str(path), f"line # {UNCERTAINTY}", note or "nothing", allowed, advice)
    return np.full(given.load.shape, size), f"uncertain by {note}{' of the mean load' if share else ''}"


def loads_as_run_record(scene: Scene, load: Array, angle: Array) -> Run:
    """Return given contact loads and angles as the record of a 3D run that has no mesh, displacements and times.

    ``load``: contact loads of n balls on 4 flanks (n, 4) [N]; ``angle``: contact angles (n, 4) [deg]. Loads from a file can
    then be used wherever a run of the 3D reference is expected.
    """
    loaded_angle = np.where(load > 0.0, angle, np.nan)
    return Run(scene.name, 0, "", "converged", load, loaded_angle, load, np.zeros((0, 4)), sides=tuple(range(4)))


#: Number of mesh levels of the 3D reference that are computed by default: the smallest number from which its uncertainty
#: can be estimated.
ENOUGH = 2

#: Error limit [%] below which the user may have meant a fraction (0.07 for 7 %): no reference is that accurate.
SHARE = 0.2

#: Reason of the verdict "not covered" on a scene without 3D reference.
NONE_STORED = "no run of its 3D reference is stored, and none is to be computed"

#: Known columns of a file of contact loads, as text for messages.
KNOWN = "ball, flank, newton, azimuth_deg, z_mm, contact_angle_deg, approach_um, pressure_MPa, uncertainty_N; any unit"

#: Default for error limits of other quantities: none are stated.
NO_OTHERS: Mapping[str, float] = {}

#: Default for names of load cases: the scenes have none.
NO_CASES: Mapping[str, str] = {}


@dataclass(frozen=True, kw_only=True)
class GateRequest:
    """Request to judge the results of a model or a user's file: error limits, and reference to judge them against.

    Raises `InputError` if arguments exclude each other or are out of range.
    """

    #: Name of the model whose loads are judged; empty: the default model.
    model: str = ""
    #: File of contact loads that are judged instead of a model's.
    loads: Path | None = None
    #: File of further values (such as stiffness or life) that are judged.
    values: Path | None = None
    #: Limit of the errors of contact loads [%]; None: the limit that the scene states, or else 7 (`LIMIT`).
    max_error: float | None = None
    #: Error limits of quantities other than loads, each as ``NAME=NUMBER`` in %, or in degrees for contact angles.
    limits: Sequence[str] = ()
    #: File of contact loads that replaces the 3D reference.
    reference: Path | None = None
    #: Whether unknown column headings are an error, and a model outside its range of validity fails.
    strict: bool = False
    #: Least number of mesh levels of the 3D reference; None: as many as are stored, but at least two (`ENOUGH`).
    levels: int | None = None
    #: Folder in which new runs of the 3D reference are stored.
    store: Path = Path("rollbench-reference")
    #: Folder with stored runs of the 3D reference; if it is given, no new run is computed.
    stored: Path | None = None
    #: Whether missing runs of the 3D reference are computed.
    compute: bool = True

    def __post_init__(self) -> None:
        """Check the arguments."""
        if self.max_error is not None and not 0.0 < self.max_error <= 100.0:
            allowed, advice = "above 0 to 100 per cent of a contact load", "leave `max_error` out for 7 per cent"
            raise ArgumentError("max_error", str(self.max_error), allowed, advice)
        if self.levels is not None:
            allowed, advice = "", ""
            if not 1 <= self.levels <= len(LEVELS):
                allowed = f"1 to {len(LEVELS)}"
                advice = "compute at least 2 mesh levels to estimate the mesh uncertainty"
            elif self.stored is not None or not self.compute:
                allowed = "only without `stored` and `compute=False`"
                advice = "leave `levels` out: stored runs are used with all mesh levels that are stored"
            elif self.reference is not None:
                allowed = "only without `reference`"
                advice = "leave `levels` out: a reference from a file needs no mesh levels"
            if allowed:
                raise ArgumentError("levels", str(self.levels), allowed, advice)
        for name, file in (("loads", self.loads), ("values", self.values)):
            if file is not None and self.model:
                advice = "leave the file or `model` out: either a file or a model is judged"
                raise ArgumentError(name, str(file), "only without `model`", advice)
        if self.stored is not None and not self.stored.is_dir():
            raise ArgumentError(
                "stored", str(self.stored), "a folder with stored runs of the 3D reference", "check the path"
            )
        if self.model:
            model_by_name(self.model)  # checks the name
        parse_error_limits(self.limits)  # checks the limits

    @property
    def stores(self) -> tuple[Path, ...]:
        """Folders with stored runs of the 3D reference; new runs are stored in the first."""
        return self.store if self.stored is None else self.stored, shipped_store()


@dataclass(frozen=True)
class UserFiles:
    """Contents of a user's files for one scene or load case: judged contact loads, judged values, reference loads."""

    #: Contact loads of another program, one record for each nut or bearing.
    loads: tuple[ContactLoadsFromFile, ...] = ()
    #: Values of quantities of the whole screw (such as stiffness or life).
    values: tuple[UserValue, ...] = ()
    #: For each axial load [N] at which a value is given, the scene with its loads scaled to that axial load.
    scenes_by_axial_load: Mapping[float, Scene] = field(default_factory=dict)
    #: User's reference, one record for each nut or bearing.
    reference: tuple[SceneWithReference, ...] = ()


def check_scenes(
    scenes: Sequence[Solvable],
    request: GateRequest,
    engine: ComputingSettings,
    step: Callable[[str], None],
    warn: Callable[[str], None] = lambda _: None,
    cases: Mapping[str, str] = NO_CASES,
) -> list[VerdictRow]:
    """Judge contact loads and other values of a model or a file on each scene, against the 3D or the user's reference.

    Missing runs of the 3D reference are computed first, unless the request forbids it.

    Parameters
    ----------
    scenes
        Scenes with one load case each.
    request
        Model or file to be judged, error limits, and the reference to judge it against.
    engine
        Settings that determine where missing runs of the 3D reference are computed.
    step
        Function that is called with each line of progress.
    warn
        Function that is called with each warning.
    cases
        For each scene's name, the name of its load case; needed if a file holds rows of several load cases, else empty.

    Returns
    -------
    list[VerdictRow]
        Verdicts on each scene, or on each of its nuts or bearings: one on the largest error of a load, one on the RMS error
        if that has a limit, and one on each further quantity that a file gives or that has a limit.

    Raises
    ------
    InputError
        If a file does not fit the scene, or the model does not cover a scene.
    """
    others = parse_error_limits(request.limits)
    each_limits = [limits_for_scene(scene, request.max_error, others) for scene in scenes]
    warned = dict.fromkeys(words for limits in each_limits for words in fraction_limit_warnings(limits))
    files = {"loads": request.loads, "values": request.values, "reference": request.reference}
    for argument, path in files.items():
        if path is not None and len(scenes) != 1 and len(cases) != len(scenes):
            advice = "check the scenes one by one, each with its own file"
            raise ArgumentError(argument, str(path), f"a file for one scene, not {len(scenes)} scenes", advice)
    named = scenes if any(files.values()) else ()
    read = [_read_files(scene, request, warned.setdefault, cases.get(scene.name)) for scene in named]
    for words in warned:
        warn(words)
    each_files, why = read or [UserFiles()] * len(scenes), dict[str, str]()
    if request.compute and request.stored is None and request.reference is None:
        scaled = (scene for given in read for scene in given.scenes_by_axial_load.values())
        why = _compute_missing_runs([*scenes, *scaled], request, engine, step)
    out: list[VerdictRow] = []
    for scene, given, limits in zip(scenes, each_files, each_limits, strict=True):
        each: Sequence[SceneWithReference] = given.reference or comparison.stored_references(scene, request.stores)
        reason = why.get(scene.name, NONE_STORED)
        if request.values is None or request.loads is not None:
            out += [v for one in each for v in _load_verdicts(one, given, limits, request)]
            judged = model_title(request.model or DEFAULT) if request.loads is None else request.loads.name
            out += (
                []
                if each
                else [verdict.verdict_not_covered(judged, LARGEST, limits.largest_load_error, reason, scene.name)]
            )
        for value in given.values:
            beside = each
            if value.axial_load is not None:
                beside = comparison.stored_references(given.scenes_by_axial_load[value.axial_load], request.stores)
            places = ((x, x.assembly) for x in beside)
            one = next((x for x, of in places if of is None or value.set in _accepted_names(of, x.index)), None)
            out.append(_verdict_on_user_value(value, one, scene, limits, request, reason))
    return out


def _load_verdicts(
    one: SceneWithReference, files: UserFiles, limits: ErrorLimits, request: GateRequest
) -> list[VerdictRow]:
    """Return the verdicts on the contact loads of one nut or bearing by a model or by a user's file.

    ``one``: the nut or bearing with its reference; ``files``: contents of the user's files; ``limits``: error limits;
    ``request``: model or file to be judged.
    """
    if request.loads is None:
        return _add_scene_and_set_names(_verdicts_on_model(one, limits, request), one)
    given, judged = files.loads[one.index], request.loads.name
    detail = "; ".join(filter(None, _explanations_on_user_loads(given, one.reference, limits)))
    verdicts = verdict.judge_contact_loads(judged, given.load, one.reference, limits, given.flanks_with_rows, detail)
    further = verdict.judge_contact_quantities(judged, given, one.scene, one.reference, limits)
    ours = stored_reference_of_nut_or_bearing(one, request.stores) if one.reference.stated else None
    if ours is not None:
        other = verdict.judge_contact_loads("", given.load, ours, limits, given.flanks_with_rows)[0]
        words = f"by the stored 3D reference: {other.comparison_text()}, {other.judgement}"
        verdicts[0] = replace(verdicts[0], detail=f"{verdicts[0].detail}; {words}")
    return _add_scene_and_set_names(verdicts + further, one)


def _add_scene_and_set_names(verdicts: list[VerdictRow], one: SceneWithReference) -> list[VerdictRow]:
    """Return the verdicts with the name of the scene filled in, and that of the nut or bearing if the scene has several.

    ``one``: the nut or bearing to which the verdicts belong.
    """
    return [replace(v, scene=one.described_scene.name, set=one.set_name or None) for v in verdicts]


def _verdict_on_user_value(
    value: UserValue,
    one: SceneWithReference | None,
    scene: Solvable,
    limits: ErrorLimits,
    request: GateRequest,
    reason: str,
) -> VerdictRow:
    """Return the verdict on a user's value of a quantity of the whole screw (such as life or rigidity).

    ``value``: the user's value; ``one``: the nut or bearing that it belongs to, with its reference; if None, the verdict is
    "not covered" for the given ``reason``. Of several nuts or bearings on one shaft, only the life of each is judged.
    ``scene``: the scene that the user's file describes.
    """
    assert request.values is not None
    judged = request.values.name
    if one is None or (one.assembly is not None and value.quantity is not LIFE):
        reason = reason if one is None else "with several nuts or bearings on one shaft, only the life of each is judged"
        return verdict.verdict_not_covered(judged, value.name, limits.limit_of(value.quantity), reason, scene.name)
    found = verdict.judge_value(judged, value, one.scene, one.reference, limits)
    return _add_scene_and_set_names([found], one)[0]


def _accepted_names(assembly: Assembly, k: int) -> tuple[str, str]:
    """Return the two texts by which users' files may name the nut or bearing ``k`` (from 0): number from 1, and name."""
    return str(k + 1), assembly.sets[k].name


def _read_files(scene: Solvable, request: GateRequest, warn: Callable[[str], None], case: str | None) -> UserFiles:
    """Read the user's files of loads, values and reference for a scene; InputError if they do not fit it.

    ``warn``: function that is called with each warning; ``case``: load case whose rows are read; None: all rows.
    """
    reference, loads, values = list[SceneWithReference](), [], list[UserValue]()
    at, strict = dict[float, Scene](), request.strict
    if request.reference is not None:
        limit = limits_for_scene(scene, request.max_error).largest_load_error
        reference = references_from_file(request.reference, scene, warn, limit, strict=strict, case=case)
    if (file := request.loads) is not None:
        for of, only in nuts_and_bearings_with_row_filter(scene, case):
            loads.append(read_loads(file, of, only))
            _check_unknown_columns(file, loads[-1].unknown_headings, warn, strict=strict)
    if (file := request.values) is not None:
        values, unknown = read_user_values(file, case)
        _check_unknown_columns(file, unknown, warn, strict=strict)
        _check_nut_or_bearing_names(scene, values, file)
        at = {v.axial_load: _scene_at_value_load(scene, v, file) for v in values if v.axial_load is not None}
    return UserFiles(tuple(loads), tuple(values), at, tuple(reference))


def nuts_and_bearings_with_row_filter(scene: Solvable, case: str | None) -> list[tuple[Scene, Only]]:
    """Return each nut or bearing of a scene, with the filter for its rows in a user's file; InputError for rollers.

    ``case``: load case whose rows are wanted; None: all. A filter has the accepted texts of the file's columns ``case`` and
    ``set``.
    """
    of_case: Only = {} if case is None else {"case": (case,)}
    if isinstance(scene, Scene):
        return [(scene, of_case)]
    out: list[tuple[Scene, Only]] = []
    for k, s in enumerate(scene.sets):
        if not isinstance(s.parts, Scene):
            advice = "judge a model instead of a file: rollers have no flanks to which loads could be assigned"
            raise InputError(scene.name, "sets", s.name, "a nut or bearing with balls", advice)
        out.append((scene_of_set(scene, k), {**of_case, "set": _accepted_names(scene, k)}))
    return out


def references_from_file(
    path: Path,
    scene: Solvable,
    warn: Callable[[str], None],
    limit: float | None = None,
    *,
    strict: bool = False,
    case: str | None = None,
) -> list[SceneWithReference]:
    """Read the user's reference file and return the reference loads of each nut or bearing of a scene.

    Parameters
    ----------
    path
        Path of the file.
    scene
        Scene with one nut or bearing or several.
    warn
        Function that is called with each warning.
    limit
        Limit of the errors of loads [%]: a warning is given if the uncertainty of the reference exceeds it. None: the limit
        that the scene states or, if it has none, the default `LIMIT`.
    strict
        Whether unknown column headings are an error.
    case
        Load case whose rows are read; None: all rows.

    Returns
    -------
    list[SceneWithReference]
        Each nut or bearing with its reference.

    Raises
    ------
    InputError
        If the file cannot be read or does not fit the scene.
    """
    out = []
    for k, (parts, only) in enumerate(nuts_and_bearings_with_row_filter(scene, case)):
        of, contacts = None if isinstance(scene, Scene) else scene, None
        if of is not None:
            contacts = comparison.loaded_contact_counts(of)[k]
        reference, unknown = read_reference_file(path, parts, only, contacts)
        reference = reference if of is None else replace(reference, scene=f"{of.name}, {of.sets[k].name}")
        _check_unknown_columns(path, unknown, warn, strict=strict)
        if words := uncertainty_warning(reference, limits_for_scene(scene, limit).largest_load_error):
            warn(words)
        out.append(SceneWithReference(parts, reference, of, k))
    return out


def stored_reference_of_nut_or_bearing(one: SceneWithReference, stores: Sequence[Path]) -> Reference | None:
    """Return the stored 3D reference of a nut or bearing that was judged against a user's reference; None if there is none.

    ``one``: the nut or bearing with the user's reference; ``stores``: folders with runs of the 3D reference.
    """
    references = comparison.stored_references(one.described_scene, stores)
    return references[one.index].reference if references else None


def _check_nut_or_bearing_names(scene: Solvable, values: Sequence[UserValue], path: Path) -> None:
    """Raise InputError if a value in a user's file names no nut or bearing of the scene, or an unknown one.

    ``path``: path of the file. Values of a scene with a single nut or bearing need no name.
    """
    if isinstance(scene, Scene):
        return
    known = [word for k in range(len(scene.sets)) for word in _accepted_names(scene, k)]
    for value in values:
        if value.set not in known:
            advice = "add a column `set` that names the nut or bearing of every value"
            raise InputError(str(path), "set", value.set or "nothing", ", ".join(known), advice)


def _scene_at_value_load(scene: Solvable, value: UserValue, path: Path) -> Scene:
    """Return the scene with its loads scaled to the axial load at which a user's value is given.

    ``value``: the value with its axial load; ``path``: the user's file. InputError if the scene has no axial load, or
    several nuts or bearings.
    """
    assert value.axial_load is not None
    given = value.load_or_position_text
    if isinstance(scene, Assembly):
        advice = "leave the cell empty: with several nuts or bearings, values are compared at the loads of the scene only"
        raise InputError(str(path), "where", given, "an empty cell", advice)
    axial = abs(sum(load.force[2] for load in scene.loads))
    if axial == 0.0:
        allowed = "an empty cell"
        advice = "leave the cell empty: the scene has no axial load that could be scaled to the load in this cell"
        raise InputError(str(path), "where", given, allowed, advice)
    return with_scaled_loads(scene, value.axial_load / axial)


def _check_unknown_columns(path: Path, headings: Sequence[str], warn: Callable[[str], None], *, strict: bool) -> None:
    """Warn that unknown columns (``headings``) of a user's file are not judged; raise InputError instead if ``strict``."""
    if not headings:
        return
    if strict:
        raise InputError(str(path), "line 1", ", ".join(headings), KNOWN, "rename the unknown columns or delete them")
    warn(f"{path.name}: unknown columns are not judged: {', '.join(headings)}; known columns: {KNOWN}")


def _explanations_on_user_loads(given: ContactLoadsFromFile, reference: Reference, limits: ErrorLimits) -> Iterator[str]:
    """Yield explanations for the verdict on a user's contact loads; some may be empty texts.

    ``given``: the user's contact loads; ``limits``: error limits. The explanations state flanks without loads, balls
    that the file numbers differently, and suspected causes of large errors.
    """
    left = [side for side in SIDES if side not in given.flanks_with_rows]
    yield f"flanks not judged because the file has no loads on them: {', '.join(left)}" if left else ""
    if given.renumbered_ball_count:
        yield f"{given.renumbered_ball_count} balls are numbered differently in the file, and were matched by azimuth and z"
    yield verdict.suspected_cause_text(given.load, reference.load, given.flanks_with_rows, limits.largest_load_error)


def limits_for_scene(scene: Solvable, max_error: float | None, others: Mapping[str, float] = NO_OTHERS) -> ErrorLimits:
    """Return the error limits for a scene: those that the user states, else those of the scene file, else the default.

    Parameters
    ----------
    scene
        Scene with one nut or bearing or several.
    max_error
        Limit of the largest error of a contact load [%] that the user states; None: the limit in the scene file or, if it
        has none, the default `LIMIT`.
    others
        Error limits of quantities other than loads, by name of the quantity.

    Returns
    -------
    ErrorLimits
        Limits by which the scene is judged.
    """
    if isinstance(scene, Assembly):
        return ErrorLimits(LIMIT if max_error is None else max_error, limits_by_quantity=others)
    limit = LIMIT if scene.gate.max_error is None else scene.gate.max_error
    return ErrorLimits(limit if max_error is None else max_error, scene.gate.rms_error, others)


def fraction_limit_warnings(limits: ErrorLimits) -> Iterator[str]:
    """Yield a warning for each error limit that looks like a fraction, such as 0.07 % where 7 % may be meant."""
    for name, limit in {"loads": limits.largest_load_error, **limits.limits_by_quantity}.items():
        if limit < SHARE and name != ANGLE.name:
            yield f"the limit of {name} is {limit:g} %: do you mean {100.0 * limit:g} %? Limits are in per cent"


def _verdicts_on_model(one: SceneWithReference, limits: ErrorLimits, request: GateRequest) -> list[VerdictRow]:
    """Return the verdicts on a model's results for one nut or bearing; one "fail" if the model finds no equilibrium.

    If the model's result is outside its range of validity, the first verdict says so; if ``request.strict``, it is "fail".
    ``one``: the nut or bearing with its reference; ``request``: name of the model, and folders with 3D runs.
    """
    scene, ref, name = one.scene, one.reference, request.model or DEFAULT
    title = model_title(name)
    model = model_by_name(name)
    if one.assembly is not None:
        answer = comparison.solve_nut_or_bearing(one, model, request.stores)
        result, status = (None, answer) if isinstance(answer, str) else (answer[0], "converged")
    else:
        if not model.covers_scene(scene):
            advice = "choose another model; the command rollbench list shows which scenes each model can describe"
            raise ArgumentError("model", f'"{name}"', f"a model that can describe {scene.name}", advice)
        solved = run_model(scene, name, comparison.comparison_options(model, scene, ref, request.stores))
        result, status = solved if solved.converged else None, solved.status
    if result is None:
        limit, why = limits.largest_load_error, f"the model computed no loads: {status}"
        return [VerdictRow(scene.name, title, LARGEST, Judgement.FAIL, None, None, limit, levels=ref.levels, detail=why)]
    loads = comparison.solution_from_result(result)
    values = verdict.contact_values_by_model(scene, loads, limits.limits_by_quantity)
    outside = "; ".join(w.brief for w in result.warnings if w.outside_validity)
    detail = outside and f"{OUTSIDE}: {outside}"
    first, *verdicts = verdict.judge_contact_loads(title, result.load, ref, limits, detail=detail)
    verdicts = [replace(first, judgement=Judgement.FAIL) if outside and request.strict else first, *verdicts]
    verdicts += verdict.judge_contact_quantities(title, values, scene, ref, limits)
    whole = [] if one.assembly else verdict.screw_values_by_model(scene, loads, limits.limits_by_quantity)
    return verdicts + [verdict.judge_value(title, v, scene, ref, limits) for v in whole]


def _compute_missing_runs(
    scenes: Sequence[Solvable], request: GateRequest, engine: ComputingSettings, step: Callable[[str], None]
) -> dict[str, str]:
    """Compute missing runs of the 3D reference, and return the reasons why runs failed, by name of the scene.

    ``request``: number of mesh levels and folders of runs; ``engine``: settings that determine where runs are computed;
    ``step``: function that is called with each line of progress. A scene that the 3D reference cannot represent does not
    stop the computation of the others.
    """
    why: dict[str, str] = {}
    for group in group_scenes_by_geometry(scenes):
        missing: dict[tuple[int, ...], list[Solvable]] = {}
        for scene in group:
            stored = [k for k in LEVELS if load_stored_run(scene, k, stores=request.stores) is not None]
            least = request.levels or (ENOUGH if len(stored) < ENOUGH else 0)
            missing.setdefault(tuple(k for k in range(1, least + 1) if k not in stored), []).append(scene)
        missing.pop((), None)
        for levels, lacking in missing.items():
            try:
                tasks = plan_reference_tasks(lacking, levels)
                failed = ensure_runs_are_stored(tasks, request.stores[0], engine, step, request.stores[1:])
            except SceneNotCoveredError as error:
                why |= {scene.name: str(error) for scene in lacking}
                continue
            why |= {run.scene: f"level {run.level} of its 3D reference: {run.status}" for run in failed}
    return why
