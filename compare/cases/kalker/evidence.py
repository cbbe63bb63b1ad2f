"""Kalker's table of linear creep coefficients, by the 3D model of rolling on three grids."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rollbench.compare.cases.external.evidence import EXAMPLE_CELLS, example
from rollbench.compare.evidence import Findings
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry, value_of
from rollbench.compare.scenes.catalogue import case
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.rolling.cases import rolling_case
from rollbench.compare.studies.rolling.runs import LEVELS, QUADRATURES
from rollbench.hifi.rolling import verification
from rollbench.hifi.rolling.balls import NEARLY_RIGID, Choices, contact_place, solve_rolling
from rollbench.hifi.rolling.bodies import Place, Sizes
from rollbench.hifi.rolling.patch import Patch, hertz_patch
from rollbench.hifi.rolling.verification import linear_coefficients
from rollbench.meshes.arrays import Array

#: Ratios of semi-axes and Poisson's ratios; grids of each ratio, cells along and across.
GRIDS = {"0.2": ((12, 24), (16, 32), (18, 36)), "1": ((20, 20), (28, 28), (36, 36)), "5": ((60, 12), (80, 16), (100, 20))}
POISSON = ("0", "0.25", "0.5")
NAMES = ("C11", "C22", "C23", "C33")


@dataclass(frozen=True)
class Coefficient:
    """One creep coefficient on several grids."""

    #: Key of the coefficient.
    key: str
    #: Values by grid.
    values: tuple[float, ...]
    #: Extrapolated to first order in the cell size if the values converge monotonically, else that of the finest grid.
    answer: float
    #: Whether it is extrapolated.
    extrapolated: bool


@lru_cache(maxsize=1)
def coefficients() -> tuple[Coefficient, ...]:
    """Return all 36 coefficients."""
    return tuple(_solved())


def _solved() -> Iterator[Coefficient]:
    """Yield each coefficient: its values by grid, and the extrapolated one if they converge from one side."""
    for ratio, shapes in GRIDS.items():
        cells = np.array([1.0 / s[1] for s in shapes])
        for poisson in POISSON:
            found = np.array([linear_coefficients(float(ratio), float(poisson), s) for s in shapes])
            limits = np.polyfit(cells, found, 1)[1]
            for name, values, limit in zip(NAMES, found.T, limits, strict=True):
                steps = np.diff(values)
                one_side = bool(steps[0] * steps[1] > 0.0 and abs(steps[1]) < abs(steps[0]))
                answer = float(limit if one_side else values[-1])
                yield Coefficient(f"{name}_{ratio}_{poisson}", tuple(map(float, values)), answer, one_side)


def table_e3(findings: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of Kalker's coefficients for a/b of 0.2, 1, 5 and nu of 0, 0.25, 0.5."""
    for one in coefficients():
        grids = ", ".join(f"{v:.4g}" for v in one.values)
        how = "extrapolated" if one.extrapolated else "the finest grid's"
        findings.number(one.key, one.answer, f"grids {grids}; {how}")


