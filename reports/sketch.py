"""Draw a screw or bearing from the side, as SVG: shaft, nut in section, balls, supports, loads and main dimensions.

The nut and the shaft near it are drawn to scale. The ends of a long shaft are shortened, with a break line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions_of_3d_parts
from rollbench.reports.content import Sketch

#: Colours of the drawing. A web page replaces those in `figures.THEME` by colours of the page; the others remain.
INK, FRAME, SHAFT, NUT, BALL, FORCE = "#222222", "#8a8f98", "#c9ced6", "#9fb4d3", "#f3c969", "#D55E00"
#: Width of the drawing, height of the thickest part, length of a shortened shaft end, and font size [pixels].
WIDTH, TALL, END, TEXT = 520.0, 130.0, 90.0, 12.0
#: Length of shaft drawn to scale beyond each face of the nut, in nut lengths, and smallest margin at each side [pixels].
BEYOND, SIDE = 0.25, 44.0

#: Factors for kilonewtons and micrometres in texts.
KILO, MICRO = 1e3, 1e-6


@dataclass(frozen=True)
class _DrawingScale:
    """Scale of the drawing: converts axial positions and radii [m] to pixels."""

    #: Axial position at which the part drawn to scale begins [m].
    to_scale_start: float
    #: Axial position at which the part drawn to scale ends [m].
    to_scale_end: float
    #: Length of the shaft [m].
    shaft_length: float
    #: Abscissa of the axial position ``to_scale_start`` in the drawing [pixels].
    start_abscissa: float
    #: Pixels per metre.
    pixels_per_metre: float
    #: Ordinate of the shaft's axis in the drawing [pixels].
    axis_ordinate: float

    def abscissa(self, station: float) -> float:
        """Return the abscissa in the drawing [pixels] of the axial position ``station`` [m] on the shaft."""
        if station < self.to_scale_start:
            share = (self.to_scale_start - station) / max(self.to_scale_start, 1e-12)
            return self.start_abscissa - share * self._drawn_end_length(self.to_scale_start)
        right = self.start_abscissa + self.pixels_per_metre * (self.to_scale_end - self.to_scale_start)
        if station > self.to_scale_end:
            beyond = self.shaft_length - self.to_scale_end
            return right + (station - self.to_scale_end) / max(beyond, 1e-12) * self._drawn_end_length(beyond)
        return self.start_abscissa + self.pixels_per_metre * (station - self.to_scale_start)

    def ordinate(self, radius: float) -> float:
        """Return the ordinate in the drawing [pixels] of a point at the height ``radius`` [m] above the shaft's axis."""
        return self.axis_ordinate - self.pixels_per_metre * radius

    def _drawn_end_length(self, length: float) -> float:
        """Return the length [pixels] with which a shaft end of the length ``length`` [m] is drawn, at most `END`."""
        return min(self.pixels_per_metre * length, END)

    def is_end_shortened(self, length: float) -> bool:
        """Return whether a shaft end of the length ``length`` [m] is drawn shortened, with a break line."""
        return self.pixels_per_metre * length > END


def draw_sketch(sketch: Sketch) -> str:
    """Return the sketch of a screw or bearing as an SVG document; identical input gives an identical document."""
    scene = sketch.scene
    scale = _drawing_scale(scene)
    below = scale.axis_ordinate + TALL / 2.0 + 26.0
    parts = [*_draw_shaft(scene, scale), *_draw_nut(scene, scale), *_draw_balls(scene, scale)]
    parts += _draw_supports_and_loads(scene, scale, below)
    height = below + 12.0 + 2.6 * TEXT
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:.0f} {height:.0f}" width="{WIDTH:.0f}" '
        f'height="{height:.0f}" role="img" aria-label="{escape(sketch.title)}" font-size="{TEXT}" '
        'font-family="Helvetica, Arial, sans-serif">'
    )
    return "\n".join([head, *parts, "</svg>"]) + "\n"


def _drawing_scale(scene: Scene) -> _DrawingScale:
    """Return the scale at which a screw or bearing fits into the drawing."""
    low, high = nut_face_positions(scene)
    room = BEYOND * (high - low)
    ends = max(low - room, 0.0), min(high + room, scene.screw.length)
    tallest = max(scene.nut.outer_diameter, scene.nut.flange.diameter if scene.nut.flange else 0.0)
    free = WIDTH - 2.0 * (SIDE + END)
    per_metre = min(free / (ends[1] - ends[0]), TALL / tallest)
    left = (WIDTH - per_metre * (ends[1] - ends[0])) / 2.0
    return _DrawingScale(*ends, scene.screw.length, left, per_metre, 2.2 * TEXT + 30.0 + TALL / 2.0)


