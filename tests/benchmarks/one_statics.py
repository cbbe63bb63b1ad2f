"""Run time of the force formulation with the beam's compliance against the solvers of beam and axis, compiled, in one run.

`python -m tests.benchmarks.one_statics` prints processor seconds of both, their ratio, and the largest difference of a
load over the largest load: one solve of 32 and of 240 balls, an axis of six sets, and 1,000 members of an ensemble. It
prints the differences on all shipped scenes too.
"""

import sys
from dataclasses import replace
from time import process_time

import numpy as np
from tests.axes import TURNING, assembly, fixed_axis, nut

from rollbench.compare.scenes.catalogue import names_of_single_nut_scenes, shipped_scene
from rollbench.compare.studies.members.ensemble import solve_random_draws
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.jit import STATICS, load_kernel_package
from rollbench.lowfi.statics.axis.elastic import solve_assembly_with_elastic_bodies
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.elastic import SpecimensWithSharedEquations, solve_elastic
from rollbench.lowfi.statics.response import clear_compliance_caches
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.parts import Scene
from rollbench.meshes.processes import limit_to_one_thread

#: The force formulation with what the source's model takes for elastic: the shaft as a beam.
BEAM = LADDER["lin"]
#: Members of the ensemble; times are the least of so many runs, in turns.
MEMBERS, RUNS = 1000, 9


def six_sets():
    """Shaft between two preloaded pairs of bearings, with two preloaded nuts in a carriage that slides along it."""
    bearings, (housing,) = fixed_axis().sets[:4], fixed_axis().housings
    nuts = (nut(f"nut {z}", z, housing="carriage", offset=x) for z, x in ((0.13, -3e-6), (0.17, 3e-6)))
    return assembly(*bearings, *nuts, housings=(replace(housing, at=0.15),), supports=(TURNING,))


def by_rows(scene):
    """Loads (N, 4) [N] by the solvers on motions."""
    solve = solve_static if isinstance(scene, Scene) else solve_assembly
    return loads_of(solve(scene, engine="compiled"))


def by_forces(scene):
    """Loads (N, 4) [N] by the force formulation."""
    solve = solve_elastic if isinstance(scene, Scene) else solve_assembly_with_elastic_bodies
    return loads_of(solve(scene, backend=BEAM, engine="compiled"))


def loads_of(result):
    """Loads (N, 4) [N] of the balls of all sets."""
    return np.concatenate([b.load for b in result.ball_results()])


def members_by_rows(scene):
    """Loads (M, N, 4) [N]."""
    return solve_random_draws(scene, MEMBERS).loads


def members_by_forces(scene):
    """Loads (M, N, 4) [N]."""
    return SpecimensWithSharedEquations(scene, BEAM, load_kernel_package(STATICS, compiled=True)).solve(0, MEMBERS)[0]


def least(functions, scene, runs):
    """Least processor seconds of each function, in turns, and what it found."""
    times, found = [float("inf")] * len(functions), [f(scene) for f in functions]
    for _ in range(runs):
        for k, f in enumerate(functions):
            clear_compliance_caches()
            begin = process_time()
            f(scene)
            times[k] = min(times[k], process_time() - begin)
    return times, found


def apart(a, b):
    """Largest difference over the largest of both."""
    return float(np.abs(a - b).max() / max(np.abs(a).max(), np.abs(b).max(), 1e-300)) if a.size else 0.0


def line(name, functions, scene, runs=RUNS):
    """Print one case."""
    (rows, forces), found = least(functions, scene, runs)
    print(f"{name:34} {1e3 * rows:10.2f} {1e3 * forces:10.2f} {forces / rows:7.2f} {apart(*found):10.1e}", flush=True)


def main():
    """Print the table and the differences."""
    one, members = (by_rows, by_forces), (members_by_rows, members_by_forces)
    print(f"{'compiled, CPU':34} {'rows ms':>10} {'forces ms':>10} {'ratio':>7} {'apart':>10}")
    line("32 balls, two sides", one, shipped_scene("lin-case1"))
    tight, oversize = shipped_scene("lin-case1"), replace(shipped_scene("lin-case1").errors.balls, oversize=3e-6)
    line("32 balls, four sides", one, replace(tight, errors=replace(tight.errors, balls=oversize)))
    line("240 balls", one, shipped_scene("external-thk-bnf-3205-7p5"))
    line("six sets", one, six_sets())
    line("1,000 members", members, shipped_scene("lin-random"), 3)
    if "--scenes" in sys.argv:
        for name in names_of_single_nut_scenes():
            scene = shipped_scene(name)
            print(f"{name:34} {apart(by_rows(scene), by_forces(scene)):10.1e}")


if __name__ == "__main__":
    limit_to_one_thread()
    main()
