"""The 3D reference against stored results of another program: contact by contact, each at its meshes, with both errors.

The other program's loads are extrapolated to elements of no size and to rigid contact, with their uncertainty.

Elements of a deck are h at the contacts and grow by g per distance d from them. With c the length over which the field of
a contact changes, their size over the distance in which the field changes there is (h + g d) / (c + d), and the energy
of the field, F^2 / (c + d)^2 per distance, is spread evenly over x = c / (c + d). An error of order p of the elements'
relative size thus changes a load in proportion to

    e = int_0^1 (x h / c + (1 - x) g)^p dx,

and the compliance 1 / k of the contact law to first order (an overclosure in series with the contact's own approach):

    F = F0 + A e + B / k,  c = lambda b,  b the short half axis of the contact's own load.

B is taken from pairs of runs that differ in k alone, where nothing else scatters. A and F0 are each contact's own; lambda
and p are common to all contacts of a scene and fitted to all meshes. Where h and g are refined together, h = s h1 and
g = s g1, e is s^p times a constant, and lambda is without effect: then the fit is the usual one by s, with a free order.

What the law leaves out, and by how much meshes of one size differ by chance, shrinks with the elements' error. So the
residual of every mesh counts over its e (of order 3), as in weighted fits of grid convergence (Eca and Hoekstra, J.
Comput. Phys. 262, 2014): coarse meshes help to find the order, fine ones set the limit.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations, product
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.reference.estimate import Reference
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Cell, Quantity

T = TypeVar("T")


@dataclass(frozen=True)
class BodyMesh:
    """Mesh of one body: name, nodes, cells, smallest scaled Jacobian."""

    name: str
    nodes: int
    cells: int
    smallest: float


@dataclass(frozen=True)
class CrossRun:
    """One run: choices of the deck (elements across the short half axis at mean load, growth, pressure per overclosure
    [Pa/m], weak springs [N/m], large displacements), element size at the contacts [m], digest of the deck, meshes; contact
    loads ``(n, 4)`` [N]; largest force of a weak spring on a ball [N], largest unbalanced force of a ball beyond it [N];
    iterations, last correction of the displacements [%], seconds of processor time, date, program; whether only the half at
    y >= 0 was meshed (meshes count its nodes, loads are of the whole), and whether balls have one mesh."""

    b_over_h: float
    growth: float
    stiffness: float
    spring: float
    nlgeom: bool
    fine: float
    deck: str
    meshes: tuple[BodyMesh, ...]
    load: Array
    weak: float
    unbalanced: float
    iterations: int
    correction: float
    seconds: float
    date: str
    program: str
    half: bool = False
    alike: bool = False

    @property
    def nodes(self) -> int:
        """Nodes of all bodies."""
        return sum(m.nodes for m in self.meshes)


@dataclass(frozen=True)
class CrossData:
    """All runs of one scene; key of the scene's content; version of rollbench and of gmsh that made the meshes."""

    scene: str
    key: str
    rollbench: str
    gmsh: str
    runs: tuple[CrossRun, ...]


def shipped() -> Path:
    """Folder of the results that come with the package."""
    return Path(__file__).parent


def path_of(folder: Path, scene: str) -> Path:
    """File of a scene's results."""
    return folder / f"{scene}.json"


def save(folder: Path, data: CrossData) -> Path:
    """Write a scene's results whole or not at all. Raises InputError where that fails."""
    plain = asdict(data)
    for run in plain["runs"]:
        run["load"] = [[float(f"{x:.7g}") for x in row] for row in run["load"].tolist()]
    path = path_of(folder, data.scene)
    replace_file(path, json.dumps(plain, indent=1) + "\n")
    return path


def load(folder: Path, scene: str) -> CrossData | None:
    """Results of a scene, None where there are none. Raises InputError for a damaged file."""
    found = "results that rollbench crosscheck wrote", "make them again: `run=True`"
    return read(path_of(folder, scene), lambda x: CrossData(**{**x, "runs": tuple(_run(r) for r in x["runs"])}), *found)


