"""Random axes as scene files: one to five sets of balls or rollers on one shaft, far beyond what anyone builds."""

import numpy as np
from tests.campaign.draw import force_and_moment, listed, log_uniform, mm

from rollbench.meshes.parts import FREEDOMS


def axis_text(seed: int, number: int) -> str:
    """TOML text of axis ``number`` of a campaign; the same for the same seed and number, whatever was drawn before."""
    if number % 10 == 7:
        return _warm_axis_text(seed, number)
    rng = np.random.default_rng([seed, 4, number])
    count = int(rng.integers(1, 6))
    ball = log_uniform(rng, 1e-3, 6e-3)
    pitch, pace = ball * log_uniform(rng, 3.5, 12.0), 8.0 * ball * rng.uniform(2.0, 5.0)
    length = pace * (count + 1)
    housings = [f"h{k}" for k in range(int(rng.integers(0, 3)))]
    places = [f"{1e3 * pace * (k + 1):.6g} mm" for k in range(count)]
    sets = [_set(rng, k, place, (ball, pitch, pace), housings) for k, place in enumerate(places)]
    stiff = rng.choice([70.0, 210.0, 310.0])
    text = (
        f'title = "campaign {seed}, axis {number}"\nkind = "axis"\n'
        f'[material]\nyoungs_modulus = "{stiff:g} GPa"\npoissons_ratio = {rng.choice([0.2, 0.3])}\n'
        f'[screw]\nlength = "{1e3 * length:.6g} mm"\nouter_diameter = "{2e3 * (pitch - 0.3 * ball):.6g} mm"\n'
        f"conformity = {rng.uniform(0.51, 0.6):.4g}\n"
    )
    if rng.random() < 0.3:
        plain = 2.0 * pitch * rng.uniform(0.5, 1.5)
        text += f'plain = [{{ start = "0 mm", end = "{500 * pace:.6g} mm", diameter = "{1e3 * plain:.6g} mm" }}]\n'
    text += "".join(_housing(rng, name, length) for name in housings)
    if len(housings) == 2 and rng.random() < 0.3:
        text += f'[[joints]]\nbetween = ["h0", "h1"]\nat = "{500 * length:.6g} mm"\n{_springs(rng)}'
    text += "".join(sets) + _held(rng, length)
    for _ in range(int(rng.choice([0, 1, 1, 2]))):
        force = rng.normal(size=3) * log_uniform(rng, 1.0, 2e4) * (rng.random(3) < 0.7)
        moment = rng.normal(size=3) * pitch * log_uniform(rng, 1.0, 2e3) * np.array([1.0, 1.0, 0.0]) * (rng.random() < 0.3)
        newton, metre = force_and_moment(force, moment, 5)
        text += f"[[loads]]\nat = {mm(length * rng.random(), 6)}\n{newton}" + metre * bool(np.any(moment))
    if rng.random() < 0.2:
        text += f'[heat]\nwarming = "{rng.uniform(-20, 40):.3g} K"\nexpansion = 11.5e-6\n'
    return text + f'[ingredients]\nhertz = "{rng.choice(["nominal", "nominal", "error-free", "actual", "as printed"])}"\n'


def _set(rng: np.random.Generator, k: int, place: str, size: tuple[float, float, float], housings: list[str]) -> str:
    """Tables of one set: a nut, a bearing of balls, or tapered rollers."""
    ball, pitch, pace = size
    what = rng.choice(["nut", "nut", "bearing", "bearing", "rollers"])
    thrust = str(rng.choice(["+z", "-z"])) if what != "nut" or rng.random() < 0.2 else ""
    thrust = "both" if what == "bearing" and rng.random() < 0.3 else thrust
    text = f'[[sets]]\nname = "s{k}"\n' + f'thrust = "{thrust}"\n' * bool(thrust)
    if housings and rng.random() < 0.5:
        text += f'housing = "{rng.choice(housings)}"\n'
    if thrust in ("+z", "-z") and rng.random() < 0.15:
        text += f'preload = "{log_uniform(rng, 10.0, 3e3):.4g} N"\n'
    elif rng.random() < 0.5:
        text += f'offset = "{rng.normal(0, 6):.3g} um"\n'
    if what == "rollers":
        return text + (
            f'position = "{place}"\n[sets.rollers]\ncount = {int(rng.integers(8, 20))}\ndiameter = "{1e3 * ball:.5g} mm"\n'
            f'length = "{1.5e3 * ball:.5g} mm"\ncup_angle = "{rng.uniform(12, 35):.4g} deg"\nroller_angle = "3 deg"\n'
            f'ring_depth = "{1e3 * ball:.5g} mm"\nslices = 5\n'
        )
    lead = 0.0 if what == "bearing" else 2.0 * ball * rng.uniform(1.2, 3.0)
    around = int(2.0 * np.pi * pitch / (2.05 * ball))
    turns = 1.0 if what == "bearing" else rng.uniform(1.1, min(3.0, 0.8 * pace / lead))
    count = max(3, int(around * turns * rng.uniform(0.4, 0.95)))
    wide = 0.9 * pace if lead else 4.0 * ball
    text += (
        f'[sets.track]\npitch_radius = "{1e3 * pitch:.9g} mm"\nlead = "{1e3 * lead:.9g} mm"\n'
        f'contact_angle = "{rng.choice([15, 30, 40, 45, 60])} deg"\nhand = "{rng.choice(["right", "left"])}"\n'
        f'[sets.nut]\nposition = "{place}"\nlength = "{1e3 * wide:.6g} mm"\nouter_diameter = "{3e3 * pitch:.6g} mm"\n'
        f"conformity = {rng.uniform(0.51, 0.6):.4g}\n"
        f'[sets.balls]\nradius = "{1e3 * ball:.9g} mm"\ncount = {count}\n' + f"turns = {turns:.6g}\n" * bool(lead)
    )
    if rng.random() < 0.4:
        text += f'[sets.errors.balls]\noversize = "{rng.normal(0, 3):.4g} um"\n' + 'sigma = "0.5 um"\n' * (
            rng.random() < 0.5
        )
    return text


