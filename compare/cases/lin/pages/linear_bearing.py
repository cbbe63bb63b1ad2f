"""Figures 3.11, 3.12 and 3.16 and Figure G.1 of Lin's thesis: friction over the spin pole, and two balls that approach."""

from __future__ import annotations

from math import degrees

import numpy as np

from rollbench.compare.cases.lin.evidence import rotary_linear
from rollbench.compare.cases.lin.evidence.rotary_linear import K_F, LINEAR, MULTIPLE, THETA, VERTICAL, YIELD
from rollbench.compare.printed import printed_value
from rollbench.compare.sections.curves import scale_to_python_floats as floats
from rollbench.lowfi.friction.contact.laws import contacts_from_values, friction_forces
from rollbench.lowfi.friction.linear.bearing import CONTACTS
from rollbench.lowfi.friction.linear.chain import solve_pair_of_linear_balls
from rollbench.reports.content import Figure, Panel, Series

#: Conformities (groove radius over ball diameter) of the curves. Lin draws four without naming them, but for 0.52.
CONFORMITIES = (0.515, 0.52, 0.55, 0.6)
#: Gap between the two balls at the start, over the ball's radius (text before Lin's Figure 3.16).
GAP = 0.1


def friction_over_spin_pole_figure() -> Figure:
    """Draw Lin's Figure 3.11: friction force and moment of a contact over the place of its spin pole."""
    pressure, panels = 1e6 * MULTIPLE * YIELD, []
    for title, reach in (("full range", 5.0), ("near the centre", 0.5)):
        place = np.linspace(-reach, reach, 81)
        curves = []
        for conformity in CONFORMITIES:
            ratio, a_over_r = rotary_linear.contact_ellipse_ratios(conformity, pressure)
            contact = contacts_from_values(np.ones(place.size), ratio, 1.0, 1.0)
            found = friction_forces(contact, np.stack([np.zeros(place.size), place, np.ones(place.size)], axis=1))
            curves.append(Series(f"force, conformity {conformity:g}", floats(place), floats(found.force[:, 1]), "line"))
            moment = floats(-found.moment, a_over_r)
            curves.append(Series(f"moment, conformity {conformity:g}", floats(place), moment, "line", pale=True))
        if reach < 1.0:
            curves.append(Series(f"Lin's line, slope {K_F:g}", floats(place), floats(-K_F * place), "line", bold=True))
        panels.append(Panel(title, "place of the spin pole c / a", "force / μF, moment / μF R_B", curves))
    caption = (
        "a: major semi-axis; F: contact load; R_B: ball radius. Pale: moments, at the pressure of "
        f"{MULTIPLE * YIELD:.0f} MPa, up to which Lin's appendix G goes. Lin does not name his other conformities."
    )
    title = "Linear bearing (Lin, Figure 3.11): friction force and moment over the place of the spin pole"
    return Figure("friction-spin-pole", title, panels, caption)


def spin_pole_of_pair_figure() -> Figure:
    """Draw what Lin's Figure 3.12 sketches: the angle between contact and spin pole, as seen from the ball's centre."""
    rho = np.linspace(-0.6, 0.6, 13)
    angle = np.empty((rho.size, 2, len(CONTACTS)))
    for k, side in enumerate(rho):
        motion = solve_pair_of_linear_balls(LINEAR, THETA, float(side), VERTICAL).apart.contact_motions
        angle[k] = np.degrees(np.abs(motion[..., 1] / motion[..., 2]) / LINEAR.ball_radius)
    limit = printed_value("lin-G", "eta")
    panels = []
    for ball in range(2):
        curves = [Series(name, floats(rho), floats(angle[:, ball, i]), "line") for i, name in enumerate(CONTACTS)]
        curves.append(Series("Lin's limit of the linear range", [-0.6, 0.6], [limit, limit], "line", bold=True))
        panels.append(Panel(f"ball {ball + 1}", "side force ratio ρ of ball 1", "|Δη| / deg", curves, include_zero=True))
    caption = (
        f"Angle deviation θ = {degrees(THETA):g}°, balls too far apart to touch. Largest angle {angle.max():.2f}°. B, T: "
        "bottom, top; L, R: left, right. Lin's figure is a sketch of this angle."
    )
    title = "Linear bearing (Lin, Figure 3.12): angle between contact and spin pole"
    return Figure("friction-spin-pole-angle", title, panels, caption)


def gap_between_balls_figure() -> Figure:
    """Draw Lin's Figure 3.16: the gap between two balls over the carriage's travel, in the designs (a) and (b)."""
    start, panels = GAP * LINEAR.ball_radius, []
    for case, words in (("a", "(a) contact angles deviate on the rail only"), ("b", "(b) carriage mated to the rail")):
        deviations = {
            "numerical model": rotary_linear.solve_linear_ball_pair(mated=case == "b").velocity_deviation,
            "Lin's formula": rotary_linear.velocity_deviations_by_formula(mated=case == "b"),
        }
        closing = {name: 0.5 * float(one[0] - one[1]) for name, one in deviations.items()}
        travel = np.linspace(0.0, 0.08, 81)
        curves = [
            Series(name, floats(travel, 1e3), floats(np.maximum(start - rate * travel, 0.0), 1e6), "line")
            for name, rate in closing.items()
        ]
        panels.append(Panel(words, "travel of the carriage / mm", "gap between the balls / µm", curves, include_zero=True))
    caption = (
        f"Gap at the start {GAP:g} R_B (Lin). In design (a) the first ball is faster and closes it; then both press on "
        "each other. In design (b) the contacts of each diagonal stay opposite, and the gap stays. The scale of "
        "Lin's abscissa is not in the text."
    )
    title = "Linear bearing (Lin, Figure 3.16): two balls that approach, and a design that avoids it"
    return Figure("friction-gap", title, panels, caption)


def semi_axis_figure() -> Figure:
    """Draw Lin's Figure G.1: major semi-axis over ball radius, over the largest Hertz pressure."""
    pressure = np.linspace(0.0, MULTIPLE * YIELD, 33)
    curves = []
    for conformity in CONFORMITIES:
        ratios = [rotary_linear.contact_ellipse_ratios(conformity, 1e6 * float(p))[1] for p in pressure]
        curves.append(Series(f"conformity {conformity:g}", floats(pressure), [float(x) for x in ratios], "line"))
    last = [printed_value("lin-G", "pressure")], [printed_value("lin-G", "a_over_R")]
    curves.append(Series("printed, conformity 0.52", *last, "markers"))
    panel = Panel("ball in a straight groove", "largest Hertz pressure / MPa", "a / R_B", curves, include_zero=True)
    title = "Linear bearing (Lin, Figure G.1): major semi-axis of the contact over the ball's radius"
    return Figure("friction-semi-axis", title, [panel])
