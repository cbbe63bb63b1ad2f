"""Verification of the 3D model of rolling contact by Kalker's creep coefficients and other known solutions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from rollbench.compare.cases.external.evidence import EXAMPLE_CELLS, lateral_force_and_moment
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_entry, printed_value
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling.cases import prepare_rolling_case
from rollbench.compare.studies.rolling.runs import LEVELS, QUADRATURES
from rollbench.hifi.rolling import verification
from rollbench.hifi.rolling.balls import NEARLY_RIGID, RollingSettings, position_of_contact_on_groove, solve_rolling
from rollbench.hifi.rolling.bodies import ContactGeometry, Sizes
from rollbench.hifi.rolling.patch import GridContact, solve_elastic_contact_on_grid
from rollbench.hifi.rolling.verification import kalker_linear_coefficients
from rollbench.meshes.arrays import Array

#: Grids for each ratio a/b of the semi-axes: cells along and across the rolling direction; then Poisson's ratios.
GRIDS = {"0.2": ((12, 24), (16, 32), (18, 36)), "1": ((20, 20), (28, 28), (36, 36)), "5": ((60, 12), (80, 16), (100, 20))}
POISSON = ("0", "0.25", "0.5")
NAMES = ("C11", "C22", "C23", "C33")


@dataclass(frozen=True)
class CreepCoefficient:
    """One of Kalker's linear creep coefficients, computed on several grids of cells over the contact ellipse."""

    #: Key of the coefficient in Kalker's table, such as ``C11_0.2_0.25``: name, ratio a/b of semi-axes, Poisson's ratio.
    key: str
    #: Values of the coefficient on the grids, from coarse to fine.
    values_by_grid: tuple[float, ...]
    #: Value extrapolated to zero cell size (first order) if the values converge monotonically, else value on the finest
    #: grid.
    best_value: float
    #: Whether ``best_value`` is extrapolated.
    is_extrapolated: bool


@lru_cache(maxsize=1)
def kalker_creep_coefficients() -> tuple[CreepCoefficient, ...]:
    """Return the 36 creep coefficients of Kalker's Table E3: four for each of nine contacts.

    Each contact has one of three ratios of the semi-axes and one of three Poisson's ratios.
    """
    return tuple(_compute_creep_coefficients())


def _compute_creep_coefficients() -> Iterator[CreepCoefficient]:
    """Compute each creep coefficient on three grids, and extrapolate it to zero cell size if it converges monotonically."""
    for ratio, shapes in GRIDS.items():
        cells = np.array([1.0 / s[1] for s in shapes])
        for poisson in POISSON:
            found = np.array([kalker_linear_coefficients(float(ratio), float(poisson), s) for s in shapes])
            limits = np.polyfit(cells, found, 1)[1]
            for name, values, limit in zip(NAMES, found.T, limits, strict=True):
                steps = np.diff(values)
                one_side = bool(steps[0] * steps[1] > 0.0 and abs(steps[1]) < abs(steps[0]))
                answer = float(limit if one_side else values[-1])
                yield CreepCoefficient(f"{name}_{ratio}_{poisson}", tuple(map(float, values)), answer, one_side)


