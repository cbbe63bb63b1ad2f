"""Description of the parts of a ball screw or ball bearing: plain records in SI units.

Both fidelities read these records and nothing else of each other.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Annotated, Any, Literal

from rollbench.meshes.fields import about, keyed, usual
from rollbench.meshes.ranges import (
    MAX_BALLS,
    Azimuth,
    Bore,
    Clearance,
    ContactAngle,
    Contamination,
    Density,
    Deviation,
    Duration,
    Element,
    Factor0,
    Filling,
    Forces,
    Harmonic,
    Lead,
    LoadStep,
    Modulus,
    Moments,
    Percent,
    Poisson,
    PressureViscosity,
    Radius,
    Reliability,
    Several,
    Size,
    SpeedLimit,
    Spread,
    Station,
    StepGoal,
    Travel,
    Turning,
    Turns,
    Viscosity,
    ViscosityRatio,
    Whole,
)

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

    youngs_modulus: Modulus
    poissons_ratio: Poisson

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))


@keyed
@dataclass(frozen=True)
class Track:
    """Nominal ball path (Lin 2.1, 2.2, 2.5): pitch radius [m], lead [m], hand, starts, contact angle [rad].

    ``phase`` [rad] is the azimuth of the helix at the nut's centre; a lead of zero is a ball bearing. ``arcs``: each groove
    is a gothic arch of two arcs, or, of a bearing, one arc, whose contacts then carry thrust on the screw this way.
    """

    pitch_radius: Radius
    lead: Lead
    contact_angle: ContactAngle
    hand: Literal["right", "left"] = usual("right")
    starts: int = usual(1)
    phase: Azimuth = usual(0.0)
    arcs: Literal["two", "+z", "-z"] = usual("two")


@keyed
@dataclass(frozen=True)
class Screw:
    """Screw shaft or inner ring: length, outer diameter, bore and groove radius [m], material."""

    length: Size
    outer_diameter: Size
    groove_radius: Radius
    material: Material
    bore: Bore = usual(0.0)


@keyed
@dataclass(frozen=True)
class Flange:
    """Flange at an end of a nut, within its length: outer diameter and thickness [m], ``side`` of the nut.

    ``seat``: radii [m] between which its face towards the rest of the nut may be held (``Solid.nut_held``); ``centring``:
    length [m] of the nut's outside from that face on that fits the housing's bore; ``bonded``: whether the fit holds the
    nut there too, or lets it go; ``bolts``: number of bolts, in each of which a circle as wide as the seat holds it in 3D,
    the first at azimuth 0 (0: all of the seat, as in low-order models).
    """

    diameter: Size
    thickness: Size
    seat: tuple[float, float]
    side: Literal["left", "right"] = usual("left")
    centring: Bore = usual(0.0)
    bonded: bool = usual(False)
    bolts: int = usual(0)

    def stations(self, low: float, high: float) -> tuple[float, float, float]:
        """Stations [m] of its outer face, of the face that may be held, and of the end of the fit, on a nut from ``low``
        to ``high`` [m]."""
        end, inwards = (low, 1.0) if self.side == "left" else (high, -1.0)
        return end, end + inwards * self.thickness, end + inwards * (self.thickness + self.centring)


@keyed
@dataclass(frozen=True)
class Nut:
    """Nut or outer ring: axial position of its centre, length, outer diameter and groove radius [m], material.

    ``azimuth`` [rad] is the angle psi_N between the axes of nut and screw (Lin 2.9), on which the nut's errors depend.
    """

    position: Station
    length: Size
    outer_diameter: Size
    groove_radius: Radius
    material: Material
    azimuth: Azimuth = usual(0.0)
    flange: Flange | None = usual(None)


@dataclass(frozen=True)
class Balls:
    """Balls: nominal radius [m], material, and the unwrapped azimuths [rad] of one start (each start has the same)."""

    radius: Radius
    material: Material
    azimuths: tuple[Azimuth, ...]


@keyed
@dataclass(frozen=True)
class FourierTerm:
    """One harmonic of an error along the track: sin * sin(harmonic * phi) + cos * cos(harmonic * phi).

    Amplitudes and sigma [m].
    """

    harmonic: Harmonic = field(metadata=about("cycles per turn; may be a fraction"))
    sin: Deviation = usual(0.0, "amplitude of the sine", "3 um")
    cos: Deviation = usual(0.0, "amplitude of the cosine", "3 um")
    sigma: Spread = usual(0.0, "standard deviation of normal draws added to both amplitudes", "1 um")


Terms = Annotated[tuple[FourierTerm, ...], Several(0, 1000)]


@keyed
@dataclass(frozen=True)
class SideErrors:
    """Errors of one groove flank: screw left (SL), screw right (SR), nut left (NL), nut right (NR).

    All in m (Lin 2.27, 4.1, 4.3); gamma in rad.
    """

    profile: Annotated[tuple[Deviation, ...], Several(0, 7)] = usual(
        (), "inward offset of the groove radius: coefficients of a polynomial in gamma / rad", ["3 um", "-1 um"]
    )
    profile_sigma: Annotated[tuple[Spread, ...], Several(0, 7)] = usual(
        (), "standard deviations of normal draws added to the coefficients of profile", ["1 um", "0 um"]
    )
    pitch: Terms = usual((), "displacement of the groove centre along the screw", [{"harmonic": 1, "sin": "3 um"}])
    pitch_along: Literal["section", "axis"] = usual(
        "section", "direction of the pitch error: in the groove's section (Lin 2.27) or along the axis (Lin 4.1)", "section"
    )
    roundness: Terms = usual((), "displacement of the groove centre along the radius", [{"harmonic": 2, "cos": "5 um"}])


@keyed
@dataclass(frozen=True)
class BallErrors:
    """Errors of the ball radii [m]: the same ``oversize`` for all, ``listed`` by ball number (from 1), and random."""

    oversize: Deviation = usual(0.0)
    listed: tuple[tuple[int, float], ...] = usual(())
    sigma: Spread = usual(0.0)
    distribution: Literal["normal", "uniform"] = usual("normal")


@keyed
@dataclass(frozen=True)
class Errors:
    """All geometric errors of a scene, and the seed of every random one.

    ``lead_offset`` [m]: shift along the axis of the nut's groove beyond the nut's centre (z above its position) against the
    rest of it, by which a single nut is preloaded in two-point contact.
    """

    balls: BallErrors = usual(BallErrors())
    SL: SideErrors = usual(SideErrors())
    SR: SideErrors = usual(SideErrors())
    NL: SideErrors = usual(SideErrors())
    NR: SideErrors = usual(SideErrors())
    seed: int = usual(0)
    lead_offset: float = usual(0.0)

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

    at: Station
    fixed: tuple[tuple[str, float], ...]


@keyed
@dataclass(frozen=True)
class Load:
    """Load on the screw at one station, applied on the axis.

    Station [m], force [N], moment [N m].
    """

    at: Station = field(metadata=about("station along the screw", "0 mm"))
    force: Forces = usual((0.0, 0.0, 0.0), "force along x, y, z", ["0 N", "0 N", "5 kN"])
    moment: Moments = usual((0.0, 0.0, 0.0), "moment about x, y, z", ["0 N m", "3 N m", "0 N m"])


@keyed
@dataclass(frozen=True)
class Ingredients:
    """Which parts of the low-order model are used.

    Constants at the nominal angle are those of each contact's own radii; a source's nodes outside the nut are about the
    pitch diameter apart; with the arm of the ball's station the force still acts at the current contact point.
    """

    hertz: Literal["nominal", "error-free", "actual", "as printed"] = usual(
        "nominal",
        "contact constants: own radii at the nominal angle, error-free parts, actual geometry, or as in Table B.1",
        "actual",
    )
    screw: Literal["beam", "rigid"] = usual("beam", "screw as Timoshenko beam or rigid", "rigid")
    partition: Literal["nodal", "source", "uniform"] = usual(
        "nodal", "beam nodes: at every contact, as the source (15 mm in the nut), or every element_length", "source"
    )
    element_length: Element = usual(1.0e-3, 'length of the elements in the nut, for partition = "uniform"')
    section: Literal["groove", "groove squared", "full"] = usual(
        "groove", "beam section: diameters scaled by k_r (Lin C.8), by k_r without the root, or full", "full"
    )
    arm: Literal["current", "nominal", "ball"] = usual(
        "current",
        "lever arm of a contact force: current contact point, nominal contact point, or the ball's station",
        "nominal",
    )
    load_step: LoadStep | None = usual(
        None, "further axial load over which the model liu also takes its stiffness (Liu's 22)", "600 N"
    )


@keyed
@dataclass(frozen=True)
class Solid:
    """What the 3D reference needs beyond the low-order model; a key left out stands for an assumption, which is printed.

    Lengths in m; assumptions by `meshes.solid`; a groove that is not through: `meshes.groove.GrooveEnds`.
    """

    nut_inner_diameter: Size | None = usual(None, "diameter of the nut's lands; mirrors the screw's if left out", "34 mm")
    hole_diameter: Size | None = usual(None, "hole along the meshed screw where it has no bore", "3 mm")
    shaft: Station | None = usual(None, "length of 3D shaft beyond each face of the nut; a beam continues it", "20 mm")
    shaft_diameter: Size | None = usual(
        None, "diameter of the plain shaft beyond the 3D stretch; the homogenised grooved shaft if left out", "31 mm"
    )
    nut_held: NutHeld | None = usual(None, "former key of nut.held.at", "left face")
    screw_held: Literal["ends", "bore"] | None = usual(
        None, "whether supports and loads reach the screw through its ends or through a stiff shaft in its bore", "ends"
    )
    nut: Literal["elastic", "rigid"] = usual("elastic", "nut elastic, or rigid beyond its contact patches", "elastic")
    nut_groove: Literal["through", "loaded"] = usual(
        "through",
        "groove through the whole nut, or filled from two ball diameters beyond the outermost balls on",
        "through",
    )


@keyed
@dataclass(frozen=True)
class Friction:
    """Coulomb coefficients of the balls on the grooves of screw and nut; ``assumed``: where they come from.

    feedback: whether friction moves each ball across its grooves, or leaves the contact loads unchanged; neighbours:
    whether balls that touch push each other at the scene's instant (in a run in time they always do); balls:
    coefficient from ball to ball, ``None`` for the larger one of the grooves.
    """

    screw: float
    nut: float
    assumed: tuple[str, ...] = usual(())
    feedback: bool = usual(True)
    balls: float | None = usual(None)
    neighbours: bool = usual(False)

    @property
    def between_balls(self) -> float:
        """Coefficient of friction from ball to ball."""
        return max(self.screw, self.nut) if self.balls is None else self.balls


@keyed
@dataclass(frozen=True)
class Motion:
    """Which part turns and how fast, for: rollbench friction.

    Angular speed [rad/s].
    """

    speed: Turning = field(metadata=about("angular speed of the part that turns, about +z; negative: the other way"))
    turns: Literal["screw", "nut"] = usual(
        "screw", "the part that turns; the other one does not, and they move apart along the axis by the lead", "nut"
    )


@keyed
@dataclass(frozen=True)
class Lubricant:
    """Oil, or base oil of a grease, at the temperature of running: kinematic viscosity [m^2/s] and density [kg/m^3] at
    ambient pressure, rise of the viscosity's logarithm with pressure [1/Pa]; how it gets to rows of balls."""

    viscosity: Viscosity = field(metadata=about("kinematic viscosity at the temperature of running", "27 mm2/s"))
    density: Density = usual(900.0, "density", "900 kg/m3")
    pressure_viscosity: PressureViscosity = usual(
        20e-9, "rise of the logarithm of the viscosity with pressure, for the film between rollers and races", "20 1/GPa"
    )
    supply: Literal["grease", "oil mist", "oil bath", "oil jet"] = usual(
        "grease", "how rows of balls are lubricated, for Palmgren's factor f0", "oil bath"
    )
    factor: Factor0 | None = usual(None, "the maker's factor f0 of a row of balls, in place of the published range", 2)

    @property
    def dynamic_viscosity(self) -> float:
        """Dynamic viscosity at ambient pressure [Pa s]."""
        return self.viscosity * self.density


