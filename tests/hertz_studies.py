"""Studies of Hertz's contacts on blocks, shared by the tests of one group: each is made once."""

from functools import cache

from rollbench.hifi.contact.block import SIZE, HertzJob, HertzRun
from rollbench.hifi.contact.block import study as fresh

GROUP = "Hertz blocks"


def study(
    job: HertzJob, element: str, b_over_h: float, *, size: float = SIZE, far_field: bool = True, aim: float = 1.0
) -> HertzRun:
    """`hifi.contact.block.study`."""
    return _made(job, element, b_over_h, size, far_field, aim)


@cache
def _made(job: HertzJob, element: str, b_over_h: float, size: float, far_field: bool, aim: float) -> HertzRun:
    return fresh(job, element, b_over_h, size=size, far_field=far_field, aim=aim)
