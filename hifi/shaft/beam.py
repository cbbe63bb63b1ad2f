"""The shaft beyond the 3D stretch: a Timoshenko beam, independent of the low-order model's; what holds and loads it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.hifi.elements.rigid import transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, Joint
from rollbench.meshes.parts import FREEDOMS, Load, Material, Scene, Support


@dataclass(frozen=True)
class ShaftSection:
    """EA [N], EI [N m2], GJ [N m2], kappa G A [N]."""

    EA: float
    EI: float
    GJ: float
    kGA: float

    @property
    def per_length(self) -> Array:
        """Flexibility ``(6, 6)`` of a metre."""
        yielding = [self.kGA, self.kGA, self.EA, self.EI, self.EI, self.GJ]
        return np.asarray(np.diag(1.0 / np.array(yielding)))


def round_section(radius: float, young: float, poisson: float, bore: float = 0.0) -> ShaftSection:
    """Circular section of a radius [m], with a bore [m] or solid; shear coefficient of Cowper 1966 for either."""
    area, inertia = np.pi * (radius**2 - bore**2), np.pi * (radius**4 - bore**4) / 4.0
    shear, squares = young / (2.0 * (1.0 + poisson)), (bore / radius) ** 2
    ring = (20.0 + 12.0 * poisson) * squares / (1.0 + squares) ** 2
    kappa = 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson + ring)
    return ShaftSection(young * area, young * inertia, 2.0 * shear * inertia, kappa * shear * area)


def tube(radius: float, bore: float, material: Material) -> ShaftSection:
    """Round section of these radii [m], with a hole unless that has none."""
    return round_section(radius, material.youngs_modulus, material.poissons_ratio, bore)


def uniform_cantilever(length: float, per_length: Array) -> Array:
    """Flexibility ``(6, 6)`` of the end of a cantilever along z from that of a metre ``(6, 6)``."""
    t = transport(1.0) - np.eye(6)
    first = t @ per_length
    return np.asarray(length * per_length + length**2 / 2.0 * (first + first.T) + length**3 / 3.0 * first @ t.T)


def beam_stiffness(length: float, section: ShaftSection) -> Array:
    """Stiffness ``(12, 12)`` of a uniform shaft along z from the flexibility of its cantilever (equilibrium transport)."""
    end, T = np.linalg.inv(uniform_cantilever(length, section.per_length)), transport(length)
    return np.block([[T.T @ end @ T, -T.T @ end], [-end @ T, end]])


@dataclass(frozen=True)
class Frame:
    """Supports of a shaft and loads on it, the housings that can move, the springs between housings; arm [m]: makes lengths
    of rotations."""

    supports: tuple[Support, ...]
    loads: tuple[Load, ...]
    arm: float
    housings: tuple[Housing, ...] = ()
    joints: tuple[Joint, ...] = ()

    @staticmethod
    def of(described: Scene | Assembly) -> Frame:
        """That of one set whose nut is held, or of several sets."""
        if isinstance(described, Scene):
            return Frame(described.supports, described.loads, described.track.pitch_radius)
        arm = max(s.parts.track.pitch_radius for s in described.sets if isinstance(s.parts, Scene))
        moving = tuple(h for h in described.housings if not h.stands)
        return Frame(described.supports, described.loads, arm, moving, described.joints)

    def number(self, housing: str | None) -> int | None:
        """Number of a housing by its name; None for one that stands, and for none."""
        return next((k for k, h in enumerate(self.housings) if h.name == housing), None)

    @property
    def stations(self) -> set[float]:
        """Stations [m] of supports and loads."""
        return {x.at for x in self.supports} | {x.at for x in self.loads}

    def holds(self) -> list[tuple[int, float, int, float]]:
        """Freedoms that are held: body (0: the shaft, then the housings), station [m], number of the freedom, value."""
        bodies = [(0, x.at, x.fixed) for x in self.supports]
        bodies += [(k, housing.at, housing.fixed) for k, housing in enumerate(self.housings, 1)]
        return [(body, at, FREEDOMS.index(name), value) for body, at, fixed in bodies for name, value in fixed]

    def wrenches(self) -> list[tuple[int, float, Array]]:
        """Loads: body as of `holds`, station [m], force and moment ``(6,)`` [N, N m]."""
        bodies = [(0, x) for x in self.loads] + [*enumerate(self.housings, 1)]
        return [(body, x.at, np.array([*x.force, *x.moment])) for body, x in bodies]

    @property
    def lengths(self) -> Array:
        """What makes lengths of the six motions of a body, ``(6,)``: 1, and the arm."""
        return np.array([1.0] * 3 + [self.arm] * 3)

    def springs(self) -> list[tuple[Array, Array]]:
        """Rows ``(6, 6 h)`` by which the housings move the ends of each spring apart, and its stiffness ``(6, 6)``."""
        out = []
        for k, housing in enumerate(self.housings):
            if housing.stiffness is not None:
                rows = np.zeros((6, 6 * len(self.housings)))
                rows[:, 6 * k : 6 * k + 6] = np.eye(6)
                out.append((rows, np.array(housing.stiffness)))
        for joint in self.joints:
            rows = np.zeros((6, 6 * len(self.housings)))
            for name, sign in ((joint.first, 1.0), (joint.second, -1.0)):
                moving = self.number(name)
                if moving is not None:
                    columns = slice(6 * moving, 6 * moving + 6)
                    rows[:, columns] = sign * transport(joint.at - self.housings[moving].at)
            out.append((rows, np.array(joint.stiffness)))
        return out
