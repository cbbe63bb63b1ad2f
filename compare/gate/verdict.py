"""Verdicts on contact loads and other quantities, from the error against a reference, its uncertainty, and a limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np

from rollbench.compare.gate import judged as gate_judged
from rollbench.compare.measure import SMALL, LoadError, error_percent, load_error, mask_of_loaded_contacts, mean_load
from rollbench.compare.models.comparison import RULE, ContactError, ContactSolution, contact_load_errors
from rollbench.compare.models.loads_file import ContactLoadsFromFile
from rollbench.compare.quantities import json_number, words_and_unit_of_key
from rollbench.compare.reference.estimate import Reference
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_or_none, result_record
from rollbench.meshes.quantity import quantity_field as stated

#: Default limit of the largest contact-load error [%].
LIMIT = 7.0


class Judgement(StrEnum):
    """Judgement of a quantity by its error e against a reference, the reference's uncertainty u, and the error's limit.

    Only `PASS` is true, so that an ``assert`` of a judgement fails on every other one.
    """

    PASS = "pass"
    """The error is within the limit even with the uncertainty added: e + u <= limit."""
    FAIL = "fail"
    """The error is beyond the limit even with the uncertainty subtracted: e - u > limit."""
    NOT_CONVERGED = "not converged"
    """The model found no equilibrium in the load case."""
    UNDECIDED = "undecided"
    """The limit lies between e - u and e + u: the reference is not accurate enough to decide."""
    NOT_COVERED = "not covered"
    """The reference has no value of the quantity."""

    def __bool__(self) -> bool:
        """Whether the judgement is `PASS`."""
        return self is Judgement.PASS


#: Exit code of each judgement, the worst one first; of several judgements the worst determines the exit code.
CODES = {Judgement.FAIL: 1, Judgement.NOT_CONVERGED: 1, Judgement.UNDECIDED: 3, Judgement.NOT_COVERED: 4, Judgement.PASS: 0}

#: Number of balls that a figure shows before, and after, the ball that determines the verdict.
NEAR = 6

#: For each of these balls: number of the ball from 1, judged load, reference load, uncertainty of the latter [N].
NeighbouringLoads: TypeAlias = tuple[tuple[int, float, float, float], ...]

#: Size in newtons of other units in which a user's contact loads may be by mistake.
UNITS = {"kilonewtons": 1e3, "pounds": 4.4482216152605, "kiloponds": 9.80665, "millinewtons": 1e-3}

#: Largest relative difference [1] between the ratio of reference to judged loads and the size of another unit in newtons
#: at which the judged loads are suspected to be in that unit.
ALIKE = 0.2

#: Name of the quantity of a verdict on the largest contact-load error.
LARGEST = "largest error of a contact load"

#: Name of the quantity of a verdict on the root mean square of all contact-load errors.
RMS = "RMS error of the contact loads"

#: Note on a 3D reference that was computed on a single mesh level.
ONE_LEVEL = "one mesh level: its uncertainty is estimated from other scenes; two or three levels measure it"


@dataclass(frozen=True)
class ErrorLimits:
    """Error limits of a scene: in per cent, or in degrees for contact angles."""

    #: Limit of the largest error of a contact load [% of its reference load; of the mean load for loads below a tenth of
    #: it].
    largest_load_error: float = LIMIT
    #: Limit of the root mean square error of the loads [% of the mean load]; None: not judged.
    rms_load_error: float | None = None
    #: Limits of other quantities, by name of the quantity (`gate.judged`).
    limits_by_quantity: Mapping[str, float] = field(default_factory=dict)

    def limit_of(self, quantity: gate_judged.JudgedQuantity) -> float:
        """Return the error limit of a quantity other than a contact load [%; deg for angles]: the stated or default one.

        The default of most quantities is a multiple of the limit of the contact loads.
        """
        default = quantity.default_limit
        default = quantity.default_limit_ratio * self.largest_load_error if default is None else default
        return self.limits_by_quantity.get(quantity.name, default)


def subject_text(scene: str, case: str | None, set_: str | None) -> str:
    """Return the names of scene, load ``case`` and nut or bearing (``set_``) as one text, without those that are None."""
    return ", ".join(filter(None, (scene, case, set_)))


@result_record
class VerdictRow:
    """Judgement of one quantity of a scene, of a load case, or of one nut or bearing out of several; true if it passes."""

    scene: str
    """Name of the scene."""
    judged: str
    """Name of the model or of the file whose values are judged."""
    quantity: str
    """Name of the judged quantity, such as "largest error of a contact load"."""
    judgement: Judgement
    """Judgement of the quantity."""
    error: float | None = stated(
        "error_percent",
        "error of the judged quantity in per cent of the reference value; for contact loads below a tenth of the mean "
        "load in per cent of the mean load",
        QuantityDescription(
            "error_deg",
            "error of the contact angle that determines the verdict, of contacts loaded in both results",
            error="`uncertainty_deg` beside it",
        ),
        error="`uncertainty_percent` beside it",
    )
    """Error of the quantity, or of the contact that determines the judgement [unit]; None if nothing could be compared."""
    uncertainty: float | None = stated("uncertainty_deg", "uncertainty of the reference's contact angle, by discretisation")
    """Uncertainty of the reference for the judged quantity or contact [unit]; None if not known."""
    limit: float = stated(
        "limit_percent",
        "error limit of the scene or of the command line",
        QuantityDescription("limit_deg", "error limit of the contact angle, 1 deg unless given"),
    )
    """Largest permitted error [unit]."""
    ball: int | None = None
    """Number of the ball, from 1, of the contact that determines the judgement; None for quantities of the whole scene."""
    side: str | None = None
    """Groove flank of the contact that determines the judgement: SL, SR, NL or NR; None for quantities of the whole
    scene."""
    levels: tuple[int, ...] = ()
    """Mesh levels of the 3D reference."""
    contacts: int = 0
    """Number of judged contacts."""
    detail: str = ""
    """Further explanation of the judgement; may be empty."""
    of_mean: LoadError | None = quantity_or_none(
        "max_percent_of_mean",
        "error of the worst contact load in per cent of the mean load",
        QuantityDescription("rms_percent_of_mean", "root mean square over all contacts, in per cent of the mean load"),
    )
    """Largest and RMS error of the contact loads in per cent of the mean load; None for other quantities."""
    set: str | None = None
    """Name of the nut or bearing; None if the scene has only one."""
    case: str | None = None
    """Name of the load case; None without load cases."""
    unit: str = "%"
    """Unit of error, uncertainty and limit: ``%`` of the reference value (for small contact loads, of the mean load), or
    the unit in which the limit is stated, such as ``deg``."""
    pair: tuple[str, float, float] | None = None
    """JSON key of the quantity, which ends with the unit of the two values, its judged value and its value in the
    reference; None for contact loads."""
    near: NeighbouringLoads = ()
    """Judged and reference loads on one flank: at the contact that determines the judgement, and on the balls before and
    after: number of the ball, judged load, reference load and its uncertainty [N]."""

    def __bool__(self) -> bool:
        """Whether the quantity passes."""
        return bool(self.judgement)

    @property
    def passed(self) -> bool:
        """Whether the quantity passes."""
        return bool(self.judgement)

    @property
    def subject(self) -> str:
        """Names of the judged scene, load case and nut or bearing, as one text."""
        return subject_text(self.scene, self.case and f"case {self.case}", self.set)

    def as_json(self) -> dict[str, Any]:
        """Return the verdict as a dictionary for JSON, in which the keys of numbers end with their unit.

        Keys that end with ``percent`` are null for a quantity that is judged in another unit.

        Returns
        -------
        dict
            JSON values by key.
        """
        data: dict[str, Any] = {"scene": self.scene, "judged": self.judged, "quantity": self.quantity}
        data["word"] = str(self.judgement)
        for key in ("error", "uncertainty", "limit"):
            data[f"{key}_percent"] = getattr(self, key) if self.unit == "%" else None
            if self.unit != "%":
                data[f"{key}_{self.unit}"] = getattr(self, key)
        data |= {"ball": self.ball, "flank": self.side, "levels": list(self.levels), "contacts": self.contacts}
        data["detail"] = self.detail
        data |= {key: name for key, name in (("set", self.set), ("case", self.case)) if name is not None}
        e = self.of_mean
        data |= {"max_percent_of_mean": e and e.max_percent, "rms_percent_of_mean": e and e.rms_percent}
        return data if self.pair is None else data | dict(zip(("key", "value", "reference"), self.pair, strict=True))

    @property
    def line(self) -> str:
        """The judgement as one line of text: scene, model or file, errors, uncertainty and limit."""
        head = f"{self.judgement.upper()}: {self.subject}, {self.judged}"
        if self.error is None:
            of = "" if self.quantity == LARGEST else f"{self.quantity}: "
            return f"{head}: {of}{self.detail}"
        at = "" if self.ball is None else f" (ball {self.ball} {self.side})"
        tail = f"; {self.detail}" if self.detail else ""
        if self.of_mean is None:
            pair = f", {self.pair_text}" if self.pair_text else ""
            return f"{head}: {self.quantity} {self.comparison_text()}{at}{pair}{tail}"
        e = self.of_mean
        whole = f"{e.max_percent:.2f} % of the mean load (ball {e.ball} {e.side}), {e.rms_percent:.2f} % RMS"
        return f"{head}: {self.quantity} {self.comparison_text()}{at}, {RULE}; {whole}{tail}"

    @property
    def pair_text(self) -> str:
        """Text that compares the judged value with the reference's value, with the unit; empty for contact loads."""
        if self.pair is None:
            return ""
        key, value, reference = self.pair
        return f"{value:.4g} against {reference:.4g} {words_and_unit_of_key(key)[1]}"

    @property
    def note(self) -> str:
        """Judged value and reference, and the further explanation, as one text; may be empty."""
        return "; ".join(filter(None, (self.pair_text, self.detail)))

    def comparison_text(self) -> str:
        """Return error, uncertainty and limit as a comparison, such as ``1.4 % + 0.2 % <= 7 %`` for "pass".

        Returns
        -------
        str
            The text.
        """
        error, limit = f"{abs(self.error or 0.0):.2f} {self.unit}", f"{self.limit:.4g} {self.unit}"
        if self.uncertainty is None:
            return f"{error}, uncertainty unknown, limit {limit}"
        u = f"{self.uncertainty:.2f} {self.unit}"
        if self.judgement is Judgement.PASS:
            return f"{error} + {u} <= {limit}"
        return f"{error} - {u} > {limit}" if self.judgement is Judgement.FAIL else f"{error} +- {u}, limit {limit}"


