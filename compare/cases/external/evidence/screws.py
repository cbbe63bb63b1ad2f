"""Ball nuts of catalogues: the three rigidities that ISO 3408-4 separates beside the printed one, and drag torque."""

from __future__ import annotations

from dataclasses import replace
from math import pi

from rollbench.compare.cases.external.evidence.case import PREFIX, given, inputs
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import entry
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force, body_compliance, contacts_displacement
from rollbench.meshes.parts import Friction, Motion, Scene
from rollbench.meshes.roots import brentq

#: Sizes of THK and one of HIWIN: names of scenes after the prefix and the maker.
THK = ("bnf-4010-5", "bnf-4010-3p5", "bnf-3205-2p5", "bnf-3205-5", "bnf-3205-7p5")
HIWIN = ("hiwin-63-10k5",)
#: Scene of the double nut's single nut.
DOUBLE = "bnf-4010-5"
#: Shares of the rigidity of the contacts alone that an independent code found: lowest and highest, THK and HIWIN.
SHARES = {THK: (0.567, 0.586), HIWIN: (0.75, 0.75)}
#: What filling and pitch diameter, which are not printed, may change.
UNPRINTED = 0.05


def scene_name(size: str) -> str:
    """Name of the shipped scene of a size."""
    return f"{PREFIX}{size}" if size in HIWIN else f"{PREFIX}thk-{size}"


def stages(scene: Scene, force: float) -> tuple[float, float]:
    """Rigidity [N/m] of the contacts alone and with the bodies at an axial load [N]. Raises ValueError without a wall."""
    alone, body = contacts_displacement(scene, force), body_compliance(scene)
    assert body is not None
    return force / alone, force / (alone + body * force)


def unequal(study: Study, name: str, model: str) -> float:
    """Rigidity [N/m] with unequal loads by a model; zero where it did not converge."""
    scene, found = study.scene(name), study.solve(name, model)
    return axial_force(found) / axial_displacement(scene, found) if found.converged else 0.0


def nuts(sheet: Sheet, study: Study) -> None:
    """Rigidities at 0.3 times the rating, their growth with the turns, the double nut, drag torque."""
    alone, bodies = {}, {}
    for size in (*THK, *HIWIN):
        scene = study.scene(scene_name(size))
        alone[size], bodies[size] = (1e-6 * x for x in stages(scene, scene.loads[0].force[2]))
        printed = entry(sheet.table, f"rigidity_{size}").value or 0.0
        share = printed / alone[size]
        words = f"catalogue {printed / bodies[size]:.3f} of it; contacts alone {alone[size]:.0f} N/um"
        sheet.number(f"rigidity_{size}", bodies[size], words)
        low, high = next(ends for sizes, ends in SHARES.items() if size in sizes)
        words = f"{share:.3f} of {alone[size]:.0f} N/um"
        sheet.claim(f"share_{size}", low * (1.0 - UNPRINTED) <= share <= high * (1.0 + UNPRINTED), words)
    for turns, size in (("5", "bnf-3205-5"), ("7p5", "bnf-3205-7p5")):
        sheet.number(f"turns_{turns}", alone[size] / alone["bnf-3205-2p5"], "contacts alone")
    words = f"contacts alone {2.0**1.5 / 3.0 ** (1.0 / 3.0):.3f}"
    sheet.number("double", double_over_single(study), f"with the bodies; {words}")
    _drag(study, sheet)


def double_over_single(study: Study) -> float:
    """Rigidity of a double nut preloaded to a third of the single nut's load, up to the load that unloads one nut, over
    that of the single nut, both with their bodies.

    Either nut moves by its own deflection under the preload before the other one is loose, and then carries all.
    """
    scene = study.scene(scene_name(DOUBLE))
    full = scene.loads[0].force[2]
    preload = full / 3.0
    single = stages(scene, full)[1]
    moved = preload / stages(scene, preload)[1]

    def excess(force: float) -> float:
        return force / stages(scene, force)[1] - 2.0 * moved

    unloads = float(brentq(excess, preload, 4.0 * preload, rtol=1e-6))
    return unloads / moved / single


def _drag(study: Study, sheet: Sheet) -> None:
    """Preload drag torque by the maker's formula, and by sliding of the balls in both nuts."""
    case = inputs()["thk"]
    preload, lead, mu = given("thk", "preload", "force"), given("thk", "lead", "length"), float(case["friction"])
    formula = 0.05 * case["tangent"] ** -0.5 * preload * lead / (2.0 * pi)
    sheet.number("drag_formula", 1e3 * formula)
    torque = study.once(drag_torque, preload, mu)
    printed = entry(sheet.table, "drag").value or 0.0
    words = (
        f"both nuts at a coefficient of {mu:g}, friction moving each ball across its grooves as in every scene that says "
        f"nothing else: {1e3 * torque / printed:.2f} times the printed torque"
    )
    sheet.number("drag", 1e3 * torque, words)


def drag_torque(study: Study, preload: float, mu: float) -> float:
    """Friction torque [N m] of both nuts of a double nut under a preload [N], each as a single nut under that load."""
    scene = study.scene(scene_name(DOUBLE))
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, preload)) for x in scene.loads))
    found = run_model(nut, "lin", Options(discretisation=False))
    return 2.0 * friction_state(nut, found, Friction(mu, mu), Motion(2.0 * pi)).torque.friction