#: Contact of the full-slip cases: load [N], relative radii [m], Young's modulus [Pa], Poisson's ratio; friction.
GROOVE, MU = (100.0, (5e-3, 46.667e-3), 210e9, 0.28), 0.1
#: Creepages of full slip: spin pole outside, near the edge, inside.
SLIPS = {"pole outside": verification.Creep(0.02, 0.004, 30.0), "pole inside": verification.Creep(0.02, 0.004, 400.0)}
#: How full slip is computed on grids: alone, with the slip resolved within cells, and as runs have it.
BY_GRID, RESOLVED, AS_RUNS = "on a grid alone", "on a grid, slip resolved within cells", "as runs have it, worst level"
#: What full slip is compared by.
WRENCH = ("force [N]", "moment [N mm]")
#: Errors [%] to reach: Carter, Cattaneo-Mindlin, full slip, Kalker's table.
REACH = (0.5, 0.5, 0.1, 2.0)
#: Share of the largest force whose strip of stick is so narrow, 4 to 17 cells here, that its width jumps with where cells
#: lie (-1.9, 0.3, 0.8 % on 40, 80, 160 of them): errors without an order, and what is left of them to reach.
NARROW, NARROW_REACH = 0.95, 1.0
#: The same of grids alone whose spin pole lies inside a cell: what differencing against the rigid limit takes out.
ALONE = 2.0
#: Share of the compliance along tangents with which all of a contact slips as rigid bodies do.
STIFF = 1e-3
#: Cells along an axis of the finest level of runs over those of the coarsest.
FINER = LEVELS[max(LEVELS)][0] / LEVELS[min(LEVELS)][0]
#: Cells along each axis of CONTACT's example on coarser grids and as printed.
EXAMPLE_GRIDS = (22, 33, EXAMPLE_CELLS)
#: A contact at rest beside the static reference: quantities, errors to reach [%], cells of that one's zone; where.
#: What is to be reached is what that one's grid leaves open: from 6 x 6 to 10 x 10 cells its peak falls by 2.9 %, its
#: semi-axes grow by 1.4 and 1.0 % (`pytest -m survey tests/sources/kalker/literature/test_rolling_at_rest.py`).
AT_REST = ("approach [um]", "semi-axis along [um]", "semi-axis across [um]", "peak pressure [MPa]")
STATIC_REACH, STATIC_CELLS = (0.5, 1.5, 2.0, 2.5), (10, 10)
SCREW, LINEAR = "lin-screw-pair-a-inferred", "lin-pair-a"
#: Error [%] of the cells of a contact zone on their own: the same in a body and in the half space beside it.
ELEMENTS_REACH = 2.0
#: Error [%] of taking a point for the contact of two balls; on finite ones, it lies half an approach inside their surfaces.
RUB_REACH = 0.01


@dataclass(frozen=True)
class Proof:
    """A test against a known answer: values on three grids, exact or printed value, target for the error [%].

    ``answer`` is the value of the finest grid unless stated otherwise. ``finer`` is the number of cells along an axis
    of the finest grid over that of the coarsest (None: the grids' errors have no order).
    """

    case: str
    quantity: str
    values: tuple[float, ...]
    exact: float
    reach: float
    answer: float
    finer: float | None = 2.0

    @property
    def error(self) -> float:
        """Error of the answer [%]."""
        return float(error_percent(self.answer, self.exact))

    @property
    def reached(self) -> bool:
        """Whether the error of the answer is within its target."""
        return abs(self.error) <= self.reach

    @property
    def order(self) -> float | None:
        """Observed order of the errors from the coarsest grid to the finest.

        None if the last error is round-off, or if an error does not fall from grid to grid: it then depends on where
        cells lie.
        """
        errors = np.abs(np.array(self.values) - self.exact)
        if self.finer is None or not errors[-1] > 1e-12 * abs(self.exact) or (np.diff(errors) >= 0.0).any():
            return None
        return float(np.log(errors[0] / errors[-1]) / np.log(self.finer))


@lru_cache(maxsize=2)
def proofs(*, meshing: bool = True) -> tuple[Proof, ...]:
    """Return all tests against known answers; without ``meshing``, without those that need gmsh."""
    parts = (_elements, _carter, _mindlin, _full_slip, _rubbing, _kalker, _contact)
    return tuple(proof for proof_of in ((_at_rest,) if meshing else ()) + parts for proof in proof_of())


def resting(cells: tuple[int, int] = STATIC_CELLS) -> tuple[float, ...]:
    """Return `AT_REST` of the most loaded contact of two balls of a screw; cells: grid of the static reference."""
    at, load, material = _most_loaded()
    return _read(verification.solve_by_static_reference(at, load, *material, cells))


def _most_loaded() -> tuple[Place, float, tuple[float, float]]:
    """Return place, load [N] and elastic constants of the most loaded contact of a screw's two balls."""
    scene = rolling_case(case(SCREW, KindScene), Choices(LEVELS[1])).touching
    touch = max((t for b in scene.balls for t in b.touches), key=lambda t: t.load)
    return contact_place(scene, touch)[0], touch.load, (scene.young, scene.poisson)


