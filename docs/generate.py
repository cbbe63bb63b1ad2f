"""The reference pages that the program itself writes: scene file, commands, quantities."""

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rollbench.compare.case import case_files_named
from rollbench.compare.quantities import name_and_unit_of_key
from rollbench.compare.results.definitions import TABLES

WORDS = {"COLUMNS": "96", "NO_COLOR": "1", "TERM": "dumb"}


def output_of(*arguments: str) -> str:
    """Output of ``rollbench ARGUMENTS``."""
    command = [sys.executable, "-m", "rollbench", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, **WORDS}).stdout


def pages(folder: Path) -> None:
    """Writes the pages into a folder, each only where its text is new."""
    written = {"scene-file": scene_file, "commands": commands, "quantities": quantities, "misprints": misprints}
    for name, page in written.items():
        text = "\n".join(page()) + "\n"
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def commands() -> Iterator[str]:
    """Every command with its help, in the order of ``rollbench --help``."""
    yield "# Commands\n\nWhat `rollbench COMMAND --help` prints. [Exit codes](exit-codes.md) have a page of their own."
    for name in re.findall(r"^│ ([a-z][a-z-]+)  ", output_of("--help"), re.MULTILINE):
        yield f"\n## `rollbench {name}`\n\n```text\n{output_of(name, '--help').strip()}\n```"


#: Drawings of the lengths of a scene: name, what it shows, caption.
DRAWINGS = (
    (
        "lengths",
        "lengths of a ball screw in a scene file",
        "Section through a screw with its nut: stations from the left end.",
    ),
    (
        "contact",
        "one ball in its grooves",
        "One ball between its four flanks: SL and SR of the screw, NL and NR of the nut.",
    ),
    (
        "flange",
        "lengths of a flanged nut and of the 3D stretch",
        "A nut with a flange, and what only the 3D reference needs.",
    ),
)


def _figure(name: str, alt: str, caption: str) -> str:
    return f"```{{figure}} ../_static/{name}.svg\n:alt: {alt}\n\n{caption}\n```\n"


def scene_file() -> Iterator[str]:
    """Every table and key of a scene file of a screw, bearing or axis, from the JSON Schema; friction's kinds by name."""
    schema = json.loads(output_of("schema"))
    records = schema["$defs"]
    yield (
        "# Scene file\n\nA scene is one TOML file. Lengths, forces and angles are texts with a unit:"
        ' `"20 mm"`, `"5 kN"`, `"45 deg"`.'
        " `rollbench schema` prints the JSON Schema from which this page is made. `rollbench new FILE` writes a scene with"
        " every key as a comment.\n\n"
        "Editors with a TOML language server (Taplo, Tombi; VS Code: Even Better TOML) complete and check the keys: write"
        " `rollbench schema > scene.schema.json` beside the scenes, and `#:schema ./scene.schema.json` as the first line of"
        " a scene.\n\n" + "\n".join(_figure(*drawing) for drawing in DRAWINGS)
    )
    seen: set[str] = set()
    for kind in schema["oneOf"]:
        name = kind["$ref"].rsplit("/", 1)[1]
        yield f"\n## {_title(name)}\n\n{records[name].get('description', '')}\n"
        yield from _table(records, name, "", seen)


def _title(record: str) -> str:
    words = re.sub(r"(?<!^)(?=[A-Z])", " ", record.removesuffix("Keys")).lower()
    return {"scene": "Ball screw or ball bearing", "axis": "Several sets on a shaft"}.get(words, words.capitalize())


def _table(records: Mapping[str, Any], name: str, prefix: str, seen: set[str]) -> Iterator[str]:
    """The keys of a record as rows, then the tables that its keys hold, each once."""
    record = records[name]
    needed = set(record.get("required", ()))
    yield "\n| key | what it is | allowed | default |\n|---|---|---|---|"
    inside: list[tuple[str, str]] = []
    for key, about in record["properties"].items():
        inside += [(key, found) for found in dict.fromkeys(re.findall(r"#/\$defs/(\w+)", json.dumps(about)))]
        given = about.get("default")
        default = "needed" if key in needed else "–" if given in (None, "", []) else _code(given)
        yield f"| `{key}` | {_cell(about.get('description', ''))} | {_allowed(about)} | {default} |"
    for key, found in inside:
        path = f"{prefix}{key}"
        if found not in seen:
            seen.add(found)
            yield f"\n### `[{path}]`\n\n{records[found].get('description', '')}"
            yield from _table(records, found, f"{path}.", seen)


def _allowed(about: Mapping[str, Any]) -> str:
    one = about.get("items", about)
    if "x-allowed" in one:
        return _cell(str(one["x-allowed"]))
    if "enum" in one:
        return ", ".join(_code(word) for word in one["enum"] if word != "")
    if "minimum" in one or "maximum" in one:
        return f"{one.get('minimum', '')} to {one.get('maximum', '')}"
    if "#/$defs/" in json.dumps(about):
        return "tables" if "items" in about else "table"
    return {"string": "text", "boolean": "true, false", "array": "list"}.get(str(one.get("type")), str(one.get("type", "")))


def _code(value: object) -> str:
    return f"`{json.dumps(value)}`".replace('"', "") if isinstance(value, str) else f"`{json.dumps(value)}`"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ").replace("<", "\\<").replace("*", "\\*")


def quantities() -> Iterator[str]:
    """Every quantity of the output: from the fields that state it."""
    yield (
        "# Quantities\n\nEvery number that `solve`, `compare`, `check`, `mesh-study` and `friction` print has a path in"
        " their JSON (`--json`); in Python `result.definition(path)` says the same. The ending of a path is its unit. Axes:"
        " z along the screw, azimuth from x to y about it; a positive axial force pushes the screw to larger z.\n"
    )
    for table in TABLES:
        head = "| path | unit | definition | its error |\n|---|---|---|---|"
        yield f"\n## {table.title}\n\n{table.about}\n\n{head}"
        for path, one in table.paths():
            yield f"| `{path}` | {unit_of_path(path)} | {_cell(one.definition)} | {_cell(one.error or '–')} |"


def unit_of_path(path: str) -> str:
    """Unit of a quantity: the ending of the last part of its path that names one; a dash for counts, words and ratios."""
    units = (
        name_and_unit_of_key(piece.removesuffix("[]").removesuffix("_per_100N"))[1] for piece in reversed(path.split("."))
    )
    return next((unit.text for unit in units if unit is not None), "–").replace("um", "µm")


def misprints() -> Iterator[str]:
    """The sources' misprints, from the data of each source."""
    yield "# Misprints of the sources\n\nThe right value stands in the models; as-printed modes show what a misprint does."
    for path in case_files_named("misprints.toml").values():
        found = tomllib.loads(path.read_text())
        yield f"\n## {found['title']}\n\n| where | printed | right | evidence |\n|---|---|---|---|"
        for row in found["row"]:
            yield "| " + " | ".join(_cell(row[key]) for key in ("place", "wrong", "right", "evidence")) + " |"