def table_e3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the creep coefficients of Kalker's Table E3, for semi-axes ratios of 0.2, 1 and 5 and three Poisson's ratios.

    Poisson's ratios are 0, 0.25 and 0.5. ``findings``: receives each computed coefficient to compare with the printed one,
    with its values on several grids as a remark. ``cache``: not used here.
    """
    for one in kalker_creep_coefficients():
        grids = ", ".join(f"{v:.4g}" for v in one.values_by_grid)
        how = "extrapolated" if one.is_extrapolated else "the finest grid's"
        findings.add_number(one.key, one.best_value, f"grids {grids}; {how}")


#: Contact in full slip: load [N], relative radii [m], Young's modulus [Pa], Poisson's ratio; friction coefficient.
GROOVE, MU = (100.0, (5e-3, 46.667e-3), 210e9, 0.28), 0.1
#: Creepages (along, across, spin [1/m]) of full slip. The spin pole, where slip is zero, lies outside or inside the contact
#: ellipse.
SLIPS = {"pole outside": verification.Creep(0.02, 0.004, 30.0), "pole inside": verification.Creep(0.02, 0.004, 400.0)}
#: How full slip is computed on a grid: one slip per cell, slip resolved within cells, differences as in stored 3D results.
BY_GRID, RESOLVED, AS_RUNS = (
    "on a grid alone",
    "on a grid, slip resolved within cells",
    "corrected as stored results are, worst grid",
)
#: Friction force and moment by which full slip is compared, with units.
WRENCH = ("force [N]", "moment [N mm]")
#: Permitted errors [%] against Carter, Cattaneo and Mindlin, full slip by quadrature, and Kalker's table.
REACH = (0.5, 0.5, 0.1, 2.0)
#: Fraction of mu P at which Carter's stick zone is only 4 to 17 cells wide, so that its computed width depends on where
#: cell boundaries lie (errors of -1.9, 0.3, 0.8 % on 40, 80, 160 cells, without an order of convergence), and its permitted
#: error [%].
NARROW, NARROW_REACH = 0.95, 1.0
#: Permitted error [%] on a grid if the spin pole lies inside a cell, before the correction by the rigid limit.
ALONE = 2.0
#: Factor on the tangential compliance at which the whole contact slips, as between rigid bodies.
STIFF = 1e-3
#: Number of cells along an axis on the finest grid of the stored 3D results, divided by their number on the coarsest.
FINER = LEVELS[max(LEVELS)][0] / LEVELS[min(LEVELS)][0]
#: Cells along each axis of CONTACT's example: two coarser grids, and the printed one.
EXAMPLE_GRIDS = (22, 33, EXAMPLE_CELLS)
#: A contact at rest, compared with the static 3D reference: quantities, permitted errors [%], cells of the reference's
#: contact zone, scene. The permitted errors are the reference's own grid errors: from 6 x 6 to 10 x 10 cells its peak
#: pressure falls by 2.9 %, its semi-axes grow by 1.4 and 1.0 %
#: (`pytest -m survey tests/sources/kalker/literature/test_rolling_at_rest.py`).
AT_REST = ("approach [um]", "semi-axis along rolling [um]", "semi-axis across rolling [um]", "peak pressure [MPa]")
STATIC_REACH, STATIC_CELLS = (0.5, 1.5, 2.0, 2.5), (10, 10)
SCREW, LINEAR = "lin-screw-pair-a-inferred", "lin-pair-a"
#: Permitted error [%] of finite elements of a contact zone against the closed-form solution of the half space.
ELEMENTS_REACH = 2.0
#: Permitted error [%] of friction at one point in place of the contact ellipse of two balls that touch. Where the balls'
#: own shape counts, the point lies half the Hertz approach inside their surfaces.
RUB_REACH = 0.01


@dataclass(frozen=True)
class Verification:
    """A verification of the 3D model of rolling contact: one quantity on three grids, and its exact or printed value.

    ``contact_problem``: in words; ``quantity``: name with unit; ``values_by_grid``: value on the coarse, the middle and the
    fine grid; ``exact_value``: exact or printed value; ``permitted_error_percent``: permitted error [%] of the value that
    is compared with it; ``compared_value``: this value; None: the value on the finest grid; ``grid_refinement``: number of
    cells along an axis of the finest grid divided by the number on the coarsest grid; None if no order of convergence is
    expected.
    """

    contact_problem: str
    quantity: str
    values_by_grid: tuple[float, ...]
    exact_value: float
    permitted_error_percent: float
    compared_value: float | None = None
    grid_refinement: float | None = 2.0

    @property
    def relative_error_percent(self) -> float:
        """Error of the compared value against the exact or printed value [%]."""
        compared = self.values_by_grid[-1] if self.compared_value is None else self.compared_value
        return float(error_percent(compared, self.exact_value))

    @property
    def within_permitted_error(self) -> bool:
        """Whether the error of the compared value is within ``permitted_error_percent``."""
        return abs(self.relative_error_percent) <= self.permitted_error_percent

    @property
    def convergence_order(self) -> float | None:
        """Order of convergence observed from the coarsest grid to the finest.

        None if the error on the finest grid is round-off, or if the error does not fall with each finer grid, as happens
        where it depends on the position of the cell boundaries in the contact.
        """
        errors = np.abs(np.array(self.values_by_grid) - self.exact_value)
        if self.grid_refinement is None or not errors[-1] > 1e-12 * abs(self.exact_value) or (np.diff(errors) >= 0.0).any():
            return None
        return float(np.log(errors[0] / errors[-1]) / np.log(self.grid_refinement))


@lru_cache(maxsize=2)
def verifications_of_rolling_model(*, meshing: bool = True) -> tuple[Verification, ...]:
    """Return all verifications of the 3D model of rolling contact against known solutions.

    ``meshing``: whether to include the verification that needs the mesh generator gmsh.
    """
    parts = (
        _verify_finite_elements,
        _verify_carter,
        _verify_cattaneo_mindlin,
        _verify_full_slip,
        _verify_ball_to_ball_friction,
        _verify_creep_coefficients,
        _verify_example_of_program_contact,
    )
    return tuple(proof for proof_of in ((_verify_contact_at_rest,) if meshing else ()) + parts for proof in proof_of())


def most_loaded_contact_by_3d_reference(cells: tuple[int, int] = STATIC_CELLS) -> tuple[float, ...]:
    """Return approach, semi-axes and peak pressure of a screw's most loaded contact by the static 3D reference.

    In this order: approach [um], semi-axes along and across the rolling direction [um], peak pressure [MPa]. ``cells``:
    numbers of cells of the contact zone along and across the rolling direction.
    """
    at, load, material = _most_loaded_contact()
    return _approach_semi_axes_and_peak(verification.solve_normal_contact_by_patches(at, load, *material, cells))


def _most_loaded_contact() -> tuple[ContactGeometry, float, tuple[float, float]]:
    """Return the contact with the largest load of all ball-to-groove contacts of two touching balls of a ball screw.

    First: its geometry at its position on the groove; second: its load [N]; third: Young's modulus [Pa] and Poisson's
    ratio.
    """
    scene = prepare_rolling_case(shipped_scene_of_kind(SCREW, FrictionScene), RollingSettings(LEVELS[1])).touching
    touch = max((t for b in scene.balls for t in b.groove_contacts), key=lambda t: t.contact_force)
    return position_of_contact_on_groove(scene, touch)[0], touch.contact_force, (scene.young, scene.poisson)


def _verify_contact_at_rest() -> Iterator[Verification]:
    """Verify approach, semi-axes and peak pressure of a contact at rest against the static 3D reference."""
    at, load, material = _most_loaded_contact()
    exact = most_loaded_contact_by_3d_reference()
    solve = verification.solve_normal_contact_by_rolling_model
    found = [_approach_semi_axes_and_peak(solve(at, load, *material, shape, Sizes())) for shape in LEVELS.values()]
    words = "contact at rest, against the static 3D reference"
    yield from _verify_each(words, AT_REST, found, exact, STATIC_REACH, grid_refinement=FINER)


def _verify_each(
    problem: str,
    names: Sequence[str],
    found: Sequence[Any],
    exact: Any,
    permitted_percent: float | Sequence[float],
    **others: Any,
) -> Iterator[Verification]:
    """Yield the verification of each quantity of a contact problem.

    ``names``: the k quantities; ``found``: k values or more on each of three grids, of which the first k are theirs;
    ``exact``: exact values, likewise; ``permitted_percent``: permitted error [%], for all or each of them; ``others``:
    further fields of `Verification`.
    """
    reaches = np.broadcast_to(permitted_percent, len(names))
    for name, values, known, reach in zip(names, zip(*found, strict=True), exact, reaches, strict=False):
        yield Verification(problem, name, tuple(map(float, values)), float(known), float(reach), **others)


def _approach_semi_axes_and_peak(contact: verification.NormalContact) -> tuple[float, ...]:
    """Return approach [um], semi-axes [um] along and across the rolling direction, peak pressure [MPa] of a contact."""
    return 1e6 * contact.approach, 1e6 * contact.semi_axes[0], 1e6 * contact.semi_axes[1], 1e-6 * contact.peak_pressure


def _verify_finite_elements() -> Iterator[Verification]:
    """Verify displacements of a half space of finite elements against the closed-form solution.

    A uniform traction acts on a rectangle of the surface; the mean displacements of this rectangle are compared.
    """
    load, radii, young, poisson = GROOVE
    at = ContactGeometry(radii[0], radii, 0.25 * np.pi, None)
    zones = (at.contact_zone(load, young, poisson, replace(Sizes(), cells=(n, n))) for n in (2, 3, 4))
    found = [verification.compare_half_space_displacements(zone, at.ball_radius, young, poisson) for zone in zones]
    names = [f"{name} displacement by a force [nm/N]" for name in ("longitudinal", "lateral", "normal")]
    in_nm = [1e9 * np.asarray(f[0]) for f in found]
    words = "half space of finite elements, uniform traction"
    yield from _verify_each(words, names, in_nm, 1e9 * np.asarray(found[-1][1]), ELEMENTS_REACH)


def _verify_ball_to_ball_friction() -> Iterator[Verification]:
    """Verify friction force and loss over the contact patch of two balls against friction at one point."""
    choices = RollingSettings((12, 16))
    scene = prepare_rolling_case(shipped_scene_of_kind(LINEAR, FrictionScene), choices).touching
    found = solve_rolling(scene, choices)
    for where, bodies, grids in (("Hertz's circle", None, (20, 30, 40)), ("the balls' own patch", Sizes(), (8, 12, 16))):
        shares = [verification.compare_ball_friction_with_point(scene, found, 0, points, bodies) for points in grids]
        names = ("force over that of point contact", "loss over that of point contact")
        yield from _verify_each(f"balls that touch, friction over {where}", names, shares, (1.0, 1.0), RUB_REACH)


def _verify_carter() -> Iterator[Verification]:
    """Verify tangential force and half width of the stick zone against Carter's solution."""
    names = ("force over mu P", "half width of the stick zone over a")
    for share in (0.1, 0.25, 0.5, 0.75, 0.9):
        found = [verification.compare_with_carter(n, share) for n in (41, 61, 82)]
        yield from _verify_each(f"Carter, Q = {share:g} mu P", names, [f[0] for f in found], found[-1][1], REACH[0])
    found = [verification.compare_with_carter(n, NARROW) for n in (40, 80, 160)]
    names = (f"{names[0]} (stick zone of a few cells)", f"{names[1]} (stick zone of a few cells)")
    words = f"Carter, Q = {NARROW:g} mu P"
    yield from _verify_each(words, names, [f[0] for f in found], found[-1][1], NARROW_REACH, grid_refinement=None)


