"""Records that describe a ball screw or ball bearing with its loads (a scene), in SI units.

The low-order models and the 3D reference both read these records, and share nothing else.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any, ClassVar, Literal

from rollbench.meshes import ranges
from rollbench.meshes.record_keys import frozen_default, frozen_record, scene_key
from rollbench.meshes.scene_text import Table, fixed_keys, keys_of_record, toml_of_tables, with_unit, without_empty_values
from rollbench.meshes.stated import ball_spacing_table, clearance_table, groove_table

#: Names of the four flanks in the order of the columns of every ``(n, 4)`` array: screw left, right; nut left, right.
SIDES = ("SL", "SR", "NL", "NR")

#: Unit factors ``(s_x, s_z)`` of the contact direction ``(s_x cos(gamma), s_z sin(gamma))`` in the plane of the
#: groove section (x3 radial, z3 across the track), one row per flank (Lin 2019, Figure 2.4).
SIDE_SIGNS = ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0))

#: Degrees of freedom of a cross-section of the screw: displacements along x, y, z and small rotations about these axes.
FREEDOMS = ("ux", "uy", "uz", "rx", "ry", "rz")

#: Descriptions of the keys at the head of every scene file.
TITLE = "title of the scene, in one line"
SOURCE = "publication or data sheet from which the data are taken"
ASSUMED = "assumptions on what the source does not state, as sentences"

#: Keys with which a scene file begins, in order.
FIRST = ("title", "source", "assumed", "kind", "role", "members", "material")

#: Surfaces at which a nut may be fixed. The inner and outer halves of a face are the two rings of equal width that form it.
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
    """Error of a scene that cannot be built or solved; it names the key of the scene file that is the cause."""

    def __init__(self, key: str, reason: str) -> None:
        """Store the key that is the cause, such as ``"nut.outer_diameter"``, and the reason, which is the message."""
        super().__init__(key, reason)
        self.key = key

    def __str__(self) -> str:
        """Return the reason for the error as the message."""
        return str(self.args[1])


@frozen_record
class Material:
    """Isotropic linear elastic material."""

    youngs_modulus: ranges.Modulus = scene_key("Young's modulus")
    poissons_ratio: ranges.Poisson = scene_key("Poisson's ratio")

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa].

        Examples
        --------
        >>> round(Material(210e9, 0.28).shear_modulus / 1e9, 2)
        82.03
        """
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))

    def file_keys(self, shared: Material | None) -> Table:
        """Return the key ``material`` of a part of this material.

        Parameters
        ----------
        shared : Material | None
            Material at the head of the scene file, of which a part needs no key; None: the key is always wanted.

        Returns
        -------
        Table
            The key with its value, or nothing.
        """
        if self == shared:
            return {}
        unusual = not ranges.SOLIDS[0] <= self.youngs_modulus <= ranges.SOLIDS[1]
        return {"material": ({"unusual": True} if unusual else {}) | keys_of_record(self)}


@frozen_record
class Washers:
    """Dimensions of both washers of a thrust ball bearing, whose grooves open in their faces; the models assume others."""

    bore: ranges.Size | None = frozen_default(None, "bore of both washers", "20 mm")
    outer_diameter: ranges.Size | None = frozen_default(None, "outer diameter of both washers", "35 mm")
    thickness: ranges.Size | None = frozen_default(
        None, "thickness of both washers beside the groove, from face to back", "3.8 mm"
    )
    groove_depth: ranges.Size | None = frozen_default(None, "depth of the groove below the washer's face", "1.2 mm")


@frozen_record
class Track:
    """Nominal path of the ball centres in a screw or bearing, and number of arcs of each groove.

    Lin (2019), equations 2.1, 2.2 and 2.5.
    """

    pitch_radius: ranges.Size = scene_key("radius of the helix of the ball centres", "16.5 mm")
    lead: ranges.Lead = scene_key('lead: advance of the helix per turn; "0 mm" for a ball bearing')
    contact_angle: ranges.TrackAngle = scene_key("nominal angle between contact normal and radius")
    hand: Literal["right", "left"] = frozen_default("right", "hand of the helix", "right")
    starts: ranges.Starts = frozen_default(1, "number of thread starts, evenly spaced around the axis", 1)
    phase: ranges.Azimuth = frozen_default(0.0, "azimuth of the helix at the nut's centre", "0 deg")
    #: Arcs of each groove: ``"two"`` for a gothic arch. A bearing may also have one arc, which carries thrust on the shaft
    #: in the direction ``"+z"`` or ``"-z"``.
    arcs: Literal["two", "+z", "-z"] = frozen_default("two")
    washers: Washers = frozen_default(
        Washers(), "dimensions of the washers of a thrust ball bearing, at contact angles above 45 deg", {"bore": "20 mm"}
    )


