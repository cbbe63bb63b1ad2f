"""What a screw under tension or bending does to its grooves by Poisson's ratio, and they to it.

A beam's sections are rigid to its contacts; real ones shrink under tension and bend their outline under a moment (the
anticlastic surface). By Saint-Venant a section that stretches by e and bends by k_x, k_y moves its surface of radius r
outward by

    u_r = -nu r e + nu r^2 / 2 (k_y cos t - k_x sin t).

By reciprocity a contact that presses inward lengthens the screw, or kinks it. Between the contacts of one set the smooth
body of revolution (`lowfi.compliance.tube`) holds this, its upper end free; a beam that goes on from there, to a support or
a load, sets its own forces to all sections below, and those are what is added here: the difference between the supported
beam and the cantilever that the smooth body stands on.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lowfi.statics.problem import Problem
from lowfi.statics.shaft import Shaft, free_state, rows_of, shaft_of
from lowfi.statics.shape import shape_matrix, shear_ratio
from meshes.helix import nominal_contact_points
from meshes.solid import dimensions

Array = NDArray[np.float64]


def loaded_beyond(problem: Problem) -> bool:
    """Whether the beam carries anything beyond the last contact: only then do its forces differ from the cantilever's."""
    if problem.basis is not None:
        return False
    beyond = problem.nodes > float(problem.layout.z.max()) + 1e-9
    return bool(problem.fixed[beyond].any() or problem.load[beyond].any())


def squeeze_rows(problem: Problem, used: list[int]) -> Array:
    """Outward motion of the contacts of the used sides of the screw, side after side, by the motions of all nodes:
    ``(2 c, 6 n)``, zero along the second axis of each."""
    scene, nodes = problem.scene, problem.nodes
    nu, count = scene.screw.material.poissons_ratio, problem.layout.z.size
    out = np.zeros((len(used) * count, 2, 6 * nodes.size))
    for i in range(count):
        tension, kx, ky = _strains(problem, float(problem.layout.z[i]))
        c, s = problem.layout.radial[i, :2]
        for k, side in enumerate(used):
            r = scene.track.pitch_radius + float(nominal_contact_points(scene)[side][0])
            out[k * count + i, 0] = -nu * r * tension + 0.5 * nu * r**2 * (c * ky - s * kx)
    return out.reshape(2 * len(out), -1)


def _strains(problem: Problem, z: float) -> Array:
    """Rows ``(3, 6 n)``: stretch and both curvatures of the beam at a station, by the motions of all nodes; at a node the
    mean of both sides."""
    nodes = problem.nodes
    out = np.zeros((3, 6 * nodes.size))
    near = [e for e in range(nodes.size - 1) if nodes[e] - 1e-9 <= z <= nodes[e + 1] + 1e-9]
    for e in near:
        section = problem.section if problem.sections is None else problem.sections[e]
        length = float(nodes[e + 1] - nodes[e])
        xi = min(max((z - float(nodes[e])) / length, 0.0), 1.0)
        slopes = shape_matrix(xi, length, float(shear_ratio(length, section)), 1) / length
        out[:, 6 * e : 6 * e + 12] += slopes[[2, 3, 4]] / len(near)
    return out


def squeezed(shaft: Shaft, used: list[int]) -> tuple[Array, Array, Array]:
    """What is added to the compliance ``(2 c, 2 c)`` of the flanks and to their motion ``(2 c,)`` by loads and prescribed
    displacements (see `lowfi.statics.shaft.flank_response`), and the rows that it comes from (`squeeze_rows`)."""
    problem = shaft.problem
    dof, rows = rows_of(problem, used)
    rigid = np.zeros((2 * len(rows), 6 * problem.nodes.size))
    for c, (own, row) in enumerate(zip(dof, rows, strict=True)):
        rigid[2 * c : 2 * c + 2, own] = row
    outward = squeeze_rows(problem, used)
    G = np.zeros((len(rigid), len(rigid)))
    for beam, sign in ((shaft, 1.0), (shaft_of(_cantilever(problem)), -1.0)):
        across = outward @ beam.solve(rigid.T)
        G += sign * (across + across.T + outward @ beam.solve(outward.T))
    return 0.5 * (G + G.T), outward @ free_state(shaft), outward


def _cantilever(problem: Problem) -> Problem:
    """The beam held at the node where the smooth body's low end is, and nowhere else, without loads."""
    low = dimensions(problem.scene).ends(problem.scene)[0]
    below = np.flatnonzero(problem.nodes <= min(low, float(problem.layout.z.min())) + 1e-9)
    base = int(below[-1]) if below.size else 0
    fixed = np.zeros_like(problem.fixed)
    fixed[base] = True
    return replace(problem, fixed=fixed, prescribed=np.zeros_like(problem.prescribed), load=np.zeros_like(problem.load))
