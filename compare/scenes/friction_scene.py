"""Scenes of friction and ball motion as TOML: a ball in a rotary bearing, a linear pair, a linear chain.

Those of ball screws and of bearings in pairs are in ``friction_screw_scene``.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from math import degrees, pi, tan
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from pydantic import ValidationError

from compare.errors import InputError, SceneError
from compare.scenes import units
from compare.scenes.catalogue import looks_like_path
from compare.scenes.checks import Fault, mm
from compare.scenes.friction_keys import KINDS, ChainKeys, CommonKeys, Kind, Law, LinearBearingKeys, PairKeys, RotaryKeys
from compare.scenes.refusal import _allowed, _node, refuse
from compare.scenes.scene_file import read_text, read_toml
from compare.scenes.schema import _without_null
from lowfi.friction.bearing.rotary import Bearing, Mode
from lowfi.friction.linear.bearing import Array, LinearBearing, deviations
from lowfi.friction.linear.loads import Loads


@dataclass(frozen=True)
class FrictionScene:
    """What every friction scene has."""

    name: str
    title: str
    source: str
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class RotaryScene(FrictionScene):
    """One ball: bearing, axial force [N], radial displacement [m], Hertz constants, law with its parameters.

    creep [m/s] for "regularised"; sharpness k_S and map_step in c/a (None: exact integrals) for "sigmoid".
    """

    bearing: Bearing
    force: float
    displacement: float
    hertz: Mode
    law: Law
    creep: float
    sharpness: float
    map_step: float | None


@dataclass(frozen=True)
class LinearScene(FrictionScene):
    """N balls: contact angles (N, 4) [rad] before loading, vertical force [N], side force ratios (N,).

    gap (N-1,) [m] between neighbours; kind: "linear pair" or "linear chain".
    """

    kind: Kind
    bearing: LinearBearing
    angles: Array
    vertical: float
    side: Array
    distribution: Loads
    gap: Array


def kinds() -> dict[str, type[CommonKeys]]:
    """The keys of every kind of scene."""
    from compare.scenes import friction_screw_scene

    return KINDS | friction_screw_scene.KINDS


def scene_names() -> list[str]:
    """Names of the shipped friction scenes, sorted."""
    files = resources.files("compare").joinpath("friction_scenes").iterdir()
    return sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml"))


def scene(name_or_path: str) -> FrictionScene:
    """A shipped friction scene by name, or that of a file. Raises InputError (SceneError for a faulty file)."""
    names = scene_names()
    if name_or_path in names:
        path = resources.files("compare").joinpath("friction_scenes", f"{name_or_path}.toml")
        return loads(path.read_text(encoding="utf-8"), f"{name_or_path}.toml")
    if looks_like_path(name_or_path):
        return loads(read_text(name_or_path), name_or_path)
    near = difflib.get_close_matches(name_or_path, names, n=3, cutoff=0.4)
    advice = f"did you mean {' or '.join(near)}?" if near else f"shipped: {', '.join(names)}"
    allowed = f"one of {len(names)} shipped names, or a file"
    raise InputError("friction scene", "name", f'"{name_or_path}"', allowed, advice)


def loads(text: str, origin: str) -> FrictionScene:
    """The scene in ``text``; ``origin`` is the file named in errors. Raises SceneError, and nothing else."""
    from compare.scenes import friction_screw_scene

    raw = read_toml(text, origin)
    kind = raw.get("kind")
    if not isinstance(kind, str) or kind not in kinds():
        found = units.show(kind) if "kind" in raw else "nothing"
        advice = 'write e.g. kind = "rotary bearing" above the first table'
        raise SceneError(origin, "kind", found, ", ".join(map(units.show, kinds())), advice)
    model = kinds()[kind]
    try:
        keys = model.model_validate(raw)
    except ValidationError as error:
        _refuse_keys(origin, model, error)
    name = Path(origin).stem
    if kind not in KINDS:
        refuse(origin, raw, list(friction_screw_scene.faults(keys)))
        return friction_screw_scene.record(keys, name)
    refuse(origin, raw, list(faults(keys)))
    return _rotary(keys, name) if isinstance(keys, RotaryKeys) else _linear(keys, name)


def json_schema(kind: Kind) -> dict[str, Any]:
    """JSON Schema of a scene of one kind, with description, unit, range and example of every key."""
    found: dict[str, Any] = _without_null(kinds()[kind].model_json_schema())
    return found


def _refuse_keys(origin: str, model: type[CommonKeys], error: ValidationError) -> NoReturn:
    """Raise the first fault that pydantic found, unknown keys first."""
    listed = error.errors(include_url=False)
    first = min(listed, key=lambda f: f["type"] != "extra_forbidden")
    where, kind, more = first["loc"], first["type"], len(listed) - 1
    path = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in where).lstrip(".")
    schema: dict[str, Any] = _without_null(model.model_json_schema())
    if kind == "extra_forbidden":
        known = list(_node(schema, where[:-1]).get("properties", {}))
        near = difflib.get_close_matches(str(where[-1]), known, n=1, cutoff=0.5)
        advice = f"unknown key; did you mean {near[0]}?" if near else "unknown key: remove it or move it"
        raise SceneError(origin, path, units.show(first["input"]), ", ".join(known), advice, more)
    node, context = _node(schema, where), first.get("ctx", {})
    allowed = "true, false" if node.get("type") == "boolean" else str(context.get("allowed") or _allowed(node))
    examples = node.get("examples", [])
    example = f"e.g. {where[-1]} = {units.show(examples[0])}" if examples else f"a [{path}] table"
    advice = str(context.get("advice") or f"{'add' if kind == 'missing' else 'write'} {example}")
    found = "nothing" if kind == "missing" else units.show(first["input"])
    raise SceneError(origin, path, found, allowed, advice, more)


# --- what a scene may not describe


def faults(keys: CommonKeys) -> Iterator[Fault]:
    """Contradictory choices and bodies that the models cannot treat."""
    assert isinstance(keys, (RotaryKeys, PairKeys, ChainKeys))
    wrong = list(groove_faults(keys.bearing, "bearing"))
    if wrong:
        yield from wrong
        return
    if isinstance(keys, RotaryKeys):
        yield from _rotary_faults(keys, groove_radius(keys.bearing))
        return
    if keys.friction.law != "coulomb":
        advice = "balls in contact are solved with Coulomb friction only; the other laws are for a rotary bearing"
        yield Fault(("friction.law",), '"coulomb" for linear bearings', advice)
    yield from _linear_faults(keys)


def groove_faults(b: LinearBearingKeys, table: str) -> Iterator[Fault]:
    """Faults of the groove radius of a table."""
    if (b.groove_radius is None) == (b.conformity is None):
        found = "neither" if b.conformity is None else "both"
        advice = "groove radius = conformity x ball diameter: give one and leave out the other"
        yield Fault((f"{table}.groove_radius",), "one of groove_radius and conformity", advice, found)
        return
    if groove_radius(b) <= b.ball_radius:
        advice = "a groove is wider than its ball"
        yield Fault((f"{table}.groove_radius", f"{table}.conformity"), f"above {mm(b.ball_radius)}", advice)


def groove_radius(bearing: LinearBearingKeys) -> float:
    """Groove radius [m], as given or from the conformity."""
    return bearing.groove_radius or 2.0 * (bearing.conformity or 0.0) * bearing.ball_radius


def _rotary_faults(keys: RotaryKeys, groove: float) -> Iterator[Fault]:
    b, f, reach = keys.bearing, keys.friction, groove - keys.bearing.ball_radius
    if b.pitch_radius <= groove:
        advice = "the balls run on a circle larger than the groove's section"
        yield Fault(("bearing.pitch_radius",), f"above {mm(groove)}", advice)
    moved = keys.loads.radial_displacement
    for where, size in (("bearing.clearance", b.clearance), ("loads.radial_displacement", moved)):
        if abs(size) >= reach:
            advice = "the ball's centre would leave its groove's section: the models hold for small displacements"
            yield Fault((where,), f"between -{mm(reach)} and {mm(reach)}, groove radius less ball radius", advice)
    owners = {"creep": "regularised", "sharpness": "sigmoid", "map_step": "sigmoid"}
    for name, law in owners.items():
        if getattr(f, name) is not None and f.law != law:
            yield Fault((f"friction.{name}",), f'only with law = "{law}"', f'remove it, or set law = "{law}"')
    if f.law == "regularised" and f.creep is None:
        advice = 'add creep = "0.1 mm/s", the speed that regularises'
        yield Fault(("friction.creep",), "above 0 m/s", advice, "nothing")
    if f.law == "sigmoid" and keys.motion.inner_ring == 0.0:
        advice = "the sigmoid's spin is relative to the ring's speed: let it turn, or take another law"
        yield Fault(("motion.inner_ring",), "not zero for the sigmoid", advice)


def _linear_faults(keys: PairKeys | ChainKeys) -> Iterator[Fault]:
    angles, side, gap = _balls(keys)
    if isinstance(keys, ChainKeys) and gap[-1] != 0.0:
        where = f"balls[{len(gap) - 1}].gap"
        yield Fault((where,), "none for the last ball", "the last ball has no next one: remove its gap")
    for i, row in enumerate(angles):
        single = f"balls[{i}]"
        where = f"{single}.angle_deviations" if isinstance(keys, ChainKeys) else "grooves.angle_deviation"
        if row.min() <= 0.0 or row.max() >= 0.5 * pi:
            advice = f"the nominal contact angle is {degrees(keys.bearing.contact_angle):.6g} deg"
            yield Fault((where,), "contact angles above 0 deg, below 90 deg", advice)
            return
        low, high = side_range(row, keys.bearing.contact_angle, keys.loads.distribution)
        if not low <= side[i] <= high:
            where = f"{single}.side_force_ratio" if isinstance(keys, ChainKeys) else "loads.side_force_ratio"
            least, most = (low, high) if isinstance(keys, ChainKeys) or i == 0 else (-high, -low)
            advice = 'a contact would have to pull: take less, or distribution = "elastic"'
            yield Fault((where,), f"{least:.4g} to {most:.4g} at these contact angles", advice)
            return


def side_range(angles: Array, nominal: float, distribution: Loads) -> tuple[float, float]:
    """Least and greatest side force ratio of a ball at contact angles (4,) without a contact that pulls."""
    if distribution == "elastic":
        return -np.inf, np.inf
    if distribution == "diagonal":
        return -tan(nominal), tan(nominal)
    bl, br, tr, tl = (tan(float(a)) for a in angles)
    return -min(bl, tr), min(br, tl)


# --- records


def _balls(keys: PairKeys | ChainKeys) -> tuple[Array, Array, Array]:
    """Contact angles (N, 4) [rad], side force ratios (N,), gaps after each ball (N,) [m]."""
    if isinstance(keys, PairKeys):
        two = np.full(2, keys.grooves.angle_deviation)
        turned, rho = deviations(two, mated=keys.grooves.mated), keys.loads.side_force_ratio
        return keys.bearing.contact_angle + turned, np.array([rho, -rho]), np.zeros(2)
    turned = np.array([b.angle_deviations for b in keys.balls])
    side, gap = (np.array([getattr(b, name) for b in keys.balls]) for name in ("side_force_ratio", "gap"))
    return keys.bearing.contact_angle + turned, side, gap


def _rotary(keys: RotaryKeys, name: str) -> RotaryScene:
    b, f, m = keys.bearing, keys.friction, keys.material
    bearing = Bearing(
        b.ball_radius,
        groove_radius(b),
        b.pitch_radius,
        b.contact_angle,
        m.youngs_modulus,
        m.poissons_ratio,
        f.coefficient,
        keys.motion.inner_ring,
        b.clearance,
    )
    return RotaryScene(
        name,
        keys.title,
        keys.source,
        tuple(keys.assumed),
        bearing,
        keys.loads.axial_force,
        keys.loads.radial_displacement,
        keys.hertz,
        f.law,
        f.creep or 0.0,
        f.sharpness or 100.0,
        f.map_step,
    )


def _linear(keys: CommonKeys, name: str) -> LinearScene:
    assert isinstance(keys, (PairKeys, ChainKeys))
    b, f, m = keys.bearing, keys.friction, keys.material
    rubbing = f.coefficient if f.between_balls is None else f.between_balls
    conformity = b.conformity or 0.5 * groove_radius(b) / b.ball_radius
    bearing = LinearBearing(
        b.ball_radius,
        conformity,
        b.contact_angle,
        keys.motion.carriage,
        f.coefficient,
        rubbing,
        m.youngs_modulus,
        m.poissons_ratio,
    )
    angles, side, gap = _balls(keys)
    return LinearScene(
        name,
        keys.title,
        keys.source,
        tuple(keys.assumed),
        keys.kind,
        bearing,
        angles,
        keys.loads.vertical_force,
        side,
        keys.loads.distribution,
        gap[:-1],
    )
