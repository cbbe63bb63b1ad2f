"""Names, options and help of every command; each calls its function in ``compare.commands``, or in its wing."""

from importlib import import_module

from cyclopts import App

from rollbench.compare.commands.arguments.order import arrange
from rollbench.compare.commands.arguments.terminal import app
from rollbench.compare.registration import registered

#: Modules of this folder and the commands of the core that they add.
CORE = {
    "scenes": ("list", "schema", "new", "solve", "condense"),
    "validation": ("compare", "report", "verify", "check", "audit", "completion"),
}
#: Commands that tell of all others.
OF_ALL = ("completion",)


def commands(first: str = "") -> App:
    """The application with the command that the command line begins with, all of them where it begins with none that is
    known, or with one that tells of all."""
    modules = {name: f"commands.arguments.{module}" for module, names in CORE.items() for name in names}
    modules |= {name: module for one in registered().values() for name, module in one.commands.items()}
    wanted = modules if first not in modules or first in OF_ALL else (first,)
    for name in wanted:
        import_module(f"rollbench.compare.{modules[name]}")
    arrange(app)
    return app


__all__ = ["CORE", "app", "commands"]