def _verify_cattaneo_mindlin() -> Iterator[Verification]:
    """Verify tangential force and stick radius against Cattaneo and Mindlin, on half spaces and on finite balls."""
    for balls, what in ((None, "Cattaneo-Mindlin"), (Sizes(), "Cattaneo-Mindlin on two finite balls")):
        for share in (0.25, 0.5, 0.75):
            found = [verification.compare_with_mindlin(n, share, finite_balls=balls) for n in (14, 20, 28)]
            names, values = ("force over mu P", "stick radius over a"), [f[0] for f in found]
            yield from _verify_each(f"{what}, Q = {share:g} mu P", names, values, found[-1][1], REACH[1])


def _verify_full_slip() -> Iterator[Verification]:
    """Verify friction force and moment of a contact that slips everywhere.

    Force and moment are computed in three ways: by quadrature for rigid bodies; on a grid of cells; and, as in stored 3D
    results, as the quadrature's value plus the difference between elastic and nearly rigid bodies on the grid. The exact
    values follow from a fine quadrature.
    """

    def by_quadrature(creep: verification.Creep, points: int) -> tuple[float, float]:
        """Return friction force [N], then moment [N mm], by a quadrature of ``points`` points along an axis."""
        return _force_and_moment(*verification.friction_at_full_slip_by_quadrature(*GROOVE, creep, MU, points))

    for where, creep in SLIPS.items():
        exact = by_quadrature(creep, 1200)
        patches = [solve_elastic_contact_on_grid(*GROOVE, (n, n)) for n in (16, 24, 32)]
        ways = {
            "by quadrature": [by_quadrature(creep, n) for n in (150, 225, 300)],
            BY_GRID: [_rolling_force_and_moment(p, creep, STIFF) for p in patches],
        }
        if "inside" in where:
            resolved = (verification.friction_at_full_slip_by_cells(p, creep, MU) for p in patches)
            ways[RESOLVED] = [_force_and_moment(*friction) for friction in resolved]
        for way, found in ways.items():
            reach = ALONE if way == BY_GRID and "inside" in where else REACH[2]
            yield from _verify_each(f"full slip {way}, {where}", WRENCH, found, exact, reach)
        limits = [by_quadrature(creep, n) for n in QUADRATURES]
        grids = (solve_elastic_contact_on_grid(*GROOVE, shape) for shape in LEVELS.values())
        found = [_grid_corrected_force_and_moment(patch, creep, limits) for patch in grids]
        for name, values, known in zip(WRENCH, zip(*found, strict=True), exact, strict=True):
            worst = values[int(np.argmax(np.abs(np.array(values) - known)))]
            yield Verification(f"full slip {AS_RUNS}, {where}", name, values, known, REACH[2], worst, None)


