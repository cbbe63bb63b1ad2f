"""The ball screw of Liu et al. (2025), its one calibration, and the screws drawn from its distribution of errors."""

from __future__ import annotations

from functools import cache

import numpy as np

from rollbench.compare.printed.printed_data import value_of
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.random_errors.chain import Chain, ChainState, Law, ball_stiffness, calibrated, solve_chain
from rollbench.lowfi.random_errors.ensemble import Ensemble, Percentile, Quantity, percentile, solve_ensemble
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Scene

#: What the source leaves open.
ASSUMED = (
    "Young's modulus 205 GPa and Poisson's ratio 0.3 for balls and nut too: E' is not printed.",
    "Areas of screw and nut and balls a turn are not printed. Only the compliance of a segment enters; it is calibrated "
    "once, so that Q78/Q1 without errors at 5000 N is 0.862.",
    "Stiffness is the tangent dF/du at the loaded end: the step of load of (22) is not printed.",
    "Drawn errors are independent and uniform in +-e; the draws of the source are not printed.",
)
#: Drawn screws; seed; loads at which they are solved [N].
MEMBERS, SEED = 5000, 2025
LOADS: dict[int, tuple[float, ...]] = {
    1: (100.0, 500.0, 1000.0, 2137.0, 3000.0, 5000.0),
    3: (100.0, 500.0, 1000.0, 2137.0, 3000.0, 5000.0),
}
LOADS[2] = (100.0, 500.0, 1000.0, 1100.0, 1500.0, 2000.0, 2100.0, 2137.0, 3000.0, 5000.0)
#: Probability below which a number is said not to come from the stated distribution.
UNLIKELY = 0.005


def liu_screw() -> Scene:
    """The screw of Table 2 and section 3.2.1; its load is that of section 4.1."""
    return catalogue.scene("liu-screw")


@cache
def balls() -> int:
    """Number of its balls."""
    return liu_screw().ball_count


@cache
def printed_ratio() -> float:
    """Q78/Q1 without errors of section 4.1: the input that the chain's compliance is calibrated to."""
    return value_of("liu-4.1", "ratio")


def calibration_load() -> float:
    """Load [N] of that ratio, section 4.1's and the scene's."""
    return liu_screw().loads[0].force[2]


@cache
def screw(law: Law = "implicit") -> Chain:
    """The calibrated chain by a reading of the contact angle; the source's is "implicit"."""
    scene = liu_screw()
    track, steel, groove, diameter = scene.track, scene.balls.material, scene.screw.groove_radius, 2.0 * scene.balls.radius
    stiffness = ball_stiffness(
        diameter, track.pitch_radius, groove, track.contact_angle, steel.youngs_modulus, steel.poissons_ratio
    )
    plain = Chain(balls(), stiffness, 0.0, 2.0 * groove - diameter, track.contact_angle, lead_angle(track), law)
    return calibrated(plain, printed_ratio(), calibration_load())


def implied_area(balls_a_turn: float) -> float:
    """Area [m^2] of screw and nut in series, 1/(1/A_n + 1/A_s), that the calibration implies."""
    scene = liu_screw()
    return scene.track.lead / balls_a_turn / (scene.balls.material.youngs_modulus * screw().compliance)


def one_error(error: float) -> Array:
    """Errors [m] with that of ball 33 only."""
    errors = np.zeros(balls())
    errors[32] = error
    return errors


@cache
def single(error_um: float, load: float, chain: Chain | None = None) -> ChainState:
    """State with one error [um] at ball 33 under a load [N]."""
    return solve_chain(chain or screw(), one_error(1e-6 * error_um), load)


@cache
def drawn(half_range_um: int) -> Ensemble:
    """Screws with errors within +-half_range [um], other draws for each range."""
    return solve_ensemble(screw(), 1e-6 * half_range_um, list(LOADS[half_range_um]), MEMBERS, seed=SEED + half_range_um)


def sample(half_range_um: int, quantity: Quantity, load: float) -> Array:
    """One quantity of the drawn screws (n,)."""
    return drawn(half_range_um).of(quantity, load)


def place_in(values: Array, printed: float, half_digit: float) -> tuple[Percentile, str]:
    """Percentile of a printed number in a sample, and the sentence that states it."""
    p = percentile(values, printed, half_digit)
    low, high = np.quantile(values, [UNLIKELY, 1.0 - UNLIKELY])
    words = f"percentile {p.middle:.1f} ± {p.error:.1f} of {p.size} drawn screws, median {np.median(values):.4g}, "
    words += f"central 99 % {low:.4g} to {high:.4g}; as far out: probability {p.tail:.4f}"
    return p, words + (f", at most {p.tail_bound:.4f} (95 %)" if p.tail < UNLIKELY else "")
