"""Description of the parts of a ball screw or ball bearing: plain records in SI units.

Both fidelities read these records and nothing else of each other.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Literal

#: Contact sides in the order of every ``(n, 4)`` array: screw left, screw right, nut left, nut right.
SIDES = ("SL", "SR", "NL", "NR")

#: Unit factors ``(s_x, s_z)`` of the contact direction ``(s_x cos(gamma), s_z sin(gamma))`` in the plane of the
#: groove section (x3 radial, z3 along the binormal), one row per side (Lin 2019, Figure 2.4).
SIDE_SIGNS = ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0))

#: Freedoms of a station of the screw: displacements along x, y, z and small rotations about them.
FREEDOMS = ("ux", "uy", "uz", "rx", "ry", "rz")

#: Where a nut may be held: the inner and outer halves of a face are rings on both sides of the middle of its width.
NutHeld = Literal[
    "left face",
    "right face",
    "both faces",
    "outer surface",
    "left face, inner half",
    "left face, outer half",
    "right face, inner half",
    "right face, outer half",
    "flange face",
]


class UnfitKey(ValueError):
    """Parts that cannot be built, or not solved by a model: ``key`` of the scene (``nut.outer_diameter``), and why."""

    def __init__(self, key: str, reason: str) -> None:
        """Keep both; the text is the reason."""
        super().__init__(key, reason)
        self.key = key

    def __str__(self) -> str:
        """The reason."""
        return str(self.args[1])


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material: Young's modulus [Pa] and Poisson's ratio."""

    youngs_modulus: float
    poissons_ratio: float

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))


@dataclass(frozen=True)
class Track:
    """Nominal ball path (Lin 2.1, 2.2, 2.5): pitch radius [m], lead [m], hand, starts, contact angle [rad].

    ``phase`` [rad] is the azimuth of the helix at the nut's centre; a lead of zero is a ball bearing. ``arcs``: each groove
    is a gothic arch of two arcs, or, of a bearing, one arc, whose contacts then carry thrust on the screw this way.
    """

    pitch_radius: float
    lead: float
    contact_angle: float
    hand: Literal["right", "left"] = "right"
    starts: int = 1
    phase: float = 0.0
    arcs: Literal["two", "+z", "-z"] = "two"


@dataclass(frozen=True)
class Screw:
    """Screw shaft or inner ring: length, outer diameter, bore and groove radius [m], material."""

    length: float
    outer_diameter: float
    groove_radius: float
    material: Material
    bore: float = 0.0


@dataclass(frozen=True)
class Flange:
    """Flange at an end of a nut, within its length: outer diameter and thickness [m], ``side`` of the nut.

    ``seat``: radii [m] between which its face towards the rest of the nut may be held (``Solid.nut_held``); ``centring``:
    length [m] of the nut's outside from that face on that fits the housing's bore; ``bonded``: whether the fit holds the
    nut there too, or lets it go; ``bolts``: number of bolts, in each of which a circle as wide as the seat holds it in 3D,
    the first at azimuth 0 (0: all of the seat, as in low-order models).
    """

    diameter: float
    thickness: float
    seat: tuple[float, float]
    side: Literal["left", "right"] = "left"
    centring: float = 0.0
    bonded: bool = False
    bolts: int = 0

    def stations(self, low: float, high: float) -> tuple[float, float, float]:
        """Stations [m] of its outer face, of the face that may be held, and of the end of the fit, on a nut from ``low``
        to ``high`` [m]."""
        end, inwards = (low, 1.0) if self.side == "left" else (high, -1.0)
        return end, end + inwards * self.thickness, end + inwards * (self.thickness + self.centring)


@dataclass(frozen=True)
class Nut:
    """Nut or outer ring: axial position of its centre, length, outer diameter and groove radius [m], material.

    ``azimuth`` [rad] is the angle psi_N between the axes of nut and screw (Lin 2.9), on which the nut's errors depend.
    """

    position: float
    length: float
    outer_diameter: float
    groove_radius: float
    material: Material
    azimuth: float = 0.0
    flange: Flange | None = None


@dataclass(frozen=True)
class Balls:
    """Balls: nominal radius [m], material, and the unwrapped azimuths [rad] of one start (each start has the same)."""

    radius: float
    material: Material
    azimuths: tuple[float, ...]


@dataclass(frozen=True)
class FourierTerm:
    """One term ``sin * sin(h phi) + cos * cos(h phi)`` [m] of an error along the track; ``h`` may be a fraction.

    ``sigma`` [m] > 0 adds independent normal draws to both amplitudes.
    """

    harmonic: float
    sin: float = 0.0
    cos: float = 0.0
    sigma: float = 0.0