@frozen_record
class Screw:
    """Dimensions and material of a screw shaft, or of the inner ring of a bearing."""

    length: ranges.Size = scene_key("length of the screw; positions along the screw run from 0 to this length", "800 mm")
    outer_diameter: ranges.Size = scene_key("outer diameter of the thread, or of the inner ring's shoulders", "32 mm")
    #: Radius of the groove's arcs [m].
    groove_radius: ranges.Radius
    #: Elastic material.
    material: Material
    bore: ranges.Bore = frozen_default(0.0, "diameter of the hole along the axis", "10 mm")


@frozen_record
class Flange:
    """Dimensions of the flange at one end of a nut, and how it is fixed; the nut's length includes the flange."""

    diameter: ranges.Size = scene_key("outer diameter of the flange", "72 mm")
    thickness: ranges.Size = scene_key("thickness of the flange", "11 mm")
    #: Inner and outer radius [m] of the ring that may be fixed, on the face towards the rest of the nut.
    seat: tuple[float, float]
    side: Literal["left", "right"] = frozen_default("left", "end of the nut at which the flange is", "right")
    centring: ranges.Bore = frozen_default(
        0.0, "length of the nut's outer surface, from the flange on, that fits into the bore of the housing", "10 mm"
    )
    #: Whether the nut is fixed at the centring fit too (True), or is free there.
    bonded: bool = frozen_default(False)
    #: Number of bolts. At each bolt the 3D reference fixes a circle as wide as the ring ``seat``; the first bolt is at
    #: azimuth 0. With 0 bolts the whole ring is fixed, as it always is in the low-order models.
    bolts: int = frozen_default(0)

    def stations(self, low: float, high: float) -> tuple[float, float, float]:
        """Return the axial positions of the flange's two faces and of the end of its centring fit.

        Parameters
        ----------
        low, high : float
            Axial positions of the nut's ends [m].

        Returns
        -------
        outer : float
            Axial position of the flange's outer face [m].
        seat : float
            Axial position of the face that may be fixed [m].
        centring : float
            Axial position of the end of the centring fit [m].

        Examples
        --------
        >>> Flange(0.1, 0.02, (0.03, 0.05), centring=0.01).stations(0.4, 0.5)
        (0.4, 0.42000000000000004, 0.43000000000000005)
        """
        end, inwards = (low, 1.0) if self.side == "left" else (high, -1.0)
        return end, end + inwards * self.thickness, end + inwards * (self.thickness + self.centring)


@frozen_record
class Nut:
    """Dimensions, position and material of a nut, or of the outer ring of a bearing."""

    position: ranges.Station = scene_key("axial position of the nut's centre, from the left end of the screw", "400 mm")
    length: ranges.Size = scene_key("length of the nut or outer ring", "54 mm")
    outer_diameter: ranges.Size = scene_key("outer diameter of the nut or outer ring", "48 mm")
    #: Radius of the groove's arcs [m].
    groove_radius: ranges.Radius
    #: Elastic material.
    material: Material
    azimuth: ranges.Azimuth = frozen_default(
        0.0,
        "angle from the screw's x axis to the nut's x axis; the nut's errors are defined in the axes of the nut",
        "0 deg",
    )
    #: Flange; None for a nut without flange.
    flange: Flange | None = frozen_default(None)

    def file_keys(self, ball_radius: float, held_at: NutHeld | None, shared: Material) -> Table:
        """Return the keys of the nut in a scene file, with its flange and the surface at which it is fixed (``held``).

        Parameters
        ----------
        ball_radius : float
            Radius of the balls [m].
        held_at : NutHeld | None
            Surface at which the nut is fixed; None: not stated.
        shared : Material
            Material at the head of the scene file; a nut of this material gets no key for it.

        Returns
        -------
        Table
            Keys and their values, with units.
        """
        flange, held = self.flange, without_empty_values(at=held_at)
        if flange is not None and held_at in (None, "flange face"):
            seat = 0.5 * self.outer_diameter, 0.5 * flange.diameter
            for name, radius, whole in zip(("inner_diameter", "outer_diameter"), flange.seat, seat, strict=True):
                held |= {} if radius == whole else {name: with_unit(ranges.Size, 2.0 * radius)}
            held |= ({"centring": "bonded"} if flange.bonded else {}) | ({"bolts": flange.bolts} if flange.bolts else {})
        own = {} if flange is None else {"flange": keys_of_record(flange)}
        return _dimensions_and_material(self, ball_radius, shared) | own | without_empty_values(held=held)