def nut_face_positions(scene: Scene) -> tuple[float, float]:
    """Return the axial positions of the nut's left and right face [m]."""
    return scene.nut.position - scene.nut.length / 2.0, scene.nut.position + scene.nut.length / 2.0


def _draw_shaft(scene: Scene, scale: _DrawingScale) -> Iterator[str]:
    """Yield the SVG elements of the shaft: outline, bore, break lines of shortened ends, and axis.

    ``scale``: conversion from positions on the shaft to pixels.
    """
    radius = scene.screw.outer_diameter / 2.0
    x0, x1 = scale.abscissa(0.0), scale.abscissa(scene.screw.length)
    yield _rectangle(x0, scale.ordinate(radius), x1 - x0, 2.0 * (scale.axis_ordinate - scale.ordinate(radius)), SHAFT)
    for end, length, at in (
        (-1.0, scale.to_scale_start, scale.start_abscissa - END / 2.0),
        (1.0, scale.shaft_length - scale.to_scale_end, scale.abscissa(scale.to_scale_end) + END / 2.0),
    ):
        if scale.is_end_shortened(length):
            top, foot = scale.ordinate(radius) - 4.0, scale.ordinate(-radius) + 4.0
            wave = f"q {4 * end} {(foot - top) / 4:.1f} 0 {(foot - top) / 2:.1f} t 0 {(foot - top) / 2:.1f}"
            yield f'<path d="M {at - 2.5:.1f} {top:.1f} {wave}" fill="none" stroke="#ffffff" stroke-width="5"/>'
            for side in (-5.0, 0.0):
                yield f'<path d="M {at + side:.1f} {top:.1f} {wave}" fill="none" stroke="{INK}" stroke-width="0.8"/>'
    if scene.screw.bore:
        for y in (scale.ordinate(-scene.screw.bore / 2.0), scale.ordinate(scene.screw.bore / 2.0)):
            yield _line_element(x0, y, x1, y, dash="4 3")
    yield _line_element(x0 - 10.0, scale.axis_ordinate, x1 + 10.0, scale.axis_ordinate, FRAME, "9 3 2 3")
    yield _text_element(x1 + 13.0, scale.axis_ordinate + 4.0, "z", "start")


