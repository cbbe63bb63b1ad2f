"""Write the results of one scene as a self-contained HTML page, and read such a page.

The page contains the scene file, the results as JSON, and a manifest: versions, and the SHA-256 checksum of every file that
was used. `read_page_data` extracts them.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from markupsafe import Markup

from rollbench.reports import figures, scene3d, sketch
from rollbench.reports.cells import format_cell, with_typographic_signs
from rollbench.reports.content import Figure, LoadedScrew, SceneView, Section, Sketch, Table
from rollbench.reports.pages import load_templates, svg_as_html_element
from rollbench.reports.view import MARKER, json_script_element, viewer_elements_html

#: HTML identifiers of the script elements in which a page contains data.
BLOCKS = ("manifest", "scene", "results")


@dataclass(frozen=True)
class ScenePage:
    """Contents of the HTML page with the results of one scene."""

    #: Title of the page.
    title: str
    #: Line below the title.
    subtitle: str
    #: Main result in one sentence.
    verdict: str
    #: Further results, as pairs of label and sentence.
    answers: Sequence[tuple[str, str]]
    #: 3D picture of the loaded screw; None for a scene without one.
    picture: LoadedScrew | None
    #: Sections of the page.
    parts: Sequence[Section]
    #: Facts on the page's origin, such as version and date, by label.
    provenance: Mapping[str, str]
    #: Text of the scene file.
    scene_text: str
    #: Results as written by the command ``solve --json``.
    results: Mapping[str, Any]
    #: SHA-256 checksums of further files that were used, by file name.
    files: Mapping[str, str] = field(default_factory=dict)
    #: Warnings, which are printed when the page is written and are listed among its assumptions.
    warnings: Sequence[str] = ()
    #: Interactive 3D view of the same results; None for a page without one.
    view: SceneView | None = None
    #: Link target of each label of ``answers`` that is a link.
    links: Mapping[str, str] = field(default_factory=dict)
    #: Table below the results.
    table: Table | None = None


def scene_page_html(page: ScenePage) -> str:
    """Return the page of a scene as HTML, with its manifest; raise ValueError if the data of a figure are inconsistent."""
    environment = load_templates()
    environment.finalize = lambda value: value if isinstance(value, Markup) else with_typographic_signs(str(value))
    environment.globals["cell"] = format_cell
    environment.globals["drawn"] = _svg_of_item
    picture, missing = _picture_as_base64(page.picture)
    manifest = {"provenance": dict(page.provenance), "files": dict(page.files)}
    data = {"manifest": manifest, "scene": page.scene_text, "results": page.results}
    return environment.get_template("scene.html.j2").render(
        page=page,
        picture=Markup(picture),  # base64 may hold the letters of a unit
        missing=missing,
        viewer=Markup("" if page.view is None else viewer_elements_html(page.view)),
        marker=Markup(MARKER),
        data={name: Markup(json_script_element(name, data[name])) for name in BLOCKS},
    )


def _svg_of_item(item: Figure | Sketch) -> Markup:
    """Return a figure or sketch as an SVG element for the HTML page."""
    return Markup(svg_as_html_element(sketch.draw_sketch(item) if isinstance(item, Sketch) else figures.draw_figure(item)))


def _picture_as_base64(item: LoadedScrew | None) -> tuple[str, str]:
    """Draw the 3D picture of a page; return the PNG file as base64 text, and the reason if it cannot be drawn.

    One of the two texts is empty. Both are empty if ``item`` is None, for a page without a picture.
    """
    if item is None:
        return "", ""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        try:
            scene3d.draw_loaded_screw(item, path)
        except (RuntimeError, ImportError) as error:
            return "", str(error)
        return base64.b64encode(path.read_bytes()).decode("ascii"), ""


def read_page_data(html: str) -> dict[str, Any]:
    """Return the manifest, the scene file's text and the results from the HTML of a scene's page, by these names.

    Raises ValueError if one of them is missing or damaged.
    """
    out = {}
    for name in BLOCKS:
        found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', html, re.DOTALL)
        if found is None:
            raise ValueError(f"the page lacks the script element {name!r}, which contains its data")
        try:
            out[name] = json.loads(found[1])
        except (ValueError, RecursionError) as error:
            raise ValueError(f"the script element {name!r} of the page contains damaged data ({error})") from None
    manifest = out["manifest"]
    sound = isinstance(manifest, dict) and isinstance(out["scene"], str) and isinstance(out["results"], dict)
    for key in ("files", "provenance"):
        texts = manifest.get(key, {}) if sound else None
        sound = sound and isinstance(texts, dict) and all(isinstance(text, str) for text in texts.values())
    if not sound:
        raise ValueError("the manifest, the scene text or the results in the page are damaged")
    return out
