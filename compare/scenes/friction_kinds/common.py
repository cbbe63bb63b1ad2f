"""Shared parts of the kinds of scenes that only friction is computed for: keys, records, checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np

from rollbench.compare.errors import escape_unprintable
from rollbench.compare.scenes.fault import Fault, mm
from rollbench.compare.scenes.key_checks import groove_choice_faults
from rollbench.compare.scenes.keys import (
    MATERIAL,
    BallSizeKeys,
    CoulombKeys,
    GrooveKeys,
    HeadKeys,
    MaterialKeys,
    OversizeKeys,
    PathKeys,
    Table,
    key,
)
from rollbench.lowfi.friction.screw.groove import Mode, ScrewGroove
from rollbench.meshes.ranges import Coefficient, Quantity
from rollbench.meshes.scene_text import to_toml


class KindKeys(HeadKeys):
    """Keys of every kind."""

    kind: str = key("what the scene describes")
    material: MaterialKeys = key("material of all parts", example=MATERIAL)


@dataclass(frozen=True)
class KindScene:
    """Fields of the scene of every kind. ``assumed``: statements about what the source leaves open."""

    kind: ClassVar[str]
    name: str
    title: str
    source: str
    assumed: tuple[str, ...]

    def to_toml(self) -> str:
        """Return the text of a scene file that is read as this scene."""
        from rollbench.compare.scenes.friction_kinds.table import scene_tables

        return to_toml(scene_tables(self))


Head = tuple[str, str, str, tuple[str, ...]]


def head_fields(keys: KindKeys, name: str) -> Head:
    """Return the first fields of a record: name, title, source, assumptions."""
    assumed = tuple(map(escape_unprintable, keys.assumed))
    return name, escape_unprintable(keys.title), escape_unprintable(keys.source), assumed


@dataclass(frozen=True)
class SceneKind:
    """A kind of scene: its keys, keys that are not allowed, and the function that makes its record."""

    keys: type[KindKeys]
    faults: Callable[[Any], Iterator[Fault]]
    record: Callable[[Any, str], KindScene]


Pressing = Annotated[float, Quantity("force", "0 N", "1 MN", "100 N", above=True)]

AxialLoad = Annotated[float, Quantity("force", "-1 MN", "1 MN", "50 N")]

Gap = Annotated[float, Quantity("length", "0 mm", "1 m", "0.5 mm")]

Theta = Annotated[float, Quantity("angle", "-15 deg", "15 deg", "2 deg")]


class SharedErrorKeys(Table):
    """Geometric errors that a module of a few balls knows."""

    balls: OversizeKeys = key("errors of the ball radii", OversizeKeys(), {"oversize": "1.7 um"})


class HertzKeys(Table):
    """Which Hertz constants are used."""

    hertz: Literal["nominal", "as printed"] = key(
        "contact constants: exact at the nominal angle, or with the faults of Table B.1", "nominal", "nominal"
    )

    @property
    def mode(self) -> Mode:
        """Name of the Hertz constants in the modules of friction."""
        return "right" if self.hertz == "nominal" else "as printed"


class RubbingKeys(CoulombKeys):
    """Coulomb friction of grooves and balls."""

    balls: Coefficient | None = key("coefficient from ball to ball, where it is not that of the grooves", None)


class SectionKeys(KindKeys):
    """A ring or a screw: one groove section on both parts, one size of balls."""

    screw: GrooveKeys = key("groove of the screw, or of the inner ring", example={"conformity": 0.54})
    nut: GrooveKeys = key("groove of the nut, or of the outer ring; the same section", example={"conformity": 0.54})
    errors: SharedErrorKeys = key("geometric errors", SharedErrorKeys(), {"balls": {"oversize": "1.7 um"}})
    ingredients: HertzKeys = key("parts of the low-order model", HertzKeys(), {"hertz": "nominal"})


def material_faults(material: MaterialKeys) -> Iterator[Fault]:
    """Yield a fault of a material without modulus or Poisson's ratio."""
    for name, text in (("youngs_modulus", '"210 GPa"'), ("poissons_ratio", "0.28")):
        if getattr(material, name) is None:
            yield Fault((f"material.{name}",), "a value", f"write {name} = {text} under [material]", "nothing")