def _force_and_moment(force: Array, moment: float) -> tuple[float, float]:
    """Return the component of a force [N] along the rolling direction, then a moment converted from [N m] to [N mm]."""
    return float(force[0]), 1e3 * moment


def _rolling_force_and_moment(
    patch: GridContact, creep: verification.Creep, compliance_factor: float
) -> tuple[float, float]:
    """Return friction force [N], then moment [N mm], in steady rolling of bodies whose tangential compliance is scaled.

    The force is the component along rolling. ``patch``: contact ellipse divided into cells; ``creep``: creepages and spin;
    ``compliance_factor``: factor on the tangential compliance (the normal contact stays unchanged).
    """
    found = verification.solve_steady_rolling_for_creepages(patch, creep, MU, elastic=compliance_factor)
    return _force_and_moment(found.friction_force, found.friction_moment)


def _grid_corrected_force_and_moment(
    patch: GridContact, creep: verification.Creep, rigid_limits: list[tuple[float, float]]
) -> tuple[float, float]:
    """Return friction force [N], then moment [N mm], of a slipping contact, corrected for the grid error.

    As in the stored 3D results, the corrected value is the value for rigid bodies by quadrature plus the difference between
    elastic and nearly rigid bodies on the same grid. ``patch``: contact ellipse divided into cells; ``creep``: creepages
    and spin; ``rigid_limits``: pairs of force [N] and moment [N mm] for rigid bodies, one pair for each of several
    quadratures; their mean is used.
    """
    elastic, near = (_rolling_force_and_moment(patch, creep, factor) for factor in (STIFF, STIFF * NEARLY_RIGID))
    limit = np.mean(rigid_limits, axis=0)
    force, moment = limit + np.subtract(elastic, near)
    return float(force), float(moment)


