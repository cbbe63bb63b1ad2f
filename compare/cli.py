"""Command line: table of the commands with their modules in ``compare.commands``, error messages, and exit codes."""

from __future__ import annotations

import os
import re
import signal
import sys
import threading
import time
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from copy import copy
from importlib import import_module
from types import FrameType

from cyclopts import App, CycloptsError, Group

from rollbench.compare.commands.terminal import app, join_paragraph_lines
from rollbench.compare.errors import ArgumentError, InputError, one_line
from rollbench.compare.running import clear_progress_line, input_error_of_failed_import, restart_clock
from rollbench.compare.text.printing import StandardOutputError, guard_standard_output
from rollbench.meshes.processes import limit_to_one_thread

#: Largest time [s] for which an interrupted command waits for threads that clean up after parallel workers.
TIDYING = 2.0
#: Command-line options by name of the argument of a library function, where the option is not the same name with dashes;
#: positional arguments of the command line are without dashes.
OPTIONS = {
    "models": "--model",
    "limits": "--limit",
    "everything": "--all",
    "names": "names",
    "part": "part",
    "scene": "scene",
    "scenes": "scenes",
}


#: Commands below each heading of ``rollbench --help``, with the module in ``compare.commands`` that defines each command.
COMMANDS = {
    "Start here": {
        "new": "new",
        "solve": "solve",
        "friction": "friction",
        "view": "report",
        "report": "report",
        "doctor": "doctor",
    },
    "How far to trust it": {"compare": "compare", "check": "check", "survey": "survey", "mesh-study": "mesh_study"},
    "Many scenes": {"sweep": "sweep", "table": "sweep"},
    "To and from other programs": {"export": "export", "condense": "export", "crosscheck": "export", "schema": "new"},
    "This program and its sources": {
        "list": "printed",
        "audit": "printed",
        "stability": "survey",
        "bench": "bench",
        "completion": "doctor",
    },
}
#: Command for which the modules of all other commands must be imported.
OF_ALL = "completion"


def app_with_commands(first: str = "") -> App:
    """Return the command-line application with the command ``first`` only; with all commands if ``first`` is no command."""
    modules = {name: module for group in COMMANDS.values() for name, module in group.items()}
    for name in modules if first not in modules or first == OF_ALL else (first,):
        import_module(f"rollbench.compare.commands.{modules[name]}")
    group_commands_in_help(app)
    return app


def group_commands_in_help(app: App) -> None:
    """Group the commands of the application under the headings of `COMMANDS`."""
    for place, (heading, names) in enumerate(COMMANDS.items()):
        group = Group(heading, sort_key=place)
        for number, name in enumerate(names):
            if name in app:
                app[name].group = (group,)
                app[name].sort_key = number
                command = app[name].default_command
                command.__doc__ = join_paragraph_lines(command.__doc__)
    others = Group("Other options", sort_key=len(COMMANDS))
    for flag in ("--help", "--version"):
        app[flag].group = (others,)


def option_of_argument(argument: str) -> str:
    """Return the command-line option that corresponds to an argument of a library function.

    ``argument``: name of the argument, or ``name=value``.

    Examples
    --------
    >>> [option_of_argument(text) for text in ("max_error", "levels=1", "spread=True", "compute=False")]
    ['--max-error', '--levels 1', '--spread', '--no-compute']
    """
    name, _, value = argument.partition("=")
    spelled = OPTIONS.get(name, "--" + name.replace("_", "-"))
    if value == "False":
        return spelled.replace("--", "--no-", 1)
    return spelled if value in ("", "True") else f"{spelled} {value}"


def error_with_option_names(error: InputError) -> InputError:
    """Return a copy of an input error whose message names command-line options in place of arguments of functions."""
    said = copy(error)
    argument = re.compile("`([a-z_]+(?:=[^`]*)?)`")
    for part in ("allowed", "advice"):
        setattr(said, part, argument.sub(lambda found: option_of_argument(found[1]), getattr(error, part)))
    if isinstance(error, ArgumentError):
        said.file, said.key = error.file or "command line", ", ".join(map(option_of_argument, error.key.split(", ")))
    return said


