"""Ball screws as catalogues have them, drawn as scene files: size, starts, hand, preload, errors, offsets, moments."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, pi
from typing import Any

import numpy as np

from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.from_keys import touching_angle
from rollbench.compare.scenes.template import LOAD, values_like
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.units import show

#: The survey's seed; no scene of it is ever drawn again.
SEED = 20360
#: Nuts without a flange come first.
TUBES, SCENES = 200, 240
#: Nominal diameters with their leads [mm].
SIZES = {
    16: (5, 10, 16),
    20: (5, 10, 20),
    25: (5, 10, 25),
    32: (5, 10, 20, 32),
    40: (5, 10, 20, 40),
    50: (10, 20),
    63: (10, 20),
    80: (10, 20),
}
#: Oversize of the ball radius over its diameter [-] that makes a light preload.
OVERSIZE = 4.7e-4
#: Circuits and turns of each, least first, and the balls that a nut may have for it.
CIRCUITS, BALLS = ((1, 1.0), (1, 1.5), (2, 1.0), (1, 2.5), (2, 1.5), (3, 1.0), (2, 2.5)), 40
#: Preloads of one nut, or none, or clearance.
PRELOADS = ("none", "oversize", "oversize", "force", "lead offset", "clearance")
#: Standard deviations [um] of ball radius, pitch once a turn and roundness twice a turn, as of classes 1, 3 and 5.
CLASSES = ((0.05, 0.5, 0.25), (0.1, 1.0, 0.5), (0.2, 2.0, 1.0))
HELD = ("left face", "left face", "right face", "both faces", "outer surface")


def scene_text(seed: int, number: int) -> str:
    """TOML text of scene ``number`` of a survey; the same for the same seed and number, whatever was drawn before."""
    rng = np.random.default_rng([seed, number])
    outer = int(rng.choice(list(SIZES)))
    lead = int(rng.choice(SIZES[outer]))
    kind = str(rng.choice(PRELOADS))
    starts = 2 if lead > 0.3 * outer and kind != "lead offset" and rng.random() < 0.45 else 1
    sizes = values_like(f"{outer}x{lead / starts:g}")
    ball, pitch, wall = sizes["ball"], sizes["pitch"], sizes["outside"]
    balls, count = _balls(rng, starts, ball, touching_angle(pitch / 2.0, lead, ball), halved=kind == "lead offset")
    force = LOAD * ball**2 * count * np.sin(pi / 4.0)
    length = round(outer * rng.uniform(12.0, 30.0))
    track = {
        "pitch_diameter": f"{pitch:g} mm",
        "lead": f"{lead} mm",
        "contact_angle": f"{rng.uniform(40.0, 50.0):.1f} deg",
        "hand": str(rng.choice(["right", "right", "left"])),
        "starts": starts,
    }
    screw = {"length": f"{length} mm", "outer_diameter": f"{outer} mm", "conformity": _conformity(rng)}
    position = length * rng.uniform(0.3, 0.7)
    outside = float(f"{wall * rng.uniform(0.95, 1.2):.3g}")
    scene: dict[str, Any] = {
        "title": f"survey {seed}, scene {number}: {outer}x{lead}, {kind}",
        "material": {"name": "bearing steel"},
        "track": track,
        "screw": screw,
        "nut": {
            "position": f"{position:.4g} mm",
            "length": f"{length * 0.58:.4g} mm",
            "outer_diameter": f"{outside:g} mm",
            "conformity": _conformity(rng),
        },
        "balls": balls,
        "errors": _errors(rng),
        "solid": {"nut_held": str(rng.choice(HELD))},
        "supports": _supports(rng, length),
    }
    if rng.random() < 0.25:
        scene["screw"]["bore"] = f"{floor(0.4 * outer)} mm"
    if kind != "none":
        scene["preload"] = _preload(rng, kind, ball, force)
    scene["loads"] = _loads(rng, force, pitch / 2.0, scene["nut"]["position"])
    nut_length = _nut_length(scene, rng)
    scene["nut"]["length"] = f"{nut_length:.3f} mm"
    if number >= TUBES:
        del scene["solid"]
        scene["title"] += ", flange"
        scene["nut"] |= _flange(rng, nut_length, outside)
    return _toml(scene)


def _flange(rng: np.random.Generator, length: float, wall: float) -> dict[str, dict[str, str]]:
    """A flange for a nut of a length and an outer diameter [mm], and the annulus of its face, which the nut is held by."""
    wide, thick = wall * rng.uniform(1.3, 1.8), min(wall * rng.uniform(0.15, 0.3), 0.4 * length)
    room, fit = wide - wall, rng.uniform(0.05, 0.5) * (length - thick)
    low, high = wall + room * rng.uniform(0.0, 0.3), wide - room * rng.uniform(0.0, 0.3)
    bonded = rng.random() < 0.4
    flange = {"diameter": wide, "thickness": thick, "centring": fit if bonded else 0.0}
    return {
        "flange": {name: f"{x:.2f} mm" for name, x in flange.items()} | {"side": str(rng.choice(["left", "right"]))},
        "held": {
            "inner_diameter": f"{low:.2f} mm",
            "outer_diameter": f"{high:.2f} mm",
            "centring": "bonded" if bonded else "free",
        },
    }


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _conformity(rng: np.random.Generator) -> float:
    return round(float(rng.uniform(0.515, 0.54)), 3)


def _balls(
    rng: np.random.Generator, starts: int, ball: float, touching: float, *, halved: bool
) -> tuple[dict[str, Any], int]:
    """Keys of the balls and how many there are; halved: in an even number of circuits, none in the middle."""
    filling = round(float(rng.uniform(0.8, 0.95)), 2)

    def count(circuits: int, turns: float) -> int:
        return starts * circuits * max(1, floor(filling * turns * 2.0 * pi / touching))

    allowed = [c for c in CIRCUITS if not (halved and c[0] % 2)]
    circuits, turns = allowed[int(rng.integers(max(1, sum(count(*c) <= BALLS for c in allowed))))]
    keys = {"diameter": f"{ball:g} mm", "filling": filling, "turns": turns, "circuits": circuits}
    return keys | ({"circuit_gap": 0.5} if circuits > 1 else {}), count(circuits, turns)


def _preload(rng: np.random.Generator, kind: str, ball: float, force: float) -> dict[str, str]:
    """Keys of a preload or clearance for balls of a diameter [mm] and a usual axial load [N]."""
    size = 1e3 * OVERSIZE * ball * _log(rng, 0.3, 2.5)
    if kind == "force":
        return {"force": f"{force * _log(rng, 0.1, 0.6):.3g} N"}
    if kind == "lead offset":
        return {"lead_offset": f"{2.0 * size * rng.choice([-1.0, 1.0]):.3g} um"}
    return {"oversize": f"{size if kind == 'oversize' else -size:.3g} um"}


def _errors(rng: np.random.Generator) -> dict[str, Any]:
    """Random errors of a tolerance class, or none."""
    chosen = int(rng.integers(len(CLASSES) + 1))
    if chosen == len(CLASSES):
        return {}
    radius, pitch, round_ = (f"{x:g} um" for x in CLASSES[chosen])
    flank = {"pitch": [{"harmonic": 1, "sigma": pitch}], "roundness": [{"harmonic": 2, "sigma": round_}]}
    return {"seed": int(rng.integers(2**31)), "balls": {"sigma": radius}} | dict.fromkeys(("SL", "SR", "NL", "NR"), flank)


def _supports(rng: np.random.Generator, length: int) -> list[dict[str, Any]]:
    """Fixed bearing on the left; on the right a floating or a clamped one, offset or tilted or not, or none."""
    left = {"at": "0 mm", "fix": ["ux", "uy", "rx", "ry", "rz"]}
    right = str(rng.choice(["floating", "floating", "clamped", "none"]))
    offset, tilt = rng.random() < 0.35, rng.random() < 0.25
    moved, turned = _log(rng, 10.0, 200.0), _log(rng, 0.03, 0.3)
    if right == "none":
        return [left]
    held, given = ["uy"], {}
    if offset:
        given["ux"] = f"{moved:.3g} um"
    else:
        held.append("ux")
    if right == "clamped":
        held.append("rx")
        if tilt:
            given["ry"] = f"{turned:.3g} mrad"
        else:
            held.append("ry")
    return [left, {"at": f"{length} mm", "fix": held} | ({"displace": given} if given else {})]


def _loads(rng: np.random.Generator, force: float, radius: float, at: str) -> list[dict[str, Any]]:
    """Axial load at the left end, about a usual one [N]; at the nut a moment or a radial force or none."""
    axial = force * _log(rng, 0.15, 1.6) * rng.choice([-1.0, 1.0])
    moment = force * radius * 1e-3 * rng.uniform(0.05, 0.5) * (rng.random() < 0.3)
    radial, turn = force * rng.uniform(0.02, 0.2) * (rng.random() < 0.3), rng.uniform(0.0, 2.0 * pi)
    out: list[dict[str, Any]] = [{"at": "0 mm", "force": ["0 N", "0 N", f"{axial:.4g} N"]}]
    if moment or radial:
        x, y = np.cos(turn), np.sin(turn)
        across = [f"{radial * x:.4g} N", f"{radial * y:.4g} N", "0 N"]
        out.append({"at": at, "force": across, "moment": [f"{-moment * y:.4g} N m", f"{moment * x:.4g} N m", "0 N m"]})
    return out


def _nut_length(scene: Mapping[str, Any], rng: np.random.Generator) -> float:
    """Length [mm] of a nut that ends 1 to 6 ball radii beyond its last balls, whole micrometres."""
    read = scene_file.loads(_toml({k: v for k, v in scene.items() if k != "preload"}), "survey.toml")
    reach = float(np.abs(ball_layout(read).z - read.nut.position).max())
    return round(1e3 * 2.0 * (reach + read.balls.radius * _log(rng, 1.0, 6.0)) + 5e-4, 3)


def _toml(scene: Mapping[str, Any]) -> str:
    """A scene's keys as TOML: plain values and lists, then tables and lists of tables."""
    plain = {k: v for k, v in scene.items() if not isinstance(v, Mapping) and not _tables(v)}
    lines = [f"{k} = {show(v)}" for k, v in plain.items()]
    for name, value in scene.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{name}]", *(f"{k} = {show(v)}" for k, v in value.items())]
        elif _tables(value):
            for row in value:
                lines += ["", f"[[{name}]]", *(f"{k} = {show(v)}" for k, v in row.items())]
    return "\n".join(lines) + "\n"


def _tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)
