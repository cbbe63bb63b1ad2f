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
#: groove section (x3 radial, z3 along the binormal), one row per flank (Lin 2019, Figure 2.4).
SIDE_SIGNS = ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0))

#: Freedoms of a station of the screw: displacements along x, y, z and small rotations about them.
FREEDOMS = ("ux", "uy", "uz", "rx", "ry", "rz")

#: Surfaces by which a nut may be fixed: the inner and outer halves of a face are rings on both sides of the middle of
#: its width.
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
    """Error of a scene whose parts cannot be built, or not be solved by a model."""

    def __init__(self, key: str, reason: str) -> None:
        """Keep the scene's key (``"nut.outer_diameter"``) and the reason, which is the message."""
        super().__init__(key, reason)
        self.key = key

    def __str__(self) -> str:
        """Return the reason."""
        return str(self.args[1])


@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic material."""

    #: Young's modulus E [Pa].
    youngs_modulus: Modulus
    #: Poisson's ratio nu.
    poissons_ratio: Poisson

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa].

        Examples
        --------
        >>> round(Material(210e9, 0.28).shear_modulus / 1e9, 2)
        82.03
        """
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))


@keyed
@dataclass(frozen=True)
class Track:
    """Nominal ball path of a screw or bearing (Lin 2019, 2.1, 2.2, 2.5)."""

    #: Pitch radius R_p [m].
    pitch_radius: Radius
    #: Lead [m]; 0 for a bearing.
    lead: Lead
    #: Nominal contact angle beta [rad].
    contact_angle: ContactAngle
    #: Hand of the helix.
    hand: Literal["right", "left"] = usual("right")
    #: Number of starts.
    starts: int = usual(1)
    #: Azimuth of the helix at the nut's centre [rad].
    phase: Azimuth = usual(0.0)
    #: Arcs of each groove: ``"two"`` for a gothic arch; of a bearing also one arc, whose contacts carry thrust on the
    #: shaft along ``"+z"`` or ``"-z"``.
    arcs: Literal["two", "+z", "-z"] = usual("two")


@keyed
@dataclass(frozen=True)
class Screw:
    """Screw shaft, or inner ring of a bearing."""

    #: Length [m], from station 0 on.
    length: Size
    #: Diameter of the lands [m].
    outer_diameter: Size
    #: Radius of the groove's arcs [m].
    groove_radius: Radius
    #: Elastic material.
    material: Material
    #: Diameter of the bore [m]; 0: solid.
    bore: Bore = usual(0.0)


@keyed
@dataclass(frozen=True)
class Flange:
    """Flange at one end of a nut, within the nut's length."""

    #: Outer diameter [m].
    diameter: Size
    #: Thickness [m].
    thickness: Size
    #: Radii [m] between which the face towards the rest of the nut may be fixed (``Solid.nut_held``).
    seat: tuple[float, float]
    #: End of the nut at which the flange is.
    side: Literal["left", "right"] = usual("left")
    #: Length of the nut's outer surface, from that face on, that fits the bore of the housing [m].
    centring: Bore = usual(0.0)
    #: Whether the centring fit fixes the nut too, or leaves it free.
    bonded: bool = usual(False)
    #: Number of bolts; the 3D reference fixes a circle as wide as the seat at each, the first at azimuth 0. 0 fixes all
    #: of the seat, as low-order models always do.
    bolts: int = usual(0)

    def stations(self, low: float, high: float) -> tuple[float, float, float]:
        """Axial places of a flange on a nut.

        Parameters
        ----------
        low, high : float
            Stations of the nut's ends [m].

        Returns
        -------
        outer : float
            Station of the flange's outer face [m].
        seat : float
            Station of the face that may be fixed [m].
        centring : float
            Station of the end of the centring fit [m].

        Examples
        --------
        >>> Flange(0.1, 0.02, (0.03, 0.05), centring=0.01).stations(0.4, 0.5)
        (0.4, 0.42000000000000004, 0.43000000000000005)
        """
        end, inwards = (low, 1.0) if self.side == "left" else (high, -1.0)
        return end, end + inwards * self.thickness, end + inwards * (self.thickness + self.centring)


@keyed
@dataclass(frozen=True)
class Nut:
    """Nut, or outer ring of a bearing."""

    #: Station of its centre [m].
    position: Station
    #: Length [m].
    length: Size
    #: Outer diameter [m].
    outer_diameter: Size
    #: Radius of the groove's arcs [m].
    groove_radius: Radius
    #: Elastic material.
    material: Material
    #: Angle psi_N from the axes of the screw to those of the nut [rad], on which the nut's errors depend (Lin 2.9).
    azimuth: Azimuth = usual(0.0)
    #: Flange, if any.
    flange: Flange | None = usual(None)


@dataclass(frozen=True)
class Balls:
    """Balls of one screw or bearing."""

    #: Nominal radius [m].
    radius: Radius
    #: Elastic material.
    material: Material
    #: Unwrapped azimuths of the balls of one start [rad]; the other starts have the same, shifted by their offsets.
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
    """Errors of the ball radii."""

    #: Error that all radii share [m].
    oversize: Deviation = usual(0.0)
    #: Pairs of a ball's number (from 1) and the further error of its radius [m].
    listed: tuple[tuple[int, float], ...] = usual(())
    #: Standard deviation of a random error of each radius [m].
    sigma: Spread = usual(0.0)
    #: Distribution of the random errors; a uniform one has the half width sqrt(3) sigma.
    distribution: Literal["normal", "uniform"] = usual("normal")


