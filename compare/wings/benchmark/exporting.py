"""The benchmark as a folder: problems, answers, the page that explains them, and on demand meshes and STEP files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from string import Template
from typing import Any

from rollbench.comparison import __version__
from rollbench.comparison.models.total_uncertainty import SHARED
from rollbench.comparison.system import need_gmsh, need_packages
from rollbench.comparison.wings.benchmark import scoring
from rollbench.comparison.wings.benchmark.answers import FILE, Answers, mean_load, shipped
from rollbench.comparison.wings.benchmark.neutral import UNITS, described
from rollbench.comparison.wings.benchmark.problems import HERE, JUNCTION, NAME, PROBLEMS, Problem, fixed_text
from rollbench.comparison.wings.export.command import BODIES, part_mesh
from rollbench.comparison.writing import replace_file
from rollbench.meshes.axis import Assembly
from rollbench.meshes.exchange.mesh_files import write_mesh
from rollbench.meshes.parts import FREEDOMS, SIDES, BallErrors, Errors

Step = Callable[[str], None]
#: Mesh level of the whole bodies that are written.
LEVEL = 1
#: Oversize [m] with which all flanks of a set touch, to refine their meshes.
TOUCHING = 2e-6
NUMBER = {"type": "number"}
POSITIVE = {"type": "number", "exclusiveMinimum": 0}


def schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a problem."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"A problem of {NAME}, in SI units",
        **_object(
            benchmark={"const": NAME},
            problem={"enum": list(PROBLEMS)},
            title=_text("what it is"),
            shows=_text("what it is there for"),
            units={"const": UNITS},
            shaft=_object(
                "screw, or inner ring",
                z=_numbers(2, "ends along the axis"),
                land_radius=POSITIVE | {"description": "of the cylinder between the grooves"},
                bore_radius=POSITIVE | {"description": "of the hole along the axis"},
                bore_moves_as_rigid_body={"type": "boolean"},
                material=_material(),
            ),
            sets={"type": "array", "minItems": 1, "items": _set()},
            supports={"type": "array", "items": _object(z=NUMBER, motion=_motion("of the shaft's section, m or rad"))},
            loads={"type": "array", "items": _object(z=NUMBER, force=_numbers(3, "N"), moment=_numbers(3, "N m"))},
        ),
    }


def _set() -> dict[str, Any]:
    flank = _object(
        radius=POSITIVE, centre_x3_z3=_numbers(2, "middle of the arc in the section of a ball, before any load")
    )
    return _object(
        "a nut or outer ring with its balls",
        name=_text("empty where there is one set"),
        helix=_object(
            pitch_radius=POSITIVE,
            lead={"type": "number", "minimum": 0, "description": "0: a ring"},
            hand={"enum": ["right", "left"]},
            azimuth_at_nut_centre=NUMBER,
        ),
        contact_angle=NUMBER | {"description": "of the flanks' centres, from the radius"},
        nut=_object(
            z=_numbers(2, "its faces: left, right"),
            shift_z=NUMBER | {"description": "by which it is pushed along z when it is mounted"},
            land_radius=POSITIVE,
            outer_radius=POSITIVE,
            material=_material(),
            held=_object(
                surface={"enum": ["left face", "right face", "outer surface"]}, motion=_motion("of all its points")
            ),
        ),
        flanks=_object(**dict.fromkeys(SIDES, flank)),
        stretch_meshed_by_the_reference=_numbers(2, "beyond it the reference has beams of the grooved shaft's section"),
        ball_material=_material(),
        balls={
            "type": "array",
            "items": _object(
                number={"type": "integer", "minimum": 1}, radius=POSITIVE, azimuth=NUMBER, centre=_numbers(3, "x, y, z")
            ),
        },
    )


def _object(description: str = "", /, **properties: dict[str, Any]) -> dict[str, Any]:
    about = {"description": description} if description else {}
    return about | {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def _material() -> dict[str, Any]:
    return _object(youngs_modulus=POSITIVE, poissons_ratio=NUMBER)


def _motion(description: str) -> dict[str, Any]:
    motions = {"type": "object", "properties": dict.fromkeys(FREEDOMS, NUMBER), "additionalProperties": False}
    return motions | {"description": description}


def _numbers(count: int, description: str) -> dict[str, Any]:
    return {"type": "array", "items": NUMBER, "minItems": count, "maxItems": count, "description": description}


def _text(description: str) -> dict[str, Any]:
    return {"type": "string", "description": description}


def export(folder: Path, *, meshes: bool, step_files: bool, step: Step) -> list[str]:
    """Write the benchmark into a folder, files of that name replaced; names of the files.

    Raises InputError where answers are of another state, a file cannot be written, or gmsh is missing for meshes or STEP.
    """
    answers = shipped()
    if meshes or step_files:
        need_gmsh()
    texts = {
        "README.html": page(answers),
        "LICENSE.txt": (HERE / "LICENSE.txt").read_text(encoding="utf-8"),
        "schema.json": _json(schema()),
        FILE: (HERE / FILE).read_text(encoding="utf-8"),
    }
    for name, one in PROBLEMS.items():
        texts[f"problems/{name}.toml"] = fixed_text(one)
        texts[f"problems/{name}.json"] = _json(described(one))
    for name, text in texts.items():
        replace_file(folder / name, text)
    written = list(texts)
    held: dict[str, float] = {}
    if step_files:
        from rollbench.comparison.wings.benchmark.step_files import write_step

        for name, one in PROBLEMS.items():
            step(f"{name}: STEP")
            files = write_step(one, folder / "step")
            held |= {f"step/{path.name}": worst for path, worst in files.items()}
        written += held
    if meshes:
        need_packages("scikit-fem")
        for name, one in PROBLEMS.items():
            step(f"{name}: meshes")
            written += [str(path.relative_to(folder)) for path in write_meshes(one, folder / "meshes")]
    replace_file(folder / "manifest.json", _json(manifest(folder, written, answers, held)))
    return [*written, "manifest.json"]


def manifest(folder: Path, files: list[str], answers: Mapping[str, Answers], held: dict[str, float]) -> dict[str, Any]:
    """Hashes and sizes of the files, licence, and what the problems are; held: how far STEP surfaces are off [m]."""
    entries: dict[str, dict[str, Any]] = {}
    for name in files:
        data = (folder / name).read_bytes()
        entries[name] = {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
        if held.get(name):
            entries[name]["largest_distance_um"] = round(1e6 * held[name], 3)
    problems = {name: {"loaded_contacts": _loaded(a), "mean_load_N": mean_load(a)} for name, a in answers.items()}
    return {
        "benchmark": NAME,
        "made_by": f"rollbench {__version__}",
        "licence": "MIT (LICENSE.txt)",
        "problems": problems,
        "files": entries,
    }


def page(answers: Mapping[str, Answers]) -> str:
    """The page that explains the benchmark."""
    low, high = SHARED
    values = {
        "version": __version__,
        "problems": "\n".join(_row(one, answers[name]) for name, one in PROBLEMS.items()),
        "drawing": (HERE / "drawing.svg").read_text(encoding="utf-8"),
        "junction": f"{JUNCTION:g}",
        "shared": f"{low:g} to {high:g}",
        "load": f"{scoring.LOAD:g}",
        "shape": f"{scoring.SHAPE:g}",
        "angle": f"{scoring.ANGLE:g}",
        "heavy": f"{scoring.HEAVY:g}",
    }
    return Template((HERE / "page.html").read_text(encoding="utf-8")).substitute(values)


def _row(one: Problem, answers: Answers) -> str:
    mean = mean_load(answers)
    cells = f"<td>{one.name}</td><td>{one.shows}</td>"
    worst = 100.0 * max(c.uncertainty for c in answers.values()) / mean
    numbers = (f"{len(answers) // len(SIDES)}", f"{_loaded(answers)}", f"{mean:.1f}", f"{worst:.2f}")
    cells += "".join(f'<td class="n">{x}</td>' for x in numbers)
    return f"<tr>{cells}</tr>"


def _loaded(answers: Answers) -> int:
    return sum(c.load > 0.0 for c in answers.values())


def write_meshes(one: Problem, folder: Path) -> list[Path]:
    """Whole bodies of a problem as VTU files: shaft (the stretch that the reference meshes), nut, ball; with two nuts those
    of the first, in stations that begin at its stretch."""
    from rollbench.hifi.several_sets import bodies_of

    scene = one.described
    bodies = scene
    if isinstance(bodies, Assembly):  # its errors are between the sets: all flanks touch where balls are too large
        bodies = replace(bodies_of(bodies)[0].bodies, errors=Errors(balls=BallErrors(oversize=TOUCHING)))
    folder.mkdir(parents=True, exist_ok=True)
    out = []
    for part in BODIES:
        out.append(folder / f"{one.name}-{part}.vtu")
        write_mesh(out[-1], part_mesh(bodies, part, LEVEL), form="vtu")
    return out


def _json(value: Any) -> str:
    return json.dumps(value, indent=1, allow_nan=False) + "\n"
