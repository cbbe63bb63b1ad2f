"""Liu, sections 4.3 and 4.4: random errors, by the place of each printed number among drawn screws."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from rollbench.compare.cases.liu.evidence import case
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import Printed
from rollbench.lowfi.random_errors.chain import solve_chain
from rollbench.lowfi.random_errors.ensemble import Quantity, solve_ensemble
from rollbench.meshes.arrays import Array

RANGES = (1, 2, 3)
NAMES: dict[str, Quantity] = {
    "max": "largest",
    "min": "smallest",
    "loaded": "loaded",
    "unloaded": "loaded",
    "K": "stiffness",
}
#: A step of load over which (22) is compared with its tangent, as a share of the load.
STEP = 0.12
#: Printed sets of +-2 um, each a draw of its own.
SETS = "abc"


def sample_of(key: str) -> Array:
    """Sample behind an entry named quantity_range_load, in its printed unit."""
    name, which, load = key.removesuffix("_again").split("_")
    values = case.sample(2 if which in SETS else int(which), NAMES[name], float(load))
    if name == "unloaded":
        return case.balls() - values
    return 1e-8 * values if name == "K" else values


def fewer_given(half_range: int, at_500: int, at_1000: int) -> str:
    """How many balls are loaded at 1000 N where about as many as printed are at 500 N, in words."""
    first, then = (case.sample(half_range, "loaded", f) for f in (500.0, 1000.0))
    some = then[np.abs(first - at_500) <= 1]
    reached = int(np.count_nonzero(some <= at_1000))
    return f"of {some.size} screws with {at_500} ± 1 loaded at 500 N, {reached} have at most {at_1000} at 1000 N"


def placed(e: Sheet, key: str, *remarks: str) -> None:
    """File the median for a random number, and its percentile with its sampling error in words."""
    row = next(f.printed for f in e.evidence() if f.printed.key == key)
    values = sample_of(key)
    half = 0.0 if key.startswith(("loaded", "unloaded")) else row.tolerance
    words = case.place_in(values, e.printed(key), half)[1]
    e.number(key, float(np.median(values)), ". ".join((words, *remarks)))


def share(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[bool, str]:
    """Whether an event is likely enough, and its probability in words."""
    p = float(np.mean(mask))
    return p >= case.UNLIKELY, f"probability {p:.3f} ± {np.sqrt(p * (1.0 - p) / mask.size):.3f}"


def falling(quantity: Quantity, load: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether a quantity falls from range to range, screw i of each range beside the others'."""
    a, b, c = (case.sample(h, quantity, load) for h in RANGES)
    return np.asarray((a > b) & (b > c))


