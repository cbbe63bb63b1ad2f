"""The command rollbench list: what is shipped."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rollbench.compare.commands.terminal import Flag, Json, Word, app
from rollbench.compare.text.printing import Answer, print_answer


def shipped() -> Answer:
    """Scenes, models and printed tables."""
    data = _shipped_json()
    return Answer(data, _lines(data))


def _shipped_json() -> dict[str, dict[str, Any]]:
    """Scenes by kind and models with their titles, printed tables with their number of rows."""
    from rollbench.compare.models.registry import AXIS_MODELS, MODELS
    from rollbench.compare.models.user_models import installed, origin
    from rollbench.compare.printed import printed_data
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.names import AXIS, KINDS, WHOLE

    titles = {name: catalogue.heading(name)["title"] for name in catalogue.scene_names()}
    of_users = {name: origin(name) for name in installed() if name not in MODELS}
    return {
        "scenes": {k: {n: t for n, t in titles.items() if catalogue.kind(n) == k} for k in (*WHOLE, AXIS, *KINDS)},
        "models": {model.name: model.about for model in MODELS.values()},
        **({"models of other packages": of_users} if of_users else {}),
        "models of several sets on one shaft": {name: MODELS[name].label for name in AXIS_MODELS},
        "printed_tables": {name: len(printed_data.load_table(name)) for name in printed_data.tables()},
    }


def _lines(data: Mapping[str, Any]) -> Iterator[str]:
    """The same for the terminal."""
    groups = {f"scenes, {kind}": titles for kind, titles in data["scenes"].items()}
    groups |= {group: entries for group, entries in data.items() if group != "scenes"}
    width = max(len(name) for group in groups.values() for name in group)
    for group, entries in groups.items():
        yield group.replace("_", " ")
        for name, text in entries.items():
            yield f"  {name:{width}}  {f'{text} rows' if group == 'printed_tables' else text}"


@app.command(name="list")
def list_(*, trace: Flag = False, table: Word = "", as_json: Json = False) -> None:
    """List the scenes, the models and the printed tables that are shipped.

    Parameters
    ----------
    trace
        Instead: every printed number and claim with its scenes, or why it has none, the function that computes it and its
        test.
    table
        The same for the numbers of one printed table.
    """

    if trace or table:
        from rollbench.compare.commands.printed import traced

        print_answer(traced(table), as_json)
    else:
        print_answer(shipped(), as_json)
