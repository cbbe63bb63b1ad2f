"""The command line: options and help of a command stand in ``compare.commands.arguments``."""

from __future__ import annotations

import os
import sys

from cyclopts import CycloptsError

from compare.commands.arguments import app
from compare.commands.arguments.terminal import OutputLost, writing
from compare.errors import InputError, one_line


def _drop_output() -> None:
    """Send what is still buffered for standard output nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def main(tokens: list[str] | None = None) -> None:
    """Entry point: bad input gives one line on standard error and exit code 2, an interrupt 130; an output that nobody
    reads any more ends quietly with 141, one that cannot be written with 74 and one line."""
    if sys.stdout is None:  # closed by the caller: nobody reads it
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - for the life of the process
    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        with writing():
            sys.stdout.flush()
    except InputError as error:
        sys.stderr.writelines(f"rollbench: {line}\n" for line in error.lines())
        sys.exit(2)
    except CycloptsError as error:
        text = one_line(" ".join(str(error).split()), 400)
        sys.stderr.write(f"rollbench: command line: {text} Advice: see rollbench --help\n")
        sys.exit(2)
    except KeyboardInterrupt:
        sys.stderr.write("rollbench: interrupted; nothing was left half-written\n")
        sys.exit(130)
    except BrokenPipeError:
        _drop_output()
        sys.exit(141)
    except OutputLost as error:
        _drop_output()
        sys.stderr.write(f"rollbench: standard output: {error}\n")
        sys.exit(74)
    sys.exit(code if isinstance(code, int) else 0)