@dataclass(frozen=True)
class SideErrors:
    """Geometric errors of one groove flank (Lin 2.27, 4.1, 4.3).

    ``profile``: coefficients [m] of the inward offset of the groove radius, a polynomial in gamma [rad];
    ``profile_sigma``: standard deviations [m] of normal draws added to those coefficients;
    ``pitch``: displacement of the groove centre along z3 (``pitch_along = "section"``, Lin 2.27) or along the
    screw's axis (``"axis"``, Lin 4.1); ``roundness``: displacement of the groove centre along the radius (Lin 4.3).
    """

    profile: tuple[float, ...] = ()
    profile_sigma: tuple[float, ...] = ()
    pitch: tuple[FourierTerm, ...] = ()
    pitch_along: Literal["section", "axis"] = "section"
    roundness: tuple[FourierTerm, ...] = ()


@dataclass(frozen=True)
class BallErrors:
    """Errors of the ball radii [m]: the same ``oversize`` for all, ``listed`` by ball number (from 1), and random."""

    oversize: float = 0.0
    listed: tuple[tuple[int, float], ...] = ()
    sigma: float = 0.0
    distribution: Literal["normal", "uniform"] = "normal"


@dataclass(frozen=True)
class Errors:
    """All geometric errors of a scene, and the seed of every random one.

    ``lead_offset`` [m]: shift along the axis of the nut's groove beyond the nut's centre (z above its position) against the
    rest of it, by which a single nut is preloaded in two-point contact.
    """

    balls: BallErrors = field(default_factory=BallErrors)
    SL: SideErrors = field(default_factory=SideErrors)
    SR: SideErrors = field(default_factory=SideErrors)
    NL: SideErrors = field(default_factory=SideErrors)
    NR: SideErrors = field(default_factory=SideErrors)
    seed: int = 0
    lead_offset: float = 0.0

    def side(self, name: str) -> SideErrors:
        """Errors of the flank ``name`` (one of SIDES)."""
        found: SideErrors = getattr(self, name)
        return found

    @property
    def random(self) -> bool:
        """Whether anything is drawn at random."""
        return self.balls.sigma > 0.0 or any(
            any(s > 0.0 for s in e.profile_sigma) or any(t.sigma > 0.0 for t in (*e.pitch, *e.roundness))
            for e in (self.SL, self.SR, self.NL, self.NR)
        )


@dataclass(frozen=True)
class Support:
    """Support of the screw at station ``at`` [m]: pairs (freedom, prescribed displacement [m] or rotation [rad])."""

    at: float
    fixed: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Load:
    """Load on the screw at station ``at`` [m]: force [N] and moment [N m] vectors, applied on the axis."""

    at: float
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    moment: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Ingredients:
    """Which parts of the low-order model a scene uses.

    hertz: constants at the ``"nominal"`` contact angle with each contact's own radii, of ``"error-free"`` parts there, at
    the ``"actual"`` geometry of each contact, or ``"as printed"`` (Table B.1's faults).
    screw: ``"beam"`` (Timoshenko) or ``"rigid"``.
    partition: ``"nodal"`` (a node at every contact station, exact), ``"source"`` (15 mm in the nut, about the pitch
    diameter outside), or ``"uniform"`` with ``element_length`` inside the nut.
    section: ``"groove"`` (Lin C.8: diameters scaled by k_r), ``"groove squared"`` (k_r without the root), ``"full"``.
    arm: lever arm of the contact force: ``"current"`` contact point, ``"nominal"`` contact point (frozen), or
    ``"ball"`` (current contact point, but the force enters the beam at the ball's station).
    """

    hertz: Literal["nominal", "error-free", "actual", "as printed"] = "nominal"
    screw: Literal["beam", "rigid"] = "beam"
    partition: Literal["nodal", "source", "uniform"] = "nodal"
    element_length: float = 1.0e-3
    section: Literal["groove", "groove squared", "full"] = "groove"
    arm: Literal["current", "nominal", "ball"] = "current"


@dataclass(frozen=True)
class Solid:
    """What a 3D model needs beyond a low-order one; ``None`` stands for the assumption of ``meshes.solid``.

    ``nut_inner_diameter``: lands of the nut [m]; ``hole_diameter``: hole along the axis of the meshed screw [m];
    ``shaft``: length of the 3D stretch beyond the nut on each side [m]; ``shaft_diameter``: diameter of the equivalent
    plain shaft beyond it [m] (``None``: the section is homogenised from the grooved shaft);
    ``nut_held``: where the nut is held (half a face: the inner or outer half of its width; the flange's: at its ``seat``);
    ``screw_held``: at the ends of the 3D stretch, or by its bore (a ring on a stiff shaft); ``nut``: elastic, or rigid
    beyond the contact patches; ``nut_groove``: through the whole nut, or filled beyond the loaded balls
    (`meshes.groove.GrooveEnds`).
    """

    nut_inner_diameter: float | None = None
    hole_diameter: float | None = None
    shaft: float | None = None
    shaft_diameter: float | None = None
    nut_held: NutHeld | None = None
    screw_held: Literal["ends", "bore"] | None = None
    nut: Literal["elastic", "rigid"] = "elastic"
    nut_groove: Literal["through", "loaded"] = "through"


