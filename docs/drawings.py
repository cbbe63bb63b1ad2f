"""Drawings of the manual that are not results: the lengths of a scene."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Rectangle, Wedge

STEEL, NUT, BALL = "#d7dce3", "#b9c7dd", "#f3c969"
CODE = {"fontsize": 9, "family": "monospace"}


def draw(folder: Path) -> None:
    """Writes every drawing into a folder as SVG, each only where it is older than this file."""
    mpl.rcParams["svg.fonttype"] = "none"
    for name, drawing in {"lengths": lengths, "contact": contact, "flange": flange, "refined": refined}.items():
        path = folder / f"{name}.svg"
        if not path.exists() or path.stat().st_mtime < Path(__file__).stat().st_mtime:
            drawing(path)


def _axes(size: tuple[float, float], aspect: str = "equal") -> tuple[plt.Figure, Axes]:
    figure, axes = plt.subplots(figsize=size, layout="constrained")
    axes.set_aspect(aspect)
    axes.axis("off")
    return figure, axes


def _across(axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, below: bool = False) -> None:
    """A dimension line along z with its text above or below it."""
    _line(axes, start, end)
    x, y = (start[0] + end[0]) / 2, start[1]
    axes.text(x, y + (-1.2 if below else 1.2), text, ha="center", va="top" if below else "bottom", **CODE)


def _upright(axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, at: float) -> None:
    """A dimension line along the radius with its text beside it at a height."""
    _line(axes, start, end)
    axes.text(start[0] + 1.2, at, text, ha="left", va="center", **CODE)


def _line(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate("", xy=start, xytext=end, arrowprops={"arrowstyle": "<->", "lw": 0.8, "shrinkA": 0, "shrinkB": 0})


def lengths(path: Path) -> None:
    """Section through a screw with its nut: stations, lengths and diameters as scene files name them."""
    figure, axes = _axes((10, 4.6))
    axes.add_patch(Rectangle((0, -16), 160, 32, fc=STEEL, ec="black", lw=0.8))
    for side in (-1, 1):
        axes.add_patch(Rectangle((58, side * 17 - (14 if side < 0 else 0)), 54, 14, fc=NUT, ec="black", lw=0.8))
        for k in range(5):
            z = 62.5 + 10 * k + (5 if side > 0 else 0)
            axes.add_patch(Circle((z, side * 16.5), 2.8, fc=BALL, ec="black", lw=0.7))
    for z in (*range(6, 56, 10), *range(114, 156, 10)):
        axes.plot([z, z + 5], [16, -16], color="grey", lw=0.5)
    axes.plot([-8, 168], [0, 0], color="black", lw=0.6, ls=(0, (12, 3, 2, 3)))
    axes.annotate("", xy=(178, 0), xytext=(166, 0), arrowprops={"arrowstyle": "->"})
    axes.text(179, 0, "z", va="center")
    for z in (0, 160):
        axes.plot([z, z - 4, z + 4, z], [-16, -23, -23, -16], color="black", lw=0.8)
    axes.text(-5, -27, "[[supports]] at", **CODE, ha="left")
    axes.annotate("", xy=(0, 4), xytext=(-18, 4), arrowprops={"arrowstyle": "-|>", "color": "#b3261e", "lw": 1.6})
    axes.text(-18, 7, "[[loads]] force", **CODE, color="#b3261e")
    _across(axes, (0, -36), (160, -36), "screw.length")
    _across(axes, (0, 42), (85, 42), "nut.position")
    _across(axes, (58, 34), (112, 34), "nut.length")
    _across(axes, (82.5, -25), (92.5, -25), "track.lead", below=True)
    _upright(axes, (118, -31), (118, 31), "nut.outer_diameter", 25)
    _upright(axes, (132, -16), (132, 16), "screw.outer_diameter", -8)
    _upright(axes, (16, -16.5), (16, 16.5), "track.pitch_diameter", 8)
    axes.plot([85, 85], [31, 45], color="black", lw=0.5)
    axes.set_xlim(-22, 184)
    axes.set_ylim(-42, 48)
    figure.savefig(path)
    plt.close(figure)


def contact(path: Path) -> None:
    """One ball between the four flanks of its grooves: flanks' names, contact angle, groove radius, lands."""
    figure, axes = _axes((5.6, 4.6))
    R, f, angle = 1.0, 0.62, np.radians(45)
    radius = 2 * R * f
    excess = radius - R
    for side, fill in ((1, NUT), (-1, STEEL)):
        phi = np.linspace(np.radians(20), np.radians(78), 60)
        left = np.c_[
            excess * np.sin(angle) - radius * np.sin(phi[::-1]), excess * np.cos(angle) - radius * np.cos(phi[::-1])
        ]
        right = np.c_[-left[::-1, 0], left[::-1, 1]]
        line = np.r_[[[-2.4, left[0, 1]]], left, right, [[2.4, left[0, 1]]]]
        line[:, 1] *= -side
        rim = np.r_[line, [[2.4, side * 2.2], [-2.4, side * 2.2]]]
        axes.fill(rim[:, 0], rim[:, 1], fc=fill, ec="black", lw=0.9)
    axes.add_patch(Circle((0, 0), R, fc=BALL, ec="black", lw=0.9))
    for name, sx, sy in (("SL", -1, -1), ("SR", 1, -1), ("NL", -1, 1), ("NR", 1, 1)):
        axes.plot([0, 1.35 * sx * np.sin(angle)], [0, 1.35 * sy * np.cos(angle)], color="black", lw=0.6, ls="--")
        axes.text(1.5 * sx * np.sin(angle), 1.5 * sy * np.cos(angle), name, ha="center", va="center", weight="bold")
    axes.plot([0, 0], [0, 1.9], color="black", lw=0.6)
    axes.add_patch(Arc((0, 0), 1.1, 1.1, theta1=45, theta2=90, lw=0.8))
    axes.text(0.16, 0.62, r"contact_angle", **CODE)
    axes.add_patch(Wedge((excess * np.sin(angle), -excess * np.cos(angle)), 0.03, 0, 360, fc="black"))
    end = (
        excess * np.sin(angle) - radius * np.sin(np.radians(60)),
        -excess * np.cos(angle) + radius * np.cos(np.radians(60)),
    )
    axes.annotate("", xy=end, xytext=(excess * np.sin(angle), -excess * np.cos(angle)), arrowprops={"arrowstyle": "->"})
    axes.text(-0.95, 0.12, "groove_radius", **CODE)
    axes.text(0, 2.0, "nut", ha="center", va="center")
    axes.text(0, -2.0, "screw", ha="center", va="center")
    edge = excess * np.cos(angle) - radius * np.cos(np.radians(78))
    phi = np.radians(70)
    on_arc = (excess * np.sin(angle) - radius * np.sin(phi), radius * np.cos(phi) - excess * np.cos(angle))
    for name, at, text in (("land", (1.75, edge), (1.75, -0.8)), ("arc", on_arc, (-1.75, 0.75))):
        arrow = {"arrowstyle": "->", "lw": 0.7}
        axes.annotate(name, xy=at, xytext=text, fontsize=8, ha="center", va="center", arrowprops=arrow)
    axes.set_xlim(-2.4, 2.4)
    axes.set_ylim(-2.2, 2.2)
    figure.savefig(path)
    plt.close(figure)


