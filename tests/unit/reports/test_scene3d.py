"""The loaded screw in 3D: grooves, starts, colours, and a picture."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest
from tests.report_samples import screw

from rollbench.reports import scene3d
from rollbench.reports.records import LoadedScrew

PNG_START = b"\x89PNG\r\n\x1a\n"


class TestScene:
    def test_groove_holds_the_balls_and_leaves_the_lands(self):
        picture = screw()
        grooves = scene3d._grooves(picture)
        centres = np.asarray(picture.ball_radii_centres)
        phi, z = np.arctan2(centres[:, 1], centres[:, 0]), centres[:, 2]
        under = grooves.surface(phi, z, picture.screw_radius)
        gap = picture.track_radius - picture.ball_radius - under
        assert np.all(gap > 0.0)
        assert np.all(gap < 0.15e-3)
        assert np.all(grooves.surface(phi, z, 0.017) - (picture.track_radius + picture.ball_radius) > 0.0)
        np.testing.assert_allclose(grooves.surface(phi, z + 0.5 * picture.lead, picture.screw_radius), 0.016)

    def test_a_ring_has_one_groove_in_which_its_balls_stand(self):
        ring = screw(lead=0.0)
        phi = np.linspace(-np.pi, np.pi, 9)
        under = scene3d._grooves(ring).surface(phi, np.full_like(phi, ring.nut_position), ring.screw_radius)
        assert np.all(np.abs(ring.track_radius - ring.ball_radius - under) < 0.15e-3)

    def test_starts_are_read_off_the_balls(self):
        one = screw()
        turned = np.asarray(one.ball_radii_centres) * np.array([-1.0, -1.0, 1.0])
        both = np.concatenate([one.ball_radii_centres, turned])
        two = LoadedScrew(**{**vars(one), "ball_radii_centres": both, "ball_loads": [1.0] * len(both)})
        assert len(scene3d._grooves(one).phases) == 1
        grooves = scene3d._grooves(two)
        assert len(grooves.phases) == 2
        azimuth = np.arctan2(both[:, 1], both[:, 0])
        assert np.all(grooves.surface(azimuth, both[:, 2], one.screw_radius) < one.track_radius - one.ball_radius)

    @pytest.mark.parametrize(
        ("low", "high", "expected"),
        [(215.1, 230.1, (215.0, 235.0, 5)), (0.0, 100.0, (0.0, 100.0, 5)), (5.0, 5.0, (4.5, 5.5, 5))],
    )
    def test_colour_scale_has_round_ends(self, low, high, expected):
        first, last, labels = scene3d._round_scale(low, high)
        assert first <= low <= high <= last
        assert (first, last) == pytest.approx(expected[:2])
        assert labels == expected[2]

    @pytest.mark.parametrize(
        ("code", "stderr", "words"),
        [
            (-11, b"", "no off-screen OpenGL.*libegl1 libgl1 libxrender1"),
            (1, b"ImportError: libGL.so.1: cannot open", "libGL.so.1.*libgl1"),
            (1, b"Traceback\nTypeError: odd", "TypeError: odd"),
        ],
    )
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
        try:
            scene3d.draw_loaded_screw(replace(screw(), nut_length=0.02), tmp_path / "s.png")
        except RuntimeError as error:
            if "libgl1" in str(error):
                pytest.skip(str(error))
            raise
        data = (tmp_path / "s.png").read_bytes()
        assert data.startswith(PNG_START)
        assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == scene3d.SIZE
        assert len(data) > 50_000
