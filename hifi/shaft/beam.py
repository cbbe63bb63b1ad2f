"""Shaft beyond the stretch that is meshed in 3D: a Timoshenko beam with its supports, loads and housings.

It is written independently of the low-order model's beam.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, Joint
from rollbench.meshes.parts import FREEDOMS, Load, Material, Scene, Support


@dataclass(frozen=True)
class ShaftSection:
    """Stiffnesses of a beam's cross-section against tension, bending, torsion and shear."""

    #: Axial stiffness E A of the beam's section [N].
    EA: float
    #: Bending stiffness E I of the beam's section [N m2].
    EI: float
    #: Torsional stiffness G J of the beam's section [N m2].
    GJ: float
    #: Shear stiffness kappa G A of the beam's section [N].
    kGA: float

    @property
    def flexibility_per_length(self) -> Array:
        """Flexibility of the beam per unit length ``(6, 6)``: strains, curvatures, twist by unit forces and moments."""
        yielding = [self.kGA, self.kGA, self.EA, self.EI, self.EI, self.GJ]
        return np.asarray(np.diag(1.0 / np.array(yielding)))


def round_section(radius: float, young: float, poisson: float, bore: float = 0.0) -> ShaftSection:
    """Compute the stiffnesses of a circular cross-section, solid or hollow.

    Parameters
    ----------
    radius : float
        Outer radius [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    bore : float, default 0.0
        Radius of the bore [m]; 0: solid.

    Returns
    -------
    ShaftSection
        The section.

    References
    ----------
    Shear coefficient: Cowper (1966), J. Appl. Mech. 33, 335.

    Examples
    --------
    >>> shaft = round_section(16e-3, 210e9, 0.28)
    >>> round(shaft.EA / 1e6, 2), round(shaft.EI)  # MN, N m2
    (168.89, 10809)
    """
    area, inertia = np.pi * (radius**2 - bore**2), np.pi * (radius**4 - bore**4) / 4.0
    shear, squares = young / (2.0 * (1.0 + poisson)), (bore / radius) ** 2
    ring = (20.0 + 12.0 * poisson) * squares / (1.0 + squares) ** 2
    kappa = 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson + ring)
    return ShaftSection(young * area, young * inertia, 2.0 * shear * inertia, kappa * shear * area)


def tube_section(radius: float, bore: float, material: Material) -> ShaftSection:
    """Compute the stiffnesses of a circular cross-section, solid or hollow, of a given material.

    Parameters
    ----------
    radius : float
        Outer radius [m].
    bore : float
        Radius of the bore [m]; 0: solid.
    material : Material
        Elastic material.

    Returns
    -------
    ShaftSection
        The section.
    """
    return round_section(radius, material.youngs_modulus, material.poissons_ratio, bore)


def end_flexibility_of_cantilever(length: float, per_length: Array) -> Array:
    """Compute the flexibility of the free end of a uniform cantilever along z, with shear.

    Parameters
    ----------
    length : float
        Length of the cantilever [m].
    per_length : (6, 6) Array
        Flexibility of the beam per unit length, as `ShaftSection.flexibility_per_length`.

    Returns
    -------
    (6, 6) Array
        Translation and rotation of the end by unit forces and moments there [m/N, 1/N, 1/(N m)].

    Examples
    --------
    >>> section = round_section(16e-3, 210e9, 0.28)
    >>> F = end_flexibility_of_cantilever(0.4, section.flexibility_per_length)
    >>> bool(np.isclose(F[0, 0], 0.4**3 / (3.0 * section.EI) + 0.4 / section.kGA))
    True
    """
    t = rigid_motion_transfer_along_z(1.0) - np.eye(6)
    first = t @ per_length
    return np.asarray(length * per_length + length**2 / 2.0 * (first + first.T) + length**3 / 3.0 * first @ t.T)


def beam_stiffness(length: float, section: ShaftSection) -> Array:
    """Compute the stiffness matrix of a uniform Timoshenko beam element along z.

    Parameters
    ----------
    length : float
        Length of the element [m].
    section : ShaftSection
        Stiffnesses of the cross-section.

    Returns
    -------
    (12, 12) Array
        Forces and moments on both ends by unit motions of both ends [N/m, N, N m].
    """
    end = np.linalg.inv(end_flexibility_of_cantilever(length, section.flexibility_per_length))
    T = rigid_motion_transfer_along_z(length)
    return np.block([[T.T @ end @ T, -T.T @ end], [-end @ T, end]])