def _springs(rng: np.random.Generator) -> str:
    along, about = log_uniform(rng, 1e6, 1e9), log_uniform(rng, 1e3, 1e6)
    values = [f'{f} = "{along:.4g} N/m"' if f[0] == "u" else f'{f} = "{about:.4g} N m"' for f in FREEDOMS]
    return f"springs = {{ {', '.join(values)} }}\n"


def _housing(rng: np.random.Generator, name: str, length: float) -> str:
    """A body on springs, or free to move in some freedoms."""
    text = f'[[housings]]\nname = "{name}"\nat = {mm(length * rng.uniform(0.2, 0.8), 6)}\n'
    if rng.random() < 0.5:
        text += _springs(rng)
    text += f"fix = {listed([f for f in FREEDOMS[: 5 + int(rng.integers(2))] if rng.random() < 0.6])}\n"
    if rng.random() < 0.5:
        text += force_and_moment(rng.normal(size=3) * log_uniform(rng, 1.0, 1e4), np.zeros(3), 5)[0]
    return text


def _held(rng: np.random.Generator, length: float) -> str:
    """Supports of the shaft: mostly only against turning."""
    held = ["rz"] if rng.random() < 0.6 else [f for f in FREEDOMS if rng.random() < 0.5]
    return f"[[supports]]\nat = {mm(length * rng.choice([0.0, 1.0]), 6)}\nfix = {listed(held)}\n" if held else ""


def _warm_axis_text(seed: int, number: int) -> str:
    """An axis whose only load is warming: two to four rows of balls on a plain shaft, the outer ones against each other."""
    rng = np.random.default_rng([seed, 6, number])
    ball = log_uniform(rng, 1e-3, 6e-3)
    pitch, pace, count = ball * rng.uniform(4.0, 8.0), ball * rng.uniform(15.0, 60.0), int(rng.integers(2, 5))
    text = (
        f'title = "campaign {seed}, warm axis {number}"\nkind = "axis"\n'
        f'[material]\nyoungs_modulus = "{rng.choice([70.0, 210.0, 310.0]):g} GPa"\npoissons_ratio = 0.3\n'
        f'[screw]\nlength = "{1e3 * pace * (count + 1):.6g} mm"\nouter_diameter = "{2e3 * (pitch - 0.3 * ball):.6g} mm"\n'
        f"conformity = {rng.uniform(0.51, 0.56):.4g}\n"
        f'[heat]\nwarming = "{log_uniform(rng, 0.1, 40.0):.3g} K"\nexpansion = 11.5e-6\n'
        '[[supports]]\nat = "0 mm"\nfix = ["rz"]\n'
    )
    around = int(2.0 * np.pi * pitch / (2.1 * ball))
    for k in range(count):
        thrust = "-z" if k == 0 else "+z" if k == count - 1 else str(rng.choice(["+z", "-z"]))
        text += (
            f'[[sets]]\nname = "s{k}"\nthrust = "{thrust}"\n[sets.track]\npitch_radius = "{1e3 * pitch:.9g} mm"\n'
            f'lead = "0 mm"\ncontact_angle = "{rng.choice([25, 30, 40, 45, 60])} deg"\n'
            f'[sets.nut]\nposition = "{1e3 * pace * (k + 1):.6g} mm"\nlength = "{4e3 * ball:.6g} mm"\n'
            f'outer_diameter = "{3e3 * pitch:.6g} mm"\nconformity = {rng.uniform(0.51, 0.56):.4g}\n'
            f'[sets.balls]\nradius = "{1e3 * ball:.9g} mm"\ncount = {max(3, int(around * rng.uniform(0.6, 0.95)))}\n'
        )
    return text + f'[ingredients]\nhertz = "{rng.choice(["nominal", "actual"])}"\n'