def verdict_on_error(error: float, uncertainty: float | None, limit: float) -> Judgement:
    """Return the verdict on an error, given the uncertainty of the reference and a limit: pass, fail or undecided.

    Parameters
    ----------
    error
        Error against the reference, in any unit.
    uncertainty
        Uncertainty of the reference, in the same unit; None: not known.
    limit
        Limit of the error, in the same unit.

    Returns
    -------
    Judgement
        "pass" if abs(error) + uncertainty is within the limit, "fail" if abs(error) - uncertainty exceeds it; otherwise, or
        if the uncertainty is not known, "undecided".

    Examples
    --------
    >>> verdict_on_error(-6.0, 0.5, 7.0), verdict_on_error(6.8, 0.5, 7.0), verdict_on_error(8.0, 0.5, 7.0)
    (<Judgement.PASS: 'pass'>, <Judgement.UNDECIDED: 'undecided'>, <Judgement.FAIL: 'fail'>)
    """
    if uncertainty is None:
        return Judgement.UNDECIDED
    if abs(error) + uncertainty <= limit:
        return Judgement.PASS
    return Judgement.FAIL if abs(error) - uncertainty > limit else Judgement.UNDECIDED


def decisive_contact(points: Sequence[ContactError], limit: float) -> tuple[Judgement, ContactError]:
    """Return the worst verdict on any contact, and the contact that determines it.

    ``points``: errors of all judged contacts; ``limit``: error limit, in the unit of these errors. The decisive contact is
    the one that exceeds the limit by most; if none exceeds it, the one nearest to the limit.
    """
    each = [verdict_on_error(p.error, p.uncertainty, limit) for p in points]
    worst = worst_judgement(each)
    sign = -1.0 if worst is Judgement.FAIL else 1.0
    gravest = [p for p, kind in zip(points, each, strict=True) if kind == worst]
    return worst, max(gravest, key=lambda p: abs(p.error) + sign * float(np.nan_to_num(p.uncertainty)))


