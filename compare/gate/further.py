"""Verdicts on what stands beside contact loads: angle, approach and pressure of every contact, and the whole screw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rollbench.compare.gate.judged import ANGLE, OF_CONTACTS, QUANTITIES, Whole, hertz_of, limit_of, of_contacts
from rollbench.compare.gate.values_file import GivenValue
from rollbench.compare.gate.verdict import At, Limits, Verdict, about, blank, decisive, word
from rollbench.compare.measure import SMALL, error_percent
from rollbench.compare.models.comparison import Loads
from rollbench.compare.reference.estimate import Reference
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import bearing
from rollbench.meshes.parts import SIDES, Scene

#: What is said of approaches and pressures that the reference does not hold itself.
BY_HERTZ = "the reference's by Hertz from its loads, each contact's own radii"


class Contacts(NamedTuple):
    """What is judged of contacts beside their loads ``(n, 4)`` [N]: other quantities ``(n, 4)`` [SI] by the columns of
    `OF_CONTACTS`, nan where they are not given; the flanks that are named."""

    load: Array
    further: Mapping[str, Array]
    flanks: Sequence[str] = SIDES


def contacts_by(scene: Scene, answer: Loads, limits: Mapping[str, float]) -> Contacts:
    """What a model says of contacts, of the quantities that are given a limit."""
    limited = {name: q for name, q in OF_CONTACTS.items() if q.name in limits}
    further = {k: np.radians(answer.angle) if q is ANGLE else hertz_of(scene, q, answer.load) for k, q in limited.items()}
    return Contacts(answer.load, further)


def values_by(scene: Scene, answer: Loads, limits: Mapping[str, float]) -> list[GivenValue]:
    """What a model says of the whole, of the quantities that are given a limit and that it has."""
    whole, limited = Whole(scene), [q for q in QUANTITIES.values() if q.name in limits and q not in OF_CONTACTS.values()]
    values = ((q, whole.of(q, answer)) for q in limited)
    return [GivenValue(q, value) for q, value in values if value is not None]


def contact_verdicts(judged: str, given: Contacts, scene: Scene, ref: Reference, limits: Limits) -> list[Verdict]:
    """A verdict on each quantity of contacts that is given and that the reference has, on the contact that decides."""
    without = {"angle"} if not np.isfinite(ref.best.angle).any() else set()
    names = [name for name in OF_CONTACTS if name in given.further.keys() - without]
    return [_of_contacts(judged, given, name, scene, ref, limits) for name in names]


def _of_contacts(judged: str, given: Contacts, name: str, scene: Scene, ref: Reference, limits: Limits) -> Verdict:
    """In per cent of a contact's own value, of that at the mean load for contacts below a tenth of it; of angles in
    degrees, of contacts that bear load in both."""
    q, value = OF_CONTACTS[name], given.further[name]
    limit, unit = limit_of(q, limits.others, limits.largest), "deg" if q is ANGLE else "%"
    reference, bars = of_contacts(scene, ref, q)
    chosen = np.array([side in given.flanks for side in SIDES])
    if q is ANGLE:
        judge = bearing(ref.load) & bearing(given.load) & chosen & np.isfinite(reference)
        errors, shares = np.degrees(value - reference), np.degrees(bars)
    else:
        judge = ((ref.load > 0.0) | (value > 0.0)) & chosen
        value = np.where(np.isnan(value) & (given.load == 0.0), 0.0, value)  # of a contact that is lost
        mean = hertz_of(scene, q, np.full(value.shape, ref.mean))
        scale = np.where(ref.load >= SMALL * ref.mean, reference, mean)
        errors, shares = error_percent(value, reference, scale), error_percent(bars, 0.0, scale)
    if not judge.any():
        return blank(ref, judged, q.name, limit, f"no contact of the flanks {', '.join(given.flanks)} is loaded", unit)
    points = [
        At(float(errors[k]), float(shares[k]) if np.isfinite(shares[k]) else None, int(k[0]) + 1, SIDES[k[1]])
        for k in zip(*np.nonzero(judge), strict=True)
    ]
    kind, at = decisive(points, limit)
    k = at.ball - 1, SIDES.index(at.side)
    pair = (q.key, q.factor * float(value[k]), q.factor * float(reference[k]))
    detail = about(ref) if q is ANGLE or q.name in ref.further else "; ".join(filter(None, [BY_HERTZ, about(ref)]))
    where = (at.ball, at.side, ref.levels, len(points), detail)
    return Verdict(ref.scene, judged, q.name, kind, at.error, at.bar, limit, *where, unit=unit, pair=pair)


def value_verdict(judged: str, given: GivenValue, scene: Scene, ref: Reference, limits: Limits) -> Verdict:
    """The verdict on a value of the whole, in per cent of the reference's."""
    whole, q = Whole(scene), given.quantity
    limit = limit_of(q, limits.others, limits.largest)
    reference, bar = whole.reference(q, ref, given.station)
    if not reference:
        return blank(ref, judged, given.name, limit, f"no {q.name}: {whole.why_not(q, ref)}")
    error = float(error_percent(given.value, reference))
    share = None if bar is None else float(error_percent(bar, 0.0, reference))
    detail = "; ".join(filter(None, (whole.words(q), about(ref))))
    pair = (q.key, q.factor * given.value, q.factor * reference)
    kind = word(error, share, limit)
    return Verdict(ref.scene, judged, given.name, kind, error, share, limit, levels=ref.levels, detail=detail, pair=pair)


def not_judged(verdicts: Sequence[Verdict]) -> list[str]:
    """Quantities that no verdict is on."""
    return [name for name in QUANTITIES if not any(v.quantity.split(" at ")[0] == name for v in verdicts)]
