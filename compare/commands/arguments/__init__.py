"""Names, options and help of every command; each calls its function in ``compare.commands``."""

from compare.commands.arguments import many, reference, scenes, validation
from compare.commands.arguments.terminal import app

__all__ = ["app", "many", "reference", "scenes", "validation"]
