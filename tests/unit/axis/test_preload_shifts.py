"""Shifts that preload an assembly are the same from disk as computed, also where preloads are not reached."""

import pytest

from rollbench.lowfi.statics.axis.mount import PreloadShifts
from rollbench.lowfi.statics.result import Status
from rollbench.meshes.cache import record_from_bytes, record_to_bytes

FOUND = [
    PreloadShifts((1.0 / 3.0 * 1e-6, -2.7e-9), ("preload by force: ...",)),
    PreloadShifts((), (), ("not held", "preloads by force are not met at mounting", "mounting")),
]


@pytest.mark.parametrize("found", FOUND)
def test_shifts_from_disk_are_those_computed(found):
    again = record_from_bytes(record_to_bytes(found), "rollbench.lowfi")
    assert again == found
    if again.failure:
        assert Status(*again.failure).cause == "mounting"