def _discard_standard_output() -> None:
    """Redirect standard output to the null device, so that text which is not written yet is discarded."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class Terminated(KeyboardInterrupt):
    """Exception raised by the signal TERM, which is handled like an interrupt from the keyboard."""


def _raise_terminated(_number: int, _frame: FrameType | None) -> None:
    """Raise `Terminated`; this is the handler of the signal TERM."""
    raise Terminated


@contextmanager
def _treat_term_signal_as_interrupt() -> Iterator[None]:
    """Handle the signal TERM like an interrupt from the keyboard inside the ``with`` block; only in the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, _raise_terminated)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL if before is None else before)


def _print_to_stderr(lines: Iterable[str]) -> None:
    """Print lines on standard error, each after "rollbench: "; if standard error is closed, they are lost."""
    clear_progress_line()
    with suppress(OSError):
        sys.stderr.writelines(f"rollbench: {line}\n" for line in lines)
        sys.stderr.flush()


def _wait_for_threads() -> None:
    """Wait up to `TIDYING` seconds for threads that clean up after parallel workers.

    If this process ended while such a thread had removed a semaphore but not yet reported this, joblib would warn of a
    leak.
    """
    until = time.monotonic() + TIDYING
    for thread in threading.enumerate():
        if thread is not threading.current_thread():
            thread.join(max(until - time.monotonic(), 0.0))


@_treat_term_signal_as_interrupt()
def main(tokens: list[str] | None = None) -> None:
    """Run a command with the arguments ``tokens`` (None: those of the process), and exit.

    Exit codes: 2 for bad input, with one line on standard error; 1 if an external program of the user fails; 130 after an
    interrupt; 143 after the signal TERM; 141, without a message, if the reader of a pipe has ended; 74, with one line, if
    standard output cannot be written.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # the caller closed it
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - open until the process ends
    if tokens is None:
        limit_to_one_thread()
        from rollbench.meshes.cache import switch_on_geometry_cache  # loads numpy, which reads the number of threads

        switch_on_geometry_cache()
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")  # joblib restarts the worker
    try:
        restart_clock()
        asked = sys.argv[1:] if tokens is None else tokens
        run = app_with_commands(asked[0] if asked else "")
        code = run(asked, exit_on_error=False, print_error=False, result_action="return_value")
        with guard_standard_output():
            sys.stdout.flush()
    except (InputError, ImportError) as error:
        refusal = error if isinstance(error, InputError) else input_error_of_failed_import(error)
        if refusal is None:
            raise
        _print_to_stderr(error_with_option_names(refusal).lines())
        sys.exit(refusal.code)
    except CycloptsError as error:
        text = one_line(" ".join(str(error).split()), 400)
        from rollbench.meshes.units import number_advice

        given = re.search('convert "(.*)" into (?:int|float)', text)
        advice = number_advice(given[1] if given else "", "rollbench --help lists commands and options")
        _print_to_stderr((f"command line: {text} Advice: {advice}",))
        sys.exit(2)
    except KeyboardInterrupt as stop:
        _wait_for_threads()
        _print_to_stderr(("interrupted; nothing was left half-written",))
        sys.exit(143 if isinstance(stop, Terminated) else 130)
    except BrokenPipeError:
        _discard_standard_output()
        sys.exit(141)
    except SystemExit as stop:
        if isinstance(stop.__context__, BrokenPipeError):  # the package rich exits with 1
            _discard_standard_output()
            sys.exit(141)
        raise
    except StandardOutputError as error:
        _discard_standard_output()
        _print_to_stderr((f"standard output: {error}",))
        sys.exit(74)
    sys.exit(code if isinstance(code, int) else 0)
