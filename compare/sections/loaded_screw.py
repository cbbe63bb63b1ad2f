"""The 3D picture of a screw with its balls and the contact forces on them."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.reports.records import LoadedScrew


def loaded_screw(
    scene: Scene, title: tuple[str, str], load: Array, arrows: tuple[Array, Array], caption: str
) -> LoadedScrew:
    """Picture of a scene. title: its name and title; load ``(N, 4)`` [N] colours the balls; arrows: points ``(k, 3)`` [m]
    and forces ``(k, 3)`` [N] of the contacts that carry load."""
    layout, radius = ball_layout(scene), scene.track.pitch_radius
    phi = np.linspace(layout.azimuth.min(), layout.azimuth.max(), 400)
    rise = np.interp(phi, layout.azimuth, layout.z)
    return LoadedScrew(
        name=title[0],
        title=title[1],
        screw_length=scene.screw.length,
        screw_radius=scene.screw.outer_diameter / 2.0,
        nut_position=scene.nut.position,
        nut_length=scene.nut.length,
        nut_radius=scene.nut.outer_diameter / 2.0,
        track_radius=radius,
        ball_radius=float(specimen(scene, layout).ball_radius.max()),
        ball_radii_centres=layout.centre.tolist(),
        ball_loads=[float(x) for x in load.max(axis=1)],
        helix=np.stack([radius * np.cos(phi), radius * np.sin(phi), rise], axis=1).tolist(),
        contact_points=arrows[0].tolist(),
        contact_forces=arrows[1].tolist(),
        groove_radius=scene.screw.groove_radius,
        lead=scene.track.lead,
        caption=caption,
    )