def _dimensions_and_material(part: Screw | Nut, ball_radius: float, shared: Material) -> Table:
    """Return the keys of a screw or nut in a scene file: dimensions, groove (beside the ball radius [m]) and material.

    ``shared``: material at the head of the scene file; a part of this material gets no key for it.
    """
    return keys_of_record(part) | groove_table(part.groove_radius, ball_radius) | part.material.file_keys(shared)


@frozen_record
class Balls:
    """Radius, material and azimuths of the balls of a screw or bearing."""

    radius: ranges.Radius = scene_key("nominal ball radius")
    #: Elastic material of the balls.
    material: Material
    #: Azimuths of the balls of the first thread start [rad], counted on over whole turns. The balls of each further start
    #: have these azimuths plus the offset of that start.
    azimuths: tuple[ranges.Azimuth, ...]

    def file_keys(self, track: Track, shared: Material) -> Table:
        """Return the keys of the balls in a scene file.

        Parameters
        ----------
        track : Track
            Path of the ball centres.
        shared : Material
            Material at the head of the scene file; balls of this material get no key for it.

        Returns
        -------
        Table
            Keys and their values, with units.
        """
        spacing = ball_spacing_table(self.azimuths, track.phase, track.starts)
        return {"radius": with_unit(ranges.Size, self.radius)} | spacing | self.material.file_keys(shared)


@frozen_record
class FourierTerm:
    """One harmonic of a manufacturing error along the track: sin * sin(harmonic * phi) + cos * cos(harmonic * phi).

    Amplitudes and standard deviation are in metres; phi is the azimuth.
    """

    #: Keys of which a scene file states at least one.
    ONE_OF: ClassVar = ("sin", "cos", "sigma")

    harmonic: ranges.Harmonic = scene_key("cycles per turn; may be a fraction")
    sin: ranges.Deviation = frozen_default(0.0, "amplitude of the sine", "3 um")
    cos: ranges.Deviation = frozen_default(0.0, "amplitude of the cosine", "3 um")
    sigma: ranges.Spread = frozen_default(
        0.0, "standard deviation of the normally distributed random numbers that are added to both amplitudes", "1 um"
    )


#: Type of the Fourier terms of one manufacturing error along the track.
Terms = Annotated[tuple[Annotated[FourierTerm, ranges.OneKeyNeeded(1)], ...], ranges.ListLength(0, 1000)]


@frozen_record
class SideErrors:
    """Manufacturing errors of one groove flank: screw left (SL), screw right (SR), nut left (NL) or nut right (NR).

    Lengths are in metres, the section angle gamma in radians. Lin (2019), equations 2.27, 4.1 and 4.3.
    """

    profile: Annotated[tuple[ranges.Deviation, ...], ranges.ListLength(0, 7)] = frozen_default(
        (),
        "profile error: offset of the groove surface towards its arc's centre, as coefficients of a polynomial in "
        "the section angle gamma [rad], by ascending powers",
        ["3 um", "-1 um"],
    )
    profile_sigma: Annotated[tuple[ranges.Spread, ...], ranges.ListLength(0, 7)] = frozen_default(
        (),
        "standard deviations of the normally distributed random numbers that are added to the coefficients of profile",
        ["1 um", "0 um"],
    )
    pitch: Terms = frozen_default(
        (),
        "pitch error: displacement of the centre of the groove's arc along the screw, as Fourier terms over the azimuth",
        [{"harmonic": 1, "sin": "3 um"}],
    )
    pitch_along: Literal["section", "axis"] = frozen_default(
        "section",
        "direction of the pitch error: in the section normal to the helix (Lin 2.27), or along the axis (Lin 4.1)",
        "section",
    )
    roundness: Terms = frozen_default(
        (),
        "roundness error: radial displacement of the centre of the groove's arc, as Fourier terms over the azimuth",
        [{"harmonic": 2, "cos": "5 um"}],
    )