def flange(path: Path) -> None:
    """Upper half of a section through a flanged nut on a hollow screw: lengths of flange, bore, lands and 3D stretch."""
    figure, axes = _axes((10, 5.2))
    axes.add_patch(Rectangle((0, 5), 150, 14, fc=STEEL, ec="black", lw=0.8))
    axes.add_patch(Rectangle((40, 21), 76, 17, fc=NUT, ec="black", lw=0.8))
    axes.add_patch(Rectangle((40, 38), 14, 16, fc=NUT, ec="black", lw=0.8))
    for z in range(62, 112, 10):
        axes.add_patch(Circle((z, 20), 3, fc=BALL, ec="black", lw=0.7))
    for y in np.arange(45, 53, 2.0):
        axes.plot([54, 57], [y, y + 2.0], color="black", lw=0.7)
    axes.plot([-8, 160], [0, 0], color="black", lw=0.6, ls=(0, (12, 3, 2, 3)))
    for z in (14, 142):
        axes.plot([z, z], [3, 25], color="grey", lw=0.8, ls="--")
    _across(axes, (40, 60), (54, 60), "nut.flange.thickness")
    _across(axes, (54, 42), (84, 42), "nut.flange.centring")
    axes.plot([84, 84], [38, 44], color="black", lw=0.5)
    _across(axes, (116, 27), (142, 27), "solid.shaft")
    _upright(axes, (30, 0), (30, 54), "", 30)
    axes.text(28, 44, "nut.flange.diameter / 2", ha="right", va="center", **CODE)
    axes.plot([30, 40], [54, 54], color="black", lw=0.5)
    axes.annotate(
        "nut.flange.seat\n(two diameters of the ring\nby which it is held)",
        xy=(57, 51),
        xytext=(70, 54),
        **CODE,
        arrowprops={"arrowstyle": "->", "lw": 0.7},
    )
    _upright(axes, (66, 0), (66, 5), "screw.bore / 2", 2.5)
    _upright(axes, (120, 0), (120, 21), "solid.nut_inner_diameter / 2", 11)
    axes.plot([116, 122], [21, 21], color="black", lw=0.5)
    axes.text(-8, -4, "axis; the dashed lines bound the 3D stretch of the shaft", fontsize=9)
    axes.set_xlim(-22, 184)
    axes.set_ylim(-8, 66)
    figure.savefig(path)
    plt.close(figure)


