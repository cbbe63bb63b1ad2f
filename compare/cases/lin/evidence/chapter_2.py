"""Chapter 2 and Table B.1 of Lin's thesis: contact loads of the case studies, geometric errors, Hertz constants."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from rollbench.compare.cases.lin.reconstruction.explanations import ERRORS, evaluate_explanations
from rollbench.compare.evidence import ComputedEntryValues, count_in_words
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.comparison import PRINTED
from rollbench.compare.models.study import SceneResultCache, with_conformity
from rollbench.compare.printed import printed_entry, printed_value
from rollbench.compare.studies.members.ensemble import random_draws_of_built_in_scene
from rollbench.lowfi.statics.contacts import hertz_without_errors, misprinted_hertz_of_flanks
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Errors, Scene, SideErrors, Support
from rollbench.meshes.section import nodes_of_whole_beam, screw_groove_section
from rollbench.meshes.surface import principal_curvatures
from rollbench.reports.content import Row

#: Conformity with which Table B.1 was computed (that of Table 3.6), instead of Table 2.1's groove radius.
TABLE_CONFORMITY = 0.56


def exact_hertz_parameters(scene: Scene) -> dict[str, dict[str, float]]:
    """Return the Hertz parameters of Lin's Table B.1 by exact elliptic integrals, in SI units.

    The outer keys are "S" for contacts with the screw and "N" for those with the nut; the inner ones are names of the
    parameters, such as "C_a". ``scene``: the ball screw; its geometric errors are ignored.
    """
    bare = replace(scene, errors=Errors())
    drawn = draw_geometry_with_errors(bare, ball_layout(bare))
    gamma = np.full(scene.ball_count, scene.track.contact_angle)
    constants = hertz_without_errors(bare)
    out = {}
    for letter, side in (("S", 0), ("N", 3)):
        across, along = principal_curvatures(bare, drawn, side, gamma)[0]
        r2, r1 = 1.0 / (1.0 / scene.balls.radius + across), 1.0 / (1.0 / scene.balls.radius + along)
        out[letter] = {"e": float(constants.eccentricity[side])}
        out[letter] |= {name: float(getattr(constants, name)[side]) for name in ("C", "C_a", "C_b")}
        radii = {"rho1": 1.0 / across, "rho2": 1.0 / along, "R1": r1, "R2": r2, "rho_eq": np.sqrt(r1 * r2)}
        out[letter] |= {name: float(radius) for name, radius in radii.items()}
    return out


#: Quantities of Table B.1 by the first part of the printed number's key: name of the value computed as Lin did, name of the
#: correct value, factor from SI to the printed unit.
QUANTITIES = {
    "e_": ("e", "e", 1.0),
    "C_": ("C", "C", 1.0),
    "C_a": ("C_a", "C_a", 1.0),
    "C_b": ("C_b", "C_b", 1.0),
    "rho1_": ("rho_1", "rho1", 1e3),
    "rho2_": ("rho_2", "rho2", 1e3),
    "R1_": ("R_1", "R1", 1e3),
    "R2_": ("R_2", "R2", 1e3),
    "rho_eq_": ("rho_eq", "rho_eq", 1e3),
}
#: Rows 1 and 2 of the table are along and across the groove for the nut, but across and along it for the screw.
SWAPPED = {"rho1_N": "rho2", "rho2_N": "rho1"}


def correct_values_of_table_b_1(scene: Scene) -> dict[str, float]:
    """Return the correct values of Lin's Table B.1 for the groove radius of the scene, by key of the printed numbers.

    The values have the units of the table.
    """
    right = exact_hertz_parameters(scene)
    keys = [(f"{start}{letter}", letter, name, unit) for letter in "SN" for start, (_, name, unit) in QUANTITIES.items()]
    return {key: unit * right[letter][SWAPPED.get(key, name)] for key, letter, name, unit in keys}


def table_b_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute the Hertz parameters of Table B.1 of Lin's thesis, with his faults and without them.

    ``findings``: receives two values to compare with each printed number. One is computed as Lin did, with a conformity of
    0.56 and the thesis's faults; the other is correct and has the groove of Table 2.1, which the text names. ``cache``:
    gives the scenes included with rollbench.
    """
    scene = cache.built_in_scene("lin-case1")
    misprinted = misprinted_hertz_of_flanks(with_conformity(scene, TABLE_CONFORMITY))
    right, faulty = correct_values_of_table_b_1(scene), dict(zip("SN", misprinted, strict=True))
    for letter, printed in faulty.items():
        for start, (attribute, _, unit) in QUANTITIES.items():
            key = f"{start}{letter}"
            findings.add_number(key, right[key], as_printed=unit * getattr(printed, attribute))
    findings.add_number("F_1", None, as_printed=faulty["S"].F_1)