def _at_rest() -> Iterator[Proof]:
    """Yield the tests of a contact at rest against the static reference's patch."""
    at, load, material = _most_loaded()
    exact = resting()
    found = [
        _read(verification.solve_normal_contact_at_rest(at, load, *material, shape, Sizes())) for shape in LEVELS.values()
    ]
    for k, (name, reach) in enumerate(zip(AT_REST, STATIC_REACH, strict=True)):
        values = tuple(one[k] for one in found)
        yield Proof("no motion: the static reference's patch", name, values, exact[k], reach, values[-1], FINER)


def _read(one: verification.NormalContact) -> tuple[float, ...]:
    """Return approach [um], semi-axes [um] and peak pressure [MPa] of a pressed contact."""
    return 1e6 * one.approach, 1e6 * one.semi[0], 1e6 * one.semi[1], 1e-6 * one.peak


def _elements() -> Iterator[Proof]:
    """Yield the tests of finite elements under uniform traction against the half space."""
    load, radii, young, poisson = GROOVE
    at = Place(radii[0], radii, 0.25 * np.pi, None)
    zones = (at.zone(load, young, poisson, replace(Sizes(), cells=(n, n))) for n in (2, 3, 4))
    found = [verification.compare_half_space_displacements(zone, at.ball, young, poisson) for zone in zones]
    for k, name in enumerate(("along", "across", "normal")):
        values = tuple(1e9 * float(f[0][k]) for f in found)
        exact, quantity = 1e9 * float(found[-1][1][k]), f"compliance, {name} [nm/N]"
        yield Proof("half space of finite elements, uniform traction", quantity, values, exact, ELEMENTS_REACH, values[-1])


def _rubbing() -> Iterator[Proof]:
    """Yield the tests of friction between two balls over a patch against friction at one point."""
    choices = Choices((12, 16))
    scene = rolling_case(case(LINEAR, KindScene), choices).touching
    found = solve_rolling(scene, choices)
    for where, bodies, grids in (("Hertz's circle", None, (20, 30, 40)), ("the balls' own patch", Sizes(), (8, 12, 16))):
        shares = [verification.compare_ball_friction_with_point(scene, found, 0, points, bodies) for points in grids]
        for k, name in enumerate(("force over that of a point", "loss over that of a point")):
            values = tuple(s[k] for s in shares)
            yield Proof(f"balls that touch, over {where}", name, values, 1.0, RUB_REACH, values[-1])


def _carter() -> Iterator[Proof]:
    """Yield the tests against Carter's solution: force, and half width of the stick zone."""
    for share in (0.1, 0.25, 0.5, 0.75, 0.9):
        found = [verification.compare_with_carter(n, share) for n in (41, 61, 82)]
        for k, name in enumerate(("force over mu P", "half width of stick over a")):
            values = tuple(float(f[0][k]) for f in found)
            yield Proof(f"Carter, Q = {share:g} mu P", name, values, float(found[-1][1][k]), REACH[0], values[-1])
    found = [verification.compare_with_carter(n, NARROW) for n in (40, 80, 160)]
    for k, name in enumerate(("force over mu P", "half width of stick over a")):
        values, exact = tuple(float(f[0][k]) for f in found), float(found[-1][1][k])
        name += " (stick of a few cells: no order)"
        yield Proof(f"Carter, Q = {NARROW:g} mu P", name, values, exact, NARROW_REACH, values[-1], None)


def _mindlin() -> Iterator[Proof]:
    """Yield the tests against Cattaneo and Mindlin: force and stick radius, on half spaces and finite balls."""
    for balls, what in ((None, "Cattaneo-Mindlin"), (Sizes(), "Cattaneo-Mindlin on two finite balls")):
        for share in (0.25, 0.5, 0.75):
            found = [verification.compare_with_mindlin(n, share, balls=balls) for n in (14, 20, 28)]
            for k, name in enumerate(("force over mu P", "stick radius over a")):
                values = tuple(float(f[0][k]) for f in found)
                yield Proof(f"{what}, Q = {share:g} mu P", name, values, float(found[-1][1][k]), REACH[1], values[-1])