@frozen_record
class BallErrors:
    """Errors of ball radii: an error common to all balls, additional errors of single balls, and random errors."""

    oversize: ranges.Deviation = frozen_default(
        0.0, "length added to the radius of every ball (preload if positive)", "7 um"
    )
    #: Number of a ball (from 1) and additional error of its radius [m], one pair for each ball that has such an error.
    listed: tuple[tuple[int, float], ...] = frozen_default(())
    sigma: ranges.Spread = frozen_default(0.0, "standard deviation of random radius errors", "1 um")
    #: A uniform distribution has the half width sqrt(3) sigma.
    distribution: Literal["normal", "uniform"] = frozen_default("normal", "distribution of the random errors", "normal")


@frozen_record
class Errors:
    """All manufacturing errors of balls and grooves of a scene, and the seed of the random errors."""

    seed: ranges.Seed = frozen_default(0, "seed of all random errors", 2019)
    balls: BallErrors = frozen_default(BallErrors(), "errors of the ball radii", {"oversize": "7 um"})
    SL: SideErrors = frozen_default(SideErrors(), "errors of the screw's left flank", {"profile": ["3 um"]})
    SR: SideErrors = frozen_default(SideErrors(), "errors of the screw's right flank", {"profile": ["3 um"]})
    NL: SideErrors = frozen_default(SideErrors(), "errors of the nut's left flank", {"profile": ["3 um"]})
    NR: SideErrors = frozen_default(SideErrors(), "errors of the nut's right flank", {"profile": ["3 um"]})
    #: Axial offset between the two halves of the nut's groove [m]: shift of the half at larger z than the nut's centre. It
    #: preloads a single nut in two-point contact.
    lead_offset: float = frozen_default(0.0)

    def side(self, name: str) -> SideErrors:
        """Return the errors of a flank.

        Parameters
        ----------
        name : str
            Name of the flank: SL (screw left), SR (screw right), NL (nut left) or NR (nut right).

        Returns
        -------
        SideErrors
            Errors of that flank.
        """
        found: SideErrors = getattr(self, name)
        return found

    @property
    def random(self) -> bool:
        """Whether any error is random: of a ball radius, a profile, a pitch or a roundness."""
        return self.balls.sigma > 0.0 or any(
            any(s > 0.0 for s in e.profile_sigma) or any(t.sigma > 0.0 for t in (*e.pitch, *e.roundness))
            for e in (self.SL, self.SR, self.NL, self.NR)
        )

    def file_keys(self) -> Table:
        """Return the keys of the table ``errors`` of a scene file."""
        listed = {str(number): with_unit(ranges.Deviation, error) for number, error in self.balls.listed}
        return keys_of_record(self, balls=keys_of_record(self.balls, listed=listed))


@frozen_record
class Support:
    """Support of the screw: displacements and rotations prescribed at one axial position."""

    at: ranges.Station = scene_key("axial position of the support, from the left end of the screw", "0 mm")
    #: Pairs of a degree of freedom (of `FREEDOMS`) and its prescribed displacement [m] or rotation [rad].
    fixed: tuple[tuple[str, float], ...]

    def file_keys(self) -> Table:
        """Return the keys of the support in a scene file: position, fixed degrees of freedom, prescribed displacements."""
        return keys_of_record(self) | fixed_keys(self.fixed)


@frozen_record
class Load:
    """Load on the screw, applied on its axis at one axial position.

    Position in m, force in N, moment in N m.
    """

    #: Keys of which a scene file states at least one.
    ONE_OF: ClassVar = ("force", "moment")

    at: ranges.Station = scene_key("axial position along the screw, from its left end", "0 mm")
    force: ranges.Forces = frozen_default((0.0, 0.0, 0.0), "force along x, y, z", ["0 N", "0 N", "5 kN"])
    moment: ranges.Moments = frozen_default((0.0, 0.0, 0.0), "moment about x, y, z", ["0 N m", "3 N m", "0 N m"])


#: Loads of a scene, and an example of them.
Loads = Annotated[tuple[Annotated[Load, ranges.OneKeyNeeded(1)], ...], ranges.ListLength(0, 1000)]
LOADED = [{"at": "0 mm", "force": ["0 N", "0 N", "5 kN"]}]