def verdict_not_covered(
    judged: str, quantity: str, limit: float, why: str, scene: str, levels: tuple[int, ...] = (), unit: str = "%"
) -> VerdictRow:
    """Return the verdict on a quantity that has no value in the reference, or whose scene has no reference.

    ``judged``: name of the model or of the file; ``limit``: error limit [unit]; ``why``: the reason; ``scene``: name of the
    scene; ``levels``: mesh levels of the reference.
    """
    word = Judgement.NOT_COVERED
    return VerdictRow(scene, judged, quantity, word, None, None, limit, levels=levels, detail=why, unit=unit)


def judge_contact_loads(
    judged: str, load: Array, reference: Reference, limits: ErrorLimits, flanks: Sequence[str] = SIDES, detail: str = ""
) -> list[VerdictRow]:
    """Judge the contact loads of a model or file against a reference, by their largest error and their RMS error.

    Parameters
    ----------
    judged
        Name of the model or file whose loads are judged.
    load
        Contact loads of n balls on 4 flanks, (n, 4) [N].
    reference
        Reference loads with their uncertainty.
    limits
        Error limits of the scene.
    flanks
        Flanks that are judged; loads on the others are not used. For the mean load, the sum of their loads is divided by
        the number of contacts `Reference.contacts` times the ratio of loaded contacts on the judged flanks to all loaded
        contacts of the reference.
    detail
        Text that is added to the explanation of the verdict.

    Returns
    -------
    list[VerdictRow]
        Verdict on the largest error; also one on the RMS error if that has a limit.
    """
    chosen = np.array([side in flanks for side in SIDES])
    name, limit, rms_limit = reference.scene, limits.largest_load_error, limits.rms_load_error
    points = [p for p in contact_load_errors(reference, load) if p.side in flanks]
    if not points:
        why = f"the reference has no contact load on the flanks {', '.join(flanks)}"
        return [verdict_not_covered(judged, LARGEST, limit, why, name, reference.levels)]
    reached = mask_of_loaded_contacts(reference.load)
    contacts = round(reference.contacts * np.count_nonzero(reached[:, chosen]) / np.count_nonzero(reached))
    of_mean = load_error(np.where(chosen, load, 0.0), np.where(chosen, reference.load, 0.0), contacts)
    kind, at = decisive_contact(points, limit)
    words = "; ".join(filter(None, (detail, reference_notes(reference))))
    shared: dict[str, Any] = {"levels": reference.levels, "contacts": len(points), "detail": words}
    first = VerdictRow(
        name, judged, LARGEST, kind, at.error, json_number(at.uncertainty), limit, at.ball, at.side, **shared
    )
    out = [replace(first, of_mean=of_mean, near=_loads_of_neighbouring_balls(load, reference, at))]
    if rms_limit is not None:
        error, bar = of_mean.rms_percent, reference.parts.uncertainty
        kind = verdict_on_error(error, bar, rms_limit)
        out.append(VerdictRow(name, judged, RMS, kind, error, bar, rms_limit, **shared))
    return out


