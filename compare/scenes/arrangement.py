"""Sets of equal bearings by name, ``arrangement = "DBD"``: one row a bearing, ground to equal gaps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rollbench.comparison.errors import InputError
from rollbench.comparison.registration import needed
from rollbench.comparison.scenes.axis_schema import SetKeys
from rollbench.comparison.scenes.fault import Fault
from rollbench.meshes.axis import ARRANGEMENTS, RollingSet
from rollbench.meshes.parts import Scene


def arrangement_faults(at: str, one: SetKeys) -> Iterator[Fault]:
    """What does not go with an arrangement, or without one."""
    given = one.arrangement is not None
    if one.pair_preload and not given:
        yield Fault((f"{at}.pair_preload",), "with an arrangement", 'write e.g. arrangement = "DB", or preload')
    if one.pair_preload and one.preload:
        yield Fault(
            (f"{at}.preload",), "either preload or pair_preload", "one follows from the other: leave one out", "both"
        )
    if one.pair_rigidity is not None:
        if not one.pair_preload:
            yield Fault((f"{at}.pair_rigidity",), "with pair_preload", "write the preload of the pair that has it")
        if any(x is not None and (x.conformity or x.groove_radius) for x in (one.screw, one.nut)):
            yield Fault(
                (f"{at}.pair_rigidity",), "in place of the grooves of the set", "leave conformity and groove_radius out"
            )
    if not given:
        return
    if one.rollers is not None or (one.track is not None and one.track.lead != 0.0):
        yield Fault((f"{at}.arrangement",), "a ball bearing", "rollers and nuts are written row by row: leave it out")
    for key, written in (("thrust", one.thrust is not None), ("offset", one.offset != 0.0)):
        if written:
            yield Fault(
                (f"{at}.{key}",), "nothing with an arrangement", "the arrangement says it of every row: leave it out"
            )
    if (one.preload or one.pair_preload) and len(set(ARRANGEMENTS[one.arrangement or ""])) == 1:
        advice = "bearings in tandem press against nothing: leave it out, or name another arrangement"
        yield Fault((f"{at}.{'preload' if one.preload else 'pair_preload'}",), "rows that face both ways", advice)


def preload_of_set(name: str, pair: float) -> float:
    """Preload [N] of a set, on either side in all, whose bearings are ground to the gaps of a pair of that preload [N].

    The gaps of a pair close by twice the deflection of a bearing; so do those of opposite rows in any set, where a side of
    n rows shares its load: P^(2/3) (n_1^(-2/3) + n_2^(-2/3)) = 2 F^(2/3), at a contact angle that stands still.
    """
    ways = ARRANGEMENTS[name]
    shared = sum(ways.count(way) ** (-2.0 / 3.0) for way in set(ways))
    return float(pair * (2.0 / shared) ** 1.5)


def bearings_of(whole: RollingSet, one: SetKeys, seeds: int) -> Iterator[RollingSet]:
    """The rows of a set in its arrangement, side by side about its position, each as wide as its ring; the set itself where
    it has none. seeds: step between the seeds of their errors."""
    if one.arrangement is None or not isinstance(whole.parts, Scene):
        yield whole
        return
    ways, parts = ARRANGEMENTS[one.arrangement], whole.parts
    total = preload_of_set(one.arrangement, one.pair_preload) if one.pair_preload else whole.preload
    for k, way in enumerate(ways):
        name, at = f"{whole.name} {k + 1}", whole.position + (k - 0.5 * (len(ways) - 1)) * parts.nut.length
        errors = replace(parts.errors, seed=parts.errors.seed + seeds * k)
        row = replace(parts, name=name, nut=replace(parts.nut, position=at), errors=errors)
        share = total / ways.count(way) if len(set(ways)) == 2 else 0.0
        yield replace(whole, name=name, parts=row, position=at, thrust=way, preload=share)


def with_conformity(parts: Scene, one: SetKeys, origin: str, at: str) -> Scene:
    """The parts with the conformity of both grooves that a pair's rigidity at its preload implies, where one is given.
    Raises InputError."""
    if one.pair_rigidity is None:
        return parts
    given = f"{1e-6 * one.pair_rigidity:g} N/um at {one.pair_preload:g} N"
    conformity = needed("conformity", origin, f"{at}.pair_rigidity", given)
    try:
        implied = conformity(parts, one.pair_preload, one.pair_rigidity)
    except ValueError as error:
        raise InputError(origin, f"{at}.pair_rigidity", given, str(error), "mend balls, preload or rigidity") from None
    groove = 2.0 * implied * parts.balls.radius
    text = f"{parts.name}: conformity {implied:.4f} of both grooves, from the rigidity of a pair, {given}."
    return replace(
        parts,
        screw=replace(parts.screw, groove_radius=groove),
        nut=replace(parts.nut, groove_radius=groove),
        assumed=(*parts.assumed, text),
    )
