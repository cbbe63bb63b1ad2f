"""Drawing of the layers of the program, read from the import contracts in pyproject.toml."""

import tomllib
from pathlib import Path

import matplotlib as mpl
from drawings import BALL, NUT, STEEL
from matplotlib import pyplot as plt
from matplotlib.patches import Rectangle

PROJECT = Path(__file__).parent.parent / "pyproject.toml"
#: Width of the drawing, and height of a layer [pt].
WIDTH, HEIGHT = 520, 34
#: Colours of the layers: command line and report, what this package holds of them, physics and geometry.
SHELLS = ("__main__", "cli", "commands", "report")


def layers() -> list[list[str]]:
    """Packages by layer, top to bottom: those of ``compare``, then the folders below it."""
    contracts = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    of = {one.get("containers", ["all"])[0]: one["layers"] for one in contracts if one["type"] == "layers"}
    rows = [*of["rollbench.compare"], *of["all"][1:]]
    return [[name.strip().removeprefix("rollbench.") for name in row.split("|")] for row in rows]


def draw(path: Path) -> None:
    """Writes the drawing as SVG: a row a layer, which imports from rows below it only."""
    mpl.rcParams["svg.fonttype"] = "none"
    rows = layers()
    figure = plt.figure(figsize=(WIDTH / 72, HEIGHT * len(rows) / 72))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, WIDTH), ylim=(HEIGHT * len(rows), 0))
    axes.axis("off")
    for k, names in enumerate(rows):
        width = WIDTH / len(names)
        for place, name in enumerate(names):
            below = name in ("lowfi", "hifi", "reports", "meshes")
            fill = BALL if name in SHELLS else STEEL if below else NUT
            axes.add_patch(
                Rectangle((width * place + 2, HEIGHT * k + 2), width - 4, HEIGHT - 4, fc=fill, ec="black", lw=0.8)
            )
            axes.text(width * (place + 0.5), HEIGHT * (k + 0.5), name, fontsize=13, ha="center", va="center")
    figure.savefig(path)
    plt.close(figure)
