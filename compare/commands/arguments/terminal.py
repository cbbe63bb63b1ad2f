"""The application that the commands of the command line are added to, and how they print."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from rollbench.comparison import __version__
from rollbench.comparison.errors import escaped

if TYPE_CHECKING:
    from rollbench.comparison.reference.jobs import Engine

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
Json = Annotated[bool, Parameter(name="--json", negative="", show_default=False, help="Print exactly one JSON value.")]


@Parameter(name="*")
@dataclass(frozen=True)
class Tls:
    """Certificates for a Dask scheduler at tls://HOST:PORT."""

    tls_ca: Annotated[Path | None, Parameter(help="Certificate of the authority of a scheduler at tls://HOST:PORT.")] = None
    tls_cert: Annotated[Path | None, Parameter(help="This machine's certificate for such a scheduler.")] = None
    tls_key: Annotated[Path | None, Parameter(help="The key of that certificate.")] = None


def engine(backend: str, scheduler: str | None, workers: int | None, tls: Tls | None) -> Engine:
    """Where jobs run. Raises InputError for certificates that cannot be used."""
    from rollbench.comparison.reference.jobs import Engine
    from rollbench.comparison.reference.parallel import use_tls

    if tls is not None:
        use_tls(*(None if file is None else str(file) for file in (tls.tls_ca, tls.tls_cert, tls.tls_key)))
    return Engine(backend, scheduler, workers, cache_folder())


class OutputLost(Exception):
    """Standard output cannot be written: full, or taken away."""


@contextmanager
def writing() -> Iterator[None]:
    """Writing to standard output: what fails there, but for a pipe without reader, is an OutputLost."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputLost(error.strerror or str(error)) from error


def print_json(value: Any) -> None:
    """Print one JSON value on standard output. Raises ValueError for a number that is not finite, OutputLost."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with writing():
        sys.stdout.write(text)


def show(*parts: Any) -> None:
    """Print texts and tables of rich: on a terminal texts wrapped, and tables taken apart, to its width; elsewhere texts as
    they are, and tables without rules, 160 columns wide or as their words need. Raises OutputLost."""
    from rich.console import Console
    from rich.table import Table

    from rollbench.comparison.commands.wrapping import fitted, unbroken, wrapped

    terminal = sys.stdout.isatty()
    console = Console(width=None if terminal else 160, soft_wrap=True, highlight=False, markup=False)
    with writing():
        for given in parts:
            part = "\n".join(map(escaped, given.split("\n"))) if isinstance(given, str) else given  # names of files
            if isinstance(part, Table) and not terminal:
                part.box, part.pad_edge = None, False
                console.width = max(160, unbroken(part))
            if terminal and isinstance(part, Table):
                console.print(*fitted(part, text_width()), sep="\n")
            else:
                console.print(wrapped(part, text_width()) if terminal and isinstance(part, str) else part)


def text_width() -> int:
    """Width of running text: the terminal's, 100 where standard output is none."""
    return shutil.get_terminal_size((100, 24)).columns if sys.stdout.isatty() else 100


def cache_folder() -> Path | None:
    """Folder of meshes and condensed parts, None for none."""
    from rollbench.meshes.cache import default_root

    return default_root()