def _loads_of_neighbouring_balls(load: Array, reference: Reference, at: ContactError) -> NeighbouringLoads:
    """Return the judged and reference loads on the flank of a contact, of up to `NEAR` balls before it and after it.

    ``at``: the contact. Each entry is (number of the ball from 1, judged load, reference load, uncertainty of the reference
    load), loads in N.
    """
    s, balls = SIDES.index(at.side), range(max(at.ball - 1 - NEAR, 0), min(at.ball + NEAR, len(load)))
    return tuple((k + 1, float(load[k, s]), float(reference.load[k, s]), float(reference.uncertainty[k, s])) for k in balls)


def reference_notes(reference: Reference) -> str:
    """Return remarks on a reference as text: its origin, incomplete convergence, a single mesh level; may be empty."""
    single = ONE_LEVEL if reference.parts.is_from_other_scenes and not reference.stated else ""
    return "; ".join(filter(None, (reference.stated, reference.unsettled, single)))


def worst_judgement(judgements: Sequence[Judgement]) -> Judgement:
    """Return the worst of several judgements; `CODES` lists them from the worst to "pass"."""
    return next((x for x in CODES if x in judgements), Judgement.PASS)


def suspected_cause_text(load: Array, reference: Array, flanks: Sequence[str], limit: float) -> str:
    """Return the likely cause if load errors exceed the limit: wrong unit, other numbering of balls, or swapped flanks.

    Parameters
    ----------
    load
        Contact loads of n balls on 4 flanks, (n, 4) [N].
    reference
        Reference loads, (n, 4) [N].
    flanks
        Flanks that are judged.
    limit
        Limit of the largest error [% of the mean load].

    Returns
    -------
    str
        Sentence with the likely cause; empty if the limit holds or no cause is recognised.
    """
    sides = [SIDES.index(side) for side in flanks]
    given, right = load[:, sides], reference[:, sides]
    mean = mean_load(right)
    if mean == 0.0 or not given.any() or _largest_error_percent(given, right, mean) <= limit:
        return ""
    for name, newton in UNITS.items():
        if abs(float(given.sum()) * newton / float(right.sum()) - 1.0) < ALIKE:
            return f"the loads look like {name}: in newtons they are {newton:g} times as large"
    if _largest_error_percent(np.sort(given, axis=0), np.sort(right, axis=0), mean) <= limit:
        reverse = "in reverse order" if _largest_error_percent(given[::-1], right, mean) <= limit else "in another order"
        return (
            f"the same loads are on other balls, which look numbered {reverse}: add the columns azimuth_deg and z_mm, so "
            "that balls are matched by position"
        )
    swapped = {"SL": "SR", "SR": "SL", "NL": "NR", "NR": "NL"}
    other = reference[:, [SIDES.index(swapped[side]) for side in flanks]]
    if other.any() and _largest_error_percent(given, other, mean_load(other)) <= limit:
        return "the loads look like those of the opposite flanks: check left and right, as seen along +z"
    return ""