# --- section 2.4.1, case studies 1, 2 and 3: printed numbers and claims, with the errors against ANSYS


def table_2_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Record the inputs of Table 2.1 and section 2.4.1 of Lin's thesis, as the scenes contain them.

    ``findings``: receives the value to compare with each printed number, in the printed unit; ``cache``: gives the scenes
    included with rollbench.
    """
    scene, preloaded, offset = (cache.built_in_scene(name) for name in ("lin-case1", "lin-case3", "lin-case3-offset"))
    track, nut, steel = scene.track, scene.nut, scene.screw.material
    mm = {"length": scene.screw.length, "R_P": track.pitch_radius, "lead": track.lead, "R_B": scene.balls.radius}
    mm |= {"r_G": scene.screw.groove_radius, "nut_diameter": nut.outer_diameter, "nut_length": nut.length}
    findings.numbers({key: 1e3 * value for key, value in mm.items()})
    findings.numbers({"balls": scene.ball_count, "beta": np.degrees(track.contact_angle), "nu": steel.poissons_ratio})
    findings.numbers({"force": scene.loads[0].force[2], "oversize": 1e6 * preloaded.errors.balls.oversize})
    findings.add_number("oversize_17", 1e6 * dict(cache.built_in_scene("lin-case2").errors.balls.listed)[17])
    findings.add_number("offset", 1e6 * dict(offset.supports[-1].fixed)["ux"])
    young = steel.youngs_modulus
    findings.add_number("E", 1e-6 * young, f"taken as {1e-9 * young:g} kN/mm²; shown in the unit printed")


def lin_beam_element_count(cache: SceneResultCache) -> int:
    """Return the number of beam elements of Lin's screw model: 12 + 12 outside the nut, 3 of 15 mm each inside it.

    ``cache``: gives the scenes included with rollbench.
    """
    return nodes_of_whole_beam(cache.scene_with_options("lin-case1", partition="source")).size - 1


def table_2_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute the number of beam elements in Table 2.2 of Lin's thesis.

    ``findings``: receives this number; ``cache``: gives the scenes included with rollbench.
    """
    words = "12 outside + 3 of 15 mm inside + 12 outside"
    findings.add_number("elements_proposed", float(lin_beam_element_count(cache)), words)


@dataclass(frozen=True)
class EndSupport:
    """An interpretation of the support of the screw's right end in Lin's case study 3, which his text leaves unclear.

    ``restraint``: displacements and rotations that the support restrains; ``plain_scene``, ``offset_scene``: names of the
    scenes without and with a lateral offset of the right end; ``is_stated_by_text``: whether Lin's text states this
    support.
    """

    restraint: str
    plain_scene: str
    offset_scene: str
    is_stated_by_text: bool = False


#: Interpretations of the right end's support. The first is the text's own, which gives the answers to case study 3; the 3D
#: reference has the first two.
END_SUPPORTS = (
    EndSupport("only ux held", "lin-case3-ux", "lin-case3-offset-ux", is_stated_by_text=True),
    EndSupport("ux and uy held", "lin-case3", "lin-case3-offset"),
    EndSupport("ux, uy and rotations held", "lin-case3-clamped", "lin-case3-offset-clamped"),
)


CASES = ("lin-case1", "lin-case2", *(name for r in END_SUPPORTS for name in (r.plain_scene, r.offset_scene)))


def load_ratio(load: Array) -> float:
    """Return the ratio of the largest to the smallest ball load on one flank; infinite if a ball carries no load.

    ``load``: loads of the n balls on this flank (n,) [N].
    """
    return float(load.max() / load.min()) if load.min() > 0.0 else float("inf")


def is_two_point_contact(load: Array) -> bool:
    """Return whether every ball carries load on the flanks SL and NR, and no ball on the flanks SR and NL.

    ``load``: contact loads (n, 4) [N] of n balls on the flanks SL, SR, NL and NR (screw or nut, left or right).
    """
    return bool(np.all(load[:, [0, 3]] > 0.0) and not np.any(load[:, [1, 2]] > 0.0))


