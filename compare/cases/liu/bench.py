"""Run times of screws with random errors: a drawn screw in an ensemble, against the source's elimination."""

from __future__ import annotations

from collections.abc import Iterator

from rollbench.compare.cases.liu.evidence import case
from rollbench.compare.wings.bench.costs.timing import Job, timed
from rollbench.lowfi.random_errors.chain import LAWS, Chain
from rollbench.lowfi.random_errors.elimination import solve_by_elimination
from rollbench.lowfi.random_errors.ensemble import draw_errors, solve_ensemble
from rollbench.meshes.memory import peak_MB

#: Screws of an ensemble; screws that the elimination is timed on; load [N]; half range of the errors [m].
MEMBERS, FEW, LOAD, HALF_RANGE = 20000, 4, 1000.0, 2e-6
#: Screws a second on one core that are aimed at.
TARGET = 20000


def jobs(repeats: int = 5) -> Iterator[Job]:
    """One job a reading of the contact angle; one core, compiled, with drawing. repeats 1: a tenth of the screws.

    Raises RuntimeError where a screw does not converge.
    """
    count = MEMBERS if repeats > 1 else MEMBERS // 10
    errors = draw_errors(case.SEED, 0, FEW, case.balls(), HALF_RANGE)
    for law in LAWS:
        chain = case.screw(law)
        if solve_ensemble(chain, HALF_RANGE, [LOAD], count).failed:
            raise RuntimeError(f"bench: a drawn screw did not converge, {law} contact angle")

        def eliminate(chain: Chain = chain) -> None:
            for e in errors:
                solve_by_elimination(chain, e, LOAD)

        def ensemble(chain: Chain = chain) -> None:
            solve_ensemble(chain, HALF_RANGE, [LOAD], count)

        slow = timed(eliminate, repeats) / FEW
        fast = timed(ensemble, repeats) / count
        note = (
            f"per screw of {count}, {case.balls()} balls, ±2 um, {LOAD:g} N, drawing included: {1.0 / fast:,.0f} a second "
        )
        note += f"(aim {TARGET:,}); ratio: the source's elimination, interpreted, dense equations"
        yield Job(f"random errors, {law} contact angle", fast, slow / fast, case.balls(), peak_MB(), note)
