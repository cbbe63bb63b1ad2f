"""Names, options and help of every command; each calls its function in ``compare.commands``."""

from compare.commands.arguments import machine, many, reference, scenes, validation
from compare.commands.arguments.order import arrange
from compare.commands.arguments.terminal import app

arrange(app)

__all__ = ["app", "machine", "many", "reference", "scenes", "validation"]