@dataclass(frozen=True)
class Friction:
    """Coulomb coefficients of the balls on the grooves of screw and nut; ``assumed``: where they come from.

    feedback: whether friction moves each ball across its grooves, or leaves the contact loads unchanged; neighbours:
    whether balls that touch push each other at the scene's instant (in a run in time they always do); balls:
    coefficient from ball to ball, ``None`` for the larger one of the grooves.
    """

    screw: float
    nut: float
    assumed: tuple[str, ...] = ()
    feedback: bool = True
    balls: float | None = None
    neighbours: bool = False

    @property
    def between_balls(self) -> float:
        """Coefficient of friction from ball to ball."""
        return max(self.screw, self.nut) if self.balls is None else self.balls


@dataclass(frozen=True)
class Motion:
    """Which part turns, and its angular speed about +z [rad/s]; the other part does not turn."""

    speed: float
    turns: Literal["screw", "nut"] = "screw"


@dataclass(frozen=True)
class Circulation:
    """How the balls of a screw go round: ``circuits`` closed tracks per start, each a loaded arc and a return.

    turns: loaded turns of each start over all its circuits (``None``: as many as its balls fill); returning: balls in the
    return of each circuit; gap: mean clearance between neighbouring balls of a circuit along its track [m], or filling: the
    fraction of a circuit that its balls would fill if they touched (neither: spaced in the return as on the loaded arc).
    """

    circuits: int = 1
    turns: float | None = None
    returning: int = 0
    gap: float | None = None
    filling: float | None = None


@dataclass(frozen=True)
class Time:
    """A run over an ``angle`` [rad] of the part that turns, or a ``duration`` [s]; one of them is given.

    steps: ``None`` for as many as keep the error of the steps below ``goal``, a fraction of the mean friction torque;
    output: histories of torque and balls, or only of the torque.
    """

    angle: float | None = None
    duration: float | None = None
    steps: int | None = None
    goal: float = 0.01
    output: Literal["balls", "torque"] = "balls"

    def span(self, motion: Motion) -> float:
        """Duration of the run [s] at a motion's speed."""
        if self.duration is not None:
            return self.duration
        return abs((self.angle or 0.0) / motion.speed)


@dataclass(frozen=True)
class GateLimits:
    """Limits [%] that a scene sets on errors against its 3D reference, ``None`` for the gate's own: ``max_error`` of any
    contact load, ``rms_error`` of all of them over the mean load."""

    max_error: float | None = None
    rms_error: float | None = None


@dataclass(frozen=True)
class Scene:
    """One load case of one ball screw or bearing. ``assumed``: statements about what the source leaves open."""

    name: str
    title: str
    track: Track
    screw: Screw
    nut: Nut
    balls: Balls
    errors: Errors = field(default_factory=Errors)
    supports: tuple[Support, ...] = ()
    loads: tuple[Load, ...] = ()
    ingredients: Ingredients = field(default_factory=Ingredients)
    solid: Solid = field(default_factory=Solid)
    source: str = ""
    assumed: tuple[str, ...] = ()
    members: int = 1
    friction: Friction | None = None
    motion: Motion | None = None
    role: str = field(default="", compare=False)
    circulation: Circulation | None = None
    time: Time | None = None
    gate: GateLimits = field(default_factory=GateLimits, compare=False)

    def __hash__(self) -> int:
        """Hash of the fields that are compared, kept once computed: many caches are looked up by scenes."""
        found: int | None = self.__dict__.get("_hash")
        if found is None:
            found = self.__dict__["_hash"] = hash(tuple(getattr(self, f.name) for f in fields(self) if f.compare))
        return found

    def __getstate__(self) -> dict[str, Any]:
        """Only the fields: words have another hash in another process."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def stations(self) -> list[float]:
        """Stations [m] of supports, then of loads."""
        return [*(x.at for x in self.supports), *(x.at for x in self.loads)]

    @property
    def ball_count(self) -> int:
        """Number of balls over all starts."""
        return len(self.balls.azimuths) * self.track.starts
