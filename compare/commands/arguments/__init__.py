"""Names, options and help of every command; each calls its function in ``compare.commands``, or in its wing."""

from importlib import import_module

from cyclopts import App

from rollbench.comparison.commands.arguments import machine, many, reference, scenes, validation
from rollbench.comparison.commands.arguments.order import arrange
from rollbench.comparison.commands.arguments.terminal import app
from rollbench.comparison.registration import registered

#: Commands that tell of all others.
OF_ALL = ("completion",)


def commands(first: str = "") -> App:
    """The application with its commands; of the wings', the one that the command line begins with; all of them where it
    begins with none that is known."""
    wings = {name: module for one in registered().values() for name, module in one.commands.items()}
    known = first in wings or (first in app and first not in OF_ALL and not first.startswith("-"))
    for name, module in wings.items():
        if name == first or not known:
            import_module(f"rollbench.comparison.{module}")
    arrange(app)
    return app


__all__ = ["app", "commands", "machine", "many", "reference", "scenes", "validation"]
