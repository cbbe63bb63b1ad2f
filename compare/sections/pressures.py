"""Contact pressures of the 3D reference against Hertz: maps, curves along lines of nodes, and a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rollbench.reports.content import Figure, Panel, PressurePanel, Quantity, Row, Series, Table

if TYPE_CHECKING:
    from rollbench.hifi.fields import ContactPressure

MM, MPA = 1e3, 1e-6


def panel_of(name: str, found: ContactPressure) -> PressurePanel:
    """Map of one contact."""
    h = found.hertz
    return PressurePanel(
        name,
        MM * found.across,
        MM * found.along,
        MPA * found.pressure,
        (MM * found.centre[0], MM * found.centre[1], MM * h.semi_x, MM * h.semi_y),
        f"{found.load:.1f} N; largest {MPA * found.pressure.max():.0f} MPa, pole pressure by Hertz "
        f"{MPA * h.pole_pressure:.0f} MPa",
    )


def profiles(found: dict[str, ContactPressure]) -> Figure:
    """Pressure along both lines of nodes through the most loaded node, with Hertz's."""
    panels = []
    for name, one in found.items():
        assert one.shape is not None
        grid = np.arange(one.pressure.size).reshape(one.shape)
        i, k = np.unravel_index(int(one.pressure.argmax()), one.shape)
        for title, line, distance, axis in (
            ("across the groove", grid[:, k], one.across, 0),
            ("along the groove", grid[i], one.along, 1),
        ):
            at = np.linspace(distance[line].min(), distance[line].max(), 161)
            other = (one.along if axis == 0 else one.across)[line].mean() - one.centre[1 - axis]
            across, along = (at - one.centre[0], other + 0.0 * at) if axis == 0 else (other + 0.0 * at, at - one.centre[1])
            panels.append(
                Panel(
                    f"{name}, {title}",
                    "distance from the nominal contact / mm",
                    "pressure / MPa",
                    (
                        Series("3D reference, nodes", list(MM * distance[line]), list(MPA * one.pressure[line]), "markers"),
                        Series("Hertz", list(MM * at), list(MPA * one.hertz.pressure(across, along)), "line"),
                    ),
                    zero=True,
                )
            )
    return Figure(
        "pressure-profiles",
        "Contact pressure along lines of nodes",
        tuple(panels),
        "Lines of nodes through the most loaded node of each contact; Hertz's closed form for the same load, centred on "
        "the resultant force.",
    )


def step_along(found: ContactPressure) -> float:
    """Mean distance [m] of the nodes along the groove."""
    assert found.shape is not None
    return float(np.abs(np.diff(found.along.reshape(found.shape), axis=1)).mean())


def pressure_table(groups: dict[str, dict[str, ContactPressure]]) -> Table:
    """Largest pressures, by the 3D reference and by Hertz."""
    rows: list[Row] = [
        {
            Quantity("contact", "Contact", format="s"): f"{scene}, {name}",
            Quantity("load", "Load", "N", ".1f"): x.load,
            Quantity("ours", "Largest pressure, 3D", "MPa", ".0f"): MPA * float(x.pressure.max()),
            Quantity("hertz", "Pole pressure, Hertz", "MPa", ".0f"): MPA * x.hertz.pole_pressure,
            Quantity("ratio", "3D / Hertz", "", ".3f"): float(x.pressure.max() / x.hertz.pole_pressure),
            Quantity("a", "Semi-axis across", "mm", ".3f"): MM * x.hertz.semi_x,
            Quantity("b", "Semi-axis along", "mm", ".3f"): MM * x.hertz.semi_y,
            Quantity("cells", "Nodes across 2b", "", ".1f"): 2.0 * x.hertz.semi_y / step_along(x),
        }
        for scene, found in groups.items()
        for name, x in found.items()
    ]
    return Table.of(
        "pictures-pressure",
        "Largest nodal pressure and Hertz's pole pressure",
        rows,
        (
            "Nodal force over tributary area. Where the pressure is curved, this reads too high at corner nodes "
            "of second-order cells and too low at mid-side nodes, in proportion to the square of the cell size. "
            "The largest value is at a corner, so the ratio exceeds 1. Loads and approaches are not affected."
        ),
    )
