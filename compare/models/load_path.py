"""Where the loads of a scene go: into its supports and the frames of its housings, or through its contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from rollbench.lowfi.statics.result import AxisResult, Solved, StaticResult
from rollbench.lowfi.statics.summary import about_origin
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Load, Scene
from rollbench.meshes.quantity import Stated, quantity, record

#: Part of a load below which it is called little.
LITTLE = 0.05
#: Part of a load below which it is round-off, or of no interest.
NOTHING = 5e-4
#: Words for the six components of a load.
COMPONENTS = tuple(f"{way} {axis}" for way in ("along", "about") for axis in "xyz")


@record
class Taker:
    """What holds shaft or housing, by its name, and what it takes of the loads: force and moment (6,) [N, N m]."""

    name: str = quantity("name", "support of the shaft by its station, or frame of a housing")
    part: Array = quantity(
        "force_N",
        "what the support of this name (of several sets also the frame of a housing) takes of the loads: the force on it, "
        "less that without the loads",
        Stated("moment_Nm", "the same of the moment on it, at its station", show=lambda part: part[3:], parts="[]"),
        show=lambda part: part[:3],
        parts="[]",
    )


@record
class LoadPath:
    """applied: force and couple (6,) of all loads [N, N m]; on_shaft: of those on the shaft; takers: supports of the shaft,
    frames of housings; contacts: what the loads change of the forces and moments (6,) of the contacts, moments about their
    nut or ring; of several sets the sum of the sizes; arm [m]: pitch radius, which makes forces of couples.

    All are differences from the scene without its loads, so that displacements of supports and preload do not count. where:
    what the loads act on, of those on one body only; empty for all.
    """

    applied: Array = quantity(
        "applied.force_N",
        "sum of the forces of the scene's loads, on shaft and housings, along x, y, z",
        Stated(
            "applied.moment_Nm",
            "sum of the couples of its loads about x, y, z, as they are written",
            show=lambda applied: applied[3:],
            parts="[]",
        ),
        show=lambda applied: applied[:3],
        parts="[]",
    )
    on_shaft: Array
    takers: tuple[Taker, ...] = quantity("supports")
    contacts: Array = quantity(
        "contacts.force_N",
        "what the loads change of the force that the contacts take from the screw; of several sets the sum of the changes' "
        "sizes",
        Stated(
            "contacts.moment_Nm",
            "the same of the moment about the centre of the nut or ring",
            show=lambda contacts: contacts[3:],
            parts="[]",
        ),
        show=lambda contacts: contacts[:3],
        parts="[]",
    )
    arm: float
    where: str = ""


def path_of_set(scene: Scene, result: StaticResult, bare: StaticResult) -> LoadPath | None:
    """Where the loads of one set go; bare: its result without them. None without loads."""
    applied = sum_of(scene.loads)
    if not applied.any():
        return None
    contacts = _at(scene.nut.position, _on_screw(result) - _on_screw(bare))
    return LoadPath(applied, applied, _supports(scene, result, bare), -contacts, scene.track.pitch_radius)


def path_of_sets(assembly: Assembly, result: AxisResult, bare: AxisResult, where: str = "") -> LoadPath | None:
    """Where the loads on a shaft and its housings go; bare: the result without them. None without loads."""
    on_shaft = sum_of(assembly.loads)
    applied = on_shaft + sum_of([Load(h.at, h.force, h.moment) for h in assembly.housings])
    if not applied.any():
        return None
    pairs = zip(result.housings, bare.housings, strict=True) if bare.converged else ((h, None) for h in result.housings)
    frames = (Taker(f"the frame of {a.name}", -(a.wrench - (0.0 if b is None else b.wrench))) for a, b in pairs)
    each = [np.concatenate([s.force, s.moment]) for s in result.sets]
    idle = [np.concatenate([s.force, s.moment]) for s in bare.sets] if bare.converged else [np.zeros(6)] * len(each)
    contacts = np.abs(np.array(each) - np.array(idle)).sum(axis=0)
    radii = [s.parts.track.pitch_radius for s in assembly.sets if isinstance(s.parts, Scene)]
    arm = max(radii, default=assembly.screw.outer_diameter / 2.0)
    return LoadPath(applied, on_shaft, (*_supports(assembly, result, bare), *frames), contacts, arm, where)


def loaded_bodies(assembly: Assembly) -> dict[str, tuple[Assembly, Assembly]]:
    """Of each body with loads, the shaft or a housing, by name: the assembly with its loads only, and with all others."""
    none, out = (0.0, 0.0, 0.0), dict[str, tuple[Assembly, Assembly]]()
    bare = tuple(replace(h, force=none, moment=none) for h in assembly.housings)
    off = tuple(replace(x, force=none, moment=none) for x in assembly.loads)
    if sum_of(assembly.loads).any():
        out["the shaft"] = replace(assembly, housings=bare), replace(assembly, loads=off)
    for i, h in enumerate(assembly.housings):
        if any((*h.force, *h.moment)):
            alone, others = (*bare[:i], h, *bare[i + 1 :]), (*assembly.housings[:i], bare[i], *assembly.housings[i + 1 :])
            out[h.name] = replace(assembly, loads=off, housings=alone), replace(assembly, housings=others)
    return out


def sum_of(loads: Sequence[Load]) -> Array:
    """Force and couple (6,) of loads as they are written, without the moments of forces [N, N m]."""
    return np.asarray(np.array([(*x.force, *x.moment) for x in loads]).reshape(-1, 6).sum(axis=0))


def _supports(scene: Scene | Assembly, result: Solved, bare: Solved) -> tuple[Taker, ...]:
    if not len(result.reactions):  # the axial models of Mei know no single support
        return ()
    idle = bare.reactions if bare.converged else np.zeros(result.reactions.shape)
    parts = zip(scene.supports, -(result.reactions - idle), strict=True)
    return tuple(Taker(f"the support at {1e3 * s.at:.6g} mm", part) for s, part in parts)


def _on_screw(result: StaticResult) -> Array:
    """Force and moment (6,) of the contacts on the screw, about the origin; none without a solution."""
    e = result.equilibrium
    return np.zeros(6) if e is None or not result.converged else np.concatenate([e.contact_force, e.contact_moment])


def _at(station: float, wrench: Array) -> Array:
    """A wrench (6,) about a station [m] of the axis in place of the origin."""
    return about_origin(np.array([-station]), wrench[None])


def path_words(path: LoadPath) -> str:
    """How much of each component of the loads goes into which support; empty where supports take nothing of it."""
    out = []
    for k in np.flatnonzero(path.applied):
        load, unit = float(path.applied[k]), "N" if k < 3 else "N m"
        into = [(t.name, float(t.part[k])) for t in path.takers if abs(t.part[k]) > NOTHING * abs(load)]
        if into:
            each = ", ".join(f"{part:.5g} {unit} into {name}" for name, part in into)
            out.append(
                f"of {load:.5g} {unit} {COMPONENTS[k]} {each}, {float(path.contacts[k]):.3g} {unit} through contacts"
            )
    return "; ".join(out)


def path_warnings(path: LoadPath | None) -> Iterator[Warned]:
    """A warning where little of the axial force, or of all loads on the shaft together, reaches the contacts: what is
    computed of them then says nothing of the load. Of loads on several bodies: of the path of each by itself."""
    if path is None:
        return
    size, axial = np.repeat([1.0, 1.0 / path.arm], 3), path.applied[2]
    given = path.on_shaft != 0.0
    load = float(np.linalg.norm((path.on_shaft * size)[given]))
    reached = float(np.linalg.norm((path.contacts * size)[given]))
    if axial and abs(path.contacts[2]) < LITTLE * abs(axial):
        on = f" on {path.where}" if path.where else ""
        what, share = f"the axial load of {axial:.5g} N{on}", abs(path.contacts[2] / axial)
    elif load and reached < LITTLE * load:
        what, share = "the loads on the shaft", reached / load
    else:
        return
    words = path_words(path)
    text = (
        f"of {what} only {100.0 * share:.2g} % reaches the contacts, and what is computed of them holds for that: {words}; "
        "free the freedom that holds it, unless that is meant"
    )
    yield Warned("held load", text, f"only {100.0 * share:.2g} % of {what} reaches the contacts, supports take the rest")