def load_ratio_range_in_words(cache: SceneResultCache) -> str:
    """Return in words the range of the ratio of largest to smallest load in Lin's case 1, for two modelling choices varied.

    The modelling choices are the partition of the beam into elements, and whether equation C.8 for the beam's section is
    read with a square root. ``cache``: gives the solved scenes.
    """
    choices = product(("nodal", "source"), ("groove", "groove squared"))
    variants = [cache.scene_with_options("lin-case1", partition=p, section=s) for p, s in choices]
    ratios = [load_ratio(cache.solve_once(v).load[:, 0]) for v in variants]
    return f"{min(ratios):.4f} to {max(ratios):.4f} with the beam's partition and the reading of C.8"


def section_2_4_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Recompute the numbers printed in section 2.4.1 of Lin's thesis, and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds;
    ``cache``: gives solved scenes and stored 3D references.
    """
    _compute_case_1(cache, findings)
    _compute_case_2(cache, findings)
    _compute_case_3(cache, findings)
    _compare_with_ansys(cache, findings)
    elements, ansys, ours = (
        printed_value("lin-2.2", f"{k}") for k in ("elements_proposed", "time_ansys_1", "time_proposed_1")
    )
    findings.add_number("elements", float(lin_beam_element_count(cache)), follows=elements)
    words = "arithmetic of Table 2.2, case 1; run times of this project stand in table lin-2.2-times"
    findings.add_number("speed_ratio", None, words, follows=ansys * 3600.0 / ours)


def _compute_case_1(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Compute the ratio of largest to smallest load in Lin's case study 1; check two-point contact, lateral displacement.

    ``cache``: gives solved scenes and stored 3D references; ``findings``: receives the results.
    """
    load, line = cache.solve_once("lin-case1").load, cache.solve_once("lin-case1").centreline
    mei = cache.solve_once("lin-case1", "mei").load[:, 0]
    lateral = 1e6 * float(np.hypot(line[:, 0], line[:, 1]).max())
    run = cache.stored_reference("lin-case1")
    findings.add_number("case1_ratio", load_ratio(load[:, 0]), load_ratio_range_in_words(cache))
    if run is not None:
        in_3d, p = load_ratio(run.load[:, 0]), printed_entry("lin-2.4.1", "case1_ratio")
        side = "within" if (p.low or 0.0) <= in_3d <= (p.high or 0.0) else "outside"
        off = float(error_percent(in_3d, p.value or 0.0))
        words = f"our 3D reference, {in_3d:.4f}, is {side} {p.low:g} to {p.high:g} ({off:+.1f} %)"
        findings.add_number("case1_ratio_ansys", None, words, reference=in_3d)
    falling = f"{mei[0]:.1f} N at ball 1 falling at every ball to {mei[-1]:.1f} N at ball 32"
    findings.add_claim("case1_mei", bool(np.all(np.diff(mei) < 0.0)), falling)
    words = f"SL {count_in_words(load[:, 0] > 0)} loaded, SR {count_in_words(load[:, 1] > 0)}"
    findings.add_claim("case1_two_point", is_two_point_contact(load), words)
    words = f"largest lateral displacement of the centreline {lateral:.2f} um; 0 in the axial-only model"
    findings.add_claim("case1_lateral", lateral > 0.1, words)


