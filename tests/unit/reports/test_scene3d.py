"""The loaded screw in 3D: grooves, starts, colours, and a picture."""

import subprocess

import numpy as np
import pytest
from tests.report_samples import image, screw

from rollbench.compare.scenes import catalogue
from rollbench.meshes.helix import ball_layout
from rollbench.reports import scene3d

ENDS = [
    (-11, b"", "no off-screen OpenGL.*libegl1 libgl1 libxrender1"),
    (1, b"ImportError: libGL.so.1: cannot open", "libGL.so.1.*libgl1"),
    (1, b"Traceback\nTypeError: odd", "TypeError: odd"),
]


class TestScene:
    @pytest.mark.parametrize(("name", "starts"), [("lin-case1", 1), ("unseen-63x20", 2), ("unseen-four-point", 1)])
    def test_grooves_hold_the_balls_and_leave_the_lands(self, name, starts):
        scene = catalogue.scene(name)
        grooves, centres, radius = (
            scene3d._drawn_grooves(scene),
            ball_layout(scene).centre,
            scene3d.drawn_ball_radius(scene),
        )
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
        def run(command, **_):
            return subprocess.CompletedProcess(command, code, b"", stderr)

        monkeypatch.setattr(subprocess, "run", run)
        with pytest.raises(RuntimeError, match=words):
            scene3d.draw_loaded_screw(screw(), tmp_path / "s.png")

    @pytest.mark.slow
    def test_picture_without_a_display(self, tmp_path, monkeypatch):
        """Of a screw; the surfaces of a ring are drawn in test_view3d."""
        monkeypatch.delenv("DISPLAY", raising=False)
        data = image(scene3d.draw_loaded_screw, screw(), tmp_path / "s.png")
        assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == scene3d.SIZE
        assert len(data) > 50_000
