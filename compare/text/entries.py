"""The answers of a solved scene as labelled sentences, aligned and no wider than asked."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rollbench.compare.models.load_cases import Solved, SolvedAxis
from rollbench.compare.models.loading import path_words
from rollbench.compare.models.model_form import ModelForm
from rollbench.compare.quantities import as_json, count_of, shown
from rollbench.compare.results.scene_json import answers_json, set_json, starting_torque, whole_json
from rollbench.meshes.axis import RollerRow

if TYPE_CHECKING:
    from rollbench.compare.models.answers import Answers, AxisAnswers
    from rollbench.lowfi.bearings.torque import BallTorque

#: Width of the labels of the block.
LABEL = 10


def block(one: Solved | SolvedAxis, width: int) -> str:
    """All entries, no line wider than ``width`` (40 or more); empty without answers."""
    if one.answers is None:
        return ""
    return "\n".join(entry(label, text, width) for label, text in entries(one))


def entry(label: str, text: str, width: int) -> str:
    """A label and its text, wrapped with a hanging indent."""
    return textwrap.fill(
        text, max(width, 40), initial_indent=f"{label:<{LABEL}}", subsequent_indent=" " * LABEL, break_on_hyphens=False
    )


def entries(one: Solved | SolvedAxis) -> Sequence[tuple[str, str]]:
    """The entries of a solved scene that has answers: label and sentence."""
    if isinstance(one, SolvedAxis):
        assert one.answers is not None, "a solved axis has answers"
        return _of_sets(one, one.answers)
    data, worth = answers_json(one), one.expected
    return (
        ("loads", _loads(data, worth)),
        ("axial", _axial(data, worth)),
        ("contact", _contact(data)),
        ("ellipse", _ellipse(data)),
        ("static", _static(data)),
        ("preload", _preload(data)),
        *_supports(one.answers),
        *_rests([("", data)]),
        ("friction", _friction(data)),
        *_torques([] if one.answers is None else [("", one.answers.torque)]),
        ("life", _life(data)),
        *reference_lines("", data["reference_life"]),
        ("ratings", _ratings(data)),
        *_shaft(data),
        ("error", "not estimated" if worth is None else model_form_words(worth)),
    )


def _of_sets(one: SolvedAxis, answers: AxisAnswers) -> list[tuple[str, str]]:
    """The entries of several sets: axial answers, then what the worst set's contacts say, preloads, torques."""
    data, result = whole_json(one), one.result
    axial = data.get("axial")
    lines = []
    if axial is not None:
        moved = axial["displacement_um"]
        text = f"{axial['force_N']:.5g} N on shaft and housings"
        text += "" if moved is None else f", {result.stiffness_at} moves by {moved:.4g} um from where it is without loads"
        rigid = axial["tangent_N_per_um"]
        lines.append(("axial", text if rigid is None else f"{text}; tangent rigidity {rigid:.5g} N/um"))
        lost = axial["lost_motion_um_per_100N"]
        if lost is not None:
            lines.append(("lost", f"{lost:.3g} um of motion for every 100 N of friction that reverses, by elasticity only"))
    kinds: set[bool] = set()
    for i in answers.by_pressure:  # the worst set of balls and the worst row of rollers
        s, of_set = result.sets[i], answers.sets[i]
        if (of_rollers := isinstance(of_set.parts, RollerRow)) in kinds:
            continue
        kinds.add(of_rollers)
        said = set_json(s, of_set, one.scene.motion)
        lines += [(label, f"{of_set.name}: {text(said)}") for label, text in (OF_ROLLERS if of_rollers else OF_BALLS)]
        lines += reference_lines(f"{of_set.name}: ", said["reference_life"])
    lines.append(("preload", _preloads(answers)))
    lines += _supports(answers)
    sets = list(zip(result.sets, answers.sets, strict=True))
    lines += _rests([(f"{s.of.name}: ", set_json(s, x, one.scene.motion)) for s, x in sets])
    torques = {x.name: found["torque_Nmm"] for s, x in sets if (found := starting_torque(s, x)) is not None}
    if torques:
        each = "; ".join(f"{name} {value:.3g} N mm" for name, value in torques.items())
        words = "in all by Palmgren's load formula (Smith 2.33), without lubricant and seals"
        lines.append(("starting", f"torque {sum(torques.values()):.3g} N mm {words}: {each}"))
    lines += _torques([(f"{x.name} ", x.torque) for x in answers.sets])
    return [*lines, *drive_lines(data.get("drive")), *_axis_life(data.get("axis_life"))]


def band(ends: Sequence[float] | None, digits: int = 3) -> str:
    """A range, one number where its ends agree to the digits shown."""
    if ends is None:
        return "not known"
    low, high = (shown(x, digits=digits) for x in ends)
    return low if low == high else f"{low} to {high}"