def _compute_case_2(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Check the claim that in Lin's case study 2 the oversize ball 17 changes its own load only.

    ``cache``: gives the solved scenes; ``findings``: receives the results.
    """
    case1, case2 = (cache.solve_once(name).load[:, 0] for name in ("lin-case1", "lin-case2"))
    change = error_percent(case2, case1, float(case1.mean()))
    most = float(np.abs(np.delete(change, 16)).max())
    words = f"ball 17 {change[16]:+.1f} % of the mean load, every other ball within {most:.2f} %"
    findings.add_claim("case2_ball17", bool(change[16] > 5.0 * most), words)


def _compute_case_3(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Check Lin's claims on four-point contact and on the last balls in his case study 3.

    In this case study the right end of the screw is displaced laterally, and the loads of the last balls rise most.
    ``cache``: gives the solved scenes. ``findings``: receives the results.
    """
    smallest = [float(cache.solve_once(name).load.min()) for name in CASES[2:]]
    words = f"smallest load of any contact for all supports of the right end {min(smallest):.1f} N"
    findings.add_claim("case3_four_point", min(smallest) > 0.0, words)
    rise = [cache.solve_once(r.offset_scene).load - cache.solve_once(r.plain_scene).load for r in END_SUPPORTS]
    last = [int(np.argsort(x[:, 1] + x[:, 2])[-3:].min()) + 1 for x in rise]
    places = ", ".join(f"{ball} and up ({r.restraint})" for ball, r in zip(last, END_SUPPORTS, strict=True))
    words = f"the three largest rises of SR + NL are at balls {places}"
    findings.add_claim("case3_last_balls", all(x >= 30 for x in last), words)


def _compare_with_ansys(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Compute the errors of Lin's model against the 3D reference, to compare with those that he prints against ANSYS.

    Lin prints only the errors against ANSYS, not its loads. ``findings``: receives the results; ``cache``: gives solved
    scenes and stored 3D references.
    """
    every = [c.errors_percent for c in cache.compute_once(evaluate_explanations)]
    explained = dict(zip(ERRORS, zip(*every, strict=True), strict=True))
    for name, (largest, rms, _) in PRINTED.items():
        found = cache.stored_reference(name)
        if found is None:
            continue
        e = load_error(cache.solve_once(name).load, found.load, found.contacts)
        for key, error, mean in ((largest, e.own_max_percent, e.max_percent), (rms, e.own_rms_percent, e.rms_percent)):
            words = (
                "computed here: Lin's model against this project's 3D reference, in per cent of each load "
                f"({mean:.2f} % of the mean load); Lin's ANSYS loads are not printed"
            )
            others = f"explanations of the printed errors give {min(explained[key]):.2f} to {max(explained[key]):.2f} %"
            findings.add_number(key, error, f"{words}; {others} (section reconstruction)")


# --- case study 1 under the choices that the thesis leaves open, and under its faults


#: Choices that the thesis leaves open, and its faults, in case study 1: in words; conformity of the grooves, None: as in
#: the scene; changed options of the model; name of the model. The first has all choices by default.
CASE_1_CHOICES: tuple[tuple[str, float | None, dict[str, Any], str], ...] = (
    ("default: node at every contact, C.8 with its root, right Hertz constants", None, {}, "lin"),
    ("Lin's partition of the beam (elements of 15 mm in the nut)", None, {"partition": "source"}, "lin"),
    ("C.8 read without the root", None, {"section": "groove squared"}, "lin"),
    ("groove ignored in the beam's section", None, {"section": "full"}, "lin"),
    (
        "Lin's partition of the beam and C.8 without the root",
        None,
        {"partition": "source", "section": "groove squared"},
        "lin",
    ),
    ("Hertz constants as printed (faults of Table B.1)", None, {"hertz": "as printed"}, "lin"),
    ("groove radius 0.56 x diameter, right Hertz constants", TABLE_CONFORMITY, {}, "lin"),
    ("groove radius 0.56 x diameter, as printed (Table B.1 itself)", TABLE_CONFORMITY, {"hertz": "as printed"}, "lin"),
    ("Hertz constants at each contact's actual geometry", None, {"hertz": "actual"}, "lin"),
    ("lever arm frozen at the nominal contact point", None, {"arm": "nominal"}, "lin"),
    ("contact force acts on the beam at the ball's axial position, not the contact's", None, {"arm": "ball"}, "lin"),
    ("Lin's own equations (lever arm and axial position of the force follow the contact angle)", None, {}, "source"),
    ("axial bars only, rigid nut (Mei)", None, {}, "mei"),
    ("axial bars only, nut an elastic bar (Mei)", None, {}, "mei-nut"),
)


def model_choice_rows(cache: SceneResultCache) -> Iterator[Row]:
    """Yield the table rows of Lin's case 1, one for each modelling choice: loads, largest change, axial displacement.

    Changes are from the loads with all choices by default. ``cache``: gives the solved scenes.
    """
    for words, conformity, options, model in CASE_1_CHOICES:
        scene = cache.scene_with_options("lin-case1", **options)
        result = cache.solve_once(scene if conformity is None else with_conformity(scene, conformity), model)
        change = load_error(result.load, cache.solve_once("lin-case1").load)
        yield {
            "modelling_choice": words,
            "largest_load": float(result.load.max()),
            "smallest_load": float(result.load[:, 0].min()),
            "load_ratio": load_ratio(result.load[:, 0]),
            "largest_change_f3": change.max_percent,
            "rms_change_f3": change.rms_percent,
            "screw_displacement": 1e6 * float(result.centreline[0, 2]),
            "status": result.status,
        }


# --- section 2.4.2, geometric errors: printed numbers and claims; those on random errors need randomly drawn screws


#: Change of a contact load [% of the mean load] above which a load distribution counts as significantly changed: twice the
#: largest error that Lin reports for his model (5.38 %).
SIGNIFICANT = 2.0 * 5.38
#: Fraction of the randomly drawn screws for which a claim on random errors must hold.
SEEN = 0.05


def section_2_4_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Recompute the numbers printed in section 2.4.2 of Lin's thesis, and check its claims on geometric errors.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    Claims on random errors stay open if ``cache`` draws no random screws.
    """
    groove = screw_groove_section(cache.built_in_scene("lin-case1"))
    findings.add_number("gamma_low", groove.apex_angle / np.pi, "Lin C.5")
    findings.add_number("gamma_high", groove.edge_angle / np.pi, "Lin C.5")
    _record_error_amplitudes(cache, findings)
    _check_single_error_claims(cache, findings)
    if cache.random_draw_count != 0:
        _check_random_error_claims(cache, findings)


def _record_error_amplitudes(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Record the amplitudes of the geometric errors that Lin prints, as the scenes contain them.

    ``cache``: gives the scenes included with rollbench; ``findings``: receives the amplitudes, in the printed units.
    """
    profile, pitch = (cache.built_in_scene(name).errors for name in ("lin-profile", "lin-pitch"))
    for side in SIDES:
        findings.numbers({f"profile_{side}_{k}": 1e6 * c for k, c in enumerate(profile.side(side).profile)})
        findings.add_number(f"pitch_{side}", 1e6 * pitch.side(side).pitch[0].sin)
    findings.add_number("random_sigma", 1e6 * cache.built_in_scene("lin-random").errors.balls.sigma)


def _check_single_error_claims(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Check Lin's claims on contact loads with profile errors only and with pitch errors only.

    ``cache``: gives the solved scenes; ``findings``: receives the results.
    """
    base, profile, pitch = (cache.solve_once(name).load for name in ("lin-case1", "lin-profile", "lin-pitch"))
    for name, load in (("profile", profile), ("pitch", pitch)):
        words = f"SL {count_in_words(load[:, 0] > 0)}, SR {count_in_words(load[:, 1] > 0)} loaded"
        findings.add_claim(f"{name}_two_point", is_two_point_contact(load), words)
    little, much = load_error(profile, base), load_error(pitch, base)
    words = f"largest change {little.max_percent:.2f} % of the mean load (pitch errors: {much.max_percent:.1f} %)"
    findings.add_claim("profile_little", little.max_percent < SIGNIFICANT, words)
    words = f"largest change {much.max_percent:.1f} % of the mean load, ball {much.ball} {much.side}"
    findings.add_claim("pitch_much", much.max_percent > SIGNIFICANT, words)


def _check_random_error_claims(cache: SceneResultCache, findings: ComputedEntryValues) -> None:
    """Check Lin's claims on contact loads with random ball errors, on many randomly drawn screws.

    ``cache``: gives the solved scenes and the randomly drawn screws; ``findings``: receives the results.
    """
    base = cache.solve_once("lin-case1").load
    random, combined = (
        cache.compute_once(random_draws_of_built_in_scene, name).loads for name in ("lin-random", "lin-combined")
    )
    kept = np.array([is_two_point_contact(load) for load in random])
    findings.add_claim("random_two_point", bool(kept.mean() > SEEN), f"holds in {count_in_words(kept)} drawn screws")
    changed = np.array([load_error(load, base).max_percent for load in random])
    low, high = np.percentile(changed, [5, 95])
    words = (
        f"largest change {low:.0f} to {high:.0f} % of the mean load in nine of ten drawn screws; significant in "
        f"{count_in_words(changed > SIGNIFICANT)}"
    )
    findings.add_claim("random_much", bool((changed > SIGNIFICANT).mean() > SEEN), words)
    four = np.array([bool(np.any(load[:, [1, 2]] > 0.0)) for load in combined])
    words = f"some ball carries on SR or NL in {count_in_words(four)} drawn screws"
    findings.add_claim("combined_four_point", bool(four.mean() > SEEN), words)


SCREWS = {"4p1": "Table 4.1", "2p1": "Table 2.1"}
#: Changes of all ball radii [m], at which the claim of two-point contact is checked.
CLEARANCES = (0.0, -1e-6, -2e-6, -3e-6, -4e-6, -5e-6)


def relative_load_scatter(result: StaticResult) -> float:
    """Return the standard deviation of the contact loads on flank SL (left flank of the screw), divided by their mean."""
    return float(result.load[:, 0].std() / result.load[:, 0].mean())


def balls_without_load(result: StaticResult) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return for each ball of a static solution whether it carries no load, (n,) for n balls."""
    return np.asarray(result.load.sum(axis=1) == 0.0)


def dominant_harmonic_of_unloaded_balls(
    scene: Scene, unloaded: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> tuple[int, float]:
    """Return the strongest Fourier harmonic in the pattern of unloaded balls around the screw.

    First: number of its cycles per turn, 1 to 4 (0 if no ball is unloaded); second: its power divided by the power of all
    four harmonics. ``scene``: the screw with its balls; ``unloaded``: for each ball (n,), whether it is unloaded.
    """
    phi = ball_layout(scene).azimuth
    x = unloaded.astype(float) - unloaded.mean()
    power = np.array([np.abs((x * np.exp(-1j * k * phi)).sum()) ** 2 for k in range(1, 5)])
    if power.sum() == 0.0:
        return 0, 0.0
    return int(power.argmax()) + 1, float(power.max() / power.sum())


def scenes_with_unprinted_inputs_varied(scene: Scene) -> list[tuple[str, Scene]]:
    """Return copies of a scene, each with a label: unchanged, then with one input changed that Lin does not print."""
    rotation = (Support(0.0, (("rz", 0.0),)),)
    lateral = (Support(0.0, (("ux", 0.0), ("uy", 0.0), ("rz", 0.0))),)
    no_right = replace(scene.errors, SR=SideErrors())
    out = [
        ("as shipped: left end clamped but for axial motion", scene),
        ("left end: only rotation about the axis held", replace(scene, supports=rotation)),
        ("left end: lateral displacement and rotation about the axis held", replace(scene, supports=lateral)),
        ("error on SL only, as the formula is printed", replace(scene, errors=no_right)),
    ]
    for c in CLEARANCES[1:]:
        errors = replace(scene.errors, balls=replace(scene.errors.balls, oversize=c))
        out.append((f"ball radius smaller by {-1e6 * c:.0f} um", replace(scene, errors=errors)))
    return out


def section_4_3_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Recompute the numbers printed in section 4.3.2 of Lin's thesis, and check its claims on manufacturing errors.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds;
    ``cache``: gives the solved scenes.
    """
    pitch, roundness = cache.built_in_scene("lin-pitch-4p1"), cache.built_in_scene("lin-roundness-4p1")
    findings.add_number("e_p", 1e6 * pitch.errors.SL.pitch[0].sin, "key of the scene")
    findings.add_number("e_R", 1e6 * roundness.errors.SL.roundness[0].sin, "key of the scene")
    findings.add_number("force", pitch.loads[0].force[2], "key of the scene")
    for screw in SCREWS:
        _check_manufacturing_error_claims(cache, findings, screw)


def _check_manufacturing_error_claims(cache: SceneResultCache, findings: ComputedEntryValues, screw: str) -> None:
    """Check the claims of section 4.3.2 of Lin's thesis on pitch and on roundness errors, for one screw.

    The claims are on two-point contact, uneven loads and unloaded balls; ``screw``: key of `SCREWS`. ``cache``: gives the
    solved scenes. ``findings``: receives the results.
    """
    pitch, roundness = cache.solve_once(f"lin-pitch-{screw}"), cache.solve_once(f"lin-roundness-{screw}")
    third = [float(r.load[:, [1, 2]].max()) for r in (pitch, roundness)]
    words = (
        f"a third contact carries up to {third[0]:.1f} N (pitch) and {third[1]:.1f} N (roundness); "
        "with clearance it vanishes, see table manufacturing-readings"
    )
    findings.add_claim(f"two_point_{screw}", max(third) == 0.0, words)
    words = (
        f"standard deviation over mean {relative_load_scatter(roundness):.2f} with roundness, "
        f"{relative_load_scatter(pitch):.2f} with pitch error"
    )
    findings.add_claim(f"less_uniform_{screw}", relative_load_scatter(roundness) > relative_load_scatter(pitch), words)
    lost = balls_without_load(roundness)
    words = f"{count_in_words(lost)} balls without contact; with pitch error {count_in_words(balls_without_load(pitch))}"
    findings.add_claim(f"lost_{screw}", bool(lost.any()), words)
    count, power = dominant_harmonic_of_unloaded_balls(cache.built_in_scene(f"lin-roundness-{screw}"), lost)
    words = f"{power:.0%} of the pattern's power is at {count} cycles per turn" if lost.any() else "no ball loses contact"
    findings.add_claim(f"pattern_{screw}", bool(lost.any()) and count == 2, words)
