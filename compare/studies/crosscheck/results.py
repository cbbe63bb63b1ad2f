"""Stored contact loads by CalculiX, compared with the 3D reference contact by contact, with both uncertainties.

CalculiX's loads are extrapolated to zero element size and infinite contact (penalty) stiffness, with their uncertainty.

Elements of a deck have size h at the contacts and grow by g per distance d from them. With c the length over which the
elastic field of a contact changes, the element size at the distance d, divided by the length over which the field changes
there, is (h + g d) / (c + d). The energy of the field, F^2 / (c + d)^2 per distance, is spread evenly over x = c / (c + d).
An error of order p of the elements' relative size thus changes a load in proportion to

    e = int_0^1 (x h / c + (1 - x) g)^p dx.

The compliance 1 / k of the contact law (an overclosure in series with the approach of the contact) changes a load F in
proportion to 1 / k, to first order:

    F = F0 + A e + B / k,  c = lambda b,  b the minor semi-axis of the contact at its load.

A, B and F0 are fitted: B from pairs of runs that differ only in k, where nothing else scatters. A and F0 differ between
contacts; lambda and p are common to all contacts of a scene and fitted to all meshes. If h and g are refined together, h =
s h1 and g = s g1, e is s^p times a constant, and lambda has no effect: then the fit is the usual one by s, with a free
order.

What the law neglects, and the random differences between meshes of one size, shrink with the elements' error. So the
residual of every mesh is divided by its e (of order 3), as in weighted fits of grid convergence (Eca and Hoekstra, J.
Comput. Phys. 262, 2014): coarse meshes help to find the order, fine ones determine the limit.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations, product
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.studies.crosscheck.deck import DeckOptions
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import ColumnKey

T = TypeVar("T")

#: Row of a table of contact loads: values by the key of the column.
Row = dict[str, Any]


@dataclass(frozen=True)
class BodyMesh:
    """Size and quality of the mesh of one body in a CalculiX deck."""

    #: Name of the body.
    name: str
    #: Number of nodes.
    nodes: int
    #: Number of finite elements.
    cells: int
    #: Smallest scaled Jacobian of the elements.
    smallest: float


@dataclass(frozen=True, kw_only=True)
class CalculixRun(DeckOptions):
    """Solution of one input deck by CalculiX: mesh, contact options and contact loads.

    Nodes of half bodies are those of this half, but contact loads are those of whole balls.
    """

    #: Element size at the contacts [m].
    fine: float
    #: Digest (hash value) of the deck's text.
    deck: str
    #: Meshes of the bodies.
    meshes: tuple[BodyMesh, ...]
    #: Contact loads of n balls on the four flanks (screw left, screw right, nut left, nut right), (n, 4) [N].
    load: Array
    #: Largest force of a weak spring on a ball [N].
    weak: float
    #: Largest unbalanced force of a ball after the force of the weak springs is deducted [N].
    unbalanced: float
    #: Number of iterations of CalculiX.
    iterations: int
    #: Last correction of the displacements in the iteration [% of the largest displacement].
    correction: float
    #: Processor time of CalculiX [s].
    seconds: float
    #: Date of the solution.
    date: str
    #: Name and version of the program, CalculiX.
    program: str

    @property
    def nodes(self) -> int:
        """Number of nodes of all bodies."""
        return sum(m.nodes for m in self.meshes)


@dataclass(frozen=True)
class CalculixRunsOfScene:
    """All stored CalculiX solutions of one scene, on several meshes."""

    #: Name of the scene.
    scene: str
    #: Digest (hash value) of the scene's content.
    key: str
    #: Version of rollbench that made the meshes.
    rollbench: str
    #: Version of gmsh that made the meshes.
    gmsh: str
    #: CalculiX solutions of the scene, one for each deck.
    runs: tuple[CalculixRun, ...]


def shipped_calculix_results_folder() -> Path:
    """Return the folder of the stored CalculiX results that are part of the package."""
    return Path(__file__).parent


def path_of_calculix_results(folder: Path, scene: str) -> Path:
    """Return the path of the JSON file with the CalculiX results of a scene.

    ``folder``: folder of stored results; ``scene``: name of the scene.
    """
    return folder / f"{scene}.json"


def save_calculix_results(folder: Path, data: CalculixRunsOfScene) -> Path:
    """Write the CalculiX results of a scene to a folder; return the path of the file.

    The file is written completely or not at all. Raises InputError if that fails.
    """
    plain = asdict(data)
    for run in plain["runs"]:
        run["load"] = [[float(f"{x:.7g}") for x in row] for row in run["load"].tolist()]
    path = path_of_calculix_results(folder, data.scene)
    replace_file(path, json.dumps(plain, indent=1) + "\n")
    return path


def load_calculix_results(folder: Path, scene: str) -> CalculixRunsOfScene | None:
    """Return the stored CalculiX results of a scene from a folder; None if the folder has no such file.

    Raises InputError for a damaged file.
    """

    def build(plain: dict[str, Any]) -> CalculixRunsOfScene:
        return CalculixRunsOfScene(**{**plain, "runs": tuple(_calculix_run_from_json(r) for r in plain["runs"])})

    found = "results that rollbench crosscheck wrote", "compute the results again by `run=True`"
    return read_object_from_json(path_of_calculix_results(folder, scene), build, *found)


def read_object_from_json(path: Path, build: Callable[[dict[str, Any]], T], allowed: str, advice: str) -> T | None:
    """Return the object that a function builds from the JSON values of a file; None if there is no such file.

    ``build``: the function; ``allowed`` and ``advice``: content of a valid file, and how to get one, for the message of the
    InputError that a damaged file raises.
    """
    try:
        return build(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(str(path), "file", str(error), allowed, advice) from None


def _calculix_run_from_json(plain: dict[str, Any]) -> CalculixRun:
    """Return a CalculiX solution from its stored JSON values; raises ValueError for contact loads of a wrong shape."""
    load = np.array(plain["load"], dtype=float)
    if load.ndim != 2 or load.shape[1] != len(SIDES):
        raise ValueError(f"the contact loads have the shape {load.shape}, not (number of balls, {len(SIDES)})")
    return CalculixRun(**{**plain, "load": load, "meshes": tuple(BodyMesh(**m) for m in plain["meshes"])})


#: Orders of convergence that are tried. Second-order elements have 4 where the field is smooth, and 3 at the rim of a
#: contact, where the pressure falls like a square root; coarse meshes may show as little as 2, the order of first-order
#: elements.
ORDERS = tuple(np.arange(2.0, 4.01, 0.125).tolist())

#: Lengths c that are tried, over the minor semi-axis: up to the major semi-axis of a slender ellipse.
LENGTHS = tuple(np.geomspace(0.5, 6.0, 26).tolist())

#: Order p and length lambda with which the weights of the meshes are computed.
WEIGHING = (3.0, 1.7)

#: Misfits of a fit below this fraction of the largest load count as zero.
EXACT = 1e-9

#: Number of standard errors of a limit that its uncertainty contains, and smallest uncertainty over the extrapolated change
#: from the finest mesh to the limit.
COVERED, LEAST = 2.0, 0.1


@dataclass(frozen=True)
class LoadExtrapolation:
    """Contact loads by CalculiX, extrapolated to zero element size and infinite contact (penalty) stiffness."""

    #: Extrapolated contact loads, (n, 4) [N].
    load: Array
    #: Uncertainty of the extrapolated contact loads, (n, 4) [N].
    uncertainty: Array
    #: Order p of the discretisation error, which decreases as the element size to the power p.
    error_order: float
    #: Ratio of the length lambda, over which the elastic field of a contact changes, to the minor semi-axis of the contact.
    field_length: float
    #: RMS of the weighted residuals of the fitted contact loads [N]; weights are 1 on the finest mesh.
    misfit: float
    #: Error of every contact load by the element size, on the mesh with the smallest such errors, (n, 4) [N].
    element_size_effect: Array
    #: Error of every contact load by the finite contact (penalty) stiffness, at the largest stiffness used on that mesh,
    #: (n, 4) [N].
    contact_stiffness_effect: Array
    #: Names of those of element size, growth and contact stiffness that do not vary between the solutions, so that their
    #: effect is unknown.
    unvaried_options: tuple[str, ...]


def relative_element_error(size: Array, growth: Array, order: float) -> Array:
    """Return the relative discretisation error near a contact, e = int_0^1 (x h / c + (1 - x) g)^p dx, by Gauss' rule.

    Parameters
    ----------
    size
        Ratio h / c of the element size h at the contact to the length c over which the contact's elastic field changes.
    growth
        Increase g of the element size per unit of distance from the contact, of the same shape as ``size``.
    order
        Order p of the discretisation error.

    Examples
    --------
    >>> relative_element_error(np.array([1.0, 0.0]), np.array([0.0, 0.5]), 2.0).round(6).tolist()
    [0.333333, 0.083333]
    """
    x, w = np.polynomial.legendre.leggauss(8)
    at = 0.5 * (x + 1.0)
    return np.asarray((np.multiply.outer(size, at) + np.multiply.outer(growth, 1.0 - at)) ** order @ (0.5 * w))


def contact_compliance_factor(runs: Sequence[CalculixRun]) -> Array | None:
    """Return the coefficient B [N Pa/m] of the contact compliance 1/k in the fit F = F0 + A e + B/k of a contact load F.

    There is one value for each contact. F0 is the load for zero element size and infinite k, e the relative discretisation
    error, A the coefficient of this error, and k the contact stiffness (pressure per overclosure). B is the mean over pairs
    of solutions with the same mesh and different k; the result is None without such a pair.
    """
    factors = [
        (a.load - b.load).ravel() / (1.0 / a.stiffness - 1.0 / b.stiffness)
        for a, b in combinations(runs, 2)
        if mesh_options_of_run(a) == mesh_options_of_run(b) and a.stiffness != b.stiffness
    ]
    return np.asarray(np.mean(factors, axis=0)) if factors else None


def mesh_options_of_run(run: CalculixRun) -> tuple[float, float, bool, bool]:
    """Return those options of a CalculiX solution that determine its mesh.

    In this order: number of elements along the minor semi-axis of a contact, growth of the element size, whether only the
    half y >= 0 was meshed, and whether all balls have the same mesh.
    """
    return run.b_over_h, run.growth, run.half, run.alike


def extrapolate_calculix_loads(runs: Sequence[CalculixRun]) -> LoadExtrapolation:
    """Extrapolate the contact loads of CalculiX to zero element size and infinite contact (penalty) stiffness.

    Only runs without geometric nonlinearity are used. The loads are fitted for many combinations of the order p of the
    discretisation error and the length over which the contact's elastic field changes; the combination with the smallest
    residuals gives the extrapolated loads (limits). The uncertainty of a contact load is the root of the sum of squares of
    three contributions:

    - the largest change of the limit among all combinations that fit about as well as the best one: their sum of squared
      residuals exceeds the smallest one by at most four times the variance of a residual (that of this contact or of all
      contacts, whichever is larger);
    - two standard errors of the limit, from the residuals of this contact or of all contacts, whichever are larger;
    - a tenth of the difference between the load on the finest mesh and the limit.

    With two meshes only, every combination fits exactly, and the uncertainty covers the whole range of limits.

    Parameters
    ----------
    runs
        Solutions of one scene with several meshes and contact stiffnesses.

    Returns
    -------
    LoadExtrapolation
        Extrapolated loads with their uncertainty.

    Raises
    ------
    ValueError
        If there is only one mesh, or if the contact stiffness varies between runs but no two of them with different
        stiffness have the same mesh.
    """
    linear = [r for r in runs if not r.nlgeom]
    B = contact_compliance_factor(linear)
    if B is None and len({r.stiffness for r in linear}) > 1:
        raise ValueError(
            "the effect of contact stiffness is unknown, as no two CalculiX runs differ in the contact stiffness alone: "
            "add a run on the same mesh with another contact stiffness"
        )
    B = np.zeros(linear[0].load.size) if B is None else B
    groups: dict[tuple[float, float, bool, bool], list[CalculixRun]] = {}
    for r in linear:
        groups.setdefault(mesh_options_of_run(r), []).append(r)
    if len({m[:2] for m in groups}) < 2:
        raise ValueError(
            "the CalculiX runs have one mesh only: the extrapolation of loads to zero element size needs two or more meshes"
        )
    h, g = (np.array([x[k] for x in groups]) for k in (0, 1))
    h = 1.0 / h
    loads = np.stack([np.mean([r.load.ravel() - B / r.stiffness for r in same], axis=0) for same in groups.values()])
    typical = loads.mean(axis=0)
    semi = np.cbrt(np.maximum(typical / typical[typical > 0.0].mean(), 1e-3))  # own semi-axis over that at mean load
    weight = 1.0 / _relative_element_errors_of_contacts(h, g, semi, *WEIGHING)
    weight = weight / weight.max(axis=0)
    # weighted straight lines of the loads (m, c) over the errors of each order and length (k, m, c)
    combined = list(product(ORDERS, LENGTHS))
    errors = np.stack([_relative_element_errors_of_contacts(h, g, semi, *of) for of in combined])
    w = weight**2 / (weight**2).sum(axis=0)
    middle, mean = (w * errors).sum(axis=1, keepdims=True), (w * loads).sum(axis=0)
    wide = (w * (errors - middle) ** 2).sum(axis=1)
    slope = (w * (errors - middle) * (loads - mean)).sum(axis=1) / wide
    limits = mean - slope * middle[:, 0]
    square = (weight * (loads - limits[:, None] - slope[:, None] * errors)) ** 2
    residual, misfit = np.sqrt(square.mean(axis=1)), np.sqrt(square.mean(axis=(1, 2)))
    best = int(misfit.argmin())
    free = max(1, len(loads) - 2)
    scatter = np.sqrt(np.maximum(square[best].sum(axis=0), square[best].sum() / mean.size) / free)
    # Var F0 = sigma^2 (1 + middle^2 / wide) / sum of weights squared, sigma that of the finest mesh
    share = (1.0 + middle[best, 0] ** 2 / wide[best]) / (weight**2).sum(axis=0)
    standard_error = scatter * np.sqrt(share) * (mean > 0.0)
    enough = np.hypot(residual[best], COVERED * np.maximum(residual[best], misfit[best]) / np.sqrt(free))
    enough = enough + EXACT * float(np.abs(loads).max())
    spread = np.where(residual <= enough, np.abs(limits - limits[best]), 0.0).max(axis=0)
    effects = slope[best] * errors[best]
    near = int(np.argmin(np.abs(effects).sum(axis=1)))
    stiff = max(r.stiffness for r in list(groups.values())[near])
    shape = linear[0].load.shape
    uncertainty = np.sqrt(spread**2 + (COVERED * standard_error) ** 2 + (LEAST * effects[near]) ** 2)
    varied = (("element size", h), ("growth", g), ("contact stiffness", B))
    return LoadExtrapolation(
        load=limits[best].reshape(shape),
        uncertainty=uncertainty.reshape(shape),
        error_order=combined[best][0],
        field_length=combined[best][1],
        misfit=float(misfit[best]),
        element_size_effect=effects[near].reshape(shape),
        contact_stiffness_effect=(B / stiff).reshape(shape),
        unvaried_options=tuple(name for name, x in varied if np.ptp(x) == 0.0),
    )


def _relative_element_errors_of_contacts(
    element_size: Array, growth: Array, semi_axis: Array, order: float, length: float
) -> Array:
    """Return the relative discretisation error e on each of m meshes at each of c contacts, (m, c).

    The error is that of `relative_element_error`. ``element_size``: element size at the contacts over the minor semi-axis
    of a contact with mean load (m,); ``growth``: growth of the element size per distance from the contacts (m,);
    ``semi_axis``: minor semi-axis of each contact over that at mean load (c,); ``order``: order p with which the error
    decreases; ``length``: length over which the elastic field of a contact changes, over its minor semi-axis.
    """
    size = element_size[:, None] / (length * semi_axis)
    return relative_element_error(size, np.broadcast_to(growth[:, None], size.shape), order)


#: Largest allowed difference of a contact load between both programs [% of the mean load].
TARGET = 0.5

#: Columns that name a contact, each with its key in the rows of `compare_contact_loads`.
PLACE: dict[ColumnKey, str] = {"ball": "ball", "flank": "side"}

#: Columns that compare a contact's load: finest level of the 3D reference, and extrapolated load of CalculiX.
COLUMNS: dict[ColumnKey, str] = {
    **PLACE,
    ("load_by", "the 3D reference"): "ours",
    ("load_uncertainty_by", "the 3D reference"): "ours_percent",
    ("load_by", "CalculiX"): "theirs",
    ("load_uncertainty_by", "CalculiX"): "theirs_percent",
    "reference_minus_calculix": "difference",
}


def runs_with_common_contact_stiffness(data: CalculixRunsOfScene) -> list[CalculixRun]:
    """Return the CalculiX solutions without geometric nonlinearity that have their most frequent contact stiffness.

    The solutions are sorted by number of nodes, fewest first.
    """
    linear = [r for r in data.runs if not r.nlgeom]
    alike = [sum(r.stiffness == one.stiffness for r in linear) for one in linear]
    most = linear[int(np.argmax(alike))].stiffness
    return sorted((r for r in linear if r.stiffness == most), key=lambda r: r.nodes)


def deck_label(run: CalculixRun) -> str:
    """Return a short label of the mesh of a CalculiX solution, such as "b/h 0.8, g 0.6, half".

    It gives the number of elements along the minor semi-axis of a contact (b/h), the growth of the element size (g),
    whether only the half y >= 0 was meshed, and whether all balls have the same mesh.
    """
    return f"b/h {run.b_over_h:g}, g {run.growth:g}" + ", half" * run.half + ", equal balls" * run.alike


def compare_contact_loads(
    data: CalculixRunsOfScene, reference: Reference, extrapolation: LoadExtrapolation | None = None
) -> list[Row]:
    """Compare 3D reference and CalculiX at each contact that carries load in one of them; return one row for each contact.

    A row has ball (from 1) and flank, the load on every mesh of both programs by the name of the mesh, and the values of
    `COLUMNS`: loads by the 3D reference on its finest level ("ours") and by CalculiX, extrapolated ("theirs") [N], their
    uncertainties and the difference of both programs [% of the mean load of the 3D reference].

    ``data``: solutions by CalculiX; ``reference``: the 3D reference; ``extrapolation``: extrapolated loads of CalculiX,
    None to compute them.
    """
    extrapolation = extrapolation or extrapolate_calculix_loads(data.runs)
    mean, loads = reference.mean, {f"level {r.level}": r.load for r in reference.runs}
    loads |= {deck_label(r): r.load for r in runs_with_common_contact_stiffness(data)}
    loads |= {
        "ours": reference.load,
        "ours_percent": error_percent(reference.uncertainty, 0.0, mean),
        "theirs": extrapolation.load,
        "theirs_percent": error_percent(extrapolation.uncertainty, 0.0, mean),
        "difference": error_percent(reference.load, extrapolation.load, mean),
    }
    loaded = np.nonzero((reference.load > 0.0) | (extrapolation.load > 1e-3 * mean))
    return [
        {"ball": str(i + 1), "side": SIDES[s], **{name: float(of[i, s]) for name, of in loads.items()}}
        for i, s in zip(*loaded, strict=True)
    ]


def columns_of_contact_load_table(data: CalculixRunsOfScene, reference: Reference) -> dict[ColumnKey, str]:
    """Return the columns of the table of contact loads on every mesh of both programs, as `COLUMNS`.

    ``data``: solutions by CalculiX; ``reference``: the 3D reference with its solutions on several mesh levels.
    """
    columns = PLACE | {("load_by", f"the 3D reference, mesh level {r.level}"): f"level {r.level}" for r in reference.runs}
    decks = map(deck_label, runs_with_common_contact_stiffness(data))
    return columns | {("load_by", f"CalculiX, {label}"): label for label in decks}


def agreement_sentence(name: str, rows: Sequence[Row]) -> str:
    """Return a sentence on the largest and RMS difference of contact loads between the 3D reference and CalculiX.

    The sentence also says at how many contacts the difference exceeds the combined uncertainty of both programs.
    ``name``: name of the scene; ``rows``: comparison of each contact.
    """
    worst = max(rows, key=lambda r: abs(r["difference"]))
    rms = float(np.sqrt(np.mean([r["difference"] ** 2 for r in rows])))
    met = "within" if abs(worst["difference"]) <= TARGET else "NOT within"
    theirs = max(r["theirs_percent"] for r in rows)
    beyond = sum(abs(r["difference"]) > np.hypot(r["theirs_percent"], r["ours_percent"]) for r in rows)
    return (
        f"{name}: the 3D reference differs from CalculiX by at most {worst['difference']:+.2f} % of the mean load (ball "
        f"{worst['ball']} {worst['side']}; RMS {rms:.2f} %), {met} {TARGET} %; CalculiX's own uncertainty is up to "
        f"{theirs:.2f} %, and {beyond} of {len(rows)} contacts differ by more than both uncertainties."
    )
