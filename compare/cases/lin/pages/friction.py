"""Report sections on friction in Lin's thesis.

Sections 3.2 and 3.3: one ball of a rotary bearing, two balls of a linear bearing. Sections 3.4 and 4.3: two balls of a ball
screw, a whole screw over time, torque of a four-point and a double-row bearing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from math import degrees

import numpy as np

from rollbench.compare.cases.lin.evidence import rotary_linear, screw, source_cases
from rollbench.compare.cases.lin.pages import linear_bearing
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_entry, printed_value
from rollbench.compare.sections.curves import scale_to_python_floats as floats
from rollbench.lowfi.friction import bearing as rotary_bearing
from rollbench.lowfi.friction.bearing import SIDES, BearingBallSolution, BearingStates
from rollbench.lowfi.friction.linear.chain import pair_results_over_grid
from rollbench.lowfi.friction.screw.motion import Coupling
from rollbench.lowfi.friction.screw.run import Run, contact_angle_deviation, summarise_screw_run
from rollbench.lowfi.friction.screw.travel import TravelHistory
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Section, Series, Table, Text

# --- tables


def power_balance_table() -> Table:
    """Return the table of the rotary bearing's friction torque, power input and friction losses in cases I to III.

    Each case has three rows: correct; with least dissipation, but the contact loads that Lin computed; and as Lin computed
    it.
    """
    table = Table.from_rows(
        "friction-balance",
        "One ball of a rotary bearing (Lin 3.2): friction torque, power input and losses, for each friction model",
        rotary_linear.power_balance_rows(),
    )
    worst = max(table.rows, key=lambda row: abs(float(row["power_balance"] or 0.0)))
    off = float(error_percent(float(worst["friction_loss"] or 0.0), float(worst["power_input"] or 0.0)))
    note = (
        "Lin computes the torque from the friction losses (3.21); because he interpolates in maps of the friction, it "
        f"differs by {off:+.1f} % from the moment of the friction forces in case {worst['case_of_table_3_2']}. In cases "
        "I and II his sigmoid friction law moves a contact that rests under Coulomb friction: the sum of the losses stays, "
        "their distribution over the contacts changes."
    )
    return replace(table, note=note)


def linear_pair_sensitivity_table() -> Table:
    """Return the table of force between two balls and friction losses in the linear bearing, for each assumption.

    The assumptions concern the contact loads of two balls and the friction between them.
    """
    printed = printed_entry("lin-3.5", "a_force_numerical")
    table = Table.from_rows(
        "friction-sensitivity",
        "Two balls of a linear bearing (Lin 3.3): ball-to-ball force and losses, for each assumption on the contact loads",
        rotary_linear.linear_pair_sensitivity_rows(),
    )
    target = printed.value or 0.0
    forces = [float(force or 0.0) for force in table.columns["ball_force_at", "2"]]
    inside = "lies within" if min(forces) <= target <= max(forces) else "lies outside"
    deviations = " and ".join(f"{printed_entry('lin-3.4', f'a_eps{k}_numerical').number_as_printed} %" for k in (1, 2))
    note = (
        "θ: deviation of the contact angle from nominal. Loads: diagonal (equal at both contacts of each diagonal, as "
        "Lin's text says before (3.54)), balanced (in "
        "equilibrium at the stated contact angles), or elastic (contact angles follow the loads). The printed force of "
        f"{printed.number_as_printed} N {inside} the range of the assumptions, {min(forces):.2f} to "
        f"{max(forces):.2f} N; Table 3.4 prints velocity deviations of {deviations} for the same case."
    )
    return replace(table, note=note)


# --- figures


def rotary_bearing_torque_figure() -> Figure:
    """Draw Lin's Figure 3.7: forces, torque, losses and ball rotation over the ring's radial displacement."""
    u = 1e-6 * np.concatenate([np.linspace(0.0, 4.0, 9), np.linspace(4.05, 6.0, 40), np.linspace(6.2, 10.0, 20)])
    bearing, axial, law = rotary_linear.ROTARY, rotary_linear.AXIAL, rotary_linear.PRINTED_LAW
    true = rotary_bearing.solve_balls_of_bearing(bearing, axial, u)
    printed = [rotary_bearing.solve_ball_by_lin_method(bearing, axial, float(x), law) for x in u]
    good = np.array([s.motion.status == "exact" for s in printed])
    x, label = floats(u, 1e6), "u_y / µm"
    marks = [1e6 * v for v in rotary_linear.CASES.values()]
    laws = (("correct", true, np.ones(u.size, dtype=bool)), ("as printed", printed, good))

    def curves_of_quantity(
        quantity_of_solution: Callable[[BearingBallSolution], float], key: str, factor: float = 1.0
    ) -> tuple[Series, ...]:
        """Return curves of a quantity by the correct and the printed friction law, and markers of the values in Table 3.2.

        ``quantity_of_solution``: function that returns the quantity from a ball's solution; ``key``: first part of the keys
        of the printed values; ``factor``: factor from the quantity's unit to the panel's.
        """
        drawn = []
        for name, found, ok in laws:
            values = np.where(ok, [quantity_of_solution(s) for s in found], np.nan)
            drawn.append(Series(name, x, floats(values, factor), "line", bold=name == "correct"))
        dots = [printed_value("lin-3.2", f"{key}_{case}") for case in rotary_linear.CASES]
        return (*drawn, Series("Table 3.2, cases I to III", marks, dots, "markers"))

    losses = [Series(side, x, [float(s.motion.friction.loss[i]) for s in true], "line") for i, side in enumerate(SIDES)]
    force = curves_of_quantity(lambda s: s.load.force.sum(), "F_sum")
    torque = curves_of_quantity(lambda s: s.inner_ring_torque, "torque", 1e3)
    omega_x = curves_of_quantity(lambda s: s.motion.unknown_velocities[1], "omega_x")
    panels = (
        Panel("sum of contact loads", label, "force / N", force, include_zero=True),
        Panel("friction torque", label, "torque", torque, include_zero=True),
        Panel("friction loss of each contact, correct", label, "loss / W", losses, include_zero=True),
        Panel("angular velocity ω_x of the ball", label, "ω_x / rad/s", omega_x),
    )
    missing = int(np.sum(~good))
    caption = (
        "Once all four contacts of the ball are loaded, the torque rises faster than the force: the lightly loaded "
        "contacts first slide; beyond the bend of the curve, all contacts spin. Case II of Lin's Table 3.2 lies beyond the "
        "bend with exact Hertz constants, and just before it with the constants that Lin prints. The sum of forces that he "
        f"prints for case III is a misprint. Gaps in the curves: Lin's root finding fails at {missing} of {u.size} points."
    )
    title = (
        "Rotary bearing (Lin, Figure 3.7): forces, torque, losses and ball rotation, plotted against the radial "
        "displacement"
    )
    return Figure("friction-torque", title, panels, caption)


def sliding_velocity_panel(case: str, solution: BearingBallSolution, title: str) -> Panel:
    """Draw the sliding velocity [mm/s] along the major axis of each loaded contact of a ball of the rotary bearing.

    ``case``: case of Lin's Table 3.2, "I", "II" or "III"; ``solution``: solved motion of the ball; ``title``: end of the
    panel's title.
    """
    x = np.linspace(-1.0, 1.0, 3)
    curves = []
    for i in np.flatnonzero(solution.load.force > 0.0):
        _, vz, spin = (float(v) for v in solution.motion.contact_motions[i])
        velocity = vz - spin * x * float(solution.problem.contacts.a[i])
        curves.append(Series(SIDES[i], floats(x), floats(velocity, 1e3), "line"))
    return Panel(f"sliding velocity, case {case}, {title}", "x / a", "velocity / mm/s", curves)


def sliding_velocity_figure() -> Figure:
    """Draw Lin's Figure 3.8: sliding velocity along the contacts of the rotary bearing's ball in cases I to III.

    Three panels have correct values, and three have values computed with Lin's faults.
    """
    ways = ("correct", rotary_linear.solve_rotary_ball), ("as printed", rotary_linear.rotary_ball_as_printed)
    panels = [sliding_velocity_panel(case, solve(case), words) for words, solve in ways for case in rotary_linear.CASES]
    caption = (
        "Contacts: I inner, O outer ring; L left, R right. Slope of a curve: spin; offset: sliding. Case I: one contact "
        "rolls, the other spins about its centre. Case II: as printed, IR and OL slide and OR is nearly at rest; "
        "correct: all four contacts of the ball spin, as in case III."
    )
    title = "Rotary bearing (Lin, Figure 3.8): sliding velocity along the major axes of the contacts"
    return Figure("friction-velocity", title, panels, caption, 3)


def panels_over_side_force_ratio(theta: Array, rho: Array, numerical: Array, formula: Array, label: str) -> list[Panel]:
    """Draw a quantity of two balls over the side force ratio: by the numerical model, by Lin's formula, and the difference.

    There is one curve for each deviation ``theta`` of the contact angle from nominal [rad]. ``rho``: side force ratios;
    ``numerical``, ``formula``: the quantity over theta and rho by numerical model and by formula; ``label``: name of the
    quantity with unit.
    """
    x = floats(rho)
    parts = (
        ("numerical model", numerical),
        ("Lin's formula", formula),
        ("difference, formula minus numerical", formula - numerical),
    )
    panels = []
    for title, values in parts:
        curves = [Series(f"θ = {degrees(t):+.0f}°", x, floats(row), "line") for t, row in zip(theta, values, strict=True)]
        panels.append(Panel(title, "side force ratio ρ", label, curves))
    return panels


def figures_over_side_force_ratio() -> tuple[Figure, Figure]:
    """Draw Lin's Figures 3.14 and 3.15 for two balls of a linear bearing, over the ratio of side force to vertical load.

    First: difference of the balls' velocities; second: ball-to-ball force and ratio of friction losses.
    """
    theta, rho = np.radians([-3.0, -1.0, 1.0, 2.0, 3.0]), np.linspace(-0.6, 0.6, 25)
    both = pair_results_over_grid(rotary_linear.LINEAR, theta, rho, rotary_linear.VERTICAL, rotary_linear.K_F)
    (difference, force, ratio), (difference_error, force_error, ratio_error) = both[0], both[1] - both[0]
    labels = "velocity difference ε₁ − ε₂", "ball-to-ball force / N", "loss ratio"
    first_row, *other_rows = (panels_over_side_force_ratio(theta, rho, *of) for of in zip(*both, labels, strict=True))
    short = np.abs(difference_error).max() / np.abs(difference).max()
    first = Figure(
        "friction-difference",
        "Linear bearing (Lin, Figure 3.14): velocity difference of two balls, plotted against side force/vertical load",
        first_row,
        "θ: deviation of the contact angle from nominal; ε₁, ε₂: relative deviations of both balls' velocities "
        "from nominal. The balls approach each other where the curve is above zero. Lin's formula gives velocity "
        f"differences that are too small by up to {short:.0%} of the largest difference.",
        3,
    )
    second = Figure(
        "friction-force",
        "Linear bearing (Lin, Figure 3.15): ball-to-ball force and loss ratio, plotted against side force/vertical load",
        [panel for row in other_rows for panel in row],
        "θ: deviation of the contact angle from nominal. Loss ratio: groove losses without ball-to-ball contact plus loss "
        "between the balls, divided by the former. "
        f"Where the balls approach each other, the force grows up to {force.max():.2f} N and the "
        f"loss ratio up to {100.0 * ratio.max():.1f} % (Lin prints it as an increase of "
        f"{printed_entry('lin-3.3', 'worst_ratio').number_as_printed} %). Lin's formula gives a force that is too small by "
        f"up to {-force_error.min():.2f} N, and a loss ratio that is wrong by up to "
        f"{np.abs(ratio_error).max():.2f}.",
        3,
    )
    return first, second


INTRODUCTION = (
    "Cases I to III of the rotary bearing come out to every printed digit, except one misprinted sum, when "
    "the thesis's faults are repeated: F = 1 with the second fundamental form alone in the Hertz constants, "
    "the sigmoid with k_S = 100 on the magnitude of the spin, and friction interpolated linearly between "
    f"maps. Radial displacements of {', '.join(f'{1000000.0 * u:g}' for u in rotary_linear.CASES.values())} µm and the "
    "maps' step of 0.08 are not printed; they are inferred, and every number of a case follows from one of "
    "them. The correct values use exact Hertz constants and Coulomb friction in closed form.",
    "For the linear bearing Lin, too, uses exact Hertz constants; misprints in his formulas (exponents "
    "of 3.51) are corrected here. The load state behind the printed "
    f"{printed_entry('lin-3.5', 'a_force_numerical').number_as_printed} N stays open; see friction-sensitivity.",
)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on friction in a rotary and in a linear bearing: sections 3.2 and 3.3 of Lin's thesis.

    ``cache``: records which scenes the section uses; ``step``: function that receives a message before each step.
    """
    step("velocities of the rotary bearing")
    cache.record_used_scenes((*source_cases.ROTARY_SCENES.values(), source_cases.LINEAR_PAIR, source_cases.LINEAR_WORST))
    drawn = [sliding_velocity_figure()]
    step("maps of the linear pair")
    drawn += figures_over_side_force_ratio()
    poles = linear_bearing.friction_over_spin_pole_figure(), linear_bearing.spin_pole_of_pair_figure()
    last = linear_bearing.gap_between_balls_figure(), linear_bearing.semi_axis_figure()
    return Section(
        "friction",
        "Lin 3.2 and 3.3: friction and ball motion in a rotary bearing, and in a linear bearing with touching balls",
        (
            *(Text(INTRODUCTION), power_balance_table(), drawn[0], linear_pair_sensitivity_table()),
            *(*poles, drawn[1], drawn[2], *last),
        ),
    )


