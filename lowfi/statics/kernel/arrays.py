"""Types of the kernels' arguments."""

from typing import Any

from numpy.typing import NDArray

#: Array of floats (masks and node numbers are passed the same way).
Array = NDArray[Any]
#: Tuple of arrays: beam (lengths, sections, fixed, load), state (q, d, p, contact), or outputs.
Arrays = tuple[Array, ...]
#: (node, B, geometry, closure, r_ball, profile, tiny): arrays and one number.
Contacts = Any
