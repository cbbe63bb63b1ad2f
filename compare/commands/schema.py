"""The command rollbench schema."""

from __future__ import annotations

from rollbench.compare.commands.terminal import app
from rollbench.compare.text.printing import print_json


@app.command
def schema() -> None:
    """Print the JSON Schema of a scene file, of all kinds."""
    from rollbench.compare.scenes.friction_kinds.table import json_schema

    print_json(json_schema())