#: Axial force [N] of Table 3.7.
LOAD = 50.0

#: Load angle [deg] up to which Lin compares torques.
END = 18.0

#: Number of time steps whose contacts are drawn.
DOTS = 66


def simulated_torque_panel(title: str, history: TravelHistory) -> Panel:
    """Draw the friction torque over time in a simulation of the whole screw (Lin's Figure 3.25), under a given ``title``.

    The curves are the torque by ball-to-groove contacts, by ball-to-ball contacts, and their sum. ``history``: motions and
    torques at each time step.
    """
    time = floats(history.nut_angle, 1.0 / history.setting.groove.speed)
    parts = (
        ("ball-to-groove", history.groove_torque),
        ("ball-to-ball", history.ball_torque + history.closing_torque),
        ("sum", history.torque),
    )
    curves = [Series(name, time, floats(v, 1e3), "line", bold=name == "sum") for name, v in parts]
    return Panel(title, "time / s", "torque", curves, include_zero=True)


def angle_deviation_panel(case: Run) -> Panel:
    """Draw the assumed deviation theta of the contact angles from nominal over the azimuth (Lin's Figure 3.23).

    ``case``: inputs of the whole-screw simulation.
    """
    phi = np.linspace(-2.0 * np.pi, 2.0 * np.pi, 201)
    curve = Series("assumed", floats(np.degrees(phi)), floats(np.degrees(contact_angle_deviation(case, phi))), "line")
    return Panel("deviation θ of the contact angles over the loaded turns", "azimuth", "θ / deg", (curve,))


