"""Names, options and help of every command; each calls its function in ``compare.commands``."""

from rollbench.comparison.commands.arguments import machine, many, reference, scenes, validation
from rollbench.comparison.commands.arguments.order import arrange
from rollbench.comparison.commands.arguments.terminal import app

arrange(app)

__all__ = ["app", "machine", "many", "reference", "scenes", "validation"]
