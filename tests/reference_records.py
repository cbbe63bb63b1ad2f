"""Shared by the tests of stored references: a run and condensed bodies as if computed."""

from dataclasses import asdict

import numpy as np

from rollbench.compare.reference.store import Run
from rollbench.compare.reference.tasks import mesh_settings
from rollbench.compare.scenes import catalogue
from rollbench.meshes.condensed import CondensedBodies, digest_of_geometry
from rollbench.meshes.parts import Scene


def run_of(scene_name: str, level: int, load_: np.ndarray, variant: str = "", group: tuple[str, ...] = ()) -> Run:
    """A run as meshed together with the scenes of ``group``."""
    settings = asdict(mesh_settings([catalogue.scene(n) for n in (group or (scene_name,))], level, variant))
    which = {"scene": scene_name, "level": level, "variant": variant, "settings": settings, "sides": (0, 3)}
    loads = {"load": load_, "frozen": load_, "without": {"elastic nut": load_}, "status": "converged", "unknowns": 10}
    moved = {"angle": np.full(load_.shape, np.nan), "centreline": np.zeros((3, 4))}
    effort = {"without_seconds": {"elastic nut": 1.0}, "stages": {"meshes": 1.0, "nut": 2.0}, "solve_seconds": 0.5}
    checks = {"balance": 0.0, "along_groove": 0.0, "screw_balance": 0.0, "quality": {"elements across 2b": 6.0}}
    origin = {"peak_MB": 5.0, "assumed": ("nothing",), "versions": {}, "date": "2026-01-01"}
    return Run(**which, **loads, **moved, **effort, **checks, **origin)


def bodies_of(scene: Scene, level: int, sides: tuple[int, ...] = (0, 3)) -> CondensedBodies:
    k = len(sides)
    body, ball = 1e-9 * np.eye(scene.ball_count * k // 2), 1e-9 * np.eye(k)
    contacts = np.full((k, 2), 1e-9), np.tile([100.0, 200.0], (k, 1)), np.full(k, 1e-7)
    return CondensedBodies(digest_of_geometry(scene), level, np.array(sides, dtype=float), 0.3, body, body, ball, *contacts)
