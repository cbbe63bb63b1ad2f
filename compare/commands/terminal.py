"""Application of the command line, to which commands are added, and options that several commands share."""

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
    help="Validation workbench for ball screws and rolling bearings: low-order models and their references.\n\nStart here: "
    "rollbench new my.toml --like 40x10, then rollbench solve my.toml; rollbench compare my.toml says how far off it is.",
    version=__version__,
    help_format="plaintext",
    default_parameter=Parameter(negative_iterable=""),
    suppress_keyboard_interrupt=False,
)

#: A switch that is off unless given, and a word or path that is none unless given.
Flag = Annotated[bool, Parameter(negative="", show_default=False)]
Word = Annotated[str, Parameter(show_default=False)]
#: What lies behind the answers is printed too.
Verbose = Annotated[bool, Parameter(name=("--verbose", "--assumptions"), negative="", show_default=False)]
#: Names after one option, none unless given.
Names = Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")]
#: What is said of the runs at the same time.
WORKERS = "Runs at the same time, 1 to 3 GB each of the 3D reference; 1 here, 2 of a report, the cluster's unless given."
WAIT = "Seconds to wait for a worker of the scheduler where there is none, as on a cluster with a queue; 60 unless given."
Json = Annotated[bool, Parameter(name="--json", negative="", show_default=False, help="Print exactly one JSON value.")]


@Parameter(name="*")
@dataclass(frozen=True)
class OfProgram:
    """A program of any language as a model."""

    model_command: Annotated[
        Word,
        Parameter(
            help='Command of a program that is the model, "prog {scene.json} {loads.csv}": it reads the scene, as '
            "export SCENE --format json writes it, and writes loads as solve --loads-csv does. Exit code 1 where it fails."
        ),
    ] = ""
    model_seconds: Annotated[float | None, Parameter(help="Seconds that it has for a scene; 60 unless given.")] = None


def model_of(program: OfProgram | None, model: str = "") -> str:
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
    """Where runs are made: on this machine or a cluster, and certificates for its scheduler."""

    backend: Annotated[str, Parameter(help="joblib (this machine) or dask (a cluster).")] = "joblib"
    scheduler: Annotated[str | None, Parameter(help="Address of the Dask scheduler.")] = None
    workers: Annotated[int | None, Parameter(help=WORKERS)] = None
    wait_workers: Annotated[float | None, Parameter(help=WAIT)] = None
    tls_ca: Annotated[Path | None, Parameter(help="Certificate of the authority of a scheduler at tls://HOST:PORT.")] = None
    tls_cert: Annotated[Path | None, Parameter(help="This machine's certificate for such a scheduler.")] = None
    tls_key: Annotated[Path | None, Parameter(help="The key of that certificate.")] = None


def engine(where: Where | None, here: int | None = None) -> Engine:
    """Where jobs run; here: how many at a time on this machine, unless given. Raises InputError for certificates that
    cannot be used."""
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