@keyed
@dataclass(frozen=True)
class Circulation:
    """How the balls of a screw go round, for: rollbench friction.

    Each circuit is a loaded arc and a return; without gap [m] and filling the balls in the return are spaced as on the arc.
    """

    circuits: Annotated[int, Whole(1, 1000)] = usual(1, "closed circuits that share the balls of each start equally", 1)
    turns: Turns | None = usual(
        None, "loaded turns of each start, all circuits together; left out: those that its balls fill"
    )
    returning: Annotated[int, Whole(0, MAX_BALLS)] = usual(0, "balls in the return of each circuit", 4)
    gap: Clearance | None = usual(None, "mean clearance between neighbouring balls along a circuit (or filling)", "50 um")
    filling: Filling | None = usual(None, "part of a circuit that its balls would fill if they touched (or gap)", 0.8)


@keyed
@dataclass(frozen=True)
class Time:
    """A run in time, for: rollbench friction. Give angle or duration.

    Angle [rad], duration [s].
    """

    angle: Travel | None = usual(None, "angle that the part that turns covers", "360 deg")
    duration: Duration | None = usual(None, "duration (or angle)", "1 s")
    steps: Annotated[int, Whole(1, 100_000)] | None = usual(
        None, "number of steps, from 4; left out: as many as keep the errors of the steps below goal", 200
    )
    goal: StepGoal = usual(
        0.01, "largest error of the steps, as a part of the mean friction torque: beyond it the run has not converged", 0.01
    )
    output: Literal["balls", "torque"] = usual(
        "balls", "histories in the JSON result: of torque and balls, or of torque", "balls"
    )

    def span(self, motion: Motion) -> float:
        """Duration of the run [s] at a motion's speed."""
        if self.duration is not None:
            return self.duration
        return abs((self.angle or 0.0) / motion.speed)


