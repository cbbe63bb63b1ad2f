"""Drawing of the house: its parts as boxes by floor, and the imports between them as arrows, read from the code."""

import ast
from collections import Counter
from functools import cache
from pathlib import Path

import matplotlib as mpl
from drawings import BALL, NUT, STEEL
from matplotlib import pyplot as plt
from matplotlib.patches import FancyArrowPatch, Rectangle

import rollbench
from rollbench.compare.registration import registered

TOP = Path(rollbench.__file__).parent
CORE = ("compare", "lowfi", "hifi", "reports", "meshes")
#: Boxes from left to right in each row of the drawing, the rows from top to bottom: an arrow may only go to a lower row.
ROWS: tuple[tuple[str, ...], ...] = (
    ("kalker",),
    ("liu", "smith", "makers", "lin", "external"),
    ("rolling", "extremes"),
    ("random_errors", "bearings", "crosscheck", "friction", "sweep"),
    ("doctor", "evidence", "bench", "export", "mesh_study"),
    ("members",),
    ("compare",),
    ("lowfi", "hifi", "reports"),
    ("meshes",),
)
_SOURCES = (*ROWS[1], *ROWS[0])
_WINGS = (*ROWS[5], *ROWS[4], *ROWS[3][:-1], "rolling", "sweep", "extremes")
_WIDE = 456 / len(_WINGS)
_UPPER = {name: 130 + 29 * row for row in (2, 3, 4, 5) for name in ROWS[row]}
#: Left edge, upper edge, width and height of each box [pt].
_BOXES: dict[str, tuple[float, float, float, float]] = {
    **{name: (12 + 76 * k, 12 if name in ROWS[0] else 66, 70, 38) for k, name in enumerate(_SOURCES)},
    **{
        name: (10 + _WIDE * k, 190 if name in ROWS[2] else 225 if name in ROWS[3] else 260, _WIDE - 9, 126)
        for k, name in enumerate(_WINGS)
    },
    "compare": (14, 462, 492, 36),
    **{name: (14 + 145 * k, 532, 130, 36) for k, name in enumerate(ROWS[7])},
    "meshes": (14, 602, 492, 36),
}
_FRAMES = {"sources": (4, 4, 512, 110), "wings": (4, 178, 466, 215), "core": (4, 436, 512, 212)}


def box_of(module: str) -> str:
    """The box of a module, named below ``rollbench``: its wing (physics included), its source, or its part of the core."""
    parts = module.split(".")
    if parts[:2] in (["compare", "wings"], ["compare", "sources"]) and parts[2:]:
        return parts[2]
    return _physics().get(".".join(parts[:2]), parts[0] if parts[0] in CORE else "compare")


@cache
def _physics() -> dict[str, str]:
    return {folder.replace("/", "."): wing for wing, one in registered().items() for folder in one.folders}


@cache
def arrows(top: Path = TOP) -> Counter[tuple[str, str]]:
    """Number of import statements from one box to another, wherever they stand in a module."""
    found: Counter[tuple[str, str]] = Counter()
    for path in (*top.glob("*.py"), *(path for folder in CORE for path in (top / folder).rglob("*.py"))):
        parts = path.relative_to(top).with_suffix("").parts
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            if isinstance(node, ast.ImportFrom):
                package = ("rollbench", *parts[: -node.level]) if node.level else ()
                names = [".".join((*package, *filter(None, (node.module, name)))) for name in names]
            boxes = {box_of(name.removeprefix("rollbench.")) for name in names if name.startswith("rollbench.")}
            found.update((box_of(".".join(parts)), box) for box in boxes - {box_of(".".join(parts))})
    return found


def _ends(start: str, end: str, arriving: list[str]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where an arrow begins and ends, beside the others that arrive at its box."""
    if start == "sources":
        return (493, 114), (493, 436)
    x, y, width, height = _BOXES[start]
    foot = (x + width / 2, y + height)
    if end == "core":
        return foot, (foot[0], 436)
    if start in CORE and end in CORE:  # straight down, beside the middle row where it is passed
        down = x + width / 2 if start in ROWS[7] else 480 if end == "meshes" else _BOXES[end][0] + _BOXES[end][2] / 2
        return (down, y + height), (down, _BOXES[end][1])
    left, upper, broad, _ = _BOXES[end]
    if start in _WINGS:  # a wing on another
        foot = (x, y + 12)
    apart = min(9, broad / len(arriving))
    return foot, (left + broad / 2 + apart * (arriving.index(start) - (len(arriving) - 1) / 2), upper)


def draw(path: Path) -> None:
    """Writes the drawing as SVG. What a wing imports of the core is one arrow, and what all sources import of it."""
    mpl.rcParams["svg.fonttype"] = "none"
    drawn: Counter[tuple[str, str]] = Counter()
    for (start, end), count in arrows().items():
        to_core = end in CORE and start not in CORE
        drawn["sources" if to_core and start in _SOURCES else start, "core" if to_core else end] += count
    figure = plt.figure(figsize=(520 / 72, 684 / 72))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 520), ylim=(684, 0))
    axes.axis("off")
    for name, (x, y, width, height) in _FRAMES.items():
        axes.add_patch(Rectangle((x, y), width, height, fc="#fafafa", ec="grey", lw=0.8))
        axes.text(x + 8, y + 17, name, fontsize=15, weight="bold", va="center")
    for name, (x, y, width, height) in _BOXES.items():
        fill = STEEL if name in CORE else BALL if name in _SOURCES else NUT
        axes.add_patch(Rectangle((x, y), width, height, fc=fill, ec="black", lw=0.8, zorder=3))
        middle, turned = (x + width / 2, y + height / 2 - 4 * (name in _SOURCES)), 90 * (name in _WINGS)
        axes.text(*middle, name, fontsize=15, rotation=turned, ha="center", va="center", zorder=4)
    for x, y in [(10, 660), *((x + 4, y + height - 11) for name, (x, y, _, height) in _BOXES.items() if name not in CORE)]:
        axes.add_patch(Rectangle((x, y), 8, 11, fc="#b3261e", lw=0, zorder=5))
    axes.text(24, 666, "one door each: registration.py", fontsize=15, va="center")
    for (start, end), count in drawn.items():
        arriving = sorted((a for a, b in drawn if b == end and a in _BOXES), key=lambda a: _BOXES[a][:2])
        wide = 0.45 * count**0.5
        style = f"Simple,tail_width={wide},head_width={wide + 6},head_length=9"
        arrow = FancyArrowPatch(
            *_ends(start, end, arriving), arrowstyle=style, lw=0, color="#444444", zorder=2, shrinkA=0, shrinkB=0
        )
        arrow.set_gid(f"{start} to {end}: {count}")
        axes.add_patch(arrow)
    figure.savefig(path)
    plt.close(figure)