@dataclass(frozen=True)
class ShaftSupports:
    """Supports and loads of a shaft, the movable housings of its nuts, and the springs between housings."""

    #: Supports of the shaft.
    supports: tuple[Support, ...]
    #: Loads on the shaft.
    loads: tuple[Load, ...]
    #: Length by which rotations are multiplied to compare them with displacements [m].
    length_per_rotation: float
    #: Housings that can move.
    housings: tuple[Housing, ...] = ()
    #: Springs between housings, or between a housing and the machine frame.
    housing_springs: tuple[Joint, ...] = ()

    @staticmethod
    def from_scene(scene: Scene | Assembly) -> ShaftSupports:
        """Collect supports, loads and housings from a scene with one fixed nut, or from a shaft with several nuts.

        Parameters
        ----------
        scene : Scene | Assembly
            Scene of one nut or bearing, or shaft with several of them.

        Returns
        -------
        ShaftSupports
            Supports, loads, movable housings and springs.
        """
        if isinstance(scene, Scene):
            return ShaftSupports(scene.supports, scene.loads, scene.track.pitch_radius)
        arm = max(s.parts.track.pitch_radius for s in scene.sets if isinstance(s.parts, Scene))
        moving = tuple(h for h in scene.housings if not h.is_fixed)
        return ShaftSupports(scene.supports, scene.loads, arm, moving, scene.joints)

    def housing_index(self, housing: str | None) -> int | None:
        """Return the index of a named movable housing among ``housings``; None if it is fixed, or if the name is None."""
        return next((k for k, h in enumerate(self.housings) if h.name == housing), None)

    @property
    def support_and_load_positions(self) -> set[float]:
        """Axial positions of all supports of the shaft and all loads on it [m]."""
        return {x.at for x in self.supports} | {x.at for x in self.loads}

    def prescribed_motions(self) -> list[tuple[int, float, int, float]]:
        """List the prescribed displacements and rotations of shaft and housings at their supports.

        Returns
        -------
        list[tuple[int, float, int, float]]
            For each: the body (0: the shaft, then the housings from 1), the axial position [m], the index of the degree of
            freedom (0 to 5), and the prescribed value [m, rad].
        """
        bodies = [(0, x.at, x.fixed) for x in self.supports]
        bodies += [(k, housing.at, housing.fixed) for k, housing in enumerate(self.housings, 1)]
        return [(body, at, FREEDOMS.index(name), value) for body, at, fixed in bodies for name, value in fixed]

    def forces_and_moments(self) -> list[tuple[int, float, Array]]:
        """List the forces and moments that act on shaft and housings.

        Returns
        -------
        list[tuple[int, float, Array]]
            For each: the body (0: the shaft, then the housings from 1), the axial position [m], and the force and moment
            ``(6,)`` [N, N m].
        """
        bodies = [(0, x) for x in self.loads] + [*enumerate(self.housings, 1)]
        return [(body, x.at, np.array([*x.force, *x.moment])) for body, x in bodies]

    @property
    def lengths_of_unit_motions(self) -> Array:
        """Factors ``(6,)`` that turn a body's six motions into lengths: 1 for displacements, a length for rotations."""
        return np.array([1.0] * 3 + [self.length_per_rotation] * 3)

    def spring_stiffnesses(self) -> list[tuple[Array, Array]]:
        """List the springs between housings, and between a housing and the machine frame.

        Returns
        -------
        list[tuple[Array, Array]]
            For each spring: the matrix ``(6, 6 h)`` that gives the relative motion of its ends by the motions of the h
            housings, and its stiffness ``(6, 6)`` [N/m, N, N m].
        """
        out = []
        for k, housing in enumerate(self.housings):
            if housing.stiffness is not None:
                rows = np.zeros((6, 6 * len(self.housings)))
                rows[:, 6 * k : 6 * k + 6] = np.eye(6)
                out.append((rows, np.array(housing.stiffness)))
        for joint in self.housing_springs:
            rows = np.zeros((6, 6 * len(self.housings)))
            for name, sign in ((joint.first, 1.0), (joint.second, -1.0)):
                moving = self.housing_index(name)
                if moving is not None:
                    columns = slice(6 * moving, 6 * moving + 6)
                    rows[:, columns] = sign * rigid_motion_transfer_along_z(joint.at - self.housings[moving].at)
            out.append((rows, np.array(joint.stiffness)))
        return out
