"""The page on which a loaded screw can be turned, in Debian's Chromium: it draws, and says nothing on its console."""

import re
from unittest.mock import Mock

import numpy as np
import pytest
from tests.processes import ran
from tests.report_samples import CHROMIUM, WITH_CHROMIUM, paged, screw

from rollbench.reports import pages, view3d
from rollbench.reports.content import Report, Section
from rollbench.reports.pages import write

#: A ring, whose surfaces come from the same functions as those of pictures (test_scene3d draws a screw).
PICTURE = screw("unseen-four-point", name="bearing", title="A short <screw>", turns=True)


def test_without_the_viewer_the_report_is_whole_and_says_what_installs_it(tmp_path, monkeypatch):
    monkeypatch.setattr(view3d, "write_view", Mock(side_effect=ImportError("No module named 'trimesh'")))
    monkeypatch.setattr(pages.scene3d, "draw_loaded_screw", lambda _, path: path.write_bytes(b""))
    said = []
    page = write(Report("a report", "", {}, paged(Section("cases", "Cases", (PICTURE,)))), tmp_path / "report", said.append)
    assert "view-bearing.html" not in (page.parent / "cases.html").read_text(encoding="utf-8")
    assert any("view-bearing.html left out" in line and "pip install 'rollbench[report]'" in line for line in said)


@pytest.mark.slow
@WITH_CHROMIUM
def test_the_screw_is_drawn_from_a_file_without_network(tmp_path):
    pytest.importorskip("trimesh", reason="the viewer comes with trimesh, which is optional")
    from PIL import Image

    path, shot = tmp_path / "view.html", tmp_path / "view.png"
    view3d.write_view(PICTURE, path, pages.MARKER, "cases.html#figure-bearing")
    html = path.read_text(encoding="utf-8")
    assert [words for words in (pages.MARKER, "A short &lt;screw&gt;", 'id="scale"') if words not in html] == []
    assert not re.search(r'(src|href)="https?:', html)
    look = "for (let y = 0; y < innerHeight; y += 4) for (let x = 0; x < innerWidth; x += 4) found.add(ballAt(x, y));"
    smooth = "scene.traverse(part => { if (part.isMesh) found.add(part.material.flatShading); });"
    tell = f"setTimeout(() => {{ const found = new Set(); {look} {smooth} document.title = [...found].join(); }}, 3000);"
    tried = tmp_path / "tried.html"
    tried.write_text(html.replace("</body>", f"<script>{tell}</script></body>"), encoding="utf-8")
    flags = ["--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    flags += ["--enable-logging=stderr", "--virtual-time-budget=5000", "--window-size=400,300", f"--screenshot={shot}"]
    done = ran(CHROMIUM, *flags, f"--user-data-dir={tmp_path / 'user'}", path.as_uri())
    looking = "--virtual-time-budget=8000", "--window-size=400,300", "--dump-dom", tried.as_uri()
    dumped = ran(CHROMIUM, *flags[:-3], *looking)
    assert (done.returncode, dumped.returncode) == (0, 0), done.stderr + dumped.stderr
    (seen,) = re.findall(r"<title>(.*?)</title>", dumped.stdout)
    assert {"-1", "1", "false"} < set(seen.split(",")), "loads of balls under the pointer, smooth surfaces"
    assert "true" not in seen
    assert not [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    middle = np.asarray(Image.open(shot).convert("RGB"))[100:, 100:300]
    assert len(np.unique(middle.reshape(-1, 3), axis=0)) > 100  # a white page has one colour