@frozen_record
class Ingredients:
    """Options of the low-order models: contact constants, screw as a beam or rigid, beam elements, and lever arms.

    With ``hertz = "nominal"`` the Hertz constants of each contact follow from its own radii, errors included, at the
    nominal contact angle. ``partition`` places the nodes of the beam: ``"nodal"`` one at every contact, support and load;
    ``"source"`` every 15 mm inside the nut, as in Lin's thesis, and about one pitch diameter apart outside; ``"uniform"``
    at most ``element_length`` apart inside the nut, outside as for ``"source"``. With ``arm = "ball"`` a contact force acts
    on the beam at the axial position of the ball's centre instead of at that of the contact point; its line of action is
    still that through the current contact point.
    """

    hertz: Literal["nominal", "error-free", "actual", "as printed"] = frozen_default(
        "nominal",
        "Hertz constants: from the radii of each contact, errors included, at the nominal contact angle; from "
        "dimensions without errors; from the actual geometry at the contact angle under load; or as printed in "
        "Lin's Table B.1",
        "actual",
    )
    screw: Literal["beam", "rigid"] = frozen_default("beam", "screw as Timoshenko beam or rigid", "rigid")
    partition: Literal["nodal", "source", "uniform"] = frozen_default(
        "nodal",
        "nodes of the screw's beam elements: at every contact; 15 mm apart in the nut, as in Lin's thesis; or at "
        "most element_length apart in the nut",
        "source",
    )
    element_length: ranges.Element = frozen_default(1.0e-3, 'length of the elements in the nut, for partition = "uniform"')
    section: Literal["groove", "groove squared", "full"] = frozen_default(
        "groove",
        "cross-section of the screw as a beam: outer diameter times k_r, the square root of the volume with "
        "groove divided by the volume without (Lin C.8); outer diameter times k_r^2; or not reduced",
        "full",
    )
    arm: Literal["current", "nominal", "ball"] = frozen_default(
        "current",
        "point to which the lever arm of a contact load is measured: current contact point, nominal contact "
        "point, or ball's centre",
        "nominal",
    )
    load_step: ranges.LoadStep | None = frozen_default(
        None, "increment of the axial load for which the model liu also computes a stiffness (Liu's equation 22)", "600 N"
    )


@frozen_record
class Solid:
    """Inputs that only the 3D finite-element reference needs; a missing value is assumed, and the assumption printed."""

    nut_inner_diameter: ranges.Size | None = frozen_default(
        None,
        "diameter of the nut's lands; if left out, they are as far outside the pitch cylinder as the screw's are inside it",
        "34 mm",
    )
    hole_diameter: ranges.Size | None = frozen_default(
        None,
        "diameter of the hole along the screw's axis in the 3D mesh, at least the bore; if left out, the bore, or "
        "for a screw without bore an assumed hole",
        "3 mm",
    )
    shaft: ranges.Station | None = frozen_default(
        None,
        "length over which the shaft is meshed in 3D beyond each face of the nut; the rest of the shaft is a beam",
        "20 mm",
    )
    shaft_diameter: ranges.Size | None = frozen_default(
        None,
        "diameter of the shaft without groove beyond the 3D mesh; if left out, the shaft there is a beam with the "
        "mean stiffness of the grooved shaft",
        "31 mm",
    )
    nut_held: NutHeld | None = frozen_default(None, "former key of nut.held.at", "left face")
    screw_held: Literal["ends", "bore"] | None = frozen_default(
        None, "where supports and loads act on the screw: at its ends, or in its bore, by a stiff shaft", "ends"
    )
    nut: Literal["elastic", "rigid"] = frozen_default(
        "elastic", "whether the nut is elastic, or rigid except in the finely meshed zones at the contacts", "elastic"
    )
    nut_groove: Literal["through", "loaded"] = frozen_default(
        "through",
        "groove through the whole nut, or groove that ends two ball diameters beyond the outermost balls",
        "through",
    )


