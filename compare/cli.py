"""The command line: options and help of a command stand in ``compare.commands.arguments``."""

from __future__ import annotations

import os
import sys

from cyclopts import CycloptsError

from compare.commands.arguments import app
from compare.errors import InputError, one_line


def main(tokens: list[str] | None = None) -> None:
    """Entry point: bad input gives one line on standard error and exit code 2, an interrupt 130."""
    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
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
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(141)
    sys.exit(code if isinstance(code, int) else 0)
