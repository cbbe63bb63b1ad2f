"""Equilibrium of several bearings and ball nuts on one shaft, as the minimum of one energy, found by Newton's method."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from time import perf_counter

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel
from rollbench.lowfi.statics import settle
from rollbench.lowfi.statics.axis import summary
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.equations import assembly_equations, grooved_shaft_section
from rollbench.lowfi.statics.axis.held import pin_unresisted_motions, status_of_runaway_assembly, unresisted_motions
from rollbench.lowfi.statics.axis.mount import PreloadShifts, find_axial_preload_shifts, replace_preload_forces_by_offsets
from rollbench.lowfi.statics.axis.system import AssemblyArrays
from rollbench.lowfi.statics.result import HEAT, AxisResult, SolverReport, Status
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.cache import cached_on_disk

#: Assumptions of every result of the refined model on an assembly.
ASSUMPTIONS = (
    "the shaft is a Timoshenko beam between its bearings and nuts; in addition the screw, nut and balls of each bearing or "
    "nut deform under their own contact forces, and respond to contacts elsewhere only by the section forces of the shaft",
    "housings are rigid; nuts and outer rings are fixed in them as the nut of a single ball screw is fixed in its scene",
    *ELASTIC_ASSUMPTIONS,
)
#: Effect that the model neglects for tapered roller bearings.
RIGID_RINGS = (
    "elastic rings: cone and cup are rigid apart from the line contacts, whose force law includes the local deformation"
)

#: Effect that the model neglects for an inner ring that a housing carries.
RIGID_INNER = "elastic inner ring: apart from its contacts it is rigid, like the housing that carries it"


#: Ratio of a body's displacement to the largest pitch radius, or rotation [rad], above which a linear program decides
#: whether the contacts can carry the loads.
FAR = 0.1


def moved_too_far(q: Array, system: AssemblyArrays) -> bool:
    """Return whether a shaft node or housing moved so far that the linear kinematics of the contacts no longer hold.

    Parameters
    ----------
    q
        Motions of shaft nodes and housings ``(r, 6)`` [m, rad].
    system
        Arrays of the assembly.
    """
    return not float((np.abs(q) / np.repeat([system.moment_arm, 1.0], 3)).max()) <= FAR


def solve_assembly(assembly: Assembly, *, member: int = 0) -> AxisResult:
    """Compute contact forces, stiffness and motions of a shaft with several bearings and nuts in static equilibrium.

    The shaft is a beam; nuts, outer rings and housings are rigid (model lin).

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    member
        Number of the specimen: each number gives other random errors.

    Returns
    -------
    AxisResult
        Forces, stiffness and motions; if there is no equilibrium, ``status`` gives the reason.

    Raises
    ------
    ValueError
        If dimensions leave a part without material.
    """
    return solve_assembly_by_model(assembly, None, "lin", member)


def solve_assembly_by_model(assembly: Assembly, backend: ComplianceModel | None, name: str, member: int) -> AxisResult:
    """Compute the static equilibrium of an assembly by a model, and return forces, stiffness and motions.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    backend
        Method by which the compliance of screws, nuts and balls is computed; None: they are rigid.
    name
        Name of the model in the result.
    member
        Number of the specimen: each number gives other random errors.
    """
    start = perf_counter()
    assumed = (*assembly.assumed, *(summary.AXIS_ASSUMPTIONS if backend is None else ASSUMPTIONS))

    def result_without_equilibrium(status: Status) -> AxisResult:
        """Return the result of an assembly without equilibrium, with the ``status`` that gives the reason."""
        report = SolverReport(0, 0, float("nan"), perf_counter() - start, 0, 0, "none")
        return AxisResult(model=name, status=status, solver=report, assumed=assumed)

    mounted, notes, unmet = replace_preload_forces_by_offsets(
        assembly, lambda bare: _preload_shifts(bare, backend, name, member)
    )
    if unmet:
        return result_without_equilibrium(unmet)
    section = None if backend is None else grooved_shaft_section(assembly, backend)
    system = axis_system.build_assembly_arrays(mounted, member, section)
    loose = unresisted_motions(system)
    if loose.is_driven_by_loads:
        return result_without_equilibrium(Status("not held", loose.description))
    prepared = assembly_equations(pin_unresisted_motions(system, loose), backend)
    ready = perf_counter()
    prepared, outcome = solve_alone(settle.solve_with_updated_contacts(prepared))
    q, reactions = prepared.body_motions_and_reactions()
    # with elastic bodies, loose motions stay fixed in the proof
    proven = system if backend is None else prepared.assembly_arrays
    prove, far = partial(status_of_runaway_assembly, proven), moved_too_far(q, proven)
    status = settle.status_of_solve(outcome, prepared.round_off_residual(), prove, far)
    if outcome.status in settle.NO_LOADS:
        return result_without_equilibrium(status)
    report = settle.solver_report(outcome, prepared, system.structure.nodes.size - 1, (start, ready), notes)
    result = summary.result_of_solved_assembly(prepared, q, reactions, status, report)
    fixed = f"{loose.description}: fixed at its initial position, as no load drives and nothing resists it"
    return replace(
        result,
        model=name,
        assumed=(*assumed, *result.assumed),
        left_out=(
            *((HEAT,) if assembly.thermal_strain else ()),
            *((fixed,) if loose.description else ()),
            *(() if backend is None else describe_rigid_rings(assembly)),
        ),
    )


def solve_assembly_with_elastic_bodies(
    assembly: Assembly, *, member: int = 0, backend: ComplianceModel = REFINED, name: str = "refined"
) -> AxisResult:
    """Compute contact forces, stiffness and motions of an assembly with elastic bodies.

    If all bearings are roller bearings, only the shaft's beam and the line contacts are elastic; the model lin is solved.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    member
        Number of the specimen: each number gives other random errors.
    backend
        Method by which the compliance of screws, nuts and balls is computed.
    name
        Name of the model in the result.

    Raises
    ------
    ValueError
        If an inner ring sits on a housing that stands on springs, there are more than `LARGEST` balls and rollers, or a
        body has impossible dimensions.
    """
    if not assembly.ball_count:
        result = solve_assembly(assembly, member=member)
        return replace(result, model=name, left_out=(*result.left_out, *describe_rigid_rings(assembly)))
    return solve_assembly_by_model(assembly, backend, name, member)


@lru_cache(maxsize=4)
@cached_on_disk(PreloadShifts)
def _preload_shifts(bare: Assembly, backend: ComplianceModel | None, name: str, member: int) -> PreloadShifts:
    """Return the shifts that preload an assembly without loads, from memory or disk, as all its load cases share them."""
    return find_axial_preload_shifts(bare, partial(solve_assembly_by_model, backend=backend, name=name, member=member))


def describe_rigid_rings(assembly: Assembly) -> tuple[str, ...]:
    """Return a sentence for each roller bearing and each inner ring on a housing; the model takes their rings as rigid."""
    rollers = tuple(f"{s.name}: {RIGID_RINGS}" for s in assembly.sets if isinstance(s.parts, RollerRow))
    return rollers + tuple(f"{s.name}: {RIGID_INNER}" for s in assembly.sets if s.carrier is not None)