def _torques(rows: list[tuple[str, BallTorque | None]]) -> list[tuple[str, str]]:
    """The entry on the friction torques of bearings: what each sentence begins with, and its torque."""
    known = [(name, as_json(torque) or {}) for name, torque in rows if torque is not None]
    if not known:
        return []
    each = [
        f"{name}{band(data['starting_Nmm'])}" + (f", {band(runs)}" if (runs := data["running_Nmm"]) else "")
        for name, data in known
    ]
    runs = "to start, to run" if known[0][1]["running_Nmm"] else "to start (to run: with [lubricant] and [motion])"
    words = f"friction torque in N mm {runs}, by Palmgren, lowest to highest published coefficients"
    return [("bearings" if known[0][0] else "bearing", f"{words}: {'; '.join(each)}")]


def drive_lines(drive: dict[str, Any] | None) -> list[tuple[str, str]]:
    """The entries on what the motor of an axis turns, from its JSON."""
    if drive is None:
        return []
    speeding = drive["accelerating_torque_Nmm"]
    runs = f"torque in N mm {band(drive['running_torque_Nmm'])} at constant speed"
    text = f"{runs}, {band(drive['starting_torque_Nmm'])} from rest"
    text += "" if speeding is None else f", {band(speeding)} while it comes to speed"
    given = [
        f"{name} {shown(drive[key])} N mm" for name, key in (("seals", "seals_Nmm"), ("other", "other_Nmm")) if drive[key]
    ]
    text += f"; with {', '.join(given)} as given" if given else ""
    why = "; ".join(dict.fromkeys(x["words"] for x in drive["sets"] if x["words"]))
    inertia = f"{shown(drive['inertia_kg_mm2'])} kg mm2: shaft {shown(drive['shaft_inertia_kg_mm2'])}"
    inertia += f", reflected mass {shown(drive['reflected_inertia_kg_mm2'])}" if drive["reflected_inertia_kg_mm2"] else ""
    return [("drive", f"{text}; not known: {why}" if why else text), ("inertia", inertia)]


def _axis_life(life: dict[str, Any] | None) -> list[tuple[str, str]]:
    """The entry on the life of all sets together."""
    if life is None:
        return []
    return [("axis life", f"L10 {life_words(life)}, of all sets together; {life['shortest_set']} lives shortest")]


def _preloads(answers: AxisAnswers) -> str:
    """Of every set, without the loads of the scene."""
    if any(x.preload is None for x in answers.sets):
        return "not known: the scene does not solve without its loads"
    held = [(x.name, "roller" if isinstance(x.parts, RollerRow) else "contact", x.preload) for x in answers.sets]
    each = [f"{name} {p.mean:.1f} N a {one}, {p.axial:.0f} N along the axis" for name, one, p in held if p and p.loaded]
    return "; ".join(each) or "none: no contact carries load when the scene's loads are away"


def _supports(answers: Answers | AxisAnswers | None) -> list[tuple[str, str]]:
    """The entry on what supports take of the loads, where they take something."""
    words = "" if answers is None or answers.path is None else path_words(answers.path)
    return [("supports", words)] if words else []


def _rests(sets: list[tuple[str, dict[str, Any]]]) -> list[tuple[str, str]]:
    """The entry on the clearance of deep-groove rows: how it begins and answers of each."""
    rows = [
        f"{name}contact angle at rest {d['rest_angle_deg']:.2f} deg; clearance {d['radial_um']:.4g} um radial, "
        f"{d['axial_um']:.4g} um axial"
        for name, data in sets
        if (d := data.get("clearance")) is not None
    ]
    return [("clearance", "; ".join(rows))] if rows else []


def model_form_text(m: ModelForm) -> str:
    """The estimate in one sentence."""
    return f"model-form error{': ' if m.percent is None else ' '}{model_form_words(m)}"