def touching_balls_panels(history: TravelHistory) -> tuple[Panel, Panel]:
    """Draw positions, number and groups of touching neighbouring balls over time (Lin's Figure 3.24).

    ``history``: motions, torques and touching balls at each time step. First panel: positions of touching balls along the
    nut's track; second: numbers of touching pairs and of groups of touching balls.
    """
    setting, angle = history.setting, history.nut_angle
    along = np.degrees(np.mod(history.azimuth - angle[:, None] + np.pi * setting.turns, setting.ring))
    shown_steps = np.arange(angle.size) % max(1, angle.size // DOTS) == 0
    step, ball = np.nonzero(history.presses_on_next & shown_steps[:, None])
    time, x, theta = angle / setting.groove.speed, "time / s", theta_in_words(history)
    dots = Series("touching", floats(time[step]), floats(along[step, ball]), "markers")
    numbers = (
        Series("touching pairs", floats(time), floats(history.presses_on_next.sum(axis=1)), "line"),
        Series("groups of touching balls", floats(time), floats(history.touching_group_counts), "line"),
    )
    return (
        Panel(f"positions of touching balls, {theta}", x, "position along the nut's track / deg", (dots,)),
        Panel(f"numbers of touching pairs and groups, {theta}", x, "number", numbers, include_zero=True),
    )


def theta_in_words(history: TravelHistory) -> str:
    """Return as text the amplitude of the contact angles' deviation theta in a simulation, such as "θ of 3°"."""
    return f"θ of {np.degrees(history.setting.amplitude):g}°"


def screw_simulation_figure() -> Figure:
    """Draw Lin's Figures 3.23 to 3.25: contact-angle deviation, friction torque and touching balls of the whole screw."""
    three, two, open_grooves = screw.simulate_screw(3.0), screw.simulate_screw(2.0), screw.simulate_screw_without_oversize()

    def torque_panel(history: TravelHistory, coupling: str = "") -> Panel:
        """Draw the friction torque over time; ``coupling``: end of the title."""
        oversize = f"oversize {1e6 * history.setting.oversize:g} µm"
        return simulated_torque_panel(f"torque, {theta_in_words(history)}, {oversize}{coupling}", history)

    panels = (
        angle_deviation_panel(three.setting),
        torque_panel(three),
        torque_panel(two),
        *touching_balls_panels(three),
        torque_panel(open_grooves, ", friction coupled"),
    )
    high, low = summarise_screw_run(three), summarise_screw_run(two)
    caption = (
        "θ: deviation of the contact angles; its amplitude and phase, and the oversize of the balls, are assumed. The "
        f"torque by ball-to-ball friction rises to {high.largest_ball_to_groove_ratio:.0%} of that by ball-to-groove "
        f"friction with {theta_in_words(three)} (at a nut angle of {high.nut_angle_of_largest_ratio:.0f}°), and to "
        f"{low.largest_ball_to_groove_ratio:.0%} with {theta_in_words(two)} (at {low.nut_angle_of_largest_ratio:.0f}°); "
        f"then it vanishes, and returns weaker. The touching balls form {high.most_touching_groups} groups. Without "
        f"oversize (last panel) the ball-to-groove torque varies by {screw.groove_torque_variation(open_grooves):.0%} "
        "after the first time step."
    )
    title = "Simulation of a whole ball screw (Lin, Figures 3.23 to 3.25): friction torque and touching balls over time"
    return Figure("friction-run", title, panels, caption, 3)


def panels_over_ball_oversize(case: str, coupling: Coupling) -> list[Panel]:
    """Draw ball-to-ball force and loss increase of two balls over the balls' oversize, a curve for each axial load.

    The loss increase is the rise of the balls' friction loss by ball-to-ball contact.
    ``case``: case of Lin's Table 3.7, "a" or "b"; ``coupling``: which parts the friction displaces, so that it changes the
    contact loads: "none", "ball" or "ball and screw".
    """
    (force, increase), x = screw.pair_results_over_oversize(case, coupling), [1e6 * o for o in screw.OVERSIZE]
    words = "loads without friction" if coupling == "none" else "friction moves the balls"
    panels = []
    for key, values, label in (("force", force, "force / N"), ("increase", 100.0 * increase, "increase / %")):
        curves = [Series(f"{f:g} N", x, floats(values[:, j]), "line", bold=f == LOAD) for j, f in enumerate(screw.AXIAL)]
        printed = printed_value("lin-3.7", f"{key}_{case}")
        curves.append(Series("printed", [x[0], x[-1]], [printed, printed], "line"))
        title = f"{'ball-to-ball force' if key == 'force' else 'friction increase'}, θ = {screw.THETA[case]:g}°, {words}"
        panels.append(Panel(title, "oversize of the ball's radius / µm", label, curves, include_zero=True))
    return panels


def force_without_oversize_over_printed(coupling: Coupling) -> float:
    """Return the ball-to-ball force of two balls without oversize over the printed force: case (a), axial load of 50 N.

    ``coupling``: bodies that friction displaces, as in `screw.pair_results_over_oversize`.
    """
    force, _ = screw.pair_results_over_oversize("a", coupling)
    at = int(np.argmin(np.abs(np.array(screw.OVERSIZE))))
    return float(force[at, screw.AXIAL.index(LOAD)]) / printed_value("lin-3.7", "force_a")


def oversizes_at_printed_value_in_words(key: str) -> str:
    """Return in words the ball oversizes at which a computed quantity, at an axial load of 50 N, equals the printed value.

    The oversizes are given for cases (a) and (b) of Lin's Table 3.7. ``key``: "force" (ball-to-ball force) or "increase"
    (of the friction loss).
    """
    words = []
    for case in ("a", "b"):
        force, increase = screw.pair_results_over_oversize(case, "none")
        values = (force if key == "force" else 100.0 * increase)[:, screw.AXIAL.index(LOAD)]
        crossings = oversizes_at_crossings(values, printed_value("lin-3.7", f"{key}_{case}"))
        found = " and ".join(f"{x:.1f}" for x in crossings) or "no oversize"
        words.append(f"{found} µm in case ({case})")
    return ", ".join(words)


def oversizes_at_crossings(values: Array, level: float) -> list[float]:
    """Return the ball oversizes [µm] at which a quantity equals a given value, by linear interpolation.

    ``values``: the quantity at the oversizes `screw.OVERSIZE`; ``level``: the given value, in the unit of the quantity.
    """
    off, x = values - level, 1e6 * np.array(screw.OVERSIZE)
    k = np.flatnonzero(off[:-1] * off[1:] < 0.0)
    return [float(v) for v in x[k] - off[k] * (x[k + 1] - x[k]) / (off[k + 1] - off[k])]


def force_over_ball_oversize_figure() -> Figure:
    """Draw ball-to-ball force and loss increase of two balls of a screw over the balls' oversize, for several axial loads.

    The loss increase is the rise of the balls' friction loss by ball-to-ball contact.
    """
    sets: tuple[tuple[str, Coupling], ...] = (("a", "none"), ("b", "none"), ("a", "ball"))
    panels = [p for case, coupling in sets for p in panels_over_ball_oversize(case, coupling)]
    caption = (
        "Cases (a) and (b) of Lin's Table 3.7: deviation θ of the contact angle of "
        f"{screw.THETA['a']:g}° and {screw.THETA['b']:g}°. Beyond the bend of a curve, all four contacts of a ball are "
        "loaded: the force grows with the oversize, the relative increase of friction falls. "
        f"Without oversize, at {LOAD:g} N and θ = {screw.THETA['a']:g}°, the force is "
        f"{force_without_oversize_over_printed('ball') / force_without_oversize_over_printed('none'):.1f} times "
        "as large if friction displaces the balls, and then "
        f"{force_without_oversize_over_printed('ball'):.2f} times the printed force. The curves of {LOAD:g} N reach "
        f"the printed forces at an oversize of {oversizes_at_printed_value_in_words('force')}, and the printed increases "
        f"of friction at {oversizes_at_printed_value_in_words('increase')}. Inferred from both, and used in the other "
        f"figures: an oversize of {1000000.0 * source_cases.oversized_pair().oversize:g} µm at "
        f"{source_cases.oversized_pair().force[0]:g} N."
    )
    return Figure(
        "friction-pair-maps",
        "Two touching balls of a ball screw: ball-to-ball force and friction increase, plotted against the balls' oversize",
        panels,
        caption,
        2,
    )


def first_load_angle_beyond_two_contacts(found: BearingStates) -> float:
    """Return the smallest load angle [deg] at which a ball of the bearing has more than two loaded contacts.

    ``found``: friction torque and contacts of the bearing over the load angle.
    """
    return float(np.degrees(screw.ANGLES[np.flatnonzero(found.balls_beyond_two_contacts)[0]]))


def bearing_torque_figure() -> Figure:
    """Draw Lin's Figure 4.7: friction torque of a four-point and a double-row bearing over the load angle."""
    curves = [
        (f"{words}, tilt {how}", screw.torque_over_load_angle(kind, how == "free"))
        for (kind, words), how in product((("4P", "four-point"), ("DR", "double row")), ("free", "held"))
    ]
    x, label = floats(np.degrees(screw.ANGLES)), "load angle / deg"

    def draw_panel(title: str, unit: str, quantity_of_bearing: Callable[[BearingStates], Array]) -> Panel:
        """Draw a quantity of both bearings, with and without tilt of the inner ring, over the load angle.

        ``title``: title of the panel; ``unit``: label of the ordinate; ``quantity_of_bearing``: function that returns the
        quantity of a bearing.
        """
        drawn = [
            Series(name, x, floats(quantity_of_bearing(c)), "line+markers", bold=k == 0)
            for k, (name, c) in enumerate(curves)
        ]
        return Panel(title, label, unit, drawn, include_zero=True)

    title = "friction torque divided by that at load angle 0°"
    ratio = draw_panel(title, "torque ratio", lambda c: c.torque / c.torque[0])
    printed = [printed_value("lin-4.3", "ratio_4p")] * 2
    marked = (*ratio.series, Series("printed ratio of largest to smallest", [0.0, END], printed, "line"))
    title = "balls with more than two loaded contacts"
    panels = (
        draw_panel("friction torque", "torque / N mm", lambda c: 1e3 * c.torque),
        replace(ratio, series=marked),
        draw_panel(title, "number of balls", lambda c: c.balls_beyond_two_contacts.astype(float)),
    )
    free, held, last = curves[0][1], curves[1][1], float(np.degrees(screw.ANGLES[-1]))
    caption = (
        "The torque of the four-point bearing rises with the load angle, steeply once balls have more than two loaded "
        f"contacts: from {first_load_angle_beyond_two_contacts(free):.0f}° on if the inner ring is free to tilt. The "
        f"torque of the double-row bearing stays within {screw.largest_over_smallest_torque(curves[2][1], END):.2f} times "
        f"its smallest value up to {END:g}°. If the inner ring of the four-point bearing cannot tilt, "
        + (
            f"balls have more than two loaded contacts from {first_load_angle_beyond_two_contacts(held):.0f}° on."
            if held.balls_beyond_two_contacts.any()
            else f"no ball has more than two loaded contacts up to {last:.0f}°."
        )
    )
    title = "Four-point and double-row bearing (Lin 4.3.1): friction torque, plotted against the load angle"
    return Figure("friction-load-angle", title, panels, caption, 3)


# --- Lin 3.4 and 4.3: two balls of a ball screw, a whole screw over time, two bearings


# --- tables


def pair_interpretations_table() -> Table:
    """Return the table of ball-to-ball force and loss increase of two balls, for each interpretation of Lin's Table 3.7.

    The loss increase is the rise of the balls' friction loss by ball-to-ball contact.
    """
    printed = {
        case: [printed_entry("lin-3.7", f"{what}_{case}").number_as_printed for what in ("force", "increase")]
        for case in screw.THETA
    }
    note = (
        f"Printed: {', '.join(f'{force} N and {increase} % ({case})' for case, (force, increase) in printed.items())}. "
        "Oversize: of the ball's radius, not stated in the thesis; it was chosen so "
        "that the printed force and the printed increase imply the same contact load."
    )
    title = "Lin, Table 3.7: ball-to-ball force and loss increase, for each interpretation of the text"
    return Table.from_rows("friction-readings", title, screw.contact_load_interpretation_rows(), note)


def _printed_results_of_simulation() -> list[str]:
    """Return as texts the results that Lin prints for the whole-screw simulation, in the order of `PRINTED_OF_RUN`."""
    return [printed_entry("lin-3.4.4", key).number_as_printed for key in screw.PRINTED_OF_RUN]


def simulation_sensitivity_table() -> Table:
    """Return the table of the whole-screw simulation's results under varied assumptions that Lin's thesis does not print.

    The assumptions concern section 3.4.4; in each row, one of them is changed.
    """
    largest, at, none_at = _printed_results_of_simulation()
    note = (
        f"Lin prints {largest} % at {at}°, no contact from {none_at}° on, and four groups. Third row: Lin's root finding, "
        "by which neighbouring balls touch if they are near and would approach without contact (3.77). Rows below: one "
        "assumption changed at a time from theta of 3° (deviation of the contact angles), "
        f"{source_cases.simulation_inputs().force[0]:g} N, {screw.oversize_in_words()} oversize and contact loads without "
        "friction, over one turn of the nut in steps of 7.2°. Empty: contact does not end within that turn."
    )
    title = "Simulation of a whole ball screw (Lin 3.4.4): change of the results with each assumption"
    return Table.from_rows("friction-run-sensitivity", title, screw.simulation_sensitivity_rows(), note)


def simulation_interpretations_table() -> Table:
    """Return the table of the whole-screw simulation's results for each interpretation of section 3.4.4 of Lin's thesis.

    The table also contains the differences from the printed results.
    """
    largest, at, none_at = _printed_results_of_simulation()
    note = (
        f"Lin prints {largest} % at {at}° and no contact from {none_at}° on. Theta: deviation of the contact angles. Lin's "
        "text leaves open whether theta moves with the screw or the nut, its amplitude, whether it acts on one or both "
        "contacts of the screw, and the oversize of the balls. Last rows: Lin's rule by which neighbouring balls touch "
        "(3.77). No interpretation gives all three numbers. With theta on the screw, contact begins and ends too early; "
        "with theta on the nut, largest torque and its angle come out together, and contact ends too late."
    )
    rows = screw.simulation_interpretation_rows()
    title = "Simulation of a whole ball screw (Lin 3.4.4): ball-to-ball torque, for each interpretation of the text"
    return Table.from_rows("friction-run-readings", title, rows, note)


def bearing_torque_table() -> Table:
    """Return the table of the friction torque of the bearings of Lin's Table 4.2 under varied assumptions.

    The torque ratios are those of the largest to the smallest torque over a range of load angles.
    """
    note = (
        f"Printed for the four-point bearing: {printed_entry('lin-4.3', 'ratio_4p').number_as_printed}. Friction "
        f"coefficient {source_cases.four_point_bearing().groove.mu:g} and the freedom to tilt are assumed; the "
        "ratio does not depend on the friction coefficient. Range of load angles read off Lin's figure."
    )
    title = "Bearings of Lin's Table 4.2: ratio of largest to smallest friction torque, for each assumption"
    return Table.from_rows("friction-bearings", title, screw.bearing_torque_rows(), note)


def ball_contact_onset_table(cache: SceneResultCache) -> Table:
    """Return the table of the nut angle at which neighbouring balls first touch (section 4.3.2 of Lin's thesis).

    There is a row for each kind of geometric error and each velocity of unloaded balls. ``cache``: gives the solved scenes.
    """
    note = (
        "Screw of Lin's Table 4.1, errors of 5 µm, 1000 N, evenly spaced balls. Lin's conclusion that balls touch sooner "
        "with roundness errors assumes slow unloaded balls; it does not hold if these move at the nominal speed."
    )
    title = "Nut angle at which neighbouring balls first touch, with pitch or roundness error (Lin 4.3.2)"
    return Table.from_rows("friction-onset", title, screw.ball_contact_onset_rows(cache), note)


def _ball_pair_paragraph(pairs: Table) -> str:
    """Return the paragraph on the contact loads of two balls in Lin's Table 3.7.

    ``pairs``: table of ball-to-ball force and increase of the friction loss, a row for each interpretation of the text.
    """
    rows = {str(row["load_assumption"]): row for row in pairs.rows}
    loose, coupled, inferred = (rows[x] for x in (screw.UNCOUPLED, screw.AS_TEXT, screw.label_of_inferred_oversize()))
    load, inferred_load = (float(row["ball_load_at", f"{screw.THETA['a']:g}"] or 0.0) for row in (coupled, inferred))
    uncoupled, moved = (
        " and ".join(
            f"{100.0 + float(row['ball_force_error_at', f'{theta:g}'] or 0.0):.0f} %" for theta in screw.THETA.values()
        )
        for row in (loose, coupled)
    )
    return (
        "Lin does not print the load state of the two balls in 3.4.3. Read literally (no oversize, "
        f"{source_cases.pair_as_printed().force[0]:g} N along the axis), one diagonal carries nearly all: {uncoupled} of "
        f"the printed forces (cases a and b), {moved} where friction moves the balls and loads a third contact. Printed "
        f"force and increase together imply a contact load of {screw.contact_load_implied_by_table_3_7():.0f} N per ball, "
        f"against {load:.0f} N here; {screw.oversize_in_words()} of oversize would give {inferred_load:.0f} N. The literal "
        "reading is compared with the printed numbers; the inferred one is shown with it and labelled so, because its "
        "oversize was inferred from these numbers."
    )


def _simulation_paragraph(simulations: Table) -> str:
    """Return the paragraph on the whole-screw simulation of Lin's section 3.4.4.

    ``simulations``: table of the simulation's results, a row for each assumption.
    """
    cases = [row for row in simulations.rows if row["varied_assumption"] == screw.AS_CASE]
    source = next(row for row in simulations.rows if row["varied_assumption"] == screw.SOURCE_RULE)
    _, at, none_at = _printed_results_of_simulation()
    found = "; ".join(
        f"theta of {a:g}°: largest at {row['angle_of_largest_ratio']:.0f}°, none from {row['angle_without_contact']:.0f}°"
        for a, row in zip(screw.AMPLITUDES, cases, strict=True)
    )
    ratio = float(source["torque_ratio"] or 0.0) / float(cases[-1]["torque_ratio"] or np.nan)
    return (
        "The run of 3.4.4 also needs amplitude, phase and pattern of theta, oversize, start and return "
        f"tube: all are assumptions, varied below. Printed are {at}° for the largest torque and {none_at}° "
        f"for the end of contact; {found}. With Lin's rule for contact between balls the largest "
        f"torque ratio is {ratio:.2f} of the one by complementarity at the same theta, with balls that "
        "overlap. This may be why the printed ratio is smaller; it does not explain the angles."
    )


def screw_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on friction in a ball screw and in two bearings: sections 3.4 and 4.3 of Lin's thesis.

    ``cache``: gives the solved scenes; ``step``: function that receives a message before each step.
    """
    step("readings and maps of two balls")
    pairs = (pair_interpretations_table(), force_over_ball_oversize_figure())
    step("whole screw and what its assumptions change")
    whole = (screw_simulation_figure(), simulation_interpretations_table(), simulation_sensitivity_table())
    step("bearings and errors")
    last = (bearing_torque_table(), ball_contact_onset_table(cache))
    return Section(
        "friction-screw",
        "Lin 3.4 and 4.3: friction in a ball screw and in two bearings",
        (Text((_ball_pair_paragraph(pairs[0]), _simulation_paragraph(whole[2]))), *pairs, *whole, *last),
    )
