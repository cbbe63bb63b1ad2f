"""What rollbench solve --members prints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.text.printing import Answer, on_terminal
from rollbench.compare.text.tables import ruled

if TYPE_CHECKING:
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.studies.members.members import Members


def run(
    name: str, model: str, count: int, *, csv_out: Path | None, seed: int | None, engine: Engine, balls: bool = False
) -> Answer:
    """Solve, write one CSV row a member as they come (balls: show the bands of every ball too); exit code 1 where none
    converged. Raises InputError."""
    from rollbench.compare.results.base import with_schema
    from rollbench.compare.scenes import catalogue

    described = catalogue.any_scene(name)
    from rollbench.compare.studies.members.answer import solved, whole

    each, cases = solved(described, name, model, count, seed, engine, on_terminal, csv_out)
    shown = [x for batch in each for x in as_table(batch, balls=balls)] + [f"{csv_out}: one row a member"] * bool(csv_out)
    data = with_schema(whole(described, each, cases))
    return Answer(data, shown, 0 if all(len(batch.failed) < count for batch in each) else 1)


def _statistics(title: str, headings: Mapping[str, str], rows: Mapping[str, dict[str, Any] | None]) -> Any:
    table = []
    for key, stats in rows.items():
        if stats is None:
            continue
        q = {row["level"]: f"{row['value']:.4g} ({row['low']:.4g} to {row['high']:.4g})" for row in stats["quantiles"]}
        first = (f"{stats[k]:.4g}" for k in ("mean", "standard_error", "standard_deviation", "smallest"))
        table.append([headings[key], *first, q[0.05], q[0.5], q[0.95], q[0.99], f"{stats['largest']:.4g}"])
    heads = ("", "mean", "standard error", "deviation", "smallest", "5 %", "median", "95 %", "99 %", "largest")
    return ruled(title, heads, table, ("",))


def as_table(members: Members, *, balls: bool = False) -> list[Any]:
    """The same for the terminal: statistics, and, where asked for, the bands of every ball."""
    from rollbench.compare.studies.members.answer import as_json
    from rollbench.compare.studies.members.blocks import KEPT, OF_SET, WHOLE
    from rollbench.meshes.axis import Assembly

    data = as_json(members)
    several = isinstance(members.scene, Assembly)
    parts: list[Any] = [
        f"{data['scene']}, model {data['model']}, seed {data['seed']}: {data['members']} members, {data['converged']} "
        f"converged, {1e3 * members.seconds / data['members']:.3g} ms a member"
    ]
    parts += [f"member {row['member']}: {row['status']}" for row in data["failed"][:5]]
    headings = WHOLE if several else KEPT
    tables = [_statistics("members (in brackets: 95 % interval of the quantile)", headings, data["statistics"])]
    tables += [_statistics(f"set {s['set']}, {s['name']}", OF_SET, s["statistics"]) for s in data.get("sets", [])]
    of_nut = "stiffness at the loads: tangent, by 0.1 % more load, of shaft and nut; solve's rigidity is the nut's alone"
    stiff = "tangent rigidity: in equilibrium, where it is asked for" if several else of_nut
    parts += [*tables, f"life: ISO/TS 16281 equivalent loads, raceways equally strong; {stiff}"]
    return [*parts, _bands(data, members.bands.width) if balls else "bands of every ball: --balls"]


def _bands(data: dict[str, Any], width: float) -> Any:
    keys = [key for key in (data["balls"][0] if data["balls"] else ()) if key != "quantile_0.5_N"]
    rows = ([v if isinstance(v := row[key], str) else f"{v:.4g}" for key in keys] for row in data["balls"])
    headings = (key.removesuffix("_N").replace("_", " ") for key in keys)
    return ruled(f"bands of the contact loads / N (to {width:.2g} N)", headings, rows)
