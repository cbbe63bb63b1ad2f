"""A flange on the smooth body that stands for a nut: plate theory, limits of what holds it, symmetry."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import relative

from rollbench.lowfi.compliance.tube import ContactPoints, SmoothBody, contact_compliance, tube_compliance
from rollbench.meshes.parts import Flange, Material

STEEL = Material(210e9, 0.3)
BORE, OUTER, LENGTH = 17e-3, 24e-3, 54e-3
FLANGE = Flange(72e-3, 11e-3, (26e-3, 34e-3))
ZONE = (12e-3, 50e-3)
Z, AZIMUTH = 1e-3 * np.array([14.0, 22.0, 31.0, 40.0, 47.0]), np.array([0.3, 2.0, -1.1, -2.8, 0.9])


def tube(flange: Flange | None = FLANGE, held: str = "flange", length: float = LENGTH, bore: float = BORE) -> SmoothBody:
    return SmoothBody(bore, OUTER, (0.0, length), held, bore, 2e-3, 12, (3.2e-3, 1.5e-3), STEEL, None, flange)


def motions(of: SmoothBody, shift: float = 0.0) -> np.ndarray:
    """Compliance of contacts in all three directions, those along r first."""
    z = Z - shift
    found = tube_compliance(of, (ZONE[0] - shift, ZONE[1] - shift))
    axes = np.repeat(np.eye(3)[:, None], z.size, axis=1)  # (3, contacts, 3)
    pairs = np.stack([np.concatenate([axes[0], axes[2]]), np.concatenate([axes[1], axes[1]])], axis=1)
    return contact_compliance(found, ContactPoints(np.tile(AZIMUTH, 2), np.tile(z, 2), pairs))


def axial(of: SmoothBody) -> float:
    """Motion of the far end along the axis by an axial force all around the line beside the flange."""
    found = tube_compliance(of, of.ends)
    return float(found.line_compliance[0].full_matrix()[-1, 2])


def plate(thickness: float, inner: float, outer: float) -> float:
    """Deflection of an annular plate by a unit force on its inner edge, which does not turn, its outer edge clamped:
    D (1/r (r w')')' = 1/(2 pi r), and the shear's share."""
    D = STEEL.youngs_modulus * thickness**3 / (12.0 * (1.0 - STEEL.poissons_ratio**2))
    r = np.array([inner, outer])
    c = 1.0 / (4.0 * np.pi * D)
    A, B = np.linalg.solve(np.stack([r, 1.0 / r], axis=1), -c * r * np.log(r))
    whole = np.diff(c * (r**2 * np.log(r) / 2.0 - r**2 / 4.0) + A * r**2 / 2.0 + B * np.log(r))[0]
    shear = np.log(outer / inner) / (2.0 * np.pi * 5.0 / 6.0 * STEEL.shear_modulus * thickness)
    return float(abs(whole) + shear)


@pytest.mark.slow
def test_a_thin_flange_is_an_annular_plate() -> None:
    """A thick-walled sleeve on a flange clamped from twice its radius on: the rest falls with the flange's thickness."""
    off = []
    for thickness in (3.0e-3, 1.5e-3, 0.75e-3):
        flange = Flange(4.4 * OUTER, thickness, (2.0 * OUTER, 2.2 * OUTER))
        fine = replace(tube(flange, bore=4e-3), size=(1.5e-3, 1.0e-3))
        off.append(axial(fine) / plate(thickness, OUTER, 2.0 * OUTER) - 1.0)
    assert 0.0 < off[2] < 0.5 * off[1] < 0.25 * off[0] < 0.11


def test_a_flange_holds_less_than_a_clamped_section_and_more_than_its_plate_alone() -> None:
    """What is held in more places gives way less: the sleeve beyond the flange clamped, or the flange's bonded fit."""
    free, bonded = (np.diag(motions(tube(replace(FLANGE, centring=10e-3, bonded=x)))) for x in (False, True))
    clamped = np.diag(motions(tube(None, "low", LENGTH - FLANGE.thickness), FLANGE.thickness))
    small = np.diag(motions(tube(replace(FLANGE, seat=(32e-3, 34e-3)))))
    beyond = np.tile(np.repeat(FLANGE.thickness < Z, 2), 2)
    assert (clamped < free)[beyond].all()
    assert (bonded < free).all()
    assert (free < small).all()


def test_a_fit_bonded_all_along_holds_the_outer_surface() -> None:
    """With a flange too thin to matter, its bonded fit of the whole length is today's outer surface."""
    thin = Flange(50e-3, 0.5e-3, (24.2e-3, 25e-3), centring=LENGTH - 0.5e-3, bonded=True)
    assert relative(motions(tube(thin)), motions(tube(None, "outer"))) < 1e-3


def test_a_flange_that_does_not_hold_is_a_stiffer_ring() -> None:
    plain, stiff = (np.diag(motions(tube(x, "high"))) for x in (None, FLANGE))
    assert (stiff < plain * (1.0 + 1e-9)).all()
    assert stiff[0] < 0.9 * plain[0]