@frozen_record
class Friction:
    """Coefficients of Coulomb friction of the balls, and which effects of friction are computed."""

    screw: ranges.Coefficient = scene_key("coefficient of friction at the screw's groove, if it differs from coefficient")
    nut: ranges.Coefficient = scene_key("coefficient of friction at the nut's groove, if it differs from coefficient")
    assumed: ranges.Sentences = frozen_default(
        (), "sentences on where the coefficients come from", ["Grease-lubricated steel, assumed."]
    )
    feedback: ranges.Switch = frozen_default(
        True,
        "whether friction displaces each ball across its grooves and so changes its contact loads (the axial load "
        "of each ball remains that without friction)",
        False,
    )
    balls: ranges.Coefficient | None = frozen_default(
        None, "coefficient of friction between balls; if left out, the larger one of the coefficients at the two grooves"
    )
    neighbours: ranges.Switch = frozen_default(
        False,
        "whether touching balls exert forces on each other in the quasi-static solution (in a simulation over "
        "time they always do)",
        True,
    )

    @property
    def between_balls(self) -> float:
        """Coefficient of friction between balls: ``balls``, or if that is None, the larger one of ``screw`` and ``nut``."""
        return max(self.screw, self.nut) if self.balls is None else self.balls

    def file_keys(self) -> Table:
        """Return the keys of the table ``friction`` of a scene file; one key where screw and nut are alike."""
        if self.screw == self.nut:
            return {"coefficient": self.screw} | keys_of_record(self, "screw", "nut")
        return keys_of_record(self)


@frozen_record
class Motion:
    """Which part of a scene rotates, and its angular speed, for the command ``rollbench friction``.

    The angular speed is in rad/s.
    """

    speed: ranges.Turning = scene_key("angular speed of the rotating part about +z; negative for the other direction")
    turns: Literal["screw", "nut"] = frozen_default(
        "screw",
        "part that rotates; the other part does not rotate, and the two move along the axis relative to each "
        "other by one lead per turn",
        "nut",
    )


@frozen_record
class Lubricant:
    """Properties of the oil, or of the base oil of a grease, at operating temperature and ambient pressure.

    Viscosity in m^2/s, density in kg/m^3, pressure coefficient in 1/Pa.
    """

    viscosity: ranges.Viscosity = scene_key("kinematic viscosity at operating temperature", "27 mm2/s")
    density: ranges.Density = frozen_default(900.0, "density", "900 kg/m3")
    pressure_viscosity: ranges.PressureViscosity = frozen_default(
        20e-9, "pressure-viscosity coefficient (Barus), for the film between rollers and raceways", "20 1/GPa"
    )
    supply: Literal["grease", "oil mist", "oil bath", "oil jet"] = frozen_default(
        "grease", "type of lubrication of a ball bearing row, for Palmgren's factor f0", "oil bath"
    )
    factor: ranges.Factor0 | None = frozen_default(
        None,
        "manufacturer's factor f0 of a ball bearing row; if left out, the published range of f0 for this type of "
        "lubrication",
        2,
    )

    @property
    def dynamic_viscosity(self) -> float:
        """Dynamic viscosity at ambient pressure [Pa s].

        Examples
        --------
        >>> round(Lubricant(100e-6, 900.0).dynamic_viscosity, 4)
        0.09
        """
        return self.viscosity * self.density


@frozen_record
class Circulation:
    """Ball circuits of a screw, and how far its balls fill them, for the command ``rollbench friction``."""

    circuits: ranges.Circuits = frozen_default(
        1, "number of closed circuits of each start; each has the same number of balls", 1
    )
    turns: ranges.Turns | None = frozen_default(
        None,
        "number of turns with loaded balls of each thread start, in all its circuits together; if left out, the "
        "turns that its balls fill",
    )
    returning: Annotated[int, ranges.Plain("int", 0, ranges.MAX_BALLS)] = frozen_default(
        0, "number of balls in the return path of each circuit", 4
    )
    gap: ranges.Clearance | None = frozen_default(
        None, "mean clearance between neighbouring balls along a circuit (instead of filling)", "50 um"
    )
    filling: ranges.Filling | None = frozen_default(
        None, "fraction of a circuit's length that its balls would fill if they touched (instead of gap)", 0.8
    )


