"""Judge loads of another program, here 8 % too large on one ball: ``python -m compare.examples.judge_a_spreadsheet``."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import rollbench


def main(factor: float = 1.08) -> rollbench.Verdict:
    """Write contact loads as a spreadsheet would, and judge them against the 3D reference that rollbench includes.

    ``factor``: factor on the loads of ball 5, so that they are wrong. Returns the verdict, which is also printed.
    """
    load = rollbench.solve("lin-case1").loads
    assert load is not None, "the scene converges"
    load[4] *= factor
    with TemporaryDirectory() as folder:
        path = Path(folder) / "colleague.csv"
        rows = [f"{i + 1},{side},{load[i, s]:.3f}" for i in range(len(load)) for s, side in ((0, "SL"), (3, "NR"))]
        path.write_text("\n".join(["ball,flank,newton", *rows]), encoding="utf-8")
        judged = rollbench.check("lin-case1", loads=path, max_error=7, compute=False)
    print(judged)
    return judged


if __name__ == "__main__":
    main()