def section_4_3(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Section 4.3."""
    for row in (f.printed for f in e.evidence()):
        if row.value is not None:
            placed(e, row.key)
    for key, at_500, at_1000 in (
        ("unloaded_2_1000", 53, 62),
        ("unloaded_2_1000_again", 53, 61),
        ("unloaded_3_1000", 42, 43),
    ):
        placed(e, key, fewer_given(int(key.split("_")[1]), at_500, at_1000))
    every = [case.sample(h, "loaded", 2137.0) == case.balls() for h in RANGES]
    holds, words = share(np.logical_and.reduce(every))
    alone = ", ".join(f"{np.mean(m):.3f}" for m in every)
    e.claim("all_2137", holds, f"{words} (singly {alone})")
    e.claim("all_5000", *share(case.sample(2, "loaded", 5000.0) == case.balls()))
    e.claim("fewer", *share(falling("loaded", 100.0) & falling("loaded", 500.0)))
    width = {(h, f): case.sample(h, "largest", f) - case.sample(h, "smallest", f) for h in RANGES for f in (1000.0, 5000.0)}
    grows = [width[h, 5000.0] > width[h, 1000.0] for h in RANGES]
    grows += [width[h + 1, f] > width[h, f] for h in (1, 2) for f in (1000.0, 5000.0)]
    e.claim("wider", *share(np.logical_and.reduce(grows)))
    a, b, c = (case.sample(h, "displacement_first_loaded", 1000.0) for h in RANGES)
    e.claim("further", *share((a < b) & (b < c)))
    _curves(e)


def _curves(e: Sheet) -> None:
    """Claims on the curves of displacement over load, on medians."""
    loads = np.array(case.LOADS[1])
    curve = np.array([[np.median(case.sample(h, "displacement", f)) for f in loads] for h in RANGES])
    power = np.diff(np.log(curve[1])) / np.diff(np.log(loads))
    words = f"a power between {power.min():.2f} and {power.max():.2f} of the load: it grows ever more slowly"
    e.claim("exponential", bool(power.min() > 1.0), words)
    apart = 1e6 * np.diff(curve, axis=0)
    words = "; ".join(", ".join(f"{v:.2f}" for v in row) for row in apart) + " um from 100 to 5000 N (medians), "
    grown = " and ".join(f"{100.0 * (row[-1] / row[-2] - 1.0):.1f}" for row in apart)
    e.words("parallel", f"{words}by {grown} % still from 3000 to 5000 N")


def spreads(load: float) -> Array:
    """Range of the stiffness of three drawn screws of +-2 um [1e8 N/m]."""
    values = 1e-8 * case.sample(2, "stiffness", load)
    return np.asarray(np.ptp(values[: values.size // 3 * 3].reshape(-1, 3), axis=1))


def relative_to_none(key: str, printed: float, reference: float) -> str:
    """Percentile of a stiffness over that without errors: an offset of the contact stiffness drops out."""
    h, load = int(key.split("_")[1]), float(key.split("_")[2])
    ratio = case.sample(h, "stiffness", load) / solve_chain(case.screw(), np.zeros(case.balls()), load).stiffness
    return "over the value without errors: " + case.place_in(ratio, printed / reference, 0.0)[1]


def secant(load: float, step: float) -> float:
    """Stiffness (22) without errors [1e8 N/m] from a load on, by a step of load [N]; 0: the tangent."""
    chain, zero = case.screw(), np.zeros(case.balls())
    if step == 0.0:
        return 1e-8 * solve_chain(chain, zero, load).stiffness
    moved = [solve_chain(chain, zero, f).displacement for f in (load, load + step)]
    return 1e-8 * step / (moved[1] - moved[0])


@cache
def secants(half_range_um: int, load: float, share: float) -> Array:
    """The same of drawn screws, by a step that is a share of the load."""
    if share == 0.0:
        return 1e-8 * case.sample(half_range_um, "stiffness", load)
    ends = [load, (1.0 + share) * load]
    found = solve_ensemble(case.screw(), 1e-6 * half_range_um, ends, case.MEMBERS, seed=case.SEED + half_range_um)
    first, last = (found.of("displacement", f) for f in ends)
    return np.asarray(1e-8 * share * load / (last - first))


def stiffness_comes_out(row: Printed, share: float) -> bool:
    """Whether a printed stiffness is among those of the drawn screws by a step that is a share of the load; without errors:
    within the per cent to which the model has the source's other results."""
    _, which, load = row.key.split("_")
    assert row.value is not None
    if which == "0":
        return abs(row.value / secant(float(load), share * float(load)) - 1.0) <= 0.01
    values = secants(2 if which in SETS else int(which), float(load), share)
    return bool(values.min() - row.tolerance <= row.value <= values.max() + row.tolerance)


def by_step(rows: Sequence[Printed]) -> str:
    """How many printed stiffnesses come out with the tangent, and by a step of load, in words."""
    counts = [sum(stiffness_comes_out(row, share) for row in rows) for share in (0.0, STEP)]
    return (
        f"the step of load of (22) is not printed: of {len(rows)} stiffnesses {counts[0]} come out with the tangent and "
        f"{counts[1]} by a step of {100.0 * STEP:g} % of the load"
    )


def section_4_4(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Section 4.4."""
    bare, printed_K = e.printed("K_0_3000"), [f.printed for f in e.evidence() if f.printed.key.startswith("K_")]
    for row in printed_K:
        if row.value is not None and row.key != "K_0_3000":
            near = row.key.endswith("_3000")
            placed(e, row.key, *((relative_to_none(row.key, row.value, bare),) if near else ()))
    other = {
        law: 1e-8 * solve_chain(case.screw(law), np.zeros(case.balls()), 3000.0).stiffness for law in ("exact", "constant")
    }
    words = "; ".join(f"{law} contact angle {value:.3f}" for law, value in other.items())
    words = (
        f"{words}; by a step of {100.0 * STEP:g} % of the load {secant(3000.0, STEP * 3000.0):.3f}; {by_step(printed_K)}"
    )
    e.number("K_0_3000", secant(3000.0, 0.0), words)
    for load in (100, 1100, 2100):
        printed = [e.printed(f"K_{s}_{load}") for s in SETS]
        _, words = case.place_in(spreads(float(load)), max(printed) - min(printed), 0.0005)
        e.number(f"spread_{load}", max(printed) - min(printed), words.replace("screws", "triples"))
    low = min(e.printed(f"K_{s}_1100") for s in SETS)
    e.number("spread_percent", 100.0 * e.printed("spread_1100") / low)
    _claims(e)


def _claims(e: Sheet) -> None:
    """Claims of section 4.4."""
    s = {load: spreads(load) for load in (100.0, 1100.0, 2100.0)}
    e.claim("largest_1100", *share((s[1100.0] > s[100.0]) & (s[1100.0] > s[2100.0])))
    percent = 100.0 * s[100.0] / (1e-8 * np.median(case.sample(2, "stiffness", 100.0)))
    median, printed = np.median(percent), 100.0 * e.printed("spread_100") / e.printed("K_a_100")
    e.claim(
        "minimal",
        bool(median <= 4.31),
        f"three draws differ by {median:.0f} % at 100 N in the median; its own by {printed:.1f} %",
    )
    rises = [np.diff(np.stack([case.sample(h, "stiffness", f) for f in case.LOADS[h]]), axis=0) > 0.0 for h in RANGES]
    e.claim(
        "rises",
        all(bool(r.all()) for r in rises),
        f"in all of {3 * case.MEMBERS} drawn screws, {case.LOADS[1][0]:.0f} to 5000 N",
    )
    e.claim("softer", *share(falling("stiffness", 500.0)))
    free = solve_chain(case.screw(), np.zeros(case.balls()), 3000.0).stiffness
    off = [100.0 * (np.median(case.sample(h, "stiffness", 3000.0)) / free - 1.0) for h in RANGES]
    e.words("meet", ", ".join(f"{x:.1f}" for x in off) + " % in the median of drawn screws")