def _largest_error_percent(given: Array, right: Array, mean: float) -> float:
    """Return the largest absolute difference of loads (``given``) from reference loads (``right``) [% of ``mean``]."""
    return float(np.abs(error_percent(given, right, mean)).max())


#: Remark on approaches and pressures that are computed from the reference's contact loads.
BY_HERTZ = "reference value computed by Hertz theory from its contact loads and the radii of each contact"


def contact_values_by_model(scene: Scene, answer: ContactSolution, limits: Mapping[str, float]) -> ContactLoadsFromFile:
    """Return a model's contact loads, and those of its contact angles, approaches and pressures that have an error limit.

    ``answer``: results of the model; ``limits``: error limits by name of the quantity.
    """
    of_model, further = {"angle": np.radians(answer.angle), "pressure": answer.pressure}, {}
    for name, q in gate_judged.OF_CONTACTS.items():
        if q.name in limits:
            given = of_model.get(name)
            further[name] = gate_judged.hertz_approach_or_pressure(scene, q, answer.load) if given is None else given
    return ContactLoadsFromFile(answer.load, SIDES, further_quantities=further)


def screw_values_by_model(
    scene: Scene, answer: ContactSolution, limits: Mapping[str, float]
) -> list[gate_judged.UserValue]:
    """Return a model's values of the quantities of the whole screw (such as life or rigidity) that have an error limit.

    ``answer``: results of the model; ``limits``: error limits by name of the quantity.
    """
    whole = gate_judged.WholeScrewEvaluation(scene)
    values = ((q, whole.value_of(q, answer)) for q in gate_judged.OF_WHOLE if q.name in limits)
    return [gate_judged.UserValue(q, value) for q, value in values if value is not None]


def judge_contact_quantities(
    judged: str, given: ContactLoadsFromFile, scene: Scene, ref: Reference, limits: ErrorLimits
) -> list[VerdictRow]:
    """Judge contact angles, approaches and pressures against the reference, each by the contact with the worst error.

    ``judged``: name of the model or file; ``given``: its values on all contacts; ``ref``: the reference. Quantities that
    are not stated, and angles that the reference does not have, are left out.
    """
    without = {"angle"} if not np.isfinite(ref.best.angle).any() else set()
    names = [name for name in gate_judged.OF_CONTACTS if name in given.further_quantities.keys() - without]
    return [_judge_contact_quantity(judged, given, name, scene, ref, limits) for name in names]


