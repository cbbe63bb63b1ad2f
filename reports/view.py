"""Make a web page that shows a solved scene as a 3D model, which the reader can rotate; the page needs no network.

The page contains the script `viewer/view.js` and the part of three.js that it uses, which `.ci/three` extracts. The script
draws surfaces, balls and forces, and takes every value that it displays from the results, stored in the page as JSON.
"""

from __future__ import annotations

import base64
import json
from html import escape
from importlib import resources
from itertools import pairwise
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports import scene3d
from rollbench.reports.content import LoadCaseView, NutOrBearingView, SceneView

#: HTML element that marks a page as written by this program, which may therefore replace the page or its folder.
MARKER = '<meta name="generator" content="rollbench">'
#: Step of the surface grids in the 3D viewer, as a multiple of the step in a picture.
COARSE = 3.0
#: Length of shaft drawn on each side of the centre of a nut [nut lengths], and of a bearing row [ring widths].
NUT, RING = 0.8, 0.5
#: Millimetres per metre.
MM = 1e3


def viewer_page_html(view: SceneView, back_link: str = "") -> str:
    """Return the HTML page that shows a solved scene in 3D.

    ``view``: data of the scene. ``back_link``: target of a link back to the report; empty: no link.
    """
    link = f' <a href="{escape(back_link)}">back</a>' if back_link else ""
    filled = {
        "TITLE": escape(view.title),
        "SUBTITLE": escape(view.subtitle) + link,
        "MARKER": MARKER,
        "RESULTS": json_script_element("results", view.results),
        "VIEWER": viewer_elements_html(view),
    }
    html = _viewer_file_text("page.html")
    for name, text in filled.items():
        html = html.replace(f"{{{{{name}}}}}", text)
    return html


def viewer_elements_html(view: SceneView) -> str:
    """Return the 3D viewer of a solved scene as HTML elements, to be inserted into a page.

    The page must contain the results as JSON in the script element ``results``.
    """
    surfaces: dict[str, int] = {}
    cases = [_load_case_data(case, surfaces) for case in view.load_cases]
    data = {"cases": cases, "surfaces": [json.loads(text) for text in surfaces], "flanks": SIDES}
    data |= {"sight": scene3d.direction_to_viewer().tolist(), "up": scene3d.viewer_and_upward_vectors()[1].tolist()}
    scripts = "".join(f"<script>{_viewer_file_text(name)}</script>" for name in ("three.min.js", "view.js"))
    style, page = _viewer_file_text("view.css"), _viewer_file_text("view.html")
    return f"<style>{style}</style>{page}{json_script_element('view-data', data)}{scripts}"


def json_script_element(name: str, data: Any) -> str:
    """Return an HTML script element that contains data as JSON.

    ``name``: HTML identifier of the element. The characters <, > and & are escaped, so that no text can end the element.
    """
    text = json.dumps(data, sort_keys=True, separators=(",", ":"))
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return f'<script type="application/json" id="{name}">{text}</script>'


def _viewer_file_text(name: str) -> str:
    """Return the text of a file of the 3D viewer, from the folder ``viewer`` of this package."""
    return resources.files("rollbench.reports").joinpath("viewer", name).read_text(encoding="utf-8")


def _load_case_data(case: LoadCaseView, surfaces: dict[str, int]) -> dict[str, Any]:
    """Return the data of one load case for the script of the 3D viewer.

    ``surfaces``: number of each surface of earlier load cases, by the JSON text of the surface. New surfaces are added to
    this mapping; a surface that is equal in several load cases is stored only once.
    """
    drawn = [s for one in case.nuts_and_bearings for s in _surfaces_of_nut_or_bearing(one, case.shaft is not None)]
    if case.shaft is not None:
        drawn += _shaft_parts_between_nuts(case.shaft)
    numbers = [surfaces.setdefault(json.dumps(one), len(surfaces)) for one in drawn]
    return {
        "name": case.name,
        "surfaces": numbers,
        "sets": [_viewer_data_of_nut_or_bearing(one) for one in case.nuts_and_bearings],
    }


