"""One scene as one self-contained HTML page with the hashes of what it rests on, and the check of these hashes.

The page carries the scene file, the results as JSON and a manifest: SHA-256 of both, of the page and of every file that was
used. `read_page` takes them out again. The hashes tell what changed; they prove nothing of who wrote the page.
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
from rollbench.reports.cells import format_cell, typeset
from rollbench.reports.content import Figure, LoadedScrew, Section, Sketch, Table, View
from rollbench.reports.manifest import all_texts, parsed, sha256
from rollbench.reports.pages import inline, templates
from rollbench.reports.view import MARKER, fragment

#: Blocks of the page that hold data, by id.
BLOCKS = ("manifest", "scene", "results")


@dataclass(frozen=True)
class ScenePage:
    """Title and what stands under it; the answer in one sentence; answers (label, sentence); picture or None; parts;
    provenance (label, text); text of the scene file; results, JSON-ready; files: SHA-256 of what else was used, by name;
    warnings: what is said where the page is written, and stands among its assumptions; view: what can be turned on it,
    whose results are those of the page; links: files that labels of answers lead to; table: of answers, below them."""

    title: str
    subtitle: str
    verdict: str
    answers: Sequence[tuple[str, str]]
    picture: LoadedScrew | None
    parts: Sequence[Section]
    provenance: Mapping[str, str]
    scene_text: str
    results: Mapping[str, Any]
    files: Mapping[str, str] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    view: View | None = None
    links: Mapping[str, str] = field(default_factory=dict)
    table: Table | None = None


def manifest_of(page: ScenePage, html: str) -> dict[str, Any]:
    """What the page rests on: provenance, and SHA-256 of the scene, the results, every file, and of the page itself,
    ``html``, without a manifest."""
    return {
        "provenance": dict(page.provenance),
        "scene": sha256(page.scene_text),
        "results": results_hash(page.results),
        "files": dict(page.files),
        "page": sha256(html),
    }


def results_hash(results: Mapping[str, Any]) -> str:
    """SHA-256 of results, whatever the order of their keys."""
    return sha256(json.dumps(results, sort_keys=True))


def render(page: ScenePage) -> str:
    """The page as HTML. Raises ValueError for a figure whose data are inconsistent."""
    environment = templates()
    environment.finalize = lambda value: value if isinstance(value, Markup) else typeset(str(value))
    environment.globals["cell"] = format_cell
    environment.globals["drawn"] = _drawn
    picture, missing = _picture(page.picture)
    html = environment.get_template("scene.html.j2").render(
        page=page,
        picture=picture,
        missing=missing,
        viewer=Markup("" if page.view is None else fragment(page.view)),
        marker=Markup(MARKER),
        scene_json=_embedded(page.scene_text),
        results_json=_embedded(page.results),
    )
    return html.replace(_block("manifest"), _block("manifest", str(_embedded(manifest_of(page, html)))), 1)


def _block(name: str, content: str = "") -> str:
    return f'<script type="application/json" id="{name}">{content}</script>'


def without_manifest(html: str) -> str:
    """The page as it was when its own hash was taken."""
    pattern = re.escape(_block("manifest", "@")).replace("@", ".*?")
    return re.sub(pattern, lambda _: _block("manifest"), html, count=1, flags=re.DOTALL)


def _embedded(data: Any) -> Markup:
    """JSON for a script block: nothing in it ends the block."""
    text = json.dumps(data, sort_keys=True)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _drawn(item: Figure | Sketch) -> Markup:
    return Markup(inline(sketch.draw(item) if isinstance(item, Sketch) else figures.draw(item)))


def _picture(item: LoadedScrew | None) -> tuple[str, str]:
    """The picture as base64, or why there is none."""
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
    """Manifest, scene text and results of a page. Raises ValueError where one is missing or damaged."""
    out = {}
    for name in BLOCKS:
        found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', html, re.DOTALL)
        if found is None:
            raise ValueError(f"the page has no block {name!r}")
        try:
            out[name] = parsed(found[1])
        except ValueError as error:
            raise ValueError(f"the block {name!r} is damaged: {error}") from None
    manifest, texts = out["manifest"], isinstance(out["scene"], str)
    whole = isinstance(manifest, dict) and all(all_texts(manifest.get(key, {})) for key in ("files", "provenance"))
    if not (whole and texts and isinstance(out["results"], dict)):
        raise ValueError("the manifest is damaged")
    return out