def _draw_nut(scene: Scene, scale: _DrawingScale) -> Iterator[str]:
    """Yield the SVG elements of the nut in section: body, flange, hatching where it is fixed, and its dimension line.

    ``scale``: conversion from positions on the shaft to pixels.
    """
    ends = nut_face_positions(scene)
    low, high = map(scale.abscissa, ends)
    held, outside = _fixed_nut_faces(scene, *ends)
    inner, outer = scene.track.pitch_radius, scene.nut.outer_diameter / 2.0
    thick = scale.pixels_per_metre * (outer - inner)
    for side in (-1.0, 1.0):
        yield _rectangle(low, min(scale.ordinate(side * outer), scale.ordinate(side * inner)), high - low, thick, NUT)
        if scene.nut.flange:
            rim = scene.nut.flange.diameter / 2.0
            start, end = sorted(scene.nut.flange.stations(*ends)[:2])
            wide = scale.pixels_per_metre * (rim - outer)
            top = scale.ordinate(rim) if side > 0 else scale.ordinate(-outer)
            yield _rectangle(scale.abscissa(start), top, scale.abscissa(end) - scale.abscissa(start), wide, NUT)
        for z, r0, r1 in held:
            x, y0, y1 = scale.abscissa(z), scale.ordinate(side * r0), scale.ordinate(side * r1)
            yield from _hatch_lines(x, min(y0, y1), max(y0, y1), -1.0 if z <= scene.nut.position else 1.0)
        if outside:
            y = scale.ordinate(side * outer)
            for k in range(int((high - low) // 7.0)):
                yield _line_element(low + 7.0 * k, y, low + 7.0 * k + 5.0, y - side * 5.0)
    top, around = scale.axis_ordinate - TALL / 2.0 - 12.0, "nut" if scene.track.lead else "outer ring"
    yield from _dimension_line(low, high, top, f"{around} {1e3 * scene.nut.length:.4g} mm, Ø {1e3 * 2 * outer:.4g}")


def _hatch_lines(x: float, top: float, foot: float, side: float) -> Iterator[str]:
    """Yield the SVG elements of the hatching beside a fixed vertical edge.

    ``x``: abscissa of the edge. ``top``, ``foot``: ordinates of its ends; all in pixels. ``side``: -1 for hatching on the
    left of the edge, 1 on the right.
    """
    for k in range(int((foot - top) // 5.0) + 1):
        yield _line_element(x, top + 5.0 * k, x + 5.0 * side, top + 5.0 * k + 5.0)


def _draw_balls(scene: Scene, scale: _DrawingScale) -> Iterator[str]:
    """Yield the SVG elements of the balls, seen from the side; balls behind the shaft's axis are pale.

    ``scale``: conversion from positions on the shaft to pixels.
    """
    for height, front, z in sorted(ball_layout(scene).centre.tolist(), key=lambda centre: centre[1]):
        radius = scale.pixels_per_metre * scene.balls.radius
        pale = "" if front >= 0.0 else ' opacity="0.45"'
        where = f'cx="{scale.abscissa(z):.1f}" cy="{scale.ordinate(height):.1f}" r="{radius:.1f}"'
        yield f'<circle {where} fill="{BALL}" stroke="{INK}" stroke-width="0.6"{pale}/>'


def _draw_supports_and_loads(scene: Scene, scale: _DrawingScale, below: float) -> Iterator[str]:
    """Yield the SVG elements of supports and loads with their labels, and of the shaft's dimension line.

    ``scale``: conversion from positions on the shaft to pixels. ``below``: ordinate below all parts [pixels], from which
    the dimension line is placed. Supports and loads that the nut would hide are drawn beside it.
    """
    edge = scale.ordinate(-scene.screw.outer_diameter / 2.0)
    x0, x1 = scale.abscissa(0.0), scale.abscissa(scene.screw.length)
    low, high = nut_face_positions(scene)
    for support in scene.supports:
        x, hidden = scale.abscissa(support.at), low <= support.at <= high
        if not hidden:
            yield f'<path d="M {x:.1f} {edge:.1f} l -7 12 h 14 z" fill="{FRAME}" stroke="{INK}" stroke-width="0.8"/>'
        for n, word in enumerate(_support_labels(support.fixed)):
            down = n * 1.2 * TEXT
            if hidden:
                yield _text_element(
                    scale.abscissa(high) + 30.0, scale.axis_ordinate + 4.0 + down, f"shaft: {word}", "start"
                )
            else:
                yield _text_element(_text_abscissa_within_drawing(x, word), edge + 25.0 + down, word)
    above = scale.ordinate(scene.screw.outer_diameter / 2.0)
    count: dict[float, int] = {}
    for load in scene.loads:
        at, words, (lateral, _, axial) = load.at, _load_label(load.force, load.moment), load.force
        n = count[at] = count.get(at, -1) + 1
        hidden = low <= at <= high
        x, top = (scale.abscissa(low) - 22.0, scale.axis_ordinate) if hidden else (scale.abscissa(at), above)
        if axial:
            tail = x - 34.0 if axial > 0.0 else x + 34.0
            yield _line_element(tail, scale.axis_ordinate, x, scale.axis_ordinate, FORCE, width=2.2)
            yield _arrow_head(x, scale.axis_ordinate, 1.0 if axial > 0.0 else -1.0, 0.0)
        if lateral:
            yield _line_element(x, top - 34.0, x, top, FORCE, width=2.2)
            yield _arrow_head(x, top, 0.0, 1.0) if lateral < 0.0 else _arrow_head(x, top - 34.0, 0.0, -1.0)
        if hidden:
            yield _text_element(x - 40.0, scale.axis_ordinate + 4.0 + n * 1.2 * TEXT, words, "end", FORCE)
        else:
            up = 40.0 if lateral else 10.0
            yield _text_element(_text_abscissa_within_drawing(x, words), above - up - n * 1.2 * TEXT, words, colour=FORCE)
    shaft = "screw" if scene.track.lead else "inner ring"
    words = f"{shaft} {1e3 * scene.screw.length:.4g} mm, Ø {1e3 * scene.screw.outer_diameter:.4g}"
    yield from _dimension_line(x0, x1, below + 2.0 * TEXT, words)


def _fixed_nut_faces(scene: Scene, low: float, high: float) -> tuple[list[tuple[float, float, float]], bool]:
    """Return the annular faces at which the nut is fixed, and whether its outer surface is fixed instead.

    Each face is given by its axial position, inner and outer radius [m]. ``low``, ``high``: axial positions [m] of the left
    and right face of the nut.
    """
    solid = dimensions_of_3d_parts(scene)
    if solid.nut_held.startswith("outer surface"):
        return [], True
    if scene.nut.flange and solid.nut_held.startswith("flange face"):
        return [(scene.nut.flange.stations(low, high)[1], *solid.held_radii)], False
    faces = {"left": [low], "right": [high], "both": [low, high]}[solid.nut_held.split()[0]]
    return [(face, *solid.held_radii) for face in faces], False


def _support_labels(prescribed_freedoms: tuple[tuple[str, float], ...]) -> Iterator[str]:
    """Yield the labels of a support: its fixed degrees of freedom, and its prescribed displacements and rotations.

    ``prescribed_freedoms``: pairs of degree of freedom (ux to rz) and prescribed value [m, rad]; 0 means fixed.
    """
    held = " ".join(freedom for freedom, value in prescribed_freedoms if value == 0.0)
    if held:
        yield f"fixes {held}"
    for freedom, value in prescribed_freedoms:
        if value:
            turned = freedom.startswith("r")
            yield f"{freedom} = {1e3 * value:.4g} mrad" if turned else f"{freedom} = {value / MICRO:.4g} µm"


def _load_label(force: tuple[float, float, float], moment: tuple[float, float, float]) -> str:
    """Return the label of a load, with those components of its force [N] and moment [N m] that are not zero."""
    forces = [
        f"F{axis} {value / KILO:.4g} kN" if abs(value) >= KILO else f"F{axis} {value:.4g} N"
        for axis, value in zip("xyz", force, strict=True)
        if value
    ]
    return ", ".join([*forces, *(f"M{axis} {value:.4g} N m" for axis, value in zip("xyz", moment, strict=True) if value)])


def _text_abscissa_within_drawing(x: float, words: str) -> float:
    """Return the abscissa [pixels] next to ``x`` at which the centred text ``words`` lies completely within the drawing."""
    half = 0.27 * TEXT * len(words)
    return min(max(x, half + 2.0), WIDTH - half - 2.0)


def _dimension_line(x0: float, x1: float, y: float, words: str) -> Iterator[str]:
    """Yield the SVG elements of a horizontal dimension line from x0 to x1 with a text above it; coordinates in pixels."""
    yield _line_element(x0, y, x1, y, FRAME)
    for x in (x0, x1):
        yield _line_element(x, y - 4.0, x, y + 4.0, FRAME)
    yield _text_element((x0 + x1) / 2.0, y - 5.0, words)


def _rectangle(x: float, y: float, width: float, height: float, fill: str) -> str:
    """Return the SVG element of a filled rectangle; lengths in pixels."""
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f'<rect {place} fill="{fill}" stroke="{INK}" stroke-width="0.8"/>'


def _line_element(x0: float, y0: float, x1: float, y1: float, colour: str = INK, dash: str = "", width: float = 0.8) -> str:
    """Return the SVG element of a straight line; coordinates and width in pixels."""
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    place = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return f'<line {place} stroke="{colour}" stroke-width="{width:g}"{dashes}/>'


def _arrow_head(x: float, y: float, along: float, down: float) -> str:
    """Return the SVG element of an arrow head with its tip at (x, y) [pixels], pointing in the direction (along, down)."""
    points: Sequence[tuple[float, float]] = (
        (x, y),
        (x - 9.0 * along - 4.0 * down, y - 9.0 * down - 4.0 * along),
        (x - 9.0 * along + 4.0 * down, y - 9.0 * down + 4.0 * along),
    )
    return f'<polygon points="{" ".join(f"{a:.1f},{b:.1f}" for a, b in points)}" fill="{FORCE}"/>'


def _text_element(x: float, y: float, words: str, anchor: str = "middle", colour: str = INK) -> str:
    """Return the SVG element of a text at the point (x, y) [pixels]; anchor: ``"start"``, ``"middle"`` or ``"end"``."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(words)}</text>'
