"""Names of the bodies under rolling contacts: half spaces, or finite ones."""

from __future__ import annotations

HALF_SPACE, FINITE = "half-space", "finite"