@frozen_record
class Time:
    """Duration and number of steps of a computation over time, for ``rollbench friction``; give angle or duration.

    Angle in rad, duration in s.
    """

    angle: ranges.Travel | None = frozen_default(
        None, "angle by which the rotating part turns in the computed time", "360 deg"
    )
    duration: ranges.Duration | None = frozen_default(None, "computed time (instead of angle)", "1 s")
    steps: Annotated[int, ranges.Plain("int", 1, 100_000)] | None = frozen_default(
        None, "number of time steps, at least 4; if left out, as many as needed for errors below goal", 200
    )
    goal: ranges.StepGoal = frozen_default(
        0.01,
        "largest accepted error of the friction torque due to the time steps, as a fraction of its mean; with a "
        "larger error the simulation counts as not converged",
        0.01,
    )
    output: Literal["balls", "torque"] = frozen_default(
        "balls", "time histories in the JSON result: torque and balls, or torque only", "balls"
    )

    def span(self, motion: Motion) -> float:
        """Return the length of the computed time: the given duration, or the given angle divided by the angular speed.

        Parameters
        ----------
        motion : Motion
            Motion with the angular speed of the rotating part.

        Returns
        -------
        float
            Computed time [s].

        Examples
        --------
        >>> Time(angle=6.0).span(Motion(speed=-3.0))
        2.0
        """
        if self.duration is not None:
            return self.duration
        return abs((self.angle or 0.0) / motion.speed)


@frozen_record
class GateLimits:
    """Largest accepted errors of the contact loads of this scene, for the command ``rollbench check``."""

    max_error: ranges.Percent | None = frozen_default(
        None, "largest accepted error of a contact load against the 3D reference, in per cent", 7
    )
    rms_error: ranges.Percent | None = frozen_default(
        None, "largest accepted RMS error of the contact loads, in per cent of the mean load", 3
    )


@frozen_record
class Operation:
    """Operating conditions for the modified rating life (ISO 281), and the speed limit of the ball return."""

    reliability: ranges.Reliability | None = frozen_default(
        None, "fraction of specimens that reach the modified life, in per cent", 95
    )
    viscosity_ratio: ranges.ViscosityRatio | None = frozen_default(
        None, "viscosity ratio kappa of ISO 281: actual over required viscosity (only together with contamination)", 1.5
    )
    contamination: ranges.Contamination | None = frozen_default(
        None,
        "contamination factor e_C of ISO 281: 1 extremely clean, 0.8 to 0.6 sealed, 0.3 to 0.1 coarsely filtered "
        "(only together with viscosity_ratio)",
        0.6,
    )
    dn_limit: ranges.SpeedLimit = frozen_default(
        76_200.0, "manufacturer's limit of pitch diameter times rotational speed, in mm/min", 120_000
    )


@frozen_record
class Calibration:
    """Values that were fitted to a measured or published result of the screw; that result then confirms no model."""

    segment_stiffness: ranges.SegmentStiffness | None = frozen_default(
        None,
        "axial stiffness of screw and nut in series over the mean distance of two neighbouring balls, for the model liu "
        "only; if left out, it follows from the cross-sections of screw and nut",
        "258 kN/um",
    )


@frozen_record
class MakerRating:
    """Load ratings of a nut or bearing as its maker gives them, beside which the computed ones stand."""

    dynamic: ranges.Rating | None = frozen_default(
        None, "the maker's basic dynamic load rating C: axial for nuts and thrust bearings, radial for others", "23.2 kN"
    )
    static: ranges.Rating | None = frozen_default(None, "the maker's basic static load rating C0, likewise", "41 kN")