def model_form_words(m: ModelForm) -> str:
    """The same behind a label that says what it is of."""
    if m.percent is None or m.rms_percent is None:
        away = f" (nearest {m.nearest})" if m.nearest else ""
        return f"not covered by the comparisons with the 3D reference{away}; " + "; ".join(m.words)
    kind = "scene of its kind" if m.compared == 1 else "scenes of its kind"
    others = {
        "displacement": m.displacement_percent,
        "rigidity": m.rigidity_percent,
        "largest pressure": m.pressure_percent,
    }
    further = "".join(f", {name} {value:.1f} %" for name, value in others.items() if value is not None)
    return (
        f"to expect: {m.percent:.1f} % of the mean load on the worst contact, {m.rms_percent:.1f} % RMS{further} "
        f"(nine of ten of {m.compared} {kind} were within, nearest {m.nearest}); " + "; ".join(m.words)
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
    lost = f"; {count_of(d['balls_without_load'], 'ball')} without load" if d["balls_without_load"] else ""
    if d["contacts_in_mean"] != d["loaded_contacts"]:
        nominal = count_of(d["contacts_in_mean"], "contact")
        lost += f"; the mean is their sum over the {nominal} that the screw without errors loads"
    error = load_error(d["mean_N"], worth)
    most, mean, least = (shown(d[key], error) for key in ("max_N", "mean_N", "min_N"))
    return (
        f"ball {d['worst_ball']} {d['worst_side']} carries most, {most} N; mean {mean} N, least {least} N of "
        f"{count_of(d['loaded_contacts'], 'loaded contact')}{lost}"
    )


def _axial(data: dict[str, Any], worth: ModelForm | None) -> str:
    d, three = data["axial"], data["rigidities_N_per_um"]
    moved = None if worth is None else worth.displacement_percent
    stiff = None if worth is None else worth.rigidity_percent
    um = d["displacement_um"]
    moves = "displacement not known" if um is None else f"{shown(um, _share(um, moved), 3)} um"
    text = f"{moves} under {d['force_N']:.5g} N at the nut's centre"
    if three is None:
        return f"{text}; no rigidity without axial load"
    why = f"; no tangent: {d['tangent_words']}" if d["tangent_words"] else ""
    rigid = {"tangent": d["tangent_N_per_um"], "over the step of load": d.get("stepped_N_per_um")}
    return f"{text}; {_rigidities(three, rigid, moved, stiff)}{why}"


def _rigidities(three: dict[str, Any], local: dict[str, float | None], moved: float | None, stiff: float | None) -> str:
    """The model's own rigidity, and those of formulas, which take another contact angle: no one bounds another. local: at
    the load, by their names; moved, stiff: errors [%] to expect of secant and of these."""

    def known(*named: tuple[str, float | None], off: float | None = None) -> str:
        return ", ".join(f"{name} {shown(value, _share(value, off))}" for name, value in named if value is not None)

    secant = known(("secant", three["with_unequal_loads"]), off=moved)
    by_model = ", ".join(filter(None, [secant, known(*local.items(), off=stiff)])) or "none"
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
            f"TRUNCATED on {count_of(d['contacts_cut'], 'contact')}, most on {where}: {ends} {d['edge_angle_deg']:.1f} "
            f"deg, {-d['margin_deg']:.1f} deg beyond"
        )
    return f"inside all grooves; nearest to an edge on {where}: {ends} {d['edge_angle_deg']:.1f} deg"


def _roller_loads(data: dict[str, Any]) -> str:
    d = data["loads"]
    lost = f"; {count_of(d['rollers_without_load'], 'roller')} without load" if d["rollers_without_load"] else ""
    most, mean, least = (shown(d[key]) for key in ("max_N", "mean_N", "min_N"))
    return (
        f"roller {d['worst_roller']} carries most, {most} N; mean {mean} N, least {least} N of "
        f"{count_of(d['loaded_contacts'], 'loaded roller')}{lost}"
    )


def _line_contact(data: dict[str, Any]) -> str:
    d = data["worst_contact"]
    return (
        f"worst on roller {d['roller']}, {d['race']} race: {d['pressure_MPa']:.0f} MPa {d['place_mm']:+.2g} mm from its "
        f"middle (+: to its large end), where {shown(d['line_load_N_mm'])} N/mm press a strip of half-width "
        f"{d['half_width_mm']:.3g} mm; {d['middle_pressure_MPa']:.0f} MPa with its load evenly spread; "
        f"{d['other_race_pressure_MPa']:.0f} MPa on the other race; without what straight ends add"
    )


def _static(data: dict[str, Any]) -> str:
    d = data["static_safety"]
    if d is None:
        return "none"
    text = f"safety {d['factor']:.3g} on the worst contact's load against {d['allowed_pressure_MPa']:.0f} MPa (ISO 76)"
    if "permanent_over_diameter" not in d:  # of rollers
        return text
    return f"{text}; lasting dent {d['permanent_over_diameter']:.1e} of the ball's diameter, 1e-4 allowed (Palmgren)"


def _rib(data: dict[str, Any]) -> str:
    d = data["rib_contact"]
    if d is None:
        return "no load"
    text = f"{shown(d['load_N'])} N on the large end of roller {d['roller']}"
    if d["pressure_MPa"] is not None:
        axes = f"{d['semi_axis_a_mm']:.3g} x {d['semi_axis_b_mm']:.3g} mm"
        text += f", {shown(d['pressure_MPa'])} MPa on an ellipse of semi-axes {axes}"
    return f"{text}{_noted(d)}"


