"""Pictures of meshes and fields: faces and pieces of cells, records that do not fit, files, and their section's helpers."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import LOCAL, cube, face_nodes
from tests.report_samples import paged

from rollbench.comparison.sections import pressures
from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.fields import ContactPressure
from rollbench.reports import field3d, figures, html, offscreen
from rollbench.reports.records import FieldPicture, MeshPart, PressureMap, PressurePanel, Report, Section

PNG_START = b"\x89PNG\r\n\x1a\n"
KINDS = ("P1", "P2", "Q2")


def volume(points, cells):
    """Of tetrahedra, or of hexahedra as six tetrahedra about a diagonal."""
    if cells.shape[1] == 8:
        ring = (1, 2, 3, 7, 4, 5)
        cells = np.concatenate([cells[:, [0, ring[k], ring[(k + 1) % 6], 6]] for k in range(6)])
    x = points[cells]
    return float(np.abs(np.linalg.det(x[:, 1:] - x[:, :1])).sum() / 6.0)


def area(points, triangles):
    x = points[triangles]
    return float(np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum() / 2.0)


def picture(kind="Q2", **changes):
    points, cells = cube(kind, 2)
    plain = FieldPicture(
        "cube", "A cube", (MeshPart(points, cells, kind),), (1.0, 0.4, 0.3), (0.0, 0.0, 1.0), (0.5, 0.5, 0.5), 2.0
    )
    return replace(plain, **changes)


def with_values(kind="P2"):
    part = picture(kind).parts[0]
    return replace(part, values=1.0 + part.points[:, 0], outline=True)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "P1"])
def test_midpoints_lie_between_the_corners_before_and_after(kind):
    x = LOCAL[kind]
    corners = 4 if kind == "Q2" else 3
    for face in field3d.faces(np.arange(len(x))[None], kind):
        for k in range(corners):
            assert np.allclose(x[face[corners + k]], 0.5 * (x[face[k]] + x[face[(k + 1) % corners]]))


@pytest.mark.parametrize("kind", KINDS)
class TestCells:
    def test_faces_are_those_of_the_elements(self, kind):
        faces = field3d.faces(np.arange(len(LOCAL[kind]))[None], kind)
        assert [sorted(f) for f in faces.tolist()] == [sorted(f) for f in face_nodes(kind).tolist()]

    def test_skin_and_pieces_of_a_cube(self, kind):
        points, cells = cube(kind, 2)
        _, where, triangles, edges = field3d.drawn_faces(points, field3d.skin(cells, kind), kind)
        assert area(where, triangles) == pytest.approx(6.0)
        assert np.ptp(where[edges], axis=1).max() <= 0.5 + 1e-12
        small, new, values = field3d.drawn_cells(MeshPart(points, cells, kind, points[:, 0] ** 2), cells)
        assert volume(small, new) == pytest.approx(1.0)
        assert values == pytest.approx(small[:, 0] ** 2) or kind == "P1"


class TestRefusals:
    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"kind": "Q9"}, "kind is 'Q9'"),
            ({"kind": "P2"}, "P2 cells need 10 nodes"),
            ({"points": np.zeros((3, 2))}, r"shape \(n, 3\)"),
            ({"points": np.full((125, 3), np.nan)}, "must be finite"),
            ({"points": np.zeros((3, 3))}, "nodes that are not there"),
            ({"values": np.zeros(3)}, "125 points"),
        ],
    )
    def test_part(self, tmp_path, changes, words):
        bad = picture()
        bad = replace(bad, parts=(replace(bad.parts[0], **changes),))
        with pytest.raises(ValueError, match=words):
            field3d.draw_field(bad, tmp_path / "a.png")

    @pytest.mark.parametrize("changes", [{"parts": ()}, {"section": True}])
    def test_picture(self, tmp_path, changes):
        with pytest.raises(ValueError, match="exactly one cut"):
            field3d.draw_field(picture(**changes), tmp_path / "a.png")

    @pytest.mark.parametrize(
        ("code", "stderr", "words"),
        [(-11, b"", "no off-screen OpenGL"), (1, b"ImportError: no vtk", "cannot be loaded"), (1, b"boom", "boom")],
    )
    def test_says_why_it_cannot_be_drawn(self, tmp_path, monkeypatch, code, stderr, words):
        answer = subprocess.CompletedProcess([], code, b"", stderr)
        monkeypatch.setattr(offscreen.subprocess, "run", lambda *_, **__: answer)
        with pytest.raises(RuntimeError, match=words):
            field3d.draw_field(picture(), tmp_path / "a.png")

    def test_a_picture_that_cannot_be_drawn_is_left_out_of_the_page(self, tmp_path, monkeypatch):
        def fail(_, path):
            path.write_bytes(b"half")
            raise RuntimeError("3D picture: no off-screen OpenGL on this machine")

        monkeypatch.setattr(field3d, "draw_field", fail)
        said = []
        html.write(Report("t", "s", {}, paged(Section("one", "One", (picture(),)))), tmp_path / "r", said.append)
        page = (tmp_path / "r" / "one.html").read_text(encoding="utf-8")
        assert "This picture was left out. 3D picture: no off-screen OpenGL" in page
        assert not (tmp_path / "r/figures/cube.png").exists()
        assert any("left out" in line for line in said)


@pytest.mark.parametrize(
    "drawn",
    [
        picture("P2", scale_bar=0.2, cuts=(((0.5, 0.5, 0.5), (1.0, 0.0, 0.0)),)),
        picture(
            parts=(with_values(), replace(with_values("Q2"), edges=False)),
            section=True,
            log=True,
            label="stress [MPa]",
            cuts=(((0.45, 0.5, 0.5), (1.0, 0.2, 0.0)),),
            words=(((0.5, 0.5, 0.5), "here"),),
        ),
    ],
    ids=["mesh", "section"],
)
def test_a_file_is_written(tmp_path, drawn):
    try:
        field3d.draw_field(drawn, tmp_path / "a.png")
    except RuntimeError as error:
        if "OpenGL" in str(error):
            pytest.skip(str(error))
        raise
    data = (tmp_path / "a.png").read_bytes()
    assert data.startswith(PNG_START)
    assert 5_000 < len(data) < 600_000


def contact():
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-6e-4, 6e-4, 13), np.linspace(-2e-4, 2e-4, 13), indexing="ij"))
    closed = hertz(225.0, 19e-3, 2.4e-3, 210e9, 0.28)
    areas = np.full(169, 1e-4 * 4e-4 / 12.0)
    return ContactPressure(x, y, closed.pressure(x, y), np.zeros(2), 225.0, closed, areas, (13, 13))


class TestPressureMap:
    def map_of(self, count=2):
        panels = tuple(pressures.panel_of(f"ball {k} <1>", contact()) for k in range(count))
        return PressureMap("map", "Pressures", panels, "across / mm", "along / mm", "pressure / MPa")

    def test_same_data_same_small_file_with_its_numbers(self):
        svg = figures.draw_map(self.map_of())
        assert svg == figures.draw_map(self.map_of())
        assert len(svg) < 200_000
        assert "pole pressure by Hertz" in svg
        assert "ball 1 &lt;1&gt;" in svg
        assert 'id="fig-map-' in svg

    @pytest.mark.parametrize("count", [0, 5])
    def test_refuses_wrong_number_of_panels(self, count):
        with pytest.raises(ValueError, match="1 to 4"):
            figures.draw_map(self.map_of(count))

    def test_refuses_other_numbers_of_nodes(self):
        panel = PressurePanel("one", np.zeros(4), np.zeros(4), np.zeros(3), (0.0, 0.0, 1.0, 1.0))
        with pytest.raises(ValueError, match="as many"):
            figures.draw_map(replace(self.map_of(), panels=(panel,)))

    def test_profiles_lie_on_hertz(self):
        panels = pressures.profiles({"ball 1, SL": contact()}).panels
        assert len(panels) == 2
        for panel in panels:
            nodes, closed = panel.series
            assert np.interp(nodes.x, closed.x, closed.y) == pytest.approx(nodes.y, abs=60.0)

    def test_table_quotes_both_pressures(self):
        (row,) = pressures.pressure_table({"case": {"ball 1, SL": contact()}}).rows
        assert row["ratio"] == pytest.approx(1.0)
        assert row["hertz"] == pytest.approx(row["ours"])
        assert row["cells"] == pytest.approx(2.0 * contact().hertz.semi_y / (4e-4 / 12.0))