@frozen_record
class Scene:
    """One load case of one ball screw or bearing, in SI units; the input of every model."""

    #: Name of the scene.
    name: str = scene_key(static=False)
    title: ranges.Sentence = scene_key(TITLE, "Screw under 5 kN", static=False)
    track: Track = scene_key("path of the ball centres")
    screw: Screw = scene_key("screw shaft, or inner ring")
    nut: Nut = scene_key("nut, or outer ring")
    balls: Balls = scene_key("size, number and positions of the balls")
    source: ranges.Words = frozen_default("", SOURCE, "Lin 2019, 2.4.1.1", static=False)
    assumed: ranges.Sentences = frozen_default((), ASSUMED, ["The nut is rigid."], static=False)
    role: Literal["", "referenced", "unseen, changed parts", "unseen, catalogue size"] = frozen_default(
        "",
        "role in the validation report of a scene that is included in rollbench: case study with a 3D reference, "
        "or scene that was not used when the models were developed",
        "referenced",
        compare=False,
        static=False,
    )
    members: ranges.Members = frozen_default(1, "number of specimens, each with its own random errors", 200, static=False)
    errors: Errors = frozen_default(Errors(), "manufacturing errors of balls and grooves", {"seed": 0})
    supports: tuple[Support, ...] = frozen_default((), "supports of the screw", [{"at": "0 mm", "fix": ["ux", "uy"]}])
    loads: Loads = frozen_default((), "loads on the screw", LOADED)
    ingredients: Ingredients = frozen_default(Ingredients(), "options of the low-order models", {"screw": "rigid"})
    calibration: Calibration = frozen_default(
        Calibration(),
        "values fitted to a measured or published result of this screw",
        {"segment_stiffness": "258 kN/um"},
        static=False,
    )
    solid: Solid = frozen_default(Solid(), "inputs of the 3D reference only", {"nut_groove": "through"})
    friction: Friction | None = frozen_default(None, "friction of balls and grooves", {"coefficient": 0.1}, static=False)
    motion: Motion | None = frozen_default(
        None, "part that rotates, and its angular speed", {"speed": "600 rpm"}, static=False
    )
    lubricant: Lubricant | None = frozen_default(
        None, "lubricant, for torques that depend on speed", {"viscosity": "27 mm2/s"}
    )
    circulation: Circulation | None = frozen_default(
        None, "number of ball circuits, and how far the balls fill them", {"returning": 4, "filling": 0.8}, static=False
    )
    time: Time | None = frozen_default(None, "simulation over time", {"angle": "360 deg"}, static=False)
    gate: GateLimits = frozen_default(
        GateLimits(),
        "largest accepted errors of contact loads, for rollbench check",
        {"max_error": 7},
        compare=False,
        static=False,
    )
    operation: Operation = frozen_default(
        Operation(), "reliability, lubrication, speed limit", {"reliability": 95}, compare=False, static=False
    )
    rating: MakerRating = frozen_default(MakerRating(), "load ratings by the maker", {"dynamic": "23.2 kN"}, static=False)

    def __hash__(self) -> int:
        """Return a hash of the fields that ``==`` compares; it is computed once, because many caches look up scenes."""
        found: int | None = self.__dict__.get("_hash")
        if found is None:
            found = self.__dict__["_hash"] = hash(tuple(getattr(self, f.name) for f in fields(self) if f.compare))
        return found

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields for pickling, without the stored hash, because hashes of text differ between processes."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def to_toml(self) -> str:
        """Return the scene as the text of a TOML scene file, from which the same scene can be read."""
        return toml_of_tables(self.file_tables())

    def file_tables(self) -> Table:
        """Return the keys and tables of the scene's file, without keys that have their default values."""
        shared, offset = self.screw.material, self.errors.lead_offset
        tables = keys_of_record(
            self,
            **shared.file_keys(None),
            track=self.track_table(),
            screw=_dimensions_and_material(self.screw, self.balls.radius, shared),
            nut=self.nut.file_keys(self.balls.radius, self.solid.nut_held, shared),
            balls=self.balls.file_keys(self.track, shared),
            errors=self.errors.file_keys(),
            supports=[support.file_keys() for support in self.supports],
            solid=keys_of_record(self.solid, "nut_held"),
            friction={} if self.friction is None else self.friction.file_keys(),
            preload={"lead_offset": with_unit(ranges.Deviation, offset)} if offset else {},
        )
        return with_first_keys_first(tables)

    def track_table(self, *, by_thrust: bool = False) -> Table:
        """Return the keys of the table ``track``, the path of the ball centres.

        For a bearing whose grooves are single arcs, the clearance from which its contact angle follows is written instead
        of the angle.

        Parameters
        ----------
        by_thrust : bool, default False
            Whether the key ``thrust`` of a rolling set states the direction of the single arcs; then the angle is written,
            and no clearance.

        Returns
        -------
        Table
            Keys and their values, with units.
        """
        track = self.track
        if track.arcs == "two" or by_thrust:
            return keys_of_record(track)
        apart = self.screw.groove_radius + self.nut.groove_radius - 2.0 * self.balls.radius
        return keys_of_record(track, "contact_angle", "washers") | clearance_table(apart, track.contact_angle)

    @property
    def stations(self) -> list[float]:
        """Axial positions of the supports, then of the loads [m]."""
        return [*(x.at for x in self.supports), *(x.at for x in self.loads)]

    @property
    def ball_count(self) -> int:
        """Number of loaded balls of all starts together."""
        return len(self.balls.azimuths) * self.track.starts


def with_first_keys_first(tables: Table) -> Table:
    """Return the tables of a scene file with the title and the other keys of `FIRST` at the beginning."""
    return {name: tables[name] for name in FIRST if name in tables} | tables