def _judge_contact_quantity(
    judged: str, given: ContactLoadsFromFile, name: str, scene: Scene, ref: Reference, limits: ErrorLimits
) -> VerdictRow:
    """Judge one contact quantity (angle, approach or pressure) by the contact with the worst error.

    ``judged``: name of the model or file; ``given``: its values; ``name``: key of the quantity in `OF_CONTACTS`; ``ref``:
    the reference; ``limits``: error limits. Errors of approach and pressure are in per cent of the reference value of the
    contact; for contacts with less than a tenth of the mean load, in per cent of the value at the mean load. Errors of
    angles are in degrees, on contacts that bear load both in the reference and in the judged values.
    """
    q, value = gate_judged.OF_CONTACTS[name], given.further_quantities[name]
    limit, unit, notes = limits.limit_of(q), "deg" if q is gate_judged.ANGLE else "%", [reference_notes(ref)]
    reference, bars = gate_judged.contact_quantity_of_reference(scene, ref, q)
    chosen = np.array([side in given.flanks_with_rows for side in SIDES])
    if q is gate_judged.ANGLE:
        judge = mask_of_loaded_contacts(ref.load) & mask_of_loaded_contacts(given.load) & chosen & np.isfinite(reference)
        errors, shares = np.degrees(value - reference), np.degrees(bars)
    else:
        judge = ((ref.load > 0.0) | (value > 0.0)) & chosen
        value = np.where(np.isnan(value) & (given.load == 0.0), 0.0, value)  # of a contact that is lost
        mean = gate_judged.hertz_approach_or_pressure(scene, q, np.full(value.shape, ref.mean))
        scale = np.where(ref.load >= SMALL * ref.mean, reference, mean)
        errors, shares = error_percent(value, reference, scale), error_percent(bars, 0.0, scale)
    if not judge.any():
        why = f"no contact of the flanks {', '.join(given.flanks_with_rows)} is loaded"
        return verdict_not_covered(judged, q.name, limit, why, ref.scene, ref.levels, unit)
    points = [
        ContactError(float(errors[i, s]), float(shares[i, s]), int(i) + 1, SIDES[s])
        for i, s in zip(*np.nonzero(judge), strict=True)
    ]
    kind, at = decisive_contact(points, limit)
    k = at.ball - 1, SIDES.index(at.side)
    pair = (q.key, q.display_factor * float(value[k]), q.display_factor * float(reference[k]))
    if q is not gate_judged.ANGLE and q.name not in ref.further:
        notes.insert(0, BY_HERTZ)
    where = (at.ball, at.side, ref.levels, len(points), "; ".join(filter(None, notes)))
    return VerdictRow(
        ref.scene, judged, q.name, kind, at.error, json_number(at.uncertainty), limit, *where, unit=unit, pair=pair
    )


def judge_value(judged: str, given: gate_judged.UserValue, scene: Scene, ref: Reference, limits: ErrorLimits) -> VerdictRow:
    """Judge a value of the whole screw (such as its life or rigidity) against that of the reference.

    ``judged``: name of the model or file that states the value ``given``; ``ref``: the reference. The error is in per cent
    of the reference value.
    """
    whole, q = gate_judged.WholeScrewEvaluation(scene), given.quantity
    limit = limits.limit_of(q)
    reference, bar = whole.reference_value_and_uncertainty(q, ref, given.station)
    if not reference:
        why = f"no {q.name}: {whole.reason_without_value(q, ref)}"
        return verdict_not_covered(judged, given.name, limit, why, ref.scene, ref.levels)
    error = float(error_percent(given.value, reference))
    share = None if bar is None else float(error_percent(bar, 0.0, reference))
    detail = "; ".join(filter(None, (whole.computation_note(q, given.station), reference_notes(ref))))
    pair = (q.key, q.display_factor * given.value, q.display_factor * reference)
    kind = verdict_on_error(error, share, limit)
    return VerdictRow(ref.scene, judged, given.name, kind, error, share, limit, levels=ref.levels, detail=detail, pair=pair)


def quantities_without_verdict(verdicts: Sequence[VerdictRow]) -> list[str]:
    """Return the names of the quantities (of all in `QUANTITIES`) on which ``verdicts`` contains no verdict."""
    return [name for name in gate_judged.QUANTITIES if not any(v.quantity.split(" at ")[0] == name for v in verdicts)]
