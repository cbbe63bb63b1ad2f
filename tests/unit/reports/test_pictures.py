"""Pictures of meshes, fields and the loaded screw: grids, grooves, files, and the helpers of their section."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import cube
from tests.report_samples import image, screw

from rollbench.compare.scenes import catalogue
from rollbench.compare.sections import pictures
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.fields import ContactPressure
from rollbench.meshes.helix import ball_layout
from rollbench.reports import content, field3d, scene3d
from rollbench.reports.offscreen import reason_drawing_fails


def picture(kind="Q2", **changes):
    points, cells = cube(kind, 2)
    view = (1.0, 0.4, 0.3), (0.0, 0.0, 1.0), (0.5, 0.5, 0.5), 2.0
    return replace(content.FieldPicture("cube", "A cube", (content.MeshPart(points, cells, kind),), *view), **changes)


def with_values(kind="P2"):
    part = picture(kind).parts[0]
    return replace(part, values=1.0 + part.points[:, 0], outline=True)


@pytest.mark.parametrize("kind", ["P1", "P2", "Q2"])
def test_a_cube_has_its_volume_surface_edges_and_values(kind):
    points, cells = cube(kind, 2)
    grid = field3d.pyvista_grid_of_part(content.MeshPart(points, cells, kind, points[:, 0] ** 2))
    surface = field3d.triangulated_outer_surface(grid)
    assert (grid.volume, surface.area) == pytest.approx((1e9, 6e6))
    assert surface["values"] == pytest.approx((1e-3 * surface.points[:, 0]) ** 2)
    assert np.ptp(grid.extract_all_edges().points.reshape(-1, 3), axis=0) == pytest.approx(1e3)


MIDDLE = (0.5, 0.5, 0.5)
MESH = picture("P2", scale_bar=0.2, cuts=((MIDDLE, (1.0, 0.0, 0.0)),))
CUT = {"section": True, "cuts": (((0.45, 0.5, 0.5), (1.0, 0.2, 0.0)),), "words": ((MIDDLE, "here"),)}
WITH_VALUES = (with_values(), replace(with_values("Q2"), edges=False))
SECTION = picture(parts=WITH_VALUES, log=True, label="stress [MPa]", **CUT)


@pytest.mark.slow
@pytest.mark.parametrize("drawn", [MESH, SECTION], ids=["mesh", "section"])
def test_a_picture_is_drawn_without_its_meshes(tmp_path, drawn):
    def draw(picture, path):
        if reason := reason_drawing_fails():
            raise RuntimeError(reason)
        found = field3d.drawn_picture(picture)
        assert isinstance(found, content.Picture)
        found.png.tofile(path)

    assert 5_000 < len(image(draw, drawn, tmp_path / "a.png")) < 600_000


def contact():
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-6e-4, 6e-4, 13), np.linspace(-2e-4, 2e-4, 13), indexing="ij"))
    closed = solve_hertz(225.0, 19e-3, 2.4e-3, 210e9, 0.28)
    areas = np.full(169, 1e-4 * 4e-4 / 12.0)
    return ContactPressure(x, y, closed.pressure(x, y), np.zeros(2), 225.0, closed, areas, (13, 13))


class TestPressureMap:
    def test_profiles_lie_on_hertz_and_the_table_quotes_both_pressures(self):
        panels = pictures.pressure_profiles_figure({"ball 1, SL": contact()}).panels
        assert len(panels) == 2
        for panel in panels:
            nodes, closed = panel.series
            assert np.interp(nodes.x, closed.x, closed.y) == pytest.approx(nodes.y, abs=60.0)
        (row,) = pictures.largest_pressure_table({"case": {"ball 1, SL": contact()}}).rows
        assert row["pressure_ratio"] == pytest.approx(1.0)
        assert row["hertz_pressure"] == pytest.approx(row["nodal_pressure"])
        assert row["node_spacings"] == pytest.approx(2.0 * contact().hertz_solution.semi_y / (4e-4 / 12.0))


ENDS = [
    (-11, b"", "no off-screen OpenGL.*libegl1 libgl1 libxrender1"),
    (1, b"ImportError: libGL.so.1: cannot open", "libGL.so.1.*libgl1"),
    (1, b"Traceback\nTypeError: odd", "TypeError: odd"),
]


class TestScene:
    @pytest.mark.parametrize(("name", "starts"), [("lin-case1", 1), ("unseen-63x20", 2), ("unseen-four-point", 1)])
    def test_grooves_hold_the_balls_and_leave_the_lands(self, name, starts):
        scene = catalogue.scene(name)
        grooves, radius = scene3d._drawn_grooves(scene), scene3d.drawn_ball_radius(scene)
        centres = ball_layout(scene).centre
        assert len(grooves.start_azimuths) == starts
        phi, z, land = np.arctan2(centres[:, 1], centres[:, 0]), centres[:, 2], scene.screw.outer_diameter / 2.0
        gap = scene.track.pitch_radius - radius - grooves.surface_radius(phi, z, land)
        assert np.all(gap > 0.0)
        assert np.all(gap < 0.15e-3)
        assert np.all(grooves.surface_radius(phi, z, 1.01 * scene.track.pitch_radius) > scene.track.pitch_radius + radius)
        aside = 0.5 * scene.track.lead / starts or 1.5 * radius
        np.testing.assert_allclose(grooves.surface_radius(phi, z + aside, land), land)

    @pytest.mark.parametrize(("code", "stderr", "words"), ENDS)
    def test_says_why_a_picture_cannot_be_drawn(self, tmp_path, monkeypatch, code, stderr, words):
        ended = subprocess.CompletedProcess((), code, b"", stderr)
        monkeypatch.setattr(subprocess, "run", lambda *_, **__: ended)
        with pytest.raises(RuntimeError, match=words):
            scene3d.draw_loaded_screw(screw(), tmp_path / "s.png")

    @pytest.mark.slow
    def test_picture_without_a_display(self, tmp_path, monkeypatch):
        """Of a screw; the surfaces of a ring are drawn in test_view3d."""
        monkeypatch.delenv("DISPLAY", raising=False)
        data = image(scene3d.draw_loaded_screw, screw(), tmp_path / "s.png")
        assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == scene3d.SIZE
        assert len(data) > 50_000