def _full_slip() -> Iterator[Proof]:
    """Yield the tests under full slip: by quadrature, by the grid, and by differences as runs are evaluated."""
    for where, creep in SLIPS.items():
        exact = _wrench(*verification.full_slip_by_quadrature(*GROOVE, creep, MU, 1200))
        patches = [hertz_patch(*GROOVE, (n, n)) for n in (16, 24, 32)]
        ways = {
            "by quadrature": [
                _wrench(*verification.full_slip_by_quadrature(*GROOVE, creep, MU, n)) for n in (150, 225, 300)
            ],
            BY_GRID: [_stiff(p, creep, STIFF) for p in patches],
        }
        if "inside" in where:
            ways[RESOLVED] = [_wrench(*verification.full_slip_within_cells(p, creep, MU)) for p in patches]
        for way, found in ways.items():
            reach = ALONE if way == BY_GRID and "inside" in where else REACH[2]
            for name, values, known in zip(WRENCH, zip(*found, strict=True), exact, strict=True):
                yield Proof(f"full slip {way}, {where}", name, values, known, reach, values[-1])
        limits = [_wrench(*verification.full_slip_by_quadrature(*GROOVE, creep, MU, n)) for n in QUADRATURES]
        found = [_differenced(hertz_patch(*GROOVE, shape), creep, limits) for shape in LEVELS.values()]
        for name, values, known in zip(WRENCH, zip(*found, strict=True), exact, strict=True):
            worst = values[int(np.argmax(np.abs(np.array(values) - known)))]
            yield Proof(f"full slip {AS_RUNS}, {where}", name, values, known, REACH[2], worst, None)


def _wrench(force: Array, moment: float) -> tuple[float, float]:
    """Return a tangential force [N] and a moment [N mm] from a force vector [N] and a moment [N m]."""
    return float(force[0]), 1e3 * moment


def _stiff(patch: Patch, creep: verification.Creep, share: float) -> tuple[float, float]:
    """Return force [N] and moment [N mm] of steady rolling with the elastic response scaled by ``share``."""
    found = verification.solve_steady_rolling(patch, creep, MU, elastic=share)
    return _wrench(found.force, found.moment)


def _differenced(patch: Patch, creep: verification.Creep, limits: list[tuple[float, float]]) -> tuple[float, float]:
    """Return force and moment evaluated like runs: elastic less nearly rigid on a grid, plus the mean rigid limit."""
    limit, elastic, near = np.mean(limits, axis=0), _stiff(patch, creep, STIFF), _stiff(patch, creep, STIFF * NEARLY_RIGID)
    force, moment = limit + np.subtract(elastic, near)
    return float(force), float(moment)


def _kalker() -> Iterator[Proof]:
    """Yield the tests against Kalker's printed creep coefficients."""
    for one in coefficients():
        name, ratio, poisson = one.key.split("_")
        value = value_of("kalker-E3", one.key)
        yield Proof(
            f"Kalker, a/b = {ratio}, nu = {poisson}",
            name,
            one.values,
            value,
            REACH[3],
            one.answer,
            GRIDS[ratio][-1][1] / GRIDS[ratio][0][1],
        )


def _contact() -> Iterator[Proof]:
    """Yield the tests against CONTACT's printed example.

    With CONTACT's difference scheme the target is the printed digits. With the scheme used here it is the first-order
    error of CONTACT's scheme, estimated by the change from its coarsest grid to its finest.
    """
    theirs = [example(n, by_cells=True) for n in EXAMPLE_GRIDS]
    ours = [example(n) for n in (16, 24, 32)]
    for key, name in (("lateral", "lateral force over mu P"), ("moment", "moment [N mm]")):
        printed = entry("external-contact", key)
        assert printed.value is not None
        values = tuple(getattr(v, key) for v in theirs)
        digits = 100.0 * printed.tolerance / abs(printed.value)
        yield Proof("CONTACT's example, discretised as there", name, values, printed.value, digits, values[-1], None)
        reach = abs(float(error_percent(values[0], values[-1])))
        values = tuple(getattr(v, key) for v in ours)
        yield Proof("CONTACT's example", name, values, printed.value, reach, values[-1])
