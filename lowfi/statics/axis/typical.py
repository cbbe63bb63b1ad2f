"""Sizes of an assembly before it is solved: force of a typical contact, its stiffness, what residuals are measured by."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.hertz import contact_force
from rollbench.lowfi.statics.axis.system import BallSet, System
from rollbench.lowfi.statics.problem import tightest
from rollbench.meshes.axis import Housing
from rollbench.meshes.parts import Load


def applied(system: System) -> float:
    """Loads on shaft and housings [N], moments over the largest pitch radius; what holds a warm shaft does not count."""
    bodies: tuple[Load | Housing, ...] = (*system.assembly.loads, *system.assembly.housings)
    return float(sum(np.abs(x.force).sum() + np.abs(x.moment).sum() / system.arm for x in bodies))


def pair_compliance(b: BallSet) -> float:
    """C of two opposite contacts in series [m/N^(2/3)]."""
    return float(np.mean(b.problem.C[:, 0] + b.problem.C[:, 3]))


def squeeze(b: BallSet) -> float:
    """Approach [m] of a set's contacts by oversized balls or the shift of its outer part, all else held."""
    shift = {"+z": -b.of.offset, "-z": b.of.offset}.get(b.of.thrust, abs(b.of.offset))
    return max(tightest(b.problem), shift * float(np.sin(b.problem.scene.track.contact_angle)))


def typical_force(system: System, b: BallSet) -> float:
    """Force [N] of a typical contact of a set: its mean share of the loads, or what it is squeezed by; a micrometre's where
    only displacements are given. At least 1e-6 N."""
    elements = max(1, system.contacts.r_ball.size + sum(r.row.count for r in system.rollers))
    pair = pair_compliance(b)
    force = max(applied(system) / elements, float(contact_force(squeeze(b), pair)))
    if force == 0.0 and np.any(system.structure.prescribed):
        force = float(contact_force(1e-6, pair))
    return max(force, 1e-6)


def typical(system: System) -> tuple[float, float, float]:
    """Force [N] of a typical loaded contact, its secant stiffness [N/m], and least force [N] that residuals count by."""
    load = system.structure.load
    elements = max(1, system.contacts.r_ball.size + sum(r.row.count for r in system.rollers))
    force, stiffness, floor = applied(system) / elements, 1.0, 0.0
    squeezed = 0.0
    for b in system.balls:
        pair = pair_compliance(b)
        squeezed = max(squeezed, float(contact_force(squeeze(b), pair)))
        if force == 0.0 and squeezed == 0.0 and np.any(system.structure.prescribed):
            squeezed = float(contact_force(1e-6, pair))
    force = max(force, squeezed)
    for b in system.balls:
        stiffness = max(stiffness, float(np.cbrt(force) / pair_compliance(b)) if force > 0.0 else 1.0)
    for r in system.rollers:
        per_length = max(force, 1.0) / r.row.length
        law = r.arrays
        stiffness = max(stiffness, r.row.length / r.row.slices / float(law.g[0] - law.s[0] * np.log(per_length)))
    floor = max(float(np.abs(load[:, :3]).max()), float(np.abs(load[:, 3:]).max()) / system.arm, squeezed)
    return force, stiffness, floor