def refined(path: Path) -> None:
    """The four parts of the refined model's compliance, in the order of its equation: which body each loads, and where."""
    figure, axes = _axes((10, 2.9))
    load = {"arrowstyle": "-|>", "lw": 1.4, "color": "#c0392b", "shrinkA": 0, "shrinkB": 0}

    def push(x: float, y: float) -> None:
        axes.annotate("", xy=(x, y), xytext=(x, y + 6), arrowprops=load)

    def under(x: float, name: str, text: str) -> None:
        axes.text(x, -17, name, ha="center", fontsize=11, weight="bold")
        axes.text(x, -20, text, ha="center", va="top", fontsize=9)

    def beam(x: float, y: float, half: float) -> None:
        axes.plot([x - half, x + half], [y, y], color="black", lw=2.2)
        for z in (-0.6, 0.0, 0.6):
            axes.plot(x + z * half, y, "o", color="black", ms=3.5)

    beam(14, 0, 14)
    for z in (-8.4, 0.0, 8.4):
        push(14 + z, 0.8)
    under(14, "beam", "whole shaft, sections\nof the grooved body")
    axes.text(34, 0, "+", fontsize=20, ha="center", va="center")
    axes.add_patch(Rectangle((40, -10), 26, 20, fc=STEEL, ec="black", lw=0.8))
    axes.plot([38, 68], [0, 0], color="black", lw=0.6, ls=(0, (12, 3, 2, 3)))
    axes.add_patch(Rectangle((49, 9.3), 8, 1.4, fc="#c0392b", ec="none"))
    push(53, 10.7)
    axes.text(71, 0, "\u2212", fontsize=20, ha="center", va="center")
    beam(82, 0, 7)
    push(82, 0.8)
    under(60, "body of revolution, less its own beam", "smooth, a wide patch,\nharmonics around the axis")
    axes.text(94, 0, "+", fontsize=20, ha="center", va="center")
    z = np.linspace(-13, 13, 200)
    groove = 10 - np.where(np.abs(z) < 7, np.sqrt(np.maximum(0.0, 64 - (np.abs(z) + 1) ** 2)), 0.0)
    axes.fill(np.r_[112 + z, 125, 99], np.r_[groove, -10, -10], fc=STEEL, ec="black", lw=0.8)
    axes.add_patch(Circle((112, 10), 6.7, fc=BALL, ec="black", lw=0.7))
    angle = np.radians(np.linspace(215, 235, 20))
    axes.plot(112 + 7.2 * np.cos(angle), 10 + 7.2 * np.sin(angle), color="#c0392b", lw=3)
    under(112, "flank, less the smooth body", "the true groove,\na narrow patch")
    axes.text(132, 0, "\u2212", fontsize=20, ha="center", va="center")
    axes.add_patch(Wedge((150, 4), 14, 180, 360, fc=STEEL, ec="none"))
    axes.plot([136, 164], [4, 4], color="black", lw=0.8)
    axes.plot([147, 153], [4, 4], color="#c0392b", lw=3)
    push(150, 4.7)
    under(150, "half space", "Hertz's law holds it already")
    axes.set_xlim(-2, 168)
    axes.set_ylim(-29, 20)
    figure.savefig(path)
    plt.close(figure)
