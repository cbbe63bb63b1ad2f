"""The answers of a solved scene as a block of eleven entries, aligned and no wider than asked, and as JSON."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from rollbench.comparison.commands.solving.solve_output import model_form_words
from rollbench.comparison.models.answers import Answers, LoadAnswers
from rollbench.comparison.models.model_form import ModelForm
from rollbench.comparison.quantities import number, quantity, record, shown
from rollbench.lowfi.rating.contacts import ALLOWED
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.validity import DENT_PRESSURE
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import counted, mean_load
from rollbench.meshes.parts import SIDES, Scene

#: Width of the labels of the block.
LABEL = 10


def loads_json(load: Array, contacts: int = 0) -> dict[str, Any] | None:
    """Worst ball, mean and extremes of the loaded contacts ``(n, 4)`` [N]; None without load. contacts: see
    `meshes.loads.mean_load`."""
    loaded = load > 0.0
    if not loaded.any():
        return None
    carried = load[loaded]
    i, s = np.unravel_index(int(load.argmax()), load.shape)
    return {
        "worst_ball": int(i) + 1,
        "worst_side": SIDES[int(s)],
        "max_N": number(carried.max()),
        "mean_N": number(mean_load(load, contacts)),
        "min_N": number(carried.min()),
        "loaded_contacts": int(carried.size),
        "contacts_in_mean": counted(load, contacts),
        "balls_without_load": int((~loaded.any(axis=1)).sum()),
    }


CONTACT = (
    quantity("ball"),
    quantity("side"),
    quantity("force_N"),
    quantity("contact_angle_deg", "angle"),
    quantity("approach_um", heading="approach of its contact", form=".3f"),
    quantity("semi_axis_a_mm", "a", "larger semi-axis", ".4f"),
    quantity("semi_axis_b_mm", "b"),
    quantity("pressure_MPa", heading="peak pressure", form=".0f"),
)
TRUNCATION = (
    quantity("ball"),
    quantity("side"),
    quantity("edge"),
    quantity("contact_angle_deg", "angle"),
    quantity("ellipse_half_width_deg", "half"),
    quantity("edge_angle_deg", "limit"),
    quantity("margin_deg", heading="ellipse to edge of groove", form=".2f"),
    quantity("contacts_cut", "cut"),
)
STATIC_SAFETY = (
    quantity("factor", heading="static safety", form=".2f"),
    quantity("permanent_over_diameter", "permanent"),
    quantity("allowed_over_diameter", lambda _: ALLOWED),
    quantity("allowed_pressure_MPa", lambda _: DENT_PRESSURE),
)
LIFE = (
    quantity("L10_million_revolutions", "revolutions", "life L10", ".1f"),
    quantity("raceways_million_revolutions", "raceways"),
    quantity("rating_as_computed_N", "rating"),
    quantity("equivalent_load_N", "equivalent"),
    quantity("standard"),
)
RATINGS = (
    quantity("dynamic_N"),
    quantity("static_N"),
    quantity("direction", lambda rated: "axial" if rated.axial else "radial"),
    quantity("dynamic_standard"),
    quantity("static_standard"),
)
RIGIDITIES = (
    quantity("contacts_alone", lambda three: 1e-6 * three.contacts),
    quantity("with_bodies", lambda three: three.bodies and 1e-6 * three.bodies),
    quantity("with_unequal_loads", lambda three: three.unequal and 1e-6 * three.unequal),
    quantity("makers_practice", lambda three: three.practice and 1e-6 * three.practice),
)
PRELOAD = (quantity("mean_N"), quantity("max_N", "largest"), quantity("axial_N"), quantity("loaded_contacts", "loaded"))
CONTACT_LOST = (
    quantity("load_factor", "factor"),
    quantity("axial_force_N", lambda lift: None if lift.factor is None else lift.axial),
    quantity("ball", lambda lift: lift.ball or None),
    quantity("side", lambda lift: lift.side or None),
    quantity("words", lambda lift: lift.words or None),
)
#: Groups of answers that contact loads alone give.
GROUPS = {"worst_contact": CONTACT, "truncation": TRUNCATION, "static_safety": STATIC_SAFETY, "life": LIFE}


def contacts_json(answers: LoadAnswers) -> dict[str, Any]:
    """Worst contact, truncation, static safety, life and ratings; null where there is none."""
    return {
        "worst_contact": record(CONTACT, answers.worst),
        "truncation": record(TRUNCATION, answers.reach),
        "static_safety": record(STATIC_SAFETY, answers.safety),
        "life": record(LIFE, answers.life),
        "ratings": record(RATINGS, answers.ratings),
        "rating_refused": answers.words or None,
    }


def answers_json(scene: Scene, result: StaticResult, answers: Answers) -> dict[str, Any]:
    """All answers: forces in N, displacements in um, rigidities in N/um."""
    three, life = answers.rigidities, answers.loads.life
    data = contacts_json(answers.loads)
    if life is not None and scene.motion is not None and scene.motion.speed:
        data["life"]["L10_hours"] = number(life.hours(scene.motion.speed))
    return {
        "loads": loads_json(result.load, nominal_contacts(scene, result)),
        "axial": {
            "force_N": number(answers.force),
            "displacement_um": number(1e6 * answers.displacement),
            "rigidity_N_per_um": None if three is None or three.unequal is None else number(1e-6 * three.unequal),
            "tangent_N_per_um": None if answers.tangent is None else number(1e-6 * answers.tangent),
            "tangent_words": answers.tangent_words or None,
        },
        "rigidities_N_per_um": record(RIGIDITIES, three),
        **data,
        "preload": record(PRELOAD, answers.preload),
        "contact_lost": record(CONTACT_LOST, answers.lift),
        "friction": answers.friction,
        "friction_words": answers.friction_words or None,
    }


def block(
    scene: Scene, result: StaticResult, answers: Answers, worth: ModelForm | None, width: int, speed: float | None = None
) -> str:
    """Eleven labelled entries, no line wider than ``width`` (40 or more); speed: of the turning part [rad/s], for hours."""
    return "\n".join(entry(label, text, width) for label, text in entries(scene, result, answers, worth, speed))


def entries(
    scene: Scene, result: StaticResult, answers: Answers, worth: ModelForm | None, speed: float | None = None
) -> tuple[tuple[str, str], ...]:
    """The eleven entries of the block: label and sentence."""
    data = answers_json(scene, result, answers)
    return (
        ("loads", _loads(data, worth)),
        ("axial", _axial(data, worth)),
        *contact_entries(data, speed)[1:4],
        ("preload", _preload(data)),
        ("friction", _friction(data)),
        ("life", _life(data, speed)),
        ("ratings", _ratings(data)),
        ("error", "not estimated" if worth is None else model_form_words(worth)),
    )


def contact_entries(data: dict[str, Any], speed: float | None) -> tuple[tuple[str, str], ...]:
    """Labels and texts of what contacts alone say: loads, worst contact, ellipses, static safety, life, ratings."""
    return (
        ("loads", _loads(data)),
        ("contact", _contact(data)),
        ("ellipse", _ellipse(data)),
        ("static", _static(data)),
        ("life", _life(data, speed)),
        ("ratings", _ratings(data)),
    )


def entry(label: str, text: str, width: int) -> str:
    """A label and its text, wrapped with a hanging indent."""
    return textwrap.fill(
        text, max(width, 40), initial_indent=f"{label:<{LABEL}}", subsequent_indent=" " * LABEL, break_on_hyphens=False
    )


def load_error(mean: float, worth: ModelForm | None) -> float | None:
    """Error [N] to expect of a contact load; None where it is not covered."""
    return None if worth is None or worth.percent is None else mean * worth.percent / 100.0


def _share(value: float, percent: float | None) -> float | None:
    return None if percent is None else abs(value) * percent / 100.0


def _loads(data: dict[str, Any], worth: ModelForm | None = None) -> str:
    d = data["loads"]
    if d is None:
        return "no contact carries load"
    lost = f"; {d['balls_without_load']} balls without load" if d["balls_without_load"] else ""
    if d["contacts_in_mean"] != d["loaded_contacts"]:
        lost += f"; the mean is their sum over the {d['contacts_in_mean']} contacts that the screw without errors loads"
    error = load_error(d["mean_N"], worth)
    most, mean, least = (shown(d[key], error) for key in ("max_N", "mean_N", "min_N"))
    return (
        f"ball {d['worst_ball']} {d['worst_side']} carries most, {most} N; mean {mean} N, least {least} N of "
        f"{d['loaded_contacts']} loaded contacts{lost}"
    )


def _axial(data: dict[str, Any], worth: ModelForm | None) -> str:
    d, three = data["axial"], data["rigidities_N_per_um"]
    moved = None if worth is None else worth.displacement_percent
    stiff = None if worth is None else worth.rigidity_percent
    moves = shown(d["displacement_um"], _share(d["displacement_um"], moved), 3)
    text = f"{moves} um under {d['force_N']:.5g} N at the nut's centre"
    if three is None:
        return f"{text}; no rigidity without axial load"
    why = f"; no tangent: {d['tangent_words']}" if d["tangent_words"] else ""
    return f"{text}; {_rigidities(three, d['tangent_N_per_um'], moved, stiff)}{why}"


def _rigidities(three: dict[str, Any], tangent: float | None, moved: float | None, stiff: float | None) -> str:
    """The model's own rigidity, and those of formulas, which take another contact angle: no one bounds another. moved,
    stiff: errors [%] to expect of secant and tangent."""

    def known(*named: tuple[str, float | None], off: float | None = None) -> str:
        return ", ".join(f"{name} {shown(value, _share(value, off))}" for name, value in named if value is not None)

    secant = known(("secant", three["with_unequal_loads"]), off=moved)
    by_model = ", ".join(filter(None, [secant, known(("tangent", tangent), off=stiff)])) or "none"
    formulas = known(("contacts alone", three["contacts_alone"]), ("contacts and bodies", three["with_bodies"]))
    practice = known((", of which makers advise to take 80 %:", three["makers_practice"]))
    return f"rigidity in N/um: {by_model} by this model; {formulas} by formulas at the nominal contact angle{practice}"


def _contact(data: dict[str, Any]) -> str:
    d = data["worst_contact"]
    if d is None:
        return "none"
    return (
        f"worst on ball {d['ball']} {d['side']}: {d['pressure_MPa']:.0f} MPa, approach {d['approach_um']:.3g} um, "
        f"semi-axes {d['semi_axis_a_mm']:.3g} x {d['semi_axis_b_mm']:.3g} mm, angle {d['contact_angle_deg']:.1f} deg"
    )


def _ellipse(data: dict[str, Any]) -> str:
    d = data["truncation"]
    if d is None:
        return data["rating_refused"] or "none"
    where = f"ball {d['ball']} {d['side']}"
    ends = f"ellipse {d['contact_angle_deg']:.1f} +- {d['ellipse_half_width_deg']:.1f} deg, {d['edge']} at"
    if d["contacts_cut"]:
        return (
            f"TRUNCATED on {d['contacts_cut']} contacts, most on {where}: {ends} {d['edge_angle_deg']:.1f} deg, "
            f"{-d['margin_deg']:.1f} deg beyond"
        )
    return f"inside all grooves; nearest to an edge on {where}: {ends} {d['edge_angle_deg']:.1f} deg"


def _static(data: dict[str, Any]) -> str:
    d = data["static_safety"]
    if d is None:
        return "none"
    return (
        f"safety {d['factor']:.3g} on the worst contact's load against {d['allowed_pressure_MPa']:.0f} MPa (ISO 76); "
        f"lasting dent {d['permanent_over_diameter']:.1e} of the ball's diameter, 1e-4 allowed (Palmgren)"
    )


def _preload(data: dict[str, Any]) -> str:
    d, lost = data["preload"], data["contact_lost"]
    if d is None:
        return "not known: the scene does not solve without its loads"
    if not d["loaded_contacts"]:
        return "none: no contact carries load when the scene's loads are away"
    text = f"{shown(d['mean_N'], digits=3)} N a contact, {shown(d['axial_N'])} N along the axis, without the scene's loads"
    if lost is None:
        return text
    if lost["load_factor"] is None:
        return f"{text}; first contact lost: {lost['words']}"
    axial = f" ({shown(lost['axial_force_N'])} N axial)" if lost["axial_force_N"] else ""
    where = f"ball {lost['ball']} {lost['side']}"
    return f"{text}; first contact lost at {lost['load_factor']:.3g} times the loads{axial}, {where}"


def _friction(data: dict[str, Any]) -> str:
    d = data["friction"]
    if d is None:
        return f"not computed: {data['friction_words']}"
    # the coefficient is known to a factor of about three, and with it all that friction costs
    torque = d["friction_torque_Nmm"]
    text = f"torque {shown(torque, torque)} N mm"
    if d["efficiency_forward_percent"] is None:
        return text
    back = d["efficiency_backward_percent"]
    backward = "self-locking" if back is None else f"{_efficiency(back)} % with it"
    return f"{text}; efficiency {_efficiency(d['efficiency_forward_percent'])} % against the load, {backward}"


def _efficiency(percent: float) -> str:
    """An efficiency whose loss is known to its order of magnitude."""
    return shown(percent, 100.0 - percent)


def _life(data: dict[str, Any], speed: float | None) -> str:
    d = data["life"]
    if d is None:
        return f"not rated: {data['rating_refused'] or 'no load'}"
    hours = f" ({d['L10_hours']:.3g} h)" if speed and "L10_hours" in d else ""
    return (
        f"L10 {shown(d['L10_million_revolutions'])} million revolutions{hours} of this load distribution, equivalent load "
        f"{shown(d['equivalent_load_N'])} N, rating {shown(d['rating_as_computed_N'])} N as computed by "
        f"{d['standard']}, not a maker's"
    )


def _ratings(data: dict[str, Any]) -> str:
    d = data["ratings"]
    if d is None:
        return f"none: {data['rating_refused']}"
    return (
        f"C {shown(d['dynamic_N'])} N ({d['dynamic_standard']}), C0 {shown(d['static_N'])} N ({d['static_standard']}), "
        f"both {d['direction']}, as computed of these parts, not a maker's"
    )