def _verify_creep_coefficients() -> Iterator[Verification]:
    """Yield the comparison of each computed creep coefficient with the value that Kalker printed."""
    for one in kalker_creep_coefficients():
        name, ratio, poisson = one.key.split("_")
        value, words = printed_value("kalker-E3", one.key), f"Kalker, a/b = {ratio}, nu = {poisson}"
        finer = GRIDS[ratio][-1][1] / GRIDS[ratio][0][1]
        yield Verification(words, name, one.values_by_grid, value, REACH[3], one.best_value, finer)


def _verify_example_of_program_contact() -> Iterator[Verification]:
    """Yield the comparison of lateral force and spin moment with the example printed for the program CONTACT.

    With CONTACT's difference scheme, the computed values must have the printed digits. With the scheme of this package, the
    permitted error is the first-order error of CONTACT's scheme, estimated by the change of its results from the coarsest
    grid to the finest.
    """
    theirs = [lateral_force_and_moment(n, by_contact_scheme=True) for n in EXAMPLE_GRIDS]
    ours = [lateral_force_and_moment(n) for n in (16, 24, 32)]
    for key, name in (("lateral", "lateral force over mu P"), ("moment", "moment [N mm]")):
        printed = printed_entry("external-contact", key)
        assert printed.value is not None
        values = tuple(v[key] for v in theirs)
        digits = 100.0 * printed.tolerance / abs(printed.value)
        words = "CONTACT's example, discretised as there"
        yield Verification(words, name, values, printed.value, digits, grid_refinement=None)
        reach = abs(float(error_percent(values[0], values[-1])))
        values = tuple(v[key] for v in ours)
        yield Verification("CONTACT's example", name, values, printed.value, reach)