@keyed
@dataclass(frozen=True)
class GateLimits:
    """Limits of this scene for: rollbench check."""

    max_error: Percent | None = usual(
        None, "limit of the error of any contact load against the 3D reference, in per cent", 7
    )
    rms_error: Percent | None = usual(None, "limit of the RMS error of the contact loads, in per cent of the mean load", 3)


@keyed
@dataclass(frozen=True)
class Operation:
    """What modifies the life, and what the return of the balls bears."""

    reliability: Reliability | None = usual(None, "share that reaches the modified life, in per cent", 95)
    viscosity_ratio: ViscosityRatio | None = usual(
        None, "kappa of ISO 281: viscosity of the lubricant at work over that it should have (with contamination)", 1.5
    )
    contamination: Contamination | None = usual(
        None,
        "e_C of ISO 281: 1 extremely clean, 0.8 to 0.6 sealed, 0.3 to 0.1 coarsely filtered (with viscosity_ratio)",
        0.6,
    )
    dn_limit: SpeedLimit = usual(76_200.0, "largest pitch diameter times speed, in mm/min, by the maker", 120_000)


@keyed
@dataclass(frozen=True)
class Scene:
    """One load case of one ball screw or bearing. ``assumed``: statements about what the source leaves open."""

    name: str
    title: str
    track: Track
    screw: Screw
    nut: Nut
    balls: Balls
    errors: Errors = usual(Errors())
    supports: tuple[Support, ...] = usual(())
    loads: tuple[Load, ...] = usual(())
    ingredients: Ingredients = usual(Ingredients())
    solid: Solid = usual(Solid())
    source: str = usual("")
    assumed: tuple[str, ...] = usual(())
    members: int = usual(1)
    friction: Friction | None = usual(None)
    motion: Motion | None = usual(None)
    role: str = usual("", compare=False)
    circulation: Circulation | None = usual(None)
    time: Time | None = usual(None)
    gate: GateLimits = usual(GateLimits(), compare=False)
    operation: Operation = usual(Operation(), compare=False)
    lubricant: Lubricant | None = usual(None)

    def __hash__(self) -> int:
        """Hash of the fields that are compared, kept once computed: many caches are looked up by scenes."""
        found: int | None = self.__dict__.get("_hash")
        if found is None:
            found = self.__dict__["_hash"] = hash(tuple(getattr(self, f.name) for f in fields(self) if f.compare))
        return found

    def __getstate__(self) -> dict[str, Any]:
        """Only the fields: words have another hash in another process."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def to_toml(self) -> str:
        """Text of a scene file that is read as this scene."""
        from rollbench.meshes.scene_text import scene_tables, to_toml

        return to_toml(scene_tables(self))

    @property
    def stations(self) -> list[float]:
        """Stations [m] of supports, then of loads."""
        return [*(x.at for x in self.supports), *(x.at for x in self.loads)]

    @property
    def ball_count(self) -> int:
        """Number of balls over all starts."""
        return len(self.balls.azimuths) * self.track.starts
