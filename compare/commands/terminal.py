"""Command-line application, to which the modules of the commands add theirs, and options that several commands share."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

from cyclopts import App, ArgumentCollection, Group, Parameter

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError

if TYPE_CHECKING:
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.results.base import TabularRecord


def _types_of(hint: Any) -> set[Any]:
    """Return the types that occur in the type ``hint`` of an option."""
    parts = get_args(hint)
    return {x for part in parts for x in _types_of(part)} if parts else {hint}


def refuse_underscores(arguments: ArgumentCollection) -> None:
    """Raise ArgumentError for an option with a number that has underscores, as Python's but no other numbers may."""
    from rollbench.meshes.units import UNDERSCORE

    for argument in arguments:
        if _types_of(argument.hint) & {int, float}:
            for token in argument.tokens:
                if "_" in token.value:
                    allowed = "a number with digits, point and exponent only"
                    raise ArgumentError(argument.field_info.name, f'"{token.value}"', allowed, UNDERSCORE)


def join_paragraph_lines(doc: str | None) -> str:
    r"""Return a docstring with each paragraph on one line, so that the help text can be wrapped to the terminal's width.

    ``doc``: the docstring; None gives an empty text.

    Examples
    --------
    >>> join_paragraph_lines("Solve.\n\nParameters\n----------\nscene\n    A name,\n    or a file.").splitlines()[-1]
    '    A name, or a file.'
    """
    paragraph = r"(?m)^( *)(?!-+$|Parameters$|Attributes$)\S.*(?:\n\1\S.*)+"
    return re.sub(paragraph, lambda match: re.sub(r"\n *", " ", match[0]), inspect.cleandoc(doc or ""))


app = App(
    name="rollbench",
    help="Validation workbench for ball screws and rolling bearings: compares low-order models with a 3D finite-element "
    "reference.\n\nStart here: rollbench new my.toml --like 40x10 writes a scene, rollbench solve my.toml solves it, and "
    "rollbench compare my.toml measures the error of the result.",
    version=__version__,
    help_format="plaintext",
    default_parameter=Parameter(negative_iterable=""),
    group_arguments=Group("Arguments", validator=refuse_underscores),
    group_parameters=Group("Parameters", validator=refuse_underscores),
    suppress_keyboard_interrupt=False,
)

#: Types of options: a switch that is off by default, and a text that is empty by default.
Flag = Annotated[bool, Parameter(negative="", show_default=False)]
Word = Annotated[str, Parameter(show_default=False)]
#: Type of the option that prints details too.
Verbose = Annotated[bool, Parameter(name=("--verbose", "--assumptions"), negative="", show_default=False)]
#: Type of an option that is followed by several names.
Names = Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")]
#: Help texts of the options for parallel runs.
WORKERS = "Number of parallel runs; 3D runs need 1 to 4 GB each. Default: 1 (report: 2); on a cluster, all its workers."
#: Type of the option that prints the results as JSON.
Json = Annotated[bool, Parameter(name="--json", negative="", show_default=False, help="Print exactly one JSON value.")]


@Parameter(name="*")
@dataclass(frozen=True)
class ProgramOptions:
    """Command-line options by which an external program is used as the model."""

    model_command: Annotated[
        Word,
        Parameter(
            help='Use an external program as the model, by this command: "prog {scene.json} {loads.csv}". The program '
            "reads the scene in the format of export SCENE --format json, and writes the loads in the format of solve "
            "--loads-csv. Exit code 1 if it fails."
        ),
    ] = ""
    model_seconds: Annotated[
        float | None, Parameter(help="Time limit of the external program for one scene, in seconds. Default: 60.")
    ] = None


def model_or_program_name(program: ProgramOptions | None, model: str = "") -> str:
    """Return the name of the model, which is either ``model`` or made from the command of an external program.

    ``program``: options that state the external program, None if none is used. Raises InputError if both a model and a
    program are given, or if a time limit is given without a program.
    """
    if program is None or program == ProgramOptions():
        return model
    if not program.model_command:
        advice = "add `model_command`, or leave the time limit out"
        raise ArgumentError("model_seconds", f"{program.model_seconds:g}", "only with `model_command`", advice)
    if model:
        given = f"{program.model_command} together with the model {model}"
        raise ArgumentError("model_command", given, "either `model` or `model_command`", "leave out one of the two options")
    from rollbench.compare.models.programs import SECONDS, model_command

    seconds = SECONDS if program.model_seconds is None else program.model_seconds
    return model_command(program.model_command, seconds)


@Parameter(name="*")
@dataclass(frozen=True)
class ComputeOptions:
    """Command-line options that select where 3D runs are computed: on this computer, or on a cluster."""

    backend: Annotated[
        str, Parameter(help="Where runs of the 3D reference are computed: joblib (this computer) or dask (a cluster).")
    ] = "joblib"
    scheduler: Annotated[str | None, Parameter(help="Address of the Dask scheduler.")] = None
    workers: Annotated[int | None, Parameter(help=WORKERS)] = None


def engine_from_options(where: ComputeOptions | None, local_workers: int | None = None) -> ComputingSettings:
    """Return the settings for computing runs of the 3D reference on this computer or on the cluster that the options name.

    ``where``: options; None: this computer. ``local_workers``: number of parallel runs on this computer, unless the options
    state it.
    """
    from rollbench.compare.reference.jobs import ComputingSettings

    where = where or ComputeOptions()
    workers = local_workers if where.workers is None and where.scheduler is None else where.workers
    return ComputingSettings(where.backend, where.scheduler, workers, cache_folder())


def cache_folder() -> Path | None:
    """Return the folder in which meshes and condensed bodies are cached; None if the cache is switched off."""
    from rollbench.meshes.cache import default_cache_folder

    return default_cache_folder()


def refuse_given_arguments(given: Mapping[str, object], allowed: str, advice: str, value: str = "") -> None:
    """Raise ArgumentError if the user stated one of the arguments ``given``, none of which may be used here.

    ``given``: values by name of the argument. ``allowed``, ``advice``: when the arguments may be used, and what to do;
    ``value``: what the error says of the given value; empty: the value. All are texts of the error.
    """
    for name, stated in given.items():
        if stated not in (None, "", []) and stated is not False:
            text = ", ".join(map(str, stated)) if isinstance(stated, list) else str(stated)
            raise ArgumentError(name, value or text, allowed, advice)


def check_plot_file(path: Path) -> None:
    """Raise InputError unless the file ``path`` of a figure ends with .svg and can be written."""
    from rollbench.compare.files import check_writable

    if path.suffix.lower() != ".svg":
        raise ArgumentError("plot", str(path), "a file that ends with .svg", "name an SVG file")
    check_writable(path)


def write_plot(path: Path, answer: TabularRecord) -> str:
    """Write the figure of an answer to an SVG file; return a line that names the file, or says why there is none."""
    from rollbench.compare.files import reason_without_figure, write_figure

    figure = answer.figure()
    if figure is None:
        return "no figure: there is nothing to draw"
    return reason_without_figure() or f"wrote {write_figure(path, figure)}: {figure.title}"