def _surfaces_of_nut_or_bearing(one: NutOrBearingView, shaft_is_shared: bool) -> list[dict[str, Any]]:
    """Return the surfaces of one nut or bearing row, and of the part of the shaft in it, for the 3D viewer.

    ``shaft_is_shared``: whether the shaft carries several nuts or bearing rows; the parts of the shaft between them are
    then drawn by `_shaft_parts_between_nuts`.
    """
    if isinstance(one.parts, RollerRow):
        return [_cone_surface(one.parts, one.position, _apex_direction(one.thrust))]
    reach = RING if shaft_is_shared and not one.parts.track.lead else NUT
    found = scene3d.screw_and_nut_surfaces_by_colour(one.parts, COARSE, reach)
    return [_packed_surface(grid, tint) for tint, grids in found.items() for grid in grids]


def _packed_surface(grid: scene3d.Grid, tint: str) -> dict[str, Any]:
    """Return a surface for the 3D viewer, with its coordinates [mm] coded as 16-bit integers between their extremes.

    ``grid``: radius [m], azimuth [rad] and axial position [m] of its points. ``tint``: colour of the surface.
    """
    points = MM * np.stack(scene3d.cylindrical_to_cartesian(grid), axis=-1)
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    step = np.maximum(high - low, 1e-9) / 65535.0
    whole = np.rint((points - low) / step).astype("<u2")
    text = base64.b64encode(whole.tobytes()).decode("ascii")
    return {"tint": tint, "rows": len(points), "low": low.tolist(), "step": step.tolist(), "points": text}


def _shaft_parts_between_nuts(shaft: Assembly) -> list[dict[str, Any]]:
    """Return the parts of a shaft between its nuts and bearings, for the 3D viewer.

    Each part is a body of revolution, given by its outline of radius and axial position [mm].
    """
    on_shaft = [(s, s.parts) for s in shaft.sets if isinstance(s.parts, Scene) and s.carrier is None]
    under = [_shaft_range_drawn_with_nut(s, parts, shaft.screw.length) for s, parts in on_shaft]
    ranges = [(0.0, shaft.screw.length), *under, *((s.start, s.end) for s in shaft.segments)]
    found = []
    for low, high in pairwise(sorted({z for ends in ranges for z in ends})):
        middle = 0.5 * (low + high)
        if any(start < middle < end for start, end in under):
            continue
        size = next((s.diameter for s in shaft.segments if s.start <= middle <= s.end), shaft.screw.outer_diameter)
        radius, z0, z1 = MM * size / 2.0, MM * low, MM * high
        found.append({"tint": scene3d.STEEL, "outline": [[0.0, z0], [radius, z0], [radius, z1], [0.0, z1]]})
    return found


def _shaft_range_drawn_with_nut(rolling_set: RollingSet, parts: Scene, length: float) -> tuple[float, float]:
    """Return the axial positions [m] between which the shaft is drawn together with a nut or bearing row.

    ``rolling_set``: the nut or bearing row. ``parts``: its geometry. ``length``: length of the shaft [m].
    """
    half = (NUT if parts.track.lead else RING) * parts.nut.length
    return max(0.0, rolling_set.position - half), min(length, rolling_set.position + half)