def _roller_torque(data: dict[str, Any]) -> str:
    d = data["roller_torque"]
    if d is None:
        return "no load"
    film = "" if d["film_Nmm"] is None else f"film {shown(d['film_Nmm'])}, "
    band = "" if d["low_Nmm"] is None else f", {shown(d['low_Nmm'])} to {shown(d['high_Nmm'])} with 0.03 to 0.15 on the rib"
    timken = "" if d["timken_Nmm"] is None else f"; {shown(d['timken_Nmm'])} N mm by Timken's formula (Smith 3.29)"
    return (
        f"of friction {shown(d['torque_Nmm'])} N mm by work ({film}rib {shown(d['rib_Nmm'])}, hysteresis "
        f"{shown(d['hysteresis_Nmm'])}){band}; {shown(d['starting_torque_Nmm'])} N mm at rest{timken}{_noted(d)}"
    )


def _noted(d: dict[str, Any]) -> str:
    return f"; {d['words']}" if d["words"] else ""


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


def _life(data: dict[str, Any]) -> str:
    d = data["life"]
    if d is None:
        return f"not rated: {data['rating_refused'] or 'no load'}"
    return (
        f"L10 {life_words(d)} of this load distribution, equivalent load "
        f"{shown(d['equivalent_load_N'])} N, rating {shown(d['rating_as_computed_N'])} N as computed by "
        f"{d['standard']}, not a maker's{modified_words(data.get('modified_life'))}"
    )


def modified_words(d: dict[str, Any] | None) -> str:
    """The modified life, empty where the scene gives nothing of it."""
    if d is None:
        return ""
    lubricated = "" if d["a_ISO"] is None else f", a_ISO {shown(d['a_ISO'])} (C_u {shown(d['fatigue_load_limit_N'])} N)"
    million, share = shown(d["Lnm_million_revolutions"]), d["reliability_percent"]
    return f"; modified {million} million revolutions for {share:g} %: a_1 {shown(d['a_1'])}{lubricated}"


def reference_lines(of: str, d: dict[str, Any] | None) -> list[tuple[str, str]]:
    """The entry on the life by ISO/TS 16281, nothing where there is none; of: what it begins with."""
    if d is None:
        return []
    capacity, carried = d["raceway_capacity_N"], d["raceway_equivalent_load_N"]
    each = ", ".join(f"{name} {shown(carried[name])} of {shown(Q)} N" for name, Q in capacity.items())
    million, load = shown(d["L10r_million_revolutions"]), shown(d["equivalent_reference_load_N"])
    return [("ISO 16281", f"{of}L10r {million} million revolutions, P_ref {load} N; Q_e of Q_c: {each}")]


def _shaft(data: dict[str, Any]) -> list[tuple[str, str]]:
    """Limits of the shaft, nothing where there are none."""
    d = data["shaft"]
    if d is None:
        return []
    turns = (
        "" if d["speed_rpm"] is None else f"; it turns at {shown(d['speed_rpm'])} rpm, DN {shown(d['dn_mm_rpm'])} mm rpm"
    )
    return [
        (
            "shaft",
            f"{shown(d['length_mm'])} mm, {d['ends']}: buckles under {shown(d['buckling_N'])} N (allowed "
            f"{shown(d['allowed_compression_N'])} N, {shown(d['compression_N'])} N press), whirls at "
            f"{shown(d['critical_speed_rpm'])} rpm (allowed {shown(d['allowed_speed_rpm'])} rpm){turns}",
        )
    ]


def life_words(d: dict[str, Any]) -> str:
    """A life in revolutions and, where they are known, hours and kilometres."""
    also = [f"{shown(d[key])} {unit}" for key, unit in (("L10_hours", "h"), ("L10_km", "km")) if d.get(key)]
    return f"{shown(d['L10_million_revolutions'])} million revolutions" + (f" ({', '.join(also)})" if also else "")


def _ratings(data: dict[str, Any]) -> str:
    d = data["ratings"]
    if d is None:
        return f"none: {data['rating_refused']}"
    return (
        f"C {shown(d['dynamic_N'])} N ({d['dynamic_standard']}), C0 {shown(d['static_N'])} N ({d['static_standard']}), "
        f"both {d['direction']}, as computed of these parts, not a maker's"
    )


#: Entries on the worst set of several, of balls and of rollers.
OF_BALLS = (
    ("loads", _loads),
    ("contact", _contact),
    ("ellipse", _ellipse),
    ("static", _static),
    ("life", _life),
    ("ratings", _ratings),
)
OF_ROLLERS = (
    ("loads", _roller_loads),
    ("contact", _line_contact),
    ("static", _static),
    ("rib", _rib),
    ("torque", _roller_torque),
    ("life", _life),
    ("ratings", _ratings),
)
