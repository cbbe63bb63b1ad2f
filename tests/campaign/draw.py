"""Random extreme screws and bearings as scene files: within what a file may say, far beyond what anyone builds."""

from collections.abc import Iterable
from math import cos, pi, sin

import numpy as np

from rollbench.meshes.parts import FREEDOMS

#: Largest number of balls of a randomly drawn scene.
MOST = 400


def scene_text(seed: int, number: int) -> str:
    """TOML text of scene ``number`` of a campaign; the same for the same seed and number, whatever was drawn before."""
    rng = np.random.default_rng([seed, number])
    ring = rng.random() < 0.4
    ball = log_uniform(rng, 0.3e-3, 10e-3)
    count = round(log_uniform(rng, 3, MOST))
    angle = np.radians(rng.uniform(0.5, 60.0))
    pitch, lead, starts, turns, room = _path(rng, ring, ball, count)
    count = max(starts, count - count % starts)
    tight = rng.choice([0.0, 1.0, -1.0]) * log_uniform(rng, 1e-8, 30e-6)
    screw, outside = (max(ball * (1.0 + log_uniform(rng, 5e-3, 0.2)), ball + 2.0 * abs(tight)) for _ in range(2))
    nut = max(1.15 * room + 2.5 * ball, 4.0 * ball)
    length = nut * rng.uniform(1.0, 8.0)
    position = rng.uniform(nut / 2.0, length - nut / 2.0)
    outer = 2.0 * (pitch - ball * rng.uniform(0.05, 0.4))
    bore = rng.choice([0.0, 0.0, 0.5]) * 2.0 * max(pitch - 1.6 * ball, 0.0)
    stiff = rng.choice([3.0, 70.0, 210.0, 310.0, 700.0])
    ratio = rng.choice([0.0, 0.2, 0.3, 0.499])
    turning = "" if ring else f"turns = {turns:.9g}\n"
    return (
        f'title = "campaign {seed}, scene {number}"\n'
        f'[material]\nyoungs_modulus = "{stiff:g} GPa"\npoissons_ratio = {ratio:g}\n'
        f'[track]\npitch_radius = {mm(pitch)}\nlead = {mm(lead)}\ncontact_angle = "{np.degrees(angle):.6g} deg"\n'
        f'hand = "{rng.choice(["right", "left"])}"\nstarts = {starts}\nphase = "{rng.uniform(-360, 360):.4g} deg"\n'
        f"[screw]\nlength = {mm(length)}\nouter_diameter = {mm(outer)}\nbore = {mm(bore)}\n"
        f"groove_radius = {mm(screw, 12)}\n[nut]\nposition = {mm(position)}\nlength = {mm(nut)}\n"
        f'outer_diameter = "{2e3 * (pitch + ball) * rng.uniform(1.05, 1.6):.9g} mm"\ngroove_radius = {mm(outside, 12)}\n'
        f"[balls]\nradius = {mm(ball)}\ncount = {count}\n{turning}"
        f'[errors]\nseed = {int(rng.integers(2**31))}\n[errors.balls]\noversize = "{1e6 * tight:.6g} um"\n'
        f"{_errors(rng)}{_supports(rng, length)}{_loads(rng, length, pitch)}[ingredients]\n{_choices(rng)}"
    )


def mm(length: float, digits: int = 9) -> str:
    """A length [m] as a file has it."""
    return f'"{1e3 * length:.{digits}g} mm"'


def listed(texts: Iterable[str]) -> str:
    """A list of words or quantities as a file has it."""
    return "[" + ", ".join(f'"{text}"' for text in texts) + "]"


def force_and_moment(force: np.ndarray, moment: np.ndarray, digits: int) -> tuple[str, str]:
    """A force [N] and a moment [N m] as a file has them."""
    newton, metre = ([f"{x:.{digits}g} {unit}" for x in v] for v, unit in ((force, "N"), (moment, "N m")))
    return f"force = {listed(newton)}\n", f"moment = {listed(metre)}\n"


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A value between two, its logarithm uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _path(rng: np.random.Generator, ring: bool, ball: float, count: int) -> tuple[float, float, int, float, float]:
    """Pitch radius, lead [m], starts, turns and length of nut that the balls take [m]."""
    spacing = 2.0 * ball * rng.uniform(1.02, 3.0)
    if ring:
        pitch = max(count * spacing / (2.0 * pi), 2.2 * ball) * rng.uniform(1.0, 1.5)
        return pitch, 0.0, 1, 1.0, 0.0
    starts = int(rng.choice([1, 1, 2, 3]))
    per_start = max(1, count // starts)
    pitch = ball * log_uniform(rng, 3.0, 25.0)
    lead = starts * 2.0 * ball * rng.uniform(1.15, 4.0)
    turns = per_start * spacing / float(np.hypot(2.0 * pi * pitch, lead))
    return pitch, lead, starts, turns, turns * lead + lead


def _errors(rng: np.random.Generator) -> str:
    """Random balls, pitch and roundness, on a third of the scenes each; uneven flanks on a tenth."""
    text = ""
    if rng.random() < 0.3:
        text += f'sigma = "{1e6 * log_uniform(rng, 1e-8, 2e-6):.4g} um"\n'
    for side in ("SL", "NR"):
        if rng.random() < 0.3:
            text += (
                f"[errors.{side}]\npitch = [{{ harmonic = {rng.choice([0.5, 1, 2, 7])}, "
                f'sin = "{1e6 * log_uniform(rng, 1e-7, 2e-5):.4g} um" }}]\n'
            )
            if rng.random() < 0.3:
                text += f'profile = ["{rng.normal():.3g} um", "{rng.normal():.3g} um"]\n'
    return text


def _supports(rng: np.random.Generator, length: float) -> str:
    text = ""
    for _ in range(int(rng.choice([0, 1, 1, 2, 3]))):
        held = [name for name in FREEDOMS if rng.random() < 0.6]
        moved = {}
        if held and rng.random() < 0.3:
            name = held.pop()
            moved[name] = f"{rng.normal(0, 100):.3g} um" if name[0] == "u" else f"{rng.normal():.3g} mrad"
        if held or moved:
            text += f"[[supports]]\nat = {mm(length * rng.random())}\nfix = {listed(held)}\n"
        for name, value in moved.items():
            text += f'displace = {{ {name} = "{value}" }}\n'
    return text


def _loads(rng: np.random.Generator, length: float, pitch: float) -> str:
    """Nothing, axial, radial, a moment, or all of it."""
    kind, size = rng.choice(["none", "axial", "radial", "moment", "all", "all"]), log_uniform(rng, 1e-3, 1e5)
    if kind == "none":
        return ""
    force, moment = np.zeros(3), np.zeros(3)
    turn = rng.uniform(0, 2 * pi)
    if kind in ("axial", "all"):
        force[2] = rng.choice([-1, 1]) * size * rng.random()
    if kind in ("radial", "all"):
        force[:2] = size * rng.random() * np.array([cos(turn), sin(turn)])
    if kind in ("moment", "all"):
        moment[:2] = size * pitch * rng.random() * np.array([sin(turn), cos(turn)])
    return f"[[loads]]\nat = {mm(length * rng.random())}\n" + "".join(force_and_moment(force, moment, 6))


def _choices(rng: np.random.Generator) -> str:
    text = f'hertz = "{rng.choice(["nominal", "nominal", "error-free", "actual", "as printed"])}"\n'
    if rng.random() < 0.25:
        text += 'screw = "rigid"\n'
    elif rng.random() < 0.3:
        text += 'partition = "source"\n'
    return text
