"""Numpy arrays in annotations (shapes and units are given in docstrings), and records that have arrays as fields."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


class RecordWithArrays:
    """Base of frozen dataclasses with arrays: equal if all fields are, arrays if all elements are, with a hash to match.

    The methods that ``dataclass`` makes raise ValueError where two records have arrays of more than one element.
    """

    def __init_subclass__(cls) -> None:
        """Give each subclass both methods as its own, which ``dataclass`` then leaves as they are."""
        super().__init_subclass__()
        cls.__eq__, cls.__hash__ = RecordWithArrays.__eq__, RecordWithArrays.__hash__  # type: ignore[method-assign]

    def _compared_fields(self) -> list[Any]:
        """Return the values of the fields that are compared."""
        return [getattr(self, f.name) for f in fields(self) if f.compare]  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        """Return whether another record is of the same class and has equal fields."""
        if not isinstance(other, RecordWithArrays) or type(other) is not type(self):
            return NotImplemented
        pairs = zip(self._compared_fields(), other._compared_fields(), strict=True)
        return all(
            np.array_equal(a, b) if isinstance(a, np.ndarray) or isinstance(b, np.ndarray) else a == b for a, b in pairs
        )

    def __hash__(self) -> int:
        """Return a hash of the fields, of arrays the number of elements."""
        return hash(tuple(x.size if isinstance(x, np.ndarray) else x for x in self._compared_fields()))