def elastic_constants(material: MaterialKeys) -> tuple[float, float]:
    """Return Young's modulus [Pa] and Poisson's ratio of a validated material."""
    return material.youngs_modulus or 0.0, material.poissons_ratio or 0.0


def groove_radius(groove: GrooveKeys, balls: BallSizeKeys) -> float:
    """Return the groove radius [m], as given or from the conformity."""
    return groove.groove_radius or 2.0 * (groove.conformity or 0.0) * balls.radius


def groove_faults(groove: GrooveKeys, balls: BallSizeKeys, table: str) -> Iterator[Fault]:
    """Yield a fault of a groove that is given twice, not at all, or narrower than its ball."""
    wrong = list(groove_choice_faults(groove, table))
    yield from wrong
    if not wrong and groove_radius(groove, balls) <= balls.radius:
        advice = "a groove is wider than its ball"
        yield Fault((f"{table}.groove_radius", f"{table}.conformity"), f"above {mm(balls.radius)}", advice)


class OneRingKeys(Protocol):
    """Tables of one ring or screw."""

    screw: GrooveKeys
    nut: GrooveKeys
    errors: SharedErrorKeys

    @property
    def track(self) -> PathKeys:
        """Path of the ball centres."""

    @property
    def balls(self) -> BallSizeKeys:
        """The balls."""


def groove_and_path_faults(body: OneRingKeys, p: str = "", *, ring: bool) -> Iterator[Fault]:
    """Yield faults of grooves and path.

    Parameters
    ----------
    body
        Tables of a ring or screw.
    p
        Prefix of its tables (``four_point.``).
    ring
        Whether the lead must be zero instead of positive.
    """
    track, radius = body.track, groove_radius(body.screw, body.balls)
    for name, groove in (("screw", body.screw), ("nut", body.nut)):
        wrong = list(groove_faults(groove, body.balls, p + name))
        yield from wrong
        if wrong:
            return
    if abs(groove_radius(body.nut, body.balls) / radius - 1.0) > 1e-12:
        advice = "this kind has one groove section: for unlike grooves describe the whole screw or bearing"
        yield Fault((f"{p}nut.groove_radius", f"{p}nut.conformity"), f"the screw's, {mm(radius)}", advice)
    if ring and track.lead != 0.0:
        yield Fault((f"{p}track.lead",), '"0 mm"', "this kind describes rings, without a lead")
    if not ring and track.lead == 0.0:
        yield Fault((f"{p}track.lead",), "above 0 mm", "this kind describes a ball screw: give its lead")
    if track.pitch_radius <= radius:
        advice = "the balls run on a circle larger than the groove's section"
        yield Fault((f"{p}track.pitch_radius",), f"above {mm(radius)}", advice)
    yield from displacement_faults(radius - body.balls.radius, body.errors.balls.oversize, f"{p}errors.balls.oversize")


def displacement_faults(reach: float, size: float, where: str) -> Iterator[Fault]:
    """Yield a fault of a play or displacement [m] that moves the ball's centre out of its groove's section."""
    if abs(size) >= reach:
        advice = "the ball's centre would leave its groove's section: the models hold for small displacements"
        yield Fault((where,), f"between -{mm(reach)} and {mm(reach)}, groove radius less ball radius", advice)


def hertz_faults(groove: ScrewGroove, prefix: str = "") -> Iterator[Fault]:
    """Yield a fault of grooves without the Hertz constants asked for; ``prefix``: of their tables."""
    try:
        with np.errstate(invalid="ignore"):
            if np.all(np.isfinite(groove.constants.C)):
                return
    except ValueError:
        pass
    if groove.hertz == "as printed":
        advice = "the source's constants do not exist there, mostly because the helix is too steep"
        yield Fault(("ingredients.hertz",), '"nominal" for these grooves', advice)
        return
    keys = (f"{prefix}screw.groove_radius", f"{prefix}screw.conformity")
    yield Fault(keys, "a groove that does not conform to its ball", "take a wider groove")