def _viewer_data_of_nut_or_bearing(one: NutOrBearingView) -> dict[str, Any]:
    """Return the data of one nut or bearing row for the 3D viewer; lengths are in mm.

    Reductions of the clearance at a contact by geometric errors (of ball, shaft groove and outer groove) are in um.
    """
    head = {"name": one.name, "kind": one.kind, "expected": one.expected}
    if isinstance(one.parts, RollerRow):
        return head | _viewer_data_of_rollers(one.parts, one.position, _apex_direction(one.thrust))
    out = head | {
        "centre": [0.0, 0.0, MM * one.position],
        "size": MM * max(one.parts.nut.outer_diameter, one.parts.nut.length),
        "radius": MM * scene3d.drawn_ball_radius(one.parts),
        "places": (MM * ball_layout(one.parts).centre).round(4).tolist(),
    }
    if one.points is not None and one.forces is not None:
        out |= {"points": _rounded(MM * one.points), "forces": _rounded(one.forces)}
    if one.reference is not None:
        label, *rows = one.reference
        out["reference"] = {"label": label, **dict(zip(("load", "uncertainty", "error"), map(_rounded, rows), strict=True))}
    if one.closer is not None and one.closer.size and np.ptp(one.closer, axis=0).max() > 1e-12:  # else flat lines
        out["closer"] = _rounded(1e6 * one.closer)
    return out


def _apex_direction(thrust: str) -> float:
    """Return the direction along z in which the apex of tapered rollers lies: 1 if they carry thrust in +z, else -1.

    ``thrust``: direction of the axial load that the row can carry, "+z" or "-z".
    """
    return 1.0 if thrust == "+z" else -1.0


def _cone_surface(row: RollerRow, position: float, apex_direction: float) -> dict[str, Any]:
    """Return the surface of the cone (inner ring) of a tapered roller row, without ribs, for the 3D viewer.

    ``position``: axial position of the row [m]. ``apex_direction``: direction along z in which the apex lies, 1 or -1.
    """
    reach, angle = 0.5 * row.diameter / np.sin(row.roller_angle), row.cup_angle - 2.0 * row.roller_angle
    apex = position + apex_direction * reach * np.cos(row.cup_angle)
    ends = [float(reach + x) for x in (-0.5 * row.length, 0.5 * row.length)]
    (r0, z0), (r1, z1) = ((MM * x * np.sin(angle), MM * (apex - apex_direction * x * np.cos(angle))) for x in ends)
    return {"tint": scene3d.STEEL, "outline": [[0.0, z0], [r0, z0], [r1, z1], [0.0, z1]]}


def _viewer_data_of_rollers(row: RollerRow, position: float, apex_direction: float) -> dict[str, Any]:
    """Return the positions [mm] and axes of all rollers of a row, and the outline of one roller [mm], for the 3D viewer.

    ``position``: axial position of the row [m]. ``apex_direction``: direction along z in which the apex of the rollers
    lies, 1 or -1.
    """
    reach = 0.5 * row.diameter / np.sin(row.roller_angle)  # from the apex to the middle of the contact line with the cup
    azimuth = row.phase + 2.0 * np.pi * np.arange(row.count) / row.count
    tilt = row.cup_angle - row.roller_angle
    axis = np.stack(
        [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), 0.0 * azimuth - apex_direction * np.cos(tilt)],
        axis=1,
    )
    middle, half = reach * np.cos(row.roller_angle), 0.5 * row.length
    places = np.array([0.0, 0.0, position + apex_direction * reach * np.cos(row.cup_angle)]) + middle * axis
    ends = [(MM * (middle + x) * float(np.tan(row.roller_angle)), MM * x) for x in (-half, half)]
    outline = [(0.0, ends[0][1]), *ends, (0.0, ends[1][1])]
    size = 2.0 * np.hypot(*places[0, :2]) + 2.0 * row.diameter
    return {
        "centre": [0.0, 0.0, MM * position],
        "size": float(MM * size),
        "places": (MM * places).round(4).tolist(),
        "axes": axis.round(6).tolist(),
        "outline": outline,
    }


def _rounded(values: Array) -> Any:
    """Return an array as nested lists of numbers with six significant digits; nan and infinity become None."""

    def rounded(value: Any) -> Any:
        if isinstance(value, list):
            return [rounded(x) for x in value]
        return float(f"{value:.6g}") if np.isfinite(value) else None

    return rounded(np.asarray(values).tolist())