@keyed
@dataclass(frozen=True)
class Errors:
    """All geometric errors of a scene, and the seed of its random ones."""

    #: Errors of the ball radii.
    balls: BallErrors = usual(BallErrors())
    #: Errors of the screw's left flank.
    SL: SideErrors = usual(SideErrors())
    #: Errors of the screw's right flank.
    SR: SideErrors = usual(SideErrors())
    #: Errors of the nut's left flank.
    NL: SideErrors = usual(SideErrors())
    #: Errors of the nut's right flank.
    NR: SideErrors = usual(SideErrors())
    #: Seed of all random draws.
    seed: int = usual(0)
    #: Axial shift [m] of the nut's groove beyond the nut's centre (z above its position) against the rest, by which a
    #: single nut is preloaded in two-point contact.
    lead_offset: float = usual(0.0)

    def side(self, name: str) -> SideErrors:
        """Errors of the flank of a name out of `SIDES`.

        Parameters
        ----------
        name : str
            SL, SR, NL or NR.

        Returns
        -------
        SideErrors
            Errors of that flank.
        """
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
    """Support of the screw."""

    #: Station [m].
    at: Station
    #: Pairs of a freedom (of `FREEDOMS`) and its prescribed displacement [m] or rotation [rad].
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
        "lever arm of a contact load: current contact point, nominal contact point, or the ball's station",
        "nominal",
    )
    load_step: LoadStep | None = usual(
        None, "further axial load over which the model liu also takes its stiffness (Liu's 22)", "600 N"
    )


@keyed
@dataclass(frozen=True)
class Solid:
    """Inputs that only the 3D reference uses; a missing key is replaced by an assumption, which is printed."""

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
    """Coulomb friction of the balls."""

    #: Coefficient on the grooves of the screw.
    screw: float
    #: Coefficient on the grooves of the nut.
    nut: float
    #: Where the coefficients come from.
    assumed: tuple[str, ...] = usual(())
    #: Whether friction moves each ball across its grooves, or leaves the contact loads unchanged.
    feedback: bool = usual(True)
    #: Coefficient between balls; None for the larger one of the grooves.
    balls: float | None = usual(None)
    #: Whether balls in touch push each other at the scene's instant; in a run in time they always do.
    neighbours: bool = usual(False)

    @property
    def between_balls(self) -> float:
        """Coefficient of friction between balls."""
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
    """Oil, or base oil of a grease, at running temperature and ambient pressure.

    Viscosity [m^2/s], density [kg/m^3], pressure coefficient [1/Pa].
    """

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
        """Dynamic viscosity at ambient pressure [Pa s].

        Examples
        --------
        >>> round(Lubricant(100e-6, 900.0).dynamic_viscosity, 4)
        0.09
        """
        return self.viscosity * self.density


@keyed
@dataclass(frozen=True)
class Circulation:
    """Circulation of the balls of a screw, for ``rollbench friction``."""

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
        """Duration of the run [s]: as given, or the angle over the speed of the motion.

        Parameters
        ----------
        motion : Motion
            Gives the speed.

        Returns
        -------
        float
            [s].

        Examples
        --------
        >>> Time(angle=6.0).span(Motion(speed=-3.0))
        2.0
        """
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
    """Conditions that modify the life, and the limit of the balls' return."""

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
    """One load case of one ball screw or bearing, in SI units; the input of every model."""

    #: Name of the scene.
    name: str
    #: Title of the scene.
    title: str
    #: Nominal ball path.
    track: Track
    #: Screw shaft or inner ring.
    screw: Screw
    #: Nut or outer ring.
    nut: Nut
    #: Balls of one start.
    balls: Balls
    #: Geometric errors.
    errors: Errors = usual(Errors())
    #: Supports of the screw.
    supports: tuple[Support, ...] = usual(())
    #: Loads on the screw.
    loads: tuple[Load, ...] = usual(())
    #: Parts of the low-order model that are used.
    ingredients: Ingredients = usual(Ingredients())
    #: Further inputs of the 3D reference.
    solid: Solid = usual(Solid())
    #: Where the case comes from.
    source: str = usual("")
    #: Statements about what the source leaves open.
    assumed: tuple[str, ...] = usual(())
    #: Number of specimens with different random errors.
    members: int = usual(1)
    #: Coulomb friction of the balls.
    friction: Friction | None = usual(None)
    #: Which part turns, and how fast.
    motion: Motion | None = usual(None)
    #: Role in the report of a shipped scene.
    role: str = usual("", compare=False)
    #: Circulation of the balls.
    circulation: Circulation | None = usual(None)
    #: Run in time.
    time: Time | None = usual(None)
    #: Limits of errors against the 3D reference.
    gate: GateLimits = usual(GateLimits(), compare=False)
    #: Conditions that modify the life.
    operation: Operation = usual(Operation(), compare=False)
    #: Oil or base oil.
    lubricant: Lubricant | None = usual(None)

    def __hash__(self) -> int:
        """Hash of the fields that are compared, computed once: many caches look up scenes."""
        found: int | None = self.__dict__.get("_hash")
        if found is None:
            found = self.__dict__["_hash"] = hash(tuple(getattr(self, f.name) for f in fields(self) if f.compare))
        return found

    def __getstate__(self) -> dict[str, Any]:
        """Only the fields: a hash of text differs in another process."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def to_toml(self) -> str:
        """Text of a scene file that reads back as this scene."""
        from rollbench.meshes.scene_text import scene_tables, to_toml

        return to_toml(scene_tables(self))

    @property
    def stations(self) -> list[float]:
        """Stations of the supports, then of the loads [m]."""
        return [*(x.at for x in self.supports), *(x.at for x in self.loads)]

    @property
    def ball_count(self) -> int:
        """Number of balls over all starts."""
        return len(self.balls.azimuths) * self.track.starts
