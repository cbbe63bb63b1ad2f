"""Writes one scene as a self-contained HTML page with hashes of its inputs, and reads these from a page.

The page contains the scene file, the results as JSON and a manifest: SHA-256 of both, of the page and of every file that
was used. `read_page` takes them out again. The hashes show what changed, but not who wrote the page.
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
from rollbench.reports.cells import format_cell, typeset_text
from rollbench.reports.content import Figure, LoadedScrew, Section, Sketch, Table, View
from rollbench.reports.manifest import all_texts, parse_manifest, sha256
from rollbench.reports.pages import inline_svg, load_templates
from rollbench.reports.view import MARKER, view_fragment

#: Blocks of the page that hold data, by id.
BLOCKS = ("manifest", "scene", "results")


@dataclass(frozen=True)
class ScenePage:
    """Contents of the HTML page of a scene."""

    #: Title.
    title: str
    #: Line below the title.
    subtitle: str
    #: Main result in one sentence.
    verdict: str
    #: Results as (label, sentence).
    answers: Sequence[tuple[str, str]]
    #: Picture, if any.
    picture: LoadedScrew | None
    #: Sections.
    parts: Sequence[Section]
    #: Facts on its origin as (label, text).
    provenance: Mapping[str, str]
    #: Text of the scene file.
    scene_text: str
    #: JSON of the results.
    results: Mapping[str, Any]
    #: SHA-256 of further files that were used, by name.
    files: Mapping[str, str] = field(default_factory=dict)
    #: Warnings, printed when the page is written and listed among its assumptions.
    warnings: Sequence[str] = ()
    #: 3D view on the page, with the same results.
    view: View | None = None
    #: Files to which labels of results link.
    links: Mapping[str, str] = field(default_factory=dict)
    table: Table | None = None


def page_manifest(page: ScenePage, html: str) -> dict[str, Any]:
    """Return the manifest of a page: provenance, SHA-256 of scene, results, files, and page without manifest."""
    return {
        "provenance": dict(page.provenance),
        "scene": sha256(page.scene_text),
        "results": results_hash(page.results),
        "files": dict(page.files),
        "page": sha256(html),
    }


def results_hash(results: Mapping[str, Any]) -> str:
    """Return the SHA-256 of results, independent of the order of their keys."""
    return sha256(json.dumps(results, sort_keys=True))


def render_page(page: ScenePage) -> str:
    """Return the page as HTML; ValueError if the data of a figure are inconsistent."""
    environment = load_templates()
    environment.finalize = lambda value: value if isinstance(value, Markup) else typeset_text(str(value))
    environment.globals["cell"] = format_cell
    environment.globals["drawn"] = _draw_item
    picture, missing = _embed_picture(page.picture)
    html = environment.get_template("scene.html.j2").render(
        page=page,
        picture=picture,
        missing=missing,
        viewer=Markup("" if page.view is None else view_fragment(page.view)),
        marker=Markup(MARKER),
        scene_json=_embedded_json(page.scene_text),
        results_json=_embedded_json(page.results),
    )
    return html.replace(_data_block("manifest"), _data_block("manifest", str(_embedded_json(page_manifest(page, html)))), 1)


def _data_block(name: str, content: str = "") -> str:
    """Return a script element that holds JSON under an id."""
    return f'<script type="application/json" id="{name}">{content}</script>'


def without_manifest(html: str) -> str:
    """Return the HTML with an empty manifest, as it was when its hash was computed."""
    pattern = re.escape(_data_block("manifest", "@")).replace("@", ".*?")
    return re.sub(pattern, lambda _: _data_block("manifest"), html, count=1, flags=re.DOTALL)


def _embedded_json(data: Any) -> Markup:
    """Return data as JSON for a script element, escaped so that nothing in it ends the element."""
    text = json.dumps(data, sort_keys=True)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _draw_item(item: Figure | Sketch) -> Markup:
    """Return a figure or sketch as an SVG element of the page."""
    return Markup(inline_svg(sketch.draw_sketch(item) if isinstance(item, Sketch) else figures.draw_figure(item)))


def _embed_picture(item: LoadedScrew | None) -> tuple[str, str]:
    """Return the 3D picture as base64 and an empty text, or an empty text and why it is missing."""
    if item is None:
        return "", ""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        try:
            scene3d.draw_loaded_screw(item, path)
        except (RuntimeError, ImportError) as error:
            return "", str(error)
        return base64.b64encode(path.read_bytes()).decode("ascii"), ""


def read_page(html: str) -> dict[str, Any]:
    """Return manifest, scene text and results of a page; ValueError if one is missing or damaged."""
    out = {}
    for name in BLOCKS:
        found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', html, re.DOTALL)
        if found is None:
            raise ValueError(f"the page has no block {name!r}")
        try:
            out[name] = parse_manifest(found[1])
        except ValueError as error:
            raise ValueError(f"the block {name!r} is damaged: {error}") from None
    manifest, texts = out["manifest"], isinstance(out["scene"], str)
    whole = isinstance(manifest, dict) and all(all_texts(manifest.get(key, {})) for key in ("files", "provenance"))
    if not (whole and texts and isinstance(out["results"], dict)):
        raise ValueError("the manifest is damaged")
    return out
