"""Types of the kernels' arguments."""

from typing import Any

from numpy.typing import NDArray

#: Array of floats (masks are passed the same way).
Array = NDArray[Any]
