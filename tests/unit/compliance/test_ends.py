"""Stretch of shaft loaded at its end: Saint-Venant's closed forms at the contacts, nothing at the end beyond the beam."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance.between import contact_frames
from rollbench.lowfi.compliance.bodies import end_response
from rollbench.lowfi.compliance.parts import LADDER, REFINED, geometry_only, smooth_body
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.section import tube_section

CASE = catalogue.scene("lin-case1")
LAYOUT = ball_layout(CASE)
SMOOTH = replace(REFINED, flank=False)
TUBE = smooth_body(geometry_only(CASE), True, REFINED)
PLAIN = tube_section(2.0 * TUBE.outer, 2.0 * TUBE.bore, TUBE.material)


@pytest.fixture(scope="module")
def response():
    """The smooth stretch loaded at its end; not made where tests are only collected, as every worker does."""
    return end_response(CASE, LAYOUT, SMOOTH)


def by_closed_form(width: float) -> np.ndarray:
    """Motions (4 N, 6) of the contacts on a solid bar by tension and bending at its end; patches of a width spread along z
    add the mean of the deflection's curvature over them."""
    x, axes = contact_frames(CASE, LAYOUT, True)
    nu = TUBE.material.poissons_ratio
    one = np.zeros(len(x))
    tension = -nu / PLAIN.EA * np.stack([x[:, 0], x[:, 1], one], axis=1)
    across = 0.5 * nu * (x[:, 0] ** 2 - x[:, 1] ** 2)
    both, spread = nu * x[:, 0] * x[:, 1], 0.5 * width**2
    about_y = np.stack([across + spread, both, one], axis=1) / PLAIN.EI
    about_x = np.stack([-both, across - spread, one], axis=1) / PLAIN.EI
    moved = [np.einsum("cak,ck->ca", axes, u).ravel() for u in (tension, about_x, about_y)]
    return np.stack(moved, axis=1)


def test_contacts_move_as_saint_venant_says(response):
    found, wanted = response.contacts[:, 2:5], by_closed_form(TUBE.width)
    inside = np.abs(np.repeat(contact_frames(CASE, LAYOUT, True)[0][:, 2], 2) - CASE.nut.position) < 10e-3
    for k in range(3):
        size = np.abs(wanted[:, k]).max()
        assert np.abs(found - wanted)[inside, k].max() < 1e-2 * size
        assert np.abs(found - wanted)[:, k].max() < 4e-2 * size
    assert np.abs(found - by_closed_form(0.0))[inside, 2].max() > 5e-2 * np.abs(wanted[:, 2]).max()


def test_torsion_leaves_round_sections_as_they_are(response):
    x, _ = contact_frames(CASE, LAYOUT, True)
    turn = float(np.hypot(x[:, 0], x[:, 1]).max() * 0.05 / PLAIN.GJ)
    assert np.abs(response.contacts[:, 5]).max() < 1e-3 * turn


def test_end_moves_as_the_beams(response):
    """Beyond the beam there is only what a uniform shear at the ends does: some per cent of the beam's own shear."""
    length = response.high - TUBE.ends[0]
    beam = np.array([length / PLAIN.kGA] * 2 + [length / PLAIN.EA] + [length / PLAIN.EI] * 2 + [length / PLAIN.GJ])
    assert np.abs(np.diag(response.end)[2:] / beam[2:]).max() < 1e-8
    assert np.abs(np.diag(response.end)[:2] / beam[:2]).max() < 0.04
    assert np.array_equal(response.end, response.end.T)


def test_bodies_that_are_no_stretch_of_a_shaft_have_none():
    """A beam alone, a ring on a stiff shaft."""
    ring = catalogue.scene("bearing-9")
    held = replace(ring, solid=replace(ring.solid, screw_held="bore"))
    assert end_response(CASE, LAYOUT, LADDER["lin"]) is None
    assert end_response(held, ball_layout(held), REFINED) is None
