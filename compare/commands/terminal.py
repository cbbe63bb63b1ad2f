"""Application of the command line, and options that several commands share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError

if TYPE_CHECKING:
    from rollbench.compare.reference.jobs import Engine

app = App(
    name="rollbench",
    help="Validation workbench for ball screws and rolling bearings: low-order models, judged by a 3D finite element "
    "reference.\n\nStart here: rollbench new my.toml --like 40x10, then rollbench solve my.toml; rollbench compare my.toml "
    "measures the error of the result.",
    version=__version__,
    help_format="plaintext",
    default_parameter=Parameter(negative_iterable=""),
    suppress_keyboard_interrupt=False,
)

#: Types of options: a switch, off by default, and a text, empty by default.
Flag = Annotated[bool, Parameter(negative="", show_default=False)]
Word = Annotated[str, Parameter(show_default=False)]
#: Print details too.
Verbose = Annotated[bool, Parameter(name=("--verbose", "--assumptions"), negative="", show_default=False)]
#: Several names after one option, none by default.
Names = Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")]
#: Help of options.
WORKERS = "Number of parallel runs; 3D runs need 1 to 3 GB each. Default: 1 (report: 2); on a cluster all its workers."
WAIT = "Seconds to wait until the scheduler has a worker, as on a cluster with a queue. Default: 60."
Json = Annotated[bool, Parameter(name="--json", negative="", show_default=False, help="Print exactly one JSON value.")]


@Parameter(name="*")
@dataclass(frozen=True)
class OfProgram:
    """Options for an external program as a model."""

    model_command: Annotated[
        Word,
        Parameter(
            help='Use an external program as the model, with this command: "prog {scene.json} {loads.csv}". It reads the '
            "scene in the format of export SCENE --format json and writes loads in that of solve --loads-csv. Exit code 1 "
            "where it fails."
        ),
    ] = ""
    model_seconds: Annotated[
        float | None, Parameter(help="Time limit of this program for one scene in seconds. Default: 60.")
    ] = None


def model_name_of(program: OfProgram | None, model: str = "") -> str:
    """Return the model given by its name, or by a command; InputError for both, and for a time limit without command."""
    if program is None or program == OfProgram():
        return model
    if not program.model_command:
        raise ArgumentError("model_seconds", f"{program.model_seconds:g}", "with `model_command`", "give the command")
    if model:
        raise ArgumentError("model_command", program.model_command, "without `model`", "leave one out")
    from rollbench.compare.models.programs import SECONDS, model_command

    seconds = SECONDS if program.model_seconds is None else program.model_seconds
    return model_command(program.model_command, seconds)


@Parameter(name="*")
@dataclass(frozen=True)
class Where:
    """Options for where runs are computed: on this machine or a cluster, and certificates for its scheduler."""

    backend: Annotated[str, Parameter(help="Where runs are computed: joblib (this machine) or dask (a cluster).")] = (
        "joblib"
    )
    scheduler: Annotated[str | None, Parameter(help="Address of the Dask scheduler.")] = None
    workers: Annotated[int | None, Parameter(help=WORKERS)] = None
    wait_workers: Annotated[float | None, Parameter(help=WAIT)] = None
    tls_ca: Annotated[Path | None, Parameter(help="CA certificate for a scheduler at tls://HOST:PORT.")] = None
    tls_cert: Annotated[Path | None, Parameter(help="Client certificate for such a scheduler.")] = None
    tls_key: Annotated[Path | None, Parameter(help="Key of the client certificate.")] = None


def engine_of(where: Where | None, here: int | None = None) -> Engine:
    """Return where jobs run. Raises InputError for certificates that cannot be used.

    here: number of jobs at a time on this machine, unless the user gives it.
    """
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.reference.parallel import use_tls

    where = where or Where()
    use_tls(*(None if file is None else str(file) for file in (where.tls_ca, where.tls_cert, where.tls_key)))
    workers = here if where.workers is None and where.scheduler is None else where.workers
    return Engine(where.backend, where.scheduler, workers, cache_folder(), where.wait_workers)


def cache_folder() -> Path | None:
    """Return the folder of meshes and condensed parts; None for no cache."""
    from rollbench.meshes.cache import default_root

    return default_root()