def read(path: Path, made: Callable[[dict[str, Any]], T], allowed: str, advice: str) -> T | None:
    """What is made of a stored JSON value, None without a file. Raises InputError for a damaged one."""
    try:
        return made(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(str(path), "file", str(error), allowed, advice) from None


def _run(plain: dict[str, Any]) -> CrossRun:
    load = np.array(plain["load"], dtype=float)
    if load.ndim != 2 or load.shape[1] != len(SIDES):
        raise ValueError(f"loads of shape {load.shape}")
    return CrossRun(**{**plain, "load": load, "meshes": tuple(BodyMesh(**m) for m in plain["meshes"])})


#: Orders tried: second-order elements have 4 where the field is smooth and 3 at the rim of a contact, whose pressure falls
#: like a root; coarse ones may show as little as first-order elements have, 2.
ORDERS = tuple(np.arange(2.0, 4.01, 0.125).tolist())

#: Lengths tried, over the short half axis: up to the long one of a slender ellipse.
LENGTHS = tuple(np.geomspace(0.5, 6.0, 26).tolist())

#: Order and length of the weights.
WEIGHING = (3.0, 1.7)

#: Misfits of this share of the largest load are none.
EXACT = 1e-9

#: Standard errors of a limit that its uncertainty covers; share of what is extrapolated beyond the finest mesh that it has
#: at least.
COVERED, LEAST = 2.0, 0.1


@dataclass(frozen=True)
class Extrapolation:
    """Loads ``(n, 4)`` [N] extrapolated, their uncertainty ``(n, 4)`` [N], order p and length lambda, RMS misfit as at the
    finest mesh [N], and what elements and contact law add to the limit in the run nearest to it ``(n, 4)`` [N]; choices
    that no run varies."""

    load: Array
    uncertainty: Array
    order: float
    length: float
    misfit: float
    by_elements: Array
    by_stiffness: Array
    fixed: tuple[str, ...]


def element_error(size: Array, growth: Array, order: float) -> Array:
    """e of the module's head for sizes h / c and growths, by Gauss' rule.

    >>> element_error(np.array([1.0, 0.0]), np.array([0.0, 0.5]), 2.0).round(6).tolist()
    [0.333333, 0.083333]
    """
    x, w = np.polynomial.legendre.leggauss(8)
    at = 0.5 * (x + 1.0)
    return np.asarray((np.multiply.outer(size, at) + np.multiply.outer(growth, 1.0 - at)) ** order @ (0.5 * w))


def softness(runs: Sequence[CrossRun]) -> Array | None:
    """B ``(contacts,)`` [N Pa/m] of the contact law: mean over pairs of runs on one mesh, None without such a pair."""
    pairs = [(a, b) for a, b in combinations(runs, 2) if mesh_of(a) == mesh_of(b) and a.stiffness != b.stiffness]
    if not pairs:
        return None
    return np.asarray(
        np.mean([(a.load - b.load).ravel() / (1.0 / a.stiffness - 1.0 / b.stiffness) for a, b in pairs], axis=0)
    )


def mesh_of(run: CrossRun) -> tuple[float, float, bool, bool]:
    """Identity of a run's mesh: elements across, growth, half, equal balls."""
    return run.b_over_h, run.growth, run.half, run.alike


def extrapolate(runs: Sequence[CrossRun]) -> Extrapolation:
    """Limit of the runs with small displacements.

    The uncertainty of a contact is the largest change of its limit over all pairs of order and length whose sum of squares
    there is within two standard deviations of the best pair's (four times the variance of a residual, its own or of all
    contacts, whichever is larger), joined by root of squares with two standard errors of the limit, of its own
    residuals or of all contacts', whichever are larger, and with a tenth of what lies between the finest mesh and the
    limit. Where two meshes are all, every pair fits and the uncertainty is the whole range of limits. Raises ValueError
    with one mesh only, and where the contact stiffness varies, but on no mesh.
    """
    linear = [r for r in runs if not r.nlgeom]
    law = softness(linear)
    if law is None and len({r.stiffness for r in linear}) > 1:
        raise ValueError("the contact stiffness varies, but on no mesh: add a run that differs in it alone")
    law = np.zeros(linear[0].load.size) if law is None else law
    groups: dict[tuple[float, float, bool, bool], list[CrossRun]] = {}
    for r in linear:
        groups.setdefault(mesh_of(r), []).append(r)
    if len({m[:2] for m in groups}) < 2:
        raise ValueError("one mesh only: two are needed to extrapolate")
    h, g = (np.array([x[k] for x in groups]) for k in (0, 1))
    h = 1.0 / h
    loads = np.stack([np.mean([r.load.ravel() - law / r.stiffness for r in same], axis=0) for same in groups.values()])
    typical = loads.mean(axis=0)
    half = np.cbrt(np.maximum(typical / typical[typical > 0.0].mean(), 1e-3))  # own half axis over that at mean load
    weight = 1.0 / _errors(h, g, half, *WEIGHING)
    weight = weight / weight.max(axis=0)
    fits = [_fit(loads, _errors(h, g, half, p, s), weight, p, s) for p, s in product(ORDERS, LENGTHS)]
    best = min(fits, key=lambda fit: fit.misfit)
    free = max(1, len(loads) - 2)
    enough = np.hypot(best.residual, COVERED * np.maximum(best.residual, best.misfit) / np.sqrt(free))
    enough = enough + EXACT * float(np.abs(loads).max())
    change = np.abs(np.stack([f.limit for f in fits]) - best.limit)
    spread = np.where(np.stack([f.residual for f in fits]) <= enough, change, 0.0).max(axis=0)
    near = int(np.argmin(np.abs(best.elements).sum(axis=1)))
    stiff = max(r.stiffness for r in list(groups.values())[near])
    shape = linear[0].load.shape
    varied = (("element size", h), ("growth", g), ("contact stiffness", law))
    return Extrapolation(
        best.limit.reshape(shape),
        np.sqrt(spread**2 + (COVERED * best.error) ** 2 + (LEAST * best.elements[near]) ** 2).reshape(shape),
        best.order,
        best.length,
        best.misfit,
        best.elements[near].reshape(shape),
        (law / stiff).reshape(shape),
        tuple(name for name, x in varied if np.ptp(x) == 0.0),
    )


def _errors(h: Array, g: Array, half: Array, order: float, length: float) -> Array:
    """e of every mesh and contact ``(meshes, contacts)``."""
    size = h[:, None] / (length * half)
    return element_error(size, np.broadcast_to(g[:, None], size.shape), order)


@dataclass(frozen=True)
class _Fit:
    """Weighted least squares with one order and length: RMS misfit of all contacts and of each ``(contacts,)``; limit and
    its standard error ``(contacts,)``; what elements add ``(meshes, contacts)`` [N]."""

    order: float
    length: float
    misfit: float
    residual: Array
    limit: Array
    error: Array
    elements: Array


def _fit(loads: Array, e: Array, weight: Array, order: float, length: float) -> _Fit:
    """A straight line over e for every contact; residuals count times ``weight``, 1 for the finest mesh."""
    w = weight**2 / (weight**2).sum(axis=0)
    middle, mean = (w * e).sum(axis=0), (w * loads).sum(axis=0)
    wide = (w * (e - middle) ** 2).sum(axis=0)
    slope = (w * (e - middle) * (loads - mean)).sum(axis=0) / wide
    limit = mean - slope * middle
    square = (weight * (loads - limit - slope * e)) ** 2
    free = max(1, len(loads) - 2)
    scatter = np.sqrt(np.maximum(square.sum(axis=0), square.sum() / square.shape[1]) / free)
    # Var F0 = sigma^2 (1 + middle^2 / wide) / sum of weights squared, sigma that of the finest mesh
    error = scatter * np.sqrt((1.0 + middle**2 / wide) / (weight**2).sum(axis=0)) * (mean > 0.0)
    residual = np.sqrt(square.mean(axis=0))
    return _Fit(order, length, float(np.sqrt(square.mean())), residual, limit, error, slope * e)


#: Agreement aimed at, in per cent of the mean load.
TARGET = 0.5

PLACE = (Quantity("ball", "ball", "", "s"), Quantity("side", "side", "", "s"))

#: The comparison of a contact: the reference's finest level, the other program extrapolated.
COMPARED = (
    Quantity("ours", "reference", "N", ".2f"),
    Quantity("ours_percent", "uncertainty, reference", "% of mean", ".2f"),
    Quantity("theirs", "CalculiX", "N", ".2f"),
    Quantity("theirs_percent", "uncertainty, CalculiX", "% of mean", ".2f"),
    Quantity("difference", "difference", "% of mean", "+.2f"),
)

COLUMNS = (*PLACE, *COMPARED)


@dataclass(frozen=True)
class ContactRow:
    """One contact: ball (from 1), side, loads [N] on every mesh of the reference and of the other program by name, the
    reference's finest and the other's extrapolated, their uncertainties and differences in per cent of the
    mean load of the reference."""

    ball: int
    side: str
    meshes: Mapping[str, float]
    ours: float
    ours_percent: float
    theirs: float
    theirs_percent: float
    difference: float

    def cells(self) -> dict[str, Cell]:
        """The row of a table."""
        compared: dict[str, Cell] = {q.key: getattr(self, q.key) for q in COMPARED}
        return {"ball": str(self.ball), "side": self.side, **self.meshes, **compared}


def series(data: CrossData) -> list[CrossRun]:
    """The runs with small displacements and the contact stiffness of most, fewest nodes first."""
    linear = [r for r in data.runs if not r.nlgeom]
    alike = [sum(r.stiffness == one.stiffness for r in linear) for one in linear]
    most = linear[int(np.argmax(alike))].stiffness
    return sorted((r for r in linear if r.stiffness == most), key=lambda r: r.nodes)


def deck_label(run: CrossRun) -> str:
    """Short name of a deck in a series: elements across the short half axis, growth, half or equal balls."""
    return f"b/h {run.b_over_h:g}, g {run.growth:g}" + ", half" * run.half + ", equal balls" * run.alike


def contact_rows(data: CrossData, ours: Reference, limit: Extrapolation | None = None) -> list[ContactRow]:
    """Rows of all contacts that either program finds loaded."""
    limit = limit or extrapolate(data.runs)
    best, mean, rows = ours.load, ours.mean, []
    meshes = {f"level {r.level}": r.load for r in ours.runs} | {deck_label(r): r.load for r in series(data)}
    for i, s in zip(*np.nonzero((best > 0.0) | (limit.load > 1e-3 * mean)), strict=True):
        uncertainty = float(error_percent(ours.uncertainty[i, s], 0.0, mean))
        rows.append(
            ContactRow(
                int(i) + 1,
                SIDES[s],
                {name: float(load[i, s]) for name, load in meshes.items()},
                float(best[i, s]),
                uncertainty,
                float(limit.load[i, s]),
                float(error_percent(limit.uncertainty[i, s], 0.0, mean)),
                float(error_percent(best[i, s], limit.load[i, s], mean)),
            )
        )
    return rows


def mesh_columns(data: CrossData, ours: Reference) -> list[Quantity]:
    """Columns of the loads on every mesh of both programs."""
    return [
        *PLACE,
        *(Quantity(f"level {r.level}", f"reference, level {r.level}", "N", ".2f") for r in ours.runs),
        *(Quantity(deck_label(r), f"CalculiX, {deck_label(r)}", "N", ".2f") for r in series(data)),
    ]


def agreement(name: str, rows: Sequence[ContactRow]) -> str:
    """Sentence on the worst and RMS difference, and on whether they are more than both programs' uncertainties."""
    worst = max(rows, key=lambda r: abs(r.difference))
    rms = float(np.sqrt(np.mean([r.difference**2 for r in rows])))
    met = "within" if abs(worst.difference) <= TARGET else "NOT within"
    theirs = max(r.theirs_percent for r in rows)
    beyond = sum(abs(r.difference) > np.hypot(r.theirs_percent, r.ours_percent) for r in rows)
    return (
        f"{name}: the 3D reference differs from CalculiX by at most {worst.difference:+.2f} % of the mean load (ball "
        f"{worst.ball} {worst.side}; RMS {rms:.2f} %), {met} {TARGET} %; CalculiX's own uncertainty is up to "
        f"{theirs:.2f} %, and {beyond} of {len(rows)} contacts differ by more than both uncertainties."
    )
